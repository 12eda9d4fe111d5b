//! What moves until it stands in something else is no answer, whoever named a contact between the two; what loses equilibrium is
//! named, with how much of the load is held; and results with a sign are told for the side that is named first.

use crate::friction::Random;
use dotyk::case::{AnyCase, Case};
use dotyk::model::{Error, Intrusion, Objection, Solution};
use std::path::Path;

type Answer<const D: usize> = Result<Solution<D>, Box<Objection<D>>>;

fn asked<const D: usize>(answer: Result<Solution<D>, Error<D>>) -> Answer<D> {
    match answer {
        Ok(solution) => Ok(solution),
        Err(Error::NotConverged { reason, .. }) => Err(reason),
        Err(error) => panic!("{error}"),
    }
}

fn solve(text: &str) -> Answer<2> {
    let case = Case::<2>::from_str(text, "case.toml", Path::new("."));
    asked(case.unwrap().model.solve())
}

fn solve_in_space(text: &str) -> Answer<3> {
    let case = Case::<3>::from_str(text, "case.toml", Path::new("."));
    asked(case.unwrap().model.solve())
}

/// What stands in what, where an answer is refused for that and nothing else.
fn stands<const D: usize>(answer: Answer<D>) -> Intrusion<D> {
    match answer.map_err(|reason| *reason) {
        Err(Objection::Violated {
            certificate,
            open: None,
            glued: false,
            overlap: None,
            intrusion: Some(found),
        }) => {
            let violated = certificate.figures().into_iter();
            let violated: Vec<_> = violated.filter(|(_, figure)| !figure.holds()).collect();
            assert_eq!(violated.len(), 1, "{certificate}");
            assert_eq!(violated[0].0, "overlap");
            *found
        }
        Err(other) => panic!("{other}"),
        Ok(solution) => panic!("certified:\n{}", solution.certificate),
    }
}

/// A block that is moved along a table, which rises to a ramp ahead of it.
fn ramp(travel: f64, contact: &str) -> String {
    format!(
        r#"
analysis = "plane-strain"
[[body]]
name = "table"
mesh = {{ outline = {{ size = 1, cell = "tri6", from = [-10, -5], edges = [{{ to = [40, -5], name = "bottom" }}, {{ to = [40, 1] }}, {{ to = [15, 1], name = "ramp" }}, {{ to = [12, 0], name = "ramp" }}, {{ to = [-10, 0], name = "top" }}, {{ to = [-10, -5] }}] }} }}
material = {{ young = 210e3, poisson = 0.3 }}
fix = [{{ side = "bottom", x = 0, y = 0 }}]
[[body]]
name = "block"
mesh = {{ rectangle = {{ from = [0, 0.1], to = [10, 5], cells = [10, 5], cell = "quad8" }} }}
material = {{ young = 210e3, poisson = 0.3 }}
fix = [{{ side = "top", x = {travel}, y = 0 }}]
{contact}
"#
    )
}

const SOLE: &str = r#"
[[contact]]
name = "sole"
nonmortar = "block.bottom"
"#;

#[test]
fn a_block_does_not_travel_through_a_ramp() {
    let named = format!("{SOLE}mortar = [\"table.top\", \"table.ramp\"]\n");
    let beside = format!("{SOLE}mortar = \"table.top\"\n");
    // the ramp is on the contact's side, is on none, and no contact is named at all
    for (contact, has_contact) in [(&named, true), (&beside, true), (&String::new(), false)] {
        let found = stands(solve(&ramp(10.0, contact)));
        // 0.1 above the table, in what is 1 above it; the nearest surface is the top or the slope
        assert!((0.8..=0.9 + 1e-9).contains(&found.depth), "{found:?}");
        assert_eq!(
            (found.body.as_str(), found.other.as_str()),
            ("block", "table")
        );
        assert_eq!(found.named, has_contact);
        // up to the ramp it stands in nothing
        let before = solve(&ramp(2.2, contact)).unwrap();
        assert_eq!(
            (before.overlap, before.certificate.overlap.value),
            (None, 0.0)
        );
        // and just in it: the slope of 1 in 3 is 0.2 above the table at 12.6
        let found = stands(solve(&ramp(2.6, contact)));
        assert!((found.depth - 0.3 / 10f64.sqrt()).abs() < 1e-9, "{found:?}");
    }
}

