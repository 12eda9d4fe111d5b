//! Mortar interfaces: patches on non-matching meshes, balance on curved interfaces, true surfaces, ties, obstacles, and
//! rates of convergence.
//!
//! Tolerances are rounding: 1e-10 of the largest value for fields, where nothing else is said.

use crate::norms::{field_error, order, pressure_error};
use dotyk::analytic::Material;
use dotyk::analytic::hertz::{HalfPlane, rigid_contact_modulus};
use dotyk::geometry::{Field, Point, Surface};
use dotyk::mesh::{CellKind, Diagonals, Mesh, Rectangle, Ring};
use dotyk::model::{
    Analysis, BodyId, Elastic, Gap, Law, Load, Model, Motion, Obstacle, Pair, Pairing, Place,
    Rigid, SideRef, Solution, Status, Support,
};

const SOFT: Elastic = Elastic {
    young: 1000.0,
    poisson: 0.3,
};
const STIFF: Elastic = Elastic {
    young: 3000.0,
    poisson: 0.2,
};

/// A block with nodes spread unevenly along its sides, turned by `angle` about the origin.
fn block(from: Point<2>, to: Point<2>, cells: [usize; 2], cell: CellKind, angle: f64) -> Mesh<2> {
    let rectangle = Rectangle {
        from,
        to,
        cells,
        cell,
        diagonals: Diagonals::Checkerboard,
    };
    let width = to[0] - from[0];
    let (s, c) = angle.to_radians().sin_cos();
    let place = move |[x, y]: Point<2>| {
        let t = (x - from[0]) / width;
        let x = from[0] + width * (t + 0.12 * (5.0 * t).sin() * t * (1.0 - t));
        [c * x - s * y, s * x + c * y]
    };
    rectangle.build().unwrap().map_points(place).unwrap()
}

fn roller(model: &mut Model<2>, body: BodyId, side: &str) {
    model.roller(body, side, 0.0);
}

/// Two blocks, 5 against 7 cells, the upper one floating along the normal, pressed by 3 from above.
fn patch(cells: [CellKind; 2], swapped: bool, angle: f64) -> (Model<2>, Solution<2>) {
    let mut model = Model::new();
    let lower = model.body(
        "lower",
        block([0.0, 0.0], [2.0, 1.0], [5, 3], cells[0], angle),
        SOFT,
    );
    let upper = model.body(
        "upper",
        block([0.0, 1.0], [2.0, 2.0], [7, 4], cells[1], angle),
        STIFF,
    );
    for (body, side) in [(lower, "left"), (lower, "bottom"), (upper, "left")] {
        roller(&mut model, body, side);
    }
    model.press(upper, "top", 3.0);
    let sides = [(lower, "top"), (upper, "bottom")];
    let [a, b] = if swapped { [sides[1], sides[0]] } else { sides };
    model.contact(a, b);
    let solution = model.solve().unwrap();
    (model, solution)
}

const KINDS: [CellKind; 5] = [
    CellKind::Tri3,
    CellKind::Tri6,
    CellKind::Quad4,
    CellKind::Quad8,
    CellKind::Quad9,
];

#[test]
fn non_matching_patch_is_exact_for_every_mix_of_cells_and_both_choices() {
    for lower in KINDS {
        for upper in KINDS {
            for swapped in [false, true] {
                let (_, solution) = patch([lower, upper], swapped, 0.0);
                let contact = &solution.contacts[0];
                for node in &contact.nodes {
                    assert!((node.pressure / 3.0 - 1.0).abs() < 1e-10, "{node:?}");
                    assert!(node.weight > 0.0);
                }
                let length: f64 = contact.nodes.iter().map(|n| n.weight).sum();
                assert!((length - 2.0).abs() < 1e-13);
                for stress in solution.bodies.iter().flat_map(|b| &b.stress) {
                    assert!((stress[1] + 3.0).abs() < 3e-10, "{stress:?}");
                    assert!(stress[0].abs() < 3e-10 && stress[3].abs() < 3e-10);
                }
                assert!(contact.imbalance < 1e-13);
            }
        }
    }
}

#[test]
fn patch_does_not_depend_on_the_orientation() {
    let (_, straight) = patch([CellKind::Quad8, CellKind::Tri3], false, 0.0);
    let (_, turned) = patch([CellKind::Quad8, CellKind::Tri3], false, 37.0);
    for (a, b) in straight.contacts[0]
        .nodes
        .iter()
        .zip(&turned.contacts[0].nodes)
    {
        assert!((a.pressure - b.pressure).abs() < 3e-10);
        assert!((a.weight - b.weight).abs() < 1e-13);
    }
    assert!(turned.certificate.holds());
}

