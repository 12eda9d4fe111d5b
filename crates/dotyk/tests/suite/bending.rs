//! Bending: what each kind of cell makes of a thin plate, incompatible modes, and the warning where linear cells bend.
//!
//! The plate is 10 × 10 × 0.5, held at one side and pulled down evenly along the opposite one; cells are 1 × 1 across the
//! plate. The reference is the same plate of hex27, 20 × 20 × 2.

use dotyk::geometry::{Field, Point, distance};
use dotyk::mesh::{CellKind, Cuboid, Diagonals, Mesh, Rectangle};
use dotyk::model::{
    Analysis, BodyId, Components, Elastic, Formulation, Load, Model, Place, Solution, Support,
};

const STEEL: Elastic = Elastic {
    young: 200e3,
    poisson: 0.3,
};

const SIZE: Point<3> = [10.0, 10.0, 0.5];

fn plate(cell: CellKind, cells: [usize; 3], formulation: Formulation) -> Solution<3> {
    let cuboid = Cuboid {
        from: [0.0; 3],
        to: SIZE,
        cells,
        cell,
    };
    let mut model = Model::new();
    let body = model.body("plate", cuboid.build().unwrap(), STEEL);
    model.bodies[0].formulation = formulation;
    model.fix(body, "left", [Some(0.0); 3]);
    let force = [0.0, 0.0, -10.0].map(Field::constant);
    let side = "right".to_string();
    model.load(body, Load::Resultant { side, force });
    model.solve().unwrap()
}

/// Work of the load: its force times the mean deflection of the loaded side, here of its nodes alike.
fn deflection(solution: &Solution<3>, cell: CellKind, cells: [usize; 3]) -> f64 {
    let cuboid = Cuboid {
        from: [0.0; 3],
        to: SIZE,
        cells,
        cell,
    };
    let mesh = cuboid.build().unwrap();
    let corner = |n: &u32| {
        let [x, y, z] = mesh.points()[*n as usize];
        x == SIZE[0] && (y == 0.0 || y == SIZE[1] || y == 0.5 * SIZE[1]) && z == SIZE[2]
    };
    let nodes = mesh.side_nodes("right").unwrap();
    let values: Vec<f64> = nodes
        .iter()
        .filter(|n| corner(n))
        .map(|&n| -solution.bodies[0].displacement[n as usize][2])
        .collect();
    assert_eq!(values.len(), 3);
    values.iter().sum::<f64>() / 3.0
}

fn warned(solution: &Solution<3>) -> bool {
    solution.warnings.iter().any(|w| w.contains("bends"))
}

/// Deflection over the reference, as the table at [`Formulation`] tells it.
#[test]
fn a_thin_plate_bends_as_the_documentation_says() {
    let fine = [20, 20, 2];
    let plain = Formulation::Displacement;
    let reference = plate(CellKind::Hex27, fine, plain);
    let exact = deflection(&reference, CellKind::Hex27, fine);
    println!("reference {exact:.6e}");
    let enhanced = Formulation::Enhanced;
    let table: [(CellKind, Formulation, [f64; 3]); 8] = [
        (CellKind::Tet4, plain, [0.13, 0.18, 0.20]),
        (CellKind::Prism6, plain, [0.40, 0.43, 0.43]),
        (CellKind::Hex8, plain, [0.38, 0.40, 0.40]),
        (CellKind::Hex8, enhanced, [1.00, 0.99, 0.98]),
        (CellKind::Tet10, plain, [0.99, 0.99, 0.99]),
        (CellKind::Hex20, plain, [0.99, 0.99, 0.99]),
        (CellKind::Hex27, plain, [1.00, 1.00, 1.00]),
        (CellKind::Prism15, plain, [0.99, 0.99, 0.99]),
    ];
    for (cell, formulation, told) in table {
        for (through, told) in [1, 2, 4].into_iter().zip(told) {
            let cells = [10, 10, through];
            let solution = plate(cell, cells, formulation);
            let share = deflection(&solution, cell, cells) / exact;
            println!("{:<8} {formulation:?} {through}: {share:.4}", cell.name());
            assert!(
                (share - told).abs() < 0.01,
                "{cell:?} {formulation:?} {through}: {share}"
            );
            let warning = solution.warnings.iter().find(|w| w.contains("bends"));
            assert_eq!(warning.is_some(), share < 0.9, "{cell:?} {share}");
            if cell == CellKind::Hex8 && formulation == plain {
                // what it says is missing is what is missing
                let near = [-1.0, 0.0, 1.0].map(|d| format!("{:.0} %", 100.0 * (1.0 - share) + d));
                let warning = warning.map_or("", String::as_str);
                assert!(
                    near.iter().any(|p| warning.contains(p)),
                    "{near:?}: {warning}"
                );
            }
        }
    }
}

