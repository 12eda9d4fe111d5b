//! Nodal weights ∫N over part of a side: areas (times thickness or 2πr), and bare lengths.

use crate::fem::quadrature::{self, QuadraturePoint};
use crate::fem::{Analysis, measure};
use crate::geometry::norm;
use crate::mesh::{Facet, MAX_FACET_NODES, Mesh};
use std::collections::BTreeMap;

/// A weight below this part of the mean of its facet counts as not positive. Inside a body of revolution the smallest is
/// half of the mean; that of a quadratic facet's node on the axis is zero up to rounding and the curvature of the facet.
pub(super) const POSITIVE: f64 = 0.1;

/// Weight of a node in some facets.
#[derive(Debug, Clone, Copy, Default)]
pub struct NodalWeight {
    /// ∫N, times thickness or 2πr.
    pub area: f64,
    /// ∫N without these.
    pub extent: f64,
    /// On some facet it is not positive.
    pub negligible: bool,
}

/// The weights of the nodes of some facets.
pub fn nodal_weights<const D: usize>(
    mesh: &Mesh<D>,
    facets: impl IntoIterator<Item = Facet>,
    analysis: Analysis,
    thickness: f64,
) -> BTreeMap<usize, NodalWeight> {
    let mut weights: BTreeMap<usize, NodalWeight> = BTreeMap::new();
    for facet in facets {
        let kind = mesh.facet_kind(facet);
        let mut shape = [0.0; MAX_FACET_NODES];
        let mut own = [NodalWeight::default(); MAX_FACET_NODES];
        for QuadraturePoint { xi, weight } in quadrature::rule(kind, 2 * kind.order() + 1) {
            kind.shape(&xi, &mut shape);
            let length = weight * norm(mesh.outward_normal(facet, &xi));
            let factor = measure(analysis, thickness, mesh.facet_point(facet, &xi));
            for (own, n) in own.iter_mut().zip(shape) {
                own.area += length * factor * n;
                own.extent += length * n;
            }
        }
        let own = &own[..kind.nodes()];
        let mean = own.iter().map(|w| w.area).sum::<f64>() / own.len() as f64;
        for (node, own) in mesh.facet_nodes(facet).zip(own) {
            let sum = weights.entry(node as usize).or_default();
            sum.area += own.area;
            sum.extent += own.extent;
            // a weight that is not a number is not positive either
            sum.negligible |= own.area <= POSITIVE * mean || own.area.is_nan();
        }
    }
    weights
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contact::gaps::tests::{body, flat, node_at, wall};
    use crate::geometry::Point;
    use crate::mesh::{CellKind, Cuboid};

    fn of_side<const D: usize>(
        mesh: &Mesh<D>,
        analysis: Analysis,
        thickness: f64,
    ) -> BTreeMap<usize, NodalWeight> {
        let facets = mesh.side("bottom").unwrap().iter().copied();
        nodal_weights(mesh, facets, analysis, thickness)
    }

    /// A few roundings of numbers about as large as one.
    fn same(a: f64, b: f64) -> bool {
        (a - b).abs() < 1e-14
    }

    #[test]
    fn nodes_weigh_what_their_functions_do() {
        let linear = flat(&[0.0, 1.0, 3.0], 1.0, CellKind::Quad4);
        let weights = of_side(&linear.mesh, Analysis::PlaneStress, 0.5);
        for (x, extent) in [(0.0, 0.5), (1.0, 1.5), (3.0, 1.0)] {
            let weight = weights[&node_at(&linear, [x, 0.0])];
            assert!(same(weight.extent, extent) && same(weight.area, 0.5 * extent));
            assert!(!weight.negligible);
        }
        assert_eq!(weights.len(), 3);
        // a sixth, two thirds, a sixth
        let quadratic = flat(&[0.0, 1.5, 3.0], 1.0, CellKind::Quad8);
        let weights = of_side(&quadratic.mesh, Analysis::PlaneStrain, 2.0);
        for (x, extent) in [(0.0, 0.5), (1.5, 2.0), (3.0, 0.5)] {
            let weight = weights[&node_at(&quadratic, [x, 0.0])];
            assert!(same(weight.extent, extent) && same(weight.area, 2.0 * extent));
        }
        let cuboid = Cuboid {
            from: [0.0; 3],
            to: [1.0, 3.0, 1.0],
            cells: [1; 3],
            cell: CellKind::Hex8,
        };
        let cube = body(cuboid.build().unwrap());
        for weight in of_side(&cube.mesh, Analysis::Solid, 7.0).values() {
            assert!(same(weight.area, 0.75) && same(weight.extent, 0.75));
        }
    }

    #[test]
    fn rings_weigh_their_circumference() {
        let turn = 2.0 * std::f64::consts::PI;
        let linear = flat(&[0.5, 2.0], 1.0, CellKind::Quad4);
        let weights = of_side(&linear.mesh, Analysis::Axisymmetric, 7.0);
        // ∫N 2πr of a facet of length L from r to R: 2πL (2r + R)/6
        for (x, other) in [(0.5, 2.0), (2.0, 0.5)] {
            let weight = weights[&node_at(&linear, [x, 0.0])];
            assert!(same(weight.area / turn, 1.5 * (2.0 * x + other) / 6.0));
            assert!(same(weight.extent, 0.75));
        }
    }

    #[test]
    fn weights_of_curved_facets_are_their_integrals() {
        let nodes = [[0.5, 0.0], [1.1, 0.4], [2.0, 0.3]];
        let curved = wall(&nodes, 2.0, CellKind::Quad8);
        let weights = of_side(&curved.mesh, Analysis::Axisymmetric, 1.0);
        let shapes = |t: f64| [0.5 * t * (t - 1.0), 1.0 - t * t, 0.5 * t * (t + 1.0)];
        let slopes = |t: f64| [t - 0.5, -2.0 * t, t + 0.5];
        let at = |values: [f64; 3]| -> Point<2> {
            std::array::from_fn(|d| (0..3).map(|k| values[k] * nodes[k][d]).sum())
        };
        let mut areas = [0.0; 3];
        let steps = 2000;
        for step in 0..steps {
            let t = (2 * step + 1) as f64 / steps as f64 - 1.0;
            let length = norm(at(slopes(t))) * 2.0 / steps as f64;
            for (area, n) in areas.iter_mut().zip(shapes(t)) {
                *area += n * length * 2.0 * std::f64::consts::PI * at(shapes(t))[0];
            }
        }
        for (node, area) in nodes.into_iter().zip(areas) {
            let weight = weights[&node_at(&curved, node)].area;
            // the error of three Gauss points for a length that is a square root; two have a larger one
            assert!((weight / area - 1.0).abs() < 4e-3, "{weight} {area}");
        }
    }

    #[test]
    fn a_weight_below_a_tenth_of_the_mean_is_negligible() {
        // the inner end of a quadratic facet from r to r + L weighs r/2 : (r + L/2) of the mean
        for (radius, negligible) in [(0.0, true), (0.12, true), (0.13, false)] {
            let places = [radius, radius + 0.5, radius + 1.0];
            let body = flat(&places, 1.0, CellKind::Quad8);
            let weights = of_side(&body.mesh, Analysis::Axisymmetric, 1.0);
            let inner = weights[&node_at(&body, [radius, 0.0])];
            assert_eq!(inner.negligible, negligible, "{radius}");
            assert!(!weights[&node_at(&body, [radius + 1.0, 0.0])].negligible);
        }
        // once on some facet, whatever the others give
        let body = flat(&[0.0, 0.5, 1.0, 1.5, 2.0], 1.0, CellKind::Quad8);
        let flipped = Mesh::clone(&body.mesh)
            .map_points(|[x, y]| [1.0 - x, y])
            .unwrap();
        let weights = of_side(&flipped, Analysis::Axisymmetric, 1.0);
        let on_axis = flipped.points().iter().position(|&x| x == [0.0, 0.0]);
        assert!(weights[&on_axis.unwrap()].negligible);
        // and NaN is not positive
        let weights = of_side(&flipped, Analysis::PlaneStrain, f64::NAN);
        assert!(weights.values().all(|weight| weight.negligible));
    }
}