/// Two blocks, one above the other; the upper one is moved down.
fn two(space: bool, down: f64, shift: f64) -> String {
    let (analysis, low, high, z) = match space {
        false => (
            "plane-strain",
            "rectangle = { from = [0, 0], to = [2, 1], cells = [4, 2]".to_string(),
            "rectangle = { from = [0.5, 1.25], to = [1.5, 2], cells = [2, 2]".to_string(),
            "",
        ),
        true => (
            "3d",
            "box = { from = [0, 0, 0], to = [2, 1, 2], cells = [4, 2, 4]".to_string(),
            "box = { from = [0.5, 1.25, 0.5], to = [1.5, 2, 1.5], cells = [2, 2, 2]".to_string(),
            ", z = 0",
        ),
    };
    format!(
        r#"
analysis = "{analysis}"
[[body]]
name = "low"
mesh = {{ {low} }} }}
material = {{ young = 1e5, poisson = 0.3 }}
fix = [{{ side = "{}", x = {shift}, y = {shift}{z} }}]
[[body]]
name = "high"
mesh = {{ {high} }} }}
material = {{ young = 1e5, poisson = 0.3 }}
fix = [{{ side = "{}", x = {shift}, y = "{shift} - {down}"{z} }}]
"#,
        if space { "front" } else { "bottom" },
        if space { "back" } else { "top" },
    )
}

#[test]
fn bodies_between_which_nobody_named_a_contact_stand_in_each_other() {
    fn check<const D: usize>(found: Intrusion<D>) {
        assert!((found.depth - 0.1).abs() < 1e-12, "{found:?}");
        let mut names = [&found.body[..], &found.other[..]];
        names.sort_unstable();
        assert_eq!((names, found.named), (["high", "low"], false));
    }
    for shift in [0.0, 100.0] {
        check(stands(solve(&two(false, 0.35, shift))));
        check(stands(solve_in_space(&two(true, 0.35, shift))));
        assert!(solve(&two(false, 0.2, shift)).is_ok());
        assert!(solve_in_space(&two(true, 0.2, shift)).is_ok());
    }
    let refused = solve(&two(false, 0.35, 0.0)).unwrap_err().to_string();
    for word in [
        "stands 0.1 deep",
        "\"high\"",
        "\"low\"",
        "no contact is named",
    ] {
        assert!(refused.contains(word), "{refused}");
    }
}

/// What is drawn in each other and stays so is what was drawn.
#[test]
fn an_overlap_that_was_drawn_is_none() {
    let drawn = two(false, 0.0, 0.0).replace("1.25", "0.9");
    assert!(solve(&drawn).is_ok());
    let moved = |down: f64| solve(&two(false, down, 0.0).replace("1.25", "0.9"));
    // what moves less than it was drawn deep
    assert!(moved(0.05).is_ok());
    let found = stands(moved(0.2));
    assert!((found.depth - 0.2).abs() < 1e-12, "{found:?}");
}

/// Four squares around a point, with contacts between neighbours; without the lower upright joint two stand side by side.
fn around_a_point(cells: usize, joint: bool) -> String {
    let square = |i: usize, j: usize| {
        let young = if i == j { 1e4 } else { 1e3 };
        let held = match (i, j) {
            (_, 0) => "fix = [{ side = \"bottom\", x = 0, y = 0 }]".to_string(),
            (0, _) => {
                "fix = [{ side = \"left\", x = 0 }]\nload = [{ side = \"top\", pressure = 1 }]"
                    .to_string()
            }
            _ => "load = [{ side = \"top\", pressure = 4 }, { side = \"right\", pressure = 1 }]"
                .to_string(),
        };
        format!(
            "[[body]]\nname = \"q{i}{j}\"\nmesh = {{ rectangle = {{ from = [{i}, {j}], to = [{}, {}], cells = [{cells}, {cells}] }} }}\nmaterial = {{ young = {young}, poisson = 0.3 }}\n{held}\n",
            i + 1,
            j + 1
        )
    };
    let touch = |name: &str, nonmortar: &str, mortar: &str| {
        format!(
            "[[contact]]\nname = \"{name}\"\nnonmortar = \"{nonmortar}\"\nmortar = \"{mortar}\"\n"
        )
    };
    let mut text = "analysis = \"plane-strain\"\n".to_string();
    for (i, j) in [(0, 0), (1, 0), (0, 1), (1, 1)] {
        text += &square(i, j);
    }
    text += &touch("h0", "q01.bottom", "q00.top");
    text += &touch("h1", "q11.bottom", "q10.top");
    text += &touch("v1", "q11.left", "q01.right");
    if joint {
        text += &touch("v0", "q10.left", "q00.right");
    }
    text
}

