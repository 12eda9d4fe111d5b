//! A contact problem without any mesh: beads on a wire between two walls, as F, d, Λ, G and e, solved by several methods.
//!
//! Each bead slides on the wire and is pulled by its own force; beads touch each other and the walls through springs of
//! compliance c with clearances. A contact force λᵢ closes gap i by c λᵢ; the beads are rigid, so that Gλ = e, the balance of
//! each bead, and nothing else ties them together:
//!
//! ```text
//!   wall |<- gap 0 -> bead 1 <- gap 1 -> bead 2 ... bead n <- gap n ->| wall        F = c I,  d = −clearances
//! ```
//!
//! `cargo run --release --example beads`

use dotyk::dual::{AdmissibleSet, Balance, Block, Compliance, DualProblem};
use dotyk::linalg::Mat;
use dotyk::solve::{Accelerated, ContactSolver, Mprgp, Newton, Secant, SolveError, Uzawa};
use std::ops::ControlFlow;

const COMPLIANCE: f64 = 1e-3;
const CLEARANCE: f64 = 0.01;

/// n beads, the k-th pulled along the wire by the k-th force.
pub fn beads(pulls: &[f64]) -> Result<DualProblem, SolveError> {
    let (n, m) = (pulls.len(), pulls.len() + 1);
    let f = Mat::from_fn(m, m, |i, j| if i == j { COMPLIANCE } else { 0.0 });
    // a bead that moves along the wire opens the gap behind it and closes the one ahead: gap = Fλ − d − Gᵀα
    let modes = Mat::from_fn(n, m, |bead, gap| match gap {
        gap if gap == bead => -1.0,
        gap if gap == bead + 1 => 1.0,
        _ => 0.0,
    });
    Ok(DualProblem::new(
        Compliance::Dense(f),
        vec![-CLEARANCE; m],
        AdmissibleSet::new(vec![Block::Unilateral; m]),
        Balance::new(modes, pulls.to_vec()),
    )?)
}

/// Solves the beads by five methods; returns λ and α of the last.
pub fn solve() -> Result<(Vec<f64>, Vec<f64>), SolveError> {
    // all to the right, but for the third one
    let problem = beads(&[5.0, 3.0, -1.0, 2.0])?;
    let solvers: [&dyn ContactSolver; 5] = [
        &Uzawa::default(),
        &Accelerated::default(),
        &Mprgp::default(),
        &Secant::default(),
        &Newton::default(),
    ];
    let mut last = (Vec::new(), Vec::new());
    for solver in solvers {
        let outcome = solver.solve(&problem, None, &mut |_| ControlFlow::Continue(()))?;
        let certificate = problem.certify(&outcome.multipliers, 1e-8);
        assert!(certificate.holds(), "{}: {certificate}", solver.name());
        let lambda = &outcome.multipliers.lambda;
        // what pulls to the right adds up from contact to contact, and the left wall is free
        let expected = [0.0, 5.0, 8.0, 7.0, 9.0];
        let errors = lambda
            .iter()
            .zip(expected)
            .map(|(found, sum)| (found - sum).abs());
        assert!(
            errors.fold(0.0, f64::max) < 1e-6,
            "{}: {lambda:?}",
            solver.name()
        );
        last = (lambda.clone(), outcome.multipliers.alpha);
    }
    // the last bead closes its clearance and presses its spring together
    let expected = CLEARANCE + COMPLIANCE * 9.0;
    assert!((last.1[3] - expected).abs() < 1e-9, "{:?}", last.1);
    Ok(last)
}

fn main() -> Result<(), SolveError> {
    let (forces, positions) = solve()?;
    println!("forces {forces:.6?}\nmotions {positions:.6?}");
    Ok(())
}
