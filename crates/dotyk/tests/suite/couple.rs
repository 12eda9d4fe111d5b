//! Sides that move with a point: forces spread as tractions, rigid sides, points held and driven, and the same by elimination.
//!
//! Tolerances are rounding unless they say otherwise: 1e-10 of the largest value for fields, 1e-12 for what rows say exactly.

use crate::friction::Random;
use dotyk::case::Case;
use dotyk::fem::{assemble, quadrature::gauss};
use dotyk::geometry::{Field, Point, add_scaled, cross, distance, dot, norm, sub};
use dotyk::mesh::{CellKind, Cuboid, Diagonals, MAX_FACET_NODES, Mesh, Rectangle};
use dotyk::model::{
    Analysis, BodyId, CoupleKind, CoupleSolution, DENSE_LIMIT, Elastic, Gap, Law, Load, Method,
    Model, Motion, Obstacle, Pair, Reading, Rigid, SideRef, Solution, Status,
};
use dotyk::solve::{ContactSolver, Newton};
use std::ops::ControlFlow;

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
                Field::function(
                    text,
                    move |x, _| {
                        if linear { 1.0 - x[0] } else { x[0] * x[0] }
                    },
                )
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

/// The equations of a dense matrix with partial pivoting.
fn dense_solve(mut matrix: Vec<Vec<f64>>, mut rhs: Vec<f64>) -> Vec<f64> {
    let n = rhs.len();
    for k in 0..n {
        let size = |row: usize| matrix[row][k].abs();
        let pivot = (k..n).max_by(|&a, &b| size(a).total_cmp(&size(b))).unwrap();
        matrix.swap(k, pivot);
        rhs.swap(k, pivot);
        let (above, below) = matrix.split_at_mut(k + 1);
        for (row, own) in below.iter_mut().enumerate() {
            let factor = own[k] / above[k][k];
            for (own, top) in own[k..].iter_mut().zip(&above[k][k..]) {
                *own -= factor * top;
            }
            rhs[k + 1 + row] -= factor * rhs[k];
        }
    }
    for k in (0..n).rev() {
        let known: f64 = (k + 1..n).map(|j| matrix[k][j] * rhs[j]).sum();
        rhs[k] = (rhs[k] - known) / matrix[k][k];
    }
    rhs
}

/// The rigid motions of the plane about a point, at r from it.
fn motions([x, y]: Point<2>) -> [Point<2>; 3] {
    [[1.0, 0.0], [0.0, 1.0], [-y, x]]
}

/// Nodes of a side with ∫N φ and ∫N of the least-squares fit of rigid motions φ: rows of P with (u_p, θ) = P u, (3, 2n).
fn fit(mesh: &Mesh<2>, side: &str, at: Point<2>) -> Vec<Vec<f64>> {
    let n = 2 * mesh.points().len();
    let (mut normal, mut rows) = (vec![vec![0.0; 3]; 3], vec![vec![0.0; n]; 3]);
    for &facet in mesh.side(side).unwrap() {
        let kind = mesh.facet_kind(facet);
        let nodes: Vec<usize> = mesh.facet_nodes(facet).map(|node| node as usize).collect();
        for (xi, weight) in gauss(8) {
            let mut shape = [0.0; MAX_FACET_NODES];
            kind.shape(&[xi], &mut shape);
            let length = weight * norm(mesh.outward_normal(facet, &[xi]));
            let phi = motions(sub(mesh.facet_point(facet, &[xi]), at));
            for k in 0..3 {
                for l in 0..3 {
                    normal[k][l] += length * dot(phi[k], phi[l]);
                }
                for (&node, n) in nodes.iter().zip(shape) {
                    for i in 0..2 {
                        rows[k][2 * node + i] += length * n * phi[k][i];
                    }
                }
            }
        }
    }
    let mut fitted = vec![vec![0.0; n]; 3];
    for dof in 0..n {
        let column = rows.iter().map(|row| row[dof]).collect();
        let solved = dense_solve(normal.clone(), column);
        (0..3).for_each(|k| fitted[k][dof] = solved[k]);
    }
    fitted
}

/// min 1/2 uᵀKu − fᵀu − (F, M)·p over q with u = T q, p = S q and some components of p given; by dense equations with a
/// multiplier for each of these. The answer is u and p.
fn by_elimination(
    stiffness: &[Vec<f64>],
    (load, at_point): (&[f64], [f64; 3]),
    (to_nodes, to_point): (&[Vec<f64>], &[[f64; 3]]),
    given: [Option<f64>; 3],
) -> (Vec<f64>, [f64; 3]) {
    let n = to_nodes.len();
    let inner = |a: &[f64], b: &[f64]| -> f64 { a.iter().zip(b).map(|(a, b)| a * b).sum() };
    let held: Vec<usize> = (0..3).filter(|&k| given[k].is_some()).collect();
    let size = n + held.len();
    let (mut matrix, mut rhs) = (vec![vec![0.0; size]; size], vec![0.0; size]);
    for j in 0..n {
        let force: Vec<f64> = stiffness
            .iter()
            .map(|row| inner(row, &to_nodes[j]))
            .collect();
        for i in 0..n {
            matrix[i][j] = inner(&to_nodes[i], &force);
        }
        rhs[j] = inner(&to_nodes[j], load) + inner(&to_point[j], &at_point);
        for (row, &k) in held.iter().enumerate() {
            (matrix[n + row][j], matrix[j][n + row]) = (to_point[j][k], to_point[j][k]);
            rhs[n + row] = given[k].unwrap_or(0.0);
        }
    }
    let q = dense_solve(matrix, rhs);
    let mut u = vec![0.0; load.len()];
    let mut p = [0.0; 3];
    for (j, q) in q[..n].iter().enumerate() {
        u.iter_mut()
            .zip(&to_nodes[j])
            .for_each(|(u, t)| *u += q * t);
        p.iter_mut()
            .zip(&to_point[j])
            .for_each(|(p, s)| *p += q * s);
    }
    (u, p)
}

