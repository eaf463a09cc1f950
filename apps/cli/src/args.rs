//! Commands and options.

mod ao;
mod bake;
mod camera;
mod parse;
mod study;

pub(crate) use ao::{AoArgs, SharedAoArgs};
pub(crate) use bake::{BakeArgs, ToArg};
pub(crate) use camera::{CameraArgs, GivenCameraArgs};
pub(crate) use study::StudyArgs;

use clap::{Args, Parser, Subcommand, ValueEnum};
use conray::{AoSettings, Device, SessionOptions};
use parse::{parse_bytes, parse_size};
use std::path::PathBuf;

/// Ambient occlusion by combining voxel cone tracing with ray tracing.
///
/// Results are linear visibility: 1 is open, 0 is closed.
#[derive(Parser, Debug)]
#[command(name = "conray", version, after_help = EXIT_CODES, arg_required_else_help = true)]
pub(crate) struct Cli {
    #[command(subcommand)]
    pub(crate) command: Command,
}

const EXIT_CODES: &str = "Exit codes: 0 done; 1 the work failed, was interrupted or (with --strict) did not reach the error; 2 the request was wrong \
(usage, settings); 3 the input could not be used.";

const SCENE_HELP: &str =
    "A file (.obj, .gltf, .glb, .ply, .stl) or a built-in scene: cornell, cornell-blocks, atrium, grove";

#[derive(Subcommand, Debug)]
pub(crate) enum Command {
    /// Renders the ambient occlusion that a camera sees
    #[command(after_help = EXIT_CODES)]
    Render(RenderArgs),
    /// Bakes the ambient occlusion of a model into textures
    #[command(after_help = EXIT_CODES, args_override_self = true)]
    Bake(BakeArgs),
    /// Estimates visibility at the vertices of a PLY file
    #[command(after_help = EXIT_CODES)]
    Sample(SampleArgs),
    /// Tells what is in a scene and what is wrong with it
    #[command(after_help = EXIT_CODES)]
    Info(InfoArgs),
    /// Compares methods on scenes and writes a report: the paper's table and figures, and more
    #[command(after_help = EXIT_CODES)]
    Study(StudyArgs),
    /// Compares the visibility of two EXR images
    #[command(after_help = EXIT_CODES)]
    Compare(CompareArgs),
    /// Opens a window that shows the ambient occlusion of a scene while it converges
    #[command(after_help = EXIT_CODES, disable_help_flag = true)]
    View(ViewArgs),
}

#[derive(Args, Debug)]
pub(crate) struct ViewArgs {
    /// A scene and options of the program conray-viewer, to which this hands over; --help lists them
    #[arg(value_name = "WORD", trailing_var_arg = true, allow_hyphen_values = true)]
    pub(crate) words: Vec<std::ffi::OsString>,
}

#[derive(Args, Debug)]
pub(crate) struct RenderArgs {
    #[arg(default_value = "cornell", help = SCENE_HELP)]
    pub(crate) scene: String,
    /// Output file, .png or .exr (with all layers); may repeat
    #[arg(short, long, value_name = "FILE", default_value = "ao.png")]
    pub(crate) output: Vec<PathBuf>,
    /// Bits per sample of a PNG
    #[arg(long, value_name = "8|16", default_value = "8", value_parser = clap::builder::PossibleValuesParser::new(["8", "16"]))]
    pub(crate) bits: String,
    /// Size of the image in pixels
    #[arg(long, value_name = "WxH", default_value = "512x512", value_parser = parse_size)]
    pub(crate) size: (u32, u32),
    /// Goes on from the work that this file keeps, where there is one, and keeps the work in it at the end and when interrupted;
    /// only method hybrid. The same --rays or --error then gives the same bits as without interruption
    #[arg(long, value_name = "FILE")]
    pub(crate) state: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) camera: CameraArgs,
    #[command(flatten)]
    pub(crate) ao: AoArgs,
    #[command(flatten)]
    pub(crate) run: RunArgs,
}

