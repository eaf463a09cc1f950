//! Options of the program `conray-viewer`.

use super::Failed;
use crate::{
    app::Start,
    camera::Look,
    choices::{Choices, PictureSize},
    engine::Source,
    layers::Layer,
    panels::source_of,
};
use clap::{Parser, ValueEnum};
use conray::{Device, Method, scene::BUILTIN_NAMES};
use std::path::{Path, PathBuf};

/// Ambient occlusion looked at while it converges.
#[derive(Parser, Clone, Debug)]
#[command(name = "conray-viewer", version, after_help = EXIT_CODES)]
pub(super) struct Options {
    /// A file (.obj, .gltf, .glb, .ply, .stl) or a built-in scene: cornell, cornell-blocks, atrium, grove
    #[arg(default_value = "cornell")]
    scene: String,
    /// A named view of the scene; default the first, else the whole scene
    #[arg(long, value_name = "NAME", conflicts_with_all = ["eye", "look_at"])]
    view: Option<String>,
    /// Position of the camera
    #[arg(long, value_name = "X,Y,Z", value_parser = parse_point, allow_hyphen_values = true, requires = "look_at")]
    eye: Option<[f32; 3]>,
    /// Point in the middle of the picture
    #[arg(long, value_name = "X,Y,Z", value_parser = parse_point, allow_hyphen_values = true, requires = "eye")]
    look_at: Option<[f32; 3]>,
    /// Vertical field of view in degrees, with --eye
    #[arg(long, value_name = "DEG", default_value_t = 50.0)]
    fov: f32,
    /// How visibility is estimated: rays, cones, paper or hybrid
    #[arg(long, default_value_t = Method::default())]
    method: Method,
    /// What is shown: visibility, ao, shaded, error, rays, cone-visibility, epsilon, alpha or difference
    #[arg(long, default_value = "visibility", value_parser = parse_layer)]
    layer: Layer,
    /// A second method at the right, with a line between them to drag
    #[arg(long, value_name = "METHOD")]
    right: Option<Method>,
    /// What is shown at the right; default as at the left
    #[arg(long, value_name = "LAYER", value_parser = parse_layer)]
    right_layer: Option<Layer>,
    /// Size of the picture in pixels; default as large as there is room
    #[arg(long, value_name = "WxH", value_parser = parse_size)]
    size: Option<[u32; 2]>,
    /// Refining ends at this expected error (RMSE), from 0.00001 to 0.5
    #[arg(long, value_name = "X")]
    error: Option<f32>,
    /// Most rays a pixel of methods rays and hybrid
    #[arg(long, value_name = "N")]
    rays: Option<u32>,
    /// Where estimates are made
    #[arg(long, value_enum, default_value = "auto")]
    device: DeviceArg,
    /// The graphics adapter whose name holds this text
    #[arg(long, value_name = "NAME")]
    adapter: Option<String>,
    /// Colours of the window
    #[arg(long, value_enum, default_value = "system")]
    theme: ThemeArg,
    /// Size of the window in points
    #[arg(long, value_name = "WxH", default_value = "1280x800", value_parser = parse_size)]
    window: [u32; 2],
    /// Draws the octree's nodes of this level: 0 is the leaves
    #[arg(long, value_name = "LEVEL")]
    boxes: Option<u32>,
    /// Probes the pixel at these shares of the picture's width and height, from 0 to 1
    #[arg(long, value_name = "X,Y", value_parser = parse_shares)]
    probe: Option<[f32; 2]>,
    /// Finds the truth of the view by so many rays a pixel, to compare with
    #[arg(long, value_name = "RAYS")]
    truth: Option<u32>,
    /// Writes what the window shows to this PNG and ends: once all is at rest, or after --after
    #[arg(long, value_name = "FILE")]
    pub(super) screenshot: Option<PathBuf>,
    /// Seconds before --screenshot
    #[arg(long, value_name = "SECONDS", requires = "screenshot")]
    pub(super) after: Option<f64>,
    /// Prints how long a move of the camera and an input while refining take, and ends
    #[arg(long, conflicts_with = "screenshot")]
    pub(super) measure: bool,
}

