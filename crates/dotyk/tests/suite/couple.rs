//! Sides that move with a point: forces spread as tractions, rigid sides, points held and driven, and the same by elimination.
//!
//! Tolerances are rounding unless they say otherwise: 1e-10 of the largest value for fields, 1e-12 for what rows say exactly.

use dotyk::fem::assemble;
use dotyk::geometry::{Field, Point, add_scaled, cross, distance, dot, norm, sub};
use dotyk::mesh::{CellKind, Cuboid, Diagonals, Mesh, Rectangle};
use dotyk::model::{
    Analysis, BodyId, CoupleKind, CoupleSolution, Elastic, Gap, Law, Load, Method, Model, Motion,
    Obstacle, Pair, Place, Reading, Rigid, SideRef, Solution, Status,
};

const KINDS: [CoupleKind; 2] = [CoupleKind::Rigid, CoupleKind::Average];

const PLANE: [CellKind; 5] = [
    CellKind::Tri3,
    CellKind::Tri6,
    CellKind::Quad4,
    CellKind::Quad8,
    CellKind::Quad9,
];

const SOFT: Elastic = Elastic {
    young: 1000.0,
    poisson: 0.3,
};
/// It does not contract across a load: a bent beam keeps its sections plane.
const CORK: Elastic = Elastic {
    young: 1000.0,
    poisson: 0.0,
};

fn rectangle(from: Point<2>, to: Point<2>, cells: [usize; 2], cell: CellKind) -> Mesh<2> {
    let rectangle = Rectangle {
        from,
        to,
        cells,
        cell,
        diagonals: Diagonals::default(),
    };
    rectangle.build().unwrap()
}

/// [0, 2] × [0, 1], its columns of unequal widths.
fn uneven(cell: CellKind) -> Mesh<2> {
    let even = rectangle([0.0, 0.0], [2.0, 1.0], [5, 3], cell);
    even.map_points(|[x, y]| [x + 0.1 * x * (2.0 - x) * (1.0 - 0.4 * x), y])
        .unwrap()
}

/// A body that is clamped at its bottom.
fn clamped(mesh: Mesh<2>) -> (Model<2>, BodyId) {
    let mut model = Model::new();
    let body = model.body("block", mesh, SOFT);
    model.fix(body, "bottom", [Some(0.0); 2]);
    (model, body)
}

/// Largest distance of two fields over the largest length of the second.
fn apart<const D: usize>(a: &[Point<D>], b: &[Point<D>]) -> f64 {
    assert_eq!(a.len(), b.len());
    let scale = b.iter().map(|&u| norm(u)).fold(0.0, f64::max);
    let both = a.iter().zip(b);
    both.map(|(&a, &b)| distance(a, b)).fold(0.0, f64::max) / scale
}

fn near(a: f64, b: f64, tolerance: f64) {
    assert!((a - b).abs() <= tolerance, "{a} {b}");
}

fn point_of<const D: usize>(solution: &Solution<D>) -> &CoupleSolution<D> {
    &solution.bodies[0].couples[0]
}

#[test]
fn a_force_at_the_middle_of_an_average_couple_is_an_even_resultant() {
    for cell in PLANE {
        let (mut pulled, body) = clamped(uneven(cell));
        let force = [0.7, 2.0].map(Field::constant);
        let side = "top".to_string();
        pulled.load(body, Load::Resultant { side, force });
        let (mut coupled, body) = clamped(uneven(cell));
        let couple = coupled.couple(body, "top", ("P", [1.0, 1.0]), CoupleKind::Average);
        couple.force = [0.7, 2.0].map(Field::constant);
        let [pulled, coupled] = [pulled, coupled].map(|model| model.solve().unwrap());
        let u = |solution: &Solution<2>| solution.bodies[0].displacement.clone();
        assert!(apart(&u(&coupled), &u(&pulled)) < 1e-10, "{cell:?}");
        let point = point_of(&coupled);
        assert!(apart(&[point.force], &[[0.7, 2.0]]) < 1e-10);
        near(point.moment[0], 0.0, 1e-10);
    }
}