#[test]
fn a_body_that_keeps_its_volume_is_told_of_that_and_not_of_bending() {
    let cuboid = Cuboid {
        from: [0.0; 3],
        to: [2.0; 3],
        cells: [4; 3],
        cell: CellKind::Hex8,
    };
    let squeezed = |formulation| {
        let rubber = Elastic {
            young: 1000.0,
            poisson: 0.499,
        };
        let mut model = Model::new();
        let body = model.body("pad", cuboid.build().unwrap(), rubber);
        model.bodies[0].formulation = formulation;
        model.fix(body, "bottom", [Some(0.0); 3]);
        model.press(body, "top", 1.0);
        model.solve().unwrap().warnings
    };
    let [warning] = &squeezed(Formulation::Displacement)[..] else {
        panic!("one warning");
    };
    assert!(
        warning.contains("nearly incompressible (ν = 0.499)") && !warning.contains("bends"),
        "{warning}"
    );
    assert_eq!(squeezed(Formulation::Enhanced), [""; 0]);
}

/// A box whose inner nodes are moved.
fn distorted(cells: [usize; 3]) -> Mesh<3> {
    let cuboid = Cuboid {
        from: [0.0; 3],
        to: [1.0, 1.2, 0.8],
        cells,
        cell: CellKind::Hex8,
    };
    let place = |[x, y, z]: Point<3>| {
        let inside = x * (1.0 - x) * y * (1.2 - y) * z * (0.8 - z);
        [x + 3.0 * inside, y - 2.0 * inside, z + 1.5 * inside]
    };
    cuboid.build().unwrap().map_points(place).unwrap()
}

#[test]
fn distorted_enhanced_cells_have_a_constant_stress() {
    let h = [
        [2e-3, -1e-3, 4e-4],
        [7e-4, -3e-3, 1e-3],
        [-5e-4, 6e-4, 1e-3],
    ];
    let linear = move |x: Point<3>| h.map(|row: Point<3>| (0..3).map(|j| row[j] * x[j]).sum());
    let mut model = Model::new();
    model.body("body", distorted([3, 3, 3]), STEEL);
    model.bodies[0].formulation = Formulation::Enhanced;
    for side in ["left", "right", "front", "back", "bottom", "top"] {
        let component = |i: usize| Field::function("linear", move |x, _| linear(x)[i]);
        model.bodies[0].supports.push(Support {
            place: Place::Side(side.to_string()),
            components: [0, 1, 2].map(|i| Some(component(i))),
            normal: None,
            active: Default::default(),
        });
    }
    let solution = model.solve().unwrap();
    let body = &solution.bodies[0];
    for (&x, &u) in model.bodies[0].mesh.points().iter().zip(&body.displacement) {
        assert!(distance(u, linear(x)) < 1e-14);
    }
    let mu = STEEL.young / (2.0 * (1.0 + STEEL.poisson));
    let lambda = 2.0 * mu * STEEL.poisson / (1.0 - 2.0 * STEEL.poisson);
    let trace = h[0][0] + h[1][1] + h[2][2];
    let xx = lambda * trace + 2.0 * mu * h[0][0];
    let yz = mu * (h[1][2] + h[2][1]);
    for s in &body.stress {
        assert!(
            (s[0] - xx).abs() < 1e-9 && (s[4] - yz).abs() < 1e-9,
            "{s:?}"
        );
    }
}

