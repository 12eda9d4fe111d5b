//! Result files that change together: a folder holds all of an answer or all of the one before.
//!
//! A run holds its [`Folder`]: a second one that wants it is told. Files are written into a [`Stage`], a folder beside it with a random
//! name. When all of them are on the disk, they take the place of the old ones in one step of the file system, where it has one: the
//! two folders change their names (`swap`). Elsewhere the stage becomes a journal in the folder, from which they are renamed one by
//! one; what stands in a journal is put in place by the next run, and a reader is told to wait for it (`journal`). So a run that is
//! killed at any moment leaves the old answer or the new one, and what else it leaves goes away with the next.

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

/// How the name of a stage ends.
const PARTIAL: &str = ".partial";

/// What the name of a stage for the folder `of` begins with.
fn beginning(of: &str) -> String {
    format!(".{of}.")
}

/// A name for a stage that nobody can foresee.
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

/// What came of asking for a folder.
enum Lock {
    /// It is held while the file is open; `None` where the system locks no folders.
    Held(Option<File>),
    /// Somebody else holds it.
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

/// Folders cannot be opened: another run that writes at the same time is not told.
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
