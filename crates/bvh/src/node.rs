//! Node layout: four children a node, their boxes side by side, two cache lines.

use conray_core::Bounds;
use glam::Vec4;

/// What a child slot refers to: an inner node, a leaf of one to eight items, or nothing.
///
/// Bit 31 marks a leaf; then bits 28 to 30 hold the number of items less one and bits 0 to 27 the first item (for
/// triangles: the first packet of four).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(transparent)]
pub(crate) struct Child(u32);

/// What [`Child`] unpacks to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum ChildKind {
    /// Index of another node.
    Inner(u32),
    /// First item and number of items.
    Leaf(u32, u32),
}

impl Child {
    /// An unused slot. As a leaf it would be the very last one, which [`Child::MAX_FIRST`] rules out.
    pub(crate) const EMPTY: Self = Self(u32::MAX);
    /// Most items a leaf can hold.
    pub(crate) const MAX_ITEMS: u32 = 8;
    /// Largest index that a leaf's first item can have.
    pub(crate) const MAX_FIRST: u32 = (1 << 28) - 2;

    const LEAF: u32 = 1 << 31;

    pub(crate) fn inner(node: u32) -> Self {
        debug_assert!(node < Self::LEAF);
        Self(node)
    }

    pub(crate) fn leaf(first: u32, items: u32) -> Self {
        debug_assert!(first <= Self::MAX_FIRST && (1..=Self::MAX_ITEMS).contains(&items));
        Self(Self::LEAF | (items - 1) << 28 | first)
    }

    #[inline(always)]
    pub(crate) fn kind(self) -> ChildKind {
        if self.0 & Self::LEAF == 0 {
            ChildKind::Inner(self.0)
        } else {
            ChildKind::Leaf(self.0 & 0x0fff_ffff, (self.0 >> 28 & 7) + 1)
        }
    }
}

/// Four children with their boxes.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
pub(crate) struct Node {
    /// By axis, then lowest (0) or highest (1) plane, then child. Unused slots hold an empty box.
    pub(crate) planes: [[Vec4; 2]; 3],
    /// What the four slots refer to; the used ones come first.
    pub(crate) children: [Child; 4],
}

const _: () = assert!(size_of::<Node>() == 128);

impl Node {
    /// A node without children.
    pub(crate) const UNUSED: Self =
        Self { planes: [[Vec4::INFINITY, Vec4::NEG_INFINITY]; 3], children: [Child::EMPTY; 4] };

    /// Fills one slot.
    pub(crate) fn set(&mut self, slot: usize, bounds: &Bounds, child: Child) {
        for axis in 0..3 {
            self.planes[axis][0][slot] = bounds.min[axis];
            self.planes[axis][1][slot] = bounds.max[axis];
        }
        self.children[slot] = child;
    }

    /// Box of one slot.
    pub(crate) fn bounds(&self, slot: usize) -> Bounds {
        let corner = |side: usize| {
            conray_core::Vec3::new(
                self.planes[0][side][slot],
                self.planes[1][side][slot],
                self.planes[2][side][slot],
            )
        };
        Bounds { min: corner(0), max: corner(1) }
    }

    /// The used slots.
    pub(crate) fn slots(&self) -> impl Iterator<Item = (Bounds, Child)> + '_ {
        (0..4).filter(|&i| self.children[i] != Child::EMPTY).map(|i| (self.bounds(i), self.children[i]))
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
            }
            assert_eq!(Child::inner(first).kind(), ChildKind::Inner(first));
        }
    }
}
