//! Memory that this process has, and may still take.
//!
//! ```text
//!   free = min(what the system calls available, control group − taken, limit of the address space − taken − threads · products)
//! ```
//!
//! Products of matrices reserve two buffers as large as the third cache for each thread. Reserved is not taken: that counts only
//! where the address space is limited.

use crate::host::team::{least, team};
use crate::host::threads::started;
use std::fs::read_to_string;

/// Size of the third cache where the processor does not report it.
const CACHE: u64 = 32 << 20;

/// Bytes that this process may still take: what the system says is available, or less where a control group or a limit of the
/// address space bounds it; `None` where the system does not tell.
///
/// Of several processes the least, where each has an equal part of the memory of its machine: all have to ask.
pub fn free_memory() -> Option<u64> {
    let team = team();
    let neighbours = team.neighbours() as u64;
    least(&*team, free_here().map(|bytes| bytes / neighbours))
}

fn free_here() -> Option<u64> {
    let available = kibibytes(&read_to_string("/proc/meminfo").ok()?, "MemAvailable:")?;
    let group = |name: &str| {
        let text = read_to_string(format!("/sys/fs/cgroup/memory.{name}")).ok()?;
        text.trim().parse::<u64>().ok()
    };
    let group = group("max").zip(group("current"));
    let group = group.map(|(most, taken)| most.saturating_sub(taken));
    let space = address_space().map(|left| left.saturating_sub(started() * of_products()));
    [group, space]
        .into_iter()
        .flatten()
        .chain([available])
        .min()
}

/// Largest resident memory of the process so far in bytes; 0 where the system does not tell.
pub fn peak_memory_bytes() -> u64 {
    let status = read_to_string("/proc/self/status").unwrap_or_default();
    kibibytes(&status, "VmHWM:").unwrap_or(0)
}

/// Bytes in a person's words.
pub(crate) fn told(bytes: u64) -> String {
    match bytes < 1_000_000_000 {
        true => format!("{} MB", bytes.div_ceil(1_000_000)),
        false => format!("{:.1} GB", bytes as f64 / 1e9),
    }
}

/// The part of the address space within its limits; `None` without limits.
pub(super) fn address_space() -> Option<u64> {
    let limits = read_to_string("/proc/self/limits").ok()?;
    let status = read_to_string("/proc/self/status").ok()?;
    let kinds = [
        ("Max address space", "VmSize:"),
        ("Max data size", "VmData:"),
    ];
    let left = kinds.into_iter().filter_map(|(limit, taken)| {
        Some(soft_limit(&limits, limit)?.saturating_sub(kibibytes(&status, taken)?))
    });
    left.min()
}

/// The first number behind a name in the text of `/proc/self/limits`; `None` where it is unlimited.
fn soft_limit(text: &str, name: &str) -> Option<u64> {
    let line = text.lines().find_map(|line| line.strip_prefix(name))?;
    line.split_whitespace().next()?.parse().ok()
}

/// Bytes behind a name in a text of the kind of `/proc/meminfo`.
fn kibibytes(text: &str, name: &str) -> Option<u64> {
    let line = text.lines().find_map(|line| line.strip_prefix(name))?;
    Some(line.split_whitespace().next()?.parse::<u64>().ok()? * 1024)
}

/// Bytes that products of matrices reserve for each thread: two buffers as large as the third cache.
pub(super) fn of_products() -> u64 {
    let told = read_to_string("/sys/devices/system/cpu/cpu0/cache/index3/size");
    let told = told.ok().and_then(|text| {
        let digits = text.trim().strip_suffix('K')?;
        Some(digits.parse::<u64>().ok()? * 1024)
    });
    2 * told.unwrap_or(CACHE)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn available_memory_is_read_in_kibibytes() {
        let text = "MemTotal:  100 kB\nMemFree:   7 kB\nMemAvailable:   20 kB\n";
        let available = |text| kibibytes(text, "MemAvailable:");
        assert_eq!(available(text), Some(20 * 1024));
        assert_eq!(available("MemTotal:  100 kB\n"), None);
        assert_eq!(available("MemAvailable: much\n"), None);
    }

    #[test]
    fn a_limit_is_the_first_number_behind_its_name() {
        let text = "Limit                     Soft Limit           Hard Limit           Units\n\
                    Max data size             unlimited            unlimited            bytes\n\
                    Max address space         307200000            unlimited            bytes\n";
        assert_eq!(soft_limit(text, "Max address space"), Some(307_200_000));
        assert_eq!(soft_limit(text, "Max data size"), None);
        assert_eq!(soft_limit("", "Max data size"), None);
    }

    #[test]
    fn this_machine_has_some_memory_or_does_not_tell() {
        assert!(free_memory().is_none_or(|bytes| bytes > 1 << 20));
    }
}
