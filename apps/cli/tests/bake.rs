//! `conray bake` as a program: exit codes, messages, files.

mod support;

use std::{fs, path::Path};
use support::{bake, command, err, folder, glb, out, refused};

/// A corner of three squares, laid out side by side, each square two triangles.
fn corner(folder: &Path) {
    let squares = [([0, 0, 1], [1, 0, 0]), ([1, 0, 0], [0, 1, 0]), ([0, 1, 0], [0, 0, 1])];
    let mut text = String::new();
    let mut faces = String::new();
    for (k, (u, v)) in squares.iter().enumerate() {
        for (a, b) in [(0, 0), (1, 0), (1, 1), (0, 1)] {
            let [x, y, z] = [0, 1, 2].map(|axis| a * u[axis] + b * v[axis]);
            text += &format!("v {x} {y} {z}\n");
            text += &format!("vt {} {}\n", 0.05 + 0.3 * (k as f32 + 0.9 * a as f32), 0.05 + 0.27 * b as f32);
        }
        let first = 4 * k + 1;
        let corner = |offset: usize| format!("{0}/{0}", first + offset);
        faces += &format!("f {} {} {} {}\n", corner(0), corner(1), corner(2), corner(3));
    }
    fs::write(folder.join("corner.obj"), text + &faces).unwrap();
}

#[test]
fn a_corner_becomes_a_map_that_is_dark_where_it_should_be() {
    let dir = folder();
    corner(dir.path());
    let words =
        ["corner.obj", "-o", "map.png", "--size", "64", "--rays", "256", "--distance", "inf", "--bits", "16"];
    let output = bake(&dir, &words);
    assert_eq!(output.status.code(), Some(0), "{}", err(&output));
    assert!(out(&output).contains("1 map of at most 64 x 64"), "{}", out(&output));
    let map = conray::target::read_png(dir.path().join("map.png")).unwrap();
    // OBJ has its first row at v = 1. The floor's texel at the edge between two walls sees less than the one across.
    let at = |u: f32, v: f32| map.values[((1.0 - v) * 64.0) as usize * 64 + (u * 64.0) as usize];
    let (inner, outer) = (at(0.06, 0.06), at(0.31, 0.31));
    assert!(inner < 0.4 && outer > 0.8, "{inner} {outer}");
    assert!(at(0.9, 0.95) > 0.0, "islands are extended over the whole map");
    // The same bytes again, whatever the threads.
    let first = fs::read(dir.path().join("map.png")).unwrap();
    bake(&dir, &[&words[..], &["--threads", "1"]].concat());
    assert_eq!(fs::read(dir.path().join("map.png")).unwrap(), first);
}

#[test]
fn a_model_gains_an_occlusion_texture() {
    let dir = folder();
    glb(dir.path(), "sail.glb", r#","TEXCOORD_0":1"#);
    let output = bake(&dir, &["sail.glb", "-o", "out.glb", "--size", "16x8", "--json"]);
    assert_eq!(output.status.code(), Some(0), "{}", err(&output));
    let summary: serde_json::Value = serde_json::from_str(out(&output).lines().last().unwrap()).unwrap();
    assert_eq!((&summary["event"], &summary["files"][0]), (&"summary".into(), &"out.glb".into()));
    let bytes = fs::read(dir.path().join("out.glb")).unwrap();
    let length = u32::from_le_bytes(bytes[12..16].try_into().unwrap()) as usize;
    let json: serde_json::Value = serde_json::from_slice(&bytes[20..20 + length]).unwrap();
    assert_eq!(json["materials"][0]["occlusionTexture"], serde_json::json!({"index": 0, "texCoord": 0}));
    assert_eq!(json["meshes"][0]["primitives"][0]["material"], 0);
    assert_eq!(json["extras"].to_string(), r#"{"kept":0.001}"#);
    let loaded = command(&dir, &["info", "out.glb"]).output().unwrap();
    assert_eq!(loaded.status.code(), Some(0), "{}", err(&loaded));
}

#[test]
fn requests_that_make_no_sense_are_refused_before_any_work() {
    let dir = folder();
    corner(dir.path());
    glb(dir.path(), "sail.glb", r#","TEXCOORD_0":1"#);
    let before = fs::read(dir.path().join("sail.glb")).unwrap();
    refused(&dir, &["sail.glb", "-o", "sail.glb"], 2, "it is the model itself");
    refused(&dir, &["sail.glb", "-o", "./sail.glb"], 2, "it is the model itself");
    refused(&dir, &["sail.glb", "-o", "out.gltf"], 2, "must end in .glb");
    refused(
        &dir,
        &["corner.obj", "-o", "out.glb"],
        2,
        "must end in .png, .exr, .ply or .obj: only glTF is written back",
    );
    refused(&dir, &["sail.glb", "-o", "out.tga"], 2, "must end in");
    refused(&dir, &["sail.glb", "-o", "nowhere/out.glb"], 1, "nowhere");
    for size in ["0", "100000", "axb"] {
        refused(&dir, &["sail.glb", "-o", "out.glb", "--size", size], 2, "expected texels from 1 to 16384");
    }
    refused(&dir, &["sail.glb", "-o", "out.glb", "--supersample", "0"], 2, "supersample");
    refused(&dir, &["missing.glb", "-o", "out.glb"], 3, "missing.glb");
    assert_eq!(fs::read(dir.path().join("sail.glb")).unwrap(), before);
    assert!(!dir.path().join("out.glb").exists());
}

#[test]
fn models_without_usable_uvs_are_told_by_name() {
    let dir = folder();
    glb(dir.path(), "bare.glb", "");
    refused(&dir, &["bare.glb", "-o", "out.glb", "--no-unwrap"], 3, "the first is sail: it has no UVs");
    fs::write(dir.path().join("broken.glb"), b"glTF\x02\0\0\0\xff\0\0\0").unwrap();
    refused(&dir, &["broken.glb", "-o", "out.glb"], 3, "broken.glb: it is cut short");
}
