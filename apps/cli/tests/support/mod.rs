//! What the tests of the program share.
#![allow(dead_code, reason = "each test file uses a part of this")]

use std::{
    fs,
    path::Path,
    process::{Child, Command, Output},
};
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

/// A binary glTF of one triangle, with UVs or without.
pub(crate) fn glb(folder: &Path, name: &str, attributes: &str) {
    let numbers: [f32; 15] = [0., 0., 0., 1., 0., 0., 0., 1., 0., 0.1, 0.1, 0.9, 0.1, 0.1, 0.9];
    let bin: Vec<u8> = numbers.iter().flat_map(|x| x.to_le_bytes()).collect();
    let json = format!(
        r#"{{"asset":{{"version":"2.0"}},"scenes":[{{"nodes":[0]}}],"nodes":[{{"mesh":0,"name":"sail"}}],
        "meshes":[{{"primitives":[{{"attributes":{{"POSITION":0{attributes}}}}}]}}],"extras":{{"kept":1e-3}},
        "buffers":[{{"byteLength":60}}],"bufferViews":[{{"buffer":0,"byteLength":36}},{{"buffer":0,"byteOffset":36,"byteLength":24}}],
        "accessors":[{{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3","min":[0,0,0],"max":[1,1,0]}},
        {{"bufferView":1,"componentType":5126,"count":3,"type":"VEC2"}}]}}"#
    );
    let json = format!("{json:<width$}", width = json.len().next_multiple_of(4));
    let mut file = b"glTF\x02\0\0\0".to_vec();
    file.extend(((12 + 8 + json.len() + 8 + bin.len()) as u32).to_le_bytes());
    for (kind, chunk) in [(b"JSON", json.as_bytes()), (b"BIN\0", &bin[..])] {
        file.extend((chunk.len() as u32).to_le_bytes());
        file.extend(kind);
        file.extend(chunk);
    }
    fs::write(folder.join(name), file).unwrap();
}

/// `conray bake` with these words, in a folder.
pub(crate) fn bake(folder: &TempDir, words: &[&str]) -> Output {
    command(folder, &["bake"]).args(words).output().unwrap()
}

/// A bake that is to be refused.
pub(crate) fn refused(folder: &TempDir, words: &[&str], code: i32, message: &str) {
    let output = bake(folder, words);
    assert_eq!(output.status.code(), Some(code), "{words:?}: {}{}", out(&output), err(&output));
    assert!(err(&output).contains(message), "{words:?}: {}", err(&output));
}
