//! Can any admissible force balance the load? If not, along which rigid motion does the load pull the bodies away?
//!
//! {λ ∈ Λ, Gλ = e} is empty exactly when some z (r,) has Gᵀz ≤ 0 on the unilateral contacts, Gᵀz = 0 on the free
//! ones and eᵀz > 0 (Farkas): the motion z opens every contact, and the load does work on it. Both answers come from
//! min ‖Gλ − e‖ over λ ∈ Λ: its rest e − Gλ is zero, or it is such a z.
//!
//! Method: non-negative least squares by an active set in the manner of Lawson and Hanson; the dimension is r, the
//! number of modes, and m only counts columns. The same routine finds the least amplitude that opens all gaps. Of many
//! bodies the columns are sparse, and an interior point method comes first (`cone.rs`): what it finds is checked, and is
//! an answer by itself.
//!
//! Friction adds generators. Coulomb: Λ is a cone, in the plane that of Gₙ ± coefficient · Gₜ of each node. Tresca: the
//! bounded shears form a convex set of their own, written as the hull of its corners with weights that sum to one (a
//! further row). Corners and, in space, edges of the round cones are generated where the rest asks for them. A
//! positive answer is necessary for Coulomb's equilibrium, not sufficient: the elastic solution decides.
//!
//! Where friction does not suffice, the motion that is named is that of the bodies without friction, and the answer tells
//! which part of the load along it friction can hold. If no friction whatever could hold the bodies (they tip or are
//! lifted), it is the motion that remains when no contact slips, and that part is zero.

use crate::dual::cone;
use crate::dual::split::MANY;
use crate::dual::{
    AdmissibleSet, Block, DualProblem, Equilibrium, ModeSplit, Modes, uncontrolled_modes,
};
use crate::linalg::SparseVector;
use crate::linalg::dense::{dot, norm};

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
        /// Largest part s in [0, 1) of the load along that motion which friction can hold: e − (1 − s)(z·e)z is
        /// balanced by an admissible force. 0 without friction.
        factor: f64,
    },
}

/// Rounds in which generators are added for round cones and for bounded shears.
const ROUNDS: usize = 300;

/// Most edges of round cones that are added in a round.
const EDGES: usize = 20;

/// Bisections of a load factor: below the rounding of a load.
const BISECTIONS: usize = 48;

impl DualProblem {
    /// Whether {λ ∈ Λ, Gλ = e} is empty, and why.
    pub fn feasibility(&self) -> Feasibility {
        Feasibility::of(&self.admissible, &self.equilibrium, self.scales.force)
    }
}

impl Feasibility {
    /// Whether {λ ∈ Λ, Gλ = e} is empty, and why; `force` is the scale of the loads, where it is larger than e.
    pub fn of(admissible: &AdmissibleSet, equilibrium: &Equilibrium, force: f64) -> Self {
        let load = &equilibrium.load;
        let no_work = NO_WORK * scale_of(load, force);
        let carrier = Carrier::new(admissible, &equilibrium.modes);
        let (driven, rest) = carrier.rest(load);
        if norm(&driven) <= no_work && norm(&rest) <= no_work {
            let target = carrier.reduce(load);
            let carried: Vec<f64> = target.iter().zip(&rest).map(|(t, rest)| t - rest).collect();
            return Feasibility::Feasible {
                load: carrier.expand(&carried, load.len()),
            };
        }
        if admissible.has_friction() {
            return Self::beyond_friction(admissible, equilibrium, no_work);
        }
        let direction = if norm(&driven) > no_work {
            unit(driven)
        } else {
            unit(carrier.expand(&rest, load.len()))
        };
        Feasibility::Infeasible {
            direction,
            factor: 0.0,
        }
    }

