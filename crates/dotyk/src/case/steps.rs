//! `[[step]]` of a case file, and `active`, which names steps or their times.

use crate::case::document::{Node, Table, Value, name};
use crate::case::error::Fault;
use crate::case::keys;
use crate::case::suggest::listed;
use crate::geometry::Field;
use crate::model::Active;

/// The load steps of a case.
pub(crate) struct Steps {
    /// At least one, increasing.
    pub times: Vec<f64>,
    /// As many; empty where a step has none.
    pub names: Vec<String>,
    /// Times of those from which on displacements count anew.
    pub zeroed: Vec<f64>,
}

impl Steps {
    /// Those of a case; one at 1 without steps.
    pub fn read(table: Table<'_>) -> Result<Self, Fault> {
        let list = table.list("step")?;
        if let (Some(node), []) = (table.get("step"), list) {
            return Err(Fault::new(&node.span, "the list of steps is empty")
                .label("no step")
                .help("leave out `step` for one step at t = 1"));
        }
        let mut steps = Self {
            times: Vec::new(),
            names: Vec::new(),
            zeroed: Vec::new(),
        };
        for step in list {
            let table = step.table(keys::STEP)?;
            let node = table.require("time", "a step")?;
            let time = node.number()?;
            if let Some(before) = steps.times.last().filter(|before| time <= **before) {
                let message =
                    format!("the times of the steps must increase: {time} follows {before}");
                return Err(Fault::new(&node.span, message).label("not later than the step before"));
            }
            let called = match table.get("name") {
                Some(node) => {
                    let called = name(node)?;
                    if steps.names.contains(&called) {
                        let message = format!("two steps are named `{called}`");
                        return Err(Fault::new(&node.span, message).label("second use of the name"));
                    }
                    called
                }
                None => String::new(),
            };
            let anew = table.get("zero_displacements");
            if anew.map(Node::boolean).transpose()? == Some(true) {
                steps.zeroed.push(time);
            }
            steps.times.push(time);
            steps.names.push(called);
        }
        if steps.times.is_empty() {
            steps = Self {
                times: vec![1.0],
                names: vec![String::new()],
                zeroed: Vec::new(),
            };
        }
        Ok(steps)
    }

    /// The times of a part with the key `active`; always, without it.
    pub fn active(&self, table: Table<'_>) -> Result<Active, Fault> {
        self.read_active(table.get("active"), keys::ACTIVE)
            .map(|read| read.0)
    }

    /// The times that a table of `active` tells.
    pub fn times_of(&self, node: &Node) -> Result<Active, Fault> {
        self.read_active(Some(node), keys::ACTIVE)
            .map(|read| read.0)
    }

    /// The same for a body, with the remaining part of its forces after it has gone.
    pub fn active_body(&self, table: Table<'_>) -> Result<(Active, Option<Field>), Fault> {
        let node = table.get("active");
        let (active, table) = self.read_active(node, keys::ACTIVE_BODY)?;
        let Some(release) = table.and_then(|table| table.get("release")) else {
            return Ok((active, None));
        };
        if active.until.is_infinite() {
            return Err(Fault::new(&release.span, "`release` without `until`")
                .label("the body never goes")
                .help("`release` is what is left of the forces of its contacts after `until`"));
        }
        Ok((active, Some(release.course()?)))
    }

    fn read_active<'n>(
        &self,
        node: Option<&'n Node>,
        known: &'static [&'static str],
    ) -> Result<(Active, Option<Table<'n>>), Fault> {
        let Some(node) = node else {
            return Ok((Active::ALWAYS, None));
        };
        let table = node.table(known)?;
        let time = |key: &str| table.get(key).map(|node| self.time(node)).transpose();
        let (from, until) = (time("from")?, time("until")?);
        if from.is_none() && until.is_none() {
            return Err(Fault::new(&node.span, "`active` has neither `from` nor `until`")
                .label("when?")
                .help("times or names of steps: it is there from the first, and no longer from the second on"));
        }
        let active = Active {
            from: from.unwrap_or(f64::NEG_INFINITY),
            until: until.unwrap_or(f64::INFINITY),
        };
        if !self.times.iter().any(|&time| active.at(time)) {
            let times: Vec<String> = self.times.iter().map(f64::to_string).collect();
            return Err(Fault::new(&node.span, "it is there in no load step")
                .label("never")
                .help(format!("the steps are at t = {}", times.join(", "))));
        }
        Ok((active, Some(table)))
    }

    /// A time, or that of the step of a name.
    fn time(&self, node: &Node) -> Result<f64, Fault> {
        let Value::Text(text) = &node.value else {
            return node.number();
        };
        if let Some(step) = self.names.iter().position(|name| name == text) {
            return Ok(self.times[step]);
        }
        node.number().map_err(|_| {
            let names: Vec<&str> = self
                .names
                .iter()
                .map(String::as_str)
                .filter(|n| !n.is_empty())
                .collect();
            let fault = Fault::new(&node.span, format!("there is no step `{text}`"));
            match names.is_empty() {
                true => fault
                    .label("no step has a name")
                    .help("give the step a `name`, or write its time"),
                false => {
                    let help = format!(
                        "a time, or the name of a step: {}",
                        listed(names.iter().copied())
                    );
                    fault.label("no such step").help(help)
                }
            }
        })
    }
}
