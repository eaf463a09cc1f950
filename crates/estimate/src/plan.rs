//! Settings made definite for one scene.

use crate::{AoSettings, Budget, Distance, Epsilon, Method, Sampling, SettingsError};
use conray_core::{Bounds, ConeSet, Falloff, HemisphereCones};

/// Validated settings in world units, made once per scene; code past it does not check again.
#[derive(Clone, Debug)]
pub struct AoPlan {
    /// How visibility is estimated.
    pub method: Method,
    /// AO distance in world units, above 0; may be infinite.
    pub distance: f32,
    /// How an occluder's weight fades.
    pub falloff: Falloff,
    /// Sine of the half-angle of the cone in which rays leave, in (0, 1]: 1 is the whole hemisphere.
    pub reach: f32,
    /// Sine of the angle above the horizon below which occluders fade; 0 fades none.
    pub bias: f32,
    /// What methods `rays` and `hybrid` may spend or must reach.
    pub budget: Budget,
    /// How method `rays` chooses directions.
    pub sampling: Sampling,
    /// The cones that stand for the hemisphere.
    pub cones: HemisphereCones,
    /// Which error of a cone the paper's blend goes by.
    pub epsilon: Epsilon,
    /// The paper's transition parameter.
    pub beta: f32,
    /// The paper's error threshold.
    pub gamma: f32,
    /// The paper's most rays per cone.
    pub max_rays: u32,
    /// Chooses the random numbers.
    pub seed: u32,
}

impl AoPlan {
    /// The plan for a scene with these bounds.
    ///
    /// # Errors
    /// A setting outside its range, or an automatic distance in a scene without extent.
    pub fn new(settings: &AoSettings, bounds: Bounds) -> Result<Self, SettingsError> {
        settings.validate()?;
        let distance = settings.distance.in_world(bounds.diagonal());
        if settings.distance == Distance::Auto && !(distance > 0.0 && distance.is_finite()) {
            let expected = "the scene's size gives no distance; say one".into();
            return Err(SettingsError { option: "distance", found: "auto".into(), expected });
        }
        Ok(Self {
            method: settings.method,
            distance,
            falloff: settings.falloff,
            // 180 degrees are the whole hemisphere to the bit.
            reach: if settings.spread < 180.0 { (0.5 * settings.spread).to_radians().sin() } else { 1.0 },
            bias: settings.bias_angle.to_radians().sin(),
            budget: Budget::of(settings),
            sampling: settings.sampling,
            cones: HemisphereCones::new(ConeSet::from_count(settings.cones).expect("validated")),
            epsilon: settings.epsilon,
            beta: settings.beta,
            gamma: settings.gamma,
            max_rays: settings.max_rays,
            seed: settings.seed,
        })
    }

    /// How many samples of its sequence each point may get: rays for `rays` and `hybrid`, else one frame of the method.
    pub fn samples(&self) -> u32 {
        if self.method.has_budget() { self.budget.rays } else { 1 }
    }
}
