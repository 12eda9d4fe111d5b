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
//! depends on spectral bounds only, and all parameters are automatic: ᾱ = 1.9/ϱ, ϱ = 1.1L, M = 100L halved when the
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

/// Least scale of the load as a part of the forces: self-balanced loads round like the forces.
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
        let mut state = MprgpState::new(self, setup, &start, guess);
        iterate(self, setup, &mut state, 0, observe)
    }
}

impl Iteration for MprgpState<'_> {
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

    /// An outer step, which does not count as an iteration, or an inner one.
    fn advance(&mut self, _gap: &[f64]) -> usize {
        let settled = self.settled();
        match settled {
            true => self.update_balance(),
            false => self.step(),
        }
        usize::from(!settled)
    }

    /// The residual of balanced forces with a fresh product; each failure lowers the estimate at which the next one is computed.
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
struct MprgpState<'a> {
    setup: &'a Setup<'a>,
    projector: Projector<'a>,
    tolerance: f64,
    /// The estimate of the residual below which a verdict is computed.
    ask: f64,
    /// Ĝᵀê.
    offset: Vec<f64>,
    /// Bounds of the forces, and those of x; infinite where unbounded.
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

impl<'a> MprgpState<'a> {
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

    /// The inner problem is solved well enough for the remaining imbalance.
    fn settled(&self) -> bool {
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

    /// vᵀ(PFP + ϱQ)v of the operand v, and the step along it to the least energy, if a minimum exists.
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
            bounds[block.shear(&range)].fill(-bound..bound);
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
            method: Mprgp::NAME.to_string(),
            block,
            found: blocks[block],
            reason: "it treats friction with one tangential force per node, not with two: use newton or accelerated",
        }),
    }
}

