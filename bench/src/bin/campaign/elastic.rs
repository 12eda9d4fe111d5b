//! Elasticity, written independently of the program: nodal forces of stresses and of loads, and the conditions of supports.
//!
//! ```text
//!   internal force of node a   fₐ = ∫ σ(u) ∇Nₐ dV,     σ = 2G ε + λ tr(ε) I      with symmetry about an axis  fₐ,r += ∫ σ_θθ Nₐ/r dV
//!   external force             fₐ = ∫ N t dS + ∫ N b dV + forces at nodes
//! ```
//!
//! Stresses and strains are those of space. In the plane dV is dA times the thickness, or dA times 2πr; the third direction is
//! across the plane, or around the axis. In plane stress λ is 2Gλ/(λ + 2G), with which σzz vanishes.
//! The difference of internal and external force is the force of supports and contacts on a node.

use crate::amount::vector_at;
use crate::cells::{Functions, Kind, Place, Point};
use crate::held::{Condition, held_axes};
use crate::problem::{Analysis, Body, Load, Support};
use crate::raw::Mesh;
use crate::side::Skin;
use crate::vector::{
    applied, axes, bounds, cross, dot, length, lowered, mean, minus, plus, raised, sum, times, unit,
};
use std::f64::consts::TAU;

/// A stress or a strain.
pub type Tensor = [[f64; 3]; 3];

/// Nodal forces of the stresses of a body.
pub struct Internal<const D: usize> {
    pub forces: Vec<[f64; D]>,
    /// Σ|K||u| at each node: rounding of the displacements changes the forces by this times 2⁻⁵³. Displacements below `least` count
    /// as `least`.
    pub magnitudes: Vec<f64>,
}

/// G and λ of Hooke's law.
fn hooke([e, v]: [f64; 2], analysis: Analysis) -> [f64; 2] {
    let shear = e / (2.0 * (1.0 + v));
    match analysis {
        Analysis::PlaneStress => [shear, e * v / (1.0 - v * v)],
        _ => [shear, e * v / ((1.0 + v) * (1.0 - 2.0 * v))],
    }
}

/// What counts per area of the plane: thickness, or the circumference around the axis; one in space.
pub fn depth<const D: usize>(body: &Body<D>, analysis: Analysis, x: [f64; D]) -> f64 {
    if analysis.axisymmetric() {
        TAU * x[0]
    } else {
        body.thickness
    }
}

/// Gauss points of a kind of cell, with the shape functions there.
pub struct Table {
    kind: Kind,
    points: Vec<(Place, f64, Functions)>,
}

/// The tables of all kinds of cells of a mesh.
pub fn tables<const D: usize>(mesh: &Mesh<D>, rule: impl Fn(Kind) -> Vec<Point>) -> Vec<Table> {
    let mut all: Vec<Table> = Vec::new();
    for (kind, _) in &mesh.cells {
        if all.iter().all(|table| table.kind != *kind) {
            let points = rule(*kind).into_iter();
            all.push(Table {
                kind: *kind,
                points: points.map(|(xi, w)| (xi, w, kind.shape(xi))).collect(),
            });
        }
    }
    all
}

/// A Gauss point of a cell.
pub struct Station<const D: usize> {
    pub xi: Place,
    pub x: [f64; D],
    pub volume: f64,
    /// Shape functions with their gradients.
    pub shape: Vec<(f64, [f64; D])>,
    /// Distance from the axis of a body of revolution.
    radius: Option<f64>,
}

impl<const D: usize> Station<D> {
    /// The strain of displacements.
    pub fn strain(&self, moves: impl Fn(usize) -> [f64; D], first: [f64; D]) -> Tensor {
        let mut gradient: Tensor = [[0.0; 3]; 3];
        let mut around = 0.0;
        for (node, (n, g)) in self.shape.iter().enumerate() {
            let u = moves(node);
            // the translation of the cell causes no strain, only rounding
            for (row, u) in gradient.iter_mut().zip(minus(u, first)) {
                *row = plus(*row, u, raised(*g));
            }
            around += n * u[0];
        }
        let half = |i: usize, j: usize| 0.5 * (gradient[i][j] + gradient[j][i]);
        let mut strain: Tensor = std::array::from_fn(|i| std::array::from_fn(|j| half(i, j)));
        if let Some(radius) = self.radius {
            strain[2][2] = around / radius;
        }
        strain
    }

