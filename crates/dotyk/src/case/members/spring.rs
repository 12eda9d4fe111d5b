//! `[[spring]]` of a case file: springs between two places.

use crate::case::document::{Node, Table};
use crate::case::error::Fault;
use crate::case::steps::Steps;
use crate::model::{Acts, SpringBetween};

pub(crate) const KEYS: &[&str] = &[
    "name",
    "from",
    "to",
    "bodies",
    "stiffness",
    "acts",
    "gap",
    "spacing",
    "count",
    "radius",
    "active",
];

/// The law of a spring.
pub(crate) fn read(table: Table<'_>, what: &str, _: &Steps) -> Result<SpringBetween, Fault> {
    let stiffness = table.require("stiffness", what)?;
    let known = Acts::ALL.map(|acts| (acts.name(), acts));
    let acts = table.get("acts");
    Ok(SpringBetween {
        stiffness: stiffness.positive("`stiffness`")?,
        acts: acts.map_or(Ok(Acts::Both), |node| node.choice("way to act", &known))?,
        gap: table.get("gap").map_or(Ok(0.0), Node::number)?,
    })
}
