//! `conray study` tested as a program.

mod support;

use serde_json::Value;
use std::{
    fs,
    path::Path,
    process::{Command, Output, Stdio},
    time::{Duration, Instant},
};
use support::{err, folder, out};
use tempfile::TempDir;

/// A study small enough for a test, its truths kept in the folder.
const SMALL: [&str; 14] = [
    "--size",
    "40x40",
    "--voxels",
    "64",
    "--budgets",
    "1,4,16",
    "--truth-rays",
    "256",
    "--truth-error",
    "0.01",
    "--repeats",
    "2",
    "--cache",
    "truths",
];

fn study(folder: &TempDir, words: &[&str]) -> Output {
    command(folder, words).output().unwrap()
}

fn command(folder: &TempDir, words: &[&str]) -> Command {
    let mut command = support::command(folder, &["study"]);
    command.args(words).args(SMALL);
    command
}

/// The report without what depends on the clock.
fn timeless(path: &Path) -> Value {
    fn strip(value: &mut Value) {
        match value {
            Value::Object(members) => {
                members.remove("timing");
                members.values_mut().for_each(strip);
            }
            Value::Array(items) => items.iter_mut().for_each(strip),
            _ => {}
        }
    }
    let mut report: Value = serde_json::from_slice(&fs::read(path).unwrap()).unwrap();
    strip(&mut report);
    report
}

#[test]
fn a_study_writes_its_report_and_says_the_same_again_but_for_times() {
    let dir = folder();
    let words = ["cornell", "--methods", "rays,rays-filtered,cones,paper,paper-tuned"];
    for name in ["r1", "r2"] {
        let output = study(&dir, &[&words[..], &["-o", name]].concat());
        assert_eq!(output.status.code(), Some(0), "{}", err(&output));
        let text = out(&output);
        assert!(text.contains("cornell-front") && text.contains("report.html"), "{text}");
        for file in ["report.html", "report.json", "curves.csv", "pictures/cornell-front-truth.png"] {
            assert!(dir.path().join(name).join(file).exists(), "{name}/{file}");
        }
        assert!(!dir.path().join(name).join("unfinished").exists());
    }
    let (first, second) = (dir.path().join("r1/report.json"), dir.path().join("r2/report.json"));
    assert_eq!(timeless(&first), timeless(&second));
    assert_ne!(
        fs::read(&first).unwrap(),
        fs::read(&second).unwrap(),
        "times differ, or nothing was measured"
    );
    assert_eq!(fs::read_dir(dir.path().join("truths")).unwrap().count(), 1, "the truth is reused");

    let report = timeless(&first);
    let case = &report["cases"][0];
    let trials = case["trials"].as_array().unwrap();
    // Three budgets for rays, filtered and tuned; four sets of cones; one frame of the blend.
    assert_eq!(trials.len(), 3 * 3 + 4 + 1);
    let rmse = |method: &str, effort: u64| {
        trials.iter().find(|t| t["method"] == method && t["effort"] == effort).unwrap()["quality"]["rmse"]
            .as_f64()
            .unwrap()
    };
    assert!(rmse("rays", 16) < 0.5 * rmse("rays", 1));
    assert!(rmse("rays-filtered", 1) < rmse("rays", 1));
    assert!(rmse("paper", 1) < rmse("cones", 16));
    assert!(rmse("paper-tuned", 16) <= 1.2 * rmse("paper", 1), "at its best it is not worse");
    let shares: f64 =
        case["cones"]["classes"].as_array().unwrap().iter().map(|c| c["share"].as_f64().unwrap()).sum();
    assert!((shares - 1.0).abs() < 1e-9);
    assert!(case["truth"]["error"].as_f64().unwrap() < 0.02);

    // Another seed is another study.
    let output = study(&dir, &[&words[..], &["-o", "r3", "--seed", "5"]].concat());
    assert_eq!(output.status.code(), Some(0), "{}", err(&output));
    assert_ne!(timeless(&dir.path().join("r3/report.json"))["cases"][0]["trials"], case["trials"]);
}

