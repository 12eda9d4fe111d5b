//! Springs between two places, and what they share with bars; bars themselves are in `links.rs`.
//!
//! Tolerances are rounding unless they say otherwise: 1e-6 of the largest value, where contact forces take part and blocks of
//! Young's modulus 1e9 stand for rigid ones.

use crate::links::{PLANE, block, near, refused, solved, steps};
use dotyk::case::Case;
use dotyk::model::Solution;

/// A spring of these ends and keys.
fn spring([from, to]: [&str; 2], keys: &str) -> String {
    format!("[[spring]]\nname = \"spring\"\nfrom = {from}\nto = {to}\n{keys}\n")
}

fn force<const D: usize>(step: &Solution<D>) -> f64 {
    step.member("spring").unwrap().stations[0].force
}

/// The forces of a spring between two stiff blocks whose distance changes by a course.
fn driven(ends: [&str; 2], keys: &str, course: &[f64]) -> Vec<f64> {
    let times: Vec<f64> = (1..=course.len()).map(|k| k as f64).collect();
    let mut expression = "0".to_string();
    for (t, u) in times.iter().zip(course) {
        expression += &format!(" + ({u})*max(0, 1 - abs(t - {t}))");
    }
    let text = format!(
        "{PLANE}{}{}{}{}",
        steps(&times),
        block(
            "left",
            [0.0, 0.0],
            "fix = [{ side = \"right\", x = 0, y = 0 }]"
        ),
        block(
            "right",
            [4.0, 0.0],
            &format!("fix = [{{ side = \"left\", x = \"{expression}\", y = 0 }}]")
        ),
        spring(ends, keys)
    );
    solved(&text).1.iter().map(force).collect()
}

const SIDES: [&str; 2] = ["{ side = \"left.right\" }", "{ side = \"right.left\" }"];

#[test]
fn a_spring_bears_what_it_acts_for_from_its_gap_on() {
    let course = [0.1, 0.5, 0.3, -0.2, 0.1, 0.9, -0.7, -0.1, 0.0];
    type Law = fn(f64) -> f64;
    let laws: [(&str, Law); 6] = [
        ("", |u| 25.0 * u),
        ("acts = \"both\"", |u| 25.0 * u),
        ("acts = \"tension\"", |u| 25.0 * u.max(0.0)),
        ("acts = \"compression\"", |u| 25.0 * u.min(0.0)),
        ("acts = \"tension\"\ngap = 0.3", |u| {
            25.0 * (u - 0.3).max(0.0)
        }),
        ("acts = \"compression\"\ngap = 0.15", |u| {
            25.0 * (u + 0.15).min(0.0)
        }),
    ];
    for (keys, law) in laws {
        let keys = format!("stiffness = 25\n{keys}");
        for ends in [SIDES, [SIDES[1], SIDES[0]]] {
            let found = driven(ends, &keys, &course);
            for (found, u) in found.into_iter().zip(course) {
                near(found, law(u), 1e-6);
                assert!(found != 0.0 || found.is_sign_positive(), "{keys}");
            }
        }
        // points of the blocks instead of their sides
        let points = ["[2, 0.5]", "[4, 0.5]"];
        let keys = format!("{keys}\nbodies = [\"left\", \"right\"]\nradius = 0.1");
        for (found, u) in driven(points, &keys, &course).into_iter().zip(course) {
            near(found, law(u), 1e-5);
        }
    }
}

/// Two blocks of Young's modulus 1000, the upper one on a spring and under a load, perhaps with more members.
fn stacked(load: &str, members: &str) -> String {
    let soft = |text: String| text.replace("young = 1e9", "young = 1000");
    format!(
        "{PLANE}{}{}{members}",
        soft(block(
            "lower",
            [0.0, 0.0],
            "fix = [{ side = \"bottom\", y = 0 }, { side = \"left\", x = 0 }]"
        )),
        soft(block(
            "upper",
            [0.0, 3.0],
            &format!(
                "fix = [{{ side = \"left\", x = 0 }}]\nload = [{{ side = \"top\", traction = [0, \"{load}\"] }}]"
            )
        ))
    )
}

const STACKED: [&str; 2] = ["{ side = \"lower.top\" }", "{ side = \"upper.bottom\" }"];

/// How far the top of the upper block has moved.
fn raised(model: &dotyk::model::Model<2>, step: &Solution<2>) -> f64 {
    let points = model.bodies[1].mesh.points();
    let top = points.iter().position(|point| point[1] == 4.0).unwrap();
    step.bodies[1].displacement[top][1]
}

