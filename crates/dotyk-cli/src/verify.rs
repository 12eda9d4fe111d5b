//! `dotyk verify`: every case of a folder against its reference values.

use crate::Outcome;
use crate::book::{self, Book, Found, Picture};
use crate::failure::{Failure, warn};
use crate::progress::Count;
use crate::text::{colours, columns, number, print, red, vector};
use dotyk::case::{AnyCase, CaseError, Criterion, Reference, References, Run, Verdict};
use dotyk::dual::Certificate;
use dotyk::model::{ProbeValue, Solution};
use dotyk::output::{self, Record};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::mpsc::{Sender, channel};
use std::thread;

/// Arguments of `dotyk verify`.
#[derive(clap::Args)]
pub struct Arguments {
    /// Folders of cases [default: all folders in cases/]
    #[arg(value_name = "CASE_DIR")]
    folders: Vec<PathBuf>,
    /// Write a page of Markdown for every folder into this one, with pictures, values and verdicts
    #[arg(long, value_name = "DIR")]
    book: Option<PathBuf>,
    /// Write the summary.json of every case that has an answer into this folder, as FOLDER/CASE.json
    #[arg(long, value_name = "DIR")]
    summaries: Option<PathBuf>,
    /// No progress
    #[arg(long)]
    quiet: bool,
}

const REFERENCE_FILE: &str = "reference.toml";

/// A folder, read and checked.
pub struct Folder {
    pub path: PathBuf,
    /// File names and cases.
    pub cases: Vec<(String, AnyCase)>,
    references: Option<References>,
}

/// Counts of the results, in a folder or over all of them.
#[derive(Default)]
pub struct Tally {
    pub cases: usize,
    pub certified: usize,
    pub within: usize,
    pub outside: usize,
    pub known: usize,
    pub shown: usize,
    refused: bool,
}

impl Tally {
    fn count(&mut self, verdict: Verdict) {
        match verdict {
            Verdict::Within => self.within += 1,
            Verdict::Outside | Verdict::Unexpected => self.outside += 1,
            Verdict::Known => self.known += 1,
            Verdict::NotJudged => self.shown += 1,
        }
    }

    fn add(&mut self, other: &Self) {
        self.cases += other.cases;
        self.certified += other.certified;
        self.within += other.within;
        self.outside += other.outside;
        self.known += other.known;
        self.shown += other.shown;
        self.refused |= other.refused;
    }

    /// All of it in a line.
    fn summary(&self) -> String {
        format!(
            "{} of {} cases certified; of {} reference values {} within, {} outside, {} outside for a known reason, {} not judged\n",
            self.certified,
            self.cases,
            self.within + self.outside + self.known + self.shown,
            self.within,
            self.outside,
            self.known,
            self.shown
        )
    }
}

/// Reads everything, then solves everything: a mistake in the last folder shows before the first minute is spent. Output
/// follows the order of the folders.
pub fn verify(arguments: &Arguments) -> Result<Outcome, Failure> {
    let folders = match arguments.folders.as_slice() {
        [] => default_folders()?,
        given => given.to_vec(),
    };
    let folders = folders.iter().map(|path| read_folder(path));
    let folders = folders.collect::<Result<Vec<_>, _>>()?;
    let summaries = arguments.summaries.as_deref();
    if summaries.is_some() {
        book::names_of(&folders)?;
    }
    let book = arguments.book.as_deref();
    let mut book = book.map(|dir| Book::new(dir, &folders)).transpose()?;
    let mut tally = Tally::default();
    let count = Count::new(folders.iter().map(|f| f.cases.len()).sum(), arguments.quiet);
    let solved = solve_all(&folders, book.is_some(), &count, |folder, answers| {
        let own = count.aside(|| verify_folder(folder, answers, book.as_mut(), summaries));
        tally.add(&own?);
        Ok(())
    });
    count.finish();
    solved?;
    print(&tally.summary())?;
    if let Some(book) = book {
        book.close(&tally.summary())?;
    }
    if tally.refused {
        return Err(Failure::Message(
            "not every case could be solved".to_string(),
        ));
    }
    let verified = tally.certified == tally.cases && tally.outside == 0;
    Ok(if verified {
        Outcome::Done
    } else {
        Outcome::Unsatisfied
    })
}

