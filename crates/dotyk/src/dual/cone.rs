//! What is left of a target beyond a cone {Cx: x ≥ 0} of many sparse columns: y = t − Cx of the x ≥ 0 that minimises ‖y‖.
//!
//! y is the projection onto the polar cone, hence unique: Cᵀy ≤ 0 and y·(t − y) = 0. It is zero where the cone contains t,
//! and else proves that it does not (Farkas): Cᵀy ≤ 0 and y·t > 0.
//!
//! Interior point method on
//!
//! ```text
//!   min 1/2 ‖t − Cx‖² + 1/2 ε²‖x‖²,  x ≥ 0:      y = t − Cx,   s = ε²x − Cᵀy ≥ 0,   xⱼsⱼ = 0
//! ```
//!
//! with Mehrotra's predictor and corrector; ε keeps x bounded where bodies may be clamped against each other by any force.
//! A step is one factorisation of I + C D Cᵀ, which is as sparse as the contacts between bodies are few. Its end is a good
//! guess of the answer, and one of two corrections makes it one that can be checked: x > 0 moves by D Cᵀ(C D Cᵀ)⁻¹(t − Cx)
//! with D = x², which vanishes where x does, until Cx = t; or t is projected onto the complement of the columns with
//! xⱼ > sⱼ, and the others must not gain on it.
//!
//! As described in Mehrotra (1992), On the implementation of a primal-dual interior point method.

use crate::linalg::dense::{dot, norm};
use crate::linalg::{Cholesky, LinalgError, SparseVector, WeightedGram};

/// ε² for columns and a target of unit length.
const BOUNDED: f64 = 1e-12;

/// Steps of the interior point method: 15 to 30 do.
const STEPS: usize = 80;

/// Mean product xⱼsⱼ and residual at its end.
const CLOSE: f64 = 1e-13;
const SETTLED: f64 = 1e-11;

/// How far a step goes towards the border.
const BORDER: f64 = 0.995;

/// Corrections; two mostly do.
const CORRECTIONS: usize = 6;

/// Repetitions of a projection; columns that are nearly dependent take more of them.
const PROJECTIONS: usize = 60;

/// Rests below this part of the target are rounding.
const NOTHING: f64 = 1e-14;

/// Rests up to here answer that the cone contains the target.
const INSIDE: f64 = 1e-12;

/// Columns may gain that much on a rest: relative to it, or what is rounding of the target.
const GAIN: f64 = 1e-10;
const ROUNDING: f64 = 1e-13;

/// Compliance of the columns that the rest is to have no part along, relative to what it leaves free.
const STIFF: f64 = 1e-8;

/// The rest of `target` (k,) beyond the cone of `columns`, each (k,); `None` where no answer could be verified.
pub(super) fn rest(columns: &[SparseVector], target: &[f64]) -> Option<Vec<f64>> {
    let size = norm(target);
    if size == 0.0 {
        return Some(target.to_vec());
    }
    let unit = |column: &SparseVector| {
        let mut column = column.clone();
        column.scale(1.0 / column.norm());
        column
    };
    let sizeable = columns.iter().filter(|column| column.norm() > 0.0);
    let columns: Vec<SparseVector> = sizeable.map(unit).collect();
    let target: Vec<f64> = target.iter().map(|t| t / size).collect();
    let cone = Cone {
        gram: WeightedGram::new(target.len(), &columns).ok()?,
        columns,
        target,
    };
    let point = cone.interior()?;
    let inside = cone.inside(point.x.clone());
    let rest = match inside {
        Some(rest) => rest,
        None => cone.outside(&point)?,
    };
    Some(rest.iter().map(|y| size * y).collect())
}

struct Cone {
    columns: Vec<SparseVector>,
    target: Vec<f64>,
    gram: WeightedGram,
}

struct Iterate {
    x: Vec<f64>,
    s: Vec<f64>,
    y: Vec<f64>,
}

/// What a point leaves of Cx + y = t and of s = ε²x − Cᵀy.
struct Residual {
    primal: Vec<f64>,
    dual: Vec<f64>,
}

impl Cone {
    /// Cᵀy.
    fn gains(&self, y: &[f64]) -> Vec<f64> {
        self.columns.iter().map(|column| column.dot(y)).collect()
    }

