//! Bodies out of one drawing: common nodes to the last bit, areas, what is cut off and what becomes one, exact states across
//! common lines, ground and water by expressions, and what is refused.

use crate::outline::{area, smallest_angle};
use dotyk::case::{Case, CaseError};
use dotyk::geometry::{Point, distance, norm, sub};
use dotyk::mesh::{
    CellKind, Contour, Division, Drawing, EdgeShape, Mesh, OutlineEdge, Region, Regions, SizePoint,
};
use dotyk::model::Solution;
use proptest::prelude::*;
use std::f64::consts::PI;

/// Nodes of a side as bits, sorted: equal when they are the same points.
fn bits(mesh: &Mesh<2>, side: &str) -> Vec<[u64; 2]> {
    let nodes = mesh.side_nodes(side).unwrap_or_default().into_iter();
    let mut nodes: Vec<[u64; 2]> = nodes
        .map(|node| mesh.points()[node as usize].map(f64::to_bits))
        .collect();
    nodes.sort_unstable();
    nodes
}

/// A straight line.
fn line(from: Point<2>, to: Point<2>) -> Contour {
    let edges = vec![OutlineEdge::line(to)];
    Contour::Path { from, edges }
}

/// The rectangle [-4, 4] × [-3, 3] with a circle of radius 2 about the origin and a level line through it.
fn tunnel(level: f64) -> Drawing {
    let corners = [[-4.0, -3.0], [4.0, -3.0], [4.0, 3.0], [-4.0, 3.0]];
    let lines = vec![
        Contour::polygon(&corners),
        Contour::circle([0.0, 0.0], 2.0),
        line([-2.5, level], [2.5, level]),
    ];
    Drawing::new(lines, 0.5)
        .region("rock", [3.0, 2.0])
        .region("heading", [0.0, level + 0.1])
        .region("bench", [0.0, level - 0.1])
}

/// Every side of one region towards another has the nodes of that one's side, to the last bit, and some.
fn assert_shared(regions: &Regions) {
    let names: Vec<&str> = regions.names().collect();
    let meshes: Vec<Mesh<2>> = names.iter().map(|n| regions.mesh(&[n]).unwrap()).collect();
    let mut shared = 0;
    for (a, name) in meshes.iter().zip(&names) {
        for (b, other) in meshes.iter().zip(&names) {
            if name != other {
                assert_eq!(bits(a, other), bits(b, name), "{name} and {other}");
                shared += usize::from(a.side(other).is_some());
            }
        }
    }
    assert!(shared >= 2);
}

#[test]
fn regions_have_the_same_nodes_on_their_common_lines() {
    for cell in [CellKind::Tri3, CellKind::Tri6] {
        let drawing = Drawing {
            cell,
            refine: vec![SizePoint {
                at: [-1.0, 1.7],
                size: 0.05,
                radius: 0.1,
            }],
            ..tunnel(0.7)
        };
        let regions = drawing.build().unwrap();
        assert_shared(&regions);
        for name in ["rock", "heading", "bench"] {
            let mesh = regions.mesh(&[name]).unwrap();
            assert!(smallest_angle(&mesh) > 20.0, "{name}");
            assert_eq!(mesh.groups(), [name]);
        }
    }
}

/// One body of several regions has the triangles of all, each line between them once.
#[test]
fn a_body_of_regions_has_their_common_nodes_once() {
    for cell in [CellKind::Tri3, CellKind::Tri6] {
        let drawing = Drawing {
            cell,
            ..tunnel(-0.4)
        };
        let regions = drawing.build().unwrap();
        let each = ["rock", "heading", "bench"].map(|name| regions.mesh(&[name]).unwrap());
        let inner = regions.mesh(&["heading", "bench"]).unwrap();
        let all = regions.mesh(&["bench", "rock", "heading"]).unwrap();
        let nodes = |mesh: &Mesh<2>| mesh.points().len();
        let on = |k: usize, side: &str| bits(&each[k], side).len();
        assert_eq!(
            nodes(&inner),
            nodes(&each[1]) + nodes(&each[2]) - on(1, "bench")
        );
        let around = bits(&inner, "rock").len();
        assert_eq!(nodes(&all), nodes(&each[0]) + nodes(&inner) - around);
        assert_eq!(all.groups(), ["rock", "heading", "bench"]);
        // lines inside are no sides, and what has no name is called as in an outline
        assert_eq!(all.side_names().collect::<Vec<_>>(), ["outline"]);
        // chords of the circle are taken from one side and given to the other: 48 to rounding
        assert!((area(&all) - 48.0).abs() < 1e-12);
        let sum: f64 = each.iter().map(area).sum();
        assert!((sum - 48.0).abs() < 1e-12);
    }
}

