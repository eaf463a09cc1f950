//! The program tested as a program: exit codes, messages, files.

mod support;

use std::{fs, path::Path, process::Output};
use support::{command, err, folder, out};
use tempfile::TempDir;

fn conray(folder: &TempDir, words: &[&str]) -> Output {
    command(folder, words).output().unwrap()
}

/// Names of files in a folder, sorted.
fn files(folder: &TempDir) -> Vec<String> {
    let mut names: Vec<String> = fs::read_dir(folder.path())
        .unwrap()
        .map(|entry| entry.unwrap().file_name().to_string_lossy().into_owned())
        .collect();
    names.sort();
    names
}

const SMALL: [&str; 6] = ["--size", "48x32", "--voxels", "256", "--max-rays", "16"];

fn render(folder: &TempDir, words: &[&str]) -> Output {
    let all: Vec<&str> = ["render"].iter().chain(words).chain(&SMALL).copied().collect();
    conray(folder, &all)
}

#[test]
fn without_arguments_it_shows_help() {
    let dir = folder();
    let output = conray(&dir, &[]);
    assert_eq!(output.status.code(), Some(0));
    for word in ["render", "sample", "info", "compare", "Exit codes"] {
        assert!(out(&output).contains(word), "{word}");
    }
}

#[test]
fn help_documents_every_option_and_the_exit_codes() {
    let dir = folder();
    let output = conray(&dir, &["render", "--help"]);
    assert_eq!(output.status.code(), Some(0));
    for option in [
        "--output",
        "--method",
        "--size",
        "--view",
        "--eye",
        "--look-at",
        "--fov",
        "--distance",
        "--falloff",
        "--rays",
        "--time",
        "--error",
        "--strict",
        "--explain",
        "--state",
        "--voxels",
        "--cones",
        "--beta",
        "--epsilon",
        "--gamma",
        "--max-rays",
        "--seed",
        "--threads",
        "--max-memory",
        "--alpha",
        "--json",
        "--quiet",
        "--bits",
        "Exit codes",
    ] {
        assert!(out(&output).contains(option), "{option}");
    }
}

#[test]
fn every_method_renders_both_formats() {
    for method in ["rays", "cones", "paper", "hybrid"] {
        let dir = folder();
        let output = render(&dir, &["--method", method, "--rays", "4", "-o", "a.png", "-o", "a.exr"]);
        assert_eq!(output.status.code(), Some(0), "{}", err(&output));
        assert_eq!(files(&dir), ["a.exr", "a.png"], "nothing but the outputs is left");
        assert!(out(&output).contains("wrote a.png, a.exr"), "{}", out(&output));
        assert!(out(&output).contains(&format!("method {method}")));
        let image = image_size(&dir.path().join("a.png"));
        assert_eq!(image, (48, 32));
    }
}

/// Width and height from a PNG's header.
fn image_size(path: &Path) -> (u32, u32) {
    let bytes = fs::read(path).unwrap();
    let number = |at: usize| u32::from_be_bytes(bytes[at..at + 4].try_into().unwrap());
    assert_eq!(&bytes[1..4], b"PNG");
    (number(16), number(20))
}

#[test]
fn every_builtin_scene_renders() {
    for scene in ["cornell", "cornell-blocks", "atrium", "grove"] {
        let dir = folder();
        let output = render(&dir, &[scene, "--method", "rays", "--rays", "1"]);
        assert_eq!(output.status.code(), Some(0), "{scene}: {}", err(&output));
        assert_eq!(files(&dir), ["ao.png"]);
    }
}

