//! What carrying out a plan came to.

use conray_core::Estimate;
use conray_estimate::{Ended, Explanation};

/// What became of the points.
#[derive(Clone, Debug)]
pub struct Outcome {
    /// One per point, in order; pending where the work was stopped before it reached the point.
    pub estimates: Vec<Estimate>,
    /// What it took.
    pub work: Work,
}

/// What the estimates of some points took, and what ended it.
#[derive(Clone, Debug)]
pub struct Work {
    /// False where the caller stopped the work, or a device failed.
    pub completed: bool,
    /// What ended the work.
    pub ended: Ended,
    /// What a device said that failed ([`Ended::Failed`]): what was estimated by then is there all the same.
    pub failure: Option<String>,
    /// Expected RMSE of visibility over the points that can be estimated; infinite where one was not reached or there is none.
    pub expected_rmse: f64,
    /// Wall-clock time of the estimation alone.
    pub seconds: f64,
    /// Points asked about.
    pub points: u64,
    /// Rays traced.
    pub rays: u64,
    /// Cones marched.
    pub cones: u64,
    /// How the budget was spent, and why; `None` for methods that do one fixed amount of work.
    pub explanation: Option<Explanation>,
}

impl Work {
    /// Work on parts of a target, one after the other, as one: what ended the part that came least far, and errors by the numbers of points.
    /// Explanations stay with the parts. `None` of no part.
    pub fn of_parts(parts: &[Self]) -> Option<Self> {
        let ended = parts.iter().map(|part| part.ended).max_by_key(|ended| rank(*ended))?;
        let estimated = |part: &Self| part.explanation.as_ref().map_or(part.points, |e| e.points) as f64;
        let reached = parts.iter().filter(|part| estimated(part) > 0.0);
        let squares: f64 = reached.clone().map(|part| estimated(part) * part.expected_rmse.powi(2)).sum();
        let count: f64 = reached.map(estimated).sum();
        Some(Self {
            completed: parts.iter().all(|part| part.completed),
            ended,
            failure: parts.iter().find_map(|part| part.failure.clone()),
            expected_rmse: if count > 0.0 { (squares / count).sqrt() } else { f64::INFINITY },
            seconds: parts.iter().map(|part| part.seconds).sum(),
            points: parts.iter().map(|part| part.points).sum(),
            rays: parts.iter().map(|part| part.rays).sum(),
            cones: parts.iter().map(|part| part.cones).sum(),
            explanation: None,
        })
    }
}

/// How far from what was wanted.
fn rank(ended: Ended) -> u32 {
    match ended {
        Ended::Done => 0,
        Ended::Error => 1,
        Ended::Rays => 2,
        Ended::Time => 3,
        Ended::Cancelled => 4,
        Ended::Failed => 5,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn part(ended: Ended, points: u64, expected_rmse: f64) -> Work {
        let completed = ended != Ended::Cancelled;
        Work {
            completed,
            ended,
            failure: (ended == Ended::Failed).then(|| "lost".into()),
            expected_rmse,
            seconds: 1.5,
            points,
            rays: 10,
            cones: 1,
            explanation: None,
        }
    }

    #[test]
    fn parts_count_by_their_points() {
        let parts = [
            part(Ended::Error, 100, 0.02),
            part(Ended::Time, 300, 0.06),
            part(Ended::Done, 0, f64::INFINITY),
        ];
        let all = Work::of_parts(&parts).unwrap();
        assert_eq!((all.ended, all.points, all.rays, all.completed), (Ended::Time, 400, 30, true));
        assert!((all.expected_rmse - (0.25 * 0.0004 + 0.75 * 0.0036f64).sqrt()).abs() < 1e-12);
        assert_eq!(all.seconds, 4.5);
        assert!(!Work::of_parts(&[part(Ended::Cancelled, 1, 0.1)]).unwrap().completed);
        let failed = Work::of_parts(&[part(Ended::Time, 1, 0.1), part(Ended::Failed, 1, 0.1)]).unwrap();
        assert_eq!((failed.ended, failed.failure.as_deref()), (Ended::Failed, Some("lost")));
        assert!(Work::of_parts(&[]).is_none());
        assert_eq!(Work::of_parts(&parts[2..]).unwrap().expected_rmse, f64::INFINITY);
    }
}
