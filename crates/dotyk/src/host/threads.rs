//! Number of threads.

use crate::host::memory::{address_space, of_products, told};
use crate::host::team::team;
use rayon::ThreadPoolBuilder;
use rayon::prelude::*;
use std::sync::atomic::{AtomicU64, Ordering};
use std::thread::available_parallelism;

/// Most threads that may be requested.
const MOST_THREADS: usize = 1024;

/// Most bytes that the allocator reserves for a thread: two of its heaps of 64 MB while it aligns the first, and a stack.
const OF_ALLOCATOR: u64 = 136 << 20;

/// Bytes of a small model besides.
const OF_MODEL: u64 = 32 << 20;

/// The results of parallel work in their order. Of several errors it is the first one in this order, whichever came first in time.
pub(crate) fn in_order<T: Send, E: Send>(
    each: impl IndexedParallelIterator<Item = Result<T, E>>,
) -> Result<Vec<T>, E> {
    each.collect::<Vec<_>>().into_iter().collect()
}

/// A pool of that many threads, to be built; without a number as many as there are processors, or as fit a limited address
/// space, and one in a process that works with others.
///
/// Errors: more threads than any machine has processors; several in one of several processes; too little room for them, in words.
pub fn threads(wanted: Option<usize>) -> Result<ThreadPoolBuilder, String> {
    if let Some(wanted) = wanted.filter(|&wanted| wanted > MOST_THREADS) {
        return Err(format!(
            "{wanted} threads are too many, at most {MOST_THREADS}"
        ));
    }
    let several = team().size() > 1;
    if several && wanted.is_some_and(|wanted| wanted > 1) {
        let advice = "every process works on one thread: start more processes instead";
        return Err(advice.to_string());
    }
    let wanted = if several { Some(1) } else { wanted };
    let pool = ThreadPoolBuilder::new();
    let Some(left) = address_space() else {
        return Ok(pool.num_threads(wanted.unwrap_or(0)));
    };
    let all = available_parallelism().map_or(1, usize::from);
    let count = wanted.unwrap_or_else(|| all.min(fitting(left)).max(1));
    if count > fitting(left) {
        let needed = OF_MODEL + of_products() + count as u64 * of_thread();
        let (threads, advice) = match count {
            1 => ("thread", ""),
            _ => ("threads", ", or take fewer threads"),
        };
        return Err(format!(
            "the address space is limited: {} of it are left, and {count} {threads} would reserve {}; give it more (`ulimit -v`){advice}",
            told(left),
            told(needed),
        ));
    }
    STARTED.store(count as u64, Ordering::Relaxed);
    Ok(pool.num_threads(count))
}

/// Threads of the last pool under a limit of the address space; rayon's own pool is not queried, because that would start it.
static STARTED: AtomicU64 = AtomicU64::new(0);

/// Threads whose reservations, present or future, do not count as free where the address space is limited.
pub(super) fn started() -> u64 {
    STARTED.load(Ordering::Relaxed)
}

/// Bytes that a thread reserves.
fn of_thread() -> u64 {
    of_products() + OF_ALLOCATOR
}

/// Number of threads that fit an address space, besides the calling one.
fn fitting(left: u64) -> usize {
    let left = left.saturating_sub(OF_MODEL + of_products());
    usize::try_from(left / of_thread()).unwrap_or(MOST_THREADS)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn threads_are_as_many_as_fit() {
        let room = |count: u64| OF_MODEL + of_products() + count * of_thread();
        assert_eq!(fitting(0), 0);
        assert_eq!(fitting(room(1) - 1), 0);
        assert_eq!(fitting(room(3)), 3);
        assert!(threads(Some(3)).is_ok());
        assert!(threads(Some(5000)).unwrap_err().contains("at most 1024"));
    }
}
