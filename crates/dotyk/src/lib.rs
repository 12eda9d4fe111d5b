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
//! # What is public, and for whom
//!
//! | Modules | For |
//! |---|---|
//! | [`prelude`], [`geometry`], [`mesh`], [`model`] | a program that builds a model and solves it |
//! | [`case`], [`output`] | a front end that reads case files and writes results: the command line, a language binding |
//! | [`dual`], [`solve`] | a solver of one's own: F, d, G and e as a [`DualProblem`](dual::DualProblem), an answer as `Outcome`; a model takes it by [`solve_by`](model::Model::solve_by), and forces found elsewhere by [`dual`](model::Model::dual) |
//! | [`fem`], [`linalg`] | a program that assembles, factors and condenses bodies itself, in several processes for example |
//! | [`host`] | how many threads and how much memory a process has |
//! | [`analytic`] | comparisons with closed-form solutions |
//!
//! How two sides become rows, and the dense algebra within solvers, is not public: it changes with the methods.
//!
//! Source: V. Janovský, P. Procházka, Contact problem of two elastic bodies III, Apl. mat. 25 (1980) 137–146.

pub mod analytic;
pub mod case;
mod contact;
pub mod dual;
pub mod fem;
pub mod geometry;
pub mod host;
pub mod linalg;
pub mod mesh;
pub mod model;
pub mod output;
pub mod prelude;
pub mod solve;
