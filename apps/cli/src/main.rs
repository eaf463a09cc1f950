//! The `conray` program: thin over the library. It reads options, carries out one command and reports.

mod args;
mod bake;
mod compare;
mod explain;
mod failure;
mod info;
mod inputs;
mod interrupt;
mod render;
mod report;
mod sample;
mod study;
mod view;

use args::{Cli, Command};
use clap::{CommandFactory, FromArgMatches};
use std::process::ExitCode;

fn main() -> ExitCode {
    #[cfg(all(feature = "gpu", target_os = "linux"))]
    without_session();
    if std::env::args_os().len() == 1 {
        // Without a command: help is what was meant, and not an error. A closed pipe is no reason to complain.
        let _ = Cli::command().print_long_help();
        return ExitCode::SUCCESS;
    }
    let words = match bake::with_job(std::env::args_os().collect()) {
        Ok(words) => words,
        Err(failure) => {
            eprintln!("conray: {failure}");
            return failure.code();
        }
    };
    let matches = Cli::command().get_matches_from(words);
    bake::keep(&matches);
    let cli = Cli::from_arg_matches(&matches).unwrap_or_else(|e| e.exit());
    let result = match cli.command {
        Command::Render(args) => render::run(&args),
        Command::Bake(args) => bake::run(&args),
        Command::Sample(args) => sample::run(&args),
        Command::Info(args) => info::run(&args),
        Command::Study(args) => study::run(&args),
        Command::Compare(args) => compare::run(&args),
        Command::View(args) => match view::run(&args) {
            Ok(code) => return code,
            Err(failure) => Err(failure),
        },
    };
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => {
            eprintln!("conray: {failure}");
            failure.code()
        }
    }
}

/// Mesa's layer that chooses adapters asks the session's compositor, and where there is no session a library below it complains on the error stream. There is
/// nothing to choose by then: the layer is left out.
#[cfg(all(feature = "gpu", target_os = "linux"))]
#[allow(unsafe_code, reason = "the environment is read by a C library")]
fn without_session() {
    if std::env::var_os("XDG_RUNTIME_DIR").is_none() {
        // SAFETY: nothing else runs yet, so nobody reads the environment meanwhile.
        unsafe { std::env::set_var("NODEVICE_SELECT", "1") };
    }
}