/// A body cut in two and tied: both halves held on the left and bottom by rollers, pulled on the top and the right.
fn tied_patch(cells: [CellKind; 2], swapped: bool, angle: f64) -> Solution<2> {
    let mut model = Model::new();
    let lower = model.body(
        "lower",
        block([0.0, 0.0], [2.0, 1.0], [5, 3], cells[0], angle),
        SOFT,
    );
    let upper = model.body(
        "upper",
        block([0.0, 1.0], [2.0, 2.0], [7, 4], cells[1], angle),
        SOFT,
    );
    for (body, side) in [(lower, "left"), (lower, "bottom"), (upper, "left")] {
        roller(&mut model, body, side);
    }
    model.press(upper, "top", -3.0);
    for body in [lower, upper] {
        model.press(body, "right", 1.0);
    }
    let sides = [(lower, "top"), (upper, "bottom")];
    let [a, b] = if swapped { [sides[1], sides[0]] } else { sides };
    model.contact(a, b).law = Law::Tied;
    model.solve().unwrap()
}

#[test]
fn tied_patch_bears_tension_exactly_for_every_mix_of_cells() {
    for lower in KINDS {
        for upper in KINDS {
            let solution = tied_patch([lower, upper], lower == upper, 20.0);
            for node in &solution.contacts[0].nodes {
                assert_eq!(node.status, Status::Tied);
                assert!((node.pressure + 3.0).abs() < 3e-10, "{node:?}");
            }
            let (s, c) = 20f64.to_radians().sin_cos();
            // −1 along the first axis of the block, 3 along the second
            let exact = [-c * c + 3.0 * s * s, -s * s + 3.0 * c * c, -4.0 * s * c];
            for stress in solution.bodies.iter().flat_map(|b| &b.stress) {
                for (computed, exact) in [stress[0], stress[1], stress[3]].iter().zip(exact) {
                    assert!((computed - exact).abs() < 3e-10, "{stress:?}");
                }
            }
        }
    }
}

#[test]
fn tied_halves_shear_like_one_body() {
    // Pure shear: tractions ±τ on the top, bottom and sides, the rigid motions held at single nodes.
    let tau = 2.0;
    let mut model = Model::new();
    let mut bodies = Vec::new();
    for (name, y, n, cell) in [
        ("lower", 0.0, 5, CellKind::Quad4),
        ("upper", 1.0, 7, CellKind::Tri6),
    ] {
        let mesh = block([0.0, y], [2.0, y + 1.0], [n, 3], cell, 0.0);
        let body = model.body(name, mesh, SOFT);
        model.pull(body, "left", [0.0, -tau]);
        model.pull(body, "right", [0.0, tau]);
        bodies.push(body);
    }
    model.pull(bodies[0], "bottom", [-tau, 0.0]);
    model.pull(bodies[1], "top", [tau, 0.0]);
    model.pin(bodies[0], [0.0, 0.0], [Some(0.0), Some(0.0)]);
    model.pin(bodies[0], [2.0, 0.0], [None, Some(0.0)]);
    model.contact((bodies[0], "top"), (bodies[1], "bottom")).law = Law::Tied;
    let solution = model.solve().unwrap();
    for stress in solution.bodies.iter().flat_map(|b| &b.stress) {
        assert!((stress[3] - tau).abs() < 2e-10 && stress[1].abs() < 2e-10);
    }
    for node in &solution.contacts[0].nodes {
        // the lower body is pulled along its tangent, which points along −x
        assert!((node.shear[0] - tau).abs() < 2e-10, "{node:?}");
        assert!(node.pressure.abs() < 2e-10);
    }
}

/// A full ring around a full disc-like ring, meshes turned against each other, pressed by a pressure that depends on the
/// angle and is balanced.
fn two_rings(cell: CellKind, counts: [usize; 2], gap: Option<Gap>) -> Model<2> {
    let ring = |inner: f64, outer: f64, around: usize| Ring {
        center: [0.0, 0.0],
        inner,
        outer,
        angles: None,
        cells: [around, 4],
        ratio: 1.0,
        grade: 1.0,
        cell,
        diagonals: Diagonals::Checkerboard,
    };
    let mut model = Model::new();
    let turn = |angle: f64| {
        let (s, c) = f64::sin_cos(angle);
        move |[x, y]: Point<2>| [c * x - s * y, s * x + c * y]
    };
    let outer = ring(2.0, 3.0, counts[0]).build().unwrap();
    let inner = ring(1.0, 2.0, counts[1]).build().unwrap();
    let outer = model.body("outer", outer, SOFT);
    let inner = model.body("inner", inner.map_points(turn(0.123)).unwrap(), STIFF);
    for (body, side) in [(outer, "outer"), (inner, "inner")] {
        let sign = if side == "outer" { 1.0 } else { 0.3 };
        let pressure = Field::function("3 + cos 2θ", move |p, _| {
            let angle = p[1].atan2(p[0]);
            sign * (3.0 + (2.0 * angle).cos())
        });
        let side = side.to_string();
        model.load(body, Load::Pressure { side, pressure });
    }
    for (point, held) in [
        ([3.0, 0.0], [None, Some(0.0)]),
        ([0.0, 3.0], [Some(0.0), None]),
    ] {
        model.pin(outer, point, held);
    }
    model.pin(outer, [-3.0, 0.0], [None, Some(0.0)]);
    model.contact((outer, "inner"), (inner, "outer")).gap = gap;
    model
}

