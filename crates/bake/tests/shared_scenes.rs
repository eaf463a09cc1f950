//! Small maps of some models in `../shared/scenes`; `bake_scenes` of the bench makes large ones of all.

use conray::{
    AoSettings, Control, Session,
    scene::{Limits, load},
};
use conray_bake::{Facing, MapExtent, MapOptions, Places, Sheets, Unwrap, bake_maps};
use conray_target::MapSize;
use std::path::Path;

const MODELS: [&str; 6] = [
    "boom-box/BoomBox.gltf",
    "damaged-helmet/DamagedHelmet.glb",
    "banana-tree/BananaTree.gltf",
    "scrub-pine/scrubPine.obj",
    "cornell-box/CornellBox-Original.obj",
    "cornell-box/CornellBox-Sphere.obj",
];
/// Error that is asked for; both sides of a seam may each be off by twice that.
const ERROR: f32 = 0.02;

#[test]
#[ignore = "needs the scenes beside the checkout"]
fn every_texel_has_a_value_and_both_sides_of_seams_agree() {
    let folder = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../../../shared/scenes"));
    for model in MODELS {
        let scene = load(&folder.join(model), &Limits::default()).unwrap();
        let settings = AoSettings { error: Some(ERROR), ..AoSettings::default() };
        let session = Session::build(scene.geometry, &settings).unwrap();
        let instances: Vec<u32> = (0..session.geometry().instances().len() as u32).collect();
        let size = MapExtent::Size(MapSize { width: 512, height: 512 });
        let sheets = Sheets::of(session.geometry(), &instances, size, Unwrap::Yes);
        assert!(sheets.unmapped.is_empty(), "{model}: {:?}", sheets.unmapped);
        let places = Places::of(session.geometry(), &sheets, scene.origins.is_empty(), 1, Facing::default());
        let options = MapOptions { seam_bound: 4.0 * ERROR, ..MapOptions::default() };
        let budget = session.plan().budget;
        let baked =
            bake_maps(&session, &[], &places, budget, &options, Control::none(), &mut |_| {}).unwrap();
        for map in &baked.maps {
            assert!(map.visibility.iter().all(|value| (0.0..=1.0).contains(value)), "{model}");
            assert!(map.error.iter().all(|error| error.is_finite()), "{model}");
            assert!(map.bent.iter().all(|bent| bent.is_finite()), "{model}");
        }
        let seams = baked.seams;
        let share = seams.within as f64 / seams.places.max(1) as f64;
        eprintln!("{model}: {:.3} % of {} places, worst {:.3}", 100.0 * share, seams.places, seams.worst);
        assert!(share >= 0.999, "{model}: {seams:?}");
    }
}
