//! Hertz in space: two half-spaces on each other, one of them with the curvature of a sphere, on meshes that do not match.
//!
//! Each body is a quarter of a block, cut out of the half-space under the exact pressure with the exact tractions on its cuts, so
//! that nothing is missing but what the meshes can not resolve.

use dotyk::analytic::Material;
use dotyk::analytic::hertz::{Sphere, contact_modulus};
use dotyk::geometry::{Field, norm};
use dotyk::mesh::{CellKind, Cuboid};
use dotyk::model::{
    ContactNode, Elastic, Gap, Load, Model, Pairing, Place, Solution, Status, Support,
};

const STEEL: Elastic = Elastic {
    young: 210e3,
    poisson: 0.3,
};
const SIZE: f64 = 1.0;

fn material(elastic: Elastic) -> Material {
    Material {
        young: elastic.young,
        poisson: elastic.poisson,
    }
}

/// A steel sphere of radius 10 on a steel plane under 1000.
fn exact() -> Sphere {
    Sphere::under_force(
        1000.0,
        10.0,
        contact_modulus(material(STEEL), material(STEEL)),
    )
}

/// Two quarters of blocks; `up` is 1 for the upper one, which lies at z ≥ 0.
fn halves(cells: [usize; 2], kinds: [CellKind; 2]) -> Model<3> {
    let exact = exact();
    let mut model = Model::new();
    let mut bodies = Vec::new();
    for (k, up) in [-1.0, 1.0].into_iter().enumerate() {
        let cuboid = Cuboid {
            from: [0.0, 0.0, f64::min(0.0, up * SIZE)],
            to: [SIZE, SIZE, f64::max(0.0, up * SIZE)],
            cells: [cells[k]; 3],
            cell: kinds[k],
        };
        let body = model.body(["lower", "upper"][k], cuboid.build().unwrap(), STEEL);
        model.roller(body, "left", 0.0).roller(body, "front", 0.0);
        let cartesian = move |[x, y, z]: [f64; 3]| -> [[f64; 3]; 3] {
            let r = x.hypot(y);
            let [radial, hoop, axial, shear] = exact.stress(r, (up * z).max(1e-9), STEEL.poisson);
            let (c, s) = (x / r, y / r);
            let across = (radial - hoop) * s * c;
            let shear = up * shear;
            [
                [radial * c * c + hoop * s * s, across, shear * c],
                [across, radial * s * s + hoop * c * c, shear * s],
                [shear * c, shear * s, axial],
            ]
        };
        let far = if k == 0 { "bottom" } else { "top" };
        for (side, axis, sign) in [("right", 0, 1.0), ("back", 1, 1.0), (far, 2, up)] {
            let traction = [0, 1, 2]
                .map(|i| Field::function("Huber", move |x, _| sign * cartesian(x)[axis][i]));
            let side = side.to_string();
            model.load(body, Load::Traction { side, traction });
        }
        bodies.push(body);
    }
    model.bodies[0].supports.push(Support {
        place: Place::Point([0.0, 0.0, -SIZE]),
        components: [None, None, Some(Field::constant(0.0))],
        normal: None,
        active: Default::default(),
    });
    let radius = exact.a * exact.a / exact.approach;
    let contact = model.contact((bodies[1], "bottom"), (bodies[0], "top"));
    contact.pairing = Some(Pairing::Mortar);
    contact.gap = Some(Gap::Given(Field::function(
        "r²/(2R)",
        move |[x, y, _], _| (x * x + y * y) / (2.0 * radius),
    )));
    model
}

fn radius(node: &ContactNode<3>) -> f64 {
    norm([node.point[0], node.point[1]])
}

/// Root of a line fitted to p² of the outer loaded nodes.
fn contact_radius(nodes: &[ContactNode<3>]) -> f64 {
    let a = exact().a;
    let loaded: Vec<[f64; 2]> = nodes
        .iter()
        .filter(|n| n.status == Status::Closed && radius(n) > 0.5 * a)
        .map(|n| [radius(n).powi(2), n.pressure * n.pressure])
        .collect();
    let mean = |k: usize| loaded.iter().map(|p| p[k]).sum::<f64>() / loaded.len() as f64;
    let (x, y) = (mean(0), mean(1));
    let both: f64 = loaded.iter().map(|p| (p[0] - x) * (p[1] - y)).sum();
    let slope = both / loaded.iter().map(|p| (p[0] - x).powi(2)).sum::<f64>();
    (x - y / slope).sqrt()
}