#[test]
fn forces_and_moments_balance_on_curved_non_matching_interfaces() {
    for cell in KINDS {
        for counts in [[32, 44], [44, 32]] {
            let solution = two_rings(cell, counts, Some(Gap::Closed)).solve().unwrap();
            let contact = &solution.contacts[0];
            assert!(contact.imbalance < 1e-12, "{}", contact.imbalance);
            assert_eq!(
                contact
                    .nodes
                    .iter()
                    .filter(|n| n.status == Status::Open)
                    .count(),
                0
            );
            assert!(solution.certificate.imbalance_moment.relative < 1e-10);
        }
    }
}

#[test]
fn moments_balance_on_tied_polygons_that_do_not_coincide() {
    // A torque on the inner ring goes through the tie into the supports of the outer one.
    for cell in [CellKind::Quad4, CellKind::Tri6] {
        let mut model = two_rings(cell, [20, 26], Some(Gap::Closed));
        model.contacts[0].law = Law::Tied;
        let side = "inner".to_string();
        let traction = [
            Field::function("-y", |p, _| -p[1]),
            Field::function("x", |p, _| p[0]),
        ];
        model.bodies[1].loads = vec![Load::Traction { side, traction }];
        model.bodies[0].loads.clear();
        let solution = model.solve().unwrap();
        let contact = &solution.contacts[0];
        assert!(contact.nodes.iter().any(|n| n.shear[0].abs() > 0.1));
        assert!(contact.imbalance < 1e-12, "{}", contact.imbalance);
    }
}

#[test]
fn a_circle_may_spin_whatever_the_two_polygons_are() {
    // The rows of a spin are exactly zero: what is left would lock the inner ring against the outer like a gear.
    for cell in [CellKind::Quad4, CellKind::Quad9] {
        let solution = two_rings(cell, [32, 44], Some(Gap::Closed))
            .solve()
            .unwrap();
        let told = solution.warnings.iter();
        let told: Vec<_> = told
            .filter(|w| w.contains("rotation") && w.contains("inner"))
            .collect();
        assert_eq!(told.len(), 1, "{:?}", solution.warnings);
    }
}

#[test]
fn gaps_are_measured_between_true_circles() {
    // Clearance of 1e-3 between circles of radius 2 and 2 − 1e-3; the polygons overlap by more than that.
    let mut model = two_rings(CellKind::Quad4, [20, 26], None);
    let smaller =
        Mesh::clone(&model.bodies[1].mesh).map_points(|p| p.map(|c| c * (1.0 - 1e-3 / 2.0)));
    model.bodies[1].mesh = smaller.unwrap().into();
    let smallest = |model: &Model<2>| model.check().contacts[0].clearance;
    let crude = smallest(&model);
    assert!((crude - 1e-3).abs() > 1e-4, "{crude}");
    for (body, side, radius) in [(0, "inner", 2.0), (1, "outer", 2.0 - 1e-3)] {
        let surface = Surface::Sphere {
            center: [0.0, 0.0],
            radius,
        };
        model.bodies[body]
            .surfaces
            .insert(side.to_string(), Some(surface));
    }
    let check = model.check();
    assert!(
        (check.contacts[0].clearance - 1e-3).abs() < 1e-12,
        "{check}"
    );
    assert_eq!(check.contacts[0].penetration, 0.0);
    // quadratic geometry carries its own circle: a parabola through an arc of half-angle φ is Rφ⁴/32 off at most
    let curved = two_rings(CellKind::Quad9, [20, 26], None);
    let off = 2.0 * (std::f64::consts::PI / 20.0).powi(4) / 32.0;
    assert!(smallest(&curved).abs() < off, "{} {off}", smallest(&curved));
}

#[test]
fn nodes_off_their_true_surface_are_an_error() {
    let mut model = two_rings(CellKind::Quad4, [20, 26], None);
    let surface = Surface::Sphere {
        center: [0.1, 0.0],
        radius: 2.0,
    };
    model.bodies[0]
        .surfaces
        .insert("inner".to_string(), Some(surface));
    let message = model.solve().unwrap_err().to_string();
    assert!(
        message.contains("outer.inner") && message.contains("off the `surface`"),
        "{message}"
    );
}

