//! `dotyk run`: solve cases.

use crate::Outcome;
use crate::failure::{Failure, warn};
use crate::given::{Given, Input, located};
use crate::kept::{Kept, is_bare};
use crate::progress::Progress;
use crate::text::{columns, named, number, print, vector};
use dotyk::case::Case;
use dotyk::host::{alike, all_done, team};
use dotyk::model::{
    Analysis, BedSolution, BodySolution, ContactSolution, Dimension, MemberSolution, Method, Model,
    ProbeValue, Solution, StressAt, check_file_names,
};
use dotyk::output::{self, Folder, Scales};
use std::ffi::OsStr;
use std::path::{Path, PathBuf};
use std::time::Instant;

/// Arguments of `dotyk run`.
#[derive(clap::Args)]
pub struct Arguments {
    /// Case files, or decks of Abaqus and CalculiX (.inp)
    #[arg(required = true, value_name = "CASE")]
    cases: Vec<PathBuf>,
    #[command(flatten)]
    given: Given,
    /// Solver instead of the case's own: auto, newton, mprgp, gradient, accelerated, secant, uzawa
    #[arg(long, value_name = "NAME", value_parser = method)]
    solver: Option<Method>,
    /// Step of gradient and uzawa, for forces, unscaled
    #[arg(long, value_name = "X", value_parser = positive, allow_negative_numbers = true)]
    rho: Option<f64>,
    /// Output folder [default: CASE-out]; of several cases DIR/CASE
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Go on behind the steps of an earlier run of the case, from its output folder
    #[arg(long, value_name = "DIR")]
    from: Option<PathBuf>,
    /// Keep finished steps in DIR.unfinished every so many seconds: a killed run goes on from there with --from [default: 20 times
    /// what writing them takes]
    #[arg(long, value_name = "SECONDS", value_parser = not_negative, allow_negative_numbers = true)]
    keep_every: Option<f64>,
    /// Number of threads [default: all]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..))]
    pub threads: Option<u16>,
    /// No progress
    #[arg(long)]
    quiet: bool,
    /// Print summary.json instead of the tables; of several cases one after the other
    #[arg(long)]
    json: bool,
    /// Where the files that a deck asks for go instead of the output folder
    #[arg(skip)]
    apart: Option<PathBuf>,
}

impl Arguments {
    /// Those of one deck, quiet, whose own files go into a folder of their own.
    pub fn of_deck(deck: PathBuf, out: PathBuf, apart: PathBuf) -> Self {
        Self {
            cases: vec![deck],
            given: Given::default(),
            solver: None,
            rho: None,
            out: Some(out),
            from: None,
            keep_every: None,
            threads: None,
            quiet: true,
            json: false,
            apart: Some(apart),
        }
    }
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

/// A finite number of seconds ≥ 0, at most a century.
fn not_negative(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(value) if (0.0..=3.2e9).contains(&value) => Ok(value),
        _ => Err("expected a number of seconds, at least 0".to_string()),
    }
}

/// Solves, writes, prints.
pub fn run(arguments: &Arguments) -> Result<Outcome, Failure> {
    let folders = output_folders(arguments)?;
    if arguments.from.is_some() && arguments.cases.len() > 1 {
        let message = "--from goes on with one case: give one";
        return Err(Failure::Message(message.to_string()));
    }
    if let ([case], [folder]) = (&arguments.cases[..], &folders[..]) {
        return run_case(arguments, case, folder.clone());
    }
    let mut worst = Outcome::Done;
    for (case, folder) in arguments.cases.iter().zip(folders) {
        let outcome = run_case(arguments, case, folder).unwrap_or_else(|failure| {
            // the other cases are independent of it
            failure.print();
            Outcome::Refused
        });
        worst = worst.max(outcome);
    }
    Ok(worst)
}

/// The output folder of each case; refusals come before any work.
fn output_folders(arguments: &Arguments) -> Result<Vec<PathBuf>, Failure> {
    let stems: Vec<_> = arguments
        .cases
        .iter()
        .map(|case| case.file_stem())
        .collect();
    let twice = (1..stems.len()).find(|&k| stems[..k].contains(&stems[k]));
    if let Some(k) = twice {
        let message = "another case has the same name, and their results the same folder; run them one by one";
        return Err(Failure::of(&arguments.cases[k], message));
    }
    let several = stems.len() > 1;
    if several {
        check_stems(&stems)?;
    }
    let folder = |stem: Option<&OsStr>| {
        let stem = stem.unwrap_or_default();
        let folder = match &arguments.out {
            Some(folder) if several => folder.join(stem),
            Some(folder) => folder.clone(),
            None => PathBuf::from(format!("{}-out", stem.to_string_lossy())),
        };
        free_folder(folder)
    };
    stems.into_iter().map(folder).collect()
}

