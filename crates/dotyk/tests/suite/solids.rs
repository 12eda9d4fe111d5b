//! Cylinders, spheres and extruded meshes: volumes, areas of sides, closed boundaries, quality, true surfaces.
//!
//! Volumes and areas are integrals over the cells and facets, compared with the closed forms of the true solids: their errors
//! fall with the second power of the cell size for linear cells and with the fourth for quadratic ones, whose middle nodes
//! lie on the true surfaces. The cells at the apex of a cone span a quarter of the turn however small they are: its area is
//! wrong by h², and the volume by h³.
//! The quality of tetrahedra is that of slender hexahedra cut into six.

use dotyk::fem::quadrature::rule;
use dotyk::geometry::{Point, Surface, cross, dot, norm};
use dotyk::mesh::{
    CellBlock, CellKind, Cylinder, Diagonals, Extrude, Facet, MAX_CELL_NODES, Mesh, MeshError,
    Path, Rectangle, Ring, Sphere,
};
use std::collections::{BTreeMap, BTreeSet};
use std::f64::consts::PI;

const CELLS: [CellKind; 5] = [
    CellKind::Tet4,
    CellKind::Tet10,
    CellKind::Hex8,
    CellKind::Hex20,
    CellKind::Hex27,
];

pub fn volume(mesh: &Mesh<3>) -> f64 {
    let mut sum = 0.0;
    for block in mesh.blocks() {
        let rule = rule(block.kind, 6);
        for cell in block.cells() {
            for point in &rule {
                let mut slopes = [[0.0; 3]; MAX_CELL_NODES];
                block.kind.gradients(&point.xi, &mut slopes);
                let mut columns = [[0.0; 3]; 3];
                for (&node, slope) in cell.iter().zip(&slopes) {
                    for (column, s) in columns.iter_mut().zip(slope) {
                        for (c, x) in column.iter_mut().zip(mesh.points()[node as usize]) {
                            *c += s * x;
                        }
                    }
                }
                sum += point.weight * dot(cross(columns[0], columns[1]), columns[2]);
            }
        }
    }
    sum
}

pub fn area(mesh: &Mesh<3>, side: &str) -> f64 {
    let of_facet = |&facet: &Facet| {
        let points = rule(mesh.facet_kind(facet), 8).into_iter();
        points
            .map(|p| p.weight * norm(mesh.outward_normal(facet, &p.xi)))
            .sum::<f64>()
    };
    let facets = mesh.side(side).unwrap_or_else(|| panic!("no side {side}"));
    facets.iter().map(of_facet).sum()
}

fn worst_quality(mesh: &Mesh<3>) -> f64 {
    let blocks = mesh.blocks().iter().enumerate();
    let cells = blocks.flat_map(|(b, block)| (0..block.cells().len()).map(move |c| (b, c)));
    cells
        .map(|(b, c)| mesh.cell_quality(b, c))
        .fold(1.0, f64::min)
}

/// Cells meet in whole facets with the same nodes, the boundary is closed, its facets lie on one side each. Gives V − E + F.
pub fn check_topology(mesh: &Mesh<3>) -> i64 {
    let table = mesh.facet_table();
    for (b, block) in mesh.blocks().iter().enumerate() {
        for (c, (local, (kind, _))) in (0..block.cells().len())
            .flat_map(|c| block.kind.facets().iter().enumerate().map(move |f| (c, f)))
        {
            let facet = Facet {
                block: b as u32,
                cell: c as u32,
                local: local as u32,
            };
            let nodes: Vec<u32> = mesh.facet_nodes(facet).collect();
            let all = |facet: Facet| mesh.facet_nodes(facet).collect::<BTreeSet<u32>>();
            let same: Vec<Facet> = table.find(&nodes[..kind.corners()]).collect();
            assert!(same.len() <= 2, "{} cells at a facet", same.len());
            assert!(same.iter().all(|&other| all(other) == all(facet)));
        }
    }
    let boundary = mesh.boundary_facets();
    let named: Vec<Facet> = mesh.sides().values().flatten().copied().collect();
    assert_eq!(
        named.iter().copied().collect::<BTreeSet<_>>(),
        boundary.iter().copied().collect()
    );
    assert_eq!(named.len(), boundary.len(), "sides overlap");
    let mut corners = BTreeSet::new();
    let mut edges: BTreeMap<[u32; 2], usize> = BTreeMap::new();
    for &facet in &boundary {
        let n = mesh.facet_kind(facet).corners();
        let nodes: Vec<u32> = mesh.facet_nodes(facet).take(n).collect();
        for k in 0..n {
            let (a, b) = (nodes[k], nodes[(k + 1) % n]);
            *edges.entry([a.min(b), a.max(b)]).or_default() += 1;
        }
        corners.extend(nodes);
    }
    assert!(
        edges.values().all(|&count| count == 2),
        "the boundary is open"
    );
    corners.len() as i64 - edges.len() as i64 + boundary.len() as i64
}

