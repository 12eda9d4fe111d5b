//! Cattaneo–Mindlin and a full cycle of Mindlin–Deresiewicz in two boxes under the exact tractions: no error of truncation.
//!
//! Two equal boxes [−1.5, 1.5] × ±[0, 1.5] with a contact of half-width a = 1 are cut out of two half-planes. The exact
//! stress acts on all cuts and balances, so that the supports only place the pair. Time 0: P alone; then Q goes
//! 0 → Q* (t = 1) → −Q* (t = 3) → Q* (t = 5), Q* = 0.6 μP. Units: E = 1, a = 1.

use crate::norms::pressure_error;
use dotyk::analytic::Material;
use dotyk::analytic::hertz::{HalfPlane, contact_modulus};
use dotyk::analytic::mindlin::{Cycle, Way};
use dotyk::geometry::Field;
use dotyk::mesh::{CellKind, Diagonals, Rectangle};
use dotyk::model::{BodyId, ContactNode, Elastic, Gap, Law, Load, Method, Model, Solution, Status};

const CONTACT: HalfPlane = HalfPlane { a: 1.0, p0: 0.1 };
const BOX: Elastic = Elastic {
    young: 1.0,
    poisson: 0.3,
};
const FRICTION: f64 = 0.3;
const SHARE: f64 = 0.6;
const SIZE: f64 = 1.5;

fn modulus() -> f64 {
    let material = Material {
        young: BOX.young,
        poisson: BOX.poisson,
    };
    contact_modulus(material, material)
}

/// The exact solution at time t; its traction is that on the upper body, along +x.
fn exact(t: f64) -> Cycle {
    let (share, way) = match t {
        t if t <= 1.0 => (SHARE * t, Way::First),
        t if t <= 3.0 => (SHARE * (2.0 - t), Way::Falling),
        t => (SHARE * (t.min(5.0) - 4.0), Way::Rising),
    };
    let limit = FRICTION * CONTACT.force();
    Cycle {
        normal: CONTACT,
        friction: FRICTION,
        largest: SHARE * limit,
        tangential: share * limit,
        way,
    }
}

/// Exact stress [xx, yy, xy] of the upper (sign 1) or lower (sign −1) body.
fn stress(sign: f64, [x, y, _]: [f64; 3], t: f64) -> [f64; 3] {
    let normal = CONTACT.stress(x, sign * y);
    let shear = exact(t).stress(x, sign * y);
    // the lower body is mirrored and feels the opposite shear
    let [xx, yy, xy]: [f64; 3] = std::array::from_fn(|i| normal[i] + sign * shear[i]);
    [xx, yy, sign * xy]
}

/// What a run looks like.
#[derive(Debug, Clone, Copy)]
struct Setup {
    cell: CellKind,
    /// Cells over the contact [−a, a], above and below.
    cells: [usize; 2],
    /// The lower body carries the multipliers.
    swapped: bool,
}

impl Setup {
    fn of(cell: CellKind, cells: [usize; 2]) -> Self {
        Self {
            cell,
            cells,
            swapped: false,
        }
    }

    /// Distance of neighbouring nodes of the nonmortar side.
    fn spacing(self) -> f64 {
        let cells = self.cells[usize::from(self.swapped)];
        2.0 * CONTACT.a / (cells * self.cell.order()) as f64
    }

    /// Cell of the coarser side.
    fn coarsest(self) -> f64 {
        2.0 * CONTACT.a / self.cells[0].min(self.cells[1]) as f64
    }

    fn model(self, times: &[f64]) -> Model<2> {
        let mut model = Model::new();
        for (name, sign, cells) in [
            ("upper", 1.0, self.cells[0]),
            ("lower", -1.0, self.cells[1]),
        ] {
            let (low, high) = if sign > 0.0 {
                (0.0, SIZE)
            } else {
                (-SIZE, 0.0)
            };
            let along = (SIZE * cells as f64).round() as usize;
            let mesh = Rectangle {
                from: [-SIZE, low],
                to: [SIZE, high],
                cells: [along, along / 2],
                cell: self.cell,
                diagonals: Diagonals::Checkerboard,
            };
            let body = model.body(name, mesh.build().unwrap(), BOX);
            let far = if sign > 0.0 { "top" } else { "bottom" };
            for (side, normal) in [
                ("left", [-1.0, 0.0]),
                ("right", [1.0, 0.0]),
                (far, [0.0, sign]),
            ] {
                let traction = [[0, 2], [2, 1]].map(|row| {
                    Field::function("Hertz and Mindlin", move |p, t| {
                        let stress = stress(sign, p, t);
                        normal[0] * stress[row[0]] + normal[1] * stress[row[1]]
                    })
                });
                let side = side.to_string();
                model.load(body, Load::Traction { side, traction });
            }
        }
        // the exact tractions balance: this places the pair and bears nothing
        let lower = BodyId(1);
        model.pin(lower, [-SIZE, -SIZE], [Some(0.0), Some(0.0)]);
        model.pin(lower, [SIZE, -SIZE], [None, Some(0.0)]);
        let sides = [(BodyId(0), "bottom"), (lower, "top")];
        let [a, b] = if self.swapped {
            [sides[1], sides[0]]
        } else {
            sides
        };
        let curvature = 2.0 * CONTACT.p0 / (CONTACT.a * modulus());
        let contact = model.contact(a, b);
        contact.gap = Some(Gap::Given(Field::function("two parabolas", move |p, _| {
            0.5 * curvature * p[0] * p[0]
        })));
        contact.law = Law::Coulomb(Field::constant(FRICTION));
        model.times = times.to_vec();
        model
    }

