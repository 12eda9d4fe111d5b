//! Space: rigid motions, patches of every mix of cells, rates, friction and contacts of boxes.
//!
//! Tolerances are rounding unless they say otherwise: 1e-12 of the largest value for fields. Forces under friction: a tenth of
//! what the certificate asks, 1e-9. Where nodes slip their directions are iterated to 1e-8, and they are not quite parallel, so
//! that the resultant is less than the sum of the bounds: 1e-3.

use crate::norms::order;
use dotyk::fem::quadrature::rule;
use dotyk::fem::{Analysis, assemble, describe_motion};
use dotyk::geometry::{Field, Point, Surface, add_scaled, cross, distance, dot, norm, sub};
use dotyk::mesh::{CellKind, Cuboid, MAX_CELL_NODES, Mesh};
use dotyk::model::{
    BodyId, ContactNode, Elastic, Law, Load, Model, Motion, Obstacle, Pair, Pairing, Place,
    Reading, Rigid, SideRef, Solution, Status, Support,
};
use proptest::prelude::*;

const CELLS: [CellKind; 2] = [CellKind::Tet4, CellKind::Hex8];

const SOFT: Elastic = Elastic {
    young: 1000.0,
    poisson: 0.3,
};
const STIFF: Elastic = Elastic {
    young: 2500.0,
    poisson: 0.2,
};
/// It does not contract across a load: what sticks has a uniform stress, too.
const CORK: Elastic = Elastic {
    young: 1000.0,
    poisson: 0.0,
};

/// A rotation, rows are images of the axes.
type Rotation = [Point<3>; 3];

const PLAIN: Rotation = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

/// Rotations about z, then x, then y.
fn rotation([a, b, c]: [f64; 3]) -> Rotation {
    PLAIN.map(|[x, y, z]| {
        let (s, k) = a.sin_cos();
        let [x, y] = [k * x - s * y, s * x + k * y];
        let (s, k) = b.sin_cos();
        let [y, z] = [k * y - s * z, s * y + k * z];
        let (s, k) = c.sin_cos();
        [k * x + s * z, y, k * z - s * x]
    })
}

fn turned(rotation: &Rotation, x: Point<3>) -> Point<3> {
    (0..3).fold([0.0; 3], |sum, d| add_scaled(sum, x[d], rotation[d]))
}

fn turned_back(rotation: &Rotation, x: Point<3>) -> Point<3> {
    rotation.map(|axis| dot(axis, x))
}

/// A box between two corners, its inner nodes moved.
fn distorted(from: Point<3>, to: Point<3>, cells: [usize; 3], cell: CellKind) -> Mesh<3> {
    let cuboid = Cuboid {
        from,
        to,
        cells,
        cell,
    };
    let place = |x: Point<3>| {
        let share: Point<3> = std::array::from_fn(|d| (x[d] - from[d]) / (to[d] - from[d]));
        let inside: f64 = share.iter().map(|s| 4.0 * s * (1.0 - s)).product();
        let wave = [
            share[1] - share[2],
            0.7 * share[2] - share[0],
            0.9 - share[1] - share[0],
        ];
        std::array::from_fn(|d| x[d] + 0.1 * inside * wave[d] * (to[d] - from[d]))
    };
    cuboid.build().unwrap().map_points(place).unwrap()
}

fn turn(mesh: Mesh<3>, rotation: &Rotation) -> Mesh<3> {
    mesh.map_points(|x| turned(rotation, x)).unwrap()
}

#[test]
fn a_free_box_has_six_rigid_motions_that_strain_nothing() {
    for cell in CELLS {
        let mut model = Model::<3>::new();
        let mesh = distorted([0.0; 3], [1.0, 1.2, 0.8], [3, 3, 3], cell);
        model.body("body", mesh, SOFT);
        let system = assemble(&model.bodies[0], Analysis::Solid, 1.0).unwrap();
        assert_eq!(system.modes.len(), 6, "{cell:?}");
        let largest = system.stiffness.diagonal().into_iter().fold(0.0, f64::max);
        for mode in &system.modes {
            let mut force = vec![0.0; mode.len()];
            system.stiffness.mul(mode, &mut force);
            let worst = force.iter().fold(0.0, |s: f64, f| s.max(f.abs()));
            assert!(worst < 1e-13 * largest, "{cell:?} {worst:e}");
        }
        let points = model.bodies[0].mesh.points();
        let words = |motion: &dyn Fn(Point<3>) -> Point<3>| {
            let motion: Vec<Point<3>> = points.iter().map(|&x| motion(x)).collect();
            describe_motion(points, &motion)
        };
        assert_eq!(words(&|_| [0.0, 2.0, 0.0]), "translation along y");
        let (about, screw) = (
            "rotation about z through (0, 0, 0.4)",
            "screw about z through (0, 0, 0.4)",
        );
        assert_eq!(words(&|[x, y, _]| [-y, x, 0.0]), about);
        assert_eq!(words(&|[x, y, _]| [-y, x, 1.0]), screw);
        for mode in &system.modes {
            let longest = mode.chunks(3).map(|u| norm([u[0], u[1], u[2]]));
            assert!((longest.fold(0.0, f64::max) - 1.0).abs() < 1e-14);
        }
        let plane = assemble(&model.bodies[0], Analysis::PlaneStrain, 1.0).err();
        let message = plane.map_or(String::new(), |error| error.to_string());
        assert!(
            message.contains("plane-strain") && message.contains('3'),
            "{message}"
        );
    }
}

