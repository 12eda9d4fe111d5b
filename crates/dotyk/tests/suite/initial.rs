//! Bodies with a stress or a strain before anything acts on them: untouched ground, excavation, temperature.
//!
//! Tolerances are rounding unless they say otherwise: nothing in ground at rest, 1e-10 of the largest value elsewhere.

use dotyk::case::Case;
use dotyk::geometry::{Field, Point, norm, sub};
use dotyk::mesh::{CellKind, Cuboid, Diagonals, Mesh, Rectangle, Ring};
use dotyk::model::{
    Analysis, BodyId, Components, Elastic, Error, Formulation, Gap, Initial, Load, Model, Solution,
};

const GROUND: Elastic = Elastic {
    young: 2e9,
    poisson: 0.3,
};

const PLANE: [CellKind; 5] = [
    CellKind::Tri3,
    CellKind::Tri6,
    CellKind::Quad4,
    CellKind::Quad8,
    CellKind::Quad9,
];

/// Weight per volume, and the depth of the origin.
const WEIGHT: f64 = 27e3;
const DEPTH: f64 = 80.0;

/// Ground with a horizontal surface, at rest; its lateral stress is 0.6 in the plane and 0.4 out of it.
fn at_rest<const D: usize>(up: usize, k0: [f64; 2]) -> Initial {
    at_rest_along(std::array::from_fn::<_, D, _>(|i| f64::from(i == up)), k0)
}

/// The same with any vertical, a unit vector.
fn at_rest_along<const D: usize>(up: Point<D>, k0: [f64; 2]) -> Initial {
    let height = move |x: [f64; 3]| (0..D).map(|i| up[i] * x[i]).sum::<f64>();
    let stress = Field::function("-27e3*(80 - y)", move |x, _| -WEIGHT * (DEPTH - height(x)));
    Initial {
        stress: Some(Components::ground(up, stress, k0.map(Field::constant))),
        pore: None,
        strain: None,
        vertical: Some(dotyk::geometry::padded(up)),
    }
}

fn half_ring(cell: CellKind) -> Mesh<2> {
    let ring = Ring {
        center: [0.0, 0.0],
        inner: 5.0,
        outer: 20.0,
        angles: Some([-90.0, 90.0]),
        cells: [8, 3],
        ratio: 1.3,
        grade: 1.0,
        cell,
        diagonals: Diagonals::default(),
    };
    ring.build().unwrap()
}

/// Half of a tunnel in ground with weight: held at its plane of symmetry and, against sinking, at one point.
fn tunnel(cell: CellKind, analysis: Analysis, k0: [f64; 2]) -> (Model<2>, BodyId) {
    let mut model = Model::new();
    model.analysis = analysis;
    let body = model.body("rock", half_ring(cell), GROUND);
    model.bodies[0].body_force = [0.0, -WEIGHT].map(Field::constant);
    model.bodies[0].initial = at_rest::<2>(1, k0);
    model.pin(body, [0.0, -20.0], [None, Some(0.0)]);
    for side in ["start", "end"] {
        model.fix(body, side, [Some(0.0), None]);
    }
    model.in_situ(body, "outer", 1.0);
    (model, body)
}

fn largest<const D: usize>(vectors: &[Point<D>]) -> f64 {
    vectors.iter().map(|&v| norm(v)).fold(0.0, f64::max)
}

/// The excavated ground moves by some millimetres; untouched it does not.
fn untouched<const D: usize>(
    mut model: Model<D>,
    body: BodyId,
    hole: &str,
    solve: fn(&Model<D>) -> Result<Solution<D>, Error<D>>,
) {
    let mut excavated = model.clone();
    excavated.in_situ(body, hole, 0.0);
    let moved = largest(&solve(&excavated).unwrap().bodies[0].displacement);
    assert!(moved > 1e-4, "{moved}");
    model.in_situ(body, hole, 1.0);
    let solution = solve(&model).unwrap();
    let body = &solution.bodies[0];
    assert_eq!(largest(&body.displacement), 0.0, "of {moved}");
    let initial = model.bodies[0].initial.stress.as_ref().unwrap();
    for (stress, &point) in body.stress.iter().zip(model.bodies[0].mesh.points()) {
        for (told, given) in stress.iter().zip(initial.at(point, 1.0)) {
            assert!(
                (told - given).abs() < 1e-9 * WEIGHT * DEPTH,
                "{told} {given}"
            );
        }
    }
    assert!(
        solution.converged && solution.warnings.is_empty(),
        "{:?}",
        solution.warnings
    );
}

