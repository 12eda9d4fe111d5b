//! Friction problems of the literature, solved on the dual layer alone.
//!
//! ```text
//! cargo run --release -p dotyk-bench --bin friction -- FOLDER [--solver newton].. [--limit SECONDS]
//!                                    [--tolerance 1e-8] [--only TEXT] [--siconos RESULTS.csv] [--out DIR]
//! ```
//!
//! Every file of FOLDER that ends in `.dat`, `.dat.gz`, `.hdf5` or `.h5` is read (`text.rs`, `hdf5.rs`), mapped to a
//! dual problem and judged by the scaled error (`problem.rs`); other files are named and left out. HDF5 is read in pure Rust.
//!
//! Each problem runs in a process of its own, on one thread, and is ended when the limit (60 s) is over; the clock begins when
//! the problem is read. A problem is *solved* when its scaled error is at most the tolerance, whatever the solver says.
//!
//! | Verdict | Meaning |
//! |---|---|
//! | solved | the scaled error is at most the tolerance |
//! | inaccurate | the solver says that it converged, the scaled error says otherwise |
//! | failed | the solver says that it did not converge |
//! | limit | its time was over |
//! | ended | the process ended without an answer, as when the memory does not suffice |
//!
//! `--siconos` names the results of `bench/friction/siconos.py` on the same folder: a table (problem, solver, seconds,
//! iterations, scaled, solved) whose solvers join the performance profile (`profile.rs`). `--out` writes `results.csv`
//! and `profile.svg`.

mod condense;
mod hdf5;
mod problem;
mod profile;
mod single;
mod text;

use profile::Times;
use single::{Answer, Facts};
use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode, Stdio};
use std::sync::mpsc::{Receiver, RecvTimeoutError, channel};
use std::time::Duration;

/// First argument of the processes that solve one problem.
const SINGLE: &str = "--single";

/// Seconds within which a problem must be read.
const READING: f64 = 300.0;

struct Arguments {
    folder: PathBuf,
    solvers: Vec<String>,
    limit: f64,
    tolerance: f64,
    only: String,
    peers: Option<PathBuf>,
    out: Option<PathBuf>,
}

/// How a run ended.
#[derive(Debug)]
enum Run {
    /// The file holds no problem.
    Unreadable(String),
    /// The solver gave an answer.
    Answered(Answer),
    /// The time limit was reached.
    Limit,
    /// No answer, with the reason.
    Ended(String),
}

fn main() -> ExitCode {
    let words: Vec<String> = std::env::args().skip(1).collect();
    let result = match words.as_slice() {
        [first, file, solver, tolerance] if first == SINGLE => match tolerance.parse() {
            Ok(tolerance) => single::run(Path::new(file), solver, tolerance),
            Err(_) => Err(format!("{tolerance} is not a number")),
        },
        _ => arguments(words.into_iter()).and_then(|arguments| bench(&arguments)),
    };
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(message) => {
            eprintln!("{message}");
            ExitCode::FAILURE
        }
    }
}

fn arguments(mut words: impl Iterator<Item = String>) -> Result<Arguments, String> {
    let mut folder = None;
    let mut arguments = Arguments {
        folder: PathBuf::new(),
        solvers: Vec::new(),
        limit: 60.0,
        tolerance: 1e-8,
        only: String::new(),
        peers: None,
        out: None,
    };
    while let Some(word) = words.next() {
        if !word.starts_with("--") {
            folder = Some(PathBuf::from(word));
            continue;
        }
        let value = words.next().ok_or(format!("{word} needs a value"))?;
        let number = || {
            let number: Option<f64> = value.parse().ok();
            number
                .filter(|&x| x > 0.0 && x.is_finite())
                .ok_or(format!("{word} needs a number above 0, not {value}"))
        };
        match word.as_str() {
            "--solver" => {
                single::solver(&value, 1e-8)?;
                arguments.solvers.push(value);
            }
            "--limit" => arguments.limit = number()?,
            "--tolerance" => arguments.tolerance = number()?,
            "--only" => arguments.only = value,
            "--siconos" => arguments.peers = Some(PathBuf::from(value)),
            "--out" => arguments.out = Some(PathBuf::from(value)),
            _ => return Err(format!("there is no option {word}")),
        }
    }
    arguments.folder = folder.ok_or("name a folder with friction problems")?;
    if arguments.solvers.is_empty() {
        arguments.solvers.push("newton".to_string());
    }
    Ok(arguments)
}

