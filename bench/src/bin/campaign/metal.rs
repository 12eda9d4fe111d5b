//! Plasticity of metal, written independently of the program: stresses after all load steps, from displacements alone.
//!
//! ```text
//!   s* = 2μ (dev ε − ε_p),   σᵥ* = √(3/2 s*:s*),   Δp = max(0, σᵥ* − σ_Y − H p) / (3μ + H),   ε_p += Δp 3s*/(2σᵥ*),   p += Δp
//!   σ = K θ + 2μ (dev ε − ε_p)
//! ```
//!
//! at the Gauss points of the stiffness, step by step, each with the plastic strain ε_p and the equivalent plastic strain p of the
//! steps before. θ is the volumetric strain; once a point of a body has yielded, in its quadrilaterals of second order θ is replaced
//! by its least-squares fit by a linear function of the reference coordinates (normal equations of three coefficients). Components
//! xx yy zz xy; around an axis zz is the hoop.
//!
//! The judge solves no problem: displacements are an answer if these stresses are in equilibrium.

use crate::cells::Kind;
use crate::elastic::{Internal, Station, depth, station};
use crate::plane::{Vector, length, minus, plus};
use crate::problem::{Analysis, Body, Metal};
use crate::raw::Mesh;

/// Plastic strain of a point, and the equivalent plastic strain.
type Plastic = ([f64; 4], f64);

/// Strain of a cell at one of its points, from displacements relative to its first node.
fn strain(at: &Station, nodes: &[usize], moves: &[Vector], axisymmetric: bool) -> [f64; 4] {
    let first = moves[nodes[0]];
    let mut strain = [0.0; 4];
    for ((&node, g), n) in nodes.iter().zip(&at.gradients).zip(&at.shape) {
        let u = minus(moves[node], first);
        strain[0] += g[0] * u[0];
        strain[1] += g[1] * u[1];
        strain[3] += 0.5 * (g[1] * u[0] + g[0] * u[1]);
        if axisymmetric {
            strain[2] += n * moves[node][0] / at.x[0];
        }
    }
    strain
}

/// The shear component counts twice: xy stands for yx, too.
fn contracted(a: [f64; 4]) -> f64 {
    a[0] * a[0] + a[1] * a[1] + a[2] * a[2] + 2.0 * a[3] * a[3]
}

fn deviator(a: [f64; 4]) -> [f64; 4] {
    let mean = (a[0] + a[1] + a[2]) / 3.0;
    [a[0] - mean, a[1] - mean, a[2] - mean, a[3]]
}

/// One step of a point to a strain; its elastic stress relative to its strength, above 1 where the point yields.
fn returned((plastic, p): &mut Plastic, strain: [f64; 4], shear: f64, metal: &Metal) -> f64 {
    let trial: [f64; 4] = {
        let dev = deviator(strain);
        std::array::from_fn(|i| 2.0 * shear * (dev[i] - plastic[i]))
    };
    let size = (1.5 * contracted(trial)).sqrt();
    let strength = metal.yields + metal.hardening * *p;
    let beyond = size - strength;
    if beyond <= 0.0 {
        return size / strength;
    }
    let more = beyond / (3.0 * shear + metal.hardening);
    *p += more;
    for (plastic, s) in plastic.iter_mut().zip(trial) {
        *plastic += more * 1.5 * s / size;
    }
    size / strength
}

/// The least-squares fit a + bξ + cη of values at points, evaluated at these points.
fn linear(points: &[(Vector, f64)], values: &[f64]) -> Vec<f64> {
    let functions = |[x, y]: Vector| [1.0, x, y];
    let (mut matrix, mut right) = ([[0.0; 3]; 3], [0.0; 3]);
    for (&(xi, weight), value) in points.iter().zip(values) {
        let f = functions(xi);
        for i in 0..3 {
            right[i] += weight * f[i] * value;
            for j in 0..3 {
                matrix[i][j] += weight * f[i] * f[j];
            }
        }
    }
    for k in 0..3 {
        for i in k + 1..3 {
            let (pivot, part) = (matrix[k], matrix[i][k] / matrix[k][k]);
            for (entry, above) in matrix[i].iter_mut().zip(pivot) {
                *entry -= part * above;
            }
            right[i] -= part * right[k];
        }
    }
    let mut solved = [0.0; 3];
    for i in (0..3).rev() {
        let known: f64 = (i + 1..3).map(|j| matrix[i][j] * solved[j]).sum();
        solved[i] = (right[i] - known) / matrix[i][i];
    }
    let at = |&(xi, _): &(Vector, f64)| {
        let f = functions(xi);
        (0..3).map(|k| f[k] * solved[k]).sum()
    };
    points.iter().map(at).collect()
}