    /// t − Cx.
    fn rest(&self, x: &[f64]) -> Vec<f64> {
        let mut rest = self.target.clone();
        for (column, x) in self.columns.iter().zip(x) {
            column.add_to(-x, &mut rest);
        }
        rest
    }

    fn residual(&self, point: &Iterate) -> Residual {
        let gains = self.gains(&point.y);
        let dual = point.x.iter().zip(&point.s).zip(gains);
        Residual {
            primal: (self.rest(&point.x).iter().zip(&point.y))
                .map(|(rest, y)| rest - y)
                .collect(),
            dual: dual.map(|((x, s), gain)| BOUNDED * x - gain - s).collect(),
        }
    }

    /// The end of the interior point method; `None` where it does not get there.
    fn interior(&self) -> Option<Iterate> {
        let p = self.columns.len();
        let first = 1.0 / (self.target.len() as f64).sqrt();
        let mut point = Iterate {
            x: vec![first; p],
            s: vec![first; p],
            y: Vec::new(),
        };
        point.y = self.rest(&point.x);
        for _ in 0..STEPS {
            let residual = self.residual(&point);
            let mean = dot(&point.x, &point.s) / p.max(1) as f64;
            let open = norm(&residual.primal).max(norm(&residual.dual));
            if mean <= CLOSE && open <= SETTLED {
                return Some(point);
            }
            let factor = self.factor(|j| point.x[j] / (point.s[j] + BOUNDED * point.x[j]), 1.0);
            let factor = factor.ok()?;
            let products = |j: usize| point.x[j] * point.s[j];
            let affine = self.direction(&point, &residual, &factor, |j| -products(j));
            let reach = affine.reach(&point);
            let mut after = 0.0;
            for j in 0..p {
                after += (point.x[j] + reach * affine.x[j]) * (point.s[j] + reach * affine.s[j]);
            }
            let centre = mean * (after / p.max(1) as f64 / mean).powi(3);
            let corrected = |j: usize| centre - products(j) - affine.x[j] * affine.s[j];
            let step = self.direction(&point, &residual, &factor, corrected);
            let reach = (BORDER * step.reach(&point)).min(1.0);
            let move_by = |to: &mut [f64], by: &[f64]| {
                to.iter_mut().zip(by).for_each(|(to, by)| *to += reach * by);
            };
            move_by(&mut point.x, &step.x);
            move_by(&mut point.s, &step.s);
            move_by(&mut point.y, &step.y);
        }
        None
    }

    fn factor(&self, weight: impl Fn(usize) -> f64, shift: f64) -> Result<Cholesky, LinalgError> {
        self.gram.factor(&self.columns, |a, _| weight(a), shift)
    }

    /// Newton's direction towards xⱼsⱼ + `products`ⱼ.
    fn direction(
        &self,
        point: &Iterate,
        residual: &Residual,
        factor: &Cholesky,
        products: impl Fn(usize) -> f64,
    ) -> Iterate {
        // (s + ε²x) dx = products − x (dual − Cᵀdy),  C dx + dy = primal
        let free = |j: usize, gain: f64| {
            let (x, s) = (point.x[j], point.s[j]);
            (products(j) - x * (residual.dual[j] - gain)) / (s + BOUNDED * x)
        };
        let mut y = residual.primal.clone();
        for (j, column) in self.columns.iter().enumerate() {
            column.add_to(-free(j, 0.0), &mut y);
        }
        factor.solve(&mut y);
        let x: Vec<f64> = (self.gains(&y).into_iter().enumerate())
            .map(|(j, gain)| free(j, gain))
            .collect();
        let s = (0..x.len()).map(|j| (products(j) - point.s[j] * x[j]) / point.x[j]);
        Iterate {
            s: s.collect(),
            x,
            y,
        }
    }

