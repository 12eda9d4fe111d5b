//! Section forces against statics, thin and thick rings, and what cuts must do whatever the mesh is.
//!
//! What statics determines is exact to the rounding of the nodal balance, 1e-9 of the largest value, wherever the cut lies
//! among the cells. Where displacements decide, bands are those of the issue: 0.1 % with four quad9 through the thickness,
//! 0.5 % with quad4 that resolve the bending.

use dotyk::analytic::{
    Material, Plane,
    ring::{Interface, Part, RingInPlate},
};
use dotyk::case::Case;
use dotyk::model::{BodyId, Model, SectionSolution, Solution, Station, Stations};
use std::f64::consts::{PI, TAU};
use std::path::Path;

pub fn solved(text: &str) -> Solution<2> {
    let case =
        Case::<2>::from_str(text, "test.toml", Path::new(".")).unwrap_or_else(|e| panic!("{e}"));
    case.model.solve().unwrap_or_else(|e| panic!("{e}"))
}

fn section(text: &str) -> SectionSolution {
    solved(text).sections.remove(0)
}

/// Largest difference of N, V and M from expected ones, relative to the largest expected values: forces and moments each.
pub fn off(section: &SectionSolution, expected: impl Fn(&Station) -> [f64; 3]) -> f64 {
    let all: Vec<([f64; 3], [f64; 3])> = section
        .stations
        .iter()
        .map(|s| ([s.normal, s.shear, s.moment], expected(s)))
        .collect();
    let force = all
        .iter()
        .flat_map(|(_, e)| [e[0].abs(), e[1].abs()])
        .fold(0.0, f64::max);
    let moment = all.iter().map(|(_, e)| e[2].abs()).fold(0.0, f64::max);
    let scales = [force, force, moment];
    let each = all
        .iter()
        .flat_map(|(a, e)| (0..3).map(move |i| (a[i] - e[i]).abs() / scales[i]));
    each.fold(0.0, f64::max)
}

/// N, V, M per unit of thickness of a cantilever of length 5 and height 1/2 held at x = 0, under an end traction, a traction on
/// its top and its weight, at a distance from its free end; the first side is the top.
pub fn cantilever(d: f64) -> [f64; 3] {
    let (h, x) = (0.5, 5.0 - d);
    // end: (30, -20) on h; top: (1, -10 - 3x); weight: (1/2, -25) on h
    let normal = 30.0 * h + d + 0.5 * h * d;
    let top = 10.0 * d + 1.5 * (25.0 - x * x);
    let shear = 20.0 * h + top + 25.0 * h * d;
    let arm = 10.0 * d * d / 2.0 + 3.0 * ((125.0 - x.powi(3)) / 3.0 - x * (25.0 - x * x) / 2.0);
    let moment = 20.0 * h * d + arm + 25.0 * h * d * d / 2.0 + 0.25 * d;
    [normal, shear, moment]
}

const CANTILEVER: &str = r#"
analysis = "plane-stress"
[[body]]
name = "beam"
mesh = { MESH }
material = { young = 3e7, poisson = 0.2, thickness = 0.4 }
fix = [{ side = "left", x = 0, y = 0 }]
load = [{ side = "right", traction = [30, -20] }, { side = "top", traction = [1, "-10 - 3*x"] }]
body_force = [0.5, -25]
[[section]]
name = "cut"
body = "beam"
sides = ["top", "bottom"]
stations = 12
[[section]]
name = "turned"
body = "beam"
sides = ["bottom", "top"]
stations = 12
"#;

#[test]
fn cantilevers_are_statics_on_every_mesh() {
    let rectangle =
        |cells: &str| format!("rectangle = {{ from = [0, 0], to = [5, 0.5], {cells} }}");
    let outline = |cell: &str| {
        format!(
            r#"outline = {{ size = 0.2, cell = "{cell}", from = [0, 0], edges = [
                {{ to = [5, 0], name = "bottom", cells = 31 }}, {{ to = [5, 0.5], name = "right" }},
                {{ to = [0, 0.5], name = "top", cells = 23 }}, {{ to = [0, 0], name = "left" }}] }}"#
        )
    };
    let meshes = [
        rectangle("cells = [11, 2], cell = \"quad4\""),
        rectangle("cells = [20, 4], cell = \"quad9\""),
        rectangle("cells = [7, 1], cell = \"tri6\""),
        outline("tri3"),
        outline("tri6"),
    ];
    for mesh in meshes {
        let mut sections = solved(&CANTILEVER.replace("MESH", &mesh)).sections;
        let expected = |s: &Station| cantilever(5.0 - s.point[0]);
        let error = off(&sections[0], expected);
        assert!(error < 1e-9, "{mesh}: {error:.1e}");
        // swapped sides: the same N and V, the other sign of M, s back
        let turned = sections.remove(1);
        let error = off(&turned, |s| {
            let [n, v, m] = expected(s);
            [n, v, -m]
        });
        assert!(error < 1e-9, "{mesh}, turned: {error:.1e}");
        for (a, b) in sections[0]
            .stations
            .iter()
            .zip(turned.stations.iter().rev())
        {
            assert!((a.s + b.s - 5.0).abs() < 1e-6, "{} {}", a.s, b.s);
            let back = (a.angle() - b.angle()).to_radians();
            assert!(back.sin().abs() < 1e-6 && back.cos() < 0.0, "{mesh}");
        }
        let [first, second] = sections[0].stations[3].edge_stress();
        let Station { normal, moment, .. } = sections[0].stations[3];
        assert!((first - (normal / 0.5 + 6.0 * moment / 0.25)).abs() < 1e-9 * first.abs());
        assert!((first + second - 2.0 * normal / 0.5).abs() < 1e-9 * first.abs());
    }
}

