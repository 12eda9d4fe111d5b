//! Bodies in pieces: the answer of whole ones, whatever they are a part of.
//!
//! Displacements agree to 1e-7 of the largest one, contact forces to 1e-6: ten times what the certificates of both allow.

use dotyk::case::AnyCase;
use dotyk::geometry::norm;
use dotyk::model::{Division, Error, Model, Solution, Subdomains};

fn same<const D: usize>(whole: &[Solution<D>], pieces: &[Solution<D>]) {
    assert_eq!(whole.len(), pieces.len());
    assert!(pieces.iter().all(|step| step.converged));
    for (a, b) in whole.iter().zip(pieces) {
        let sizes = a.bodies.iter().flat_map(|body| &body.displacement);
        let largest = sizes.fold(0.0, |s: f64, u| s.max(norm(*u)));
        for (a, b) in a.bodies.iter().zip(&b.bodies) {
            for (u, v) in a.displacement.iter().zip(&b.displacement) {
                let off = (0..D).map(|d| (u[d] - v[d]).abs()).fold(0.0, f64::max);
                assert!(off <= 1e-7 * largest, "{}: {u:?} {v:?}", a.name);
            }
        }
        let force = |contact: &dotyk::model::ContactSolution<D>| norm(contact.resultant);
        let largest = a.contacts.iter().map(force).fold(0.0, f64::max);
        for (a, b) in a.contacts.iter().zip(&b.contacts) {
            for d in 0..D {
                let off = (a.resultant[d] - b.resultant[d]).abs();
                assert!(off <= 1e-6 * largest, "{}", a.name);
            }
        }
    }
}

/// Solves a case with whole bodies, and with them in pieces; returns the number of pieces.
#[track_caller]
fn agrees(text: &str, pieces: usize) -> usize {
    compared(text, pieces).subdomains
}

/// The same; returns how the first step was divided.
#[track_caller]
fn compared(text: &str, pieces: usize) -> Division {
    let divided = format!("{text}\n[solver]\nsubdomains = {pieces}\n");
    let read = |text: &str| AnyCase::from_str(text, "pieces.toml", "".as_ref()).unwrap();
    match (read(text), read(&divided)) {
        (AnyCase::Plane(whole), AnyCase::Plane(divided)) => {
            let [whole, divided] = [&whole, &divided].map(|case| case.model.solve_steps().unwrap());
            same(&whole, &divided);
            divided[0].division
        }
        (AnyCase::Space(whole), AnyCase::Space(divided)) => {
            let [whole, divided] = [&whole, &divided].map(|case| case.model.solve_steps().unwrap());
            same(&whole, &divided);
            divided[0].division
        }
        _ => panic!("a case of two dimensions"),
    }
}

/// A block that is pressed on a larger one, which does not match it, and pulled aside.
fn pressed(contact: &str) -> String {
    format!(
        "title = \"a block on a block\"\nanalysis = \"plane-strain\"\n\
         [[body]]\nname = \"lower\"\n\
         mesh = {{ rectangle = {{ from = [0, 0], to = [4, 2], cells = [16, 8] }} }}\n\
         material = {{ young = 1000, poisson = 0.3 }}\n\
         fix = [{{ side = \"bottom\", x = 0, y = 0 }}]\n\
         [[body]]\nname = \"upper\"\n\
         mesh = {{ rectangle = {{ from = [1, 2], to = [3, 3], cells = [9, 5] }} }}\n\
         material = {{ young = 300, poisson = 0.4 }}\n\
         load = [{{ side = \"top\", traction = [\"4 - 2*t\", -10] }}]\n\
         [[contact]]\nname = \"sole\"\nnonmortar = \"upper.bottom\"\nmortar = \"lower.top\"\n{contact}\n\
         [[step]]\ntime = 1\n[[step]]\ntime = 2\n[[step]]\ntime = 3\n"
    )
}

#[test]
fn plane_bodies_with_friction_and_history() {
    assert_eq!(agrees(&pressed("friction = 0.5"), 7), 7);
    assert_eq!(agrees(&pressed("tied = true"), 4), 4);
    // two bodies are at least two pieces
    assert_eq!(agrees(&pressed("friction = 0.5"), 1), 2);
}

