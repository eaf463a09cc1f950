use super::*;
use crate::{fixture, picture::Picture};

/// Elements without an end.
const VOID: [&str; 3] = ["meta", "img", "br"];

/// The first fault in the nesting of tags; knows what the page uses: no comments, no `>` in attributes.
fn fault(html: &str) -> Option<String> {
    let mut open: Vec<&str> = Vec::new();
    let mut rest = html;
    while let Some(start) = rest.find('<') {
        let end = start + rest[start..].find('>')?;
        let tag = &rest[start + 1..end];
        rest = &rest[end + 1..];
        let name = tag.trim_start_matches('/').split([' ', '\n', '/']).next()?;
        if tag.starts_with('!') || tag.ends_with('/') || VOID.contains(&name) {
            continue;
        }
        if !tag.starts_with('/') {
            open.push(name);
            // What is in these is no markup.
            if name == "script" || name == "style" {
                rest = &rest[rest.find(&format!("</{name}>"))?..];
            }
        } else if open.pop() != Some(name) {
            return Some(format!("</{name}> before {}", &rest[..rest.len().min(60)]));
        }
    }
    open.last().map(|name| format!("<{name}> is never closed"))
}

fn fixture_page() -> (Report, String) {
    let report = fixture::report();
    let html = page(&report, &fixture::pictures(&report)).unwrap();
    (report, html)
}

#[test]
fn tags_are_balanced() {
    let (_, html) = fixture_page();
    assert_eq!(fault(&html), None);
    assert!(fault(&html.replacen("</figure>", "", 1)).is_some(), "the negative control");
    assert!(fault(&html.replacen("</table>", "</div>", 1)).is_some());
}

#[test]
fn anchors_are_unique_and_every_link_leads_to_one() {
    let (_, html) = fixture_page();
    let values = |start: &str| -> Vec<String> {
        html.split(start).skip(1).map(|s| s[..s.find('"').unwrap()].to_owned()).collect()
    };
    let ids = values(" id=\"");
    let links = values("href=\"#");
    assert!(links.len() > 8);
    assert_eq!(ids.iter().collect::<std::collections::BTreeSet<_>>().len(), ids.len());
    for link in links {
        assert!(ids.contains(&link), "{link}");
    }
}

#[test]
fn nothing_is_fetched() {
    let (_, html) = fixture_page();
    for outside in ["http://", "https://", "url(", "@import", "<link", "srcset"] {
        assert!(!html.contains(outside), "{outside}");
    }
    let sources: Vec<&str> = html.split(" src=\"").skip(1).map(|s| &s[..5.min(s.len())]).collect();
    assert!(!sources.is_empty() && sources.iter().all(|s| *s == "data:"));
}

#[test]
fn every_panel_is_embedded_and_a_missing_one_is_named() {
    let report = fixture::report();
    let pictures = fixture::pictures(&report);
    let html = page(&report, &pictures).unwrap();
    for (file, bytes) in &pictures {
        assert!(html.contains(&BASE64_STANDARD.encode(bytes)), "{file}");
    }
    let other = BASE64_STANDARD.encode(Picture::plain(9, 9, [1, 2, 3]).to_png());
    assert!(!html.contains(&other), "the negative control");
    for file in pictures.keys() {
        let mut fewer = pictures.clone();
        fewer.remove(file);
        assert!(page(&report, &fewer).unwrap_err().to_string().contains(file));
    }
}

#[test]
fn every_value_is_escaped() {
    let hostile = "<script>alert('x')</script>\"&";
    // Every text of the report becomes hostile but for names that choose something.
    let report = fixture::report();
    let pictures = fixture::pictures(&report);
    let mut json = serde_json::to_value(&report).unwrap();
    poison(&mut json, hostile);
    let poisoned: Report = serde_json::from_value(json).unwrap();
    assert_eq!(poisoned.cases[0].scene, hostile);
    let html = page(&poisoned, &pictures).unwrap();
    assert_eq!(html.matches("<script>").count(), 1, "the page's own");
    assert!(!html.contains("alert('x')"));
    assert!(html.matches("&lt;script&gt;").count() > 100);
    assert_eq!(fault(&html), None);
}

/// Replaces texts, except files of pictures and names of plots and classes.
fn poison(value: &mut serde_json::Value, hostile: &str) {
    match value {
        serde_json::Value::String(text) => *text = hostile.into(),
        serde_json::Value::Array(all) => all.iter_mut().for_each(|v| poison(v, hostile)),
        serde_json::Value::Object(all) => {
            for (name, value) in
                all.iter_mut().filter(|(n, _)| !["file", "plot", "class"].contains(&n.as_str()))
            {
                let _ = name;
                poison(value, hostile);
            }
        }
        _ => {}
    }
}

#[test]
fn an_empty_report_and_one_without_optional_parts_are_pages_too() {
    let mut report = fixture::report();
    for case in &mut report.cases {
        case.table.clear();
        case.failures.clear();
        case.causes.clear();
        case.tuned.clear();
        case.calibration.clear();
        case.equal_time.clear();
        case.trials.clear();
        case.cones = Default::default();
        case.distance = None;
        case.truth.ratio = 1.5;
    }
    report.timing.noise = None;
    let html = page(&report, &fixture::pictures(&report)).unwrap();
    assert_eq!(fault(&html), None);
    assert!(html.contains("No method took part.") && html.contains("infinite"));
    assert_eq!(html.matches("partly those of the truth itself").count(), 2);

    report.cases.clear();
    report.methods.clear();
    assert_eq!(fault(&page(&report, &BTreeMap::new()).unwrap()), None);
}

#[test]
fn every_trial_and_every_number_of_table_1_is_shown() {
    let (report, html) = fixture_page();
    for case in &report.cases {
        for trial in &case.trials {
            let cell = crate::plots::figures(trial.quality.rmse);
            assert!(html.contains(&format!(">{cell}<")), "{} {}: {cell}", trial.method, trial.label);
        }
        for row in &case.table {
            let paper = crate::plots::figures(row.paper_rmse.unwrap());
            assert!(html.contains(&format!(">{paper}<")), "{}: {paper}", row.label);
        }
    }
}
