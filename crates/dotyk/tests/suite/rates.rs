//! Rates of convergence of every kind of cell: smooth elasticity, Hertz in a box, a ring in rock, a press fit.
//!
//! A measured rate between the two finest meshes lies within 0.1 of theory, or is bounded below where regularity is
//! what limits it. Errors are relative, integrated by the test.

use crate::norms::{FieldError, field_error, order, pressure_error};
use dotyk::analytic::hertz::{HalfPlane, rigid_contact_modulus};
use dotyk::analytic::lame::PressFit;
use dotyk::analytic::ring::{Interface, Part, RingInPlate};
use dotyk::analytic::{Material, Plane};
use dotyk::geometry::{Field, Point};
use dotyk::mesh::{CellKind, Diagonals, Mesh, Rectangle, Ring};
use dotyk::model::{Elastic, Gap, Load, Model, Place, Solution, Support};
use std::f64::consts::PI;

// Smooth elasticity

const SMOOTH: Elastic = Elastic {
    young: 5.0,
    poisson: 0.3,
};

/// sin(ax + c) with its first and second derivatives.
fn wave(a: f64, c: f64, x: f64) -> [f64; 3] {
    let (s, k) = (a * x + c).sin_cos();
    [s, a * k, -a * a * s]
}

/// A smooth plane strain state: displacement, strains [εxx, εyy, γxy], the force density that balances it, and stress.
struct Smooth {
    displacement: [f64; 2],
    strain: [f64; 3],
    force: [f64; 2],
    stress: [f64; 3],
}

/// u = (f(x)g(y), h(x)k(y)) with waves f, g, h, k; b = −(λ + μ)∇div u − μΔu.
fn smooth([x, y]: Point<2>) -> Smooth {
    let (f, g) = (wave(1.3, 0.2, x), wave(0.9, 1.1, y));
    let (h, k) = (wave(0.7, 1.4, x), wave(1.1, 0.3, y));
    let Elastic { young, poisson } = SMOOTH;
    let mu = young / (2.0 * (1.0 + poisson));
    let lambda = young * poisson / ((1.0 + poisson) * (1.0 - 2.0 * poisson));
    let divergence = [f[2] * g[0] + h[1] * k[1], f[1] * g[1] + h[0] * k[2]];
    let laplace = [f[2] * g[0] + f[0] * g[2], h[2] * k[0] + h[0] * k[2]];
    let [xx, yy, xy] = [f[1] * g[0], h[0] * k[1], f[0] * g[1] + h[1] * k[0]];
    Smooth {
        displacement: [f[0] * g[0], h[0] * k[0]],
        strain: [xx, yy, xy],
        force: std::array::from_fn(|i| -(lambda + mu) * divergence[i] - mu * laplace[i]),
        stress: [
            lambda * (xx + yy) + 2.0 * mu * xx,
            lambda * (xx + yy) + 2.0 * mu * yy,
            mu * xy,
        ],
    }
}

fn fields(
    text: &str,
    f: impl Fn(Point<2>) -> [f64; 2] + Clone + Send + Sync + 'static,
) -> [Field; 2] {
    [0, 1].map(|i| {
        let f = f.clone();
        Field::function(text, move |p, _| f([p[0], p[1]])[i])
    })
}

fn traction([xx, yy, xy]: [f64; 3], n: [f64; 2]) -> [f64; 2] {
    [xx * n[0] + xy * n[1], xy * n[0] + yy * n[1]]
}

/// The smooth state on a mesh, prescribed by displacement on some sides and by traction on one.
fn smooth_error(
    mesh: Mesh<2>,
    held: &[&str],
    loaded: &str,
    normal: impl Fn(Point<2>) -> [f64; 2] + Clone + Send + Sync + 'static,
) -> FieldError {
    let mut model = Model::new();
    let body = model.body("body", mesh, SMOOTH);
    model.bodies[0].body_force = fields("b", |p| smooth(p).force);
    for side in held {
        model.bodies[0].supports.push(Support {
            place: Place::Side(side.to_string()),
            components: fields("u", |p| smooth(p).displacement).map(Some),
            normal: None,
            active: Default::default(),
        });
    }
    let side = loaded.to_string();
    let traction = fields("t", move |p| traction(smooth(p).stress, normal(p)));
    model.load(body, Load::Traction { side, traction });
    let solution = model.solve().unwrap();
    let exact = |p: Point<2>| (smooth(p).displacement, smooth(p).strain);
    field_error(
        &model.bodies[0].mesh,
        &solution.bodies[0].displacement,
        SMOOTH,
        &exact,
    )
}

