//! Elasticity, written independently of the program: nodal forces of stresses and of loads, and the conditions of supports.
//!
//! ```text
//!   internal force of node a   fₐ = ∫ σ(u)·∇Nₐ dV     with symmetry about an axis  fₐ,r += ∫ σ_θθ Nₐ/r dV, dV = 2πr dA
//!   external force             fₐ = ∫ N t dS + ∫ N b dV + forces at nodes
//! ```
//!
//! Hooke's law by Young's modulus and Poisson's ratio, as textbooks write the matrices of plane strain, plane stress
//! and axial symmetry. The difference of internal and external force is the force of supports and contacts on a node.

use crate::amount::vector_at;
use crate::cells::{along, gauss};
use crate::held::Condition;
use crate::plane::{Vector, bounds, dot, length, minus, plus, times, unit};
use crate::problem::{Analysis, Body, Load, Place, Support};
use crate::raw::Mesh;
use std::collections::BTreeMap;
use std::f64::consts::TAU;

/// Nodal forces of the stresses of a body.
pub struct Internal {
    pub forces: Vec<Vector>,
    /// Σ|K||u| at each node: rounding of the displacements changes the forces by this times 2⁻⁵³. Displacements below `least` count
    /// as `least`.
    pub magnitudes: Vec<f64>,
}

/// The matrix of Hooke's law on (εxx, εyy, 2εxy, ε_θθ).
fn hooke((e, v): (f64, f64), analysis: Analysis) -> [[f64; 4]; 4] {
    let shear = e / (2.0 * (1.0 + v));
    match analysis {
        Analysis::PlaneStress => {
            let c = e / (1.0 - v * v);
            [
                [c, c * v, 0.0, 0.0],
                [c * v, c, 0.0, 0.0],
                [0.0, 0.0, shear, 0.0],
                [0.0; 4],
            ]
        }
        _ => {
            let c = e / ((1.0 + v) * (1.0 - 2.0 * v));
            let (a, b) = (c * (1.0 - v), c * v);
            let hoop = if analysis.axisymmetric() {
                [a, b]
            } else {
                [0.0; 2]
            };
            [
                [a, b, 0.0, hoop[1]],
                [b, a, 0.0, hoop[1]],
                [0.0, 0.0, shear, 0.0],
                [hoop[1], hoop[1], 0.0, hoop[0]],
            ]
        }
    }
}

/// Thickness, or the circumference around the axis.
pub fn depth(body: &Body, analysis: Analysis, x: Vector) -> f64 {
    if analysis.axisymmetric() {
        TAU * x[0]
    } else {
        body.thickness
    }
}

/// A Gauss point of a cell: place, gradients of the shape functions, shape functions, area.
pub struct Station {
    pub x: Vector,
    pub gradients: Vec<Vector>,
    pub shape: Vec<f64>,
    pub area: f64,
}

/// The station of a cell at reference coordinates.
pub fn station(mesh: &Mesh, cell: usize, xi: Vector, weight: f64) -> Station {
    let (kind, nodes) = &mesh.cells[cell];
    let (shape, slopes) = kind.shape(xi);
    let mut x = [0.0; 2];
    let mut jacobian = [[0.0; 2]; 2];
    for (&node, (n, slope)) in nodes.iter().zip(shape.iter().zip(&slopes)) {
        let p = mesh.points[node];
        x = plus(x, *n, p);
        for i in 0..2 {
            for j in 0..2 {
                jacobian[i][j] += p[i] * slope[j];
            }
        }
    }
    let [[a, b], [c, d]] = jacobian;
    let volume = a * d - b * c;
    // gradients by the inverse transpose of the Jacobian
    let gradient = |s: &Vector| {
        [
            (d * s[0] - c * s[1]) / volume,
            (a * s[1] - b * s[0]) / volume,
        ]
    };
    Station {
        x,
        gradients: slopes.iter().map(gradient).collect(),
        shape,
        area: weight * volume,
    }
}

