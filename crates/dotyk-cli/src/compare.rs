//! `dotyk compare`: all solvers on one case, and iterations as a function of rho; for several load steps on the last one.

use crate::Outcome;
use crate::failure::{Failure, warn};
use crate::given::Given;
use crate::progress::Progress;
use crate::run::{output_folder, positive};
use crate::text::{columns, named, number, print};
use dotyk::model::{Comparison, ComparisonRow};
use dotyk::output::{self, Folder};
use std::path::PathBuf;

/// Arguments of `dotyk compare`.
#[derive(clap::Args)]
pub struct Arguments {
    /// Case file
    case: PathBuf,
    #[command(flatten)]
    given: Given,
    /// Also gradient and uzawa with 25 steps between A and B, for forces, unscaled
    #[arg(long, value_name = "A..B", value_parser = range)]
    rho: Option<(f64, f64)>,
    /// Output folder for compare.csv and compare.svg [default with --rho: CASE-out]
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
}

/// Number of steps between the ends of a range.
const STEPS: usize = 25;

fn range(text: &str) -> Result<(f64, f64), String> {
    let expected =
        || "expected two positive numbers A..B with A < B, such as 1e8..1e11".to_string();
    let (a, b) = text.split_once("..").ok_or_else(expected)?;
    match (positive(a), positive(b)) {
        (Ok(a), Ok(b)) if a < b => Ok((a, b)),
        _ => Err(expected()),
    }
}

/// Values of equal ratio from a to b, both included.
fn log_spaced((a, b): (f64, f64)) -> Vec<f64> {
    let last = (STEPS - 1) as f64;
    let inner = (1..STEPS - 1).map(|i| (a.ln() + (b / a).ln() * i as f64 / last).exp());
    [a].into_iter().chain(inner).chain([b]).collect()
}

/// Compares, writes, prints.
pub fn compare(arguments: &Arguments) -> Result<Outcome, Failure> {
    let case = arguments.given.read_case(&arguments.case)?;
    let compared = of_any!(&case, |case| {
        let writes = arguments.rho.is_some() || arguments.out.is_some();
        let folder = writes.then(|| output_folder(arguments.out.as_deref(), &case.stem));
        let folder = folder.transpose()?;
        warn(&case.warnings);
        let mut progress = Progress::new(false);
        let methods = case.model.compare(&mut |event| progress.observe(event));
        let steps = match (&methods, arguments.rho) {
            (Ok(_), Some(range)) => {
                let rho = log_spaced(range);
                let steps = case
                    .model
                    .compare_steps(&rho, &mut |event| progress.observe(event));
                Some(steps)
            }
            _ => None,
        };
        progress.finish();
        let failed = methods.as_ref().err();
        let failed = failed.or_else(|| steps.as_ref().and_then(|steps| steps.as_ref().err()));
        if let Some(error) = failed {
            return Err(case
                .error(error.subject().as_ref(), &error.to_string())
                .into());
        }
        Compared {
            title: case.model.title.clone(),
            steps: case.model.times.len(),
            folder,
            methods: methods.unwrap_or_default(),
            of_rho: steps.and_then(Result::ok).unwrap_or_default(),
        }
    });
    report(&compared)
}

/// The results of all solvers.
struct Compared {
    title: String,
    /// Number of load steps of the case.
    steps: usize,
    /// The output folder, if files are requested.
    folder: Option<Folder>,
    methods: Vec<ComparisonRow>,
    of_rho: Vec<ComparisonRow>,
}

/// Writes and prints.
fn report(compared: &Compared) -> Result<Outcome, Failure> {
    let Compared {
        title,
        folder,
        methods,
        of_rho,
        ..
    } = compared;
    let step = match compared.steps {
        1 => String::new(),
        count => format!("step {count} of {count}, from its own start\n"),
    };
    let mut text = format!("{title}\n{step}\n{}", method_table(methods));
    if !of_rho.is_empty() {
        text += "\n";
        text += &step_table(of_rho);
    }
    if let Some(folder) = folder {
        let comparison = Comparison {
            title: title.clone(),
            rows: methods.iter().chain(of_rho).cloned().collect(),
        };
        let files = output::write_comparison(&comparison, folder);
        let files = files.map_err(Failure::of_output)?;
        text += "\n";
        text += &named(&files);
    }
    print(&text)?;
    Ok(if methods.iter().all(|run| run.converged) {
        Outcome::Done
    } else {
        Outcome::Unsatisfied
    })
}

fn optional(value: Option<f64>) -> String {
    value.map_or_else(|| "-".to_string(), number)
}

fn converged(run: &ComparisonRow) -> String {
    if run.converged { "yes" } else { "NO" }.to_string()
}

fn method_table(runs: &[ComparisonRow]) -> String {
    let rows: Vec<Vec<String>> = runs
        .iter()
        .map(|run| {
            vec![
                run.method.clone(),
                converged(run),
                run.iterations.to_string(),
                run.products.to_string(),
                format!("{:.4}", run.seconds),
                format!("{:.1e}", run.difference),
                optional(run.rho),
                optional(run.rho_lambda_max),
            ]
        })
        .collect();
    let header = [
        "solver",
        "converged",
        "iterations",
        "F-products",
        "seconds",
        "difference to newton",
        "rho",
        "rho·λ_max",
    ];
    columns(&header, &rows, 2..8)
}

fn step_table(runs: &[ComparisonRow]) -> String {
    let rows: Vec<Vec<String>> = runs
        .iter()
        .map(|run| {
            vec![
                run.method.clone(),
                optional(run.rho),
                optional(run.rho_lambda_max),
                run.iterations.to_string(),
                converged(run),
            ]
        })
        .collect();
    let header = ["solver", "rho", "rho·λ_max", "iterations", "converged"];
    columns(&header, &rows, 1..4)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_range_is_two_increasing_positive_numbers() {
        assert_eq!(range("1e8..2e10"), Ok((1e8, 2e10)));
        assert_eq!(range(".5..1."), Ok((0.5, 1.0)));
        for text in [
            "1", "1..", "..1", "2..1", "1..1", "-1..1", "0..1", "1..inf", "1..nan", "a..b",
        ] {
            assert!(range(text).is_err(), "{text}");
        }
    }

    #[test]
    fn steps_have_equal_ratios_and_exact_ends() {
        let rho = log_spaced((3.0, 3e6));
        assert_eq!((rho.len(), rho[0], rho[24]), (25, 3.0, 3e6));
        let ratio = 10f64.powf(0.25);
        // a few rounding errors of exp and ln of numbers up to 15
        assert!(rho.windows(2).all(|w| (w[1] / w[0] - ratio).abs() < 1e-13));
    }
}
