//! Files on their way into a folder.

use crate::output::Error;
use crate::output::files::folder::remove_empty;
use crate::output::files::{Folder, Lock, journal, lock, random_name, swap, unwritable};
use std::collections::BTreeSet;
use std::fs::{self, File};
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError, RwLock, RwLockReadGuard};

/// Most files that are synced in parallel.
const SIDE_BY_SIDE: usize = 8;

/// Folders and files that a process has to remove when it is ended.
#[derive(Default)]
pub(super) struct Left {
    pub stages: BTreeSet<PathBuf>,
    /// Folders that were made for results: those that are empty.
    pub made: BTreeSet<PathBuf>,
}

static LEFT: Mutex<Left> = Mutex::new(Left {
    stages: BTreeSet::new(),
    made: BTreeSet::new(),
});

/// Writers of files hold it for reading; the end of the process holds it for writing, for ever.
static WRITING: RwLock<()> = RwLock::new(());

/// A guard that keeps the process from ending during a write.
pub(super) fn writing() -> RwLockReadGuard<'static, ()> {
    WRITING.read().unwrap_or_else(PoisonError::into_inner)
}

pub(super) fn left() -> MutexGuard<'static, Left> {
    LEFT.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Removes all unfinished files and the folders made for them, and blocks further writing: for a process that was told to end. Files
/// that are being put in place are finished first.
pub fn abandon() {
    std::mem::forget(WRITING.write().unwrap_or_else(PoisonError::into_inner));
    let left = std::mem::take(&mut *left());
    for stage in left.stages {
        let _ = fs::remove_dir_all(stage);
    }
    remove_empty(left.made.iter());
}

/// Files on their way into a folder, invisible until all of them are there; dropped without [`Stage::commit`] it leaves no files.
pub struct Stage {
    folder: Folder,
    /// Their folder until then.
    place: PathBuf,
    files: Vec<String>,
    /// Keeps other runs from removing it.
    _lock: Lock,
}

impl Stage {
    /// A stage for a folder.
    ///
    /// Errors: [`Error::Unwritable`].
    pub fn open(folder: &Folder) -> Result<Self, Error> {
        let _writing = writing();
        let target = folder.place();
        let name = target.file_name().map(|name| name.to_string_lossy());
        let beside = target.parent().zip(name);
        let beside = beside.and_then(|(parent, name)| new_folder(parent, &name).ok());
        // the folder above may belong to another user
        let place = match beside {
            Some(place) => place,
            None => new_folder(target, journal::STAGE_PREFIX)
                .map_err(|e| unwritable(folder.path(), e))?,
        };
        if let Ok(data) = target.metadata() {
            // the stage gets the permissions of the folder, because it has its name for a moment
            let _ = fs::set_permissions(&place, data.permissions());
        }
        Ok(Self {
            folder: folder.clone(),
            files: Vec::new(),
            _lock: lock(&place),
            place,
        })
    }

    /// Writes one file; its name may lead into folders within the folder.
    ///
    /// Errors: [`Error::Unwritable`]; [`Error::IsADirectory`] when a folder has its name.
    pub fn put(&mut self, name: &str, bytes: &[u8]) -> Result<(), Error> {
        self.put_with(name, &mut |out| out.write_all(bytes))
    }

    /// The same for a file that is not in memory as a whole.
    ///
    /// Errors: as [`Self::put`].
    pub fn put_with(
        &mut self,
        name: &str,
        write: &mut dyn FnMut(&mut dyn Write) -> io::Result<()>,
    ) -> Result<(), Error> {
        let _writing = writing();
        let target = self.folder.path().join(name);
        if target.is_dir() {
            return Err(Error::IsADirectory { path: target });
        }
        if journal::within(self.folder.place(), name).is_none() {
            let linked = io::Error::other("a link stands where its folder is to be");
            return Err(unwritable(&target, linked));
        }
        let staged = self.place.join(name);
        self.files.push(name.to_string());
        let opened = journal::make_parents(&staged).and_then(|()| File::create_new(&staged));
        let written = opened.and_then(|file| {
            let mut out = BufWriter::new(file);
            write(&mut out)?;
            out.flush()
        });
        written.map_err(|source| unwritable(&target, source))
    }

    /// Puts all files in their places, in one step where the system has one, and removes `stale` ones of an earlier run; returns the
    /// paths.
    ///
    /// Errors: [`Error::Unwritable`], [`Error::IsADirectory`]; then the folder is as it was before, or, where files are put in place one
    /// by one, the next run finishes it.
    pub fn commit(self, stale: &[String]) -> Result<Vec<PathBuf>, Error> {
        let _writing = writing();
        let folder = self.folder.place();
        let paths: Vec<PathBuf> = self.named(&self.files);
        if let Some(path) = paths.iter().find(|path| path.is_dir()) {
            return Err(Error::IsADirectory { path: path.clone() });
        }
        let stale = stale.iter().filter(|name| !self.files.contains(name));
        let stale: Vec<String> = stale
            .filter(|name| folder.join(name).is_file())
            .cloned()
            .collect();
        sync(&self.place, &self.files).map_err(|e| unwritable(self.folder.path(), e))?;
        let beside = !self.place.starts_with(folder);
        if !(beside && swap::swap(folder, &self.place, &self.files, &stale)) {
            journal::put_in_place(folder, &self.place, &self.files, &stale)?;
        }
        // the names, too; a folder that cannot be synced has been written all the same
        for path in [Some(folder), folder.parent()].into_iter().flatten() {
            let _ = File::open(path).and_then(|dir| dir.sync_all());
        }
        Ok(paths)
    }

