//! A sparse symmetric system, by conjugate gradients.
//!
//! Hestenes, Stiefel, "Methods of Conjugate Gradients for Solving Linear Systems", 1952, with Jacobi's preconditioner: the diagonal. That of a mass matrix
//! leaves a condition number of at most four, whatever the sizes and shapes of the triangles (Wathen, "Realistic Eigenvalue Bounds for the Galerkin Mass
//! Matrix", 1987), so that each step leaves at most a third of the error; smoothness adds some steps.
//!
//! All sums are taken in one order, block by block, so that the number of threads changes no bit.

use rayon::prelude::*;

/// The residual that is left, as a share of the right side, both in the preconditioner's norm. With a condition of four a value then errs by no more than twice
/// that in the mean, by 2e-5, about a step of the 16 bits that values are stored in; each further digit costs two or three steps.
const ENOUGH: f64 = 1e-5;
/// Steps at most: far more than any smoothness within its range takes.
const MOST_STEPS: usize = 2000;
/// Numbers that are added one after the other.
const BLOCK: usize = 4096;

/// Which items of a list touch each slot.
pub(super) struct Touching {
    starts: Vec<usize>,
    items: Vec<u32>,
}

impl Touching {
    /// `slots` are those of each item, all below `count`.
    pub(super) fn new<'a, const N: usize>(
        count: usize,
        slots: impl Iterator<Item = &'a [u32; N]> + Clone,
    ) -> Self {
        let mut starts = vec![0; count + 1];
        slots.clone().flatten().for_each(|&slot| starts[slot as usize + 1] += 1);
        for slot in 0..count {
            starts[slot + 1] += starts[slot];
        }
        let mut next = starts.clone();
        let mut items = vec![0; starts[count]];
        for (item, slots) in slots.enumerate() {
            for &slot in slots {
                items[next[slot as usize]] = item as u32;
                next[slot as usize] += 1;
            }
        }
        Self { starts, items }
    }

    /// The items of a slot, in their order; one that touches it twice is there twice.
    pub(super) fn of(&self, slot: usize) -> impl Iterator<Item = usize> {
        self.items[self.starts[slot]..self.starts[slot + 1]].iter().map(|&item| item as usize)
    }
}

/// A symmetric matrix, row by row.
pub(super) struct Matrix {
    starts: Vec<usize>,
    entries: Vec<(u32, f64)>,
}

impl Matrix {
    /// Of rows in the making: entries of one column are added, in the order in which they stand.
    pub(super) fn of(count: usize, row: impl Fn(usize) -> Vec<(u32, f64)> + Sync) -> Self {
        let merged = |at: usize| {
            let mut entries = row(at);
            entries.sort_by_key(|(column, _)| *column);
            entries.dedup_by(|next, kept| {
                let is_same = next.0 == kept.0;
                kept.1 += if is_same { next.1 } else { 0.0 };
                is_same
            });
            entries
        };
        let rows: Vec<Vec<(u32, f64)>> = (0..count).into_par_iter().map(merged).collect();
        let mut starts = vec![0];
        starts.extend(rows.iter().scan(0, |end, row| {
            *end += row.len();
            Some(*end)
        }));
        Self { starts, entries: rows.into_iter().flatten().collect() }
    }

    fn row(&self, at: usize) -> &[(u32, f64)] {
        &self.entries[self.starts[at]..self.starts[at + 1]]
    }

    /// What is on the diagonal.
    pub(super) fn diagonal(&self) -> Vec<f64> {
        let of =
            |at: usize| self.row(at).iter().filter(|(column, _)| *column as usize == at).map(|e| e.1).sum();
        (0..self.starts.len() - 1).map(of).collect()
    }

    fn times(&self, values: &[f64]) -> Vec<f64> {
        let product =
            |at| self.row(at).iter().map(|&(column, entry)| entry * values[column as usize]).sum::<f64>();
        (0..values.len()).into_par_iter().with_min_len(BLOCK / 8).map(product).collect()
    }
}

/// What solving came to.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Solution {
    pub(super) values: Vec<f64>,
    pub(super) steps: usize,
}

