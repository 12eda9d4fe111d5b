//! Meshes of space from files: what Gmsh and meshio write of every kind of cell reads as meant, and what is no body is said.
//!
//! The files show a quarter of a pipe, radii 1 and 2, height 1.5, three cells around (`tests/data/README.md`). A middle node
//! in the wrong place makes a cell fold, or a volume and areas that are wrong by far more than the polygons for the circles.

use crate::solids::{area, check_topology, volume};
use dotyk::geometry::Point;
use dotyk::mesh::{CellKind, ImportError, Imported, Mesh, MeshFile};
use std::f64::consts::PI;
use std::path::PathBuf;

fn data(name: &str) -> PathBuf {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../dotyk/tests/data");
    PathBuf::from(folder).join(name)
}

fn read(name: &str) -> MeshFile {
    MeshFile::read_solid(&data(name)).unwrap_or_else(|error| panic!("{error}"))
}

const PIPES: [(&str, CellKind, usize); 15] = [
    ("gmsh_pipe_tet4_41.msh", CellKind::Tet4, 169),
    ("gmsh_pipe_tet10_41.msh", CellKind::Tet10, 169),
    ("gmsh_pipe_tet10_22b.msh", CellKind::Tet10, 169),
    ("gmsh_pipe_hex8_22b.msh", CellKind::Hex8, 6),
    ("gmsh_pipe_hex20_41.msh", CellKind::Hex20, 6),
    ("gmsh_pipe_hex27_22.msh", CellKind::Hex27, 6),
    ("gmsh_pipe_hex27_22b.msh", CellKind::Hex27, 6),
    ("gmsh_pipe_hex27_41.msh", CellKind::Hex27, 6),
    ("gmsh_pipe_hex27_41b.msh", CellKind::Hex27, 6),
    ("gmsh_pipe_prism6_41b.msh", CellKind::Prism6, 12),
    ("gmsh_pipe_prism15_22.msh", CellKind::Prism15, 12),
    ("gmsh_pipe_prism18_22.msh", CellKind::Prism18, 12),
    ("gmsh_pipe_prism18_22b.msh", CellKind::Prism18, 12),
    ("gmsh_pipe_prism18_41.msh", CellKind::Prism18, 12),
    ("gmsh_pipe_prism18_41b.msh", CellKind::Prism18, 12),
];

/// Volume and areas of the pipe, relative errors below a bound.
fn check_pipe(mesh: &Mesh<3>, kind: CellKind, name: &str) {
    let exact = 0.75 * PI * 1.5;
    let off = (volume(mesh) / exact - 1.0).abs();
    // sectors of 30° (shorter for tetrahedra inside): 1 − sin φ/φ for chords, φ⁴/1500 or less for parabolas
    let bound = [0.06, 1e-3][kind.order() - 1];
    assert!(off < bound, "{name}: volume off by {off:e}");
    let sides = [
        ("bottom", 0.75 * PI),
        ("top", 0.75 * PI),
        ("outer", 1.5 * PI),
        ("inner", 0.75 * PI),
        ("start", 1.5),
        ("end", 1.5),
    ];
    for (side, exact) in sides {
        let off = (area(mesh, side) / exact - 1.0).abs();
        assert!(off < bound, "{name}, {side}: area off by {off:e}");
    }
}

#[test]
fn files_of_gmsh_have_cells_sides_and_points_of_every_kind() {
    for (name, kind, cells) in PIPES {
        let file = read(name);
        assert_eq!(file.cell_groups(), ["pipe"], "{name}");
        for groups in [&[][..], &["pipe"]] {
            let Imported {
                mut mesh,
                points,
                unused_sides,
                ..
            } = file.solid(groups).unwrap();
            assert_eq!(mesh.blocks()[0].kind, kind, "{name}");
            assert_eq!(mesh.cell_count(), cells, "{name}");
            assert_eq!(mesh.blocks()[0].group.as_deref(), Some("pipe"));
            assert_eq!(points["corner"], [[2.0, 0.0, 0.0]], "{name}");
            assert!(unused_sides.is_empty());
            check_pipe(&mesh, kind, name);
            assert_eq!(mesh.side("boundary").unwrap(), mesh.boundary_facets());
            // the named sides are the whole boundary
            mesh = without_boundary(mesh);
            assert_eq!(check_topology(&mesh), 2, "{name}");
        }
    }
}