    /// The motion and the part of the load along it that friction holds, where it does not hold all.
    fn beyond_friction(
        admissible: &AdmissibleSet,
        equilibrium: &Equilibrium,
        no_work: f64,
    ) -> Self {
        let (modes, load) = (&equilibrium.modes, &equilibrium.load);
        let motion = |set: &AdmissibleSet| -> Vec<f64> {
            let carrier = Carrier::new(set, modes);
            let (driven, rest) = carrier.rest(load);
            let rest = carrier.expand(&rest, load.len());
            driven.iter().zip(&rest).map(|(d, rest)| d + rest).collect()
        };
        let held = motion(&admissible.sticking());
        if norm(&held) > no_work {
            return Feasibility::Infeasible {
                direction: unit(held),
                factor: 0.0,
            };
        }
        let smooth = admissible.with_all_bounds(0.0);
        let direction = unit(motion(&smooth));
        let work = dot(&direction, load);
        let carrier = Carrier::new(admissible, modes);
        let factor = largest_part(|part| {
            let along = |(e, z): (&f64, &f64)| e - (1.0 - part) * work * z;
            let reduced: Vec<f64> = load.iter().zip(&direction).map(along).collect();
            carrier.carries(&reduced, no_work)
        });
        Feasibility::Infeasible { direction, factor }
    }

    /// Largest s in [0, 1] for which some admissible force balances e₀ + s(e − e₀), e₀ = `before` (r,) the load of the
    /// step before and e that of `equilibrium`: where within the step equilibrium is lost. 1: nowhere.
    ///
    /// The loads that can be balanced are convex, so a load e₀ that is one of them makes the answer unique; 0 if it is not.
    pub fn fraction(admissible: &AdmissibleSet, equilibrium: &Equilibrium, before: &[f64]) -> f64 {
        let load = &equilibrium.load;
        let no_work = NO_WORK * scale_of(before, scale_of(load, 0.0));
        let carrier = Carrier::new(admissible, &equilibrium.modes);
        largest_part(|part| {
            let between = |(e, e0): (&f64, &f64)| e0 + part * (e - e0);
            let mixed: Vec<f64> = load.iter().zip(before).map(between).collect();
            carrier.carries(&mixed, no_work)
        })
    }
}

/// Largest s in [0, 1] that `holds`, if those that do form an interval from 0.
fn largest_part(holds: impl Fn(f64) -> bool) -> f64 {
    if holds(1.0) {
        return 1.0;
    }
    let (mut low, mut high) = (0.0, 1.0);
    for _ in 0..BISECTIONS {
        let middle = 0.5 * (low + high);
        if holds(middle) {
            low = middle;
        } else {
            high = middle;
        }
    }
    low
}

fn scale_of(load: &[f64], force: f64) -> f64 {
    load.iter().fold(force, |s, e| s.max(e.abs()))
}

/// {Gλ: λ ∈ Λ} by generators, in the coordinates of the modes that the contact controls.
struct Carrier {
    split: ModeSplit,
    /// Generators of a cone.
    columns: Vec<SparseVector>,
    /// Round cones: Gₙ and coefficient · Gₜ of a node.
    cones: Vec<(Vec<f64>, Vec<Vec<f64>>)>,
    /// Bounded shears: bound · Gₜ of a node.
    shears: Vec<Vec<Vec<f64>>>,
}

impl Carrier {
    fn new(admissible: &AdmissibleSet, modes: &Modes) -> Self {
        let split = if admissible.has_friction() {
            // What friction cannot bear controls nothing.
            let mut borne = modes.columns().to_vec();
            for (block, range) in admissible.iter() {
                if block.bound(1.0) == Some(0.0) {
                    for column in &mut borne[range.start + 1..range.end] {
                        *column = SparseVector::new(modes.nrows(), []);
                    }
                }
            }
            uncontrolled_modes(&Modes::new(modes.nrows(), borne))
        } else {
            uncontrolled_modes(modes)
        };
        let mut carrier = Self {
            split,
            columns: Vec::new(),
            cones: Vec::new(),
            shears: Vec::new(),
        };
        for (block, range) in admissible.iter() {
            let columns: Vec<Vec<f64>> = range
                .map(|i| carrier.reduce(&modes.column(i).to_dense()))
                .collect();
            carrier.add(block, columns);
        }
        carrier
    }

