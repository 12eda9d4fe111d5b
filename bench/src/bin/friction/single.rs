//! One problem and one solver, in a process of their own.
//!
//! The process prints two lines: the facts of the problem, as soon as it is read, and the answer of the solver. In between only
//! the solver works, so that the parent process can enforce the time limit.

use crate::problem::Problem;
use crate::{hdf5, text};
use dotyk::solve::{
    Accelerated, ContactSolver, Gradient, Mprgp, Newton, Secant, SolveError, Uzawa,
};
use flate2::read::MultiGzDecoder;
use std::io::{Read, Write};
use std::ops::ControlFlow;
use std::path::Path;
use std::time::Instant;

/// Endings of the formats.
const ENDINGS: [&str; 4] = [".dat.gz", ".dat", ".hdf5", ".h5"];

/// Facts of a problem.
#[derive(Debug, Clone, PartialEq)]
pub struct Facts {
    /// Components of a contact.
    pub dimension: usize,
    /// Number of contacts.
    pub contacts: usize,
    /// Numerical rank of W, if computed.
    pub rank: Option<usize>,
    /// Smallest and largest coefficient of friction.
    pub friction: (f64, f64),
}

/// The answer of a solver.
#[derive(Debug, Clone, PartialEq)]
pub struct Answer {
    /// Its iterations.
    pub iterations: usize,
    /// Wall seconds of the solver.
    pub seconds: f64,
    /// Scaled error.
    pub scaled: f64,
    /// Error of the literature.
    pub literature: f64,
    /// Message of the solver if it did not converge.
    pub complaint: Option<String>,
}

/// Name of the file without the ending of its format; `None` for other files.
pub fn stem(path: &Path) -> Option<String> {
    let mut name = path.file_name()?.to_str()?;
    let before = name;
    // Some carry two of them.
    while let Some(shorter) = ENDINGS.iter().find_map(|ending| name.strip_suffix(ending)) {
        name = shorter;
    }
    (name != before).then(|| name.to_string())
}

/// The problem in a file. Errors in words.
pub fn read(path: &Path) -> Result<Problem, String> {
    stem(path).ok_or("its format is none of .dat, .dat.gz, .hdf5, .h5")?;
    let bytes = std::fs::read(path).map_err(|error| error.to_string())?;
    let file = path.to_string_lossy();
    if file.ends_with(".hdf5") || file.ends_with(".h5") {
        let file = hdf5_pure::File::from_bytes(bytes).map_err(|error| error.to_string())?;
        return hdf5::parse(&file);
    }
    let mut text = String::new();
    let read = if file.ends_with(".gz") {
        MultiGzDecoder::new(bytes.as_slice()).read_to_string(&mut text)
    } else {
        bytes.as_slice().read_to_string(&mut text)
    };
    read.map_err(|error| error.to_string())?;
    text::parse(&text)
}

/// The solver of that name with its limits widened, so that the clock decides.
pub fn solver(name: &str, tolerance: f64) -> Result<Box<dyn ContactSolver>, String> {
    Ok(match name {
        "newton" => Box::new(Newton {
            tolerance,
            ..Newton::default()
        }),
        "mprgp" => Box::new(Mprgp {
            tolerance,
            ..Mprgp::default()
        }),
        "gradient" => Box::new(Gradient {
            tolerance,
            ..Gradient::default()
        }),
        "accelerated" => Box::new(Accelerated {
            tolerance,
            ..Accelerated::default()
        }),
        "secant" => Box::new(Secant {
            tolerance,
            ..Secant::default()
        }),
        "uzawa" => Box::new(Uzawa {
            tolerance,
            ..Uzawa::default()
        }),
        _ => {
            return Err(format!(
                "there is no solver {name:?}: newton, mprgp, gradient, accelerated, secant or uzawa"
            ));
        }
    })
}

/// Solves and judges.
pub fn solve(problem: &Problem, solver: &dyn ContactSolver) -> Result<Answer, String> {
    let dual = problem.dual().map_err(|error| error.to_string())?;
    let clock = Instant::now();
    let result = solver.solve(&dual, None, &mut |_| ControlFlow::Continue(()));
    let seconds = clock.elapsed().as_secs_f64();
    let (outcome, complaint) = match result {
        Ok(outcome) => (outcome, None),
        Err(SolveError::NotConverged {
            outcome, reason, ..
        }) => (*outcome, Some(reason)),
        Err(error) => return Err(error.to_string()),
    };
    let forces = &outcome.multipliers.lambda;
    Ok(Answer {
        iterations: outcome.iterations,
        seconds,
        scaled: problem.scaled_error(forces),
        literature: problem.literature_error(forces),
        complaint,
    })
}

