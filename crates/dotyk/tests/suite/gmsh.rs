//! Meshes from files: what is written in any variant of a format reads back, files of other programs read as meant,
//! and what is wrong or has no place in a body is said.

use crate::solids::volume;
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use dotyk::case::{Case, CaseError};
use dotyk::fem::quadrature::rule;
use dotyk::mesh::{
    CellBlock, CellKind, Facet, FilePlace, ImportError, Imported, Mesh, MeshFile, Rectangle, Ring,
};
use dotyk::output;
use dotyk::prelude::*;
use std::collections::{BTreeMap, BTreeSet};
use std::f64::consts::FRAC_PI_4;
use std::path::PathBuf;

/// A variant of the format: version, and in binary files the order of bytes.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Variant {
    version: f64,
    big_endian: Option<bool>,
}

const VARIANTS: [Variant; 12] = [
    variant(2.0, None),
    variant(2.0, Some(false)),
    variant(2.1, None),
    variant(2.2, None),
    variant(2.2, Some(false)),
    variant(2.2, Some(true)),
    variant(4.0, None),
    variant(4.0, Some(false)),
    variant(4.0, Some(true)),
    variant(4.1, None),
    variant(4.1, Some(false)),
    variant(4.1, Some(true)),
];

const fn variant(version: f64, big_endian: Option<bool>) -> Variant {
    Variant {
        version,
        big_endian,
    }
}

/// An element of a file: Gmsh's type, dimension, physical tag (which is also its entity), points.
#[derive(Clone)]
struct Element {
    kind: i32,
    dimension: i32,
    physical: i32,
    nodes: Vec<u32>,
}

/// Elements with their places in the file.
type Numbered<'e> = Vec<(usize, &'e Element)>;

/// What is written into a file.
#[derive(Clone, Default)]
struct Content {
    names: Vec<(i32, i32, String)>,
    points: Vec<[f64; 3]>,
    elements: Vec<Element>,
}

fn gmsh_type(kind: CellKind) -> i32 {
    match kind {
        CellKind::Tri3 => 2,
        CellKind::Tri6 => 9,
        CellKind::Quad4 => 3,
        CellKind::Quad8 => 16,
        CellKind::Quad9 => 10,
        CellKind::Line2 => 1,
        CellKind::Line3 => 8,
        CellKind::Tet4 => 4,
        CellKind::Hex8 => 5,
        CellKind::Tet10 => 11,
        CellKind::Hex20 => 17,
        CellKind::Hex27 => 12,
        CellKind::Prism6 => 6,
        CellKind::Prism15 => 18,
        CellKind::Prism18 => 13,
    }
}

impl Content {
    /// Adds a mesh: its cells as the group `name`, its sides as groups `name-SIDE`. Points are shared with `merge`.
    fn add(&mut self, mesh: &Mesh<2>, name: &str, merge: bool) {
        let mut index = Vec::new();
        for &[x, y] in mesh.points() {
            let same = self
                .points
                .iter()
                .position(|p| merge && (p[0] - x).hypot(p[1] - y) < 1e-9);
            index.push(same.unwrap_or_else(|| {
                self.points.push([x, y, 0.5]);
                self.points.len() - 1
            }) as u32);
        }
        let mut tag = self.names.len() as i32 + 1;
        self.names.push((2, tag, name.to_string()));
        for block in mesh.blocks() {
            for cell in block.cells() {
                self.elements.push(Element {
                    kind: gmsh_type(block.kind),
                    dimension: 2,
                    physical: tag,
                    nodes: cell.iter().map(|&n| index[n as usize]).collect(),
                });
            }
        }
        for (side, facets) in mesh.sides() {
            tag += 1;
            self.names.push((1, tag, format!("{name}-{side}")));
            for &facet in facets {
                let mut nodes: Vec<u32> =
                    mesh.facet_nodes(facet).map(|n| index[n as usize]).collect();
                // the other way round than the cell has it
                nodes.swap(0, 1);
                self.elements.push(Element {
                    kind: if nodes.len() == 2 { 1 } else { 8 },
                    dimension: 1,
                    physical: tag,
                    nodes,
                });
            }
        }
    }

    fn of(mesh: &Mesh<2>, name: &str) -> Self {
        let mut content = Self::default();
        content.add(mesh, name, false);
        content
    }

    fn write(&self, variant: Variant) -> Vec<u8> {
        let mut out = Output {
            bytes: Vec::new(),
            big_endian: variant.big_endian,
        };
        let mode = i32::from(variant.big_endian.is_some());
        out.text(&format!("$MeshFormat\n{} {mode} 8\n", variant.version));
        if variant.big_endian.is_some() {
            out.int(1);
            out.end();
        }
        out.text(&format!(
            "$EndMeshFormat\n$PhysicalNames\n{}\n",
            self.names.len()
        ));
        for (dimension, tag, name) in &self.names {
            // version 2.0 has no dimension
            let dimension = match variant.version {
                2.0 => String::new(),
                _ => format!("{dimension} "),
            };
            out.text(&format!("{dimension}{tag} \"{name}\"\n"));
        }
        out.text("$EndPhysicalNames\n");
        match variant.version {
            4.0 => self.write_4(&mut out, true),
            4.1 => self.write_4(&mut out, false),
            _ => self.write_2(&mut out),
        }
        out.bytes
    }

    /// Version 1 is text and has no names.
    fn write_1(&self) -> Vec<u8> {
        let mut text = format!("$NOD\n{}\n", self.points.len());
        for (index, [x, y, z]) in self.points.iter().enumerate() {
            text += &format!("{} {x:?} {y:?} {z:?}\n", Self::number(index as u32));
        }
        text += &format!("$ENDNOD\n$ELM\n{}\n", self.elements.len());
        for (index, element) in self.elements.iter().enumerate() {
            let nodes = element.nodes.iter();
            let nodes: Vec<String> = nodes.map(|&n| Self::number(n).to_string()).collect();
            let (kind, tag, count) = (element.kind, element.physical, nodes.len());
            text += &format!(
                "{} {kind} {tag} {tag} {count} {}\n",
                index + 1,
                nodes.join(" ")
            );
        }
        (text + "$ENDELM\n").into_bytes()
    }

    /// Numbers of nodes have gaps.
    fn number(point: u32) -> i32 {
        3 * point as i32 + 10
    }

    fn write_2(&self, out: &mut Output) {
        out.text(&format!("$Nodes\n{}\n", self.points.len()));
        for (index, point) in self.points.iter().enumerate() {
            out.int(Self::number(index as u32));
            point.iter().for_each(|&c| out.real(c));
            out.end();
        }
        out.text(&format!("$EndNodes\n$Elements\n{}\n", self.elements.len()));
        for (index, element) in self.elements.iter().enumerate() {
            let number = index as i32 + 1;
            let tags = [element.physical, element.physical];
            if out.big_endian.is_some() {
                [element.kind, 1, 2, number]
                    .iter()
                    .for_each(|&i| out.int(i));
            } else {
                [number, element.kind, 2].iter().for_each(|&i| out.int(i));
            }
            tags.iter().for_each(|&tag| out.int(tag));
            element
                .nodes
                .iter()
                .for_each(|&node| out.int(Self::number(node)));
            out.end();
        }
        out.text("$EndElements\n");
    }

