//! Loads scene files and says what is in them and how long it took.

use conray_scene::{Limits, load};
use std::path::Path;
use std::time::Instant;

fn main() {
    for file in std::env::args().skip(1) {
        let start = Instant::now();
        match load(Path::new(&file), &Limits::default()) {
            Err(error) => println!("{error}"),
            Ok(scene) => {
                let (seconds, g) = (start.elapsed().as_secs_f64(), &scene.geometry);
                let masked = g.materials().iter().filter(|m| !m.opacity.is_opaque()).count();
                println!(
                    "{file}: {seconds:.3} s, {} triangles, {} meshes, {} instances, {} views",
                    g.triangle_count(),
                    g.meshes().len(),
                    g.instances().len(),
                    scene.views.len(),
                );
                println!("  {masked} of {} materials are not opaque; {:?}", g.materials().len(), g.bounds());
                scene.warnings.iter().for_each(|warning| println!("  {warning}"));
            }
        }
    }
}