impl Facts {
    /// The facts of a problem.
    pub fn of(problem: &Problem) -> Self {
        Self {
            dimension: problem.dimension,
            contacts: problem.friction.len(),
            rank: problem.rank(),
            friction: problem.friction_range(),
        }
    }

    /// The line that a process prints.
    pub fn line(&self) -> String {
        let rank = self.rank.map_or("-".to_string(), |rank| rank.to_string());
        let (low, high) = self.friction;
        format!(
            "facts\t{}\t{}\t{rank}\t{low:e}\t{high:e}",
            self.dimension, self.contacts
        )
    }

    /// From that line.
    pub fn parse(line: &str) -> Option<Self> {
        let words: Vec<&str> = line.strip_prefix("facts\t")?.split('\t').collect();
        let [dimension, contacts, rank, low, high] = words[..] else {
            return None;
        };
        Some(Self {
            dimension: dimension.parse().ok()?,
            contacts: contacts.parse().ok()?,
            rank: rank.parse().ok(),
            friction: (low.parse().ok()?, high.parse().ok()?),
        })
    }
}

impl Answer {
    /// The line that a process prints.
    pub fn line(&self) -> String {
        let Self {
            iterations,
            seconds,
            scaled,
            literature,
            complaint,
        } = self;
        let complaint = complaint
            .as_deref()
            .unwrap_or("")
            .replace(['\t', '\n'], " ");
        format!("answer\t{iterations}\t{seconds:e}\t{scaled:e}\t{literature:e}\t{complaint}")
    }

    /// From that line.
    pub fn parse(line: &str) -> Option<Self> {
        let words: Vec<&str> = line.strip_prefix("answer\t")?.split('\t').collect();
        let [iterations, seconds, scaled, literature, complaint] = words[..] else {
            return None;
        };
        Some(Self {
            iterations: iterations.parse().ok()?,
            seconds: seconds.parse().ok()?,
            scaled: scaled.parse().ok()?,
            literature: literature.parse().ok()?,
            complaint: (!complaint.is_empty()).then(|| complaint.to_string()),
        })
    }
}

/// The work of the process: reads, prints the facts, solves, prints the answer. Errors in words.
pub fn run(path: &Path, name: &str, tolerance: f64) -> Result<(), String> {
    let solver = solver(name, tolerance)?;
    let problem = read(path)?;
    println!("{}", Facts::of(&problem).line());
    std::io::stdout()
        .flush()
        .map_err(|error| error.to_string())?;
    println!("{}", solve(&problem, solver.as_ref())?.line());
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_carry_everything() {
        let facts = Facts {
            dimension: 3,
            contacts: 12,
            rank: None,
            friction: (0.1, 0.7),
        };
        assert_eq!(Facts::parse(&facts.line()), Some(facts.clone()));
        let ranked = Facts {
            rank: Some(7),
            ..facts
        };
        assert_eq!(Facts::parse(&ranked.line()), Some(ranked));
        let answer = Answer {
            iterations: 5,
            seconds: 1.25e-3,
            scaled: 3e-11,
            literature: f64::INFINITY,
            complaint: Some("two words".to_string()),
        };
        assert_eq!(Answer::parse(&answer.line()), Some(answer.clone()));
        assert_eq!(
            Answer::parse(&Facts::line(&Facts::parse("facts\t2\t1\t-\t0\t1").unwrap())),
            None
        );
    }

    #[test]
    fn endings_of_formats_are_no_part_of_a_name() {
        let named = |file: &str| stem(Path::new(file));
        assert_eq!(named("folder/a.b.dat.gz"), Some("a.b".to_string()));
        assert_eq!(named("tower-4.hdf5.dat.gz"), Some("tower-4".to_string()));
        assert_eq!(named("README.md"), None);
    }

    #[test]
    fn compressed_and_plain_files_are_the_same() {
        let folder = std::env::temp_dir().join(format!("dotyk-friction-{}", std::process::id()));
        std::fs::create_dir_all(&folder).unwrap();
        let text = "2 1 0 2 2 2 2 1 0 0 1 -1 0.25 .5";
        std::fs::write(folder.join("a.dat"), text).unwrap();
        let file = std::fs::File::create(folder.join("b.dat.gz")).unwrap();
        let mut encoder = flate2::write::GzEncoder::new(file, flate2::Compression::fast());
        encoder.write_all(text.as_bytes()).unwrap();
        encoder.finish().unwrap();
        let plain = read(&folder.join("a.dat")).unwrap();
        let compressed = read(&folder.join("b.dat.gz")).unwrap();
        assert_eq!(plain.free, compressed.free);
        let answer = solve(&plain, solver("newton", 1e-8).unwrap().as_ref()).unwrap();
        assert!(answer.scaled < 1e-14 && answer.complaint.is_none());
        std::fs::remove_dir_all(&folder).unwrap();
    }
}
