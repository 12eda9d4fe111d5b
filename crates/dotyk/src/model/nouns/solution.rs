//! Results: displacements, stresses, reactions, contact state, certificate.

use crate::dual::Certificate;
use crate::fem::{Borders, CoupleKind, list_motions, principal};
use crate::geometry::{Point, add_scaled, norm};
use crate::model::nouns::dimension::Dimension;
use crate::model::nouns::ids::SideRef;
use crate::model::nouns::intrusion::Intrusion;
use crate::model::nouns::member::{MemberSolution, MemberWords};
use crate::model::nouns::members::by_kind;
use crate::model::nouns::section::SectionSolution;
use std::borrow::Cow;
use std::collections::BTreeMap;
use std::fmt;
use std::sync::Arc;

/// Wall seconds of each stage since the run began, earlier load steps included.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Seconds {
    /// Reading the case and making the meshes.
    pub read: f64,
    /// Stiffness, loads, supports, interfaces.
    pub assemble: f64,
    /// Fill-reducing orderings and symbolic analysis.
    pub order: f64,
    /// Numerical factorisations.
    pub factor: f64,
    /// Compliance F and overlap d on the contact unknowns.
    pub condense: f64,
    /// The contact solver.
    pub contact: f64,
    /// Displacements, stresses, reactions, certificate.
    pub recover: f64,
    /// Writing files.
    pub write: f64,
    /// All of it.
    pub total: f64,
}

/// State of a contact node.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Status {
    /// No force.
    Open,
    /// In contact, frictionless.
    Closed,
    /// In contact, below the friction bound.
    Stick,
    /// In contact, at the friction bound.
    Slip,
    /// Tied.
    Tied,
    /// Its normal displacement is prescribed on both sides: no unknown.
    Fixed,
}

impl Status {
    /// Every state.
    pub const ALL: [Self; 6] = [
        Self::Open,
        Self::Closed,
        Self::Stick,
        Self::Slip,
        Self::Tied,
        Self::Fixed,
    ];

    /// The name in `contact.csv`.
    pub fn name(self) -> &'static str {
        match self {
            Self::Open => "open",
            Self::Closed => "closed",
            Self::Stick => "stick",
            Self::Slip => "slip",
            Self::Tied => "tied",
            Self::Fixed => "fixed",
        }
    }
}

/// One node of a nonmortar side.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ContactNode<const D: usize> {
    /// Index in the nonmortar body's mesh.
    pub node: usize,
    /// Partner node in the mortar body's mesh (node-to-node only).
    pub partner: Option<usize>,
    /// Undeformed position.
    pub point: Point<D>,
    /// Outward unit normal of the nonmortar side.
    pub normal: Point<D>,
    /// ∫ψ of the node's multiplier (area, times thickness or 2πr); all positive.
    pub weight: f64,
    /// Gap after deformation, ≥ 0 open, of a gasket minus its closure; NaN where nothing is opposite.
    pub gap: f64,
    /// Contact pressure λ / weight, ≥ 0 compression; NaN where fixed.
    pub pressure: f64,
    /// Tangential traction ON the nonmortar body in global axes (zero without friction).
    pub shear: Point<D>,
    /// Tangential displacement relative to the mortar body in global axes; NaN where undefined.
    pub slip: Point<D>,
    /// Displacement of the nonmortar side along the normal.
    pub displacement_nonmortar: f64,
    /// Displacement of the mortar side (or obstacle) along the same normal; NaN where nothing is opposite.
    pub displacement_mortar: f64,
    /// State.
    pub status: Status,
}

/// Solution of one contact.
#[derive(Debug, Clone, PartialEq)]
pub struct ContactSolution<const D: usize> {
    /// Name of the contact.
    pub name: String,
    /// The side that carries the multipliers.
    pub nonmortar: SideRef,
    /// The other side; `None` for a rigid obstacle.
    pub mortar: Option<SideRef>,
    /// Nodes of the nonmortar side in the order of the side (along the chain in 2D).
    pub nodes: Vec<ContactNode<D>>,
    /// The chain closes on itself (a full ring).
    pub cyclic: bool,
    /// The side that the model names first; either one where dotyk has chosen the side that carries the multipliers.
    pub first: SideRef,
    /// Force ON the body of that side.
    pub resultant: Point<D>,
    /// Its moment about the origin.
    pub moment: [f64; 3],
    /// Length or area in contact, times thickness or 2πr left out: with axial symmetry the length of the meridian.
    pub length: f64,
    /// Sum of the forces on both sides, relative to the sum of the nodal forces' magnitudes.
    pub imbalance: f64,
    /// The sticking part of the length; with friction.
    pub length_stick: f64,
    /// The slipping part of it.
    pub length_slip: f64,
    /// Displacement of the rigid obstacle; `None` where the other side is that of a body.
    pub obstacle: Option<Point<D>>,
    /// Work that friction dissipated in this step, ≥ 0.
    pub dissipated: f64,
    /// The same since the first step, this one included.
    pub dissipated_total: f64,
}

