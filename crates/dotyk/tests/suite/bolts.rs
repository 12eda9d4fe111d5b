//! Bolts that are bodies: cut across and drawn together. Uniform tension is in `cases/bolts-tightened`.
//!
//! Tolerances are rounding of a linear solve: 1e-9 of the largest value.

use crate::links::{near, refused, solved};
use dotyk::model::Solution;

const ROUNDING: f64 = 1e-9;

/// A cantilever of triangles under a load at its end, of one step or two, and perhaps a bolt.
fn cantilever(steps: usize, bolt: &str) -> String {
    let steps: String = (1..=steps)
        .map(|t| format!("[[step]]\ntime = {t}\n"))
        .collect();
    format!(
        "analysis = \"plane-strain\"\n\
         [[body]]\nname = \"beam\"\n\
         mesh = {{ rectangle = {{ from = [0, 0], to = [5, 1], cells = [13, 4], cell = \"tri3\" }} }}\n\
         material = {{ young = 1000, poisson = 0.3 }}\n\
         fix = [{{ side = \"left\", x = 0, y = 0 }}]\n\
         load = [{{ side = \"right\", traction = [\"0.3*t\", \"-0.1*t\"] }}]\n{bolt}{steps}"
    )
}

fn bolt(keys: &str) -> String {
    format!("[[bolt]]\nname = \"stud\"\nbody = \"beam\"\nat = [2.3, 0.5]\n{keys}\n")
}

/// Largest difference of the displacements of the nodes of a whole body, over the largest displacement.
fn difference(cut: &Solution<2>, whole: &Solution<2>) -> f64 {
    let [cut, whole] = [cut, whole].map(|s| &s.bodies[0].displacement);
    assert!(cut.len() > whole.len());
    let all = || whole.iter().flatten();
    let most = all().fold(0.0, |most: f64, u| most.max(u.abs()));
    let apart = cut.iter().flatten().zip(all()).map(|(a, b)| (a - b).abs());
    apart.fold(0.0, f64::max) / most
}

/// A block on a beam that a bolt may cut, of two steps, by the sides that carry the multipliers.
fn pressed(swapped: bool, friction: f64, bolt: &str) -> Vec<Solution<2>> {
    let [nonmortar, mortar] = match swapped {
        true => ["beam.top", "block.bottom"],
        false => ["block.bottom", "beam.top"],
    };
    let text = format!(
        "analysis = \"plane-strain\"\n\
         [[body]]\nname = \"beam\"\n\
         mesh = {{ rectangle = {{ from = [0, 0], to = [4, 1], cells = [8, 2] }} }}\n\
         material = {{ young = 1000, poisson = 0.3 }}\n\
         fix = [{{ side = \"bottom\", y = 0 }}, {{ side = \"left\", x = 0 }}]\n\
         [[body]]\nname = \"block\"\n\
         mesh = {{ rectangle = {{ from = [0, 1], to = [4, 2], cells = [8, 2] }} }}\n\
         material = {{ young = 1000, poisson = 0.3 }}\nfix = [{{ side = \"left\", x = 0 }}]\n\
         load = [{{ side = \"top\", traction = [0.1, -1] }}]\n\
         [[contact]]\nname = \"c\"\nnonmortar = \"{nonmortar}\"\nmortar = \"{mortar}\"\n\
         friction = {friction}\n{bolt}[[step]]\ntime = 1\n[[step]]\ntime = 2\n"
    );
    solved(&text).1
}

fn beside_the_cut(solution: &Solution<2>) -> Vec<f64> {
    let nodes = solution.contacts[0].nodes.iter();
    let there = nodes.filter(|node| (node.point[0] - 2.0).abs() < 1e-9);
    there.map(|node| node.pressure).collect()
}

