//! What contact nodes do: open, stick or slip; and what that leaves unknown of their forces.
//!
//! ```text
//!   open:   λₙ = 0, λₜ = 0
//!   stick:  gapₙ = 0, gapₜ = 0
//!   slip:   gapₙ = 0, λₜ = bound · s,     bound = given + growth · λₙ, see `dual/law.rs`
//! ```
//!
//! The states follow from trial forces z = λ − gap/a with a compliance a: λₙ = max(0, zₙ), and λₜ is zₜ shortened to its
//! bound. A bound that does not follow from λₙ holds in open contacts as well (`dual/law.rs`).
//!
//! *Anchored* conditions ask for gap + a(λ − centre) = 0 in place of gap = 0: those of the problem with F + a, the proximal
//! point step from `centre`. Its matrix is definite whatever F is.
//!
//! The unknowns are the forces that are left: λ = offset + Σ xₐ cₐ, where offset holds given · s, and the column cₐ of the
//! normal force of a slipping node is (1, growth · s). Each is tested by its row wₐ (gap · wₐ + softness · xₐ = right side), which is cₐ but for that node,
//! where only the normal gap counts: such a system is unsymmetric. With two tangents the force across s is an unknown, too,
//! with the linearised law λ = β z across s, β = bound/|z| < 1.
//!
//! As described in Alart & Curnier (1991) and Hüeber, Stadler & Wohlmuth (2008), here on the condensed dual problem.

use std::ops::Range;

use crate::dual::{AdmissibleSet, Block};
use crate::solve::norm;

/// A shear within this part of its bound is at it.
const AT_BOUND: f64 = 1e-7;

/// What the shear of a node does.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Shear {
    /// No slip.
    Stick,
    /// At the bound along `direction` (unit); `share` is the bound over the length of the trial shear, in (0, 1).
    Slip { direction: Vec<f64>, share: f64 },
    /// The bound is zero.
    Smooth,
}

/// State of one block.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct State {
    /// It bears a normal force.
    pub closed: bool,
    /// What its shear does.
    pub shear: Shear,
    /// |z| − bound of the trial, a force: how much the node wants to slip.
    pub excess: f64,
}

impl State {
    /// Closed, without slip where it may stick.
    pub fn sticking(block: &Block, closed: bool) -> Self {
        let smooth = block.friction().is_some_and(|law| law.is_smooth());
        let shear = match smooth {
            true => Shear::Smooth,
            false => Shear::Stick,
        };
        Self {
            closed: closed || block.is_free(),
            shear,
            excess: 0.0,
        }
    }

    /// What forces of a block tell by themselves: a contact with a force is closed, and a shear at its bound slips.
    pub fn of_forces(block: &Block, forces: &[f64]) -> Self {
        let mut trial = forces.to_vec();
        trial[1..].iter_mut().for_each(|t| *t *= 1.0 + AT_BOUND);
        Self::of_trial(block, &trial)
    }

    /// The same of all blocks; λ (m,).
    pub fn of_all_forces(admissible: &AdmissibleSet, lambda: &[f64]) -> Vec<Self> {
        let blocks = admissible.iter();
        let state = |(block, range): (&_, Range<usize>)| Self::of_forces(block, &lambda[range]);
        blocks.map(state).collect()
    }

    /// What trial forces z of a block ask for.
    pub fn of_trial(block: &Block, trial: &[f64]) -> Self {
        let closed = trial[0] > 0.0;
        let mut state = Self::sticking(block, closed);
        let Some(law) = block.friction() else {
            return state;
        };
        if state.shear == Shear::Smooth || !law.bears(closed) {
            return state;
        }
        let (length, bound) = (norm(&trial[1..]), law.bound(trial[0]));
        state.excess = length - bound;
        if length > bound {
            state.shear = Shear::Slip {
                direction: trial[1..].iter().map(|z| z / length).collect(),
                share: bound / length,
            };
        }
        state
    }

    /// It slips in space, where the direction is a part of what is sought.
    pub fn may_turn(&self) -> bool {
        matches!(&self.shear, Shear::Slip { direction, .. } if direction.len() > 1)
    }

    /// Those of all blocks.
    pub fn keys(states: &[Self]) -> Vec<(bool, u8)> {
        states.iter().map(Self::key).collect()
    }

    /// The same state for the purpose of finding one again: directions of slip in space never come back exactly.
    pub fn key(&self) -> (bool, u8) {
        let shear = match &self.shear {
            Shear::Stick => 0,
            Shear::Smooth => 1,
            Shear::Slip { direction, .. } if direction[0] > 0.0 => 2,
            Shear::Slip { .. } => 3,
        };
        (self.closed, shear)
    }
}

/// One unknown of the linear system.
#[derive(Debug, Clone)]
pub(crate) struct Unknown {
    /// cₐ: components of λ that it moves.
    pub force: Vec<(usize, f64)>,
    /// wₐ: gaps that it closes.
    pub row: Vec<(usize, f64)>,
    /// A length over force ≥ 0.
    pub softness: f64,
    /// Right side beyond that of the problem, a length.
    pub pull: f64,
}

