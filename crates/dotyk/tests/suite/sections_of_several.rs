//! Section forces of several bodies: side by side, one upon the other, with joints across and oblique to the cuts.
//!
//! What statics determines is exact to the rounding of the nodal balance, 1e-9 of the largest value, wherever the cut lies. Rings are
//! polygons of 24 to 36 facets: their middle lines, and what acts along them, are off by (π/30)²/6 = 2e-3. Hoop forces come from recovered
//! stresses of quadratic cells: 1e-3.

use crate::friction::Random;
use crate::links::refused;
use crate::sections::{cantilever, off, solved};
use dotyk::case::Case;
use dotyk::model::Station;
use std::f64::consts::TAU;

/// The cantilever of length 5 and height 1/2 in these bodies: for each its mesh, and the sides that bear something.
fn beam(bodies: &[(&str, &str)], contacts: &str, section: &str) -> String {
    let mut text = String::from("analysis = \"plane-stress\"\n");
    for (k, (mesh, keys)) in bodies.iter().enumerate() {
        text += &format!(
            "[[body]]\nname = \"b{k}\"\nmesh = {{ {mesh} }}\n\
             material = {{ young = 3e7, poisson = 0.2, thickness = 0.4 }}\nbody_force = [0.5, -25]\n{keys}\n"
        );
    }
    format!("{text}{contacts}\n[[section]]\nname = \"cut\"\n{section}\n")
}

const HELD: &str = "{ side = \"left\", x = 0, y = 0 }";
const END: &str = "{ side = \"right\", traction = [30, -20] }";
const TOP: &str = "{ side = \"top\", traction = [1, \"-10 - 3*x\"] }";

#[test]
fn bodies_side_by_side_are_one_beam() {
    let mesh = |from: f64, to: f64, cells: &str| {
        format!("rectangle = {{ from = [{from}, 0], to = [{to}, 0.5], cells = {cells} }}")
    };
    for [one, two, three] in [
        ["[5, 2]", "[3, 2]", "[6, 2]"],
        [
            "[5, 2], cell = \"tri3\"",
            "[4, 3], cell = \"quad9\"",
            "[7, 1], cell = \"quad4\"",
        ],
        [
            "[5, 1], cell = \"tri6\"",
            "[2, 4], cell = \"quad8\"",
            "[9, 3], cell = \"tri3\"",
        ],
    ] {
        let (first, middle, last) = (
            format!("fix = [{HELD}]\nload = [{TOP}]"),
            format!("load = [{TOP}]"),
            format!("load = [{TOP}, {END}]"),
        );
        let meshes = [
            mesh(0.0, 2.0, one),
            mesh(2.0, 3.3, two),
            mesh(3.3, 5.0, three),
        ];
        let bodies = [
            (&meshes[0][..], &first[..]),
            (&meshes[1], &middle),
            (&meshes[2], &last),
        ];
        let tied = "[[contact]]\nname = \"p\"\nsides = [\"b0.right\", \"b1.left\"]\ntied = true\n\
                    [[contact]]\nname = \"q\"\nsides = [\"b1.right\", \"b2.left\"]\ntied = true\n";
        // in any order, and with the joints among the stations
        for section in [
            "bodies = [\"b0\", \"b1\", \"b2\"]\nsides = [\"top\", \"bottom\"]\nstations = 14",
            "bodies = [\"b2\", \"b0\", \"b1\"]\nsides = [\"top\", [\"b1.bottom\", \"b0.bottom\", \"b2.bottom\"]]\n\
             stations = [[2, 0.25], [3.3, 0.2], [1.9, 0.2], [2.05, 0.2], [4.9, 0.25], [0, 0.25], [5, 0.25]]",
        ] {
            let text = beam(&bodies, tied, section);
            let cut = &solved(&text).sections[0];
            assert!((cut.length - 5.0).abs() < 1e-12 && !cut.closed);
            let error = off(cut, |s| cantilever(5.0 - s.point[0]));
            assert!(error < 1e-9, "{one} {two} {three}: {error:.1e}");
        }
    }
}