/// The errors of volume and areas fall at the rate of the cells; `build` makes a mesh with n times as many cells.
fn check_solid(
    what: &str,
    cell: CellKind,
    build: impl Fn(usize) -> Mesh<3>,
    (exact, sides): (f64, &[(&str, f64)]),
    euler: i64,
) {
    let [coarse, fine] = [2, 4].map(&build);
    for mesh in [&build(1), &coarse, &fine] {
        assert_eq!(check_topology(mesh), euler, "{what} {cell:?}");
        assert_eq!(mesh.side_names().count(), sides.len(), "{what}");
    }
    let quality = worst_quality(&fine);
    let slender = cell.corners() == 4 || what == "axis";
    let floor = if slender { 0.03 } else { 0.3 };
    assert!(quality > floor, "{what} {cell:?}: quality {quality}");
    let order = |a: f64, b: f64, exact: f64| {
        let [a, b] = [a, b].map(|x| (x / exact - 1.0).abs());
        // nothing is left to measure where an area is exact
        (b > 1e-12).then(|| (a / b).log2())
    };
    let apex = what == "cone";
    let highest = |limit: f64| (2.0 * cell.order() as f64).min(limit) - 0.2;
    let expected = highest(if apex { 3.0 } else { 4.0 });
    let (a, b) = (volume(&coarse), volume(&fine));
    let rate = order(a, b, exact);
    println!(
        "{what:<12} {:<6} quality {quality:.3} volume {:.2e} {rate:?}",
        cell.name(),
        b / exact - 1.0
    );
    assert!(
        rate.is_none_or(|r| r > expected),
        "{what} {cell:?}: {rate:?}"
    );
    for &(side, exact) in sides {
        let (a, b) = (area(&coarse, side), area(&fine, side));
        let rate = order(a, b, exact);
        let cone = apex && ["start", "end"].contains(&side);
        let expected = highest(if cone { 2.0 } else { 4.0 });
        println!("    {side:<8} {:.2e} {rate:?}", b / exact - 1.0);
        assert!(
            rate.is_none_or(|r| r > expected),
            "{what} {cell:?} {side}: {rate:?} {a} {b} {exact}"
        );
    }
    for facet in fine.boundary_facets() {
        if let Some(surface) = fine.curve(facet) {
            let off = fine.facet_points(facet).map(|x| surface.distance(x).abs());
            assert!(off.fold(0.0, f64::max) < 1e-13 * fine.diameter());
        }
    }
}

fn cylinder(cell: CellKind, inner: f64, angles: Option<[f64; 2]>, cells: [usize; 3]) -> Cylinder {
    Cylinder {
        base: [1.0, -2.0, 0.5],
        axis: [1.0, 2.0, -0.7],
        radius: 1.5,
        inner,
        height: 2.0,
        angles,
        cells,
        cell,
    }
}

