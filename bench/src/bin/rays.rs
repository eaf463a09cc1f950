//! Rays a second: our kernels against Embree and obvhs, on the same triangles and the same rays.
//!
//! `cargo run --release -p conray-bench --bin rays -- cornell atrium PATH... [--rays 64] [--json FILE]`
//!
//! `bench/fetch-rivals embree` fetches Embree; without it the program fails, as a comparison with nothing is none. It
//! fails too where kernels do not agree on the rays. `--modes all` tries every mode and order of Embree's; otherwise
//! the ones that were best somewhere take part.

use clap::{Parser, ValueEnum};
use conray::Distance;
use conray_bench::{
    agreement,
    embree::SceneFlags,
    machine::Machine,
    rays::{self, Contest, Lineup, RayOptions, Variant},
};
use serde_json::json;

#[derive(Parser)]
struct Args {
    /// Built-in scenes or files
    #[arg(default_values = ["cornell", "atrium"])]
    scenes: Vec<String>,
    /// Rays per point, multiples of 16
    #[arg(long, value_delimiter = ',', default_values_t = [16, 64, 256])]
    rays: Vec<usize>,
    /// Side of the image whose points are taken
    #[arg(long, default_value_t = 256)]
    side: u32,
    /// Timed rounds
    #[arg(long, default_value_t = 5)]
    rounds: usize,
    /// Timed builds of each hierarchy
    #[arg(long, default_value_t = 5)]
    builds: usize,
    /// AO distance
    #[arg(long, default_value_t = Distance::Auto)]
    distance: Distance,
    /// Which of Embree's modes and orders take part
    #[arg(long, value_enum, default_value = "best")]
    modes: Modes,
    /// More devices of Embree's, as rtcNewDevice documents them (such as max_isa=avx2), beside the default
    #[arg(long = "device")]
    devices: Vec<String>,
    /// Embree's robust scenes too
    #[arg(long)]
    robust: bool,
    /// A few seconds for each scene: to see that it works, not to measure
    #[arg(long)]
    quick: bool,
    /// Writes all figures to a file
    #[arg(long)]
    json: Option<std::path::PathBuf>,
}

#[derive(Clone, Copy, PartialEq, ValueEnum)]
enum Modes {
    /// Those that were the best in some scene
    Best,
    /// All
    All,
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    run(&Args::parse())
}

fn run(args: &Args) -> Result<(), Box<dyn std::error::Error>> {
    if args.rays.iter().any(|r| *r == 0 || r % 16 != 0) {
        return Err("--rays: expected multiples of 16, as Embree's packets have no empty places".into());
    }
    let machine = Machine::here();
    println!("{machine}");
    let (mut figures, mut wrong) = (Vec::new(), Vec::new());
    for name in &args.scenes {
        let contest = Contest::new(name, &args.options())?;
        println!("\n{}", contest.heading());
        for &per_point in &args.rays {
            let race = contest.run(per_point, args.rounds());
            print!("{}", rays::table(&race));
            wrong.extend(agreement::check(&race).err().map(|why| format!("{name}, {per_point} rays: {why}")));
            figures.push(json!({ "scene": contest.json(), "race": rays::json(&race) }));
        }
    }
    if let Some(path) = &args.json {
        std::fs::write(path, format!("{:#}\n", json!({ "machine": machine.json(), "races": figures })))?;
    }
    if wrong.is_empty() { Ok(()) } else { Err(wrong.join("\n").into()) }
}

impl Args {
    fn rounds(&self) -> usize {
        if self.quick { 1 } else { self.rounds.max(1) }
    }

    fn options(&self) -> RayOptions {
        let variant = |config: &str, flags| Variant { config: config.into(), flags };
        let mut variants = vec![variant("", SceneFlags::default())];
        variants.extend(self.devices.iter().map(|config| variant(config, SceneFlags::default())));
        if self.robust {
            variants.push(variant("", SceneFlags { robust: true, compact: false }));
        }
        RayOptions {
            distance: self.distance,
            side: if self.quick { 64 } else { self.side },
            builds: if self.quick { 1 } else { self.builds.max(1) },
            variants,
            lineup: if self.modes == Modes::All { Lineup::All } else { Lineup::Best },
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    #[ignore = "needs Embree, which bench/fetch-rivals gets"]
    fn every_kernel_agrees_ray_for_ray_with_embree() {
        run(&Args::parse_from(["rays", "--quick"])).unwrap();
    }
}
