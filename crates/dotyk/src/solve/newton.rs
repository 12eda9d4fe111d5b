//! Newton's method on the states of contact nodes: few linear problems, exact answers, and a way out of every circle.
//!
//! Each node is open, sticks or slips. The states of all nodes give the forces by one linear solve, and the forces give the next
//! states. *Exact steps* (`exact.rs`) repeat this until the states no longer change: from a good start they end after a few,
//! with an exact answer. Two things can go wrong, and each has a remedy:
//!
//! * The start is far, so that the edge of a contact moves by a few nodes in each step and the steps grow with the mesh.
//!   Where there are many contacts, a problem with fewer of them is solved first, in which neighbours act as one
//!   (`levels.rs`). Its answer is right to a node. Where there is none and F is applied, those are closed at first that would overlap without contact forces.
//! * The states run in a circle. *Interior points* (`interior.rs`) guess no states; near the answer, and where F is not assembled,
//!   *proximal steps* (`proximal.rs`) come first: with given bounds of friction the solution is the minimum of a convex energy,
//!   which they lower each time, so that no state can come back. Where bounds follow from normal forces, as with Coulomb's law,
//!   there is no such energy: `slip.rs` treats those.
//!
//! Steps that led nowhere are taken back: a bad guess is worse than no guess.
//!
//! As described in Hintermüller, Ito & Kunisch (2003) for the exact steps; Rockafellar (1976) for the proximal point and
//! augmented Lagrangian methods, and the semismooth Newton methods on them since.

use crate::dual::{Compliance, Multipliers};
use crate::solve::exact::{COARSER, EXACT_STEPS, Ended, INTERIOR, NEAR, Patience, STALLED, Search};
use crate::solve::interior::{self, interior};
use crate::solve::proximal::proximal_steps;
use crate::solve::setup::{Forces, Setup};
use crate::solve::states::State;
use crate::solve::{FixedBounds, Observer, Outcome, SolveError, TOLERANCE, levels, slip};

/// One step from all contacts closed where a coarser problem may follow.
const ONE: Patience = Patience::new(1, 1.0);

/// Steps from all contacts closed where there is no coarser problem.
const PLAIN: Patience = Patience::new(7, f64::INFINITY);

/// The same where a rescue costs as much.
const LONG: Patience = Patience::new(20, f64::INFINITY).opening();

/// The same where interior points can follow. Steps that converge change fewer states each time or reduce the residual, once the
/// first ones have found most states: from the first step on a coarser problem, whose answer is only a guess.
const SETTLING: Patience = PLAIN.settling(5);
const ROUGH: Patience = PLAIN.settling(3);

/// Steps from a coarser problem, whose states are right but for a node.
const FROM_COARSE: Patience = NEAR.settling(2);

/// Most steps of a rescue where another follows: of 33 that energies answered from a coarser problem none took more than 24 steps,
/// but one 600.
const FEW: usize = 30;

/// With fewer blocks than this no coarser problem is solved.
const FEW_BLOCKS: usize = 96;

/// Newton's method.
#[derive(Debug, Clone, PartialEq)]
pub struct Newton {
    /// Residual below which an answer is accepted.
    pub tolerance: f64,
    /// Most linear solves, in solves of the size of the problem.
    pub max_iterations: usize,
}

impl Default for Newton {
    fn default() -> Self {
        Self {
            tolerance: TOLERANCE,
            max_iterations: 600,
        }
    }
}

impl FixedBounds for Newton {
    const NAME: &'static str = "newton";

    fn limits_mut(&mut self) -> (&mut f64, &mut usize) {
        (&mut self.tolerance, &mut self.max_iterations)
    }

    fn run(
        &self,
        setup: &Setup<'_>,
        guess: Option<&Multipliers>,
        observe: Observer<'_>,
    ) -> Result<Outcome, SolveError> {
        self.search(setup, guess, (&SETTLING, FROM_AFAR), observe)
    }

