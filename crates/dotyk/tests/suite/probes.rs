//! Probes of friction, couples and obstacles in space against closed forms.

use dotyk::case::Case;
use dotyk::model::Solution;
use std::path::Path;

fn case(text: &str) -> Case<3> {
    Case::<3>::from_str(text, "case.toml", Path::new(".")).unwrap()
}

#[track_caller]
fn reads(solution: &Solution<3>, probe: &str, expected: f64) {
    let found = solution.probe(probe).unwrap();
    // solved to 1e-8 of the largest overlap; the largest value here is 4
    assert!(
        (found - expected).abs() < 1e-7,
        "{probe}: {found} {expected}"
    );
}

/// A block of 2 × 1 × 1 that does not contract across a load is held at its top 0.004 below where it was, on a rigid plane
/// that is dragged by s along (0.6, 0.8). The pressure is p = 4, the bound of friction 1; tractions of that size on its four
/// sides make the stress constant, so that at the bound it sinks aside by 1·h/G = 0.002, and the rest of s is slip.
const DRAGGED: &str = r#"
analysis = "3d"
[[body]]
name = "block"
mesh = { box = { from = [0, 0, 0], to = [2, 1, 1], cells = [3, 2, 2] } }
material = { young = 1000, poisson = 0 }
fix  = [{ side = "top", x = 0, y = 0, z = -0.004 }]
load = [
  { side = "right", traction = [0, 0, "-0.6*min(t, 1)"] }, { side = "left", traction = [0, 0, "0.6*min(t, 1)"] },
  { side = "back", traction = [0, 0, "-0.8*min(t, 1)"] }, { side = "front", traction = [0, 0, "0.8*min(t, 1)"] },
]
[[contact]]
name = "sole"
nonmortar = "block.bottom"
obstacle = { plane = { point = [0, 0, 0], normal = [0, 0, 1] }, displacement = ["0.6*0.005*t", "0.8*0.005*t", 0] }
friction = 0.25
[[step]]
time = 0
[[step]]
time = 1
[[step]]
time = 2
"#;

fn probe(quantity: &str, place: &str) -> String {
    format!("[[probe]]\nname = \"{quantity}\"\nquantity = \"{quantity}\"\n{place}\n")
}

#[test]
fn components_areas_and_work_of_friction_are_those_of_a_dragged_block() {
    let fields = [
        "shear.x",
        "shear.y",
        "shear.z",
        "shear.magnitude",
        "shear",
        "slip.x",
        "slip.y",
        "slip.magnitude",
    ];
    let numbers = [
        "length",
        "length_stick",
        "length_slip",
        "dissipated_work",
        "dissipated_work_total",
        "displacement_obstacle.x",
        "displacement_obstacle.magnitude",
    ];
    let of = |name: &&str| format!("sole.{name}");
    let fields = fields.iter().map(|f| probe(&of(f), "at = [0.7, 0.3, 0]"));
    let numbers = numbers.iter().map(|n| probe(&of(n), ""));
    let probes: String = fields.chain(numbers).collect();
    let case = case(&(DRAGGED.to_string() + &probes));
    let steps = case.model.solve_steps().unwrap();
    let area = 2.0;
    let slips = [0.0, 0.003, 0.008];
    for (step, solution) in steps.iter().enumerate() {
        let slides = f64::from(u8::from(step > 0));
        for (name, expected) in [
            ("shear.x", 0.6 * slides),
            ("shear.y", 0.8 * slides),
            ("shear.z", 0.0),
            ("shear.magnitude", slides),
            ("shear", slides),
            ("slip.x", -0.6 * slips[step]),
            ("slip.y", -0.8 * slips[step]),
            ("slip.magnitude", slips[step]),
            ("length", area),
            ("length_stick", area * (1.0 - slides)),
            ("length_slip", area * slides),
            ("dissipated_work_total", area * slips[step]),
            (
                "dissipated_work",
                area * (slips[step] - slips[step.saturating_sub(1)]),
            ),
            ("displacement_obstacle.x", 0.003 * step as f64),
            ("displacement_obstacle.magnitude", 0.005 * step as f64),
        ] {
            reads(solution, &format!("sole.{name}"), expected);
        }
    }
}

