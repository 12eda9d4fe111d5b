//! Bodies meshed anew with a size field: sizes are kept and grow gradually, and geometry, sides, groups, supports and loads are those
//! of before.

use crate::outline::{area, smallest_angle};
use dotyk::case::Case;
use dotyk::geometry::{Point, distance};
use dotyk::mesh::{
    CellKind, Contour, Cuboid, Cylinder, Diagonals, Division, Drawing, Mesh, Outline, OutlineEdge,
    Rectangle, Ring, SizeField, SizePoint, Sphere, TunnelRock,
};
use dotyk::model::{BodyId, Elastic, Model};
use proptest::prelude::*;
use std::collections::BTreeMap;
use std::f64::consts::PI;

const STEEL: Elastic = Elastic {
    young: 1000.0,
    poisson: 0.3,
};

/// Longest edge of a cell over the size wanted in its middle, at most.
const LONGEST: f64 = 1.5;

fn point<const D: usize>(at: Point<D>, size: f64) -> SizePoint<D> {
    let radius = 0.0;
    SizePoint { at, size, radius }
}

fn field<const D: usize>(points: Vec<SizePoint<D>>) -> SizeField<D> {
    SizeField::new(points, 0.3).unwrap()
}

/// Longest edge and middle of every cell.
fn cells<const D: usize>(mesh: &Mesh<D>) -> impl Iterator<Item = (f64, Point<D>)> + '_ {
    let blocks = mesh.blocks().iter().enumerate();
    blocks.flat_map(move |(index, block)| {
        let corners = block.kind.corners();
        block.cells().enumerate().map(move |(cell, nodes)| {
            let at = |d: usize| {
                let nodes = nodes[..corners].iter();
                nodes
                    .map(|&node| mesh.points()[node as usize][d])
                    .sum::<f64>()
                    / corners as f64
            };
            (mesh.longest_edge(index, cell), std::array::from_fn(at))
        })
    })
}

/// The largest longest edge over the wanted size in the middle.
fn longest<const D: usize>(mesh: &Mesh<D>, wanted: impl Fn(Point<D>) -> f64) -> f64 {
    let all = cells(mesh).map(|(edge, middle)| edge / wanted(middle));
    all.fold(0.0, f64::max)
}

/// The largest ratio of the longest edges of two neighbours.
fn steepest(mesh: &Mesh<2>) -> f64 {
    let longest: Vec<f64> = cells(mesh).map(|(edge, _)| edge).collect();
    let all = mesh.blocks().iter().flat_map(|block| block.cells());
    let mut before: BTreeMap<[u32; 2], f64> = BTreeMap::new();
    let mut steepest: f64 = 1.0;
    for (nodes, longest) in all.zip(longest) {
        for k in 0..3 {
            let (a, b) = (nodes[k], nodes[(k + 1) % 3]);
            if let Some(other) = before.insert([a.min(b), a.max(b)], longest) {
                steepest = steepest.max(longest / other).max(other / longest);
            }
        }
    }
    steepest
}

fn length(mesh: &Mesh<2>, side: &str) -> f64 {
    let facets = mesh.side(side).unwrap().iter();
    facets.map(|&facet| mesh.facet_length(facet)).sum()
}

fn l_shape() -> Outline {
    let corners = [
        [0.0, 0.0],
        [2.0, 0.0],
        [2.0, 1.0],
        [1.0, 1.0],
        [1.0, 2.0],
        [0.0, 2.0],
    ];
    Outline::new(Contour::polygon(&corners), 0.4)
}

#[test]
fn an_l_shape_is_fine_at_its_corner_and_coarse_elsewhere() {
    let mesh = l_shape().build().unwrap();
    for size in [0.1, 0.01, 1e-3, 1e-5] {
        let wanted = field(vec![point([1.0, 1.0], size)]);
        let anew = mesh.recipe().mesh(&wanted, &[]).unwrap();
        assert!(longest(&anew, |x| wanted.at(x).min(0.4)) < LONGEST);
        assert!(steepest(&anew) < 3.0);
        assert!((area(&anew) - 3.0).abs() < 1e-12 * 3.0);
        assert!((length(&anew, "outline") - 8.0).abs() < 1e-12);
        assert!(smallest_angle(&anew) > 20.0);
        // each halving of the size at one point adds the same number of cells
        let rings = (0.4 / size).log2();
        assert!(
            (anew.cell_count() as f64) < 120.0 + 150.0 * rings,
            "{}",
            anew.cell_count()
        );
        // and what is made anew can be made anew: the recipe is still the one of the user
        let again = anew.recipe().mesh(&field(vec![]), &[]).unwrap();
        assert_eq!(again, mesh);
    }
}