/// Bodies that meet at an edge alone have no sides there that a contact could name; those that lie side by side have, with one
/// cell along them, too.
#[test]
fn only_what_lies_side_by_side_needs_a_contact() {
    for cells in [1, 2, 5] {
        assert!(solve(&around_a_point(cells, true)).is_ok(), "{cells}");
        let found = stands(solve(&around_a_point(cells, false)));
        let mut names = [&found.body[..], &found.other[..]];
        names.sort_unstable();
        assert_eq!((names, found.named), (["q00", "q10"], false), "{cells}");
    }
}

/// The parts of the outline of a rectangle with `n` cells.
fn outline([from, to]: [[f64; 2]; 2], n: [usize; 2]) -> Vec<[[f64; 2]; 2]> {
    let at = |d: usize, k: usize| from[d] + (to[d] - from[d]) * k as f64 / n[d] as f64;
    let flat = [from[1], to[1]]
        .into_iter()
        .flat_map(|y| (0..n[0]).map(move |k| [[at(0, k), y], [at(0, k + 1), y]]));
    let upright = [from[0], to[0]]
        .into_iter()
        .flat_map(|x| (0..n[1]).map(move |k| [[x, at(1, k)], [x, at(1, k + 1)]]));
    flat.chain(upright).collect()
}

/// How deep a point is in a rectangle.
fn depth(p: [f64; 2], [from, to]: [[f64; 2]; 2]) -> f64 {
    let of_axis = |d: usize| (p[d] - from[d]).min(to[d] - p[d]);
    of_axis(0).min(of_axis(1))
}

/// Where a part of an outline is deepest in a rectangle: at its ends, or half way through where it goes right through.
fn deepest(part: [[f64; 2]; 2], into: [[f64; 2]; 2]) -> f64 {
    let ends = depth(part[0], into).max(depth(part[1], into));
    let through = (0..2).filter(|&d| part[0][d] < into[0][d] && into[1][d] < part[1][d]);
    let half = through.map(|d| {
        let mut p = part[0];
        p[d] = 0.5 * (into[0][d] + into[1][d]);
        depth(p, into)
    });
    half.fold(ends, f64::max)
}

/// Four boxes around an edge, with contacts between neighbours and meshes that do not match: the edges of those across from each
/// other cut each other's corners wherever their nodes are.
#[test]
fn boxes_that_meet_at_an_edge_need_no_contact() {
    let mut random = Random(1);
    let mut random = |low: f64, high: f64| low + (high - low) * random.unit();
    for round in 0..12 {
        let mut text = "analysis = \"3d\"\n".to_string();
        for (k, [x, y]) in [[-1, -1], [0, -1], [-1, 0], [0, 0]].into_iter().enumerate() {
            let cells = [0; 3].map(|_| random(1.0, 4.0) as usize);
            let young = [100, 1000][random(0.0, 2.0) as usize];
            let along = |from: i32, sides: [&str; 2], axis: &str, by: f64| match from {
                0 => format!("{{ side = \"{}\", {axis} = {by} }}", sides[1]),
                _ => format!("{{ side = \"{}\", {axis} = 0 }}", sides[0]),
            };
            let [by_x, by_y] = [0; 2].map(|_| -random(0.001, 0.003));
            text += &format!(
                "[[body]]\nname = \"b{k}\"\nmesh = {{ box = {{ from = [{x}, {y}, 0], to = [{}, {}, 1], cells = {cells:?} }} }}\nmaterial = {{ young = {young}, poisson = 0.3 }}\nfix = [{}, {}, {{ side = \"bottom\", z = 0 }}]\n",
                x + 1,
                y + 1,
                along(x, ["left", "right"], "x", by_x),
                along(y, ["front", "back"], "y", by_y),
            );
        }
        for (name, first, second) in [
            ("low", "b0.right", "b1.left"),
            ("high", "b2.right", "b3.left"),
            ("west", "b0.back", "b2.front"),
            ("east", "b1.back", "b3.front"),
        ] {
            text +=
                &format!("[[contact]]\nname = \"{name}\"\nsides = [\"{first}\", \"{second}\"]\n");
        }
        if let Err(refused) = solve_in_space(&text) {
            panic!("{round}: {refused}\n{text}");
        }
    }
}

