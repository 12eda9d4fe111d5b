//! Joints that bear tension and cohesion until they part or slip, over load steps.
//!
//! Blocks without Poisson's effect, moved by supports: stresses are uniform, and what the joint does follows by hand. Tolerances
//! are those of the certificate, 1e-8, on stresses of the order of one.

use dotyk::case::{Case, CaseError};
use dotyk::model::{ContactNode, Model, Solution, Status};

fn model(text: &str) -> Model<2> {
    Case::<2>::from_str(text, "joints.toml", "".as_ref())
        .unwrap()
        .model
}

fn solved(text: &str) -> Vec<Solution<2>> {
    let steps = model(text).solve_steps().unwrap();
    assert!(steps.iter().all(|step| step.converged));
    steps
}

fn refused(text: &str) -> CaseError {
    match Case::<2>::from_str(text, "joints.toml", "".as_ref()) {
        Ok(case) => {
            let error = case.model.solve_steps().unwrap_err();
            case.error(error.subject().as_ref(), &error.to_string())
        }
        Err(error) => error,
    }
}

/// A value of each step as an expression of the time 1, 2, ..
fn course(values: &[f64]) -> String {
    let each = values.iter().zip(1..);
    let each = each.map(|(u, t)| format!("({u})*max(0, 1 - abs(t - {t}))"));
    each.collect::<Vec<_>>().join(" + ")
}

fn steps(count: usize) -> String {
    (1..=count)
        .map(|t| format!("[[step]]\ntime = {t}\n"))
        .collect()
}

/// Two blocks of height 1 and E = 1000, the upper one moved at its top by u and v.
fn blocks([u, v]: [&[f64]; 2], law: &str, swapped: bool) -> String {
    let (nonmortar, mortar) = match swapped {
        false => ("upper.bottom", "lower.top"),
        true => ("lower.top", "upper.bottom"),
    };
    format!(
        "title = \"Joint\"\nanalysis = \"plane-stress\"\n{}\
         [[body]]\nname = \"lower\"\n\
         mesh = {{ rectangle = {{ from = [0, 0], to = [2, 1], cells = [5, 2], cell = \"quad4\" }} }}\n\
         material = {{ young = 1000, poisson = 0 }}\nfix = [{{ side = \"bottom\", x = 0, y = 0 }}]\n\
         [[body]]\nname = \"upper\"\n\
         mesh = {{ rectangle = {{ from = [0, 1], to = [2, 2], cells = [3, 2], cell = \"quad4\" }} }}\n\
         material = {{ young = 1000, poisson = 0 }}\n\
         fix = [{{ side = \"top\", x = \"{}\", y = \"{}\" }}]\n\
         [[contact]]\nname = \"joint\"\nnonmortar = \"{nonmortar}\"\nmortar = \"{mortar}\"\nfriction = {law}\n",
        steps(u.len()),
        course(u),
        course(v)
    )
}

fn nodes(step: &Solution<2>) -> &[ContactNode<2>] {
    &step.contacts[0].nodes
}

/// σ = 500 v up to 5, then a gap; in the step in which it parts it still pulls with 5, afterwards not any more.
#[test]
fn a_joint_pulls_until_it_parts_and_never_again() {
    let v = [0.008, 0.012, 0.012, -0.004, 0.002];
    let expected = [
        (-4.0, 0.0, Status::Stick),
        (-5.0, 0.002, Status::Open),
        (0.0, 0.012, Status::Open),
        (2.0, 0.0, Status::Stick),
        (0.0, 0.002, Status::Open),
    ];
    for swapped in [false, true] {
        let law = "{ coulomb = 0.5, cohesion = 4, tension = 5 }";
        let found = solved(&blocks([&[0.0; 5], &v], law, swapped));
        for (step, (pressure, gap, status)) in found.iter().zip(expected) {
            for node in nodes(step) {
                assert!(
                    (node.pressure - pressure).abs() < 1e-6,
                    "{} {pressure}",
                    node.pressure
                );
                assert!((node.gap - gap).abs() < 1e-9, "{} {gap}", node.gap);
                assert_eq!(node.status, status);
                assert!(node.shear.iter().all(|s| s.abs() < 1e-6));
            }
            let top: f64 = step.bodies[1].reaction[1];
            assert!((top + 2.0 * pressure).abs() < 1e-6, "{top} {pressure}");
        }
        let told: Vec<usize> = found.iter().map(|step| step.warnings.len()).collect();
        let parted = |step: &Solution<2>| {
            step.warnings
                .iter()
                .any(|w| w.contains("parted or slipped"))
        };
        assert!(
            parted(&found[1]) && !parted(&found[0]) && !parted(&found[2]),
            "{told:?}"
        );
        assert!(
            found[1]
                .warnings
                .iter()
                .any(|w| w.contains(&format!("{} nodes", nodes(&found[1]).len())))
        );
    }
}

