//! What a person asks for.

use crate::{Distance, Epsilon};
use conray_core::{ConeSet, Falloff};
use serde::{Deserialize, Serialize};
use std::{fmt, ops::RangeInclusive, str::FromStr};
use thiserror::Error;

/// How visibility is estimated.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Method {
    /// Rays alone: unbiased, noisy with few rays.
    Rays,
    /// Cones alone: without noise, biased.
    Cones,
    /// The blend of both as published: Podee, Dobashi, Yamamoto, "Combining Cone and Ray Tracing for Ambient
    /// Occlusion Computation".
    Paper,
    /// conray's own: rays where they help most, pooled with what like neighbours found, each weighed by its expected
    /// squared error. Of points taken one by one it is [`Method::Rays`].
    #[default]
    Hybrid,
}

impl Method {
    /// Every method.
    pub const ALL: [Self; 4] = [Self::Rays, Self::Cones, Self::Paper, Self::Hybrid];

    /// True where the method marches cones, and so needs an octree.
    pub fn needs_octree(self) -> bool {
        matches!(self, Self::Cones | Self::Paper)
    }

    /// True where the method may trace rays.
    pub fn traces_rays(self) -> bool {
        self != Self::Cones
    }
}

impl fmt::Display for Method {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Rays => "rays",
            Self::Cones => "cones",
            Self::Paper => "paper",
            Self::Hybrid => "hybrid",
        })
    }
}

impl FromStr for Method {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        Self::ALL
            .into_iter()
            .find(|method| method.to_string() == text)
            .ok_or_else(|| "expected rays, cones, paper or hybrid".into())
    }
}

/// Which points of the unit square become the directions of the rays of method `rays`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Sampling {
    /// Owen-scrambled Sobol points: the least error per ray, and any number of rays is a good set.
    #[default]
    Sobol,
    /// Jittered points: one at a random place in each cell of a grid with as many cells as rays. Needs the number
    /// of rays beforehand.
    Stratified,
    /// Independent points: the most error per ray. What others compare with.
    Random,
}

impl Sampling {
    /// Every sampling.
    pub const ALL: [Self; 3] = [Self::Sobol, Self::Stratified, Self::Random];
}

impl fmt::Display for Sampling {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Sobol => "sobol",
            Self::Stratified => "stratified",
            Self::Random => "random",
        })
    }
}

impl FromStr for Sampling {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        Self::ALL
            .into_iter()
            .find(|sampling| sampling.to_string() == text)
            .ok_or_else(|| "expected sobol, stratified or random".into())
    }
}

/// What the opacity of materials means.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Alpha {
    /// As the materials say.
    #[default]
    Material,
    /// Every surface blocks fully.
    Opaque,
}

/// Ranges of the settings.
pub mod limits {
    use super::RangeInclusive;

    /// Rays per point.
    pub const RAYS: RangeInclusive<u32> = 1..=1 << 20;
    /// Seconds of estimation. Below the first, not even the clock can tell.
    pub const TIME: RangeInclusive<f64> = 1e-6..=1e6;
    /// Expected RMSE of visibility.
    pub const ERROR: RangeInclusive<f32> = 1e-5..=0.5;
    /// Aperture of the cone in which rays leave, in degrees.
    pub const SPREAD: RangeInclusive<f32> = 1.0..=180.0;
    /// Degrees above the horizon below which occluders fade.
    pub const BIAS_ANGLE: RangeInclusive<f32> = 0.0..=89.0;
    /// Leaves along the longest side of the scene; powers of two only.
    pub const VOXELS: RangeInclusive<u32> = 16..=2048;
    /// The paper's beta.
    pub const BETA: RangeInclusive<f32> = 0.0..=1e6;
    /// The paper's gamma.
    pub const GAMMA: RangeInclusive<f32> = 0.0..=1.0;
    /// The paper's N_max, rays per cone.
    pub const MAX_RAYS: RangeInclusive<u32> = 1..=1 << 16;
}

/// Everything that changes an estimate. Defaults are ready to use; struct update changes some.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields, rename_all = "kebab-case")]
pub struct AoSettings {
    /// How visibility is estimated.
    pub method: Method,
    /// How far an occluder still counts: world units above 0, infinite, or a share of the scene's size.
    pub distance: Distance,
    /// How an occluder's weight fades with its distance. Needs a finite distance unless `none`.
    pub falloff: Falloff,
    /// Most rays per point of methods `rays` and, on average, `hybrid`, in [`limits::RAYS`]; powers of two give the least error
    /// per ray. The work ends at whichever of `rays`, `time` and `error` comes first; without any of them at an
    /// expected error of [`HARDLY_SEEN`](crate::HARDLY_SEEN).
    pub rays: Option<u32>,
    /// Methods `rays` and `hybrid`: most seconds of estimation, in [`limits::TIME`].
    pub time: Option<f64>,
    /// Methods `rays` and `hybrid`: aperture of the cone about the normal in which rays leave, cosine-weighted, in degrees, in
    /// [`limits::SPREAD`]; 180 is the whole hemisphere.
    pub spread: f32,
    /// Methods `rays` and `hybrid`: angle above the horizon, in degrees, in [`limits::BIAS_ANGLE`], below which occluders count less, and at the
    /// horizon not at all: hides the facets of surfaces that are shaded smoothly. 0 is the truth.
    pub bias_angle: f32,
    /// Methods `rays` and `hybrid`: the expected RMSE that is enough, in [`limits::ERROR`].
    pub error: Option<f32>,
    /// Method `rays`: how directions are chosen. Other methods keep to Sobol points.
    pub sampling: Sampling,
    /// Octree leaves along the longest side of the scene: a power of two in [`limits::VOXELS`].
    pub voxels: u32,
    /// Cones per point: 6, 9, 16 or 25.
    pub cones: u32,
    /// Method `paper`: which error of a cone that is.
    pub epsilon: Epsilon,
    /// Method `paper`: how fast trust in a cone falls with its error, in [`limits::BETA`].
    pub beta: f32,
    /// Method `paper`: the cone error up to which a cone is trusted fully, in [`limits::GAMMA`].
    pub gamma: f32,
    /// Method `paper`: most rays per cone, in [`limits::MAX_RAYS`].
    pub max_rays: u32,
    /// Chooses the random numbers.
    pub seed: u32,
    /// Whether the materials' opacity counts.
    pub alpha: Alpha,
    /// Most bytes that the octree may take, its build included; `None` is no limit. The resolution steps down to obey.
    pub max_memory: Option<u64>,
}