#[test]
fn rectangles_are_as_deep_as_their_outlines_say() {
    let mut random = Random(2);
    let mut between = |low: f64, high: f64| low + (high - low) * random.unit();
    let (mut through, mut deep, mut free) = (0, 0, 0);
    for round in 0..300 {
        let [mut w, h, b, mut t] = [0; 4].map(|_| between(0.2, 2.0));
        if round % 2 == 1 {
            // a post and a beam
            (w, t) = (0.3 * w, 0.3 * t);
        }
        let mut n = [0; 4].map(|_| between(1.0, 5.0) as usize);
        if round % 4 == 1 {
            // with no node where they cross
            (n[1], n[2]) = (1, 1);
        }
        let (x, y) = (between(-b, w), h + between(0.0, 0.5));
        let [u, v] = [between(-0.5, 0.5), -between(0.0, 2.0)];
        let low = [[0.0, 0.0], [w, h]];
        let high = [[x + u, y + v], [x + b + u, y + t + v]];
        let parts = outline(low, [n[0], n[1]])
            .into_iter()
            .map(|part| (part, high));
        let others = outline(high, [n[2], n[3]])
            .into_iter()
            .map(|part| (part, low));
        let parts: Vec<_> = parts.chain(others).collect();
        let most = parts.iter().map(|&(part, into)| deepest(part, into));
        let most = most.fold(0.0, f64::max);
        let mut ends = parts
            .iter()
            .flat_map(|&(part, into)| part.map(|p| depth(p, into)));
        through += usize::from(most > 1e-9 && ends.all(|depth| depth < 0.0));
        let moved = ["left", "right", "top", "bottom"]
            .map(|side| format!("{{ side = \"{side}\", x = {u}, y = {v} }}"));
        let text = format!(
            "analysis = \"plane-strain\"\n[[body]]\nname = \"low\"\nmesh = {{ rectangle = {{ from = [0, 0], to = [{w}, {h}], cells = [{}, {}] }} }}\nmaterial = {{ young = 1e3, poisson = 0.3 }}\nfix = [{{ side = \"bottom\", x = 0, y = 0 }}]\n[[body]]\nname = \"high\"\nmesh = {{ rectangle = {{ from = [{x}, {y}], to = [{}, {}], cells = [{}, {}] }} }}\nmaterial = {{ young = 1e3, poisson = 0.3 }}\nfix = [{}]\n",
            n[0],
            n[1],
            x + b,
            y + t,
            n[2],
            n[3],
            moved.join(", ")
        );
        // the height of what overlaps, told by the rectangles alone
        let overlap = (0..2).map(|d| low[1][d].min(high[1][d]) - low[0][d].max(high[0][d]));
        let overlap = overlap.fold(f64::INFINITY, f64::min);
        assert_eq!(most > 1e-9, overlap > 1e-9, "{text}");
        if most > 1e-9 {
            let found = stands(solve(&text));
            assert!((found.depth - most).abs() < 1e-9, "{most} {found:?}");
            deep += 1;
        } else {
            assert!(solve(&text).is_ok(), "{text}");
            free += 1;
        }
    }
    assert!(
        through > 10 && deep > 50 && free > 20,
        "{through} {deep} {free}"
    );
}

/// A block over a floor that is 0.5 lower than it is drawn, and a post beside it that stands where it is drawn.
#[test]
fn a_given_clearance_is_one_of_its_sides() {
    let moved = |x: f64, y: f64| {
        format!(
            r#"
analysis = "plane-strain"
[[body]]
name = "a"
mesh = {{ outline = {{ size = 0.5, from = [0, 0], edges = [{{ to = [4, 0], name = "bottom" }}, {{ to = [4, 3], name = "r" }}, {{ to = [3, 3], name = "pt" }}, {{ to = [3, 1], name = "post" }}, {{ to = [0, 1], name = "floor" }}, {{ to = [0, 0], name = "l" }}] }} }}
material = {{ young = 1e6, poisson = 0.3 }}
fix = [{{ side = "bottom", x = 0, y = 0 }}]
[[body]]
name = "b"
mesh = {{ rectangle = {{ from = [1, 1.2], to = [2.8, 2], cells = [4, 4] }} }}
material = {{ young = 1e6, poisson = 0.3 }}
fix = [{{ side = "top", x = {x}, y = {y} }}]
[[contact]]
name = "c"
nonmortar = "b.bottom"
mortar = "a.floor"
gap = 0.7
"#
        )
    };
    // down to where the floor is, whose sides alone have the clearance: the edge of the block goes with it
    assert!(solve(&moved(0.0, -0.6)).is_ok());
    assert!(solve(&moved(0.1, -0.6)).is_ok());
    for down in [0.0, -0.1] {
        let found = stands(solve(&moved(0.6, down)));
        assert!((found.depth - 0.4).abs() < 1e-6, "{found:?}");
    }
}

