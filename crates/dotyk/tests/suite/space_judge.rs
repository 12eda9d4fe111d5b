//! What the certificate passed in space, or the program left out without a word: each problem here was once wrong so.

use dotyk::case::Case;
use dotyk::geometry::Point;
use dotyk::model::Solution;
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