#[test]
fn a_contact_goes_on_over_a_cut() {
    let stud = "[[bolt]]\nname = \"stud\"\nbody = \"beam\"\nat = [2, 0.5]\naxis = [1, 0]\n";
    for (swapped, friction) in [(false, 0.0), (false, 0.3), (true, 0.0), (true, 0.3)] {
        let whole = &pressed(swapped, friction, "")[1];
        let kept = format!("{stud}shortening = 0\n");
        let cut = &pressed(swapped, friction, &kept)[1];
        let [expected] = beside_the_cut(whole)[..] else {
            panic!("one node there")
        };
        // two of the cut side, or one of the other side with a row for each face of the cut
        let found = beside_the_cut(cut);
        assert_eq!(found.len(), 2);
        for pressure in found {
            assert!((pressure - expected).abs() < 1e-6, "{pressure} {expected}");
        }
        let [cut, whole] = [cut, whole].map(|s| s.contacts[0].resultant);
        assert!((cut[1] - whole[1]).abs() < 1e-9);
        // without friction nothing else holds the part that the bolt draws
        if friction == 0.0 {
            continue;
        }
        // a bolt that is locked does not exchange its force with the friction beside it
        let drawn = pressed(swapped, friction, &format!("{stud}prestress = 0.1\n"));
        for step in &drawn {
            let force = step.member("stud").unwrap().stations[0].force;
            assert!((force - 0.1).abs() < 1e-8, "{force}");
        }
        let [first, second] = [0, 1].map(|step: usize| beside_the_cut(&drawn[step]));
        for (first, second) in first.into_iter().zip(second) {
            assert!((first - second).abs() < 1e-7, "{first} {second}");
        }
    }
}

#[test]
fn no_corner_leans_at_a_cut() {
    let beam = |bolt: &str| {
        let text = format!(
            "analysis = \"plane-strain\"\n[[body]]\nname = \"beam\"\n\
             mesh = {{ rectangle = {{ from = [0, 0], to = [4, 1], cells = [8, 2] }} }}\n\
             material = {{ young = 1000, poisson = 0.3 }}\n\
             fix = [{{ side = \"bottom\", y = 0 }}, {{ side = \"left\", x = 0 }}]\n\
             [[contact]]\nname = \"c\"\nnonmortar = \"beam.top\"\n\
             obstacle = {{ outline = [[-1, 1], [5, 1.006]], displacement = [0, -0.02] }}\n{bolt}"
        );
        solved(&text).1.remove(0)
    };
    let cut = beam(
        "[[bolt]]\nname = \"stud\"\nbody = \"beam\"\nat = [2, 0.5]\naxis = [1, 0]\nshortening = 0\n",
    );
    assert!(difference(&cut, &beam("")) < ROUNDING);
}

#[test]
fn a_cut_that_is_not_drawn_together_changes_nothing() {
    let whole = solved(&cantilever(2, "")).1;
    for axis in ["[1, 0]", "[-3, 0]", "[1, 0.8]", "[1, -0.3]"] {
        let keys = format!("axis = {axis}\nshortening = 0");
        let cut = solved(&cantilever(2, &bolt(&keys))).1;
        for (cut, whole) in cut.iter().zip(&whole) {
            assert!(difference(cut, whole) < ROUNDING, "{axis}");
        }
        // the force of the part that it holds
        let (along, force) = match axis {
            "[1, 0.8]" => ([1.0, 0.8], [0.3, -0.1]),
            "[1, -0.3]" => ([1.0, -0.3], [0.3, -0.1]),
            _ => ([1.0, 0.0], [0.3, -0.1]),
        };
        let length = f64::hypot(along[0], along[1]);
        let expected = (along[0] * force[0] + along[1] * force[1]) / length;
        near(
            cut[0].member("stud").unwrap().stations[0].force,
            expected,
            ROUNDING,
        );
    }
}

/// The same held at both ends, and drawn along its top.
fn clamped(steps: usize, bolt: &str) -> String {
    let text = cantilever(steps, bolt);
    let text = text.replace("fix = [", "fix = [{ side = \"right\", x = 0 }, ");
    text.replace("side = \"right\", traction", "side = \"top\", traction")
}

