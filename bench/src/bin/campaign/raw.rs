//! The data that the checker takes from a solution: only numbers, no functions.
//!
//! Meshes with their sides, nodal displacements, and the rows of `contact.csv`, of the plane or of space.

use crate::cells::Kind;
use crate::vector::{length, minus};
use std::collections::BTreeMap;

/// A mesh.
#[derive(Debug, Clone)]
pub struct Mesh<const D: usize = 2> {
    pub points: Vec<[f64; D]>,
    pub cells: Vec<(Kind, Vec<usize>)>,
    /// Nodes of the facets of each side: two ends with the cell on the left, in space the corners counter-clockwise from
    /// outside, then the middles of a quadratic facet.
    pub sides: BTreeMap<String, Vec<Vec<usize>>>,
}

impl<const D: usize> Mesh<D> {
    /// The facets of a side, or of several whose names are joined by plus signs.
    pub fn side(&self, names: &str) -> impl Iterator<Item = &Vec<usize>> {
        let each = names.split('+').filter_map(|name| self.sides.get(name));
        each.flatten()
    }

    /// The node nearest to a point.
    pub fn nearest(&self, point: [f64; D]) -> usize {
        let distance = |node: &usize| length(minus(self.points[*node], point));
        let nodes = 0..self.points.len();
        nodes
            .min_by(|a, b| distance(a).total_cmp(&distance(b)))
            .unwrap_or(0)
    }
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
pub struct Answer<const D: usize = 2> {
    pub meshes: Vec<Mesh<D>>,
    pub steps: Vec<Step<D>>,
}
