//! What makes values smooth: a kink between two triangles that share an edge is held against them.
//!
//! Kavan, Bargteil, Sloan, "Least Squares Vertex Baking", 2011, add the squared differences of the gradients on both sides of each edge, so that values which
//! are linear over a surface cost nothing. Such a sum has a unit, one over a squared length, and its weight depends on the mesh. Here the difference is
//! multiplied by a length, and so is how far the value at an edge is off the straight line across both triangles:
//!
//! ```text
//!      k        Along the edge both gradients agree. Across it, with the heights h of k and l over it and the
//!     / \       values e of the edge's line at their feet,
//!    i---j          jump = (v_k - e_k) / h_k + (v_l - e_l) / h_l
//!     \ /           kink = jump h_k h_l / (h_k + h_l)
//!      l
//! ```
//!
//! The sum of squared kinks, each weighed by a third of the area of its two triangles, is a mean over the surface as is the sum of squared differences to
//! the estimates, each weighed by its area. Their ratio, alpha, has no unit: it means the same for large and small meshes, coarse and fine.

use super::samples::Patch;
use conray_core::Vec3;
use rayon::prelude::*;

/// An edge between two triangles: the kink is the sum of values of slots, each times its share.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Kink {
    /// The ends of the edge, then the corners across.
    pub(super) slots: [u32; 4],
    pub(super) shares: [f32; 4],
    /// What its square counts for: a third of the area of both triangles.
    pub(super) weight: f64,
}

/// An edge of a triangle: its slots, the lesser first, the triangle and which corner the edge begins at.
type Edge = ([u32; 2], usize, usize);

/// The edges that two triangles share by both slots; `corners` are those of a triangle in the world. Where more than two meet, or where a triangle
/// lies on its own copy, there is no telling which goes on into which: such edges may kink.
pub(super) fn kinks(patches: &[Patch], corners: impl Fn(&Patch) -> [Vec3; 3] + Sync) -> Vec<Kink> {
    let edges = |(at, patch): (usize, &Patch)| {
        let slots = patch.slots;
        let edge = move |k: usize| {
            let [i, j] = [slots[k], slots[(k + 1) % 3]];
            ([i.min(j), i.max(j)], at, k)
        };
        (0..if patch.area > 0.0 { 3 } else { 0 }).map(edge)
    };
    let mut edges: Vec<Edge> = patches.par_iter().enumerate().flat_map_iter(edges).collect();
    edges.par_sort_unstable();
    let side = |&(_, at, k): &Edge| {
        let (patch, corners) = (&patches[at], corners(&patches[at]));
        (patch.area, [0, 1, 2].map(|n| patch.slots[(k + n) % 3]), [0, 1, 2].map(|n| corners[(k + n) % 3]))
    };
    let shared: Vec<&[Edge]> = edges.chunk_by(|a, b| a.0 == b.0).filter(|sides| sides.len() == 2).collect();
    shared.par_iter().filter_map(|sides| kink(side(&sides[0]), side(&sides[1]))).collect()
}

/// Area, slots and corners of a triangle, its edge from the first to the second.
type Side = (f64, [u32; 3], [Vec3; 3]);

/// `None` where one of the triangles has no height over the edge, or both are one.
fn kink((area, [i, j, k], one): Side, (other_area, [from, _, l], mut other): Side) -> Option<Kink> {
    if from != i {
        other.swap(0, 1);
    }
    let ([one_foot, one_height], [other_foot, other_height]) = (foot(one), foot(other));
    let heights = one_height + other_height;
    let (of_one, of_other) = (other_height / heights, one_height / heights);
    let along = of_one * one_foot + of_other * other_foot;
    let shares = [along - 1.0, -along, of_one, of_other];
    // A corner whose foot lies far beyond the edge would multiply what the edge's values differ by: such a kink counts for less, so that no value
    // counts for more than itself.
    let most = shares.iter().fold(1.0f64, |most, share| most.max(share.abs()));
    let is_usable = k != l && most.is_finite() && one_height > 0.0 && other_height > 0.0;
    let shares = shares.map(|share| (share / most) as f32);
    is_usable.then_some(Kink { slots: [i, j, k, l], shares, weight: (area + other_area) / 3.0 })
}

