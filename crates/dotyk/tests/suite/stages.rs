//! Bodies, contacts, supports and loads that come and go.
//!
//! Tolerances are rounding unless they say otherwise: 1e-9 of the largest value, 1e-8 where contact forces are compared, which
//! the certificate knows to that.

use dotyk::case::{Case, CaseError};
use dotyk::geometry::{Point, add_scaled, norm, sub};
use dotyk::model::{Model, Solution, Status};

fn case(text: &str) -> Case<2> {
    Case::<2>::from_str(text, "stages.toml", "".as_ref()).unwrap()
}

fn solved(text: &str) -> (Model<2>, Vec<Solution<2>>) {
    let model = case(text).model;
    let steps = model.solve_steps().unwrap();
    assert_eq!(steps.len(), model.times.len());
    assert!(steps.iter().all(|step| step.converged));
    (model, steps)
}

fn refused(text: &str) -> CaseError {
    match Case::<2>::from_str(text, "stages.toml", "".as_ref()) {
        Ok(case) => {
            let error = case.model.solve_steps().unwrap_err();
            case.error(error.subject().as_ref(), &error.to_string())
        }
        Err(error) => error,
    }
}

fn body<'s>(solution: &'s Solution<2>, name: &str) -> &'s [Point<2>] {
    let found = solution.bodies.iter().find(|body| body.name == name);
    &found.unwrap().displacement
}

fn largest(vectors: &[Point<2>]) -> f64 {
    vectors.iter().map(|&v| norm(v)).fold(0.0, f64::max)
}

fn same(a: &[Point<2>], b: &[Point<2>], tolerance: f64) {
    assert_eq!(a.len(), b.len());
    let scale = largest(b);
    for (a, b) in a.iter().zip(b) {
        assert!(
            norm(sub(*a, *b)) <= tolerance * scale,
            "{a:?} {b:?} of {scale}"
        );
    }
}

/// A quarter of a hole in stressed ground, with a ring in it that does not fit its mesh; `ring` are keys of the ring,
/// `contact` of the contact, `factor` what is left of the ground in the hole.
fn tunnel(steps: &str, factor: &str, ring: &str, contact: &str) -> String {
    format!(
        "title = \"Tunnel\"\nanalysis = \"plane-strain\"\n{steps}\n\
         [[body]]\nname = \"rock\"\n\
         mesh = {{ ring = {{ inner = 5, outer = 40, from = 0, to = 90, cells = [14, 10], ratio = 1.2, cell = \"quad9\" }} }}\n\
         material = {{ young = 500, poisson = 0.3 }}\n\
         initial_stress = {{ xx = -0.6, yy = -1, zz = -0.5 }}\n\
         load = [{{ side = \"inner\", in_situ = {factor} }}]\n\
         fix = [{{ side = \"start\", y = 0 }}, {{ side = \"end\", x = 0 }}, {{ side = \"outer\", x = 0, y = 0 }}]\n\
         [[body]]\nname = \"ring\"\n\
         mesh = {{ ring = {{ inner = 4.7, outer = 5, from = 0, to = 90, cells = [17, 2], cell = \"quad9\" }} }}\n\
         material = {{ young = 30000, poisson = 0.2 }}\n\
         fix = [{{ side = \"start\", y = 0 }}, {{ side = \"end\", x = 0 }}]\n{ring}\n\
         [[contact]]\nname = \"back\"\nnonmortar = \"ring.outer\"\nmortar = \"rock.inner\"\ngap = \"closed\"\n{contact}\n"
    )
}

const LATE: &str = "[[step]]\nname = \"ground\"\ntime = 0\n[[step]]\nname = \"heading\"\ntime = 0.4\n\
                    [[step]]\nname = \"support\"\ntime = 0.5\n[[step]]\ntime = 1";

