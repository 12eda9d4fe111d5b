//! The certificate sees what was dropped, prescribed or moved: each problem here was once certified and wrong.

use dotyk::case::Case;
use dotyk::mesh::{
    CellBlock, CellKind, Cuboid, Diagonals, Extrude, Facet, Mesh, Path as Along, Rectangle,
};
use dotyk::model::{ContactNode, Elastic, Error, Law, Model, Objection, Place, Solution, Status};
use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Arc;

const PLANE: &str = "analysis = \"plane-strain\"\n";

fn case(text: &str) -> Case<2> {
    Case::<2>::from_str(text, "case.toml", Path::new(".")).unwrap()
}

fn solve(text: &str) -> Result<Solution<2>, Error<2>> {
    case(text).model.solve()
}

/// A rectangle of E = 1000, ν = 0.3.
fn block(name: &str, from: [f64; 2], to: [f64; 2], cells: [usize; 2], extra: &str) -> String {
    format!(
        "[[body]]\nname = \"{name}\"\nmesh = {{ rectangle = {{ from = {from:?}, to = {to:?}, cells = {cells:?} }} }}\n\
         material = {{ young = 1000.0, poisson = 0.3 }}\n{extra}\n"
    )
}

fn contact(name: &str, what: &str) -> String {
    format!("[[contact]]\nname = \"{name}\"\n{what}\n")
}

fn obstacle(name: &str, side: &str, what: &str) -> String {
    contact(name, &format!("nonmortar = \"{side}\"\nobstacle = {what}"))
}

/// Every node obeys Coulomb's law: within the bound, and at it where it slips, against the motion of the body.
fn obeys(node: &ContactNode<2>, coefficient: f64, scale: f64) {
    let bound = coefficient * node.pressure;
    let (shear, slip) = (node.shear, node.slip);
    let size = |v: [f64; 2]| v[0].hypot(v[1]);
    assert!(size(shear) <= bound + 1e-9 * scale, "{node:?}");
    if node.pressure > 0.0 && size(slip) > 1e-9 {
        assert!(size(shear) >= bound - 1e-9 * scale, "{node:?}");
        assert!(shear[0] * slip[0] + shear[1] * slip[1] < 0.0, "{node:?}");
    }
}

#[test]
fn a_corner_with_friction_on_both_walls_is_not_passed() {
    let text = [
        PLANE.to_string(),
        block(
            "block",
            [0.0; 2],
            [1.0; 2],
            [4, 4],
            "body_force = [-1.0, -1.0]",
        ),
        obstacle(
            "floor",
            "block.bottom",
            "{ plane = { point = [0.0, 0.0], normal = [0.0, 1.0] } }\nfriction = 0.3",
        ),
        obstacle(
            "wall",
            "block.left",
            "{ plane = { point = [0.0, 0.0], normal = [1.0, 0.0] } }\nfriction = 0.3",
        ),
    ]
    .concat();
    let solution = solve(&text).unwrap();
    for contact in &solution.contacts {
        for node in &contact.nodes {
            assert!(node.gap > -1e-15, "{node:?}");
            obeys(node, 0.3, 1.0);
        }
    }
    let [floor, wall] = [0, 1].map(|k| solution.contacts[k].resultant);
    for component in 0..2 {
        assert!((floor[component] + wall[component] - 1.0).abs() < 1e-12);
    }
    let shared = |w: &String| w.contains("node 0 at (0, 0)") && w.contains("not unique");
    assert!(
        solution.warnings.iter().any(shared),
        "{:?}",
        solution.warnings
    );
}

/// A block in the corner of a body, by one contact with these further keys.
fn in_a_corner(of_block: &str, of_contact: &str) -> String {
    PLANE.to_string()
        + "[[body]]\nname = \"corner\"\nmaterial = { young = 1000, poisson = 0.3 }\n\
           fix = [{ side = \"base\", x = 0, y = 0 }]\n\
           [body.mesh.outline]\nsize = 0.4\nfrom = [-1, -1]\n\
           edges = [{ to = [2, -1], name = \"base\" }, { to = [2, 0] }, { to = [0, 0], name = \"face\" }, \
           { to = [0, 2], name = \"face\" }, { to = [-1, 2] }, { to = [-1, -1] }]\n"
        + &block("block", [0.0; 2], [1.0; 2], [4, 4], of_block)
        + &contact(
            "both",
            &format!(
                "nonmortar = [\"block.bottom\", \"block.left\"]\nmortar = \"corner.face\"\n{of_contact}"
            ),
        )
}

#[test]
fn a_corner_node_of_one_contact_shares_with_no_other() {
    let text = in_a_corner("body_force = [-1.0, -1.0]", "friction = 0.3");
    let warnings = solve(&text).unwrap().warnings;
    let shared: Vec<&String> = warnings
        .iter()
        .filter(|w| w.contains("not unique"))
        .collect();
    let told = "several of its forces do the same; how they share it is not unique";
    assert!(
        shared.len() == 1 && shared[0].ends_with(told),
        "{warnings:?}"
    );
}

/// Two blocks that are tied to each other stand on a third one, whose nodes coincide with theirs: the shear of the tie could bear any part
/// of the force at its foot.
#[test]
fn pressure_goes_on_from_a_block_to_one_that_is_tied_to_it() {
    for (law, load, method) in [
        ("", "[0.0, -1.0]", "auto"),
        ("", "[0.0, -1.0]", "mprgp"),
        ("friction = 0.5", "[0.0, -1.0]", "auto"),
        ("friction = 0.5", "[0.1, -1.0]", "auto"),
        ("friction = 0.11", "[0.1, -1.0]", "auto"),
    ] {
        let under = format!("load = [{{ side = \"top\", traction = {load} }}]");
        let text = [
            format!("{PLANE}[solver]\nmethod = \"{method}\"\n"),
            block(
                "low",
                [0.0, 0.0],
                [4.0, 1.0],
                [8, 2],
                "fix = [{ side = \"bottom\", x = 0, y = 0 }]",
            ),
            block(
                "a",
                [0.0, 1.0],
                [2.0, 2.0],
                [4, 2],
                &format!("fix = [{{ side = \"left\", x = 0 }}]\n{under}"),
            ),
            block("b", [2.0, 1.0], [4.0, 2.0], [4, 2], &under),
            contact(
                "t",
                "nonmortar = \"a.right\"\nmortar = \"b.left\"\ntied = true",
            ),
            contact(
                "c",
                &format!("nonmortar = \"a.bottom\"\nmortar = \"low.top\"\n{law}"),
            ),
            contact(
                "d",
                &format!("nonmortar = \"b.bottom\"\nmortar = \"low.top\"\n{law}"),
            ),
        ]
        .concat();
        let solution = case(&text).model.solve().unwrap();
        let at_foot = |contact: usize| {
            let mut nodes = solution.contacts[contact].nodes.iter();
            let foot = |n: &&ContactNode<2>| (n.point[0] - 2.0).abs() < 1e-9;
            let found = nodes.find(foot).unwrap();
            [found.pressure, found.shear[0]]
        };
        let [c, d] = [1, 2].map(at_foot);
        for (c, d) in c.into_iter().zip(d) {
            // the tie counts a millionth
            assert!((c - d).abs() < 1e-5, "{law} {load} {method}: {c} {d}");
        }
    }
}

