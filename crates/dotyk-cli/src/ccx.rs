//! `dotyk-ccx`: a deck under the calling convention of CalculiX, for programs that call `ccx`.
//!
//! `JOB.frd`, `JOB.dat` and `JOB.sta` appear beside `JOB.inp`, dotyk's own files in `JOB-out`. Exit status: 0 done, 201 not
//! converged, 1 a mistake in the deck.

use crate::failure::Failure;
use crate::{Outcome, run};
use clap::Parser;
use std::path::{Path, PathBuf};

/// Solve a deck as `ccx` does: JOB.inp to JOB.frd and JOB.dat
#[derive(Parser)]
#[command(name = "dotyk-ccx", version)]
pub struct Arguments {
    /// Name of the deck without .inp
    #[arg(short = 'i', value_name = "JOB", required_unless_present = "job")]
    input: Option<PathBuf>,
    /// The same
    #[arg(value_name = "JOB", conflicts_with = "input")]
    job: Option<PathBuf>,
    /// Format of results; only the default is written
    #[arg(short = 'o', value_name = "FORMAT", hide = true)]
    output: Option<String>,
}

/// Solves; the exit status is that of `ccx`.
pub fn solve(arguments: &Arguments) -> u8 {
    let job = arguments.input.as_ref().or(arguments.job.as_ref());
    let job = job.cloned().unwrap_or_default();
    let deck = match dotyk_deck::is_deck(&job) {
        true => job,
        false => PathBuf::from(format!("{}.inp", job.display())),
    };
    let apart = deck.parent().unwrap_or(Path::new("")).to_path_buf();
    let stem = deck.file_stem().unwrap_or_default().to_string_lossy();
    let out = apart.join(format!("{stem}-out"));
    // results of an earlier run would be taken for those of this one
    for extension in ["frd", "dat", "sta"] {
        let old = deck.with_extension(extension);
        if let Err(e) = std::fs::remove_file(&old)
            && e.kind() != std::io::ErrorKind::NotFound
        {
            Failure::of(&old, e).print();
            return 1;
        }
    }
    match run::run(&run::Arguments::of_deck(deck.clone(), out, apart)) {
        Ok(Outcome::Done) => 0,
        Ok(Outcome::Unsatisfied) => 201,
        Ok(Outcome::Refused) => 1,
        Err(failure) => {
            failure.print();
            1
        }
    }
}
