//! What is read at points: the tensor is interpolated and the number taken there, and a cell has the stress of its own material.
//!
//! Stresses are uniform in each material and elements exact, so that tolerances are the rounding of a solution, 1e-10.

use dotyk::case::Case;
use dotyk::model::Solution;
use std::path::Path;

fn solved(text: &str) -> Solution<2> {
    let case = Case::<2>::from_str(text, "case.toml", Path::new(".")).unwrap();
    case.model.solve().unwrap()
}

#[track_caller]
fn reads(solution: &Solution<2>, probe: &str, expected: f64) {
    let found = solution.probe(probe).unwrap();
    assert!(
        (found - expected).abs() < 1e-10 * (1.0 + expected.abs()),
        "{probe}: {found} {expected}"
    );
}

/// xx = 3, yy = −1, xy = 0.8 everywhere.
const UNIFORM: &str = r#"
analysis = "plane-strain"
[[body]]
name = "b"
mesh = { rectangle = { from = [0, 0], to = [2, 1], cells = [4, 2] } }
material = { young = 1000, poisson = 0.25 }
fix = [{ point = [0, 0], x = 0, y = 0 }, { point = [2, 0], y = 0 }]
load = [{ side = "right", traction = [3, 0.8] }, { side = "left", traction = [-3, -0.8] }, { side = "top", traction = [0.8, -1] }, { side = "bottom", traction = [-0.8, 1] }]
"#;

/// The hoop stress of that state about (0.3, 0.2): t·σ·t with t across the way from there.
fn hoop([x, y]: [f64; 2]) -> f64 {
    let [x, y] = [x - 0.3, y - 0.2];
    (3.0 * y * y - x * x - 1.6 * x * y) / (x * x + y * y)
}

#[test]
fn hoop_stress_has_the_direction_of_its_point() {
    let probe = |name: &str, place: &str| {
        format!(
            "[[probe]]\nname = \"{name}\"\nquantity = \"b.stress.hoop\"\ncenter = [0.3, 0.2]\n{place}\n"
        )
    };
    let text = UNIFORM.to_string()
        + &probe("at", "at = [1.3, 0.7]")
        + &probe("beside the centre", "at = [0.31, 0.22]")
        + &probe(
            "line",
            "along = { from = [0.1, 0.9], to = [1.9, 0.3], points = 8 }",
        )
        + &probe("over the top", "along = \"b.top\"\nreduce = \"mean\"");
    let solution = solved(&text);
    reads(&solution, "at", -0.84);
    reads(&solution, "beside the centre", hoop([0.31, 0.22]));
    let line = solution.probes.iter().find(|probe| probe.name == "line");
    for place in &line.unwrap().line {
        let expected = hoop([place.point[0], place.point[1]]);
        assert!(
            (place.value - expected).abs() < 1e-10,
            "{place:?} {expected}"
        );
    }
    // Simpson's rule with so many pieces is exact to rounding; that of the sides, of degree 9, to 1e-7 here
    let (n, mut mean) = (2000, 0.0);
    for k in 0..=n {
        let weight = if k % n == 0 {
            1.0
        } else {
            2.0 + 2.0 * f64::from(k % 2)
        };
        mean += weight * hoop([2.0 * f64::from(k) / f64::from(n), 1.0]) / (3.0 * f64::from(n));
    }
    let found = solution.probe("over the top").unwrap();
    assert!((found - mean).abs() < 1e-6, "{found} {mean}");
}

/// A tension that grows along y between xx = −y and y: its von Mises stress is |xx|, its utilisation with a yield stress of 2 half that.
#[test]
fn what_is_not_linear_in_the_tensor_is_taken_at_the_point() {
    let probe = |quantity: &str| {
        format!("[[probe]]\nname = \"{quantity}\"\nquantity = \"b.{quantity}\"\nat = [0.8, 0.1]\n")
    };
    let probes: String = [
        "stress.xx",
        "stress.von_mises",
        "stress.tresca",
        "stress.s1",
        "utilisation",
    ]
    .map(probe)
    .concat();
    let bent = solved(&format!(
        r#"
analysis = "plane-stress"
[[body]]
name = "b"
mesh = {{ rectangle = {{ from = [0, -1], to = [4, 1], cells = [4, 1], cell = "quad8" }} }}
material = {{ young = 1000, poisson = 0, strength = {{ yield = 2 }} }}
fix = [{{ side = "left", x = 0 }}, {{ point = [0, -1], y = 0 }}]
load = [{{ side = "right", traction = ["y", 0] }}]
{probes}"#
    ));
    reads(&bent, "stress.xx", 0.1);
    reads(&bent, "stress.von_mises", 0.1);
    reads(&bent, "stress.tresca", 0.1);
    reads(&bent, "stress.s1", 0.1);
    reads(&bent, "utilisation", 0.05);
}