#[test]
fn cylinders_have_their_volume_and_areas() {
    let (r, h) = (1.5f64, 2.0);
    for cell in CELLS {
        let disc = PI * r * r;
        let sides = [("bottom", disc), ("top", disc), ("outer", 2.0 * PI * r * h)];
        let solid = |n| cylinder(cell, 0.0, None, [8 * n, n, n]).build().unwrap();
        check_solid("solid", cell, solid, (disc * h, &sides), 2);
        for span in [60.0, 90.0, 180.0, 250.0, 330.0] {
            let part = span / 360.0;
            let flat = r * h;
            let sides = [
                ("bottom", part * disc),
                ("top", part * disc),
                ("outer", part * 2.0 * PI * r * h),
                ("start", flat),
                ("end", flat),
            ];
            let around = (span / 30.0) as usize;
            let sector = |n| {
                let angles = Some([20.0, 20.0 + span]);
                cylinder(cell, 0.0, angles, [around * n, n, n])
                    .build()
                    .unwrap()
            };
            check_solid("sector", cell, sector, (part * disc * h, &sides), 2);
        }
        let inner = 0.6f64;
        let ring = disc - PI * inner * inner;
        let hollow = [
            ("bottom", ring),
            ("top", ring),
            ("outer", 2.0 * PI * r * h),
            ("inner", 2.0 * PI * inner * h),
        ];
        let pipe = |n| cylinder(cell, inner, None, [8 * n, n, n]).build().unwrap();
        check_solid("pipe", cell, pipe, (ring * h, &hollow), 0);
        let shares = hollow.map(|(name, area)| (name, 0.25 * area));
        let ends = [("start", (r - inner) * h), ("end", (r - inner) * h)];
        let sides: Vec<(&str, f64)> = shares.into_iter().chain(ends).collect();
        let part = |n| {
            cylinder(cell, inner, Some([0.0, 90.0]), [3 * n, n, n])
                .build()
                .unwrap()
        };
        check_solid("elbow", cell, part, (0.25 * ring * h, &sides), 2);
    }
}

#[test]
fn a_cylinder_starts_where_the_smallest_rotation_takes_x() {
    let mut quarter = cylinder(CellKind::Hex8, 0.5, Some([0.0, 90.0]), [2, 1, 1]);
    (quarter.base, quarter.axis) = ([0.0; 3], [0.0, 0.0, 3.0]);
    let ends = |cylinder: &Cylinder, side: &str| -> Vec<Point<3>> {
        let mesh = cylinder.build().unwrap();
        let nodes = mesh.side_nodes(side).unwrap();
        nodes.iter().map(|&n| mesh.points()[n as usize]).collect()
    };
    assert!(
        ends(&quarter, "start")
            .iter()
            .all(|x| x[1] == 0.0 && x[0] > 0.0)
    );
    assert!(
        ends(&quarter, "end")
            .iter()
            .all(|x| x[0] == 0.0 && x[1] > 0.0)
    );
    assert!(ends(&quarter, "top").iter().all(|x| x[2] == 2.0));
    // z onto x takes x onto −z
    quarter.axis = [1.0, 0.0, 0.0];
    assert!(
        ends(&quarter, "start")
            .iter()
            .all(|x| x[1] == 0.0 && x[2] < 0.0)
    );
    assert!(
        ends(&quarter, "end")
            .iter()
            .all(|x| x[2] == 0.0 && x[1] > 0.0)
    );
    // z onto −z about x
    quarter.axis = [0.0, 0.0, -1.0];
    assert!(
        ends(&quarter, "start")
            .iter()
            .all(|x| x[1] == 0.0 && x[0] > 0.0)
    );
    assert!(
        ends(&quarter, "end")
            .iter()
            .all(|x| x[0] == 0.0 && x[1] < 0.0)
    );
}

fn sphere(cell: CellKind, inner: f64, angles: [f64; 2], cells: [usize; 2]) -> Sphere {
    Sphere {
        center: [0.3, -1.0, 2.0],
        radius: 1.3,
        inner,
        angles,
        cells,
        cell,
    }
}