/// A body of cells that bend with an initial strain that is the same in all directions, and nothing else.
fn warmed<const D: usize>(mesh: Mesh<D>, strain: Field) -> (Model<D>, BodyId) {
    let mut model = Model::new();
    let body = model.body("body", mesh, STEEL);
    model.bodies[0].formulation = Formulation::Enhanced;
    model.bodies[0].initial.strain = Some(Components::isotropic(strain));
    (model, body)
}

/// The body has these displacements, of which the largest is 8e-3, and no stress, beside some 600 in cells that are not free.
fn moves_freely<const D: usize>(
    model: &Model<D>,
    solution: &Solution<D>,
    expected: impl Fn(Point<D>) -> Point<D>,
) {
    let body = &solution.bodies[0];
    for (&x, &u) in model.bodies[0].mesh.points().iter().zip(&body.displacement) {
        assert!(distance(u, expected(x)) < 1e-14, "{x:?} {u:?}");
    }
    let most = body.von_mises.iter().fold(0.0, |a: f64, &b| a.max(b));
    assert!(most < 1e-8, "{most}");
}

/// A strain that is linear in the place, the same in all directions, bends a free body into a sphere without stress.
#[test]
fn a_free_body_bends_without_stress_under_a_linear_temperature() {
    let alpha = 1e-3;
    let rectangle = Rectangle {
        from: [0.0, 0.0],
        to: [4.0, 1.0],
        cells: [8, 2],
        cell: CellKind::Quad4,
        diagonals: Diagonals::default(),
    };
    let strain = Field::function("1e-3*y", move |x, _| alpha * x[1]);
    let (mut model, body) = warmed(rectangle.build().unwrap(), strain);
    model.analysis = Analysis::PlaneStress;
    model.pin(body, [0.0, 0.0], [Some(0.0), Some(0.0)]);
    model.pin(body, [0.0, 1.0], [Some(0.0), None]);
    moves_freely(&model, &model.solve().unwrap(), |[x, y]| {
        [alpha * x * y, 0.5 * alpha * (y * y - x * x)]
    });
    let cuboid = Cuboid {
        from: [0.0; 3],
        to: [4.0, 1.0, 1.0],
        cells: [4, 1, 2],
        cell: CellKind::Hex8,
    };
    let strain = Field::function("1e-3*z", move |x, _| alpha * x[2]);
    let (mut model, body) = warmed(cuboid.build().unwrap(), strain);
    model.pin(body, [0.0; 3], [Some(0.0); 3]);
    model.pin(body, [0.0, 0.0, 1.0], [Some(0.0), Some(0.0), None]);
    model.pin(body, [0.0, 1.0, 0.0], [Some(0.0), None, None]);
    moves_freely(&model, &model.solve().unwrap(), |[x, y, z]| {
        let down = 0.5 * alpha * (z * z - x * x - y * y);
        [alpha * x * z, alpha * y * z, down]
    });
}

#[test]
fn distorted_cells_that_bend_expand_without_stress() {
    let alpha = 1e-3;
    let (mut model, body) = warmed(distorted([3, 3, 3]), Field::constant(alpha));
    for side in ["left", "front", "bottom"] {
        let axis = ["left", "front", "bottom"].iter().position(|s| *s == side);
        let held = std::array::from_fn(|i| (Some(i) == axis).then_some(0.0));
        model.fix(body, side, held);
    }
    moves_freely(&model, &model.solve().unwrap(), |x| x.map(|c| alpha * c));
}

