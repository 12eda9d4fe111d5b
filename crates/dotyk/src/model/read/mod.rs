//! Results read off displaced bodies and their contact forces: fields, sections, probes, peaks, and remarks on them.

pub mod assumptions;
pub mod beds;
pub mod coupled;
pub mod fields;
pub mod formulas;
pub mod line;
pub mod on_side;
pub mod probe;
pub mod remarks;
pub mod section;
pub mod singular;
pub mod stiff;
pub mod unglued;
pub mod view;