#[test]
fn spheres_have_their_volume_and_areas() {
    let (r, i) = (1.3f64, 0.7f64);
    for cell in CELLS {
        let ball = |n| sphere(cell, 0.0, [0.0, 180.0], [8 * n, n]).build().unwrap();
        let whole = [("outer", 4.0 * PI * r * r)];
        check_solid("ball", cell, ball, (4.0 / 3.0 * PI * r.powi(3), &whole), 2);
        let shell = |n| sphere(cell, i, [0.0, 180.0], [8 * n, n]).build().unwrap();
        let both = [("outer", 4.0 * PI * r * r), ("inner", 4.0 * PI * i * i)];
        let content = 4.0 / 3.0 * PI * (r.powi(3) - i.powi(3));
        check_solid("shell", cell, shell, (content, &both), 4);
        for [from, to] in [[0.0, 90.0], [0.0, 50.0], [70.0, 180.0], [30.0, 100.0]] {
            let [a, b] = [from, to].map(f64::to_radians);
            let zone = 2.0 * PI * (a.cos() - b.cos());
            // the cone at a polar angle between two radii
            let cone = |angle: f64, inner: f64| PI * angle.sin() * (r * r - inner * inner);
            let ends = |inner: f64| {
                let start = (from > 0.0).then(|| ("start", cone(a, inner)));
                let end = (to < 180.0).then(|| ("end", cone(b, inner)));
                start.into_iter().chain(end).collect::<Vec<_>>()
            };
            let pole = from == 0.0 || to == 180.0;
            let mut sides = ends(i);
            sides.extend([("outer", zone * r * r), ("inner", zone * i * i)]);
            let cap = |n| sphere(cell, i, [from, to], [8 * n, n]).build().unwrap();
            let content = zone / 3.0 * (r.powi(3) - i.powi(3));
            check_solid(
                "cap",
                cell,
                cap,
                (content, &sides),
                if pole { 2 } else { 0 },
            );
            if pole {
                let mut sides = ends(0.0);
                sides.push(("outer", zone * r * r));
                let part = |n| sphere(cell, 0.0, [from, to], [8 * n, n]).build().unwrap();
                let what = if to == 90.0 { "half" } else { "cone" };
                check_solid(what, cell, part, (zone / 3.0 * r.powi(3), &sides), 2);
            }
        }
    }
}

fn plane(cell: CellKind, cells: [usize; 2]) -> Mesh<2> {
    let rectangle = Rectangle {
        from: [1.0, 0.0],
        to: [2.0, 1.5],
        cells,
        cell,
        diagonals: Diagonals::Checkerboard,
    };
    rectangle.build().unwrap()
}

#[test]
fn extruded_meshes_keep_their_sides() {
    let kinds = [
        (CellKind::Tri3, CellKind::Prism6),
        (CellKind::Tri6, CellKind::Prism15),
        (CellKind::Quad4, CellKind::Hex8),
        (CellKind::Quad8, CellKind::Hex20),
        (CellKind::Quad9, CellKind::Hex27),
    ];
    for (flat, solid) in kinds {
        let straight = |n: usize| {
            let extrude = Extrude {
                mesh: plane(flat, [2 * n, n]),
                path: Path::Straight(0.8),
                offset: 0.0,
                layers: n,
            };
            extrude.build().unwrap()
        };
        assert_eq!(straight(1).blocks()[0].kind, solid);
        let sides = [
            ("left", 1.5 * 0.8),
            ("right", 1.5 * 0.8),
            ("bottom", 0.8),
            ("top", 0.8),
            ("first", 1.5),
            ("last", 1.5),
        ];
        check_solid("straight", solid, straight, (1.5 * 0.8, &sides), 2);
        for (angle, axis) in [(80.0, 1.0), (80.0, -1.0), (360.0, 1.0)] {
            let turn: f64 = f64::to_radians(angle);
            let turned = |n: usize| {
                let extrude = Extrude {
                    mesh: plane(flat, [2 * n, n]),
                    path: Path::Turn {
                        point: [0.0; 3],
                        axis: [0.0, 2.0 * axis, 0.0],
                        angle,
                    },
                    offset: 0.0,
                    layers: n * (angle / 40.0) as usize,
                };
                extrude.build().unwrap()
            };
            // right-handed about +y, x > 0 goes to −z
            let last = turned(1).points().iter().map(|x| x[2]).sum::<f64>();
            assert!(angle == 360.0 || last * axis < 0.0);
            let mut sides = vec![
                ("left", turn * 1.5),
                ("right", turn * 2.0 * 1.5),
                ("bottom", turn * 1.5),
                ("top", turn * 1.5),
            ];
            if angle < 360.0 {
                sides.extend([("first", 1.5), ("last", 1.5)]);
            }
            let euler = if angle < 360.0 { 2 } else { 0 };
            // Pappus: area times the way of its centre
            check_solid("turned", solid, turned, (1.5 * 1.5 * turn, &sides), euler);
            let mesh = turned(1);
            let outer = mesh.side("right").unwrap();
            let known = |&f: &Facet| matches!(mesh.curve(f), Some(Surface::Cylinder { radius, .. }) if radius == 2.0);
            assert!(outer.iter().all(known));
        }
    }
}

