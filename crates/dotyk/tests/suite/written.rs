//! What a user wrote down as a contact is what touches: near and far surfaces, whole boundaries, circles, lists of sides, nodes that
//! contacts have in common, sides that supports hold. Each problem here was once certified and wrong.

use dotyk::case::Case;
use dotyk::geometry::Point;
use dotyk::model::{ContactNode, ContactSolution, Solution, Status};
use std::path::Path;

fn solve(text: &str) -> Solution<2> {
    let case = Case::<2>::from_str(text, "case.toml", Path::new("."));
    case.unwrap().model.solve().unwrap()
}

fn solve_in_space(text: &str) -> Solution<3> {
    let case = Case::<3>::from_str(text, "case.toml", Path::new("."));
    case.unwrap().model.solve().unwrap()
}

fn probe<const D: usize>(solution: &Solution<D>, name: &str) -> f64 {
    let found = solution.probes.iter().find(|probe| probe.name == name);
    found.unwrap().value
}

/// The same words with some of them changed.
fn with(text: &str, changes: &[(&str, &str)]) -> String {
    changes.iter().fold(text.to_string(), |text, (from, to)| {
        assert!(text.contains(from), "{from}");
        text.replace(from, to)
    })
}

fn near(found: f64, expected: f64, off: f64) {
    assert!((found - expected).abs() <= off, "{found} {expected}");
}

/// A block on a pedestal, whose floor lies H below its top.
const STEP: &str = r#"
analysis = "plane-strain"
[parameters]
n = 40
H = 2
[[body]]
name = "base"
mesh = { outline = { size = 0.2, cell = "tri6", from = [-1, "-1 - H"], edges = [ { to = [4, "-1 - H"], name = "bottom" }, { to = [4, "-H"] }, { to = [2, "-H"], name = "floor" }, { to = [2, 0] }, { to = [1, 0], name = "top" }, { to = [1, "-H"] }, { to = [-1, "-H"], name = "floor" }, { to = [-1, "-1 - H"] } ] } }
material = { young = 1000, poisson = 0.3 }
fix = [{ side = "bottom", x = 0, y = 0 }]
[[body]]
name = "block"
mesh = { rectangle = { from = [0.3, 0], to = [2.7, 1], cells = ["n", 5], cell = "quad8" } }
material = { young = 1000, poisson = 0.3 }
load = [{ side = "top", pressure = 1 }]
fix = [{ point = [0.3, 1], x = 0 }]
[[contact]]
name = "c"
nonmortar = "block.bottom"
mortar = ["base.floor", "base.top"]
[[probe]]
name = "uy"
quantity = "block.displacement.y"
at = [1.5, 0]
"#;

#[test]
fn a_floor_beside_a_pedestal_disturbs_nothing() {
    for n in ["7", "40"] {
        for cell in ["quad4", "quad8"] {
            let both = with(STEP, &[("n = 40", &format!("n = {n}")), ("quad8", cell)]);
            let alone = with(&both, &[("[\"base.floor\", \"base.top\"]", "\"base.top\"")]);
            let (both, alone) = (solve(&both), solve(&alone));
            near(probe(&both, "uy"), probe(&alone, "uy"), 1e-9);
            assert!(probe(&both, "uy") < -0.005);
            let length = |s: &Solution<2>| s.contacts[0].length;
            near(length(&both), length(&alone), 1e-12);
            near(both.contacts[0].resultant[1], 2.4, 1e-9);
            // what is far is told as far
            let nodes = both.contacts[0].nodes.iter();
            let far = nodes.filter(|node| node.gap > 1.9).count();
            assert!(far > 2, "{far}");
        }
    }
}

/// The same in space: a slab on a post, with a floor below.
#[test]
fn a_floor_beside_a_post_disturbs_nothing() {
    let text = r#"
analysis = "3d"
[[body]]
name = "base"
mesh = { extrude = { mesh = { outline = { size = 0.6, cell = "tri3", from = [-1, -3], edges = [ { to = [4, -3], name = "bottom" }, { to = [4, -2] }, { to = [2, -2], name = "floor" }, { to = [2, 0] }, { to = [1, 0], name = "top" }, { to = [1, -2] }, { to = [-1, -2], name = "floor" }, { to = [-1, -3] } ] } }, height = 1.5, layers = 3 } }
material = { young = 1000, poisson = 0.3 }
fix = [{ side = "bottom", x = 0, y = 0, z = 0 }]
[[body]]
name = "slab"
mesh = { box = { from = [0.1, 0, -0.2], to = [2.8, 0.5, 1.8], cells = [4, 2, 3], cell = "hex8" } }
material = { young = 1000, poisson = 0.3 }
load = [{ side = "back", pressure = 1 }]
fix = [{ point = [0.1, 0.5, -0.2], x = 0, z = 0 }, { point = [0.1, 0.5, 1.8], x = 0 }]
[[contact]]
name = "c"
nonmortar = "slab.front"
mortar = ["base.floor", "base.top"]
[[probe]]
name = "uy"
quantity = "slab.displacement.y"
at = [1.5, 0.5, 0.8]
"#;
    let both = solve_in_space(text);
    let alone = with(text, &[("[\"base.floor\", \"base.top\"]", "\"base.top\"")]);
    let alone = solve_in_space(&alone);
    near(probe(&both, "uy"), probe(&alone, "uy"), 1e-9);
    assert!(probe(&both, "uy") < 0.0);
    near(both.contacts[0].length, alone.contacts[0].length, 1e-12);
    near(both.contacts[0].resultant[1], 2.7 * 2.0, 1e-9);
}

