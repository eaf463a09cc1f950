//! Every trial as a line of `curves.csv`, for those who draw their own plots.
//!
//! The form is that of Shafranovich, "Common Format and MIME Type for Comma-Separated Values (CSV) Files", RFC 4180, 2005.
//! Numbers are written so that they are read back exactly; a missing one is an empty field.

use crate::{Report, report::TrialReport};

/// The names of the columns, in order.
const HEADER: [&str; 18] = [
    "case",
    "method",
    "effort",
    "label",
    "rays",
    "cones",
    "rmse",
    "mae",
    "bias",
    "relative_bias",
    "p95",
    "flip",
    "expected_rmse",
    "seconds",
    "min_seconds",
    "max_seconds",
    "runs",
    "seconds_with_builds",
];

/// A header line, then one line a trial, in the order of the report.
pub(crate) fn curves(report: &Report) -> String {
    let trials = report.cases.iter().flat_map(|case| case.trials.iter().map(|trial| fields(&case.id, trial)));
    std::iter::once(HEADER.map(String::from)).chain(trials).map(|fields| line(&fields)).collect()
}

fn fields(case: &str, trial: &TrialReport) -> [String; 18] {
    let (quality, timing) = (&trial.quality, &trial.timing);
    [
        case.into(),
        trial.method.clone(),
        trial.effort.to_string(),
        trial.label.clone(),
        number(trial.rays),
        number(trial.cones),
        number(quality.rmse),
        number(quality.mae),
        number(quality.bias),
        number(quality.relative_bias),
        number(quality.p95),
        number(quality.flip),
        trial.expected_rmse.map_or_else(String::new, number),
        number(timing.seconds),
        number(timing.min_seconds),
        number(timing.max_seconds),
        timing.runs.to_string(),
        number(timing.seconds_with_builds),
    ]
}

/// The shortest text that is read back as the same number; nothing for what is no number.
fn number(value: f64) -> String {
    if !value.is_finite() {
        String::new()
    } else if value != 0.0 && !(1e-6..1e15).contains(&value.abs()) {
        format!("{value:e}")
    } else {
        format!("{value}")
    }
}

fn line(fields: &[String]) -> String {
    fields.iter().map(|f| quoted(f)).collect::<Vec<_>>().join(",") + "\r\n"
}

fn quoted(field: &str) -> String {
    if field.contains(['"', ',', '\r', '\n']) {
        format!("\"{}\"", field.replace('"', "\"\""))
    } else {
        field.into()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fixture;
    use proptest::prelude::*;

    /// Reads RFC 4180 character by character: knows nothing of how the text was written.
    fn parse(text: &str) -> Vec<Vec<String>> {
        let (mut records, mut record, mut field) = (Vec::new(), Vec::new(), String::new());
        let mut inside = false;
        let mut rest = text.chars().peekable();
        while let Some(c) = rest.next() {
            match (c, inside) {
                ('"', true) if rest.peek() == Some(&'"') => field.extend(rest.next()),
                ('"', _) => inside = !inside,
                (',', false) => record.push(std::mem::take(&mut field)),
                ('\r', false) if rest.peek() == Some(&'\n') => {
                    rest.next();
                    record.push(std::mem::take(&mut field));
                    records.push(std::mem::take(&mut record));
                }
                _ => field.push(c),
            }
        }
        assert!(record.is_empty() && field.is_empty() && !inside, "every record ends with a line end");
        records
    }

    #[test]
    fn every_trial_is_a_line_with_its_numbers() {
        let report = fixture::report();
        let records = parse(&curves(&report));
        assert_eq!(records[0], HEADER);
        let trials: Vec<(&str, &TrialReport)> =
            report.cases.iter().flat_map(|c| c.trials.iter().map(|t| (c.id.as_str(), t))).collect();
        assert_eq!(records.len(), trials.len() + 1);
        for (record, (case, trial)) in records[1..].iter().zip(trials) {
            let number = |name: &str| {
                let at = HEADER.iter().position(|h| *h == name).unwrap();
                record[at].parse::<f64>().ok()
            };
            assert_eq!((record[0].as_str(), &record[1], &record[3]), (case, &trial.method, &trial.label));
            assert_eq!(number("rmse"), Some(trial.quality.rmse));
            assert_eq!(number("bias"), Some(trial.quality.bias));
            assert_eq!(number("expected_rmse"), trial.expected_rmse);
            assert_eq!(number("seconds"), Some(trial.timing.seconds));
            assert_eq!(number("seconds_with_builds"), Some(trial.timing.seconds_with_builds));
            assert_ne!(number("max_seconds"), number("min_seconds"), "columns must not be mixed up");
        }
    }

    proptest! {
        #[test]
        fn any_text_and_number_comes_back(
            texts in prop::collection::vec("[a\",\r\n é]{0,6}", 1..4), value in any::<f64>(),
        ) {
            let text = line(&texts) + &line(&[number(value)]);
            let records = parse(&text);
            prop_assert_eq!(&records[0], &texts);
            let back = records[1][0].parse::<f64>().ok();
            prop_assert_eq!(back, value.is_finite().then_some(value));
            // The negative control: quotes are needed as soon as there is one of these characters.
            let bare = texts.join(",") + "\r\n";
            if texts.iter().any(|t| t.contains([',', '"', '\n'])) {
                prop_assert_ne!(line(&texts), bare);
            }
        }
    }
}
