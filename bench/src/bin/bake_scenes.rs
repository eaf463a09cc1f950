//! Maps of models, each texel looked at: are there values everywhere, and do both sides of seams agree.
//!
//! `cargo run --release -p conray-bench --bin bake_scenes -- MODEL... [--size 1024] [--error 0.02]`

use clap::Parser;
use conray::{
    AoSettings, Control, Session, Work,
    scene::{Limits, load},
    target::{AtlasMap, MapSize},
};
use conray_bake::{Facing, MapExtent, MapOptions, Places, Sheets, Unwrap, bake_maps};
use std::{error::Error, path::PathBuf, time::Instant};

#[derive(Parser)]
struct Args {
    /// Files of models
    #[arg(required = true)]
    models: Vec<PathBuf>,
    /// Texels on each side of a map
    #[arg(long, default_value_t = 1024)]
    size: u32,
    /// Error that is asked for
    #[arg(long, default_value_t = 0.02)]
    error: f32,
}

fn main() -> Result<(), Box<dyn Error>> {
    let args = Args::parse();
    println!(
        "{:22} {:>4} {:>10} {:>10} {:>9} {:>8} {:>10} {:>9} {:>7} {:>8}",
        "model", "maps", "texels", "read", "no value", "expected", "seams", "within", "worst", "seconds"
    );
    for model in &args.models {
        let start = Instant::now();
        let scene = load(model, &Limits::default())?;
        let settings = AoSettings { error: Some(args.error), ..AoSettings::default() };
        let session = Session::build(scene.geometry, &settings)?;
        let instances: Vec<u32> = (0..session.geometry().instances().len() as u32).collect();
        let size = MapExtent::Size(MapSize { width: args.size, height: args.size });
        let sheets = Sheets::of(session.geometry(), &instances, size, Unwrap::Yes);
        let v_up = scene.origins.is_empty();
        let places = Places::of(session.geometry(), &sheets, v_up, 1, Facing::default());
        let (budget, options) = (session.plan().budget, MapOptions::default());
        let baked = bake_maps(&session, &[], &places, budget, &options, Control::none(), &mut |_| {})?;
        let texels: usize = baked.maps.iter().map(|map| map.visibility.len()).sum();
        let read: usize = baked.maps.iter().map(|map| map.is_read.iter().filter(|read| **read).count()).sum();
        let seams = baked.seams;
        println!(
            "{:22} {:>4} {texels:>10} {read:>10} {:>9} {:>8.4} {:>10} {:>7.3} % {:>7.3} {:>8.1}",
            scene.name,
            baked.maps.len(),
            baked.maps.iter().map(without_value).sum::<usize>() + sheets.unmapped.len(),
            Work::of_parts(&baked.parts).map_or(0.0, |work| work.expected_rmse),
            seams.places,
            100.0 * seams.within as f64 / seams.places.max(1) as f64,
            seams.worst,
            start.elapsed().as_secs_f64()
        );
    }
    Ok(())
}

/// Texels, read or not, of which a value is no number from 0 to 1, or an error or direction none at all.
fn without_value(map: &AtlasMap) -> usize {
    let values = map.visibility.iter().zip(&map.error).zip(&map.bent);
    let is_right = |((visibility, error), bent): &((&f32, &f32), &conray::Vec3)| {
        (0.0..=1.0).contains(*visibility) && error.is_finite() && bent.is_finite()
    };
    values.filter(|all| !is_right(all)).count()
}