    /// Version 4.1, or 4.0, which is `old`.
    fn write_4(&self, out: &mut Output, old: bool) {
        let mut entities: BTreeMap<(i32, i32), Numbered> = BTreeMap::new();
        for (index, element) in self.elements.iter().enumerate() {
            let key = (element.dimension, element.physical);
            entities.entry(key).or_default().push((index, element));
        }
        out.text("$Entities\n");
        for dimension in 0..4 {
            out.size(entities.keys().filter(|key| key.0 == dimension).count());
        }
        out.end();
        for (dimension, tag) in entities.keys() {
            out.int(*tag);
            let point = *dimension == 0 && !old;
            (0..if point { 3 } else { 6 }).for_each(|_| out.real(0.0));
            if *tag == 0 {
                out.size(0);
            } else {
                out.size(1);
                // the sign is an orientation
                out.int(-tag);
            }
            if *dimension > 0 {
                out.size(0);
            }
            out.end();
        }
        out.text("$EndEntities\n$Nodes\n");
        // two blocks, the first with parameters
        let half = self.points.len() / 2;
        let last = Self::number(self.points.len() as u32 - 1) as usize;
        let head = [2, self.points.len(), 10, last];
        let head = if old { &head[..2] } else { &head };
        head.iter().for_each(|&s| out.size(s));
        out.end();
        for (parametric, range) in [(1, 0..half), (0, half..self.points.len())] {
            let entity = if old { [1, 2] } else { [2, 1] };
            entity.iter().for_each(|&i| out.int(i));
            out.int(parametric);
            out.size(range.len());
            out.end();
            if !old {
                for index in range.clone() {
                    out.size(Self::number(index as u32) as usize);
                    out.end();
                }
            }
            for index in range {
                if old {
                    out.int(Self::number(index as u32));
                }
                self.points[index].iter().for_each(|&c| out.real(c));
                (0..2 * parametric).for_each(|_| out.real(0.25));
                out.end();
            }
        }
        // a block for each kind of an entity
        let mut blocks: BTreeMap<(i32, i32, i32), Numbered> = BTreeMap::new();
        for (index, element) in self.elements.iter().enumerate() {
            let key = (element.dimension, element.physical, element.kind);
            blocks.entry(key).or_default().push((index, element));
        }
        out.text("$EndNodes\n$Elements\n");
        let count = self.elements.len();
        let head = [blocks.len(), count, 1, count];
        let head = if old { &head[..2] } else { &head };
        head.iter().for_each(|&s| out.size(s));
        out.end();
        for ((dimension, tag, kind), elements) in blocks {
            let entity = if old {
                [tag, dimension]
            } else {
                [dimension, tag]
            };
            entity.iter().for_each(|&i| out.int(i));
            out.int(kind);
            out.size(elements.len());
            out.end();
            for (index, element) in elements {
                out.label(index + 1, old);
                for &node in &element.nodes {
                    out.label(Self::number(node) as usize, old);
                }
                out.end();
            }
        }
        out.text("$EndElements\n");
    }
}

/// Numbers as text or bytes.
struct Output {
    bytes: Vec<u8>,
    big_endian: Option<bool>,
}

impl Output {
    fn text(&mut self, text: &str) {
        if self.big_endian.is_some() && self.bytes.last().is_some_and(|&b| b != b'\n') {
            self.bytes.push(b'\n');
        }
        self.bytes.extend(text.bytes());
    }

    fn number(&mut self, text: String, little: &[u8]) {
        match self.big_endian {
            None => self.bytes.extend((text + " ").bytes()),
            Some(false) => self.bytes.extend(little),
            Some(true) => self.bytes.extend(little.iter().rev()),
        }
    }

    fn int(&mut self, value: i32) {
        self.number(value.to_string(), &value.to_le_bytes());
    }

    fn size(&mut self, value: usize) {
        self.number(value.to_string(), &(value as u64).to_le_bytes());
    }

    /// The number of a node or an element, which has four bytes in version 4.0.
    fn label(&mut self, value: usize, old: bool) {
        match old {
            true => self.int(value as i32),
            false => self.size(value),
        }
    }

    fn real(&mut self, value: f64) {
        self.number(format!("{value:?}"), &value.to_le_bytes());
    }

    /// The end of a line, which binary parts do not have.
    fn end(&mut self) {
        if self.big_endian.is_none() {
            self.bytes.push(b'\n');
        }
    }
}

fn quarter(cell: CellKind, inner: f64, outer: f64, around: usize) -> Mesh<2> {
    let ring = Ring {
        center: [0.0, 0.0],
        inner,
        outer,
        angles: Some([0.0, 90.0]),
        cells: [around, 2],
        ratio: 1.0,
        grade: 1.0,
        cell,
        diagonals: Diagonals::default(),
    };
    ring.build().unwrap()
}

fn square(cell: CellKind, cells: [usize; 2]) -> Mesh<2> {
    let rectangle = Rectangle {
        from: [0.0, 0.0],
        to: [1.0, 1.0],
        cells,
        cell,
        diagonals: Diagonals::default(),
    };
    rectangle.build().unwrap()
}

fn read(bytes: &[u8]) -> Result<MeshFile, ImportError> {
    MeshFile::from_bytes("part.msh", bytes)
}

fn data(name: &str) -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR"))
        .join("../dotyk/tests/data")
        .join(name)
}

fn real(name: &str) -> MeshFile {
    MeshFile::read(&data(name)).unwrap_or_else(|error| panic!("{error}"))
}

fn whole(name: &str) -> Imported {
    real(name)
        .mesh(&[])
        .unwrap_or_else(|error| panic!("{error}"))
}

fn names(mesh: &Mesh<2>) -> Vec<&str> {
    mesh.side_names().collect()
}

/// The blocks in the order of their kinds: the order of blocks is that of the file.
fn by_kind(mesh: &Mesh<2>) -> Vec<&CellBlock> {
    let mut blocks: Vec<&CellBlock> = mesh.blocks().iter().collect();
    blocks.sort_by_key(|block| block.kind);
    blocks
}

#[test]
fn every_cell_kind_reads_back_in_every_variant() {
    for kind in CellKind::of_dimension(2) {
        let mesh = quarter(kind, 1.0, 2.5, 5);
        let content = Content::of(&mesh, "ring");
        for variant in VARIANTS {
            let file = read(&content.write(variant)).unwrap();
            assert_eq!(file.warnings(), [""; 0], "{variant:?}");
            let imported = file.mesh(&["ring"]).unwrap();
            assert_eq!(imported.warnings, [""; 0], "{variant:?}");
            let back = imported.mesh;
            assert_eq!(back.points(), mesh.points(), "{kind:?} {variant:?}");
            assert_eq!(back.blocks().len(), 1);
            assert_eq!(back.blocks()[0].kind, kind);
            assert_eq!(back.blocks()[0].nodes, mesh.blocks()[0].nodes);
            assert_eq!(back.blocks()[0].group.as_deref(), Some("ring"));
            assert_eq!(back.sides().len(), mesh.sides().len() + 1);
            for (side, facets) in mesh.sides() {
                assert_eq!(back.side(&format!("ring-{side}")), Some(&facets[..]));
            }
            assert_eq!(back.side("boundary"), Some(&mesh.boundary_facets()[..]));
        }
    }
}

#[test]
fn two_bodies_of_one_file_share_the_side_between_them() {
    let mut content = Content::of(&quarter(CellKind::Tri6, 1.0, 2.0, 4), "in");
    content.add(&quarter(CellKind::Quad8, 2.0, 3.0, 4), "out", true);
    for variant in VARIANTS {
        let file = read(&content.write(variant)).unwrap();
        assert_eq!(file.cell_groups(), ["in", "out"]);
        let (inner, outer) = (file.mesh(&["in"]).unwrap(), file.mesh(&["out"]).unwrap());
        let places = |mesh: &Mesh<2>, side: &str| {
            let nodes = mesh.side_nodes(side).unwrap();
            let bits = nodes
                .iter()
                .map(|&n| mesh.points()[n as usize].map(f64::to_bits));
            bits.collect::<BTreeSet<_>>()
        };
        // both groups on the circle are sides of both bodies
        for side in ["in-outer", "out-inner"] {
            assert_eq!(places(&inner.mesh, side), places(&outer.mesh, side));
            assert_eq!(places(&inner.mesh, side).len(), 9);
        }
        assert_eq!(inner.unused_cells, ["out"]);
        assert_eq!(inner.unused_sides, ["out-end", "out-outer", "out-start"]);
        assert!(outer.mesh.side("in-inner").is_none());
    }
}