#[test]
fn untouched_ground_does_not_move_in_the_plane() {
    for cell in PLANE {
        let (model, body) = tunnel(cell, Analysis::PlaneStrain, [0.6, 0.4]);
        untouched(model, body, "inner", Model::<2>::solve);
        let (mut model, body) = tunnel(cell, Analysis::PlaneStress, [0.6, 0.0]);
        model.bodies[0].thickness = 0.3;
        untouched(model, body, "inner", Model::<2>::solve);
    }
}

#[test]
fn untouched_ground_does_not_move_in_cells_that_bend() {
    let (mut model, body) = tunnel(CellKind::Quad4, Analysis::PlaneStrain, [0.6, 0.4]);
    model.bodies[0].formulation = Formulation::Enhanced;
    untouched(model, body, "inner", Model::<2>::solve);
}

#[test]
fn untouched_ground_does_not_move_around_a_shaft() {
    // a shaft about the axis of symmetry: radial and hoop stress are alike
    for cell in PLANE {
        let mesh = Rectangle {
            from: [2.0, -10.0],
            to: [12.0, 0.0],
            cells: [5, 4],
            cell,
            diagonals: Diagonals::default(),
        };
        let mesh = mesh.build().unwrap();
        // oblique edges, and curved ones where the cells can have them
        let mesh = mesh
            .map_points(|[r, z]| [r + 0.02 * z * z, z + 0.005 * r * z * (z + 10.0)])
            .unwrap();
        let mut model = Model::new();
        model.analysis = Analysis::Axisymmetric;
        let body = model.body("ground", mesh, GROUND);
        model.bodies[0].body_force = [0.0, -WEIGHT].map(Field::constant);
        model.bodies[0].initial = at_rest::<2>(1, [0.6; 2]);
        model.fix(body, "bottom", [None, Some(0.0)]);
        model.in_situ(body, "top", 1.0).in_situ(body, "right", 1.0);
        untouched(model, body, "left", Model::<2>::solve);
    }
}

#[test]
fn untouched_ground_does_not_move_in_space() {
    for cell in [
        CellKind::Tet4,
        CellKind::Tet10,
        CellKind::Hex8,
        CellKind::Hex20,
        CellKind::Hex27,
    ] {
        let mesh = Cuboid {
            from: [0.0; 3],
            to: [10.0; 3],
            cells: [2; 3],
            cell,
        };
        let curved = |[x, y, z]: [f64; 3]| [x + 0.01 * y * z, y + 0.02 * z * z, z - 0.01 * x * y];
        let mesh = mesh.build().unwrap().map_points(curved).unwrap();
        let mut model = Model::new();
        model.analysis = Analysis::Solid;
        let body = model.body("ground", mesh, GROUND);
        model.bodies[0].body_force = [0.0, 0.0, -WEIGHT].map(Field::constant);
        model.bodies[0].initial = at_rest::<3>(2, [0.6, 0.8]);
        model.fix(body, "bottom", [Some(0.0); 3]);
        for side in ["right", "front", "back", "top"] {
            model.in_situ(body, side, 1.0);
        }
        untouched(model, body, "left", Model::<3>::solve);
    }
}

