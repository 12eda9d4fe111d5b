//! Description of one elastic body: material, supports; its loads have a file of their own.

use crate::fem::ageing::Ages;
use crate::fem::couple::Couple;
use crate::fem::cyclic::Cyclic;
use crate::fem::initial::Initial;
use crate::fem::loads::Load;
use crate::fem::plastic::{Plastic, Yielded};
use crate::fem::springs::Spring;
use crate::fem::strength::Strength;
use crate::geometry::{Field, Point, Surface};
use crate::mesh::Mesh;
use std::collections::BTreeMap;
use std::sync::Arc;

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
    /// E/(1 − ν²), the modulus of a plane surface of the material.
    pub fn plane_modulus(&self) -> f64 {
        self.young / (1.0 - self.poisson * self.poisson)
    }
}

/// A material for the cells of one group of the mesh, or for all cells.
#[derive(Debug, Clone, PartialEq)]
pub struct Material {
    /// Cell group that it applies to; `None`: every cell of the body.
    pub group: Option<String>,
    /// The law; of a material that ages that of the load step, in a whole model of the last one.
    pub elastic: Elastic,
    /// How Young's modulus changes with time; `None`: it does not.
    pub ages: Option<Ages>,
    /// Its strength, for the utilisation; it changes no other result, unless the material is plastic.
    pub strength: Option<Strength>,
    /// How it yields where its stress reaches its strength; `None`: it stays elastic.
    pub plastic: Option<Plastic>,
}

/// Where a support holds: a whole side, or the node nearest to a point.
#[derive(Debug, Clone, PartialEq)]
pub enum Place<const D: usize> {
    /// All nodes of a side of the body.
    Side(String),
    /// The nearest node; an error when it is farther than half an edge.
    Point(Point<D>),
}

impl<const D: usize> Place<D> {
    /// The side, if it is one.
    pub fn side(&self) -> Option<&str> {
        match self {
            Self::Side(side) => Some(side),
            Self::Point(_) => None,
        }
    }
}

/// The times when a part is present: from ≤ t < until.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Active {
    /// Its first time.
    pub from: f64,
    /// The time from which on it is gone.
    pub until: f64,
}

impl Active {
    /// From the beginning to the end.
    pub const ALWAYS: Self = Self {
        from: f64::NEG_INFINITY,
        until: f64::INFINITY,
    };

    /// A number that counts as zero at other times.
    pub fn gate(self, field: Field) -> Field {
        if self == Self::ALWAYS || field.as_constant() == Some(0.0) {
            return field;
        }
        let text = match [self.from.is_finite(), self.until.is_finite()] {
            [true, true] => format!("{field} (from t = {} until {})", self.from, self.until),
            [true, false] => format!("{field} (from t = {})", self.from),
            _ => format!("{field} (until t = {})", self.until),
        };
        let inner = field.clone();
        Field::of(&text, [&field], move |x, t| match self.at(t) {
            true => inner.at(x, t),
            false => 0.0,
        })
    }

    /// Whether it is there at a time.
    pub fn at(self, time: f64) -> bool {
        self.from <= time && time < self.until
    }

    /// Whether both are there at some time.
    pub fn meets(self, other: Self) -> bool {
        self.from.max(other.from) < self.until.min(other.until)
    }
}

impl Default for Active {
    fn default() -> Self {
        Self::ALWAYS
    }
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
    /// When it holds. If it comes later than the body it holds nodes at their displacements of that time, and its prescribed
    /// values are added.
    pub active: Active,
}

/// How the cells of a body are made.
///
/// The effect: the deflection of a plate 10 × 10 × 0.5, held at one side and loaded at the opposite one, in cells of 1 × 1 with
/// 1, 2 and 4 of them through the thickness, relative to the exact one (`tests/suite/bending.rs`):
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
/// More linear cells through the thickness do not help, shorter ones do; a warning reports where such cells bend.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Formulation {
    /// By the displacements of their nodes alone.
    #[default]
    Displacement,
    /// quad4 and hex8 with incompatible modes, so that they can bend; other cells as before. Not with axial symmetry.
    Enhanced,
}

