//! To come.

pub mod quadrature;
