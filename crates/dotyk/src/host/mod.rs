//! Resources of this process: memory, threads, other processes that work on the same case, and the bytes of files that a case names.

mod files;
mod memory;
mod team;
mod threads;

pub use files::read;
pub(crate) use files::read_text;
pub(crate) use memory::told;
pub use memory::{free_memory, peak_memory_bytes};
#[cfg(test)]
pub(crate) use team::threads::in_teams;
pub use team::{Team, alike, all_done, team, work_in};
pub(crate) use team::{largest_share, processes, share};
pub(crate) use threads::in_order;
pub use threads::threads;
