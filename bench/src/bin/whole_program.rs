//! `conray render` against `embree_render`, whole processes in turn.
//!
//! `cargo run --release -p conray-bench --bin whole_program -- SCENE... [--width 1280] [--height 720] [--rays 64] [--rounds 5]`

use clap::Parser;
use conray_bench::whole_program::Job;

#[derive(Parser)]
struct Args {
    /// Built-in scenes or files
    #[arg(default_values = ["cornell", "atrium"])]
    scenes: Vec<String>,
    /// Width of the image in pixels
    #[arg(long, default_value_t = 1280)]
    width: u32,
    /// Height of the image in pixels
    #[arg(long, default_value_t = 720)]
    height: u32,
    /// Rays per pixel, a multiple of 16
    #[arg(long, default_value_t = 64)]
    rays: u32,
    /// Runs of each program
    #[arg(long, default_value_t = 5)]
    rounds: usize,
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let args = Args::parse();
    for scene in args.scenes {
        let job = Job { scene, size: (args.width, args.height), rays: args.rays };
        let found = job.run(args.rounds)?;
        println!(
            "{}: conray {:.3} s ({:.3} to {:.3}), with Embree {:.3} s ({:.3} to {:.3}); conray is {:.2} times as fast; \
             RMSE between the images {:.4}",
            job.scene,
            found.conray.median,
            found.conray.spread.0,
            found.conray.spread.1,
            found.embree.median,
            found.embree.spread.0,
            found.embree.spread.1,
            found.ratio,
            found.rmse
        );
    }
    Ok(())
}
