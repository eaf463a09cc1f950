//! Prints the JSON schema of `report.json`: `cargo run -p conray-study --example schema > docs/report.schema.json`.

fn main() -> Result<(), serde_json::Error> {
    println!("{}", serde_json::to_string_pretty(&conray_study::schema())?);
    Ok(())
}
