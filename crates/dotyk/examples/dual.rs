//! The dual problem of a model, taken out and brought back: F, d, G and e for a method that knows nothing of bodies, and from
//! its forces to displacements, stresses and a certificate. The bodies are factored once for all of it.
//!
//! The method here is the oldest one: forces are changed one after the other until every gap is closed or its force zero
//! (Gauss and Seidel, projected). The body is held, so that nothing floats and Gλ = e is empty.
//!
//! `cargo run --release --example dual`

use dotyk::dual::{Compliance, Multipliers};
use dotyk::prelude::*;

/// A block of steel pressed onto a floor that falls away to both sides: how far it touches is not known.
pub fn model() -> Result<Model<2>, MeshError> {
    let block = Rectangle {
        from: [-1.0, 0.0],
        to: [1.0, 1.0],
        cells: [40, 20],
        cell: CellKind::Quad4,
        diagonals: Diagonals::default(),
    };
    let steel = Elastic {
        young: 210e9,
        poisson: 0.3,
    };
    let mut model = Model::new();
    let block = model.body("block", block.build()?, steel);
    model.fix(block, "top", [Some(0.0), None]).obstacle(
        (block, "bottom"),
        Field::function("floor", |p, _| 1e-5 * p[0] * p[0]),
    );
    model.bodies[0].supports[0].components[1] = Some(Field::constant(-1e-5));
    Ok(model)
}

/// λ ≥ 0 with Fλ − d ≥ 0 and λ·(Fλ − d) = 0, one force after the other.
pub fn gauss_seidel(f: &dyn Fn(usize, usize) -> f64, d: &[f64], sweeps: usize) -> Vec<f64> {
    let mut lambda = vec![0.0; d.len()];
    for _ in 0..sweeps {
        for i in 0..d.len() {
            let gap: f64 = (0..d.len()).map(|j| f(i, j) * lambda[j]).sum::<f64>() - d[i];
            lambda[i] = f64::max(0.0, lambda[i] - gap / f(i, i));
        }
    }
    lambda
}

/// Solves the model with forces found outside of it.
pub fn solve(model: &Model<2>) -> Result<Solution<2>, Error<2>> {
    let dual = model.dual(1.0)?;
    let problem = dual.problem();
    let Compliance::Dense(f) = &problem.compliance else {
        unreachable!("41 unknowns are assembled");
    };
    assert_eq!((problem.len(), problem.balance.load().len()), (41, 0));
    let rough = Multipliers {
        lambda: gauss_seidel(&|i, j| f[(i, j)], &problem.shift, 10),
        alpha: Vec::new(),
    };
    // ten sweeps are not enough, and nobody takes them for an answer
    assert!(!dual.certify(&rough)?.holds());
    assert!(matches!(
        dual.recover(&rough),
        Err(Error::NotConverged { .. })
    ));
    let forces = Multipliers {
        lambda: gauss_seidel(&|i, j| f[(i, j)], &problem.shift, 3000),
        alpha: Vec::new(),
    };
    let solution = dual.recover(&forces)?;
    // each force is that of the node that its row names
    for (unknown, force) in dual.unknowns().iter().zip(&forces.lambda) {
        let node = solution.contacts[unknown.contact].nodes[unknown.place];
        assert!((node.pressure - force / unknown.weight).abs() < 1e-6);
    }
    let touching = solution.contacts[0]
        .nodes
        .iter()
        .filter(|n| n.status == Status::Closed);
    assert!((3..39).contains(&touching.count()));
    Ok(solution)
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let solution = solve(&model()?)?;
    println!("{}", solution.certificate);
    for node in &solution.contacts[0].nodes {
        println!(
            "{:>6.2} {:>13.5e} {:>13.5e}",
            node.point[0], node.pressure, node.gap
        );
    }
    Ok(())
}
