//! Springs and bars.
//!
//! Tolerances are rounding unless they say otherwise: 1e-9 of the largest value, 1e-8 where contact forces take part, which the
//! certificate knows to that.

use dotyk::case::{Case, CaseError};
use dotyk::geometry::Field;
use dotyk::model::{BodyId, BodySolution, Load, MemberSolution, Model, Solution};

pub fn solved(text: &str) -> (Model<2>, Vec<Solution<2>>) {
    let model = Case::<2>::from_str(text, "links.toml", "".as_ref())
        .unwrap()
        .model;
    let steps = model.solve_steps().unwrap();
    assert!(steps.iter().all(|step| step.converged));
    (model, steps)
}

pub fn refused(text: &str) -> CaseError {
    match Case::<2>::from_str(text, "links.toml", "".as_ref()) {
        Ok(case) => {
            let error = case.model.solve_steps().unwrap_err();
            case.error(error.subject().as_ref(), &error.to_string())
        }
        Err(error) => error,
    }
}

pub fn near(found: f64, expected: f64, tolerance: f64) {
    let off = (found - expected).abs();
    assert!(
        off <= tolerance * expected.abs().max(1.0),
        "{found} {expected}"
    );
}

fn body<'s>(solution: &'s Solution<2>, name: &str) -> &'s BodySolution<2> {
    let found = solution.bodies.iter().find(|body| body.name == name);
    found.unwrap()
}

fn bar<'s>(solution: &'s Solution<2>, name: &str) -> &'s MemberSolution<2> {
    solution.member(name).unwrap()
}

/// A stiff block of 2 × 1 with these keys.
pub fn block(name: &str, from: [f64; 2], keys: &str) -> String {
    let [x, y] = from;
    let (right, top) = (x + 2.0, y + 1.0);
    format!(
        "[[body]]\nname = \"{name}\"\n\
         mesh = {{ rectangle = {{ from = [{x}, {y}], to = [{right}, {top}], cells = [4, 2], cell = \"quad9\" }} }}\n\
         material = {{ young = 1e9, poisson = 0.0, thickness = 0.5 }}\n{keys}\n"
    )
}

pub fn steps(times: &[f64]) -> String {
    let each = times.iter().map(|t| format!("[[step]]\ntime = {t}\n"));
    each.collect()
}

pub const PLANE: &str = "title = \"Links\"\nanalysis = \"plane-stress\"\n";

/// k · area · u = load, in both directions, with thickness; and nothing floats.
#[test]
fn a_bedded_block_sinks_by_its_load_over_its_bed() {
    let text = format!(
        "{PLANE}{}",
        block(
            "block",
            [0.0, 0.0],
            "spring = [{ side = \"bottom\", normal = 100, tangential = 20 }]\n\
             load = [{ side = \"top\", pressure = 10 }, { side = \"bottom\", traction = [4, 0] }]"
        )
    );
    let (_, solution) = solved(&text);
    let block = body(&solution[0], "block");
    for u in &block.displacement {
        near(u[0], 0.2, 1e-6);
        near(u[1], -0.1, 1e-6);
    }
    assert!(block.floating_modes.is_empty());
    near(block.reaction[1], 10.0, 1e-9);
    near(block.side_reactions["bottom"][0], -4.0, 1e-9);
    // the nodal balance, with which sections are cut
    let nodal: f64 = block.reactions.iter().map(|f| f[1]).sum();
    near(nodal, 10.0, 1e-9);
}

/// Two springs at points carry a beam by statics.
#[test]
fn springs_at_points_share_a_load_by_statics() {
    let keys = "points = { a = [0, 0], b = [2, 0] }\n\
                spring = [{ point = \"a\", x = 7, y = 50 }, { point = \"b\", y = 100 }]\n\
                load = [{ point = [1.5, 1], force = [0, -8] }]";
    let (model, solution) = solved(&format!("{PLANE}{}", block("block", [0.0, 0.0], keys)));
    let block = body(&solution[0], "block");
    let sunk = |x: f64| {
        let points = model.bodies[0].mesh.points();
        let node = points.iter().position(|point| *point == [x, 0.0]);
        block.displacement[node.unwrap()][1]
    };
    near(sunk(0.0), -2.0 / 50.0, 1e-5);
    near(sunk(2.0), -6.0 / 100.0, 1e-5);
    near(block.reaction[1], 8.0, 1e-9);
}

/// It comes without a force, and what happens from then on is what happens to the bedded body.
#[test]
fn a_spring_that_comes_later_bears_nothing_where_it_finds_the_body() {
    let keys = |active: &str, load: &str| {
        format!(
            "spring = [{{ side = \"bottom\", normal = 100, tangential = 20 }}, \
                       {{ side = \"right\", normal = 300, tangential = 30{active} }}]\n\
             load = [{{ side = \"top\", traction = [\"{load}\", \"-3*({load})\"] }}]"
        )
    };
    let late = keys(", active = { from = 2 }", "t");
    let all = steps(&[1.0, 2.0, 3.0]).replace("time = 2\n", "time = 2\nname = \"late\"\n");
    let text = format!("{PLANE}{all}{}", block("block", [0.0, 0.0], &late));
    let text = text.replace("t\", \"-3*(t)", "max(t, 2) - 1\", \"-3*(max(t, 2) - 1)");
    let (_, found) = solved(&text);
    let [first, second, third] = [0, 1, 2].map(|k| &body(&found[k], "block").displacement);
    let (_, more) = solved(&format!(
        "{PLANE}{}",
        block("block", [0.0, 0.0], &keys("", "1"))
    ));
    let more = &body(&more[0], "block").displacement;
    for node in 0..first.len() {
        for i in 0..2 {
            near(second[node][i], first[node][i], 1e-8);
            near(third[node][i] - second[node][i], more[node][i], 1e-8);
        }
    }
    near(
        body(&found[1], "block").side_reactions["right"][0],
        0.0,
        1e-8,
    );
}

