//! Projection onto the admissible balanced forces: min 1/2‖λ − y‖² over λ ∈ Λ, Ĝλ = ê.
//!
//! λ(τ) = P_Λ(y − Ĝᵀτ) with the τ (k,) that balances it, h(τ) = Ĝλ(τ) − ê = 0. h is minus the gradient of a convex
//! function of τ, and it is piecewise linear without friction.
//! * k = 0: P_Λ alone.
//! * k = 1, free and unilateral blocks: h falls monotonically between the points yᵢ/gᵢ; sorting them and bisecting finds
//!   the root exactly, O(m log m) (continuous quadratic knapsack).
//! * otherwise: semismooth Newton in τ with regularised Jacobian ĜP′Ĝᵀ and line search on the convex function. A step
//!   of length 1 along h always descends, because the rows of Ĝ are orthonormal; it is taken when Newton's direction fails.
//!
//! Of many bodies the Jacobian is L⁻¹(MP′Mᵀ)L⁻ᵀ with the sparse M of [`Balance`]: entries only where two bodies touch, a
//! sparse factor. Of few bodies nothing is allocated after construction but one row of Ĝ at a time.

use crate::dual::{AdmissibleSet, Balance};
use crate::linalg::WeightedGram;
use crate::linalg::dense::{dot, norm};
use std::ops::Range;

/// Projects onto Λ ∩ {Ĝλ = ê}; keeps its workspace between calls.
pub struct Projector<'a> {
    admissible: &'a AdmissibleSet,
    balance: &'a Balance,
    bounds_only: bool,
    bounded: Vec<bool>,
    points: Vec<f64>,
    shifted: Vec<f64>,
    trial: Vec<f64>,
    column: Vec<f64>,
    imbalance: Vec<f64>,
    trial_imbalance: Vec<f64>,
    direction: Vec<f64>,
    trial_tau: Vec<f64>,
    jacobian: Jacobian,
}

/// Storage of the Jacobian of h.
enum Jacobian {
    /// (k, k), row-major.
    Dense(Vec<f64>),
    /// The pattern of MP′Mᵀ, absent where its factor would be too large (steps then go along h), and the position of each force
    /// in its block.
    Sparse {
        pattern: Option<Box<WeightedGram>>,
        position: Vec<usize>,
    },
}

impl Jacobian {
    fn new(admissible: &AdmissibleSet, balance: &Balance) -> Self {
        let k = balance.rank();
        if balance.is_orthonormal() {
            return Self::Dense(vec![0.0; k * k]);
        }
        let blocks: Vec<Range<usize>> = admissible.iter().map(|(_, range)| range).collect();
        let position = blocks.iter().flat_map(|block| 0..block.len()).collect();
        let pattern = WeightedGram::of_blocks(k, balance.columns(), blocks);
        Self::Sparse {
            pattern: pattern.ok().map(Box::new),
            position,
        }
    }
}

impl<'a> Projector<'a> {
    /// Workspace for the projections onto `admissible` ∩ {`balance`}.
    pub fn new(admissible: &'a AdmissibleSet, balance: &'a Balance) -> Self {
        let (m, k) = (admissible.len(), balance.rank());
        let bounded: Vec<bool> = admissible
            .iter()
            .flat_map(|(block, range)| range.map(move |_| !block.is_free()))
            .collect();
        Self {
            admissible,
            balance,
            bounds_only: !admissible.has_friction(),
            bounded,
            points: Vec::with_capacity(m),
            shifted: vec![0.0; m],
            trial: vec![0.0; m],
            column: vec![0.0; m],
            imbalance: vec![0.0; k],
            trial_imbalance: vec![0.0; k],
            direction: vec![0.0; k],
            trial_tau: vec![0.0; k],
            jacobian: Jacobian::new(admissible, balance),
        }
    }