const EXIT_CODES: &str = "Exit codes: 0 done; 1 no window could be opened, or the work failed; 2 the request was wrong; 3 the scene could not be used.";

#[derive(ValueEnum, Clone, Copy, Debug)]
enum DeviceArg {
    Auto,
    Cpu,
    Gpu,
}

#[derive(ValueEnum, Clone, Copy, Debug)]
enum ThemeArg {
    System,
    Light,
    Dark,
}

impl Options {
    /// What the viewer begins with; refuses what can be refused without a window.
    pub(super) fn start(&self) -> Result<Start, Failed> {
        let source = source_of(&self.scene);
        if let Source::File(path) = &source
            && !path.exists()
        {
            let names = BUILTIN_NAMES.join(", ");
            let built_in = if path.extension().is_none() {
                format!(", and no built-in scene ({names})")
            } else {
                String::new()
            };
            return Err(Failed { code: 3, message: format!("{}: no such file{built_in}", self.scene) });
        }
        let choices = self.choices();
        for side in choices.sides() {
            side.validate().map_err(|e| Failed { code: 2, message: e.to_string() })?;
        }
        let look = self.eye.zip(self.look_at).map(|(eye, look_at)| Look {
            eye,
            look_at,
            up: [0.0, 1.0, 0.0],
            vertical_fov_deg: self.fov,
        });
        if let Some(look) = look {
            let camera = conray::target::Camera::new(&look.view("given"), 1, 1);
            camera.map_err(|e| Failed { code: 2, message: format!("--{e}") })?;
        }
        self.check_screenshot()?;
        let (view, boxes, probe, truth) = (self.view.clone(), self.boxes, self.probe, self.truth);
        Ok(Start { source: Some(source), view, look, choices, boxes, probe, truth })
    }

    fn check_screenshot(&self) -> Result<(), Failed> {
        let Some(path) = &self.screenshot else { return Ok(()) };
        if path.extension().is_none_or(|ending| !ending.eq_ignore_ascii_case("png")) {
            return Err(Failed {
                code: 2,
                message: format!("--screenshot {}: must end in .png", path.display()),
            });
        }
        if self.after.is_some_and(|seconds| !(0.0..=3600.0).contains(&seconds)) {
            return Err(Failed { code: 2, message: "--after: must be from 0 to 3600 seconds".into() });
        }
        let writable = conray::target::check_writable(Path::new(path));
        writable.map_err(|e| Failed { code: 1, message: e.to_string() })
    }

    fn choices(&self) -> Choices {
        let mut choices = Choices {
            right_method: self.right.unwrap_or(Method::Rays),
            layers: [self.layer, self.right_layer.unwrap_or(self.layer)],
            is_split: self.right.is_some() || self.right_layer.is_some(),
            device: match self.device {
                DeviceArg::Auto => Device::Auto,
                DeviceArg::Cpu => Device::Cpu,
                DeviceArg::Gpu => Device::Gpu,
            },
            adapter: self.adapter.clone().unwrap_or_default(),
            size: self.size.map_or(PictureSize::Fit, PictureSize::Fixed),
            ..Choices::default()
        };
        choices.settings.method = self.method;
        choices.settings.rays = self.rays;
        choices.settings.error = self.error.or(choices.settings.error);
        choices
    }

    pub(super) fn window(&self) -> [f32; 2] {
        self.window.map(|side| side as f32)
    }

    pub(super) fn theme(&self) -> egui::ThemePreference {
        match self.theme {
            ThemeArg::System => egui::ThemePreference::System,
            ThemeArg::Light => egui::ThemePreference::Light,
            ThemeArg::Dark => egui::ThemePreference::Dark,
        }
    }
}

