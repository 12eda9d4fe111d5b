//! `mesh.outline` of a body: a path of lines and arcs, holes, sizes; and `[drawing]`, lines between the regions that bodies
//! are made of.

use crate::case::document::{Node, Span, Table, Value, name};
use crate::case::error::Fault;
use crate::case::keys;
use crate::geometry::Point;
use crate::mesh::{
    CellKind, Contour, Division, Drawing, EdgeShape, GROWTH, Mesh, MeshError, Outline, OutlineEdge,
    OutlinePart, OutlinePlace, Region, Regions, SizePoint,
};

const TRIANGLES: [(&str, CellKind); 2] = [("tri3", CellKind::Tri3), ("tri6", CellKind::Tri6)];

/// Places of the edges of a contour in the file.
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
    let Fineness {
        growth,
        refine,
        cell,
    } = fineness(table)?;
    let outline = Outline {
        boundary,
        holes,
        size,
        growth,
        refine,
        cell,
    };
    outline.build().map_err(|error| {
        let error = Refused::of(error, table, &all_spans, &[]);
        error.because(&format!("the mesh of body `{body}`"))
    })
}

/// The regions of a drawing, filled.
pub(crate) fn drawing(node: &Node) -> Result<Regions, Fault> {
    let table = node.table(keys::DRAWING)?;
    let what = "a drawing";
    let size = table.require("size", what)?.positive("`size`")?;
    let (mut lines, mut spans) = (Vec::new(), Vec::new());
    for line in table.list("lines")? {
        let table = line.table(keys::LINE)?;
        own_shape(table)?;
        let line_names = names(table)?;
        let line_size = table.get("size").map(|node| node.positive("`size`"));
        let (contour, line_spans) = contour(table, "a line", &line_names, line_size.transpose()?)?;
        lines.push(contour);
        spans.push(line_spans);
    }
    let mut regions = Vec::new();
    for node in table.list("regions")? {
        let table = node.table(keys::REGION)?;
        let size = table.get("size").map(|node| node.positive("`size`"));
        let at = table.require("at", "a region")?;
        regions.push(Region {
            name: name(table.require("name", "a region")?)?,
            at: match &at.value {
                Value::List(list) if list.iter().all(|n| matches!(n.value, Value::List(_))) => {
                    list.iter().map(Node::point).collect::<Result<_, _>>()?
                }
                _ => vec![at.point()?],
            },
            size: size.transpose()?,
        });
    }
    let region_spans: Vec<Span> = table
        .list("regions")?
        .iter()
        .map(|n| n.span.clone())
        .collect();
    let Fineness {
        growth,
        refine,
        cell,
    } = fineness(table)?;
    let drawing = Drawing {
        lines,
        regions,
        size,
        growth,
        refine,
        cell,
    };
    drawing.build().map_err(|error| {
        Refused::of(error, table, &spans, &region_spans).because("the regions of the case")
    })
}

/// Refuses keys of a single edge in a line of several.
fn own_shape(table: Table<'_>) -> Result<(), Fault> {
    let keys = ["center", "via", "radius", "clockwise", "cells"].into_iter();
    let other = keys.filter_map(|key| table.entry(key)).next();
    match (other, table.entry("to")) {
        (Some(entry), None) => {
            let message = format!("`{}` belongs to a single edge", entry.key);
            Err(Fault::new(&entry.key_span, message)
                .label("says nothing here")
                .help("a line is { from, to } with the keys of an edge, { from, edges } or { circle }"))
        }
        _ => Ok(()),
    }
}

/// Settings of the mesh besides the size of its cells.
struct Fineness {
    growth: f64,
    refine: Vec<SizePoint>,
    cell: CellKind,
}

fn fineness(table: Table<'_>) -> Result<Fineness, Fault> {
    let refine = table.list("refine")?.iter().map(size_point);
    let growth = table.get("growth");
    let cell = table.get("cell");
    Ok(Fineness {
        growth: growth.map_or(Ok(GROWTH), |node| node.positive("`growth`"))?,
        refine: refine.collect::<Result<_, _>>()?,
        cell: cell.map_or(Ok(CellKind::Tri3), |node| {
            node.choice("cell of an outline", &TRIANGLES)
        })?,
    })
}

/// The error of a mesh, with its place in the file.
struct Refused {
    error: MeshError,
    span: Span,
}

impl Refused {
    fn of(error: MeshError, table: Table<'_>, contours: &[Spans], regions: &[Span]) -> Self {
        let span = match &error {
            MeshError::Outline { place, .. } | MeshError::Drawing { place, .. } => {
                span(contours, regions, place)
            }
            MeshError::Parameter { key, .. } => table.entry(key).map(|entry| &entry.node.span),
            _ => None,
        };
        let span = span.unwrap_or(table.span).clone();
        Self { error, span }
    }

    fn because(self, what: &str) -> Fault {
        let message = format!("{what}: {}", self.error);
        Fault::new(&self.span, message).label("cannot be meshed")
    }
}

fn span<'s>(contours: &'s [Spans], regions: &'s [Span], place: &OutlinePlace) -> Option<&'s Span> {
    let contour = match place.part {
        OutlinePart::Outer => contours.first()?,
        OutlinePart::Hole(hole) => contours.get(hole + 1)?,
        OutlinePart::Line(line) => contours.get(line)?,
        OutlinePart::Region(region) => return regions.get(region),
        OutlinePart::Drawing => return None,
    };
    Some(match place.edge {
        Some(edge) => contour.edges.get(edge).unwrap_or(&contour.whole),
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
        let others = ["edges", "from", "to"].into_iter();
        if let Some(other) = others.filter_map(|key| table.entry(key)).next() {
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
    if table.entry("to").is_some() {
        if let Some(other) = table.entry("edges") {
            let message = format!("{what} has both `to` and `edges`");
            return Err(Fault::new(&other.key_span, message).label("give one of the two"));
        }
        let from = table.require("from", what)?.point()?;
        let edge = edge(table, from)?;
        let spans = Spans {
            whole: table.span.clone(),
            edges: Vec::new(),
        };
        let edges = vec![edge];
        return Ok((Contour::Path { from, edges }, spans));
    }
    if table.entry("edges").is_none() {
        let message = match what {
            "a line" => "a line needs `from` and `to` or `edges`, or `circle`".to_string(),
            _ => format!("{what} needs `from` and `edges`, or `circle`"),
        };
        return Err(Fault::new(table.span, message).label("no edges"));
    }
    let edges_node = table.require("edges", what)?;
    let from = table.require("from", what)?.point()?;
    let mut start = from;
    let mut edges = Vec::new();
    for node in table.list("edges")? {
        let mut edge = edge(node.table(keys::EDGE)?, start)?;
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

/// The edge of a path that goes on from a point.
pub(crate) fn edge(table: Table<'_>, start: Point<2>) -> Result<OutlineEdge, Fault> {
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

/// `name`: one name or a list of names, no name twice.
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