#[test]
fn a_free_end_bears_nothing_and_a_point_load_on_a_cut_is_behind_it() {
    let text = r#"
analysis = "plane-strain"
[[body]]
name = "beam"
mesh = { rectangle = { from = [0, 0], to = [4, 0.5], cells = [16, 2], cell = "quad9" } }
material = { young = 3e7, poisson = 0.2 }
fix = [{ side = "left", x = 0, y = 0 }]
load = [{ point = [2, 0.5], force = [3, -7] }]
[[section]]
name = "cut"
body = "beam"
sides = ["top", "bottom"]
stations = 9
"#;
    let error = off(&section(text), |s| {
        let x = s.point[0];
        match x < 2.0 - 1e-9 {
            true => [3.0, 7.0, 7.0 * (2.0 - x) + 0.75],
            false => [0.0; 3],
        }
    });
    assert!(error < 1e-10, "{error:.1e}");
}

#[test]
fn a_clamped_beam_has_the_moments_of_the_theory() {
    let text = |cells: &str| {
        format!(
            r#"
analysis = "plane-stress"
[[body]]
name = "beam"
mesh = {{ rectangle = {{ from = [0, 0], to = [20, 0.5], {cells} }} }}
material = {{ young = 3e7, poisson = 0 }}
fix = [{{ side = "left", x = 0, y = 0 }}, {{ side = "right", x = 0, y = 0 }}]
body_force = [0, -24]
[[section]]
name = "cut"
body = "beam"
sides = ["top", "bottom"]
stations = [[0, 0.25], [5, 0.25], [10, 0.25], [20, 0.25]]
"#
        )
    };
    // q = 12: M = q l²/12 at the ends, −q l²/24 in the middle
    for (cells, band) in [
        ("cells = [80, 4], cell = \"quad9\"", 1e-3),
        ("cells = [320, 6], cell = \"quad4\"", 5e-3),
    ] {
        let section = section(&text(cells));
        let error = off(&section, |s| {
            let x = s.point[0];
            [0.0, 120.0 - 12.0 * x, 400.0 - 12.0 * x * (20.0 - x) / 2.0]
        });
        assert!(error < band, "{cells}: {error:.1e}");
    }
}

/// A ring under two opposite forces F = 1, which its supports balance without forces.
fn pinched(cells: &str) -> String {
    format!(
        r#"
analysis = "plane-stress"
[[body]]
name = "ring"
mesh = {{ ring = {{ inner = 0.98, outer = 1.02, {cells} }} }}
material = {{ young = 1e6, poisson = 0.0 }}
fix = [{{ point = [0, 0.98], x = 0 }}, {{ point = [0, -0.98], x = 0, y = 0 }}]
load = [{{ point = [0, 1.02], force = [0, -1] }}, {{ point = [0, -1.02], force = [0, 1] }}]
[[section]]
name = "s"
body = "ring"
sides = ["outer", "inner"]
stations = 17
"#
    )
}

#[test]
fn a_pinched_ring_has_the_forces_of_the_thin_ring() {
    for (cells, band) in [
        ("cells = [96, 4], cell = \"quad9\"", 1e-3),
        ("cells = [800, 6], cell = \"quad4\"", 5e-3),
    ] {
        let ring = section(&pinched(cells));
        assert!(ring.closed && ring.stations.len() == 17);
        // s runs clockwise with the outer side on its left, from +x; forces jump at the loads, where the cut is behind them
        let error = off(&ring, |s| {
            let around = -s.s / ring.length * TAU;
            let (sin, cos) = around.sin_cos();
            let left = (-1.5 * PI + 1e-6..=-0.5 * PI + 1e-6).contains(&around);
            let right = if left { -1.0 } else { 1.0 };
            let normal = -0.5 * cos * right;
            let shear = -0.5 * sin * right;
            // tension outside at the sides, inside below the loads
            let moment = 0.5 * cos.abs() - 1.0 / PI;
            [normal, shear, moment]
        });
        assert!(error < band, "{cells}: {error:.1e}");
        let [least, most] = ring
            .extremes(dotyk::model::SectionQuantity::Moment)
            .unwrap();
        assert!((most.1 - 0.5 + 1.0 / PI).abs() < band && (least.1 + 1.0 / PI).abs() < band);
    }
}

/// Lamé's hoop stress of a ring b ≤ r ≤ a under an outer pressure p: normal force and moment about the middle, tension outside
/// positive.
fn lame(b: f64, a: f64, p: f64) -> [f64; 2] {
    let k = -p * a * a / (a * a - b * b);
    let middle = 0.5 * (a + b);
    let normal = k * ((a - b) + b * b * (1.0 / b - 1.0 / a));
    let first = k * (0.5 * (a * a - b * b) + b * b * (a / b).ln());
    [normal, first - middle * normal]
}

#[test]
fn a_thick_ring_has_lames_forces_on_grids_and_free_triangles() {
    let ring = "ring = { inner = 1, outer = 1.5, cells = [36, 4], cell = \"quad9\" }";
    let free = r#"outline = { size = 0.13, cell = "tri6", circle = { center = [0, 0], radius = 1.5, name = "outer", cells = 64 },
        holes = [{ circle = { center = [0, 0], radius = 1, name = "inner", cells = 44 } }] }"#;
    for mesh in [ring, free] {
        let text = format!(
            r#"
analysis = "plane-strain"
[[body]]
name = "ring"
mesh = {{ {mesh} }}
material = {{ young = 1e4, poisson = 0.3 }}
fix = [{{ point = [1.5, 0], y = 0 }}, {{ point = [-1.5, 0], y = 0 }}, {{ point = [0, 1.5], x = 0 }}]
load = [{{ side = "outer", pressure = 2 }}]
[[section]]
name = "s"
body = "ring"
sides = ["outer", "inner"]
stations = 8
"#
        );
        let [normal, moment] = lame(1.0, 1.5, 2.0);
        assert!((normal + 3.0).abs() < 1e-12, "N = p R");
        let section = section(&text);
        let error = off(&section, |_| [normal, 0.0, moment]);
        assert!(error < 1e-3, "{mesh}: {error:.1e}");
    }
}

