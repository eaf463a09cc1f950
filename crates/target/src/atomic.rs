//! Files that appear whole or not at all.

use crate::TargetError;
use std::{
    ffi::OsString,
    fs::{self, File, OpenOptions},
    io::{self, BufWriter, Write},
    path::{Path, PathBuf},
    process,
    sync::atomic::{AtomicU64, Ordering},
};

/// How many temporary names are tried before giving up; a taken one is left from a process that was killed.
const NAME_ATTEMPTS: u32 = 1000;

/// Writes a file under a temporary name in the same folder, flushes it to the disk and renames it.
///
/// If anything fails, `write` included, the temporary file is removed and an earlier file of that name stays as it was.
/// An earlier file keeps its permissions; a symbolic link is followed; a device or pipe is written to directly, as it
/// cannot be replaced. Errors ([`TargetError::Output`]) name the path.
pub fn write_atomically(
    path: impl AsRef<Path>,
    write: impl FnOnce(&mut dyn Write) -> io::Result<()>,
) -> Result<(), TargetError> {
    let path = path.as_ref();
    let mut write = Some(write);
    let mut call_once = |w: &mut dyn Write| write.take().map_or(Ok(()), |f| f(w));
    write_through(path, &mut call_once).map_err(|source| TargetError::Output { path: path.into(), source })
}

/// Fails as [`write_atomically`] would before its first byte, leaving no file behind: for asking before long work.
pub fn check_writable(path: impl AsRef<Path>) -> Result<(), TargetError> {
    let path = path.as_ref();
    let check = || match destination(path)? {
        Destination::File { path, .. } => Temporary::beside(&path).map(drop),
        Destination::Device(path) => OpenOptions::new().write(true).open(path).map(drop),
    };
    check().map_err(|source| TargetError::Output { path: path.into(), source })
}

/// Not generic: compiled once, whatever is written.
fn write_through(path: &Path, write: &mut dyn FnMut(&mut dyn Write) -> io::Result<()>) -> io::Result<()> {
    match destination(path)? {
        Destination::File { path, permissions } => {
            let mut temporary = Temporary::beside(&path)?;
            write(&mut temporary.file)?;
            temporary.file.flush()?;
            if let Some(permissions) = permissions {
                fs::set_permissions(&temporary.path, permissions)?;
            }
            temporary.file.get_ref().sync_all()?;
            temporary.rename_to(&path)
        }
        Destination::Device(path) => {
            let mut device = BufWriter::new(OpenOptions::new().write(true).open(path)?);
            write(&mut device)?;
            device.flush()
        }
    }
}

/// Where the bytes really go.
enum Destination {
    /// A regular file, with the permissions of the earlier one.
    File { path: PathBuf, permissions: Option<fs::Permissions> },
    /// Something that must not be replaced, such as `/dev/null`.
    Device(PathBuf),
}

fn destination(path: &Path) -> io::Result<Destination> {
    if path.file_name().is_none() {
        return Err(io::Error::new(io::ErrorKind::InvalidInput, "it does not name a file"));
    }
    match fs::metadata(path) {
        Ok(m) if m.is_dir() => Err(io::ErrorKind::IsADirectory.into()),
        Ok(m) if m.permissions().readonly() => {
            Err(io::Error::new(io::ErrorKind::PermissionDenied, "it is read-only"))
        }
        Ok(m) if !m.is_file() => Ok(Destination::Device(path.into())),
        Ok(m) => Ok(Destination::File { path: path.canonicalize()?, permissions: Some(m.permissions()) }),
        Err(e) if e.kind() == io::ErrorKind::NotFound => {
            check_folder(folder_of(path))?;
            Ok(Destination::File { path: path.into(), permissions: None })
        }
        Err(e) => Err(e),
    }
}

fn folder_of(path: &Path) -> &Path {
    path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."))
}

fn check_folder(folder: &Path) -> io::Result<()> {
    let because = |kind, what: &str| io::Error::new(kind, format!("the folder {} {what}", folder.display()));
    match fs::metadata(folder) {
        Ok(m) if m.is_dir() => Ok(()),
        Ok(_) => Err(because(io::ErrorKind::NotADirectory, "is a file")),
        Err(e) if e.kind() == io::ErrorKind::NotFound => Err(because(e.kind(), "does not exist")),
        Err(e) => Err(e),
    }
}

/// An open file that is removed when dropped, unless it was renamed.
struct Temporary {
    path: PathBuf,
    file: BufWriter<File>,
    renamed: bool,
}

impl Temporary {
    fn beside(path: &Path) -> io::Result<Self> {
        static COUNTER: AtomicU64 = AtomicU64::new(0);
        let stem = path.file_name().unwrap_or_default();
        for _ in 0..NAME_ATTEMPTS {
            let mut name = OsString::from(".");
            name.push(stem);
            name.push(format!(".{}-{}.tmp", process::id(), COUNTER.fetch_add(1, Ordering::Relaxed)));
            let path = folder_of(path).join(name);
            match OpenOptions::new().write(true).create_new(true).open(&path) {
                Ok(file) => return Ok(Self { path, file: BufWriter::new(file), renamed: false }),
                Err(e) if e.kind() == io::ErrorKind::AlreadyExists => {}
                Err(e) => return Err(e),
            }
        }
        Err(io::Error::new(io::ErrorKind::AlreadyExists, "no temporary name is free"))
    }

