//! `mesh` of a body: generators, files, and sides that are parts of others.

use crate::case::body::side;
use crate::case::document::{Entry, Node, Span, Table, check_name};
use crate::case::error::Fault;
use crate::case::given::GivenMesh;
use crate::case::mesh_file::{MeshFiles, Named};
use crate::case::suggest::listed;
use crate::case::{keys, outline};
use crate::host::{free_memory, team, told};
use crate::mesh::{
    CellKind, Cuboid, Cylinder, Diagonals, Extrude, ImportError, Imported, Mesh, MeshError,
    MeshFile, Path, Rectangle, Ring, Sphere, TunnelRock, pieces,
};
use crate::model::least;

/// Bytes that every machine has.
const ALWAYS_THERE: u64 = 10_000_000;

/// A side that every mesh has for patches: its whole boundary.
const BOUNDARY: &str = "boundary";

/// Most cells of a generated mesh: a misplaced digit must not exhaust the memory, and no direct factor of a larger one fits it.
const MOST_CELLS: usize = 5_000_000;

const CELLS_OF_THE_PLANE: [(&str, CellKind); 5] = [
    ("tri3", CellKind::Tri3),
    ("tri6", CellKind::Tri6),
    ("quad4", CellKind::Quad4),
    ("quad8", CellKind::Quad8),
    ("quad9", CellKind::Quad9),
];

const CELLS_OF_SPACE: [(&str, CellKind); 8] = [
    ("tet4", CellKind::Tet4),
    ("tet10", CellKind::Tet10),
    ("hex8", CellKind::Hex8),
    ("hex20", CellKind::Hex20),
    ("hex27", CellKind::Hex27),
    ("prism6", CellKind::Prism6),
    ("prism15", CellKind::Prism15),
    ("prism18", CellKind::Prism18),
];

const DIAGONALS: [(&str, Diagonals); 5] = [
    ("checkerboard", Diagonals::Checkerboard),
    ("checkerboard-odd", Diagonals::CheckerboardOdd),
    ("mirrored", Diagonals::Mirrored),
    ("forward", Diagonals::Forward),
    ("backward", Diagonals::Backward),
];

/// Meshes of D dimensions as a case file makes them.
pub(crate) trait Generated<const D: usize>: Sized {
    /// Keys of `mesh` that make one.
    const GENERATORS: &'static [&'static str];

    /// The mesh that one of these keys but `file` makes, and the points that a mesh file within it names.
    fn generated(entry: &Entry, body: &str, files: &mut MeshFiles) -> Result<Made<D>, Fault>;

    /// An existing mesh and its named points; `None` if it has another dimension.
    fn given(mesh: &GivenMesh) -> Option<(Self, Named<D>)>;

    /// A mesh file for such bodies.
    fn read(path: &std::path::Path) -> Result<MeshFile, ImportError>;

    /// The content of a mesh file for such bodies, which messages call `name`.
    fn from_bytes(name: &str, bytes: &[u8]) -> Result<MeshFile, ImportError>;

    /// A body of some groups of it.
    fn cut(file: &MeshFile, groups: &[&str]) -> Result<Imported<D>, ImportError>;
}

/// A mesh or its error, and named points.
pub(crate) type Made<const D: usize> = (Result<Mesh<D>, MeshError>, Named<D>);

impl Generated<2> for Mesh<2> {
    const GENERATORS: &'static [&'static str] = &[
        "rectangle",
        "ring",
        "tunnel_rock",
        "outline",
        "region",
        "file",
    ];

    fn generated(entry: &Entry, body: &str, files: &mut MeshFiles) -> Result<Made<2>, Fault> {
        let node = &entry.node;
        let built = match entry.key.as_str() {
            "rectangle" => rectangle(node)?.build(),
            "ring" => ring(node)?.build(),
            "tunnel_rock" => tunnel_rock(node)?.build(),
            "region" => Ok(files.regions(node, body)?),
            _ => Ok(outline::mesh(node, body)?),
        };
        Ok((built, Named::new()))
    }

    fn given(mesh: &GivenMesh) -> Option<(Self, Named<2>)> {
        match mesh {
            GivenMesh::Plane(mesh, points) => Some((Self::clone(mesh), points.clone())),
            GivenMesh::Space(..) => None,
        }
    }

    fn read(path: &std::path::Path) -> Result<MeshFile, ImportError> {
        MeshFile::read(path)
    }

    fn from_bytes(name: &str, bytes: &[u8]) -> Result<MeshFile, ImportError> {
        MeshFile::from_bytes(name, bytes)
    }

    fn cut(file: &MeshFile, groups: &[&str]) -> Result<Imported<2>, ImportError> {
        file.mesh(groups)
    }
}