#[test]
fn a_part_between_two_cuts_is_in_balance_under_a_pressure() {
    let text = r#"
analysis = "plane-strain"
[[body]]
name = "ring"
mesh = { ring = { inner = 1, outer = 1.3, cells = [20, 2], cell = "quad9" } }
material = { young = 1e4, poisson = 0.3 }
fix = [{ point = [1.3, 0], y = 0 }, { point = [-1.3, 0], y = 0 }, { point = [0, 1.3], x = 0 }]
load = [{ side = "outer", pressure = 2 }, { side = "inner", pressure = 0.7 }]
[[section]]
name = "s"
body = "ring"
sides = ["inner", "outer"]
stations = 9
"#;
    let section = section(text);
    let ends = |s: &Station| {
        [0.5, -0.5].map(|k| [0, 1].map(|i| s.point[i] + k * s.thickness * s.toward_first[i]))
    };
    for pair in section.stations.windows(2) {
        let mut sums = [0.0; 3];
        let mut add = |at: [f64; 2], f: [f64; 2], moment: f64| {
            let own = [f[0], f[1], at[0] * f[1] - at[1] * f[0] + moment];
            sums.iter_mut().zip(own).for_each(|(sum, own)| *sum += own);
        };
        // the part behind the second cut and ahead of the first: on it act −F of the first and F of the second
        for (s, sign) in [(&pair[0], -1.0), (&pair[1], 1.0)] {
            let e = s.toward_first;
            let t = [e[1], -e[0]];
            let f = [0, 1].map(|i| sign * (s.normal * t[i] - s.shear * e[i]));
            add(s.point, f, -sign * s.moment);
        }
        // a pressure on a curve from p to q depends on its ends alone: p̂ (q − p) turned by +90°, at the middle of the chord
        let [[a, b], [c, d]] = [ends(&pair[0]), ends(&pair[1])];
        for (from, to, pressure) in [(a, c, -0.7), (b, d, 2.0)] {
            let chord = [to[0] - from[0], to[1] - from[1]];
            let middle = [0, 1].map(|i| 0.5 * (from[i] + to[i]));
            add(middle, [-pressure * chord[1], pressure * chord[0]], 0.0);
        }
        // loads are of the size 2 × 1.3
        let worst = sums
            .iter()
            .fold(0.0, |worst: f64, sum| worst.max(sum.abs()));
        assert!(worst < 1e-10 * 2.6, "{worst:.1e}");
    }
}

#[test]
fn a_three_hinged_arch_is_statics() {
    // one half of it, r = 4 in the middle: a hinge at the springing, and one at the crown, where symmetry holds x
    let text = r#"
analysis = "plane-strain"
[[body]]
name = "arch"
mesh = { ring = { inner = 3.8, outer = 4.2, from = 0, to = 90, cells = [24, 2], cell = "quad8" } }
material = { young = 3e7, poisson = 0.2 }
couple = [{ side = "start", point = "foot", kind = "average" }, { side = "end", point = "crown", kind = "average" }]
points = { foot = [4, 0], crown = [0, 4] }
fix = [{ point = "foot", x = 0, y = 0 }, { point = "crown", x = 0 }]
load = [{ point = [ X , Y ], force = [0, -10] }]
[[section]]
name = "cut"
body = "arch"
sides = ["inner", "outer"]
stations = 11
"#;
    // at 60° from the springing
    let angle: f64 = PI / 3.0;
    let at = [4.2 * angle.cos(), 4.2 * angle.sin()];
    let text = text
        .replace(" X ", &at[0].to_string())
        .replace(" Y ", &at[1].to_string());
    // moments about the crown: thrust h at the foot, 4 h = 10·4 − 10·x
    let thrust = 10.0 * (4.0 - at[0]) / 4.0;
    let section = section(&text);
    let error = off(&section, |s| {
        // s runs from the foot up, the inner side on its left
        let [x, y] = s.point;
        let (cos, sin) = (x / 4.0, y / 4.0);
        // on the part ahead, towards the crown: its thrust, and the load as long as it is there
        let load = if y.atan2(x) < angle { 10.0 } else { 0.0 };
        let force = [thrust, -load];
        let normal = -force[0] * sin + force[1] * cos;
        let toward_first = [-cos, -sin];
        let shear = -(force[0] * toward_first[0] + force[1] * toward_first[1]);
        let moment = (0.0 - x) * 0.0 - (4.0 - y) * thrust + (at[0] - x) * -load;
        [normal, shear, -moment]
    });
    // the middle line is that of parabolas, off by 1e-6 of its radius
    assert!(error < 1e-5, "{error:.1e}");
}

const FRAME: &str = r#"
analysis = "plane-stress"
[[body]]
name = "frame"
mesh = { outline = { size = 0.15, cell = "tri6", from = [0, 0], edges = [
    { to = [3, 0], name = "below" }, { to = [3, 0.4], name = "end" }, { to = [0.4, 0.4], name = "above" },
    { to = [0.4, 2.5], name = "right" }, { to = [0, 2.5], name = "start" }, { to = [0, 0], name = "left" }] } }
material = { young = 3e7, poisson = 0.2 }
fix = [{ side = "start", x = 0, y = 0 }]
load = [{ side = "end", force = [2, -5] }]
[[section]]
name = "cut"
body = "frame"
sides = [["above", "right"], ["left", "below"]]
stations = [[0.2, 2.0], [0.2, 1.0], [0.2, 0.2], [1.0, 0.2], [2.9, 0.2]]
"#;

