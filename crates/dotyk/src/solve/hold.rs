//! States that hold the floating bodies: no linear problem is posed in which a body could slide or fly off freely.
//!
//! A guess may let every node of a body slip, or open, although some of them must bear its load. The nodes of least excess
//! shear then stick, one after the other, until no body can slide; where the load is still not borne, contacts that were closed
//! before stay closed.

use crate::solve::setup::Setup;
use crate::solve::states::{Shear, State};
use crate::solve::system::{LOOSE, System};

/// Changes `states` until they hold the floating bodies: nodes of least excess shear stick, then contacts closed in `before`
/// stay closed (all contacts without `before`).
pub(crate) fn hold(setup: &Setup<'_>, states: &mut [State], before: Option<&[State]>) {
    if setup.modes() == 0 {
        return;
    }
    stick_where_free(setup, states);
    if System::of(setup, states, None, &setup.problem.softness).carries() {
        return;
    }
    for (place, state) in states.iter_mut().enumerate() {
        match before.map(|before| &before[place]) {
            Some(before) if before.closed && !state.closed => *state = before.clone(),
            None => state.closed = true,
            _ => {}
        }
    }
    stick_where_free(setup, states);
}

/// [`hold`] as exact steps adjust the states that come next.
pub(crate) fn held<'a>(setup: &'a Setup<'_>) -> impl Fn(&mut Vec<State>, &[State]) + 'a {
    |next, before| hold(setup, next, Some(before))
}

/// Nodes stick in the order of their excess shear, least first, until no body slides freely.
fn stick_where_free(setup: &Setup<'_>, states: &mut [State]) {
    loop {
        let loose = System::of(setup, states, None, &setup.problem.softness).loose;
        if loose.is_empty() {
            return;
        }
        let motions = loose.iter().map(|z| {
            let mut motion = vec![0.0; setup.len()];
            setup.balance.add_transposed(1.0, z, &mut motion);
            motion
        });
        let motions: Vec<Vec<f64>> = motions.collect();
        let moves = |i: usize| motions.iter().any(|motion| motion[i].abs() > LOOSE);
        let slipping = |place: &usize| {
            let state = &states[*place];
            let block = &setup.admissible.blocks()[*place];
            let mut sheared = block.shear(&setup.admissible.range(*place));
            let law = block.friction();
            matches!(state.shear, Shear::Slip { .. })
                && law.is_some_and(|law| law.bears(state.closed))
                && sheared.any(moves)
        };
        let least = (0..states.len())
            .filter(slipping)
            .min_by(|&a, &b| states[a].excess.total_cmp(&states[b].excess));
        let Some(place) = least else { return };
        states[place].shear = Shear::Stick;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::dual::{Compliance, DualProblem, Friction};
    use crate::solve::tests::{definite, of};

    /// Nodes in the plane on one body: `modes` move normals (even) and tangents (odd).
    fn nodes(count: usize, modes: &[Vec<f64>], load: &[f64]) -> DualProblem {
        let block = Friction::Coulomb { coefficient: 0.5 }.block(1);
        let shift = vec![1.0; 2 * count];
        let f = Compliance::Dense(definite(2 * count));
        of(f, &shift, vec![block; count], (modes, load))
    }

    fn slipping(closed: bool, excess: f64) -> State {
        State {
            closed,
            shear: Shear::Slip {
                direction: vec![1.0],
                share: 0.5,
            },
            excess,
            normal: 0.0,
        }
    }

    fn sticks(states: &[State]) -> Vec<usize> {
        let stick = |i: &usize| states[*i].shear == Shear::Stick;
        (0..states.len()).filter(stick).collect()
    }

    #[test]
    fn node_that_wants_to_slip_least_sticks_and_no_more_than_are_needed() {
        let aside = vec![0.0, 1.0, 0.0, 1.0, 0.0, 1.0];
        let problem = nodes(3, &[aside], &[0.1]);
        let setup = Setup::new(&problem).unwrap();
        let mut states: Vec<State> = [3.0, 1.0, 2.0].map(|e| slipping(true, e)).to_vec();
        hold(&setup, &mut states, None);
        assert_eq!(sticks(&states), [1]);
        assert_eq!([states[0].excess, states[2].excess], [3.0, 2.0]);
        // an open node bears no shear, and a node that the motion does not move does not hold it
        let aside = vec![0.0, 1.0, 0.0, 1.0, 0.0, 0.0];
        let problem = nodes(3, &[aside], &[0.1]);
        let setup = Setup::new(&problem).unwrap();
        let mut states = vec![
            slipping(true, 3.0),
            slipping(false, 1.0),
            slipping(true, 2.0),
        ];
        hold(&setup, &mut states, None);
        assert_eq!(sticks(&states), [0]);
        // two motions ask for two nodes
        let modes = [
            vec![0.0, 1.0, 0.0, 1.0, 0.0, 1.0],
            vec![0.0, -1.0, 0.0, 0.5, 0.0, 1.0],
        ];
        let problem = nodes(3, &modes, &[0.1, 0.0]);
        let setup = Setup::new(&problem).unwrap();
        let mut states: Vec<State> = [3.0, 1.0, 2.0].map(|e| slipping(true, e)).to_vec();
        hold(&setup, &mut states, None);
        assert_eq!(sticks(&states), [1, 2]);
    }

    #[test]
    fn contacts_that_were_closed_stay_where_the_load_has_nothing_else() {
        let up = vec![1.0, 0.0, 1.0, 0.0, 1.0, 0.0];
        let problem = nodes(3, &[up], &[2.0]);
        let setup = Setup::new(&problem).unwrap();
        let block = &setup.admissible.blocks()[0];
        let open = || vec![State::sticking(block, false); 3];
        // all contacts, without states before
        let mut states = open();
        hold(&setup, &mut states, None);
        assert!(states.iter().all(|state| state.closed));
        // those closed before, with their states
        let before = vec![
            State::sticking(block, false),
            slipping(true, 1.5),
            State::sticking(block, false),
        ];
        let mut states = open();
        hold(&setup, &mut states, Some(&before));
        assert_eq!(states, before);
        let mut states = open();
        held(&setup)(&mut states, &before);
        assert_eq!(states, before);
        // one is enough: no state changes
        let mut states = open();
        states[2].closed = true;
        let own = states.clone();
        hold(&setup, &mut states, Some(&before));
        assert_eq!(states, own);
        // without a load open contacts may stay open
        let problem = nodes(3, &[vec![1.0, 0.0, 1.0, 0.0, 1.0, 0.0]], &[0.0]);
        let setup = Setup::new(&problem).unwrap();
        let mut states = open();
        hold(&setup, &mut states, None);
        assert_eq!(states, open());
    }

    #[test]
    fn where_nothing_floats_states_are_left_alone() {
        let problem = nodes(2, &[], &[]);
        let setup = Setup::new(&problem).unwrap();
        let own = vec![slipping(true, 1.0), slipping(false, 2.0)];
        let mut states = own.clone();
        hold(&setup, &mut states, None);
        assert_eq!(states, own);
    }
}
