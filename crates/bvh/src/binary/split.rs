//! Where a set of boxes is split: by the surface area heuristic over bins, by count where that does not tell.

use glam::{Vec3A, Vec4};

/// Bins per axis, and for few items.
const BINS: usize = 16;
const FEW_BINS: usize = 8;
const FEW_ITEMS: usize = 32;
/// From this depth on items are split by count, which bounds the depth of all trees.
pub(super) const MEDIAN_DEPTH: u32 = 40;

#[inline]
fn half_area(lo: Vec3A, hi: Vec3A) -> f32 {
    let e = hi - lo;
    e.x * e.y + e.y * e.z + e.z * e.x
}

/// A box on its way into the tree: half a cache line, as sorting moves them about a lot.
#[derive(Clone, Copy)]
pub(super) struct Item {
    /// Lowest corner, and which box it is as the bits of a number of usual size.
    lo: Vec4,
    hi: Vec3A,
}

/// Makes any index, below 2^28, the bits of a float near 2, which no arithmetic slows down on.
const USUAL: u32 = 1 << 30;

impl Item {
    pub(super) fn new(lo: Vec3A, hi: Vec3A, index: u32) -> Self {
        Self { lo: lo.extend(f32::from_bits(USUAL | index)), hi }
    }

    pub(super) fn index(&self) -> u32 {
        self.lo.w.to_bits() & !USUAL
    }

    #[inline]
    fn lo(&self) -> Vec3A {
        Vec3A::from_vec4(self.lo)
    }

    #[inline]
    fn centre(&self) -> Vec3A {
        0.5 * (self.lo() + self.hi)
    }
}

#[derive(Clone, Copy)]
pub(super) struct Box3 {
    pub(super) lo: Vec3A,
    pub(super) hi: Vec3A,
}

impl Box3 {
    const EMPTY: Self = Self { lo: Vec3A::INFINITY, hi: Vec3A::NEG_INFINITY };

    #[inline]
    fn add(&mut self, lo: Vec3A, hi: Vec3A) {
        self.lo = self.lo.min(lo);
        self.hi = self.hi.max(hi);
    }
}

/// Boxes of some items and of their centres.
#[derive(Clone, Copy)]
pub(super) struct Extent {
    pub(super) whole: Box3,
    centres: Box3,
}

impl Extent {
    const EMPTY: Self = Self { whole: Box3::EMPTY, centres: Box3::EMPTY };

    #[inline]
    fn add(&mut self, item: &Item) {
        self.whole.add(item.lo(), item.hi);
        self.centres.add(item.centre(), item.centre());
    }

    pub(super) fn of(items: &[Item]) -> Self {
        items.iter().fold(Self::EMPTY, |mut all, item| {
            all.add(item);
            all
        })
    }
}

/// Reorders two or more items; how many go left - at least one and not all - and the extents of both sides.
pub(super) fn split(items: &mut [Item], extent: &Extent, depth: u32) -> (usize, Extent, Extent) {
    if let Some(found) = split_by_area(items, extent, depth) {
        return found;
    }
    let half = items.len() / 2;
    let size = extent.centres.hi - extent.centres.lo;
    // Coincident centres may stay in any order.
    if size.max_element() > 0.0 {
        let axis = longest_axis(size);
        items.select_nth_unstable_by(half, |a, b| {
            a.centre()[axis].total_cmp(&b.centre()[axis]).then(a.index().cmp(&b.index()))
        });
    }
    (half, Extent::of(&items[..half]), Extent::of(&items[half..]))
}

/// `None` where areas do not tell, or the tree is deep enough already.
fn split_by_area(items: &mut [Item], extent: &Extent, depth: u32) -> Option<(usize, Extent, Extent)> {
    let size = extent.centres.hi - extent.centres.lo;
    // Coincident centres, or a difference so small that its reciprocal overflows.
    if size.max_element() < f32::MIN_POSITIVE * 1e6 || depth >= MEDIAN_DEPTH {
        return None;
    }
    let bins = if items.len() < FEW_ITEMS { FEW_BINS } else { BINS };
    let binner = Binner::new(&extent.centres, bins);
    let (axis, boundary) = if bins == FEW_BINS {
        best_split::<FEW_BINS>(items, &binner)?
    } else {
        best_split::<BINS>(items, &binner)?
    };
    let found = partition(items, |item| binner.is_below(item, axis, boundary));
    (found.0 > 0 && found.0 < items.len()).then_some(found)
}

