//! `[[probe]]` of a case file: values to be read off the solution, checked before the solution.

use crate::case::contact::{Sought, side_ref};
use crate::case::document::{Entry, Node, Table, Value, coordinates};
use crate::case::error::Fault;
use crate::case::keys;
use crate::case::points::place;
use crate::case::suggest::listed;
use crate::geometry::{Field, distance};
use crate::model::{
    Along, Body, BodyId, Contact, Error, Member, Mistake, Probe, Quantity, QuantityError, Reading,
    Section, SectionQuantity, Subject,
};

fn reductions<const D: usize>() -> [(&'static str, Reading<D>); 4] {
    [
        ("max", Reading::Largest),
        ("min", Reading::Smallest),
        ("mean", Reading::Mean),
        ("integral", Reading::Integral),
    ]
}

const UNKNOWN: [&str; 2] = ["the nearest known", "known"];

/// What probes read beside bodies.
pub(crate) struct Owners<'a, const D: usize> {
    /// Names of all probes.
    pub probes: &'a [&'a str],
    pub contacts: &'a [Contact<D>],
    /// Bodies between which contacts were sought.
    pub sought: &'a [Sought],
    pub sections: &'a [Section<D>],
    pub members: &'a [Member<D>],
}

/// One probe on these bodies and contacts.
pub(crate) fn probe<const D: usize>(
    node: &Node,
    bodies: &mut [Body<D>],
    owners: &Owners<'_, D>,
) -> Result<Probe<D>, Fault> {
    let table = node.table(keys::PROBE)?;
    let name = label(table.require("name", "a probe")?)?;
    if let Some(entry) = table.entry("expression") {
        return formula(table, name, entry, owners.probes);
    }
    let quantity_node = table.require("quantity", "a probe")?;
    let Owners {
        probes: _,
        contacts,
        sought,
        sections,
        members,
    } = *owners;
    let contacts: Vec<&str> = contacts.iter().map(|c| c.name.as_str()).collect();
    let cut: Vec<&str> = sections.iter().map(|s| s.name.as_str()).collect();
    let named = [&contacts[..], &cut];
    let text = quantity_node.text()?;
    let owner = text.split('.').next().unwrap_or_default();
    let absent = !contacts.contains(&owner) && sought.iter().any(|sought| sought.would_be(owner));
    let parsed = match absent {
        true => Quantity::of_absent::<D>(text, owner),
        false => Quantity::parse(text, bodies, named, members),
    };
    let quantity = parsed.map_err(|error| fault(quantity_node, &error))?;
    refuse_beside_stations(table, &quantity, quantity_node, sections)?;
    let along = table.get("along").map(|node| along(node, bodies));
    let along = along.transpose()?;
    if quantity.needs_side() && !matches!(along, Some(Along::Side(_))) {
        let message = format!("`{quantity}` is normal to a side, and needs one");
        return Err(Fault::new(&quantity_node.span, message)
            .label("normal to what?")
            .help("add `along = \"BODY.SIDE\"`"));
    }
    Ok(Probe {
        minus_rigid: minus_rigid(table, &quantity, bodies)?,
        center: center(table, &quantity)?,
        factor: factor(table, &quantity)?,
        reading: reading(table, &name, &quantity, along.as_ref(), bodies)?,
        along,
        name,
        quantity,
    })
}

/// A number of the values of other probes, which has no other keys.
fn formula<const D: usize>(
    table: Table<'_>,
    name: String,
    entry: &Entry,
    probes: &[&str],
) -> Result<Probe<D>, Fault> {
    let mut others = keys::PROBE
        .iter()
        .filter(|key| !["name", "expression"].contains(*key));
    if let Some(other) = others.find_map(|key| table.entry(key)) {
        let message = format!(
            "probe `{name}` is an expression of other probes, and has no `{}`",
            other.key
        );
        return Err(Fault::new(&other.key_span, message)
            .label("superfluous beside `expression`")
            .help("give the probes that the expression names their own `quantity` and place"));
    }
    let formula = entry.node.formula(probes)?;
    Ok(Probe::new(
        &name,
        Quantity::of_formula(formula),
        Reading::Whole,
    ))
}

/// The error of a formula at its place among the tables of probes.
pub(crate) fn formula_fault<const D: usize>(error: &Error<D>, probes: &[Node]) -> Fault {
    let fields = probes.iter().map(|node| node.entries().unwrap_or_default());
    let field = |fields: &[Entry], key: &str| fields.iter().position(|entry| entry.key == key);
    let found = fields.into_iter().find_map(|fields| {
        let name = fields[field(fields, "name")?].node.text().ok()?;
        let own = error.subject() == Some(Subject::Probe(name.to_string()));
        own.then_some(&fields[field(fields, "expression")?].node)
    });
    let span = found.map_or(0..0, |node| node.span.clone());
    Fault::new(&span, error.to_string()).label("this expression")
}