/// Pressed it is the bed that acts both ways, lifted it does nothing; late it presses from where it finds the side.
#[test]
fn a_bed_that_only_presses_is_a_bed_where_it_presses() {
    let case = |only: bool, load: f64, active: &str| {
        format!(
            "{PLANE}{}{}",
            steps(&[1.0, 2.0]),
            block(
                "block",
                [0.0, 0.0],
                &format!(
                    "spring = [{{ side = \"bottom\", normal = 100, compression_only = {only}{active} }}, \
                               {{ side = \"top\", normal = 25, tangential = 10 }}]\n\
                     load = [{{ side = \"top\", pressure = \"{load}*t\" }}]"
                )
            )
        )
    };
    let sunk = |text: &str| {
        let (_, found) = solved(text);
        [0, 1].map(|k| body(&found[k], "block").displacement[0][1])
    };
    let [one, two] = sunk(&case(true, 5.0, ""));
    near(one, -5.0 / 125.0, 1e-7);
    near(two, -10.0 / 125.0, 1e-7);
    assert_eq!(
        sunk(&case(false, 5.0, "")).map(|u| (u * 1e9).round()),
        [one, two].map(|u| (u * 1e9).round())
    );
    let [_, lifted] = sunk(&case(true, -5.0, ""));
    near(lifted, 10.0 / 25.0, 1e-7);
    let [before, after] = sunk(&case(true, 5.0, ", active = { from = 2 }"));
    near(before, -5.0 / 25.0, 1e-7);
    near(after, -5.0 / 25.0 - 5.0 / 125.0, 1e-7);
    // a late one that is lifted at once
    let [before, after] = sunk(&case(true, -5.0, ", active = { from = 2 }"));
    near(before, 5.0 / 25.0, 1e-7);
    near(after, 10.0 / 25.0, 1e-7);
}

/// A rigid footing of width 1 on a bed, under 1 at a distance from its middle: the largest pressure.
fn footing(mesh: &str, (analysis, young): (&str, f64), only: bool, off: f64) -> f64 {
    let space = analysis == "3d";
    let (at, force, moment) = match space {
        false => ("[0, 1]", "[0, -1]", format!("{}", -off)),
        true => ("[0, 0, 1]", "[0, 0, -1]", format!("[0, {off}, 0]")),
    };
    let held = match space {
        false => "{ point = [-0.5, 0], x = 0 }".to_string(),
        true => "{ point = [-0.5, -0.5, 0], x = 0, y = 0 }, { point = [0.5, -0.5, 0], y = 0 }"
            .to_string(),
    };
    let text = format!(
        "analysis = \"{analysis}\"\n[[body]]\nname = \"f\"\nmesh = {{ {mesh} }}\n\
         material = {{ young = {young:e}, poisson = 0.0 }}\npoints = {{ P = {at} }}\nfix = [{held}]\n\
         spring = [{{ side = \"bottom\", normal = 1e6, compression_only = {only} }}]\n\
         couple = [{{ side = \"top\", point = \"P\", kind = \"rigid\" }}]\n\
         load = [{{ point = \"P\", force = {force}, moment = {moment} }}]\n"
    );
    fn sunk<const D: usize>(solution: &Solution<D>) -> f64 {
        let body = &solution.bodies[0];
        near(body.side_reactions["bottom"][D - 1], 1.0, 1e-8);
        let least = body.displacement.iter().map(|u| u[D - 1]);
        -1e6 * least.fold(f64::INFINITY, f64::min)
    }
    match space {
        false => {
            let case = Case::<2>::from_str(&text, "footing.toml", "".as_ref());
            sunk(&case.unwrap().model.solve().unwrap())
        }
        true => {
            let case = Case::<3>::from_str(&text, "footing.toml", "".as_ref());
            sunk(&case.unwrap().model.solve().unwrap())
        }
    }
}

/// Stiff enough to be rigid to 1e-5 beside its bed, and no more than that.
const STIFF: f64 = 1e12;

/// Where all of it presses a bed that only presses is the one that acts both ways, with any number of facets; where it parts it
/// comes near Winkler's triangle.
#[test]
fn a_footing_turns_on_its_bed() {
    for cell in ["tri3", "tri6", "quad4", "quad8", "quad9"] {
        for n in [1, 2, 3, 8] {
            let mesh = format!(
                "rectangle = {{ from = [-0.5, 0], to = [0.5, 0.5], cells = [{n}, 1], cell = \"{cell}\" }}"
            );
            for only in [false, true] {
                // no tension at the sixth: P/B (1 + 6 e/B)
                near(
                    footing(&mesh, ("plane-strain", STIFF), only, 1.0 / 6.0),
                    2.0,
                    1e-5,
                );
                near(
                    footing(&mesh, ("plane-strain", STIFF), only, 0.05),
                    1.3,
                    1e-5,
                );
            }
        }
        let mesh = format!(
            "rectangle = {{ from = [-0.5, 0], to = [0.5, 0.5], cells = [32, 1], cell = \"{cell}\" }}"
        );
        near(
            footing(&mesh, ("plane-strain", STIFF), true, 0.25),
            2.0 / 0.75,
            1e-3,
        );
    }
    for cell in [
        "tet4", "tet10", "hex8", "hex20", "hex27", "prism6", "prism15",
    ] {
        let mesh = |n: usize| {
            format!(
                "box = {{ from = [-0.5, -0.5, 0], to = [0.5, 0.5, 0.5], cells = [{n}, 1, 1], cell = \"{cell}\" }}"
            )
        };
        for n in [1, 3] {
            for only in [false, true] {
                near(footing(&mesh(n), ("3d", STIFF), only, 1.0 / 6.0), 2.0, 1e-5);
            }
        }
        near(
            footing(&mesh(12), ("3d", STIFF), true, 0.25),
            2.0 / 0.75,
            1e-2,
        );
    }
}