impl<const D: usize> ContactSolution<D> {
    /// Turns force and moment on the nonmortar body into those on the body of one of its sides.
    pub(crate) fn tell_for(&mut self, side: &SideRef) {
        if *side != self.nonmortar {
            self.resultant = self.resultant.map(|f| -f);
            self.moment = self.moment.map(|m| -m);
        }
        self.first = side.clone();
    }

    /// 1 where the side that carries the multipliers is named first, otherwise −1.
    pub(crate) fn sign(&self) -> f64 {
        if self.first == self.nonmortar {
            1.0
        } else {
            -1.0
        }
    }
}

/// A bed at a point of integration of its side.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BedPoint<const D: usize> {
    /// Undeformed place.
    pub point: Point<D>,
    /// Outward unit normal of the body.
    pub normal: Point<D>,
    /// Its part of the side, times thickness or 2πr.
    pub area: f64,
    /// On the body, ≥ 0 compression; negative where a bed that acts both ways pulls.
    pub pressure: f64,
    /// By how much the body has left a bed that only presses, ≥ 0.
    pub gap: f64,
    /// Tangential traction ON the body.
    pub shear: Point<D>,
    /// The bed presses.
    pub closed: bool,
}

/// The bed of a side: all springs there.
#[derive(Debug, Clone, PartialEq)]
pub struct BedSolution<const D: usize> {
    /// "BODY.SIDE".
    pub name: String,
    /// The side.
    pub side: SideRef,
    /// Its springs along the normal press and do not pull.
    pub compression_only: bool,
    /// Points of integration of its facets, facet by facet.
    pub points: Vec<BedPoint<D>>,
    /// Force ON the body.
    pub resultant: Point<D>,
}

impl<const D: usize> BedSolution<D> {
    /// Area of the side, times thickness or 2πr.
    pub fn area(&self) -> f64 {
        self.points.iter().map(|at| at.area).sum()
    }

    /// The part of it on which the bed presses.
    pub fn closed_area(&self) -> f64 {
        let closed = self.points.iter().filter(|at| at.closed);
        // a sum of nothing would be -0
        closed.fold(0.0, |sum, at| sum + at.area)
    }

    /// Mean of the pressure over the whole side.
    pub fn mean_pressure(&self) -> f64 {
        let forces = self.points.iter().map(|at| at.pressure * at.area);
        forces.sum::<f64>() / self.area()
    }

    /// The point with the largest pressure.
    pub fn largest(&self) -> Option<&BedPoint<D>> {
        let points = self.points.iter();
        points.reduce(|best, next| {
            if next.pressure > best.pressure {
                next
            } else {
                best
            }
        })
    }

    /// The smallest pressure: that of a tension, where a bed pulls.
    pub fn min_pressure(&self) -> f64 {
        let pressures = self.points.iter().map(|at| at.pressure);
        pressures.fold(f64::NAN, f64::min)
    }

    /// The largest gap.
    pub fn max_gap(&self) -> f64 {
        let gaps = self.points.iter().map(|at| at.gap);
        gaps.fold(f64::NAN, f64::max)
    }
}

/// A rigid motion that a body's supports leave free, in words and numbers.
#[derive(Debug, Clone, PartialEq)]
pub struct RigidMode<const D: usize> {
    /// "translation along y", "rotation about (0, 0)", ...
    pub description: String,
    /// Displacement of every node, scaled to largest length 1.
    pub displacement: Vec<Point<D>>,
}

/// Best rigid motion of a body, least squares over its nodes.
#[derive(Debug, Clone, PartialEq)]
pub struct RigidMotion<const D: usize> {
    /// Translation of the centroid of the nodes.
    pub translation: Point<D>,
    /// Rotation about the centroid: one angle in 2D, those about x, y and z in 3D.
    pub rotation: Vec<f64>,
}