/// Three layers with other cells, moduli and cuts of their own; the middle one has no long side.
#[test]
fn layers_are_one_beam() {
    for seed in 1..4 {
        let mut random = Random(70_311 + seed);
        let mut below = |n: usize| (random.unit() * n as f64) as usize % n;
        let kinds = ["quad4", "tri3", "quad9", "tri6", "quad8"];
        let heights = [0.0, 0.13, 0.38, 0.5];
        let meshes: Vec<String> = (0..3)
            .map(|k| {
                let kind = kinds[below(5)];
                let (n, m) = (7 + below(9), 1 + below(3));
                format!(
                    "rectangle = {{ from = [0, {}], to = [5, {}], cells = [{n}, {m}], cell = \"{kind}\" }}",
                    heights[k],
                    heights[k + 1]
                )
            })
            .collect();
        let keys = format!("fix = [{HELD}]\nload = [{END}]");
        let last = format!("fix = [{HELD}]\nload = [{END}, {TOP}]");
        let bodies = [
            (&meshes[0][..], &keys[..]),
            (&meshes[1], &keys),
            (&meshes[2], &last),
        ];
        let contacts = "[[contact]]\nname = \"p\"\nsides = [\"b0.top\", \"b1.bottom\"]\ntied = true\n\
             [[contact]]\nname = \"q\"\nsides = [\"b1.top\", \"b2.bottom\"]\ntied = true\n";
        let section =
            "bodies = [\"b0\", \"b1\", \"b2\"]\nsides = [\"b2.top\", \"b0.bottom\"]\nstations = 23";
        let text = beam(&bodies, contacts, section).replacen("young = 3e7", "young = 2e6", 1);
        let cut = &solved(&text).sections[0];
        let error = off(cut, |s| cantilever(5.0 - s.point[0]));
        assert!(error < 1e-9, "{meshes:?}: {error:.1e}");
        assert!(
            cut.stations
                .iter()
                .all(|s| (s.thickness - 0.5).abs() < 1e-9)
        );
    }
}

/// Facets much longer than the beam is thick, which do not match those opposite: the cuts stand across all the same.
#[test]
fn cuts_stand_across_a_thin_beam_of_long_facets() {
    for (height, cells) in [
        (0.3, [7, 9]),
        (0.1, [9, 7]),
        (0.02, [5, 11]),
        (0.02, [1, 3]),
    ] {
        let [below, above] = cells;
        let mesh = format!(
            "outline = {{ size = 0.5, cell = \"tri3\", from = [0, 0], edges = [\
             {{ to = [5, 0], name = \"bottom\", cells = {below} }}, {{ to = [5, {height}], name = \"right\", cells = 1 }}, \
             {{ to = [0, {height}], name = \"top\", cells = {above} }}, {{ to = [0, 0], name = \"left\", cells = 1 }}] }}"
        );
        let keys = format!("fix = [{HELD}]\nload = [{END}]");
        let section = "body = \"b0\"\nsides = [\"top\", \"bottom\"]\nstations = 101";
        let text = beam(&[(&mesh, &keys)], "", section).replace("body_force = [0.5, -25]\n", "");
        let cut = &solved(&text).sections[0];
        let error = off(cut, |s| {
            [30.0, 20.0, 20.0 * (5.0 - s.point[0])].map(|force| force * height)
        });
        assert!(error < 1e-9, "{height} {cells:?}: {error:.1e}");
    }
}

