//! All bodies and rigid parts, displaced under some contact forces, and what of that each contact sees.

use crate::contact::Moved;
use crate::geometry::{Point, sub};
use crate::model::nouns::ids::BodyId;
use crate::model::nouns::model::Model;
use crate::model::system::condense::Condensed;
use crate::model::system::paired::{Fit, Paired, row_ranges};
use crate::model::system::recover::BodyState;
use std::borrow::Cow;
use std::ops::Range;
use std::sync::Arc;

/// All bodies and rigid parts, displaced.
pub(crate) struct Displaced<const D: usize> {
    pub states: Vec<BodyState<D>>,
    /// Displacements of the nodes of the rigid parts.
    pub parts: Vec<Vec<Point<D>>>,
    /// Gaps of all multipliers.
    pub gaps: Vec<f64>,
    /// To what these are known.
    pub rounding: Vec<f64>,
    /// Gaps after the rigid motions alone.
    pub clearances: Vec<f64>,
    /// The part of the displacements that strains each body.
    pub strained: Vec<Vec<f64>>,
    /// Domain of every part, and rounding of the largest displacement of every domain.
    pub domains: Vec<usize>,
    pub negligible: Vec<f64>,
    /// Bodies that touch nothing and carry no load.
    pub hovering: Vec<String>,
    /// Contacts that press some body let it move.
    pub loose: bool,
}

/// What each contact of a model moves with, counted from where its sides were fitted to each other.
pub(crate) fn moved<'a, const D: usize>(
    model: &Model<D>,
    pair: &Paired<D>,
    Displaced { states, parts, .. }: &'a Displaced<D>,
) -> Moved<'a, D> {
    let since = |body: BodyId, fitted: &Option<Arc<[Point<D>]>>| {
        let now = &states[body.0].u[..];
        let Some(then) = fitted else {
            return Cow::Borrowed(now);
        };
        let both = now.iter().zip(then.iter());
        Cow::Owned(both.map(|(now, then)| sub(*now, *then)).collect())
    };
    let Fit { own, other } = &pair.fit;
    Moved {
        own: since(pair.nonmortar.body, own),
        other: pair.mortar.as_ref().map(|side| since(side.body, other)),
        obstacle: match (&pair.mortar, pair.opposite) {
            (None, Some(part)) => parts[part - model.bodies.len()][0],
            _ => pair.obstacle_motion,
        },
    }
}

/// The contacts among the pairs, with their places and rows: couples and links have no sides that could overlap.
pub(crate) fn contact_rows<'a, const D: usize>(
    model: &Model<D>,
    condensed: &'a Condensed<D>,
) -> impl Iterator<Item = (usize, (Range<usize>, &'a Paired<D>))> + use<'a, D> {
    let contacts = row_ranges(&condensed.paired).take(model.contacts.len());
    contacts.enumerate()
}
