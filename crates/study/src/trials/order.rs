//! In which order trials run, and about how long each takes beside the others.

use crate::{Contender, Effort};

/// Rays that take about as long as one cone, for the progress bar alone.
const RAYS_A_CONE: f64 = 16.0;

/// The trials of a round: all of them, each round starting a third of the way further on.
pub(super) fn round(trials: usize, round: u32) -> impl Iterator<Item = usize> {
    let start = (round as usize * trials.div_ceil(3)) % trials.max(1);
    (0..trials).map(move |i| (start + i) % trials)
}

/// The trial to time twice: `rays`, else the first contender, at the middle of its curve.
pub(super) fn twin(planned: &[(usize, Effort)], contenders: &[Box<dyn Contender>]) -> Option<usize> {
    let chosen = contenders.iter().position(|c| c.name() == "rays").unwrap_or(0);
    let steps: Vec<usize> = (0..planned.len()).filter(|&step| planned[step].0 == chosen).collect();
    steps.get(steps.len() / 2).copied()
}

/// About how much work a trial is, in rays per point.
pub(super) fn weight(contender: &dyn Contender, effort: &Effort) -> f64 {
    let cones = if contender.needs().octree { 16.0 * RAYS_A_CONE } else { 0.0 };
    cones + f64::from(effort.value)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_round_runs_every_trial_once_and_starts_elsewhere() {
        for trials in [1, 2, 7, 60] {
            let rounds: Vec<Vec<usize>> = (0..3).map(|r| round(trials, r).collect()).collect();
            for order in &rounds {
                let mut sorted = order.clone();
                sorted.sort_unstable();
                assert_eq!(sorted, (0..trials).collect::<Vec<_>>());
            }
            assert!(trials < 3 || (rounds[0][0] != rounds[1][0] && rounds[1][0] != rounds[2][0]));
        }
        assert_eq!(round(0, 2).count(), 0);
    }
}