/// A joint across the beam that no cut runs along: some pass through both bodies. It slides with friction, and does not lift.
#[test]
fn cuts_pass_through_an_oblique_joint() {
    let outline = |points: [[f64; 2]; 4], names: [&str; 4], size: f64| {
        let edges = (0..4).map(|k| {
            let [x, y] = points[(k + 1) % 4];
            format!("{{ to = [{x}, {y}], name = \"{}\" }}", names[k])
        });
        let [x, y] = points[0];
        format!(
            "outline = {{ size = {size}, from = [{x}, {y}], edges = [{}] }}",
            edges.collect::<Vec<_>>().join(", ")
        )
    };
    for (law, push, top) in [("tied = true", 30.0, 2.7), ("friction = 0.9", -4e3, 2.2)] {
        let one = outline(
            [[0.0, 0.0], [2.0, 0.0], [top, 0.5], [0.0, 0.5]],
            ["bottom", "joint", "top", "left"],
            0.09,
        );
        let two = outline(
            [[2.0, 0.0], [5.0, 0.0], [5.0, 0.5], [top, 0.5]],
            ["bottom", "right", "top", "joint"],
            0.13,
        );
        let first = format!("fix = [{HELD}]\nload = [{TOP}]");
        let last = format!("load = [{TOP}, {{ side = \"right\", traction = [{push}, -20] }}]");
        let contact =
            format!("[[contact]]\nname = \"j\"\nsides = [\"b0.joint\", \"b1.joint\"]\n{law}\n");
        let text = beam(
            &[(&one, &first), (&two, &last)],
            &contact,
            "bodies = [\"b0\", \"b1\"]\nsides = [\"top\", \"bottom\"]\nstations = 61",
        );
        let cut = &solved(&text).sections[0];
        let error = off(cut, |s| {
            let [n, v, m] = cantilever(5.0 - s.point[0]);
            [n + 0.5 * (push - 30.0), v, m]
        });
        assert!(error < 1e-9, "{law}: {error:.1e}");
    }
}

/// A ring of four segments of unlike cells with dry joints under a pressure, as one ring; and two shells one in the other.
#[test]
fn segments_and_shells_are_one_ring() {
    let mut text = String::from("analysis = \"plane-strain\"\n");
    for k in 0..4 {
        let (from, to) = (90.0 * k as f64 + 20.0, 90.0 * k as f64 + 110.0);
        let cells = 6 + k;
        text += &format!(
            "[[body]]\nname = \"s{k}\"\n\
             mesh = {{ ring = {{ inner = 2, outer = 2.4, from = {from}, to = {to}, cells = [{cells}, 2], cell = \"quad9\" }} }}\n\
             material = {{ young = 3e4, poisson = 0.2 }}\nload = [{{ side = \"outer\", pressure = 1 }}]\n"
        );
    }
    text += "[[body]]\nname = \"shell\"\n\
             mesh = { ring = { inner = 1.7, outer = 2, cells = [40, 2], cell = \"quad9\" } }\n\
             material = { young = 1e4, poisson = 0.3 }\nfix = [{ point = [1.7, 0], y = 0 }, { point = [-1.7, 0], y = 0 }, { point = [0, 1.7], x = 0 }]\n";
    for k in 0..4 {
        let next = (k + 1) % 4;
        text += &format!(
            "[[contact]]\nname = \"j{k}\"\nnonmortar = \"s{k}.end\"\nmortar = \"s{next}.start\"\nfriction = 0.5\n\
             [[contact]]\nname = \"c{k}\"\nnonmortar = \"s{k}.inner\"\nmortar = \"shell.outer\"\nfriction = 0.4\n"
        );
    }
    text += "[[section]]\nname = \"ring\"\nbodies = [\"s0\", \"s1\", \"s2\", \"s3\"]\nsides = [\"inner\", \"outer\"]\nstations = 25\n\
             [[section]]\nname = \"both\"\nbodies = [\"s0\", \"s1\", \"s2\", \"s3\", \"shell\"]\nsides = [\"shell.inner\", [\"s0.outer\", \"s1.outer\", \"s2.outer\", \"s3.outer\"]]\nstations = 25\n\
             [[section]]\nname = \"thin\"\nbody = \"shell\"\nsides = [\"inner\", \"outer\"]\nstations = 25\n";
    let solution = solved(&text);
    let [ring, both, shell] = &solution.sections[..] else {
        panic!()
    };
    for (cut, middle) in [(ring, 2.2), (both, 2.05), (shell, 1.85)] {
        assert!(cut.closed, "{}", cut.name);
        let length = cut.length / (TAU * middle);
        assert!((length - 1.0).abs() < 2e-3, "{} {length}", cut.name);
    }
    // statics: the pressure is borne by all
    let error = both
        .stations
        .iter()
        .map(|s| (s.normal / -2.4 - 1.0).abs().max(s.shear.abs() / 2.4));
    let error = error.fold(0.0, f64::max);
    assert!(error < 2e-3, "{error:.1e}");
    let shares = ring.stations.iter().zip(&shell.stations);
    for ((one, other), all) in shares.zip(&both.stations) {
        let sum = one.normal + other.normal;
        assert!(
            (sum / all.normal - 1.0).abs() < 2e-3,
            "{sum} {}",
            all.normal
        );
    }
}

