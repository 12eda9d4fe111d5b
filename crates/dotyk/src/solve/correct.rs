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
/// where it cannot be solved, and for a crowd. Shapes: (m,).
pub(crate) fn correction(
    problem: &DualProblem,
    multipliers: &Multipliers,
    (gap, rounding): (&[f64], &[f64]),
) -> Option<Multipliers> {
    if problem.is_crowd() {
        return None;
    }
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

/// How far each force is from that of the answer that a few exact steps find beside them (m,): by that much they are wrong, however
/// small their gaps. `None` where exact steps find none, where states do not determine the forces,
/// as in a crowd, where the gaps that should be closed are rounding, and where F is not assembled.
pub(crate) fn distance_to_exact(
    problem: &DualProblem,
    multipliers: &Multipliers,
) -> Option<Vec<f64>> {
    if matches!(problem.compliance, Compliance::Operator { .. }) || problem.is_crowd() {
        return None;
    }
    let setup = Setup::new(problem).ok()?;
    let mut search = Search::new(Newton::default().limits(), &setup);
    let states = search.states_asked_by(multipliers).ok()?;
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
    exact.then(|| difference.map(|(a, b)| (a - b).abs()).collect())
}

/// By how much each force changes (m,) where the gaps change within `rounding` (m,) and the states stay, in two patterns of signs that
/// are as good as random. `None` where F is not assembled, and where the states do not determine the forces.
///
/// Forces whose gaps a stiff side alone tells apart change most, and every pattern has a part of those.
pub(crate) fn left_open(
    problem: &DualProblem,
    multipliers: &Multipliers,
    rounding: &[f64],
) -> Option<Vec<f64>> {
    if matches!(problem.compliance, Compliance::Operator { .. }) || problem.is_crowd() {
        return None;
    }
    let limits = Newton::default().limits();
    let mut setup = Setup::new(problem).ok()?;
    let states = Search::new(limits, &setup)
        .states_asked_by(multipliers)
        .ok()?;
    setup.balance.set_load(vec![0.0; setup.modes()]);
    let mut most = vec![0.0f64; rounding.len()];
    for pattern in [0x9e37_79b9_7f4a_7c15, 0xd1b5_4a32_d192_ed03u64] {
        let odd = |i: usize| (i as u64 + 1).wrapping_mul(pattern).count_ones() % 2 == 1;
        let signed = rounding.iter().enumerate();
        let signed = signed.map(|(i, r)| if odd(i) { -r } else { *r });
        setup.shift = signed.collect();
        let (list, _) = unknowns(&setup.admissible, &states, None, &problem.softness);
        let mut system = System::new(&setup, list, vec![0.0; most.len()]);
        let found = system.solve(&Forces::none(&setup), finest(limits.0))?;
        if !system.unique {
            return None;
        }
        let changes = most.iter_mut().zip(&found.lambda);
        changes.for_each(|(most, change)| *most = most.max(change.abs()));
    }
    Some(most)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::dual::{AdmissibleSet, Balance, Block, Friction};
    use crate::linalg::Mat;
    use crate::solve::setup::largest;
    use crate::solve::tests::{apart, applied, definite, of, silent};
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

    const SHIFT: [f64; 6] = [1.0, 0.9, 0.8, -0.3, 0.7, 0.1];

    fn nodes(compliance: Compliance) -> DualProblem {
        let block = Friction::Coulomb { coefficient: 0.3 }.block(1);
        let modes = [vec![1.0, 0.0, 1.0, 0.0, 1.0, 0.0]];
        of(compliance, &SHIFT, vec![block; 3], (&modes, &[4.0]))
    }

    #[test]
    fn correction_of_stick_and_slip_ends_at_the_answer() {
        let problem = nodes(Compliance::Dense(definite(6)));
        let answer = Newton::default()
            .solve(&problem, None, &mut silent)
            .unwrap()
            .multipliers;
        let slips = |n: usize| (answer.lambda[n + 1].abs() - 0.3 * answer.lambda[n]).abs() < 1e-12;
        assert!(slips(0) && slips(4), "{:?}", answer.lambda);
        let mut at = answer.clone();
        // wrong forces that ask for the same states
        at.lambda
            .iter_mut()
            .enumerate()
            .for_each(|(i, force)| *force += 1e-4 * (i as f64).cos());
        at.alpha[0] += 1e-4;
        for _ in 0..3 {
            let gap = problem.gap(&at);
            let change = correction(&problem, &at, (&gap, &[0.0; 6])).unwrap();
            at.lambda
                .iter_mut()
                .zip(&change.lambda)
                .for_each(|(l, d)| *l += d);
            at.alpha
                .iter_mut()
                .zip(&change.alpha)
                .for_each(|(a, d)| *a += d);
        }
        assert!(apart(&at.lambda, &answer.lambda) < 1e-13);
        assert!(apart(&at.alpha, &answer.alpha) < 1e-13);
        // the answer itself is changed by rounding
        let gap = problem.gap(&answer);
        let change = correction(&problem, &answer, (&gap, &[0.0; 6])).unwrap();
        assert!(apart(&change.lambda, &[0.0; 6]) < 1e-13);
    }

    #[test]
    fn gap_within_its_rounding_asks_for_no_other_state() {
        // an open contact that seems to overlap a little
        let blocks = vec![Block::Unilateral; 2];
        let problem = of(
            Compliance::Dense(definite(2)),
            &[1.0, 0.0],
            blocks,
            (&[], &[]),
        );
        let f = definite(2);
        let forces = Multipliers {
            lambda: vec![1.0 / f[(0, 0)], 0.0],
            alpha: Vec::new(),
        };
        let change = |rounding: f64| {
            let gap = [0.0, -1e-3];
            correction(&problem, &forces, (&gap, &[rounding; 2]))
                .unwrap()
                .lambda
        };
        assert!(apart(&change(1e-3), &[0.0; 2]) < 1e-15);
        assert!(change(0.9e-3)[1] > 1e-4);
    }

    #[test]
    fn load_that_closed_contacts_cannot_carry_has_no_correction() {
        let blocks = vec![Block::Unilateral; 2];
        let modes = [vec![1.0, 0.0], vec![0.0, 1.0]];
        let f = Compliance::Dense(definite(2));
        let problem = of(f, &[1.0, 1.0], blocks, (&modes, &[1.0, 1.0]));
        let forces = Multipliers {
            lambda: vec![1.0, 0.0],
            alpha: vec![0.0; 2],
        };
        assert!(correction(&problem, &forces, (&[0.0, 1.0], &[0.0; 2])).is_none());
        assert!(correction(&problem, &forces, (&[0.0, -1.0], &[0.0; 2])).is_some());
    }

    #[test]
    fn distance_to_the_exact_answer_is_by_how_much_forces_are_off() {
        let problem = nodes(Compliance::Dense(definite(6)));
        let answer = Newton::default()
            .solve(&problem, None, &mut silent)
            .unwrap()
            .multipliers;
        let mut off = answer.clone();
        off.lambda[2] += 1e-3;
        off.lambda[4] -= 2e-3;
        off.lambda[0] += 1e-3;
        let distance = largest(0.0, &distance_to_exact(&problem, &off).unwrap());
        assert!((distance - 2e-3).abs() < 1e-9, "{distance}");
        // an applied compliance is not asked
        let f = definite(6);
        assert_eq!(
            distance_to_exact(&nodes(applied(&f, Mat::identity(6, 6))), &off),
            None
        );
        // forces that are not unique are not compared
        let alike = Mat::from_fn(2, 2, |_, _| 1.0);
        let blocks = vec![Block::Unilateral; 2];
        let problem = of(Compliance::Dense(alike), &[1.0, 1.0], blocks, (&[], &[]));
        let half = |more: f64| Multipliers {
            lambda: vec![0.5 + more, 0.5 + more],
            alpha: Vec::new(),
        };
        assert_eq!(distance_to_exact(&problem, &half(0.1)), None);
        // gaps that are rounding tell nothing
        let f = Mat::from_fn(2, 2, |i, j| f64::from(i == j));
        let blocks = vec![Block::Unilateral; 2];
        let problem = of(Compliance::Dense(f), &[0.5, 0.5], blocks, (&[], &[]));
        assert_eq!(distance_to_exact(&problem, &half(0.0)), None);
        let distance = largest(0.0, &distance_to_exact(&problem, &half(0.1)).unwrap());
        assert!((distance - 0.1).abs() < 1e-14);
    }

    #[test]
    fn rounding_changes_forces_that_a_stiff_side_alone_tells_apart() {
        // two forces on one soft place; what tells them apart is a millionth of what it gives
        let f = Mat::from_fn(2, 2, |i, j| if i == j { 1.0 + 1e-6 } else { 1.0 });
        let changes = |compliance: Compliance, shift: [f64; 2], lambda: [f64; 2]| {
            let problem = of(compliance, &shift, vec![Block::Unilateral; 2], (&[], &[]));
            let answer = Multipliers {
                lambda: lambda.to_vec(),
                alpha: Vec::new(),
            };
            left_open(&problem, &answer, &[1e-9; 2])
        };
        let both = [2.0 + 1e-6; 2];
        // (1, -1) is an eigenvector to 1e-6
        for change in changes(Compliance::Dense(f.clone()), both, [1.0; 2]).unwrap() {
            assert!((change - 1e-3).abs() < 1e-8, "{change:e}");
        }
        // beside a node that is open, what the soft place gives
        let alone = changes(Compliance::Dense(f.clone()), [1.0 + 1e-6, 0.5], [1.0, 0.0]).unwrap();
        assert!((alone[0] - 1e-9).abs() < 1e-14 && alone[1] == 0.0);
        let applied = applied(&f, Mat::identity(2, 2));
        assert_eq!(changes(applied, both, [1.0; 2]), None);
    }
}
