//! Gaskets: pressure over closure, with and without a way back.
//!
//! Blocks under a uniform pressure follow the law by hand; other problems are compared with beds and bodies. Tolerance: 1e-9 where nothing
//! else is told.

use crate::friction::Random;
use crate::links::{near, refused, solved};
use dotyk::case::Case;
use dotyk::model::{Past, Solution};

/// Two blocks with a gasket between them, pressed or moved by keys of the upper one, over steps of these times.
fn blocks(gasket: &str, upper: &str, times: &[f64]) -> String {
    let steps = times.iter().map(|t| format!("[[step]]\ntime = {t}\n"));
    format!(
        "analysis = \"plane-strain\"\n\
         [[body]]\nname = \"lower\"\nmesh = {{ rectangle = {{ from = [0, 0], to = [3, 1], cells = [5, 2], cell = \"quad8\" }} }}\n\
         material = {{ young = 2000, poisson = 0 }}\nfix = [{{ side = \"bottom\", x = 0, y = 0 }}]\n\
         [[body]]\nname = \"upper\"\nmesh = {{ rectangle = {{ from = [0, 8], to = [3, 9], cells = [4, 2], cell = \"quad8\" }} }}\n\
         material = {{ young = 2000, poisson = 0 }}\nfix = [{{ side = \"left\", x = 0 }}]\n{upper}\n\
         [[contact]]\nname = \"seal\"\nnonmortar = \"upper.bottom\"\nmortar = \"lower.top\"\ngasket = {{ {gasket} }}\n{}",
        steps.collect::<String>()
    )
}

const TABLE: &str = "closure = [0, 1, 2, 4], pressure = [0, 10, 40, 60]";

/// Mean pressure and gap of the first contact after each step.
fn course(text: &str) -> Vec<[f64; 2]> {
    let (_, steps) = solved(text);
    steps.iter().map(read).collect()
}

fn read<const D: usize>(step: &Solution<D>) -> [f64; 2] {
    let nodes = &step.contacts[0].nodes;
    let [p, gap] = [nodes[0].pressure, nodes[0].gap];
    for node in nodes {
        near(node.pressure + 1.0, p + 1.0, 1e-9);
        near(node.gap + 1.0, gap + 1.0, 1e-9);
    }
    [p, gap]
}

#[test]
fn a_pressure_closes_it_along_its_table() {
    let load = "load = [{ side = \"top\", pressure = \"t\" }]";
    for unloading in ["", ", unloading = 50"] {
        let found = course(&blocks(
            &format!("{TABLE}{unloading}"),
            load,
            &[5.0, 10.0, 25.0, 40.0, 55.0, 80.0],
        ));
        let closures = [0.5, 1.0, 1.5, 2.0, 3.5, 6.0];
        for ([p, gap], (load, closure)) in found.into_iter().zip(
            [5.0, 10.0, 25.0, 40.0, 55.0, 80.0]
                .into_iter()
                .zip(closures),
        ) {
            near(p, load, 1e-9);
            near(gap, -closure, 1e-9);
        }
    }
}

