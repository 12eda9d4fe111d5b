//! The linear problem of a guess of states where F is applied: conjugate gradients in the null space of the balance for symmetric
//! systems, restarted minimal residuals for unsymmetric ones, both preconditioned and warm started.
//!
//! Where bodies are in pieces, F is the compliance of pieces under forces of the glue t that leave no jumps. These are unknowns
//! beside the forces x, so that one iteration is one solution with every piece:
//!
//! ```text
//!   residual of x:  pullₐ − wₐ·gap − softnessₐ xₐ,      residual of t:  −Ju,      balance:  Ĝλ = ê,  Rᵀ(Bᵀλ + t) = 0
//! ```
//!
//! Balance and rigid motions are then those of pieces and bodies at once (`network.rs`).
//!
//! t and u are scaled by √(n/g) and its inverse, n forces and g forces of the glue, so that jumps count as much as gaps in the norm of
//! both.

use crate::dual::Glue;
use crate::linalg::{LinearOperator, SparseVector};
use crate::solve::null::Null;
use crate::solve::setup::Forces;
use crate::solve::states::{Unknown, along};
use crate::solve::system::network::Network;
use crate::solve::system::{Side, System};
use crate::solve::{dot, norm};

/// Iterations compare their residual with the right side, and at least with this part of the residual of the start: a right side
/// that vanishes on balanced forces could not be met.
const FROM_START: f64 = 1e-3;

/// Relative error allowed to forces, as a multiple of the one allowed to gaps. Where long waves are soft, forces that alternate from
/// node to node are larger than their gaps show; the preconditioner may tell a part of them (see [`Goal::is_met`]).
const ON_FORCES: f64 = 2.0;

/// Gaps below this part of their tolerance are rounding, whatever the forces.
const TOLERANCE_ROUNDING: f64 = 1e-3;

/// So are those below these parts of the displacements that they are differences of: elastic ones, and rigid motions.
const ELASTIC_ROUNDING: f64 = 256.0 * f64::EPSILON;
const RIGID_ROUNDING: f64 = 8.0 * f64::EPSILON;

/// When iterations within a step end.
struct Goal {
    /// Size of the gaps.
    gap: f64,
    /// Error of the forces, relative.
    force: f64,
    /// Size of gaps that are rounding.
    rounding: f64,
}

impl Goal {
    /// From the size of the right side, the residual of the start, and the rounding of it.
    fn new(accuracy: f64, reference: f64, residual: &[f64], rounding: f64) -> Self {
        let gap = accuracy * reference.max(FROM_START * norm(residual));
        Self {
            gap: gap.max(rounding),
            force: ON_FORCES * accuracy,
            rounding: rounding.max(TOLERANCE_ROUNDING * gap),
        }
    }

    /// Whether gaps of this size are small enough. `change` are the forces by which the preconditioner would remove them: at least as
    /// large as the exact ones where each node has one condition. Elsewhere it knows only a part of forces that alternate from node to
    /// node: those of the nonmortar side by the square of its share, and those that nodes between corners do not follow.
    fn is_met(&self, gap: f64, change: &[f64], forces: &[f64]) -> bool {
        let settled = norm(change) <= self.force * norm(forces);
        gap <= self.gap && (settled || gap <= self.rounding)
    }
}

/// Most conjugate gradients of one linear problem.
const CONJUGATE: usize = 500;

/// Gaps are reduced by this factor where the forces are not accurate enough.
const FURTHER: f64 = 0.1;

/// Vectors that minimal residuals keep, and how often they begin again.
const KRYLOV: usize = 60;
const RESTARTS: usize = 10;

/// The vectors of the iterations, (n + g,): the forces x, behind them the scaled forces t of the glue; and their operators.
struct Space<'s, 'a> {
    system: &'s System<'a>,
    preconditioner: &'s dyn LinearOperator,
    glue: Option<&'s dyn Glue>,
    /// √(n/g).
    scale: f64,
    /// Workspace: λ and Fλ, (m,); t and jumps, (g,).
    lambda: Vec<f64>,
    image: Vec<f64>,
    t: Vec<f64>,
    jumps: Vec<f64>,
}

