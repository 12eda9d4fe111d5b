//! Uzawa's iteration with crossed-secant acceleration: no parameter, and few iterations.
//!
//! ```text
//!   λ̂ₖ = P(λₖ − ρ(Fλₖ − d)),   δₖ = λ̂ₖ − λₖ
//!   λₖ₊₁ = P(λ̂ₖ − s δₖ),       s = (λ̂ₖ − λ̂ₖ₋₁)·(δₖ − δₖ₋₁)/|δₖ − δₖ₋₁|²
//! ```
//!
//! The map λ ↦ λ̂ is one iteration of Uzawa's method, here that of `gradient.rs`: P projects onto Λ ∩ {Gλ = e}. Two pairs
//! (λ, λ̂) give the point where a secant through them meets λ̂ = λ. While the same contacts are closed the map is linear and ρ cancels:
//! λₖ₊₁ = λₖ − β gapₖ with β = Δλ·Δgap/|Δgap|², the shorter step of Barzilai and Borwein, so that ρ need not be chosen. Bolts
//! in place of the exact projection, as in the p,A-algorithm, double the iterations: 91 for 50 with 400 nodes below a punch
//! that may sink, 198 for 99 with all of them closed.
//!
//! A secant step may raise the energy 1/2 λᵀFλ − dᵀλ, but not above the largest of the last ten: else λ̂ is taken instead,
//! which lowers it for every ρ < 2/L. So the iteration converges from every start.
//!
//! As described in Koliesnikova & Ramière (2026), arXiv 2603.12205, for Uzawa's iteration in contact problems; the secant as
//! described in Ramière & Helfer (2015); the safeguard as described in Grippo, Lampariello & Lucidi (1986). The projection
//! of the secant point and the safeguard are additions of ours.

use crate::dual::Multipliers;
use crate::solve::gradient::projected_bound;
use crate::solve::iteration::{FixedStep, Iteration, Projection, iterate};
use crate::solve::setup::{Forces, Position, Setup};
use crate::solve::{FixedBounds, Observer, Outcome, SolveError, TOLERANCE, dot};

/// Number of energies with which a secant step is compared.
const MEMORY: usize = 10;

/// Part of |δ|²/ρ by which a secant step must stay below them.
const DECREASE: f64 = 1e-4;

/// Rounding of an energy as a part of its terms.
const ENERGY_ROUNDING: f64 = 1e-14;

/// Uzawa's iteration with crossed-secant acceleration.
#[derive(Debug, Clone, PartialEq)]
pub struct Secant {
    /// Residual at which it stops.
    pub tolerance: f64,
    /// Most iterations.
    pub max_iterations: usize,
}

impl Default for Secant {
    fn default() -> Self {
        Self {
            tolerance: TOLERANCE,
            max_iterations: 100_000,
        }
    }
}

impl FixedBounds for Secant {
    const NAME: &'static str = "secant";

    fn limits_mut(&mut self) -> (&mut f64, &mut usize) {
        (&mut self.tolerance, &mut self.max_iterations)
    }

    fn run(
        &self,
        setup: &Setup<'_>,
        guess: Option<&Multipliers>,
        observe: Observer<'_>,
    ) -> Result<Outcome, SolveError> {
        let (projection, at) = Projection::start(setup, guess)?;
        let now = Pair {
            image: at.lambda.clone(),
            at,
        };
        let mut steps = SecantSteps {
            setup,
            projection,
            step: FixedStep::new(None, || projected_bound(setup)),
            then: now.clone(),
            now,
            energies: Vec::new(),
            kind: 'g',
        };
        iterate(self, setup, &mut steps, 0, observe)
    }
}

/// Forces, and their image by Uzawa's iteration.
#[derive(Clone)]
struct Pair {
    at: Forces,
    /// λ̂, (m,).
    image: Vec<f64>,
}

impl Pair {
    /// δ, (m,).
    fn step(&self) -> impl Iterator<Item = f64> {
        let pairs = self.image.iter().zip(&self.at.lambda);
        pairs.map(|(image, force)| image - force)
    }
}

struct SecantSteps<'a> {
    setup: &'a Setup<'a>,
    projection: Projection<'a>,
    step: FixedStep,
    /// The last two iterates.
    now: Pair,
    then: Pair,
    /// Energies of the last iterates, the latest first.
    energies: Vec<f64>,
    /// Secant step, or plain one.
    kind: char,
}

