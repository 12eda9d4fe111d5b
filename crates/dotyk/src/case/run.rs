//! A case as a run: solved step by step, with the last iterate where a step has no answer.

use crate::case::{Case, CaseError};
use crate::model::{Error, Objection, Solution, told_in_steps};
use std::fmt;

/// Result of a case.
#[derive(Debug)]
pub struct Run<const D: usize> {
    /// The load steps that have an answer, and after them the last iterate of the one that did not converge, if one did not.
    pub steps: Vec<Solution<D>>,
    /// Number of load steps of the case.
    pub count: usize,
    /// Why it ended early.
    pub failure: Option<Failure>,
}

/// A load step without an answer.
#[derive(Debug)]
pub struct Failure {
    /// Its number, from 1.
    pub step: usize,
    /// Its time.
    pub time: f64,
    /// Why, in words.
    pub reason: String,
    /// The part of it that the bodies can bear, where that is known.
    pub carried: Option<f64>,
    /// The error of the input; `None` where the iteration did not converge.
    pub refusal: Option<CaseError>,
}

impl<const D: usize> Case<D> {
    /// The run from the result of its load steps.
    pub(crate) fn became(&self, solved: Result<Vec<Solution<D>>, Error<D>>) -> Run<D> {
        let times = &self.model.times;
        let failed = |steps: &[Solution<D>], reason: String, refusal| Failure {
            step: steps.len() + 1,
            time: times.get(steps.len()).copied().unwrap_or(f64::NAN),
            reason,
            carried: None,
            refusal,
        };
        let (mut steps, failure) = match solved {
            Ok(steps) => (steps, None),
            Err(Error::NotConverged {
                reason,
                solution,
                earlier: mut steps,
            }) => {
                let mut failure = failed(&steps, reason.to_string(), None);
                if let Objection::Yields {
                    carried,
                    unlimited: false,
                    ..
                } = *reason
                {
                    failure.carried = carried;
                }
                steps.push(*solution);
                (steps, Some(failure))
            }
            Err(error) => {
                let refusal = self.error(error.subject().as_ref(), &error.to_string());
                let (steps, reason) = match error {
                    Error::Step {
                        source, earlier, ..
                    } => (earlier, source.to_string()),
                    other => (Vec::new(), other.to_string()),
                };
                let failure = failed(&steps, reason, Some(refusal));
                (steps, Some(failure))
            }
        };
        for step in &mut steps {
            step.seconds.read = self.seconds;
            step.seconds.total += self.seconds;
            self.warn_first(&mut step.warnings);
        }
        Run {
            steps,
            count: times.len(),
            failure,
        }
    }
}

impl<const D: usize> Run<D> {
    /// Every step has its certificate.
    pub fn certified(&self) -> bool {
        self.failure.is_none()
    }

    /// The steps to be written: those with an answer, or, if no step has an answer, the last iterate of the first.
    pub fn standing(&self) -> &[Solution<D>] {
        let certified = self.steps.iter().filter(|step| step.converged).count();
        &self.steps[..certified.max(1).min(self.steps.len())]
    }

    /// The failure that result files tell: of one of several steps, or with the part of the step that is carried.
    pub fn failed_step(&self) -> Option<&Failure> {
        let failure = self.failure.as_ref();
        failure.filter(|failure| self.count > 1 || failure.carried.is_some())
    }

    /// Iterations of all steps.
    pub fn iterations(&self) -> usize {
        self.steps.iter().map(|step| step.solver.iterations).sum()
    }

    /// Warnings of all written steps, each once; of warnings that differ only in figures the one with the largest.
    pub fn warnings(&self) -> Vec<String> {
        told_in_steps(self.standing().iter().map(|step| &step.warnings[..]))
    }
}

impl<const D: usize> fmt::Display for Run<D> {
    /// Why it ended early, with step and method; empty if it did not.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Some(failure) = &self.failure else {
            return Ok(());
        };
        if let Some(refusal) = &failure.refusal {
            return write!(f, "{refusal}");
        }
        if self.count > 1 {
            let Failure { step, time, .. } = failure;
            write!(f, "step {step} of {} (t = {time}): ", self.count)?;
        }
        let solver = self.steps.last().map(|last| &last.solver);
        if let Some(solver) = solver.filter(|solver| solver.iterations > 0) {
            let (iterations, method) = (solver.iterations, &solver.method);
            write!(
                f,
                "not converged after {iterations} iterations of {method}: "
            )?;
        }
        f.write_str(&failure.reason)
    }
}
