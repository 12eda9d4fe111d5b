//! Can any admissible force balance the load? If not, along which rigid motion does the load pull the bodies away?
//!
//! {λ ∈ Λ, Gλ = e} is empty exactly when some z (r,) has Gᵀz ≤ 0 on the unilateral contacts, Gᵀz = 0 on the free
//! ones and eᵀz > 0 (Farkas): the motion z opens every contact, and the load does work on it. Both answers come from
//! min ‖Gλ − e‖ over λ ∈ Λ: its rest e − Gλ is zero, or it is such a z.
//!
//! Method: non-negative least squares by an active set in the manner of Lawson and Hanson; the dimension is r, the
//! number of modes, and m only counts columns. The same routine finds the least amplitude that opens all gaps.
//!
//! Tangential forces are left out: with friction, a negative answer means that normal forces alone do not suffice.

use crate::dual::{AdmissibleSet, Component, DualProblem, Equilibrium, uncontrolled_modes};

/// Work on a rigid motion below this part of the load's scale counts as none.
pub const NO_WORK: f64 = 1e-9;

/// Answer of [`DualProblem::feasibility`].
#[derive(Debug, Clone, PartialEq)]
pub enum Feasibility {
    /// Some admissible force balances the load.
    Feasible {
        /// Gλ of that force, (r,): e, or e without a part below 1e-9 of the load's scale that nothing can carry.
        load: Vec<f64>,
    },
    /// No admissible force balances the load.
    Infeasible {
        /// Amplitudes z (r,), unit length: the rigid motion along which the load pulls the bodies away.
        direction: Vec<f64>,
    },
}

impl DualProblem {
    /// Whether {λ ∈ Λ, Gλ = e} is empty, and why.
    pub fn feasibility(&self) -> Feasibility {
        Feasibility::of(&self.admissible, &self.equilibrium, self.scales.force)
    }
}

impl Feasibility {
    /// Whether {λ ∈ Λ, Gλ = e} is empty, and why; `force` is the scale of the loads, where it is larger than e.
    pub fn of(admissible: &AdmissibleSet, equilibrium: &Equilibrium, force: f64) -> Self {
        let (modes, load) = (&equilibrium.modes, &equilibrium.load);
        let r = load.len();
        let scale = load.iter().fold(force, |s, e| s.max(e.abs()));
        let no_work = NO_WORK * scale;
        let split = uncontrolled_modes(modes);
        // A driven mode that no contact controls.
        let mut direction = vec![0.0; r];
        for j in 0..split.uncontrolled.ncols() {
            let z = split.uncontrolled.col_as_slice(j);
            let work = dot(z, load);
            for (d, z) in direction.iter_mut().zip(z) {
                *d += work * z;
            }
        }
        if norm(&direction) > no_work {
            return Feasibility::Infeasible {
                direction: unit(direction),
            };
        }
        // The rest in the coordinates of the controlled modes.
        let k = split.controlled.ncols();
        let reduce = |v: &dyn Fn(usize) -> f64| -> Vec<f64> {
            (0..k)
                .map(|j| (0..r).map(|i| split.controlled[(i, j)] * v(i)).sum())
                .collect()
        };
        let mut columns: Vec<Vec<f64>> = Vec::new();
        for (i, component) in admissible.components().into_iter().enumerate() {
            let column = reduce(&|mode| modes[(mode, i)]);
            if component == Component::Free {
                columns.push(column.iter().map(|x| -x).collect());
            }
            if component != Component::Tangent {
                columns.push(column);
            }
        }
        let target = reduce(&|mode| load[mode]);
        let (_, rest) = least_squares_nonnegative(&columns, &target);
        let back = |v: &[f64]| -> Vec<f64> {
            (0..r)
                .map(|i| (0..k).map(|j| split.controlled[(i, j)] * v[j]).sum())
                .collect()
        };
        if norm(&rest) > no_work {
            return Feasibility::Infeasible {
                direction: unit(back(&rest)),
            };
        }
        let carried: Vec<f64> = target.iter().zip(&rest).map(|(t, rest)| t - rest).collect();
        Feasibility::Feasible {
            load: back(&carried),
        }
    }
}

/// x ≥ 0 that minimises ‖Σ xⱼ columnsⱼ − target‖, and the rest target − Σ xⱼ columnsⱼ.
pub fn least_squares_nonnegative(columns: &[Vec<f64>], target: &[f64]) -> (Vec<f64>, Vec<f64>) {
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
                // Walk towards the solution until a force reaches zero.
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

/// The columns that carry something, orthogonalised one after the other.
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
pub fn least_norm_within(rows: &[Vec<f64>], bounds: &[f64], q: usize) -> Option<Vec<f64>> {
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

fn unit(mut v: Vec<f64>) -> Vec<f64> {
    let length = norm(&v);
    v.iter_mut().for_each(|x| *x /= length);
    v
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(x, y)| x * y).sum()
}

fn norm(v: &[f64]) -> f64 {
    dot(v, v).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::dual::{AdmissibleSet, Block, Compliance, Equilibrium, Mat, Scales};

    /// A plate on two unilateral points at x = 0 and 1 (forces up), modes: lift and rotation.
    fn plate(load: [f64; 2], blocks: [Block; 2]) -> DualProblem {
        let modes = Mat::from_fn(2, 2, |i, j| if i == 0 { -1.0 } else { -(j as f64) });
        DualProblem {
            compliance: Compliance::Dense(Mat::from_fn(2, 2, |i, j| f64::from(i == j))),
            shift: vec![0.0; 2],
            admissible: AdmissibleSet::new(blocks.to_vec()),
            equilibrium: Equilibrium::new(modes, load.to_vec()),
            scales: Scales::default(),
        }
    }

    #[test]
    fn load_between_the_supports_is_carried() {
        let problem = plate([-1.0, -0.3], [Block::Unilateral; 2]);
        let Feasibility::Feasible { load } = problem.feasibility() else {
            panic!("the load lies between the supports");
        };
        assert!((load[0] + 1.0).abs() < 1e-14 && (load[1] + 0.3).abs() < 1e-14);
    }

    #[test]
    fn load_beside_the_supports_tips_the_plate() {
        let problem = plate([-1.0, -1.5], [Block::Unilateral; 2]);
        let Feasibility::Infeasible { direction } = problem.feasibility() else {
            panic!("the load lies beside the supports");
        };
        // It opens both contacts (G z ≤ 0 in each column), and the load works on it.
        for j in 0..2 {
            let image: f64 = (0..2)
                .map(|i| problem.equilibrium.modes[(i, j)] * direction[i])
                .sum();
            assert!(image < 1e-12, "contact {j}: {image}");
        }
        assert!(dot(&direction, &problem.equilibrium.load) > 0.1);
    }

    #[test]
    fn a_tie_carries_what_a_contact_cannot() {
        let tied = plate([-1.0, -1.5], [Block::Free { size: 1 }, Block::Unilateral]);
        assert!(matches!(tied.feasibility(), Feasibility::Feasible { .. }));
    }

    #[test]
    fn driven_mode_without_contact_is_named() {
        let mut problem = plate([-1.0, 0.5], [Block::Unilateral; 2]);
        problem.equilibrium.modes[(1, 0)] = 0.0;
        problem.equilibrium.modes[(1, 1)] = 0.0;
        let Feasibility::Infeasible { direction } = problem.feasibility() else {
            panic!("nothing holds mode 1");
        };
        assert_eq!(direction, vec![0.0, 1.0]);
        problem.equilibrium.load[1] = 1e-12;
        assert!(matches!(
            problem.feasibility(),
            Feasibility::Feasible { .. }
        ));
    }

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
