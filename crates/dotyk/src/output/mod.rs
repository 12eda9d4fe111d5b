//! VTU, CSV, JSON, pictures and the report of a solution.
//!
//! Result files change together, or not at all: see [`Folder`] and [`Record`]. Numbers and signs are those of the solution; only the report
//! rounds. The same solution gives the same bytes, except for the timings.

mod beds;
mod chain;
mod colour;
mod compare;
mod contacts;
mod crosses;
mod csv;
mod deformed;
mod encode;
mod export;
mod figures;
mod files;
mod film;
mod history;
mod html;
mod interface;
mod json;
mod lines;
mod market;
mod markup;
mod members;
mod npz;
mod panels;
mod past;
mod picture;
mod plot;
mod points;
mod ranges;
mod report;
mod scene;
mod sections;
mod setup;
mod solutions;
mod space;
mod state;
mod steps;
mod strength;
mod study;
mod svg;
mod symbols;
mod text;
mod trough;
#[cfg(test)]
mod tunnel;
mod utilisation;
mod verdict;
mod view;
mod vtu;
mod yielding;

pub use files::{Folder, Stage, abandon};
pub use json::closed_and_open;
pub use past::PastError;
pub use text::Scales;

use crate::dual::Multipliers;
use crate::geometry::Point;
use crate::host::{peak_memory_bytes, processes};
use crate::model::{Check, Comparison, Dual, MemberKind, Model, Past, Seconds, Solution, Study};
use rayon::prelude::*;
use std::borrow::Cow;
use std::io::Read;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

/// Why a result file could not be written.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// The system refused.
    #[error("cannot write {}: {source}; choose another folder, or make it writable", path.display())]
    Unwritable {
        /// The file or folder.
        path: PathBuf,
        /// The error of the system.
        source: std::io::Error,
    },
    /// The output folder is a file.
    #[error("{} is not a folder; remove it, or choose another folder", path.display())]
    NotADirectory {
        /// The path.
        path: PathBuf,
    },
    /// The output folder is that of a run that goes on.
    #[error("{} is in use: another run writes its results there; wait for its end, or choose another folder", path.display())]
    Taken {
        /// The folder.
        path: PathBuf,
    },
    /// A folder has the name of a result file.
    #[error("{} is a folder, a result file needs its name; remove it, or choose another folder", path.display())]
    IsADirectory {
        /// The path.
        path: PathBuf,
    },
    /// A body's name cannot be the name of a file.
    #[error("body name \"{name}\" cannot name its file; use letters, digits, \"_\" and \"-\" only")]
    Name {
        /// The name.
        name: String,
    },
    /// F is not assembled.
    #[error(
        "F of {unknowns} contact unknowns has too many entries for a file: it is exported up to {most}; use a coarser mesh, or take products with F from the library (`Model::dual`)"
    )]
    Unassembled {
        /// Number of contact unknowns.
        unknowns: usize,
        /// The most that are assembled.
        most: usize,
    },
    /// Model and solution do not belong together.
    #[error(
        "the solution has {found} {what}, the model has {expected}: they do not belong together"
    )]
    Mismatch {
        /// Bodies, contacts or nodes of a body.
        what: String,
        /// In the model.
        expected: usize,
        /// In the solution.
        found: usize,
    },
}

/// A run that is to be written.
pub struct Record<'a, const D: usize> {
    /// The model.
    pub model: &'a Model<D>,
    /// Solutions of its load steps in their order, at least one.
    pub steps: &'a [Solution<D>],
    /// Name of the case.
    pub stem: &'a str,
    /// The step after these that has no answer.
    pub failed: Option<FailedStep>,
    /// When the run began.
    pub since: Instant,
    /// Names and contents of further files that appear with the others.
    pub beside: &'a [(String, Vec<u8>)],
}

impl<'a, const D: usize> Record<'a, D> {
    /// A run whose steps all have an answer; the time it took is that of the solution.
    pub fn of(model: &'a Model<D>, steps: &'a [Solution<D>], stem: &'a str) -> Self {
        let spent = steps.last().map_or(0.0, |last| last.seconds.total);
        let now = Instant::now();
        Self {
            model,
            steps,
            stem,
            failed: None,
            since: now
                .checked_sub(Duration::from_secs_f64(spent))
                .unwrap_or(now),
            beside: &[],
        }
    }

