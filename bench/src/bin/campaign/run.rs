//! The campaign itself: seeds on threads, each solved, judged, and solved again.

use crate::check::check;
use crate::dimension::Dimension;
use crate::judgement::Finding;
use crate::problem::{Known, Problem};
use crate::random::Random;
use crate::raw::{Answer, Step};
use crate::report::Report;
use crate::solve::{Folder, Outcome, solve, write_meshes};
use crate::state::State;
use crate::twin::difference;
use crate::twins::unique;
use crate::vector::{length, minus};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Instant;

/// The options of the command line.
pub struct Options {
    /// Each with its family, unless the seed chooses it or one family is given for all.
    pub seeds: Vec<(u64, Option<&'static str>)>,
    pub threads: usize,
    pub family: Option<String>,
    /// Seeds choose among the later families.
    pub more: bool,
    /// Bodies are cut into 2 to 6 pieces, as the seed says.
    pub pieces: bool,
    /// Folder for the case files of failing seeds, and of all that are shown.
    pub keep: Option<PathBuf>,
    /// Part of the seeds that is solved again as an equivalent problem.
    pub twins: f64,
    /// The other method, with which a part of the frictionless seeds is solved.
    pub method: String,
    /// Print the margins of all checks.
    pub margins: bool,
    /// Print case and findings.
    pub show: bool,
    /// Seconds after which a run is stopped.
    pub limit: f64,
    /// A missing answer is a failure, too.
    pub answered: bool,
}

/// The verdict on a seed.
#[derive(Debug, Clone, PartialEq)]
pub enum Verdict {
    Right,
    Wrong,
    /// The contacts cannot hold the load by statics, and the program gives no answer.
    RightlyRefused,
    NotConverged,
    Refused,
    Panicked,
    /// Stopped at the limit of time.
    Slow,
}

/// One seed.
pub struct Result {
    pub seed: u64,
    pub family: &'static str,
    pub known: Known,
    pub rough: bool,
    pub coulomb: bool,
    pub verdict: Verdict,
    /// The worst finding, or the message of the program.
    pub message: String,
    /// Kind of the worst finding.
    pub what: &'static str,
    /// The program warned that it dropped conditions.
    pub dropped: bool,
    pub iterations: Vec<usize>,
    /// The stage of the solver that gave the answer, for each step.
    pub answered: Vec<&'static str>,
    pub margins: BTreeMap<&'static str, f64>,
    /// Name of the twin with the difference of its answer, if that is not a finding.
    pub twin: Option<(&'static str, f64)>,
    /// Difference of the contact forces of another method; NaN if that method did not converge.
    pub method: Option<f64>,
    pub dofs: usize,
    pub seconds: f64,
}

/// Runs all seeds; whether every answer is right, and with `answered` none is missing.
pub fn run<const D: usize>(options: &Options) -> std::result::Result<bool, String>
where
    Problem<D>: Dimension<D>,
{
    let families = Problem::families();
    if let Some(name) = options.family.as_deref().filter(|n| !families.contains(n)) {
        let known = families.join(", ");
        return Err(format!("no family {name}; there are {known}"));
    }
    if let Some(folder) = &options.keep {
        std::fs::create_dir_all(folder).map_err(|error| error.to_string())?;
    }
    // a panic is a result, which the report counts
    std::panic::set_hook(Box::new(|_| {}));
    let next = AtomicUsize::new(0);
    let results = Mutex::new(Vec::new());
    let clock = Instant::now();
    std::thread::scope(|scope| {
        for _ in 0..options.threads {
            scope.spawn(|| {
                let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build();
                loop {
                    let place = next.fetch_add(1, Ordering::Relaxed);
                    let Some(&(seed, family)) = options.seeds.get(place) else {
                        break;
                    };
                    let result = match &pool {
                        Ok(pool) => pool.install(|| one::<D>(seed, family, options)),
                        Err(_) => one::<D>(seed, family, options),
                    };
                    if let Ok(mut results) = results.lock() {
                        results.push(result);
                    }
                }
            });
        }
    });
    let mut results = results.into_inner().map_err(|error| error.to_string())?;
    results.sort_by_key(|result: &Result| result.seed);
    let report = Report::new(&results, clock.elapsed().as_secs_f64(), &options.method);
    report.print(options.margins);
    Ok(report.clean(options.answered))
}

fn one<const D: usize>(seed: u64, family: Option<&str>, options: &Options) -> Result
where
    Problem<D>: Dimension<D>,
{
    let mut problem = Problem::of_seed(seed, family.or(options.family.as_deref()), options.more);
    problem.subdomains = options.pieces.then_some(2 + seed % 5);
    let known = problem.known;
    let clock = Instant::now();
    let mut result = Result {
        seed,
        family: problem.family,
        known,
        rough: problem.rough(),
        coulomb: problem.coulomb(),
        verdict: Verdict::Right,
        message: String::new(),
        what: "",
        dropped: false,
        iterations: Vec::new(),
        answered: Vec::new(),
        margins: BTreeMap::new(),
        twin: None,
        method: None,
        dofs: 0,
        seconds: 0.0,
    };
    let folder = match Folder::new(&format!("{seed}")) {
        Ok(folder) => folder,
        Err(error) => {
            result.verdict = Verdict::Refused;
            result.message = error.to_string();
            return result;
        }
    };
    let mut kept = vec![problem.clone()];
    if options.show {
        println!("{}", problem.text());
        println!("# known: {:?}, {}", known, problem.reason);
    }
    judge(&problem, &folder, seed, options, &mut result, &mut kept);
    result.seconds = clock.elapsed().as_secs_f64();
    if options.show {
        for twin in &kept[1..] {
            println!("# twin\n{}", twin.text());
        }
        println!("# {:?} {}", result.verdict, result.message);
    }
    let bad = matches!(result.verdict, Verdict::Wrong | Verdict::Panicked)
        || (known == Known::Holds && result.verdict != Verdict::Right);
    if let (true, Some(folder)) = (bad || options.show, &options.keep) {
        for (index, problem) in kept.iter().enumerate() {
            if let Err(error) = keep(problem, folder, seed, index) {
                result.message += &format!(" (not kept: {error})");
            }
        }
    }
    result
}

fn keep<const D: usize>(
    problem: &Problem<D>,
    folder: &Path,
    seed: u64,
    index: usize,
) -> std::io::Result<()> {
    let name = match index {
        0 => format!("{seed}_{}", problem.family),
        _ => format!("{seed}_{}_twin", problem.family),
    };
    let own = folder.join(name);
    std::fs::create_dir_all(&own)?;
    write_meshes(problem, &own)?;
    std::fs::write(own.join("case.toml"), problem.text())
}

fn judge<const D: usize>(
    problem: &Problem<D>,
    folder: &Folder,
    seed: u64,
    options: &Options,
    result: &mut Result,
    kept: &mut Vec<Problem<D>>,
) where
    Problem<D>: Dimension<D>,
{
    let known = problem.known;
    let answer = match solve(problem, folder, options.limit) {
        Outcome::Slow => {
            result.verdict = Verdict::Slow;
            result.message = format!("stopped after {} s", options.limit);
            return;
        }
        Outcome::Panicked(message) => {
            (result.verdict, result.message) = (Verdict::Panicked, message);
            return;
        }
        Outcome::Refused(message) => {
            result.verdict = if known == Known::Falls {
                Verdict::RightlyRefused
            } else {
                Verdict::Refused
            };
            result.message = message;
            return;
        }
        Outcome::NotConverged(message, steps) => {
            result.verdict = if known == Known::Falls {
                Verdict::RightlyRefused
            } else {
                Verdict::NotConverged
            };
            result.message = message;
            // the steps before are certified nevertheless
            if let Some(answer) = steps {
                look(problem, &answer, result);
            }
            return;
        }
        Outcome::Certified(answer) => answer,
    };
    look(problem, &answer, result);
    if options.show {
        show_rows(problem, &answer);
    }
    if known == Known::Falls && result.verdict == Verdict::Right {
        wrong(
            result,
            "held",
            format!("cannot be held: {}", problem.reason),
        );
    }
    if result.verdict != Verdict::Right {
        return;
    }
    let mut random = Random::new(seed ^ 0x7717);
    if random.chance(options.twins) || problem.other.is_some() {
        ask_twins(
            problem,
            &answer,
            (folder, options.limit, options.show),
            &mut random,
            result,
            kept,
        );
    }
    if !problem.rough() && result.dofs < 4000 && random.chance(2.0 * options.twins) {
        other_method(problem, &answer, (folder, options), result);
    }
}

fn look<const D: usize>(problem: &Problem<D>, answer: &Answer<D>, result: &mut Result)
where
    Problem<D>: Dimension<D>,
{
    result.dofs = answer.meshes.iter().map(|m| D * m.points.len()).sum();
    result.iterations = answer.steps.iter().map(|s| s.iterations).collect();
    let last = |step: &Step<D>| step.tried.last().copied().unwrap_or("no stage");
    result.answered = answer.steps.iter().map(last).collect();
    result.dropped = answer.steps.iter().any(|s| s.dropped);
    let judgement = check(problem, answer);
    if let Some(Finding {
        step,
        what,
        place,
        times,
    }) = judgement.worst()
    {
        let mut others: BTreeMap<&str, f64> = BTreeMap::new();
        for finding in judgement.findings.iter().filter(|f| f.what != *what) {
            let most = others.entry(finding.what).or_insert(0.0);
            *most = most.max(finding.times);
        }
        let others: Vec<String> = others
            .iter()
            .map(|(what, times)| format!("{what} {times:.1e}x"))
            .collect();
        let others = match others.len() {
            0 => String::new(),
            _ => format!("; also {}", others.join(", ")),
        };
        let dropped = match result.dropped {
            true => " (the program dropped conditions)",
            false => "",
        };
        let text =
            format!("{what} {times:.1e} times its limit, step {step}, {place}{others}{dropped}");
        wrong(result, what, text);
    }
    result.margins = judgement.margins;
}

fn wrong(result: &mut Result, what: &'static str, message: String) {
    result.verdict = Verdict::Wrong;
    (result.what, result.message) = (what, message);
}

fn ask_twins<const D: usize>(
    problem: &Problem<D>,
    answer: &Answer<D>,
    (folder, limit, show): (&Folder, f64, bool),
    random: &mut Random,
    result: &mut Result,
    kept: &mut Vec<Problem<D>>,
) where
    Problem<D>: Dimension<D>,
{
    for twin in problem.twins(answer, random) {
        kept.truncate(1);
        kept.push(twin.problem.clone());
        let other = match solve(&twin.problem, folder, limit) {
            Outcome::Certified(other) => other,
            Outcome::Slow => continue,
            Outcome::Panicked(message) => {
                (result.verdict, result.message) = (Verdict::Panicked, message);
                return;
            }
            Outcome::NotConverged(message, _) | Outcome::Refused(message) => {
                let text = format!("twin `{}` has no answer: {message}", twin.name);
                result.twin = Some((twin.name, f64::NAN));
                result.message = text;
                continue;
            }
        };
        let judgement = check(&twin.problem, &other);
        if show {
            println!("# twin `{}`", twin.name);
            show_rows(&twin.problem, &other);
        }
        if let Some(finding) = judgement.worst() {
            let text = format!(
                "twin `{}`: {} {:.1e} times its limit, step {}, {}",
                twin.name, finding.what, finding.times, finding.step, finding.place
            );
            wrong(result, finding.what, text);
            return;
        }
        let Some(off) = difference(problem, answer, &twin, &other) else {
            wrong(
                result,
                "twin",
                format!("twin `{}` has other nodes", twin.name),
            );
            return;
        };
        let unique = unique(problem, answer, twin.name);
        if off > twin.tolerance && unique {
            let text = format!(
                "twin `{}` differs by {off:.1e} of the largest displacement",
                twin.name
            );
            wrong(result, "twin", text);
            return;
        }
        result.twin = Some((twin.name, off));
    }
}

/// Judges the answer of another method, and takes the largest difference of the nodal contact forces, relative to the force
/// scale.
fn other_method<const D: usize>(
    problem: &Problem<D>,
    answer: &Answer<D>,
    (folder, options): (&Folder, &Options),
    result: &mut Result,
) where
    Problem<D>: Dimension<D>,
{
    let again = Problem {
        method: options.method.clone(),
        ..problem.clone()
    };
    let Outcome::Certified(other) = solve(&again, folder, options.limit) else {
        result.method = Some(f64::NAN);
        return;
    };
    if let Some(finding) = check(problem, &other).worst() {
        let text = format!(
            "method `{}`: {} {:.1e} times its limit, step {}, {}",
            options.method, finding.what, finding.times, finding.step, finding.place
        );
        wrong(result, finding.what, text);
        return;
    }
    let mut worst: f64 = 0.0;
    for (a, b) in answer.steps.iter().zip(&other.steps) {
        let mine = State::new(problem, answer, a);
        let theirs = State::new(problem, &other, b);
        let all = mine.rest.iter().flatten().zip(theirs.rest.iter().flatten());
        for (a, b) in all {
            if mine.force > 0.0 {
                worst = worst.max(length(minus(*a, *b)) / mine.force);
            }
        }
    }
    result.method = Some(worst);
}

/// Prints the rows of all contacts.
fn show_rows<const D: usize>(problem: &Problem<D>, answer: &Answer<D>) {
    for (index, step) in answer.steps.iter().enumerate() {
        for (contact, raw) in problem.contacts.iter().zip(&step.contacts) {
            println!("# step {} contact {}", index + 1, contact.name);
            for row in &raw.rows {
                println!(
                    "#   {:>5} {:>13.6e} n {:>9.2e} weight {:>10.3e} gap {:>11.3e} pressure {:>11.3e} shear {:>11.3e} slip {:>11.3e} {:?}",
                    row.node,
                    List(&answer.meshes[raw.nonmortar.0].points[row.node]),
                    List(&row.normal),
                    row.weight,
                    row.gap,
                    row.pressure,
                    List(&row.shear),
                    List(&row.slip),
                    row.status
                );
            }
        }
    }
}

/// Numbers in brackets, each with the width and precision that is asked for.
struct List<'a>(&'a [f64]);

impl std::fmt::LowerExp for List<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        for (place, number) in self.0.iter().enumerate() {
            f.write_str(if place == 0 { "(" } else { ", " })?;
            number.fmt(f)?;
        }
        f.write_str(")")
    }
}