#[test]
fn nodes_lie_on_the_circle_and_where_lines_meet_it() {
    let regions = Drawing {
        cell: CellKind::Tri6,
        ..tunnel(0.7)
    };
    let regions = regions.build().unwrap();
    let inner = regions.mesh(&["heading", "bench"]).unwrap();
    for node in inner.side_nodes("rock").unwrap() {
        let away = norm(inner.points()[node as usize]);
        assert!((away - 2.0).abs() < 1e-14, "{away}");
    }
    // the error of curved quadratic cells: of the fourth order
    assert!((area(&inner) - 4.0 * PI).abs() < 1e-3);
    let heading = regions.mesh(&["heading"]).unwrap();
    let corner = [(4.0_f64 - 0.49).sqrt(), 0.7];
    let nearest = heading.points().iter().map(|&p| distance(p, corner));
    assert!(nearest.fold(1.0, f64::min) < 1e-15);
}

#[test]
fn the_finer_of_two_regions_decides_at_their_line() {
    let mut drawing = tunnel(0.7);
    drawing.regions[1].size = Some(0.05);
    let regions = drawing.build().unwrap();
    assert_shared(&regions);
    let bench = regions.mesh(&["bench"]).unwrap();
    let longest = |side: &str| {
        let facets = bench.side(side).unwrap().iter();
        facets.map(|&f| bench.facet_length(f)).fold(0.0, f64::max)
    };
    assert!(
        longest("heading") <= 0.05 * (1.0 + 1e-12),
        "{}",
        longest("heading")
    );
    assert!(longest("rock") > 0.3);
}

#[test]
fn what_sticks_out_is_cut_off() {
    let level: f64 = 0.7;
    let half = (4.0 - level * level).sqrt();
    let mut exact = tunnel(level);
    exact.lines[2] = line([-half, level], [half, level]);
    let mut long = tunnel(level);
    long.lines[2] = line([-3.9, level], [3.0, level]);
    let [exact, long] = [exact, long].map(|drawing| drawing.build().unwrap());
    for name in ["rock", "heading", "bench"] {
        let [a, b] = [&exact, &long].map(|regions| regions.mesh(&[name]).unwrap());
        assert_eq!(a.blocks(), b.blocks(), "{name}");
        for (p, q) in a.points().iter().zip(b.points()) {
            assert!(distance(*p, *q) < 1e-12);
        }
    }
}

/// Two closed outlines that share a line, an arc of one being drawn the other way round, are one drawing.
#[test]
fn lines_that_are_drawn_twice_are_one() {
    let arc = |to: Point<2>, clockwise: bool| {
        let shape = EdgeShape::Center {
            center: [0.0, 0.0],
            clockwise,
        };
        OutlineEdge::of(to, shape).named("vault")
    };
    let inside = Contour::Path {
        from: [-1.0, 0.0],
        edges: vec![OutlineEdge::line([1.0, 0.0]), arc([-1.0, 0.0], false)],
    };
    let outside = Contour::Path {
        from: [-1.0, 0.0],
        edges: vec![
            arc([1.0, 0.0], true).divided(Division::Size(0.1)),
            OutlineEdge::line([3.0, 0.0]),
            OutlineEdge::line([3.0, 2.0]),
            OutlineEdge::line([-3.0, 2.0]),
            OutlineEdge::line([-3.0, 0.0]),
            OutlineEdge::line([-1.0, 0.0]),
        ],
    };
    let regions = Drawing::new(vec![inside, outside], 0.4)
        .region("in", [0.0, 0.5])
        .region("out", [2.0, 1.0])
        .build()
        .unwrap();
    assert_shared(&regions);
    let mesh = regions.mesh(&["in"]).unwrap();
    assert_eq!(mesh.side("vault"), mesh.side("out"));
    // the finer of both
    assert_eq!(mesh.side("vault").unwrap().len(), 32);
    let outline = mesh.side("outline").unwrap();
    assert!(
        outline
            .iter()
            .all(|&f| mesh.facet_points(f).all(|p| p[1] == 0.0))
    );
}

/// Groups of lines inside a region are holes of it, filled or not, and groups in these as well.
#[test]
fn regions_nest() {
    let circles = [3.0, 2.0, 1.0].map(|r| Contour::circle([0.0, 0.0], r));
    let mut drawing = Drawing::new(circles.into(), 0.4)
        .region("outer", [2.5, 0.0])
        .region("inner", [0.5, 0.0]);
    drawing.cell = CellKind::Tri6;
    let regions = drawing.build().unwrap();
    let [outer, inner] = ["outer", "inner"].map(|name| regions.mesh(&[name]).unwrap());
    assert!((area(&outer) - 5.0 * PI).abs() < 1e-3);
    assert!((area(&inner) - PI).abs() < 1e-3);
    assert!(outer.side("inner").is_none());
}