/// The folders in `cases/` of the working directory that hold a case.
fn default_folders() -> Result<Vec<PathBuf>, Failure> {
    let root = Path::new("cases");
    if !root.is_dir() {
        let message = "there is no such folder here; name the folders of cases to verify";
        return Err(Failure::of(root, message));
    }
    let mut folders = Vec::new();
    for path in entries(root)? {
        if path.is_dir() && !case_files(&path)?.is_empty() {
            folders.push(path);
        }
    }
    if folders.is_empty() {
        return Err(Failure::of(root, "there is no folder with a case in it"));
    }
    Ok(folders)
}

/// The entries of a folder, sorted by name.
fn entries(folder: &Path) -> Result<Vec<PathBuf>, Failure> {
    let refused = |e| Failure::of(folder, e);
    let list = std::fs::read_dir(folder).map_err(refused)?;
    let paths = list.map(|entry| entry.map(|e| e.path()));
    let mut paths = paths.collect::<Result<Vec<_>, _>>().map_err(refused)?;
    paths.sort();
    Ok(paths)
}

fn case_files(folder: &Path) -> Result<Vec<PathBuf>, Failure> {
    let mut files = entries(folder)?;
    files.retain(|path| {
        let toml = path.extension().is_some_and(|e| e == "toml");
        toml && path.is_file() && path.file_name().is_some_and(|n| n != REFERENCE_FILE)
    });
    Ok(files)
}

fn read_folder(path: &Path) -> Result<Folder, Failure> {
    if !path.is_dir() {
        let message = if path.exists() {
            "is a file; name the folder of the case"
        } else {
            "there is no such folder"
        };
        return Err(Failure::of(path, message));
    }
    let mut cases = Vec::new();
    for file in case_files(path)? {
        let name = file.file_name().unwrap_or_default();
        cases.push((
            name.to_string_lossy().into_owned(),
            AnyCase::read_with(&file, &[])?,
        ));
    }
    if cases.is_empty() {
        return Err(Failure::of(path, "there is no case file in the folder"));
    }
    let file = path.join(REFERENCE_FILE);
    let references = file.exists().then(|| References::read(&file)).transpose()?;
    if let Some(references) = &references {
        let case = |name: &str| cases.iter().find(|(n, _)| n == name);
        references.check(|name| case(name).map(|(_, case)| case))?;
    }
    Ok(Folder {
        path: path.to_path_buf(),
        cases,
        references,
    })
}

/// The part of a run that is compared, in either dimension.
pub struct Solved {
    /// The load steps that have an answer, and the last iterate of one that did not converge.
    pub steps: Vec<Step>,
    /// Number of load steps of the case.
    count: usize,
    certified: bool,
    /// Method, iterations, time and bolts.
    words: String,
    /// Content of `summary.json`, if every step has an answer.
    summary: Option<String>,
    /// Pictures for the book, if requested.
    pub pictures: Vec<Picture>,
}

/// A load step.
pub struct Step {
    converged: bool,
    pub certificate: Certificate,
    probes: Vec<ProbeValue>,
}

impl Solved {
    /// The compared part of a run, with its summary and these pictures of it.
    fn of<const D: usize>(run: Run<D>, summary: Option<String>, pictures: Vec<Picture>) -> Self {
        let (words, certified) = (words(&run), run.certified());
        let steps = run.steps.into_iter().map(|step| Step {
            converged: step.converged,
            certificate: step.certificate,
            probes: step.probes,
        });
        Self {
            steps: steps.collect(),
            count: run.count,
            certified,
            words,
            summary,
            pictures,
        }
    }
}

