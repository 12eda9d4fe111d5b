//! Bolts: bodies, or parts of them, that are cut across and whose two sides of the cut are drawn together.
//!
//! ```text
//!   u⁻ − u⁺ = s a           at every node of the cut; a its axis, outward from the side behind it
//!   tightened               s is such that the tension of the cut, Σ λ·a, is the prestress
//!   else                    s stays what it was, or is the given shortening
//! ```
//!
//! The sides of the cut move relative to each other by one shift along the axis, and as one body otherwise: a shank of the length L − s
//! stands in the place of one of the length L. Tension is positive whatever the direction of the axis.
//!
//! Units: s a length; the prestress a force, that of the whole cut: in the plane of the thickness, with axial symmetry of the full turn,
//! in a model that is cut by symmetry of its part.

use crate::dual::Block;
use crate::fem::Active;
use crate::geometry::{Field, norm};
use crate::model::nouns::member::{Bond, MemberError, MemberWords, Pull, PullLaw};

/// A bolt that is tightened at a cut. Its line ends at the two sides of the cut, whose nodes lie on each other in pairs.
#[derive(Debug, Clone)]
pub struct Bolt {
    /// Axis, of any length and direction, missing coordinates zero; `None`: the mean normal of the cut.
    pub axis: Option<[f64; 3]>,
    /// Tension by which it is tightened; it may depend on time.
    pub prestress: Option<Field>,
    /// When it is tightened; `None`: in the step in which it comes.
    pub tightened: Option<Active>,
    /// Shortening while it is not tightened, counted from its undeformed state; `None`: it stays what it was.
    pub shortening: Option<Field>,
}

/// What acts on a cut at a time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Drawn {
    /// This tension.
    Force(f64),
    /// This shortening.
    Length(f64),
    /// The shortening that it has.
    Kept,
}

/// Prestress and shortening are driving quantities: bolts that differ in their values are equal.
impl PartialEq for Bolt {
    fn eq(&self, other: &Self) -> bool {
        let Self {
            axis,
            prestress,
            tightened,
            shortening,
        } = self;
        (axis, tightened) == (&other.axis, &other.tightened)
            && prestress.is_some() == other.prestress.is_some()
            && shortening.is_some() == other.shortening.is_some()
    }
}

pub(crate) const WORDS: MemberWords = MemberWords {
    key: "bolt",
    plural: "bolts",
    apart: "bolt",
    apart_plural: "bolts",
    choice: "drawn by",
};

impl Bolt {
    /// A bolt that is tightened by a tension in its first step, and locked then.
    pub fn tightened_by(prestress: f64) -> Self {
        Self {
            axis: None,
            prestress: Some(Field::constant(prestress)),
            tightened: None,
            shortening: None,
        }
    }

    /// What acts on it at a time, while it is being tightened or not.
    ///
    /// Errors: a value that is not finite.
    pub(crate) fn drawn(&self, tightening: bool, time: f64) -> Result<Drawn, MemberError> {
        let value = |key: &'static str, field: &Field| match field.at([0.0; 3], time) {
            value if value.is_finite() => Ok(value),
            value => Err(MemberError::number(key, value, "a finite number")),
        };
        Ok(match (tightening, &self.prestress, &self.shortening) {
            (true, Some(force), _) => Drawn::Force(value("prestress", force)?),
            (_, _, Some(length)) => Drawn::Length(value("shortening", length)?),
            _ => Drawn::Kept,
        })
    }
}

impl Pull for Bolt {
    fn check(&self, _: Bond) -> Result<(), MemberError> {
        let refuse =
            |key, message: &str, label: &str| Err(MemberError::new(key, message, label, ""));
        if let Some(axis) = self.axis {
            let length = norm(axis);
            if !(length > 0.0 && length.is_finite()) {
                return refuse("axis", "its axis has no direction", "not a direction");
            }
        }
        if self.prestress.is_none() && self.shortening.is_none() {
            let message = "it has neither `prestress` nor `shortening`: nothing tightens it";
            return refuse("", message, "how is it tightened?");
        }
        if self.prestress.is_none() && self.tightened.is_some() {
            let message = "`tightened` is when its prestress acts, and it has none";
            return refuse("tightened", message, "superfluous");
        }
        Ok(())
    }

    fn stiffness(&self, _: f64, _: f64) -> f64 {
        0.0
    }

    fn law(&self, _: f64) -> PullLaw {
        PullLaw {
            sign: 1.0,
            block: Block::Free { size: 1 },
            offset: 0.0,
            gap: 0.0,
        }
    }

    fn chosen(&self, _: Bond) -> &'static str {
        match (&self.prestress, &self.shortening) {
            (Some(_), None) => "force",
            (None, _) => "length",
            (Some(_), Some(_)) => "force, length",
        }
    }

    fn tightened(&self, comes: bool, time: f64) -> bool {
        self.prestress.is_some() && self.tightened.map_or(comes, |when| when.at(time))
    }
}