#[test]
fn a_bar_grows_part_by_part() {
    let text = r#"
analysis = "plane-strain"
[[body]]
name = "a"
mesh = { rectangle = { from = [0, 0], to = [2, 0.5], cells = [8, 2] } }
material = { young = 1e5, poisson = 0.2 }
fix = [{ side = "left", x = 0, y = 0 }]
load = [{ side = "right", traction = ["10*t", 0], active = { until = 2 } }]
[[body]]
name = "b"
active = { from = 2 }
mesh = { rectangle = { from = [2, 0], to = [4, 0.5], cells = [7, 2] } }
material = { young = 1e5, poisson = 0.2 }
load = [{ side = "right", traction = [20, 0] }]
[[contact]]
name = "j"
sides = ["a.right", "b.left"]
tied = true
[[section]]
name = "cut"
bodies = ["a", "b"]
sides = ["top", "bottom"]
stations = 5
[[step]]
time = 1
[[step]]
time = 2
[[probe]]
name = "most"
quantity = "cut.N"
reduce = "max"
[[probe]]
name = "far"
quantity = "cut.N"
at = [3, 0.25]
"#;
    let case = Case::<2>::from_str(text, "test.toml", "".as_ref()).unwrap();
    let steps = case.model.solve_steps().unwrap();
    let forces = |step: usize| -> Vec<f64> {
        let stations = steps[step].sections[0].stations.iter();
        stations.map(|s: &Station| s.normal).collect()
    };
    let [early, late] = [forces(0), forces(1)];
    assert!(
        early[..2].iter().all(|n| (n - 5.0).abs() < 1e-9),
        "{early:?}"
    );
    assert!(early[2..].iter().all(|n| n.is_nan()), "{early:?}");
    assert!(late.iter().all(|n| (n - 10.0).abs() < 1e-9), "{late:?}");
    let probes = |step: usize| [0, 1].map(|k| steps[step].probes[k].value);
    assert!((probes(0)[0] - 5.0).abs() < 1e-9 && probes(0)[1].is_nan());
    assert!((probes(1)[0] - 10.0).abs() < 1e-9 && (probes(1)[1] - 10.0).abs() < 1e-9);
}

#[test]
fn sides_that_make_no_strip_are_told() {
    let mesh = |x: f64| {
        format!(
            "rectangle = {{ from = [{x}, 0], to = [{}, 0.5], cells = [4, 2] }}",
            x + 2.0
        )
    };
    let (a, b) = (mesh(0.0), mesh(3.0));
    let held = format!("fix = [{HELD}]");
    let bodies = [(&a[..], &held[..]), (&b, &held)];
    let told = |section: &str| {
        let text = beam(&bodies, "", &format!("{section}\nstations = 3"));
        refused(&text).to_string()
    };
    let apart = told("bodies = [\"b0\", \"b1\"]\nsides = [\"top\", \"bottom\"]");
    assert!(apart.contains("not one line: it has 2 pieces"), "{apart}");
    let twice = told("bodies = [\"b0\", \"b0\"]\nsides = [\"top\", \"bottom\"]");
    assert!(twice.contains("names the body `b0` twice"), "{twice}");
    let both = told("body = \"b0\"\nbodies = [\"b1\"]\nsides = [\"top\", \"bottom\"]");
    assert!(both.contains("`body` and `bodies`"), "{both}");
    let wrong = told("bodies = [\"b0\", \"b1\"]\nsides = [\"tap\", \"bottom\"]");
    assert!(
        wrong.contains("none of the bodies has a side `tap`"),
        "{wrong}"
    );
    let none = told("bodies = []\nsides = [\"top\", \"bottom\"]");
    assert!(none.contains("the list of bodies is empty"), "{none}");
}

