//! `conray-page`: builds the viewer for web browsers and serves it on this machine.
//!
//! 1. cargo builds the program `conray-viewer` for `wasm32-unknown-unknown` (`make.rs`);
//! 2. wasm-bindgen writes the JavaScript that loads it;
//! 3. both go with the files of `web/` into one folder, which any server of files can serve, and which is served here.

mod make;
mod serve;

use clap::Parser;
use std::{path::PathBuf, process::ExitCode};

/// Builds the viewer as a web page and serves it on this machine.
#[derive(Parser)]
#[command(name = "conray-page", version)]
struct Options {
    /// Folder that the page is put into
    #[arg(long, value_name = "FOLDER", default_value = "target/page")]
    out: PathBuf,
    /// Port of this machine to serve it on; 0 is any that is free
    #[arg(long, value_name = "PORT", default_value_t = 8080)]
    port: u16,
    /// Builds the page and does not serve it
    #[arg(long)]
    build_only: bool,
    /// Serves the page that is there and does not build it
    #[arg(long, conflicts_with = "build_only")]
    serve_only: bool,
    /// Serves without the headers that let page and worker share memory, as servers of files do that cannot be told
    #[arg(long)]
    plain: bool,
}

fn main() -> ExitCode {
    match run(&Options::parse()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(message) => {
            eprintln!("conray-page: {message}");
            ExitCode::FAILURE
        }
    }
}

fn run(options: &Options) -> Result<(), String> {
    if !options.serve_only {
        make::page(&options.out)?;
    }
    if options.build_only {
        println!("the page is in {}", options.out.display());
        return Ok(());
    }
    serve::serve(&options.out, options.port, !options.plain)
}
