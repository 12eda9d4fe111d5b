//! Contacts that are found between bodies.

use crate::fem::Active;
use crate::model::nouns::ids::BodyId;
use crate::model::nouns::model::{Contact, Gap, Law, Pairing};
use crate::model::nouns::told::listed;

/// Contacts to be found between bodies: every two of them whose outer surfaces face each other within a reach become one with these
/// properties, named "NAME-a-b" in the order of the model's bodies.
#[derive(Debug, Clone)]
pub struct Finding {
    /// The first part of their names.
    pub name: String,
    /// At least two bodies.
    pub bodies: Vec<BodyId>,
    /// Largest distance of facets that face each other, a length. `None`: a tenth of the diagonal of the smaller body's box, at most half
    /// of the thickness behind the facets of either body.
    pub reach: Option<f64>,
    /// As of [`Contact::pairing`].
    pub pairing: Option<Pairing>,
    /// As of [`Contact::gap`].
    pub gap: Option<Gap>,
    /// As of [`Contact::law`].
    pub law: Law,
    /// As of [`Contact::active`].
    pub active: Active,
}

impl Finding {
    /// The name of a contact between two bodies of these names.
    pub fn name_of(&self, [a, b]: [&str; 2]) -> String {
        format!("{}-{a}-{b}", self.name)
    }

    /// Whether its contacts do not ask how far apart their sides are: ties, and gaps that are given.
    pub(crate) fn is_closed_anywhere(&self) -> bool {
        let given = matches!(self.gap, Some(Gap::Closed | Gap::Given(_)));
        given || matches!(self.law, Law::Tied)
    }
}

/// What came of a [`Finding`].
#[derive(Debug, Clone)]
pub struct Found<const D: usize> {
    /// The contacts, in the order of their bodies.
    pub contacts: Vec<Contact<D>>,
    /// Pairs of bodies that were left to a written contact, in words.
    pub left: Vec<String>,
    /// Bodies that overlap at first by more than the reach, so that nothing was found between them, in words.
    pub warnings: Vec<String>,
}

/// Why contacts cannot be found.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum FindingError {
    /// Fewer than two bodies.
    #[error("contact `{name}` is to be found between at least two bodies, and has {count}")]
    TooFew {
        /// Name of the finding.
        name: String,
        /// How many it has.
        count: usize,
    },
    /// A body stands twice in the list.
    #[error("contact `{name}` names body `{body}` twice: a body has no contact with itself")]
    Repeated {
        /// Name of the finding.
        name: String,
        /// The body.
        body: String,
    },
    /// No two bodies face each other.
    #[error(
        "contact `{name}`: no two of its bodies face each other within {}: {}",
        .reach.map_or("the default `reach`".to_string(), |reach| format!("`reach` = {reach}")),
        told_nearest(.nearest.as_ref())
    )]
    Nothing {
        /// Name of the finding.
        name: String,
        /// Its reach.
        reach: Option<f64>,
        /// The two bodies that are nearest to each other, and their distance.
        nearest: Option<([String; 2], f64)>,
    },
    /// Two findings found a contact between the same bodies.
    #[error(
        "contacts `{first}` and `{second}` are both found between the bodies {}: leave the two out of one of them, or write their contact with `sides`",
        listed(&.bodies.each_ref().map(String::as_str), "and")
    )]
    Twice {
        /// Name of the finding.
        second: String,
        /// The contact that was found first.
        first: String,
        /// The bodies.
        bodies: [String; 2],
    },
    /// The name of the new side is that of another one.
    #[error(
        "body `{body}` has a side `{side}` already, which is not what contact `{name}` found: give that another name"
    )]
    SideExists {
        /// Name of the finding.
        name: String,
        /// The body.
        body: String,
        /// The side.
        side: String,
    },
}

fn told_nearest(found: Option<&([String; 2], f64)>) -> String {
    match found {
        Some(([a, b], distance)) => {
            format!("`{a}` and `{b}` are nearest, {distance:.4e} apart at their nodes")
        }
        None => "no two of them are there at the same time, or other contacts stand between all"
            .to_string(),
    }
}