#[test]
fn a_beam_does_not_pass_through_a_post() {
    // a post of one cell across, and a beam of one cell, whose nodes are all outside of each other in the end
    let body = |name: &str, box_of: &str, fix: &str| {
        format!(
            "[[body]]\nname = \"{name}\"\nmesh = {{ {box_of} }}\nmaterial = {{ young = 1e3, poisson = 0.3 }}\nfix = [{fix}]\n"
        )
    };
    let post = body(
        "post",
        "box = { from = [-0.3, -0.4, -2], to = [0.3, 0.4, 2], cells = [1, 1, 1] }",
        "{ side = \"bottom\", x = 0, y = 0, z = 0 }",
    );
    let all =
        ["left", "right"].map(|side| format!("{{ side = \"{side}\", x = 0, y = TRAVEL, z = 0 }}"));
    for (travel, stands_in) in [(1.0, None), (2.0, Some(0.1))] {
        let beam = body(
            "beam",
            "box = { from = [-2, -2.2, -0.11], to = [2, -1.8, 0.13], cells = [1, 1, 1], cell = \"tet4\" }",
            &all.join(", ").replace("TRAVEL", &travel.to_string()),
        );
        let answer = solve_in_space(&format!("analysis = \"3d\"\n{post}{beam}"));
        match stands_in {
            None => assert!(answer.is_ok()),
            Some(least) => {
                let found = stands(answer);
                assert!(found.depth > least && found.depth <= 0.3, "{found:?}");
            }
        }
    }
}

/// A force that a study reads keeps its sign, whichever side dotyk lets carry the multipliers.
#[test]
fn a_resultant_is_that_on_the_side_that_is_named_first() {
    let text = |cells: usize, sides: &str| {
        format!(
            r#"
analysis = "plane-strain"
[[body]]
name = "lower"
mesh = {{ rectangle = {{ from = [-1, -1], to = [2, 0], cells = [12, 4] }} }}
material = {{ young = 2e5, poisson = 0.3 }}
fix = [{{ side = "bottom", x = 0, y = 0 }}]
[[body]]
name = "upper"
mesh = {{ rectangle = {{ from = [0, 0], to = [1, 1], cells = [{cells}, {cells}] }} }}
material = {{ young = 2e5, poisson = 0.3 }}
load = [{{ side = "top", force = [30, -100] }}]
[[contact]]
name = "c"
friction = 0.9
sides = {sides}
[[probe]]
name = "force"
quantity = "c.resultant.y"
[[probe]]
name = "shear"
quantity = "c.shear.x"
reduce = "mean"
"#
        )
    };
    let mut carried = Vec::new();
    for cells in [2, 8] {
        for (sides, sign) in [
            ("[\"upper.bottom\", \"lower.top\"]", 1.0),
            ("[\"lower.top\", \"upper.bottom\"]", -1.0),
        ] {
            let solution = solve(&text(cells, sides)).unwrap();
            let contact = &solution.contacts[0];
            assert!((solution.probes[0].value - sign * 100.0).abs() < 1e-8);
            assert!((contact.resultant[0] + sign * 30.0).abs() < 1e-8);
            assert!(
                sign * solution.probes[1].value < 0.0,
                "{}",
                solution.probes[1].value
            );
            carried.push(contact.nonmortar.side.clone());
        }
    }
    // both sides carry them at some time
    assert!(carried.contains(&"top".to_string()) && carried.contains(&"bottom".to_string()));
}

