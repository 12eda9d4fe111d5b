//! Sides as a whole: centroid, mean normal, and what their nodes bear of a uniform traction, which is also how they take part in the mean
//! displacement.
//!
//! ```text
//!   c = ∫x dS / A,      n = ∫n dS / A,      share of node i = ∫N_i dS / A
//! ```

use crate::fem::{Analysis, Body, side_points};
use crate::geometry::{Point, add_scaled};
use crate::model::nouns::ids::SideRef;
use crate::model::nouns::member::{ENDS, MemberError};
use std::collections::BTreeMap;

/// A side as a whole.
pub(crate) struct Face<const D: usize> {
    pub centre: Point<D>,
    /// Mean outward normal, a unit vector where the side is plane.
    pub normal: Point<D>,
    /// By node, ascending; 1 in all.
    pub shares: Vec<(usize, f64)>,
}

impl<const D: usize> Face<D> {
    /// The side at an end of a member.
    ///
    /// Errors: a side that is unknown or has no area.
    pub fn new(
        (bodies, analysis): (&[Body<D>], Analysis),
        side: &SideRef,
        end: usize,
    ) -> Result<Self, MemberError> {
        let body = &bodies[side.body.0];
        let fail = || {
            let message = format!("its side \"{}\" is unknown, or has no area", side.side);
            MemberError::new(ENDS[end], message, "no side to pull at", "")
        };
        let (mut area, mut centre, mut normal) = (0.0, [0.0; D], [0.0; D]);
        let mut sums: BTreeMap<usize, f64> = BTreeMap::new();
        for place in side_points(body, &side.side, analysis).map_err(|_| fail())? {
            area += place.area;
            centre = add_scaled(centre, place.area, place.point);
            normal = add_scaled(normal, place.area, place.normal);
            for (node, n) in body.mesh.facet_nodes(place.facet).zip(place.shape) {
                *sums.entry(node as usize).or_insert(0.0) += place.area * n;
            }
        }
        if area <= 0.0 {
            return Err(fail());
        }
        Ok(Self {
            centre: centre.map(|c| c / area),
            normal: normal.map(|c| c / area),
            shares: sums.into_iter().map(|(node, n)| (node, n / area)).collect(),
        })
    }
}
