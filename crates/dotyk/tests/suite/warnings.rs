//! Warnings about what the theory assumes: each where it belongs, and none where it does not.

use dotyk::case::Case;
use dotyk::mesh::Diagonals;
use dotyk::model::{Law, Motion, Pair, Pairing};
use dotyk::prelude::*;
use std::path::Path;

fn rectangle(from: Point<2>, to: Point<2>, cells: [usize; 2]) -> Mesh<2> {
    Rectangle {
        from,
        to,
        cells,
        cell: CellKind::Quad4,
        diagonals: Diagonals::default(),
    }
    .build()
    .unwrap()
}

const SOFT: Elastic = Elastic {
    young: 100.0,
    poisson: 0.3,
};

fn warned(model: &Model<2>, words: &str) -> bool {
    let solution = model.solve().unwrap();
    solution
        .warnings
        .iter()
        .any(|warning| warning.contains(words))
}

/// A block pressed on a rigid parabola, with so many cells.
fn on_a_bump(cells: usize) -> Model<2> {
    let mut model = Model::<2>::new();
    let block = model.body(
        "block",
        rectangle([-1.0, 0.0], [1.0, 1.0], [cells, 4]),
        SOFT,
    );
    model.fix(block, "top", [Some(0.0), Some(-0.02)]);
    model.obstacle(
        (block, "bottom"),
        dotyk::case::parse_expression("x^2/4").unwrap(),
    );
    model
}

#[test]
fn few_closed_nodes_are_told_where_the_contact_has_an_edge() {
    let words = "fewer than 5 nodes are closed";
    assert!(warned(&on_a_bump(10), words));
    assert!(!warned(&on_a_bump(60), words));
    // all of a side that is closed has no edge, however few its nodes
    let mut flat = on_a_bump(2);
    let Pair::Obstacle { obstacle, .. } = &mut flat.contacts[0].pair else {
        unreachable!()
    };
    obstacle.shape = dotyk::model::Rigid::Gap(Field::constant(0.0));
    assert!(!warned(&flat, words));
}

/// A block pressed on another one and dragged along it by so much; facets have the length 0.25 and 0.2.
fn dragged(by: f64) -> Model<2> {
    let mut model = Model::<2>::new();
    let base = model.body("base", rectangle([0.0, 0.0], [4.0, 1.0], [20, 4]), SOFT);
    let block = model.body("block", rectangle([1.0, 1.0], [3.0, 2.0], [8, 4]), SOFT);
    model.fix(base, "bottom", [Some(0.0), Some(0.0)]);
    model.fix(block, "top", [Some(by), Some(-0.01)]);
    model.contact((block, "bottom"), (base, "top"));
    model
}

#[test]
fn a_node_that_slips_to_another_facet_is_told() {
    let words = "slips by";
    assert!(warned(&dragged(0.12), words));
    assert!(!warned(&dragged(0.08), words));
    // beside a rigid obstacle there is no facet to leave
    let mut rigid = on_a_bump(60);
    let Pair::Obstacle { obstacle, .. } = &mut rigid.contacts[0].pair else {
        unreachable!()
    };
    obstacle.motion = Motion::Prescribed([Field::constant(0.2), Field::constant(0.0)]);
    assert!(!warned(&rigid, words));
}

