//! Exchange of one contact at a time: the primal active-set method, the last resort of [`crate::solve::Newton`].
//!
//! λ stays admissible and balanced. Solve on the face: where a force would turn into tension, go there only until the
//! first one vanishes, and leave that contact out; otherwise let the contact with the largest overlap join. The
//! objective never rises and no face comes back while it falls, so the method is finite; when λ does not move, the
//! first contact in order is chosen instead of the worst (Bland's rule), against cycles. Slow, one linear solve per
//! contact, but it starts from the face that MPRGP found. As described in textbooks of quadratic programming.

use std::ops::ControlFlow;

use crate::solve::newton::{Phase, Search};
use crate::solve::{Iterate, Observer, Setup, loaded};

/// A gap above minus this part of the length scale does not overlap.
const OVERLAP: f64 = 1e-13;

impl Search {
    /// Exchanges contacts from the forces in `face.lambda` until the residual passes.
    pub fn exchange(&mut self, setup: &Setup<'_>, observe: Observer<'_>) -> Phase {
        let m = setup.len();
        let mut current = vec![0.0; m];
        let mut tau = vec![0.0; setup.modes()];
        setup
            .projector()
            .project(&self.face.lambda, &mut tau, &mut current);
        let mut active: Vec<bool> = (0..m)
            .map(|i| !setup.bounded(i) || current[i] > 0.0)
            .collect();
        self.inner = self.tight();
        let mut still = 0;
        for _ in 0..20 * m + 200 {
            self.face.lambda.copy_from_slice(&current);
            self.step(setup, &active);
            let stopped = observe(&Iterate {
                iteration: self.iterations,
                lambda: &self.face.lambda,
                residual: self.residual,
                active: loaded(&self.face.lambda),
                step: 'x',
            });
            if stopped == ControlFlow::Break(()) {
                return Phase::Stopped;
            }
            if self.residual <= 1e-2 * self.tolerance {
                return Phase::Converged;
            }
            let bland = still > 2;
            match self.blocking(setup, &active, &current, bland) {
                Some((contact, part)) => {
                    for (own, target) in current.iter_mut().zip(&self.face.lambda) {
                        *own += part * (target - *own);
                    }
                    current[contact] = 0.0;
                    active[contact] = false;
                    still = if part > 0.0 { 0 } else { still + 1 };
                }
                None => {
                    current.copy_from_slice(&self.face.lambda);
                    match self.overlapping(setup, &active, bland) {
                        Some(contact) => active[contact] = true,
                        None if self.residual <= self.tolerance => return Phase::Converged,
                        None => return Phase::Stuck,
                    }
                }
            }
        }
        Phase::Stuck
    }

    /// The contact whose force vanishes first on the way from `current` to the solution on the face, and where.
    fn blocking(
        &self,
        setup: &Setup<'_>,
        active: &[bool],
        current: &[f64],
        bland: bool,
    ) -> Option<(usize, f64)> {
        let mut found: Option<(usize, f64)> = None;
        for i in (0..current.len()).filter(|&i| active[i] && setup.bounded(i)) {
            let target = self.face.lambda[i];
            if target >= 0.0 {
                continue;
            }
            let part = current[i] / (current[i] - target);
            let first = match found {
                None => true,
                // Ties: the contact that wants to pull most, or under Bland's rule the first in order.
                Some((other, least)) => {
                    part < least || (!bland && part == least && target < self.face.lambda[other])
                }
            };
            if first {
                found = Some((i, part));
            }
        }
        found
    }

    /// The inactive contact with the largest overlap; under Bland's rule the first in order.
    fn overlapping(&self, setup: &Setup<'_>, active: &[bool], bland: bool) -> Option<usize> {
        let scale = setup.problem.scales.length;
        let limit = -OVERLAP * if scale > 0.0 { scale } else { 1.0 };
        let gap = &self.judge.gap;
        let mut candidates = (0..gap.len()).filter(|&i| !active[i] && gap[i] < limit);
        if bland {
            return candidates.next();
        }
        candidates.min_by(|&a, &b| gap[a].total_cmp(&gap[b]))
    }
}
