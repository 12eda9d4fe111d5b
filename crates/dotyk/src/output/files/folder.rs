//! A folder of results that one run holds.

use crate::output::Error;
use crate::output::files::stage::{left, writing};
use crate::output::files::{Lock, is_random_name, is_still, journal, lock, missing, unwritable};
use std::fs::{self, File};
use std::io::ErrorKind;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::{Duration, Instant};

/// Longest wait for other writers.
const LONGEST_WAIT: Duration = Duration::from_secs(10);

/// Interval of the checks whether they have ended.
const PAUSE: Duration = Duration::from_millis(10);

/// Most tries for a folder that others exchange meanwhile.
const MOST_TRIES: usize = 100;

/// A folder of results; as long as it lives, no other run of any process can have it.
///
/// Folders that were made for it and got no file are removed with it.
#[derive(Clone)]
pub struct Folder(Arc<Held>);

struct Held {
    named: PathBuf,
    /// Without links and `..`.
    place: PathBuf,
    /// Folders that did not exist before, outermost first.
    made: Vec<PathBuf>,
    _lock: Option<File>,
}

impl Folder {
    /// Takes a folder, and makes it if it does not exist. Leftovers of killed runs in it are finished or removed.
    ///
    /// Errors: [`Error::Taken`] where another run has it, [`Error::NotADirectory`], [`Error::Unwritable`].
    pub fn hold(dir: &Path) -> Result<Self, Error> {
        let _writing = writing();
        let mut own = Made(Vec::new());
        let mut tries = 0..MOST_TRIES;
        let lock = 'again: loop {
            for path in missing(dir) {
                match fs::create_dir(&path) {
                    Ok(()) => own.0.push(path),
                    Err(_) if path.is_dir() => {}
                    // another run without results has just removed its folder
                    Err(e) if e.kind() == ErrorKind::NotFound && tries.next().is_some() => {
                        continue 'again;
                    }
                    Err(source) => return Err(unwritable(&path, source)),
                }
            }
            if !dir.is_dir() {
                return Err(Error::NotADirectory {
                    path: dir.to_path_buf(),
                });
            }
            match lock(dir) {
                Lock::Taken => {
                    // it belongs to the other run now, although this one may have made it
                    drop(own.kept());
                    return Err(Error::Taken {
                        path: dir.to_path_buf(),
                    });
                }
                Lock::Held(None) => break None,
                // another run may just have put another folder in its place; some systems cannot tell which folder it is
                Lock::Held(Some(file)) if is_still(&file, dir) || tries.next().is_none() => {
                    break Some(file);
                }
                Lock::Held(Some(_)) => {}
            }
        };
        let place = dir.canonicalize().map_err(|e| unwritable(dir, e))?;
        if lock.is_some() {
            sweep(&place);
        }
        journal::finish(&place)?;
        let made = own.kept();
        left().made.extend(made.iter().cloned());
        Ok(Self(Arc::new(Held {
            named: dir.to_path_buf(),
            place,
            made,
            _lock: lock,
        })))
    }

    /// The same, but waits some seconds for others who write into it.
    ///
    /// Errors: as [`Self::hold`].
    pub fn wait(dir: &Path) -> Result<Self, Error> {
        let end = Instant::now() + LONGEST_WAIT;
        loop {
            match Self::hold(dir) {
                Err(Error::Taken { .. }) if Instant::now() < end => std::thread::sleep(PAUSE),
                held => return held,
            }
        }
    }

    /// Its path as given.
    pub fn path(&self) -> &Path {
        &self.0.named
    }

    /// Without links and `..`.
    pub(super) fn place(&self) -> &Path {
        &self.0.place
    }
}

impl Drop for Held {
    fn drop(&mut self) {
        remove_empty(self.made.iter());
        let mut left = left();
        self.made.iter().for_each(|path| drop(left.made.take(path)));
    }
}

/// Folders that were made, and are removed unless they are kept.
struct Made(Vec<PathBuf>);

impl Made {
    fn kept(mut self) -> Vec<PathBuf> {
        std::mem::take(&mut self.0)
    }
}

impl Drop for Made {
    fn drop(&mut self) {
        remove_empty(self.0.iter());
    }
}

/// Removes empty folders, outer ones first in the list.
pub(super) fn remove_empty<'p>(made: impl DoubleEndedIterator<Item = &'p PathBuf>) {
    for path in made.rev() {
        // fails on a folder with content: then it stays
        let _ = fs::remove_dir(path);
    }
}

/// Removes stages of killed runs; no live run holds the folder, and a stage in use is locked.
fn sweep(place: &Path) {
    let name = place.file_name().unwrap_or_default().to_string_lossy();
    let beside = place.parent().map(|parent| (parent, name.as_ref()));
    for (folder, of) in beside.into_iter().chain([(place, journal::STAGE_PREFIX)]) {
        let entries = fs::read_dir(folder).into_iter().flatten().flatten();
        let left = entries.filter(|e| is_random_name(&e.file_name().to_string_lossy(), of));
        for entry in left.filter(|e| e.file_type().is_ok_and(|kind| kind.is_dir())) {
            if let Lock::Held(Some(_)) = lock(&entry.path()) {
                // leftovers that cannot be removed do no harm
                let _ = fs::remove_dir_all(entry.path());
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::output::tunnel::{Scratch, names};

    #[test]
    fn one_at_a_time_has_a_folder() {
        let scratch = Scratch::new("folder-held");
        let dir = scratch.path().join("a/b");
        let held = Folder::hold(&dir).unwrap();
        let second = Folder::hold(&dir).err().unwrap();
        assert!(matches!(second, Error::Taken { .. }), "{second}");
        assert!(second.to_string().contains("another run"), "{second}");
        let other = scratch.path().join("c");
        drop(Folder::hold(&other).unwrap());
        drop(held);
        // no file was written
        assert!(names(scratch.path()).is_empty());
        drop(Folder::hold(&dir).unwrap());
    }

    #[test]
    fn what_a_killed_run_left_goes_away() {
        let scratch = Scratch::new("folder-swept");
        let dir = scratch.path().join("out");
        for left in [
            ".out.0123456789abcdef.partial",
            "out/.dotyk.0123456789abcdef.partial",
        ] {
            fs::create_dir_all(scratch.path().join(left).join("x")).unwrap();
        }
        let foreign = [".out.mine.partial", ".other.0123456789abcdef.partial"];
        for foreign in foreign {
            fs::create_dir(scratch.path().join(foreign)).unwrap();
        }
        drop(Folder::hold(&dir).unwrap());
        assert_eq!(names(scratch.path()), [foreign[1], foreign[0], "out"]);
        assert!(names(&dir).is_empty());
    }
}