/// The point of a couple.
#[derive(Debug, Clone, PartialEq)]
pub struct CoupleSolution<const D: usize> {
    /// Name of the point.
    pub name: String,
    /// How its side moves with it.
    pub kind: CoupleKind,
    /// Where it was.
    pub point: Point<D>,
    /// Its displacement.
    pub displacement: Point<D>,
    /// Its rotation in radians: one angle in 2D, those about x, y and z in 3D; zero with axial symmetry.
    pub rotation: Vec<f64>,
    /// Force of the couple ON the body, for the full turn with axial symmetry.
    pub force: Point<D>,
    /// Moment of the couple ON the body about the point: one number in 2D, three in 3D; zero with axial symmetry.
    pub moment: Vec<f64>,
    /// Force of the supports ON the point; it is in the reaction of the body, too.
    pub reaction: Point<D>,
}

/// Solution of one body.
#[derive(Debug, Clone, PartialEq)]
pub struct BodySolution<const D: usize> {
    /// Name of the body.
    pub name: String,
    /// Displacement of every node; of a body that came in a later step since then.
    pub displacement: Vec<Point<D>>,
    /// For such a body: at every node the displacement of the body to which it was fitted, at that time. Pictures show it there.
    pub fitted: Option<Arc<[Point<D>]>>,
    /// Places of stress and strain: every node, followed by nodes on borders between materials once more for each further material.
    pub borders: Borders,
    /// Stress at every node, and at the further places of `borders`: xx yy zz xy yz xz.
    pub stress: Vec<[f64; 6]>,
    /// Strain there: xx yy zz xy yz xz, tensor components.
    pub strain: Vec<[f64; 6]>,
    /// Von Mises stress there.
    pub von_mises: Vec<f64>,
    /// Force of its supports and springs ON the body at every node (zero where not held).
    pub reactions: Vec<Point<D>>,
    /// Force of all contacts and couples ON the body at every node. With loads, reactions and the forces of members it balances the
    /// internal forces.
    pub contact_forces: Vec<Point<D>>,
    /// Forces of members ON the body, by node.
    pub member_forces: BTreeMap<usize, Point<D>>,
    /// Reactions by the side that is held or bedded.
    pub side_reactions: BTreeMap<String, Point<D>>,
    /// Reactions of the supports of larger sides at the nodes of sides that are parts of them.
    pub part_reactions: BTreeMap<String, Point<D>>,
    /// Rigid motions that its supports leave free.
    pub floating_modes: Vec<RigidMode<D>>,
    /// Best rigid motion.
    pub rigid: RigidMotion<D>,
    /// Sum of the reactions, those at the points of its couples included.
    pub reaction: Point<D>,
    /// The points of its couples, in their order.
    pub couples: Vec<CoupleSolution<D>>,
    /// Elastic energy 1/2 uᵀKu.
    pub strain_energy: f64,
    /// Degrees of freedom, prescribed ones included.
    pub dofs: usize,
    /// Its largest von Mises stress; `None` where no value is finite.
    pub peak: Option<Peak<D>>,
    /// Utilisation of its strength; `None` where no material has a strength.
    pub utilisation: Option<Utilisation<D>>,
    /// Pressure of the water in its pores, by place as the stress; `None` where no water is given.
    pub pore_pressure: Option<Vec<f64>>,
    /// Its yielding; `None` where no material may yield.
    pub yielding: Option<Yielding>,
    /// Strain that bears no stress, plastic or kept by a material that ages, behind it the equivalent plastic one and the change of
    /// volume that the cell does not resist, at the points of integration of the stiffness: cell by cell, block by block. With it a later
    /// run goes on. `None` where there is none.
    pub inelastic: Option<Vec<[f64; 8]>>,
}

/// Yielding of a body.
#[derive(Debug, Clone, PartialEq)]
pub struct Yielding {
    /// Plastic strain at every node, and at the further places of the body's `borders`: xx yy zz xy yz xz, tensor components.
    pub strain: Vec<[f64; 6]>,
    /// Equivalent plastic strain there, the sum of √(2/3 dε:dε) over all steps.
    pub equivalent: Vec<f64>,
    /// The part of the cells around that has yielded in this step, in [0, 1].
    pub share: Vec<f64>,
    /// The part of every cell, in the order of the mesh, that has yielded in this step.
    pub cells: Vec<f64>,
    /// Area with a plastic strain, in space volume; without thickness, with axial symmetry that of the section.
    pub extent: f64,
}

/// Utilisation of the strength of the materials of a body by its stress. The stress is elastic: material beyond its strength
/// would yield or break, and shed stress to its neighbourhood.
#[derive(Debug, Clone, PartialEq)]
pub struct Utilisation<const D: usize> {
    /// At every node, and at the further places of the body's `borders`: 1 is failure, infinite beyond the apex of a criterion; NaN
    /// where no cell has a strength. Between materials of equal elasticity the largest value of theirs.
    pub nodal: Vec<f64>,
    /// Area where it exceeds 1, in space volume; without thickness, with axial symmetry that of the section.
    pub overstressed: f64,
    /// Area, in space volume, of the materials with a strength.
    pub judged: f64,
    /// The largest value; `None` where no value is finite.
    pub peak: Option<Peak<D>>,
}

