//! All tests that see the library from outside, in one binary: one link, and shared code is compiled once.
//!
//! A file is a module; `cargo test --release --test suite rates::` runs one of them.

mod axisymmetric;
mod bending;
mod cohesion;
mod couple;
mod determinism;
mod drawing;
mod examples;
mod friction;
mod gmsh;
mod gmsh_space;
mod initial;
mod joints;
mod judge;
mod layers;
mod levels;
mod lines;
mod links;
mod mindlin;
mod mortar;
mod names;
mod norms;
mod outline;
mod own;
mod past;
mod patch;
mod probes;
mod rates;
mod sections;
mod sliding;
mod solids;
mod solvers;
mod source;
mod space;
mod space_cells;
mod space_cost;
mod space_friction;
mod space_hertz;
mod space_judge;
mod stages;
mod steps;
mod strength;
mod tables;
mod tidy;
mod warnings;
