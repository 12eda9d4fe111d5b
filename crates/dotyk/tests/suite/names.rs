//! Named points and what takes no part in a contact.
//!
//! Tolerances: 1e-9 of the largest value between two models with the same answer, which exact steps find to the rounding of linear
//! solves, and for balance.

use dotyk::case::Case;
use dotyk::prelude::*;
use std::path::Path;

/// A punch on a block with friction; `points` of the punch, what else is said of the contact, and a probe.
fn case(nodes: &str, points: &str, contact: &str, probe: &str) -> String {
    format!(
        r#"analysis = "plane-strain"
[[body]]
name = "block"
mesh = {{ rectangle = {{ from = [-1, -1], to = [2, 0], cells = [{nodes}, 4] }} }}
material = {{ young = 1e3, poisson = 0.3 }}
fix = [{{ side = "bottom", x = 0, y = 0 }}]
[[body]]
name = "punch"
mesh = {{ rectangle = {{ from = [0, 0], to = [1, 1], cells = [8, 8] }} }}
material = {{ young = 2e3, poisson = 0.2 }}
{points}
[[contact]]
name = "sole"
nonmortar = "punch.bottom"
mortar = "block.top"
{contact}
[[probe]]
name = "p"
quantity = "sole.pressure"
{probe}
"#
    )
}

const HELD: &str = r#"fix = [{ side = "top", x = 0.002, y = -0.01 }]"#;

fn solve(text: &str) -> Solution<2> {
    let case = Case::<2>::from_str(text, "names.toml", Path::new(""));
    case.unwrap_or_else(|error| panic!("{}", error.message))
        .model
        .solve()
        .unwrap()
}

fn pressures(solution: &Solution<2>) -> Vec<f64> {
    let nodes = solution.contacts[0].nodes.iter();
    nodes.map(|node| node.pressure).collect()
}

fn near(a: &[f64], b: &[f64]) {
    let scale = b.iter().fold(0.0, |s: f64, x| s.max(x.abs()));
    assert_eq!(a.len(), b.len());
    for (a, b) in a.iter().zip(b) {
        assert!((a - b).abs() < 1e-9 * scale, "{a} {b}");
    }
}

#[test]
fn a_name_stands_for_its_coordinates() {
    let named = format!(
        "{HELD}\nload = [{{ point = \"tip\", force = [3, -2] }}]\npoints = {{ tip = [1, 0.5], foot = [0.5, 0] }}"
    );
    let plain = format!("{HELD}\nload = [{{ point = [1, 0.5], force = [3, -2] }}]");
    let by_name = solve(&case("24", &named, "", "at = \"punch.foot\""));
    let by_place = solve(&case("24", &plain, "", "at = [0.5, 0]"));
    assert_eq!(by_name.probes[0].value, by_place.probes[0].value);
    assert_eq!(pressures(&by_name), pressures(&by_place));
    // and a support
    let named = "fix = [{ side = \"top\", y = -0.01 }, { point = \"tip\", x = 0.001 }]\npoints = { tip = [1, 0.5] }";
    let plain = "fix = [{ side = \"top\", y = -0.01 }, { point = [1, 0.5], x = 0.001 }]";
    let [by_name, by_place] =
        [named, plain].map(|points| solve(&case("24", points, "", "at = [0.5, 0]")));
    assert_eq!(pressures(&by_name), pressures(&by_place));
}

#[test]
fn an_excluded_node_is_one_that_is_far_away() {
    let points = format!("{HELD}\npoints = {{ left = [0, 0], a = [0.375, 0] }}");
    for friction in ["", "friction = 0.3"] {
        let out = format!("{friction}\nexclude = [\"left\", \"a\"]");
        let far = format!(
            "{friction}\ngap = \"max(0, 1e-2 - abs(x)) * 1e6 + max(0, 1e-2 - abs(x - 0.375)) * 1e6\""
        );
        let [out, far] =
            [out, far].map(|contact| solve(&case("24", &points, &contact, "reduce = \"max\"")));
        assert!(out.certificate.holds());
        near(&pressures(&out), &pressures(&far));
        for node in &out.contacts[0].nodes {
            let excluded = [0.0, 0.375].contains(&node.point[0]);
            assert_eq!(node.gap.is_nan(), excluded, "{node:?}");
            assert_eq!(node.status == Status::Open, excluded, "{node:?}");
            assert_eq!(node.pressure == 0.0, excluded);
            assert!(node.weight > 0.0);
        }
        assert!(
            !out.warnings
                .iter()
                .any(|warning| warning.contains("face nothing"))
        );
    }
}

/// Between non-matching meshes the other rows are what they would be without.
#[test]
fn what_is_excluded_bears_nothing_and_the_rest_balances() {
    for cells in ["24", "19"] {
        let points = format!("{HELD}\npoints = {{ a = [0.375, 0] }}");
        let whole = solve(&case(cells, &points, "", "reduce = \"max\""));
        let out = solve(&case(cells, &points, "exclude = \"a\"", "reduce = \"max\""));
        assert!(out.certificate.holds());
        // what is left out is not judged: that it overlaps is told, with its place
        let overlaps = |s: &Solution<2>| {
            s.warnings
                .iter()
                .any(|w| w.contains("beside nodes that are excluded"))
        };
        let told = overlaps(&out) && !overlaps(&whole);
        let nodes = out.contacts[0].nodes.iter();
        let pressed: f64 = nodes.map(|node| node.pressure * node.weight).sum();
        let held = out.bodies.iter().find(|body| body.name == "punch").unwrap();
        assert!((pressed + held.reaction[1]).abs() < 1e-9 * pressed);
        let [whole, out] = [whole, out].map(|solution| pressures(&solution));
        assert!(whole[3] > 0.0 && out[3] == 0.0);
        assert!(told);
        // the neighbours bear more, those far away the same by a percent
        assert!(out[2] > 1.05 * whole[2] && out[4] > 1.05 * whole[4]);
        assert!((out[7] / whole[7] - 1.0).abs() < 0.02);
    }
}