/// While the contact stays closed, all that the ring does is in proportion to what is left when it comes.
#[test]
fn forces_of_a_lining_are_in_proportion_to_what_is_left() {
    for contact in ["", "tied = true"] {
        let (_, early) = solved(&tunnel("", "0", "", contact));
        let late = tunnel(
            LATE,
            "\"1 - t\"",
            "active = { from = \"support\" }",
            contact,
        );
        let (_, steps) = solved(&late);
        // it is there at the end of the step at 0.4, when 0.6 is left
        for (step, share) in [(2, 0.1), (3, 0.6)] {
            let expected: Vec<Point<2>> = body(&early[0], "ring")
                .iter()
                .map(|u| u.map(|c| share * c))
                .collect();
            same(body(&steps[step], "ring"), &expected, 1e-8);
            let (found, whole) = (&steps[step].contacts[0], &early[0].contacts[0]);
            let scale = whole.nodes.iter().map(|n| n.pressure).fold(0.0, f64::max);
            for (found, whole) in found.nodes.iter().zip(&whole.nodes) {
                let off = (found.pressure - share * whole.pressure).abs();
                assert!(off < 1e-7 * scale, "{} {}", found.pressure, whole.pressure);
                assert!(found.gap.abs() < 1e-12, "{}", found.gap);
            }
        }
    }
}

/// A lining that comes where nothing happens afterwards bears nothing; what is not there tells nothing.
#[test]
fn what_appears_is_free_of_stress() {
    for contact in ["", "tied = true", "friction = 0.3"] {
        let steps = "[[step]]\ntime = 1\n[[step]]\nname = \"late\"\ntime = 2\n[[step]]\ntime = 3";
        let probes = "[[probe]]\nname = \"p\"\nquantity = \"back.pressure\"\nreduce = \"max\"\n\
                      [[probe]]\nname = \"u\"\nquantity = \"rock.displacement.x\"\nat = [5, 0]";
        let ring = "active = { from = \"late\" }";
        let text = tunnel(steps, "0.3", ring, &format!("{contact}\n{probes}"));
        let (model, steps) = solved(&text);
        assert_eq!((steps[0].bodies.len(), steps[0].contacts.len()), (1, 0));
        assert_eq!(model.stage(1.0).bodies.len(), 1);
        assert!(steps[0].probe("p").unwrap().is_nan() && steps[0].probe("u").unwrap() < -1e-3);
        for step in &steps[1..] {
            let moved = largest(body(step, "rock"));
            assert!(largest(body(step, "ring")) < 1e-12 * moved);
            same(body(step, "rock"), body(&steps[0], "rock"), 1e-12);
            assert!(step.probe("p").unwrap().abs() < 1e-12);
            let nodes = &step.contacts[0].nodes;
            assert!(
                nodes
                    .iter()
                    .all(|n| n.gap.abs() < 1e-14 && norm(n.slip) < 1e-14)
            );
        }
    }
}

/// What is done in two steps with all bodies there is the same as what is done at once.
#[test]
fn stages_of_a_tied_lining_add_up() {
    let steps = "[[step]]\ntime = 0.3\n[[step]]\ntime = 1";
    let (_, both) = solved(&tunnel(steps, "\"1 - t\"", "", "tied = true"));
    let (_, once) = solved(&tunnel("", "0", "", "tied = true"));
    same(body(&both[1], "ring"), body(&once[0], "ring"), 1e-9);
    same(body(&both[1], "rock"), body(&once[0], "rock"), 1e-9);
}

