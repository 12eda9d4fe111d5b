//! Surfaces of bodies as pictures need them: facets divided into triangles, edges of cells and edges of features.
//!
//! A facet is the image of its reference cell under its shape functions, x(ξ) = Σ Nᵢ(ξ) xᵢ; a lattice of reference points
//! divides it, finer where it is curved or large on paper. Normals are ∂x/∂ξ × ∂x/∂η, values Σ Nᵢ vᵢ. An edge is one of a
//! feature where the normals of its facets differ by more than [`SHARP`], or where it has not two facets.

use crate::geometry::{Point, cross, distance, dot, unit};
use crate::mesh::{CellKind, Domain, Facet, MAX_FACET_NODES, Mesh};
use crate::model::Borders;
use crate::output::space::camera::Window;
use crate::output::space::canvas::{Canvas, Corner, NONE, Paint, between};
use std::collections::BTreeMap;

/// Cosine of the angle between the normals of facets from which their common edge is one of a feature: 34 degrees.
pub const SHARP: f64 = 0.83;

/// Edges of cells that are narrower than this many pixels are not drawn.
const LEAST_WIDTH: f64 = 3.5;

/// Where the light comes from, in camera coordinates.
const LIGHT: Point<3> = [-0.35, 0.5, 0.79];

/// No middle node.
const STRAIGHT: u32 = u32::MAX;

/// A reference cell of a facet, divided.
pub struct Lattice {
    /// Reference coordinates of its points.
    pub points: Vec<[f64; 3]>,
    /// Values of the shape functions there.
    shapes: Vec<[f64; MAX_FACET_NODES]>,
    /// Their gradients.
    slopes: Vec<[[f64; 2]; MAX_FACET_NODES]>,
    /// Triangles of points, in the sense of the facet.
    pub triangles: Vec<[usize; 3]>,
}

impl Lattice {
    /// `parts` along each edge, squares in four about their centres: the same from both sides of a facet. Zero: corners
    /// alone, and a square in two.
    pub fn new(kind: CellKind, parts: usize) -> Self {
        let (points, triangles) = match (kind.domain(), parts) {
            (Domain::Square, 0) => {
                let corners = kind.reference_nodes()[..4].to_vec();
                (corners, vec![[0, 1, 2], [0, 2, 3]])
            }
            (Domain::Square, _) => square(parts),
            _ => triangle(parts.max(1)),
        };
        let shapes = points.iter().map(|xi| {
            let mut values = [0.0; MAX_FACET_NODES];
            kind.shape(xi, &mut values);
            values
        });
        let slopes = points.iter().map(|xi| {
            let mut values = [[0.0; 2]; MAX_FACET_NODES];
            kind.gradients(xi, &mut values);
            values
        });
        Self {
            shapes: shapes.collect(),
            slopes: slopes.collect(),
            points,
            triangles,
        }
    }

    /// The value at a point of the lattice, interpolated from these nodal values.
    pub fn value(&self, point: usize, nodes: &[f64]) -> f64 {
        self.shapes[point]
            .iter()
            .zip(nodes)
            .map(|(n, v)| n * v)
            .sum()
    }

    /// The place of a point of the lattice.
    pub fn place(&self, point: usize, nodes: &[Point<3>]) -> Point<3> {
        let mut sum = [0.0; 3];
        for (weight, node) in self.shapes[point].iter().zip(nodes) {
            (0..3).for_each(|d| sum[d] += weight * node[d]);
        }
        sum
    }

    /// The unit normal there; towards the viewer where there is none.
    fn normal(&self, point: usize, nodes: &[Point<3>]) -> Point<3> {
        let mut tangents = [[0.0; 3]; 2];
        for (slope, node) in self.slopes[point].iter().zip(nodes) {
            for (tangent, s) in tangents.iter_mut().zip(slope) {
                (0..3).for_each(|d| tangent[d] += s * node[d]);
            }
        }
        unit(cross(tangents[0], tangents[1])).unwrap_or([0.0, 0.0, 1.0])
    }
}

fn triangle(parts: usize) -> (Vec<[f64; 3]>, Vec<[usize; 3]>) {
    let mut points = Vec::new();
    let mut row_starts = Vec::new();
    for j in 0..=parts {
        row_starts.push(points.len());
        points.extend((0..=parts - j).map(|i| [i as f64, j as f64, 0.0].map(|c| c / parts as f64)));
    }
    let mut triangles = Vec::new();
    for j in 0..parts {
        let (row, next) = (row_starts[j], row_starts[j + 1]);
        for i in 0..parts - j {
            triangles.push([row + i, row + i + 1, next + i]);
            if i + 1 < parts - j {
                triangles.push([row + i + 1, next + i + 1, next + i]);
            }
        }
    }
    (points, triangles)
}

