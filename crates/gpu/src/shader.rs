//! The shaders, with what they include put in its place.

/// Entry points, by the names of their files.
pub const SHADERS: [&str; 4] = ["rays.wgsl", "cones.wgsl", "cone_rays.wgsl", "bundles.wgsl"];

const FILES: [(&str, &str); 13] = [
    ("rays.wgsl", include_str!("../shaders/rays.wgsl")),
    ("cones.wgsl", include_str!("../shaders/cones.wgsl")),
    ("cone_rays.wgsl", include_str!("../shaders/cone_rays.wgsl")),
    ("bundles.wgsl", include_str!("../shaders/bundles.wgsl")),
    ("shared/point.wgsl", include_str!("../shaders/shared/point.wgsl")),
    ("shared/seen.wgsl", include_str!("../shaders/shared/seen.wgsl")),
    ("shared/octree.wgsl", include_str!("../shaders/shared/octree.wgsl")),
    ("shared/sobol.wgsl", include_str!("../shaders/shared/sobol.wgsl")),
    ("shared/hemisphere.wgsl", include_str!("../shaders/shared/hemisphere.wgsl")),
    ("shared/scene.wgsl", include_str!("../shaders/shared/scene.wgsl")),
    ("shared/opacity.wgsl", include_str!("../shaders/shared/opacity.wgsl")),
    ("shared/trace.wgsl", include_str!("../shaders/shared/trace.wgsl")),
    ("shared/points.wgsl", include_str!("../shaders/shared/points.wgsl")),
];

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