/// A soft plate, which presses its whole bed unevenly: node by node the displacements of the bed that acts both ways.
#[test]
fn a_bed_that_is_pressed_everywhere_is_that_which_acts_both_ways() {
    let bent = |analysis: &str, only: bool| {
        let text = format!(
            "analysis = \"{analysis}\"\n[[body]]\nname = \"plate\"\n\
             mesh = {{ rectangle = {{ from = [1, 0], to = [4, 0.2], cells = [9, 2], cell = \"quad9\" }} }}\n\
             material = {{ young = 1e3, poisson = 0.3 }}\nfix = [{{ side = \"left\", x = 0 }}]\n\
             spring = [{{ side = \"bottom\", normal = 20, compression_only = {only} }}]\n\
             load = [{{ side = \"top\", pressure = \"1 + x*x/3\" }}]\n\
             [[section]]\nname = \"s\"\nbody = \"plate\"\nsides = [\"top\", \"bottom\"]\nstations = 7\n"
        );
        let model = Case::<2>::from_str(&text, "plate.toml", "".as_ref())
            .unwrap()
            .model;
        model.solve().unwrap()
    };
    for analysis in ["plane-strain", "axisymmetric"] {
        let [only, both] = [true, false].map(|only| bent(analysis, only));
        let displacements = only.bodies[0].displacement.iter().flatten();
        for (a, b) in displacements.zip(both.bodies[0].displacement.iter().flatten()) {
            near(*a, *b, 1e-8);
        }
        for (a, b) in only.sections[0]
            .stations
            .iter()
            .zip(&both.sections[0].stations)
        {
            near(a.normal, b.normal, 1e-7);
            near(a.shear, b.shear, 1e-7);
            near(a.moment, b.moment, 1e-7);
        }
    }
}

/// A ring on springs along its radius, as an oval presses it, with a twist `dp`.
fn bedded_ring(cell: &str, n: usize, dp: f64, more: &str) -> Model<2> {
    let text = format!(
        "analysis = \"plane-strain\"\n[[body]]\nname = \"a\"\n\
         mesh = {{ ring = {{ inner = 4.7, outer = 5, cells = [{n}, 2], cell = \"{cell}\" }} }}\n\
         material = {{ young = 35e3, poisson = 0.2 }}\nspring = [{{ side = \"outer\", normal = 10 }}{more}]\n\
         load = [{{ side = \"outer\", traction = [\"-0.2*x/5 - {dp}*y/5\", \"-0.4*y/5 + {dp}*x/5\"] }}]\n"
    );
    Case::<2>::from_str(&text, "ring.toml", "".as_ref())
        .unwrap()
        .model
}

/// The same with its nodes at other angles, so that no two facets are alike, and without a word of what its sides are.
fn uneven(mut model: Model<2>, oval: f64) -> Model<2> {
    let body = &mut model.bodies[0];
    let moved = dotyk::mesh::Mesh::clone(&body.mesh).map_points(|[x, y]| {
        let (r, a) = (x.hypot(y), y.atan2(x));
        let a = a + 0.2 * (2.0 * a).sin() * a.cos();
        [(1.0 + oval) * r * a.cos(), r * a.sin()]
    });
    body.mesh = moved.unwrap().into();
    model
}

fn largest(solution: &Solution<2>) -> f64 {
    let u = solution.bodies[0].displacement.iter();
    u.map(|u| u[0].hypot(u[1])).fold(0.0, f64::max)
}

#[test]
fn a_bed_along_the_radius_leaves_a_ring_its_spin_however_fine_it_is() {
    for cell in ["quad4", "quad8", "quad9"] {
        let mut sizes = Vec::new();
        for n in [24, 48, 50, 64, 96] {
            let solution = bedded_ring(cell, n, 0.0, "").solve().unwrap();
            assert_eq!(solution.bodies[0].floating_modes.len(), 1, "{cell} {n}");
            let told = &solution.warnings[..];
            assert!(
                told.iter()
                    .any(|w| w.contains("nothing controls its rotation about (0, 0)")),
                "{cell} {n}: {told:?}"
            );
            assert!(!told.iter().any(|w| w.contains("hovers")), "{told:?}");
            assert!(solution.bodies[0].rigid.rotation[0].abs() < 1e-9);
            sizes.push(largest(&solution));
            let driven = bedded_ring(cell, n, 1e-4, "")
                .solve()
                .unwrap_err()
                .to_string();
            assert!(
                driven.contains("rotation about (0, 0)") && driven.contains("does work"),
                "{driven}"
            );
        }
        let [least, most] = [f64::min, f64::max].map(|f| sizes.iter().copied().reduce(f).unwrap());
        // straight facets are a polygon of their own, and linear cells bend too little
        let band = if cell == "quad4" { 2.0 } else { 1.05 };
        assert!(most < band * least && most < 0.2, "{cell}: {sizes:?}");
    }
}

