//! Points of a nonmortar side between its nodes, and what lies opposite: what the judge looks at, whatever the rows are.
//!
//! ```text
//!   gap(x) = g₀(x) + n·(u_m(y) − u_s(x)),     y on the line x + s·n(x)
//! ```
//!
//! g₀ is the initial gap as the contact defines it (measured, closed, given). A pressure that varies from node to node dents
//! both bodies by about p (h_s/E_s + h_m/E_m), h the lengths of the facets, E their plane moduli: what the meshes cannot
//! resolve.

use crate::contact::mortar::{Pairing, shape};
use crate::contact::node_to_node::facets;
use crate::contact::{Against, ContactError, End, InitialGap};
use crate::fem::Analysis;
use crate::geometry::Point;
use crate::mesh::Facet;
use rayon::prelude::*;

/// Points on each facet: the middles of as many equal parts.
const POINTS: usize = 6;

/// One point that faces something.
#[derive(Debug, Clone, PartialEq)]
pub struct Sample<const D: usize> {
    /// Undeformed position.
    pub point: Point<D>,
    /// Contact normal, outward from the nonmortar side.
    pub normal: Point<D>,
    /// Initial gap.
    pub gap: f64,
    /// Nodes and shape functions of the nonmortar side.
    pub own: Vec<(usize, f64)>,
    /// Those of the mortar side; empty against an obstacle.
    pub opposite: Vec<(usize, f64)>,
    /// Depth that a unit pressure dents between the nodes, a length³/force.
    pub dent: f64,
}

/// The points of every facet of the nonmortar side that face something, facet by facet. None yet in space.
///
/// Errors: as [`crate::contact::pair_mortar`].
pub fn samples<const D: usize>(
    nonmortar: End<'_, D>,
    against: Against<'_, D>,
    gap: InitialGap<'_>,
    analysis: Analysis,
    time: f64,
) -> Result<Vec<Vec<Sample<D>>>, ContactError> {
    if D != 2 {
        return Ok(Vec::new());
    }
    let pairing = Pairing::new(nonmortar, against, gap, analysis, time)?;
    let on_facet = |&facet: &Facet| {
        let points = (0..POINTS).map(|k| -1.0 + (2 * k + 1) as f64 / POINTS as f64);
        let found = points.filter_map(|xi| sample(&pairing, facet, xi).transpose());
        found.collect::<Result<Vec<_>, _>>()
    };
    facets(nonmortar)?.par_iter().map(on_facet).collect()
}

fn sample<const D: usize>(
    pairing: &Pairing<'_, D>,
    facet: Facet,
    xi: f64,
) -> Result<Option<Sample<D>>, ContactError> {
    let line = pairing.line(facet, xi);
    let own = pairing.nonmortar;
    let (normal, gap, opposite, other) = match pairing.against {
        Against::Obstacle(rigid, _) => {
            let place = (line.start, line.direction);
            match rigid.opposite(place, pairing.time, own)? {
                Some((normal, gap)) => (normal, gap, Vec::new(), 0.0),
                None => return Ok(None),
            }
        }
        Against::Side(mortar) => {
            let shallow = own.body.mesh.facet_length(facet);
            let Some(hit) = pairing.facing(line, shallow) else {
                return Ok(None);
            };
            let nodes = shape(&mortar.body.mesh, hit.facet, hit.xi.clamp(-1.0, 1.0));
            let gap = pairing.gap_at(facet, line, hit)?;
            (line.direction, gap, nodes, dent(mortar, hit.facet))
        }
    };
    Ok(Some(Sample {
        point: line.start,
        normal,
        gap,
        own: shape(&own.body.mesh, facet, xi),
        opposite,
        dent: dent(own, facet) + other,
    }))
}

/// h/E of a facet: its length over the plane modulus E/(1 − ν²) of its cell; zero without a material.
fn dent<const D: usize>(end: End<'_, D>, facet: Facet) -> f64 {
    let block = &end.body.mesh.blocks()[facet.block as usize];
    let elastic = end.body.elastic(block);
    elastic.map_or(0.0, |e| {
        end.body.mesh.facet_length(facet) / e.plane_modulus()
    })
}
