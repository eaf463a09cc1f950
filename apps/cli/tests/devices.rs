//! Where estimates are made: `--device`, `--adapter`, `conray info --devices`.

mod support;

use support::{command, err, folder, out};

#[test]
fn what_no_device_has_is_refused_and_auto_takes_the_cpu() {
    let dir = folder();
    let render = |words: &[&str]| {
        let common = ["render", "cornell", "-o", "a.png", "--size", "32x32", "--rays", "4"];
        command(&dir, &[&common[..], words].concat()).output().unwrap()
    };
    let refused = |words: &[&str], expected: &str| {
        let output = render(words);
        assert_eq!(output.status.code(), Some(2), "{words:?}: {}", err(&output));
        assert!(err(&output).contains(expected), "{words:?}: {}", err(&output));
        assert!(!dir.path().join("a.png").exists());
    };
    refused(&["--device", "gpu", "--method", "rays", "--sampling", "random"], "sampling other than sobol");
    let nameless = ["--device", "gpu", "--method", "rays", "--adapter", "no such thing"];
    refused(&nameless, "no graphics adapter has a name with no such thing; there ");
    refused(&["--device", "tpu"], "possible values: auto, cpu, gpu");
    let bake = ["bake", "cornell.obj", "-o", "a.png", "--device", "gpu", "--method", "rays", "--self-only"];
    std::fs::write(
        dir.path().join("cornell.obj"),
        "v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 0 1\nf 1/1 2/2 3/3\n",
    )
    .unwrap();
    let output = command(&dir, &bake).output().unwrap();
    assert_eq!(output.status.code(), Some(2), "{}", err(&output));
    assert!(err(&output).contains("stand apart are estimated on the CPU"), "{}", err(&output));
    let output = render(&["--device", "cpu"]);
    assert_eq!(output.status.code(), Some(0), "{}", err(&output));
    assert!(!out(&output).contains(", on "), "{}", out(&output));
    for words in [&["--device", "auto"][..], &["--device", "auto", "--method", "rays"]] {
        let output = render(words);
        assert_eq!(output.status.code(), Some(0), "{}", err(&output));
        let told = out(&output);
        assert!(!told.contains("llvmpipe"), "a program on the CPU is not taken by itself: {told}");
    }
}

#[test]
fn adapters_are_listed() {
    let dir = folder();
    let output = command(&dir, &["info", "--devices", "--json"]).output().unwrap();
    assert_eq!(output.status.code(), Some(0), "{}", err(&output));
    let listed: serde_json::Value = serde_json::from_str(&out(&output)).unwrap();
    for device in listed["devices"].as_array().unwrap() {
        assert!(
            device["name"].is_string() && device["largest_binding_bytes"].as_u64().unwrap() > 0,
            "{device}"
        );
    }
    let lines = command(&dir, &["info", "--devices"]).output().unwrap();
    assert!(!out(&lines).trim().is_empty());
    assert_eq!(command(&dir, &["info"]).output().unwrap().status.code(), Some(2));
}

#[test]
#[ignore = "needs a graphics adapter, if only a software one"]
fn a_picture_by_a_device_is_that_of_the_cpu_gpu() {
    let dir = folder();
    for method in ["rays", "hybrid", "cones", "paper"] {
        for (device, file) in [("cpu", "cpu.exr"), ("gpu", "gpu.exr")] {
            let words = ["render", "atrium", "--method", method, "--size", "96x96", "--voxels", "128"];
            let rays = if ["rays", "hybrid"].contains(&method) { &["--rays", "32"][..] } else { &[] };
            let rest = ["--device", device, "-o", file, "--json"];
            let output = command(&dir, &[&words[..], rays, &rest].concat()).output().unwrap();
            assert_eq!(output.status.code(), Some(0), "{method}: {}", err(&output));
            assert_eq!(out(&output).contains(r#""device":"CPU""#), device == "cpu", "{}", out(&output));
        }
        let compared = command(&dir, &["compare", "gpu.exr", "cpu.exr", "--json"]).output().unwrap();
        let found: serde_json::Value = serde_json::from_str(&out(&compared)).unwrap();
        let rmse = found["rmse"].as_f64().unwrap();
        assert!(rmse <= 0.003, "{method}: {rmse}");
    }
}
