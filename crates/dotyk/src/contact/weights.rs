//! Nodal weights ∫N over part of a side: areas (times thickness or 2πr), and bare lengths.

use crate::fem::quadrature::{self, QuadraturePoint};
use crate::fem::{Analysis, measure};
use crate::geometry::norm;
use crate::mesh::{Facet, MAX_FACET_NODES, Mesh};
use std::collections::BTreeMap;

/// A weight below this part of the mean of its facet counts as not positive. Inside a body of revolution the smallest is
/// half of the mean; that of a quadratic facet's node on the axis is zero up to rounding and the curvature of the facet.
pub(super) const POSITIVE: f64 = 0.1;

/// What a node has of some facets.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct NodalWeight {
    /// ∫N, times thickness or 2πr.
    pub area: f64,
    /// ∫N without these.
    pub extent: f64,
    /// On some facet it is not positive.
    pub negligible: bool,
}

/// The weights of the nodes of some facets.
pub(super) fn nodal_weights<const D: usize>(
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
