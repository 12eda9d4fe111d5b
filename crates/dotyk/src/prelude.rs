//! Names for a program that builds and solves a model: `use dotyk::prelude::*;`.

pub use crate::geometry::{Field, Point};
pub use crate::mesh::{
    CellKind, Contour, Cuboid, Diagonals, Division, Drawing, EdgeShape, Mesh, MeshError, MeshFile,
    Outline, OutlineEdge, Rectangle, Ring, SizePoint, TunnelRock,
};
pub use crate::model::{
    Along, Analysis, BodyId, Bolts, Contact, Couple, CoupleKind, Cyclic, Elastic, Error, Finding,
    Gap, Load, Method, Model, Place, Probe, Reading, SideRef, Solution, SolverOptions, Status,
    Support,
};
