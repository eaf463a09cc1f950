//! The boxes of a node against a bundle.

use super::directions::GROUPS;
use super::rays::BoxRays;
use crate::lanes::{Lanes, WIDTH, bits};
use crate::{node::Node, ray::Slab};
use fearless_simd::{Simd, f32x16, prelude::*, u16x32};

/// Bound on the rounding of a height over the surface, as a share of the sum of the absolute products: three differences,
/// products and sums for the box, as many for a direction that barely leads above. 8 u.
pub(super) const HEIGHT_ROUNDING: f32 = 8.0 / 16_777_216.0;

/// Work of one ray against the boxes of a node, and of one box against a group of rays, in vector instructions.
const RAY_WORK: u32 = 12;
const BOX_WORK: u32 = 18;

/// The boxes of a node, moved to the origin.
pub(super) struct NearBoxes {
    /// By axis: lowest and highest planes.
    planes: [[Lanes; 2]; 3],
    /// Squared distance of each box from the origin.
    distance: Lanes,
    /// Children that some ray may reach: within the AO distance and not wholly below the surface.
    pub(super) reachable: u32,
}

/// An axis of the boxes: what it adds to distance and height.
struct AxisPart<S: Simd> {
    low: f32x16<S>,
    high: f32x16<S>,
    gap: f32x16<S>,
    height: f32x16<S>,
    rounding: f32x16<S>,
}

impl NearBoxes {
    #[inline(always)]
    pub(super) fn new<S: Simd>(simd: S, node: &Node, rays: &BoxRays) -> Self {
        let x = axis_part(simd, node, rays, 0);
        let y = axis_part(simd, node, rays, 1);
        let z = axis_part(simd, node, rays, 2);
        let distance = z.gap.mul_add(z.gap, y.gap.mul_add(y.gap, x.gap * x.gap));
        let rounding = x.rounding + y.rounding + z.rounding;
        let height = x.height + y.height + z.height + rounding * f32x16::splat(simd, HEIGHT_ROUNDING);
        let near = bits(distance.simd_le(f32x16::splat(simd, rays.farthest_squared)));
        // Not "at or above": an unused slot is infinite, and its height may be no number.
        let below = bits(height.simd_lt(f32x16::splat(simd, 0.0)));
        let planes = [
            [Lanes::of(x.low), Lanes::of(x.high)],
            [Lanes::of(y.low), Lanes::of(y.high)],
            [Lanes::of(z.low), Lanes::of(z.high)],
        ];
        Self { planes, distance: Lanes::of(distance), reachable: near & !below }
    }

    /// Which rays meet which children, as far as that is worked out for all children at once.
    #[inline(always)]
    pub(super) fn met<S: Simd>(&self, simd: S, rays: &BoxRays, active: u64) -> MetBoxes {
        let by_boxes = self.reachable.count_ones() * groups_of(active) * BOX_WORK;
        if active.count_ones() * RAY_WORK >= by_boxes {
            return MetBoxes { children: self.reachable, by_ray: None };
        }
        let mut of_rays = RayBits([0; WIDTH * GROUPS]);
        let (mut children, mut left) = (0, active);
        while left != 0 {
            let [first, second] = take_two(&mut left);
            let (one, two) = (self.met_by_ray(simd, rays, first), self.met_by_ray(simd, rays, second));
            children |= one | two;
            of_rays.0[first] = one as u16;
            of_rays.0[second] = two as u16;
        }
        MetBoxes { children, by_ray: Some(of_rays) }
    }

    /// The active rays that meet the box of a child.
    #[inline(always)]
    pub(super) fn rays_to<S: Simd>(
        &self,
        simd: S,
        rays: &BoxRays,
        met: &MetBoxes,
        child: usize,
        active: u64,
    ) -> u64 {
        match &met.by_ray {
            Some(of_rays) => of_rays.of_child(simd, child),
            // A box around the origin is met by all.
            None if self.distance.0[child] == 0.0 => active,
            None => self.met_by_all(simd, rays, child, active),
        }
    }

    /// The boxes that one ray meets.
    #[inline(always)]
    fn met_by_ray<S: Simd>(&self, simd: S, rays: &BoxRays, ray: usize) -> u32 {
        let (group, lane) = (ray / WIDTH, ray % WIDTH);
        let inverse = &rays.inverse[group];
        let side = |axis: usize| (rays.negative[axis] >> ray & 1) as usize;
        let (sx, sy, sz) = (side(0), side(1), side(2));
        let ix = f32x16::splat(simd, inverse[0].0[lane]);
        let iy = f32x16::splat(simd, inverse[1].0[lane]);
        let iz = f32x16::splat(simd, inverse[2].0[lane]);
        let p = &self.planes;
        let (near_x, far_x) = (p[0][sx].load(simd) * ix, p[0][sx ^ 1].load(simd) * ix);
        let (near_y, far_y) = (p[1][sy].load(simd) * iy, p[1][sy ^ 1].load(simd) * iy);
        let (near_z, far_z) = (p[2][sz].load(simd) * iz, p[2][sz ^ 1].load(simd) * iz);
        let near = near_x.max(near_y).max(near_z.max(f32x16::splat(simd, 0.0)));
        let far = far_x.min(far_y).min(far_z) * f32x16::splat(simd, Slab::FAR);
        let far = far.min(f32x16::splat(simd, rays.t_max));
        bits(near.simd_le(far)) & self.reachable
    }

