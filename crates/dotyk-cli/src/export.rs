//! `dotyk export`: the contact problem of a case for other solvers.

use crate::Outcome;
use crate::failure::{Failure, warn};
use crate::given::Given;
use crate::run::output_folder;
use crate::text::{named, number, print};
use dotyk::dual::{Block, DualProblem};
use dotyk::model::Error;
use dotyk::output;
use std::path::PathBuf;

/// Arguments of `dotyk export`.
#[derive(clap::Args)]
pub struct Arguments {
    /// Case file
    case: PathBuf,
    #[command(flatten)]
    given: Given,
    /// Time of the problem [default: that of the last load step]; friction counts slip from the step before
    #[arg(long, value_name = "T", value_parser = finite, allow_negative_numbers = true)]
    time: Option<f64>,
    /// Output folder [default: CASE-out]
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Number of threads [default: all]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..))]
    pub threads: Option<u16>,
}

fn finite(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(value) if value.is_finite() => Ok(value),
        _ => Err("expected a number".to_string()),
    }
}

/// Condenses, solves for comparison, writes, prints.
pub fn export(arguments: &Arguments) -> Result<Outcome, Failure> {
    of_any!(arguments.given.read_case(&arguments.case)?, |case| {
        let folder = output_folder(arguments.out.as_deref(), &case.stem)?;
        warn(&case.warnings);
        let time = arguments.time.unwrap_or(case.model.last_time());
        let mut dual = match case.model.dual(time) {
            Ok(dual) => dual,
            Err(error @ Error::NotConverged { .. }) => {
                let message = format!("a load step before t = {}: {error}", number(time));
                Failure::of(&arguments.case, message).print();
                return Ok(Outcome::Unsatisfied);
            }
            Err(error) => {
                let refusal = case.error(error.subject().as_ref(), &error.to_string());
                return Err(refusal.into());
            }
        };
        if !dual.assemble() {
            let (unknowns, most) = (dual.problem().len(), dotyk::model::ASSEMBLED);
            let error = output::Error::Unassembled { unknowns, most };
            return Err(Failure::of_output(error));
        }
        // a problem that is not solved here may still interest another solver
        let answer = dual.solve(case.model.solver.method);
        if let Err(error) = &answer {
            warn(&[format!("the problem is written without an answer: {error}")]);
        }
        let files = dual.write(answer.as_ref().ok(), &case.stem, &folder);
        let text = summary(&case.model.title, dual.time(), dual.problem());
        print(&(text + &named(&files.map_err(Failure::of_output)?)))?;
        Ok(Outcome::Done)
    })
}

/// Title and size of the problem, in two lines.
fn summary(title: &str, time: f64, problem: &DualProblem) -> String {
    let blocks = problem.admissible.blocks();
    let count = |law: &str| match blocks.iter().filter(|block| block.name() == law).count() {
        0 => String::new(),
        count => format!(", {count} {law}"),
    };
    let laws = Block::LAWS.map(count);
    format!(
        "{title}\nt = {}, m = {} contact forces, r = {} rigid amplitudes, {} blocks{}\n\n",
        number(time),
        problem.len(),
        problem.balance.load().len(),
        blocks.len(),
        laws.concat()
    )
}
