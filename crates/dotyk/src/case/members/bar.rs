//! `[[bar]]` of a case file: bolts, anchors and ties.

use crate::case::document::{Node, Table};
use crate::case::error::Fault;
use crate::case::members::positive;
use crate::case::steps::Steps;
use crate::model::Bar;

pub(crate) const KEYS: &[&str] = &[
    "name",
    "from",
    "to",
    "bodies",
    "bond",
    "free_length",
    "bond_length",
    "young",
    "area",
    "prestress",
    "spacing",
    "count",
    "tension_only",
    "yield",
    "radius",
    "active",
];

/// The law of a bar.
pub(crate) fn read(table: Table<'_>, what: &str, _: &Steps) -> Result<Bar, Fault> {
    let required = |key: &str| table.require(key, what)?.positive(&format!("`{key}`"));
    let (young, area) = (required("young")?, required("area")?);
    Ok(Bar {
        yields: positive(table, "yield")?,
        prestress: table.get("prestress").map(Node::number).transpose()?,
        tension_only: table.get("tension_only").map_or(Ok(false), Node::boolean)?,
        young,
        area,
    })
}