fn longest_axis(extent: Vec3A) -> usize {
    (0..3).fold(0, |best, axis| if extent[axis] > extent[best] { axis } else { best })
}

/// Maps centres to bins on all three axes.
struct Binner {
    origin: Vec3A,
    scale: Vec3A,
    last: Vec3A,
}

/// Added to a float of less than this, rounds it to a whole number and puts that into the lowest bits: a conversion on all
/// axes at once, where a checked one takes many steps on each.
const ROUNDER: f32 = 1.5 * (1 << 23) as f32;

impl Binner {
    fn new(centres: &Box3, bins: usize) -> Self {
        let extent = centres.hi - centres.lo;
        let scale = |axis: usize| {
            let s = bins as f32 / extent[axis];
            if s.is_finite() { s } else { 0.0 }
        };
        Self {
            origin: centres.lo,
            scale: Vec3A::new(scale(0), scale(1), scale(2)),
            last: Vec3A::splat(bins as f32 - 1.0),
        }
    }

    /// The bins, as what lies above [`ROUNDER`].
    #[inline]
    fn rounded(&self, item: &Item) -> Vec3A {
        ((item.centre() - self.origin) * self.scale - 0.5).min(self.last) + ROUNDER
    }

    #[inline]
    fn bins(&self, item: &Item) -> [usize; 3] {
        let [x, y, z] = self.rounded(item).to_array();
        // There are fewer than 32 bins.
        let bin = |rounded: f32| (rounded.to_bits() & 31) as usize;
        [bin(x), bin(y), bin(z)]
    }

    /// True where the bin on an axis is below that one.
    #[inline]
    fn is_below(&self, item: &Item, axis: usize, bin: usize) -> bool {
        let below = self.rounded(item).cmplt(Vec3A::splat(ROUNDER + bin as f32));
        below.bitmask() >> axis & 1 == 1
    }
}

/// Axis and first bin on the right of the cheapest split: area times count, summed over both sides.
fn best_split<const N: usize>(items: &[Item], binner: &Binner) -> Option<(usize, usize)> {
    let mut counts = [[0u32; N]; 3];
    let mut boxes = [[Box3::EMPTY; N]; 3];
    for item in items {
        let b = binner.bins(item);
        for axis in 0..3 {
            let bin = b[axis].min(N - 1);
            counts[axis][bin] += 1;
            boxes[axis][bin].add(item.lo(), item.hi);
        }
    }
    let mut best: Option<(f32, usize, usize)> = None;
    for axis in 0..3 {
        let mut right_costs = [0.0f32; N];
        let (mut right, mut count) = (Box3::EMPTY, 0);
        for bin in (1..N).rev() {
            right.add(boxes[axis][bin].lo, boxes[axis][bin].hi);
            count += counts[axis][bin];
            right_costs[bin] =
                if count == 0 { f32::INFINITY } else { half_area(right.lo, right.hi) * count as f32 };
        }
        let (mut left, mut count) = (Box3::EMPTY, 0);
        for bin in 1..N {
            left.add(boxes[axis][bin - 1].lo, boxes[axis][bin - 1].hi);
            count += counts[axis][bin - 1];
            if count == 0 {
                continue;
            }
            let cost = half_area(left.lo, left.hi) * count as f32 + right_costs[bin];
            if cost.is_finite() && best.is_none_or(|(c, ..)| cost < c) {
                best = Some((cost, axis, bin));
            }
        }
    }
    best.map(|(_, axis, bin)| (axis, bin))
}

/// Moves the items that satisfy `is_left` to the front: how many they are, and the extents of both parts.
fn partition(items: &mut [Item], is_left: impl Fn(&Item) -> bool) -> (usize, Extent, Extent) {
    let (mut left, mut right) = (0, items.len());
    let mut extents = (Extent::EMPTY, Extent::EMPTY);
    while left < right {
        if is_left(&items[left]) {
            extents.0.add(&items[left]);
            left += 1;
        } else {
            extents.1.add(&items[left]);
            right -= 1;
            items.swap(left, right);
        }
    }
    (left, extents.0, extents.1)
}
