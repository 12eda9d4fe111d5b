//! What a solved model leaves to others: nothing is made twice that is the same in both.

use crate::model::read::view::View;
use crate::model::system::condense::Condensed;

/// What a solved model leaves for the next one: its bodies condensed onto the contact. A model of the same stiffness takes all of it
/// up, any other one the bodies that are the same.
#[derive(Default)]
pub struct Reuse<const D: usize> {
    pub(crate) kept: Option<(Condensed<D>, View<D>)>,
}