/// A bolt of four teeth in a nut, pulled: contacts of pairs of flanks.
fn thread(contacts: &str) -> String {
    let tooth = |k: usize| 2.0 * k as f64;
    let bolt: String = (0..4)
        .map(|k| {
            let z = tooth(k);
            format!(
                "{{ to = [4.0, {}] }}, {{ to = [5.0, {}], name = \"low{k}\" }}, {{ to = [5.0, {}] }}, {{ to = [4.0, {}], name = \"up{k}\" }}, ",
                z + 0.2113,
                z + 0.7887,
                z + 1.2113,
                z + 1.7887
            )
        })
        .collect();
    let nut: String = (0..4)
        .rev()
        .map(|k| {
            let z = tooth(k);
            format!(
                "{{ to = [4.15, {}] }}, {{ to = [5.15, {}], name = \"press{k}\" }}, {{ to = [5.15, {}] }}, {{ to = [4.15, {}], name = \"un{k}\" }}, ",
                z + 1.7021,
                z + 1.1247,
                z + 0.7753,
                z + 0.1979
            )
        })
        .collect();
    format!(
        r#"
analysis = "axisymmetric"
[[body]]
name = "bolt"
mesh = {{ outline = {{ size = 0.5, cell = "tri6", from = [0, -4], edges = [{{ to = [4.0, -4] }}, {bolt}{{ to = [4.0, 14.0] }}, {{ to = [0, 14.0], name = "pull" }}, {{ to = [0, -4] }}] }} }}
material = {{ young = 210e3, poisson = 0.3 }}
load = [{{ side = "pull", force = [0, 1000.0] }}]
[[body]]
name = "nut"
mesh = {{ outline = {{ size = 0.5, cell = "tri6", from = [9.0, 0], edges = [{{ to = [9.0, 8.0] }}, {{ to = [4.15, 8.0], name = "face" }}, {nut}{{ to = [4.15, 0.0] }}, {{ to = [9.0, 0] }}] }} }}
material = {{ young = 210e3, poisson = 0.3 }}
fix = [{{ side = "face", y = 0 }}]
{contacts}"#
    )
}

/// What a tooth bears: the force along the axis of the rows within its height.
fn on_tooth(contact: &ContactSolution<2>, k: usize) -> f64 {
    let nodes = contact.nodes.iter();
    let own = nodes.filter(|n| (n.point[1] - 2.0 * k as f64 - 1.4).abs() < 0.5);
    let along = own.map(|n| n.weight * (n.shear[1] - n.pressure * n.normal[1]));
    along.sum()
}

#[test]
fn teeth_of_a_list_are_contacts_of_their_own_in_any_order() {
    let each: String = (0..4)
        .map(|k| format!("[[contact]]\nname = \"c{k}\"\nnonmortar = \"nut.press{k}\"\nmortar = \"bolt.up{k}\"\nfriction = 0.15\n"))
        .collect();
    let each = solve(&thread(&each));
    let expected: Vec<f64> = each.contacts.iter().map(|c| c.resultant[1]).collect();
    let list = |body: &str, side: &str, order: [usize; 4]| {
        let names = order.map(|k| format!("\"{body}.{side}{k}\""));
        format!("[{}]", names.join(", "))
    };
    for [own, other] in [[[0, 1, 2, 3], [0, 1, 2, 3]], [[3, 1, 0, 2], [2, 3, 1, 0]]] {
        let (own, other) = (list("nut", "press", own), list("bolt", "up", other));
        let text = format!(
            "[[contact]]\nname = \"c\"\nnonmortar = {own}\nmortar = {other}\nfriction = 0.15\n"
        );
        let found = solve(&thread(&text));
        for (k, expected) in expected.iter().enumerate() {
            near(on_tooth(&found.contacts[0], k), *expected, 1e-5 * 1000.0);
        }
    }
    assert!(expected[0] > 100.0 && expected[3] < 620.0, "{expected:?}");
}