    /// λ = P(y). `tau` (k,) holds the starting multiplier and receives the final one.
    ///
    /// Returns ‖Ĝλ − ê‖; it is far from rounding only when no admissible force balances the load.
    pub fn project(&mut self, y: &[f64], tau: &mut [f64], lambda: &mut [f64]) -> f64 {
        match self.balance.rank() {
            0 => {
                self.admissible.project(y, lambda);
                return 0.0;
            }
            1 if self.bounds_only && self.balance.is_orthonormal() => {
                tau[0] = self.breakpoint_search(y, lambda)
            }
            _ => self.newton(y, tau, lambda),
        }
        // y − Ĝᵀτ is rounded; a force below that is zero (it would press an open contact).
        let rounding = 16.0 * f64::EPSILON * y.iter().fold(0.0, |s: f64, y| s.max(y.abs()));
        for (block, range) in self.admissible.iter() {
            let bears = block.friction().is_none_or(|law| law.bears(false));
            if !bears && lambda[range.start] <= rounding {
                lambda[range].fill(0.0);
            } else if !block.is_free() {
                let none = lambda[range].iter_mut().filter(|l| l.abs() <= rounding);
                none.for_each(|l| *l = 0.0);
            }
        }
        if lambda.iter().all(|force| force.abs() <= rounding) {
            lambda.fill(0.0);
        }
        self.balance.imbalance(lambda, &mut self.imbalance);
        norm(&self.imbalance)
    }

    /// k = 1: the τ between two neighbouring breakpoints where the falling h crosses zero.
    fn breakpoint_search(&mut self, y: &[f64], lambda: &mut [f64]) -> f64 {
        let (row, load) = (self.balance.rows()[0].to_dense(), self.balance.target()[0]);
        let bounded = &self.bounded;
        self.points.clear();
        self.points.extend(
            (0..y.len())
                .filter(|&i| bounded[i])
                .map(|i| y[i] / row[i])
                // a component with a zero in the row has no breakpoint
                .filter(|point| point.is_finite()),
        );
        self.points.sort_unstable_by(f64::total_cmp);
        let imbalance = |tau: f64| -> f64 {
            let force = |i: usize| {
                let free = y[i] - tau * row[i];
                if bounded[i] { free.max(0.0) } else { free }
            };
            (0..y.len()).map(|i| row[i] * force(i)).sum::<f64>() - load
        };
        let next = self.points.partition_point(|&point| imbalance(point) > 0.0);
        let from = if next == 0 {
            f64::NEG_INFINITY
        } else {
            self.points[next - 1]
        };
        let to = self.points.get(next).copied().unwrap_or(f64::INFINITY);
        // (a component with a zero in the row adds nothing, whether it carries or not)
        let carries = |i: usize| {
            !bounded[i]
                || if row[i] > 0.0 {
                    y[i] / row[i] >= to
                } else {
                    y[i] / row[i] <= from
                }
        };
        let (mut slope, mut value) = (0.0, -load);
        for i in (0..y.len()).filter(|&i| carries(i)) {
            slope += row[i] * row[i];
            value += row[i] * y[i];
        }
        // Flat: no component carries, and any τ of the interval is a root; the smallest amplitude is taken.
        let tau = if slope > 0.0 { value / slope } else { 0.0 };
        let tau = tau.clamp(from, to);
        for i in 0..y.len() {
            let free = y[i] - tau * row[i];
            lambda[i] = if bounded[i] { free.max(0.0) } else { free };
        }
        self.spread_rest(&row, lambda);
        tau
    }

    /// Rounding in λ leaves a rest of the imbalance: spread it over the forces that can take it.
    fn spread_rest(&self, row: &[f64], lambda: &mut [f64]) {
        let (mut slope, mut value) = (0.0, -self.balance.target()[0]);
        for i in 0..lambda.len() {
            value += row[i] * lambda[i];
            if !self.bounded[i] || lambda[i] > 0.0 {
                slope += row[i] * row[i];
            }
        }
        if slope == 0.0 {
            return;
        }
        for i in 0..lambda.len() {
            let change = value / slope * row[i];
            if !self.bounded[i] || lambda[i] > change.max(0.0) {
                lambda[i] -= change;
            }
        }
    }