impl Generated<3> for Mesh<3> {
    const GENERATORS: &'static [&'static str] = &["box", "cylinder", "sphere", "extrude", "file"];

    fn generated(entry: &Entry, body: &str, files: &mut MeshFiles) -> Result<Made<3>, Fault> {
        let node = &entry.node;
        let built = match entry.key.as_str() {
            "extrude" => return extrude(node, body, files),
            "cylinder" => cylinder(node)?.build(),
            "sphere" => sphere(node)?.build(),
            _ => cuboid(node)?.build(),
        };
        Ok((built, Named::new()))
    }

    fn given(mesh: &GivenMesh) -> Option<(Self, Named<3>)> {
        match mesh {
            GivenMesh::Space(mesh, points) => Some((Self::clone(mesh), points.clone())),
            GivenMesh::Plane(..) => None,
        }
    }

    fn read(path: &std::path::Path) -> Result<MeshFile, ImportError> {
        MeshFile::read_solid(path)
    }

    fn from_bytes(name: &str, bytes: &[u8]) -> Result<MeshFile, ImportError> {
        MeshFile::solid_from_bytes(name, bytes)
    }

    fn cut(file: &MeshFile, groups: &[&str]) -> Result<Imported<3>, ImportError> {
        file.solid(groups)
    }
}

/// The mesh, and the points that a mesh file names; `needed` is the reason for D dimensions.
pub(crate) fn mesh<const D: usize>(
    node: &Node,
    body: &str,
    needed: &str,
    files: &mut MeshFiles,
) -> Result<(Mesh<D>, Named<D>), Fault>
where
    Mesh<D>: Generated<D>,
{
    let table = node.table(keys::MESH)?;
    let generators: Vec<&Entry> = keys::MESH
        .iter()
        .filter(|key| **key != "sides")
        .filter_map(|key| table.entry(key))
        .collect();
    let known = || listed(Mesh::<D>::GENERATORS.iter().copied());
    let [generator] = generators[..] else {
        let message = match generators.len() {
            0 => format!("the mesh of body `{body}` has no generator"),
            _ => format!("the mesh of body `{body}` has more than one generator"),
        };
        return Err(Fault::new(table.span, message)
            .label("exactly one is needed")
            .help(format!("give exactly one of {}", known())));
    };
    if !Mesh::<D>::GENERATORS.contains(&generator.key.as_str()) {
        let other = 5 - D;
        let message = format!("`{}` makes {other}D meshes, and {needed}", generator.key);
        return Err(Fault::new(&generator.key_span, message)
            .label(format!("a {other}D mesh"))
            .help(format!("{D}D meshes: {}", known())));
    }
    let (built, points) = match generator.key.as_str() {
        "file" => {
            let (mesh, points) = files.mesh(&generator.node, body)?;
            (Ok(mesh), points)
        }
        _ => Mesh::<D>::generated(generator, body, files)?,
    };
    let invalid = |e: MeshError, span: &Span| {
        Fault::new(span, format!("the mesh of body `{body}`: {e}")).label("cannot be built")
    };
    let mut mesh = built.map_err(|e| invalid(e, &generator.key_span))?;
    for patch in table.get("sides").map_or(Ok(&[][..]), Node::entries)? {
        check_name(&patch.key, &patch.key_span)?;
        let keys = patch.node.table(keys::PATCH)?;
        if mesh.side(&patch.key).is_some() {
            let message = format!("body `{body}` has a side `{}` already", patch.key);
            return Err(Fault::new(&patch.key_span, message).label("second use of the name"));
        }
        let of = keys.require("of", "a patch")?;
        if matches!(of.text(), Ok(BOUNDARY)) && mesh.side(BOUNDARY).is_none() {
            mesh = mesh.with_side(BOUNDARY, |_| true);
        }
        let of = side(of, body, &mut mesh)?;
        let min = keys.require("min", "a patch")?.point()?;
        let max = keys.require("max", "a patch")?.point()?;
        mesh = mesh
            .with_patch(&patch.key, &of, min, max)
            .map_err(|e| invalid(e, &patch.key_span))?;
    }
    Ok((mesh, points))
}

fn rectangle(node: &Node) -> Result<Rectangle, Fault> {
    let table = node.table(keys::RECTANGLE)?;
    let (what, cell) = ("a rectangle", cell(table, 2)?);
    Ok(Rectangle {
        from: table.require("from", what)?.point()?,
        to: table.require("to", what)?.point()?,
        cells: lattice(table, what, cell)?,
        cell,
        diagonals: diagonals(table)?,
    })
}