impl SecantSteps<'_> {
    /// Finds the product of the present forces; returns their energy and its rounding.
    fn energy(&mut self) -> (f64, f64) {
        let Forces {
            lambda, product, ..
        } = &mut self.now.at;
        self.setup.multiply(lambda, product);
        let (own, work) = (0.5 * dot(lambda, product), dot(lambda, &self.setup.shift));
        (own - work, ENERGY_ROUNDING * (own.abs() + work.abs()))
    }

    /// The largest energy that a secant step may have.
    fn bar(&self) -> f64 {
        let square: f64 = self.then.step().map(|step| step * step).sum();
        let largest = self.energies.iter().copied().fold(f64::MIN, f64::max);
        largest - DECREASE * square / self.step.rho
    }

    /// s; zero for the first step, and where δ stands still.
    fn secant(&self) -> f64 {
        let (now, then) = (&self.now, &self.then);
        let changes = || now.step().zip(then.step()).map(|(now, then)| now - then);
        let images = now.image.iter().zip(&then.image);
        let along: f64 = images.zip(changes()).map(|((a, b), c)| (a - b) * c).sum();
        let square: f64 = changes().map(|c| c * c).sum();
        match self.energies.len() > 1 && square > 0.0 {
            true => along / square,
            false => 0.0,
        }
    }
}

