//! Values of formulas, after those of the probes that they take, in whatever order the model has them.

use crate::model::nouns::error::{Error, ProbeError};
use crate::model::nouns::formula::Formula;
use crate::model::nouns::model::{Model, Probe};
use crate::model::nouns::solution::ProbeValue;
use std::collections::{HashMap, HashSet};

/// Gives the probes that are formulas their values, of those of the other probes, which stand among `values` already; NaN where a
/// probe is not there or has no value.
pub(crate) fn compute<const D: usize>(model: &Model<D>, values: &mut [ProbeValue], time: f64) {
    let mut known: HashMap<String, f64> = HashMap::new();
    for (probe, value) in model.probes.iter().zip(values.iter()) {
        if probe.quantity.formula().is_none() {
            known.insert(value.name.clone(), value.value);
        }
    }
    let (order, _) = ordered(&model.probes);
    for (place, formula) in order {
        let value = &mut values[place];
        value.value = formula.value(|name| known.get(name).copied(), time);
        known.insert(value.name.clone(), value.value);
    }
}

/// The place and the formula of a probe.
type Placed<'a> = (usize, &'a Formula);

/// The formulas among probes, each after those that it takes, and those that wait for each other.
fn ordered<const D: usize>(probes: &[Probe<D>]) -> (Vec<Placed<'_>>, Vec<Placed<'_>>) {
    let all = probes.iter().enumerate();
    let formulas = all.filter_map(|(place, probe)| Some((place, probe.quantity.formula()?)));
    let mut waiting: Vec<Placed<'_>> = formulas.collect();
    let mut order = Vec::new();
    loop {
        let names = waiting.iter().map(|(place, _)| &probes[*place].name);
        let names: HashSet<&String> = names.collect();
        let waits = |(_, f): &Placed<'_>| f.probes().iter().any(|name| names.contains(name));
        let (later, now): (Vec<_>, Vec<_>) = waiting.into_iter().partition(waits);
        if now.is_empty() {
            return (order, later);
        }
        order.extend(now);
        waiting = later;
    }
}

/// The names from a formula that depends on itself to itself again; `None` where none does.
fn circle<const D: usize>(probes: &[Probe<D>]) -> Option<Vec<&str>> {
    let (_, left) = ordered(probes);
    let waits = |name: &str| left.iter().find(|(place, _)| probes[*place].name == name);
    let mut way: Vec<&str> = Vec::new();
    let mut next = left.first()?;
    loop {
        let name = probes[next.0].name.as_str();
        let before = way.iter().position(|other| *other == name);
        way.push(name);
        if let Some(before) = before {
            return Some(way.split_off(before));
        }
        // what waits takes one that waits
        next = next.1.probes().iter().find_map(|name| waits(name))?;
    }
}

impl<const D: usize> Model<D> {
    /// Checks that formulas take probes of one number, and none of them itself.
    ///
    /// Errors: the probe of such a formula.
    pub(crate) fn check_formulas(&self) -> Result<(), Error<D>> {
        let named = self.probes.iter().map(|probe| (&probe.name, probe));
        let probes: HashMap<&String, &Probe<D>> = named.collect();
        let wrong = |probe: &str, source| {
            let probe = probe.to_string();
            Err(Error::Probe { probe, source })
        };
        for probe in &self.probes {
            for name in probe.quantity.formula().map_or(&[][..], Formula::probes) {
                let name = name.clone();
                match probes.get(&name) {
                    None => return wrong(&probe.name, ProbeError::NoProbe { name }),
                    Some(other) if other.is_line() => {
                        return wrong(&probe.name, ProbeError::OfLine { name });
                    }
                    Some(_) => {}
                }
            }
        }
        let Some(way) = circle(&self.probes) else {
            return Ok(());
        };
        let told = way.join(" → ");
        wrong(way[0], ProbeError::Circular { way: told })
    }
}
