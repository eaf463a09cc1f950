//! What the study ran on.

use crate::report::{CaseReport, StudyTiming};

/// The machine, and the whole study's times.
pub(crate) fn timing(threads: usize, seconds: f64, cases: &[CaseReport]) -> StudyTiming {
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    StudyTiming {
        processor: processor(),
        system: format!("{} {}", std::env::consts::OS, std::env::consts::ARCH),
        threads: if threads == 0 { cores } else { threads },
        cores,
        seconds,
        noise: cases.iter().filter_map(|case| case.timing.noise).reduce(f64::max),
    }
}

/// The processor's name, where the system tells it.
fn processor() -> String {
    let from_linux = std::fs::read_to_string("/proc/cpuinfo").ok().and_then(|text| {
        let line = text.lines().find(|line| line.starts_with("model name"))?;
        Some(line.split_once(':')?.1.trim().to_owned())
    });
    // Elsewhere the environment may know.
    from_linux.or_else(|| std::env::var("PROCESSOR_IDENTIFIER").ok()).unwrap_or_else(|| "unknown".into())
}
