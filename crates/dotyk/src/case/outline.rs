//! `mesh.outline` of a body: a path of lines and arcs, holes, sizes.

use crate::case::document::{Node, Span, Table, Value, name};
use crate::case::error::Fault;
use crate::case::keys;
use crate::geometry::Point;
use crate::mesh::{
    CellKind, Contour, Division, EdgeShape, Mesh, MeshError, Outline, OutlineEdge, OutlinePlace,
    SizePoint,
};

/// Growth where the file does not say.
const GROWTH: f64 = 0.3;

const TRIANGLES: [(&str, CellKind); 2] = [("tri3", CellKind::Tri3), ("tri6", CellKind::Tri6)];

/// Where the edges of a contour stand in the file.
struct Spans {
    whole: Span,
    edges: Vec<Span>,
}

/// The mesh of the outline of a body; errors of the mesher point at the edge.
pub(crate) fn mesh(node: &Node, body: &str) -> Result<Mesh<2>, Fault> {
    let table = node.table(keys::OUTLINE)?;
    let what = "an outline";
    let size = table.require("size", what)?.positive("`size`")?;
    let outer_names = names(table)?;
    let (boundary, spans) = contour(table, what, &outer_names, None)?;
    let mut all_spans = vec![spans];
    let mut holes = Vec::new();
    for hole in table.list("holes")? {
        let table = hole.table(keys::HOLE)?;
        let hole_names = names(table)?;
        let hole_size = table.get("size").map(|node| node.positive("`size`"));
        let (contour, spans) = contour(table, "a hole", &hole_names, hole_size.transpose()?)?;
        holes.push(contour);
        all_spans.push(spans);
    }
    let refine = table.list("refine")?.iter().map(size_point);
    let growth = table.get("growth");
    let cell = table.get("cell");
    let outline = Outline {
        boundary,
        holes,
        size,
        growth: growth.map_or(Ok(GROWTH), |node| node.positive("`growth`"))?,
        refine: refine.collect::<Result<_, _>>()?,
        cell: cell.map_or(Ok(CellKind::Tri3), |node| {
            node.choice("cell of an outline", &TRIANGLES)
        })?,
    };
    outline.build().map_err(|error| {
        let place = match &error {
            MeshError::Outline { place, .. } => span(&all_spans, place),
            MeshError::Parameter { key, .. } => table.entry(key).map(|entry| &entry.node.span),
            _ => None,
        };
        let message = format!("the mesh of body `{body}`: {error}");
        Fault::new(place.unwrap_or(table.span), message).label("cannot be meshed")
    })
}

fn span<'s>(spans: &'s [Spans], place: &OutlinePlace) -> Option<&'s Span> {
    let contour = spans.get(place.hole.map_or(0, |hole| hole + 1))?;
    Some(match place.edge {
        Some(edge) => contour.edges.get(edge)?,
        None => &contour.whole,
    })
}

/// A path or circle; `default_names` and `default_size` hold for edges without their own.
fn contour(
    table: Table<'_>,
    what: &str,
    default_names: &[String],
    default_size: Option<f64>,
) -> Result<(Contour, Spans), Fault> {
    let default = default_size.map(Division::Size);
    if let Some(entry) = table.entry("circle") {
        if let Some(other) = table.entry("edges").or(table.entry("from")) {
            let message = format!("{what} has both `circle` and `{}`", other.key);
            return Err(Fault::new(&other.key_span, message).label("give one of the two"));
        }
        let circle = entry.node.table(keys::OUTLINE_CIRCLE)?;
        let own = names(circle)?;
        let contour = Contour::Circle {
            center: circle.require("center", "a circle")?.point()?,
            radius: circle.require("radius", "a circle")?.positive("`radius`")?,
            names: or(own, default_names),
            division: division(circle)?.or(default),
        };
        let spans = Spans {
            whole: entry.node.span.clone(),
            edges: Vec::new(),
        };
        return Ok((contour, spans));
    }
    if table.entry("edges").is_none() {
        let message = format!("{what} needs `from` and `edges`, or `circle`");
        return Err(Fault::new(table.span, message).label("no edges"));
    }
    let edges_node = table.require("edges", what)?;
    let from = table.require("from", what)?.point()?;
    let mut start = from;
    let mut edges = Vec::new();
    for node in table.list("edges")? {
        let mut edge = edge(node, start)?;
        edge.names = or(edge.names, default_names);
        edge.division = edge.division.or(default);
        start = edge.to;
        edges.push(edge);
    }
    let spans = Spans {
        whole: edges_node.span.clone(),
        edges: edges_node.list()?.iter().map(|e| e.span.clone()).collect(),
    };
    Ok((Contour::Path { from, edges }, spans))
}