#[test]
fn bodies_in_space_with_and_without_friction() {
    for friction in ["", "friction = 0.3\n"] {
        let text = format!(
            "title = \"blocks\"\nanalysis = \"3d\"\n\
             [[body]]\nname = \"lower\"\n\
             mesh = {{ box = {{ from = [0, 0, 0], to = [2, 2, 1], cells = [6, 6, 3] }} }}\n\
             material = {{ young = 1000, poisson = 0.3 }}\n\
             fix = [{{ side = \"bottom\", x = 0, y = 0, z = 0 }}]\n\
             [[body]]\nname = \"upper\"\n\
             mesh = {{ box = {{ from = [0.4, 0.4, 1], to = [1.6, 1.6, 2], cells = [4, 5, 4], cell = \"hex20\" }} }}\n\
             material = {{ young = 3000, poisson = 0.2 }}\n\
             fix = [{{ side = \"top\", x = 0.004, y = 0, z = -0.02 }}]\n\
             [[contact]]\nname = \"c\"\nnonmortar = \"upper.bottom\"\nmortar = \"lower.top\"\n{friction}"
        );
        assert_eq!(agrees(&text, 10), 10);
    }
}

#[test]
fn sprung_and_floating_bodies_around_an_axis() {
    let text = "title = \"a ring in a ring\"\nanalysis = \"axisymmetric\"\n\
        [[body]]\nname = \"inner\"\n\
        mesh = { rectangle = { from = [1, 0], to = [2, 3], cells = [6, 12], cell = \"quad8\" } }\n\
        material = { young = 1000, poisson = 0.3 }\n\
        load = [{ side = \"left\", pressure = 20 }]\n\
        [[body]]\nname = \"outer\"\n\
        mesh = { rectangle = { from = [2.001, 0], to = [3, 3], cells = [5, 9] } }\n\
        material = { young = 2000, poisson = 0.2 }\n\
        spring = [{ side = \"bottom\", normal = 100 }]\n\
        [[contact]]\nname = \"fit\"\nnonmortar = \"inner.right\"\nmortar = \"outer.left\"\nfriction = 0.2\n\
        [[contact]]\nname = \"foot\"\nnonmortar = \"inner.bottom\"\nobstacle = { plane = { point = [0, 0], normal = [0, 1] } }\n";
    assert_eq!(agrees(text, 6), 6);
}

#[test]
fn bodies_that_come_later() {
    let text = pressed("friction = 0.5")
        + "[[body]]\nname = \"wedge\"\n\
           mesh = { rectangle = { from = [3.4, 2], to = [4, 2.5], cells = [5, 4] } }\n\
           material = { young = 500, poisson = 0.3 }\nactive = { from = 2 }\n\
           load = [{ side = \"top\", traction = [0, -3] }]\n\
           [[contact]]\nname = \"later\"\nnonmortar = \"wedge.bottom\"\nmortar = \"lower.top\"\nfriction = 0.4\n";
    agrees(&text, 9);
}

#[test]
fn beds_over_several_pieces() {
    let text = "title = \"a plate on a bed\"\nanalysis = \"3d\"\n\
        [[body]]\nname = \"plate\"\n\
        mesh = { box = { from = [0, 0, 0], to = [3, 2, 1], cells = [6, 4, 2] } }\n\
        material = { young = 1000, poisson = 0.2 }\n\
        fix = [{ side = \"left\", x = 0 }, { side = \"front\", y = 0 }]\n\
        spring = [{ side = \"bottom\", normal = 50 }]\n\
        load = [{ side = \"top\", traction = [0, 0, \"-1 - x\"] }]\n\
        [[contact]]\nname = \"wall\"\nnonmortar = \"plate.right\"\n\
        obstacle = { plane = { point = [3, 0, 0], normal = [-1, 0, 0] } }\n";
    assert_eq!(agrees(text, 7), 7);
}

#[test]
fn body_that_yields() {
    let text = "title = \"a strip that yields\"\nanalysis = \"plane-strain\"\n\
        [[body]]\nname = \"strip\"\n\
        mesh = { rectangle = { from = [0, 0], to = [3, 1], cells = [12, 6], cell = \"quad8\" } }\n\
        material = { young = 1000, poisson = 0.3, strength = { yield = 8 }, plastic = true, hardening = 100 }\n\
        fix = [{ side = \"left\", x = 0 }, { side = \"bottom\", y = 0 }]\n\
        load = [{ side = \"right\", traction = [\"12*t\", 0] }]\n";
    agrees(text, 5);
}