/// The files of a folder that may be problems, by name.
fn problems(folder: &Path, only: &str) -> Result<Vec<(String, PathBuf)>, String> {
    let list =
        std::fs::read_dir(folder).map_err(|error| format!("{}: {error}", folder.display()))?;
    let mut files: Vec<(String, PathBuf)> = list
        .filter_map(|entry| Some(entry.ok()?.path()))
        .filter_map(|path| Some((single::stem(&path)?, path)))
        .filter(|(name, _)| name.contains(only))
        .collect();
    files.sort();
    if files.is_empty() {
        return Err(format!(
            "{} holds no .dat, .dat.gz, .hdf5 or .h5",
            folder.display()
        ));
    }
    Ok(files)
}

fn bench(arguments: &Arguments) -> Result<(), String> {
    let files = problems(&arguments.folder, &arguments.only)?;
    let mut names: Vec<String> = files.iter().map(|file| file.0.clone()).collect();
    let mut all = Vec::new();
    let mut table = String::from("problem,solver,seconds,iterations,scaled,literature,verdict\n");
    for solver in &arguments.solvers {
        println!(
            "{solver}, tolerance {:.0e} of the scaled error, limit {} s\n{}",
            arguments.tolerance,
            arguments.limit,
            head()
        );
        let mut times: BTreeMap<String, f64> = BTreeMap::new();
        let (mut seconds, mut steps) = (0.0, 0);
        for (name, file) in &files {
            let (facts, run) = in_own_process(file, solver, arguments)?;
            if let Run::Unreadable(reason) = &run {
                println!("{name:<44} left out: {reason}");
                names.retain(|other| other != name);
                continue;
            }
            let verdict = verdict(&run, arguments.tolerance);
            println!("{}", line(name, facts.as_ref(), &run, verdict));
            if let Run::Answered(answer) = &run {
                let _ = writeln!(
                    table,
                    "{name},{solver},{:e},{},{:e},{:e},{verdict}",
                    answer.seconds, answer.iterations, answer.scaled, answer.literature
                );
                if verdict == "solved" {
                    times.insert(name.clone(), answer.seconds);
                    seconds += answer.seconds;
                    steps += answer.iterations;
                }
            } else {
                let _ = writeln!(table, "{name},{solver},,,,,{verdict}");
            }
        }
        println!(
            "{solver}: solved {} of {}, {steps} iterations and {seconds:.2} s on these\n",
            times.len(),
            names.len()
        );
        all.push((solver.clone(), times));
    }
    if let Some(path) = &arguments.peers {
        all.extend(peers(path)?);
    }
    let times: Vec<Times> = all
        .into_iter()
        .map(|(solver, times)| Times {
            solver,
            seconds: names.iter().map(|name| times.get(name).copied()).collect(),
        })
        .collect();
    println!("part of the problems solved within τ times the time of the fastest");
    print!("{}", profile::text(&times));
    if let Some(folder) = &arguments.out {
        let title = format!(
            "{} friction problems, scaled error at most {:.0e}",
            names.len(),
            arguments.tolerance
        );
        let files = [
            ("results.csv", table),
            ("profile.svg", profile::svg(&times, &title)),
        ];
        write_all(folder, &files).map_err(|error| format!("{}: {error}", folder.display()))?;
    }
    Ok(())
}

/// Writes files into a folder, each whole or not at all.
fn write_all(folder: &Path, files: &[(&str, String)]) -> std::io::Result<()> {
    std::fs::create_dir_all(folder)?;
    for (name, text) in files {
        let partial = folder.join(format!("{name}.part"));
        std::fs::write(&partial, text)?;
        std::fs::rename(partial, folder.join(name))?;
    }
    Ok(())
}