fn square(parts: usize) -> (Vec<[f64; 3]>, Vec<[usize; 3]>) {
    let along = |i: f64| 2.0 * i / parts as f64 - 1.0;
    let grid = |shift: f64, count: usize| {
        (0..count * count).map(move |k| {
            let (i, j) = ((k % count) as f64 + shift, (k / count) as f64 + shift);
            [along(i), along(j), 0.0]
        })
    };
    let corners = parts + 1;
    let points = grid(0.0, corners).chain(grid(0.5, parts)).collect();
    let mut triangles = Vec::new();
    for k in 0..parts * parts {
        let (i, j) = (k % parts, k / parts);
        let first = j * corners + i;
        let rim = [first, first + 1, first + corners + 1, first + corners];
        let centre = corners * corners + k;
        triangles.extend((0..4).map(|e| [rim[e], rim[(e + 1) % 4], centre]));
    }
    (points, triangles)
}

/// Lattices that were asked for.
#[derive(Default)]
pub struct Lattices(BTreeMap<(CellKind, usize), Lattice>);

impl Lattices {
    /// The lattice of a kind with these parts.
    pub fn of(&mut self, kind: CellKind, parts: usize) -> &Lattice {
        let made = || Lattice::new(kind, parts);
        self.0.entry((kind, parts)).or_insert_with(made)
    }
}

/// An edge between facets.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Edge {
    /// Its ends and its middle node.
    nodes: [u32; 3],
    /// The body has an edge there, not only its mesh.
    pub feature: bool,
    /// Width of the narrowest of its facets, in units of length.
    width: f64,
}

/// Nodes of a body in a picture.
pub struct Look {
    /// Places in a window.
    pub places: Vec<Point<3>>,
    /// In [0, 1] along the colours; NaN without a value.
    pub values: Vec<f64>,
    /// Where the values are given; by default at the nodes.
    pub borders: Borders,
}

impl Look {
    /// Nodes at their places, moved by displacements times a factor.
    pub fn moved(
        window: &Window,
        points: &[Point<3>],
        displacement: &[Point<3>],
        factor: f64,
    ) -> Self {
        let at = |(i, x): (usize, &Point<3>)| match displacement.get(i) {
            Some(u) => window.place([0, 1, 2].map(|d| x[d] + factor * u[d])),
            None => window.place(*x),
        };
        Self {
            places: points.iter().enumerate().map(at).collect(),
            values: Vec::new(),
            borders: Borders::default(),
        }
    }

    /// Nodes where they were.
    pub fn at(window: &Window, points: &[Point<3>]) -> Self {
        Self::moved(window, points, &[], 0.0)
    }
}

/// Some facets of a mesh and the edges between them.
pub struct Skin<'a> {
    /// The mesh.
    pub mesh: &'a Mesh<3>,
    /// The facets.
    pub facets: Vec<Facet>,
    /// Every edge once.
    pub edges: Vec<Edge>,
}

impl<'a> Skin<'a> {
    /// The facets with their edges.
    pub fn new(mesh: &'a Mesh<3>, facets: Vec<Facet>) -> Self {
        let edges = edges(mesh, &facets);
        Self {
            mesh,
            facets,
            edges,
        }
    }

    /// Draws the facets that look at the viewer, each with its paint.
    pub fn fill(
        &self,
        canvas: &mut Canvas,
        look: &Look,
        owner: usize,
        paint: &dyn Fn(usize) -> Paint,
    ) {
        let mut lattices = Lattices::default();
        for (index, &facet) in self.facets.iter().enumerate() {
            let paint = paint(index);
            self.triangles(&mut lattices, look, facet, None, &mut |corners, _| {
                canvas.triangle(corners, paint, owner);
            });
        }
    }

    /// Draws the lines on which the values are `level`, on the facets that look at the viewer.
    pub fn level(&self, canvas: &mut Canvas, look: &Look, level: f64, ink: usize) {
        let mut lattices = Lattices::default();
        for &facet in &self.facets {
            self.triangles(&mut lattices, look, facet, None, &mut |corners, _| {
                if let Some([a, b]) = level_line(corners, level) {
                    canvas.line(a, b, ink);
                }
            });
        }
    }