impl<'s, 'a> Space<'s, 'a> {
    fn new(
        system: &'s System<'a>,
        preconditioner: &'s dyn LinearOperator,
        glue: Option<&'s dyn Glue>,
    ) -> Self {
        let (n, m) = (system.unknowns.len(), system.setup.len());
        let glue = glue.filter(|_| n > 0);
        let pieces = glue.map_or(0, Glue::len);
        Self {
            system,
            preconditioner,
            glue,
            scale: (n as f64 / pieces.max(1) as f64).sqrt(),
            lambda: vec![0.0; m],
            image: vec![0.0; m],
            t: vec![0.0; pieces],
            jumps: vec![0.0; pieces],
        }
    }

    /// Number n of forces.
    fn forces(&self) -> usize {
        self.system.unknowns.len()
    }

    /// Length n + g of all vectors.
    fn len(&self) -> usize {
        self.forces() + self.t.len()
    }

    /// The values nearest to a guess: of x by its forces, of t by the last ones.
    fn start(&self, guess: &Forces) -> Vec<f64> {
        let apart = guess.lambda.iter().zip(&self.system.offset);
        let apart: Vec<f64> = apart.map(|(force, known)| force - known).collect();
        let nearest = self.system.unknowns.iter().map(|u| u.nearest(&apart));
        let glue = self.system.setup.glue(self.t.len());
        nearest.chain(glue.iter().map(|t| t / self.scale)).collect()
    }

    /// λ without the offset, and t.
    fn spread(&mut self, x: &[f64], side: fn(&Unknown) -> &[(usize, f64)]) {
        self.lambda.fill(0.0);
        for (unknown, x) in self.system.unknowns.iter().zip(x) {
            for &(i, weight) in side(unknown) {
                self.lambda[i] += x * weight;
            }
        }
        let scaled = self.t.iter_mut().zip(&x[self.system.unknowns.len()..]);
        scaled.for_each(|(t, x)| *t = self.scale * x);
    }

    /// Fλ and the jumps of λ and t, pieces `placed` or somewhere.
    fn respond(&mut self, placed: bool) {
        match self.glue {
            None => self.system.setup.multiply(&self.lambda, &mut self.image),
            Some(glue) => {
                let forces = (&self.lambda[..], &self.t[..]);
                glue.respond(forces, placed, &mut self.image, &mut self.jumps);
                self.system.setup.count(1);
            }
        }
    }

    /// out = WᵀFC x + softness x, and the jumps, but for rigid motions of pieces.
    fn apply(&mut self, x: &[f64], out: &mut [f64]) {
        self.spread(x, |u| &u.force);
        self.respond(false);
        for ((out, unknown), x) in out.iter_mut().zip(&self.system.unknowns).zip(x) {
            *out = along(&unknown.row, &self.image) + unknown.softness * x;
        }
        let scaled = out[self.forces()..].iter_mut().zip(&self.jumps);
        scaled.for_each(|(out, jump)| *out = self.scale * jump);
    }

    /// out = an approximation of the inverse of [`Self::apply`] on r.
    fn precondition(&mut self, r: &[f64], out: &mut [f64]) {
        self.spread(r, |u| &u.row);
        let n = self.forces();
        match self.glue {
            None => self.preconditioner.apply(&self.lambda, &mut self.image),
            Some(glue) => {
                let scaled = self.jumps.iter_mut().zip(&r[n..]);
                scaled.for_each(|(jump, r)| *jump = r / self.scale);
                glue.precondition(&self.lambda, &self.jumps, &mut self.image, &mut self.t);
                let scaled = out[n..].iter_mut().zip(&self.t);
                scaled.for_each(|(out, t)| *out = t / self.scale);
            }
        }
        for (out, unknown) in out.iter_mut().zip(&self.system.unknowns) {
            *out = along(&unknown.row, &self.image);
        }
    }

    /// The forces of x, without amplitudes.
    fn point(&mut self, x: &[f64]) -> Forces {
        let none = vec![0.0; self.system.setup.modes()];
        if self.glue.is_none() {
            return self.system.point(x, none);
        }
        self.spread(x, |u| &u.force);
        let both = self.lambda.iter_mut().zip(&self.system.offset);
        both.for_each(|(force, offset)| *force += offset);
        self.respond(true);
        Forces {
            lambda: self.lambda.clone(),
            alpha: none,
            product: self.image.clone(),
        }
    }

