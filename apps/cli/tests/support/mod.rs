//! What the tests of the program share.
#![allow(dead_code, reason = "each test file uses a part of this")]

use std::process::{Child, Command, Output};
use tempfile::TempDir;

pub(crate) fn folder() -> TempDir {
    tempfile::tempdir().unwrap()
}

/// The program with these words, in a folder.
pub(crate) fn command(folder: &TempDir, words: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_conray"));
    command.current_dir(folder.path()).args(words);
    command
}

pub(crate) fn out(output: &Output) -> String {
    String::from_utf8_lossy(&output.stdout).into_owned()
}

pub(crate) fn err(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

#[cfg(unix)]
pub(crate) fn press_ctrl_c(child: &Child) {
    assert!(Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap().success());
}

/// Runs a command that prints JSON lines and presses Ctrl-C once a line tells `sign`.
#[cfg(unix)]
pub(crate) fn interrupted(mut command: Command, sign: &str) -> Output {
    use std::{
        io::{BufRead, BufReader, Read},
        process::Stdio,
    };
    let mut child = command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    let mut reader = BufReader::new(child.stdout.take().unwrap());
    let mut stdout = String::new();
    while !stdout.contains(sign) {
        assert!(reader.read_line(&mut stdout).unwrap() > 0, "ended without {sign}");
    }
    press_ctrl_c(&child);
    reader.read_to_string(&mut stdout).unwrap();
    Output { stdout: stdout.into_bytes(), ..child.wait_with_output().unwrap() }
}
