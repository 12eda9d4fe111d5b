//! States of contact nodes (open, stick or slip), and the forces that these leave unknown.
//!
//! ```text
//!   open:   λₙ = 0, λₜ = 0
//!   stick:  gapₙ = 0, gapₜ = 0
//!   slip:   gapₙ = 0, λₜ = bound · s,     bound = given + growth · λₙ
//! ```
//!
//! An interval is a shear by itself: it sticks or slips, and counts as closed.
//!
//! The states follow from trial forces z = λ − gap/a with a compliance a: λₙ = max(0, zₙ), and λₜ is zₜ shortened to its
//! bound. A bound that does not follow from λₙ holds in open contacts as well. Given and growth are those of the line that touches
//! the bound at zₙ (`dual/law.rs`): it is the bound itself, or a step is one of Newton's method on a bound that bends.
//!
//! *Anchored* conditions ask for gap + a(λ − centre) = 0 in place of gap = 0: those of the problem with F + a, the proximal
//! point step from `centre`. Its matrix is definite whatever F is.
//!
//! The unknowns xₐ are the remaining forces: λ = offset + Σ xₐ cₐ, where offset holds given · s, and the column cₐ of the
//! normal force of a slipping node is (1, growth · s). Each has a condition with the row wₐ (gap · wₐ + softness · xₐ = right side).
//! wₐ equals cₐ except for that normal force, where only the normal gap counts: such a system is unsymmetric. With two tangents the
//! force across s is an unknown, too, with the linearised law λ = β z across s, β = bound/|z| < 1.
//!
//! As described in Alart & Curnier (1991) and Hüeber, Stadler & Wohlmuth (2008), here on the condensed dual problem.

use std::ops::Range;

use crate::dual::{AdmissibleSet, Block};
use crate::solve::norm;

/// A shear within this part of its bound is at it.
const AT_BOUND: f64 = 1e-7;

/// The part to which a residual must fall while directions of slip turn, and while bounds bend.
const TURNING: f64 = 0.5;
const BENDING: f64 = 1.0;

/// State of the shear of a node.
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
    /// State of its shear.
    pub shear: Shear,
    /// |z| − bound of the trial, a force: the excess shear.
    pub excess: f64,
    /// The normal force at which a line touches the bound, ≥ 0.
    pub normal: f64,
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
            closed: closed || !block.is_normal(),
            shear,
            excess: 0.0,
            normal: 0.0,
        }
    }

    /// The state from the forces of a block alone: a contact with a force is closed, and a shear at its bound slips.
    pub fn of_forces(block: &Block, forces: &[f64]) -> Self {
        let mut trial = forces.to_vec();
        let sheared = block.shear(&(0..trial.len()));
        trial[sheared].iter_mut().for_each(|t| *t *= 1.0 + AT_BOUND);
        Self::of_trial(block, &trial)
    }

    /// The same of all blocks; λ (m,).
    pub fn of_all_forces(admissible: &AdmissibleSet, lambda: &[f64]) -> Vec<Self> {
        let blocks = admissible.iter();
        let state = |(block, range): (&_, Range<usize>)| Self::of_forces(block, &lambda[range]);
        blocks.map(state).collect()
    }

    /// The state from trial forces z of a block.
    pub fn of_trial(block: &Block, trial: &[f64]) -> Self {
        let closed = trial[0] > 0.0;
        let mut state = Self::sticking(block, closed);
        let Some(law) = block.friction() else {
            return state;
        };
        if state.shear == Shear::Smooth || !law.bears(closed) {
            return state;
        }
        let sheared = &trial[block.shear(&(0..trial.len()))];
        let (length, bound) = (norm(sheared), law.bound(trial[0]));
        state.excess = length - bound;
        state.normal = trial[0].max(0.0);
        if length > bound {
            state.shear = Shear::Slip {
                direction: sheared.iter().map(|z| z / length).collect(),
                share: bound / length,
            };
        }
        state
    }

    /// Steps from states that repeat themselves lead on to other forces where a node slips in space, as the direction is unknown, too,
    /// or at a bound that bends: to what part the residual must fall for them to go on. Zero where they lead nowhere.
    pub fn turning(states: &[Self], admissible: &AdmissibleSet) -> f64 {
        let blocks = states.iter().zip(admissible.blocks());
        let parts = blocks.map(|(state, block)| match &state.shear {
            Shear::Slip { direction, .. } => match block.friction() {
                Some(law) if law.touch(0.0).bend != 0.0 => BENDING,
                _ if direction.len() > 1 => TURNING,
                _ => 0.0,
            },
            _ => 0.0,
        });
        parts.fold(0.0, f64::max)
    }

    /// Whether contacts open from these states to the next, and nothing else happens.
    pub fn only_open(these: &[Self], next: &[Self]) -> bool {
        let mut changed = these.iter().zip(next).filter(|(a, b)| a.key() != b.key());
        changed.all(|(before, after)| before.closed && !after.closed)
    }

    /// Those of all blocks.
    pub fn keys(states: &[Self]) -> Vec<(bool, u8)> {
        states.iter().map(Self::key).collect()
    }

    /// The state without the direction of slip, for comparison: directions in space never come back exactly.
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
    /// Residuals of the anchored conditions, gap + a(λ − centre), (m,).
    pub fn left(&self, lambda: &[f64], gap: &[f64]) -> Vec<f64> {
        let apart = lambda.iter().zip(self.centre).map(|(force, c)| force - c);
        let pulls = apart.zip(self.compliance).map(|(apart, a)| a * apart);
        gap.iter()
            .zip(pulls)
            .map(|(gap, pull)| gap + pull)
            .collect()
    }
}

