//! Node layout: sixteen children a node, their boxes side by side.

use crate::lanes::{Lanes, WIDTH};
use conray_core::{Bounds, Vec3};
use fearless_simd::{Simd, prelude::*, u32x16};

/// What a child slot refers to: an inner node, a leaf of one to sixteen items, or nothing.
///
/// Bit 31 marks a leaf; then bits 27 to 30 hold the number of items less one and bits 0 to 26 the leaf's number: that of its
/// packet for triangles, and that of its only item for placements.
#[derive(Clone, Copy, Debug, PartialEq, Eq, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(transparent)]
pub(crate) struct Child(u32);

/// What [`Child`] unpacks to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum ChildKind {
    /// Index of another node.
    Inner(u32),
    /// Number of the leaf, and how many items it has.
    Leaf(u32, u32),
}

impl Child {
    /// An unused slot. As a leaf it would be the very last one, which [`Child::MAX_FIRST`] rules out.
    pub(crate) const EMPTY: Self = Self(u32::MAX);
    /// Most items a leaf can hold.
    pub(crate) const MAX_ITEMS: u32 = WIDTH as u32;
    /// Largest index that a leaf can have.
    pub(crate) const MAX_FIRST: u32 = (1 << 27) - 2;

    const LEAF: u32 = 1 << 31;

    pub(crate) fn inner(node: u32) -> Self {
        debug_assert!(node < Self::LEAF);
        Self(node)
    }

    pub(crate) fn leaf(first: u32, items: u32) -> Self {
        debug_assert!(first <= Self::MAX_FIRST && (1..=Self::MAX_ITEMS).contains(&items));
        Self(Self::LEAF | (items - 1) << 27 | first)
    }

    /// The same among nodes and leaves that come after so many others.
    pub(crate) fn moved(self, nodes: u32, leaves: u32) -> Self {
        match self.kind() {
            _ if self == Self::EMPTY => self,
            ChildKind::Inner(node) => Self::inner(node + nodes),
            ChildKind::Leaf(first, items) => Self::leaf(first + leaves, items),
        }
    }

    /// Of an inner node, its index.
    #[inline(always)]
    pub(crate) fn index(self) -> u32 {
        self.0
    }

    #[inline(always)]
    pub(crate) fn kind(self) -> ChildKind {
        if self.0 & Self::LEAF == 0 {
            ChildKind::Inner(self.0)
        } else {
            ChildKind::Leaf(self.0 & 0x07ff_ffff, (self.0 >> 27 & 15) + 1)
        }
    }
}

/// Sixteen children with their boxes: seven cache lines.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
pub(crate) struct Node {
    /// By axis, then lowest (0) or highest (1) plane, then child. Unused slots hold an empty box.
    pub(crate) planes: [[Lanes; 2]; 3],
    /// What the slots refer to; the used ones come first.
    pub(crate) children: [Child; WIDTH],
}

const _: () = assert!(size_of::<Node>() == 448);

impl Node {
    /// A node without children.
    pub(crate) const UNUSED: Self = Self {
        planes: [[Lanes([f32::INFINITY; WIDTH]), Lanes([f32::NEG_INFINITY; WIDTH])]; 3],
        children: [Child::EMPTY; WIDTH],
    };

    /// Fills one slot.
    pub(crate) fn set(&mut self, slot: usize, bounds: &Bounds, child: Child) {
        for axis in 0..3 {
            self.planes[axis][0].0[slot] = bounds.min[axis];
            self.planes[axis][1].0[slot] = bounds.max[axis];
        }
        self.children[slot] = child;
    }

    /// Box of one slot.
    pub(crate) fn bounds(&self, slot: usize) -> Bounds {
        let corner = |side: usize| Vec3::from_array([0, 1, 2].map(|axis| self.planes[axis][side].0[slot]));
        Bounds { min: corner(0), max: corner(1) }
    }

    /// A bit for each slot that holds a leaf; bits of unused slots are set as well.
    #[inline(always)]
    pub(crate) fn leaf_slots<S: Simd>(&self, simd: S) -> u32 {
        let children = u32x16::from_slice(simd, bytemuck::cast_slice(&self.children));
        children.simd_ge(u32x16::splat(simd, Child::LEAF)).to_bitmask() as u32
    }

    /// The used slots.
    pub(crate) fn slots(&self) -> impl Iterator<Item = (Bounds, Child)> + '_ {
        (0..WIDTH).filter(|&i| self.children[i] != Child::EMPTY).map(|i| (self.bounds(i), self.children[i]))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn children_unpack_to_what_was_packed() {
        for first in [0, 1, 12345, Child::MAX_FIRST] {
            for items in 1..=Child::MAX_ITEMS {
                let child = Child::leaf(first, items);
                assert_eq!(child.kind(), ChildKind::Leaf(first, items));
                assert_ne!(child, Child::EMPTY);
                assert_eq!(Child::leaf(0, items).moved(7, first), child);
            }
            assert_eq!(Child::inner(first).kind(), ChildKind::Inner(first));
            assert_eq!(Child::inner(0).moved(first, 7), Child::inner(first));
            assert_eq!(Child::EMPTY.moved(first, first), Child::EMPTY);
        }
    }
}