#[test]
fn large_strains_and_rotations_are_told() {
    for (pull, told) in [(0.06, true), (0.04, false)] {
        let mut model = Model::<2>::new();
        let strip = model.body("strip", rectangle([0.0, 0.0], [1.0, 1.0], [4, 4]), SOFT);
        model.fix(strip, "left", [Some(0.0), None]);
        model.fix(strip, "right", [Some(pull), None]);
        model.fix(strip, "bottom", [None, Some(0.0)]);
        assert_eq!(warned(&model, "is strained by"), told);
    }
    for (turn, told) in [(0.06, true), (0.04, false)] {
        let mut model = Model::<2>::new();
        let body = model.body("body", rectangle([0.0, 0.0], [1.0, 1.0], [4, 4]), SOFT);
        let field = |text: String| Some(dotyk::case::parse_expression(&text).unwrap());
        for side in ["left", "right"] {
            let components = [field(format!("-{turn} * y")), field(format!("{turn} * x"))];
            model.fix(body, side, [Some(0.0), Some(0.0)]);
            let support = model.bodies[0].supports.last_mut().unwrap();
            support.components = components;
        }
        assert_eq!(warned(&model, "is turned by"), told);
        assert!(!warned(&model, "is strained by"));
    }
    // a singular corner alone is no large strain
    let mut corner = Model::<2>::new();
    let body = corner.body("body", rectangle([0.0, 0.0], [1.0, 1.0], [40, 40]), SOFT);
    corner.fix(body, "bottom", [Some(0.0), Some(0.0)]);
    corner.load(
        body,
        Load::Force {
            point: [1.0, 1.0],
            force: [Field::constant(0.0), Field::constant(-0.2)],
        },
    );
    let solution = corner.solve().unwrap();
    let largest = solution.bodies[0]
        .strain
        .iter()
        .flatten()
        .fold(0.0f64, |m, e| m.max(e.abs()));
    assert!(
        largest > 0.05 && !warned(&corner, "is strained by"),
        "{largest}"
    );
}

#[test]
fn a_point_that_is_no_node_is_told_with_its_distance() {
    let at = |load: Point<2>, held: Point<2>| {
        let mut model = Model::<2>::new();
        let body = model.body("body", rectangle([0.0, 0.0], [1.0, 1.0], [4, 4]), SOFT);
        model.fix(body, "bottom", [Some(0.0), Some(0.0)]);
        let support = model.bodies[0].supports[0].clone();
        model.bodies[0].supports.push(dotyk::model::Support {
            place: Place::Point(held),
            ..support
        });
        let force = [Field::constant(0.0), Field::constant(-0.1)];
        model.load(body, Load::Force { point: load, force });
        model
    };
    let exact = at([0.5, 1.0], [0.0, 0.75]);
    assert!(!warned(&exact, "acts at its nearest node"));
    // what is rounding of a node is the node
    assert!(!warned(&at([0.5 + 1e-12, 1.0], [0.0, 0.75]), "acts at"));
    let load = at([0.53, 1.0], [0.0, 0.75]);
    let told = "the force at (0.53, 1) acts at its nearest node (0.5, 1), 3.0000e-2 away";
    assert!(warned(&load, told));
    assert!(
        load.check()
            .warnings
            .iter()
            .any(|warning| warning.contains(told))
    );
    let support = at([0.5, 1.0], [0.0, 0.7]);
    assert!(warned(
        &support,
        "the support at (0, 0.7) acts at its nearest node (0, 0.75)"
    ));
}

/// A disc in a groove under a force that leads almost out of it: neither guessed states nor interior points find the slips soon.
#[test]
fn friction_that_is_hard_to_find_is_told_with_its_place() {
    let disc = |force: &str| {
        format!(
            r#"analysis = "plane-strain"
[[body]]
name = "disc"
mesh = {{ ring = {{ center = [0, 0], inner = 0.2, outer = 1.0, cells = [40, 6], ratio = 1.2, cell = "quad4" }} }}
material = {{ young = 1.0, poisson = 0.2824210408273037 }}
load = [{{ point = [0.7071067811865476, 0.7071067811865475], force = {force} }}]
[[contact]]
name = "floor"
nonmortar = "disc.outer"
obstacle = {{ plane = {{ point = [0.7071067811865476, -0.7071067811865475], normal = [-0.7071067811865476, 0.7071067811865475] }} }}
pairing = "mortar"
friction = 0.6019868100526565
[[contact]]
name = "wall"
nonmortar = "disc.outer"
obstacle = {{ plane = {{ point = [-1.0, 0.0], normal = [1.0, -0.0] }} }}
friction = 0.6019868100526565
"#
        )
    };
    let solve = |force: &str| {
        let case =
            dotyk::case::Case::<2>::from_str(&disc(force), "disc.toml", std::path::Path::new(""));
        case.unwrap().model.solve().unwrap()
    };
    let told = |solution: &Solution<2>| {
        let mut warnings = solution.warnings.iter();
        warnings.any(|w| {
            w.contains("friction took")
                && w.contains("of contact \"")
                && w.contains("smaller load steps")
        })
    };
    let hard = solve("[2.5870558044280414e-5, -3.950776880870536e-5]");
    assert!(hard.solver.iterations > 60, "{}", hard.solver.iterations);
    assert!(told(&hard));
    let easy = solve("[0.0, -4.0e-5]");
    assert!(easy.solver.iterations <= 60 && !told(&easy));
}

