//! Rigid tools of any shape: as planes and circles where they are flat or round, pressed where their edges are, clear words for files
//! and outlines that are none.

use crate::norms::difference;
use dotyk::case::Case;
use dotyk::geometry::{distance, norm};
use dotyk::model::Solution;
use proptest::prelude::*;
use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

fn read<const D: usize>(text: &str, folder: &Path) -> Case<D>
where
    Case<D>: Reads,
{
    Case::<D>::of(text, folder).unwrap_or_else(|error| panic!("{error}"))
}

/// A case of either dimension from its text.
trait Reads: Sized {
    fn of(text: &str, folder: &Path) -> Result<Self, String>;
}

impl Reads for Case<2> {
    fn of(text: &str, folder: &Path) -> Result<Self, String> {
        Self::from_str(text, "case.toml", folder).map_err(|error| error.message)
    }
}

impl Reads for Case<3> {
    fn of(text: &str, folder: &Path) -> Result<Self, String> {
        Self::from_str(text, "case.toml", folder).map_err(|error| error.message)
    }
}

fn plane(text: &str) -> Vec<Solution<2>> {
    read::<2>(text, Path::new(".")).model.solve_steps().unwrap()
}

/// A folder of this test with a file.
fn folder(name: &str, files: &[(&str, &[u8])]) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR"))
        .join("tools")
        .join(name);
    fs::create_dir_all(&folder).unwrap();
    for (file, content) in files {
        fs::write(folder.join(file), content).unwrap();
    }
    folder
}

const BLOCK: &str = r#"
analysis = "plane-strain"
[[body]]
name = "block"
mesh = { rectangle = { from = [0, 0], to = [4, 2], cells = [9, 4], cell = "quad9" } }
material = { young = 1000, poisson = 0.3 }
fix = [{ side = "bottom", x = 0, y = 0 }]
[[contact]]
name = "c"
nonmortar = "block.top"
obstacle = { SHAPE }
MORE
[[step]]
time = 1
[[step]]
time = 2
"#;

fn block(shape: &str, more: &str) -> String {
    BLOCK.replace("SHAPE", shape).replace("MORE", more)
}

#[test]
fn a_flat_tool_is_a_plane() {
    for (motion, more) in [
        ("displacement = [0, \"-0.01*t\"]", "pairing = \"mortar\""),
        (
            "displacement = [\"0.02*(t-1)\", -0.01]",
            "pairing = \"mortar\"\nfriction = 0.2",
        ),
        ("force = [0, \"-20*t\"]", "pairing = \"mortar\""),
        (
            "force = [\"2*(t-1)\", -20]",
            "pairing = \"mortar\"\nfriction = { tresca = 3 }",
        ),
    ] {
        let flat = format!("outline = [[-1, 2], [0.7, 2], [2.61, 2], [6, 2]], {motion}");
        let flat = plane(&block(&flat, more));
        let whole = format!("plane = {{ point = [0, 2], normal = [0, -1] }}, {motion}");
        let whole = plane(&block(&whole, more));
        for (flat, whole) in flat.iter().zip(&whole) {
            let off = difference(flat, whole);
            assert!(off < 1e-9, "{motion}: {off:e}");
            let [a, b] = [flat, whole].map(|s| s.contacts[0].resultant);
            assert!(distance(a, b) < 1e-9 * norm(b), "{a:?} {b:?}");
        }
    }
}

#[test]
fn an_arc_is_its_circle() {
    let fine = |text: String| text.replace("cells = [9, 4]", "cells = [80, 20]");
    let motion = "displacement = [0, -0.02]";
    // from the left along the lower half: the solid is on the left of the way
    let arc = format!("outline = [[-1, 5], {{ to = [5, 5], center = [2, 5] }}], {motion}");
    let circle = format!("circle = {{ center = [2, 5], radius = 3 }}, {motion}");
    let [arc, circle] =
        [arc, circle].map(|shape| plane(&fine(block(&shape, "pairing = \"mortar\""))));
    // the same true circle, but cut into facets of three degrees, between whose ends points opposite lie on chords
    let off = difference(&arc[1], &circle[1]);
    assert!(off < 1e-3, "{off:e}");
    let most = |s: &Solution<2>| {
        s.contacts[0]
            .nodes
            .iter()
            .map(|n| n.pressure)
            .fold(0.0, f64::max)
    };
    let (a, b) = (most(&arc[1]), most(&circle[1]));
    assert!((a - b).abs() < 1e-3 * b, "{a} {b}");
    let [a, b] = [&arc[1], &circle[1]].map(|s| s.contacts[0].resultant[1]);
    assert!((a - b).abs() < 1e-4 * b.abs(), "{a} {b}");
}

