//! Where a body stands in what it should not: what a solution tells of it. It is found in `march/intrusion.rs`.

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