/// Refuses, for a section, a utilisation without a capacity, and places other than stations.
fn refuse_beside_stations<const D: usize>(
    table: Table<'_>,
    quantity: &Quantity,
    node: &Node,
    sections: &[Section<D>],
) -> Result<(), Fault> {
    if let Some((section, SectionQuantity::AxialMoment)) = quantity.of_section()
        && sections[section].places > 1
    {
        let message = format!(
            "section `{}` tells M2 of whole cuts alone",
            sections[section].name
        );
        return Err(Fault::new(&node.span, message)
            .label("at places along the axis N tells it")
            .help("add a section without `places`"));
    }
    if let Some((section, SectionQuantity::Utilisation)) = quantity.of_section()
        && sections[section].capacity.is_none()
    {
        let message = format!(
            "section `{}` has no capacity to be used",
            sections[section].name
        );
        return Err(Fault::new(&node.span, message)
            .label("utilisation of what?")
            .help("add `capacity = { compression = .. }` to the section"));
    }
    let mut others = ["along", "mean_of_neighbours"].into_iter();
    match others.find_map(|key| table.entry(key)) {
        Some(entry) if quantity.is_of_stations() => {
            let places = match quantity.is_of_bed() {
                true => "points of integration",
                false => "stations",
            };
            let message = format!("`{quantity}` is known at {places}, and not `{}`", entry.key);
            Err(Fault::new(&entry.key_span, message)
                .label("not there")
                .help("give `at`, a point of which the nearest one is read, or `reduce`"))
        }
        _ => Ok(()),
    }
}

/// A probe's name is only a label, not part of a file name or quantity, so it may have blanks.
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
        Mistake::NoStrength => fault.label("nothing to compare the stress with"),
        Mistake::NotPlastic => fault.label("nothing yields"),
        Mistake::NoWater => fault.label("no water"),
        Mistake::NoBed if error.known.is_empty() => fault.label("no springs there"),
        Mistake::NoBed => fault
            .label("no springs there")
            .help(format!("the body has beds at {}", listed(known))),
    }
}

/// How values of all places become one, as a help.
const REDUCE: &str = "`reduce = \"max\"`, \"min\", \"mean\" or \"integral\"";

/// Most points of a line: each is located in the cells, and gives a row for each step.
const MOST_POINTS: usize = 1_000_000;

/// How a line is written.
fn written_line<const D: usize>() -> String {
    let point = coordinates::<D>();
    format!("{{ from = {point}, to = {point}, points = 50 }}")
}

/// A line from one point to another, or "BODY.SIDE", or a list of sides.
fn along<const D: usize>(node: &Node, bodies: &mut [Body<D>]) -> Result<Along<D>, Fault> {
    match node.value {
        Value::Table(_) => line(node, bodies),
        Value::Text(_) | Value::List(_) => side_ref(node, bodies).map(Along::Side),
        _ => Err(node.expected(&format!("\"BODY.SIDE\" or {}", written_line::<D>()))),
    }
}

fn line<const D: usize>(node: &Node, bodies: &[Body<D>]) -> Result<Along<D>, Fault> {
    let table = node.table(keys::ALONG)?;
    let what = "a line";
    let from = place(table.require("from", what)?, bodies)?;
    let end = table.require("to", what)?;
    let to = place(end, bodies)?;
    if distance(from, to) == 0.0 {
        let message = "a line ends at another point than it begins at";
        return Err(Fault::new(&end.span, message).label("the same as `from`"));
    }
    let count = table.require("points", what)?;
    let points = count.positive_integer("`points`")?;
    if !(2..=MOST_POINTS).contains(&points) {
        let message = format!("a line has 2 to {MOST_POINTS} points, both ends included");
        return Err(Fault::new(&count.span, message).label(format!("{points}")));
    }
    Ok(Along::Line { from, to, points })
}

/// The reading: a field needs `at`, `along` or `reduce`, a number none of them; neighbours are those of a point.
fn reading<const D: usize>(
    table: Table<'_>,
    name: &str,
    quantity: &Quantity,
    along: Option<&Along<D>>,
    bodies: &[Body<D>],
) -> Result<Reading<D>, Fault> {
    let reduced = table.get("reduce");
    let reduced = reduced
        .map(|node| node.choice("reduction", &reductions()))
        .transpose()?;
    let at = table
        .get("at")
        .map(|node| place(node, bodies))
        .transpose()?;
    let mean = table.get("mean_of_neighbours");
    let mean = mean.map_or(Ok(false), Node::boolean)?;
    let mut places = ["at", "along", "reduce"]
        .into_iter()
        .filter_map(|key| table.entry(key));
    if let (false, Some(entry)) = (quantity.is_field(), places.next()) {
        let message = format!(
            "`{quantity}` of probe `{name}` is one number and takes no `{}`",
            entry.key
        );
        return Err(Fault::new(&entry.key_span, message).label("superfluous"));
    }
    refuse_contradiction(table, name, quantity, along)?;
    refuse_rotation(table, quantity, bodies)?;
    match (at, reduced, table.entry("mean_of_neighbours")) {
        // without a place the force of a member is the largest
        (None, None, _) if quantity.is_field() && !quantity.is_of_member() && along.is_none() => {
            Err(Fault::new(
                table.span,
                format!("probe `{name}` must say where: `at`, `along` or `reduce` is missing"),
            )
            .label("`at`, `along` or `reduce` is missing")
            .help(match quantity.is_of_stations() {
                true => format!("add `at = {}` or {}", coordinates::<D>(), REDUCE),
                false => format!(
                    "add `at = {}`, or `along = {}`, or `along = \"BODY.SIDE\"`, or {REDUCE}",
                    coordinates::<D>(),
                    written_line::<D>()
                ),
            }))
        }
        (None, _, Some(entry)) if mean => {
            let message = format!("`mean_of_neighbours` of probe `{name}` needs `at`");
            Err(Fault::new(&entry.key_span, message).label("neighbours of what?"))
        }
        (Some(point), _, _) if mean => Ok(Reading::MeanOfNeighbours(point)),
        (Some(point), _, _) => Ok(coupled(table, quantity, bodies).unwrap_or(Reading::At(point))),
        (None, reduced, _) => Ok(reduced.unwrap_or(Reading::Whole)),
    }
}