#[test]
fn a_tool_presses_where_its_edges_are() {
    // between two nodes, in the middle of the block: by symmetry the force acts there
    let narrow = block(
        "outline = [[1.3, 4], [1.9, 2], [2.1, 2], [2.7, 4]], force = [0, -5]",
        "",
    );
    let solution = &plane(&narrow)[0];
    let contact = &solution.contacts[0];
    assert!((contact.resultant[1] + 5.0).abs() < 1e-9);
    let moment: f64 = contact
        .nodes
        .iter()
        .map(|n| n.point[0] * n.pressure * n.weight)
        .sum();
    assert!((moment - 2.0 * 5.0).abs() < 1e-9, "{moment}");
    // turned with the block, it presses the same
    let (sin, cos) = 0.4f64.sin_cos();
    let turned = |x: f64, y: f64| format!("[{:?}, {:?}]", cos * x - sin * y, sin * x + cos * y);
    let edges = [(1.3, 4.0), (1.9, 2.0), (2.1, 2.0), (2.7, 4.0)].map(|(x, y)| turned(x, y));
    let corners = [(4.0, 0.0), (4.0, 2.0), (0.0, 2.0), (0.0, 0.0)].map(|(x, y)| turned(x, y));
    let upright = |outline: &str, force: &str, mesh: &str| {
        format!(
            "analysis = \"plane-strain\"\n[[body]]\nname = \"block\"\nmesh = {{ outline = {mesh} }}\nmaterial = {{ young = 1000, poisson = 0.3 }}\nfix = [{{ side = \"bottom\", x = 0, y = 0 }}]\n[[contact]]\nname = \"c\"\nnonmortar = \"block.top\"\nobstacle = {{ outline = {outline}, force = {force} }}\n"
        )
    };
    let mesh = |ends: &[String; 4]| {
        format!(
            "{{ size = 9, from = {}, edges = [{{ to = {}, name = \"bottom\", cells = 9 }}, {{ to = {}, cells = 5 }}, {{ to = {}, name = \"top\", cells = 9 }}, {{ to = {}, cells = 5 }}] }}",
            ends[3], ends[0], ends[1], ends[2], ends[3]
        )
    };
    let straight =
        [(4.0, 0.0), (4.0, 2.0), (0.0, 2.0), (0.0, 0.0)].map(|(x, y)| format!("[{x:?}, {y:?}]"));
    let first = upright(
        "[[1.3, 4], [1.9, 2], [2.1, 2], [2.7, 4]]",
        "[0, -5]",
        &mesh(&straight),
    );
    let second = upright(
        &format!("[{}]", edges.join(", ")),
        &turned(0.0, -5.0),
        &mesh(&corners),
    );
    let [a, b] = [first, second].map(|text| plane(&text).remove(0));
    // half of the force on either side of the tip, whose faces meet each node with one condition; the meshes differ in their inner nodes,
    // which makes one half of a block somewhat softer
    for solution in [&a, &b] {
        let nodes = &solution.contacts[0].nodes;
        let mut forces: BTreeMap<usize, f64> = BTreeMap::new();
        for node in nodes.iter().filter(|node| node.pressure != 0.0) {
            *forces.entry(node.node).or_default() += node.pressure * node.weight;
        }
        let forces: Vec<f64> = forces.into_values().collect();
        assert_eq!(forces.len(), 2);
        assert!((forces[0] + forces[1] - 5.0).abs() < 1e-9, "{forces:?}");
        assert!((forces[0] - 2.5).abs() < 0.25, "{forces:?}");
    }
}