#[test]
fn the_spin_of_a_ring_of_which_nothing_is_known_is_free_too() {
    for cell in ["quad4", "quad8", "quad9"] {
        let mut model = uneven(bedded_ring(cell, 48, 0.0, ""), 0.0);
        model.bodies[0].loads.clear();
        model.load(
            BodyId(0),
            Load::Pressure {
                side: "outer".to_string(),
                pressure: Field::constant(0.3),
            },
        );
        let solution = model.solve().unwrap();
        assert_eq!(solution.bodies[0].floating_modes.len(), 1, "{cell}");
        assert!(largest(&solution) < 0.1, "{cell}: {}", largest(&solution));
        // out of round by 1 % it bears a torque on its bed
        let oval = uneven(bedded_ring(cell, 48, 1e-4, ""), 0.01);
        let solution = oval.solve().unwrap();
        assert!(solution.bodies[0].floating_modes.is_empty(), "{cell}");
    }
}

#[test]
fn a_weak_spring_holds_what_strong_ones_leave() {
    // torque 2π R² dp over 2π R² k R: turned by dp/(k R), for the spring at the outer side
    let [dp, k] = [1e-4, 1e-3];
    let more = format!(", {{ side = \"outer\", normal = 0, tangential = {k} }}");
    for cell in ["quad4", "quad9"] {
        let solution = bedded_ring(cell, 64, dp, &more).solve().unwrap();
        assert!(solution.bodies[0].floating_modes.is_empty());
        near(
            solution.bodies[0].rigid.rotation[0] * 5.0 * k / dp,
            1.0,
            2e-2,
        );
    }
}

/// A pipe in space on springs along its radius, held along its axis by springs, too: it spins, and nothing drives that.
#[test]
fn a_bedded_pipe_spins_in_space() {
    for cell in ["hex8", "hex20", "tet4", "tet10"] {
        let text = format!(
            "analysis = \"3d\"\n[[body]]\nname = \"pipe\"\n\
             mesh = {{ cylinder = {{ base = [0, 0, 0], axis = [0, 0, 1], radius = 1, inner = 0.8, height = 1, cells = [16, 1, 2], cell = \"{cell}\" }} }}\n\
             material = {{ young = 1e4, poisson = 0.2 }}\n\
             spring = [{{ side = \"outer\", normal = 10 }}, {{ side = \"bottom\", normal = 7 }}]\n\
             load = [{{ side = \"outer\", pressure = 1 }}]\n"
        );
        let model = Case::<3>::from_str(&text, "pipe.toml", "".as_ref())
            .unwrap()
            .model;
        let solution = model.solve().unwrap();
        let modes = &solution.bodies[0].floating_modes;
        assert_eq!(modes.len(), 1, "{cell}");
        assert!(
            modes[0].description.contains("rotation about z"),
            "{}",
            modes[0].description
        );
    }
}

/// A block that hangs on a bar alone along y: N is its load over the bars in the thickness, and it sinks by F L/(EA).
#[test]
fn a_block_hangs_on_its_bar() {
    for (spacing, bars) in [("", 1.0), ("spacing = 0.1\n", 5.0)] {
        let text = format!(
            "{PLANE}{}{}[[bar]]\nname = \"tie\"\nfrom = {{ side = \"upper.bottom\" }}\nto = {{ side = \"lower.top\" }}\n\
             young = 1000\narea = 0.2\n{spacing}",
            block(
                "upper",
                [0.0, 3.0],
                "fix = [{ side = \"top\", x = 0, y = 0 }]"
            ),
            block(
                "lower",
                [0.0, 0.0],
                "fix = [{ side = \"left\", x = 0 }, { side = \"right\", x = 0 }]\nload = [{ side = \"bottom\", force = [0, -6] }]"
            )
        );
        let (_, found) = solved(&text);
        let force = bar(&found[0], "tie").stations[0].force;
        near(force, 6.0 / bars, 1e-9);
        let sunk = body(&found[0], "lower").displacement[0][1];
        near(sunk, -6.0 * 2.0 / (bars * 200.0), 1e-6);
        near(body(&found[0], "upper").reaction[1], 6.0, 1e-9);
    }
}

/// A bar between two bodies that are moved: what it does is known from the course of its length.
fn driven(keys: &str, course: &[f64]) -> Vec<f64> {
    let times: Vec<f64> = (1..=course.len()).map(|k| k as f64).collect();
    let mut expression = "0".to_string();
    for (t, u) in times.iter().zip(course) {
        expression += &format!(" + ({u})*max(0, 1 - abs(t - {t}))");
    }
    let text = format!(
        "{PLANE}{}{}{}[[bar]]\nname = \"bar\"\nfrom = {{ side = \"left.right\" }}\nto = {{ side = \"right.left\" }}\n\
         young = 100\narea = 0.5\n{keys}",
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
        )
    );
    let (_, found) = solved(&text);
    found
        .iter()
        .map(|step| bar(step, "bar").stations[0].force)
        .collect()
}

