//! Elasticity of space, written independently of the program: nodal forces of stresses and of loads, and the conditions of supports.
//!
//! ```text
//!   internal force of node a   fₐ = ∫ σ(u) ∇Nₐ dV,     σ = 2G ε + λ tr(ε) I
//!   external force             fₐ = ∫ N t dS + ∫ N b dV
//! ```

use super::Mesh;
use super::geometry::{AXES, Matrix, Vector, bounds, cross, dot, length, mean, minus, plus, times};
use super::problem::{Body, Held, Load};
use super::side::Skin;
use super::solids::Solid;
use crate::amount::vector_at;
use crate::held::{Condition, held_axes};

/// Nodal forces of the stresses of a body.
pub struct Internal {
    pub forces: Vec<Vector>,
    /// Σ|K||u| at each node: rounding of the displacements changes the forces by this times 2⁻⁵³. Displacements below `least` count
    /// as `least`.
    pub magnitudes: Vec<f64>,
}

/// Shape functions and reference gradients of a kind of cell at the points of a rule, with their weights.
struct Table {
    kind: Solid,
    points: Vec<(f64, Vec<(f64, Vector)>)>,
}

impl Table {
    fn new(kind: Solid, rule: Vec<(Vector, f64)>) -> Self {
        let points = rule.into_iter().map(|(xi, w)| (w, kind.shape(xi)));
        Self {
            kind,
            points: points.collect(),
        }
    }

    /// Calls back with volume, shape functions and gradients in space at every point of a cell.
    fn each(&self, corners: &[Vector], mut at: impl FnMut(f64, &[(f64, Vector)])) {
        let mut real = Vec::new();
        for (weight, shape) in &self.points {
            // columns: derivatives of the place
            let mut tangents: Matrix = [[0.0; 3]; 3];
            for (&x, (_, slope)) in corners.iter().zip(shape) {
                for (tangent, s) in tangents.iter_mut().zip(slope) {
                    *tangent = plus(*tangent, *s, x);
                }
            }
            let [a, b, c] = tangents;
            let volume = dot(a, cross(b, c));
            let dual = [cross(b, c), cross(c, a), cross(a, b)];
            real.clear();
            real.extend(shape.iter().map(|(n, slope)| {
                let sum = (0..3).fold([0.0; 3], |s, d| plus(s, slope[d] / volume, dual[d]));
                (*n, sum)
            }));
            at(weight * volume, &real);
        }
    }
}

fn tables(mesh: &Mesh, rule: impl Fn(Solid) -> Vec<(Vector, f64)>) -> Vec<Table> {
    let mut all: Vec<Table> = Vec::new();
    for (kind, _) in &mesh.cells {
        if all.iter().all(|table| table.kind != *kind) {
            all.push(Table::new(*kind, rule(*kind)));
        }
    }
    all
}

/// Calls back for every cell with its table, its nodes and their places.
fn cells(mesh: &Mesh, tables: &[Table], mut each: impl FnMut(&Table, &[usize], &[Vector])) {
    for (kind, nodes) in &mesh.cells {
        let places: Vec<Vector> = nodes.iter().map(|&n| mesh.points[n]).collect();
        if let Some(table) = tables.iter().find(|table| table.kind == *kind) {
            each(table, nodes, &places);
        }
    }
}

/// Nodal forces of the stresses that displacements cause.
pub fn internal(mesh: &Mesh, body: &Body, moves: &[Vector], least: f64) -> Internal {
    let (e, v) = (body.young, body.poisson);
    let shear = e / (2.0 * (1.0 + v));
    let bulk = e * v / ((1.0 + v) * (1.0 - 2.0 * v));
    let stiff = bulk + 2.0 * shear;
    let mut out = Internal {
        forces: vec![[0.0; 3]; moves.len()],
        magnitudes: vec![0.0; moves.len()],
    };
    cells(mesh, &tables(mesh, Solid::rule), |table, nodes, places| {
        // the translation of the cell is removed: it causes no strain, only rounding
        let first = moves[nodes[0]];
        let own: Vec<Vector> = nodes.iter().map(|&n| minus(moves[n], first)).collect();
        let largest = nodes
            .iter()
            .fold(least, |s: f64, &n| s.max(length(moves[n])));
        table.each(places, |volume, shape| {
            let mut gradient: Matrix = [[0.0; 3]; 3];
            let mut slopes = 0.0;
            for (u, (_, g)) in own.iter().zip(shape) {
                for (row, u) in gradient.iter_mut().zip(u) {
                    *row = plus(*row, *u, *g);
                }
                slopes += length(*g);
            }
            let trace = gradient[0][0] + gradient[1][1] + gradient[2][2];
            let stress: Matrix = std::array::from_fn(|i| {
                let strained = |j: usize| shear * (gradient[i][j] + gradient[j][i]);
                plus(std::array::from_fn(strained), bulk * trace, AXES[i])
            });
            for (&node, (_, g)) in nodes.iter().zip(shape) {
                let force = stress.map(|row| dot(row, *g));
                out.forces[node] = plus(out.forces[node], volume, force);
                out.magnitudes[node] += volume * stiff * length(*g) * slopes * largest;
            }
        });
    });
    out
}