/// A disc-shaped obstacle pressed in and then moved along the side: the contact does not go with it, and says so.
#[test]
fn a_curved_obstacle_that_moves_along_its_side_is_told() {
    let pressed = |sideways: f64| {
        let mut model = Model::<2>::new();
        let block = model.body("block", rectangle([-4.0, -2.0], [4.0, 0.0], [64, 16]), SOFT);
        model.fix(block, "bottom", [Some(0.0), Some(0.0)]);
        let contact = model.obstacle((block, "top"), Field::constant(0.0));
        let Pair::Obstacle { obstacle, .. } = &mut contact.pair else {
            unreachable!()
        };
        obstacle.shape = dotyk::model::Rigid::Surface {
            surface: dotyk::geometry::Surface::Sphere {
                center: [0.0, 8.0],
                radius: 8.0,
            },
            inside: false,
        };
        obstacle.motion = Motion::Prescribed([sideways, -0.05].map(Field::constant));
        model
    };
    let words = "its curved obstacle slips along it";
    assert!(warned(&pressed(2.0), words));
    assert!(!warned(&pressed(0.0), words));
}

/// A ball beside a block that comes over it, or is pressed where it is.
#[test]
fn an_obstacle_that_moves_to_where_it_was_not_opposite_is_told() {
    let moved = |from: f64, by: f64| {
        let mut model = Model::<2>::new();
        let block = model.body("block", rectangle([-1.0, -1.0], [1.0, 0.0], [16, 8]), SOFT);
        model.fix(block, "bottom", [Some(0.0), Some(0.0)]);
        let contact = model.obstacle((block, "top"), Field::constant(0.0));
        let Pair::Obstacle { obstacle, .. } = &mut contact.pair else {
            unreachable!()
        };
        obstacle.shape = dotyk::model::Rigid::Surface {
            surface: dotyk::geometry::Surface::Sphere {
                center: [from, 0.5],
                radius: 0.5,
            },
            inside: false,
        };
        obstacle.motion = Motion::Prescribed([by, -0.02].map(Field::constant));
        model
    };
    let words = "its obstacle moves to where it overlaps";
    assert!(warned(&moved(-2.0, 2.0), words));
    assert!(!warned(&moved(0.0, 0.0), words));
}

