//! All bodies and rigid parts, displaced under some contact forces, and the displacements of the sides of each contact.

use crate::contact::Moved;
use crate::geometry::{Point, sub};
use crate::model::nouns::ids::BodyId;
use crate::model::system::condition::{Condition, Fit};
use crate::model::system::recover::BodyState;
use std::borrow::Cow;
use std::sync::Arc;

/// All bodies and rigid parts, displaced.
pub(crate) struct Displaced<const D: usize> {
    pub states: Vec<BodyState<D>>,
    /// Displacements of the nodes of the parts behind the bodies.
    pub parts: Vec<Vec<Point<D>>>,
    /// Gaps of all multipliers.
    pub gaps: Vec<f64>,
    /// Uncertainty of these.
    pub rounding: Vec<f64>,
    /// Gaps after the rigid motions alone.
    pub clearances: Vec<f64>,
    /// The part of the displacements that strains each body.
    pub strained: Vec<Vec<f64>>,
    /// Domain of every part, and rounding of the largest displacement of every domain.
    pub domains: Vec<usize>,
    pub negligible: Vec<f64>,
    /// Bodies without contact and without load.
    pub hovering: Vec<String>,
    /// Some body is pressed by contacts and still free to move.
    pub loose: bool,
}

impl<const D: usize> Displaced<D> {
    /// Displacements of the nodes of a part.
    pub fn nodes(&self, part: usize) -> &[Point<D>] {
        match self.states.get(part) {
            Some(body) => &body.u,
            None => &self.parts[part - self.states.len()],
        }
    }
}

/// Displacements of the sides of each contact of a model, counted from their fitting to each other.
pub(crate) fn moved<'a, const D: usize>(
    condition: &Condition<D>,
    displaced: &'a Displaced<D>,
) -> Moved<'a, D> {
    let since = |body: BodyId, fitted: &Option<Arc<[Point<D>]>>| {
        let now = displaced.nodes(body.0);
        let Some(then) = fitted else {
            return Cow::Borrowed(now);
        };
        let both = now.iter().zip(then.iter());
        Cow::Owned(both.map(|(now, then)| sub(*now, *then)).collect())
    };
    let Fit { own, other } = &condition.touch.fit;
    Moved {
        own: since(condition.nonmortar.body, own),
        other: condition
            .mortar
            .as_ref()
            .map(|side| since(side.body, other)),
        obstacle: match (&condition.mortar, condition.opposite) {
            (None, Some(part)) => displaced.nodes(part)[0],
            _ => condition.touch.obstacle_motion,
        },
    }
}
