//! Structured generators of the plane: rectangle, ring, half plate with a round hole; those of space have their own files.
//!
//! Each is the image of a lattice of nu × nv squares. A quadratic cell has lattice points at its middles, so the
//! lattice has order·n + 1 points in a direction, order·n where it closes on itself. The first lattice direction u and the
//! second v are x and y of a rectangle; outward and around (counter-clockwise) of a ring, so that cells keep their
//! orientation. Point (u, v) of the lattice is the image of one function, whichever the cells are.
//!
//! Angles are in degrees from +x. Around, sizes are symmetric about the middle of the arc (the springline of an arc from
//! −90 to 90) and a cell k places away from it has size ∝ gradeᵏ; outward, cell k has size ∝ ratioᵏ.
//! Invariants: nodes lie on the true circles and exactly on the straight sides, `0` and `from`/`to` are met to the last
//! bit; the outer nodes of a [`Ring`] from −90 to 90 about the origin and the hole nodes of a [`TunnelRock`] of the same
//! radius, `cells[0]` and `grade` are the same numbers.

mod axis;
mod cuboid;
mod disc;
mod divided;
mod layers;
mod solids;
mod tets;

pub use cuboid::Cuboid;
pub use solids::{Cylinder, Extrude, Path, Sphere};

use crate::geometry::{Point, Surface, add_scaled};
use crate::mesh::{CellBlock, CellKind, Domain, Facet, Mesh, MeshError};
use std::collections::BTreeMap;
use std::ops::Range;

/// Most nodes of a mesh: gigabytes in the plane and tens of them in space, long before an index overflows.
const MOST_POINTS: usize = 100_000_000;

/// Smallest cell over the sum of all cells in a direction: below, neighbouring nodes coincide up to rounding.
const LEAST_SHARE: f64 = 1e-10;

/// Diagonals that cut quadrilaterals into triangles.
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
    /// Forward in the second half of the second direction (y, or around a circle), backward in the first: symmetric.
    Mirrored,
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

impl Rectangle {
    /// The mesh, cells of one size.
    ///
    /// Errors: corners that are not finite or not `from` < `to`, no cells, too many cells.
    pub fn build(&self) -> Result<Mesh<2>, MeshError> {
        let lattice = Lattice::new(self.cells, self.cell, self.diagonals, false)?;
        let lines = lines("rectangle", self.from, self.to, self.cells)?;
        let [x, y] = lines.map(|nodes| lattice.with_middles(nodes));
        let mesh = lattice.mesh(
            |u, v| [x[u], y[v]],
            &[
                ("left", vec![lattice.edge(Edge::Left)]),
                ("right", vec![lattice.edge(Edge::Right)]),
                ("bottom", vec![lattice.edge(Edge::Bottom)]),
                ("top", vec![lattice.edge(Edge::Top)]),
            ],
        )?;
        Ok(mesh.made_by(self.clone()))
    }
}

/// Coordinates of the nodes of equal cells along each axis between two corners.
///
/// Errors: corners that are not finite or not `from` < `to`, no cells.
fn lines<const D: usize>(
    generator: &'static str,
    from: Point<D>,
    to: Point<D>,
    cells: [usize; D],
) -> Result<[Vec<f64>; D], MeshError> {
    let wrong = |key, value: String, need| wrong(generator, key, value, need);
    for d in 0..D {
        if !(to[d] - from[d]).is_finite() {
            let value = format!("{from:?}, {to:?}");
            return Err(wrong("from, to", value, "give finite coordinates"));
        }
        if to[d] <= from[d] {
            let need = "must exceed `from` along every axis";
            return Err(wrong("to", format!("{to:?}"), need));
        }
    }
    if cells.contains(&0) {
        return Err(wrong("cells", format!("{cells:?}"), AT_LEAST_ONE));
    }
    Ok(std::array::from_fn(|d| {
        let n = cells[d];
        let nodes = (0..=n).map(|i| between(from[d], to[d], i as f64 / n as f64));
        nodes.collect()
    }))
}

/// Cells that a square of the plane, or a hexahedron of space, is cut into.
pub(crate) fn pieces(cell: CellKind) -> u128 {
    match cell.domain() {
        Domain::Triangle | Domain::Prism => 2,
        Domain::Tetrahedron => 6,
        Domain::Line | Domain::Square | Domain::Cube => 1,
    }
}

/// Errors: more nodes than a mesh may have.
fn within_reach(points: u128) -> Result<(), MeshError> {
    match points > MOST_POINTS as u128 {
        true => Err(MeshError::TooLarge {
            nodes: points,
            most: MOST_POINTS,
        }),
        false => Ok(()),
    }
}