    fn run_coulomb(
        &self,
        setup: &Setup<'_>,
        guess: Option<&Multipliers>,
        observe: Observer<'_>,
    ) -> Result<Outcome, SolveError> {
        slip::solve(self, setup, guess, observe)
    }
}

/// A stage that follows where exact steps do not end, with its name: from the next states to its end.
type Rescue = (
    &'static str,
    fn(&mut Search<'_>, Vec<State>, Observer<'_>) -> Ended,
);

const BY_INTERIOR: Rescue = (INTERIOR, interior);
const FALLING: Rescue = ("energies that fall", proximal_steps);

/// How long steps from all contacts closed go on, and the rescues where they do not end.
type Course<'a> = (&'a Patience, &'a [Rescue]);

/// Rescues in their order.
const FROM_AFAR: &[Rescue] = &[BY_INTERIOR, FALLING];

/// The same from a coarser problem, whose states are right but for a node: energies fall to the answer at once.
const CLOSE: &[Rescue] = &[FALLING, BY_INTERIOR];

impl Newton {
    /// Searches from a guess, or from anywhere.
    fn search(
        &self,
        setup: &Setup<'_>,
        guess: Option<&Multipliers>,
        course: Course<'_>,
        observe: Observer<'_>,
    ) -> Result<Outcome, SolveError> {
        let mut search = Search::new(self.limits(), setup);
        let ended = match guess {
            Some(guess) => {
                let states = search.states_of_guess(guess)?;
                search.tried.push(EXACT_STEPS);
                from_near(&mut search, states, (&NEAR, course.1), observe)
            }
            None => from_anywhere(self, &mut search, course, observe),
        };
        match ended {
            Ended::Converged => Ok(search.outcome(false)),
            Ended::Stopped => Ok(search.outcome(true)),
            Ended::Stuck(_) => Err(search.not_converged(Self::NAME, STALLED)),
        }
    }
}

/// Exact steps from a presumably near start, then one rescue after the other from the same start.
fn from_near(
    search: &mut Search<'_>,
    states: Vec<State>,
    (patience, rescues): Course<'_>,
    observe: Observer<'_>,
) -> Ended {
    let start = (states.clone(), search.point.clone());
    match search.exact(states, patience, &|_, _| {}, observe) {
        Ended::Stuck(_) => rescued(search, start, rescues, observe),
        ended => ended,
    }
}

/// One rescue after the other from the same start, until one ends.
fn rescued(
    search: &mut Search<'_>,
    (states, point): (Vec<State>, Forces),
    rescues: &[Rescue],
    observe: Observer<'_>,
) -> Ended {
    let (most, inside) = (search.most, interior::serves(search.setup));
    for (place, (name, rescue)) in rescues.iter().enumerate() {
        search.point = point.clone();
        let states = states.clone();
        // energies that do not fall to an answer at once may fall for hundreds of steps
        let few = inside && place + 1 < rescues.len();
        search.most = if few {
            most.min(search.iterations() + FEW)
        } else {
            most
        };
        let ended = search.stage(name, |search| rescue(search, states, observe));
        search.most = most;
        if !matches!(ended, Ended::Stuck(_)) {
            return ended;
        }
    }
    Ended::Stuck(states)
}

