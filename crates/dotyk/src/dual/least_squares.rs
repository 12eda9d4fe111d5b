//! Least squares with signs: the nearest point of a cone that few vectors generate, and the nearest point of a polyhedron.
//!
//! ```text
//!   min ‖Σ xⱼ cⱼ − t‖  over x ≥ 0          the rest t − Σ xⱼ cⱼ is zero, or separates t from the cone of all cⱼ
//!   min ‖β‖            over Rβ ≤ b
//! ```
//!
//! The first is solved by an active set: the columns whose weight is positive are held orthogonal; the column along which the
//! rest falls most enters, and those whose weights would become negative leave. The length of t decides what a step costs, the
//! number of columns hardly counts. The second is the first with one component more.
//!
//! As described in Lawson & Hanson (1974), Solving least squares problems, chapter 23.

use crate::linalg::dense::{dot, norm};

/// x ≥ 0 that minimises ‖Σ xⱼ columnsⱼ − target‖, and the rest target − Σ xⱼ columnsⱼ.
pub(super) fn least_squares_nonnegative(
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
                    if value <= 0.0 && x[j] <= step * (x[j] - value) {
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
        // Twice: the second pass removes what rounding left.
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

    /// Keeps some columns: those behind the first that leaves are orthogonalised again.
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

/// β (q,) of least norm with Σ βⱼ rowsᵢⱼ ≤ boundsᵢ for every i, or `None` when there is none.
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

    #[test]
    fn nonnegative_least_squares_satisfies_its_optimality_conditions() {
        for seed in 0..100 {
            let wave = |i: usize, j: usize| ((seed * 97 + i * 31 + j * 17) as f64 * 0.73).sin();
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
}