/// A von Mises stress, or a utilisation, and its node.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StressAt<const D: usize> {
    /// The stress, or the utilisation.
    pub value: f64,
    /// Undeformed place of the node.
    pub at: Point<D>,
}

/// The largest von Mises stress or utilisation of a body.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Peak<const D: usize> {
    /// The stress and its node.
    pub most: StressAt<D>,
    /// Set if it lies within one cell of a place where the theory has no finite stress.
    pub place: Option<SingularPeak<D>>,
}

/// Stresses away from a place where they are not finite.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SingularPeak<const D: usize> {
    /// The place.
    pub place: Singular,
    /// The largest stress farther than two cells from all such places, where there is a node.
    pub away: Option<StressAt<D>>,
    /// The stress exceeded in half a per cent of the body's volume, or the stress away from such places if that is less.
    pub usual: f64,
    /// The part of the volume that does not exceed it.
    pub share: f64,
}

/// A place where linear elasticity has no finite stress: computed values grow there as the mesh is refined.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Singular {
    /// A force at a node.
    PointLoad,
    /// A support at a node, with a force.
    PointSupport,
    /// A corner of more than 180 degrees.
    Corner,
    /// Where a support ends.
    EndOfSupport,
    /// Where a contact ends that bears a force there.
    EndOfContact,
}

impl fmt::Display for Singular {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::PointLoad => "a point load",
            Self::PointSupport => "a point support",
            Self::Corner => "a re-entrant corner",
            Self::EndOfSupport => "the end of a support",
            Self::EndOfContact => "the end of a contact",
        })
    }
}

/// The stress between grains: total stress plus the pressure of the water in the pores, both by place; tension positive.
pub(crate) fn effective_stress(stress: &[[f64; 6]], water: &[f64]) -> Vec<[f64; 6]> {
    let add = |(stress, p): (&[f64; 6], &f64)| {
        std::array::from_fn(|c| stress[c] + if c < 3 { *p } else { 0.0 })
    };
    stress.iter().zip(water).map(add).collect()
}

impl<const D: usize> BodySolution<D> {
    /// Displacement of every node in pictures: plus that of the body to which it was fitted.
    pub fn shown(&self) -> Cow<'_, [Point<D>]> {
        let Some(fitted) = &self.fitted else {
            return Cow::Borrowed(&self.displacement);
        };
        let both = self.displacement.iter().zip(fitted.iter());
        both.map(|(u, fitted)| add_scaled(*u, 1.0, *fitted))
            .collect()
    }

    /// Largest length of the displacement of a node.
    pub fn max_displacement(&self) -> f64 {
        let lengths = self.displacement.iter().map(|&u| norm(u));
        lengths.fold(0.0, f64::max)
    }

    /// The rigid motions that its supports leave free, in words.
    pub fn floating(&self) -> String {
        let modes = self.floating_modes.iter();
        let modes: Vec<String> = modes.map(|mode| mode.description.clone()).collect();
        list_motions::<D>(&modes)
    }

    /// The stress of the cells of a block at one of their nodes.
    pub fn stress_in(&self, block: usize, node: usize) -> [f64; 6] {
        self.stress[self.borders.place(block, node)]
    }

    /// Principal stresses at every node, and at the further places of `borders`, largest first.
    pub fn principal_stress(&self) -> Vec<[f64; 3]> {
        self.stress
            .iter()
            .map(|&stress| principal(stress))
            .collect()
    }
}

/// One line of the convergence history.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HistoryPoint {
    /// Iteration, from 1.
    pub iteration: usize,
    /// Largest relative violation of the optimality conditions at that iterate.
    pub residual: f64,
    /// Contact unknowns with a force.
    pub active: usize,
}

/// A bolt of the p,A-algorithm.
#[derive(Debug, Clone, PartialEq)]
pub struct BoltReport<const D: usize> {
    /// Contact and node that held the bolt.
    pub contact: String,
    /// Undeformed position.
    pub point: Point<D>,
    /// Its force at the limit: negative is tension, that is, improper.
    pub force: f64,
    /// It was moved away from here because it was improper.
    pub moved: bool,
}