#[test]
fn the_forces_go_around_the_corner_of_a_frame() {
    let section = section(FRAME);
    let [_, _, corner, ..] = &section.stations[..] else {
        panic!("five stations")
    };
    assert!((corner.thickness - 0.4 * 2.0_f64.sqrt()).abs() < 1e-6);
    assert!((corner.angle() + 45.0).abs() < 1e-4);
    let error = off(&section, |s| {
        let e = s.toward_first;
        let t = [e[1], -e[0]];
        let [x, y] = s.point;
        let moment = (3.0 - x) * -5.0 - (0.2 - y) * 2.0;
        [2.0 * t[0] - 5.0 * t[1], -(2.0 * e[0] - 5.0 * e[1]), -moment]
    });
    assert!(error < 1e-9, "{error:.1e}");
}

#[test]
fn a_step_in_thickness_shifts_the_middle_and_no_more() {
    let text = r#"
analysis = "plane-stress"
[[body]]
name = "beam"
mesh = { outline = { size = 0.1, cell = "tri6", from = [0, 0], edges = [
    { to = [4, 0], name = "bottom" }, { to = [4, 0.8], name = "right" }, { to = [2, 0.8], name = "top" },
    { to = [2, 0.5], name = "top" }, { to = [0, 0.5], name = "top" }, { to = [0, 0], name = "left" }] } }
material = { young = 3e7, poisson = 0.2 }
fix = [{ side = "right", x = 0, y = 0 }]
load = [{ side = "left", force = [-6, -2] }]
[[section]]
name = "cut"
body = "beam"
sides = ["top", "bottom"]
stations = 21
"#;
    let section = section(text);
    let error = off(&section, |s| {
        let [x, y] = s.point;
        // the load is behind: what is ahead has the opposite
        let middle = if x < 2.0 - 1e-6 { 0.25 } else { 0.4 };
        assert!(
            (y - middle).abs() < 1e-6 || (x - 2.0).abs() < 1e-3,
            "{x} {y}"
        );
        [6.0, -2.0, 2.0 * x + 6.0 * (0.25 - y)]
    });
    assert!(error < 1e-8, "{error:.1e}");
}

#[test]
fn a_wall_that_grows_out_of_its_slab_is_cut_at_its_foot() {
    // sides that end at the slab, whose upper face lies in the line of the cut there
    let text = |sides: &str| {
        format!(
            r#"
analysis = "plane-strain"
[[body]]
name = "wall"
mesh = {{ outline = {{ size = 0.15, cell = "tri6", from = [0, 0], edges = [
    {{ to = [3, 0], name = "ground" }}, {{ to = [3, 0.5] }}, {{ to = [1.4, 0.5] }}, {{ to = [1.4, 2.5], name = "back" }},
    {{ to = [1, 2.5] }}, {{ to = [1, 0.5], name = "front" }}, {{ to = [0, 0.5] }}, {{ to = [0, 0] }}] }} }}
material = {{ young = 3e7, poisson = 0.2 }}
fix = [{{ side = "ground", x = 0, y = 0 }}]
load = [{{ side = "front", pressure = "10*(2.5 - y)" }}]
body_force = [0, -25]
[[section]]
name = "foot"
body = "wall"
sides = [{sides}]
stations = 6
"#
        )
    };
    for (sides, sign) in [("\"front\", \"back\"", 1.0), ("\"back\", \"front\"", -1.0)] {
        let error = off(&section(&text(sides)), |s| {
            // the load pushes along +x from the front; weight 25 over 0.4
            let d = 2.5 - s.point[1];
            [-10.0 * d, 5.0 * d * d, sign * 10.0 * d.powi(3) / 6.0]
        });
        assert!(error < 1e-9, "{sides}: {error:.1e}");
    }
}

#[test]
fn a_cut_that_ends_within_the_body_is_refused() {
    // behind the wall the slab is thicker: from the end of one side to that of the other the line goes on through it
    let text = r#"
analysis = "plane-strain"
[[body]]
name = "wall"
mesh = { outline = { size = 0.15, from = [0, 0], edges = [
    { to = [3, 0], name = "ground" }, { to = [3, 1] }, { to = [1.4, 1] }, { to = [1.4, 2.5], name = "back" },
    { to = [1, 2.5] }, { to = [1, 0.5], name = "front" }, { to = [0, 0.5] }, { to = [0, 0] }] } }
material = { young = 3e7, poisson = 0.2 }
fix = [{ side = "ground", x = 0, y = 0 }]
[[section]]
name = "foot"
body = "wall"
sides = ["front", "back"]
stations = STATIONS
"#;
    let read = |stations: &str| {
        let text = text.replace("STATIONS", stations);
        Case::<2>::from_str(&text, "test.toml", Path::new("."))
    };
    let error = read("6").unwrap_err().to_string();
    assert!(
        error.contains("station 1 ends within the body, at (1.0000, 0.5000)"),
        "{error}"
    );
    read("[[1.2, 1.5], [1.2, 2.5]]").unwrap();
}

#[test]
fn turned_and_mirrored_bodies_have_the_same_forces() {
    let case = |text: &str| {
        Case::<2>::from_str(text, "test.toml", Path::new("."))
            .unwrap()
            .model
    };
    let original = case(FRAME);
    let forces = original.solve().unwrap().sections.remove(0);
    let (sin, cos) = 0.7_f64.sin_cos();
    for mirrored in [false, true] {
        let map = |[x, y]: [f64; 2]| {
            let x = if mirrored { -x } else { x };
            [cos * x - sin * y, sin * x + cos * y]
        };
        let mut model = original.clone();
        let body = &mut model.bodies[0];
        body.mesh = dotyk::mesh::Mesh::clone(&body.mesh)
            .map_points(map)
            .unwrap()
            .into();
        let [fx, fy] = map([2.0, -5.0]);
        body.loads.clear();
        let force = [fx, fy].map(dotyk::geometry::Field::constant);
        let side = "end".to_string();
        model.load(
            dotyk::model::BodyId(0),
            dotyk::model::Load::Resultant { side, force },
        );
        if let dotyk::model::Stations::Points(points) = &mut model.sections[0].stations {
            points.iter_mut().for_each(|point| *point = map(*point));
        }
        let turned = model.solve().unwrap().sections.remove(0);
        for (a, b) in forces.stations.iter().zip(&turned.stations) {
            // s runs back in a mirror: the shear force changes its sign, and sides keep theirs
            let sign = if mirrored { -1.0 } else { 1.0 };
            for (x, y) in [
                (a.normal, b.normal),
                (a.shear, sign * b.shear),
                (a.moment, b.moment),
            ] {
                assert!((x - y).abs() < 1e-9 * 15.0, "{mirrored}: {x} {y}");
            }
        }
    }
}