/// Two blocks of ground side by side on a floor, tied to each other; the right one goes, and leaves some of its forces.
fn cut(active: &str, steps: &str) -> String {
    let block = |name: &str, from: f64, keys: &str| {
        format!(
            "[[body]]\nname = \"{name}\"\nmesh = {{ rectangle = {{ from = [{from}, 0], to = [{}, 4], cells = [6, 5], cell = \"quad8\" }} }}\n\
             material = {{ young = 100, poisson = 0.25 }}\nbody_force = [0, -0.02]\n\
             initial_stress = {{ vertical = \"-0.02*(4 - y)\", k0 = 0.5 }}\n{keys}\n",
            from + 5.0
        )
    };
    format!(
        "title = \"Cut\"\nanalysis = \"plane-strain\"\n{steps}\n{}{}[[contact]]\nname = \"cut\"\nnonmortar = \"right.left\"\nmortar = \"left.right\"\ntied = true\n",
        block(
            "left",
            0.0,
            "fix = [{ side = \"bottom\", x = 0, y = 0 }, { side = \"left\", x = 0 }]"
        ),
        block(
            "right",
            5.0,
            &format!(
                "fix = [{{ side = \"bottom\", x = 0, y = 0 }}, {{ side = \"right\", x = 0 }}]\n{active}"
            )
        ),
    )
}

#[test]
fn ground_that_goes_releases_its_neighbours() {
    let steps = "[[step]]\ntime = 0\n[[step]]\nname = \"cut\"\ntime = 1\n[[step]]\ntime = 2\n[[step]]\ntime = 3";
    let (_, steps) = solved(&cut(
        "active = { until = \"cut\", release = \"(3 - t)/2\" }",
        steps,
    ));
    // at rest, and still so while all of the forces are left
    let rest = |step: usize| largest(body(&steps[step], "left"));
    let whole = rest(3);
    assert!(
        whole > 1e-4 && rest(0) < 1e-12 * whole && rest(1) < 1e-12 * whole,
        "{whole}"
    );
    assert_eq!(steps[1].bodies.len(), 1);
    let warned = |step: &Solution<2>| step.warnings.iter().any(|w| w.contains("equilibrium"));
    assert!(!steps.iter().any(warned), "{:?}", steps[1].warnings);
    // the face is free of stress in the end, and half so before
    let half: Vec<Point<2>> = body(&steps[3], "left")
        .iter()
        .map(|u| u.map(|c| 0.5 * c))
        .collect();
    same(body(&steps[2], "left"), &half, 1e-9);
    // the same ground with an excavated face
    let alone = cut("", "");
    let alone = alone.split("[[body]]\nname = \"right\"").next().unwrap();
    let (_, alone) = solved(alone);
    same(body(&steps[3], "left"), body(&alone[0], "left"), 1e-9);
    // without `release` nothing is left at once
    let (_, at_once) = solved(&cut(
        "active = { until = 1 }",
        "[[step]]\ntime = 0\n[[step]]\ntime = 1",
    ));
    same(body(&at_once[1], "left"), body(&alone[0], "left"), 1e-9);
}

/// A column of two blocks, of which the upper one comes later, under loads in steps.
#[test]
fn a_support_that_comes_later_holds_what_it_finds() {
    let column = |steps: &str, fix: &str, load: &str| {
        format!(
            "title = \"Column\"\nanalysis = \"plane-stress\"\n{steps}\n[[body]]\nname = \"column\"\n\
             mesh = {{ rectangle = {{ from = [0, 0], to = [1, 2], cells = [2, 4], cell = \"quad8\" }} }}\n\
             material = {{ young = 10, poisson = 0.3 }}\nfix = [{{ side = \"bottom\", x = 0, y = 0 }}{fix}]\n\
             load = [{load}]\n"
        )
    };
    let steps = "[[step]]\ntime = 1\n[[step]]\ntime = 2\n[[step]]\ntime = 3\n[[step]]\ntime = 4";
    let fix = ", { side = \"top\", x = 0, y = \"0.01*(t - 2)\", active = { from = 2, until = 4 } }";
    let load = "{ side = \"top\", traction = [\"0.1*t\", -0.5] }";
    let (_, steps) = solved(&column(steps, fix, load));
    let (_, free) = solved(&column(
        "",
        "",
        "{ side = \"top\", traction = [0.1, -0.5] }",
    ));
    same(body(&steps[0], "column"), body(&free[0], "column"), 1e-12);
    let top = |step: usize, x: f64| {
        let points = case(&column("", "", load)).model.bodies[0]
            .mesh
            .points()
            .to_vec();
        let node = points
            .iter()
            .position(|&p| norm(sub(p, [x, 2.0])) < 1e-12)
            .unwrap();
        body(&steps[step], "column")[node]
    };
    for x in [0.0, 0.5, 1.0] {
        // held where it was at the end of the first step, then drawn up
        assert!(
            norm(sub(top(1, x), top(0, x))) < 1e-14,
            "{:?} {:?}",
            top(1, x),
            top(0, x)
        );
        assert!(norm(sub(top(2, x), add_scaled(top(0, x), 0.01, [0.0, 1.0]))) < 1e-14);
    }
    // it leaves: the column is as free as it would be without it
    let (_, last) = solved(&column("[[step]]\ntime = 4", "", load));
    same(body(&steps[3], "column"), body(&last[0], "column"), 1e-10);
    let reaction = |step: usize| steps[step].bodies[0].side_reactions.get("top").copied();
    assert!(reaction(0).is_none() && norm(reaction(2).unwrap()) > 0.01 && reaction(3).is_none());
}

