//! A contest of ray kernels on one scene: who takes part, and what is printed of it.

use crate::{
    builds::{Builds, Seconds},
    embree::{Device, Embree, SceneFlags},
    hemispheres::{Hemispheres, Order},
    judged,
    kernels::{Bundles, EmbreeKernel, Kernel, Mode, Obvhs, Packing, Single},
    race::{self, Finish, Race},
};
use conray::{AoSettings, Distance};
use serde_json::{Value, json};
use std::fmt::Write;

/// A device of Embree's and what its scenes are asked to be.
#[derive(Clone, Debug)]
pub struct Variant {
    /// As `rtcNewDevice` documents it; empty for the defaults.
    pub config: String,
    /// Of the scene.
    pub flags: SceneFlags,
}

/// Which of Embree's modes take part.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Lineup {
    /// Those that were the best in some scene, each in its best order.
    Best,
    /// Every mode in every order.
    All,
}

/// What a contest is about.
#[derive(Clone, Debug)]
pub struct RayOptions {
    /// AO distance.
    pub distance: Distance,
    /// Side of the image whose points are taken, in pixels.
    pub side: u32,
    /// Timed builds of each hierarchy.
    pub builds: usize,
    /// Embree's devices and scene flags.
    pub variants: Vec<Variant>,
    /// Embree's modes.
    pub lineup: Lineup,
}

/// A scene made ready in every kernel.
pub struct Contest {
    scene: Hemispheres,
    embrees: Vec<(String, Embree)>,
    obvhs: Obvhs,
    /// Our builds and Embree's.
    pub builds: Builds,
    lineup: Lineup,
}

impl Contest {
    /// Loads and builds a scene.
    ///
    /// # Errors
    /// What the loader or a builder says.
    pub fn new(name: &str, options: &RayOptions) -> Result<Self, Box<dyn std::error::Error>> {
        let settings = AoSettings { distance: options.distance, ..AoSettings::default() };
        let scene = Hemispheres::new(judged(name)?, &settings, options.side)?;
        let geometry = scene.session.geometry();
        let builds = Builds::time(geometry, &Device::new("")?, options.builds)?;
        let embree = |v: &Variant| -> Result<(String, Embree), String> {
            let robust = if v.flags.robust { "robust" } else { "" };
            let name = [v.config.as_str(), robust].into_iter().filter(|s| !s.is_empty());
            let name = name.collect::<Vec<_>>().join(" ");
            Ok((name, Embree::build(&Device::new(&v.config)?, geometry, v.flags)?))
        };
        let embrees = options.variants.iter().map(embree).collect::<Result<_, _>>()?;
        let obvhs = Obvhs::build(geometry, scene.distance);
        Ok(Self { scene, embrees, obvhs, builds, lineup: options.lineup })
    }

    /// Lets all kernels trace that many rays of each point.
    pub fn run(&self, rays: usize, rounds: usize) -> Race {
        race::race(&self.scene.points, rays, &self.kernels(), rounds)
    }

    /// The scene with its points.
    pub fn scene(&self) -> &Hemispheres {
        &self.scene
    }

    /// Million rays a second of `rtcOccluded1` on the first of Embree's devices.
    pub fn single_mrays(&self, rays: usize, rounds: usize) -> f64 {
        let (variant, embree) = &self.embrees[0];
        let (mode, order, distance) = (Mode::Single, Order::Morton, self.scene.distance);
        let kernel = EmbreeKernel { embree, variant, mode, order, distance };
        let race = race::race(&self.scene.points, rays, &[Box::new(kernel)], rounds);
        race.mrays(&race.finishes[0])
    }