    /// The stage of each step.
    fn stages(&self) -> Vec<Cow<'a, Model<D>>> {
        let steps = self.steps.iter();
        steps.map(|step| self.model.stage(step.time)).collect()
    }

    /// The data of summary and report, the time so far included.
    ///
    /// Errors: [`Error::Name`], [`Error::Mismatch`], also without any step.
    fn overview(&self) -> Result<Overview<'_, D>, Error> {
        let stages = self.stages();
        check(&stages, self.steps)?;
        let (last, earlier) = self.steps.split_last().ok_or(Error::Mismatch {
            what: "steps".to_string(),
            expected: self.model.times.len(),
            found: 0,
        })?;
        Ok(Overview {
            model: self.model,
            stages,
            earlier,
            last,
            stem: self.stem,
            converged: self.failed.is_none() && self.steps.iter().all(|step| step.converged),
            failed: self.failed.as_ref(),
            seconds: Seconds {
                total: self.since.elapsed().as_secs_f64(),
                ..last.seconds
            },
            peak_memory: peak_memory_bytes(),
        })
    }
}

/// The written files.
#[derive(Debug, Clone, PartialEq)]
pub struct Written {
    /// Paths of the files.
    pub files: Vec<PathBuf>,
    /// Content of `summary.json`.
    pub summary: String,
}

/// A load step without an answer.
#[derive(Debug, Clone, PartialEq)]
pub struct FailedStep {
    /// From 1.
    pub step: usize,
    /// Its time.
    pub time: f64,
    /// Why.
    pub reason: String,
    /// The part of it that the bodies can bear, where that is known.
    pub carried: Option<f64>,
}

/// The data of summary and report.
#[derive(Clone)]
pub(crate) struct Overview<'a, const D: usize> {
    /// All of the model.
    pub model: &'a Model<D>,
    /// The stage of each step.
    pub stages: Vec<Cow<'a, Model<D>>>,
    /// Steps before the last.
    pub earlier: &'a [Solution<D>],
    pub last: &'a Solution<D>,
    /// Name of the case.
    pub stem: &'a str,
    /// All steps were solved.
    pub converged: bool,
    /// The step that was not.
    pub failed: Option<&'a FailedStep>,
    /// Spent on the whole run.
    pub seconds: Seconds,
    /// In bytes.
    pub peak_memory: u64,
}

impl<'a, const D: usize> Overview<'a, D> {
    /// The model has several steps, even where the first of them has failed.
    pub fn has_steps(&self) -> bool {
        self.model.times.len() > 1 || !self.earlier.is_empty()
    }

    /// The model of the last step, with its present parts.
    pub fn stage(&self) -> &Model<D> {
        self.stages.last().map_or(self.model, |stage| stage)
    }

    /// Name of a step, counted from 0; `None` where it has none.
    pub fn step_name(&self, step: usize) -> Option<&'a str> {
        let name = self.model.step_names.get(step).map(String::as_str);
        name.filter(|name| !name.is_empty())
    }

    /// All steps in their order.
    pub fn steps(&self) -> impl Iterator<Item = &'a Solution<D>> {
        self.earlier.iter().chain([self.last])
    }
}

