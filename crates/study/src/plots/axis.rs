//! Axes: which stretch of numbers is shown, and where its ticks are.

/// Values beyond these are drawn at them; no error or time of a study comes near.
const SMALLEST: f64 = 1e-12;
const LARGEST: f64 = 1e12;

/// A logarithmic axis shows at most this many decades below its largest value: a bias of nearly 0 must not squeeze the rest.
const DECADES: f64 = 6.0;

/// Where there is one: enough for half a marker and an arrow.
const MARGIN: f64 = 0.07;

/// One axis.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Axis {
    /// What it shows, with its unit.
    pub(super) title: String,
    /// Where it is labelled, ascending: the value and its text. The text is empty at finer grid lines.
    pub(super) ticks: Vec<(f64, String)>,
    logarithmic: bool,
    from: f64,
    to: f64,
    /// Share of the axis kept free at its start: for values below it, or for large markers at 0.
    margin: f64,
}

impl Axis {
    /// A logarithmic axis around all values above 0; `None` where there is none.
    pub(super) fn logarithmic(title: &str, values: impl IntoIterator<Item = f64>) -> Option<Self> {
        let values: Vec<f64> = values.into_iter().filter(|v| v.is_finite()).collect();
        let known = || values.iter().filter(|v| **v > 0.0).map(|v| v.clamp(SMALLEST, LARGEST));
        let most = known().reduce(f64::max)?;
        let least = known().fold(most, f64::min).max(most * 10f64.powf(-DECADES));
        let steps = steps_of_decades();
        let mut from = steps.iter().copied().rev().find(|s| *s <= least * 1.000_001)?;
        let to = steps.iter().copied().find(|s| *s * 1.000_001 >= most && *s > from)?;
        if to / from < 3.0 {
            from = steps.iter().copied().rev().find(|s| *s < from).unwrap_or(from);
        }
        let shown = steps.into_iter().filter(|s| (from..=to).contains(s));
        // With few decades there is room for 1, 2, 5; otherwise only powers of ten are labelled.
        let labelled = |s: f64| to / from < 1100.0 || leading_digit(s) == 1;
        let ticks = shown.map(|s| (s, if labelled(s) { plain(s) } else { String::new() })).collect();
        let mut axis = Self { title: title.into(), ticks, logarithmic: true, from, to, margin: 0.0 };
        if values.iter().any(|v| axis.is_below(*v)) {
            axis.margin = MARGIN;
        }
        Some(axis)
    }

    /// A linear axis from 0 to a round number at or above every value.
    pub(super) fn from_zero(title: &str, values: impl IntoIterator<Item = f64>) -> Self {
        let most = values.into_iter().filter(|v| v.is_finite()).fold(0.0, f64::max).clamp(1e-6, LARGEST);
        let steps = steps_of_decades();
        let step = steps.into_iter().find(|s| s * 6.0 >= most).unwrap_or(LARGEST);
        let count = (most / step - 1e-9).ceil().max(1.0);
        let ticks = (0..=count as u32)
            .map(|i| f64::from(i) * step)
            .map(|v| (v, if v == 0.0 { "0".into() } else { plain(v) }))
            .collect();
        Self { title: title.into(), ticks, logarithmic: false, from: 0.0, to: count * step, margin: MARGIN }
    }

    /// The same stretch under another title.
    pub(super) fn titled(&self, title: &str) -> Self {
        Self { title: title.into(), ..self.clone() }
    }

    /// Place of a value along the axis, from 0 at its start to 1 at its end. What is too large is held at the end, what is
    /// too small in the middle of the margin.
    pub(super) fn place(&self, value: f64) -> f64 {
        if self.is_below(value) {
            return self.margin / 2.0;
        }
        let share = if self.logarithmic {
            let value = value.clamp(self.from, self.to);
            (value / self.from).ln() / (self.to / self.from).ln()
        } else {
            (value - self.from) / (self.to - self.from)
        };
        self.margin + (1.0 - self.margin) * share.clamp(0.0, 1.0)
    }