fn check_smooth(what: &str, error: impl Fn(CellKind, usize) -> FieldError) {
    for cell in CellKind::of_dimension(2) {
        let k = cell.order();
        let finest = [64, 32][k - 1];
        let (coarse, fine) = (error(cell, finest / 2), error(cell, finest));
        let (energy, l2) = (order(coarse.energy, fine.energy), order(coarse.l2, fine.l2));
        println!(
            "{what:<10} {:<6} energy {:.2e} {energy:.3}  L2 {:.2e} {l2:.3}",
            cell.name(),
            fine.energy,
            fine.l2
        );
        assert!(
            (energy - k as f64).abs() < 0.1,
            "{what} {}: energy order {energy}",
            cell.name()
        );
        assert!(
            (l2 - (k + 1) as f64).abs() < 0.1,
            "{what} {}: L2 order {l2}",
            cell.name()
        );
    }
}

#[test]
fn smooth_fields_converge_on_squares() {
    check_smooth("squares", |cell, n| {
        let mesh = Rectangle {
            from: [0.0, 0.0],
            to: [1.0, 1.0],
            cells: [n, n],
            cell,
            diagonals: Diagonals::Checkerboard,
        };
        smooth_error(
            mesh.build().unwrap(),
            &["left", "bottom", "top"],
            "right",
            |_| [1.0, 0.0],
        )
    });
}

#[test]
fn smooth_fields_converge_on_distorted_cells() {
    check_smooth("distorted", |cell, n| {
        let mesh = Rectangle {
            from: [0.0, 0.0],
            to: [1.0, 1.0],
            cells: [n, n],
            cell,
            diagonals: Diagonals::Forward,
        };
        // Curved inside and on the held sides; the loaded side stays straight.
        let place = |[x, y]: Point<2>| {
            let bend = 0.15 * (PI * x).sin();
            [
                x + 0.1 * x * (1.0 - x) * (3.0 * y).sin(),
                y + bend * (1.0 - 0.5 * y),
            ]
        };
        let mesh = mesh.build().unwrap().map_points(place).unwrap();
        smooth_error(mesh, &["left", "bottom", "top"], "right", |_| [1.0, 0.0])
    });
}

#[test]
fn smooth_fields_converge_on_rings() {
    check_smooth("ring", |cell, n| {
        let mesh = Ring {
            center: [0.0, 0.0],
            inner: 0.5,
            outer: 1.2,
            angles: Some([0.0, 90.0]),
            cells: [n, n / 2],
            ratio: 1.0,
            grade: 1.0,
            cell,
            diagonals: Diagonals::Checkerboard,
        };
        let normal = |[x, y]: Point<2>| [x / x.hypot(y), y / x.hypot(y)];
        smooth_error(
            mesh.build().unwrap(),
            &["start", "end", "inner"],
            "outer",
            normal,
        )
    });
}

// Hertz in a box: exact on any box, no truncation

const BOX: Elastic = Elastic {
    young: 1.0,
    poisson: 0.3,
};
const CONTACT: HalfPlane = HalfPlane { a: 1.0, p0: 0.1 };

/// A box [0, size]² with y into the body, pressed on a rigid parabola below, exact tractions on the right and the top;
/// `cells` per unit length, so that the contact edge x = 1 is a node. The box floats along y.
fn hertz_model(cell: CellKind, size: f64, cells: usize) -> Model<2> {
    let n = (size * cells as f64).round() as usize;
    let mesh = Rectangle {
        from: [0.0, 0.0],
        to: [size, size],
        cells: [n, n],
        cell,
        diagonals: Diagonals::Checkerboard,
    };
    let mut model = Model::new();
    let body = model.body("box", mesh.build().unwrap(), BOX);
    model.fix(body, "left", [Some(0.0), None]);
    for (side, normal) in [("right", [1.0, 0.0]), ("top", [0.0, 1.0])] {
        let side = side.to_string();
        let traction = fields("Hertz", move |p| {
            traction(CONTACT.stress(p[0], p[1]), normal)
        });
        model.load(body, Load::Traction { side, traction });
    }
    let material = Material {
        young: BOX.young,
        poisson: BOX.poisson,
    };
    let radius = 0.5 * CONTACT.a * rigid_contact_modulus(material) / CONTACT.p0;
    let gap = Field::function("parabola", move |p, _| p[0] * p[0] / (2.0 * radius));
    model.obstacle((body, "bottom"), gap);
    model
}

