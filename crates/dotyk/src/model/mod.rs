//! The user's nouns and the pipeline: assemble → condense → solve → recover.
//!
//! A [`Model`] is plain data: bodies with meshes, materials, supports and loads, contacts between their sides.
//! [`Model::solve`] turns it into a [`Solution`]; nothing in between is visible or valid only after a second call.

mod between;
mod build;
mod check;
mod compare;
mod condense;
mod dependent;
mod error;
mod floating;
mod nouns;
mod obstacle;
mod pair;
mod pipeline;
mod probe;
mod recover;
mod sliding;
mod solution;

pub use crate::contact::ContactError;
pub use check::{BodyCheck, Check, ContactCheck};
pub use compare::{Comparison, ComparisonRow};
pub use condense::DENSE_LIMIT;
pub use error::{Error, Subject};
pub use nouns::*;
pub use pipeline::Event;
pub use solution::*;