/// A load that pulls goes through block, spring and block: 1/1000 + 1/k + 1/1000, with sides of 2 × 0.5.
#[test]
fn springs_and_blocks_are_springs_in_a_row() {
    for (spacing, count) in [("", 1.0), ("spacing = 0.25", 2.0), ("spacing = 2", 0.25)] {
        for load in [6.0, -6.0] {
            let keys = format!("stiffness = 40\n{spacing}");
            let text = stacked(&load.to_string(), &spring(STACKED, &keys));
            let (model, found) = solved(&text);
            near(force(&found[0]), load / count, 1e-9);
            near(
                raised(&model, &found[0]),
                load * (2e-3 + 1.0 / (40.0 * count)),
                1e-9,
            );
            let told = found[0].member("spring").unwrap();
            assert_eq!(
                (told.length, told.stations.len(), told.tightening),
                (2.0, 1, false)
            );
            // what the springs pull is no force of contacts, and balances the load
            let pulls = found[0].bodies[1].member_forces.values();
            near(pulls.map(|f| f[1]).sum(), -load, 1e-9);
            near(found[0].bodies[0].reaction[1], -load, 1e-9);
        }
    }
}

/// A load that nothing but a spring of the other kind of force could bear is told; one that it bears moves through its play.
#[test]
fn a_spring_that_acts_one_way_holds_one_way() {
    for (acts, load) in [("tension", 6.0), ("compression", -6.0)] {
        let keys = format!("stiffness = 40\nacts = \"{acts}\"\ngap = 0.3");
        let members = spring(STACKED, &keys);
        let (model, found) = solved(&stacked(&load.to_string(), &members));
        near(force(&found[0]), load, 1e-9);
        let play = 0.3 * load.signum();
        near(
            raised(&model, &found[0]),
            play + load * (2e-3 + 1.0 / 40.0),
            1e-8,
        );
        let error = refused(&stacked(&(-load).to_string(), &members)).to_string();
        assert!(error.contains("upper"), "{error}");
    }
}

#[test]
fn a_spring_of_the_stiffness_of_a_bar_moves_bodies_alike() {
    let load = "6*t - 2*x";
    let [from, to] = STACKED;
    let bar = |keys: &str| {
        format!(
            "[[bar]]\nname = \"spring\"\nfrom = {from}\nto = {to}\nyoung = 80\narea = 0.6\n{keys}\n"
        )
    };
    // EA/L = 80 · 0.6/2
    let pairs = [
        (bar(""), spring(STACKED, "stiffness = 24")),
        (
            bar("tension_only = true"),
            spring(STACKED, "stiffness = 24\nacts = \"tension\""),
        ),
        (
            bar("spacing = 0.2"),
            spring(STACKED, "stiffness = 24\nspacing = 0.2"),
        ),
    ];
    for (bar, spring) in pairs {
        // a side moves by its mean, so that the block is held against its turn
        let held = |members: &str| {
            let text = stacked(load, members);
            text.replace(
                "[{ side = \"left\", x = 0 }]\nload",
                "[{ side = \"left\", x = 0 }, { side = \"right\", x = 0 }]\nload",
            )
        };
        let [(_, one), (_, other)] = [bar, spring].map(|members| solved(&held(&members)));
        near(force(&one[0]), force(&other[0]), 1e-12);
        for (body, same) in one[0].bodies.iter().zip(&other[0].bodies) {
            for (u, v) in body.displacement.iter().zip(&same.displacement) {
                (0..2).for_each(|d| near(u[d], v[d], 1e-12));
            }
        }
    }
}

/// One for tension and one for compression are one that acts both ways.
#[test]
fn two_springs_that_act_one_way_are_one_that_acts_both_ways() {
    let one = |name: &str, acts: &str| {
        let keys = format!("stiffness = 40\nacts = \"{acts}\"");
        spring(STACKED, &keys).replace("\"spring\"", &format!("\"{name}\""))
    };
    let two = one("spring", "tension") + &one("other", "compression");
    for load in ["6", "-6"] {
        let (model, found) = solved(&stacked(load, &two));
        let (_, same) = solved(&stacked(load, &one("spring", "both")));
        near(raised(&model, &found[0]), raised(&model, &same[0]), 1e-8);
        let sum = force(&found[0]) + found[0].member("other").unwrap().stations[0].force;
        near(sum, force(&same[0]), 1e-8);
    }
}