    /// The forces of a stress at the nodes of the cell.
    pub fn forces(&self, stress: &Tensor) -> impl Iterator<Item = [f64; D]> {
        self.shape.iter().map(|(n, g)| {
            let mut force = applied(*stress, raised(*g));
            if let Some(radius) = self.radius {
                force[0] += stress[2][2] * n / radius;
            }
            lowered(times(self.volume, force))
        })
    }

    /// Adds the forces of a stress at the nodes of the cell, and the magnitudes of rounding, `stiff` the largest modulus and
    /// `largest` the largest displacement.
    pub fn add(
        &self,
        out: &mut Internal<D>,
        nodes: &[usize],
        stress: &Tensor,
        [stiff, largest]: [f64; 2],
    ) {
        let slopes: f64 = self.shape.iter().map(|(_, g)| length(*g)).sum();
        for ((&node, force), (_, g)) in nodes.iter().zip(self.forces(stress)).zip(&self.shape) {
            out.forces[node] = plus(out.forces[node], 1.0, force);
            out.magnitudes[node] += self.volume * stiff * length(*g) * slopes * largest;
        }
    }
}

/// The Gauss points of a cell.
pub fn stations<const D: usize>(
    (mesh, body, analysis): (&Mesh<D>, &Body<D>, Analysis),
    tables: &[Table],
    cell: usize,
) -> Vec<Station<D>> {
    let (kind, nodes) = &mesh.cells[cell];
    let table = tables.iter().find(|table| table.kind == *kind);
    let points = table.into_iter().flat_map(|table| &table.points);
    let each = points.map(|(xi, weight, shape)| {
        let mut x = [0.0; D];
        // derivatives of the place; a cell of the plane is a slab of depth one
        let mut tangents: Tensor = axes();
        tangents[..D].fill([0.0; 3]);
        for (&node, (n, slope)) in nodes.iter().zip(shape) {
            let place = mesh.points[node];
            x = plus(x, *n, place);
            for (tangent, s) in tangents[..D].iter_mut().zip(slope) {
                *tangent = plus(*tangent, *s, raised(place));
            }
        }
        let [a, b, c] = tangents;
        let volume = dot(a, cross(b, c));
        let dual = [cross(b, c), cross(c, a), cross(a, b)];
        let gradient = |slope: &Place| {
            let each = dual.iter().zip(slope);
            lowered(each.fold([0.0; 3], |sum, (d, s)| plus(sum, s / volume, *d)))
        };
        Station {
            xi: *xi,
            x,
            volume: weight * volume * depth(body, analysis, x),
            shape: shape.iter().map(|(n, s)| (*n, gradient(s))).collect(),
            radius: analysis.axisymmetric().then_some(x[0]),
        }
    });
    each.collect()
}

/// Nodal forces of the stresses that displacements cause.
pub fn internal<const D: usize>(
    mesh: &Mesh<D>,
    body: &Body<D>,
    analysis: Analysis,
    moves: &[[f64; D]],
    least: f64,
) -> Internal<D> {
    let own = hooke([body.young, body.poisson], analysis);
    let beyond = body.more.beyond.as_ref();
    let other = beyond.map(|b| (b.border, hooke([b.young, b.poisson], analysis)));
    let mut out = Internal {
        forces: vec![[0.0; D]; moves.len()],
        magnitudes: vec![0.0; moves.len()],
    };
    let tables = tables(mesh, |kind| kind.rule(analysis.axisymmetric()));
    for (cell, (_, nodes)) in mesh.cells.iter().enumerate() {
        let middle = nodes.iter().map(|&n| mesh.points[n][0]).sum::<f64>() / nodes.len() as f64;
        let [shear, bulk] = match other {
            Some((border, law)) if middle > border => law,
            _ => own,
        };
        let largest = largest(nodes, moves, least);
        for at in stations((mesh, body, analysis), &tables, cell) {
            let strain = at.strain(|k| moves[nodes[k]], moves[nodes[0]]);
            let trace = strain[0][0] + strain[1][1] + strain[2][2];
            let mut stress = strain.map(|row| times(2.0 * shear, row));
            (0..3).for_each(|i| stress[i][i] += bulk * trace);
            at.add(&mut out, nodes, &stress, [bulk + 2.0 * shear, largest]);
        }
    }
    out
}

