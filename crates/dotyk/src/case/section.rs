//! `[[section]]` of a case file: the body, its cuts, and its capacity.

use crate::case::body::side;
use crate::case::document::{Node, Table, Value, coordinates, name};
use crate::case::error::Fault;
use crate::case::keys;
use crate::case::points::{named_body, place};
use crate::model::{Body, BodyId, Capacity, Reinforcement, Section, SectionError, Stations};
use std::sync::Arc;

/// Most stations: each is a row for each step.
const MOST_STATIONS: usize = 10_000;

/// One section of these bodies.
pub(crate) fn section<const D: usize>(
    node: &Node,
    bodies: &mut [Body<D>],
) -> Result<Section<D>, Fault> {
    let table = node.table(keys::SECTION)?;
    let name = name(table.require("name", "a section")?)?;
    let what = format!("section `{name}`");
    let of = table.require("body", &what)?;
    let body = named_body(of.text()?, &of.span, bodies)?;
    let sides_node = table.require("sides", &what)?;
    let [first, second] = sides_node.list()? else {
        let message = format!("{what} needs two sides");
        return Err(Fault::new(&sides_node.span, message)
            .label("not two")
            .help("`sides = [\"inner\", \"outer\"]`: the long sides of the body, the first on the left of s"));
    };
    let mut side_of = |node: &Node| {
        let Body { name, mesh, .. } = &mut bodies[body];
        side(node, name, Arc::make_mut(mesh))
    };
    let sides = [side_of(first)?, side_of(second)?];
    let stations_node = table.require("stations", &what)?;
    let stations = stations(stations_node, bodies)?;
    let capacity = capacity(table, &what)?;
    let section = Section {
        name,
        body: BodyId(body),
        sides,
        stations,
        capacity,
    };
    let wrong = section.check(&bodies[body]);
    wrong.map_err(|error| fault(&error, table, &what))?;
    Ok(section)
}

/// An error of the cuts of a section, at its place in the text.
fn fault(error: &SectionError, table: Table<'_>, what: &str) -> Fault {
    let span = |key: &str| table.get(key).map_or(table.span, |node| &node.span);
    let message = format!("{what}: {error}");
    match error {
        SectionError::Sides(_) => Fault::new(span("sides"), message)
            .label("not two long sides of the body")
            .help("a section lies between two sides that run along the body, such as `inner` and `outer` of a ring, `top` and `bottom` of a beam; a side in several parts is written as a list of names"),
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
        SectionError::TooFew | SectionError::Space => {
            Fault::new(span("stations"), message).label("not a section")
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