/// Nodal forces of the stresses that displacements cause.
pub fn internal(
    mesh: &Mesh,
    body: &Body,
    analysis: Analysis,
    moves: &[Vector],
    least: f64,
) -> Internal {
    let axisymmetric = analysis.axisymmetric();
    let own = hooke((body.young, body.poisson), analysis);
    let beyond = body.more.beyond.as_ref();
    let other = beyond.map(|b| (b.border, hooke((b.young, b.poisson), analysis)));
    let mut out = Internal {
        forces: vec![[0.0; 2]; moves.len()],
        magnitudes: vec![0.0; moves.len()],
    };
    for (cell, (kind, nodes)) in mesh.cells.iter().enumerate() {
        let middle = nodes.iter().map(|&n| mesh.points[n][0]).sum::<f64>() / nodes.len() as f64;
        let law = match other {
            Some((border, law)) if middle > border => law,
            _ => own,
        };
        let stiff = law.iter().flatten().fold(0.0, |s: f64, c| s.max(*c));
        // the translation of the cell is removed: it causes no strain, only rounding
        let first = moves[nodes[0]];
        let largest = nodes
            .iter()
            .fold(least, |s: f64, &n| s.max(length(moves[n])));
        for (xi, weight) in kind.rule(axisymmetric) {
            let at = station(mesh, cell, xi, weight);
            let volume = at.area * depth(body, analysis, at.x);
            let mut strain = [0.0; 4];
            let mut slopes = 0.0;
            for ((&node, g), n) in nodes.iter().zip(&at.gradients).zip(&at.shape) {
                let u = minus(moves[node], first);
                strain[0] += g[0] * u[0];
                strain[1] += g[1] * u[1];
                strain[2] += g[1] * u[0] + g[0] * u[1];
                if axisymmetric {
                    strain[3] += n * moves[node][0] / at.x[0];
                }
                slopes += length(*g);
            }
            let stress: [f64; 4] =
                std::array::from_fn(|i| (0..4).map(|j| law[i][j] * strain[j]).sum());
            for ((&node, g), n) in nodes.iter().zip(&at.gradients).zip(&at.shape) {
                let mut force = [
                    stress[0] * g[0] + stress[2] * g[1],
                    stress[2] * g[0] + stress[1] * g[1],
                ];
                if axisymmetric {
                    force[0] += stress[3] * n / at.x[0];
                }
                out.forces[node] = plus(out.forces[node], volume, force);
                out.magnitudes[node] += volume * stiff * length(*g) * slopes * largest;
            }
        }
    }
    out
}

/// Nodal forces of the loads of a body at a time.
pub fn external(mesh: &Mesh, body: &Body, analysis: Analysis, t: f64) -> Vec<Vector> {
    let mut forces = vec![[0.0; 2]; mesh.points.len()];
    for load in &body.loads {
        match load {
            Load::Traction { side, field } => {
                add_on_side(mesh, body, analysis, side, &mut forces, |x, _| {
                    vector_at(field, x, t)
                });
            }
            Load::Pressure { side, field } => {
                add_on_side(mesh, body, analysis, side, &mut forces, |x, normal| {
                    times(-field.at(x, t), normal)
                });
            }
            Load::Force { point, field } => {
                let node = nearest(mesh, *point);
                forces[node] = plus(forces[node], 1.0, vector_at(field, mesh.points[node], t));
            }
            Load::InSitu { side, factor } => {
                add_on_side(mesh, body, analysis, side, &mut forces, |x, [nx, ny]| {
                    let [xx, yy, _, xy] = initial_at(body, x);
                    let pull = [xx * nx + xy * ny, xy * nx + yy * ny];
                    times(factor.at(x, t), pull)
                });
            }
        }
    }
    if body.more.initial.is_some() {
        resist_initial(mesh, body, analysis, &mut forces);
    }
    if body.weight.iter().any(|w| !w.is_zero()) {
        for (cell, (kind, nodes)) in mesh.cells.iter().enumerate() {
            for (xi, weight) in kind.fine_rule() {
                let at = station(mesh, cell, xi, weight);
                let volume = at.area * depth(body, analysis, at.x);
                let force = times(volume, vector_at(&body.weight, at.x, t));
                for (&node, n) in nodes.iter().zip(&at.shape) {
                    forces[node] = plus(forces[node], *n, force);
                }
            }
        }
    }
    forces
}