#[test]
fn groups_make_one_body_with_a_block_for_each() {
    let mut content = Content::of(&quarter(CellKind::Quad9, 1.0, 2.0, 4), "steel");
    content.add(&quarter(CellKind::Tri6, 2.0, 3.0, 4), "rubber", true);
    let file = read(&content.write(VARIANTS[3])).unwrap();
    for groups in [&["steel", "rubber"][..], &[]] {
        let body = file.mesh(groups).unwrap();
        let blocks = body.mesh.blocks().iter();
        let blocks: Vec<_> = blocks.map(|b| (b.kind, b.group.as_deref())).collect();
        assert_eq!(
            blocks,
            [
                (CellKind::Quad9, Some("steel")),
                (CellKind::Tri6, Some("rubber"))
            ]
        );
        assert_eq!(body.mesh.component_count(), 1);
        // what is between the two is no side, and is reported
        assert!(body.mesh.side("steel-outer").is_none());
        assert_eq!(body.warnings.len(), 2, "{:?}", body.warnings);
        assert!(body.warnings[0].contains("`steel-outer`") && body.warnings[0].contains("inside"));
        assert!(body.unused_cells.is_empty());
    }
}

#[test]
fn the_four_files_of_gmsh_hold_one_mesh() {
    let first = whole("gmsh_rings_41.msh").mesh;
    let others = [
        "gmsh_rings_41b.msh",
        "gmsh_rings_22.msh",
        "gmsh_rings_22b.msh",
        "gmsh_parametric_41b.msh",
        "gmsh_parametric_22.msh",
        "gmsh_parametric_22b.msh",
        "meshio_22.msh",
        "meshio_22b.msh",
    ];
    for name in others {
        let other = whole(name).mesh;
        assert_eq!(other.points().len(), first.points().len(), "{name}");
        for (a, b) in first.points().iter().zip(other.points()) {
            // 16 digits are written, of numbers below 100
            assert!((a[0] - b[0]).hypot(a[1] - b[1]) < 1e-13, "{name}");
        }
        assert_eq!(by_kind(&other), by_kind(&first), "{name}");
        assert_eq!(names(&other), names(&first), "{name}");
        for side in names(&first) {
            assert_eq!(other.side_nodes(side), first.side_nodes(side), "{name}");
        }
    }
}

#[test]
fn second_order_cells_of_gmsh_follow_the_circles() {
    for name in ["gmsh_rings_41.msh", "gmsh_quad8_41.msh"] {
        let mesh = whole(name).mesh;
        assert_eq!(names(&mesh), ["5", "bore", "boundary", "rim", "y_0"]);
        for (side, radius) in [("bore", 20.0), ("rim", 80.0)] {
            for &facet in mesh.side(side).unwrap() {
                assert_eq!(mesh.facet_nodes(facet).len(), 3);
                for [x, y] in mesh.facet_points(facet) {
                    // Gmsh places nodes on curves to about 1e-7 of their length
                    assert!((x.hypot(y) - radius).abs() < 1e-5, "{name}");
                }
            }
        }
        // the smallest corner of a right Jacobian everywhere: a wrong order of middle nodes folds cells
        for (block, cells) in mesh.blocks().iter().enumerate() {
            for cell in 0..cells.cells().len() {
                assert!(mesh.cell_quality(block, cell) > 0.3);
            }
        }
    }
}

#[test]
fn groups_are_called_by_name_or_number_and_renamed_with_a_warning() {
    let file = real("gmsh_rings_41.msh");
    assert_eq!(file.cell_groups(), ["inner_ring", "outer"]);
    assert_eq!(file.side_groups(), ["bore", "fit", "rim", "y_0", "5"]);
    let warnings = file.warnings();
    assert_eq!(warnings.len(), 2, "{warnings:?}");
    assert!(warnings[0].contains("`inner ring` is called `inner_ring`"));
    assert!(warnings[1].contains("`y=0` is called `y_0`"));
    assert_eq!(file.point_groups(), ["corner"]);
    let (a, b) = (
        file.mesh(&["inner ring"]).unwrap(),
        file.mesh(&["inner_ring"]).unwrap(),
    );
    assert_eq!(a.mesh, b.mesh);
    assert_eq!(names(&a.mesh), ["5", "bore", "boundary", "fit", "y_0"]);
    assert_eq!(a.unused_sides, ["rim"]);
    let named = |imported: &Imported| imported.points.get("corner").map(Vec::len);
    let whole = file.mesh(&[]).unwrap();
    assert_eq!(named(&whole), Some(1));
    assert_ne!(named(&a).is_some(), a.unused_points == ["corner"]);
}

#[test]
fn names_that_cannot_be_told_apart_are_refused() {
    let mut content = Content::of(&square(CellKind::Quad4, [1, 1]), "a b");
    content.add(
        &square(CellKind::Quad4, [1, 1])
            .map_points(|[x, y]| [x + 2.0, y])
            .unwrap(),
        "a.b",
        false,
    );
    let error = read(&content.write(VARIANTS[0])).unwrap_err();
    assert!(
        matches!(&error, ImportError::NameClash { name, .. } if name == "a_b"),
        "{error}"
    );
    // a number and a name
    content.names[0].2 = String::new();
    content.names[5].2 = "1".to_string();
    let error = read(&content.write(VARIANTS[0])).unwrap_err();
    assert!(
        matches!(&error, ImportError::NameClash { name, .. } if name == "1"),
        "{error}"
    );
    // one name of two tags is one group
    content.names[0].2 = "ab".to_string();
    content.names[5].2 = "ab".to_string();
    for name in &mut content.names[6..] {
        name.2 = name.2.replace("a.b", "ab");
    }
    let file = read(&content.write(VARIANTS[0])).unwrap();
    assert_eq!(file.mesh(&["ab"]).unwrap().mesh.cell_count(), 2);
}

#[test]
fn a_file_without_groups_is_one_body_with_one_side() {
    let imported = whole("gmsh_nogroups_41.msh");
    assert_eq!(names(&imported.mesh), ["boundary"]);
    assert_eq!(imported.warnings.len(), 1);
    assert!(imported.warnings[0].contains("`boundary`"));
    assert!(
        imported
            .mesh
            .blocks()
            .iter()
            .all(|block| block.group.is_none())
    );
    let outer = whole("meshio_41.msh").mesh;
    assert_eq!(outer.blocks().len(), 1);
    assert_eq!(outer, whole("meshio_41b.msh").mesh);
}

#[test]
fn elements_of_no_group_are_counted() {
    let file = real("gmsh_all_41.msh");
    // every curve and surface of this part is in a group, no point but one is
    assert!(
        file.warnings()
            .iter()
            .all(|w| !w.contains("belong to no physical group"))
    );
    let mut content = Content::of(&square(CellKind::Quad4, [3, 1]), "a");
    content.elements[1].physical = 0;
    content.elements[4].physical = 0;
    for variant in VARIANTS {
        let file = read(&content.write(variant)).unwrap();
        let words = file.warnings().join("\n");
        assert!(
            words.contains("1 edges belong to no physical group"),
            "{words}"
        );
        let all = file.mesh(&[]).unwrap();
        assert!(
            all.warnings[0].contains("1 of its 3 cells"),
            "{:?}",
            all.warnings
        );
        let some = file.mesh(&["a"]).unwrap();
        assert_eq!((some.mesh.cell_count(), some.unused_loose), (2, 1));
    }
}