/// Discs above a straight side, whose facets are too large to see them between their nodes. What is above a node is seen as it is:
/// there a disc apart bears no force.
#[test]
fn overlaps_between_nodes_that_bear_no_force_are_told() {
    let below = |cells: usize, [beside, clearance]: [f64; 2], down: f64| {
        let mut model = Model::<2>::new();
        let ring = Ring {
            center: [beside, 1.0 + clearance],
            inner: 0.5,
            outer: 1.0,
            angles: None,
            cells: [96, 4],
            ratio: 1.0,
            grade: 1.0,
            cell: CellKind::Quad4,
            diagonals: Diagonals::default(),
        };
        let ring = model.body("ring", ring.build().unwrap(), SOFT);
        let block = model.body(
            "block",
            rectangle([-1.0, -1.0], [1.0, 0.0], [cells, 8]),
            SOFT,
        );
        model
            .fix(block, "bottom", [Some(0.0), Some(0.0)])
            .fix(ring, "inner", [Some(0.0), Some(-down)])
            .contact((block, "top"), (ring, "outer"));
        model.contacts[0].pairing = Some(Pairing::Mortar);
        model
    };
    let between = "between nodes none of which is closed";
    assert!(warned(&below(4, [0.25, 0.0], 0.01), between));
    assert!(!warned(&below(64, [0.25, 0.0], 0.01), between));
    let apart = below(4, [0.0, 0.005], 0.0);
    assert_eq!(apart.solve().unwrap().contacts[0].resultant, [0.0; 2]);
}

/// A pin that is pressed on a block: where its facets are larger than the pin, it sinks until they are a mean distance apart.
#[test]
fn a_pin_that_sinks_between_nodes_is_told() {
    let on = |cells: usize, nonmortar: &str, mortar: &str| {
        let text = format!(
            "analysis = \"plane-strain\"\n[[body]]\nname = \"a\"\nmesh = {{ rectangle = {{ from = [-2, -1], to = [2, 0], cells = [{cells}, 2] }} }}\nmaterial = {{ young = 1000, poisson = 0.3 }}\nfix = [{{ side = \"bottom\", x = 0, y = 0 }}]\n[[body]]\nname = \"b\"\nmesh = {{ ring = {{ center = [0.1, 0.25], inner = 0.1, outer = 0.25, cells = [32, 3] }} }}\nmaterial = {{ young = 1000, poisson = 0.3 }}\nfix = [{{ side = \"inner\", x = 0 }}]\nload = [{{ side = \"inner\", force = [0, -7] }}]\n[[contact]]\nname = \"c\"\nnonmortar = \"{nonmortar}\"\nmortar = \"{mortar}\"\n"
        );
        let case = Case::<2>::from_str(&text, "case.toml", Path::new("."));
        case.unwrap().model
    };
    let words = "have sunk";
    assert!(warned(&on(3, "a.top", "b.outer"), words));
    assert!(!warned(&on(200, "a.top", "b.outer"), words));
    assert!(!warned(&on(64, "b.outer", "a.top"), words));
}

/// A free body in the way of a wider one that comes down goes along: nothing presses, nothing overlaps.
#[test]
fn a_body_that_goes_along_overlaps_nothing() {
    let text = r#"
analysis = "plane-strain"
[[body]]
name = "a"
mesh = { rectangle = { from = [0, 0], to = [1, 1], cells = [2, 2] } }
material = { young = 1000, poisson = 0.2 }
[[body]]
name = "b"
mesh = { rectangle = { from = [-0.25, 1], to = [1.25, 2], cells = [3, 2] } }
material = { young = 1000, poisson = 0.2 }
fix = [{ side = "top", x = -0.005, y = -0.01 }]
[[contact]]
name = "c"
nonmortar = "b.bottom"
mortar = "a.top"
"#;
    let case = Case::<2>::from_str(text, "case.toml", Path::new("."));
    let model = case.unwrap().model;
    let solution = model.solve().unwrap();
    assert!(
        solution.bodies[0]
            .displacement
            .iter()
            .all(|u| (u[1] + 0.01).abs() < 1e-12)
    );
    assert!(!warned(&model, "overlap"));
}