/// Loads come and go as the same loads with a factor.
#[test]
fn loads_come_and_go() {
    let slab = |steps: &str, load: &str| {
        format!(
            "title = \"Slab\"\nanalysis = \"plane-stress\"\n{steps}\n[[body]]\nname = \"slab\"\n\
             mesh = {{ rectangle = {{ from = [0, 0], to = [4, 1], cells = [4, 2] }} }}\n\
             material = {{ young = 10, poisson = 0.3 }}\nfix = [{{ side = \"left\", x = 0, y = 0 }}]\nload = [{load}]\n"
        )
    };
    let steps = "[[step]]\ntime = 1\n[[step]]\nname = \"on\"\ntime = 2\n[[step]]\ntime = 3";
    let load = "{ side = \"top\", pressure = 0.01 }, { side = \"right\", traction = [0, \"0.01*t\"], active = { from = \"on\", until = 3 } }";
    let (_, steps) = solved(&slab(steps, load));
    let (_, one) = solved(&slab("", "{ side = \"top\", pressure = 0.01 }"));
    let (_, two) = solved(&slab(
        "",
        "{ side = \"top\", pressure = 0.01 }, { side = \"right\", traction = [0, 0.02] }",
    ));
    same(body(&steps[0], "slab"), body(&one[0], "slab"), 1e-12);
    same(body(&steps[1], "slab"), body(&two[0], "slab"), 1e-12);
    same(body(&steps[2], "slab"), body(&one[0], "slab"), 1e-12);
}

/// A block pushed to and fro on another one slips as far whether or not a third body comes and goes meanwhile.
#[test]
fn slip_goes_on_when_other_bodies_come_and_go() {
    let blocks = |active: &str| {
        let block = |name: &str, [x, y]: [f64; 2], more: &str| {
            format!(
                "[[body]]\nname = \"{name}\"\nmesh = {{ rectangle = {{ from = [{x}, {y}], to = [{}, {}], cells = [6, 2] }} }}\n\
                 material = {{ young = 100, poisson = 0.3 }}\n{more}\n",
                x + 3.0,
                y + 1.0
            )
        };
        let steps: String = [0.5, 1.0, 1.5, 2.0]
            .map(|t| format!("[[step]]\ntime = {t}\n"))
            .concat();
        format!(
            "title = \"Slip\"\nanalysis = \"plane-strain\"\n{steps}{}{}{}\
             [[contact]]\nname = \"joint\"\nnonmortar = \"upper.bottom\"\nmortar = \"lower.top\"\nfriction = 0.4\n",
            block(
                "lower",
                [0.0, 0.0],
                "fix = [{ side = \"bottom\", x = 0, y = 0 }]"
            ),
            block(
                "upper",
                [0.0, 1.0],
                "fix = [{ side = \"top\", y = -0.01, x = \"0.03*sin(pi*t)\" }]"
            ),
            block(
                "other",
                [9.0, 0.0],
                &format!("fix = [{{ side = \"bottom\", x = 0, y = 0 }}]\n{active}")
            ),
        )
    };
    let (_, plain) = solved(&blocks(""));
    let (_, staged) = solved(&blocks("active = { from = 1, until = 2 }"));
    assert!(plain.last().unwrap().contacts[0].dissipated_total > 1e-4);
    for (staged, plain) in staged.iter().zip(&plain) {
        let (a, b) = (&staged.contacts[0], &plain.contacts[0]);
        for (a, b) in a.nodes.iter().zip(&b.nodes) {
            assert!(
                norm(sub(a.shear, b.shear)) < 1e-6,
                "{:?} {:?}",
                a.shear,
                b.shear
            );
            assert_eq!(a.status, b.status);
        }
        let off = (a.dissipated_total - b.dissipated_total).abs();
        assert!(
            off < 1e-7 * plain.contacts[0].dissipated_total.max(1e-3),
            "{off}"
        );
        same(body(staged, "upper"), body(plain, "upper"), 1e-7);
    }
}

