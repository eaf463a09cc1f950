//! Error against time: what is kept of each run, and its picture.

use crate::{engine::Picture, text::tick};
use conray::Method;
use egui::{Align2, Color32, FontId, Pos2, Rect, Sense, Shape, Stroke, Ui, Vec2, pos2, vec2};

/// Runs that are kept: the one that goes on and some before it, to compare with.
const KEPT: usize = 4;

/// The course of one method in one run.
#[derive(Clone, Debug)]
pub(crate) struct Course {
    pub(crate) method: Method,
    /// Seconds of work, and the expected RMSE then.
    pub(crate) expected: Vec<[f64; 2]>,
    /// Seconds of work, and the RMSE against the truth then, where there is one.
    pub(crate) measured: Vec<[f64; 2]>,
}

/// The courses of a run, one a side, and those of runs before.
#[derive(Debug, Default)]
pub(crate) struct Curves {
    pub(crate) now: Vec<Course>,
    before: Vec<Vec<Course>>,
}

impl Curves {
    /// Adds what a picture tells; a preview begins a new run.
    pub(crate) fn add(&mut self, picture: &Picture, measured: &[Option<f64>]) {
        if picture.is_preview() {
            self.restart();
            return;
        }
        let same = self.now.len() == picture.sides.len()
            && self.now.iter().zip(&picture.sides).all(|(a, b)| {
                a.method == b.method && a.expected.last().is_none_or(|last| last[0] <= b.seconds)
            });
        if !same {
            self.restart();
            let course = |method| Course { method, expected: Vec::new(), measured: Vec::new() };
            self.now = picture.sides.iter().map(|side| course(side.method)).collect();
        }
        for (index, (course, side)) in self.now.iter_mut().zip(&picture.sides).enumerate() {
            let at = |y: f64| [side.seconds.max(1e-4), y];
            let is_new = course.expected.last().is_none_or(|last| last[0] < side.seconds);
            if side.expected_rmse.is_finite() && is_new {
                course.expected.push(at(side.expected_rmse));
            }
            let measured = measured.get(index).copied().flatten();
            if let Some(rmse) = measured.filter(|rmse| rmse.is_finite() && *rmse > 0.0)
                && course.measured.last().is_none_or(|last| last[0] < side.seconds)
            {
                course.measured.push(at(rmse));
            }
        }
    }

    fn restart(&mut self) {
        let now = std::mem::take(&mut self.now);
        if now.iter().any(|course| course.expected.len() > 1) {
            self.before.insert(0, now);
            self.before.truncate(KEPT);
        }
    }
}

/// Colours of the two sides, readable on light and dark.
pub(crate) fn side_colour(side: usize, dark: bool) -> Color32 {
    match (side, dark) {
        (0, true) => Color32::from_rgb(110, 180, 255),
        (0, false) => Color32::from_rgb(20, 95, 190),
        (_, true) => Color32::from_rgb(255, 165, 90),
        (_, false) => Color32::from_rgb(190, 80, 10),
    }
}

/// Both axes are logarithmic: decades.
struct Axes {
    rect: Rect,
    x: [f64; 2],
    y: [f64; 2],
}

impl Axes {
    /// Axes that hold all points, whole decades in height.
    fn around(rect: Rect, points: impl Iterator<Item = [f64; 2]>) -> Option<Self> {
        let (mut x, mut y) = ([f64::MAX, f64::MIN], [f64::MAX, f64::MIN]);
        for [px, py] in points {
            (x[0], x[1]) = (x[0].min(px.log10()), x[1].max(px.log10()));
            (y[0], y[1]) = (y[0].min(py.log10()), y[1].max(py.log10()));
        }
        if x[0] > x[1] {
            return None;
        }
        let (x, y) = (
            [x[0].floor(), x[1].max(x[0].floor() + 1.0)],
            [y[0].floor(), y[1].ceil().max(y[0].floor() + 1.0)],
        );
        Some(Self { rect, x, y })
    }

    fn at(&self, [px, py]: [f64; 2]) -> Pos2 {
        let share = |v: f64, [low, high]: [f64; 2]| ((v.log10() - low) / (high - low)) as f32;
        pos2(
            self.rect.left() + share(px, self.x) * self.rect.width(),
            self.rect.bottom() - share(py, self.y) * self.rect.height(),
        )
    }
}