/// A region in several parts; a line that divides nothing is kept within its region.
#[test]
fn a_region_may_have_parts_and_a_line_may_divide_nothing() {
    let square = Contour::polygon(&[[0.0, 0.0], [3.0, 0.0], [3.0, 1.0], [0.0, 1.0]]);
    let hole = Contour::polygon(&[[1.3, 0.4], [1.6, 0.4], [1.6, 0.7]]);
    let lines = vec![
        square,
        line([1.0, 0.0], [1.0, 1.0]),
        line([2.0, 0.0], [2.0, 1.0]),
        hole,
        line([1.0, 0.4], [1.3, 0.4]),
    ];
    let mut drawing = Drawing::new(lines, 0.2).region("middle", [1.8, 0.2]);
    drawing.regions.push(Region {
        name: "ends".to_string(),
        at: vec![[0.5, 0.5], [2.5, 0.5]],
        size: None,
    });
    let regions = drawing.build().unwrap();
    assert_shared(&regions);
    let [middle, ends] = ["middle", "ends"].map(|name| regions.mesh(&[name]).unwrap());
    assert!((area(&middle) - (1.0 - 0.045)).abs() < 1e-13);
    assert!((area(&ends) - 2.0).abs() < 1e-13);
    let on_line = |p: &&Point<2>| p[1] == 0.4 && (1.0..=1.3).contains(&p[0]);
    assert!(middle.points().iter().filter(on_line).count() >= 3);
    assert_eq!(smallest_angle(&middle).max(20.0), smallest_angle(&middle));
}

#[test]
fn the_order_of_lines_and_regions_does_not_matter() {
    let drawing = tunnel(0.7);
    let mut turned = drawing.clone();
    turned.lines.reverse();
    turned.regions.reverse();
    let [a, b] = [drawing, turned].map(|drawing| drawing.build().unwrap());
    for name in ["rock", "heading", "bench"] {
        let [a, b] = [&a, &b].map(|regions| regions.mesh(&[name]).unwrap());
        assert_eq!(
            a.side_names().collect::<Vec<_>>(),
            b.side_names().collect::<Vec<_>>()
        );
        for side in a.side_names() {
            assert_eq!(bits(&a, side), bits(&b, side), "{name}.{side}");
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig {
        cases: 60,
        rng_seed: proptest::test_runner::RngSeed::Fixed(1980),
        ..ProptestConfig::default()
    })]

    /// Strata with any dip and a fault of any angle through a tunnel anywhere: what they divide is told apart by the signs of
    /// simple functions.
    #[test]
    fn random_strata_share_their_nodes_and_fill_the_whole(
        heights in [-1.5..-0.3_f64, 0.3..1.5_f64],
        dips in [-0.3..0.3_f64, -0.3..0.3_f64],
        fault in (-2.0..2.0_f64, 0.6..2.5_f64),
        radius in 0.4..1.2_f64,
        size in 0.25..0.8_f64,
    ) {
        let corners = [[-4.0, -3.0], [4.0, -3.0], [4.0, 3.0], [-4.0, 3.0]];
        let layer = |k: usize| line([-5.0, heights[k] - 5.0 * dips[k]], [5.0, heights[k] + 5.0 * dips[k]]);
        let (at, angle) = fault;
        let along = [5.0 * angle.cos() / angle.sin(), 5.0];
        let mut lines = vec![
            Contour::polygon(&corners),
            layer(0),
            layer(1),
            line(sub([at, 0.0], along), [at + along[0], along[1]]),
            Contour::circle([0.0, 0.0], radius),
        ];
        // every part by its signs, from a fine lattice
        let side = |p: Point<2>| {
            let above = [0, 1].map(|k| p[1] - heights[k] - dips[k] * p[0]);
            let beside = p[0] - at - p[1] * angle.cos() / angle.sin();
            [above[0], above[1], beside, norm(p) - radius]
        };
        if lines.len() == 5 && heights[1] - heights[0] < 5.0 * (dips[0] - dips[1]).abs() {
            lines.remove(2);
        }
        let two = lines.len() == 5;
        let mut drawing = Drawing::new(lines, size);
        let mut found: Vec<([bool; 4], Vec<Point<2>>)> = Vec::new();
        for i in 0..159 {
            for j in 0..119 {
                let p = [-3.95 + 0.05 * f64::from(i), -2.95 + 0.05 * f64::from(j)];
                let mut signs = side(p);
                if !two {
                    signs[1] = 1.0;
                }
                if signs.iter().any(|s| s.abs() < 0.02) {
                    continue;
                }
                let key = signs.map(|s| s > 0.0);
                match found.iter_mut().find(|(known, _)| *known == key) {
                    Some((_, points)) => points.push(p),
                    None => found.push((key, vec![p])),
                }
            }
        }
        for (k, (_, points)) in found.iter().enumerate() {
            drawing = drawing.region(&format!("part{k}"), points[0]);
        }
        let regions = match drawing.build() {
            Ok(regions) => regions,
            Err(error) => {
                // lines that nearly touch
                let said = error.to_string();
                let near = ["under one degree", "nearly coincide"];
                prop_assert!(near.iter().any(|words| said.contains(words)), "{}", said);
                return Ok(());
            }
        };
        // what the tunnel cuts into two has a region for one part alone: the sum may be too small
        assert_shared(&regions);
        let names: Vec<&str> = regions.names().collect();
        let all = regions.mesh(&names).unwrap();
        let sum: f64 = names.iter().map(|name| area(&regions.mesh(&[name]).unwrap())).sum();
        prop_assert!((sum - area(&all)).abs() < 1e-11);
        prop_assert!(sum < 48.0 + 1e-11);
        prop_assert_eq!(drawing.build().unwrap().mesh(&names).unwrap(), all);
    }
}