/// A contact that appears between bodies that are there sees how far they are apart, and presses them apart where they overlap.
#[test]
fn a_contact_that_comes_later_sees_the_true_gap() {
    let text = |from: &str| {
        format!(
            "title = \"Gap\"\nanalysis = \"plane-stress\"\n[[step]]\ntime = 1\n[[step]]\ntime = 2\n[[step]]\ntime = 3\n\
             [[body]]\nname = \"low\"\nmesh = {{ rectangle = {{ from = [0, 0], to = [1, 1], cells = [3, 3] }} }}\n\
             material = {{ young = 100, poisson = 0 }}\nfix = [{{ side = \"bottom\", x = 0, y = 0 }}]\n\
             [[body]]\nname = \"high\"\nmesh = {{ rectangle = {{ from = [0, 1.1], to = [1, 2.1], cells = [3, 3] }} }}\n\
             material = {{ young = 100, poisson = 0 }}\nfix = [{{ side = \"top\", x = 0, y = \"-0.06*t\" }}]\n\
             [[contact]]\nname = \"joint\"\nnonmortar = \"high.bottom\"\nmortar = \"low.top\"\ngap = \"geometric\"\n{from}\n"
        )
    };
    let (_, always) = solved(&text(""));
    let (_, late) = solved(&text("active = { from = 3 }"));
    assert!(late[1].contacts.is_empty());
    same(body(&late[2], "low"), body(&always[2], "low"), 1e-9);
    let force = late[2].contacts[0].resultant[1];
    assert!((force / (100.0 * 0.08 / 2.0) - 1.0).abs() < 1e-9, "{force}");
}

