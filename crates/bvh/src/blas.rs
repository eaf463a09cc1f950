//! A bottom level: a tree over triangles, each leaf a packet.

use crate::collapse::LeafRule;
use crate::packet::{Packet, PacketIds, PlacedTriangle, TriangleId};
use crate::refine::build_wide;
use crate::wide::WideTree;
use conray_core::Bounds;
use rayon::prelude::*;
use std::ops::Range;

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
        // The leaves first, in order; their packets then in parallel.
        let (mut order, mut leaves) = (Vec::with_capacity(triangles.len()), Vec::new());
        let tree = build_wide(&boxes, LEAF_RULE, |items| {
            leaves.push(order.len()..order.len() + items.len());
            order.extend_from_slice(items);
            leaves.len() as u32 - 1
        });
        drop(boxes);
        let triangle = |lane: usize, leaf: &Range<usize>| triangles[order[leaf.start + lane] as usize];
        let packets = leaves
            .par_iter()
            .map(|leaf| Packet::new(leaf.len(), |lane| triangle(lane, leaf).corners))
            .collect();
        let id = |lane: usize, leaf: &Range<usize>| {
            if lane < leaf.len() { triangle(lane, leaf).id } else { TriangleId::default() }
        };
        let ids: Vec<PacketIds> =
            leaves.par_iter().map(|leaf| std::array::from_fn(|lane| id(lane, leaf))).collect();
        let bit = |(lane, id): (usize, &TriangleId)| u16::from(id.is_opaque()) << lane;
        let opaque = ids.iter().map(|ids| ids.iter().enumerate().map(bit).sum()).collect();
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