/// Two layers side by side, pushed together by 1 %: −10 in the stiff one below, −0.1 in the soft one above it.
fn layers(cell: &str, probes: &str) -> Solution<2> {
    solved(&format!(
        r#"
analysis = "plane-stress"
[drawing]
size = 0.5
cell = "{cell}"
lines = [ {{ from = [0,0], edges = [{{ to = [4,0], name = "b" }},{{ to = [4,2], name = "r" }},{{ to = [0,2], name = "t" }},{{ to = [0,0], name = "l" }}] }}, {{ from = [0,1], to = [4,1] }} ]
regions = [ {{ name = "stiff", at = [2,0.5] }}, {{ name = "soft", at = [2,1.5] }} ]
[[body]]
name = "a"
mesh = {{ region = ["stiff","soft"] }}
material = [ {{ group = "stiff", young = 1000, poisson = 0, strength = {{ yield = 20 }} }}, {{ group = "soft", young = 10, poisson = 0, strength = {{ yield = 0.2 }} }} ]
fix = [ {{ side = "l", x = 0 }}, {{ side = "r", x = -0.04 }}, {{ side = "b", y = 0 }} ]
{probes}"#
    ))
}

#[test]
fn each_side_of_a_border_between_materials_has_its_own_stress() {
    let probe = |name: &str, quantity: &str, place: &str| {
        format!("[[probe]]\nname = \"{name}\"\nquantity = \"a.{quantity}\"\n{place}\n")
    };
    let (above, below) = ("at = [2, 1.001]", "at = [2, 0.999]");
    let probes = [
        probe("above", "stress.xx", above),
        probe("below", "stress.xx", below),
        probe("used above", "utilisation", above),
        probe("used below", "utilisation", below),
        probe("most used", "utilisation", "reduce = \"max\""),
        probe("largest", "stress.xx", "reduce = \"max\""),
        probe("smallest", "stress.xx", "reduce = \"min\""),
        probe("integral", "stress.xx", "reduce = \"integral\""),
        probe(
            "across",
            "stress.xx",
            "along = { from = [2.1, 0], to = [2.1, 2], points = 10 }",
        ),
        probe("end", "stress.xx", "along = \"a.r\""),
        probe(
            "end mean",
            "stress.xx",
            "along = \"a.r\"\nreduce = \"mean\"",
        ),
    ];
    for cell in ["tri3", "tri6"] {
        let solution = layers(cell, &probes.concat());
        for (name, expected) in [
            ("above", -0.1),
            ("below", -10.0),
            ("used above", 0.5),
            ("used below", 0.5),
            ("most used", 0.5),
            ("largest", -0.1),
            ("smallest", -10.0),
            ("integral", -40.4),
            ("end mean", -5.05),
        ] {
            reads(&solution, name, expected);
        }
        let line = |name: &str| {
            let probe = solution.probes.iter().find(|probe| probe.name == name);
            probe.unwrap().line.clone()
        };
        let own = |y: f64| if y < 1.0 { -10.0 } else { -0.1 };
        for place in line("across") {
            assert!(
                (place.value - own(place.point[1])).abs() < 1e-9,
                "{place:?}"
            );
        }
        // the side goes up: the node between stands there twice, with either stress
        let end = line("end");
        let between: Vec<_> = end.iter().filter(|place| place.point[1] == 1.0).collect();
        assert_eq!(between.len(), 2, "{end:?}");
        assert!(!between[0].starts && between[1].starts);
        assert!((between[0].value + 10.0).abs() < 1e-9 && (between[1].value + 0.1).abs() < 1e-9);
        let body = &solution.bodies[0];
        let most = body.peak.unwrap().most;
        assert!((most.value - 10.0).abs() < 1e-9 && most.at[1] <= 1.0);
        assert_eq!(body.utilisation.as_ref().unwrap().overstressed, 0.0);
    }
}
