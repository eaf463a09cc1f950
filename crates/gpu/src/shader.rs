//! The shaders, with what they include put in its place.

macro_rules! files {
    ($($file:literal),+ $(,)?) => {
        &[$(($file, include_str!(concat!("../shaders/", $file)))),+]
    };
}

/// All files, entry points first.
const FILES: &[(&str, &str)] = files![
    "rays.wgsl",
    "cones.wgsl",
    "cone_rays.wgsl",
    "bundles.wgsl",
    "weigh_units.wgsl",
    "weigh_begin.wgsl",
    "weigh_cells.wgsl",
    "weigh_guess.wgsl",
    "weigh_sums.wgsl",
    "weigh_everywhere.wgsl",
    "weigh.wgsl",
    "see.wgsl",
    "lattice.wgsl",
    "resolve.wgsl",
    "shared/point.wgsl",
    "shared/seen.wgsl",
    "shared/octree.wgsl",
    "shared/sobol.wgsl",
    "shared/hemisphere.wgsl",
    "shared/scene.wgsl",
    "shared/opacity.wgsl",
    "shared/trace.wgsl",
    "shared/points.wgsl",
    "shared/bundle.wgsl",
    "shared/place.wgsl",
    "shared/weighing.wgsl",
    "shared/cells.wgsl",
    "shared/likeness.wgsl",
    "shared/marks.wgsl",
    "shared/layer.wgsl",
    "shared/state.wgsl",
    "shared/sums.wgsl",
];

/// Entry points, by the names of their files.
pub fn entry_points() -> impl Iterator<Item = &'static str> {
    FILES.iter().map(|(file, _)| *file).filter(|file| !file.starts_with("shared/"))
}

/// The text of a shader: each line `//#include FILE` stands for that file, at its first mention.
///
/// # Panics
/// A file that does not exist, which the tests would have found.
pub fn source(name: &str) -> String {
    let (mut text, mut seen) = (String::new(), Vec::new());
    append(name, &mut text, &mut seen);
    text
}

fn append(name: &str, text: &mut String, seen: &mut Vec<String>) {
    if seen.iter().any(|known| known == name) {
        return;
    }
    seen.push(name.into());
    let (_, file) =
        FILES.iter().find(|(file, _)| *file == name).unwrap_or_else(|| panic!("there is no shader {name}"));
    for line in file.lines() {
        match line.strip_prefix("//#include ") {
            Some(other) => append(other.trim(), text, seen),
            None => {
                text.push_str(line);
                text.push('\n');
            }
        }
    }
}
