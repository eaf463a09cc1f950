//! Triangles as leaves hold them: up to sixteen side by side, with the ids apart.

use crate::lanes::{Lanes, WIDTH};
use conray_core::Vec3;

/// Corners of up to sixteen triangles: `corners[corner][axis]`, one triangle a lane.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Packet {
    pub(crate) corners: [[Lanes; 3]; 3],
}

/// Whose triangles a packet's are.
pub(crate) type PacketIds = [TriangleId; WIDTH];

/// Whose triangle it is, and whether its opacity must be looked up.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct TriangleId {
    /// Instance; 0 in the tree of an instanced mesh, where the top level knows it.
    pub(crate) instance: u32,
    /// Triangle of the mesh, below 2^31; the top bit marks opaque ones.
    tagged_triangle: u32,
}

impl TriangleId {
    const OPAQUE: u32 = 1 << 31;

    pub(crate) fn new(instance: u32, triangle: u32, opaque: bool) -> Self {
        debug_assert!(triangle < Self::OPAQUE);
        Self { instance, tagged_triangle: triangle | if opaque { Self::OPAQUE } else { 0 } }
    }

    /// Triangle of the mesh.
    #[inline]
    pub(crate) fn triangle(self) -> u32 {
        self.tagged_triangle & !Self::OPAQUE
    }

    /// No opacity look-up is needed.
    #[inline]
    pub(crate) fn is_opaque(self) -> bool {
        self.tagged_triangle & Self::OPAQUE != 0
    }
}

/// A triangle on its way into packets.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PlacedTriangle {
    pub(crate) corners: [Vec3; 3],
    pub(crate) id: TriangleId,
}

impl PlacedTriangle {
    /// False where two corners coincide: such a triangle occludes nothing, and without it its neighbours still close.
    ///
    /// A triangle whose corners lie on a line but apart is kept: where a mesh has one, it closes the gap between one
    /// long edge and two short ones that rounding would open.
    pub(crate) fn has_three_corners(&self) -> bool {
        let [a, b, c] = self.corners;
        a != b && b != c && c != a
    }
}

impl Packet {
    /// A packet of `count`, one to sixteen, triangles; the lanes past the last repeat it.
    pub(crate) fn new(count: usize, corners: impl Fn(usize) -> [Vec3; 3]) -> Self {
        let mut packet = Self { corners: [[Lanes::ZERO; 3]; 3] };
        for lane in 0..WIDTH {
            for (corner, position) in packet.corners.iter_mut().zip(corners(lane.min(count - 1))) {
                for (axis, lanes) in corner.iter_mut().enumerate() {
                    lanes.0[lane] = position[axis];
                }
            }
        }
        packet
    }

    /// Corners of one triangle.
    #[inline]
    pub(crate) fn lane(&self, lane: usize) -> [Vec3; 3] {
        let lane = lane & (WIDTH - 1);
        // Written out: closures over arrays are not always made part of the caller.
        let [a, b, c] = &self.corners;
        let corner = |[x, y, z]: &[Lanes; 3]| Vec3::new(x.0[lane], y.0[lane], z.0[lane]);
        [corner(a), corner(b), corner(c)]
    }
}
