//! All that a person chooses, and the wish that it comes to.

use crate::{camera::Look, engine::Wish, layers::Layer};
use conray::{AoSettings, Device, Method, Sampling};

/// How large the picture is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum PictureSize {
    /// As many pixels as there is room for.
    #[default]
    Fit,
    /// Width and height in pixels, each at least 1.
    Fixed([u32; 2]),
}

/// What a person chose.
#[derive(Clone, Debug)]
pub struct Choices {
    /// All that both sides share; its method is that of the first.
    pub settings: AoSettings,
    /// The method at the right, while the picture is split.
    pub right_method: Method,
    /// What is shown at the left, or of the whole picture, and at the right.
    pub layers: [Layer; 2],
    /// True while two methods are shown side by side.
    pub is_split: bool,
    /// Where the picture is split: a share of its width.
    pub split_at: f32,
    /// Where estimates are made.
    pub device: Device,
    /// Part of the name of the adapter that is meant; empty for the first.
    pub adapter: String,
    /// How large the picture is.
    pub size: PictureSize,
    /// From where.
    pub look: Option<Look>,
    /// Counts how often the same was asked for anew.
    pub again: u32,
}

/// The error at which refining ends unless another is chosen: a quarter of what is hardly seen.
pub const DEFAULT_ERROR: f32 = 0.005;

/// What the viewer begins with: the library's defaults, but that it refines further.
pub fn default_settings() -> AoSettings {
    AoSettings { error: Some(DEFAULT_ERROR), ..AoSettings::default() }
}

impl Default for Choices {
    fn default() -> Self {
        Self {
            settings: default_settings(),
            right_method: Method::Rays,
            layers: [Layer::Visibility; 2],
            is_split: false,
            split_at: 0.5,
            device: Device::Auto,
            adapter: String::new(),
            size: PictureSize::Fit,
            look: None,
            again: 0,
        }
    }
}

impl Choices {
    /// The settings of each side: what a method does not have is left out of its own.
    pub fn sides(&self) -> Vec<AoSettings> {
        let right = self.is_split.then_some(self.right_method);
        std::iter::once(self.settings.method).chain(right).map(|method| self.settings_by(method)).collect()
    }

    /// The settings as one method takes them.
    pub fn settings_by(&self, method: Method) -> AoSettings {
        let all = AoSettings { method, ..self.settings.clone() };
        let defaults = AoSettings::default();
        if method.has_budget() {
            let stratified = all.sampling == Sampling::Stratified;
            // Jittered rays are a fixed number: neither time nor error can end them.
            let (time, error) = if stratified { (None, None) } else { (all.time, all.error) };
            AoSettings { time, error, ..all }
        } else {
            let AoSettings { spread, bias_angle, .. } = defaults;
            AoSettings { time: None, error: None, rays: None, spread, bias_angle, ..all }
        }
    }

    /// The wish for a scene, where there is room for so many pixels; `None` while there is none, or no view yet.
    pub fn wish(&self, scene: u64, room: [u32; 2]) -> Option<Wish> {
        let size = match self.size {
            PictureSize::Fit => room,
            PictureSize::Fixed(size) => size,
        };
        let adapter = Some(self.adapter.trim().to_owned()).filter(|name| !name.is_empty());
        (!size.contains(&0) && !room.contains(&0)).then_some(())?;
        let (look, device, again) = (self.look?, self.device, self.again);
        Some(Wish { scene, look, size, sides: self.sides(), device, adapter, again })
    }

    /// What a truth belongs to: the same words, the same truth.
    pub fn truth_key(wish: &Wish) -> String {
        let AoSettings { distance, falloff, spread, bias_angle, alpha, .. } = &wish.sides[0];
        let settings = (distance, falloff, spread, bias_angle, alpha);
        format!("{} {:?} {:?} {settings:?}", wish.scene, wish.look, wish.size)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn choices() -> Choices {
        let look =
            Look { eye: [0.0, 0.0, 3.0], look_at: [0.0; 3], up: [0.0, 1.0, 0.0], vertical_fov_deg: 40.0 };
        Choices { look: Some(look), ..Choices::default() }
    }

    #[test]
    fn every_pair_of_methods_gives_settings_that_are_valid() {
        for sampling in Sampling::ALL {
            for method in Method::ALL {
                for right_method in Method::ALL {
                    let settings = AoSettings {
                        method,
                        sampling,
                        rays: Some(64),
                        time: Some(3.0),
                        spread: 90.0,
                        bias_angle: 10.0,
                        ..default_settings()
                    };
                    let choices = Choices { settings, right_method, is_split: true, ..choices() };
                    let sides = choices.sides();
                    assert_eq!([sides[0].method, sides[1].method], [method, right_method]);
                    for side in sides {
                        side.validate().unwrap();
                    }
                }
            }
        }
    }

    #[test]
    fn there_is_no_wish_without_room_or_view() {
        assert!(choices().wish(1, [0, 100]).is_none());
        assert!(Choices { look: None, ..choices() }.wish(1, [100, 100]).is_none());
        let fixed = Choices { size: PictureSize::Fixed([512, 512]), ..choices() };
        assert_eq!(fixed.wish(1, [100, 80]).unwrap().size, [512, 512]);
        assert!(fixed.wish(1, [0, 0]).is_none(), "a window that is folded up shows nothing");
    }

    #[test]
    fn a_truth_belongs_to_what_it_depends_on() {
        let key = |choices: &Choices| Choices::truth_key(&choices.wish(1, [64, 64]).unwrap());
        let mut other = choices();
        other.settings.rays = Some(7);
        other.settings.method = Method::Cones;
        assert_eq!(key(&other), key(&choices()), "rays and method change no truth");
        other.settings.distance = 2.0.into();
        assert_ne!(key(&other), key(&choices()));
        let turned = Choices { look: Some(choices().look.unwrap().orbit(0.1, 0.0)), ..choices() };
        assert_ne!(key(&turned), key(&choices()));
    }
}