/// A rectangle or, with a fan of triangles, one that is cut, from x = 0, turned about its left side.
#[test]
fn sections_that_touch_their_axis_make_whole_solids() {
    let kinds = [
        (CellKind::Tri3, CellKind::Tet4),
        (CellKind::Tri6, CellKind::Tet10),
        (CellKind::Quad4, CellKind::Prism6),
        (CellKind::Quad8, CellKind::Prism15),
        (CellKind::Quad9, CellKind::Prism18),
    ];
    for (flat, solid) in kinds {
        for (angle, axis, offset) in [
            (80.0, 1.0, 0.0),
            (-80.0, 1.0, 25.0),
            (80.0, -1.0, -10.0),
            (360.0, 1.0, 0.0),
            (-360.0, 1.0, 90.0),
        ] {
            let turn: f64 = f64::to_radians(f64::abs(angle));
            let turned = |n: usize| {
                let section = Rectangle {
                    from: [0.0, 0.0],
                    to: [1.0, 1.5],
                    cells: [n, n],
                    cell: flat,
                    diagonals: Diagonals::Checkerboard,
                };
                let extrude = Extrude {
                    mesh: section.build().unwrap(),
                    path: Path::Turn {
                        point: [0.0, -3.0, 0.0],
                        axis: [0.0, 2.0 * axis, 0.0],
                        angle,
                    },
                    offset,
                    layers: n * (angle.abs() / 40.0) as usize,
                };
                extrude.build().unwrap()
            };
            let mesh = turned(2);
            assert_eq!(mesh.blocks()[0].kind, solid);
            let mut sides = vec![
                ("right", turn * 1.5),
                ("bottom", 0.5 * turn),
                ("top", 0.5 * turn),
            ];
            if angle.abs() < 360.0 {
                sides.extend([("first", 1.5), ("last", 1.5)]);
                // right-handed about +y, x > 0 goes to −z
                for (side, degrees) in [("first", offset), ("last", offset + angle)] {
                    let (sin, cos) = f64::to_radians(-axis * degrees).sin_cos();
                    for node in mesh.side_nodes(side).unwrap() {
                        let [x, _, z] = mesh.points()[node as usize];
                        assert!((x * sin - z * cos).abs() < 1e-12, "{side} {x} {z}");
                    }
                }
            }
            check_solid("axis", solid, turned, (0.75 * turn, &sides), 2);
        }
    }
}

/// Half a ring whose two ends lie on the axis makes a hollow ball, and a corner of triangles on the axis a pinched ring.
#[test]
fn balls_and_pinched_rings_are_turned() {
    let turned = |mesh: Mesh<2>, axis: [f64; 3], angle: f64, layers: usize| {
        let path = Path::Turn {
            point: [0.0; 3],
            axis,
            angle,
        };
        let extrude = Extrude {
            mesh,
            path,
            offset: 0.0,
            layers,
        };
        extrude.build().unwrap()
    };
    for cell in [CellKind::Quad8, CellKind::Tri6] {
        let ring = Ring {
            center: [0.0; 2],
            inner: 0.5,
            outer: 1.0,
            angles: Some([-90.0, 90.0]),
            cells: [12, 3],
            ratio: 1.0,
            grade: 1.0,
            cell,
            diagonals: Diagonals::Forward,
        };
        let mesh = turned(ring.build().unwrap(), [0.0, 1.0, 0.0], 360.0, 16);
        assert_eq!(check_topology(&mesh), 4);
        assert_eq!(mesh.side_names().collect::<Vec<_>>(), ["inner", "outer"]);
        assert!((volume(&mesh) / (PI * 4.0 / 3.0 * (1.0 - 0.125)) - 1.0).abs() < 1e-3);
        for (side, radius) in [("outer", 1.0), ("inner", 0.5)] {
            for &facet in mesh.side(side).unwrap() {
                let known = mesh.curve(facet);
                assert!(matches!(known, Some(Surface::Sphere { radius: r, .. }) if r == radius));
            }
        }
    }
    for cell in [CellKind::Tri3, CellKind::Tri6] {
        let square = Rectangle {
            from: [0.0, 0.0],
            to: [1.0, 1.0],
            cells: [4, 4],
            cell,
            diagonals: Diagonals::Forward,
        };
        let mesh = turned(square.build().unwrap(), [1.0, -1.0, 0.0], 90.0, 24);
        // Pappus: the middle is 1/√2 off the axis
        let exact = 0.5 * PI * 0.5f64.sqrt();
        assert!((volume(&mesh) / exact - 1.0).abs() < 1e-3);
        check_topology(&mesh);
    }
}

