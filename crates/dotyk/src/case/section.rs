//! `[[section]]` of a case file: its bodies, their cuts, and the capacity.

use crate::case::body::{joined, side};
use crate::case::document::{Node, Span, Table, Value, coordinates, name};
use crate::case::error::Fault;
use crate::case::keys;
use crate::case::points::{named_body, place};
use crate::case::surface::direction;
use crate::mesh::ExtrudedError;
use crate::model::{
    Body, BodyId, Capacity, Reinforcement, Section, SectionError, SideRef, Stations,
};
use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

/// Most stations: each is a row for each step.
const MOST_STATIONS: usize = 10_000;

/// Most places along the axis, at each of which all stations have a row.
const MOST_PLACES: usize = 1000;

/// One section of these bodies.
pub(crate) fn section<const D: usize>(
    node: &Node,
    bodies: &mut [Body<D>],
) -> Result<Section<D>, Fault> {
    let table = node.table(keys::SECTION)?;
    let name = name(table.require("name", "a section")?)?;
    let what = format!("section `{name}`");
    let own = own_bodies(table, &what, bodies)?;
    let sides_node = table.require("sides", &what)?;
    let [first, second] = sides_node.list()? else {
        let message = format!("{what} needs two sides");
        return Err(Fault::new(&sides_node.span, message)
            .label("not two")
            .help("`sides = [\"inner\", \"outer\"]`: the long sides of the body, the first on the left of s"));
    };
    let sides = match own[..] {
        [body] if table.get("body").is_some() => {
            let mut side_of = |node: &Node| {
                let Body { name, mesh, .. } = &mut bodies[body];
                let side = side(node, name, Arc::make_mut(mesh))?;
                let body = BodyId(body);
                Ok(vec![SideRef { body, side }])
            };
            [side_of(first)?, side_of(second)?]
        }
        _ => [along(first, &own, bodies)?, along(second, &own, bodies)?],
    };
    let stations_node = table.require("stations", &what)?;
    let stations = stations(stations_node, bodies)?;
    let axis = table.get("axis").map(|_| direction(table, "axis", &what));
    let places = table.get("places").map_or(Ok(1), places)?;
    let capacity = capacity(table, &what)?;
    let section = Section {
        name,
        bodies: own.into_iter().map(BodyId).collect(),
        sides,
        stations,
        axis: axis.transpose()?,
        places,
        capacity,
    };
    let wrong = section.check(bodies);
    wrong.map_err(|error| fault(&error, table, &what))?;
    Ok(section)
}

/// The bodies of a section: `body`, or `bodies`, each once.
fn own_bodies<const D: usize>(
    table: Table<'_>,
    what: &str,
    bodies: &[Body<D>],
) -> Result<Vec<usize>, Fault> {
    let one = |node: &Node| named_body(node.text()?, &node.span, bodies);
    let Some(entry) = table.entry("bodies") else {
        return Ok(vec![one(table.require("body", what)?)?]);
    };
    if table.get("body").is_some() {
        let message = format!("{what} has `body` and `bodies`");
        return Err(Fault::new(&entry.key_span, message)
            .label("beside `body`")
            .help("name one body, or list all in `bodies`"));
    }
    let list = entry.node.list()?;
    if list.is_empty() {
        let message = format!("{what}: the list of bodies is empty");
        return Err(Fault::new(&entry.node.span, message).label("no body"));
    }
    let mut own = Vec::new();
    for node in list {
        let body = one(node)?;
        if own.contains(&body) {
            let message = format!("{what} names the body `{}` twice", bodies[body].name);
            return Err(Fault::new(&node.span, message).label("second time"));
        }
        own.push(body);
    }
    Ok(own)
}

