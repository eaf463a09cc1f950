//! Options of `conray bake`: each does what it says, in the files that come out.

mod support;

use std::{fs, path::Path};
use support::{bake, command, err, folder, glb, out, refused};
use tempfile::TempDir;

/// A floor of 1 x 1 that faces up, in the left half of the map, and above it, at a height of 0.25, a lid that is as large and faces up too, in the right half.
fn floor_and_lid(folder: &Path) {
    let mut text = String::new();
    for (name, y, left, first) in [("floor", 0.0, 0.05, 1), ("lid", 0.25, 0.55, 5)] {
        text += &format!("o {name}\n");
        for (x, z) in [(0.0, 0.0), (0.0, 1.0), (1.0, 1.0), (1.0, 0.0)] {
            text += &format!("v {x} {y} {z}\nvt {} {}\n", left + 0.4 * x, 0.05 + 0.9 * z);
        }
        text += &format!("f {0}/{0} {1}/{1} {2}/{2} {3}/{3}\n", first, first + 1, first + 2, first + 3);
    }
    fs::write(folder.join("pair.obj"), text).unwrap();
}

/// Bakes the pair and tells the visibility in the middle of the floor and of the lid.
fn middles(dir: &TempDir, words: &[&str]) -> [f32; 2] {
    let common =
        ["pair.obj", "-o", "m.png", "--size", "64", "--rays", "256", "--bits", "16", "--distance", "4"];
    let output = bake(dir, &[&common[..], words].concat());
    assert_eq!(output.status.code(), Some(0), "{words:?}: {}", err(&output));
    let map = conray::target::read_png(dir.path().join("m.png")).unwrap();
    [16, 48].map(|x| map.values[32 * 64 + x])
}

#[test]
fn patterns_and_objects_say_what_occludes() {
    let dir = folder();
    floor_and_lid(dir.path());
    // The middle of a square under one as large, at a quarter of its side (four corners of a rectangle parallel to an element: Howell, "A Catalog of
    // Radiation Heat Transfer Configuration Factors", B-3, with a = b = 2).
    let p = 5f32.sqrt();
    let covered = 4.0 * 2.0 * (2.0 / p * (2.0 / p).atan()) / std::f32::consts::TAU;
    let near = |found: [f32; 2], floor: f32, lid: f32| {
        assert!((found[0] - floor).abs() < 0.01 && (found[1] - lid).abs() < 0.01, "{found:?}: {floor} {lid}");
    };
    near(middles(&dir, &[]), 1.0 - covered, 1.0);
    near(middles(&dir, &["--occluders", "fl*"]), 1.0, 1.0);
    near(middles(&dir, &["--occluders", "floor", "--occluders", "l?d"]), 1.0 - covered, 1.0);
    near(middles(&dir, &["--self-only"]), 1.0, 1.0);
    near(middles(&dir, &["--ignore-backfaces", "all"]), 1.0, 1.0);
    // An OBJ does not say which sides are seen: both.
    near(middles(&dir, &["--ignore-backfaces"]), 1.0 - covered, 1.0);
    // The lid looks down at the floor, the floor at the ground that is there.
    near(middles(&dir, &["--inside"]), 1.0, 1.0 - covered);
    let grounded = middles(&dir, &["--inside", "--ground"]);
    assert!(grounded[0] < 0.01, "the floor lies on it: {grounded:?}");
    let low = middles(&dir, &["--inside", "--ground", "-100"]);
    assert!(low[0] > 0.99, "beyond the distance: {low:?}");
    refused(&dir, &["pair.obj", "-o", "m.png", "--receivers", "Lid"], 2, "there are floor, lid");
    refused(&dir, &["pair.obj", "-o", "m.png", "--ground", "deep"], 2, "height");
    let voxels = ["pair.obj", "-o", "m.png", "--ignore-backfaces", "all", "--method", "cones"];
    refused(&dir, &voxels, 2, "voxels have no backs");
}