/// State of the supports, springs and neighbours of a body that come and go, after load steps.
#[derive(Debug, Clone, Default)]
pub(crate) struct History<const D: usize> {
    /// Supports that came later than the body, by their place among its supports, with the displacements (nodes,) of the
    /// body then.
    pub placed: BTreeMap<usize, Arc<[Point<D>]>>,
    /// Springs that came later than the body, in the same way.
    pub sprung: BTreeMap<usize, Arc<[Point<D>]>>,
    /// Forces (nodes,) of bodies that have gone, each with the remaining part of it at a time.
    pub released: Vec<(Arc<[Point<D>]>, Field)>,
    /// Its plastic strain, `None` without any.
    pub yielded: Option<Arc<Yielded>>,
}

/// A fraction of a step: loads and prescribed displacements are interpolated between those of the time before (zero without a
/// step before) and its own.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Part {
    /// Time of the step before.
    pub before: Option<f64>,
    /// In [0, 1].
    pub share: f64,
}

impl Part {
    /// Values between those of the step before, zero where there was none, and those of the step.
    pub fn mix(self, values: &mut [f64], before: Option<&[f64]>) {
        values.iter_mut().for_each(|value| *value *= self.share);
        let before = values.iter_mut().zip(before.into_iter().flatten());
        before.for_each(|(value, before)| *value += (1.0 - self.share) * before);
    }
}

/// One elastic body.
#[derive(Debug, Clone)]
pub struct Body<const D: usize> {
    /// Unique name.
    pub name: String,
    /// Its mesh with named sides, which copies of it share.
    pub mesh: Arc<Mesh<D>>,
    /// One material for all cells, or one per cell group.
    pub materials: Vec<Material>,
    /// How its cells are made.
    pub formulation: Formulation,
    /// Thickness in plane analyses, > 0.
    pub thickness: f64,
    /// Force per volume.
    pub body_force: [Field; D],
    /// Its initial state.
    pub initial: Initial,
    /// When it is present. It appears free of stress, fitted to its neighbours of that time; its displacements count from there.
    pub active: Active,
    /// The remaining part, at a time after it has gone, of the forces of its contacts on its neighbours; `None`: zero.
    pub release: Option<Field>,
    /// Prescribed displacements.
    pub supports: Vec<Support<D>>,
    /// Springs between it and fixed ground.
    pub springs: Vec<Spring<D>>,
    /// External loads.
    pub loads: Vec<Load<D>>,
    /// Sides that move with a reference point.
    pub couples: Vec<Couple<D>>,
    /// What it is a sector of.
    pub cyclic: Option<Cyclic<D>>,
    /// True surface behind a side, for contact gaps and normals, instead of the one that the mesh may know; `None`: its facets are
    /// the true surface.
    pub surfaces: BTreeMap<String, Option<Surface<D>>>,
    /// Points with a name, on its nodes or not; several have one name where a group of a mesh file says so.
    pub points: BTreeMap<String, Vec<Point<D>>>,
}

impl<const D: usize> Body<D> {
    /// A body of this mesh, of no material yet, that nothing holds or loads.
    pub(crate) fn of(name: &str, mesh: Arc<Mesh<D>>) -> Self {
        Self {
            name: name.to_string(),
            mesh,
            materials: Vec::new(),
            thickness: 1.0,
            body_force: std::array::from_fn(|_| Field::constant(0.0)),
            initial: Initial::default(),
            active: Active::ALWAYS,
            release: None,
            supports: Vec::new(),
            springs: Vec::new(),
            loads: Vec::new(),
            formulation: Formulation::default(),
            couples: Vec::new(),
            cyclic: None,
            surfaces: BTreeMap::new(),
            points: BTreeMap::new(),
        }
    }

    /// Places of supports and springs.
    pub(crate) fn held_places(&self) -> impl Iterator<Item = Place<D>> {
        let supports = self.supports.iter().map(|support| support.place.clone());
        supports.chain(self.springs.iter().map(Spring::place))
    }
}
