//! Command line of dotyk.
fn main() {}