#[test]
fn it_unloads_as_steeply_as_it_is_told() {
    let load = "load = [{ side = \"top\", pressure = \"if_t\" }]".replace(
        "if_t",
        // 0, 25, 5, 20, 45, 3 at t = 0..5
        "25*max(0, 1 - abs(t - 1)) + 5*max(0, 1 - abs(t - 2)) + 20*max(0, 1 - abs(t - 3)) + 45*max(0, 1 - abs(t - 4)) + 3*max(0, 1 - abs(t - 5))",
    );
    let times = [1.0, 2.0, 3.0, 4.0, 5.0];
    let found = course(&blocks(&format!("{TABLE}, unloading = 50"), &load, &times));
    let expected = [
        (25.0, 1.5),
        (5.0, 1.5 - 20.0 / 50.0),
        (20.0, 1.5 - 5.0 / 50.0),
        (45.0, 2.5),
        (3.0, 2.5 - 42.0 / 50.0),
    ];
    for ([p, gap], (load, closure)) in found.into_iter().zip(expected) {
        near(p, load, 1e-9);
        near(gap, -closure, 1e-9);
    }
    // so does a run that goes on from its middle
    let text = blocks(&format!("{TABLE}, unloading = 50"), &load, &times);
    let (model, whole) = solved(&text);
    let past: Vec<Past<2>> = whole[..3].iter().map(Past::from).collect();
    let on = model.solve_steps_after(&past, &mut |_| {}).unwrap();
    for (a, b) in on.iter().map(read).zip(whole.iter().map(read)) {
        assert_eq!(a, b);
    }
    // without a way of its own it goes back along the table
    let found = course(&blocks(TABLE, &load, &times));
    for ([p, gap], (load, closure)) in found.into_iter().zip([
        (25.0, 1.5),
        (5.0, 0.5),
        (20.0, 4.0 / 3.0),
        (45.0, 2.5),
        (3.0, 0.3),
    ]) {
        near(p, load, 1e-9);
        near(gap, -closure, 1e-9);
    }
}

/// What is drawn away leaves the set of the gasket: no pressure, and a gap that counts from the sides as drawn.
#[test]
fn it_does_not_pull() {
    let moved = "fix = [{ side = \"left\", x = 0 }, { side = \"top\", y = \"-3*min(t, 1) + 2*max(t - 1, 0)\" }]";
    let text = blocks(&format!("{TABLE}, unloading = 50"), "", &[1.0, 2.0, 3.0])
        .replace("fix = [{ side = \"left\", x = 0 }]", moved);
    let found = course(&text);
    // 3 = c + 2 p/2000: between 2 and 4, p = 40 + 10 (c − 2)
    let closure = (3.0 - 2.0 * 20.0 / 2000.0) / (1.0 + 2.0 * 10.0 / 2000.0);
    let p = 20.0 + 10.0 * closure;
    near(found[0][0], p, 1e-9);
    near(found[0][1], -closure, 1e-9);
    // drawn back by 2: the set is closure − p/50, larger than the closure of 1 that is left
    let set = closure - p / 50.0;
    assert!(set > 1.0);
    for ([p, gap], moved) in found[1..].iter().zip([-1.0, 1.0]) {
        near(p + 1.0, 1.0, 1e-12);
        near(*gap, moved, 1e-9);
    }
}

/// A stiff plate on an elastic gasket of one line is a plate on a bed that only presses, in any analysis, tilted until it lifts.
#[test]
fn one_line_is_a_bed() {
    let plate = |below: &str, contact: &str| {
        format!(
            "analysis = \"plane-strain\"\n{below}\
             [[body]]\nname = \"plate\"\nmesh = {{ rectangle = {{ from = [0, 0], to = [2, 0.5], cells = [16, 3], cell = \"quad4\" }} }}\n\
             material = {{ young = 3e4, poisson = 0.2 }}\npoints = {{ p = [1.5, 0.5], o = [0, 0.5] }}\n\
             fix = [{{ point = \"o\", x = 0 }}]\nload = [{{ point = \"p\", force = [0, -8] }}]\n{contact}"
        )
    };
    let bed = plate(
        "",
        "spring = [{ side = \"bottom\", normal = 100, compression_only = true }]\n",
    );
    let block = "[[body]]\nname = \"block\"\nmesh = { rectangle = { from = [0, -1], to = [2, 0], cells = [16, 2], cell = \"quad4\" } }\n\
         material = { young = 1e13, poisson = 0 }\nfix = [{ side = \"bottom\", x = 0, y = 0 }]\n";
    let gasket = plate(
        block,
        "[[contact]]\nname = \"seal\"\nnonmortar = \"plate.bottom\"\nmortar = \"block.top\"\ngasket = { closure = [0, 1], pressure = [0, 100] }\n",
    );
    let (_, bed) = solved(&bed);
    let (_, gasket) = solved(&gasket);
    let down = |step: &Solution<2>| {
        let body = step
            .bodies
            .iter()
            .find(|body| body.name == "plate")
            .unwrap();
        let ends = body.displacement.iter().map(|u| u[1]);
        ends.fold(0.0, f64::min)
    };
    assert!(
        gasket[0].contacts[0]
            .nodes
            .iter()
            .any(|node| node.pressure == 0.0)
    );
    // springs at nodes here, at points of integration there
    near(down(&gasket[0]), down(&bed[0]), 2e-3);
    near(gasket[0].contacts[0].resultant[1], 8.0, 1e-9);
}