#[test]
fn wrong_requests_exit_with_2_name_the_option_and_touch_nothing() {
    let cases: &[(&[&str], &[&str])] = &[
        (&["--method", "magic"], &["--method", "rays, cones, paper or hybrid"]),
        (&["--rays", "0"], &["--rays 0", "1 to 1048576"]),
        (&["--rays", "-3"], &["--rays"]),
        (&["--rays", "many"], &["--rays"]),
        (&["--time", "0"], &["--time 0", "0.000001 to 1000000"]),
        (&["--time", "-2s"], &["--time -2"]),
        (&["--time", "nan"], &["--time NaN"]),
        (&["--time", "abc"], &["--time", "500ms"]),
        (&["--time", "1s", "--method", "cones"], &["--time 1", "method cones"]),
        (&["--error", "0"], &["--error 0", "to 0.5"]),
        (&["--error", "-0.02"], &["--error -0.02"]),
        (&["--error", "nan"], &["--error NaN"]),
        (&["--error", "abc"], &["--error"]),
        (&["--error", "0.02", "--method", "paper"], &["--error 0.02", "method paper"]),
        (&["--sampling", "stratified", "--method", "rays"], &["--sampling stratified", "--rays"]),
        (&["--strict", "--rays", "4"], &["--strict", "--error"]),
        (&["--state", "work", "--method", "rays"], &["--state", "--method hybrid"]),
        (&["--voxels", "500"], &["--voxels 500", "power of two"]),
        (&["--cones", "7"], &["--cones 7", "6, 9, 16 or 25"]),
        (&["--beta", "-1"], &["--beta -1", "0 to"]),
        (&["--gamma", "2"], &["--gamma 2", "0 to 1"]),
        (&["--epsilon", "other"], &["--epsilon", "published or marching"]),
        (&["--max-rays", "0"], &["--max-rays 0", "1 to 65536"]),
        (&["--distance", "-1"], &["--distance"]),
        (&["--distance", "0"], &["--distance", "above 0"]),
        (&["--distance", "inf", "--falloff", "linear"], &["--falloff", "finite --distance"]),
        (&["--falloff", "cubic"], &["--falloff", "smooth"]),
        (&["--size", "0x10"], &["--size", "WIDTHxHEIGHT"]),
        (&["--size", "65536x65536"], &["65536"]),
        (&["--fov", "180"], &["180"]),
        (&["--fov", "nan"], &["--fov", "0 to 180"]),
        (&["--eye", "1,2"], &["--eye", "three numbers"]),
        (&["--eye", "1,2,3"], &["--look-at"]),
        (&["--eye", "1,2,3", "--look-at", "1,2,3"], &["look"]),
        (&["--view", "nowhere"], &["--view nowhere", "front"]),
        (&["-o", "a.jpg"], &["a.jpg", ".png or .exr"]),
        (&["-o", "noextension"], &["noextension"]),
        (&["--max-memory", "1K", "--method", "cones"], &["--max-memory"]),
        (&["--max-memory", "lots"], &["--max-memory", "512M"]),
        (&["--alpha", "maybe"], &["--alpha"]),
        (&["--unknown"], &["--unknown"]),
        (&["--bits", "12"], &["--bits"]),
    ];
    for (words, fragments) in cases {
        let dir = folder();
        // The small settings come first, so that the case's own win... clap refuses repeats: leave out what it names.
        let mut all = vec!["render"];
        for pair in SMALL.chunks(2).filter(|pair| !words.contains(&pair[0])) {
            all.extend(pair);
        }
        all.extend(*words);
        let output = conray(&dir, &all);
        assert_eq!(output.status.code(), Some(2), "{words:?}: {}", err(&output));
        for fragment in *fragments {
            assert!(err(&output).contains(fragment), "{words:?}: {} lacks {fragment}", err(&output));
        }
        assert!(files(&dir).is_empty(), "{words:?} left {:?}", files(&dir));
    }
}

