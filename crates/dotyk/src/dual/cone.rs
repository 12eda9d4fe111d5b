//! The rest of a target t beyond a cone {Cx: x ≥ 0} of many sparse columns: y = t − Cx, x ≥ 0 such that ‖y‖ is least.
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
//! A step is one factorisation of I + C D Cᵀ, which is sparse where each body has few contacts. The last iterate is a good
//! guess, and one of two corrections makes it a verified answer: x > 0 moves by D Cᵀ(C D Cᵀ)⁻¹(t − Cx) with D = x², which
//! vanishes with x, until Cx = t; or t is projected onto the complement of the columns with xⱼ > sⱼ, and no other column
//! may gain on it.
//!
//! As described in Mehrotra (1992), On the implementation of a primal-dual interior point method.

use crate::linalg::dense::{dot, norm};
use crate::linalg::{Cholesky, LinalgError, SparseVector, WeightedGram};

/// ε² for columns and a target of unit length.
const BOUNDED: f64 = 1e-12;

/// Most steps of the interior point method; 15 to 30 are usual.
const CONE_STEPS: usize = 80;

/// Mean product xⱼsⱼ and residual where it has converged.
const CLOSE: f64 = 1e-13;
const SETTLED: f64 = 1e-11;

/// How far a step goes towards the border.
const BORDER: f64 = 0.995;

/// Most corrections; two are usual.
const CORRECTIONS: usize = 6;

/// Repetitions of a projection; columns that are nearly dependent take more of them.
const PROJECTIONS: usize = 60;

/// Rests below this part of the target are rounding.
const NO_REST: f64 = 1e-14;

/// Up to this rest the cone contains the target.
const CONTAINED: f64 = 1e-12;

/// Tolerance of column·rest: relative to the rest, or rounding of the target.
const GAIN: f64 = 1e-10;
const REST_ROUNDING: f64 = 1e-13;

/// Relative compliance of the columns to which the rest is to be orthogonal.
const STIFF: f64 = 1e-8;

/// The rest of `target` (k,) beyond the cone of `columns`, each (k,); `None` where no answer could be verified.
pub(super) fn rest(columns: &[SparseVector], target: &[f64]) -> Option<Vec<f64>> {
    Some(nearest(columns, target)?.rest)
}

/// The point of a cone that is nearest to a target.
pub(super) struct Nearest {
    /// Target minus that point, (k,), verified.
    pub rest: Vec<f64>,
    /// Weight of each column, ≥ 0, near those that lead there.
    pub weights: Vec<f64>,
}