/// The vertical may have any direction: a ring turned by any angle, and a block of space whose vertical is y, or oblique.
#[test]
fn untouched_ground_does_not_move_whatever_its_vertical() {
    let (s, c) = 0.7f64.sin_cos();
    let (mut model, body) = tunnel(CellKind::Quad9, Analysis::PlaneStrain, [0.6, 0.4]);
    let turned = half_ring(CellKind::Quad9).map_points(|[x, y]| [c * x - s * y, s * x + c * y]);
    model.bodies[0].mesh = turned.unwrap().into();
    model.bodies[0].supports.clear();
    model.bodies[0].body_force = [s * WEIGHT, -c * WEIGHT].map(Field::constant);
    model.bodies[0].initial = at_rest_along([-s, c], [0.6, 0.4]);
    model.fix(body, "start", [Some(0.0); 2]);
    // a load in situ is of the stress that the body has when it is said
    model.bodies[0].loads.clear();
    for side in ["outer", "end"] {
        model.in_situ(body, side, 1.0);
    }
    untouched(model, body, "inner", Model::<2>::solve);

    for up in [[0.0, 1.0, 0.0], [0.36, -0.48, 0.8]] {
        let mesh = Cuboid {
            from: [0.0; 3],
            to: [10.0; 3],
            cells: [2; 3],
            cell: CellKind::Hex20,
        };
        let mut model = Model::new();
        model.analysis = Analysis::Solid;
        let body = model.body("ground", mesh.build().unwrap(), GROUND);
        model.bodies[0].body_force = up.map(|n| Field::constant(-WEIGHT * n));
        model.bodies[0].initial = at_rest_along(up, [0.6, 0.8]);
        model.fix(body, "bottom", [Some(0.0); 3]);
        for side in ["right", "front", "back", "top"] {
            model.in_situ(body, side, 1.0);
        }
        untouched(model, body, "left", Model::<3>::solve);
    }
}

#[test]
fn stresses_of_ground_are_principal_along_its_vertical_and_across() {
    // n = (2, −1, 2)/3 and x made horizontal: the largest component of n is the first of the two that are equal
    let n = [2.0, -1.0, 2.0].map(|c: f64| c / 3.0);
    let stress = Components::ground(n, Field::constant(-5.0), [0.6, 0.4].map(Field::constant));
    let rows = |v: Point<3>| stress.traction([0.0; 3], v, 0.0);
    let close = |a: Point<3>, b: Point<3>| norm(sub(a, b)) < 1e-14;
    assert!(close(rows(n), n.map(|c| -5.0 * c)));
    // y without its part along n: (0, 1, 0) + n/3
    let a = [2.0, 8.0, 2.0].map(|c: f64| c / 72f64.sqrt());
    assert!(close(rows(a), a.map(|c| -3.0 * c)), "{:?}", rows(a));
    let b = dotyk::geometry::cross(n, a);
    assert!(close(rows(b), b.map(|c| -2.0 * c)));
    // along an axis the two others come in their order, and nothing is sheared
    for (up, expected) in [
        ([0.0, 0.0, 1.0], [-3.0, -2.0, -5.0]),
        ([0.0, -7.0, 0.0], [-3.0, -5.0, -2.0]),
        ([1.0, 0.0, 0.0], [-5.0, -3.0, -2.0]),
    ] {
        let stress = Components::ground(up, Field::constant(-5.0), [0.6, 0.4].map(Field::constant));
        let [x, y, z] = expected;
        assert_eq!(stress.at([0.0; 3], 0.0), [x, y, z, 0.0, 0.0, 0.0]);
    }
}