const LINES: &str = "lines = [
  { from = [-4, -3], edges = [{ to = [4, -3], name = \"bottom\" }, { to = [4, 3], name = \"east\" }, { to = [-4, 3], name = \"top\" }, { to = [-4, -3], name = \"west\" }] },
  { circle = { center = [0.3, 0], radius = 2 }, size = 0.4 },
  { from = [-4, 0.8], to = [4, 1.3] },
]";
const REGIONS: &str = "regions = [{ name = \"upper\", at = [0, 2.5] }, { name = \"lower\", at = [0, -2.5] }, { name = \"heading\", at = [0, 1.5] }, { name = \"bench\", at = [0, 0] }]";

/// Four bodies, each tied to its neighbours.
fn four_bodies(cell: &str, bodies: [&str; 4], keys: impl Fn(&str) -> String) -> String {
    let mut text = format!(
        "analysis = \"plane-strain\"\n[drawing]\nsize = 1\ncell = \"{cell}\"\n{LINES}\n{REGIONS}\n"
    );
    for body in bodies {
        text += &format!(
            "[[body]]\nname = \"{body}\"\nmesh = {{ region = \"{body}\" }}\n\
             material = {{ young = 100, poisson = 0.3 }}\n{}\n",
            keys(body)
        );
    }
    for (a, b) in [
        ("upper", "lower"),
        ("upper", "heading"),
        ("lower", "bench"),
        ("heading", "bench"),
    ] {
        text += &format!(
            "[[contact]]\nname = \"{a}-{b}\"\nsides = [\"{a}.{b}\", \"{b}.{a}\"]\ntied = true\n"
        );
    }
    text
}

fn solved(text: &str) -> (Case<2>, Vec<Solution<2>>) {
    let case = Case::<2>::from_str(text, "drawing.toml", "".as_ref());
    let case = case.unwrap_or_else(|error| panic!("{error}"));
    let steps = case.model.solve_steps().unwrap();
    assert!(steps.iter().all(|step| step.converged));
    (case, steps)
}

/// A linear displacement around bodies that are tied along lines, arcs and where three of them meet is linear in all.
#[test]
fn constant_strain_passes_through_ties_along_common_lines() {
    let linear = |[x, y]: Point<2>| [1e-3 * x + 2e-3 * y, -3e-3 * y + 5e-4 * x];
    let fixed = |body: &str| match body {
        "upper" => {
            "fix = [{ side = [\"top\", \"east\", \"west\"], x = \"1e-3*x + 2e-3*y\", y = \"5e-4*x - 3e-3*y\" }]"
        }
        "lower" => {
            "fix = [{ side = [\"bottom\", \"east\", \"west\"], x = \"1e-3*x + 2e-3*y\", y = \"5e-4*x - 3e-3*y\" }]"
        }
        _ => "",
    };
    for cell in ["tri3", "tri6"] {
        let names = ["upper", "lower", "heading", "bench"];
        let text = four_bodies(cell, names, |body| fixed(body).to_string());
        let (case, steps) = solved(&text);
        for (body, solution) in case.model.bodies.iter().zip(&steps[0].bodies) {
            for (&x, &u) in body.mesh.points().iter().zip(&solution.displacement) {
                // rounding of stiffnesses of 100, beside displacements of 1e-2
                assert!(norm(sub(u, linear(x))) < 1e-12, "{} {x:?}", body.name);
            }
        }
        for contact in &case.model.contacts {
            assert!(contact.pairing.is_none());
        }
        let gaps = steps[0].contacts.iter().flat_map(|contact| &contact.nodes);
        assert!(gaps.clone().count() > 20);
        // nodes are the same points: there is nothing between them
        let contact_gaps = gaps.filter(|node| node.gap.is_finite());
        assert!(contact_gaps.into_iter().all(|node| node.gap.abs() < 1e-13));
    }
}

#[test]
fn the_order_of_the_bodies_does_not_matter() {
    let load = |body: &str| match body {
        "upper" => {
            "load = [{ side = \"top\", pressure = \"1 + x/8\" }]\nfix = [{ side = [\"west\", \"east\"], x = 0 }]"
        }
        "lower" => {
            "fix = [{ side = \"bottom\", x = 0, y = 0 }, { side = [\"west\", \"east\"], x = 0 }]"
        }
        _ => "",
    };
    let run = |names| solved(&four_bodies("tri6", names, |body| load(body).to_string()));
    let (first, a) = run(["upper", "lower", "heading", "bench"]);
    let (second, b) = run(["bench", "upper", "heading", "lower"]);
    for (body, solution) in first.model.bodies.iter().zip(&a[0].bodies) {
        let other = second.model.bodies.iter().position(|b| b.name == body.name);
        let other = other.unwrap();
        assert_eq!(second.model.bodies[other].mesh, body.mesh);
        let moved = solution
            .displacement
            .iter()
            .map(|&u| norm(u))
            .fold(0.0, f64::max);
        for (u, v) in solution
            .displacement
            .iter()
            .zip(&b[0].bodies[other].displacement)
        {
            // who carries the multipliers may differ: rounding of the ties
            assert!(norm(sub(*u, *v)) < 1e-9 * moved);
        }
    }
}

#[test]
fn a_drawing_makes_bodies_of_space_too() {
    let text = format!(
        "analysis = \"3d\"\n[drawing]\nsize = 1.5\n{LINES}\n{REGIONS}\n\
         [[body]]\nname = \"ground\"\nmesh = {{ extrude = {{ mesh = {{ region = [\"upper\", \"lower\"] }}, height = 2, layers = 2 }} }}\n\
         material = [{{ group = \"upper\", young = 100, poisson = 0.3 }}, {{ young = 50, poisson = 0.3 }}]\n\
         fix = [{{ side = \"bottom\", x = 0, y = 0, z = 0 }}]\n\
         [[body]]\nname = \"core\"\nmesh = {{ extrude = {{ mesh = {{ region = [\"heading\", \"bench\"] }}, height = 2, layers = 2 }} }}\n\
         material = {{ young = 100, poisson = 0.3 }}\n\
         [[contact]]\nname = \"wall\"\nsides = [[\"core.upper\", \"core.lower\"], [\"ground.heading\", \"ground.bench\"]]\ntied = true\n"
    );
    let case = Case::<3>::from_str(&text, "drawing.toml", "".as_ref()).unwrap();
    let [ground, core] = &case.model.bodies[..] else {
        panic!("two bodies");
    };
    let nodes = |mesh: &Mesh<3>, side: &str| {
        let nodes = mesh.side_nodes(side).unwrap().into_iter();
        let mut nodes: Vec<_> = nodes
            .map(|n| mesh.points()[n as usize].map(f64::to_bits))
            .collect();
        nodes.sort_unstable();
        nodes
    };
    let wall = nodes(&core.mesh, "upper+lower");
    assert_eq!(wall, nodes(&ground.mesh, "heading+bench"));
    assert_eq!(ground.mesh.groups(), ["upper", "lower"]);
}

/// Ground with a sloping surface under σ_yy = −γ·depth and a K0 is not in equilibrium, and said to be so; with a level surface
/// it is, and so is the slope whose shear stress is that of the theory of the infinite slope.
#[test]
fn ground_under_a_slope_needs_its_shear_stress() {
    let ground = |rise: f64, stress: &str| {
        let (west, east) = (10.0 - 10.0 * rise, 10.0 + 10.0 * rise);
        let text = format!(
            "analysis = \"plane-strain\"\n[parameters]\nrise = {rise}\n\
             [drawing]\nsize = 2\ncell = \"tri6\"\nlines = [\n\
             {{ from = [-10, 0], edges = [{{ to = [10, 0], name = \"bottom\" }}, {{ to = [10, {east}], name = \"east\" }}, {{ to = [-10, {west}], name = \"surface\" }}, {{ to = [-10, 0], name = \"west\" }}] }},\n\
             {{ from = [-10, 5], to = [10, 4] }}]\n\
             regions = [{{ name = \"upper\", at = [0, 8] }}, {{ name = \"lower\", at = [0, 2] }}]\n\
             [[body]]\nname = \"ground\"\nmesh = {{ region = [\"upper\", \"lower\"] }}\n\
             material = [{{ group = \"upper\", young = 20, poisson = 0.3 }}, {{ group = \"lower\", young = 90, poisson = 0.2 }}]\n\
             body_force = [0, -0.02]\ninitial_stress = {stress}\n\
             load = [{{ side = [\"west\", \"east\"], in_situ = 1 }}]\n\
             fix = [{{ side = [\"west\", \"east\"], x = 0 }}, {{ side = \"bottom\", x = 0, y = 0 }}]\n"
        );
        let (_, steps) = solved(&text);
        let moved = steps[0].bodies[0].displacement.iter();
        let moved = moved.map(|&u| norm(u)).fold(0.0, f64::max);
        let told = steps[0].warnings.iter().any(|w| w.contains("equilibrium"));
        (moved, told)
    };
    let depth = "(10 + rise*x - y)";
    let k0 = format!("{{ vertical = \"-0.02*{depth}\", k0 = 0.5 }}");
    let shear = format!(
        "{{ xx = \"-0.01*{depth}\", zz = \"-0.01*{depth}\", xy = \"-0.01*rise*{depth}\", yy = \"-(0.02 + 0.01*rise^2)*{depth}\" }}"
    );
    let (moved, told) = ground(0.0, &k0);
    assert!(moved < 1e-13 && !told, "{moved}");
    let (moved, told) = ground(0.3, &k0);
    assert!(moved > 1e-4 && told, "{moved}");
    let (moved, told) = ground(0.3, &shear);
    assert!(moved < 1e-13 && !told, "{moved}");
}

/// Water in the joint behind a lining presses on both sides: contact forces give way to it, node by node, and nothing moves.
#[test]
fn water_between_lining_and_ground_takes_over_what_they_pressed() {
    let text = "analysis = \"plane-strain\"
step = [{ time = 0 }, { time = 1 }, { time = 2 }]
[drawing]
size = 3
cell = \"tri6\"
lines = [
  { from = [-20, -20], edges = [{ to = [20, -20], name = \"bottom\" }, { to = [20, 20], name = \"east\" }, { to = [-20, 20], name = \"top\" }, { to = [-20, -20], name = \"west\" }] },
  { circle = { center = [0, 0], radius = 5 }, size = 0.8 },
  { circle = { center = [0, 0], radius = 4.5 } },
]
regions = [{ name = \"rock\", at = [0, 15] }, { name = \"ring\", at = [0, 4.8] }]
[[body]]
name = \"rock\"
mesh = { region = \"rock\" }
material = { young = 500, poisson = 0.3 }
initial_stress = { xx = -0.8, yy = -1, zz = -0.8 }
fix = [{ side = [\"west\", \"east\"], x = 0 }, { side = \"bottom\", y = 0 }]
load = [{ side = \"top\", in_situ = 1 }, { side = \"ring\", in_situ = \"max(0, 0.8 - t)\" }, { side = \"ring\", pressure = \"0.01*(10 - y)\", active = { from = 2 } }]
[[body]]
name = \"lining\"
mesh = { region = \"ring\" }
material = { young = 30000, poisson = 0.2 }
load = [{ side = \"rock\", pressure = \"0.01*(10 - y)\", active = { from = 2 } }]
active = { from = 1 }
[[contact]]
name = \"back\"
nonmortar = \"lining.rock\"
mortar = \"rock.ring\"
LAW
[[section]]
name = \"forces\"
body = \"lining\"
sides = [\"outline\", \"rock\"]
stations = 8
[[probe]]
name = \"what the rock bears\"
quantity = \"back.resultant.y\"
";
    // Without friction the force that a varying pressure on curved edges has at a node is a little off the normal of the node.
    for (law, tolerance) in [("", 1e-6), ("tied = true", 1e-9)] {
        let (_, steps) = solved(&text.replace("LAW", law));
        let [dry, wet] = [&steps[1], &steps[2]];
        let resultant = |step: &Solution<2>| step.probes[0].value;
        // Archimedes: the water bears 0.01·25π, and curved quadratic cells miss 1e-4 of the circle
        let lifted = resultant(dry) - resultant(wet);
        assert!((lifted / (0.25 * PI) - 1.0).abs() < 1e-3, "{lifted}");
        for (a, b) in dry.bodies.iter().zip(&wet.bodies) {
            let moved = a.displacement.iter().map(|&u| norm(u));
            let moved = moved.fold(0.0, f64::max);
            for (u, v) in a.displacement.iter().zip(&b.displacement) {
                assert!(norm(sub(*u, *v)) < tolerance * moved, "{}", a.name);
            }
        }
        let nodes = dry.contacts[0].nodes.iter().zip(&wet.contacts[0].nodes);
        for (a, b) in nodes {
            assert!(b.pressure > 0.0 && b.pressure < a.pressure);
        }
    }
}

/// In place of an error.
fn accepted(text: &str) -> CaseError {
    CaseError {
        message: format!("accepted: {text}"),
        label: "".into(),
        help: None,
        span: None,
        source_name: "".into(),
        source_text: "".into(),
    }
}

/// The error of a file, and what of it is underlined.
fn refused(text: &str) -> (CaseError, String) {
    let error = match Case::<2>::from_str(text, "drawing.toml", "".as_ref()) {
        Ok(_) => return (accepted(text), String::new()),
        Err(error) => error,
    };
    let span = error.span.clone().unwrap_or_default();
    let marked = text[span].to_string();
    (error, marked)
}

#[test]
fn wrong_drawings_are_refused_with_their_place() {
    let whole = format!(
        "analysis = \"plane-strain\"\n[drawing]\nsize = 1\n{LINES}\n{REGIONS}\n\
         [[body]]\nname = \"ground\"\nmesh = {{ region = [\"upper\", \"lower\"] }}\nmaterial = {{ young = 1, poisson = 0 }}\nfix = [{{ side = \"bottom\", x = 0, y = 0 }}]\n\
         [[body]]\nname = \"core\"\nmesh = {{ region = [\"heading\", \"bench\"] }}\nmaterial = {{ young = 1, poisson = 0 }}\nfix = [{{ side = \"upper\", x = 0, y = 0 }}]\n"
    );
    assert!(Case::<2>::from_str(&whole, "drawing.toml", "".as_ref()).is_ok());
    let layer = "{ from = [-4, 0.8], to = [4, 1.3] }";
    let of = |from: &str, to: &str| {
        assert!(whole.contains(from), "{from}");
        whole.replace(from, to)
    };
    let cases: &[(String, &str, &str)] = &[
        // regions that bodies name
        (
            of("region = [\"upper\",", "region = [\"uper\","),
            "no region `uper`",
            "\"uper\"",
        ),
        (
            of("\"upper\", \"lower\"] }", "\"upper\", \"upper\"] }"),
            "listed twice",
            "\"upper\"",
        ),
        (
            of("[\"heading\", \"bench\"]", "[\"heading\", \"lower\"]"),
            "both made of region `lower`",
            "\"lower\"",
        ),
        (
            of("[\"heading\", \"bench\"]", "[]"),
            "name of a group",
            "[]",
        ),
        (
            whole[whole.find("[[body]]").unwrap()..].replace(
                "[[body]]\nname = \"ground\"",
                "analysis = \"plane-strain\"\n[[body]]\nname = \"ground\"",
            ),
            "has no drawing",
            "[\"upper\", \"lower\"]",
        ),
        (
            of("fix = [{ side = \"upper\"", "fix = [{ side = \"sky\""),
            "no side `sky`",
            "\"sky\"",
        ),
        // what regions are
        (
            of("at = [0, 2.5] }", "at = [0, 3.5] }"),
            "surrounded by no lines",
            "{ name = \"upper\", at = [0, 3.5] }",
        ),
        (
            of("at = [0, 2.5] }", "at = [4, 2.5] }"),
            "lies on edge 2 of line 1 (`east`)",
            "{ name = \"upper\", at = [4, 2.5] }",
        ),
        (
            of("at = [0, 2.5] }", "at = [[0, 2.5], [1, 2.5]] }"),
            "in the same part",
            "{ name = \"upper\"",
        ),
        (
            of("name = \"bench\", at", "name = \"top\", at"),
            "a line has this name",
            "{ name = \"top\"",
        ),
        (
            of("name = \"bench\", at", "name = \"upper\", at"),
            "another region has this name",
            "{ name = \"upper\", at = [0, 0] }",
        ),
        (
            of("at = [0, 1.5] }", "at = [0, 1.5], size = 2 }"),
            "must be positive and not exceed",
            "{ name = \"heading\"",
        ),
        (
            of("at = [0, 1.5] }", "at = [] }"),
            "it has no point",
            "{ name = \"heading\"",
        ),
        (
            of(REGIONS, "regions = []"),
            "it has no regions",
            "[drawing]",
        ),
        (of(REGIONS, ""), "it has no regions", "[drawing]"),
        // lines
        (of(LINES, "lines = []"), "it has no lines", "[drawing]"),
        (
            of(&format!("  {layer},\n"), ""),
            "no line separates it from region `upper`",
            "{ name = \"lower\"",
        ),
        (
            of(layer, "{ from = [-4, 0.8], to = [3.99, 1.3] }"),
            "leads nowhere: it ends at [3.99, 1.3], 1.000e-2 away from edge 2 of line 1 (`east`)",
            "{ from = [-4, 0.8], to = [3.99",
        ),
        (
            of(
                layer,
                "{ from = [-4, 0.8], to = [4, 1.3] }, { from = [-1, 2.2], to = [1, 2.4], name = \"crack\" }",
            ),
            "leads nowhere",
            "{ from = [-1, 2.2]",
        ),
        (
            of(
                layer,
                "{ from = [-4, 0.8], to = [4, 1.3] }, { from = [-4, 0.8], to = [4, 1.31] }",
            ),
            "let them meet under one degree",
            "{ from = [-4, 0.8]",
        ),
        (
            of(
                layer,
                "{ from = [-4, 0.8], to = [4, 1.3] }, { from = [-5, 0.73751], to = [5, 1.36251] }",
            ),
            "nearly coincide: make them one",
            "{ to = [4, 3], name = \"east\" }",
        ),
        (
            of(
                layer,
                "{ from = [-4, 0.8], to = [4, 1.3] }, { from = [-5, 0.73753], to = [5, 1.36253] }",
            ),
            "nearly coincides with edge 1 of line",
            "{ from = [-",
        ),
        (
            of(layer, "{ from = [-4, 0.8], to = [4, 1.3], cells = 12 }"),
            "cannot have 12 cells",
            "{ from = [-4, 0.8]",
        ),
        (
            of(layer, "{ from = [-4, 0.8], to = [4, 1.3], size = 2 }"),
            "exceeds that of the whole drawing",
            "{ from = [-4, 0.8]",
        ),
        (
            of(
                layer,
                "{ from = [-4, 0.8], to = [4, 1.3], center = [9, 9] }",
            ),
            "they must be equal",
            "{ from = [-4, 0.8]",
        ),
        (
            of(
                layer,
                "{ from = [-4, 0.8], to = [4, 1.3], edges = [{ to = [4, 1.3] }] }",
            ),
            "both `to` and `edges`",
            "edges",
        ),
        (
            of(
                layer,
                "{ from = [-4, 0.8], edges = [{ to = [4, 1.3] }], cells = 8 }",
            ),
            "`cells` belongs to a single edge",
            "cells",
        ),
        (
            of(layer, "{ from = [-4, 0.8] }"),
            "a line needs `from` and `to` or `edges`",
            "{ from = [-4, 0.8] }",
        ),
        (
            of(layer, "{ from = [-4, 0.8], too = [4, 1.3] }"),
            "unknown key `too`",
            "too",
        ),
        (
            of("size = 1\n", "size = 1e-4\n").replace(", size = 0.4", ""),
            "nodes",
            "[drawing]",
        ),
        (of("size = 1\n", ""), "needs the key `size`", "[drawing]"),
        (
            of("size = 1\n", "size = 1\ncell = \"quad4\"\n"),
            "quad4",
            "\"quad4\"",
        ),
    ];
    let mut wrong = Vec::new();
    for (text, words, place) in cases {
        let (error, marked) = refused(text);
        if !error.message.contains(words) || !marked.starts_with(place) {
            wrong.push(format!("{words}: {error}; underlined: {marked}"));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn a_region_that_no_body_is_made_of_is_told() {
    let text = format!(
        "analysis = \"plane-strain\"\n[drawing]\nsize = 1\n{LINES}\n{REGIONS}\n\
         [[body]]\nname = \"ground\"\nmesh = {{ region = [\"upper\", \"lower\"] }}\nmaterial = {{ young = 1, poisson = 0 }}\n\
         fix = [{{ side = \"bottom\", x = 0, y = 0 }}]\n"
    );
    let case = Case::<2>::from_str(&text, "drawing.toml", "".as_ref()).unwrap();
    let told = case
        .warnings
        .iter()
        .any(|w| w.contains("no body has the regions `heading`, `bench`"));
    assert!(told, "{:?}", case.warnings);
}