/// Two bonded tubes under pressure: the hoop force of both is p r by statics, whatever the order of the bodies.
#[test]
fn hoop_forces_are_those_of_all_shells() {
    let tube = |name: &str, from: f64, to: f64, young: f64, cells: &str, load: &str| {
        format!(
            "[[body]]\nname = \"{name}\"\n\
             mesh = {{ rectangle = {{ from = [{from}, 0], to = [{to}, 3], cells = {cells}, cell = \"quad9\" }} }}\n\
             material = {{ young = {young}, poisson = 0.3 }}\nfix = [{{ side = \"bottom\", y = 0 }}, {{ side = \"top\", y = 0 }}]\n{load}\n"
        )
    };
    let inner = tube(
        "in",
        1.0,
        1.1,
        1e5,
        "[1, 7]",
        "load = [{ side = \"left\", pressure = 1 }]",
    );
    let outer = tube("out", 1.1, 1.3, 1e3, "[2, 6]", "");
    for order in ["\"in\", \"out\"", "\"out\", \"in\""] {
        let text = format!(
            "analysis = \"axisymmetric\"\n{inner}{outer}[[contact]]\nname = \"bond\"\n\
             sides = [\"in.right\", \"out.left\"]\ntied = true\n\
             [[section]]\nname = \"wall\"\nbodies = [{order}]\nsides = [\"in.left\", \"out.right\"]\nstations = [[1.1, 1.5]]\n"
        );
        let [hoop, _] = solved(&text).sections[0].stations[0].hoop.unwrap();
        assert!((hoop - 1.0).abs() < 1e-3, "{order}: {hoop}");
    }
}

/// Stations in the gap of a joint that is drawn open, in one layer and between two others: the joint bears what there is to bear.
#[test]
fn cuts_pass_through_the_gap_of_a_joint() {
    let layer = |name: &str, x: [f64; 2], y: [f64; 2], cells: &str, keys: &str| {
        format!(
            "[[body]]\nname = \"{name}\"\nmesh = {{ rectangle = {{ from = [{}, {}], to = [{}, {}], cells = {cells} }} }}\n\
             material = {{ young = 3e7, poisson = 0 }}\n{keys}\n",
            x[0], y[0], x[1], y[1]
        )
    };
    let held = format!("fix = [{HELD}]");
    let end = "load = [{ side = \"right\", pressure = 120 }]";
    let joint = "[[contact]]\nname = \"joint\"\nsides = [\"a.right\", \"b.left\"]\ngap = \"closed\"\nfriction = 0.5\n";
    let stations =
        "stations = [[1.9, 0.25], [2, 0.25], [2.0005, 0.25], [2.001, 0.25], [2.1, 0.25]]";
    let alone = layer("a", [0.0, 2.0], [0.0, 0.5], "[9, 2]", &held)
        + &layer("b", [2.001, 4.0], [0.0, 0.5], "[7, 3]", end)
        + joint
        + "[[section]]\nname = \"cut\"\nbodies = [\"a\", \"b\"]\nsides = [\"top\", \"bottom\"]\n"
        + stations;
    let both = format!("{held}\n{end}");
    let glue = |name: &str, sides: &str| {
        format!("[[contact]]\nname = \"{name}\"\nsides = [{sides}]\ntied = true\n")
    };
    let within = layer("a", [0.0, 2.0], [0.2, 0.4], "[9, 1]", &held)
        + &layer("b", [2.001, 4.0], [0.2, 0.4], "[7, 2]", end)
        + &layer("low", [0.0, 4.0], [0.0, 0.2], "[16, 2]", &both)
        + &layer("up", [0.0, 4.0], [0.4, 0.5], "[16, 1]", &both)
        + joint
        + &glue("la", "\"low.top\", \"a.bottom\"")
        + &glue("lb", "\"low.top\", \"b.bottom\"")
        + &glue("ua", "\"up.bottom\", \"a.top\"")
        + &glue("ub", "\"up.bottom\", \"b.top\"")
        + "[[section]]\nname = \"cut\"\nbodies = [\"a\", \"b\", \"low\", \"up\"]\nsides = [\"up.top\", \"low.bottom\"]\n"
        + stations;
    for text in [alone, within] {
        let cut = &solved(&format!("analysis = \"plane-stress\"\n{text}")).sections[0];
        for station in &cut.stations {
            assert!((station.normal + 60.0).abs() < 1e-6, "{station:?}");
            assert!(station.shear.abs() < 1e-6, "{station:?}");
        }
    }
}