/// A ball above a block, whose facets at the equator reach beyond its edges or see its far faces.
#[test]
fn a_ball_that_touches_nothing_presses_nothing() {
    let text = |cell: &str| {
        format!(
            r#"
analysis = "3d"
[[body]]
name = "ball"
mesh = {{ sphere = {{ center = [0, 0, 6.0001], radius = 1, cells = [8, 2], cell = "{cell}" }} }}
material = {{ young = 1000, poisson = 0.3 }}
fix = [{{ point = [0, 0, 6.0001], x = 0, y = 0, z = 0 }}, {{ point = [0, 0, 7.0001], x = 0, y = 0 }}, {{ point = [1, 0, 6.0001], y = 0 }}]
[[body]]
name = "block"
mesh = {{ box = {{ from = [-5, -5, -5], to = [5, 5, 5], cells = [10, 10, 5], cell = "hex8" }} }}
material = {{ young = 1000, poisson = 0.3 }}
fix = [{{ side = "bottom", x = 0, y = 0, z = 0 }}]
[[contact]]
name = "c"
nonmortar = "ball.outer"
mortar = "block.top"
"#
        )
    };
    let solution = solve_in_space(&text("hex8"));
    assert_eq!(solution.contacts[0].resultant, [0.0; 3]);
    for cell in ["hex8", "hex27", "tet10"] {
        let case = Case::<3>::from_str(&text(cell), "case.toml", Path::new("."));
        let check = case.unwrap().model.check();
        let contact = &check.contacts[0];
        assert_eq!(contact.penetration, 0.0, "{cell}");
        near(contact.clearance, 1e-4, 1e-12);
    }
}

/// A block above another one, of which it touches the middle, or nothing between its nodes.
#[test]
fn a_pressed_body_does_not_rise() {
    let text = |cells: usize, cell: &str, gap: &str| {
        format!(
            r#"
analysis = "plane-strain"
[[body]]
name = "block"
mesh = {{ rectangle = {{ from = [-1.0, 0.0], to = [1.0, 1.0], cells = [{cells}, 1], cell = "{cell}" }} }}
material = {{ young = 1e6, poisson = 0.0 }}
fix = [{{ side = "top", x = 0.0 }}]
load = [{{ side = "top", traction = [0.0, -1.0] }}]
[[body]]
name = "base"
mesh = {{ rectangle = {{ from = [-1.5, -1.0], to = [1.5, 0.0], cells = [4, 1] }} }}
material = {{ young = 1e6, poisson = 0.0 }}
fix = [{{ side = "bottom", x = 0.0, y = 0.0 }}]
[[contact]]
name = "floor"
nonmortar = "block.bottom"
mortar = "base.top"
gap = "{gap}"
[[probe]]
name = "u"
quantity = "block.displacement.y"
at = [0.0, 1.0]
"#
        )
    };
    // what the sides miss of the curve between their nodes, at most
    for (cells, cell, sag) in [
        (2, "quad4", 0.0),
        (3, "quad4", 0.012),
        (2, "quad8", 0.0),
        (5, "quad8", 1e-5),
    ] {
        let found = probe(&solve(&text(cells, cell, "0.1*x^2")), "u");
        assert!(found < 0.0 && found > -sag - 1e-5, "{cells} {cell} {found}");
    }
    // rounding of a floor that is level
    let found = probe(&solve(&text(3, "quad4", "0")), "u");
    near(found, -1.8e-6, 1e-7);
}

/// Two rectangles that overlap by 0.01, with some of their sides.
fn overlapping(fix: &str, nonmortar: &str, mortar: &str) -> String {
    format!(
        r#"
analysis = "plane-strain"
[[body]]
name = "plate"
mesh = {{ rectangle = {{ from = [0, -0.5], to = [4, 0], cells = [8, 2] }}, sides = {{ all = {{ of = "boundary", min = [-9, -9], max = [9, 9] }} }} }}
material = {{ young = 1000, poisson = 0.0 }}
fix = [{fix}]
[[body]]
name = "block"
mesh = {{ rectangle = {{ from = [1, -0.01], to = [3, 0.99], cells = [4, 2] }}, sides = {{ all = {{ of = "boundary", min = [-9, -9], max = [9, 9] }} }} }}
material = {{ young = 1000, poisson = 0.0 }}
fix = [{{ side = "top", x = 0, y = 0 }}]
[[contact]]
name = "c"
nonmortar = "{nonmortar}"
mortar = "{mortar}"
"#
    )
}

fn moved<const D: usize>(solution: &Solution<D>) -> f64 {
    let u = solution.bodies.iter().flat_map(|body| &body.displacement);
    u.map(|u| u.iter().map(|c| c * c).sum::<f64>().sqrt())
        .fold(0.0, f64::max)
}

#[test]
fn whole_boundaries_touch_where_they_touch() {
    let feet = "{ point = [0, -0.5], x = 0, y = 0 }, { point = [2, -0.5], y = 0 }, { point = [4, -0.5], y = 0 }";
    let expected = moved(&solve(&overlapping(feet, "plate.top", "block.bottom")));
    near(expected, 0.0088, 1e-4);
    for sides in [
        ["plate.all", "block.all"],
        ["block.all", "plate.all"],
        ["plate.all", "block.bottom"],
    ] {
        let found = solve(&overlapping(feet, sides[0], sides[1]));
        near(moved(&found), expected, 1e-9);
    }
    // whatever is held
    for fix in [
        "{ side = \"all\", x = 0, y = 0 }",
        "{ side = \"top\", x = 0, y = 0 }",
    ] {
        for sides in [
            ["plate.all", "block.all"],
            ["block.all", "plate.all"],
            ["plate.top", "block.bottom"],
        ] {
            let found = solve(&overlapping(fix, sides[0], sides[1]));
            near(found.contacts[0].resultant[1].abs(), 20.0, 1e-9);
        }
    }
}