#[test]
fn a_partly_covered_side_weighs_what_is_covered() {
    for cell in KINDS {
        let mut model = Model::new();
        let lower = model.body(
            "lower",
            block([0.0, 0.0], [4.0, 1.0], [9, 3], cell, 0.0),
            SOFT,
        );
        let upper = model.body(
            "upper",
            block([1.1, 1.0], [2.9, 2.0], [5, 3], cell, 0.0),
            SOFT,
        );
        for (body, side) in [(lower, "left"), (lower, "bottom")] {
            roller(&mut model, body, side);
        }
        model.fix(upper, "left", [Some(0.0), None]);
        model.fix(upper, "right", [Some(0.0), None]);
        model.press(upper, "top", 2.0);
        model.contact((lower, "top"), (upper, "bottom"));
        let solution = model.solve().unwrap();
        let contact = &solution.contacts[0];
        assert!(contact.nodes.iter().all(|n| n.weight > 0.0));
        let faced = contact.nodes.iter().filter(|n| !n.gap.is_nan());
        let length: f64 = faced.map(|n| n.weight).sum();
        assert!((length - 1.8).abs() < 1e-12, "{} {length}", cell.name());
        assert!((contact.resultant[1] + 3.6).abs() < 1e-9);
        let alone = contact.nodes.iter().filter(|n| n.gap.is_nan());
        for node in alone {
            assert_eq!((node.pressure, node.status), (0.0, Status::Open));
        }
        assert!(contact.imbalance < 1e-12);
    }
}

#[test]
fn held_nodes_of_the_nonmortar_side_leave_their_share_to_the_neighbours() {
    // The left end of the nonmortar side is clamped: its node is no unknown, and the patch stays exact beside it.
    let mut model = Model::new();
    let lower = model.body(
        "lower",
        block([0.0, 0.0], [2.0, 1.0], [5, 3], CellKind::Quad4, 0.0),
        Elastic {
            young: 1000.0,
            poisson: 0.0,
        },
    );
    let upper = model.body(
        "upper",
        block([0.0, 1.0], [2.0, 2.0], [7, 4], CellKind::Quad9, 0.0),
        STIFF,
    );
    model.fix(lower, "bottom", [Some(0.0), Some(0.0)]);
    roller(&mut model, upper, "left");
    model.press(upper, "top", 3.0);
    // where the patch solution puts this node
    model.pin(lower, [0.0, 1.0], [Some(0.0), Some(-3.0 / 1000.0)]);
    model.contact((lower, "top"), (upper, "bottom"));
    let solution = model.solve().unwrap();
    let contact = &solution.contacts[0];
    let fixed: Vec<_> = contact
        .nodes
        .iter()
        .filter(|n| n.status == Status::Fixed)
        .collect();
    assert_eq!(fixed.len(), 1);
    assert!(fixed[0].pressure.is_nan());
    let rest = contact.nodes.iter().filter(|n| n.status != Status::Fixed);
    let length: f64 = rest.clone().map(|n| n.weight).sum();
    assert!((length - 2.0).abs() < 1e-13);
    for node in rest {
        assert!((node.pressure - 3.0).abs() < 3e-10, "{node:?}");
    }
}

#[test]
fn a_nonmortar_side_that_is_held_altogether_bears_what_the_other_one_gives() {
    let mut model = Model::new();
    let lower = model.body(
        "lower",
        block([0.0, 0.0], [2.0, 1.0], [5, 3], CellKind::Quad4, 0.0),
        SOFT,
    );
    let upper = model.body(
        "upper",
        block([0.0, 1.0], [2.0, 2.0], [7, 4], CellKind::Quad4, 0.0),
        SOFT,
    );
    model.fix(lower, "top", [None, Some(0.0)]);
    model.fix(lower, "left", [Some(0.0), None]);
    roller(&mut model, upper, "left");
    model.press(upper, "top", 3.0);
    model.contact((lower, "top"), (upper, "bottom"));
    let given = model.solve().unwrap();
    let pressures = given.contacts[0].nodes.iter().map(|node| node.pressure);
    assert!(pressures.into_iter().all(|p| (p - 3.0).abs() < 1e-9));
    // chosen automatically, the other side carries the multipliers
    let Pair::Given { nonmortar, mortar } = model.contacts[0].pair.clone() else {
        panic!("two sides");
    };
    model.contacts[0].pair = Pair::Automatic([nonmortar, mortar]);
    let solution = model.solve().unwrap();
    assert!(
        solution.contacts[0]
            .nodes
            .iter()
            .all(|n| (n.pressure - 3.0).abs() < 1e-9)
    );
}

// Rigid obstacles

/// A half disc of radius 1 pressed by its flat top on an obstacle; symmetric about x = 0.
fn pressed(
    mesh: Mesh<2>,
    side: &str,
    top: &str,
    rigid: Rigid<2>,
    pairing: Option<Pairing>,
) -> Model<2> {
    let mut model = Model::new();
    let body = model.body("body", mesh, SOFT);
    model.fix(body, top, [Some(0.0), None]);
    model.press(body, top, 2.0);
    let contact = model.obstacle((body, side), Field::constant(0.0));
    contact.pairing = pairing;
    if let Pair::Obstacle { obstacle, .. } = &mut contact.pair {
        *obstacle = Obstacle {
            shape: rigid,
            motion: Motion::Prescribed([Field::constant(0.0), Field::constant(0.0)]),
        };
    }
    model
}