/// Nodal forces of the loads of a body at a time.
pub fn external(mesh: &Mesh, body: &Body, t: f64) -> Vec<Vector> {
    let mut forces = vec![[0.0; 3]; mesh.points.len()];
    for load in &body.loads {
        let side = match load {
            Load::Traction { side, .. } | Load::Pressure { side, .. } => side,
        };
        for facet in &Skin::new(mesh, side, None).facets {
            for (xi, weight) in facet.rule() {
                let at = facet.at(xi);
                let area = weight * length(at.normal);
                let traction = match load {
                    Load::Traction { field, .. } => times(area, vector_at(field, at.x, t)),
                    Load::Pressure { field, .. } => times(-weight * field.at(at.x, t), at.normal),
                };
                for (&node, n) in facet.nodes.iter().zip(&at.shape) {
                    forces[node] = plus(forces[node], *n, traction);
                }
            }
        }
    }
    if body.weight.iter().any(|w| !w.is_zero()) {
        let weight = vector_at(&body.weight, [0.0; 3], t);
        cells(
            mesh,
            &tables(mesh, Solid::fine_rule),
            |table, nodes, places| {
                table.each(places, |volume, shape| {
                    for (&node, (n, _)) in nodes.iter().zip(shape) {
                        forces[node] = plus(forces[node], volume * n, weight);
                    }
                });
            },
        );
    }
    forces
}

/// The node nearest to a point.
#[cfg(test)]
pub fn nearest(mesh: &Mesh, point: Vector) -> usize {
    let distance = |node: &usize| length(minus(mesh.points[*node], point));
    let nodes = 0..mesh.points.len();
    nodes
        .min_by(|a, b| distance(a).total_cmp(&distance(b)))
        .unwrap_or(0)
}

/// All conditions of the supports of a body at a time.
pub fn conditions(mesh: &Mesh, body: &Body, t: f64) -> Vec<Condition<3>> {
    let mut all = Vec::new();
    for (side, held) in &body.supports {
        let skin = Skin::new(mesh, side, None);
        for &node in skin.around.keys() {
            let x = mesh.points[node];
            let mut hold = |axis: Vector, value: f64| all.push(Condition { node, axis, value });
            match held {
                Held::All(field) => {
                    let values = vector_at(field, x, t).into_iter();
                    AXES.into_iter().zip(values).for_each(|(a, v)| hold(a, v));
                }
                Held::Normal(value) => hold(skin.normal_at(node), value.at(x, t)),
            }
        }
    }
    all
}

