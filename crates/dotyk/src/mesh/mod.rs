//! Meshes: points, cell blocks, named sides; structured generators, triangles in an outline, and meshes from files.
//!
//! A [`Mesh`] is checked when it is made and never changed: functions that return a mesh return another one.
//! Indices of points, blocks and cells are counted from zero; a cell is named by its block and its place there.
//!
//! Invariants: every coordinate is finite, every node belongs to a cell, the Jacobian of every cell is positive (plane
//! cells run counter-clockwise), every facet of a side exists. Coincident nodes are not merged.
//! Sides may overlap and need not cover the boundary. Units: lengths, whichever the user chose.

mod basis;
mod cell;
mod check;
mod error;
mod extruded;
mod facets;
mod generate;
mod import;
mod locate;
mod nearest;
mod on_surface;
mod outline;
mod pieces;
mod recipe;
mod reference;
mod shell;
mod sizes;
mod skin;
mod slit;
mod strip;

pub use cell::{CellBlock, MAX_CELL_NODES, MAX_FACET_NODES, drop_repeated};
pub use error::MeshError;
pub use extruded::ExtrudedError;
pub(crate) use extruded::{Axes, direction, extent, levels, profile};
pub use facets::{Chain, FacetTable};
pub(crate) use generate::pieces;
pub use generate::{
    Cuboid, Cylinder, Diagonals, Extrude, Path, Rectangle, Ring, Sphere, TunnelRock,
};
pub(crate) use import::stl::Triangles;
pub use import::{FilePlace, ImportError, Imported, MeshFile};
pub(crate) use locate::{Located, locate, locate_all, locate_on_side};
pub(crate) use outline::GROWTH;
pub use outline::{
    Contour, Division, Drawing, EdgeShape, Outline, OutlineEdge, OutlinePart, OutlinePlace, Region,
    Regions,
};
pub(crate) use pieces::Count;
pub use recipe::{Generator, Recipe};
pub use reference::{CellKind, Domain};
pub(crate) use shell::Segments;
pub use sizes::{SizeField, SizePoint};
pub(crate) use skin::{Bow, SHARP, Skin, Surrounding, divided};
pub use strip::{Cut, Strip, StripError};

use crate::geometry::{Point, Surface, determinant, distance, norm, padded, sub};
use crate::mesh::check::check;
use crate::mesh::nearest::Found;
use crate::mesh::recipe::Added;
use std::collections::BTreeMap;

/// A facet: the `local`-th facet of a cell of a block.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Facet {
    /// Index of the block.
    pub block: u32,
    /// Index of the cell in its block.
    pub cell: u32,
    /// Index into `kind.facets()`.
    pub local: u32,
}

/// A finite-element mesh with named sides.
#[derive(Debug, Clone, PartialEq)]
pub struct Mesh<const D: usize> {
    points: Vec<Point<D>>,
    blocks: Vec<CellBlock>,
    sides: BTreeMap<String, Vec<Facet>>,
    /// The curves behind facets, where the mesh generator knew them.
    curves: BTreeMap<Facet, Surface<D>>,
    recipe: Recipe<D>,
    found: Found<D>,
    /// It is a surface without a body behind it: its sides are its whole boundary.
    shell: bool,
}

impl<const D: usize> Mesh<D> {
    /// A mesh without sides. Cells that are numbered the other way round are turned.
    ///
    /// Errors: no cells; cells of another dimension; a node list that does not divide into cells; coordinates that are
    /// not finite; a node index out of range or repeated in its cell; a cell without volume or folded; a loose node.
    pub fn new(points: Vec<Point<D>>, blocks: Vec<CellBlock>) -> Result<Self, MeshError> {
        Self::assembled(points, blocks, BTreeMap::new(), BTreeMap::new())
    }