/// Pure bending of a beam of square cells: exact with incompatible modes, in space and in the plane.
#[test]
fn enhanced_cells_are_exact_in_pure_bending() {
    // u = (−κ x z, 0, κ x²/2), σxx = −Eκ z, ν = 0: one cell through the thickness, four times as long
    let cork = Elastic {
        young: 1000.0,
        poisson: 0.0,
    };
    let kappa = 1e-3;
    let cuboid = Cuboid {
        from: [0.0, 0.0, -0.5],
        to: [8.0, 1.0, 0.5],
        cells: [2, 1, 1],
        cell: CellKind::Hex8,
    };
    for (formulation, share) in [
        (Formulation::Enhanced, 1.0),
        (Formulation::Displacement, 1.0 / 9.0),
    ] {
        let mut model = Model::new();
        let body = model.body("beam", cuboid.build().unwrap(), cork);
        model.bodies[0].formulation = formulation;
        model.fix(body, "left", [Some(0.0), Some(0.0), None]);
        model.pin(body, [0.0, 0.0, -0.5], [None, None, Some(0.0)]);
        model.pin(body, [0.0, 1.0, -0.5], [None, None, Some(0.0)]);
        let bend = Field::function("bend", move |x, _| -1000.0 * kappa * x[2]);
        let zero = || Field::constant(0.0);
        let side = "right".to_string();
        let traction = [bend, zero(), zero()];
        model.load(body, Load::Traction { side, traction });
        let solution = model.solve().unwrap();
        let points = model.bodies[0].mesh.points().iter();
        for (x, u) in points.zip(&solution.bodies[0].displacement) {
            // 1 + ½(l/h)² times stiffer with l/h = 4
            let along = -share * kappa * x[0] * x[2];
            assert!(
                (u[0] - along).abs() < 1e-12,
                "{formulation:?} {x:?} {u:?} {along}"
            );
        }
        if formulation == Formulation::Enhanced {
            for s in &solution.bodies[0].stress {
                assert!(
                    (s[0].abs() - 0.5).abs() < 1e-10 && s[5].abs() < 1e-10,
                    "{s:?}"
                );
            }
            assert!(!warned(&solution));
        } else {
            assert!(warned(&solution), "{:?}", solution.warnings);
        }
    }
    let mut plane = Model::new();
    let rectangle = Rectangle {
        from: [0.0, -0.5],
        to: [8.0, 0.5],
        cells: [2, 1],
        cell: CellKind::Quad4,
        diagonals: Diagonals::default(),
    };
    let body = plane.body("beam", rectangle.build().unwrap(), cork);
    plane.bodies[0].formulation = Formulation::Enhanced;
    plane.fix(body, "left", [Some(0.0), None]);
    plane.pin(body, [0.0, -0.5], [None, Some(0.0)]);
    let bend = Field::function("bend", move |x, _| -1000.0 * kappa * x[1]);
    let traction = [bend, Field::constant(0.0)];
    let side = "right".to_string();
    plane.load(body, Load::Traction { side, traction });
    let solution = plane.solve().unwrap();
    let points = plane.bodies[0].mesh.points().iter();
    for (x, u) in points.zip(&solution.bodies[0].displacement) {
        assert!((u[0] + kappa * x[0] * x[1]).abs() < 1e-12);
    }
}

#[test]
fn enhanced_cells_need_cells_that_can_be_enhanced() {
    let cuboid = Cuboid {
        from: [0.0; 3],
        to: [1.0; 3],
        cells: [1; 3],
        cell: CellKind::Tet10,
    };
    let mut model = Model::new();
    let body = model.body("body", cuboid.build().unwrap(), STEEL);
    model.fix(body, "bottom", [Some(0.0); 3]);
    model.bodies[0].formulation = Formulation::Enhanced;
    let said = model.solve().unwrap_err().to_string();
    assert!(
        said.contains("body") && said.contains("quad4 and hex8"),
        "{said}"
    );
}