/// A block, held at its bottom, whose corner at (1, 1) an obstacle with a face inclined by an angle presses.
fn corner(angle: f64, listed: &str, friction: f64, cell: &str, flat: bool) -> Solution<2> {
    let (sin, cos) = angle.to_radians().sin_cos();
    let (along, normal) = ([cos, -sin], [-sin, -cos]);
    let end = |s: f64| [0, 1].map(|k| 1.0 + s * along[k]);
    let pressed = [0, 1].map(|k| 0.002 * normal[k] - 0.004 * along[k]);
    let shape = match flat {
        true => format!("plane = {{ point = [1, 1], normal = {normal:?} }}"),
        false => format!("outline = [{:?}, {:?}]", end(-3.0), end(3.0)),
    };
    let text = format!(
        "analysis = \"plane-strain\"\n[[body]]\nname = \"a\"\n\
         mesh = {{ rectangle = {{ from = [0, 0], to = [1, 1], cells = [4, 4], cell = \"{cell}\" }} }}\n\
         material = {{ young = 1000, poisson = 0.3 }}\n\
         fix = [{{ side = \"bottom\", x = 0, y = 0 }}, {{ side = \"left\", x = 0 }}]\n\
         [[contact]]\nname = \"c\"\nnonmortar = {listed}\nfriction = {friction}\n\
         obstacle = {{ {shape}, displacement = {pressed:?} }}\n"
    );
    plane(&text).remove(0)
}

/// Where an outline drives the corner of a block at (1, 1), held left and below, and its resultant.
fn driven(outline: &str) -> [[f64; 2]; 2] {
    let text = format!(
        "analysis = \"plane-strain\"\n[[body]]\nname = \"a\"\n\
         mesh = {{ rectangle = {{ from = [0, 0], to = [1, 1], cells = [3, 3], cell = \"quad4\" }} }}\n\
         material = {{ young = 1000, poisson = 0.3 }}\n\
         fix = [{{ side = \"left\", x = 0 }}, {{ side = \"bottom\", x = 0, y = 0 }}]\n\
         [[contact]]\nname = \"c\"\nnonmortar = [\"a.top\", \"a.right\"]\n\
         obstacle = {{ outline = {outline}, displacement = [-0.003, -0.004] }}\n"
    );
    let case = read::<2>(&text, Path::new("."));
    let corner = case.model.bodies[0].mesh.points().iter();
    let corner = corner.clone().position(|&x| distance(x, [1.0, 1.0]) < 1e-9);
    let solution = case.model.solve_steps().unwrap().remove(0);
    let u = solution.bodies[0].displacement[corner.unwrap()];
    [u, solution.contacts[0].resultant]
}

#[test]
fn a_corner_in_a_pocket_has_a_condition_for_each_wall() {
    // a wall on the right, a ceiling that comes down to it by 20 degrees: both are touched, or one of them 0.001 away
    let (slope, reach) = (f64::tan(f64::to_radians(20.0)), 2.8);
    for (wall, ceiling) in [(0.0, 0.001), (0.0, 0.0), (0.001, 0.0), (0.001, 0.001)] {
        let foot = 1.0 + ceiling / f64::cos(f64::to_radians(20.0));
        let end = foot - slope * wall;
        let x = 1.0 + wall;
        let outline = format!(
            "[[{:?}, {:?}], [{x:?}, {end:?}], [{x:?}, {:?}]]",
            x - reach,
            end + slope * reach,
            end - reach
        );
        let [u, _] = driven(&outline);
        // both are reached: the walls have moved by (−0.003, −0.004), and with them the lines on which the corner lies
        let right = wall - 0.003;
        let above = (foot - 1.0) - 0.004 - slope * (u[0] + 0.003);
        assert!((u[0] - right).abs() < 1e-6, "{wall} {ceiling}: {u:?}");
        assert!(
            (u[1] - above).abs() < 1e-6,
            "{wall} {ceiling}: {u:?} {above}"
        );
    }
    // at the apex of a shallow groove both of its faces are touched: the corner goes with it
    let [u, _] = driven("[[-1.598076211353316, 2.5], [1.0, 1.0], [2.5, -1.598076211353316]]");
    assert!(distance(u, [-0.003, -0.004]) < 1e-9, "{u:?}");
}

#[test]
fn a_corner_meets_an_inclined_face_along_its_normal() {
    for (angle, friction, cell) in [
        (3.0, 0.0, "quad4"),
        (10.0, 0.0, "quad8"),
        (10.0, 0.2, "quad4"),
        (30.0, 0.0, "tri3"),
        (45.0, 0.2, "tri6"),
        (80.0, 0.0, "quad4"),
    ] {
        for listed in ["\"a.top\"", "[\"a.top\", \"a.right\"]"] {
            let [flat, drawn] =
                [true, false].map(|flat| corner(angle, listed, friction, cell, flat));
            let unlike = difference(&flat, &drawn);
            assert!(
                unlike < 1e-9,
                "{angle} {friction} {cell} {listed}: {unlike}"
            );
            let [x, y] = drawn.contacts[0].resultant;
            let slope = f64::tan(f64::to_radians(angle));
            assert!(friction > 0.0 || (x / y - slope).abs() < 1e-9 * slope);
        }
    }
}