#[test]
fn the_nearer_of_two_obstacles_counts_whatever_their_order() {
    let body = "fix = [{ side = \"left\", x = 0.0 }, { side = \"right\", x = 0.0 }]\n\
                load = [{ side = \"top\", traction = [0.0, -10.0] }]";
    for gaps in [[0.1, 0.05], [0.05, 0.1]] {
        let text = [
            PLANE.to_string(),
            block("block", [0.0; 2], [1.0; 2], [4, 4], body),
            obstacle("first", "block.bottom", &format!("{{ gap = {} }}", gaps[0])),
            obstacle(
                "second",
                "block.bottom",
                &format!("{{ gap = {} }}", gaps[1]),
            ),
        ]
        .concat();
        let solution = solve(&text).unwrap();
        for (contact, gap) in solution.contacts.iter().zip(gaps) {
            let near = gap == 0.05;
            assert!((contact.resultant[1] - if near { 10.0 } else { 0.0 }).abs() < 1e-12);
            for node in &contact.nodes {
                assert!((node.gap - (gap - 0.05)).abs() < 1e-14, "{node:?}");
                assert_eq!(node.status == Status::Open, !near);
            }
        }
    }
}

#[test]
fn an_obstacle_that_moves_along_its_face_drags_the_body() {
    let text = |motion: &str| {
        let floor = format!(
            "{{ plane = {{ point = [0.0, 0.0], normal = [0.0, 1.0] }}, displacement = {motion} }}\nfriction = 0.5"
        );
        let body = "fix = [{ side = \"top\", x = 0.0 }]\nload = [{ side = \"top\", traction = [0.0, -10.0] }]";
        let steps = "[[step]]\ntime = 1.0\n[[step]]\ntime = 2.0\n";
        [
            PLANE.to_string(),
            block("block", [0.0; 2], [1.0; 2], [4, 4], body),
            obstacle("floor", "block.bottom", &floor),
            steps.to_string(),
        ]
        .concat()
    };
    // far: it slips under the block; force on the block along the motion, at the limit but for nodes that lift
    let far = solve(&text("[\"0.1*t\", 0.0]")).unwrap();
    let floor = &far.contacts[0];
    assert!(floor.resultant[0] > 4.9 && floor.resultant[0] < 5.0 + 1e-12);
    // near: all stick, as if the bottom were moved
    let near = solve(&text("[\"1e-4*t\", 0.0]")).unwrap();
    let held = [
        PLANE.to_string(),
        block("block", [0.0; 2], [1.0; 2], [4, 4], "fix = [{ side = \"top\", x = 0.0 }, { side = \"bottom\", x = 2e-4, y = 0.0 }]\nload = [{ side = \"top\", traction = [0.0, -10.0] }]"),
    ]
    .concat();
    let held = solve(&held).unwrap();
    // the floor holds in the first step what Poisson's ratio pushes out; the sum of the shears is that of the motion
    assert!(
        (near.contacts[0].resultant[0] - held.bodies[0].side_reactions["bottom"][0]).abs() < 1e-9
    );
    for node in floor.nodes.iter().chain(&near.contacts[0].nodes) {
        assert!(node.gap > -1e-14);
    }
    assert!(
        near.contacts[0]
            .nodes
            .iter()
            .all(|n| n.status == Status::Stick)
    );
}

#[test]
fn a_tipping_block_is_held_by_no_floor_beside_it() {
    for (cells, sides) in [
        (
            [6, 2],
            "nonmortar = \"floor.top\"\nmortar = \"block.bottom\"",
        ),
        (
            [6, 2],
            "nonmortar = \"block.bottom\"\nmortar = \"floor.top\"",
        ),
        (
            [17, 3],
            "nonmortar = \"floor.top\"\nmortar = \"block.bottom\"",
        ),
    ] {
        for cell in ["quad4", "quad9"] {
            // the resultant leaves the sole at a push of 0.5
            for (push, held) in [(0.495, true), (0.505, false)] {
                let text = [
                    PLANE.to_string(),
                    block(
                        "floor",
                        [-2.0, -1.0],
                        [3.0, 0.0],
                        cells,
                        "fix = [{ side = \"bottom\", x = 0.0, y = 0.0 }]",
                    ),
                    block(
                        "block",
                        [0.0, 0.0],
                        [1.0, 2.0],
                        [4, 8],
                        &format!("body_force = [-{push}, -1.0]"),
                    ),
                    contact("sole", &format!("{sides}\nfriction = 1.0")),
                ]
                .concat()
                .replace("cells =", &format!("cell = \"{cell}\", cells ="));
                match solve(&text) {
                    Ok(_) => assert!(held, "{sides} {cell}"),
                    Err(Error::PulledAway { body, .. }) => assert!(!held && body == "block"),
                    Err(error) => panic!("{sides} {cell} {push}: {error}"),
                }
            }
        }
    }
}

#[test]
fn a_quadratic_side_that_ends_at_the_axis_bears_what_hertz_says() {
    let text = "analysis = \"axisymmetric\"\n\
        [[body]]\nname = \"sphere\"\n\
        mesh = { ring = { inner = 2.0, outer = 10.0, from = -90, to = 0, cells = [48, 10], grade = 0.9, cell = \"quad9\" } }\n\
        material = { young = 1000.0, poisson = 0.3 }\n\
        load = [{ side = \"inner\", traction = [0.0, -1.0] }]\n\
        surface = { outer = { circle = { center = [0.0, 0.0], radius = 10.0 } } }\n"
        .to_string()
        + &obstacle("floor", "sphere.outer", "{ plane = { point = [0.0, -10.0], normal = [0.0, 1.0] } }");
    let floor = &solve(&text).unwrap().contacts[0];
    let (force, modulus) = (floor.resultant[1], 1000.0 / 0.91);
    let radius = (0.75 * force * 10.0 / modulus).cbrt();
    let peak = 1.5 * force / (std::f64::consts::PI * radius * radius);
    let apex = floor
        .nodes
        .iter()
        .find(|n| n.point[0].abs() < 1e-9)
        .unwrap();
    // the sphere is finite, and pressed from inside
    assert!(
        (apex.pressure / peak - 1.0).abs() < 0.03,
        "{} {peak}",
        apex.pressure
    );
    // a cell is 0.08 wide there
    assert!(
        (floor.length - radius).abs() < 0.08,
        "{} {radius}",
        floor.length
    );
}

#[test]
fn length_of_a_round_contact_is_that_of_its_meridian() {
    for cell in ["quad4", "quad8", "quad9", "tri6"] {
        let disc = |name: &str, y: f64, cells: [usize; 2], extra: &str| {
            block(name, [0.0, y], [1.0, y + 1.0], cells, extra)
        };
        let text = [
            "analysis = \"axisymmetric\"\n".to_string(),
            disc("low", 0.0, [5, 3], "fix = [{ side = \"bottom\", y = 0.0 }]"),
            disc(
                "up",
                1.0,
                [7, 3],
                "load = [{ side = \"top\", pressure = 2.0 }]",
            ),
            contact("sole", "nonmortar = \"up.bottom\"\nmortar = \"low.top\""),
        ]
        .concat()
        .replace("cells =", &format!("cell = \"{cell}\", cells ="));
        let sole = &solve(&text).unwrap().contacts[0];
        assert!((sole.length - 1.0).abs() < 1e-12, "{cell}: {}", sole.length);
    }
}

