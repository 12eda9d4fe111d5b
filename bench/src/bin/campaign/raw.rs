//! What the checker takes from a solution: numbers, and nothing that computes.
//!
//! Meshes with their sides, nodal displacements, and the rows of `contact.csv`.

use crate::cells::Kind;
use crate::plane::Vector;
use std::collections::BTreeMap;

/// A mesh.
#[derive(Debug, Clone)]
pub struct Mesh {
    pub points: Vec<Vector>,
    pub cells: Vec<(Kind, Vec<usize>)>,
    /// Nodes of the facets of each side: two ends with the cell on the left, then the middle of a quadratic facet.
    pub sides: BTreeMap<String, Vec<Vec<usize>>>,
}

/// State of a contact node.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Status {
    Open,
    Closed,
    Stick,
    Slip,
    Tied,
    Fixed,
}

/// A row of `contact.csv`.
#[derive(Debug, Clone, Copy)]
pub struct Row {
    pub node: usize,
    pub normal: Vector,
    pub weight: f64,
    pub gap: f64,
    pub pressure: f64,
    /// Along the normal turned by +90°.
    pub shear: f64,
    pub slip: f64,
    pub status: Status,
}

/// One contact of one step.
#[derive(Debug, Clone)]
pub struct Contact {
    pub nonmortar: (usize, String),
    pub rows: Vec<Row>,
    /// Force on the nonmortar body.
    pub resultant: Vector,
}

/// One load step that the program calls converged.
#[derive(Debug, Clone)]
pub struct Step {
    pub time: f64,
    /// Of every node of every body, in the order of the problem.
    pub displacements: Vec<Vec<Vector>>,
    /// Force of its supports on each body.
    pub reactions: Vec<Vector>,
    /// In the order of the problem.
    pub contacts: Vec<Contact>,
    pub iterations: usize,
    /// The program warns that it dropped conditions: for the report, the checker does not ask.
    pub dropped: bool,
}

/// All of it.
#[derive(Debug, Clone)]
pub struct Answer {
    pub meshes: Vec<Mesh>,
    pub steps: Vec<Step>,
}
