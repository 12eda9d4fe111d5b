//! The smallest complete program: a punch that only contact holds, pressed on a block.
//!
//! Plane strain, forces per unit thickness in N and lengths in m. The punch is guided at its sides and free to sink: a
//! floating body. Nothing is said about the solver; the certificate says what the answer is worth.
//!
//! `cargo run --release --example punch`

use dotyk::prelude::*;

/// A steel block 4 × 1 on a rigid floor, a steel punch 1 × 1 on top of it under 1 MPa.
pub fn model() -> Result<Model<2>, MeshError> {
    let steel = Elastic {
        young: 210e9,
        poisson: 0.3,
    };
    let rectangle = |from, to, cells| Rectangle {
        from,
        to,
        cells,
        cell: CellKind::Quad4,
        diagonals: Diagonals::default(),
    };
    let mut model = Model::new();
    let block = rectangle([0.0, 0.0], [4.0, 1.0], [80, 20]).build()?;
    let block = model.body("block", block, steel);
    let punch = rectangle([1.5, 1.0], [2.5, 2.0], [20, 20]).build()?;
    let punch = model.body("punch", punch, steel);
    model
        .fix(block, "bottom", [Some(0.0), Some(0.0)])
        .fix(punch, "left", [Some(0.0), None])
        .fix(punch, "right", [Some(0.0), None])
        .pull(punch, "top", [0.0, -1e6])
        .contact((punch, "bottom"), (block, "top"));
    Ok(model)
}

/// Solves the model and checks what must hold for any elastic punch.
pub fn solve(model: &Model<2>) -> Result<Solution<2>, Error<2>> {
    let solution = model.solve()?;
    let sole = &solution.contacts[0];
    // The block carries the whole load of 1 MPa over 1 m.
    assert!((sole.resultant[1] - 1e6).abs() < 1e-3);
    // Sharp corners press harder than the middle.
    let pressure = |x: f64| sole.nodes.iter().find(|n| (n.point[0] - x).abs() < 1e-9);
    let [corner, middle] = [1.5, 2.0].map(|x| pressure(x).map_or(f64::NAN, |n| n.pressure));
    assert!(corner > 1.5 * middle);
    assert!(solution.certificate.holds());
    Ok(solution)
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let model = model()?;
    let solution = solve(&model)?;
    println!("{}", solution.certificate);
    let folder = std::path::Path::new("punch-out");
    let folder = dotyk::output::Folder::hold(folder)?;
    let record = dotyk::output::Record::of(&model, std::slice::from_ref(&solution), "punch");
    for file in record.write(&folder)?.files {
        println!("{}", file.display());
    }
    Ok(())
}
