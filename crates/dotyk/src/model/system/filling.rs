//! State of a gasket (`gasket.rs`): what stays of its closure at each node, and the line of its law that holds there.

use crate::model::nouns::gasket::{Branch, Gasket};
use std::collections::BTreeMap;

/// The state of a gasket at a node.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(crate) struct Pressed {
    /// Closure that stays without pressure.
    pub set: f64,
    /// The line that holds, by its number.
    pub branch: usize,
}

/// The state of a gasket at all nodes of its contact.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Filling {
    pub law: Gasket,
    /// The side that carries the multipliers.
    pub side: (String, bool),
    /// Its nodes, by place.
    pub carriers: Vec<usize>,
    /// By place.
    pub nodes: Vec<Pressed>,
}

/// Which nodes take other lines after a solution, and which ones.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Moves {
    /// All, the lines on which their pressures lie: fast.
    All,
    /// All, the next ones.
    Next,
    /// The first one alone, the next one: no set of lines comes twice, but there are many of them. Murty's rule of the least index.
    First,
}

/// Pressures are on a line up to this part of the largest one: the error of forces that a certificate allows. Where lines meet, either is
/// right.
const ON_LINE: f64 = 1e-7;

impl Filling {
    /// The line of a state.
    pub fn line(&self, at: Pressed) -> Branch {
        let branches = self.law.branches(at.set);
        let own = branches.iter().find(|branch| branch.id == at.branch);
        *own.unwrap_or(&branches[0])
    }

    /// The closure at a node of this place on its line, at a pressure.
    pub fn closure(&self, place: usize, pressure: f64) -> f64 {
        let line = self.line(self.nodes[place]);
        line.set + line.softness * pressure
    }

    /// The state after a step with these pressures, by place: what stays of the largest closure.
    pub fn after(&self, pressures: &BTreeMap<usize, f64>) -> Self {
        let mut after = self.clone();
        for (&place, &pressure) in pressures {
            let at = &mut after.nodes[place];
            let set = self.law.set_by(pressure);
            if set > at.set * (1.0 + ON_LINE) {
                at.set = set;
            }
        }
        after
    }

    /// The same with other lines, those on which these pressures lie or towards them; `None` where all lie on their lines.
    pub fn on_lines_of(&self, pressures: &BTreeMap<usize, f64>, moves: Moves) -> Option<Self> {
        let largest = pressures.values().fold(0.0, |most: f64, p| most.max(*p));
        let rounding = ON_LINE * largest;
        let mut next = self.clone();
        for (&place, &pressure) in pressures {
            let at = &mut next.nodes[place];
            let branches = self.law.branches(at.set);
            let own = branches.iter().position(|branch| branch.id == at.branch);
            let own = own.unwrap_or(0);
            let inside = |branch: &Branch| {
                pressure >= branch.low - rounding && pressure <= branch.high + rounding
            };
            if inside(&branches[own]) {
                continue;
            }
            let there = branches.iter().position(inside).unwrap_or(own);
            let goal = match moves {
                Moves::All => there,
                Moves::Next | Moves::First => there.clamp(own.saturating_sub(1), own + 1),
            };
            at.branch = branches[goal].id;
            if moves == Moves::First && goal != own {
                break;
            }
        }
        (next != *self).then_some(next)
    }
}
