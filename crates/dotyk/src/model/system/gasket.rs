//! Gaskets as links: each node of their contact presses on a spring that holds for one line of the law.
//!
//! ```text
//!   gap = g₀ − n·(u_s − u_m) + q ≥ 0,   λ ≥ 0,   λ gap = 0        q = α + λ/k,  k = w/β      closure and pressure p = λ/w: q = α + β p
//! ```
//!
//! with the weight w of the node (`nouns/gasket.rs`). The problem of a step has one line for each node; where the pressure lies beyond the
//! ends of its line another one is taken, and the step is solved again, until all lie within theirs: then the law holds exactly. Lines of a
//! growing function lead from one to the next, so that a node alone takes none twice. Many nodes at once may; then they follow one by one,
//! the first of those that lie beyond their lines, which ends as the complementarity problem of such lines has a positive matrix.
//!
//! Source of the last rule: K. G. Murty, Note on a Bard-type scheme for solving the complementarity problem (1974).

use crate::contact::{ContactError, Row};
use crate::model::nouns::error::Error;
use crate::model::nouns::model::Model;
use crate::model::system::condition::{Condition, Elastic};
use crate::model::system::filling::{Filling, Moves, Pressed};
use crate::model::system::joints::carrying;
use crate::model::system::links::{axis, less};
use crate::model::system::parts::{Owner, Parts};
use std::collections::BTreeMap;

/// Fills the contacts that have a gasket, from their states before by name.
///
/// Errors: a law that is none; multipliers that have moved to the other side since.
pub(crate) fn fill<'s, const D: usize>(
    model: &Model<D>,
    conditions: &mut [Condition<D>],
    before: &dyn Fn(&str) -> Option<&'s Filling>,
) -> Result<(), Error<D>> {
    let parts = Parts::of(model);
    for condition in conditions {
        let Some(index) = condition.contact() else {
            continue;
        };
        let contact = &model.contacts[index];
        let (Some(law), Some(part)) = (&contact.gasket, parts.find(Owner::Gasket(index))) else {
            continue;
        };
        let fail = |source| Error::Contact {
            contact: contact.name.clone(),
            source,
        };
        law.check().map_err(|error| {
            fail(ContactError::Gasket {
                why: error.to_string(),
            })
        })?;
        let nodes = condition.interface.nodes.iter();
        let carriers: Vec<usize> = nodes.map(|node| node.node).collect();
        let side = carrying(condition);
        let filling = match before(&contact.name) {
            Some(known) if known.side == side && known.carriers == carriers => known.clone(),
            Some(known) if known.nodes.iter().any(|at| at.set > 0.0) => {
                let why = "the nodes that carry its forces have changed, by supports or parts that have come or gone: name `nonmortar` and `mortar` of the contact".to_string();
                return Err(fail(ContactError::Gasket { why }));
            }
            _ => Filling {
                law: law.clone(),
                side,
                nodes: vec![Pressed::default(); carriers.len()],
                carriers,
            },
        };
        let mut elastic = Elastic::default();
        let mut rows: Vec<Row<D>> = vec![Row::new(); condition.interface.nonmortar.len()];
        for (node, &at) in condition.interface.nodes.iter().zip(&filling.nodes) {
            let Some(row) = node.rows[0] else { continue };
            let line = filling.line(at);
            let stiffness = node.weight / line.softness;
            rows[row] = less(elastic.stiffness.len(), 0);
            elastic.stiffness.push(axis::<D>(0).map(|c| c * stiffness));
            elastic
                .load
                .push(axis::<D>(0).map(|c| c * stiffness * line.set));
        }
        condition.further = vec![(part, rows)];
        condition.elastic = Some(elastic);
        condition.touch.filling = Some(filling);
    }
    Ok(())
}

impl<const D: usize> Condition<D> {
    /// Pressures at the nodes of a gasket under forces `lambda` (m of the condition,), by place.
    fn pressures(&self, lambda: &[f64]) -> BTreeMap<usize, f64> {
        let nodes = self.interface.nodes.iter().enumerate();
        let pressed = nodes.filter_map(|(place, node)| {
            Some((place, (lambda[node.rows[0]?] / node.weight).max(0.0)))
        });
        pressed.collect()
    }

    /// The closure of a gasket at a place under forces `lambda` (m of the condition,); `None` without one, or without a multiplier there.
    pub fn closure(&self, place: usize, lambda: &[f64]) -> Option<f64> {
        let filling = self.touch.filling.as_ref()?;
        let node = &self.interface.nodes[place];
        Some(filling.closure(place, lambda[node.rows[0]?] / node.weight))
    }

    /// How far each node of the nonmortar side has come into a gasket under such forces, at a corner into both faces at once; empty without
    /// one.
    pub fn closures(&self, lambda: &[f64]) -> BTreeMap<usize, f64> {
        let mut deep: BTreeMap<usize, f64> = BTreeMap::new();
        for (place, node) in self.interface.nodes.iter().enumerate() {
            if let Some(closure) = self.closure(place, lambda) {
                let own = deep.entry(node.node).or_default();
                *own = own.hypot(closure);
            }
        }
        deep
    }

    /// The state of its gasket after a step with such forces.
    pub fn filled_after(&self, lambda: &[f64]) -> Option<Filling> {
        let filling = self.touch.filling.as_ref()?;
        Some(filling.after(&self.pressures(lambda)))
    }

    /// Its gasket on other lines; `None` if the forces lie on those that it has.
    pub fn filled_otherwise(&self, lambda: &[f64], moves: Moves) -> Option<Filling> {
        let filling = self.touch.filling.as_ref()?;
        filling.on_lines_of(&self.pressures(lambda), moves)
    }
}
