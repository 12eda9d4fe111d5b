//! A lined tunnel in an infinite rock against its exact solution.
//!
//! A thick ring fills a round hole, slides on it without friction, and both are compressed from afar: 1 vertically, 1/3
//! horizontally. The pressure is nowhere negative, so that the series of Michell (`dotyk::analytic::ring`) solves the
//! contact problem. The model is the half x ≥ 0 out to r = 45, where the exact tractions act; the lining floats along y.
//!
//! `cargo run --release --example ring`

use dotyk::analytic::ring::{Interface, RingInPlate};
use dotyk::analytic::{Material, Plane};
use dotyk::prelude::*;

const EXACT: RingInPlate = RingInPlate {
    inner: 12.0,
    radius: 15.0,
    ring: Material {
        young: 2.1e6,
        poisson: 0.15,
    },
    plate: Material {
        young: 2000.0,
        poisson: 0.25,
    },
    plane: Plane::Strain,
    vertical: 1.0,
    ratio: 1.0 / 3.0,
    interface: Interface::FullSlip,
};

/// Rock and lining with 32 biquadratic cells around, 65 contact nodes.
pub fn model() -> Result<Model<2>, MeshError> {
    let half_ring = |inner, outer, through, ratio| Ring {
        center: [0.0, 0.0],
        inner,
        outer,
        angles: Some([-90.0, 90.0]),
        cells: [32, through],
        ratio,
        grade: 1.0,
        cell: CellKind::Quad9,
        diagonals: Diagonals::default(),
    };
    let elastic = |material: Material| Elastic {
        young: material.young,
        poisson: material.poisson,
    };
    let mut model = Model::new();
    let rock = half_ring(15.0, 45.0, 11, 1.105).build()?;
    let rock = model.body("rock", rock, elastic(EXACT.plate));
    let lining = half_ring(12.0, 15.0, 2, 1.0).build()?;
    let lining = model.body("lining", lining, elastic(EXACT.ring));
    for body in [rock, lining] {
        // The axis of symmetry x = 0.
        model
            .fix(body, "start", [Some(0.0), None])
            .fix(body, "end", [Some(0.0), None]);
    }
    model.pin(rock, [45.0, 0.0], [None, Some(0.0)]);
    let traction = |component: usize| {
        Field::function("traction of the exact solution", move |p, _| {
            let r = p[0].hypot(p[1]);
            EXACT.traction([p[0], p[1]], [p[0] / r, p[1] / r])[component]
        })
    };
    let side = "outer".to_string();
    let traction = [traction(0), traction(1)];
    model.load(rock, Load::Traction { side, traction });
    model.contact((rock, "inner"), (lining, "outer"));
    Ok(model)
}

/// Solves the model; returns the solution and the largest error of the pressure at a node, relative to its largest value.
pub fn solve(model: &Model<2>) -> Result<(Solution<2>, f64), Error<2>> {
    let solution = model.solve()?;
    let angle = |p: Point<2>| p[1].atan2(p[0]);
    let nodes = &solution.contacts[0].nodes;
    let errors = nodes
        .iter()
        .map(|n| (n.pressure - EXACT.pressure(angle(n.point))).abs());
    let largest = EXACT.pressure(std::f64::consts::FRAC_PI_2);
    let error = errors.fold(0.0, f64::max) / largest;
    assert!(error < 5e-3, "{error}");
    Ok((solution, error))
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let (solution, error) = solve(&model()?)?;
    println!("{}", solution.certificate);
    println!("  angle   pressure      exact");
    for node in &solution.contacts[0].nodes {
        let angle = node.point[1].atan2(node.point[0]);
        let exact = EXACT.pressure(angle);
        println!(
            "{:>7.2} {:>10.6} {exact:>10.6}",
            angle.to_degrees(),
            node.pressure
        );
    }
    println!("largest error {:.3} % of the crown pressure", 100.0 * error);
    Ok(())
}