/// Excavation is the unstressed ground under what the excavated ground no longer bears: the same displacements, and the stress
/// that was there on top.
/// What stands in ground that is not yet excavated is not pressed, whatever the law between them, wherever the ground lies; and is
/// when it is.
#[test]
fn a_lining_in_untouched_ground_bears_nothing() {
    let laws = [
        "",
        "friction = 0.3",
        "friction = { coulomb = 0.3, cohesion = 0.2, tension = 0.1 }",
        "tied = true",
    ];
    let places = [[0.0, 0.0], [4000.0, -300.0]];
    for (law, [x, y]) in laws.iter().flat_map(|law| places.map(|place| (law, place))) {
        let text = format!(
            "title = \"Lining\"\nanalysis = \"plane-strain\"\n[[step]]\ntime = 0\n[[step]]\ntime = 1\n\
             [[body]]\nname = \"ground\"\nmaterial = {{ young = 500, poisson = 0.3 }}\n\
             mesh = {{ ring = {{ center = [{x}, {y}], inner = 5, outer = 50, cells = [24, 8], ratio = 1.3, cell = \"quad9\" }} }}\n\
             initial_stress = {{ vertical = -1, k0 = 0.5 }}\n\
             load = [{{ side = \"outer\", in_situ = 1 }}, {{ side = \"inner\", in_situ = \"1 - t\" }}]\n\
             fix = [{{ point = [{}, {y}], y = 0 }}, {{ point = [{}, {y}], y = 0 }}, {{ point = [{x}, {}], x = 0 }}]\n\
             [[body]]\nname = \"lining\"\nmaterial = {{ young = 25e3, poisson = 0.2 }}\n\
             mesh = {{ ring = {{ center = [{x}, {y}], inner = 4.7, outer = 5, cells = [24, 2], cell = \"quad9\" }} }}\n\
             [[contact]]\nname = \"back\"\nsides = [\"ground.inner\", \"lining.outer\"]\n{law}\n",
            x + 50.0,
            x - 50.0,
            y + 50.0
        );
        let model = Case::<2>::from_str(&text, "initial.toml", "".as_ref())
            .unwrap()
            .model;
        let steps = model
            .solve_steps()
            .unwrap_or_else(|e| panic!("{law} at {x}: {e}"));
        assert!(steps.iter().all(|step| step.converged));
        let at_rest = &steps[0];
        // a joint that bears tension is at rest to rounding of that
        let none = if law.contains("tension") { 1e-12 } else { 0.0 };
        for body in &at_rest.bodies {
            assert!(largest(&body.displacement) <= none, "{law} at {x}");
        }
        for node in &at_rest.contacts[0].nodes {
            let borne = node.pressure.abs().max(norm(node.shear));
            assert!(borne <= none, "{law} at {x}: {borne:e}");
        }
        let pressed = steps[1].contacts[0].nodes.iter();
        let pressed = pressed.fold(0.0, |s: f64, node| s.max(node.pressure));
        assert!(pressed > 0.5, "{law} at {x}: {pressed}");
    }
}

#[test]
fn excavation_is_a_traction_on_ground_without_stress() {
    for cell in [CellKind::Quad4, CellKind::Tri6] {
        let mesh = Rectangle {
            from: [0.0, 0.0],
            to: [20.0, 10.0],
            cells: [8, 5],
            cell,
            diagonals: Diagonals::default(),
        };
        let mut ground = Model::new();
        let body = ground.body("ground", mesh.build().unwrap(), GROUND);
        ground.fix(body, "bottom", [Some(0.0); 2]);
        let mut bare = ground.clone();
        ground.bodies[0].body_force = [0.0, -WEIGHT].map(Field::constant);
        ground.bodies[0].initial = at_rest::<2>(1, [0.6, 0.4]);
        ground.in_situ(body, "top", 1.0).in_situ(body, "right", 1.0);
        ground.in_situ(body, "left", Field::function("1 - t", |_, t| 1.0 - t));
        // −(1 − factor) σ₀ n with the normal (−1, 0)
        let released = |x: [f64; 3], t: f64| -0.6 * t * WEIGHT * (DEPTH - x[1]);
        let traction = [Field::function("released", released), Field::constant(0.0)];
        let side = "left".to_string();
        bare.load(body, Load::Traction { side, traction });
        for model in [&mut ground, &mut bare] {
            model.times = vec![0.3, 1.0];
        }
        let (steps, expected) = (ground.solve_steps().unwrap(), bare.solve_steps().unwrap());
        let stress = ground.bodies[0].initial.stress.clone().unwrap();
        for (solution, expected) in steps.iter().zip(&expected) {
            let (told, bare) = (&solution.bodies[0], &expected.bodies[0]);
            let scale = largest(&bare.displacement);
            assert!(scale > 1e-4);
            for (a, b) in told.displacement.iter().zip(&bare.displacement) {
                assert!(norm(sub(*a, *b)) < 1e-10 * scale, "{a:?} {b:?}");
            }
            let totals = told.stress.iter().zip(&bare.stress);
            for ((total, more), &point) in totals.zip(ground.bodies[0].mesh.points()) {
                for ((total, more), initial) in total.iter().zip(more).zip(stress.at(point, 0.0)) {
                    let off = (total - more - initial).abs();
                    assert!(off < 1e-10 * WEIGHT * DEPTH, "{total} {more} {initial}");
                }
            }
            // the reaction bears the weight, and the horizontal stress that is gone
            let force = [0.6 * solution.time, 1.0];
            let sizes = [(DEPTH - 5.0) * 10.0, DEPTH * 20.0].map(|area| WEIGHT * area);
            for ((told, part), size) in told.reaction.iter().zip(force).zip(sizes) {
                assert!(
                    (told - part * size).abs() < 1e-10 * sizes[1],
                    "{told} {}",
                    part * size
                );
            }
        }
    }
}