    fn steps(self, times: &[f64]) -> Vec<Solution<2>> {
        self.model(times).solve_steps().unwrap()
    }
}

/// What is known of one run, and how it is judged.
struct Step<'a> {
    setup: Setup,
    solution: &'a Solution<2>,
    exact: Cycle,
}

/// Steps of a full cycle; nothing changes in the last one.
const TIMES: [f64; 14] = [
    0.0, 0.25, 0.5, 0.75, 1.0, 1.5, 2.0, 2.5, 3.0, 3.5, 4.0, 4.5, 5.0, 6.0,
];

impl<'a> Step<'a> {
    fn new(setup: Setup, solution: &'a Solution<2>) -> Self {
        Self {
            setup,
            solution,
            exact: exact(solution.time),
        }
    }

    fn nodes(&self) -> &[ContactNode<2>] {
        &self.solution.contacts[0].nodes
    }

    /// −1 where the lower body carries the multipliers: what it feels is minus what the upper one does.
    fn sign(&self) -> f64 {
        if self.setup.swapped { -1.0 } else { 1.0 }
    }

    /// Points (x, q) of the shear traction on the upper body.
    fn shear(&self) -> Vec<[f64; 2]> {
        let points = self.nodes().iter();
        points
            .map(|n| [n.point[0], self.sign() * n.shear[0]])
            .collect()
    }

    /// The end of the state at Q*: c* of the past.
    fn furthest(&self) -> Cycle {
        Cycle {
            tangential: self.exact.largest,
            way: Way::First,
            ..self.exact
        }
    }

    /// Where the exact traction has a vertical tangent.
    fn ends(&self) -> [f64; 3] {
        let furthest = self.furthest().stick_half_width();
        [CONTACT.a, self.exact.stick_half_width(), furthest]
    }

    /// Certificate, Newton steps, balance.
    fn check_solver(&self) {
        let Self { solution, .. } = self;
        assert!(solution.converged && solution.certificate.holds());
        // the theory is linear, and the load may be as large as one likes
        let linear = [
            "small strains and rotations",
            "sides stay paired as they were",
        ];
        let known = |warning: &String| linear.iter().any(|words| warning.contains(words));
        assert!(
            solution.warnings.iter().all(known),
            "{:?}",
            solution.warnings
        );
        assert!(solution.solver.method == "newton" && solution.solver.iterations <= 12);
        let [x, y] = solution.contacts[0].resultant.map(|f| self.sign() * f);
        // quadrature of the smooth tractions on the cuts
        assert!((x - self.exact.tangential).abs() < 1e-6 * CONTACT.force());
        assert!((y - CONTACT.force()).abs() < 1e-6 * CONTACT.force());
    }

    /// The zones of stick and slip end within a distance of two nodes from where they should.
    fn check_zones(&self) {
        let (c, h) = (self.exact.stick_half_width(), self.setup.spacing());
        for node in self.nodes() {
            let x = node.point[0].abs();
            let expected = if x < c - h {
                Status::Stick
            } else if x > c + h && x < CONTACT.a - h {
                Status::Slip
            } else if x > CONTACT.a + h {
                Status::Open
            } else {
                continue;
            };
            assert_eq!(
                node.status, expected,
                "t = {}: {node:?}",
                self.solution.time
            );
        }
    }

