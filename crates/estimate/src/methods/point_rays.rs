//! Rays that leave one surface point, and the tally of what they met.

use crate::AoPlan;
use conray_bvh::{BUNDLE_RAYS, Bvh, Directions};
use conray_core::{Estimate, Falloff, Frame, LANES, Ray, SurfacePoint, Vec3};
use fearless_simd::{Simd, dispatch, f32x16, prelude::*};

/// All that the rays of a point share.
pub(crate) struct PointRays<'a> {
    plan: &'a AoPlan,
    bvh: &'a Bvh,
    pub(crate) frame: Frame,
    geometric_normal: Vec3,
    origin: Vec3,
}

impl<'a> PointRays<'a> {
    pub(crate) fn new(plan: &'a AoPlan, bvh: &'a Bvh, point: &SurfacePoint) -> Self {
        Self {
            plan,
            bvh,
            frame: Frame::from_normal(point.shading_normal),
            geometric_normal: point.geometric_normal,
            origin: point.ray_origin(),
        }
    }

    /// Sine of the half-angle of the cone in which rays leave.
    #[inline]
    pub(crate) fn reach(&self) -> f32 {
        self.plan.reach
    }

    /// Visibility along each direction of a bundle, in world space.
    ///
    /// Below the geometric surface the point's own surface is in the way. Within the bias angle of the horizon what is in the way
    /// counts less and less.
    #[inline]
    pub(crate) fn visibilities(&self, directions: &Directions, out: &mut [f32]) {
        self.plain_visibilities(directions, out);
        if self.plan.bias > 0.0 {
            for (index, visible) in out.iter_mut().enumerate() {
                let height = directions.get(index).dot(self.frame.z);
                *visible = 1.0 - (1.0 - *visible) * (height / self.plan.bias).clamp(0.0, 1.0);
            }
        }
    }

    #[inline]
    fn plain_visibilities(&self, directions: &Directions, out: &mut [f32]) {
        let (origin, normal, distance) = (self.origin, self.geometric_normal, self.plan.distance);
        if self.plan.falloff == Falloff::None || distance == f32::INFINITY {
            return self.bvh.transmittances(origin, normal, directions, distance, out);
        }
        for (index, visible) in out.iter_mut().enumerate() {
            let direction = directions.get(index);
            *visible = if direction.dot(normal) > 0.0 {
                let ray = Ray { origin, direction, t_max: distance };
                self.bvh.visibility(&ray, self.plan.falloff, distance)
            } else {
                0.0
            };
        }
    }

    /// Traces a bundle into a tally and empties it.
    #[inline]
    pub(crate) fn trace(&self, directions: &mut Directions, tally: &mut Tally) {
        let mut visible = [0.0; BUNDLE_RAYS];
        self.visibilities(directions, &mut visible[..directions.len()]);
        dispatch!(self.bvh.level(), simd => tally.add_bundle(simd, directions, &visible));
        directions.clear();
    }

    /// The tally of a bundle whose visibilities are known.
    #[inline]
    pub(crate) fn tally(&self, directions: &Directions, visible: &[f32; BUNDLE_RAYS]) -> Tally {
        let mut tally = Tally::default();
        dispatch!(self.bvh.level(), simd => tally.add_bundle(simd, directions, visible));
        tally
    }
}

/// Rays of several tallies on their way into bundles.
pub(crate) struct RayQueue<'a> {
    rays: &'a PointRays<'a>,
    directions: Directions,
    /// The tally of each direction.
    owners: [u16; BUNDLE_RAYS],
}

impl<'a> RayQueue<'a> {
    pub(crate) fn new(rays: &'a PointRays<'a>) -> Self {
        Self { rays, directions: Directions::new(), owners: [0; BUNDLE_RAYS] }
    }

    /// Adds the first `count` of sixteen directions, axis by axis in world space, for one of the tallies.
    #[inline]
    pub(crate) fn push(
        &mut self,
        world: &[[f32; LANES]; 3],
        count: usize,
        owner: usize,
        tallies: &mut [Tally],
    ) {
        let [x, y, z] = world;
        for lane in 0..count {
            self.owners[self.directions.len()] = owner as u16;
            self.directions.push(Vec3::new(x[lane], y[lane], z[lane]));
            if self.directions.len() == BUNDLE_RAYS {
                self.trace(tallies);
            }
        }
    }

    /// Traces what is there.
    pub(crate) fn trace(&mut self, tallies: &mut [Tally]) {
        let mut visible = [0.0; BUNDLE_RAYS];
        let visible = &mut visible[..self.directions.len()];
        self.rays.visibilities(&self.directions, visible);
        for (index, (&visible, &owner)) in visible.iter().zip(&self.owners).enumerate() {
            tallies[owner as usize].add(visible, self.directions.get(index));
        }
        self.directions.clear();
    }
}

/// Sums over the rays of a point.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Tally {
    /// Rays traced.
    pub rays: u32,
    /// Sum of visibilities.
    pub sum: f32,
    /// Sum of squared visibilities.
    pub squares: f32,
    /// Sum of directions, each times its visibility.
    pub open: Vec3,
}

impl Tally {
    /// What the rays say.
    pub fn estimate(&self) -> Estimate {
        Estimate {
            visibility: self.mean(),
            error: self.variance_of_mean().sqrt(),
            rays: self.rays,
            bent: self.open / self.rays.max(1) as f32,
            cone: None,
        }
    }

    #[inline]
    pub(super) fn add(&mut self, visibility: f32, direction: Vec3) {
        self.rays += 1;
        self.sum += visibility;
        self.squares += visibility * visibility;
        self.open += visibility * direction;
    }

    /// Adds the rays of a bundle; what is past the last has visibility 0.
    #[inline(always)]
    fn add_bundle<S: Simd>(&mut self, simd: S, directions: &Directions, visible: &[f32; BUNDLE_RAYS]) {
        let mut sums = [f32x16::splat(simd, 0.0); 5];
        for (group, visible) in
            visible.as_chunks::<LANES>().0.iter().enumerate().take(directions.group_count())
        {
            let (visible, [x, y, z]) = (f32x16::from_slice(simd, visible), directions.group(simd, group));
            sums[0] += visible;
            sums[1] += visible * visible;
            sums[2] += visible * x;
            sums[3] += visible * y;
            sums[4] += visible * z;
        }
        self.rays += directions.len() as u32;
        self.sum += total(sums[0]);
        self.squares += total(sums[1]);
        self.open += Vec3::new(total(sums[2]), total(sums[3]), total(sums[4]));
    }

    /// Mean visibility; 0 without rays.
    pub(crate) fn mean(&self) -> f32 {
        self.sum / self.rays.max(1) as f32
    }

    /// Variance of the mean, as of independent rays.
    ///
    /// One open and one closed ray are added (the rule of succession), so that few rays that agree do not claim
    /// certainty. Stratified rays err less than this says.
    pub(crate) fn variance_of_mean(&self) -> f32 {
        let n = self.rays as f32 + 2.0;
        let mean = (self.sum + 1.0) / n;
        let variance = ((self.squares + 1.0) / n - mean * mean).max(0.0);
        variance / self.rays.max(1) as f32
    }
}

/// Sum of the lanes, in halves, so that every level of SIMD adds in the same order.
#[inline(always)]
fn total<S: Simd>(lanes: f32x16<S>) -> f32 {
    let (low, high) = lanes.split();
    let (low, high) = (low + high).split();
    let [a, b, c, d]: [f32; 4] = (low + high).into();
    (a + b) + (c + d)
}