/// The same mesh with the sides that the file names alone.
fn without_boundary(mesh: Mesh<3>) -> Mesh<3> {
    let mut sides = mesh.sides().clone();
    sides.remove("boundary");
    let bare = Mesh::new(mesh.points().to_vec(), mesh.blocks().to_vec()).unwrap();
    bare.with_sides(sides).unwrap()
}

#[test]
fn files_of_meshio_have_the_nodes_in_the_same_places() {
    for (vtu, msh) in [
        ("meshio_pipe_tet10.vtu", "gmsh_pipe_tet10_41.msh"),
        ("meshio_pipe_hex20.vtu", "gmsh_pipe_hex20_41.msh"),
        ("meshio_pipe_hex27.vtu", "gmsh_pipe_hex27_41.msh"),
    ] {
        let [vtu, msh] = [vtu, msh].map(|name| read(name).solid(&[]).unwrap().mesh);
        assert_eq!(vtu.side_names().collect::<Vec<_>>(), ["boundary"]);
        assert_eq!(vtu.blocks()[0].kind, msh.blocks()[0].kind);
        let places = |mesh: &Mesh<3>| -> Vec<Point<3>> {
            let nodes = mesh.blocks()[0].nodes.iter();
            nodes.map(|&node| mesh.points()[node as usize]).collect()
        };
        assert_eq!(places(&vtu), places(&msh));
    }
}

#[test]
fn what_is_no_body_of_space_is_said() {
    let error = |name: &str| MeshFile::read_solid(&data(name)).unwrap_err().to_string();
    let said = error("gmsh_shell_41.msh");
    assert!(said.contains("has no cells of space"), "{said}");
    assert!(
        said.contains("faces") && said.contains("mesh in 3D"),
        "{said}"
    );
    // a mesh of the plane
    let said = error("gmsh_rings_41.msh");
    assert!(said.contains("has no cells of space"), "{said}");
    let said = read("gmsh_pyramid_41.msh")
        .solid(&[])
        .unwrap_err()
        .to_string();
    assert!(
        said.contains("pyramid5, which is not supported yet"),
        "{said}"
    );
    let pipe = read("gmsh_pipe_hex8_22b.msh");
    let said = pipe.solid(&["top"]).unwrap_err();
    assert!(matches!(&said, ImportError::Shell { .. }), "{said}");
    assert!(
        said.to_string().contains("`top` is a group of faces"),
        "{said}"
    );
    let said = pipe.solid(&["pip"]).unwrap_err().to_string();
    assert!(
        said.contains("no group of cells `pip`; it has pipe"),
        "{said}"
    );
    // a file is read for one dimension
    let said = pipe.mesh(&[]).unwrap_err().to_string();
    assert!(said.contains("dimension 3"), "{said}");
    let plane = MeshFile::read(&data("gmsh_pipe_hex8_22b.msh")).unwrap();
    let warned = plane.warnings().join("\n");
    assert!(
        warned.contains("6 elements of the kind hex8 are left out"),
        "{warned}"
    );
}

/// A text of version 2.2: points, and elements as type and nodes from 1.
fn text(points: &[Point<3>], elements: &[(u8, &[usize])]) -> Vec<u8> {
    let mut text = format!(
        "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n{}\n",
        points.len()
    );
    for (k, [x, y, z]) in points.iter().enumerate() {
        text += &format!("{} {x} {y} {z}\n", k + 1);
    }
    text += &format!("$EndNodes\n$Elements\n{}\n", elements.len());
    for (k, (kind, nodes)) in elements.iter().enumerate() {
        let nodes: Vec<String> = nodes.iter().map(usize::to_string).collect();
        text += &format!("{} {kind} 2 1 1 {}\n", k + 11, nodes.join(" "));
    }
    (text + "$EndElements\n").into_bytes()
}