fn edge(node: &Node, start: Point<2>) -> Result<OutlineEdge, Fault> {
    let table = node.table(keys::EDGE)?;
    let to = table.require("to", "an edge")?.point()?;
    let shapes: Vec<_> = ["center", "via", "radius"]
        .into_iter()
        .filter_map(|key| table.entry(key))
        .collect();
    if let [_, second, ..] = shapes[..] {
        let message = format!(
            "the edge from {start:?} to {to:?} has both `{}` and `{}`",
            shapes[0].key, second.key
        );
        return Err(Fault::new(&second.key_span, message).label("give one of the two"));
    }
    let clockwise = table.entry("clockwise");
    if let Some(entry) = clockwise {
        let free = shapes.first().is_none_or(|shape| shape.key == "via");
        if free {
            let message = "`clockwise` belongs to an arc with `center` or `radius`";
            return Err(Fault::new(&entry.key_span, message).label("says nothing here"));
        }
    }
    let clockwise = clockwise.map_or(Ok(false), |entry| entry.node.boolean())?;
    let shape = match shapes.first() {
        None => EdgeShape::Line,
        Some(entry) if entry.key == "center" => EdgeShape::Center {
            center: entry.node.point()?,
            clockwise,
        },
        Some(entry) if entry.key == "via" => EdgeShape::Via(entry.node.point()?),
        Some(entry) => EdgeShape::Radius {
            radius: entry.node.positive("`radius`")?,
            clockwise,
        },
    };
    Ok(OutlineEdge {
        to,
        shape,
        names: names(table)?,
        division: division(table)?,
    })
}

/// `name`: one name or a list of some, none twice.
fn names(table: Table<'_>) -> Result<Vec<String>, Fault> {
    let Some(node) = table.get("name") else {
        return Ok(Vec::new());
    };
    let Value::List(list) = &node.value else {
        return Ok(vec![name(node)?]);
    };
    let mut names = Vec::with_capacity(list.len());
    for node in list {
        let name = name(node)?;
        if names.contains(&name) {
            let message = format!("the name `{name}` is listed twice");
            return Err(Fault::new(&node.span, message).label("second time"));
        }
        names.push(name);
    }
    Ok(names)
}

fn or(own: Vec<String>, default: &[String]) -> Vec<String> {
    match own.is_empty() {
        true => default.to_vec(),
        false => own,
    }
}

/// `size` or `cells` of an edge or circle.
fn division(table: Table<'_>) -> Result<Option<Division>, Fault> {
    match (table.get("size"), table.entry("cells")) {
        (None, None) => Ok(None),
        (Some(node), None) => Ok(Some(Division::Size(node.positive("`size`")?))),
        (None, Some(entry)) => {
            let cells = entry.node.positive_integer("`cells`")?;
            Ok(Some(Division::Cells(cells)))
        }
        (Some(_), Some(entry)) => {
            let message = "an edge has either `size` or `cells`";
            Err(Fault::new(&entry.key_span, message)
                .label("give one of the two")
                .help("`size` is a length, `cells` a number of equal pieces"))
        }
    }
}

fn size_point(node: &Node) -> Result<SizePoint, Fault> {
    let table = node.table(keys::REFINE)?;
    let what = "a point of `refine`";
    Ok(SizePoint {
        at: table.require("at", what)?.point()?,
        size: table.require("size", what)?.positive("`size`")?,
        radius: table
            .get("radius")
            .map_or(Ok(0.0), |node| node.positive("`radius`"))?,
    })
}