impl Ring {
    /// The mesh; a full ring closes on itself.
    ///
    /// Errors: values that are not finite, radii that are not 0 < `inner` < `outer`, an arc that is not in (0°, 360°],
    /// `ratio` or `grade` not positive or too far from one for so many cells, `grade` on a full ring, no cells or too many,
    /// so few cells that one spans 180°.
    pub fn build(&self) -> Result<Mesh<2>, MeshError> {
        let wrong = |key, value: String, need| wrong("ring", key, value, need);
        let [around, through] = self.cells;
        if !self.center.iter().all(|c| c.is_finite()) {
            let value = format!("{:?}", self.center);
            return Err(wrong("center", value, "give finite coordinates"));
        }
        if !(self.inner > 0.0 && self.inner.is_finite()) {
            let value = self.inner.to_string();
            return Err(wrong("inner", value, "must be positive and finite"));
        }
        if !(self.outer > self.inner && self.outer.is_finite()) {
            let value = self.outer.to_string();
            return Err(wrong("outer", value, "must exceed `inner` and be finite"));
        }
        let [from, to] = self.angles.unwrap_or([0.0, 360.0]);
        let span = to - from;
        if !(span > 0.0 && (span <= 360.0 || is_full(span))) {
            let need = "the arc `to` − `from` must be in (0, 360] degrees";
            return Err(wrong("from, to", format!("{from}, {to}"), need));
        }
        let full = is_full(span);
        if full && self.grade != 1.0 {
            let need = "a full ring has no springline: leave `grade` at 1 or give an arc";
            return Err(wrong("grade", self.grade.to_string(), need));
        }
        if self.cells.contains(&0) {
            return Err(wrong("cells", format!("{:?}", self.cells), AT_LEAST_ONE));
        }
        let lattice = Lattice::new([through, around], self.cell, self.diagonals, full)?;
        let Some(layers) = geometric(through, self.ratio) else {
            return Err(wrong("ratio", self.ratio.to_string(), PROGRESSION));
        };
        let Some(arc) = symmetric(around, self.grade) else {
            return Err(wrong("grade", self.grade.to_string(), PROGRESSION));
        };
        let widest = arc.windows(2).map(|t| t[1] - t[0]).fold(0.0, f64::max);
        if 0.5 * span * widest >= 180.0 {
            let need = "so few cells around that one spans 180 degrees: use more";
            return Err(wrong("cells", format!("{:?}", self.cells), need));
        }
        let radii = layers.iter().map(|&s| between(self.inner, self.outer, s));
        let radii = lattice.with_middles(radii.collect());
        let directions = lattice.directions(0.5 * (from + to), 0.5 * span, &arc);
        let mut sides = vec![
            ("inner", vec![lattice.edge(Edge::Left)]),
            ("outer", vec![lattice.edge(Edge::Right)]),
        ];
        if !full {
            sides.push(("start", vec![lattice.edge(Edge::Bottom)]));
            sides.push(("end", vec![lattice.edge(Edge::Top)]));
        }
        let at = |u: usize, v: usize| add_scaled(self.center, radii[u], directions[v]);
        let circle = |radius: f64| Surface::Sphere {
            center: self.center,
            radius,
        };
        let mesh = lattice.mesh(at, &sides)?;
        let mesh = mesh.with_curve(&["inner"], circle(self.inner));
        let mesh = mesh.with_curve(&["outer"], circle(self.outer));
        Ok(mesh.made_by(self.clone()))
    }
}