/// What a model needs by the estimate from its factors, in bytes.
fn needed(model: &mut Model<3>) -> u64 {
    let mut told = 1;
    // the first estimate is that of the mesh alone
    for _ in 0..2 {
        model.solver.memory = Some(told);
        told = match model.solve_steps() {
            Err(Error::Memory { needed, .. }) => needed,
            other => panic!("{other:?}"),
        };
    }
    told
}

#[test]
fn bodies_are_divided_where_the_memory_is_too_small_for_wholes() {
    let text = "title = \"a cube on a floor\"\nanalysis = \"3d\"\n\
        [[body]]\nname = \"cube\"\n\
        mesh = { box = { from = [0, 0, 0], to = [1, 1, 1], cells = [16, 16, 16] } }\n\
        material = { young = 1000, poisson = 0.3 }\n\
        fix = [{ side = \"left\", x = 0 }, { side = \"front\", y = 0 }]\n\
        load = [{ side = \"top\", traction = [0, 0, -2] }]\n\
        [[contact]]\nname = \"foot\"\nnonmortar = \"cube.bottom\"\n\
        obstacle = { plane = { point = [0, 0, 0], normal = [0, 0, 1] } }\n";
    let AnyCase::Space(case) = AnyCase::from_str(text, "cube.toml", "".as_ref()).unwrap() else {
        panic!("a case of space");
    };
    let mut model = case.model;
    model.solver.subdomains = Subdomains::Parts(1);
    let whole = needed(&mut model);
    model.solver.subdomains = Subdomains::Parts(64);
    let pieces = needed(&mut model);
    assert!(pieces < whole, "{pieces} {whole}");
    model.solver.memory = Some((pieces + whole) / 2);
    model.solver.subdomains = Subdomains::Auto;
    let solution = model.solve().unwrap();
    // 14 739 unknowns: 4.2 pieces along each edge
    assert_eq!(solution.division.subdomains, 64);
    let sinks = solution.bodies[0].displacement.iter().map(|u| u[2]);
    let sinks = sinks.fold(0.0, f64::min);
    assert!((sinks / -2e-3 - 1.0).abs() < 1e-9);
    // nobody is asked twice
    model.solver.subdomains = Subdomains::Parts(1);
    assert!(matches!(model.solve(), Err(Error::Memory { .. })));
}

#[test]
fn pieces_that_were_not_glued_are_told() {
    let text = "title = \"a beam that keeps its volume\"\nanalysis = \"3d\"\n\
        [[body]]\nname = \"beam\"\n\
        mesh = { box = { from = [0, 0, 0], to = [4, 1, 1], cells = [24, 6, 6] } }\n\
        material = { young = 1000, poisson = 0.4999999 }\n\
        fix = [{ side = \"left\", x = 0, y = 0, z = 0 }]\n\
        load = [{ side = \"top\", traction = [\"sin(9*x)\", 0, -0.01] }]\n\
        [solver]\nsubdomains = 40\n";
    let AnyCase::Space(case) = AnyCase::from_str(text, "beam.toml", "".as_ref()).unwrap() else {
        panic!("a case of space");
    };
    let refused = case.model.solve().map(|_| ()).unwrap_err().to_string();
    assert!(refused.contains("`subdomains = 1`"), "{refused}");
}

/// Pieces that are halves along the axes, and held where they are supported, need 710 solutions here.
#[test]
fn meshes_with_small_cells_at_one_place() {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../../cases/space-hertz");
    let block = |pieces: usize| {
        let text = format!(
            "title = \"a block that is pressed at one place\"\nanalysis = \"3d\"\n\
             [[body]]\nname = \"block\"\n\
             mesh = {{ file = {{ path = \"ball-on-block.msh\", group = \"block\" }} }}\n\
             material = {{ young = 210000, poisson = 0.3 }}\n\
             fix = [{{ side = \"block_left\", x = 0 }}, {{ side = \"block_front\", y = 0 }}, {{ side = \"block_bottom\", z = 0 }}]\n\
             load = [{{ side = \"block_top\", traction = [0, 0, \"-1/(1 + 100*(x^2 + y^2))\"] }}]\n\
             [solver]\nsubdomains = {pieces}\n"
        );
        let case = AnyCase::from_str(&text, "block.toml", folder.as_ref()).unwrap();
        let AnyCase::Space(case) = case else {
            panic!("a case of space");
        };
        case.model.solve_steps().unwrap()
    };
    let pieces = block(100);
    same(&block(1), &pieces);
    // 158, of two passes: to nine digits, and to rounding
    let solutions = pieces[0].division.iterations;
    assert!(solutions < 200, "{solutions}");
}