/// It counts from the moved blocks: k and the gap of what they move from then on.
#[test]
fn a_spring_that_comes_later_bears_nothing_where_it_finds_the_bodies() {
    let first = spring(STACKED, "stiffness = 40").replace("\"spring\"", "\"first\"");
    for (acts, gap, load) in [
        ("both", 0.0, "4 + 2*(t - 1)"),
        ("tension", 0.02, "4 + 2*(t - 1)"),
        ("compression", 0.02, "-4 - 2*(t - 1)"),
    ] {
        let gap_key = match acts {
            "both" => String::new(),
            _ => format!("\ngap = {gap}"),
        };
        let keys = format!("stiffness = 60\nacts = \"{acts}\"{gap_key}\nactive = {{ from = 2 }}");
        let members = format!("{first}{}", spring(STACKED, &keys));
        let text =
            stacked(load, &members).replace(PLANE, &format!("{PLANE}{}", steps(&[1.0, 2.0, 3.0])));
        let (_, found) = solved(&text);
        assert!(found[0].member("spring").is_none());
        let lengthened =
            |step: usize| found[step].member("first").unwrap().stations[0].force / 40.0;
        for step in [1, 2] {
            let since = lengthened(step) - lengthened(0);
            let bears = 60.0 * (since.abs() - gap).max(0.0) * since.signum();
            near(force(&found[step]), bears, 1e-7);
            let load = (4.0 + 2.0 * step as f64) * since.signum();
            near(force(&found[step]) + 40.0 * lengthened(step), load, 1e-8);
        }
        assert!(force(&found[2]).abs() > 0.5, "{acts}");
    }
}

/// A block on four springs at its corners in space, pressed beside its middle: statics, and a part of 5e-7 that the block gives.
#[test]
fn springs_in_space_share_a_load_by_statics() {
    let cube = |name: &str, z: f64, keys: &str| {
        format!(
            "[[body]]\nname = \"{name}\"\nmesh = {{ box = {{ from = [0, 0, {z}], to = [2, 2, {}], cells = [2, 2, 1] }} }}\n\
             material = {{ young = 1e9, poisson = 0.0 }}\n{keys}\n",
            z + 1.0
        )
    };
    let corners = [[0, 0], [2, 0], [0, 2], [2, 2]];
    let springs = corners.iter().enumerate().map(|(k, [x, y])| {
        spring(
            [&format!("[{x}, {y}, 1]"), &format!("[{x}, {y}, 1.5]")],
            "bodies = [\"low\", \"up\"]\nstiffness = 500\nacts = \"compression\"\ngap = 0.1",
        )
        .replace("\"spring\"", &format!("\"spring-{k}\""))
    });
    let text = format!(
        "title = \"Springs\"\nanalysis = \"3d\"\n{}{}{}[[probe]]\nname = \"corner\"\nquantity = \"spring-3.force\"\n",
        cube(
            "low",
            0.0,
            "fix = [{ side = \"bottom\", x = 0, y = 0, z = 0 }]"
        ),
        cube(
            "up",
            1.5,
            "fix = [{ point = [0, 0, 2.5], x = 0, y = 0 }, { point = [2, 0, 2.5], y = 0 }]\n\
             load = [{ point = [1, 1, 2.5], force = [0, 0, -40] }, { point = [2, 2, 2.5], force = [0, 0, -8] }]"
        ),
        springs.collect::<String>()
    );
    let model = Case::<3>::from_str(&text, "members.toml", "".as_ref())
        .unwrap()
        .model;
    let found = model.solve_steps().unwrap();
    // 12 each, and moments 8 about both axes through the middle on arms of 1
    for (member, [x, y]) in found[0].members.iter().zip(corners) {
        let [x, y] = [x - 1, y - 1].map(f64::from);
        near(member.stations[0].force, -(12.0 + 2.0 * x + 2.0 * y), 1e-5);
        near(member.length, 0.5, 1e-12);
    }
    near(found[0].probe("corner").unwrap(), -16.0, 1e-5);
}

/// Kinds stand together, each in its order, whatever the order of the text.
#[test]
fn members_are_told_kind_by_kind() {
    let [from, to] = STACKED;
    let bar =
        format!("[[bar]]\nname = \"bar\"\nfrom = {from}\nto = {to}\nyoung = 80\narea = 0.6\n");
    let second = spring(STACKED, "stiffness = 2").replace("\"spring\"", "\"second\"");
    let text = stacked(
        "6",
        &format!("{}{bar}{second}", spring(STACKED, "stiffness = 14")),
    );
    let (_, found) = solved(&text);
    let kinds = found[0].members_by_kind().map(|(kind, own)| {
        let names = own.iter().map(|member| member.name.as_str());
        (kind.plural, names.collect::<Vec<_>>().join(" "))
    });
    let kinds: Vec<(&str, String)> = kinds.collect();
    let told = [("bars", "bar"), ("springs", "spring second")];
    assert_eq!(kinds, told.map(|(kind, names)| (kind, names.to_string())));
    // k = 24, 14 and 2 beside each other
    for (name, part) in [("bar", 0.6), ("spring", 0.35), ("second", 0.05)] {
        near(
            found[0].member(name).unwrap().stations[0].force,
            6.0 * part,
            1e-9,
        );
    }
}

