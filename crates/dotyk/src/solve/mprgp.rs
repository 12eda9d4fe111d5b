//! MPRGP, conjugate gradients on faces of the bounds, inside SMALBE-M, an augmented Lagrangian for the balance.
//!
//! With λ = Ĝᵀê + x, P = I − ĜᵀĜ and Q = ĜᵀĜ:
//!
//! ```text
//!   outer:  min 1/2 xᵀ(PFP + ϱQ)x − (P(d − FĜᵀê) − μ)ᵀx  over x ≥ −Ĝᵀê, until ‖gᴾ‖ ≤ min(M‖Qx‖, η‖b‖);  μ += ϱQx
//!   inner:  ‖β‖² ≤ φ̃ᵀφ:  a conjugate gradient step, or, where it would leave the bounds, the feasible part of it and
//!                        an expansion x ← max(l, x − ᾱφ)
//!           else:        a proportioning step along β
//! ```
//!
//! Friction with given bounds adds upper bounds: |λₜ| ≤ bound is −bound ≤ λₜ ≤ bound. Only in the plane: discs are not boxes.
//!
//! φ is the gradient on the free unknowns, β its part that releases active ones, φ̃ᵢ = min((xᵢ − lᵢ)/ᾱ, φᵢ). The rate
//! depends on spectral bounds only, and nothing is asked of the user: ᾱ = 1.9/ϱ, ϱ = 1.1L, M = 100L halved when the
//! Lagrangian does not grow, η = 0.1, L from Lanczos. Where the contact is a small part of the nodes, ϱQ is weak on its
//! face and the outer steps crawl: then ϱ is raised. The gradient is carried across outer steps at no product. The last
//! step balances the loaded forces exactly and judges a fresh gap. For a punch over 17 of 100 nodes these two take 55
//! iterations where fixed ϱ and a projection that loads open contacts took 2891.
//!
//! Sources: MPRGP as described in Dostál & Schöberl, Comput. Optim. Appl. 30 (2005) 23–43; defaults of PERMON.

use std::ops::Range;

use crate::dual::{Block, Component, Multipliers, NO_WORK, Projector};
use crate::linalg::SparseVector;
use crate::solve::gradient::projected_bound;
use crate::solve::iteration::{Iteration, iterate};
use crate::solve::null::Null;
use crate::solve::setup::{Forces, Judge, Position, Setup};
use crate::solve::{FixedBounds, Observer, Outcome, SAFE_STEP, SolveError, TOLERANCE, dot, norm};

/// An outer step that leaves more than this part of the imbalance is slow; [`SLOW_STEPS`] in a row raise the penalty.
const SLOW: f64 = 0.5;

/// Slow outer steps in a row that raise the penalty.
const SLOW_STEPS: usize = 3;

/// Factor by which the penalty is raised.
const GROWTH: f64 = 4.0;

/// A load below this part of the forces is compared with that part of them: what balances itself rounds like the forces.
const SMALL_LOAD: f64 = 1e-3;

/// MPRGP for the bounds, SMALBE-M for the balance.
#[derive(Debug, Clone, PartialEq)]
pub struct Mprgp {
    /// Residual at which it stops.
    pub tolerance: f64,
    /// Most inner iterations.
    pub max_iterations: usize,
}

impl Default for Mprgp {
    fn default() -> Self {
        Self {
            tolerance: TOLERANCE,
            max_iterations: 20_000,
        }
    }
}

impl FixedBounds for Mprgp {
    const NAME: &'static str = "mprgp";

    fn limits_mut(&mut self) -> (&mut f64, &mut usize) {
        (&mut self.tolerance, &mut self.max_iterations)
    }

    fn run(
        &self,
        setup: &Setup<'_>,
        guess: Option<&Multipliers>,
        observe: Observer<'_>,
    ) -> Result<Outcome, SolveError> {
        check_tangents(setup)?;
        let start = setup.start(guess)?;
        let mut state = State::new(self, setup, &start, guess);
        iterate(self, setup, &mut state, 0, observe)
    }
}

