//! Triangles of good shape inside an outline of straight lines and circular arcs, with holes and named edges.
//!
//! The outer path and the holes are closed and do not touch; which way round they are drawn does not matter. Edges of one
//! name form one side. Edges without a name form the side `outline`, those of hole k the side `hole_k`, so that
//! every facet of the boundary is in exactly one side.
//!
//! Sizes are lengths of cell edges. The size of the outline holds everywhere, that of an edge along it, that of a point of
//! refinement around it; from each, the wanted size grows by `growth` per distance. Where two edges that do not share a
//! corner come nearer through the body than the size, the size is their distance; a piece of an arc spans at most 30°.
//! Nodes of the boundary lie on the true lines and arcs, for quadratic cells the middle nodes, too; facets on arcs know them.
//!
//! **Matching nodes.** An edge is divided from its own data in a direction-independent way. The same edge of two
//! outlines has the same nodes when both give the same number of cells, or the same size and nothing near that wants
//! finer cells.
//!
//! Angles: at least 25° where the corners of the outline are at least 60° and neighbouring edges do not prescribe numbers of
//! cells that differ wildly; 30° or more is usual. The boundary is never divided further to raise an angle.

mod curve;
mod divide;
mod fill;

use crate::geometry::{Point, Surface, add_scaled, bounding_box, distance, sub, unit};
use crate::mesh::outline::curve::{Curve, cross};
use crate::mesh::outline::divide::{Rib, Sizes, divide};
use crate::mesh::outline::fill::{Boundary, Filled, Unfilled, fill};
use crate::mesh::{CellBlock, CellKind, Facet, Mesh, MeshError};
use std::collections::BTreeMap;
use std::f64::consts::{FRAC_PI_2, TAU};
use std::fmt;

/// Most corners of cells: some hundred megabytes, and a size that was meant in another unit is reported in seconds.
pub(crate) const MOST_VERTICES: usize = 2_000_000;

/// Below this share of the diameter two points are one.
const SAME: f64 = 1e-9;

/// How much the two radii of an arc that is given by its centre may differ, relatively.
const SAME_RADIUS: f64 = 1e-6;

/// Magnitudes of coordinates and diameters whose squares are still numbers.
const MAGNITUDES: [f64; 2] = [1e-100, 1e100];

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
        /// Name of its side.
        name: Option<String>,
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
    /// Name of its side.
    pub name: Option<String>,
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
    /// Name of the edge.
    pub name: Option<String>,
}

impl fmt::Display for OutlinePlace {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match (self.edge, self.hole) {
            (Some(edge), Some(hole)) => write!(f, "edge {} of hole {}", edge + 1, hole + 1)?,
            (Some(edge), None) => write!(f, "edge {}", edge + 1)?,
            (None, Some(hole)) => write!(f, "hole {}", hole + 1)?,
            (None, None) => write!(f, "the outer path")?,
        }
        match &self.name {
            Some(name) => write!(f, " (`{name}`)"),
            None => Ok(()),
        }
    }
}

