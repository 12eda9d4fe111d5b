//! Bodies of revolution: x is the radius, y the axis; forces, weights and resultants are for the full turn.

use dotyk::analytic::hertz::{Sphere, rigid_contact_modulus};
use dotyk::analytic::lame::{PressFit, ThickRing};
use dotyk::analytic::{Material as AnalyticMaterial, Plane};
use dotyk::geometry::{Field, Point};
use dotyk::mesh::{CellKind, Diagonals, Mesh, Rectangle};
use dotyk::model::{
    Analysis, BodyId, Elastic, Error, Gap, Load, Model, Pairing, Reading, Solution, Status,
};
use std::f64::consts::PI;

const KINDS: [CellKind; 5] = [
    CellKind::Tri3,
    CellKind::Tri6,
    CellKind::Quad4,
    CellKind::Quad8,
    CellKind::Quad9,
];
const STEEL: Elastic = Elastic {
    young: 210e3,
    poisson: 0.3,
};

fn rectangle(from: Point<2>, to: Point<2>, cells: [usize; 2], cell: CellKind) -> Mesh<2> {
    let rectangle = Rectangle {
        from,
        to,
        cells,
        cell,
        diagonals: Diagonals::Checkerboard,
    };
    rectangle.build().unwrap()
}

fn model() -> Model<2> {
    let mut model = Model::<2>::new();
    model.analysis = Analysis::Axisymmetric;
    model
}

/// A cylinder or tube with distorted (curved, where quadratic) cells inside and straight sides.
fn distorted(from: Point<2>, to: Point<2>, cell: CellKind) -> Mesh<2> {
    let place = |[x, y]: Point<2>| {
        let bump = (x - from[0]) * (to[0] - x) * (y - from[1]) * (to[1] - y);
        [x + 0.2 * bump * (1.0 - y), y + 0.15 * bump * (x - 0.7)]
    };
    rectangle(from, to, [4, 3], cell).map_points(place).unwrap()
}

/// Two tubes (or cylinders) on each other under a pressure on the top; the upper one floats along the axis.
fn pile(inner: f64, cell: CellKind) -> Model<2> {
    let mut model = model();
    let low = model.body("low", distorted([inner, 0.0], [2.0, 1.0], cell), STEEL);
    let soft = Elastic {
        young: 70e3,
        poisson: 0.25,
    };
    let up = model.body("up", distorted([inner, 1.0], [2.0, 2.5], cell), soft);
    model
        .roller(low, "bottom", 0.0)
        .press(up, "top", 3.0)
        .contact((up, "bottom"), (low, "top"))
        .name = "sole".to_string();
    model
}

#[test]
fn uniform_axial_pressure_passes_through_every_kind_of_cell() {
    for cell in KINDS {
        for inner in [0.0, 0.5] {
            // a quadratic facet gives its node on the axis no weight: it needs another pairing
            let quadratic = !matches!(cell, CellKind::Tri3 | CellKind::Quad4);
            if quadratic && inner == 0.0 {
                continue;
            }
            let model = pile(inner, cell);
            let solution = model.solve().unwrap();
            let area = PI * (4.0 - inner * inner);
            let sole = &solution.contacts[0];
            let total: f64 = sole.nodes.iter().map(|n| n.weight).sum();
            assert!((total - area).abs() < 1e-12 * area);
            assert!((sole.length - (2.0 - inner)).abs() < 1e-12);
            assert!((sole.resultant[1] - 3.0 * area).abs() < 1e-10 * area);
            for node in &sole.nodes {
                assert!(
                    (node.pressure - 3.0).abs() < 1e-10,
                    "{cell:?}: {}",
                    node.pressure
                );
            }
            let reaction = solution.bodies[0].reaction;
            assert!((reaction[1] - 3.0 * area).abs() < 1e-10 * area);
            for (body, given) in solution.bodies.iter().zip(&model.bodies) {
                let Elastic { young, poisson } = given.materials[0].elastic;
                for (stress, (u, x)) in body
                    .stress
                    .iter()
                    .zip(body.displacement.iter().zip(given.mesh.points()))
                {
                    let wanted = [0.0, -3.0, 0.0, 0.0, 0.0, 0.0];
                    let off = stress.iter().zip(wanted).map(|(s, w)| (s - w).abs());
                    // uniform stress: rounding
                    assert!(off.fold(0.0, f64::max) < 1e-9, "{cell:?}: {stress:?}");
                    assert!((u[0] - 3.0 * poisson / young * x[0]).abs() < 1e-14);
                }
            }
            let floating = &solution.bodies[1].floating_modes;
            assert_eq!(floating.len(), 1);
            assert_eq!(floating[0].description, "translation along y");
            let rigid = &solution.bodies[1].rigid;
            assert_eq!((rigid.translation[0], rigid.rotation[0]), (0.0, 0.0));
            assert!(solution.certificate.imbalance_force.relative < 1e-12);
        }
    }
}

