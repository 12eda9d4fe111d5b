//! Data of a solved model that other models reuse: equal parts are not made twice.

use crate::model::read::view::View;
use crate::model::system::condense::Condensed;

/// Data of a solved model for the next one: its bodies condensed onto the contact. A model of the same stiffness reuses all of it,
/// any other model the equal bodies.
#[derive(Default)]
pub struct Reuse<const D: usize> {
    pub(crate) kept: Option<(Condensed<D>, View<D>)>,
}
