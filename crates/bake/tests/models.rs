//! Baked models on a disc: what is written beside what, and what other readers make of it.

use conray::{AoSettings, Control, Session};
use conray_bake::{
    Document, Facing, Look, MapExtent, MapOptions, Origins, Places, PngOptions, Sheets, Unwrap, Written,
    bake_maps, write_model,
};
use conray_scene::{Limits, load};
use conray_target::{MapSize, PngDepth};
use std::{
    fs,
    path::{Path, PathBuf},
};

/// Two quads at a right angle, by one mesh that two nodes show, in a text document with a buffer beside it and an image that is not there.
fn write_source(folder: &Path) -> PathBuf {
    let positions: [[f32; 3]; 4] = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]];
    let uvs: [[f32; 2]; 4] = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
    let mut bin: Vec<u8> =
        positions.iter().flatten().chain(uvs.iter().flatten()).flat_map(|x| x.to_le_bytes()).collect();
    bin.extend([0u16, 1, 2, 0, 2, 3].iter().flat_map(|x| x.to_le_bytes()));
    fs::write(folder.join("a quad.bin"), &bin).unwrap();
    let text = r#"{"asset":{"version":"2.0","generator":"by hand"},"scene":0,"scenes":[{"nodes":[0,1]}],
        "nodes":[{"mesh":0},{"mesh":0,"rotation":[-0.70710678,0,0,0.70710678],"translation":[0,0,1.0]}],
        "meshes":[{"primitives":[{"attributes":{"POSITION":0,"TEXCOORD_0":1},"indices":2,"material":0}]}],
        "materials":[{"name":"two/sided","emissiveTexture":{"index":0}}],"textures":[{"source":0}],
        "images":[{"uri":"missing.png"}],"extras":{"kept":0.01},
        "buffers":[{"uri":"a%20quad.bin","byteLength":92}],
        "bufferViews":[{"buffer":0,"byteLength":48},{"buffer":0,"byteOffset":48,"byteLength":32},
            {"buffer":0,"byteOffset":80,"byteLength":12}],
        "accessors":[{"bufferView":0,"componentType":5126,"count":4,"type":"VEC3","min":[0,0,0],"max":[1,1,0]},
            {"bufferView":1,"componentType":5126,"count":4,"type":"VEC2"},
            {"bufferView":2,"componentType":5123,"count":6,"type":"SCALAR"}]}"#;
    let path = folder.join("quad.gltf");
    fs::write(&path, text).unwrap();
    path
}

fn bake(source: &Path, to: &Path) -> Written {
    bake_packed(source, to, false)
}

fn bake_packed(source: &Path, to: &Path, packs: bool) -> Written {
    let scene = load(source, &Limits::default()).unwrap();
    let settings = AoSettings { rays: Some(64), ..AoSettings::default() };
    let instances: Vec<u32> = (0..scene.geometry.instances().len() as u32).collect();
    let sheets = Sheets::of(
        &scene.geometry,
        &instances,
        MapExtent::Size(MapSize { width: 16, height: 16 }),
        Unwrap::Yes,
    );
    let session = Session::build(scene.geometry, &settings).unwrap();
    let places = Places::of(session.geometry(), &sheets, false, 1, Facing::default());
    let budget = session.plan().budget;
    let baked =
        bake_maps(&session, &[], &places, budget, &MapOptions::default(), Control::none(), &mut |_| {})
            .unwrap();
    let document = Document::open(&fs::read(source).unwrap()).unwrap();
    let vertices: Vec<&[u32]> = session
        .geometry()
        .instances()
        .iter()
        .map(|instance| &scene.sources[instance.mesh as usize][..])
        .collect();
    let png = PngOptions { depth: PngDepth::Eight, look: Look::default(), packs };
    let origins = Origins { instances: &scene.origins, vertices: &vertices };
    write_model(to, source, document, &origins, &sheets, &baked.maps, png).unwrap()
}

fn names(written: &Written) -> Vec<String> {
    written.files.iter().map(|path| path.file_name().unwrap().to_string_lossy().into_owned()).collect()
}