/// Three boxes on an incline of 1 in 2, of which the middle joint is the weakest.
#[test]
fn a_stack_slides_where_it_is_weakest() {
    let boxes: String = (0..3)
        .map(|k| {
            format!(
                "[[body]]\nname = \"b{k}\"\nmesh = {{ rectangle = {{ from = [0, {k}], to = [2, {}], cells = [4, 2] }} }}\nmaterial = {{ young = 1e5, poisson = 0.2 }}\nbody_force = [1, -2]\n",
                k + 1
            )
        })
        .collect();
    let stack = |weak: f64| {
        format!(
            r#"
analysis = "plane-strain"
{boxes}
[[contact]]
name = "j0"
nonmortar = "b0.bottom"
friction = 0.8
obstacle = {{ plane = {{ point = [0, 0], normal = [0, 1] }} }}
[[contact]]
name = "j1"
nonmortar = "b1.bottom"
mortar = "b0.top"
friction = {weak}
[[contact]]
name = "j2"
nonmortar = "b2.bottom"
mortar = "b1.top"
friction = 0.8
"#
        )
    };
    assert!(solve(&stack(0.55)).is_ok());
    let refused = *solve(&stack(0.4)).unwrap_err();
    let Objection::Slides {
        bodies, held, by, ..
    } = &refused
    else {
        panic!("{refused}");
    };
    let mut bodies = bodies.clone();
    bodies.sort();
    assert_eq!(bodies, ["b1", "b2"]);
    assert_eq!(*by, Some("friction"));
    // μ times the weight over the thrust
    assert!((held - 0.8).abs() < 1e-6, "{held}");
}

/// A block that leans over its edge tips. What it stands on holds it until then; of a load that only scales, nothing is held.
#[test]
fn what_tips_is_told_with_the_part_that_is_held() {
    let leaning = r#"
analysis = "plane-strain"
[[body]]
name = "tower"
mesh = { rectangle = { from = [0, 0], to = [1, 3], cells = [2, 6] } }
material = { young = 1e5, poisson = 0.2 }
body_force = ["THRUST", -1]
[[contact]]
name = "foot"
nonmortar = "tower.bottom"
friction = 2
obstacle = { plane = { point = [0, 0], normal = [0, 1] } }
"#;
    // tips about its edge where the thrust is a third of the weight
    let of = |thrust: &str| leaning.replace("THRUST", thrust);
    assert!(solve(&of("0.3")).is_ok());
    let case = Case::<2>::from_str(&of("0.4"), "case.toml", Path::new("."));
    match case.unwrap().model.solve() {
        Err(Error::PulledAway { body, motion, .. }) => {
            assert_eq!((&body[..], &motion[..]), ("tower", "rotation about (1, 0)"));
        }
        other => panic!("{}", other.is_ok()),
    }
    let steps = of("0.2*t") + "[[step]]\ntime = 1\n[[step]]\ntime = 2\n";
    let case = Case::<2>::from_str(&steps, "case.toml", Path::new("."));
    let Err(Error::NotConverged { reason, .. }) = case.unwrap().model.solve_steps() else {
        panic!("it stands");
    };
    let told = reason.to_string();
    let Objection::Slides {
        bodies, held, by, ..
    } = *reason
    else {
        panic!("{told}");
    };
    assert_eq!((&bodies[..], by), (&["tower".to_string()][..], None));
    assert!((held - 2.0 / 3.0).abs() < 1e-6, "{held}");
    for word in ["loss of equilibrium", "tips", "rotation", "t = 1.66667"] {
        assert!(told.contains(word), "{told}");
    }
}

/// Without friction a block that tips in a later step is pulled away as in the first one, after what is told to be the time.
#[test]
fn what_tips_without_friction_is_pulled_away() {
    let text = r#"
analysis = "plane-strain"
[[body]]
name = "base"
mesh = { rectangle = { from = [0, 0], to = [1, 1], cells = [7, 8] } }
material = { young = 1e3, poisson = 0.3 }
fix = [{ side = "bottom", x = 0, y = 0 }]
[[body]]
name = "block"
mesh = { rectangle = { from = [0, 1], to = [1, 2], cells = [10, 8] } }
material = { young = 1e3, poisson = 0.3 }
load = [{ side = "top", traction = ["0.6*t", "-1"] }]
fix = [{ point = [0, 1], x = 0 }]
[[contact]]
name = "sole"
nonmortar = "block.bottom"
mortar = "base.top"
"#;
    let of = |steps: &str| {
        let case = Case::<2>::from_str(&format!("{text}{steps}"), "case.toml", Path::new("."));
        case.unwrap().model.solve_steps().err().unwrap().to_string()
    };
    let pulled = "pulls body \"block\" away";
    let (at_once, later) = (
        of("[[step]]\ntime = 1\n"),
        of("[[step]]\ntime = 0.5\n[[step]]\ntime = 1\n"),
    );
    assert!(
        at_once.contains(pulled) && !at_once.contains("until"),
        "{at_once}"
    );
    // thrust times its lever 1 beside the weight times half the width
    assert!(
        later.contains(pulled) && later.contains("held until t = 0.833333"),
        "{later}"
    );
}

