//! A leaf against a bundle: the wide test, and the exact one where that is not sure or an opacity must be looked up.

use super::boxes::{groups_of, take_two};
use super::triangles::{Decided, HalfSpaces};
use super::walk::Leaves;
use super::{Met, rays::Rays};
use crate::blas::TriangleTree;
use crate::hits::opacity;
use crate::packet::{Packet, PacketIds};
use crate::placement::world_packet;
use crate::query::Hit;
use crate::ray::PreparedRay;
use crate::top::Placed;
use crate::triangle::crossing;
use crate::visits::{Visit, count};
use conray_core::{Geometry, Ray};
use fearless_simd::Simd;

/// The leaves of a tree of triangles: packets.
pub(super) struct Triangles<'a> {
    pub(super) geometry: &'a Geometry,
    pub(super) tree: &'a TriangleTree,
    /// Where the tree is in a mesh's space.
    pub(super) placed: Option<&'a Placed>,
    pub(super) rays: &'a Rays<'a>,
    /// The rays that come to the tree.
    pub(super) all: u64,
    pub(super) met: &'a mut Met,
}

impl Leaves for Triangles<'_> {
    #[inline(always)]
    fn open(&self) -> u64 {
        self.all & !self.met.blocked
    }

    #[inline(always)]
    fn visit<S: Simd>(&mut self, simd: S, first: u32, items: u32, active: u64) -> Option<()> {
        let (tree, first) = (self.tree, first as usize);
        let (packet, ids, opaque) = (&tree.packets[first], &tree.ids[first], u32::from(tree.opaque[first]));
        let geometry = self.geometry;
        let (world, instance);
        let packet = match self.placed {
            None => {
                instance = None;
                packet
            }
            Some(placed) => {
                instance = Some(placed.instance);
                world = world_packet(simd, &placed.world_from_mesh, packet);
                &world
            }
        };
        Leaf { geometry, packet, ids, items, opaque, instance }.test(simd, self.rays, active, self.met);
        Some(())
    }
}

/// Triangles of one leaf, in world space.
struct Leaf<'a> {
    geometry: &'a Geometry,
    packet: &'a Packet,
    ids: &'a PacketIds,
    /// How many triangles.
    items: u32,
    /// A bit for each that blocks all.
    opaque: u32,
    /// Where the ids do not know it.
    instance: Option<u32>,
}

impl Leaf<'_> {
    /// Tests the active rays, none of them blocked yet.
    #[inline(always)]
    fn test<S: Simd>(&self, simd: S, rays: &Rays<'_>, active: u64, met: &mut Met) {
        let triangles = HalfSpaces::new(simd, self.packet, u32::MAX >> (32 - self.items), rays);
        count(Visit::Leaf, 1);
        count(Visit::LeafRay, active.count_ones());
        count(Visit::Triangle, triangles.possible.count_ones());
        if triangles.possible == 0 {
            return;
        }
        if active.count_ones() <= triangles.possible.count_ones() * groups_of(active) {
            let (mut left, mut touched) = (active, 0);
            while left != 0 {
                for ray in take_two(&mut left) {
                    let decided = triangles.met_by_ray(simd, rays.direction(ray));
                    let blocked = decided.inside as u32 & self.opaque != 0;
                    let open = (decided.inside | decided.unsure) != 0 && !blocked;
                    met.blocked |= u64::from(blocked) << ray;
                    touched |= u64::from(open) << ray;
                }
            }
            // Few: tested again here rather than kept for all.
            while touched != 0 {
                let ray = touched.trailing_zeros() as usize & 63;
                touched &= touched - 1;
                self.settle_ray(ray, triangles.met_by_ray(simd, rays.direction(ray)), rays, met);
            }
        } else {
            let mut left = triangles.possible;
            while left != 0 {
                let triangle = left.trailing_zeros() as usize & 15;
                left &= left - 1;
                let decided = triangles.met_by_groups(simd, triangle, rays, active & !met.blocked);
                if decided.inside | decided.unsure != 0 {
                    self.settle_triangle(triangle, decided, rays, met);
                }
            }
        }
    }

    /// What a ray's meetings with triangles come to.
    #[inline(always)]
    fn settle_ray(&self, ray: usize, decided: Decided, rays: &Rays<'_>, met: &mut Met) {
        let mut left = decided.inside | decided.unsure;
        while left != 0 && met.blocked >> ray & 1 == 0 {
            let triangle = left.trailing_zeros() as usize & 15;
            left &= left - 1;
            self.settle(triangle, ray, rays, met);
        }
    }

    /// What a triangle's meetings with rays come to.
    #[inline(always)]
    fn settle_triangle(&self, triangle: usize, decided: Decided, rays: &Rays<'_>, met: &mut Met) {
        let mut left = decided.inside | decided.unsure;
        if self.ids[triangle].is_opaque() {
            met.blocked |= decided.inside;
            left = decided.unsure;
        }
        while left != 0 {
            let ray = left.trailing_zeros() as usize & 63;
            left &= left - 1;
            self.settle(triangle, ray, rays, met);
        }
    }

    /// The exact test of one ray and one triangle, and its opacity where they meet.
    #[cold]
    #[inline(never)]
    fn settle(&self, triangle: usize, ray: usize, rays: &Rays<'_>, met: &mut Met) {
        count(Visit::Exact, 1);
        let line = Ray { origin: rays.origin, direction: rays.direction(ray), t_max: rays.t_max };
        let Some(prepared) = PreparedRay::new(&line) else { return };
        let Some(crossing) = crossing(&self.packet.lane(triangle), &prepared) else { return };
        if crossing.t >= rays.t_max {
            return;
        }
        let id = &self.ids[triangle];
        let instance = self.instance.unwrap_or(id.instance);
        let hit = Hit { t: crossing.t, instance, triangle: id.triangle(), u: crossing.u, v: crossing.v };
        let opacity = opacity(self.geometry, &hit, line.direction, id.is_opaque());
        if opacity >= 1.0 {
            met.blocked |= 1 << ray;
        } else if opacity > 0.0 {
            met.unsettled |= 1 << ray;
        }
    }
}