#[test]
fn only_receivers_are_baked() {
    let dir = folder();
    floor_and_lid(dir.path());
    let words = ["pair.obj", "-o", "m.exr", "--size", "64", "--rays", "16", "--receivers", "lid"];
    let output = bake(&dir, &words);
    assert_eq!(output.status.code(), Some(0), "{}", err(&output));
    let layers = conray::target::read_exr_channels(dir.path().join("m.exr")).unwrap();
    let coverage = layers.channel("A").unwrap();
    assert_eq!([16, 48].map(|x| coverage[32 * 64 + x]), [0.0, 1.0]);
    assert!(layers.channel("error").unwrap()[32 * 64 + 48] < 0.2);
}

#[test]
fn looks_change_pictures_and_not_the_truth() {
    let dir = folder();
    floor_and_lid(dir.path());
    let [plain, _] = middles(&dir, &[]);
    let [found, _] = middles(&dir, &["--intensity", "0.5", "--power", "2"]);
    assert!((found - (1.0 - 0.5 * (1.0 - plain)).powi(2)).abs() < 1e-3, "{found} of {plain}");
    let exr = |name: &str, more: &[&str]| {
        let words = ["pair.obj", "-o", name, "--size", "32", "--rays", "16"];
        assert_eq!(bake(&dir, &[&words[..], more].concat()).status.code(), Some(0));
        conray::target::read_exr_channels(dir.path().join(name)).unwrap().channel("R").map(<[f32]>::to_vec)
    };
    assert_eq!(exr("a.exr", &[]), exr("b.exr", &["--intensity", "3"]));
    refused(&dir, &["pair.obj", "-o", "m.png", "--power", "-1"], 2, "from 0 to 10");
}

#[test]
fn bent_directions_lean_away_from_what_is_near() {
    let dir = folder();
    floor_and_lid(dir.path());
    let words =
        ["pair.obj", "-o", "m.png", "--size", "64", "--rays", "256", "--distance", "4", "--bent-normals"];
    let output = bake(&dir, &words);
    assert_eq!(output.status.code(), Some(0), "{}", err(&output));
    assert!(out(&output).contains("m-bent.png"), "{}", out(&output));
    let bent = image(&dir.path().join("m-bent.png"));
    // The floor's rim at x = 0 sees out to that side; the lid straight up.
    let at = |x: usize| bent[32 * 64 + x];
    assert!(at(4)[0] < 110 && at(28)[0] > 145, "{:?} {:?}", at(4), at(28));
    assert!(at(48)[1] > 250, "{:?}", at(48));
    // The rim at z = 1 is at the top of the picture.
    for (space, green) in [("tangent", 145..=255u8), ("tangent-dx", 0..=110)] {
        let output = bake(&dir, &[&words[..], &[space]].concat());
        assert_eq!(output.status.code(), Some(0), "{}", err(&output));
        let bent = image(&dir.path().join("m-bent.png"));
        let [rim, top, lid] = [32 * 64 + 4, 5 * 64 + 16, 32 * 64 + 48].map(|at| bent[at]);
        assert!(rim[0] < 110 && lid[2] > 250 && green.contains(&top[1]), "{space} {rim:?} {top:?} {lid:?}");
    }
}

fn image(path: &Path) -> Vec<[u8; 3]> {
    let mut reader =
        png::Decoder::new(std::io::BufReader::new(fs::File::open(path).unwrap())).read_info().unwrap();
    let mut bytes = vec![0; reader.output_buffer_size().unwrap()];
    reader.next_frame(&mut bytes).unwrap();
    bytes.as_chunks::<3>().0.to_vec()
}

#[test]
fn a_dry_run_tells_and_writes_nothing() {
    let dir = folder();
    floor_and_lid(dir.path());
    let output = bake(&dir, &["pair.obj", "-o", "m.png", "--size", "128x64", "--rays", "16", "--dry-run"]);
    assert_eq!(output.status.code(), Some(0), "{}", err(&output));
    for part in ["128 x 64", "2 surfaces of 4 triangles by UV set 0", "memory: about", "time of estimation"] {
        assert!(out(&output).contains(part), "{part}: {}", out(&output));
    }
    assert!(!dir.path().join("m.png").exists());
    refused(&dir, &["pair.obj", "-o", "m.png", "--size", "2048", "--max-memory", "1M"], 2, "--max-memory");
}

