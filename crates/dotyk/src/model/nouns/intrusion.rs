//! What stands in what: the deformed outer surfaces of all bodies against each other and against rigid obstacles, whoever named a
//! contact between them.
//!
//! ```text
//!   grown(x) = max(0, −φ(x + u)) − max(0, −φ₀(x))          φ the signed distance from what may be stood in, now and at first
//! ```
//!
//! Conditions of a contact hold between what lay opposite at first, and where a contact is named. Neither tells what becomes of a
//! body that travels, nor of two that no contact keeps apart. So the nodes of every outer surface are looked up in every other
//! body as it has moved; and edges that pass through it, half way between where they come in and go out. What an answer of small
//! displacements may overlap, and no more, is
//!
//! ```text
//!   allowed = 10 × what the meshes of a contact resolve there          dents and bends of the gap, see `between`
//!           + 2 (b₁ + b₂)                          b = hθ/8, how far polygons are off the curves that they stand for, as drawn or
//!                                                  as bent: facets of second order are looked at as polygons; where no contact
//!                                                  is named, of hollow ones alone, whose chords lie in what is beside the body
//!           + s (‖∇u₁‖ + ‖∇u₂‖)                    rotations by angles instead of their sines, over a motion s past each other
//!           + a given clearance that the meshes lack + rounding
//! ```
//!
//! The first and the last but one hold at the sides of contacts alone. The third is of second order in the displacements, as the
//! theory is of first: a body that travels without a strain gets none of it. What lay deeper than it has moved since was drawn
//! so. What lies beside excluded nodes is told by a warning of its own, as is what a contact would hold that is not there. Where
//! a clearance is given, what meshes do no farther than that from the sides, and from what goes on from these without an edge,
//! says nothing. Bodies that are drawn to meet at edges alone have no sides there that a contact could name: what overlaps is
//! narrow by the motion, and is left as long as that is small beside the facets.
//!
//! An obstacle is there for the side that its contact names, and no other: a plane may stand for a punch. Nodes alone can stand in
//! it: the second term does not count, and of the first the tenth part where each node has a condition of its own, and nothing
//! where a node of the side has none. Beside them stands what the normal of the obstacle turns by along the motion.

use crate::dual::Figure;
use crate::fem::{Short, show};
use crate::geometry::Point;

/// Where one body stands in another one, or in the obstacle of a contact.
#[derive(Debug, Clone, PartialEq)]
pub struct Intrusion<const D: usize> {
    /// The body whose node it is.
    pub body: String,
    /// The body that it stands in, or the contact whose obstacle it stands in.
    pub other: String,
    /// It is an obstacle.
    pub obstacle: bool,
    /// Undeformed position of the node.
    pub point: Point<D>,
    /// By how much deeper than at first, a length > 0.
    pub depth: f64,
    /// What small displacements and the meshes explain of that, a length > 0.
    pub allowed: f64,
    /// A contact between the two is named.
    pub named: bool,
    /// Such a contact, where it is not there yet, or no more: who said so is told, and no more.
    pub waits: Option<String>,
}

impl<const D: usize> Intrusion<D> {
    /// The worst of those that no contact explains by its absence.
    pub(crate) fn worst(found: &[Self]) -> Option<Self> {
        let judged = found.iter().filter(|found| found.waits.is_none());
        judged.cloned().reduce(Self::worse)
    }

    /// The figure of the certificate; zero where nothing was found.
    pub(crate) fn figure(found: Option<&Self>) -> Figure {
        let (depth, allowed) = found.map_or((0.0, 0.0), |found| (found.depth, found.allowed));
        Figure::new(depth, allowed, 1.0)
    }

    /// What is told of two bodies whose contact is not there.
    pub(crate) fn remark(&self) -> Option<String> {
        let contact = self.waits.as_ref()?;
        (self.ratio() > 1.0).then(|| {
            format!(
                "body \"{}\" stands {} deep in {} at {}: contact \"{contact}\" between them is not active now",
                self.body,
                Short(self.depth),
                self.what(),
                show(self.point)
            )
        })
    }

    /// What it stands in, in words.
    pub fn what(&self) -> String {
        match self.obstacle {
            true => format!("the obstacle of contact \"{}\"", self.other),
            false => format!("body \"{}\"", self.other),
        }
    }

    pub(crate) fn ratio(&self) -> f64 {
        self.depth / self.allowed
    }

    /// The other one, where that is worse.
    pub(crate) fn worse(self, other: Self) -> Self {
        if other.ratio() > self.ratio() {
            other
        } else {
            self
        }
    }
}
