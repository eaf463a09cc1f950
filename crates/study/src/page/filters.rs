//! How values are written in the page. A value that is missing is a dash.

use crate::plots::figures;
use minijinja::{Environment, Value};

const MISSING: &str = "–";

pub(super) fn add(environment: &mut Environment<'_>) {
    environment.add_filter("num", |value: &Value| with(value, figures));
    environment.add_filter("signed", |value: &Value| {
        with(value, |v| if v > 0.0 { format!("+{}", figures(v)) } else { figures(v) })
    });
    environment.add_filter("percent", |value: &Value| with(value, |v| figures(100.0 * v)));
    environment.add_filter("count", |value: &Value| {
        with(value, |v| if v.fract() == 0.0 { whole(v) } else { figures(v) })
    });
    environment.add_filter("whole", |value: &Value| with(value, whole));
}

fn with(value: &Value, write: impl Fn(f64) -> String) -> String {
    match f64::try_from(value.clone()) {
        // A real minus sign is as wide as a plus.
        Ok(v) if v.is_finite() => write(v).replace('-', "−"),
        _ => MISSING.into(),
    }
}

/// A whole number in groups of three digits, with thin spaces that do not break.
fn whole(value: f64) -> String {
    let digits = format!("{:.0}", value.abs());
    let mut text = String::from(if value < 0.0 { "-" } else { "" });
    for (index, digit) in digits.chars().enumerate() {
        if index > 0 && (digits.len() - index).is_multiple_of(3) {
            text.push('\u{202f}');
        }
        text.push(digit);
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn whole_numbers_are_grouped() {
        let shown = [0.0, 999.0, 1000.0, 1_234_567.0, -4096.0].map(whole);
        assert_eq!(shown, ["0", "999", "1\u{202f}000", "1\u{202f}234\u{202f}567", "-4\u{202f}096"]);
    }

    #[test]
    fn values_are_written_by_their_kind_and_missing_ones_as_a_dash() {
        let mut environment = Environment::new();
        add(&mut environment);
        let show = |text: &str| {
            let values =
                minijinja::context! { a => -0.012_345, b => Option::<f64>::None, c => f64::NAN, d => 7 };
            environment.render_str(text, values).unwrap()
        };
        assert_eq!(show("{{ a|num }} {{ b|num }} {{ c|percent }} {{ d|signed }}"), "−0.0123 – – +7.00");
        assert_eq!(show("{{ a|percent }} {{ d|whole }}"), "−1.23 7");
        assert_eq!(show("{{ a|count }} {{ d|count }}"), "−0.0123 7");
    }
}
