//! The program tested as a program.

use std::process::Command;

#[test]
fn without_a_page_there_is_nothing_to_serve() {
    let dir = tempfile::tempdir().unwrap();
    let output = Command::new(env!("CARGO_BIN_EXE_conray-page"))
        .args(["--serve-only", "--port", "0", "--out"])
        .arg(dir.path())
        .output()
        .unwrap();
    assert_eq!(output.status.code(), Some(1));
    let told = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(told.contains("there is no page; build it first"), "{told}");
}