    /// Any k: semismooth Newton on h(τ) = 0 with line search on the convex function whose gradient is −h.
    fn newton(&mut self, y: &[f64], tau: &mut [f64], lambda: &mut [f64]) {
        let size = norm(y) + norm(self.balance.target());
        let mut value = self.evaluate(y, tau, lambda);
        let mut rest = norm(&self.imbalance);
        let mut still = 0;
        for _ in 0..200 {
            // Rounding of Ĝλ.
            if rest <= 4e-16 * (size + norm(lambda)) || still == 3 {
                break;
            }
            self.newton_direction(y, tau, rest / (size + norm(lambda)));
            let slope = dot(&self.direction, &self.imbalance);
            let (mut step, mut accepted) = (1.0, false);
            while step > 1e-4 {
                self.try_tau(tau, step, Towards::Newton);
                let trial = self.evaluate_trial(y);
                let trial_rest = norm(&self.trial_imbalance);
                // Near the root values differ by rounding only; the imbalance decides.
                if trial <= value - 1e-4 * step * slope || trial_rest < 0.5 * rest {
                    (value, accepted) = (trial, true);
                    break;
                }
                step *= 0.5;
            }
            if !accepted {
                self.try_tau(tau, 1.0, Towards::Gradient);
                value = self.evaluate_trial(y);
            }
            let trial_rest = norm(&self.trial_imbalance);
            let small = trial_rest.min(rest) <= 1e-12 * (size + norm(lambda));
            still = if small && trial_rest >= rest {
                still + 1
            } else {
                0
            };
            if small && trial_rest >= rest {
                continue;
            }
            tau.copy_from_slice(&self.trial_tau);
            lambda.copy_from_slice(&self.trial);
            self.imbalance.copy_from_slice(&self.trial_imbalance);
            rest = trial_rest;
        }
    }

    /// Trial τ = `tau` + `step` · direction.
    fn try_tau(&mut self, tau: &[f64], step: f64, towards: Towards) {
        let direction = match towards {
            Towards::Newton => &self.direction,
            Towards::Gradient => &self.imbalance,
        };
        for ((trial, tau), direction) in self.trial_tau.iter_mut().zip(tau).zip(direction) {
            *trial = tau + step * direction;
        }
    }

    /// Convex function, λ and h at `tau`.
    fn evaluate(&mut self, y: &[f64], tau: &[f64], lambda: &mut [f64]) -> f64 {
        self.trial_tau.copy_from_slice(tau);
        let value = self.evaluate_trial(y);
        lambda.copy_from_slice(&self.trial);
        self.imbalance.copy_from_slice(&self.trial_imbalance);
        value
    }

    /// −(1/2‖λ − y‖² + τ·h) at the trial τ, together with λ and h there.
    fn evaluate_trial(&mut self, y: &[f64]) -> f64 {
        self.shifted.copy_from_slice(y);
        self.balance
            .add_transposed(-1.0, &self.trial_tau, &mut self.shifted);
        self.admissible.project(&self.shifted, &mut self.trial);
        self.balance
            .imbalance(&self.trial, &mut self.trial_imbalance);
        let distance: f64 = self.trial.iter().zip(y).map(|(l, y)| (l - y).powi(2)).sum();
        -0.5 * distance - dot(&self.trial_tau, &self.trial_imbalance)
    }

