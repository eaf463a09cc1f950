//! `conray view`: hands over to the viewer, a program of its own so that the build of this one stays short.

use crate::{args::ViewArgs, failure::Failure};
use std::{
    env,
    ffi::OsString,
    io,
    path::PathBuf,
    process::{Command, ExitCode},
};

/// The viewer's program.
const VIEWER: &str = "conray-viewer";

/// Runs the viewer with the words that were given, and ends as it does.
pub(crate) fn run(args: &ViewArgs) -> Result<ExitCode, Failure> {
    let beside = env::current_exe().ok().and_then(|program| Some(program.parent()?.join(name())));
    let program = beside.filter(|path| path.is_file()).unwrap_or_else(|| PathBuf::from(name()));
    match Command::new(&program).args(&args.words).status() {
        Ok(status) => {
            Ok(status.code().map_or(ExitCode::FAILURE, |code| ExitCode::from(code.clamp(0, 255) as u8)))
        }
        Err(e) if e.kind() == io::ErrorKind::NotFound => Err(Failure::Request(format!(
            "view: there is no program {VIEWER} beside this one or on PATH; cargo build --release -p {VIEWER} makes it"
        ))),
        Err(e) => Err(Failure::Work(format!("view: {} cannot be run: {e}", program.display()))),
    }
}

fn name() -> OsString {
    format!("{VIEWER}{}", env::consts::EXE_SUFFIX).into()
}