/// A file and what the message about it must say besides its name.
fn bad_files() -> Vec<(&'static str, Vec<u8>, &'static str)> {
    let glb = |json: &str| {
        let mut padded = json.as_bytes().to_vec();
        while !padded.len().is_multiple_of(4) {
            padded.push(b' ');
        }
        let mut bytes = b"glTF".to_vec();
        for word in [2, 20 + padded.len() as u32, padded.len() as u32, 0x4e4f_534a] {
            bytes.extend(word.to_le_bytes());
        }
        [bytes, padded].concat()
    };
    vec![
        ("empty.obj", vec![], "no triangles"),
        ("range.obj", b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 99\n".to_vec(), "line 4"),
        ("nan.obj", b"v 0 0 0\nv nan 0 0\nv 0 1 0\nf 1 2 3\n".to_vec(), "line 2"),
        ("words.obj", b"v 0 zero 0\nf 1 1 1\n".to_vec(), "line 1"),
        ("short.glb", b"glTF\x02\0\0\0\xff\0\0\0".to_vec(), "ends here"),
        ("text.gltf", b"{ not json".to_vec(), "line 1"),
        ("none.gltf", br#"{"asset":{"version":"2.0"}}"#.to_vec(), "no triangles"),
        (
            "draco.glb",
            glb(r#"{"asset":{"version":"2.0"},"extensionsRequired":["KHR_draco_mesh_compression"],"extensionsUsed":["KHR_draco_mesh_compression"]}"#),
            "KHR_draco_mesh_compression",
        ),
        (
            "gone.gltf",
            br#"{"asset":{"version":"2.0"},"buffers":[{"byteLength":36,"uri":"gone.bin"}],
            "bufferViews":[{"buffer":0,"byteLength":36}],
            "accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3"}],
            "meshes":[{"primitives":[{"attributes":{"POSITION":0}}]}],"nodes":[{"mesh":0}],"scenes":[{"nodes":[0]}],"scene":0}"#
                .to_vec(),
            "gone.bin",
        ),
        ("cut.ply", b"ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\n".to_vec(), "cut.ply"),
        (
            "huge.ply",
            b"ply\nformat binary_little_endian 1.0\nelement vertex 4000000000\nproperty float x\nproperty float y\nproperty float z\nend_header\n"
                .to_vec(),
            "4000000000",
        ),
        ("cut.stl", [vec![0u8; 80], 1000u32.to_le_bytes().to_vec(), vec![0; 50]].concat(), "cut.stl"),
        ("model.fbx", b"Kaydara".to_vec(), "fbx"),
    ]
}

#[test]
fn bad_inputs_exit_with_3_name_the_file_and_lose_no_earlier_output() {
    for (name, bytes, fragment) in bad_files() {
        let dir = folder();
        fs::write(dir.path().join(name), bytes).unwrap();
        fs::write(dir.path().join("ao.png"), "earlier").unwrap();
        for words in [vec!["render", name], vec!["info", name]] {
            let output = conray(&dir, &words);
            assert_eq!(output.status.code(), Some(3), "{words:?}: {}", err(&output));
            let message = err(&output);
            assert!(
                message.contains(name) && message.contains(fragment),
                "{words:?}: {message} lacks {fragment}"
            );
            assert!(message.lines().count() <= 2, "short: {message}");
        }
        assert_eq!(fs::read(dir.path().join("ao.png")).unwrap(), b"earlier");
        assert_eq!(files(&dir).len(), 2, "nothing is left behind");
    }
}

#[test]
fn a_missing_scene_names_the_builtin_ones() {
    let dir = folder();
    let output = render(&dir, &["cornel"]);
    assert_eq!(output.status.code(), Some(3));
    assert!(err(&output).contains("cornel:") && err(&output).contains("cornell-blocks"), "{}", err(&output));
    let output = render(&dir, &["gone.obj"]);
    assert_eq!(output.status.code(), Some(3));
    assert!(err(&output).contains("gone.obj"), "{}", err(&output));
}

#[test]
fn outputs_that_cannot_be_written_are_refused_before_the_work() {
    let dir = folder();
    fs::create_dir(dir.path().join("folder.png")).unwrap();
    for path in ["nowhere/ao.png", "folder.png"] {
        let output = render(&dir, &["-o", path]);
        assert_eq!(output.status.code(), Some(1), "{path}: {}", err(&output));
        assert!(err(&output).contains(path), "{}", err(&output));
    }
    assert_eq!(files(&dir), ["folder.png"]);
}

#[test]
fn defects_are_warnings_with_counts_and_the_work_goes_on() {
    let dir = folder();
    let obj = "mtllib gone.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nusemtl gone\nf 1 2 3\nf 1 2 3\nf 1 1 2\nf 1 2 4\n";
    fs::write(dir.path().join("odd.obj"), obj).unwrap();
    let output = render(&dir, &["odd.obj", "--method", "rays", "--rays", "1"]);
    assert_eq!(output.status.code(), Some(0), "{}", err(&output));
    assert!(err(&output).contains("warning:") && err(&output).contains("gone.mtl"), "{}", err(&output));
    let info = conray(&dir, &["info", "odd.obj"]);
    assert!(out(&info).contains("1 duplicate triangles"), "{}", out(&info));
}