    /// A mesh with sides, and the curves behind facets that are known.
    ///
    /// Errors: those of [`Self::new`].
    fn assembled(
        points: Vec<Point<D>>,
        blocks: Vec<CellBlock>,
        sides: BTreeMap<String, Vec<Facet>>,
        curves: BTreeMap<Facet, Surface<D>>,
    ) -> Result<Self, MeshError> {
        Self {
            sides,
            curves,
            ..Self::of_parts(points, blocks)
        }
        .checked()
    }

    /// Nodes and cells that were checked before, without sides.
    fn of_parts(points: Vec<Point<D>>, blocks: Vec<CellBlock>) -> Self {
        Self {
            points,
            blocks,
            sides: BTreeMap::new(),
            curves: BTreeMap::new(),
            recipe: Recipe::default(),
            found: Found::default(),
            shell: false,
        }
    }

    /// The same cells and sides with every point moved to f(point). Under a reflection the cells are turned. The curves behind
    /// facets are lost, and how the mesh was made.
    ///
    /// Errors: as [`Self::new`], where f gives no valid mesh.
    pub fn map_points(mut self, f: impl Fn(Point<D>) -> Point<D>) -> Result<Self, MeshError> {
        self.curves.clear();
        self.recipe = Recipe::default();
        for point in &mut self.points {
            *point = f(*point);
        }
        self.checked()
    }

    /// Checks the mesh, turns cells with the facets of sides and curves, sorts the sides.
    fn checked(mut self) -> Result<Self, MeshError> {
        self.found = Found::default();
        let turned = check(&self.points, &mut self.blocks)?;
        let mirrored: Vec<Vec<u32>> = self
            .blocks
            .iter()
            .map(|block| facets::mirrored(block.kind))
            .collect();
        let follow = |facet: &mut Facet| {
            let block = facet.block as usize;
            if turned[block].binary_search(&facet.cell).is_ok() {
                facet.local = mirrored[block][facet.local as usize];
            }
        };
        for side in self.sides.values_mut() {
            side.iter_mut().for_each(follow);
            side.sort_unstable();
        }
        let curves = std::mem::take(&mut self.curves).into_iter();
        let followed = curves.map(|(mut facet, curve)| {
            follow(&mut facet);
            (facet, curve)
        });
        self.curves = followed.collect();
        Ok(self)
    }

    /// Coordinates of the nodes, (nodes,).
    pub fn points(&self) -> &[Point<D>] {
        &self.points
    }

    /// The blocks of cells.
    pub fn blocks(&self) -> &[CellBlock] {
        &self.blocks
    }

    /// Names of the groups of cells, each once.
    pub fn groups(&self) -> Vec<&str> {
        let mut groups: Vec<&str> = Vec::new();
        for group in self
            .blocks
            .iter()
            .filter_map(|block| block.group.as_deref())
        {
            if !groups.contains(&group) {
                groups.push(group);
            }
        }
        groups
    }

    /// Number of cells of all blocks.
    pub fn cell_count(&self) -> usize {
        self.blocks.iter().map(|block| block.cells().len()).sum()
    }

    /// Number of cells in the blocks before this one.
    pub fn cells_before(&self, block: usize) -> usize {
        let before = self.blocks[..block].iter();
        before.map(|block| block.cells().len()).sum()
    }

    /// Nodes of a cell.
    pub fn cell_nodes(&self, block: usize, cell: usize) -> &[u32] {
        let block = &self.blocks[block];
        let n = block.kind.nodes();
        &block.nodes[n * cell..n * (cell + 1)]
    }

    /// Length of the diagonal of the bounding box.
    pub fn diameter(&self) -> f64 {
        let [low, high] = self.bounds();
        distance(low, high)
    }

    /// Length of the longest straight edge between corners of a cell.
    pub fn longest_edge(&self, block: usize, cell: usize) -> f64 {
        let nodes = self.cell_nodes(block, cell);
        let at = |local: usize| self.points[nodes[local] as usize];
        self.blocks[block]
            .kind
            .corner_edges()
            .iter()
            .enumerate()
            .flat_map(|(corner, ends)| ends.iter().map(move |&end| (corner, end)))
            .map(|(corner, end)| distance(at(corner), at(end)))
            .fold(0.0, f64::max)
    }

