//! Result files that change together: a folder holds all of an answer or all of the one before.
//!
//! A run holds its [`Folder`]: a second run gets an error. Files are written into a [`Stage`], a folder beside it with a random
//! name. When all of them are on the disk, they replace the old ones in one step of the file system, if it has such a step: the
//! two folders exchange their names (`swap`). Elsewhere the stage becomes a journal in the folder, from which the files are renamed
//! one by one; the next run finishes a journal, and a reader is told to wait for it (`journal`). So a run killed at any moment
//! leaves the old answer or the new one, and other leftovers are removed by the next run.

mod folder;
mod journal;
mod stage;
mod swap;

pub use folder::Folder;
pub(crate) use journal::is_unfinished;
pub use stage::{Stage, abandon};

use crate::output::Error;
use std::collections::hash_map::RandomState;
use std::fs::File;
use std::hash::BuildHasher;
use std::io;
use std::path::{Path, PathBuf};

/// End of the name of a stage.
const PARTIAL: &str = ".partial";

/// Beginning of the name of a stage for the folder `of`.
fn beginning(of: &str) -> String {
    format!(".{of}.")
}

/// An unpredictable name for a stage.
fn random_name(of: &str) -> String {
    let number = RandomState::new().hash_one(std::process::id());
    format!("{}{number:016x}{PARTIAL}", beginning(of))
}

/// Whether a name is one of [`random_name`].
fn is_random_name(name: &str, of: &str) -> bool {
    let rest = name.strip_prefix(&beginning(of));
    let middle = rest.and_then(|rest| rest.strip_suffix(PARTIAL));
    middle.is_some_and(|hex| hex.len() == 16 && hex.bytes().all(|b| b.is_ascii_hexdigit()))
}

/// Result of locking a folder.
enum Lock {
    /// It is held while the file is open; `None` where the system locks no folders.
    Held(Option<File>),
    /// Another run holds it.
    Taken,
}

/// Locks a folder against other processes, and other threads of this one.
#[cfg(unix)]
fn lock(folder: &Path) -> Lock {
    use std::fs::TryLockError;
    match File::open(folder).map(|file| (file.try_lock(), file)) {
        Ok((Err(TryLockError::WouldBlock), _)) => Lock::Taken,
        Ok((Ok(()), file)) => Lock::Held(Some(file)),
        Ok((Err(TryLockError::Error(_)), _)) | Err(_) => Lock::Held(None),
    }
}

/// Folders cannot be opened: another run that writes at the same time is not noticed.
#[cfg(not(unix))]
fn lock(_folder: &Path) -> Lock {
    Lock::Held(None)
}

/// Whether an open folder is the one of this name, now.
#[cfg(unix)]
fn is_still(file: &File, folder: &Path) -> bool {
    use std::os::unix::fs::MetadataExt;
    let place = |data: std::fs::Metadata| (data.dev(), data.ino());
    let both = (file.metadata().map(place), folder.metadata().map(place));
    matches!(both, (Ok(a), Ok(b)) if a == b)
}

#[cfg(not(unix))]
fn is_still(_file: &File, _folder: &Path) -> bool {
    true
}

fn unwritable(path: &Path, source: io::Error) -> Error {
    Error::Unwritable {
        path: path.to_path_buf(),
        source,
    }
}

/// The folders that a path names, and that are not there, outermost first.
fn missing(dir: &Path) -> Vec<PathBuf> {
    let mut missing: Vec<PathBuf> = dir
        .ancestors()
        .filter(|a| !a.as_os_str().is_empty())
        .take_while(|a| !a.exists())
        .map(Path::to_path_buf)
        .collect();
    missing.reverse();
    missing
}
