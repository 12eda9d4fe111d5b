//! Elastic contact mechanics: bodies are factored once, the contact unknowns alone are iterated.
//!
//! Everything before the contact solver produces, and everything after it consumes, one small object,
//! the dual contact problem (module [`dual`]):
//!
//! ```text
//!   min  1/2 λᵀFλ − dᵀλ    over λ ∈ Λ,  subject to  Gλ = e,     gap(λ, α) = Fλ − d − Gᵀα
//! ```
//!
//! One sign convention for the whole crate: gap ≥ 0 is open, λ ≥ 0 and pressure ≥ 0 are compression, the
//! contact normal points outward from the nonmortar side, tensile stress is positive.
//! Numbers are in any consistent units. 2D forces are per unit thickness unless a thickness is given.
//!
//! Source: V. Janovský, P. Procházka, Contact problem of two elastic bodies III, Apl. mat. 25 (1980) 137–146.

pub mod analytic;
pub mod case;
pub mod contact;
pub mod dual;
pub mod fem;
pub mod geometry;
pub mod linalg;
pub mod mesh;
pub mod model;
pub mod output;
pub mod prelude;
pub mod solve;
