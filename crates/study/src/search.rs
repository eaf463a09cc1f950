//! The search for the published blend's constants.
//!
//! The pilot knows of every cone what the march says, what is true, and the variance of its rays. So the expected
//! squared error of the blend and its rays follow for any constants without tracing anything, and a whole grid can be
//! searched. At a point the errors of cones add with their signs, those of rays as independent ones.

use crate::pilot::{Pilot, PilotCone, PilotPoint};
use conray::{AoSettings, Epsilon};
use rayon::prelude::*;

/// The published blend's constants.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Constants {
    /// Which error of a cone counts.
    pub(crate) epsilon: Epsilon,
    /// Transition parameter.
    pub(crate) beta: f32,
    /// Threshold.
    pub(crate) gamma: f32,
    /// Most rays per cone.
    pub(crate) max_rays: u32,
}

impl Constants {
    /// No ray is sent: the cones alone.
    pub(crate) const CONES: Self = Self { epsilon: Epsilon::Published, beta: 0.0, gamma: 1.0, max_rays: 1 };

    /// Those of a study.
    pub(crate) fn of(settings: &AoSettings) -> Self {
        let AoSettings { epsilon, beta, gamma, max_rays, .. } = *settings;
        Self { epsilon, beta, gamma, max_rays }
    }
}

/// What the search found for one budget.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Tuned {
    /// The best constants.
    pub(crate) constants: Constants,
    /// Rays per point that they take.
    pub(crate) rays: f64,
    /// RMSE that they leave.
    pub(crate) rmse: f64,
}

const BETAS: [f32; 12] = [0.5, 1.0, 2.0, 5.0, 10.0, 20.0, 50.0, 100.0, 200.0, 500.0, 2000.0, 1e6];
const GAMMAS: [f32; 11] = [0.0, 0.002, 0.005, 0.01, 0.02, 0.04, 0.07, 0.1, 0.2, 0.4, 1.0];
const MAX_RAYS: [u32; 21] = [1, 2, 3, 4, 5, 6, 7, 8, 10, 12, 14, 16, 20, 24, 28, 32, 48, 64, 96, 128, 256];

/// The constants of least expected error for each budget in rays per point, one after the other.
///
/// A larger budget never does worse than a smaller one. Without any rays the blend is the cones.
pub(crate) fn tune(pilot: &Pilot, budgets: &[u32]) -> Vec<Tuned> {
    let grid: Vec<Constants> = BETAS
        .iter()
        .flat_map(|&beta| GAMMAS.iter().map(move |&gamma| (beta, gamma)))
        .flat_map(|(beta, gamma)| MAX_RAYS.iter().map(move |&max_rays| (beta, gamma, max_rays)))
        .flat_map(|(beta, gamma, max_rays)| {
            Epsilon::ALL.map(|epsilon| Constants { epsilon, beta, gamma, max_rays })
        })
        .collect();
    let judged: Vec<Tuned> = grid.par_iter().map(|&constants| expect(pilot, constants)).collect();
    // The constants that send fewest rays: what is left where the budget allows nothing.
    let least = judged.iter().copied().reduce(|a, b| if b.rays < a.rays { b } else { a });
    budgets
        .iter()
        .filter_map(|&budget| {
            let affordable = judged.iter().filter(|t| t.rays <= f64::from(budget)).copied();
            affordable.reduce(|a, b| if b.rmse < a.rmse { b } else { a }).or(least)
        })
        .collect()
}

/// Expected error and rays of the blend with these constants, over the pilot's points.
pub(crate) fn expect(pilot: &Pilot, constants: Constants) -> Tuned {
    let (mut squared, mut rays) = (0.0, 0.0);
    for point in &pilot.points {
        let (error, traced) = expect_at(point, constants);
        squared += error;
        rays += f64::from(traced);
    }
    let points = pilot.points.len().max(1) as f64;
    Tuned { constants, rays: rays / points, rmse: (squared / points).sqrt() }
}

/// Expected squared error and rays at one point.
fn expect_at(point: &PilotPoint, constants: Constants) -> (f64, u32) {
    let (mut bias, mut variance, mut rays) = (0.0f64, 0.0f64, 0);
    for cone in &point.cones {
        let (alpha, count) = share(cone, constants);
        bias += f64::from(cone.weight * alpha * (cone.visibility - cone.truth));
        if count > 0 {
            let by_rays = f64::from(cone.weight * (1.0 - alpha));
            variance += by_rays * by_rays * f64::from(cone.variance_of_mean(count));
            rays += count;
        }
    }
    (bias * bias + variance, rays)
}

/// The cone's share and its rays: equations 1 and 2 of the paper, rounded as method `paper` does.
pub(crate) fn share(cone: &PilotCone, constants: Constants) -> (f32, u32) {
    let alpha = match constants.epsilon.of(cone.visibility, cone.epsilon) {
        f32::INFINITY => 0.0,
        epsilon => (-constants.beta * (epsilon - constants.gamma)).exp().clamp(0.0, 1.0),
    };
    let rays = ((1.0 - alpha) * constants.max_rays as f32).round() as u32;
    (if rays > 0 { alpha } else { 1.0 }, rays)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pilot::OccluderFacts;

    /// Two cones: one whose march is right with epsilon 0, one that is wrong and says so.
    fn pilot() -> Pilot {
        let cone = |visibility, epsilon, truth: f32| PilotCone {
            weight: 0.5,
            visibility,
            epsilon,
            certified: false,
            truth,
            ray_variance: std::array::from_fn(|k| truth * (1.0 - truth) / (1 << k) as f32),
            occluders: OccluderFacts::default(),
        };
        Pilot { points: vec![PilotPoint { index: 0, cones: vec![cone(1.0, 0.0, 1.0), cone(0.0, 0.5, 0.5)] }] }
    }

    #[test]
    fn expected_error_and_rays_follow_from_the_cones() {
        let always = Constants { epsilon: Epsilon::Published, beta: 1e6, gamma: 0.0, max_rays: 4 };
        let all_rays = expect(&pilot(), always);
        assert_eq!(all_rays.rays, 4.0);
        // Half the hemisphere by four rays of a coin: 0.5 * sqrt(0.25 / 4).
        assert!((all_rays.rmse - 0.125).abs() < 1e-6, "{all_rays:?}");
        let no_rays = expect(&pilot(), Constants { gamma: 1.0, ..always });
        assert_eq!(no_rays.rays, 0.0);
        assert!((no_rays.rmse - 0.25).abs() < 1e-6, "cones alone err by half of a half: {no_rays:?}");
    }

    #[test]
    fn more_budget_never_hurts_and_budgets_are_kept() {
        let found = tune(&pilot(), &[1, 4, 16, 64]);
        assert_eq!(found.len(), 4);
        assert!(found.windows(2).all(|w| w[1].rmse <= w[0].rmse));
        assert!(found.iter().zip([1.0, 4.0, 16.0, 64.0]).all(|(t, budget)| t.rays <= budget));
        assert!(found[3].rmse < 0.04 && found[0].rmse > 0.1, "{found:?}");
    }

    #[test]
    fn without_points_there_is_nothing_to_find_and_no_panic() {
        let found = tune(&Pilot { points: Vec::new() }, &[1]);
        assert_eq!((found[0].rays, found[0].rmse), (0.0, 0.0));
    }
}
