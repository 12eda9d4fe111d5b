//! What the certificate passed in space, or the program left out without a word: each problem here was once wrong so.

use dotyk::case::Case;
use dotyk::geometry::{Field, Point};
use dotyk::mesh::{CellKind, Cuboid, Mesh};
use dotyk::model::{Elastic, Error, Law, Model, Pairing, Place, Solution};
use std::path::Path;

fn solve(text: &str) -> Solution<3> {
    let text = format!("analysis = \"3d\"\n{text}");
    let case = Case::<3>::from_str(&text, "case.toml", Path::new(".")).unwrap();
    case.model.solve().unwrap()
}

/// A ball of radius 1, E = 1, ν = 0.3.
fn ball(center: Point<3>, cell: &str, more: &str) -> String {
    format!(
        "[[body]]\nname = \"ball\"\n\
         mesh = {{ sphere = {{ center = {center:?}, radius = 1.0, cells = [8, 1], cell = \"{cell}\" }} }}\n\
         material = {{ young = 1.0, poisson = 0.3 }}\n{more}\n"
    )
}

fn warned(solution: &Solution<3>, words: &str) -> bool {
    solution.warnings.iter().any(|w| w.contains(words))
}

/// Where it hovers was the difference of motions as large as itself, node by node: their rounding strained it.
#[test]
fn what_hovers_is_not_strained() {
    let plane = |name: &str, height: f64, up: f64| {
        format!(
            "[[contact]]\nname = \"{name}\"\nnonmortar = \"ball.outer\"\n\
             obstacle = {{ plane = {{ point = [30, 40, {height}], normal = [0, 0, {up}] }} }}\n"
        )
    };
    let both = plane("floor", -0.3, 1.0) + &plane("roof", 2.1, -1.0);
    let solution = solve(&(ball([30.0, 40.0, 1.0], "tet4", "") + &both));
    assert!(warned(&solution, "hovers"));
    // the square of what is rounding, times E
    let stresses = solution.bodies[0].von_mises.iter();
    let largest = stresses.fold(0.0, |s: f64, v| s.max(*v));
    assert!(largest < 1e-28, "{largest:e}");
}

/// One node carries a ball in a groove. It could turn about that until the next one touches, and did, by any angle in between.
#[test]
fn what_one_node_carries_does_not_turn() {
    let groove = "[[contact]]\nname = \"groove\"\nnonmortar = \"ball.outer\"\n\
         obstacle = { cylinder = { point = [0, 0, 2.58], axis = [0.8393, 0.5436, 0], radius = 2.58, inside = true }, displacement = [0, 0, 3e-5] }\n";
    let weight = "body_force = [0, 0, -2.3e-5]";
    let solution = solve(&(ball([0.0, 0.0, 1.0], "hex8", weight) + groove));
    assert!(solution.converged);
    // it sinks by some 1e-3, as the polyhedron is placed on the groove
    let moves = solution.bodies[0].displacement.iter().flatten();
    let largest = moves.fold(0.0, |s: f64, u| s.max(u.abs()));
    assert!(largest < 5e-3, "{largest:e}");
}

