//! Supports: conditions on displacements, and the directions that they leave free.

use crate::vector::{dot, length, plus, unit};
use std::collections::BTreeMap;

/// axis·u = value at a node.
#[derive(Debug, Clone, Copy)]
pub struct Condition<const D: usize = 2> {
    pub node: usize,
    pub axis: [f64; D],
    pub value: f64,
}

/// Orthonormal held directions of each supported node.
pub fn held_axes<const D: usize>(conditions: &[Condition<D>]) -> BTreeMap<usize, Vec<[f64; D]>> {
    let mut axes: BTreeMap<usize, Vec<[f64; D]>> = BTreeMap::new();
    for condition in conditions {
        let held = axes.entry(condition.node).or_default();
        let rest = held.iter().fold(condition.axis, |rest, &axis| {
            plus(rest, -dot(rest, axis), axis)
        });
        if length(rest) > 1e-8 {
            held.push(unit(rest));
        }
    }
    axes
}

/// A vector without its parts along held directions.
pub fn free_part<const D: usize>(vector: [f64; D], held: Option<&Vec<[f64; D]>>) -> [f64; D] {
    let axes = held.into_iter().flatten();
    axes.fold(vector, |rest, &axis| plus(rest, -dot(vector, axis), axis))
}
