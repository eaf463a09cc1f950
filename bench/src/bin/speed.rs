//! Every measure of speed with what it must reach and what it aims at, in one run.
//!
//! `cargo run --release -p conray-bench --bin speed -- cornell SCENES/crytek-sponza/sponza.obj
//! SCENES/conference/conference.obj atrium [--json FILE]`
//!
//! `bench/fetch-rivals embree` fetches the rival. Fails where kernels do not agree; a missed measure is said, not failed.

use clap::Parser;
use conray::{ConeSet, Distance};
use conray_bench::{
    agreement,
    cone_sets::ConeSets,
    embree::SceneFlags,
    judged,
    kernels::Family,
    machine::Machine,
    measures::{self, Bound, Measure},
    octree_build::OctreeBuild,
    race::Finish,
    rays::{self, Contest, Lineup, RayOptions, Variant},
    whole_program::Job,
};
use conray_voxel::{Octree, OctreeOptions};
use serde_json::{Value, json};
use std::error::Error;

#[derive(Parser)]
struct Args {
    /// Built-in scenes or files
    #[arg(default_values = ["cornell", "atrium"])]
    scenes: Vec<String>,
    /// Side of the image whose points are taken
    #[arg(long, default_value_t = 256)]
    side: u32,
    /// Timed rounds, builds and runs
    #[arg(long, default_value_t = 5)]
    rounds: usize,
    /// Rays per point of the first measure, multiples of 16
    #[arg(long, value_delimiter = ',', default_values_t = [16, 64, 256])]
    rays: Vec<usize>,
    /// Builds and runs the whole programs too: true or false
    #[arg(long, default_value_t = true, action = clap::ArgAction::Set)]
    programs: bool,
    /// Some seconds for each scene: to see that it works, not to measure
    #[arg(long)]
    quick: bool,
    /// Writes all figures to a file
    #[arg(long)]
    json: Option<std::path::PathBuf>,
}

fn main() -> Result<(), Box<dyn Error>> {
    let mut args = Args::parse();
    if args.quick {
        (args.side, args.rounds) = (64, 1);
    }
    let machine = Machine::here();
    println!("{machine}");
    let mut run =
        Run { rounds: args.rounds.max(1), measures: Vec::new(), races: Vec::new(), wrong: Vec::new() };
    // First of all, while the process has freed nothing that could hide its peak.
    for scene in &args.scenes {
        run.octree(scene)?;
    }
    for scene in &args.scenes {
        let contest = Contest::new(scene, &options(&args))?;
        println!("\n{}", contest.heading());
        run.builds(&contest);
        for &per_point in &args.rays {
            run.rays(&contest, per_point);
        }
        run.cones(&contest)?;
    }
    if args.programs {
        for scene in &args.scenes {
            run.whole_program(scene);
        }
    }
    println!("\n{}", measures::table(&run.measures));
    if let Some(path) = &args.json {
        std::fs::write(path, format!("{:#}\n", run.json(&machine)))?;
    }
    if run.wrong.is_empty() { Ok(()) } else { Err(run.wrong.join("\n").into()) }
}

fn options(args: &Args) -> RayOptions {
    RayOptions {
        distance: Distance::Auto,
        side: args.side,
        builds: args.rounds,
        variants: vec![Variant { config: String::new(), flags: SceneFlags::default() }],
        lineup: Lineup::Best,
    }
}

/// What was found so far.
struct Run {
    rounds: usize,
    measures: Vec<Measure>,
    races: Vec<Value>,
    wrong: Vec<String>,
}

impl Run {
    /// Our fastest kernel against Embree's best mode.
    fn rays(&mut self, contest: &Contest, per_point: usize) {
        let scene = contest.scene().name.clone();
        let race = contest.run(per_point, self.rounds);
        print!("{}", rays::table(&race));
        self.wrong
            .extend(agreement::check(&race).err().map(|why| format!("{scene}, {per_point} rays: {why}")));
        let (ours, theirs) = (race.best(Family::Conray), race.best(Family::Embree));
        let detail = |f: &Finish| format!("{} {:.1}", f.name, race.mrays(f));
        // Few rays are the harder case for what is done once per point.
        let least = if per_point < 64 { 1.0 } else { 1.5 };
        self.measures.push(Measure {
            what: format!("rays a second, times Embree's best, {per_point} a point"),
            scene,
            found: ours.and_then(|f| race.ratio(f)),
            must: Some(Bound::AtLeast(least)),
            aim: Some(Bound::AtLeast(3.0)),
            detail: ours.into_iter().chain(theirs).map(detail).collect::<Vec<_>>().join(", ") + " Mrays/s",
        });
        self.races.push(json!({ "scene": contest.json(), "race": rays::json(&race) }));
    }

