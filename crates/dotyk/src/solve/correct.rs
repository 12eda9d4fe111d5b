//! Errors of forces that are judged by displacements, and their corrections, both by exact steps.
//!
//! A gap is a difference of displacements that may be much larger (a slender body, a stiff one carried by a soft one), so that
//! Fλ − d − Gᵀα is lost in the rounding of its terms, while the displacements still show it. *Increments* are free of that: at
//! forces λ with the gaps g of their displacements the exact step solves
//!
//! ```text
//!   wₐ·(g + F δλ − Gᵀδα) = 0,   G δλ = e − Gλ,   λ + δλ = offset + Σ xₐ cₐ
//! ```
//!
//! for the states of the trial forces of λ and g: iterative refinement, in which a few correct digits of F are enough.

use std::ops::ControlFlow;

use crate::dual::{Compliance, DualProblem, Multipliers};
use crate::solve::exact::{Ended, NEAR, Search, finest};
use crate::solve::hold::hold;
use crate::solve::setup::{Forces, Setup};
use crate::solve::spectrum::start;
use crate::solve::states::{State, unknowns};
use crate::solve::system::System;
use crate::solve::{FixedBounds, Newton};

/// Size of the random changes of gaps, in standard deviations of their rounding.
const DEVIATIONS: f64 = 3.0;

/// A contact is surely open if its gap exceeds its rounding by this factor.
const UNDECIDED: f64 = 10.0;

/// How often the rest of the gaps is solved for again: null vectors of a shifted matrix leave their rest unchanged, other vectors reduce it.
const AGAIN: usize = 6;

/// A force is not determined by gaps if its response to the remaining gap of a unit force exceeds this. Null vectors respond with the
/// inverse of the shift, 1e10; vectors with 2e-10 of the compliance of the others respond with less after so many repetitions.
pub(crate) const FREE: f64 = 1e8;

/// Increments of forces and rigid amplitudes by one exact step from the gaps `gap` of their displacements, known to `rounding`;
/// `None` where it cannot be solved, and for a crowd. Shapes: (m,).
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
        // the forces themselves are the start: their part of each unknown
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

/// Distance of each force from the answer that a few exact steps find nearby (m,): the error of the forces, however small their
/// gaps are. `None` where exact steps find no answer, where states do not determine the forces (as in a crowd), where all gaps
/// that should be closed are rounding already, and where F is only applied.
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

/// Change of forces with the uncertainty of gaps.
pub(crate) struct Open {
    /// Change of each force (m,) when gaps change by random numbers of some deviations of their rounding; NaN where that cannot be
    /// solved.
    pub change: Vec<f64>,
    /// Where states do not determine the forces, the response of each (m,) to the remaining random gaps of unit forces: above [`FREE`]
    /// where no gap determines the force. Empty where states determine the forces.
    pub free: Vec<f64>,
}