#[test]
fn uniform_radial_pressure_is_reproduced_on_the_axis() {
    for cell in KINDS {
        let mut model = model();
        let body = model.body("bar", distorted([0.0, 0.0], [1.5, 1.0], cell), STEEL);
        model.roller(body, "bottom", 0.0).press(body, "right", 2.0);
        let solution = model.solve().unwrap();
        for stress in &solution.bodies[0].stress {
            let wanted = [-2.0, 0.0, -2.0, 0.0, 0.0, 0.0];
            let off = stress.iter().zip(wanted).map(|(s, w)| (s - w).abs());
            // uniform stress: rounding
            assert!(off.fold(0.0, f64::max) < 1e-9, "{cell:?}: {stress:?}");
        }
        // nothing but symmetry holds the bar along its radius
        assert!(solution.bodies[0].reaction[0].abs() < 1e-9);
        let on_axis = |p: &Point<2>| p[0] == 0.0;
        let points = model.bodies[0].mesh.points().iter();
        for (point, u) in points.zip(&solution.bodies[0].displacement) {
            assert!(!on_axis(point) || u[0] == 0.0);
        }
    }
}

#[test]
fn a_quadratic_facet_at_the_axis_is_integrated_because_its_node_has_no_weight() {
    let mut model = pile(0.0, CellKind::Quad9);
    for node in &model.solve().unwrap().contacts[0].nodes {
        // uniform stress: rounding
        assert!(node.weight > 0.0 && (node.pressure - 3.0).abs() < 1e-9);
    }
    model.contacts[0].pairing = Some(Pairing::NodeToNode);
    let message = model.solve().unwrap_err().to_string();
    assert!(
        message.contains("weight") && message.contains("(0, 1)"),
        "{message}"
    );
}

#[test]
fn every_load_counts_for_the_full_turn() {
    let mut model = model();
    let tube = model.body(
        "tube",
        rectangle([1.0, 0.0], [2.0, 3.0], [4, 6], CellKind::Quad4),
        STEEL,
    );
    model.roller(tube, "bottom", 0.0);
    let volume = PI * (4.0 - 1.0) * 3.0;
    model.bodies[0].body_force[1] = Field::constant(-0.4);
    model.pull(tube, "right", [0.0, 0.7]).load(
        tube,
        Load::Force {
            point: [2.0, 3.0],
            force: [0.0, 5.0].map(Field::constant),
        },
    );
    let solution = model.solve().unwrap();
    // weight, shear traction on the outside and a force along the rim
    let load = -0.4 * volume + 0.7 * 2.0 * PI * 2.0 * 3.0 + 5.0;
    let reaction = solution.bodies[0].reaction[1];
    assert!((reaction + load).abs() < 1e-11 * load.abs(), "{reaction}");
}

