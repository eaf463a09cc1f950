//! Options about ambient occlusion, and the settings that they come to.

use super::parse::{parse_bytes, parse_time};
use crate::failure::Failure;
use clap::{Args, ValueEnum};
use conray::{Alpha, AoSettings, Distance, Epsilon, Falloff, Method, Sampling};

/// Options of every command that estimates by one method.
#[derive(Args, Clone, Debug)]
#[command(next_help_heading = "Ambient occlusion")]
pub(crate) struct AoArgs {
    /// How visibility is estimated: rays, cones, paper or hybrid
    #[arg(long, default_value_t = AoSettings::default().method)]
    method: Method,
    /// Most rays per point of methods rays and (on average) hybrid, from 1 to 1048576; powers of two err least. The work ends at
    /// whichever of --rays, --time and --error comes first; without any of them at an error of 0.02
    #[arg(long, value_name = "N", allow_negative_numbers = true)]
    rays: Option<u32>,
    /// Methods rays and hybrid: most time of estimation, such as 2s, 500ms or 1.5m. Loading and building come on top
    #[arg(long, value_name = "TIME", value_parser = parse_time, allow_hyphen_values = true)]
    time: Option<f64>,
    /// Methods rays and hybrid: the expected error (RMSE of visibility) that is enough, from 0.00001 to 0.5
    #[arg(long, value_name = "X", allow_negative_numbers = true)]
    error: Option<f32>,
    /// Exits with 1 where the error is not reached within --time or --rays; what was reached is written all the same
    #[arg(long)]
    pub(crate) strict: bool,
    /// Prints the plan that was made, from what, and what ended the work
    #[arg(long)]
    pub(crate) explain: bool,
    /// Methods rays and hybrid: aperture of the cone about the normal in which rays leave, in degrees, from 1 to 180
    #[arg(long, value_name = "DEG", default_value_t = AoSettings::default().spread, allow_negative_numbers = true)]
    spread: f32,
    /// Methods rays and hybrid: degrees above the horizon, from 0 to 89, below which occluders count less, to hide the facets of
    /// surfaces that are shaded smoothly
    #[arg(long, value_name = "DEG", default_value_t = AoSettings::default().bias_angle, allow_negative_numbers = true)]
    bias_angle: f32,
    /// How method rays draws its directions: sobol (best), stratified or random (for comparisons)
    #[arg(long, default_value_t = AoSettings::default().sampling)]
    sampling: Sampling,
    #[command(flatten)]
    shared: SharedAoArgs,
}

/// Options that mean the same for every method.
#[derive(Args, Clone, Debug)]
#[command(next_help_heading = "Ambient occlusion")]
pub(crate) struct SharedAoArgs {
    /// How far an occluder counts: world units, inf, or auto for a tenth of the diagonal of the scene's bounds
    #[arg(long, value_name = "D", default_value_t = Distance::Auto, allow_hyphen_values = true)]
    distance: Distance,
    /// How an occluder's weight fades with its distance
    #[arg(long, value_enum, default_value = "none")]
    falloff: FalloffArg,
    /// Octree leaves along the longest side of the scene: a power of two from 16 to 2048
    #[arg(long, value_name = "N", default_value_t = AoSettings::default().voxels, allow_negative_numbers = true)]
    voxels: u32,
    /// Cones per point: 6, 9, 16 or 25
    #[arg(long, value_name = "N", default_value_t = AoSettings::default().cones, allow_negative_numbers = true)]
    cones: u32,
    /// Method paper: which error of a cone that is: published (the standard deviations met) or marching (with that of marching
    /// itself, which partly open cones have)
    #[arg(long, default_value_t = AoSettings::default().epsilon)]
    epsilon: Epsilon,
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
            rays: self.rays,
            time: self.time,
            error: self.error,
            spread: self.spread,
            bias_angle: self.bias_angle,
            sampling: self.sampling,
            ..self.shared.settings()
        }
    }

    /// The settings, checked; the error is what is wrong with them.
    pub(crate) fn checked(&self) -> Result<AoSettings, Failure> {
        let settings = self.settings();
        settings.validate().map_err(|e| Failure::Request(e.to_string()))?;
        if self.strict && crate::report::target_error(&settings).is_none() {
            return Err(Failure::Request("--strict: there is no error to reach; add --error".into()));
        }
        Ok(settings)
    }
}

impl SharedAoArgs {
    /// The settings, those of a single method left at their defaults.
    pub(crate) fn settings(&self) -> AoSettings {
        AoSettings {
            distance: self.distance,
            falloff: match self.falloff {
                FalloffArg::None => Falloff::None,
                FalloffArg::Linear => Falloff::Linear,
                FalloffArg::Smooth => Falloff::Smooth,
            },
            voxels: self.voxels,
            cones: self.cones,
            epsilon: self.epsilon,
            beta: self.beta,
            gamma: self.gamma,
            max_rays: self.max_rays,
            seed: self.seed,
            alpha: match self.alpha {
                AlphaArg::Material => Alpha::Material,
                AlphaArg::Opaque => Alpha::Opaque,
            },
            max_memory: self.max_memory,
            ..AoSettings::default()
        }
    }
}