#[test]
fn nonsense_is_one_clear_error() {
    let ring = |active: &str| tunnel(LATE, "0", active, "");
    for (text, words) in [
        (
            ring("active = { from = \"lining\" }"),
            "there is no step `lining`",
        ),
        (ring("active = { from = 7 }"), "it is there in no load step"),
        (
            ring("active = { from = 0.5, until = 0.4 }"),
            "it is there in no load step",
        ),
        (ring("active = {}"), "neither `from` nor `until`"),
        (
            ring("active = { from = 0.5, release = 0.3 }"),
            "`release` without `until`",
        ),
        (
            ring("active = { until = 0.5, release = \"x\" }"),
            "`x` has no meaning here",
        ),
        (ring("active = { since = 0.5 }"), "unknown key `since`"),
        (ring("active = 0.5"), "expected a table"),
        (
            tunnel(
                LATE,
                "0",
                "active = { from = \"support\" }",
                "active = { until = \"support\" }",
            ),
            "contact \"back\" is there in no load step",
        ),
        (
            tunnel(&LATE.replace("heading", "ground"), "0", "", ""),
            "two steps are named `ground`",
        ),
    ] {
        let message = refused(&text).to_string();
        assert!(message.contains(words), "{words}: {message}");
    }
    // the only neighbour of a floating body leaves
    let pair = "title = \"Pair\"\nanalysis = \"plane-stress\"\n[[step]]\ntime = 1\n[[step]]\nname = \"gone\"\ntime = 2\n\
        [[body]]\nname = \"low\"\nmesh = { rectangle = { from = [0, 0], to = [1, 1], cells = [2, 2] } }\n\
        material = { young = 100, poisson = 0 }\nfix = [{ side = \"bottom\", x = 0, y = 0 }]\n\
        active = { until = \"gone\" }\n\
        [[body]]\nname = \"high\"\nmesh = { rectangle = { from = [0, 1], to = [1, 2], cells = [2, 2] } }\n\
        material = { young = 100, poisson = 0 }\nfix = [{ side = \"left\", x = 0 }]\nbody_force = [0, -1]\n\
        [[contact]]\nname = \"joint\"\nsides = [\"high.bottom\", \"low.top\"]\n";
    let message = refused(pair).to_string();
    assert!(
        message.contains("step 2 (t = 2): body \"high\" is not held"),
        "{message}"
    );
    // the check says it, too
    let check = case(pair).model.check();
    assert!(
        check.errors[0].contains("step 2 (t = 2): body \"high\""),
        "{:?}",
        check.errors
    );
}

/// What the check tells is of each thing where it is there last.
#[test]
fn a_check_looks_at_every_stage() {
    let late = tunnel(LATE, "\"1 - t\"", "active = { from = \"support\" }", "");
    let check = case(&late).model.check();
    assert_eq!(check.errors, [""; 0]);
    let names: Vec<&str> = check.bodies.iter().map(|body| body.name.as_str()).collect();
    assert_eq!(names, ["rock", "ring"]);
    assert_eq!(check.contacts.len(), 1);
    let early = tunnel(LATE, "\"1 - t\"", "active = { until = \"heading\" }", "");
    assert_eq!(case(&early).model.check().contacts[0].name, "back");
}

/// Two blocks of which the upper one is moved sideways before a contact between them appears: friction counts from then, and a tie
/// holds them as they are.
#[test]
fn what_appears_between_moved_bodies_counts_from_then() {
    for law in ["friction = 0.3", "tied = true"] {
        let text = format!(
            "title = \"Late\"\nanalysis = \"plane-stress\"\n[[step]]\ntime = 1\n[[step]]\ntime = 2\n[[step]]\ntime = 3\n\
             [[body]]\nname = \"low\"\nmesh = {{ rectangle = {{ from = [0, 0], to = [1, 1], cells = [4, 4] }} }}\n\
             material = {{ young = 100, poisson = 0 }}\nfix = [{{ side = \"bottom\", x = 0, y = 0 }}]\n\
             [[body]]\nname = \"high\"\nmesh = {{ rectangle = {{ from = [0, 1], to = [1, 2], cells = [4, 4] }} }}\n\
             material = {{ young = 100, poisson = 0 }}\n\
             fix = [{{ side = \"top\", x = 0.01, y = \"-0.02*max(0, t - 1)\" }}]\n\
             [[contact]]\nname = \"joint\"\nnonmortar = \"high.bottom\"\nmortar = \"low.top\"\n{law}\nactive = {{ from = 2 }}\n"
        );
        let (_, steps) = solved(&text);
        for (step, depth) in [(1, 0.02), (2, 0.04)] {
            let [x, y] = steps[step].contacts[0].resultant;
            let expected = 100.0 * depth / 2.0;
            assert!(
                (y - expected).abs() < 1e-8 * expected,
                "{law}: {y} {expected}"
            );
            assert!(x.abs() < 1e-9 * expected, "{law}: {x}");
        }
    }
}