#[test]
fn a_plane_obstacle_is_the_gap_expression_of_the_same_plane() {
    let mesh = || block([-1.0, 0.0], [1.0, 1.0], [8, 4], CellKind::Quad4, 0.0);
    let plane = |height: f64| Rigid::Surface {
        surface: Surface::Plane {
            point: [5.0, height],
            normal: [0.0, 1.0],
        },
        inside: false,
    };
    let expression = Rigid::Gap(Field::function("y + 0.1", |p, _| p[1] + 0.1));
    let gaps = |rigid: Rigid<2>, pairing| {
        let solution = pressed(mesh(), "bottom", "top", rigid, pairing)
            .solve()
            .unwrap();
        let contact = &solution.contacts[0];
        assert!((contact.resultant[1] - 4.0).abs() < 1e-10);
        contact.nodes.iter().map(|n| n.pressure).collect::<Vec<_>>()
    };
    for pairing in [None, Some(Pairing::Mortar)] {
        let (a, b) = (
            gaps(plane(-0.1), pairing),
            gaps(expression.clone(), pairing),
        );
        for (a, b) in a.iter().zip(&b) {
            assert!((a - b).abs() < 1e-9, "{a} {b}");
        }
    }
}

#[test]
fn a_body_rests_in_a_rigid_groove_and_on_a_rigid_cylinder() {
    let disc = |radius: f64| {
        let ring = Ring {
            center: [0.0, 0.0],
            inner: 0.3 * radius,
            outer: radius,
            angles: Some([-180.0, 0.0]),
            cells: [40, 6],
            ratio: 1.0,
            grade: 1.0,
            cell: CellKind::Quad9,
            diagonals: Diagonals::Checkerboard,
        };
        ring.build().unwrap()
    };
    for (inside, center, radius) in [(true, [0.0, 0.5], 1.5), (false, [0.0, -3.0], 2.0)] {
        let surface = Surface::Sphere { center, radius };
        let rigid = Rigid::Surface { surface, inside };
        let mut model = Model::new();
        let body = model.body("body", disc(1.0), SOFT);
        for side in ["start", "end"] {
            model.fix(body, side, [Some(0.0), None]);
            model.pull(body, side, [0.0, -1.0]);
        }
        let contact = model.obstacle((body, "outer"), Field::constant(0.0));
        if let Pair::Obstacle { obstacle, .. } = &mut contact.pair {
            obstacle.shape = rigid;
        }
        let solution = model.solve().unwrap();
        let contact = &solution.contacts[0];
        assert!(
            (contact.resultant[1] - 1.4).abs() < 1e-9,
            "{:?}",
            contact.resultant
        );
        let bottom = contact
            .nodes
            .iter()
            .find(|n| n.point[0].abs() < 1e-9)
            .unwrap();
        assert!(bottom.pressure > 0.0 && bottom.gap.abs() < 1e-12);
        // held along their normals, where they face anything
        let ends = [&contact.nodes[0], &contact.nodes[contact.nodes.len() - 1]];
        let status = if inside { Status::Fixed } else { Status::Open };
        assert!(ends.iter().all(|n| n.status == status));
    }
}

// Hertz in two mirrored boxes: exact on any box

const CONTACT: HalfPlane = HalfPlane { a: 1.0, p0: 0.1 };
const BOX: Elastic = Elastic {
    young: 1.0,
    poisson: 0.3,
};

/// Two boxes [0, 2] × ±[0, 2] with the exact tractions on the right and at the far ends; the gap is that of two equal
/// parabolas. `cells` per unit length above, three quarters of that below.
fn mirrored_boxes(cell: CellKind, cells: usize) -> Model<2> {
    let mut model = Model::new();
    for (name, sign, n, far) in [
        ("upper", 1.0, 2 * cells, "top"),
        ("lower", -1.0, 3 * cells / 2, "bottom"),
    ] {
        let (low, high) = if sign > 0.0 { (0.0, 2.0) } else { (-2.0, 0.0) };
        let mesh = Rectangle {
            from: [0.0, low],
            to: [2.0, high],
            cells: [n, n],
            cell,
            diagonals: Diagonals::Checkerboard,
        };
        let body = model.body(name, mesh.build().unwrap(), BOX);
        model.fix(body, "left", [Some(0.0), None]);
        let stress = move |p: [f64; 3]| {
            let [xx, yy, xy] = CONTACT.stress(p[0], sign * p[1]);
            [xx, yy, sign * xy]
        };
        let traction = [
            Field::function("Hertz", move |p, _| stress(p)[0]),
            Field::function("Hertz", move |p, _| stress(p)[2]),
        ];
        let side = "right".to_string();
        model.load(body, Load::Traction { side, traction });
        let traction = [
            Field::function("Hertz", move |p, _| sign * stress(p)[2]),
            Field::function("Hertz", move |p, _| sign * stress(p)[1]),
        ];
        let side = far.to_string();
        model.load(body, Load::Traction { side, traction });
    }
    // the exact tractions balance: this holds the height of both boxes and bears nothing
    model.bodies[1].supports.push(Support {
        place: Place::Point([2.0, -2.0]),
        components: [None, Some(Field::constant(0.0))],
        normal: None,
        active: Default::default(),
    });
    let material = Material {
        young: BOX.young,
        poisson: BOX.poisson,
    };
    let radius = 0.5 * CONTACT.a * rigid_contact_modulus(material) / CONTACT.p0;
    let gap = Field::function("two parabolas", move |p, _| p[0] * p[0] / radius);
    model.contact((BodyId(0), "bottom"), (BodyId(1), "top")).gap = Some(Gap::Given(gap));
    model
}

