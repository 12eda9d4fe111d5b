//! What the machine has of memory.

use std::fs::read_to_string;

/// Bytes that this process may still take: what the system says is available, or less where a control group bounds it; `None`
/// where the system does not tell.
pub(super) fn free_memory() -> Option<u64> {
    let told = available(&read_to_string("/proc/meminfo").ok()?)?;
    let group = |name: &str| {
        let text = read_to_string(format!("/sys/fs/cgroup/memory.{name}")).ok()?;
        text.trim().parse::<u64>().ok()
    };
    let left = group("max").zip(group("current"));
    Some(left.map_or(told, |(most, taken)| told.min(most.saturating_sub(taken))))
}

/// Bytes after `MemAvailable:` in the text of `/proc/meminfo`.
fn available(text: &str) -> Option<u64> {
    let line = text
        .lines()
        .find_map(|line| line.strip_prefix("MemAvailable:"))?;
    let kibibytes = line.split_whitespace().next()?;
    Some(kibibytes.parse::<u64>().ok()? * 1024)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn available_memory_is_read_in_kibibytes() {
        let text = "MemTotal:  100 kB\nMemFree:   7 kB\nMemAvailable:   20 kB\n";
        assert_eq!(available(text), Some(20 * 1024));
        assert_eq!(available("MemTotal:  100 kB\n"), None);
        assert_eq!(available("MemAvailable: much\n"), None);
    }

    #[test]
    fn this_machine_has_some_memory_or_does_not_tell() {
        assert!(free_memory().is_none_or(|bytes| bytes > 1 << 20));
    }
}