    /// Shape of a cell, in [0, 1]: 1 for a square or an equilateral triangle, 0 for a corner of 0° or 180°.
    ///
    /// The smallest over the corners of det(t₁..)/∏|tᵢ| with the tangents tᵢ of the edges there, over that of the regular
    /// cell (at most 1). The middle nodes count through the tangents.
    pub fn cell_quality(&self, block: usize, cell: usize) -> f64 {
        let kind = self.blocks[block].kind;
        let nodes = self.cell_nodes(block, cell);
        let reference = kind.reference_nodes();
        let mut gradients = [[0.0; D]; MAX_CELL_NODES];
        let mut quality: f64 = 1.0;
        for (corner, ends) in kind.corner_edges().iter().enumerate() {
            kind.gradients(&reference[corner], &mut gradients);
            let mut tangents = [[0.0; D]; D];
            for (tangent, &end) in tangents.iter_mut().zip(ends.iter()) {
                let along = sub(reference[end], reference[corner]);
                for (&node, gradient) in nodes.iter().zip(&gradients) {
                    let slope: f64 = gradient.iter().zip(along).map(|(g, a)| g * a).sum();
                    for (t, x) in tangent.iter_mut().zip(self.points[node as usize]) {
                        *t += slope * x;
                    }
                }
            }
            let lengths: f64 = tangents.iter().map(|&t| norm(t)).product();
            let scaled = determinant(&tangents) / (lengths * kind.regular());
            quality = if lengths > 0.0 {
                quality.min(scaled)
            } else {
                0.0
            };
        }
        quality.max(0.0)
    }

    /// The curve behind a facet, if the mesh generator knew it and it is not straight.
    pub fn curve(&self, facet: Facet) -> Option<Surface<D>> {
        self.curves.get(&facet).copied()
    }

    /// The mesh with a surface behind the facets of some sides, too.
    pub(crate) fn with_curve(mut self, sides: &[&str], surface: Surface<D>) -> Self {
        for side in sides {
            let facets = self.sides.get(*side).into_iter().flatten();
            self.curves.extend(facets.map(|&facet| (facet, surface)));
        }
        self
    }

    /// The mesh with curves behind facets.
    pub(crate) fn with_curves(mut self, curves: BTreeMap<Facet, Surface<D>>) -> Self {
        self.curves = curves;
        self
    }

    /// All sides, by name.
    pub fn sides(&self) -> &BTreeMap<String, Vec<Facet>> {
        &self.sides
    }

    /// Facets of a side in ascending order; `None` without such a side.
    pub fn side(&self, name: &str) -> Option<&[Facet]> {
        self.sides.get(name).map(Vec::as_slice)
    }

    /// Names of the sides in alphabetic order.
    pub fn side_names(&self) -> impl Iterator<Item = &str> {
        self.sides.keys().map(String::as_str)
    }

    /// The mesh with one more side: the boundary facets all of whose nodes satisfy `on`. Replaces a side of that name.
    ///
    /// A side without facets is kept: its user can report the name.
    pub fn with_side(mut self, name: &str, on: impl Fn(Point<D>) -> bool) -> Self {
        let on: Vec<bool> = self.points.iter().map(|&point| on(point)).collect();
        let mut facets = self.boundary_facets();
        let all = facets.len();
        facets.retain(|&facet| self.facet_nodes(facet).all(|node| on[node as usize]));
        self.recipe.note(match facets.len() == all {
            true => Added::Boundary(name.to_string()),
            false => Added::Picked(name.to_string()),
        });
        self.sides.insert(name.to_string(), facets);
        self
    }