#[test]
fn wrong_requests_exit_with_2_before_any_work() {
    let dir = folder();
    let cases: [(&[&str], &str); 9] = [
        (&["--methods", "rays,magic"], "magic"),
        (&["--methods", "rays,rays"], "rays"),
        (&["--view", "nowhere"], "nowhere"),
        (&["--budgets", "4,2"], "--budgets"),
        (&["--budgets", "0"], "--budgets"),
        (&["--repeats", "0"], "--repeats"),
        (&["--truth-error", "0"], "--truth-error"),
        (&["cornell", "atrium", "--eye=0,0,0", "--look-at=0,0,1"], "one scene"),
        (&["cornell", "--eye=0,50,0", "--look-at=60,100,9"], "shows nothing"),
    ];
    for (words, expected) in cases {
        // Later options win, so the small study's own do not hide these.
        let output = Command::new(env!("CARGO_BIN_EXE_conray"))
            .current_dir(dir.path())
            .arg("study")
            .args(["-o", "r", "--cache", "truths"])
            .args(words)
            .output()
            .unwrap();
        assert_eq!(output.status.code(), Some(2), "{words:?}: {}", err(&output));
        assert!(err(&output).contains(expected), "{words:?}: {}", err(&output));
        assert!(!dir.path().join("r/report.json").exists());
    }
}

#[test]
fn unusable_inputs_and_folders_name_themselves() {
    let dir = folder();
    let output = study(&dir, &["no-such-scene", "-o", "r"]);
    assert_eq!(output.status.code(), Some(3), "{}", err(&output));
    assert!(err(&output).contains("no-such-scene"));
    fs::write(dir.path().join("file"), "a file, not a folder").unwrap();
    let output = study(&dir, &["cornell", "-o", "file"]);
    assert_eq!(output.status.code(), Some(1), "{}", err(&output));
    assert!(err(&output).contains("file"), "{}", err(&output));
    assert_eq!(fs::read_to_string(dir.path().join("file")).unwrap(), "a file, not a folder");
}

#[test]
fn a_damaged_truth_is_named_and_the_earlier_report_stays() {
    let dir = folder();
    let words = ["cornell", "--methods", "rays", "-o", "r"];
    assert_eq!(study(&dir, &words).status.code(), Some(0));
    let report = fs::read(dir.path().join("r/report.json")).unwrap();
    let truth = fs::read_dir(dir.path().join("truths")).unwrap().next().unwrap().unwrap().path();
    let mut bytes = fs::read(&truth).unwrap();
    let middle = bytes.len() / 2;
    bytes[middle] ^= 1;
    fs::write(&truth, bytes).unwrap();
    let output = study(&dir, &words);
    assert_eq!(output.status.code(), Some(3), "{}", err(&output));
    assert!(err(&output).contains(&*truth.file_name().unwrap().to_string_lossy()), "{}", err(&output));
    assert_eq!(fs::read(dir.path().join("r/report.json")).unwrap(), report);
}

#[test]
#[cfg(unix)]
fn an_interrupted_study_goes_on_and_ends_as_an_unbroken_one() {
    let dir = folder();
    let words = ["cornell", "--methods", "rays,cones,paper", "-o"];
    let unbroken = study(&dir, &[&words[..], &["whole"]].concat());
    assert_eq!(unbroken.status.code(), Some(0), "{}", err(&unbroken));

    let mut child = command(&dir, &[&words[..], &["broken"]].concat())
        .stdout(Stdio::null())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    // Once a first trial is kept there is something to go on from.
    let unfinished = dir.path().join("broken/unfinished");
    let start = Instant::now();
    let kept = |folder: &Path| fs::read_dir(folder).map_or(0, Iterator::count);
    while kept(&unfinished) < 3
        && child.try_wait().unwrap().is_none()
        && start.elapsed() < Duration::from_secs(120)
    {
        std::thread::sleep(Duration::from_millis(2));
    }
    support::press_ctrl_c(&child);
    let broken = child.wait_with_output().unwrap();
    assert_eq!(broken.status.code(), Some(1), "{}", err(&broken));
    assert!(err(&broken).contains("interrupted"), "{}", err(&broken));
    assert!(!dir.path().join("broken/report.json").exists());
    let trials_before = kept(&unfinished);
    assert!(trials_before >= 3);

    let resumed = study(&dir, &[&words[..], &["broken"]].concat());
    assert_eq!(resumed.status.code(), Some(0), "{}", err(&resumed));
    assert_eq!(
        timeless(&dir.path().join("broken/report.json")),
        timeless(&dir.path().join("whole/report.json"))
    );
    assert!(!unfinished.exists());
}
