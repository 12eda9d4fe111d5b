//! Facts about meshes and generators.

use crate::mesh::*;
use proptest::prelude::*;
use std::collections::BTreeSet;
use std::f64::consts::PI;

const DIAGONALS: [Diagonals; 4] = [
    Diagonals::Checkerboard,
    Diagonals::CheckerboardOdd,
    Diagonals::Forward,
    Diagonals::Backward,
];

fn block(kind: CellKind, nodes: &[u32]) -> CellBlock {
    CellBlock {
        kind,
        nodes: nodes.to_vec(),
        group: None,
    }
}

fn rectangle(cell: CellKind, cells: [usize; 2]) -> Rectangle {
    Rectangle {
        from: [-1.0, 0.5],
        to: [2.0, 1.2],
        cells,
        cell,
        diagonals: Diagonals::default(),
    }
}

fn ring(cell: CellKind, cells: [usize; 2], angles: Option<[f64; 2]>) -> Ring {
    Ring {
        center: [0.0, 0.0],
        inner: 12.0,
        outer: 15.0,
        angles,
        cells,
        ratio: 1.0,
        grade: 1.0,
        cell,
        diagonals: Diagonals::default(),
    }
}

fn rock(cell: CellKind, cells: [usize; 2]) -> TunnelRock {
    TunnelRock {
        radius: 15.0,
        half_width: 40.0,
        half_height: 40.0,
        cells,
        ratio: 1.1,
        grade: 1.0,
        cell,
        diagonals: Diagonals::default(),
    }
}

/// ∮x dy along the facets, by Simpson's rule: exact, since x and dy/dξ are at most quadratic and linear.
fn area_inside(mesh: &Mesh<2>, facets: &[Facet]) -> f64 {
    let simpson = [(-1.0, 1.0 / 3.0), (0.0, 4.0 / 3.0), (1.0, 1.0 / 3.0)];
    facets
        .iter()
        .flat_map(|&facet| simpson.map(|(xi, weight)| (facet, xi, weight)))
        .map(|(facet, xi, weight)| {
            weight * mesh.facet_point(facet, &[xi])[0] * mesh.outward_normal(facet, &[xi])[0]
        })
        .sum()
}

fn area(mesh: &Mesh<2>) -> f64 {
    area_inside(mesh, &mesh.boundary_facets())
}

/// The same area as the sum over the cells.
fn area_of_cells(mesh: &Mesh<2>) -> f64 {
    let mut sum = 0.0;
    for block in 0..mesh.blocks().len() {
        let kind = mesh.blocks()[block].kind;
        for cell in 0..mesh.blocks()[block].cells().len() {
            let facets: Vec<Facet> = (0..kind.facets().len())
                .map(|local| Facet {
                    block: block as u32,
                    cell: cell as u32,
                    local: local as u32,
                })
                .collect();
            sum += area_inside(mesh, &facets);
        }
    }
    sum
}

fn length(mesh: &Mesh<2>, side: &str) -> f64 {
    let facets = mesh.side(side).unwrap();
    facets.iter().map(|&f| mesh.facet_length(f)).sum()
}

/// Every boundary facet belongs to exactly one side, and the sides hold no others.
fn assert_closed(mesh: &Mesh<2>) {
    let mut all: Vec<Facet> = mesh.sides().values().flatten().copied().collect();
    all.sort_unstable();
    assert_eq!(all, mesh.boundary_facets());
    assert_eq!(mesh.component_count(), 1);
}

fn close(a: f64, b: f64, tolerance: f64) {
    assert!((a - b).abs() <= tolerance * b.abs(), "{a} is not {b}");
}

// ---------------------------------------------------------------- Mesh::new

#[test]
fn a_cell_numbered_the_other_way_round_is_turned() {
    for kind in CellKind::of_dimension(2) {
        let points: Vec<Point<2>> = kind
            .reference_nodes()
            .iter()
            .map(|x| [2.0 * x[0] + 0.1 * x[1] * x[1], x[1]])
            .collect();
        let right: Vec<u32> = (0..kind.nodes() as u32).collect();
        let wrong: Vec<u32> = kind.mirror().iter().map(|&i| i as u32).collect();
        let turned = Mesh::new(points, vec![block(kind, &wrong)]).unwrap();
        assert_eq!(turned.cell_nodes(0, 0), right, "{kind:?}");
        assert!(area(&turned) > 0.0);
    }
}

#[test]
fn a_folded_cell_is_rejected_with_its_index() {
    // The third cell is an arrow head: its corner 2 is pushed beyond the diagonal.
    let mut points = Vec::new();
    let mut nodes = Vec::new();
    for cell in 0..4_u32 {
        let x = f64::from(2 * cell);
        let tip = if cell == 2 { 0.4 } else { 1.0 };
        points.extend([[x, 0.0], [x + 1.0, 0.0], [x + tip, tip], [x, 1.0]]);
        nodes.extend(4 * cell..4 * cell + 4);
    }
    match Mesh::new(points, vec![block(CellKind::Quad4, &nodes)]) {
        Err(MeshError::Folded {
            block: 0,
            cell: 2,
            near,
            low,
            high,
        }) => {
            assert_eq!(near, [4.35, 0.35, 0.0]);
            assert!(low < 0.0 && high > 0.0);
        }
        other => panic!("{other:?}"),
    }
}

#[test]
fn a_quadratic_cell_folded_by_a_middle_node_alone_is_rejected() {
    for kind in [CellKind::Tri6, CellKind::Quad8, CellKind::Quad9] {
        let mut points: Vec<Point<2>> = kind
            .reference_nodes()
            .iter()
            .map(|x| [x[0], x[1]])
            .collect();
        let nodes: Vec<u32> = (0..kind.nodes() as u32).collect();
        // Beyond a quarter of the edge from corner 0 the map along the edge turns back.
        let [a, b] = [points[0], points[1]];
        let middle = kind.corners();
        points[middle] = [a[0] + 0.2 * (b[0] - a[0]), a[1]];
        let folded = Mesh::new(points.clone(), vec![block(kind, &nodes)]);
        assert!(
            matches!(folded, Err(MeshError::Folded { .. })),
            "{kind:?} {folded:?}"
        );
        points[middle] = [a[0] + 0.3 * (b[0] - a[0]), a[1]];
        assert!(
            Mesh::new(points, vec![block(kind, &nodes)]).is_ok(),
            "{kind:?}"
        );
    }
}

