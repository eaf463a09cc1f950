//! Settings in words: as options of the program, and as what files tell of how they came about.

use conray_estimate::AoSettings;
use serde_json::Value;

/// Every setting as text, by its name as an option of the program.
pub fn settings_text(settings: &AoSettings) -> Vec<(String, String)> {
    let Ok(Value::Object(members)) = serde_json::to_value(settings) else { return Vec::new() };
    let text = |value: Value| match value {
        Value::String(text) => text,
        // Whole numbers as they are: single precision would round large ones.
        whole if whole.is_u64() => whole.to_string(),
        other => match other.as_f64() {
            // Single precision, as it was asked for: 0.02 and not 0.019999999552965164.
            Some(number) if f64::from(number as f32) == number => (number as f32).to_string(),
            _ => other.to_string(),
        },
    };
    members.into_iter().map(|(name, value)| (name, text(value))).collect()
}

/// Those that differ from the defaults.
pub fn changed_settings(settings: &AoSettings) -> Vec<(String, String)> {
    let defaults = settings_text(&AoSettings::default());
    settings_text(settings).into_iter().filter(|pair| !defaults.contains(pair)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn settings_are_told_as_they_were_asked_for() {
        assert_eq!(changed_settings(&AoSettings::default()), []);
        let seed = (1 << 24) + 1;
        let changed = AoSettings { error: Some(0.03), seed, ..AoSettings::default() };
        let told: Vec<(String, String)> = changed_settings(&changed);
        let expected = [("error", "0.03"), ("seed", "16777217")];
        for pair in expected {
            assert!(told.contains(&(pair.0.into(), pair.1.into())), "{told:?}");
        }
        assert_eq!(told.len(), expected.len());
    }
}