/// A block that is moved sideways before a rigid floor comes, which was on its way, too: friction counts from then.
#[test]
fn an_obstacle_that_comes_rubs_from_then() {
    // how far the floor has moved at t, and whether it does so in the second step
    for (floor, slides) in [("0", false), ("0.03", false), ("0.004*t", true)] {
        let text = format!(
            "title = \"Late\"\nanalysis = \"plane-strain\"\n[[step]]\ntime = 1\n[[step]]\ntime = 2\n\
             [[body]]\nname = \"block\"\nmesh = {{ rectangle = {{ from = [0, 0], to = [1, 1], cells = [4, 4] }} }}\n\
             material = {{ young = 1000, poisson = 0 }}\nfix = [{{ side = \"top\", x = 0.01, y = \"-0.001*(t - 1)\" }}]\n\
             [[contact]]\nname = \"floor\"\nnonmortar = \"block.bottom\"\nfriction = 0.5\nactive = {{ from = 2 }}\n\
             obstacle = {{ plane = {{ point = [0, 0], normal = [0, 1] }}, displacement = [\"{floor}\", 0] }}\n"
        );
        let (_, steps) = solved(&text);
        let [x, y] = steps[1].contacts[0].resultant;
        assert!((y - 1.0).abs() < 0.01, "{y}");
        // rubbed along by more than it sticks to, or not at all
        let rubbed = if slides { 0.5 * y } else { 0.0 };
        assert!((x - rubbed).abs() < 1e-8, "{floor}: {x}");
    }
}

/// The sole of a block and the base under it are held together, so that the contact has no conditions, while the base is pushed
/// along. Where the supports leave, the slip under them stays: the block does not move.
#[test]
fn supports_that_leave_a_contact_leave_the_slip_under_them() {
    for (nonmortar, mortar) in [("block.bottom", "base.top"), ("base.top", "block.bottom")] {
        for pairing in ["mortar", "node-to-node"] {
            let text = sole(nonmortar, mortar, pairing, "y = 0, ");
            let (_, steps) = solved(&text);
            let [first, second] = &steps[..] else {
                panic!("two steps")
            };
            let sole = &second.contacts[0];
            let [x, y] = sole.resultant;
            // springs of 1e-3 at the head
            assert!((y.abs() - 2.0).abs() < 1e-4 && x.abs() < 1e-9, "{x} {y}");
            let moved = body(second, "block").iter().map(|u| u[0]);
            assert!((moved.sum::<f64>() / 15.0).abs() < 1e-9);
            let under = sole.nodes.iter().zip(&first.contacts[0].nodes);
            for (now, then) in under.filter(|(now, _)| now.pressure > 0.0) {
                assert!((then.slip[0].abs() - 0.01).abs() < 1e-12, "{:?}", then.slip);
                assert_eq!(now.status, Status::Stick);
                assert!(norm(sub(now.slip, then.slip)) < 1e-10, "{:?}", now.slip);
            }
        }
    }
}

/// A block whose sole is held along x, and along what `held` says beside, in the first step alone, on a base that is moved under it.
fn sole(nonmortar: &str, mortar: &str, pairing: &str, held: &str) -> String {
    let top = match held.is_empty() {
        true => String::new(),
        false => format!(", {{ side = \"top\", {held}active = {{ until = 2 }} }}"),
    };
    format!(
        "title = \"Sole\"\nanalysis = \"plane-strain\"\n[[step]]\ntime = 1\n[[step]]\ntime = 2\n\
         [[body]]\nname = \"base\"\nmesh = {{ rectangle = {{ from = [-1, 0], to = [3, 1], cells = [8, 2] }} }}\n\
         material = {{ young = 1000, poisson = 0 }}\nfix = [{{ side = \"bottom\", x = 0.01, y = 0 }}{top}]\n\
         [[body]]\nname = \"block\"\nmesh = {{ rectangle = {{ from = [0, 1], to = [2, 2], cells = [4, 2] }} }}\n\
         material = {{ young = 1000, poisson = 0 }}\nload = [{{ side = \"top\", pressure = 1 }}]\n\
         spring = [{{ side = \"top\", tangential = 1e-3, normal = 1e-3 }}]\n\
         fix = [{{ side = \"bottom\", x = 0, {held}active = {{ until = 2 }} }}]\n\
         [[contact]]\nname = \"sole\"\nnonmortar = \"{nonmortar}\"\nmortar = \"{mortar}\"\nfriction = 2\n\
         pairing = \"{pairing}\"\n"
    )
}

