//! A small writer of inline SVG: shapes and text with classes; colours are the style sheet's matter.

use std::fmt::Write;

/// A drawing under way. Coordinates are in units of its view box, y downwards.
pub(crate) struct Svg {
    body: String,
    open: usize,
}

/// Where a text hangs on its point.
#[derive(Clone, Copy)]
pub(crate) enum Anchor {
    Start,
    Middle,
    End,
}

impl Svg {
    pub(crate) fn new() -> Self {
        Self { body: String::new(), open: 0 }
    }

    /// Starts a group; what is drawn until [`Svg::close`] belongs to it. A title is shown where a pointer rests.
    pub(crate) fn group(&mut self, class: &str, title: Option<&str>) {
        self.add(format_args!(r#"<g class="{}">"#, escape(class)));
        self.open += 1;
        if let Some(title) = title {
            self.add(format_args!("<title>{}</title>", escape(title)));
        }
    }

    /// Ends the innermost group.
    pub(crate) fn close(&mut self) {
        if self.open > 0 {
            self.open -= 1;
            self.body.push_str("</g>");
        }
    }

    pub(crate) fn line(&mut self, class: &str, from: [f64; 2], to: [f64; 2]) {
        let [x1, y1, x2, y2] = [from[0], from[1], to[0], to[1]].map(number);
        self.add(format_args!(
            r#"<line class="{}" x1="{x1}" y1="{y1}" x2="{x2}" y2="{y2}"/>"#,
            escape(class)
        ));
    }

    pub(crate) fn rectangle(&mut self, class: &str, corner: [f64; 2], size: [f64; 2]) {
        let [x, y, width, height] = [corner[0], corner[1], size[0], size[1]].map(number);
        self.add(format_args!(
            r#"<rect class="{}" x="{x}" y="{y}" width="{width}" height="{height}"/>"#,
            escape(class)
        ));
    }

    /// A line through points; nothing for fewer than two. `dash` is as in `stroke-dasharray`, empty for a whole line.
    pub(crate) fn polyline(&mut self, class: &str, points: &[[f64; 2]], dash: &str) {
        if points.len() > 1 {
            let dash = if dash.is_empty() { String::new() } else { format!(r#" stroke-dasharray="{dash}""#) };
            let places = places(points);
            self.add(format_args!(r#"<polyline class="{}" points="{places}"{dash}/>"#, escape(class)));
        }
    }

    /// An area; nothing for fewer than three points.
    pub(crate) fn polygon(&mut self, class: &str, points: &[[f64; 2]]) {
        if points.len() > 2 {
            let places = places(points);
            self.add(format_args!(r#"<polygon class="{}" points="{places}"/>"#, escape(class)));
        }
    }

    pub(crate) fn circle(&mut self, class: &str, centre: [f64; 2], radius: f64) {
        let [x, y, r] = [centre[0], centre[1], radius].map(number);
        self.add(format_args!(r#"<circle class="{}" cx="{x}" cy="{y}" r="{r}"/>"#, escape(class)));
    }

    pub(crate) fn text(&mut self, class: &str, at: [f64; 2], anchor: Anchor, text: &str) {
        let place = format!(r#"x="{}" y="{}""#, number(at[0]), number(at[1]));
        self.any_text(class, &place, anchor, text);
    }

    /// Text that reads upwards.
    pub(crate) fn text_upwards(&mut self, class: &str, at: [f64; 2], anchor: Anchor, text: &str) {
        let place = format!(r#"transform="translate({} {}) rotate(-90)""#, number(at[0]), number(at[1]));
        self.any_text(class, &place, anchor, text);
    }

    /// The finished plot, as wide as its place allows; `label` is for those who do not see it.
    pub(crate) fn finish(self, width: f64, height: f64, label: &str) -> String {
        self.finish_as("plot", width, height, label)
    }

    /// The finished drawing of a class of the style sheet.
    pub(crate) fn finish_as(mut self, class: &str, width: f64, height: f64, label: &str) -> String {
        while self.open > 0 {
            self.close();
        }
        format!(
            r#"<svg class="{}" viewBox="0 0 {} {}" role="img" aria-label="{}">{}</svg>"#,
            escape(class),
            number(width),
            number(height),
            escape(label),
            self.body
        )
    }

    fn any_text(&mut self, class: &str, place: &str, anchor: Anchor, text: &str) {
        let anchor = match anchor {
            Anchor::Start => "start",
            Anchor::Middle => "middle",
            Anchor::End => "end",
        };
        let (class, text) = (escape(class), escape(text));
        self.add(format_args!(r#"<text class="{class}" {place} text-anchor="{anchor}">{text}</text>"#));
    }

    fn add(&mut self, element: std::fmt::Arguments<'_>) {
        // Writing to a string cannot fail.
        let _ = self.body.write_fmt(element);
    }
}

/// Text fit for XML, between tags and within quotes.
pub(crate) fn escape(text: &str) -> String {
    let mut safe = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => safe.push_str("&amp;"),
            '<' => safe.push_str("&lt;"),
            '>' => safe.push_str("&gt;"),
            '"' => safe.push_str("&quot;"),
            '\'' => safe.push_str("&#39;"),
            // XML has no place for other control characters, not even escaped.
            c if c.is_control() && !matches!(c, '\n' | '\t') => safe.push('\u{fffd}'),
            '\u{fffe}' | '\u{ffff}' => safe.push('\u{fffd}'),
            c => safe.push(c),
        }
    }
    safe
}

/// A hundredth of a unit is finer than any screen; what is no number becomes 0, as it would break the whole drawing.
fn number(value: f64) -> String {
    let rounded = (value * 100.0).round() / 100.0;
    if rounded.is_finite() { format!("{}", rounded + 0.0) } else { "0".into() }
}

fn places(points: &[[f64; 2]]) -> String {
    points.iter().map(|p| format!("{},{}", number(p[0]), number(p[1]))).collect::<Vec<_>>().join(" ")
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn any_text_and_any_number_stay_well_formed(
            text in any::<String>(), x in any::<f64>(), y in any::<f64>(), groups in 0usize..4,
        ) {
            let mut svg = Svg::new();
            for _ in 0..groups {
                svg.group(&text, Some(&text));
            }
            svg.text("t", [x, y], Anchor::End, &text);
            svg.text_upwards(&text, [y, x], Anchor::Middle, &text);
            svg.polyline("p", &[[x, y], [y, x]], "2 3");
            svg.close();
            let whole = svg.finish(x.abs(), 10.0, &text);
            let document = roxmltree::Document::parse(&whole).unwrap();
            prop_assert!(!whole.contains("NaN") && !whole.contains("inf"));
            let shown = document.descendants().find(|n| n.has_tag_name("text")).unwrap();
            prop_assert_eq!(shown.attribute("text-anchor"), Some("end"));
        }
    }

    #[test]
    fn text_is_shown_as_it_was_given_and_raw_text_would_not_be() {
        let text = r#"<b>"R&D"</b> 'x'"#;
        let mut svg = Svg::new();
        svg.text("t", [0.0, 0.0], Anchor::Start, text);
        let whole = svg.finish(1.0, 1.0, "l");
        let document = roxmltree::Document::parse(&whole).unwrap();
        let shown = document.descendants().find(|n| n.has_tag_name("text")).unwrap();
        assert_eq!(shown.text(), Some(text));
        assert!(roxmltree::Document::parse(&whole.replace("&lt;", "<")).is_err(), "the negative control");
    }

    #[test]
    fn numbers_are_short() {
        assert_eq!([1.0, -0.0, 2.345_67, f64::NAN, f64::INFINITY].map(number), ["1", "0", "2.35", "0", "0"]);
    }
}