// Patches: a lower and an upper box, pressed

const HEIGHTS: [f64; 2] = [0.8, 1.1];
const SIZE: [f64; 2] = [1.0, 1.3];
const PRESSURE: f64 = 3.0;

/// Two boxes on each other; the lower one on rollers.
#[derive(Clone, Copy)]
struct Stack {
    cells: [CellKind; 2],
    rotation: Rotation,
    /// z ↦ −z before the rotation.
    mirrored: bool,
    /// The lower box carries the multipliers.
    swapped: bool,
    /// No support holds the upper box.
    floating: bool,
    /// Number of cells of both.
    counts: [[usize; 3]; 2],
    /// By how much the middles of both are turned about the vertical axis: their facets there are no parallelograms.
    twist: [f64; 2],
    pairing: Option<Pairing>,
}

impl Stack {
    fn of(cell: CellKind) -> Self {
        Self {
            cells: [cell; 2],
            rotation: rotation([0.4, -0.7, 1.1]),
            mirrored: false,
            swapped: false,
            floating: false,
            counts: [[3, 2, 3]; 2],
            twist: [0.0; 2],
            pairing: None,
        }
    }

    /// Points turned about the vertical axis, the more the nearer they are to it.
    fn twisted(angle: f64, [x, y, z]: Point<3>) -> Point<3> {
        let (a, b) = (2.0 * x / SIZE[0] - 1.0, 2.0 * y / SIZE[1] - 1.0);
        let turn = angle * (1.0 - a * a) * (1.0 - b * b);
        let (s, c) = turn.sin_cos();
        let (p, q) = (x - 0.5 * SIZE[0], y - 0.5 * SIZE[1]);
        [
            0.5 * SIZE[0] + c * p - s * q,
            0.5 * SIZE[1] + s * p + c * q,
            z,
        ]
    }

    fn placed(&self, [x, y, z]: Point<3>) -> Point<3> {
        turned(&self.rotation, [x, y, if self.mirrored { -z } else { z }])
    }

    fn model(&self) -> Model<3> {
        let mut model = Model::new();
        let bottoms = [0.0, HEIGHTS[0]];
        let bodies: Vec<BodyId> = [SOFT, STIFF]
            .into_iter()
            .enumerate()
            .map(|(k, elastic)| {
                let from = [0.0, 0.0, bottoms[k]];
                let to = [SIZE[0], SIZE[1], bottoms[k] + HEIGHTS[k]];
                let mesh = distorted(from, to, self.counts[k], self.cells[k]);
                let place = |x| self.placed(Self::twisted(self.twist[k], x));
                let mesh = mesh.map_points(place).unwrap();
                model.body(["lower", "upper"][k], mesh, elastic)
            })
            .collect();
        model.roller(bodies[0], "bottom", 0.0);
        for &body in &bodies[..if self.floating { 1 } else { 2 }] {
            model.roller(body, "left", 0.0).roller(body, "front", 0.0);
        }
        model.press(bodies[1], "top", PRESSURE);
        match self.swapped {
            false => model.contact((bodies[1], "bottom"), (bodies[0], "top")),
            true => model.contact((bodies[0], "top"), (bodies[1], "bottom")),
        };
        model.contacts[0].pairing = self.pairing;
        model
    }

    /// Displacement of a point of a body: uniaxial compression, free to expand across.
    fn exact(&self, body: usize, [x, y, z]: Point<3>) -> Point<3> {
        let Elastic { young, poisson } = [SOFT, STIFF][body];
        let across = poisson * PRESSURE / young;
        let shortened = match body {
            0 => PRESSURE / SOFT.young * z,
            _ => PRESSURE / SOFT.young * HEIGHTS[0] + PRESSURE / young * (z - HEIGHTS[0]),
        };
        self.placed([across * x, across * y, -shortened])
    }