/// Solves one case, writes its files into a folder, prints.
fn run_case(arguments: &Arguments, file: &Path, folder: PathBuf) -> Result<Outcome, Failure> {
    let start = Instant::now();
    let Input { case, deck } = arguments.given.read(file)?;
    of_any!(case, |case| {
        let mut case = case;
        let taken = case.model.solver.take(arguments.solver, arguments.rho);
        taken.map_err(|method| {
            Failure::Message(format!(
                "--rho has no meaning for the solver `{}`: add --solver gradient or --solver uzawa",
                method.name()
            ))
        })?;
        let from = arguments.from.as_deref().filter(|dir| !is_bare(dir));
        let past = from.map(|dir| case.model.past(dir)).transpose();
        let past = past.map_err(|e| Failure::Message(e.to_string()))?;
        compared(&case)?;
        let held = hold(&folder)?;

        let past = past.unwrap_or_default();
        let kept = Kept::beside(&folder, past.len(), arguments.keep_every);
        kept.tell(arguments.from.as_deref());
        let all = case.model.times.len();
        let keep = |steps: &[Solution<_>]| {
            if held.is_some() && steps.len() < all {
                let record = output::Record::of(&case.model, steps, &case.stem);
                kept.after(steps.len(), |folder| {
                    record.write_unfinished(folder).map(drop)
                });
            }
        };
        let mut progress = Progress::new(arguments.quiet);
        let mut observe = |event| progress.observe(event);
        let mut run = case.run_keeping(&past, &mut observe, &keep);
        progress.finish();
        let (mut beside, mut moved) = (Vec::new(), None);
        if let Some(deck) = &deck {
            let steps = run.standing();
            let files = deck.files(&case.model, steps);
            let motion = deck.motion(&case.model, steps);
            beside = files.map_err(|e| Failure::of(file, e))?;
            if arguments.apart.is_some() {
                beside.push(deck.status(steps.len()));
            }
            moved = motion.map_err(|e| Failure::of(file, e))?;
            let told = moved.iter().map(|(told, _)| told);
            run.steps
                .iter_mut()
                .for_each(|step| step.warnings.extend(told.clone().cloned()));
        }
        warn(&run.warnings());
        let steps = run.standing();
        let record = output::Record {
            model: &case.model,
            steps,
            stem: &case.stem,
            failed: run.failed_step().map(|failure| output::FailedStep {
                step: failure.step,
                time: failure.time,
                reason: failure.reason.clone(),
                carried: failure.carried,
            }),
            since: start,
            beside: match arguments.apart {
                None => &beside,
                Some(_) => &[],
            },
        };
        if let Some(folder) = &held {
            if steps.last().is_some_and(|last| last.converged) {
                let written = record.write(folder).map_err(Failure::of_output)?;
                kept.remove();
                if let Some(apart) = &arguments.apart {
                    put_apart(apart, &beside)?;
                }
                if arguments.json {
                    print(&written.summary)?;
                } else {
                    let heading = match arguments.cases.len() {
                        1 => String::new(),
                        _ => format!("{}\n", file.display()),
                    };
                    let results = results(&case.model, steps);
                    print(&(heading + &results + &named(&written.files)))?;
                }
            } else if !steps.is_empty() {
                let written = record.write_summary(folder).map_err(Failure::of_output)?;
                for (name, _) in &beside {
                    // results of an earlier run; where there are none, nothing is to be removed
                    let _ = std::fs::remove_file(folder.path().join(name));
                }
                match arguments.json {
                    true => print(&written.summary)?,
                    false => print(&(verdict(&case.model, steps) + &named(&written.files)))?,
                }
            }
        }
        let ended = run.to_string();
        match run.failure.map(|failure| failure.refusal) {
            // the files are there, but this is not the answer that the deck asks for
            None => Ok(match moved {
                Some((_, false)) => {
                    let told = "the deck asks for finite motion, which is not supported yet, and motion is not small";
                    Failure::of(file, told).print();
                    Outcome::Unsatisfied
                }
                _ => Outcome::Done,
            }),
            Some(None) => {
                Failure::of(file, ended).print();
                Ok(Outcome::Unsatisfied)
            }
            Some(Some(refusal)) => Err(located(deck.as_deref(), refusal).into()),
        }
    })
}

