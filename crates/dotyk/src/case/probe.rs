//! `[[probe]]` of a case file: what is read off the solution, checked before anything is solved.

use crate::case::document::{Node, Table};
use crate::case::error::Fault;
use crate::case::keys;
use crate::case::points::place;
use crate::case::suggest::listed;
use crate::model::{Body, BodyId, Contact, Mistake, Probe, Quantity, QuantityError, Reading};

const REDUCTIONS: [(&str, Reading<2>); 4] = [
    ("max", Reading::Largest),
    ("min", Reading::Smallest),
    ("mean", Reading::Mean),
    ("integral", Reading::Integral),
];

const UNKNOWN: [&str; 2] = ["the nearest known", "known"];

/// One probe on these bodies and contacts.
pub(crate) fn probe(
    node: &Node,
    bodies: &[Body<2>],
    contacts: &[Contact<2>],
) -> Result<Probe<2>, Fault> {
    let table = node.table(keys::PROBE)?;
    let name = label(table.require("name", "a probe")?)?;
    let quantity = table.require("quantity", "a probe")?;
    let contacts: Vec<&str> = contacts.iter().map(|c| c.name.as_str()).collect();
    let parsed = Quantity::parse(quantity.text()?, bodies, &contacts);
    let quantity = parsed.map_err(|error| fault(quantity, &error))?;
    Ok(Probe {
        minus_rigid: minus_rigid(table, &quantity, bodies)?,
        center: center(table, &quantity)?,
        reading: reading(table, &name, &quantity, bodies)?,
        name,
        quantity,
    })
}

/// A probe's name is a label: it names no file and is part of no quantity, so it may have blanks.
fn label(node: &Node) -> Result<String, Fault> {
    let text = node.text()?;
    if text.trim().is_empty() || text.contains(char::is_control) {
        let message = "the name of a probe must be a line of text";
        return Err(Fault::new(&node.span, message).label("not a name"));
    }
    Ok(text.to_string())
}

/// The mistake at its word.
fn fault(node: &Node, error: &QuantityError) -> Fault {
    let fault = Fault::new(&node.part(error.at.clone()), error.to_string());
    let known = error.known.iter().map(String::as_str);
    match error.mistake {
        Mistake::Unknown(_) => fault.nearest(&error.word, UNKNOWN, known),
        Mistake::Incomplete => fault
            .label("incomplete")
            .help(format!("add one of {}", listed(known))),
        Mistake::TooLong => fault.label("ends too late"),
    }
}

/// Where, or how: a field needs `at` or `reduce`, a number neither; neighbours are those of a point.
fn reading(
    table: Table<'_>,
    name: &str,
    quantity: &Quantity,
    bodies: &[Body<2>],
) -> Result<Reading<2>, Fault> {
    let reduced = table.get("reduce");
    let reduced = reduced
        .map(|node| node.choice("reduction", &REDUCTIONS))
        .transpose()?;
    let at = table
        .get("at")
        .map(|node| place(node, bodies))
        .transpose()?;
    let mean = table.get("mean_of_neighbours");
    let mean = mean.map_or(Ok(false), Node::boolean)?;
    let superfluous = table.entry("at").or(table.entry("reduce"));
    if let (false, Some(entry)) = (quantity.is_field(), superfluous) {
        let message = format!(
            "`{quantity}` of probe `{name}` is one number and takes no `{}`",
            entry.key
        );
        return Err(Fault::new(&entry.key_span, message).label("superfluous"));
    }
    if let (Some(_), Some(entry)) = (at, table.entry("reduce")) {
        let message = format!("probe `{name}` has both `at` and `reduce`");
        return Err(Fault::new(&entry.key_span, message).label("give one of the two"));
    }
    match (at, reduced, table.entry("mean_of_neighbours")) {
        (None, None, _) if quantity.is_field() => Err(Fault::new(
            table.span,
            format!("probe `{name}` must say where: `at` or `reduce` is missing"),
        )
        .label("`at` or `reduce` is missing")
        .help("add `at = [x, y]`, or `reduce = \"max\"`, \"min\", \"mean\" or \"integral\"")),
        (None, _, Some(entry)) if mean => {
            let message = format!("`mean_of_neighbours` of probe `{name}` needs `at`");
            Err(Fault::new(&entry.key_span, message).label("neighbours of what?"))
        }
        (Some(point), _, _) if mean => Ok(Reading::MeanOfNeighbours(point)),
        (Some(point), _, _) => Ok(Reading::At(point)),
        (None, reduced, _) => Ok(reduced.unwrap_or(Reading::Whole)),
    }
}

/// What a hoop stress goes around; the origin where nothing is said.
fn center(table: Table<'_>, quantity: &Quantity) -> Result<[f64; 2], Fault> {
    match table.entry("center") {
        None => Ok([0.0; 2]),
        Some(entry) if quantity.is_hoop() => entry.node.point(),
        Some(entry) => {
            let message = format!("`center` belongs to hoop stresses, and not to `{quantity}`");
            Err(Fault::new(&entry.key_span, message).label("says nothing here"))
        }
    }
}

fn minus_rigid(
    table: Table<'_>,
    quantity: &Quantity,
    bodies: &[Body<2>],
) -> Result<Option<BodyId>, Fault> {
    let Some(entry) = table.entry("minus_rigid") else {
        return Ok(None);
    };
    if !quantity.is_displacement() {
        let message = format!("`minus_rigid` applies to displacements, and not to `{quantity}`");
        return Err(Fault::new(&entry.key_span, message).label("not a displacement"));
    }
    let text = entry.node.text()?;
    match bodies.iter().position(|body| body.name == text) {
        Some(body) => Ok(Some(BodyId(body))),
        None => {
            let fault = Fault::new(&entry.node.span, format!("unknown body `{text}`"));
            let names = bodies.iter().map(|body| body.name.as_str());
            Err(fault.nearest(text, UNKNOWN, names))
        }
    }
}