/// EA/L = 25: the law of a spring and a slider in a row, stepped by hand.
#[test]
fn bars_slacken_and_yield_as_they_should() {
    let course = [0.1, 0.5, 0.3, -0.2, 0.1, 0.9, 0.2, 1.1];
    let follow = |prestress: f64, most: f64, slack: bool| {
        let mut plastic = 0.0;
        let each = course.iter().enumerate().map(|(k, u)| {
            // a prestressed bar is tightened in its first step
            let (e, p) = match prestress == 0.0 {
                true => (*u, 0.0),
                false => (u - course[0], prestress),
            };
            if prestress != 0.0 && k == 0 {
                return prestress;
            }
            let trial = p + 25.0 * (e - plastic);
            let force = trial.clamp(if slack { 0.0 } else { -most }, most);
            // slackness is not plastic
            if !(slack && trial < 0.0) {
                plastic += (trial - force) / 25.0;
            }
            force
        });
        each.collect::<Vec<f64>>()
    };
    let far = f64::MAX;
    for (keys, expected) in [
        ("", follow(0.0, far, false)),
        ("tension_only = true", follow(0.0, far, true)),
        ("yield = 16", follow(0.0, 8.0, false)),
        ("yield = 16\ntension_only = true", follow(0.0, 8.0, true)),
        ("prestress = 5", follow(5.0, far, false)),
        ("prestress = 5\nyield = 16", follow(5.0, 8.0, false)),
        (
            "prestress = 5\nyield = 16\ntension_only = true",
            follow(5.0, 8.0, true),
        ),
        ("prestress = 5\ntension_only = true", follow(5.0, far, true)),
    ] {
        let found = driven(keys, &course);
        for (found, expected) in found.iter().zip(&expected) {
            assert!(
                (found - expected).abs() < 1e-6,
                "{keys}: {found} {expected}"
            );
        }
    }
}

/// From one body to itself, at points, obliquely: N follows from the strain that the block has anyway, as the bar is soft.
#[test]
fn a_soft_bar_follows_the_strain_of_its_body() {
    let text = |bar: &str| {
        format!(
            "{PLANE}[[body]]\nname = \"block\"\n\
             mesh = {{ rectangle = {{ from = [0, 0], to = [2, 1], cells = [5, 3], cell = \"quad4\" }} }}\n\
             material = {{ young = 1000, poisson = 0.25 }}\n\
             fix = [{{ side = \"left\", x = 0 }}, {{ point = [0, 0], y = 0 }}]\n\
             load = [{{ side = \"right\", traction = [8, 0] }}]\n\
             [[bar]]\nname = \"bar\"\nbodies = [\"block\"]\nyoung = 1e-3\narea = 1e-3\n{bar}"
        )
    };
    let strain = |t: [f64; 2]| 8.0e-3 * (t[0] * t[0] - 0.25 * t[1] * t[1]);
    for (ends, t) in [
        ("from = [0.3, 0.2]\nto = [1.5, 0.2]", [1.0, 0.0]),
        ("from = [1.5, 0.2]\nto = [0.3, 0.2]", [-1.0, 0.0]),
        ("from = [0.3, 0.1]\nto = [0.9, 0.9]", [0.6, 0.8]),
    ] {
        for bond in ["", "bond = \"grouted\"", "radius = 0.05"] {
            let (_, found) = solved(&text(&format!("{ends}\n{bond}\n")));
            for station in &bar(&found[0], "bar").stations {
                near(station.force / 1e-6, strain(t), 1e-6);
            }
        }
    }
}

/// What is cut off is in equilibrium with the bars that leave it.
#[test]
fn section_forces_know_of_bars_and_springs() {
    let text = format!(
        "{PLANE}[[body]]\nname = \"beam\"\n\
         mesh = {{ rectangle = {{ from = [0, 0], to = [8, 1], cells = [32, 4], cell = \"quad9\" }} }}\n\
         material = {{ young = 1000, poisson = 0.2 }}\n\
         fix = [{{ side = \"left\", x = 0, y = 0 }}]\n\
         spring = [{{ point = [8, 0], y = 3 }}]\n\
         load = [{{ side = \"top\", pressure = 1 }}]\n\
         {}[[bar]]\nname = \"tie\"\nfrom = {{ side = \"hook.bottom\" }}\nto = [5, 0.4]\nbodies = [\"beam\"]\n\
         young = 300\narea = 0.1\nradius = 0.2\n\
         [[section]]\nname = \"cut\"\nbody = \"beam\"\nsides = [\"top\", \"bottom\"]\nstations = [[2, 0.5], [6.5, 0.5]]\n",
        block(
            "hook",
            [4.0, 3.0],
            "fix = [{ side = \"top\", x = 0, y = 0 }]"
        )
        .replace("thickness = 0.5", "thickness = 1.0")
    );
    let (model, found) = solved(&text);
    let [left, right] = [0, 1].map(|k| found[0].sections[0].stations[k]);
    let pull = bar(&found[0], "tie").stations[0].force;
    assert!(pull > 0.1, "{pull}");
    let points = model.bodies[0].mesh.points();
    let corner = points.iter().position(|point| *point == [8.0, 0.0]);
    let tip = -3.0 * body(&found[0], "beam").displacement[corner.unwrap()][1];
    // V pushes the part ahead up: it carries what is ahead
    near(right.shear, 1.5 - tip, 1e-9);
    near(left.shear, 6.0 - tip - pull, 1e-9);
    near(left.moment, 18.0 - 6.0 * tip - 3.0 * pull, 1e-9);
}