/// For a triangle with an edge from its first to its second corner: where along the edge the third has its foot, 0 at the first, and its height over it.
fn foot(corners: [Vec3; 3]) -> [f64; 2] {
    let [i, j, k] = corners.map(|p| p.as_dvec3());
    let (edge, across) = (j - i, k - i);
    [across.dot(edge) / edge.length_squared(), edge.cross(across).length() / edge.length()]
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn found(triangles: &[[u32; 3]], positions: &[Vec3]) -> Vec<Kink> {
        let corners = |slots: [u32; 3]| slots.map(|slot| positions[slot as usize]);
        let patches: Vec<Patch> =
            triangles.iter().map(|&slots| Patch::new(0, 0, slots, corners(slots))).collect();
        kinks(&patches, |patch| corners(patch.slots))
    }

    fn of(kink: &Kink, value: impl Fn(u32) -> f64) -> f64 {
        kink.slots.iter().zip(kink.shares).map(|(&slot, share)| f64::from(share) * value(slot)).sum()
    }

    /// A square of side 2 with a diagonal.
    fn square() -> Vec<Vec3> {
        [(0.0, 0.0), (2.0, 0.0), (2.0, 2.0), (0.0, 2.0)].map(|(x, y)| Vec3::new(x, y, 0.0)).to_vec()
    }

    #[test]
    fn a_ridge_kinks_by_its_height() {
        for triangles in [[[0, 1, 2], [0, 2, 3]], [[0, 1, 2], [2, 0, 3]], [[1, 2, 0], [0, 2, 3]]] {
            let all = found(&triangles, &square());
            assert_eq!((all.len(), all[0].weight), (1, 4.0 / 3.0));
            // The diagonal a unit above the corners beside it.
            let kink = of(&all[0], |slot| if slot % 2 == 0 { 1.0 } else { 0.0 });
            assert!((kink.abs() - 1.0).abs() < 1e-6, "{kink}");
        }
    }

    #[test]
    fn edges_of_one_of_three_and_of_a_folded_pair_may_kink() {
        let positions = [&square()[..], &[Vec3::Z]].concat();
        assert!(found(&[[0, 1, 2]], &positions).is_empty());
        assert!(found(&[[0, 1, 2], [0, 2, 3], [2, 0, 4]], &positions).is_empty());
        assert!(found(&[[0, 1, 2], [0, 1, 2]], &positions).is_empty());
        assert!(found(&[[0, 1, 2], [0, 2, 2]], &positions).is_empty(), "no area, no edge");
    }

    proptest! {
        #[test]
        fn linear_values_do_not_kink_at_any_place_or_size(
            places in prop::collection::vec((0.0f32..1.0, 0.0f32..1.0), 4), gradient in (-1.0f64..1.0, -1.0f64..1.0),
            size in -6i32..6, away in prop_oneof![Just(0.0f32), Just(100.0)],
        ) {
            let positions: Vec<Vec3> =
                places.iter().map(|&(x, y)| (Vec3::new(x, y, 0.0) + away) * 10f32.powi(size)).collect();
            let linear = |slot: u32| {
                let place = positions[slot as usize].as_dvec3() / 10f64.powi(size) - f64::from(away);
                gradient.0 * place.x + gradient.1 * place.y
            };
            for kink in found(&[[0, 1, 2], [1, 0, 3]], &positions) {
                // Only if the triangles lie on both sides of the edge do they continue each other.
                let [a, b, c, d] = [0, 1, 2, 3].map(|k| positions[k].as_dvec3());
                let sides = [c, d].map(|p| (b - a).cross(p - a).z);
                if sides[0] * sides[1] < 0.0 {
                    prop_assert!(of(&kink, linear).abs() < 1e-6, "{kink:?}");
                    prop_assert!(of(&kink, |_| 1.0).abs() < 1e-6);
                }
                prop_assert!(kink.shares.iter().all(|share| share.abs() <= 1.0));
            }
        }

        #[test]
        fn size_changes_weights_alone(places in prop::collection::vec((0.0f32..1.0, 0.0f32..1.0), 4)) {
            let at = |size: f32| -> Vec<Vec3> {
                places.iter().map(|&(x, y)| Vec3::new(x, y, 0.0) * size).collect()
            };
            let [one, other] = [1.0, 1024.0].map(|size| found(&[[0, 1, 2], [1, 0, 3]], &at(size)));
            prop_assert_eq!(one.len(), other.len());
            for (one, other) in one.iter().zip(&other) {
                prop_assert_eq!(one.shares, other.shares);
                prop_assert!((other.weight / one.weight / 1024f64.powi(2) - 1.0).abs() < 1e-9);
            }
        }
    }
}
