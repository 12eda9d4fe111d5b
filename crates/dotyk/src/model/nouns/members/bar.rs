//! Bars: bolts, anchors and ties, straight and stiff along themselves alone.
//!
//! ```text
//!   k = EA/L                N any force
//!   tension only            N ≥ 0, and slack where it would push
//!   yields                  |N| ≤ yield · A, with a plastic elongation that stays
//!   both                    0 ≤ N ≤ yield · A, and slack bars keep their plastic elongation
//! ```

use crate::dual::Block;
use crate::model::nouns::member::{Bond, MemberError, MemberWords, Pull, PullLaw};

/// A bar.
#[derive(Debug, Clone, PartialEq)]
pub struct Bar {
    /// Young's modulus.
    pub young: f64,
    /// Cross section of one bar.
    pub area: f64,
    /// The force with which it pulls in the step in which it comes; `None`: it comes without a force.
    pub prestress: Option<f64>,
    /// It bears no compression.
    pub tension_only: bool,
    /// Stress at which it yields.
    pub yields: Option<f64>,
}

pub(crate) const WORDS: MemberWords = MemberWords {
    key: "bar",
    plural: "bars",
    apart: "bar",
    apart_plural: "bars",
    choice: "bond",
};

impl Bar {
    /// A bar that comes without a force, and is elastic both ways.
    pub fn new(young: f64, area: f64) -> Self {
        Self {
            young,
            area,
            prestress: None,
            tension_only: false,
            yields: None,
        }
    }
}

impl Pull for Bar {
    fn check(&self, _: Bond) -> Result<(), MemberError> {
        MemberError::positive("young", self.young)?;
        MemberError::positive("area", self.area)?;
        let yields = self
            .yields
            .map(|stress| MemberError::positive("yield", stress));
        yields.transpose()?;
        let Some(prestress) = self.prestress else {
            return Ok(());
        };
        let wrong = |range| Err(MemberError::number("prestress", prestress, range));
        if !prestress.is_finite() {
            return wrong("a finite number");
        }
        if self.tension_only && prestress < 0.0 {
            return wrong("a tension, as the bar bears no compression");
        }
        match self.strength() {
            Some(most) if prestress.abs() > most => {
                wrong("at most yield times area, else the bar yields while it is tightened")
            }
            _ => Ok(()),
        }
    }

    fn stiffness(&self, count: f64, length: f64) -> f64 {
        count * self.young * self.area / length
    }

    fn law(&self, count: f64) -> PullLaw {
        let half = |most: f64| 0.5 * count * most;
        let (block, offset) = match (self.strength(), self.tension_only) {
            (None, false) => (Block::Free { size: 1 }, 0.0),
            (None, true) => (Block::Unilateral, 0.0),
            (Some(most), false) => (
                Block::Interval {
                    bound: count * most,
                },
                0.0,
            ),
            (Some(most), true) => (Block::Interval { bound: half(most) }, half(most)),
        };
        PullLaw {
            sign: 1.0,
            block,
            offset,
            gap: 0.0,
        }
    }

    fn chosen(&self, bond: Bond) -> &'static str {
        bond.name()
    }

    fn prestress(&self) -> Option<f64> {
        self.prestress
    }

    fn strength(&self) -> Option<f64> {
        self.yields.map(|stress| stress * self.area)
    }

    fn exhausted(&self) -> Option<[&'static str; 2]> {
        self.yields.map(|_| {
            [
                "the strength of the bars",
                "friction, with the strength of the bars,",
            ]
        })
    }

    fn slackens(&self) -> bool {
        self.tension_only && self.yields.is_some()
    }
}