#[test]
fn what_tightens_it_is_locked_at_the_shortening_that_it_took() {
    let whole = solved(&clamped(2, "")).1;
    let stud = |step: &Solution<2>| step.member("stud").unwrap().clone();
    let drawn = |keys: &str| solved(&clamped(2, &bolt(&format!("axis = [1, 0]\n{keys}")))).1;
    // the tension that the cut has of itself tightens it by nothing
    let own = stud(&drawn("shortening = 0")[0]).stations[0].force;
    assert!(own.abs() > 0.01, "{own}");
    let cut = drawn(&format!("prestress = {own}"));
    near(stud(&cut[0]).shortening.unwrap(), 0.0, ROUNDING);
    assert!(stud(&cut[0]).tightening && !stud(&cut[1]).tightening);
    for (cut, whole) in cut.iter().zip(&whole) {
        assert!(difference(cut, whole) < ROUNDING);
    }
    near(stud(&cut[1]).stations[0].force, 2.0 * own, ROUNDING);
    // more of it adds what the bar bears of a shortening alone
    let more = drawn(&format!("prestress = {}", own + 5.0));
    let passed = stud(&more[0]).shortening.unwrap();
    assert!(passed > 0.0);
    near(stud(&more[1]).shortening.unwrap(), passed, ROUNDING);
    near(stud(&more[1]).stations[0].force, 2.0 * own + 5.0, ROUNDING);
}

/// Nothing but its load balances a part beyond the cut that is free: no other tension has an answer.
#[test]
fn a_free_end_bears_no_prestress_but_that_of_its_load() {
    let text = cantilever(1, &bolt("axis = [1, 0]\nprestress = 1"));
    assert!(refused(&text).message.contains("is not held"));
}

#[test]
fn ends_may_be_swapped_and_the_axis_turned_back() {
    let blocks = |ends: [&str; 2], axis: &str| {
        let block = |name: &str, x: f64, keys: &str| {
            format!(
                "[[body]]\nname = \"{name}\"\nmesh = {{ rectangle = {{ from = [{x}, 0], to = [{}, 1], cells = [3, 4], cell = \"quad9\" }} }}\n\
                 material = {{ young = 1000, poisson = 0.3 }}\n{keys}\n",
                x + 2.0
            )
        };
        let text = format!(
            "analysis = \"plane-strain\"\n{}{}[[bolt]]\nname = \"stud\"\nfrom = {{ side = \"{}\" }}\nto = {{ side = \"{}\" }}\n{axis}prestress = 7\n",
            block("left", 0.0, "fix = [{ side = \"left\", x = 0, y = 0 }]"),
            block(
                "right",
                2.0,
                "fix = [{ side = \"right\", x = 0 }, { point = [4, 0], y = 0 }]\nload = [{ side = \"top\", pressure = 1 }]"
            ),
            ends[0],
            ends[1]
        );
        let solution = solved(&text).1.remove(0);
        let stud = solution.member("stud").unwrap().clone();
        near(stud.stations[0].force, 7.0, ROUNDING);
        let bodies = solution.bodies.iter().flat_map(|b| b.displacement.clone());
        let bodies: Vec<f64> = bodies.flatten().collect();
        (stud.shortening.unwrap(), bodies)
    };
    let there = blocks(["left.right", "right.left"], "");
    assert!(there.0 > 0.0);
    for (ends, axis) in [
        (["right.left", "left.right"], ""),
        (["left.right", "right.left"], "axis = [2, 0]\n"),
        (["left.right", "right.left"], "axis = [-1, 0]\n"),
        (["right.left", "left.right"], "axis = [1, 0]\n"),
    ] {
        let back = blocks(ends, axis);
        near(back.0, there.0, ROUNDING);
        for (a, b) in back.1.iter().zip(&there.1) {
            near(*a, *b, ROUNDING);
        }
    }
}

/// A bar that lies aslant, of triangles that know nothing of the cut, held at its ends: N = EA s/L.
#[test]
fn a_bar_aslant_has_the_tension_of_its_shortening() {
    let (angle, length, width) = (0.7_f64, 6.0, 1.5);
    let at = |s: f64, n: f64| {
        let (sin, cos) = angle.sin_cos();
        format!("[{:?}, {:?}]", s * cos - n * sin, s * sin + n * cos)
    };
    let text = format!(
        "analysis = \"plane-stress\"\n[[body]]\nname = \"bar\"\n\
         mesh = {{ outline = {{ size = 0.4, from = {}, edges = [{{ to = {}, name = \"below\" }}, {{ to = {}, name = \"end\" }}, {{ to = {}, name = \"above\" }}, {{ to = {}, name = \"start\" }}] }} }}\n\
         material = {{ young = 1000, poisson = 0.3 }}\n\
         fix = [{{ side = \"start\", normal = 0 }}, {{ side = \"end\", normal = 0 }}, {{ point = {}, x = 0, y = 0 }}]\n\
         [[bolt]]\nname = \"stud\"\nbody = \"bar\"\nat = {}\naxis = {}\nprestress = 9\n",
        at(0.0, 0.0),
        at(length, 0.0),
        at(length, width),
        at(0.0, width),
        at(0.0, 0.0),
        at(0.0, 0.0),
        at(2.9, 0.5),
        at(-2.0, 0.0),
    );
    let (model, steps) = solved(&text);
    let stud = steps[0].member("stud").unwrap();
    near(stud.stations[0].force, 9.0, ROUNDING);
    near(
        stud.shortening.unwrap(),
        9.0 * length / (1000.0 * width),
        ROUNDING,
    );
    // the cut follows the triangles
    let cut = model.bodies[0].mesh.side("stud-behind").unwrap();
    assert!(cut.len() > 3);
}

