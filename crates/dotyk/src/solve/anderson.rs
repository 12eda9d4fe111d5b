//! Anderson's acceleration of a fixed point iteration t ← T(t): the next point would be the fixed point if T were linear, as
//! estimated from the last steps.
//!
//! ```text
//!   r = T(t) − t        γ minimises ‖r − Σ γⱼ Δrⱼ‖        next t = T(t) − Σ γⱼ (Δtⱼ + Δrⱼ)
//! ```
//!
//! Source: Walker & Ni (2011), Anderson acceleration for fixed-point iterations, SIAM J. Numer. Anal. 49, 1715–1735.

use std::collections::VecDeque;

use crate::linalg::Mat;
use crate::linalg::dense::{cholesky_in_place, dot, norm, solve_cholesky_in_place};

/// Steps that are remembered.
const MEMORY: usize = 20;

/// The normal equations of γ are shifted by this part of their trace: differences of late steps are nearly parallel.
const SHIFT: f64 = 1e-10;

/// An accelerated step after which the residual exceeds this multiple of the one before is taken back.
const WORSE: f64 = 2.0;

/// One remembered step.
struct Difference {
    /// Δt + Δr.
    moved: Vec<f64>,
    /// Δr.
    residual: Vec<f64>,
    /// Δr · Δr of this step and of those before it, oldest first.
    products: VecDeque<f64>,
}

/// Where the iteration was.
struct Place {
    image: Vec<f64>,
    residual: Vec<f64>,
    accelerated: bool,
}

/// The memory of the iteration.
#[derive(Default)]
pub(crate) struct Anderson {
    differences: VecDeque<Difference>,
    last: Option<Place>,
}

impl Anderson {
    /// The next point, from `image` = T(t) and `residual` = T(t) − t; the same metric serves all components.
    pub fn next(&mut self, image: Vec<f64>, residual: Vec<f64>) -> Vec<f64> {
        if let Some(last) = self.last.take() {
            if last.accelerated && norm(&residual) > WORSE * norm(&last.residual) {
                self.differences.clear();
                return last.image;
            }
            self.remember(&last, &image, &residual);
        }
        let mut next = image.clone();
        let weights = self.weights(&residual);
        let accelerated = weights.is_some();
        for (difference, weight) in self.differences.iter().zip(weights.into_iter().flatten()) {
            let moved = next.iter_mut().zip(&difference.moved);
            moved.for_each(|(next, moved)| *next -= weight * moved);
        }
        self.last = Some(Place {
            image,
            residual,
            accelerated,
        });
        next
    }

    fn remember(&mut self, last: &Place, image: &[f64], residual: &[f64]) {
        if self.differences.len() == MEMORY {
            self.differences.pop_front();
            for difference in &mut self.differences {
                difference.products.pop_front();
            }
        }
        // t + r = T(t)
        let minus =
            |a: &[f64], b: &[f64]| -> Vec<f64> { a.iter().zip(b).map(|(a, b)| a - b).collect() };
        let (moved, own) = (minus(image, &last.image), minus(residual, &last.residual));
        let others = self.differences.iter().map(|d| dot(&d.residual, &own));
        let products = others.chain([dot(&own, &own)]).collect();
        self.differences.push_back(Difference {
            moved,
            residual: own,
            products,
        });
    }

    /// γ, oldest first; `None` without remembered steps.
    fn weights(&self, residual: &[f64]) -> Option<Vec<f64>> {
        let n = self.differences.len();
        let product = |i: usize, j: usize| self.differences[i.max(j)].products[i.min(j)];
        let trace: f64 = (0..n).map(|i| product(i, i)).sum();
        if trace <= 0.0 {
            return None;
        }
        let mut normal = Mat::from_fn(n, n, product);
        for i in 0..n {
            normal[(i, i)] += SHIFT * trace;
        }
        cholesky_in_place(&mut normal).ok()?;
        let differences = self.differences.iter();
        let mut weights: Vec<f64> = differences.map(|d| dot(&d.residual, residual)).collect();
        solve_cholesky_in_place(&normal, &mut weights);
        weights.iter().all(|w| w.is_finite()).then_some(weights)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn linear_iterations_in_n_unknowns_end_after_n_further_steps() {
        // T(t) = Mt + b with eigenvalues up to 0.99: plain steps would take a thousand
        let n = 6;
        let slow = |i: usize| 0.99 - 0.15 * i as f64;
        let image = |t: &[f64]| -> Vec<f64> {
            let mean = t.iter().sum::<f64>() / n as f64;
            let part = |(i, t): (usize, &f64)| slow(i) * t - 0.01 * mean + 1.0 + i as f64;
            t.iter().enumerate().map(part).collect()
        };
        let (mut t, mut anderson) = (vec![0.0; n], Anderson::default());
        let mut left = f64::INFINITY;
        for _ in 0..n + 4 {
            let image = image(&t);
            let residual: Vec<f64> = image.iter().zip(&t).map(|(a, b)| a - b).collect();
            left = norm(&residual);
            t = anderson.next(image, residual);
        }
        assert!(left < 1e-7 * norm(&t), "{left}");
    }

    #[test]
    fn a_step_that_made_things_worse_is_taken_back_and_forgotten() {
        let mut anderson = Anderson::default();
        assert_eq!(anderson.next(vec![1.0, 0.0], vec![1.0, 0.0]), [1.0, 0.0]);
        let second = anderson.next(vec![1.5, 0.0], vec![0.5, 0.0]);
        assert!((second[0] - 2.0).abs() < 1e-8, "{second:?}");
        // the iteration goes on from where no acceleration would have led
        assert_eq!(anderson.next(vec![9.0, 9.0], vec![7.0, 9.0]), [1.5, 0.0]);
        assert!(anderson.differences.is_empty() && anderson.last.is_none());
    }

    #[test]
    fn only_the_last_steps_are_remembered() {
        let mut anderson = Anderson::default();
        for i in 0..MEMORY + 5 {
            let value = 1.0 / (1.0 + i as f64);
            anderson.next(vec![value, 1.0], vec![value * value, 0.3 * value]);
        }
        assert_eq!(anderson.differences.len(), MEMORY);
        for (i, difference) in anderson.differences.iter().enumerate() {
            assert_eq!(difference.products.len(), i + 1);
            let own = dot(&difference.residual, &difference.residual);
            assert_eq!(difference.products[i], own);
        }
    }
}
