//! The user's nouns and the pipeline: assemble → condense → solve → recover.
//!
//! A [`Model`] is plain data: bodies with meshes, materials, supports and loads, contacts between their sides.
//! [`Model::solve`] turns it into a [`Solution`]; nothing in between is visible or valid only after a second call.

mod nouns;
mod solution;

pub use nouns::*;
pub use solution::*;
