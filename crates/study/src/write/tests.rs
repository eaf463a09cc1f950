use super::*;
use crate::fixture;
use serde_json::Value;

/// Every file below a folder with its bytes.
fn contents(folder: &Path) -> BTreeMap<String, Vec<u8>> {
    let mut files = BTreeMap::new();
    let mut folders = vec![folder.to_path_buf()];
    while let Some(next) = folders.pop() {
        for entry in fs::read_dir(next).unwrap().map(Result::unwrap) {
            if entry.path().is_dir() {
                folders.push(entry.path());
            } else {
                let name = entry.path().strip_prefix(folder).unwrap().to_str().unwrap().replace('\\', "/");
                files.insert(name, fs::read(entry.path()).unwrap());
            }
        }
    }
    files
}

/// The same but for the last bits of numbers, which may be lost in reading.
fn equal(a: &Value, b: &Value) -> bool {
    match (a, b) {
        (Value::Number(a), Value::Number(b)) => match (a.as_f64(), b.as_f64()) {
            (Some(a), Some(b)) => (a - b).abs() <= 1e-14 * a.abs().max(b.abs()),
            _ => false,
        },
        (Value::Array(a), Value::Array(b)) => a.len() == b.len() && a.iter().zip(b).all(|(a, b)| equal(a, b)),
        (Value::Object(a), Value::Object(b)) => {
            a.len() == b.len() && a.iter().all(|(name, a)| b.get(name).is_some_and(|b| equal(a, b)))
        }
        _ => a == b,
    }
}

#[test]
fn a_report_is_written_whole_and_read_back() {
    let parent = tempfile::tempdir().unwrap();
    let folder = parent.path().join("new/deeper");
    let report = fixture::report();
    let pictures = fixture::pictures(&report);
    check_folder(&folder).unwrap();
    write_report(&folder, &report, &pictures).unwrap();
    let files = contents(&folder);
    assert_eq!(files.len(), pictures.len() + 3);
    assert!(pictures.iter().all(|(name, bytes)| files[name] == *bytes));
    let back: Report = serde_json::from_slice(&files["report.json"]).unwrap();
    let wanted = serde_json::to_value(&report).unwrap();
    let mut found = serde_json::to_value(&back).unwrap();
    assert!(equal(&found, &wanted));
    found["cases"][1]["trials"][3]["quality"]["bias"] = 0.5.into();
    assert!(!equal(&found, &wanted), "the negative control");
    assert!(files["report.html"].starts_with(b"<!doctype html>"));
    assert!(files["curves.csv"].starts_with(b"case,method,"));

    let mut other = report;
    other.version = "another".into();
    write_report(&folder, &other, &pictures).unwrap();
    let after = contents(&folder);
    assert_ne!(after["report.json"], files["report.json"], "a second report replaces the first");
    assert_eq!(after.len(), files.len());
}

#[test]
fn the_same_report_gives_the_same_bytes() {
    let report = fixture::report();
    let pictures = fixture::pictures(&report);
    let written = [0, 1].map(|_| {
        let folder = tempfile::tempdir().unwrap();
        write_report(folder.path(), &report, &pictures).unwrap();
        contents(folder.path())
    });
    assert!(written[0] == written[1]);
}

#[test]
fn a_report_that_cannot_be_written_harms_no_earlier_one() {
    let folder = tempfile::tempdir().unwrap();
    let report = fixture::report();
    let pictures = fixture::pictures(&report);
    write_report(folder.path(), &report, &pictures).unwrap();
    // The last file of all is in the way of the next report.
    fs::remove_file(folder.path().join("report.html")).unwrap();
    fs::create_dir(folder.path().join("report.html")).unwrap();
    let before = contents(folder.path());
    let mut other = report.clone();
    other.version = "another".into();
    other.cases[0].trials.truncate(3);
    for error in [write_report(folder.path(), &other, &pictures), check_folder(folder.path())] {
        let message = error.unwrap_err().to_string();
        assert!(message.contains("report.html") && message.contains("cannot be written"), "{message}");
    }
    assert!(contents(folder.path()) == before);

    fs::remove_dir(folder.path().join("report.html")).unwrap();
    let mut fewer = pictures.clone();
    let missing = fewer.pop_first().unwrap().0;
    let message = write_report(folder.path(), &report, &fewer).unwrap_err().to_string();
    assert!(message.contains(&missing), "{message}");
    assert!(contents(folder.path()) == before);
}

#[test]
fn a_folder_that_cannot_be_is_refused_by_name() {
    let parent = tempfile::tempdir().unwrap();
    let file = parent.path().join("file");
    fs::write(&file, "kept").unwrap();
    let report = fixture::report();
    for folder in [file.clone(), file.join("inside")] {
        for result in [check_folder(&folder), write_report(&folder, &report, &fixture::pictures(&report))] {
            let error = result.unwrap_err();
            assert!(matches!(&error, StudyError::Output { path, .. } if path.starts_with(&file)), "{error}");
        }
    }
    assert_eq!(fs::read_to_string(&file).unwrap(), "kept");
}

#[test]
fn checking_leaves_no_file_behind() {
    let folder = tempfile::tempdir().unwrap();
    check_folder(folder.path()).unwrap();
    assert!(contents(folder.path()).is_empty());
}

#[test]
fn no_picture_leads_out_of_the_folder() {
    for name in ["../x.png", "/x.png", "pictures/../../x.png", ""] {
        assert!(inside(name).is_err(), "{name}");
    }
    assert!(inside("pictures/x.png").is_ok());
}

fn kept_schema() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/report.schema.json")
}

#[test]
fn the_kept_schema_is_that_of_the_report() {
    let kept: Value = serde_json::from_slice(&fs::read(kept_schema()).unwrap()).unwrap();
    assert!(
        kept == schema(),
        "docs/report.schema.json is out of date: cargo run -p conray-study --example schema > docs/report.schema.json"
    );
}
