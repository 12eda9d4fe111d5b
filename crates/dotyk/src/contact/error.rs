//! What can be wrong with a contact.

use crate::fem::FemError;

/// An error of one contact; the model adds the contact's name.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum ContactError {
    /// A side is unknown or empty, or a gap is not finite.
    #[error("{body}: {source}")]
    Side {
        /// Name of the body.
        body: String,
        /// What is wrong.
        source: FemError,
    },
    /// A gap is not finite.
    #[error("gap = {text} is not finite at {point} on side \"{side}\"")]
    NotFinite {
        /// The side.
        side: String,
        /// The expression.
        text: String,
        /// Where.
        point: String,
    },
    /// Node-to-node pairing was asked for sides whose nodes do not coincide.
    #[error(
        "pairing \"node-to-node\" needs coincident nodes, but node {node} of {nonmortar} at {point} has no partner on {mortar} (nearest: {distance:.3e} away)"
    )]
    Unpaired {
        /// The nonmortar side.
        nonmortar: String,
        /// The mortar side.
        mortar: String,
        /// First node without a partner.
        node: usize,
        /// Its position.
        point: String,
        /// Distance of the nearest node of the mortar side.
        distance: f64,
    },
    /// Nodal weights are not all positive.
    #[error(
        "node {node} of {side} at {point} has no positive nodal weight; use pairing \"mortar\""
    )]
    Weight {
        /// The nonmortar side.
        side: String,
        /// The node.
        node: usize,
        /// Its position.
        point: String,
    },
    /// The capability comes later.
    #[error("{what} is not supported yet")]
    NotYet {
        /// What.
        what: &'static str,
    },
}
