//! Entry points of a model: its solution, its dual problem, a check, a comparison of solvers, a study.

pub mod anew;
pub mod check;
pub mod compare;
pub mod doors;
pub mod dual;
pub mod found;
pub mod study;