    fn named(&self, files: &[String]) -> Vec<PathBuf> {
        let dir = self.folder.path();
        files.iter().map(|name| dir.join(name)).collect()
    }
}

impl Drop for Stage {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(&self.place);
        left().stages.remove(&self.place);
    }
}

/// Makes a folder with an unpredictable name.
fn new_folder(parent: &Path, of: &str) -> io::Result<PathBuf> {
    loop {
        let place = parent.join(random_name(of));
        left().stages.insert(place.clone());
        match fs::create_dir(&place) {
            Ok(()) => return Ok(place),
            Err(error) => {
                left().stages.remove(&place);
                if error.kind() != io::ErrorKind::AlreadyExists {
                    return Err(error);
                }
            }
        }
    }
}

/// Syncs files to the disk.
fn sync(place: &Path, files: &[String]) -> io::Result<()> {
    let each = files.len().div_ceil(SIDE_BY_SIDE).max(1);
    let some = |names: &[String]| {
        let mut names = names.iter();
        names.try_for_each(|name| File::open(place.join(name))?.sync_all())
    };
    std::thread::scope(|scope| {
        let parts = files.chunks(each).map(|names| {
            let thread = std::thread::Builder::new().spawn_scoped(scope, move || some(names));
            // without a new thread this one does the work
            thread.map_or_else(|_| Err(some(names)), Ok)
        });
        let parts: Vec<_> = parts.collect();
        let results = parts.into_iter().map(|part| match part {
            Ok(thread) => thread.join().unwrap_or(Err(io::ErrorKind::Other.into())),
            Err(done) => done,
        });
        results.collect()
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::output::tunnel::{Scratch, names};

    fn stage(dir: &Path) -> Stage {
        Stage::open(&Folder::hold(dir).unwrap()).unwrap()
    }

    #[test]
    fn nothing_is_seen_before_the_commit() {
        let scratch = Scratch::new("stage-commit");
        let dir = scratch.path().join("a/b");
        let mut stage = stage(&dir);
        stage.put("one.txt", b"1").unwrap();
        stage.put("in/two.txt", b"2").unwrap();
        assert!(names(&dir).is_empty());
        stage.commit(&[]).unwrap();
        assert_eq!(names(&dir), ["in", "one.txt"]);
        assert_eq!(names(&scratch.path().join("a")), ["b"]);
        assert_eq!(fs::read(dir.join("in/two.txt")).unwrap(), b"2");
    }

    #[test]
    fn dropped_stage_leaves_no_trace() {
        let scratch = Scratch::new("stage-drop");
        let mut stage = stage(&scratch.path().join("a/b"));
        stage.put("one.txt", b"1").unwrap();
        drop(stage);
        assert!(names(scratch.path()).is_empty());
    }

    #[test]
    fn what_others_put_there_stays_and_the_folder_is_the_same() {
        let scratch = Scratch::new("stage-others");
        let dir = scratch.path().join("out");
        fs::create_dir_all(dir.join("sub/deep")).unwrap();
        for name in ["one.txt", "old.txt", "mine.txt", "sub/deep/mine.txt"] {
            fs::write(dir.join(name), b"old").unwrap();
        }
        #[cfg(unix)]
        std::os::unix::fs::symlink("nowhere", dir.join("link")).unwrap();
        // a link planted in place of a result: it is not followed
        #[cfg(unix)]
        std::os::unix::fs::symlink(dir.join("mine.txt"), dir.join("two.txt")).unwrap();
        let opened = File::open(&dir).unwrap();
        let mut stage = stage(&dir);
        for name in ["one.txt", "two.txt"] {
            stage.put(name, b"new").unwrap();
        }
        stage
            .commit(&["old.txt".to_string(), "one.txt".to_string()])
            .unwrap();
        let mut expected = vec!["mine.txt", "one.txt", "sub", "two.txt"];
        if cfg!(unix) {
            expected.insert(0, "link");
        }
        assert_eq!(names(&dir), expected);
        assert_eq!(fs::read(dir.join("mine.txt")).unwrap(), b"old");
        assert_eq!(fs::read(dir.join("sub/deep/mine.txt")).unwrap(), b"old");
        assert_eq!(fs::read(dir.join("two.txt")).unwrap(), b"new");
        assert_eq!(names(scratch.path()), ["out"]);
        assert!(super::super::is_still(&opened, &dir));
    }

    #[cfg(unix)]
    #[test]
    fn no_link_leads_files_out_of_the_folder() {
        let scratch = Scratch::new("stage-link");
        let dir = scratch.path().join("out");
        fs::create_dir(&dir).unwrap();
        std::os::unix::fs::symlink(scratch.path(), dir.join("link")).unwrap();
        let error = stage(&dir).put("link/one.txt", b"1").unwrap_err();
        assert!(error.to_string().contains("a link stands"), "{error}");
        assert_eq!(names(scratch.path()), ["out"]);
    }

    #[test]
    fn a_folder_in_the_way_leaves_the_old_files() {
        let scratch = Scratch::new("stage-restore");
        let dir = scratch.path();
        fs::write(dir.join("one.txt"), b"old").unwrap();
        let mut stage = stage(dir);
        stage.put("one.txt", b"new").unwrap();
        stage.put("two.txt", b"new").unwrap();
        // it takes the name between writing and putting in place
        fs::create_dir(dir.join("two.txt")).unwrap();
        let error = stage.commit(&[]).unwrap_err();
        assert!(error.to_string().contains("two.txt"), "{error}");
        assert_eq!(fs::read(dir.join("one.txt")).unwrap(), b"old");
    }
}