/// The unknown forces of `states`, and the known ones (m,).
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
        let tangents = block.shear(&range);
        if block.is_free() {
            unknowns.extend(range.map(plain));
            continue;
        }
        let law = block.friction();
        let touch = law.map(|law| law.touch(state.normal));
        let (given, growth) = touch.map_or((0.0, 0.0), |touch| (touch.given, touch.growth));
        if state.closed && block.is_normal() {
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::dual::Friction;

    const COULOMB: Friction = Friction::Coulomb { coefficient: 0.5 };
    const TRESCA: Friction = Friction::Tresca { bound: 2.0 };
    const COHESIVE: Friction = Friction::Cohesive {
        cohesion: 1.0,
        coefficient: 0.5,
    };

    fn slip(direction: &[f64], share: f64) -> Shear {
        let direction = direction.to_vec();
        Shear::Slip { direction, share }
    }

    #[test]
    fn contacts_only_open_if_none_closes_and_no_shear_changes() {
        let block = COULOMB.block(1);
        let [closed, open] = [true, false].map(|closed| State::sticking(&block, closed));
        let slips = State::of_trial(&block, &[4.0, -2.5]);
        let both = [closed.clone(), closed.clone()];
        let only_open = |next: [&State; 2]| State::only_open(&both, &next.map(State::clone));
        assert!(only_open([&open, &closed]) && only_open([&closed, &closed]));
        assert!(!only_open([&open, &slips]));
        assert!(!State::only_open(
            &[open.clone(), closed.clone()],
            &[closed, open]
        ));
    }

    #[test]
    fn trial_forces_tell_open_stick_and_slip_of_every_law() {
        let state = |block: Block, trial: &[f64]| State::of_trial(&block, trial);
        // pressed by 4: the bound of Coulomb's law is 2
        let stick = state(COULOMB.block(1), &[4.0, -1.5]);
        assert_eq!(
            (stick.closed, &stick.shear, stick.excess),
            (true, &Shear::Stick, -0.5)
        );
        let at_bound = state(COULOMB.block(1), &[4.0, 2.0]);
        assert_eq!((at_bound.shear, at_bound.excess), (Shear::Stick, 0.0));
        let slips = state(COULOMB.block(1), &[4.0, -2.5]);
        assert_eq!((slips.shear, slips.excess), (slip(&[-1.0], 0.8), 0.5));
        let space = state(COULOMB.block(2), &[4.0, 3.0, -4.0]);
        assert_eq!((space.shear, space.excess), (slip(&[0.6, -0.8], 0.4), 3.0));
        let open = state(COULOMB.block(1), &[-4.0, 9.0]);
        assert_eq!(
            (open.closed, open.shear, open.excess),
            (false, Shear::Stick, 0.0)
        );
        // zero is no force
        assert!(!state(COULOMB.block(1), &[0.0, 1.0]).closed);
        // a given bound holds in open contacts, too
        let open = state(TRESCA.block(1), &[-1.0, 2.5]);
        assert_eq!(
            (open.closed, open.shear, open.excess),
            (false, slip(&[1.0], 0.8), 0.5)
        );
        let cohesive = state(COHESIVE.block(1), &[4.0, 6.0]);
        assert_eq!((cohesive.shear, cohesive.excess), (slip(&[1.0], 0.5), 3.0));
        assert_eq!(state(COHESIVE.block(1), &[-4.0, 6.0]).shear, Shear::Stick);
        let smooth = state(Friction::Tresca { bound: 0.0 }.block(1), &[1.0, 5.0]);
        assert_eq!((smooth.shear, smooth.excess), (Shear::Smooth, 0.0));
        // a tie is always closed
        let tied = state(Block::Free { size: 2 }, &[-1.0, 3.0]);
        assert_eq!((tied.closed, tied.shear), (true, Shear::Stick));
        assert!(!state(Block::Unilateral, &[-1.0]).closed);
    }

    #[test]
    fn shear_of_forces_that_is_at_its_bound_slips() {
        let block = COULOMB.block(1);
        let of = |shear: f64| State::of_forces(&block, &[4.0, shear]).shear;
        assert!(matches!(of(2.0 * (1.0 - 0.9e-7)), Shear::Slip { .. }));
        assert_eq!(of(2.0 * (1.0 - 1.1e-7)), Shear::Stick);
        let set = AdmissibleSet::new(vec![Block::Unilateral, block]);
        let states = State::of_all_forces(&set, &[0.0, 4.0, -2.0]);
        assert_eq!(State::keys(&states), [(false, 0), (true, 3)]);
    }

    #[test]
    fn states_are_told_apart_by_what_they_do_and_which_way_they_slip() {
        let state = |closed, shear| State {
            closed,
            shear,
            excess: 7.0,
            normal: 0.0,
        };
        assert_eq!(state(true, Shear::Stick).key(), (true, 0));
        assert_eq!(state(false, Shear::Smooth).key(), (false, 1));
        assert_eq!(state(true, slip(&[0.6, -0.8], 0.5)).key(), (true, 2));
        assert_eq!(state(true, slip(&[-1.0], 0.5)).key(), (true, 3));
        assert_eq!(state(true, slip(&[0.0, 1.0], 0.5)).key(), (true, 3));
        let turning = |tangents: usize, shear: Shear| {
            let set = AdmissibleSet::new(vec![Block::Unilateral, COULOMB.block(tangents)]);
            State::turning(&[state(true, Shear::Stick), state(true, shear)], &set)
        };
        assert_eq!(turning(2, slip(&[0.6, 0.8], 0.5)), TURNING);
        assert_eq!(
            [turning(1, slip(&[1.0], 0.5)), turning(2, Shear::Stick)],
            [0.0; 2]
        );
        let smooth = Friction::Coulomb { coefficient: 0.0 }.block(1);
        let sticking = State::sticking(&smooth, true);
        assert_eq!((sticking.shear, sticking.excess), (Shear::Smooth, 0.0));
        assert!(State::sticking(&Block::Free { size: 1 }, false).closed);
        assert!(!State::sticking(&Block::Unilateral, false).closed);
    }

    /// Forces, rows, softness and pull of unknowns as plain lists.
    type Plain = (Vec<(usize, f64)>, Vec<(usize, f64)>, f64, f64);

    fn plain(unknowns: &[Unknown]) -> Vec<Plain> {
        let one = |u: &Unknown| (u.force.clone(), u.row.clone(), u.softness, u.pull);
        unknowns.iter().map(one).collect()
    }

    #[test]
    fn states_leave_the_unknowns_of_the_table() {
        let blocks = vec![
            Block::Unilateral,
            Block::Free { size: 2 },
            COULOMB.block(1),
            COHESIVE.block(1),
            TRESCA.block(1),
            TRESCA.block(1),
            COULOMB.block(1),
            Friction::Tresca { bound: 0.0 }.block(1),
        ];
        let set = AdmissibleSet::new(blocks);
        let state = |closed, shear| State {
            closed,
            shear,
            excess: 0.0,
            normal: 0.0,
        };
        let states = vec![
            state(false, Shear::Stick),
            state(true, Shear::Stick),
            state(true, slip(&[-1.0], 0.5)),
            state(true, slip(&[1.0], 0.5)),
            state(false, slip(&[-1.0], 0.5)),
            state(false, Shear::Stick),
            state(false, slip(&[1.0], 0.5)),
            state(true, Shear::Smooth),
        ];
        let (list, offset) = unknowns(&set, &states, None, &[9.0; 15]);
        let one = |i: usize| (vec![(i, 1.0)], vec![(i, 1.0)], 0.0, 0.0);
        let expected = vec![
            one(1),
            one(2),
            // a slipping normal force brings its shear along, and closes the normal gap alone
            (vec![(3, 1.0), (4, -0.5)], vec![(3, 1.0)], 0.0, 0.0),
            (vec![(5, 1.0), (6, 0.5)], vec![(5, 1.0)], 0.0, 0.0),
            // open nodes with a given bound stick or slip
            one(10),
            one(13),
        ];
        assert_eq!(plain(&list), expected);
        let mut known = [0.0; 15];
        (known[6], known[8]) = (1.0, -2.0);
        assert_eq!(offset, known);
        assert!(list[0].is_symmetric() && !list[2].is_symmetric());
    }

    #[test]
    fn anchored_conditions_have_the_compliance_and_the_pull_of_the_centre() {
        let set = AdmissibleSet::new(vec![COULOMB.block(1); 2]);
        let (centre, compliance) = ([3.0, -1.0, 2.0, 4.0], [0.5, 0.25, 2.0, 1.0]);
        let anchor = Anchor {
            centre: &centre,
            compliance: &compliance,
        };
        let states = vec![
            State::sticking(&set.blocks()[0], true),
            State {
                closed: true,
                shear: slip(&[1.0], 0.5),
                excess: 0.0,
                normal: 0.0,
            },
        ];
        let (list, offset) = unknowns(&set, &states, Some(anchor), &[1.0; 4]);
        let one = |i: usize, softness, pull| (vec![(i, 1.0)], vec![(i, 1.0)], softness, pull);
        let slipping = (vec![(2, 1.0), (3, 0.5)], vec![(2, 1.0)], 2.0, 4.0);
        assert_eq!(
            plain(&list),
            [one(0, 0.5, 1.5), one(1, 0.25, -0.25), slipping]
        );
        assert_eq!(offset, [0.0; 4]);
        // gap + a(λ − centre)
        let left = anchor.left(&[4.0, 0.0, 1.0, 2.0], &[0.1, 0.2, 0.3, 0.4]);
        let expected = [0.1 + 0.5, 0.2 + 0.25, 0.3 - 2.0, 0.4 - 2.0];
        for (left, expected) in left.iter().zip(expected) {
            assert!((left - expected).abs() < 1e-15);
        }
    }

    #[test]
    fn force_across_the_slip_of_space_is_as_soft_as_the_linearised_law() {
        let set = AdmissibleSet::new(vec![COULOMB.block(2)]);
        let states = |share| {
            vec![State {
                closed: true,
                shear: slip(&[0.6, -0.8], share),
                excess: 0.0,
                normal: 0.0,
            }]
        };
        let own = [5.0, 3.0, 3.0];
        let (list, _) = unknowns(&set, &states(0.25), None, &own);
        assert_eq!(list.len(), 2);
        assert_eq!(list[0].force, [(0, 1.0), (1, 0.3), (2, -0.4)]);
        let across = &list[1];
        assert!(across.is_symmetric() && across.pull == 0.0);
        let [(1, a), (2, b)] = across.force[..] else {
            panic!("{:?}", across.force);
        };
        assert!((0.6 * a - 0.8 * b).abs() < 1e-15 && (a * a + b * b - 1.0).abs() < 1e-15);
        // c (1/β − 1) with β = 1/4
        assert!((across.softness - 9.0).abs() < 1e-14);
        // a bound that is negligible beside its trial leaves a finite number
        let (list, _) = unknowns(&set, &states(1e-9), None, &own);
        assert_eq!(list[1].softness, 3e6);
        let (list, _) = unknowns(&set, &states(1e-5), None, &own);
        assert!((list[1].softness - 3.0 * 99_999.0).abs() < 1e-6);
        let (centre, compliance) = ([1.0, 2.0, 4.0], [0.5, 0.25, 0.25]);
        let anchor = Anchor {
            centre: &centre,
            compliance: &compliance,
        };
        let (list, _) = unknowns(&set, &states(0.25), Some(anchor), &own);
        assert!((list[1].softness - 9.25).abs() < 1e-14);
        assert!((list[1].pull - 0.25 * (2.0 * a + 4.0 * b)).abs() < 1e-14);
    }

    #[test]
    fn complement_is_orthonormal_for_directions_of_either_sign() {
        for direction in [
            [0.6, 0.8, 0.0],
            [-0.6, 0.0, 0.8],
            [-1.0, 0.0, 0.0],
            [0.0, 0.0, 1.0],
        ] {
            let found = complement(&direction);
            assert_eq!(found.len(), 2);
            let all = [direction.to_vec(), found[0].clone(), found[1].clone()];
            for (i, a) in all.iter().enumerate() {
                for (j, b) in all.iter().enumerate() {
                    let product: f64 = a.iter().zip(b).map(|(a, b)| a * b).sum();
                    assert!((product - f64::from(i == j)).abs() < 1e-15, "{direction:?}");
                }
            }
        }
        assert!(complement(&[1.0]).is_empty());
    }

    #[test]
    fn nearest_value_of_an_unknown_leaves_nothing_along_it() {
        let mut unknown = Unknown::of(1);
        assert_eq!(
            plain(std::slice::from_ref(&unknown)),
            [(vec![(1, 1.0)], vec![(1, 1.0)], 0.0, 0.0)]
        );
        assert_eq!(unknown.nearest(&[7.0, 3.0]), 3.0);
        unknown.force = vec![(0, 2.0), (1, -1.0)];
        // (2, −1)·(7, 3)/5
        assert!((unknown.nearest(&[7.0, 3.0]) - 11.0 / 5.0).abs() < 1e-15);
        assert_eq!(along(&unknown.force, &[7.0, 3.0]), 11.0);
    }
}
