//! Facets: shared ones, those on the boundary, the order of a side, its normals.
//!
//! Conventions: in the plane a facet keeps its cell on the left, so a chain runs with the body on its left and the outward
//! normal is its tangent turned by −90°; in space its nodes run counter-clockwise seen from outside, and the outward normal is
//! the product of its two tangents. Two facets are the same when they have the same corner nodes.

use crate::geometry::{Point, distance, norm};
use crate::mesh::cell::MAX_FACET_NODES;
use crate::mesh::{CellKind, Facet, Mesh};
use std::any::Any;
use std::collections::{BTreeMap, BTreeSet};

/// Most corners of a facet of any kind.
const MAX_CORNERS: usize = 4;

/// A key of a facet that is the same for both of its cells.
type Key = [u32; MAX_CORNERS];

/// Corner nodes in ascending order, padded with `u32::MAX`: the same for all cells, or facets, on the same corners.
pub(crate) fn sorted<const N: usize>(corners: impl IntoIterator<Item = u32>) -> [u32; N] {
    let mut key = [u32::MAX; N];
    for (place, node) in key.iter_mut().zip(corners) {
        *place = node;
    }
    key.sort_unstable();
    key
}

/// Index of each facet of a cell after the cell was turned.
pub(crate) fn mirrored(kind: CellKind) -> Vec<u32> {
    let keys = |node: &dyn Fn(usize) -> usize| -> Vec<Key> {
        let of_facet = |&(facet, local): &(CellKind, &[usize])| {
            sorted(local[..facet.corners()].iter().map(|&i| node(i) as u32))
        };
        kind.facets().iter().map(of_facet).collect()
    };
    let turned = keys(&|node| kind.mirror()[node]);
    keys(&|node| node)
        .iter()
        .enumerate()
        .map(|(local, key)| turned.iter().position(|t| t == key).unwrap_or(local) as u32)
        .collect()
}

/// All facets of all cells, sorted by their corner nodes.
#[derive(Debug, Clone, PartialEq)]
pub struct FacetTable {
    entries: Vec<(Key, Facet)>,
}

impl FacetTable {
    /// The facets with exactly these corner nodes, in any order: one on the boundary, two between cells, else an empty list.
    pub fn find(&self, corners: &[u32]) -> impl Iterator<Item = Facet> + '_ {
        let key: Key = sorted(corners.iter().copied());
        let start = self.entries.partition_point(|(k, _)| *k < key);
        self.entries[start..]
            .iter()
            .take_while(move |(k, _)| *k == key)
            .map(|&(_, facet)| facet)
    }

    /// Facets with the same corners, one slice for each set of corners.
    pub(crate) fn groups(&self) -> impl Iterator<Item = &[(Key, Facet)]> {
        self.entries.chunk_by(|(a, _), (b, _)| a == b)
    }
}

/// Facets joined end to end along a side of a plane mesh, the body on the left.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Chain {
    /// The facets in order.
    pub facets: Vec<Facet>,
    /// Their nodes in order, middle nodes included; a cyclic chain names its first node once.
    pub nodes: Vec<u32>,
    /// The last facet ends where the first begins.
    pub cyclic: bool,
}

impl<const D: usize> Mesh<D> {
    /// Kind of a facet.
    pub fn facet_kind(&self, facet: Facet) -> CellKind {
        self.blocks[facet.block as usize].kind.facets()[facet.local as usize].0
    }