    /// What the conditions and the jumps of a point lack.
    fn residual(&self, point: &Forces, x: &[f64]) -> Vec<f64> {
        let (mut residual, _) = self.system.residual(point, x);
        residual.extend(self.jumps.iter().map(|jump| -self.scale * jump));
        residual
    }

    /// The rounding of the residual of a point, before its rigid motions are found.
    fn rounding(&self, point: &Forces, residual: &[f64]) -> f64 {
        let own = self.system.unknowns.iter();
        let own = own.map(|u| along(&u.row, &point.product));
        let elastic = norm(&own.collect::<Vec<f64>>());
        ELASTIC_ROUNDING * elastic + RIGID_ROUNDING * norm(residual)
    }

    /// Size of the right side on the balanced forces.
    fn reference(&self) -> f64 {
        let (rows, loose) = (&self.system.rows, &self.system.loose);
        let shift = &self.system.setup.shift;
        let unknowns = self.system.unknowns.iter();
        let own = unknowns.map(|u| u.pull + along(&u.row, shift));
        let mut reference: Vec<f64> = own.collect();
        Null::new(rows, loose).project(rows, &mut reference);
        norm(&reference)
    }

    /// The balance of the forces, or the rigid motions along the conditions. `None` where a motion of pieces meets no resistance.
    fn rigid(&self, side: Side) -> Option<Rigid<'s>> {
        let system = self.system;
        let (floating, loose) = match side {
            Side::Forces => (&system.forces, Vec::new()),
            Side::Rows => (&system.rows, system.loose.clone()),
        };
        let n = self.forces();
        let Some(glue) = self.glue else {
            let null = Null::new(floating, &loose);
            return Some(Rigid::Floating { null, floating, n });
        };
        let loose = match side {
            Side::Forces => system.loose_forces(),
            Side::Rows => loose,
        };
        let unknowns = (&system.unknowns[..], side);
        let softness = &system.setup.problem.softness;
        let network = Network::new(glue, unknowns, (floating, &loose), softness)?;
        Some(Rigid::Pieces {
            network,
            n,
            scale: self.scale,
        })
    }
}

/// The balance of forces, and the rigid motions that belong to it.
enum Rigid<'s> {
    Floating {
        null: Null,
        floating: &'s [SparseVector],
        n: usize,
    },
    Pieces {
        network: Network<'s>,
        n: usize,
        scale: f64,
    },
}

impl Rigid<'_> {
    /// The balance beside known forces (m,), of which bodies lack `floating` (k,).
    fn target(&self, known: &[f64], floating: Vec<f64>) -> Vec<f64> {
        match self {
            Self::Floating { .. } => floating,
            Self::Pieces { network, .. } => network.target(known, &floating),
        }
    }

    /// x ← the nearest forces in balance with a target.
    fn restore(&mut self, target: &[f64], x: &mut [f64]) {
        match self {
            Self::Floating { null, floating, n } => null.restore(floating, target, &mut x[..*n]),
            Self::Pieces { network, n, scale } => {
                let (x, scaled) = x.split_at_mut(*n);
                let mut t: Vec<f64> = scaled.iter().map(|t| *scale * t).collect();
                network.restore(target, x, &mut t);
                let both = scaled.iter_mut().zip(&t);
                both.for_each(|(scaled, t)| *scaled = t / *scale);
            }
        }
    }

    /// x ← the nearest forces in balance.
    fn clear(&mut self, x: &mut [f64]) {
        match self {
            Self::Floating { null, floating, n } => null.project(floating, &mut x[..*n]),
            Self::Pieces { .. } => self.restore(&[], x),
        }
    }

    /// r ← gaps and jumps after the rigid motions that make them least.
    fn place(&mut self, r: &mut [f64]) {
        match self {
            Self::Floating { null, floating, n } => null.project(floating, &mut r[..*n]),
            Self::Pieces { .. } => {
                self.amplitudes(r);
            }
        }
    }

    /// α̂ that makes the gaps least; those of pieces are then so.
    fn amplitudes(&mut self, r: &mut [f64]) -> Vec<f64> {
        match self {
            Self::Floating { null, floating, n } => null.amplitudes(floating, &r[..*n]),
            Self::Pieces { network, n, scale } => {
                let (r, scaled) = r.split_at_mut(*n);
                let mut jumps: Vec<f64> = scaled.iter().map(|jump| jump / *scale).collect();
                let amplitudes = network.place(r, &mut jumps);
                let both = scaled.iter_mut().zip(&jumps);
                both.for_each(|(scaled, jump)| *scaled = *scale * jump);
                amplitudes
            }
        }
    }
}