fn ring(node: &Node) -> Result<Ring, Fault> {
    let table = node.table(keys::RING)?;
    let (what, cell) = ("a ring", cell(table, 2)?);
    let angles = angles(table, what)?;
    Ok(Ring {
        center: table.get("center").map_or(Ok([0.0; 2]), Node::point)?,
        inner: table.require("inner", what)?.positive("the inner radius")?,
        outer: table.require("outer", what)?.positive("the outer radius")?,
        angles,
        cells: lattice(table, what, cell)?,
        ratio: growth(table, "ratio")?,
        grade: growth(table, "grade")?,
        cell,
        diagonals: diagonals(table)?,
    })
}

fn tunnel_rock(node: &Node) -> Result<TunnelRock, Fault> {
    let table = node.table(keys::TUNNEL_ROCK)?;
    let (what, cell) = ("tunnel rock", cell(table, 2)?);
    let length = |key: &str| table.require(key, what)?.positive(&format!("`{key}`"));
    Ok(TunnelRock {
        radius: length("radius")?,
        half_width: length("half_width")?,
        half_height: length("half_height")?,
        cells: lattice(table, what, cell)?,
        ratio: growth(table, "ratio")?,
        grade: growth(table, "grade")?,
        cell,
        diagonals: diagonals(table)?,
    })
}

fn cuboid(node: &Node) -> Result<Cuboid, Fault> {
    let table = node.table(keys::BOX)?;
    let (what, cell) = ("a box", cell(table, 3)?);
    Ok(Cuboid {
        from: table.require("from", what)?.point()?,
        to: table.require("to", what)?.point()?,
        cells: lattice(table, what, cell)?,
        cell,
    })
}

/// Numbers of the squares or hexahedra of a lattice that is cut into these cells.
fn lattice<const N: usize>(
    table: Table<'_>,
    what: &str,
    cell: CellKind,
) -> Result<[usize; N], Fault> {
    let counts = cells(table, what)?;
    let all = counts.iter().map(|&n| n as u128);
    few_enough::<N>(table, all.fold(pieces(cell), u128::saturating_mul), cell)?;
    Ok(counts)
}

fn cells<const N: usize>(table: Table<'_>, what: &str) -> Result<[usize; N], Fault> {
    let node = table.require("cells", what)?;
    node.counts("the number of cells")
}

/// Refuses, before any memory is allocated, meshes that do not fit the memory of any machine or of this one.
fn few_enough<const D: usize>(table: Table<'_>, cells: u128, kind: CellKind) -> Result<(), Fault> {
    let message = if cells > MOST_CELLS as u128 {
        format!("more than {MOST_CELLS} cells in one body")
    } else {
        // several processes may share it out
        let needed = least::<D>(kind, cells as u64) / team().size() as u64;
        // the query takes longer than a small mesh
        let free = (needed > ALWAYS_THERE).then(free_memory).flatten();
        match free.filter(|&free| needed > free) {
            None => return Ok(()),
            Some(free) => format!(
                "{} of memory are needed at least, and {} are free",
                told(needed),
                told(free)
            ),
        }
    };
    let span = table.get("cells").map_or(table.span, |node| &node.span);
    Err(Fault::new(span, message).label(format!("{cells} cells")))
}

fn growth(table: Table<'_>, key: &str) -> Result<f64, Fault> {
    let name = format!("`{key}`");
    table.get(key).map_or(Ok(1.0), |node| node.positive(&name))
}

/// A kind of cells of a dimension; by default four or eight corners.
fn cell(table: Table<'_>, dimension: usize) -> Result<CellKind, Fault> {
    let [own, other] = match dimension {
        2 => [&CELLS_OF_THE_PLANE[..], &CELLS_OF_SPACE],
        _ => [&CELLS_OF_SPACE[..], &CELLS_OF_THE_PLANE],
    };
    let Some(node) = table.get("cell") else {
        return Ok(if dimension == 2 {
            CellKind::Quad4
        } else {
            CellKind::Hex8
        });
    };
    let text = node.text()?;
    if other.iter().any(|(name, _)| *name == text) {
        let message = format!("`{text}` is a cell of {}D meshes", 5 - dimension);
        let known = own.iter().map(|(name, _)| *name);
        return Err(Fault::new(&node.span, message)
            .label(format!("a {}D cell", 5 - dimension))
            .help(format!("cells of {dimension}D meshes: {}", listed(known))));
    }
    node.choice("cell", own)
}

fn diagonals(table: Table<'_>) -> Result<Diagonals, Fault> {
    let node = table.get("diagonals");
    node.map_or(Ok(Diagonals::default()), |node| {
        node.choice("pattern of diagonals", &DIAGONALS)
    })
}