#[test]
fn less_memory_gives_the_same_map_within_its_error() {
    let dir = folder();
    floor_and_lid(dir.path());
    let bake = |name: &str, more: &[&str]| {
        let words =
            ["pair.obj", "-o", name, "--size", "512", "--rays", "64", "--bits", "16", "--distance", "4"];
        let output = bake(&dir, &[&words[..], more].concat());
        assert_eq!(output.status.code(), Some(0), "{}", err(&output));
        (conray::target::read_png(dir.path().join(name)).unwrap().values, out(&output))
    };
    let (whole, _) = bake("a.png", &["--explain"]);
    let (parts, told) = bake("b.png", &["--max-memory", "40M", "--explain"]);
    assert!(told.contains("part 2 of"), "{told}");
    let squares: f32 = whole.iter().zip(&parts).map(|(a, b)| (a - b).powi(2)).sum();
    let rms = (squares / whole.len() as f32).sqrt();
    assert!(rms > 0.0 && rms < 0.02, "{rms}");
}

#[test]
fn a_preview_ends_as_the_map() {
    let dir = folder();
    floor_and_lid(dir.path());
    let words = ["pair.obj", "-o", "m.png", "--size", "64", "--rays", "64", "--distance", "4"];
    let output = bake(&dir, &[&words[..], &["--preview", "p.png"]].concat());
    assert_eq!(output.status.code(), Some(0), "{}", err(&output));
    assert_eq!(fs::read(dir.path().join("p.png")).unwrap(), fs::read(dir.path().join("m.png")).unwrap());
    refused(&dir, &[&words[..], &["--preview", "m.png"]].concat(), 2, "is the output too");
    refused(&dir, &[&words[..], &["--preview", "p.jpg"]].concat(), 2, "must end in .png, for maps");
    refused(&dir, &[&words[..], &["--preview", "nowhere/p.png"]].concat(), 1, "nowhere");
}