#[test]
fn two_meshes_of_one_arc_press_evenly() {
    let ring = |name: &str, a: f64, b: f64, size: f64, extra: &str| {
        format!(
            "[[body]]\nname = \"{name}\"\nmesh = {{ outline = {{ from = [{a:?}, 0.0], size = {size}, cell = \"tri6\", edges = [\
             {{ to = [{b:?}, 0.0], name = \"start\" }}, {{ to = [0.0, {b:?}], center = [0.0, 0.0], name = \"outer\" }},\
             {{ to = [0.0, {a:?}], name = \"end\" }}, {{ to = [{a:?}, 0.0], center = [0.0, 0.0], clockwise = true, name = \"inner\" }}] }} }}\n\
             material = {{ young = 1e5, poisson = 0.3 }}\nfix = [{{ side = \"start\", y = 0.0 }}, {{ side = \"end\", x = 0.0 }}]\n{extra}\n"
        )
    };
    let text = [
        PLANE.to_string(),
        ring("in", 1.0, 2.0, 0.15, ""),
        ring(
            "out",
            2.0,
            3.0,
            0.4,
            "load = [{ side = \"outer\", pressure = 1.0 }]",
        ),
        contact("fit", "sides = [\"in.outer\", \"out.inner\"]"),
    ]
    .concat();
    let scatter = |text: &str| {
        let solution = solve(text).unwrap();
        let nodes = solution.contacts[0].nodes.iter().map(|n| n.pressure);
        let (low, high) = nodes.fold((f64::INFINITY, 0.0f64), |(l, h), p| (l.min(p), h.max(p)));
        ((high - low) / (high + low), solution.warnings)
    };
    let (known, warnings) = scatter(&text);
    assert!(known < 0.005 && warnings.is_empty(), "{known} {warnings:?}");
    // where nobody knows the arc, the gaps are below what the meshes miss of it
    let rings = |cell: &str, surface: &str| {
        let ring = |name: &str, inner: f64, cells: [usize; 2], extra: &str| {
            format!(
                "[[body]]\nname = \"{name}\"\nmesh = {{ ring = {{ inner = {inner:?}, outer = {:?}, from = 0, to = 90, cells = {cells:?}, cell = \"{cell}\" }} }}\n\
                 material = {{ young = 1e5, poisson = 0.3 }}\nfix = [{{ side = \"start\", y = 0.0 }}, {{ side = \"end\", x = 0.0 }}]\n{surface}\n{extra}\n",
                inner + 1.0
            )
        };
        [
            PLANE.to_string(),
            ring("in", 1.0, [14, 6], ""),
            ring(
                "out",
                2.0,
                [9, 5],
                "load = [{ side = \"outer\", pressure = 1.0 }]",
            ),
            contact("fit", "sides = [\"in.outer\", \"out.inner\"]"),
        ]
        .concat()
    };
    for (cell, most) in [("quad8", 0.001), ("quad9", 0.001), ("quad4", 0.03)] {
        let (known, warnings) = scatter(&rings(cell, ""));
        assert!(known < most && warnings.is_empty(), "{cell}: {known}");
        let facets = "surface = { inner = \"facets\", outer = \"facets\" }";
        let (unknown, warnings) = scatter(&rings(cell, facets));
        assert!(unknown < most, "{cell}: {unknown}");
        let [warning] = &warnings[..] else {
            panic!("{warnings:?}");
        };
        for word in ["\"fit\"", "`surface`", "\"closed\""] {
            assert!(warning.contains(word), "{warning}");
        }
    }
}

/// A post between floor and ceiling that is driven to turn: their clearance has a lever of half its width, so that it turns by two
/// radians before it touches both.
#[test]
fn a_body_that_hardly_anything_holds_against_turning_has_no_answer() {
    let text = r#"analysis = "plane-strain"
[[body]]
name = "post"
mesh = { rectangle = { from = [-0.005, 0.0], to = [0.005, 1.0], cells = [2, 50], cell = "quad8" } }
material = { young = 1.0, poisson = 0.3 }
body_force = [0.0, -1e-9]
fix = [{ point = [0.0, 0.5], x = 0.0 }]
load = [{ side = "left", traction = ["1e-11 * (y - 0.5)", 0.0] }]
[[contact]]
name = "floor"
nonmortar = "post.bottom"
obstacle = { plane = { point = [0.0, 0.0], normal = [0.0, 1.0] } }
[[contact]]
name = "ceiling"
nonmortar = "post.top"
obstacle = { plane = { point = [0.0, 1.02], normal = [0.0, -1.0] } }
"#;
    let Err(Error::NotConverged { reason, .. }) = solve(text) else {
        panic!("an answer");
    };
    let told = reason.to_string();
    let Objection::Turned { body, turn, .. } = *reason else {
        panic!("{told}");
    };
    assert!(body == "post" && (turn - 2.0).abs() < 1e-3, "{told}");
    assert!(told.contains("hold it by a support"), "{told}");
}

#[test]
fn what_a_tie_implies_is_judged_although_it_has_no_multiplier() {
    let text = |gap: f64| {
        [
            PLANE.to_string(),
            block(
                "low",
                [0.0; 2],
                [1.0; 2],
                [2, 2],
                "fix = [{ side = \"top\", x = 0.0, y = 0.0 }]",
            ),
            block(
                "up",
                [0.0, 1.0],
                [1.0, 2.0],
                [2, 2],
                "load = [{ side = \"top\", pressure = 1.0 }]",
            ),
            contact(
                "glue",
                "nonmortar = \"up.bottom\"\nmortar = \"low.top\"\ntied = true",
            ),
            obstacle("stop", "up.bottom", &format!("{{ gap = {gap:?} }}")),
        ]
        .concat()
    };
    let solution = solve(&text(0.01)).unwrap();
    let dropped = |w: &String| w.contains("\"stop\"") && w.contains("dropped");
    assert!(
        solution.warnings.iter().any(dropped),
        "{:?}",
        solution.warnings
    );
    let Err(Error::NotConverged { solution, .. }) = solve(&text(-0.01)) else {
        panic!("the glue holds the body where the stop is");
    };
    assert!((solution.certificate.penetration.value - 0.01).abs() < 1e-12);
}

#[test]
fn a_contact_that_faces_nothing_is_told_by_a_run() {
    let text = [
        PLANE.to_string(),
        block(
            "a",
            [0.0; 2],
            [1.0; 2],
            [2, 2],
            "fix = [{ side = \"bottom\", x = 0.0, y = 0.0 }]",
        ),
        block(
            "b",
            [5.0, 2.0],
            [6.0, 3.0],
            [2, 2],
            "fix = [{ side = \"top\", x = 0.0, y = 0.0 }]",
        ),
        contact("touch", "sides = [\"a.top\", \"b.bottom\"]"),
    ]
    .concat();
    let solution = solve(&text).unwrap();
    assert!(solution.warnings[0].contains("\"touch\": no node of a.top faces b.bottom"));
    assert_eq!(case(&text).model.check().warnings, solution.warnings);
}