/// A free body that is warmed grows without stress; what keeps it flat in plane strain presses it.
#[test]
fn a_warm_body_grows() {
    let (alpha, change) = (1.2e-5, 40.0);
    let strain = alpha * change;
    for analysis in [
        Analysis::PlaneStrain,
        Analysis::PlaneStress,
        Analysis::Axisymmetric,
    ] {
        for cell in PLANE {
            let mut model = Model::new();
            model.analysis = analysis;
            let mesh = Rectangle {
                from: [1.0, 0.0],
                to: [3.0, 1.0],
                cells: [4, 2],
                cell,
                diagonals: Diagonals::default(),
            };
            let body = model.body("plate", mesh.build().unwrap(), GROUND);
            let change = Field::constant(alpha * change);
            model.bodies[0].initial.strain = Some(Components::isotropic(change));
            model.pin(body, [1.0, 0.0], [None, Some(0.0)]);
            if analysis != Analysis::Axisymmetric {
                model.pin(body, [1.0, 0.0], [Some(0.0), None]);
                model.pin(body, [3.0, 0.0], [None, Some(0.0)]);
            }
            let solution = model.solve().unwrap();
            let (grown, from, along) = match analysis {
                Analysis::PlaneStrain => {
                    ((1.0 + GROUND.poisson) * strain, 1.0, -GROUND.young * strain)
                }
                Analysis::PlaneStress => (strain, 1.0, 0.0),
                _ => (strain, 0.0, 0.0),
            };
            let points = model.bodies[0].mesh.points();
            for (u, x) in solution.bodies[0].displacement.iter().zip(points) {
                let expected = [grown * (x[0] - from), grown * x[1]];
                assert!(
                    norm(sub(*u, expected)) < 1e-11 * strain,
                    "{u:?} {expected:?}"
                );
            }
            let scale = GROUND.young * strain;
            for stress in &solution.bodies[0].stress {
                let expected = [0.0, 0.0, along, 0.0, 0.0, 0.0];
                for (told, expected) in stress.iter().zip(expected) {
                    assert!(
                        (told - expected).abs() < 1e-10 * scale,
                        "{analysis:?} {stress:?}"
                    );
                }
            }
        }
    }
}