impl Iteration for SecantSteps<'_> {
    fn evaluate(&mut self) {
        let (mut energy, rounding) = self.energy();
        let falls = energy <= self.bar() + rounding;
        if self.kind == 's' && !falls {
            self.now.at.lambda.copy_from_slice(&self.then.image);
            self.kind = 'g';
            energy = self.energy().0;
        }
        self.energies.truncate(MEMORY - 1);
        self.energies.insert(0, energy);
        let Pair { at, image } = &mut self.now;
        self.step.adapt(at, &self.then.at, |_| true);
        self.projection
            .descend(self.setup, self.step.rho, at, image);
    }

    fn point(&self) -> Position<'_> {
        self.now.at.at(self.setup, self.kind)
    }

    fn advance(&mut self, _gap: &[f64]) -> usize {
        let s = self.secant();
        std::mem::swap(&mut self.now, &mut self.then);
        let Pair { at, image } = &self.then;
        let next = |i: usize| image[i] - s * (image[i] - at.lambda[i]);
        self.projection.project(next, &mut self.now.at.lambda);
        self.kind = if s == 0.0 { 'g' } else { 's' };
        1
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::dual::{AdmissibleSet, Balance, Block, Compliance, DualProblem};
    use crate::linalg::Mat;
    use crate::solve::{ContactSolver, Iterate};
    use std::ops::ControlFlow;

    /// Closed contacts beside each other on springs whose compliances fall from 1 to 1e-3.
    fn springs(m: usize) -> DualProblem {
        let compliance = |i: usize| 1e3f64.powf(-(i as f64) / (m as f64 - 1.0));
        DualProblem::new(
            Compliance::Dense(Mat::from_fn(m, m, |i, j| match i == j {
                true => compliance(i),
                false => 0.0,
            })),
            (0..m)
                .map(|i| compliance(i) * (1.0 + 0.5 * (i as f64).sin()))
                .collect(),
            AdmissibleSet::new(vec![Block::Unilateral; m]),
            Balance::none(m),
        )
        .unwrap()
    }

    #[test]
    fn energy_never_exceeds_the_largest_of_the_last_ten() {
        let problem = springs(20);
        let (mut energies, mut kinds) = (Vec::new(), String::new());
        let outcome = Secant::default()
            .solve(&problem, None, &mut |iterate: &Iterate<'_>| {
                let mut product = vec![0.0; 20];
                problem.compliance.apply(iterate.lambda, &mut product);
                let half: f64 = 0.5 * dot(iterate.lambda, &product);
                energies.push(half - dot(iterate.lambda, &problem.shift));
                kinds.push(iterate.step);
                ControlFlow::Continue(())
            })
            .unwrap();
        assert!(problem.certify(&outcome.multipliers, 1e-8).holds());
        let raised = energies.windows(2).filter(|pair| pair[1] > pair[0]).count();
        assert!(raised > 10, "the energy falls by itself: {raised}");
        for (k, &energy) in energies.iter().enumerate().skip(MEMORY) {
            let last = &energies[k - MEMORY..k];
            let bar = last.iter().copied().fold(f64::MIN, f64::max);
            assert!(energy <= bar + 1e-12 * bar.abs(), "iterate {k}");
        }
        // the first step is plain, and so is one that was refused
        assert!(kinds[1..].contains('g'), "no secant step was refused");
    }

    #[test]
    fn step_of_a_linear_map_is_that_of_barzilai_and_borwein() {
        let problem = springs(6);
        let mut iterates: Vec<Vec<f64>> = Vec::new();
        let mut keep = |iterate: &Iterate<'_>| {
            iterates.push(iterate.lambda.to_vec());
            match iterates.len() {
                4 => ControlFlow::Break(()),
                _ => ControlFlow::Continue(()),
            }
        };
        let start = Multipliers {
            lambda: vec![1.0; 6],
            alpha: Vec::new(),
        };
        Secant::default()
            .solve(&problem, Some(&start), &mut keep)
            .unwrap();
        let gap = |lambda: &[f64]| {
            let multipliers = Multipliers {
                lambda: lambda.to_vec(),
                alpha: Vec::new(),
            };
            problem.gap(&multipliers)
        };
        for three in iterates.windows(3) {
            assert!(three.iter().flatten().all(|force| *force > 0.0), "a kink");
            let (then, now) = (gap(&three[0]), gap(&three[1]));
            let changes: Vec<f64> = now.iter().zip(&then).map(|(a, b)| a - b).collect();
            let moves = three[1].iter().zip(&three[0]).map(|(a, b)| a - b);
            let along: f64 = moves.zip(&changes).map(|(a, b)| a * b).sum();
            let beta = along / dot(&changes, &changes);
            for i in 0..6 {
                let expected = three[1][i] - beta * now[i];
                assert!((three[2][i] - expected).abs() < 1e-12 * expected.abs());
            }
        }
    }

    /// Steps between two pairs of forces and images, on the compliances 1 and 2 with overlaps 1 and 3.
    fn between(problem: &DualProblem, check: impl Fn(&mut SecantSteps<'_>)) {
        let setup = Setup::new(problem).unwrap();
        let (projection, at) = Projection::start(&setup, None).unwrap();
        let pair = |lambda: [f64; 2], image: [f64; 2]| Pair {
            at: Forces {
                lambda: lambda.to_vec(),
                ..at.clone()
            },
            image: image.to_vec(),
        };
        check(&mut SecantSteps {
            setup: &setup,
            projection,
            step: FixedStep::new(Some(0.25), || 1.0),
            then: pair([0.0, 1.0], [2.0, 4.0]),
            now: pair([3.0, 0.5], [4.0, 1.5]),
            energies: vec![-1.0, -7.0],
            kind: 's',
        });
    }

    fn two_springs() -> DualProblem {
        let f = Mat::from_fn(2, 2, |i, j| if i == j { 1.0 + i as f64 } else { 0.0 });
        DualProblem::new(
            Compliance::Dense(f),
            vec![1.0, 3.0],
            AdmissibleSet::new(vec![Block::Unilateral; 2]),
            Balance::none(2),
        )
        .unwrap()
    }

    #[test]
    fn energy_bar_and_secant_are_those_of_two_springs() {
        between(&two_springs(), |steps| {
            // 1/2 (9 + 2 · 0.25) − (3 + 1.5)
            let (energy, rounding) = steps.energy();
            assert_eq!(energy, 4.75 - 4.5);
            assert!((rounding - 1e-14 * (4.75 + 4.5)).abs() < 1e-28);
            assert_eq!(steps.now.at.product, [3.0, 1.0]);
            // δ = (2, 3) before
            assert!((steps.bar() - (-1.0 - 1e-4 * 13.0 / 0.25)).abs() < 1e-15);
            // δ = (1, 1) now: changes (−1, −2), images moved by (2, −2.5)
            assert!((steps.secant() - 3.0 / 5.0).abs() < 1e-15);
            // one energy: no secant yet
            steps.energies.truncate(1);
            assert_eq!(steps.secant(), 0.0);
            // δ stands still
            steps.energies.push(0.0);
            steps.now = steps.then.clone();
            assert_eq!(steps.secant(), 0.0);
        });
    }

    #[test]
    fn secant_step_above_the_bar_is_refused_for_the_plain_one() {
        between(&two_springs(), |steps| {
            // energy 0.25 is above the bar −1.0052
            steps.evaluate();
            assert_eq!(
                (steps.kind, &steps.now.at.lambda[..]),
                ('g', &[2.0, 4.0][..])
            );
            // 1/2 (4 + 32) − (2 + 12)
            assert_eq!(steps.energies, [4.0, -1.0, -7.0]);
        });
        between(&two_springs(), |steps| {
            steps.energies = vec![0.25 + 52e-4 - 1e-12; 10];
            steps.evaluate();
            assert_eq!(steps.kind, 'g');
        });
        between(&two_springs(), |steps| {
            steps.energies = vec![-5.0, 0.25 + 52e-4 + 1e-12];
            steps.energies.resize(MEMORY, -6.0);
            steps.evaluate();
            assert_eq!(
                (steps.kind, &steps.now.at.lambda[..]),
                ('s', &[3.0, 0.5][..])
            );
            // the oldest one is forgotten
            assert_eq!(steps.energies.len(), MEMORY);
            assert_eq!(steps.energies[..2], [0.25, -5.0]);
            // λ − ρ(Fλ − d) = (3 − 0.25 · 2, 0.5 + 0.25 · 2)
            assert_eq!(steps.now.image, [2.5, 1.0]);
        });
    }
}
