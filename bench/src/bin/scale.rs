//! How the cost of rays, cones and builds grows with triangles, resolution, AO distance and rays per point.
//!
//! `cargo run --release -p conray-bench --bin scale -- [-o docs/images] [--ask triangles,distance] [--json FILE]`
//!
//! Prints a table for each question with the exponents that fit best, and writes `scale-*.svg` into the folder. Built-in
//! scenes are cut finer and finer, up to 20 million triangles: that takes 5 GB of memory and ten minutes;
//! `--most-triangles 1000000` takes less of both.

use clap::{Parser, ValueEnum};
use conray_bench::{
    machine::Machine,
    scale::{self, Answer, ScaleOptions},
};
use serde_json::{Value, json};
use std::{error::Error, path::PathBuf};

#[derive(Parser)]
struct Args {
    /// Built-in scenes or files
    #[arg(default_values = ["cornell-blocks", "cornell", "atrium"])]
    scenes: Vec<String>,
    /// Questions
    #[arg(long, value_enum, value_delimiter = ',',
        default_values = ["triangles", "resolution", "distance", "rays"])]
    ask: Vec<Question>,
    /// Side of the image whose points are taken
    #[arg(long, default_value_t = 128)]
    side: u32,
    /// Timed rounds
    #[arg(long, default_value_t = 5)]
    rounds: usize,
    /// Most triangles that scenes are cut into
    #[arg(long, default_value_t = 20_000_000)]
    most_triangles: u64,
    /// A scene with instances that is measured as it is, beside the others; empty for none
    #[arg(long, default_value = "grove")]
    instanced: String,
    /// Folder for the plots
    #[arg(short, long)]
    output: Option<PathBuf>,
    /// Writes all figures to a file
    #[arg(long)]
    json: Option<PathBuf>,
}

#[derive(Clone, Copy, PartialEq, ValueEnum)]
enum Question {
    /// Time of a point and of builds against triangles
    Triangles,
    /// Time of cones and octree builds against resolution
    Resolution,
    /// Time of a point against AO distance
    Distance,
    /// Time of a point against its rays
    Rays,
}

fn main() -> Result<(), Box<dyn Error>> {
    let args = Args::parse();
    let machine = Machine::here();
    println!("{machine}");
    let options = ScaleOptions {
        scenes: args.scenes,
        side: args.side,
        rounds: args.rounds.max(1),
        most_triangles: args.most_triangles,
        instanced: (!args.instanced.is_empty()).then_some(args.instanced),
    };
    let tell = |step: &str| eprintln!("{step}");
    let mut answers: Vec<Answer> = Vec::new();
    for question in args.ask {
        match question {
            Question::Triangles => answers.extend(scale::triangles(&options, &tell)?),
            Question::Resolution => answers.extend(scale::resolution(&options, &tell)?),
            Question::Distance => answers.push(scale::distance(&options, &tell)?),
            Question::Rays => answers.push(scale::rays(&options, &tell)?),
        }
    }
    answers.iter().for_each(|answer| println!("\n{}", answer.table()));
    if let Some(folder) = &args.output {
        std::fs::create_dir_all(folder)?;
        for answer in &answers {
            std::fs::write(folder.join(format!("scale-{}.svg", answer.name)), answer.svg())?;
        }
    }
    if let Some(path) = &args.json {
        let answers: Vec<Value> = answers.iter().map(Answer::json).collect();
        std::fs::write(path, format!("{:#}\n", json!({ "machine": machine.json(), "answers": answers })))?;
    }
    Ok(())
}