/// Held on all sides it cannot grow: −EαΔT/(1 − 2ν) all around, and swelling differs from temperature by its name alone.
#[test]
fn a_warm_body_that_is_held_is_pressed() {
    let mesh = Cuboid {
        from: [0.0; 3],
        to: [1.0; 3],
        cells: [2; 3],
        cell: CellKind::Hex8,
    };
    let mut model = Model::new();
    model.analysis = Analysis::Solid;
    let body = model.body("block", mesh.build().unwrap(), GROUND);
    let strain = Field::function("4e-4*t", |_, t| 4e-4 * t);
    model.bodies[0].initial.strain = Some(Components::isotropic(strain));
    for (side, axis) in [
        ("left", 0),
        ("right", 0),
        ("front", 1),
        ("back", 1),
        ("bottom", 2),
        ("top", 2),
    ] {
        let components = std::array::from_fn(|i| (i == axis).then_some(0.0));
        model.fix(body, side, components);
    }
    model.times = vec![0.0, 0.5, 1.0];
    for solution in model.solve_steps().unwrap() {
        let expected = -2e9 * 4e-4 * solution.time / (1.0 - 0.6);
        for stress in &solution.bodies[0].stress {
            for (c, told) in stress.iter().enumerate() {
                let expected = if c < 3 { expected } else { 0.0 };
                assert!(
                    (told - expected).abs() < 1e-10 * 2e6,
                    "{stress:?} {expected}"
                );
            }
        }
        let top = solution.bodies[0].side_reactions["top"];
        assert!(
            (top[2] - expected).abs() < 1e-10 * 2e6,
            "{top:?} {expected}"
        );
    }
}

/// Two bars end to end between two walls: the warmed one grows into its gap, then both are pressed by
/// (αΔT L − gap)/(2L/E), in plane stress with free sides.
#[test]
fn a_warm_bar_presses_the_next_one() {
    let bar = |from: f64| {
        let rectangle = Rectangle {
            from: [from, 0.0],
            to: [from + 1.0, 0.1],
            cells: [10, 1],
            cell: CellKind::Quad8,
            diagonals: Diagonals::default(),
        };
        rectangle.build().unwrap()
    };
    let cork = Elastic {
        young: 1e9,
        poisson: 0.0,
    };
    let mut model = Model::new();
    model.analysis = Analysis::PlaneStress;
    let (warm, cold) = (
        model.body("warm", bar(0.0), cork),
        model.body("cold", bar(1.0), cork),
    );
    let strain = Field::function("1e-3*t", |_, t| 1e-3 * t);
    model.bodies[0].initial.strain = Some(Components([
        strain.clone(),
        strain.clone(),
        strain,
        Field::constant(0.0),
        Field::constant(0.0),
        Field::constant(0.0),
    ]));
    for (body, side, corner) in [(warm, "left", [0.0, 0.0]), (cold, "right", [2.0, 0.0])] {
        model.fix(body, side, [Some(0.0), None]);
        model.pin(body, corner, [None, Some(0.0)]);
    }
    model.contact((warm, "right"), (cold, "left")).gap = Some(Gap::Given(Field::constant(4e-4)));
    model.times = vec![0.3, 1.0];
    let steps = model.solve_steps().unwrap();
    assert_eq!(steps[0].contacts[0].resultant[0], 0.0);
    let force = -0.1 * 1e9 * (1e-3 - 4e-4) / 2.0;
    let found = steps[1].contacts[0].resultant[0];
    assert!((found / force - 1.0).abs() < 1e-9, "{found} {force}");
    let certified = |solution: &Solution<2>| solution.converged;
    assert!(steps.iter().all(certified));
}

