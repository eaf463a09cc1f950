//! A bottom level: a tree over triangles, each leaf a packet.

use crate::collapse::LeafRule;
use crate::packet::{Packet, PacketIds, PlacedTriangle};
use crate::refine::build_wide;
use crate::wide::WideTree;
use conray_core::Bounds;
use rayon::prelude::*;

/// A leaf holds one packet. Its cost is that of setting the packet up for a bundle; a triangle more in it costs nothing. Groups
/// of one trace no faster than of four and take twice as long to build.
const LEAF_RULE: LeafRule = LeafRule { max_items: 16, group: 4, leaf_cost: 2.0, item_cost: 0.0 };

/// Triangles under a tree; leaves point at packets.
#[derive(Clone, Debug)]
pub(crate) struct TriangleTree {
    pub(crate) tree: WideTree,
    pub(crate) packets: Vec<Packet>,
    /// Lanes past a leaf's last triangle are never looked at.
    pub(crate) ids: Vec<PacketIds>,
    /// For each packet a bit for each triangle that needs no opacity looked up.
    pub(crate) opaque: Vec<u16>,
    /// How many triangles.
    pub(crate) triangles: u64,
}

impl TriangleTree {
    pub(crate) fn build(triangles: &[PlacedTriangle]) -> Self {
        let boxes: Vec<Bounds> = triangles.par_iter().map(|t| Bounds::of_points(t.corners)).collect();
        let (tree, leaves) = build_wide(&boxes, LEAF_RULE);
        drop(boxes);
        let of_leaf = |leaf: usize| {
            let items = leaves.get(leaf);
            let triangle = |lane: usize| &triangles[items[lane] as usize];
            let packet = Packet::new(items.len(), |lane| triangle(lane).corners);
            let mut ids = PacketIds::default();
            let mut opaque = 0;
            for (lane, id) in ids.iter_mut().enumerate().take(items.len()) {
                *id = triangle(lane).id;
                opaque |= u16::from(id.is_opaque()) << lane;
            }
            (packet, (ids, opaque))
        };
        let (packets, (ids, opaque)): (Vec<_>, (Vec<_>, Vec<_>)) =
            (0..leaves.len()).into_par_iter().map(of_leaf).unzip();
        Self { tree, packets, ids, opaque, triangles: triangles.len() as u64 }
    }

    /// Bytes held.
    pub(crate) fn memory_bytes(&self) -> u64 {
        let packets = self.packets.capacity() * size_of::<Packet>();
        let ids = self.ids.capacity() * size_of::<PacketIds>();
        let opaque = size_of_val(self.opaque.as_slice());
        self.tree.memory_bytes() + (packets + ids + opaque) as u64
    }
}