/// Errors: processes of a team that have read different files, from different disks or while they changed.
fn compared<const D: usize>(case: &Case<D>) -> Result<(), Failure> {
    if team().size() == 1 {
        return Ok(());
    }
    let values = case.model.parameters.iter();
    let values = values.map(|(name, value)| (name, value.to_bits()));
    let asked = (
        values.collect::<Vec<_>>(),
        format!("{:?}", case.model.solver),
    );
    match alike((case.source().0, case.files(), asked)) {
        true => Ok(()),
        false => {
            let told = "the processes have read different files: give them one case in a folder that all of them see";
            Err(Failure::Message(told.to_string()))
        }
    }
}

/// The folder of the results, held by the first process of a team: the others write nothing.
fn hold(folder: &Path) -> Result<Option<Folder>, Failure> {
    let first = (team().rank() == 0).then(|| Folder::hold(folder));
    let held = first.transpose().map_err(Failure::of_output);
    match (all_done(held.is_ok()), held) {
        (true, held) | (false, held @ Err(_)) => held,
        (false, Ok(_)) => {
            let told = "another process cannot go on";
            Err(Failure::Message(told.to_string()))
        }
    }
}

/// Writes files into a folder, each whole or not at all.
fn put_apart(folder: &Path, files: &[(String, Vec<u8>)]) -> Result<(), Failure> {
    for (name, content) in files {
        let (path, part) = (folder.join(name), folder.join(format!("{name}.part")));
        let written = std::fs::write(&part, content).and_then(|()| std::fs::rename(&part, &path));
        written.map_err(|e| Failure::of(&path, format!("cannot be written: {e}")))?;
    }
    Ok(())
}

/// The folder for results of a case, which is held from then on; refused before any work when a file is in its way, or another run
/// has it.
pub fn output_folder(given: Option<&Path>, stem: &str) -> Result<Folder, Failure> {
    let folder = free_folder(match given {
        Some(folder) => folder.to_path_buf(),
        None => PathBuf::from(format!("{stem}-out")),
    })?;
    Folder::hold(&folder).map_err(Failure::of_output)
}

/// Refuses cases whose names cannot be names of folders, or coincide on some systems.
fn check_stems(stems: &[Option<&OsStr>]) -> Result<(), Failure> {
    let names = stems.iter().flatten().map(|stem| stem.to_string_lossy());
    let names: Vec<_> = names.collect();
    let checked = check_file_names(names.iter().map(|name| &**name));
    checked.map_err(|error| Failure::Message(format!("case `{}`: {error}", error.name())))
}

fn free_folder(folder: PathBuf) -> Result<PathBuf, Failure> {
    let existing = folder.ancestors().find(|path| path.exists());
    match existing {
        Some(path) if !path.is_dir() => {
            let message = "cannot be the output folder, it is a file; choose another with --out";
            Err(Failure::of(path, message))
        }
        _ => Ok(folder),
    }
}

/// A force, or zero if it is only rounding.
fn force(scales: &Scales, value: f64) -> String {
    number(scales.without_noise(value, Dimension::Force))
}

/// The value of a probe; for a line the smallest and the largest one.
fn of_probe(scales: &Scales, probe: &ProbeValue) -> String {
    let shown = |value: f64| number(scales.without_noise(value, probe.dimension));
    if probe.line.is_empty() {
        return shown(probe.value);
    }
    let values = || probe.line.iter().map(|place| place.value);
    let (low, high) = (
        values().fold(f64::NAN, f64::min),
        values().fold(f64::NAN, f64::max),
    );
    format!("{} .. {}", shown(low), shown(high))
}

/// The result lines: for several load steps one line each, and the last step in full.
fn results<const D: usize>(model: &Model<D>, steps: &[Solution<D>]) -> String {
    let Some(last) = steps.last() else {
        return String::new();
    };
    let pieces = match last.division.subdomains {
        count if count > model.bodies.len() => format!(" in {count} pieces"),
        _ => String::new(),
    };
    let mut text = format!(
        "{}\n{}, {} bodies{}, {} dofs, {} contact unknowns{}\n",
        model.title,
        model.analysis.name(),
        model.bodies.len(),
        pieces,
        last.dofs,
        last.contact_unknowns,
        units(model)
    );
    if steps.len() > 1 {
        text += &format!("\n{}", contacts_of_steps(model, steps));
        let from = last.counted_from.map(number);
        let from = from.map(|t| format!(", displacements from the end of that at t = {t}"));
        text += &format!(
            "\nlast step, t = {}{}\n",
            number(last.time),
            from.unwrap_or_default()
        );
    }
    for table in [
        contacts(model, last),
        bodies(model, last),
        points(model, last),
        beds(last),
        members(last),
        probes(steps),
    ] {
        if !table.is_empty() {
            text += "\n";
            text += &table;
        }
    }
    text + "\n" + &verdict(model, steps)
}

