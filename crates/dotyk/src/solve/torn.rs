//! Nodes of joints that have no state of equilibrium.
//!
//! The bound of a cohesive law jumps where the node opens (`dual/law.rs`): a shear that the cohesion bears may lift the node off,
//! while the open node, which bears no shear, is pressed on again. With all other nodes kept as they are,
//!
//! ```text
//!   open:   gapₙ < 0        stick:  λₙ ≤ 0 or ‖λₜ‖ > c + μλₙ        slip either way:  λₙ ≤ 0 or against the slip
//! ```
//!
//! and no state reproduces itself. Once such a node has parted its law is known: friction without cohesion, where it is pressed
//! again.

use crate::dual::{DualProblem, Multipliers};
use crate::solve::exact::Search;
use crate::solve::setup::Setup;
use crate::solve::states::{Shear, State};
use crate::solve::{FixedBounds, Newton, norm};

/// The first component of a block with a bound that jumps and without a state of equilibrium, beside the states of all others that
/// follow from the forces.
pub(crate) fn torn(problem: &DualProblem, multipliers: &Multipliers) -> Option<usize> {
    if !problem.admissible.jumps() {
        return None;
    }
    let setup = Setup::new(problem).ok()?;
    let mut search = Search::new(Newton::default().limits(), &setup);
    let states = search.states_asked_by(multipliers).ok()?;
    let blocks = setup.admissible.blocks().iter().enumerate();
    let joints = blocks.filter(|(_, block)| block.friction().is_some_and(|law| law.jumps()));
    let mut joints = joints.map(|(place, _)| place);
    let place = joints.find(|&place| !stands(&mut search, &states, place))?;
    Some(setup.admissible.range(place).start)
}

/// Whether a block has a state that reproduces itself while all others have the given `states`.
fn stands(search: &mut Search<'_>, states: &[State], place: usize) -> bool {
    let block = search.setup.admissible.blocks()[place];
    let sticks = |closed| State::sticking(&block, closed);
    if [false, true]
        .map(sticks)
        .into_iter()
        .any(|own| asks_for_itself(search, states, place, own))
    {
        return true;
    }
    // it slips along the shear that would have held it, or back
    let range = search.setup.admissible.range(place);
    let normal = search.point.lambda[range.start].max(0.0);
    let shear = search.point.lambda[block.shear(&range)].to_vec();
    let length = norm(&shear);
    let slips = |sign: f64| State {
        closed: true,
        shear: Shear::Slip {
            direction: shear.iter().map(|t| sign * t / length).collect(),
            share: 0.5,
        },
        excess: 0.0,
        normal,
    };
    let mut either = [1.0, -1.0].map(slips).into_iter();
    length > 0.0 && either.any(|own| asks_for_itself(search, states, place, own))
}

/// Whether the state of one block reproduces itself.
fn asks_for_itself(search: &mut Search<'_>, states: &[State], place: usize, own: State) -> bool {
    let mut states = states.to_vec();
    states[place] = own;
    if !search.exact_step(&states) {
        return false;
    }
    let next = search.next_states(&states, &search.judge.gap);
    next[place].key() == states[place].key()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::dual::{Compliance, Friction};
    use crate::linalg::Mat;
    use crate::solve::tests::of;

    /// A node whose shear and normal gap are coupled by `mixed`, with these overlaps and the cohesion 1.
    fn joint(mixed: f64, shift: [f64; 2]) -> DualProblem {
        let law = Friction::Cohesive {
            cohesion: 1.0,
            coefficient: 0.3,
        };
        let f = Mat::from_fn(2, 2, |i, j| if i == j { 1.0 } else { mixed });
        of(Compliance::Dense(f), &shift, vec![law.block(1)], (&[], &[]))
    }

    #[test]
    fn node_that_its_shear_lifts_and_that_closes_without_it_has_no_state() {
        let none = Multipliers {
            lambda: vec![0.0; 2],
            alpha: Vec::new(),
        };
        let torn = |mixed, shift| torn(&joint(mixed, shift), &none);
        // open: gap −0.1; stick: λₙ = (0.1 − 1.2)/0.64; slip: λₙ = (0.1 − 0.6)/1.18
        assert_eq!(torn(0.6, [0.1, 2.0]), Some(0));
        assert_eq!(torn(-0.6, [0.1, -2.0]), Some(0));
        // a shear that presses, a pressure that bears it, a shear that sticks, a gap
        assert_eq!(torn(-0.6, [0.1, 2.0]), None);
        assert_eq!(torn(0.6, [0.8, 2.0]), None);
        assert_eq!(torn(0.6, [0.5, 0.1]), None);
        assert_eq!(torn(0.6, [-0.1, 2.0]), None);
        // with dry friction there is always such a state here
        let mut dry = joint(0.6, [0.1, 2.0]);
        dry.admissible =
            crate::dual::AdmissibleSet::new(vec![Friction::Coulomb { coefficient: 0.3 }.block(1)]);
        assert_eq!(super::torn(&dry, &none), None);
    }
}