#[test]
fn json_lines_are_json_and_end_with_the_summary() {
    let dir = folder();
    let output = render(&dir, &["--json", "--method", "paper", "--seed", "7"]);
    assert_eq!(output.status.code(), Some(0), "{}", err(&output));
    let lines: Vec<serde_json::Value> =
        out(&output).lines().map(|line| serde_json::from_str(line).expect(line)).collect();
    let events: Vec<&str> = lines.iter().map(|line| line["event"].as_str().unwrap()).collect();
    assert_eq!(events.last(), Some(&"summary"));
    for event in ["started", "progress", "finished"] {
        assert!(events.contains(&event), "{event}");
    }
    let summary = lines.last().unwrap();
    assert_eq!(summary["settings"]["seed"], 7);
    assert_eq!(summary["changed_settings"]["seed"], "7");
    assert!(summary["changed_settings"].get("rays").is_none());
    assert!(summary["rays"].as_u64().unwrap() > 0 && summary["cones"].as_u64().unwrap() > 0);
    let progress: Vec<u64> = lines
        .iter()
        .filter(|line| line["event"] == "progress")
        .map(|line| line["done"].as_u64().unwrap())
        .collect();
    assert!(!progress.is_empty());
}

#[test]
fn quiet_is_quiet() {
    let dir = folder();
    let output = render(&dir, &["--quiet", "--method", "rays", "--rays", "1"]);
    assert_eq!(output.status.code(), Some(0));
    assert_eq!(out(&output) + &err(&output), "");
}

#[test]
fn thread_count_changes_no_byte_of_a_file() {
    let dir = folder();
    for method in ["rays", "cones", "paper"] {
        for threads in ["1", "3"] {
            let (png, exr) = (format!("{threads}.png"), format!("{threads}.exr"));
            let words = ["--method", method, "--rays", "8", "--threads", threads, "-o", &png, "-o", &exr];
            assert_eq!(render(&dir, &words).status.code(), Some(0));
        }
        for kind in ["png", "exr"] {
            let read = |name: &str| fs::read(dir.path().join(format!("{name}.{kind}"))).unwrap();
            assert!(read("1") == read("3"), "{method} {kind}");
        }
    }
}

#[test]
fn options_have_effect() {
    let dir = folder();
    let base = ["--method", "paper", "--rays", "4", "-o", "base.exr"];
    assert_eq!(render(&dir, &base).status.code(), Some(0));
    let changes: &[&[&str]] = &[
        &["--distance", "inf"],
        &["--falloff", "smooth"],
        &["--cones", "9"],
        &["--beta", "1"],
        &["--gamma", "0.5"],
        &["--epsilon", "marching"],
        &["--seed", "9"],
        &["--fov", "60"],
        &["--view", "whole"],
        &["--eye=0.1,0.2,0.3", "--look-at=0.3,0.1,0.2"],
    ];
    for change in changes {
        let words: Vec<&str> = base[..4].iter().chain(*change).chain(&["-o", "other.exr"]).copied().collect();
        let output = render(&dir, &words);
        assert_eq!(output.status.code(), Some(0), "{change:?}: {}", err(&output));
        let output = conray(&dir, &["compare", "other.exr", "base.exr", "--json"]);
        let metrics: serde_json::Value = serde_json::from_str(&out(&output)).unwrap();
        assert!(metrics["rmse"].as_f64().unwrap() > 0.0, "{change:?} has no effect");
    }
}

#[test]
fn compare_finds_equal_and_different_images() {
    let dir = folder();
    for (name, seed) in [("a.exr", "0"), ("b.exr", "1")] {
        assert_eq!(
            render(&dir, &["--method", "rays", "--rays", "4", "--seed", seed, "-o", name]).status.code(),
            Some(0)
        );
    }
    let rmse = |a: &str, b: &str| {
        let output = conray(&dir, &["compare", a, b, "--json"]);
        assert_eq!(output.status.code(), Some(0), "{}", err(&output));
        serde_json::from_str::<serde_json::Value>(&out(&output)).unwrap()["rmse"].as_f64().unwrap()
    };
    assert_eq!(rmse("a.exr", "a.exr"), 0.0);
    assert!(rmse("a.exr", "b.exr") > 0.01);
    fs::write(dir.path().join("broken.exr"), "no image").unwrap();
    assert_eq!(conray(&dir, &["compare", "a.exr", "broken.exr"]).status.code(), Some(3));
    assert_eq!(conray(&dir, &["compare", "a.exr", "gone.exr"]).status.code(), Some(3));
}