/// How the contact problem was solved.
#[derive(Debug, Clone, PartialEq)]
pub struct SolverReport<const D: usize> {
    /// Method that was used (never "auto"), or name of a solver from outside; "given" where forces were given.
    pub method: String,
    /// Stages of Newton's method in the order in which they were entered; the last one answered.
    pub tried: Vec<&'static str>,
    /// Iterations.
    pub iterations: usize,
    /// Products with the compliance F.
    pub products: usize,
    /// Fixed step, where there is one.
    pub rho: Option<f64>,
    /// Convergence history.
    pub history: Vec<HistoryPoint>,
    /// Bolts, in the order in which they were used.
    pub bolts: Vec<BoltReport<D>>,
    /// Where Coulomb's law was solved as a fixed point of problems with given bounds: the factor by which each reduces the
    /// error; below 1 speaks for a unique solution.
    pub contraction: Option<f64>,
}

/// How the bodies were divided into pieces.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Division {
    /// Number of pieces of all bodies; a whole body is one.
    pub subdomains: usize,
    /// Size of the coarse problems: the rigid motions of the pieces of divided bodies.
    pub coarse: usize,
    /// Solutions with every piece of divided bodies so far, earlier load steps included.
    pub iterations: usize,
}

/// Value of a probe.
#[derive(Debug, Clone, PartialEq)]
pub struct ProbeValue {
    /// Name of the probe.
    pub name: String,
    /// The quantity read.
    pub quantity: String,
    /// Its dimension.
    pub dimension: Dimension,
    /// The number; NaN of a line.
    pub value: f64,
    /// The node where the largest or smallest value is (x, y, z; undeformed).
    pub at: Option<[f64; 3]>,
    /// The values along a line; empty where there is one number.
    pub line: Vec<LinePoint>,
}

/// A value on a line.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LinePoint {
    /// Distance from the first point; along a side the length of the path from node to node, with straight gaps between its pieces.
    pub s: f64,
    /// Undeformed place (x, y, z).
    pub point: [f64; 3],
    /// NaN where there is no value.
    pub value: f64,
    /// The side has an end or a sharp corner before it.
    pub starts: bool,
}

/// The answer, with its certificate.
#[derive(Debug, Clone, PartialEq)]
pub struct Solution<const D: usize> {
    /// Time at which loads and supports were taken.
    pub time: f64,
    /// Time of the step at whose end the displacements are zero; `None` where they count from the beginning.
    pub counted_from: Option<f64>,
    /// One per body of the model, in its order.
    pub bodies: Vec<BodySolution<D>>,
    /// One per contact of the model, in its order.
    pub contacts: Vec<ContactSolution<D>>,
    /// One per side with springs, in the order of the bodies and of their springs.
    pub beds: Vec<BedSolution<D>>,
    /// One per member of the model, in its order.
    pub members: Vec<MemberSolution<D>>,
    /// One per section of the model, in its order.
    pub sections: Vec<SectionSolution>,
    /// The figures of the answer, with their limits.
    pub certificate: Certificate,
    /// The intrusion of a deformed body into another one or into an obstacle that is deepest relative to the explained depth.
    pub overlap: Option<Intrusion<D>>,
    /// The certificate holds.
    pub converged: bool,
    /// How it was solved.
    pub solver: SolverReport<D>,
    /// How the bodies were divided.
    pub division: Division,
    /// Warnings to the user.
    pub warnings: Vec<String>,
    /// Values of the model's probes.
    pub probes: Vec<ProbeValue>,
    /// Degrees of freedom of all bodies, prescribed ones included.
    pub dofs: usize,
    /// Number of multipliers.
    pub contact_unknowns: usize,
    /// Threads that were used.
    pub threads: usize,
    /// Wall time by stage.
    pub seconds: Seconds,
}

impl<const D: usize> Solution<D> {
    /// The contact of this name; `None` where it was not there.
    pub fn contact(&self, name: &str) -> Option<&ContactSolution<D>> {
        self.contacts.iter().find(|contact| contact.name == name)
    }

    /// The bed of this side, "BODY.SIDE"; `None` where it was not there.
    pub fn bed(&self, name: &str) -> Option<&BedSolution<D>> {
        self.beds.iter().find(|bed| bed.name == name)
    }

    /// The member of this name; `None` where it was not there.
    pub fn member(&self, name: &str) -> Option<&MemberSolution<D>> {
        self.members.iter().find(|member| member.name == name)
    }

    /// The members of each kind that was there, in the order of all kinds.
    pub fn members_by_kind(&self) -> impl Iterator<Item = (MemberWords, Vec<&MemberSolution<D>>)> {
        by_kind(&self.members, |member| member.kind)
    }

    /// Value of the probe of this name.
    pub fn probe(&self, name: &str) -> Option<f64> {
        let probe = self.probes.iter().find(|probe| probe.name == name)?;
        Some(probe.value)
    }
}
