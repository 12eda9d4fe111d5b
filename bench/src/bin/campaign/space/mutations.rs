//! A checker that cannot fail is worth nothing: right answers, spoiled one way each, and the check that must notice.

use super::problem::{Body, Field, Shape};
use super::solids::Solid;
use super::{Mesh, Problem};
use crate::problem::Known;

/// A body without supports and loads.
pub fn body(name: &str, shape: Shape, kind: Solid) -> Body {
    Body {
        name: name.to_string(),
        shape,
        kind,
        young: 1.0,
        poisson: 0.3,
        supports: Vec::new(),
        loads: Vec::new(),
        weight: Field::default(),
        surfaces: Vec::new(),
    }
}

pub fn cuboid(from: [f64; 3], to: [f64; 3], cells: [usize; 3]) -> Shape {
    Shape::Cuboid { from, to, cells }
}

pub fn ball(center: [f64; 3], radius: f64, cells: [usize; 2]) -> Shape {
    Shape::Ball {
        center,
        radius,
        cells,
    }
}

fn problem(bodies: Vec<Body>, count: usize) -> Problem {
    Problem {
        family: "mutations",
        bodies,
        contacts: Vec::new(),
        times: (1..=count).map(|t| t as f64).collect(),
        known: Known::Holds,
        reason: String::new(),
        uniform: None,
        spins: false,
        method: "auto".to_string(),
    }
}

/// The mesh that the program makes of a body.
pub fn mesh_of(body: &Body) -> Mesh {
    let text = problem(vec![body.clone()], 1).text();
    crate::solve::meshes(&text).unwrap().remove(0)
}
