//! Divided curves as a net of pieces, the filled faces between them, and bodies made of one or several such faces.
//!
//! Every curve is divided once for both of its sides: faces that meet along it have the same nodes there, to the last bit. Each
//! face is filled separately; a body of several faces has their common nodes once.

use crate::geometry::{Point, distance};
use crate::mesh::outline::divide::{Rib, Sizes, divide};
use crate::mesh::outline::fill::{Boundary, Filled, Unfilled, fill};
use crate::mesh::outline::nouns::{MOST_VERTICES, OutlinePlace};
use crate::mesh::{CellBlock, CellKind, Facet, Mesh, MeshError};
use std::collections::BTreeMap;

/// All pieces of all curves: one edge of a cell each.
#[derive(Debug, Clone)]
pub(crate) struct Net {
    nodes: Vec<Point<2>>,
    pieces: Vec<Piece>,
}

/// A piece of a curve, in its direction.
#[derive(Debug, Clone)]
struct Piece {
    ends: [u32; 2],
    rib: usize,
    /// Its middle on the true curve.
    middle: Point<2>,
}

/// A filled face.
#[derive(Debug, Clone)]
pub(crate) struct Part {
    pub face: usize,
    /// The group of its cells.
    group: Option<String>,
    /// The nodes of the net that it has, ascending; they are its first.
    shared: Vec<u32>,
    /// Its other nodes.
    inner: Vec<Point<2>>,
    /// Corners, counter-clockwise.
    triangles: Vec<[u32; 3]>,
}

impl Net {
    /// The curves divided; `None`: into too many pieces.
    pub fn of(ribs: &[Rib], sizes: &Sizes<'_>) -> Option<Self> {
        let divided = divide(ribs, sizes)?;
        let corners = ribs.iter().flat_map(|rib| rib.ends).max();
        let mut corner = vec![None; corners.map_or(0, |corner| corner + 1)];
        let mut nodes = Vec::new();
        let mut firsts = Vec::with_capacity(ribs.len());
        for (rib, parts) in ribs.iter().zip(&divided) {
            let start = &mut corner[rib.ends[0]];
            if start.is_none() {
                *start = Some(nodes.len() as u32);
                nodes.push(parts.nodes[0]);
            }
            firsts.push(nodes.len() as u32);
            nodes.extend(&parts.nodes[1..parts.nodes.len() - 1]);
        }
        // A corner where no piece begins is one where a piece ends.
        for (rib, parts) in ribs.iter().zip(&divided) {
            let end = &mut corner[rib.ends[1]];
            if end.is_none() {
                *end = Some(nodes.len() as u32);
                nodes.push(parts.nodes[parts.nodes.len() - 1]);
            }
        }
        let mut pieces = Vec::new();
        for (index, (rib, parts)) in ribs.iter().zip(&divided).enumerate() {
            let count = parts.middles.len();
            let [start, end] = rib.ends.map(|end| corner[end].unwrap_or_default());
            let node = |k: usize| match k {
                0 => start,
                k if k == count => end,
                k => firsts[index] + k as u32 - 1,
            };
            pieces.extend((0..count).map(|k| Piece {
                ends: [node(k), node(k + 1)],
                rib: index,
                middle: parts.middles[k],
            }));
        }
        Some(Self { nodes, pieces })
    }

    /// Triangles in a face between curves (with these places in messages), of at most the largest of the sizes.
    ///
    /// Errors: pieces of its boundary that cross or touch, naming their edges; too many nodes.
    pub fn fill(
        &self,
        (ribs, places): (&[Rib], &[OutlinePlace]),
        face: usize,
        group: Option<String>,
        sizes: &Sizes<'_>,
    ) -> Result<Part, MeshError> {
        let beside = |piece: &&Piece| ribs[piece.rib].faces.contains(&Some(face));
        let pieces: Vec<&Piece> = self.pieces.iter().filter(beside).collect();
        let mut shared: Vec<u32> = pieces.iter().flat_map(|piece| piece.ends).collect();
        shared.sort_unstable();
        shared.dedup();
        let own = |node: u32| shared.binary_search(&node).unwrap_or_default() as u32;
        let oriented = pieces.iter().map(|piece| {
            let [from, to] = piece.ends.map(own);
            match ribs[piece.rib].faces[0] == Some(face) {
                true => [from, to],
                false => [to, from],
            }
        });
        let nodes = shared.iter().map(|&n| self.nodes[n as usize]).collect();
        let boundary = boundary(nodes, oriented.collect(), sizes.largest);
        let place = |piece: usize| pieces.get(piece).map(|piece| &places[piece.rib]);
        let filled = fill(&boundary, sizes).map_err(|unfilled| match unfilled {
            Unfilled::TooMany => places[pieces[0].rib].whole().too_many(),
            Unfilled::Meet(a, b) => {
                let here = place(a).or(place(b)).cloned().unwrap_or_default();
                let there = place(b).cloned().unwrap_or_default();
                here.error(format!(
                    "its cell edges meet those of {there}: give both smaller sizes or more cells"
                ))
            }
        })?;
        let Filled { nodes, triangles } = filled;
        Ok(Part {
            face,
            group,
            inner: nodes[shared.len()..].to_vec(),
            shared,
            triangles,
        })
    }

