//! How a mesh was made, so that the same body can be meshed anew with other sizes of cells.
//!
//! A mesh keeps its generator with the data of the user: a mesh anew begins with these, not with the cells of the last one, so
//! that it can be finer or coarser. Sides that were joined or cut out afterwards are made again from what defines them. A mesh read
//! from a file, or given cell by cell, has no generator.
//!
//! | Generator | Anew, with a size field h |
//! |---|---|
//! | [`Outline`](crate::mesh::Outline), [`Drawing`] | the same lines; h is one more of their sizes, and counts of cells are the largest lengths of their pieces |
//! | [`Rectangle`](crate::mesh::Rectangle), [`Ring`](crate::mesh::Ring), [`TunnelRock`](crate::mesh::TunnelRock) | triangles in their outline, as many nodes per area as before where h is larger: a lattice can only be refined along whole rows, so that one small place would cost rows of small cells through the whole body |
//! | [`Cuboid`](crate::mesh::Cuboid), [`Cylinder`](crate::mesh::Cylinder), [`Sphere`](crate::mesh::Sphere) | each cell is divided into k³, with the least k that makes all edges at most h in the middle of their cell |
//!
//! The longest edge of a triangle made anew is at most 1.5·h in its middle, as told in `outline.rs`.

use crate::geometry::{Point, add_scaled, bounding_box, distance};
use crate::mesh::{Drawing, Facet, Mesh, MeshError, SizeField};
use std::collections::BTreeMap;
use std::fmt::Debug;
use std::sync::Arc;

/// Makes the mesh of a body from data of the user.
pub trait Generator<const D: usize>: Debug + Send + Sync {
    /// The mesh with its own sizes and those of a field, whichever are smaller; points on its boundary become nodes.
    ///
    /// Errors: too many nodes; a body that cannot be meshed with these sizes.
    fn anew(&self, sizes: &SizeField<D>, nodes: &[Point<D>]) -> Result<Mesh<D>, MeshError>;

    /// The regions of a drawing of which it fills some.
    fn drawing(&self) -> Option<&Drawing> {
        None
    }
}

/// How a mesh was made. Meshes are equal if their cells and sides are, however they were made: all recipes are equal.
#[derive(Debug, Clone, Default)]
pub struct Recipe<const D: usize> {
    /// `None`: from a file, or cell by cell.
    generator: Option<Arc<dyn Generator<D>>>,
    /// Sides that were added afterwards, in this order.
    sides: Vec<Added<D>>,
}

/// A side that was added to those of the generator.
#[derive(Debug, Clone)]
pub(super) enum Added<const D: usize> {
    /// The union of these sides.
    Joined(Vec<String>),
    /// The facets of a side in a box, and the nodes at which it ends.
    Patch {
        name: String,
        of: String,
        bounds: [Point<D>; 2],
        ends: Vec<Point<D>>,
    },
    /// The whole boundary.
    Boundary(String),
    /// Picked by a program.
    Picked(String),
}

impl<const D: usize> Added<D> {
    /// The patch of these facets, cut out of a side with a box. On straight sides its own box counts: smaller facets beyond its ends
    /// are not in it.
    pub fn patch(
        mesh: &Mesh<D>,
        [name, of]: [&str; 2],
        bounds: [Point<D>; 2],
        facets: &[Facet],
    ) -> Self {
        let mut corners = BTreeMap::new();
        for &facet in facets {
            let count = mesh.facet_kind(facet).corners();
            for node in mesh.facet_nodes(facet).take(count) {
                *corners.entry(node).or_insert(0) += 1;
            }
        }
        let at = |node: &u32| mesh.points()[*node as usize];
        let straight = facets.iter().all(|&facet| mesh.curve(facet).is_none());
        let all: Vec<Point<D>> = corners.keys().map(at).collect();
        let ends = corners.iter().filter(|(_, facets)| **facets == 1);
        Self::Patch {
            name: name.to_string(),
            of: of.to_string(),
            bounds: if straight {
                bounding_box(&all).into()
            } else {
                bounds
            },
            ends: ends.map(|(node, _)| at(node)).collect(),
        }
    }
}

impl<const D: usize> PartialEq for Recipe<D> {
    fn eq(&self, _: &Self) -> bool {
        true
    }
}

impl<const D: usize> Recipe<D> {
    /// The mesh made anew: no cell longer than its own recipe and the size field want. Ends of patches and points of `nodes` that
    /// lie on the boundary become nodes.
    ///
    /// Errors: no generator; a side that was picked by a program; as [`Generator::anew`].
    pub fn mesh(&self, sizes: &SizeField<D>, nodes: &[Point<D>]) -> Result<Mesh<D>, MeshError> {
        let generator = self.generator.as_ref().ok_or(MeshError::NoGenerator)?;
        let nodes: Vec<Point<D>> = nodes.iter().copied().chain(self.ends()).collect();
        let mut mesh = generator.anew(sizes, &nodes)?;
        mesh.recipe.generator = Some(Arc::clone(generator));
        for side in &self.sides {
            match side {
                Added::Joined(sides) => {
                    let sides: Vec<&str> = sides.iter().map(String::as_str).collect();
                    mesh.join_sides(&sides)?;
                }
                Added::Patch {
                    name, of, bounds, ..
                } => mesh = mesh.with_patch(name, of, bounds[0], bounds[1])?,
                Added::Boundary(name) => mesh = mesh.with_side(name, |_| true),
                Added::Picked(side) => return Err(MeshError::PickedSide { side: side.clone() }),
            }
        }
        Ok(mesh)
    }

    /// Whether it has a generator.
    pub fn can_be_made_anew(&self) -> bool {
        self.generator.is_some()
    }

    /// The nodes at which its patches end.
    pub(crate) fn ends(&self) -> impl Iterator<Item = Point<D>> + '_ {
        let sides = self.sides.iter();
        let ends = sides.filter_map(|side| match side {
            Added::Patch { ends, .. } => Some(ends),
            _ => None,
        });
        ends.flatten().copied()
    }

    /// Whether both fill regions of one drawing, so that they share the nodes of common lines.
    pub fn shares_drawing(&self, other: &Self) -> bool {
        let [own, others] = [self, other].map(|recipe| recipe.generator.as_ref()?.drawing());
        own.is_some() && own == others
    }

    /// Notes a side that was added to the mesh.
    pub(super) fn note(&mut self, side: Added<D>) {
        if self.generator.is_some() {
            self.sides.push(side);
        }
    }
}

impl<const D: usize> Mesh<D> {
    /// How it was made.
    pub fn recipe(&self) -> &Recipe<D> {
        &self.recipe
    }

    /// The mesh as that of a generator.
    pub(crate) fn made_by(mut self, generator: impl Generator<D> + 'static) -> Self {
        self.recipe.generator = Some(Arc::new(generator));
        self
    }

    /// The middle of the corners of a cell, and the distance of the farthest of them.
    pub(crate) fn middle(&self, block: usize, cell: usize) -> (Point<D>, f64) {
        let corners = self.blocks[block].kind.corners();
        let nodes = &self.cell_nodes(block, cell)[..corners];
        let corners = nodes.iter().map(|&node| self.points[node as usize]);
        let sum = corners
            .clone()
            .fold([0.0; D], |sum, x| add_scaled(sum, 1.0, x));
        let middle = sum.map(|c| c / nodes.len() as f64);
        let radius = corners.map(|x| distance(x, middle)).fold(0.0, f64::max);
        (middle, radius)
    }
}
