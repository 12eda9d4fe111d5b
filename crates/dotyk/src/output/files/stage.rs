//! Result files that appear whole or not at all.
//!
//! Every file is written under a temporary name in the target directory; only when all of them are complete are they
//! renamed, and a failing rename puts back what was there before. Dropping an uncommitted [`Stage`] removes all it made,
//! the directories too.

use crate::output::Error;
use std::fs::{self, File};
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};

/// Files on their way into a directory.
pub struct Stage {
    dir: PathBuf,
    /// Directories that did not exist before, outermost first.
    made: Vec<PathBuf>,
    files: Vec<String>,
    committed: bool,
}

impl Stage {
    /// Opens a directory, and makes it where it does not exist.
    ///
    /// Errors: [`Error::NotADirectory`], [`Error::Unwritable`].
    pub fn open(dir: &Path) -> Result<Self, Error> {
        let mut missing: Vec<PathBuf> = dir
            .ancestors()
            .filter(|a| !a.as_os_str().is_empty())
            .take_while(|a| !a.exists())
            .map(Path::to_path_buf)
            .collect();
        missing.reverse();
        let mut stage = Self {
            dir: dir.to_path_buf(),
            made: Vec::new(),
            files: Vec::new(),
            committed: false,
        };
        for path in missing {
            fs::create_dir(&path).map_err(|source| unwritable(&path, source))?;
            stage.made.push(path);
        }
        if !dir.is_dir() {
            return Err(Error::NotADirectory {
                path: dir.to_path_buf(),
            });
        }
        Ok(stage)
    }

    /// Writes one file under its temporary name.
    ///
    /// Errors: [`Error::Unwritable`]; [`Error::IsADirectory`] when a directory has the final name.
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
        let target = self.dir.join(name);
        if target.is_dir() {
            return Err(Error::IsADirectory { path: target });
        }
        let temporary = self.temporary(name);
        self.files.push(name.to_string());
        let written = File::create(&temporary).and_then(|file| {
            let mut out = BufWriter::new(file);
            write(&mut out)?;
            out.flush()
        });
        written.map_err(|source| unwritable(&target, source))
    }

    /// Renames all files to their final names and removes `stale` ones of an earlier run; returns the paths.
    ///
    /// Errors: [`Error::Unwritable`]; then the directory is as it was before.
    pub fn commit(mut self, stale: &[String]) -> Result<Vec<PathBuf>, Error> {
        let mut done: Vec<String> = Vec::new();
        let result = self.files.iter().try_for_each(|name| {
            let target = self.dir.join(name);
            done.push(name.clone());
            if target.exists() {
                fs::rename(&target, self.backup(name)).map_err(|s| unwritable(&target, s))?;
            }
            fs::rename(self.temporary(name), &target).map_err(|s| unwritable(&target, s))
        });
        if let Err(error) = result {
            for name in &done {
                let (target, backup) = (self.dir.join(name), self.backup(name));
                // Best effort: the first error is the one that the user must hear of.
                if backup.exists() {
                    let _ = fs::rename(&backup, &target);
                } else if !self.temporary(name).exists() {
                    let _ = fs::remove_file(&target);
                }
            }
            return Err(error);
        }
        for name in &self.files {
            let backup = self.backup(name);
            if backup.exists() {
                fs::remove_file(&backup).map_err(|source| unwritable(&backup, source))?;
            }
        }
        for name in stale.iter().filter(|name| !self.files.contains(name)) {
            let path = self.dir.join(name);
            if path.is_file() {
                fs::remove_file(&path).map_err(|source| unwritable(&path, source))?;
            }
        }
        self.committed = true;
        Ok(self.files.iter().map(|name| self.dir.join(name)).collect())
    }

    fn temporary(&self, name: &str) -> PathBuf {
        self.dir
            .join(format!(".{name}.{}.partial", std::process::id()))
    }

    fn backup(&self, name: &str) -> PathBuf {
        self.dir
            .join(format!(".{name}.{}.before", std::process::id()))
    }
}

impl Drop for Stage {
    fn drop(&mut self) {
        if self.committed {
            return;
        }
        for name in &self.files {
            let _ = fs::remove_file(self.temporary(name));
        }
        for path in self.made.iter().rev() {
            // Fails on a directory that somebody else has put something into: then it stays.
            let _ = fs::remove_dir(path);
        }
    }
}

fn unwritable(path: &Path, source: io::Error) -> Error {
    Error::Unwritable {
        path: path.to_path_buf(),
        source,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::output::tunnel::{Scratch, names};

    #[test]
    fn nothing_is_seen_before_the_commit() {
        let scratch = Scratch::new("stage-commit");
        let dir = scratch.path().join("a/b");
        let mut stage = Stage::open(&dir).unwrap();
        stage.put("one.txt", b"1").unwrap();
        assert!(!dir.join("one.txt").exists());
        stage.commit(&[]).unwrap();
        assert_eq!(names(&dir), ["one.txt"]);
    }

    #[test]
    fn dropped_stage_leaves_no_trace() {
        let scratch = Scratch::new("stage-drop");
        let mut stage = Stage::open(&scratch.path().join("a/b")).unwrap();
        stage.put("one.txt", b"1").unwrap();
        drop(stage);
        assert!(names(scratch.path()).is_empty());
    }

    #[test]
    fn failing_rename_restores_the_old_files() {
        let scratch = Scratch::new("stage-restore");
        let dir = scratch.path();
        fs::write(dir.join("one.txt"), b"old").unwrap();
        let mut stage = Stage::open(dir).unwrap();
        stage.put("one.txt", b"new").unwrap();
        stage.put("two.txt", b"new").unwrap();
        // A directory that takes the name between writing and renaming, and cannot be moved onto a file.
        fs::create_dir(dir.join("two.txt")).unwrap();
        fs::write(stage.backup("two.txt"), b"in the way").unwrap();
        let error = stage.commit(&[]).unwrap_err();
        assert!(error.to_string().contains("two.txt"), "{error}");
        assert_eq!(fs::read(dir.join("one.txt")).unwrap(), b"old");
    }
}
