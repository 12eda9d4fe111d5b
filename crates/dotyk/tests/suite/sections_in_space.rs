//! Section forces of extruded bodies in space: statics, the plane, and forces that change along the axis.
//!
//! What statics determines is exact to the rounding of the nodal balance, 1e-9 of the largest value, on any mesh. An extruded mesh under
//! what the plane has answers what the plane answers, to the rounding of both.

use crate::sections::{cantilever, off, solved};
use dotyk::case::Case;
use dotyk::geometry::{Field, cross, dot, unit};
use dotyk::mesh::Mesh;
use dotyk::model::{BodyId, Load, Model, Solution, Station};
use std::path::Path;

fn model(text: &str) -> Model<3> {
    let case = Case::<3>::from_str(text, "test.toml", Path::new("."));
    case.unwrap_or_else(|e| panic!("{e}")).model
}

fn in_space(text: &str) -> Solution<3> {
    model(text).solve().unwrap_or_else(|e| panic!("{e}"))
}

/// All of V2, M2 and T.
fn across(station: &Station) -> [f64; 3] {
    let own = station.across.expect("in space");
    [own.shear, own.moment.unwrap_or(0.0), own.twist]
}

/// The cantilever of the plane, 0.8 wide along z, its loads and its weight as in the plane.
fn beam(mesh: &str, [top, bottom]: [&str; 2], section: &str) -> String {
    format!(
        r#"
analysis = "3d"
[[body]]
name = "beam"
mesh = {{ {mesh} }}
material = {{ young = 3e7, poisson = 0.2 }}
fix = [{{ side = "left", x = 0, y = 0, z = 0 }}]
load = [{{ side = "right", traction = [30, -20, 0] }}, {{ side = "{top}", traction = [1, "-10 - 3*x", 0] }}]
body_force = [0.5, -25, 0]
[[section]]
name = "cut"
body = "beam"
sides = ["{top}", "{bottom}"]
stations = 12
{section}
"#
    )
}

fn extruded(plane: &str, layers: usize) -> String {
    format!(
        "extrude = {{ mesh = {{ rectangle = {{ from = [0, 0], to = [5, 0.5], {plane} }} }}, height = 0.8, layers = {layers}, offset = -0.3 }}"
    )
}

#[test]
fn cantilevers_are_statics_on_every_mesh() {
    let own = ["top", "bottom"];
    let tetrahedra =
        |cells: &str| format!("box = {{ from = [0, 0, -0.3], to = [5, 0.5, 0.5], {cells} }}");
    // a box has its top and bottom along z
    let of_box = ["back", "front"];
    for (mesh, sides) in [
        (extruded("cells = [11, 2]", 2), own),
        (extruded("cells = [7, 1], cell = \"quad8\"", 2), own),
        (extruded("cells = [9, 2], cell = \"tri3\"", 3), own),
        (extruded("cells = [6, 1], cell = \"tri6\"", 2), own),
        (tetrahedra("cells = [9, 2, 3], cell = \"tet4\""), of_box),
        (tetrahedra("cells = [5, 1, 2], cell = \"tet10\""), of_box),
    ] {
        let section = in_space(&beam(&mesh, sides, "axis = [0, 0, 1]"))
            .sections
            .remove(0);
        let error = off(&section, |s| cantilever(5.0 - s.point[0]));
        assert!(error < 1e-9, "{mesh}: {error:.1e}");
        for station in &section.stations {
            assert!(
                across(station).iter().all(|c| c.abs() < 1e-7),
                "{station:?}"
            );
            assert!((station.place()[2] - 0.1).abs() < 1e-12);
        }
        // along the other axis s runs back, with the first side on its left
        let back = in_space(&beam(&mesh, sides, "axis = [0, 0, -1]"))
            .sections
            .remove(0);
        for (a, b) in section.stations.iter().zip(back.stations.iter().rev()) {
            for (x, y) in [
                (a.normal, b.normal),
                (a.shear, -b.shear),
                (a.moment, b.moment),
            ] {
                assert!((x - y).abs() < 1e-6, "{mesh}: {x} {y}");
            }
        }
    }
}

