//! `conray view`: where the viewer is looked for, and that words and exit code pass.
#![cfg(unix)]

mod support;

use std::{fs, os::unix::fs::PermissionsExt, path::Path, process::Command};
use support::{err, folder, out};

/// A program that tells its words and ends with 3.
fn pretend_viewer(folder: &Path) {
    let path = folder.join("conray-viewer");
    fs::write(&path, "#!/bin/sh\necho \"viewer: $*\"\nexit 3\n").unwrap();
    fs::set_permissions(&path, fs::Permissions::from_mode(0o755)).unwrap();
}

/// The program, copied so that nothing is beside it.
fn lonely(folder: &Path) -> Command {
    let program = folder.join("conray");
    fs::copy(env!("CARGO_BIN_EXE_conray"), &program).unwrap();
    let mut command = Command::new(program);
    command.current_dir(folder).env("PATH", folder.join("path"));
    command
}

/// One test: programs are written and run, and a process that forks for another test meanwhile would keep a written file open.
#[test]
fn the_viewer_is_looked_for_and_gets_the_words() {
    without_the_viewer_it_says_how_to_build_it();
    words_and_exit_code_pass_to_the_viewer_beside_it_or_on_the_path();
}

fn without_the_viewer_it_says_how_to_build_it() {
    let dir = folder();
    let output = lonely(dir.path()).args(["view", "cornell"]).output().unwrap();
    assert_eq!(output.status.code(), Some(2), "{}", err(&output));
    assert!(err(&output).contains("cargo build --release -p conray-viewer"), "{}", err(&output));
    assert_eq!(err(&output).lines().count(), 1);
}

fn words_and_exit_code_pass_to_the_viewer_beside_it_or_on_the_path() {
    let dir = folder();
    let words = ["view", "model.glb", "--method", "rays", "--help", "--eye=-1,2,3"];
    fs::create_dir(dir.path().join("path")).unwrap();
    for place in ["path", "."] {
        pretend_viewer(&dir.path().join(place));
        let output = lonely(dir.path()).args(words).output().unwrap();
        assert_eq!(output.status.code(), Some(3), "{place}: {}", err(&output));
        assert_eq!(out(&output).trim(), "viewer: model.glb --method rays --help --eye=-1,2,3", "{place}");
        fs::remove_file(dir.path().join(place).join("conray-viewer")).unwrap();
    }
}