#[test]
fn sizes_of_the_cells_of_the_last_mesh_make_the_next_one() {
    let mut mesh = l_shape().build().unwrap();
    for _ in 0..6 {
        let sizes =
            cells(&mesh).map(
                |(edge, middle)| match distance(middle, [1.0, 1.0]) < 2.0 * edge {
                    true => 0.5 * edge,
                    false => f64::INFINITY,
                },
            );
        let wanted = SizeField::of_cells(&mesh, &sizes.collect::<Vec<_>>(), 0.3).unwrap();
        mesh = mesh.recipe().mesh(&wanted, &[]).unwrap();
        assert!(longest(&mesh, |x| wanted.at(x).min(0.4)) < LONGEST);
    }
    let least = cells(&mesh).map(|(edge, _)| edge).fold(1.0, f64::min);
    assert!(
        least < 0.02 && mesh.cell_count() < 1000,
        "{least} {}",
        mesh.cell_count()
    );
}

#[test]
fn a_number_of_cells_of_an_edge_is_a_largest_length_of_its_pieces() {
    let circle = Contour::Circle {
        center: [0.0, 0.0],
        radius: 1.0,
        names: vec!["rim".to_string()],
        division: Some(Division::Cells(24)),
    };
    let disc = Outline::new(circle, 1.0).build().unwrap();
    assert_eq!(disc.side("rim").unwrap().len(), 24);
    let wanted = field(vec![point([1.0, 0.0], 0.01)]);
    let anew = disc.recipe().mesh(&wanted, &[]).unwrap();
    assert!(longest(&anew, |x| wanted.at(x)) < LONGEST);
    let pieces = anew
        .side("rim")
        .unwrap()
        .iter()
        .map(|&facet| anew.facet_length(facet));
    assert!(pieces.fold(0.0, f64::max) < 2.0 * PI / 24.0);
}

/// A star of corners about the origin.
fn stars() -> impl Strategy<Value = Vec<Point<2>>> {
    prop::collection::vec((-0.25..0.25f64, 0.4..1.0f64), 3..11).prop_map(|corners| {
        let count = corners.len() as f64;
        let corners = corners.iter().enumerate();
        let corners = corners.map(|(k, (turn, far))| {
            let angle = 2.0 * PI * (k as f64 + turn) / count;
            [far * angle.cos(), far * angle.sin()]
        });
        corners.collect()
    })
}

/// A point, the logarithm of its size over the finest one, its radius.
fn wishes() -> impl Strategy<Value = Vec<(Point<2>, f64, f64)>> {
    let place = [-1.0..1.0f64, -1.0..1.0f64];
    prop::collection::vec((place, 0.0..1.0f64, 0.0..0.1f64), 1..10)
}

proptest! {
    #![proptest_config(ProptestConfig {
        cases: 2000,
        rng_seed: proptest::test_runner::RngSeed::Fixed(1980),
        ..ProptestConfig::default()
    })]

    #[test]
    fn random_outlines_keep_their_area_and_the_sizes_of_random_fields(
        corners in stars(),
        points in wishes(),
        at_corner in prop::bool::ANY,
        size in 0.05..0.5f64,
        finest in -2.3..-1.0f64,
        growth in 0.1..0.5f64,
    ) {
        let outline = Outline::new(Contour::polygon(&corners), size);
        let mesh = outline.build().unwrap();
        let points = points.into_iter().enumerate();
        let points: Vec<_> = points.map(|(k, (at, share, radius))| SizePoint {
            at: if at_corner { corners[k % corners.len()] } else { at },
            size: 10.0_f64.powf(finest + share),
            radius,
        }).collect();
        let wanted = SizeField::new(points.clone(), growth).unwrap();
        let anew = mesh.recipe().mesh(&wanted, &[]).unwrap();
        let here = |x: Point<2>| wanted.at(x).min(size);
        let longest = longest(&anew, here);
        prop_assert!(longest < LONGEST, "{}", longest);
        prop_assert!((area(&anew) - area(&mesh)).abs() < 1e-12);
        let perimeter = length(&mesh, "outline");
        prop_assert!((length(&anew, "outline") - perimeter).abs() < 1e-12 * perimeter);
        // The outline lets sizes grow by 0.3.
        let graded = SizeField::new(points, growth.min(0.3)).unwrap();
        let triangles = cells(&anew).zip(anew.blocks()[0].cells()).map(|((_, middle), nodes)| {
            let [a, b, c] = [0, 1, 2].map(|k| anew.points()[nodes[k] as usize]);
            let twice = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
            0.5 * twice / (3.0_f64.sqrt() / 4.0 * graded.at(middle).min(size).powi(2))
        });
        // near walls and corners the outline has more of its own
        let wanted = triangles.sum::<f64>() + mesh.cell_count() as f64;
        let count = anew.cell_count() as f64;
        prop_assert!(count < 2.5 * wanted, "{} cells, {} wanted", count, wanted);
    }
}

