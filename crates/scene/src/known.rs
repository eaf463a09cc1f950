//! Views of well-known scene files that bring none.
//!
//! A file is known by its name and its bounds: other scenes of the same name, and the same scene moved or scaled, get
//! nothing. Views point the way that pictures of these scenes usually do. Sources of the files: McGuire, "Computer
//! Graphics Archive", 2017; Stanford 3D Scanning Repository; Khronos glTF sample models.

use crate::Scene;
use conray_core::{Bounds, Vec3, View};

/// A file that is known.
struct Known {
    stem: &'static str,
    min: [f32; 3],
    max: [f32; 3],
    /// Name, eye, the point looked at, vertical field of view in degrees.
    views: &'static [(&'static str, [f32; 3], [f32; 3], f32)],
}

/// How far each coordinate of the bounds may be off, as a share of the diagonal: more than rounding, less than an edit.
const TOLERANCE: f32 = 0.005;

#[rustfmt::skip]
const KNOWN: [Known; 11] = [
    Known { stem: "sponza", min: [-1920.95, -126.44, -1182.81], max: [1799.91, 1429.43, 1105.43], views: &[
        ("atrium", [950.0, 170.0, -40.0], [-1000.0, 430.0, -40.0], 65.0),
        ("gallery", [-620.0, 730.0, -230.0], [-100.0, 560.0, 330.0], 65.0),
        ("along", [-900.0, 560.0, 60.0], [900.0, 330.0, -120.0], 60.0),
        ("ivy", [250.0, 260.0, -60.0], [620.0, 130.0, -235.0], 55.0),
    ] },
    Known { stem: "conference", min: [-1020.13, -2.79, -1055.66], max: [1685.81, 650.29, 668.49], views: &[
        ("chairs", [300.0, 300.0, 480.0], [560.0, 110.0, -200.0], 65.0),
        ("room", [-700.0, 330.0, 450.0], [600.0, 140.0, -250.0], 60.0),
        ("lectern", [1450.0, 420.0, -900.0], [350.0, 120.0, -100.0], 60.0),
    ] },
    Known { stem: "CornellBox-Original", min: [-1.02, 0.0, -1.04], max: [1.0, 1.99, 0.99], views: &[
        ("usual", [0.0, 1.0, 3.9], [0.0, 1.0, 0.0], 38.0),
    ] },
    Known { stem: "CornellBox-Sphere", min: [-1.02, 0.0, -1.04], max: [1.0, 1.59, 0.99], views: &[
        ("usual", [0.0, 0.8, 3.9], [0.0, 0.8, 0.0], 38.0),
    ] },
    Known { stem: "bunny", min: [-0.956, 0.021, -0.543], max: [0.658, 1.642, 0.690], views: &[
        ("usual", [-1.2, 1.8, 3.2], [-0.15, 0.75, 0.05], 35.0),
    ] },
    Known { stem: "bun_zipper", min: [-0.0947, 0.0330, -0.0619], max: [0.0610, 0.1873, 0.0588], views: &[
        ("usual", [-0.12, 0.2, 0.28], [-0.017, 0.105, 0.0], 35.0),
    ] },
    Known { stem: "scrubPine", min: [-374.48, 3.03, -431.86], max: [341.12, 933.94, 269.71], views: &[
        ("usual", [900.0, 600.0, 1400.0], [0.0, 450.0, -50.0], 45.0),
    ] },
    Known { stem: "BananaTree", min: [-198.14, -0.65, -180.49], max: [240.39, 488.27, 167.42], views: &[
        ("usual", [450.0, 320.0, 700.0], [20.0, 230.0, 0.0], 40.0),
    ] },
    Known { stem: "DamagedHelmet", min: [-0.947, -0.901, -1.187], max: [0.943, 0.901, 0.813], views: &[
        ("usual", [1.8, 0.9, 2.9], [0.0, -0.05, -0.15], 40.0),
    ] },
    Known { stem: "FlightHelmet", min: [-0.204, 0.0, -0.172], max: [0.163, 0.716, 0.200], views: &[
        ("usual", [0.6, 0.6, 1.2], [0.0, 0.34, 0.0], 40.0),
    ] },
    Known { stem: "BoomBox", min: [-0.0099, -0.0098, -0.0101], max: [0.0099, 0.0098, 0.0101], views: &[
        ("usual", [0.02, 0.012, 0.03], [0.0, 0.0, 0.0], 40.0),
    ] },
];