/// A ball between a block and a plate, whose weight three nodes find only after corrections: these do not begin from where least
/// norm would place it.
#[test]
fn what_is_found_by_corrections_is_placed_behind_them() {
    let bodies = "[[body]]\nname = \"ball\"\n\
         mesh = { sphere = { center = [0, 0, 1], radius = 1, cells = [12, 1], cell = \"hex8\" } }\n\
         material = { young = 2.9064348074291737, poisson = 0.3592562797445302 }\n\
         body_force = [0, 0, -1.0586583005979451e-7]\n\
         surface = { outer = { sphere = { center = [0, 0, 1], radius = 1 } } }\n\
         [[body]]\nname = \"lower\"\n\
         mesh = { box = { from = [-1.1088950887522873, -1.1088950887522873, -0.6], to = [1.1088950887522873, 0.9, 0], cells = [3, 2, 1], cell = \"tet10\" } }\n\
         material = { young = 1, poisson = 0.15999339742781 }\n\
         fix = [{ side = \"bottom\", x = 0, y = 0, z = 0 }]\n";
    let contacts = "[[contact]]\nname = \"c0\"\nnonmortar = \"ball.outer\"\nmortar = \"lower.top\"\n\
         [[contact]]\nname = \"c1\"\nnonmortar = \"ball.outer\"\n\
         obstacle = { plane = { point = [0, 0, 2], normal = [0, 0, -1] }, displacement = [-8.903213016209021e-6, 3.673871719543231e-5, -1.5879874508969175e-5] }\n";
    let solution = solve(&format!("{bodies}{contacts}"));
    assert!(solution.converged);
}

const CONCRETE: Elastic = Elastic {
    young: 1000.0,
    poisson: 0.25,
};

/// How much the joint leans to the rollers.
const LEAN: f64 = 0.2;

/// A box whose face at y = 1 leans: y = 1 + LEAN·z.
fn leaning(from: f64, to: f64, cells: [usize; 3]) -> Mesh<3> {
    let cuboid = Cuboid {
        from: [0.0, from, -0.5],
        to: [1.0, to, 0.5],
        cells,
        cell: CellKind::Hex8,
    };
    let lean = |[x, y, z]: Point<3>| [x, y + LEAN * z * (1.0 - (y - 1.0).abs()), z];
    cuboid.build().unwrap().map_points(lean).unwrap()
}

/// Two blocks with a joint that leans, pressed by 1 between rollers on both of their ends z = ±0.5.
fn between_rollers(upper: [usize; 3]) -> Model<3> {
    let mut model = Model::new();
    let blocks = [
        model.body("lower", leaning(0.0, 1.0, [2, 2, 3]), CONCRETE),
        model.body("upper", leaning(1.0, 2.0, upper), CONCRETE),
    ];
    for block in blocks {
        for end in ["bottom", "top"] {
            model.fix(block, end, [None, None, Some(0.0)]);
        }
        model.fix(block, "left", [Some(0.0), None, None]);
    }
    model.fix(blocks[0], "front", [None, Some(0.0), None]);
    model.pull(blocks[1], "back", [0.0, -1.0, 0.0]);
    let joint = model.contact((blocks[1], "front"), (blocks[0], "back"));
    joint.law = Law::Coulomb(Field::constant(0.5));
    model
}

/// σ_yy = −1, σ_zz = −ν between the rollers: the lower block pushes the upper one by 1 along y and −ν·LEAN along z.
#[test]
fn rollers_on_both_sides_leave_an_oblique_joint_its_shear() {
    for cells in [[3, 2, 4], [2, 2, 3]] {
        let mut model = between_rollers(cells);
        model.contacts[0].pairing = Some(Pairing::Mortar);
        let solution = model.solve().unwrap();
        assert!(!warned(&solution, "oblique"));
        let [_, y, z] = solution.contacts[0].resultant;
        assert!((y - 1.0).abs() < 1e-9, "{y}");
        assert!((z + CONCRETE.poisson * LEAN).abs() < 1e-9, "{z}");
        for node in &solution.contacts[0].nodes {
            let normal = (1.0 + CONCRETE.poisson * LEAN * LEAN) / (1.0 + LEAN * LEAN);
            assert!((node.pressure - normal).abs() < 1e-9, "{node:?}");
        }
    }
}

#[test]
fn shear_that_rollers_on_both_sides_take_from_an_oblique_joint_is_told() {
    let words = "oblique to the contact";
    // node by node the forces are along what the rollers leave free
    let solution = between_rollers([2, 2, 3]).solve().unwrap();
    assert!(warned(&solution, words));
    // one facet between the rollers: no node has neighbours without
    let mut model = between_rollers([3, 2, 1]);
    model.contacts[0].pairing = Some(Pairing::Mortar);
    assert!(warned(&model.solve().unwrap(), words));
}