    /// Checks stresses and pressures, and displacements where no body floats, against what is rounding.
    fn check(&self, rounding: f64) {
        let model = self.model();
        let solution = model.solve().unwrap();
        assert!(solution.converged, "{}", solution.certificate.objection());
        let n = self.placed([0.0, 0.0, 1.0]);
        let pairs = [(0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (0, 2)];
        let stress = pairs.map(|(i, j)| -PRESSURE * n[i] * n[j]);
        let back = |x: Point<3>| {
            let [x, y, z] = turned_back(&self.rotation, x);
            [x, y, if self.mirrored { -z } else { z }]
        };
        for (k, (body, solved)) in model.bodies.iter().zip(&solution.bodies).enumerate() {
            let scale = PRESSURE / SOFT.young;
            let both = body.mesh.points().iter().zip(&solved.displacement);
            for (&x, &u) in both.filter(|_| !self.floating) {
                let off = distance(u, self.exact(k, back(x)));
                assert!(off < rounding * scale, "{}: {off:e}", body.name);
            }
            for s in &solved.stress {
                let off = (0..6).map(|c| (s[c] - stress[c]).abs()).fold(0.0, f64::max);
                assert!(off < rounding * PRESSURE, "{}: {off:e}", body.name);
            }
        }
        let contact = &solution.contacts[0];
        let [across, deep, _] = self.counts[usize::from(!self.swapped)];
        assert_eq!(contact.nodes.len(), (across + 1) * (deep + 1));
        for node in &contact.nodes {
            let off = (node.pressure / PRESSURE - 1.0).abs();
            assert!(off < rounding, "{off:e} at {:?}", node.point);
        }
        let area = SIZE[0] * SIZE[1];
        assert!((contact.length - area).abs() < rounding * area);
        let push = if self.swapped {
            -PRESSURE * area
        } else {
            PRESSURE * area
        };
        assert!(distance(contact.resultant, n.map(|c| push * c)) < 10.0 * rounding * PRESSURE);
        assert!(contact.imbalance < 1e-13);
    }
}

#[test]
fn patches_of_two_boxes_have_a_constant_stress_whatever_way_they_are_turned() {
    for cell in CELLS {
        let stack = Stack::of(cell);
        stack.check(1e-12);
        for (mirrored, swapped) in [(true, false), (false, true), (true, true)] {
            Stack {
                mirrored,
                swapped,
                ..stack
            }
            .check(1e-12);
        }
        // normals along every axis, either way
        for k in 0..4 {
            let quarter = f64::from(k) * std::f64::consts::FRAC_PI_2;
            for angles in [[0.0, quarter, 0.0], [0.0, 0.0, quarter]] {
                let rotation = rotation(angles);
                Stack { rotation, ..stack }.check(1e-12);
            }
        }
    }
}

#[test]
fn a_floating_box_is_carried_by_pressure_and_contact_alone() {
    for cell in CELLS {
        let stack = Stack {
            floating: true,
            ..Stack::of(cell)
        };
        stack.check(1e-12);
        let solution = stack.model().solve().unwrap();
        assert_eq!(solution.bodies[1].floating_modes.len(), 6);
        // it may slide and spin on the lower box: three motions that nothing drives
        assert_eq!(solution.warnings.len(), 3, "{:?}", solution.warnings);
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(8))]
    #[test]
    fn patches_are_exact_under_any_rotation(a in -3.0..3.0, b in -3.0..3.0, c in -3.0..3.0) {
        let rotation = rotation([a, b, c]);
        Stack { rotation, ..Stack::of(CellKind::Tet4) }.check(1e-12);
    }
}

#[test]
fn patches_of_boxes_that_do_not_match_have_a_constant_stress() {
    let rotation = rotation([0.4, -0.7, 1.1]);
    for lower in CellKind::of_dimension(3) {
        for upper in CellKind::of_dimension(3) {
            for counts in [[[2, 2, 2], [2, 3, 1]], [[1, 1, 1], [3, 2, 1]]] {
                for swapped in [false, true] {
                    let stack = Stack {
                        cells: [lower, upper],
                        counts,
                        swapped,
                        rotation,
                        pairing: Some(Pairing::Mortar),
                        ..Stack::of(lower)
                    };
                    // rounding of cuts beside that of solving
                    stack.check(1e-11);
                }
            }
        }
    }
}

#[test]
fn patches_are_constant_where_facets_are_no_parallelograms() {
    let rotation = rotation([0.4, -0.7, 1.1]);
    for cells in [[0, 0], [0, 1], [1, 0], [1, 1]].map(|kinds| kinds.map(|k: usize| CELLS[k])) {
        for counts in [[[3, 2, 3]; 2], [[1, 1, 2], [4, 5, 2]]] {
            for swapped in [false, true] {
                let stack = Stack {
                    cells,
                    counts,
                    swapped,
                    rotation,
                    pairing: Some(Pairing::Mortar),
                    twist: [0.2, -0.35],
                    ..Stack::of(cells[0])
                };
                // shape functions of such quadrilaterals are integrated to nine digits
                stack.check(1e-9);
            }
        }
    }
}

#[test]
fn facets_that_differ_are_refused_where_nodes_are_asked_for() {
    // a shifted box: no node has a partner
    let mut shifted = Stack::of(CellKind::Hex8).model();
    let along = Mesh::clone(&shifted.bodies[1].mesh);
    let shift = turned(&rotation([0.4, -0.7, 1.1]), [0.1, 0.0, 0.0]);
    shifted.bodies[1].mesh = along
        .map_points(|x| add_scaled(x, 1.0, shift))
        .unwrap()
        .into();
    shifted.contacts[0].pairing = Some(Pairing::NodeToNode);
    let said = shifted.solve().unwrap_err().to_string();
    assert!(said.contains("coincides with none of its nodes"), "{said}");
    assert!(said.contains("upper.bottom"), "{said}");
}