    /// Tractions and slip. Friction that turns jumps by 2μp where it slips, however small q: the measure is μp.
    fn check_tractions(&self) {
        let time = self.solution.time;
        let largest = FRICTION * CONTACT.p0;
        let off = distance(&self.shear(), |x| self.exact.traction(x));
        let friction = size(|x| FRICTION * CONTACT.pressure(x));
        assert!(off < 0.02 * friction, "t = {time}: {}", off / friction);
        if self.exact.tangential.abs() == self.exact.largest {
            let own = size(|x| self.exact.traction(x));
            assert!(off < 0.02 * own, "t = {time}: {} of q", off / own);
        }
        // two cells of the coarser side: the next nodes left and right of an end, on either side
        let aside = 2.0 * self.setup.coarsest();
        let far = |x: f64| self.ends().iter().all(|end| (x.abs() - end).abs() > aside);
        let mut far_nodes = 0;
        for [x, q] in self.shear().into_iter().filter(|[x, _]| far(*x)) {
            let off = (q - self.exact.traction(x)).abs();
            assert!(off < 0.02 * largest, "t = {time}, {x}: {}", off / largest);
            far_nodes += 1;
        }
        assert!(far_nodes > self.nodes().len() / 2);
        let most = self.furthest().slip(CONTACT.a, modulus()).abs();
        let touching = self.nodes().iter().filter(|n| n.pressure > 0.0);
        for node in touching.filter(|n| n.point[0].abs() <= CONTACT.a) {
            let exact = self.exact.slip(node.point[0], modulus());
            let off = (self.sign() * node.slip[0] - exact).abs();
            assert!(off < 0.02 * most, "t = {time}: {} {node:?}", off / most);
        }
    }
}

/// ‖f‖ over the contact: x = cos φ puts many points where roots end.
fn size(f: impl Fn(f64) -> f64) -> f64 {
    let points = 20_000;
    let step = std::f64::consts::PI / points as f64;
    let angles = (0..points).map(|i| (i as f64 + 0.5) * step);
    let squares = angles.map(|angle| f(angle.cos()).powi(2) * angle.sin() * step);
    squares.sum::<f64>().sqrt()
}

/// ‖q − f‖ over the side, q linear between the points (x, q).
fn distance(points: &[[f64; 2]], f: impl Fn(f64) -> f64) -> f64 {
    let parts = 40;
    let pieces = points.windows(2).flat_map(|w| {
        let [[x, q], [next, then]] = [w[0], w[1]];
        (0..parts).map(move |i| {
            let part = (i as f64 + 0.5) / parts as f64;
            let width = (next - x).abs() / parts as f64;
            [x + part * (next - x), q + part * (then - q), width]
        })
    });
    let squares = pieces.map(|[x, q, width]| (q - f(x)).powi(2) * width);
    squares.sum::<f64>().sqrt()
}

/// The value at x of what is linear between points (x, q).
fn between(points: &[[f64; 2]], at: f64) -> f64 {
    let pair = points.windows(2).find(|w| {
        let [[x, _], [next, _]] = [w[0], w[1]];
        x.min(next) <= at && at <= x.max(next)
    });
    let [[x, q], [next, then]] = pair.map(|w| [w[0], w[1]]).unwrap();
    q + (at - x) / (next - x) * (then - q)
}

/// Every step of a full cycle against the closed form, with the dissipated work.
fn check_cycle(setup: Setup) {
    let steps = setup.steps(&TIMES);
    let whole = Step::new(setup, &steps[0]).furthest().dissipated(modulus());
    let mut since_turn = 0.0;
    for solution in &steps {
        let step = Step::new(setup, solution);
        step.check_solver();
        step.check_zones();
        step.check_tractions();
        let work = solution.contacts[0].dissipated;
        // rounding
        assert!(work > -1e-12 * whole, "{work}");
        if [0.0, 6.0].contains(&solution.time) {
            // P alone moves equal bodies alike; and without a change nothing slips
            assert!(work.abs() < 1e-12 * whole, "{work}");
        }
        since_turn += work;
        let off = since_turn - step.exact.dissipated(modulus());
        // the slip is right to 2 %, and mostly much better; a half cycle dissipates twice the first way
        assert!(
            off.abs() < 0.02 * whole,
            "t = {}: {}",
            solution.time,
            off / whole
        );
        if [1.0, 3.0].contains(&solution.time) {
            since_turn = 0.0;
        }
    }
    let pressure = pressure_error(&steps[12].contacts[0], setup.cell.order(), |p| {
        CONTACT.pressure(p[0])
    });
    let last = Step::new(setup, &steps[12]);
    let shear =
        distance(&last.shear(), |x| last.exact.traction(x)) / size(|x| last.exact.traction(x));
    let loop_work: f64 = steps[5..13].iter().map(|s| s.contacts[0].dissipated).sum();
    println!(
        "{setup:?}: errors at Q*: p {pressure:.4} q {shear:.4}, work of a cycle {:+.4}, Newton {:?}",
        loop_work / (4.0 * whole) - 1.0,
        steps
            .iter()
            .map(|s| s.solver.iterations)
            .collect::<Vec<_>>(),
    );
    assert!(pressure < 0.01);
    // the loop: two half cycles of twice the work of the first way
    assert!((loop_work / (4.0 * whole) - 1.0).abs() < 0.01);
}