#[test]
fn a_resultant_on_a_side_is_the_traction_that_is_spread_evenly_over_it() {
    let mesh = || rectangle([1.0, 0.0], [2.0, 3.0], [4, 6], CellKind::Quad9);
    let side = "top".to_string();
    // area of the top: of the full turn, or the width times the thickness
    for (analysis, area) in [
        (Analysis::Axisymmetric, 3.0 * PI),
        (Analysis::PlaneStress, 0.4),
    ] {
        let solve = |load: Load<2>| {
            let mut model = Model::<2>::new();
            model.analysis = analysis;
            let body = model.body("body", mesh(), STEEL);
            if analysis == Analysis::PlaneStress {
                model.bodies[0].thickness = 0.4;
            }
            model.fix(body, "bottom", [None, Some(0.0)]);
            model.fix(body, "left", [Some(0.0), None]);
            model.load(body, load);
            model.times = vec![7.0];
            model.solve().unwrap()
        };
        let field = |value: f64| Field::function("t", move |_, t| value * t);
        let spread = solve(Load::Resultant {
            side: side.clone(),
            force: [field(0.0), field(2.0)],
        });
        let traction = solve(Load::Traction {
            side: side.clone(),
            traction: [field(0.0), field(2.0 / area)],
        });
        let reaction = spread.bodies[0].reaction[1];
        assert!((reaction + 14.0).abs() < 1e-10, "{reaction}");
        let pairs = spread.bodies[0]
            .displacement
            .iter()
            .zip(&traction.bodies[0].displacement);
        let scale = pairs.clone().fold(0.0f64, |m, (_, u)| m.max(u[1].abs()));
        for (a, b) in pairs {
            assert!((0..2).all(|i| (a[i] - b[i]).abs() < 1e-12 * scale));
        }
    }
}

/// Strain energy of a tube under internal pressure, without axial strain.
fn energy(cells: usize, cell: CellKind) -> f64 {
    let mut model = model();
    let mesh = rectangle([20.0, 0.0], [80.0, 30.0], [cells, cells / 2], cell);
    let tube = model.body("tube", mesh, STEEL);
    model
        .roller(tube, "bottom", 0.0)
        .roller(tube, "top", 0.0)
        .press(tube, "left", 100.0);
    model.solve().unwrap().bodies[0].strain_energy
}

#[test]
fn a_thick_tube_converges_to_lame() {
    let ring = ThickRing {
        inner: 20.0,
        outer: 80.0,
        material: AnalyticMaterial {
            young: 210e3,
            poisson: 0.3,
        },
        plane: Plane::Strain,
        inner_pressure: 100.0,
        outer_pressure: 0.0,
    };
    // half the work of the pressure on the bore
    let exact = 0.5 * 100.0 * 2.0 * PI * 20.0 * 30.0 * ring.displacement(20.0);
    for (cell, order) in [
        (CellKind::Tri3, 2.0),
        (CellKind::Quad4, 2.0),
        (CellKind::Tri6, 4.0),
        (CellKind::Quad8, 4.0),
        (CellKind::Quad9, 4.0),
    ] {
        let error = |cells: usize| (energy(cells, cell) - exact).abs() / exact;
        let (coarse, fine) = (error(16), error(32));
        let rate = (coarse / fine).log2();
        // twice the order of the strains
        assert!((rate - order).abs() < 0.1, "{cell:?}: {rate}");
        assert!(fine < 0.01);
    }
}

/// Two tubes of height 10 with an interference, radii 20, 40, 80.
fn press_fit(cells: usize, held_ends: bool) -> Model<2> {
    let mut model = model();
    let tube = |from: f64, to: f64, cells: usize| {
        rectangle([from, 0.0], [to, 10.0], [cells, 2], CellKind::Quad4)
    };
    let inner = model.body("inner", tube(20.0, 40.0, cells), STEEL);
    let outer = model.body("outer", tube(40.0, 80.0, 2 * cells), STEEL);
    for body in [inner, outer] {
        model.roller(body, "bottom", 0.0);
        if held_ends {
            model.roller(body, "top", 0.0);
        }
    }
    let fit = model.contact((inner, "right"), (outer, "left"));
    fit.gap = Some(Gap::Given(Field::constant(-0.04)));
    model
}

