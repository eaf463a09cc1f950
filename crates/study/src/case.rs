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
    /// Places of interest: what is in the middle of the scene's other views, by their names, in world space.
    pub places: Vec<(String, Vec3)>,
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
        Ok(Answer {
            visibility: estimates.iter().map(|e| e.visibility).collect(),
            expected_error: Some(estimates.iter().map(|e| e.error).collect()),
            rays: estimates.iter().map(|e| u64::from(e.rays)).sum(),
            cones: (cones * estimates.len()) as u64,
        })
    }
}