#[test]
fn a_straight_corner_is_legal_and_has_quality_zero() {
    let points = vec![[0.0, 0.0], [1.0, 0.0], [0.5, 0.5], [0.0, 1.0]];
    let mesh = Mesh::new(points, vec![block(CellKind::Quad4, &[0, 1, 2, 3])]).unwrap();
    assert_eq!(mesh.cell_quality(0, 0), 0.0);
    close(area(&mesh), 0.5, 1e-15);
}

#[test]
fn a_cell_without_volume_is_rejected_wherever_it_lies() {
    for shift in [0.0, 1e6] {
        let at = |t: f64| [shift + 0.1 * t, shift + 0.3 * t];
        let points = vec![at(0.0), at(1.0), at(3.0)];
        let flat = Mesh::new(points, vec![block(CellKind::Tri3, &[0, 1, 2])]);
        assert!(
            matches!(
                flat,
                Err(MeshError::ZeroVolume {
                    block: 0,
                    cell: 0,
                    ..
                })
            ),
            "{flat:?}"
        );
    }
}

#[test]
fn a_thin_cell_far_from_the_origin_is_legal() {
    let (x, y) = (5e5, 4e6);
    let points = vec![[x, y], [x + 1.0, y], [x + 1.0, y + 1e-5], [x, y + 1e-5]];
    assert!(Mesh::new(points, vec![block(CellKind::Quad4, &[0, 1, 2, 3])]).is_ok());
}

