//! Two folders that change their names, so that all files of one change at the same moment.
//!
//! The new files are in a stage beside the folder, and foreign files of the folder are linked there, too. After the exchange of names
//! the stage is the folder, complete. Now the former folder gets the new files as links, and its name back: a shell or a viewer that
//! has it open still has it. At every moment the folder with the name is complete, and the other one holds no file that is not also
//! there: it can be removed.

use crate::output::files::journal::make_parents;
use std::collections::HashSet;
use std::fs;
use std::io;
use std::path::Path;

/// Most foreign files that are linked: with more of them files are put in place one by one.
const MOST_LINKED: usize = 1000;

/// Gives a folder the `files` of the stage, without the `stale` ones. `false` if the exchange is impossible: then the folder is
/// unchanged.
pub(super) fn swap(folder: &Path, stage: &Path, files: &[String], stale: &[String]) -> bool {
    let own: HashSet<&Path> = files.iter().chain(stale).map(Path::new).collect();
    let mut links = 0;
    let adopted = adopt(folder, stage, Path::new(""), &own, &mut links);
    if adopted.is_err() || exchange(folder, stage).is_err() {
        return false;
    }
    // the stage is the old folder from here on; if it cannot be renewed the stage's files are in place all the same
    if renew(stage, folder, files, stale).is_ok() && exchange(folder, stage).is_ok() {
        rescue(stage, folder);
    }
    true
}

/// Links all foreign files of the folder below `at` into the stage.
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
        if *links > MOST_LINKED {
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

/// Gives the former folder the files of the complete one.
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

/// Moves files that others put into the stage while it had the name of the folder.
fn rescue(stage: &Path, folder: &Path) {
    for entry in fs::read_dir(stage).into_iter().flatten().flatten() {
        let target = folder.join(entry.file_name());
        if target.symlink_metadata().is_err() {
            // files that cannot be moved are lost with the stage
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