/// A body without a yielding point may have the cells of a flowing one if a point is this near to yielding: with the stiffer cells of an
/// elastic body that point may yield, so that neither is an answer but this one.
const NEAR: f64 = 0.9;

/// Nodal forces of the stresses of a body of metal after the displacements of all steps in turn, with the cells of a flowing body if it
/// flows or `gives_way`; and whether it may have either.
pub fn internal(
    (mesh, body, metal): (&Mesh, &Body, &Metal),
    analysis: Analysis,
    ways: &[&[Vector]],
    (least, gives_way): (f64, bool),
) -> (Internal, bool) {
    let round = analysis.axisymmetric();
    let shear = body.young / (2.0 * (1.0 + body.poisson));
    let bulk = body.young / (3.0 * (1.0 - 2.0 * body.poisson));
    let moves = ways.last().copied().unwrap_or_default();
    let mut out = Internal {
        forces: vec![[0.0; 2]; mesh.points.len()],
        magnitudes: vec![0.0; mesh.points.len()],
    };
    let points = |cell: usize| -> Vec<(Vector, Station)> {
        let rule = mesh.cells[cell].0.rule(round).into_iter();
        rule.map(|(xi, weight)| (xi, station(mesh, cell, xi, weight)))
            .collect()
    };
    let mut most = 0.0;
    let mut plastic: Vec<Vec<Plastic>> = Vec::new();
    for (cell, (_, nodes)) in mesh.cells.iter().enumerate() {
        let of_point = |(_, at): &(Vector, Station)| {
            let mut own = ([0.0; 4], 0.0);
            for moves in ways {
                let size = returned(&mut own, strain(at, nodes, moves, round), shear, metal);
                most = f64::max(most, size);
            }
            own
        };
        plastic.push(points(cell).iter().map(of_point).collect());
    }
    let flows = most > 1.0;
    for (cell, (kind, nodes)) in mesh.cells.iter().enumerate() {
        let points = points(cell);
        let strains = points.iter().map(|(_, at)| strain(at, nodes, moves, round));
        let strains: Vec<[f64; 4]> = strains.collect();
        let mut volumes: Vec<f64> = strains.iter().map(|e| e[0] + e[1] + e[2]).collect();
        if (flows || gives_way) && matches!(kind, Kind::Quad8 | Kind::Quad9) {
            let places = points
                .iter()
                .map(|(xi, at)| (*xi, at.area * depth(body, analysis, at.x)));
            volumes = linear(&places.collect::<Vec<_>>(), &volumes);
        }
        let largest = nodes
            .iter()
            .fold(least, |s: f64, &n| s.max(length(moves[n])));
        for (((_, at), strain), (theta, (own, _))) in points
            .iter()
            .zip(strains)
            .zip(volumes.iter().zip(&plastic[cell]))
        {
            let dev = deviator(strain);
            let mut stress: [f64; 4] = std::array::from_fn(|i| 2.0 * shear * (dev[i] - own[i]));
            stress[..3].iter_mut().for_each(|s| *s += bulk * theta);
            let volume = at.area * depth(body, analysis, at.x);
            let slopes: f64 = at.gradients.iter().map(|g| length(*g)).sum();
            for ((&node, g), n) in nodes.iter().zip(&at.gradients).zip(&at.shape) {
                let mut force = [
                    stress[0] * g[0] + stress[3] * g[1],
                    stress[3] * g[0] + stress[1] * g[1],
                ];
                if round {
                    force[0] += stress[2] * n / at.x[0];
                }
                out.forces[node] = plus(out.forces[node], volume, force);
                out.magnitudes[node] +=
                    volume * (bulk + 2.0 * shear) * length(*g) * slopes * largest;
            }
        }
    }
    (out, !flows && most > NEAR)
}
