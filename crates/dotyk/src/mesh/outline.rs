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
mod drawing;
mod fill;
mod nouns;

pub use nouns::{Contour, Division, EdgeShape, Outline, OutlineEdge, OutlinePlace, SizePoint};

use crate::geometry::{Point, Surface, add_scaled, distance};
use crate::mesh::outline::divide::{Divided, Sizes, divide};
use crate::mesh::outline::drawing::Drawing;
use crate::mesh::outline::fill::{Boundary, Filled, Unfilled, fill};
use crate::mesh::outline::nouns::MOST_VERTICES;
use crate::mesh::{CellBlock, CellKind, Facet, Mesh, MeshError};
use std::collections::BTreeMap;
use std::f64::consts::TAU;

/// A piece of the boundary: one edge of a cell.
struct Edge<'a> {
    sides: &'a [String],
    /// The circle that it is a part of.
    circle: Option<Surface<2>>,
    /// Its middle on the true curve.
    middle: Point<2>,
}

impl Outline {
    /// The mesh: nodes of the boundary first, path after path.
    ///
    /// Errors, each naming the edge: coordinates that are not finite; edges of no length, that do not close, cross or touch;
    /// arcs that do not exist; a hole outside or in another one; sizes that are not positive or exceed the outline; a kind of
    /// cell that is no triangle; more than two million corners of cells.
    pub fn build(&self) -> Result<Mesh<2>, MeshError> {
        let drawing = Drawing::of(self)?;
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
                sides: &drawing.sides[rib],
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

    /// The pieces of all edges, the edge that each belongs to, and their middles.
    fn pieces(
        &self,
        drawing: &Drawing,
        divided: &[Divided],
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
                    for side in edge.sides {
                        sides.entry(side.clone()).or_default().push(facet);
                    }
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

fn too_many() -> MeshError {
    OutlinePlace::default().error(format!(
        "the sizes ask for more than {MOST_VERTICES} nodes: use larger ones"
    ))
}
