//! Springs between two places: linear, both ways or one way, with a play.
//!
//! ```text
//!   both                    N = k e
//!   tension                 N = k max(e − gap, 0)
//!   compression             N = −k max(−e − gap, 0)
//! ```

use crate::dual::Block;
use crate::model::nouns::member::{Bond, MemberError, MemberWords, Pull, PullLaw};

/// A spring between two places.
#[derive(Debug, Clone, PartialEq)]
pub struct SpringBetween {
    /// Force of one spring for each length of elongation.
    pub stiffness: f64,
    /// The signs of its force.
    pub acts: Acts,
    /// Play: the motion of the ends, apart in tension, towards each other in compression, without a force.
    pub gap: f64,
}

/// The signs of the force of a spring.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Acts {
    /// Tension and compression.
    #[default]
    Both,
    /// Tension alone.
    Tension,
    /// Compression alone.
    Compression,
}

impl Acts {
    /// All choices.
    pub const ALL: [Self; 3] = [Self::Both, Self::Tension, Self::Compression];

    /// The name in a case file.
    pub fn name(self) -> &'static str {
        match self {
            Self::Both => "both",
            Self::Tension => "tension",
            Self::Compression => "compression",
        }
    }
}

pub(crate) const WORDS: MemberWords = MemberWords {
    key: "spring",
    plural: "springs",
    apart: "spring between",
    apart_plural: "springs between places",
    choice: "acts",
};

impl SpringBetween {
    /// A spring that acts both ways.
    pub fn new(stiffness: f64) -> Self {
        Self {
            stiffness,
            acts: Acts::Both,
            gap: 0.0,
        }
    }
}

impl Pull for SpringBetween {
    fn check(&self, bond: Bond) -> Result<(), MemberError> {
        MemberError::positive("stiffness", self.stiffness)?;
        if !(self.gap >= 0.0 && self.gap.is_finite()) {
            return Err(MemberError::number("gap", self.gap, "zero or positive"));
        }
        if self.acts == Acts::Both && self.gap > 0.0 {
            let message = "its gap has no meaning where it acts both ways";
            let help = "add `acts = \"tension\"` or `acts = \"compression\"`, or leave out `gap`";
            return Err(MemberError::new(
                "gap",
                message,
                "before which force?",
                help,
            ));
        }
        match bond {
            Bond::Ends => Ok(()),
            Bond::Grouted => {
                let message = "a spring is held at its ends alone: it cannot be grouted";
                Err(MemberError::new("", message, "grouted", ""))
            }
        }
    }

    fn stiffness(&self, count: f64, _: f64) -> f64 {
        count * self.stiffness
    }

    fn law(&self, _: f64) -> PullLaw {
        let (sign, block) = match self.acts {
            Acts::Both => (1.0, Block::Free { size: 1 }),
            Acts::Tension => (1.0, Block::Unilateral),
            Acts::Compression => (-1.0, Block::Unilateral),
        };
        PullLaw {
            sign,
            block,
            offset: 0.0,
            gap: self.gap,
        }
    }

    fn chosen(&self, _: Bond) -> &'static str {
        self.acts.name()
    }
}
