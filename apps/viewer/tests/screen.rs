//! The program on a screen, if only a virtual one: what its window shows, and that its command makes the same picture.

use conray::target::{compare, read_exr_channels};
use conray_viewer::{
    camera::Look,
    engine::{Order, Question, Report},
    save::command,
};
use std::{
    collections::HashSet,
    fs::File,
    io::BufReader,
    path::{Path, PathBuf},
    process::{Command, Output},
};
use support::{Runner, wish};
use tempfile::TempDir;

mod support;

/// The viewer with these words, in a folder.
fn viewer(dir: &TempDir, words: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_conray-viewer")).current_dir(dir.path()).args(words).output().unwrap()
}

fn err(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

/// Width, height and colours of an RGB picture.
fn pixels(path: &Path) -> (usize, usize, Vec<[u8; 3]>) {
    let mut reader = png::Decoder::new(BufReader::new(File::open(path).unwrap())).read_info().unwrap();
    let mut bytes = vec![0; reader.output_buffer_size().unwrap()];
    let info = reader.next_frame(&mut bytes).unwrap();
    assert_eq!(info.color_type, png::ColorType::Rgb);
    (info.width as usize, info.height as usize, bytes.as_chunks::<3>().0.to_vec())
}

/// The colours of a part of the picture's middle, by shares of the window.
fn part(all: &(usize, usize, Vec<[u8; 3]>), x: [f32; 2], y: [f32; 2]) -> Vec<[u8; 3]> {
    let (width, height, pixels) = all;
    let range =
        |share: [f32; 2], side: usize| (share[0] * side as f32) as usize..(share[1] * side as f32) as usize;
    let rows = range(y, *height).flat_map(|row| range(x, *width).map(move |column| row * width + column));
    rows.map(|at| pixels[at]).collect()
}

#[test]
#[ignore = "needs a screen, if only a virtual one"]
fn the_window_shows_picture_panels_and_legend_on_a_screen() {
    let dir = tempfile::tempdir().unwrap();
    let words = |theme, method, layer, out| {
        [
            "--theme",
            theme,
            "--method",
            method,
            "--layer",
            layer,
            "--error",
            "0.03",
            "--screenshot",
            out,
            "--window",
            "1000x700",
        ]
    };
    let mut means = Vec::new();
    for (theme, method, layer, out) in
        [("dark", "hybrid", "visibility", "dark.png"), ("light", "paper", "alpha", "light.png")]
    {
        let output = viewer(&dir, &words(theme, method, layer, out));
        assert_eq!(output.status.code(), Some(0), "{}", err(&output));
        let told: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
        assert_eq!(
            (&told["scene"], &told["sides"][0]["method"]),
            (&"cornell".into(), &method.into()),
            "{told}"
        );
        let shown = pixels(&dir.path().join(out));
        assert_eq!((shown.0, shown.1), (1000, 700));
        // The room has many values; a window that is blank, or that has no picture, has few.
        let room = part(&shown, [0.4, 0.9], [0.1, 0.6]);
        let colours: HashSet<[u8; 3]> = room.iter().copied().collect();
        assert!(colours.len() > 60, "{theme}: {} colours", colours.len());
        let is_grey = |c: &&[u8; 3]| c.iter().max().unwrap() - c.iter().min().unwrap() <= 2;
        let grey = room.iter().filter(is_grey).count() as f64 / room.len() as f64;
        assert_eq!(grey > 0.9, layer == "visibility", "{layer}: {grey}");
        let panel = part(&shown, [0.0, 0.2], [0.0, 1.0]);
        let text: HashSet<[u8; 3]> = panel.iter().copied().collect();
        assert!(text.len() > 10, "{theme}: a panel with controls");
        means.push(panel.iter().flatten().map(|&c| f64::from(c)).sum::<f64>() / (3 * panel.len()) as f64);
    }
    assert!(means[1] > means[0] + 100.0, "light is lighter than dark: {means:?}");
}

#[test]
#[ignore = "needs a screen, if only a virtual one"]
fn a_scene_that_cannot_be_read_ends_a_screenshot_with_3_on_a_screen() {
    let dir = tempfile::tempdir().unwrap();
    std::fs::write(dir.path().join("broken.glb"), b"glTF\x02\0\0\0\xff\0\0\0").unwrap();
    let output = viewer(&dir, &["broken.glb", "--screenshot", "a.png"]);
    assert_eq!(output.status.code(), Some(3), "{}", err(&output));
    assert!(err(&output).contains("broken.glb"), "{}", err(&output));
    assert!(!dir.path().join("a.png").exists());
}

#[test]
fn without_a_screen_it_says_so() {
    let dir = tempfile::tempdir().unwrap();
    let output = Command::new(env!("CARGO_BIN_EXE_conray-viewer"))
        .current_dir(dir.path())
        .env_remove("DISPLAY")
        .env_remove("WAYLAND_DISPLAY")
        .output()
        .unwrap();
    if cfg!(target_os = "linux") {
        assert_eq!(output.status.code(), Some(1), "{}", err(&output));
        assert!(err(&output).contains("no window can be opened"), "{}", err(&output));
    }
}

/// The program `conray`, which the tests of the workspace have built beside the viewer.
fn conray() -> PathBuf {
    Path::new(env!("CARGO_BIN_EXE_conray-viewer"))
        .with_file_name(format!("conray{}", std::env::consts::EXE_SUFFIX))
}

#[test]
#[ignore = "needs the program conray beside the viewer's; cargo test --workspace builds it; no screen is needed"]
fn its_command_makes_the_picture_that_is_saved_on_a_screen() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("shown.exr");
    let mut runner = Runner::open("cornell");
    let scene = runner.scene.clone();
    for (method, most) in [(conray::Method::Paper, 1e-6), (conray::Method::Hybrid, 0.05)] {
        let mut wished = wish(&scene, [80, 60], &[method]);
        wished.look = Look { eye: [0.3, 0.25, -0.7], ..wished.look.orbit(0.1, 0.05) };
        wished.sides[0].gamma = 0.05;
        wished.sides[0].seed = 4_000_000_001;
        runner.order(Order::Wish(Box::new(wished.clone())));
        runner.until_rest();
        runner.order(Order::Ask(Question::Exr { side: 0, path: Some(path.clone()) }));
        runner.answer(|report| matches!(report, Report::Written(_)));
        let words = command(&scene, &wished.look, wished.size, &wished.sides[0], wished.device, None);
        let output = Command::new(conray()).current_dir(dir.path()).args(&words[1..]).output().unwrap();
        assert_eq!(output.status.code(), Some(0), "{words:?}: {}", err(&output));
        let (shown, made) =
            (read_exr_channels(&path).unwrap(), read_exr_channels(dir.path().join("view.exr")).unwrap());
        let red = |image: &conray::target::ExrImage| image.channel("R").unwrap().to_vec();
        let (shown, made) = (red(&shown), red(&made));
        let found = compare(&shown, &made, &vec![true; made.len()]).unwrap();
        // The blend is the same bits; hybrid is refined in other rounds, each within its error.
        assert!(found.rmse <= most && found.count == 80 * 60, "{method}: {found:?}");
        assert!(made.iter().any(|v| *v < 0.9), "something is seen");
    }
}