    fn builds(&mut self, contest: &Contest) {
        let (ours, theirs) = (contest.builds.conray.median, contest.builds.embree.median);
        self.measures.push(Measure {
            what: "BVH build, times Embree's at quality high".into(),
            scene: contest.scene().name.clone(),
            found: Some(contest.builds.ratio()),
            must: Some(Bound::AtMost(1.5)),
            aim: Some(Bound::AtMost(1.0)),
            detail: format!("conray {ours:.3} s, Embree {theirs:.3} s"),
        });
    }

    /// A set of 16 cones in units of Embree's single rays.
    fn cones(&mut self, contest: &Contest) -> Result<(), Box<dyn Error>> {
        let scene = contest.scene();
        let options = OctreeOptions { resolution: 512, ..OctreeOptions::default() };
        let octree = Octree::build(scene.session.geometry(), &options)?;
        let (seconds, visibility) =
            ConeSets::new(&octree, ConeSet::Sixteen, scene.distance).time(&scene.points, self.rounds);
        let mrays = contest.single_mrays(16, self.rounds);
        let set_us = seconds / scene.points.len() as f64 * 1e6;
        self.measures.push(Measure {
            what: "16 cones, octree at 512, in rtcOccluded1 rays".into(),
            scene: scene.name.clone(),
            found: Some(set_us * mrays),
            must: Some(Bound::AtMost(16.0)),
            aim: Some(Bound::AtMost(4.0)),
            detail: format!("{set_us:.2} us a set, {mrays:.1} Mrays/s, mean visibility {visibility:.3}"),
        });
        Ok(())
    }

    /// Seconds and peak of the octree at 1024; the measure is for Crytek Sponza, others are reported.
    fn octree(&mut self, name: &str) -> Result<(), Box<dyn Error>> {
        let loaded = judged(name)?;
        // With its masks, as a user's octree is built.
        let build = OctreeBuild::time(&loaded.scene.geometry, 1024, self.rounds)?;
        let bound = |at_most: f64| (loaded.name == "sponza").then_some(Bound::AtMost(at_most));
        let megabytes = |bytes: u64| bytes as f64 / 1e6;
        let process = build.process_bytes.map_or("unknown".into(), |b| format!("{:.0} MB", megabytes(b)));
        self.measures.push(Measure {
            what: "octree at 1024, seconds".into(),
            scene: loaded.name.clone(),
            found: Some(build.seconds.median),
            must: bound(2.0),
            aim: bound(0.7),
            detail: format!("{:.2} to {:.2} s", build.seconds.spread.0, build.seconds.spread.1),
        });
        self.measures.push(Measure {
            what: "octree at 1024, MB at the peak".into(),
            scene: loaded.name.clone(),
            found: Some(megabytes(build.worst_peak_bytes())),
            must: bound(400.0),
            aim: bound(150.0),
            detail: format!(
                "by its own count {:.0} MB, process {process}, held {:.0} MB",
                megabytes(build.peak_bytes),
                megabytes(build.memory_bytes)
            ),
        });
        Ok(())
    }

    fn whole_program(&mut self, name: &str) {
        let job = Job { scene: name.into(), size: (1280, 720), rays: 64 };
        let found = job.run(self.rounds);
        let detail = match &found {
            Ok(f) => format!(
                "conray {:.2} s, with Embree {:.2} s, RMSE between the images {:.4}",
                f.conray.median, f.embree.median, f.rmse
            ),
            Err(why) => why.clone(),
        };
        self.measures.push(Measure {
            what: "1280x720, 64 rays, times as fast as with Embree".into(),
            scene: std::path::Path::new(name).file_stem().unwrap_or_default().to_string_lossy().into_owned(),
            found: found.ok().map(|f| f.ratio),
            must: None,
            aim: Some(Bound::AtLeast(2.0)),
            detail,
        });
    }

    fn json(&self, machine: &Machine) -> Value {
        let measures: Vec<Value> = self.measures.iter().map(Measure::json).collect();
        json!({ "machine": machine.json(), "measures": measures, "races": self.races })
    }
}