    /// Nodes of a facet in its own order: ends with the cell on the left, then the middle.
    pub fn facet_nodes(&self, facet: Facet) -> impl ExactSizeIterator<Item = u32> + '_ {
        let block = facet.block as usize;
        let nodes = self.cell_nodes(block, facet.cell as usize);
        let (_, local) = self.blocks[block].kind.facets()[facet.local as usize];
        local.iter().map(|&i| nodes[i])
    }

    /// Coordinates of the nodes of a facet in its own order.
    pub fn facet_points(&self, facet: Facet) -> impl ExactSizeIterator<Item = Point<D>> + '_ {
        self.facet_nodes(facet)
            .map(|node| self.points[node as usize])
    }

    /// The point of a facet at the reference coordinate ξ (in [−1, 1] on a line).
    pub fn facet_point(&self, facet: Facet, xi: &[f64]) -> Point<D> {
        let mut values = [0.0; MAX_FACET_NODES];
        self.facet_kind(facet).shape(xi, &mut values);
        let mut sum = [0.0; D];
        for (point, value) in self.facet_points(facet).zip(values) {
            for (s, x) in sum.iter_mut().zip(point) {
                *s += value * x;
            }
        }
        sum
    }

    /// Tangents ∂x/∂ξₖ of a facet at ξ, one in the plane and two in space; the others are zero.
    pub fn facet_tangents(&self, facet: Facet, xi: &[f64]) -> [Point<D>; D] {
        let mut gradients = [[0.0; D]; MAX_FACET_NODES];
        self.facet_kind(facet).gradients(xi, &mut gradients);
        let mut tangents = [[0.0; D]; D];
        for (point, gradient) in self.facet_points(facet).zip(gradients) {
            for (tangent, slope) in tangents.iter_mut().zip(gradient) {
                for (t, x) in tangent.iter_mut().zip(point) {
                    *t += slope * x;
                }
            }
        }
        tangents
    }

    /// Outward normal of a facet at ξ, as long as dS/dξ: the tangent turned by −90°, in space the product of both tangents.
    pub fn outward_normal(&self, facet: Facet, xi: &[f64]) -> Point<D> {
        let tangents = self.facet_tangents(facet, xi);
        match D {
            2 => {
                let [x, y] = [tangents[0][0], tangents[0][1]];
                std::array::from_fn(|d| if d == 0 { y } else { -x })
            }
            _ => std::array::from_fn(|d| {
                let (i, j) = ((d + 1) % D, (d + 2) % D);
                tangents[0][i] * tangents[1][j] - tangents[0][j] * tangents[1][i]
            }),
        }
    }

    /// All facets, for looking them up by their corners.
    pub fn facet_table(&self) -> FacetTable {
        // by the smallest corner, which few facets have in common, then those in order: a tenth of the time of sorting all at once
        let mut starts = vec![0; self.points.len() + 1];
        self.each_facet(|key, _| starts[key[0] as usize + 1] += 1);
        for node in 1..starts.len() {
            starts[node] += starts[node - 1];
        }
        let nothing = Facet {
            block: 0,
            cell: 0,
            local: 0,
        };
        let mut entries = vec![(Key::default(), nothing); starts[self.points.len()]];
        let mut next = starts.clone();
        self.each_facet(|key, facet| {
            let place = &mut next[key[0] as usize];
            entries[*place] = (key, facet);
            *place += 1;
        });
        for ends in starts.windows(2) {
            entries[ends[0]..ends[1]].sort_unstable();
        }
        FacetTable { entries }
    }

    /// Visits all facets of all cells, each with its key.
    fn each_facet(&self, mut visit: impl FnMut(Key, Facet)) {
        for (block, cells) in self.blocks.iter().enumerate() {
            for (cell, nodes) in cells.cells().enumerate() {
                for (local, (kind, of_cell)) in cells.kind.facets().iter().enumerate() {
                    let corners = of_cell[..kind.corners()].iter();
                    let facet_key = sorted(corners.map(|&i| nodes[i]));
                    let facet = Facet {
                        block: block as u32,
                        cell: cell as u32,
                        local: local as u32,
                    };
                    visit(facet_key, facet);
                }
            }
        }
    }

    /// The facets with these corner nodes, one after the other: of each the one of a single cell, or of the first of two. Looks
    /// at cells at these nodes alone.
    ///
    /// Errors: the index of the first set of corners that no facet has.
    pub fn facets_at(&self, corners: &[Vec<u32>]) -> Result<Vec<Facet>, usize> {
        let mut marked = vec![false; self.points.len()];
        for &node in corners.iter().flatten() {
            if let Some(mark) = marked.get_mut(node as usize) {
                *mark = true;
            }
        }
        let mut entries: Vec<(Key, Facet)> = Vec::new();
        for (block, cells) in self.blocks.iter().enumerate() {
            for (cell, nodes) in cells.cells().enumerate() {
                for (local, (kind, of_cell)) in cells.kind.facets().iter().enumerate() {
                    let own = of_cell[..kind.corners()].iter().map(|&i| nodes[i]);
                    if own.clone().all(|node| marked[node as usize]) {
                        let [block, cell, local] = [block, cell, local].map(|i| i as u32);
                        entries.push((sorted(own), Facet { block, cell, local }));
                    }
                }
            }
        }
        entries.sort_unstable();
        let table = FacetTable { entries };
        let found = corners.iter().enumerate();
        let found = found.map(|(k, corners)| match corners.len() <= MAX_CORNERS {
            true => table.find(corners).next().ok_or(k),
            false => Err(k),
        });
        found.collect()
    }

    /// The facets that belong to one cell only, in ascending order.
    pub fn boundary_facets(&self) -> Vec<Facet> {
        if self.shell {
            return self.sides.values().flatten().copied().collect();
        }
        let table = self.facet_table();
        let mut boundary: Vec<Facet> = table
            .groups()
            .filter(|group| group.len() == 1)
            .map(|group| group[0].1)
            .collect();
        boundary.sort_unstable();
        boundary
    }

    /// The facets of the cells of a group that belong to one of these cells alone, in ascending order.
    pub fn group_boundary(&self, group: &str) -> Vec<Facet> {
        let own = |facet: &Facet| self.blocks[facet.block as usize].group.as_deref() == Some(group);
        let table = self.facet_table();
        let mut boundary: Vec<Facet> = table
            .groups()
            .filter_map(|cells| {
                let mut own = cells.iter().map(|cell| cell.1).filter(own);
                own.next().filter(|_| own.next().is_none())
            })
            .collect();
        boundary.sort_unstable();
        boundary
    }

    /// Nodes of a side, each once, in ascending order; `None` without such a side.
    pub fn side_nodes(&self, name: &str) -> Option<Vec<u32>> {
        let mut nodes: Vec<u32> = self
            .side(name)?
            .iter()
            .flat_map(|&facet| self.facet_nodes(facet))
            .collect();
        nodes.sort_unstable();
        nodes.dedup();
        Some(nodes)
    }

    /// For each cell, block after block, the number of the part of the mesh that it is connected with through facets.
    ///
    /// Parts are numbered from zero in the order of their first cells. Cells that share only a node are not connected.
    pub fn facet_components(&self) -> Vec<u32> {
        components(self.cell_count(), self.neighbours())
    }

    /// Pairs of cells that share a facet, counted block after block.
    pub(crate) fn neighbours(&self) -> Vec<[u32; 2]> {
        let blocks = 0..self.blocks.len();
        let before: Vec<usize> = blocks.map(|block| self.cells_before(block)).collect();
        let cell = |facet: Facet| before[facet.block as usize] as u32 + facet.cell;
        let table = self.facet_table();
        let groups = table.groups().flat_map(|group| group.windows(2));
        groups
            .map(|pair| [cell(pair[0].1), cell(pair[1].1)])
            .collect()
    }

    /// Number of parts in [`Self::facet_components`].
    pub fn component_count(&self) -> usize {
        self.facet_components()
            .into_iter()
            .max()
            .map_or(0, |last| last as usize + 1)
    }
}