/// The largest displacement of some nodes, or `least`.
pub fn largest<const D: usize>(nodes: &[usize], moves: &[[f64; D]], least: f64) -> f64 {
    let sizes = nodes.iter().map(|&n| length(moves[n]));
    sizes.fold(least, f64::max)
}

/// Nodal forces of the loads of a body at a time.
pub fn external<const D: usize>(
    mesh: &Mesh<D>,
    body: &Body<D>,
    analysis: Analysis,
    t: f64,
) -> Vec<[f64; D]> {
    let mut forces = vec![[0.0; D]; mesh.points.len()];
    for load in &body.loads {
        if let Load::Force { point, field } = load {
            let node = mesh.nearest(*point);
            forces[node] = plus(forces[node], 1.0, vector_at(field, mesh.points[node], t));
        }
        let Some(side) = load.side() else { continue };
        for facet in &Skin::new(mesh, side, None).facets {
            for (xi, weight) in facet.rule() {
                let at = facet.at(xi);
                let area = weight * depth(body, analysis, at.x);
                let traction = match load {
                    Load::Traction { field, .. } => {
                        times(length(at.normal), vector_at(field, at.x, t))
                    }
                    Load::Pressure { field, .. } => times(-field.at(at.x, t), at.normal),
                    Load::InSitu { factor, .. } => {
                        let pull = applied(initial_at(body, at.x), raised(at.normal));
                        times(factor.at(at.x, t), lowered(pull))
                    }
                    Load::Force { .. } => continue,
                };
                for (node, n) in at.shape_of(&facet.nodes) {
                    forces[node] = plus(forces[node], n * area, traction);
                }
            }
        }
    }
    if body.more.initial.is_some() {
        let tables = tables(mesh, |kind| kind.rule(analysis.axisymmetric()));
        for (cell, (_, nodes)) in mesh.cells.iter().enumerate() {
            for at in stations((mesh, body, analysis), &tables, cell) {
                let stress = initial_at(body, at.x);
                for (&node, force) in nodes.iter().zip(at.forces(&stress)) {
                    forces[node] = minus(forces[node], force);
                }
            }
        }
    }
    if body.weight.iter().any(|w| !w.is_zero()) {
        let tables = tables(mesh, Kind::fine_rule);
        for (cell, (_, nodes)) in mesh.cells.iter().enumerate() {
            for at in stations((mesh, body, analysis), &tables, cell) {
                let force = times(at.volume, vector_at(&body.weight, at.x, t));
                for (&node, (n, _)) in nodes.iter().zip(&at.shape) {
                    forces[node] = plus(forces[node], *n, force);
                }
            }
        }
    }
    forces
}

/// The stress before anything acts.
fn initial_at<const D: usize>(body: &Body<D>, x: [f64; D]) -> Tensor {
    let initial = body.more.initial.as_ref();
    initial.map_or([[0.0; 3]; 3], |stress| {
        let [xx, yy, zz, xy] = stress.each_ref().map(|s| s.at(x, 0.0));
        [[xx, xy, 0.0], [xy, yy, 0.0], [0.0, 0.0, zz]]
    })
}

/// Nodal forces of the beds under a body. A bed that only presses is springs side by side at the Gauss points of its facets, each of
/// which parts by itself.
pub fn bedded<const D: usize>(
    mesh: &Mesh<D>,
    body: &Body<D>,
    analysis: Analysis,
    moves: &[[f64; D]],
) -> Vec<[f64; D]> {
    let mut forces = vec![[0.0; D]; mesh.points.len()];
    for spring in &body.more.springs {
        for facet in &Skin::new(mesh, &spring.side, None).facets {
            for (xi, weight) in facet.kind.rule(false) {
                let at = facet.at(xi);
                let shape = at.shape_of(&facet.nodes);
                let area = weight * length(at.normal) * depth(body, analysis, at.x);
                let normal = unit(at.normal);
                let u = sum(shape.iter().map(|&(node, n)| times(n, moves[node])));
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
                for (node, n) in shape {
                    forces[node] = plus(forces[node], n, force);
                }
            }
        }
    }
    forces
}

