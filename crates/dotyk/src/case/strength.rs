//! `strength` of a material: the criterion of its keys, with a check of its constants.

use crate::case::document::{Entry, Node, Table};
use crate::case::error::Fault;
use crate::case::keys;
use crate::case::suggest::listed;
use crate::fem::FemError;
use crate::model::{Plastic, Strength};

/// The criteria: name, required keys, optional keys.
const CRITERIA: [(&str, &[&str], &[&str]); 4] = [
    ("von Mises", &["yield"], &[]),
    (
        "Mohr–Coulomb",
        &["friction_angle", "cohesion"],
        &["tension"],
    ),
    ("Hoek–Brown", &["sci", "mb", "s", "a"], &[]),
    ("principal stresses", &["compression", "tension"], &[]),
];

/// The strength that a table means.
pub(crate) fn strength(node: &Node) -> Result<Strength, Fault> {
    let table = node.table(keys::STRENGTH)?;
    let written = node.entries()?;
    // `tension` belongs to two of them: the first other key decides
    let first = written.iter().find(|entry| entry.key != "tension");
    let has = |needed: &[&str]| first.is_some_and(|first| needed.contains(&first.key.as_str()));
    let meant = CRITERIA.iter().find(|(_, needed, _)| has(needed));
    let Some(&(criterion, needed, more)) = meant else {
        return Err(Fault::new(table.span, "this is no strength")
            .label("which criterion?")
            .help(known()));
    };
    let belongs = |entry: &&Entry| [needed, more].concat().contains(&entry.key.as_str());
    if let Some(entry) = written.iter().find(|entry| !belongs(entry)) {
        let message = format!("`{}` is none of the keys of {criterion}", entry.key);
        return Err(Fault::new(&entry.key_span, message)
            .label("of another criterion")
            .help(known()));
    }
    let number = |key: &str| {
        table
            .require(key, &format!("the strength of {criterion}"))?
            .number()
    };
    let strength = match needed[0] {
        "yield" => Strength::VonMises {
            yield_stress: number("yield")?,
        },
        "friction_angle" => Strength::MohrCoulomb {
            friction_angle: number("friction_angle")?,
            cohesion: number("cohesion")?,
            tension: table.get("tension").map(Node::number).transpose()?,
        },
        "sci" => Strength::HoekBrown {
            sci: number("sci")?,
            mb: number("mb")?,
            s: number("s")?,
            a: number("a")?,
        },
        _ => Strength::Principal {
            tension: number("tension")?,
            compression: number("compression")?,
        },
    };
    strength
        .check()
        .map_err(|error| out_of_range(&error, table))?;
    Ok(strength)
}

/// The plasticity of a material with a strength, if it has one: `plastic` and its keys.
pub(crate) fn plastic(
    table: Table<'_>,
    strength: Option<&Strength>,
) -> Result<Option<Plastic>, Fault> {
    let yields = table.get("plastic").map(Node::boolean).transpose()?;
    for key in ["dilation", "unload"] {
        if let Some(node) = table.get(key) {
            let message = format!("`{key}` is not supported yet");
            return Err(Fault::new(&node.span, message)
                .label("of ground that yields")
                .help("so far metals yield, by von Mises' criterion with `hardening`"));
        }
    }
    let hardening = table.get("hardening");
    let (Some(true), Some(node)) = (yields, table.get("plastic")) else {
        return match hardening {
            Some(node) => Err(Fault::new(
                &node.span,
                "`hardening` of a material that does not yield",
            )
            .label("without `plastic = true`")
            .help("add `plastic = true`, or leave `hardening` out")),
            None => Ok(None),
        };
    };
    let plastic = Plastic {
        hardening: hardening.map_or(Ok(0.0), Node::number)?,
    };
    match plastic.check(strength) {
        Ok(()) => Ok(Some(plastic)),
        Err(error @ FemError::Material { .. }) => Err(out_of_range(&error, table)),
        Err(error) => Err(Fault::new(&node.span, error.to_string()).label("yields by which law?")),
    }
}

/// A constant that is out of range, at its place.
fn out_of_range(error: &FemError, table: Table<'_>) -> Fault {
    let FemError::Material { name, value, range } = error else {
        return Fault::new(table.span, error.to_string());
    };
    let span = table.get(name).map_or(table.span, |node| &node.span);
    Fault::new(span, format!("`{name}` = {value}: {range}")).label("out of range")
}

/// The criteria with their keys, for messages.
fn known() -> String {
    let one = |(name, needed, more): &(&str, &[&str], &[&str])| {
        let more = match more {
            [] => String::new(),
            more => format!(" and perhaps {}", listed(more.iter().copied())),
        };
        format!("{} ({name}){more}", listed(needed.iter().copied()))
    };
    let all: Vec<String> = CRITERIA.iter().map(one).collect();
    format!(
        "a strength has the keys of one criterion: {}",
        all.join("; ")
    )
}