impl TunnelRock {
    /// The mesh: straight lines from the nodes of the hole to those of the rectangle, whose corners are nodes.
    ///
    /// The node nearest to the direction of a corner becomes that corner; between, the directions of the outer nodes
    /// follow those of the hole nodes piecewise linearly. With an even number of cells around, the mesh is its own image
    /// in y = 0 to the last bit.
    ///
    /// Errors: values that are not finite, a rectangle that does not contain the hole, fewer than four cells around or
    /// no cell outward, too many cells, `ratio` or `grade` not positive or too far from one for so many cells; a folded cell
    /// where a coarse mesh cannot follow a hole that almost touches the rectangle.
    pub fn build(&self) -> Result<Mesh<2>, MeshError> {
        let wrong = |key, value: String, need| wrong("tunnel_rock", key, value, need);
        let [around, outward] = self.cells;
        if !(self.radius > 0.0 && self.radius.is_finite()) {
            let value = self.radius.to_string();
            return Err(wrong("radius", value, "must be positive and finite"));
        }
        for (key, extent) in [
            ("half_width", self.half_width),
            ("half_height", self.half_height),
        ] {
            if !(extent > self.radius && extent.is_finite()) {
                let need = "must exceed `radius` and be finite";
                return Err(wrong(key, extent.to_string(), need));
            }
        }
        if around < 4 || outward == 0 {
            let need = "use at least four cells around and one outward";
            return Err(wrong("cells", format!("{:?}", self.cells), need));
        }
        let lattice = Lattice::new([outward, around], self.cell, self.diagonals, false)?;
        let Some(layers) = geometric(outward, self.ratio) else {
            return Err(wrong("ratio", self.ratio.to_string(), PROGRESSION));
        };
        let Some(arc) = symmetric(around, self.grade) else {
            return Err(wrong("grade", self.grade.to_string(), PROGRESSION));
        };
        let layers = lattice.with_middles(layers);
        let hole: Vec<Point<2>> = lattice
            .directions(0.0, 90.0, &arc)
            .iter()
            .map(|direction| direction.map(|c| self.radius * c))
            .collect();
        let (outline, corner) = self.outline(&arc);
        let outline = lattice.with_middle_points(outline);
        let (bottom, top) = (0..around - corner, corner..around);
        let circle = Surface::Sphere {
            center: [0.0; 2],
            radius: self.radius,
        };
        let mesh = lattice.mesh(
            |u, v| {
                let s = layers[u];
                std::array::from_fn(|d| hole[v][d] * (1.0 - s) + outline[v][d] * s)
            },
            &[
                ("hole", vec![lattice.edge(Edge::Left)]),
                ("bottom", vec![(Edge::Right, bottom)]),
                ("right", vec![(Edge::Right, around - corner..corner)]),
                ("top", vec![(Edge::Right, top)]),
                (
                    "axis",
                    vec![lattice.edge(Edge::Bottom), lattice.edge(Edge::Top)],
                ),
            ],
        );
        let mesh = mesh?.with_curve(&["hole"], circle);
        Ok(mesh.made_by(self.clone()))
    }

    /// Nodes of the rectangle from (0, −H) to (0, H), and the index of the one at (W, H).
    fn outline(&self, arc: &[f64]) -> (Vec<Point<2>>, usize) {
        let (w, h) = (self.half_width, self.half_height);
        let around = arc.len() - 1;
        let angle = h.atan2(w).to_degrees();
        let away = |index: usize| (90.0 * arc[index] - angle).abs();
        let upper = around / 2 + 1..around;
        let corner = upper
            .min_by(|&a, &b| away(a).total_cmp(&away(b)))
            .unwrap_or(around - 1);
        let share = arc[corner];
        let upper_point = |index: usize| -> Point<2> {
            if index == corner {
                [w, h]
            } else if index < corner {
                let phi = angle * arc[index] / share;
                [w, w * phi.to_radians().tan()]
            } else {
                let from_axis = (90.0 - angle) * (1.0 - arc[index]) / (1.0 - share);
                [h * from_axis.to_radians().tan(), h]
            }
        };
        // The lower half mirrors the upper one.
        let outline = (0..=around).map(|index| {
            let [x, y] = upper_point(index.max(around - index));
            if 2 * index < around { [x, -y] } else { [x, y] }
        });
        (outline.collect(), corner)
    }
}

/// A span of 360° but for the rounding of its ends.
fn is_full(span: f64) -> bool {
    (span - 360.0).abs() <= 1e-9
}

const AT_LEAST_ONE: &str = "use at least one cell along each direction";
const PROGRESSION: &str =
    "must be positive, and so near to one that the smallest cell keeps 1e-10 of the length";

fn wrong(
    generator: &'static str,
    key: &'static str,
    value: String,
    need: &'static str,
) -> MeshError {
    MeshError::Parameter {
        generator,
        key,
        value,
        need,
    }
}

/// The point at the share s between two numbers, both ends exactly.
fn between(from: f64, to: f64, s: f64) -> f64 {
    if s == 1.0 { to } else { from + (to - from) * s }
}

/// Ends of n intervals of [0, 1] with sizes ∝ ratioᵏ; `None` if the points are not distinct.
fn geometric(n: usize, ratio: f64) -> Option<Vec<f64>> {
    cumulated(None, ratio, 0..n)
}

