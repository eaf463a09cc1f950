//! A made-up study for tests of the page and for looking at it: two cases, nine methods, numbers and pictures by formulas.
//!
//! Compiled into the tests, and by `examples/fixture_report.rs`; it names the crate as a user would.

use conray_study::{
    Report,
    picture::Picture,
    report::{
        CaseReport, CaseTiming, CauseReport, ConeBin, ConeClass, ConeClassReport, ConeReport, Content,
        EqualTime, EqualTimeTiming, ErrorBin, EstimateCalibration, Failure, Figure, MethodReport, Panel,
        PlotKind, Quality, Request, StudyTiming, TableRow, TableTiming, TrialReport, TrialTiming,
        TruthReport, TunedReport, ViewReport,
    },
};
use serde_json::{Map, json};
use std::collections::BTreeMap;

/// Width and height of the pictures.
const SIDE: u32 = 160;

/// Error of a method by formula: `noise / rays^power`, and what stays however many rays there are.
struct Law {
    name: &'static str,
    noise: f64,
    power: f64,
    stays: f64,
    seconds_a_ray: f64,
    seconds_more: f64,
    octree: bool,
}

const LAWS: [Law; 9] = [
    law("rays", 0.30, 0.72, 0.0, 0.004, 0.002, false),
    law("rays-stratified", 0.31, 0.66, 0.0, 0.004, 0.002, false),
    law("rays-random", 0.32, 0.50, 0.0, 0.0042, 0.002, false),
    law("rays-filtered", 0.09, 0.45, 0.0, 0.004, 0.03, false),
    law("rays-denoised", 0.07, 0.38, 0.0, 0.004, 0.12, false),
    law("cones", 0.0, 1.0, 0.083, 0.0, 0.06, true),
    law("paper", 0.12, 0.5, 0.061, 0.004, 0.06, true),
    law("paper-tuned", 0.11, 0.6, 0.012, 0.004, 0.06, true),
    law("hybrid", 0.05, 0.5, 0.0, 0.004, 0.02, true),
];

const fn law(
    name: &'static str,
    noise: f64,
    power: f64,
    stays: f64,
    seconds_a_ray: f64,
    seconds_more: f64,
    octree: bool,
) -> Law {
    Law { name, noise, power, stays, seconds_a_ray, seconds_more, octree }
}

/// The study.
pub(crate) fn report() -> Report {
    let methods = LAWS.iter().map(|law| MethodReport {
        name: law.name.into(),
        about: format!(
            "Made up for looking at the page: noise {} over rays to the power {}.",
            law.noise, law.power
        ),
        needs_bvh: law.noise > 0.0,
        needs_octree: law.octree,
        unavailable: (law.name == "rays-denoised")
            .then(|| "libOpenImageDenoise.so.2 was not found; bench/fetch-rivals gets it.".into()),
    });
    let settings =
        json!({ "distance": "auto", "voxels": 256, "cones": 16, "beta": 4.0, "gamma": 0.02, "seed": 1 });
    Report {
        version: "0.1.0".into(),
        schema: 1,
        quick: true,
        request: Request {
            size: [SIDE, SIDE],
            budgets: (0..7).map(|k| 1 << k).collect(),
            repeats: 3,
            truth_error: 0.003,
            settings: settings.as_object().cloned().unwrap_or_default(),
        },
        methods: methods.collect(),
        cases: vec![case("cornell", "front", 1.0), case("sponza", "nave", 1.6)],
        unstated: vec![
            "Image size: the paper gives none; here as stated under Settings.".into(),
            "Scale of its RMSE: only ratios are compared.".into(),
        ],
        timing: StudyTiming {
            processor: "A made-up processor".into(),
            system: "linux x86_64".into(),
            threads: 2,
            cores: 2,
            seconds: 61.3,
            noise: Some(0.021),
        },
    }
}

/// Every picture that the report shows, by file.
pub(crate) fn pictures(report: &Report) -> BTreeMap<String, Vec<u8>> {
    let mut pictures = BTreeMap::new();
    for case in &report.cases {
        let of_figures = case.figures.iter().flat_map(|f| match &f.content {
            Content::Pictures(panels) => panels.as_slice(),
            Content::Plot(_) => &[],
        });
        for panel in of_figures.chain(case.failures.iter().flat_map(|f| &f.panels)) {
            pictures.insert(panel.file.clone(), picture(&panel.file).to_png());
        }
    }
    pictures
}

