//! Least squares with signs: the nearest point of a cone that few vectors generate, and the nearest point of a polyhedron.
//!
//! ```text
//!   min ‖Σ xⱼ cⱼ − t‖  over x ≥ 0          the rest t − Σ xⱼ cⱼ is zero, or separates t from the cone of all cⱼ
//!   min ‖β‖            over Rβ ≤ b
//! ```
//!
//! The first is solved by an active set: the rest is kept orthogonal to the columns with positive weights; the column along which
//! the rest decreases most enters, and columns whose weights would become negative leave. The cost of a step depends on the length
//! of t, and hardly on the number of columns. The second is the first with one more component.
//!
//! As described in Lawson & Hanson (1974), Solving least squares problems, chapter 23.

use crate::linalg::dense::{dot, norm};

/// x ≥ 0 that minimises ‖Σ xⱼ columnsⱼ − target‖, and the rest target − Σ xⱼ columnsⱼ.
pub(crate) fn least_squares_nonnegative(
    columns: &[Vec<f64>],
    target: &[f64],
) -> (Vec<f64>, Vec<f64>) {
    let mut x = vec![0.0; columns.len()];
    let mut rest = target.to_vec();
    let mut passive = Passive::new(columns, target);
    let mut barred = vec![false; columns.len()];
    let lengths: Vec<f64> = columns.iter().map(|column| norm(column)).collect();
    for _ in 0..10 * target.len() + 100 {
        let gain = |j: usize| dot(&columns[j], &rest) / lengths[j];
        let entering = (0..columns.len())
            .filter(|&j| lengths[j] > 0.0 && !barred[j] && !passive.has[j])
            .map(|j| (j, gain(j)))
            .max_by(|a, b| a.1.total_cmp(&b.1));
        let Some((entering, _)) = entering.filter(|(_, gain)| *gain > 1e-13 * norm(target)) else {
            break;
        };
        let before = norm(&rest);
        // A column that depends on the passive ones cannot enter.
        if passive.enter(entering) {
            loop {
                let solution = passive.solve();
                // Walk towards the solution until a weight reaches zero.
                let (mut step, mut blocking) = (1.0, None);
                for (&j, &value) in passive.index.iter().zip(&solution) {
                    // a step is at most 1: only weights that fall to zero or below come here
                    if x[j] <= step * (x[j] - value) {
                        (step, blocking) = (x[j] / (x[j] - value).max(f64::MIN_POSITIVE), Some(j));
                    }
                }
                for (&j, &value) in passive.index.iter().zip(&solution) {
                    x[j] = (x[j] + step * (value - x[j])).max(0.0);
                }
                let Some(blocking) = blocking else { break };
                x[blocking] = 0.0;
                passive.retain(|j| x[j] > 0.0);
                if passive.index.is_empty() {
                    break;
                }
            }
        }
        rest.copy_from_slice(target);
        for &j in &passive.index {
            for (rest, column) in rest.iter_mut().zip(&columns[j]) {
                *rest -= x[j] * column;
            }
        }
        // Without progress the column is barred until another one enters.
        if norm(&rest) < before * (1.0 - 1e-14) {
            barred.fill(false);
        } else {
            barred[entering] = true;
        }
    }
    (x, rest)
}

/// The columns whose weight is positive, orthogonalised one after the other.
struct Passive<'a> {
    columns: &'a [Vec<f64>],
    target: &'a [f64],
    index: Vec<usize>,
    has: Vec<bool>,
    /// Orthonormal columns, and the upper triangle that leads back, column by column.
    basis: Vec<Vec<f64>>,
    upper: Vec<Vec<f64>>,
    /// Components of the target in the basis.
    parts: Vec<f64>,
}

impl<'a> Passive<'a> {
    fn new(columns: &'a [Vec<f64>], target: &'a [f64]) -> Self {
        Self {
            columns,
            target,
            index: Vec::new(),
            has: vec![false; columns.len()],
            basis: Vec::new(),
            upper: Vec::new(),
            parts: Vec::new(),
        }
    }

