//! Where methods fail: crops about the worst places, with the cause named.

use super::{
    Evidence,
    causes::{Cause, constants},
};
use crate::{
    StudyError,
    case::file_name,
    picture::Picture,
    pilot,
    report::{Failure, Panel},
    study::Pictures,
    trials::Trial,
};

/// Side of a crop in pixels, and how much it is enlarged.
const SIDE: u32 = 48;
const ENLARGED: u32 = 4;
/// Errors are averaged over squares of this side before the worst place is looked for: blotches, not single pixels.
const WINDOW: i64 = 5;
/// Full scale of the difference pictures.
const SCALE: f32 = 0.5;

/// The two worst places of each method at one effort, the worst of each cause for the blend, and the worst of what the
/// scene's other views show from nearby, such as a corner.
pub(super) fn find(evidence: &Evidence<'_>, pictures: &mut Pictures) -> Result<Vec<Failure>, StudyError> {
    let mut failures = Vec::new();
    for contender in evidence.contenders {
        let Some(trial) = judged_trial(evidence, contender.name()) else { continue };
        for (number, place) in worst_places(evidence, trial).into_iter().enumerate() {
            let cause = cause_at(evidence, trial, place)?;
            let stem = format!("{}-worst-{}", contender.name(), number + 1);
            failures.push(crop(evidence, trial, place, cause, &stem, pictures));
        }
    }
    if let Some(trial) = evidence.trial("paper", 1) {
        for (cause, index) in worst_of_causes(evidence, trial) {
            let place = evidence.case.points()[index].id;
            let stem = format!("paper-cause-{}", format!("{cause:?}").to_lowercase());
            failures.push(crop(evidence, trial, place, cause.text().into(), &stem, pictures));
        }
    }
    for place in &evidence.case.places {
        for method in ["cones", "paper"] {
            let Some(trial) = judged_trial(evidence, method) else { continue };
            let shown = |index: &usize| place.shows(evidence.case.points()[*index].position);
            let Some(index) = worst_first(evidence, trial).into_iter().find(shown) else { continue };
            let pixel = evidence.case.points()[index].id;
            let cause = format!("{}: {}", place.view.name, cause_at(evidence, trial, pixel)?);
            let stem = format!("{method}-place-{}", file_name(&place.view.name));
            failures.push(crop(evidence, trial, pixel, cause, &stem, pictures));
        }
    }
    Ok(failures)
}

/// The effort at which a method is shown: cones as set, the blend's first frame, else the middle of the curve.
fn judged_trial<'a>(evidence: &'a Evidence<'_>, method: &'a str) -> Option<&'a Trial> {
    match method {
        "cones" => evidence.trial("cones", evidence.case.settings.cones),
        "paper" => evidence.trial(method, 1),
        _ => {
            let count = evidence.trials_of(method).count();
            evidence.trials_of(method).nth(count / 2)
        }
    }
}

/// Pixels in the middle of the worst squares, the second clear of the first.
fn worst_places(evidence: &Evidence<'_>, trial: &Trial) -> Vec<u32> {
    let case = evidence.case;
    let (width, _) = case.size();
    let apart =
        |a: u32, b: u32| (a % width).abs_diff(b % width) >= SIDE || (a / width).abs_diff(b / width) >= SIDE;
    let ranked = worst_first(evidence, trial);
    let pixels = || ranked.iter().map(|&index| case.points()[index].id);
    let first = pixels().next();
    let second = pixels().find(|&id| first.is_some_and(|f| apart(f, id)));
    first.into_iter().chain(second).collect()
}

/// Indices of the points by the mean squared error of the square about each, the largest first.
fn worst_first(evidence: &Evidence<'_>, trial: &Trial) -> Vec<usize> {
    let case = evidence.case;
    let pairs = trial.answer.visibility.iter().zip(&evidence.truth.visibility);
    let squared: Vec<f32> = pairs.map(|(v, t)| (v - t) * (v - t)).collect();
    let pixels = case.pixels(&squared, 0.0);
    let mut ranked: Vec<(f32, usize)> = (case.points().iter().enumerate())
        .map(|(index, p)| (around(&pixels, case.size(), p.id), index))
        .collect();
    ranked.sort_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
    ranked.into_iter().map(|(_, index)| index).collect()
}

