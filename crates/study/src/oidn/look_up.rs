//! Where Open Image Denoise is looked for.

use super::Api;
use std::{
    env,
    ffi::OsStr,
    path::{Path, PathBuf},
};

/// Names of the library, as the system's loader knows them.
const NAMES: [&str; 5] = [
    "libOpenImageDenoise.so.2",
    "libOpenImageDenoise.so",
    "libOpenImageDenoise.2.dylib",
    "libOpenImageDenoise.dylib",
    "OpenImageDenoise.dll",
];

/// Names a file of the library; nothing else is then tried.
const VARIABLE: &str = "CONRAY_OIDN";

/// Where `bench/fetch-rivals` leaves the library, here or in a folder above.
const FOLDER: &str = "target/rivals/oidn/lib";

/// Looks in all those places.
pub(super) fn look_up() -> Result<Api, String> {
    let named = env::var_os(VARIABLE);
    first_fit(&candidates(named.as_deref()), named.as_deref())
}

/// What to open, best first.
fn candidates(named: Option<&OsStr>) -> Vec<PathBuf> {
    if let Some(file) = named {
        return vec![file.into()];
    }
    let here = env::current_dir().unwrap_or_default();
    let fetched = here.ancestors().flat_map(|folder| NAMES.map(|name| folder.join(FOLDER).join(name)));
    NAMES.iter().map(PathBuf::from).chain(fetched.filter(|file| file.exists())).collect()
}

/// The first library that can be used; else what was wrong with the first that was there, or that none was.
pub(super) fn first_fit(candidates: &[PathBuf], named: Option<&OsStr>) -> Result<Api, String> {
    let mut problems = Vec::new();
    for file in candidates {
        match Api::open(file) {
            Ok(Some(api)) => return Ok(api),
            Ok(None) => {}
            Err(problem) => problems.push(problem),
        }
    }
    Err(match (problems.into_iter().next(), named) {
        (Some(problem), _) => format!("Open Image Denoise cannot be used: {problem}"),
        (None, Some(file)) => {
            let file = Path::new(&file).display();
            format!("Open Image Denoise was not found: {VARIABLE} names {file}, and there is no such library")
        }
        (None, None) => format!(
            "Open Image Denoise was not found: looked for {} among the system's libraries and in {FOLDER}; get it with \
             bench/fetch-rivals, or name its file in {VARIABLE}",
            NAMES[if cfg!(windows) {
                4
            } else if cfg!(target_os = "macos") {
                3
            } else {
                0
            }]
        ),
    })
}