/// Errors of energy and pressure.
fn mirrored_error(cell: CellKind, cells: usize) -> [f64; 2] {
    let model = mirrored_boxes(cell, cells);
    let solution = model.solve().unwrap();
    let Elastic { young, poisson } = BOX;
    let mut squares = 0.0;
    for (body, sign) in [(0, 1.0), (1, -1.0)] {
        let strain = |[x, y]: Point<2>| {
            let [xx, yy, xy] = CONTACT.stress(x, sign * y);
            let (direct, cross) = (
                (1.0 - poisson * poisson) / young,
                -poisson * (1.0 + poisson) / young,
            );
            [
                direct * xx + cross * yy,
                cross * xx + direct * yy,
                sign * 2.0 * (1.0 + poisson) / young * xy,
            ]
        };
        let exact = |p: Point<2>| ([1.0, 0.0], strain(p));
        let u = &solution.bodies[body].displacement;
        squares += field_error(&model.bodies[body].mesh, u, BOX, &exact)
            .energy
            .powi(2);
    }
    let contact = &solution.contacts[0];
    let pressure = pressure_error(contact, cell.order(), |p| CONTACT.pressure(p[0]));
    let energy = (0.5 * squares).sqrt();
    println!(
        "{:<6} h/a = 1/{cells:<4} energy {energy:.4e}  pressure {pressure:.4e}  resultant {:+.1e}  imbalance {:.1e}",
        cell.name(),
        contact.resultant[1] / (0.5 * CONTACT.force()) - 1.0,
        contact.imbalance
    );
    [energy, pressure]
}

fn check_mirrored(cell: CellKind, finest: usize, energy: f64) {
    let [a, b] = [finest / 2, finest].map(|cells| mirrored_error(cell, cells));
    let orders = [order(a[0], b[0]), order(a[1], b[1])];
    println!("orders: energy {:.3}, pressure {:.3}", orders[0], orders[1]);
    assert!(
        orders[0] >= energy,
        "{}: energy order {}",
        cell.name(),
        orders[0]
    );
    assert!(
        orders[1] >= 0.95,
        "{}: pressure order {}",
        cell.name(),
        orders[1]
    );
}

#[test]
fn mirrored_hertz_converges_on_non_matching_linear_cells() {
    check_mirrored(CellKind::Tri3, 128, 0.95);
    check_mirrored(CellKind::Quad4, 64, 0.95);
}

#[test]
fn mirrored_hertz_converges_on_non_matching_quadratic_cells() {
    for cell in [CellKind::Tri6, CellKind::Quad8, CellKind::Quad9] {
        check_mirrored(cell, 32, 1.45);
    }
}

// Obstacles that forces move

/// A block held at its top, and a rigid plane below it that a force presses upwards.
fn pressed_by_a_plate(force: [f64; 2], analysis: Analysis) -> Model<2> {
    let mut model = Model::new();
    model.analysis = analysis;
    let mesh = block([0.0, 0.0], [2.0, 1.0], [5, 3], CellKind::Quad9, 0.0);
    let body = model.body("block", mesh, SOFT);
    model.fix(body, "top", [None, Some(0.0)]);
    if analysis != Analysis::Axisymmetric {
        model.fix(body, "left", [Some(0.0), None]);
    }
    let contact = model.obstacle((body, "bottom"), Field::constant(0.0));
    contact.name = "plate".to_string();
    if let Pair::Obstacle { obstacle, .. } = &mut contact.pair {
        *obstacle = Obstacle {
            shape: Rigid::Surface {
                surface: Surface::Plane {
                    point: [0.0, -0.25],
                    normal: [0.0, 1.0],
                },
                inside: false,
            },
            motion: Motion::Loaded(force.map(Field::constant)),
        };
    }
    model
}

