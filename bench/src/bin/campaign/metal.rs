//! Plasticity of metal, written independently of the program: stresses after all load steps, from displacements alone.
//!
//! ```text
//!   s* = 2μ (dev ε − ε_p),   σᵥ* = √(3/2 s*:s*),   Δp = max(0, σᵥ* − σ_Y − H p) / (3μ + H),   ε_p += Δp 3s*/(2σᵥ*),   p += Δp
//!   σ = K θ + 2μ (dev ε − ε_p)
//! ```
//!
//! at the Gauss points of the stiffness, step by step, each with the plastic strain ε_p and the equivalent plastic strain p of the
//! steps before. θ is the volumetric strain; once a point of a body has yielded, in its quadrilaterals of second order θ is replaced
//! by its least-squares fit by a linear function of the reference coordinates (normal equations of three coefficients).
//!
//! The judge solves no problem: displacements are an answer if these stresses are in equilibrium.

use crate::cells::{Kind, Place};
use crate::elastic::{Internal, Station, Tensor, largest, stations, tables};
use crate::problem::{Analysis, Body, Metal};
use crate::raw::Mesh;
use crate::vector::{dot, plus, times};

/// Plastic strain of a point, and the equivalent plastic strain.
type Plastic = (Tensor, f64);

fn deviator(a: Tensor) -> Tensor {
    let mean = (a[0][0] + a[1][1] + a[2][2]) / 3.0;
    let mut deviator = a;
    (0..3).for_each(|i| deviator[i][i] -= mean);
    deviator
}

/// a + s·b.
fn sum(a: Tensor, s: f64, b: Tensor) -> Tensor {
    std::array::from_fn(|i| plus(a[i], s, b[i]))
}

/// One step of a point to a strain; its elastic stress relative to its strength, above 1 where the point yields.
fn returned((plastic, p): &mut Plastic, strain: Tensor, shear: f64, metal: &Metal) -> f64 {
    let trial = sum(deviator(strain), -1.0, *plastic).map(|row| times(2.0 * shear, row));
    let contracted: f64 = trial.iter().map(|&row| dot(row, row)).sum();
    let size = (1.5 * contracted).sqrt();
    let strength = metal.yields + metal.hardening * *p;
    let beyond = size - strength;
    if beyond <= 0.0 {
        return size / strength;
    }
    let more = beyond / (3.0 * shear + metal.hardening);
    *p += more;
    *plastic = sum(*plastic, more * 1.5 / size, trial);
    size / strength
}

/// The least-squares fit a + bξ + cη of values at points, evaluated at these points.
fn linear(points: &[(Place, f64)], values: &[f64]) -> Vec<f64> {
    let functions = |[x, y, _]: Place| [1.0, x, y];
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
    let at = |&(xi, _): &(Place, f64)| {
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
pub fn internal<const D: usize>(
    (mesh, body, metal): (&Mesh<D>, &Body<D>, &Metal),
    analysis: Analysis,
    ways: &[&[[f64; D]]],
    (least, gives_way): (f64, bool),
) -> (Internal<D>, bool) {
    let shear = body.young / (2.0 * (1.0 + body.poisson));
    let bulk = body.young / (3.0 * (1.0 - 2.0 * body.poisson));
    let moves = ways.last().copied().unwrap_or_default();
    let mut out = Internal {
        forces: vec![[0.0; D]; mesh.points.len()],
        magnitudes: vec![0.0; mesh.points.len()],
    };
    let tables = tables(mesh, |kind| kind.rule(analysis.axisymmetric()));
    let points = |cell: usize| stations((mesh, body, analysis), &tables, cell);
    let strain = |at: &Station<D>, nodes: &[usize], moves: &[[f64; D]]| {
        at.strain(|k| moves[nodes[k]], moves[nodes[0]])
    };
    let mut most = 0.0;
    let mut plastic: Vec<Vec<Tensor>> = Vec::new();
    for (cell, (_, nodes)) in mesh.cells.iter().enumerate() {
        let of_point = |at: &Station<D>| {
            let mut own = ([[0.0; 3]; 3], 0.0);
            for moves in ways {
                let size = returned(&mut own, strain(at, nodes, moves), shear, metal);
                most = f64::max(most, size);
            }
            own.0
        };
        plastic.push(points(cell).iter().map(of_point).collect());
    }
    let flows = most > 1.0;
    for (cell, (kind, nodes)) in mesh.cells.iter().enumerate() {
        let points = points(cell);
        let strains = points.iter().map(|at| strain(at, nodes, moves));
        let strains: Vec<Tensor> = strains.collect();
        let volumetric = strains.iter().map(|e| e[0][0] + e[1][1] + e[2][2]);
        let mut volumes: Vec<f64> = volumetric.collect();
        if (flows || gives_way) && matches!(kind, Kind::Quad8 | Kind::Quad9) {
            let places: Vec<_> = points.iter().map(|at| (at.xi, at.volume)).collect();
            volumes = linear(&places, &volumes);
        }
        let largest = largest(nodes, moves, least);
        for (k, at) in points.iter().enumerate() {
            let elastic = sum(deviator(strains[k]), -1.0, plastic[cell][k]);
            let mut stress = elastic.map(|row| times(2.0 * shear, row));
            (0..3).for_each(|i| stress[i][i] += bulk * volumes[k]);
            at.add(&mut out, nodes, &stress, [bulk + 2.0 * shear, largest]);
        }
    }
    (out, !flows && most > NEAR)
}