#[test]
fn shells_of_revolution_have_meridional_and_hoop_forces() {
    // a sphere under an inner pressure p: N = p b²/(2 r) all around, r in the middle; the hoop force is ∫σ_θ dr
    let text = r#"
analysis = "axisymmetric"
[[body]]
name = "dome"
mesh = { ring = { inner = 2, outer = 2.4, from = -60, to = 70, cells = [32, 4], cell = "quad9" } }
material = { young = 1e4, poisson = 0.3 }
fix = [{ side = "start", normal = 0 }, { side = "end", normal = 0 }]
load = [{ side = "inner", pressure = 3 }]
[[section]]
name = "meridian"
body = "dome"
sides = ["inner", "outer"]
stations = 9
"#;
    let section = section(text);
    let (b, a, r): (f64, f64, f64) = (2.0, 2.4, 2.2);
    // σ_θ = p b³/(a³ − b³) (1 + a³/2r³)
    let k = 3.0 * b.powi(3) / (a.powi(3) - b.powi(3));
    let ring = |f: &dyn Fn(f64) -> f64| -> f64 {
        let n = 2000;
        let step = (a - b) / f64::from(n);
        (0..n)
            .map(|i| b + (f64::from(i) + 0.5) * step)
            .map(|x| f(x) * step)
            .sum()
    };
    let stress = |x: f64| k * (1.0 + 0.5 * (a / x).powi(3));
    // a cone's cut is longer outside: ∫σ x dx/r
    let normal = ring(&|x| stress(x) * x) / r;
    assert!((normal / (3.0 * b * b / (2.0 * r)) - 1.0).abs() < 1e-6);
    let moment = ring(&|x| stress(x) * (r - x) * x) / r;
    let error = off(&section, |_| [normal, 0.0, moment]);
    assert!(error < 1e-3, "{error:.1e}");
    let hoop = [ring(&stress), ring(&|x| stress(x) * (r - x))];
    for s in &section.stations {
        let [n, m] = s.hoop.unwrap();
        assert!((n / hoop[0] - 1.0).abs() < 1e-3, "{n} {}", hoop[0]);
        assert!(
            (m - hoop[1]).abs() < 5e-3 * hoop[1].abs(),
            "{m} {}",
            hoop[1]
        );
    }
}

#[test]
fn the_weight_of_a_shell_of_revolution_is_carried_to_its_foot() {
    let text = r#"
analysis = "axisymmetric"
[[body]]
name = "tube"
mesh = { rectangle = { from = [1, 0], to = [1.2, 3], cells = [2, 17], cell = "quad4" } }
material = { young = 1e4, poisson = 0 }
fix = [{ side = "bottom", y = 0 }]
load = [{ side = "top", traction = [0, -4] }]
body_force = [0, -2]
[[section]]
name = "wall"
body = "tube"
sides = ["left", "right"]
stations = 8
"#;
    let section = section(text);
    for s in &section.stations {
        let z = s.point[1];
        let expected = -0.2 * (4.0 + 2.0 * (3.0 - z));
        assert!(
            (s.normal - expected).abs() < 1e-9,
            "{z}: {} {expected}",
            s.normal
        );
        assert!(s.shear.abs() < 1e-9);
    }
}

#[test]
fn contact_pressure_is_cut_where_the_cut_is() {
    // a ring shrunk by rock that presses it evenly, meshes that do not match: N = p R on every cut, also within facets
    let text = r#"
analysis = "plane-strain"
[[body]]
name = "lining"
mesh = { ring = { inner = 1.8, outer = 2, cells = [40, 2], cell = "quad9" } }
material = { young = 3e4, poisson = 0.2 }
[[body]]
name = "rock"
mesh = { ring = { inner = 2, outer = 4, cells = [52, 4], cell = "quad9" } }
material = { young = 2e3, poisson = 0.25 }
fix = [{ point = [4, 0], y = 0 }, { point = [-4, 0], y = 0 }, { point = [0, 4], x = 0 }]
load = [{ side = "outer", pressure = 10 }]
[[contact]]
name = "joint"
nonmortar = "lining.outer"
mortar = "rock.inner"
gap = "closed"
[[section]]
name = "s"
body = "lining"
sides = ["inner", "outer"]
stations = 24
"#;
    let solution = solved(text);
    let pressure: f64 = solution.contacts[0]
        .nodes
        .iter()
        .map(|n| n.pressure * n.weight)
        .sum::<f64>()
        / (TAU * 2.0);
    let section = &solution.sections[0];
    let normal = -2.0 * pressure;
    for s in &section.stations {
        assert!(
            (s.normal / normal - 1.0).abs() < 1e-3,
            "{} {normal}",
            s.normal
        );
        // half of a node's force would be 0.08 of N here
        assert!(s.shear.abs() < 1e-3 * normal.abs(), "{}", s.shear);
    }
}

