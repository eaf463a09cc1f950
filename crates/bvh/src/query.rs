//! The queries: nearest hit, transmittance, visibility with falloff.

use crate::bvh::Bvh;
use crate::hits::{Blocked, Faded, Nearest, Sink};
use crate::packet::{Packet, TriangleId};
use crate::placement::world_packet;
use crate::ray::{PreparedRay, Slab};
use crate::traverse::{cut, traverse};
use crate::triangle::{candidates, crossing};
use conray_core::{Falloff, Ray};

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
        let mut sink = Nearest::new(&self.geometry, ray.t_max);
        self.visit(ray, &mut sink);
        sink.best
    }

    /// Share of light in [0, 1] that passes all surfaces with `0 < t < t_max`: the product of 1 - opacity.
    ///
    /// Rays that can hit nothing (see [`Bvh::nearest`]) give 1.
    pub fn transmittance(&self, ray: &Ray) -> f32 {
        let mut sink = Blocked::new(&self.geometry, ray.t_max);
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
        let mut sink = Faded::new(&self.geometry, t_max);
        self.visit(&Ray { t_max, ..*ray }, &mut sink);
        sink.visibility(falloff, distance)
    }

    /// Hands every crossing within the sink's limit to it, in no particular order, until it has had enough.
    fn visit<S: Sink>(&self, ray: &Ray, sink: &mut S) {
        let Some(ray) = PreparedRay::new(ray) else { return };
        let slab = Slab::in_world(&ray);
        let flat = &self.flat;
        let go_on = traverse(&flat.tree, &slab, sink.limit(), |first, items| {
            for (packet, lanes) in packets_of(first, items) {
                if !test(&flat.packets[packet], &flat.ids[packet], lanes, &ray, None, sink) {
                    return None;
                }
            }
            Some(sink.limit())
        });
        if go_on && !self.top.placed.is_empty() {
            self.visit_instances(&ray, &slab, sink);
        }
    }

    #[inline(never)]
    fn visit_instances<S: Sink>(&self, ray: &PreparedRay, slab: &Slab, sink: &mut S) {
        traverse(&self.top.tree, slab, sink.limit(), |first, items| {
            for placed in &self.top.placed[first as usize..(first + items) as usize] {
                let tree = &self.trees[placed.tree as usize];
                let slab = Slab::in_mesh(ray, placed.mesh_space.as_ref());
                let go_on = traverse(&tree.tree, &slab, sink.limit(), |first, items| {
                    for (packet, lanes) in packets_of(first, items) {
                        let world = world_packet(&placed.world_from_mesh, &tree.packets[packet]);
                        if !test(&world, &tree.ids[packet], lanes, ray, Some(placed.instance), sink) {
                            return None;
                        }
                    }
                    Some(sink.limit())
                });
                if !go_on {
                    return None;
                }
            }
            Some(sink.limit())
        });
    }
}

/// Packets of a leaf, each with the mask of lanes in use.
#[inline(always)]
fn packets_of(first: u32, items: u32) -> impl Iterator<Item = (usize, u32)> {
    (0..items.div_ceil(4)).map(move |i| {
        let used = (items - 4 * i).min(4);
        ((first + i) as usize, (1 << used) - 1)
    })
}

/// Tests a packet's triangles; false where the sink has had enough.
#[inline(always)]
fn test<S: Sink>(
    packet: &Packet,
    ids: &[TriangleId; 4],
    lanes: u32,
    ray: &PreparedRay,
    instance: Option<u32>,
    sink: &mut S,
) -> bool {
    let mut mask = candidates(packet, ray, cut(sink.limit())) & lanes;
    while mask != 0 {
        let lane = mask.trailing_zeros() as usize & 3;
        mask &= mask - 1;
        if !settle(&packet.lane(lane), &ids[lane], ray, instance, sink) {
            return false;
        }
    }
    true
}

/// The exact test of one candidate; false where the sink has had enough.
#[inline(never)]
fn settle<S: Sink>(
    corners: &[conray_core::Vec3; 3],
    id: &TriangleId,
    ray: &PreparedRay,
    instance: Option<u32>,
    sink: &mut S,
) -> bool {
    let Some(c) = crossing(corners, ray) else { return true };
    if c.t >= ray.t_max {
        return true;
    }
    let instance = instance.unwrap_or(id.instance);
    sink.take(Hit { t: c.t, instance, triangle: id.triangle(), u: c.u, v: c.v }, id.is_opaque())
}
