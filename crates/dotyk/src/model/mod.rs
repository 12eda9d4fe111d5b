//! The user's nouns, and how they are solved, in five rooms, each of which uses itself and those before it:
//!
//! | Room | What it holds |
//! |---|---|
//! | `nouns` | the user's input and the results |
//! | `system` | the dual problem of bodies and pairs at a given time, and from forces back to displacements |
//! | `read` | results read off displaced bodies and their forces |
//! | `march` | step by step: the loop around solver and certificate, the judge, the state passed on to the next step |
//! | `ask` | the entry points of a model |
//!
//! A [`Model`] is plain data: bodies with meshes, materials, supports and loads, contacts between their sides.
//! [`Model::solve`] turns it into a [`Solution`]; nothing in between is visible or valid only after a second call.

mod ask;
mod march;
mod nouns;
mod read;
mod system;

pub use crate::contact::ContactError;
pub use ask::check::{BodyCheck, Check, MemberCheck};
pub use ask::compare::{Comparison, ComparisonRow};
pub use ask::dual::{Dual, Unknown};
pub(crate) use ask::found::find;
pub use ask::study::{Column, Make, Study, StudyMember, StudyRow, Varied};
pub use march::past::{Past, PastBody, PastNode};
pub use march::reuse::Reuse;
pub use nouns::capacity::{Capacity, Reinforcement};
pub use nouns::dimension::Dimension;
pub use nouns::error::{Advice, Error, NotHeld, Objection, ProbeError, Subject};
pub use nouns::event::{Event, Work};
pub(crate) use nouns::field::numbers_at_nodes;
pub use nouns::field::{BodyField, On, Shape};
pub use nouns::file_names::{NameError, check_file_names};
pub use nouns::finding::{Finding, FindingError, Found};
pub use nouns::formula::Formula;
pub use nouns::gasket::{Gasket, GasketError};
pub use nouns::ids::*;
pub use nouns::intrusion::Intrusion;
pub use nouns::member::{
    Bond, Line, MemberEnd, MemberError, MemberSolution, MemberStation, MemberWords,
};
pub use nouns::members::*;
pub use nouns::model::*;
pub use nouns::quantity::{Mistake, Quantity, QuantityError};
pub use nouns::section::{
    Across, Extrusion, Section, SectionError, SectionQuantity, SectionSolution, Station, Stations,
};
pub use nouns::solution::*;
pub(crate) use nouns::told::{listed, told_in_steps};
pub(crate) use read::on_side::OnSide;
pub(crate) use read::probe::read_probe;
pub use read::remarks::ContactCheck;
pub use system::compliance::{ASSEMBLED, DENSE_LIMIT};
pub(crate) use system::memory::least;