/// The problem that is handed out has the bars and beds in it.
#[test]
fn the_dual_problem_has_links() {
    let text = format!(
        "{PLANE}{}{}[[bar]]\nname = \"tie\"\nfrom = {{ side = \"upper.bottom\" }}\nto = [1, 1]\nbodies = [\"lower\"]\n\
         young = 1000\narea = 0.2\ntension_only = true\n",
        block(
            "upper",
            [0.0, 3.0],
            "fix = [{ side = \"top\", x = 0, y = 0 }]"
        ),
        block(
            "lower",
            [0.0, 0.0],
            "fix = [{ side = \"left\", x = 0 }]\nspring = [{ side = \"bottom\", normal = 10, compression_only = true }]\n\
             load = [{ side = \"bottom\", force = [0, -6] }]"
        )
    );
    let (model, found) = solved(&text);
    let pull = bar(&found[0], "tie").stations[0].force;
    assert!(pull > 0.0 && pull < 6.0, "{pull}");
    near(body(&found[0], "lower").reaction[1], 6.0 - pull, 1e-8);
    for method in dotyk::model::Method::NAMED {
        let mut model = model.clone();
        model.solver.method = method;
        model.solver.tolerance = 1e-7;
        let Ok(steps) = model.solve_steps() else {
            panic!("{}", method.name());
        };
        near(bar(&steps[0], "tie").stations[0].force, pull, 1e-5);
    }
}

/// Between two points of one body a bar resists no motion of the body: what nothing else holds is not held.
#[test]
fn a_bar_within_a_body_does_not_hold_it() {
    let case = |bar: &str, load: &str| {
        format!(
            "{PLANE}[[body]]\nname = \"block\"\n\
             mesh = {{ rectangle = {{ from = [0, 0], to = [2, 1], cells = [2, 2] }} }}\n\
             material = {{ young = 1000, poisson = 0.2 }}\nfix = [{{ side = \"bottom\", y = 0 }}]\n\
             load = [{{ side = \"top\", traction = [{load}, -1] }}]\n\
             [[bar]]\nname = \"tie\"\nbodies = [\"block\"]\nyoung = 1e4\narea = 0.1\n{bar}\n"
        )
    };
    for bar in [
        "from = [0.4, 0.5]\nto = [0.6, 0.4]",
        "from = [0.31, 0.17]\nto = [1.73, 0.93]\nbond = \"grouted\"",
        "from = [0.1, 0.1]\nto = [0.2, 0.9]\ntension_only = true",
    ] {
        let (_, found) = solved(&case(bar, "0"));
        let moved = body(&found[0], "block").displacement.iter();
        assert!(moved.flatten().all(|u| u.abs() < 0.01), "{bar}");
        assert!(
            found[0]
                .warnings
                .iter()
                .any(|w| w.contains("nothing controls"))
        );
        let error = refused(&case(bar, "0.5")).to_string();
        assert!(error.contains("is not held"), "{error}");
    }
}

/// An inclined anchor within a body that is held statically determinately: forces of its own, which no support feels, although its plate
/// reaches beyond the body.
#[test]
fn the_plate_of_a_bar_pulls_along_its_axis_where_it_reaches_beyond_the_body() {
    for radius in ["", "radius = 0.01", "radius = 0.1", "radius = 0.3"] {
        let text = format!(
            "{PLANE}[[body]]\nname = \"block\"\n\
             mesh = {{ rectangle = {{ from = [0, 0], to = [3, 2], cells = [12, 8] }} }}\n\
             material = {{ young = 1e4, poisson = 0.3 }}\nfix = [{{ point = [0, 0], x = 0, y = 0 }}]\n\
             spring = [{{ point = [3, 0], y = 100.0 }}]\n\
             [[bar]]\nname = \"anchor\"\nfrom = [1.5, 2.0]\nto = [2.3, 1.2]\nbodies = [\"block\"]\n\
             young = 1000\narea = 0.1\nprestress = 10\n{radius}\n"
        );
        let (_, found) = solved(&text);
        assert!(bar(&found[0], "anchor").stations[0].force > 9.0);
        // the anchor is no reaction of its body
        let reactions = body(&found[0], "block").reactions.iter().flatten();
        let most = reactions.fold(0.0, |most: f64, force| most.max(force.abs()));
        assert!(most < 1e-9, "{radius}: {most}");
    }
}

/// A bar through blocks in a row, of one cell each: their cells have nodes of the same numbers, and are cells of their own.
#[test]
fn a_grouted_bar_has_points_in_every_body_that_it_crosses() {
    const BLOCKS: usize = 20;
    let row = |divided: bool| {
        let one = |k: usize| {
            let (left, cells) = (k as f64, if divided && k % 2 == 1 { 2 } else { 1 });
            let end = if k == 0 {
                ", { side = \"left\", x = 0 }"
            } else {
                ""
            };
            format!(
                "[[body]]\nname = \"b{k}\"\n\
                 mesh = {{ rectangle = {{ from = [{left}, 0], to = [{}, 1], cells = [{cells}, 1], cell = \"quad8\" }} }}\n\
                 material = {{ young = 1e4, poisson = 0.0 }}\nfix = [{{ side = \"bottom\", y = 0 }}{end}]\n\
                 load = [{{ side = \"top\", traction = [0.1, 0] }}]\n",
                left + 1.0
            )
        };
        let blocks: String = (0..BLOCKS).map(one).collect();
        let names: Vec<String> = (0..BLOCKS).map(|k| format!("\"b{k}\"")).collect();
        let text = format!(
            "{PLANE}{blocks}[[bar]]\nname = \"tendon\"\nfrom = [0.5, 0.5]\nto = [19.5, 0.5]\nbodies = [{}]\nbond = \"grouted\"\n\
             young = 1e4\narea = 1\n",
            names.join(", ")
        );
        let (_, found) = solved(&text);
        let stations = bar(&found[0], "tendon").stations.len();
        let last = body(&found[0], "b19").displacement.iter();
        (stations, last.map(|u| u[0]).fold(0.0, f64::max))
    };
    let ((few, coarse), (more, fine)) = (row(false), row(true));
    assert!(few >= 4 * BLOCKS && more > few, "{few} {more}");
    assert!((coarse / fine - 1.0).abs() < 0.2, "{coarse} {fine}");
}

