//! Preparation, counting and judgement that all solvers share.

use std::cell::{Cell, RefCell};
use std::rc::Rc;

use crate::dual::{
    AdmissibleSet, Balance, Component, DualProblem, Feasibility, Multipliers, Projector, Violations,
};
use crate::solve::outcome::{Outcome, SolveError};

/// An eigenvalue bound below this part of the largest compliance is rounding of products.
const NO_BOUND: f64 = 1e-13;

/// Checked data, the balance in orthonormal modes, the kind of each force.
pub(crate) struct Setup<'a> {
    pub problem: &'a DualProblem,
    /// d, (m,): that of the problem, or its remainder beside forces whose increments are sought.
    pub shift: Vec<f64>,
    /// Λ: that of the problem, or with other friction blocks in the same places.
    pub admissible: AdmissibleSet,
    pub balance: Balance,
    pub components: Vec<Component>,
    /// Products with F so far, those with other admissible sets included.
    products: Rc<Cell<usize>>,
    /// The last forces of the glue.
    glue: Rc<RefCell<Vec<f64>>>,
}

impl<'a> Setup<'a> {
    /// Checks the problem, refuses loads that no force can carry.
    pub fn new(problem: &'a DualProblem) -> Result<Self, SolveError> {
        problem.check()?;
        let mut setup = Self::unchecked(problem);
        match problem.feasibility() {
            Feasibility::Infeasible { direction, factor } => {
                Err(SolveError::Infeasible { direction, factor })
            }
            Feasibility::Feasible { load } => {
                setup.balance.set_load(load);
                Ok(setup)
            }
        }
    }

    /// The same for a problem that was checked before.
    pub fn unchecked(problem: &'a DualProblem) -> Self {
        Self {
            problem,
            shift: problem.shift.clone(),
            admissible: problem.admissible.clone(),
            balance: problem.balance.clone(),
            components: problem.admissible.components(),
            products: Rc::default(),
            glue: Rc::default(),
        }
    }

    /// The same problem with the admissible set `admissible`, which must have the same length.
    pub fn with_admissible(&self, admissible: AdmissibleSet) -> Self {
        Self {
            problem: self.problem,
            shift: self.shift.clone(),
            components: admissible.components(),
            admissible,
            balance: self.balance.clone(),
            products: Rc::clone(&self.products),
            glue: Rc::clone(&self.glue),
        }
    }

    /// Number m of contact forces.
    pub fn len(&self) -> usize {
        self.components.len()
    }

    /// Number k of rigid modes that contact controls.
    pub fn modes(&self) -> usize {
        self.balance.rank()
    }

    /// Force `i` is ≥ 0.
    pub fn bounded(&self, i: usize) -> bool {
        self.components[i] == Component::Normal
    }

    /// `bound`, an eigenvalue bound, or a number of its order where it is rounding: then the balance alone determines
    /// the forces, and any step is right that is comparable with them.
    pub fn usable_bound(&self, bound: f64) -> f64 {
        let diagonal = self.problem.compliance.diagonal();
        let diagonal = diagonal.map_or(0.0, |d| d.into_iter().fold(0.0, f64::max));
        if self.len() > self.modes() && bound > NO_BOUND * diagonal {
            return bound;
        }
        let or_one = |scale: f64| if scale > 0.0 { scale } else { 1.0 };
        or_one(self.problem.scales.length) / or_one(self.problem.scales.force)
    }

    /// The scale of forces: the largest of λ (m,) and of the load.
    pub fn largest_force(&self, lambda: &[f64]) -> f64 {
        largest(self.problem.scales.force, lambda)
    }

    /// Workspace for projections.
    pub fn projector(&self) -> Projector<'_> {
        Projector::new(&self.admissible, &self.balance)
    }

    /// Forces to begin with: those of the guess, or zero; not yet admissible or balanced.
    pub fn start(&self, guess: Option<&Multipliers>) -> Result<Vec<f64>, SolveError> {
        let Some(guess) = guess else {
            return Ok(vec![0.0; self.len()]);
        };
        let expected = (self.len(), self.balance.load().len());
        if (guess.lambda.len(), guess.alpha.len()) != expected {
            return Err(SolveError::Invalid(format!(
                "the starting point has {} contact forces and {} rigid amplitudes, the problem {} and {}",
                guess.lambda.len(),
                guess.alpha.len(),
                expected.0,
                expected.1
            )));
        }
        let mut values = guess.lambda.iter().chain(&guess.alpha);
        if let Some(value) = values.find(|value| !value.is_finite()) {
            return Err(SolveError::Invalid(format!(
                "the starting point holds {value}: it must be finite"
            )));
        }
        Ok(guess.lambda.clone())
    }

    /// y = Fx, counted. Shapes: both (m,).
    pub fn multiply(&self, x: &[f64], y: &mut [f64]) {
        self.problem.compliance.apply(x, y);
        self.count(1);
    }

    /// Counts products with F that were made elsewhere.
    pub fn count(&self, products: usize) {
        self.products.set(self.products() + products);
    }

    /// Products with F so far.
    pub fn products(&self) -> usize {
        self.products.get()
    }

    /// Forces of the glue (g,) to begin with: the last ones, or zero.
    pub fn glue(&self, length: usize) -> Vec<f64> {
        let mut glue = self.glue.borrow().clone();
        glue.resize(length, 0.0);
        glue
    }

    /// Keeps forces of the glue for the next beginning.
    pub fn keep_glue(&self, glue: Vec<f64>) {
        *self.glue.borrow_mut() = glue;
    }

    /// The outcome with these forces.
    pub fn outcome(&self, forces: &Forces) -> Outcome {
        Outcome {
            products: self.products(),
            ..Outcome::new(self.multipliers(&forces.lambda, &forces.alpha), 0)
        }
    }

    /// α from its amplitudes in orthonormal modes.
    pub fn multipliers(&self, lambda: &[f64], alpha: &[f64]) -> Multipliers {
        let mut original = vec![0.0; self.balance.load().len()];
        self.balance.to_original(alpha, &mut original);
        Multipliers {
            lambda: lambda.to_vec(),
            alpha: original,
        }
    }

    /// Workspace of [`Judge::residual`].
    pub fn judge(&self) -> Judge {
        Judge {
            alpha: vec![0.0; self.balance.load().len()],
            gap: vec![0.0; self.len()],
            violations: Violations::default(),
        }
    }
}

