//! Beds that only press, as links at the points of integration of their side.
//!
//! ```text
//!   gap = −(n·u − q) ≥ 0,  λ ≥ 0      k = kₙ A         q = λ/k: pressed in
//! ```
//!
//! A bed is a row of springs, each of which parts by itself. They are at the points of integration of the facets, with the area
//! A = weight · Jacobian: u = Σ Nₐuₐ there, and where all press their work is that of a bed that acts both ways,
//!
//! ```text
//!   Σ_q k_q (n·u)² = Σ_q kₙ A_q (n·u)² = ∫ kₙ (n·u)² dS        for every u of straight facets, with rules of degree 2 · order
//! ```
//!
//! of a line 2 points, or 3 with a middle node; 4 or 9 of a quadrilateral, 3 or 6 of a triangle: one to three times its nodes, and
//! all of positive weight. Conditions at nodes would divide the area among them, k = kₙ∫N, which is too stiff for a side that
//! turns: by a third with one facet across a footing, by 1/n² of that with n facets. Conditions on the nodal forces of the whole
//! bed, ∫NᵀCN dS u, would open corners of curved facets under an even pressure, because their ∫N is at most zero.
//!
//! kₙ is taken at these points, and where it is 0 there is no spring. Where it varies along the side, the rules have two degrees more:
//! 3 or 4 points of a line, 9 or 16 of a quadrilateral, exact for a kₙ of degree 2 on straight facets.

use crate::contact::{Coupling, Interface, InterfaceNode, Row, frame};
use crate::dual::Block;
use crate::fem::{Pad, Place, pads};
use crate::model::nouns::error::Error;
use crate::model::nouns::ids::{BodyId, SideRef};
use crate::model::nouns::model::Model;
use crate::model::system::condition::{Condition, Elastic, Source};
use crate::model::system::links::{axis, carrier, less, linked};
use crate::model::system::parts::Owner;

/// The condition of a bed, from its body, the index of its spring, and its part.
///
/// Errors: a side that has no points of integration.
pub(crate) fn bedded<const D: usize>(
    model: &Model<D>,
    (of, place): (usize, usize),
    part: usize,
) -> Result<Condition<D>, Error<D>> {
    let body = &model.bodies[of];
    let spring = &body.springs[place];
    let refused = |source| Error::in_body(body, source);
    let pads = pads(body, spring, model.analysis).map_err(refused)?;
    let pads: Vec<Pad<D>> = pads.into_iter().filter(Pad::bears).collect();
    let (Place::Side(side), false) = (spring.place(), pads.is_empty()) else {
        return Err(refused(spring.nowhere(true)));
    };
    let mut interface = Interface::empty(Coupling::Normal);
    let mut elastic = Elastic::default();
    for (row, pad) in pads.into_iter().enumerate() {
        let along = |n: f64| pad.normal.map(|c| n * c);
        let own: Row<D> = pad.nodes.iter().map(|&(k, n)| (k, along(n))).collect();
        let nearest = pad.nodes.iter().max_by(|a, b| a.1.total_cmp(&b.1));
        interface.nodes.push(InterfaceNode {
            node: nearest.map_or(0, |nearest| nearest.0),
            frame: frame(pad.normal, &[]),
            weight: pad.area,
            extent: pad.extent,
            ..carrier(row)
        });
        interface.nonmortar.push(own);
        interface.mortar.push(less(row, 0));
        elastic
            .stiffness
            .push(axis::<D>(0).map(|c| c * pad.stiffness[0] * pad.area));
        elastic.load.push([0.0; D]);
    }
    let name = format!("spring of {}.{side}", body.name);
    let nonmortar = SideRef {
        body: BodyId(of),
        side,
    };
    Ok(Condition {
        law: Some(Block::Unilateral),
        ..linked(
            (Source::Of(Owner::Bed(of, place)), name),
            (nonmortar, part),
            interface,
            elastic,
        )
    })
}