#[test]
fn a_lining_in_rock_has_the_forces_of_the_exact_ring() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../cases/ring-in-rock/quad9_32.toml");
    let mut model = Case::<2>::read(&path).unwrap().model;
    // 19 stations and 32 cells on half a turn: most cuts lie within facets
    let stations = Stations::Number(19);
    model.section("wall", BodyId(1), ["inner", "outer"], stations);
    let exact = RingInPlate {
        inner: 12.0,
        radius: 15.0,
        ring: Material {
            young: 2.1e6,
            poisson: 0.15,
        },
        plate: Material {
            young: 2000.0,
            poisson: 0.25,
        },
        plane: Plane::Strain,
        vertical: 1.0,
        ratio: 1.0 / 3.0,
        interface: Interface::FullSlip,
    };
    let integral = |f: &dyn Fn(f64) -> f64| -> f64 {
        (0..600)
            .map(|k| 12.0 + (f64::from(k) + 0.5) / 200.0)
            .map(|r| f(r) / 200.0)
            .sum()
    };
    let section = model.solve().unwrap().sections.remove(0);
    let error = off(&section, |s| {
        let [x, y] = s.point;
        let stress = |r: f64| exact.polar_stress(r, y.atan2(x), Part::Ring);
        [
            integral(&|r| stress(r).hoop),
            integral(&|r| stress(r).shear),
            integral(&|r| stress(r).hoop * (13.5 - r)),
        ]
    });
    // the pressure of this mesh is right to 0.1 %
    assert!(error < 2e-3, "{error:.1e}");
}

#[test]
fn forces_are_those_of_total_stresses() {
    // ground that nobody has touched, and a bar that is heated between walls
    let ground = |analysis: &str| {
        format!(
            r#"
analysis = "{analysis}"
[[body]]
name = "ground"
mesh = {{ rectangle = {{ from = [1, 0], to = [2, 3], cells = [3, 7], cell = "quad9" }} }}
material = {{ young = 2e5, poisson = 0.3 }}
initial_stress = {{ vertical = "-20*(5 - y)", k0 = [0.5, 0.5] }}
body_force = [0, -20]
fix = [{{ side = "bottom", y = 0 }}, {{ point = [1, 0], x = 0 }}]
load = [{{ side = ["left", "right"], in_situ = 1 }}, {{ side = "top", in_situ = 1 }}]
[[section]]
name = "column"
body = "ground"
sides = ["left", "right"]
stations = 6
"#
        )
    };
    for analysis in ["plane-strain", "axisymmetric"] {
        for s in section(&ground(analysis)).stations {
            let expected = -20.0 * (5.0 - s.point[1]);
            let at = s.point[1];
            assert!(
                (s.normal - expected).abs() < 1e-8,
                "{analysis} {at}: {} {expected}",
                s.normal
            );
            assert!(s.shear.abs() < 1e-8, "{analysis} {at}: {}", s.shear);
            // around the axis an even stress has its resultant beside the middle: ∫(3/2 − r) r dr = −1/12
            let moment = if analysis == "axisymmetric" {
                -expected / 12.0 / 1.5
            } else {
                0.0
            };
            assert!(
                (s.moment - moment).abs() < 1e-8,
                "{analysis} {at}: {}",
                s.moment
            );
            assert!(
                s.hoop
                    .is_none_or(|hoop| (hoop[0] - 0.5 * expected).abs() < 1e-6)
            );
        }
    }
    let heated = r#"
analysis = "plane-stress"
[[body]]
name = "bar"
mesh = { rectangle = { from = [0, 0], to = [4, 0.5], cells = [7, 2], cell = "quad8" } }
material = { young = 3e7, poisson = 0 }
initial_strain = { thermal = 20, expansion = 1e-5 }
fix = [{ side = "left", x = 0, y = 0 }, { side = "right", x = 0 }]
[[section]]
name = "cut"
body = "bar"
sides = ["top", "bottom"]
stations = 5
"#;
    for s in section(heated).stations {
        // E α ΔT h
        assert!(
            (s.normal + 3000.0).abs() < 1e-6 && s.moment.abs() < 1e-6,
            "{s:?}"
        );
    }
}

#[test]
fn a_section_is_there_when_its_body_is() {
    let text = r#"
analysis = "plane-strain"
[[body]]
name = "base"
mesh = { rectangle = { from = [0, -1], to = [1, 0], cells = [2, 2] } }
material = { young = 1e5, poisson = 0.2 }
fix = [{ side = "bottom", x = 0, y = 0 }]
[[body]]
name = "wall"
active = { from = "late" }
mesh = { rectangle = { from = [0, 0], to = [0.5, 2], cells = [2, 8] } }
material = { young = 1e5, poisson = 0.2 }
fix = [{ side = "bottom", x = 0, y = 0 }]
load = [{ side = "top", traction = [0, "-10*t"] }]
[[section]]
name = "cut"
body = "wall"
sides = ["left", "right"]
stations = 3
[[step]]
name = "early"
time = 1
[[step]]
name = "late"
time = 2
[[probe]]
name = "n"
quantity = "cut.N"
reduce = "min"
"#;
    let case = Case::<2>::from_str(text, "test.toml", Path::new(".")).unwrap();
    let steps = case.model.solve_steps().unwrap();
    assert!(steps[0].sections.is_empty() && steps[0].probes[0].value.is_nan());
    assert_eq!(steps[1].sections[0].name, "cut");
    assert!((steps[1].probes[0].value + 10.0).abs() < 1e-9);
}