#[test]
fn wrong_indices_and_coordinates_are_named() {
    let square = vec![[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
    let new = |points: &[Point<2>], nodes: &[u32]| {
        Mesh::new(points.to_vec(), vec![block(CellKind::Tri3, nodes)])
    };
    assert_eq!(
        new(&square, &[0, 1, 2, 0, 2, 7]),
        Err(MeshError::NodeOutOfRange {
            block: 0,
            cell: 1,
            node: 7,
            points: 4
        })
    );
    assert_eq!(
        new(&square, &[0, 1, 2, 0, 2, 2]),
        Err(MeshError::RepeatedNode {
            block: 0,
            cell: 1,
            node: 2
        })
    );
    assert_eq!(
        new(&square, &[0, 1, 2]),
        Err(MeshError::LooseNode {
            node: 3,
            point: [0.0, 1.0, 0.0]
        })
    );
    assert!(matches!(
        new(&square, &[0, 1, 2, 3]),
        Err(MeshError::RaggedBlock { length: 4, .. })
    ));
    assert_eq!(new(&square, &[]), Err(MeshError::Empty));
    assert_eq!(Mesh::<2>::new(vec![], vec![]), Err(MeshError::Empty));
    let mut broken = square.clone();
    broken[1][1] = f64::NAN;
    assert!(matches!(
        new(&broken, &[0, 1, 2, 0, 2, 3]),
        Err(MeshError::NotFinite { node: 1, .. })
    ));
    let solid = Mesh::<3>::new(vec![[0.0; 3]; 3], vec![block(CellKind::Tri3, &[0, 1, 2])]);
    assert!(matches!(solid, Err(MeshError::Dimension { .. })));
}

#[test]
fn a_reflection_keeps_sides_on_their_edges() {
    for cell in CellKind::of_dimension(2) {
        let mesh = rectangle(cell, [3, 2]).build().unwrap();
        let before = area(&mesh);
        let mesh = mesh.map_points(|[x, y]| [-x, y]).unwrap();
        assert_closed(&mesh);
        close(area(&mesh), before, 1e-14);
        for node in mesh.side_nodes("left").unwrap() {
            assert_eq!(mesh.points()[node as usize][0], 1.0, "{cell:?}");
        }
        for &facet in mesh.side("left").unwrap() {
            assert!(mesh.outward_normal(facet, &[0.3])[0] > 0.0);
        }
    }
}

#[test]
fn squares_and_equilateral_triangles_have_quality_one() {
    let root = 3.0_f64.sqrt() / 2.0;
    let triangle = Mesh::new(
        vec![[0.0, 0.0], [1.0, 0.0], [0.5, root]],
        vec![block(CellKind::Tri3, &[0, 1, 2])],
    )
    .unwrap();
    close(triangle.cell_quality(0, 0), 1.0, 1e-15);
    for (cell, quality) in [
        (CellKind::Quad4, 1.0),
        (CellKind::Quad8, 1.0),
        (CellKind::Quad9, 1.0),
        // A right isosceles triangle: sin 45° / sin 60°.
        (CellKind::Tri3, (2.0_f64 / 3.0).sqrt()),
        (CellKind::Tri6, (2.0_f64 / 3.0).sqrt()),
    ] {
        let mesh = Rectangle {
            from: [0.0, 0.0],
            to: [4.0, 2.0],
            ..rectangle(cell, [4, 2])
        }
        .build()
        .unwrap();
        for index in 0..mesh.cell_count() {
            close(mesh.cell_quality(0, index), quality, 1e-14);
        }
    }
}

#[test]
fn a_sheared_square_has_the_sine_of_its_angle_as_quality() {
    let mesh = rectangle(CellKind::Quad9, [1, 1]).build().unwrap();
    let angle = PI / 6.0;
    let mesh = mesh
        .map_points(|[x, y]| [x + y * angle.cos(), y * angle.sin()])
        .unwrap();
    close(mesh.cell_quality(0, 0), angle.sin(), 1e-13);
}

// ---------------------------------------------------------------- sides

#[test]
fn a_side_by_predicate_equals_the_generated_one() {
    for cell in CellKind::of_dimension(2) {
        let mesh = rectangle(cell, [4, 3])
            .build()
            .unwrap()
            .with_side("upper", |p| p[1] == 1.2)
            .with_side("nowhere", |p| p[1] > 1.2);
        assert_eq!(mesh.side("upper"), mesh.side("top"));
        assert_eq!(mesh.side("nowhere"), Some(&[][..]));
        assert_eq!(mesh.side("elsewhere"), None);
    }
}

#[test]
fn a_patch_holds_the_whole_facets_in_its_box_and_its_borders() {
    let mesh = Rectangle {
        from: [0.0, 0.0],
        to: [1.0, 1.0],
        ..rectangle(CellKind::Quad8, [10, 1])
    }
    .build()
    .unwrap();
    // The box misses both end nodes by a possible rounding.
    let mesh = mesh
        .with_patch(
            "patch",
            "top",
            [0.3 + 1e-12, 1.0 + 1e-12],
            [0.6 - 1e-12, 1.0 + 1e-12],
        )
        .unwrap();
    let mut xs: Vec<f64> = mesh
        .side_nodes("patch")
        .unwrap()
        .iter()
        .map(|&node| mesh.points()[node as usize][0])
        .collect();
    xs.sort_by(f64::total_cmp);
    assert_eq!(xs.len(), 7);
    close(xs[0], 0.3, 1e-15);
    close(xs[6], 0.6, 1e-15);
    close(length(&mesh, "top"), 1.0, 1e-14);
    assert!(matches!(
        mesh.clone()
            .with_patch("q", "top", [0.31, 1.0], [0.39, 1.0]),
        Err(MeshError::EmptyPatch { .. })
    ));
    assert!(matches!(
        mesh.clone().with_patch("q", "tip", [0.0; 2], [1.0; 2]),
        Err(MeshError::UnknownSide { .. })
    ));
    assert!(matches!(
        mesh.with_patch("left", "top", [0.0; 2], [1.0; 2]),
        Err(MeshError::SideExists { .. })
    ));
}

#[test]
fn a_facet_that_does_not_exist_is_no_side() {
    let mesh = rectangle(CellKind::Tri3, [2, 2]).build().unwrap();
    for (block, cell, local) in [(1, 0, 0), (0, 8, 0), (0, 0, 3)] {
        let facet = Facet { block, cell, local };
        let sides = BTreeMap::from([("s".to_string(), vec![facet])]);
        assert!(matches!(
            mesh.clone().with_sides(sides),
            Err(MeshError::FacetOutOfRange { .. })
        ));
    }
}

#[test]
fn facets_are_found_by_their_corners_in_any_order() {
    let mesh = rectangle(CellKind::Quad8, [2, 2]).build().unwrap();
    let table = mesh.facet_table();
    for &facet in mesh.side("right").unwrap() {
        let nodes: Vec<u32> = mesh.facet_nodes(facet).collect();
        assert_eq!(table.find(&nodes[..2]).collect::<Vec<_>>(), [facet]);
        assert_eq!(table.find(&[nodes[1], nodes[0]]).count(), 1);
        assert_eq!(table.find(&[nodes[0], nodes[2]]).count(), 0);
    }
    let inner = mesh.facet_nodes(Facet {
        block: 0,
        cell: 0,
        local: 1,
    });
    let inner: Vec<u32> = inner.take(2).collect();
    assert_eq!(table.find(&inner).count(), 2);
}

#[test]
fn normals_point_outward_and_are_as_long_as_the_facet() {
    for cell in CellKind::of_dimension(2) {
        let mesh = rectangle(cell, [4, 2]).build().unwrap();
        let sides = [
            ("left", [-1.0, 0.0], 0.7 / 2.0),
            ("right", [1.0, 0.0], 0.7 / 2.0),
            ("bottom", [0.0, -1.0], 3.0 / 4.0),
            ("top", [0.0, 1.0], 3.0 / 4.0),
        ];
        for (side, normal, long) in sides {
            for &facet in mesh.side(side).unwrap() {
                close(mesh.facet_length(facet), long, 1e-14);
                for xi in [-1.0, 0.2, 1.0] {
                    let n = mesh.outward_normal(facet, &[xi]);
                    for d in 0..2 {
                        // dS/dξ is half the length.
                        assert!((n[d] - 0.5 * long * normal[d]).abs() < 1e-15);
                    }
                }
            }
        }
    }
}

#[test]
fn a_chain_runs_along_the_side_with_the_body_on_the_left() {
    for cell in CellKind::of_dimension(2) {
        let mesh = ring(cell, [6, 2], Some([-90.0, 90.0])).build().unwrap();
        let chains = mesh.chain("outer").unwrap();
        assert_eq!(chains.len(), 1);
        let chain = &chains[0];
        assert!(!chain.cyclic);
        assert_eq!(chain.facets.len(), 6);
        assert_eq!(chain.nodes.len(), 6 * cell.order() + 1);
        let ys: Vec<f64> = chain
            .nodes
            .iter()
            .map(|&node| mesh.points()[node as usize][1])
            .collect();
        assert!(ys.windows(2).all(|y| y[0] < y[1]), "{cell:?} {ys:?}");
        let inner = &mesh.chain("inner").unwrap()[0];
        let first = mesh.points()[inner.nodes[0] as usize];
        assert_eq!(first, [0.0, 12.0]);
    }
}

#[test]
fn the_chain_of_a_full_ring_is_cyclic_and_names_each_node_once() {
    for cell in CellKind::of_dimension(2) {
        let mesh = ring(cell, [7, 1], None).build().unwrap();
        for side in ["inner", "outer"] {
            let chains = mesh.chain(side).unwrap();
            assert_eq!(chains.len(), 1);
            assert!(chains[0].cyclic);
            let mut nodes = chains[0].nodes.clone();
            nodes.sort_unstable();
            assert_eq!(nodes, mesh.side_nodes(side).unwrap());
        }
    }
}

#[test]
fn a_side_in_two_pieces_has_two_chains() {
    let mesh = rock(CellKind::Quad8, [8, 2]).build().unwrap();
    let chains = mesh.chain("axis").unwrap();
    assert_eq!(chains.len(), 2);
    for chain in &chains {
        assert!(!chain.cyclic);
        assert_eq!(chain.nodes.len(), 5);
    }
    assert_eq!(mesh.chain("no side"), None);
}

#[test]
fn a_chain_ends_where_the_boundary_touches_itself() {
    // Two squares that share one corner only.
    let points = vec![
        [0.0, 0.0],
        [1.0, 0.0],
        [1.0, 1.0],
        [0.0, 1.0],
        [2.0, 1.0],
        [2.0, 2.0],
        [1.0, 2.0],
    ];
    let cells = block(CellKind::Quad4, &[0, 1, 2, 3, 2, 4, 5, 6]);
    let mesh = Mesh::new(points, vec![cells])
        .unwrap()
        .with_side("all", |_| true);
    let chains = mesh.chain("all").unwrap();
    assert_eq!(chains.len(), 2);
    for chain in &chains {
        assert_eq!(chain.facets.len(), 4);
        assert_eq!((chain.nodes[0], chain.nodes[4]), (2, 2));
    }
    assert_eq!(mesh.facet_components(), [0, 1]);
    assert_eq!(mesh.component_count(), 2);
    // Without one of the two facets that arrive at the corner the leaving one is still ambiguous.
    let mut facets = mesh.side("all").unwrap().to_vec();
    facets.retain(|&facet| mesh.facet_nodes(facet).nth(1) != Some(2) || facet.cell == 0);
    let sides = BTreeMap::from([("most".to_string(), facets)]);
    let chains = mesh.with_sides(sides).unwrap().chain("most").unwrap();
    let mut lengths: Vec<usize> = chains.iter().map(|chain| chain.facets.len()).collect();
    lengths.sort_unstable();
    assert_eq!(lengths, [3, 4]);
    assert!(chains.iter().all(|chain| !chain.cyclic));
}

#[test]
fn parts_are_numbered_in_the_order_of_their_first_cells() {
    // Unit squares at these places; neighbours share an edge through the same nodes.
    let places = [0.0, 10.0, 20.0, 11.0, 21.0, 1.0, 30.0];
    let mut points = Vec::new();
    let mut node = |x: f64, y: f64| {
        let found = points.iter().position(|&p| p == [x, y]);
        found.unwrap_or_else(|| {
            points.push([x, y]);
            points.len() - 1
        }) as u32
    };
    let nodes: Vec<u32> = places
        .iter()
        .flat_map(|&x| {
            [
                node(x, 0.0),
                node(x + 1.0, 0.0),
                node(x + 1.0, 1.0),
                node(x, 1.0),
            ]
        })
        .collect();
    let mesh = Mesh::new(points, vec![block(CellKind::Quad4, &nodes)]).unwrap();
    assert_eq!(mesh.facet_components(), [0, 1, 2, 1, 2, 0, 3]);
    assert_eq!(mesh.component_count(), 4);
}

#[test]
fn components_are_counted_across_blocks() {
    // Triangles 0, 2 and quadrilateral of block 1 hang together, triangle 1 is alone.
    let points = vec![
        [0.0, 0.0],
        [1.0, 0.0],
        [0.0, 1.0],
        [5.0, 0.0],
        [6.0, 0.0],
        [5.0, 1.0],
        [1.0, 1.0],
        [0.0, -1.0],
        [1.0, -1.0],
    ];
    let triangles = block(CellKind::Tri3, &[0, 1, 2, 3, 4, 5, 1, 6, 2]);
    let squares = block(CellKind::Quad4, &[7, 8, 1, 0]);
    let mesh = Mesh::new(points, vec![triangles, squares]).unwrap();
    assert_eq!(mesh.facet_components(), [0, 1, 0, 0]);
    assert_eq!(mesh.boundary_facets().len(), 6 + 3);
}

// ---------------------------------------------------------------- generators

#[test]
fn a_rectangle_has_its_area_its_sides_and_its_counts() {
    for cell in CellKind::of_dimension(2) {
        for diagonals in DIAGONALS {
            let mesh = Rectangle {
                diagonals,
                ..rectangle(cell, [5, 3])
            }
            .build()
            .unwrap();
            assert_closed(&mesh);
            close(area(&mesh), 3.0 * 0.7, 1e-14);
            close(area_of_cells(&mesh), 3.0 * 0.7, 1e-14);
            close(length(&mesh, "left"), 0.7, 1e-14);
            close(length(&mesh, "bottom"), 3.0, 1e-14);
            let nodes = match (cell, cell.order()) {
                (_, 1) => 6 * 4,
                (CellKind::Quad8, _) => 11 * 7 - 15,
                _ => 11 * 7,
            };
            assert_eq!(mesh.points().len(), nodes, "{cell:?}");
            let per_square = if cell.corners() == 3 { 2 } else { 1 };
            assert_eq!(mesh.cell_count(), 15 * per_square);
            for (side, d, value) in [
                ("left", 0, -1.0),
                ("right", 0, 2.0),
                ("bottom", 1, 0.5),
                ("top", 1, 1.2),
            ] {
                for node in mesh.side_nodes(side).unwrap() {
                    assert_eq!(mesh.points()[node as usize][d], value);
                }
            }
        }
    }
}

#[test]
fn diagonals_run_as_they_are_named() {
    // Upper ends of the diagonals of 2 × 1 unit squares: at the right for forward ones.
    for (diagonals, forward) in [
        (Diagonals::Checkerboard, [true, false]),
        (Diagonals::CheckerboardOdd, [false, true]),
        (Diagonals::Forward, [true, true]),
        (Diagonals::Backward, [false, false]),
    ] {
        let mesh = Rectangle {
            diagonals,
            ..rectangle(CellKind::Tri3, [2, 1])
        }
        .build()
        .unwrap();
        let table = mesh.facet_table();
        for i in 0..2 {
            let diagonal = [[i + 1, i + 3], [i, i + 4]][usize::from(forward[i as usize])];
            assert_eq!(table.find(&diagonal).count(), 2, "{diagonals:?} {i}");
        }
    }
}

#[test]
fn a_linear_ring_is_a_ring_of_polygons() {
    for cell in [CellKind::Tri3, CellKind::Quad4] {
        for angles in [None, Some([-90.0, 90.0]), Some([30.0, 100.0])] {
            let around = 9;
            let mesh = ring(cell, [around, 2], angles).build().unwrap();
            assert_closed(&mesh);
            let span = angles.map_or(360.0, |[a, b]| b - a) * PI / 180.0;
            let step = span / around as f64;
            let polygon = 0.5 * around as f64 * step.sin() * (15.0 * 15.0 - 12.0 * 12.0);
            close(area(&mesh), polygon, 1e-13);
            close(area_of_cells(&mesh), polygon, 1e-13);
            let chords = around as f64 * 2.0 * 15.0 * (0.5 * step).sin();
            close(length(&mesh, "outer"), chords, 1e-13);
            assert_eq!(mesh.side("start").is_some(), angles.is_some());
            if angles.is_some() {
                close(length(&mesh, "start"), 3.0, 1e-13);
                close(length(&mesh, "end"), 3.0, 1e-13);
            }
        }
    }
}

#[test]
fn a_quadratic_ring_converges_with_order_four_to_the_true_one() {
    let exact = PI * (15.0 * 15.0 - 12.0 * 12.0);
    for cell in [CellKind::Tri6, CellKind::Quad8, CellKind::Quad9] {
        let error = |around: usize| {
            let mesh = ring(cell, [around, 1], None).build().unwrap();
            assert_closed(&mesh);
            (area(&mesh) - exact).abs() / exact
        };
        assert!(error(24) < 1e-5, "{cell:?} {}", error(24));
        let order = (error(12) / error(24)).log2();
        assert!((order - 4.0).abs() < 0.1, "{cell:?} {order}");
    }
}

#[test]
fn a_full_ring_closes_on_itself() {
    for (cell, nodes) in [
        (CellKind::Quad4, 8 * 3),
        (CellKind::Tri6, 16 * 5),
        (CellKind::Quad8, 16 * 5 - 16),
    ] {
        let mesh = ring(cell, [8, 2], Some([-180.0, 180.0])).build().unwrap();
        assert_eq!(mesh.points().len(), nodes);
        assert_closed(&mesh);
        let names: Vec<&str> = mesh.side_names().collect();
        assert_eq!(names, ["inner", "outer"]);
    }
}

#[test]
fn every_node_of_a_quadratic_ring_lies_on_the_circle_of_its_layer() {
    let mesh = Ring {
        center: [3.0, -2.0],
        ratio: 1.3,
        ..ring(CellKind::Quad9, [5, 2], Some([10.0, 200.0]))
    }
    .build()
    .unwrap();
    let ends = [12.0, 12.0 + 3.0 / 2.3, 15.0];
    let layers = [
        ends[0],
        0.5 * (ends[0] + ends[1]),
        ends[1],
        0.5 * (ends[1] + ends[2]),
        ends[2],
    ];
    for (index, p) in mesh.points().iter().enumerate() {
        let (x, y) = (p[0] - 3.0, p[1] + 2.0);
        close(x.hypot(y), layers[index % 5], 1e-14);
        let angle = y.atan2(x).to_degrees().rem_euclid(360.0);
        close(angle, 10.0 + 19.0 * (index / 5) as f64, 1e-13);
    }
}

#[test]
fn sizes_around_fall_geometrically_from_the_springline() {
    let sizes = |around: usize| -> Vec<f64> {
        let mesh = Ring {
            grade: 0.8,
            ..ring(CellKind::Quad4, [around, 1], Some([-90.0, 90.0]))
        }
        .build()
        .unwrap();
        let angles: Vec<f64> = mesh.chain("outer").unwrap()[0]
            .nodes
            .iter()
            .map(|&node| mesh.points()[node as usize])
            .map(|[x, y]| y.atan2(x))
            .collect();
        angles.windows(2).map(|a| a[1] - a[0]).collect()
    };
    let even = sizes(6);
    let odd = sizes(5);
    for k in 0..2 {
        close(even[3 + k + 1] / even[3 + k], 0.8, 1e-13);
        close(even[2 - k - 1] / even[2 - k], 0.8, 1e-13);
        close(odd[2 + k + 1] / odd[2 + k], 0.8, 1e-13);
        close(odd[2 - k - 1] / odd[2 - k], 0.8, 1e-13);
    }
    close(even[2], even[3], 1e-13);
}

#[test]
fn the_rock_has_its_area_and_exact_straight_sides() {
    let (w, h) = (40.0, 25.0);
    for cell in CellKind::of_dimension(2) {
        for around in [4, 5, 14, 31] {
            let rock = TunnelRock {
                half_width: w,
                half_height: h,
                ..rock(cell, [around, 3])
            };
            let mesh = rock.build().unwrap();
            assert_closed(&mesh);
            let step = PI / around as f64;
            let half_polygon = 0.5 * around as f64 * step.sin() * 15.0 * 15.0;
            let plate = 2.0 * w * h;
            match cell.order() {
                1 => close(area(&mesh), plate - half_polygon, 1e-13),
                // The arc is quadratic: relative error of the hole about (step/2)⁴/30.
                _ => close(
                    area(&mesh),
                    plate - 0.5 * PI * 15.0 * 15.0,
                    0.05 * (0.5 * step).powi(4),
                ),
            }
            close(area_of_cells(&mesh), area(&mesh), 1e-13);
            close(length(&mesh, "right"), 2.0 * h, 1e-13);
            close(length(&mesh, "top"), w, 1e-13);
            close(length(&mesh, "bottom"), w, 1e-13);
            close(length(&mesh, "axis"), 2.0 * (h - 15.0), 1e-13);
            for (side, d, value) in [
                ("right", 0, w),
                ("top", 1, h),
                ("bottom", 1, -h),
                ("axis", 0, 0.0),
            ] {
                for node in mesh.side_nodes(side).unwrap() {
                    assert_eq!(mesh.points()[node as usize][d], value);
                }
            }
            for exact in [
                [0.0, 15.0],
                [0.0, -15.0],
                [0.0, h],
                [0.0, -h],
                [w, h],
                [w, -h],
            ] {
                assert_eq!(mesh.points().iter().filter(|p| **p == exact).count(), 1);
            }
        }
    }
}

#[test]
fn the_ring_and_the_rock_share_their_contact_nodes_to_the_last_bit() {
    for cell in CellKind::of_dimension(2) {
        for around in [14, 15, 30, 38, 304] {
            for grade in [1.0, 0.98] {
                let ring = Ring {
                    grade,
                    ..ring(cell, [around, 2], Some([-90.0, 90.0]))
                }
                .build()
                .unwrap();
                let rock = TunnelRock {
                    grade,
                    ..rock(cell, [around, 3])
                }
                .build()
                .unwrap();
                let nodes = |mesh: &Mesh<2>, side: &str| -> Vec<Point<2>> {
                    let chain = mesh.chain(side).unwrap().remove(0);
                    let nodes = chain.nodes.iter();
                    nodes.map(|&node| mesh.points()[node as usize]).collect()
                };
                let outer = nodes(&ring, "outer");
                let mut hole = nodes(&rock, "hole");
                hole.reverse();
                assert_eq!(outer.len(), around * cell.order() + 1);
                assert_eq!(outer, hole, "{cell:?} {around} {grade}");
                for p in outer {
                    close(p[0].hypot(p[1]), 15.0, 1e-15);
                }
            }
        }
    }
}

/// Every cell of the image in y = 0 is a cell of the mesh.
fn is_its_own_image(mesh: &Mesh<2>) -> bool {
    let name = |p: Point<2>| [p[0].to_bits(), (p[1] + 0.0).to_bits()];
    let cells = |sign: f64| -> Vec<Vec<[u64; 2]>> {
        let mut cells: Vec<Vec<[u64; 2]>> = mesh.blocks()[0]
            .cells()
            .map(|nodes| {
                let at = |&node: &u32| mesh.points()[node as usize];
                let mut cell: Vec<[u64; 2]> = nodes
                    .iter()
                    .map(at)
                    .map(|[x, y]| name([x, sign * y]))
                    .collect();
                cell.sort_unstable();
                cell
            })
            .collect();
        cells.sort_unstable();
        cells
    };
    cells(1.0) == cells(-1.0)
}

#[test]
fn an_even_rock_and_an_even_ring_are_their_own_images_to_the_last_bit() {
    for cell in CellKind::of_dimension(2) {
        for around in [14, 38] {
            let rock = TunnelRock {
                half_width: 53.0,
                grade: 0.97,
                ..rock(cell, [around, 4])
            };
            assert!(is_its_own_image(&rock.build().unwrap()), "{cell:?}");
            let ring = ring(cell, [around, 3], Some([-90.0, 90.0]));
            assert!(is_its_own_image(&ring.build().unwrap()), "{cell:?}");
        }
    }
    // Not every mesh is: the check can fail.
    let rock = TunnelRock {
        diagonals: Diagonals::Forward,
        ..rock(CellKind::Tri3, [14, 4])
    };
    assert!(!is_its_own_image(&rock.build().unwrap()));
}

#[test]
fn directions_of_the_outer_nodes_are_piecewise_linear_between_the_corners() {
    let mesh = TunnelRock {
        half_height: 30.0,
        ..rock(CellKind::Quad4, [12, 1])
    }
    .build()
    .unwrap();
    // Hole nodes are 15° apart; the corner at 36.87° goes to the node at 30°, the nearest.
    let corner = (30.0_f64 / 40.0).atan().to_degrees();
    for index in 0..=12 {
        let theta = 15.0 * index as f64 - 90.0;
        let phi = if theta.abs() <= 30.0 {
            theta * corner / 30.0
        } else {
            theta.signum() * (corner + (theta.abs() - 30.0) * (90.0 - corner) / 60.0)
        };
        // Two nodes per line, the outer one last.
        let [x, y] = mesh.points()[2 * index + 1];
        assert!((y.atan2(x).to_degrees() - phi).abs() < 1e-12, "{theta}");
    }
}

#[test]
fn layers_of_the_rock_grow_by_the_ratio() {
    let mesh = rock(CellKind::Quad4, [6, 4]).build().unwrap();
    let ys: Vec<f64> = (0..5).map(|u| -mesh.points()[u][1]).collect();
    assert_eq!((ys[0], ys[4]), (15.0, 40.0));
    for u in 0..3 {
        close((ys[u + 2] - ys[u + 1]) / (ys[u + 1] - ys[u]), 1.1, 1e-13);
    }
}

#[test]
fn wrong_parameters_are_errors_that_name_the_key() {
    let key = |built: Result<Mesh<2>, MeshError>| match built {
        Err(MeshError::Parameter { key, .. }) => key,
        other => panic!("{other:?}"),
    };
    let r = || rectangle(CellKind::Quad4, [2, 2]);
    let full = || ring(CellKind::Quad4, [8, 2], None);
    let arc = |angles| ring(CellKind::Quad4, [8, 2], Some(angles));
    let plate = || rock(CellKind::Quad4, [8, 2]);
    let (nan, inf) = (f64::NAN, f64::INFINITY);
    let wrong = [
        (
            Rectangle {
                cells: [0, 2],
                ..r()
            }
            .build(),
            "cells",
        ),
        (
            Rectangle {
                to: [2.0, 0.5],
                ..r()
            }
            .build(),
            "to",
        ),
        (
            Rectangle {
                to: [2.0, nan],
                ..r()
            }
            .build(),
            "from, to",
        ),
        (
            Rectangle {
                from: [-inf, 0.0],
                ..r()
            }
            .build(),
            "from, to",
        ),
        (
            Ring {
                center: [nan, 0.0],
                ..full()
            }
            .build(),
            "center",
        ),
        (
            Ring {
                inner: 0.0,
                ..full()
            }
            .build(),
            "inner",
        ),
        (
            Ring {
                inner: nan,
                ..full()
            }
            .build(),
            "inner",
        ),
        (
            Ring {
                inner: 15.0,
                ..full()
            }
            .build(),
            "outer",
        ),
        (
            Ring {
                outer: inf,
                ..full()
            }
            .build(),
            "outer",
        ),
        (
            Ring {
                cells: [8, 0],
                ..full()
            }
            .build(),
            "cells",
        ),
        (
            Ring {
                cells: [2, 1],
                ..full()
            }
            .build(),
            "cells",
        ),
        (
            Ring {
                ratio: 0.0,
                ..full()
            }
            .build(),
            "ratio",
        ),
        (
            Ring {
                ratio: nan,
                ..full()
            }
            .build(),
            "ratio",
        ),
        (
            Ring {
                ratio: -1.0,
                cells: [8, 1],
                ..full()
            }
            .build(),
            "ratio",
        ),
        (
            Ring {
                grade: 0.9,
                ..full()
            }
            .build(),
            "grade",
        ),
        (
            Ring {
                grade: -1.0,
                ..arc([0.0, 9.0])
            }
            .build(),
            "grade",
        ),
        (
            Ring {
                grade: 1e9,
                cells: [9, 1],
                ..arc([0.0, 9.0])
            }
            .build(),
            "grade",
        ),
        (arc([10.0, 10.0]).build(), "from, to"),
        (arc([0.0, 361.0]).build(), "from, to"),
        (arc([nan, 90.0]).build(), "from, to"),
        (arc([-inf, 90.0]).build(), "from, to"),
        (
            TunnelRock {
                radius: -1.0,
                ..plate()
            }
            .build(),
            "radius",
        ),
        (
            TunnelRock {
                half_width: 15.0,
                ..plate()
            }
            .build(),
            "half_width",
        ),
        (
            TunnelRock {
                half_height: nan,
                ..plate()
            }
            .build(),
            "half_height",
        ),
        (
            TunnelRock {
                half_height: inf,
                ..plate()
            }
            .build(),
            "half_height",
        ),
        (
            TunnelRock {
                cells: [3, 2],
                ..plate()
            }
            .build(),
            "cells",
        ),
        (
            TunnelRock {
                cells: [8, 0],
                ..plate()
            }
            .build(),
            "cells",
        ),
        (
            TunnelRock {
                ratio: inf,
                ..plate()
            }
            .build(),
            "ratio",
        ),
        (
            TunnelRock {
                ratio: 2.0,
                cells: [8, 5000],
                ..plate()
            }
            .build(),
            "ratio",
        ),
        (
            TunnelRock {
                grade: 0.0,
                ..plate()
            }
            .build(),
            "grade",
        ),
    ];
    for (built, expected) in wrong {
        assert_eq!(key(built), expected);
    }
}

#[test]
fn a_mesh_that_fits_no_machine_is_an_error() {
    let cells = [usize::MAX, usize::MAX];
    assert!(matches!(
        rectangle(CellKind::Quad9, cells).build(),
        Err(MeshError::TooLarge { .. })
    ));
    assert!(matches!(
        ring(CellKind::Quad4, [100_000, 100_000], None).build(),
        Err(MeshError::TooLarge { .. })
    ));
    assert!(matches!(
        rock(CellKind::Tri3, [usize::MAX, 1]).build(),
        Err(MeshError::TooLarge { .. })
    ));
}

fn kinds() -> impl Strategy<Value = CellKind> {
    prop::sample::select(CellKind::of_dimension(2).collect::<Vec<_>>())
}

fn cuts() -> impl Strategy<Value = Diagonals> {
    prop::sample::select(DIAGONALS.to_vec())
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(128))]

    #[test]
    fn any_ring_closes_and_has_its_area(
        cell in kinds(), diagonals in cuts(), around in 3_usize..20, through in 1_usize..5,
        inner in 0.1..10.0, thickness in 0.01..10.0, from in -400.0..400.0, span in 1.0..360.0,
        ratio in 0.5..2.0, grade in 0.8..1.2,
    ) {
        let ring = Ring {
            center: [1.0, 2.0], inner, outer: inner + thickness, angles: Some([from, from + span]),
            cells: [around, through], ratio, grade, cell, diagonals,
        };
        match ring.build() {
            Ok(mesh) => {
                assert_closed(&mesh);
                prop_assert!((area(&mesh) / area_of_cells(&mesh) - 1.0).abs() < 1e-11);
                let angle = f64::to_radians(span);
                let exact = 0.5 * angle * thickness * (2.0 * inner + thickness);
                prop_assert!(area(&mesh) < 1.02 * exact);
            }
            // Three or four cells on nearly a full turn bend quadratic cells too far, if anything does.
            Err(error) => prop_assert!(span / around as f64 > 60.0, "{}", error),
        }
    }

    #[test]
    fn any_roomy_rock_is_a_mesh(
        cell in kinds(), diagonals in cuts(), around in 4_usize..40, outward in 1_usize..6,
        width in 1.5..20.0, height in 1.5..20.0, ratio in 0.7..1.6, grade in 0.9..1.1,
    ) {
        let rock = TunnelRock {
            radius: 1.0, half_width: width, half_height: height, cells: [around, outward],
            ratio, grade, cell, diagonals,
        };
        let mesh = rock.build();
        prop_assert!(mesh.is_ok(), "{}", mesh.unwrap_err());
        let mesh = mesh.unwrap();
        assert_closed(&mesh);
        prop_assert!((area(&mesh) / area_of_cells(&mesh) - 1.0).abs() < 1e-11);
        prop_assert!(area(&mesh) > 2.0 * width * height - 0.5 * PI * 1.02);
    }

    #[test]
    fn no_parameters_of_a_rock_panic(
        cell in kinds(), around in 0_usize..9, outward in 0_usize..4,
        values in prop::array::uniform5(prop::sample::select(vec![
            0.0, -1.0, 1.0, 1.001, 1.1, 3.0, 1e9, 1e-300, 1e300, f64::NAN, f64::INFINITY,
        ])),
    ) {
        let [radius, half_width, half_height, ratio, grade] = values;
        let cells = [around, outward];
        let diagonals = Diagonals::default();
        if let Ok(mesh) = (TunnelRock {
            radius, half_width, half_height, cells, ratio, grade, cell, diagonals,
        }).build() {
            assert_closed(&mesh);
        }
        if let Ok(mesh) = (Ring {
            center: [ratio, grade], inner: radius, outer: half_width, angles: Some([grade, half_height]),
            cells, ratio, grade, cell, diagonals,
        }).build() {
            assert_closed(&mesh);
        }
        if let Ok(mesh) = (Rectangle {
            from: [radius, half_width], to: [half_height, ratio], cells, cell, diagonals,
        }).build() {
            assert_closed(&mesh);
        }
    }
}