#[test]
fn an_edge_has_a_condition_for_each_of_its_faces() {
    let rotation = rotation([0.3, 0.5, -0.2]);
    for cell in CELLS {
        let mesh = distorted([0.0; 3], [1.0; 3], [3, 3, 3], cell);
        let on = |x: Point<3>| x.contains(&0.0);
        let mesh = turn(mesh.with_side("all", on), &rotation);
        let mut model = Model::new();
        let body = model.body("body", mesh, SOFT);
        for (side, pressure) in [("right", 1.0), ("back", 2.0), ("top", 3.0)] {
            model.press(body, side, pressure);
        }
        model.obstacle((body, "all"), Field::constant(0.0));
        let solution = model.solve().unwrap();
        let nodes = &solution.contacts[0].nodes;
        assert_eq!(nodes.len(), 3 * 16, "{cell:?}");
        for node in nodes {
            let normal = turned_back(&rotation, node.normal);
            let axis = (0..3).find(|&d| (normal[d] + 1.0).abs() < 1e-12);
            let pressure = [1.0, 2.0, 3.0][axis.unwrap()];
            assert!(
                (node.pressure - pressure).abs() < 1e-11,
                "{cell:?} {node:?}"
            );
        }
    }
}

// Rates

/// A smooth displacement with its gradient ∂uᵢ/∂xⱼ and divergence of stress, from waves aᵢ sin(kᵢ·x + cᵢ).
fn waves(x: Point<3>) -> (Point<3>, [Point<3>; 3], Point<3>) {
    let (lambda, mu) = lame(SOFT);
    let amplitude = [1.0, 0.8, 0.9];
    let k = [[1.1, 0.7, -0.5], [0.4, 1.2, 0.6], [-0.8, 0.5, 1.0]];
    let c = [0.3, 1.0, -0.4];
    let phase: Point<3> = std::array::from_fn(|i| dot(k[i], x) + c[i]);
    let u = std::array::from_fn(|i| amplitude[i] * phase[i].sin());
    let gradient = std::array::from_fn(|i| k[i].map(|kj| amplitude[i] * kj * phase[i].cos()));
    let balance = std::array::from_fn(|i| {
        let divergence: f64 = (0..3)
            .map(|l| -amplitude[l] * k[l][l] * k[l][i] * phase[l].sin())
            .sum();
        (lambda + mu) * divergence - mu * amplitude[i] * dot(k[i], k[i]) * phase[i].sin()
    });
    (u, gradient, balance)
}

fn lame(elastic: Elastic) -> (f64, f64) {
    let Elastic { young, poisson } = elastic;
    let mu = young / (2.0 * (1.0 + poisson));
    (2.0 * mu * poisson / (1.0 - 2.0 * poisson), mu)
}

fn traction(gradient: [Point<3>; 3], n: Point<3>) -> Point<3> {
    let (lambda, mu) = lame(SOFT);
    let trace: f64 = (0..3).map(|i| gradient[i][i]).sum();
    std::array::from_fn(|i| {
        let shear: f64 = (0..3)
            .map(|j| mu * (gradient[i][j] + gradient[j][i]) * n[j])
            .sum();
        lambda * trace * n[i] + shear
    })
}

type Exact = fn(Point<3>) -> (Point<3>, [Point<3>; 3], Point<3>);

fn fields(f: impl Fn(Point<3>) -> Point<3> + Clone + Send + Sync + 'static) -> [Field; 3] {
    [0, 1, 2].map(|i| {
        let f = f.clone();
        Field::function("exact", move |x, _| f(x)[i])
    })
}

/// Adds a body with the loads of an exact solution, held on some sides and pulled on others.
fn exact_body(
    model: &mut Model<3>,
    name: &str,
    mesh: Mesh<3>,
    exact: Exact,
    held: &[&str],
    pulled: &[(&str, Point<3>)],
) -> BodyId {
    let body = model.body(name, mesh, SOFT);
    model.bodies[body.0].body_force = fields(move |x| exact(x).2.map(|c| -c));
    for side in held {
        model.bodies[body.0].supports.push(Support {
            place: Place::Side(side.to_string()),
            components: fields(move |x| exact(x).0).map(Some),
            normal: None,
            active: Default::default(),
        });
    }
    for &(side, n) in pulled {
        let traction = fields(move |x| traction(exact(x).1, n));
        let side = side.to_string();
        model.load(body, Load::Traction { side, traction });
    }
    body
}