    /// The mesh of some filled faces, nodes of the net first; the cells of each face are a block. `sides` gives the sides of a curve,
    /// by the face beyond it, if any.
    ///
    /// Errors: as [`Mesh::new`].
    pub fn mesh(
        &self,
        ribs: &[Rib],
        cell: CellKind,
        parts: &[&Part],
        sides: impl Fn(usize, Option<usize>) -> Vec<String>,
    ) -> Result<Mesh<2>, MeshError> {
        let mut own = vec![None; self.nodes.len()];
        for &node in parts.iter().flat_map(|part| &part.shared) {
            own[node as usize] = Some(0);
        }
        let mut points = Vec::new();
        for (own, &point) in own.iter_mut().zip(&self.nodes) {
            if let Some(own) = own {
                *own = points.len() as u32;
                points.push(point);
            }
        }
        let between = self.between(&own);
        let mut corners = Vec::with_capacity(parts.len());
        for part in parts {
            corners.push(part.numbered(&own, points.len() as u32));
            points.extend(&part.inner);
        }
        let (mut facets, mut curves) = (BTreeMap::<String, Vec<Facet>>::new(), BTreeMap::new());
        for (facet, edge) in edges(&corners) {
            let Some(&(piece, forward)) = between.get(&edge) else {
                continue;
            };
            let rib = &ribs[piece.rib];
            let beyond = rib.faces[usize::from(forward)];
            if parts.iter().any(|part| Some(part.face) == beyond) {
                continue;
            }
            for side in sides(piece.rib, beyond) {
                facets.entry(side).or_default().push(facet);
            }
            curves.extend(rib.curve.circle().map(|circle| (facet, circle)));
        }
        let nodes = match cell {
            CellKind::Tri6 => with_middles(&corners, &between, &mut points),
            _ => corners.iter().map(|c| c.as_flattened().to_vec()).collect(),
        };
        let blocks = parts.iter().zip(nodes).map(|(part, nodes)| CellBlock {
            kind: cell,
            nodes,
            group: part.group.clone(),
        });
        let mesh = Mesh::new(points, blocks.collect())?.with_sides(facets)?;
        Ok(mesh.with_curves(curves))
    }

    /// The pieces between nodes of a body, by their ends in either direction; `own` are its numbers of the nodes of the net.
    fn between(&self, own: &[Option<u32>]) -> Between<'_> {
        let mut between = BTreeMap::new();
        for piece in &self.pieces {
            if let [Some(from), Some(to)] = piece.ends.map(|end| own[end as usize]) {
                between.insert((from, to), (piece, true));
                between.insert((to, from), (piece, false));
            }
        }
        between
    }
}

/// The boundary of a face: the size at a node is the mean length of its pieces, if that is not too large.
fn boundary(nodes: Vec<Point<2>>, pieces: Vec<[u32; 2]>, largest: f64) -> Boundary {
    let mut sums = vec![(0.0, 0.0); nodes.len()];
    for piece in &pieces {
        let [a, b] = piece.map(|node| nodes[node as usize]);
        for &node in piece {
            let sum = &mut sums[node as usize];
            *sum = (sum.0 + 0.5 * distance(a, b), sum.1 + 0.5);
        }
    }
    let means = sums.into_iter().map(|(sum, count)| sum / count);
    Boundary {
        sizes: means.map(|size| size.min(largest)).collect(),
        nodes,
        pieces,
        most: MOST_VERTICES,
    }
}

/// The piece between two nodes, and whether these are in its direction.
type Between<'a> = BTreeMap<(u32, u32), (&'a Piece, bool)>;

impl Part {
    /// Corners of the triangles in the numbers of a body, in which the inner nodes begin with `first`.
    fn numbered(&self, own: &[Option<u32>], first: u32) -> Vec<[u32; 3]> {
        let number = |node: u32| match self.shared.get(node as usize) {
            Some(&shared) => own[shared as usize].unwrap_or_default(),
            None => first + node - self.shared.len() as u32,
        };
        let triangles = self.triangles.iter();
        triangles.map(|corners| corners.map(number)).collect()
    }
}

/// All edges of the triangles of some blocks: facet and ends.
fn edges(corners: &[Vec<[u32; 3]>]) -> impl Iterator<Item = (Facet, (u32, u32))> + '_ {
    let cells = corners.iter().enumerate().flat_map(|(block, triangles)| {
        let triangles = triangles.iter().enumerate();
        triangles.map(move |(cell, corners)| (block, cell, corners))
    });
    cells.flat_map(|(block, cell, corners)| {
        (0..3).map(move |local| {
            let facet = Facet {
                block: block as u32,
                cell: cell as u32,
                local: local as u32,
            };
            (facet, (corners[local], corners[(local + 1) % 3]))
        })
    })
}

/// Nodes of quadratic triangles, block by block: a node in the middle of each edge, of a piece on its curve.
fn with_middles(
    corners: &[Vec<[u32; 3]>],
    between: &Between<'_>,
    points: &mut Vec<Point<2>>,
) -> Vec<Vec<u32>> {
    let mut nodes: Vec<Vec<u32>> = vec![Vec::new(); corners.len()];
    let mut middles = BTreeMap::new();
    for (facet, (from, to)) in edges(corners) {
        let cells = &mut nodes[facet.block as usize];
        if facet.local == 0 {
            cells.extend(corners[facet.block as usize][facet.cell as usize]);
        }
        let node = *middles
            .entry((from.min(to), from.max(to)))
            .or_insert_with(|| {
                let ends = [from, to].map(|node| points[node as usize]);
                let straight = [0, 1].map(|d| 0.5 * (ends[0][d] + ends[1][d]));
                let piece = between.get(&(from, to));
                points.push(piece.map_or(straight, |(piece, _)| piece.middle));
                points.len() as u32 - 1
            });
        cells.push(node);
    }
    nodes
}
