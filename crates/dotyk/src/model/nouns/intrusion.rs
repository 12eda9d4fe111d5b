//! Intrusion of a body into another body or an obstacle, as a solution reports it. It is found in `march/intrusion.rs`.

use crate::dual::Figure;
use crate::fem::{Short, show};
use crate::geometry::Point;

/// Intrusion of a body into another one, or into the obstacle of a contact.
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
    /// Increase of the depth since the beginning, a length > 0.
    pub depth: f64,
    /// The part of it that small displacements and the meshes explain, a length > 0.
    pub allowed: f64,
    /// A contact between the two is named.
    pub named: bool,
    /// Such a contact, if it is not there yet or no longer: this gives a remark only.
    pub waits: Option<String>,
}

impl<const D: usize> Intrusion<D> {
    /// The worst intrusion not explained by an inactive contact.
    pub(crate) fn worst(found: &[Self]) -> Option<Self> {
        let judged = found.iter().filter(|found| found.waits.is_none());
        judged.cloned().reduce(Self::worse)
    }

    /// The figure of the certificate; zero where nothing was found.
    pub(crate) fn figure(found: Option<&Self>) -> Figure {
        let (depth, allowed) = found.map_or((0.0, 0.0), |found| (found.depth, found.allowed));
        Figure::new(depth, allowed, 1.0)
    }

    /// The remark on two bodies whose contact is inactive.
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

    /// The body or obstacle that it enters, in words.
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