#[test]
fn loads_that_balance_to_rounding_are_so_for_check_and_for_run() {
    let body = "load = [{ side = \"top\", pressure = 1.0 }, { side = \"bottom\", pressure = 1.000000000001 }]\n\
                fix = [{ side = \"left\", x = 0.0 }]";
    let text = [
        PLANE.to_string(),
        block("block", [0.0; 2], [1.0; 2], [2, 2], body),
        obstacle("floor", "block.bottom", "{ gap = 0.001 }"),
    ]
    .concat();
    assert_eq!(case(&text).model.check().errors, [""; 0]);
    solve(&text).unwrap();
}

#[test]
fn prescribed_nodes_in_the_middle_of_a_side_press_the_other_body() {
    // the middle of the upper body's bottom is pushed into the lower one by its supports alone
    let push = "sides = { patch = { of = \"bottom\", min = [0.5, 1.0], max = [1.5, 1.0] } }";
    let upper = block(
        "up",
        [0.0, 1.0],
        [2.0, 2.0],
        [8, 4],
        "fix = [{ side = \"patch\", x = 0.0, y = -0.01 }]",
    )
    .replace("cells = [8, 4] }", &format!("cells = [8, 4] }}, {push}"));
    let text = [
        PLANE.to_string(),
        block(
            "low",
            [0.0, 0.0],
            [2.0, 1.0],
            [11, 5],
            "fix = [{ side = \"bottom\", x = 0.0, y = 0.0 }]",
        ),
        upper,
        contact("sole", "nonmortar = \"up.bottom\"\nmortar = \"low.top\""),
    ]
    .concat();
    let solution = solve(&text).unwrap();
    let force = solution.contacts[0].resultant[1];
    assert!(force > 5.0, "{force}");
    assert!((solution.bodies[0].reaction[1] - force).abs() < 1e-9 * force);
}

#[test]
fn the_corner_of_a_block_has_a_condition_for_each_wall() {
    // a block in the corner of an L, pushed down and away from the wall: one condition along the mean of both normals let
    // its corner sink into the floor
    let outline = "[[body]]\nname = \"frame\"\nmaterial = { young = 1000.0, poisson = 0.3 }\n\
                   mesh = { outline = { size = 0.25, cell = \"tri3\", from = [0.0, 1.0], edges = [\
                   { to = [0.0, 0.0], name = \"seat\" }, { to = [1.5, 0.0], name = \"seat\" }, \
                   { to = [1.5, -0.5], name = \"right\" }, { to = [-0.5, -0.5], name = \"base\" }, \
                   { to = [-0.5, 1.0], name = \"left\" }, { to = [0.0, 1.0], name = \"rim\" }] } }\n\
                   fix = [{ side = \"base\", x = 0.0, y = 0.0 }]\n";
    let body = "[[body]]\nname = \"block\"\nmaterial = { young = 1000.0, poisson = 0.3 }\n\
                mesh = { outline = { size = 0.25, cell = \"tri3\", from = [0.0, 1.0], edges = [\
                { to = [0.0, 0.0], name = \"sole\" }, { to = [1.0, 0.0], name = \"sole\" }, \
                { to = [1.0, 1.0], name = \"far\" }, { to = [0.0, 1.0], name = \"top\" }] } }\n\
                load = [{ side = \"top\", traction = [0.2, -1.0] }]\n";
    let joint = "nonmortar = \"block.sole\"\nmortar = \"frame.seat\"\ngap = 1e-3\nfriction = 0.5";
    let text = [PLANE, outline, body, &contact("joint", joint)].concat();
    let solution = solve(&text).unwrap();
    let nodes = &solution.contacts[0].nodes;
    let corner: Vec<_> = nodes
        .iter()
        .filter(|n| n.point[0].hypot(n.point[1]) < 1e-12)
        .collect();
    let [a, b] = corner[..] else {
        panic!("{corner:?}");
    };
    assert!((a.normal[0] * b.normal[0] + a.normal[1] * b.normal[1]).abs() < 1e-12);
    for node in nodes {
        assert!(node.gap.is_nan() || node.gap > -1e-15, "{node:?}");
        obeys(node, 0.5, 1.0);
    }
    let sink = if a.normal[1] < -0.5 { a } else { b };
    assert!((-sink.displacement_nonmortar).abs() > 0.9e-3, "{sink:?}");
    assert!(solution.certificate.between_nodes.relative < 1.0);
    let force = solution.contacts[0].resultant;
    assert!((force[0] + 0.2).abs() < 1e-9 && (force[1] - 1.0).abs() < 1e-9);
}

#[test]
fn forces_between_bodies_of_very_different_stiffness_do_not_depend_on_the_method() {
    // the soft block hides in its compliance by how much the stiff walls of the pocket are apart
    let text = |method: &str| {
        let pocket = "[[body]]\nname = \"box\"\nmesh = { outline = { size = 0.6, cell = \"tri6\", from = [0.0, 1.1], edges = [\
             { to = [0.0, 0.0], name = \"pocket\", cells = 4 }, { to = [1.0, 0.0], name = \"pocket\", cells = 6 }, \
             { to = [1.0, 1.1], name = \"pocket\", cells = 1 }, { to = [1.9, 1.1] }, { to = [1.9, -0.9] }, \
             { to = [-0.9, -0.9], name = \"base\" }, { to = [-0.9, 1.1] }, { to = [0.0, 1.1] }] } }\n\
             material = { young = 5e5, poisson = 0.35 }\nfix = [{ side = \"base\", x = 0.0, y = 0.0 }]\n";
        let soft = "[[body]]\nname = \"block\"\nmesh = { outline = { size = 0.6, from = [0.0, 1.1], edges = [\
             { to = [0.0, 0.0], name = \"sole\", cells = 5 }, { to = [1.0, 0.0], name = \"sole\", cells = 2 }, \
             { to = [1.0, 1.1], name = \"sole\", cells = 1 }, { to = [0.0, 1.1], name = \"top\" }] } }\n\
             material = { young = 1.0, poisson = 0.28 }\nload = [{ side = \"top\", traction = [2e-5, -1.4e-4] }]\n";
        let fit = contact(
            "fit",
            "nonmortar = \"box.pocket\"\nmortar = \"block.sole\"\npairing = \"mortar\"",
        );
        format!("{PLANE}{pocket}{soft}{fit}[solver]\nmethod = \"{method}\"\n")
    };
    let exact = solve(&text("newton")).unwrap();
    let other = solve(&text("accelerated")).unwrap();
    assert!(other.certificate.holds(), "{}", other.certificate);
    let largest = |s: f64, node: &ContactNode<2>| s.max((node.pressure * node.weight).abs());
    let force = exact.contacts[0].nodes.iter().fold(0.0, largest);
    assert!(force > 0.0);
    let pairs = exact.contacts[0].nodes.iter().zip(&other.contacts[0].nodes);
    for (a, b) in pairs {
        let off = (a.pressure - b.pressure) * a.weight / force;
        assert!(off.abs() < 1e-6, "{off:e} at {:?}", a.point);
    }
}

