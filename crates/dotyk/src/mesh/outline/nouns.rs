//! What a user says of an outline: its contours, their edges, and how fine the cells are.

use crate::geometry::Point;
use crate::mesh::{CellKind, MeshError};
use std::fmt;

/// Most corners of cells: some hundred megabytes, and a size that was meant in another unit is reported in seconds.
pub(crate) const MOST_VERTICES: usize = 2_000_000;

/// An outline with what is needed to mesh it.
#[derive(Debug, Clone, PartialEq)]
pub struct Outline {
    /// The outer path.
    pub boundary: Contour,
    /// Holes.
    pub holes: Vec<Contour>,
    /// Largest length of cell edges.
    pub size: f64,
    /// How much the size may grow per distance from where it is smaller.
    pub growth: f64,
    /// Places with smaller cells.
    pub refine: Vec<SizePoint>,
    /// Kind of cells: linear or quadratic triangles.
    pub cell: CellKind,
}

/// A closed path.
#[derive(Debug, Clone, PartialEq)]
pub enum Contour {
    /// Edges one after the other.
    Path {
        /// Start of the first edge.
        from: Point<2>,
        /// The edges; the last one ends at `from`.
        edges: Vec<OutlineEdge>,
    },
    /// A circle. Its rightmost, upper, leftmost and lower points are nodes.
    Circle {
        /// Centre.
        center: Point<2>,
        /// Radius.
        radius: f64,
        /// Names of its sides.
        names: Vec<String>,
        /// Its cells; a number must be a multiple of four.
        division: Option<Division>,
    },
}

/// An edge from where the last one ended.
#[derive(Debug, Clone, PartialEq)]
pub struct OutlineEdge {
    /// Its end.
    pub to: Point<2>,
    /// Line or arc.
    pub shape: EdgeShape,
    /// Names of its sides; without, that of its contour.
    pub names: Vec<String>,
    /// Its cells; without, the size of the outline.
    pub division: Option<Division>,
}

/// How an edge runs to its end.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum EdgeShape {
    /// Straight.
    Line,
    /// An arc about a centre.
    Center {
        /// Centre, equally far from both ends.
        center: Point<2>,
        /// Way round, in the direction in which the edge is drawn.
        clockwise: bool,
    },
    /// An arc through a third point.
    Via(Point<2>),
    /// An arc of at most 180°.
    Radius {
        /// Radius.
        radius: f64,
        /// Way round, in the direction in which the edge is drawn.
        clockwise: bool,
    },
}

/// How an edge is divided.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Division {
    /// Into pieces of at most this length, shorter where something near is finer.
    Size(f64),
    /// Into this many equal pieces, whatever is near.
    Cells(usize),
}

/// Smaller cells about a point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SizePoint {
    /// Centre.
    pub at: Point<2>,
    /// Size up to the radius.
    pub size: f64,
    /// Where the size begins to grow.
    pub radius: f64,
}

/// A contour or edge in messages; counted from zero here, from one in the text.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct OutlinePlace {
    /// Which hole; `None` is the outer path.
    pub hole: Option<usize>,
    /// Which edge; `None` is the whole contour.
    pub edge: Option<usize>,
    /// Names of the edge.
    pub names: Vec<String>,
}

impl fmt::Display for OutlinePlace {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match (self.edge, self.hole) {
            (Some(edge), Some(hole)) => write!(f, "edge {} of hole {}", edge + 1, hole + 1)?,
            (Some(edge), None) => write!(f, "edge {}", edge + 1)?,
            (None, Some(hole)) => write!(f, "hole {}", hole + 1)?,
            (None, None) => write!(f, "the outer path")?,
        }
        match &self.names[..] {
            [] => Ok(()),
            names => write!(f, " (`{}`)", names.join("`, `")),
        }
    }
}

impl OutlinePlace {
    /// What is wrong at this place.
    pub(crate) fn error(&self, problem: impl Into<String>) -> MeshError {
        MeshError::Outline {
            place: self.clone(),
            problem: problem.into(),
        }
    }
}

impl OutlineEdge {
    /// A straight edge.
    pub fn line(to: Point<2>) -> Self {
        Self::of(to, EdgeShape::Line)
    }

    /// An edge of any shape.
    pub fn of(to: Point<2>, shape: EdgeShape) -> Self {
        Self {
            to,
            shape,
            names: Vec::new(),
            division: None,
        }
    }

    /// The edge as a part of a side, one more of its sides.
    pub fn named(mut self, name: &str) -> Self {
        self.names.push(name.to_string());
        self
    }

    /// The edge with cells of its own.
    pub fn divided(mut self, division: Division) -> Self {
        self.division = Some(division);
        self
    }
}

impl Contour {
    /// A circle without a name.
    pub fn circle(center: Point<2>, radius: f64) -> Self {
        Self::Circle {
            center,
            radius,
            names: Vec::new(),
            division: None,
        }
    }

    /// Straight edges between corners, without names.
    pub fn polygon(corners: &[Point<2>]) -> Self {
        let first = corners.first().copied();
        let rest = corners.iter().skip(1).copied().chain(first);
        Self::Path {
            from: first.unwrap_or([0.0; 2]),
            edges: rest.map(OutlineEdge::line).collect(),
        }
    }
}

impl Outline {
    /// An outline with cells of one size, linear triangles and growth 0.3.
    pub fn new(boundary: Contour, size: f64) -> Self {
        Self {
            boundary,
            holes: Vec::new(),
            size,
            growth: 0.3,
            refine: Vec::new(),
            cell: CellKind::Tri3,
        }
    }
}
