//! What bodies in space take of memory: less where a contact needs one direction of its nodes, and told before it is taken.

use dotyk::dual::Compliance;
use dotyk::geometry::{Field, Point};
use dotyk::mesh::{CellKind, Cuboid};
use dotyk::model::{DENSE_LIMIT, Elastic, Error, Event, Gap, Law, Model, Solution};
use dotyk::solve::{ContactSolver, Newton};
use std::ops::ControlFlow;
use std::sync::atomic::Ordering;

const SOLID: Elastic = Elastic {
    young: 1000.0,
    poisson: 0.3,
};

/// Two blocks that touch in the middle of their sides, turned about x; the upper one has so many cells along its sides.
fn blocks(angle: f64, cells: usize) -> Model<3> {
    let (sin, cos) = if angle == 0.0 {
        (0.0, 1.0)
    } else {
        angle.sin_cos()
    };
    let turned = |[x, y, z]: Point<3>| [x, cos * y - sin * z, sin * y + cos * z];
    let mut model = Model::<3>::new();
    let [below, above] = [("below", 4, 5), ("above", 5, cells)].map(|(name, layers, cells)| {
        let from = if name == "below" { 0.0 } else { 0.8 };
        let cuboid = Cuboid {
            from: [0.0, 0.0, from],
            to: [1.0, 1.0, from + 0.2 * layers as f64],
            cells: [cells, cells, layers],
            cell: CellKind::Hex8,
        };
        model.body(
            name,
            cuboid.build().unwrap().map_points(turned).unwrap(),
            SOLID,
        )
    });
    model.fix(below, "bottom", [Some(0.0); 3]);
    model.fix(above, "top", turned([0.0, 0.0, -0.02]).map(Some));
    let dish = move |x: Point<3>, _: f64| {
        let along = cos * x[1] + sin * x[2];
        0.05 * ((x[0] - 0.5).powi(2) + (along - 0.3).powi(2))
    };
    model.contact((above, "bottom"), (below, "top")).gap =
        Some(Gap::Given(Field::function("a dish", dish)));
    model
}

/// The solution, and bytes of the factors.
fn solved(model: &Model<3>) -> (Solution<3>, u64) {
    let mut bytes = 0;
    let mut watch = |event| {
        if let Event::Factoring(work) = event {
            bytes = work.bytes.load(Ordering::Relaxed);
        }
    };
    let solution = model.solve_steps_with(&mut watch).unwrap().pop().unwrap();
    (solution, bytes)
}

#[test]
fn contact_without_friction_takes_one_dof_of_each_node_to_the_end() {
    // nodes that match and nodes that do not
    for cells in [5, 4] {
        check_turned(cells);
    }
}

fn check_turned(cells: usize) {
    let (straight, less) = solved(&blocks(0.0, cells));
    let (turned, same) = solved(&blocks(0.7, cells));
    assert_eq!(less, same, "{cells} cells");
    let mut tied = blocks(0.7, cells);
    tied.contacts[0].law = Law::Tied;
    tied.contacts[0].gap = Some(Gap::Closed);
    let (_, more) = solved(&tied);
    assert!(less < more, "{less} bytes, {more} tied");
    let [a, b] = [&straight, &turned].map(|s| &s.contacts[0].nodes);
    let largest = a.iter().map(|node| node.pressure).fold(0.0, f64::max);
    assert!(a.iter().any(|node| node.pressure == 0.0));
    assert_eq!(a.len(), b.len());
    for (a, b) in a.iter().zip(b) {
        // the tolerance of the certificate
        let off = (a.pressure - b.pressure).abs() / largest;
        assert!(off < 1e-8, "{off:e} at {:?}", a.point);
    }
}

/// Thin bodies with many contact nodes have cheap products, thick ones with few have dear ones.
#[test]
fn the_less_dear_way_is_taken() {
    for (side, layers, limit, assembled) in [(40, 1, 1000, false), (20, 12, 300, true)] {
        let mut model = Model::<3>::new();
        let block = |from: f64| {
            let cuboid = Cuboid {
                from: [0.0, 0.0, from],
                to: [1.0, 1.0, from + 0.05 * layers as f64],
                cells: [side, side, layers],
                cell: CellKind::Hex8,
            };
            cuboid.build().unwrap()
        };
        let below = model.body("below", block(0.0), SOLID);
        let above = model.body("above", block(0.05 * layers as f64), SOLID);
        model.fix(below, "bottom", [Some(0.0); 3]);
        model.fix(above, "top", [Some(0.0), Some(0.0), Some(-0.01)]);
        model.contact((above, "bottom"), (below, "top"));
        let problem = model.dual_problem(limit).unwrap();
        let dense = matches!(problem.compliance, Compliance::Dense(_));
        assert_eq!(dense, assembled, "{layers} layers");
    }
}

/// A plate of one layer that lies on another one: equally stiff from node to node, softer by a thousand and more under long
/// waves. The compliance is applied alone.
#[test]
fn a_thin_plate_on_a_bed_takes_few_products() {
    let plate = |heights: [f64; 2], cells: usize| {
        let cuboid = Cuboid {
            from: [0.0, 0.0, heights[0]],
            to: [30.0, 30.0, heights[1]],
            cells: [cells, cells, 1],
            cell: CellKind::Hex8,
        };
        cuboid.build().unwrap()
    };
    let mut model = Model::<3>::new();
    let bed = model.body("bed", plate([0.0, 1.0], 30), SOLID);
    let above = model.body("plate", plate([1.0, 2.0], 29), SOLID);
    model.fix(bed, "bottom", [Some(0.0); 3]);
    model.fix(above, "left", [Some(0.0), Some(0.0), None]);
    model.pull(above, "top", [0.0, 0.0, -0.01]);
    model.contact((above, "bottom"), (bed, "top"));
    let [dense, applied] = [DENSE_LIMIT, 0].map(|limit| {
        let problem = model.dual_problem(limit).unwrap();
        let newton = Newton::default();
        let outcome = newton.solve(&problem, None, &mut |_| ControlFlow::Continue(()));
        outcome.unwrap()
    });
    assert!(applied.products < 150, "{}", applied.products);
    let [dense, applied] = [dense, applied].map(|outcome| outcome.multipliers.lambda);
    let largest = dense.iter().fold(0.0, |s: f64, l| s.max(l.abs()));
    for (a, b) in applied.iter().zip(&dense) {
        assert!((a - b).abs() < 1e-6 * largest, "{a} {b}");
    }
}

#[test]
fn a_model_that_does_not_fit_its_memory_is_refused_with_what_it_needs() {
    let mut model = blocks(0.7, 5);
    model.solver.memory = Some(1_000_000);
    let error = model.solve().unwrap_err();
    let message = error.to_string();
    let Error::Memory { needed, bytes, .. } = error else {
        panic!("{message}");
    };
    assert!(message.contains("1 MB are free"), "{message}");
    assert!(
        message.contains("\"above\" of 648 unknowns alone"),
        "{message}"
    );
    assert!(message.contains("coarsen its mesh"), "{message}");
    // two bodies of 4 and 5 layers of cells, and little beside them
    assert!(bytes < needed && needed < 2 * bytes);
    // as much is enough, and the factors are a part of it
    model.solver.memory = Some(needed);
    assert!(solved(&model).1 < needed);
    model.solver.memory = Some(needed - 1);
    assert!(matches!(model.solve(), Err(Error::Memory { .. })));
}