/// Ends of n intervals of [−1, 1], symmetric to the last bit, with sizes ∝ gradeᵏ, k places away from the middle.
fn symmetric(n: usize, grade: f64) -> Option<Vec<f64>> {
    let half = match n % 2 {
        0 => cumulated(None, grade, 0..n / 2)?,
        _ => cumulated(Some(0.5), grade, 1..n / 2 + 1)?,
    };
    // The middle, where there is a node, belongs to the lower half and is +0.
    let lower = half.iter().rev().map(|t| 0.0 - t);
    let upper = half.iter().skip(1 - n % 2).copied();
    Some(lower.chain(upper).collect())
}

/// Sums of the first sizes baseᵏ, after that of a first interval that is not listed, over the sum of all.
fn cumulated(first: Option<f64>, base: f64, powers: Range<usize>) -> Option<Vec<f64>> {
    let mut sums = vec![first.unwrap_or(0.0)];
    let mut smallest = first.unwrap_or(f64::INFINITY);
    for k in powers {
        let size = base.powi(i32::try_from(k).unwrap_or(i32::MAX));
        smallest = smallest.min(size);
        sums.push(sums[sums.len() - 1] + size);
    }
    let total = sums[sums.len() - 1];
    let distinct = base > 0.0 && total.is_finite() && smallest >= LEAST_SHARE * total;
    distinct.then(|| sums.iter().map(|sum| sum / total).collect())
}

/// (cos, sin) of an angle in degrees: exact at multiples of 90°, mirrored exactly at the axes.
fn direction(degrees: f64) -> Point<2> {
    let quarter = (degrees / 90.0).round();
    let (sin, cos) = (degrees - 90.0 * quarter).to_radians().sin_cos();
    match quarter.rem_euclid(4.0) as u8 {
        0 => [cos, sin],
        1 => [-sin, cos],
        2 => [-cos, -sin],
        _ => [sin, -cos],
    }
}

/// An edge of the lattice or of one of its squares.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Edge {
    Bottom,
    Right,
    Top,
    Left,
}

/// Consecutive squares along an edge of the lattice.
type Piece = (Edge, Range<usize>);

/// The cut of one square of 3 × 3 places, numbered row by row from the lower left, into cells.
struct Cut {
    /// Places of the nodes of each cell, in the numbering of the quadratic kind.
    cells: &'static [&'static [usize]],
    /// Cell of the cut and local facet at the bottom, right, top and left.
    edges: [[u32; 2]; 4],
}

static WHOLE: Cut = Cut {
    cells: &[&[0, 2, 8, 6, 1, 5, 7, 3, 4]],
    edges: [[0, 0], [0, 1], [0, 2], [0, 3]],
};
static FORWARD: Cut = Cut {
    cells: &[&[0, 2, 8, 1, 5, 4], &[0, 8, 6, 4, 7, 3]],
    edges: [[0, 0], [0, 1], [1, 1], [1, 2]],
};
static BACKWARD: Cut = Cut {
    cells: &[&[0, 2, 6, 1, 4, 3], &[2, 8, 6, 5, 7, 4]],
    edges: [[0, 0], [1, 0], [1, 1], [0, 2]],
};

/// nu × nv squares, cut into cells of one kind.
struct Lattice {
    squares: [usize; 2],
    cell: CellKind,
    diagonals: Diagonals,
    /// The second direction closes on itself.
    closed: bool,
}

impl Lattice {
    fn new(
        squares: [usize; 2],
        cell: CellKind,
        diagonals: Diagonals,
        closed: bool,
    ) -> Result<Self, MeshError> {
        let points = squares
            .map(|n| n as u128 * cell.order() as u128 + 1)
            .into_iter()
            .fold(1, u128::saturating_mul);
        within_reach(points)?;
        if cell.dimension() != 2 {
            return Err(MeshError::Dimension {
                block: 0,
                kind: cell.name(),
                dimension: 2,
            });
        }
        Ok(Self {
            squares,
            cell,
            diagonals,
            closed,
        })
    }

    /// Lattice points along u and v.
    fn size(&self) -> [usize; 2] {
        let [nu, nv] = self.squares.map(|n| n * self.cell.order());
        [nu + 1, if self.closed { nv } else { nv + 1 }]
    }

    /// The coordinates at the lattice points, from those at the ends of the intervals.
    fn with_middles(&self, ends: Vec<f64>) -> Vec<f64> {
        let points = ends.into_iter().map(|end| [end]).collect();
        self.with_middle_points(points).concat()
    }

