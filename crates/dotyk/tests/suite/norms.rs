//! Errors against exact solutions, integrated over the cells and along the contact.

// every test file uses its own part
#![allow(dead_code)]

use dotyk::fem::quadrature::rule;
use dotyk::geometry::{Point, distance, norm};
use dotyk::mesh::{CellKind, MAX_CELL_NODES, MAX_FACET_NODES, Mesh};
use dotyk::model::{ContactSolution, Elastic, Solution};

/// Displacement [ux, uy] and strains [εxx, εyy, γxy] at a point.
pub type Exact<'a> = &'a dyn Fn(Point<2>) -> ([f64; 2], [f64; 3]);

/// Relative errors of a displacement field: L2 of u, and energy norm in plane strain.
#[derive(Debug, Clone, Copy)]
pub struct FieldError {
    pub l2: f64,
    pub energy: f64,
}

/// Errors by quadrature two orders above what the cell itself needs.
pub fn field_error(
    mesh: &Mesh<2>,
    u: &[Point<2>],
    elastic: Elastic,
    exact: Exact<'_>,
) -> FieldError {
    let Elastic { young, poisson } = elastic;
    let shear = young / (2.0 * (1.0 + poisson));
    let lame = young * poisson / ((1.0 + poisson) * (1.0 - 2.0 * poisson));
    let energy = |[xx, yy, xy]: [f64; 3]| {
        lame * (xx + yy).powi(2) + 2.0 * shear * (xx * xx + yy * yy + 0.5 * xy * xy)
    };
    let (mut error, mut size) = ([0.0; 2], [0.0; 2]);
    for (block, cells) in mesh.blocks().iter().enumerate() {
        let points = rule(cells.kind, 2 * cells.kind.order() + 4);
        for cell in 0..cells.cells().len() {
            let nodes = mesh.cell_nodes(block, cell);
            for point in &points {
                let Local {
                    place,
                    weight,
                    displacement,
                    strain,
                } = at(mesh, cells.kind, nodes, u, &point.xi);
                let weight = weight * point.weight;
                let (exact_u, exact_strain) = exact(place);
                let squared = |v: [f64; 2]| v[0] * v[0] + v[1] * v[1];
                let off = [displacement[0] - exact_u[0], displacement[1] - exact_u[1]];
                error[0] += weight * squared(off);
                size[0] += weight * squared(exact_u);
                error[1] += weight * energy(std::array::from_fn(|i| strain[i] - exact_strain[i]));
                size[1] += weight * energy(exact_strain);
            }
        }
    }
    FieldError {
        l2: (error[0] / size[0]).sqrt(),
        energy: (error[1] / size[1]).sqrt(),
    }
}

/// What the finite-element field is at a point of a cell; `weight` is det J.
struct Local {
    place: Point<2>,
    weight: f64,
    displacement: [f64; 2],
    strain: [f64; 3],
}

fn at(mesh: &Mesh<2>, kind: CellKind, nodes: &[u32], u: &[Point<2>], xi: &[f64; 3]) -> Local {
    let mut shape = [0.0; MAX_CELL_NODES];
    let mut slope = [[0.0; 2]; MAX_CELL_NODES];
    kind.shape(xi, &mut shape);
    kind.gradients(xi, &mut slope);
    let (mut place, mut displacement) = ([0.0; 2], [0.0; 2]);
    // Rows: component; columns: derivative along ξ, η.
    let (mut jacobian, mut gradient) = ([[0.0; 2]; 2], [[0.0; 2]; 2]);
    for (local, &node) in nodes.iter().enumerate() {
        let (x, u) = (mesh.points()[node as usize], u[node as usize]);
        for i in 0..2 {
            place[i] += shape[local] * x[i];
            displacement[i] += shape[local] * u[i];
            for j in 0..2 {
                jacobian[i][j] += x[i] * slope[local][j];
                gradient[i][j] += u[i] * slope[local][j];
            }
        }
    }
    let [[a, b], [c, d]] = jacobian;
    let det = a * d - b * c;
    let inverse = [[d / det, -b / det], [-c / det, a / det]];
    let du = |i: usize, j: usize| gradient[i][0] * inverse[0][j] + gradient[i][1] * inverse[1][j];
    Local {
        place,
        weight: det,
        displacement,
        strain: [du(0, 0), du(1, 1), du(0, 1) + du(1, 0)],
    }
}

/// Relative L2 error of the contact pressure, interpolated between the nodes, integrated along an open chain.
pub fn pressure_error(
    contact: &ContactSolution<2>,
    order: usize,
    exact: impl Fn(Point<2>) -> f64,
) -> f64 {
    let kind = [CellKind::Line2, CellKind::Line3][order - 1];
    let (mut error, mut size) = (0.0, 0.0);
    let mut shape = [0.0; MAX_FACET_NODES];
    let mut slope = [[0.0; 1]; MAX_FACET_NODES];
    for k in 0..(contact.nodes.len() - 1) / order {
        // Ends first, then the middle.
        let mut facet = vec![&contact.nodes[order * k], &contact.nodes[order * (k + 1)]];
        if order == 2 {
            facet.push(&contact.nodes[2 * k + 1]);
        }
        for point in rule(kind, 15) {
            kind.shape(&point.xi, &mut shape);
            kind.gradients(&point.xi, &mut slope);
            let (mut place, mut tangent, mut pressure) = ([0.0; 2], [0.0; 2], 0.0);
            for (local, node) in facet.iter().enumerate() {
                pressure += shape[local] * node.pressure;
                for i in 0..2 {
                    place[i] += shape[local] * node.point[i];
                    tangent[i] += slope[local][0] * node.point[i];
                }
            }
            let weight = point.weight * tangent[0].hypot(tangent[1]);
            let expected = exact(place);
            error += weight * (pressure - expected).powi(2);
            size += weight * expected * expected;
        }
    }
    (error / size).sqrt()
}

/// Observed order between two meshes, the finer with half the cell size.
pub fn order(coarse: f64, fine: f64) -> f64 {
    (coarse / fine).log2()
}

/// The largest difference of displacements of two solutions, over the largest displacement.
pub fn difference<const D: usize>(a: &Solution<D>, b: &Solution<D>) -> f64 {
    let u = |s: &Solution<D>| -> Vec<Point<D>> {
        let bodies = s.bodies.iter();
        bodies.flat_map(|body| body.displacement.clone()).collect()
    };
    let (a, b) = (u(a), u(b));
    let off = a.iter().zip(&b).map(|(&a, &b)| distance(a, b));
    let size = a.iter().map(|&a| norm(a)).fold(0.0, f64::max);
    off.fold(0.0, f64::max) / size
}