/// A bar of 2 × 1 × 3, held at its top, under which a plate that is 0.25 away carries a force.
#[test]
fn a_loaded_obstacle_moves_by_its_clearance_and_what_the_bar_gives_way() {
    let text = r#"
analysis = "3d"
[[body]]
name = "bar"
mesh = { box = { from = [0, 0, 0], to = [2, 1, 3], cells = [2, 1, 2] } }
material = { young = 1000, poisson = 0.3 }
fix  = [{ side = "top", z = 0 }, { side = "left", x = 0 }, { side = "front", y = 0 }]
[[contact]]
name = "plate"
nonmortar = "bar.bottom"
obstacle = { plane = { point = [0, 0, -0.25], normal = [0, 0, 1] }, force = [0, 0, 8] }
"#;
    let probes = ["z", "magnitude"].map(|c| probe(&format!("plate.displacement_obstacle.{c}"), ""));
    let solution = case(&(text.to_string() + &probes.concat()))
        .model
        .solve()
        .unwrap();
    let rise = 0.25 + 8.0 * 3.0 / (1000.0 * 2.0);
    for component in ["z", "magnitude"] {
        reads(
            &solution,
            &format!("plate.displacement_obstacle.{component}"),
            rise,
        );
    }
}

/// A beam of length 6 and section 1 × 1 that a moment bends to a circle: the end turns by M L/(E I) about its axis.
const BENT: &str = r#"
analysis = "3d"
[[body]]
name = "beam"
mesh = { box = { from = [0, 0, 0], to = [6, 1, 1], cells = [3, 1, 1], cell = "hex20" } }
material = { young = 1000, poisson = 0 }
points = { tip = [6, 0.5, 0.5] }
couple = [{ side = "right", point = "tip", kind = "rigid" }]
fix  = [{ side = "left", x = 0, y = 0, z = 0 }]
load = [{ point = "tip", moment = [0, 0.3, 0.1] }]
"#;

#[test]
fn the_point_of_a_couple_turns_as_the_end_of_a_beam() {
    let probes = ["x", "y", "z"].map(|axis| {
        let quantity = format!("beam.rotation.{axis}");
        probe(&quantity, "at = \"beam.tip\"")
    });
    let solution = case(&(BENT.to_string() + &probes.concat()))
        .model
        .solve()
        .unwrap();
    let turn = |moment: f64| moment * 6.0 / (1000.0 / 12.0);
    for (axis, expected) in [("x", 0.0), ("y", turn(0.3)), ("z", turn(0.1))] {
        reads(&solution, &format!("beam.rotation.{axis}"), expected);
    }
}

#[test]
fn rotations_elsewhere_and_obstacles_that_are_bodies_are_refused() {
    for place in ["at = [6, 0.5, 0.5]", "reduce = \"max\""] {
        let text = BENT.to_string() + &probe("beam.rotation.y", place);
        let error = Case::<3>::from_str(&text, "case.toml", Path::new(".")).unwrap_err();
        let said = error.to_string();
        assert!(said.contains("that of the point of a couple"), "{said}");
    }
    let text = r#"
analysis = "3d"
[[body]]
name = "low"
mesh = { box = { from = [0, 0, 0], to = [1, 1, 1], cells = [1, 1, 1] } }
material = { young = 1000, poisson = 0 }
fix  = [{ side = "bottom", x = 0, y = 0, z = 0 }]
[[body]]
name = "high"
mesh = { box = { from = [0, 0, 1], to = [1, 1, 2], cells = [1, 1, 1] } }
material = { young = 1000, poisson = 0 }
fix  = [{ side = "top", x = 0, y = 0, z = -0.01 }]
[[contact]]
name = "joint"
nonmortar = "high.bottom"
mortar = "low.top"
"#;
    let model = case(&(text.to_string() + &probe("joint.displacement_obstacle.z", ""))).model;
    let said = model.solve().unwrap_err().to_string();
    assert!(said.contains("no rigid obstacle"), "{said}");
}

/// A block of 2 × 1 × 1 that is drawn by 10 along z.
const DRAWN: &str = r#"
analysis = "3d"
[[body]]
name = "block"
mesh = { box = { from = [0, 0, 0], to = [2, 1, 1], cells = [3, 2, 2] } }
material = { young = 1000, poisson = 0.25 }
fix  = [{ side = "bottom", z = 0 }, { point = [0, 0, 0], x = 0, y = 0 }, { point = [2, 0, 0], y = 0 }]
load = [{ side = "top", traction = [0, 0, 10] }]
"#;

