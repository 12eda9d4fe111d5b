//! Axes of bodies that are cut along a direction of extrusion: a lining, a wall, a beam in space.
//!
//! Long sides of an extruded body run along one direction a: n·a = 0 for all their normals. Two of these that are not parallel tell
//! it, a ∝ n₁ × n₂; plane sides have but one, and the direction must be told. The first two axes x', y' span the plane of the cuts, so
//! that x' × y' = a: with a along z they are x and y, along x they are y and z, along y they are z and x, else these turned the
//! least. A body ends where a is largest with a face across it, which is its *profile*, a mesh of the plane.

use crate::geometry::{Point, add_scaled, cross, dot, norm, unit};
use crate::mesh::{CellBlock, Facet, Mesh};
use std::collections::{BTreeMap, BTreeSet};

/// Three axes, in the plane those of the coordinates.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Axes<const D: usize>([Point<D>; 3]);

impl<const D: usize> Axes<D> {
    /// x, y, and in space z.
    pub fn of_coordinates() -> Self {
        Self(std::array::from_fn(|i| {
            std::array::from_fn(|j| f64::from(u8::from(i == j)))
        }))
    }

    /// Those of a direction of extrusion in space, a unit vector.
    pub fn along(axis: Point<D>) -> Self {
        let size = |i: &usize| axis[*i].abs();
        let main = (0..D).reduce(|i, j| {
            if size(&j) > (1.0 - ALONG) * size(&i) {
                j
            } else {
                i
            }
        });
        let next = (main.unwrap_or(0) + 1) % D;
        let first: Point<D> = std::array::from_fn(|i| f64::from(u8::from(i == next)));
        let across = add_scaled(first, -dot(first, axis), axis);
        let first = unit(across).unwrap_or(first);
        let second = cross(axis, first);
        Self([first, std::array::from_fn(|i| second[i]), axis])
    }

    /// The direction of extrusion; in the plane zero.
    pub fn axis(&self) -> Point<D> {
        self.0[2]
    }

    /// Components of a point or vector along them.
    pub fn local(&self, point: Point<D>) -> [f64; 3] {
        self.0.map(|axis| dot(axis, point))
    }

    /// The point or vector of these components.
    pub fn global(&self, local: [f64; 3]) -> Point<D> {
        let parts = self.0.into_iter().zip(local);
        parts.fold([0.0; D], |sum, (axis, c)| add_scaled(sum, c, axis))
    }
}

/// Why bodies in space are not those of an extruded strip.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum ExtrudedError {
    /// No direction along both sides.
    #[error(
        "its long sides do not run along one direction: section forces in space are those of extruded bodies"
    )]
    NotExtruded,
    /// Plane sides.
    #[error(
        "its long sides are plane, and run along many directions: `axis` tells that of extrusion"
    )]
    Ambiguous,
    /// Sides across the direction that was told.
    #[error("its long sides do not run along its `axis`")]
    Across,
    /// Bodies of different extents.
    #[error("its bodies end at different places along the direction of extrusion: one from {:.4e} to {:.4e}, another from {:.4e} to {:.4e}", .0[0], .0[1], .1[0], .1[1])]
    Lengths([f64; 2], [f64; 2]),
    /// No face across the direction.
    #[error("a body has no face across the direction of extrusion at its end, {0:.4e} along it")]
    NoFace(f64),
    /// A long side with openings.
    #[error("the {} of its long sides has openings between its ends, {:.1} % of it: forces at `places` along the axis are those of bodies without", ["first", "second"][*side], 100.0 * part)]
    Openings {
        /// Which one.
        side: usize,
        /// The part of it that is missing.
        part: f64,
    },
    /// Places closer than cells.
    #[error(
        "its places along the direction of extrusion are {step:.4e} apart, and cells are up to {cells:.4e} long there"
    )]
    Finer {
        /// Between two places.
        step: f64,
        /// The longest facet of the long sides along the axis.
        cells: f64,
    },
}

/// Sine of the angle up to which a facet runs along a direction, and between normals that tell one: nodes of files have few digits.
const ALONG: f64 = 1e-3;

/// Components of a direction below this are rounding.
const ROUNDING: f64 = 1e-12;

/// Nodes nearer to the end of a body than this part of its size lie on it.
const AT_END: f64 = 1e-6;

/// The direction along which facets run, or the one that was told; each mesh with facets of its own.
///
/// Errors: facets that do not run along one direction, or along all directions of a plane.
pub fn direction<const D: usize>(
    sides: &[(&Mesh<D>, &[Facet])],
    told: Option<Point<D>>,
) -> Result<Point<D>, ExtrudedError> {
    let facets = sides.iter().flat_map(|(mesh, facets)| {
        let facets = facets.iter();
        facets.flat_map(|&facet| normals(mesh, facet))
    });
    let normals: Vec<Point<D>> = facets.collect();
    let across = |axis: Point<D>| normals.iter().any(|n| dot(*n, axis).abs() > ALONG);
    if let Some(axis) = told {
        return match across(axis) {
            true => Err(ExtrudedError::Across),
            false => Ok(axis),
        };
    }
    let first = *normals.first().ok_or(ExtrudedError::NotExtruded)?;
    let products = normals.iter().map(|n| cross(first, *n));
    let largest = products.max_by(|a, b| norm(*a).total_cmp(&norm(*b)));
    let product = largest.unwrap_or([0.0; 3]);
    if norm(product) <= ALONG {
        return Err(ExtrudedError::Ambiguous);
    }
    let axis: Point<D> = std::array::from_fn(|i| product[i] / norm(product));
    if across(axis) {
        return Err(ExtrudedError::NotExtruded);
    }
    // its largest component is positive
    let larger = |a: f64, b: f64| {
        if b.abs() > (1.0 - ALONG) * a.abs() {
            b
        } else {
            a
        }
    };
    let main = axis.into_iter().reduce(larger).unwrap_or(1.0);
    Ok(axis.map(|c| {
        if c.abs() < ROUNDING {
            0.0
        } else {
            c * main.signum()
        }
    }))
}

