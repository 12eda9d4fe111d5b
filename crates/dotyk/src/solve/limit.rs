//! The part of a load that friction bears.
//!
//! ```text
//!   gapₜ + a λₜ = 0  where a node sticks, its bound where it slips;      gapₙ as it is;      Gλ = e − (1 − s) h
//! ```
//!
//! Where friction does not bear a load with the normal forces that follow from the elasticity of the bodies, bodies pressed onto each
//! other (a shaft in its hub, a pin in its hole) slide, although larger normal forces would balance the load. A part s of h, the load on
//! motions that move no normal, has an answer then; it is raised by bisection.
//!
//! Shears are borne by springs of a compliance a: with the law itself the node that sticks first would jam, and no guess of states is
//! near. The springs change no bound, so a load that friction does not bear has no answer with them either. The first problem is that
//! without friction and without h.
//!
//! Alart & Curnier (1991) for the steps.

use crate::dual::{Component, Feasibility};
use crate::solve::anchored::{ACCURATE, Inner, anchored};
use crate::solve::exact::Search;
use crate::solve::setup::{Forces, Setup};
use crate::solve::states::{Anchor, State};
use crate::solve::system::{LOOSE, System};
use crate::solve::{FixedBounds, Observer, SolveError, dot};
use std::ops::ControlFlow;

/// Accuracy of the problem without friction, a start.
const START: f64 = 1e-6;

/// Compliances of the springs, relative to that of each contact.
const TELLING: [f64; 3] = [100.0, 1.0, 1e-2];

/// Bisections of a load: three digits.
const BISECTIONS: usize = 12;

/// At the largest load that friction bears, it is exhausted but for this part; the second is the resolution of the bisections.
const SPARE: f64 = 0.05;
const EXHAUSTED: f64 = 0.003;

/// The motion, amplitudes (r,), along which friction does not bear the load of a problem, and the part of the load along it that it
/// bears: where a part of the load has an answer with springs, the whole has none, and friction is exhausted at the largest part.
///
/// Soft springs are tried first. Near the limit they may bear a load that friction does not, because their normal forces belong to
/// another slip; stiffer ones then decide.
pub(crate) fn limit<S: FixedBounds>(method: &S, setup: &Setup<'_>) -> Option<(Vec<f64>, f64)> {
    let rest = Rest::of(method, setup)?;
    if rest.motions.is_empty() {
        return None;
    }
    let mut best: Option<Limit> = None;
    for springs in TELLING {
        let Some(found) = limit_with(method, setup, &rest, springs) else {
            continue;
        };
        let known = best.as_ref().map_or(1.0 - SPARE, |best| best.exhausted);
        if found.exhausted >= known {
            best = Some(found);
        }
        if best
            .as_ref()
            .is_some_and(|best| best.exhausted >= 1.0 - EXHAUSTED)
        {
            break;
        }
    }
    best.map(|best| (best.direction, best.held))
}

/// The largest load that friction bears with springs.
struct Limit {
    /// Amplitudes (k,) of the motion beyond it.
    direction: Vec<f64>,
    /// The part of the load along it.
    held: f64,
    /// The part of the bounds of friction that is used there.
    exhausted: f64,
}

/// As [`limit`], with springs of one compliance.
fn limit_with<S: FixedBounds>(
    method: &S,
    setup: &Setup<'_>,
    rest: &Rest,
    springs: f64,
) -> Option<Limit> {
    let bears = |part: f64, from: &[State]| {
        let mut given = setup.with_admissible(setup.admissible.clone());
        let load = setup.balance.load().iter().zip(&rest.held);
        given
            .balance
            .set_load(load.map(|(e, held)| e - (1.0 - part) * held).collect());
        // from the states of a smaller load or, where these lead nowhere, without shear
        [from, &rest.states[..]].into_iter().find_map(|from| {
            let mut search = Search::new(method.limits(), &given);
            let silent: Observer<'_> = &mut |_| ControlFlow::Continue(());
            match sprung(&mut search, from.to_vec(), springs, silent) {
                Inner::Settled(states) => Some((search.point, states)),
                _ => None,
            }
        })
    };
    let (mut before, mut states) = bears(0.0, &rest.states)?;
    if bears(1.0, &states).is_some() {
        return None;
    }
    let (mut low, mut high, mut last) = (0.0, 1.0, None);
    for _ in 0..BISECTIONS {
        let part = 0.5 * (low + high);
        match bears(part, &states) {
            Some((forces, next)) => {
                before = last.replace(forces).unwrap_or(before);
                (low, states) = (part, next);
            }
            None => high = part,
        }
    }
    let last: Forces = last?;
    // how the bodies have moved for the last part of the load, along the motions that friction alone resists
    let moved = last.alpha.iter().zip(&before.alpha);
    let moved: Vec<f64> = moved.map(|(now, then)| now - then).collect();
    let mut along = vec![0.0; moved.len()];
    for z in &rest.motions {
        let part = dot(z, &moved);
        along.iter_mut().zip(z).for_each(|(a, z)| *a += part * z);
    }
    Some(Limit {
        exhausted: exhausted(setup, &last.lambda, &along),
        direction: setup.multipliers(&last.lambda, &along).alpha,
        held: low,
    })
}