/// A uniform shift along the radius is no motion of a body of revolution.
#[test]
fn with_axial_symmetry_a_bolt_is_drawn_along_the_axis() {
    let text = |axis: &str| {
        format!(
            "analysis = \"axisymmetric\"\n[[body]]\nname = \"screw\"\n\
             mesh = {{ rectangle = {{ from = [0, 0], to = [1, 3], cells = [4, 6] }} }}\n\
             material = {{ young = 1000, poisson = 0.3 }}\nfix = [{{ side = \"bottom\", y = 0 }}, {{ side = \"top\", y = 0 }}]\n\
             [[bolt]]\nname = \"stud\"\nbody = \"screw\"\nat = [0.5, 1.5]\naxis = {axis}\nprestress = 5\n"
        )
    };
    let stud = solved(&text("[0, -2]")).1;
    let stud = stud[0].member("stud").unwrap();
    near(stud.stations[0].force, 5.0, ROUNDING);
    let area = std::f64::consts::PI;
    near(
        stud.shortening.unwrap(),
        5.0 * 3.0 / (1000.0 * area),
        ROUNDING,
    );
    for axis in ["[1, 0]", "[0.01, 1]"] {
        let error = refused(&text(axis));
        assert!(
            error.message.contains("along the axis of symmetry"),
            "{error}"
        );
    }
}

/// Else the contact would bear the prestress, and nothing would be tightened.
#[test]
fn a_contact_at_the_cut_is_refused() {
    let text = |contact: &str| {
        let part = |name: &str, y: f64, fix: &str| {
            format!(
                "[[body]]\nname = \"{name}\"\nmesh = {{ rectangle = {{ from = [0, {y}], to = [1, {}], cells = [2, 2] }} }}\n\
                 material = {{ young = 1000, poisson = 0 }}\nfix = [{{ side = \"{fix}\", x = 0, y = 0 }}]\n",
                y + 1.0
            )
        };
        format!(
            "analysis = \"plane-strain\"\n{}{}{contact}[[bolt]]\nname = \"stud\"\nfrom = {{ side = \"low.top\" }}\nto = {{ side = \"up.bottom\" }}\nprestress = 3\n",
            part("low", 0.0, "bottom"),
            part("up", 1.0, "top")
        )
    };
    let alone = solved(&text("")).1;
    near(
        alone[0].member("stud").unwrap().shortening.unwrap(),
        0.006,
        ROUNDING,
    );
    for contact in [
        "bodies = \"all\"",
        "nonmortar = \"low.top\"\nmortar = \"up.bottom\"",
    ] {
        let error = refused(&text(&format!("[[contact]]\nname = \"c\"\n{contact}\n")));
        assert!(error.message.contains("acts at its cut"), "{error}");
    }
}

#[test]
fn supports_on_both_sides_of_a_cut_along_its_axis_are_told() {
    let text = clamped(1, &bolt("axis = [1, 0]\nprestress = 1"));
    let held = |fix: &str| text.replace("fix = [", &format!("fix = [{fix}, "));
    // across the axis they are those of a plane of symmetry
    let symmetric = solved(&held("{ side = \"bottom\", y = 0 }")).1;
    near(
        symmetric[0].member("stud").unwrap().stations[0].force,
        1.0,
        ROUNDING,
    );
    let error = refused(&held("{ side = \"bottom\", x = 0 }"));
    assert!(
        error.message.contains("hold both sides of its cut"),
        "{error}"
    );
}
