//! Signals. A command that is asked to end removes its unfinished files first. A command that the runtime aborts, for want of
//! memory or stack, has an ordinary exit status; the next run removes its unfinished files.

#[cfg(unix)]
use std::sync::{Arc, atomic::AtomicBool};

/// Exit status of an aborted command.
#[cfg(unix)]
const REFUSED: i32 = 2;

/// Watches for signals that end the process. Signals that the process was started to ignore, as with `nohup`, stay ignored.
#[cfg(unix)]
pub fn watch() {
    use signal_hook::consts::{SIGABRT, SIGHUP, SIGINT, SIGTERM};
    // out of memory, stack overflow: the runtime has printed its message, and aborts
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
    // without a thread, signals end the process as usual
    let _ = std::thread::Builder::new().spawn(move || {
        for signal in signals.forever() {
            dotyk::output::abandon();
            let _ = signal_hook::low_level::emulate_default_handler(signal);
        }
    });
}

#[cfg(not(unix))]
pub fn watch() {}

/// A bit for each ignored signal, the lowest for signal 1; zero if the system does not report them.
#[cfg(unix)]
fn ignored() -> u64 {
    let text = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let mask = text.lines().find_map(|line| line.strip_prefix("SigIgn:"));
    let mask = mask.and_then(|mask| u64::from_str_radix(mask.trim(), 16).ok());
    mask.unwrap_or(0)
}