/// Values that the matrix, of no negative eigenvalue, takes to `load`. Where many do they are near to those it starts from. Rows with nothing on the diagonal
/// keep the values that they start from.
pub(super) fn solve(matrix: &Matrix, load: &[f64], start: Vec<f64>) -> Solution {
    let scale: Vec<f64> =
        matrix.diagonal().iter().map(|&entry| if entry > 0.0 { 1.0 / entry } else { 0.0 }).collect();
    let scaled = |residual: &[f64]| -> Vec<f64> {
        residual.par_iter().zip(&scale).map(|(residual, scale)| residual * scale).collect()
    };
    let mut values = start;
    let mut residual: Vec<f64> = load.to_vec();
    add(&mut residual, -1.0, &matrix.times(&values));
    let mut pulled = scaled(&residual);
    let mut direction = pulled.clone();
    let goal = ENOUGH * ENOUGH * dot(load, &scaled(load));
    let mut left = dot(&residual, &pulled);
    let mut steps = 0;
    while left > goal && steps < MOST_STEPS {
        let ahead = matrix.times(&direction);
        let bend = dot(&direction, &ahead);
        if bend <= 0.0 {
            break;
        }
        add(&mut values, left / bend, &direction);
        add(&mut residual, -left / bend, &ahead);
        pulled = scaled(&residual);
        let now = dot(&residual, &pulled);
        let kept = now / left;
        direction.par_iter_mut().zip(&pulled).for_each(|(along, pulled)| *along = pulled + kept * *along);
        (left, steps) = (now, steps + 1);
    }
    Solution { values, steps }
}

/// Adds a multiple of other numbers.
fn add(to: &mut [f64], times: f64, other: &[f64]) {
    to.par_iter_mut().zip(other).for_each(|(to, other)| *to += times * other);
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    let block = |(a, b): (&[f64], &[f64])| a.iter().zip(b).map(|(a, b)| a * b).sum();
    let blocks: Vec<f64> = a.par_chunks(BLOCK).zip(b.par_chunks(BLOCK)).map(block).collect();
    blocks.iter().sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The mass matrix of a line of elements of one length, over a sixth of that.
    fn line(count: usize) -> Matrix {
        Matrix::of(count, |at| {
            let mut row = Vec::new();
            for other in [at.checked_sub(1), (at + 1 < count).then_some(at + 1)].into_iter().flatten() {
                row.extend([(other as u32, 1.0), (at as u32, 2.0)]);
            }
            row
        })
    }

    #[test]
    fn a_line_is_solved_in_the_steps_that_its_condition_says() {
        let wanted: Vec<f64> = (0..10_000).map(|k| f64::from(k * 7919 % 101) / 101.0).collect();
        let matrix = line(wanted.len());
        assert_eq!(
            (matrix.row(0), matrix.row(5)),
            (&[(0, 2.0), (1, 1.0)][..], &[(4, 1.0), (5, 4.0), (6, 1.0)][..])
        );
        let found = solve(&matrix, &matrix.times(&wanted), vec![0.0; wanted.len()]);
        let most = found.values.iter().zip(&wanted).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        assert!(most < 5e-5 && found.steps < 15, "{most} after {} steps", found.steps);
        // From the solution no step is taken, from elsewhere some are.
        let load = matrix.times(&wanted);
        assert_eq!(solve(&matrix, &load, wanted.clone()), Solution { values: wanted, steps: 0 });
    }

    #[test]
    fn of_many_solutions_one_near_the_start_is_found() {
        // Only the sum of two values is known, and of a third nothing.
        let matrix = Matrix::of(3, |at| if at < 2 { vec![(0, 1.0), (1, 1.0)] } else { vec![] });
        let found = solve(&matrix, &[1.0, 1.0, 0.0], vec![0.5, 0.7, 0.25]);
        assert!((found.values[0] - 0.4).abs() < 1e-12 && (found.values[1] - 0.6).abs() < 1e-12);
        assert_eq!(found.values[2], 0.25);
    }

    #[test]
    fn items_are_listed_by_slot() {
        let touching = Touching::new(4, [[0, 2], [2, 1], [2, 2]].iter());
        let all: Vec<Vec<usize>> = (0..4).map(|slot| touching.of(slot).collect()).collect();
        assert_eq!(all, [vec![0], vec![1], vec![0, 1, 2, 2], vec![]]);
    }
}