impl<const D: usize> Mesh<D> {
    /// Length of the polygon through the nodes of a line, in space the longest edge between corners of a facet: a local
    /// scale, not an integral over a curved facet.
    pub fn facet_length(&self, facet: Facet) -> f64 {
        let kind = self.facet_kind(facet);
        let mut at = [[0.0; D]; MAX_FACET_NODES];
        for (place, point) in at.iter_mut().zip(self.facet_points(facet)) {
            *place = point;
        }
        match kind {
            CellKind::Line3 => distance(at[0], at[2]) + distance(at[2], at[1]),
            _ => {
                let ends = kind.corner_edges().iter().enumerate();
                let lengths = ends.flat_map(|(a, ends)| ends.iter().map(move |&b| (a, b)));
                lengths.fold(0.0, |most, (a, b)| distance(at[a], at[b]).max(most))
            }
        }
    }

    /// Length or area of a facet by the normal at its centre: of curved ones that of a flat one.
    pub fn facet_size(&self, facet: Facet) -> f64 {
        let domain = self.facet_kind(facet).domain();
        domain.volume() * norm(self.outward_normal(facet, &domain.centre()))
    }

    /// Nodes of a side in its order, each once, and whether it is one closed chain: along its chains in the plane, in space
    /// ascending; `None` without such a side.
    pub fn side_order(&self, name: &str) -> Option<(Vec<u32>, bool)> {
        let Some(plane) = self.in_plane() else {
            return Some((self.side_nodes(name)?, false));
        };
        let chains = plane.chain(name)?;
        let along = chains.iter().flat_map(|chain| &chain.nodes).copied();
        let mut seen = BTreeSet::new();
        let nodes = along.filter(|&node| seen.insert(node)).collect();
        Some((nodes, matches!(&chains[..], [only] if only.cyclic)))
    }