#[test]
fn a_press_fit_of_tubes_converges_to_lame_with_free_and_with_held_ends() {
    let material = AnalyticMaterial {
        young: 210e3,
        poisson: 0.3,
    };
    for (held, plane) in [(true, Plane::Strain), (false, Plane::Stress)] {
        let exact = PressFit {
            bore: 20.0,
            radius: 40.0,
            outer: 80.0,
            inner_material: material,
            outer_material: material,
            plane,
            interference: 0.04,
        };
        let solve = |cells: usize| -> Solution<2> { press_fit(cells, held).solve().unwrap() };
        let error = |solution: &Solution<2>| {
            let off = |n: f64| (n / exact.pressure() - 1.0).abs();
            let pressures = solution.contacts[0].nodes.iter().map(|n| off(n.pressure));
            pressures.fold(0.0, f64::max)
        };
        let (coarse, fine) = (solve(8), solve(16));
        let rate = (error(&coarse) / error(&fine)).log2();
        assert!((rate - 2.0).abs() < 0.2, "{rate}");
        assert!(error(&fine) < 2e-3);
        let force = fine.contacts[0].resultant[0];
        let around = 2.0 * PI * 40.0 * 10.0 * exact.pressure();
        // the pressure's error
        assert!((force / -around - 1.0).abs() < 2e-3, "{force}");
        assert!((fine.contacts[0].length - 10.0).abs() < 1e-12);
    }
}

/// Root of a line fitted to p² of the last five loaded nodes.
fn contact_radius(solution: &Solution<2>) -> f64 {
    let mut loaded: Vec<[f64; 2]> = solution.contacts[0]
        .nodes
        .iter()
        .filter(|n| n.status == Status::Closed)
        .map(|n| [n.point[0] * n.point[0], n.pressure * n.pressure])
        .collect();
    loaded.sort_by(|a, b| b[0].total_cmp(&a[0]));
    loaded.truncate(5);
    let mean = |k: usize| loaded.iter().map(|p| p[k]).sum::<f64>() / 5.0;
    let (x, y) = (mean(0), mean(1));
    let both: f64 = loaded.iter().map(|p| (p[0] - x) * (p[1] - y)).sum();
    let slope = both / loaded.iter().map(|p| (p[0] - x).powi(2)).sum::<f64>();
    (x - y / slope).sqrt()
}

/// A block [0, size]² cut out of the half-space below a sphere, with the exact tractions on its cuts.
fn below_a_sphere(exact: Sphere, size: f64, cells: usize, elastic: Elastic) -> Model<2> {
    let mut model = model();
    let mesh = rectangle([0.0, 0.0], [size, size], [cells, cells], CellKind::Quad4);
    let body = model.body("block", mesh, elastic);
    let part = |i: usize| {
        Field::function("Huber", move |[r, z, _], _| {
            exact.stress(r, z, elastic.poisson)[i]
        })
    };
    for (side, traction) in [("right", [part(0), part(3)]), ("top", [part(3), part(2)])] {
        let side = side.to_string();
        model.load(body, Load::Traction { side, traction });
    }
    let radius = exact.a * exact.a / exact.approach;
    let parabola = Field::function("r^2/(2R)", move |[r, ..], _| r * r / (2.0 * radius));
    model.obstacle((body, "bottom"), parabola);
    model
}

#[test]
fn a_sphere_presses_as_hertz_says() {
    // a steel sphere of radius 10 on a steel plane, both deformations given to one body
    let elastic = Elastic {
        young: 105e3,
        poisson: 0.3,
    };
    let material = AnalyticMaterial {
        young: elastic.young,
        poisson: elastic.poisson,
    };
    let exact = Sphere::under_force(1000.0, 10.0, rigid_contact_modulus(material));
    let model = below_a_sphere(exact, 1.0, 80, elastic);
    let solution = model.solve().unwrap();
    let nodes = &solution.contacts[0].nodes;
    let force = solution.contacts[0].resultant[1];
    // the tractions balance the exact force, up to their quadrature
    assert!((force / 1000.0 - 1.0).abs() < 1e-6, "{force}");
    let radius = contact_radius(&solution);
    assert!((radius / exact.a - 1.0).abs() < 0.01, "{radius}");
    let middle = nodes.iter().find(|n| n.point[0] == 0.0).unwrap();
    assert!(
        (middle.pressure / exact.p0 - 1.0).abs() < 0.01,
        "{}",
        middle.pressure
    );
    // the block comes down on the sphere by the approach, and its surface lags behind by what it sinks there
    let corner = nodes.iter().find(|n| n.point[0] == 1.0).unwrap();
    let approach = corner.displacement_nonmortar + exact.depression(1.0, material);
    assert!((approach / exact.approach - 1.0).abs() < 0.01, "{approach}");
}