    /// Adds a column; `false` when it depends on the others.
    fn enter(&mut self, index: usize) -> bool {
        let mut column = self.columns[index].clone();
        let length = norm(&column);
        let mut upper = vec![0.0; self.basis.len()];
        // Twice: the second pass removes rounding.
        for _ in 0..2 {
            for (upper, q) in upper.iter_mut().zip(&self.basis) {
                let part = dot(q, &column);
                *upper += part;
                for (c, q) in column.iter_mut().zip(q) {
                    *c -= part * q;
                }
            }
        }
        let left = norm(&column);
        if left <= 1e-11 * length {
            return false;
        }
        column.iter_mut().for_each(|c| *c /= left);
        upper.push(left);
        self.parts.push(dot(&column, self.target));
        self.basis.push(column);
        self.upper.push(upper);
        self.index.push(index);
        self.has[index] = true;
        true
    }

    /// Keeps some columns: those after the first that leaves are orthogonalised again.
    fn retain(&mut self, keep: impl Fn(usize) -> bool) {
        let first = self.index.iter().position(|&j| !keep(j));
        let Some(first) = first else { return };
        let behind = self.index.split_off(first);
        self.basis.truncate(first);
        self.upper.truncate(first);
        self.parts.truncate(first);
        for j in behind {
            self.has[j] = false;
            if keep(j) {
                self.enter(j);
            }
        }
    }

    /// Least squares with these columns.
    fn solve(&self) -> Vec<f64> {
        let mut x = self.parts.clone();
        for i in (0..x.len()).rev() {
            x[i] /= self.upper[i][i];
            let (head, tail) = x.split_at_mut(i);
            for (x, u) in head.iter_mut().zip(&self.upper[i]) {
                *x -= u * tail[0];
            }
        }
        x
    }
}