    /// Generators of one block from the columns of G.
    fn add(&mut self, block: &Block, mut columns: Vec<Vec<f64>>) {
        let scaled = |factor: f64, columns: &[Vec<f64>]| -> Vec<Vec<f64>> {
            let scale = |column: &Vec<f64>| column.iter().map(|x| factor * x).collect();
            columns.iter().map(scale).collect()
        };
        let mut generates = |column: &[f64]| self.columns.push(SparseVector::from_dense(column));
        match *block {
            Block::Free { .. } => {
                for column in columns {
                    generates(&column.iter().map(|x| -x).collect::<Vec<f64>>());
                    generates(&column);
                }
            }
            Block::Unilateral => generates(&columns[0]),
            Block::Tresca { bound, .. } => {
                generates(&columns[0]);
                if bound > 0.0 {
                    self.shears.push(scaled(bound, &columns[1..]));
                }
            }
            Block::Coulomb { coefficient, .. } => {
                let shears = scaled(coefficient, &columns[1..]);
                let normal = columns.swap_remove(0);
                if coefficient <= 0.0 {
                    generates(&normal);
                    return;
                }
                for shear in &shears {
                    for sign in [-1.0, 1.0] {
                        let edge = normal.iter().zip(shear).map(|(n, t)| n + sign * t);
                        generates(&edge.collect::<Vec<f64>>());
                    }
                }
                if shears.len() > 1 {
                    self.cones.push((normal, shears));
                }
            }
        }
    }

    /// Coordinates of v (r,) in the controlled modes, (k,).
    fn reduce(&self, v: &[f64]) -> Vec<f64> {
        let modes = self.split.controlled.iter();
        modes.map(|mode| mode.dot(v)).collect()
    }

    /// The vector (r,) with the coordinates v (k,) in the controlled modes.
    fn expand(&self, v: &[f64], r: usize) -> Vec<f64> {
        let mut expanded = vec![0.0; r];
        for (mode, part) in self.split.controlled.iter().zip(v) {
            mode.add_to(*part, &mut expanded);
        }
        expanded
    }

    /// Some admissible force balances `load` up to `no_work`.
    fn carries(&self, load: &[f64], no_work: f64) -> bool {
        let (driven, rest) = self.rest(load);
        norm(&driven) <= no_work && norm(&rest) <= no_work
    }

    /// What no admissible force balances of `load` (r,): along the modes that the contact does not control (r,), and in
    /// the coordinates of those that it does (k,), where it separates the load from what can be carried.
    fn rest(&self, load: &[f64]) -> (Vec<f64>, Vec<f64>) {
        let mut driven = vec![0.0; load.len()];
        for z in &self.split.uncontrolled {
            z.add_to(z.dot(load), &mut driven);
        }
        let target = self.reduce(load);
        let rest = if self.cones.is_empty() && self.shears.is_empty() {
            self.rest_of_cone(&target)
        } else {
            self.rest_with_generation(target)
        };
        (driven, rest)
    }

    /// The rest where the generators are all there are.
    fn rest_of_cone(&self, target: &[f64]) -> Vec<f64> {
        if target.len() >= MANY
            && let Some(rest) = cone::rest(&self.columns, target)
        {
            return rest;
        }
        least_squares_nonnegative(&self.dense_columns(), target).1
    }

    fn dense_columns(&self) -> Vec<Vec<f64>> {
        self.columns.iter().map(SparseVector::to_dense).collect()
    }

    /// The rest where generators are added as it asks for them. The further row makes the weights of the corners of the
    /// bounded shears sum to one.
    fn rest_with_generation(&self, mut target: Vec<f64>) -> Vec<f64> {
        let k = target.len();
        let weight = Some(norm(&target))
            .filter(|size| *size > 0.0)
            .unwrap_or(1.0);
        target.push(weight);
        let mut columns = self.dense_columns();
        columns.iter_mut().for_each(|column| column.push(0.0));
        let mut none = vec![0.0; k];
        none.push(weight);
        columns.push(none);
        let mut rest = Vec::new();
        for _ in 0..ROUNDS {
            rest = least_squares_nonnegative(&columns, &target).1;
            let mut wanted = self.edges(&rest[..k]);
            wanted.iter_mut().for_each(|edge| edge.push(0.0));
            let mut corner = self.corner(&rest[..k]);
            corner.push(weight);
            wanted.push(corner);
            let gains = |column: &Vec<f64>| {
                dot(column, &rest) > 1e-13 * norm(&target) * norm(column)
                    && !columns.contains(column)
            };
            let added: Vec<Vec<f64>> = wanted.into_iter().filter(gains).collect();
            if added.is_empty() {
                break;
            }
            columns.extend(added);
        }
        rest.pop();
        rest
    }