/// Change of forces when gaps change within `rounding` (m,). The states stay, except that contacts open by little more than
/// rounding may press. `None` where F is only applied, and for a crowd.
///
/// Forces that only a stiff side distinguishes change most, and random gaps have a part along them.
pub(crate) fn left_open(
    problem: &DualProblem,
    multipliers: &Multipliers,
    (gap, rounding): (&[f64], &[f64]),
) -> Option<Open> {
    if matches!(problem.compliance, Compliance::Operator { .. }) || problem.is_crowd() {
        return None;
    }
    let limits = Newton::default().limits();
    let mut setup = Setup::new(problem).ok()?;
    let states = Search::new(limits, &setup).states_asked_by(multipliers);
    let mut states = states.ok()?;
    for (state, (block, range)) in states.iter_mut().zip(setup.admissible.iter()) {
        let first = range.start;
        if !state.closed && gap[first].abs() <= UNDECIDED * rounding[first] {
            *state = State::sticking(block, true);
        }
    }
    setup.balance.set_load(vec![0.0; setup.modes()]);
    // a unit vector's numbers have a mean square of 1/m
    let size = DEVIATIONS * (rounding.len() as f64).sqrt();
    let random = start(rounding.len());
    let within = |gaps: &[f64]| -> Vec<f64> {
        let parts = gaps.iter().zip(&random);
        parts.map(|(gap, part)| gap * size * part).collect()
    };
    // forces, the gaps that they leave, and whether they are unique
    let mut answer = |gaps: Vec<f64>| {
        setup.shift = gaps;
        let (list, known) = unknowns(&setup.admissible, &states, None, &problem.softness);
        let mut system = System::new(&setup, list, vec![0.0; known.len()]);
        let found = system.solve(&Forces::none(&setup), finest(limits.0))?;
        let parts = setup.shift.iter().zip(&found.product);
        let mut left: Vec<f64> = parts.map(|(gap, closed)| gap - closed).collect();
        setup.balance.add_transposed(1.0, &found.alpha, &mut left);
        Some((found.lambda, left, system.unique))
    };
    let (mut change, mut free) = (vec![f64::NAN; rounding.len()], Vec::new());
    if let Some((found, _, unique)) = answer(within(rounding)) {
        change = found;
        let mut left = within(&problem.softness);
        for _ in 0..if unique { 0 } else { AGAIN } {
            (free, left, _) = answer(left)?;
        }
    }
    Some(Open { change, free })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::dual::{AdmissibleSet, Balance, Block, Friction};
    use crate::linalg::Mat;
    use crate::solve::setup::largest;
    use crate::solve::tests::{apart, applied, definite, of, silent};
    use crate::solve::{ContactSolver, Outcome};

    /// Contacts with a large common compliance and a small one of their own, which is known only to within `error`.
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
        // an applied compliance is not used
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
        // gaps that are rounding determine no forces
        let f = Mat::from_fn(2, 2, |i, j| f64::from(i == j));
        let blocks = vec![Block::Unilateral; 2];
        let problem = of(Compliance::Dense(f), &[0.5, 0.5], blocks, (&[], &[]));
        assert_eq!(distance_to_exact(&problem, &half(0.0)), None);
        let distance = largest(0.0, &distance_to_exact(&problem, &half(0.1)).unwrap());
        assert!((distance - 0.1).abs() < 1e-14);
    }

    #[test]
    fn rounding_changes_forces_that_a_stiff_side_alone_tells_apart() {
        // two forces on one soft place; their relative compliance is a millionth of its compliance
        let f = Mat::from_fn(2, 2, |i, j| if i == j { 1.0 + 1e-6 } else { 1.0 });
        let changes = |compliance: Compliance, shift: [f64; 2], lambda: [f64; 2]| {
            let problem = of(compliance, &shift, vec![Block::Unilateral; 2], (&[], &[]));
            let answer = Multipliers {
                lambda: lambda.to_vec(),
                alpha: Vec::new(),
            };
            left_open(&problem, &answer, (&problem.gap(&answer), &[1e-9; 2]))
        };
        let both = [2.0 + 1e-6; 2];
        // (1, -1) is an eigenvector to 1e-6, and both get the same of it
        let apart = changes(Compliance::Dense(f.clone()), both, [1.0; 2]).unwrap();
        let [own, other] = [0, 1].map(|i| DEVIATIONS * start(2)[i] * 2f64.sqrt() * 1e-9);
        let known = (0.5 * (own - other) / 1e-6).abs();
        let close = |x: &f64| (x.abs() / known - 1.0).abs() < 1e-5;
        assert!(known > 1e-5 && apart.change.iter().all(close) && apart.free.is_empty());
        // no gap distinguishes them
        let same = Mat::from_fn(2, 2, |_, _| 1.0);
        let same = changes(Compliance::Dense(same), [2.0; 2], [1.0; 2]).unwrap();
        assert!(same.free.len() == 2 && same.free.iter().all(|x| x.abs() > FREE));
        // beside an open node the compliance of the soft place counts; a node that touches within rounding may press
        let alone = |gap: f64| {
            let shift = [1.0 + 1e-6, 1.0 - gap];
            let open = changes(Compliance::Dense(f.clone()), shift, [1.0, 0.0]).unwrap();
            [0, 1].map(|i| open.change[i].abs())
        };
        let [own, other] = alone(0.5);
        assert!(own > 0.0 && own < DEVIATIONS * 2e-9 && other == 0.0);
        assert!(alone(1e-9).iter().all(close));
        let applied = applied(&f, Mat::identity(2, 2));
        assert!(changes(applied, both, [1.0; 2]).is_none());
    }
}