fn parse_layer(text: &str) -> Result<Layer, String> {
    Layer::named(text).ok_or_else(|| {
        "expected visibility, ao, shaded, error, rays, cone-visibility, epsilon, alpha or difference".into()
    })
}

fn parse_numbers<const N: usize>(text: &str) -> Option<[f32; N]> {
    let numbers: Option<Vec<f32>> = text.split(',').map(|n| n.trim().parse().ok()).collect();
    numbers?.try_into().ok().filter(|numbers: &[f32; N]| numbers.iter().all(|n| n.is_finite()))
}

fn parse_point(text: &str) -> Result<[f32; 3], String> {
    parse_numbers(text).ok_or_else(|| "expected three numbers with commas between, such as 1.5,-2,0".into())
}

fn parse_shares(text: &str) -> Result<[f32; 2], String> {
    let shares =
        parse_numbers(text).filter(|shares: &[f32; 2]| shares.iter().all(|s| (0.0..=1.0).contains(s)));
    shares.ok_or_else(|| "expected two shares from 0 to 1 with a comma between, such as 0.5,0.25".into())
}

fn parse_size(text: &str) -> Result<[u32; 2], String> {
    let side = |side: &str| side.trim().parse().ok().filter(|n| (1..=8192).contains(n));
    let sides = text.split_once(['x', 'X']).and_then(|(w, h)| Some([side(w)?, side(h)?]));
    sides.ok_or_else(|| "expected WIDTHxHEIGHT, each from 1 to 8192, such as 1280x800".into())
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::CommandFactory;

    fn start(words: &[&str]) -> Result<Start, Failed> {
        let words = std::iter::once(&"conray-viewer").chain(words);
        Options::try_parse_from(words).map_err(|e| Failed { code: 2, message: e.to_string() })?.start()
    }

    #[test]
    fn options_are_consistent() {
        Options::command().debug_assert();
    }

    #[test]
    fn options_become_choices() {
        let words =
            ["atrium", "--view", "gallery", "--method", "paper", "--layer", "alpha", "--right", "rays"];
        let start =
            start(&[&words[..], &["--size", "64x48", "--device", "cpu", "--boxes", "3"]].concat()).unwrap();
        assert_eq!(start.source, Some(Source::Builtin("atrium".into())));
        assert_eq!(start.view.as_deref(), Some("gallery"));
        let choices = start.choices;
        assert_eq!((choices.settings.method, choices.right_method), (Method::Paper, Method::Rays));
        assert!(choices.is_split && choices.layers == [Layer::Alpha; 2]);
        assert_eq!(choices.size, PictureSize::Fixed([64, 48]));
        assert_eq!((choices.device, start.boxes), (Device::Cpu, Some(3)));
    }

    #[test]
    fn wrong_requests_and_missing_scenes_are_told_apart() {
        for (words, code, message) in [
            (&["gone.obj"][..], 3, "gone.obj: no such file"),
            (&["cornel"], 3, "cornell-blocks"),
            (&["--method", "magic"], 2, "rays, cones, paper or hybrid"),
            (&["--layer", "magic"], 2, "cone-visibility"),
            (&["--error", "7"], 2, "--error 7"),
            (&["--rays", "0"], 2, "--rays 0"),
            (&["--size", "0x9"], 2, "WIDTHxHEIGHT"),
            (&["--eye", "1,2,3"], 2, "--look-at"),
            (&["--eye", "1,2,3", "--look-at", "1,2,3"], 2, "no direction"),
            (&["--probe", "2,0"], 2, "shares"),
            (&["--screenshot", "a.jpg"], 2, ".png"),
            (&["--screenshot", "gone/a.png"], 1, "gone"),
            (&["--after", "3"], 2, "--screenshot"),
        ] {
            let failed = start(words).err().unwrap_or_else(|| panic!("{words:?} is refused"));
            assert_eq!(failed.code, code, "{words:?}: {}", failed.message);
            assert!(failed.message.contains(message), "{words:?}: {}", failed.message);
        }
    }
}