/// Used part of the bounds of friction that resists a motion α̂ (k,): Σ‖λₜ‖ over Σ bound; 0 if none resists. Shapes: λ (m,).
fn exhausted(setup: &Setup<'_>, lambda: &[f64], along: &[f64]) -> f64 {
    let mut motion = vec![0.0; setup.len()];
    setup.balance.add_transposed(1.0, along, &mut motion);
    let size = motion.iter().fold(0.0, |s: f64, u| s.max(u.abs()));
    let bounds = setup.admissible.bounds(lambda);
    let (mut borne, mut most) = (0.0, 0.0);
    for ((block, range), bound) in setup.admissible.iter().zip(bounds) {
        let tangents = block.shear(&range);
        if tangents.clone().any(|i| motion[i].abs() > LOOSE * size) {
            borne += lambda[tangents].iter().map(|t| t * t).sum::<f64>().sqrt();
            most += bound;
        }
    }
    if size > 0.0 && most > 0.0 {
        borne / most
    } else {
        0.0
    }
}

/// Equilibrium by normal forces alone.
struct Rest {
    /// States of the nodes there; no node slips.
    states: Vec<State>,
    /// Motions that no normal force resists, orthonormal amplitudes (k,).
    motions: Vec<Vec<f64>>,
    /// The load on these motions (r,), which is left out.
    held: Vec<f64>,
}

impl Rest {
    /// `None` where normal forces alone do not carry the rest of the load, or no solution is found.
    fn of<S: FixedBounds>(method: &S, setup: &Setup<'_>) -> Option<Self> {
        let bounds = setup.admissible.bounds(&vec![0.0; setup.len()]);
        let mut smooth = setup.with_admissible(setup.admissible.with_bounds(&bounds));
        let blocks = smooth.admissible.blocks().iter();
        let closed: Vec<State> = blocks.map(|block| State::sticking(block, true)).collect();
        let softness = &setup.problem.softness;
        let motions = System::of(&smooth, &closed, None, softness).loose;
        let mut pulls = vec![0.0; setup.len()];
        for z in &motions {
            let load = dot(z, setup.balance.target());
            setup.balance.add_transposed(load, z, &mut pulls);
        }
        let held = setup.balance.modes().product(&pulls);
        let rest = setup.balance.load().iter().zip(&held);
        smooth
            .balance
            .set_load(rest.map(|(e, held)| e - held).collect());
        let force = setup.problem.scales.force;
        if setup.modes() > 0 {
            let carried = Feasibility::of(&smooth.admissible, &smooth.balance, force);
            let Feasibility::Feasible { load } = carried else {
                return None;
            };
            smooth.balance.set_load(load);
        }
        let most = method.limits().1;
        let silent: Observer<'_> = &mut |_| ControlFlow::Continue(());
        let outcome = match method.within(START, most).run(&smooth, None, silent) {
            Ok(outcome) => outcome,
            Err(SolveError::NotConverged { outcome, .. }) => *outcome,
            Err(_) => return None,
        };
        let forces = &outcome.multipliers.lambda;
        let pressed = State::of_all_forces(&setup.admissible, forces).into_iter();
        let blocks = setup.admissible.blocks().iter();
        let states = blocks
            .zip(pressed)
            .map(|(block, state)| State::sticking(block, state.closed));
        Some(Self {
            states: states.collect(),
            motions,
            held,
        })
    }
}

/// Newton's iteration with springs of a compliance that is a part of that of each contact.
fn sprung(search: &mut Search<'_>, states: Vec<State>, part: f64, observe: Observer<'_>) -> Inner {
    let setup = search.setup;
    let softness = &setup.problem.softness;
    let springs = setup.components.iter().zip(softness);
    let springs = springs.map(|(component, c)| match component {
        Component::Tangent => part * c,
        Component::Normal | Component::Free => 0.0,
    });
    let springs: Vec<f64> = springs.collect();
    // a trial force of a spring is that of spring and contact together
    let own: Vec<f64> = springs.iter().zip(softness).map(|(a, c)| a + c).collect();
    let anchor = Anchor {
        centre: &vec![0.0; setup.len()],
        compliance: &springs,
    };
    anchored(search, states, (anchor, &own), ACCURATE, observe)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::dual::{Compliance, DualProblem, Friction};
    use crate::linalg::Mat;
    use crate::solve::tests::{of, silent};
    use crate::solve::{ContactSolver, Newton};

    /// A node that is pressed by an overlap of 1 and drawn aside, where nothing but friction holds it.
    fn pressed(load: f64) -> DualProblem {
        let f = Mat::from_fn(2, 2, |i, j| if i == j { 1.0 } else { 0.1 });
        let block = Friction::Coulomb { coefficient: 0.5 }.block(1);
        let balance = (&[vec![0.0, 1.0]][..], &[load][..]);
        of(Compliance::Dense(f), &[1.0, 0.0], vec![block], balance)
    }

    /// λₙ + 0.1 λₜ = 1 and λₜ = 0.5 λₙ.
    const MOST: f64 = 0.5 / 1.05;

    #[test]
    fn load_beyond_what_normal_forces_let_friction_bear_slides_with_its_part() {
        let held = Newton::default().solve(&pressed(0.99 * MOST), None, &mut silent);
        assert!((held.unwrap().multipliers.lambda[1] - 0.99 * MOST).abs() < 1e-9);
        for load in [1.01 * MOST, 3.0] {
            match Newton::default().solve(&pressed(load), None, &mut silent) {
                Err(SolveError::Slides { direction, factor }) => {
                    assert!((factor * load / MOST - 1.0).abs() < 1e-2, "{factor}");
                    assert!(direction.len() == 1 && direction[0] > 0.0);
                }
                other => panic!("{other:?}"),
            }
        }
    }
}
