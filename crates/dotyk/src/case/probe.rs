//! `[[probe]]` of a case file: what is read off the solution, checked before anything is solved.

use crate::case::document::{Node, Span, Table};
use crate::case::error::Fault;
use crate::case::keys;
use crate::case::suggest::{listed, nearest};
use crate::model::{Body, Contact, Probe, Reduce};

const REDUCTIONS: [(&str, Reduce); 2] = [("max", Reduce::Max), ("min", Reduce::Min)];

const BODY_QUANTITIES: [&str; 3] = ["displacement", "stress", "reaction"];
const CONTACT_FIELDS: [&str; 6] = [
    "pressure",
    "gap",
    "shear",
    "slip",
    "displacement_nonmortar",
    "displacement_mortar",
];
const AXES: [&str; 2] = ["x", "y"];
const DISPLACEMENTS: [&str; 3] = ["x", "y", "magnitude"];
const STRESSES: [&str; 7] = ["xx", "yy", "zz", "xy", "von_mises", "s1", "s3"];

/// How a quantity is brought to one number.
#[derive(Clone, Copy, PartialEq)]
enum Extent {
    /// It varies: `at` or `reduce`. With `displacement`, `minus_rigid` makes sense.
    Field { displacement: bool },
    /// It is one number.
    Number,
}

