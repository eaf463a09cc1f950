//! How each method looks in every plot: colour, dash and marker together, so that none of them is needed alone.
//!
//! A method keeps its look whatever others take part. Colours are the classes `m0` to `m11` of the style sheet, chosen after
//! the palette that Okabe and Ito, "Color Universal Design", 2008, found safe with colour blindness.

use crate::svg::Svg;

/// Methods with a place of their own; others take the places behind them in the order they come.
const KNOWN: [&str; 9] = [
    "rays",
    "rays-stratified",
    "rays-random",
    "rays-filtered",
    "rays-denoised",
    "cones",
    "paper",
    "paper-tuned",
    "hybrid",
];

/// Colours in the style sheet.
const COLOURS: usize = 12;

const DASHES: [&str; 5] = ["", "7 3", "2 3", "9 3 2 3", "12 4"];

/// Marker outlines about the origin, half a marker being 1; open ones are crosses of lines.
const MARKERS: [Marker; 9] = [
    Marker::Disc,
    Marker::Filled(&[[-0.9, -0.9], [0.9, -0.9], [0.9, 0.9], [-0.9, 0.9]]),
    Marker::Filled(&[[0.0, -1.3], [1.1, 0.0], [0.0, 1.3], [-1.1, 0.0]]),
    Marker::Filled(&[[0.0, -1.2], [1.1, 0.8], [-1.1, 0.8]]),
    Marker::Filled(&[[0.0, 1.2], [1.1, -0.8], [-1.1, -0.8]]),
    Marker::Lines(&[([-1.0, -1.0], [1.0, 1.0]), ([-1.0, 1.0], [1.0, -1.0])]),
    Marker::Lines(&[([-1.25, 0.0], [1.25, 0.0]), ([0.0, -1.25], [0.0, 1.25])]),
    Marker::Filled(&[[0.0, -1.2], [1.14, -0.37], [0.7, 0.97], [-0.7, 0.97], [-1.14, -0.37]]),
    Marker::Filled(&[
        [0.0, -1.5],
        [0.4, -0.5],
        [1.4, -0.5],
        [0.6, 0.2],
        [0.9, 1.3],
        [0.0, 0.6],
        [-0.9, 1.3],
        [-0.6, 0.2],
        [-1.4, -0.5],
        [-0.4, -0.5],
    ]),
];

#[derive(Clone, Copy)]
enum Marker {
    Disc,
    Filled(&'static [[f64; 2]]),
    Lines(&'static [([f64; 2], [f64; 2])]),
}

/// The look of one method.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Style {
    place: usize,
}

impl Style {
    /// The look of `name` among all methods of a plot or page, in their order.
    pub(crate) fn of<'a>(name: &str, all: impl IntoIterator<Item = &'a str>) -> Self {
        let known = |name: &str| KNOWN.iter().position(|k| *k == name);
        let place = known(name).unwrap_or_else(|| {
            let mut others: Vec<&str> = Vec::new();
            for other in all {
                if known(other).is_none() && !others.contains(&other) {
                    others.push(other);
                }
            }
            KNOWN.len() + others.iter().position(|o| *o == name).unwrap_or(others.len())
        });
        Self { place }
    }

    /// Class of the style sheet that sets the colour.
    pub(crate) fn class(self) -> String {
        format!("m{}", self.place % COLOURS)
    }

    /// As in `stroke-dasharray`; empty for a whole line.
    pub(super) fn dash(self) -> &'static str {
        DASHES[self.place % DASHES.len()]
    }

    /// Draws the marker; `size` is half its width.
    pub(super) fn mark(self, svg: &mut Svg, at: [f64; 2], size: f64) {
        let place = |p: &[f64; 2]| [at[0] + size * p[0], at[1] + size * p[1]];
        match MARKERS[self.place % MARKERS.len()] {
            Marker::Disc => svg.circle("marker", at, size),
            Marker::Filled(outline) => {
                svg.polygon("marker", &outline.iter().map(place).collect::<Vec<_>>());
            }
            Marker::Lines(lines) => {
                for (from, to) in lines {
                    svg.line("stroke", place(from), place(to));
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_method_keeps_its_look_whoever_takes_part() {
        assert_eq!(Style::of("cones", ["cones"]), Style::of("cones", ["a", "rays", "cones"]));
        assert_ne!(Style::of("a", ["a", "b"]), Style::of("b", ["a", "b"]));
    }

    #[test]
    fn no_two_of_many_methods_look_the_same() {
        let names: Vec<String> =
            KNOWN.iter().map(ToString::to_string).chain((0..9).map(|i| format!("new-{i}"))).collect();
        let all = || names.iter().map(String::as_str);
        let look = |name: &String| {
            let style = Style::of(name, all());
            let mut svg = Svg::new();
            style.mark(&mut svg, [0.0, 0.0], 4.0);
            (style.class(), style.dash(), svg.finish(1.0, 1.0, ""))
        };
        let looks: Vec<_> = names.iter().map(look).collect();
        for (i, a) in looks.iter().enumerate() {
            assert!(looks[..i].iter().all(|b| a != b), "{}", names[i]);
        }
        let markers_of_known = looks[..9].iter().map(|l| &l.2).collect::<std::collections::BTreeSet<_>>();
        assert_eq!(markers_of_known.len(), 9, "markers alone tell the known ones apart");
    }
}