#[derive(Args, Debug)]
pub(crate) struct SampleArgs {
    #[arg(help = SCENE_HELP)]
    pub(crate) scene: String,
    /// PLY file with vertices and normals
    #[arg(long, value_name = "FILE")]
    pub(crate) points: PathBuf,
    /// PLY file to write: the input with visibility, error and rays at each vertex
    #[arg(short, long, value_name = "FILE")]
    pub(crate) output: PathBuf,
    #[command(flatten)]
    pub(crate) ao: AoArgs,
    #[command(flatten)]
    pub(crate) run: RunArgs,
}

#[derive(Args, Debug)]
pub(crate) struct InfoArgs {
    #[arg(help = SCENE_HELP, required_unless_present = "devices")]
    pub(crate) scene: Option<String>,
    /// Lists the graphics adapters instead
    #[arg(long, conflicts_with = "scene")]
    pub(crate) devices: bool,
    /// Octree leaves along the longest side of the scene: a power of two from 16 to 2048
    #[arg(long, value_name = "N", default_value_t = AoSettings::default().voxels)]
    pub(crate) voxels: u32,
    /// Most memory that the structures may take, such as 512M or 2G
    #[arg(long, value_name = "BYTES", value_parser = parse_bytes)]
    pub(crate) max_memory: Option<u64>,
    /// Threads to work on; 0 is one per core
    #[arg(long, value_name = "N", default_value_t = 0)]
    pub(crate) threads: usize,
    /// Prints JSON
    #[arg(long)]
    pub(crate) json: bool,
}

#[derive(Args, Debug)]
pub(crate) struct CompareArgs {
    /// EXR image to judge
    pub(crate) image: PathBuf,
    /// EXR image taken as the truth
    pub(crate) reference: PathBuf,
    /// PNG of the absolute difference, 10 times enlarged: black is equal
    #[arg(short, long, value_name = "FILE")]
    pub(crate) output: Option<PathBuf>,
    /// Prints JSON
    #[arg(long)]
    pub(crate) json: bool,
}

/// Options about how the program runs.
#[derive(Args, Clone, Debug)]
#[command(next_help_heading = "Running")]
pub(crate) struct RunArgs {
    /// Threads to work on; 0 is one per core. Results do not depend on it
    #[arg(long, value_name = "N", default_value_t = 0)]
    pub(crate) threads: usize,
    /// Where estimates are made: on a graphics processor or on the CPU; auto takes a graphics processor where there is one and it has all of the
    /// method
    #[arg(long, value_enum, default_value = "auto")]
    device: DeviceArg,
    /// The graphics adapter whose name holds this text; conray info --devices lists them
    #[arg(long, value_name = "NAME")]
    adapter: Option<String>,
    /// Prints events as JSON lines on standard output
    #[arg(long)]
    pub(crate) json: bool,
    /// Prints nothing but warnings and errors
    #[arg(short, long)]
    pub(crate) quiet: bool,
}

#[derive(ValueEnum, Clone, Copy, Debug)]
enum DeviceArg {
    Auto,
    Cpu,
    Gpu,
}

impl RunArgs {
    /// As the library takes them.
    pub(crate) fn options(&self) -> SessionOptions {
        let device = match self.device {
            DeviceArg::Auto => Device::Auto,
            DeviceArg::Cpu => Device::Cpu,
            DeviceArg::Gpu => Device::Gpu,
        };
        SessionOptions { threads: self.threads, device, adapter: self.adapter.clone() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::CommandFactory;
    use conray::Vec3;

    #[test]
    fn options_are_consistent() {
        Cli::command().debug_assert();
    }

    #[test]
    fn defaults_are_the_librarys() {
        let cli = Cli::parse_from(["conray", "render"]);
        let Command::Render(args) = cli.command else { panic!("render was asked for") };
        assert_eq!(args.ao.settings(), AoSettings::default());
    }

    #[test]
    fn negative_coordinates_do_with_and_without_equals() {
        for words in [
            vec!["conray", "render", "--eye", "-1,2,-3", "--look-at", "0,0,0"],
            vec!["conray", "render", "--eye=-1,2,-3", "--look-at=0,0,0"],
        ] {
            let Command::Render(args) = Cli::parse_from(words).command else {
                panic!("render was asked for")
            };
            assert_eq!(args.camera.given.eye, Some(Vec3::new(-1.0, 2.0, -3.0)));
        }
    }
}