    /// Draws the facets that look at the viewer, each place in the colour of the nearest corner, or of a node between corners
    /// that has one.
    pub fn patches(
        &self,
        canvas: &mut Canvas,
        look: &Look,
        owner: usize,
        colour: &dyn Fn(u32) -> Option<[u8; 3]>,
    ) {
        let mut lattices = Lattices::default();
        for &facet in &self.facets {
            let kind = self.mesh.facet_kind(facet);
            let nodes = self.mesh.facet_nodes(facet).map(colour).enumerate();
            let known = nodes.filter(|(local, own)| *local < kind.corners() || own.is_some());
            let coloured: Vec<([f64; 3], [u8; 3])> = known
                .map(|(local, own)| (kind.reference_nodes()[local], own.unwrap_or(NONE)))
                .collect();
            let parts = Some(6);
            self.triangles(&mut lattices, look, facet, parts, &mut |corners, xi| {
                let near = coloured
                    .iter()
                    .min_by(|a, b| distance(a.0, xi).total_cmp(&distance(b.0, xi)));
                let plain = Paint::Plain(near.map_or(NONE, |c| c.1));
                canvas.triangle(corners, plain, owner);
            });
        }
    }

    /// The triangles of a facet that look at the viewer, and the reference coordinates of their centres.
    fn triangles(
        &self,
        lattices: &mut Lattices,
        look: &Look,
        facet: Facet,
        parts: Option<usize>,
        draw: &mut dyn FnMut(&[Corner; 3], [f64; 3]),
    ) {
        let kind = self.mesh.facet_kind(facet);
        let mut nodes = [[0.0; 3]; MAX_FACET_NODES];
        let mut values = [0.0; MAX_FACET_NODES];
        for (local, node) in self.mesh.facet_nodes(facet).enumerate() {
            let [x, y, z] = look.places[node as usize];
            nodes[local] = [x, -y, z];
            let place = look.borders.place(facet.block as usize, node as usize);
            values[local] = look.values.get(place).copied().unwrap_or(0.0);
        }
        let (nodes, values) = (&nodes[..kind.nodes()], &values[..kind.nodes()]);
        let parts = parts.unwrap_or_else(|| fineness(kind, nodes));
        let lattice = lattices.of(kind, parts);
        let corner = |i: usize| {
            let [x, y, z] = lattice.place(i, nodes);
            Corner {
                at: [x, -y, z],
                shade: shade(lattice.normal(i, nodes)),
                value: lattice.value(i, values),
            }
        };
        let corners: Vec<Corner> = (0..lattice.points.len()).map(corner).collect();
        for &[a, b, c] in &lattice.triangles {
            let three = [corners[a], corners[b], corners[c]];
            if looks_here(&three) {
                let xi = [a, b, c].map(|i| lattice.points[i]);
                let centre = [0, 1, 2].map(|d| (xi[0][d] + xi[1][d] + xi[2][d]) / 3.0);
                draw(&three, centre);
            }
        }
    }

    /// Draws edges with inks: those between cells where they are not too close, and those of features.
    pub fn outline(
        &self,
        canvas: &mut Canvas,
        window: &Window,
        look: &Look,
        [thin, heavy]: [Option<usize>; 2],
    ) {
        for edge in &self.edges {
            let ink = match edge.feature {
                true => heavy,
                false => thin.filter(|_| edge.width * window.scale >= LEAST_WIDTH),
            };
            if let Some(ink) = ink {
                let line = edge.line(&look.places);
                line.windows(2)
                    .for_each(|ab| canvas.line(ab[0], ab[1], ink));
            }
        }
    }
}

impl Edge {
    /// Its nodes in a row.
    pub fn nodes(&self) -> Vec<u32> {
        let [a, b, middle] = self.nodes;
        match middle {
            STRAIGHT => vec![a, b],
            _ => vec![a, middle, b],
        }
    }

    /// The edge as a row of points, `places` by node.
    pub fn line(&self, places: &[Point<3>]) -> Vec<Point<3>> {
        let [a, b] = [0, 1].map(|i| places[self.nodes[i] as usize]);
        if self.nodes[2] == STRAIGHT {
            return vec![a, b];
        }
        let m = places[self.nodes[2] as usize];
        let size = (b[0] - a[0]).hypot(b[1] - a[1]);
        let parts = if size < 12.0 { 2 } else { 6 };
        let at = |k: usize| {
            let t = k as f64 / parts as f64;
            let weights = [
                (1.0 - t) * (1.0 - 2.0 * t),
                t * (2.0 * t - 1.0),
                4.0 * t * (1.0 - t),
            ];
            [0, 1, 2].map(|d| weights[0] * a[d] + weights[1] * b[d] + weights[2] * m[d])
        };
        (0..=parts).map(at).collect()
    }
}

