//! Where the files that a scene refers to come from.

use super::error::Fault;
use std::fs::File;
use std::io::{self, Read};
use std::path::{Path, PathBuf};

/// Hands out the content of a file that a scene refers to by the name written in the scene.
///
/// A name is a relative path with either kind of slash; a missing file is [`io::ErrorKind::NotFound`].
pub type Resolver<'a> = dyn Fn(&str) -> io::Result<Vec<u8>> + 'a;

/// Reads a whole file of at most `max_bytes`.
pub(super) fn read_file(path: &Path, max_bytes: u64) -> Result<Vec<u8>, Fault> {
    let io_fault = |error: io::Error| match error.kind() {
        io::ErrorKind::NotFound => Fault::NotFound,
        _ => Fault::CannotRead(error),
    };
    let file = File::open(path).map_err(io_fault)?;
    let metadata = file.metadata().map_err(io_fault)?;
    // A device or a pipe has no length to check, and may never end.
    if !metadata.is_file() {
        let what = if metadata.is_dir() { "it is a folder" } else { "it is not a regular file" };
        return Err(Fault::CannotRead(io::Error::other(what)));
    }
    let too_big = |found| Fault::LimitExceeded { what: "bytes in the file", found, limit: max_bytes };
    if metadata.len() > max_bytes {
        return Err(too_big(metadata.len()));
    }
    let mut bytes = Vec::with_capacity(metadata.len() as usize);
    file.take(max_bytes.saturating_add(1)).read_to_end(&mut bytes).map_err(io_fault)?;
    if bytes.len() as u64 > max_bytes { Err(too_big(bytes.len() as u64)) } else { Ok(bytes) }
}

/// Finds a scene's files beside it.
///
/// Names in scenes often come from another computer: slashes of either kind, another case, a folder that is not here.
/// Tried in turn: the name as written, the name without regard to case, the bare file name in the scene's folder.
/// Relative names may climb with `..`; an absolute name is never opened, only its bare file name is tried.
pub(super) struct Folder {
    /// The scene's folder.
    pub root: PathBuf,
    /// Longest file that is read.
    pub max_bytes: u64,
}

impl Folder {
    /// Content of the file that the scene calls `reference`.
    pub(super) fn read(&self, reference: &str) -> io::Result<Vec<u8>> {
        let path = self.find(reference).ok_or(io::ErrorKind::NotFound)?;
        read_file(&path, self.max_bytes).map_err(|fault| match fault {
            Fault::CannotRead(error) => error,
            Fault::NotFound => io::ErrorKind::NotFound.into(),
            other => io::Error::other(other.to_string()),
        })
    }

    fn find(&self, reference: &str) -> Option<PathBuf> {
        let slashed = reference.replace('\\', "/");
        let absolute = slashed.starts_with('/') || slashed.as_bytes().get(1) == Some(&b':');
        let parts: Vec<&str> = slashed.split('/').filter(|part| !part.is_empty() && *part != ".").collect();
        let last = parts.last().copied().filter(|last| *last != "..")?;
        if !absolute {
            let exact = self.root.join(parts.iter().collect::<PathBuf>());
            if exact.is_file() {
                return Some(exact);
            }
            if let Some(found) = self.find_ignoring_case(&parts) {
                return Some(found);
            }
        }
        self.find_ignoring_case(&[last])
    }

    fn find_ignoring_case(&self, parts: &[&str]) -> Option<PathBuf> {
        let mut path = self.root.clone();
        for part in parts {
            let exact = path.join(part);
            if *part == ".." || exact.exists() {
                path = exact;
                continue;
            }
            let folder = if path.as_os_str().is_empty() { Path::new(".") } else { &path };
            let wanted = part.to_lowercase();
            // The least of several, so that the order in which the system lists them does not matter.
            let name = std::fs::read_dir(folder)
                .ok()?
                .filter_map(|entry| entry.ok()?.file_name().into_string().ok())
                .filter(|name| name.to_lowercase() == wanted)
                .min()?;
            path.push(name);
        }
        path.is_file().then_some(path)
    }
}

/// The scheme of a name that is a network address, such as `https`; `data` is none.
pub(super) fn network_scheme(reference: &str) -> Option<&str> {
    let (scheme, _) = reference.split_once("://")?;
    let plain = |c: char| c.is_ascii_alphanumeric() || "+-.".contains(c);
    (!scheme.is_empty() && scheme.chars().all(plain)).then_some(scheme)
}