/// A long side along several bodies: a name or a list of names, each "BODY.SIDE", or that of a side of any of the bodies.
fn along<const D: usize>(
    node: &Node,
    own: &[usize],
    bodies: &mut [Body<D>],
) -> Result<Vec<SideRef>, Fault> {
    let nodes = match &node.value {
        Value::List(list) => &list[..],
        _ => std::slice::from_ref(node),
    };
    let mut named: BTreeMap<usize, Vec<(String, Span)>> = BTreeMap::new();
    for node in nodes {
        let text = node.text()?;
        let of_body = text.split_once('.').and_then(|(body, side)| {
            let body = own.iter().copied().find(|&of| bodies[of].name == body)?;
            Some((body, side.to_string()))
        });
        let found: Vec<(usize, String)> = match of_body {
            Some(found) => vec![found],
            None => {
                let with = own
                    .iter()
                    .filter(|&&of| bodies[of].mesh.side(text).is_some());
                with.map(|&of| (of, text.to_string())).collect()
            }
        };
        if found.is_empty() {
            let sides = own.iter().flat_map(|&of| bodies[of].mesh.sides().keys());
            let sides: BTreeSet<&str> = sides.map(String::as_str).collect();
            let message = format!("none of the bodies has a side `{text}`");
            let fault = Fault::new(&node.span, message);
            return Err(fault.nearest(text, ["the nearest side", "sides"], sides.iter().copied()));
        }
        for (body, side) in found {
            named
                .entry(body)
                .or_default()
                .push((side, node.span.clone()));
        }
    }
    let sides = own.iter().filter_map(|&of| Some((of, named.remove(&of)?)));
    let joined = sides.map(|(of, sides)| {
        let Body { name, mesh, .. } = &mut bodies[of];
        Ok(SideRef {
            body: BodyId(of),
            side: joined(&sides, &node.span, name, Arc::make_mut(mesh))?,
        })
    });
    joined.collect()
}

/// An error of the cuts of a section, at its place in the text.
fn fault(error: &SectionError, table: Table<'_>, what: &str) -> Fault {
    let span = |key: &str| table.get(key).map_or(table.span, |node| &node.span);
    let message = format!("{what}: {error}");
    match error {
        SectionError::Sides(_) => Fault::new(span("sides"), message)
            .label("not two long sides of the body")
            .help("a section lies between two sides that run along the body, such as `inner` and `outer` of a ring, `top` and `bottom` of a beam; a side in several parts is written as a list of names; of several bodies `\"BODY.SIDE\"` is that of one of them"),
        SectionError::Off { index, .. } => {
            let stations = table.get("stations").and_then(|node| node.list().ok());
            let node = stations.and_then(|list| list.get(*index));
            Fault::new(node.map_or(table.span, |node| &node.span), message)
                .label("off the body")
                .help("a station is the place of the middle line that is nearest to the point")
        }
        SectionError::Depth { layer, .. } => {
            let bars = reinforcement(table).and_then(|node| node.list().ok());
            let node = bars.and_then(|list| list.get(*layer));
            Fault::new(node.map_or(table.span, |node| &node.span), message)
                .label("outside of the section")
                .help("`depth` counts from the first of the `sides`")
        }
        SectionError::NotThrough { .. } => Fault::new(span("sides"), message)
            .label("the body goes on beside them")
            .help("end both sides where the other does, or name stations farther from their ends"),
        SectionError::Bodies | SectionError::Thicknesses(_) => {
            Fault::new(span("bodies"), message).label("not the bodies of one section")
        }
        SectionError::Beside(_) => Fault::new(span("sides"), message).label("beside the bodies"),
        SectionError::TooFew => Fault::new(span("stations"), message).label("not a section"),
        SectionError::Plane => {
            let key = if table.get("axis").is_some() { "axis" } else { "places" };
            Fault::new(span(key), message).label("not in the plane")
        }
        SectionError::NoPlace | SectionError::Extruded(ExtrudedError::Finer { .. }) => {
            Fault::new(span("places"), message)
                .label("too close")
                .help("fewer `places`, or smaller cells along the axis")
        }
        SectionError::Extruded(ExtrudedError::Openings { .. }) => Fault::new(span("places"), message)
            .label("beside openings")
            .help("without `places` the forces of whole cuts are told; a section of its own for each part between openings tells more"),
        SectionError::Extruded(ExtrudedError::Ambiguous) => {
            Fault::new(span("sides"), message)
                .label("parallel planes")
                .help("add `axis = [x, y, z]`, a direction along both of them: that of a tunnel, a wall, or across a beam; s runs from one end of the sides to the other, across it")
        }
        SectionError::Extruded(ExtrudedError::Across) => Fault::new(span("axis"), message)
            .label("not along the sides"),
        SectionError::Extruded(ExtrudedError::NotExtruded) => Fault::new(span("sides"), message)
            .label("not along one direction")
            .help("name the parts of the boundary that run along the axis of the lining, wall or beam, without its ends"),
        SectionError::Extruded(ExtrudedError::NoFace(_) | ExtrudedError::Lengths(..)) => {
            Fault::new(span(if table.get("body").is_some() { "body" } else { "bodies" }), message)
                .label("not extruded from one end to the other")
                .help("rings of a lining that follow each other have a section each; a body ends with plane faces across the axis")
        }
    }
}