#[test]
fn an_extrusion_begins_where_it_is_told_and_may_go_down() {
    for (offset, height) in [(0.0, -0.8), (2.5, 0.8), (-1.0, -0.25)] {
        let mesh = Extrude {
            mesh: plane(CellKind::Quad8, [2, 2]),
            path: Path::Straight(height),
            offset,
            layers: 3,
        };
        assert_eq!(mesh.foot([1.5, 1.0]), [1.5, 1.0, offset]);
        let mesh = mesh.build().unwrap();
        assert_eq!(check_topology(&mesh), 2);
        assert!((volume(&mesh) - 1.5 * height.abs()).abs() < 1e-12);
        for (side, z) in [("first", offset), ("last", offset + height)] {
            let nodes = mesh.side_nodes(side).unwrap();
            assert!(nodes.iter().all(|&n| mesh.points()[n as usize][2] == z));
        }
    }
}

/// A quarter of a column under pressure, of every kind of cells that a section at its axis gives: the same stress everywhere.
#[test]
fn cells_at_an_axis_pass_the_patch_test() {
    for cell in ["tri3", "tri6", "quad4", "quad8", "quad9"] {
        let text = format!(
            "analysis = \"3d\"\n[[body]]\nname = \"c\"\nmaterial = {{ young = 1000, poisson = 0.3 }}\n\
             points = {{ top = [0, 2, 0] }}\n\
             mesh = {{ extrude = {{ mesh = {{ rectangle = {{ from = [0, 0], to = [1, 2], cells = [3, 2], cell = \"{cell}\" }} }}, \
             turn = {{ point = [0, 0, 0], axis = [0, 1, 0], angle = -90 }}, offset = 90, layers = 3 }} }}\n\
             fix = [{{ side = \"first\", normal = 0 }}, {{ side = \"last\", normal = 0 }}, {{ side = \"bottom\", y = 0 }}]\n\
             load = [{{ side = \"top\", pressure = 10 }}]\n"
        );
        let model = dotyk::case::Case::<3>::from_str(&text, "c.toml", "".as_ref())
            .unwrap()
            .model;
        let solution = model.solve().unwrap();
        for stress in &solution.bodies[0].stress {
            for (s, exact) in stress.iter().zip([0.0, -10.0, 0.0, 0.0, 0.0, 0.0]) {
                assert!((s - exact).abs() < 1e-8, "{cell}: {stress:?}");
            }
        }
    }
}

#[test]
fn cells_are_counted_before_they_are_made() {
    for cell in [CellKind::Hex8, CellKind::Tet4] {
        for inner in [0.0, 1.0] {
            for (angles, around) in [
                (None, 14),
                (Some([10.0, 100.0]), 7),
                (Some([0.0, 300.0]), 19),
            ] {
                let cylinder = cylinder(cell, inner, angles, [around, 3, 2]);
                let mesh = cylinder.build().unwrap();
                assert_eq!(mesh.cell_count() as u128, cylinder.cell_count());
            }
            let whole = [0.0, 180.0];
            let parts = [[0.0, 90.0], [70.0, 180.0], [0.0, 10.0], whole];
            // a part without a pole is hollow
            let ring = (inner > 0.0).then_some([40.0, 110.0]);
            for angles in parts.into_iter().chain(ring) {
                let sphere = sphere(cell, inner, angles, [12, 3]);
                let mesh = sphere.build().unwrap();
                assert_eq!(mesh.cell_count() as u128, sphere.cell_count());
            }
        }
    }
}

