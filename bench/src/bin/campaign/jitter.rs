//! Skew cells.

use crate::problem::{Body, Shape};
use crate::random::Random;
use crate::raw::Mesh;
use crate::vector::plus;

/// Moves the nodes of a block at random by this part of a cell, those on its boundary along it, and puts the nodes between
/// corners in their middles: cells become skew, facets tapered.
pub fn jitter<const D: usize>(body: &Body<D>, mesh: &mut Mesh<D>, part: f64, random: &mut Random) {
    let Shape::Block {
        from, to, cells, ..
    } = body.shape
    else {
        return;
    };
    let mut moved: Vec<[f64; D]> = mesh.points.clone();
    for x in &mut moved {
        let by: [f64; D] = std::array::from_fn(|d| {
            let size = to[d] - from[d];
            let inside = (x[d] - from[d]).min(to[d] - x[d]) > 1e-9 * size;
            let by = part * size / cells[d] as f64 * random.between(-1.0, 1.0);
            if inside { by } else { 0.0 }
        });
        *x = plus(*x, 1.0, by);
    }
    for (kind, nodes) in &mesh.cells {
        let corners = &nodes[..kind.corners().len()];
        let corners: Vec<[f64; D]> = corners.iter().map(|&n| moved[n]).collect();
        for (&node, place) in nodes.iter().zip(kind.places(&corners)) {
            mesh.points[node] = place;
        }
    }
}
