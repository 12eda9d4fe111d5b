//! Linear elasticity of one body: from a mesh, materials, supports and loads to
//!
//! ```text
//!   min 1/2 uᵀKu − fᵀu   over u with prescribed components,     K R = 0 for the rigid modes R left free
//! ```
//!
//! Dof `D·node + component`. At nodes held in an oblique direction the components are taken along the axes of the
//! node's own frame (first the held directions), so that a prescribed displacement is always one dof.
//! Tensile stress is positive; forces in plane analyses are for the body's thickness.

mod ageing;
mod assemble;
mod block;
mod borders;
mod cells;
mod coincident;
mod couple;
mod cut;
mod cyclic;
mod elasticity;
mod enhanced;
mod error;
mod initial;
mod internal;
mod loads;
mod locking;
mod modes;
mod nouns;
mod overstress;
mod pieces;
mod plastic;
mod points;
pub mod quadrature;
mod sides;
mod springs;
mod strength;
mod stress;
mod supports;
mod surface;
#[cfg(test)]
mod tests;
mod volume;

pub use ageing::Ages;
pub(crate) use assemble::{ALONG, assemble_after, completed, largest_coefficient};
pub use assemble::{BodySystem, assemble};
pub use borders::Borders;
pub use couple::{Couple, CoupleKind};
pub use cyclic::Cyclic;
pub use error::FemError;
pub use initial::{Components, Initial, NAMES as COMPONENTS};
pub use loads::{Amount, Load};
pub(crate) use loads::{SidePoint, nodal_volumes, side_points, volume_points};
pub use modes::{RigidBasis, describe_motion, list_motions};
pub use nouns::{Active, Analysis, Body, Elastic, Formulation, Material, Place, Support};
pub(crate) use nouns::{History, Part};
pub use plastic::Plastic;
pub use points::{CellPoints, cell_points, nodal_forces};
pub use springs::{Bed, Spring};
pub use strength::Strength;
pub use stress::{principal, recover_spin, recover_strain, recover_stress, von_mises};
pub use supports::{Constraints, Held, nearest_node};
pub use surface::node_normals;

pub(crate) use cells::measure;
pub(crate) use coincident::{SAME, coincident, largest_facet, placed, spans};
pub(crate) use cut::{Ahead, Along, Push, Resultant, Sums};
pub(crate) use cyclic::{Turn, Twins};
pub(crate) use enhanced::has_modes;
pub(crate) use error::{Short, show};
pub(crate) use initial::{OutOfBalance, out_of_balance, tilted};
pub(crate) use internal::internal_forces;
pub(crate) use locking::{INCOMPRESSIBLE, Unseen, unseen};
pub(crate) use modes::fit_rigid;
pub(crate) use overstress::overstress;
pub(crate) use pieces::pieces;
pub(crate) use plastic::{Increment, Yielded};
pub(crate) use sides::{side_facets, side_nodes};
pub(crate) use springs::{Pad, pads, spring_forces, spring_loads};
pub(crate) use stress::{recover_yielded, recover_yielded_stress};
pub(crate) use supports::{AGREE, describe};
pub(crate) use surface::TrueSurface;