/// A quad8, a quad9 and two tri6 in a row on [0, 3] × [0, 1], one middle node of the quad8 moved outwards.
fn mixed_row() -> Mesh<2> {
    // the lattice of halves of cells; the centre of the first square is no node
    let lattice = (0..3).flat_map(|v| (0..7).map(move |u| [u, v]));
    let lattice: Vec<[usize; 2]> = lattice.filter(|at| *at != [1, 1]).collect();
    let place = |at: [usize; 2]| lattice.iter().position(|&other| other == at).unwrap();
    let points = lattice.iter().map(|at| at.map(|c| 0.5 * c as f64));
    let mut points: Vec<Point<2>> = points.collect();
    points[place([0, 1])] = [-0.2, 0.5];
    let cell = |u: usize, places: &[[usize; 2]]| -> Vec<u32> {
        let nodes = places.iter().map(|&[i, j]| place([u + i, j]) as u32);
        nodes.collect()
    };
    let square = [
        [0, 0],
        [2, 0],
        [2, 2],
        [0, 2],
        [1, 0],
        [2, 1],
        [1, 2],
        [0, 1],
        [1, 1],
    ];
    let below = [[0, 0], [2, 0], [2, 2], [1, 0], [2, 1], [1, 1]];
    let above = [[0, 0], [2, 2], [0, 2], [1, 1], [1, 2], [0, 1]];
    let block = |kind, nodes| CellBlock {
        kind,
        nodes,
        group: None,
    };
    let blocks = vec![
        block(CellKind::Quad8, cell(0, &square[..8])),
        block(CellKind::Quad9, cell(2, &square)),
        block(CellKind::Tri6, [cell(4, &below), cell(4, &above)].concat()),
    ];
    Mesh::new(points, blocks).unwrap()
}

#[test]
fn cells_beside_those_with_nodes_in_their_faces_have_them_too() {
    let mesh = Extrude {
        mesh: mixed_row(),
        path: Path::Straight(2.0),
        offset: 0.0,
        layers: 2,
    };
    let mesh = mesh.build().unwrap();
    let kinds: Vec<CellKind> = mesh.blocks().iter().map(|block| block.kind).collect();
    assert_eq!(kinds, [CellKind::Hex27, CellKind::Hex27, CellKind::Prism18]);
    let mut inner = 0;
    let nodes = |facet: Facet| mesh.facet_nodes(facet).collect::<BTreeSet<u32>>();
    let table = mesh.facet_table();
    for block in 0..mesh.blocks().len() {
        for cell in 0..mesh.blocks()[block].cells().len() {
            for local in 0..mesh.blocks()[block].kind.facets().len() {
                let facet = Facet {
                    block: block as u32,
                    cell: cell as u32,
                    local: local as u32,
                };
                let corners = mesh.facet_kind(facet).corners();
                let corners: Vec<u32> = mesh.facet_nodes(facet).take(corners).collect();
                for other in table.find(&corners).filter(|&other| other != facet) {
                    assert_eq!(nodes(facet), nodes(other));
                    inner += 1;
                }
            }
        }
    }
    // three between columns in each of two layers, one between the layers over each of four cells, seen from both sides
    assert_eq!(inner, 2 * (3 * 2 + 4));
    // what bulges out is 2/3 of its height times the length of its edge
    assert!((volume(&mesh) - 2.0 * (3.0 + 2.0 / 3.0 * 0.2)).abs() < 1e-13);
}

#[test]
fn an_arc_turned_about_its_diameter_is_a_sphere() {
    let ring = Ring {
        center: [0.0; 2],
        inner: 0.5,
        outer: 1.0,
        angles: Some([-60.0, 60.0]),
        cells: [8, 2],
        ratio: 1.0,
        grade: 1.0,
        cell: CellKind::Quad8,
        diagonals: Diagonals::Forward,
    };
    let extrude = Extrude {
        mesh: ring.build().unwrap(),
        path: Path::Turn {
            point: [0.0; 3],
            axis: [0.0, 1.0, 0.0],
            angle: 90.0,
        },
        offset: 0.0,
        layers: 6,
    };
    let mesh = extrude.build().unwrap();
    assert_eq!(mesh.blocks()[0].kind, CellKind::Hex20);
    for (side, radius) in [("outer", 1.0), ("inner", 0.5)] {
        let nodes = mesh.side_nodes(side).unwrap();
        let off = nodes
            .iter()
            .map(|&n| (norm(mesh.points()[n as usize]) - radius).abs());
        assert!(off.fold(0.0, f64::max) < 1e-15);
    }
    let exact = PI / 3.0 * 60f64.to_radians().sin() * (1.0 - 0.125);
    assert!((volume(&mesh) / exact - 1.0).abs() < 1e-4);
}