/// Mean over the square about a pixel, as far as it lies in the image.
fn around(pixels: &[f32], (width, height): (u32, u32), id: u32) -> f32 {
    let (x, y) = (i64::from(id % width), i64::from(id / width));
    let reach = WINDOW / 2;
    let (mut sum, mut count) = (0.0, 0);
    for row in (y - reach).max(0)..=(y + reach).min(i64::from(height) - 1) {
        for column in (x - reach).max(0)..=(x + reach).min(i64::from(width) - 1) {
            sum += pixels[(row * i64::from(width) + column) as usize];
            count += 1;
        }
    }
    sum / count as f32
}

/// Why a method is wrong at a pixel.
fn cause_at(evidence: &Evidence<'_>, trial: &Trial, pixel: u32) -> Result<String, StudyError> {
    let case = evidence.case;
    let Some(index) = case.points().iter().position(|p| p.id == pixel) else { return Ok(String::new()) };
    let method = evidence.method(trial);
    let tuned = evidence.contenders[trial.contender].chosen(trial.effort.value);
    let blend = constants(method, &case.settings).or_else(|| {
        let number = |name: &str| tuned.get(name).and_then(serde_json::Value::as_f64);
        let (beta, gamma, rays) = (number("beta")?, number("gamma")?, number("max-rays")?);
        let epsilon = tuned.get("epsilon")?.as_str()?.parse().ok()?;
        Some(crate::search::Constants {
            epsilon,
            beta: beta as f32,
            gamma: gamma as f32,
            max_rays: rays as u32,
        })
    });
    if let Some(constants) = blend {
        let points = pilot::trace_points(case, &[index])?;
        return Ok(points.first().map_or("", |p| Cause::at(p, constants).text()).into());
    }
    let truth = case.pixels(&evidence.truth.visibility, 1.0);
    let found = case.pixels(&trial.answer.visibility, 1.0);
    let (here, true_here) = (found[pixel as usize], truth[pixel as usize]);
    let true_around = around(&truth, case.size(), pixel);
    let smoothing = !matches!(method, "rays" | "rays-random" | "rays-stratified");
    Ok(if smoothing && (here - true_around).abs() < 0.5 * (here - true_here).abs() {
        "smoothed away: detail finer than the filter's neighbourhood".into()
    } else if smoothing {
        "noise that the filter took for detail, or spread".into()
    } else {
        Cause::Noise.text().into()
    })
}

/// For each cause the sampled point of largest error, causes of at least a thirtieth of the squared error only.
fn worst_of_causes(evidence: &Evidence<'_>, trial: &Trial) -> Vec<(Cause, usize)> {
    let Some(constants) = constants("paper", &evidence.case.settings) else { return Vec::new() };
    let mut worst: std::collections::BTreeMap<Cause, (f32, f32, usize)> = Default::default();
    let mut all = 0.0;
    for point in &evidence.pilot.points {
        let error = trial.answer.visibility[point.index] - evidence.truth.visibility[point.index];
        all += error * error;
        let entry = worst.entry(Cause::at(point, constants)).or_insert((0.0, 0.0, point.index));
        entry.0 += error * error;
        if error.abs() > entry.1 {
            (entry.1, entry.2) = (error.abs(), point.index);
        }
    }
    let mut found: Vec<(f32, Cause, usize)> = worst
        .into_iter()
        .filter(|(cause, w)| *cause != Cause::Small && w.0 > all / 30.0)
        .map(|(cause, w)| (w.0, cause, w.2))
        .collect();
    found.sort_by(|a, b| b.0.total_cmp(&a.0));
    found.into_iter().map(|(_, cause, index)| (cause, index)).collect()
}

fn crop(
    evidence: &Evidence<'_>,
    trial: &Trial,
    pixel: u32,
    cause: String,
    stem: &str,
    pictures: &mut Pictures,
) -> Failure {
    let case = evidence.case;
    let (width, height) = case.size();
    let place = [pixel % width, pixel / width];
    let found = case.pixels(&trial.answer.visibility, 1.0);
    let truth = case.pixels(&evidence.truth.visibility, 1.0);
    let whole = [
        ("result", Picture::grey(width, height, &found)),
        ("truth", Picture::grey(width, height, &truth)),
        ("difference", Picture::difference(width, height, &found, &truth, SCALE)),
    ];
    let panels = whole
        .into_iter()
        .map(|(label, picture)| {
            let file = format!("pictures/{}-{stem}-{label}.png", case.id);
            pictures.insert(file.clone(), picture.crop_enlarged(place, SIDE, ENLARGED).to_png());
            Panel { file, label: label.into() }
        })
        .collect();
    Failure {
        method: evidence.method(trial).into(),
        label: trial.effort.label.clone(),
        pixel: place,
        cause,
        panels,
    }
}
