//! Memory of this process, as the system counts it. Linux tells; elsewhere nothing is known.

use std::fs;

/// Bytes that the process holds now, and at most since [`restart_peak`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Resident {
    /// Now.
    pub now: u64,
    /// At most.
    pub peak: u64,
}

/// What the system says of this process; `None` where it does not.
pub fn resident() -> Option<Resident> {
    parse(&fs::read_to_string("/proc/self/status").ok()?)
}

/// Lets the peak begin anew. False where the system cannot.
pub fn restart_peak() -> bool {
    fs::write("/proc/self/clear_refs", "5").is_ok()
}

/// Bytes that the system could still give; `None` where it does not say.
pub fn available() -> Option<u64> {
    let text = fs::read_to_string("/proc/meminfo").ok()?;
    bytes(&text, "MemAvailable:")
}

fn parse(status: &str) -> Option<Resident> {
    Some(Resident { now: bytes(status, "VmRSS:")?, peak: bytes(status, "VmHWM:")? })
}

/// The number of KiB in the line of that name, in bytes.
fn bytes(text: &str, name: &str) -> Option<u64> {
    let line = text.lines().find_map(|line| line.strip_prefix(name))?;
    let kib: u64 = line.split_whitespace().next()?.parse().ok()?;
    Some(kib * 1024)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_numbers_are_read_and_none_is_made_up() {
        let status = "Name:\tx\nVmHWM:\t    2048 kB\nVmRSS:\t    1024 kB\n";
        assert_eq!(parse(status), Some(Resident { now: 1 << 20, peak: 2 << 20 }));
        assert_eq!(parse("VmHWM:\t1 kB\n"), None);
    }
}
