//! Values that fit the estimates on a surface best, in the sense of least squares.
//!
//! Kavan, Bargteil, Sloan, "Least Squares Vertex Baking", 2011: of all values v at the vertices those for which
//!
//! ```text
//! sum over samples s of w_s (sum over corners k of b_k(s) v_k  -  f_s)^2   +   alpha sum over edges e of c_e kink_e(v)^2
//! ```
//!
//! is least, with the area w that a sample stands for, its barycentric weights b and its estimate f; for the second sum, which differs from the paper's, see
//! kinks.rs. The sums over the samples of a triangle are taken first, so that solving costs the same however many there are.

use super::{
    kinks::Kink,
    solve::{Matrix, Touching, solve},
    values::VertexValues,
};
use conray_core::Estimate;
use rayon::prelude::*;

/// What the samples of a triangle come to.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Element {
    pub(super) slots: [u32; 3],
    /// Sums of w b_k b_l.
    mass: [[f64; 3]; 3],
    /// Sums of w b_k, of w b_k f, and of w b_k times the estimate's error.
    share: [f64; 3],
    load: [f64; 3],
    error: [f64; 3],
    /// Sum of w f^2, and of w.
    square: f64,
    weight: f64,
}

impl Element {
    /// Of samples with the weights of their second and third corner, each of that area; those that have no answer do not count.
    pub(super) fn of<'a>(
        slots: [u32; 3],
        area: f64,
        samples: impl Iterator<Item = (&'a [f32; 2], &'a Estimate)>,
    ) -> Self {
        let none = [0.0; 3];
        let mut all =
            Self { slots, mass: [none; 3], share: none, load: none, error: none, square: 0.0, weight: 0.0 };
        for (&[u, v], estimate) in samples.filter(|(_, e)| !e.is_pending() && e.error.is_finite()) {
            let [u, v, value] = [u, v, estimate.visibility].map(f64::from);
            let corners = [1.0 - u - v, u, v];
            for (k, of_k) in corners.iter().enumerate() {
                let weight = area * of_k;
                all.mass[k].iter_mut().zip(corners).for_each(|(mass, of_l)| *mass += weight * of_l);
                all.share[k] += weight;
                all.load[k] += weight * value;
                all.error[k] += weight * f64::from(estimate.error);
            }
            all.square += area * value * value;
            all.weight += area;
        }
        all
    }

    /// Sum of w (sum of b_k v_k - f)^2.
    fn off(&self, values: [f64; 3]) -> f64 {
        let row = |k: usize| (0..3).map(|l| self.mass[k][l] * values[l]).sum::<f64>();
        let both: f64 = (0..3).map(|k| values[k] * (row(k) - 2.0 * self.load[k])).sum();
        // A sum of squares, were it not for rounding.
        (both + self.square).max(0.0)
    }
}

/// The values of so many slots.
pub(super) fn fit(count: usize, elements: &[Element], kinks: &[Kink], smoothness: f64) -> VertexValues {
    let triangles = Touching::new(count, elements.iter().map(|element| &element.slots));
    let sums = |of: fn(&Element) -> [f64; 3]| -> Vec<f64> {
        let at = |slot: usize| {
            let own = |item: usize| of(&elements[item])[place(elements[item].slots, slot)];
            triangles.of(slot).map(own).sum()
        };
        (0..count).into_par_iter().map(at).collect()
    };
    let (share, load) = (sums(|element| element.share), sums(|element| element.load));
    let mean = |sums: &[f64]| -> Vec<f64> {
        sums.iter().zip(&share).map(|(sum, share)| if *share > 0.0 { sum / share } else { 0.0 }).collect()
    };
    // What no sample tells of is left out, and so are the kinks that it is in.
    let is_known = |slot: u32| share[slot as usize] > 0.0;
    let kinks: Vec<&Kink> = kinks.iter().filter(|kink| kink.slots.into_iter().all(is_known)).collect();
    let matrix = matrix(count, elements, &triangles, &kinks, smoothness);
    // From the means of what is about each vertex: what the estimates leave open stays near them.
    let solution = solve(&matrix, &load, mean(&load));
    let visibility: Vec<f32> = solution.values.iter().map(|value| value.clamp(0.0, 1.0) as f32).collect();
    let mut values = VertexValues {
        misfit: misfit(elements, &visibility),
        visibility,
        error: mean(&sums(|element| element.error)).into_iter().map(|error| error as f32).collect(),
        filled: 0,
        steps: solution.steps,
    };
    let unknown: Vec<u32> = (0..count as u32).filter(|&slot| !is_known(slot)).collect();
    values.fill(unknown, &triangles, elements);
    values
}

/// Half the second derivatives of what is to be least.
fn matrix(
    count: usize,
    elements: &[Element],
    triangles: &Touching,
    kinks: &[&Kink],
    smoothness: f64,
) -> Matrix {
    let edges = Touching::new(count, kinks.iter().map(|kink| &kink.slots));
    Matrix::of(count, |slot| {
        let mut row = Vec::new();
        for element in triangles.of(slot).map(|item| &elements[item]) {
            row.extend(element.slots.into_iter().zip(element.mass[place(element.slots, slot)]));
        }
        for kink in edges.of(slot).map(|item| kinks[item]) {
            let shares = kink.shares.map(f64::from);
            let own = smoothness * kink.weight * shares[place(kink.slots, slot)];
            row.extend(kink.slots.into_iter().zip(shares.map(|share| own * share)));
        }
        row
    })
}

/// Where a slot stands among those that it is one of. Triangles that have it twice have no area, and sums of 0.
fn place<const N: usize>(slots: [u32; N], slot: usize) -> usize {
    slots.iter().position(|&other| other as usize == slot).unwrap_or(0)
}

/// Root mean square difference between the samples and what is drawn between values.
fn misfit(elements: &[Element], visibility: &[f32]) -> f64 {
    let (mut off, mut weight) = (0.0, 0.0);
    for element in elements {
        off += element.off(element.slots.map(|slot| visibility[slot as usize].into()));
        weight += element.weight;
    }
    if weight > 0.0 { (off / weight).sqrt() } else { 0.0 }
}

#[cfg(test)]
mod tests;
