//! Figures 1 to 6 of the paper.

use super::{Album, blend_map, captions, gallery, plot};
use crate::{
    StudyError,
    assemble::shaded::shade,
    report::{Figure, Panel, PlotKind},
    trials::Trial,
};

pub(super) fn figures(album: &mut Album<'_>) -> Result<Vec<Figure>, StudyError> {
    let mut figures = vec![first(album)];
    figures.extend(second(album));
    figures.push(third(album));
    figures.extend(fourth(album));
    if album.evidence.trial("paper", 1).is_some() {
        figures.push(plot(
            "figure-5",
            "Figure 5: error by frames",
            PlotKind::RmseByFrames,
            captions::fifth(album.report),
            String::new(),
        ));
        figures.push(sixth(album)?);
    }
    Ok(figures)
}

fn first(album: &mut Album<'_>) -> Figure {
    let (case, truth) = (album.evidence.case, album.evidence.truth);
    let without = shade(case, |_| 1.0);
    let with = shade(case, |index| truth.visibility[index]);
    let panels = vec![
        album.grey_pixels("shaded", "without AO", &without),
        album.grey_pixels("shaded-ao", "the sky's light dimmed by AO", &with),
    ];
    gallery("figure-1", "Figure 1: what AO does", panels, captions::first())
}

fn second(album: &mut Album<'_>) -> Option<Figure> {
    let evidence = album.evidence;
    let rays = evidence.trials_of("rays").last()?;
    let cones = evidence.trial("cones", evidence.case.settings.cones)?;
    let panels = vec![
        album.grey("rays-most", format!("rays, {}", rays.effort.label), &rays.answer.visibility),
        album.grey("cones", cones.effort.label.clone(), &cones.answer.visibility),
    ];
    Some(gallery("figure-2", "Figure 2: rays and cones", panels, captions::second(album.report)))
}

fn third(album: &mut Album<'_>) -> Figure {
    let pixels = shade(album.evidence.case, |_| 1.0);
    let label = format!("{}, view {}", album.report.scene, album.report.view.name);
    let panels = vec![album.grey_pixels("scene", label, &pixels)];
    gallery("figure-3", "Figure 3: the scene", panels, captions::third(album.report))
}

fn fourth(album: &mut Album<'_>) -> Option<Figure> {
    let evidence = album.evidence;
    let blend = evidence.trial("paper", 1)?;
    let points = evidence.case.points().len().max(1) as f64;
    let blend_rays = blend.answer.rays as f64 / points;
    let mut shown: Vec<(&str, String, &Trial)> =
        vec![("paper", format!("blend, {blend_rays:.0} rays"), blend)];
    if let Some(cones) = evidence.trial("cones", evidence.case.settings.cones) {
        shown.push(("cones", cones.effort.label.clone(), cones));
    }
    // The budget nearest to the rays of the blend, in ratio.
    let off = |t: &Trial| (f64::from(t.effort.value).ln() - blend_rays.max(1.0).ln()).abs();
    if let Some(rays) = evidence.trials_of("rays").min_by(|a, b| off(a).total_cmp(&off(b))) {
        shown.push(("rays", format!("rays, {}", rays.effort.label), rays));
    }
    let mut panels: Vec<Panel> = Vec::new();
    for (stem, label, trial) in &shown {
        panels.push(album.grey(&format!("first-{stem}"), label.clone(), &trial.answer.visibility));
    }
    let truth = format!("truth, {} rays", evidence.truth.rays);
    panels.push(album.grey("truth", truth, &evidence.truth.visibility));
    for (stem, label, trial) in &shown {
        let label = format!("{label}: minus truth");
        panels.push(album.difference(&format!("first-{stem}-difference"), label, &trial.answer.visibility));
    }
    Some(gallery("figure-4", "Figure 4: the first frame", panels, captions::fourth(album.report)))
}

fn sixth(album: &mut Album<'_>) -> Result<Figure, StudyError> {
    let map = blend_map::map(album.evidence.case)?;
    let by_cones: Vec<f32> = map.iter().map(|b| b.by_cones).collect();
    let alpha: Vec<f32> = map.iter().map(|b| b.alpha).collect();
    let rays: Vec<f32> = map.iter().map(|b| b.rays as f32).collect();
    let settings = &album.evidence.case.settings;
    let most = (settings.cones * settings.max_rays) as f32;
    let panels = vec![
        album.grey("blend-cones-only", "the blend without its rays", &by_cones),
        album.grey("blend-alpha", "alpha: white trusts cones", &alpha),
        album.heat("blend-rays", format!("rays, 0 to {most:.0}"), &rays, most),
    ];
    let mean =
        |values: &[f32]| values.iter().map(|&v| f64::from(v)).sum::<f64>() / values.len().max(1) as f64;
    let caption = captions::sixth(mean(&alpha), mean(&rays), most);
    Ok(gallery("figure-6", "Figure 6: where the blend trusts cones", panels, caption))
}
