//! Budgets of the program: what ends the work, what is told of it, and work kept in a file.

mod support;

use std::{
    fs,
    process::{Command, Output},
};
use support::{err, folder};
use tempfile::TempDir;

fn command(folder: &TempDir, words: &[&str]) -> Command {
    let mut command = support::command(folder, &["render", "--size", "48x32"]);
    command.args(words);
    command
}

fn render(folder: &TempDir, words: &[&str]) -> Output {
    command(folder, words).output().unwrap()
}

/// All that it told.
fn out(output: &Output) -> String {
    support::out(output) + &err(output)
}

fn summary(output: &Output) -> serde_json::Value {
    serde_json::from_str(support::out(output).lines().last().unwrap()).unwrap()
}

#[test]
fn by_default_it_ends_at_the_error_that_is_hardly_seen() {
    let dir = folder();
    let output = render(&dir, &["--json"]);
    assert_eq!(output.status.code(), Some(0), "{}", out(&output));
    let facts = summary(&output);
    assert_eq!(
        (facts["ended"].as_str(), facts["settings"]["method"].as_str()),
        (Some("error"), Some("hybrid"))
    );
    assert!(
        facts["expected_rmse"].as_f64().unwrap() <= 0.02 && facts["target_error"].as_f64().unwrap() > 0.0199
    );
    assert!(facts["plan"]["rounds"].as_array().is_some_and(|rounds| !rounds.is_empty()));
}

#[test]
fn an_error_that_is_missed_is_told_and_fails_only_when_strict() {
    for (strict, code) in [(false, 0), (true, 1)] {
        let dir = folder();
        let mut words = vec!["--error", "0.0001", "--rays", "4"];
        words.extend(strict.then_some("--strict"));
        let output = render(&dir, &words);
        assert_eq!(output.status.code(), Some(code), "{}", out(&output));
        assert!(out(&output).contains("not 0.0001: all rays of the budget were traced"), "{}", out(&output));
        assert!(dir.path().join("ao.png").exists(), "what was reached is written");
    }
    let dir = folder();
    assert_eq!(render(&dir, &["--error", "0.3", "--strict"]).status.code(), Some(0), "reached is no failure");
}

#[test]
fn explaining_tells_costs_choices_rounds_and_the_end() {
    let dir = folder();
    let output = render(&dir, &["--explain", "--error", "0.05", "--time", "100s"]);
    assert_eq!(output.status.code(), Some(0), "{}", out(&output));
    for fragment in [
        "budget: 100 s or an expected error of 0.05",
        "settings other than the defaults: --time 100 --error 0.05",
        "a ray ",
        "a weighing ",
        "in bundles of 16",
        "cones: left out",
        "round 1: ",
        "end: the error was reached",
    ] {
        assert!(out(&output).contains(fragment), "{fragment}: {}", out(&output));
    }
    let output = render(&dir, &["--explain", "--method", "cones", "--voxels", "32"]);
    assert!(out(&output).contains("method cones does one fixed amount"), "{}", out(&output));
}

#[cfg(unix)]
#[test]
fn interrupted_work_is_kept_and_ends_in_the_same_bytes() {
    let (dir, whole) = (folder(), folder());
    // So many that it takes seconds, and yet ends.
    let words = ["atrium", "--rays", "2048", "--state", "work", "-o", "a.exr", "--json"];
    assert_eq!(render(&whole, &words).status.code(), Some(0));
    let output = support::interrupted(command(&dir, &words), "\"progress\"");
    assert_eq!(output.status.code(), Some(1), "{}", out(&output));
    assert!(dir.path().join("work").exists() && dir.path().join("a.exr").exists());
    let read = |dir: &TempDir| fs::read(dir.path().join("a.exr")).unwrap();
    assert!(read(&dir) != read(&whole), "it was interrupted before the end");
    assert_eq!(render(&dir, &words).status.code(), Some(0));
    assert!(read(&dir) == read(&whole));
}

#[test]
fn kept_work_that_does_not_fit_is_refused() {
    let dir = folder();
    let words = ["--rays", "4", "--state", "work"];
    assert_eq!(render(&dir, &words).status.code(), Some(0));
    let output = render(&dir, &["--rays", "4", "--state", "work", "--seed", "3"]);
    assert_eq!(output.status.code(), Some(2), "{}", out(&output));
    assert!(out(&output).contains("--state work") && out(&output).contains("--seed"), "{}", out(&output));
    let kept = fs::read(dir.path().join("work")).unwrap();
    fs::write(dir.path().join("work"), &kept[..kept.len() / 2]).unwrap();
    let output = render(&dir, &words);
    assert_eq!(output.status.code(), Some(3), "{}", out(&output));
    assert!(out(&output).contains("work: its checksum"), "{}", out(&output));
}

#[test]
fn points_without_neighbours_keep_budgets_too() {
    let dir = folder();
    let points = "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\nproperty float z\n\
        property float nx\nproperty float ny\nproperty float nz\nend_header\n0.1 0 0.1 0 1 0\n";
    fs::write(dir.path().join("in.ply"), points).unwrap();
    let words = ["sample", "cornell", "--points", "in.ply", "-o", "out.ply", "--explain"];
    let output = support::command(&dir, &words).output().unwrap();
    assert_eq!(output.status.code(), Some(0), "{}", out(&output));
    assert!(out(&output).contains("end: the error was reached"), "{}", out(&output));
}