/// A wedge with faces at 45° whose edge is at the origin and moves down by `down`, and its contact.
fn edge(pairing: &str, obstacle: &str, down: f64) -> String {
    format!(
        r#"analysis = "plane-strain"
[[body]]
name = "wedge"
mesh = {{ outline = {{ size = 0.15, cell = "tri3", from = [0, 0], edges = [{{ to = [1, 1], name = "low" }}, {{ to = [-1, 1], name = "top" }}, {{ to = [0, 0], name = "low" }}] }} }}
material = {{ young = 1e4, poisson = 0.3 }}
fix = [{{ side = "top", x = 0, y = {} }}]
[[contact]]
name = "edge"
nonmortar = "wedge.low"
obstacle = {{ {obstacle} }}
{pairing}
"#,
        -down
    )
}

/// Along faces at 45° a clearance of 0.01 would be used up after 0.02 alone. On its way straight down the edge meets a roller, a
/// wire that its faces do not see, or a bowl as it meets a plane.
#[test]
fn an_edge_meets_what_is_round_where_it_is() {
    let plane = "plane = { point = [0, -0.01], normal = [0, 1] }";
    let round = [
        "circle = { center = [0, -1.01], radius = 1 }",
        "circle = { center = [0, -0.06], radius = 0.05 }",
        "circle = { center = [0, 9.99], radius = 10, inside = true }",
    ];
    for down in [0.0099, 0.0101, 0.012] {
        let force = |obstacle: &str| {
            let solution = solve(&edge("", obstacle, down)).map_err(|reason| panic!("{reason}"));
            let contact = &solution.unwrap().contacts[0];
            let closed = contact.nodes.iter().filter(|node| node.pressure > 0.0);
            (contact.resultant[1], closed.count())
        };
        let (flat, count) = force(plane);
        assert_eq!(
            count,
            usize::from(down > 0.01),
            "one condition, not one for each face"
        );
        for obstacle in round {
            let (found, closed) = force(obstacle);
            assert_eq!(closed, count, "{obstacle}");
            assert!(
                (found - flat).abs() <= 1e-9 * flat.abs(),
                "{obstacle}: {found}, {flat}"
            );
        }
    }
}

/// Conditions in the mean go along the faces: what the edge overlaps is told.
#[test]
fn an_edge_that_means_over_its_faces_let_through_is_told() {
    let obstacle = "circle = { center = [0, -1.01], radius = 1 }";
    let found = stands(solve(&edge("pairing = \"mortar\"", obstacle, 0.015)));
    assert!(
        found.obstacle && (found.depth - 0.005).abs() < 1e-9,
        "{found:?}"
    );
    assert_eq!(found.point, [0.0, 0.0]);
}

/// A polygon of ten sides stands for a post of radius 0.3338: it is 0.016 off, inside. What is less deep in it stands in the post.
#[test]
fn a_corner_that_stands_in_a_round_post_is_excused_by_no_chord() {
    let moved = |aside: f64| {
        solve(&format!(
            r#"
analysis = "plane-strain"
[[body]]
name = "post"
mesh = {{ outline = {{ size = 0.21, circle = {{ center = [1.2562872240440321, 0.6337706286315488], radius = 0.3337706286315487, name = "round" }} }} }}
material = {{ young = 82.0, poisson = 0.17 }}
fix = [{{ side = "round", x = 0, y = 0 }}]
[[body]]
name = "slider"
mesh = {{ rectangle = {{ from = [0.2, 0.016], to = [0.7111, 0.4513], cells = [2, 2], cell = "tri6" }} }}
material = {{ young = 132.0, poisson = 0.16 }}
fix = [{{ side = "top", x = {aside}, y = 0 }}]
"#
        ))
    };
    // the true circle stands at x = 0.9757 at this height, and the chord a little behind
    assert!(moved(0.26).is_ok());
    let depths = [0.28, 0.29].map(|aside| stands(moved(aside)));
    assert!(
        depths
            .iter()
            .all(|found| !found.named && found.body == "slider")
    );
    assert!(depths[0].depth < depths[1].depth && depths[1].depth < 0.016);
}

