//! Image layers: one plane of 32-bit floats for each thing known about a pixel.

use crate::{AtlasMap, fill::fill_pending};
use conray_core::{ConeEstimate, Estimate, SurfacePoint};
use rayon::prelude::*;

/// A named plane.
#[derive(Clone, Debug, PartialEq)]
pub struct Channel {
    /// Its name, as in an EXR file: `visibility`, `A`, `error`, `cone.visibility`, `normal.X`, ...
    pub name: &'static str,
    /// One value per pixel, row by row from the top.
    pub values: Vec<f32>,
}

/// All that an image knows per pixel.
///
/// | channel | value | where the pixel sees nothing |
/// |---|---|---|
/// | `visibility` | linear, 1 = open; NaN while pending | 1 |
/// | `A` | coverage: 1 where there is a surface | 0 |
/// | `error` | expected error of the visibility; infinite while pending | 0 |
/// | `cone.visibility`, `cone.error`, `alpha` | what the cones said and their weight; NaN where a point has none | 1, 0, 1 |
/// | `rays` | rays traced for the pixel | 0 |
/// | `normal.X/Y/Z` | unit shading normal, world space | 0 |
/// | `position.X/Y/Z` | world position | 0 |
/// | `bent.X/Y/Z` | mean open direction, world space | 0 |
///
/// The three cone channels exist only if the method marched cones for any point.
#[derive(Clone, Debug, PartialEq)]
pub struct Layers {
    width: u32,
    height: u32,
    channels: Vec<Channel>,
    pending: usize,
}

/// Value of a channel for one point.
type Value = fn(&SurfacePoint, &Estimate) -> f32;

