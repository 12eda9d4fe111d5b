//! Newton's steps do not grow with the number of contact nodes, whatever the shape of the cells: a tunnel whose sides are
//! free, so that the lining loses contact at the springline, with many nodes around and few cells through the depth. There a
//! plain active set moves the edge of the contact by one node in each step.

use dotyk::case::Case;
use dotyk::dual::{Compliance, DualProblem};
use dotyk::linalg::Mat;
use dotyk::solve::{ContactSolver, Newton, Outcome};
use std::ops::ControlFlow;
use std::path::Path;

/// `n` intervals on the half circle.
fn tunnel(n: usize, friction: &str, dense_limit: usize) -> DualProblem {
    let text = format!(
        "analysis = \"plane-strain\"\n\
         [[body]]\nname = \"rock\"\n\
         mesh = {{ tunnel_rock = {{ radius = 15.0, half_width = 40.0, half_height = 40.0, cells = [{n}, 12] }} }}\n\
         material = {{ young = 2000.0, poisson = 0.25 }}\n\
         fix = [{{ side = \"axis\", x = 0.0 }}, {{ side = \"bottom\", y = 0.0 }}]\n\
         load = [{{ side = \"top\", traction = [0.0, -50.0] }}]\n\
         [[body]]\nname = \"lining\"\n\
         mesh = {{ ring = {{ inner = 12.0, outer = 15.0, from = -90, to = 90, cells = [{n}, 5] }} }}\n\
         material = {{ young = 2.1e6, poisson = 0.15 }}\n\
         fix = [{{ side = \"start\", x = 0.0 }}, {{ side = \"end\", x = 0.0 }}]\n\
         [[contact]]\nname = \"gamma\"\nnonmortar = \"rock.hole\"\nmortar = \"lining.outer\"\n{friction}\n"
    );
    let case = Case::<2>::from_str(&text, "case.toml", Path::new(".")).unwrap();
    case.model.dual_problem(dense_limit).unwrap()
}

fn solve(problem: &DualProblem) -> Outcome {
    let outcome = Newton::default().solve(problem, None, &mut |_| ControlFlow::Continue(()));
    let outcome = outcome.unwrap();
    assert!(problem.certify(&outcome.multipliers, 1e-8).holds());
    outcome
}

#[test]
fn steps_do_not_grow_with_the_number_of_nodes() {
    for friction in ["", "friction = 0.3"] {
        for n in [75, 150, 300, 600] {
            let outcome = solve(&tunnel(n, friction, usize::MAX));
            let open = outcome.multipliers.lambda.iter().filter(|l| **l == 0.0);
            assert!(open.count() > n / 4, "the contact opens");
            let steps = outcome.iterations;
            println!("{n} nodes, {friction:?}: {steps} steps");
            assert!(steps <= 9, "{n} nodes, {friction:?}: {steps} steps");
        }
    }
}

#[test]
fn a_compliance_that_is_applied_takes_as_few_steps_and_gives_the_same_forces() {
    for friction in ["", "friction = 0.3"] {
        let dense = solve(&tunnel(600, friction, usize::MAX));
        let applied = solve(&tunnel(600, friction, 0));
        let (steps, products) = (applied.iterations, applied.products);
        println!("{friction:?}: {steps} steps, {products} products");
        assert!(steps <= 9, "{friction:?}: {steps} steps");
        assert!(products <= 500, "{friction:?}: {products} products");
        let largest = |forces: &[f64]| forces.iter().fold(0.0, |s: f64, l| s.max(l.abs()));
        let (a, b) = (&dense.multipliers.lambda, &applied.multipliers.lambda);
        let off: Vec<f64> = a.iter().zip(b).map(|(a, b)| a - b).collect();
        assert!(largest(&off) <= 1e-7 * largest(a), "{:e}", largest(&off));
    }
}

#[test]
fn products_with_many_vectors_at_once_are_those_with_each_and_those_of_assembled_forces() {
    let mut problem = tunnel(75, "friction = 0.3", 0);
    let m = problem.len();
    let product = |problem: &DualProblem, x: &[f64]| {
        let mut y = vec![0.0; m];
        problem.compliance.apply(x, &mut y);
        y
    };
    let close = |a: &[f64], b: &[f64]| {
        let largest = a.iter().fold(0.0, |s: f64, v| s.max(v.abs()));
        for (a, b) in a.iter().zip(b) {
            assert!((a - b).abs() <= 1e-12 * largest, "{a:e}, {b:e}");
        }
    };
    // more columns than are taken at a time, and not a multiple of them
    let x = Mat::from_fn(m, 37, |i, j| ((i * 31 + j * 17) as f64).sin());
    let Compliance::Operator { apply, .. } = &problem.compliance else {
        panic!("F is assembled");
    };
    let together = apply.apply_many(&x);
    let alone: Vec<Vec<f64>> = (0..x.ncols())
        .map(|j| product(&problem, x.col_as_slice(j)))
        .collect();
    assert!(!problem.assemble(m - 1), "it has more unknowns than that");
    assert!(problem.assemble(m));
    assert!(matches!(problem.compliance, Compliance::Dense(_)));
    for (j, alone) in alone.iter().enumerate() {
        close(alone, together.col_as_slice(j));
        close(alone, &product(&problem, x.col_as_slice(j)));
    }
}