/// Adds the change of least norm to the `loaded` forces that balances all of them; `false` if they cannot balance.
fn restore(setup: &Setup<'_>, loaded: &[bool], forces: &mut [f64]) -> bool {
    let list: Vec<usize> = (0..forces.len()).filter(|&i| loaded[i]).collect();
    let rows = setup.balance.rows().iter();
    let rows =
        rows.map(|row| SparseVector::new(list.len(), list.iter().map(|&i| row[i]).enumerate()));
    let rows = setup.balance.orthonormal_rows(rows.collect());
    let mut null = Null::new(&rows, &[]);
    let mut rest = vec![0.0; rows.len()];
    // the second pass removes rounding
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
    use crate::dual::{AdmissibleSet, Balance, Compliance, DualProblem, Friction};
    use crate::linalg::Mat;
    use crate::solve::tests::{apart, definite, of, times};
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

    fn modes() -> [Vec<f64>; 2] {
        [
            vec![1.0; 8],
            (0..8).map(|i| 0.25 * i as f64 - 0.6).collect(),
        ]
    }

    fn floating() -> DualProblem {
        of(
            Compliance::Dense(definite(8)),
            &[1.0, -0.4, 0.7, 0.2, -1.0, 0.9, -0.8, 0.6],
            vec![Block::Unilateral; 8],
            (&modes(), &[2.0, 0.3]),
        )
    }

    /// The gradient of the augmented Lagrangian at x, from products with P and Q written out.
    fn gradient(state: &MprgpState<'_>) -> Vec<f64> {
        let (setup, m) = (state.setup, state.x.len());
        let along = |v: &[f64]| {
            let mut parts = vec![0.0; setup.modes()];
            setup.balance.apply(v, &mut parts);
            let mut image = vec![0.0; m];
            setup.balance.add_transposed(1.0, &parts, &mut image);
            image
        };
        let across =
            |v: &[f64]| -> Vec<f64> { v.iter().zip(along(v)).map(|(v, part)| v - part).collect() };
        let f = definite(m);
        let elastic = across(&times(&f, &across(&state.x)));
        let mut offset = vec![0.0; m];
        setup
            .balance
            .add_transposed(1.0, setup.balance.target(), &mut offset);
        let loaded = times(&f, &offset);
        let right: Vec<f64> = (0..m).map(|i| setup.problem.shift[i] - loaded[i]).collect();
        let (right, held) = (across(&right), along(&state.x));
        let mut pull = vec![0.0; m];
        setup
            .balance
            .add_transposed(1.0, &state.multiplier, &mut pull);
        (0..m)
            .map(|i| elastic[i] + state.penalty * held[i] - right[i] + pull[i])
            .collect()
    }

    #[test]
    fn gradient_is_carried_through_every_kind_of_step() {
        let problem = floating();
        let setup = Setup::new(&problem).unwrap();
        let method = Mprgp::default();
        let nothing = Multipliers {
            lambda: vec![0.0; 8],
            alpha: vec![0.0; 2],
        };
        let far = Multipliers {
            lambda: (0..8).map(|i| if i % 2 == 0 { 5.0 } else { 0.0 }).collect(),
            alpha: vec![0.0; 2],
        };
        let mut kinds = std::collections::BTreeSet::new();
        for guess in [None, Some(&nothing), Some(&far)] {
            let start = setup.start(guess).unwrap();
            let mut state = super::MprgpState::new(&method, &setup, &start, guess);
            let mut outer = 0;
            for step in 0..60 {
                assert!(
                    apart(&state.gradient, &gradient(&state)) < 1e-12,
                    "step {step}"
                );
                state.evaluate();
                for i in 0..8 {
                    let x = state.x[i];
                    assert!(x >= state.floor[i] && state.at.lambda[i] >= 0.0);
                    let free = x > state.floor[i];
                    let expected = if free {
                        (state.gradient[i], 0.0)
                    } else {
                        (0.0, state.gradient[i].min(0.0))
                    };
                    assert_eq!((state.free[i], state.chopped[i]), expected);
                }
                // the gap that is told is that of these forces with the amplitudes that are told, but for the imbalance
                let told = setup.multipliers(&state.at.lambda, &state.at.alpha);
                let mut imbalance = vec![0.0; 2];
                setup.balance.imbalance(&told.lambda, &mut imbalance);
                if norm(&imbalance) < 1e-13 {
                    assert!(
                        apart(&problem.gap(&told), &state.gradient) < 1e-11,
                        "step {step}"
                    );
                }
                // the product that belongs to it is that of the forces whose imbalance is taken away
                let mut parts = vec![0.0; 2];
                setup.balance.apply(&state.x, &mut parts);
                let mut inside: Vec<f64> = (0..8).map(|i| state.offset[i] + state.x[i]).collect();
                setup.balance.add_transposed(-1.0, &parts, &mut inside);
                assert!(apart(&state.at.product, &times(&definite(8), &inside)) < 1e-11);
                match state.advance(&[]) {
                    0 => outer += 1,
                    _ => {
                        kinds.insert(state.kind);
                    }
                }
            }
            assert!(outer > 2, "{outer} outer steps");
            let told = setup.multipliers(&state.at.lambda, &state.at.alpha);
            assert!(problem.kkt_residual(&told) < 1e-6);
        }
        assert!(kinds.contains(&'c') && kinds.contains(&'p'), "{kinds:?}");
    }

    #[test]
    fn multiplier_of_a_guess_makes_its_gap_the_gradient() {
        let problem = floating();
        let setup = Setup::new(&problem).unwrap();
        // in balance: λ = Gᵀ(GGᵀ)⁻¹e is positive here
        let mut lambda = vec![0.0; 8];
        setup
            .balance
            .add_transposed(1.0, setup.balance.target(), &mut lambda);
        assert!(lambda.iter().all(|force| *force > 0.0));
        let guess = Multipliers {
            lambda,
            alpha: vec![0.3, -0.8],
        };
        let start = setup.start(Some(&guess)).unwrap();
        let mut state = super::MprgpState::new(&Mprgp::default(), &setup, &start, Some(&guess));
        assert!(apart(&state.gradient, &problem.gap(&guess)) < 1e-12);
        state.evaluate();
        assert!(apart(&setup.multipliers(&[], &state.at.alpha).alpha, &guess.alpha) < 1e-12);
        assert!(apart(&state.at.product, &times(&definite(8), &guess.lambda)) < 1e-12);
        assert_eq!(state.direction, state.free);
        let bound = projected_bound(&setup);
        assert!((state.penalty / bound - 1.1).abs() < 1e-14);
        assert!((state.precision / bound - 100.0).abs() < 1e-12);
        assert!((state.step_length * bound - 1.9 / 1.1).abs() < 1e-14);
    }

    #[test]
    fn outer_steps_raise_the_penalty_where_they_crawl_and_the_precision_where_nothing_is_gained() {
        let problem = floating();
        let setup = Setup::new(&problem).unwrap();
        let start = setup.start(None).unwrap();
        let outer = |imbalance: f64, slow: usize, lagrangian: f64| {
            let mut state = super::MprgpState::new(&Mprgp::default(), &setup, &start, None);
            // an x out of balance, and its Lagrangian by definition
            state.x = vec![0.5; 8];
            state.refresh();
            setup.balance.apply(&state.x, &mut state.modes_x);
            let square = dot(&state.modes_x, &state.modes_x);
            (state.imbalance, state.slow) = (imbalance * square, slow);
            let hx: Vec<f64> = (0..8).map(|i| state.gradient[i] + state.right[i]).collect();
            let value = 0.5 * dot(&state.x, &hx) - dot(&state.x, &state.right);
            let enough = value - 0.5 * state.penalty * square;
            state.lagrangian = Some(enough + lagrangian);
            let (penalty, precision, length) = (state.penalty, state.precision, state.step_length);
            state.update_balance();
            assert!((state.lagrangian.unwrap() - value).abs() < 1e-12);
            assert!(apart(&state.gradient, &gradient(&state)) < 1e-11);
            let told = (0..2).map(|j| state.multiplier[j] - penalty * state.modes_x[j]);
            assert!(told.fold(0.0, |s: f64, x| s.max(x.abs())) < 1e-12);
            assert_eq!(state.direction, state.free);
            (
                state.penalty / penalty,
                length / state.step_length,
                state.precision / precision,
                state.slow,
            )
        };
        // a quarter of the square is half of the imbalance
        assert_eq!(outer(3.9, 2, -1e-6), (4.0, 4.0, 1.0, 0));
        assert_eq!(outer(4.1, 2, -1e-6), (1.0, 1.0, 1.0, 0));
        assert_eq!(outer(3.9, 1, 1e-6), (1.0, 1.0, 0.5, 2));
    }

    #[test]
    fn inner_problem_is_settled_for_the_imbalance_that_is_left() {
        let problem = floating();
        let setup = Setup::new(&problem).unwrap();
        let start = setup.start(None).unwrap();
        let mut state = super::MprgpState::new(&Mprgp::default(), &setup, &start, None);
        let mut settled = |free: f64, chopped: f64, imbalance: f64, precision: f64, size: f64| {
            state.free = vec![0.0; 8];
            state.chopped = vec![0.0; 8];
            (state.free[2], state.chopped[5]) = (3.0 * free, -4.0 * chopped);
            state.modes_x = vec![0.6 * imbalance, -0.8 * imbalance];
            (state.precision, state.size) = (precision, size);
            state.settled()
        };
        // the gradient is 5, or 3, or 4 long
        assert!(settled(1.0, 1.0, 0.1, 51.0, 60.0));
        assert!(!settled(1.0, 1.0, 0.1, 49.0, 60.0));
        assert!(!settled(1.0, 1.0, 0.1, 51.0, 49.0));
        assert!(settled(1.0, 0.0, 0.1, 31.0, 31.0) && !settled(0.0, 1.0, 0.1, 31.0, 60.0));
        assert!(!settled(0.0, 0.0, 0.0, 1.0, 1.0));
    }

    #[test]
    fn longest_step_ends_at_the_first_bound() {
        let tresca = Friction::Tresca { bound: 2.0 }.block(1);
        let problem = of(
            Compliance::Dense(definite(4)),
            &[1.0; 4],
            vec![tresca, Block::Unilateral, Block::Free { size: 1 }],
            (&[], &[]),
        );
        let setup = Setup::new(&problem).unwrap();
        let own = bounds(&setup);
        assert_eq!(own[0], 0.0..f64::INFINITY);
        assert_eq!(own[1], -2.0..2.0);
        assert_eq!(own[2], 0.0..f64::INFINITY);
        assert_eq!(own[3], f64::NEG_INFINITY..f64::INFINITY);
        let start = setup.start(None).unwrap();
        let mut state = super::MprgpState::new(&Mprgp::default(), &setup, &start, None);
        state.x = vec![1.0, 0.5, 3.0, 0.0];
        assert_eq!(state.longest(&[0.5, 0.0, 1.0, 7.0]), 2.0);
        assert_eq!(state.longest(&[0.0, 1.25, 1.0, 0.0]), 2.0);
        assert_eq!(state.longest(&[0.0, -0.5, 0.0, 0.0]), 3.0);
        assert_eq!(state.longest(&[-1.0, 0.0, 0.0, 9.0]), f64::INFINITY);
        // both sides of a bound that leaves no room are held
        state.gradient = vec![1.0, -1.0, -1.0, 2.0];
        state.x = vec![0.0, 2.0, 0.0, 0.0];
        state.split();
        assert_eq!(state.free, [0.0, 0.0, 0.0, 2.0]);
        assert_eq!(state.chopped, [0.0, 0.0, -1.0, 0.0]);
        state.gradient[1] = 1.0;
        state.split();
        assert_eq!((state.free[1], state.chopped[1]), (0.0, 1.0));
        (state.floor[1], state.ceiling[1]) = (2.0, 2.0);
        state.split();
        assert_eq!((state.free[1], state.chopped[1]), (0.0, 0.0));
    }

    #[test]
    fn friction_with_given_bounds_meets_its_law_and_that_of_space_is_refused() {
        let tresca = Friction::Tresca { bound: 0.1 }.block(1);
        let shift = [1.0, 0.5, 0.8, -0.9, 0.6, 0.1];
        let compliance = || Compliance::Dense(definite(6));
        let problem = of(compliance(), &shift, vec![tresca; 3], (&[], &[]));
        let outcome = Mprgp::default()
            .solve(&problem, None, &mut |_| ControlFlow::Continue(()))
            .unwrap();
        assert!(problem.certify(&outcome.multipliers, 1e-8).holds());
        let slips = |t: usize| outcome.multipliers.lambda[t].abs() > 0.1 - 1e-9;
        assert!(slips(1) && slips(3));
        let disc = Friction::Tresca { bound: 0.1 }.block(2);
        let problem = of(
            compliance(),
            &shift,
            vec![tresca, Block::Unilateral, disc],
            (&[], &[]),
        );
        let error = Mprgp::default().solve(&problem, None, &mut |_| ControlFlow::Continue(()));
        let Err(SolveError::Unsupported { block, found, .. }) = error else {
            panic!("discs are no boxes");
        };
        assert_eq!((block, found), (2, disc));
    }

    #[test]
    fn loaded_forces_alone_restore_the_balance_where_they_can() {
        let problem = floating();
        let setup = Setup::new(&problem).unwrap();
        let mut loaded = vec![false; 8];
        for i in [1, 4, 6] {
            loaded[i] = true;
        }
        let before = [0.0, 1.0, 0.0, 0.0, 0.5, 0.0, 0.7, 0.2];
        let mut after = before;
        assert!(restore(&setup, &loaded, &mut after));
        let carried = problem.balance.modes().product(&after);
        assert!(apart(&carried, &[2.0, 0.3]) < 1e-14);
        let change: Vec<f64> = (0..8).map(|i| after[i] - before[i]).collect();
        assert!((0..8).all(|i| loaded[i] || change[i] == 0.0));
        // of least norm: nothing along the forces of these three that balance each other
        let g = |i: usize| modes()[1][i];
        let own = [g(6) - g(4), g(1) - g(6), g(4) - g(1)];
        let along = change[1] * own[0] + change[4] * own[1] + change[6] * own[2];
        assert!(along.abs() < 1e-14);
        // one force cannot balance two motions
        let one: Vec<bool> = (0..8).map(|i| i == 4).collect();
        assert!(!restore(&setup, &one, &mut before.clone()));
    }

    #[test]
    fn last_step_balances_exactly_and_by_the_projection_where_it_must() {
        let problem = floating();
        let setup = Setup::new(&problem).unwrap();
        let start = setup.start(None).unwrap();
        let mut state = super::MprgpState::new(&Mprgp::default(), &setup, &start, None);
        let carried = |lambda: &[f64]| problem.balance.modes().product(lambda);
        state.at.lambda = vec![0.0, 1.0, 0.0, 0.5, 0.0, 0.4, 0.0, 0.0];
        state.balance_exactly();
        assert!(apart(&carried(&state.at.lambda), &[2.0, 0.3]) < 1e-13);
        assert_eq!([0, 2, 4, 6, 7].map(|i| state.at.lambda[i]), [0.0; 5]);
        // one force alone cannot: others are loaded
        state.at.lambda = vec![0.0, 0.0, 0.0, 2.0, 0.0, 0.0, 0.0, 0.0];
        state.balance_exactly();
        assert!(apart(&carried(&state.at.lambda), &[2.0, 0.3]) < 1e-11);
        assert!(state.at.lambda.iter().all(|force| *force >= 0.0));
        // two whose balance would need tension
        state.at.lambda = vec![1.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0];
        state.balance_exactly();
        assert!(apart(&carried(&state.at.lambda), &[2.0, 0.3]) < 1e-11);
        assert!(state.at.lambda.iter().all(|force| *force >= 0.0));
    }
}