/// A wall of quarter rings, held at its start and loaded at its end and inside, in the plane or extruded.
fn quarter(cells: &str, height: Option<f64>) -> String {
    let ring = format!("ring = {{ inner = 4, outer = 4.4, from = 0, to = 90, {cells} }}");
    let (head, mesh, zero, held) = match height {
        None => ("plane-strain", ring, "", String::new()),
        Some(height) => (
            "3d",
            format!(
                "extrude = {{ mesh = {{ {ring} }}, height = {height}, layers = 2, offset = 7 }}"
            ),
            ", 0",
            "{ side = \"first\", z = 0 }, { side = \"last\", z = 0 }, ".to_string(),
        ),
    };
    format!(
        r#"
analysis = "{head}"
[[body]]
name = "wall"
mesh = {{ {mesh} }}
material = {{ young = 3e4, poisson = 0.2 }}
fix = [{held}{{ side = "start", x = 0, y = 0 }}]
load = [{{ side = "end", traction = [3, -2{zero}] }}, {{ side = "inner", pressure = "1 + x" }}]
body_force = [0.1, -0.4{zero}]
[[section]]
name = "cut"
body = "wall"
sides = ["inner", "outer"]
stations = 9
"#
    )
}

#[test]
fn an_extruded_wall_is_the_wall_of_the_plane() {
    for cells in [
        "cells = [12, 2]",
        "cells = [10, 1], cell = \"quad9\"",
        "cells = [11, 2], cell = \"tri3\"",
    ] {
        let plane = solved(&quarter(cells, None)).sections.remove(0);
        let solid = in_space(&quarter(cells, Some(0.7))).sections.remove(0);
        for (a, b) in plane.stations.iter().zip(&solid.stations) {
            assert!((a.s - b.s).abs() < 1e-9 && (a.thickness - b.thickness).abs() < 1e-9);
            assert!((a.angle() - b.angle()).abs() < 1e-6);
        }
        let at = |s: &Station| {
            let place = plane
                .stations
                .iter()
                .find(|own| (own.s - s.s).abs() < 1e-9)
                .unwrap();
            [place.normal, place.shear, place.moment]
        };
        let error = off(&solid, at);
        assert!(error < 1e-9, "{cells}: {error:.1e}");
        let extrusion = solid.extrusion.as_ref().unwrap();
        assert_eq!((extrusion.axis, extrusion.places), ([0.0, 0.0, 1.0], 1));
        assert!((extrusion.length - 0.7).abs() < 1e-12);
    }
}

/// The turn about an axis through the origin by an angle (Rodrigues).
fn rotation(axis: [f64; 3], angle: f64) -> impl Fn([f64; 3]) -> [f64; 3] + Copy {
    let n = unit(axis).expect("an axis");
    let (sin, cos) = angle.sin_cos();
    move |x| {
        let (beside, along) = (cross(n, x), (1.0 - cos) * dot(n, x));
        std::array::from_fn(|i| cos * x[i] + sin * beside[i] + along * n[i])
    }
}

/// A model turned about an oblique axis, the forces of its loads with it.
fn turned(model: &Model<3>, map: impl Fn([f64; 3]) -> [f64; 3] + Copy, end: [f64; 3]) -> Model<3> {
    let mut model = model.clone();
    let body = &mut model.bodies[0];
    body.mesh = Mesh::clone(&body.mesh).map_points(map).unwrap().into();
    body.loads.clear();
    let side = "end".to_string();
    let force = map(end).map(Field::constant);
    model.load(BodyId(0), Load::Resultant { side, force });
    model
}

