//! From a model to a dual problem at a time: parts, their connections, stiffness and compliance; and back from forces to
//! displacements.

pub mod admissible;
pub mod applied;
pub mod bed;
pub mod bodies;
pub mod bolt;
pub mod border;
pub mod choose;
pub mod compliance;
pub mod condense;
pub mod condition;
pub mod conditions;
pub mod contact;
pub mod counted;
pub mod couple;
pub mod cyclic;
pub mod dependent;
pub mod displaced;
pub mod domains;
pub mod drive;
pub mod face;
pub mod factor;
pub mod filling;
pub mod floating;
pub mod gasket;
pub mod joints;
pub mod key;
pub mod laid;
pub mod links;
pub mod member;
pub mod memory;
pub mod parts;
pub mod reach;
pub mod recover;
pub mod shared;
pub mod state;