/// The stress before anything acts: xx yy zz xy.
fn initial_at(body: &Body, x: Vector) -> [f64; 4] {
    let initial = body.more.initial.as_ref();
    initial.map_or([0.0; 4], |stress| {
        std::array::from_fn(|k| stress[k].at(x, 0.0))
    })
}

/// Nodal forces of the initial stress as a load: −∫ σ₀·∇N dV.
fn resist_initial(mesh: &Mesh, body: &Body, analysis: Analysis, forces: &mut [Vector]) {
    for (cell, (kind, nodes)) in mesh.cells.iter().enumerate() {
        for (xi, weight) in kind.rule(analysis.axisymmetric()) {
            let at = station(mesh, cell, xi, weight);
            let volume = at.area * depth(body, analysis, at.x);
            let [xx, yy, zz, xy] = initial_at(body, at.x);
            for ((&node, g), n) in nodes.iter().zip(&at.gradients).zip(&at.shape) {
                let mut force = [xx * g[0] + xy * g[1], xy * g[0] + yy * g[1]];
                if analysis.axisymmetric() {
                    force[0] += zz * n / at.x[0];
                }
                forces[node] = plus(forces[node], -volume, force);
            }
        }
    }
}

/// Nodal forces of the beds under a body. A bed that only presses is springs side by side at the Gauss points of its facets, two of a
/// line and three with a middle node, each of which parts by itself.
pub fn bedded(mesh: &Mesh, body: &Body, analysis: Analysis, moves: &[Vector]) -> Vec<Vector> {
    let mut forces = vec![[0.0; 2]; mesh.points.len()];
    for spring in &body.more.springs {
        for facet in &mesh.sides[&spring.side] {
            for (xi, weight) in gauss(facet.len()) {
                let (n, slopes) = along(facet.len(), xi);
                let sum = |values: &[f64; 3], of: &[Vector]| {
                    let nodes = facet.iter().zip(values);
                    nodes.fold([0.0; 2], |s, (&node, v)| plus(s, *v, of[node]))
                };
                let tangent = sum(&slopes, &mesh.points);
                let normal = unit([tangent[1], -tangent[0]]);
                let area = weight * length(tangent);
                let area = area * depth(body, analysis, sum(&n, &mesh.points));
                let u = sum(&n, moves);
                let out = dot(u, normal);
                let across = plus(u, -out, normal);
                let pressed = match spring.compression_only {
                    true => out.max(0.0),
                    false => out,
                };
                let force = plus(
                    times(-spring.normal * area * pressed, normal),
                    -spring.tangential * area,
                    across,
                );
                for (&node, n) in facet.iter().zip(n) {
                    forces[node] = plus(forces[node], n, force);
                }
            }
        }
    }
    forces
}

fn add_on_side(
    mesh: &Mesh,
    body: &Body,
    analysis: Analysis,
    side: &str,
    forces: &mut [Vector],
    traction: impl Fn(Vector, Vector) -> Vector,
) {
    for facet in &mesh.sides[side] {
        for (xi, weight) in gauss(5) {
            let (n, slopes) = along(facet.len(), xi);
            let sum = |values: &[f64; 3]| {
                let nodes = facet.iter().zip(values);
                nodes.fold([0.0; 2], |s, (&node, v)| plus(s, *v, mesh.points[node]))
            };
            let (x, tangent) = (sum(&n), sum(&slopes));
            let normal = unit([tangent[1], -tangent[0]]);
            let area = weight * length(tangent) * depth(body, analysis, x);
            let force = times(area, traction(x, normal));
            for (&node, n) in facet.iter().zip(n) {
                forces[node] = plus(forces[node], n, force);
            }
        }
    }
}

/// The node nearest to a point.
pub fn nearest(mesh: &Mesh, point: Vector) -> usize {
    let distance = |node: &usize| length(minus(mesh.points[*node], point));
    let nodes = 0..mesh.points.len();
    nodes
        .min_by(|a, b| distance(a).total_cmp(&distance(b)))
        .unwrap_or(0)
}