const POINTS: &str = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n\
property float nx\nproperty float ny\nproperty float nz\nproperty uchar red\nelement face 1\n\
property list uchar int vertex_indices\nend_header\n\
0.1 0 0.1 0 1 0 11\n0.2 0 0.2 0 1 0 22\n0.3 0 0.3 0 1 0 33\n3 0 1 2\n";

#[test]
fn sample_adds_properties_and_keeps_the_rest() {
    let dir = folder();
    fs::write(dir.path().join("in.ply"), POINTS).unwrap();
    for method in ["rays", "cones", "paper", "hybrid"] {
        let words = [
            "sample", "cornell", "--points", "in.ply", "-o", "out.ply", "--method", method, "--voxels", "32",
        ];
        let output = conray(&dir, &words);
        assert_eq!(output.status.code(), Some(0), "{}", err(&output));
        let text = fs::read_to_string(dir.path().join("out.ply")).unwrap();
        for kept in ["property uchar red", "element face 1", "3 0 1 2"] {
            assert!(text.contains(kept), "{text}");
        }
        for added in ["property float visibility", "property float error", "property float rays"] {
            assert!(text.contains(added), "{text}");
        }
    }
}

#[test]
fn sample_refuses_bad_points() {
    let dir = folder();
    let without_normals = POINTS.replace("property float nz\n", "").replace("0 1 0", "0 1");
    fs::write(dir.path().join("flat.ply"), without_normals).unwrap();
    fs::write(dir.path().join("nan.ply"), POINTS.replace("0.2 0 0.2", "nan 0 0.2")).unwrap();
    fs::write(dir.path().join("cut.ply"), &POINTS[..POINTS.len() - 40]).unwrap();
    for (name, fragment) in
        [("flat.ply", "nz"), ("nan.ply", "1"), ("cut.ply", "cut.ply"), ("gone.ply", "gone.ply")]
    {
        let output = conray(&dir, &["sample", "cornell", "--points", name, "-o", "out.ply"]);
        assert_eq!(output.status.code(), Some(3), "{name}: {}", err(&output));
        assert!(err(&output).contains(name) && err(&output).contains(fragment), "{}", err(&output));
        assert!(!dir.path().join("out.ply").exists());
    }
}

#[test]
fn info_tells_in_words_and_in_json() {
    let dir = folder();
    let output = conray(&dir, &["info", "cornell", "--voxels", "64"]);
    assert_eq!(output.status.code(), Some(0), "{}", err(&output));
    assert!(out(&output).contains("triangles") && out(&output).contains("view front"), "{}", out(&output));
    let output = conray(&dir, &["info", "atrium", "--voxels", "64", "--json"]);
    let facts: serde_json::Value = serde_json::from_str(&out(&output)).unwrap();
    assert!(facts["triangles"].as_u64().unwrap() >= 200_000);
    assert!(facts["bvh"]["bytes"].as_u64().unwrap() > 0 && facts["octree"]["leaves"].as_u64().unwrap() > 0);
}

#[cfg(unix)]
#[test]
fn ctrl_c_writes_what_is_there_and_says_so() {
    let dir = folder();
    let words = [
        "render", "--method", "rays", "--rays", "1048576", "--size", "64x64", "-o", "ao.png", "-o", "ao.exr",
        "--json",
    ];
    // Progress on standard output says that estimation is under way.
    let output = support::interrupted(command(&dir, &words), "\"progress\"");
    assert_eq!(output.status.code(), Some(1), "{}", err(&output));
    assert!(err(&output).contains("interrupted"), "{}", err(&output));
    let summary: serde_json::Value = serde_json::from_str(out(&output).lines().last().unwrap()).unwrap();
    assert_eq!(summary["completed"], false);
    assert_eq!(files(&dir), ["ao.exr", "ao.png"]);
    assert_eq!(image_size(&dir.path().join("ao.png")), (64, 64));
}
