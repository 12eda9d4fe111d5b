//! Rigid tools of a case file: `stl = "FILE"` in space, `outline = [..]` in the plane.

use crate::case::document::{Entry, Node, Value};
use crate::case::error::Fault;
use crate::case::keys;
use crate::case::mesh_file::MeshFiles;
use crate::case::outline::edge;
use crate::contact::Tool;
use crate::geometry::{Point, Surface};
use crate::mesh::{EdgeShape, OutlineEdge, Segments, Triangles};
use std::collections::BTreeMap;

/// The tool of a contact.
pub(crate) fn tool<const D: usize>(
    entry: &Entry,
    contact: &str,
    files: &mut MeshFiles,
) -> Result<Tool<D>, Fault> {
    let (node, key) = (&entry.node, entry.key.as_str());
    let (of, other) = if D == 3 {
        ("stl", "the plane")
    } else {
        ("outline", "space")
    };
    if key != of {
        let message = format!("`{key}` is a tool of {other}");
        return Err(Fault::new(&entry.key_span, message)
            .label(format!("not in {D}D"))
            .help(format!("a tool in {D}D is `{of}`")));
    }
    let (name, parts) = match of {
        "stl" => {
            let path = node.text()?;
            (path.to_string(), triangles(node, path, files)?)
        }
        _ => (
            format!("the outline of contact `{contact}`"),
            outline(node)?,
        ),
    };
    let Parts {
        points,
        facets,
        curves,
    } = parts;
    let tool = Tool::new(&name, points, &facets, &curves);
    tool.map_err(|error| Fault::new(&node.span, format!("{name}: {error}")))
}

/// Corners and facets of a tool, and the curves behind facets.
struct Parts<const D: usize> {
    points: Vec<Point<D>>,
    facets: Vec<[u32; D]>,
    curves: BTreeMap<usize, Surface<D>>,
}

/// The triangles of a file.
fn triangles<const D: usize>(
    node: &Node,
    path: &str,
    files: &mut MeshFiles,
) -> Result<Parts<D>, Fault> {
    let fault = |why: String| Fault::new(&node.span, format!("STL file `{path}`: {why}"));
    let bytes = files.bytes(node, path).map_err(fault)?;
    let read = Triangles::read(&bytes).map_err(|error| fault(error.to_string()))?;
    let Triangles {
        points,
        triangles,
        contradictions,
        thin,
        repeated,
    } = read;
    if contradictions > 0 {
        files.warn(format!(
            "STL file {path}: {contradictions} of {} stored normals contradict the order of the corners, which counts",
            triangles.len() + thin
        ));
    }
    if repeated > 0 {
        files.warn(format!(
            "STL file {path}: {repeated} triangles are there more than once, and count once"
        ));
    }
    if thin > 0 {
        files.warn(format!(
            "STL file {path}: {thin} triangles without an area are left out"
        ));
    }
    // D is 3
    let points = points.iter().map(|x| std::array::from_fn(|d| x[d]));
    let facets = triangles.iter().map(|t| std::array::from_fn(|k| t[k]));
    Ok(Parts {
        points: points.collect(),
        facets: facets.collect(),
        curves: BTreeMap::new(),
    })
}

/// A list of points and edges. Without a point before them, edges begin where the last one ends.
fn outline<const D: usize>(node: &Node) -> Result<Parts<D>, Fault> {
    let list = node.list()?;
    let is_edge = |node: &Node| matches!(node.value, Value::Table(_));
    let (Some(first), Some(last)) = (list.first(), list.last()) else {
        return Err(Fault::new(&node.span, "the outline is empty").label("no point"));
    };
    let (from, rest) = match is_edge(first) {
        false => (first.point()?, &list[1..]),
        true if is_edge(last) => {
            let end = last.table(keys::EDGE)?.require("to", "an edge")?;
            (end.point()?, list)
        }
        true => (last.point()?, list),
    };
    let (mut start, mut edges) = (from, Vec::new());
    for node in rest {
        let next = match is_edge(node) {
            true => edge(node.table(keys::EDGE)?, start)?,
            false => OutlineEdge {
                to: node.point()?,
                shape: EdgeShape::Line,
                names: Vec::new(),
                division: None,
            },
        };
        start = next.to;
        edges.push(next);
    }
    let read = Segments::of(from, &edges);
    let Segments { points, segments, curves } = read.map_err(|error| {
        Fault::new(&node.span, error.to_string())
            .label("no way along it")
            .help("points, or edges { to } with `center`, `via` or `radius`, with the solid on the left")
    })?;
    // D is 2
    let points = points.iter().map(|x| std::array::from_fn(|d| x[d]));
    let facets = segments.iter().map(|s| std::array::from_fn(|k| s[k]));
    let curves = curves.into_iter().filter_map(|(place, curve)| match curve {
        Surface::Sphere { center, radius } => {
            let center = std::array::from_fn(|d| center[d]);
            Some((place, Surface::Sphere { center, radius }))
        }
        _ => None,
    });
    Ok(Parts {
        points: points.collect(),
        facets: facets.collect(),
        curves: curves.collect(),
    })
}