#[derive(Debug, Clone, Copy)]
struct HertzError {
    energy: f64,
    pressure: f64,
    /// Nodal: √Σw(p − p)²/√Σwp².
    nodal: f64,
}

fn hertz_error(cell: CellKind, size: f64, cells: usize) -> HertzError {
    let model = hertz_model(cell, size, cells);
    let solution = model.solve().unwrap();
    let Elastic { young, poisson } = BOX;
    let strain = |[x, y]: Point<2>| {
        let [xx, yy, xy] = CONTACT.stress(x, y);
        let (direct, cross) = (
            (1.0 - poisson * poisson) / young,
            -poisson * (1.0 + poisson) / young,
        );
        [
            direct * xx + cross * yy,
            cross * xx + direct * yy,
            2.0 * (1.0 + poisson) / young * xy,
        ]
    };
    let exact = |p: Point<2>| ([1.0, 0.0], strain(p));
    let field = field_error(
        &model.bodies[0].mesh,
        &solution.bodies[0].displacement,
        BOX,
        &exact,
    );
    let contact = &solution.contacts[0];
    let (mut error, mut norm) = (0.0, 0.0);
    for node in &contact.nodes {
        let expected = CONTACT.pressure(node.point[0]);
        error += node.weight * (node.pressure - expected).powi(2);
        norm += node.weight * expected * expected;
    }
    println!(
        "{:<6} h/a = 1/{cells:<4} {:>8} dofs {:>2} steps  energy {:.4e}  pressure {:.4e} (nodes {:.4e})  p(0)/p0 {:.5}  resultant {:+.1e}  length {:.5}  {:.1} s",
        cell.name(),
        solution.dofs,
        solution.solver.iterations,
        field.energy,
        pressure_error(contact, cell.order(), |p| CONTACT.pressure(p[0])),
        (error / norm).sqrt(),
        contact
            .nodes
            .iter()
            .find(|n| n.point[0] == 0.0)
            .unwrap()
            .pressure
            / CONTACT.p0,
        contact.resultant[1] / (0.5 * CONTACT.force()) - 1.0,
        contact.length,
        solution.seconds.total,
    );
    HertzError {
        energy: field.energy,
        pressure: pressure_error(contact, cell.order(), |p| CONTACT.pressure(p[0])),
        nodal: (error / norm).sqrt(),
    }
}

/// Solves on meshes with 4, 8, .. `finest` cells per half-width and judges the two finest.
fn check_hertz(cell: CellKind, size: f64, finest: usize, energy: f64, pressure: f64) {
    let meshes = std::iter::successors(Some(4), |n| Some(2 * n)).take_while(|n| *n <= finest);
    let errors: Vec<HertzError> = meshes.map(|n| hertz_error(cell, size, n)).collect();
    for pair in errors.windows(2) {
        let [a, b] = [pair[0], pair[1]];
        println!(
            "orders: energy {:.3}  pressure {:.3}  nodes {:.3}",
            order(a.energy, b.energy),
            order(a.pressure, b.pressure),
            order(a.nodal, b.nodal)
        );
    }
    let [.., a, b] = errors.as_slice() else {
        panic!("two meshes at least");
    };
    let measured = order(a.energy, b.energy);
    assert!(
        measured >= energy,
        "{}: energy order {measured}",
        cell.name()
    );
    for measured in [order(a.pressure, b.pressure), order(a.nodal, b.nodal)] {
        assert!(
            measured >= pressure,
            "{}: pressure order {measured}",
            cell.name()
        );
    }
}

// Six meshes down to h/a = 1/128. The pressure behaves like √(a − x) at the edge, so that its order is one whatever the
// cells; linear triangles reach it from below, 0.92, 0.95, 0.97 between the last meshes.

#[test]
fn hertz_converges_with_linear_cells() {
    check_hertz(CellKind::Tri3, 2.0, 128, 0.95, 0.95);
    check_hertz(CellKind::Quad4, 2.0, 128, 0.95, 0.95);
}

#[test]
fn hertz_converges_with_biquadratic_cells() {
    check_hertz(CellKind::Quad9, 2.0, 128, 1.45, 0.95);
}

