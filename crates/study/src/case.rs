//! A case: one scene seen from one view, built and ready for every contender.

use crate::{Answer, StudyError};
use conray::{
    AoSettings, Control, Session, SurfacePoint, Vec3, View,
    target::{CameraTarget, Target},
};
use std::{ops::Range, sync::Arc};

/// A scene seen from one view.
#[derive(Clone)]
pub struct Case {
    /// Unique in the study and fit for file names: `cornell-front`.
    pub id: String,
    /// Name of the scene.
    pub scene: String,
    /// The view.
    pub view: View,
    /// Places of interest: what the scene's other views show.
    pub places: Vec<Place>,
    /// What was built for the scene, with BVH and octree; views of one scene share it.
    pub session: Arc<Session>,
    /// The surface points behind the pixels.
    pub target: CameraTarget,
    /// Settings that all contenders share: distance, falloff, voxels, cones, the paper's constants, seed.
    pub settings: AoSettings,
}

impl Case {
    /// The surface points, in the order of every answer. The `id` of each is its pixel, `y * width + x`.
    pub fn points(&self) -> &[SurfacePoint] {
        self.target.points()
    }

    /// Width and height in pixels.
    pub fn size(&self) -> (u32, u32) {
        (self.target.camera().width(), self.target.camera().height())
    }

    /// Spreads one value a point over the pixels, row by row from the top.
    pub fn pixels(&self, values: &[f32], background: f32) -> Vec<f32> {
        let (width, height) = self.size();
        let mut pixels = vec![background; width as usize * height as usize];
        for (point, value) in self.points().iter().zip(values) {
            pixels[point.id as usize] = *value;
        }
        pixels
    }

    /// True for the pixels that see a surface.
    pub fn mask(&self) -> Vec<bool> {
        self.pixels(&vec![1.0; self.points().len()], 0.0).iter().map(|&v| v > 0.0).collect()
    }

    /// Carries out one of the product's methods on every point.
    ///
    /// # Errors
    /// A setting outside its range.
    pub fn answer(
        &self,
        settings: &AoSettings,
        samples: Range<u32>,
        control: Control<'_>,
    ) -> Result<Answer, StudyError> {
        let plan = self.session.plan_for(settings)?;
        let estimates = self.session.estimate_plan(&plan, samples, self.points(), control)?;
        let cones = if plan.method.needs_octree() { plan.cones.cones().len() } else { 0 };
        let rays = estimates.iter().map(|e| u64::from(e.rays)).sum();
        Ok(Answer::of(&estimates, rays, (cones * estimates.len()) as u64))
    }
}

/// What another view of the scene shows in its middle.
#[derive(Clone, Debug, PartialEq)]
pub struct Place {
    /// The view.
    pub view: View,
    /// How far from its eye the surface in its middle is, in world units.
    pub distance: f32,
}

impl Place {
    /// True for positions in the middle two thirds of the view, at most half as far again as what is in its centre.
    pub fn shows(&self, position: Vec3) -> bool {
        let from_eye = position - self.view.eye;
        let ahead = (self.view.look_at - self.view.eye).normalize_or_zero();
        let reach = (self.view.vertical_fov_deg.to_radians() / 3.0).cos();
        from_eye.length() <= 1.5 * self.distance && from_eye.normalize_or_zero().dot(ahead) >= reach
    }
}

/// A name made fit for files: letters, digits, `_` and `-` stay, all else becomes `-`.
pub(crate) fn file_name(text: &str) -> String {
    text.chars().map(|c| if c.is_ascii_alphanumeric() || c == '_' { c } else { '-' }).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_of_views_make_no_paths() {
        assert_eq!(file_name("../a b/c\\d.é"), "---a-b-c-d--");
        assert_eq!(file_name("front_2"), "front_2");
    }

    #[test]
    fn a_place_shows_what_is_near_the_middle_of_its_view() {
        let (eye, look_at) = (Vec3::ZERO, Vec3::Z);
        let view = View { name: "near".into(), eye, look_at, up: Vec3::Y, vertical_fov_deg: 60.0 };
        let place = Place { view, distance: 2.0 };
        assert!(place.shows(Vec3::new(0.0, 0.5, 2.0)));
        for outside in [Vec3::new(0.0, 1.0, 2.0), 4.0 * Vec3::Z, Vec3::NEG_Z, Vec3::ZERO] {
            assert!(!place.shows(outside), "{outside}");
        }
    }
}