/// Bodies that overlap at an edge have more in common along it than across, and are pressed apart across: whole boundaries mean
/// what the faces do that lie in each other.
#[test]
fn whole_boundaries_that_overlap_at_an_edge_are_pressed_apart_the_short_way() {
    let all = |min: &str, max: &str| {
        format!("sides = {{ all = {{ of = \"boundary\", min = {min}, max = {max} }} }}")
    };
    let blocks = |shift: f64, cells: [usize; 4], sides: [&str; 2]| {
        let all = all("[-9, -9]", "[9, 9]");
        let [a, b, c, d] = cells;
        format!(
            r#"
analysis = "plane-stress"
[[body]]
name = "low"
mesh = {{ rectangle = {{ from = [0, 0], to = [3, 1], cells = [{a}, {b}] }}, {all} }}
material = {{ young = 1000, poisson = 0.0 }}
fix = [{{ side = "bottom", x = 0, y = 0 }}]
[[body]]
name = "up"
mesh = {{ rectangle = {{ from = [{shift}, 0.99], to = [{}, 2], cells = [{c}, {d}] }}, {all} }}
material = {{ young = 1000, poisson = 0.0 }}
fix = [{{ side = "top", x = 0, y = 0 }}]
[[contact]]
name = "c"
nonmortar = "low.{}"
mortar = "up.{}"
"#,
            3.0 + shift,
            sides[0],
            sides[1]
        )
    };
    let cells = [[1, 1, 1, 1], [6, 2, 4, 2], [3, 1, 7, 3]];
    for (shift, cells) in [0.0, 0.5, -0.5, 2.5, 2.9]
        .into_iter()
        .flat_map(|s| cells.map(|c| (s, c)))
    {
        let faces = solve(&blocks(shift, cells, ["top", "bottom"]));
        let whole = solve(&blocks(shift, cells, ["all", "all"]));
        let [faces, whole] = [faces, whole].map(|solution| solution.contacts[0].resultant);
        assert!(faces[1].abs() > 0.1);
        near(whole[0], faces[0], 1e-9);
        near(whole[1], faces[1], 1e-9);
    }
    // of equal width: E times 0.01 over both heights, but for what the sides do where they end
    let flush = solve(&blocks(0.0, [6, 2, 6, 2], ["all", "all"]));
    for node in &flush.contacts[0].nodes {
        assert!(node.pressure.abs() < 1e-9 || (node.pressure - 10.0 / 2.01).abs() < 1e-9);
    }
    let cubes = |shift: f64, sides: [&str; 2]| {
        let all = all("[-9, -9, -9]", "[9, 9, 9]");
        format!(
            r#"
analysis = "3d"
[[body]]
name = "low"
mesh = {{ box = {{ from = [0, 0, 0], to = [3, 2, 1], cells = [3, 2, 1] }}, {all} }}
material = {{ young = 1000, poisson = 0.0 }}
fix = [{{ side = "bottom", x = 0, y = 0, z = 0 }}]
[[body]]
name = "up"
mesh = {{ box = {{ from = [{shift}, 0, 0.99], to = [{}, 2, 2], cells = [2, 3, 1] }}, {all} }}
material = {{ young = 1000, poisson = 0.0 }}
fix = [{{ side = "top", x = 0, y = 0, z = 0 }}]
[[contact]]
name = "c"
nonmortar = "low.{}"
mortar = "up.{}"
"#,
            3.0 + shift,
            sides[0],
            sides[1]
        )
    };
    for shift in [0.0, 0.5, 2.5] {
        let faces = solve_in_space(&cubes(shift, ["top", "bottom"]));
        let whole = solve_in_space(&cubes(shift, ["all", "all"]));
        let [faces, whole] = [faces, whole].map(|solution| solution.contacts[0].resultant);
        assert!(faces[2].abs() > 0.1);
        for d in 0..3 {
            near(whole[d], faces[d], 1e-9);
        }
    }
}

