//! States that hold the floating bodies: no linear problem is posed in which a body could slide or fly off freely.
//!
//! A guess may let every node of a body slip, or open, although its load must be borne by some of them. The nodes that want
//! to slip least then stick, one after the other, until no body can slide; where the load still has nothing to bear it,
//! contacts that were closed before stay closed.

use crate::solve::setup::Setup;
use crate::solve::states::{Shear, State};
use crate::solve::system::System;

/// Changes `states` until they hold the floating bodies: nodes that want to slip least stick, then contacts of `before`
/// stay closed (all of them where there is no before).
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

/// Nodes stick, those first that want to slip least, until no body slides freely.
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
        let moves = |i: usize| motions.iter().any(|motion| motion[i].abs() > 1e-9);
        let slipping = |place: &usize| {
            let state = &states[*place];
            let law = setup.admissible.blocks()[*place].friction();
            matches!(state.shear, Shear::Slip { .. })
                && law.is_some_and(|law| law.bears(state.closed))
                && setup.admissible.range(*place).skip(1).any(moves)
        };
        let least = (0..states.len())
            .filter(slipping)
            .min_by(|&a, &b| states[a].excess.total_cmp(&states[b].excess));
        let Some(place) = least else { return };
        states[place].shear = Shear::Stick;
    }
}