fn rectangle(cell: CellKind) -> Rectangle {
    Rectangle {
        from: [-1.0, 0.0],
        to: [3.0, 1.0],
        cells: [16, 4],
        cell,
        diagonals: Diagonals::default(),
    }
}

fn ring(angles: Option<[f64; 2]>) -> Ring {
    Ring {
        center: [0.3, -0.2],
        inner: 1.0,
        outer: 1.5,
        angles,
        cells: [36, 4],
        ratio: 1.2,
        grade: 1.0,
        cell: CellKind::Quad8,
        diagonals: Diagonals::default(),
    }
}

#[test]
fn a_lattice_of_the_plane_becomes_the_outline_of_its_sides() {
    let rock = TunnelRock {
        radius: 1.0,
        half_width: 6.0,
        half_height: 5.0,
        cells: [24, 12],
        ratio: 1.15,
        grade: 1.0,
        cell: CellKind::Quad4,
        diagonals: Diagonals::default(),
    };
    let lattices = [
        rectangle(CellKind::Quad4).build(),
        rectangle(CellKind::Tri6).build(),
        ring(None).build(),
        ring(Some([-90.0, 90.0])).build(),
        ring(Some([10.0, 300.0])).build(),
        rock.build(),
    ];
    for lattice in lattices {
        let lattice = lattice.unwrap();
        let nodes = lattice.points().len() as f64;
        let same = lattice.recipe().mesh(&SizeField::default(), &[]).unwrap();
        let share = same.points().len() as f64 / nodes;
        assert!((0.6..2.0).contains(&share), "{share}");
        let fine = lattice.points()[0];
        let wanted = field(vec![point(fine, 0.01)]);
        let anew = lattice.recipe().mesh(&wanted, &[]).unwrap();
        assert!(longest(&anew, |x| wanted.at(x)) < LONGEST);
        assert!(anew.side_names().eq(lattice.side_names()));
        for mesh in [&same, &anew] {
            // polygons and parabolas instead of arcs
            assert!((area(mesh) / lattice_area(&lattice) - 1.0).abs() < 2e-2);
            for side in lattice.side_names() {
                let share = length(mesh, side) / length(&lattice, side);
                assert!((share - 1.0).abs() < 5e-3, "{side} {share}");
                let curve = lattice.curve(lattice.side(side).unwrap()[0]);
                for &facet in mesh.side(side).unwrap() {
                    assert_eq!(mesh.curve(facet).is_some(), curve.is_some());
                    for (x, circle) in mesh.facet_points(facet).zip(std::iter::repeat(curve)) {
                        assert!(circle.is_none_or(|circle| circle.distance(x).abs() < 1e-12));
                    }
                }
            }
        }
    }
}

/// Area of a mesh of the plane by the divergence theorem.
fn lattice_area(mesh: &Mesh<2>) -> f64 {
    let facets = mesh.boundary_facets().into_iter();
    let parts = facets.map(|facet| {
        let ends: Vec<_> = mesh.facet_points(facet).take(2).collect();
        0.5 * (ends[0][0] * ends[1][1] - ends[0][1] * ends[1][0])
    });
    parts.sum()
}

#[test]
fn solids_are_divided_as_a_whole() {
    let corner = |mesh: &Mesh<3>| field(vec![point(mesh.points()[0], 0.15)]);
    let block = Cuboid {
        from: [0.0; 3],
        to: [1.0, 2.0, 1.0],
        cells: [2, 4, 2],
        cell: CellKind::Hex8,
    };
    let tube = Cylinder {
        base: [0.0; 3],
        axis: [0.0, 0.0, 1.0],
        radius: 1.0,
        inner: 0.5,
        height: 1.0,
        angles: None,
        cells: [12, 1, 2],
        cell: CellKind::Hex20,
    };
    let ball = Sphere {
        center: [0.0; 3],
        radius: 1.0,
        inner: 0.0,
        angles: [0.0, 180.0],
        cells: [8, 1],
        cell: CellKind::Tet4,
    };
    for mesh in [block.build(), tube.build(), ball.build()] {
        let mesh = mesh.unwrap();
        let wanted = corner(&mesh);
        let anew = mesh.recipe().mesh(&wanted, &[]).unwrap();
        assert!(longest(&anew, |x| wanted.at(x)) <= 1.0 + 1e-9);
        assert!(anew.cell_count() > mesh.cell_count());
        assert!(anew.side_names().eq(mesh.side_names()));
        // what is fine enough stays
        let same = mesh.recipe().mesh(&SizeField::default(), &[]).unwrap();
        assert_eq!(same, mesh);
    }
}