#[test]
fn wrong_solids_are_errors_that_name_the_key() {
    let said = |mesh: Result<Mesh<3>, MeshError>, text: &str| {
        let message = mesh.unwrap_err().to_string();
        assert!(message.contains(text), "{message}");
    };
    let good = cylinder(CellKind::Hex8, 0.0, None, [8, 1, 1]);
    let odd = Cylinder {
        cells: [9, 1, 1],
        ..good.clone()
    };
    said(odd.build(), "cylinder: cells = [9, 1]: around a full turn");
    let none = Cylinder {
        cells: [8, 0, 1],
        ..good.clone()
    };
    said(none.build(), "at least one cell");
    said(
        Cylinder {
            axis: [0.0; 3],
            ..good.clone()
        }
        .build(),
        "cylinder: axis",
    );
    said(
        Cylinder {
            inner: 2.0,
            ..good.clone()
        }
        .build(),
        "less than `radius`",
    );
    said(
        Cylinder {
            height: -1.0,
            ..good.clone()
        }
        .build(),
        "cylinder: height = -1",
    );
    said(
        Cylinder {
            angles: Some([10.0, 10.0]),
            ..good.clone()
        }
        .build(),
        "(0, 360]",
    );
    said(
        Cylinder {
            cell: CellKind::Prism6,
            ..good.clone()
        }
        .build(),
        "`extrude` of triangles",
    );
    said(
        Cylinder {
            cells: [4000; 3],
            ..good
        }
        .build(),
        "fewer cells",
    );
    let good = sphere(CellKind::Hex8, 0.0, [0.0, 180.0], [8, 1]);
    said(
        Sphere {
            cells: [6, 1],
            ..good.clone()
        }
        .build(),
        "a multiple of 4",
    );
    said(
        Sphere {
            angles: [10.0, 90.0],
            ..good.clone()
        }
        .build(),
        "must reach a pole",
    );
    said(
        Sphere {
            angles: [90.0, 10.0],
            ..good.clone()
        }
        .build(),
        "0 <= from < to <= 180",
    );
    said(
        Sphere {
            radius: f64::NAN,
            ..good.clone()
        }
        .build(),
        "sphere: radius = NaN",
    );
    said(
        Sphere {
            cell: CellKind::Quad4,
            ..good
        }
        .build(),
        "sphere: cell = quad4",
    );
    let turn = |point: Point<3>, axis: Point<3>, angle: f64, layers: usize| {
        let mesh = plane(CellKind::Quad4, [2, 2]);
        let path = Path::Turn { point, axis, angle };
        Extrude {
            mesh,
            path,
            offset: 0.0,
            layers,
        }
        .build()
    };
    let y = [0.0, 1.0, 0.0];
    said(turn([1.5, 0.0, 0.0], y, 90.0, 2), "on one side of the axis");
    said(
        turn([1.0, 0.0, 0.0], [1.0, -1.0, 0.0], 90.0, 2),
        "have a whole edge on it",
    );
    said(
        turn([0.0; 3], [0.0, 0.0, 1.0], 90.0, 2),
        "in the plane of the mesh",
    );
    said(turn([0.0, 0.0, 1.0], y, 90.0, 2), "extrude: point");
    said(turn([0.0; 3], y, 400.0, 2), "(0, 360]");
    said(turn([0.0; 3], y, 360.0, 2), "spans 180 degrees");
    said(turn([0.0; 3], y, 90.0, 0), "at least one layer");
    let mesh = plane(CellKind::Tri3, [1, 1]).with_side("first", |x| x[0] == 1.0);
    let path = Path::Straight(1.0);
    said(
        Extrude {
            mesh,
            path,
            offset: 0.0,
            layers: 1,
        }
        .build(),
        "`first` exists already",
    );
    let mesh = plane(CellKind::Tri3, [1, 1]);
    let path = Path::Straight(0.0);
    said(
        Extrude {
            mesh,
            path,
            offset: 0.0,
            layers: 1,
        }
        .build(),
        "extrude: height = 0",
    );
}