/// All conditions, at a time, of the supports that a body has from the beginning, and of the axis of revolution.
pub fn conditions(mesh: &Mesh, body: &Body, analysis: Analysis, t: f64) -> Vec<Condition> {
    let mut all = Vec::new();
    if analysis.axisymmetric() {
        let (low, high) = bounds(&mesh.points);
        let limit = 1e-9 * length(minus(high, low));
        for (node, x) in mesh.points.iter().enumerate() {
            if x[0].abs() <= limit {
                all.push(Condition {
                    node,
                    axis: [1.0, 0.0],
                    value: 0.0,
                });
            }
        }
    }
    for support in body.supports.iter().filter(|s| s.from.is_none()) {
        all.extend(of_support(mesh, support, t));
    }
    all
}

/// The conditions of one support.
pub fn of_support(mesh: &Mesh, support: &Support, t: f64) -> Vec<Condition> {
    let mut all = Vec::new();
    for (node, normal) in held_nodes(mesh, support) {
        let x = mesh.points[node];
        let named = [[1.0, 0.0], [0.0, 1.0]].into_iter().zip(&support.axes);
        for (axis, value) in named.chain([(normal, &support.normal)]) {
            all.extend(value.as_ref().map(|value| Condition {
                node,
                axis,
                value: value.at(x, t),
            }));
        }
    }
    all
}