#[test]
fn a_slender_beam_on_many_supports_is_certified() {
    // the loads alone bend it by 1e5 of its height: the gaps of the answer are rounding beside that
    let beam = block(
        "beam",
        [0.0, 0.0],
        [1000.0, 1.0],
        [1000, 1],
        "fix = [{ side = \"left\", x = 0.0 }]\nload = [{ side = \"top\", pressure = 1.0 }]",
    )
    .replace("cells = [1000, 1]", "cells = [1000, 1], cell = \"quad8\"")
    .replace(
        "young = 1000.0, poisson = 0.3",
        "young = 12e6, poisson = 0.0",
    );
    let floor = obstacle(
        "floor",
        "beam.bottom",
        "{ gap = \"0.05*(1-cos(2*pi*x/10.0))+0.002*sin(x)\" }",
    );
    let solution = solve(&format!("{PLANE}{beam}{floor}")).unwrap();
    assert!(solution.certificate.holds(), "{}", solution.certificate);
    let force = solution.contacts[0].resultant[1];
    assert!((force - 1000.0).abs() < 1e-6 * force, "{force}");
    let bearing = solution.contacts[0]
        .nodes
        .iter()
        .filter(|n| n.pressure > 0.0)
        .count();
    assert!((50..150).contains(&bearing), "{bearing}");
}

/// Two blocks of almost one width that are drawn a little into each other, their whole boundaries as sides: the flank of the upper
/// tip of one faces nothing, though the other's flank lies behind it, inside of both all the way.
#[test]
fn whole_boundaries_of_blocks_that_are_sunk_a_little_press_as_the_sides_that_face_each_other() {
    let text = |own: &str, other: &str| {
        format!(
            r#"
analysis = "plane-strain"
[[body]]
name = "lower"
mesh = {{ rectangle = {{ from = [-0.35, 0], to = [0.257, 0.5232], cells = [11, 9], cell = "tri6" }} }}
material = {{ young = 1, poisson = 0.2 }}
fix = [{{ side = "bottom", x = 0, y = 0 }}]
[[body]]
name = "upper"
mesh = {{ rectangle = {{ from = [-0.345, 0.5228], to = [0.525, 1.46], cells = [5, 6], cell = "tri6" }} }}
material = {{ young = 1, poisson = 0.3 }}
fix = [{{ side = "left", x = 0 }}]
load = [{{ side = "top", pressure = 1e-4 }}]
[[contact]]
name = "c"
nonmortar = {own}
mortar = {other}
"#
        )
    };
    let all = |body: &str| {
        let sides = ["left", "bottom", "right", "top"].map(|side| format!("\"{body}.{side}\""));
        format!("[{}]", sides.join(", "))
    };
    let largest = |text: &str| {
        let case = Case::<2>::from_str(text, "case.toml", Path::new(".")).unwrap();
        let solution = case.model.solve().unwrap();
        let moves = solution.bodies.iter().flat_map(|body| &body.displacement);
        moves.fold(0.0, |s: f64, u| s.max(u[0].hypot(u[1])))
    };
    let facing = largest(&text("\"lower.top\"", "\"upper.bottom\""));
    let whole = largest(&text(&all("lower"), &all("upper")));
    // the strain of the load and of an overlap of 4e-4 over heights of about one
    assert!(facing > 1e-4 && facing < 2e-3, "{facing}");
    assert!((whole - facing).abs() < 1e-9 * facing, "{whole} {facing}");
}

/// A free body that is curved by a strain of its own, without a stress, and lies on a plane: nothing presses, whatever the cells.
#[test]
fn a_body_that_is_warped_without_a_load_lies_without_a_force() {
    for (cell, cells) in [
        ("tri6", [3, 2]),
        ("quad4", [6, 2]),
        ("quad9", [3, 2]),
        ("tri3", [4, 2]),
        ("quad8", [5, 3]),
    ] {
        for (strain, law) in [
            ("xx = \"-1e-3*y\"", ""),
            ("xx = \"1e-3*y\"", ""),
            ("thermal = 1, expansion = 1e-3", "friction = 0.3"),
        ] {
            let text = format!(
                r#"
analysis = "plane-strain"
[[body]]
name = "a"
mesh = {{ rectangle = {{ from = [0, 0], to = [1, 1], cells = [{}, {}], cell = "{cell}" }} }}
material = {{ young = 1000, poisson = 0.2 }}
initial_strain = {{ {strain} }}
[[contact]]
name = "c"
nonmortar = "a.bottom"
obstacle = {{ plane = {{ point = [0, 0], normal = [0, 1] }} }}
{law}
"#,
                cells[0], cells[1]
            );
            let case = Case::<2>::from_str(&text, "case.toml", Path::new(".")).unwrap();
            let solution = case.model.solve().unwrap();
            let contact = &solution.contacts[0];
            assert!(contact.resultant.iter().all(|f| f.abs() < 1e-12));
            assert!(contact.nodes.iter().all(|n| n.gap > -1e-12));
        }
    }
}

/// A wedge whose faces enclose 53 degrees, drawn out: from a coefficient of 1/2 on friction could hold it, but nothing presses it in.
/// Pressed in it is held, also by what is left of a load; below 1/2 it is drawn out.
#[test]
fn a_body_that_two_rough_faces_jam_is_named_with_what_helps() {
    let solve = |friction: f64, course: &str| {
        let text = format!(
            r#"
analysis = "plane-strain"
[[body]]
name = "wedge"
material = {{ young = 1, poisson = 0.3 }}
load = [{{ side = "top", pressure = "{course}" }}]
[body.mesh.outline]
size = 0.15
from = [-0.2, 0]
edges = [
  {{ to = [0.2, 0] }},
  {{ to = [0.5, 0.6], name = "right", cells = 8 }},
  {{ to = [-0.5, 0.6], name = "top" }},
  {{ to = [-0.2, 0], name = "left", cells = 8 }},
]
[[contact]]
name = "left"
nonmortar = "wedge.left"
obstacle = {{ plane = {{ point = [-0.2, 0], normal = [2, 1] }} }}
friction = {friction}
[[contact]]
name = "right"
nonmortar = "wedge.right"
obstacle = {{ plane = {{ point = [0.2, 0], normal = [-2, 1] }} }}
friction = {friction}
[[step]]
time = 1
[[step]]
time = 2
"#
        );
        let case = Case::<2>::from_str(&text, "case.toml", Path::new(".")).unwrap();
        case.run(&[], &mut |_| {})
    };
    let told = |run: &dotyk::case::Run<2>| {
        let failure = run.failure.as_ref();
        failure.map_or(String::new(), |failure| failure.reason.clone())
    };
    let drawn = told(&solve(0.7, "-1e-3"));
    let jam = "body \"wedge\" stands between two rough faces, which jam it: with coefficients of 0.7 and 0.7";
    assert!(
        drawn.contains(jam) && drawn.contains("below a coefficient of 0.5 nothing jams"),
        "{drawn}"
    );
    assert!(told(&solve(0.45, "-1e-3")).contains("loss of equilibrium: body \"wedge\""));
    assert_eq!(told(&solve(0.7, "1e-3*(1.99 - 0.99*t)")), "");
}

