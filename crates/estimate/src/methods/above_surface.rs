//! What of a cone lies above the geometric surface, where the hemisphere leans with the shading normal.

use conray_core::{HemisphereCones, Vec2, Vec3};
use conray_voxel::ConeResult;

/// Directions along a side of a cone's square.
const SIDE: u32 = 4;

/// Directions that stand for a cone.
const DIRECTIONS: usize = (SIDE * SIDE) as usize;

/// Directions that stand for each cone of a set, about the shading normal; component by component, so that a compiler can test
/// them side by side.
pub(super) struct AboveSurface {
    cones: Vec<[[f32; DIRECTIONS]; 3]>,
}

impl AboveSurface {
    pub(super) fn new(cones: &HemisphereCones) -> Self {
        let directions = |cone: &conray_core::Cone| {
            let direction = |i: usize| {
                let i = i as u32;
                let u = (Vec2::new((i % SIDE) as f32, (i / SIDE) as f32) + 0.5) / SIDE as f32;
                cone.sample(u)
            };
            [0, 1, 2].map(|k| std::array::from_fn(|i| direction(i)[k]))
        };
        Self { cones: cones.cones().iter().map(directions).collect() }
    }

    /// Takes from each cone's visibility the share of its directions that are below a surface, given by its normal in the frame
    /// of the cones: the point's own surface is in the way of those.
    pub(super) fn scale(&self, normal: Vec3, results: &mut [ConeResult]) {
        for ([x, y, z], result) in self.cones.iter().zip(results) {
            let mut above = [0u32; DIRECTIONS];
            for (i, above) in above.iter_mut().enumerate() {
                *above = u32::from(normal.x * x[i] + normal.y * y[i] + normal.z * z[i] > 0.0);
            }
            result.visibility *= above.iter().sum::<u32>() as f32 / DIRECTIONS as f32;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use conray_core::ConeSet;

    fn shares(normal: Vec3) -> Vec<f32> {
        let cones = HemisphereCones::new(ConeSet::Sixteen);
        let mut results = vec![ConeResult { visibility: 1.0, error: 0.0 }; 16];
        AboveSurface::new(&cones).scale(normal.normalize(), &mut results);
        results.iter().map(|r| r.visibility).collect()
    }

    #[test]
    fn a_surface_hides_what_is_below_it() {
        assert!(shares(Vec3::Z).iter().all(|&s| s == 1.0));
        assert!(shares(Vec3::NEG_Z).iter().all(|&s| s == 0.0));
        // Half of the hemisphere by area of its base is above a wall; tilted by an angle a, (1 + cos a) / 2.
        for (normal, truth) in [(Vec3::X, 0.5), (Vec3::new(1.0, 0.0, 1.0), 0.5 + 0.5 * 0.5f32.sqrt())] {
            let mean = shares(normal).iter().sum::<f32>() / 16.0;
            assert!((mean - truth).abs() < 0.02, "{normal}: {mean} {truth}");
        }
    }

    #[test]
    fn a_normal_that_is_not_a_number_hides_all() {
        let cones = HemisphereCones::new(ConeSet::Nine);
        let mut results = vec![ConeResult { visibility: 1.0, error: 0.0 }; 9];
        AboveSurface::new(&cones).scale(Vec3::NAN, &mut results);
        assert!(results.iter().all(|r| r.visibility == 0.0));
    }
}