/// Nodes of a support with the mean of the unit normals of its facets there.
fn held_nodes(mesh: &Mesh, support: &Support) -> Vec<(usize, Vector)> {
    match &support.place {
        Place::Point(point) => vec![(nearest(mesh, *point), [0.0; 2])],
        Place::Side(side) => {
            let mut sums: BTreeMap<usize, Vector> = BTreeMap::new();
            for facet in &mesh.sides[side] {
                for (&node, xi) in facet.iter().zip([-1.0, 1.0, 0.0]) {
                    let (_, slopes) = along(facet.len(), xi);
                    let tangent = facet
                        .iter()
                        .zip(slopes)
                        .fold([0.0; 2], |s, (&n, slope)| plus(s, slope, mesh.points[n]));
                    let normal = unit([tangent[1], -tangent[0]]);
                    let sum = sums.entry(node).or_insert([0.0; 2]);
                    *sum = plus(*sum, 1.0, normal);
                }
            }
            sums.into_iter().map(|(n, sum)| (n, unit(sum))).collect()
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::amount::Amount;
    use crate::cells::Kind;
    use crate::plane::{cross, turned};
    use crate::problem::Shape;
    use crate::raw::Cell;

    fn body(kind: Kind) -> Body {
        Body {
            name: "b".to_string(),
            shape: Shape::Rectangle {
                from: [0.0; 2],
                to: [1.0; 2],
                cells: [1, 1],
                diagonals: "forward",
            },
            kind,
            patches: Vec::new(),
            young: 7.0,
            poisson: 0.3,
            thickness: 1.5,
            supports: Vec::new(),
            loads: Vec::new(),
            weight: Default::default(),
            circles: Vec::new(),
            more: Default::default(),
        }
    }

    /// A distorted patch: four quadrilaterals or eight triangles about an inner node off the middle, straight edges.
    fn patch(kind: Kind) -> Mesh {
        let shift = |i: usize, j: usize| match (i, j) {
            (1, 1) => [1.13, 0.92],
            _ => [1.0 + i as f64 - 1.0, j as f64],
        };
        let mut mesh = Mesh {
            points: Vec::new(),
            cells: Vec::new(),
            sides: BTreeMap::new(),
        };
        let add = |mesh: &mut Mesh, x: Vector| {
            let found = mesh
                .points
                .iter()
                .position(|p| length(minus(*p, x)) < 1e-12);
            found.unwrap_or_else(|| {
                mesh.points.push(x);
                mesh.points.len() - 1
            })
        };
        for i in 0..2 {
            for j in 0..2 {
                let [a, b, c, d] = [(i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)]
                    .map(|(i, j)| plus(shift(i, j), 0.5, [1.0, 0.0]));
                let corners = match kind.triangle() {
                    true => vec![vec![a, b, c], vec![a, c, d]],
                    false => vec![vec![a, b, c, d]],
                };
                for corner in corners {
                    let n = corner.len();
                    let mut places = corner.clone();
                    for k in 0..n {
                        places.push(times(0.5, plus(corner[k], 1.0, corner[(k + 1) % n])));
                    }
                    let sum = corner.iter().fold([0.0; 2], |s, &p| plus(s, 1.0, p));
                    places.push(times(1.0 / n as f64, sum));
                    places.truncate(kind.nodes());
                    let nodes = places.into_iter().map(|x| add(&mut mesh, x)).collect();
                    mesh.cells.push((kind, nodes));
                }
            }
        }
        mesh
    }

    const ANALYSES: [Analysis; 3] = [
        Analysis::PlaneStrain,
        Analysis::PlaneStress,
        Analysis::Axisymmetric,
    ];

    #[test]
    fn rigid_motions_cause_no_force_and_forces_balance() {
        for &kind in Kind::ALL {
            let (mesh, body) = (patch(kind), body(kind));
            for analysis in ANALYSES {
                let turn = if analysis.axisymmetric() { 0.0 } else { 0.1 };
                let across = if analysis.axisymmetric() { 0.0 } else { 0.4 };
                let rigid: Vec<Vector> = mesh
                    .points
                    .iter()
                    .map(|&x| plus([across, -0.7], turn, turned(x)))
                    .collect();
                let found = internal(&mesh, &body, analysis, &rigid, 0.0);
                assert!(found.forces.iter().all(|&f| length(f) < 1e-13), "{kind:?}");
                let any: Vec<Vector> = mesh
                    .points
                    .iter()
                    .map(|x| [(3.0 * x[0] * x[1]).sin(), x[0] * x[0] - 0.4 * x[1]])
                    .collect();
                let found = internal(&mesh, &body, analysis, &any, 0.0);
                let sum = found.forces.iter().fold([0.0; 2], |s, &f| plus(s, 1.0, f));
                let largest = found.forces.iter().fold(0.0, |s: f64, &f| s.max(length(f)));
                assert!(sum[1].abs() < 1e-13 * largest);
                if !analysis.axisymmetric() {
                    let moment: f64 = mesh
                        .points
                        .iter()
                        .zip(&found.forces)
                        .map(|(&x, &f)| cross(x, f))
                        .sum();
                    assert!(sum[0].abs() < 1e-13 * largest && moment.abs() < 1e-12 * largest);
                }
            }
        }
    }

    /// Under a constant stress inner nodes have no force, and the force on a boundary is stress times area.
    #[test]
    fn a_constant_stress_is_a_patch() {
        for &kind in Kind::ALL {
            let (mesh, body) = (patch(kind), body(kind));
            for analysis in [Analysis::PlaneStrain, Analysis::PlaneStress] {
                let (a, b, c) = (0.01, -0.02, 0.005);
                let linear: Vec<Vector> = mesh
                    .points
                    .iter()
                    .map(|x| [a * x[0] + c * x[1], c * x[0] + b * x[1]])
                    .collect();
                let found = internal(&mesh, &body, analysis, &linear, 0.0);
                let (e, v) = (body.young, body.poisson);
                let across = match analysis {
                    Analysis::PlaneStress => e / (1.0 - v * v) * (b + v * a),
                    _ => e / (1.0 + v) * (b + v / (1.0 - 2.0 * v) * (a + b)),
                };
                let shear = e / (1.0 + v) * c;
                let mut top = [0.0; 2];
                for (x, f) in mesh.points.iter().zip(&found.forces) {
                    let inner = x[0] > 0.6 && x[0] < 2.4 && x[1] > 0.1 && x[1] < 1.9;
                    assert!(!inner || length(*f) < 1e-14, "{kind:?}");
                    if x[1] > 1.99 && x[0] > 0.6 && x[0] < 2.4 {
                        top = plus(top, 1.0, *f);
                    }
                }
                // the end nodes of the top belong to the flanks, too: only its inner nodes are compared
                let share = match kind.linear() {
                    true => 1.0,
                    false => 2.0 - 1.0 / 3.0,
                };
                let area = share * body.thickness;
                assert!(
                    (top[1] - across * area).abs() < 1e-13,
                    "{kind:?} {analysis:?}"
                );
                assert!((top[0] - shear * area).abs() < 1e-13);
            }
        }
    }

    /// u = (a r, c z): uniform stress; the forces on the flat ends are σzz·π(R₂² − R₁²).
    #[test]
    fn a_constant_stress_about_an_axis_is_a_patch() {
        for &kind in Kind::ALL {
            let (mesh, body) = (patch(kind), body(kind));
            let (a, c) = (0.01, -0.03);
            let linear: Vec<Vector> = mesh.points.iter().map(|x| [a * x[0], c * x[1]]).collect();
            let found = internal(&mesh, &body, Analysis::Axisymmetric, &linear, 0.0);
            let (e, v) = (body.young, body.poisson);
            let factor = e / ((1.0 + v) * (1.0 - 2.0 * v));
            let along = factor * ((1.0 - v) * c + 2.0 * v * a);
            let top: f64 = mesh
                .points
                .iter()
                .zip(&found.forces)
                .filter(|(x, _)| x[1] > 1.99)
                .map(|(_, f)| f[1])
                .sum();
            let area = std::f64::consts::PI * (2.5 * 2.5 - 0.5 * 0.5);
            assert!((top - along * area).abs() < 1e-11 * area, "{kind:?}");
            for (x, f) in mesh.points.iter().zip(&found.forces) {
                let inner = x[0] > 0.6 && x[0] < 2.4 && x[1] > 0.1 && x[1] < 1.9;
                assert!(!inner || length(*f) < 1e-11, "{kind:?} {x:?} {f:?}");
            }
        }
    }

    #[test]
    fn loads_have_their_resultants() {
        for &kind in Kind::ALL {
            let mut mesh = patch(kind);
            let top: Vec<Vec<usize>> = mesh
                .cells
                .iter()
                .flat_map(|(kind, nodes)| {
                    let corners = if kind.triangle() { 3 } else { 4 };
                    (0..corners)
                        .map(|k| kind.facet(k).iter().map(|&i| nodes[i]).collect::<Vec<_>>())
                })
                .filter(|facet: &Vec<usize>| facet.iter().all(|&n| mesh.points[n][1] > 1.99))
                .collect();
            mesh.sides.insert("top".to_string(), top);
            let mut body = body(kind);
            body.loads = vec![
                Load::Pressure {
                    side: "top".to_string(),
                    field: Amount::new(1.0, [2.0, 0.0], crate::amount::Time::Always),
                },
                Load::Force {
                    point: [0.5, 0.0],
                    field: [Amount::from(3.0), Amount::from(4.0)],
                },
            ];
            body.weight = [Amount::from(0.0), Amount::from(-2.0)];
            let forces = external(&mesh, &body, Analysis::PlaneStrain, 1.0);
            let sum = forces.iter().fold([0.0; 2], |s, &f| plus(s, 1.0, f));
            let expected = 4.0 - 1.5 * (2.0 + 2.0 * 3.0) - 1.5 * 4.0 * 2.0;
            assert!((sum[0] - 3.0).abs() < 1e-13 && (sum[1] - expected).abs() < 1e-12);
            let round = external(&mesh, &body, Analysis::Axisymmetric, 1.0);
            let sum = round.iter().fold([0.0; 2], |s, &f| plus(s, 1.0, f));
            let pi = std::f64::consts::PI;
            let pressed = pi * 6.0 + 2.0 * pi * 2.0 * (2.5f64.powi(3) - 0.125) / 3.0;
            assert!((sum[1] - (4.0 - pressed - 2.0 * 2.0 * pi * 6.0)).abs() < 1e-10);
        }
    }
}