#[test]
fn probes_read_the_nearest_station_and_what_stations_become() {
    let probes = r#"
[[probe]]
name = "at"
quantity = "cut.M"
at = [2.4, 0.1]
[[probe]]
name = "largest"
quantity = "cut.V"
reduce = "max"
[[probe]]
name = "mean"
quantity = "cut.N"
reduce = "mean"
[[probe]]
name = "used"
quantity = "plain.utilisation"
reduce = "max"
[[section]]
name = "plain"
body = "beam"
sides = ["top", "bottom"]
stations = [[1, 0.25]]
capacity = { compression = 20000, tension = 3000 }
reinforcement = [{ depth = 0.05, area = 1e-3, yield = 435e3 }]
"#;
    let mesh = "rectangle = { from = [0, 0], to = [5, 0.5], cells = [10, 2], cell = \"quad9\" }";
    let solution = solved(&(CANTILEVER.replace("MESH", mesh) + probes));
    let stations = &solution.sections[0].stations;
    let probe = |name: &str| {
        solution
            .probes
            .iter()
            .find(|probe| probe.name == name)
            .unwrap()
    };
    assert_eq!(probe("at").value, stations[5].moment);
    assert_eq!(probe("largest").value, stations[0].shear);
    assert_eq!(probe("largest").at, Some([0.0, 0.25, 0.0]));
    let mean =
        |f: &dyn Fn(f64) -> f64| (0..=1000).map(|i| f(f64::from(i) / 200.0)).sum::<f64>() / 1001.0;
    let expected = mean(&|x| cantilever(5.0 - x)[0]);
    assert!((probe("mean").value / expected - 1.0).abs() < 1e-3);
    assert_eq!(
        Some(probe("used").value),
        solution.sections[2].stations[0].utilisation
    );
    assert!(probe("used").value > 0.0);
}

/// A wall along y from 0 to 6, of the thickness 1/2, pressed from the left by 10 (6 − y), with further keys.
fn wall(held: &str, keys: &str) -> String {
    format!(
        r#"
analysis = "plane-strain"
[[body]]
name = "wall"
mesh = {{ outline = {{ size = 0.25, cell = "tri6", from = [0, 0], edges = [
    {{ to = [0.5, 0], name = "foot" }}, {{ to = [0.5, 1.5], name = "low", cells = 5 }}, {{ to = [0.5, 6], name = "high", cells = 17 }},
    {{ to = [0, 6], name = "head" }}, {{ to = [0, 0], name = "left", cells = 25 }}] }} }}
material = {{ young = 30e6, poisson = 0.2 }}
fix = [{{ side = "{held}", x = 0, y = 0 }}]
load = [{{ side = "left", traction = ["10*(6 - y)", 0] }}]
{keys}
[[section]]
name = "s"
body = "wall"
sides = ["left", ["low", "high"]]
stations = [[0.25, 0], [0.25, 0.13], [0.25, 0.5], [0.25, 1.45], [0.25, 1.5], [0.25, 1.6], [0.25, 3], [0.25, 5.9], [0.25, 6]]
"#
    )
}

/// Force and moment about the origin of what acts above a height: a function of y and the force per length along +x there on
/// sides at 0 and 1/2, given where it has kinks.
fn above(y: f64, kinks: &[f64], along_x: impl Fn(f64) -> f64) -> [f64; 2] {
    let mut ends: Vec<f64> = kinks.iter().copied().filter(|k| *k > y).collect();
    ends.insert(0, y);
    let mut sums = [0.0; 2];
    for pair in ends.windows(2) {
        // Gauss's three points: exact for parabolas times y
        let (middle, half) = (0.5 * (pair[0] + pair[1]), 0.5 * (pair[1] - pair[0]));
        for (x, w) in [
            (-0.6_f64.sqrt(), 5.0 / 9.0),
            (0.0, 8.0 / 9.0),
            (0.6_f64.sqrt(), 5.0 / 9.0),
        ] {
            let at = middle + half * x;
            let force = half * w * along_x(at);
            sums[0] += force;
            sums[1] += force * (at - y);
        }
    }
    sums
}

/// Traction along x of a spring on the right side of the wall, and the ends of its facets.
fn spring_of(
    model: &Model<2>,
    solution: &Solution<2>,
    sides: &[&str],
    k: f64,
) -> (Vec<f64>, impl Fn(f64) -> f64) {
    let mesh = &model.bodies[0].mesh;
    let mut facets: Vec<[(f64, f64); 3]> = Vec::new();
    for side in sides {
        for &facet in mesh.side(side).unwrap() {
            let nodes: Vec<u32> = mesh.facet_nodes(facet).collect();
            let at = |n: u32| {
                let n = n as usize;
                (mesh.points()[n][1], solution.bodies[0].displacement[n][0])
            };
            facets.push([at(nodes[0]), at(nodes[2]), at(nodes[1])]);
        }
    }
    let mut kinks: Vec<f64> = facets.iter().flat_map(|f| [f[0].0, f[2].0]).collect();
    kinks.sort_by(f64::total_cmp);
    kinks.dedup();
    let traction = move |y: f64| {
        let within = |f: &&[(f64, f64); 3]| (f[0].0.min(f[2].0)..=f[0].0.max(f[2].0)).contains(&y);
        let Some([a, b, c]) = facets.iter().find(within) else {
            return 0.0;
        };
        let x = 2.0 * (y - a.0) / (c.0 - a.0) - 1.0;
        -k * (0.5 * x * (x - 1.0) * a.1 + (1.0 - x * x) * b.1 + 0.5 * x * (x + 1.0) * c.1)
    };
    (kinks, traction)
}

fn model_of(text: &str) -> Model<2> {
    let case = Case::<2>::from_str(text, "test.toml", Path::new("."));
    case.unwrap_or_else(|e| panic!("{e}")).model
}

#[test]
fn a_wall_on_springs_is_statics_up_to_its_clamp() {
    for (held, sides) in [
        ("foot", &["low", "high"][..]),
        ("head", &["low", "high"]),
        ("foot", &["high"]),
        ("head", &["low"]),
    ] {
        let names = format!(
            "[{}]",
            sides
                .iter()
                .map(|s| format!("\"{s}\""))
                .collect::<Vec<_>>()
                .join(", ")
        );
        let keys = format!("spring = [{{ side = {names}, normal = 2e4, tangential = 0 }}]");
        let model = model_of(&wall(held, &keys));
        let solution = model.solve().unwrap();
        let (mut kinks, spring) = spring_of(&model, &solution, sides, 2e4);
        kinks.extend([0.0, 6.0]);
        kinks.sort_by(f64::total_cmp);
        kinks.dedup();
        let reaction = solution.bodies[0].side_reactions[held];
        // the first side is on the left of s, which runs up
        let error = off(&solution.sections[0], |s| {
            let y = s.point[1];
            let [mut v, mut m] = above(y, &kinks, |y| 10.0 * (6.0 - y) + spring(y));
            if held == "head" {
                // the reaction, and its moment: what balances all the rest about the cut
                let [all, about] = above(0.0, &kinks, |y| 10.0 * (6.0 - y) + spring(y));
                assert!((all + reaction[0]).abs() < 1e-8 * 180.0);
                v -= all;
                m -= about - all * y;
            }
            [0.0, v, m]
        });
        assert!(error < 1e-9, "{held} {sides:?}: {error:.1e}");
    }
}

