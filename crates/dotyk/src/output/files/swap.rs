//! Two folders that change their names, so that all files of one change at the same moment.
//!
//! The new files stand in a stage beside the folder, and those that others have put into the folder are linked there, too. After the
//! exchange of names the folder is the stage, whole; now the one that was the folder gets the new files, as links, and is given its name
//! back: whoever has it open, a shell or a viewer, has it still. At every moment what the name leads to is whole, and what does not have
//! it holds nothing that is not also there: it can be removed.

use crate::output::files::journal::make_parents;
use std::collections::HashSet;
use std::fs;
use std::io;
use std::path::Path;

/// Most files of others that are linked: beside more of them files are put in place one by one.
const MOST: usize = 1000;

/// Gives a folder the `files` of the stage, without the `stale` ones. False where that cannot be done so: then the folder is as it was.
pub(super) fn swap(folder: &Path, stage: &Path, files: &[String], stale: &[String]) -> bool {
    let own: HashSet<&Path> = files.iter().chain(stale).map(Path::new).collect();
    let mut links = 0;
    let adopted = adopt(folder, stage, Path::new(""), &own, &mut links);
    if adopted.is_err() || exchange(folder, stage).is_err() {
        return false;
    }
    // the stage is the old folder from here on; where that cannot be renewed it has done its service
    if renew(stage, folder, files, stale).is_ok() && exchange(folder, stage).is_ok() {
        rescue(stage, folder);
    }
    true
}

/// Links all that others have put into the folder below `at` into the stage.
fn adopt(
    folder: &Path,
    stage: &Path,
    at: &Path,
    own: &HashSet<&Path>,
    links: &mut usize,
) -> io::Result<()> {
    for entry in fs::read_dir(folder.join(at))? {
        let entry = entry?;
        let place = at.join(entry.file_name());
        if own.contains(place.as_path()) {
            continue;
        }
        *links += 1;
        if *links > MOST {
            return Err(io::ErrorKind::QuotaExceeded.into());
        }
        let target = stage.join(&place);
        if entry.file_type()?.is_dir() {
            fs::create_dir_all(&target)?;
            fs::set_permissions(&target, entry.metadata()?.permissions())?;
            adopt(folder, stage, &place, own, links)?;
        } else {
            fs::hard_link(entry.path(), &target)?;
        }
    }
    Ok(())
}

/// Gives what was the folder the files of the whole one.
fn renew(old: &Path, whole: &Path, files: &[String], stale: &[String]) -> io::Result<()> {
    for name in files.iter().chain(stale) {
        let target = old.join(name);
        if target.symlink_metadata().is_ok() {
            fs::remove_file(&target)?;
        }
    }
    for name in files {
        let target = old.join(name);
        make_parents(&target)?;
        fs::hard_link(whole.join(name), &target)?;
    }
    Ok(())
}

/// What somebody has put into the stage while it had the name of the folder moves over.
fn rescue(stage: &Path, folder: &Path) {
    for entry in fs::read_dir(stage).into_iter().flatten().flatten() {
        let target = folder.join(entry.file_name());
        if target.symlink_metadata().is_err() {
            // what cannot be moved is lost with the stage
            let _ = fs::rename(entry.path(), target);
        }
    }
}

#[cfg(any(target_os = "linux", target_os = "android", target_vendor = "apple"))]
fn exchange(a: &Path, b: &Path) -> io::Result<()> {
    use rustix::fs::{CWD, RenameFlags, renameat_with};
    Ok(renameat_with(CWD, a, CWD, b, RenameFlags::EXCHANGE)?)
}

#[cfg(not(any(target_os = "linux", target_os = "android", target_vendor = "apple")))]
fn exchange(_a: &Path, _b: &Path) -> io::Result<()> {
    Err(io::ErrorKind::Unsupported.into())
}