/// Errors of all bodies in the mean of the displacement and of its gradient.
fn errors(model: &Model<3>, solution: &Solution<3>, exact: Exact) -> [f64; 2] {
    let mut sums = [0.0; 2];
    for (body, solved) in model.bodies.iter().zip(&solution.bodies) {
        let mesh = &body.mesh;
        let block = &mesh.blocks()[0];
        let rule = rule(block.kind, 2 * block.kind.order() + 2);
        for cell in block.cells() {
            for point in &rule {
                let (mut shape, mut slopes) = ([0.0; MAX_CELL_NODES], [[0.0; 3]; MAX_CELL_NODES]);
                block.kind.shape(&point.xi, &mut shape);
                block.kind.gradients(&point.xi, &mut slopes);
                // columns ∂x/∂ξ and ∂u/∂ξ
                let (mut x, mut u) = ([0.0; 3], [0.0; 3]);
                let (mut dx, mut du) = ([[0.0; 3]; 3], [[0.0; 3]; 3]);
                for (a, &node) in cell.iter().enumerate() {
                    let (at, moved) = (
                        mesh.points()[node as usize],
                        solved.displacement[node as usize],
                    );
                    x = add_scaled(x, shape[a], at);
                    u = add_scaled(u, shape[a], moved);
                    for d in 0..3 {
                        dx[d] = add_scaled(dx[d], slopes[a][d], at);
                        du[d] = add_scaled(du[d], slopes[a][d], moved);
                    }
                }
                let det = dot(cross(dx[0], dx[1]), dx[2]);
                let dual = [
                    cross(dx[1], dx[2]),
                    cross(dx[2], dx[0]),
                    cross(dx[0], dx[1]),
                ];
                let (value, gradient, _) = exact(x);
                let slope: f64 = (0..3)
                    .map(|i| {
                        let own = (0..3)
                            .fold([0.0; 3], |sum, d| add_scaled(sum, du[d][i] / det, dual[d]));
                        dot(sub(own, gradient[i]), sub(own, gradient[i]))
                    })
                    .sum();
                let off = sub(u, value);
                sums[0] += point.weight * det * dot(off, off);
                sums[1] += point.weight * det * slope;
            }
        }
    }
    sums.map(f64::sqrt)
}

fn check_rates(what: &str, cell: CellKind, error: impl Fn(usize) -> [f64; 2]) {
    let finest = [16, 8][cell.order() - 1];
    let (coarse, fine) = (error(finest / 2), error(finest));
    for (k, norm) in ["L2", "H1"].iter().enumerate() {
        let rate = order(coarse[k], fine[k]);
        println!("{what} {:<5} {norm} {:.2e} {rate:.3}", cell.name(), fine[k]);
        let theory = (cell.order() + 1 - k) as f64;
        assert!(
            (rate - theory).abs() < 0.1,
            "{what} {cell:?} {norm}: {rate}"
        );
    }
}

#[test]
fn smooth_fields_converge() {
    for cell in CellKind::of_dimension(3) {
        check_rates("smooth", cell, |n| {
            let mesh = distorted([0.0; 3], [1.0; 3], [n; 3], cell);
            let mut model = Model::new();
            let held = ["left", "front", "bottom", "top"];
            let pulled = [("right", [1.0, 0.0, 0.0]), ("back", [0.0, 1.0, 0.0])];
            exact_body(&mut model, "body", mesh, waves, &held, &pulled);
            errors(&model, &model.solve().unwrap(), waves)
        });
    }
}

/// A displacement that is even along x and y and odd along z about z = 1, so that no shear crosses that plane; it is pressed.
fn pressed(x: Point<3>) -> (Point<3>, [Point<3>; 3], Point<3>) {
    let (lambda, mu) = lame(SOFT);
    let (sx, cx) = (0.9 * x[0] + 0.2).sin_cos();
    let (sy, cy) = (1.1 * x[1] - 0.3).sin_cos();
    let (sz, cz) = (0.8 * (x[2] - 1.0)).sin_cos();
    let (a, b, c) = (0.9, 1.1, 0.8);
    // u = (A sx cy cz, B cx sy cz, −C (2 + cx cy) sz)
    let (p, q, r) = (0.2, 0.3, 1.0);
    let w = 2.0 + cx * cy;
    let u = [p * sx * cy * cz, q * cx * sy * cz, -r * w * sz];
    let gradient = [
        [
            p * a * cx * cy * cz,
            -p * b * sx * sy * cz,
            -p * c * sx * cy * sz,
        ],
        [
            -q * a * sx * sy * cz,
            q * b * cx * cy * cz,
            -q * c * cx * sy * sz,
        ],
        [r * a * sx * cy * sz, r * b * cx * sy * sz, -r * c * w * cz],
    ];
    // div u = (s cx cy − 2 r c) cz
    let s = p * a + q * b - r * c;
    let divergence = [
        -s * a * sx * cy * cz,
        -s * b * cx * sy * cz,
        -(s * cx * cy - 2.0 * r * c) * c * sz,
    ];
    let k = a * a + b * b + c * c;
    let laplace = [-k * u[0], -k * u[1], r * (k * cx * cy + 2.0 * c * c) * sz];
    let balance = std::array::from_fn(|i| (lambda + mu) * divergence[i] + mu * laplace[i]);
    (u, gradient, balance)
}