/// In space tangents follow what supports hold. Where these leave, slips are where they were: on a sole that is rough then, nothing
/// moves.
#[test]
fn slips_in_space_stay_when_supports_leave() {
    for (axis, across) in [("x", "y"), ("y", "x")] {
        let side = if across == "y" { "right" } else { "back" };
        let text = format!(
            "title = \"Space\"\nanalysis = \"3d\"\n[[step]]\ntime = 1\n[[step]]\ntime = 2\n\
             [[body]]\nname = \"base\"\nmesh = {{ box = {{ from = [-1, -1, -1], to = [2, 2, 0], cells = [2, 2, 1] }} }}\n\
             material = {{ young = 1000, poisson = 0 }}\n\
             fix = [{{ side = \"bottom\", {axis} = 0, {across} = 0.01, z = 0 }}]\n\
             [[body]]\nname = \"block\"\nmesh = {{ box = {{ from = [0, 0, 0], to = [1, 1, 1], cells = [1, 1, 1] }} }}\n\
             material = {{ young = 1000, poisson = 0 }}\nload = [{{ side = \"top\", traction = [0, 0, -1] }}]\n\
             spring = [{{ side = \"top\", tangential = 1e-2, normal = 1e-2 }}]\n\
             fix = [{{ side = \"bottom\", {axis} = 0, active = {{ until = 2 }} }}, {{ side = \"{side}\", {across} = 0, active = {{ until = 2 }} }}]\n\
             [[contact]]\nname = \"sole\"\nnonmortar = \"block.bottom\"\nmortar = \"base.top\"\nfriction = \"0.3 + 0.7*(t - 1)\"\n"
        );
        let case = Case::<3>::from_str(&text, "stages.toml", "".as_ref()).unwrap();
        let steps = case.model.solve_steps().unwrap();
        let [first, second] = [0, 1].map(|step| &steps[step].contacts[0]);
        let [x, y, _] = second.resultant;
        // springs of 1e-2 at the head
        assert!(x.abs() < 1e-4 && y.abs() < 1e-4, "{x} {y}");
        for (now, then) in second.nodes.iter().zip(&first.nodes) {
            assert!(norm(then.slip) > 0.008, "{:?}", then.slip);
            assert!(
                norm(sub(now.slip, then.slip)) < 1e-9,
                "{:?} {:?}",
                now.slip,
                then.slip
            );
            assert_eq!(now.status, Status::Stick);
        }
    }
}

/// The dual problem of a step, in a program or a file, is that of its stage after what came before.
#[test]
fn the_dual_problem_of_a_stage_has_its_history() {
    let late = tunnel(LATE, "\"1 - t\"", "active = { from = \"support\" }", "");
    let (model, steps) = solved(&late);
    let mut dual = model.dual(1.0).unwrap();
    let forces = dual.solve(dotyk::model::Method::Newton).unwrap();
    let solution = dual.recover(&forces).unwrap();
    same(body(&solution, "ring"), body(&steps[3], "ring"), 1e-8);
    // between its steps, too, and before anything comes
    assert_eq!(model.dual(0.7).unwrap().model().bodies.len(), 2);
    assert_eq!(model.dual(0.45).unwrap().model().bodies.len(), 1);
}

#[test]
fn a_body_leaves_no_more_than_its_forces() {
    let steps = "[[step]]\ntime = 0\n[[step]]\ntime = 1";
    let message = refused(&cut("active = { until = 1, release = \"2*t\" }", steps)).to_string();
    assert!(
        message.contains("release = 2*t, is 2 at t = 1: it must lie in [0, 1]"),
        "{message}"
    );
}