    /// The mesh with these sides added; facets are sorted and repeated ones dropped.
    ///
    /// Errors: a name that exists already, a facet that does not exist.
    pub fn with_sides(mut self, sides: BTreeMap<String, Vec<Facet>>) -> Result<Self, MeshError> {
        for (side, facets) in sides {
            self.add_side(&side, facets)?;
        }
        Ok(self)
    }

    /// Adds a side of some facets; they are sorted and repeated ones dropped.
    ///
    /// Errors: as [`Self::with_sides`].
    pub fn add_side(&mut self, name: &str, mut facets: Vec<Facet>) -> Result<(), MeshError> {
        let side = name.to_string();
        if let Some(facet) = facets.iter().find(|&&facet| !self.has(facet)) {
            return Err(MeshError::FacetOutOfRange {
                side,
                block: facet.block,
                cell: facet.cell,
                local: facet.local,
            });
        }
        if self.sides.contains_key(name) {
            return Err(MeshError::SideExists { side });
        }
        facets.sort_unstable();
        facets.dedup();
        self.recipe.note(Added::Picked(side.clone()));
        self.sides.insert(side, facets);
        Ok(())
    }

    /// The union of some sides of the mesh, named after all of them; made if it does not exist yet.
    ///
    /// Errors: unknown sides.
    pub fn join_sides(&mut self, sides: &[&str]) -> Result<String, MeshError> {
        let name = sides.join("+");
        if !self.sides.contains_key(&name) {
            let mut facets = Vec::new();
            for side in sides {
                facets.extend(self.side(side).ok_or_else(|| self.unknown_side(side))?);
            }
            facets.sort_unstable();
            facets.dedup();
            let parts = sides.iter().map(|side| side.to_string());
            self.recipe.note(Added::Joined(parts.collect()));
            self.sides.insert(name.clone(), facets);
        }
        Ok(name)
    }

    /// The mesh with one more side: the whole facets of the side `of` whose corners lie in a box, its faces included.
    ///
    /// Coordinates are compared within 1e-9 of the diameter of the mesh, so that a box given in round numbers holds the
    /// nodes that rounding moved.
    /// Errors: unknown side, a name that exists already, no facet in the box.
    pub fn with_patch(
        mut self,
        name: &str,
        of: &str,
        min: Point<D>,
        max: Point<D>,
    ) -> Result<Self, MeshError> {
        let tolerance = 1e-9 * self.diameter();
        let Some(side) = self.sides.get(of) else {
            return Err(self.unknown_side(of));
        };
        if self.sides.contains_key(name) {
            let side = name.to_string();
            return Err(MeshError::SideExists { side });
        }
        let inside = |node: u32| {
            let x = self.points[node as usize];
            (0..D).all(|d| x[d] >= min[d] - tolerance && x[d] <= max[d] + tolerance)
        };
        let facets: Vec<Facet> = side
            .iter()
            .copied()
            .filter(|&facet| {
                let corners = self.facet_kind(facet).corners();
                self.facet_nodes(facet).take(corners).all(inside)
            })
            .collect();
        if facets.is_empty() {
            return Err(MeshError::EmptyPatch {
                patch: name.to_string(),
                of: of.to_string(),
                min: padded(min),
                max: padded(max),
            });
        }
        let patch = Added::patch(&self, [name, of], [min, max], &facets);
        self.recipe.note(patch);
        self.sides.insert(name.to_string(), facets);
        Ok(self)
    }

    /// The error that names a missing side, and the existing ones.
    pub fn unknown_side(&self, side: &str) -> MeshError {
        let names: Vec<&str> = self.side_names().collect();
        MeshError::UnknownSide {
            side: side.to_string(),
            known: match names.len() {
                0 => "no sides".to_string(),
                _ => names.join(", "),
            },
        }
    }

    /// Whether a facet exists.
    fn has(&self, facet: Facet) -> bool {
        self.blocks.get(facet.block as usize).is_some_and(|block| {
            (facet.cell as usize) < block.cells().len()
                && (facet.local as usize) < block.kind.facets().len()
        })
    }
}

#[cfg(test)]
mod tests;
