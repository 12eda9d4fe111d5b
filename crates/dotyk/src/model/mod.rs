//! The user's nouns and what becomes of them, in five rooms, each of which uses itself and those before it:
//!
//! | Room | What it holds |
//! |---|---|
//! | `nouns` | what a user writes, and what comes out |
//! | `system` | bodies and pairs at a time as a dual problem, and from forces back to displacements |
//! | `read` | what is read off displaced bodies and their forces |
//! | `march` | step by step: the loop around solver and certificate, the judge, what a step leaves to the next one |
//! | `ask` | what a model can be asked |
//!
//! A [`Model`] is plain data: bodies with meshes, materials, supports and loads, contacts between their sides.
//! [`Model::solve`] turns it into a [`Solution`]; nothing in between is visible or valid only after a second call.

mod ask;
mod march;
mod nouns;
mod read;
mod system;

pub use crate::contact::ContactError;
pub use ask::check::{BodyCheck, Check};
pub use ask::compare::{Comparison, ComparisonRow};
pub use ask::dual::{Dual, Unknown};
pub use ask::study::{Column, Make, Member, Study, Varied};
pub use march::past::{Past, PastBody, PastNode};
pub use march::reuse::Reuse;
pub use nouns::bar::{Bar, BarEnd, BarError, BarSolution, BarStation, Bond};
pub use nouns::capacity::{Capacity, Reinforcement};
pub use nouns::dimension::Dimension;
pub use nouns::error::{Advice, Error, NotHeld, Objection, ProbeError, Subject};
pub use nouns::event::{Event, Work};
pub(crate) use nouns::field::numbers_at_nodes;
pub use nouns::field::{BodyField, On, Shape};
pub use nouns::file_names::{NameError, check_file_names};
pub use nouns::ids::*;
pub use nouns::intrusion::Intrusion;
pub use nouns::model::*;
pub use nouns::quantity::{Mistake, Quantity, QuantityError};
pub use nouns::section::{
    Section, SectionError, SectionQuantity, SectionSolution, Station, Stations,
};
pub use nouns::solution::*;
pub(crate) use nouns::told::told_in_steps;
pub(crate) use read::on_side::OnSide;
pub(crate) use read::probe::read_probe;
pub use read::remarks::ContactCheck;
pub use system::compliance::{ASSEMBLED, DENSE_LIMIT};
pub(crate) use system::memory::least;