fn head() -> String {
    format!(
        "{:<44} {:>3} {:>8} {:>11} {:>9} {:>7} {:>9} {:>8} {:>10}  verdict",
        "problem", "dim", "contacts", "rank/size", "μ", "steps", "seconds", "scaled", "literature"
    )
}

fn line(name: &str, facts: Option<&Facts>, run: &Run, verdict: &str) -> String {
    let mut line = format!("{name:<44} ");
    match facts {
        Some(facts) => {
            let size = facts.dimension * facts.contacts;
            let rank = facts.rank.map_or("-".to_string(), |rank| rank.to_string());
            let (low, high) = facts.friction;
            let friction = if low == high {
                format!("{low:.3}")
            } else {
                format!("{low:.2}..{high:.2}")
            };
            let _ = write!(
                line,
                "{:>3} {:>8} {:>11} {friction:>9} ",
                facts.dimension,
                facts.contacts,
                format!("{rank}/{size}")
            );
        }
        None => line.push_str(&" ".repeat(35)),
    }
    let remark = match run {
        Run::Answered(answer) => {
            let _ = write!(
                line,
                "{:>7} {:>9.4} {:>8.1e} {:>10.1e}  ",
                answer.iterations, answer.seconds, answer.scaled, answer.literature
            );
            answer.complaint.as_deref().unwrap_or("")
        }
        Run::Ended(reason) | Run::Unreadable(reason) => {
            line.push_str(&" ".repeat(39));
            reason
        }
        Run::Limit => {
            line.push_str(&" ".repeat(39));
            ""
        }
    };
    line.push_str(verdict);
    if !remark.is_empty() {
        let short: String = remark.chars().take(60).collect();
        let _ = write!(line, " ({short})");
    }
    line
}

fn verdict(run: &Run, tolerance: f64) -> &'static str {
    match run {
        Run::Answered(answer) if answer.scaled <= tolerance => "solved",
        Run::Answered(answer) if answer.complaint.is_none() => "inaccurate",
        Run::Answered(_) => "failed",
        Run::Limit => "limit",
        Run::Ended(_) | Run::Unreadable(_) => "ended",
    }
}

/// Solves one problem in a process of its own, which is ended when its time is over.
fn in_own_process(
    file: &Path,
    solver: &str,
    arguments: &Arguments,
) -> Result<(Option<Facts>, Run), String> {
    let own = std::env::current_exe().map_err(|error| error.to_string())?;
    let tolerance = arguments.tolerance.to_string();
    let mut child = Command::new(own)
        .arg(SINGLE)
        .arg(file)
        .args([solver, tolerance.as_str()])
        .env("RAYON_NUM_THREADS", "1")
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .map_err(|error| format!("no process for {}: {error}", file.display()))?;
    let lines = lines_of(child.stdout.take());
    let errors = lines_of(child.stderr.take());
    let facts = within(&lines, READING).map(|line| Facts::parse(&line));
    let answer = match facts {
        Ok(Some(_)) => within(&lines, arguments.limit).map(|line| Answer::parse(&line)),
        _ => Ok(None),
    };
    // Errors are ignored: the process may have ended already.
    let _ = child.kill();
    let _ = child.wait();
    let complaint = || {
        let said = errors.iter().last();
        said.unwrap_or_else(|| "without a word".to_string())
    };
    Ok(match (facts, answer) {
        (Ok(Some(facts)), Ok(Some(answer))) => (Some(facts), Run::Answered(answer)),
        (Ok(Some(facts)), Err(RecvTimeoutError::Timeout)) => (Some(facts), Run::Limit),
        (Ok(Some(facts)), _) => (Some(facts), Run::Ended(complaint())),
        (Err(RecvTimeoutError::Timeout), _) => {
            let reason = format!("it was not read within {READING} s");
            (None, Run::Unreadable(reason))
        }
        _ => (None, Run::Unreadable(complaint())),
    })
}

/// The lines of a stream as they come.
fn lines_of(stream: Option<impl std::io::Read + Send + 'static>) -> Receiver<String> {
    let (sender, receiver) = channel();
    if let Some(stream) = stream {
        std::thread::spawn(move || {
            for line in BufReader::new(stream).lines().map_while(Result::ok) {
                if sender.send(line).is_err() {
                    break;
                }
            }
        });
    }
    receiver
}