/// As in [`Model`]: generic code is compiled here, once for each dimension.
macro_rules! doors {
    ($($D:literal)*) => {$(
        impl Record<'_, $D> {
            /// Writes all result files into a folder: a VTU file per body and step, a VTM file per step that
            /// names them as blocks, `case.pvd`, `contact.csv`, `lines.csv` with a probe along a line, `sections.csv` with a section,
            /// `beds.csv` with bedded sides, `bars.csv` and `springs.csv` with such members, `state.bin` if a material yields,
            /// `summary.json`, `report.html`.
            ///
            /// `seconds.write` in the summary is the time for all other files, and `seconds.total` the time since the run began; the
            /// report, which is one of these files, gives the time up to itself.
            /// Files of other names in the folder stay, except for the VTU and VTM files of an earlier run that its `case.pvd` names,
            /// and its `lines.csv`, `sections.csv`, `beds.csv`, files of members and `state.bin`.
            /// Errors: any [`Error`]; then the folder is as it was before.
            pub fn write(&self, folder: &Folder) -> Result<Written, Error> {
                write(self, folder)
            }

            /// The same without the report: what a run that goes on from here reads.
            ///
            /// Errors: as [`Self::write`].
            pub fn write_unfinished(&self, folder: &Folder) -> Result<Written, Error> {
                write_files(self, folder, false)
            }

            /// Writes `summary.json` alone, with `"converged": false`, and removes the other result files of an earlier run of this
            /// case: a run whose first step has no answer leaves no others.
            ///
            /// The steps of the record are the last iterate of that step alone.
            /// Errors: any [`Error`]; then the folder is as it was before.
            pub fn write_summary(&self, folder: &Folder) -> Result<Written, Error> {
                write_summary(self, folder)
            }

            /// The content of `summary.json`.
            ///
            /// Errors: [`Error::Name`], [`Error::Mismatch`].
            pub fn summary(&self) -> Result<String, Error> {
                Ok(json::summary(&self.overview()?))
            }

            /// The content of `contact.csv`.
            ///
            /// Errors: [`Error::Name`], [`Error::Mismatch`].
            pub fn contact_csv(&self) -> Result<String, Error> {
                Ok(csv::contact_csv(&self.overview()?.stages, self.steps))
            }

            /// The content of the VTU file of a body in a step, both counted from 0.
            ///
            /// Errors: [`Error::Name`], [`Error::Mismatch`], also where there is no such body.
            pub fn body_vtu(&self, step: usize, body: usize) -> Result<String, Error> {
                let run = self.overview()?;
                match (run.stages.get(step), self.steps.get(step)) {
                    (Some(stage), Some(solution)) if body < stage.bodies.len() => {
                        Ok(vtu::body_vtu(stage, solution, body))
                    }
                    (stage, _) => Err(Error::Mismatch {
                        what: "bodies".to_string(),
                        expected: body + 1,
                        found: stage.map_or(0, |stage| stage.bodies.len()),
                    }),
                }
            }

            /// The content of `report.html`.
            ///
            /// Errors: [`Error::Name`], [`Error::Mismatch`].
            pub fn report(&self) -> Result<String, Error> {
                Ok(report::page(&self.overview()?).into_string())
            }

            /// The figures of the report in its order: the title of each, as text, and its `<figure>`, HTML that refers to
            /// nothing outside itself; in space one of them brings its script. None where the record cannot be written
            /// because model and steps do not belong together.
            pub fn figures(&self) -> Vec<(String, String)> {
                self.overview()
                    .map_or(Vec::new(), |run| report::figures(&run))
            }
        }

        impl Record<'_, $D> {
            /// The solutions of the steps as bytes, from which the same version makes the same ones with
            /// [`Model::read_solutions`](Model).
            pub fn solutions(&self) -> Vec<u8> {
                solutions::solutions(self.model, self.steps)
            }
        }

        impl Check<$D> {
            /// Writes `check.html`, the mesh-and-supports page of an unsolved model, with the findings of its check.
            ///
            /// Errors: any [`Error`]; then the folder is as it was before.
            pub fn write_page(
                &self,
                model: &Model<$D>,
                stem: &str,
                folder: &Folder,
            ) -> Result<PathBuf, Error> {
                let alone = self.contacts.iter().flat_map(|contact| &contact.alone);
                let alone: Vec<Point<$D>> = alone.copied().collect();
                let page = report::check_page(model, &self.to_string(), &alone, stem);
                let mut stage = Stage::open(folder)?;
                stage.put("check.html", page.as_bytes())?;
                stage.commit(&[])?;
                Ok(folder.path().join("check.html"))
            }
        }

        impl Dual<$D> {
            /// Writes the dual problem of a case for solvers elsewhere, with an `answer` where there is one, and returns the
            /// paths: `dual.npz`, a `.mtx` file of each matrix and vector, `rows.csv` and `dual.txt`, which explains them.
            ///
            /// Errors: any [`Error`], [`Error::Unassembled`] where F is applied ([`Dual::assemble`]); then the folder is as
            /// it was before.
            pub fn write(
                &self,
                answer: Option<&Multipliers>,
                stem: &str,
                folder: &Folder,
            ) -> Result<Vec<PathBuf>, Error> {
                let mut stage = Stage::open(folder)?;
                export::put(&mut stage, self, answer, stem)?;
                stage.commit(&export::OPTIONAL.map(String::from))
            }
        }

        impl Model<$D> {
            /// The steps of an earlier run of this model that have an answer, at least one, from the folder of its results.
            ///
            /// Errors: files that are missing or not from a run; a run without an answer.
            pub fn past(&self, dir: &Path) -> Result<Vec<Past<$D>>, PastError> {
                past::past(dir)
            }

            /// The solutions of steps of this model, to the bit, from the bytes that [`Record::solutions`](Record) made of them.
            ///
            /// Errors, in words: bytes of another version, or that are cut off; other meshes, bodies or contacts.
            pub fn read_solutions(&self, bytes: &[u8]) -> Result<Vec<Solution<$D>>, String> {
                solutions::read_solutions(self, bytes)
            }
        }
    )*};
}

