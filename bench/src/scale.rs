//! How cost grows: with triangles, octree resolution, AO distance and rays per point.

mod ask;
mod fit;
mod plot;
mod tessellate;

pub use ask::{ScaleOptions, distance, rays, resolution, triangles};
pub use fit::exponent;
pub use tessellate::tessellated;

use serde_json::{Value, json};

/// A cost against what it may depend on, on one scene.
#[derive(Clone, Debug, PartialEq)]
pub struct Series {
    /// What costs, and on which scene.
    pub name: String,
    /// What it is plotted against, ascending, and the cost.
    pub points: Vec<[f64; 2]>,
}

/// A question with what was measured.
#[derive(Clone, Debug, PartialEq)]
pub struct Answer {
    /// Short name, of the file of its plot.
    pub name: &'static str,
    /// The question in words.
    pub title: &'static str,
    /// What costs are plotted against.
    pub x_title: &'static str,
    /// What the costs are, with their unit.
    pub y_title: &'static str,
    /// The costs.
    pub series: Vec<Series>,
}

impl Series {
    fn new(name: impl Into<String>) -> Self {
        Self { name: name.into(), points: Vec::new() }
    }

    /// Power of x that the cost grows with; `None` for fewer than two points.
    pub fn exponent(&self) -> Option<f64> {
        exponent(&self.points)
    }
}

impl Answer {
    /// A line for each series: its costs and its exponent.
    pub fn table(&self) -> String {
        let line = |s: &Series| {
            let costs = s.points.iter().map(|p| format!("{}: {}", short(p[0]), short(p[1])));
            let exponent = s.exponent().map_or("-".into(), |e| format!("{e:.2}"));
            format!("  {}, exponent {exponent}\n    {}\n", s.name, costs.collect::<Vec<_>>().join("  "))
        };
        format!(
            "{}: {} by {}\n{}",
            self.title,
            self.y_title,
            self.x_title,
            self.series.iter().map(line).collect::<String>()
        )
    }

    /// For programs.
    pub fn json(&self) -> Value {
        let series = |s: &Series| json!({ "name": s.name, "points": s.points, "exponent": s.exponent() });
        json!({
            "name": self.name,
            "title": self.title,
            "x": self.x_title,
            "y": self.y_title,
            "series": self.series.iter().map(series).collect::<Vec<_>>(),
        })
    }

    /// A drawing that stands by itself.
    pub fn svg(&self) -> String {
        plot::draw(self)
    }
}

/// A number to four digits, without a tail of zeros.
fn short(value: f64) -> String {
    if value == 0.0 || !value.is_finite() {
        return format!("{value}");
    }
    let decimals = (3 - value.abs().log10().floor() as i32).clamp(0, 9);
    let text = format!("{value:.*}", decimals as usize);
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').into() } else { text }
}