// Space

fn cuboid(cell: CellKind, cells: [usize; 3]) -> Mesh<3> {
    let cuboid = Cuboid {
        from: [-1.0, 0.5, 2.0],
        to: [1.0, 1.5, 5.0],
        cells,
        cell,
    };
    cuboid.build().unwrap()
}

/// ∫n dS of some facets: their area where they are plane.
fn area_vector(mesh: &Mesh<3>, facets: &[Facet]) -> [f64; 3] {
    let mut sum = [0.0; 3];
    for &facet in facets {
        let kind = mesh.facet_kind(facet);
        let centre = kind.domain().centre();
        let normal = mesh.outward_normal(facet, &centre);
        for (s, n) in sum.iter_mut().zip(normal) {
            *s += kind.domain().volume() * n;
        }
    }
    sum
}

#[test]
fn a_box_has_its_counts_and_the_areas_of_its_sides() {
    for cell in CellKind::of_dimension(3) {
        let mesh = cuboid(cell, [2, 3, 4]);
        let (per_hexahedron, squares_in_z) = match cell.domain() {
            Domain::Tetrahedron => (6, 2),
            Domain::Prism => (2, 2),
            _ => (1, 1),
        };
        let across = if cell.domain() == Domain::Tetrahedron {
            2
        } else {
            1
        };
        // edges, diagonals included, and middles of quadrilaterals and hexahedra
        let (corners, edges, inner) = (60, 40 + 45 + 48, 32 + 36 + 30 + 24);
        let diagonals = 2 * 3 * 5;
        let nodes = corners
            + match cell {
                CellKind::Tet4 | CellKind::Hex8 | CellKind::Prism6 => 0,
                CellKind::Hex20 => edges,
                CellKind::Prism15 => edges + diagonals,
                _ => edges + inner,
            };
        assert_eq!(mesh.points().len(), nodes, "{cell:?}");
        assert_eq!(mesh.cell_count(), 24 * per_hexahedron);
        assert_eq!(mesh.component_count(), 1);
        let facets = 2 * (6 * squares_in_z + (8 + 12) * across);
        assert_eq!(mesh.boundary_facets().len(), facets);
        let sides = [
            ("left", [-3.0, 0.0, 0.0]),
            ("right", [3.0, 0.0, 0.0]),
            ("front", [0.0, -6.0, 0.0]),
            ("back", [0.0, 6.0, 0.0]),
            ("bottom", [0.0, 0.0, -2.0]),
            ("top", [0.0, 0.0, 2.0]),
        ];
        for (side, expected) in sides {
            let area = area_vector(&mesh, mesh.side(side).unwrap());
            let off = crate::geometry::distance(area, expected);
            assert!(off < 1e-14, "{cell:?} {side} {area:?}");
        }
        // cubes: tetrahedra on the paths of a cube have edges 1, √2 and √3 at their sharpest corner
        let cube = Cuboid {
            from: [0.0; 3],
            to: [1.0; 3],
            cells: [2; 3],
            cell,
        };
        let cube = cube.build().unwrap();
        let worst = (0..cube.cell_count()).map(|c| cube.cell_quality(0, c));
        let worst = worst.fold(1.0, f64::min);
        let expected = match cell.domain() {
            Domain::Tetrahedron => 1.0 / 3f64.sqrt(),
            // 45° over 60°
            Domain::Prism => (0.5f64 / 0.75).sqrt(),
            _ => 1.0,
        };
        close(worst, expected, 1e-14);
    }
}