/// An overlap pushes the corner off both faces: there N₁ − μN₂ and N₂ − μN₁ cannot both be positive from μ = 1 on.
#[test]
fn a_node_that_two_rough_faces_jam_is_named_with_what_helps() {
    let solve = |of_contact: &str| {
        let of_block = "points = { tip = [0, 0] }\nbody_force = [0.0, -1.0]";
        solve(&in_a_corner(
            of_block,
            &format!("gap = -0.001\n{of_contact}"),
        ))
    };
    let Err(Error::NotConverged { reason, .. }) = solve("friction = 1.2") else {
        panic!("there are no forces");
    };
    let told = reason.to_string();
    let jam = "node 0 at (0, 0) of body \"block\" lies on two rough faces, which jam it";
    assert!(
        told.contains(jam) && told.contains("use less than 1,"),
        "{told}"
    );
    for helps in ["friction = 0.99", "friction = 1.2\nexclude = [\"tip\"]"] {
        assert!(solve(helps).is_ok(), "{helps}");
    }
}

/// A loose block whose top presses a lid with the traction that acts there: it is carried without any strain, and work is compared with
/// that of the forces.
#[test]
fn work_without_strain_is_judged_beside_its_forces() {
    let gap = 0.003;
    let cell = "cell = \"quad9\"";
    let text = format!(
        "{PLANE}[[body]]\nname = \"a\"\n\
         mesh = {{ rectangle = {{ from = [0, 0], to = [1, 1], cells = [3, 2], {cell} }} }}\n\
         material = {{ young = 1000, poisson = 0 }}\nfix = [{{ side = \"left\", x = 0 }}]\n\
         load = [{{ side = \"top\", traction = [0, 1] }}]\n{}",
        obstacle(
            "lid",
            "a.top",
            &format!(
                "{{ plane = {{ point = [0, {}], normal = [0, -1] }} }}",
                1.0 + gap
            )
        )
    );
    let solution = solve(&text).unwrap();
    for u in &solution.bodies[0].displacement {
        assert!(u[0].abs() < 1e-14 && (u[1] - gap).abs() < 1e-14, "{u:?}");
    }
    for node in &solution.contacts[0].nodes {
        assert!((node.pressure - 1.0).abs() < 1e-12, "{node:?}");
    }
}

/// A support carries a load to and fro: where it is back no energy is left but rounding.
#[test]
fn supports_that_come_back_leave_no_energy() {
    let text = format!(
        "{PLANE}{}[[step]]\ntime = 0.5\n[[step]]\ntime = 1\n",
        block(
            "a",
            [0.0, 0.0],
            [1.0, 1.0],
            [2, 2],
            "fix = [{ side = \"bottom\", x = 0, y = 0 }, { side = \"top\", y = \"0.001*sin(pi*t)\" }]\n\
             load = [{ side = \"top\", traction = [0, -1] }]"
        )
    );
    let steps = case(&text).model.solve_steps().unwrap();
    assert!(steps[1].bodies[0].max_displacement() < 1e-18);
}

/// Rollers all around a tube of any cells leave its turn free: it is refused, where the errors of its mesh held it before.
#[test]
fn rollers_around_a_tube_do_not_hold_its_turn() {
    for cell in ["tet4", "tet10", "hex8", "hex20"] {
        let text = format!(
            "analysis = \"3d\"\n[[body]]\nname = \"tube\"\n\
             mesh = {{ cylinder = {{ base = [0, 0, 0], axis = [0, 0, 1], radius = 2, inner = 1, height = 1, cells = [12, 2, 1], cell = \"{cell}\" }} }}\n\
             material = {{ young = 1000, poisson = 0.3 }}\n\
             fix = [{{ side = [\"bottom\", \"top\"], normal = 0 }}, {{ side = \"outer\", normal = 0 }}]\n\
             load = [{{ side = \"inner\", traction = [\"-1e-4*y + x\", \"1e-4*x + y\", 0] }}]\n"
        );
        let case = Case::<3>::from_str(&text, "case.toml", Path::new(".")).unwrap();
        let mut model = case.model;
        let refused = |model: &Model<3>| {
            let error = model.solve().err().map(|error| error.to_string());
            let told = |error: &String| error.contains("rotation about z");
            assert!(error.as_ref().is_some_and(told), "{cell}: {error:?}");
        };
        refused(&model);
        // the same of a mesh that does not know its curve, and in halves that meet at nodes
        let body = &mut model.bodies[0];
        let mesh = (*body.mesh).clone().map_points(|point| point).unwrap();
        let outside = |x: f64, y: f64| (x.hypot(y) - 2.0).abs() < 1e-9;
        let mesh = mesh
            .with_side("east", |[x, y, _]| outside(x, y) && x > -1e-9)
            .with_side("west", |[x, y, _]| outside(x, y) && x < 1e-9);
        body.mesh = Arc::new(mesh);
        refused(&model);
        let whole = model.bodies[0].supports.pop().unwrap();
        for half in ["east", "west"] {
            let mut support = whole.clone();
            support.place = Place::Side(half.into());
            model.bodies[0].supports.push(support);
        }
        refused(&model);
    }
}

/// Two strips that share their nodes from x = 1 on; on [0, 1], a slit, the lower one has `cells[0]` edges and the upper one `cells[1]`.
fn slit(cells: [usize; 2]) -> Mesh<2> {
    let mut points = Vec::new();
    let mut columns: [Vec<[u32; 3]>; 2] = Default::default();
    for (strip, height) in [-1.0, 1.0].into_iter().enumerate() {
        let along = (0..cells[strip]).map(|i| i as f64 / cells[strip] as f64);
        for x in along.chain([1.0, 1.3, 2.0]) {
            let column = [0.0, 0.5, 1.0].map(|part| {
                let at = [x, part * height];
                let known = (x >= 1.0 && part == 0.0).then(|| points.iter().position(|p| *p == at));
                known.flatten().unwrap_or_else(|| {
                    points.push(at);
                    points.len() - 1
                }) as u32
            });
            columns[strip].push(column);
        }
    }
    let blocks = columns.iter().map(|columns| {
        let nodes = columns.windows(2).flat_map(|pair| {
            let quads = [0, 1].map(|i| [pair[0][i], pair[1][i], pair[1][i + 1], pair[0][i + 1]]);
            quads.concat()
        });
        CellBlock {
            kind: CellKind::Quad4,
            nodes: nodes.collect(),
            group: None,
        }
    });
    let mesh = Mesh::new(points, blocks.collect()).unwrap();
    let faces = |block: u32| {
        let on = |facet: &Facet| {
            facet.block == block
                && mesh
                    .facet_nodes(*facet)
                    .all(|n| mesh.points()[n as usize][1] == 0.0)
        };
        mesh.boundary_facets().into_iter().filter(on).collect()
    };
    let sides = BTreeMap::from([("lower".into(), faces(0)), ("upper".into(), faces(1))]);
    let mesh = mesh.with_sides(sides).unwrap();
    mesh.with_side("bottom", |[_, y]| y == -1.0)
        .with_side("top", |[_, y]| y == 1.0)
        .with_side("left", |[x, _]| x == 0.0)
}