/// Pressed by 3 it bears 2 + 0.5 · 3 until it slips, and 0.5 · 3 from the next step on.
#[test]
fn a_joint_that_slips_keeps_its_friction_alone() {
    let u = [0.001, 0.1, 0.1001, 0.2, -0.2];
    let v = [-0.006; 5];
    for (law, whole) in [
        ("{ coulomb = 0.5, cohesion = 2 }", 3.5),
        ("{ coulomb = 0.5, cohesion = 2, tension = 3 }", 3.5),
        ("{ cohesion = 2, tension = 30 }", 2.0),
    ] {
        let dry = if law.contains("coulomb") { 1.5 } else { 0.0 };
        let found = solved(&blocks([&u, &v], law, false));
        let force = |step: usize| found[step].contacts[0].resultant[0];
        assert!(
            force(0).abs() < 2.0 * whole
                && nodes(&found[0]).iter().all(|n| n.status == Status::Stick)
        );
        for (step, expected) in [(1, -whole), (3, -dry), (4, dry)] {
            assert!(
                (force(step) - 2.0 * expected).abs() < 1e-5,
                "{law} {step}: {}",
                force(step)
            );
            assert!(nodes(&found[step]).iter().all(|n| n.status == Status::Slip));
        }
        // the shear of the step before is more than it now bears
        assert!(force(2).abs() < 2.0 * dry + 1e-6, "{}", force(2));
    }
}

/// It is also lost to what comes later, and a joint that has a gap was never whole.
#[test]
fn what_is_lost_stays_lost_from_stage_to_stage() {
    let v = [0.012, 0.012, 0.002, -0.004, 0.002];
    let text = blocks(
        [&[0.0; 5], &v],
        "{ coulomb = 0.5, cohesion = 4, tension = 5 }",
        false,
    );
    let other = "[[body]]\nname = \"other\"\nmesh = { rectangle = { from = [5, 0], to = [6, 1], cells = [1, 1] } }\n\
                 material = { young = 1, poisson = 0 }\nfix = [{ side = \"bottom\", x = 0, y = 0 }]\nactive = { from = 3 }\n";
    let found = solved(&(text.clone() + other));
    let alone = solved(&text);
    for (found, alone) in found.iter().zip(&alone) {
        for (found, alone) in nodes(found).iter().zip(nodes(alone)) {
            assert!((found.pressure - alone.pressure).abs() < 1e-6);
            assert!((found.gap - alone.gap).abs() < 1e-9);
        }
    }
    for step in [2, 4] {
        assert!(
            nodes(&found[step])
                .iter()
                .all(|n| n.pressure.abs() < 1e-9 && n.status == Status::Open)
        );
    }
    let apart = text.replace("friction =", "gap = 0.001\nfriction =");
    let found = solved(&apart);
    assert!(nodes(&found[0]).iter().all(|n| n.pressure.abs() < 1e-9));
}

