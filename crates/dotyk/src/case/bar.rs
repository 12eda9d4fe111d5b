//! `[[bar]]` of a case file: bolts, anchors and ties.

use crate::case::contact::side_ref;
use crate::case::document::{Node, Table, Value, later, name};
use crate::case::error::Fault;
use crate::case::keys;
use crate::case::points::place;
use crate::case::steps::Steps;
use crate::model::{Analysis, Bar, BarEnd, BarError, Body, BodyId, Bond};

const BONDS: [(&str, Bond); 2] = [("ends", Bond::Ends), ("grouted", Bond::Grouted)];

/// One bar of these bodies.
pub(crate) fn bar<const D: usize>(
    node: &Node,
    bodies: &mut [Body<D>],
    analysis: Analysis,
    steps: &Steps,
) -> Result<Bar<D>, Fault> {
    let table = node.table(keys::BAR)?;
    let name = name(table.require("name", "a bar")?)?;
    let what = format!("bar `{name}`");
    if analysis == Analysis::Axisymmetric {
        return Err(later(table.span, "a bar with axial symmetry"));
    }
    let active = steps.active(table)?;
    let positive = |key: &str| {
        let node = table.get(key);
        node.map(|node| node.positive(&format!("`{key}`")))
            .transpose()
    };
    let required = |key: &str| table.require(key, &what)?.positive(&format!("`{key}`"));
    let (young, area) = (required("young")?, required("area")?);
    let [spacing, yields, radius] = ["spacing", "yield", "radius"].map(positive);
    let (spacing, yields, radius) = (spacing?, yields?, radius?);
    if let (3, Some(entry)) = (D, table.entry("spacing")) {
        let message = "`spacing` is the distance of bars across a plane model";
        return Err(Fault::new(&entry.key_span, message)
            .label("not in space")
            .help("in space each bar is there by itself"));
    }
    let bond = table.get("bond");
    let bond = bond.map_or(Ok(Bond::Ends), |node| node.choice("bond", &BONDS))?;
    let prestress = table.get("prestress").map(Node::number).transpose()?;
    let tension_only = table.get("tension_only").map_or(Ok(false), Node::boolean)?;
    let ends = ["from", "to"].map(|key| end(table.require(key, &what)?, bodies));
    let [from, to] = ends;
    let ends = [from?, to?];
    let within = bodies_of(table, &ends, bond, &what, bodies)?;
    let at_points = ends.iter().any(|end| matches!(end, BarEnd::Point(_)));
    if let (false, Some(entry)) = (at_points, table.entry("radius")) {
        let message = format!("`radius` is of ends at points, and {what} has none");
        return Err(Fault::new(&entry.key_span, message).label("superfluous"));
    }
    Ok(Bar {
        bond,
        prestress,
        spacing,
        tension_only,
        yields,
        radius,
        active,
        ..Bar::new(&name, ends, &within, [young, area])
    })
}

/// A point, or `{ side = "BODY.SIDE" }`.
fn end<const D: usize>(node: &Node, bodies: &mut [Body<D>]) -> Result<BarEnd<D>, Fault> {
    match node.value {
        Value::Table(_) => {
            let table = node.table(keys::BAR_END)?;
            let side = table.require("side", "the end of a bar")?;
            side_ref(side, bodies).map(BarEnd::Side)
        }
        _ => place(node, bodies).map(BarEnd::Point),
    }
}

/// The bodies in which its points lie.
fn bodies_of<const D: usize>(
    table: Table<'_>,
    ends: &[BarEnd<D>; 2],
    bond: Bond,
    what: &str,
    bodies: &[Body<D>],
) -> Result<Vec<BodyId>, Fault> {
    let at_points = ends.iter().any(|end| matches!(end, BarEnd::Point(_)));
    let needed = at_points || bond == Bond::Grouted;
    let Some(entry) = table.entry("bodies") else {
        return match needed {
            false => Ok(Vec::new()),
            true => Err(Fault::new(table.span, format!("{what} does not say in which bodies it lies"))
                .label("`bodies` is missing")
                .help("add `bodies = [\"rock\"]`: its points are looked for in the first of them, then in the next")),
        };
    };
    if !needed {
        let message = format!("`bodies` is of ends at points, and {what} ends at sides");
        return Err(Fault::new(&entry.key_span, message).label("superfluous"));
    }
    let list = entry.node.list()?;
    if list.is_empty() {
        let message = format!("the list of bodies of {what} is empty");
        return Err(Fault::new(&entry.node.span, message).label("no body"));
    }
    let mut found: Vec<BodyId> = Vec::new();
    for node in list {
        let text = node.text()?;
        let Some(place) = bodies.iter().position(|body| body.name == text) else {
            let fault = Fault::new(&node.span, format!("there is no body `{text}`"));
            let names = bodies.iter().map(|body| body.name.as_str());
            return Err(fault.nearest(text, ["the nearest known body", "bodies"], names));
        };
        if found.contains(&BodyId(place)) {
            let message = format!("{what} names the body `{text}` twice");
            return Err(Fault::new(&node.span, message).label("second time"));
        }
        found.push(BodyId(place));
    }
    Ok(found)
}

/// An error of a bar in the model, at its place in the text.
pub(crate) fn fault(error: &BarError, node: &Node, name: &str) -> Result<Fault, Fault> {
    let table = node.table(keys::BAR)?;
    let span = |key: &str| table.get(key).map_or(table.span, |node| &node.span);
    let message = format!("bar `{name}`: {error}");
    let end = |end: usize| ["from", "to"][end];
    Ok(match error {
        BarError::Number { what, .. } => Fault::new(span(what), message).label("not possible"),
        BarError::Off { end: k, .. } => Fault::new(span(end(*k)), message)
            .label("in none of its bodies")
            .help("a point end lies in a cell of one of the `bodies`, on the boundary at the most"),
        BarError::Side { end: k, .. } => {
            Fault::new(span(end(*k)), message).label("no side to pull at")
        }
        BarError::NoLength => Fault::new(span("to"), message).label("the same as `from`"),
        BarError::NotWithin => Fault::new(span("bodies"), message)
            .label("not in them")
            .help("name the bodies through which it runs, or leave out `bond`"),
        BarError::Axial => Fault::new(table.span, message).label("not with axial symmetry"),
        BarError::Thickness | BarError::Spacing => {
            Fault::new(span("spacing"), message).label("of how many bars?")
        }
    })
}