doors!(2 3);

/// As [`Record::<2>::write`](Record).
fn write<const D: usize>(record: &Record<'_, D>, folder: &Folder) -> Result<Written, Error> {
    write_files(record, folder, true)
}

/// All files, the report among them or not.
fn write_files<const D: usize>(
    record: &Record<'_, D>,
    folder: &Folder,
    with_report: bool,
) -> Result<Written, Error> {
    let start = Instant::now();
    let (model, steps) = (record.model, record.steps);
    let mut run = record.overview()?;
    let mut stage = Stage::open(folder)?;
    let several = model.times.len().max(steps.len()) > 1;
    for (step, (solution, model)) in steps.iter().zip(&run.stages).enumerate() {
        let bodies: Vec<usize> = (0..model.bodies.len()).collect();
        // side by side, but no more of them in memory than that takes
        for some in bodies.chunks(rayon::current_num_threads()) {
            let files = some.par_iter().map(|&i| {
                let name = vtu::file_name(&model.bodies[i].name, step, several);
                body_files(model, solution, (i, name))
            });
            for (name, file) in files.collect::<Vec<_>>().concat() {
                stage.put(&name, file.as_bytes())?;
            }
        }
    }
    for (step, solution) in steps.iter().enumerate() {
        let name = vtu::blocks_name(step, several);
        stage.put(&name, vtu::blocks(solution, step, several).as_bytes())?;
    }
    stage.put(COLLECTION, vtu::collection(steps, several).as_bytes())?;
    stage.put(
        "contact.csv",
        csv::contact_csv(&run.stages, steps).as_bytes(),
    )?;
    if let Some(lines) = csv::lines_csv(steps) {
        stage.put(LINES, lines.as_bytes())?;
    }
    if let Some(sections) = csv::sections_csv(model, steps) {
        stage.put(SECTIONS, sections.as_bytes())?;
    }
    if let Some(beds) = csv::beds_csv(steps) {
        stage.put(BEDS, beds.as_bytes())?;
    }
    for kind in MemberKind::ALL {
        if let Some(forces) = csv::members_csv(*kind, steps) {
            stage.put(&csv::members_file(kind), forces.as_bytes())?;
        }
    }
    if let Some(state) = state::state(steps) {
        stage.put(state::STATE, &state)?;
    }
    for (name, content) in record.beside {
        stage.put(name, content)?;
    }

    let seconds = || Seconds {
        write: start.elapsed().as_secs_f64(),
        total: record.since.elapsed().as_secs_f64(),
        ..run.last.seconds
    };
    run.seconds = seconds();
    if with_report {
        stage.put("report.html", report::page(&run).as_bytes())?;
        run.seconds = seconds();
    }
    let summary = json::summary(&run);
    stage.put("summary.json", summary.as_bytes())?;
    let files = stage.commit(&earlier_files(folder.path()))?;
    Ok(Written { files, summary })
}

