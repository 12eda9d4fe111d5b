//! What a check tells of loads and clearances, beside sums by hand.

use dotyk::case::Case;
use dotyk::model::{BodyCheck, Check};

fn check(text: &str) -> Check<2> {
    let case = Case::<2>::from_str(text, "check.toml", "".as_ref());
    let check = case.unwrap_or_else(|e| panic!("{e}")).model.check();
    assert!(check.errors.is_empty(), "{:?}", check.errors);
    check
}

fn body(name: &str, [x, y]: [f64; 2], keys: &str) -> String {
    format!(
        "[[body]]\nname = \"{name}\"\nmesh = {{ rectangle = {{ from = [{x}, {y}], to = [{}, {}], cells = [4, 2] }} }}\n{keys}\n",
        x + 2.0,
        y + 1.0
    )
}

const STEEL: &str = "material = { young = 1e4, poisson = 0.3 }";
const HELD: &str = "fix = [{ side = \"bottom\", x = 0, y = 0 }]";
const SOLE: &str = "[[contact]]\nname = \"sole\"\nsides = [\"block.bottom\", \"base.top\"]\n";

/// A block on a base in plane strain, with keys of the block and of their contact, and what else there is.
fn on_base(block: &str, contact: &str, rest: &str) -> Check<2> {
    check(&format!(
        "analysis = \"plane-strain\"\n{}{}{SOLE}{contact}\n{rest}\n",
        body("base", [0.0, 0.0], &format!("{STEEL}\n{HELD}")),
        body("block", [0.0, 1.0], block),
    ))
}

/// The load that is told of a motion of a body.
fn on(body: &BodyCheck<2>, motion: &str) -> f64 {
    let told = body.floating.iter().find(|f| f.starts_with(motion));
    let told = told.unwrap_or_else(|| panic!("{motion}: {:?}", body.floating));
    let (_, rest) = told.split_once("load on it ").unwrap();
    rest.split(", held").next().unwrap().parse().unwrap()
}

fn near(found: f64, expected: f64) {
    let scale = expected.abs().max(1.0);
    // figures are told to six digits
    assert!(
        (found - expected).abs() < 1e-5 * scale,
        "{found} {expected}"
    );
}

/// Cohesion and tension of a joint, the force of a bar and what a bed bears are no loads, nor is heat.
#[test]
fn what_bears_is_no_load() {
    let block = format!("{STEEL}\nload = [{{ side = \"top\", traction = [0, -3] }}]");
    let joint = "friction = { coulomb = 0.5, cohesion = 2, tension = 1 }";
    let bar = "[[bar]]\nname = \"bolt\"\nfrom = { side = \"base.bottom\" }\nto = { side = \"block.top\" }\n\
               young = 1e5\narea = 0.01\nprestress = 7\n";
    let heat = "initial_strain = { thermal = 20, expansion = 1e-4 }";
    for found in [
        on_base(&block, "friction = 0.5", ""),
        on_base(&block, joint, ""),
        on_base(&block, joint, bar),
        on_base(&format!("{block}\n{heat}"), "friction = 0.5", bar),
    ] {
        let block = &found.bodies[1];
        assert_eq!(block.load[0], 0.0);
        near(block.load[1], -6.0);
        near(on(block, "translation along y"), -6.0);
        assert_eq!(on(block, "translation along x"), 0.0);
        assert_eq!(on(block, "rotation"), 0.0);
    }
    // on a bed that only presses, half as thick
    let keys = "material = { young = 1e4, poisson = 0.3, thickness = 0.5 }\nfix = [{ side = \"left\", x = 0 }]\n\
                spring = [{ side = \"bottom\", normal = 10, compression_only = true }]\n\
                body_force = [0, -2]\nload = [{ side = \"top\", pressure = 3 }]";
    let text = format!(
        "analysis = \"plane-stress\"\n{}",
        body("block", [0.0, 0.0], keys)
    );
    let found = check(&text);
    near(found.bodies[0].load[1], -0.5 * (2.0 * 2.0 + 3.0 * 2.0));
    near(on(&found.bodies[0], "translation along y"), -5.0);
}