/// The area of a mesh, ½ ∫ x·n over its boundary.
fn area(mesh: &Mesh<2>) -> f64 {
    let of_facet = |facet: Facet| {
        let points = rule(mesh.facet_kind(facet), 6).into_iter();
        let flux = |xi: &[f64]| {
            let ([x, y], [nx, ny]) = (mesh.facet_point(facet, xi), mesh.outward_normal(facet, xi));
            0.5 * (x * nx + y * ny)
        };
        points.map(|p| p.weight * flux(&p.xi)).sum::<f64>()
    };
    mesh.boundary_facets().into_iter().map(of_facet).sum()
}

#[test]
fn partitions_of_one_file_are_joined() {
    for name in ["gmsh_partitioned_22.msh", "gmsh_partitioned_41.msh"] {
        let mesh = whole(name).mesh;
        assert_eq!(
            names(&mesh),
            ["5", "bore", "boundary", "rim", "y_0"],
            "{name}"
        );
        assert_eq!(mesh.component_count(), 1, "{name}");
        let ring = FRAC_PI_4 * (80.0f64.powi(2) - 20.0f64.powi(2));
        // chords instead of arcs
        assert!((area(&mesh) / ring - 1.0).abs() < 5e-3, "{name}");
    }
}

#[test]
fn files_of_partitions_are_joined_under_the_name_of_the_mesh() {
    let folder = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join("partitions");
    let _ = std::fs::remove_dir_all(&folder);
    std::fs::create_dir_all(&folder).unwrap();
    let [left, right, path] =
        ["part_1.msh", "part_02.msh", "part.msh"].map(|name| folder.join(name));
    let write = |path: &PathBuf, partition: usize, shift: f64| {
        std::fs::write(path, partition_of_two(partition, shift)).unwrap();
    };
    write(&left, 1, 0.0);
    // one partition alone is not the mesh
    let error = MeshFile::read(&left).unwrap_err().to_string();
    assert!(
        error.contains("part_1.msh: the mesh has 2 partitions, and there are no cells of 2: ")
            && error.contains("name `part.msh`"),
        "{error}"
    );
    let error = MeshFile::read(&path).unwrap_err().to_string();
    assert!(
        error.contains("part.msh: ") || error.contains("part_1.msh: "),
        "{error}"
    );
    write(&right, 2, 0.0);
    let file = MeshFile::read(&path).unwrap();
    let imported = file.mesh(&["block"]).unwrap();
    // the nodes between them are one, and the facet there is inside
    assert_eq!(imported.mesh.points().len(), 6);
    assert_eq!(imported.mesh.cell_count(), 2);
    assert_eq!(imported.mesh.boundary_facets().len(), 6);
    assert_eq!(imported.mesh.side("bottom").unwrap().len(), 2);
    assert_eq!(imported.warnings, [""; 0]);
    // a shared node in two places is no mesh
    write(&right, 2, 0.5);
    let error = MeshFile::read(&path).unwrap_err().to_string();
    assert!(
        error.contains("part_02.msh, line") && error.contains("node 2 is given twice"),
        "{error}"
    );
    std::fs::rename(&right, folder.join("part_3.msh")).unwrap();
    let error = MeshFile::read(&path).unwrap_err().to_string();
    assert!(
        error.contains("numbered 1, 3: ") && error.contains("number 2 is expected"),
        "{error}"
    );
}

/// A file of version 4.1 with one of two squares side by side, of the entities 11 and 12 cut out of the surface 1; the
/// nodes 2 and 3 are those between them, and the curve there, which has the tag of the surface, is of both.
fn partition_of_two(partition: usize, shift: f64) -> String {
    let nodes = match partition {
        1 => "1\n2\n3\n4\n0 0 0\n1 0 0\n1 1 0\n0 1 0".to_string(),
        _ => format!("2\n5\n6\n3\n{} 0 0\n2 0 0\n2 1 0\n1 1 0", 1.0 + shift),
    };
    let (cell, bottom) = match partition {
        1 => ("1 2 3 4", "1 2"),
        _ => ("2 5 6 3", "2 5"),
    };
    let entity = 10 + partition;
    format!(
        "$MeshFormat
4.1 0 8
$EndMeshFormat
$PhysicalNames
2
1 4 \"bottom\"
2 7 \"block\"
$EndPhysicalNames
$Entities
0 1 1 0
1 0 0 0 2 0 0 1 4 0
1 0 0 0 2 1 0 1 7 0
$EndEntities
$PartitionedEntities
2
1
9 1
0 3 2 0
11 1 1 1 1 0 0 0 1 0 0 1 4 0
12 1 1 1 2 1 0 0 2 0 0 1 4 0
13 2 1 2 1 2 1 0 0 1 1 0 1 7 0
11 2 1 1 1 0 0 0 1 1 0 1 7 0
12 2 1 1 2 1 0 0 2 1 0 1 7 0
$EndPartitionedEntities
$Nodes
1 4 1 6
2 {entity} 0 4
{nodes}
$EndNodes
$Elements
3 3 1 6
1 {entity} 1 1
{partition} {bottom}
1 13 1 1
5 2 3
2 {entity} 3 1
{entity} {cell}
$EndElements
$GhostElements
1
12 2 1 1
$EndGhostElements
"
    )
}

#[test]
fn a_partition_of_version_2_is_read_with_a_remark() {
    let text = SQUARE
        .replace("2 3 2 2 1 1 2 3 4", "2 3 4 2 1 1 2 1 2 3 4")
        .replace("3 3 2 2 1 2 5 6 3", "3 3 5 2 1 2 2 -1 2 5 6 3");
    let file = read(text.as_bytes()).unwrap();
    assert_eq!(file.mesh(&["block"]).unwrap().mesh.cell_count(), 2);
    let remark = "part.msh: no cell is of a partition 1: to join the files";
    assert!(
        file.warnings()[0].starts_with(remark),
        "{:?}",
        file.warnings()
    );
}

#[test]
fn version_1_has_groups_by_number_and_its_mistakes_have_lines() {
    let square = square(CellKind::Quad9, [3, 2]);
    let text = String::from_utf8(Content::of(&square, "a").write_1()).unwrap();
    let file = read(text.as_bytes()).unwrap();
    assert_eq!(file.cell_groups(), ["1"]);
    let mesh = file.mesh(&[]).unwrap().mesh;
    assert!((area(&mesh) - 1.0).abs() < 1e-14);
    // `a` and its sides in the order of their names
    assert_eq!(names(&mesh), ["2", "3", "4", "5", "boundary"]);
    assert_eq!(
        mesh.side("2").unwrap().len(),
        square.side("bottom").unwrap().len()
    );
    let line = |wanted: &str| text.lines().position(|line| line == wanted).unwrap() + 1;
    let element = text.lines().nth(line("$ELM") + 1).unwrap();
    let cases = [
        ("$ENDNOD", "", line("$ENDNOD") + 1, "expected `$ENDNOD`"),
        ("$ENDELM\n", "", line("$ENDELM"), "`$ENDELM` should be"),
        (
            element,
            &element.replacen(" 9 ", " 8 ", 1),
            line("$ELM") + 2,
            "element 1 is a quad9 and has 8 nodes",
        ),
    ];
    for (old, new, line, words) in cases {
        let error = read(text.replacen(old, new, 1).as_bytes()).unwrap_err();
        assert!(error.to_string().contains(words), "{error}");
        assert!(
            error.to_string().contains(&format!("line {line}: ")),
            "{error}"
        );
    }
    // other programs write the version's only variant, too
    let real = real("gmsh_nogroups_10.msh").mesh(&[]).unwrap().mesh;
    assert_eq!(
        real.cell_count(),
        whole("gmsh_nogroups_40.msh").mesh.cell_count()
    );
}

