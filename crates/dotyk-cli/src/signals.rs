//! A command that is told to end leaves nothing half done: what is being written is removed first. One that the runtime ends,
//! for want of memory or stack, has an exit status like others; what it was writing is swept by the next run.

#[cfg(unix)]
use std::sync::{Arc, atomic::AtomicBool};

/// Exit status of what is not done.
#[cfg(unix)]
const REFUSED: i32 = 2;

/// Watches for signals that end the process; those that whoever started it lets it ignore, as `nohup` does, stay ignored.
#[cfg(unix)]
pub fn watch() {
    use signal_hook::consts::{SIGABRT, SIGHUP, SIGINT, SIGTERM};
    // memory that the system does not give, a stack that is full: the runtime has told it, and aborts
    let always = Arc::new(AtomicBool::new(true));
    let _ = signal_hook::flag::register_conditional_shutdown(SIGABRT, REFUSED, always);
    let ignored = ignored();
    let heard = [SIGHUP, SIGINT, SIGTERM];
    let heard = heard
        .into_iter()
        .filter(|signal| ignored >> (signal - 1) & 1 == 0);
    let Ok(mut signals) = signal_hook::iterator::Signals::new(heard) else {
        return;
    };
    // a system that gives no thread ends the process as it would without this
    let _ = std::thread::Builder::new().spawn(move || {
        for signal in signals.forever() {
            dotyk::output::abandon();
            let _ = signal_hook::low_level::emulate_default_handler(signal);
        }
    });
}

#[cfg(not(unix))]
pub fn watch() {}

/// A bit for each signal that is ignored, the first for signal 1; none where the system does not tell.
#[cfg(unix)]
fn ignored() -> u64 {
    let text = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let mask = text.lines().find_map(|line| line.strip_prefix("SigIgn:"));
    let mask = mask.and_then(|mask| u64::from_str_radix(mask.trim(), 16).ok());
    mask.unwrap_or(0)
}