/// Friction bounds the shear by the pressure of the gasket.
#[test]
fn it_slips_under_its_own_pressure() {
    let keys =
        "fix = [{ side = \"top\", x = \"2*t\" }]\nload = [{ side = \"top\", pressure = 12 }]";
    // drawn touching: what lies far apart bears shear by levers
    let table = "closure = [0, 0.1, 0.2, 0.4], pressure = [0, 10, 40, 60]";
    let text = blocks(table, "", &[1.0])
        .replace("[0, 8], to = [3, 9]", "[0, 1], to = [3, 2]")
        .replace("fix = [{ side = \"left\", x = 0 }]", keys)
        .replace("gasket =", "friction = 0.25\ngasket =");
    let (_, steps) = solved(&text);
    let contact = &steps[0].contacts[0];
    near(contact.resultant[1].abs(), 36.0, 1e-9);
    near(contact.resultant[0].abs(), 9.0, 1e-9);
}

/// Random tables, loads and cells in the plane and in space: at every node closure and pressure lie on the law, on that of unloading below the
/// largest pressure so far; and the resultant is the load.
#[test]
fn every_node_lies_on_the_law() {
    let mut numbers = Random(11);
    let mut random = || numbers.unit();
    for trial in 0..12 {
        let (mut closure, mut pressure, mut steepest) = (vec![0.0], vec![0.0], 0.0_f64);
        for k in 0..4 {
            let (dc, dp) = (0.01 + 0.1 * random(), 1.0 + 30.0 * random());
            closure.push(closure[k] + dc);
            pressure.push(pressure[k] + dp);
            steepest = steepest.max(dp / dc);
        }
        let unloading = steepest * (1.0 + 3.0 * random());
        let [a, b, c, d] = [random(), random(), random(), random()];
        let load = format!("20*{a} + 10*{b}*x + (30*{c} + 20*{d}*x)*abs(sin(2.2*t))");
        let table =
            format!("closure = {closure:?}, pressure = {pressure:?}, unloading = {unloading}");
        let times: Vec<f64> = (1..6).map(f64::from).collect();
        let (cells, side) = if trial % 2 == 0 {
            ("quad4", "gap = \"closed\"\n")
        } else {
            ("quad9", "")
        };
        let text = blocks(
            &table,
            &format!("load = [{{ side = \"top\", pressure = \"{load}\" }}]"),
            &times,
        )
        .replace("quad8", cells)
        .replace("gasket =", &format!("{side}gasket ="));
        let (_, steps) = solved(&text);
        let at = |list: [&[f64]; 2], x: f64| {
            let k = (1..list[0].len() - 1)
                .find(|&k| x < list[0][k])
                .unwrap_or(list[0].len() - 1);
            let t = (x - list[0][k - 1]) / (list[0][k] - list[0][k - 1]);
            list[1][k - 1] + t * (list[1][k] - list[1][k - 1])
        };
        let count = steps[0].contacts[0].nodes.len();
        let mut most = vec![0.0_f64; count];
        for step in &steps {
            for (node, most) in step.contacts[0].nodes.iter().zip(&mut most) {
                let closed = -node.gap;
                *most = most.max(node.pressure);
                let largest = at([&pressure, &closure], *most);
                if node.pressure > 0.0 {
                    let law = largest - (*most - node.pressure) / unloading;
                    assert!((closed - law).abs() < 1e-8, "{trial}: {closed} {law}");
                } else {
                    assert!(closed <= largest - *most / unloading + 1e-9);
                }
            }
        }
    }
}