/// What remains of a strip is torn off from one end: only what has parted is lost.
#[test]
fn a_joint_may_be_lost_in_part() {
    let text = blocks(
        [&[0.0; 3], &[0.0, 0.0, 0.0]],
        "{ coulomb = 0.5, cohesion = 4, tension = 5 }",
        false,
    )
    .replace("y = \"(0)", "y = \"0.0035*t*x + (0)");
    let found = solved(&text);
    let open = |step: usize| {
        nodes(&found[step])
            .iter()
            .filter(|n| n.status == Status::Open)
            .count()
    };
    assert_eq!(open(0), 0);
    assert!(
        open(1) > 0 && open(1) < nodes(&found[1]).len() && open(2) >= open(1),
        "{} {}",
        open(1),
        open(2)
    );
    for step in 1..3 {
        for node in nodes(&found[step]) {
            assert!(node.pressure >= -5.0 - 1e-6);
            let lost_before = nodes(&found[step - 1])
                .iter()
                .any(|n| n.node == node.node && n.status == Status::Open);
            if lost_before {
                assert!(node.pressure >= -1e-9, "{}", node.pressure);
            }
        }
    }
}

/// A block that comes on a base that has risen fits it, however far that is: its joint bears half of its strength.
#[test]
fn the_joint_of_a_body_that_comes_is_whole() {
    for rise in [0.2, 20.0, -20.0] {
        let text = format!(
            "title = \"Late\"\nanalysis = \"plane-strain\"\n{}\
             [[body]]\nname = \"base\"\nmesh = {{ rectangle = {{ from = [0, 0], to = [2, 1], cells = [4, 2] }} }}\n\
             material = {{ young = 1000, poisson = 0 }}\n\
             fix = [{{ side = \"bottom\", x = 0, y = 0 }}, {{ side = \"left\", x = 0 }}, {{ side = \"right\", x = 0 }}]\n\
             load = [{{ side = \"top\", traction = [0, {rise}], active = {{ until = 2 }} }}]\n\
             [[body]]\nname = \"block\"\nmesh = {{ rectangle = {{ from = [0, 1], to = [2, 2], cells = [4, 2] }} }}\n\
             material = {{ young = 1000, poisson = 0 }}\nactive = {{ from = 2 }}\n\
             spring = [{{ side = \"top\", normal = 1e-3, tangential = 1e-3 }}]\n\
             load = [{{ side = \"top\", traction = [0, \"{rise} + 0.5\"] }}]\n\
             [[contact]]\nname = \"joint\"\nnonmortar = \"block.bottom\"\nmortar = \"base.top\"\n\
             friction = {{ coulomb = 0.5, cohesion = 100, tension = 100 }}\n",
            steps(2)
        );
        // the base is let down by what the block is pulled up with: nothing moves but by the half
        let found = solved(&text);
        for node in nodes(&found[1]) {
            assert_eq!(node.status, Status::Stick);
            assert!(
                (node.pressure + rise + 0.5).abs() < 1e-3,
                "{}",
                node.pressure
            );
            assert!(node.gap.abs() < 1e-9, "{}", node.gap);
        }
    }
}

/// What comes between bodies that have parted is bonded to nothing; between those that touch it is whole.
#[test]
fn a_joint_that_comes_between_bodies_holds_where_they_touch() {
    for (apart, pressure) in [(0.002, 0.0), (0.0, -0.5), (-0.002, 0.5)] {
        let law = "{ coulomb = 0.5, cohesion = 4, tension = 5 }\nactive = { from = 2 }";
        // moved by its head, and then by a thousandth more
        let text = blocks([&[0.0; 2], &[apart, apart + 0.001]], law, false);
        let found = solved(&text);
        for node in nodes(&found[1]) {
            // a gap of blocks that nothing holds together is that of the head
            let (expected, gap) = match apart > 0.0 {
                true => (0.0, apart + 0.001),
                false => (pressure, 0.0),
            };
            assert!(
                (node.pressure - expected).abs() < 1e-6,
                "{apart}: {}",
                node.pressure
            );
            assert!((node.gap - gap).abs() < 1e-9, "{}", node.gap);
        }
    }
}