/// Random bent bodies and points; some components of the points are held, all carry forces.
#[test]
fn couples_are_what_elimination_gives() {
    let mut random = Random(7);
    for (case, cell) in PLANE.into_iter().cycle().take(40).enumerate() {
        let kind = KINDS[case / 5 % 2];
        let mesh = rectangle([0.0, 0.0], [2.0, 1.0], [3, 2], cell);
        let [a, b] = [random.signed(), random.signed()];
        let bent = |[x, y]: Point<2>| [x + 0.2 * a * y * y, y + 0.2 * b * x * x];
        let mut model = Model::new();
        let body = model.body("block", mesh.map_points(bent).unwrap(), SOFT);
        model.fix(body, "left", [Some(0.0); 2]);
        model.pull(body, "top", [random.signed(), random.signed()]);
        let system = assemble(&model.bodies[0], model.analysis, 1.0).unwrap();
        let loads: [f64; 3] = std::array::from_fn(|_| random.signed());
        let at = [3.0 * random.signed(), 3.0 * random.signed()];
        let mut given = [None; 3];
        for held in given.iter_mut().skip(case % 4) {
            *held = Some(0.01 * random.signed());
        }
        let couple = model.couple(body, "right", ("P", at), kind);
        couple.force = [loads[0], loads[1]].map(Field::constant);
        couple.moment[2] = Field::constant(loads[2]);
        couple.displacement = [given[0], given[1]].map(|held| held.map(Field::constant));
        couple.rotation[2] = given[2].map(Field::constant);
        let solution = model.solve().unwrap();

        let mesh = &model.bodies[0].mesh;
        let n = system.held.len();
        let unit =
            |dof: usize| -> Vec<f64> { (0..n).map(|i| f64::from(u8::from(i == dof))).collect() };
        let stiffness: Vec<Vec<f64>> = (0..n)
            .map(|dof| {
                let mut column = vec![0.0; n];
                system.stiffness.mul(&unit(dof), &mut column);
                column
            })
            .collect();
        let side = mesh.side("right").unwrap().iter();
        let side: Vec<usize> = side
            .flat_map(|&facet| mesh.facet_nodes(facet))
            .map(|node| node as usize)
            .collect();
        let free = (0..n).filter(|&dof| !system.held[dof]);
        let (mut to_nodes, mut to_point) = (Vec::new(), Vec::new());
        match kind {
            CoupleKind::Rigid => {
                for dof in free.filter(|dof| !side.contains(&(dof / 2))) {
                    to_nodes.push(unit(dof));
                    to_point.push([0.0; 3]);
                }
                for k in 0..3 {
                    let mut column = vec![0.0; n];
                    for &node in &side {
                        let u = motions(sub(mesh.points()[node], at))[k];
                        column[2 * node..2 * node + 2].copy_from_slice(&u);
                    }
                    to_nodes.push(column);
                    to_point.push(std::array::from_fn(|i| f64::from(u8::from(i == k))));
                }
            }
            CoupleKind::Average => {
                let fitted = fit(mesh, "right", at);
                for dof in free {
                    to_nodes.push(unit(dof));
                    to_point.push(std::array::from_fn(|k| fitted[k][dof]));
                }
            }
        }
        let forces = (&system.load[..], loads);
        let (u, p) = by_elimination(&stiffness, forces, (&to_nodes, &to_point), given);
        let expected: Vec<Point<2>> = u.chunks(2).map(|u| [u[0], u[1]]).collect();
        assert!(
            apart(&solution.bodies[0].displacement, &expected) < 1e-10,
            "{cell:?} {kind:?}"
        );
        let point = point_of(&solution);
        let [x, y] = point.displacement;
        let scale = p.iter().fold(0.0, |s: f64, p| s.max(p.abs()));
        for (computed, p) in [x, y, point.rotation[0]].into_iter().zip(p) {
            near(computed, p, 1e-10 * scale);
        }
        // what holds the point and what it carries is what the side gets
        near(point.force[0], loads[0] + point.reaction[0], 1e-9);
        near(point.force[1], loads[1] + point.reaction[1], 1e-9);
        if given == [None; 3] {
            near(point.moment[0], loads[2], 1e-9);
        }
    }
}