/// Unit normals of a facet at its corners.
fn normals<const D: usize>(mesh: &Mesh<D>, facet: Facet) -> impl Iterator<Item = Point<D>> + '_ {
    let kind = mesh.facet_kind(facet);
    let corners = kind.reference_nodes()[..kind.corners()].iter();
    corners.filter_map(move |xi| unit(mesh.outward_normal(facet, xi)))
}

/// The least and the largest component of points along a direction.
fn range<const D: usize>(points: impl Iterator<Item = Point<D>>, axis: Point<D>) -> [f64; 2] {
    let along = points.map(|point| dot(point, axis));
    along.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], x| {
        [low.min(x), high.max(x)]
    })
}

/// Extent of a mesh along a direction.
pub fn extent<const D: usize>(mesh: &Mesh<D>, axis: Point<D>) -> [f64; 2] {
    range(mesh.points().iter().copied(), axis)
}

/// The levels of the nodes of facets along a direction, where each facet goes from one of them to the next; else the longest facet.
pub fn levels<const D: usize>(
    sides: &[(&Mesh<D>, &[Facet])],
    axis: Point<D>,
) -> Result<Vec<f64>, f64> {
    let facets = || {
        let all = sides.iter();
        all.flat_map(|(mesh, facets)| facets.iter().map(move |&facet| (*mesh, facet)))
    };
    let corners = |(mesh, facet): (&'_ Mesh<D>, Facet)| {
        let count = mesh.facet_kind(facet).corners();
        let points: Vec<Point<D>> = mesh.facet_points(facet).take(count).collect();
        points
    };
    let ranges: Vec<[f64; 2]> = facets()
        .map(|of| range(corners(of).into_iter(), axis))
        .collect();
    let longest = ranges.iter().fold(0.0, |most: f64, [a, b]| most.max(b - a));
    let mut levels: Vec<f64> = ranges.as_flattened().to_vec();
    levels.sort_by(f64::total_cmp);
    levels.dedup_by(|b, a| *b - *a <= AT_END * longest);
    let level = |at: f64| levels.partition_point(|level| *level < at - 0.5 * AT_END * longest);
    match ranges.iter().all(|[a, b]| level(*b) <= level(*a) + 1) {
        true => Ok(levels),
        false => Err(longest),
    }
}

/// The profile of a body: its face at the end of its extent along the third axis, with the sides that begin there.
///
/// Errors: no such face.
pub fn profile<const D: usize>(mesh: &Mesh<D>, axes: &Axes<D>) -> Result<Mesh<2>, ExtrudedError> {
    let [_, end] = extent(mesh, axes.axis());
    let tolerance = AT_END * mesh.diameter();
    let at_end: Vec<bool> = {
        let points = mesh.points().iter();
        points
            .map(|point| end - dot(*point, axes.axis()) <= tolerance)
            .collect()
    };
    let on_face = |facet: &Facet| mesh.facet_nodes(*facet).all(|node| at_end[node as usize]);
    let mut names: BTreeMap<u32, u32> = BTreeMap::new();
    let mut points: Vec<Point<2>> = Vec::new();
    let mut blocks: Vec<CellBlock> = Vec::new();
    for facet in mesh.boundary_facets().into_iter().filter(on_face) {
        let kind = mesh.facet_kind(facet);
        let nodes = mesh.facet_nodes(facet).map(|node| {
            *names.entry(node).or_insert_with(|| {
                let [x, y, _] = axes.local(mesh.points()[node as usize]);
                points.push([x, y]);
                points.len() as u32 - 1
            })
        });
        let nodes: Vec<u32> = nodes.collect();
        match blocks.iter_mut().find(|block| block.kind == kind) {
            Some(block) => block.nodes.extend(nodes),
            None => blocks.push(CellBlock {
                kind,
                nodes,
                group: None,
            }),
        }
    }
    let no_face = ExtrudedError::NoFace(end);
    let plane = Mesh::new(points, blocks).map_err(|_| no_face.clone())?;
    let boundary = plane.boundary_facets();
    let mut sides: BTreeMap<String, Vec<Facet>> = BTreeMap::new();
    for (name, facets) in mesh.sides() {
        let mut edges: BTreeSet<[u32; 2]> = BTreeSet::new();
        for &facet in facets.iter().filter(|facet| !on_face(facet)) {
            let corners = mesh.facet_kind(facet).corners();
            let nodes = mesh.facet_nodes(facet).take(corners);
            let own: Vec<u32> = nodes.filter_map(|node| names.get(&node).copied()).collect();
            if let [a, b] = own[..] {
                edges.insert([a.min(b), a.max(b)]);
            }
        }
        let own = boundary.iter().copied().filter(|&facet| {
            let mut ends = plane.facet_nodes(facet);
            match (ends.next(), ends.next()) {
                (Some(a), Some(b)) => edges.contains(&[a.min(b), a.max(b)]),
                _ => false,
            }
        });
        let own: Vec<Facet> = own.collect();
        if !own.is_empty() {
            sides.insert(name.clone(), own);
        }
    }
    plane.with_sides(sides).map_err(|_| no_face)
}
