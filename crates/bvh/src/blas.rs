//! A bottom level: a tree over triangles, in packets of four.

use crate::packet::{Packet, PlacedTriangle, TriangleId};
use crate::refine::build_wide;
use crate::wide::{LeafRule, WideTree};
use conray_core::Bounds;

/// Leaves hold up to two packets. A packet's test costs about as much as a step through a node.
const LEAF_RULE: LeafRule = LeafRule { max_items: 8, group: 4, group_cost: 1.0 };

/// Triangles under a tree; leaves point at packets.
#[derive(Clone, Debug)]
pub(crate) struct TriangleTree {
    pub(crate) tree: WideTree,
    pub(crate) packets: Vec<Packet>,
    /// Four to a packet; lanes past a leaf's last triangle are never looked at.
    pub(crate) ids: Vec<[TriangleId; 4]>,
    /// How many triangles.
    pub(crate) triangles: u64,
}

impl TriangleTree {
    pub(crate) fn build(triangles: &[PlacedTriangle]) -> Self {
        let boxes: Vec<Bounds> = triangles.iter().map(|t| Bounds::of_points(t.corners)).collect();
        let packets_expected = triangles.len() / 2;
        let mut packets = Vec::with_capacity(packets_expected);
        let mut ids = Vec::with_capacity(packets_expected);
        let mut leaf = Vec::with_capacity(LEAF_RULE.max_items as usize);
        let tree = build_wide(&boxes, LEAF_RULE, |items| {
            let first = packets.len() as u32;
            leaf.clear();
            leaf.extend(items.iter().map(|&i| triangles[i as usize]));
            for four in leaf.chunks(4) {
                packets.push(Packet::new(four));
                ids.push([0, 1, 2, 3].map(|i| four.get(i).map_or(TriangleId::default(), |t| t.id)));
            }
            first
        });
        packets.shrink_to_fit();
        ids.shrink_to_fit();
        Self { tree, packets, ids, triangles: triangles.len() as u64 }
    }

    /// Bytes held.
    pub(crate) fn memory_bytes(&self) -> u64 {
        let packets = self.packets.capacity() * size_of::<Packet>();
        let ids = self.ids.capacity() * size_of::<[TriangleId; 4]>();
        self.tree.memory_bytes() + (packets + ids) as u64
    }
}
