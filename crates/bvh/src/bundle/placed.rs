//! Bundles among placed meshes: boxes are met in the mesh's space, triangles in the world.

use super::Met;
use super::directions::GROUPS;
use super::leaf::Triangles;
use super::rays::{BoxRays, Rays};
use super::walk::{Leaves, walk};
use crate::bvh::Bvh;
use crate::lanes::Lanes;
use crate::mesh_space::MeshSpace;
use fearless_simd::{Simd, f32x16, prelude::*};

/// The leaves of the top level: trees of their own.
pub(super) struct Placements<'a> {
    pub(super) bvh: &'a Bvh,
    pub(super) rays: &'a Rays<'a>,
    pub(super) met: &'a mut Met,
}

impl Leaves for Placements<'_> {
    #[inline(always)]
    fn open(&self) -> u64 {
        self.rays.all & !self.met.blocked
    }

    /// `None` where a tree is too deep or a placement cannot be undone.
    #[inline(always)]
    fn visit<S: Simd>(&mut self, simd: S, first: u32, items: u32, active: u64) -> Option<()> {
        for placed in &self.bvh.top.placed[first as usize..(first + items) as usize] {
            let boxes = in_mesh(simd, self.rays, placed.mesh_space.as_ref()?)?;
            let tree = &self.bvh.trees[placed.tree as usize];
            let mut triangles = Triangles {
                geometry: &self.bvh.geometry,
                tree,
                placed: Some(placed),
                rays: self.rays,
                all: active,
                met: &mut *self.met,
            };
            walk(simd, &tree.tree, &boxes, &mut triangles)?;
        }
        Some(())
    }
}

/// The rays as the boxes of a placed mesh see them; `None` beyond single precision.
#[inline(always)]
fn in_mesh<S: Simd>(simd: S, rays: &Rays<'_>, space: &MeshSpace) -> Option<BoxRays> {
    let bundle = space.bundle(rays.origin, rays.boxes.normal)?;
    let m = bundle.mesh_from_world;
    let mut directions = [[Lanes::ZERO; 3]; GROUPS];
    for (placed, [x, y, z]) in directions.iter_mut().zip(rays.directions) {
        let (x, y, z) = (x.load(simd), y.load(simd), z.load(simd));
        for (axis, placed) in placed.iter_mut().enumerate() {
            let (mx, my) = (f32x16::splat(simd, m.x_axis[axis]), f32x16::splat(simd, m.y_axis[axis]));
            let mz = f32x16::splat(simd, m.z_axis[axis]);
            *placed = Lanes::of(z.mul_add(mz, y.mul_add(my, x * mx)));
        }
    }
    let farthest_squared = (rays.boxes.farthest_squared * bundle.stretch_squared).min(f32::MAX);
    let origins = [bundle.origin + bundle.slack, bundle.origin - bundle.slack];
    let groups = &directions[..rays.directions.len()];
    Some(BoxRays::new(simd, groups, origins, bundle.normal, farthest_squared, rays.t_max))
}