/// A node that faces a near surface and a far one is asked for what it bears.
#[test]
fn a_probe_reads_the_surface_that_presses() {
    let text = r#"
analysis = "plane-strain"
[[body]]
name = "base"
mesh = { outline = { size = 1, cell = "tri3", from = [0, -2], edges = [ { to = [3, -2], name = "bottom" }, { to = [3, -1], name = "e" }, { to = [2, -1], name = "floor" }, { to = [2, 0], name = "w" }, { to = [1, 0], name = "top" }, { to = [1, -1], name = "w" }, { to = [0, -1], name = "floor" }, { to = [0, -2], name = "e" } ] } }
material = { young = 1000, poisson = 0.0 }
fix = [{ side = "bottom", x = 0, y = 0 }]
[[body]]
name = "block"
mesh = { rectangle = { from = [0.2, 0], to = [2.7, 1], cells = [3, 1] } }
material = { young = 1000, poisson = 0.0 }
fix = [{ side = "left", x = 0 }]
load = [{ side = "top", traction = [0, "-(0.1 + 0.3*x)"] }]
[[contact]]
name = "c"
nonmortar = "block.bottom"
mortar = ["base.floor", "base.top"]
[[probe]]
name = "most"
quantity = "c.pressure"
reduce = "max"
[[probe]]
name = "there"
quantity = "c.pressure"
at = [0.2, 0]
[[probe]]
name = "gap"
quantity = "c.gap"
reduce = "min"
"#;
    let found = solve(text);
    let nodes = &found.contacts[0].nodes;
    let at_end = |n: &&ContactNode<2>| n.point[0] < 0.3;
    assert_eq!(nodes.iter().filter(at_end).count(), 2);
    let largest = |pressures: Vec<f64>| pressures.into_iter().fold(0.0, f64::max);
    let all = largest(nodes.iter().map(|n| n.pressure).collect());
    let there = largest(nodes.iter().filter(at_end).map(|n| n.pressure).collect());
    assert!(there > 0.0);
    near(probe(&found, "most"), all, 1e-12);
    near(probe(&found, "there"), there, 1e-12);
    near(probe(&found, "gap"), 0.0, 1e-12);
}

/// A shaft 0.0025 too large for its hub: 6.15 by Lamé.
#[test]
fn rings_know_their_circles() {
    let text = r#"
analysis = "plane-stress"
[[body]]
name = "shaft"
mesh = { ring = { center = [0, 0], inner = 10, outer = 20.0025, cells = [24, 6], cell = "quad4" } }
material = { young = 210e3, poisson = 0.3 }
[[body]]
name = "hub"
mesh = { ring = { center = [0, 0], inner = 20, outer = 30, cells = [40, 6], cell = "quad4" } }
material = { young = 210e3, poisson = 0.3 }
fix = [{ point = [30, 0], y = 0 }, { point = [-30, 0], y = 0 }, { point = [0, 30], x = 0 }]
[[contact]]
name = "c"
nonmortar = "shaft.outer"
mortar = "hub.inner"
[[probe]]
name = "p"
quantity = "c.pressure"
reduce = "mean"
"#;
    for (cell, off) in [("quad4", 0.05), ("quad9", 0.01)] {
        let found = solve(&with(text, &[("quad4", cell)]));
        near(probe(&found, "p"), 6.15, off);
        let swapped = [
            ("\"shaft.outer\"", "X"),
            ("\"hub.inner\"", "\"shaft.outer\""),
            ("X", "\"hub.inner\""),
        ];
        let found = solve(&with(&with(text, &[("quad4", cell)]), &swapped));
        near(probe(&found, "p"), 6.15, off);
    }
    // as their facets are they overlap by what these miss of the circles
    let facets = with(
        text,
        &[(
            "material",
            "surface = { inner = \"facets\", outer = \"facets\" }\nmaterial",
        )],
    );
    assert!(
        solve(&facets)
            .warnings
            .iter()
            .any(|w| w.contains("count as closed"))
    );
}

/// One interface as two contacts that have the node at x = 1 in common.
const SPLIT: &str = r#"
analysis = "plane-strain"
[[body]]
name = "low"
mesh = { rectangle = { from = [0, 0], to = [2, 1], cells = [4, 2] }, sides = { l = { of = "top", min = [-1, 0.9], max = [1.001, 1.1] }, r = { of = "top", min = [0.999, 0.9], max = [3, 1.1] } } }
material = { young = 1000, poisson = 0.3 }
fix = [{ side = "bottom", y = 0 }, { side = "left", x = 0 }]
[[body]]
name = "up"
mesh = { rectangle = { from = [0, 1], to = [2, 2], cells = [4, 2] }, sides = { l = { of = "bottom", min = [-1, 0.9], max = [1.001, 1.1] }, r = { of = "bottom", min = [0.999, 0.9], max = [3, 1.1] } } }
material = { young = 1000, poisson = 0.3 }
fix = [{ side = "left", x = 0 }]
load = [{ side = "top", traction = ["SHEAR", "-1 - BEND * (x - 1)"] }]
[[contact]]
name = "c1"
nonmortar = "up.l"
mortar = "low.l"
LAW1
[[contact]]
name = "c2"
nonmortar = "up.r"
mortar = "low.r"
LAW2
"#;

/// Pressures of two contacts along x; those at the common node are told by both.
fn along_both(solution: &Solution<2>) -> Vec<(f64, f64)> {
    let nodes = solution.contacts.iter().flat_map(|c| &c.nodes);
    let mut found: Vec<(f64, f64)> = nodes.map(|n| (n.point[0], n.pressure)).collect();
    found.sort_by(|a, b| a.0.total_cmp(&b.0));
    found
}