impl Iteration for State<'_> {
    /// The forces of x, with the gradient as their gap.
    fn evaluate(&mut self) {
        let balance = &self.setup.balance;
        balance.apply(&self.x, &mut self.modes_x);
        for j in 0..self.at.alpha.len() {
            self.at.alpha[j] = self.beside(j, self.multiplier[j]);
        }
        for i in 0..self.x.len() {
            let (force, own) = (self.offset[i] + self.x[i], &self.bounds[i]);
            self.at.lambda[i] = force.max(own.start).min(own.end);
            self.at.product[i] = self.gradient[i] + self.setup.problem.shift[i];
        }
        balance.add_transposed(1.0, &self.at.alpha, &mut self.at.product);
    }

    fn point(&self) -> Position<'_> {
        self.at.at(self.setup, self.kind)
    }

    /// An outer step, which is no iteration, or an inner one.
    fn advance(&mut self, _gap: &[f64]) -> usize {
        let settled = self.settled();
        match settled {
            true => self.update_balance(),
            false => self.step(),
        }
        usize::from(!settled)
    }

    /// The residual of balanced forces with a fresh product; each one that does not pass asks for a better estimate.
    fn verdict(&mut self, estimate: f64, judge: &mut Judge, last: bool) -> Option<f64> {
        if estimate > self.ask && !last {
            return None;
        }
        self.balance_exactly();
        self.setup.multiply(&self.at.lambda, &mut self.at.product);
        let residual = judge.residual(self.setup, &self.point());
        let passes = residual <= self.tolerance;
        if !passes && !last {
            self.ask *= 0.3;
            self.refresh();
        }
        Some(residual)
    }
}

/// Iterate, gradient and workspace.
struct State<'a> {
    setup: &'a Setup<'a>,
    projector: Projector<'a>,
    tolerance: f64,
    /// The estimate of the residual that asks for a verdict.
    ask: f64,
    /// Ĝᵀê.
    offset: Vec<f64>,
    /// Bounds of the forces, and those of x; infinite where there is none.
    bounds: Vec<Range<f64>>,
    floor: Vec<f64>,
    ceiling: Vec<f64>,
    /// P(d − FĜᵀê), ĜFĜᵀê and Ĝd.
    right: Vec<f64>,
    modes_offset: Vec<f64>,
    modes_shift: Vec<f64>,
    /// Size of the right-hand side.
    size: f64,
    /// ϱ, M, ᾱ.
    penalty: f64,
    precision: f64,
    step_length: f64,
    x: Vec<f64>,
    /// Gradient of the augmented Lagrangian.
    gradient: Vec<f64>,
    direction: Vec<f64>,
    /// φ and β.
    free: Vec<f64>,
    chopped: Vec<f64>,
    /// μ = Ĝᵀ`multiplier`, ĜF(Ĝᵀê + Px), Ĝx.
    multiplier: Vec<f64>,
    modes_product: Vec<f64>,
    modes_x: Vec<f64>,
    lagrangian: Option<f64>,
    /// ‖Qx‖² of the last outer step, and how many in a row were slow.
    imbalance: f64,
    slow: usize,
    /// Forces max(0, Ĝᵀê + x) and the α̂ that belongs to the gradient.
    at: Forces,
    /// v of the last product, Pv, and the product.
    operand: Vec<f64>,
    inside: Vec<f64>,
    image: Vec<f64>,
    modes_image: Vec<f64>,
    parts: Vec<f64>,
    kind: char,
}