/// Both ends of a part of a turn, in degrees; `None`: the full one.
fn angles(table: Table<'_>, what: &str) -> Result<Option<[f64; 2]>, Fault> {
    match (table.entry("from"), table.entry("to")) {
        (None, None) => Ok(None),
        (Some(from), Some(to)) => Ok(Some([from.node.number()?, to.node.number()?])),
        (Some(one), None) | (None, Some(one)) => {
            let message = format!("a part of {what} needs both `from` and `to`");
            Err(Fault::new(&one.key_span, message)
                .label("the other angle is missing")
                .help("without `from` and `to` it is full"))
        }
    }
}

/// A radius that may be zero.
fn inner(table: Table<'_>) -> Result<f64, Fault> {
    let Some(node) = table.get("inner") else {
        return Ok(0.0);
    };
    match node.number()? {
        radius if radius >= 0.0 => Ok(radius),
        _ => Err(Fault::new(&node.span, "the inner radius must not be negative").label("not ≥ 0")),
    }
}

fn cylinder(node: &Node) -> Result<Cylinder, Fault> {
    let table = node.table(keys::CYLINDER_MESH)?;
    let what = "a cylinder";
    let cylinder = Cylinder {
        base: table.require("base", what)?.point()?,
        axis: table.require("axis", what)?.point()?,
        radius: table.require("radius", what)?.positive("the radius")?,
        inner: inner(table)?,
        height: table.require("height", what)?.positive("the height")?,
        angles: angles(table, what)?,
        cells: cells(table, what)?,
        cell: cell(table, 3)?,
    };
    few_enough::<3>(table, cylinder.cell_count(), cylinder.cell)?;
    Ok(cylinder)
}

fn sphere(node: &Node) -> Result<Sphere, Fault> {
    let table = node.table(keys::SPHERE_MESH)?;
    let what = "a sphere";
    let polar = |key: &str, default: f64| table.get(key).map_or(Ok(default), Node::number);
    let sphere = Sphere {
        center: table.require("center", what)?.point()?,
        radius: table.require("radius", what)?.positive("the radius")?,
        inner: inner(table)?,
        angles: [polar("from", 0.0)?, polar("to", 180.0)?],
        cells: cells(table, what)?,
        cell: cell(table, 3)?,
    };
    few_enough::<3>(table, sphere.cell_count(), sphere.cell)?;
    Ok(sphere)
}

/// A plane mesh carried along z or around an axis; its named points are where that begins.
fn extrude(node: &Node, body: &str, files: &mut MeshFiles) -> Result<Made<3>, Fault> {
    let table = node.table(keys::EXTRUDE)?;
    let what = "an extruded mesh";
    let plane = table.require("mesh", what)?;
    let (plane, points) = mesh::<2>(plane, body, "`extrude` takes 2D ones", files)?;
    let path = match (table.entry("height"), table.entry("turn")) {
        (Some(entry), None) => Path::Straight(not_zero(&entry.node, "the height")?),
        (None, Some(entry)) => {
            let turn = entry.node.table(keys::TURN)?;
            Path::Turn {
                point: turn.require("point", "a turn")?.point()?,
                axis: turn.require("axis", "a turn")?.point()?,
                angle: not_zero(turn.require("angle", "a turn")?, "the angle")?,
            }
        }
        (Some(_), Some(entry)) => {
            let message = format!("{what} has both `height` and `turn`");
            return Err(Fault::new(&entry.key_span, message).label("give one of the two"));
        }
        (None, None) => {
            let message = format!("{what} needs `height` or `turn`");
            return Err(Fault::new(table.span, message).label("neither `height` nor `turn`"));
        }
    };
    let layers = table.require("layers", what)?;
    let layers = layers.positive_integer("the number of layers")?;
    let cells = layers as u128 * plane.cell_count() as u128;
    few_enough::<3>(table, cells, CellKind::Prism6)?;
    let offset = table.get("offset").map_or(Ok(0.0), Node::number)?;
    let solid = Extrude {
        mesh: plane,
        path,
        layers,
        offset,
    };
    let named = points.into_iter().map(|(name, places)| {
        let feet = places.into_iter().map(|place| solid.foot(place));
        (name, feet.collect())
    });
    let named = named.collect();
    Ok((solid.build(), named))
}

/// A finite number other than zero.
fn not_zero(node: &Node, name: &str) -> Result<f64, Fault> {
    match node.number()? {
        0.0 => {
            let message = format!("{name} must not be zero");
            Err(Fault::new(&node.span, message).label("no way to go"))
        }
        value => Ok(value),
    }
}
