//! From what was found to what is reported.

mod calibration;
mod causes;
mod cones;
mod failures;
mod figures;
mod ray_to_cone;
mod shaded;
mod table;

use crate::{
    Case, Contender, StudyError, StudyOptions,
    pilot::Pilot,
    quality,
    report::{
        CaseReport, CaseTiming, Quality, TrialReport, TrialTiming, TruthReport, TunedReport, ViewReport,
    },
    search,
    study::Pictures,
    trials::{Trial, Trials, median},
    truth::Truth,
};
use conray::AoSettings;
use rayon::prelude::*;

/// Everything that was found about one case.
pub(crate) struct Evidence<'a> {
    pub(crate) case: &'a Case,
    pub(crate) truth: &'a Truth,
    pub(crate) pilot: &'a Pilot,
    pub(crate) contenders: &'a [Box<dyn Contender>],
    pub(crate) trials: &'a Trials,
    pub(crate) timing: CaseTiming,
    pub(crate) options: &'a StudyOptions,
}

impl Evidence<'_> {
    /// The trial of a contender at an effort.
    fn trial(&self, method: &str, effort: u32) -> Option<&Trial> {
        self.trials.find(self.contenders, method, effort)
    }

    /// The trials of a contender, efforts ascending.
    fn trials_of<'a>(&'a self, method: &'a str) -> impl Iterator<Item = &'a Trial> {
        self.trials.of(self.contenders, method)
    }

    /// Name of a trial's contender.
    fn method(&self, trial: &Trial) -> &'static str {
        self.contenders[trial.contender].name()
    }
}

/// The report of one case; its pictures are added to the others.
pub(crate) fn case_report(
    evidence: &Evidence<'_>,
    pictures: &mut Pictures,
) -> Result<CaseReport, StudyError> {
    let Evidence { case, truth, pilot, options, .. } = evidence;
    let session = &case.session;
    // FLIP runs on one core, so trials are judged side by side.
    let answers: Vec<&[f32]> =
        evidence.trials.list.iter().map(|trial| &trial.answer.visibility[..]).collect();
    let judge = |answer: &&[f32]| quality::judge(case, answer, &truth.visibility);
    let qualities: Vec<Quality> =
        session.install(|| answers.par_iter().map(judge).collect::<Result<_, _>>())?;
    let trials: Vec<TrialReport> = (evidence.trials.list.iter().zip(qualities))
        .map(|(trial, quality)| trial_report(evidence, trial, quality))
        .collect();
    let smallest_judged = trials.iter().map(|t| t.quality.rmse).fold(f64::INFINITY, f64::min);
    let mean =
        |values: &[f32]| values.iter().map(|&v| f64::from(v)).sum::<f64>() / values.len().max(1) as f64;
    let distance = session.plan().distance;
    let mut report = CaseReport {
        id: case.id.clone(),
        scene: case.scene.clone(),
        view: ViewReport {
            name: case.view.name.clone(),
            eye: case.view.eye.to_array(),
            look_at: case.view.look_at.to_array(),
            vertical_fov_deg: case.view.vertical_fov_deg,
        },
        triangles: session.geometry().triangle_count(),
        points: case.points().len(),
        distance: distance.is_finite().then(|| f64::from(distance)),
        voxels: session.octree().map_or(0, |octree| octree.resolution()),
        voxel_size: session.octree().map_or(0.0, |o| f64::from(o.voxel_size())),
        truth: TruthReport {
            rays: truth.rays,
            error: truth.error,
            smallest_judged,
            ratio: if truth.error > 0.0 { smallest_judged / truth.error } else { 0.0 },
            mean_visibility: mean(&truth.visibility),
        },
        table: Vec::new(),
        equal_time: table::equal_time(&trials),
        cones: cones::report(pilot, &case.settings),
        tuned: tuned(pilot, options),
        calibration: calibration::report(evidence),
        causes: causes::report(evidence),
        failures: Vec::new(),
        figures: Vec::new(),
        timing: CaseTiming { noise: evidence.trials.noise(), ..evidence.timing },
        trials,
    };
    report.table = table::rows(&report);
    report.failures = failures::find(evidence, pictures)?;
    report.figures = figures::all(evidence, &report, pictures)?;
    Ok(report)
}