/// Round values between two powers of ten: those of 1, and where there is room of 2 and 5.
fn ticks([low, high]: [f64; 2]) -> Vec<f64> {
    let steps: &[f64] = if high - low > 2.5 { &[1.0] } else { &[1.0, 2.0, 5.0] };
    let decades = low.floor() as i32..=high.ceil() as i32;
    let all = decades.flat_map(|decade| steps.iter().map(move |step| step * 10f64.powi(decade)));
    all.filter(|value| (low - 1e-9..=high + 1e-9).contains(&value.log10())).collect()
}

/// Draws the courses, and the error that is to be reached.
pub(crate) fn show(ui: &mut Ui, curves: &Curves, goal: Option<f32>, size: Vec2) {
    let (outer, response) = ui.allocate_exact_size(size, Sense::hover());
    let visuals = ui.visuals();
    let (weak, text, dark) = (visuals.weak_text_color(), visuals.text_color(), visuals.dark_mode);
    let painter = ui.painter().with_clip_rect(outer);
    let font = FontId::proportional(11.0);
    let rect = Rect::from_min_max(outer.min + vec2(46.0, 18.0), outer.max - vec2(10.0, 18.0));
    painter.text(outer.min, Align2::LEFT_TOP, "error (RMSE) against seconds", font.clone(), text);
    let goals = goal.map(|goal| f64::from(goal.max(1e-5)));
    let all = || curves.before.iter().flatten().chain(&curves.now);
    let points = all().flat_map(|c| c.expected.iter().chain(&c.measured)).copied();
    let Some(mut axes) = Axes::around(rect, points) else {
        painter.text(rect.center(), Align2::CENTER_CENTER, "nothing refined yet", font, weak);
        return;
    };
    if let Some(goal) = goals {
        axes.y[0] = axes.y[0].min(goal.log10().floor());
    }
    painter.rect_stroke(rect, 0.0, Stroke::new(1.0, weak), egui::StrokeKind::Middle);
    for value in ticks(axes.y) {
        let y = axes.at([1.0, value]).y;
        painter.hline(rect.x_range(), y, Stroke::new(0.5, weak.gamma_multiply(0.5)));
        painter.text(pos2(rect.left() - 4.0, y), Align2::RIGHT_CENTER, tick(value), font.clone(), weak);
    }
    for value in ticks(axes.x) {
        let x = axes.at([value, 1.0]).x;
        painter.vline(x, rect.y_range(), Stroke::new(0.5, weak.gamma_multiply(0.5)));
        painter.text(pos2(x, rect.bottom() + 3.0), Align2::CENTER_TOP, tick(value), font.clone(), weak);
    }
    if let Some(goal) = goals {
        let y = axes.at([1.0, goal]).y;
        painter.extend(Shape::dashed_line(
            &[pos2(rect.left(), y), pos2(rect.right(), y)],
            Stroke::new(1.0, weak),
            4.0,
            4.0,
        ));
    }
    let inside = painter.with_clip_rect(rect.expand(3.0));
    for course in curves.before.iter().flatten() {
        line(&inside, &axes, &course.expected, Stroke::new(1.0, weak.gamma_multiply(0.6)));
    }
    for (side, course) in curves.now.iter().enumerate() {
        let colour = side_colour(side, dark);
        line(&inside, &axes, &course.expected, Stroke::new(2.0, colour));
        for &point in &course.expected {
            inside.circle_filled(axes.at(point), 2.5, colour);
        }
        for &point in &course.measured {
            inside.circle_stroke(axes.at(point), 4.0, Stroke::new(1.5, colour));
        }
        let label = course.method.to_string();
        let at = rect.right_top() + vec2(-6.0, 3.0 + 13.0 * side as f32);
        inside.text(at, Align2::RIGHT_TOP, label, font.clone(), colour);
    }
    response.on_hover_text(
        "Expected error as the method itself predicts it, after each round; grey: runs before. Rings: error against the truth, \
         where one was found or read. The dashed line is the error at which refining ends.",
    );
}

fn line(painter: &egui::Painter, axes: &Axes, points: &[[f64; 2]], stroke: Stroke) {
    if points.len() > 1 {
        painter.add(Shape::line(points.iter().map(|&point| axes.at(point)).collect(), stroke));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_are_round_and_within() {
        assert_eq!(ticks([-2.0, -1.0]), [0.01, 0.02, 0.05, 0.1]);
        assert_eq!(ticks([-3.0, 0.5]), [0.001, 0.01, 0.1, 1.0]);
    }
}
