//! The figures: those of the paper, then those beyond it.

mod beyond;
mod blend_map;
mod captions;
mod of_paper;

use super::Evidence;
use crate::{
    StudyError,
    picture::Picture,
    report::{CaseReport, Content, Figure, Panel, PlotKind},
    study::Pictures,
};

/// Full scale of difference pictures: an error of this much has the strongest colour.
const DIFFERENCE_SCALE: f32 = 0.3;

/// Every figure of a case, its pictures added to the others.
pub(super) fn all(
    evidence: &Evidence<'_>,
    report: &CaseReport,
    pictures: &mut Pictures,
) -> Result<Vec<Figure>, StudyError> {
    let mut album = Album { evidence, report, pictures };
    let mut figures = of_paper::figures(&mut album)?;
    figures.extend(beyond::figures(&mut album));
    Ok(figures)
}

/// Where figures get their facts from and put their pictures.
struct Album<'a> {
    evidence: &'a Evidence<'a>,
    report: &'a CaseReport,
    pictures: &'a mut Pictures,
}

impl Album<'_> {
    /// A grey picture of one value a point.
    fn grey(&mut self, stem: &str, label: impl Into<String>, values: &[f32]) -> Panel {
        let pixels = self.evidence.case.pixels(values, 1.0);
        self.grey_pixels(stem, label, &pixels)
    }

    /// A grey picture of one value a pixel.
    fn grey_pixels(&mut self, stem: &str, label: impl Into<String>, pixels: &[f32]) -> Panel {
        let (width, height) = self.evidence.case.size();
        self.keep(stem, label, &Picture::grey(width, height, pixels))
    }

    /// Estimate minus truth.
    fn difference(&mut self, stem: &str, label: impl Into<String>, values: &[f32]) -> Panel {
        let case = self.evidence.case;
        let (width, height) = case.size();
        let (found, truth) = (case.pixels(values, 1.0), case.pixels(&self.evidence.truth.visibility, 1.0));
        let picture = Picture::difference(width, height, &found, &truth, DIFFERENCE_SCALE);
        self.keep(stem, label, &picture)
    }

    /// One value a point, from 0 to `most`.
    fn heat(&mut self, stem: &str, label: impl Into<String>, values: &[f32], most: f32) -> Panel {
        let case = self.evidence.case;
        let (width, height) = case.size();
        let picture = Picture::heat(width, height, &case.pixels(values, 0.0), most);
        self.keep(stem, label, &picture)
    }

    fn keep(&mut self, stem: &str, label: impl Into<String>, picture: &Picture) -> Panel {
        let file = format!("pictures/{}-{stem}.png", self.evidence.case.id);
        self.pictures.insert(file.clone(), picture.to_png());
        Panel { file, label: label.into() }
    }
}

fn plot(id: &str, title: &str, kind: PlotKind, caption: String, timing_caption: String) -> Figure {
    Figure { id: id.into(), title: title.into(), content: Content::Plot(kind), caption, timing_caption }
}

fn gallery(id: &str, title: &str, panels: Vec<Panel>, caption: String) -> Figure {
    Figure {
        id: id.into(),
        title: title.into(),
        content: Content::Pictures(panels),
        caption,
        timing_caption: String::new(),
    }
}