#[test]
fn hertz_converges_with_other_quadratic_cells() {
    for cell in [CellKind::Tri6, CellKind::Quad8] {
        check_hertz(cell, 2.0, 32, 1.45, 0.95);
    }
}

/// Six meshes of the quadratic cells that the suite stops at h/a = 1/32.
#[test]
#[ignore = "526 000 dofs: half a minute, 1.5 GB"]
fn hertz_converges_on_six_meshes() {
    for cell in [CellKind::Tri6, CellKind::Quad8] {
        check_hertz(cell, 2.0, 128, 1.45, 0.95);
    }
}

/// The box [0, 4]² of the case folder.
#[test]
#[ignore = "2.1 million dofs: a minute, 6 GB"]
fn hertz_converges_on_six_meshes_of_the_large_box() {
    check_hertz(CellKind::Quad4, 4.0, 128, 0.95, 0.95);
    check_hertz(CellKind::Quad9, 4.0, 128, 1.45, 0.95);
}

// A ring in rock: the tunnel, exactly

const TUNNEL: RingInPlate = RingInPlate {
    inner: 12.0,
    radius: 15.0,
    ring: Material {
        young: 2.1e6,
        poisson: 0.15,
    },
    plate: Material {
        young: 2000.0,
        poisson: 0.25,
    },
    plane: Plane::Strain,
    vertical: 1.0,
    ratio: 1.0 / 3.0,
    interface: Interface::FullSlip,
};

/// Relative errors of the pressure (L2 along the contact) and of the ovalisation u2.
#[derive(Debug, Clone, Copy)]
struct RingError {
    pressure: f64,
    ovalisation: f64,
}

/// The half x ≥ 0 out to r = 45 where the exact tractions act; `around` cells on the half circle. The lining floats.
fn ring_error(cell: CellKind, around: usize) -> RingError {
    let part = |inner: f64, outer: f64, through: usize, ratio: f64| {
        let ring = Ring {
            center: [0.0, 0.0],
            inner,
            outer,
            angles: Some([-90.0, 90.0]),
            cells: [around, through],
            ratio,
            grade: 1.0,
            cell,
            diagonals: Diagonals::Checkerboard,
        };
        ring.build().unwrap()
    };
    let elastic = |m: Material| Elastic {
        young: m.young,
        poisson: m.poisson,
    };
    // Cells of the rock are nearly square: radii grow by π/around from layer to layer.
    let growth = 1.0 + PI / around as f64;
    let outward = (3.0_f64.ln() / growth.ln()).round() as usize;
    let through = (around as f64 / 16.0).round().max(1.0) as usize;
    let mut model = Model::new();
    let rock = model.body(
        "rock",
        part(15.0, 45.0, outward, growth),
        elastic(TUNNEL.plate),
    );
    let lining = model.body(
        "lining",
        part(12.0, 15.0, through, 1.0),
        elastic(TUNNEL.ring),
    );
    for body in [rock, lining] {
        model
            .fix(body, "start", [Some(0.0), None])
            .fix(body, "end", [Some(0.0), None]);
    }
    model.pin(rock, [45.0, 0.0], [None, Some(0.0)]);
    let traction = fields("Michell", |p| {
        let r = p[0].hypot(p[1]);
        TUNNEL.traction(p, [p[0] / r, p[1] / r])
    });
    model.load(
        rock,
        Load::Traction {
            side: "outer".to_string(),
            traction,
        },
    );
    model.contact((rock, "inner"), (lining, "outer"));
    let solution = model.solve().unwrap();
    let contact = &solution.contacts[0];
    assert_eq!(contact.nodes.len(), cell.order() * around + 1);
    let pressure = pressure_error(contact, cell.order(), |p| TUNNEL.pressure(p[1].atan2(p[0])));
    let [exact, _] = TUNNEL.displacement_harmonics(15.0, Part::Ring);
    let ovalisation =
        (second_harmonic(&solution, &model.bodies[1].mesh) / exact.second - 1.0).abs();
    println!(
        "{:<6} {around:>3} around, {:>4} nodes  pressure {pressure:.4e}  ovalisation {ovalisation:.4e}",
        cell.name(),
        contact.nodes.len()
    );
    RingError {
        pressure,
        ovalisation,
    }
}

