//! One linear solution of the first body of a model: the least cost of any analysis of its mesh, by the same kernels.

use crate::Failure;
use dotyk::fem::assemble;
use dotyk::linalg::{SymbolicCholesky, expand_to_dofs, fill_reducing_order};
use dotyk::model::Model;
use std::time::Instant;

/// Processor time of this process in seconds, over all processors; 0 if the system does not report it.
pub fn processor_seconds() -> f64 {
    let text = std::fs::read_to_string("/proc/self/stat").unwrap_or_default();
    let fields = text.rsplit(')').next().unwrap_or_default();
    let ticks = fields.split_whitespace().skip(11).take(2);
    ticks.filter_map(|t| t.parse::<f64>().ok()).sum::<f64>() / 100.0
}

/// Assembles, orders, factors and solves.
pub fn solve(model: &Model<3>) -> Result<(), Failure> {
    let begin = processor_seconds();
    let mut clock = Instant::now();
    let mut lap = || {
        let last = std::mem::replace(&mut clock, Instant::now());
        last.elapsed().as_secs_f64()
    };
    let system = assemble(&model.bodies[0], model.analysis, 1.0)?;
    let assembled = lap();
    let keep: Vec<bool> = system.held.iter().map(|held| !held).collect();
    let nodes: Vec<bool> = keep
        .chunks_exact(3)
        .map(|dofs| dofs.contains(&true))
        .collect();
    let order = fill_reducing_order(&system.graph, &nodes, &[]);
    let kept = expand_to_dofs(&order, 3, &keep);
    let analysis = SymbolicCholesky::new(&system.stiffness, &kept, 0)?;
    let ordered = lap();
    let factor = analysis.factor(&system.stiffness)?;
    let factored = lap();
    let mut displacement = system.load.clone();
    factor.solve(&mut displacement);
    let solved = lap();
    println!(
        "one body, one linear solution: {} dofs, {:.1} million entries, {:.1} Gflop, {:.1} s of all processors",
        displacement.len(),
        analysis.stored() as f64 / 1e6,
        analysis.operations() / 1e9,
        processor_seconds() - begin,
    );
    println!(
        "  assemble {assembled:.2}  order {ordered:.2}  factor {factored:.2}  solve {solved:.2}  all {:.2}",
        assembled + ordered + factored + solved
    );
    Ok(())
}