#[test]
fn patches_keep_their_ends_and_points_of_supports_become_nodes() {
    let mut plate = rectangle(CellKind::Quad8).build().unwrap();
    plate = plate
        .with_patch("pad", "top", [0.4, 0.9], [1.6, 1.1])
        .unwrap();
    plate = plate.with_side("all", |_| true);
    let both = plate.join_sides(&["left", "right"]).unwrap();
    let mut model = Model::new();
    let body = model.body("plate", plate.clone(), STEEL);
    let foot = [0.37, 0.0];
    model.pin(body, foot, [Some(0.0), Some(0.0)]);
    model.press(body, "pad", 1.0);
    model.press(body, &both, 1.0);
    for size in [0.07, 0.013] {
        let wanted = field(vec![point([0.5, 1.0], size)]);
        let anew = model.meshed_anew(&[(body, wanted)]).unwrap();
        let mesh = &anew.bodies[0].mesh;
        assert!((length(mesh, "pad") - length(&plate, "pad")).abs() < 1e-12);
        assert!((length(mesh, &both) - 2.0).abs() < 1e-12);
        assert_eq!(mesh.side("all").unwrap(), mesh.boundary_facets());
        let node = mesh.points()[mesh.nearest_node(foot)];
        assert!(distance(node, foot) < 1e-12);
        // and once more from there
        let again = anew.meshed_anew(&[(body, field(vec![]))]);
        assert!(
            (length(&again.unwrap().bodies[0].mesh, "pad") - length(&plate, "pad")).abs() < 1e-12
        );
    }
}

/// A lined tunnel in rock: the lining has two regions, and a line ends at it.
fn lined_tunnel() -> Drawing {
    let corners = [[-6.0, -6.0], [6.0, -6.0], [6.0, 6.0], [-6.0, 6.0]];
    let lines = vec![
        Contour::polygon(&corners),
        Contour::circle([0.0, 0.0], 2.0),
        Contour::circle([0.0, 0.0], 1.8),
        Contour::Path {
            from: [-6.0, 0.0],
            edges: vec![OutlineEdge::line([6.0, 0.0])],
        },
    ];
    Drawing::new(lines, 1.0)
        .region("upper", [0.0, 4.0])
        .region("lower", [0.0, -4.0])
        .region("crown", [0.0, 1.9])
        .region("invert", [0.0, -1.9])
}

#[test]
fn bodies_of_a_drawing_keep_their_common_nodes() {
    let regions = lined_tunnel().build().unwrap();
    let mut model = Model::new();
    let lining = regions.mesh(&["crown", "invert"]).unwrap();
    let lining = lining
        .with_patch("key", "upper", [-1.0, 1.0], [1.0, 3.0])
        .unwrap();
    let lining = model.body("lining", lining, STEEL);
    for name in ["upper", "lower"] {
        model.body(name, regions.mesh(&[name]).unwrap(), STEEL);
    }
    let wanted = field(vec![point([2.0, 0.0], 0.02)]);
    let anew = model.meshed_anew(&[(lining, wanted.clone())]).unwrap();
    let nodes = |body: usize, side: &str| {
        let mesh = &anew.bodies[body].mesh;
        let nodes = mesh.side_nodes(side).unwrap().into_iter();
        let mut nodes: Vec<_> = nodes
            .map(|node| mesh.points()[node as usize].map(f64::to_bits))
            .collect();
        nodes.sort_unstable();
        nodes
    };
    for (body, name, part) in [(1, "upper", "crown"), (2, "lower", "invert")] {
        assert_eq!(nodes(0, name), nodes(body, part));
        assert!(nodes(0, name).len() > 20);
    }
    for body in &anew.bodies {
        let mesh = &body.mesh;
        assert!(longest(mesh, |x| wanted.at(x).min(1.0)) < LONGEST);
        assert!(steepest(mesh) < 3.0);
        assert_eq!(mesh.groups(), body_groups(&model, &body.name));
    }
    // the ring lies between polygons of its nodes
    let ring = PI * (4.0 - 1.8 * 1.8);
    assert!((area(&anew.bodies[0].mesh) / ring - 1.0).abs() < 2e-2);
}

