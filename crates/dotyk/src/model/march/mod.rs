//! From step to step: the loop around solver and certificate, the judge, and the state passed on to the next step.

pub mod attempt;
pub mod between;
pub mod borne;
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