/// Brightness of a surface with this unit normal in camera coordinates.
pub fn shade(normal: Point<3>) -> f64 {
    const DARK: f64 = 0.6;
    // half of the light comes from all around: nothing is black
    let light = 0.5 + 0.5 * dot(normal, LIGHT);
    (DARK + (1.03 - DARK) * light).min(1.0)
}

/// The line across a triangle on which its values are `level`.
fn level_line(corners: &[Corner; 3], level: f64) -> Option<[[f64; 3]; 2]> {
    let known = corners.iter().all(|corner| !corner.value.is_nan());
    let ends = (0..3).filter_map(|i| {
        let (a, b) = (&corners[i], &corners[(i + 1) % 3]);
        let crosses = known && (a.value > level) != (b.value > level);
        crosses.then(|| between(a.at, b.at, (level - a.value) / (b.value - a.value)))
    });
    ends.collect::<Vec<_>>().try_into().ok()
}

/// The corners run counter-clockwise on paper, where y is downward.
fn looks_here([a, b, c]: &[Corner; 3]) -> bool {
    let [a, b, c] = [a.at, b.at, c.at];
    (b[0] - a[0]) * (c[1] - a[1]) - (c[0] - a[0]) * (b[1] - a[1]) < 0.0
}

/// Parts along the edges of a facet of this size on paper.
fn fineness(kind: CellKind, nodes: &[Point<3>]) -> usize {
    let corners = &nodes[..kind.corners()];
    let spread = |d: usize| {
        let values = corners.iter().map(|p| p[d]);
        values.clone().fold(f64::MIN, f64::max) - values.fold(f64::MAX, f64::min)
    };
    let size = spread(0).max(spread(1));
    match (kind.order(), size) {
        (1, s) if s < 6.0 => 0,
        (1, s) if s < 60.0 => 1,
        (1, _) => 2,
        (_, s) if s < 4.0 => 1,
        (_, s) if s < 24.0 => 2,
        (_, s) if s < 80.0 => 4,
        _ => 8,
    }
}

fn edges(mesh: &Mesh<3>, facets: &[Facet]) -> Vec<Edge> {
    // (ends in ascending order, facet, edge of the facet)
    let mut list: Vec<([u32; 2], u32, u32)> = Vec::new();
    let mut widths = Vec::with_capacity(facets.len());
    for (index, &facet) in facets.iter().enumerate() {
        let kind = mesh.facet_kind(facet);
        let nodes: Vec<u32> = mesh.facet_nodes(facet).collect();
        for (local, (_, of)) in kind.facets().iter().enumerate() {
            let [a, b] = [nodes[of[0]], nodes[of[1]]];
            list.push(([a.min(b), a.max(b)], index as u32, local as u32));
        }
        widths.push(width(mesh, facet));
    }
    list.sort_unstable();
    let normal = |index: u32, local: u32| {
        let facet = facets[index as usize];
        let kind = mesh.facet_kind(facet);
        let ends = kind.facets()[local as usize].1;
        let [a, b] = [0, 1].map(|i| kind.reference_nodes()[ends[i]]);
        let middle = [0, 1, 2].map(|d| 0.5 * (a[d] + b[d]));
        unit(mesh.outward_normal(facet, &middle)).unwrap_or([0.0; 3])
    };
    let groups = list.chunk_by(|a, b| a.0 == b.0);
    let edge = |group: &[([u32; 2], u32, u32)]| {
        let &(_, index, local) = group.first()?;
        let facet = facets[index as usize];
        let of = mesh.facet_kind(facet).facets()[local as usize].1;
        let nodes: Vec<u32> = mesh.facet_nodes(facet).collect();
        let middle = of.get(2).map_or(STRAIGHT, |&m| nodes[m]);
        let widths = group.iter().map(|e| widths[e.1 as usize]);
        Some(Edge {
            nodes: [nodes[of[0]], nodes[of[1]], middle],
            feature: match group {
                [a, b] => dot(normal(a.1, a.2), normal(b.1, b.2)) < SHARP,
                _ => true,
            },
            width: widths.fold(f64::INFINITY, f64::min),
        })
    };
    groups.filter_map(edge).collect()
}

/// Area of a facet over its longest edge.
fn width(mesh: &Mesh<3>, facet: Facet) -> f64 {
    let kind = mesh.facet_kind(facet);
    let centre = mesh.outward_normal(facet, &kind.domain().centre());
    let area = dot(centre, centre).sqrt() * kind.domain().volume();
    let full = if kind.corners() == 3 { 2.0 } else { 1.0 };
    full * area / mesh.facet_length(facet)
}
