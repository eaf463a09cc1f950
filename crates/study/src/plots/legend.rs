//! The legend, below the plot so that it covers no data.

use super::chart::{Chart, Mark, WIDTH};
use crate::svg::{Anchor, Svg};

const ROW: f64 = 22.0;
const MARGIN: f64 = 10.0;
/// Room for the sample of line and marker before each name.
const SAMPLE: f64 = 40.0;

/// About how wide a text of 13 units is. System fonts differ; this is a wide one's.
pub(super) fn text_width(text: &str) -> f64 {
    7.4 * text.chars().count() as f64
}

/// An arrow head a marker's width beyond `at`.
pub(super) fn arrow(at: [f64; 2], towards: [f64; 2]) -> [[f64; 2]; 3] {
    let tip = [at[0] + 11.0 * towards[0], at[1] + 11.0 * towards[1]];
    let wing = |side: f64| {
        [
            tip[0] - 5.0 * towards[0] + 5.0 * side * towards[1],
            tip[1] - 5.0 * towards[1] + 5.0 * side * towards[0],
        ]
    };
    [wing(1.0), tip, wing(-1.0)]
}

/// Draws an entry for each series and what else needs a word; gives the height of the whole drawing.
pub(super) fn draw(svg: &mut Svg, chart: &Chart<'_>, clamped: bool, top: f64) -> f64 {
    let mut names: Vec<&str> = chart.series.iter().map(|s| s.name.as_str()).collect();
    names.extend(chart.band.iter().map(|b| b.1));
    names.extend(chart.diagonal.then_some("equal"));
    let widest = names.iter().map(|n| text_width(n)).fold(0.0, f64::max) + SAMPLE + 4.0;
    let columns = ((WIDTH - MARGIN) / widest).floor().clamp(1.0, 3.0) as usize;
    let column_width = (WIDTH - MARGIN) / columns as f64;
    let room = ((column_width - SAMPLE) / text_width("x")).floor() as usize;

    for (index, name) in names.iter().enumerate() {
        let x = MARGIN + column_width * (index % columns) as f64;
        let y = top + ROW * (index / columns) as f64;
        let (from, to) = ([x, y - 4.5], [x + 30.0, y - 4.5]);
        if let Some(series) = chart.series.get(index) {
            svg.group(&series.style.class(), None);
            svg.polyline("curve", &[from, to], series.style.dash());
            series.style.mark(svg, [x + 15.0, y - 4.5], Mark::SIZE);
            svg.close();
        } else if index == chart.series.len() && chart.band.is_some() {
            svg.rectangle("band", [x, y - 11.0], [30.0, 13.0]);
        } else {
            svg.line("diagonal", from, to);
        }
        svg.text("legend", [x + SAMPLE - 4.0, y], Anchor::Start, &shortened(name, room));
    }
    let mut bottom = top + ROW * names.len().div_ceil(columns) as f64;
    if clamped {
        svg.polyline("edge", &arrow([MARGIN + 15.0, bottom - 12.0], [0.0, 1.0]), "");
        let note = "at the edge: smaller than the axis shows, or 0";
        svg.text("legend", [MARGIN + SAMPLE - 4.0, bottom], Anchor::Start, note);
        bottom += ROW;
    }
    bottom - ROW / 2.0
}

fn shortened(name: &str, room: usize) -> String {
    if name.chars().count() <= room {
        return name.into();
    }
    name.chars().take(room.saturating_sub(1)).chain(['…']).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn long_names_are_cut_and_short_ones_are_not() {
        assert_eq!(shortened("rays", 4), "rays");
        assert_eq!(shortened("rays-stratified", 6), "rays-…");
    }
}