    fn with_middle_points<const D: usize>(&self, ends: Vec<Point<D>>) -> Vec<Point<D>> {
        if self.cell.order() == 1 {
            return ends;
        }
        let mut all = Vec::with_capacity(2 * ends.len());
        for pair in ends.windows(2) {
            all.push(pair[0]);
            all.push(std::array::from_fn(|d| 0.5 * (pair[0][d] + pair[1][d])));
        }
        all.extend(ends.last());
        all
    }

    /// Unit vectors at the lattice points of an arc, from the ends of its intervals in [−1, 1].
    fn directions(&self, middle: f64, half_span: f64, arc: &[f64]) -> Vec<Point<2>> {
        let angles = arc.iter().map(|t| middle + half_span * t).collect();
        let angles = self.with_middles(angles);
        angles.into_iter().map(direction).collect()
    }

    /// A whole edge of the lattice.
    fn edge(&self, edge: Edge) -> Piece {
        match edge {
            Edge::Bottom | Edge::Top => (edge, 0..self.squares[0]),
            Edge::Left | Edge::Right => (edge, 0..self.squares[1]),
        }
    }

    fn cut(&self, i: usize, j: usize) -> &'static Cut {
        if self.cell.corners() == 4 {
            return &WHOLE;
        }
        let forward = match self.diagonals {
            Diagonals::Forward => true,
            Diagonals::Backward => false,
            Diagonals::Mirrored => 2 * j >= self.squares[1],
            Diagonals::Checkerboard => (i + j).is_multiple_of(2),
            Diagonals::CheckerboardOdd => !(i + j).is_multiple_of(2),
        };
        if forward { &FORWARD } else { &BACKWARD }
    }

    /// The mesh of the points that some cell uses, with sides as pieces of the edges of the lattice.
    fn mesh(
        &self,
        point: impl Fn(usize, usize) -> Point<2>,
        sides: &[(&str, Vec<Piece>)],
    ) -> Result<Mesh<2>, MeshError> {
        let (points, numbers) = self.points(point);
        let nodes = self.nodes(&numbers);
        let block = CellBlock {
            kind: self.cell,
            nodes,
            group: None,
        };
        let sides = sides
            .iter()
            .map(|(name, pieces)| (name.to_string(), self.facets(pieces)))
            .collect();
        Mesh::assembled(points, vec![block], sides, BTreeMap::new())
    }

    /// Points in the order of the lattice, u fastest, and the number of each lattice point; the serendipity cell
    /// leaves out the centres of the squares.
    fn points(&self, point: impl Fn(usize, usize) -> Point<2>) -> (Vec<Point<2>>, Vec<u32>) {
        let [nu, nv] = self.size();
        let mut points = Vec::with_capacity(nu * nv);
        let mut numbers = Vec::with_capacity(nu * nv);
        for v in 0..nv {
            for u in 0..nu {
                numbers.push(points.len() as u32);
                let centre = u % 2 == 1 && v % 2 == 1;
                if !(self.cell == CellKind::Quad8 && centre) {
                    points.push(point(u, v));
                }
            }
        }
        (points, numbers)
    }

    /// Node indices of all cells, square after square, u fastest.
    fn nodes(&self, numbers: &[u32]) -> Vec<u32> {
        let [nu, nv] = self.size();
        let order = self.cell.order();
        let mut nodes = Vec::new();
        for j in 0..self.squares[1] {
            for i in 0..self.squares[0] {
                for cell in self.cut(i, j).cells {
                    nodes.extend(cell[..self.cell.nodes()].iter().map(|place| {
                        // A linear cell uses the corner places only, which are two apart.
                        let u = order * i + place % 3 * order / 2;
                        let v = (order * j + place / 3 * order / 2) % nv;
                        numbers[v * nu + u]
                    }));
                }
            }
        }
        nodes
    }

    /// The facets along pieces of the edges of the lattice.
    fn facets(&self, pieces: &[Piece]) -> Vec<Facet> {
        let [nu, nv] = self.squares;
        let mut facets = Vec::new();
        for (edge, range) in pieces {
            for k in range.clone() {
                let (i, j) = match edge {
                    Edge::Bottom => (k, 0),
                    Edge::Top => (k, nv - 1),
                    Edge::Left => (0, k),
                    Edge::Right => (nu - 1, k),
                };
                let cut = self.cut(i, j);
                let [cell, local] = cut.edges[*edge as usize];
                facets.push(Facet {
                    block: 0,
                    cell: ((j * nu + i) * cut.cells.len()) as u32 + cell,
                    local,
                });
            }
        }
        facets
    }
}
