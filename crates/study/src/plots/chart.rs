//! The common part of all plots: area, grid, axis titles, series of marks, and a legend below.

use super::{axis::Axis, legend, style::Style};
use crate::svg::{Anchor, Svg};

/// Width of every plot in units; text of 13 units stays readable on a telephone.
pub(super) const WIDTH: f64 = 480.0;
const LEFT: f64 = 66.0;
const RIGHT: f64 = 14.0;
const TOP: f64 = 12.0;
const HEIGHT: f64 = 280.0;
/// Room below the area for tick labels and the title of the axis.
const BELOW: f64 = 46.0;

/// One measured point.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Mark {
    pub(super) x: f64,
    pub(super) y: f64,
    /// From where to where `x` was seen, drawn as a thin bar.
    pub(super) spread: Option<(f64, f64)>,
    /// Half the marker's width.
    pub(super) size: f64,
    /// All numbers, for a pointer that rests on it.
    pub(super) title: String,
}

impl Mark {
    /// Half the width of a marker that says nothing by its size.
    pub(super) const SIZE: f64 = 4.2;
}

/// The marks of one method, in the order in which a line joins them.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Series {
    /// As in the legend.
    pub(super) name: String,
    pub(super) style: Style,
    pub(super) marks: Vec<Mark>,
}

impl Series {
    /// Marks that can be drawn; a missing number is no number.
    fn known(&self) -> impl Iterator<Item = &Mark> {
        self.marks.iter().filter(|m| m.x.is_finite() && m.y.is_finite())
    }
}

/// A plot of series.
pub(super) struct Chart<'a> {
    /// What it shows, in a sentence, for those who do not see it.
    pub(super) label: &'a str,
    pub(super) x: Axis,
    pub(super) y: Axis,
    pub(super) series: Vec<Series>,
    /// Draws the line y = x.
    pub(super) diagonal: bool,
    /// Outline of an area behind the series, in values, and what the legend says of it.
    pub(super) band: Option<(Vec<[f64; 2]>, &'a str)>,
}

impl Chart<'_> {
    pub(super) fn draw(&self) -> String {
        let mut svg = Svg::new();
        self.grid(&mut svg);
        if let Some((outline, _)) = &self.band {
            let places: Vec<[f64; 2]> = outline.iter().map(|p| self.at(p[0], p[1])).collect();
            svg.polygon("band", &places);
        }
        if self.diagonal {
            self.draw_diagonal(&mut svg);
        }
        let mut clamped = false;
        for series in &self.series {
            svg.group(&series.style.class(), None);
            let line: Vec<[f64; 2]> = series.known().map(|m| self.at(m.x, m.y)).collect();
            svg.polyline("curve", &line, series.style.dash());
            for mark in series.known() {
                clamped |= self.draw_mark(&mut svg, series.style, mark);
            }
            svg.close();
        }
        let bottom = legend::draw(&mut svg, self, clamped, TOP + HEIGHT + BELOW + 16.0);
        svg.finish(WIDTH, bottom, self.label)
    }

    /// Place of a pair of values in the drawing.
    fn at(&self, x: f64, y: f64) -> [f64; 2] {
        [LEFT + self.x.place(x) * (WIDTH - LEFT - RIGHT), TOP + (1.0 - self.y.place(y)) * HEIGHT]
    }

    fn grid(&self, svg: &mut Svg) {
        let (right, bottom) = (WIDTH - RIGHT, TOP + HEIGHT);
        svg.group("axes", None);
        for (value, text) in &self.x.ticks {
            let class = if text.is_empty() { "grid fine" } else { "grid" };
            let x = LEFT + self.x.place(*value) * (right - LEFT);
            svg.line(class, [x, TOP], [x, bottom]);
        }
        for (value, text) in &self.y.ticks {
            let class = if text.is_empty() { "grid fine" } else { "grid" };
            let y = TOP + (1.0 - self.y.place(*value)) * HEIGHT;
            svg.line(class, [LEFT, y], [right, y]);
            svg.text("tick", [LEFT - 6.0, y + 4.5], Anchor::End, text);
        }
        self.label_x(svg, right, bottom);
        svg.line("axis", [LEFT, TOP], [LEFT, bottom]);
        svg.line("axis", [LEFT, bottom], [right, bottom]);
        svg.text("name", [(LEFT + right) / 2.0, bottom + 40.0], Anchor::Middle, &self.x.title);
        svg.text_upwards("name", [15.0, TOP + HEIGHT / 2.0], Anchor::Middle, &self.y.title);
        svg.close();
    }

    /// Labels below the area, without those that would touch their neighbour.
    fn label_x(&self, svg: &mut Svg, right: f64, bottom: f64) {
        let mut free_from = 0.0;
        for (value, text) in self.x.ticks.iter().filter(|t| !t.1.is_empty()) {
            let half = legend::text_width(text) / 2.0;
            // The last label stays inside the drawing.
            let x = (LEFT + self.x.place(*value) * (right - LEFT)).min(WIDTH - half - 1.0);
            if x - half >= free_from {
                svg.text("tick", [x, bottom + 18.0], Anchor::Middle, text);
                free_from = x + half + 6.0;
            }
        }
    }

    /// From where the line y = x enters the area to where it leaves it.
    fn draw_diagonal(&self, svg: &mut Svg) {
        let ends = |axis: &Axis| (axis.ticks.first().map(|t| t.0), axis.ticks.last().map(|t| t.0));
        if let ((Some(a), Some(b)), (Some(c), Some(d))) = (ends(&self.x), ends(&self.y)) {
            let (from, to) = (a.max(c), b.min(d));
            svg.line("diagonal", self.at(from, from), self.at(to, to));
        }
    }

    /// Says whether the mark lies beyond an axis and was drawn at its edge.
    fn draw_mark(&self, svg: &mut Svg, style: Style, mark: &Mark) -> bool {
        let at = self.at(mark.x, mark.y);
        let (low, left) = (self.y.is_below(mark.y), self.x.is_below(mark.x));
        svg.group(if low || left { "mark clamped" } else { "mark" }, Some(&mark.title));
        if let Some((least, most)) = mark.spread.filter(|(a, b)| a.is_finite() && b.is_finite()) {
            svg.line("spread", self.at(least, mark.y), self.at(most, mark.y));
        }
        style.mark(svg, at, mark.size);
        if low {
            svg.polyline("edge", &legend::arrow(at, [0.0, 1.0]), "");
        }
        if left {
            svg.polyline("edge", &legend::arrow(at, [-1.0, 0.0]), "");
        }
        svg.close();
        low || left
    }
}