/// A bar along a line between cells lies in neither of them: it has the elements of one row, whichever end comes first.
#[test]
fn a_bar_between_cells_has_the_elements_of_one_row() {
    for ends in [
        "from = [0.5, 0.3]\nto = [7.5, 0.3]",
        "from = [7.5, 0.3]\nto = [0.5, 0.3]",
    ] {
        let text = format!(
            "{PLANE}[[body]]\nname = \"block\"\n\
             mesh = {{ rectangle = {{ from = [0, 0], to = [8, 0.6], cells = [8, 2], cell = \"quad8\" }} }}\n\
             material = {{ young = 1e4, poisson = 0.3 }}\nfix = [{{ side = \"left\", x = 0, y = 0 }}]\n\
             load = [{{ side = \"right\", traction = [1, 0] }}]\n\
             [[bar]]\nname = \"tendon\"\n{ends}\nbodies = [\"block\"]\nbond = \"grouted\"\nyoung = 1e4\narea = 0.1\n"
        );
        let (_, found) = solved(&text);
        let stations = bar(&found[0], "tendon").stations.len();
        assert!((32..=40).contains(&stations), "{stations}");
    }
}

/// A thin plate beside coarse ground: the bar ends in the plate, in whatever order the bodies are named.
#[test]
fn a_bar_ends_in_the_body_that_it_lies_in() {
    let case = |bodies: &str| {
        format!(
            "{PLANE}[[body]]\nname = \"rock\"\n\
             mesh = {{ rectangle = {{ from = [0, 0], to = [8, 8], cells = [2, 2] }} }}\n\
             material = {{ young = 1000, poisson = 0 }}\n\
             fix = [{{ side = \"bottom\", x = 0, y = 0 }}, {{ side = \"top\", x = 0, y = 0 }}]\n\
             [[body]]\nname = \"plate\"\n\
             mesh = {{ rectangle = {{ from = [0, 8.1], to = [8, 8.2], cells = [8, 1] }} }}\n\
             material = {{ young = 1000, poisson = 0 }}\n\
             fix = [{{ side = [\"left\", \"right\", \"bottom\", \"top\"], x = 0 }}]\n\
             spring = [{{ side = \"bottom\", normal = 1 }}]\nload = [{{ side = \"top\", traction = [0, 1] }}]\n\
             [[bar]]\nname = \"anchor\"\nfrom = [4, 4]\nto = [4, 8.15]\nbodies = {bodies}\nyoung = 1000\narea = 1\n"
        )
    };
    let force = |bodies: &str| bar(&solved(&case(bodies)).1[0], "anchor").stations[0].force;
    let found = force("[\"plate\", \"rock\"]");
    assert!(found > 1.0, "{found}");
    near(force("[\"rock\", \"plate\"]"), found, 1e-12);
    let error = refused(&case("[\"rock\"]")).to_string();
    assert!(error.contains("none of the bodies rock"), "{error}");
}

/// What a check says of bars and beds, and of what only a bar that may yield holds.
#[test]
fn a_check_knows_links() {
    let wall = block(
        "wall",
        [0.0, 0.0],
        "fix = [{ side = \"left\", x = 0, y = 0 }]",
    );
    let keys = "fix = [{ side = \"left\", y = 0 }, { side = \"right\", y = 0 }]\n\
                spring = [{ side = \"bottom\", normal = 3, compression_only = true, active = { from = 2 } }]\n\
                load = [{ side = \"right\", traction = [1, \"3 - 2*t\"] }]";
    let text = format!(
        "{PLANE}{}{wall}{}[[bar]]\nname = \"tie\"\nfrom = {{ side = \"wall.right\" }}\nto = {{ side = \"block.left\" }}\n\
         young = 1000\narea = 0.1\nyield = 20\n",
        steps(&[1.0, 2.0, 3.0]),
        block("block", [3.0, 0.0], keys)
    );
    let model = Case::<2>::from_str(&text, "links.toml", "".as_ref())
        .unwrap()
        .model;
    let told = model.check().bodies[1].floating.join(", ");
    assert!(told.contains("held by bar \"tie\""), "{told}");
    let (_, found) = solved(&text);
    for step in &found {
        near(bar(step, "tie").stations[0].force, 0.5, 1e-7);
    }
}

/// What another model has left serves one with the same springs and bars alone.
#[test]
fn nothing_is_reused_where_a_bar_or_a_spring_differs() {
    let case = |area: f64, bed: f64| {
        let keys = format!(
            "fix = [{{ side = \"left\", x = 0 }}]\nload = [{{ side = \"bottom\", force = [0, -6] }}]\n\
             spring = [{{ side = \"bottom\", normal = {bed}, compression_only = true }}]"
        );
        let text = format!(
            "{PLANE}{}{}[[bar]]\nname = \"tie\"\nfrom = {{ side = \"upper.bottom\" }}\nto = {{ side = \"lower.top\" }}\n\
             young = 1000\narea = {area}\n",
            block(
                "upper",
                [0.0, 3.0],
                "fix = [{ side = \"top\", x = 0, y = 0 }]"
            ),
            block("lower", [0.0, 0.0], &keys)
        );
        Case::<2>::from_str(&text, "links.toml", "".as_ref())
            .unwrap()
            .model
    };
    let mut reuse = dotyk::model::Reuse::default();
    for (area, bed) in [(0.1, 10.0), (0.1, 30.0), (0.4, 30.0), (0.4, 10.0)] {
        let model = case(area, bed);
        let found = model.solve_steps_reusing(&mut reuse, &mut |_| {}).unwrap();
        let (bar_stiffness, bed_stiffness) = (1000.0 * area / 2.0, bed * 2.0 * 0.5);
        let share = bar_stiffness / (bar_stiffness + bed_stiffness);
        near(bar(&found[0], "tie").stations[0].force, 6.0 * share, 1e-6);
    }
}