#[test]
fn names_of_version_2_0_are_those_of_every_dimension() {
    let text = SQUARE
        .replace("2.2 0 8", "2 0 8")
        .replace("1 1 \"bottom\"", "1\"bottom\"")
        .replace("2 2 \"block\"", "2 \"block\" of other programs");
    let file = read(text.as_bytes()).unwrap();
    assert_eq!(file.cell_groups(), ["block"]);
    assert_eq!(file.side_groups(), ["bottom"]);
    assert_eq!(file.warnings(), [""; 0]);
}

#[test]
fn other_versions_say_how_to_save_the_mesh_beside_the_file() {
    for version in ["3", "1.5", "5.2"] {
        let text = SQUARE.replace("2.2 0 8", &format!("{version} 0 8"));
        let error = read(text.as_bytes()).unwrap_err().to_string();
        assert!(
            error.contains(&format!("version {version} "))
                && error.contains("-format msh41 -o NEW.msh"),
            "{error}"
        );
    }
}

#[test]
fn a_mesh_of_space_read_for_the_plane_says_so_and_the_reverse() {
    let error = MeshFile::read(&data("gmsh_pipe_tet4_41.msh"))
        .and_then(|file| file.mesh(&[]))
        .unwrap_err()
        .to_string();
    assert!(
        error.contains("a mesh of space, with") && error.contains("`analysis = \"3d\"`"),
        "{error}"
    );
    let error = MeshFile::solid_from_bytes("part.msh", SQUARE.as_bytes())
        .unwrap_err()
        .to_string();
    assert!(
        error.contains("all at one z: a mesh of the plane") && error.contains("plane-strain"),
        "{error}"
    );
}

#[test]
fn cells_of_third_order_are_refused_by_the_body_that_has_them() {
    let file = real("gmsh_cubic_41.msh");
    assert!(
        file.warnings()
            .iter()
            .any(|w| w.contains("line of order 3 (4 nodes)"))
    );
    let error = file.mesh(&["outer"]).unwrap_err();
    assert!(
        matches!(&error, ImportError::UnsupportedCells { kind, .. } if kind == "triangle of order 3 (10 nodes)"),
        "{error}"
    );
    assert!(error.to_string().contains("tri6, quad4"), "{error}");
}

#[test]
fn vtu_files_of_meshio_hold_the_mesh_with_numbers_for_names() {
    let mesh = whole("gmsh_rings_22.msh").mesh;
    for name in [
        "meshio_rings_ascii.vtu",
        "meshio_rings_raw.vtu",
        "meshio_rings_zlib.vtu",
    ] {
        let file = real(name);
        assert_eq!(file.cell_groups(), ["10", "11"], "{name}");
        assert!(
            file.warnings()
                .iter()
                .any(|w| w.contains("`gmsh:geometrical`"))
        );
        let vtu = file.mesh(&[]).unwrap().mesh;
        for (a, b) in mesh.points().iter().zip(vtu.points()) {
            assert!(
                (a[0] - b[0]).hypot(a[1] - b[1]) < 1e-10,
                "{name}: text has 11 digits"
            );
        }
        // meshio sorts the cells by kind
        let triangles = |mesh: &Mesh<2>| {
            let block = mesh.blocks().iter().find(|b| b.kind == CellKind::Tri6);
            block.unwrap().nodes.clone()
        };
        assert_eq!(triangles(&vtu), triangles(&mesh), "{name}");
        assert_eq!(names(&vtu), ["1", "3", "4", "5", "boundary"]);
        assert_eq!(vtu.side_nodes("1"), mesh.side_nodes("bore"));
    }
    let error = MeshFile::read(&data("meshio_rings_lzma.vtu")).unwrap_err();
    assert!(error.to_string().contains("zlib"), "{error}");
}

#[test]
fn vtu_files_of_dotyk_read_back() {
    let mesh = quarter(CellKind::Quad8, 1.0, 2.0, 4);
    let mut model = Model::new();
    let elastic = Elastic {
        young: 1.0,
        poisson: 0.3,
    };
    let ring = model.body("ring", mesh.clone(), elastic);
    model
        .fix(ring, "start", [Some(0.0), Some(0.0)])
        .pull(ring, "outer", [0.0, 1e-3]);
    let solution = model.solve().unwrap();
    let folder = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join("vtu");
    let steps = std::slice::from_ref(&solution);
    let record = output::Record::of(&model, steps, "ring");
    let held = output::Folder::hold(&folder).unwrap();
    record.write(&held).unwrap();
    let file = MeshFile::read(&folder.join("ring.vtu")).unwrap();
    assert!(
        file.warnings()[0].contains("`displacement`, `stress`"),
        "{:?}",
        file.warnings()
    );
    let back = file.mesh(&[]).unwrap().mesh;
    assert_eq!(back.points(), mesh.points());
    assert_eq!(back.blocks(), mesh.blocks());
}

/// A VTU file of a square, its arrays appended: raw, or as base64.
fn appended(raw: bool, big_endian: bool) -> Vec<u8> {
    let order = |little: Vec<u8>| match big_endian {
        true => little.into_iter().rev().collect(),
        false => little,
    };
    let mut arrays: Vec<Vec<u8>> = Vec::new();
    let points = [
        0.0f32, 0.0, 2.0, 1.0, 0.0, 2.0, 1.0, 1.0, 2.0, 0.0, 1.0, 2.0,
    ];
    arrays.push(
        points
            .iter()
            .flat_map(|c| order(c.to_le_bytes().to_vec()))
            .collect(),
    );
    arrays.push(
        (0..4i32)
            .flat_map(|n| order(n.to_le_bytes().to_vec()))
            .collect(),
    );
    arrays.push(order(4i32.to_le_bytes().to_vec()));
    arrays.push(vec![9]);
    arrays.push(order(7u16.to_le_bytes().to_vec()));
    let (mut data, mut offsets) = (Vec::new(), Vec::new());
    for array in arrays {
        offsets.push(data.len());
        let mut bytes: Vec<u8> = order((array.len() as u32).to_le_bytes().to_vec());
        bytes.extend(array);
        if raw {
            data.extend(bytes);
        } else {
            data.extend(STANDARD.encode(bytes).bytes());
        }
    }
    let order = if big_endian {
        "BigEndian"
    } else {
        "LittleEndian"
    };
    let encoding = if raw { "raw" } else { "base64" };
    let array = |kind: &str, name: &str, offset: usize| {
        format!("<DataArray type='{kind}' Name='{name}' format='appended' offset='{offset}'/>\n")
    };
    let mut out = format!(
        "<VTKFile type='UnstructuredGrid' byte_order='{order}'>\n<!-- > -->\n<UnstructuredGrid>\n\
         <Piece NumberOfPoints='4' NumberOfCells='1'>\n<CellData>{}</CellData>\n<Points>{}</Points>\n<Cells>{}{}{}</Cells>\n\
         </Piece>\n</UnstructuredGrid>\n<AppendedData encoding='{encoding}'>\n_",
        array("UInt16", "group", offsets[4]),
        array("Float32", "Points", offsets[0]),
        array("Int32", "connectivity", offsets[1]),
        array("Int32", "offsets", offsets[2]),
        array("UInt8", "types", offsets[3]),
    )
    .into_bytes();
    out.extend(data);
    out.extend(b"\n</AppendedData>\n</VTKFile>\n");
    out
}