/// Method, iterations, time and bolts.
fn words<const D: usize>(run: &Run<D>) -> String {
    let Some(last) = run.steps.last() else {
        return String::new();
    };
    let steps = match run.count {
        1 => String::new(),
        count => format!("{count} steps, "),
    };
    format!(
        "{steps}{}, {} iterations, {:.2} s{}",
        last.solver.method,
        run.iterations(),
        last.seconds.total,
        bolts(last)
    )
}

/// The result of a case.
struct Answer {
    /// `None` if the case was refused.
    solved: Option<Solved>,
    told: Told,
}

/// Messages about a case for standard error.
enum Told {
    Warnings(Vec<String>),
    Refusal(CaseError),
}

impl Told {
    fn print(self) {
        match self {
            Self::Warnings(warnings) => warn(&warnings),
            Self::Refusal(error) => Failure::from(error).print(),
        }
    }
}

/// Most cases that are solved side by side: each of them may use all free memory.
const TOGETHER: usize = 4;

/// Solves the cases of all folders, several side by side, and passes the answers of each folder to `take`, in the order of the folders.
fn solve_all(
    folders: &[Folder],
    pictured: bool,
    count: &Count,
    mut take: impl FnMut(&Folder, Vec<Answer>) -> Result<(), Failure>,
) -> Result<(), Failure> {
    let cases = folders.iter().enumerate();
    let cases = cases.flat_map(|(k, folder)| (0..folder.cases.len()).map(move |case| (k, case)));
    let cases: Vec<(usize, usize)> = cases.collect();
    let next = AtomicUsize::new(0);
    let (sender, receiver) = channel();
    let work = |sender: Sender<(usize, usize, Answer)>| {
        while let Some(&(k, case)) = cases.get(next.fetch_add(1, Ordering::Relaxed)) {
            let folder = &folders[k];
            let (name, read) = &folder.cases[case];
            let drawn = pictured && book::pictured(folder).as_ref() == Some(name);
            let answer = solve(&folder.path.join(name), read, drawn);
            count.one_more();
            if sender.send((k, case, answer)).is_err() {
                // the receiver has ended
                break;
            }
        }
    };
    thread::scope(|scope| {
        // threads of the pool would begin another case while they wait for a part of one
        for _ in 0..TOGETHER.min(rayon::current_num_threads()) {
            let thread = thread::Builder::new().stack_size(crate::STACK);
            let sender = sender.clone();
            let started = thread.spawn_scoped(scope, || work(sender));
            started.map_err(|e| Failure::Message(format!("cannot start a thread: {e}")))?;
        }
        // only the threads keep senders: the channel closes when they end
        drop(sender);
        let own = |folder: &Folder| folder.cases.iter().map(|_| None).collect();
        let mut answers: Vec<Vec<Option<Answer>>> = folders.iter().map(own).collect();
        for (k, folder) in folders.iter().enumerate() {
            while answers[k].iter().any(Option::is_none) {
                let Ok((k, case, answer)) = receiver.recv() else {
                    return Err(Failure::Message(
                        "a case was not solved to its end".to_string(),
                    ));
                };
                answers[k][case] = Some(answer);
            }
            take(folder, answers[k].drain(..).flatten().collect())?;
        }
        Ok(())
    })
}