impl OutlinePlace {
    fn error(&self, problem: impl Into<String>) -> MeshError {
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
            name: None,
            division: None,
        }
    }

    /// The edge as a part of a side.
    pub fn named(mut self, name: &str) -> Self {
        self.name = Some(name.to_string());
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
            name: None,
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

/// A curve of a contour, before it is known which ones meet.
struct Drawn {
    curve: Curve,
    place: OutlinePlace,
    name: Option<String>,
    division: Option<Division>,
}

/// All curves of all contours, each contour with the body on the left.
struct Drawing {
    ribs: Vec<Rib>,
    places: Vec<OutlinePlace>,
    sides: Vec<String>,
    /// Of the outer path less the holes.
    area: f64,
}

/// A piece of the boundary: one edge of a cell.
struct Edge<'a> {
    side: &'a str,
    /// The circle that it is a part of.
    circle: Option<Surface<2>>,
    /// Its middle on the true curve.
    middle: Point<2>,
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

    /// The mesh: nodes of the boundary first, path after path.
    ///
    /// Errors, each naming the edge: coordinates that are not finite; edges of no length, that do not close, cross or touch;
    /// arcs that do not exist; a hole outside or in another one; sizes that are not positive or exceed the outline; a kind of
    /// cell that is no triangle; more than two million corners of cells.
    pub fn build(&self) -> Result<Mesh<2>, MeshError> {
        self.check_values()?;
        let drawing = self.drawing()?;
        let wanted = self.expected(&drawing);
        if wanted > MOST_VERTICES as f64 {
            return Err(MeshError::TooLarge {
                nodes: wanted.min(u64::MAX as f64) as u128,
                most: MOST_VERTICES,
            });
        }
        let sizes = Sizes {
            largest: self.size,
            growth: self.growth,
            refine: &self.refine,
        };
        let Some(divided) = divide(&drawing.ribs, &sizes) else {
            return Err(too_many());
        };
        let (boundary, ribs, middles) = self.pieces(&drawing, &divided);
        let filled = fill(&boundary, &sizes).map_err(|unfilled| match unfilled {
            Unfilled::TooMany => too_many(),
            Unfilled::Meet(a, b) => {
                let place = |piece: usize| ribs.get(piece).map(|&rib| &drawing.places[rib]);
                let here = place(a).or(place(b)).cloned().unwrap_or_default();
                let there = place(b).cloned().unwrap_or_default();
                here.error(format!(
                    "its cell edges meet those of {there}: give both smaller sizes or more cells"
                ))
            }
        })?;
        let edges: Vec<Edge<'_>> = ribs
            .iter()
            .zip(&middles)
            .map(|(&rib, &middle)| Edge {
                side: &drawing.sides[rib],
                circle: drawing.ribs[rib].curve.circle(),
                middle,
            })
            .collect();
        self.mesh(filled, &boundary.pieces, &edges)
    }

    /// About the number of corners of cells that the sizes of the outline and of the points of refinement ask for at least.
    fn expected(&self, drawing: &Drawing) -> f64 {
        // Each corner of equilateral triangles has √3/2 h² of the area.
        let corners = |area: f64, size: f64| 2.0 / 3.0_f64.sqrt() * area / (size * size);
        let within = |p: Point<2>| {
            let turns: f64 = drawing.ribs.iter().map(|rib| rib.curve.winding(p)).sum();
            turns > 0.5 * TAU
        };
        // A share of each disc of refinement, by the middles of 20 × 20 squares.
        let of_disc = |point: &SizePoint| {
            let step = point.radius / 10.0;
            let places = (0..400).map(|k| [k % 20, k / 20].map(|i| (f64::from(i) - 9.5) * step));
            let inside = places.filter(|&d| {
                d[0].hypot(d[1]) < point.radius && within(add_scaled(point.at, 1.0, d))
            });
            corners(
                inside.count() as f64 * step * step,
                point.size.min(self.size),
            )
        };
        let discs = self.refine.iter().map(of_disc).fold(0.0, f64::max);
        corners(drawing.area, self.size).max(discs)
    }

    fn check_values(&self) -> Result<(), MeshError> {
        let wrong = |key, value: String, need| MeshError::Parameter {
            generator: "outline",
            key,
            value,
            need,
        };
        if !matches!(self.cell, CellKind::Tri3 | CellKind::Tri6) {
            let need = "an outline is filled with `tri3` or `tri6`";
            return Err(wrong("cell", self.cell.name().to_string(), need));
        }
        if !(self.size > 0.0 && self.size.is_finite()) {
            let need = "must be positive and finite";
            return Err(wrong("size", self.size.to_string(), need));
        }
        if !(self.growth > 0.0 && self.growth <= 1.0) {
            let need = "must be positive and at most 1: 0.3 lets neighbours differ by a third";
            return Err(wrong("growth", self.growth.to_string(), need));
        }
        for point in &self.refine {
            if !(point.size > 0.0 && point.size.is_finite()) {
                let need = "the size at a point must be positive and finite";
                return Err(wrong("refine", point.size.to_string(), need));
            }
            let finite = point.at.iter().all(|c| c.is_finite());
            if !(finite && point.radius >= 0.0 && point.radius.is_finite()) {
                let value = format!("{:?}, radius {}", point.at, point.radius);
                let need = "must have finite coordinates and a radius that is not negative";
                return Err(wrong("refine", value, need));
            }
        }
        Ok(())
    }

    /// The contours as curves, checked and turned.
    fn drawing(&self) -> Result<Drawing, MeshError> {
        let contours = std::iter::once((None, &self.boundary));
        let contours = contours.chain((0..).map(Some).zip(&self.holes));
        let mut paths = Vec::new();
        for (hole, contour) in contours {
            paths.push(contour.curves(hole)?);
        }
        let corners: Vec<Point<2>> = paths
            .iter()
            .flatten()
            .flat_map(|drawn| <[Point<2>; 2]>::from(drawn.curve.bounds()))
            .collect();
        let (low, high) = bounding_box(&corners);
        let diameter = distance(low, high);
        for drawn in paths.iter().flatten() {
            self.check_division(drawn, diameter)?;
        }
        separate(&paths, diameter)?;
        let mut drawing = Drawing {
            ribs: Vec::new(),
            places: Vec::new(),
            sides: Vec::new(),
            area: 0.0,
        };
        for (index, path) in paths.iter().enumerate() {
            let twice: f64 = path.iter().map(|d| d.curve.twice_area(low)).sum();
            let area = 0.5 * twice.abs();
            if area <= SAME * diameter * diameter {
                return Err(contour_place(path).error("it encloses no area"));
            }
            drawing.area += if index == 0 { area } else { -area };
            self.add_path(path, (twice > 0.0) != (index == 0), index, &mut drawing);
        }
        nested(&paths)?;
        Ok(drawing)
    }

    fn check_division(&self, drawn: &Drawn, diameter: f64) -> Result<(), MeshError> {
        let size = match drawn.division {
            Some(Division::Size(size)) => size,
            None => self.size,
            Some(Division::Cells(cells)) => {
                let sweep = drawn.curve.arc.map_or(0.0, |arc| arc.sweep.abs());
                if cells == 0 || cells > MOST_VERTICES {
                    let problem = format!("it cannot have {cells} cells");
                    return Err(drawn.place.error(problem));
                }
                // A quarter of a circle may have one cell, whatever rounding says.
                if sweep > FRAC_PI_2 * (cells as f64 + SAME) {
                    let problem = format!(
                        "with {cells} cells, one spans {:.0} degrees: use more, at most 90 degrees each",
                        (sweep / cells as f64).to_degrees()
                    );
                    return Err(drawn.place.error(problem));
                }
                return Ok(());
            }
        };
        if !(size > 0.0 && size.is_finite()) {
            let problem = format!("the size {size} must be positive and finite");
            return Err(drawn.place.error(problem));
        }
        if size > self.size {
            let problem = format!(
                "the size {size} exceeds that of the whole outline, {}: leave it out or make it smaller",
                self.size
            );
            return Err(drawn.place.error(problem));
        }
        if size > diameter {
            let problem = format!(
                "the size {size} exceeds the whole outline, which is {diameter} across: check the units"
            );
            return Err(drawn.place.error(problem));
        }
        Ok(())
    }

    fn add_path(&self, path: &[Drawn], turn: bool, index: usize, drawing: &mut Drawing) {
        let first = drawing.ribs.len();
        let count = path.len();
        for k in 0..count {
            let drawn = &path[if turn { count - 1 - k } else { k }];
            let (size, pieces) = match drawn.division {
                Some(Division::Size(size)) => (size, None),
                Some(Division::Cells(cells)) => (self.size, Some(cells)),
                None => (self.size, None),
            };
            drawing.ribs.push(Rib {
                curve: match turn {
                    true => drawn.curve.reversed(),
                    false => drawn.curve,
                },
                size,
                pieces,
                path: index,
                next: first + (k + 1) % count,
                previous: first + (k + count - 1) % count,
            });
            let side = drawn
                .name
                .clone()
                .unwrap_or_else(|| match drawn.place.hole {
                    Some(hole) => format!("hole_{}", hole + 1),
                    None => "outline".to_string(),
                });
            drawing.sides.push(side);
            drawing.places.push(drawn.place.clone());
        }
    }

    /// The pieces of all edges, the edge that each belongs to, and their middles.
    fn pieces(
        &self,
        drawing: &Drawing,
        divided: &[divide::Divided],
    ) -> (Boundary, Vec<usize>, Vec<Point<2>>) {
        let mut boundary = Boundary {
            nodes: Vec::new(),
            pieces: Vec::new(),
            sizes: Vec::new(),
            most: MOST_VERTICES,
        };
        let (mut owners, mut middles) = (Vec::new(), Vec::new());
        let mut start = 0;
        for (index, (rib, parts)) in drawing.ribs.iter().zip(divided).enumerate() {
            if index > 0 && rib.path != drawing.ribs[index - 1].path {
                start = boundary.nodes.len();
            }
            for k in 1..parts.nodes.len() {
                let node = boundary.nodes.len() as u32;
                let last = rib.next <= index && k + 1 == parts.nodes.len();
                let next = if last { start as u32 } else { node + 1 };
                boundary.nodes.push(parts.nodes[k - 1]);
                boundary.pieces.push([node, next]);
                owners.push(index);
            }
            middles.extend(&parts.middles);
        }
        let lengths = boundary.pieces.iter().map(|piece| {
            let [a, b] = piece.map(|node| boundary.nodes[node as usize]);
            distance(a, b)
        });
        let mut sums = vec![0.0; boundary.nodes.len()];
        for (piece, length) in boundary.pieces.iter().zip(lengths) {
            for &node in piece {
                sums[node as usize] += 0.5 * length;
            }
        }
        boundary.sizes = sums.into_iter().map(|s| s.min(self.size)).collect();
        (boundary, owners, middles)
    }

    fn mesh(
        &self,
        filled: Filled,
        pieces: &[[u32; 2]],
        edges: &[Edge<'_>],
    ) -> Result<Mesh<2>, MeshError> {
        let Filled {
            nodes: mut points,
            triangles,
        } = filled;
        // A piece begins at the node of its own number.
        let piece = |from: u32, to: u32| {
            let found = pieces.get(from as usize);
            found.filter(|p| p[1] == to).map(|p| p[0] as usize)
        };
        let mut sides: BTreeMap<String, Vec<Facet>> = BTreeMap::new();
        let mut curves = BTreeMap::new();
        let mut between = BTreeMap::new();
        let mut nodes = Vec::with_capacity(triangles.len() * self.cell.nodes());
        for (cell, corners) in triangles.iter().enumerate() {
            nodes.extend(corners);
            for local in 0..3 {
                let (from, to) = (corners[local], corners[(local + 1) % 3]);
                let on_boundary = piece(from, to);
                if let Some(piece) = on_boundary {
                    let facet = Facet {
                        block: 0,
                        cell: cell as u32,
                        local: local as u32,
                    };
                    let edge = &edges[piece];
                    sides.entry(edge.side.to_string()).or_default().push(facet);
                    curves.extend(edge.circle.map(|circle| (facet, circle)));
                }
                if self.cell == CellKind::Tri6 {
                    let ends = [from, to].map(|node| points[node as usize]);
                    let straight = [0, 1].map(|d| 0.5 * (ends[0][d] + ends[1][d]));
                    let node = *between
                        .entry((from.min(to), from.max(to)))
                        .or_insert_with(|| {
                            points.push(on_boundary.map_or(straight, |piece| edges[piece].middle));
                            points.len() as u32 - 1
                        });
                    nodes.push(node);
                }
            }
        }
        let block = CellBlock {
            kind: self.cell,
            nodes,
            group: None,
        };
        let mesh = Mesh::new(points, vec![block])?.with_sides(sides)?;
        Ok(mesh.with_curves(curves))
    }
}

impl Contour {
    /// The curves in the order of the user.
    fn curves(&self, hole: Option<usize>) -> Result<Vec<Drawn>, MeshError> {
        match self {
            Self::Path { from, edges } => path_curves(*from, edges, hole),
            Self::Circle {
                center,
                radius,
                name,
                division,
            } => {
                let place = OutlinePlace {
                    hole,
                    edge: None,
                    name: name.clone(),
                };
                check_points(&place, center)?;
                if !(*radius > 0.0 && *radius < MAGNITUDES[1]) {
                    let problem = format!("the radius {radius} must be positive and finite");
                    return Err(place.error(problem));
                }
                let quarter = match division {
                    Some(Division::Cells(cells)) if !cells.is_multiple_of(4) => {
                        let problem = format!(
                            "{cells} cells: a circle has a multiple of four, so that its outermost points are nodes"
                        );
                        return Err(place.error(problem));
                    }
                    Some(Division::Cells(cells)) => Some(Division::Cells(cells / 4)),
                    other => *other,
                };
                let quarters = Curve::quarters(*center, *radius).map(|curve| Drawn {
                    curve,
                    place: place.clone(),
                    name: name.clone(),
                    division: quarter,
                });
                Ok(quarters.into())
            }
        }
    }
}

fn path_curves(
    from: Point<2>,
    edges: &[OutlineEdge],
    hole: Option<usize>,
) -> Result<Vec<Drawn>, MeshError> {
    let place = |edge: usize| OutlinePlace {
        hole,
        edge: Some(edge),
        name: edges.get(edge).and_then(|e| e.name.clone()),
    };
    let whole = OutlinePlace {
        hole,
        ..OutlinePlace::default()
    };
    check_points(&whole, &from)?;
    for (index, edge) in edges.iter().enumerate() {
        check_points(&place(index), &edge.to)?;
    }
    let ends: Vec<Point<2>> = edges.iter().map(|edge| edge.to).chain([from]).collect();
    let (low, high) = bounding_box(&ends);
    let diameter = distance(low, high);
    let Some(last) = edges.last() else {
        return Err(whole.error("it has no edges"));
    };
    if distance(last.to, from) > SAME * diameter {
        let problem = format!(
            "it ends at {:?}, but the path begins at {from:?}: let the last edge end there",
            last.to
        );
        return Err(place(edges.len() - 1).error(problem));
    }
    let mut start = from;
    let mut curves = Vec::with_capacity(edges.len());
    for (index, edge) in edges.iter().enumerate() {
        // To the bit, so that the last node is the first.
        let end = if index + 1 == edges.len() {
            from
        } else {
            edge.to
        };
        let place = place(index);
        if distance(start, end) <= SAME * diameter {
            let problem = format!(
                "it begins and ends at {end:?}: remove it, or use `circle` for a whole circle"
            );
            return Err(place.error(problem));
        }
        curves.push(Drawn {
            curve: shaped(start, end, edge.shape, &place)?,
            place,
            name: edge.name.clone(),
            division: edge.division,
        });
        start = end;
    }
    Ok(curves)
}

fn check_points(place: &OutlinePlace, point: &Point<2>) -> Result<(), MeshError> {
    // Squares of what passes are numbers.
    if point.iter().all(|c| c.abs() < MAGNITUDES[1]) {
        return Ok(());
    }
    Err(place.error(format!("the coordinates {point:?} are not finite")))
}

/// The curve of an edge.
fn shaped(
    start: Point<2>,
    end: Point<2>,
    shape: EdgeShape,
    place: &OutlinePlace,
) -> Result<Curve, MeshError> {
    let chord = sub(end, start);
    let length = distance(start, end);
    match shape {
        EdgeShape::Line => Ok(Curve::line(start, end)),
        EdgeShape::Center { center, clockwise } => {
            check_points(place, &center)?;
            let radii = [distance(start, center), distance(end, center)];
            let [least, most] = [radii[0].min(radii[1]), radii[0].max(radii[1])];
            if most - least > SAME_RADIUS * most || 2.0 * most < length {
                return Err(place.error(format!(
                    "its start is {} away from the center {center:?} and its end {}: they must be equal; correct one of them, or give `radius` or `via` instead",
                    radii[0], radii[1]
                )));
            }
            Ok(Curve::arc(start, end, center, clockwise))
        }
        EdgeShape::Via(via) => {
            check_points(place, &via)?;
            let side = cross(chord, sub(via, start));
            // The height of the arc over its chord: below this the arc is a line but for rounding.
            if side.abs() <= SAME * length * (length + distance(start, via)) {
                return Err(place.error(format!(
                    "the point {via:?} of `via` lies on the line through both ends: leave it out, or choose a point on the arc"
                )));
            }
            let (u, v) = (sub(via, start), chord);
            let (uu, vv) = (u[0] * u[0] + u[1] * u[1], v[0] * v[0] + v[1] * v[1]);
            let twice = 2.0 * cross(u, v);
            let center = [
                start[0] + (v[1] * uu - u[1] * vv) / twice,
                start[1] + (u[0] * vv - v[0] * uu) / twice,
            ];
            Ok(Curve::arc(start, end, center, side > 0.0))
        }
        EdgeShape::Radius { radius, clockwise } => {
            if !(radius > 0.0 && radius < MAGNITUDES[1]) {
                return Err(place.error(format!("the radius {radius} must be positive and finite")));
            }
            if length > 2.0 * radius * (1.0 + SAME) {
                return Err(place.error(format!(
                    "its ends are {length} apart, more than twice the radius {radius}: use a larger radius"
                )));
            }
            let height = (radius * radius - 0.25 * length * length).max(0.0).sqrt();
            let [x, y] = unit(chord).unwrap_or([0.0; 2]);
            let middle = add_scaled(start, 0.5, chord);
            let left = if clockwise { [y, -x] } else { [-y, x] };
            let center = add_scaled(middle, height, left);
            Ok(Curve::arc(start, end, center, clockwise))
        }
    }
}

fn contour_place(path: &[Drawn]) -> OutlinePlace {
    OutlinePlace {
        hole: path.first().and_then(|drawn| drawn.place.hole),
        ..OutlinePlace::default()
    }
}

/// Refuses curves that cross or touch elsewhere than at their common corners.
fn separate(paths: &[Vec<Drawn>], diameter: f64) -> Result<(), MeshError> {
    if !(MAGNITUDES[0]..MAGNITUDES[1]).contains(&diameter) {
        let problem = format!("the outline is {diameter} across: use other units");
        return Err(OutlinePlace::default().error(problem));
    }
    // Path, place in the path, curve, box.
    let all: Vec<(usize, usize, &Drawn)> = paths
        .iter()
        .enumerate()
        .flat_map(|(p, path)| path.iter().enumerate().map(move |(k, drawn)| (p, k, drawn)))
        .collect();
    let boxes: Vec<_> = all.iter().map(|(_, _, d)| d.curve.bounds()).collect();
    let near = SAME * diameter;
    for (i, &(path, k, a)) in all.iter().enumerate() {
        for (j, &(other, l, b)) in all.iter().enumerate().skip(i + 1) {
            let apart = |d: usize| {
                boxes[i].1[d] + near < boxes[j].0[d] || boxes[j].1[d] + near < boxes[i].0[d]
            };
            if apart(0) || apart(1) {
                continue;
            }
            let count = paths[path].len();
            let mut corners = Vec::new();
            if path == other && (k + 1) % count == l {
                corners.push(a.curve.end);
            }
            if path == other && (l + 1) % count == k {
                corners.push(b.curve.end);
            }
            // What happens within a thousandth of an edge from a corner is rounding of a tangent arc.
            let margin = 1e-3 * a.curve.length().min(b.curve.length());
            let approach = a.curve.approach(&b.curve, &corners, margin);
            if let Some((gap, at)) = approach.filter(|(gap, _)| *gap <= near) {
                let rounding = 64.0 * f64::EPSILON * diameter;
                let how = if gap > rounding { "touches" } else { "meets" };
                let problem = format!(
                    "it {how} {} near {at:?}: edges may meet at their common corners only",
                    b.place
                );
                return Err(a.place.error(problem));
            }
        }
    }
    Ok(())
}

/// Refuses holes that are not inside the outer path or inside another hole.
fn nested(paths: &[Vec<Drawn>]) -> Result<(), MeshError> {
    let inside = |p: Point<2>, path: &[Drawn]| {
        let turns: f64 = path.iter().map(|drawn| drawn.curve.winding(p)).sum();
        turns.abs() > 0.5 * TAU
    };
    let starts: Vec<Point<2>> = paths.iter().map(|path| path[0].curve.start).collect();
    for (hole, &start) in starts.iter().enumerate().skip(1) {
        let place = contour_place(&paths[hole]);
        if !inside(start, &paths[0]) {
            return Err(place.error("it lies outside of the outer path"));
        }
        for (other, path) in paths.iter().enumerate().skip(1) {
            if other != hole && inside(start, path) {
                let problem = format!("it lies inside of {}: remove it", contour_place(path));
                return Err(place.error(problem));
            }
        }
    }
    Ok(())
}

fn too_many() -> MeshError {
    OutlinePlace::default().error(format!(
        "the sizes ask for more than {MOST_VERTICES} nodes: use larger ones"
    ))
}