/// Allows one of `at`, `along` and `reduce`, except that a stress or displacement of a body can be reduced along a side.
fn refuse_contradiction<const D: usize>(
    table: Table<'_>,
    name: &str,
    quantity: &Quantity,
    along: Option<&Along<D>>,
) -> Result<(), Fault> {
    let (at, reduce) = (table.entry("at"), table.entry("reduce"));
    let both = |entry: &Entry, first: &str| {
        let message = format!("probe `{name}` has both `{first}` and `{}`", entry.key);
        Fault::new(&entry.key_span, message).label("give one of the two")
    };
    match (at, table.entry("along"), reduce) {
        (Some(_), Some(entry), _) | (Some(_), None, Some(entry)) => Err(both(entry, "at")),
        (None, Some(_), Some(reduce)) => {
            let help = match along {
                Some(Along::Side(_)) if quantity.is_of_contact() => {
                    "a reduction of a contact runs over its whole nonmortar side: leave out `along`"
                }
                Some(Along::Side(_)) => return Ok(()),
                _ => {
                    "a reduction runs over the whole body, or along a side: `along = \"BODY.SIDE\"`"
                }
            };
            Err(both(reduce, "along").help(help))
        }
        _ => Ok(()),
    }
}

/// Errors: a rotation at a place that is not the point of a couple of its body.
fn refuse_rotation<const D: usize>(
    table: Table<'_>,
    quantity: &Quantity,
    bodies: &[Body<D>],
) -> Result<(), Fault> {
    if !quantity.is_rotation() || coupled(table, quantity, bodies).is_some() {
        return Ok(());
    }
    let message = format!("`{quantity}` is that of the point of a couple, and is read at one");
    let span = ["at", "along", "reduce"]
        .into_iter()
        .find_map(|key| table.entry(key));
    let couples = quantity.displaced_body().map(|body| &bodies[body]);
    let names = couples.into_iter().flat_map(|body| {
        let couples = body.couples.iter();
        couples.map(|couple| format!("`at = \"{}.{}\"`", body.name, couple.name))
    });
    let names: Vec<String> = names.collect();
    let fault = Fault::new(span.map_or(table.span, |entry| &entry.node.span), message);
    Err(match names.is_empty() {
        true => fault.label("the body has no couple"),
        false => fault
            .label("no point of a couple of the body")
            .help(format!("say {}", names.join(" or "))),
    })
}

/// The point of a couple of the body whose displacement or rotation is read.
fn coupled<const D: usize>(
    table: Table<'_>,
    quantity: &Quantity,
    bodies: &[Body<D>],
) -> Option<Reading<D>> {
    let (body, name) = table.get("at")?.text().ok()?.split_once('.')?;
    let read = &bodies[quantity.displaced_body()?];
    let place = read.couples.iter().position(|couple| couple.name == name)?;
    (read.name == body).then_some(Reading::Coupled(place))
}

/// Centre of a hoop stress or a moment; the origin by default.
fn center<const D: usize>(table: Table<'_>, quantity: &Quantity) -> Result<[f64; D], Fault> {
    match table.entry("center") {
        None => Ok([0.0; D]),
        Some(entry) if quantity.has_center() => entry.node.point(),
        Some(entry) => {
            let owners = if D == 2 { "hoop stresses" } else { "moments" };
            let message = format!("`center` belongs to {owners}, and not to `{quantity}`");
            Err(Fault::new(&entry.key_span, message).label("says nothing here"))
        }
    }
}

/// The factor of each value: an expression, of t alone for what is one number.
fn factor(table: Table<'_>, quantity: &Quantity) -> Result<Option<Field>, Fault> {
    let Some(node) = table.get("factor") else {
        return Ok(None);
    };
    let factor = match quantity.is_field() {
        true => node.field()?,
        false => node.course()?,
    };
    if factor.is_sampled() {
        let message = "the factor of a probe is a number or an expression";
        return Err(Fault::new(&node.span, message).label("a function"));
    }
    Ok(Some(factor))
}

fn minus_rigid<const D: usize>(
    table: Table<'_>,
    quantity: &Quantity,
    bodies: &[Body<D>],
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