#[test]
fn contacts_that_share_a_node_share_its_force() {
    let split = |laws: [&str; 2], shear: &str, bend: &str| {
        with(
            SPLIT,
            &[
                ("LAW1", laws[0]),
                ("LAW2", laws[1]),
                ("SHEAR", shear),
                ("BEND", bend),
            ],
        )
    };
    let laws = [
        ["", ""],
        ["tied = true"; 2],
        ["friction = 0.3"; 2],
        ["friction = 0.3", ""],
        ["", "friction = 0.2"],
        ["tied = true", ""],
        ["", "tied = true"],
        ["friction = 0.3", "tied = true"],
        ["pairing = \"mortar\""; 2],
    ];
    for laws in laws {
        let found = solve(&split(laws, "0", "0"));
        for contact in &found.contacts {
            near(contact.resultant[1], 1.0, 1e-10);
            near(contact.length, 1.0, 1e-12);
            let weights: f64 = contact.nodes.iter().map(|n| n.weight).sum();
            near(weights, 1.0, 1e-12);
        }
        assert!(
            along_both(&found)
                .iter()
                .all(|(_, p)| (p - 1.0).abs() < 1e-9),
            "{laws:?}"
        );
        assert!(found.warnings.is_empty(), "{:?}", found.warnings);
        // one contact says the same
        let found = solve(&split(laws, "0", "0.4"));
        let one = split(laws, "0", "0.4");
        let end = one.find("[[contact]]").unwrap();
        let law = if laws[0].is_empty() { laws[1] } else { laws[0] };
        if laws[0] == laws[1] {
            let one = format!(
                "{}[[contact]]\nname = \"c\"\nnonmortar = \"up.bottom\"\nmortar = \"low.top\"\n{law}\n",
                &one[..end]
            );
            let one = solve(&one);
            for (x, p) in along_both(&found) {
                let nodes = &one.contacts[0].nodes;
                let node = nodes
                    .iter()
                    .find(|n| (n.point[0] - x).abs() < 1e-9)
                    .unwrap();
                near(p, node.pressure, 1e-9);
            }
            let sum: f64 = found.contacts.iter().map(|c| c.resultant[1]).sum();
            near(sum, one.contacts[0].resultant[1], 1e-9);
        }
        // whichever body carries the multipliers
        let swapped = [
            ("\"up.r\"", "X"),
            ("\"low.r\"", "\"up.r\""),
            ("X", "\"low.r\""),
        ];
        let swapped = solve(&with(&split(laws, "0", "0.4"), &swapped));
        for (a, b) in along_both(&found).iter().zip(along_both(&swapped)) {
            near(a.1, b.1, 1e-9);
        }
    }
    // a tie that pulls at the common node bears all of that, and all of the shear
    for (laws, tie) in [
        (["tied = true", "friction = 0.4"], 0),
        (["", "tied = true"], 1),
    ] {
        let pulled = split(laws, "0.02", "0").replace("-1 - 0 * (x - 1)", "0.1");
        let pulled = pulled.replace("fix = [{ side = \"left\", x = 0 }]\nload", "load");
        let found = solve(&pulled);
        let [tied, loose] = [&found.contacts[tie], &found.contacts[1 - tie]];
        near(tied.resultant[1], -0.2, 1e-10);
        near(tied.resultant[0], -0.04, 1e-10);
        near(loose.resultant[0].hypot(loose.resultant[1]), 0.0, 1e-12);
        assert!(
            loose
                .nodes
                .iter()
                .all(|n| n.pressure == 0.0 && n.shear == [0.0; 2])
        );
        let common = tied.nodes.iter().find(|n| n.point[0] == 1.0).unwrap();
        assert!(common.pressure < 0.0);
        let forces = tied.nodes.iter().map(|n| n.pressure * n.weight);
        near(forces.sum(), -0.2, 1e-10);
    }
    // what slides bears the shear of both coefficients: 0.3 and 0.1 on halves of equal pressure at the common node
    let sliding = with(
        &split(["friction = 0.3", "friction = 0.1"], "0", "0"),
        &[
            (
                "load = [",
                "load = [{ point = [0, 1.5], force = [0.05, 0] }, ",
            ),
            (
                "fix = [{ side = \"left\", x = 0 }]",
                "fix = [{ side = \"right\", x = 0.2 }]",
            ),
        ],
    );
    let found = solve(&sliding);
    for (contact, coefficient) in found.contacts.iter().zip([0.3, 0.1]) {
        for node in &contact.nodes {
            assert_eq!(node.status, Status::Slip);
            near(node.shear[0], -coefficient * node.pressure, 1e-9);
        }
        near(
            contact.resultant[0],
            -coefficient * contact.resultant[1],
            1e-9,
        );
    }
}

