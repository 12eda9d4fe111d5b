//! What exact steps say of forces that are judged by displacements: how far off they are, and what is to be added to them.
//!
//! A gap is a difference of displacements that may be much larger (a slender body, a stiff one carried by a soft one), so that
//! Fλ − d − Gᵀα drowns in the rounding of its terms where the displacements still tell it. *Increments* are free of that: at
//! forces λ with the gaps g of their displacements the exact step solves
//!
//! ```text
//!   wₐ·(g + F δλ − Gᵀδα) = 0,   G δλ = e − Gλ,   λ + δλ = offset + Σ xₐ cₐ
//! ```
//!
//! for the states that λ and g ask for: iterative refinement, in which F need not be better than a few digits.

use std::ops::ControlFlow;

use crate::dual::{Compliance, DualProblem, Multipliers};
use crate::solve::exact::{Ended, NEAR, Search, finest};
use crate::solve::hold::hold;
use crate::solve::setup::{Forces, Setup};
use crate::solve::states::unknowns;
use crate::solve::system::System;
use crate::solve::{FixedBounds, Newton};

/// What one exact step adds to forces and rigid amplitudes whose displacements have the gaps `gap`, known to `rounding`; `None`
/// where it cannot be solved. Shapes: (m,).
pub(crate) fn correction(
    problem: &DualProblem,
    multipliers: &Multipliers,
    (gap, rounding): (&[f64], &[f64]),
) -> Option<Multipliers> {
    let limits = Newton::default().limits();
    let mut setup = Setup::unchecked(problem);
    setup.shift = gap.iter().map(|gap| -gap).collect();
    let balance = &problem.balance;
    let carried = balance.modes().product(&multipliers.lambda);
    let left = balance.load().iter().zip(&carried);
    let left = left.map(|(load, carried)| load - carried);
    setup.balance.set_load(left.collect());
    let mut search = Search::new(limits, &setup);
    let states = search.states_of_guess(multipliers).ok()?;
    let told = gap.iter().zip(rounding);
    let told: Vec<f64> = told
        .map(|(g, r)| if g.abs() <= *r { 0.0 } else { *g })
        .collect();
    let mut next = search.next_states(&states, &told);
    if setup.admissible.bounds_follow() {
        hold(&setup, &mut next, Some(&states));
    }
    let (mut list, mut offset) = unknowns(&setup.admissible, &next, None, search.softness());
    let apart = offset.iter_mut().zip(&multipliers.lambda);
    apart.for_each(|(offset, force)| *offset -= force);
    for unknown in &mut list {
        // the forces themselves are the start: what they have of each unknown
        let x = unknown.nearest(&offset);
        for &(i, weight) in &unknown.force {
            offset[i] -= x * weight;
        }
        unknown.pull += unknown.softness * x;
    }
    let mut system = System::new(&setup, list, offset);
    if !system.carries() {
        return None;
    }
    let found = system.solve(&Forces::none(&setup), finest(limits.0))?;
    Some(setup.multipliers(&found.lambda, &found.alpha))
}

/// How far forces are from those of the answer that a few exact steps find beside them, the largest difference: by that much
/// they are wrong, however small their gaps. `None` where exact steps find none, where states do not determine the forces,
/// where the gaps that should be closed are rounding, and where F is not assembled.
pub(crate) fn distance_to_exact(problem: &DualProblem, multipliers: &Multipliers) -> Option<f64> {
    if matches!(problem.compliance, Compliance::Operator { .. }) {
        return None;
    }
    let setup = Setup::new(problem).ok()?;
    let mut search = Search::new(Newton::default().limits(), &setup);
    let sticking = search.states_of_guess(multipliers).ok()?;
    search.move_to(multipliers.lambda.clone(), search.point.alpha.clone());
    let states = search.next_states(&sticking, &search.judge.gap);
    let (list, _) = unknowns(&setup.admissible, &states, None, search.softness());
    let gap = search.judge.gap.clone();
    let known = problem.rounding(&gap, &multipliers.alpha);
    let rounding = |&(i, _): &(usize, f64)| gap[i].abs() <= known(i);
    if list.iter().all(|unknown| unknown.row.iter().all(rounding)) {
        return None;
    }
    let found = search.exact(
        states,
        &NEAR,
        &|_, _| {},
        &mut |_| ControlFlow::Continue(()),
    );
    let exact = matches!(found, Ended::Converged) && search.unique;
    let difference = search.point.lambda.iter().zip(&multipliers.lambda);
    let largest = difference.fold(0.0, |s: f64, (a, b)| s.max((a - b).abs()));
    exact.then_some(largest)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::dual::{AdmissibleSet, Balance, Block};
    use crate::linalg::Mat;
    use crate::solve::{ContactSolver, Outcome};

    /// Contacts that give way much together and little by themselves, and that only to within `error`.
    fn problem(error: f64) -> DualProblem {
        let m = 24;
        let near = |i: usize, j: usize| (-(i.abs_diff(j) as f64)).exp();
        let own = |i: usize, j: usize| if i == j { error } else { 0.0 };
        let f = Mat::from_fn(m, m, |i, j| 50.0 + near(i, j) + own(i, j));
        let modes = Mat::from_fn(1, m, |_, i| f64::from(u8::from(i % 2 == 0)));
        DualProblem::new(
            Compliance::Dense(f),
            (0..m).map(|i| (0.7 * i as f64).sin() - 0.2).collect(),
            AdmissibleSet::new(vec![Block::Unilateral; m]),
            Balance::new(modes, vec![3.0]),
        )
        .unwrap()
    }

    #[test]
    fn increments_reach_the_answer_of_gaps_that_a_rough_compliance_does_not_know() {
        let (rough, true_one) = (problem(1e-2), problem(0.0));
        let newton = Newton::default();
        let exact = newton.solve(&true_one, None, &mut |_| ControlFlow::Continue(()));
        let exact = exact.unwrap().multipliers;
        let start = newton.solve(&rough, None, &mut |_| ControlFlow::Continue(()));
        let mut at = start.unwrap();
        let off = |at: &Outcome| {
            let pairs = at.multipliers.lambda.iter().zip(&exact.lambda);
            pairs.fold(0.0, |s: f64, (a, b)| s.max((a - b).abs()))
        };
        assert!(
            off(&at) > 1e-3,
            "the compliances do not differ: {:e}",
            off(&at)
        );
        for _ in 0..12 {
            let gap = true_one.gap(&at.multipliers);
            let known = (&gap[..], &vec![0.0; gap.len()][..]);
            at = at.corrected(&correction(&rough, &at.multipliers, known).unwrap());
        }
        assert!(off(&at) < 1e-13, "{:e}", off(&at));
        assert!(true_one.certify(&at.multipliers, 1e-8).holds());
    }
}