#[test]
fn what_is_drawn_slides_by_coulombs_law() {
    let cases = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../cases/rigid-tools");
    let text = |name: &str| fs::read_to_string(cases.join(name)).unwrap();
    let wedge = read::<2>(&text("wedge.toml"), &cases)
        .model
        .solve_steps()
        .unwrap();
    let [x, y] = wedge[1].contacts[0].resultant;
    assert!((x + 0.3 * y).abs() < 1e-8 * y.abs(), "{x} {y}");
    let plate = read::<3>(&text("plate.toml"), &cases)
        .model
        .solve_steps()
        .unwrap();
    let [x, y, z] = plate[1].contacts[0].resultant;
    assert!(
        (y + 0.2 * z).abs() < 1e-8 * z.abs() && x.abs() < 1e-8 * z.abs(),
        "{x} {y} {z}"
    );
    assert!(
        plate[1].contacts[0]
            .nodes
            .iter()
            .any(|node| node.gap.is_finite())
    );
}

const CUBE: &str = r#"
analysis = "3d"
[[body]]
name = "block"
mesh = { box = { from = [0, 0, 0], to = [1, 1, 1], cells = [2, 2, 2] } }
material = { young = 1000, poisson = 0.3 }
fix = [{ side = "bottom", x = 0, y = 0, z = 0 }]
[[contact]]
name = "c"
nonmortar = "block.top"
obstacle = { stl = "tool.stl", displacement = [0, 0, -0.01] }
"#;

/// Two triangles at a height, seen from below or above, as text.
fn sheet(height: f64, from_below: bool) -> String {
    let corners = [[-1.0, -1.0], [2.0, -1.0], [2.0, 2.0], [-1.0, 2.0]];
    let triangle = |of: [usize; 3]| {
        let mut of = of;
        if from_below {
            of.swap(1, 2);
        }
        let corners = of.map(|k| format!("vertex {} {} {height}", corners[k][0], corners[k][1]));
        format!(
            "facet normal 0 0 0\nouter loop\n{}\nendloop\nendfacet\n",
            corners.join("\n")
        )
    };
    format!(
        "solid s\n{}{}endsolid s\n",
        triangle([0, 1, 2]),
        triangle([0, 2, 3])
    )
}

#[test]
fn an_open_sheet_is_a_plane_of_space() {
    let at = folder("sheet", &[("tool.stl", sheet(1.0, true).as_bytes())]);
    let sheet = read::<3>(CUBE, &at).model.solve().unwrap();
    let plane = CUBE
        .replace(
            "stl = \"tool.stl\"",
            "plane = { point = [0, 0, 1], normal = [0, 0, -1] }",
        )
        .replace("name = \"c\"", "name = \"c\"\npairing = \"mortar\"");
    let plane = read::<3>(&plane, &at).model.solve().unwrap();
    assert!(difference(&sheet, &plane) < 1e-9);
}