/// Exact steps from all contacts closed; then, where there are many, from a coarser problem.
///
/// Where interior points can follow, a coarser problem that exact steps do not solve is abandoned: interior points take fewer steps
/// than a rescue on each of the levels.
fn from_anywhere(
    method: &Newton,
    search: &mut Search<'_>,
    (plain, rescues): Course<'_>,
    observe: Observer<'_>,
) -> Ended {
    let setup = search.setup;
    let inside = interior::serves(setup);
    let mut plain = if inside { plain } else { &PLAIN };
    let mut states = search.all_closed();
    search.tried.push(EXACT_STEPS);
    if setup.admissible.blocks().len() >= FEW_BLOCKS {
        match search.exact(states, &ONE, &|_, _| {}, observe) {
            Ended::Stuck(next) => states = next,
            ended => return ended,
        }
        if search.exhausted() {
            return Ended::Stuck(states);
        }
        let coarse = levels::start(setup, &|(tolerance, most), coarse, tell| {
            let rough = method.within(tolerance, most.min(method.max_iterations));
            let rescues = if inside { &[] } else { CLOSE };
            rough.search(coarse, None, (&ROUGH, rescues), tell)
        });
        if let Some(start) = coarse {
            let solved = start.solved;
            states = search.begin(start);
            search.tried.push(COARSER);
            if inside && !solved {
                return from_nothing(search, states, rescues, observe);
            }
            search.tried.push(EXACT_STEPS);
            return from_near(search, states, (&FROM_COARSE, CLOSE), observe);
        }
        if matches!(setup.problem.compliance, Compliance::Operator { .. }) {
            plain = &LONG;
            if let Some(fewer) = search.overlapping(&states) {
                let before = search.steps;
                match search.exact(fewer, plain, &|_, _| {}, observe) {
                    // these states have no solution
                    Ended::Stuck(_) if search.steps == before => {}
                    Ended::Stuck(states) => {
                        return from_nothing(search, states, rescues, observe);
                    }
                    ended => return ended,
                }
            }
        }
    }
    match search.exact(states, plain, &|_, _| {}, observe) {
        Ended::Stuck(states) => from_nothing(search, states, rescues, observe),
        ended => ended,
    }
}