impl System<'_> {
    pub(super) fn solve_applied(
        &self,
        (preconditioner, glue): (&dyn LinearOperator, Option<&dyn Glue>),
        guess: &Forces,
        accuracy: f64,
    ) -> Option<Forces> {
        let mut space = Space::new(self, preconditioner, glue);
        let start = space.start(guess);
        let found = match self.unknowns.iter().all(Unknown::is_symmetric) {
            true => self.conjugate_gradients(&mut space, start, accuracy),
            false => self.minimal_residuals(&mut space, start, accuracy),
        };
        if let (Some(glue), Some(found)) = (space.glue, &found) {
            glue.keep(&found.lambda, &space.t);
            self.setup.keep_glue(space.t);
        }
        found
    }

    /// ê less the balance of the known forces.
    fn target(&self) -> Vec<f64> {
        let mut target = vec![0.0; self.setup.modes()];
        self.setup.balance.imbalance(&self.offset, &mut target);
        target.iter_mut().for_each(|rest| *rest = -*rest);
        target
    }

    /// Conjugate gradients on the forces that keep the balance.
    fn conjugate_gradients(
        &self,
        space: &mut Space<'_, '_>,
        mut x: Vec<f64>,
        accuracy: f64,
    ) -> Option<Forces> {
        let n = space.forces();
        let mut rigid = space.rigid(Side::Rows)?;
        let target = rigid.target(&self.offset, self.target());
        rigid.restore(&target, &mut x);
        let point = space.point(&x);
        let mut residual = space.residual(&point, &x);
        let reference = space.reference();
        let rounding = space.rounding(&point, &residual);
        rigid.place(&mut residual);
        let goal = Goal::new(accuracy, reference, &residual, rounding);
        let (mut z, mut out) = (vec![0.0; space.len()], vec![0.0; space.len()]);
        space.precondition(&residual, &mut z);
        rigid.clear(&mut z);
        let mut direction = z.clone();
        let mut slope = dot(&residual, &z);
        for _ in 0..CONJUGATE.min(2 * space.len() + 50) {
            if slope <= 0.0 || goal.is_met(norm(&residual), &z[..n], &x[..n]) {
                break;
            }
            space.apply(&direction, &mut out);
            rigid.place(&mut out);
            let curvature = dot(&direction, &out);
            if curvature <= 0.0 {
                break;
            }
            let step = slope / curvature;
            for i in 0..x.len() {
                x[i] += step * direction[i];
                residual[i] -= step * out[i];
            }
            space.precondition(&residual, &mut z);
            rigid.clear(&mut z);
            let next = dot(&residual, &z);
            for i in 0..x.len() {
                direction[i] = z[i] + next / slope * direction[i];
            }
            slope = next;
        }
        rigid.restore(&target, &mut x);
        let mut point = space.point(&x);
        point.alpha = rigid.amplitudes(&mut space.residual(&point, &x));
        Some(point)
    }

    /// Minimal residuals on the forces that keep the balance, tested by motions that are not rigid.
    fn minimal_residuals(
        &self,
        space: &mut Space<'_, '_>,
        mut x: Vec<f64>,
        accuracy: f64,
    ) -> Option<Forces> {
        let mut forces = space.rigid(Side::Forces)?;
        let mut rigid = space.rigid(Side::Rows)?;
        let target = forces.target(&self.offset, self.target());
        forces.restore(&target, &mut x);
        let point = space.point(&x);
        let mut residual = space.residual(&point, &x);
        let reference = space.reference();
        let rounding = space.rounding(&point, &residual);
        rigid.place(&mut residual);
        let goal = Goal::new(accuracy, reference, &residual, rounding);
        self.krylov(space, (residual, &mut x), &goal, [&mut forces, &mut rigid])?;
        forces.restore(&target, &mut x);
        let mut point = space.point(&x);
        point.alpha = rigid.amplitudes(&mut space.residual(&point, &x));
        Some(point)
    }

    /// Adds a change without resultant to x such that the residual b − Ax becomes a rigid motion, to within a goal. Restarted minimal
    /// residuals, preconditioned from the right; the null spaces are those of the forces and of the rigid motions.
    fn krylov(
        &self,
        space: &mut Space<'_, '_>,
        (mut residual, x): (Vec<f64>, &mut [f64]),
        goal: &Goal,
        [forces, rigid]: [&mut Rigid<'_>; 2],
    ) -> Option<()> {
        let (n, all) = (space.forces(), space.len());
        let mut change = vec![0.0; all];
        let mut enough = goal.gap;
        for _ in 0..RESTARTS {
            let size = norm(&residual);
            if size <= enough {
                space.precondition(&residual, &mut change);
                forces.clear(&mut change);
                if size == 0.0 || goal.is_met(size, &change[..n], &x[..n]) {
                    return Some(());
                }
                enough = FURTHER * size;
            }
            let mut basis = vec![residual.iter().map(|r| r / size).collect::<Vec<f64>>()];
            let mut directions: Vec<Vec<f64>> = Vec::new();
            let mut triangle: Vec<Vec<f64>> = Vec::new();
            let mut turns: Vec<(f64, f64)> = Vec::new();
            let mut right = vec![size];
            for j in 0..KRYLOV.min(all) {
                let (mut z, mut w) = (vec![0.0; all], vec![0.0; all]);
                space.precondition(&basis[j], &mut z);
                forces.clear(&mut z);
                space.apply(&z, &mut w);
                rigid.place(&mut w);
                directions.push(z);
                let mut column: Vec<f64> = Vec::with_capacity(j + 2);
                for q in &basis {
                    let part = dot(q, &w);
                    w.iter_mut().zip(q).for_each(|(w, q)| *w -= part * q);
                    column.push(part);
                }
                let rest = norm(&w);
                for (i, &(cos, sin)) in turns.iter().enumerate() {
                    let (a, b) = (column[i], column[i + 1]);
                    (column[i], column[i + 1]) = (cos * a + sin * b, cos * b - sin * a);
                }
                let length = column[j].hypot(rest);
                let (cos, sin) = match length > 0.0 {
                    true => (column[j] / length, rest / length),
                    false => (1.0, 0.0),
                };
                column[j] = length;
                turns.push((cos, sin));
                triangle.push(column);
                let last = right[j];
                right[j] = cos * last;
                right.push(-sin * last);
                if right[j + 1].abs() <= enough || rest == 0.0 {
                    break;
                }
                basis.push(w.iter().map(|w| w / rest).collect());
            }
            let count = triangle.len();
            let mut y = right[..count].to_vec();
            for i in (0..count).rev() {
                y[i] /= triangle[i][i];
                for row in 0..i {
                    y[row] -= triangle[i][row] * y[i];
                }
            }
            if !y.iter().all(|y| y.is_finite()) {
                return None;
            }
            change.fill(0.0);
            for (y, direction) in y.iter().zip(&directions) {
                let parts = change.iter_mut().zip(direction);
                parts.for_each(|(change, d)| *change += y * d);
            }
            x.iter_mut().zip(&change).for_each(|(x, d)| *x += d);
            let mut image_of_change = vec![0.0; all];
            space.apply(&change, &mut image_of_change);
            rigid.place(&mut image_of_change);
            let done = residual.iter_mut().zip(&image_of_change);
            done.for_each(|(r, done)| *r -= done);
        }
        Some(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn gaps_that_are_rounding_of_displacements_meet_every_goal() {
        // forces that still change by their own size
        let met = |goal: &Goal, gap: f64| goal.is_met(gap, &[1.0], &[1.0]);
        let goal = Goal::new(1e-12, 0.0, &[1e-9], 5e-14);
        assert!(met(&goal, 5e-14) && !met(&goal, 1e-13));
        let goal = Goal::new(1e-12, 2.0, &[1e-9], 5e-14);
        assert!(met(&goal, 5e-14) && !met(&goal, 1e-12));
        // forces that do not
        assert!(goal.is_met(1e-12, &[1e-12], &[1.0]) && !goal.is_met(3e-12, &[0.0], &[1.0]));
    }
}