/// With displacements that are rough where a condition meets several nodes, with rigid motions that do not meet the conditions between
/// supports and points, and with a goal below rounding where loads come through points alone, these need 366, 660, 5012 and 1450.
#[test]
fn cells_of_second_degree_and_points_of_sides_need_few_solutions() {
    let supports = "fix = [{ side = \"left\", x = 0 }, { side = \"front\", y = 0 }]\n";
    for (cell, kind, rest, friction, most) in [
        ("hex8", "rigid", supports, 0.0, 160),
        ("hex8", "average", supports, 0.0, 160),
        ("hex8", "rigid", "", 0.3, 350),
        ("tet10", "rigid", supports, 0.0, 350),
    ] {
        let (many, few) = if cell == "hex8" { (12, 6) } else { (6, 3) };
        let (width, height) = (many * 3 / 4, few);
        let text = format!(
            "title = \"a block under a point\"\nanalysis = \"3d\"\n\
             [[body]]\nname = \"lower\"\n\
             mesh = {{ box = {{ from = [0, 0, 0], to = [2, 2, 1], cells = [{many}, {many}, {few}], cell = \"{cell}\" }} }}\n\
             material = {{ young = 1000, poisson = 0.3 }}\n\
             fix = [{{ side = \"bottom\", x = 0, y = 0, z = 0 }}]\n\
             [[body]]\nname = \"upper\"\n\
             mesh = {{ box = {{ from = [0.4, 0.4, 1], to = [1.6, 1.6, 2], cells = [{width}, {width}, {height}], cell = \"{cell}\" }} }}\n\
             material = {{ young = 2000, poisson = 0.2 }}\n\
             points = {{ p = [1, 1, 2] }}\n\
             couple = [{{ side = \"top\", point = \"p\", kind = \"{kind}\" }}]\n\
             load = [{{ point = \"p\", force = [0, 0, -5] }}]\n{rest}\
             [[contact]]\nname = \"sole\"\nnonmortar = \"upper.bottom\"\nmortar = \"lower.top\"\nfriction = {friction}\n"
        );
        let solutions = compared(&text, 24).iterations;
        assert!(solutions < most, "{cell} {kind}: {solutions}");
    }
}

/// A case file with other pieces than whole ones.
fn file(name: &str) -> String {
    let path = format!("{}/../../cases/{name}.toml", env!("CARGO_MANIFEST_DIR"));
    std::fs::read_to_string(path).unwrap()
}

#[test]
fn gaskets_between_pieces() {
    let text = file("gasket-of-a-flange/flange");
    for pieces in [4, 5, 6] {
        assert_eq!(agrees(&text, pieces), pieces);
    }
}

/// Springs much softer than the body hold its pieces against some motions and not against others.
#[test]
fn pieces_on_soft_springs() {
    for soft in ["1", "1e-2"] {
        let text = format!(
            "analysis = \"plane-strain\"\n[[body]]\nname = \"up\"\n\
             mesh = {{ rectangle = {{ from = [0, 0], to = [1, 1], cells = [6, 4], cell = \"quad8\" }} }}\n\
             material = {{ young = 1000, poisson = 0.3 }}\n\
             load = [{{ side = \"top\", traction = [0.001, -0.1] }}]\n\
             spring = [{{ side = \"top\", tangential = {soft} }}]\n\
             [[contact]]\nname = \"c\"\nnonmortar = \"up.bottom\"\n\
             obstacle = {{ plane = {{ point = [0, 0], normal = [0, 1] }} }}\n"
        );
        assert_eq!(agrees(&text, 4), 4);
    }
}

/// A piece of tetrahedra may have all nodes of a facet on springs without its cell.
#[test]
fn pieces_of_tetrahedra_on_springs() {
    let text = "analysis = \"3d\"\n[[body]]\nname = \"up\"\n\
         mesh = { box = { from = [0, 0, 0], to = [1, 1, 1], cells = [3, 2, 1], cell = \"tet4\" } }\n\
         material = { young = 1000, poisson = 0 }\n\
         load = [{ side = \"top\", traction = [0, 0, -0.01] }]\n\
         spring = [{ side = \"top\", tangential = 100 }]\n\
         [[contact]]\nname = \"c\"\nnonmortar = \"up.bottom\"\n\
         obstacle = { plane = { point = [0, 0, 0], normal = [0, 0, 1] } }\n";
    for pieces in [2, 3, 4, 5] {
        agrees(text, pieces);
    }
}
