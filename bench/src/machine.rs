//! What a measurement ran on.

use conray_bvh::Level;
use serde_json::{Value, json};

/// The processor and what of it is used.
pub struct Machine {
    /// The processor's name, where the system tells it.
    pub processor: String,
    /// The widest SIMD instructions that conray's kernels use on it.
    pub simd: String,
    /// Threads that trace.
    pub threads: usize,
}

impl Machine {
    /// This machine, with rayon's current threads.
    pub fn here() -> Self {
        let simd = format!("{:?}", Level::new());
        let simd = simd.split('(').next().unwrap_or_default().to_owned();
        Self { processor: processor(), simd, threads: rayon::current_num_threads() }
    }

    /// For a file of figures.
    pub fn json(&self) -> Value {
        json!({ "processor": self.processor, "simd": self.simd, "threads": self.threads })
    }
}

impl std::fmt::Display for Machine {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}, {}, {} threads", self.processor, self.simd, self.threads)
    }
}

fn processor() -> String {
    let from_linux = std::fs::read_to_string("/proc/cpuinfo").ok().and_then(|text| {
        let line = text.lines().find(|line| line.starts_with("model name"))?;
        Some(line.split_once(':')?.1.trim().to_owned())
    });
    // Elsewhere the environment may know.
    from_linux.or_else(|| std::env::var("PROCESSOR_IDENTIFIER").ok()).unwrap_or_else(|| "unknown".into())
}
