//! A log-log plot as an SVG that stands by itself: white ground, its own style, readable where documents show it.

use super::{Answer, Series};
use std::fmt::Write;

const WIDTH: f64 = 720.0;
const LEFT: f64 = 70.0;
const RIGHT: f64 = 20.0;
const TOP: f64 = 40.0;
const HEIGHT: f64 = 330.0;
const LEGEND_ROW: f64 = 20.0;
/// Told apart by those who see colours otherwise too (Okabe and Ito, "Color Universal Design", 2008).
const COLOURS: [&str; 8] =
    ["#0072b2", "#d55e00", "#009e73", "#cc79a7", "#b8860b", "#56b4e9", "#000000", "#7f7f7f"];
const STYLE: &str = "text{font:13px sans-serif;fill:#222}.title{font-size:15px;font-weight:bold}\
    .grid{stroke:#ddd}.axis{stroke:#444}.curve{fill:none;stroke-width:2}";

/// The plot, with a legend that tells each series' exponent.
pub(super) fn draw(answer: &Answer) -> String {
    let all = || answer.series.iter().flat_map(|s| &s.points);
    let (Some(x), Some(y)) = (Axis::at(all().map(|p| p[0])), Axis::around(all().map(|p| p[1]))) else {
        return String::from(r#"<svg xmlns="http://www.w3.org/2000/svg"/>"#);
    };
    let at =
        |p: &[f64; 2]| [LEFT + x.place(p[0]) * (WIDTH - LEFT - RIGHT), TOP + (1.0 - y.place(p[1])) * HEIGHT];
    let mut body = String::new();
    grid(&mut body, answer, &x, &y);
    for (series, colour) in answer.series.iter().zip(COLOURS.iter().cycle()) {
        let points: Vec<[f64; 2]> = series.points.iter().map(at).collect();
        let path: Vec<String> = points.iter().map(|p| format!("{:.1},{:.1}", p[0], p[1])).collect();
        add(
            &mut body,
            format_args!(r#"<polyline class="curve" stroke="{colour}" points="{}"/>"#, path.join(" ")),
        );
        for [x, y] in points {
            add(&mut body, format_args!(r#"<circle cx="{x:.1}" cy="{y:.1}" r="4" fill="{colour}"/>"#));
        }
    }
    let bottom = legend(&mut body, answer);
    format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {WIDTH} {bottom}\" width=\"{WIDTH}\" height=\"{bottom}\" \
         role=\"img\" aria-label=\"{title}\"><style>{STYLE}</style><rect width=\"100%\" height=\"100%\" fill=\"#fff\"/>\
         {body}</svg>\n",
        title = escape(answer.title)
    )
}

fn grid(body: &mut String, answer: &Answer, x: &Axis, y: &Axis) {
    let (right, bottom) = (WIDTH - RIGHT, TOP + HEIGHT);
    for (value, label) in x.ticks() {
        let at = LEFT + x.place(value) * (right - LEFT);
        add(body, format_args!(r#"<line class="grid" x1="{at:.1}" y1="{TOP}" x2="{at:.1}" y2="{bottom}"/>"#));
        text(body, "", at, bottom + 18.0, "middle", &label);
    }
    for (value, label) in y.ticks() {
        let at = TOP + (1.0 - y.place(value)) * HEIGHT;
        add(body, format_args!(r#"<line class="grid" x1="{LEFT}" y1="{at:.1}" x2="{right}" y2="{at:.1}"/>"#));
        text(body, "", LEFT - 6.0, at + 4.5, "end", &label);
    }
    add(body, format_args!(r#"<path class="axis" fill="none" d="M{LEFT} {TOP}V{bottom}H{right}"/>"#));
    text(body, "title", WIDTH / 2.0, 24.0, "middle", answer.title);
    text(body, "", (LEFT + right) / 2.0, bottom + 38.0, "middle", answer.x_title);
    let middle = TOP + HEIGHT / 2.0;
    add(body, format_args!(r#"<g transform="translate(16 {middle}) rotate(-90)">"#));
    text(body, "", 0.0, 0.0, "middle", answer.y_title);
    body.push_str("</g>");
}

/// Two columns below the plot; gives the height of the whole.
fn legend(body: &mut String, answer: &Answer) -> f64 {
    let first = TOP + HEIGHT + 66.0;
    let column = (WIDTH - LEFT) / 2.0;
    for (i, (series, colour)) in answer.series.iter().zip(COLOURS.iter().cycle()).enumerate() {
        let (x, y) = (LEFT + (i % 2) as f64 * column, first + (i / 2) as f64 * LEGEND_ROW);
        add(body, format_args!(r#"<circle cx="{x}" cy="{}" r="4" fill="{colour}"/>"#, y - 4.5));
        text(body, "", x + 12.0, y, "start", &name(series));
    }
    first + answer.series.len().div_ceil(2) as f64 * LEGEND_ROW
}

fn name(series: &Series) -> String {
    let exponent = series.exponent().map_or(String::new(), |e| format!(", exponent {e:.2}"));
    format!("{}{exponent}", series.name)
}

/// A logarithmic axis.
struct Axis {
    from: f64,
    to: f64,
    /// Values that are labelled; round numbers where there are none.
    labelled: Vec<f64>,
}

/// More different values than this are not labelled one by one.
const MOST_LABELS: usize = 10;

impl Axis {
    /// From and to the round numbers around all values; `None` where there is none above 0.
    fn around(values: impl Iterator<Item = f64>) -> Option<Self> {
        let (mut least, mut most) = (f64::INFINITY, 0.0f64);
        for value in values.filter(|v| *v > 0.0 && v.is_finite()) {
            (least, most) = (least.min(value), most.max(value));
        }
        (most > 0.0).then(|| {
            let from = steps().rev().find(|s| *s <= least * 1.000_001).unwrap_or(least);
            let to = steps().find(|s| *s >= most * 0.999_999 && *s > from).unwrap_or(most);
            Self { from, to, labelled: Vec::new() }
        })
    }

    /// A little more than all values, with a label at each where they are few.
    fn at(values: impl Iterator<Item = f64>) -> Option<Self> {
        let mut values: Vec<f64> = values.filter(|v| *v > 0.0 && v.is_finite()).collect();
        values.sort_by(f64::total_cmp);
        values.dedup();
        let (from, to) = (values.first()? / 1.2, values.last()? * 1.2);
        let labelled = if values.len() > MOST_LABELS { Vec::new() } else { values };
        Some(Self { from, to, labelled })
    }

    /// From 0 at the start to 1 at the end.
    fn place(&self, value: f64) -> f64 {
        (value / self.from).ln() / (self.to / self.from).ln()
    }

    /// What is to be labelled, or round numbers within: 1, 2, 5 where there is room, otherwise powers of ten.
    fn ticks(&self) -> Vec<(f64, String)> {
        let (from, to) = (self.from * 0.999, self.to * 1.001);
        let sparse = to / from > 1000.0;
        let round = |s: &f64| (from..=to).contains(s) && (!sparse || s.log10().fract().abs() < 1e-9);
        let values =
            if self.labelled.is_empty() { steps().filter(round).collect() } else { self.labelled.clone() };
        values.into_iter().map(|s| (s, label(s))).collect()
    }
}

/// 1, 2, 5 times powers of ten.
fn steps() -> impl DoubleEndedIterator<Item = f64> {
    (-6..=9).flat_map(|decade| [1.0, 2.0, 5.0].map(|digit| digit * 10f64.powi(decade)))
}

fn label(value: f64) -> String {
    match value {
        1e6.. => format!("{} M", value / 1e6),
        1e4.. => format!("{} k", value / 1e3),
        _ => format!("{}", (value * 1e6).round() / 1e6),
    }
}

fn text(body: &mut String, class: &str, x: f64, y: f64, anchor: &str, text: &str) {
    let text = escape(text);
    add(
        body,
        format_args!(r#"<text class="{class}" x="{x:.1}" y="{y:.1}" text-anchor="{anchor}">{text}</text>"#),
    );
}

fn add(body: &mut String, element: std::fmt::Arguments<'_>) {
    // Writing to a string cannot fail.
    let _ = body.write_fmt(element);
}

fn escape(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn answer(name: &str, points: Vec<[f64; 2]>) -> Answer {
        let series = vec![Series { name: name.into(), points }];
        Answer { name: "n", title: "t", x_title: "x", y_title: "y", series }
    }

    #[test]
    fn every_mark_is_inside_and_every_name_is_there() {
        let svg = draw(&answer("a < b", vec![[10_000.0, 0.003], [2e7, 450.0]]));
        assert!(svg.contains("a &lt; b, exponent 1.5"), "{svg}");
        assert!(!svg.contains("NaN") && !svg.contains("inf"));
        let centres: Vec<f64> =
            svg.split("cx=\"").skip(1).map(|rest| rest.split('"').next().unwrap().parse().unwrap()).collect();
        assert_eq!(centres.len(), 3, "two marks and one in the legend");
        assert!(centres.iter().all(|x| (LEFT..=WIDTH - RIGHT).contains(x)), "{centres:?}");
    }

    #[test]
    fn ticks_are_round_and_within() {
        let labels: Vec<String> =
            Axis::around([3.0, 40.0].into_iter()).unwrap().ticks().into_iter().map(|t| t.1).collect();
        assert_eq!(labels, ["2", "5", "10", "20", "50"]);
        let wide: Vec<String> =
            Axis::around([12_000.0, 2e7].into_iter()).unwrap().ticks().into_iter().map(|t| t.1).collect();
        assert_eq!(wide, ["10 k", "100 k", "1 M", "10 M"]);
        let few: Vec<String> =
            Axis::at([512.0, 128.0, 512.0].into_iter()).unwrap().ticks().into_iter().map(|t| t.1).collect();
        assert_eq!(few, ["128", "512"]);
    }

    #[test]
    fn nothing_to_draw_is_an_empty_drawing() {
        assert!(draw(&answer("a", Vec::new())).ends_with("/>"));
    }
}