fn body_groups<'m>(model: &'m Model<2>, name: &str) -> Vec<&'m str> {
    let mut bodies = model.bodies.iter();
    bodies.find(|body| body.name == name).unwrap().mesh.groups()
}

#[test]
fn what_cannot_be_made_anew_is_told_with_its_body() {
    let made = rectangle(CellKind::Quad4).build().unwrap();
    let moved = made.clone().map_points(|[x, y]| [x, 2.0 * y]).unwrap();
    let picked = made.clone().with_side("low", |[_, y]| y < 0.5);
    for (mesh, said) in [
        (
            moved,
            [
                "body \"plate\": its cells come from a file",
                "cannot be made anew",
            ],
        ),
        (
            picked,
            ["body \"plate\": the facets of side `low`", "with a box"],
        ),
    ] {
        let mut model = Model::new();
        let body = model.body("plate", mesh, STEEL);
        let wanted = field(vec![point([0.0, 0.0], 0.1)]);
        let error = model
            .meshed_anew(&[(body, wanted)])
            .unwrap_err()
            .to_string();
        assert!(said.iter().all(|said| error.contains(said)), "{error}");
        // the others are as they were
        assert_eq!(
            model.meshed_anew(&[]).unwrap().bodies[0].mesh,
            model.bodies[0].mesh
        );
    }
}

/// The problem of the case, on a coarse mesh, and made anew with finer and finer cells at the corners of sole and foot.
#[test]
fn the_energy_of_the_floating_punch_converges_with_cells_made_anew() {
    let text = |cell: &str, n: usize| {
        format!(
            "analysis = \"plane-strain\"
[[body]]
name = \"block\"
mesh = {{ rectangle = {{ from = [0, 0], to = [4, 1], cells = [{}, {}], cell = \"{cell}\" }} }}
material = {{ young = 210e9, poisson = 0.3 }}
fix = [{{ side = \"bottom\", x = 0, y = 0 }}]
[[body]]
name = \"punch\"
mesh = {{ rectangle = {{ from = [1.5, 1], to = [2.5, 2], cells = [{n}, {n}], cell = \"{cell}\" }} }}
material = {{ young = 210e9, poisson = 0.3 }}
fix = [{{ side = [\"left\", \"right\"], x = 0 }}]
load = [{{ side = \"top\", traction = [0, -1e6] }}]
[[contact]]
name = \"sole\"
nonmortar = \"punch.bottom\"
mortar = \"block.top\"
",
            4 * n,
            n
        )
    };
    let energy = |model: &Model<2>| {
        let solution = model.solve().unwrap();
        assert!(solution.converged);
        let [x, y] = solution.contacts[0].resultant;
        assert!(x.abs() < 1e-3 && (y.abs() - 1e6).abs() < 1e-2, "{x} {y}");
        solution
            .bodies
            .iter()
            .map(|body| body.strain_energy)
            .sum::<f64>()
    };
    let read = |text: &str| {
        Case::<2>::from_str(text, "punch.toml", "".as_ref())
            .unwrap()
            .model
    };
    // The elastic energy under given loads grows with each refinement; cells that are fine at the corners alone find more of it than
    // 32 000 nodes of a uniform mesh.
    let uniform = energy(&read(&text("quad9", 40)));
    let model = read(&text("quad8", 5));
    let mut before = 1.0 - energy(&model) / uniform;
    assert!((2e-3..1e-2).contains(&before), "{before}");
    for (size, most, nodes) in [(0.05, 2e-3, 1500), (0.02, 5e-4, 2000), (0.005, 0.0, 3000)] {
        let corners = [[1.5, 1.0], [2.5, 1.0]].map(|at| point(at, size));
        let feet = [[0.0, 0.0], [4.0, 0.0]].map(|at| point(at, 4.0 * size));
        let wanted = field([corners, feet].concat());
        let bodies = [0, 1].map(|body| (BodyId(body), wanted.clone()));
        let anew = model.meshed_anew(&bodies).unwrap();
        let all: usize = anew
            .bodies
            .iter()
            .map(|body| body.mesh.points().len())
            .sum();
        let below = 1.0 - energy(&anew) / uniform;
        assert!(below < before && below < most && below > -5e-4, "{below}");
        assert!(all < nodes, "{all}");
        before = below;
    }
}