#[test]
fn fields_of_bodies_are_read_by_their_names() {
    let probes = [
        probe("block.strain.zz", "at = [0.3, 0.4, 0.5]"),
        probe("block.strain.xx", "reduce = \"mean\""),
        probe("block.strain.xy", "reduce = \"max\""),
    ];
    let case = case(&(DRAWN.to_string() + &probes.concat()));
    let solution = case.model.solve().unwrap();
    reads(&solution, "block.strain.zz", 0.01);
    reads(&solution, "block.strain.xx", -0.0025);
    reads(&solution, "block.strain.xy", 0.0);
    let refused = |quantity: &str| {
        let text = DRAWN.to_string() + &probe(quantity, "at = [0, 0, 0]");
        let error = Case::<3>::from_str(&text, "case.toml", Path::new(".")).err();
        error.unwrap().to_string()
    };
    for (quantity, words) in [
        ("block.strain", "the quantity ends after `strain`"),
        ("block.strain.zx", "unknown component `zx`"),
        ("block.strain.zz.z", "`zz` has no components here"),
        ("block.yielded", "of a body that does not yield"),
        ("block.strian.zz", "unknown quantity of a body `strian`"),
    ] {
        let said = refused(quantity);
        assert!(said.contains(words), "{quantity}: {said}");
    }
}

/// A block under a pressure p = 2 on a floor without friction: what a factor of place and time makes of it, by hand.
#[test]
fn a_factor_weighs_values_before_they_become_one() {
    let text = r#"
analysis = "plane-stress"
parameters = { mu = 0.25 }
[[step]]
time = 3
[[body]]
name = "block"
mesh = { rectangle = { from = [1, 0], to = [3, 1], cells = [6, 3], cell = "quad9" } }
material = { young = 100, poisson = 0.0, thickness = 0.5 }
fix = [{ side = "left", x = 0 }]
load = [{ side = "top", pressure = 2 }, { side = "right", traction = [3, 0] }]
[[contact]]
name = "floor"
nonmortar = "block.bottom"
obstacle = { gap = 0 }
[[section]]
name = "cut"
body = "block"
sides = ["top", "bottom"]
stations = 3
[[probe]]
name = "torque"
quantity = "floor.pressure"
factor = "mu*x"
reduce = "integral"
[[probe]]
name = "lever"
quantity = "floor.pressure"
factor = "x^2"
reduce = "mean"
[[probe]]
name = "at"
quantity = "block.stress.yy"
factor = "y*t"
at = [2, 0.5]
[[probe]]
name = "volume"
quantity = "block.stress.yy"
factor = "x*y"
reduce = "integral"
[[probe]]
name = "side"
quantity = "block.stress.yy"
factor = "x"
along = "block.top"
reduce = "integral"
[[probe]]
name = "most"
quantity = "block.stress.yy"
factor = "-x"
reduce = "max"
[[probe]]
name = "number"
quantity = "block.reaction.x"
factor = "2*t"
[[probe]]
name = "cut"
quantity = "cut.N"
factor = "x"
reduce = "mean"
[[probe]]
name = "line"
quantity = "block.stress.yy"
factor = "10*x"
along = { from = [1, 0.5], to = [3, 0.5], points = 3 }
"#;
    let (_, steps) = crate::links::solved(text);
    let value = |name: &str| steps[0].probe(name).unwrap();
    for (name, expected) in [
        // ∫ μ x p t dx, t = 1/2
        ("torque", 0.25 * 2.0 * 0.5 * 4.0),
        ("at", -2.0 * 0.5 * 3.0),
        ("volume", -2.0 * 0.5 * 4.0 * 0.5),
        ("side", -2.0 * 0.5 * 4.0),
        ("most", 6.0),
        // of the supports along x: what pulls at the other end
        ("number", -3.0 * 0.5 * 6.0),
        ("cut", 3.0 * 2.0),
    ] {
        crate::links::near(value(name), expected, 1e-9);
    }
    // the mean of x² over [1, 3] by the weights of the nodes of six facets 1/3 long: Simpson's rule or the trapezoidal one, off by h²/6
    let lever = value("lever") / 2.0;
    assert!((lever - 13.0 / 3.0).abs() <= 1.0 / 54.0 + 1e-9, "{lever}");
    let probes = &steps[0].probes;
    let line = &probes.iter().find(|p| p.name == "line").unwrap().line;
    let values: Vec<f64> = line.iter().map(|at| at.value).collect();
    for (found, expected) in values.iter().zip([-20.0, -40.0, -60.0]) {
        crate::links::near(*found, expected, 1e-9);
    }
    let refused = crate::links::refused(&text.replace("factor = \"2*t\"", "factor = \"2*x\""));
    assert!(
        refused.to_string().contains("`x` has no meaning here"),
        "{refused}"
    );
}

