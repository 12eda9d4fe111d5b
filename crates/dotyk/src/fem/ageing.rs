//! Young's modulus that changes with time, as that of sprayed concrete which hardens: between two load steps
//!
//! ```text
//!   Δσ = C Δ(ε − ε₀),        C of the later step
//! ```
//!
//! so that what was stressed while it was soft keeps this stress, and its strain. In a step the law is
//! σ = C(ε − ε₀ − ε*) + σ₀, and where Young's modulus becomes E′ after E the strain that bears nothing becomes
//!
//! ```text
//!   ε* ← (ε − ε₀) − E/E′ (ε − ε₀ − ε*)
//! ```
//!
//! at the points of integration of the stiffness, where it is kept and acts as plastic strain does (`plastic.rs`): as a load.
//! Poisson's ratio does not change.
//!
//! Source: the elastic law in rates; in practice a smaller constant modulus often stands for it, R. Pöttler, Time-dependent rock–shotcrete
//! interaction, Computers and Geotechnics 9 (1990).

use crate::fem::error::FemError;
use crate::fem::nouns::{Analysis, Body, Elastic, Formulation, Material};
use crate::fem::plastic::{Strained, Yielded, inelastic, points};
use crate::geometry::{Field, Point};

/// How Young's modulus changes with time.
#[derive(Debug, Clone)]
pub struct Ages {
    /// Young's modulus over t, the same all over; in a load step that at its time.
    pub young: Field,
    /// That of the last load step, by which contacts choose the side that carries their multipliers.
    pub last: f64,
}

/// Two functions are equal only if one is a copy of the other.
impl PartialEq for Ages {
    fn eq(&self, other: &Self) -> bool {
        self.last == other.last && self.young.is_copy_of(&other.young)
    }
}

impl Ages {
    /// Young's modulus at a time.
    pub(crate) fn at(&self, time: f64) -> f64 {
        let nowhere: Point<3> = [0.0; 3];
        Field::prepare([&self.young], [nowhere], time);
        self.young.at(nowhere, time)
    }
}

impl Material {
    /// The law in the last load step: sides do not change from step to step.
    pub(crate) fn lasting(&self) -> Elastic {
        let ages = self.ages.as_ref();
        Elastic {
            young: ages.map_or(self.elastic.young, |ages| ages.last),
            ..self.elastic
        }
    }

    /// Sets what a material that ages is at the time of the last load step.
    pub fn age_until(&mut self, last: Option<f64>) {
        if let (Some(ages), Some(last)) = (&mut self.ages, last) {
            ages.last = ages.at(last);
            self.elastic.young = ages.last;
        }
    }

    /// Young's modulus at a time.
    pub(crate) fn young_at(&self, time: f64) -> f64 {
        let ages = self.ages.as_ref();
        ages.map_or(self.elastic.young, |ages| ages.at(time))
    }
}

impl<const D: usize> Body<D> {
    /// Young's modulus of some material of it changes with time.
    pub(crate) fn ages(&self) -> bool {
        self.materials.iter().any(|m| m.ages.is_some())
    }

    /// A copy with these Young's moduli of its materials; with its own for an empty list.
    pub(crate) fn with_moduli(&self, young: &[f64]) -> Self {
        let mut body = self.clone();
        for (material, &young) in body.materials.iter_mut().zip(young) {
            material.elastic.young = young;
        }
        body
    }

    /// Errors: an analysis, formulation or law that cannot be combined with a changing modulus.
    pub(crate) fn check_ages(&self, analysis: Analysis) -> Result<(), FemError> {
        let why = match (self.ages(), analysis, self.formulation) {
            (false, ..) => return Ok(()),
            (_, Analysis::PlaneStress, _) => {
                "in plane stress: use plane strain, axial symmetry or space"
            }
            (_, _, Formulation::Enhanced) => {
                "with `formulation = \"enhanced\"`: use quadratic cells"
            }
            _ if self.is_plastic() => "of a body that yields",
            _ => return Ok(()),
        };
        Err(FemError::Ages { why })
    }

    /// The strains that bear nothing after its moduli have become those of `next`, from those of `before`, under nodal displacements at a
    /// time.
    ///
    /// Errors: a group of cells without a material; an initial strain that is not finite.
    pub(crate) fn aged(
        &self,
        next: &Self,
        analysis: Analysis,
        (displacement, time): (&[Point<D>], f64),
        before: Option<&Yielded>,
    ) -> Result<Yielded, FemError> {
        let mut kept = match before {
            Some(before) => before.clone(),
            None => Yielded::nothing(self, analysis)?,
        };
        for own in points(self, analysis)? {
            let [now, later] = [self, next].map(|body| body.material(own.block));
            let ratio = now?.elastic.young / later?.elastic.young;
            let count = own.cells.table.len();
            let each = kept.0[own.range].chunks_mut(count);
            for (points, cell) in each.zip(own.block.cells()) {
                for (q, point) in points.iter_mut().enumerate() {
                    let here = own.cells.deformation(q, (cell, &[]), displacement);
                    let strain = own.cells.lame.strain(here.gradient, here.hoop);
                    let free = match &self.initial.strain {
                        Some(free) => free.finite_at("initial_strain", here.point, time)?,
                        None => [0.0; 6],
                    };
                    let was = inelastic(point);
                    *point = Strained::default();
                    for c in 0..6 {
                        let all = strain[c] - free[c];
                        point[c] = all - ratio * (all - was[c]);
                    }
                }
            }
        }
        Ok(kept)
    }
}