/// A stiff punch on a soft block that is finer below it, and coarser everywhere else.
#[test]
fn a_side_is_finer_than_the_softer_one_where_they_face_each_other() {
    let on = |cells: usize, graded: bool| {
        let mut model = Model::<2>::new();
        let block = rectangle([-4.0, -1.0], [4.0, 0.0], [cells, 4]);
        let grade = |[x, y]: Point<2>| [if graded { 0.25 * x * x.abs() } else { x }, y];
        let block = model.body("block", block.map_points(grade).unwrap(), SOFT);
        let stiff = Elastic {
            young: 100.0 * SOFT.young,
            ..SOFT
        };
        let punch = rectangle([-0.25, 0.0], [0.25, 0.5], [5, 4]);
        let punch = model.body("punch", punch, stiff);
        model
            .fix(block, "bottom", [Some(0.0), Some(0.0)])
            .fix(punch, "top", [Some(0.0), Some(-1e-3)])
            .contact((punch, "bottom"), (block, "top"));
        model
    };
    let words = "multipliers finer than the softer side";
    assert!(warned(&on(65, false), words));
    assert!(!warned(&on(65, true), words));
}

/// A stiff block on a soft one, pressed by a load that the rounding of their coordinates is more than, in the stiff one: its finer
/// multipliers have forces that nothing tells. As mortar side it has none, and the pressure is the load.
#[test]
fn forces_that_rounding_decides_are_no_answer() {
    let on = |stiff: f64, finer: bool| {
        let mut model = Model::<2>::new();
        let material = |times: f64| Elastic {
            young: times * SOFT.young,
            poisson: 0.0,
        };
        let soft = rectangle([0.0, 0.0], [1.0, 1.0], [5, 3]);
        let soft = model.body("soft", soft, material(1.0));
        let hard = rectangle([0.0, 1.0 - 1e-7], [1.0, 1.6], [8, 3]);
        let hard = model.body("hard", hard, material(stiff));
        let sides = [(hard, "bottom"), (soft, "top")];
        model
            .fix(soft, "bottom", [None, Some(0.0)])
            .fix(soft, "left", [Some(0.0), None])
            .fix(hard, "left", [Some(0.0), None])
            .press(hard, "top", 1e-6 * SOFT.young);
        match finer {
            true => model.contact(sides[0], sides[1]),
            false => model.contact(sides[1], sides[0]),
        };
        model
    };
    // of 1e15 the exact step does not tell the forces apart at all
    let mut rough = on(1e15, true);
    rough.contacts[0].law = Law::Coulomb(0.3.into());
    for wrong in [on(1e9, true), on(1e15, true), rough] {
        let Err(Error::NotConverged { reason, .. }) = wrong.solve() else {
            panic!("rounding of 1e-16 beside strains of 1e-15");
        };
        let told = reason.to_string();
        let words =
            "rounding of coordinates and displacements decides forces of contact \"contact_1\"";
        assert!(told.contains("rounding ") && told.contains(words), "{told}");
    }
    for (right, known) in [(on(1e9, false), 0.0), (on(1e3, true), 1e-4)] {
        let answer = right.solve().unwrap();
        let relative = answer.certificate.rounding.relative;
        assert!(relative <= known && (relative == 0.0) == (known == 0.0));
        for node in &answer.contacts[0].nodes {
            assert!(
                (node.pressure / SOFT.young - 1e-6).abs() < 1e-9,
                "{}",
                node.pressure
            );
        }
    }
}

