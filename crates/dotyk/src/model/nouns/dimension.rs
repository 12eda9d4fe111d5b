//! Physical dimensions of quantities.

/// Physical dimension of a quantity.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Dimension {
    /// A length.
    Length,
    /// A force.
    Force,
    /// A force per area.
    Stress,
    /// A length times a length.
    Area,
    /// A force times a length.
    Moment,
    /// A force per length.
    ForcePerLength,
    /// A moment per length.
    MomentPerLength,
    /// A ratio.
    Ratio,
    /// A work.
    Energy,
    /// Radians.
    Angle,
    /// An integral of another one, or that of an expression.
    Other,
}
