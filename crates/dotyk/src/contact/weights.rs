//! Nodal weights ∫N over part of a side.

use crate::fem::{Analysis, quadrature};
use crate::geometry::norm;
use crate::mesh::{Facet, Mesh};
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
        let mut shape = [0.0; 9];
        for (xi, weight) in quadrature::facet_rule(kind, 2 * kind.order() + 1) {
            kind.shape(xi, &mut shape);
            let mut point = [0.0; D];
            for (node, n) in mesh.facet_nodes(facet).zip(shape) {
                for i in 0..D {
                    point[i] += n * mesh.points()[node][i];
                }
            }
            let area = weight
                * norm(mesh.facet_normal(facet, xi))
                * crate::fem::measure(analysis, thickness, point);
            for (node, n) in mesh.facet_nodes(facet).zip(shape) {
                *weights.entry(node).or_insert(0.0) += area * n;
            }
        }
    }
    weights
}