#[test]
fn appended_arrays_are_read_in_both_orders_of_bytes() {
    for (raw, big_endian) in [(true, false), (true, true), (false, false), (false, true)] {
        let file = MeshFile::from_bytes("square.vtu", &appended(raw, big_endian)).unwrap();
        let body = file.mesh(&["7"]).unwrap().mesh;
        assert_eq!(
            body.points(),
            [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]]
        );
        assert_eq!(body.blocks()[0].group.as_deref(), Some("7"));
    }
}

/// A VTU file of text with one cell.
fn one_cell(kind: u8, points: &[[f64; 3]], nodes: &str) -> String {
    let coordinates = points.iter().map(|[x, y, z]| format!("{x} {y} {z}"));
    let coordinates: Vec<String> = coordinates.collect();
    let array = |name: &str, data: &str| {
        format!("<DataArray type='Int64' Name='{name}' format='ascii'>{data}</DataArray>")
    };
    format!(
        "<VTKFile type='UnstructuredGrid'><UnstructuredGrid>\
         <Piece NumberOfPoints='{}' NumberOfCells='1'>\
         <Points><DataArray type='Float64' NumberOfComponents='3' format='ascii'>{}</DataArray></Points>\
         <Cells>{}{}{}</Cells></Piece></UnstructuredGrid></VTKFile>",
        points.len(),
        coordinates.join(" "),
        array("connectivity", nodes),
        array("offsets", &nodes.split(' ').count().to_string()),
        array("types", &kind.to_string()),
    )
}

#[test]
fn cells_along_the_axes_are_quadrilaterals_and_hexahedra() {
    let grid: Vec<[f64; 3]> = (0..8u8)
        .map(|k| {
            [
                2.0 * f64::from(k & 1),
                3.0 * f64::from(k >> 1 & 1),
                5.0 * f64::from(k >> 2),
            ]
        })
        .collect();
    let pixel = one_cell(8, &grid[..4], "0 1 2 3");
    let pixel = MeshFile::from_bytes("pixel.vtu", pixel.as_bytes()).unwrap();
    let pixel = pixel.mesh(&[]).unwrap().mesh;
    assert_eq!(pixel.blocks()[0].kind, CellKind::Quad4);
    assert!((area(&pixel) / 6.0 - 1.0).abs() < 1e-14);
    let voxel = one_cell(11, &grid, "0 1 2 3 4 5 6 7");
    let voxel = MeshFile::solid_from_bytes("voxel.vtu", voxel.as_bytes()).unwrap();
    let voxel = voxel.solid(&[]).unwrap().mesh;
    assert_eq!(voxel.blocks()[0].kind, CellKind::Hex8);
    assert!((volume(&voxel) / 30.0 - 1.0).abs() < 1e-14);
    // Lagrange's cells of first order are those, too
    let lagrange = one_cell(72, &grid, "0 1 3 2 4 5 7 6");
    let lagrange = MeshFile::solid_from_bytes("lagrange.vtu", lagrange.as_bytes()).unwrap();
    assert_eq!(lagrange.solid(&[]).unwrap().mesh, voxel);
}

#[test]
fn cells_that_no_mesh_has_are_refused_by_name() {
    let points = [
        [0.0, 0.0, 0.0],
        [1.0, 0.0, 0.0],
        [1.0, 1.0, 0.0],
        [0.0, 1.0, 0.0],
        [0.5, 0.5, 1.0],
    ];
    let cases = [
        (14, "0 1 2 3 4", "pyramid5"),
        (14, "0 1 2 3 4", "tied by a [[contact]]"),
        (42, "0 1 2 3 4", "polyhedron"),
        (41, "0 1 2 3", "convex set of points"),
        (72, "0 1 2 3 4", "hexahedron of Lagrange"),
    ];
    for (kind, nodes, words) in cases {
        let text = one_cell(kind, &points, nodes);
        let file = MeshFile::solid_from_bytes("cell.vtu", text.as_bytes()).unwrap();
        let error = file.solid(&[]).unwrap_err().to_string();
        assert!(error.contains(words), "{error}");
    }
    // a hexahedron whose nodes meet in the tip of a pyramid
    let text = one_cell(12, &points, "0 1 2 3 4 4 4 4");
    let file = MeshFile::solid_from_bytes("cell.vtu", text.as_bytes()).unwrap();
    let error = file.solid(&[]).unwrap_err().to_string();
    assert!(error.contains("names node 4 twice"), "{error}");
    // points and lines of any length are left out
    let text = one_cell(2, &points, "");
    let error = MeshFile::from_bytes("cell.vtu", text.as_bytes()).unwrap_err();
    assert!(error.to_string().contains("cell.vtu"), "{error}");
}

#[test]
fn entities_of_a_document_are_not_expanded() {
    let laughs = "<!DOCTYPE VTKFile [<!ENTITY a 'ha'><!ENTITY b '&a;&a;&a;&a;'>]>\n";
    let grid = "<VTKFile type='UnstructuredGrid'>\n<Piece NumberOfPoints='&b;' NumberOfCells='1'/></VTKFile>";
    let error = MeshFile::from_bytes("laughs.vtu", format!("{laughs}{grid}").as_bytes());
    let error = error.unwrap_err().to_string();
    assert!(error.starts_with("laughs.vtu, a tag, byte 98:"), "{error}");
}

/// A text of version 2.2 with one square, which the cases below spoil.
const SQUARE: &str = "$MeshFormat
2.2 0 8
$EndMeshFormat
$PhysicalNames
2
1 1 \"bottom\"
2 2 \"block\"
$EndPhysicalNames
$Nodes
6
1 0 0 0
2 1 0 0
3 1 1 0
4 0 1 0
5 2 0 0
6 2 1 0
$EndNodes
$Elements
3
1 1 2 1 1 1 2
2 3 2 2 1 1 2 3 4
3 3 2 2 1 2 5 6 3
$EndElements
";

#[test]
fn mistakes_are_named_with_their_line() {
    assert_eq!(
        read(SQUARE.as_bytes())
            .unwrap()
            .mesh(&["block"])
            .unwrap()
            .mesh
            .cell_count(),
        2
    );
    let cases = [
        ("2.2 0 8", "3.0 0 8", None, "version 3 "),
        (
            "2.2 0 8",
            "2.2 2 8",
            Some(2),
            "0 (text) or 1 (binary), found 2",
        ),
        (
            "\"bottom\"",
            "bottom",
            Some(6),
            "quotation marks, found `bottom`",
        ),
        (
            "$Nodes\n6",
            "$Nodes\n7",
            Some(17),
            "fewer entries than its counts",
        ),
        (
            "$Nodes\n6",
            "$Nodes\n5",
            Some(16),
            "more entries than its counts",
        ),
        (
            "3 1 1 0",
            "3 1 one 0",
            Some(13),
            "a coordinate, found `one`",
        ),
        ("3 1 1 0", "3 1 nan 0", Some(13), "finite"),
        ("3 1 1 0", "2 1 1 0", Some(13), "node 2 is given twice"),
        ("3 1 1 0", "-3 1 1 0", Some(13), "positive, found -3"),
        (
            "$Elements\n3",
            "$Elements\n4",
            Some(23),
            "fewer entries than its counts",
        ),
        (
            "2 3 2 2 1 1 2 3 4",
            "2 3 2 2 1 1 2 3 9",
            Some(21),
            "node 9, which `$Nodes` does not have",
        ),
        (
            "2 3 2 2 1 1 2 3 4",
            "2 77 2 2 1 1 2 3 4",
            Some(21),
            "element type 77",
        ),
        (
            "$EndElements\n",
            "",
            Some(23),
            "the file ends where `$EndElements` should be",
        ),
        (
            "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n",
            "",
            Some(1),
            "$MeshFormat",
        ),
        (
            "$Elements",
            "garbage\n$Elements",
            Some(18),
            "expected a section",
        ),
    ];
    for (old, new, line, words) in cases {
        assert!(SQUARE.contains(old));
        let error = read(SQUARE.replacen(old, new, 1).as_bytes()).unwrap_err();
        let place = match &error {
            ImportError::Malformed {
                place: FilePlace::Line(line),
                ..
            } => Some(*line),
            _ => None,
        };
        assert_eq!(place, line, "{error}");
        let text = error.to_string();
        assert!(text.contains(words) && text.contains("part.msh"), "{text}");
    }
}

