//! Counts of what bundles do, for profiles: exact and repeatable where times are not. Only with the feature `visits`;
//! without it nothing is counted and nothing is left of the calls.

/// What is counted, over all bundles of the process.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Visit {
    /// Bundles traced.
    Bundle,
    /// Nodes opened.
    Node,
    /// Rays that come to a node, summed over nodes.
    NodeRay,
    /// Children of opened nodes that are within reach and above the surface.
    Reachable,
    /// Leaves tested.
    Leaf,
    /// Rays that come to a leaf, summed over leaves.
    LeafRay,
    /// Triangles of tested leaves that are not below the surface.
    Triangle,
    /// Pairs of a ray and a triangle that the wide test left to the exact one.
    Exact,
}

impl Visit {
    /// All of them.
    pub const ALL: [Self; 8] = [
        Self::Bundle,
        Self::Node,
        Self::NodeRay,
        Self::Reachable,
        Self::Leaf,
        Self::LeafRay,
        Self::Triangle,
        Self::Exact,
    ];
}

#[cfg(feature = "visits")]
mod counters {
    use super::Visit;
    use std::sync::atomic::{AtomicU64, Ordering::Relaxed};

    static COUNTS: [AtomicU64; Visit::ALL.len()] = [const { AtomicU64::new(0) }; Visit::ALL.len()];

    pub(crate) fn count(visit: Visit, times: u32) {
        COUNTS[visit as usize].fetch_add(u64::from(times), Relaxed);
    }

    /// What has been counted since the last call.
    pub fn take_visits() -> [(Visit, u64); Visit::ALL.len()] {
        Visit::ALL.map(|visit| (visit, COUNTS[visit as usize].swap(0, Relaxed)))
    }
}

#[cfg(feature = "visits")]
pub(crate) use counters::count;
#[cfg(feature = "visits")]
pub use counters::take_visits;

/// Counts nothing.
#[cfg(not(feature = "visits"))]
#[inline(always)]
pub(crate) fn count(_: Visit, _: u32) {}