#[test]
fn a_free_rigid_plate_comes_to_rest_where_its_force_is_borne() {
    let solution = pressed_by_a_plate([0.0, 8.0], Analysis::PlaneStress)
        .solve()
        .unwrap();
    let contact = &solution.contacts[0];
    assert!((contact.resultant[1] - 8.0).abs() < 1e-10);
    for node in &contact.nodes {
        assert!((node.pressure - 4.0).abs() < 4e-10, "{node:?}");
        // the plate rises by its clearance and the compression of the block
        assert!((node.displacement_mortar + 0.25 + 4.0 / SOFT.young).abs() < 1e-12);
    }
    // the same force over the full turn of a disc of radius 2
    let area = std::f64::consts::PI * 4.0;
    let round = pressed_by_a_plate([0.0, 4.0 * area], Analysis::Axisymmetric)
        .solve()
        .unwrap();
    for node in &round.contacts[0].nodes {
        assert!((node.pressure - 4.0).abs() < 4e-10, "{node:?}");
    }
}

#[test]
fn a_force_that_pulls_a_plate_away_or_along_itself_is_an_error() {
    for (force, word) in [([0.0, -1.0], "pulls"), ([1.0, 8.0], "x")] {
        let message = pressed_by_a_plate(force, Analysis::PlaneStrain)
            .solve()
            .unwrap_err();
        let message = message.to_string();
        assert!(
            message.contains("obstacle of plate") && message.contains(word),
            "{message}"
        );
    }
    // nothing pulls it along itself: placed by least norm, with a warning
    let solution = pressed_by_a_plate([0.0, 8.0], Analysis::PlaneStrain)
        .solve()
        .unwrap();
    let told = solution
        .warnings
        .iter()
        .filter(|w| w.contains("obstacle of plate"));
    assert_eq!(told.count(), 1, "{:?}", solution.warnings);
}

#[test]
fn crude_polygons_are_told_and_what_to_do() {
    let warned = |model: &Model<2>| {
        let solution = model.solve().unwrap();
        solution
            .warnings
            .iter()
            .any(|w| w.contains("\"closed\"") && w.contains("`surface`"))
    };
    assert!(warned(&two_rings(CellKind::Quad4, [20, 26], None)));
    assert!(!warned(&two_rings(
        CellKind::Quad4,
        [20, 26],
        Some(Gap::Closed)
    )));
    // curved cells miss so little that it counts as closed, which is said as well
    let solution = two_rings(CellKind::Quad9, [20, 26], None).solve().unwrap();
    assert!(
        solution
            .warnings
            .iter()
            .any(|w| w.contains("count as closed"))
    );
    assert!(solution.contacts[0].nodes.iter().all(|n| n.gap < 1e-12));
    // a straight side is no polygon for anything
    let (_, solution) = patch([CellKind::Quad4, CellKind::Quad4], false, 0.0);
    assert_eq!(solution.warnings, Vec::<String>::new());
}

/// A block of equal cells.
fn even(from: Point<2>, to: Point<2>, cells: [usize; 2], cell: CellKind) -> Mesh<2> {
    let rectangle = Rectangle {
        from,
        to,
        cells,
        cell,
        diagonals: Diagonals::Checkerboard,
    };
    rectangle.build().unwrap()
}

/// A block of so many columns whose top, or bottom, follows a profile.
fn profiled(
    [low, high]: [f64; 2],
    columns: usize,
    profile: fn(f64) -> f64,
    upper: bool,
) -> Mesh<2> {
    let rectangle = even([0.0, low], [4.0, high], [columns, 4], CellKind::Quad4);
    let moved = rectangle.map_points(|[x, y]| {
        let part = (y - low) / (high - low);
        let part = if upper { 1.0 - part } else { part };
        [x, y + part * profile(x)]
    });
    moved.unwrap()
}

/// A blunt step, with a flank of 20 degrees, is drawn as it is, and a polygon for a circle is not; neither is told where it does not
/// touch.
#[test]
fn polygons_stand_for_curves_where_they_turn_all_along_and_are_loaded() {
    let step: fn(f64) -> f64 = |x| 0.36 * (x - 1.0).clamp(0.0, 1.0);
    let arch: fn(f64) -> f64 = |x| -0.03 * (x - 2.0).powi(2);
    let flat: fn(f64) -> f64 = |_| 0.0;
    // bends down, and behind that is curved
    let far: fn(f64) -> f64 = |x| -0.2 * (x - 2.0).max(0.0) - 0.1 * (x - 3.0).max(0.0).powi(2);
    let told = |[floor, sole]: [fn(f64) -> f64; 2]| {
        let mut model = Model::new();
        let soft = Elastic {
            young: 1000.0,
            poisson: 0.0,
        };
        let lower = model.body("floor", profiled([-2.0, 0.0], 20, floor, false), soft);
        let upper = model.body("block", profiled([0.0, 2.0], 24, sole, true), soft);
        model.fix(lower, "bottom", [Some(0.0); 2]);
        model.fix(upper, "top", [Some(0.0), Some(-1e-3)]);
        model.contact((lower, "top"), (upper, "bottom")).gap = Some(Gap::Geometric);
        let solution = model.solve().unwrap();
        let words = "polygons stand for curves";
        solution
            .warnings
            .iter()
            .any(|w| w.contains(words) || w.contains("count as closed"))
    };
    assert!(!told([step; 2]));
    assert!(told([arch; 2]));
    assert!(!told([far, flat]));
    // as a curve that touches all along
    assert!(told([far; 2]));
}