/// Judges the answers of a folder, prints its table, values outside in red, and writes its page and its summaries.
fn verify_folder(
    folder: &Folder,
    answers: Vec<Answer>,
    book: Option<&mut Book>,
    summaries: Option<&Path>,
) -> Result<Tally, Failure> {
    let mut tally = Tally::default();
    let mut text = format!("{}\n", folder.path.display());
    let mut solved: Vec<Option<Solved>> = Vec::new();
    for ((name, _), answer) in folder.cases.iter().zip(answers) {
        tally.cases += 1;
        answer.told.print();
        text += &match &answer.solved {
            Some(s) if s.certified => format!("  {name}: certified, {}\n", s.words),
            _ => format!("  {name}: NOT CERTIFIED\n"),
        };
        match &answer.solved {
            Some(s) => tally.certified += usize::from(s.certified),
            None => tally.refused = true,
        }
        solved.push(answer.solved);
    }
    let of = |name: &str| {
        let place = folder.cases.iter().position(|(n, _)| *n == name);
        place.and_then(|place| solved[place].as_ref())
    };
    let references = folder.references.iter();
    let judged = references.flat_map(|references| {
        references.values.iter().map(|reference| {
            let other = reference.against.as_deref().map(of);
            let judged = judged(reference, of(&reference.case), other);
            if judged.verdict == Verdict::Unexpected {
                Failure::from(references.unexpected(reference)).print();
            }
            judged
        })
    });
    let judged: Vec<Judged<'_>> = judged.collect();
    for value in &judged {
        tally.count(value.verdict);
    }
    print(&(text + &table(&judged) + "\n"))?;
    if let Some(dir) = summaries {
        write_summaries(folder, &solved, dir)?;
    }
    if let Some(book) = book {
        book.put(&Found {
            folder,
            solved: &solved,
            judged: &judged,
            tally: &tally,
        })?;
    }
    Ok(tally)
}

/// Writes the summaries of a folder into a folder of the same name.
fn write_summaries(folder: &Folder, solved: &[Option<Solved>], dir: &Path) -> Result<(), Failure> {
    let of_summaries = |e: output::Error| Failure::of_files(&e, "--summaries");
    let held = output::Folder::hold(&dir.join(book::name_of(&folder.path)?));
    let stage = held.and_then(|held| output::Stage::open(&held));
    let mut stage = stage.map_err(of_summaries)?;
    for ((name, _), solved) in folder.cases.iter().zip(solved) {
        let summary = solved.as_ref().and_then(|solved| solved.summary.as_ref());
        if let Some(text) = summary {
            let name = Path::new(name).with_extension("json");
            let put = stage.put(&name.display().to_string(), text.as_bytes());
            put.map_err(of_summaries)?;
        }
    }
    stage.commit(&[]).map_err(of_summaries)?;
    Ok(())
}

/// The table of a folder, values outside in red.
fn table(judged: &[Judged<'_>]) -> String {
    if judged.is_empty() {
        return String::new();
    }
    let header = [
        "case",
        "probe",
        "kind",
        "reference",
        "computed",
        "difference",
        "verdict",
    ];
    let rows: Vec<_> = judged.iter().map(|value| value.row().to_vec()).collect();
    let table = columns(&header, &rows, 4..6);
    let shown = colours(&std::io::stdout());
    let agrees = |verdict: Verdict| matches!(verdict, Verdict::Within | Verdict::NotJudged);
    let reds = judged.iter().map(|value| shown && !agrees(value.verdict));
    let lines = table.lines().zip(std::iter::once(false).chain(reds));
    lines
        .map(|(line, is_red)| red(line, is_red) + "\n")
        .collect()
}

/// The load steps as far as they were solved, with pictures if requested.
fn solve(path: &Path, case: &AnyCase, drawn: bool) -> Answer {
    of_any!(case, |case| {
        let run = case.run(&[], &mut |_| ());
        let refusal = run.failure.as_ref().and_then(|f| f.refusal.clone());
        if let Some(error) = refusal {
            return Answer {
                solved: None,
                told: Told::Refusal(error),
            };
        }
        let warnings = match run.certified() {
            true => run.warnings(),
            false => Vec::new(),
        };
        let warnings = warnings.iter().map(|w| format!("{}: {w}", path.display()));
        let told = Told::Warnings(warnings.collect());
        let record = Record::of(&case.model, run.standing(), &case.stem);
        let figures = match drawn {
            true => record.figures(),
            false => Vec::new(),
        };
        let pictures = figures.into_iter().filter_map(Picture::of).collect();
        let summary = run.certified().then(|| record.summary().ok()).flatten();
        Answer {
            solved: Some(Solved::of(run, summary, pictures)),
            told,
        }
    })
}

/// The bolts of the p,A-algorithm with their forces: compression in each shows that the choice was proper.
fn bolts<const D: usize>(solution: &Solution<D>) -> String {
    let words = solution.solver.bolts.iter().map(|bolt| {
        let kind = if bolt.force < 0.0 {
            "tension: improper, moved"
        } else {
            "compression: proper"
        };
        format!(
            ", bolt at {} with force {} ({kind})",
            vector(&bolt.point),
            number(bolt.force)
        )
    });
    words.collect()
}

fn judged_step<'s>(reference: &Reference, solved: Option<&'s Solved>) -> Option<&'s Step> {
    solved.and_then(|s| reference.of(&s.steps, s.count))
}

