//! Writes the made-up report of the tests into a folder, for looking at the page:
//! `cargo run -p conray-study --example fixture_report -- FOLDER`.

#[path = "../src/fixture.rs"]
mod fixture;

use std::{env, path::PathBuf, process::ExitCode};

fn main() -> ExitCode {
    let Some(folder) = env::args_os().nth(1).map(PathBuf::from) else {
        eprintln!("usage: fixture_report FOLDER");
        return ExitCode::from(2);
    };
    let report = fixture::report();
    match conray_study::write_report(&folder, &report, &fixture::pictures(&report)) {
        Ok(()) => {
            println!("wrote {}", folder.join("report.html").display());
            ExitCode::SUCCESS
        }
        Err(error) => {
            eprintln!("{error}");
            ExitCode::FAILURE
        }
    }
}
