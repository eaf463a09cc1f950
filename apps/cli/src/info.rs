//! `conray info`: what is in a scene and what is wrong with it.

mod devices;

use crate::{
    args::InfoArgs,
    failure::Failure,
    inputs,
    report::{self, bytes},
};
use conray::{AoSettings, Distance, Method, Opacity, Session, SessionOptions, scene::Scene};
use serde_json::{Value, json};
use std::time::Instant;

pub(crate) fn run(args: &InfoArgs) -> Result<(), Failure> {
    if args.devices {
        return devices::print(args.json);
    }
    let settings = AoSettings {
        method: Method::Cones,
        voxels: args.voxels,
        max_memory: args.max_memory,
        // Nothing is estimated here; a scene without extent has no automatic distance.
        distance: Distance::Infinite,
        ..AoSettings::default()
    };
    settings.validate().map_err(|e| Failure::Request(e.to_string()))?;
    let start = Instant::now();
    let mut scene = inputs::load_scene(args.scene.as_deref().unwrap_or_default())?;
    let load_seconds = start.elapsed().as_secs_f64();
    scene.inspect();
    let options = SessionOptions { threads: args.threads, ..SessionOptions::default() };
    let geometry = std::mem::take(&mut scene.geometry);
    let session = Session::build_observed(geometry, &settings, &options, &|_| {})?;
    let facts = facts(&scene, &session, load_seconds);
    report::print_lines(&if args.json {
        vec![format!("{facts:#}")]
    } else {
        lines(&scene, &session, &facts)
    });
    Ok(())
}

fn facts(scene: &Scene, session: &Session, load_seconds: f64) -> Value {
    let (geometry, bounds, built) = (session.geometry(), session.bounds(), session.report());
    let stats = session.octree().map(|octree| octree.stats());
    json!({
        "name": scene.name,
        "load_seconds": load_seconds,
        "triangles": geometry.triangle_count(),
        "stored_triangles": geometry.stored_triangle_count(),
        "meshes": geometry.meshes().len(),
        "instances": geometry.instances().len(),
        "bounds": { "min": bounds.min.to_array(), "max": bounds.max.to_array() },
        "auto_distance": Distance::Auto.in_world(bounds.diagonal()),
        "materials": geometry.materials().iter().map(|material| json!({
            "name": material.name,
            "opacity": opacity_name(&material.opacity),
            "double_sided": material.double_sided,
        })).collect::<Vec<_>>(),
        "views": scene.views.iter().map(|view| json!({
            "name": view.name, "eye": view.eye.to_array(), "look_at": view.look_at.to_array(),
            "up": view.up.to_array(), "vertical_fov_deg": view.vertical_fov_deg,
        })).collect::<Vec<_>>(),
        "defects": scene.warnings.iter().map(|warning| json!({
            "kind": format!("{:?}", warning.kind), "count": warning.count, "example": warning.example,
            "message": warning.to_string(),
        })).collect::<Vec<_>>(),
        "bvh": { "seconds": built.bvh_seconds, "bytes": built.bvh_bytes },
        "octree": {
            "seconds": built.octree_seconds, "bytes": built.octree_bytes, "voxels": built.voxels,
            "estimated_peak_bytes": session.estimate_octree_bytes(built.voxels),
            "leaves": stats.as_ref().map(|s| s.occupied.first().copied()), "voxel_size": stats.as_ref().map(|s| s.voxel_size),
        },
        "peak_memory_bytes": report::peak_memory(),
    })
}

fn opacity_name(opacity: &Opacity) -> String {
    match opacity {
        Opacity::Constant(value) if *value >= 1.0 => "opaque".into(),
        Opacity::Constant(value) => format!("{value}"),
        Opacity::Texture(texture) => {
            let size = format!("{} x {} texels", texture.texture.width(), texture.texture.height());
            texture.cutoff.map_or(format!("texture of {size}"), |c| format!("mask of {size}, cutoff {c}"))
        }
    }
}

fn lines(scene: &Scene, session: &Session, facts: &Value) -> Vec<String> {
    let (geometry, bounds, built) = (session.geometry(), session.bounds(), session.report());
    let masked: Vec<String> = geometry
        .materials()
        .iter()
        .filter(|m| !m.opacity.is_opaque())
        .map(|m| format!("{} ({})", m.name, opacity_name(&m.opacity)))
        .collect();
    let mut lines = vec![
        format!("{}: loaded in {:.2} s", scene.name, facts["load_seconds"].as_f64().unwrap_or(0.0)),
        format!(
            "{} triangles ({} stored), {} meshes, {} instances",
            geometry.triangle_count(),
            geometry.stored_triangle_count(),
            geometry.meshes().len(),
            geometry.instances().len()
        ),
        format!(
            "bounds {} to {}; automatic AO distance {}",
            bounds.min,
            bounds.max,
            Distance::Auto.in_world(bounds.diagonal())
        ),
        format!("{} materials, {} not opaque", geometry.materials().len(), masked.len()),
    ];
    lines.extend(masked.into_iter().map(|material| format!("  {material}")));
    for view in &scene.views {
        lines.push(format!(
            "view {}: from {} to {}, {} degrees",
            view.name, view.eye, view.look_at, view.vertical_fov_deg
        ));
    }
    lines.push(format!("BVH {:.2} s, {}", built.bvh_seconds, bytes(built.bvh_bytes)));
    lines.push(format!(
        "octree of {} voxels, estimated {}: {:.2} s, {}, {} leaves",
        built.voxels,
        bytes(facts["octree"]["estimated_peak_bytes"].as_u64().unwrap_or(0)),
        built.octree_seconds,
        bytes(built.octree_bytes),
        facts["octree"]["leaves"]
    ));
    if scene.warnings.is_empty() {
        lines.push("no defects found".into());
    }
    lines.extend(scene.warnings.iter().map(|warning| format!("defect: {warning}")));
    lines
}