/// A line for each step and contact.
fn contacts_of_steps<const D: usize>(model: &Model<D>, steps: &[Solution<D>]) -> String {
    // a column of names only where some step has one
    let named = model.step_names.iter().any(|name| !name.is_empty());
    let names: &[String] = if named { &model.step_names } else { &[] };
    let mut rows = Vec::new();
    for (i, step) in steps.iter().enumerate() {
        let scales = Scales::of(step);
        let start = |contact: Vec<String>| {
            let mut row = vec![(i + 1).to_string(), number(step.time)];
            row.extend(names.get(i).cloned());
            row.push(step.solver.iterations.to_string());
            row.extend(contact);
            row
        };
        match step.contacts.as_slice() {
            [] => rows.push(start(vec![String::new(); D + 5])),
            contacts => rows.extend(contacts.iter().map(|c| start(contact_row(c, &scales)))),
        }
    }
    let own = contact_header(model);
    let header = ["step", "t"].into_iter();
    let header = header.chain((!names.is_empty()).then_some("name"));
    let header = header.chain(["iterations"]);
    let header: Vec<&str> = header.chain(own.iter().map(String::as_str)).collect();
    columns(&header, &rows, header.len() - own.len() + 1..header.len())
}

/// ", in m and N" where the case says so.
fn units<const D: usize>(model: &Model<D>) -> String {
    let given = [&model.units.length, &model.units.force];
    let given: Vec<&str> = given
        .into_iter()
        .filter_map(|unit| unit.as_deref())
        .collect();
    match given.is_empty() {
        true => String::new(),
        false => format!(", in {}", given.join(" and ")),
    }
}

/// Names of the axes in the heads of columns, after a word.
fn along_axes<const D: usize>(model: &Model<D>, word: &str) -> Vec<String> {
    let axes = match model.analysis {
        Analysis::Axisymmetric => &["r", "z"],
        _ => &["x", "y", "z"][..D],
    };
    axes.iter().map(|axis| format!("{word} {axis}")).collect()
}

fn contact_header<const D: usize>(model: &Model<D>) -> Vec<String> {
    let forces = along_axes(model, "force");
    let extent = if D == 3 { "area" } else { "length" };
    let rest = ["max pressure", extent, "closed", "open"].map(String::from);
    ["contact".to_string()]
        .into_iter()
        .chain(forces)
        .chain(rest)
        .collect()
}

fn contact_row<const D: usize>(contact: &ContactSolution<D>, scales: &Scales) -> Vec<String> {
    let (closed, open) = output::closed_and_open(&contact.nodes);
    let pressures = contact.nodes.iter().map(|n| n.pressure);
    let mut row = vec![contact.name.clone()];
    row.extend(contact.resultant.map(|f| force(scales, f)));
    row.push(number(pressures.fold(0.0, f64::max)));
    row.push(number(contact.length));
    row.extend([closed, open].map(|count| count.to_string()));
    row
}

fn contacts<const D: usize>(model: &Model<D>, solution: &Solution<D>) -> String {
    if solution.contacts.is_empty() {
        return String::new();
    }
    let rows: Vec<Vec<String>> = {
        let scales = Scales::of(solution);
        let rows = solution.contacts.iter().map(|c| contact_row(c, &scales));
        rows.collect()
    };
    let header = contact_header(model);
    let header: Vec<&str> = header.iter().map(String::as_str).collect();
    columns(&header, &rows, 1..header.len())
}

