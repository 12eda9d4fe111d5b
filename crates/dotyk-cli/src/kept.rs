//! Finished load steps of a long run, in a folder beside that of its results: a run that is killed goes on from there with `--from`.
//!
//! They are written after a step when the time since the last time is [`SHARE`] times what writing took then, so that it costs a
//! small part of the run, and are removed when the results themselves are there.

use crate::failure::warn;
use dotyk::output::{Error, Folder};
use std::cell::Cell;
use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

/// How much longer than writing the steps before it takes.
const SHARE: u32 = 20;

/// Steps of shorter runs are not worth a file.
const SHORTEST: Duration = Duration::from_secs(2);

/// End of the name of the folder.
const ENDING: &str = ".unfinished";

/// A folder without it is none of these.
const SUMMARY: &str = "summary.json";

/// Endings of the files in it.
const ENDINGS: [&str; 7] = ["vtu", "pvtu", "vtm", "pvd", "csv", "json", "bin"];

/// The folder of the finished steps of a run.
pub struct Kept {
    path: PathBuf,
    /// Seconds between two times, if the user wants it so.
    every: Option<Duration>,
    last: Cell<Instant>,
    wait: Cell<Duration>,
    /// Steps in it.
    steps: Cell<usize>,
    failed: Cell<bool>,
}

impl Kept {
    /// That of a run with these results, whose first steps are those of an earlier one.
    pub fn beside(results: &Path, past: usize, every: Option<f64>) -> Self {
        let every = every.map(Duration::from_secs_f64);
        Self {
            path: path_beside(results),
            every,
            last: Cell::new(Instant::now()),
            wait: Cell::new(every.unwrap_or(SHORTEST)),
            steps: Cell::new(past),
            failed: Cell::new(false),
        }
    }

    /// Tells of steps that an interrupted run has left, unless this run goes on from there, or that it has left none.
    pub fn tell(&self, from: Option<&Path>) {
        if let Some(bare) = from.filter(|from| is_bare(from)) {
            warn(&[format!(
                "the run that made {} was ended before it had finished a step: this one starts from the beginning",
                bare.display()
            )]);
        }
        let goes_on = from.is_some_and(|from| same(from, &self.path));
        if self.path.join(SUMMARY).is_file() && !goes_on {
            let path = self.path.display();
            warn(&[format!(
                "an earlier run into this folder did not come to its end; what it finished is in {path}, and --from {path} goes on from there"
            )]);
        }
    }

    /// Writes these many steps if it is time; a folder that cannot be written is told once.
    pub fn after(&self, steps: usize, write: impl FnOnce(&Folder) -> Result<(), Error>) {
        let now = Instant::now();
        let early = now.duration_since(self.last.get()) < self.wait.get();
        if early || self.failed.get() || steps <= self.steps.get() {
            return;
        }
        if let Err(error) = Folder::hold(&self.path).and_then(|folder| write(&folder)) {
            self.failed.set(true);
            warn(&[format!("finished steps are not kept: {error}")]);
            return;
        }
        self.steps.set(steps);
        self.wait
            .set(self.every.unwrap_or((SHARE * now.elapsed()).max(SHORTEST)));
        self.last.set(Instant::now());
    }

    /// Removes them, the results being there, and their folder unless it has other files.
    pub fn remove(&self) {
        if !self.path.join(SUMMARY).is_file() {
            // one that a killed run made, and nothing in it
            let _ = std::fs::remove_dir(&self.path);
            return;
        }
        let entries = std::fs::read_dir(&self.path).into_iter().flatten();
        let files = entries.flatten().map(|entry| entry.path());
        let ours = |path: &PathBuf| {
            let ending = path.extension().and_then(|ending| ending.to_str());
            ending.is_some_and(|ending| ENDINGS.contains(&ending))
        };
        for file in files.filter(ours) {
            // what cannot be removed does no harm
            let _ = std::fs::remove_file(file);
        }
        let _ = std::fs::remove_dir(&self.path);
    }
}

/// Whether a run has made this folder for its finished steps and was killed before it had put any there.
pub fn is_bare(folder: &Path) -> bool {
    let name = folder.file_name().unwrap_or_default().as_encoded_bytes();
    let mut entries = std::fs::read_dir(folder).into_iter().flatten();
    name.ends_with(ENDING.as_bytes()) && folder.is_dir() && entries.next().is_none()
}

/// FOLDER.unfinished.
fn path_beside(results: &Path) -> PathBuf {
    let whole = results.canonicalize();
    let named = match results.file_name() {
        Some(_) => results,
        None => whole.as_deref().unwrap_or(results),
    };
    let mut name = named.file_name().map_or_else(OsString::new, OsString::from);
    name.push(ENDING);
    named.with_file_name(name)
}

fn same(a: &Path, b: &Path) -> bool {
    match (a.canonicalize(), b.canonicalize()) {
        (Ok(a), Ok(b)) => a == b,
        _ => a == b,
    }
}
