//! Friction in space on meshes that do not match: spinning, dragging, and what a stack can bear.
//!
//! Limits: a box with a square sole of the side L under the uniform pressure p bears the moment
//! μ p ∫r dA = μ p L³ (√2 + ln(1 + √2))/6 about its middle; a block on a plane tilted by β slides when tan β > μ.

use dotyk::case::Case;
use dotyk::geometry::{Field, Point, cross, dot, norm};
use dotyk::mesh::{CellKind, Cuboid, Mesh};
use dotyk::model::{BodyId, CoupleKind, Elastic, Law, Model, Pairing, Solution, Status};

/// It does not contract across a load: pressures stay uniform.
const CORK: Elastic = Elastic {
    young: 1000.0,
    poisson: 0.0,
};

fn cuboid(from: Point<3>, to: Point<3>, cells: [usize; 3], cell: CellKind) -> Mesh<3> {
    let cuboid = Cuboid {
        from,
        to,
        cells,
        cell,
    };
    cuboid.build().unwrap()
}

/// A box on a wider one, pressed down and spun by a plate on its top.
fn spun(kinds: [CellKind; 2], cells: usize, turn: f64) -> (Model<3>, Solution<3>) {
    let mut model = Model::new();
    let lower = model.body(
        "lower",
        cuboid([-1.0, -1.0, -0.5], [1.0, 1.0, 0.0], [5, 4, 1], kinds[0]),
        Elastic {
            young: 1e6,
            poisson: 0.0,
        },
    );
    model.fix(lower, "bottom", [Some(0.0); 3]);
    let counts = [cells, cells + 1, 1];
    let upper = model.body(
        "upper",
        cuboid([-0.5, -0.5, 0.0], [0.5, 0.5, 0.3], counts, kinds[1]),
        CORK,
    );
    let plate = model.couple(upper, "top", ("plate", [0.0, 0.0, 0.3]), CoupleKind::Rigid);
    plate.displacement = [Some(0.0), Some(0.0), Some(-0.003)].map(|c| c.map(Field::constant));
    plate.rotation = [Some(0.0), Some(0.0), Some(turn)].map(|c| c.map(Field::constant));
    let contact = model.contact((upper, "bottom"), (lower, "top"));
    contact.pairing = Some(Pairing::Mortar);
    contact.law = Law::Coulomb(Field::constant(0.4));
    let solution = model.solve().unwrap();
    assert!(solution.converged, "{}", solution.certificate.objection());
    (model, solution)
}

#[test]
fn a_spun_box_bears_the_moment_of_friction_on_its_sole() {
    let root = 2f64.sqrt();
    let arm = (root + (1.0 + root).ln()) / 6.0;
    for kinds in [
        [CellKind::Hex8; 2],
        [CellKind::Tet4, CellKind::Hex20],
        [CellKind::Hex27, CellKind::Tet10],
    ] {
        let (_, solution) = spun(kinds, 6, 0.5);
        let contact = &solution.contacts[0];
        let pressure = contact.resultant[2];
        // 1000 · 0.003/0.3, less what the lower box gives way
        assert!((pressure - 10.0).abs() < 0.1, "{pressure}");
        let mut moment = 0.0;
        for node in &contact.nodes {
            if node.status == Status::Open {
                continue;
            }
            assert_eq!(node.status, Status::Slip, "{:?}", node.point);
            moment += node.weight * cross(node.point, node.shear)[2];
            // friction is against the slip, and all that it may be
            let bound = 0.4 * node.pressure;
            assert!((norm(node.shear) / bound - 1.0).abs() < 1e-7);
            assert!(dot(node.shear, node.slip) < -0.999_999 * bound * norm(node.slip));
        }
        let expected = 0.4 * pressure * arm;
        // tangents turn by some degrees over the support of a node
        assert!(
            (moment / expected + 1.0).abs() < 0.02,
            "{moment} {expected}"
        );
        let total = &solution.bodies[1].couples[0].moment[2];
        assert!((total - moment.abs()).abs() < 1e-2 * expected, "{total}");
    }
}