/// The lower edge of a block's front lies in its sole and is moved down with that.
#[test]
fn nodes_that_supports_push_into_the_other_side_are_told() {
    let cuboid = |name: &str, from: Point<3>, to: Point<3>, n: usize, fix: &str| {
        format!(
            "[[body]]\nname = \"{name}\"\nmesh = {{ box = {{ from = {from:?}, to = {to:?}, cells = [{n}, {n}, {n}] }} }}\n\
             material = {{ young = 1.0, poisson = 0.3 }}\nfix = [{fix}]\n"
        )
    };
    let text = |nonmortar: &str, mortar: &str| {
        cuboid(
            "a",
            [0.0; 3],
            [1.0; 3],
            3,
            "{ side = \"bottom\", x = 0, y = 0, z = 0 }",
        ) + &cuboid(
            "b",
            [0.1, 0.1, 1.0],
            [0.9, 0.9, 2.0],
            2,
            "{ side = \"front\", x = 0, y = 0, z = -0.01 }",
        ) + &format!(
            "[[contact]]\nname = \"c\"\nnonmortar = \"{nonmortar}\"\nmortar = \"{mortar}\"\n"
        )
    };
    let words = "supports hold nodes of its nonmortar side";
    assert!(warned(&solve(&text("b.bottom", "a.top")), words));
    assert!(!warned(&solve(&text("a.top", "b.bottom")), words));
}

/// In space middle nodes carry no multiplier that could be left out.
#[test]
fn middle_nodes_are_not_excluded_in_silence() {
    let excluded = |point: [f64; 3], friction: bool| {
        let mut model = Model::<3>::new();
        let cuboid = |from: f64, cells: [usize; 3]| {
            let cuboid = Cuboid {
                from: [0.0, 0.0, from],
                to: [1.0, 1.0, from + 1.0],
                cells,
                cell: CellKind::Hex20,
            };
            cuboid.build().unwrap()
        };
        let lower = model.body("lower", cuboid(0.0, [1, 1, 1]), CONCRETE);
        let upper = model.body("upper", cuboid(1.0, [2, 2, 1]), CONCRETE);
        model.fix(lower, "bottom", [Some(0.0); 3]);
        model.fix(upper, "top", [Some(0.0), Some(0.0), Some(-1e-3)]);
        let contact = model.contact((upper, "bottom"), (lower, "top"));
        contact.law = Law::Coulomb(Field::constant(0.3));
        match friction {
            true => contact.friction_exclude.push(Place::Point(point)),
            false => contact.exclude.push(Place::Point(point)),
        }
        model.solve().map_err(|error| error.to_string())
    };
    for friction in [false, true] {
        assert!(excluded([0.0, 0.0, 1.0], friction).is_ok());
        let message = excluded([0.25, 0.0, 1.0], friction).err().unwrap();
        assert!(message.contains("name a corner"), "{message}");
    }
}

/// A block far from what could hold it: shears have no distance.
#[test]
fn friction_reaches_no_farther_than_pressure() {
    let text = |friction: &str| {
        format!(
            "analysis = \"3d\"\n{}[[contact]]\nname = \"floor\"\nnonmortar = \"ball.outer\"\n\
             obstacle = {{ plane = {{ point = [0, 0, -1e8], normal = [0, 0, 1] }} }}\n{friction}\n",
            ball([0.0, 0.0, 1.0], "hex8", "body_force = [0, 0, -1e-5]")
        )
    };
    for friction in ["", "friction = 0.5"] {
        let case = Case::<3>::from_str(&text(friction), "case.toml", Path::new(".")).unwrap();
        let message = case.model.solve().err().unwrap().to_string();
        assert!(message.contains("out of reach"), "{message}");
    }
}