#[test]
fn an_edge_and_a_corner_of_a_box_meet_an_inclined_sheet_along_its_normal() {
    let three = "[\"cube.top\", \"cube.right\", \"cube.back\"]";
    // in one layer of cells held nodes share the facets of the corner; a sheet may cover a part of these
    for (toward, cell, listed, layers, reach) in [
        (
            [0.3, 0.0, 0.95f64],
            "hex8",
            "[\"cube.top\", \"cube.right\"]",
            2,
            9.0,
        ),
        ([0.6, 0.0, 0.8], "tet10", "\"cube.top\"", 2, 9.0),
        ([0.4, 0.7, 0.6], "tet4", three, 2, 9.0),
        ([0.4, 0.7, 0.6], "hex8", three, 1, 9.0),
        ([0.4, 0.6, 0.7], "tet4", three, 1, 9.0),
        ([0.5, 0.6, 0.7], "hex8", three, 2, 0.2),
    ] {
        let size = norm(toward);
        let up = toward.map(|c| c / size);
        // a triangle around the corner (1, 1, 1), seen from below
        let (a, b) = (
            [up[2], 0.0, -up[0]],
            [-up[0] * up[1], 1.0 - up[1] * up[1], -up[1] * up[2]],
        );
        let at = |s: f64, t: f64| {
            [0, 1, 2]
                .map(|k| 1.0 + s * a[k] + t * b[k])
                .map(|c| format!("{c:?}"))
                .join(" ")
        };
        let facet = [at(-reach, -reach), at(0.0, reach), at(reach, -reach)];
        let stl = format!(
            "solid s\nfacet normal 0 0 0\nouter loop\nvertex {}\nvertex {}\nvertex {}\nendloop\nendfacet\nendsolid s\n",
            facet[0], facet[1], facet[2]
        );
        let name = format!("leaning_{cell}_{layers}_{reach}");
        let at = folder(&name, &[("tool.stl", stl.as_bytes())]);
        let pressed = up.map(|c| -0.002 * c);
        let text = |shape: &str| {
            format!(
                "analysis = \"3d\"\n[[body]]\nname = \"cube\"\n\
                 mesh = {{ box = {{ from = [0, 0, 0], to = [1, 1, 1], cells = [2, 2, {layers}], cell = \"{cell}\" }} }}\n\
                 material = {{ young = 1000, poisson = 0.3 }}\n\
                 fix = [{{ side = \"bottom\", x = 0, y = 0, z = 0 }}]\n\
                 [[contact]]\nname = \"c\"\nnonmortar = {listed}\n\
                 obstacle = {{ {shape}, displacement = {pressed:?} }}\n"
            )
        };
        let normal = up.map(|c| -c);
        let flat = text(&format!(
            "plane = {{ point = [1, 1, 1], normal = {normal:?} }}"
        ));
        let [flat, drawn] = [flat, text("stl = \"tool.stl\"")]
            .map(|text| read::<3>(&text, &at).model.solve().unwrap());
        assert!(difference(&flat, &drawn) < 1e-9, "{cell}");
        let force = drawn.contacts[0].resultant;
        let along = force.iter().zip(up).map(|(f, n)| f * n).sum::<f64>();
        assert!(
            (along.abs() - norm(force)).abs() < 1e-9 * norm(force),
            "{force:?}"
        );
    }
}

#[test]
fn what_is_no_tool_is_told() {
    let told = |files: &[(&str, &[u8])], name: &str, text: &str| -> String {
        let at = folder(name, files);
        match Case::<3>::of(text, &at) {
            Err(message) => message,
            Ok(case) => case
                .model
                .solve()
                .map(|_| String::new())
                .unwrap_or_else(|e| e.to_string()),
        }
    };
    let back = sheet(1.1, false);
    let error = told(&[("tool.stl", back.as_bytes())], "back", CUBE);
    assert!(
        error.contains("tool.stl") && error.contains("backs"),
        "{error}"
    );
    let whole = sheet(1.0, true);
    let cut = &whole.as_bytes()[..whole.len() / 2];
    let error = told(&[("tool.stl", cut)], "cut", CUBE);
    assert!(
        error.contains("tool.stl") && error.contains("cut off"),
        "{error}"
    );
    let error = told(
        &[("tool.stl", b"solid none\nendsolid none\n")],
        "none",
        CUBE,
    );
    assert!(
        error.contains("tool.stl") && error.contains("no triangles"),
        "{error}"
    );
    let error = told(&[], "missing", CUBE);
    assert!(
        error.contains("tool.stl") && error.contains("no such file"),
        "{error}"
    );
    let outline = CUBE.replace("stl = \"tool.stl\"", "outline = [[0, 0], [1, 0]]");
    let error = told(&[], "outline", &outline);
    assert!(
        error.contains("`outline` is a tool of space") || error.contains("plane"),
        "{error}"
    );
    for (shape, word) in [
        ("stl = \"tool.stl\"", "`stl`"),
        ("outline = []", "empty"),
        ("outline = [[0, 2]]", "edges"),
        ("outline = [[0, 2], [0, 2], [1, 2]]", "begins and ends"),
        (
            "outline = [[0, 2], { to = [4, 2], center = [1, 3] }]",
            "center",
        ),
        (
            "outline = [[0, 2], [4, 2]], circle = { center = [0, 0], radius = 1 }",
            "exactly one",
        ),
    ] {
        let text = block(shape, "");
        let error = Case::<2>::of(&text, Path::new(".")).unwrap_err();
        assert!(error.contains(word), "{shape}: {error}");
    }
    let turned = plane_error(&block(
        "outline = [[5, 2.1], [-1, 2.1]], displacement = [0, -0.2]",
        "",
    ));
    assert!(turned.contains("backs"), "{turned}");
}