/// The chords of a bore stand in a shaft that fits and turns, by what they are off the bore; no contact is named.
#[test]
fn a_shaft_that_turns_in_its_bore_stands_in_no_more_than_chords() {
    let turned = |angle: f64| {
        solve(&format!(
            r#"
analysis = "plane-strain"
[[body]]
name = "hub"
mesh = {{ ring = {{ inner = 1, outer = 2, cells = [24, 2], cell = "quad4" }} }}
material = {{ young = 1000, poisson = 0.3 }}
fix = [{{ side = "outer", x = 0, y = 0 }}]
[[body]]
name = "shaft"
mesh = {{ ring = {{ inner = 0.5, outer = 1, cells = [24, 2], cell = "quad4" }} }}
material = {{ young = 1000, poisson = 0.3 }}
fix = [{{ side = "inner", x = "-{angle}*y", y = "{angle}*x" }}]
"#
        ))
    };
    assert!(turned(0.02).is_ok());
    assert!(turned(0.1).is_ok());
}

#[test]
fn gaps_up_to_adjust_count_as_closed() {
    // a block above another one, pressed by 1 of 1000: its top goes down by the gap and by 1e-3 for each of the two
    let top = |gap: &str, apart: f64, analysis: &str| {
        let space = analysis == "3d";
        let (z, zero, cells) = if space {
            (", 0.0", ", z = 0.0", ", 2")
        } else {
            ("", "", "")
        };
        let (kind, high, side) = match space {
            true => ("box", "1.0, 1.0", "top"),
            false => ("rectangle", "1.0", "top"),
        };
        // the last coordinate is up
        let block = |name: &str, from: f64, n: usize, rest: &str| {
            let low = if space { "0.0, 0.0" } else { "0.0" };
            let to = from + 1.0;
            format!(
                "[[body]]\nname = \"{name}\"\nmesh = {{ {kind} = {{ from = [{low}, {from:?}], to = [{high}, {to:?}], cells = [{n}, {n}{cells}] }} }}\n\
                 material = {{ young = 1000.0, poisson = 0.0 }}\n{rest}\n"
            )
        };
        let up = if space { "z" } else { "y" };
        let held = format!("fix = [{{ side = \"bottom\", x = 0.0, y = 0.0{zero} }}]");
        let free = if space { "x = 0.0, y = 0.0" } else { "x = 0.0" };
        let pressed = format!(
            "fix = [{{ side = \"top\", {free} }}]\nload = [{{ side = \"{side}\", pressure = 1.0 }}]"
        );
        let text = format!(
            "analysis = \"{analysis}\"\n{}{}[[contact]]\nname = \"c\"\nnonmortar = \"high.bottom\"\nmortar = \"low.top\"\ngap = {gap}\n\
             [[probe]]\nname = \"top\"\nquantity = \"high.displacement.{up}\"\nat = [0.5{z}, {:?}]\n",
            block("low", 0.0, 3, &held),
            block("high", 1.0 + apart, 2, &pressed),
            2.0 + apart
        );
        let text = if space {
            text.replace("at = [0.5, 0.0, ", "at = [0.5, 0.5, ")
        } else {
            text
        };
        match AnyCase::from_str(&text, "adjust.toml", Path::new(".")).unwrap() {
            AnyCase::Plane(case) => asked(case.model.solve()).unwrap().probes[0].value,
            AnyCase::Space(case) => asked(case.model.solve()).unwrap().probes[0].value,
        }
    };
    for analysis in ["plane-strain", "3d"] {
        for (gap, apart, moved) in [
            ("\"geometric\"", 0.01, 0.012),
            ("{ adjust = 0.005 }", 0.01, 0.012),
            ("{ adjust = 0.02 }", 0.01, 0.002),
            // overlaps count as closed, whatever the length
            ("{ adjust = 0.0 }", -0.01, 0.002),
            ("\"geometric\"", -0.001, 0.001),
        ] {
            let found = top(gap, apart, analysis);
            assert!(
                (found + moved).abs() < 1e-9,
                "{analysis} {gap} {apart}: {found}"
            );
        }
    }
}
