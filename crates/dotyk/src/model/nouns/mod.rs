//! Input and results: models, solutions, errors, and the words for them.

pub mod build;
pub mod capacity;
pub mod dimension;
pub mod error;
pub mod event;
pub mod field;
pub mod file_names;
pub mod finding;
pub mod formula;
pub mod gasket;
pub mod ids;
pub mod intrusion;
pub mod member;
pub mod members;
pub mod model;
pub mod presence;
pub mod quantity;
pub mod section;
pub mod solution;
pub mod told;
