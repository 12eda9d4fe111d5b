//! A solver of one's own inside a model: the fast projected gradient method, with certificate, result files and report.
//!
//! Whoever implements `ContactSolver` needs two things of a problem: its gap, the gradient of 1/2 λᵀFλ − dᵀλ, and the
//! projection onto the forces that are admissible and balance the loads. What it returns is judged as the answers of all
//! other solvers, from the displacements.
//!
//! Source: A. Beck, M. Teboulle, A fast iterative shrinkage-thresholding algorithm, SIAM J. Imaging Sci. 2 (2009) 183–202.
//!
//! `cargo run --release --example own_solver`

use dotyk::dual::{DualProblem, Multipliers};
use dotyk::prelude::*;
use dotyk::solve::{ContactSolver, Iterate, Observer, Outcome, SolveError};
use std::ops::ControlFlow;

/// Fast projected gradient: a step from an extrapolated point, whose momentum starts anew where it leads uphill.
pub struct Fast {
    /// Relative violation of the optimality conditions at which it stops.
    pub tolerance: f64,
    /// Most iterations.
    pub most: usize,
}

/// The largest eigenvalue of F, by some power iterations, with a margin.
fn stiffest(problem: &DualProblem) -> f64 {
    let mut x: Vec<f64> = (0..problem.len()).map(|i| (1.0 + i as f64).sin()).collect();
    let mut product = x.clone();
    let norm = |v: &[f64]| v.iter().map(|v| v * v).sum::<f64>().sqrt();
    let mut largest = norm(&x);
    x.iter_mut().for_each(|x| *x /= largest);
    for _ in 0..50 {
        problem.compliance.apply(&x, &mut product);
        largest = norm(&product);
        x = product.iter().map(|product| product / largest).collect();
    }
    1.1 * largest
}

impl ContactSolver for Fast {
    fn name(&self) -> &str {
        "fast gradient"
    }

    fn solve(
        &self,
        problem: &DualProblem,
        guess: Option<&Multipliers>,
        observe: Observer<'_>,
    ) -> Result<Outcome, SolveError> {
        let (m, r) = (problem.len(), problem.balance.load().len());
        let step = 1.0 / stiffest(problem);
        let mut lambda = guess.map_or(vec![0.0; m], |guess| guess.lambda.clone());
        let (mut ahead, mut momentum) = (lambda.clone(), 1.0f64);
        let mut tau = vec![0.0; r];
        for iteration in 1..=self.most {
            // the gap without rigid motion: the projection finds that
            let alpha = vec![0.0; r];
            let gradient = problem.gap(&Multipliers {
                lambda: ahead.clone(),
                alpha,
            });
            let trial: Vec<f64> = ahead
                .iter()
                .zip(&gradient)
                .map(|(l, g)| l - step * g)
                .collect();
            let mut next = vec![0.0; m];
            problem.project(&trial, &mut tau, &mut next);
            let moved: Vec<f64> = next.iter().zip(&lambda).map(|(b, a)| b - a).collect();
            let uphill: f64 = gradient.iter().zip(&moved).map(|(g, s)| g * s).sum();
            let larger = match uphill > 0.0 {
                true => 1.0,
                false => 0.5 * (1.0 + (1.0 + 4.0 * momentum * momentum).sqrt()),
            };
            let factor = if larger == 1.0 {
                0.0
            } else {
                (momentum - 1.0) / larger
            };
            momentum = larger;
            ahead = next
                .iter()
                .zip(&moved)
                .map(|(l, s)| l + factor * s)
                .collect();
            lambda = next;
            let alpha = tau.iter().map(|tau| -tau / step).collect();
            let answer = Multipliers {
                lambda: lambda.clone(),
                alpha,
            };
            let residual = problem.kkt_residual(&answer);
            let iterate = Iterate {
                iteration,
                lambda: &lambda,
                residual,
                active: lambda.iter().filter(|force| **force > 0.0).count(),
                step: 'f',
            };
            let stopped = observe(&iterate) == ControlFlow::Break(());
            if residual <= self.tolerance || stopped || iteration == self.most {
                // no better than it is: the certificate tells
                return Ok(Outcome::new(answer, iteration));
            }
        }
        Err(SolveError::Invalid("no iteration is allowed".to_string()))
    }
}

/// A block of rubber on the floor, and a stiff plate on its middle that only contact holds.
pub fn model() -> Result<Model<2>, MeshError> {
    let rectangle = |from, to, cells| Rectangle {
        from,
        to,
        cells,
        cell: CellKind::Quad9,
        diagonals: Diagonals::default(),
    };
    let elastic = |young, poisson| Elastic { young, poisson };
    let mut model = Model::new();
    model.title = "A plate on rubber".to_string();
    let rubber = rectangle([0.0, 0.0], [4.0, 1.0], [24, 6]).build()?;
    let rubber = model.body("rubber", rubber, elastic(5e6, 0.45));
    let plate = rectangle([1.0, 1.0], [3.0, 1.2], [12, 2]).build()?;
    let plate = model.body("plate", plate, elastic(200e6, 0.3));
    model
        .fix(rubber, "bottom", [Some(0.0), Some(0.0)])
        .fix(plate, "left", [Some(0.0), None])
        .pull(plate, "top", [0.0, -2e4])
        .contact((plate, "bottom"), (rubber, "top"));
    Ok(model)
}

/// Solves the model with the solver above, and holds the answer against that of the built-in one.
pub fn solve(model: &Model<2>) -> Result<Solution<2>, Error<2>> {
    let solver = Fast {
        tolerance: 1e-11,
        most: 20_000,
    };
    let solution = model.solve_by(&solver)?; // an answer that the certificate refuses is an error
    assert_eq!(solution.solver.method, "fast gradient");
    let built_in = model.solve()?;
    let pressures = |s: &Solution<2>| -> Vec<f64> {
        s.contacts[0]
            .nodes
            .iter()
            .map(|node| node.pressure)
            .collect()
    };
    let pairs = pressures(&solution).into_iter().zip(pressures(&built_in));
    let error = pairs.fold(0.0, |s: f64, (a, b)| s.max((a - b).abs()));
    assert!(error < 1e-5 * 2e4, "{error}");
    Ok(solution)
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let model = model()?;
    let solution = solve(&model)?;
    println!(
        "{} iterations\n{}",
        solution.solver.iterations, solution.certificate
    );
    let folder = std::path::Path::new("own_solver-out");
    let folder = dotyk::output::Folder::hold(folder)?;
    let record = dotyk::output::Record::of(&model, std::slice::from_ref(&solution), "own_solver");
    for file in record.write(&folder)?.files {
        println!("{}", file.display());
    }
    Ok(())
}