    /// direction = (ĜP′Ĝᵀ + εI)⁻¹h with ε in proportion to the relative imbalance.
    fn newton_direction(&mut self, y: &[f64], tau: &[f64], relative: f64) {
        self.shifted.copy_from_slice(y);
        self.balance.add_transposed(-1.0, tau, &mut self.shifted);
        self.direction.copy_from_slice(&self.imbalance);
        let shift = relative.clamp(1e-15, 1e-2);
        match &mut self.jacobian {
            Jacobian::Dense(jacobian) => {
                dense_jacobian(
                    (self.admissible, self.balance),
                    &self.shifted,
                    &mut self.column,
                    jacobian,
                );
                let k = self.balance.rank();
                (0..k).for_each(|j| jacobian[j * k + j] += shift);
                solve_positive(jacobian, &mut self.direction);
            }
            Jacobian::Sparse { pattern, position } => {
                let parts = derivative(self.admissible, &self.shifted, position);
                let mut rest = self.balance.rest_of_rows(&self.imbalance);
                // more than ε where rounding makes the matrix singular
                let factor = [shift, 1e-12, 1e-8].into_iter().find_map(|least| {
                    let weight = |a: usize, b: usize| {
                        let own = if a == b { least.max(shift) } else { 0.0 };
                        parts[position[b]][a] + own
                    };
                    let pattern = pattern.as_ref()?;
                    pattern.factor(self.balance.columns(), weight, 0.0).ok()
                });
                if let Some(factor) = factor {
                    factor.solve(&mut rest);
                    self.direction = self.balance.from_rows(rest);
                }
            }
        }
    }
}

/// The columns of P′ at y, which is made of blocks: column c of all blocks together, (m,), for each place c in a block.
fn derivative(admissible: &AdmissibleSet, y: &[f64], position: &[usize]) -> Vec<Vec<f64>> {
    let last = position.iter().copied().max().unwrap_or(0);
    let column = |c: usize| {
        let units = position.iter().map(|&p| f64::from(u8::from(p == c)));
        let mut column = vec![0.0; y.len()];
        admissible.project_derivative(y, &units.collect::<Vec<f64>>(), &mut column);
        column
    };
    (0..=last).map(column).collect()
}

/// ĜP′Ĝᵀ at y of few orthonormal rows, (k, k); `column` is workspace (m,).
fn dense_jacobian(
    (admissible, balance): (&AdmissibleSet, &Balance),
    y: &[f64],
    column: &mut [f64],
    jacobian: &mut [f64],
) {
    let (rows, k) = (balance.rows(), balance.rank());
    for j in 0..k {
        admissible.project_derivative(y, &rows[j].to_dense(), column);
        for i in 0..=j {
            let product = rows[i].dot(column);
            (jacobian[i * k + j], jacobian[j * k + i]) = (product, product);
        }
    }
}

/// Direction of a trial step.
#[derive(Clone, Copy)]
enum Towards {
    Newton,
    Gradient,
}

