//! Options of `conray study`.

use super::{GivenCameraArgs, RunArgs, SharedAoArgs, parse::parse_size};
use clap::Args;
use std::path::PathBuf;

#[derive(Args, Debug)]
pub(crate) struct StudyArgs {
    /// Files or built-in scenes
    #[arg(default_values = ["cornell", "atrium"])]
    pub(crate) scenes: Vec<String>,
    /// Folder for the report: report.html, report.json, curves.csv and pictures
    #[arg(short, long, value_name = "DIR")]
    pub(crate) output: PathBuf,
    /// A first look within about a minute on two cores: small images, few budgets
    #[arg(long)]
    pub(crate) quick: bool,
    /// Size of the images in pixels [default: 512x512, 128x128 with --quick]
    #[arg(long, value_name = "WxH", value_parser = parse_size)]
    pub(crate) size: Option<(u32, u32)>,
    /// Rays per point at which methods are judged, ascending [default: 1,2,4,...,256, up to 64 with --quick]
    #[arg(long, value_name = "N,N,...", value_delimiter = ',')]
    pub(crate) budgets: Option<Vec<u32>>,
    /// Methods to compare [default: all]
    #[arg(long, value_name = "NAME,NAME,...", value_delimiter = ',')]
    pub(crate) methods: Option<Vec<String>>,
    /// Views to judge from, of every scene that has them [default: the first of each scene]
    #[arg(long, value_name = "NAME", conflicts_with_all = ["eye", "look_at"])]
    pub(crate) view: Vec<String>,
    #[command(flatten)]
    pub(crate) given: GivenCameraArgs,
    /// How often each trial is timed
    #[arg(long, value_name = "N", default_value_t = 3)]
    pub(crate) repeats: u32,
    /// Error (RMSE) that the truth must reach [default: 0.002, 0.003 with --quick]
    #[arg(long, value_name = "E")]
    pub(crate) truth_error: Option<f64>,
    /// Most rays per point for the truth [default: 16384, 2048 with --quick]
    #[arg(long, value_name = "N")]
    pub(crate) truth_rays: Option<u32>,
    /// Folder in which truths are kept for later studies [default: the user's cache folder]
    #[arg(long, value_name = "DIR")]
    pub(crate) cache: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) ao: SharedAoArgs,
    #[command(flatten)]
    pub(crate) run: RunArgs,
}