/// All conditions, at a time, of the supports that a body has from the beginning, and of the axis of revolution.
pub fn conditions<const D: usize>(
    mesh: &Mesh<D>,
    body: &Body<D>,
    analysis: Analysis,
    t: f64,
) -> Vec<Condition<D>> {
    let mut all = Vec::new();
    if analysis.axisymmetric() {
        let (low, high) = bounds(&mesh.points);
        let limit = 1e-9 * length(minus(high, low));
        let points = mesh.points.iter().enumerate();
        all.extend(
            points
                .filter(|(_, x)| x[0].abs() <= limit)
                .map(|(node, _)| {
                    let axis = axes()[0];
                    let value = 0.0;
                    Condition { node, axis, value }
                }),
        );
    }
    for support in body.supports.iter().filter(|s| s.from.is_none()) {
        all.extend(of_support(mesh, support, t));
    }
    all
}

/// The conditions of one support.
pub fn of_support<const D: usize>(
    mesh: &Mesh<D>,
    support: &Support<D>,
    t: f64,
) -> Vec<Condition<D>> {
    use crate::problem::Place::{Point, Side};
    let nodes: Vec<(usize, [f64; D])> = match &support.place {
        Point(point) => vec![(mesh.nearest(*point), [0.0; D])],
        Side(side) => {
            let skin = Skin::new(mesh, side, None);
            let nodes = skin.around.keys();
            nodes.map(|&node| (node, skin.normal_at(node))).collect()
        }
    };
    let mut all = Vec::new();
    for (node, normal) in nodes {
        let x = mesh.points[node];
        let named = axes().into_iter().zip(&support.axes);
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

/// Supports alone leave a body no rigid motion.
pub fn fully_held<const D: usize>(
    mesh: &Mesh<D>,
    body: &Body<D>,
    analysis: Analysis,
    t: f64,
) -> bool {
    let held = held_axes(&conditions(mesh, body, analysis, t));
    if analysis.axisymmetric() {
        return held.values().flatten().any(|a| a[1].abs() > 0.5);
    }
    let (low, high) = bounds(&mesh.points);
    let (middle, size) = (mean(&mesh.points), length(minus(high, low)));
    // rows (axis, moment of the axis): as many independent ones as there are rigid motions
    let mut basis: Vec<[f64; 6]> = Vec::new();
    for (&node, held) in &held {
        let arm = times(1.0 / size, minus(mesh.points[node], middle));
        for &axis in held {
            let ([a, b, c], [d, e, f]) = (raised(axis), cross(arm, axis));
            let mut row = [a, b, c, d, e, f];
            for q in &basis {
                row = plus(row, -dot(row, *q), *q);
            }
            if length(row) > 1e-6 {
                basis.push(unit(row));
            }
        }
    }
    basis.len() == D * (D + 1) / 2
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::amount::{Amount, Time};
    use crate::mutations::{block, mesh_of};
    use crate::problem::{Problem, constant, roller};
    use crate::random::Random;
    use crate::solve::Solvable;

    const SIZE: [f64; 3] = [2.0, 1.0, 1.5];

    /// Two cells along each axis, in a box whose middle node is moved; of bodies of revolution an inner radius of 0.5.
    fn patch<const D: usize>(kind: Kind, analysis: Analysis) -> (Mesh<D>, Body<D>)
    where
        Problem<D>: Solvable<D>,
    {
        let mut from = [0.0; D];
        if analysis.axisymmetric() {
            from[0] = 0.5;
        }
        let shape = block(from, plus(from, 1.0, lowered(SIZE)), [2; D]);
        let mut body = Body::new("b", shape, kind, [7.0, 0.3]);
        if D == 2 && !analysis.axisymmetric() {
            body.thickness = 1.5;
        }
        let mut mesh = mesh_of(&body);
        crate::jitter::jitter(&body, &mut mesh, 0.1, &mut Random::new(4));
        (mesh, body)
    }

    const ANALYSES: [Analysis; 3] = [
        Analysis::PlaneStrain,
        Analysis::PlaneStress,
        Analysis::Axisymmetric,
    ];

    fn moved<const D: usize>(mesh: &Mesh<D>, f: impl Fn([f64; D]) -> [f64; D]) -> Vec<[f64; D]> {
        mesh.points.iter().map(|&x| f(x)).collect()
    }

    fn rigid_motions_cause_no_force_and_forces_balance_in<const D: usize>(
        kind: Kind,
        analysis: Analysis,
    ) where
        Problem<D>: Solvable<D>,
    {
        let (mesh, body) = patch::<D>(kind, analysis);
        let round = analysis.axisymmetric();
        let spin = if D == 2 {
            [0.0, 0.0, 1.0]
        } else {
            [1.0, 2.0, -1.0]
        };
        let rigid = moved(&mesh, |x| match round {
            true => times(-0.7, axes()[1]),
            false => plus(
                lowered([0.4, -0.7, 0.2]),
                0.1,
                lowered(cross(spin, raised(x))),
            ),
        });
        let found = internal(&mesh, &body, analysis, &rigid, 0.0).forces;
        assert!(found.iter().all(|&f| length(f) < 1e-13), "{kind:?}");
        let any = moved(&mesh, |x| {
            let [x, y, z] = raised(x);
            lowered([(3.0 * x * y).sin(), x * x - 0.4 * (y + z), y * z])
        });
        let found = internal(&mesh, &body, analysis, &any, 0.0).forces;
        let total = sum(found.iter().copied());
        let moment = sum(mesh.points.iter().zip(&found).map(|(&x, &f)| cross(x, f)));
        let largest = found.iter().fold(0.0, |s: f64, &f| s.max(length(f)));
        match round {
            true => assert!(total[1].abs() < 1e-13 * largest),
            false => assert!(length(total).max(length(moment)) < 1e-12 * largest.max(1.0)),
        }
    }

    #[test]
    fn rigid_motions_cause_no_force_and_forces_balance() {
        for kind in Kind::PLANE {
            for analysis in ANALYSES {
                rigid_motions_cause_no_force_and_forces_balance_in::<2>(kind, analysis);
            }
        }
        for kind in Kind::SPACE {
            rigid_motions_cause_no_force_and_forces_balance_in::<3>(kind, Analysis::Space);
        }
    }

    const STRAIN: Tensor = [
        [0.01, 0.003, -0.002],
        [0.003, -0.02, 0.004],
        [-0.002, 0.004, 0.005],
    ];

    /// Under a constant stress inner nodes have no force, and Σ x f = ∫ σ·e_x dV.
    fn a_constant_stress_is_a_patch_in<const D: usize>(kind: Kind, analysis: Analysis)
    where
        Problem<D>: Solvable<D>,
    {
        let (mesh, body) = patch::<D>(kind, analysis);
        let moves = moved(&mesh, |x| lowered(STRAIN.map(|row| dot(row, raised(x)))));
        let found = internal(&mesh, &body, analysis, &moves, 0.0).forces;
        // as textbooks write the law of plane strain, plane stress and space by E and ν
        let (e, v) = (7.0, 0.3);
        let [a, b, c] = [0, 1, 2].map(|i| STRAIN[i][i]);
        let along = match analysis {
            Analysis::PlaneStress => e / (1.0 - v * v) * (a + v * b),
            Analysis::Space => e / ((1.0 + v) * (1.0 - 2.0 * v)) * ((1.0 - v) * a + v * (b + c)),
            _ => e / ((1.0 + v) * (1.0 - 2.0 * v)) * ((1.0 - v) * a + v * b),
        };
        let shear = |i: usize| e / (1.0 + v) * STRAIN[i][0];
        // an area of 2 by a thickness of 1.5, or a box
        let volume = 3.0;
        let mut right = [0.0; D];
        for (&x, &f) in mesh.points.iter().zip(&found) {
            let inner = (0..D).all(|d| x[d] > 1e-9 && x[d] < SIZE[d] - 1e-9);
            assert!(!inner || length(f) < 1e-14, "{kind:?}");
            right = plus(right, x[0], f);
        }
        for (i, sum) in right.into_iter().enumerate() {
            let stress = if i == 0 { along } else { shear(i) };
            assert!(
                (sum - volume * stress).abs() < 1e-13,
                "{kind:?} {analysis:?} {i}"
            );
        }
    }

    #[test]
    fn a_constant_stress_is_a_patch() {
        for kind in Kind::PLANE {
            a_constant_stress_is_a_patch_in::<2>(kind, Analysis::PlaneStrain);
            a_constant_stress_is_a_patch_in::<2>(kind, Analysis::PlaneStress);
        }
        for kind in Kind::SPACE {
            a_constant_stress_is_a_patch_in::<3>(kind, Analysis::Space);
        }
    }

    /// u = (a r, c z): uniform stress; the forces on the flat ends are σzz·π(R₂² − R₁²).
    #[test]
    fn a_constant_stress_about_an_axis_is_a_patch() {
        for kind in Kind::PLANE {
            let (mesh, body) = patch::<2>(kind, Analysis::Axisymmetric);
            let (a, c) = (0.01, -0.03);
            let moves = moved(&mesh, |[r, z]| [a * r, c * z]);
            let found = internal(&mesh, &body, Analysis::Axisymmetric, &moves, 0.0).forces;
            let (e, v) = (body.young, body.poisson);
            let factor = e / ((1.0 + v) * (1.0 - 2.0 * v));
            let along = factor * ((1.0 - v) * c + 2.0 * v * a);
            let nodes = mesh.points.iter().zip(&found);
            let top = nodes.clone().filter(|(x, _)| x[1] > 0.99);
            let top: f64 = top.map(|(_, f)| f[1]).sum();
            let area = std::f64::consts::PI * (2.5 * 2.5 - 0.5 * 0.5);
            assert!((top - along * area).abs() < 1e-11 * area, "{kind:?}");
            for ([r, z], f) in nodes {
                let inner = *r > 0.51 && *r < 2.49 && *z > 0.01 && *z < 0.99;
                assert!(!inner || length(*f) < 1e-11, "{kind:?} {r} {z} {f:?}");
            }
        }
    }

    fn loaded<const D: usize>(kind: Kind, analysis: Analysis) -> [f64; D]
    where
        Problem<D>: Solvable<D>,
    {
        let (mesh, mut body) = patch::<D>(kind, analysis);
        body.weight = constant(lowered([0.0, -2.0, 0.5]));
        body.press("top", Amount::new(1.0, times(2.0, axes()[0]), Time::Always));
        body.loads.push(Load::Force {
            point: [0.0; D],
            field: constant(lowered([3.0, 4.0, 0.0])),
        });
        assert!(!fully_held(&mesh, &body, analysis, 1.0));
        body.supports = vec![
            roller("left", Amount::default()),
            roller("bottom", Amount::default()),
        ];
        assert_eq!(fully_held(&mesh, &body, analysis, 1.0), D == 2);
        sum(external(&mesh, &body, analysis, 1.0))
    }

    #[test]
    fn loads_have_their_resultants() {
        for kind in Kind::PLANE {
            // weight on an area of 2, and 1 + 2x over the top, by a thickness of 1.5
            let found = loaded::<2>(kind, Analysis::PlaneStrain);
            let expected = [3.0, 4.0 - 1.5 * (2.0 + 4.0) - 1.5 * 2.0 * 2.0];
            assert!(length(minus(found, expected)) < 1e-12, "{kind:?} {found:?}");
            // ∫ (1 + 2r) 2πr dr from 0.5 to 2.5
            let found = loaded::<2>(kind, Analysis::Axisymmetric);
            let pi = std::f64::consts::PI;
            let pressed = pi * 6.0 + 4.0 * pi * (2.5f64.powi(3) - 0.125) / 3.0;
            let expected = 4.0 - pressed - 2.0 * pi * 6.0;
            assert!((found[1] - expected).abs() < 1e-10, "{kind:?} {found:?}");
        }
        for kind in Kind::SPACE {
            // weight on a volume of 3, and 1 + 2x over the top
            let found = loaded::<3>(kind, Analysis::Space);
            let expected = [3.0, 4.0 - 6.0, 1.5 - (2.0 + 4.0)];
            assert!(length(minus(found, expected)) < 1e-12, "{kind:?} {found:?}");
        }
    }
}