    fn rename_to(mut self, path: &Path) -> io::Result<()> {
        fs::rename(&self.path, path)?;
        self.renamed = true;
        Ok(())
    }
}

impl Drop for Temporary {
    fn drop(&mut self) {
        if !self.renamed {
            // Nothing more can be done about a file that cannot be removed.
            let _ = fs::remove_file(&self.path);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::{fs, panic};

    fn names(folder: &Path) -> Vec<String> {
        let mut names: Vec<_> = (fs::read_dir(folder).unwrap())
            .map(|entry| entry.unwrap().file_name().into_string().unwrap())
            .collect();
        names.sort();
        names
    }

    #[test]
    fn files_appear_and_are_replaced() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.txt");
        for text in ["one", "second"] {
            check_writable(&path).unwrap();
            write_atomically(&path, |w| w.write_all(text.as_bytes())).unwrap();
            assert_eq!(fs::read_to_string(&path).unwrap(), text);
            assert_eq!(names(folder.path()), ["a.txt"]);
        }
    }

    #[test]
    fn a_failure_keeps_the_earlier_file() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.txt");
        fs::write(&path, "earlier").unwrap();
        let result = write_atomically(&path, |w| {
            w.write_all(&[b'x'; 100_000])?;
            // The temporary file is there, under another name, and the earlier one is untouched.
            assert_eq!(names(folder.path()).len(), 2);
            assert_eq!(fs::read_to_string(&path)?, "earlier");
            Err(io::Error::other("disc full"))
        });
        let message = result.unwrap_err().to_string();
        assert!(message.contains("a.txt") && message.contains("disc full"), "{message}");
        assert_eq!(fs::read_to_string(&path).unwrap(), "earlier");
        assert_eq!(names(folder.path()), ["a.txt"]);
    }

    #[test]
    fn a_panic_leaves_nothing_behind() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.txt");
        let run = panic::AssertUnwindSafe(|| write_atomically(&path, |_| panic!("on purpose")));
        assert!(panic::catch_unwind(run).is_err());
        assert!(names(folder.path()).is_empty());
    }

    #[test]
    fn unusable_paths_are_refused_by_reason_without_a_trace() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        fs::create_dir(at("folder")).unwrap();
        fs::write(at("file"), "kept").unwrap();
        fs::write(at("locked"), "kept").unwrap();
        let mut permissions = fs::metadata(at("locked")).unwrap().permissions();
        permissions.set_readonly(true);
        fs::set_permissions(at("locked"), permissions).unwrap();
        let before = names(folder.path());
        let cases = [
            (at("folder"), "directory"),
            (at("absent/a.png"), "does not exist"),
            (at("file/a.png"), ""),
            (at("locked"), "read-only"),
            (PathBuf::from("/"), "does not name a file"),
            (PathBuf::new(), "does not name a file"),
        ];
        for (path, reason) in cases {
            let errors = [
                check_writable(&path).unwrap_err(),
                write_atomically(&path, |_| panic!("nothing must be written")).unwrap_err(),
            ];
            for message in errors.map(|e| e.to_string()) {
                assert!(message.contains(reason), "{message} / {reason}");
                assert!(message.contains(&path.display().to_string()), "{message}");
            }
        }
        assert_eq!(names(folder.path()), before);
        assert_eq!(fs::read_to_string(at("locked")).unwrap(), "kept");
    }

    #[cfg(target_os = "linux")]
    #[test]
    fn folders_that_take_no_files_are_refused() {
        // Even the superuser cannot create files there.
        let error = check_writable("/proc/conray.png").unwrap_err();
        assert_eq!(error.fault(), crate::Fault::Output);
        assert!(error.to_string().contains("/proc/conray.png"));
    }

    #[cfg(unix)]
    #[test]
    fn devices_are_written_to_and_not_replaced() {
        check_writable("/dev/null").unwrap();
        write_atomically("/dev/null", |w| w.write_all(b"gone")).unwrap();
        assert!(!fs::metadata("/dev/null").unwrap().is_file());
    }

    #[cfg(unix)]
    #[test]
    fn links_are_followed_and_permissions_kept() {
        use std::os::unix::fs::{PermissionsExt, symlink};
        let folder = tempfile::tempdir().unwrap();
        let (real, link) = (folder.path().join("real"), folder.path().join("link"));
        fs::write(&real, "old").unwrap();
        fs::set_permissions(&real, fs::Permissions::from_mode(0o640)).unwrap();
        symlink(&real, &link).unwrap();
        write_atomically(&link, |w| w.write_all(b"new")).unwrap();
        assert_eq!(fs::read_to_string(&real).unwrap(), "new");
        assert!(fs::symlink_metadata(&link).unwrap().is_symlink());
        assert_eq!(fs::metadata(&real).unwrap().permissions().mode() & 0o777, 0o640);
    }

    #[test]
    fn many_threads_write_one_name_without_mixing() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.bin");
        std::thread::scope(|scope| {
            for byte in 0..4u8 {
                let path = &path;
                scope.spawn(move || write_atomically(path, |w| w.write_all(&[byte; 50_000])).unwrap());
            }
        });
        let bytes = fs::read(&path).unwrap();
        assert!(bytes.len() == 50_000 && bytes.iter().all(|&b| b == bytes[0]));
        assert_eq!(names(folder.path()), ["a.bin"]);
    }
}