/// One rescue after the other, each from zero forces.
fn from_nothing(
    search: &mut Search<'_>,
    states: Vec<State>,
    rescues: &[Rescue],
    observe: Observer<'_>,
) -> Ended {
    search.point.lambda.fill(0.0);
    let start = (states, search.point.clone());
    rescued(search, start, rescues, observe)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::dual::{Block, DualProblem};
    use crate::linalg::Mat;
    use crate::solve::tests::{apart, applied, by_trial, circle, definite, of, silent};
    use crate::solve::{ContactSolver, Iterate};
    use std::ops::ControlFlow;

    fn kinds(problem: &DualProblem, guess: Option<&Multipliers>) -> (Outcome, String) {
        let mut kinds = String::new();
        let outcome = Newton::default()
            .solve(problem, guess, &mut |at: &Iterate<'_>| {
                kinds.push(at.step);
                ControlFlow::Continue(())
            })
            .unwrap();
        (outcome, kinds)
    }

    #[test]
    fn interior_points_follow_where_exact_ones_circle_from_a_guess_and_without() {
        let problem = circle();
        let nothing = Multipliers {
            lambda: vec![0.0; 6],
            alpha: Vec::new(),
        };
        for guess in [None, Some(&nothing)] {
            let (outcome, kinds) = kinds(&problem, guess);
            assert!(problem.certify(&outcome.multipliers, 1e-8).holds());
            assert!(
                kinds.starts_with('n') && kinds.len() == outcome.iterations,
                "{kinds}"
            );
            assert!(kinds.len() <= 20, "{kinds}");
        }
        let (outcome, dense) = kinds(&problem, None);
        assert!(dense.contains('i') && !dense.contains('p'), "{dense}");
        assert_eq!(outcome.tried, [EXACT_STEPS, INTERIOR]);
        // where F is applied proximal steps answer
        let Compliance::Dense(f) = &problem.compliance else {
            panic!("F is assembled");
        };
        let mut other = circle();
        other.compliance = applied(f, Mat::identity(6, 6));
        let (outcome, applied) = kinds(&other, None);
        assert!(problem.certify(&outcome.multipliers, 1e-8).holds());
        assert!(applied.contains('p') && !applied.contains('i'), "{applied}");
        assert_eq!(outcome.tried, [EXACT_STEPS, FALLING.0]);
    }

    #[test]
    fn coarser_problem_is_asked_from_96_contacts_on() {
        // a chain whose pressed middle is wide: its edge moves in plain steps, and by a coarser problem at once
        let chain = |count: usize| {
            let middle = 0.5 * (count - 1) as f64;
            let shift: Vec<f64> = (0..count)
                .map(|i| 1.0 - ((i as f64 - middle) / (0.3 * count as f64)).powi(2))
                .collect();
            let blocks = vec![Block::Unilateral; count];
            let mut problem = of(
                Compliance::Dense(definite(count)),
                &shift,
                blocks,
                (&[], &[]),
            );
            problem.neighbours = (1..count).map(|i| [i - 1, i]).collect();
            problem
        };
        let solve = |problem: &DualProblem| {
            let mut count = 0;
            let outcome = Newton::default().solve(problem, None, &mut |_| {
                count += 1;
                ControlFlow::Continue(())
            });
            let outcome = outcome.unwrap();
            assert!(problem.certify(&outcome.multipliers, 1e-8).holds());
            let levels = [EXACT_STEPS, COARSER, EXACT_STEPS];
            let tried = &outcome.tried[..];
            assert!(tried == levels || tried == [EXACT_STEPS], "{tried:?}");
            // coarser steps are counted, and not shown
            outcome.iterations - count
        };
        assert_eq!(solve(&chain(FEW_BLOCKS - 1)), 0);
        assert!(solve(&chain(FEW_BLOCKS)) > 0);
        // nor do they exceed the allowed number
        for most in 1..=12 {
            let few = Newton::default().within(1e-8, most);
            let made = match few.solve(&chain(200), None, &mut silent) {
                Ok(outcome) => outcome.iterations,
                Err(SolveError::NotConverged { outcome, .. }) => outcome.iterations,
                Err(other) => panic!("{other}"),
            };
            assert!(made <= most, "{made} steps of {most}");
        }
        let mut alone = chain(FEW_BLOCKS);
        alone.neighbours.clear();
        assert_eq!(solve(&alone), 0);
    }

    #[test]
    fn too_few_steps_are_an_error_with_the_least_residual() {
        let problem = circle();
        let few = Newton::default().within(1e-8, 4);
        let mut least = f64::INFINITY;
        let error = few.solve(&problem, None, &mut |at: &Iterate<'_>| {
            least = least.min(at.residual);
            ControlFlow::Continue(())
        });
        let Err(SolveError::NotConverged {
            method,
            outcome,
            residual,
            reason,
        }) = error
        else {
            panic!("four steps do");
        };
        assert_eq!((method.as_str(), outcome.iterations), ("newton", 4));
        assert!(residual >= least && residual > 1e-8);
        assert_eq!(reason, STALLED);
        assert_eq!(outcome.tried.first(), Some(&EXACT_STEPS));
    }

    #[test]
    fn answer_as_a_guess_takes_one_step_and_another_guess_the_same_answer() {
        let shift = [1.0, -0.4, 0.7, 0.2, -1.0, 0.9, 0.8, 0.6];
        let f = definite(8);
        let blocks = vec![Block::Unilateral; 8];
        let problem = of(Compliance::Dense(f.clone()), &shift, blocks, (&[], &[]));
        let expected = by_trial(&f, &shift, (&[], &[]));
        let again = Newton::default()
            .solve(&problem, Some(&expected), &mut silent)
            .unwrap();
        assert_eq!((again.iterations, again.exact), (1, true));
        assert_eq!(again.tried, [EXACT_STEPS]);
        let wrong = Multipliers {
            lambda: vec![0.0, 1.0, 0.0, 0.0, 5.0, 0.0, 0.0, 0.0],
            alpha: Vec::new(),
        };
        let found = Newton::default()
            .solve(&problem, Some(&wrong), &mut silent)
            .unwrap();
        assert!(apart(&found.multipliers.lambda, &expected.lambda) < 1e-13);
        let stopped = Newton::default().solve(&problem, None, &mut |_| ControlFlow::Break(()));
        assert!(stopped.unwrap().stopped_by_observer);
    }
}
