//! Anchors with a free and a bonded length, bars and springs around an axis of symmetry, and what a check tells of members.
//!
//! Tolerances are 1e-6 where blocks of Young's modulus 1e9 and more stand for rigid ones, unless they say otherwise.

use crate::links::{PLANE, block, near, refused, solved, steps};
use dotyk::case::Case;
use std::f64::consts::PI;

/// A wall from x = 0 to 2, which moves to the left from the second step on, and ground from 4 to 6 with an anchor between them.
fn anchored(keys: &str) -> String {
    format!(
        "{PLANE}{}{}{}[[bar]]\nname = \"anchor\"\nfrom = {{ side = \"wall.right\" }}\nto = [5.5, 0.5]\nbodies = [\"ground\"]\n\
         young = 1000\narea = 0.1\n{keys}\n",
        steps(&[1.0, 2.0]),
        block(
            "wall",
            [0.0, 0.0],
            "fix = [{ side = \"left\", x = \"-0.1*max(t - 1, 0)\", y = 0 }]"
        ),
        block(
            "ground",
            [4.0, 0.0],
            "fix = [{ side = \"right\", x = 0, y = 0 }]"
        ),
    )
}

/// N = EA/L of the free length; stiff ground bears all of it where the bond begins.
#[test]
fn an_anchor_is_as_stiff_as_its_free_length() {
    for keys in [
        "free_length = 2.5",
        "bond_length = 1.0",
        "bond_length = \"2 - 1\"",
    ] {
        let (_, found) = solved(&anchored(&format!("bond = \"grouted\"\n{keys}")));
        let free = found[1].member("anchor").unwrap();
        assert_eq!(free.stations.len(), 1);
        near(free.length, 2.5, 1e-12);
        near(free.stations[0].force, 1000.0 * 0.1 / 2.5 * 0.1, 1e-6);
        let bond = found[1].member("anchor-bond").unwrap();
        near(bond.length, 1.0, 1e-12);
        assert!(bond.stations.len() >= 8);
        assert!(bond.stations.iter().all(|at| at.force.abs() < 1e-5));
    }
}

/// While it is tightened the free length pulls with its prestress, and the bond lets it into the ground; then it is elastic.
#[test]
fn the_bond_of_an_anchor_bears_its_prestress() {
    let keys = "bond = \"grouted\"\nfree_length = 2.5\nprestress = 7";
    let (_, found) = solved(&anchored(keys));
    let force = |step: usize| found[step].member("anchor").unwrap().stations[0].force;
    assert!(found[0].member("anchor").unwrap().tightening);
    assert!(!found[0].member("anchor-bond").unwrap().tightening);
    near(force(0), 7.0, 1e-9);
    near(force(1), 7.0 + 4.0, 1e-6);
    // soft ground: the first element of the bond takes a part of it over, less from one to the next
    let soft = anchored(keys).replace("young = 1e9", "young = 50");
    let (_, found) = solved(&soft);
    near(
        found[0].member("anchor").unwrap().stations[0].force,
        7.0,
        1e-9,
    );
    let bond = &found[0].member("anchor-bond").unwrap().stations;
    assert!(
        bond[0].force > 0.5 && bond[0].force < 7.0,
        "{}",
        bond[0].force
    );
    assert!(bond.windows(2).all(|pair| pair[1].force < pair[0].force));
}

/// One entry is the two bars that it stands for, to the last bit.
#[test]
fn an_anchor_is_a_free_bar_and_a_grouted_one() {
    let one = anchored("bond = \"grouted\"\nfree_length = 2.5\nprestress = 7\nyield = 300")
        .replace("young = 1e9", "young = 50");
    let two = one
        .replace("to = [5.5, 0.5]", "to = [4.5, 0.5]")
        .replace("bond = \"grouted\"\nfree_length = 2.5\n", "")
        + "[[bar]]\nname = \"anchor-bond\"\nfrom = [4.5, 0.5]\nto = [5.5, 0.5]\nbodies = [\"ground\"]\nbond = \"grouted\"\n\
           young = 1000\narea = 0.1\nyield = 300\n";
    let [one, two] = [one, two].map(|text| solved(&text).1);
    for (a, b) in one.iter().zip(&two) {
        for (a, b) in a.members.iter().zip(&b.members) {
            assert_eq!(a.name, b.name);
            for (a, b) in a.stations.iter().zip(&b.stations) {
                near(a.force, b.force, 1e-12);
            }
        }
        for (a, b) in a.bodies.iter().zip(&b.bodies) {
            for (a, b) in a.displacement.iter().zip(&b.displacement) {
                near(a[0], b[0], 1e-12);
            }
        }
    }
}

