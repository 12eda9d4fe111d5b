//! `dotyk run`: solve one case.

use crate::Outcome;
use crate::failure::{Failure, warn};
use crate::progress::Progress;
use crate::text::{columns, number, print, written};
use dotyk::case::Case;
use dotyk::geometry::norm;
use dotyk::model::{Bolts, Error, Method, Model, Solution, SolverOptions, Status};
use dotyk::output;
use std::path::{Path, PathBuf};
use std::time::Instant;

/// Arguments of `dotyk run`.
#[derive(clap::Args)]
pub struct Arguments {
    /// Case file
    case: PathBuf,
    /// Solver instead of the case's own: auto, newton, mprgp, gradient, accelerated, uzawa
    #[arg(long, value_name = "NAME", value_parser = method)]
    solver: Option<Method>,
    /// Step of gradient and uzawa, for forces, unscaled
    #[arg(long, value_name = "X", value_parser = positive, allow_negative_numbers = true)]
    rho: Option<f64>,
    /// Output folder [default: CASE-out]
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Number of threads [default: all]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..))]
    threads: Option<u16>,
    /// No progress
    #[arg(long)]
    quiet: bool,
}

fn method(text: &str) -> Result<Method, String> {
    Method::from_name(text).ok_or_else(|| {
        let names: Vec<&str> = Method::NAMED.iter().map(|m| m.name()).collect();
        format!("known solvers: auto, {}", names.join(", "))
    })
}

/// A finite number > 0.
pub fn positive(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(value) if value > 0.0 && value.is_finite() => Ok(value),
        _ => Err("expected a positive number".to_string()),
    }
}

/// Solves, writes, prints.
pub fn run(arguments: &Arguments) -> Result<Outcome, Failure> {
    if let Some(threads) = arguments.threads {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(usize::from(threads));
        let built = pool.build_global();
        built.map_err(|e| Failure::Message(format!("cannot start {threads} threads: {e}")))?;
    }
    let start = Instant::now();
    let mut case = Case::read(&arguments.case)?;
    override_solver(&mut case.model.solver, arguments.solver, arguments.rho)?;
    let folder = output_folder(arguments.out.as_deref(), &case)?;
    let read = start.elapsed().as_secs_f64();

    let mut progress = Progress::new(arguments.quiet);
    let solved = case.model.solve_with(&mut |event| progress.observe(event));
    progress.finish();
    let (mut solution, objection) = match solved {
        Ok(solution) => (solution, String::new()),
        Err(Error::NotConverged { solution, reason }) => (*solution, reason),
        Err(error) => {
            return Err(case
                .error(error.subject().as_ref(), &error.to_string())
                .into());
        }
    };
    solution.seconds.read = read;
    solution.seconds.total += read;
    case.warn_first(&mut solution.warnings);

    let refused = |e: output::Error| Failure::Message(e.to_string());
    warn(&solution.warnings);
    if solution.converged {
        let files = output::write(&case.model, &solution, &case.stem, &folder).map_err(refused)?;
        print(&(results(&case.model, &solution) + &written(&files)));
        return Ok(Outcome::Done);
    }
    let file = output::write_summary(&case.model, &solution, &case.stem, &folder);
    let file = file.map_err(refused)?;
    print(&(certificate(&solution) + &written(&[file])));
    let message = format!(
        "not converged after {} iterations of {}: {objection}",
        solution.solver.iterations, solution.solver.method
    );
    Failure::of(&arguments.case, message).print();
    Ok(Outcome::Unsatisfied)
}

/// The command line's solver and step instead of the case's; what belongs to the case's own method goes with it.
fn override_solver(
    options: &mut SolverOptions<2>,
    method: Option<Method>,
    rho: Option<f64>,
) -> Result<(), Failure> {
    if let Some(method) = method {
        options.method = method;
    }
    let steps = matches!(options.method, Method::Gradient | Method::Uzawa);
    if rho.is_some() && !steps {
        return Err(Failure::Message(format!(
            "--rho has no meaning for the solver `{}`: add --solver gradient or --solver uzawa",
            options.method.name()
        )));
    }
    if !steps {
        options.rho = None;
    }
    if options.method != Method::Uzawa {
        options.bolts = Bolts::Automatic;
    }
    options.rho = rho.or(options.rho);
    Ok(())
}

/// The folder for results; refused before any work when a file is in its way.
pub fn output_folder(given: Option<&Path>, case: &Case) -> Result<PathBuf, Failure> {
    let folder = match given {
        Some(folder) => folder.to_path_buf(),
        None => PathBuf::from(format!("{}-out", case.stem)),
    };
    let existing = folder.ancestors().find(|path| path.exists());
    match existing {
        Some(path) if !path.is_dir() => {
            let message = "cannot be the output folder, it is a file; choose another with --out";
            Err(Failure::of(path, message))
        }
        _ => Ok(folder),
    }
}