/// A ball on a floor, by the closed form of a ball above a plane, with noise that depends on the file's name.
fn picture(file: &str) -> Picture {
    let seed = file.bytes().fold(7u32, |h, b| h.wrapping_mul(31).wrapping_add(u32::from(b)));
    let noise = if file.contains("truth") { 0.0 } else { 0.16 };
    let (mut found, mut truth) = (Vec::new(), Vec::new());
    for i in 0..SIDE * SIDE {
        let (x, y) = ((i % SIDE) as f32 / 80.0 - 1.0, (i / SIDE) as f32 / 80.0 - 1.0);
        let squared = x * x + y * y + 0.16;
        let open = 1.0 - 0.15 / squared * (0.4 / squared.sqrt());
        let hash = (i ^ seed).wrapping_mul(0x9E37_79B9).rotate_left(13).wrapping_mul(0x85EB_CA6B);
        truth.push(open);
        found.push(open + noise * (hash as f32 / u32::MAX as f32 - 0.5));
    }
    let whole = if file.contains("difference") {
        Picture::difference(SIDE, SIDE, &found, &truth, 0.1)
    } else if file.contains("heat") {
        Picture::heat(SIDE, SIDE, &found.iter().map(|v| 1.0 - v).collect::<Vec<_>>(), 1.0)
    } else {
        Picture::grey(SIDE, SIDE, &found)
    };
    if file.contains("failure") { whole.crop_enlarged([90, 70], 24, 6) } else { whole }
}

fn case(scene: &str, view: &str, hardness: f64) -> CaseReport {
    let id = format!("{scene}-{view}");
    let timing = CaseTiming {
        load_seconds: 0.01,
        bvh_seconds: 0.09,
        octree_seconds: 0.4 * hardness,
        noise: Some(0.02),
    };
    let trials: Vec<TrialReport> = LAWS.iter().flat_map(|law| trials(law, hardness, timing)).collect();
    let smallest = trials.iter().map(|t| t.quality.rmse).fold(f64::INFINITY, f64::min);
    CaseReport {
        scene: scene.into(),
        view: ViewReport {
            name: view.into(),
            eye: [0.0, 1.0, 3.5],
            look_at: [0.0, 1.0, 0.0],
            vertical_fov_deg: 39.0,
        },
        triangles: (36.0 * hardness.powi(18)) as u64,
        points: (SIDE * SIDE) as usize - 311,
        distance: Some(0.35 * hardness),
        voxels: 256,
        voxel_size: 0.0078 * hardness,
        truth: TruthReport {
            rays: 2048,
            error: 0.0021,
            smallest_judged: smallest,
            ratio: smallest / 0.0021,
            mean_visibility: 0.81 / hardness.sqrt(),
        },
        table: table(hardness),
        equal_time: equal_time(&trials),
        cones: cones(hardness),
        tuned: (0..7).map(|k| tuned(1 << k)).collect(),
        calibration: trials.iter().filter(|t| t.expected_rmse.is_some()).map(calibration).collect(),
        causes: causes(),
        failures: failures(&id),
        figures: figures(&id),
        timing,
        trials,
        id,
    }
}

fn trials(law: &Law, hardness: f64, timing: CaseTiming) -> Vec<TrialReport> {
    let efforts: Vec<u32> = match law.name {
        "cones" => vec![6, 9, 16, 25],
        _ => (0..7).map(|k| 1 << k).collect(),
    };
    let builds = timing.bvh_seconds + if law.octree { timing.octree_seconds } else { 0.0 };
    let trial = |effort: u32| {
        let unit = match law.name {
            "cones" => "cones",
            "paper" => "frames",
            _ => "rays",
        };
        let count = f64::from(effort);
        let rays = match unit {
            "cones" => 0.0,
            "frames" => 5.3 * count,
            _ => count,
        };
        let stays = if unit == "cones" { law.stays * (16.0 / count).powf(0.25) } else { law.stays };
        let noise = if rays > 0.0 { law.noise * rays.powf(-law.power) } else { 0.0 };
        let rmse = hardness * (noise * noise + stays * stays).sqrt();
        let bias =
            if law.name == "rays" && effort == 8 { 0.0 } else { -0.4 * hardness * stays - 0.001 * noise };
        let seconds = hardness
            * (law.seconds_more
                + law.seconds_a_ray * rays
                + if unit == "cones" { 0.002 * count } else { 0.0 });
        let mut chosen = Map::new();
        if law.name == "rays-filtered" {
            chosen.insert("levels".into(), json!(4));
            chosen.insert("sigma_value".into(), json!(0.6));
        }
        TrialReport {
            method: law.name.into(),
            effort,
            label: if effort == 1 {
                format!("1 {}", unit.trim_end_matches('s'))
            } else {
                format!("{effort} {unit}")
            },
            rays,
            cones: if law.octree { if unit == "cones" { count } else { 16.0 } } else { 0.0 },
            chosen,
            quality: Quality {
                rmse,
                mae: 0.7 * rmse,
                bias,
                relative_bias: bias / 0.8,
                p95: 2.1 * rmse,
                flip: 0.5 * rmse.powf(0.8),
            },
            expected_rmse: (!law.name.starts_with("rays-")).then_some(0.9 * rmse),
            timing: TrialTiming {
                seconds,
                min_seconds: 0.97 * seconds,
                max_seconds: 1.11 * seconds,
                runs: 3,
                seconds_with_builds: seconds + builds,
            },
        }
    };
    efforts.into_iter().map(trial).collect()
}

