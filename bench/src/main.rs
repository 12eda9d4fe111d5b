//! The cost of contact: a case solved with contact, and with its bodies welded together, in one process, in turns.
//!
//! ```text
//! cargo run --release -p dotyk-bench -- [CASE.toml ..] [--repeat N] [--threads N]
//! ```
//!
//! Both sides assemble, order, factor and solve with the same kernels; neither recovers stresses. Turns alternate, so
//! that other load on the machine affects both alike. Seconds are wall time. Peak memory is that of a fresh process:
//! `peak_memory_bytes` in the `summary.json` of `dotyk run`.

mod tied;

use dotyk::case::Case;
use dotyk::model::Seconds;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// Arguments of the command line.
struct Arguments {
    cases: Vec<PathBuf>,
    repeat: usize,
    threads: usize,
}

fn main() -> ExitCode {
    match arguments(std::env::args().skip(1)).and_then(|arguments| compare(&arguments)) {
        Ok(()) => ExitCode::SUCCESS,
        Err(message) => {
            eprintln!("{message}");
            ExitCode::FAILURE
        }
    }
}

fn arguments(mut words: impl Iterator<Item = String>) -> Result<Arguments, String> {
    let (mut cases, mut repeat, mut threads) = (Vec::new(), 15, 0);
    while let Some(word) = words.next() {
        let mut number = || -> Result<usize, String> {
            let value = words
                .next()
                .and_then(|text| text.parse().ok())
                .filter(|&n| n > 0);
            value.ok_or_else(|| format!("{word} needs a number from 1"))
        };
        match word.as_str() {
            "--repeat" => repeat = number()?,
            "--threads" => threads = number()?,
            _ => cases.push(PathBuf::from(word)),
        }
    }
    if cases.is_empty() {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("cases");
        cases = ["tunnel_305.toml", "tunnel_609.toml"]
            .map(|case| folder.join(case))
            .to_vec();
    }
    Ok(Arguments {
        cases,
        repeat,
        threads,
    })
}

fn compare(arguments: &Arguments) -> Result<(), String> {
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(arguments.threads)
        .build();
    let pool = pool.map_err(|error| error.to_string())?;
    for case in &arguments.cases {
        let case = Case::<2>::read(case).map_err(|error| error.to_string())?;
        pool.install(|| compare_case(&case, arguments.repeat))?;
    }
    Ok(())
}

fn compare_case(case: &Case<2>, repeat: usize) -> Result<(), String> {
    let welded = tied::weld(&case.model)?;
    let (mut contact, mut plain) = (Vec::new(), Vec::new());
    let mut head = String::new();
    for _ in 0..repeat {
        let solution = case.model.solve().map_err(|error| error.to_string())?;
        contact.push(solution.seconds);
        head = format!(
            "{}: {} dofs, {} contact unknowns, {} iterations of {}, {} threads, {repeat} repetitions",
            case.stem,
            solution.dofs,
            solution.contact_unknowns,
            solution.solver.iterations,
            solution.solver.method,
            solution.threads
        );
        let (system, displacement, stages) = tied::solve(&welded, case.model.analysis)?;
        let residual = tied::residual(&system, &displacement);
        if residual > 1e-6 {
            return Err(format!(
                "the tied model is not solved: residual {residual:.1e}"
            ));
        }
        plain.push(stages);
    }
    println!("{head}");
    println!("{:<22} {:>9} {:>9}", "milliseconds", "median", "least");
    type Read<T> = fn(&T) -> f64;
    let without_stress: Read<Seconds> =
        |s| s.assemble + s.order + s.factor + s.condense + s.contact;
    let rows: [(&str, Read<Seconds>); 8] = [
        ("assemble", |s| s.assemble),
        ("order", |s| s.order),
        ("factor", |s| s.factor),
        ("condense", |s| s.condense),
        ("contact", |s| s.contact),
        ("recover", |s| s.recover),
        ("contact, all", |s| s.total),
        ("contact, no stresses", without_stress),
    ];
    for (name, read) in rows {
        row(name, &contact.iter().map(read).collect::<Vec<_>>());
    }
    let rows: [(&str, Read<tied::Stages>); 5] = [
        ("tied: assemble", |s| s.assemble),
        ("tied: order", |s| s.order),
        ("tied: factor", |s| s.factor),
        ("tied: solve", |s| s.solve),
        ("tied, all", tied::Stages::total),
    ];
    for (name, read) in rows {
        row(name, &plain.iter().map(read).collect::<Vec<_>>());
    }
    let each: Vec<f64> = contact
        .iter()
        .zip(&plain)
        .map(|(c, t)| without_stress(c) / t.total())
        .collect();
    let least = |values: Vec<f64>| values.into_iter().fold(f64::INFINITY, f64::min);
    let fastest = least(contact.iter().map(without_stress).collect())
        / least(plain.iter().map(tied::Stages::total).collect());
    println!(
        "contact / tied: {:.2} median of the turns, {fastest:.2} fastest against fastest\n",
        median(&each)
    );
    Ok(())
}

fn row(name: &str, seconds: &[f64]) {
    let least = seconds.iter().copied().fold(f64::INFINITY, f64::min);
    println!(
        "{name:<22} {:>9.1} {:>9.1}",
        1e3 * median(seconds),
        1e3 * least
    );
}

fn median(values: &[f64]) -> f64 {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    let middle = sorted.len() / 2;
    if sorted.len() % 2 == 1 {
        sorted[middle]
    } else {
        0.5 * (sorted[middle - 1] + sorted[middle])
    }
}