/// A body that a point alone holds: what its loads need comes back from there.
#[test]
fn a_floating_body_is_held_by_its_point() {
    for kind in KINDS {
        let mut model = Model::new();
        let body = model.body("block", uneven(CellKind::Quad8), SOFT);
        model.pull(body, "right", [1.0, 0.5]);
        let couple = model.couple(body, "left", ("P", [-2.0, -1.0]), kind);
        couple.displacement = [0.0, 0.1].map(|held| Some(Field::constant(held)));
        couple.rotation[2] = Some(Field::constant(0.0));
        let at = Reading::Coupled(0);
        for quantity in ["displacement.y", "displacement.magnitude"] {
            let quantity = format!("block.{quantity}");
            model.probe(&quantity, &quantity, at).unwrap();
        }
        let solution = model.solve().unwrap();
        for probe in &solution.probes {
            near(probe.value, 0.1, 1e-15);
        }
        model.probe("stress", "block.stress.xx", at).unwrap();
        let error = model.solve().unwrap_err().to_string();
        assert!(error.contains("probe \"stress\""), "{error}");
        let (body, point) = (&solution.bodies[0], point_of(&solution));
        assert!(apart(&[body.reaction], &[[-1.0, -0.5]]) < 1e-10);
        assert!(apart(&[point.force], &[[-1.0, -0.5]]) < 1e-10);
        // the load acts at (2, 0.5), which is (4, 1.5) from the point
        near(point.moment[0], -(4.0 * 0.5 - 1.5), 1e-9);
        assert_eq!(body.floating_modes.len(), 3);
        assert!(solution.warnings.is_empty(), "{:?}", solution.warnings);
        // its answer is that of the side held where it may stay, moved
        if kind == CoupleKind::Rigid {
            let mut fixed = Model::new();
            let id = fixed.body("block", uneven(CellKind::Quad8), SOFT);
            fixed.fix(id, "left", [Some(0.0), Some(0.1)]);
            fixed.pull(id, "right", [1.0, 0.5]);
            let fixed = fixed.solve().unwrap();
            assert!(apart(&body.displacement, &fixed.bodies[0].displacement) < 1e-9);
        }
    }
}

#[test]
fn what_nothing_holds_is_named_by_its_body() {
    for kind in KINDS {
        let mut model = Model::new();
        let body = model.body("block", uneven(CellKind::Quad4), SOFT);
        let couple = model.couple(body, "left", ("P", [-50.0, 0.0]), kind);
        couple.force[0] = Field::constant(1.0);
        let error = model.solve().unwrap_err().to_string();
        let said = ["body \"block\" is not held", "its load does work on it"];
        assert!(said.iter().all(|words| error.contains(words)), "{error}");
    }
}

/// A punch on a block with friction, driven at its top in steps: down, aside, and back.
fn driven_punch(hold: impl Fn(&mut Model<2>, BodyId, [Field; 2])) -> Model<2> {
    let mut model = Model::new();
    let block = model.body(
        "block",
        rectangle([-1.0, -1.0], [2.0, 0.0], [9, 4], CellKind::Quad4),
        SOFT,
    );
    model.fix(block, "bottom", [Some(0.0); 2]);
    let punch = model.body(
        "punch",
        rectangle([0.0, 0.0], [1.0, 1.0], [4, 4], CellKind::Quad4),
        CORK,
    );
    let aside = Field::function("aside", |_, t| [0.0, 2e-3, 2e-2, -5e-3][t as usize - 1]);
    hold(
        &mut model,
        punch,
        [
            aside,
            Field::function("down", |_, t| -5e-3 * f64::min(t, 2.0)),
        ],
    );
    let contact = model.contact((punch, "bottom"), (block, "top"));
    contact.law = Law::Coulomb(Field::constant(0.3));
    model.bodies.swap(0, 1);
    let side = |body: usize, side: &str| SideRef {
        body: BodyId(body),
        side: side.to_string(),
    };
    model.contacts[0].pair = Pair::Given {
        nonmortar: side(0, "bottom"),
        mortar: side(1, "top"),
    };
    model.times = vec![1.0, 2.0, 3.0, 4.0];
    model
}

#[test]
fn a_rigid_couple_driven_in_steps_is_a_side_driven_in_steps() {
    let fixed = driven_punch(|model, punch, [x, y]| {
        model.fix(punch, "top", [Some(0.0); 2]);
        let last = model.bodies[punch.0].supports.last_mut().unwrap();
        last.components = [Some(x), Some(y)];
    });
    let coupled = driven_punch(|model, punch, [x, y]| {
        let couple = model.couple(punch, "top", ("P", [0.3, 5.0]), CoupleKind::Rigid);
        couple.displacement = [Some(x), Some(y)];
        couple.rotation[2] = Some(Field::constant(0.0));
    });
    let [fixed, coupled] = [fixed, coupled].map(|model| model.solve_steps().unwrap());
    let states = |solution: &Solution<2>| -> Vec<Status> {
        solution.contacts[0]
            .nodes
            .iter()
            .map(|node| node.status)
            .collect()
    };
    let mut slipped = false;
    for (a, b) in coupled.iter().zip(&fixed) {
        assert_eq!(states(a), states(b));
        slipped |= states(a).contains(&Status::Slip);
        assert!(apart(&a.bodies[0].displacement, &b.bodies[0].displacement) < 1e-8);
        assert!(apart(&[a.contacts[0].resultant], &[b.contacts[0].resultant]) < 1e-8);
        assert!(apart(&[a.bodies[0].reaction], &[b.bodies[0].reaction]) < 1e-8);
    }
    assert!(slipped);
}