    /// The rest where the cone contains the target: of forces that stay where they are zero.
    fn inside(&self, mut x: Vec<f64>) -> Option<Vec<f64>> {
        let mut best = self.rest(&x);
        for _ in 0..CORRECTIONS {
            if norm(&best) <= NOTHING {
                break;
            }
            let largest = x.iter().fold(0.0, |s: f64, x| s.max(*x));
            let shift = 1e-14 * largest * largest;
            let factor = self.factor(|j| x[j] * x[j], shift).ok()?;
            let mut move_by = best.clone();
            factor.solve(&mut move_by);
            let gains = self.gains(&move_by);
            let moved: Vec<f64> = (x.iter().zip(&gains))
                .map(|(x, gain)| (x + x * x * gain).max(0.0))
                .collect();
            let rest = self.rest(&moved);
            if norm(&rest) >= norm(&best) {
                break;
            }
            (x, best) = (moved, rest);
        }
        (norm(&best) <= INSIDE).then_some(best)
    }

    /// The rest where the cone does not contain the target.
    fn outside(&self, point: &Iterate) -> Option<Vec<f64>> {
        let bears = |j: usize| f64::from(point.x[j] > point.s[j]);
        let factor = self.factor(|j| bears(j) / STIFF, 1.0).ok()?;
        let mut y = self.target.clone();
        for _ in 0..PROJECTIONS {
            let before = y.clone();
            factor.solve(&mut y);
            let change = y.iter().zip(&before).map(|(a, b)| (a - b).abs());
            if change.fold(0.0, f64::max) <= NOTHING {
                break;
            }
        }
        let size = norm(&y);
        let separates = size > 0.0 && dot(&y, &self.target) > 0.0;
        let gains = self.gains(&y).into_iter().fold(0.0, f64::max);
        let away = y.iter().zip(&point.y).map(|(a, b)| (a - b).powi(2));
        let near = away.sum::<f64>().sqrt() <= 1e-4 * size;
        (separates && near && gains <= (GAIN * size).max(ROUNDING)).then_some(y)
    }
}

impl Iterate {
    /// How far `from` may go in this direction until a component of x or s is zero.
    fn reach(&self, from: &Self) -> f64 {
        let both = (self.x.iter().zip(&from.x)).chain(self.s.iter().zip(&from.s));
        let falling = both.filter(|(direction, _)| **direction < 0.0);
        falling.fold(1.0 / BORDER, |reach: f64, (d, at)| reach.min(-at / d))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::dual::least_squares::least_squares_nonnegative;

    /// Columns that each meet two of k places, some of them clamping against each other.
    fn joints(k: usize, seed: usize) -> Vec<SparseVector> {
        let wave = |i: usize| ((i * 37 + seed * 101) as f64 * 0.61).sin();
        (0..3 * k)
            .map(|j| {
                let i = j % (k - 1);
                SparseVector::new(k, [(i, wave(j)), (i + 1, wave(j + 1000))])
            })
            .collect()
    }

    #[test]
    fn rest_is_that_of_the_active_set() {
        let mut answered = 0;
        for seed in 0..40 {
            let columns = &joints(30, seed)[..30 + seed];
            let target: Vec<f64> = (0..30).map(|i| ((i + seed) as f64 * 1.7).sin()).collect();
            let dense: Vec<Vec<f64>> = columns.iter().map(SparseVector::to_dense).collect();
            let expected = least_squares_nonnegative(&dense, &target).1;
            // what cannot be checked is left to the active set
            let Some(found) = rest(columns, &target) else {
                continue;
            };
            answered += 1;
            for (found, expected) in found.iter().zip(&expected) {
                // √CLOSE: a column whose force and gain both vanish may be taken to bear or not
                assert!(
                    (found - expected).abs() < 3e-7,
                    "seed {seed}: {found} {expected}"
                );
            }
        }
        assert!(answered >= 36, "{answered} of 40");
    }

    #[test]
    fn cone_contains_what_its_columns_add_up_to() {
        for seed in 0..40 {
            let columns = joints(30, seed);
            let mut target = vec![0.0; 30];
            for (j, column) in columns.iter().enumerate() {
                // most columns bear nothing
                let part = if j % 3 == 0 {
                    1.0 + (j as f64).sin()
                } else {
                    0.0
                };
                column.add_to(part, &mut target);
            }
            let found = rest(&columns, &target).unwrap_or_else(|| panic!("seed {seed}"));
            assert!(norm(&found) <= 1e-12 * norm(&target), "seed {seed}");
        }
    }
}