/// Error of the pressures in L2, by nodes, relative.
fn pressure_error(nodes: &[ContactNode<3>]) -> f64 {
    let exact = exact();
    let sum = |f: &dyn Fn(&ContactNode<3>) -> f64| -> f64 {
        nodes.iter().map(|n| n.weight * f(n).powi(2)).sum()
    };
    let off = |n: &ContactNode<3>| n.pressure - exact.pressure(radius(n));
    (sum(&off) / sum(&|n| exact.pressure(radius(n)))).sqrt()
}

/// Largest distance of the pressures well inside the contact from the exact ones, over the largest.
fn scatter(nodes: &[ContactNode<3>]) -> f64 {
    let exact = exact();
    let inner = nodes.iter().filter(|n| radius(n) < 0.6 * exact.a);
    let off = inner.map(|n| (n.pressure - exact.pressure(radius(n))).abs() / exact.p0);
    off.fold(0.0, f64::max)
}

fn solved(cells: [usize; 2], kinds: [CellKind; 2]) -> Solution<3> {
    let solution = halves(cells, kinds).solve().unwrap();
    assert!(solution.converged, "{}", solution.certificate.objection());
    let force = solution.contacts[0].resultant[2];
    assert!((force / 250.0 - 1.0).abs() < 1e-3, "{force}");
    assert!(solution.contacts[0].imbalance < 1e-10);
    solution
}

#[test]
fn two_half_spaces_press_as_hertz_says() {
    let exact = exact();
    // what meshes with 7, 3.6 and 3.4 edges of the coarser side to a radius leave: radius, largest pressure, scatter
    for (kinds, cells, [edge, middle, rough]) in [
        ([CellKind::Hex8; 2], [18, 16], [0.01, 0.005, 0.005]),
        (
            [CellKind::Tet10, CellKind::Hex20],
            [9, 8],
            [0.015, 0.03, 0.04],
        ),
        (
            [CellKind::Hex27, CellKind::Hex8],
            [8, 17],
            [0.02, 0.005, 0.01],
        ),
    ] {
        let solution = solved(cells, kinds);
        let nodes = &solution.contacts[0].nodes;
        let a = contact_radius(nodes) / exact.a;
        assert!((a - 1.0).abs() < edge, "{kinds:?} {a}");
        let centre = nodes.iter().find(|n| radius(n) == 0.0).unwrap();
        let p0 = centre.pressure / exact.p0;
        assert!((p0 - 1.0).abs() < middle, "{kinds:?} {p0}");
        let off = scatter(nodes);
        assert!(off < rough, "{kinds:?} {off}");
    }
}

#[test]
fn pressures_converge_with_the_size_of_the_cells() {
    // from 1.6 to 7 edges to a radius; where the edge of the contact lies in a facet makes single errors scatter
    for (kinds, cells) in [
        (
            [CellKind::Hex8; 2],
            [[4, 5], [6, 7], [9, 10], [13, 14], [17, 18]],
        ),
        (
            [CellKind::Hex27, CellKind::Tet10],
            [[3, 2], [4, 3], [5, 4], [7, 6], [9, 8]],
        ),
    ] {
        let points = cells.map(|cells| {
            let solution = solved(cells, kinds);
            let error = pressure_error(&solution.contacts[0].nodes);
            println!("{kinds:?} {cells:?} {error}");
            [-(cells[1] as f64).ln(), error.ln()]
        });
        let mean = |k: usize| points.iter().map(|p| p[k]).sum::<f64>() / points.len() as f64;
        let (x, y) = (mean(0), mean(1));
        let both: f64 = points.iter().map(|p| (p[0] - x) * (p[1] - y)).sum();
        let order = both / points.iter().map(|p| (p[0] - x).powi(2)).sum::<f64>();
        println!("{order}");
        assert!(order > 0.95, "{kinds:?} {order}");
    }
}
