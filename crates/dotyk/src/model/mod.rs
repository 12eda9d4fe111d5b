//! The user's nouns and what becomes of them: pair → condense → attempt → finish, step by step.
//!
//! A [`Model`] is plain data: bodies with meshes, materials, supports and loads, contacts between their sides.
//! [`Model::solve`] turns it into a [`Solution`]; nothing in between is visible or valid only after a second call.

mod admissible;
mod applied;
mod ask;
mod assumptions;
mod attempt;
mod between;
mod bodies;
mod build;
mod capacity;
mod check;
mod choose;
mod compare;
mod compliance;
mod condense;
mod coupled;
mod dependent;
mod dual;
mod error;
mod event;
mod factor;
mod fields;
mod finish;
mod floating;
mod judge;
mod line;
mod locate;
mod memory;
mod nouns;
mod objection;
mod on_side;
mod on_surface;
mod pair;
mod parts;
mod past;
mod probe;
mod quantity;
mod recover;
mod reuse;
mod section;
mod settle;
mod singular;
mod sliding;
mod solution;
mod stages;
mod steps;
mod study;

pub use crate::contact::ContactError;
pub use attempt::ASSEMBLED;
pub use capacity::{Capacity, Reinforcement};
pub use check::{BodyCheck, Check, ContactCheck};
pub use compare::{Comparison, ComparisonRow};
pub use compliance::DENSE_LIMIT;
pub use dual::{Dual, Unknown};
pub use error::{Advice, Error, NotHeld, Objection, ProbeError, Subject};
pub use event::{Event, Work};
pub use nouns::*;
pub(crate) use on_side::OnSide;
pub use past::{Past, PastBody, PastNode};
pub use quantity::{Dimension, Mistake, Quantity, QuantityError};
pub use reuse::Reuse;
pub use section::{Section, SectionError, SectionQuantity, SectionSolution, Station, Stations};
pub use solution::*;
pub use study::{Column, Make, Member, Study, Varied};