/// A stamp whose sole a rigid couple keeps plane, above a block of the same width; an eccentric force tilts it. All is turned.
fn stamp(angle: f64, law: Law) -> Model<2> {
    let turn = move |[x, y]: Point<2>| {
        let (s, c) = angle.sin_cos();
        [c * x - s * y, s * x + c * y]
    };
    let turned = |from: Point<2>, to: Point<2>| {
        let mesh = rectangle(from, to, [16, 6], CellKind::Quad4);
        mesh.map_points(turn).unwrap()
    };
    let mut model = Model::new();
    let stamp = model.body("stamp", turned([0.0, 0.0], [2.0, 0.5]), SOFT);
    let block = model.body("block", turned([0.0, -1.0], [2.0, 0.0]), SOFT);
    model.fix(block, "bottom", [Some(0.0); 2]);
    let couple = model.couple(stamp, "bottom", ("P", turn([1.5, 3.0])), CoupleKind::Rigid);
    couple.force = turn([0.0, -3.0]).map(Field::constant);
    model.contact((stamp, "bottom"), (block, "top")).law = law;
    model
}

#[test]
fn an_eccentric_force_tilts_a_rigid_sole_and_opens_it() {
    let pressed = stamp(0.0, Law::Frictionless).solve().unwrap();
    let nodes = &pressed.contacts[0].nodes;
    let open = nodes
        .iter()
        .filter(|node| node.status == Status::Open)
        .count();
    assert!(open >= 2 && open < nodes.len() - 2, "{open}");
    // the resultant passes through the point
    let force: f64 = nodes.iter().map(|node| node.pressure * node.weight).sum();
    let moment = nodes
        .iter()
        .map(|node| node.pressure * node.weight * node.point[0]);
    near(force, 3.0, 1e-9);
    near(moment.sum::<f64>(), 4.5, 1e-9);

    // the same block below a rigid obstacle where the sole has gone
    let point = point_of(&pressed);
    let (sink, tilt) = (point.displacement[1], point.rotation[0]);
    let mut model = stamp(0.0, Law::Frictionless);
    model.bodies.remove(0);
    let contact = &mut model.contacts[0];
    contact.pair = Pair::Obstacle {
        nonmortar: SideRef {
            body: BodyId(0),
            side: "top".to_string(),
        },
        obstacle: Obstacle {
            shape: Rigid::Gap(Field::function("plane", move |x, _| {
                sink + tilt * (x[0] - 1.5)
            })),
            motion: Motion::Prescribed([0.0, 0.0].map(Field::constant)),
        },
    };
    let below = model.solve().unwrap();
    let u = |solution: &Solution<2>, body: usize| solution.bodies[body].displacement.clone();
    assert!(apart(&u(&pressed, 1), &u(&below, 0)) < 1e-9);
}

#[test]
fn a_turned_model_has_the_turned_answer() {
    let law = || Law::Coulomb(Field::constant(0.4));
    let plain = stamp(0.0, law()).solve().unwrap();
    for angle in [0.7, 2.5] {
        let (s, c) = f64::sin_cos(angle);
        let turned = stamp(angle, law()).solve().unwrap();
        for (a, b) in turned.bodies.iter().zip(&plain.bodies) {
            let back = |&[x, y]: &Point<2>| [c * x + s * y, c * y - s * x];
            let back: Vec<_> = a.displacement.iter().map(back).collect();
            assert!(apart(&back, &b.displacement) < 1e-8);
        }
        let [a, b] = [&turned, &plain].map(point_of);
        near(a.rotation[0], b.rotation[0], 1e-8 * b.rotation[0].abs());
        near(
            norm(a.displacement),
            norm(b.displacement),
            1e-8 * norm(b.displacement),
        );
    }
}

#[test]
fn every_method_solves_what_couples_hold() {
    let reference = stamp(0.0, Law::Frictionless).solve().unwrap();
    for method in Method::NAMED {
        let mut model = stamp(0.0, Law::Frictionless);
        model.solver.method = method;
        let solution = model
            .solve()
            .unwrap_or_else(|error| panic!("{}: {error}", method.name()));
        let u = |solution: &Solution<2>| solution.bodies[1].displacement.clone();
        assert!(
            apart(&u(&solution), &u(&reference)) < 1e-5,
            "{}",
            method.name()
        );
    }
}

/// F as products alone, with its preconditioner, whatever part has no stiffness.
#[test]
fn compliances_that_are_not_assembled_know_couples() {
    let model = stamp(0.0, Law::Frictionless);
    let [dense, applied] = [DENSE_LIMIT, 0].map(|limit| {
        let problem = model.dual_problem(limit).unwrap();
        let newton = Newton::default();
        let outcome = newton.solve(&problem, None, &mut |_| ControlFlow::Continue(()));
        outcome.unwrap().multipliers.lambda
    });
    let scale = dense.iter().fold(0.0, |s: f64, l| s.max(l.abs()));
    for (a, b) in applied.iter().zip(&dense) {
        near(*a, *b, 1e-6 * scale);
    }
}