/// A reference value beside the computed one, in words.
pub struct Judged<'a> {
    pub reference: &'a Reference,
    label: String,
    /// The reference value with its band or tolerance.
    expected: String,
    computed: f64,
    difference: String,
    verdict: Verdict,
}

impl Judged<'_> {
    /// One line of the table.
    pub fn row(&self) -> [String; 7] {
        let reason = self.reference.known.as_deref().unwrap_or_default();
        let known = match self.verdict {
            Verdict::Known => format!(": {reason}"),
            _ => String::new(),
        };
        [
            self.reference.case.clone(),
            self.label.clone(),
            self.reference.kind.name().to_string(),
            self.expected.clone(),
            number(self.computed),
            self.difference.clone(),
            self.verdict.name().to_string() + &known,
        ]
    }
}

/// Judges one value; `other` is the case that a percentage refers to, if the reference is one.
/// An answer that is not certified is outside every band.
fn judged<'a>(
    reference: &'a Reference,
    solved: Option<&Solved>,
    other: Option<Option<&Solved>>,
) -> Judged<'a> {
    let certified = judged_step(reference, solved).is_some_and(|s| s.converged);
    let read = |solved: Option<&Solved>| {
        let step = judged_step(reference, solved);
        let value = |name: &str| {
            let mut probes = step.iter().flat_map(|step| &step.probes);
            let probe = probes.find(|probe| probe.name == name);
            probe.map_or(f64::NAN, |probe| probe.value)
        };
        value(&reference.probe) - reference.minus.as_deref().map_or(0.0, value)
    };
    let computed = reference.computed(read(solved), other.map(read));
    let verdict = match reference.judge(computed) {
        Verdict::NotJudged => Verdict::NotJudged,
        _ if !certified => Verdict::Outside,
        verdict => verdict,
    };
    let value = number(reference.value);
    let expected = match reference.criterion {
        Criterion::Band([low, high]) => format!("{value} in [{}, {}]", number(low), number(high)),
        Criterion::Tolerance(t) if reference.value == 0.0 => format!("{value} ± {}", number(t)),
        Criterion::Tolerance(t) => format!("{value} ± {} %", number(100.0 * t)),
        Criterion::NotJudged => value,
    };
    let difference = reference.difference(computed);
    let difference = match (difference.is_nan(), reference.value == 0.0) {
        (true, _) => "-".to_string(),
        (false, true) => format!("{:+.2e}", difference + 0.0),
        // for a percentage the difference is in percentage points
        (false, false) if other.is_some() => format!("{:+.4} points", computed - reference.value),
        (false, false) if difference.abs() < 1e-6 => format!("{:+.1e} %", 100.0 * difference),
        (false, false) => format!("{:+.4} %", 100.0 * difference),
    };
    let label = match reference.step {
        Some(step) => format!("{} (step {step})", reference.label),
        None => reference.label.clone(),
    };
    Judged {
        reference,
        label,
        expected,
        computed,
        difference,
        verdict,
    }
}