/// x ← A⁻¹x for a small positive definite A (row-major, overwritten by its Cholesky factor); pivots below
/// rounding are lifted.
fn solve_positive(a: &mut [f64], x: &mut [f64]) {
    let k = x.len();
    for j in 0..k {
        for i in j..k {
            let known: f64 = (0..j).map(|l| a[i * k + l] * a[j * k + l]).sum();
            let rest = a[i * k + j] - known;
            a[i * k + j] = if i == j {
                rest.max(1e-15).sqrt()
            } else {
                rest / a[j * k + j]
            };
        }
    }
    for i in 0..k {
        let known: f64 = (0..i).map(|l| a[i * k + l] * x[l]).sum();
        x[i] = (x[i] - known) / a[i * k + i];
    }
    for i in (0..k).rev() {
        let known: f64 = (i + 1..k).map(|l| a[l * k + i] * x[l]).sum();
        x[i] = (x[i] - known) / a[i * k + i];
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::dual::split::tests::row_of_discs;
    use crate::dual::{Balance, Block, Friction, Mat};

    fn wave(m: usize, seed: usize) -> Vec<f64> {
        (0..m)
            .map(|i| ((i * 37 + seed * 101) as f64 * 0.61).sin() + 0.3)
            .collect()
    }

    fn mixed(m: usize, friction: bool) -> AdmissibleSet {
        let mut blocks = vec![Block::Free { size: 2 }];
        if friction {
            blocks.push(Friction::Tresca { bound: 0.4 }.block(2));
            blocks.push(Friction::Coulomb { coefficient: 0.3 }.block(1));
        }
        let rest = m - AdmissibleSet::new(blocks.clone()).len();
        blocks.extend(vec![Block::Unilateral; rest]);
        AdmissibleSet::new(blocks)
    }

    /// Balance of `k` smooth modes with a load that an admissible force carries.
    fn balance(set: &AdmissibleSet, k: usize, seed: usize) -> Balance {
        let m = set.len();
        let modes = Mat::from_fn(k, m, |i, j| {
            ((j as f64 / m as f64) * (i + 1) as f64 * 2.0).cos()
        });
        let mut carried = vec![0.0; m];
        set.project(&wave(m, seed + 5), &mut carried);
        let load = (0..k)
            .map(|i| (0..m).map(|j| modes[(i, j)] * carried[j]).sum())
            .collect();
        Balance::new(modes, load)
    }

    /// Nearest ⇔ y − λ − Ĝᵀτ is in the normal cone, that is λ = P_Λ(y − Ĝᵀτ).
    fn nearest(set: &AdmissibleSet, balance: &Balance, y: &[f64]) {
        let (mut tau, mut lambda) = (vec![0.0; balance.rank()], vec![0.0; y.len()]);
        let rest = Projector::new(set, balance).project(y, &mut tau, &mut lambda);
        assert!(rest < 1e-12 * norm(y), "{rest:e}");
        let mut shifted = y.to_vec();
        balance.add_transposed(-1.0, &tau, &mut shifted);
        let mut again = vec![0.0; y.len()];
        set.project(&shifted, &mut again);
        let apart = again.iter().zip(&lambda).map(|(a, b)| (a - b).abs());
        let worst = apart.fold(0.0, f64::max);
        assert!(worst < 1e-12 * norm(y), "{worst:e}");
    }

    #[test]
    fn projection_is_admissible_balanced_and_nearest() {
        for k in 0..=4 {
            for friction in [false, true] {
                for seed in 0..20 {
                    let set = mixed(30, friction);
                    let balance = balance(&set, k, seed);
                    let y: Vec<f64> = wave(30, seed).iter().map(|x| 10.0 * (x - 0.4)).collect();
                    nearest(&set, &balance, &y);
                }
            }
        }
    }

    #[test]
    fn projection_of_the_forces_between_many_bodies_is_admissible_balanced_and_nearest() {
        let modes = row_of_discs(60);
        let m = modes.ncols();
        let pair = |j: usize| match j % 3 {
            0 => vec![Block::Unilateral; 2],
            1 => vec![Friction::Tresca { bound: 0.4 }.block(1)],
            _ => vec![Friction::Coulomb { coefficient: 0.3 }.block(1)],
        };
        let set = AdmissibleSet::new((0..m / 2).flat_map(pair).collect());
        for seed in 0..10 {
            let mut carried = vec![0.0; m];
            set.project(&wave(m, seed + 5), &mut carried);
            let load = (0..modes.nrows()).map(|i| (0..m).map(|j| modes[(i, j)] * carried[j]).sum());
            let balance = Balance::new(modes.clone(), load.collect());
            assert!(!balance.is_orthonormal());
            let y: Vec<f64> = wave(m, seed).iter().map(|x| 10.0 * (x - 0.4)).collect();
            nearest(&set, &balance, &y);
        }
    }

    #[test]
    fn breakpoint_search_and_newton_agree() {
        for seed in 0..50 {
            let set = mixed(25, false);
            let balance = balance(&set, 1, seed);
            let mut projector = Projector::new(&set, &balance);
            let y = wave(25, seed + 1);
            let (mut exact, mut iterated) = (vec![0.0; 25], vec![0.0; 25]);
            let mut tau = [0.0];
            projector.project(&y, &mut tau, &mut exact);
            projector.newton(&y, &mut [0.0], &mut iterated);
            for i in 0..25 {
                assert!((exact[i] - iterated[i]).abs() < 1e-13);
            }
        }
    }

    #[test]
    fn unloaded_hovering_body_gets_no_force() {
        for k in [1, 2] {
            let set = AdmissibleSet::new(vec![Block::Unilateral; 6]);
            let modes = Mat::from_fn(k, 6, |i, j| 1.0 + (i * j) as f64 * 0.1);
            let balance = Balance::new(modes, vec![0.0; k]);
            let mut projector = Projector::new(&set, &balance);
            let (mut tau, mut lambda) = (vec![0.0; k], vec![1.0; 6]);
            projector.project(&[1.0, 2.0, -1.0, 0.5, 3.0, 0.0], &mut tau, &mut lambda);
            assert!(norm(&lambda) < 1e-13);
            projector.project(&[-1.0; 6], &mut [0.0, 0.0][..k], &mut lambda);
            assert_eq!(norm(&lambda), 0.0);
        }
    }

    #[test]
    fn load_that_nothing_can_carry_leaves_an_imbalance() {
        let set = AdmissibleSet::new(vec![Block::Unilateral; 4]);
        for k in [1, 2] {
            let modes = Mat::from_fn(k, 4, |i, j| 1.0 + (i * j) as f64);
            let balance = Balance::new(modes, vec![-1.0; k]);
            let rest =
                Projector::new(&set, &balance).project(&[1.0; 4], &mut vec![0.0; k], &mut [0.0; 4]);
            assert!(rest > 0.1);
        }
    }

    #[test]
    fn forces_that_nothing_balances_are_projected_alone() {
        // no τ is subtracted, so that no rounding is cleared: a force beside 1 may be 1e-17
        let set = AdmissibleSet::new(vec![Block::Unilateral; 3]);
        let none = Balance::none(3);
        let mut lambda = [9.0; 3];
        let rest = Projector::new(&set, &none).project(&[1.0, 1e-17, -2.0], &mut [], &mut lambda);
        assert_eq!((rest, lambda), (0.0, [1.0, 1e-17, 0.0]));
    }

    #[test]
    fn traces_of_forces_are_cleared_but_of_ties() {
        let one = |block: Block| vec![block; 3];
        let of = |blocks: Vec<Block>, y: &[f64], row: &[f64]| {
            let set = AdmissibleSet::new(blocks);
            let load: f64 = row.iter().zip(y).map(|(row, y)| row * y).sum();
            let balance = Balance::new(Mat::from_fn(1, y.len(), |_, j| row[j]), vec![load]);
            let mut lambda = vec![9.0; y.len()];
            Projector::new(&set, &balance).project(y, &mut [0.0], &mut lambda);
            lambda
        };
        // of a largest number of 1 up to 16 ε = 3.6e-15 is rounding
        let y = [1.0, 2e-15, 1e-14];
        let found = of(one(Block::Unilateral), &y, &[1.0; 3]);
        assert!((found[0] - 1.0).abs() < 1e-15 && found[1] == 0.0);
        assert!((found[2] - 1e-14).abs() < 1e-15);
        let found = of(one(Block::Free { size: 1 }), &y, &[1.0; 3]);
        assert!((found[1] - 2e-15).abs() < 1e-15 && found[1] != 0.0);
        // an open node bears its shear only where the bound is given
        let y = [1.0, 0.0, 2e-15, 1e-15];
        let row = [1.0, 0.0, 1.0, 0.0];
        let coulomb = Friction::Coulomb { coefficient: 0.9 }.block(1);
        assert_eq!(of(vec![coulomb; 2], &y, &row)[2..], [0.0, 0.0]);
        let tresca = Friction::Tresca { bound: 0.5 }.block(1);
        let y = [1.0, 1e-15, 2e-15, 0.25];
        let found = of(vec![tresca; 2], &y, &row);
        assert!((found[0] - 1.0).abs() < 1e-14 && found[1..] == [0.0, 0.0, 0.25]);
    }

    #[test]
    fn motion_of_a_body_that_nothing_holds_is_the_one_at_which_its_last_force_goes() {
        let set = AdmissibleSet::new(vec![Block::Unilateral; 2]);
        let motion = |y: [f64; 2], load: f64| {
            let balance = Balance::new(Mat::from_fn(1, 2, |_, _| 1.0), vec![load]);
            let (mut tau, mut lambda) = ([9.0], [9.0; 2]);
            let rest = Projector::new(&set, &balance).project(&y, &mut tau, &mut lambda);
            assert_eq!(lambda, [0.0; 2]);
            // of the row (1, 1)/√2
            assert!((rest + load / 2f64.sqrt()).abs() < 1e-15);
            tau[0] * balance.column(0)[0]
        };
        let near = |found: f64, expected: f64| assert!((found - expected).abs() < 1e-15, "{found}");
        near(motion([-1.0, -2.0], 0.0), -1.0);
        near(motion([1.0, 2.0], 0.0), 2.0);
        // a load that pulls determines no distance: the shortest one is taken
        near(motion([-1.0, -2.0], -1.0), 0.0);
        near(motion([1.0, 2.0], -1.0), 2.0);
    }

    #[test]
    fn what_rounding_leaves_of_the_balance_is_spread_over_forces_that_can_take_it() {
        let spread = |set: AdmissibleSet, row: [f64; 4], load: f64, lambda: [f64; 4]| {
            let balance = Balance::new(Mat::from_fn(1, 4, |_, j| row[j]), vec![load]);
            // the row of norm 1, of whatever sign
            let own = balance.rows()[0].to_dense();
            let mut lambda = lambda;
            Projector::new(&set, &balance).spread_rest(&own, &mut lambda);
            lambda
        };
        let near = |a: [f64; 4], b: [f64; 4]| {
            assert!((0..4).all(|i| (a[i] - b[i]).abs() < 1e-15), "{a:?} {b:?}");
        };
        let contacts = || AdmissibleSet::new(vec![Block::Unilateral; 4]);
        // too little: the two contacts that bear take half of it each
        let found = spread(contacts(), [1.0; 4], 2.0, [0.5, 0.25, 0.0, 0.0]);
        near(found, [1.125, 0.875, 0.0, 0.0]);
        // too much: a force that is less than its part is left as it is
        let found = spread(contacts(), [1.0; 4], 2.0, [3.0, 0.125, 0.0, 0.0]);
        near(found, [3.0 - 0.5625, 0.125, 0.0, 0.0]);
        let ties = AdmissibleSet::new(vec![Block::Free { size: 4 }]);
        let found = spread(ties, [1.0; 4], 2.0, [3.0, 0.0, -1.0, 1.0]);
        near(found, [2.75, -0.25, -1.25, 0.75]);
        // where no force can take it, a tie that does no work on the motion stays unchanged, too
        let blocks = [vec![Block::Free { size: 1 }], vec![Block::Unilateral; 3]].concat();
        let set = AdmissibleSet::new(blocks);
        let found = spread(set, [0.0, 1.0, 1.0, 1.0], 0.5, [5.0, 0.0, 0.0, 0.0]);
        assert_eq!(found, [5.0, 0.0, 0.0, 0.0]);
    }

    /// Frictional sets with few and with many bodies, and forces to project.
    fn cases() -> [(AdmissibleSet, Balance, Vec<f64>); 2] {
        let set = mixed(20, true);
        let few = balance(&set, 3, 1);
        let modes = row_of_discs(40);
        let m = modes.ncols();
        let law = Friction::Coulomb { coefficient: 0.3 };
        let pairs = (0..m / 2).flat_map(|j| match j % 3 {
            0 => vec![Block::Unilateral; 2],
            _ => vec![law.block(1)],
        });
        let load = (0..modes.nrows()).map(|i| (0.7 * i as f64).sin()).collect();
        let many = Balance::new(modes, load);
        let y = |m: usize| wave(m, 3).iter().map(|y| 4.0 * y).collect();
        let pairs = AdmissibleSet::new(pairs.collect());
        [(set, few, y(20)), (pairs, many, y(m))]
    }

    #[test]
    fn imbalance_is_minus_the_slope_of_the_convex_function() {
        for (set, balance, y) in &cases() {
            let k = balance.rank();
            let mut projector = Projector::new(set, balance);
            let at: Vec<f64> = wave(k, 8).iter().map(|t| 0.3 * t).collect();
            let mut value = |tau: &[f64]| {
                let value = projector.evaluate(y, tau, &mut vec![0.0; y.len()]);
                (value, projector.imbalance.clone())
            };
            let imbalance = value(&at).1;
            let h = 1e-5;
            for j in 0..k.min(10) {
                let mut moved = |step: f64| {
                    let mut tau = at.clone();
                    tau[j] += step;
                    value(&tau).0
                };
                // a piecewise quadratic function of size 100, differences of 1e-5
                let slope = (moved(h) - moved(-h)) / (2.0 * h);
                assert!(
                    (slope + imbalance[j]).abs() < 1e-4,
                    "{slope} {}",
                    imbalance[j]
                );
            }
        }
    }

    #[test]
    fn direction_is_newtons_with_a_shift_in_proportion_to_the_imbalance() {
        for (set, balance, y) in &cases() {
            let (k, m) = (balance.rank(), y.len());
            let tau: Vec<f64> = wave(k, 8).iter().map(|t| 0.3 * t).collect();
            let mut shifted = y.clone();
            balance.add_transposed(-1.0, &tau, &mut shifted);
            for (relative, shift) in [(0.5, 1e-2), (1e-3, 1e-3)] {
                let mut projector = Projector::new(set, balance);
                projector.evaluate(y, &tau, &mut vec![0.0; m]);
                projector.newton_direction(y, &tau, relative);
                // ĜP′Ĝᵀd + εd = h
                let (mut pull, mut moved) = (vec![0.0; m], vec![0.0; m]);
                balance.add_transposed(1.0, &projector.direction, &mut pull);
                set.project_derivative(&shifted, &pull, &mut moved);
                let mut image = vec![0.0; k];
                balance.apply(&moved, &mut image);
                let terms = image.iter().zip(&projector.direction);
                for ((image, direction), imbalance) in terms.zip(&projector.imbalance) {
                    let left = image + shift * direction - imbalance;
                    assert!(left.abs() < 1e-10, "{left:e}");
                }
            }
        }
    }

    #[test]
    fn a_small_system_is_solved_by_its_factor_and_lost_pivots_are_lifted() {
        for k in 1..=4 {
            let b = |i: usize, j: usize| ((i * 5 + j * 3) as f64).sin();
            let entry = |i: usize, j: usize| {
                let product: f64 = (0..k).map(|l| b(i, l) * b(j, l)).sum();
                product + f64::from(i == j)
            };
            let a: Vec<f64> = (0..k * k).map(|n| entry(n / k, n % k)).collect();
            let expected = wave(k, 2);
            let mut x: Vec<f64> = (0..k)
                .map(|i| (0..k).map(|j| entry(i, j) * expected[j]).sum())
                .collect();
            solve_positive(&mut a.clone(), &mut x);
            for (x, expected) in x.iter().zip(&expected) {
                assert!((x - expected).abs() < 1e-14);
            }
        }
        let (mut a, mut x) = ([0.0], [2e-15]);
        solve_positive(&mut a, &mut x);
        assert!((x[0] - 2.0).abs() < 1e-14);
    }

    #[test]
    fn projection_of_forces_that_are_balanced_already_is_themselves() {
        for (set, balance, y) in cases() {
            let mut admissible = vec![0.0; y.len()];
            set.project(&y, &mut admissible);
            let mut balanced = balance.clone();
            balanced.set_load(balance.modes().product(&admissible));
            let (mut tau, mut lambda) = (vec![0.0; balance.rank()], vec![0.0; y.len()]);
            let rest = Projector::new(&set, &balanced).project(&admissible, &mut tau, &mut lambda);
            assert!(rest < 1e-13 * norm(&y), "{rest:e}");
            for (a, b) in admissible.iter().zip(&lambda) {
                assert!((a - b).abs() < 1e-13 * norm(&y));
            }
        }
    }
}