/// In a joint on supports so weak that a block alone would fly off, what parts is parted all the same.
#[test]
fn what_parts_is_lost_however_weak_the_supports_are() {
    for spring in ["1e-2", "1e-4", "1e-6"] {
        let text = format!(
            "title = \"Weak\"\nanalysis = \"plane-strain\"\n{}\
             [[body]]\nname = \"base\"\nmesh = {{ rectangle = {{ from = [0, 0], to = [2, 1], cells = [8, 4] }} }}\n\
             material = {{ young = 1000, poisson = 0.2 }}\nfix = [{{ side = \"bottom\", x = 0, y = 0 }}]\n\
             [[body]]\nname = \"block\"\nmesh = {{ rectangle = {{ from = [0, 1], to = [2, 2], cells = [8, 4] }} }}\n\
             material = {{ young = 1000, poisson = 0.2 }}\n\
             spring = [{{ side = \"top\", normal = {spring}, tangential = {spring} }}]\n\
             load = [{{ side = \"top\", traction = [\"0.3*t\", \"-0.2 - x\"] }}]\n\
             [[contact]]\nname = \"joint\"\nnonmortar = \"block.bottom\"\nmortar = \"base.top\"\n\
             friction = {{ coulomb = 0.5, cohesion = 0.6, tension = 0.3 }}\n",
            steps(3)
        );
        let found = solved(&text);
        let parted = nodes(&found[0]).iter().filter(|node| node.gap > 1e-6);
        assert!(parted.count() > 0, "{spring}");
        for step in 1..3 {
            for (now, then) in nodes(&found[step]).iter().zip(nodes(&found[step - 1])) {
                if then.gap > 1e-6 {
                    assert!(now.pressure > -1e-9, "{spring}: {}", now.pressure);
                }
            }
        }
    }
}

/// Ground that nobody touches neither parts from a wall beside it nor slips along it: the cohesion is there afterwards.
#[test]
fn a_joint_of_untouched_ground_is_whole() {
    for (far, tension) in [(0.0, 0.0), (0.0, 1.5), (3000.0, 0.0)] {
        let text = format!(
            "title = \"Wall\"\nanalysis = \"plane-strain\"\n{}\
             [[body]]\nname = \"rock\"\n\
             mesh = {{ rectangle = {{ from = [{far}, 0], to = [{}, 3], cells = [3, 5], cell = \"tri3\" }} }}\n\
             material = {{ young = 1000, poisson = 0.3 }}\n\
             initial_stress = {{ vertical = \"-0.1*(3.1 - y)\", k0 = 0.7 }}\nbody_force = [0, -0.1]\n\
             fix = [{{ side = \"bottom\", x = 0, y = 0 }}, {{ side = \"left\", x = 0 }}]\n\
             load = [{{ side = \"top\", in_situ = 1 }}, {{ side = \"right\", in_situ = 1 }}]\n\
             [[body]]\nname = \"wall\"\n\
             mesh = {{ rectangle = {{ from = [{}, 0], to = [{}, 3], cells = [2, 7], cell = \"quad9\" }} }}\n\
             material = {{ young = 1000, poisson = 0.3 }}\n\
             fix = [{{ side = \"right\", x = \"-0.0001*(t-1)\", y = \"-0.001*(t-1)\" }}]\n\
             [[contact]]\nname = \"joint\"\nnonmortar = \"wall.left\"\nmortar = \"rock.right\"\n\
             friction = {{ coulomb = 0.5, cohesion = 1.0, tension = {tension} }}\n",
            steps(2),
            far + 2.0,
            far + 2.0,
            far + 3.0
        );
        let found = solved(&text);
        let parted = found[0]
            .warnings
            .iter()
            .any(|w| w.contains("parted or slipped"));
        assert!(!parted, "{:?}", found[0].warnings);
        for body in &found[0].bodies {
            let moved = body.displacement.iter().flatten();
            assert!(moved.fold(0.0, |s: f64, u| s.max(u.abs())) < 1e-15);
        }
        for node in nodes(&found[1]) {
            // the same shear overcomes dry friction, and not the cohesion
            assert_ne!(node.status, Status::Slip, "{:?}", node.point);
        }
    }
}