/// Neither the middle of a facet nor a line half way to its corners met the other side: the nodes were paired one by one, and none
/// had a partner.
#[test]
fn a_strip_of_a_hundredth_of_a_facet_bears() {
    for [nonmortar, mortar] in [["a.top", "b.bottom"], ["b.bottom", "a.top"]] {
        for width in [0.2, 0.02] {
            let (from, to) = (2.0 - width, 4.0 - width);
            let solution = solve(&format!(
                "[[body]]\nname = \"a\"\n\
                 mesh = {{ box = {{ from = [0, 0, 0], to = [2, 2, 2], cells = [2, 2, 2] }} }}\n\
                 material = {{ young = 100.0, poisson = 0.3 }}\n\
                 fix = [{{ side = \"bottom\", x = 0, y = 0, z = 0 }}]\n\
                 [[body]]\nname = \"b\"\n\
                 mesh = {{ box = {{ from = [{from}, -0.3, 2], to = [{to}, 1.7, 4], cells = [2, 2, 2] }} }}\n\
                 material = {{ young = 100.0, poisson = 0.3 }}\n\
                 fix = [{{ side = \"top\", x = 0, y = 0, z = -0.01 }}]\n\
                 [[contact]]\nname = \"joint\"\nnonmortar = \"{nonmortar}\"\nmortar = \"{mortar}\"\n"
            ));
            let joint = &solution.contacts[0];
            let area = 1.7 * width;
            let facing = joint.nodes.iter().filter(|node| !node.gap.is_nan());
            let facing: f64 = facing.map(|node| node.weight).sum();
            assert!((facing - area).abs() < 1e-9, "{facing}");
            let force = joint.resultant[2].abs();
            assert!(force > 0.05, "{width} {nonmortar}: {force}");
        }
    }
}

/// The forces of nodes reach less far than facets of which only a part faces something: no load "pulls away" what the sides hold.
#[test]
fn a_load_beyond_the_reach_of_coarse_facets_is_told_from_one_that_nothing_holds() {
    let error = |cells: [usize; 3], x: f64| {
        let text = format!(
            "analysis = \"3d\"\n\
             [[body]]\nname = \"base\"\n\
             mesh = {{ box = {{ from = [-0.6, -0.55, -0.5], to = [0.6, 0.55, 0.0], cells = {cells:?}, cell = \"tet10\" }} }}\n\
             material = {{ young = 1000.0, poisson = 0.3 }}\n\
             fix = [{{ side = \"bottom\", x = 0.0, y = 0.0, z = 0.0 }}]\n\
             [[body]]\nname = \"block\"\n\
             mesh = {{ box = {{ from = [-0.82, -0.33, 0.0], to = [-0.12, 0.34, 0.5], cells = [4, 4, 2], cell = \"hex8\" }} }}\n\
             material = {{ young = 1000.0, poisson = 0.3 }}\n\
             load = [{{ side = \"top\", pressure = \"max(0, -y - 0.1)*max(0, 0.1 - abs(x - ({x})))\" }}]\n\
             [[contact]]\nname = \"foot\"\nnonmortar = \"base.top\"\nmortar = \"block.bottom\"\n"
        );
        let case = Case::<3>::from_str(&text, "case.toml", Path::new(".")).unwrap();
        case.model.solve().err()
    };
    // its middle lies within both, close to a corner of what they share
    let coarse = error([2, 2, 1], -0.45);
    assert!(
        matches!(&coarse, Some(Error::OutOfReach { body, contacts, .. }) if body == "block" && contacts == "\"foot\""),
        "{coarse:?}"
    );
    assert_eq!(error([6, 6, 1], -0.45).map(|error| error.to_string()), None);
    // and here beside the base
    let beside = error([2, 2, 1], -0.7);
    assert!(
        matches!(&beside, Some(Error::PulledAway { body, .. }) if body == "block"),
        "{beside:?}"
    );
}