fn trial_report(evidence: &Evidence<'_>, trial: &Trial, quality: Quality) -> TrialReport {
    let contender = &evidence.contenders[trial.contender];
    let points = evidence.case.points().len().max(1) as f64;
    let seconds = median(&trial.seconds);
    let needs = contender.needs();
    let builds = f64::from(u8::from(needs.bvh)) * evidence.timing.bvh_seconds
        + f64::from(u8::from(needs.octree)) * evidence.timing.octree_seconds;
    let expected_rmse = trial.answer.expected_error.as_ref().map(|errors| {
        let squares: f64 = errors.iter().map(|&e| f64::from(e).powi(2)).sum();
        (squares / points).sqrt()
    });
    TrialReport {
        method: contender.name().into(),
        effort: trial.effort.value,
        label: trial.effort.label.clone(),
        rays: trial.answer.rays as f64 / points,
        cones: trial.answer.cones as f64 / points,
        chosen: contender.chosen(trial.effort.value),
        quality,
        expected_rmse: expected_rmse.filter(|rmse| rmse.is_finite()),
        timing: TrialTiming {
            seconds,
            min_seconds: trial.seconds.iter().copied().fold(f64::INFINITY, f64::min),
            max_seconds: trial.seconds.iter().copied().fold(0.0, f64::max),
            runs: trial.seconds.len() as u32,
            seconds_with_builds: seconds + builds,
        },
    }
}

/// A single-precision number as the shortest decimal that stands for it.
pub(crate) fn decimal(value: f32) -> f64 {
    value.to_string().parse().unwrap_or(f64::from(value))
}

fn tuned(pilot: &Pilot, options: &StudyOptions) -> Vec<TunedReport> {
    let found = search::tune(pilot, &options.budgets);
    options
        .budgets
        .iter()
        .zip(found)
        .map(|(&budget, t)| TunedReport {
            budget,
            epsilon: t.constants.epsilon.to_string(),
            beta: decimal(t.constants.beta),
            gamma: decimal(t.constants.gamma),
            max_rays: t.constants.max_rays,
            expected_rays: t.rays,
            expected_rmse: t.rmse,
        })
        .collect()
}

/// What the paper leaves open, and how it was settled here.
pub(crate) fn unstated(settings: &AoSettings) -> Vec<String> {
    vec![
        "Image size: the paper gives none; here as stated under Settings.".into(),
        format!("AO distance: the paper speaks of short rays; here {}.", match settings.distance {
            conray::Distance::Auto => "a tenth of the diagonal of the scene's bounds".to_owned(),
            other => format!("{other} world units"),
        }),
        format!("Cones: their number, directions and apertures are not given; here {} cells of equal cosine weight.", settings.cones),
        format!("Voxels: the octree's depth is not given; here {} leaves along the longest side.", settings.voxels),
        format!(
            "Beta and N_max: not given; here beta {} and N_max {}, with gamma {}. The method paper-tuned shows the best that others give.",
            settings.beta, settings.max_rays, settings.gamma
        ),
        "Scale of its RMSE: its values of up to 0.8 do not fit visibilities in [0, 1] averaged over an image that is mostly open; \
         only ratios are compared.".into(),
        "Rays of its ray tracer: neither their number nor how directions were drawn; its times suggest about as many as the blend takes. \
         Here they follow an Owen-scrambled Sobol sequence, and plain random ones are shown beside.".into(),
        "Rounding of N and what happens where it is 0: here to the nearest whole, and a cone without rays is taken alone.".into(),
        "Accumulation over frames: here the cones are marched once and each frame adds rays, which is the cheaper way to the same picture.".into(),
    ]
}