impl Default for AoSettings {
    fn default() -> Self {
        Self {
            method: Method::default(),
            distance: Distance::Auto,
            falloff: Falloff::None,
            rays: None,
            time: None,
            error: None,
            spread: 180.0,
            bias_angle: 0.0,
            sampling: Sampling::default(),
            voxels: 512,
            cones: 16,
            epsilon: Epsilon::default(),
            // With gamma given, beta and N_max are those of least squared error times cost on the built-in `cornell`
            // (`cargo run --release -p conray-bench --bin tune_paper`); beyond a beta of 100 little is gained.
            beta: 100.0,
            // The 2 % below which an error is hardly seen: Walter et al., "Lightcuts", 2005.
            gamma: 0.02,
            max_rays: 8,
            seed: 0,
            alpha: Alpha::Material,
            max_memory: None,
        }
    }
}

/// A setting outside its range.
#[derive(Clone, Debug, Error, PartialEq)]
#[error("--{option} {found}: {expected}")]
pub struct SettingsError {
    /// Name of the setting, as an option of the program.
    pub option: &'static str,
    /// What was asked for.
    pub found: String,
    /// What would do.
    pub expected: String,
}

impl AoSettings {
    /// Checks every setting against its range.
    ///
    /// # Errors
    /// The first setting outside its range, in the order of the members.
    pub fn validate(&self) -> Result<(), SettingsError> {
        let bad = |option, found: &dyn fmt::Display, expected: &str| {
            Err(SettingsError { option, found: found.to_string(), expected: expected.into() })
        };
        if let Distance::World(distance) = self.distance
            && !(distance > 0.0 && distance.is_finite())
        {
            return bad("distance", &distance, "must be above 0, or inf");
        }
        if self.falloff != Falloff::None && self.distance == Distance::Infinite {
            return bad("falloff", &self.falloff, "needs a finite --distance");
        }
        self.validate_budget()?;
        in_range("spread", self.spread, limits::SPREAD)?;
        in_range("bias-angle", self.bias_angle, limits::BIAS_ANGLE)?;
        let defaults = Self::default();
        let lacks = |option, found: f32| {
            let expected = format!("needs --method rays or hybrid, not {}", self.method);
            Err(SettingsError { option, found: found.to_string(), expected })
        };
        if !self.method.has_budget() && self.spread != defaults.spread {
            return lacks("spread", self.spread);
        }
        if !self.method.has_budget() && self.bias_angle != defaults.bias_angle {
            return lacks("bias-angle", self.bias_angle);
        }
        if !limits::VOXELS.contains(&self.voxels) || !self.voxels.is_power_of_two() {
            return bad("voxels", &self.voxels, "must be a power of two from 16 to 2048");
        }
        if ConeSet::from_count(self.cones).is_none() {
            return bad("cones", &self.cones, "must be 6, 9, 16 or 25");
        }
        in_range("beta", self.beta, limits::BETA)?;
        in_range("gamma", self.gamma, limits::GAMMA)?;
        in_range("max-rays", self.max_rays, limits::MAX_RAYS)
    }

    fn validate_budget(&self) -> Result<(), SettingsError> {
        self.rays.map_or(Ok(()), |rays| in_range("rays", rays, limits::RAYS))?;
        self.time.map_or(Ok(()), |seconds| in_range("time", seconds, limits::TIME))?;
        self.error.map_or(Ok(()), |error| in_range("error", error, limits::ERROR))?;
        let unused = |option, found: String| {
            let expected = format!("method {} does one fixed amount of work; leave it out", self.method);
            Err(SettingsError { option, found, expected })
        };
        match (self.time, self.error) {
            (Some(seconds), _) if !self.method.has_budget() => return unused("time", seconds.to_string()),
            (_, Some(error)) if !self.method.has_budget() => return unused("error", error.to_string()),
            _ => {}
        }
        // Its rays are one in each cell of a grid with as many cells: a part of them is no fair sample.
        let known = self.rays.is_some() && self.time.is_none() && self.error.is_none();
        if self.method.has_budget() && self.sampling == Sampling::Stratified && !known {
            let expected = "needs --rays, and neither --time nor --error".into();
            return Err(SettingsError { option: "sampling", found: self.sampling.to_string(), expected });
        }
        Ok(())
    }
}

fn in_range<T: PartialOrd + fmt::Display>(
    option: &'static str,
    found: T,
    range: RangeInclusive<T>,
) -> Result<(), SettingsError> {
    if range.contains(&found) {
        return Ok(());
    }
    let expected = format!("must be from {} to {}", range.start(), range.end());
    Err(SettingsError { option, found: found.to_string(), expected })
}

#[cfg(test)]
mod tests;