/// The same with the weights of the columns.
pub(super) fn nearest(columns: &[SparseVector], target: &[f64]) -> Option<Nearest> {
    let size = norm(target);
    if size == 0.0 {
        return Some(Nearest {
            rest: target.to_vec(),
            weights: vec![0.0; columns.len()],
        });
    }
    let lengths: Vec<f64> = columns.iter().map(SparseVector::norm).collect();
    let sizeable = columns.iter().zip(&lengths).filter(|(_, l)| **l > 0.0);
    let columns: Vec<SparseVector> = sizeable.map(|(c, l)| c.scaled(1.0 / l)).collect();
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
    let mut x = point.x.iter();
    let weight = |l: &f64| match *l > 0.0 {
        true => x.next().map_or(0.0, |x| size * x / l),
        false => 0.0,
    };
    Some(Nearest {
        rest: rest.iter().map(|y| size * y).collect(),
        weights: lengths.iter().map(weight).collect(),
    })
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

/// Residuals of Cx + y = t and of s = ε²x − Cᵀy.
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
        for _ in 0..CONE_STEPS {
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

    /// The rest where the cone contains the target; zero weights stay zero.
    fn inside(&self, mut x: Vec<f64>) -> Option<Vec<f64>> {
        let mut best = self.rest(&x);
        for _ in 0..CORRECTIONS {
            if norm(&best) <= NO_REST {
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
        (norm(&best) <= CONTAINED).then_some(best)
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
            if change.fold(0.0, f64::max) <= NO_REST {
                break;
            }
        }
        let size = norm(&y);
        let separates = dot(&y, &self.target) > 0.0;
        let gains = self.gains(&y).into_iter().fold(0.0, f64::max);
        let away = y.iter().zip(&point.y).map(|(a, b)| (a - b).powi(2));
        let near = away.sum::<f64>().sqrt() <= 1e-4 * size;
        (separates && near && gains <= (GAIN * size).max(REST_ROUNDING)).then_some(y)
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
    use crate::linalg::signed::least_squares_nonnegative;

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
            // an answer that cannot be verified is left to the active set
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

    fn cone(columns: &[SparseVector], target: &[f64]) -> Cone {
        Cone {
            gram: WeightedGram::new(target.len(), columns).unwrap(),
            columns: columns.to_vec(),
            target: target.to_vec(),
        }
    }

    /// A target of unit length.
    fn target(k: usize, seed: usize) -> Vec<f64> {
        let target: Vec<f64> = (0..k).map(|i| ((i + seed) as f64 * 1.7).sin()).collect();
        let size = norm(&target);
        target.iter().map(|t| t / size).collect()
    }

    #[test]
    fn full_step_along_the_direction_solves_the_linear_equations() {
        let cone = cone(&joints(12, 3), &target(12, 3));
        let p = cone.columns.len();
        let wave = |i: usize| 1.0 + 0.5 * (i as f64 * 0.9).sin();
        let point = Iterate {
            x: (0..p).map(wave).collect(),
            s: (0..p).map(|j| wave(j + 7)).collect(),
            y: (0..12).map(|i| wave(i + 3) - 1.0).collect(),
        };
        let residual = cone.residual(&point);
        let weight = |j: usize| point.x[j] / (point.s[j] + BOUNDED * point.x[j]);
        let factor = cone.factor(weight, 1.0).unwrap();
        let asked = |j: usize| 0.3 - 0.2 * wave(2 * j);
        let step = cone.direction(&point, &residual, &factor, asked);
        let sum = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a + b).collect();
        let after = cone.residual(&Iterate {
            x: sum(&point.x, &step.x),
            s: sum(&point.s, &step.s),
            y: sum(&point.y, &step.y),
        });
        assert!(norm(&residual.primal) > 0.1 && norm(&residual.dual) > 0.1);
        assert!(norm(&after.primal) < 1e-12 && norm(&after.dual) < 1e-12);
        for j in 0..p {
            let change = point.x[j] * step.s[j] + point.s[j] * step.x[j];
            assert!((change - asked(j)).abs() < 1e-13);
        }
    }

    #[test]
    fn reach_ends_where_the_first_component_vanishes() {
        let iterate = |x: [f64; 2], s: [f64; 2]| Iterate {
            x: x.to_vec(),
            s: s.to_vec(),
            y: vec![-100.0],
        };
        let from = iterate([1.0, 2.0], [3.0, 4.0]);
        assert_eq!(iterate([-4.0, 1.0], [1.0, 0.0]).reach(&from), 0.25);
        assert_eq!(iterate([-4.0, -16.0], [1.0, -1.0]).reach(&from), 0.125);
        assert_eq!(iterate([1.0, 1.0], [-1.0, -8.0]).reach(&from), 0.5);
        // a step of BORDER times that is a full one
        assert_eq!(iterate([1.0, 0.0], [1.0, 0.0]).reach(&from), 1.0 / BORDER);
    }

    #[test]
    fn interior_point_ends_at_what_its_constants_promise() {
        for seed in 0..10 {
            let cone = cone(&joints(30, seed), &target(30, seed));
            let Iterate { x, s, y } = cone.interior().unwrap();
            assert!(x.iter().chain(&s).all(|x| *x > 0.0));
            assert!(dot(&x, &s) <= CLOSE * x.len() as f64);
            let mut primal = cone.target.clone();
            for (column, x) in cone.columns.iter().zip(&x) {
                column.add_to(-x, &mut primal);
            }
            let primal = primal.iter().zip(&y).map(|(a, b)| (a - b).powi(2));
            assert!(primal.sum::<f64>().sqrt() <= SETTLED);
            let dual = cone.columns.iter().zip(x.iter().zip(&s));
            let dual = dual.map(|(column, (x, s))| (BOUNDED * x - column.dot(&y) - s).powi(2));
            assert!(dual.sum::<f64>().sqrt() <= SETTLED);
        }
    }

    #[test]
    fn rest_is_a_proof_that_no_size_of_columns_or_target_changes() {
        let mut outside = 0;
        for seed in 0..20 {
            let (columns, target) = (&joints(30, seed)[..40], target(30, seed));
            let Some(expected) = rest(columns, &target) else {
                continue;
            };
            let size = norm(&expected);
            if size > 1e-6 {
                outside += 1;
                // it does work on the target, as much as its own square, and none on what the columns add up to
                assert!((dot(&expected, &target) - size * size).abs() < 1e-7);
                let gains = columns.iter().map(|c| c.dot(&expected) / c.norm());
                assert!(gains.fold(0.0, f64::max) <= 1e-7);
            }
            let mut scaled = columns.to_vec();
            for (j, column) in scaled.iter_mut().enumerate() {
                column.scale([1e-3, 1.0, 1e3][j % 3]);
            }
            scaled.insert(7, SparseVector::new(30, []));
            let large: Vec<f64> = target.iter().map(|t| 1e6 * t).collect();
            let found = rest(&scaled, &large).unwrap();
            for (found, expected) in found.iter().zip(&expected) {
                // √CLOSE, as above
                assert!((1e-6 * found - expected).abs() < 3e-7, "seed {seed}");
            }
        }
        assert!(outside >= 5, "{outside}");
    }

    #[test]
    fn a_target_of_zero_has_no_rest_and_one_across_all_columns_is_its_own() {
        let columns = [
            SparseVector::new(3, [(0, 2.0)]),
            SparseVector::new(3, [(1, 1.0)]),
        ];
        assert_eq!(rest(&columns, &[0.0; 3]), Some(vec![0.0; 3]));
        let near = |target: [f64; 3], expected: [f64; 3]| {
            let found = rest(&columns, &target).unwrap();
            assert!(
                (0..3).all(|i| (found[i] - expected[i]).abs() < 1e-9),
                "{found:?}"
            );
        };
        near([0.0, 0.0, 5.0], [0.0, 0.0, 5.0]);
        near([3.0, 4.0, 5.0], [0.0, 0.0, 5.0]);
        near([-3.0, 4.0, 0.0], [-3.0, 0.0, 0.0]);
        near([3.0, 4.0, 0.0], [0.0; 3]);
    }

    #[test]
    fn a_target_is_told_to_be_inside_only_where_forces_reach_it() {
        let columns = [SparseVector::new(2, [(0, 1.0)])];
        let across = cone(&columns, &[0.0, 1.0]);
        assert!(across.inside(vec![1.0]).is_none());
        let found = across.outside(&across.interior().unwrap()).unwrap();
        assert!(found[0].abs() < 1e-12 && (found[1] - 1.0).abs() < 1e-12);
        let along = cone(&columns, &[1.0, 0.0]);
        // from a force that is far off, too
        for start in [0.5, 1.0, 2.0] {
            assert!(
                along
                    .inside(vec![start])
                    .is_some_and(|rest| norm(&rest) <= NO_REST)
            );
        }
        assert!(along.outside(&along.interior().unwrap()).is_none());
    }
}