#[test]
fn wrong_anchors_are_told_by_key() {
    for (keys, words) in [
        (
            "free_length = 1",
            "`free_length` is of a bar that is grouted",
        ),
        (
            "bond = \"grouted\"\nfree_length = 1\nbond_length = 1",
            "is that of the free and of the bonded part",
        ),
        (
            "bond = \"grouted\"\nfree_length = 3.5",
            "its free length is 3.5, and the bar is 3.5 long",
        ),
        (
            "bond = \"grouted\"\nbond_length = 9",
            "its bond length is 9",
        ),
        ("bond = \"grouted\"\nbond_length = 0", "must be positive"),
        (
            "bond = \"grouted\"\nfree_length = 1",
            "its bond begins at (3, 0.5), in none of its bodies",
        ),
        (
            "bond = \"grouted\"\nfree_length = 2.5\nradius = 0.1",
            "the plate of an anchor at its head",
        ),
        (
            "bond = \"grouted\"\nfree_length = 2.5\ncount = 3",
            "around the axis of symmetry",
        ),
    ] {
        let error = refused(&anchored(keys)).to_string();
        assert!(error.contains(words), "{keys}: {error}");
    }
    let taken = anchored("bond = \"grouted\"\nfree_length = 2.5")
        + &block(
            "anchor-bond",
            [9.0, 0.0],
            "fix = [{ side = \"right\", x = 0, y = 0 }]",
        );
    let error = refused(&taken).to_string();
    assert!(
        error.contains("a body has the name `anchor-bond`"),
        "{error}"
    );
}

/// A stiff ring around the axis, between the radii a and b and the heights of a rectangle.
fn ring(name: &str, [a, b]: [f64; 2], [low, high]: [f64; 2], young: f64, keys: &str) -> String {
    format!(
        "[[body]]\nname = \"{name}\"\n\
         mesh = {{ rectangle = {{ from = [{a}, {low}], to = [{b}, {high}], cells = [16, 4], cell = \"quad8\" }} }}\n\
         material = {{ young = {young:e}, poisson = 0.25 }}\n{keys}\n"
    )
}

const AXIAL: &str = "title = \"Links\"\nanalysis = \"axisymmetric\"\n";

/// n inclined bars or springs carry a load along the axis: N = F/(n cos θ), and give way by F/(n k cos² θ).
#[test]
fn bars_around_an_axis_carry_a_load_along_it_as_a_cone() {
    for (n, out) in [(1, 0.0), (6, 0.8), (17, -0.6)] {
        let length = (4.0f64 + out * out).sqrt();
        let cos = 2.0 / length;
        for kind in ["bar", "spring"] {
            let law = match kind {
                "bar" => format!("young = {}\narea = 0.1", 500.0 * length),
                _ => "stiffness = 50".to_string(),
            };
            let text = format!(
                "{AXIAL}{}{}[[{kind}]]\nname = \"m\"\nfrom = [1.5, 1]\nto = [{}, 3]\nbodies = [\"lower\", \"upper\"]\ncount = {n}\n{law}\n",
                ring(
                    "lower",
                    [0.5, 2.5],
                    [0.0, 1.0],
                    1e12,
                    "fix = [{ side = \"bottom\", y = 0 }]"
                ),
                ring(
                    "upper",
                    [0.5, 2.5],
                    [3.0, 4.0],
                    1e12,
                    "load = [{ side = \"top\", force = [0, 30] }]"
                ),
                1.5 + out
            );
            let (_, found) = solved(&text);
            let force = found[0].member("m").unwrap().stations[0].force;
            near(force, 30.0 / (f64::from(n) * cos), 1e-5);
            let raised = found[0].bodies[1].displacement[0][1];
            near(raised, 30.0 / (f64::from(n) * 50.0 * cos * cos), 1e-5);
        }
    }
}