/// Force and moment at a point far from the body are the traction that varies linearly along the side, and the point moves as
/// the side does in the mean.
#[test]
fn a_force_beside_an_average_couple_is_a_linear_traction() {
    let (at, force, turn) = ([3.5, 2.2], [0.7, 2.0], -1.3);
    for cell in PLANE {
        let (mut pulled, body) = clamped(uneven(cell));
        // about the middle (1, 1) of the side, of length 2: J = 2³/12
        let moment = turn + cross(sub(at, [1.0, 1.0]), force)[2];
        let slope = moment / (8.0 / 12.0);
        let traction = [
            Field::constant(force[0] / 2.0),
            Field::function("linear", move |x, _| force[1] / 2.0 + slope * (x[0] - 1.0)),
        ];
        let side = "top".to_string();
        pulled.load(body, Load::Traction { side, traction });
        let (mut coupled, body) = clamped(uneven(cell));
        let couple = coupled.couple(body, "top", ("P", at), CoupleKind::Average);
        couple.force = force.map(Field::constant);
        couple.moment[2] = Field::constant(turn);
        let [pulled, coupled] = [pulled, coupled].map(|model| model.solve().unwrap());
        let u = |solution: &Solution<2>| solution.bodies[0].displacement.clone();
        assert!(apart(&u(&coupled), &u(&pulled)) < 1e-10, "{cell:?}");
        let point = point_of(&coupled);
        assert!(apart(&[point.force], &[force]) < 1e-10);
        near(point.moment[0], turn, 1e-10);
        // Clapeyron: the work of force and moment at the point is that of the traction
        let work = dot(point.force, point.displacement) + point.moment[0] * point.rotation[0];
        let energy = coupled.bodies[0].strain_energy;
        near(work, 2.0 * energy, 1e-10 * energy);
    }
}

#[test]
fn a_couple_that_nothing_drives_changes_nothing_or_stiffens() {
    for cell in PLANE {
        let loaded = || {
            let (mut model, body) = clamped(uneven(cell));
            let traction = ["x^2", "1 - x"].map(|text| {
                let linear = text == "1 - x";
                Field::function(text, move |x, _| {
                    if linear { 1.0 - x[0] } else { x[0] * x[0] }
                })
            });
            let side = "top".to_string();
            model.load(body, Load::Traction { side, traction });
            (model, body)
        };
        let alone = loaded().0.solve().unwrap();
        let [rigid, average] = KINDS.map(|kind| {
            let (mut model, body) = loaded();
            model.couple(body, "top", ("P", [-1.0, 4.0]), kind);
            model.solve().unwrap()
        });
        let u = |solution: &Solution<2>| solution.bodies[0].displacement.clone();
        assert!(apart(&u(&average), &u(&alone)) < 1e-10, "{cell:?}");
        let energy = |solution: &Solution<2>| solution.bodies[0].strain_energy;
        assert!(energy(&rigid) < 0.999 * energy(&alone), "{cell:?}");
        for solution in [&rigid, &average] {
            let point = point_of(solution);
            near(norm(point.force), 0.0, 1e-10);
            near(point.moment[0], 0.0, 1e-10);
            assert!(solution.warnings.is_empty(), "{:?}", solution.warnings);
        }
    }
}

/// A beam [0, 6] × [-0.5, 0.5] of this thickness, clamped at its left; its right end moves with a point at its middle.
fn cantilever(cell: CellKind, kind: CoupleKind) -> Model<2> {
    let mut model = Model::new();
    model.analysis = Analysis::PlaneStress;
    let mesh = rectangle([0.0, -0.5], [6.0, 0.5], [12, 2], cell);
    let body = model.body("beam", mesh, CORK);
    model.bodies[body.0].thickness = 0.5;
    model.fix(body, "left", [Some(0.0); 2]);
    model.couple(body, "right", ("tip", [6.0, 0.0]), kind);
    model
}

/// EI of the beam.
const BENDING: f64 = 1000.0 * 0.5 / 12.0;