/// A finer ring of the same material in a coarse one, pressed by an overlap: it answers the corners of the other, which a coarser
/// one does not, nor one that is finer than facets of second order.
#[test]
fn a_side_is_finer_than_one_whose_corners_it_shows() {
    let ring = |[inner, outer]: [f64; 2], cells: usize, cell: CellKind| Ring {
        center: [0.0, 0.0],
        inner,
        outer,
        angles: None,
        cells: [cells, 4],
        ratio: 1.0,
        grade: 1.0,
        cell,
        diagonals: Diagonals::default(),
    };
    let pressed = |own: usize, others: usize, cell: CellKind| {
        let mut model = Model::<2>::new();
        let shaft = ring([10.0, 20.0025], own, cell).build().unwrap();
        let hub = ring([20.0, 30.0], others, cell).build().unwrap();
        let shaft = model.body("shaft", shaft, SOFT);
        let hub = model.body("hub", hub, SOFT);
        model
            .fix(hub, "outer", [Some(0.0), Some(0.0)])
            .contact((shaft, "outer"), (hub, "inner"));
        model
    };
    let words = "multipliers finer than the softer side";
    let spread = |model: &Model<2>| {
        let nodes = &model.solve().unwrap().contacts[0].nodes;
        let pressures = nodes.iter().map(|node| node.pressure);
        let most = pressures.clone().fold(0.0, f64::max);
        most / pressures.fold(f64::INFINITY, f64::min) - 1.0
    };
    let finer = pressed(128, 16, CellKind::Quad4);
    assert!(warned(&finer, words) && spread(&finer) > 0.05);
    for right in [
        pressed(16, 128, CellKind::Quad4),
        pressed(44, 40, CellKind::Quad4),
        pressed(128, 16, CellKind::Quad8),
    ] {
        assert!(!warned(&right, words) && spread(&right) < 0.01);
    }
}

#[test]
fn bodies_of_different_thickness_are_told() {
    let stack = |thickness: f64| {
        let mut model = Model::<2>::new();
        let low = model.body("low", rectangle([0.0, 0.0], [1.0, 1.0], [4, 4]), SOFT);
        let up = model.body("up", rectangle([0.0, 1.0], [1.0, 2.0], [4, 4]), SOFT);
        model.bodies[1].thickness = thickness;
        model
            .fix(low, "bottom", [Some(0.0), Some(0.0)])
            .fix(up, "left", [Some(0.0), None])
            .press(up, "top", 0.1)
            .contact((up, "bottom"), (low, "top"));
        model
    };
    let words = "are over the thickness of the first";
    assert!(warned(&stack(2.0), words));
    assert!(!warned(&stack(1.0), words));
}

/// A dozen strips that are drawn out by more and more, each on its own, in two steps.
#[test]
fn what_is_wrong_with_a_dozen_bodies_is_told_once_with_the_worst() {
    let mut text =
        "analysis = \"plane-strain\"\n[[step]]\ntime = 1\n[[step]]\ntime = 2\n".to_string();
    for k in 0..12 {
        let low = 2 * k;
        text += &format!(
            "[[body]]\nname = \"strip_{k}\"\nmesh = {{ rectangle = {{ from = [0, {low}], to = [1, {}], cells = [4, 4] }} }}\n\
             material = {{ young = 100, poisson = 0.3 }}\n\
             fix = [{{ side = \"left\", x = 0 }}, {{ side = \"right\", x = \"(0.06 + 0.001*{k})*t\" }}, {{ side = \"bottom\", y = 0 }}]\n",
            low + 1
        );
    }
    let case = dotyk::case::Case::<2>::from_str(&text, "strips.toml", "".as_ref()).unwrap();
    let run = case.run(&[], &mut |_| {});
    let expected = |part: f64| {
        format!(
            "body \"strip_11\" is strained by up to {part:.1} %: the theory is for small strains and rotations, and off by about as much; likewise \"strip_0\", \"strip_1\", \"strip_2\", \"strip_3\" and 7 more"
        )
    };
    assert_eq!(run.steps[0].warnings, [expected(7.1)]);
    assert_eq!(run.steps[1].warnings, [expected(14.2)]);
    assert_eq!(
        run.warnings(),
        [expected(14.2) + " (in 2 steps, here most)"]
    );
}

