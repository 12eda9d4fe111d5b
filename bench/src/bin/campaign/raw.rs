//! The data that the checker takes from a solution: only numbers, no functions.
//!
//! Meshes with their sides, nodal displacements, and the rows of `contact.csv`, of the plane or of space.

use crate::cells::Kind;
use crate::plane::turned;
use crate::vector::dot;
use std::collections::BTreeMap;

/// Kinds of cells of the plane, or of space.
pub trait Cell: Copy + std::fmt::Debug + 'static {
    /// All of them.
    const ALL: &'static [Self];

    /// The name in a case file.
    fn name(self) -> &'static str;

    /// Local nodes of a facet, in the order of the facet's own kind.
    fn facet(self, local: usize) -> Vec<usize>;
}

/// A mesh.
#[derive(Debug, Clone)]
pub struct Mesh<const D: usize = 2, K = Kind> {
    pub points: Vec<[f64; D]>,
    pub cells: Vec<(K, Vec<usize>)>,
    /// Nodes of the facets of each side: two ends with the cell on the left, in space the corners counter-clockwise from
    /// outside, then the middles of a quadratic facet.
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
pub struct Row<const D: usize = 2> {
    pub node: usize,
    pub normal: [f64; D],
    pub weight: f64,
    pub gap: f64,
    pub pressure: f64,
    /// Traction on the nonmortar body.
    pub shear: [f64; D],
    /// Slip of the nonmortar side relative to the other.
    pub slip: [f64; D],
    pub status: Status,
}

impl Row {
    /// Shear along the normal turned by +90°.
    pub fn shear(&self) -> f64 {
        dot(self.shear, turned(self.normal))
    }
}

/// One contact of one step.
#[derive(Debug, Clone)]
pub struct Contact<const D: usize = 2> {
    pub nonmortar: (usize, String),
    pub rows: Vec<Row<D>>,
    /// Force on the nonmortar body.
    pub resultant: [f64; D],
    /// Its moment about the origin.
    pub moment: [f64; 3],
}

/// One load step that the program calls converged.
#[derive(Debug, Clone)]
pub struct Step<const D: usize = 2> {
    pub time: f64,
    /// Displacement of every node of every body, in the order of the problem.
    pub displacements: Vec<Vec<[f64; D]>>,
    /// Force of its supports on each body.
    pub reactions: Vec<[f64; D]>,
    /// The contacts, in the order of the problem.
    pub contacts: Vec<Contact<D>>,
    /// Section forces of each section at each station: x, y, N, V, M.
    pub sections: Vec<Vec<[f64; 5]>>,
    pub iterations: usize,
    /// The entered stages of the solver; the last one gave the answer.
    pub tried: Vec<&'static str>,
    /// The rounding of a force, as reported by the program.
    pub rounding: f64,
    /// The program warns that it dropped conditions: for the report, the checker does not ask.
    pub dropped: bool,
}

/// All of it.
#[derive(Debug, Clone)]
pub struct Answer<const D: usize = 2, K = Kind> {
    pub meshes: Vec<Mesh<D, K>>,
    pub steps: Vec<Step<D>>,
}
