//! Calls of the program: case text in, raw numbers out. The only file that uses the library.

use crate::cells::Kind;
use crate::problem::Problem;
use crate::raw::{self, Answer, Mesh, Row, Step};
use dotyk::case::{Case, CaseError, Run};
use dotyk::model::{ContactNode, Event, Model, Past, Solution, Status};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};
use std::time::Instant;

/// The outcome of a run of the program.
#[derive(Debug)]
pub enum Outcome<A> {
    /// All steps are certified.
    Certified(A),
    /// Exit status 1; the steps before the failing one are certified.
    NotConverged(String, Option<A>),
    /// Exit status 2.
    Refused(String),
    Panicked(String),
    /// It was stopped at the limit of time.
    Slow,
}

/// Panic payload with which the observer stops a run that takes too long.
struct TooSlow;

/// A folder for mesh files that is removed when it is dropped.
pub struct Folder(PathBuf);

impl Folder {
    /// A folder of its own for each name.
    pub fn new(name: &str) -> std::io::Result<Self> {
        let path =
            std::env::temp_dir().join(format!("dotyk-campaign-{}-{name}", std::process::id()));
        std::fs::create_dir_all(&path)?;
        Ok(Self(path))
    }

    /// Its path.
    pub fn path(&self) -> &Path {
        &self.0
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        // an error is ignored: the folder is among the temporary files
        let _ = std::fs::remove_dir_all(&self.0);
    }
}

/// Functions of the library that exist separately for the plane and for space.
pub trait Solvable<const D: usize>: Sized {
    /// Reads the text of a case file.
    fn parsed(text: &str, folder: &Path) -> Result<Case<D>, CaseError>;

    /// Solves all its load steps.
    fn solved(case: &Case<D>, past: &[Past<D>], observe: &mut dyn FnMut(Event)) -> Run<D>;
}

macro_rules! solvable {
    ($($D:literal)*) => {$(
        impl Solvable<$D> for Problem<$D> {
            fn parsed(text: &str, folder: &Path) -> Result<Case<$D>, CaseError> {
                Case::<$D>::from_str(text, "case.toml", folder)
            }

            fn solved(
                case: &Case<$D>,
                past: &[Past<$D>],
                observe: &mut dyn FnMut(Event),
            ) -> Run<$D> {
                case.run(past, observe)
            }
        }
    )*};
}

solvable!(2 3);

/// Writes the mesh files of a problem.
pub fn write_meshes<const D: usize>(problem: &Problem<D>, folder: &Path) -> std::io::Result<()> {
    for (name, text) in problem.files() {
        std::fs::write(folder.join(name), text)?;
    }
    Ok(())
}

/// Solves a problem from its case file, in some seconds at most.
pub fn solve<const D: usize>(
    problem: &Problem<D>,
    folder: &Folder,
    seconds: f64,
) -> Outcome<Answer<D>>
where
    Problem<D>: Solvable<D>,
{
    if let Err(error) = write_meshes(problem, folder.path()) {
        return Outcome::Refused(format!("campaign: {error}"));
    }
    let text = problem.text();
    let past = problem.past;
    let attempt = catch_unwind(AssertUnwindSafe(|| {
        attempt(&text, folder.path(), past, seconds)
    }));
    match attempt {
        Ok(outcome) => outcome,
        Err(payload) if payload.is::<TooSlow>() => Outcome::Slow,
        Err(payload) => {
            let text = payload.downcast_ref::<String>().cloned();
            let text = text.or_else(|| payload.downcast_ref::<&str>().map(|s| (*s).to_string()));
            Outcome::Panicked(text.unwrap_or_else(|| "panic without a text".to_string()))
        }
    }
}

fn attempt<const D: usize>(
    text: &str,
    folder: &Path,
    past: usize,
    seconds: f64,
) -> Outcome<Answer<D>>
where
    Problem<D>: Solvable<D>,
{
    let case = match Problem::<D>::parsed(text, folder) {
        Ok(case) => case,
        Err(error) => return Outcome::Refused(format!("case file: {error}")),
    };
    let clock = Instant::now();
    let mut watch = |_| {
        if clock.elapsed().as_secs_f64() > seconds {
            std::panic::panic_any(TooSlow);
        }
    };
    let mut run = Problem::solved(&case, &[], &mut watch);
    if past > 0 && run.failure.is_none() {
        let done: Vec<Past<D>> = run.steps[..past].iter().map(Past::from).collect();
        run = Problem::solved(&case, &done, &mut watch);
    }
    let Some(failure) = &run.failure else {
        return Outcome::Certified(answer(&case.model, &run.steps));
    };
    if let Some(refusal) = &failure.refusal {
        return Outcome::Refused(refusal.message.clone());
    }
    let certified = &run.steps[..failure.step - 1];
    let steps = (!certified.is_empty()).then(|| answer(&case.model, certified));
    Outcome::NotConverged(failure.reason.clone(), steps)
}