/// The file of a body, or those of its parts and one that names them where a team writes.
fn body_files<const D: usize>(
    model: &Model<D>,
    solution: &Solution<D>,
    (body, name): (usize, String),
) -> Vec<(String, String)> {
    let Some(count) = processes() else {
        return vec![(name, vtu::body_vtu(model, solution, body))];
    };
    let fields = vtu::Fields::of(model, solution, body);
    let parts = vtu::parts(&model.bodies[body].mesh, count);
    let parts = parts.par_iter().enumerate().map(|(k, part)| {
        let content = vtu::part_vtu(model, solution, (body, &fields), Some(part));
        (vtu::part_name(&name, k), content)
    });
    let mut files: Vec<(String, String)> = parts.collect();
    let names: Vec<String> = files.iter().map(|(name, _)| name.clone()).collect();
    let whole = files.first().map(|(_, part)| vtu::whole(part, &names));
    files.extend(whole.map(|whole| (name, whole)));
    files
}

/// As [`Record::<2>::write_summary`](Record).
fn write_summary<const D: usize>(
    record: &Record<'_, D>,
    folder: &Folder,
) -> Result<Written, Error> {
    let run = Overview {
        converged: false,
        ..record.overview()?
    };
    let mut stage = Stage::open(folder)?;
    let summary = json::summary(&run);
    stage.put("summary.json", summary.as_bytes())?;
    let mut stale = earlier_files(folder.path());
    let bodies = record.model.bodies.iter();
    stale.extend(bodies.map(|b| format!("{}.vtu", b.name)));
    stale.extend([COLLECTION, "contact.csv", "report.html"].map(String::from));
    let files = stage.commit(&stale)?;
    Ok(Written { files, summary })
}

/// The file that names all VTU files.
const COLLECTION: &str = "case.pvd";

/// The file of probes along lines.
const LINES: &str = "lines.csv";

/// The file of beds.
const BEDS: &str = "beds.csv";

/// The file of section forces.
const SECTIONS: &str = "sections.csv";

/// Files of an earlier run in a folder that not every run writes: VTU and VTM files named by its collection, and files that look
/// like its `lines.csv`, `sections.csv`, `beds.csv`, forces of members or `state.bin`; unreadable ones are left out.
fn earlier_files(dir: &Path) -> Vec<String> {
    let read = |name: &str| std::fs::read_to_string(dir.join(name)).unwrap_or_default();
    let text = read(COLLECTION);
    let mut files = vtu::collected(&text);
    let wholes = files.iter().filter(|name| name.ends_with(".pvtu"));
    let parts: Vec<String> = wholes.flat_map(|name| vtu::sources(&read(name))).collect();
    files.extend(parts);
    files.extend(vtu::collected_blocks(&text));
    if read(LINES).starts_with(csv::LINES_HEAD) {
        files.push(LINES.to_string());
    }
    if read(SECTIONS).starts_with(csv::SECTIONS_HEAD) {
        files.push(SECTIONS.to_string());
    }
    if read(BEDS).starts_with(csv::BEDS_HEAD) {
        files.push(BEDS.to_string());
    }
    for kind in MemberKind::ALL {
        let name = csv::members_file(kind);
        if read(&name).starts_with(&csv::members_head(kind)) {
            files.push(name);
        }
    }
    if begins(&dir.join(state::STATE), state::STATE_HEAD) {
        files.push(state::STATE.to_string());
    }
    files
}

/// A file begins with these words.
fn begins(file: &Path, words: &str) -> bool {
    let mut head = vec![0; words.len()];
    let read = std::fs::File::open(file).and_then(|mut file| file.read_exact(&mut head));
    read.is_ok() && head == words.as_bytes()
}

/// Writes `compare.csv` and `compare.svg`, and returns their paths.
///
/// Errors: any [`Error`]; then the folder is as it was before.
pub fn write_comparison(comparison: &Comparison, folder: &Folder) -> Result<Vec<PathBuf>, Error> {
    let mut stage = Stage::open(folder)?;
    stage.put(
        "compare.csv",
        compare::comparison_csv(comparison).as_bytes(),
    )?;
    stage.put(
        "compare.svg",
        compare::comparison_svg(comparison).as_bytes(),
    )?;
    stage.commit(&[])
}