/// Turned by an angle, with its stress and its weight, the ground does the same.
#[test]
fn ground_does_the_same_in_any_direction() {
    let solve = |angle: f64| {
        let (s, c) = angle.sin_cos();
        let mesh = half_ring(CellKind::Quad9);
        let mesh = mesh
            .map_points(|[x, y]| [c * x - s * y, s * x + c * y])
            .unwrap();
        let mut model = Model::new();
        let body = model.body("rock", mesh, GROUND);
        // σ in its own axes x', y': [−3, −1, shear 0.5] MPa
        let [a, b, t] = [-3e6, -1e6, 0.5e6];
        let turned = [
            a * c * c + b * s * s - 2.0 * t * s * c,
            a * s * s + b * c * c + 2.0 * t * s * c,
            -2e6,
            (a - b) * s * c + t * (c * c - s * s),
            0.0,
            0.0,
        ];
        model.bodies[0].initial.stress = Some(Components(turned.map(Field::constant)));
        model.fix(body, "outer", [Some(0.0); 2]);
        for side in ["start", "end"] {
            model.in_situ(body, side, 1.0);
        }
        model.in_situ(body, "inner", 0.25);
        let solution = model.solve().unwrap();
        let back = |[x, y]: [f64; 2]| [c * x + s * y, -s * x + c * y];
        let moved: Vec<[f64; 2]> = solution.bodies[0]
            .displacement
            .iter()
            .copied()
            .map(back)
            .collect();
        (moved, solution.bodies[0].von_mises.clone())
    };
    let (straight, turned) = (solve(0.0), solve(0.7));
    let scale = largest(&straight.0);
    assert!(scale > 1e-4);
    for (a, b) in straight.0.iter().zip(&turned.0) {
        assert!(norm(sub(*a, *b)) < 1e-10 * scale, "{a:?} {b:?}");
    }
    for (a, b) in straight.1.iter().zip(&turned.1) {
        assert!((a - b).abs() < 1e-10 * 3e6, "{a} {b}");
    }
}

fn ground(body: &str) -> String {
    format!(
        "title = \"Ground\"\nanalysis = \"plane-strain\"\n[[body]]\nname = \"rock\"\n\
         mesh = {{ tunnel_rock = {{ radius = 5, half_width = 30, half_height = 30, cells = [24, 8], cell = \"quad9\" }} }}\n\
         material = {{ young = 2e9, poisson = 0.3 }}\n\
         fix = [{{ side = [\"axis\", \"right\"], x = 0 }}, {{ side = \"bottom\", y = 0 }}]\n{body}\n"
    )
}

fn warned(body: &str) -> Vec<String> {
    let case = Case::<2>::from_str(&ground(body), "ground.toml", "".as_ref()).unwrap();
    let solution = case.model.solve().unwrap();
    assert_eq!(
        solution.warnings,
        case.model.check().warnings,
        "a run says what a check would have said"
    );
    solution.warnings
}

#[test]
fn ground_that_moves_by_itself_is_a_warning_with_the_place() {
    let stress = "initial_stress = { vertical = \"-27e3*(80 - y)\", k0 = 0.6 }";
    let load = "load = [{ side = \"hole\", in_situ = 0 }, { side = \"top\", in_situ = 1 }]";
    let weight = "body_force = [0, -27e3]";
    assert_eq!(warned(&[stress, load, weight].join("\n")), [""; 0]);
    // a lining could stand in an excavated hole that no load names
    let top = "load = [{ side = \"top\", in_situ = 1 }]";
    assert_eq!(warned(&[stress, top, weight].join("\n")), [""; 0]);
    for (body, words) in [
        // without weight the ground rises everywhere
        (
            [stress, load, ""],
            "not in equilibrium with its body force: at (",
        ),
        // a free top bears no stress
        ([stress, "", weight], "a nodal force of "),
        (
            [stress, load, "body_force = [0, 27e3]"],
            "and moves the ground; make the stress grow with depth",
        ),
    ] {
        let found = warned(&body.join("\n"));
        assert!(found.len() == 1 && found[0].contains(words), "{found:?}");
    }
}

