//! The cones of the pilot: classes, and epsilon against the truth.

use crate::{
    pilot::{PILOT_RAYS, Pilot, PilotCone},
    report::{ConeBin, ConeClass, ConeClassReport, ConeReport},
    search::{Constants, share},
};
use conray::{AoSettings, Epsilon};

/// Bins of epsilon beyond the one of zeros.
const BINS: usize = 12;

pub(super) fn report(pilot: &Pilot, settings: &AoSettings) -> ConeReport {
    let cones: Vec<&PilotCone> = pilot.points.iter().flat_map(|p| &p.cones).collect();
    ConeReport {
        points: pilot.points.len(),
        cones: settings.cones,
        rays: PILOT_RAYS,
        classes: classes(&cones, settings),
        epsilon: bins(&cones),
        rank_correlation: rank_correlation(&cones, Epsilon::Published),
        rank_correlation_marching: rank_correlation(&cones, Epsilon::Marching),
    }
}

fn error(cone: &PilotCone) -> f64 {
    f64::from(cone.visibility) - f64::from(cone.truth)
}

fn classes(cones: &[&PilotCone], settings: &AoSettings) -> Vec<ConeClassReport> {
    let constants = Constants::of(settings);
    [ConeClass::Certified, ConeClass::Open, ConeClass::Closed, ConeClass::Trusted, ConeClass::Refined]
        .into_iter()
        .map(|class| {
            let errors: Vec<f64> =
                cones.iter().filter(|c| class_of(c, constants) == class).map(|c| error(c)).collect();
            let n = errors.len().max(1) as f64;
            ConeClassReport {
                class,
                share: errors.len() as f64 / cones.len().max(1) as f64,
                rmse: (errors.iter().map(|e| e * e).sum::<f64>() / n).sqrt(),
                bias: errors.iter().sum::<f64>() / n,
                right: errors.iter().filter(|e| e.abs() <= 0.05).count() as f64 / n,
            }
        })
        .collect()
}

fn class_of(cone: &PilotCone, constants: Constants) -> ConeClass {
    let (_, rays) = share(cone, constants);
    if cone.certified {
        ConeClass::Certified
    } else if rays > 0 {
        ConeClass::Refined
    } else if cone.epsilon > 0.0 {
        ConeClass::Trusted
    } else if cone.visibility >= 1.0 {
        ConeClass::Open
    } else if cone.visibility <= 0.0 {
        ConeClass::Closed
    } else {
        ConeClass::Trusted
    }
}

/// Cones of epsilon 0, then bins of equally many cones by rising epsilon.
fn bins(cones: &[&PilotCone]) -> Vec<ConeBin> {
    let mut known: Vec<&PilotCone> = cones.iter().copied().filter(|c| c.epsilon.is_finite()).collect();
    known.sort_by(|a, b| a.epsilon.total_cmp(&b.epsilon));
    let zeros = known.iter().take_while(|c| c.epsilon == 0.0).count();
    let (certain, rest) = known.split_at(zeros);
    let size = rest.len().div_ceil(BINS).max(1);
    std::iter::once(certain).chain(rest.chunks(size)).filter(|bin| !bin.is_empty()).map(bin_of).collect()
}

fn bin_of(cones: &[&PilotCone]) -> ConeBin {
    let n = cones.len() as f64;
    let mut sizes: Vec<f64> = cones.iter().map(|c| error(c).abs()).collect();
    sizes.sort_by(f64::total_cmp);
    ConeBin {
        count: cones.len(),
        epsilon: cones.iter().map(|c| f64::from(c.epsilon)).sum::<f64>() / n,
        mae: sizes.iter().sum::<f64>() / n,
        rmse: (sizes.iter().map(|e| e * e).sum::<f64>() / n).sqrt(),
        // Nearest rank.
        p95: sizes[((0.95 * n).ceil() as usize).clamp(1, sizes.len()) - 1],
    }
}