impl Unknown {
    /// Component `i` by itself, whose gap closes.
    pub fn of(i: usize) -> Self {
        Self {
            force: vec![(i, 1.0)],
            row: vec![(i, 1.0)],
            softness: 0.0,
            pull: 0.0,
        }
    }

    /// The x for which x c is nearest to the components of `lambda` (m,).
    pub fn nearest(&self, lambda: &[f64]) -> f64 {
        let square: f64 = self.force.iter().map(|(_, weight)| weight * weight).sum();
        along(&self.force, lambda) / square
    }

    /// c and w are the same.
    pub fn is_symmetric(&self) -> bool {
        self.force == self.row
    }
}

/// Product of a short list of components with a vector.
pub(crate) fn along(list: &[(usize, f64)], v: &[f64]) -> f64 {
    list.iter().map(|&(i, weight)| weight * v[i]).sum()
}

/// The forces from which anchored conditions measure, and with which compliance (m,).
#[derive(Clone, Copy)]
pub(crate) struct Anchor<'a> {
    pub centre: &'a [f64],
    pub compliance: &'a [f64],
}

impl Anchor<'_> {
    /// What forces and their gaps (m,) leave of the anchored conditions, gap + a(λ − centre), (m,).
    pub fn left(&self, lambda: &[f64], gap: &[f64]) -> Vec<f64> {
        let apart = lambda.iter().zip(self.centre).map(|(force, c)| force - c);
        let pulls = apart.zip(self.compliance).map(|(apart, a)| a * apart);
        gap.iter()
            .zip(pulls)
            .map(|(gap, pull)| gap + pull)
            .collect()
    }
}

/// The forces that `states` leave unknown, and those that are known (m,).
///
/// `own` (m,) is the compliance of the trial forces, for slip in space.
pub(crate) fn unknowns(
    admissible: &AdmissibleSet,
    states: &[State],
    anchor: Option<Anchor<'_>>,
    own: &[f64],
) -> (Vec<Unknown>, Vec<f64>) {
    let mut offset = vec![0.0; admissible.len()];
    let plain = |i: usize| match anchor {
        Some(Anchor { centre, compliance }) => Unknown {
            softness: compliance[i],
            pull: compliance[i] * centre[i],
            ..Unknown::of(i)
        },
        None => Unknown::of(i),
    };
    let mut unknowns = Vec::new();
    for (state, (block, range)) in states.iter().zip(admissible.iter()) {
        let first = range.start;
        let tangents = first + 1..range.end;
        if block.is_free() {
            unknowns.extend(range.map(plain));
            continue;
        }
        let law = block.friction();
        let (given, growth) = law.map_or((0.0, 0.0), |law| law.terms());
        if state.closed {
            let mut normal = plain(first);
            if let Shear::Slip { direction, .. } = &state.shear
                && growth > 0.0
            {
                let shear = direction.iter().map(|s| growth * s);
                normal.force.extend(tangents.clone().zip(shear));
            }
            unknowns.push(normal);
        }
        if !law.is_some_and(|law| law.bears(state.closed)) {
            continue;
        }
        match &state.shear {
            Shear::Smooth => {}
            Shear::Stick => unknowns.extend(tangents.map(plain)),
            Shear::Slip { direction, share } => {
                for (i, s) in tangents.clone().zip(direction) {
                    offset[i] = given * s;
                }
                across(direction, *share, tangents, anchor, own, &mut unknowns);
            }
        }
    }
    (unknowns, offset)
}

/// Unknown forces across the slip of a node.
fn across(
    direction: &[f64],
    share: f64,
    tangents: Range<usize>,
    anchor: Option<Anchor<'_>>,
    own: &[f64],
    unknowns: &mut Vec<Unknown>,
) {
    for vector in complement(direction) {
        let list: Vec<(usize, f64)> = tangents.clone().zip(vector).collect();
        let (added, pull) = match anchor {
            Some(Anchor { centre, compliance }) => {
                let a = compliance[tangents.start];
                (a, a * along(&list, centre))
            }
            None => (0.0, 0.0),
        };
        let softness = added + own[tangents.start] * (1.0 / share - 1.0).min(1e6);
        unknowns.push(Unknown {
            force: list.clone(),
            row: list,
            softness,
            pull,
        });
    }
}

/// Orthonormal vectors across the unit vector `direction`, by the reflection that turns it into the first axis.
fn complement(direction: &[f64]) -> Vec<Vec<f64>> {
    let mut mirror = direction.to_vec();
    mirror[0] += 1.0_f64.copysign(direction[0]);
    let square: f64 = mirror.iter().map(|x| x * x).sum();
    let reflected = |axis: usize| -> Vec<f64> {
        (0..direction.len())
            .map(|i| f64::from(i == axis) - 2.0 * mirror[axis] * mirror[i] / square)
            .collect()
    };
    (1..direction.len()).map(reflected).collect()
}