/// A body that hovers is placed as if the couple were not there.
#[test]
fn a_point_that_nothing_drives_does_not_move_what_hovers() {
    let lifted = |couple: bool| {
        let mut model = stamp(0.0, Law::Frictionless);
        model.bodies[0].couples.clear();
        if couple {
            model.couple(BodyId(0), "bottom", ("P", [7.0, 3.0]), CoupleKind::Average);
        }
        model.press(BodyId(1), "top", 3.0);
        model.contacts[0].gap = Some(Gap::Given(Field::constant(0.001)));
        model.solve().unwrap()
    };
    let [with, without] = [true, false].map(lifted);
    let u = |solution: &Solution<2>, body: usize| solution.bodies[body].displacement.clone();
    assert!(apart(&u(&with, 1), &u(&without, 1)) < 1e-9);
    let largest = u(&without, 1).iter().map(|&u| norm(u)).fold(0.0, f64::max);
    for (a, b) in u(&with, 0).iter().zip(&u(&without, 0)) {
        near(distance(*a, *b), 0.0, 1e-9 * largest);
    }
    assert_eq!(with.warnings, without.warnings);
}

/// A block of space, clamped at its bottom.
fn block_of_space(cell: CellKind) -> (Model<3>, BodyId) {
    let cuboid = Cuboid {
        from: [0.0; 3],
        to: [2.0, 1.0, 1.0],
        cells: [3, 2, 2],
        cell,
    };
    let even = cuboid.build().unwrap();
    let mesh = even
        .map_points(|[x, y, z]| [x + 0.1 * x * (2.0 - x), y + 0.2 * y * (1.0 - y), z])
        .unwrap();
    let mut model = Model::new();
    let body = model.body("block", mesh, SOFT);
    model.fix(body, "bottom", [Some(0.0); 3]);
    (model, body)
}

const SPACE: [CellKind; 2] = [CellKind::Tet4, CellKind::Hex8];

/// Force and moment beside the side as F/W + (J⁻¹M) × s, with the moments of a rectangle of 2 by 1.
#[test]
fn in_space_an_average_couple_is_a_linear_traction() {
    let (at, force, turn) = ([3.0, -1.0, 2.5], [0.7, -0.4, 2.0], [0.3, -0.8, 1.1]);
    for cell in SPACE {
        let (mut pulled, body) = block_of_space(cell);
        let moment = add_scaled(turn, 1.0, cross(sub(at, [1.0, 0.5, 1.0]), force));
        // about x, y and z: ∫y², ∫x², ∫x² + y²
        let [jx, jy]: [f64; 2] = [2.0 / 12.0, 8.0 / 12.0];
        let spin = [moment[0] / jx, moment[1] / jy, moment[2] / (jx + jy)];
        let traction = std::array::from_fn(|i| {
            Field::function("linear", move |x, _| {
                let s = [x[0] - 1.0, x[1] - 0.5, 0.0];
                force[i] / 2.0 + cross(spin, s)[i]
            })
        });
        let side = "top".to_string();
        pulled.load(body, Load::Traction { side, traction });
        let (mut coupled, body) = block_of_space(cell);
        let couple = coupled.couple(body, "top", ("P", at), CoupleKind::Average);
        couple.force = force.map(Field::constant);
        couple.moment = turn.map(Field::constant);
        let [pulled, coupled] = [pulled, coupled].map(|model| model.solve().unwrap());
        let u = |solution: &Solution<3>| solution.bodies[0].displacement.clone();
        assert!(apart(&u(&coupled), &u(&pulled)) < 1e-10, "{cell:?}");
        let point = point_of(&coupled);
        let turns = [point.rotation[0], point.rotation[1], point.rotation[2]];
        let work = dot(force, point.displacement) + dot(turn, turns);
        let energy = coupled.bodies[0].strain_energy;
        near(work, 2.0 * energy, 1e-10 * energy);
    }
}

#[test]
fn in_space_a_rigid_side_moves_as_its_point_tells() {
    for cell in SPACE {
        let (mut model, body) = block_of_space(cell);
        let couple = model.couple(body, "top", ("P", [3.0, -1.0, 2.5]), CoupleKind::Rigid);
        couple.displacement[1] = Some(Field::constant(0.1));
        couple.rotation[0] = Some(Field::constant(0.05));
        couple.force[2] = Field::constant(1.0);
        couple.moment[2] = Field::constant(-2.0);
        let solution = model.solve().unwrap();
        check_rigid(&model.bodies[0].mesh, "top", &solution);
        let point = point_of(&solution);
        near(point.displacement[1], 0.1, 1e-15);
        near(point.rotation[0], 0.05, 1e-15);
        // what is not held gets what is given
        near(point.force[0], 0.0, 1e-9);
        near(point.force[2], 1.0, 1e-9);
        near(point.moment[1], 0.0, 1e-9);
        near(point.moment[2], -2.0, 1e-9);
        assert!(point.force[1].abs() > 0.1 && point.moment[0].abs() > 0.1);
        near(point.reaction[1], point.force[1], 1e-9);
    }
}

/// A thick pipe or a solid cylinder, held at its lower end.
fn cylinder(inner: f64, kind: CoupleKind) -> (Model<2>, BodyId) {
    let mut model = Model::new();
    model.analysis = Analysis::Axisymmetric;
    let mesh = rectangle([inner, 0.0], [inner + 1.0, 2.0], [3, 4], CellKind::Quad8);
    let body = model.body("pipe", mesh, SOFT);
    model.fix(body, "bottom", [None, Some(0.0)]);
    model.couple(body, "top", ("P", [0.0, 5.0]), kind);
    (model, body)
}