#[test]
fn nonsense_is_one_clear_error() {
    let spring = |keys: &str| {
        format!(
            "{PLANE}{}",
            block(
                "block",
                [0.0, 0.0],
                &format!("fix = [{{ side = \"left\", x = 0, y = 0 }}]\nspring = [{keys}]")
            )
        )
    };
    let springs = [
        ("{ normal = 1 }", "needs `side` or `point`"),
        (
            "{ side = \"bottom\", point = [0, 0], normal = 1 }",
            "both `side` and `point`",
        ),
        ("{ side = \"bottom\" }", "without a stiffness"),
        ("{ side = \"bottom\", normal = -1 }", "must not be negative"),
        ("{ side = \"bottom\", x = 1 }", "no `x`"),
        ("{ side = \"buttom\", normal = 1 }", "no side `buttom`"),
        (
            "{ side = \"bottom\", tangential = 1, compression_only = true }",
            "`compression_only`",
        ),
        ("{ point = [0, 0] }", "without a stiffness"),
        ("{ point = [0, 0], normal = 1 }", "no `normal`"),
        ("{ point = [0, 0], z = 1 }", "no `z`"),
        ("{ point = \"tip\", y = 1 }", "no point `tip`"),
        ("{ point = [9, 9], y = 1 }", "spring"),
        (
            "{ side = \"bottom\", normal = 1, active = { from = 7 } }",
            "in no load step",
        ),
        (
            "{ side = \"bottom\", normal = \"t\" }",
            "`t` has no meaning here",
        ),
    ];
    for (keys, words) in springs {
        let error = refused(&spring(keys)).to_string();
        assert!(error.contains(words), "{keys}: {error}");
    }
    let bar = |keys: &str, analysis: &str| {
        format!(
            "title = \"Bars\"\nanalysis = \"{analysis}\"\n{}[[bar]]\n{keys}\n",
            block(
                "block",
                [0.0, 0.0],
                "fix = [{ side = \"left\", x = 0, y = 0 }]"
            )
            .replace(", thickness = 0.5", "")
        )
    };
    let whole = "name = \"b\"\nfrom = [0.5, 0.5]\nto = [1.5, 0.5]\nbodies = [\"block\"]\nyoung = 1\narea = 1\n";
    let bars = [
        (whole.replace("name = \"b\"\n", ""), "`name`"),
        (whole.replace("\"b\"", "\"block\""), "names a body already"),
        (whole.replace("from = [0.5, 0.5]\n", ""), "`from`"),
        (
            whole.replace("[0.5, 0.5]", "[5, 5]"),
            "lies in none of the bodies block",
        ),
        (whole.replace("[0.5, 0.5]", "[1.5, 0.5]"), "same place"),
        (
            whole.replace("bodies = [\"block\"]\n", ""),
            "in which bodies",
        ),
        (whole.replace("[\"block\"]", "[]"), "empty"),
        (
            whole.replace("[\"block\"]", "[\"bluck\"]"),
            "no body `bluck`",
        ),
        (
            whole.replace("[\"block\"]", "[\"block\", \"block\"]"),
            "twice",
        ),
        (whole.replace("young = 1\n", ""), "`young`"),
        (whole.replace("area = 1", "area = 0"), "`area`"),
        (
            whole.replace("[0.5, 0.5]", "{ side = \"block.bottem\" }"),
            "no side `bottem`",
        ),
        (
            whole.replace("[0.5, 0.5]", "{ edge = \"block.bottom\" }"),
            "unknown key `edge`",
        ),
        (format!("{whole}bond = \"glued\""), "bond"),
        (format!("{whole}spacing = -1"), "`spacing`"),
        (format!("{whole}radius = 0"), "`radius`"),
        (format!("{whole}yield = -2"), "`yield`"),
        (
            format!("{whole}prestress = 5\nyield = 2"),
            "at most yield times area",
        ),
        (
            format!("{whole}prestress = -5\ntension_only = true"),
            "a tension",
        ),
        (format!("{whole}tension_only = 1"), "true or false"),
        (format!("{whole}active = {{ from = 3 }}"), "in no load step"),
        (
            format!("{whole}[[probe]]\nname = \"p\"\nquantity = \"b.tension\"\nat = [1, 0]"),
            "unknown quantity of a bar",
        ),
        (
            format!(
                "{whole}[[probe]]\nname = \"p\"\nquantity = \"b.force\"\nalong = \"block.top\""
            ),
            "stations",
        ),
    ];
    for (keys, words) in bars {
        let error = refused(&bar(&keys, "plane-stress")).to_string();
        assert!(error.contains(words), "{keys}: {error}");
    }
    let error = refused(&bar(whole, "axisymmetric")).to_string();
    assert!(error.contains("the axis of symmetry"), "{error}");
}
