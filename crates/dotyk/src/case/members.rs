//! Members of a case file: the readers of all kinds, and of the line that all of them have.

mod anchor;
mod bar;
mod bolt;
mod spring;

use crate::case::contact::side_ref;
use crate::case::document::{Node, Table, Value, name};
use crate::case::error::Fault;
use crate::case::keys;
use crate::case::points::{named_body, place};
use crate::case::steps::Steps;
use crate::model::{
    Analysis, Body, BodyId, Bond, Line, Member, MemberEnd, MemberError, MemberKind, MemberWords,
};

macro_rules! readers {
    ($($file:ident::$kind:ident)*) => {
        /// The keys of each kind, in the order of [`MemberKind::ALL`].
        pub(crate) const KEYS: [&[&str]; MemberKind::ALL.len()] = [$($file::KEYS,)*];

        /// The law of a member of each kind.
        const READERS: [fn(Table<'_>, &str, &Steps) -> Result<MemberKind, Fault>; KEYS.len()] =
            [$(|table, what, steps| $file::read(table, what, steps).map(MemberKind::$kind),)*];
    };
}

readers! {
    bar::Bar
    spring::SpringBetween
    bolt::Bolt
}

/// All members of a case, kind by kind, each with its node.
pub(crate) fn members<'n, const D: usize>(
    case: Table<'n>,
    bodies: &mut [Body<D>],
    analysis: Analysis,
    steps: &Steps,
) -> Result<Vec<(Member<D>, &'n Node)>, Fault> {
    let mut members = Vec::new();
    for ((kind, keys), read) in MemberKind::ALL.iter().zip(KEYS).zip(READERS) {
        for node in case.list(kind.key)? {
            let table = node.table(keys)?;
            let name = name(table.require("name", &format!("a {}", kind.key))?)?;
            let what = format!("{} `{name}`", kind.key);
            let active = steps.active(table)?;
            let mut law = read(table, &what, steps)?;
            let line = match &mut law {
                MemberKind::Bolt(bolt) => {
                    bolt.axis = bolt::axis::<D>(table)?;
                    bolt::line(table, (&name, &what), bodies)?
                }
                _ => line(table, (kind, &what), (&mut *bodies, analysis))?,
            };
            let member = Member {
                active,
                kind: law,
                line,
                name,
            };
            match anchor::bond_length(table, &member, (&*bodies, analysis))? {
                None => members.push((member, node)),
                Some(place) => {
                    let parts = anchor::parts(member, place);
                    refuse_taken(case, &parts[1].name, node)?;
                    members.extend(parts.map(|part| (part, node)));
                }
            }
        }
    }
    Ok(members)
}

/// Refuses the name of the bond of an anchor where another part has it.
fn refuse_taken(case: Table<'_>, name: &str, node: &Node) -> Result<(), Fault> {
    let kinds = MemberKind::ALL.iter().map(|kind| kind.key);
    for key in ["body", "contact", "section"].into_iter().chain(kinds) {
        for other in case.list(key)? {
            let mut entries = other.entries().unwrap_or_default().iter();
            let own = entries.find(|entry| entry.key == "name");
            if own.is_some_and(|entry| entry.node.text().is_ok_and(|text| text == name)) {
                let message = format!("a {key} has the name `{name}`, which is that of the bond");
                return Err(Fault::new(&node.span, message)
                    .label("its bond is told by this name")
                    .help("choose another name for one of the two"));
            }
        }
    }
    Ok(())
}

/// The positive number of a key; `None` without the key.
pub(crate) fn positive(table: Table<'_>, key: &str) -> Result<Option<f64>, Fault> {
    let node = table.get(key);
    node.map(|node| node.positive(&format!("`{key}`")))
        .transpose()
}

/// How many members there are around the axis; `None` without axial symmetry.
fn count(
    table: Table<'_>,
    (kind, what): (&MemberWords, &str),
    analysis: Analysis,
) -> Result<Option<usize>, Fault> {
    let plural = kind.plural;
    match (table.entry("count"), analysis) {
        (Some(entry), Analysis::Axisymmetric) => {
            let count = entry
                .node
                .positive_integer(&format!("the number of {plural}"));
            count.map(Some)
        }
        (Some(entry), _) => {
            let message = format!("`count` is that of {plural} around the axis of symmetry");
            Err(Fault::new(&entry.key_span, message).label("not in this analysis"))
        }
        (None, Analysis::Axisymmetric) => Err(Fault::new(
            table.span,
            format!("{what} stands for those all around the axis of symmetry"),
        )
        .label("`count` is missing")
        .help(format!(
            "add `count`, how many {plural} there are in the full turn, spread evenly"
        ))),
        (None, _) => Ok(None),
    }
}

const BONDS: [(&str, Bond); 2] = [("ends", Bond::Ends), ("grouted", Bond::Grouted)];

/// The line of a member; a kind without the key `bond` is held at its ends.
fn line<const D: usize>(
    table: Table<'_>,
    (kind, what): (&MemberWords, &str),
    (bodies, analysis): (&mut [Body<D>], Analysis),
) -> Result<Line<D>, Fault> {
    let MemberWords {
        key: word, plural, ..
    } = kind;
    let (spacing, radius) = (positive(table, "spacing")?, positive(table, "radius")?);
    let count = count(table, (kind, what), analysis)?;
    if let (Some(_), Some(entry)) = (count, table.entry("spacing")) {
        let message = format!("with axial symmetry `count` says how many {plural} there are");
        return Err(Fault::new(&entry.key_span, message).label("not with axial symmetry"));
    }
    if let (3, Some(entry)) = (D, table.entry("spacing")) {
        let message = format!("`spacing` is the distance of {plural} across a plane model");
        return Err(Fault::new(&entry.key_span, message)
            .label("not in space")
            .help(format!("in space each {word} is there by itself")));
    }
    let bond = table.get("bond");
    let bond = bond.map_or(Ok(Bond::Ends), |node| node.choice("bond", &BONDS))?;
    let end_of = format!("the end of a {word}");
    let ends = ["from", "to"].map(|key| end(table.require(key, what)?, &end_of, bodies));
    let [from, to] = ends;
    let mut line = Line {
        ends: [from?, to?],
        bodies: Vec::new(),
        bond,
        spacing,
        count,
        radius: [radius; 2],
    };
    line.bodies = bodies_of(table, &line, what, bodies)?;
    if let (false, Some(entry)) = (line.ends_at_points(), table.entry("radius")) {
        let message = format!("`radius` is of ends at points, and {what} has none");
        return Err(Fault::new(&entry.key_span, message).label("superfluous"));
    }
    Ok(line)
}

/// A point, or `{ side = "BODY.SIDE" }`.
pub(crate) fn end<const D: usize>(
    node: &Node,
    what: &str,
    bodies: &mut [Body<D>],
) -> Result<MemberEnd<D>, Fault> {
    match node.value {
        Value::Table(_) => {
            let table = node.table(keys::MEMBER_END)?;
            let side = table.require("side", what)?;
            side_ref(side, bodies).map(MemberEnd::Side)
        }
        _ => place(node, bodies).map(MemberEnd::Point),
    }
}

/// The bodies in which its points lie.
fn bodies_of<const D: usize>(
    table: Table<'_>,
    line: &Line<D>,
    what: &str,
    bodies: &[Body<D>],
) -> Result<Vec<BodyId>, Fault> {
    let needed = line.ends_at_points() || line.bond == Bond::Grouted;
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
        let place = named_body(text, &node.span, bodies)?;
        if found.contains(&BodyId(place)) {
            let message = format!("{what} names the body `{text}` twice");
            return Err(Fault::new(&node.span, message).label("second time"));
        }
        found.push(BodyId(place));
    }
    Ok(found)
}

/// An error of a member in the model, at its place in the text.
pub(crate) fn fault<const D: usize>(error: &MemberError, node: &Node, member: &Member<D>) -> Fault {
    let mut entries = node.entries().unwrap_or_default().iter();
    let entry = entries.find(|entry| entry.key == error.key);
    let span = entry.map_or(&node.span, |entry| &entry.node.span);
    let message = format!("{} `{}`: {error}", member.kind.words().key, member.name);
    let fault = Fault::new(span, message).label(error.label.as_str());
    match error.help {
        "" => fault,
        help => fault.help(help),
    }
}
