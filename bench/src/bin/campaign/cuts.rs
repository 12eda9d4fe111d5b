//! Section forces, computed from the stresses and loads of the cells on one hand of a cut.
//!
//! ```text
//!   f = internal − external force at the nodes on the cut, of the cells ahead alone: what those behind exert on them
//!   N = −Σ fₓ/t,   V = Σ f_y/t,   M = −Σ fₓ (y − y_c)/t        the first side above, s along x, t the thickness
//! ```
//!
//! For cuts along lines of the mesh whose nodes carry no contact and no support other than that of the cut. At the far end the
//! force is computed from the cells behind the cut, with the opposite sign.
//! The program spreads nodal forces of contacts over their sides by consistent tractions, which alternate and decay beside the
//! pressed part: the decayed part is allowed (a factor LEAK per facet of distance).

use crate::check::View;
use crate::elastic::{bedded, external, internal};
use crate::judgement::Judgement;
use crate::raw::Mesh;
use crate::vector::{bounds, length, minus};

/// Largest factor between such tractions of one facet and the next.
const LEAK: f64 = 0.4;

/// Largest part of the contact forces on a body that may leak into a cut.
fn leak(view: &View<'_, 2>, body: usize, at: f64) -> f64 {
    let mesh = &view.answer.meshes[body];
    let mut sum = 0.0;
    for c in 0..view.touches.len() {
        for (_, skin, _) in view.sides(c).filter(|(own, ..)| *own == body) {
            for &node in skin.around.keys() {
                let between = (mesh.points[node][0] - at).abs() / skin.longest;
                // forces of supports are not spread
                let force = view.state.free(body, node, view.state.rest[body][node]);
                sum += length(force) * LEAK.powf(between - 1.0);
            }
        }
    }
    sum
}

/// The cells on one side of a vertical line, with the sides of the mesh on them.
fn part(mesh: &Mesh, at: f64, ahead: bool) -> Mesh {
    let middle = |nodes: &[usize]| {
        nodes.iter().map(|&n| mesh.points[n][0]).sum::<f64>() / nodes.len() as f64
    };
    let keep = |nodes: &[usize]| (middle(nodes) > at) == ahead;
    let cells = mesh.cells.iter().filter(|(_, nodes)| keep(nodes));
    let sides = mesh.sides.iter().map(|(name, facets)| {
        let own = facets.iter().filter(|nodes| keep(nodes));
        (name.clone(), own.cloned().collect())
    });
    Mesh {
        points: mesh.points.clone(),
        cells: cells.cloned().collect(),
        sides: sides.collect(),
    }
}

/// Judges the section forces of a step.
pub fn check_sections(judgement: &mut Judgement, view: &View<'_, 2>) {
    let analysis = view.problem.analysis;
    for (section, told) in view.problem.sections.iter().zip(&view.step.sections) {
        let place = view.problem.body(&section.body);
        let (body, mesh) = (&view.problem.bodies[place], &view.answer.meshes[place]);
        let moves = &view.step.displacements[place];
        let (low, high) = bounds(&mesh.points);
        let near = 1e-9 * length(minus(high, low));
        let deep = high[1] - low[1];
        for (&station, told) in section.stations.iter().zip(told) {
            let ahead = station[0] < high[0] - near;
            let cells = part(mesh, station[0], ahead);
            let inside = internal(&cells, body, analysis, moves, 0.0).forces;
            let outside = external(&cells, body, analysis, view.step.time);
            let beds = bedded(&cells, body, analysis, moves);
            let middle = 0.5 * (low[1] + high[1]);
            let [mut n, mut v, mut m] = [0.0; 3];
            let mut limit = 0.0;
            for (node, x) in mesh.points.iter().enumerate() {
                if (x[0] - station[0]).abs() > near {
                    continue;
                }
                let f = minus(minus(inside[node], outside[node]), beds[node]);
                n -= f[0];
                v += f[1];
                m -= f[0] * (x[1] - middle);
                limit += 10.0 * view.state.limits[place][node];
            }
            let sign = if ahead { 1.0 } else { -1.0 } / body.thickness;
            limit = (limit + leak(view, place, station[0])) / body.thickness;
            let compared = [
                ("N", told[2], sign * n, 1.0),
                ("V", told[3], sign * v, 1.0),
                ("M", told[4], sign * m, deep),
            ];
            for (name, told, own, arm) in compared {
                judgement.compare("section", (told - own).abs(), limit * arm, || {
                    format!(
                        "{name} of {} at x = {:.6e}: {told:.6e}, {own:.6e}",
                        section.name, station[0]
                    )
                });
            }
        }
    }
}