/// Writes `study.csv`, the page `study.html`, and where `pairs` of probes or varied parameters, each by its name [x, y], are
/// to be drawn against each other, the picture `study.svg`; returns their paths.
///
/// Errors: any [`Error`]; then the folder is as it was before.
pub fn write_study(
    study: &Study,
    pairs: &[[String; 2]],
    stem: &str,
    folder: &Folder,
) -> Result<Vec<PathBuf>, Error> {
    let picture = (!pairs.is_empty()).then(|| study::study_picture(study, pairs));
    let page = study::study_page(study, picture.as_ref(), stem);
    let mut stage = Stage::open(folder)?;
    stage.put("study.csv", study::study_csv(study).as_bytes())?;
    stage.put("study.html", page.as_bytes())?;
    if let Some(picture) = picture {
        stage.put("study.svg", picture.as_bytes())?;
    }
    stage.commit(&[])
}

/// Names that can be files, and counts that agree in every step.
fn check<const D: usize>(stages: &[Cow<'_, Model<D>>], steps: &[Solution<D>]) -> Result<(), Error> {
    let mut both = stages.iter().zip(steps);
    both.try_for_each(|(stage, step)| check_step(stage, step))
}

fn check_step<const D: usize>(model: &Model<D>, solution: &Solution<D>) -> Result<(), Error> {
    let same = |what: &str, expected: usize, found: usize| {
        if expected == found {
            Ok(())
        } else {
            Err(Error::Mismatch {
                what: what.to_string(),
                expected,
                found,
            })
        }
    };
    same("bodies", model.bodies.len(), solution.bodies.len())?;
    same("contacts", model.contacts.len(), solution.contacts.len())?;
    for (body, answer) in model.bodies.iter().zip(&solution.bodies) {
        let good = |c: char| c.is_ascii_alphanumeric() || c == '_' || c == '-';
        if body.name.is_empty() || !body.name.chars().all(good) {
            return Err(Error::Name {
                name: body.name.clone(),
            });
        }
        let what = format!("nodes of body {}", body.name);
        same(&what, body.mesh.points().len(), answer.displacement.len())?;
        for found in [answer.stress.len(), answer.von_mises.len()] {
            same(&what, answer.borders.count(), found)?;
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::LinePoint;
    use crate::output::tunnel::names;
    use std::fs;
    use std::slice::from_ref;

    fn held(dir: &Path) -> Folder {
        Folder::hold(dir).unwrap()
    }

    fn record<'a>(model: &'a Model<2>, steps: &'a [Solution<2>]) -> Record<'a, 2> {
        Record::of(model, steps, "case_1")
    }

    #[test]
    fn all_files_are_written_and_foreign_ones_stay() {
        let scratch = tunnel::Scratch::new("write");
        fs::write(scratch.path().join("notes.txt"), b"mine").unwrap();
        fs::write(scratch.path().join("contact.csv"), b"old").unwrap();
        let (model, solution) = tunnel::solved();
        let written = write(&record(&model, from_ref(&solution)), &held(scratch.path())).unwrap();
        let mut expected = vec![
            "case.pvd",
            "case.vtm",
            "contact.csv",
            "notes.txt",
            "report.html",
            "ring.vtu",
            "rock.vtu",
            "summary.json",
        ];
        assert_eq!(names(scratch.path()), expected);
        expected.retain(|n| *n != "notes.txt");
        assert_eq!(written.files.len(), expected.len());
        assert!(
            fs::read_to_string(scratch.path().join("contact.csv"))
                .unwrap()
                .starts_with("step,")
        );
    }

    #[test]
    fn fewer_steps_take_the_fields_of_an_earlier_run_away() {
        let scratch = tunnel::Scratch::new("fewer");
        let (model, solution) = tunnel::solved();
        let dir = scratch.path();
        fs::write(dir.join("ring_0009.vtu"), b"mine").unwrap();
        let three = vec![solution.clone(); 3];
        write(&record(&model, &three), &held(dir)).unwrap();
        let fields = |dir: &Path| -> Vec<String> {
            let all = names(dir).into_iter();
            all.filter(|n| n.ends_with(".vtu")).collect()
        };
        let of_three = ["ring_0001.vtu", "ring_0002.vtu", "ring_0003.vtu"];
        assert_eq!(fields(dir)[..3], of_three);
        assert_eq!(fields(dir).len(), 7);
        write(&record(&model, &three[..2]), &held(dir)).unwrap();
        let two = [
            "ring_0001.vtu",
            "ring_0002.vtu",
            "ring_0009.vtu",
            "rock_0001.vtu",
            "rock_0002.vtu",
        ];
        assert_eq!(fields(dir), two);
        assert!(dir.join("case_0002.vtm").exists() && !dir.join("case_0003.vtm").exists());
        write(&record(&model, from_ref(&solution)), &held(dir)).unwrap();
        assert_eq!(fields(dir), ["ring.vtu", "ring_0009.vtu", "rock.vtu"]);
        write_summary(&record(&model, &three), &held(dir)).unwrap();
        assert_eq!(names(dir), ["ring_0009.vtu", "summary.json"]);
        let empty = write(&record(&model, &[]), &held(dir)).unwrap_err();
        assert!(empty.to_string().contains("0 steps"), "{empty}");
    }

    #[test]
    fn lines_are_written_where_there_are_some_and_taken_away_where_not() {
        let scratch = tunnel::Scratch::new("lines");
        let (model, solution) = tunnel::solved();
        let mut with = solution.clone();
        let place = LinePoint {
            s: 0.1,
            point: [1.0, -0.0, 0.0],
            value: f64::NAN,
            starts: true,
        };
        with.probes[0].name = "one, \"two\"".to_string();
        with.probes[0].line = vec![place];
        let (dir, file) = (scratch.path(), scratch.path().join(LINES));
        let both = [with.clone(), with];
        write(&record(&model, &both), &held(dir)).unwrap();
        let text = fs::read_to_string(&file).unwrap();
        let row = "\"one, \"\"two\"\"\",0.1,1.0,0.0,NaN\n";
        assert_eq!(text, format!("{},value\n1,{row}2,{row}", csv::LINES_HEAD));
        write(&record(&model, from_ref(&solution)), &held(dir)).unwrap();
        assert!(!file.exists());
        // a foreign file
        fs::write(&file, b"mine").unwrap();
        write(&record(&model, from_ref(&solution)), &held(dir)).unwrap();
        assert_eq!(fs::read(&file).unwrap(), b"mine");
    }

    #[test]
    fn a_failing_target_leaves_nothing() {
        let scratch = tunnel::Scratch::new("failing");
        let (model, solution) = tunnel::solved();
        // The last file cannot get its name.
        let dir = scratch.path().join("out");
        fs::create_dir_all(dir.join("report.html")).unwrap();
        let error = write(&record(&model, from_ref(&solution)), &held(&dir)).unwrap_err();
        assert!(matches!(error, Error::IsADirectory { .. }), "{error}");
        assert_eq!(names(&dir), ["report.html"]);

        let file = scratch.path().join("file");
        fs::write(&file, b"mine").unwrap();
        for target in [file.clone(), file.join("below")] {
            let error = Folder::hold(&target).err().unwrap();
            assert!(error.to_string().contains("another folder"), "{error}");
        }
        assert_eq!(fs::read(&file).unwrap(), b"mine");
        assert_eq!(names(scratch.path()), ["file", "out"]);
    }

    #[test]
    fn a_failed_run_leaves_its_summary_only() {
        let scratch = tunnel::Scratch::new("summary");
        let (model, solution) = tunnel::solved();
        write(&record(&model, from_ref(&solution)), &held(scratch.path())).unwrap();
        write_summary(&record(&model, from_ref(&solution)), &held(scratch.path())).unwrap();
        assert_eq!(names(scratch.path()), ["summary.json"]);
        let text = fs::read_to_string(scratch.path().join("summary.json")).unwrap();
        assert!(text.contains("\"converged\": false"));
    }

    #[test]
    fn strange_names_and_foreign_solutions_are_refused() {
        let scratch = tunnel::Scratch::new("names");
        let (mut model, mut solution) = tunnel::solved();
        solution.bodies[1].von_mises.pop();
        let error = write(&record(&model, from_ref(&solution)), &held(scratch.path())).unwrap_err();
        assert!(error.to_string().contains("nodes of body rock"), "{error}");
        model.bodies[0].name = "../ring".to_string();
        let error = write(&record(&model, from_ref(&solution)), &held(scratch.path())).unwrap_err();
        assert!(matches!(error, Error::Name { .. }), "{error}");
        assert!(names(scratch.path()).is_empty());
    }
}
