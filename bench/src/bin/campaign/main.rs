//! A campaign of random contact problems in the plane or in space against a checker without any code of the solver.
//!
//! ```text
//! cargo run --release -p dotyk-bench --bin campaign -- [--space] [--seeds 0..1000] [--threads N] [--family NAME] [--keep DIR]
//!                                                      [--twins PART] [--method NAME] [--limit SECONDS] [--margins]
//!                                                      [--seed K --show] [--failed] [--more] [--pieces]
//! ```
//!
//! A seed makes a problem ([`families`], in space [`solids`]), the problem makes a case file, the program answers, and [`check`]
//! judges the answer from displacements and rows alone. The campaign looks for answers that are certified and wrong. A part of the
//! seeds is solved again as an equivalent problem ([`twins`]), frictionless ones by another method.
//! `--more` draws among the families that were added later: a new family in the first list would change the family of each seed.
//! `--pieces` cuts the bodies of every problem into 2 to 6 pieces, as its seed says.
//! In a named family the problem of a seed never changes.
//! `--failed` solves only the seeds that once had a wrong answer, or none, because of a fault, with a limit of at least a minute.
//! The same seeds give the same report for any number of threads, except for seconds and the runs stopped by the limit.
//! Exit status 1 if an answer is wrong or the program panics, with `--failed` also if an answer is missing.

mod amount;
mod carry;
mod case;
mod cells;
mod check;
mod cone;
mod cuts;
mod dimension;
mod elastic;
mod families;
mod gmsh;
mod held;
mod jitter;
mod judgement;
mod lines;
mod metal;
#[cfg(test)]
mod mutations;
mod overlap;
mod plane;
mod polygons;
mod problem;
mod random;
mod raw;
mod report;
mod rows;
mod run;
mod side;
mod solids;
mod solve;
mod state;
mod statics;
mod touch;
mod twin;
mod twins;
mod vector;
mod wrench;

use run::{Options, run};
use std::path::PathBuf;
use std::process::ExitCode;

fn main() -> ExitCode {
    let (options, space) = match options(std::env::args().skip(1)) {
        Ok(asked) => asked,
        Err(message) => {
            eprintln!("{message}");
            return ExitCode::from(2);
        }
    };
    let clean = match space {
        true => run::<3>(&options),
        false => run::<2>(&options),
    };
    match clean {
        Ok(true) => ExitCode::SUCCESS,
        Ok(false) => ExitCode::FAILURE,
        Err(message) => {
            eprintln!("{message}");
            ExitCode::from(2)
        }
    }
}

/// Seeds, in the plane and in space, that once had a wrong answer or none because of faults that are now corrected.
const FAILED: [&[u64]; 2] = [
    &[
        1_005_828,
        1_008_342,
        1_008_558,
        1_011_141,
        1_017_930,
        1_022_964,
        1_024_636,
        1_027_712,
        200_427_175,
        240_684_173,
        240_707_326,
    ],
    &[
        20,
        2_006,
        2_154,
        253_082_568,
        253_082_650,
        253_084_410,
        736_000_129,
    ],
];

/// The same for the later families, by name: the problem of a seed in a family does not depend on other families.
const FAILED_MORE: &[(&str, u64)] = &[
    ("edge", 240_663_960),
    ("graded", 200_417_299),
    ("metal", 98),
    ("metal", 125),
    ("metal", 159),
    ("metal", 194),
    ("metal", 736),
    ("metal", 816),
    ("shared", 238_392_131),
    ("stack", 238_432_234),
    ("whole", 31),
    ("whole", 39),
    ("whole", 43),
    ("whole", 61),
    ("whole", 85),
    ("whole", 90),
    ("whole", 93),
];

/// The options, and whether the problems are in space.
fn options(mut words: impl Iterator<Item = String>) -> Result<(Options, bool), String> {
    let (mut space, mut failed) = (false, false);
    let mut options = Options {
        seeds: (0..1000).map(|seed| (seed, None)).collect(),
        threads: std::thread::available_parallelism().map_or(1, |n| n.get()),
        family: None,
        more: false,
        pieces: false,
        keep: None,
        twins: 0.25,
        method: "accelerated".to_string(),
        margins: false,
        show: false,
        limit: 10.0,
        answered: false,
    };
    while let Some(word) = words.next() {
        let mut value = || words.next().ok_or_else(|| format!("{word} needs a value"));
        let number = |text: String| {
            text.parse::<u64>()
                .map_err(|_| format!("{text} is no number"))
        };
        match word.as_str() {
            "--seeds" => {
                let text = value()?;
                let (from, to) = text.split_once("..").ok_or("--seeds needs FROM..TO")?;
                let range = number(from.to_string())?..number(to.to_string())?;
                options.seeds = range.map(|seed| (seed, None)).collect();
            }
            "--seed" => {
                options.seeds = vec![(number(value()?)?, None)];
            }
            "--threads" => options.threads = (number(value()?)? as usize).max(1),
            "--family" => {
                options.family = Some(value()?);
            }
            "--keep" => options.keep = Some(PathBuf::from(value()?)),
            "--twins" => {
                let text = value()?;
                options.twins = text.parse().map_err(|_| format!("{text} is no number"))?;
            }
            "--method" => options.method = value()?,
            "--limit" => {
                let text = value()?;
                options.limit = text.parse().map_err(|_| format!("{text} is no number"))?;
            }
            "--margins" => options.margins = true,
            "--failed" => failed = true,
            "--more" => options.more = true,
            "--pieces" => options.pieces = true,
            "--space" => space = true,
            "--show" => options.show = true,
            other => return Err(format!("unknown argument {other}")),
        }
    }
    if space && options.more {
        return Err("--more has families of the plane alone: leave out --space".to_string());
    }
    if failed {
        options.answered = true;
        // a missing answer is a fault there, not of a busy machine
        options.limit = options.limit.max(60.0);
        let drawn = FAILED[usize::from(space)].iter();
        options.seeds = drawn.map(|&seed| (seed, None)).collect();
        if !space {
            let named = FAILED_MORE.iter();
            options
                .seeds
                .extend(named.map(|&(family, seed)| (seed, Some(family))));
        }
    }
    Ok((options, space))
}