#[test]
fn a_model_in_another_folder_has_its_files_beside_it() {
    let (from, to) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
    let source = write_source(from.path());
    let out = to.path().join("baked.gltf");
    let written = bake(&source, &out);
    let expected = ["a quad.bin", "baked-two-sided-0-ao.png", "baked-two-sided-1-ao.png", "baked.gltf"]
        .map(String::from);
    assert_eq!(names(&written), expected);
    assert_eq!(written.not_copied, ["missing.png"]);
    let scene = load(&out, &Limits::default()).unwrap();
    assert_eq!(scene.geometry.triangle_count(), 4);
    let document = Document::open(&fs::read(&out).unwrap()).unwrap();
    assert_eq!(document.root()["extras"].to_string(), r#"{"kept":0.01}"#);
    // The two nodes show different maps, which are dark where they meet.
    let map = |name: &str| conray_target::read_png(to.path().join(name)).unwrap();
    let (standing, lying) = (map(&expected[1]), map(&expected[2]));
    let row = |values: &[f32], y: usize| values[y * 16..][..16].iter().sum::<f32>() / 16.0;
    assert!(row(&standing.values, 0) < 0.75 && row(&standing.values, 15) > 0.9, "{:?}", standing.values);
    assert!(standing.values != lying.values);
}

#[test]
fn a_model_in_its_own_folder_shares_the_files_that_are_there() {
    let folder = tempfile::tempdir().unwrap();
    let source = write_source(folder.path());
    let before = fs::read(&source).unwrap();
    let written = bake(&source, &folder.path().join("baked.gltf"));
    assert_eq!(names(&written).len(), 3, "{:?}", names(&written));
    assert_eq!(fs::read(&source).unwrap(), before);
}

#[test]
fn a_surface_without_uvs_gets_vertices_with_new_ones() {
    let folder = tempfile::tempdir().unwrap();
    let source = write_source(folder.path());
    // Without its UVs, and with a colour for each vertex in their place: that must follow the vertices.
    let text = fs::read_to_string(&source).unwrap();
    fs::write(&source, text.replace(r#""TEXCOORD_0":1"#, r#""_MARK":1"#)).unwrap();
    let out = folder.path().join("baked.gltf");
    let written = bake(&source, &out);
    assert_eq!(names(&written), ["baked-two-sided-ao.png", "baked-ao.bin", "baked.gltf"]);
    let (before, after) =
        (load(&source, &Limits::default()).unwrap(), load(&out, &Limits::default()).unwrap());
    assert_eq!(after.geometry.meshes().len(), 2, "the two nodes read different parts of the map");
    for (instance, other) in after.geometry.instances().iter().zip(before.geometry.instances()) {
        let mesh = &after.geometry.meshes()[instance.mesh as usize];
        let same = &before.geometry.meshes()[other.mesh as usize];
        assert_eq!(mesh.uv_sets().len(), 1);
        assert!((0..2).all(|triangle| mesh.corners(triangle) == same.corners(triangle)));
    }
    let document = Document::open(&fs::read(&out).unwrap()).unwrap();
    let primitive = &document.root()["meshes"][0]["primitives"][0];
    let mark = primitive["attributes"]["_MARK"].as_u64().unwrap() as usize;
    assert_eq!(document.element("accessors", mark).unwrap()["count"], 4);
    let bin = fs::read(folder.path().join("baked-ao.bin")).unwrap();
    let view = &document.root()["bufferViews"]
        [document.element("accessors", mark).unwrap()["bufferView"].as_u64().unwrap() as usize];
    let offset = view["byteOffset"].as_u64().unwrap() as usize;
    let first = f32::from_le_bytes(bin[offset..offset + 4].try_into().unwrap());
    assert!([0.0, 1.0].contains(&first), "a value of the vertex that it was");
    assert_eq!(document.root()["materials"][0]["occlusionTexture"]["texCoord"], 0);
}

/// The quads with an image of 2 x 2 texels for roughness and metalness.
fn write_rough(folder: &Path, info: &str) -> PathBuf {
    let source = write_source(folder);
    let image =
        image::RgbImage::from_fn(2, 2, |x, y| image::Rgb([9, 40 + 100 * x as u8, 200 - 90 * y as u8]));
    image.save(folder.join("rough.png")).unwrap();
    let text = fs::read_to_string(&source).unwrap();
    let text = text.replace("missing.png", "rough.png").replace(
        r#""emissiveTexture":{"index":0}"#,
        &format!(r#""pbrMetallicRoughness":{{"metallicRoughnessTexture":{{"index":0{info}}}}}"#),
    );
    fs::write(&source, text).unwrap();
    source
}

#[test]
fn occlusion_is_packed_with_roughness_and_metalness() {
    let folder = tempfile::tempdir().unwrap();
    let source = write_rough(folder.path(), "");
    let (plain, out) = (folder.path().join("plain.gltf"), folder.path().join("packed.gltf"));
    bake(&source, &plain);
    let written = bake_packed(&source, &out, true);
    assert!(written.not_packed.is_empty(), "{:?}", written.not_packed);
    let document = Document::open(&fs::read(&out).unwrap()).unwrap();
    for (k, material) in document.root()["materials"].as_array().unwrap().iter().enumerate().skip(1) {
        let shown = &material["occlusionTexture"]["index"];
        assert_eq!(shown, &material["pbrMetallicRoughness"]["metallicRoughnessTexture"]["index"], "{k}");
        let texture = &document.root()["textures"][shown.as_u64().unwrap() as usize];
        assert!(texture.get("sampler").is_none(), "as the one before");
    }
    for k in 0..2 {
        let packed =
            image::open(folder.path().join(format!("packed-two-sided-{k}-orm.png"))).unwrap().into_rgb8();
        let alone =
            conray_target::read_png(folder.path().join(format!("plain-two-sided-{k}-ao.png"))).unwrap();
        assert_eq!(packed.dimensions(), (16, 16));
        for (texel, value) in packed.pixels().zip(&alone.values) {
            assert!((f32::from(texel.0[0]) / 255.0 - value).abs() < 1e-3);
        }
        // Enlarged: the corners are those of the image before.
        assert_eq!((packed[(0, 0)].0[1], packed[(15, 15)].0[1]), (40, 140));
        assert_eq!((packed[(0, 0)].0[2], packed[(15, 15)].0[2]), (200, 110));
    }
}

#[test]
fn what_cannot_be_packed_is_told_and_stands_alone() {
    let cases = [
        (r#","texCoord":1"#, "other UVs"),
        (r#","extensions":{"KHR_texture_transform":{"scale":[2,2]}}"#, "transformed"),
    ];
    for (info, reason) in cases {
        let folder = tempfile::tempdir().unwrap();
        let source = write_rough(folder.path(), info);
        let written = bake_packed(&source, &folder.path().join("out.gltf"), true);
        assert_eq!(written.not_packed.len(), 2);
        assert!(written.not_packed[0].contains(reason), "{:?}", written.not_packed);
        assert!(folder.path().join("out-two-sided-0-ao.png").exists());
    }
    let folder = tempfile::tempdir().unwrap();
    let source = write_rough(folder.path(), "");
    fs::write(folder.path().join("rough.png"), b"no image").unwrap();
    let written = bake_packed(&source, &folder.path().join("out.gltf"), true);
    assert!(written.not_packed[0].contains("cannot be read"), "{:?}", written.not_packed);
}