/// Name, value where the pixel sees nothing, value of a point.
type Recipe = (&'static str, f32, Value);

const RECIPES: [Recipe; 13] = [
    ("visibility", 1.0, |_, e| e.visibility),
    ("A", 0.0, |_, _| 1.0),
    ("error", 0.0, |_, e| e.error),
    ("rays", 0.0, |_, e| e.rays as f32),
    ("normal.X", 0.0, |p, _| p.shading_normal.x),
    ("normal.Y", 0.0, |p, _| p.shading_normal.y),
    ("normal.Z", 0.0, |p, _| p.shading_normal.z),
    ("position.X", 0.0, |p, _| p.position.x),
    ("position.Y", 0.0, |p, _| p.position.y),
    ("position.Z", 0.0, |p, _| p.position.z),
    ("bent.X", 0.0, |_, e| e.bent.x),
    ("bent.Y", 0.0, |_, e| e.bent.y),
    ("bent.Z", 0.0, |_, e| e.bent.z),
];

const CONE_RECIPES: [Recipe; 3] = [
    ("cone.visibility", 1.0, |_, e| cone(e, |c| c.visibility)),
    ("cone.error", 0.0, |_, e| cone(e, |c| c.error)),
    ("alpha", 1.0, |_, e| cone(e, |c| c.alpha)),
];

fn cone(estimate: &Estimate, value: fn(&ConeEstimate) -> f32) -> f32 {
    estimate.cone.as_ref().map_or(f32::NAN, value)
}

impl Layers {
    /// Scatters points and their estimates (equally many) over the pixels that the points' ids name.
    pub(crate) fn new(width: u32, height: u32, points: &[SurfacePoint], estimates: &[Estimate]) -> Self {
        let pixels = width as usize * height as usize;
        let with_cones = estimates.iter().any(|e| e.cone.is_some());
        let recipes = RECIPES.iter().chain(CONE_RECIPES.iter().filter(|_| with_cones));
        let channels = recipes
            .collect::<Vec<_>>()
            .into_par_iter()
            .map(|&(name, background, value)| {
                let mut values = vec![background; pixels];
                for (p, e) in points.iter().zip(estimates) {
                    values[p.id as usize] = value(p, e);
                }
                Channel { name, values }
            })
            .collect();
        let pending = estimates.iter().filter(|e| e.is_pending()).count();
        Self { width, height, channels, pending }
    }

    /// Those of a map, whose texels that no surface reads keep the values that islands were extended by.
    pub(crate) fn of_map(map: &AtlasMap) -> Self {
        let bent = |axis: usize| map.bent.iter().map(|bent| bent[axis]).collect();
        let channel = |name, values| Channel { name, values };
        let channels = vec![
            channel("visibility", map.visibility.clone()),
            channel("A", map.is_read.iter().map(|&is_read| f32::from(u8::from(is_read))).collect()),
            channel("error", map.error.clone()),
            channel("bent.X", bent(0)),
            channel("bent.Y", bent(1)),
            channel("bent.Z", bent(2)),
        ];
        Self { width: map.width, height: map.height, channels, pending: map.missing() }
    }

    /// Leaves out channels whose names begin so: what was not found out.
    pub fn leave_out(&mut self, prefix: &str) {
        self.channels.retain(|channel| !channel.name.starts_with(prefix));
    }

    /// Width in pixels.
    pub fn width(&self) -> u32 {
        self.width
    }

    /// Height in pixels.
    pub fn height(&self) -> u32 {
        self.height
    }

    /// All channels.
    pub fn channels(&self) -> &[Channel] {
        &self.channels
    }

    /// The values of one channel, if the method gave it.
    pub fn channel(&self, name: &str) -> Option<&[f32]> {
        self.channels.iter().find(|c| c.name == name).map(|c| c.values.as_slice())
    }

    /// Visibility per pixel: 1 where there is no surface, NaN where the estimate is pending.
    pub fn visibility(&self) -> &[f32] {
        self.channel("visibility").unwrap_or_default()
    }

    /// Coverage per pixel: 1 where there is a surface, else 0.
    pub fn coverage(&self) -> &[f32] {
        self.channel("A").unwrap_or_default()
    }

    /// How many pixels see a surface whose estimate is pending.
    pub fn pending(&self) -> usize {
        self.pending
    }

    /// Visibility with pending pixels filled from the nearest finished ones (in steps along rows and columns), so that
    /// the picture of interrupted work can be read; 0.5 where no pixel is finished.
    pub fn filled_visibility(&self) -> Vec<f32> {
        let mut values = self.visibility().to_vec();
        if self.pending > 0 {
            fill_pending(self.width as usize, &mut values, self.coverage());
        }
        values
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use conray_core::Vec3;

    fn point(id: u32) -> SurfacePoint {
        SurfacePoint::new(Vec3::new(id as f32, 2.0, 3.0), Vec3::Y).with_id(id)
    }

    fn estimate(visibility: f32, cone: Option<ConeEstimate>) -> Estimate {
        Estimate { visibility, error: 0.1, rays: 7, bent: Vec3::new(0.1, 0.2, 0.3), cone }
    }

    #[test]
    fn every_value_lands_in_its_pixel() {
        let cone = ConeEstimate { visibility: 0.6, error: 0.2, alpha: 0.3 };
        let layers = Layers::new(
            2,
            2,
            &[point(3), point(0), point(1)],
            &[estimate(0.25, Some(cone)), Estimate::PENDING, estimate(0.75, None)],
        );
        let at = |name: &str| layers.channel(name).unwrap();
        assert!(layers.visibility()[0].is_nan());
        assert_eq!(layers.visibility()[1..], [0.75, 1.0, 0.25]);
        assert_eq!(layers.coverage(), [1.0, 1.0, 0.0, 1.0]);
        assert_eq!(at("error"), [f32::INFINITY, 0.1, 0.0, 0.1]);
        assert_eq!(at("rays"), [0.0, 7.0, 0.0, 7.0]);
        assert_eq!(at("position.X"), [0.0, 1.0, 0.0, 3.0]);
        assert_eq!(at("normal.Y"), [1.0, 1.0, 0.0, 1.0]);
        assert_eq!(at("bent.Z"), [0.0, 0.3, 0.0, 0.3]);
        assert_eq!(at("cone.visibility")[2..], [1.0, 0.6]);
        assert_eq!(at("cone.error")[2..], [0.0, 0.2]);
        assert_eq!(at("alpha")[2..], [1.0, 0.3]);
        assert!(at("alpha")[..2].iter().all(|a| a.is_nan()), "points without cones have no alpha");
        assert_eq!(layers.pending(), 1);
        assert_eq!(layers.filled_visibility(), [0.75, 0.75, 1.0, 0.25]);
    }

    #[test]
    fn cone_channels_need_cones() {
        let layers = Layers::new(1, 1, &[point(0)], &[estimate(0.5, None)]);
        assert!(["cone.visibility", "cone.error", "alpha"].iter().all(|&n| layers.channel(n).is_none()));
        assert_eq!(layers.channels().len(), 13);
    }
}
