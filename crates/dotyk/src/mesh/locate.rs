//! Location of a point in a mesh: the cell that contains it, or the facet of a side on which it lies.

use crate::geometry::{
    Point, Settling, add_scaled, bounding_box, distance, dot, invert, norm, sub, unit,
};
use crate::mesh::on_surface::locate_on_surface;
use crate::mesh::{CellKind, Facet, MAX_CELL_NODES, Mesh};
use rstar::primitives::GeomWithData;
use rstar::{AABB, RTree};

/// A point may lie outside a cell by this much in reference coordinates: only a polygon's sagitta.
const OUTSIDE: f64 = 0.1;

/// A point nearer to the border of a cell than this, in reference coordinates, is on it: what Newton's method leaves.
const ON_BORDER: f64 = 1e-9;

/// Nodes and weights of the value at a place.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Located<const D: usize> {
    /// Index of the block of the cell, or of that behind the facet: its material.
    pub block: usize,
    /// Its place among those of the block, where the place lies within it and not on its border.
    pub cell: Option<usize>,
    pub nodes: Vec<usize>,
    /// Shape functions of the nodes.
    pub shape: Vec<f64>,
    /// Outward unit normal of the side; zero in a cell.
    pub normal: Point<D>,
    /// Distance outside of the cell, in its own coordinates; not positive within.
    pub outside: f64,
}

impl<const D: usize> Located<D> {
    /// A node of the cells of a block, of a side with this normal.
    pub fn at_node(block: usize, node: usize, normal: Point<D>) -> Self {
        Self {
            block,
            cell: None,
            nodes: vec![node],
            shape: vec![1.0],
            normal,
            outside: 0.0,
        }
    }

    /// The place ξ of a facet.
    pub fn on_facet(mesh: &Mesh<D>, facet: Facet, xi: &[f64]) -> Self {
        let mut shape = [0.0; MAX_CELL_NODES];
        mesh.facet_kind(facet).shape(xi, &mut shape);
        let nodes: Vec<usize> = mesh.facet_nodes(facet).map(|n| n as usize).collect();
        Self {
            block: facet.block as usize,
            cell: None,
            shape: shape[..nodes.len()].to_vec(),
            nodes,
            normal: unit(mesh.outward_normal(facet, xi)).unwrap_or([0.0; D]),
            outside: 0.0,
        }
    }

    /// The nodes whose values count here.
    pub fn carriers(&self) -> impl Iterator<Item = usize> {
        let parts = self.nodes.iter().zip(&self.shape);
        parts.filter_map(|(&node, n)| (n.abs() > ON_BORDER).then_some(node))
    }

    /// The interpolated value of these nodal values; a node without weight does not count, whatever its value.
    pub fn interpolate<const N: usize>(&self, value: impl Fn(usize) -> [f64; N]) -> [f64; N] {
        let parts = self.nodes.iter().zip(&self.shape);
        parts.fold([0.0; N], |sum, (&node, &n)| match n {
            0.0 => sum,
            _ => add_scaled(sum, n, value(node)),
        })
    }
}

/// The place of a point in the cell that contains it; `None` without such a cell.
pub(crate) fn locate<const D: usize>(mesh: &Mesh<D>, point: Point<D>) -> Option<Located<D>> {
    locate_all(mesh, &[point]).pop().flatten()
}

/// The same for several points: one pass through the cells for all of them.
pub(crate) fn locate_all<const D: usize>(
    mesh: &Mesh<D>,
    points: &[Point<D>],
) -> Vec<Option<Located<D>>> {
    let indexed = points.iter().enumerate();
    let indexed = indexed.map(|(index, &point)| GeomWithData::new(point, index));
    let tree = RTree::bulk_load(indexed.collect());
    let mut best: Vec<Option<(f64, Located<D>)>> = vec![None; points.len()];
    for (index, block) in mesh.blocks().iter().enumerate() {
        for (number, cell) in block.cells().enumerate() {
            let corners: Vec<Point<D>> = cell
                .iter()
                .map(|&node| mesh.points()[node as usize])
                .collect();
            let (low, high) = bounding_box(&corners);
            let margin = 0.2 * distance(low, high);
            let near = AABB::from_corners(low.map(|c| c - margin), high.map(|c| c + margin));
            for candidate in tree.locate_in_envelope(near) {
                let Some(xi) = invert_map(block.kind, &corners, *candidate.geom()) else {
                    continue;
                };
                let outside = block.kind.domain().outside(&xi);
                let best = &mut best[candidate.data];
                if outside <= OUTSIDE && best.as_ref().is_none_or(|b| outside < b.0) {
                    let mut shape = [0.0; MAX_CELL_NODES];
                    block.kind.shape(&xi, &mut shape);
                    let found = Located {
                        block: index,
                        cell: (outside < -ON_BORDER).then_some(number),
                        nodes: cell.iter().map(|&node| node as usize).collect(),
                        shape: shape[..cell.len()].to_vec(),
                        normal: [0.0; D],
                        outside,
                    };
                    *best = Some((outside, found));
                }
            }
        }
    }
    let located = best.into_iter();
    located.map(|best| best.map(|(_, found)| found)).collect()
}