    /// True for a value too small for the axis, such as 0 on a logarithmic one.
    pub(super) fn is_below(&self, value: f64) -> bool {
        value < self.from * 0.999_999
    }
}

/// 1, 2, 5 times every power of ten that can be shown.
fn steps_of_decades() -> Vec<f64> {
    // Parsed, not multiplied: 0.3 and the like come out as they are written.
    let decades = -13i32..=12;
    decades.flat_map(|d| [1, 2, 5].map(|k| format!("{k}e{d}").parse().unwrap_or(1.0))).collect()
}

fn leading_digit(step: f64) -> u32 {
    let digits = format!("{step:e}");
    digits.chars().next().and_then(|c| c.to_digit(10)).unwrap_or(1)
}

/// A tick's text: `0.05`, `200`, `1e-6`.
fn plain(value: f64) -> String {
    if !(1e-3..1e6).contains(&value) {
        return format!("{value:e}");
    }
    // Multiples of a step carry rounding errors far behind the digits that matter.
    format!("{}", (value * 1e6).round() / 1e6)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn labels(axis: &Axis) -> Vec<&str> {
        axis.ticks.iter().map(|t| t.1.as_str()).filter(|t| !t.is_empty()).collect()
    }

    #[test]
    fn ticks_are_round() {
        let axis = Axis::logarithmic("x", [0.031, 0.4]).unwrap();
        assert_eq!(labels(&axis), ["0.02", "0.05", "0.1", "0.2", "0.5"]);
        let wide = Axis::logarithmic("x", [1e-5, 3.0]).unwrap();
        assert_eq!(labels(&wide), ["1e-5", "1e-4", "0.001", "0.01", "0.1", "1"]);
        assert_eq!(labels(&Axis::from_zero("x", [0.83])), ["0", "0.2", "0.4", "0.6", "0.8", "1"]);
        assert_eq!(labels(&Axis::from_zero("x", [0.3])), ["0", "0.05", "0.1", "0.15", "0.2", "0.25", "0.3"]);
    }

    #[test]
    fn a_decade_is_as_long_as_any_other() {
        let axis = Axis::logarithmic("x", [0.001, 1.0]).unwrap();
        for (value, place) in [(0.001, 0.0), (0.01, 1.0 / 3.0), (0.1, 2.0 / 3.0), (1.0, 1.0)] {
            assert!((axis.place(value) - place).abs() < 1e-12);
        }
        let linear = Axis::from_zero("x", [1.0]);
        let length = |a: f64, b: f64| linear.place(b) - linear.place(a);
        assert!((length(0.0, 0.25) - length(0.75, 1.0)).abs() < 1e-12);
    }

    #[test]
    fn nothing_above_zero_is_no_axis_and_zero_is_below_every_other() {
        assert_eq!(Axis::logarithmic("x", [0.0, f64::NAN, -1.0, f64::INFINITY]), None);
        let axis = Axis::logarithmic("x", [0.0, 1e-30, 0.5]).unwrap();
        assert!(axis.is_below(0.0) && axis.is_below(1e-30) && !axis.is_below(0.5));
        assert_eq!(axis.place(0.0), axis.place(1e-30));
        assert!(0.0 < axis.place(0.0) && axis.place(0.0) < axis.place(axis.ticks[0].0));
    }

    proptest! {
        #[test]
        fn every_value_has_a_place(values in prop::collection::vec(any::<f64>(), 1..9)) {
            let axes = [Axis::logarithmic("x", values.clone()), Some(Axis::from_zero("x", values.clone()))];
            for axis in axes.into_iter().flatten() {
                prop_assert!(axis.ticks.len() >= 2 && axis.ticks.len() < 40);
                prop_assert!(axis.ticks.windows(2).all(|w| w[0].0 < w[1].0));
                for value in values.iter().filter(|v| v.is_finite()) {
                    prop_assert!((0.0..=1.0).contains(&axis.place(*value)));
                }
                for (tick, _) in &axis.ticks {
                    prop_assert!(!axis.is_below(*tick));
                }
            }
        }
    }
}