const TWO_CUBES: [Point<3>; 12] = [
    [0.0, 0.0, 0.0],
    [1.0, 0.0, 0.0],
    [1.0, 1.0, 0.0],
    [0.0, 1.0, 0.0],
    [0.0, 0.0, 1.0],
    [1.0, 0.0, 1.0],
    [1.0, 1.0, 1.0],
    [0.0, 1.0, 1.0],
    [0.0, 0.0, 2.0],
    [1.0, 0.0, 2.0],
    [1.0, 1.0, 2.0],
    [0.0, 1.0, 2.0],
];

fn solid(elements: &[(u8, &[usize])]) -> Result<Mesh<3>, String> {
    let file = MeshFile::solid_from_bytes("part.msh", &text(&TWO_CUBES, elements));
    let imported = file.and_then(|file| file.solid(&[]));
    imported.map(|i| i.mesh).map_err(|error| error.to_string())
}

#[test]
fn cells_numbered_the_other_way_round_are_turned_and_flat_or_folded_ones_named() {
    let right = solid(&[(4, &[1, 2, 4, 5])]).unwrap();
    let left = solid(&[(4, &[2, 1, 4, 5])]).unwrap();
    assert!((volume(&right) - 1.0 / 6.0).abs() < 1e-15);
    assert!((volume(&left) - 1.0 / 6.0).abs() < 1e-15);
    let said = solid(&[(4, &[1, 2, 4, 5]), (4, &[1, 2, 3, 4])]).unwrap_err();
    assert!(
        said.contains("element 12") && said.contains("no volume"),
        "{said}"
    );
    let said = solid(&[(5, &[1, 2, 4, 3, 5, 6, 7, 8])]).unwrap_err();
    assert!(
        said.contains("element 11") && said.contains("is folded"),
        "{said}"
    );
    let said = solid(&[(4, &[1, 2, 4, 5]), (4, &[1, 2, 4, 6]), (4, &[1, 2, 4, 7])]).unwrap_err();
    assert!(said.contains("do not fit together at one face"), "{said}");
}

#[test]
fn triangles_on_a_quadrilateral_do_not_fit() {
    let cube: (u8, &[usize]) = (5, &[1, 2, 3, 4, 5, 6, 7, 8]);
    let halves: [(u8, &[usize]); 2] = [(4, &[5, 6, 7, 9]), (4, &[5, 7, 8, 9])];
    let said = solid(&[cube, halves[0], halves[1]]).unwrap_err();
    assert!(
        said.contains("the elements 11, 12, 13 do not fit together at one face"),
        "{said}"
    );
    // one of them alone is as much inside
    let said = solid(&[halves[0], cube]).unwrap_err();
    assert!(said.contains("the elements 11, 12 do not"), "{said}");
    // beside it, with an edge in common, nothing is wrong
    assert!(solid(&[cube, (4, &[5, 6, 9, 11])]).is_ok());
}

#[test]
fn a_face_inside_is_no_side_and_one_that_leaves_the_body_is_none_of_its_own() {
    let lower: &[usize] = &[1, 2, 3, 4, 5, 6, 7, 8];
    let upper: &[usize] = &[5, 6, 7, 8, 9, 10, 11, 12];
    let faces: [&[usize]; 3] = [&[5, 6, 7, 8], &[1, 4, 3, 2], &[9, 10, 11, 12]];
    let mut elements: Vec<(u8, &[usize])> = vec![(5, lower), (5, upper)];
    elements.extend(faces.map(|face| (3, face)));
    let file = MeshFile::solid_from_bytes("part.msh", &text(&TWO_CUBES, &elements)).unwrap();
    let imported = file.solid(&[]).unwrap();
    assert_eq!(imported.mesh.side("1").unwrap().len(), 2);
    let warned = imported.warnings.join("\n");
    assert!(
        warned.contains("1 faces of the group `1` lie inside it"),
        "{warned}"
    );
    // three corners of a quadrilateral are a face of the tetrahedron beside it
    let corner: &[usize] = &[5, 6, 8, 9];
    let quad: &[usize] = &[5, 6, 7, 8];
    let file = text(&TWO_CUBES, &[(4, corner), (3, quad)]);
    let file = MeshFile::solid_from_bytes("part.msh", &file).unwrap();
    let imported = file.solid(&[]).unwrap();
    assert_eq!(imported.mesh.side_names().collect::<Vec<_>>(), ["boundary"]);
    assert_eq!(imported.unused_sides, ["1"]);
}