#[test]
fn a_long_side_that_is_held_in_part_bears_its_own_reaction() {
    // a roller on the lower part, springs above it, and the foot clamped: both hold x at the corner
    let keys = "spring = [{ side = \"high\", normal = 2e4 }]";
    let text = wall("foot", keys).replace(
        "fix = [{ side = \"foot\"",
        "fix = [{ side = \"low\", x = 0 }, { side = \"foot\"",
    );
    let model = model_of(&text);
    let solution = model.solve().unwrap();
    let (mut kinks, spring) = spring_of(&model, &solution, &["high"], 2e4);
    kinks.extend([0.0, 6.0]);
    kinks.sort_by(f64::total_cmp);
    kinks.dedup();
    let section = &solution.sections[0];
    let force: f64 = 180.0;
    for s in &section.stations {
        let y = s.point[1];
        let [mut v, m] = above(y, &kinks, |y| 10.0 * (6.0 - y) + spring(y));
        assert!(s.normal.abs() < 1e-9 * force, "{y}: {}", s.normal);
        if y > 1.5 - 1e-9 {
            assert!((s.shear - v).abs() < 1e-9 * force, "{y}: {} {v}", s.shear);
            assert!(
                (s.moment - m).abs() < 1e-9 * 3.0 * force,
                "{y}: {} {m}",
                s.moment
            );
        } else if y < 1e-9 {
            // all of the roller's reaction is ahead of the foot
            v += solution.bodies[0].side_reactions["low"][0];
            assert!((s.shear - v).abs() < 1e-9 * force, "{} {v}", s.shear);
            let foot = solution.bodies[0].side_reactions["foot"];
            assert!((s.shear + foot[0]).abs() < 1e-9 * force);
        }
    }
}

#[test]
fn contacts_and_couples_beside_a_held_end_are_on_their_own_side() {
    // pushed by a stiff beam below, driven by a point above
    let more = r#"
couple = [{ side = "head", point = "P", kind = "rigid" }]
points = { P = [0.25, 6] }
[[body]]
name = "prop"
mesh = { rectangle = { from = [0.5, 0], to = [1.5, 1.5], cells = [3, 4] } }
material = { young = 1e5, poisson = 0 }
fix = [{ side = "right", x = 0, y = 0 }]
[[contact]]
name = "joint"
nonmortar = "wall.low"
mortar = "prop.left"
"#;
    let text = wall("foot", more).replace(
        "load = [{ side",
        "load = [{ point = \"P\", force = [-20, -30], moment = 4 }, { side",
    );
    let solution = model_of(&text).solve().unwrap();
    let contact = &solution.contacts[0];
    let pushed = contact.resultant[0];
    assert!(pushed < -10.0, "{pushed}");
    for s in &solution.sections[0].stations {
        let y = s.point[1];
        let [mut v, mut m] = above(y, &[0.0, 6.0], |y| 10.0 * (6.0 - y));
        v -= 20.0;
        // with tension on the left side of s positive: a moment ahead about z is minus that
        m += -20.0 * (6.0 - y) - 4.0;
        if (1e-9..1.5 - 1e-9).contains(&y) {
            continue;
        }
        if y < 1e-9 {
            v += pushed;
            // its moment is about the origin: −y fx + x fy
            m += 0.25 * contact.resultant[1] - contact.moment[2];
        }
        if y > 6.0 - 1e-9 {
            continue;
        }
        assert!((s.normal + 30.0).abs() < 1e-8 * 180.0, "{y}: {}", s.normal);
        assert!((s.shear - v).abs() < 1e-7 * 180.0, "{y}: {} {v}", s.shear);
        assert!((s.moment - m).abs() < 1e-7 * 540.0, "{y}: {} {m}", s.moment);
    }
}

#[test]
fn beds_along_a_closed_ring_are_cut_where_the_cut_is() {
    // pressed evenly from inside it bears N = p b − k w a on every cut, w the way outward of its outer side
    for only in [false, true] {
        let text = format!(
            r#"
analysis = "plane-strain"
[[body]]
name = "ring"
mesh = {{ ring = {{ inner = 1.8, outer = 2, cells = [40, 2], cell = "quad9" }} }}
material = {{ young = 3e4, poisson = 0.2 }}
spring = [{{ side = "outer", normal = 30, compression_only = {only} }}]
load = [{{ side = "inner", pressure = 10 }}]
[[section]]
name = "s"
body = "ring"
sides = ["inner", "outer"]
stations = 24
"#
        );
        let solution = solved(&text);
        let displacements = solution.bodies[0].displacement.iter();
        let moved: Vec<f64> = displacements.map(|u| u[0].hypot(u[1])).collect();
        // the outer nodes move least
        let least = moved.iter().copied().fold(f64::INFINITY, f64::min);
        let normal = 10.0 * 1.8 - 30.0 * least * 2.0;
        for s in &solution.sections[0].stations {
            let off = (s.normal / normal - 1.0).abs();
            assert!(
                off < 1e-4 && s.shear.abs() < 1e-4 * normal,
                "{only} {normal} {s:?}"
            );
        }
    }
}