/// Supports of both sides of a tie may move them alike, and nowhere apart.
#[test]
fn supports_that_tear_a_tie_are_refused() {
    let tied = |lower: &str, upper: &str, cells: usize| {
        let text = format!(
            "analysis = \"plane-stress\"\n\
             [[body]]\nname = \"lower\"\nmesh = {{ rectangle = {{ from = [0, -1], to = [1, 0], cells = [3, 2], cell = \"quad8\" }} }}\n\
             material = {{ young = 1000, poisson = 0 }}\n\
             fix = [{{ side = \"bottom\", x = 0, y = 0 }}, {{ side = \"top\", {lower} }}]\n\
             [[body]]\nname = \"upper\"\nmesh = {{ rectangle = {{ from = [0, 0], to = [1, 1], cells = [{cells}, 2], cell = \"quad8\" }} }}\n\
             material = {{ young = 1000, poisson = 0 }}\n\
             fix = [{{ side = \"top\", x = 0, y = 0 }}, {{ side = \"bottom\", {upper} }}]\n\
             [[contact]]\nname = \"glue\"\nnonmortar = \"upper.bottom\"\nmortar = \"lower.top\"\ntied = true\n\
             [[step]]\ntime = 0\n[[step]]\ntime = 1\n"
        );
        let case = dotyk::case::Case::<2>::from_str(&text, "tie.toml", "".as_ref());
        let solved = case.unwrap().model.solve_steps();
        solved
            .map(|steps| steps.len())
            .map_err(|error| error.to_string())
    };
    for cells in [2, 3] {
        for (lower, upper) in [
            ("y = 0", "y = \"0.01*t\""),
            ("x = \"t/100\"", "x = 0"),
            ("y = \"0.01*t\"", "y = \"-0.01*t\""),
        ] {
            let told = tied(lower, upper, cells).unwrap_err();
            assert!(
                told.contains("\"glue\"") && told.contains("both are held at"),
                "{told}"
            );
        }
        // a part of one side that comes to lie on a node of the other one
        let bent = tied(
            "y = \"0.01*x*t\"",
            "y = \"0.01*x*t + 0.001*t*max(0, x - 0.6)\"",
            cells,
        );
        let told = bent.unwrap_err();
        let at_end = "both are held at (1, 0) and move by 4.000e-4";
        let found = if cells == 2 {
            at_end
        } else {
            "both are held at"
        };
        assert!(told.contains(found), "{told}");
        // together, turned together, or one side alone
        for (lower, upper) in [
            ("y = \"0.01*t\"", "y = \"0.01*t\""),
            ("y = \"0.1*x*t\"", "y = \"0.1*x*t\""),
            ("y = \"t/100\"", "x = 0"),
        ] {
            assert_eq!(tied(lower, upper, cells), Ok(2), "{lower} {upper}");
        }
    }
}

/// The same against an obstacle that is moved, in every direction.
#[test]
fn supports_that_tear_a_tie_from_an_obstacle_are_refused() {
    let tied = |upper: &str, motion: &str| {
        let text = format!(
            "analysis = \"plane-strain\"\n\
             [[body]]\nname = \"upper\"\nmesh = {{ rectangle = {{ from = [0, 0], to = [1, 1], cells = [3, 2], cell = \"quad8\" }} }}\n\
             material = {{ young = 1000, poisson = 0.3 }}\n\
             fix = [{{ side = \"top\", x = 0, y = 0 }}, {{ side = \"bottom\", {upper} }}]\n\
             [[contact]]\nname = \"glue\"\nnonmortar = \"upper.bottom\"\ntied = true\n\
             obstacle = {{ plane = {{ point = [0, 0], normal = [0, 1] }}, displacement = {motion} }}\n"
        );
        let case = dotyk::case::Case::<2>::from_str(&text, "tie.toml", "".as_ref());
        let solved = case.unwrap().model.solve_steps();
        solved.map(|_| ()).map_err(|error| error.to_string())
    };
    for (upper, motion) in [("y = 0", "[0, -0.01]"), ("x = 0", "[0.01, 0]")] {
        let told = tied(upper, motion).unwrap_err();
        assert!(
            told.contains("move by 1.000e-2 against each other"),
            "{told}"
        );
    }
    for (upper, motion) in [("y = -0.01", "[0, -0.01]"), ("x = 0", "[0, 0.01]")] {
        assert_eq!(tied(upper, motion), Ok(()), "{upper}");
    }
}
