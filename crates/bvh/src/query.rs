//! The queries: nearest hit, transmittance, visibility with falloff.

use crate::blas::TriangleTree;
use crate::bvh::Bvh;
use crate::hits::{Blocked, Faded, Nearest, Sink};
use crate::packet::{Packet, PacketIds, TriangleId};
use crate::placement::world_packet;
use crate::ray::{PreparedRay, Slab};
use crate::top::Placed;
use crate::traverse::{Leaves, cut, traverse};
use crate::triangle::{candidates, crossing};
use conray_core::{Falloff, Ray};
use fearless_simd::{Level, Simd, dispatch};

/// Where a ray meets a triangle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// Distance along the ray in world units (for unit directions), in (0, t_max).
    pub t: f32,
    /// Index into [`Geometry::instances`](conray_core::Geometry::instances), which knows the mesh.
    pub instance: u32,
    /// Index into the triangles of the instance's mesh.
    pub triangle: u32,
    /// Barycentric weight of the triangle's corner 1, in [0, 1].
    pub u: f32,
    /// Barycentric weight of the triangle's corner 2, in [0, 1]; corner 0 has the rest.
    pub v: f32,
}

impl Bvh {
    /// The first hit that blocks at least half of the light: opacity 0.5 or more, on either side of a surface.
    ///
    /// Of hits at one distance the one of lowest instance and then triangle is taken. `None` also for rays that can
    /// hit nothing: NaN or infinite origin, NaN, infinite or zero direction, `t_max` NaN or not above zero.
    pub fn nearest(&self, ray: &Ray) -> Option<Hit> {
        let mut sink = Nearest::new(&self.geometry, ray);
        self.visit(ray, &mut sink);
        sink.best
    }

    /// Share of light in [0, 1] that passes all surfaces with `0 < t < t_max`: the product of 1 - opacity.
    ///
    /// Rays that can hit nothing (see [`Bvh::nearest`]) give 1.
    pub fn transmittance(&self, ray: &Ray) -> f32 {
        let mut sink = Blocked::new(&self.geometry, ray);
        self.visit(ray, &mut sink);
        sink.transmittance()
    }

    /// Visibility in [0, 1] along one ray: 1 less each surface's opacity, weighed by the falloff at its distance and by
    /// what the surfaces before it let through.
    ///
    /// `distance` is the AO distance at which the falloff reaches zero; it may be infinite, then nothing fades. A ray
    /// longer than it only wastes time. With [`Falloff::None`] this is [`Bvh::transmittance`], and `distance` plays
    /// no part: `t_max` is the limit. A `distance` that is NaN or not above zero lets nothing occlude under a falloff.
    pub fn visibility(&self, ray: &Ray, falloff: Falloff, distance: f32) -> f32 {
        if falloff == Falloff::None || distance == f32::INFINITY {
            return self.transmittance(ray);
        }
        if distance.is_nan() || distance <= 0.0 {
            return 1.0;
        }
        // Not `min`, which would drop a NaN.
        let t_max = if distance < ray.t_max { distance } else { ray.t_max };
        let ray = Ray { t_max, ..*ray };
        let mut sink = Faded::new(&self.geometry, &ray);
        self.visit(&ray, &mut sink);
        sink.visibility(falloff, distance)
    }

    /// Hands every crossing within the sink's limit to it, in no particular order, until it has had enough.
    fn visit<K: Sink>(&self, ray: &Ray, sink: &mut K) {
        let Some(ray) = PreparedRay::new(ray) else { return };
        visit_at(self.level, self, &ray, sink);
    }
}

/// [`Bvh::visit`] at a level of SIMD.
fn visit_at<K: Sink>(level: Level, bvh: &Bvh, ray: &PreparedRay, sink: &mut K) {
    dispatch!(level, simd => visit_with(simd, bvh, ray, sink));
}

#[inline(always)]
fn visit_with<S: Simd, K: Sink>(simd: S, bvh: &Bvh, ray: &PreparedRay, sink: &mut K) {
    let slab = Slab::in_world(ray);
    let mut triangles = Triangles { tree: &bvh.flat, ray, placed: None, sink };
    let limit = triangles.sink.limit();
    let go_on = traverse(simd, &bvh.flat.tree, &slab, limit, &mut triangles);
    if go_on && !bvh.top.placed.is_empty() {
        let limit = sink.limit();
        traverse(simd, &bvh.top.tree, &slab, limit, &mut Placements { bvh, ray, sink });
    }
}

/// The leaves of the top level: trees of their own.
struct Placements<'a, K> {
    bvh: &'a Bvh,
    ray: &'a PreparedRay,
    sink: &'a mut K,
}

impl<K: Sink> Leaves for Placements<'_, K> {
    #[inline(always)]
    fn visit<S: Simd>(&mut self, simd: S, first: u32, items: u32) -> Option<f32> {
        for placed in &self.bvh.top.placed[first as usize..(first + items) as usize] {
            let tree = &self.bvh.trees[placed.tree as usize];
            let slab = Slab::in_mesh(self.ray, placed.mesh_space.as_ref());
            let mut triangles =
                Triangles { tree, ray: self.ray, placed: Some(placed), sink: &mut *self.sink };
            let limit = triangles.sink.limit();
            if !traverse(simd, &tree.tree, &slab, limit, &mut triangles) {
                return None;
            }
        }
        Some(self.sink.limit())
    }
}

/// The leaves of a tree of triangles: packets.
struct Triangles<'a, K> {
    tree: &'a TriangleTree,
    ray: &'a PreparedRay,
    placed: Option<&'a Placed>,
    sink: &'a mut K,
}

impl<K: Sink> Leaves for Triangles<'_, K> {
    #[inline(always)]
    fn visit<S: Simd>(&mut self, simd: S, first: u32, items: u32) -> Option<f32> {
        let (packet, ids) = (&self.tree.packets[first as usize], &self.tree.ids[first as usize]);
        let go_on = match self.placed {
            None => test(simd, packet, ids, items, self.ray, None, self.sink),
            Some(placed) => {
                let world = world_packet(simd, &placed.world_from_mesh, packet);
                test(simd, &world, ids, items, self.ray, Some(placed.instance), self.sink)
            }
        };
        go_on.then(|| self.sink.limit())
    }
}

/// Tests a packet's triangles; false where the sink has had enough.
#[inline(always)]
fn test<S: Simd, K: Sink>(
    simd: S,
    packet: &Packet,
    ids: &PacketIds,
    items: u32,
    ray: &PreparedRay,
    instance: Option<u32>,
    sink: &mut K,
) -> bool {
    let used = u32::MAX >> (32 - items);
    let mut mask = candidates(simd, packet, ray, cut(sink.limit())) & used;
    while mask != 0 {
        let lane = mask.trailing_zeros() as usize & 15;
        mask &= mask - 1;
        if !settle(&packet.lane(lane), &ids[lane], ray, instance, sink) {
            return false;
        }
    }
    true
}

/// The exact test of one candidate; false where the sink has had enough.
#[inline(never)]
fn settle<K: Sink>(
    corners: &[conray_core::Vec3; 3],
    id: &TriangleId,
    ray: &PreparedRay,
    instance: Option<u32>,
    sink: &mut K,
) -> bool {
    let Some(c) = crossing(corners, ray) else { return true };
    if c.t >= ray.t_max {
        return true;
    }
    let instance = instance.unwrap_or(id.instance);
    sink.take(Hit { t: c.t, instance, triangle: id.triangle(), u: c.u, v: c.v }, id.is_opaque())
}