fn within(lines: &Receiver<String>, seconds: f64) -> Result<String, RecvTimeoutError> {
    lines.recv_timeout(Duration::from_secs_f64(seconds))
}

/// Seconds of each problem that a peer solved.
type Solved = BTreeMap<String, f64>;

/// Results of peers: problem, solver, seconds, iterations, scaled, solved (1 or 0); one line each, after a head.
fn peers(path: &Path) -> Result<Vec<(String, Solved)>, String> {
    let text =
        std::fs::read_to_string(path).map_err(|error| format!("{}: {error}", path.display()))?;
    let mut solvers: Vec<(String, Solved)> = Vec::new();
    for (number, line) in text.lines().enumerate().skip(1) {
        let words: Vec<&str> = line.split(',').collect();
        let [problem, solver, seconds, _, _, solved] = words[..] else {
            return Err(format!(
                "{}, line {}: six columns are expected",
                path.display(),
                number + 1
            ));
        };
        if !solvers.iter().any(|(name, _)| name == solver) {
            solvers.push((solver.to_string(), Solved::new()));
        }
        let Some((_, times)) = solvers.iter_mut().find(|(name, _)| name == solver) else {
            continue;
        };
        if solved == "1" {
            let seconds = seconds.parse().map_err(|_| {
                format!(
                    "{}, line {}: {seconds:?} are no seconds",
                    path.display(),
                    number + 1
                )
            })?;
            times.insert(problem.to_string(), seconds);
        }
    }
    Ok(solvers)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn answered(scaled: f64, complaint: Option<&str>) -> Run {
        Run::Answered(Answer {
            iterations: 3,
            seconds: 0.5,
            scaled,
            literature: 1.0,
            complaint: complaint.map(str::to_string),
        })
    }

    #[test]
    fn the_scaled_error_decides() {
        assert_eq!(verdict(&answered(1e-9, Some("it did not")), 1e-8), "solved");
        assert_eq!(verdict(&answered(1e-7, None), 1e-8), "inaccurate");
        assert_eq!(verdict(&answered(f64::NAN, Some("no")), 1e-8), "failed");
        assert_eq!(verdict(&Run::Limit, 1e-8), "limit");
    }

    #[test]
    fn arguments_are_read() {
        let words = |text: &str| text.split(' ').map(str::to_string).collect::<Vec<_>>();
        let read = |text: &str| arguments(words(text).into_iter());
        let found =
            read("folder --solver mprgp --solver newton --limit 5 --tolerance 1e-6 --out x")
                .unwrap();
        assert_eq!(found.solvers, ["mprgp", "newton"]);
        assert_eq!((found.limit, found.tolerance), (5.0, 1e-6));
        assert_eq!(read("folder").unwrap().solvers, ["newton"]);
        for wrong in [
            "--limit 5",
            "a --limit none",
            "a --solver best",
            "a --fast 1",
            "a --limit",
        ] {
            assert!(read(wrong).is_err(), "{wrong}");
        }
    }

    #[test]
    fn peers_are_read_and_only_what_they_solved_counts() {
        let path = std::env::temp_dir().join(format!("dotyk-peers-{}.csv", std::process::id()));
        let head = "problem,solver,seconds,iterations,scaled,solved\n";
        let text = format!("{head}a,NSGS,0.5,10,1e-9,1\na,PROX,,,,0\nb,NSGS,0.25,3,1e-4,0\n");
        std::fs::write(&path, text).unwrap();
        let solvers = peers(&path).unwrap();
        std::fs::write(&path, "head\na,NSGS,0.5\n").unwrap();
        let message = peers(&path).unwrap_err();
        std::fs::remove_file(&path).unwrap();
        assert_eq!(solvers[0].0, "NSGS");
        assert_eq!(solvers[0].1, Solved::from([("a".to_string(), 0.5)]));
        assert!(solvers[1].1.is_empty());
        assert!(message.contains("line 2"));
    }
}