/// The factor of a member is that of each station before the largest is chosen.
#[test]
fn a_factor_is_that_of_each_station() {
    let text = r#"
analysis = "plane-stress"
[[body]]
name = "rock"
mesh = { rectangle = { from = [0, 0], to = [4, 1], cells = [16, 4] } }
material = { young = 100, poisson = 0.2 }
fix = [{ side = "left", x = 0 }, { point = [0, 0], y = 0 }]
load = [{ side = "right", traction = [1, 0] }]
[[bar]]
name = "bolt"
from = [0.5, 0.5]
to = [3.5, 0.5]
young = 1e4
area = 0.01
bodies = ["rock"]
bond = "grouted"
[[probe]]
name = "plain"
quantity = "bolt.force"
[[probe]]
name = "weighed"
quantity = "bolt.force"
factor = "x^4"
"#;
    let (_, steps) = crate::links::solved(text);
    let bolt = steps[0].member("bolt").unwrap();
    let stations = || bolt.stations.iter();
    let weighed = stations().map(|at| at.force * at.point[0].powi(4));
    let most = weighed.fold(0.0, f64::max);
    let value = |name: &str| steps[0].probe(name).unwrap();
    assert!((value("weighed") / most - 1.0).abs() < 1e-12);
    // not the station that bears most
    let largest = bolt.largest().unwrap();
    assert!(most > 1.01 * largest.force * largest.point[0].powi(4));
    assert_eq!(value("plain"), largest.force);
    let quantity = &steps[0].probes[1].quantity;
    assert_eq!(quantity, "(x^4) bolt.force");
}

/// A column of two blocks, of which the upper one comes in the second step, and expressions of what is read of both.
#[test]
fn expressions_are_those_of_the_probes_of_the_same_step() {
    let text = r#"
analysis = "plane-stress"
parameters = { depth = 2.0 }
[[body]]
name = "low"
mesh = { rectangle = { from = [0, 0], to = [1, 1], cells = [2, 2] } }
material = { young = 100, poisson = 0 }
fix = [{ side = "bottom", x = 0, y = 0 }]
load = [{ side = "top", pressure = "t", active = { until = "second" } }]
[[body]]
name = "up"
mesh = { rectangle = { from = [0, 1], to = [1, 2], cells = [2, 2] } }
material = { young = 100, poisson = 0 }
fix = [{ side = "left", x = 0 }, { side = "right", x = 0 }]
load = [{ side = "top", pressure = "t" }]
active = { from = "second" }
[[contact]]
name = "joint"
nonmortar = "up.bottom"
mortar = "low.top"
[[step]]
time = 1
[[step]]
time = 2
name = "second"
[[probe]]
name = "all of it"
expression = "max(2*both, -100)"
[[probe]]
name = "both"
expression = "('low-y' + up)/depth + 0*t"
[[probe]]
name = "low-y"
quantity = "low.displacement.y"
at = [0.5, 1]
[[probe]]
name = "up"
quantity = "up.displacement.y"
at = [0.5, 2]
[[probe]]
name = "ratio"
expression = "sqrt('low-y')"
[[probe]]
name = "low alone"
expression = "-100*'low-y' - t"
"#;
    let case = Case::<2>::from_str(text, "case.toml", Path::new(".")).unwrap();
    let steps = case.model.solve_steps().unwrap();
    let value = |step: usize, name: &str| steps[step].probe(name).unwrap();
    for name in ["all of it", "both", "up", "ratio"] {
        assert!(value(0, name).is_nan(), "{name}");
    }
    // the lower block is pressed by t in both steps
    for step in [0, 1] {
        assert!(value(step, "low alone").abs() < 1e-9);
    }
    let both = 0.5 * (value(1, "low-y") + value(1, "up"));
    assert_eq!(value(1, "both"), both);
    assert_eq!(value(1, "all of it"), 2.0 * both);
    assert!(value(1, "ratio").is_nan());
    let probe = |name: &str| case.probe(&format!("expression = \"{name}\""), &steps[1]);
    assert_eq!(probe("both*depth").unwrap().value, 2.0 * both);
    assert!(probe("booth").unwrap_err().to_string().contains("`both`"));
}
