//! What every loader must do with any input, for the fuzz targets and for the ordinary tests alike.

use conray_core::Opacity;
use conray_scene::{Extras, Format, Limits, Scene, SceneError, load_bytes_with};
use std::io;

/// Small enough that no input can slow the search down.
fn limits() -> Limits {
    Limits {
        max_file_bytes: 1 << 20,
        max_triangles: 100_000,
        max_vertices: 100_000,
        max_texture_pixels: 1 << 20,
        max_nodes: 10_000,
        max_node_depth: 100,
        max_instances: 10_000,
        ..Limits::default()
    }
}

/// Loads an input and checks what came out of it.
///
/// The input is the scene file; after the first byte FF, which no text has, follow the material file and after another one
/// the texture, for formats that name them.
pub(crate) fn check(format: Format, input: &[u8]) -> Result<(), SceneError> {
    let mut parts = input.splitn(if format == Format::Obj { 3 } else { 1 }, |&byte| byte == 0xff);
    let file = parts.next().unwrap_or_default();
    let (materials, texture) = (parts.next(), parts.next());
    let resolve = |name: &str| {
        let part = if name.ends_with(".mtl") { materials } else { texture };
        part.map(<[u8]>::to_vec).ok_or_else(|| io::ErrorKind::NotFound.into())
    };
    let extras = Extras { tangents: true, normal_maps: true };
    let load = || load_bytes_with("input", file, Some(format), &resolve, &limits(), extras);
    let scene = load()?;
    check_scene(&scene);
    assert_eq!(format!("{scene:?}"), format!("{:?}", load()?), "the same input gives the same scene");
    Ok(())
}

/// What holds of every scene that a loader returns.
fn check_scene(scene: &Scene) {
    let geometry = &scene.geometry;
    assert!(geometry.triangle_count() > 0);
    let bounds = geometry.bounds();
    assert!(bounds.min.is_finite() && bounds.max.is_finite(), "{bounds:?}");
    for mesh in geometry.meshes() {
        assert!(mesh.normals().is_empty() || mesh.normals().len() == mesh.positions().len());
        assert!(mesh.normals().iter().all(|n| (n.length() - 1.0).abs() < 1e-3));
        assert!(mesh.uv_sets().iter().flatten().all(|uv| uv.is_finite()));
        assert!(mesh.tangents().is_empty() || mesh.tangents().len() == mesh.normals().len());
        assert!(mesh.tangents().iter().all(|tangent| tangent.is_finite() && tangent.w.abs() == 1.0));
        assert!((mesh.material as usize) < geometry.materials().len().max(1));
    }
    for instance in geometry.instances() {
        assert!(instance.world_from_mesh.inverse().is_finite(), "{instance:?}");
    }
    for material in geometry.materials() {
        match &material.opacity {
            Opacity::Constant(opacity) => assert!((0.0..=1.0).contains(opacity)),
            Opacity::Texture(texture) => assert!((0.0..=1.0).contains(&texture.factor)),
        }
    }
    for view in &scene.views {
        assert!(view.eye.is_finite() && view.look_at.is_finite() && view.eye != view.look_at, "{view:?}");
        assert!(view.vertical_fov_deg > 0.0 && view.vertical_fov_deg < 180.0);
    }
    for warning in &scene.warnings {
        assert!(warning.count > 0 && warning.example.len() < 400, "{warning:?}");
    }
}