/// The points of couples; an empty text if no body has any.
fn points<const D: usize>(model: &Model<D>, solution: &Solution<D>) -> String {
    let scales = Scales::of(solution);
    let length = |value: f64| number(scales.without_noise(value, Dimension::Length));
    let couples = solution.bodies.iter();
    let couples = couples.flat_map(|body| body.couples.iter().map(move |couple| (body, couple)));
    let rows: Vec<Vec<String>> = couples
        .map(|(body, couple)| {
            let mut row = vec![
                format!("{}.{}", body.name, couple.name),
                couple.kind.name().to_string(),
            ];
            row.extend(couple.displacement.map(length));
            row.extend(couple.rotation.iter().map(|&angle| number(angle)));
            row.extend(couple.force.map(|f| force(&scales, f)));
            row.extend(couple.moment.iter().map(|&m| force(&scales, m)));
            row
        })
        .collect();
    if rows.is_empty() {
        return String::new();
    }
    let about = |word: &str| match D {
        2 => vec![word.to_string()],
        _ => along_axes(model, word),
    };
    let header = [
        vec!["point".to_string(), "couple".to_string()],
        along_axes(model, "displacement"),
        about("rotation"),
        along_axes(model, "force"),
        about("moment"),
    ]
    .concat();
    let header: Vec<&str> = header.iter().map(String::as_str).collect();
    columns(&header, &rows, 2..header.len())
}

/// Pressure, gap and area of bedded sides; an empty text without these.
fn beds<const D: usize>(solution: &Solution<D>) -> String {
    let scales = Scales::of(solution);
    let stress = |value: f64| number(scales.without_noise(value, Dimension::Stress));
    let row = |bed: &BedSolution<D>| {
        vec![
            bed.name.clone(),
            number(bed.area()),
            number(bed.closed_area()),
            stress(bed.mean_pressure()),
            stress(bed.largest().map_or(f64::NAN, |at| at.pressure)),
            stress(bed.min_pressure()),
            number(scales.without_noise(bed.max_gap(), Dimension::Length)),
        ]
    };
    if solution.beds.is_empty() {
        return String::new();
    }
    let header = [
        "bed",
        "area",
        "pressed",
        "mean pressure",
        "largest",
        "smallest",
        "largest gap",
    ];
    let rows: Vec<Vec<String>> = solution.beds.iter().map(row).collect();
    columns(&header, &rows, 1..header.len())
}

/// The forces of members, a table for each kind; an empty text without members.
fn members<const D: usize>(solution: &Solution<D>) -> String {
    let scales = Scales::of(solution);
    let row = |member: &MemberSolution<D>| {
        let forces = || member.stations.iter().map(|station| station.force);
        let ends = [
            forces().fold(f64::NAN, f64::min),
            forces().fold(f64::NAN, f64::max),
        ];
        let state = if member.tightening { "tightened" } else { "" };
        let [least, most] = ends.map(|f| force(&scales, f));
        vec![
            member.name.clone(),
            number(member.shortening.unwrap_or(member.length)),
            least,
            most,
            state.to_string(),
        ]
    };
    let tables = solution.members_by_kind().map(|(kind, members)| {
        let bolts = members.iter().any(|member| member.shortening.is_some());
        let length = if bolts { "shortening" } else { "length" };
        let rows: Vec<Vec<String>> = members.into_iter().map(row).collect();
        columns(&[kind.key, length, "least N", "largest N", ""], &rows, 1..4)
    });
    tables.collect::<Vec<String>>().join("\n")
}

fn bodies<const D: usize>(model: &Model<D>, solution: &Solution<D>) -> String {
    let scales = Scales::of(solution);
    let rows: Vec<Vec<String>> = solution
        .bodies
        .iter()
        .map(|body| {
            let most = body.von_mises.iter().copied().fold(0.0, f64::max);
            let mut row = vec![
                body.name.clone(),
                number(body.max_displacement()),
                number(scales.without_noise(most, Dimension::Stress)),
            ];
            row.extend(body.reaction.map(|f| force(&scales, f)));
            row.push(body.floating());
            row
        })
        .collect();
    let reactions = along_axes(model, "reaction");
    let mut header = vec!["body", "max displacement", "max von Mises"];
    header.extend(reactions.iter().map(String::as_str));
    header.push("floats");
    let told = solution.bodies.iter().filter_map(singular_stress);
    columns(&header, &rows, 1..3 + D) + &told.collect::<String>()
}

/// A warning line if the largest stress of a body depends on the mesh (a singularity); `None` for a stress that the mesh resolves.
fn singular_stress<const D: usize>(body: &BodySolution<D>) -> Option<String> {
    let peak = body.peak?;
    let singular = peak.place?;
    let at = |stress: StressAt<D>| format!("{} at {}", number(stress.value), vector(&stress.at));
    let away = singular.away.map_or(String::new(), |away| {
        format!("; farther than two cells from such places {}", at(away))
    });
    Some(format!(
        "max von Mises of {} is at {} and grows as the mesh is refined: {}{away}\n",
        body.name,
        singular.place,
        at(peak.most)
    ))
}