impl<'a> State<'a> {
    fn new(
        method: &Mprgp,
        setup: &'a Setup<'a>,
        start: &[f64],
        guess: Option<&Multipliers>,
    ) -> Self {
        let (m, k) = (setup.len(), setup.modes());
        let bound = projected_bound(setup);
        let (balance, mut offset) = (&setup.balance, vec![0.0; m]);
        balance.add_transposed(1.0, balance.target(), &mut offset);
        let bounds = bounds(setup);
        let from = |bound: fn(&Range<f64>) -> f64| {
            let pairs = bounds.iter().zip(&offset);
            pairs.map(|(own, offset)| bound(own) - offset).collect()
        };
        let (floor, ceiling): (Vec<f64>, Vec<f64>) = (from(|own| own.start), from(|own| own.end));
        // Without a guess x is the projection of zero, as in the unbounded problem.
        let x = |i: usize| {
            let x = guess.map_or(0.0, |_| start[i] - offset[i]);
            x.max(floor[i]).min(ceiling[i])
        };
        let x = (0..m).map(x).collect();
        let mut state = Self {
            setup,
            projector: setup.projector(),
            tolerance: method.tolerance,
            ask: method.tolerance,
            floor,
            ceiling,
            offset,
            bounds,
            right: setup.problem.shift.clone(),
            modes_offset: vec![0.0; k],
            modes_shift: vec![0.0; k],
            size: 0.0,
            penalty: 1.1 * bound,
            precision: 100.0 * bound,
            step_length: SAFE_STEP / if k > 0 { 1.1 * bound } else { bound },
            x,
            gradient: vec![0.0; m],
            direction: vec![0.0; m],
            free: vec![0.0; m],
            chopped: vec![0.0; m],
            multiplier: vec![0.0; k],
            modes_product: vec![0.0; k],
            modes_x: vec![0.0; k],
            lagrangian: None,
            imbalance: f64::INFINITY,
            slow: 0,
            at: Forces::none(setup),
            operand: vec![0.0; m],
            inside: vec![0.0; m],
            image: vec![0.0; m],
            modes_image: vec![0.0; k],
            parts: vec![0.0; k],
            kind: 'c',
        };
        state.prepare();
        state.refresh();
        if let Some(guess) = guess {
            state.adopt(&guess.alpha);
        }
        if state.size == 0.0 {
            state.size = norm(&state.gradient);
        }
        state
    }

    /// Begins with the μ that makes the gradient the gap of the guess.
    fn adopt(&mut self, alpha: &[f64]) {
        let balance = &self.setup.balance;
        balance.from_original(alpha, &mut self.at.alpha);
        balance.apply(&self.x, &mut self.modes_x);
        for j in 0..self.at.alpha.len() {
            self.multiplier[j] = self.beside(j, self.at.alpha[j]);
        }
        balance.add_transposed(1.0, &self.multiplier, &mut self.gradient);
        self.restart();
    }

    /// α̂ beside a multiplier and the multiplier beside α̂, which add up to Ĝ(Fλ − d) − ϱĜx.
    fn beside(&self, j: usize, other: f64) -> f64 {
        self.modes_product[j] - self.modes_shift[j] - other - self.penalty * self.modes_x[j]
    }

    /// Right-hand side of the shifted problem.
    fn prepare(&mut self) {
        let balance = &self.setup.balance;
        balance.apply(&self.setup.problem.shift, &mut self.modes_shift);
        if self.offset.iter().any(|x| *x != 0.0) {
            self.setup.multiply(&self.offset, &mut self.image);
            balance.apply(&self.image, &mut self.modes_offset);
            for (right, image) in self.right.iter_mut().zip(&self.image) {
                *right -= image;
            }
        }
        let mut parts = vec![0.0; self.setup.modes()];
        balance.apply(&self.right, &mut parts);
        balance.add_transposed(-1.0, &parts, &mut self.right);
        self.size = norm(&self.right);
    }

    /// `image` = (PFP + ϱQ)v and `modes_image` = ĜFPv of the operand v.
    fn multiply(&mut self) {
        let balance = &self.setup.balance;
        let (v, parts) = (&self.operand, &mut self.parts);
        balance.apply(v, parts);
        self.inside.copy_from_slice(v);
        balance.add_transposed(-1.0, parts, &mut self.inside);
        self.setup.multiply(&self.inside, &mut self.image);
        balance.apply(&self.image, &mut self.modes_image);
        for (part, image) in parts.iter_mut().zip(&self.modes_image) {
            *part = self.penalty * *part - image;
        }
        balance.add_transposed(1.0, parts, &mut self.image);
    }

