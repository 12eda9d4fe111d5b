//! Errors of a contact.

use crate::fem::FemError;

/// An error of one contact; the model adds the contact's name.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum ContactError {
    /// A side is unknown or empty, or a gap is not finite.
    #[error("{body}: {source}")]
    Side {
        /// Name of the body.
        body: String,
        /// The fault.
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
        "node {node} of {side} at {point} faces {other}, but coincides with none of its nodes (nearest: {distance:.3e} away): pairing \"node-to-node\" needs coincident nodes; give both sides the same nodes, or leave out `pairing`"
    )]
    Unpaired {
        /// The side of the node.
        side: String,
        /// The side that it faces.
        other: String,
        /// First node without a partner.
        node: usize,
        /// Its position.
        point: String,
        /// Distance of the nearest node of the other side.
        distance: f64,
    },
    /// An excluded place is not on the nonmortar side.
    #[error(
        "what is excluded {place} has no node of {side}, the side that carries the contact forces"
    )]
    NotOnSide {
        /// The nonmortar side.
        side: String,
        /// The place.
        place: String,
    },
    /// Every node is excluded.
    #[error("all nodes of {side} are excluded: nothing is left of the contact")]
    NothingLeft {
        /// The nonmortar side.
        side: String,
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
    /// A node does not lie on the true surface of its side.
    #[error(
        "node {node} of {side} at {point} lies {distance:.3e} off the `surface` of that side; correct the surface or the mesh"
    )]
    OffSurface {
        /// The side.
        side: String,
        /// The node.
        node: usize,
        /// Its position.
        point: String,
        /// Its distance from the surface.
        distance: f64,
    },
    /// A coefficient or bound of friction is invalid.
    #[error(
        "friction = {text} is {value} at {point} on side \"{side}\"; it must be finite and not negative"
    )]
    Friction {
        /// The nonmortar side.
        side: String,
        /// The expression.
        text: String,
        /// Where.
        point: String,
        /// Its value there.
        value: f64,
    },
    /// The tensile strength of a joint is not between 0 and its cohesion over its coefficient of friction.
    #[error(
        "the tension {text} of {side} is {value} at {point}: it must lie between 0 and cohesion over coulomb, {most}"
    )]
    Tension {
        /// The nonmortar side.
        side: String,
        /// The expression.
        text: String,
        /// Where.
        point: String,
        /// Its value there.
        value: f64,
        /// The largest that it may be.
        most: f64,
    },
    /// Nothing of two sides is as near as wanted.
    #[error(
        "no facets of {} and {} face each other within `reach` = {reach}; give a larger one, or leave it out",
        .sides[0], .sides[1]
    )]
    BeyondReach {
        /// The sides.
        sides: [String; 2],
        /// A length.
        reach: f64,
    },
    /// A contact reaches a face of a sector where the other body has none.
    #[error(
        "{} ends at {point} on a face of the sector {}, the contact goes on beyond it, and {} has no face there: {} must end at the faces of this sector; {advice}",
        .sides[0], .bodies[0], .sides[1], .bodies[1]
    )]
    Sectors {
        /// The side that ends, and the other one.
        sides: [String; 2],
        /// Their bodies.
        bodies: [String; 2],
        /// Where it ends.
        point: String,
        /// What to do.
        advice: &'static str,
    },
    /// A gasket without a law, or whose state cannot go on.
    #[error("its gasket cannot be computed: {why}")]
    Gasket {
        /// Why.
        why: String,
    },
    /// Two sectors are not parts of one whole.
    #[error(
        "{} and {} are sectors of different wholes: bodies that touch need the same axis and number of sectors in `cyclic`",
        .bodies[0], .bodies[1]
    )]
    Wholes {
        /// The bodies.
        bodies: [String; 2],
    },
    /// Supports move the two sides of a tie apart.
    #[error(
        "its sides are tied, but both are held at {point} and move by {distance:.3e} against each other: no force of a tie can change that; prescribe the same displacement on both sides, or on one side alone, or leave the place out (`exclude`)"
    )]
    MovedApart {
        /// Where.
        point: String,
        /// By how much.
        distance: f64,
    },
    /// Another body stands between two sides.
    #[error(
        "between {} and {} another body stands wherever they face each other, {by}: a contact does not act through a body; name what each of them touches, or give the body between `active`",
        .sides[0], .sides[1]
    )]
    Hidden {
        /// The sides.
        sides: [String; 2],
        /// Names of the bodies between.
        by: String,
    },
    /// A side is in front of the back of a tool.
    #[error(
        "all facets of {tool} turn their backs to {side}: outward is where one sees the corners of a triangle counter-clockwise, or the right of the way along an outline; turn them round"
    )]
    Turned {
        /// Name of the tool.
        tool: String,
        /// The side.
        side: String,
    },
    /// There is no node with a multiplier to exclude there.
    #[error(
        "no node of {side} {place} carries a multiplier: in space corners of facets do, nodes in the middle of edges do not; name a corner, or a side"
    )]
    NoCarrier {
        /// The nonmortar side.
        side: String,
        /// Where.
        place: String,
    },
    /// A body of neither two nor three dimensions.
    #[error("{side} is a side of neither the plane nor space")]
    NeitherPlaneNorSpace {
        /// The nonmortar side.
        side: String,
    },
}