/// Spearman's rank correlation of epsilon and absolute error, ties sharing their mean rank; 0 where one never varies.
fn rank_correlation(cones: &[&PilotCone], epsilon: Epsilon) -> f64 {
    let epsilon = |c: &&PilotCone| f64::from(epsilon.of(c.visibility, c.epsilon));
    let a = ranks(&cones.iter().map(epsilon).collect::<Vec<_>>());
    let b = ranks(&cones.iter().map(|c| error(c).abs()).collect::<Vec<_>>());
    let middle = (a.len() as f64 - 1.0) / 2.0;
    let product =
        |x: &[f64], y: &[f64]| x.iter().zip(y).map(|(x, y)| (x - middle) * (y - middle)).sum::<f64>();
    let spread = (product(&a, &a) * product(&b, &b)).sqrt();
    if spread > 0.0 { product(&a, &b) / spread } else { 0.0 }
}

fn ranks(values: &[f64]) -> Vec<f64> {
    let mut order: Vec<usize> = (0..values.len()).collect();
    order.sort_by(|&i, &j| values[i].total_cmp(&values[j]));
    let mut ranks = vec![0.0; values.len()];
    let mut start = 0;
    while start < order.len() {
        let tied = order[start..].iter().take_while(|&&i| values[i] == values[order[start]]).count().max(1);
        let shared = start as f64 + (tied as f64 - 1.0) / 2.0;
        order[start..start + tied].iter().for_each(|&i| ranks[i] = shared);
        start += tied;
    }
    ranks
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pilot::OccluderFacts;

    fn cone(visibility: f32, epsilon: f32, truth: f32) -> PilotCone {
        let ray_variance = Default::default();
        let occluders = OccluderFacts::default();
        PilotCone { weight: 0.25, visibility, epsilon, certified: false, truth, ray_variance, occluders }
    }

    #[test]
    fn ranks_share_ties() {
        assert_eq!(ranks(&[5.0, 1.0, 5.0, 2.0]), [2.5, 0.0, 2.5, 1.0]);
    }

    #[test]
    fn correlation_is_1_where_epsilon_orders_errors_and_0_where_it_says_nothing() {
        let told: Vec<PilotCone> = (1..50).map(|i| cone(0.0, i as f32, i as f32 / 100.0)).collect();
        let silent: Vec<PilotCone> = (1..50).map(|i| cone(0.0, 0.3, i as f32 / 100.0)).collect();
        assert!((rank_correlation(&told.iter().collect::<Vec<_>>(), Epsilon::Published) - 1.0).abs() < 1e-12);
        assert_eq!(rank_correlation(&silent.iter().collect::<Vec<_>>(), Epsilon::Published), 0.0);
        assert_eq!(rank_correlation(&[], Epsilon::Published), 0.0);
    }

    #[test]
    fn classes_share_out_all_cones() {
        let settings = AoSettings { beta: 100.0, gamma: 0.02, max_rays: 8, ..AoSettings::default() };
        let all = [cone(1.0, 0.0, 1.0), cone(0.0, 0.0, 0.5), cone(0.5, 0.01, 0.5), cone(0.5, 0.5, 0.1)];
        let report =
            report(&Pilot { points: vec![crate::PilotPoint { index: 0, cones: all.into() }] }, &settings);
        let shares: Vec<f64> = report.classes.iter().map(|c| c.share).collect();
        assert_eq!(shares, [0.0, 0.25, 0.25, 0.25, 0.25]);
        assert_eq!(report.classes[2].bias, -0.5);
        assert_eq!(report.epsilon.iter().map(|b| b.count).sum::<usize>(), 4);
        assert_eq!(report.epsilon[0].epsilon, 0.0);
    }

    #[test]
    fn epsilon_with_the_error_of_marching_orders_cones_better() {
        let case = crate::testing::test_case(48);
        let found = report(&Pilot::trace(&case, 200).unwrap(), &case.settings);
        let (published, marching) = (found.rank_correlation, found.rank_correlation_marching);
        assert!(marching > published + 0.02 && published > 0.5, "{published}, {marching}");
    }
}