/// Reference coordinates of a point in a cell by Newton's method; `None` when it does not settle.
fn invert_map<const D: usize>(
    kind: CellKind,
    nodes: &[Point<D>],
    point: Point<D>,
) -> Option<[f64; D]> {
    let corners = kind.corners();
    let mut xi: [f64; D] = std::array::from_fn(|i| {
        kind.reference_nodes()[..corners]
            .iter()
            .map(|node| node[i])
            .sum::<f64>()
            / corners as f64
    });
    let mut settling = Settling::new();
    for _ in 0..30 {
        let (mut shape, mut gradients) = ([0.0; MAX_CELL_NODES], [[0.0; D]; MAX_CELL_NODES]);
        kind.shape(&xi, &mut shape);
        kind.gradients(&xi, &mut gradients);
        let mut x = [0.0; D];
        let mut jacobian = [[0.0; D]; D];
        for (a, node) in nodes.iter().enumerate() {
            for i in 0..D {
                x[i] += shape[a] * node[i];
                for j in 0..D {
                    jacobian[i][j] += node[i] * gradients[a][j];
                }
            }
        }
        let (inverse, det) = invert(&jacobian);
        if det == 0.0 || !det.is_finite() {
            return None;
        }
        let rest = sub(point, x);
        let change = inverse.map(|row| dot(row, rest));
        xi = add_scaled(xi, 1.0, change);
        if settling.ends(&change, &xi) {
            break;
        }
    }
    xi.iter().all(|c| c.is_finite()).then_some(xi)
}

/// Newton's steps on a facet end below this length in reference coordinates, which are of size one: at rounding of tangents
/// that are differences.
pub(crate) const SETTLED: f64 = 1e-12;

/// Step of these differences in ξ: its square, which they neglect, is rounding.
const DIFFERENCE: f64 = 1e-6;

/// A point may lie beside a side by this fraction of a facet: only the sagitta of a polygon.
pub(crate) const BESIDE: f64 = 0.1;

/// A point may lie beyond the end of a side by this fraction of a facet: only rounding.
pub(crate) const BEYOND: f64 = 1e-6;

/// The place of a side that is nearest to a point; `None` where the point lies beside.
pub(crate) fn locate_on_side<const D: usize>(
    mesh: &Mesh<D>,
    facets: &[Facet],
    point: Point<D>,
) -> Option<Located<D>> {
    if D > 2 {
        return locate_on_surface(mesh, facets, point);
    }
    let mut best: Option<(f64, Facet, f64, f64)> = None;
    for &facet in facets {
        let ends: Vec<Point<D>> = mesh.facet_points(facet).take(2).collect();
        let length = distance(ends[0], ends[1]);
        let xi = nearest_on_facet(mesh, facet, [ends[0], ends[1]], point);
        let gap = distance(point, mesh.facet_point(facet, &[xi]));
        if best.is_none_or(|b| gap < b.0) {
            best = Some((gap, facet, xi, length));
        }
    }
    let (gap, facet, xi, length) = best?;
    let beyond = beyond_the_end(mesh, facets, facet, xi, point);
    let near = gap <= BESIDE * length && beyond <= BEYOND * length;
    near.then(|| Located::on_facet(mesh, facet, &[xi]))
}

/// Coordinate of the point of a facet that is nearest to a point.
fn nearest_on_facet<const D: usize>(
    mesh: &Mesh<D>,
    facet: Facet,
    ends: [Point<D>; 2],
    point: Point<D>,
) -> f64 {
    let chord = sub(ends[1], ends[0]);
    let length = norm(chord);
    let mut xi = (2.0 * dot(sub(point, ends[0]), chord) / (length * length) - 1.0).clamp(-1.0, 1.0);
    for _ in 0..20 {
        let h = DIFFERENCE;
        let (back, here, ahead) = (
            mesh.facet_point(facet, &[xi - h]),
            mesh.facet_point(facet, &[xi]),
            mesh.facet_point(facet, &[xi + h]),
        );
        let tangent = sub(ahead, back).map(|c| c / (2.0 * h));
        let step = dot(sub(point, here), tangent) / dot(tangent, tangent);
        let next = (xi + step).clamp(-1.0, 1.0);
        let settled = (next - xi).abs() < SETTLED;
        xi = next;
        if settled {
            break;
        }
    }
    xi
}

/// Distance of a point beyond the end of a side whose nearest place is ξ of a facet; zero elsewhere.
fn beyond_the_end<const D: usize>(
    mesh: &Mesh<D>,
    facets: &[Facet],
    facet: Facet,
    xi: f64,
    point: Point<D>,
) -> f64 {
    if xi.abs() < 1.0 {
        return 0.0;
    }
    let ends: Vec<u32> = mesh.facet_nodes(facet).take(2).collect();
    let node = ends[usize::from(xi > 0.0)];
    let touching = facets
        .iter()
        .filter(|&&f| mesh.facet_nodes(f).take(2).any(|n| n == node));
    if touching.count() > 1 {
        return 0.0;
    }
    let [here, inside] = [xi, xi - DIFFERENCE * xi].map(|xi| mesh.facet_point(facet, &[xi]));
    let outwards = sub(here, inside);
    dot(sub(point, here), outwards) / norm(outwards)
}