#[test]
fn boxes_of_tetrahedra_match_on_all_sides() {
    for cell in [CellKind::Tet4, CellKind::Tet10] {
        matches_on_all_sides(&cuboid(cell, [2, 2, 2]));
    }
}

fn matches_on_all_sides(mesh: &Mesh<3>) {
    for (side, opposite, d) in [
        ("left", "right", 0),
        ("front", "back", 1),
        ("bottom", "top", 2),
    ] {
        let facets = |side: &str, shift: f64| -> BTreeSet<Vec<[i64; 3]>> {
            let of_facet = |&facet: &Facet| {
                let mut points: Vec<[i64; 3]> = mesh
                    .facet_points(facet)
                    .map(|mut x| {
                        x[d] += shift;
                        x.map(|c| (1e6 * c).round() as i64)
                    })
                    .collect();
                points.sort_unstable();
                points
            };
            mesh.side(side).unwrap().iter().map(of_facet).collect()
        };
        assert_eq!(facets(side, [2.0, 1.0, 3.0][d]), facets(opposite, 0.0));
    }
}

#[test]
fn cells_of_space_that_are_mirrored_are_turned_and_those_that_are_folded_refused() {
    for cell in CellKind::of_dimension(3) {
        let mesh = cuboid(cell, [2, 2, 1]);
        let mirrored = mesh.clone().map_points(|[x, y, z]| [x, -y, z]).unwrap();
        let area = area_vector(&mirrored, mirrored.side("front").unwrap());
        assert!(
            crate::geometry::distance(area, [0.0, 6.0, 0.0]) < 1e-13,
            "{cell:?} {area:?}"
        );
        for c in 0..mesh.cell_count() {
            close(mirrored.cell_quality(0, c), mesh.cell_quality(0, c), 1e-12);
        }
        let flat = mesh.clone().map_points(|[x, y, _]| [x, y, 0.0]);
        assert!(
            matches!(flat, Err(MeshError::ZeroVolume { .. })),
            "{flat:?}"
        );
        let folded = mesh.map_points(|[x, y, z]| match x == 0.0 && z < 3.0 {
            true => [3.0, y, z],
            false => [x, y, z],
        });
        let folded = folded.map(|mesh| mesh.cell_count());
        match cell {
            // a tetrahedron has one orientation: it is turned, and the mesh overlaps, which its outline shows
            CellKind::Tet4 => assert!(folded.is_ok()),
            // a prism or quadratic cell may be turned as a whole
            _ if cell != CellKind::Hex8 => assert!(
                folded.is_ok()
                    || matches!(
                        folded,
                        Err(MeshError::Folded { .. } | MeshError::ZeroVolume { .. })
                    )
            ),
            _ => assert!(
                matches!(folded, Err(MeshError::Folded { .. })),
                "{folded:?}"
            ),
        }
    }
}