    /// Gradient from scratch, and a new direction.
    fn refresh(&mut self) {
        let balance = &self.setup.balance;
        self.operand.copy_from_slice(&self.x);
        self.multiply();
        for i in 0..self.x.len() {
            self.gradient[i] = self.image[i] - self.right[i];
        }
        balance.add_transposed(1.0, &self.multiplier, &mut self.gradient);
        for j in 0..self.modes_product.len() {
            self.modes_product[j] = self.modes_offset[j] + self.modes_image[j];
        }
        self.restart();
    }

    /// φ and β of the gradient, and φ as the direction.
    fn restart(&mut self) {
        self.split();
        self.direction.copy_from_slice(&self.free);
    }

    /// φ and β of the gradient.
    fn split(&mut self) {
        for i in 0..self.x.len() {
            let (low, high) = (self.x[i] <= self.floor[i], self.x[i] >= self.ceiling[i]);
            let g = self.gradient[i];
            (self.free[i], self.chopped[i]) = match (low, high) {
                (false, false) => (g, 0.0),
                (true, false) => (0.0, g.min(0.0)),
                (false, true) => (0.0, g.max(0.0)),
                (true, true) => (0.0, 0.0),
            };
        }
    }

    /// Ĝλ = ê to rounding: by the loaded forces alone where they stay admissible, else by the projection, which also
    /// loads open contacts a little.
    fn balance_exactly(&mut self) {
        let setup = self.setup;
        let both = self.at.lambda.iter().zip(&self.bounds);
        let loaded: Vec<bool> = both
            .map(|(force, own)| *force > own.start && *force < own.end)
            .collect();
        let mut trial = self.at.lambda.clone();
        let balanced = restore(setup, &loaded, &mut trial);
        let mut both = trial.iter().zip(&self.bounds);
        let admissible = both.all(|(force, own)| (own.start..=own.end).contains(force));
        if balanced && admissible {
            self.at.lambda = trial;
        } else {
            let mut tau = vec![0.0; setup.modes()];
            trial.copy_from_slice(&self.at.lambda);
            self.projector
                .project(&trial, &mut tau, &mut self.at.lambda);
        }
    }

    /// The inner problem is solved well enough for the imbalance that is left.
    fn settled(&self) -> bool {
        if self.modes_x.is_empty() {
            return false;
        }
        let projected = (dot(&self.free, &self.free) + dot(&self.chopped, &self.chopped)).sqrt();
        let imbalance = norm(&self.modes_x);
        imbalance > 0.0 && projected <= (self.precision * imbalance).min(0.1 * self.size)
    }

    /// μ += ϱQx; the gradient follows without a product.
    fn update_balance(&mut self) {
        let balance = &self.setup.balance;
        let imbalance = dot(&self.modes_x, &self.modes_x);
        // 1/2 xᵀHx − (b − μ)ᵀx with Hx = g + b − μ, and μᵀx = multiplier · Ĝx.
        let value = 0.5
            * (dot(&self.x, &self.gradient) - dot(&self.x, &self.right)
                + dot(&self.multiplier, &self.modes_x));
        if self
            .lagrangian
            .is_some_and(|before| value < before + 0.5 * self.penalty * imbalance)
        {
            self.precision *= 0.5;
        }
        self.lagrangian = Some(value);
        let slow = imbalance > SLOW * SLOW * self.imbalance;
        self.slow = if slow { self.slow + 1 } else { 0 };
        self.imbalance = imbalance;
        for (multiplier, part) in self.multiplier.iter_mut().zip(&self.modes_x) {
            *multiplier += self.penalty * part;
        }
        balance.add_transposed(self.penalty, &self.modes_x, &mut self.gradient);
        if self.slow == SLOW_STEPS {
            let more = (GROWTH - 1.0) * self.penalty;
            self.penalty *= GROWTH;
            self.step_length /= GROWTH;
            balance.add_transposed(more, &self.modes_x, &mut self.gradient);
            self.slow = 0;
        }
        self.restart();
    }

