//! The user's outline or drawing: contours or lines, their edges, and sizes of the cells.

use crate::geometry::Point;
use crate::mesh::{CellKind, MeshError, SizePoint};
use std::fmt;

/// Most corners of cells: some hundred megabytes, so that a size in a wrong unit is reported within seconds.
pub(crate) const MOST_VERTICES: usize = 2_000_000;

/// Growth of sizes per distance, where nothing else is said.
pub(crate) const GROWTH: f64 = 0.3;

/// An outline with the data for its mesh.
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

/// A drawing: lines that may meet, end and cross anywhere, and the regions between them. Bodies are made of regions.
#[derive(Debug, Clone, PartialEq)]
pub struct Drawing {
    /// Lines; a path need not close.
    pub lines: Vec<Contour>,
    /// The filled regions.
    pub regions: Vec<Region>,
    /// Largest length of cell edges.
    pub size: f64,
    /// How much the size may grow per distance from where it is smaller.
    pub growth: f64,
    /// Places with smaller cells.
    pub refine: Vec<SizePoint>,
    /// Kind of cells: linear or quadratic triangles.
    pub cell: CellKind,
}

/// A part of a drawing, or several, that lines surround.
#[derive(Debug, Clone, PartialEq)]
pub struct Region {
    /// Unique name, also of the sides of other bodies beyond which it lies.
    pub name: String,
    /// A point in each of its parts.
    pub at: Vec<Point<2>>,
    /// Its own largest length of cell edges.
    pub size: Option<f64>,
}

/// A closed path, or a line of a drawing.
#[derive(Debug, Clone, PartialEq)]
pub enum Contour {
    /// Edges one after the other.
    Path {
        /// Start of the first edge.
        from: Point<2>,
        /// The edges; the last one of a closed path ends at `from`.
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

/// Shape of an edge.
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

/// Division of an edge.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Division {
    /// Into pieces of at most this length, shorter near finer parts.
    Size(f64),
    /// Into this many equal pieces, regardless of the neighbourhood.
    Cells(usize),
}

/// A part of an outline or drawing in messages; counted from zero here, from one in the text.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum OutlinePart {
    /// The outer path of an outline.
    #[default]
    Outer,
    /// A hole of an outline.
    Hole(usize),
    /// A whole drawing.
    Drawing,
    /// A line of a drawing.
    Line(usize),
    /// A region of a drawing.
    Region(usize),
}

/// A contour, line, region or edge in messages.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct OutlinePlace {
    /// Which contour, line or region.
    pub part: OutlinePart,
    /// Which edge of it; `None` is all of it.
    pub edge: Option<usize>,
    /// Names of the edge.
    pub names: Vec<String>,
}

impl fmt::Display for OutlinePlace {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let Some(edge) = self.edge {
            write!(f, "edge {}", edge + 1)?;
        }
        match (self.edge, self.part) {
            (None, OutlinePart::Outer) => write!(f, "the outer path")?,
            (None, OutlinePart::Drawing) => write!(f, "as a whole")?,
            (Some(_), OutlinePart::Outer | OutlinePart::Drawing) => {}
            (edge, part) => {
                let (what, number) = match part {
                    OutlinePart::Line(line) => ("line", line),
                    OutlinePart::Region(region) => ("region", region),
                    OutlinePart::Hole(hole) => ("hole", hole),
                    OutlinePart::Outer | OutlinePart::Drawing => ("part", 0),
                };
                let of = if edge.is_some() { " of " } else { "" };
                write!(f, "{of}{what} {}", number + 1)?;
            }
        }
        match &self.names[..] {
            [] => Ok(()),
            names => write!(f, " (`{}`)", names.join("`, `")),
        }
    }
}

impl OutlinePlace {
    /// The error at this place.
    pub(crate) fn error(&self, problem: impl Into<String>) -> MeshError {
        let (place, problem) = (self.clone(), problem.into());
        match self.part {
            OutlinePart::Outer | OutlinePart::Hole(_) => MeshError::Outline { place, problem },
            _ => MeshError::Drawing { place, problem },
        }
    }

    /// More nodes than there may be.
    pub(crate) fn too_many(&self) -> MeshError {
        self.error(format!(
            "the sizes ask for more than {MOST_VERTICES} nodes: use larger ones"
        ))
    }

    /// The whole outline or drawing that it is a part of.
    pub(crate) fn whole(&self) -> Self {
        let part = match self.part {
            OutlinePart::Outer | OutlinePart::Hole(_) => OutlinePart::Outer,
            _ => OutlinePart::Drawing,
        };
        Self {
            part,
            ..Self::default()
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
            growth: GROWTH,
            refine: Vec::new(),
            cell: CellKind::Tri3,
        }
    }
}

impl Drawing {
    /// A drawing with cells of one size, linear triangles and growth 0.3, without regions yet.
    pub fn new(lines: Vec<Contour>, size: f64) -> Self {
        Self {
            lines,
            regions: Vec::new(),
            size,
            growth: GROWTH,
            refine: Vec::new(),
            cell: CellKind::Tri3,
        }
    }

    /// The drawing with one more region, by a point in it.
    pub fn region(mut self, name: &str, at: Point<2>) -> Self {
        self.regions.push(Region {
            name: name.to_string(),
            at: vec![at],
            size: None,
        });
        self
    }
}