#[test]
fn a_vertical_that_is_not_the_direction_of_the_weight_is_told_with_both() {
    let load = "load = [{ side = \"hole\", in_situ = 1 }, { side = \"top\", in_situ = 1 }]";
    let stress = |more: &str| {
        format!("initial_stress = {{ vertical = \"-27e3*(80 + x)\", k0 = 0.6{more} }}")
    };
    let weight = "body_force = [27e3, 0]";
    let found = warned(&[&stress(""), load, weight].join("\n"));
    let words = "body \"rock\": the vertical of its initial stress is along (0, 1), its body force along (1, 0)";
    assert!(found.len() == 1 && found[0].starts_with(words), "{found:?}");
    // named, it is: but for the bottom of the mesh, which the stress presses now
    let named = warned(&[&stress(", direction = [-1, 0]"), load, weight].join("\n"));
    assert!(named.iter().all(|w| !w.contains("vertical")), "{named:?}");

    // a profile that is extruded along its tunnel
    let profile = |more: &str, stress: &str| {
        format!(
            "title = \"Profile\"\nanalysis = \"3d\"\n[[body]]\nname = \"rock\"\nmaterial = {{ young = 1e9, poisson = 0.3 }}\n\
             mesh = {{ extrude = {{ mesh = {{ rectangle = {{ from = [0, 0], to = [4, 4], cells = [2, 2], cell = \"quad4\" }} }}, height = 3, layers = 1 }} }}\n\
             fix = [{{ side = [\"bottom\", \"top\", \"left\", \"right\"], x = 0, y = 0, z = 0 }}]\n{more}\n\
             initial_stress = {{ vertical = -1e6, k0 = 0.5{stress} }}\n"
        )
    };
    let told = |text: String| {
        let case = Case::<3>::from_str(&text, "profile.toml", "".as_ref()).unwrap();
        let run = case.run(&[], &mut |_| {});
        run.warnings()
    };
    let about = |warnings: &[String]| warnings.iter().filter(|w| w.contains("vertical")).count();
    let silent = told(profile("", ", direction = [0, 1, 0]"));
    assert_eq!(about(&silent), 0, "{silent:?}");
    let found = told(profile("", ""));
    assert_eq!(about(&found), 1, "{found:?}");
    assert!(
        found
            .iter()
            .any(|w| w.contains("along which its profile is extruded"))
    );
    let found = told(profile("body_force = [0, -27e3, 0]", ""));
    assert_eq!(about(&found), 1, "{found:?}");
    let words =
        "the vertical of its initial stress is along (0, 0, 1), its body force along (0, -1, 0)";
    assert!(found.iter().any(|w| w.contains(words)), "{found:?}");
}

#[test]
fn a_component_out_of_the_plane_is_not_forgotten_in_silence() {
    let load = "load = [{ side = \"hole\", in_situ = 0 }, { side = \"top\", in_situ = 1 }]\n";
    let found = warned(&format!(
        "{load}initial_stress = {{ xx = -1e6, yy = -2e6 }}"
    ));
    assert!(
        found.len() == 1 && found[0].contains("zz of its initial stress"),
        "{found:?}"
    );
    let stress = "initial_stress = { xx = -1e6, yy = -2e6, zz = -1e6, yz = 1e5 }";
    let found = warned(&format!("{load}{stress}"));
    assert!(
        found.len() == 1 && found[0].contains("does not move out of its plane"),
        "{found:?}"
    );
}

#[test]
fn a_plate_grows_across_its_plane_as_its_stress_and_temperature_say() {
    // εzz = αT - ν/E (σxx + σyy): free all round, and held along x
    for (held, wanted) in [("", 1e-3), (", { side = \"right\", x = 0.0 }", 1e-3 * 1.3)] {
        let text = format!(
            "analysis = \"plane-stress\"\n[[body]]\nname = \"plate\"\n\
             mesh = {{ rectangle = {{ from = [0.0, 0.0], to = [2.0, 1.0], cells = [4, 3] }} }}\n\
             material = {{ young = 2e11, poisson = 0.3 }}\ninitial_strain = {{ thermal = 100.0, expansion = 1e-5 }}\n\
             fix = [{{ side = \"left\", x = 0.0 }}, {{ point = [0.0, 0.0], y = 0.0 }}{held}]\n\
             [[probe]]\nname = \"across\"\nquantity = \"plate.strain.zz\"\nat = [1.3, 0.4]\n"
        );
        let case = Case::<2>::from_str(&text, "plate.toml", ".".as_ref()).unwrap();
        let found = case.model.solve().unwrap().probes[0].value;
        assert!(
            (found / wanted - 1.0).abs() < 1e-10,
            "{held}: {found} and not {wanted}"
        );
    }
}