#[test]
fn what_cannot_be_on_the_axis_is_refused() {
    let mut behind = model();
    let mesh = rectangle([-0.1, 0.0], [1.0, 1.0], [2, 2], CellKind::Quad4);
    let body = behind.body("bar", mesh, STEEL);
    behind.roller(body, "bottom", 0.0);
    let message = behind.solve().unwrap_err().to_string();
    assert!(
        message.contains("negative radius") && message.contains("node 0"),
        "{message}"
    );

    let mut moved = model();
    let mesh = rectangle([0.0, 0.0], [1.0, 1.0], [2, 2], CellKind::Quad4);
    let body = moved.body("bar", mesh, STEEL);
    moved.fix(body, "left", [Some(0.1), Some(0.0)]);
    let error = moved.solve().unwrap_err();
    assert!(matches!(error, Error::Body { .. }));
    let message = error.to_string();
    assert!(
        message.contains("axis") && message.contains("\"left\""),
        "{message}"
    );

    // what agrees with symmetry is welcome, and its reaction belongs to the support
    moved.bodies[0].supports.clear();
    moved
        .fix(body, "left", [Some(0.0), Some(0.0)])
        .press(body, "right", 1.0);
    assert!(moved.solve().is_ok());
}

#[test]
fn a_body_that_nothing_holds_along_the_axis_is_not_held() {
    let mut model = model();
    let mesh = rectangle([0.0, 0.0], [1.0, 1.0], [2, 2], CellKind::Quad4);
    let body = model.body("bar", mesh, STEEL);
    model.press(body, "top", 1.0);
    let error = model.solve().unwrap_err();
    assert!(
        matches!(&error, Error::NotHeld { motion, .. } if motion == "translation along y"),
        "{error}"
    );
}

#[test]
fn means_and_integrals_of_probes_are_those_of_the_volume_and_the_contact() {
    for analysis in [Analysis::Axisymmetric, Analysis::PlaneStrain] {
        for cell in KINDS {
            let mut model = pile(1.0, cell);
            model.analysis = analysis;
            if analysis == Analysis::PlaneStrain {
                let held = model.bodies.iter_mut();
                held.for_each(|body| body.thickness = 0.7);
                model.fix(BodyId(1), "left", [Some(0.0), None]);
                model.fix(BodyId(0), "left", [Some(0.0), None]);
            }
            let contact = model.contacts[0].name.clone();
            let upper = model.bodies[1].name.clone();
            for (name, quantity, reading) in [
                ("force", format!("{contact}.pressure"), Reading::Integral),
                (
                    "mean pressure",
                    format!("{contact}.pressure"),
                    Reading::Mean,
                ),
                ("work", format!("{upper}.stress.yy"), Reading::Integral),
                ("mean stress", format!("{upper}.stress.yy"), Reading::Mean),
                ("most", format!("{upper}.displacement.y"), Reading::Smallest),
            ] {
                model.probe(name, &quantity, reading).unwrap();
            }
            let solution = model.solve().unwrap();
            let probe = |k: usize| solution.probes[k].value;
            let force = solution.contacts[0].resultant[1].abs();
            assert!((probe(0) - force).abs() < 1e-10 * force, "{cell:?}");
            let weights: f64 = solution.contacts[0].nodes.iter().map(|n| n.weight).sum();
            assert!((probe(1) - force / weights).abs() < 1e-10 * probe(1));
            // mean of σyy by the virial of what acts on the body: ∫σyy dV = Σ f_y y
            let body = &solution.bodies[1];
            let points = model.bodies[1].mesh.points();
            let pressed: f64 = force * (top(points) - bottom(points));
            assert!(
                (probe(2) + pressed).abs() < 1e-8 * pressed,
                "{cell:?} {} {pressed}",
                probe(2)
            );
            let volume = probe(2) / probe(3);
            let area = weights;
            assert!((volume - area * (top(points) - bottom(points))).abs() < 1e-9 * volume);
            let lowest = body
                .displacement
                .iter()
                .map(|u| u[1])
                .fold(f64::INFINITY, f64::min);
            assert_eq!(probe(4), lowest);
            let at = solution.probes[4].at.unwrap();
            let node = points.iter().position(|p| *p == at[..2]).unwrap();
            assert_eq!(body.displacement[node][1], lowest);
            assert_eq!(solution.probes[0].at, None);
        }
    }
}