    /// Ours first: the others are judged by its answers.
    fn kernels(&self) -> Vec<Box<dyn Kernel + '_>> {
        let (bvh, distance) = (self.scene.session.bvh(), self.scene.distance);
        let mut kernels: Vec<Box<dyn Kernel + '_>> =
            vec![Box::new(Single { bvh, distance }), Box::new(Bundles { bvh, distance })];
        for (variant, embree) in &self.embrees {
            for (mode, order) in self.lineup.modes() {
                kernels.push(Box::new(EmbreeKernel { embree, variant, mode, order, distance }));
            }
        }
        kernels.push(Box::new(&self.obvhs));
        kernels
    }

    /// The scene and its builds, for people.
    pub fn heading(&self) -> String {
        let seconds = |b: &Seconds| format!("{:.3} s ({:.3} to {:.3})", b.median, b.spread.0, b.spread.1);
        format!(
            "{}: {} triangles, {} points, distance {}\n  builds: conray {}, Embree {}, ratio {:.2}; obvhs {:.2} s",
            self.scene.name,
            self.scene.session.geometry().triangle_count(),
            self.scene.points.len(),
            self.scene.distance,
            seconds(&self.builds.conray),
            seconds(&self.builds.embree),
            self.builds.ratio(),
            self.obvhs.build_seconds()
        )
    }

    /// The scene and its builds, for programs.
    pub fn json(&self) -> Value {
        let seconds = |b: &Seconds| json!({ "median": b.median, "min": b.spread.0, "max": b.spread.1 });
        json!({
            "name": self.scene.name,
            "triangles": self.scene.session.geometry().triangle_count(),
            "points": self.scene.points.len(),
            "distance": self.scene.distance.is_finite().then_some(self.scene.distance),
            "build_seconds": {
                "conray": seconds(&self.builds.conray),
                "embree": seconds(&self.builds.embree),
                "obvhs": self.obvhs.build_seconds(),
            },
        })
    }
}

impl Lineup {
    fn modes(self) -> Vec<(Mode, Order)> {
        let packets = |coherent, packing| (Mode::Packets { size: 16, coherent, packing }, Order::Morton);
        match self {
            Self::Best => vec![
                (Mode::Single, Order::Morton),
                packets(false, Packing::Point),
                packets(false, Packing::Row),
                packets(true, Packing::Point),
            ],
            Self::All => Mode::all().iter().flat_map(|&mode| Order::ALL.map(|order| (mode, order))).collect(),
        }
    }
}

/// Figures of a race, a line for each kernel.
pub fn table(race: &Race) -> String {
    let mut text = format!(
        "  {} rays a point; directions are made at {:.1} Mrays/s\n  {:44} {:>8} {:>17} {:>9} {:>9} {:>9}\n",
        race.rays_per_point,
        race.rays as f64 / race.directions_seconds / 1e6,
        "",
        "Mrays/s",
        "quartiles",
        "x Embree",
        "open",
        "differ"
    );
    for finish in &race.finishes {
        let rate = |seconds: f64| race.rays as f64 / seconds / 1e6;
        let spread = format!("{:.2} to {:.2}", rate(finish.quartiles.1), rate(finish.quartiles.0));
        let ratio = race.ratio(finish).map_or("-".into(), |r| format!("{r:.3}"));
        let open = finish.open as f64 / race.rays as f64;
        // Writing to a string cannot fail.
        let _ = writeln!(
            text,
            "    {:42} {:8.2} {spread:>17} {ratio:>9} {open:9.6} {:9}",
            finish.name,
            race.mrays(finish),
            finish.differing
        );
    }
    text
}

/// Figures of a race for programs.
pub fn json(race: &Race) -> Value {
    let rate = |seconds: f64| race.rays as f64 / seconds / 1e6;
    let kernel = |f: &Finish| {
        json!({
            "name": f.name,
            "family": format!("{:?}", f.family).to_lowercase(),
            "mrays_per_second": race.mrays(f),
            "quartiles": [rate(f.quartiles.1), rate(f.quartiles.0)],
            "min": rate(f.rounds.1),
            "max": rate(f.rounds.0),
            "times_embree_best": race.ratio(f),
            "open_share": f.open as f64 / race.rays as f64,
            "differing_rays": f.differing,
        })
    };
    json!({
        "rays_per_point": race.rays_per_point,
        "rays": race.rays,
        "directions_mrays_per_second": race.rays as f64 / race.directions_seconds / 1e6,
        "kernels": race.finishes.iter().map(kernel).collect::<Vec<_>>(),
    })
}