/// 2/π ∫ u_r cos 2θ over the outer half circle of the lining, trapezium rule on the equidistant nodes (exact for the
/// harmonics present). A vertical rigid motion is odd in θ and drops out.
fn second_harmonic(solution: &Solution<2>, mesh: &Mesh<2>) -> f64 {
    let nodes = &mesh.chain("outer").unwrap()[0].nodes;
    let last = nodes.len() - 1;
    let sum: f64 = nodes
        .iter()
        .enumerate()
        .map(|(k, &node)| {
            let ([x, y], u) = (
                mesh.points()[node as usize],
                solution.bodies[1].displacement[node as usize],
            );
            let theta = y.atan2(x);
            let weight = if k == 0 || k == last { 0.5 } else { 1.0 };
            let radial = u[0] * theta.cos() + u[1] * theta.sin();
            weight * radial * (2.0 * theta).cos()
        })
        .sum();
    2.0 * sum / last as f64
}

#[test]
fn a_ring_of_32_quadratic_edges_is_right_to_a_fifth_of_a_percent() {
    for cell in [CellKind::Tri6, CellKind::Quad8, CellKind::Quad9] {
        let error = ring_error(cell, 32);
        assert!(error.pressure <= 2e-3, "{}: {error:?}", cell.name());
        assert!(error.ovalisation <= 2e-3, "{}: {error:?}", cell.name());
    }
}

#[test]
fn a_ring_of_linear_cells_converges() {
    for cell in [CellKind::Tri3, CellKind::Quad4] {
        let errors = [64, 128, 256].map(|n| ring_error(cell, n));
        let [_, [p, u]] = [0, 1].map(|k| {
            let [a, b] = [errors[k], errors[k + 1]];
            let p = order(a.pressure, b.pressure);
            let u = order(a.ovalisation, b.ovalisation);
            println!("{}: orders {p:.3} {u:.3}", cell.name());
            [p, u]
        });
        // One for triangles; on quadrilaterals, symmetric about every contact node, the pressure is better than that.
        assert!(p > 0.95, "{}: pressure order {p}", cell.name());
        // Bending locks on coarse meshes, so that the order comes from below: 1.5, 1.85, 1.96 for triangles.
        assert!(
            (u - 2.0).abs() < 0.1,
            "{}: ovalisation order {u}",
            cell.name()
        );
    }
}

// A press fit

/// Relative L2 error of the contact pressure of two pressed rings, a quarter of them with `around` cells.
fn press_fit_error(cell: CellKind, around: usize) -> f64 {
    let steel = Material {
        young: 210e3,
        poisson: 0.3,
    };
    let fit = PressFit {
        bore: 20.0,
        radius: 40.0,
        outer: 80.0,
        inner_material: steel,
        outer_material: steel,
        plane: Plane::Strain,
        interference: 0.04,
    };
    let part = |inner: f64, outer: f64, through: usize| {
        let ring = Ring {
            center: [0.0, 0.0],
            inner,
            outer,
            angles: Some([0.0, 90.0]),
            cells: [around, through],
            ratio: 1.0,
            grade: 1.0,
            cell,
            diagonals: Diagonals::Checkerboard,
        };
        ring.build().unwrap()
    };
    let elastic = Elastic {
        young: steel.young,
        poisson: steel.poisson,
    };
    let mut model = Model::new();
    let inner = model.body("inner", part(fit.bore, fit.radius, around / 2), elastic);
    let outer = model.body("outer", part(fit.radius, fit.outer, around), elastic);
    for body in [inner, outer] {
        model
            .fix(body, "start", [None, Some(0.0)])
            .fix(body, "end", [Some(0.0), None]);
    }
    let contact = model.contact((outer, "inner"), (inner, "outer"));
    contact.gap = Some(Gap::Given(Field::constant(-fit.interference)));
    let solution = model.solve().unwrap();
    let error = pressure_error(&solution.contacts[0], cell.order(), |_| fit.pressure());
    println!(
        "{:<6} {around:>3} around  pressure {error:.4e}",
        cell.name()
    );
    error
}

#[test]
fn a_press_fit_converges() {
    for cell in CellKind::of_dimension(2) {
        let [_, coarse, fine] = [8, 16, 32].map(|n| press_fit_error(cell, n));
        let measured = order(coarse, fine);
        println!("{}: order {measured:.3}", cell.name());
        // Two of the quadratic cells; linear quadrilaterals, promised one, gain from the symmetry of the state.
        let expected = cell.order() as f64;
        assert!(
            measured >= expected - 0.1,
            "{}: order {measured}",
            cell.name()
        );
    }
}
