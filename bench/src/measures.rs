//! Measures with what they must reach and what they aim at, and the plain word on each.

use serde_json::{Value, json};
use std::fmt;

/// Where a measure must lie.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Bound {
    /// This or more.
    AtLeast(f64),
    /// This or less.
    AtMost(f64),
}

impl Bound {
    fn is_met(self, found: f64) -> bool {
        match self {
            Self::AtLeast(bound) => found >= bound,
            Self::AtMost(bound) => found <= bound,
        }
    }
}

impl fmt::Display for Bound {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::AtLeast(bound) => write!(f, ">= {bound}"),
            Self::AtMost(bound) => write!(f, "<= {bound}"),
        }
    }
}

/// One row.
#[derive(Clone, Debug, PartialEq)]
pub struct Measure {
    /// What is measured, with its unit.
    pub what: String,
    /// On which scene.
    pub scene: String,
    /// The number; `None` where it could not be measured.
    pub found: Option<f64>,
    /// Where it must lie; `None` for what is only reported.
    pub must: Option<Bound>,
    /// Where it should lie.
    pub aim: Option<Bound>,
    /// The numbers behind it.
    pub detail: String,
}

impl Measure {
    /// `MISS` where it is not what it must be, and whether the aim is met.
    pub fn verdict(&self) -> &'static str {
        let Some(found) = self.found else { return "NOT MEASURED" };
        let met = |bound: Option<Bound>| bound.map(|b| b.is_met(found));
        match (met(self.must), met(self.aim)) {
            (Some(false), _) => "MISS",
            (_, Some(true)) => "aim met",
            (Some(true), _) => "must met",
            (None, Some(false)) => "aim missed",
            (None, None) => "reported",
        }
    }

    /// For programs.
    pub fn json(&self) -> Value {
        let bound = |b: Option<Bound>| b.map(|b| b.to_string());
        json!({
            "what": self.what, "scene": self.scene, "found": self.found, "must": bound(self.must),
            "aim": bound(self.aim), "verdict": self.verdict(), "detail": self.detail,
        })
    }
}

/// All rows, aligned.
pub fn table(measures: &[Measure]) -> String {
    let bound = |b: Option<Bound>| b.map_or("-".into(), |b| b.to_string());
    let mut rows = vec![["what", "scene", "found", "must", "aim", "", "from"].map(String::from)];
    rows.extend(measures.iter().map(|m| {
        let found = m.found.map_or("-".into(), |found| format!("{found:.2}"));
        let verdict = m.verdict().to_owned();
        [m.what.clone(), m.scene.clone(), found, bound(m.must), bound(m.aim), verdict, m.detail.clone()]
    }));
    let width = |column: usize| rows.iter().map(|row| row[column].len()).max().unwrap_or(0);
    let widths: [usize; 7] = std::array::from_fn(width);
    let line = |row: &[String; 7]| {
        let cells = row.iter().zip(widths).enumerate().map(|(column, (cell, width))| match column {
            2..=4 => format!("{cell:>width$}"),
            _ => format!("{cell:width$}"),
        });
        cells.collect::<Vec<_>>().join("  ").trim_end().to_owned() + "\n"
    };
    rows.iter().map(line).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn measure(found: Option<f64>, must: Option<Bound>) -> Measure {
        let aim = Some(Bound::AtLeast(3.0));
        Measure { what: "w".into(), scene: "s".into(), found, must, aim, detail: String::new() }
    }

    #[test]
    fn a_miss_is_called_a_miss() {
        let must = Some(Bound::AtLeast(1.5));
        let verdicts = [1.49, 1.5, 3.0].map(|found| measure(Some(found), must).verdict());
        assert_eq!(verdicts, ["MISS", "must met", "aim met"]);
        assert_eq!(measure(Some(1.0), None).verdict(), "aim missed");
        assert_eq!(measure(None, must).verdict(), "NOT MEASURED");
        // What is no number is above and below nothing.
        assert_eq!(measure(Some(f64::NAN), must).verdict(), "MISS");
        assert!(Bound::AtMost(2.0).is_met(2.0) && !Bound::AtMost(2.0).is_met(2.01));
    }

    #[test]
    fn columns_line_up() {
        let table = table(&[measure(Some(10.0), None), measure(None, Some(Bound::AtMost(1.0)))]);
        let places: Vec<_> = table.lines().map(|line| line.find(['a', '>']).unwrap_or(0)).collect();
        assert_eq!(table.lines().count(), 3);
        assert!(places.iter().all(|&p| p > 0), "{table}");
    }
}
