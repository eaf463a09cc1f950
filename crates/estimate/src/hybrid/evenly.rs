//! The same number of rays at every point, each answered by its own: where weighing costs more time than it saves.

use super::{
    Hybrid, Order,
    refine::Work,
    shown,
    tallies::{Rays, UNIT},
};

/// Rays grow so many times in a round, so that what they cost is known before most are traced.
const GROWTH: u32 = 4;

impl Hybrid {
    /// Brings all points to as many units as foreseen, step by step; false where nothing was left to do.
    pub(super) fn level(&mut self, work: &Work<'_>, until: f64) -> bool {
        let goal = (self.foreseen / f64::from(UNIT)) as u32;
        let units = |at: u32| self.tallies[at as usize].units;
        let least = self.pixels.covered().map(units).min().unwrap_or(0);
        let next = goal.min((GROWTH * least).max(self.rays.first));
        let missing = |at: u32| (units(at) < next).then(|| Order { at, units: next - units(at) });
        let orders: Vec<Order> = self.pixels.covered().filter_map(missing).collect();
        if orders.is_empty() {
            return false;
        }
        self.trace(work, &orders, until);
        self.know_by_own_rays();
        true
    }

    /// What each point's own rays tell; what neighbours said stays where it has none.
    fn know_by_own_rays(&mut self) {
        let tallies = shown(&self.tallies, &self.unfinished);
        for (at, tally) in tallies.iter().enumerate().filter(|(_, tally)| tally.units > 0) {
            // The variance of few units is itself uncertain: that of like neighbours counts for one more.
            let (units, own) = (tally.units as f32, self.rays.unit_variance(tally));
            let unit_variance = (own * units + self.known.unit_variance[at]) / (units + 1.0);
            self.known.value[at] = tally.mean();
            self.known.error2[at] = Rays::variance(unit_variance, tally.units);
        }
    }
}

#[cfg(test)]
mod tests {
    use crate::{AoPlan, AoSettings, Budget, Choice, Control, Distance, Ended, Hybrid};
    use conray_bvh::Bvh;
    use conray_core::{Affine3A, Geometry, SurfacePoint, TriangleMesh, Vec3};
    use std::sync::Arc;

    const SIZE: u32 = 16;

    /// Height 1 and very long.
    fn wall() -> Geometry {
        let corner = |y: f32, z: f32| Vec3::new(0.0, y, 1e3 * z);
        let corners = vec![corner(0.0, -1.0), corner(0.0, 1.0), corner(1.0, 1.0), corner(1.0, -1.0)];
        let mut geometry = Geometry::default();
        let mesh =
            geometry.add_mesh(TriangleMesh::new(corners, vec![[0, 1, 2], [0, 2, 3]]).unwrap()).unwrap();
        geometry.add_instance(mesh, Affine3A::IDENTITY).unwrap();
        geometry
    }

    #[test]
    fn even_rays_are_as_many_everywhere_and_each_point_its_own() {
        let geometry = wall();
        let settings = AoSettings { distance: Distance::Infinite, ..AoSettings::default() };
        let plan = AoPlan::new(&settings, geometry.bounds()).unwrap();
        let bvh = Bvh::build(Arc::new(geometry)).unwrap();
        let away = |id: u32| 0.1 + 0.1 * (id % SIZE) as f32;
        let point = |id: u32| {
            SurfacePoint::new(Vec3::new(away(id), 0.0, 0.1 * (id / SIZE) as f32), Vec3::Y).with_id(id)
        };
        let points: Vec<SurfacePoint> = (0..SIZE * SIZE).map(point).collect();
        let mut work = Hybrid::of_image(&plan, &points, 0, [SIZE, SIZE]);
        work.refine(&plan, &bvh, &points, Budget::rays(16), Control::none());
        assert_eq!(work.choice, Choice::Hybrid);
        work.choice = Choice::Evenly;
        let ended = work.refine(&plan, &bvh, &points, Budget::rays(1024), Control::none());
        assert_eq!(ended, Ended::Rays);
        let (mut squares, mut expected, mut independent) = (0.0, 0.0, 0.0);
        for (id, found) in work.estimates().iter().enumerate() {
            assert_eq!(found.rays, 1024);
            let away = away(id as u32);
            let truth = 0.5 + 0.5 * away / (away * away + 1.0).sqrt();
            squares += (found.visibility - truth).powi(2);
            expected += found.error.powi(2);
            independent += truth * (1.0 - truth) / 1024.0;
        }
        let to_independent = (squares / independent).sqrt();
        assert!(to_independent < 0.25, "{to_independent}");
        assert!((0.5..2.0).contains(&(expected / squares).sqrt()), "{}", (expected / squares).sqrt());
    }
}