/// A block on a wider base whose facets end anywhere under its corners.
fn over_slivers(cells: usize, cell: CellKind, off: f64) -> (Model<2>, [(BodyId, &'static str); 2]) {
    let soft = Elastic {
        young: 100.0,
        poisson: 0.3,
    };
    let mut model = Model::new();
    let (from, to) = ([0.0, 0.0], [4.0, 1.0]);
    let lower = model.body("base", even(from, to, [16, 4], cell), soft);
    let (from, to) = ([1.0 + off, 1.0], [3.0 + off, 2.0]);
    let upper = model.body("block", even(from, to, [cells, 4], cell), soft);
    model.fix(lower, "bottom", [Some(0.0); 2]);
    model.fix(upper, "top", [Some(0.0), Some(-0.05)]);
    (model, [(lower, "top"), (upper, "bottom")])
}

/// The side whose facets end under the corners of the other has pressures that are far too large at slivers, which is said; the
/// other one has none, and carries the multipliers where that is free and it is not much coarser.
#[test]
fn slivers_are_told_or_left_to_the_side_that_has_none() {
    let words = "is that of a node of whose facets";
    let most = |solution: &Solution<2>| {
        let nodes = solution.contacts[0].nodes.iter();
        nodes.fold(0.0, |most: f64, node| most.max(node.pressure))
    };
    let said = |solution: &Solution<2>| solution.warnings.iter().any(|w| w.contains(words));
    for (cell, off, large) in [
        (CellKind::Quad8, 0.24, 40.0),
        (CellKind::Quad8, 0.1, 10.0),
        (CellKind::Quad4, 0.1, 8.0),
    ] {
        let solve = |[first, second]: [(BodyId, &'static str); 2], free: bool, cells: usize| {
            let (mut model, _) = over_slivers(cells, cell, off);
            model.contact(first, second);
            let [one, other] = [first, second].map(|(body, side)| SideRef {
                body,
                side: side.to_string(),
            });
            if free {
                model.contacts[0].pair = Pair::Automatic([one, other]);
            }
            model.solve().unwrap()
        };
        let (_, [base, block]) = over_slivers(7, cell, off);
        let given = solve([base, block], false, 7);
        assert!(said(&given), "{off}");
        let turned = solve([block, base], false, 7);
        assert!(!said(&turned), "{off}");
        let [sliver, plain] = [most(&given), most(&turned)];
        assert!(sliver > large && plain < 6.0, "{off}: {sliver} {plain}");
        let free = solve([base, block], true, 7);
        assert_eq!(most(&free), most(&turned), "{off}");
        // one that is much coarser would see less
        let coarse = solve([base, block], true, 3);
        assert_eq!(coarse.contacts[0].nonmortar.body, base.0);
        assert!(said(&coarse));
        // forces do not depend on it by much
        let force = |solution: &Solution<2>| solution.contacts[0].resultant[1].abs();
        assert!((force(&given) / force(&turned) - 1.0).abs() < 0.02);
    }
}

// Friction on meshes that do not match

#[test]
fn a_node_held_along_the_interface_slips_where_the_other_side_moves() {
    // A block held along x at its left side, a floor that is pulled under it: friction bears 0.3 · 40 = 12.
    let soft = Elastic {
        young: 1000.0,
        poisson: 0.0,
    };
    for (pull, holds) in [(11.9, true), (12.1, false)] {
        for swapped in [false, true] {
            let mut model = Model::new();
            let (from, to) = ([0.0, 0.0], [4.0, 1.0]);
            let upper = model.body("block", block(from, to, [5, 2], CellKind::Quad4, 0.0), soft);
            let (from, to) = ([0.0, -1.0], [4.0, 0.0]);
            let lower = model.body("floor", block(from, to, [7, 2], CellKind::Quad4, 0.0), soft);
            model.fix(upper, "left", [Some(0.0), None]);
            model.fix(lower, "bottom", [None, Some(0.0)]);
            model.press(upper, "top", 10.0);
            model.pull(lower, "right", [pull, 0.0]);
            let sides = [(upper, "bottom"), (lower, "top")];
            let [a, b] = if swapped { [sides[1], sides[0]] } else { sides };
            model.contact(a, b).law = Law::Coulomb(Field::constant(0.3));
            let solved = model.solve();
            assert_eq!(solved.is_ok(), holds, "{pull} {swapped}");
            match solved {
                Ok(solution) => {
                    let force = solution.contacts[0].resultant[0].abs();
                    assert!((force - pull).abs() < 1e-9, "{force}");
                    assert!(solution.contacts[0].dissipated >= 0.0);
                }
                Err(error) => {
                    let message = error.to_string();
                    for word in ["loss of equilibrium", "\"floor\"", "along x", "0.991736"] {
                        assert!(message.contains(word), "no {word} in {message}");
                    }
                }
            }
        }
    }
}