#[test]
fn two_boxes_in_contact_converge_like_one() {
    for cell in CELLS {
        check_rates("contact", cell, |n| {
            let mut model = Model::new();
            let half = |z: f64, bottom: f64| {
                distorted([0.0, 0.0, z], [1.0, 1.0, z + 0.5], [n, n, n / 2], cell)
                    .map_points(|x| [x[0], x[1], x[2] + bottom])
                    .unwrap()
            };
            let pulled = [("right", [1.0, 0.0, 0.0]), ("back", [0.0, 1.0, 0.0])];
            let (lower, upper) = (half(0.5, 0.0), half(1.0, 0.0));
            let held = ["left", "front", "bottom"];
            let lower = exact_body(&mut model, "lower", lower, pressed, &held, &pulled);
            let held = ["left", "front", "top"];
            let upper = exact_body(&mut model, "upper", upper, pressed, &held, &pulled);
            model.contact((upper, "bottom"), (lower, "top"));
            let solution = model.solve().unwrap();
            let touching = solution.contacts[0]
                .nodes
                .iter()
                .filter(|n| n.status == Status::Closed);
            assert!(touching.count() >= n * n);
            errors(&model, &solution, pressed)
        });
    }
}

// Friction

const FRICTION: f64 = 0.3;

/// A box under a uniform pressure and a shear of a direction in the plane of contact, on a rough obstacle.
fn sheared(cell: CellKind, shear: f64, angle: f64, rotation: &Rotation) -> Model<3> {
    let mut model = Model::new();
    let mesh = distorted([0.0; 3], [1.0, 1.0, 0.5], [3, 3, 2], cell);
    let body = model.body("body", turn(mesh, rotation), CORK);
    let [x, y] = [shear * angle.cos(), shear * angle.sin()];
    for (side, t) in [
        ("top", [x, y, -PRESSURE]),
        ("right", [0.0, 0.0, x]),
        ("left", [0.0, 0.0, -x]),
        ("back", [0.0, 0.0, y]),
        ("front", [0.0, 0.0, -y]),
    ] {
        model.pull(body, side, turned(rotation, t));
    }
    let contact = model.obstacle((body, "bottom"), Field::constant(0.0));
    contact.law = Law::Coulomb(Field::constant(FRICTION));
    model
}

#[test]
fn what_is_sheared_less_than_friction_bears_sticks_in_any_direction() {
    for cell in CELLS {
        for (angle, angles) in [
            (0.0, [0.0; 3]),
            (0.7, [0.3, 0.2, -0.9]),
            (2.5, [1.0, -2.0, 0.5]),
        ] {
            let rotation = rotation(angles);
            let shear = 0.95 * FRICTION * PRESSURE;
            let solution = sheared(cell, shear, angle, &rotation).solve().unwrap();
            let expected = [-shear * angle.cos(), -shear * angle.sin(), 0.0];
            for node in &solution.contacts[0].nodes {
                assert_eq!(node.status, Status::Stick);
                assert!(
                    (node.pressure - PRESSURE).abs() < 1e-9 * PRESSURE,
                    "{node:?}"
                );
                let own = turned_back(&rotation, node.shear);
                assert!(
                    distance(own, expected) < 1e-9 * PRESSURE,
                    "{own:?} {expected:?}"
                );
            }
            let beyond = sheared(cell, 1.02 * FRICTION * PRESSURE, angle, &rotation);
            let message = beyond.solve().unwrap_err().to_string();
            assert!(message.contains("slides"), "{message}");
        }
    }
}

/// A box whose top is held and pressed down, on a rough base that is dragged along; the base a box, too, or an obstacle.
fn dragged(cell: CellKind, base: bool, angle: f64, rotation: &Rotation) -> Model<3> {
    let mut model = Model::new();
    let mesh = |z: f64| {
        turn(
            distorted([0.0, 0.0, z], [1.0, 1.0, z + 0.3], [3, 3, 2], cell),
            rotation,
        )
    };
    let body = model.body("body", mesh(0.0), SOFT);
    let hold = |u: Point<3>| turned(rotation, u).map(Some);
    model.fix(body, "top", hold([0.0, 0.0, -1e-3]));
    let drag = [0.1 * angle.cos(), 0.1 * angle.sin(), 0.0];
    if base {
        let base = model.body("base", mesh(-0.3), STIFF);
        model.fix(base, "bottom", hold(drag));
        model.contact((body, "bottom"), (base, "top"));
    } else {
        model.contact((body, "bottom"), (body, "bottom"));
        let shape = Rigid::Surface {
            surface: Surface::Plane {
                point: [0.0; 3],
                normal: rotation[2],
            },
            inside: false,
        };
        let motion = Motion::Prescribed(turned(rotation, drag).map(Field::constant));
        model.contacts[0].pair = Pair::Obstacle {
            nonmortar: SideRef {
                body,
                side: "bottom".to_string(),
            },
            obstacle: Obstacle { shape, motion },
        };
    }
    model.contacts[0].law = Law::Coulomb(Field::constant(FRICTION));
    model
}