#[test]
fn turned_walls_have_the_same_forces() {
    let text = quarter("cells = [10, 2]", Some(0.7))
        .replace("body_force = [0.1, -0.4, 0]\n", "")
        .replace("x = 0, y = 0 }]", "x = 0, y = 0, z = 0 }]")
        .replace(
            "{ side = \"first\", z = 0 }, { side = \"last\", z = 0 }, ",
            "",
        );
    let original = model(&text);
    let end = [2.0, -5.0, 1.5];
    let still = |x: [f64; 3]| x;
    for places in [1, 3] {
        let mut original = original.clone();
        original.sections[0].places = places;
        let forces = turned(&original, still, end)
            .solve()
            .unwrap()
            .sections
            .remove(0);
        // the resultant at the end: V2 is the force along the axis; first on the left of s, which runs from the start
        if places == 1 {
            let last = forces.stations.last().unwrap();
            let [v2, m2, t] = across(last);
            assert!(
                (v2 + 1.5 / 0.7).abs() < 1e-9 && m2.abs() < 1e-8 && t.abs() < 1e-8,
                "{last:?}"
            );
            // at the start the axial force has an arm of 4.2 about s and 4.2 about the middle line's normal
            let [v2, m2, t] = across(&forces.stations[0]);
            assert!((v2 + 1.5 / 0.7).abs() < 1e-8, "{v2}");
            assert!(
                (t.abs() - 1.5 * 4.2 / 0.7).abs() < 1e-7
                    && (m2.abs() - 1.5 * 4.2 / 0.7).abs() < 1e-7,
                "{t} {m2}"
            );
        }
        for axis in [[1.0, 2.0, 3.0], [-2.0, 0.3, 0.1], [0.0, 1.0, 0.0]] {
            let map = rotation(axis, 1.1);
            let other = turned(&original, map, end)
                .solve()
                .unwrap()
                .sections
                .remove(0);
            let told = other.extrusion.as_ref().unwrap().axis;
            let along = map([0.0, 0.0, 1.0]);
            let same = told.iter().zip(along).map(|(a, b)| a * b).sum::<f64>();
            assert!((same.abs() - 1.0).abs() < 1e-9, "{told:?} {along:?}");
            let mut pairs: Vec<&Station> = other.stations.iter().collect();
            if same < 0.0 {
                // the other axis: s and the places run back
                pairs.reverse();
            }
            for (a, b) in forces.stations.iter().zip(pairs) {
                let sign = same.signum();
                let ([v, m, t], [w, n, u]) = (across(a), across(b));
                for (x, y) in [
                    (a.normal, b.normal),
                    (a.shear, sign * b.shear),
                    (a.moment, b.moment),
                    (v, w),
                    (m, sign * n),
                    (t, u),
                ] {
                    assert!((x - y).abs() < 1e-8 * 15.0, "{places} {axis:?}: {x} {y}");
                }
            }
        }
    }
}

/// A plate of length 2, height 0.4 and width 1.2 along z, about its middle; its ends are displaced, its edges loaded.
fn plate(mesh: &str, [x, y, z]: [&str; 3], edges: [&str; 2], places: usize) -> String {
    let end =
        |side: &str| format!("{{ side = \"{side}\", x = \"{x}\", y = \"{y}\", z = \"{z}\" }}");
    format!(
        r#"
analysis = "3d"
[[body]]
name = "plate"
mesh = {{ box = {{ from = [0, -0.2, -0.6], to = [2, 0.2, 0.6], {mesh} }} }}
material = {{ young = 100, poisson = 0.25 }}
fix = [{}, {}]
load = [{{ side = "bottom", traction = ["{}", 0, 0] }}, {{ side = "top", traction = ["{}", 0, 0] }}]
[[section]]
name = "cut"
body = "plate"
sides = ["back", "front"]
stations = 5
axis = [0, 0, 1]
places = {places}
"#,
        end("left"),
        end("right"),
        edges[0],
        edges[1]
    )
}

const CELLS: [&str; 4] = [
    "cells = [5, 2, 4], cell = \"hex20\"",
    "cells = [4, 1, 3], cell = \"hex27\"",
    "cells = [3, 2, 3], cell = \"tet10\"",
    "cells = [4, 2, 3], cell = \"prism15\"",
];

#[test]
fn forces_that_are_linear_along_the_axis_are_exact() {
    // pure bending about y: sigma_x = E c z, with its quadratic displacements
    let bent = [
        "0.01*x*z",
        "-0.0025*y*z",
        "-0.005*x^2 + 0.00125*(y^2 - z^2)",
    ];
    let (free, sheared) = (["0", "0"], ["0.8*y", "-0.8*y"]);
    // pure twist of a plate: tau_xz = -2 G c y, G = 40
    let twisted = ["-0.01*y*z", "0.01*x*z", "-0.01*x*y"];
    for cells in CELLS {
        for places in [2, 4] {
            let section = in_space(&plate(cells, bent, free, places))
                .sections
                .remove(0);
            assert_eq!(section.stations.len(), 5 * places);
            for station in &section.stations {
                let z = station.place()[2];
                let n = 100.0 * 0.01 * z * 0.4;
                assert!(
                    (station.normal - n).abs() < 1e-9,
                    "{cells} {places}: {} {n}",
                    station.normal
                );
                assert!(
                    across(station).iter().all(|c| c.abs() < 1e-9),
                    "{station:?}"
                );
            }
            let section = in_space(&plate(cells, twisted, sheared, places))
                .sections
                .remove(0);
            for station in &section.stations {
                let [v2, _, t] = across(station);
                let expected = -2.0 * 40.0 * 0.01 * 0.4_f64.powi(3) / 12.0;
                assert!((t - expected).abs() < 1e-9, "{cells}: {t} {expected}");
                assert!(
                    v2.abs() < 1e-9 && station.moment.abs() < 1e-9 && station.normal.abs() < 1e-9
                );
            }
        }
        let whole = in_space(&plate(cells, bent, free, 1)).sections.remove(0);
        for station in &whole.stations {
            let [_, m2, _] = across(station);
            let expected = 0.4 * 1.2_f64.powi(2) / 12.0;
            assert!(
                (m2 - expected).abs() < 1e-9 && station.normal.abs() < 1e-9,
                "{cells}: {m2} {expected}"
            );
        }
    }
}