    /// One inner step.
    fn step(&mut self) {
        let reduced: f64 = (0..self.x.len())
            .map(|i| {
                let room = (self.x[i] - self.floor[i]) / self.step_length;
                let above = (self.x[i] - self.ceiling[i]) / self.step_length;
                self.free[i] * self.free[i].min(room).max(above)
            })
            .sum();
        if dot(&self.chopped, &self.chopped) > reduced {
            self.proportion();
            return;
        }
        self.operand.copy_from_slice(&self.direction);
        let (curvature, exact) = self.exact_step();
        let conjugate = exact.unwrap_or(f64::INFINITY);
        let feasible = self.longest(&self.direction);
        if conjugate <= feasible && conjugate.is_finite() {
            self.kind = 'c';
            self.walk(conjugate);
            let turn = dot(&self.free, &self.image) / curvature;
            for (direction, free) in self.direction.iter_mut().zip(&self.free) {
                *direction = free - turn * *direction;
            }
        } else {
            self.kind = 'e';
            if feasible.is_finite() {
                self.walk(feasible);
            }
            for i in 0..self.x.len() {
                self.x[i] = (self.x[i] - self.step_length * self.free[i])
                    .max(self.floor[i])
                    .min(self.ceiling[i]);
            }
            self.refresh();
        }
    }

    /// Releases active unknowns along β with the exact step.
    fn proportion(&mut self) {
        self.kind = 'p';
        self.operand.copy_from_slice(&self.chopped);
        let (_, exact) = self.exact_step();
        let step = exact.unwrap_or(self.step_length);
        // A tangential force may reach its other bound.
        self.walk(step.min(self.longest(&self.chopped)));
        self.direction.copy_from_slice(&self.free);
    }

    /// vᵀ(PFP + ϱQ)v of the operand v, and the step along it to the least energy, where there is one.
    fn exact_step(&mut self) -> (f64, Option<f64>) {
        self.multiply();
        let curvature = dot(&self.operand, &self.image);
        let descent = dot(&self.gradient, &self.operand);
        (curvature, (curvature > 0.0).then(|| descent / curvature))
    }

    /// The longest step for which x − step · v keeps its bounds.
    fn longest(&self, v: &[f64]) -> f64 {
        let limit = |i: usize| {
            let bound = if v[i] > 0.0 {
                self.floor[i]
            } else {
                self.ceiling[i]
            };
            (self.x[i] - bound) / v[i]
        };
        (0..v.len())
            .filter(|&i| v[i] != 0.0)
            .map(limit)
            .fold(f64::INFINITY, f64::min)
    }

    /// x −= `step`·v for the operand v, and the gradient with it; then φ and β.
    fn walk(&mut self, step: f64) {
        for (i, v) in self.operand.iter().enumerate() {
            self.x[i] = (self.x[i] - step * v)
                .max(self.floor[i])
                .min(self.ceiling[i]);
        }
        for (gradient, image) in self.gradient.iter_mut().zip(&self.image) {
            *gradient -= step * image;
        }
        for (product, image) in self.modes_product.iter_mut().zip(&self.modes_image) {
            *product -= step * image;
        }
        self.split();
    }
}

/// Bounds of every force (m,).
fn bounds(setup: &Setup<'_>) -> Vec<Range<f64>> {
    let least = |component: &Component| match component {
        Component::Normal => 0.0,
        Component::Free | Component::Tangent => f64::NEG_INFINITY,
    };
    let components = setup.components.iter();
    let mut bounds: Vec<Range<f64>> = components.map(|c| least(c)..f64::INFINITY).collect();
    for (block, range) in setup.admissible.iter() {
        if let Some(bound) = block.bound(0.0) {
            bounds[range.start + 1..range.end].fill(-bound..bound);
        }
    }
    bounds
}