#[test]
fn a_side_is_excluded_with_all_its_nodes() {
    let mesh = "mesh = { rectangle = { from = [0, 0], to = [1, 1], cells = [8, 8] } }";
    let patched = "mesh = { rectangle = { from = [0, 0], to = [1, 1], cells = [8, 8] }, sides = { heel = { of = \"bottom\", min = [0, 0], max = [0.26, 0] } } }";
    let text = case("24", HELD, "exclude = [\"heel\"]", "reduce = \"max\"").replace(mesh, patched);
    let pressures = pressures(&solve(&text));
    assert_eq!(pressures[..3], [0.0; 3]);
    assert!(pressures[3..].iter().all(|&p| p > 0.0));
}

#[test]
fn a_node_without_friction_is_one_of_coefficient_zero() {
    let points = format!("{HELD}\npoints = {{ left = [0, 0], a = [0.375, 0] }}");
    let zero = "friction = \"if_far\"".replace(
        "if_far",
        "0.3 * min(1, abs(x) * 1e6) * min(1, abs(x - 0.375) * 1e6)",
    );
    let left_out = "friction = 0.3\nfriction_exclude = [\"left\", \"a\"]";
    let [out, zero] =
        [left_out, &zero].map(|contact| solve(&case("24", &points, contact, "reduce = \"max\"")));
    near(&pressures(&out), &pressures(&zero));
    let shear =
        |s: &Solution<2>| -> Vec<f64> { s.contacts[0].nodes.iter().map(|n| n.shear[0]).collect() };
    near(&shear(&out), &shear(&zero));
    let statuses: Vec<Status> = out.contacts[0].nodes.iter().map(|n| n.status).collect();
    assert_eq!((statuses[0], statuses[3]), (Status::Closed, Status::Closed));
    assert!(statuses[1] == Status::Slip || statuses[1] == Status::Stick);
}

#[test]
fn the_body_of_what_is_excluded_carries_the_forces_where_dotyk_chooses() {
    let points = format!("{HELD}\npoints = {{ a = [0.375, 0] }}");
    let given = case("24", &points, "exclude = \"a\"", "reduce = \"max\"");
    let sides = given.replace(
        "nonmortar = \"punch.bottom\"\nmortar = \"block.top\"",
        "sides = [\"block.top\", \"punch.bottom\"]",
    );
    assert_ne!(given, sides);
    assert_eq!(pressures(&solve(&given)), pressures(&solve(&sides)));
}

#[test]
fn excluded_nodes_stay_out_in_later_steps() {
    let points = format!(
        "{}\npoints = {{ a = [0.375, 0] }}",
        HELD.replace("-0.01", "\"-0.01*t\"")
    );
    let contact = "gap = \"0.001*t\"\nexclude = \"a\"\n[[step]]\ntime = 1\n[[step]]\ntime = 2\n";
    let text = case("24", &points, contact, "reduce = \"max\"");
    let case = Case::<2>::from_str(&text, "names.toml", Path::new("")).unwrap();
    for step in case.model.solve_steps().unwrap() {
        assert!(step.contacts[0].nodes[3].gap.is_nan());
        assert_eq!(step.contacts[0].nodes[3].pressure, 0.0);
        assert!(step.contacts[0].nodes[2].pressure > 0.0);
    }
}

/// A mean of the contact is that of the part that faces the other side, whichever side carries the forces.
#[test]
fn a_mean_pressure_is_over_what_faces_something() {
    for [nonmortar, mortar] in [["punch.bottom", "block.top"], ["block.top", "punch.bottom"]] {
        let text = case("24", HELD, "", "reduce = \"mean\"").replace(
            "nonmortar = \"punch.bottom\"\nmortar = \"block.top\"",
            &format!("nonmortar = \"{nonmortar}\"\nmortar = \"{mortar}\""),
        );
        assert!(text.contains(&format!("nonmortar = \"{nonmortar}\"")));
        let solution = solve(&text);
        let force = solution.contacts[0].resultant[1].abs();
        let faces = solution.contacts[0]
            .nodes
            .iter()
            .filter(|n| !n.gap.is_nan());
        let length: f64 = faces.map(|n| n.weight).sum();
        assert!((length - 1.0).abs() < 1e-12, "{nonmortar}: {length}");
        assert!((solution.probes[0].value - force).abs() < 1e-9 * force);
    }
}

#[test]
fn a_model_whose_result_files_no_system_can_have_is_not_solved() {
    let unit = Rectangle {
        from: [0.0, 0.0],
        to: [1.0, 1.0],
        cells: [1, 1],
        cell: CellKind::Quad4,
        diagonals: Diagonals::default(),
    };
    let steel = Elastic {
        young: 1e3,
        poisson: 0.3,
    };
    let solved = |names: [&str; 2]| {
        let mut model = Model::new();
        for name in names {
            let body = model.body(name, unit.build().unwrap(), steel);
            model.fix(body, "bottom", [Some(0.0), Some(0.0)]);
        }
        model.solve()
    };
    for (names, words) in [
        (["rock", "aux"], "body \"aux\": Windows keeps the name"),
        (
            ["Rock", "rock"],
            "body \"rock\": its name differs from `Rock`",
        ),
    ] {
        let error = solved(names).unwrap_err().to_string();
        assert!(error.starts_with(words), "{error}");
    }
}
