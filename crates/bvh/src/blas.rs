//! A bottom level: a tree over triangles, each leaf a packet.

use crate::collapse::LeafRule;
use crate::packet::{Packet, PacketIds, PlacedTriangle, TriangleId};
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
        let packets_expected = triangles.len() / 8;
        let mut packets = Vec::with_capacity(packets_expected);
        let mut ids = Vec::with_capacity(packets_expected);
        let mut opaque = Vec::with_capacity(packets_expected);
        let mut leaf = Vec::with_capacity(LEAF_RULE.max_items as usize);
        let tree = build_wide(&boxes, LEAF_RULE, |items| {
            let first = packets.len() as u32;
            leaf.clear();
            leaf.extend(items.iter().map(|&i| triangles[i as usize]));
            packets.push(Packet::new(&leaf));
            let bit = |(lane, t): (usize, &PlacedTriangle)| u16::from(t.id.is_opaque()) << lane;
            opaque.push(leaf.iter().enumerate().map(bit).sum());
            ids.push(std::array::from_fn(|i| leaf.get(i).map_or(TriangleId::default(), |t| t.id)));
            first
        });
        packets.shrink_to_fit();
        ids.shrink_to_fit();
        Self { tree, packets, ids, opaque, triangles: triangles.len() as u64 }
    }

    /// Bytes held.
    pub(crate) fn memory_bytes(&self) -> u64 {
        let packets = self.packets.capacity() * size_of::<Packet>();
        let ids = self.ids.capacity() * size_of::<PacketIds>();
        self.tree.memory_bytes() + (packets + ids) as u64
    }
}
