//! A solver from outside the library: only the forces of its answers are used, after a check of their shape.

use crate::dual::{DualProblem, Multipliers};
use crate::solve::{ContactSolver, Observer, Outcome, SolveError};

/// A solver from outside. Its answer must have the lengths of the problem, finite values and indices of contact unknowns; else
/// there is an error. Its forces never count as those of exact steps.
pub(crate) struct Foreign<'a>(pub &'a dyn ContactSolver);

impl Foreign<'_> {
    fn objection(&self, what: impl std::fmt::Display) -> SolveError {
        let name = self.name();
        SolveError::Invalid(format!("what \"{name}\" returned is no answer: {what}"))
    }

    fn checked(&self, problem: &DualProblem, outcome: Outcome) -> Result<Outcome, SolveError> {
        let shape = problem.check_multipliers(&outcome.multipliers);
        shape.map_err(|error| self.objection(error))?;
        Ok(Outcome {
            exact: false,
            bolts: Vec::new(),
            ..outcome
        })
    }
}

impl ContactSolver for Foreign<'_> {
    fn name(&self) -> &str {
        self.0.name()
    }

    fn solve(
        &self,
        problem: &DualProblem,
        guess: Option<&Multipliers>,
        observe: Observer<'_>,
    ) -> Result<Outcome, SolveError> {
        let (m, r) = (problem.len(), problem.balance.load().len());
        match self.0.solve(problem, guess, observe) {
            Ok(outcome) => self.checked(problem, outcome),
            Err(SolveError::NotConverged {
                method,
                outcome,
                residual,
                reason,
            }) => Err(SolveError::NotConverged {
                method,
                outcome: Box::new(self.checked(problem, *outcome)?),
                residual,
                reason,
            }),
            Err(SolveError::Infeasible { direction, .. })
                if direction.len() != r || !direction.iter().all(|z| z.is_finite()) =>
            {
                Err(self.objection(format!("a rigid motion has {r} finite amplitudes")))
            }
            Err(SolveError::DependentBolts { bolts, .. }) if bolts.iter().any(|&i| i >= m) => {
                Err(self.objection(format!("there are {m} contact unknowns for bolts")))
            }
            Err(error) => Err(error),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::dual::{Block, Compliance};
    use crate::linalg::Mat;
    use crate::solve::tests::{of, silent};
    use crate::solve::{Bolt, Newton};

    type Answer<'a> = dyn Fn(&DualProblem) -> Result<Outcome, SolveError> + Sync + 'a;

    struct Says<'a>(&'a Answer<'a>);

    impl ContactSolver for Says<'_> {
        fn name(&self) -> &str {
            "says"
        }

        fn solve(
            &self,
            problem: &DualProblem,
            _: Option<&Multipliers>,
            _: Observer<'_>,
        ) -> Result<Outcome, SolveError> {
            (self.0)(problem)
        }
    }

    /// Two springs of compliance 1 and one body that floats on them.
    fn problem() -> DualProblem {
        let f = Compliance::Dense(Mat::from_fn(2, 2, |i, j| f64::from(u8::from(i == j))));
        let modes = [vec![1.0, 1.0]];
        of(f, &[0.0, 0.5], vec![Block::Unilateral; 2], (&modes, &[2.0]))
    }

    fn solved(answer: &Answer<'_>) -> Result<Outcome, SolveError> {
        Foreign(&Says(answer)).solve(&problem(), None, &mut silent)
    }

    fn forces(lambda: &[f64], alpha: &[f64]) -> Outcome {
        let (lambda, alpha) = (lambda.to_vec(), alpha.to_vec());
        Outcome::new(Multipliers { lambda, alpha }, 3)
    }

    #[test]
    fn forces_and_remarks_are_taken_over_and_no_claim_of_exactness() {
        let answer = solved(&|problem| {
            let bolt = Bolt {
                index: 99,
                mode: 0,
                force: 1.0,
                moved: true,
            };
            let outcome = Newton::default().solve(problem, None, &mut silent)?;
            assert!(outcome.exact);
            Ok(Outcome {
                bolts: vec![bolt],
                remarks: vec!["said".to_string()],
                ..outcome
            })
        });
        let answer = answer.unwrap();
        let lambda = &answer.multipliers.lambda;
        assert!((lambda[0] - 0.75).abs() < 1e-12 && (lambda[1] - 1.25).abs() < 1e-12);
        assert!(!answer.exact && answer.bolts.is_empty());
        assert_eq!(answer.remarks, ["said"]);
    }

    #[test]
    fn answers_of_another_shape_are_errors_that_name_the_solver() {
        let wrong: [(&[f64], &[f64], &str); 4] = [
            (&[1.0], &[0.0], "λ has length 1, but 2 is expected"),
            (&[1.0, 1.0], &[], "α has length 0, but 1 is expected"),
            (&[1.0, f64::NAN], &[0.0], "entry 1 of λ is NaN"),
            (&[1.0, 1.0], &[f64::INFINITY], "entry 0 of α is inf"),
        ];
        for (lambda, alpha, expected) in wrong {
            let given_up = move |_: &DualProblem| SolveError::NotConverged {
                method: String::new(),
                outcome: Box::new(forces(lambda, alpha)),
                residual: 1.0,
                reason: String::new(),
            };
            let answers: [&Answer<'_>; 2] = [&|_| Ok(forces(lambda, alpha)), &|p| Err(given_up(p))];
            for answer in answers {
                let message = solved(answer).unwrap_err().to_string();
                assert!(
                    message.contains("\"says\"") && message.contains(expected),
                    "{message}"
                );
            }
        }
        let infeasible = |direction: &[f64]| SolveError::Infeasible {
            direction: direction.to_vec(),
            factor: None,
        };
        let bolts = |index: usize| SolveError::DependentBolts {
            bolts: vec![index],
            modes: 1,
        };
        let refused = |error: SolveError| {
            let said = error.clone();
            solved(&move |_| Err(said.clone())).unwrap_err() != error
        };
        assert!(refused(infeasible(&[])) && refused(infeasible(&[f64::NAN])));
        assert!(refused(bolts(2)));
        assert!(!refused(infeasible(&[1.0])) && !refused(bolts(1)));
    }
}