/// Forces, amplitudes and the product with F.
#[derive(Debug, Clone)]
pub(crate) struct Forces {
    /// λ, (m,).
    pub lambda: Vec<f64>,
    /// α̂, (k,).
    pub alpha: Vec<f64>,
    /// Fλ, (m,).
    pub product: Vec<f64>,
}

impl Forces {
    /// Zero forces and amplitudes.
    pub fn none(setup: &Setup<'_>) -> Self {
        Self {
            lambda: vec![0.0; setup.len()],
            alpha: vec![0.0; setup.modes()],
            product: vec![0.0; setup.len()],
        }
    }

    /// These forces as a point that a step of some kind led to.
    pub fn at<'a>(&'a self, setup: &'a Setup<'_>, step: char) -> Position<'a> {
        Position {
            forces: self,
            components: &setup.components,
            step,
        }
    }
}

/// The present point of an iteration.
pub(crate) struct Position<'a> {
    pub forces: &'a Forces,
    /// Constraints on λ, (m,).
    pub components: &'a [Component],
    /// Kind of the step that led here, as in `Iterate::step`.
    pub step: char,
}

/// Computes the stopping measure without allocating.
pub(crate) struct Judge {
    alpha: Vec<f64>,
    /// Gap of the last call (m,).
    pub gap: Vec<f64>,
    violations: Violations,
}

impl Judge {
    /// Residual at a point; components called free are not held to λ ≥ 0.
    pub fn residual(&mut self, setup: &Setup<'_>, point: &Position<'_>) -> f64 {
        let (problem, forces) = (setup.problem, point.forces);
        setup.balance.to_original(&forces.alpha, &mut self.alpha);
        problem.gap_from_product(&forces.product, &self.alpha, &mut self.gap);
        self.violations.find(
            problem,
            &setup.admissible,
            (&forces.lambda, &self.alpha),
            &self.gap,
            point.components,
        );
        self.violations.residual()
    }
}

