//! Errors of one body.

use crate::linalg::LinalgError;

/// An error of one body; the model adds the body's name.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum FemError {
    /// A support, load or contact names a side that the mesh lacks.
    #[error("there is no side \"{side}\"; the sides are: {known}")]
    UnknownSide {
        /// The name.
        side: String,
        /// The names that exist.
        known: String,
    },
    /// A side has no facets.
    #[error("side \"{side}\" has no facets")]
    EmptySide {
        /// Its name.
        side: String,
    },
    /// A formulation that the cells of the body do not have.
    #[error("formulation = \"enhanced\" {why}")]
    Formulation {
        /// Reason and advice.
        why: &'static str,
    },
    /// An initial stress or strain that the analysis cannot have.
    #[error("{why}")]
    Initial {
        /// Why.
        why: &'static str,
    },
    /// The remaining part of the forces of a neighbour that has gone is not in [0, 1].
    #[error(
        "what a neighbour that has gone leaves of its forces, release = {text}, is {value} at t = {time}: it must lie in [0, 1]"
    )]
    Release {
        /// The expression.
        text: String,
        /// Its value.
        value: f64,
        /// When.
        time: f64,
    },
    /// A modulus that changes with time, where that is not supported.
    #[error("`young` that changes with time is not supported yet {why}")]
    Ages {
        /// Where.
        why: &'static str,
    },
    /// A modulus that at some time is no positive number.
    #[error(
        "`young` = {text} is {value} at t = {time}: it must be positive and finite at the times of all load steps"
    )]
    Young {
        /// The expression.
        text: String,
        /// Its value.
        value: f64,
        /// When.
        time: f64,
    },
    /// A spring without a stiffness, or with one that is negative or not finite.
    #[error("the stiffness of a spring is {value}: it must be positive")]
    Spring {
        /// The stiffness.
        value: f64,
    },
    /// A bed whose stiffness is somewhere negative or no number.
    #[error(
        "the stiffness {text} of the bed of side \"{side}\" is {value} at {point}: it must be a number from 0 on there, at all times the same"
    )]
    Bed {
        /// Its side.
        side: String,
        /// The expression.
        text: String,
        /// Its value.
        value: f64,
        /// Where.
        point: String,
    },
    /// A bed whose stiffness is 0 at all its points.
    #[error(
        "the bed of side \"{side}\" has no stiffness: {texts} is 0 at all its points of integration; leave the spring out, or use facets that are smaller than the part that has one"
    )]
    NoStiffness {
        /// Its side.
        side: String,
        /// The expressions.
        texts: String,
    },
    /// A force on a side without area.
    #[error(
        "side \"{side}\" has no area, it lies on the axis of symmetry: a force cannot be spread over it"
    )]
    NoArea {
        /// The side.
        side: String,
    },
    /// A couple with axial symmetry has a load or prescribed value other than along the axis.
    #[error(
        "point \"{name}\": with axial symmetry a coupled point only moves along the axis, and {what} has no meaning there"
    )]
    NotAxial {
        /// Name of the point.
        name: String,
        /// The value without a meaning.
        what: &'static str,
    },
    /// A load, support, gap or friction value is NaN or infinite.
    #[error("{what} = {text} is not finite at {point}")]
    NotFinite {
        /// Such as `load on side "top"`.
        what: String,
        /// The expression.
        text: String,
        /// Where.
        point: String,
    },
    /// The faces of a sector are not the same.
    #[error(
        "cyclic: side \"{from}\" turned by 360/{sectors} degrees about {axis} does not lie on side \"{to}\": {why}; name the two faces that bound the sector, and its axis"
    )]
    Unlike {
        /// One face.
        from: String,
        /// The other.
        to: String,
        /// Number of sectors.
        sectors: usize,
        /// A point of the axis.
        axis: String,
        /// What differs.
        why: String,
    },
    /// Supports hold the faces of a sector in ways that differ.
    #[error(
        "cyclic: at {point} supports of side \"{to}\" prescribe another displacement than those of side \"{from}\" after the turn (off by {}); hold one of the two faces, or both alike", Short(*.off)
    )]
    HeldApart {
        /// One face.
        from: String,
        /// The other.
        to: String,
        /// Where.
        point: String,
        /// The difference.
        off: f64,
    },
    /// Two supports prescribe different values for the same displacement.
    #[error(
        "node {node} at {point}: the supports {first} and {second} prescribe contradictory displacements there ({} and {}); remove one of the two, or make them agree", Short(*.a), Short(*.b)
    )]
    Contradiction {
        /// Node of the mesh.
        node: usize,
        /// Its position.
        point: String,
        /// One support.
        first: String,
        /// The other.
        second: String,
        /// Value implied by the first.
        a: f64,
        /// Value of the second.
        b: f64,
    },
    /// No node is near enough to a point.
    #[error(
        "{what}: the nearest node, {node} at {at}, is {distance:.4e} away from {point}, farther than half an edge ({limit:.4e}); move the point onto a node"
    )]
    NoNodeNear {
        /// Such as "support".
        what: String,
        /// The point.
        point: String,
        /// Nearest node.
        node: usize,
        /// Its position.
        at: String,
        /// Its distance.
        distance: f64,
        /// Largest admissible distance.
        limit: f64,
    },
    /// No material applies to a group of cells.
    #[error("no material for the cells of group {group}")]
    NoMaterial {
        /// The group.
        group: String,
    },
    /// A material names a group that the mesh lacks.
    #[error(
        "a material is given for group \"{group}\", but the mesh has no such group; the groups are: {known}"
    )]
    UnknownGroup {
        /// The group.
        group: String,
        /// The groups that exist.
        known: String,
    },
    /// A material constant is out of range.
    #[error("{name} = {value} is out of range: {range}")]
    Material {
        /// Its name.
        name: &'static str,
        /// Its value.
        value: f64,
        /// Admissible values.
        range: &'static str,
    },
    /// A material that yields where that is not possible.
    #[error("`plastic` {why}")]
    Plastic {
        /// Reason and advice.
        why: &'static str,
    },
    /// An initial stress that a material which yields does not bear.
    #[error(
        "its initial stress is outside the yield surface: at {place} von Mises' stress is {stress:.4e}, {beyond:.4e} beyond `yield`; let it obey the strength"
    )]
    Unborne {
        /// Where it is worst.
        place: String,
        /// Its von Mises stress there.
        stress: f64,
        /// How much of it is beyond the yield stress.
        beyond: f64,
    },
    /// A plane analysis in space, or the other way round.
    #[error("analysis \"{analysis}\" does not fit {dimension} dimensions")]
    Dimension {
        /// Its name.
        analysis: &'static str,
        /// Dimension of the mesh.
        dimension: usize,
    },
    /// Points with r < 0 in an axisymmetric analysis.
    #[error(
        "node {node} at {point} has a negative radius: in an axisymmetric analysis x is the radius"
    )]
    NegativeRadius {
        /// Node of the mesh.
        node: usize,
        /// Its position.
        point: String,
    },
    /// The stiffness cannot be factored.
    #[error(
        "the stiffness is singular at node {node} at {point}: {source}; check the cells around that node"
    )]
    Singular {
        /// Node of the mesh.
        node: usize,
        /// Its position.
        point: String,
        /// The error of the factorisation.
        source: LinalgError,
    },
}

/// A point as messages show it: `(1.5, -0.25)`.
pub(crate) fn show<const D: usize>(point: [f64; D]) -> String {
    let numbers: Vec<String> = point.iter().map(|&c| format!("{}", Short(c))).collect();
    format!("({})", numbers.join(", "))
}

/// A number to six significant digits without trailing zeros.
pub(crate) struct Short(pub f64);

impl std::fmt::Display for Short {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let rounded: f64 = format!("{:.5e}", self.0).parse().unwrap_or(self.0);
        let size = rounded.abs();
        if rounded == 0.0 {
            f.write_str("0")
        } else if (1e-4..1e7).contains(&size) || !size.is_finite() {
            write!(f, "{rounded}")
        } else {
            write!(f, "{rounded:e}")
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_are_short_and_readable() {
        assert_eq!(show([1.0 / 3.0, -0.0]), "(0.333333, 0)");
        assert_eq!(show([1e-12, 2.5e9]), "(1e-12, 2.5e9)");
    }
}