/// Discs are not boxes.
fn check_tangents(setup: &Setup<'_>) -> Result<(), SolveError> {
    let disc = |block: &Block| block.friction().is_some() && block.size() > 2;
    let blocks = setup.admissible.blocks();
    match blocks.iter().position(disc) {
        None => Ok(()),
        Some(block) => Err(SolveError::Unsupported {
            method: Mprgp::NAME,
            block,
            found: blocks[block],
            reason: "it treats friction with one tangential force per node, not with two: use newton or accelerated",
        }),
    }
}

/// Adds to the `loaded` forces what of least norm balances all of them; `false` where they cannot.
fn restore(setup: &Setup<'_>, loaded: &[bool], forces: &mut [f64]) -> bool {
    let list: Vec<usize> = (0..forces.len()).filter(|&i| loaded[i]).collect();
    let rows = setup.balance.rows().iter();
    let rows =
        rows.map(|row| SparseVector::new(list.len(), list.iter().map(|&i| row[i]).enumerate()));
    let rows = setup.balance.orthonormal_rows(rows.collect());
    let mut null = Null::new(&rows, &[]);
    let mut rest = vec![0.0; rows.len()];
    // the second pass removes what rounding left
    for _ in 0..2 {
        setup.balance.imbalance(forces, &mut rest);
        rest.iter_mut().for_each(|rest| *rest = -*rest);
        let mut change = vec![0.0; list.len()];
        null.restore(&rows, &rest, &mut change);
        for (&i, change) in list.iter().zip(&change) {
            forces[i] += change;
        }
    }
    setup.balance.imbalance(forces, &mut rest);
    norm(&rest) <= NO_WORK * norm(setup.balance.target()).max(SMALL_LOAD * norm(forces))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::dual::{AdmissibleSet, Balance, Compliance, DualProblem};
    use crate::linalg::Mat;
    use crate::solve::{ContactSolver, Iterate};
    use std::ops::ControlFlow;

    /// A plate on springs of compliance 1/(1 + j), loaded off centre: some springs open.
    fn plate(m: usize) -> DualProblem {
        let modes = Mat::from_fn(2, m, |i, j| {
            if i == 0 {
                1.0
            } else {
                2.0 * j as f64 / m as f64 - 1.0
            }
        });
        DualProblem::new(
            Compliance::Dense(Mat::from_fn(m, m, |i, j| {
                if i == j { 1.0 / (1.0 + j as f64) } else { 0.0 }
            })),
            (0..m).map(|j| 0.01 * (j as f64).sin()).collect(),
            AdmissibleSet::new(vec![Block::Unilateral; m]),
            Balance::new(modes, vec![1.0, 0.7]),
        )
        .unwrap()
    }

    #[test]
    fn balance_is_exact_and_every_kind_of_step_occurs() {
        let problem = plate(40);
        let mut kinds = std::collections::BTreeSet::new();
        // From no force at all, so that contacts must be released, too.
        let nothing = Multipliers {
            lambda: vec![0.0; 40],
            alpha: vec![0.0; 2],
        };
        let outcome = Mprgp::default()
            .solve(&problem, Some(&nothing), &mut |iterate: &Iterate<'_>| {
                kinds.insert(iterate.step);
                ControlFlow::Continue(())
            })
            .unwrap();
        assert!(problem.certify(&outcome.multipliers, 1e-8).holds());
        assert!(outcome.multipliers.lambda.contains(&0.0));
        assert_eq!(kinds.into_iter().collect::<String>(), "cep");
    }

    #[test]
    fn too_few_iterations_are_an_error_with_the_last_iterate() {
        let solver = Mprgp {
            max_iterations: 3,
            ..Mprgp::default()
        };
        let result = solver.solve(&plate(40), None, &mut |_| ControlFlow::Continue(()));
        let Err(SolveError::NotConverged {
            outcome, residual, ..
        }) = result
        else {
            panic!("three iterations cannot suffice");
        };
        assert_eq!(outcome.iterations, 3);
        assert!(residual > 1e-8);
    }
}
