//! What bodies in space take of memory: less where a contact needs one direction of its nodes, and told before it is taken.

use dotyk::geometry::{Field, Point};
use dotyk::mesh::{CellKind, Cuboid};
use dotyk::model::{Elastic, Error, Event, Gap, Model, Solution};
use std::sync::atomic::Ordering;

const SOLID: Elastic = Elastic {
    young: 1000.0,
    poisson: 0.3,
};

/// Two blocks that touch in the middle of their sides, turned about x.
fn blocks(angle: f64) -> Model<3> {
    let (sin, cos) = if angle == 0.0 {
        (0.0, 1.0)
    } else {
        angle.sin_cos()
    };
    let turned = |[x, y, z]: Point<3>| [x, cos * y - sin * z, sin * y + cos * z];
    let mut model = Model::<3>::new();
    let [below, above] = [("below", 4), ("above", 5)].map(|(name, layers)| {
        let from = if name == "below" { 0.0 } else { 0.8 };
        let cuboid = Cuboid {
            from: [0.0, 0.0, from],
            to: [1.0, 1.0, from + 0.2 * layers as f64],
            cells: [5, 5, layers],
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
fn contact_along_an_axis_takes_one_dof_of_each_node_to_the_end() {
    let (straight, less) = solved(&blocks(0.0));
    let (turned, more) = solved(&blocks(0.7));
    // with whole nodes at the end both have the same factors
    assert!(less < more, "{less} bytes, {more} turned");
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

#[test]
fn a_model_that_does_not_fit_its_memory_is_refused_with_what_it_needs() {
    let mut model = blocks(0.7);
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