/// Supports alone leave a body no rigid motion.
pub fn fully_held(mesh: &Mesh, body: &Body, t: f64) -> bool {
    let (low, high) = bounds(&mesh.points);
    let (middle, size) = (mean(&mesh.points), length(minus(high, low)));
    // rows (axis, moment of the axis): six independent ones
    let mut basis: Vec<[f64; 6]> = Vec::new();
    for (&node, held) in &held_axes(&conditions(mesh, body, t)) {
        let arm = times(1.0 / size, minus(mesh.points[node], middle));
        for &axis in held {
            let [a, b] = [axis, cross(arm, axis)];
            let mut row = [a[0], a[1], a[2], b[0], b[1], b[2]];
            for q in &basis {
                row = plus(row, -dot(row, *q), *q);
            }
            if length(row) > 1e-6 {
                basis.push(times(1.0 / length(row), row));
            }
        }
    }
    basis.len() == 6
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::raw::Cell;
    use crate::space::mutations::{body, cuboid, mesh_of};
    use crate::space::problem::{Number, constant};

    /// Two by two by two cells in a box whose middle node is moved, of every kind.
    fn patch(kind: Solid) -> (Mesh, Body) {
        let mut body = body("b", cuboid([0.0; 3], [2.0, 1.0, 1.5], [2, 2, 2]), kind);
        (body.young, body.poisson) = (7.0, 0.3);
        let mut mesh = mesh_of(&body);
        let mut random = crate::random::Random::new(4);
        crate::space::problem::jitter(&body, &mut mesh, 0.1, &mut random);
        (mesh, body)
    }

    #[test]
    fn rigid_motions_cause_no_force_and_forces_balance() {
        for &kind in Solid::ALL {
            let (mesh, body) = patch(kind);
            let moved = |f: &dyn Fn(Vector) -> Vector| -> Vec<Vector> {
                mesh.points.iter().map(|&x| f(x)).collect()
            };
            let rigid = moved(&|x| plus([0.4, -0.7, 0.2], 0.1, cross([1.0, 2.0, -1.0], x)));
            let found = internal(&mesh, &body, &rigid, 0.0).forces;
            assert!(found.iter().all(|&f| length(f) < 1e-13), "{kind:?}");
            let any = moved(&|[x, y, z]| [(3.0 * x * y).sin(), x * x - 0.4 * z, y * z]);
            let found = internal(&mesh, &body, &any, 0.0).forces;
            let mut sums = [[0.0; 3]; 2];
            for (&x, &f) in mesh.points.iter().zip(&found) {
                sums = [plus(sums[0], 1.0, f), plus(sums[1], 1.0, cross(x, f))];
            }
            assert!(sums.iter().all(|&s| length(s) < 1e-12), "{kind:?} {sums:?}");
        }
    }

    #[test]
    fn a_constant_stress_is_a_patch() {
        let strain = [
            [0.01, 0.003, -0.002],
            [0.003, -0.02, 0.004],
            [-0.002, 0.004, 0.005],
        ];
        for &kind in Solid::ALL {
            let (mesh, body) = patch(kind);
            let moves: Vec<Vector> = mesh
                .points
                .iter()
                .map(|&x| strain.map(|r| dot(r, x)))
                .collect();
            let found = internal(&mesh, &body, &moves, 0.0).forces;
            let c = 7.0 / 1.3;
            let trace = 0.01 - 0.02 + 0.005;
            let stress = |i: usize, j: usize| {
                c * (strain[i][j] + if i == j { 0.3 / 0.4 * trace } else { 0.0 })
            };
            let mut right = [0.0; 3];
            for (&x, &f) in mesh.points.iter().zip(&found) {
                let inner = (0..3).all(|d| x[d] > 1e-9 && x[d] < [2.0, 1.0, 1.5][d] - 1e-9);
                assert!(!inner || length(f) < 1e-14, "{kind:?}");
                // half of the forces σ·n on the whole side belongs to its own half of the boundary: moments of the forces
                right = plus(right, x[0], f);
            }
            // Σ x f = ∫ σ·e_x dV for a constant stress
            for (i, sum) in right.into_iter().enumerate() {
                assert!((sum - 3.0 * stress(i, 0)).abs() < 1e-13, "{kind:?} {i}");
            }
        }
    }

    #[test]
    fn loads_have_their_resultants() {
        for &kind in Solid::ALL {
            let (mesh, mut body) = patch(kind);
            body.weight = constant([0.0, 0.5, -2.0]);
            let field = Number::new(1.0, [2.0, 0.0, 0.0], crate::amount::Time::Always);
            let side = "top".to_string();
            body.loads = vec![Load::Pressure { side, field }];
            let forces = external(&mesh, &body, 1.0);
            let sum = forces.iter().fold([0.0; 3], |s, &f| plus(s, 1.0, f));
            // weight on a volume of 3, and 1 + 2x over the top
            let expected = [0.0, 1.5, -6.0 - (2.0 + 4.0)];
            assert!(length(minus(sum, expected)) < 1e-13, "{kind:?} {sum:?}");
            assert!(!fully_held(&mesh, &body, 1.0));
            let held = |name: &str| (name.to_string(), Held::Normal(Number::default()));
            body.supports = vec![held("left"), held("front")];
            assert!(!fully_held(&mesh, &body, 1.0));
            body.supports.push(held("bottom"));
            assert!(fully_held(&mesh, &body, 1.0));
        }
    }
}