#[test]
fn what_makes_no_body_is_said() {
    let cases = [
        ("5 2 0 0", "5 2 0 1", "z runs from 0 to 1"),
        (
            "5 2 0 0",
            "5 1 2 0",
            "part.msh, element 3: cell 1 of block 0",
        ),
        ("2 3 2 2 1 1 2 3 4", "2 3 2 2 1 1 2 3 3", "element 2"),
        (
            "2 3 2 2 1 1 2 3 4\n3 3 2 2 1 2 5 6 3",
            "2 2 2 2 1 1 2 3\n3 9 2 2 1 1 2 3 4 5 6",
            "the elements 2 and 3 have the same corners",
        ),
    ];
    for (old, new, words) in cases {
        assert!(SQUARE.contains(old));
        let file = read(SQUARE.replacen(old, new, 1).as_bytes());
        let error = file
            .and_then(|file| file.mesh(&["block"]))
            .unwrap_err()
            .to_string();
        assert!(error.contains(words), "{error}");
    }
    let lines = SQUARE
        .replace("2 3 2 2 1 1 2 3 4\n3 3 2 2 1 2 5 6 3\n", "")
        .replace("$Elements\n3", "$Elements\n1");
    let error = read(lines.as_bytes()).unwrap_err().to_string();
    assert!(
        error.contains("no cells of the plane") && error.contains("1 edges"),
        "{error}"
    );
    // a quadratic triangle beside the square, and beside two linear triangles that have its middle node
    let hanging = SQUARE
        .replace("$Nodes\n6", "$Nodes\n9")
        .replace("6 2 1 0", "6 2 1 0\n7 1.5 0 0\n8 1.5 0.5 0\n9 1 0.5 0")
        .replace("3 3 2 2 1 2 5 6 3", "3 9 2 2 1 2 5 3 7 8 9");
    let halves = hanging
        .replace("$Elements\n3", "$Elements\n4")
        .replace("2 3 2 2 1 1 2 3 4", "2 2 2 2 1 1 2 9\n4 2 2 2 1 1 9 3");
    for (text, elements) in [(hanging, "2, 3"), (halves, "2, 3, 4")] {
        let error = read(text.as_bytes()).unwrap().mesh(&[]).unwrap_err();
        let words = format!("the elements {elements} do not fit together at one edge");
        assert!(error.to_string().contains(&words), "{error}");
    }
    let error = read(SQUARE.as_bytes())
        .unwrap()
        .mesh(&["blok"])
        .unwrap_err();
    assert!(
        error
            .to_string()
            .contains("no group of cells `blok`; it has block"),
        "{error}"
    );
    let error = MeshFile::read(&data("no-such.msh")).unwrap_err();
    assert!(error.to_string().contains("no such file"), "{error}");
    let error = read(b"solid ascii").unwrap_err();
    assert!(error.to_string().contains("neither a Gmsh mesh"), "{error}");
}

#[test]
fn what_is_left_out_is_reported() {
    let text = SQUARE
        .replace("$Elements\n3", "$Elements\n7")
        .replace(
            "$EndElements",
            "4 15 2 9 1 1\n5 4 2 9 1 1 2 3 5\n6 3 2 2 1 1 2 3 4\n7 1 2 4 1 1 3\n$EndElements\n$Periodic\n0\n$EndPeriodic\n$NodeData\n$EndNodeData",
        )
        .replace("6 2 1 0", "6 2 1 0\n7 9 9 9")
        .replace("$Nodes\n6", "$Nodes\n7")
        .replace("2 2 \"block\"", "2 2 \"block\"\n1 8 \"nowhere\"")
        .replace("$PhysicalNames\n2", "$PhysicalNames\n3");
    let file = read(text.as_bytes()).unwrap();
    let warnings = file.warnings().join("\n");
    for words in [
        "section $Periodic is left out",
        "section $NodeData is left out",
        "1 elements of the kind tet4 are left out",
        "1 repeated cells are left out",
        "groups without elements: `nowhere`",
        "1 edges of the group `4` belong to no cell",
        "1 nodes belong to no cell",
    ] {
        assert!(warnings.contains(words), "{words}\n{warnings}");
    }
    assert_eq!(file.warnings().len(), 7, "{warnings}");
    let imported = file.mesh(&[]).unwrap();
    assert_eq!(imported.mesh.cell_count(), 2);
    assert_eq!(imported.points["9"].len(), 1);
}

#[test]
fn groups_of_points_name_nodes_of_the_body() {
    let text = SQUARE
        .replace("$Elements\n3", "$Elements\n7")
        .replace(
            "$EndElements",
            "4 15 2 9 1 1\n5 15 2 9 1 3\n6 15 2 7 1 7\n7 15 2 9 1 1\n$EndElements",
        )
        .replace("6 2 1 0", "6 2 1 0\n7 9 9 9")
        .replace("$Nodes\n6", "$Nodes\n7")
        .replace(
            "2 2 \"block\"",
            "2 2 \"block\"\n0 9 \"two corners\"\n0 7 \"off\"",
        )
        .replace("$PhysicalNames\n2", "$PhysicalNames\n4");
    let file = read(text.as_bytes()).unwrap();
    assert_eq!(file.point_groups(), ["off", "two_corners"]);
    assert!(
        file.warnings()
            .iter()
            .any(|w| w.contains("is called `two_corners`"))
    );
    let imported = file.mesh(&[]).unwrap();
    let points = imported.mesh.points();
    assert_eq!(imported.points["two_corners"], [points[0], points[2]]);
    assert_eq!(imported.points.len(), 1);
    assert_eq!(imported.unused_points, ["off"]);
}

#[test]
fn a_cell_in_two_groups_has_no_group_of_its_own() {
    // version 2.2 writes an element once for each of its groups
    let text = SQUARE
        .replace("$Elements\n3", "$Elements\n4")
        .replace("$EndElements", "4 3 2 3 1 2 5 6 3\n$EndElements");
    let file = read(text.as_bytes()).unwrap();
    assert_eq!(file.warnings(), [""; 0]);
    assert_eq!(file.mesh(&["3"]).unwrap().mesh.cell_count(), 1);
    assert_eq!(file.mesh(&["block"]).unwrap().mesh.cell_count(), 2);
    let all = file.mesh(&[]).unwrap();
    assert!(
        all.warnings[0].contains("`block`, `3`"),
        "{:?}",
        all.warnings
    );
    let groups: Vec<_> = all
        .mesh
        .blocks()
        .iter()
        .map(|b| b.group.as_deref())
        .collect();
    assert_eq!(groups, [Some("block"), None]);
    let error = file.mesh(&["block", "3"]).unwrap_err();
    assert!(
        matches!(error, ImportError::TwoGroups { element: 3, .. }),
        "{error}"
    );
}

