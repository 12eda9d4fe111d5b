//! What describes one elastic body: material, supports; its loads have a file of their own.

use crate::fem::couple::Couple;
use crate::fem::initial::Initial;
use crate::fem::loads::Load;
use crate::geometry::{Field, Point, Surface};
use crate::mesh::Mesh;
use std::collections::BTreeMap;

/// The kind of analysis; D = 2 for all but [`Analysis::Solid`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Analysis {
    /// Plane strain, per unit thickness unless the body has one.
    PlaneStrain,
    /// Plane stress, per unit thickness unless the body has one.
    PlaneStress,
    /// x = r, y = z; forces for the full 2π.
    Axisymmetric,
    /// Three-dimensional.
    Solid,
}

impl Analysis {
    /// The name in a case file.
    pub fn name(self) -> &'static str {
        match self {
            Self::PlaneStrain => "plane-strain",
            Self::PlaneStress => "plane-stress",
            Self::Axisymmetric => "axisymmetric",
            Self::Solid => "3d",
        }
    }
}

/// Isotropic linear elasticity: Young's modulus (force / area) and Poisson's ratio.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Elastic {
    /// Young's modulus, > 0.
    pub young: f64,
    /// Poisson's ratio, in (−1, 0.5).
    pub poisson: f64,
}

impl Elastic {
    /// E/(1 − ν²), what a plane surface of the material feels.
    pub fn plane_modulus(&self) -> f64 {
        self.young / (1.0 - self.poisson * self.poisson)
    }
}

/// A material for the cells of one group of the mesh, or for all cells.
#[derive(Debug, Clone, PartialEq)]
pub struct Material {
    /// Cell group that it applies to; `None`: every cell of the body.
    pub group: Option<String>,
    /// The law.
    pub elastic: Elastic,
}

/// Where a support holds: a whole side, or the node nearest to a point.
#[derive(Debug, Clone, PartialEq)]
pub enum Place<const D: usize> {
    /// All nodes of a side of the body.
    Side(String),
    /// The nearest node; an error when it is farther than half an edge.
    Point(Point<D>),
}

/// Prescribed displacements.
#[derive(Debug, Clone)]
pub struct Support<const D: usize> {
    /// Where.
    pub place: Place<D>,
    /// Prescribed component along each axis; `None` is free.
    pub components: [Option<Field>; D],
    /// Prescribed displacement along the outward normal (a roller on a side of any orientation).
    pub normal: Option<Field>,
}

/// How the cells of a body are made.
///
/// What it is good for: the deflection of a plate 10 × 10 × 0.5, held at one side and loaded at the opposite one, in cells of
/// 1 × 1 with 1, 2 and 4 of them through the thickness, over the right one (`tests/suite/bending.rs`):
///
/// | cells | 1 | 2 | 4 |
/// |---|---|---|---|
/// | tet4 | 13 % | 18 % | 20 % |
/// | prism6 | 40 % | 43 % | 43 % |
/// | hex8 | 38 % | 40 % | 40 % |
/// | hex8, enhanced | 100 % | 99 % | 98 % |
/// | tet10, hex20, prism15 | 99 % | 99 % | 99 % |
/// | hex27 | 100 % | 100 % | 100 % |
///
/// More linear cells through the thickness do not help, shorter ones do; a warning tells where such cells bend.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Formulation {
    /// By the displacements of their nodes alone.
    #[default]
    Displacement,
    /// quad4 and hex8 with incompatible modes, so that they can bend; other cells as before. Not with axial symmetry.
    Enhanced,
}

/// One elastic body.
#[derive(Debug, Clone)]
pub struct Body<const D: usize> {
    /// Unique name.
    pub name: String,
    /// Its mesh with named sides.
    pub mesh: Mesh<D>,
    /// One material for all cells, or one per cell group.
    pub materials: Vec<Material>,
    /// How its cells are made.
    pub formulation: Formulation,
    /// Thickness in plane analyses, > 0.
    pub thickness: f64,
    /// Force per volume.
    pub body_force: [Field; D],
    /// What is in it before anything acts on it.
    pub initial: Initial,
    /// Prescribed displacements.
    pub supports: Vec<Support<D>>,
    /// External loads.
    pub loads: Vec<Load<D>>,
    /// Sides that move with a reference point.
    pub couples: Vec<Couple<D>>,
    /// True surface behind a side, for contact gaps and normals.
    pub surfaces: BTreeMap<String, Surface<D>>,
    /// Points with a name, on its nodes or not; several have one name where a group of a mesh file says so.
    pub points: BTreeMap<String, Vec<Point<D>>>,
}