/// A slit that is pressed evenly bears that pressure to its tip, whose node is on both faces; whatever their cells.
fn bears_to_its_tip<const D: usize>(
    mesh: Mesh<D>,
    right: f64,
    solve: impl Fn(&Model<D>) -> Result<Solution<D>, Error<D>>,
) {
    let mesh = Arc::new(mesh);
    for sides in [["lower", "upper"], ["upper", "lower"]] {
        for law in [Law::Frictionless, Law::Coulomb(0.3.into()), Law::Tied] {
            let along =
                |axis: usize, value: f64| std::array::from_fn(|i| (i == axis).then_some(value));
            let mut model = Model::new();
            let elastic = Elastic {
                young: 100.0,
                poisson: 0.3,
            };
            let body = model.body("a", mesh.clone(), elastic);
            model.fix(body, "bottom", along(1, 0.0));
            model.fix(body, "left", along(0, 0.0));
            if D == 3 {
                model.fix(body, "first", along(2, 0.0));
            }
            model.press(body, "top", 0.1);
            model.contact((body, sides[0]), (body, sides[1])).law = law.clone();
            let solution = solve(&model).unwrap();
            let nodes = &solution.contacts[0].nodes;
            let bearing: Vec<_> = nodes
                .iter()
                .filter(|node| node.pressure.abs() > 1e-12)
                .collect();
            for node in &bearing {
                assert!(
                    (node.pressure - 0.1).abs() < 1e-10,
                    "{sides:?} {law:?}: {node:?}"
                );
            }
            assert!(
                bearing.len() >= D - 1,
                "{sides:?} {law:?}: {}",
                bearing.len()
            );
            let force = solution.contacts[0].resultant[1].abs();
            assert!((force - right).abs() < 1e-10, "{sides:?} {law:?}: {force}");
        }
    }
}

/// What lies behind a closed slit is no partner of the far side of the body.
#[test]
fn the_far_side_of_a_body_does_not_face_a_slit_in_it() {
    let mesh = slit([4, 4]);
    let both = ["lower", "bottom"].map(|side| mesh.side(side).unwrap());
    let both = BTreeMap::from([("both".to_string(), both.concat())]);
    let mesh = Arc::new(mesh.with_sides(both).unwrap());
    let pressures = ["lower", "both"].map(|side| {
        let mut model = Model::new();
        let elastic = Elastic {
            young: 100.0,
            poisson: 0.3,
        };
        let body = model.body("a", mesh.clone(), elastic);
        model.fix(body, "left", [Some(0.0), None]);
        model.pin(body, [2.0, -1.0], [None, Some(0.0)]);
        model.press(body, "top", 0.1);
        model.press(body, "bottom", 0.1);
        model.contact((body, side), (body, "upper"));
        let solution = model.solve().unwrap();
        let nodes = &solution.contacts[0].nodes;
        nodes
            .iter()
            .fold(0.0f64, |most, node| most.max(node.pressure))
    });
    assert!((pressures[0] - 0.1).abs() < 1e-9, "{pressures:?}");
    assert!((pressures[1] - pressures[0]).abs() < 1e-9, "{pressures:?}");
}

/// Two tied blocks on rollers in x and y, drawn turned about z, the lower one held at the edges of its tied side.
fn tied_blocks(turned: f64, traction: [f64; 2], [own, other]: [usize; 2]) -> [f64; 3] {
    let turn = |[x, y, z]: [f64; 3]| {
        let (sin, cos) = turned.sin_cos();
        [x * cos - y * sin, x * sin + y * cos, z]
    };
    let block = |from: f64, cells: usize| {
        let cuboid = Cuboid {
            from: [0.0, 0.0, from],
            to: [2.0, 2.0, from + 1.0],
            cells: [cells, cells, 2],
            cell: CellKind::Hex8,
        };
        cuboid.build().unwrap().map_points(turn).unwrap()
    };
    let elastic = |young: f64| Elastic {
        young,
        poisson: 0.3,
    };
    let mut model = Model::new();
    let lower = model.body("lower", block(0.0, own), elastic(1000.0));
    let upper = model.body("upper", block(1.0, other), elastic(3000.0));
    model.fix(lower, "bottom", [None, None, Some(0.0)]);
    model.roller(lower, "left", 0.0);
    model.roller(lower, "front", 0.0);
    let [x, y] = traction;
    model.pull(upper, "top", turn([x, y, -1.0]));
    model.contact((lower, "top"), (upper, "bottom")).law = Law::Tied;
    let solution = model.solve().unwrap();
    let displacement = &solution.bodies[1].displacement;
    // of the corner that no axis is near
    let [x, y, z] = *displacement.last().unwrap();
    let (sin, cos) = turned.sin_cos();
    [x * cos + y * sin, y * cos - x * sin, z]
}

/// The blocks are alike in x and y.
#[test]
fn a_tie_beside_held_edges_does_not_know_the_axes() {
    // nodes that lie on each other are held by pairs
    let right = tied_blocks(0.0, [0.3, 0.2], [4, 4]);
    for cells in [[3, 4], [4, 3], [3, 6], [6, 3], [8, 3]] {
        let [x, y, z] = tied_blocks(0.0, [0.3, 0.2], cells);
        // where the other side's facets are larger it may part from the edge between its nodes
        for (found, right) in [x, y, z].iter().zip(right) {
            let off = (found / right - 1.0).abs();
            assert!(
                cells[1] < cells[0] || off < 0.03,
                "{cells:?}: {found} {right}"
            );
        }
        for (found, what) in [
            (tied_blocks(0.0, [0.2, 0.3], cells), [y, x, z]),
            (tied_blocks(0.5, [0.3, 0.2], cells), [x, y, z]),
            (tied_blocks(2.0, [0.2, 0.3], cells), [y, x, z]),
        ] {
            for (found, right) in found.iter().zip(what) {
                assert!((found - right).abs() < 1e-9, "{cells:?}: {found} {right}");
            }
        }
    }
}

/// Two tied blocks between the same rollers, turned: their supports agree, though each is the sum of parts of which some are rounding.
#[test]
fn ties_on_the_same_turned_rollers_agree() {
    for turned in [0.1, 0.3, 0.7, 1.3, 2.2, 2.9] {
        let turn = |[x, y]: [f64; 2]| {
            let (sin, cos) = f64::sin_cos(turned);
            [x * cos - y * sin, x * sin + y * cos]
        };
        let block = |from: f64, cells: usize| {
            let rectangle = Rectangle {
                from: [from, 0.0],
                to: [from + 1.0, 1.0],
                cells: [1, cells],
                cell: CellKind::Quad4,
                diagonals: Diagonals::default(),
            };
            rectangle.build().unwrap().map_points(turn).unwrap()
        };
        let elastic = Elastic {
            young: 1000.0,
            poisson: 0.3,
        };
        let mut model = Model::new();
        let bodies = [("a", 0.0, 1), ("b", 1.0, 2)].map(|(name, from, cells)| {
            let body = model.body(name, block(from, cells), elastic);
            model.roller(body, "bottom", -0.01);
            model.roller(body, "top", 0.0);
            body
        });
        model.roller(bodies[0], "left", 0.0);
        model.contact((bodies[0], "right"), (bodies[1], "left")).law = Law::Tied;
        let solution = model
            .solve()
            .unwrap_or_else(|error| panic!("{turned}: {error}"));
        assert!(solution.certificate.penetration.value < 1e-12);
    }
}