#[test]
fn in_space_a_gasket_is_the_same() {
    let text = "analysis = \"3d\"\n\
         [[body]]\nname = \"lower\"\nmesh = { box = { from = [0, 0, 0], to = [2, 2, 1], cells = [3, 3, 1], cell = \"hex8\" } }\n\
         material = { young = 2000, poisson = 0 }\nfix = [{ side = \"bottom\", x = 0, y = 0, z = 0 }]\n\
         [[body]]\nname = \"upper\"\nmesh = { box = { from = [0, 0, 1.3], to = [2, 2, 2], cells = [2, 2, 1], cell = \"hex8\" } }\n\
         material = { young = 2000, poisson = 0 }\nfix = [{ side = \"left\", x = 0 }, { side = \"front\", y = 0 }]\n\
         load = [{ side = \"top\", pressure = \"25*t\" }]\n\
         [[contact]]\nname = \"seal\"\nsides = [\"upper.bottom\", \"lower.top\"]\ngasket = { closure = [0, 0.1, 0.2], pressure = [0, 10, 40], unloading = 500 }\n\
         [[step]]\ntime = 1\n[[step]]\ntime = 0.2\n"
    .replace("time = 0.2", "time = 2")
    .replace("25*t", "25*min(t, 3 - 1.25*t)");
    let model = Case::<3>::from_str(&text, "gasket.toml", "".as_ref())
        .unwrap()
        .model;
    let steps = model.solve_steps().unwrap();
    assert!(steps.iter().all(|step| step.converged));
    let found: Vec<[f64; 2]> = steps.iter().map(read).collect();
    near(found[0][0], 25.0, 1e-9);
    near(found[0][1], -0.15, 1e-9);
    near(found[1][0], 12.5, 1e-9);
    near(found[1][1], -(0.15 - 12.5 / 500.0), 1e-9);
}

#[test]
fn wrong_gaskets_are_told() {
    let load = "load = [{ side = \"top\", pressure = 5 }]";
    for (gasket, words) in [
        (
            "closure = [0, 1], pressure = [0]",
            "2 closures and 1 pressures",
        ),
        (
            "closure = [0, 1, 1], pressure = [0, 1, 2]",
            "`closure` of a gasket grows",
        ),
        (
            "closure = [0, 1], pressure = [1, 2]",
            "`pressure` of a gasket begins with 0",
        ),
        (
            "closure = [0, 1], pressure = [0, 5], unloading = 4",
            "at least as steep",
        ),
        (
            "closure = [0, 1], pressure = [0, 5], unloading = -4",
            "`unloading` must be positive",
        ),
        ("closure = [0, 1]", "pressure"),
    ] {
        let error = refused(&blocks(gasket, load, &[1.0])).to_string();
        assert!(error.contains(words), "{gasket}: {error}");
    }
    let tied = blocks(TABLE, load, &[1.0]).replace("gasket =", "tied = true\ngasket =");
    assert!(refused(&tied).to_string().contains("does not pull"));
}

