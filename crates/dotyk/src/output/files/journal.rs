//! Files that are put in place one by one, where a folder cannot change as a whole: on a mounted folder, on some file systems, or beside
//! many foreign files.
//!
//! All of them are in a folder within the folder, with a list of the actions to be done. Once that folder has its name, the new answer
//! is valid: the next run finishes the remaining actions. Renaming a file twice is harmless.

use crate::output::Error;
use crate::output::files::{random_name, unwritable};
use std::fs;
use std::io;
use std::path::{Path, PathBuf};

/// Beginning of the names of stages within a folder.
pub(super) const STAGE_PREFIX: &str = "dotyk";

/// The folder of files that are being put in place.
const JOURNAL: &str = ".dotyk.journal";

/// In it, the list of them: a line for each, `+` for a file to be put in place and `-` for one to be removed.
const LIST: &str = ".list";

/// Whether the files of a folder belong to two different answers.
pub(crate) fn is_unfinished(folder: &Path) -> bool {
    folder.join(JOURNAL).join(LIST).exists()
}

/// Puts `files` of the stage in their places in the folder, and removes the `stale` ones.
///
/// Errors: [`Error::Unwritable`]; then the folder is as it was before, or the next run finishes it.
pub(super) fn put_in_place(
    folder: &Path,
    stage: &Path,
    files: &[String],
    stale: &[String],
) -> Result<(), Error> {
    let put = files.iter().map(|name| format!("+{name}\n"));
    let lines: String = put
        .chain(stale.iter().map(|name| format!("-{name}\n")))
        .collect();
    let list = stage.join(LIST);
    let synced = fs::write(&list, lines).and_then(|()| fs::File::open(&list)?.sync_all());
    synced.map_err(|e| unwritable(&list, e))?;
    let journal = folder.join(JOURNAL);
    if fs::rename(stage, &journal).is_err() {
        // the stage is on another file system
        let inside = folder.join(random_name(STAGE_PREFIX));
        let all = files.iter().map(String::as_str).chain([LIST]);
        let copied = copies(stage, &inside, all).and_then(|()| fs::rename(&inside, &journal));
        copied.map_err(|e| {
            let _ = fs::remove_dir_all(&inside);
            unwritable(folder, e)
        })?;
    }
    finish(folder)
}

/// Copies files into a new folder.
fn copies<'n>(from: &Path, to: &Path, names: impl Iterator<Item = &'n str>) -> io::Result<()> {
    fs::create_dir(to)?;
    for name in names {
        let target = to.join(name);
        make_parents(&target)?;
        fs::copy(from.join(name), &target)?;
        fs::File::open(&target)?.sync_all()?;
    }
    Ok(())
}

/// Makes the folders above a file.
pub(super) fn make_parents(file: &Path) -> io::Result<()> {
    file.parent().map_or(Ok(()), fs::create_dir_all)
}

/// Finishes the journal of a folder, if there is one.
///
/// Errors: [`Error::Unwritable`].
pub(super) fn finish(folder: &Path) -> Result<(), Error> {
    let journal = folder.join(JOURNAL);
    if !is_unfinished(folder) {
        return Ok(());
    }
    let list = journal.join(LIST);
    let text = fs::read_to_string(&list).map_err(|e| unwritable(&list, e))?;
    for line in text.lines() {
        // a name that leads elsewhere, or through a planted link, is not one of ours
        let Some(target) = line.get(1..).and_then(|name| within(folder, name)) else {
            let message = format!("`{line}` of {} leads out of the folder", list.display());
            return Err(unwritable(folder, io::Error::other(message)));
        };
        let own = journal.join(&line[1..]);
        let done = match line.starts_with('+') && own.symlink_metadata().is_ok() {
            true => make_parents(&target).and_then(|()| fs::rename(&own, &target)),
            false if line.starts_with('-') && target.is_file() => fs::remove_file(&target),
            false => Ok(()),
        };
        done.map_err(|e| unwritable(&target, e))?;
    }
    fs::remove_dir_all(&journal).map_err(|e| unwritable(&journal, e))
}

/// A place within a folder; `None` for a name that leads out of it, by itself or through links.
pub(super) fn within(folder: &Path, name: &str) -> Option<PathBuf> {
    let plain = |part| matches!(part, std::path::Component::Normal(_));
    let inside = !name.is_empty() && Path::new(name).components().all(plain);
    let above = Path::new(name).ancestors().skip(1);
    let mut above = above.filter(|part| !part.as_os_str().is_empty());
    let linked = above.any(|part| folder.join(part).is_symlink());
    (inside && !linked).then(|| folder.join(name))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::output::tunnel::{Scratch, names};

    /// A folder with an old answer, and a stage with a new one beside it.
    fn both(scratch: &Scratch) -> [PathBuf; 2] {
        let [folder, stage] = ["out", "stage"].map(|name| scratch.path().join(name));
        for (dir, files) in [(&folder, ["a", "old"]), (&stage, ["a", "b"])] {
            fs::create_dir(dir).unwrap();
            for name in files {
                fs::write(dir.join(name), dir.to_str().unwrap()).unwrap();
            }
        }
        [folder, stage]
    }

    #[test]
    fn files_take_their_places_and_others_go() {
        let scratch = Scratch::new("journal");
        let [folder, stage] = both(&scratch);
        fs::write(folder.join("mine"), b"mine").unwrap();
        put_in_place(&folder, &stage, &["a".into(), "b".into()], &["old".into()]).unwrap();
        assert_eq!(names(&folder), ["a", "b", "mine"]);
        assert!(
            fs::read_to_string(folder.join("a"))
                .unwrap()
                .ends_with("stage")
        );
        assert!(!stage.exists() && !is_unfinished(&folder));
    }

    #[test]
    fn what_was_begun_is_finished_by_the_next() {
        let scratch = Scratch::new("journal-killed");
        let [folder, stage] = both(&scratch);
        // killed after the first of the files
        fs::write(stage.join(LIST), "+a\n+b\n-old\n").unwrap();
        fs::rename(&stage, folder.join(JOURNAL)).unwrap();
        fs::rename(folder.join(JOURNAL).join("a"), folder.join("a")).unwrap();
        assert!(is_unfinished(&folder));
        finish(&folder).unwrap();
        assert_eq!(names(&folder), ["a", "b"]);
        assert_eq!(names(scratch.path()), ["out"]);
        finish(&folder).unwrap();
    }

    #[test]
    fn no_list_leads_out_of_the_folder() {
        for line in ["+../a", "-../mine", "+/tmp/a", "+link/a"] {
            let scratch = Scratch::new("journal-planted");
            let [folder, stage] = both(&scratch);
            fs::write(scratch.path().join("mine"), b"mine").unwrap();
            #[cfg(unix)]
            std::os::unix::fs::symlink(scratch.path(), folder.join("link")).unwrap();
            fs::create_dir(stage.join("link")).unwrap();
            fs::write(stage.join("link/a"), b"planted").unwrap();
            fs::write(stage.join(LIST), line).unwrap();
            fs::rename(&stage, folder.join(JOURNAL)).unwrap();
            let told = finish(&folder).map_err(|e| e.to_string());
            if cfg!(unix) || !line.contains("link") {
                assert!(told.unwrap_err().contains("leads out of the folder"));
                assert_eq!(names(scratch.path()), ["mine", "out"], "{line}");
            }
        }
    }
}