#[test]
fn a_tool_that_sinks_where_nothing_holds_it_is_seen() {
    // beyond the named side: its nose ends in the body
    let beside = block(
        "outline = [[2, 3], [2, 2], [4.2, 2], [4.2, 1.5], [5, 1.5], [5, 3], [2, 3]], displacement = [\"-0.25*(t-1)\", -0.001]",
        "",
    );
    let error = plane_error(&beside);
    assert!(error.contains("overlap"), "{error}");
    // a tip between the corners of facets of space
    let [tip, rim] = [[0.45, 0.4, 1.0], [2.0, 2.0, 2.0]];
    let corners = [
        [-1.0, -1.0, 2.0],
        [rim[0], -1.0, 2.0],
        rim,
        [-1.0, rim[1], 2.0],
    ];
    let mut text = "solid tip\n".to_string();
    for k in 0..4 {
        let triangle = [tip, corners[(k + 1) % 4], corners[k]];
        text += "facet normal 0 0 0\nouter loop\n";
        for [x, y, z] in triangle {
            text += &format!("vertex {x} {y} {z}\n");
        }
        text += "endloop\nendfacet\n";
    }
    text += "endsolid\n";
    let at = folder("tip", &[("tool.stl", text.as_bytes())]);
    let solved = read::<3>(CUBE, &at).model.solve();
    match solved {
        // pressed, or told that nothing sees it
        Ok(solution) => assert!(
            solution.contacts[0].resultant[2] < -0.1
                || solution
                    .warnings
                    .iter()
                    .any(|w| w.contains("too large to see the contact")),
            "{:?}",
            solution.warnings
        ),
        Err(error) => assert!(error.to_string().contains("overlap"), "{error}"),
    }
}

#[test]
fn a_flat_tool_curves_nowhere() {
    let flat = block(
        "outline = [[-1, 2], [0.7, 2], [2.61, 2], [6, 2]], displacement = [\"0.02*(t-1)\", -0.01]",
        "friction = 0.2",
    );
    let solution = plane(&flat).remove(1);
    assert!(
        !solution.warnings.iter().any(|w| w.contains("curves away")),
        "{:?}",
        solution.warnings
    );
}

fn plane_error(text: &str) -> String {
    let case = read::<2>(text, Path::new("."));
    case.model.solve().unwrap_err().to_string()
}

