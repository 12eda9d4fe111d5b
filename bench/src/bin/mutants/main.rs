//! Do the tests notice errors? Small changes of the program, one at a time, against the tests that should fail.
//!
//! ```text
//! cargo run --release -p dotyk-bench --bin mutants -- COPY_DIR [--seed N] [--count N]
//! ```
//!
//! In the modules that compute, places are found where a small change makes another program: an operator, a comparison,
//! a constant, a bound of a range, a sign, a function that answers at once. A sample of them, the same number from each
//! module, is written into one copy of the workspace in COPY_DIR, each behind a switch. The tests of the tier are built
//! once and run once each, to find the places that each of them reaches; then each change is made and the tests run that reach
//! it. `mutants.txt` in COPY_DIR lists the outcome of each, survivors first. Changes that do not compile do not count.

mod copy;
mod places;
#[path = "../campaign/random.rs"]
#[allow(dead_code)]
mod random;
mod run;

use crate::copy::Mutant;
use crate::random::Random;
use crate::run::Fate;
use rayon::prelude::*;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// The modules that compute.
const MODULES: [&str; 4] = ["dual", "solve", "contact", "fem"];
/// Modules of the suite that take longer than all others together, and those that read the sources, which are changed. The
/// tier consists of the others, and of the unit tests of the library: the command in CONTRIBUTING.md.
const LEFT_OUT: [&str; 4] = ["rates::", "mindlin::", "layers::", "tidy::"];
/// Processes at a time.
const PROCESSES: usize = 2;

fn main() -> ExitCode {
    match arguments().and_then(|(folder, seed, count)| measure(&folder, seed, count)) {
        Ok(()) => ExitCode::SUCCESS,
        Err(message) => {
            eprintln!("{message}");
            ExitCode::FAILURE
        }
    }
}

/// Folder of the copy, seed and number of changes.
fn arguments() -> Result<(PathBuf, u64, usize), String> {
    let mut words = std::env::args().skip(1);
    let usage = "mutants COPY_DIR [--seed N] [--count N]";
    let folder = PathBuf::from(words.next().ok_or(usage)?);
    let (mut seed, mut count) = (0, 400);
    while let Some(word) = words.next() {
        let value = words.next().and_then(|value| value.parse::<usize>().ok());
        match (word.as_str(), value) {
            ("--seed", Some(value)) => seed = value as u64,
            ("--count", Some(value)) => count = value,
            _ => return Err(usage.to_string()),
        }
    }
    Ok((folder, seed, count))
}

fn measure(folder: &Path, seed: u64, count: usize) -> Result<(), String> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let root = root.canonicalize().map_err(|error| error.to_string())?;
    let mutants = sample(&root, seed, count)?;
    if folder.exists() {
        return Err(format!("{} exists: name a new folder", folder.display()));
    }
    copy::copy_folder(&root, folder).map_err(|error| error.to_string())?;
    let mut dropped = vec![false; mutants.len()];
    loop {
        copy::write(&root, folder, &mutants, &dropped).map_err(|error| error.to_string())?;
        let numbers = run::not_viable(folder)?;
        if numbers.is_empty() {
            break;
        }
        eprintln!("{} changes do not compile", numbers.len());
        numbers.into_iter().for_each(|k| dropped[k] = true);
    }
    let folder = folder.canonicalize().map_err(|error| error.to_string())?;
    let tests = run::tests(&folder, &LEFT_OUT)?;
    eprintln!("{} tests", tests.len());
    let threads = rayon::ThreadPoolBuilder::new().num_threads(PROCESSES);
    let threads = threads.build().map_err(|error| error.to_string())?;
    let fates = threads.install(|| {
        let surveyed = tests.par_iter().enumerate().map(|(k, test)| {
            let log = folder.join(format!("reached_{k}.txt"));
            run::survey(&folder, test, &log, mutants.len())
        });
        let surveyed = surveyed.collect::<Result<Vec<_>, _>>()?;
        let numbers = (0..mutants.len()).into_par_iter();
        let fates = numbers.map(|k| {
            let fate = match dropped[k] {
                true => Fate::NotViable,
                false => run::fate(&folder, &surveyed, k)?,
            };
            eprint!("{}", line(&mutants[k], &fate));
            Ok(fate)
        });
        fates.collect::<Result<Vec<_>, String>>()
    })?;
    let report = report(&mutants, &fates);
    print!("{report}");
    let path = folder.join("mutants.txt");
    std::fs::write(&path, report).map_err(|error| format!("{}: {error}", path.display()))
}