fn stations<const D: usize>(node: &Node, bodies: &[Body<D>]) -> Result<Stations<D>, Fault> {
    let points = match &node.value {
        Value::List(list) if list.is_empty() => {
            return Err(Fault::new(&node.span, "the list of stations is empty").label("no station"));
        }
        Value::List(list) => list,
        Value::Integer(_) | Value::Text(_) => {
            let number = node.positive_integer("`stations`")?;
            if !(2..=MOST_STATIONS).contains(&number) {
                let message =
                    format!("a section has 2 to {MOST_STATIONS} stations, both ends included");
                return Err(Fault::new(&node.span, message).label(format!("{number}")));
            }
            return Ok(Stations::Number(number));
        }
        _ => {
            let point = coordinates::<D>();
            return Err(node.expected(&format!("a number of stations or a list of points {point}")));
        }
    };
    let places = points.iter().map(|point| place(point, bodies));
    Ok(Stations::Points(places.collect::<Result<_, _>>()?))
}

/// The number of places along the axis.
fn places(node: &Node) -> Result<usize, Fault> {
    let number = node.positive_integer("`places`")?;
    if number > MOST_PLACES {
        let message = format!("a section has at most {MOST_PLACES} places along its axis");
        return Err(Fault::new(&node.span, message).label(format!("{number}")));
    }
    Ok(number)
}

/// The bars, beside `capacity` or in it.
fn reinforcement(table: Table<'_>) -> Option<&Node> {
    let inside = table.get("capacity").and_then(|node| node.entries().ok());
    let inside = inside.and_then(|entries| entries.iter().find(|e| e.key == "reinforcement"));
    table
        .get("reinforcement")
        .or(inside.map(|entry| &entry.node))
}

fn capacity(table: Table<'_>, what: &str) -> Result<Option<Capacity>, Fault> {
    let Some(node) = table.get("capacity") else {
        return match table.entry("reinforcement") {
            None => Ok(None),
            Some(entry) => Err(Fault::new(&entry.key_span, format!("{what} has bars and no strength"))
                .label("without `capacity`")
                .help("add `capacity = { compression = .. }`, the strength of the section without its bars")),
        };
    };
    let own = node.table(keys::CAPACITY)?;
    if let (Some(_), Some(entry)) = (own.get("reinforcement"), table.entry("reinforcement")) {
        let message = format!("{what} has bars in its capacity and beside it");
        return Err(Fault::new(&entry.key_span, message).label("a second time"));
    }
    let compression = own.require("compression", "a capacity")?;
    let compression = compression.positive("the strength `compression`")?;
    let tension = own.get("tension");
    let tension = tension.map_or(Ok(0.0), |node| not_negative(node, "the strength `tension`"))?;
    let bars = reinforcement(table).map_or(Ok(&[][..]), Node::list)?;
    Ok(Some(Capacity {
        compression,
        tension,
        reinforcement: bars.iter().map(bar).collect::<Result<_, _>>()?,
    }))
}

fn bar(node: &Node) -> Result<Reinforcement, Fault> {
    let table = node.table(keys::REINFORCEMENT)?;
    let value = |key: &str| table.require(key, "a layer of bars");
    let young = table.get("young");
    Ok(Reinforcement {
        depth: not_negative(value("depth")?, "`depth`")?,
        area: value("area")?.positive("`area`")?,
        yields: value("yield")?.positive("the strength `yield`")?,
        young: young.map(|node| node.positive("`young`")).transpose()?,
    })
}

fn not_negative(node: &Node, name: &str) -> Result<f64, Fault> {
    let value = node.not_negative(name);
    value.map_err(|fault| fault.help("strengths are positive, in tension and in compression"))
}