/// The height of a polyline at a place between its ends.
fn height(line: &[[f64; 2]], x: f64) -> f64 {
    let spans = line.windows(2);
    let at = |s: &[[f64; 2]]| {
        let part = (x - s[0][0]) / (s[1][0] - s[0][0]);
        (0.0..=1.0)
            .contains(&part)
            .then(|| s[0][1] + part * (s[1][1] - s[0][1]))
    };
    spans.into_iter().find_map(at).unwrap_or(f64::INFINITY)
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 200, failure_persistence: None, ..ProptestConfig::default() })]

    /// Tools of any line that is nowhere steeper than one: what they carry is their load, and by a look at the deformed line of nodes
    /// that shares nothing with the program none of them sinks in silence.
    #[test]
    fn no_tool_sinks_in_silence(rises in prop::collection::vec(-1.0..1.0f64, 5..12), start in -0.4..0.4f64, load in 1.0..30.0f64, friction in 0.0..0.5f64) {
        let step = 4.8 / rises.len() as f64;
        let mut line = vec![[start - 0.4, 0.0]];
        for rise in rises {
            let [x, y] = line[line.len() - 1];
            line.push([x + step, y + rise * step]);
        }
        // its lowest point over the block touches
        let over: Vec<f64> = line.iter().filter(|p| (0.0..=4.0).contains(&p[0])).map(|p| p[1]).collect();
        let ends = [0.0, 4.0].map(|x| height(&line, x));
        let lowest = over.into_iter().chain(ends).fold(f64::INFINITY, f64::min);
        line.iter_mut().for_each(|p| p[1] += 2.0 - lowest);
        let points: Vec<String> = line.iter().map(|[x, y]| format!("[{x:?}, {y:?}]")).collect();
        let shape = format!("outline = [{}], force = [0, {:?}]", points.join(", "), -load);
        let text = block(&shape, &format!("friction = {{ tresca = {friction:?} }}")).replace("quad9", "quad4").replace("[9, 4]", "[24, 8]");
        let case = read::<2>(&text, Path::new("."));
        let run = case.run(&[], &mut |_| {});
        if run.failure.is_none() {
            let solution = &run.steps[0];
            let contact = &solution.contacts[0];
            prop_assert!((contact.resultant[1] + load).abs() < 1e-7 * load, "{:?}", contact.resultant);
            let mesh = &case.model.bodies[0].mesh;
            let u = &solution.bodies[0].displacement;
            let motion = contact.obstacle.unwrap_or([0.0; 2]);
            let moved: Vec<[f64; 2]> = line.iter().map(|p| [p[0] + motion[0], p[1] + motion[1]]).collect();
            let mut top: Vec<[f64; 2]> = mesh.side_nodes("top").unwrap().into_iter().map(|node| {
                let (x, u) = (mesh.points()[node as usize], u[node as usize]);
                [x[0] + u[0], x[1] + u[1]]
            }).collect();
            top.sort_by(|a, b| a[0].total_cmp(&b[0]));
            let at_nodes = top.iter().map(|p| p[1] - height(&moved, p[0]));
            let inside = |p: &&[f64; 2]| top[0][0] < p[0] && p[0] < top[top.len() - 1][0];
            let at_corners = moved.iter().filter(inside).map(|p| height(&top, p[0]) - p[1]);
            let sunk = at_nodes.chain(at_corners).fold(0.0, f64::max);
            let told = solution.warnings.iter().any(|w| w.contains("sunk") || w.contains("too large"));
            // half of the motion is told, of the nearest distance, which is at least this height over the root of two
            prop_assert!(sunk <= 0.71 * norm(motion) || told, "{sunk} of {motion:?}: {:?}", solution.warnings);
        }
    }
}

#[test]
fn a_node_over_two_banks_of_one_level_has_a_condition_on_each() {
    let run = |contacts: [Option<&str>; 2]| {
        let mut text = "analysis = \"plane-strain\"\n[[body]]\nname = \"floor\"\n\
             mesh = { outline = { size = 0.2, cell = \"tri3\", from = [0, -1], edges = [\
             { to = [4, -1], name = \"low\" }, { to = [4, 0], name = \"end\" }, { to = [2.1, 0], name = \"right\" }, \
             { to = [2.1, -0.2], name = \"fall\" }, { to = [1.8, -0.2], name = \"bottom\" }, { to = [1.8, 0], name = \"rise\" }, \
             { to = [0, 0], name = \"left\" }, { to = [0, -1], name = \"start\" }] } }\n\
             material = { young = 1000, poisson = 0.3 }\n\
             fix = [{ side = \"low\", x = 0, y = 0 }]\n[[body]]\nname = \"block\"\n\
             mesh = { rectangle = { from = [0.3, 0], to = [3.8, 1], cells = [5, 2], cell = \"quad4\" } }\n\
             material = { young = 1000, poisson = 0.3 }\nfix = [{ side = \"left\", x = 0 }]\n\
             load = [{ side = \"top\", pressure = 1 }]\n"
            .to_owned();
        for (k, mortar) in contacts.into_iter().flatten().enumerate() {
            text += &format!(
                "[[contact]]\nname = \"c{k}\"\nnonmortar = \"block.bottom\"\nmortar = {mortar}\n"
            );
        }
        plane(&text).remove(0)
    };
    let whole = run([
        Some(r#"["floor.left", "floor.rise", "floor.bottom", "floor.fall", "floor.right"]"#),
        None,
    ]);
    let each = run([Some("\"floor.left\""), Some("\"floor.right\"")]);
    let forces = each.contacts.iter().map(|contact| contact.resultant[1]);
    let force = whole.contacts[0].resultant[1];
    assert!((forces.sum::<f64>() - force).abs() < 1e-9 * force);
    for (a, b) in whole.bodies.iter().zip(&each.bodies) {
        for (a, b) in a.displacement.iter().zip(&b.displacement) {
            assert!(distance(*a, *b) < 1e-9, "{a:?} {b:?}");
        }
    }
}