/// A gasket between hexahedra of 20 nodes, whose middle nodes carry no multipliers, may close there, too.
#[test]
fn a_gasket_closes_between_the_corners_of_facets() {
    for cell in ["hex8", "hex20", "hex27", "tet10"] {
        let block = |name: &str, from: f64, extra: &str| {
            format!(
                "[[body]]\nname = \"{name}\"\nmesh = {{ box = {{ from = [0, 0, {from}], to = [4, 0.5, {}], cells = [4, 1, 1], cell = \"{cell}\" }} }}\n\
                 material = {{ young = 1e4, poisson = 0.3 }}\n{extra}\n",
                from + 1.0
            )
        };
        let text = format!(
            "analysis = \"3d\"\n{}{}[[contact]]\nname = \"c\"\nnonmortar = \"up.bottom\"\nmortar = \"lo.top\"\n\
             gasket = {{ closure = [0, 0.002], pressure = [0, 1] }}\n",
            block(
                "lo",
                0.0,
                "fix = [{ side = \"bottom\", x = 0, y = 0, z = 0 }]"
            ),
            block(
                "up",
                1.0,
                "fix = [{ side = \"left\", x = 0 }, { side = \"front\", y = 0 }]\nload = [{ side = \"top\", pressure = 1 }]"
            ),
        );
        let case = Case::<3>::from_str(&text, "case.toml", Path::new(".")).unwrap();
        let solution = case
            .model
            .solve()
            .unwrap_or_else(|error| panic!("{cell}: {error}"));
        assert!(solution.certificate.overlap.relative <= 1.0, "{cell}");
        assert!(
            (solution.contacts[0].resultant[2] - 2.0).abs() < 1e-9,
            "{cell}"
        );
    }
}

#[test]
fn a_slit_bears_to_its_tip() {
    for cells in [[4, 4], [4, 3], [3, 5], [1, 3]] {
        // nodes that lie on each other bear their own part: the half edge of the tip is the body's
        let right = if cells == [4, 4] { 0.0875 } else { 0.1 };
        bears_to_its_tip(slit(cells), right, Model::<2>::solve);
        let extrude = Extrude {
            mesh: slit(cells),
            path: Along::Straight(1.0),
            offset: 0.0,
            layers: 3,
        };
        bears_to_its_tip(extrude.build().unwrap(), right, Model::<3>::solve);
    }
}

/// Rollers in the bore of a shaft that a hub presses without friction: nothing drives its turn.
#[test]
fn a_shaft_on_rollers_in_a_smooth_hub_stays() {
    let shaft = |drag: &str| {
        format!(
            "{PLANE}[[body]]\nname = \"hub\"\n\
             mesh = {{ ring = {{ inner = 2, outer = 3, cells = [20, 2], cell = \"quad9\" }} }}\n\
             material = {{ young = 1000, poisson = 0.3 }}\nfix = [{{ side = \"outer\", x = 0, y = 0 }}]\n\
             [[body]]\nname = \"shaft\"\n\
             mesh = {{ ring = {{ inner = 1, outer = 2.001, cells = [16, 2], cell = \"quad9\" }} }}\n\
             material = {{ young = 1000, poisson = 0.3 }}\nfix = [{{ side = \"inner\", normal = 0 }}]\n\
             load = [{{ side = \"inner\", traction = [\"-{drag}*y\", \"{drag}*x\"] }}]\n{}",
            contact("c", "nonmortar = \"shaft.outer\"\nmortar = \"hub.inner\"")
        )
    };
    let solution = solve(&shaft("0")).unwrap();
    assert!(solution.warnings.iter().any(|w| w.contains("least norm")));
    let pressures = solution.contacts[0].nodes.iter().map(|node| node.pressure);
    let mean = pressures.clone().sum::<f64>() / pressures.clone().count() as f64;
    // with friction nothing turns, and the pressure is the same
    let held = solve(&format!("{}friction = 0.2\n", shaft("0"))).unwrap();
    for (node, free) in held.contacts[0].nodes.iter().zip(pressures) {
        assert!(
            (node.pressure - free).abs() < 0.02 * mean,
            "{} {free}",
            node.pressure
        );
    }
    let driven = solve(&shaft("1e-4")).unwrap_err().to_string();
    assert!(driven.contains("not held"), "{driven}");
}

/// Supports hold the corners of a facet on both tied sides: nothing ties what lies between them, and that is told.
#[test]
fn a_tie_that_supports_leave_without_a_condition_is_told() {
    let cubes = |cell: &str, own: usize, other: usize| {
        let field = "x = \"1e-3*z\", y = \"1e-3*x\", z = \"-1e-3*z + 1e-3*y\"";
        let cube = |name: &str, from: f64, cells: usize, end: &str| {
            format!(
                "[[body]]\nname = \"{name}\"\n\
                 mesh = {{ box = {{ from = [0, 0, {from}], to = [1, 1, {}], cells = [{cells}, {cells}, 1], cell = \"{cell}\" }} }}\n\
                 material = {{ young = 1000, poisson = 0.3 }}\n\
                 fix = [{{ side = [\"{end}\", \"left\", \"right\", \"front\", \"back\"], {field} }}]\n",
                from + 1.0
            )
        };
        let text = format!(
            "analysis = \"3d\"\n{}{}{}",
            cube("low", -1.0, other, "bottom"),
            cube("up", 0.0, own, "top"),
            contact(
                "c",
                "nonmortar = \"up.bottom\"\nmortar = \"low.top\"\ntied = true"
            )
        );
        let case = Case::<3>::from_str(&text, "case.toml", Path::new(".")).unwrap();
        let solution = case.model.solve().unwrap();
        let told = |w: &&String| w.contains("although they are tied");
        solution.warnings.iter().any(|w| told(&w))
    };
    assert!(cubes("tet10", 2, 2) && cubes("hex8", 1, 2));
    assert!(!cubes("hex8", 2, 2) && !cubes("hex20", 2, 2) && !cubes("hex27", 3, 2));
}

/// A punch far above a block, pressed ever more softly: it is carried a length and strained by q/E. Where rounding of its motion hides the
/// forces there is no answer, instead of a wrong one.
#[test]
fn forces_that_rounding_of_a_motion_hides_are_not_certified() {
    let pressures = |gap: f64, load: f64| {
        let top = |y: f64| y + gap;
        let text = format!(
            "{PLANE}{}{}{}",
            block(
                "base",
                [0.0, 0.0],
                [3.0, 1.0],
                [12, 4],
                "fix = [{ side = \"bottom\", x = 0, y = 0 }]"
            ),
            block(
                "punch",
                [1.0, top(1.0)],
                [2.0, top(2.0)],
                [5, 4],
                &format!(
                    "load = [{{ side = \"top\", traction = [0, {}] }}]\nfix = [{{ side = \"left\", x = 0 }}]",
                    -load
                )
            ),
            contact(
                "sole",
                "nonmortar = \"punch.bottom\"\nmortar = \"base.top\""
            )
        );
        let solution = solve(&text).ok()?;
        let nodes = solution.contacts[0].nodes.iter();
        Some(nodes.map(|node| node.pressure / load).collect::<Vec<f64>>())
    };
    let touching = pressures(0.0, 1.0).unwrap();
    let mut answered = 0;
    for load in [1.0, 1e-3, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9, 1e-10, 1e-11, 1e-12] {
        let Some(found) = pressures(1.0, load) else {
            continue;
        };
        answered += 1;
        for (a, b) in found.iter().zip(&touching) {
            assert!((a - b).abs() < 1e-5, "{load}: {a} {b}");
        }
    }
    assert!(answered >= 3, "{answered}");
}
