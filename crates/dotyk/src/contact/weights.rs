//! Nodal weights ∫N over part of a side.

use crate::fem::quadrature::{self, QuadraturePoint};
use crate::fem::{Analysis, measure};
use crate::geometry::norm;
use crate::mesh::{Facet, MAX_FACET_NODES, Mesh};
use std::collections::BTreeMap;

/// ∫Nⱼ (times thickness or 2πr) over some facets, by node.
pub(crate) fn nodal_weights<const D: usize>(
    mesh: &Mesh<D>,
    facets: impl IntoIterator<Item = Facet>,
    analysis: Analysis,
    thickness: f64,
) -> BTreeMap<usize, f64> {
    let mut weights = BTreeMap::new();
    for facet in facets {
        let kind = mesh.facet_kind(facet);
        let mut shape = [0.0; MAX_FACET_NODES];
        for QuadraturePoint { xi, weight } in quadrature::facet_rule(kind, 2 * kind.order() + 1) {
            kind.shape(&xi, &mut shape);
            let point = mesh.facet_point(facet, &xi);
            let area = weight
                * norm(mesh.outward_normal(facet, &xi))
                * measure(analysis, thickness, point);
            for (node, n) in mesh.facet_nodes(facet).zip(shape) {
                *weights.entry(node as usize).or_insert(0.0) += area * n;
            }
        }
    }
    weights
}