fn equal_time(trials: &[TrialReport]) -> Vec<EqualTime> {
    trials
        .iter()
        .map(|t| {
            let rays = 0.3 * (t.timing.seconds / 0.004).powf(-0.72);
            let inside = (0.006..0.4).contains(&t.timing.seconds);
            let rmse_ratio = (inside && t.method != "rays").then_some(t.quality.rmse / rays);
            let timing = EqualTimeTiming {
                rmse_ratio,
                rmse_ratio_with_builds: rmse_ratio.map(|r| 1.3 * r),
                hybrid_rmse_ratio: inside.then_some(0.4 * rays / t.quality.rmse),
            };
            EqualTime { method: t.method.clone(), effort: t.effort, timing }
        })
        .collect()
}

/// The paper's own numbers beside made-up ones.
fn table(hardness: f64) -> Vec<TableRow> {
    let paper = if hardness > 1.5 {
        [(0.52953, 285.0), (0.79895, 63.0), (0.47633, 316.0)]
    } else {
        [(0.22815, 60.0), (0.34017, 30.0), (0.28343, 66.0)]
    };
    let row =
        |method: &str, label: &str, rays, rmse: Option<f64>, (theirs, ms): (f64, f64), seconds| TableRow {
            method: method.into(),
            label: label.into(),
            rays,
            rmse: rmse.map(|r| r * hardness),
            blend_ratio: rmse.map(|r| 0.0802 / r),
            paper_rmse: Some(theirs),
            paper_ms: Some(ms),
            paper_blend_ratio: Some(paper[0].0 / theirs),
            timing: TableTiming {
                seconds,
                rmse: rmse.is_none().then_some(0.0623),
                blend_ratio: rmse.is_none().then_some(1.287),
            },
        };
    vec![
        row("paper", "the blend, first frame", 5.3, Some(0.0802), paper[0], 0.0812),
        row("cones", "cones", 0.0, Some(0.083), paper[1], 0.06),
        row("rays", "rays, as many as the blend traces", 5.3, Some(0.0904), paper[2], 0.0232),
        row("rays", "rays, in the blend's time", 0.0, None, paper[2], 0.0812),
    ]
}

fn cones(hardness: f64) -> ConeReport {
    let class = |class, share, rmse, bias, right| ConeClassReport { class, share, rmse, bias, right };
    let bin = |i: u32| {
        let epsilon = f64::from(i) * 0.04;
        let mae = 0.01 * hardness + 0.35 * epsilon;
        ConeBin { count: if i == 0 { 4100 } else { 340 }, epsilon, mae, rmse: 1.3 * mae, p95: 2.4 * mae }
    };
    ConeReport {
        points: 512,
        cones: 16,
        rays: 256,
        classes: vec![
            class(ConeClass::Certified, 0.31, 0.0, 0.0, 1.0),
            class(ConeClass::Open, 0.14, 0.061, 0.022, 0.91),
            class(ConeClass::Closed, 0.05, 0.18, -0.11, 0.62),
            class(ConeClass::Trusted, 0.12, 0.094, -0.031, 0.55),
            class(ConeClass::Refined, 0.38, 0.21, -0.093, 0.21),
        ],
        epsilon: (0..13).map(bin).collect(),
        rank_correlation: 0.71,
        rank_correlation_marching: 0.83,
    }
}

fn tuned(budget: u32) -> TunedReport {
    let root = f64::from(budget).sqrt();
    TunedReport {
        budget,
        epsilon: "published".into(),
        beta: 2.0 * root,
        gamma: 0.04 / root,
        max_rays: 2 + budget,
        expected_rays: 0.94 * f64::from(budget),
        expected_rmse: 0.11 / root,
    }
}