    /// The same mesh as one of the plane, if it is one.
    pub fn in_plane(&self) -> Option<&Mesh<2>> {
        (self as &dyn Any).downcast_ref()
    }
}

impl Mesh<2> {
    /// The facets of a side joined end to end; `None` without such a side.
    ///
    /// Chains end where the side ends and at a node where more than two of its facets meet. They come in the order of
    /// their first facets, open ones first; a cyclic one begins with the smallest of its facets.
    pub fn chain(&self, name: &str) -> Option<Vec<Chain>> {
        let side = self.side(name)?;
        let ends: Vec<[u32; 2]> = side
            .iter()
            .map(|&facet| {
                let mut nodes = self.facet_nodes(facet);
                [nodes.next(), nodes.next()].map(|node| node.unwrap_or(u32::MAX))
            })
            .collect();
        let mut leaving: BTreeMap<u32, (usize, usize)> = BTreeMap::new();
        let mut arriving: BTreeMap<u32, usize> = BTreeMap::new();
        for (index, &[from, to]) in ends.iter().enumerate() {
            leaving.entry(from).or_insert((index, 0)).1 += 1;
            *arriving.entry(to).or_insert(0) += 1;
        }
        // The next facet, where exactly one arrives and exactly one leaves.
        let next = |index: usize| -> Option<usize> {
            let node = ends[index][1];
            let &(follower, count) = leaving.get(&node)?;
            (count == 1 && arriving.get(&node) == Some(&1)).then_some(follower)
        };
        let mut follows = vec![false; side.len()];
        for index in (0..side.len()).filter_map(next) {
            follows[index] = true;
        }
        let heads = (0..side.len()).filter(|&index| !follows[index]);
        let mut taken = vec![false; side.len()];
        let mut chains = Vec::new();
        for start in heads.chain(0..side.len()) {
            let mut order = Vec::new();
            let mut current = Some(start);
            while let Some(index) = current.filter(|&index| !taken[index]) {
                taken[index] = true;
                order.push(index);
                current = next(index);
            }
            if !order.is_empty() {
                chains.push(self.joined(side, &order, current == Some(start)));
            }
        }
        Some(chains)
    }

    fn joined(&self, side: &[Facet], order: &[usize], cyclic: bool) -> Chain {
        let facets: Vec<Facet> = order.iter().map(|&index| side[index]).collect();
        let mut nodes = Vec::new();
        let mut last = None;
        for &facet in &facets {
            let mut along = self.facet_nodes(facet);
            nodes.extend(along.next());
            last = along.next();
            nodes.extend(along);
        }
        if !cyclic {
            nodes.extend(last);
        }
        Chain {
            facets,
            nodes,
            cyclic,
        }
    }
}

/// The number of the connected part of each of some things, of which pairs are connected. Parts are numbered from zero in the order
/// of their first members.
pub(crate) fn components(things: usize, pairs: impl IntoIterator<Item = [u32; 2]>) -> Vec<u32> {
    let mut parent: Vec<usize> = (0..things).collect();
    for pair in pairs {
        let [a, b] = pair.map(|thing| root(&mut parent, thing as usize));
        parent[a.max(b)] = a.min(b);
    }
    // A root is the first of its part, so its number is known when the others ask for it.
    let mut component = vec![0; things];
    let mut count = 0;
    for thing in 0..things {
        let root = root(&mut parent, thing);
        if root == thing {
            component[thing] = count;
            count += 1;
        } else {
            component[thing] = component[root];
        }
    }
    component
}

fn root(parent: &mut [usize], mut cell: usize) -> usize {
    while parent[cell] != cell {
        parent[cell] = parent[parent[cell]];
        cell = parent[cell];
    }
    cell
}
