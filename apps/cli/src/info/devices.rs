//! `conray info --devices`: the graphics adapters of this machine.

use crate::{failure::Failure, report};
use serde_json::{Value, json};

/// Prints them, a line each.
pub(super) fn print(as_json: bool) -> Result<(), Failure> {
    let found = found();
    let line = |facts: &Value| {
        let text = |key: &str| facts[key].as_str().unwrap_or_default().to_string();
        let kind = if facts["software"] == true { ", a program on the CPU" } else { "" };
        let largest = report::bytes(facts["largest_binding_bytes"].as_u64().unwrap_or(0));
        format!(
            "{} ({}, {}{kind}): up to {largest} in a buffer",
            text("name"),
            text("backend"),
            text("driver")
        )
    };
    let mut lines: Vec<String> = found.iter().map(line).collect();
    if lines.is_empty() {
        lines.push("no graphics adapter: estimates are made on the CPU".into());
    }
    report::print_lines(&if as_json { vec![format!("{:#}", json!({ "devices": found }))] } else { lines });
    Ok(())
}

#[cfg(feature = "gpu")]
fn found() -> Vec<Value> {
    let facts = |facts: conray::gpu::AdapterFacts| {
        json!({
            "name": facts.name, "backend": facts.backend, "driver": facts.driver, "software": facts.is_software,
            "largest_binding_bytes": facts.largest_binding,
        })
    };
    conray::gpu::adapters().into_iter().map(facts).collect()
}

#[cfg(not(feature = "gpu"))]
fn found() -> Vec<Value> {
    Vec::new()
}
