//! `--explain`: the plan and why, in words; and whether the error asked for was reached.

use crate::failure::Failure;
use conray::{AoPlan, Choice, Explanation, Work};

/// Plain lines about how the budget was spent.
pub(crate) fn lines(plan: &AoPlan, work: &Work) -> Vec<String> {
    let Some(explanation) = &work.explanation else {
        return vec![format!("plan: method {} does one fixed amount of work", plan.method)];
    };
    let mut lines = vec![format!("budget: {}", budget(plan))];
    lines.push(costs(explanation));
    lines.push(choice(explanation));
    lines.push(
        "cones: left out; calibrated cones know about as much as 16 to 20 rays and cost as much as 24 to 85 (docs/method.md)".into(),
    );
    for (k, round) in explanation.rounds.iter().enumerate() {
        lines.push(format!(
            "round {}: {:.1} rays a point, expected error {:.4}, {:.3} s",
            k + 1,
            round.rays_per_point,
            round.expected_rmse,
            round.seconds
        ));
    }
    lines.push(format!("end: {}", work.ended));
    lines
}

/// Fails where a device failed before anything was estimated: there is nothing to write.
pub(crate) fn stop_if_nothing(work: &Work) -> Result<(), Failure> {
    match &work.failure {
        Some(reason) if work.rays == 0 && work.cones == 0 => {
            Err(Failure::Work(format!("{reason}; nothing was estimated, no file was written")))
        }
        _ => Ok(()),
    }
}

/// Fails where a device failed, once what it had done is written.
pub(crate) fn stop_if_failed(work: &Work) -> Result<(), Failure> {
    let failed = |reason: &String| Failure::Work(format!("{reason}; what was done by then has been written"));
    work.failure.as_ref().map_or(Ok(()), |reason| Err(failed(reason)))
}

fn budget(plan: &AoPlan) -> String {
    let budget = &plan.budget;
    let mut parts = Vec::new();
    if budget.rays < *conray::limits::RAYS.end() || (budget.seconds, budget.error) == (None, None) {
        parts.push(format!("{} rays a point", budget.rays));
    }
    parts.extend(budget.seconds.map(|seconds| format!("{seconds} s")));
    parts.extend(budget.error.map(|error| format!("an expected error of {error}")));
    parts.join(" or ")
}

fn costs(explanation: &Explanation) -> String {
    let mut line = format!("costs for {} points:", explanation.points);
    match explanation.ray_seconds {
        Some(seconds) => line += &format!(" a ray {:.1} ns", 1e9 * seconds),
        None => line += " nothing was traced",
    }
    if let Some(seconds) = explanation.weighing_seconds {
        line += &format!(", a weighing {:.1} ms", 1e3 * seconds);
    }
    line
}

fn choice(explanation: &Explanation) -> String {
    let how = match explanation.choice {
        Choice::Hybrid => "rays where they help most, pooled with like neighbours",
        Choice::Evenly => "rays evenly, each point by its own",
    };
    let why = if explanation.bundle_rays < 64 {
        "so few that small ones reach more points"
    } else {
        "full ones cost least a ray"
    };
    let mut line = format!(
        "plan: {how}; {:.1} rays a point foreseen, in bundles of {}: {why}",
        explanation.foreseen_rays, explanation.bundle_rays
    );
    if let Some([pooled, even]) = explanation.foreseen_rmse {
        let even =
            if even.is_finite() { format!("{even:.4}") } else { "too few for a bundle a point".into() };
        line += &format!("; error foreseen pooled {pooled:.4}, evenly {even}");
    }
    line
}

/// What to tell where an error was asked for and not reached; a failure with `strict`.
pub(crate) fn missed(plan: &AoPlan, work: &Work) -> Option<String> {
    let error = plan.budget.error.filter(|_| plan.method.has_budget())?;
    // Nothing to estimate is no error.
    let has_points = work.explanation.as_ref().is_some_and(|e| e.points > 0);
    (has_points && work.expected_rmse > f64::from(error)).then(|| {
        let (reached, ended) = (work.expected_rmse, work.ended);
        format!(
            "the expected error reached is {reached:.4}, not {error}: {ended}; allow more --time or --rays"
        )
    })
}

/// Fails where an error was missed and that matters.
pub(crate) fn check(strict: bool, missed: Option<String>) -> Result<(), Failure> {
    missed.filter(|_| strict).map_or(Ok(()), |missed| Err(Failure::Work(missed)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use conray::Ended;

    #[test]
    fn a_device_that_failed_is_told_before_or_after_what_is_written() {
        let work = |failure: Option<&str>, rays| Work {
            completed: failure.is_none(),
            ended: if failure.is_some() { Ended::Failed } else { Ended::Rays },
            failure: failure.map(Into::into),
            expected_rmse: 0.1,
            seconds: 1.0,
            points: 4,
            rays,
            cones: 0,
            explanation: None,
        };
        let told = |result: Result<(), Failure>| match result {
            Err(Failure::Work(message)) => message,
            other => panic!("{other:?}"),
        };
        assert!(stop_if_nothing(&work(None, 0)).is_ok() && stop_if_failed(&work(None, 9)).is_ok());
        assert!(stop_if_nothing(&work(Some("lost"), 9)).is_ok());
        assert_eq!(
            told(stop_if_nothing(&work(Some("lost"), 0))),
            "lost; nothing was estimated, no file was written"
        );
        assert_eq!(
            told(stop_if_failed(&work(Some("lost"), 9))),
            "lost; what was done by then has been written"
        );
    }
}