#[test]
fn what_is_dragged_slips_along_the_drag_and_bears_what_friction_can() {
    for cell in CELLS {
        for base in [false, true] {
            for (angle, angles) in [(0.4, [0.0; 3]), (2.1, [0.3, 0.2, -0.9])] {
                let rotation = rotation(angles);
                let solution = dragged(cell, base, angle, &rotation).solve().unwrap();
                let contact = &solution.contacts[0];
                let along = [angle.cos(), angle.sin(), 0.0];
                for node in contact.nodes.iter().filter(|node| node.pressure > 0.0) {
                    assert_eq!(node.status, Status::Slip);
                    let own = turned_back(&rotation, node.shear);
                    assert!((norm(own) - FRICTION * node.pressure).abs() < 1e-6 * norm(own));
                    // the box gives way by a hundredth of the drag
                    assert!(dot(own, along) > 0.999 * norm(own), "{own:?} {along:?}");
                }
                let [x, y, pressing] = turned_back(&rotation, contact.resultant);
                let shear = x.hypot(y);
                assert!((shear - FRICTION * pressing).abs() < 1e-3 * shear);
                assert!(contact.imbalance < 1e-12);
                assert!(contact.dissipated > 0.0);
            }
        }
    }
}

#[test]
fn friction_does_not_depend_on_how_the_whole_is_turned() {
    // the tangents at the nodes are others in each position
    for base in [false, true] {
        let solve = |angles: [f64; 3]| {
            let rotation = rotation(angles);
            let solution = dragged(CellKind::Hex8, base, 0.9, &rotation)
                .solve()
                .unwrap();
            let nodes = solution.contacts[0].nodes.iter();
            let own = nodes.map(|n| (n.pressure, turned_back(&rotation, n.shear)));
            own.collect::<Vec<_>>()
        };
        let plain = solve([0.0; 3]);
        let largest = plain.iter().fold(0.0, |s: f64, n| s.max(n.0));
        for angles in [
            [0.1, 0.0, 0.0],
            [0.8, -1.3, 0.4],
            [0.0, std::f64::consts::PI, 2.0],
        ] {
            for ((p, shear), (q, other)) in plain.iter().zip(solve(angles)) {
                // slips are iterated to 1e-8
                assert!((p - q).abs() < 1e-6 * largest, "{p} {q}");
                assert!(
                    distance(*shear, other) < 1e-6 * largest,
                    "{shear:?} {other:?}"
                );
            }
        }
    }
}

#[test]
fn forces_and_moments_of_a_contact_balance_the_load() {
    for cell in CELLS {
        let rotation = rotation([0.5, 0.9, -0.4]);
        let mut model = Model::new();
        let mesh = distorted([0.0; 3], [1.0, 1.2, 0.6], [4, 4, 3], cell);
        let corner = |x: Point<3>| x[2] == 0.6 && x[0] < 0.55 && x[1] < 0.65;
        let mesh = turn(mesh.with_side("corner", corner), &rotation);
        let body = model.body("body", mesh, SOFT);
        let push = turned(&rotation, [0.3, -0.2, -2.0]);
        model.pull(body, "corner", push);
        let contact = model.obstacle((body, "bottom"), Field::constant(0.0));
        contact.law = Law::Coulomb(Field::constant(FRICTION));
        let solution = model.solve().unwrap();
        let nodes = &solution.contacts[0].nodes;
        assert!(nodes.iter().any(|n| n.status == Status::Open), "{cell:?}");
        // the loaded quarter: 0.5 × 0.6 about its middle
        let load = push.map(|c| 0.3 * c);
        let at = turned(&rotation, [0.25, 0.3, 0.6]);
        let (mut force, mut moment) = (load, cross(at, load));
        for node in nodes {
            let reaction = add_scaled(node.shear, -node.pressure, node.normal);
            let reaction = reaction.map(|c| node.weight * c);
            force = add_scaled(force, 1.0, reaction);
            moment = add_scaled(moment, 1.0, cross(node.point, reaction));
        }
        assert!(norm(force) < 1e-9 * norm(load), "{force:?}");
        assert!(norm(moment) < 1e-9 * norm(load), "{moment:?}");
    }
}

/// Nodes of a box pressed by a surface of radius 2 that touches the middle of its top with a force of 20; points are turned
/// back. Nodes farther than 1.2 from the place of first touch are checked to be open.
fn pressed_by(
    surface: Surface<3>,
    rotation: Rotation,
    off: fn(f64, f64) -> f64,
) -> Vec<(Point<3>, f64)> {
    let mut model = Model::new();
    let mesh = distorted(
        [-1.0, -1.0, -1.0],
        [1.0, 1.0, 0.0],
        [8, 8, 4],
        CellKind::Hex8,
    );
    let body = model.body("body", turn(mesh, &rotation), SOFT);
    model.fix(body, "bottom", [Some(0.0); 3]);
    model.contact((body, "top"), (body, "top"));
    let shape = Rigid::Surface {
        surface,
        inside: false,
    };
    let force = turned(&rotation, [0.0, 0.0, -20.0]).map(Field::constant);
    let obstacle = Obstacle {
        shape,
        motion: Motion::Loaded(force),
    };
    let nonmortar = SideRef {
        body,
        side: "top".to_string(),
    };
    model.contacts[0].pair = Pair::Obstacle {
        nonmortar,
        obstacle,
    };
    let solution = model.solve().unwrap();
    let nodes = &solution.contacts[0].nodes;
    let pushed = nodes.iter().fold([0.0; 3], |sum, n| {
        add_scaled(sum, n.pressure * n.weight, n.normal)
    });
    let pushed = turned_back(&rotation, pushed);
    // the normals on a flat side are all alike: friction would have to bear nothing
    assert!(
        distance(pushed, [0.0, 0.0, 20.0]) < 1e-8 * 20.0,
        "{pushed:?}"
    );
    for node in nodes {
        let [x, y, _] = turned_back(&rotation, node.point);
        let gap = turned_back(&rotation, node.normal)[2];
        assert!((gap - 1.0).abs() < 1e-12);
        if off(x, y) > 1.2 {
            assert_eq!(node.status, Status::Open);
        }
    }
    let place = |node: &ContactNode<3>| turned_back(&rotation, node.point);
    nodes
        .iter()
        .map(|node| (place(node), node.pressure))
        .collect()
}