/// β (q,) of least norm with Σ βⱼ rowsᵢⱼ ≤ boundsᵢ for every i, or `None` without such a β.
///
/// Least distance programming: the rest of a non-negative least-squares problem of dimension q + 1.
pub(crate) fn least_norm_within(rows: &[Vec<f64>], bounds: &[f64], q: usize) -> Option<Vec<f64>> {
    let size = bounds.iter().fold(0.0, |s: f64, b| s.max(b.abs()));
    if bounds.iter().all(|&bound| bound >= 0.0) {
        return Some(vec![0.0; q]);
    }
    let columns: Vec<Vec<f64>> = rows
        .iter()
        .zip(bounds)
        .map(|(row, bound)| row.iter().map(|x| -x).chain([-bound / size]).collect())
        .collect();
    let mut target = vec![0.0; q + 1];
    target[q] = 1.0;
    let (_, rest) = least_squares_nonnegative(&columns, &target);
    // rest = target − [−Rᵀ; −bᵀ]x; the least point is −rest[..q] / rest[q].
    if rest[q] <= 1e-12 {
        return None;
    }
    Some(rest[..q].iter().map(|x| -x / rest[q] * size).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A number in [−1, 1]. Of the square: a sine of a sum of two indices would make matrices of rank 2.
    fn scattered(n: usize) -> f64 {
        ((n * n) as f64 * 0.073).sin()
    }

    #[test]
    fn nonnegative_least_squares_satisfies_its_optimality_conditions() {
        for seed in 0..100 {
            let wave = |i: usize, j: usize| scattered(seed * 97 + i * 31 + j * 17);
            let columns: Vec<Vec<f64>> = (0..20)
                .map(|j| (0..5).map(|i| wave(i, j)).collect())
                .collect();
            let columns = &columns[..3 + seed % 17];
            let target: Vec<f64> = (0..5).map(|i| wave(i, 50)).collect();
            let (x, rest) = least_squares_nonnegative(columns, &target);
            for (column, x) in columns.iter().zip(&x) {
                assert!(*x >= 0.0);
                let slope = dot(column, &rest);
                assert!(slope < 1e-12 && (slope * x).abs() < 1e-11, "{slope} {x}");
            }
        }
    }

    #[test]
    fn least_norm_point_lies_on_the_nearest_face() {
        // x + y ≤ −2: nearest point to the origin (−1, −1).
        let beta = least_norm_within(&[vec![1.0, 1.0], vec![1.0, 0.0]], &[-2.0, 5.0], 2).unwrap();
        assert!((beta[0] + 1.0).abs() < 1e-12 && (beta[1] + 1.0).abs() < 1e-12);
        assert_eq!(
            least_norm_within(&[vec![1.0], vec![-1.0]], &[-1.0, -1.0], 1),
            None
        );
    }

    #[test]
    fn answer_of_any_size_of_columns_is_that_of_unit_ones() {
        let wave = |i: usize, j: usize| scattered(i * 31 + j * 17);
        let columns: Vec<Vec<f64>> = (0..9)
            .map(|j| (0..5).map(|i| wave(i, j)).collect())
            .collect();
        let target: Vec<f64> = (0..5).map(|i| wave(i, 50)).collect();
        let expected = least_squares_nonnegative(&columns, &target);
        assert!(expected.0.iter().any(|x| *x > 0.1));
        let scaled = |columns: &[Vec<f64>], factor: f64| -> Vec<Vec<f64>> {
            let scale = |column: &Vec<f64>| column.iter().map(|c| factor * c).collect();
            columns.iter().map(scale).collect()
        };
        let near = |found: &[f64], factor: f64, expected: &[f64]| {
            let apart = |(a, b): (&f64, &f64)| (factor * a - b).abs();
            let worst = found.iter().zip(expected).map(apart).fold(0.0, f64::max);
            assert!(worst < 1e-12, "{found:?} {expected:?}");
        };
        for factor in [1e-9, 1e9] {
            let (x, rest) = least_squares_nonnegative(&scaled(&columns, factor), &target);
            near(&x, factor, &expected.0);
            near(&rest, 1.0, &expected.1);
            let large = scaled(std::slice::from_ref(&target), factor).remove(0);
            let (x, rest) = least_squares_nonnegative(&columns, &large);
            near(&x, 1.0 / factor, &expected.0);
            near(&rest, 1.0 / factor, &expected.1);
        }
    }

    #[test]
    fn least_rest_is_that_of_the_best_of_all_subsets() {
        // a face of the cone is held by a subset of the columns: the best with weights ≥ 0 is found among all of them
        for seed in 0..20 {
            let wave = |i: usize, j: usize| scattered(seed * 97 + i * 31 + j * 17);
            let columns: Vec<Vec<f64>> = (0..6)
                .map(|j| (0..3).map(|i| wave(i, j) + 0.4).collect())
                .collect();
            let target: Vec<f64> = (0..3).map(|i| wave(i, 50)).collect();
            let mut best = norm(&target);
            for subset in 1..64_usize {
                let chosen: Vec<usize> = (0..6).filter(|j| subset & (1 << j) != 0).collect();
                let mut passive = Passive::new(&columns, &target);
                if chosen.len() > 3 || !chosen.iter().all(|&j| passive.enter(j)) {
                    continue;
                }
                let x = passive.solve();
                if x.iter().all(|x| *x >= 0.0) {
                    let rest = |i: usize| {
                        let sum: f64 = chosen.iter().zip(&x).map(|(&j, x)| columns[j][i] * x).sum();
                        (target[i] - sum).powi(2)
                    };
                    best = best.min((0..3).map(rest).sum::<f64>().sqrt());
                }
            }
            let (_, rest) = least_squares_nonnegative(&columns, &target);
            assert!((norm(&rest) - best).abs() < 1e-12, "seed {seed}");
        }
    }

    #[test]
    fn columns_without_length_and_columns_twice_change_nothing() {
        let target = [1.0, 2.0];
        let columns = [
            vec![1.0, 0.0],
            vec![0.0, 0.0],
            vec![1.0, 0.0],
            vec![1.0, 1.0],
        ];
        let (x, rest) = least_squares_nonnegative(&columns, &target);
        // the nearest point along (1, 1) is (1.5, 1.5)
        assert!((x[3] - 1.5).abs() < 1e-15 && x[..3] == [0.0; 3], "{x:?}");
        assert!((rest[0] + 0.5).abs() < 1e-15 && (rest[1] - 0.5).abs() < 1e-15);
        let (x, rest) = least_squares_nonnegative(&[], &target);
        assert!(x.is_empty() && rest == target);
    }

    #[test]
    fn columns_enter_if_they_do_not_depend_on_others() {
        for size in [1e-12, 1.0, 1e12] {
            let columns = [
                vec![size, size, 0.0],
                vec![size, -size, 0.0],
                vec![size, 3.0 * size, 1e-12 * size],
                vec![size, 3.0 * size, 1e-10 * size],
            ];
            let mut passive = Passive::new(&columns, &[1.0, 2.0, 3.0]);
            assert!(passive.enter(0) && passive.enter(1));
            assert!(!passive.enter(2) && !passive.has[2]);
            assert!(passive.enter(3) && passive.has[3]);
            assert_eq!(passive.index, [0, 1, 3]);
        }
    }

    #[test]
    fn columns_that_stay_are_solved_for_as_if_they_had_come_alone() {
        let wave = |i: usize, j: usize| scattered(i * 31 + j * 17);
        let columns: Vec<Vec<f64>> = (0..5)
            .map(|j| (0..6).map(|i| wave(i, j)).collect())
            .collect();
        let target: Vec<f64> = (0..6).map(|i| wave(i, 50)).collect();
        let all = || {
            let mut passive = Passive::new(&columns, &target);
            assert!((0..5).all(|j| passive.enter(j)));
            passive
        };
        for gone in 0..5 {
            let mut passive = all();
            passive.retain(|j| j != gone);
            let kept: Vec<usize> = (0..5).filter(|&j| j != gone).collect();
            assert_eq!(passive.index, kept);
            assert!((0..5).all(|j| passive.has[j] == (j != gone)));
            let x = passive.solve();
            let mut rest = target.clone();
            for (&j, x) in kept.iter().zip(&x) {
                for (rest, c) in rest.iter_mut().zip(&columns[j]) {
                    *rest -= x * c;
                }
            }
            // least squares: the rest is orthogonal to every column that stays
            for &j in &kept {
                assert!(dot(&columns[j], &rest).abs() < 1e-14, "{gone} {j}");
            }
        }
        let mut passive = all();
        passive.retain(|_| true);
        assert_eq!(passive.index, [0, 1, 2, 3, 4]);
    }

    #[test]
    fn point_of_least_norm_is_pushed_by_the_bounds_that_it_meets_alone() {
        let (mut inside, mut outside) = (0, 0);
        for seed in 0..60 {
            let wave = |i: usize, j: usize| scattered(seed * 89 + i * 31 + j * 17);
            let size = [1.0, 1e-6, 1e6][seed % 3];
            let rows: Vec<Vec<f64>> = (0..4)
                .map(|i| (0..3).map(|j| wave(i, j)).collect())
                .collect();
            let bounds: Vec<f64> = (0..4).map(|i| size * wave(i, 50)).collect();
            let Some(beta) = least_norm_within(&rows, &bounds, 3) else {
                outside += 1;
                continue;
            };
            inside += 1;
            let slack = |i: usize| bounds[i] - dot(&rows[i], &beta);
            assert!((0..4).all(|i| slack(i) > -1e-11 * size), "seed {seed}");
            // −β is a sum of the rows that are met, with weights ≥ 0
            let met: Vec<Vec<f64>> = (0..4)
                .filter(|&i| slack(i) < 1e-10 * size)
                .map(|i| rows[i].clone())
                .collect();
            let push: Vec<f64> = beta.iter().map(|b| -b / size).collect();
            let (_, rest) = least_squares_nonnegative(&met, &push);
            assert!(norm(&rest) < 1e-9, "seed {seed} {rest:?}");
        }
        assert!(inside > 40, "{inside} {outside}");
    }

    #[test]
    fn bounds_that_zero_keeps_need_no_point() {
        assert_eq!(
            least_norm_within(&[vec![1.0, 2.0]], &[0.0], 2),
            Some(vec![0.0; 2])
        );
        assert_eq!(least_norm_within(&[], &[], 1), Some(vec![0.0]));
    }
}
