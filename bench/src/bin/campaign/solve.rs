//! Asking the program: case text in, raw numbers out. The only file that knows the program.

use crate::cells::Kind;
use crate::plane::{Vector, dot, turned};
use crate::problem::{Problem, Shape};
use crate::raw::{self, Answer, Mesh, Row, Step};
use dotyk::case::Case;
use dotyk::model::{ContactNode, Model, Solution, Status};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};
use std::time::Instant;

/// What the program said.
#[derive(Debug)]
pub enum Outcome {
    /// All steps are certified.
    Certified(Answer),
    /// Exit status 1; the steps before the failing one are certified.
    NotConverged(String, Option<Answer>),
    /// Exit status 2.
    Refused(String),
    Panicked(String),
    /// It was stopped at the limit of time.
    Slow,
}

/// What an observer throws to stop a run that takes too long.
struct TooSlow;

/// A folder for mesh files that goes when it is dropped.
pub struct Folder(PathBuf);

impl Folder {
    /// A folder of its own for each name.
    pub fn new(name: &str) -> std::io::Result<Self> {
        let path =
            std::env::temp_dir().join(format!("dotyk-campaign-{}-{name}", std::process::id()));
        std::fs::create_dir_all(&path)?;
        Ok(Self(path))
    }

    /// Where it is.
    pub fn path(&self) -> &Path {
        &self.0
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        // what is left behind lies in the folder of temporary files
        let _ = std::fs::remove_dir_all(&self.0);
    }
}

/// Writes the mesh files of a problem.
pub fn write_meshes(problem: &Problem, folder: &Path) -> std::io::Result<()> {
    for body in &problem.bodies {
        if let Shape::File { name, text } = &body.shape {
            std::fs::write(folder.join(name), text)?;
        }
    }
    Ok(())
}

/// Solves a problem from its case file, in some seconds at most.
pub fn solve(problem: &Problem, folder: &Folder, seconds: f64) -> Outcome {
    if let Err(error) = write_meshes(problem, folder.path()) {
        return Outcome::Refused(format!("campaign: {error}"));
    }
    let text = problem.text();
    let attempt = catch_unwind(AssertUnwindSafe(|| attempt(&text, folder.path(), seconds)));
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

fn attempt(text: &str, folder: &Path, seconds: f64) -> Outcome {
    let case = match Case::<2>::from_str(text, "case.toml", folder) {
        Ok(case) => case,
        Err(error) => return Outcome::Refused(format!("case file: {error}")),
    };
    let clock = Instant::now();
    let mut watch = |_| {
        if clock.elapsed().as_secs_f64() > seconds {
            std::panic::panic_any(TooSlow);
        }
    };
    let run = case.run(&[], &mut watch);
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

fn answer(model: &Model<2>, steps: &[Solution<2>]) -> Answer {
    Answer {
        meshes: model.bodies.iter().map(|body| mesh(&body.mesh)).collect(),
        steps: steps.iter().map(step).collect(),
    }
}

/// The points, cells and sides of a mesh.
pub fn mesh(mesh: &dotyk::mesh::Mesh<2>) -> Mesh {
    let mut cells = Vec::new();
    let mut firsts = Vec::new();
    for block in mesh.blocks() {
        firsts.push(cells.len());
        let kind = Kind::ALL
            .into_iter()
            .find(|kind| kind.name() == block.kind.name())
            .unwrap_or_else(|| panic!("the plane has no cell {}", block.kind.name()));
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

fn step(solution: &Solution<2>) -> Step {
    let contact = |contact: &dotyk::model::ContactSolution<2>| raw::Contact {
        nonmortar: (contact.nonmortar.body.0, contact.nonmortar.side.clone()),
        rows: contact.nodes.iter().map(row).collect(),
        resultant: contact.resultant,
    };
    Step {
        time: solution.time,
        displacements: solution
            .bodies
            .iter()
            .map(|body| body.displacement.clone())
            .collect(),
        reactions: solution.bodies.iter().map(|body| body.reaction).collect(),
        contacts: solution.contacts.iter().map(contact).collect(),
        iterations: solution.solver.iterations,
        dropped: solution
            .warnings
            .iter()
            .any(|text| text.contains("it is dropped")),
    }
}

/// The columns of `contact.csv`.
fn row(node: &ContactNode<2>) -> Row {
    let tangent: Vector = turned(node.normal);
    Row {
        node: node.node,
        normal: node.normal,
        weight: node.weight,
        gap: node.gap,
        pressure: node.pressure,
        shear: dot(node.shear, tangent),
        slip: dot(node.slip, tangent),
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