/// The same number of places from each module, or all places of a small module.
fn sample(root: &Path, seed: u64, count: usize) -> Result<Vec<Mutant>, String> {
    let mut random = Random::new(seed);
    let mut mutants = Vec::new();
    for module in MODULES {
        let mut files = Vec::new();
        let folder = root.join("crates/dotyk/src").join(module);
        sources(&folder, &mut files).map_err(|error| format!("{}: {error}", folder.display()))?;
        let mut found = Vec::new();
        for file in files {
            let refused = |error: String| format!("{}: {error}", file.display());
            let text = std::fs::read_to_string(&file).map_err(|e| refused(e.to_string()))?;
            let places = places::places(&text).map_err(|e| refused(e.to_string()))?;
            let file = file
                .strip_prefix(root)
                .map_err(|e| refused(e.to_string()))?;
            found.extend(places.into_iter().map(|place| Mutant {
                file: file.to_path_buf(),
                place,
            }));
        }
        eprintln!("{module}: {} places", found.len());
        for _ in 0..found.len().min(count / MODULES.len()) {
            mutants.push(found.swap_remove(random.count(0, found.len() - 1)));
        }
    }
    Ok(mutants)
}

/// The source files of a folder, tests left out, sorted.
fn sources(folder: &Path, files: &mut Vec<PathBuf>) -> Result<(), std::io::Error> {
    let entries = std::fs::read_dir(folder)?.map(|entry| entry.map(|entry| entry.path()));
    let mut entries = entries.collect::<Result<Vec<_>, _>>()?;
    entries.sort();
    for path in entries {
        if path.is_dir() {
            sources(&path, files)?;
        } else if path.extension().is_some_and(|e| e == "rs") && !path.ends_with("tests.rs") {
            files.push(path);
        }
    }
    Ok(())
}

/// One line for each module, one for each change, survivors first.
fn report(mutants: &[Mutant], fates: &[Fate]) -> String {
    let mut text = String::new();
    let caught = |fate: &&Fate| matches!(fate, Fate::Caught(_));
    for module in MODULES.into_iter().chain([""]) {
        let own = mutants.iter().zip(fates).filter(|(mutant, fate)| {
            let of_it = mutant
                .file
                .starts_with(format!("crates/dotyk/src/{module}"));
            of_it && **fate != Fate::NotViable
        });
        let fates: Vec<&Fate> = own.map(|(_, fate)| fate).collect();
        let (viable, caught) = (fates.len(), fates.iter().copied().filter(caught).count());
        let name = if module.is_empty() { "all" } else { module };
        let rate = 100.0 * caught as f64 / viable.max(1) as f64;
        text += &format!("{name:<8} {caught:>4} of {viable:>4} caught, {rate:.1} %\n");
    }
    let told = mutants.iter().zip(fates);
    let mut lines: Vec<String> = told.map(|(mutant, fate)| line(mutant, fate)).collect();
    lines.sort();
    text + &lines.concat()
}

/// The outcome of a change; survivors come first in sorted lines.
fn line(mutant: &Mutant, fate: &Fate) -> String {
    let (file, place) = (mutant.file.display(), &mutant.place);
    let (order, fate) = match fate {
        Fate::Survived(0) => (0, "reached by no test".to_string()),
        Fate::Survived(count) => (1, format!("survived {count} tests")),
        Fate::Caught(names) => (2, format!("caught by {names}")),
        Fate::NotViable => (3, "does not compile".to_string()),
    };
    format!("{order} {file}:{} {}: {fate}\n", place.line, place.what)
}