#[test]
fn a_ball_pressed_on_a_box_is_met_at_its_pole() {
    let rotation = rotation([0.2, 0.6, 1.0]);
    let ball = Surface::Sphere {
        center: turned(&rotation, [0.0, 0.0, 2.0]),
        radius: 2.0,
    };
    let nodes = pressed_by(ball, rotation, f64::hypot);
    let peak = nodes.iter().max_by(|a, b| a.1.total_cmp(&b.1)).unwrap();
    assert!(distance(peak.0, [0.0; 3]) < 1e-12);
}

#[test]
fn a_roller_pressed_on_a_box_is_met_along_its_line() {
    let rotation = rotation([0.2, 0.6, 1.0]);
    let roller = Surface::Cylinder {
        point: turned(&rotation, [0.0, 5.0, 2.0]),
        axis: turned(&rotation, [0.0, 1.0, 0.0]),
        radius: 2.0,
    };
    let nodes = pressed_by(roller, rotation, |x, _| x.abs());
    for (place, pressure) in &nodes {
        let below = nodes.iter().filter(|(x, _)| x[0].abs() < 1e-12);
        let mut below = below.filter(|(x, _)| (x[1] - place[1]).abs() < 1e-12);
        let (_, most) = below.next().unwrap();
        assert!(*most > 0.0 && pressure <= most, "{place:?}");
    }
}

#[test]
fn between_its_corners_a_facet_has_the_values_of_its_own_face() {
    let cuboid = Cuboid {
        from: [0.0; 3],
        to: [1.0; 3],
        cells: [2; 3],
        cell: CellKind::Hex20,
    };
    let mut mesh = cuboid.build().unwrap();
    let both = mesh.join_sides(&["bottom", "left"]).unwrap();
    let mut model = Model::<3>::new();
    let body = model.body("b", mesh, CORK);
    model.fix(body, "top", [None, None, Some(0.0)]);
    model.fix(body, "right", [Some(0.0), None, None]);
    model.fix(body, "front", [None, Some(0.0), None]);
    let gap = Field::function("-0.001 (1 + x)", |[x, ..], _| -0.001 * (1.0 + x));
    model.obstacle((body, &both), gap).name = "c".to_string();
    // in the middle of the lower face, in the middles of edges on either face, on the sharp edge between nodes
    let places = [
        [0.25, 0.5, 0.0],
        [0.0, 0.5, 0.25],
        [0.1, 0.25, 0.0],
        [0.0, 0.25, 0.1],
    ];
    for (k, at) in places.into_iter().enumerate() {
        let reading = Reading::At(at);
        model.probe(&k.to_string(), "c.pressure", reading).unwrap();
    }
    let solution = model.solve().unwrap();
    let pressure = |at: Point<3>, face: Point<3>| {
        let own = |node: &&ContactNode<3>| {
            distance(node.point, at) < 1e-12 && distance(node.normal, face) < 1e-12
        };
        solution.contacts[0]
            .nodes
            .iter()
            .find(own)
            .unwrap()
            .pressure
    };
    let (down, left) = ([0.0, 0.0, -1.0], [-1.0, 0.0, 0.0]);
    // the two faces of the edge bear what differs by 9 %
    let [low, side] = [down, left].map(|face| pressure([0.0, 0.5, 0.0], face));
    assert!((low / side - 1.0).abs() > 0.05, "{low} {side}");
    // a serendipity facet whose middle nodes are linear between the corners is bilinear
    let expected = |at: Point<3>, face: Point<3>| -> f64 {
        let along = if face == down { 0 } else { 2 };
        let mut sum = 0.0;
        for [u, v] in [[0.0, 0.0], [0.5, 0.0], [0.0, 0.5], [0.5, 0.5]] {
            let mut corner = [0.0; 3];
            (corner[along], corner[1]) = (u, v);
            let hat = |x: f64, node: f64| 1.0 - 2.0 * (x - node).abs();
            sum += hat(at[along], u) * hat(at[1], v) * pressure(corner, face);
        }
        sum
    };
    for (probe, at) in solution.probes.iter().zip(places) {
        let face = if at[2] == 0.0 { down } else { left };
        let expected = expected(at, face);
        assert!(
            (probe.value / expected - 1.0).abs() < 1e-9,
            "{at:?}: {} {expected}",
            probe.value
        );
    }
}