#[test]
fn a_file_that_is_cut_off_or_spoilt_is_an_error_and_never_a_panic() {
    let files = [
        "gmsh_rings_41.msh",
        "gmsh_rings_41b.msh",
        "gmsh_rings_22b.msh",
        "gmsh_nogroups_40.msh",
        "gmsh_nogroups_10.msh",
        "gmsh_partitioned_41.msh",
        "meshio_rings_raw.vtu",
        "meshio_rings_zlib.vtu",
    ];
    for name in files {
        let bytes = std::fs::read(data(name)).unwrap();
        // the last line end may be missing
        for cut in (0..bytes.len() - 1)
            .step_by(7)
            .chain(bytes.len() - 20..bytes.len() - 2)
        {
            assert!(read(&bytes[..cut]).is_err(), "{name} cut at {cut}");
        }
        for at in 0..bytes.len() {
            for value in [0xff, b'9', 0] {
                let mut spoilt = bytes.clone();
                spoilt[at] = value;
                // some bytes mean nothing, and other numbers may be as good
                let _ = read(&spoilt).and_then(|file| file.mesh(&[]));
            }
        }
    }
}

#[test]
fn errors_of_binary_files_name_section_and_byte() {
    let bytes = std::fs::read(data("gmsh_rings_41b.msh")).unwrap();
    let error = read(&bytes[..3000]).unwrap_err();
    let ImportError::Malformed { place, .. } = &error else {
        panic!("{error}")
    };
    assert_eq!(
        *place,
        FilePlace::Byte {
            section: "section $Nodes".to_string(),
            offset: 3000
        }
    );
    assert!(error.to_string().contains("cut off"), "{error}");
}

fn case(bodies: &str) -> Result<Case<2>, CaseError> {
    let text = format!("analysis = \"plane-stress\"\n{bodies}");
    Case::<2>::from_str(&text, "case.toml", &data(""))
}

const STEEL: &str = "material = { young = 210e3, poisson = 0.3 }";

#[test]
fn a_case_cuts_bodies_out_of_a_file_and_says_what_is_left() {
    let both = format!(
        "[[body]]\nname = \"inner\"\nmesh = {{ file = {{ path = \"gmsh_rings_41.msh\", group = \"inner ring\" }} }}\n{STEEL}\n\
         [[body]]\nname = \"outer\"\nmesh = {{ file = {{ path = \"gmsh_rings_41.msh\", group = \"outer\" }} }}\n{STEEL}\n\
         [[contact]]\nname = \"fit\"\nsides = [\"inner.fit\", \"outer.fit\"]\n"
    );
    let case_of_both = case(&both).unwrap();
    assert_eq!(case_of_both.model.bodies.len(), 2);
    // the file's own remarks, once
    assert_eq!(case_of_both.warnings, real("gmsh_rings_41.msh").warnings());
    let one = both.split("[[body]]\nname = \"outer\"").next().unwrap();
    let warnings = case(one).unwrap().warnings;
    assert!(
        warnings
            .iter()
            .any(|w| w.contains("no body has the groups of cells `outer`")),
        "{warnings:?}"
    );
    assert!(
        warnings
            .iter()
            .any(|w| w.contains("`rim` are on the boundary of no body")),
        "{warnings:?}"
    );
}

#[test]
fn a_case_points_at_the_file_or_group_that_is_wrong() {
    let body = |file: &str, material: &str| {
        case(&format!(
            "[[body]]\nname = \"b\"\nmesh = {{ file = {{ {file} }} }}\nmaterial = {material}\n"
        ))
        .unwrap_err()
    };
    let steel = "{ young = 1, poisson = 0 }";
    let path = "path = \"gmsh_rings_41.msh\"";
    let cases = [
        (
            "path = \"no.msh\"".to_string(),
            steel,
            "\"no.msh\"",
            "no such file",
        ),
        ("path = 7".to_string(), steel, "7", "expected a string"),
        (
            "group = \"outer\"".to_string(),
            steel,
            "{ group = \"outer\" }",
            "`path`",
        ),
        (format!("{path}, grup = \"a\""), steel, "grup", "`grup`"),
        (
            format!("{path}, group = [\"outer\", \"iner\"]"),
            steel,
            "\"iner\"",
            "no group of cells `iner`",
        ),
        (
            format!("{path}, group = []"),
            steel,
            "[]",
            "a list of names",
        ),
        (
            "path = \"gmsh_cubic_41.msh\"".to_string(),
            steel,
            "\"gmsh_cubic_41.msh\"",
            "triangle of order 3 (10 nodes)",
        ),
        (
            path.to_string(),
            "{ group = \"outer\", young = 1, poisson = 0 }",
            "{ group",
            "no material for its cells of `inner_ring`",
        ),
        (
            path.to_string(),
            "[{ group = \"oter\", young = 1, poisson = 0 }]",
            "\"oter\"",
            "no group of cells `oter`",
        ),
    ];
    for (file, material, place, words) in cases {
        let error = body(&file, material);
        let text = &error.source_text[error.span.clone().unwrap()];
        assert!(text.starts_with(place), "{error}: {text}");
        assert!(error.message.contains(words), "{error}");
    }
    let error = body(&format!("{path}, group = \"inner\""), steel);
    assert!(
        error.label.contains("`outer`") || error.label.contains("`inner_ring`"),
        "{}",
        error.label
    );
}

#[test]
fn each_group_has_its_material_and_one_without_group_serves_the_rest() {
    let text = "[[body]]\nname = \"b\"\nmesh = { file = { path = \"gmsh_rings_41.msh\" } }\n\
                material = [{ young = 1, poisson = 0 }, { group = \"outer\", young = 2, poisson = 0 }]\n";
    let case = case(text).unwrap();
    let materials = &case.model.bodies[0].materials;
    let found: Vec<_> = materials
        .iter()
        .map(|m| (m.group.as_deref(), m.elastic.young))
        .collect();
    // the first that fits is taken
    assert_eq!(found, [(Some("outer"), 2.0), (None, 1.0)]);
}

/// Lamé in plane stress: u(b) of the inner ring under p at a and q at b, and of the outer ring under q at b, agree.
#[test]
fn two_materials_in_one_body_share_the_load_as_lame_says() {
    let folder = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../cases/press-fit-gmsh");
    let (inner, outer, nu) = (1000.0, 3000.0, 0.3);
    let text = format!(
        "analysis = \"plane-stress\"\n[[body]]\nname = \"b\"\n\
         mesh = {{ file = {{ path = \"rings.msh\", group = [\"inner\", \"outer\"] }} }}\n\
         material = [{{ group = \"inner\", young = {inner}, poisson = {nu} }}, {{ group = \"outer\", young = {outer}, poisson = {nu} }}]\n\
         fix = [{{ side = \"on-x\", y = 0 }}, {{ side = \"on-y\", x = 0 }}]\n\
         load = [{{ side = \"bore\", pressure = 1.0 }}]\n\
         [[probe]]\nname = \"u\"\nquantity = \"b.displacement.x\"\nat = [40, 0]\n"
    );
    let case = Case::<2>::from_str(&text, "case.toml", &folder).unwrap();
    let found = case.model.solve().unwrap().probes[0].value;
    let [a2, b2, c2] = [20.0f64, 40.0, 80.0].map(|r| r * r);
    let b = 40.0;
    let under_q = b * ((1.0 - nu) * b2 + (1.0 + nu) * a2) / (inner * (b2 - a2));
    let under_p = 2.0 * a2 * b / (inner * (b2 - a2));
    let outside = b * ((1.0 - nu) * b2 + (1.0 + nu) * c2) / (outer * (c2 - b2));
    let expected = outside * under_p / (under_q + outside);
    // quadratic cells of h/r = 1/4 at the bore: (h/r)^4
    assert!(
        (found / expected - 1.0).abs() < 0.004,
        "{found} instead of {expected}"
    );
}