#[test]
fn wrong_boxes_are_errors_that_name_the_key() {
    let good = Cuboid {
        from: [0.0; 3],
        to: [1.0; 3],
        cells: [1; 3],
        cell: CellKind::Hex8,
    };
    let wrong = |cuboid: Cuboid, text: &str| {
        let message = cuboid.build().unwrap_err().to_string();
        assert!(message.contains(text), "{message}");
    };
    let (to, cells, cell) = ([1.0, 1.0, 0.0], [1, 0, 1], CellKind::Quad4);
    wrong(Cuboid { to, ..good.clone() }, "every axis");
    wrong(
        Cuboid {
            cells,
            ..good.clone()
        },
        "at least one cell",
    );
    wrong(
        Cuboid {
            cell,
            ..good.clone()
        },
        "give tet4, tet10, hex8",
    );
    let cells = [100_000; 3];
    wrong(Cuboid { cells, ..good }, "nodes");
    let rectangle = rectangle(CellKind::Hex8, [1, 1]).build();
    assert!(matches!(rectangle, Err(MeshError::Dimension { .. })));
}

#[test]
fn what_is_linear_between_corners_is_made_of_them() {
    let linear = |&[x, y, z]: &[f64; 3]| 3.0 - 2.0 * x + 0.5 * y + z;
    for kind in CellKind::ALL {
        let nodes = kind.reference_nodes();
        let mut count = kind.corners();
        for (node, parts) in kind.between_corners() {
            let value: f64 = parts
                .iter()
                .map(|&(k, part)| part * linear(&nodes[k]))
                .sum();
            assert!((value - linear(&nodes[node])).abs() < 1e-14, "{kind:?}");
            // the middle of an edge depends on its ends alone
            assert!(
                parts
                    .iter()
                    .all(|&(k, part)| k < kind.corners() && part > 0.0)
            );
            count += 1;
        }
        assert_eq!(count, nodes.len());
    }
    let middle = CellKind::Quad8.between_corners().next().unwrap();
    assert_eq!(middle, (4, vec![(0, 0.5), (1, 0.5)]));
}
