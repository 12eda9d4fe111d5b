//! Sides of bodies by their names.

use crate::fem::error::FemError;
use crate::mesh::{Facet, Mesh};
use std::collections::BTreeSet;

/// Facets of a side; an error when it is unknown or empty.
pub(crate) fn side_facets<'a, const D: usize>(
    mesh: &'a Mesh<D>,
    side: &str,
) -> Result<&'a [Facet], FemError> {
    match mesh.side(side) {
        None => Err(FemError::UnknownSide {
            side: side.to_string(),
            known: mesh.side_names().collect::<Vec<_>>().join(", "),
        }),
        Some([]) => Err(FemError::EmptySide {
            side: side.to_string(),
        }),
        Some(facets) => Ok(facets),
    }
}

/// Nodes of a side, ascending; an error when it is unknown or empty.
pub(crate) fn side_nodes<const D: usize>(
    mesh: &Mesh<D>,
    side: &str,
) -> Result<BTreeSet<usize>, FemError> {
    side_facets(mesh, side)?;
    let nodes = mesh.side_nodes(side).unwrap_or_default();
    Ok(nodes.into_iter().map(|node| node as usize).collect())
}
