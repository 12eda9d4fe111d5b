//! An equivalent problem, and the difference of its displacements from those of the original.

use crate::elastic::fully_held;
use crate::problem::Problem;
use crate::raw::{Answer, Mesh, Step};
use crate::vector::{applied, bounds, length, minus, times, transposed, without_motion};

/// A twin, and the map of its answer to that of the original.
pub struct Twin<const D: usize> {
    pub name: &'static str,
    pub problem: Problem<D>,
    pub lengths: f64,
    /// Rows of the rotation that carries the original onto it.
    pub turn: [[f64; D]; D],
    /// Bodies of the twin that form each body of the original.
    pub parts: Vec<Vec<usize>>,
    /// Relative difference that is allowed.
    pub tolerance: f64,
}

/// Steps with displacements below this part of the largest ones count as steps without displacements.
const DUST: f64 = 1e-9;

/// The largest difference of the displacements of two answers in any step, relative to the largest displacement.
///
/// `None` where nodes of the twin cannot be found.
pub fn difference<const D: usize>(
    problem: &Problem<D>,
    answer: &Answer<D>,
    twin: &Twin<D>,
    other: &Answer<D>,
) -> Option<f64> {
    let mut worst: f64 = 0.0;
    let largest = |step: &Step<D>| {
        let all = step.displacements.iter().flatten();
        all.fold(0.0, |s: f64, &u| s.max(length(u)))
    };
    let overall = answer.steps.iter().map(largest).fold(0.0, f64::max);
    for (mine, theirs) in answer.steps.iter().zip(&other.steps) {
        let largest = largest(mine);
        // the displacements are only rounding
        if largest <= DUST * overall {
            continue;
        }
        let mut off: f64 = 0.0;
        for (b, parts) in twin.parts.iter().enumerate() {
            let mesh = &answer.meshes[b];
            let found = found(&mesh.points, parts, other, twin, theirs)?;
            let differences: Vec<[f64; D]> = mine.displacements[b]
                .iter()
                .zip(&found)
                .map(|(&u, &v)| minus(v, u))
                .collect();
            let rest = determined(problem, b, mesh, differences);
            off = rest.iter().fold(off, |s, &d| s.max(length(d)));
        }
        if largest > 0.0 {
            worst = worst.max(off / largest);
        }
    }
    Some(worst)
}

/// Displacements of a body without the undetermined rigid motion.
fn determined<const D: usize>(
    problem: &Problem<D>,
    body: usize,
    mesh: &Mesh<D>,
    moves: Vec<[f64; D]>,
) -> Vec<[f64; D]> {
    let (analysis, start) = (problem.analysis, problem.times[0]);
    if fully_held(mesh, &problem.bodies[body], analysis, start) {
        moves
    } else {
        without_motion(&mesh.points, &moves, analysis.axisymmetric())
    }
}

/// Displacements of a body of the original from the answer of a twin, at the original's nodes and in its units.
fn found<const D: usize>(
    points: &[[f64; D]],
    parts: &[usize],
    other: &Answer<D>,
    twin: &Twin<D>,
    step: &Step<D>,
) -> Option<Vec<[f64; D]>> {
    let home = transposed(twin.turn);
    let back = |x: [f64; D]| times(1.0 / twin.lengths, applied(home, x));
    let mut places: Vec<([f64; D], [f64; D])> = Vec::new();
    for &part in parts {
        let moves = &step.displacements[part];
        places.extend(
            other.meshes[part]
                .points
                .iter()
                .zip(moves)
                .map(|(&x, &u)| (back(x), back(u))),
        );
    }
    let (low, high) = bounds(points);
    let near = 1e-7 * length(minus(high, low));
    // the same order, mostly; else sorted along x
    if places.len() == points.len()
        && points
            .iter()
            .zip(&places)
            .all(|(&x, (y, _))| length(minus(x, *y)) < near)
    {
        return Some(places.into_iter().map(|(_, u)| u).collect());
    }
    places.sort_by(|a, b| a.0[0].total_cmp(&b.0[0]));
    let find = |&x: &[f64; D]| {
        let start = places.partition_point(|(y, _)| y[0] < x[0] - near);
        let window = places[start..]
            .iter()
            .take_while(|(y, _)| y[0] <= x[0] + near);
        let mut window = window.filter(|(y, _)| length(minus(*y, x)) < near);
        window.next().map(|(_, u)| *u)
    };
    points.iter().map(find).collect()
}
