//! Options about the camera.

use super::parse::parse_point;
use clap::Args;
use conray::Vec3;

/// From where a scene is seen.
#[derive(Args, Debug)]
#[command(next_help_heading = "Camera")]
pub(crate) struct CameraArgs {
    /// A named view of the scene (`conray info SCENE` lists them); default the first, else the whole scene
    #[arg(long, value_name = "NAME", conflicts_with_all = ["eye", "look_at"])]
    pub(crate) view: Option<String>,
    #[command(flatten)]
    pub(crate) given: GivenCameraArgs,
}

/// A camera by its numbers.
#[derive(Args, Debug)]
#[command(next_help_heading = "Camera")]
pub(crate) struct GivenCameraArgs {
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
}