#[cfg(unix)]
#[test]
fn a_preview_is_there_before_the_work_ends() {
    let dir = folder();
    floor_and_lid(dir.path());
    let words =
        ["pair.obj", "-o", "m.png", "--size", "64", "--rays", "1000000", "--method", "rays", "--json"];
    let command = command(&dir, &[&["bake"], &words[..], &["--preview", "p.png"]].concat());
    let output = support::interrupted(command, r#""event":"progress""#);
    assert_eq!(output.status.code(), Some(1), "{}", err(&output));
    assert!(err(&output).contains("interrupted"), "{}", err(&output));
    assert!(dir.path().join("p.png").exists() && dir.path().join("m.png").exists());
}

/// Stops a bake into a folder of kept work, goes on, and compares with an unbroken one.
#[cfg(unix)]
fn resumes(dir: &TempDir, ending: &str, options: &[&str]) {
    let [broken, whole] = ["a", "b"].map(|stem| format!("{stem}.{ending}"));
    let work = format!("work-{ending}-{}", options.len());
    let words = |out: &str, state: &[&str]| {
        let words = ["bake", "pair.obj", "-o", out, "--distance", "4", "--json"];
        command(dir, &[&words, options, state].concat())
    };
    let state = ["--state", &work];
    let stopped = support::interrupted(words(&broken, &state), r#""event":"progress""#);
    assert_eq!(stopped.status.code(), Some(1), "{}", err(&stopped));
    assert!(fs::read_dir(dir.path().join(&work)).unwrap().count() > 0);
    for (out, state) in [(&broken, &state[..]), (&whole, &[])] {
        let done = words(out, state).output().unwrap();
        assert_eq!(done.status.code(), Some(0), "{}", err(&done));
    }
    let bytes = |name: &str| fs::read(dir.path().join(name)).unwrap();
    assert!(bytes(&broken) == bytes(&whole), "{options:?}");
}

#[cfg(unix)]
#[test]
fn interrupted_and_resumed_bakes_give_the_bits_of_unbroken_ones() {
    let dir = folder();
    floor_and_lid(dir.path());
    let maps = ["--size", "96", "--rays", "4096", "--bits", "16"];
    resumes(&dir, "png", &[&maps[..], &["--max-memory", "16M"]].concat());
    resumes(&dir, "png", &[&maps[..], &["--self-only"]].concat());
    let vertices = ["--samples-per-triangle", "256", "--rays", "32768"];
    resumes(&dir, "ply", &vertices);
    resumes(&dir, "ply", &[&vertices[..], &["--self-only"]].concat());
}

#[test]
fn options_that_would_do_nothing_are_refused() {
    let dir = folder();
    floor_and_lid(dir.path());
    let kept = ["pair.obj", "-o", "c.png", "--size", "96", "--rays", "4", "--state", "work"];
    assert_eq!(bake(&dir, &kept).status.code(), Some(0));
    let other =
        ["pair.obj", "-o", "c.png", "--size", "96", "--distance", "3", "--rays", "64", "--state", "work"];
    refused(&dir, &other, 2, "--state");
    refused(&dir, &[&other[..], &["--method", "rays"]].concat(), 2, "needs --method hybrid");
    refused(&dir, &["pair.obj", "-o", "v.ply", "--size", "64"], 2, "--size: is for maps");
    refused(&dir, &["pair.obj", "-o", "m.png", "--smoothness", "1"], 2, "--smoothness: is for vertices");
    refused(&dir, &["pair.obj", "-o", "m.png", "--pack"], 2, "--pack: is for glTF alone");
    refused(&dir, &["pair.obj", "-o", "m.exr", "--bits", "16"], 2, "an EXR has 32");
    refused(
        &dir,
        &["pair.obj", "-o", "v.ply", "--max-memory", "20K", "--samples-per-triangle", "200"],
        2,
        "--max-memory: the points need",
    );
}

#[test]
fn several_models_go_into_a_folder_and_one_that_fails_stops_no_other() {
    let dir = folder();
    floor_and_lid(dir.path());
    glb(dir.path(), "sail.glb", r#","TEXCOORD_0":1"#);
    fs::write(dir.path().join("broken.glb"), b"no model").unwrap();
    fs::create_dir(dir.path().join("out")).unwrap();
    let common = ["-o", "out", "--size", "32", "--rays", "16"];
    let output = bake(&dir, &[&["pair.obj", "sail.glb"], &common[..]].concat());
    assert_eq!(output.status.code(), Some(0), "{}", err(&output));
    assert!(dir.path().join("out/pair.png").exists() && dir.path().join("out/sail.glb").exists());
    fs::remove_file(dir.path().join("out/sail.glb")).unwrap();
    let output = bake(&dir, &[&["broken.glb", "sail.glb"], &common[..]].concat());
    assert_eq!(output.status.code(), Some(3), "{}", err(&output));
    let told = err(&output);
    assert!(told.contains("broken.glb") && told.contains("1 of 2 models were not baked"), "{told}");
    assert!(dir.path().join("out/sail.glb").exists());
    refused(&dir, &["pair.obj", "sail.glb", "-o", "nowhere"], 2, "must be a folder that is there");
    refused(&dir, &["sail.glb", "./sail.glb", "-o", "out"], 2, "two of the models would both be");
}

#[test]
fn a_job_is_replayed_to_the_bit() {
    let dir = folder();
    floor_and_lid(dir.path());
    let words = [
        "pair.obj",
        "-o",
        "m.png",
        "--size",
        "32",
        "--rays",
        "16",
        "--occluders",
        "lid",
        "--distance",
        "4",
        "--seed",
        "7",
        "--json",
    ];
    let output = bake(&dir, &words);
    let summary: serde_json::Value = serde_json::from_str(out(&output).lines().last().unwrap()).unwrap();
    let first = fs::read(dir.path().join("m.png")).unwrap();
    fs::write(dir.path().join("job.json"), summary["job"].to_string()).unwrap();
    let again = bake(&dir, &["--job", "job.json", "-o", "again.png"]);
    assert_eq!(again.status.code(), Some(0), "{}", err(&again));
    assert_eq!(fs::read(dir.path().join("again.png")).unwrap(), first);
    let other = bake(&dir, &["--job=job.json", "-o", "other.png", "--seed", "8"]);
    assert_eq!(other.status.code(), Some(0), "{}", err(&other));
    assert_ne!(fs::read(dir.path().join("other.png")).unwrap(), first);
    fs::write(dir.path().join("odd.json"), r#"{"sizes": 3}"#).unwrap();
    refused(&dir, &["--job", "odd.json"], 3, "there is no option sizes");
    fs::write(dir.path().join("bad.json"), "[").unwrap();
    refused(&dir, &["--job", "bad.json"], 3, "it is no JSON object");
    refused(&dir, &["--job", "none.json"], 3, "cannot be read");
}

#[test]
fn every_option_is_listed() {
    let dir = folder();
    let output = bake(&dir, &["--options", "json"]);
    assert_eq!(output.status.code(), Some(0), "{}", err(&output));
    let options: Vec<serde_json::Value> = serde_json::from_str(&out(&output)).unwrap();
    let help = out(&bake(&dir, &["--help"]));
    for option in &options {
        let name = option["name"].as_str().unwrap();
        assert!(help.contains(&format!("--{name}")) || ["model"].contains(&name), "{name}");
        assert!(!option["help"].as_str().unwrap().is_empty(), "{name}");
    }
    let find = |name: &str| options.iter().find(|option| option["name"] == name).unwrap();
    assert_eq!(
        (&find("size")["default"], &find("normal")["values"][1]),
        (&"1024".into(), &"geometric".into())
    );
    assert_eq!((&find("receivers")["kind"], &find("shared")["kind"]), (&"list".into(), &"flag".into()));
}

#[test]
fn vertices_carry_values_where_that_is_wanted() {
    let dir = folder();
    floor_and_lid(dir.path());
    let words = ["pair.obj", "--rays", "256", "--distance", "4"];
    let output = bake(&dir, &[&words[..], &["-o", "v.ply"]].concat());
    assert_eq!(output.status.code(), Some(0), "{}", err(&output));
    assert!(out(&output).contains("8 values"), "{}", out(&output));
    let text = fs::read(dir.path().join("v.ply")).unwrap();
    assert!(String::from_utf8_lossy(&text).contains("property float visibility"));
    let loaded = command(&dir, &["info", "v.ply"]).output().unwrap();
    assert!(out(&loaded).contains("4 triangles"), "{}", out(&loaded));
    glb(dir.path(), "sail.glb", r#","TEXCOORD_0":1"#);
    for (attribute, name) in [("color", "COLOR_0"), ("multiply", "COLOR_0"), ("ao", "_AO")] {
        let output = bake(&dir, &["sail.glb", "--to", "vertex", "-o", "v.glb", "--attribute", attribute]);
        assert_eq!(output.status.code(), Some(0), "{}", err(&output));
        let bytes = fs::read(dir.path().join("v.glb")).unwrap();
        let length = u32::from_le_bytes(bytes[12..16].try_into().unwrap()) as usize;
        let json: serde_json::Value = serde_json::from_slice(&bytes[20..20 + length]).unwrap();
        assert!(json["meshes"][0]["primitives"][0]["attributes"][name].is_u64(), "{json}");
    }
    refused(&dir, &["sail.glb", "-o", "v.png", "--to", "vertex"], 2, "images hold no vertices");
    refused(&dir, &["sail.glb", "-o", "v.ply", "--to", "texture"], 2, "no maps go into .ply");
    refused(&dir, &["sail.glb", "-o", "v.ply", "--smoothness", "-1"], 2, "smoothness");
}

#[test]
fn normals_of_normal_maps_count_where_that_is_wanted() {
    // The floor's normals lean by an angle whose cosine is 0.7: an open floor then sees 0.85.
    let dir = folder();
    floor_and_lid(dir.path());
    let path = dir.path().join("pair.obj");
    let text = fs::read_to_string(&path).unwrap();
    fs::write(&path, format!("mtllib pair.mtl\nusemtl leaning\n{text}")).unwrap();
    fs::write(dir.path().join("pair.mtl"), "newmtl leaning\nnorm n.png\n").unwrap();
    let mut image = Vec::new();
    let leaning = [[0.5 + 0.5 * 0.51f32.sqrt(), 0.5, 0.85]];
    conray::target::encode_colour_png(&mut image, 1, 1, &leaning, conray::target::PngDepth::Eight).unwrap();
    fs::write(dir.path().join("n.png"), image).unwrap();
    let open = ["--occluders", "floor"];
    assert!((middles(&dir, &open)[0] - 1.0).abs() < 0.005);
    let mapped = middles(&dir, &[&open[..], &["--normal", "mapped"]].concat());
    assert!((mapped[0] - 0.85).abs() < 0.01, "{mapped:?}");
    let to_vertices = ["pair.obj", "-o", "v.ply", "--normal", "mapped", "--occluders", "floor", "--json"];
    let output = bake(&dir, &to_vertices);
    assert_eq!(output.status.code(), Some(0), "{}", err(&output));
    let mean = out(&output).split(r#""mean_visibility":"#).nth(1).unwrap()[..4].parse::<f32>().unwrap();
    assert!((mean - 0.85).abs() < 0.02, "{mean}");
    fs::remove_file(dir.path().join("n.png")).unwrap();
    let words = ["pair.obj", "-o", "m.png", "--normal", "mapped"];
    let output = bake(&dir, &words);
    assert!(err(&output).contains("normal maps that could not be read"), "{}", err(&output));
    refused(&dir, &words, 2, "no material of what is baked has a normal map");
}

#[test]
fn a_preview_of_vertices_ends_as_the_values() {
    let dir = folder();
    floor_and_lid(dir.path());
    let words = ["pair.obj", "-o", "v.ply", "--rays", "64", "--distance", "4"];
    let output = bake(&dir, &[&words[..], &["--preview", "p.ply"]].concat());
    assert_eq!(output.status.code(), Some(0), "{}", err(&output));
    assert_eq!(fs::read(dir.path().join("p.ply")).unwrap(), fs::read(dir.path().join("v.ply")).unwrap());
    refused(&dir, &[&words[..], &["--preview", "p.png"]].concat(), 2, "must end in .ply, for vertices");
}

#[test]
fn maps_are_as_large_as_a_density_says() {
    let dir = folder();
    floor_and_lid(dir.path());
    // The floor has a side of 1, which is 0.4 of the map across and 0.9 up.
    let words = ["pair.obj", "-o", "m.png", "--rays", "4"];
    let output = bake(&dir, &[&words[..], &["--density", "50", "--json"]].concat());
    assert_eq!(output.status.code(), Some(0), "{}", err(&output));
    let map = conray::target::read_png(dir.path().join("m.png")).unwrap();
    assert_eq!((map.width, map.height), (128, 56));
    assert!(out(&output).contains(r#""sizes":[[128,56]]"#), "{}", out(&output));
    refused(&dir, &[&words[..], &["--density", "1e5"]].concat(), 2, "--density: the map of");
    refused(&dir, &[&words[..], &["--density", "0"]].concat(), 2, "more than 0");
    refused(&dir, &[&words[..], &["--density", "9", "--size", "64"]].concat(), 2, "cannot be used with");
    refused(&dir, &["pair.obj", "-o", "v.ply", "--density", "9"], 2, "--density: is for maps");
}

#[test]
fn an_obj_without_usable_uvs_comes_with_new_ones_beside_its_maps() {
    let dir = folder();
    floor_and_lid(dir.path());
    let text = fs::read_to_string(dir.path().join("pair.obj")).unwrap();
    fs::write(dir.path().join("folded.obj"), text.replace("vt 0.45 0.05", "vt 0.05 0.95")).unwrap();
    let output = bake(&dir, &["folded.obj", "-o", "m.png", "--size", "64", "--rays", "16"]);
    assert_eq!(output.status.code(), Some(0), "{}", err(&output));
    assert!(out(&output).contains("m-mapped.obj"), "{}", out(&output));
    // It can be baked as it is.
    let again = bake(&dir, &["m-mapped.obj", "-o", "n.png", "--size", "64", "--rays", "16", "--no-unwrap"]);
    assert_eq!(again.status.code(), Some(0), "{}", err(&again));
    let words = ["folded.obj", "-o", "m.png", "--no-unwrap"];
    refused(&dir, &words, 3, "have no UV set that a map can use");
}
