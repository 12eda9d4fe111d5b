//! How bodies and their sides are referred to.

pub use crate::fem::{
    Active, Amount, Analysis, Bed, Body, Borders, COMPONENTS, Components, Couple, CoupleKind,
    Elastic, Formulation, Initial, Load, Material, Place, Plastic, Spring, Strength, Support,
};

/// Index of a body in [`Model::bodies`](crate::model::Model::bodies).
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub struct BodyId(
    /// The index.
    pub usize,
);

/// A named side of one of the model's bodies.
#[derive(Debug, Clone, PartialEq)]
pub struct SideRef {
    /// Index of the body in [`Model::bodies`](crate::model::Model::bodies).
    pub body: BodyId,
    /// Name of the side in its mesh.
    pub side: String,
}