#[test]
fn nothing_is_reused_where_a_spring_differs() {
    let model = |keys: &str| {
        let text = stacked("6", &spring(STACKED, keys));
        let case = Case::<2>::from_str(&text, "members.toml", "".as_ref());
        case.unwrap().model
    };
    let one = model("stiffness = 40\nacts = \"tension\"\ngap = 0.1");
    assert!(one.has_stiffness_of(&one.clone()));
    for keys in [
        "stiffness = 41\nacts = \"tension\"\ngap = 0.1",
        "stiffness = 40\nacts = \"tension\"\ngap = 0.2",
        "stiffness = 40\nacts = \"compression\"\ngap = 0.1",
        "stiffness = 40\nacts = \"tension\"\ngap = 0.1\nspacing = 0.25",
    ] {
        assert!(!one.has_stiffness_of(&model(keys)), "{keys}");
    }
}

#[test]
fn nonsense_is_one_clear_error() {
    let whole =
        "name = \"s\"\nfrom = [0.5, 0.5]\nto = [1.5, 0.5]\nbodies = [\"block\"]\nstiffness = 1\n";
    let text = |keys: &str, analysis: &str| {
        let fixed = "fix = [{ side = \"left\", x = 0, y = 0 }]";
        let block = block("block", [0.0, 0.0], fixed).replace(", thickness = 0.5", "");
        format!("title = \"Springs\"\nanalysis = \"{analysis}\"\n{block}[[spring]]\n{keys}\n")
    };
    let springs = [
        (whole.replace("name = \"s\"\n", ""), "`name`"),
        (whole.replace("\"s\"", "\"block\""), "names a body already"),
        (whole.replace("stiffness = 1\n", ""), "`stiffness`"),
        (
            whole.replace("stiffness = 1", "stiffness = 0"),
            "`stiffness`",
        ),
        (whole.replace("to = [1.5, 0.5]\n", ""), "`to`"),
        (whole.replace("[0.5, 0.5]", "[1.5, 0.5]"), "same place"),
        (
            whole.replace("[0.5, 0.5]", "[5, 5]"),
            "lies in none of the bodies block",
        ),
        (
            whole.replace("bodies = [\"block\"]\n", ""),
            "in which bodies",
        ),
        (format!("{whole}acts = \"push\""), "unknown way to act"),
        (format!("{whole}gap = 0.1"), "acts both ways"),
        (
            format!("{whole}acts = \"tension\"\ngap = -0.1"),
            "zero or positive",
        ),
        (format!("{whole}spacing = -1"), "`spacing`"),
        (format!("{whole}bond = \"grouted\""), "unknown key `bond`"),
        (format!("{whole}young = 1"), "unknown key `young`"),
        (
            format!("{whole}active = {{ from = 3 }}"),
            "it is there in no load step",
        ),
        (
            format!("{whole}[[probe]]\nname = \"p\"\nquantity = \"s.tension\"\nat = [1, 0]"),
            "unknown quantity of a spring",
        ),
        (
            format!("{whole}[[probe]]\nname = \"p\"\nquantity = \"r.force\"\nat = [1, 0]"),
            "unknown body, contact or spring `r`",
        ),
        (
            format!(
                "{whole}[[bar]]\nname = \"s\"\nfrom = [0.5, 0.5]\nto = [1.5, 0.5]\nbodies = [\"block\"]\nyoung = 1\narea = 1"
            ),
            "names a bar already and cannot name a spring",
        ),
    ];
    for (keys, words) in springs {
        let error = refused(&text(&keys, "plane-stress")).to_string();
        assert!(error.contains(words), "{keys}: {error}");
    }
    let error = refused(&text(whole, "axisymmetric")).to_string();
    assert!(error.contains("the axis of symmetry"), "{error}");
    // what only the model finds has its place in the text, too
    let late = spring(STACKED, "stiffness = 40\nactive = { until = 2 }");
    let text = stacked("6", &late).replace(
        "fix = [{ side = \"left\", x = 0 }]\nload",
        "active = { from = 2 }\nfix = [{ side = \"left\", x = 0 }]\nload",
    );
    let error = refused(&text.replace(PLANE, &format!("{PLANE}{}", steps(&[1.0, 2.0]))));
    let words = "spring \"spring\" is there in no load step";
    assert!(error.to_string().contains(words), "{error}");
    assert_eq!(&*error.label, "this spring");
}