/// u_x = −κxy, u_y = κx²/2: exact for quadratic cells.
#[test]
fn a_moment_at_a_rigid_end_bends_a_beam_to_a_circle() {
    let moment = 0.3;
    let curvature = moment / BENDING;
    for cell in [CellKind::Tri6, CellKind::Quad8, CellKind::Quad9] {
        for kind in KINDS {
            let mut model = cantilever(cell, kind);
            model.bodies[0].couples[0].moment[2] = Field::constant(moment);
            let solution = model.solve().unwrap();
            let exact = |&[x, y]: &Point<2>| [-curvature * x * y, 0.5 * curvature * x * x];
            let exact: Vec<_> = model.bodies[0].mesh.points().iter().map(exact).collect();
            let computed = &solution.bodies[0].displacement;
            assert!(apart(computed, &exact) < 1e-9, "{cell:?} {kind:?}");
            let tip = point_of(&solution);
            near(tip.rotation[0], 6.0 * curvature, 1e-9 * curvature);
            near(tip.displacement[1], 18.0 * curvature, 1e-8 * curvature);
            near(tip.moment[0], moment, 1e-10);
        }
    }
}

#[test]
fn a_prescribed_rotation_gives_the_moment_back() {
    for kind in KINDS {
        let mut model = cantilever(CellKind::Quad8, kind);
        model.bodies[0].couples[0].rotation[2] = Some(Field::constant(0.02));
        let solution = model.solve().unwrap();
        let tip = point_of(&solution);
        near(tip.rotation[0], 0.02, 1e-15);
        near(tip.moment[0], 0.02 * BENDING / 6.0, 1e-9);
        near(norm(tip.force), 0.0, 1e-9);
    }
}

/// Every node of the side lies where the rigid motion of its point puts it.
fn check_rigid<const D: usize>(mesh: &Mesh<D>, side: &str, solution: &Solution<D>) {
    let point = point_of(solution);
    let spin = match point.rotation[..] {
        [z] => [0.0, 0.0, z],
        [x, y, z] => [x, y, z],
        _ => panic!("rotations"),
    };
    let u = &solution.bodies[0].displacement;
    let largest = u.iter().map(|&u| norm(u)).fold(0.0, f64::max);
    for &facet in mesh.side(side).unwrap() {
        for node in mesh.facet_nodes(facet) {
            let node = node as usize;
            let r = sub(mesh.points()[node], point.point);
            let mut arm = [0.0; 3];
            arm[..D].copy_from_slice(&r);
            let turned = cross(spin, arm);
            let rigid: Point<D> = std::array::from_fn(|i| point.displacement[i] + turned[i]);
            let off = distance(u[node], rigid);
            assert!(off < 1e-12 * largest, "{off} {largest}");
        }
    }
}

#[test]
fn a_rigid_side_moves_as_its_point_tells_and_a_beam_as_its_theory() {
    for cell in [CellKind::Tri6, CellKind::Quad8, CellKind::Quad9] {
        let mut model = cantilever(cell, CoupleKind::Rigid);
        model.bodies[0].couples[0].force[1] = Field::constant(-0.4);
        model.bodies[0].couples[0].point = [7.0, 0.3];
        let solution = model.solve().unwrap();
        check_rigid(&model.bodies[0].mesh, "right", &solution);
        // Timoshenko's deflection of the end with its force and the moment of the arm of 1; G = E/2, κ = 5/6
        let (force, length): (f64, f64) = (-0.4, 6.0);
        let shear = force * length / (5.0 / 6.0 * 500.0 * 0.5);
        let end = force * (length.powi(3) / 3.0 + length * length / 2.0) / BENDING + shear;
        let turn = force * (length * length / 2.0 + length) / BENDING;
        let tip = point_of(&solution);
        let expected = end + turn;
        // the ends do not warp as Timoshenko lets them: a part h²/L² of what shear gives
        near(tip.rotation[0], turn, 1e-3 * turn.abs());
        near(tip.displacement[1], expected, 1e-3 * expected.abs());
        near(tip.moment[0], 0.0, 1e-9);
    }
}