#[test]
fn with_axial_symmetry_points_move_along_the_axis() {
    for inner in [0.0, 0.5] {
        let (mut pulled, body) = cylinder(inner, CoupleKind::Average);
        let side = "top".to_string();
        let force = [0.0, 3.0].map(Field::constant);
        pulled.load(body, Load::Resultant { side, force });
        let (mut coupled, _) = cylinder(inner, CoupleKind::Average);
        coupled.bodies[0].couples[0].force[1] = Field::constant(3.0);
        let [pulled, coupled] = [pulled, coupled].map(|model| model.solve().unwrap());
        let [a, b] = [&coupled, &pulled].map(|solution| &solution.bodies[0].displacement);
        assert!(apart(a, b) < 1e-10);
        let [a, b] = [&coupled, &pulled].map(point_of);
        near(a.displacement[1], b.displacement[1], 1e-12);
        assert!(apart(&[a.force], &[[0.0, 3.0]]) < 1e-10);

        let (mut model, _) = cylinder(inner, CoupleKind::Rigid);
        model.bodies[0].couples[0].displacement[1] = Some(Field::constant(1e-3));
        let solution = model.solve().unwrap();
        assert!(solution.warnings.is_empty(), "{:?}", solution.warnings);
        let mesh = &model.bodies[0].mesh;
        for (&[_, y], &u) in mesh.points().iter().zip(&solution.bodies[0].displacement) {
            if y == 2.0 {
                assert!(distance(u, [0.0, 1e-3]) < 1e-15);
            }
        }
        // the end is pulled by what holds the other one
        let body = &solution.bodies[0];
        near(body.reaction[1], 0.0, 1e-8 * point_of(&solution).force[1]);
        near(
            body.side_reactions["bottom"][1],
            -point_of(&solution).force[1],
            1e-8,
        );
    }
}

#[test]
fn with_axial_symmetry_nothing_turns() {
    type Change = fn(&mut dotyk::model::Couple<2>);
    let changes: [Change; 4] = [
        |couple| couple.moment[2] = Field::constant(1.0),
        |couple| couple.rotation[2] = Some(Field::constant(0.0)),
        |couple| couple.force[0] = Field::constant(1.0),
        |couple| couple.displacement[0] = Some(Field::constant(1.0)),
    ];
    for change in changes {
        let (mut model, _) = cylinder(0.5, CoupleKind::Rigid);
        change(&mut model.bodies[0].couples[0]);
        let error = model.solve().unwrap_err().to_string();
        assert!(error.contains("only moves along the axis"), "{error}");
    }
}

/// Two points of one side, of a side that is held in part, and of sides that meet.
#[test]
fn conditions_that_others_imply_are_dropped_and_hold() {
    for cell in [CellKind::Quad4, CellKind::Quad8] {
        let (mut model, body) = clamped(uneven(cell));
        for (name, kind) in [("P", CoupleKind::Rigid), ("Q", CoupleKind::Rigid)] {
            let couple = model.couple(body, "top", (name, [1.0, 2.0]), kind);
            couple.force[0] = Field::constant(1.0);
        }
        model.couple(body, "top", ("mean", [0.0, 0.0]), CoupleKind::Average);
        let twice = model.solve().unwrap();
        let (mut model, body) = clamped(uneven(cell));
        let couple = model.couple(body, "top", ("P", [1.0, 2.0]), CoupleKind::Rigid);
        couple.force[0] = Field::constant(2.0);
        let once = model.solve().unwrap();
        let [a, b] = [&twice, &once].map(|solution| &solution.bodies[0].displacement);
        assert!(apart(a, b) < 1e-9);
        // all points of a rigid side have one rotation
        let turn = point_of(&once).rotation[0];
        for couple in &twice.bodies[0].couples {
            near(couple.rotation[0], turn, 1e-9 * turn.abs());
        }
        assert!(
            twice
                .warnings
                .iter()
                .any(|w| w.contains("rigid couple \"block.Q\"")),
            "{:?}",
            twice.warnings
        );

        // a side that the clamp holds at one end turns about that end
        let (mut model, body) = clamped(uneven(cell));
        let couple = model.couple(body, "right", ("P", [2.0, 0.0]), CoupleKind::Rigid);
        couple.moment[2] = Field::constant(1.0);
        let hinged = model.solve().unwrap();
        check_rigid(&model.bodies[0].mesh, "right", &hinged);
        near(norm(point_of(&hinged).displacement), 0.0, 1e-12);
        assert!(point_of(&hinged).rotation[0] > 0.0);
    }
}

#[test]
fn a_couple_at_the_sides_of_a_contact_shares_their_corner() {
    let mut model = stamp(0.0, Law::Coulomb(Field::constant(0.4)));
    let couple = model.couple(
        BodyId(0),
        "left",
        ("side", [-1.0, 1.0]),
        CoupleKind::Average,
    );
    couple.force = [0.1, -0.5].map(Field::constant);
    let solution = model.solve().unwrap();
    // nothing holds the stamp but the contact: its forces balance those of both points
    let force = solution.contacts[0].resultant;
    assert!(apart(&[force], &[[-0.1, 3.5]]) < 1e-9);
}