/// A force and a moment at a point that a side moves with load the body.
#[test]
fn loads_through_a_couple_are_loads() {
    for kind in ["rigid", "average"] {
        let keys = |load: &str, fix: &str| {
            format!(
                "{STEEL}\npoints = {{ P = [1.75, 3] }}\ncouple = [{{ side = \"top\", point = \"P\", kind = \"{kind}\" }}]\n\
                 load = [{{ point = \"P\", {load} }}]\n{fix}"
            )
        };
        let load = "force = [0.5, -3], moment = 0.4";
        let found = on_base(&keys(load, ""), "friction = 0.5", "");
        let block = &found.bodies[1];
        assert_eq!(block.load, [0.5, -3.0], "{kind}");
        near(on(block, "translation along y").abs(), 3.0);
        near(on(block, "translation along x").abs(), 0.5);
        // about (1, 1.5), the corners 1.118 away: x F_y − y F_x + M
        let moment = 0.75 * -3.0 - 1.5 * 0.5 + 0.4;
        near(
            on(block, "rotation about (1, 1.5)").abs(),
            -moment / 1.25f64.sqrt(),
        );
        let told = &block.couples[0];
        assert!(
            told.contains("nothing held, force (0.5, -3), moment 0.4"),
            "{told}"
        );
        // what the support of the point bears loads nothing
        let found = on_base(
            &keys(load, "fix = [{ point = \"P\", x = 0 }]"),
            "friction = 0.5",
            "",
        );
        near(on(&found.bodies[1], "translation along y").abs(), 3.0);
        assert_eq!(on(&found.bodies[1], "translation along x"), 0.0, "{kind}");
        assert!(!found.bodies[1].couples[0].contains("moment 0,"));
    }
}

#[test]
fn loads_around_an_axis_are_those_of_the_full_turn() {
    let keys = format!(
        "{STEEL}\nload = [{{ side = \"top\", pressure = 3 }}, {{ point = \"P\", force = [0, -4] }}]\npoints = {{ P = [2, 2] }}\n\
         couple = [{{ side = \"top\", point = \"P\", kind = \"rigid\" }}]"
    );
    let found = check(&format!(
        "analysis = \"axisymmetric\"\n{}{}{SOLE}",
        body("base", [1.0, 0.0], &format!("{STEEL}\n{HELD}")),
        body("block", [1.0, 1.0], &keys),
    ));
    let all = -3.0 * std::f64::consts::PI * (9.0 - 1.0) - 4.0;
    near(found.bodies[1].load[1], all);
    near(on(&found.bodies[1], "translation along y"), all);
    assert_eq!(found.bodies[1].couples[0].matches("moment").count(), 0);
}

/// Sums that are rounding of what cancels, and gaps that are rounding of the place, are zero.
#[test]
fn figures_that_are_rounding_are_told_as_none() {
    let pulled = format!(
        "{STEEL}\nload = [{{ side = \"left\", traction = [-0.3, 0.1] }}, {{ side = \"right\", traction = [\"0.1 + 0.2\", -0.1] }}, {{ side = \"top\", pressure = 1 }}]"
    );
    let found = on_base(&pulled, "friction = 0.5\ngap = \"1e-17*(1 + x)^2\"", "");
    assert_eq!(found.bodies[1].load[0], 0.0);
    assert_eq!(on(&found.bodies[1], "translation along x"), 0.0);
    assert_eq!(
        (found.contacts[0].clearance, found.contacts[0].penetration),
        (0.0, 0.0)
    );
    let text = found.to_string();
    assert!(
        text.contains("touching initially") && !text.contains("e-1"),
        "{text}"
    );
}
