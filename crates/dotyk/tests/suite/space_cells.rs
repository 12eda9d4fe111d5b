//! Every kind of cell of space: constant stress on distorted and curved meshes, loads on curved sides, moments of bodies.
//!
//! Tolerances are rounding: 1e-12 of the largest value. Rates are in `space.rs`.

use dotyk::geometry::{Field, Point, add_scaled, distance, norm};
use dotyk::mesh::{CellKind, Cuboid, Mesh};
use dotyk::model::{Elastic, Load, Model, Place, Solution, Support};
use proptest::prelude::*;
use std::f64::consts::PI;

const SOFT: Elastic = Elastic {
    young: 1000.0,
    poisson: 0.3,
};

/// A box whose nodes, inside and on its faces, follow a smooth map: quadratic cells are curved, those of a cube have faces
/// that are not plane.
fn curved(cell: CellKind, size: f64) -> Mesh<3> {
    let cuboid = Cuboid {
        from: [0.0; 3],
        to: [1.0, 1.2, 0.9],
        cells: [2, 3, 2],
        cell,
    };
    let bent = |[x, y, z]: Point<3>| {
        [
            x + size * (PI * y).sin() * (1.0 - z),
            y + size * (2.0 * z + x).cos(),
            z - size * (1.5 * x * y).sin(),
        ]
    };
    cuboid.build().unwrap().map_points(bent).unwrap()
}

/// Turns about z, then about x, then shifts.
fn placed([a, b]: [f64; 2], [x, y, z]: Point<3>) -> Point<3> {
    let ((s, k), (t, l)) = (a.sin_cos(), b.sin_cos());
    let [x, y] = [k * x - s * y, s * x + k * y];
    [x + 3.0, l * y - t * z - 1.0, t * y + l * z + 2.0]
}

const SIDES: [&str; 6] = ["left", "right", "front", "back", "bottom", "top"];

fn worst_stress(solution: &Solution<3>, expected: [f64; 6]) -> f64 {
    let stress = solution.bodies[0].stress.iter();
    let off = stress.flat_map(|s| (0..6).map(|c| (s[c] - expected[c]).abs()));
    off.fold(0.0, f64::max)
}

/// Prescribed on the whole boundary, u = H x: the same gradient everywhere.
fn check_prescribed(cell: CellKind, angles: [f64; 2]) {
    let h = [
        [2e-3, -1e-3, 4e-4],
        [7e-4, -3e-3, 1e-3],
        [-5e-4, 6e-4, 1e-3],
    ];
    let linear = move |x: Point<3>| h.map(|row: Point<3>| (0..3).map(|j| row[j] * x[j]).sum());
    let mesh = curved(cell, 0.08);
    let mesh = mesh.map_points(|x| placed(angles, x)).unwrap();
    let mut model = Model::new();
    model.body("body", mesh, SOFT);
    for side in SIDES {
        let component = |i: usize| Field::function("linear", move |x, _| linear(x)[i]);
        model.bodies[0].supports.push(Support {
            place: Place::Side(side.to_string()),
            components: [0, 1, 2].map(|i| Some(component(i))),
            normal: None,
            active: Default::default(),
        });
    }
    let solution = model.solve().unwrap();
    let mu = SOFT.young / (2.0 * (1.0 + SOFT.poisson));
    let lambda = 2.0 * mu * SOFT.poisson / (1.0 - 2.0 * SOFT.poisson);
    let trace = h[0][0] + h[1][1] + h[2][2];
    let entry =
        |i: usize, j: usize| mu * (h[i][j] + h[j][i]) + if i == j { lambda * trace } else { 0.0 };
    let pairs = [(0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (0, 2)];
    let expected = pairs.map(|(i, j)| entry(i, j));
    let largest = expected.iter().fold(0.0, |l: f64, s| l.max(s.abs()));
    let off = worst_stress(&solution, expected);
    assert!(off < 1e-12 * largest, "{cell:?} {angles:?}: {off:e}");
    let points = model.bodies[0].mesh.points().iter();
    for (&x, &u) in points.zip(&solution.bodies[0].displacement) {
        let off = distance(u, linear(x));
        assert!(off < 1e-12 * norm(linear(x)), "{cell:?}: {off:e}");
    }
}

#[test]
fn curved_cells_have_a_constant_stress_under_a_linear_displacement() {
    for cell in CellKind::of_dimension(3) {
        check_prescribed(cell, [0.0, 0.0]);
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(4))]
    #[test]
    fn linear_displacements_are_exact_under_any_rotation(a in -3.0..3.0, b in -3.0..3.0) {
        for cell in CellKind::of_dimension(3) {
            check_prescribed(cell, [a, b]);
        }
    }
}

/// A body that only six dofs hold, pressed from everywhere: the pressure stands everywhere, and nothing bears a force.
#[test]
fn pressure_all_around_a_curved_body_stands_everywhere_in_it() {
    const PRESSURE: f64 = 7.0;
    for cell in CellKind::of_dimension(3) {
        let mesh = curved(cell, 0.08);
        let mesh = mesh.map_points(|x| placed([0.4, -0.9], x)).unwrap();
        let points = mesh.points().to_vec();
        let mut model = Model::new();
        let body = model.body("body", mesh, SOFT);
        // three nodes that span a triangle, held as a tripod in the axes of the world
        let along = |d: usize, sign: f64| {
            let better = |a: &&Point<3>, b: &&Point<3>| (sign * a[d]).total_cmp(&(sign * b[d]));
            *points.iter().max_by(better).unwrap()
        };
        let (a, b, c) = (along(0, 1.0), along(0, -1.0), along(1, 1.0));
        model.pin(body, a, [Some(0.0); 3]);
        model.pin(body, b, [None, Some(0.0), Some(0.0)]);
        model.pin(body, c, [None, None, Some(0.0)]);
        for side in SIDES {
            let side = side.to_string();
            let pressure = Field::constant(PRESSURE);
            model.load(body, Load::Pressure { side, pressure });
        }
        let solution = model.solve().unwrap();
        let p = -PRESSURE;
        let off = worst_stress(&solution, [p, p, p, 0.0, 0.0, 0.0]);
        assert!(off < 1e-11 * PRESSURE, "{cell:?}: {off:e}");
    }
}

/// A dead weight: the reaction is volume times density, acting at the centre of gravity of a box.
#[test]
fn the_weight_of_a_box_is_borne_by_its_support() {
    for cell in CellKind::of_dimension(3) {
        let cuboid = Cuboid {
            from: [1.0, 2.0, 3.0],
            to: [2.0, 4.0, 6.0],
            cells: [2, 2, 3],
            cell,
        };
        let mut model = Model::new();
        let body = model.body("body", cuboid.build().unwrap(), SOFT);
        model.bodies[0].body_force = [0.3, -0.2, -0.5].map(Field::constant);
        model.fix(body, "bottom", [Some(0.0); 3]);
        let solution = model.solve().unwrap();
        let sum = solution.bodies[0].reaction;
        let expected = [-0.3, 0.2, 0.5].map(|b| 6.0 * b);
        let off = distance(sum, add_scaled([0.0; 3], 1.0, expected));
        assert!(off < 1e-12 * 6.0, "{cell:?}: {sum:?}");
    }
}