/// A stack of boxes, each turned against the one below, on a rigid plane; gravity tilted about an axis.
fn stack(tilt: f64, direction: f64, friction: f64) -> Model<3> {
    let mut model = Model::new();
    let (s, c) = tilt.sin_cos();
    let gravity = [s * direction.cos(), s * direction.sin(), -c];
    let mut below: Option<BodyId> = None;
    for k in 0..3 {
        let height = 0.4 * k as f64;
        let kind = [CellKind::Hex8, CellKind::Tet4, CellKind::Hex20][k];
        let mesh = cuboid(
            [-0.5, -0.5, height],
            [0.5, 0.5, height + 0.4],
            [2 + k % 2, 2, 1],
            kind,
        );
        let angle = 0.35 * k as f64;
        let (sa, ca) = angle.sin_cos();
        let mesh = mesh
            .map_points(|[x, y, z]| [ca * x - sa * y, sa * x + ca * y, z])
            .unwrap();
        let body = model.body(&format!("box{k}"), mesh, CORK);
        model.bodies[body.0].body_force = gravity.map(Field::constant);
        match below {
            None => {
                model.obstacle((body, "bottom"), Field::constant(0.0)).law =
                    Law::Coulomb(Field::constant(friction));
            }
            Some(other) => {
                let contact = model.contact((body, "bottom"), (other, "top"));
                contact.law = Law::Coulomb(Field::constant(friction));
            }
        }
        below = Some(body);
    }
    model
}

#[test]
fn a_stack_slides_beyond_the_angle_of_friction_about_any_axis() {
    for direction in [0.0, 0.7, 2.0] {
        let friction = 0.2;
        let angle = f64::atan(friction);
        let solution = stack(0.98 * angle, direction, friction).solve().unwrap();
        assert!(solution.converged);
        let error = stack(1.02 * angle, direction, friction)
            .solve()
            .unwrap_err();
        let said = error.to_string();
        // all three joints are as strong
        let load = said.contains("slide (translation along") && said.contains("holds 0.9798");
        assert!(load, "{said}");
    }
}

/// A block on springs that are soft along its normal, dragged over a base by a little more than Tresca's bounds bear on most nodes: the
/// block as a whole is ten thousand times as soft as its nodes are among each other.
#[test]
fn directions_of_slip_below_a_soft_block_settle() {
    let text = |side: &str| {
        format!(
            "analysis = \"3d\"\n\
             [[body]]\nname = \"up\"\n\
             mesh = {{ box = {{ from = [0, 0, 0], to = [1, 1, 1], cells = [2, 1, 1], cell = \"hex8\" }} }}\n\
             material = {{ young = 1000, poisson = 0.3 }}\n\
             load = [{{ side = \"top\", traction = [-0.0072, 0, -0.1] }}]\n\
             spring = [{{ side = \"top\", tangential = 50, normal = 0.1 }}]\n\
             [[body]]\nname = \"low\"\n\
             mesh = {{ box = {{ from = [-0.3, 0, -1], to = [1.3, 1, 0], cells = [2, 2, 1], cell = \"tet4\" }} }}\n\
             material = {{ young = 1000, poisson = 0.3 }}\n\
             fix = [{{ side = \"bottom\", x = 0, y = 0, z = 0 }}]\n\
             [[contact]]\nname = \"c\"\n{side}\nfriction = {{ tresca = 0.0163 }}\n"
        )
    };
    for side in [
        "nonmortar = \"low.top\"\nmortar = \"up.bottom\"",
        "nonmortar = \"up.bottom\"\nmortar = \"low.top\"",
    ] {
        let case = Case::<3>::from_str(&text(side), "soft.toml", "".as_ref()).unwrap();
        let solution = case.model.solve().unwrap();
        assert!(
            solution.solver.iterations <= 40,
            "{}",
            solution.solver.iterations
        );
        for node in &solution.contacts[0].nodes {
            let (shear, slip) = (norm(node.shear), norm(node.slip));
            assert!(shear <= 0.0163 * (1.0 + 1e-6), "{node:?}");
            if slip > 1e-8 {
                assert!(
                    dot(node.shear, node.slip) < -(1.0 - 1e-6) * 0.0163 * slip,
                    "{node:?}"
                );
            }
        }
    }
}