/// One probe on these bodies and contacts.
pub(crate) fn probe(
    node: &Node,
    bodies: &[Body<2>],
    contacts: &[Contact<2>],
) -> Result<Probe<2>, Fault> {
    let table = node.table(keys::PROBE)?;
    let name = label(table.require("name", "a probe")?)?;
    let quantity_node = table.require("quantity", "a probe")?;
    let quantity = quantity_node.text()?;
    let extent = extent(quantity, &quantity_node.span, bodies, contacts)?;
    let reduce = table.get("reduce");
    let reduce = reduce.map(|node| node.choice("reduction", &REDUCTIONS));
    let at = table.get("at").map(Node::point).transpose()?;
    let mean = table.get("mean_of_neighbours");
    let mean_of_neighbours = mean.map_or(Ok(false), Node::boolean)?;
    let probe = Probe {
        name,
        quantity: quantity.to_string(),
        at,
        reduce: reduce.transpose()?,
        mean_of_neighbours,
        minus_rigid: minus_rigid(table, quantity, extent, bodies)?,
    };
    place_fits(table, &probe, extent)?;
    Ok(probe)
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

/// A field needs `at` or `reduce`, a number neither; neighbours are those of a point.
fn place_fits(table: Table<'_>, probe: &Probe<2>, extent: Extent) -> Result<(), Fault> {
    let Probe { name, quantity, .. } = probe;
    match (extent, table.entry("at"), table.entry("reduce")) {
        (Extent::Field { .. }, None, None) => {
            return Err(Fault::new(
                table.span,
                format!("probe `{name}` must say where: `at` or `reduce` is missing"),
            )
            .label("`at` or `reduce` is missing")
            .help("add `at = [x, y]`, or `reduce = \"max\"` or \"min\""));
        }
        (Extent::Field { .. }, Some(_), Some(entry)) => {
            let message = format!("probe `{name}` has both `at` and `reduce`");
            return Err(Fault::new(&entry.key_span, message).label("give one of the two"));
        }
        (Extent::Number, Some(entry), _) | (Extent::Number, None, Some(entry)) => {
            let message = format!(
                "`{quantity}` of probe `{name}` is one number and takes no `{}`",
                entry.key
            );
            return Err(Fault::new(&entry.key_span, message).label("superfluous"));
        }
        _ => {}
    }
    if let (true, None, Some(entry)) = (
        probe.mean_of_neighbours,
        &probe.at,
        table.entry("mean_of_neighbours"),
    ) {
        let message = format!("`mean_of_neighbours` of probe `{name}` needs `at`");
        return Err(Fault::new(&entry.key_span, message).label("neighbours of what?"));
    }
    Ok(())
}

fn minus_rigid(
    table: Table<'_>,
    quantity: &str,
    extent: Extent,
    bodies: &[Body<2>],
) -> Result<Option<String>, Fault> {
    let Some(entry) = table.entry("minus_rigid") else {
        return Ok(None);
    };
    if extent != (Extent::Field { displacement: true }) {
        let message = format!("`minus_rigid` applies to displacements, and not to `{quantity}`");
        return Err(Fault::new(&entry.key_span, message).label("not a displacement"));
    }
    let text = entry.node.text()?;
    let names = bodies.iter().map(|b| b.name.as_str());
    one_of("body", text, &names.collect::<Vec<_>>(), &entry.node.span)?;
    Ok(Some(text.to_string()))
}

/// Checks a quantity word by word.
fn extent(
    quantity: &str,
    span: &Span,
    bodies: &[Body<2>],
    contacts: &[Contact<2>],
) -> Result<Extent, Fault> {
    let words: Vec<&str> = quantity.split('.').collect();
    let (owner, rest) = (words[0], &words[1..]);
    let body = bodies.iter().find(|b| b.name == owner);
    let contact = contacts.iter().any(|c| c.name == owner);
    match (body, contact) {
        (Some(body), false) => of_body(body, rest, span),
        (None, true) => of_contact(owner, rest, span),
        // A name shared by a body and a contact: the quantity tells which is meant.
        (Some(body), true) => of_contact(owner, rest, span).or_else(|_| of_body(body, rest, span)),
        (None, false) => {
            let bodies = bodies.iter().map(|b| b.name.as_str());
            let contacts = contacts.iter().map(|c| c.name.as_str());
            let names: Vec<&str> = bodies.chain(contacts).collect();
            Err(unknown("body or contact", owner, &names, span))
        }
    }
}

fn of_body(body: &Body<2>, rest: &[&str], span: &Span) -> Result<Extent, Fault> {
    match *rest {
        ["displacement", component] => {
            one_of("displacement", component, &DISPLACEMENTS, span)?;
            Ok(Extent::Field { displacement: true })
        }
        ["stress", component] => {
            one_of("stress", component, &STRESSES, span)?;
            Ok(Extent::Field {
                displacement: false,
            })
        }
        ["reaction", component] => {
            one_of("component", component, &AXES, span)?;
            Ok(Extent::Number)
        }
        [side, "reaction", component] => {
            let sides: Vec<&str> = body.mesh.side_names().collect();
            one_of("side", side, &sides, span)?;
            one_of("component", component, &AXES, span)?;
            Ok(Extent::Number)
        }
        ["displacement"] => Err(incomplete("displacement", &DISPLACEMENTS, span)),
        ["stress"] => Err(incomplete("stress", &STRESSES, span)),
        ["reaction"] | [_, "reaction"] => Err(incomplete("reaction", &AXES, span)),
        [] => Err(incomplete(&body.name, &BODY_QUANTITIES, span)),
        [other, ..] => Err(unknown("quantity of a body", other, &BODY_QUANTITIES, span)),
    }
}

fn of_contact(contact: &str, rest: &[&str], span: &Span) -> Result<Extent, Fault> {
    let quantities: Vec<&str> = CONTACT_FIELDS
        .into_iter()
        .chain(["resultant", "length"])
        .collect();
    match *rest {
        [field] if CONTACT_FIELDS.contains(&field) => Ok(Extent::Field {
            displacement: field.starts_with("displacement"),
        }),
        ["length"] => Ok(Extent::Number),
        ["resultant", component] => {
            one_of("component", component, &AXES, span)?;
            Ok(Extent::Number)
        }
        ["resultant"] => Err(incomplete("resultant", &AXES, span)),
        [] => Err(incomplete(contact, &quantities, span)),
        [known, ..] if quantities.contains(&known) => {
            let message = format!("`{known}` of a contact has no components");
            Err(Fault::new(span, message).label("ends too late"))
        }
        [other, ..] => Err(unknown("quantity of a contact", other, &quantities, span)),
    }
}

fn one_of(what: &str, word: &str, known: &[&str], span: &Span) -> Result<(), Fault> {
    if known.contains(&word) {
        return Ok(());
    }
    Err(unknown(what, word, known, span))
}

fn unknown(what: &str, word: &str, known: &[&str], span: &Span) -> Fault {
    let near = nearest(word, known.iter().copied()).unwrap_or_default();
    Fault::new(span, format!("unknown {what} `{word}`"))
        .label(format!("the nearest known is `{near}`"))
        .help(format!("known: {}", listed(known.iter().copied())))
}

fn incomplete(word: &str, next: &[&str], span: &Span) -> Fault {
    Fault::new(span, format!("the quantity ends after `{word}`"))
        .label("incomplete")
        .help(format!("add one of {}", listed(next.iter().copied())))
}