/// The result lines.
fn results(model: &Model<2>, solution: &Solution<2>) -> String {
    let mut text = format!(
        "{}\n{}, {} bodies, {} dofs, {} contact unknowns\n",
        model.title,
        model.analysis.name(),
        model.bodies.len(),
        solution.dofs,
        solution.contact_unknowns
    );
    for table in [contacts(solution), bodies(solution), probes(solution)] {
        if !table.is_empty() {
            text += "\n";
            text += &table;
        }
    }
    text + "\n" + &certificate(solution)
}

fn contacts(solution: &Solution<2>) -> String {
    if solution.contacts.is_empty() {
        return String::new();
    }
    let rows: Vec<Vec<String>> = solution
        .contacts
        .iter()
        .map(|contact| {
            let open = |s: Status| s == Status::Open;
            let count = |wanted: bool| {
                let nodes = contact.nodes.iter();
                nodes.filter(|n| open(n.status) == wanted).count()
            };
            let pressures = contact.nodes.iter().map(|n| n.pressure);
            vec![
                contact.name.clone(),
                number(contact.resultant[0]),
                number(contact.resultant[1]),
                number(pressures.fold(0.0, f64::max)),
                number(contact.length),
                count(false).to_string(),
                count(true).to_string(),
            ]
        })
        .collect();
    let header = [
        "contact",
        "force x",
        "force y",
        "max pressure",
        "length",
        "closed",
        "open",
    ];
    columns(&header, &rows, 1..7)
}

fn bodies(solution: &Solution<2>) -> String {
    let rows: Vec<Vec<String>> = solution
        .bodies
        .iter()
        .map(|body| {
            let lengths = body.displacement.iter().map(|u| norm(*u));
            let floating: Vec<&str> = body
                .floating_modes
                .iter()
                .map(|mode| mode.description.as_str())
                .collect();
            vec![
                body.name.clone(),
                number(lengths.fold(0.0, f64::max)),
                number(body.von_mises.iter().copied().fold(0.0, f64::max)),
                number(body.reaction[0]),
                number(body.reaction[1]),
                floating.join(", "),
            ]
        })
        .collect();
    let header = [
        "body",
        "max displacement",
        "max von Mises",
        "reaction x",
        "reaction y",
        "floats",
    ];
    columns(&header, &rows, 1..5)
}

fn probes(solution: &Solution<2>) -> String {
    if solution.probes.is_empty() {
        return String::new();
    }
    let rows: Vec<Vec<String>> = solution
        .probes
        .iter()
        .map(|probe| {
            vec![
                probe.name.clone(),
                probe.quantity.clone(),
                number(probe.value),
            ]
        })
        .collect();
    columns(&["probe", "quantity", "value"], &rows, 2..3)
}

/// Two digits: the size of a violation matters, not its digits.
fn short(value: f64) -> String {
    if value == 0.0 {
        return "0".to_string();
    }
    format!("{value:.1e}")
}

/// The verdict, every figure of the certificate, and the time.
pub fn certificate(solution: &Solution<2>) -> String {
    let figures = solution.certificate.figures();
    let rows: Vec<Vec<String>> = figures
        .iter()
        .map(|(name, figure)| {
            vec![
                name.replace('_', " "),
                short(figure.relative),
                short(figure.limit),
                if figure.holds() { "" } else { "VIOLATED" }.to_string(),
            ]
        })
        .collect();
    let table = columns(&["certificate", "relative", "limit", ""], &rows, 1..3);
    let verdict = if solution.converged {
        "converged"
    } else {
        "NOT CONVERGED"
    };
    format!(
        "{table}\n{verdict}: {}, {} iterations, {:.2} s\n",
        solution.solver.method, solution.solver.iterations, solution.seconds.total
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    fn options(method: Method) -> SolverOptions<2> {
        SolverOptions {
            method,
            rho: Some(2.0),
            bolts: Bolts::Points(vec![[1.0, 2.0]]),
            ..SolverOptions::default()
        }
    }

    #[test]
    fn what_belongs_to_the_replaced_method_goes_with_it() {
        let mut replaced = options(Method::Uzawa);
        override_solver(&mut replaced, Some(Method::Newton), None).unwrap();
        assert_eq!(replaced.method, Method::Newton);
        assert_eq!((replaced.rho, replaced.bolts), (None, Bolts::Automatic));

        let mut kept = options(Method::Uzawa);
        override_solver(&mut kept, Some(Method::Gradient), None).unwrap();
        assert_eq!((kept.rho, kept.bolts), (Some(2.0), Bolts::Automatic));

        let mut same = options(Method::Uzawa);
        override_solver(&mut same, None, Some(3.0)).unwrap();
        assert_eq!(same.rho, Some(3.0));
        assert_eq!(same.bolts, Bolts::Points(vec![[1.0, 2.0]]));
    }

    #[test]
    fn a_step_needs_a_method_that_takes_it() {
        for method in [
            Method::Auto,
            Method::Newton,
            Method::Mprgp,
            Method::Accelerated,
        ] {
            assert!(override_solver(&mut options(method), None, Some(1.0)).is_err());
        }
    }
}