/// n radial bars that pull at the inner side of a thick ring in plane strain are a tension n N/(2π a h) there: Lamé.
#[test]
fn radial_bars_load_a_ring_as_lames_pressure_does() {
    let (a, b, h, n, pull) = (2.0, 3.0, 0.5, 7, 4.0);
    let flat = "fix = [{ side = \"bottom\", y = 0 }, { side = \"top\", y = 0 }]";
    let text = format!(
        "{AXIAL}{}{}[[bar]]\nname = \"m\"\nfrom = {{ side = \"core.right\" }}\nto = {{ side = \"ring.left\" }}\ncount = {n}\n\
         young = 1\narea = 1\nprestress = {pull}\n",
        ring("core", [0.5, 1.0], [0.0, h], 1e12, flat),
        ring("ring", [a, b], [0.0, h], 1000.0, flat),
    );
    let (model, found) = solved(&text);
    let p = -f64::from(n) * pull / (2.0 * PI * a * h);
    let (young, poisson) = (1000.0, 0.25);
    let u =
        p * a * (1.0 + poisson) / young / (b * b - a * a) * ((1.0 - 2.0 * poisson) * a * a + b * b);
    let points = model.bodies[1].mesh.points();
    for (x, moved) in points.iter().zip(&found[0].bodies[1].displacement) {
        if x[0] == a {
            // the error of sixteen quadratic cells
            assert!((moved[0] / u - 1.0).abs() < 1e-5, "{} {u}", moved[0]);
        }
    }
}

/// A grouted cone of bars follows the strain of a body that it does not stiffen, e = t·ε·t, the hoop strain not counted.
#[test]
fn a_soft_grouted_bar_around_an_axis_follows_the_strain() {
    let text = format!(
        "{AXIAL}{}[[bar]]\nname = \"m\"\nfrom = [1, 0.5]\nto = [2.5, 1.5]\nbodies = [\"ring\"]\nbond = \"grouted\"\ncount = 12\n\
         young = 1e-3\narea = 0.1\n",
        ring(
            "ring",
            [0.0, 3.0],
            [0.0, 2.0],
            1000.0,
            "fix = [{ side = \"bottom\", y = 0 }]\nload = [{ side = \"top\", pressure = -10 }]"
        )
    );
    let (_, found) = solved(&text);
    let [along, across] = [1.0, 1.5].map(|d: f64| d * d / (1.0 + 1.5 * 1.5));
    let strain = 0.01 * (along - 0.25 * across);
    for at in &found[0].member("m").unwrap().stations {
        near(at.force / (1e-4 * strain), 1.0, 1e-5);
    }
}

#[test]
fn wrong_bars_around_an_axis_are_told_by_key() {
    let text = |keys: &str| {
        format!(
            "{AXIAL}{}[[bar]]\nname = \"m\"\nfrom = [1, 0.5]\nto = [2.5, 0.5]\nbodies = [\"ring\"]\nyoung = 1\narea = 1\n{keys}\n",
            ring(
                "ring",
                [0.0, 3.0],
                [0.0, 2.0],
                1000.0,
                "fix = [{ side = \"bottom\", y = 0 }]"
            )
        )
    };
    for (keys, words) in [
        ("", "stands for those all around the axis"),
        ("count = 0", "positive integer"),
        ("count = 2.5", "positive integer"),
        (
            "count = 3\nspacing = 1",
            "with axial symmetry `count` says how many",
        ),
    ] {
        let error = refused(&text(keys)).to_string();
        assert!(error.contains(words), "{keys}: {error}");
    }
    let upright = text("count = 3\nradius = 1.5").replace("to = [2.5, 0.5]", "to = [1, 1.5]");
    let error = refused(&upright).to_string();
    assert!(
        error.contains("reaches over the axis of symmetry"),
        "{error}"
    );
}

#[test]
fn a_check_lists_bars_springs_and_bolts() {
    let text = anchored("bond = \"grouted\"\nfree_length = 2.5\nspacing = 0.25")
        + "[[spring]]\nname = \"tie\"\nfrom = { side = \"wall.right\" }\nto = { side = \"ground.left\" }\nstiffness = 3\nacts = \"tension\"\n"
        + "[[bolt]]\nname = \"stud\"\nbody = \"ground\"\nat = [5, 0.5]\naxis = [1, 0]\nshortening = 0.001\n";
    let model = Case::<2>::from_str(&text, "links.toml", "".as_ref())
        .unwrap()
        .model;
    let told = model.check().to_string();
    for line in [
        "bar \"anchor\": from wall.right to (4.5, 0.5), length 2.5000e0, bond ends, stands for 2",
        "bar \"anchor-bond\": from (4.5, 0.5) to (5.5, 0.5), length 1.0000e0, bond grouted, ",
        "spring \"tie\": from wall.right to ground.left, length 2.0000e0, acts tension",
        "bolt \"stud\": from ground.stud-behind to ground.stud-ahead, drawn by length",
    ] {
        assert!(told.contains(line), "{told}");
    }
}