    /// Edges of the round cones that point most along `rest`.
    fn edges(&self, rest: &[f64]) -> Vec<Vec<f64>> {
        let edge = |(normal, shears): &(Vec<f64>, Vec<Vec<f64>>)| {
            let turned = towards(shears, rest);
            let edge: Vec<f64> = normal.iter().zip(&turned).map(|(n, t)| n + t).collect();
            (dot(&edge, rest), edge)
        };
        let mut edges: Vec<(f64, Vec<f64>)> = self.cones.iter().map(edge).collect();
        edges.sort_by(|a, b| b.0.total_cmp(&a.0));
        edges.truncate(EDGES);
        edges.into_iter().map(|(_, edge)| edge).collect()
    }

    /// The corner of the bounded shears that lies farthest along `rest`.
    fn corner(&self, rest: &[f64]) -> Vec<f64> {
        let mut corner = vec![0.0; rest.len()];
        for shears in &self.shears {
            for (corner, t) in corner.iter_mut().zip(towards(shears, rest)) {
                *corner += t;
            }
        }
        corner
    }
}

/// Σ sⱼ shearsⱼ with the unit vector s for which it lies farthest along `rest`.
fn towards(shears: &[Vec<f64>], rest: &[f64]) -> Vec<f64> {
    let along: Vec<f64> = shears.iter().map(|shear| dot(shear, rest)).collect();
    let length = norm(&along);
    let mut sum = vec![0.0; rest.len()];
    if length > 0.0 {
        for (shear, along) in shears.iter().zip(&along) {
            for (sum, x) in sum.iter_mut().zip(shear) {
                *sum += along / length * x;
            }
        }
    }
    sum
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
            softness: vec![1.0; 2],
            neighbours: Vec::new(),
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
        let Feasibility::Infeasible { direction, .. } = problem.feasibility() else {
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
        let first = &problem.equilibrium.modes.rows()[0];
        let none = SparseVector::new(2, []);
        problem.equilibrium.modes = Modes::of_rows(&[first.clone(), none], 2);
        let Feasibility::Infeasible { direction, .. } = problem.feasibility() else {
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

    /// A block on a plane, two nodes at x = ∓1: (normal, tangential..) each; modes: sinking, sliding.., tipping.
    fn block_on_plane(block: Block, load: &[f64]) -> Feasibility {
        let size = block.size();
        let modes = Mat::from_fn(1 + size, 2 * size, |mode, i| {
            let component = i % size;
            if mode == size {
                // The normal force turns the block about its middle, 1 away.
                if component == 0 {
                    (i / size) as f64 * 2.0 - 1.0
                } else {
                    0.0
                }
            } else {
                f64::from(mode == component)
            }
        });
        let set = AdmissibleSet::new(vec![block; 2]);
        Feasibility::of(&set, &Equilibrium::new(modes, load.to_vec()), 0.0)
    }

    fn feasible(block: Block, load: &[f64]) -> bool {
        matches!(block_on_plane(block, load), Feasibility::Feasible { .. })
    }

    #[test]
    fn friction_holds_a_block_up_to_its_coefficient_and_no_further() {
        let coulomb = |tangents| Block::Coulomb {
            tangents,
            coefficient: 0.3,
        };
        assert!(feasible(coulomb(1), &[1.0, 0.3 - 1e-8, 0.0]));
        assert!(!feasible(coulomb(1), &[1.0, 0.3 + 1e-8, 0.0]));
        let oblique = |size: f64| [1.0, 0.6 * size, -0.8 * size, 0.2];
        assert!(feasible(coulomb(2), &oblique(0.3 - 1e-6)));
        assert!(!feasible(coulomb(2), &oblique(0.3 + 1e-6)));
        let tresca = |tangents| Block::Tresca {
            tangents,
            bound: 0.15,
        };
        assert!(feasible(tresca(1), &[1.0, 0.3 - 1e-8, 0.2]));
        assert!(!feasible(tresca(1), &[1.0, 0.3 + 1e-8, 0.2]));
        assert!(feasible(tresca(2), &oblique(0.3 - 1e-6)));
        assert!(!feasible(tresca(2), &oblique(0.3 + 1e-6)));
    }

    #[test]
    fn sliding_block_is_told_its_motion_and_the_part_that_friction_holds() {
        let block = Block::Coulomb {
            tangents: 1,
            coefficient: 0.3,
        };
        let Feasibility::Infeasible { direction, factor } =
            block_on_plane(block, &[1.0, -0.4, 0.1])
        else {
            panic!("0.4 is more than 0.3");
        };
        assert!((direction[1] + 1.0).abs() < 1e-12, "{direction:?}");
        assert!((factor - 0.75).abs() < 1e-8, "{factor}");
    }

    #[test]
    fn tipping_block_is_not_held_by_any_friction() {
        for coefficient in [0.3, 1e3] {
            let block = Block::Coulomb {
                tangents: 1,
                coefficient,
            };
            let Feasibility::Infeasible { direction, factor } =
                block_on_plane(block, &[1.0, 0.1, 1.2])
            else {
                panic!("the load lies beside the supports");
            };
            assert_eq!(factor, 0.0);
            // It opens node 0 and lets node 1 rest: sinking against turning.
            assert!(
                direction[1].abs() < 1e-12 && direction[2] > 0.5,
                "{direction:?}"
            );
            assert!((direction[0] + direction[2]).abs() < 1e-12, "{direction:?}");
        }
    }

    #[test]
    fn wedge_is_held_by_friction_above_its_slope() {
        // One node whose normal pushes back at 45°: without friction it slips out.
        let root = 0.5f64.sqrt();
        let modes = Mat::from_fn(
            2,
            2,
            |mode, i| if mode == 1 && i == 0 { -root } else { root },
        );
        let load = Equilibrium::new(modes, vec![1.0, 0.0]);
        let held = |coefficient| {
            let set = AdmissibleSet::new(vec![Block::Coulomb {
                tangents: 1,
                coefficient,
            }]);
            Feasibility::of(&set, &load, 0.0)
        };
        assert!(matches!(held(1.01), Feasibility::Feasible { .. }));
        let Feasibility::Infeasible { factor, .. } = held(0.5) else {
            panic!("the slope is 1");
        };
        // Along the slope the load is as large as across: half of it is held.
        assert!((factor - 0.5).abs() < 1e-8, "{factor}");
    }

    #[test]
    fn smooth_contacts_hold_no_sliding_even_with_tangents() {
        for block in [
            Block::Coulomb {
                tangents: 1,
                coefficient: 0.0,
            },
            Block::Tresca {
                tangents: 1,
                bound: 0.0,
            },
        ] {
            assert!(feasible(block, &[1.0, 0.0, 0.3]));
            let Feasibility::Infeasible { direction, factor } =
                block_on_plane(block, &[1.0, 0.1, 0.3])
            else {
                panic!("nothing holds it");
            };
            assert!((direction[1] - 1.0).abs() < 1e-12 && factor == 0.0);
        }
    }

    #[test]
    fn fraction_of_a_step_ends_where_equilibrium_does() {
        let modes = Mat::from_fn(2, 2, |mode, i| f64::from(mode == i));
        let set = AdmissibleSet::new(vec![Block::Coulomb {
            tangents: 1,
            coefficient: 0.5,
        }]);
        let fraction = |load: [f64; 2], before: [f64; 2]| {
            Feasibility::fraction(
                &set,
                &Equilibrium::new(modes.clone(), load.to_vec()),
                &before,
            )
        };
        assert_eq!(fraction([1.0, 0.4], [1.0, 0.0]), 1.0);
        assert!((fraction([1.0, 0.8], [1.0, 0.2]) - 0.5).abs() < 1e-8);
        // Unloading: T = 0.3 at N = 1 − 0.8 s is lost at N = 0.6.
        assert!((fraction([0.2, 0.3], [1.0, 0.3]) - 0.5).abs() < 1e-8);
        assert!(fraction([1.0, 0.9], [1.0, 0.8]) < 1e-8);
    }
}
