//! What a wrong cone is wrong about, told by what its rays met.

use super::Evidence;
use crate::{
    pilot::{PilotCone, PilotPoint},
    report::CauseReport,
    search::{Constants, share},
};
use conray::AoSettings;
use std::collections::BTreeMap;

/// Errors of a cone up to this are no failure.
const SMALL: f32 = 0.05;

/// Why an estimate at a point is wrong.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Cause {
    Mask,
    Contact,
    Corner,
    Thin,
    Edge,
    Doubled,
    Leak,
    Noise,
    Small,
}

impl Cause {
    /// In words.
    pub(super) fn text(self) -> &'static str {
        match self {
            Self::Mask => "alpha mask: holes finer than a voxel, taken as even haze",
            Self::Contact => "contact: the occluder is within three voxels, where the march has only begun",
            Self::Corner => {
                "corner: the occluder rises from the surface by less than the samples are lifted off it"
            }
            Self::Thin => "thin wall: a voxel or less, smeared over its neighbours by the filter",
            Self::Edge => {
                "edge: an outline divides the cone, which is marched along its axis as wholly open or closed"
            }
            Self::Doubled => "doubled: several surfaces along the cone count more than they cover",
            Self::Leak => "leak: the filter lets through what is closed",
            Self::Noise => "noise: too few rays",
            Self::Small => "many small errors, none of a cone above 0.05",
        }
    }

    /// Why this cone's march is wrong.
    fn of_cone(cone: &PilotCone) -> Self {
        let facts = &cone.occluders;
        if (cone.visibility - cone.truth).abs() <= SMALL {
            Self::Small
        } else if facts.hits > 0 && facts.masked >= 0.5 {
            Self::Mask
        } else if facts.hits > 0 && facts.distance < 3.0 {
            Self::Contact
        } else if facts.hits > 0 && facts.height < 2.0 {
            Self::Corner
        } else if facts.hits > 0 && facts.thin >= 0.5 {
            Self::Thin
        } else if (0.1..=0.9).contains(&cone.truth) {
            Self::Edge
        } else if cone.visibility < cone.truth {
            Self::Doubled
        } else {
            Self::Leak
        }
    }

    /// Why an estimate that blends cones and rays with these constants is wrong at a point: the cone that adds most to
    /// its error tells, or its rays where they err more than the cones.
    pub(super) fn at(point: &PilotPoint, constants: Constants) -> Self {
        let mut worst = (0.0, Self::Small);
        let (mut by_cones, mut by_rays) = (0.0f32, 0.0f32);
        for cone in &point.cones {
            let (alpha, rays) = share(cone, constants);
            let error = cone.weight * alpha * (cone.visibility - cone.truth);
            by_cones += error;
            if rays > 0 {
                by_rays += (cone.weight * (1.0 - alpha)).powi(2) * cone.variance_of_mean(rays);
            }
            if error.abs() > worst.0 {
                worst = (error.abs(), Self::of_cone(cone));
            }
        }
        if by_rays > by_cones * by_cones { Self::Noise } else { worst.1 }
    }
}

/// The constants with which a method blends; `None` for methods that march no cones.
pub(super) fn constants(method: &str, settings: &AoSettings) -> Option<Constants> {
    match method {
        // Nothing is ever above the threshold: the cone alone.
        "cones" => Some(Constants::CONES),
        "paper" => Some(Constants::of(settings)),
        _ => None,
    }
}

/// Shares of the squared error of cones and blend by cause, the largest first.
pub(super) fn report(evidence: &Evidence<'_>) -> Vec<CauseReport> {
    [("cones", evidence.case.settings.cones), ("paper", 1)]
        .into_iter()
        .filter_map(|(method, effort)| Some((method, evidence.trial(method, effort)?)))
        .flat_map(|(method, trial)| {
            let Some(constants) = constants(method, &evidence.case.settings) else { return Vec::new() };
            let mut sums: BTreeMap<Cause, (usize, f64, f64)> = BTreeMap::new();
            for point in &evidence.pilot.points {
                let error = f64::from(trial.answer.visibility[point.index])
                    - f64::from(evidence.truth.visibility[point.index]);
                let sum = sums.entry(Cause::at(point, constants)).or_default();
                *sum = (sum.0 + 1, sum.1 + error * error, sum.2 + error);
            }
            shares(method, &sums)
        })
        .collect()
}

fn shares(method: &str, sums: &BTreeMap<Cause, (usize, f64, f64)>) -> Vec<CauseReport> {
    let points: usize = sums.values().map(|s| s.0).sum();
    let squares: f64 = sums.values().map(|s| s.1).sum();
    let mut causes: Vec<CauseReport> = sums
        .iter()
        .map(|(cause, &(count, square, error))| CauseReport {
            method: method.into(),
            cause: cause.text().into(),
            points: count as f64 / points.max(1) as f64,
            squared_error: if squares > 0.0 { square / squares } else { 0.0 },
            bias: error / count.max(1) as f64,
        })
        .collect();
    causes.sort_by(|a, b| b.squared_error.total_cmp(&a.squared_error));
    causes
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pilot::OccluderFacts;

    fn cone(visibility: f32, truth: f32, occluders: OccluderFacts) -> PilotCone {
        let ray_variance = [0.0; 8];
        PilotCone { weight: 1.0, visibility, epsilon: 0.0, certified: false, truth, ray_variance, occluders }
    }

    #[test]
    fn causes_follow_from_what_rays_met() {
        let far = OccluderFacts { hits: 10, masked: 0.0, thin: 0.0, distance: 20.0, height: 10.0 };
        let cases = [
            (cone(1.0, 0.98, far), Cause::Small),
            (cone(1.0, 0.5, OccluderFacts { masked: 0.9, ..far }), Cause::Mask),
            (cone(1.0, 0.5, OccluderFacts { distance: 1.0, ..far }), Cause::Contact),
            (cone(1.0, 0.5, OccluderFacts { height: 1.0, ..far }), Cause::Corner),
            (cone(1.0, 0.5, OccluderFacts { thin: 0.8, ..far }), Cause::Thin),
            (cone(1.0, 0.5, far), Cause::Edge),
            (cone(0.0, 1.0, OccluderFacts::default()), Cause::Doubled),
            (cone(1.0, 0.0, far), Cause::Leak),
        ];
        for (cone, cause) in cases {
            assert_eq!(Cause::of_cone(&cone), cause, "{cone:?}");
            let point = PilotPoint { index: 0, cones: vec![cone] };
            assert_eq!(Cause::at(&point, Constants::CONES), cause);
        }
        assert!(cases.iter().all(|(_, cause)| !cause.text().is_empty()));
    }

    #[test]
    fn shares_sum_to_one_and_fall() {
        let sums = BTreeMap::from([(Cause::Mask, (3, 1.0, -0.5)), (Cause::Noise, (1, 3.0, 0.1))]);
        let found = shares("paper", &sums);
        assert_eq!(found[0].squared_error, 0.75);
        assert_eq!(found.iter().map(|c| c.points).sum::<f64>(), 1.0);
        assert!(shares("paper", &BTreeMap::new()).is_empty());
    }
}