/// Where two bodies do not touch, nothing is borne between them, and the station is there.
#[test]
fn nothing_is_borne_between_bodies_that_do_not_touch() {
    let part = |name: &str, from: f64, held: &str, load: &str| {
        format!(
            "[[body]]\nname = \"{name}\"\nmesh = {{ rectangle = {{ from = [{from}, 0], to = [{}, 0.5], cells = [6, 2] }} }}\n\
             material = {{ young = 1e5, poisson = 0.2 }}\nfix = [{{ side = \"{held}\", x = 0, y = 0 }}]\n\
             load = [{{ side = \"top\", traction = [{load}, 0] }}]\n",
            from + 2.0
        )
    };
    let text = format!(
        "analysis = \"plane-stress\"\n{}{}[[section]]\nname = \"cut\"\nbodies = [\"a\", \"b\"]\nsides = [\"top\", \"bottom\"]\n\
         stations = [[1, 0.25], [2, 0.25], [2.02, 0.25], [2.04, 0.25], [3.04, 0.25]]\n",
        part("a", 0.0, "left", "3"),
        part("b", 2.04, "right", "5")
    );
    let cut = &solved(&text).sections[0];
    assert_eq!(cut.stations.len(), 5);
    for station in &cut.stations {
        // what is drawn to the right on the part between a cut and the free end
        let expected = match station.point[0] {
            x if x < 2.0 => 3.0 * (2.0 - x),
            x => -5.0 * (x - 2.04).max(0.0),
        };
        assert!((station.normal - expected).abs() < 1e-9, "{station:?}");
    }
}