/// Up to this many steps stand side by side.
const MOST_BESIDE: usize = 6;

/// Up to this many below each other; of more there are the first and the last ones.
const MOST_BELOW: usize = 40;

/// The values of the probes in every step: steps side by side while there are few, else below each other.
fn probes<const D: usize>(steps: &[Solution<D>]) -> String {
    let Some(last) = steps.last().filter(|last| !last.probes.is_empty()) else {
        return String::new();
    };
    if steps.len() > MOST_BESIDE {
        return probes_below(steps, last);
    }
    let scales: Vec<Scales> = steps.iter().map(Scales::of).collect();
    let place = |at: [f64; 3]| format!("at {}", vector(&at[..D]));
    let rows: Vec<Vec<String>> = last
        .probes
        .iter()
        .enumerate()
        .map(|(i, probe)| {
            let values = scales
                .iter()
                .zip(steps)
                .map(|(s, step)| of_probe(s, &step.probes[i]));
            let names = [probe.name.clone(), probe.quantity.clone()];
            let at = match probe.line.last() {
                Some(end) => format!(
                    "along {}, {} points in lines.csv",
                    number(end.s),
                    probe.line.len()
                ),
                None => probe.at.map_or(String::new(), place),
            };
            names.into_iter().chain(values).chain([at]).collect()
        })
        .collect();
    let times: Vec<String> = match steps {
        [_] => vec!["value".to_string()],
        several => {
            let times = several.iter().map(|s| format!("t = {}", number(s.time)));
            times.collect()
        }
    };
    let mut header = vec!["probe", "quantity"];
    header.extend(times.iter().map(String::as_str));
    header.push("");
    columns(&header, &rows, 2..2 + steps.len())
}

/// A line for each step, a column for each probe.
fn probes_below<const D: usize>(steps: &[Solution<D>], last: &Solution<D>) -> String {
    let half = MOST_BELOW / 2;
    let left_out = |k: usize| steps.len() > MOST_BELOW && k >= half && k < steps.len() - half;
    let mut rows = Vec::new();
    for (k, step) in steps.iter().enumerate().filter(|(k, _)| !left_out(*k)) {
        let scales = Scales::of(step);
        let values = step.probes.iter().map(|probe| of_probe(&scales, probe));
        let start = [(k + 1).to_string(), number(step.time)];
        rows.push(start.into_iter().chain(values).collect());
    }
    let names = last.probes.iter().map(|probe| probe.name.as_str());
    let header: Vec<&str> = ["step", "t"].into_iter().chain(names).collect();
    let table = columns(&header, &rows, 0..header.len());
    match steps.len() - rows.len() {
        0 => table,
        more => format!("{table}{more} steps between are left out: all are in summary.json\n"),
    }
}

/// Two digits: only the size of a violation matters.
fn short(value: f64) -> String {
    if value == 0.0 {
        return "0".to_string();
    }
    format!("{value:.1e}")
}

/// The figures of the certificate, the verdict, and the time; over several steps the largest value of each figure.
fn verdict<const D: usize>(model: &Model<D>, steps: &[Solution<D>]) -> String {
    let Some(last) = steps.last() else {
        return String::new();
    };
    let mut figures = last.certificate.figures();
    for step in steps {
        for (worst, (_, figure)) in figures.iter_mut().zip(step.certificate.figures()) {
            // NaN is worse than any number
            if figure.relative.is_nan() || figure.relative > worst.1.relative {
                worst.1 = figure;
            }
        }
    }
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
    let several = model.times.len() > 1;
    let title = match several {
        true => "certificate (worst step)",
        false => "certificate",
    };
    let table = columns(&[title, "relative", "limit", ""], &rows, 1..3);
    let converged = steps.len() == model.times.len() && steps.iter().all(|s| s.converged);
    let verdict = match converged {
        true => "converged",
        false => "NOT CONVERGED",
    };
    let count = match several {
        true => format!("{} of {} steps, ", steps.len(), model.times.len()),
        false => String::new(),
    };
    let iterations: usize = steps.iter().map(|s| s.solver.iterations).sum();
    format!(
        "{table}\n{verdict}: {count}{}, {iterations} iterations, {:.2} s\n",
        last.solver.method, last.seconds.total
    )
}