/// A plane that leans by a fifth: forces act along its normal, and the rows tell so.
/// A contact that repeats another one bears nothing, and takes nothing of its force.
#[test]
fn a_contact_that_is_written_twice_is_one() {
    let text = |first: &str, again: &str, cells: usize| {
        format!(
            r#"
analysis = "plane-strain"
[[body]]
name = "low"
mesh = {{ rectangle = {{ from = [0, -1], to = [2, 0], cells = [4, 2] }} }}
material = {{ young = 1000, poisson = 0 }}
fix = [{{ side = "bottom", x = 0, y = 0 }}]
[[body]]
name = "up"
mesh = {{ rectangle = {{ from = [0, 0], to = [2, 1], cells = [{cells}, 2] }} }}
material = {{ young = 1000, poisson = 0 }}
fix = [{{ side = "top", x = 0 }}]
load = [{{ side = "top", pressure = 1 }}]
[[contact]]
name = "first"
{first}
[[contact]]
name = "again"
{again}
"#
        )
    };
    let (down, up) = (
        "nonmortar = \"up.bottom\"\nmortar = \"low.top\"",
        "nonmortar = \"low.top\"\nmortar = \"up.bottom\"",
    );
    for (first, again, cells) in [
        (down, down, 4),
        (down, up, 4),
        (up, down, 4),
        (down, down, 5),
    ] {
        let solution = solve(&text(first, again, cells));
        let contact = &solution.contacts[0];
        near(contact.resultant[1].abs(), 2.0, 1e-10);
        for node in &contact.nodes {
            near(node.pressure, 1.0, 1e-9);
        }
        near(solution.contacts[1].resultant[1], 0.0, 1e-10);
        let dropped = |w: &String| w.contains("\"again\"") && w.contains("dropped");
        assert!(solution.warnings.iter().any(dropped));
    }
}

#[test]
fn rows_tell_the_direction_of_their_forces() {
    let text = |pairing: &str, cell: &str| {
        format!(
            r#"
analysis = "plane-strain"
[[body]]
name = "b"
mesh = {{ rectangle = {{ from = [0, 0], to = [1, 1], cells = [4, 4], cell = "{cell}" }} }}
material = {{ young = 1000, poisson = 0.3 }}
fix = [{{ side = "bottom", x = 0, y = 0 }}]
[[contact]]
name = "c"
nonmortar = "b.top"
obstacle = {{ plane = {{ point = [0, 0.95], normal = [-0.2, -1] }} }}
friction = 0.1
pairing = "{pairing}"
"#
        )
    };
    for pairing in ["node-to-node", "mortar"] {
        for cell in ["quad4", "quad9"] {
            let solution = solve(&text(pairing, cell));
            let contact = &solution.contacts[0];
            let length = 1.04f64.sqrt();
            let mut sum = [0.0; 2];
            for node in &contact.nodes {
                near(node.normal[0], 0.2 / length, 1e-12);
                near(node.normal[1], 1.0 / length, 1e-12);
                for (d, sum) in sum.iter_mut().enumerate() {
                    *sum += node.weight * (node.shear[d] - node.pressure * node.normal[d]);
                }
            }
            let largest = contact.resultant[1].abs();
            near(sum[0], contact.resultant[0], 1e-9 * largest);
            near(sum[1], contact.resultant[1], 1e-9 * largest);
        }
    }
}

const DRAG: &str = r#"
analysis = "plane-strain"
[[body]]
name = "block"
mesh = { rectangle = { from = [1.0, 0.0], to = [2.0, 1.0], cells = [2, 2] } }
material = { young = 1e6, poisson = 0.3 }
fix = [{ side = "bottom", x = 0.1 }]
load = [{ side = "top", traction = [0.0, -10.0] }]
[[body]]
name = "base"
mesh = { rectangle = { from = [0.0, -1.0], to = [3.0, 0.0], cells = [6, 1] } }
material = { young = 1e6, poisson = 0.3 }
fix = [{ side = ["bottom", "top"], x = 0.0, y = 0.0 }]
[[contact]]
name = "sole"
SIDES
friction = 0.2
"#;

#[test]
fn a_slip_that_supports_prescribe_is_opposed_by_friction() {
    let base = "nonmortar = \"block.bottom\"\nmortar = \"base.top\"";
    let swapped = "nonmortar = \"base.top\"\nmortar = \"block.bottom\"";
    let rigid =
        "nonmortar = \"block.bottom\"\nobstacle = { plane = { point = [0, 0], normal = [0, 1] } }";
    let mortar = format!("{base}\npairing = \"mortar\"");
    for sides in [base, swapped, rigid, &mortar] {
        let solution = solve(&with(DRAG, &[("SIDES", sides)]));
        near(solution.bodies[0].reaction[0], 2.0, 1e-9);
        let contact = &solution.contacts[0];
        near(contact.resultant[0].abs(), 2.0, 1e-9);
        near(contact.resultant[1].abs(), 10.0, 1e-9);
        assert!(contact.nodes.iter().all(|n| n.status != Status::Stick));
    }
    // a floor that slides under a sole that is held
    for (sole, floor) in [
        ("0.0", "[0.05, 0]"),
        ("0.1", "[0.05, 0]"),
        ("-0.1", "[0.0, 0]"),
    ] {
        let moved = format!(
            "nonmortar = \"block.bottom\"\nobstacle = {{ plane = {{ point = [0, 0], normal = [0, 1] }}, displacement = {floor} }}"
        );
        let solution = solve(&with(
            DRAG,
            &[("SIDES", &moved), ("x = 0.1", &format!("x = {sole}"))],
        ));
        let expected = if sole == "0.1" { -2.0 } else { 2.0 };
        near(solution.contacts[0].resultant[0], expected, 1e-9);
        near(solution.bodies[0].reaction[0], -expected, 1e-9);
    }
    // nothing slips, nothing is dragged
    let solution = solve(&with(DRAG, &[("SIDES", base), ("x = 0.1", "x = 0.0")]));
    near(solution.contacts[0].resultant[0], 0.0, 1e-9);
}