/// A lining of four parts that are tied to each other and to the rock, cut at its joints, too, as one of a single part; at each joint one
/// condition follows from the others. The nodes are the same ones, and so are the displacements.
#[test]
fn tied_parts_in_tied_ground_are_one_ring() {
    let lining = |parts: &[[usize; 2]], joints_first: bool, rock_first: bool| {
        let mut text = String::from(
            "analysis = \"plane-strain\"\n[[body]]\nname = \"rock\"\n\
             mesh = { ring = { inner = 5, outer = 30, cells = [36, 8], ratio = 1.3, cell = \"quad9\" } }\n\
             material = { young = 500, poisson = 0.3 }\ninitial_stress = { xx = -0.6, yy = -1, zz = -0.6 }\n\
             load = [{ side = \"outer\", in_situ = 1 }]\n\
             fix = [{ point = [30, 0], y = 0 }, { point = [-30, 0], y = 0 }, { point = [0, 30], x = 0 }]\n",
        );
        let (mut ground, mut joints) = (String::new(), String::new());
        for (k, [from, to]) in parts.iter().enumerate() {
            let arc = match to - from {
                360 => String::new(),
                _ => format!("from = {from}, to = {to}, "),
            };
            let cells = (to - from) / 10;
            text += &format!(
                "[[body]]\nname = \"l{k}\"\n\
                 mesh = {{ ring = {{ inner = 4.7, outer = 5, {arc}cells = [{cells}, 2], cell = \"quad9\" }} }}\n\
                 material = {{ young = 20e3, poisson = 0.2 }}\n"
            );
            let (one, other) = match rock_first {
                true => ("rock.inner".to_string(), format!("l{k}.outer")),
                false => (format!("l{k}.outer"), "rock.inner".to_string()),
            };
            ground += &format!(
                "[[contact]]\nname = \"c{k}\"\nnonmortar = \"{one}\"\nmortar = \"{other}\"\ntied = true\n"
            );
            if parts.len() > 1 {
                let next = (k + 1) % parts.len();
                joints += &format!(
                    "[[contact]]\nname = \"j{k}\"\nnonmortar = \"l{k}.end\"\nmortar = \"l{next}.start\"\ntied = true\n"
                );
            }
        }
        text += &match joints_first {
            true => joints + &ground,
            false => ground + &joints,
        };
        let names: Vec<String> = (0..parts.len()).map(|k| format!("\"l{k}\"")).collect();
        text + &format!(
            "[[section]]\nname = \"ring\"\nbodies = [{}]\nsides = [\"inner\", \"outer\"]\nstations = 73\n",
            names.join(", ")
        )
    };
    let one = solved(&lining(&[[0, 360]], false, false));
    let parts = [[30, 150], [150, 220], [220, 320], [320, 390]];
    for (joints_first, rock_first) in [(false, false), (true, false), (false, true), (true, true)] {
        let several = solved(&lining(&parts, joints_first, rock_first));
        let (a, b) = (&one.sections[0].stations, &several.sections[0].stations);
        let scales = [a[0].normal.abs(), a[0].moment.abs()];
        let off = a.iter().zip(b).map(|(a, b)| {
            let normal = (a.normal - b.normal).abs() / scales[0];
            let moment = (a.moment - b.moment).abs() / scales[1];
            normal.max(moment)
        });
        let most = off.fold(0.0, f64::max);
        // the ground's traction at a joint is taken as even over both facets: their difference is of second order
        assert!(most < 1e-3, "{joints_first} {rock_first}: {most:.1e}");
    }
}

#[test]
fn layers_that_fold_bear_what_statics_says() {
    for (one, other) in [
        ("quad4", "quad8"),
        ("quad8", "quad4"),
        ("quad4", "tri6"),
        ("quad4", "quad4"),
    ] {
        let text = format!(
            r#"
analysis = "plane-strain"
[[body]]
name = "b0"
mesh = {{ ring = {{ inner = 4, outer = 4.2, from = 0, to = 70, cells = [4, 1], cell = "{one}" }} }}
material = {{ young = 1e6, poisson = 0.25 }}
fix = [{{ side = "start", x = 0, y = 0 }}]
[[body]]
name = "b1"
mesh = {{ ring = {{ inner = 4.2, outer = 4.4, from = 0, to = 70, cells = [4, 1], cell = "{other}" }} }}
material = {{ young = 1e6, poisson = 0.25 }}
fix = [{{ side = "start", x = 0, y = 0 }}]
load = [{{ side = "end", force = [1, 2] }}]
[[contact]]
name = "k"
nonmortar = "b0.outer"
mortar = "b1.inner"
tied = true
[[section]]
name = "c"
bodies = ["b0", "b1"]
sides = ["b0.inner", "b1.outer"]
stations = 9
"#
        );
        for station in &solved(&text).sections[0].stations {
            let force = station.normal.hypot(station.shear);
            assert!(
                (force - 5.0_f64.sqrt()).abs() < 1e-9,
                "{one} {other} {}: {force}",
                station.s
            );
        }
    }
}