#[test]
fn what_is_wrong_with_a_couple_is_said() {
    let said = |change: &dyn Fn(&mut Model<2>, BodyId)| {
        let (mut model, body) = clamped(uneven(CellKind::Quad4));
        change(&mut model, body);
        model.solve().unwrap_err().to_string()
    };
    let rigid = CoupleKind::Rigid;
    let unknown = said(&|model, body| {
        model.couple(body, "roof", ("P", [0.0; 2]), rigid);
    });
    assert!(unknown.contains("there is no side \"roof\""), "{unknown}");
    let nowhere = [f64::NAN, 0.0];
    let nowhere = said(&|model, body| {
        model.couple(body, "top", ("P", nowhere), rigid);
    });
    assert!(
        nowhere.contains("\"block\"") && nowhere.contains("not finite"),
        "{nowhere}"
    );
    let infinite = said(&|model, body| {
        let couple = model.couple(body, "top", ("P", [0.0; 2]), rigid);
        couple.moment[2] = Field::function("1/t", |_, _| f64::INFINITY);
    });
    assert!(
        infinite.contains("moment of point \"P\" = 1/t is not finite"),
        "{infinite}"
    );
    let twice = said(&|model, body| {
        model.couple(body, "top", ("P", [0.0; 2]), rigid);
        model.couple(body, "left", ("P", [0.0; 2]), rigid);
    });
    assert!(
        twice.contains("named \"block.P\"") && twice.contains("rename the coupled point"),
        "{twice}"
    );
    let against = said(&|model, body| {
        let couple = model.couple(body, "bottom", ("P", [0.0; 2]), rigid);
        couple.displacement = [0.1, 0.0].map(|held| Some(Field::constant(held)));
        couple.rotation[2] = Some(Field::constant(0.0));
    });
    assert!(
        against.contains("at point \"P\"") && against.contains("contradict"),
        "{against}"
    );
}

/// A rigid side that turns about one of its nodes moves that by a sum that cancels.
#[test]
fn supports_on_the_pole_of_a_rigid_side_agree_with_it() {
    let (mut model, body) = clamped(uneven(CellKind::Quad4));
    let [_, x] = [0.0, 0.7];
    let couple = model.couple(body, "top", ("P", [x, 0.4]), CoupleKind::Rigid);
    // about (0, 1): u = θ × (P − pole)
    let turn = 0.01;
    couple.displacement = [-turn * (0.4 - 1.0), turn * x].map(|u| Some(Field::constant(u)));
    couple.rotation[2] = Some(Field::constant(turn));
    model.pin(body, [0.0, 1.0], [Some(0.0), Some(0.0)]);
    model.solve().unwrap();
    model.pin(body, [0.0, 1.0], [None, Some(1e-9)]);
    assert!(model.solve().is_err());
}

/// What agrees at the first time need not do so later.
#[test]
fn supports_that_leave_the_motion_of_a_rigid_side_are_told_with_their_step() {
    let (mut model, body) = clamped(uneven(CellKind::Quad4));
    model.pin(body, [0.0, 1.0], [None, Some(-0.1)]);
    let couple = model.couple(body, "top", ("P", [1.0, 1.0]), CoupleKind::Rigid);
    couple.displacement = [
        Some(Field::constant(0.0)),
        Some(Field::function("down", |_, t| -0.1 * t)),
    ];
    couple.rotation[2] = Some(Field::constant(0.0));
    assert!(model.solve().is_ok());
    model.times = vec![1.0, 1.5];
    let told = model.solve_steps().unwrap_err().to_string();
    assert!(
        told.contains("step 2") && told.contains("at point \"P\"") && told.contains("contradict"),
        "{told}"
    );
    assert_eq!(model.check().errors.len(), 1);
}

/// Corrections of an answer know that points do not strain.
#[test]
fn answers_with_couples_are_corrected() {
    let text = r#"analysis = "plane-stress"
[[body]]
name = "b"
mesh = { rectangle = { from = [0, 0], to = [0.546, 0.592], cells = [6, 5] } }
material = { young = 1392.1, poisson = 0.0 }
points = { P = [0.974, 0.932], q4 = [0.364, 0] }
fix = [{ point = "P", x = -0.007542004553460215, y = 0.009766228742009886, rotation = 0.006859896919011869 }]
couple = [{ side = "top", point = "P", kind = "rigid" }]
[[contact]]
name = "c"
nonmortar = "b.bottom"
obstacle = { gap = "0.002 + 0.005845513227377997*(x-0.341)^2" }
friction = 0.3
exclude = ["q4"]
"#;
    let case = Case::<2>::from_str(text, "corrected.toml", "".as_ref());
    let solution = case
        .unwrap_or_else(|e| panic!("{e}"))
        .model
        .solve()
        .unwrap();
    assert!(solution.certificate.holds());
}