/// The largest of `least` and the sizes of some values.
pub(crate) fn largest(least: f64, values: &[f64]) -> f64 {
    values.iter().fold(least, |s, value| s.max(value.abs()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::dual::{Block, Compliance, Friction};
    use crate::linalg::Mat;
    use crate::solve::tests::{apart, applied, definite, of, times};

    /// Contacts with one mode that moves them alike.
    fn floating(m: usize) -> DualProblem {
        let shift: Vec<f64> = (0..m).map(|i| 0.5 + i as f64).collect();
        let balance = (&[vec![1.0; m]][..], &[4.0][..]);
        of(
            Compliance::Dense(definite(m)),
            &shift,
            vec![Block::Unilateral; m],
            balance,
        )
    }

    #[test]
    fn eigenvalue_bound_is_used_where_it_is_more_than_rounding() {
        let f = Mat::from_fn(2, 2, |i, j| if i == j { [2.0, 4.0][i] } else { 0.0 });
        let blocks = vec![Block::Unilateral; 2];
        let balance = (&[vec![1.0, 1.0]][..], &[5.0][..]);
        let problem = of(Compliance::Dense(f), &[3.0, -10.0], blocks.clone(), balance);
        let setup = Setup::new(&problem).unwrap();
        assert_eq!(setup.usable_bound(0.7), 0.7);
        assert_eq!(setup.usable_bound(4.1e-13), 4.1e-13);
        // else the length by which contacts overlap over the load
        assert_eq!(setup.usable_bound(3.9e-13), 2.0);
        // where the balance alone determines the forces
        let one = of(
            Compliance::Dense(definite(1)),
            &[3.0],
            blocks[..1].to_vec(),
            (&[vec![1.0]], &[6.0]),
        );
        assert_eq!(Setup::new(&one).unwrap().usable_bound(0.7), 0.5);
        // scales that are zero count as one
        let scaleless = of(
            applied(&definite(2), definite(2)),
            &[0.0, 0.0],
            blocks,
            (&[], &[]),
        );
        let setup = Setup::new(&scaleless).unwrap();
        assert_eq!(setup.usable_bound(0.0), 1.0);
        assert_eq!(setup.usable_bound(1e-200), 1e-200);
    }

    #[test]
    fn starting_point_of_another_size_or_not_finite_is_refused_in_words() {
        let problem = floating(3);
        let setup = Setup::new(&problem).unwrap();
        let start =
            |lambda: Vec<f64>, alpha: Vec<f64>| setup.start(Some(&Multipliers { lambda, alpha }));
        assert_eq!(setup.start(None).unwrap(), vec![0.0; 3]);
        let own = vec![-1.0, 2.0, 0.0];
        assert_eq!(start(own.clone(), vec![0.1]).unwrap(), own);
        let refused = |lambda, alpha, words: &str| {
            let error = start(lambda, alpha).unwrap_err().to_string();
            assert!(error.contains(words), "{error}");
        };
        refused(
            vec![0.0; 2],
            vec![0.0],
            "has 2 contact forces and 1 rigid amplitudes, the problem 3 and 1",
        );
        refused(vec![0.0; 3], vec![], "has 3 contact forces and 0 rigid");
        refused(vec![0.0, f64::NAN, 0.0], vec![0.0], "holds NaN");
        refused(vec![0.0; 3], vec![f64::INFINITY], "holds inf");
    }

    #[test]
    fn products_are_counted_together_with_those_of_other_admissible_sets() {
        let block = Friction::Coulomb { coefficient: 0.3 }.block(1);
        let problem = of(
            Compliance::Dense(definite(3)),
            &[1.0, 2.0, 3.0],
            vec![block, Block::Unilateral],
            (&[], &[]),
        );
        let setup = Setup::new(&problem).unwrap();
        let other = setup.with_admissible(setup.admissible.sticking());
        let (x, mut y) = (vec![1.0, -2.0, 0.5], vec![0.0; 3]);
        other.multiply(&x, &mut y);
        assert!(apart(&y, &times(&definite(3), &x)) < 1e-15);
        setup.count(3);
        assert_eq!((setup.products(), other.products()), (4, 4));
        assert_eq!(setup.outcome(&Forces::none(&setup)).products, 4);
        assert_eq!(other.len(), 3);
        let expected = [Component::Normal, Component::Tangent, Component::Normal];
        assert_eq!(setup.components, expected);
        let expected = [Component::Normal, Component::Free, Component::Normal];
        assert_eq!(other.components, expected);
        assert!(setup.bounded(0) && !setup.bounded(1) && !other.bounded(1));
    }

    #[test]
    fn judge_finds_the_gap_of_the_forces_and_their_residual() {
        let problem = floating(3);
        let setup = Setup::new(&problem).unwrap();
        let multipliers = Multipliers {
            lambda: vec![1.0, 0.0, 3.0],
            alpha: vec![0.25],
        };
        let mut forces = Forces::none(&setup);
        forces.lambda.clone_from(&multipliers.lambda);
        setup.multiply(&multipliers.lambda, &mut forces.product);
        setup
            .balance
            .from_original(&multipliers.alpha, &mut forces.alpha);
        let mut judge = setup.judge();
        let residual = judge.residual(&setup, &forces.at(&setup, 'n'));
        let product = times(&definite(3), &multipliers.lambda);
        let gap: Vec<f64> = (0..3)
            .map(|i| product[i] - (0.5 + i as f64) - 0.25)
            .collect();
        assert!(apart(&judge.gap, &gap) < 1e-14);
        assert!((residual - problem.kkt_residual(&multipliers)).abs() < 1e-14);
        let back = setup.multipliers(&forces.lambda, &forces.alpha);
        assert!((back.alpha[0] - 0.25).abs() < 1e-14);
        assert_eq!(back.lambda, multipliers.lambda);
    }

    #[test]
    fn force_is_compared_with_the_load_and_the_largest_force_of_either_sign() {
        let problem = floating(2);
        let setup = Setup::new(&problem).unwrap();
        assert_eq!(setup.largest_force(&[1.0, -3.0]), 4.0);
        assert_eq!(setup.largest_force(&[1.0, -7.0]), 7.0);
        assert_eq!(largest(0.0, &[]), 0.0);
        assert_eq!((setup.len(), setup.modes()), (2, 1));
    }

    #[test]
    fn load_that_no_contact_can_carry_is_refused_before_anything_is_iterated() {
        let problem = of(
            Compliance::Dense(definite(2)),
            &[1.0, 1.0],
            vec![Block::Unilateral; 2],
            (&[vec![1.0, 1.0]], &[-1.0]),
        );
        let refused = Setup::new(&problem).map(|_| ());
        assert!(matches!(refused, Err(SolveError::Infeasible { .. })));
    }
}
