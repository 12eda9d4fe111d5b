//! From step to step: the loop around solver and certificate, the judge, and what a step leaves to the next one.

pub mod attempt;
pub mod between;
pub mod equilibrate;
pub mod finish;
pub mod flow;
pub mod intrusion;
pub mod jam;
pub mod judge;
pub mod objection;
pub mod open;
pub mod past;
pub mod reuse;
pub mod settle;
pub mod sliding;
pub mod steps;
pub mod torn;