#[test]
fn a_cycle_of_the_tangential_force_on_matching_meshes() {
    for cell in [CellKind::Quad4, CellKind::Quad9] {
        check_cycle(Setup::of(cell, [64, 64]));
    }
}

#[test]
fn a_cycle_of_the_tangential_force_on_non_matching_meshes_either_side_carrying_the_forces() {
    for cell in [CellKind::Quad4, CellKind::Quad9] {
        check_cycle(Setup::of(cell, [64, 48]));
        let swapped = Setup {
            swapped: true,
            ..Setup::of(cell, [80, 64])
        };
        check_cycle(swapped);
    }
}

#[test]
fn both_choices_of_the_nonmortar_side_agree() {
    let setup = Setup::of(CellKind::Quad9, [64, 48]);
    let swapped = Setup {
        swapped: true,
        ..setup
    };
    let [first, second] = [setup, swapped].map(|setup| setup.steps(&TIMES));
    for (a, b) in first.iter().zip(&second) {
        let (a, b) = (Step::new(setup, a), Step::new(swapped, b));
        let other = b.shear();
        let off = distance(&a.shear(), |x| between(&other, x));
        let friction = size(|x| FRICTION * CONTACT.pressure(x));
        println!("t = {}: {:.4}", a.solution.time, off / friction);
        // each is off by some 1 % of the friction, where it has turned
        assert!(off < 0.02 * friction, "t = {}", a.solution.time);
        let work = [&a, &b].map(|s| s.solution.contacts[0].dissipated);
        let whole = a.furthest().dissipated(modulus());
        assert!((work[0] - work[1]).abs() < 0.01 * whole, "{work:?}");
        // the loads are the same
        let [[x, y], [u, v]] = [&a, &b].map(|s| s.solution.contacts[0].resultant);
        assert!((x + u).abs() < 1e-10 && (y + v).abs() < 1e-10);
    }
}

#[test]
fn a_force_that_only_rises_may_come_at_once_or_in_ten_steps() {
    let tenths: Vec<f64> = (0..=10).map(|i| 0.1 * f64::from(i)).collect();
    // between meshes that do not match, the shear moves the pressure, and with it the bound, by some 1e-4 while nodes slip
    for (setup, in_work) in [
        (Setup::of(CellKind::Quad4, [64, 64]), 1e-9),
        (Setup::of(CellKind::Quad9, [32, 24]), 1e-4),
    ] {
        let ten = setup.steps(&tenths);
        let last = &ten[10].contacts[0];
        // also with P: a node slips either not at all or in one direction
        for times in [vec![0.0, 1.0], vec![1.0]] {
            let steps = setup.steps(&times);
            let once = &steps[times.len() - 1].contacts[0];
            for (a, b) in last.nodes.iter().zip(&once.nodes) {
                // the certificate holds to 1e-8
                assert!((a.shear[0] - b.shear[0]).abs() < 1e-8 * CONTACT.p0);
                assert!((a.pressure - b.pressure).abs() < 1e-8 * CONTACT.p0);
            }
            let [slow, fast] = [&ten, &steps]
                .map(|steps| steps.iter().map(|s| s.contacts[0].dissipated).sum::<f64>());
            assert!((slow / fast - 1.0).abs() < in_work, "{slow} {fast}");
        }
    }
}

#[test]
fn every_method_follows_the_turning_force() {
    let mut model = Setup::of(CellKind::Quad4, [32, 24]).model(&[0.0, 1.0, 2.0, 3.0]);
    let newton = model.solve_steps().unwrap();
    for method in Method::NAMED {
        model.solver.method = method;
        for (a, b) in newton.iter().zip(model.solve_steps().unwrap()) {
            assert!(b.certificate.holds(), "{}", method.name());
            let pairs = a.contacts[0].nodes.iter().zip(&b.contacts[0].nodes);
            let off = pairs.fold(0.0f64, |off, (a, b)| {
                let shear = (a.shear[0] - b.shear[0]).abs() / FRICTION;
                off.max(shear).max((a.pressure - b.pressure).abs())
            });
            // the certificate holds to 1e-8 in gaps and slip; the least eigenvalue of F costs up to four digits of forces
            assert!(off < 1e-4 * CONTACT.p0, "{}: {off}", method.name());
        }
    }
}