/// A block that shrinks on its joint: the shear at its corners lifts these off, and its weight presses them on again as soon as
/// that shear is gone. Where that happens friction is left, and the rest of the joint is whole.
#[test]
fn a_joint_that_its_own_shear_lifts_is_lost_within_the_step() {
    let text = format!(
        "title = \"Shrinking\"\nanalysis = \"plane-strain\"\n{}\
         [[body]]\nname = \"base\"\n\
         mesh = {{ rectangle = {{ from = [-1, -1], to = [2, 0], cells = [6, 2] }} }}\n\
         material = {{ young = 1000, poisson = 0.3 }}\nfix = [{{ side = \"bottom\", x = 0, y = 0 }}]\n\
         [[body]]\nname = \"block\"\n\
         mesh = {{ rectangle = {{ from = [0, 0], to = [1, 0.3], cells = [2, 2] }} }}\n\
         material = {{ young = 1000, poisson = 0.45 }}\n\
         initial_strain = {{ xx = -0.008, yy = -0.008 }}\n\
         load = [{{ side = \"top\", traction = [0, -0.25] }}]\n\
         [[contact]]\nname = \"joint\"\nnonmortar = \"block.bottom\"\nmortar = \"base.top\"\n\
         friction = {{ coulomb = 0.3, cohesion = 1.6 }}\n",
        steps(2)
    );
    let found = solved(&text);
    let told = |step: &Solution<2>| {
        let lifts = |w: &&String| w.contains("the shear that the joint bears lifts it off");
        step.warnings.iter().filter(lifts).count()
    };
    // what is lost stays lost, and is told once
    assert_eq!([told(&found[0]), told(&found[1])], [1, 0]);
    let lifts = found[0]
        .warnings
        .iter()
        .find(|w| w.contains("lifts it off"));
    assert!(
        lifts.is_some_and(|w| w.contains("at node 0 (0, 0)")),
        "{lifts:?}"
    );
    for node in nodes(&found[0]) {
        let corner = node.point[0] == 0.0;
        let bound = 0.3 * node.pressure + if corner { 0.0 } else { 1.6 };
        let shear = node.shear[0].abs();
        assert!(node.pressure > 0.0 && node.gap.abs() < 1e-12);
        assert!(shear < bound + 1e-7, "{:?}: {shear} {bound}", node.point);
        if node.status == Status::Slip {
            assert!(shear > bound - 1e-7 && node.shear[0] * node.slip[0] < 0.0);
        } else {
            assert!(node.slip[0].abs() < 1e-12);
        }
    }
    // a body that is loaded from above alone, and balanced
    let pressed: f64 = nodes(&found[0]).iter().map(|n| n.weight * n.pressure).sum();
    let drawn: f64 = nodes(&found[0]).iter().map(|n| n.weight * n.shear[0]).sum();
    assert!((pressed - 0.25).abs() < 1e-9 && drawn.abs() < 1e-9);
}

#[test]
fn nonsense_is_one_clear_error() {
    let case = |law: &str| blocks([&[0.0], &[0.0]], law, false);
    for (law, words) in [
        (
            "{ coulomb = 0.5, cohesion = 2, tension = 4.1 }",
            "more tension than its cohesion allows",
        ),
        (
            "{ coulomb = 0.5, tension = 1 }",
            "has tension and no cohesion",
        ),
        ("{ tension = 1 }", "has tension and no cohesion"),
        ("{ coulomb = 0.5, cohesion = 2, tension = -1 }", "negative"),
        ("{ coulomb = 0.5, cohesion = -2, tension = 1 }", "negative"),
        (
            "{ coulomb = 0.5, cohesion = 2, tensoin = 1 }",
            "unknown key `tensoin`",
        ),
        (
            "{ coulomb = 0.5, cohesion = 2, tension = \"3 + x\" }",
            "between 0 and cohesion over coulomb",
        ),
        (
            "{ coulomb = 0.5, cohesion = 2, tension = \"1 - x\" }",
            "between 0 and cohesion over coulomb",
        ),
    ] {
        let error = refused(&case(law)).to_string();
        assert!(error.contains(words), "{law}: {error}");
    }
}