#[test]
fn between_planes_all_places_are_those_of_plane_strain() {
    let at = |places: usize, cells: &str, layers: usize| {
        quarter(cells, Some(0.7))
            .replace("layers = 2", &format!("layers = {layers}"))
            .replace("stations = 9", &format!("stations = 9\nplaces = {places}"))
    };
    for cells in [
        "cells = [12, 2]",
        "cells = [8, 1], cell = \"tri6\"",
        "cells = [8, 1], cell = \"quad8\"",
    ] {
        let plane = solved(&quarter(cells, None)).sections.remove(0);
        for (places, layers) in [(3, 2), (3, 4), (5, 8)] {
            let section = in_space(&at(places, cells, layers)).sections.remove(0);
            let error = off(&section, |s| {
                let mut stations = plane.stations.iter();
                let own = stations.find(|own| (own.s - s.s).abs() < 1e-9).unwrap();
                [own.normal, own.shear, own.moment]
            });
            assert!(error < 1e-8, "{cells} {places} {layers}: {error:.1e}");
            for station in &section.stations {
                // relative to forces of 5 to 20
                assert!(
                    across(station).iter().all(|c| c.abs() < 1e-7),
                    "{cells} {layers}: {station:?}"
                );
            }
        }
    }
}

#[test]
fn openings_and_points_beyond_the_ends_are_told() {
    let refused = |text: &str| {
        let case = Case::<3>::from_str(text, "test.toml", Path::new("."));
        case.err()
            .map(|error| error.to_string())
            .unwrap_or_default()
    };
    let text = quarter("cells = [10, 2]", Some(0.7))
        .replace("stations = 9", "stations = [[3, 3, 7.5], [3, 3, 9]]");
    let message = refused(&text);
    assert!(
        message.contains("station 2 at (3, 3, 9) lies beside the body"),
        "{message}"
    );
    // a side that covers a half of the wall
    let half = quarter("cells = [10, 2]", Some(0.7))
        .replace("layers = 2, offset = 7 } }", "layers = 2, offset = 7 }, sides = { part = { of = \"inner\", min = [-9, -9, 7.3], max = [9, 9, 9] } } }")
        .replace("sides = [\"inner\", \"outer\"]", "sides = [\"part\", \"outer\"]")
        .replace("stations = 9", "stations = 9\nplaces = 3");
    let message = refused(&half);
    assert!(
        message.contains("the first of its long sides has openings between its ends, 50.0 %"),
        "{message}"
    );
}

#[test]
fn means_along_the_axis_are_those_of_whole_cuts() {
    let text = quarter("cells = [10, 2]", Some(0.7))
        .replace("pressure = \"1 + x\"", "pressure = \"exp(8*(7 - z))\"")
        .replace("stations = 9", "stations = 9\nplaces = 3");
    let whole = "[[section]]\nname = \"whole\"\nbody = \"wall\"\nsides = [\"inner\", \"outer\"]\nstations = 9\n";
    let probe = |name: &str, quantity: &str| {
        format!("[[probe]]\nname = \"{name}\"\nquantity = \"{quantity}\"\nreduce = \"mean\"\n")
    };
    let names = ["cut.N", "whole.N", "cut.V2", "whole.V2", "cut.M", "whole.M"];
    let probes: String = names.iter().map(|name| probe(name, name)).collect();
    let solution = in_space(&(text + whole + &probes));
    for pair in solution.probes.chunks(2) {
        let [one, other] = [pair[0].value, pair[1].value];
        assert!(
            (one - other).abs() < 1e-9,
            "{}: {one} {other}",
            pair[0].name
        );
    }
    let [cut, whole] = [&solution.sections[0], &solution.sections[1]];
    for (one, other) in cut.mean().stations.iter().zip(&whole.stations) {
        assert!((one.normal - other.normal).abs() < 1e-9 && (one.shear - other.shear).abs() < 1e-9);
    }
}