/// The meshes that the program makes from a case file without mesh files.
pub fn meshes<const D: usize>(text: &str) -> Result<Vec<Mesh<D>>, String>
where
    Problem<D>: Solvable<D>,
{
    let case = Problem::<D>::parsed(text, Path::new(".")).map_err(|error| error.to_string())?;
    Ok(case
        .model
        .bodies
        .iter()
        .map(|body| mesh(&body.mesh))
        .collect())
}

fn answer<const D: usize>(model: &Model<D>, steps: &[Solution<D>]) -> Answer<D> {
    let meshes: Vec<Mesh<D>> = model.bodies.iter().map(|body| mesh(&body.mesh)).collect();
    let mut steps: Vec<Step<D>> = steps.iter().map(step).collect();
    // a body before its first step has no displacements
    for step in &mut steps {
        for (moves, mesh) in step.displacements.iter_mut().zip(&meshes) {
            moves.resize(mesh.points.len(), [0.0; D]);
        }
    }
    Answer { meshes, steps }
}

/// The points, cells and sides of a mesh.
fn mesh<const D: usize>(mesh: &dotyk::mesh::Mesh<D>) -> Mesh<D> {
    let mut cells = Vec::new();
    let mut firsts = Vec::new();
    for block in mesh.blocks() {
        firsts.push(cells.len());
        let mut kinds = Kind::PLANE.into_iter().chain(Kind::SPACE);
        let kind = kinds
            .find(|kind| kind.name() == block.kind.name())
            .unwrap_or_else(|| panic!("the campaign has no cell {}", block.kind.name()));
        cells.extend(
            block
                .cells()
                .map(|nodes| (kind, nodes.iter().map(|&n| n as usize).collect::<Vec<_>>())),
        );
    }
    let sides = mesh.sides().iter().map(|(name, facets)| {
        let nodes = facets.iter().map(|facet| {
            let (kind, nodes) = &cells[firsts[facet.block as usize] + facet.cell as usize];
            kind.facet(facet.local as usize)
                .iter()
                .map(|&i| nodes[i])
                .collect()
        });
        (name.clone(), nodes.collect())
    });
    let sides = sides.collect();
    Mesh {
        points: mesh.points().to_vec(),
        cells,
        sides,
    }
}

fn step<const D: usize>(solution: &Solution<D>) -> Step<D> {
    let contact = |contact: &dotyk::model::ContactSolution<D>| {
        // resultants refer to the side that is named first, rows to the nonmortar side
        let turned = contact.first != contact.nonmortar;
        let sign = if turned { -1.0 } else { 1.0 };
        raw::Contact {
            nonmortar: (contact.nonmortar.body.0, contact.nonmortar.side.clone()),
            rows: contact.nodes.iter().map(row).collect(),
            resultant: contact.resultant.map(|f| sign * f),
            moment: contact.moment.map(|m| sign * m),
        }
    };
    Step {
        time: solution.time,
        displacements: solution
            .bodies
            .iter()
            .map(|body| body.displacement.clone())
            .collect(),
        sections: solution.sections.iter().map(section).collect(),
        reactions: solution.bodies.iter().map(|body| body.reaction).collect(),
        contacts: solution.contacts.iter().map(contact).collect(),
        iterations: solution.solver.iterations,
        tried: solution.solver.tried.clone(),
        rounding: solution.certificate.rounding.value,
        dropped: solution
            .warnings
            .iter()
            .any(|text| text.contains("it is dropped")),
    }
}

/// The columns of `sections.csv`.
fn section(section: &dotyk::model::SectionSolution) -> Vec<[f64; 5]> {
    let stations = section.stations.iter();
    stations
        .map(|at| [at.point[0], at.point[1], at.normal, at.shear, at.moment])
        .collect()
}

/// The columns of `contact.csv`.
fn row<const D: usize>(node: &ContactNode<D>) -> Row<D> {
    Row {
        node: node.node,
        normal: node.normal,
        weight: node.weight,
        gap: node.gap,
        pressure: node.pressure,
        shear: node.shear,
        slip: node.slip,
        status: match node.status {
            Status::Open => raw::Status::Open,
            Status::Closed => raw::Status::Closed,
            Status::Stick => raw::Status::Stick,
            Status::Slip => raw::Status::Slip,
            Status::Tied => raw::Status::Tied,
            Status::Fixed => raw::Status::Fixed,
        },
    }
}
