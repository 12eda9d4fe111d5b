//! The sheets of the other side that a side faces: near and far surfaces, each separately.
//!
//! A facet in front of an edge faces the near surface with one part and a farther one with another. One condition on a mean over
//! both would be a condition on neither: biorthogonal ψ are negative on parts of a facet, so that a far surface counts as an overlap
//! of the near one. Parts of facets belong to one sheet if they are adjacent, and their opposites are adjacent, too, without a
//! corner; on each sheet a node has a row of its own, as if the sheets were two contacts.

use crate::contact::corners::surfaces;
use crate::contact::functions::{Cell, Piece};
use crate::contact::{Against, ContactError};
use crate::geometry::Groups;
use crate::mesh::Facet;
use std::collections::BTreeMap;

/// Divides the pieces of a side by the sheets that they face, each in the order of the side. With `whole` corners do not separate
/// sheets, because one condition holds both of their faces.
///
/// Errors: nodes off their true surface.
pub(super) fn sheets<const D: usize>(
    cells: &[Cell],
    pieces: Vec<Piece>,
    against: Against<'_, D>,
    whole: bool,
) -> Result<Vec<Vec<Piece>>, ContactError> {
    let Against::Side(mortar) = against else {
        return Ok(vec![pieces]);
    };
    let facets = mortar.facets()?;
    let first = match whole {
        true => vec![0; facets.len()],
        false => surfaces(mortar)?.first,
    };
    let surface: BTreeMap<Facet, usize> = facets.iter().copied().zip(first).collect();
    let mut groups = Groups::new(pieces.len());
    let mut seen: BTreeMap<(usize, usize, u32), usize> = BTreeMap::new();
    for (index, piece) in pieces.iter().enumerate() {
        let Some(opposite) = piece.opposite else {
            continue;
        };
        for &own in &cells[piece.cell].nodes {
            for other in mortar.body.mesh.facet_nodes(opposite) {
                let before = *seen
                    .entry((own, surface[&opposite], other))
                    .or_insert(index);
                groups.join(before, index);
            }
        }
    }
    let mut sheets: BTreeMap<usize, Vec<Piece>> = BTreeMap::new();
    for (index, piece) in pieces.into_iter().enumerate() {
        sheets.entry(groups.first(index)).or_default().push(piece);
    }
    Ok(sheets.into_values().collect())
}
