//! Sides as a whole: centroid, mean normal, and what their nodes bear of a uniform traction, which is also how they take part in the mean
//! displacement.
//!
//! ```text
//!   c = ∫x dS / A,      n = ∫n dS / A,      share of node i = ∫N_i dS / A
//! ```

use crate::fem::{Analysis, Body, FemError, side_points};
use crate::geometry::{Point, add_scaled};
use crate::model::nouns::ids::SideRef;
use crate::model::nouns::member::{ENDS, MemberError};
use std::collections::BTreeMap;

/// A side as a whole.
pub(crate) struct Face<const D: usize> {
    /// Its area, in the plane its length times the thickness.
    pub area: f64,
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
        Self::of(body, &side.side, analysis).map_err(|_| {
            let message = format!("its side \"{}\" is unknown, or has no area", side.side);
            MemberError::new(ENDS[end], message, "no side to pull at", "")
        })
    }

    /// A side of a body.
    ///
    /// Errors: a side that is unknown or has no area.
    pub fn of(body: &Body<D>, side: &str, analysis: Analysis) -> Result<Self, FemError> {
        let (mut area, mut centre, mut normal) = (0.0, [0.0; D], [0.0; D]);
        let mut sums: BTreeMap<usize, f64> = BTreeMap::new();
        for place in side_points(body, side, analysis)? {
            area += place.area;
            centre = add_scaled(centre, place.area, place.point);
            normal = add_scaled(normal, place.area, place.normal);
            for (node, n) in body.mesh.facet_nodes(place.facet).zip(place.shape) {
                *sums.entry(node as usize).or_insert(0.0) += place.area * n;
            }
        }
        if area <= 0.0 {
            return Err(FemError::EmptySide {
                side: side.to_string(),
            });
        }
        Ok(Self {
            area,
            centre: centre.map(|c| c / area),
            normal: normal.map(|c| c / area),
            shares: sums.into_iter().map(|(node, n)| (node, n / area)).collect(),
        })
    }
}