/// A body that its point moves, far from what it could touch: nothing bears a force.
#[test]
fn a_body_that_its_point_moves_through_the_air_bears_nothing() {
    for kind in KINDS {
        for friction in [0.0, 0.3] {
            let mut model = Model::new();
            let mesh = rectangle([0.0, 0.0], [0.6, 1.1], [3, 6], CellKind::Quad4);
            let body = model.body("tool", mesh, SOFT);
            let couple = model.couple(body, "top", ("P", [-0.1, 2.0]), kind);
            couple.displacement = [0.004, 0.016].map(|u| Some(Field::constant(u)));
            couple.rotation[2] = Some(Field::constant(-0.009));
            let floor = model.obstacle((body, "bottom"), Field::constant(0.002));
            floor.law = Law::Coulomb(Field::constant(friction));
            let solution = model.solve().unwrap();
            assert!(solution.certificate.holds());
            let nodes = solution.contacts[0].nodes.iter();
            assert!(nodes.into_iter().all(|node| node.status == Status::Open));
            let stress = solution.bodies[0].von_mises.iter();
            // E times the rounding of a displacement over a cell
            assert!(stress.fold(0.0, |s: f64, v| s.max(*v)) < 1e-10);
            let moved = solution.bodies[0].displacement[0];
            // P at rest is (-0.1, 2) from the node (0, 0)
            near(moved[0], 0.004 - 0.009 * 2.0, 1e-12);
            near(moved[1], 0.016 - 0.009 * 0.1, 1e-12);
        }
    }
}

/// Two blocks that do not touch, each with a rigid side; one of them is not loaded.
#[test]
fn what_nothing_loads_does_not_disturb_the_others() {
    let block = |name: &str, at: f64, point: [f64; 3], more: &str| {
        format!(
            "[[body]]\nname = \"{name}\"\n\
             mesh = {{ box = {{ from = [{at}, 0, 0], to = [{}, 1, 1], cells = [1, 1, 1] }} }}\n\
             material = {{ young = 1000, poisson = 0.3 }}\n\
             points = {{ p = {point:?} }}\ncouple = [{{ side = \"right\", point = \"p\", kind = \"rigid\" }}]\n\
             fix = [{{ side = \"left\", x = 0, y = 0, z = 0 }}]\n{more}\n",
            at + 1.0
        )
    };
    let mut random = Random(511);
    for trial in 0..40 {
        let mut near = || [0.0; 3].map(|_| 0.5 + 1.5 * random.signed());
        let (first, second) = (near(), near());
        let load = match trial % 2 {
            0 => "load = [{ point = \"p\", force = [0, -1, 0.3] }]",
            _ => "fix = [{ side = \"left\", x = 0, y = 0, z = 0 }, { point = \"p\", y = -0.01 }]",
        };
        let own = block("own", 0.0, first, load).replacen(
            "fix = [{ side = \"left\", x = 0, y = 0, z = 0 }]\nfix",
            "fix",
            1,
        );
        let solve = |text: String| {
            let text = format!("analysis = \"3d\"\n{text}");
            let case = Case::<3>::from_str(&text, "couples.toml", "".as_ref()).unwrap();
            case.model
                .solve()
                .unwrap_or_else(|error| panic!("{trial}: {error}"))
        };
        let alone = solve(own.clone());
        let both = solve(own + &block("other", 5.0, second, ""));
        assert!(both.converged && both.solver.iterations == alone.solver.iterations);
        let size = alone.bodies[0]
            .displacement
            .iter()
            .map(|u| norm(*u))
            .fold(0.0, f64::max);
        for (a, b) in both.bodies[0]
            .displacement
            .iter()
            .zip(&alone.bodies[0].displacement)
        {
            assert!(distance(*a, *b) < 1e-12 * size, "{trial}: {a:?} {b:?}");
        }
        let still = both.bodies[1].displacement.iter();
        assert!(still.copied().all(|u| u == [0.0; 3]));
    }
}

/// A bar that nothing else holds goes with its turned side, far from the point, and no force is left.
#[test]
fn a_free_body_turns_with_its_point() {
    let mut random = Random(512);
    for trial in 0..10 {
        let point = match trial {
            0 => [10.0, 0.0, 4.0],
            _ => [0.0; 3].map(|_| 10.0 * random.signed()),
        };
        let turn = [0.0; 3].map(|_| 0.3 * random.signed());
        let text = format!(
            "analysis = \"3d\"\n[[body]]\nname = \"bar\"\n\
             mesh = {{ box = {{ from = [0, 0, 0], to = [1, 1, 8], cells = [2, 2, 8], cell = \"hex20\" }} }}\n\
             material = {{ young = 210000, poisson = 0.3 }}\npoints = {{ p = {point:?} }}\n\
             couple = [{{ side = \"right\", point = \"p\", kind = \"rigid\" }}]\n\
             fix = [{{ point = \"p\", x = 0, y = 0, z = 0, rotation = {{ x = {:?}, y = {:?}, z = {:?} }} }}]\n",
            turn[0], turn[1], turn[2]
        );
        let case = Case::<3>::from_str(&text, "turned.toml", "".as_ref()).unwrap();
        let solved = case.model.solve();
        let solved = solved.unwrap_or_else(|error| panic!("{trial}: {error}"));
        assert!(solved.converged);
        let points = case.model.bodies[0].mesh.points().iter();
        for (x, u) in points.zip(&solved.bodies[0].displacement) {
            assert!(distance(*u, cross(turn, sub(*x, point))) < 1e-9, "{u:?}");
        }
    }
}