/// A block in the corner of a seat, with a gasket on both faces: the node at the corner has a row for each.
#[test]
fn at_a_corner_each_face_has_its_own_closure() {
    let text = "analysis = \"plane-strain\"\n\
         [[body]]\nname = \"seat\"\nmesh = { outline = { cell = \"tri3\", size = 0.5, from = [-1, -1], edges = [{ to = [3, -1], name = \"base\" }, \
         { to = [3, 0] }, { to = [0, 0], name = \"floor\" }, { to = [0, 2], name = \"wall\" }, { to = [-1, 2] }, { to = [-1, -1], name = \"back\" }] } }\n\
         material = { young = 1e9, poisson = 0 }\nfix = [{ side = [\"base\", \"back\"], x = 0, y = 0 }]\n\
         [[body]]\nname = \"block\"\nmesh = { rectangle = { from = [0, 0], to = [2, 1.5], cells = [4, 3], cell = \"quad4\" } }\n\
         material = { young = 1e9, poisson = 0 }\n\
         load = [{ side = \"top\", pressure = \"8*min(t, 2.5 - t)\" }, { side = \"right\", pressure = \"3*min(t, 2.5 - t)\" }]\n\
         [[contact]]\nname = \"seal\"\nnonmortar = [\"block.bottom\", \"block.left\"]\nmortar = [\"seat.floor\", \"seat.wall\"]\n\
         gasket = { closure = [0, 0.01, 0.03], pressure = [0, 4, 30], unloading = 2000 }\n\
         [[step]]\ntime = 1\n[[step]]\ntime = 2\n";
    let (_, steps) = solved(text);
    for (step, part) in steps.iter().zip([1.0, 0.5]) {
        let corner = step.contacts[0]
            .nodes
            .iter()
            .filter(|node| node.point == [0.0, 0.0]);
        assert_eq!(corner.count(), 2);
        for node in &step.contacts[0].nodes {
            let (p, closure) = match node.normal[1] < -0.5 {
                true => (
                    8.0 * part,
                    0.01 + 4.0 / 1300.0 - 8.0 * (1.0 - part) / 2000.0,
                ),
                false => (3.0 * part, 0.0075 - 3.0 * (1.0 - part) / 2000.0),
            };
            // blocks of this modulus are rigid to 1e-7
            near(node.pressure, p, 1e-5);
            near(node.gap, -closure, 1e-6);
        }
    }
}

/// Blocks that are drawn touching, on meshes whose facets are shorter than the gasket closes.
#[test]
fn one_closes_by_more_than_a_facet() {
    for (cells, width) in [([6, 4], 1.0), ([4, 3], 1.5), ([2, 3], 0.6)] {
        let [a, b] = cells;
        let text = format!(
            "analysis = \"plane-stress\"\n\
             [[body]]\nname = \"lower\"\nmesh = {{ rectangle = {{ from = [0, -1], to = [1, 0], cells = [{a}, 4], cell = \"quad8\" }} }}\n\
             material = {{ young = 1e9, poisson = 0 }}\nfix = [{{ side = \"bottom\", y = 0 }}, {{ side = \"left\", x = 0 }}]\n\
             [[body]]\nname = \"upper\"\nmesh = {{ rectangle = {{ from = [0, 0], to = [{width}, 1], cells = [{b}, 4], cell = \"quad8\" }} }}\n\
             material = {{ young = 1e9, poisson = 0 }}\nfix = [{{ side = \"left\", x = 0 }}, {{ side = \"right\", x = 0 }}]\n\
             load = [{{ side = \"top\", traction = [0, -25] }}]\n\
             [[contact]]\nname = \"seal\"\nnonmortar = \"upper.bottom\"\nmortar = \"lower.top\"\n\
             gasket = {{ closure = [0, 1], pressure = [0, 100] }}\n"
        );
        let (_, steps) = solved(&text);
        assert!(steps[0].converged);
        let contact = &steps[0].contacts[0];
        near(contact.resultant[1].abs() / width, 25.0, 1e-9);
        // the load over the length that both have; the blocks are 10⁷ times as stiff as the gasket
        let length = f64::min(width, 1.0);
        let inside = contact.nodes.iter();
        let inside = inside.filter(|node| node.point[0] < 0.6 * length);
        for gap in inside.map(|node| node.gap) {
            near(gap, -0.25 * width / length, 1e-6);
        }
    }
}