    /// Groups of sixteen rays against the box of a child.
    #[inline(always)]
    fn met_by_all<S: Simd>(&self, simd: S, rays: &BoxRays, child: usize, active: u64) -> u64 {
        let p = &self.planes;
        let (low_x, high_x) = (f32x16::splat(simd, p[0][0].0[child]), f32x16::splat(simd, p[0][1].0[child]));
        let (low_y, high_y) = (f32x16::splat(simd, p[1][0].0[child]), f32x16::splat(simd, p[1][1].0[child]));
        let (low_z, high_z) = (f32x16::splat(simd, p[2][0].0[child]), f32x16::splat(simd, p[2][1].0[child]));
        let zero = f32x16::splat(simd, 0.0);
        let t_max = f32x16::splat(simd, rays.t_max);
        let grown = f32x16::splat(simd, Slab::FAR);
        let mut met = 0;
        for group in 0..GROUPS {
            if active >> (WIDTH * group) & 0xffff == 0 {
                continue;
            }
            let inverse = &rays.inverse[group];
            let (ix, iy, iz) = (inverse[0].load(simd), inverse[1].load(simd), inverse[2].load(simd));
            let (ax, bx) = (low_x * ix, high_x * ix);
            let (ay, by) = (low_y * iy, high_y * iy);
            let (az, bz) = (low_z * iz, high_z * iz);
            let near = ax.min(bx).max(ay.min(by)).max(az.min(bz)).max(zero);
            let far = ax.max(bx).min(ay.max(by)).min(az.max(bz)) * grown;
            met |= u64::from(bits(near.simd_le(far.min(t_max)))) << (WIDTH * group);
        }
        met & active
    }
}

#[inline(always)]
fn axis_part<S: Simd>(simd: S, node: &Node, rays: &BoxRays, axis: usize) -> AxisPart<S> {
    let low = node.planes[axis][0].load(simd) - f32x16::splat(simd, rays.low_origin[axis]);
    let high = node.planes[axis][1].load(simd) - f32x16::splat(simd, rays.high_origin[axis]);
    let n = rays.normal[axis];
    let gap = low.max(-high).max(f32x16::splat(simd, 0.0));
    let height = if n >= 0.0 { high } else { low } * f32x16::splat(simd, n);
    let rounding = high.max(-low) * f32x16::splat(simd, n.abs());
    AxisPart { low, high, gap, height, rounding }
}

/// The children that some ray meets or may meet, and, where sixteen boxes were tested against each ray, which it met.
pub(super) struct MetBoxes {
    pub(super) children: u32,
    by_ray: Option<RayBits>,
}

/// Two of some rays, which are then left out; the same one twice where there is but one. Loops over pairs take one branch
/// where most nodes and leaves, which few rays reach, would otherwise be mispredicted.
#[inline(always)]
pub(super) fn take_two(rays: &mut u64) -> [usize; 2] {
    let first = rays.trailing_zeros() as usize & 63;
    *rays &= *rays - 1;
    let second = if *rays == 0 { first } else { rays.trailing_zeros() as usize & 63 };
    *rays &= rays.saturating_sub(1);
    [first, second]
}

/// How many groups of sixteen have a ray among some.
#[inline(always)]
pub(super) fn groups_of(rays: u64) -> u32 {
    (0..GROUPS).filter(|group| rays >> (WIDTH * group) & 0xffff != 0).count() as u32
}

/// For each ray a bit per child.
#[repr(C, align(64))]
struct RayBits([u16; WIDTH * GROUPS]);

impl RayBits {
    /// A bit for each ray that meets a child.
    #[inline(always)]
    fn of_child<S: Simd>(&self, simd: S, child: usize) -> u64 {
        let one = u16x32::splat(simd, 1 << child);
        let (low, high) = self.0.split_at(32);
        let low = (u16x32::from_slice(simd, low) & one).simd_eq(one).to_bitmask();
        let high = (u16x32::from_slice(simd, high) & one).simd_eq(one).to_bitmask();
        low | high << 32
    }
}