/// The views of the file of that stem whose scene has those bounds; none unless both are known.
pub(crate) fn known_views(stem: &str, bounds: Bounds) -> Vec<View> {
    let fits = |known: &&Known| {
        let (min, max) = (Vec3::from_array(known.min), Vec3::from_array(known.max));
        let allowed = TOLERANCE * (max - min).length();
        // False for empty bounds too, whose corners are infinitely far.
        let near = |a: Vec3, b: Vec3| (a - b).abs().max_element() <= allowed;
        known.stem == stem && near(bounds.min, min) && near(bounds.max, max)
    };
    let view = |&(name, eye, look_at, vertical_fov_deg): &(&str, _, _, _)| View {
        name: name.into(),
        eye: Vec3::from_array(eye),
        look_at: Vec3::from_array(look_at),
        up: Vec3::Y,
        vertical_fov_deg,
    };
    KNOWN.iter().find(fits).map_or_else(Vec::new, |known| known.views.iter().map(view).collect())
}

/// Adds the known views behind the file's own, which keep their names.
pub(crate) fn add_known_views(scene: &mut Scene) {
    for view in known_views(&scene.name, scene.geometry.bounds()) {
        if scene.view(&view.name).is_none() {
            scene.views.push(view);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Limits, load_bytes};
    use std::collections::HashSet;

    fn bounds(known: &Known) -> Bounds {
        Bounds { min: Vec3::from_array(known.min), max: Vec3::from_array(known.max) }
    }

    /// Loads a text with two triangles that reach two opposite corners.
    fn load_spanning(name: &str, bounds: Bounds) -> Scene {
        let Bounds { min, max } = bounds;
        let corner = |v: Vec3| format!("v {} {} {}\n", v.x, v.y, v.z);
        let corners = [min, min.with_x(max.x), min.with_y(max.y), max, max.with_x(min.x), max.with_y(min.y)];
        let text = corners.map(corner).concat() + "f 1 2 3\nf 4 5 6\n";
        load_bytes(name, text.as_bytes(), None, &|_| unreachable!("no file is named"), &Limits::default())
            .unwrap()
    }

    #[test]
    fn each_known_file_gets_its_views_when_loaded() {
        for known in &KNOWN {
            let scene = load_spanning(&format!("somewhere/{}.obj", known.stem), bounds(known));
            let names: Vec<&str> = scene.views.iter().map(|view| &*view.name).collect();
            assert_eq!(names, known.views.iter().map(|view| view.0).collect::<Vec<_>>(), "{}", known.stem);
            assert_eq!(scene.default_view().name, known.views[0].0);
        }
    }

    #[test]
    fn other_names_and_other_bounds_get_none() {
        for known in &KNOWN {
            let whole = bounds(known);
            let diagonal = whole.diagonal();
            assert_eq!(known_views("castle", whole), []);
            assert_eq!(known_views(known.stem, Bounds::EMPTY), []);
            for axis in [Vec3::X, Vec3::Y, Vec3::Z] {
                let moved = |share: f32| Bounds { max: whole.max + share * diagonal * axis, ..whole };
                assert!(!known_views(known.stem, moved(0.004)).is_empty(), "{}", known.stem);
                assert_eq!(known_views(known.stem, moved(0.006)), [], "{}", known.stem);
                let moved = |share: f32| Bounds { min: whole.min - share * diagonal * axis, ..whole };
                assert!(!known_views(known.stem, moved(0.004)).is_empty(), "{}", known.stem);
                assert_eq!(known_views(known.stem, moved(0.006)), [], "{}", known.stem);
            }
        }
        let other = Bounds { min: Vec3::splat(-1.0), max: Vec3::ONE };
        let scene = load_spanning("sponza.obj", other);
        assert!(scene.views.is_empty() && scene.default_view().name == "whole");
    }

    #[test]
    fn views_of_the_file_itself_come_first_and_keep_their_names() {
        let mut scene = load_spanning("sponza.obj", bounds(&KNOWN[0]));
        let own = |name: &str| View { name: name.into(), vertical_fov_deg: 10.0, ..scene.views[0].clone() };
        let (ivy, mine) = (own("ivy"), own("mine"));
        scene.views = vec![ivy.clone(), mine.clone()];
        add_known_views(&mut scene);
        assert_eq!(scene.views[..2], [ivy, mine]);
        let added: Vec<&str> = scene.views[2..].iter().map(|view| &*view.name).collect();
        assert_eq!(added, ["atrium", "gallery", "along"]);
    }

    #[test]
    fn the_table_is_sound() {
        let mut stems = HashSet::new();
        for known in &KNOWN {
            assert!(stems.insert(known.stem) && !known.views.is_empty());
            assert!(!bounds(known).is_empty(), "{}", known.stem);
            let mut names = HashSet::new();
            for (name, eye, look_at, fov) in known.views {
                assert!(names.insert(name) && eye != look_at && (10.0..90.0).contains(fov), "{name}");
            }
        }
    }
}
