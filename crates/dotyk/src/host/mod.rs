//! Resources of this process: memory, threads, and the bytes of files that a case names.

mod files;
mod memory;
mod threads;

pub use files::read;
pub(crate) use files::read_text;
pub(crate) use memory::told;
pub use memory::{free_memory, peak_memory_bytes};
pub use threads::threads;