fn top(points: &[Point<2>]) -> f64 {
    points
        .iter()
        .map(|p| p[1])
        .fold(f64::NEG_INFINITY, f64::max)
}

fn bottom(points: &[Point<2>]) -> f64 {
    points.iter().map(|p| p[1]).fold(f64::INFINITY, f64::min)
}

#[test]
fn hoop_stresses_of_a_ring_go_around_its_centre() {
    let (inner, outer, pressure) = (1.0, 2.0, 3.0);
    // Lamé
    let exact = |r: f64| {
        let (a, b) = (inner * inner, outer * outer);
        pressure * a / (b - a) * (1.0 + b / (r * r))
    };
    let mut model = Model::<2>::new();
    let ring = dotyk::mesh::Ring {
        center: [5.0, -2.0],
        inner,
        outer,
        angles: None,
        cells: [64, 16],
        ratio: 1.0,
        grade: 1.0,
        cell: CellKind::Quad8,
        diagonals: Diagonals::Checkerboard,
    };
    let body = model.body("ring", ring.build().unwrap(), STEEL);
    model.press(body, "inner", pressure);
    let support = |point: Point<2>, components: [Option<f64>; 2]| dotyk::model::Support {
        place: dotyk::model::Place::Point(point),
        components: components.map(|c| c.map(Field::constant)),
        normal: None,
        active: Default::default(),
    };
    model.bodies[0].supports = vec![
        support([6.0, -2.0], [None, Some(0.0)]),
        support([4.0, -2.0], [None, Some(0.0)]),
        support([5.0, -1.0], [Some(0.0), None]),
    ];
    let places = [
        [6.0, -2.0],
        [5.0, -0.5],
        [5.0 - 1.5 * 0.6, -2.0 - 1.5 * 0.8],
        [3.0, -2.0],
    ];
    for at in places {
        let probe = model
            .probe("hoop", "ring.stress.hoop", Reading::At(at))
            .unwrap();
        probe.center = [5.0, -2.0];
    }
    let solution = model.solve().unwrap();
    for (probe, [x, y]) in solution.probes.iter().zip(places) {
        let expected = exact((x - 5.0f64).hypot(y + 2.0));
        assert!(
            (probe.value / expected - 1.0).abs() < 5e-3,
            "{} {expected}",
            probe.value
        );
    }
    // of a body of revolution it is that around the axis
    let mut tube = self::model();
    let body = tube.body(
        "tube",
        rectangle([inner, 0.0], [outer, 1.0], [16, 4], CellKind::Quad8),
        STEEL,
    );
    tube.press(body, "left", pressure)
        .roller(body, "bottom", 0.0)
        .roller(body, "top", 0.0);
    for word in ["hoop", "zz"] {
        tube.probe(
            "hoop",
            &format!("tube.stress.{word}"),
            Reading::At([1.5, 0.5]),
        )
        .unwrap();
    }
    let solution = tube.solve().unwrap();
    assert_eq!(solution.probes[0].value, solution.probes[1].value);
    assert!((solution.probes[0].value / exact(1.5) - 1.0).abs() < 5e-3);
}
