//! Commands and options.

use clap::{Args, Parser, Subcommand, ValueEnum};
use conray::{Alpha, AoSettings, Distance, Falloff, Method, Vec3};
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

const EXIT_CODES: &str = "Exit codes: 0 done; 1 the work failed or was interrupted; 2 the request was wrong \
(usage, settings); 3 the input could not be used.";

const SCENE_HELP: &str =
    "A file (.obj, .gltf, .glb, .ply, .stl) or a built-in scene: cornell, cornell-blocks, atrium, grove";

#[derive(Subcommand, Debug)]
pub(crate) enum Command {
    /// Renders the ambient occlusion that a camera sees
    #[command(after_help = EXIT_CODES)]
    Render(RenderArgs),
    /// Estimates visibility at the vertices of a PLY file
    #[command(after_help = EXIT_CODES)]
    Sample(SampleArgs),
    /// Tells what is in a scene and what is wrong with it
    #[command(after_help = EXIT_CODES)]
    Info(InfoArgs),
    /// Compares the visibility of two EXR images
    #[command(after_help = EXIT_CODES)]
    Compare(CompareArgs),
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
    /// A named view of the scene (`conray info SCENE` lists them); default the first, else the whole scene
    #[arg(long, value_name = "NAME", conflicts_with_all = ["eye", "look_at"])]
    pub(crate) view: Option<String>,
    /// Position of the camera
    #[arg(long, value_name = "X,Y,Z", value_parser = parse_point, allow_hyphen_values = true, requires = "look_at")]
    pub(crate) eye: Option<Vec3>,
    /// Point in the middle of the image
    #[arg(long, value_name = "X,Y,Z", value_parser = parse_point, allow_hyphen_values = true, requires = "eye")]
    pub(crate) look_at: Option<Vec3>,
    /// Direction that is up in the image [default: 0,1,0]
    #[arg(long, value_name = "X,Y,Z", value_parser = parse_point, allow_hyphen_values = true)]
    pub(crate) up: Option<Vec3>,
    /// Vertical field of view in degrees, above 0 and below 180 [default: the view's, or 50 with --eye]
    #[arg(long, value_name = "DEG", allow_hyphen_values = true)]
    pub(crate) fov: Option<f32>,
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
    #[arg(help = SCENE_HELP)]
    pub(crate) scene: String,
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

/// Options of every command that estimates.
#[derive(Args, Debug)]
#[command(next_help_heading = "Ambient occlusion")]
pub(crate) struct AoArgs {
    /// How visibility is estimated: rays, cones, paper or hybrid (which for now is paper)
    #[arg(long, default_value_t = AoSettings::default().method)]
    method: Method,
    /// How far an occluder counts: world units, inf, or auto for a tenth of the diagonal of the scene's bounds
    #[arg(long, value_name = "D", default_value_t = Distance::Auto, allow_hyphen_values = true)]
    distance: Distance,
    /// How an occluder's weight fades with its distance
    #[arg(long, value_enum, default_value = "none")]
    falloff: FalloffArg,
    /// Rays per point of method rays, from 1 to 1048576; powers of two err least
    #[arg(long, value_name = "N", default_value_t = AoSettings::default().rays, allow_negative_numbers = true)]
    rays: u32,
    /// Octree leaves along the longest side of the scene: a power of two from 16 to 2048
    #[arg(long, value_name = "N", default_value_t = AoSettings::default().voxels, allow_negative_numbers = true)]
    voxels: u32,
    /// Cones per point: 6, 9, 16 or 25
    #[arg(long, value_name = "N", default_value_t = AoSettings::default().cones, allow_negative_numbers = true)]
    cones: u32,
    /// Method paper: how fast trust in a cone falls with its error, 0 or more
    #[arg(long, value_name = "X", default_value_t = AoSettings::default().beta, allow_negative_numbers = true)]
    beta: f32,
    /// Method paper: the error up to which a cone is trusted fully, from 0 to 1
    #[arg(long, value_name = "X", default_value_t = AoSettings::default().gamma, allow_negative_numbers = true)]
    gamma: f32,
    /// Method paper: most rays per cone, from 1 to 65536
    #[arg(long, value_name = "N", default_value_t = AoSettings::default().max_rays, allow_negative_numbers = true)]
    max_rays: u32,
    /// Chooses the random numbers
    #[arg(long, value_name = "N", default_value_t = AoSettings::default().seed)]
    seed: u32,
    /// Whether the opacity of materials counts
    #[arg(long, value_enum, default_value = "material")]
    alpha: AlphaArg,
    /// Most memory that the structures may take, such as 512M or 2G; the octree steps down to obey
    #[arg(long, value_name = "BYTES", value_parser = parse_bytes)]
    max_memory: Option<u64>,
}

/// Options about how the program runs.
#[derive(Args, Debug)]
#[command(next_help_heading = "Running")]
pub(crate) struct RunArgs {
    /// Threads to work on; 0 is one per core. Results do not depend on it
    #[arg(long, value_name = "N", default_value_t = 0)]
    pub(crate) threads: usize,
    /// Prints events as JSON lines on standard output
    #[arg(long)]
    pub(crate) json: bool,
    /// Prints nothing but warnings and errors
    #[arg(short, long)]
    pub(crate) quiet: bool,
}

#[derive(ValueEnum, Clone, Copy, Debug)]
enum FalloffArg {
    None,
    Linear,
    Smooth,
}

#[derive(ValueEnum, Clone, Copy, Debug)]
enum AlphaArg {
    Material,
    Opaque,
}

impl AoArgs {
    pub(crate) fn settings(&self) -> AoSettings {
        AoSettings {
            method: self.method,
            distance: self.distance,
            falloff: match self.falloff {
                FalloffArg::None => Falloff::None,
                FalloffArg::Linear => Falloff::Linear,
                FalloffArg::Smooth => Falloff::Smooth,
            },
            rays: self.rays,
            voxels: self.voxels,
            cones: self.cones,
            beta: self.beta,
            gamma: self.gamma,
            max_rays: self.max_rays,
            seed: self.seed,
            alpha: match self.alpha {
                AlphaArg::Material => Alpha::Material,
                AlphaArg::Opaque => Alpha::Opaque,
            },
            max_memory: self.max_memory,
        }
    }
}

fn parse_size(text: &str) -> Result<(u32, u32), String> {
    let parse = |side: &str| side.trim().parse().ok().filter(|&n| (1..=65536).contains(&n));
    text.split_once(['x', 'X'])
        .and_then(|(w, h)| Some((parse(w)?, parse(h)?)))
        .ok_or_else(|| "expected WIDTHxHEIGHT, each from 1 to 65536, such as 1280x720".into())
}

fn parse_point(text: &str) -> Result<Vec3, String> {
    let numbers: Vec<f32> = text.split(',').filter_map(|n| n.trim().parse().ok()).collect();
    match numbers[..] {
        [x, y, z] if text.split(',').count() == 3 && Vec3::new(x, y, z).is_finite() => Ok(Vec3::new(x, y, z)),
        _ => Err("expected three numbers with commas between, such as 1.5,-2,0".into()),
    }
}

fn parse_bytes(text: &str) -> Result<u64, String> {
    let digits = text.trim_end_matches(|c: char| c.is_ascii_alphabetic());
    let unit: u64 = match &text[digits.len()..].to_ascii_uppercase()[..] {
        "" | "B" => 1,
        "K" | "KB" | "KIB" => 1 << 10,
        "M" | "MB" | "MIB" => 1 << 20,
        "G" | "GB" | "GIB" => 1 << 30,
        _ => 0,
    };
    let bytes = digits.parse::<f64>().unwrap_or(f64::NAN) * unit as f64;
    if bytes >= 1.0 { Ok(bytes as u64) } else { Err("expected bytes, such as 800000000, 512M or 2G".into()) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::CommandFactory;

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
            assert_eq!(args.eye, Some(Vec3::new(-1.0, 2.0, -3.0)));
        }
    }

    #[test]
    fn sizes_points_and_bytes() {
        assert_eq!(parse_size("640x480"), Ok((640, 480)));
        assert!(["", "640", "0x1", "1x70000", "axb", "-1x5"].iter().all(|t| parse_size(t).is_err()));
        assert_eq!(parse_point("1, -2,3e1"), Ok(Vec3::new(1.0, -2.0, 30.0)));
        assert!(["", "1,2", "1,2,3,4", "1,,3", "a,b,c", "1,2,inf"].iter().all(|t| parse_point(t).is_err()));
        assert_eq!(parse_bytes("1.5G"), Ok(3 << 29));
        assert!(["", "G", "-1M", "5X", "0", "nan"].iter().all(|t| parse_bytes(t).is_err()));
    }
}