#[test]
fn a_slip_that_supports_prescribe_in_space_is_opposed_along_itself() {
    let text = r#"
analysis = "3d"
[[body]]
name = "block"
mesh = { box = { from = [0, 0, 0], to = [1, 1, 1], cells = [2, 2, 2], cell = "CELL" } }
material = { young = 1000, poisson = 0.0 }
fix = [{ side = "bottom", x = 0.03, y = 0.04 }]
load = [{ side = "top", traction = [0, 0, -1] }]
[[contact]]
name = "sole"
nonmortar = "block.bottom"
obstacle = { plane = { point = [0, 0, 0], normal = [0, 0, 1] } }
friction = 0.3
"#;
    for cell in ["hex8", "hex20", "tet4", "tet10"] {
        let solution = solve_in_space(&with(text, &[("CELL", cell)]));
        let [x, y, z] = solution.contacts[0].resultant;
        near(z, 1.0, 1e-9);
        near(x, -0.18, 1e-8);
        near(y, -0.24, 1e-8);
        // along one of them alone
        let solution = solve_in_space(&with(
            text,
            &[("CELL", cell), ("x = 0.03, y = 0.04", "x = 0.03")],
        ));
        let force = solution.contacts[0].resultant;
        near(force[0], -0.3, 1e-3);
        near(force[0], -solution.bodies[0].reaction[0], 1e-9);
        near(force[1], 0.0, 1e-9);
    }
}

#[test]
fn a_facet_that_faces_nothing_at_one_end_slips_at_the_other() {
    let text = r#"
analysis = "plane-strain"
[[body]]
name = "base"
mesh = { rectangle = { from = [0.05, -1], to = [2, 0], cells = [3, 1] } }
material = { young = 1000, poisson = 0.0 }
fix = [{ side = "bottom", x = 0.05, y = 0 }]
[[body]]
name = "block"
mesh = { rectangle = { from = [0, 0], to = [1, 1], cells = [1, 1] } }
material = { young = 1000, poisson = 0.0 }
load = [{ side = "top", traction = [0, -1] }]
fix = [{ side = "bottom", x = 0 }]
[[contact]]
name = "sole"
nonmortar = "block.bottom"
mortar = "base.top"
friction = 0.3
"#;
    let solution = solve(text);
    near(solution.contacts[0].resultant[0], 0.3, 1e-9);
    near(solution.bodies[0].reaction[0], 0.3, 1e-9);
}

#[test]
fn a_tie_bears_what_one_side_holds() {
    let text = r#"
analysis = "plane-strain"
[[body]]
name = "base"
mesh = { rectangle = { from = [-1, -1], to = [2, 0], cells = [3, 1] } }
material = { young = 1000, poisson = 0.0 }
fix = [{ side = "bottom", x = 0.05, y = 0 }]
[[body]]
name = "block"
mesh = { rectangle = { from = [0, 0], to = [1, 1], cells = [3, 1] } }
material = { young = 1000, poisson = 0.0 }
load = [{ side = "top", traction = [0, -1] }]
fix = [{ side = "bottom", x = 0 }]
[[contact]]
name = "sole"
nonmortar = "block.bottom"
mortar = "base.top"
tied = true
"#;
    let solution = solve(text);
    near(solution.contacts[0].resultant[0], 54.7, 0.1);
    let swapped = [
        ("\"block.bottom\"", "X"),
        ("\"base.top\"", "\"block.bottom\""),
        ("X", "\"base.top\""),
    ];
    let swapped = solve(&with(text, &swapped));
    near(swapped.contacts[0].resultant[0], -54.7, 0.1);
    let top = |solution: &Solution<2>| -> Point<2> {
        let points: Vec<Point<2>> = solution.bodies[0].displacement.clone();
        points[points.len() - 2]
    };
    near(top(&solution)[0], top(&swapped)[0], 1e-2);
}

/// A joint with strength in tension whose left node is dragged along: statics, and its bound all along.
#[test]
fn a_joint_that_supports_drag_is_in_balance() {
    let text = r#"
analysis = "plane-strain"
[[body]]
name = "block"
mesh = { rectangle = { from = [0, 0], to = [1, 1], cells = [2, 2] } }
material = { young = 1e9, poisson = 0.0 }
fix = [{ side = "left", x = 0.01 }]
load = [{ side = "top", traction = [0, -1e6] }]
[[contact]]
name = "joint"
nonmortar = "block.bottom"
obstacle = { plane = { point = [0, 0], normal = [0, 1] } }
friction = { cohesion = 1e5, coulomb = 0.5, tension = 1e5 }
"#;
    for text in [text, &with(text, &[(", tension = 1e5", "")])] {
        let solution = solve(text);
        let [x, y] = solution.contacts[0].resultant;
        near(y, 1e6, 1e-3);
        // all of it slips: cohesion and friction
        near(x, -(1e5 + 0.5e6), 1.0);
        near(x, -solution.bodies[0].reaction[0], 1e-3);
    }
}