fn calibration(trial: &TrialReport) -> EstimateCalibration {
    let bin = |i: u32| {
        let expected = trial.quality.rmse * (0.2 + 0.17 * f64::from(i));
        let wrong = if trial.method == "paper" { 2.2 } else { 1.05 };
        // The first bin of rays holds points that are wholly open.
        let certain = trial.method == "rays" && i == 0;
        ErrorBin {
            count: if certain { 9000 } else { 1800 },
            expected: if certain { 0.0 } else { expected },
            actual: if certain { 0.0 } else { wrong * expected.powf(0.96) },
        }
    };
    EstimateCalibration {
        method: trial.method.clone(),
        effort: trial.effort,
        label: trial.label.clone(),
        ratio: if trial.method == "paper" { 0.48 } else { 0.97 },
        bins: (0..10).map(bin).collect(),
    }
}

fn causes() -> Vec<CauseReport> {
    let cause = |method: &str, cause: &str, points, squared_error, bias| CauseReport {
        method: method.into(),
        cause: cause.into(),
        points,
        squared_error,
        bias,
    };
    vec![
        cause("cones", "contact: the surface's own voxels close low cones", 0.08, 0.46, -0.13),
        cause("cones", "thin occluder between voxel centres", 0.03, 0.21, 0.09),
        cause("cones", "small everywhere", 0.89, 0.33, -0.01),
        cause("paper", "contact: epsilon is 0 and the cone is wrong", 0.06, 0.71, -0.12),
        cause("paper", "noise of the rays", 0.31, 0.29, 0.0),
    ]
}

fn panels(id: &str, names: &[&str]) -> Vec<Panel> {
    names
        .iter()
        .map(|n| Panel { file: format!("pictures/{id}-{n}.png"), label: n.replace('-', " ") })
        .collect()
}

fn failures(id: &str) -> Vec<Failure> {
    let failure = |n: u32, method: &str, cause: &str| {
        let names = ["result", "truth", "difference"].map(|what| format!("failure-{n}-{what}"));
        Failure {
            method: method.into(),
            label: "1 frame".into(),
            pixel: [90 + n, 70],
            cause: cause.into(),
            panels: panels(id, &names.each_ref().map(String::as_str)),
        }
    };
    vec![
        failure(
            1,
            "paper",
            "The ball's own voxels close the cones along the floor, epsilon stays 0, and no ray is sent.",
        ),
        failure(2, "cones", "A thin rim between voxel centres: its opacity is spread over a whole voxel."),
    ]
}

fn figures(id: &str) -> Vec<Figure> {
    let gallery = |figure: &str, title: &str, names: &[&str]| {
        Figure {
        id: figure.into(),
        title: title.into(),
        content: Content::Pictures(panels(id, names)),
        caption: "Blue is too closed, red too open, full colour at 0.1. The blend's RMSE is 0.97 of that of cones; the paper \
                  has 0.67: it agrees."
            .into(),
        timing_caption: String::new(),
    }
    };
    let plot = |figure: &str, title: &str, kind| Figure {
        id: figure.into(),
        title: title.into(),
        content: Content::Plot(kind),
        caption: "What the plot shows, in a sentence that was made up for looking at the page.".into(),
        timing_caption: "A sentence that depends on the clock.".into(),
    };
    vec![
        gallery("figure-1", "Figure 1: what AO does", &["shaded", "shaded-ao"]),
        gallery("figure-3", "Figure 3: the scene", &["scene"]),
        gallery(
            "figure-4",
            "Figure 4: the first frame",
            &["paper", "cones", "rays", "truth", "paper-difference", "cones-difference", "rays-difference"],
        ),
        plot("figure-5", "Figure 5: error by frames", PlotKind::RmseByFrames),
        gallery("figure-6", "Figure 6: where the blend trusts cones", &["by-cones", "alpha", "rays-heat"]),
        plot("by-time", "Error by time", PlotKind::RmseByTime),
        plot("by-time-built", "Error by time, builds counted", PlotKind::RmseByTimeWithBuilds),
        plot("by-rays", "Error by rays", PlotKind::RmseByRays),
        plot("flip", "Seen error by time", PlotKind::FlipByTime),
        plot("bias", "Bias by time", PlotKind::BiasByTime),
        plot("cone-calibration", "Does epsilon tell the error of a cone?", PlotKind::ConeCalibration),
        plot("estimate-calibration", "Do methods know their error?", PlotKind::EstimateCalibration),
    ]
}
