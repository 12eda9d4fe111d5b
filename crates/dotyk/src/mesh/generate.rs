//! Structured generators.

use super::CellKind;
use crate::geometry::Point;

/// How quadrilaterals are cut into triangles.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Diagonals {
    /// Alternating, like a checkerboard.
    #[default]
    Checkerboard,
    /// The other checkerboard.
    CheckerboardOdd,
    /// All from the first to the third corner.
    Forward,
    /// All from the second to the fourth corner.
    Backward,
}

/// Axis-parallel rectangle; sides left right bottom top.
#[derive(Debug, Clone, PartialEq)]
pub struct Rectangle {
    /// Lower left corner.
    pub from: Point<2>,
    /// Upper right corner.
    pub to: Point<2>,
    /// Cells along x and y.
    pub cells: [usize; 2],
    /// Kind of cells.
    pub cell: CellKind,
    /// Cuts, for triangles.
    pub diagonals: Diagonals,
}

/// Ring or part of a ring; sides inner outer, and start end unless it is full.
#[derive(Debug, Clone, PartialEq)]
pub struct Ring {
    /// Centre.
    pub center: Point<2>,
    /// Inner radius.
    pub inner: f64,
    /// Outer radius.
    pub outer: f64,
    /// First and last angle in degrees from +x; `None`: the full ring.
    pub angles: Option<[f64; 2]>,
    /// Cells around and through.
    pub cells: [usize; 2],
    /// Size of a cell over that of its neighbour before it, outward.
    pub ratio: f64,
    /// The same around, from the springline towards crown and invert.
    pub grade: f64,
    /// Kind of cells.
    pub cell: CellKind,
    /// Cuts, for triangles.
    pub diagonals: Diagonals,
}

/// The half x ≥ 0 of a plate with a round hole at the origin; sides hole top bottom right axis.
#[derive(Debug, Clone, PartialEq)]
pub struct TunnelRock {
    /// Radius of the hole.
    pub radius: f64,
    /// Extent along x.
    pub half_width: f64,
    /// Extent along ±y.
    pub half_height: f64,
    /// Cells around and outward.
    pub cells: [usize; 2],
    /// Size of a cell over that of its neighbour before it, outward.
    pub ratio: f64,
    /// The same around, from the springline towards crown and invert.
    pub grade: f64,
    /// Kind of cells.
    pub cell: CellKind,
    /// Cuts, for triangles.
    pub diagonals: Diagonals,
}
