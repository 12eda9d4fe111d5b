//! *EQUATION, as far as it is a support, a pair of equal motion or a rigid side.
//!
//! * One term: the degree of freedom is held, u = 0.
//! * Two terms that make all displacements of two coincident nodes equal: the two are one node.
//! * Two terms each, which make one component of many nodes equal, while the other components are held alike or made equal, too: the
//!   nodes move as a rigid side that does not turn.
//!
//! Anything else has no counterpart, and is refused at its line.

use crate::deck::{Coupling, Deck, Index, Motion};
use crate::error::Fault;
use crate::lines::{Card, Place};
use std::collections::{BTreeMap, BTreeSet};

/// Part of the size of the model within which two nodes coincide.
const COINCIDENT: f64 = 1e-9;

/// Part of a coefficient by which the other may miss it.
const EQUAL: f64 = 1e-9;

/// u of two nodes along an axis is equal.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Equal {
    place: Place,
    pub nodes: [Index; 2],
    freedom: u8,
}

/// The equations of a card: those that make two components equal, and nodes whose component is held.
pub(crate) type Read = (Vec<Equal>, Vec<(Place, Index, u8)>);

/// Reads a card.
///
/// Errors: a card that is cut off; equations of another kind.
pub(crate) fn read(deck: &Deck, card: &Card) -> Result<Read, Fault> {
    if card.get("REMOVE").is_some() {
        return Err(card.fault("REMOVE is not supported"));
    }
    let (mut equal, mut held) = (Vec::new(), Vec::new());
    let mut rows = card.rows.iter();
    while let Some(first) = rows.next() {
        let count = first.id(card, 0, "the number of terms")? as usize;
        let mut terms: Vec<(Index, u8, f64)> = Vec::new();
        while terms.len() < count {
            let Some(row) = rows.next() else {
                let message = format!("the equation has {} of {count} terms", terms.len());
                return Err(card.fault_at(first.place, message));
            };
            if row.fields.len() % 3 != 0 {
                let message = "terms are a node, a degree of freedom and a coefficient each";
                return Err(card.fault_at(row.place, message));
            }
            for term in 0..row.fields.len() / 3 {
                let number = row.id(card, 3 * term, "a node")?;
                let freedom = row.freedom(card, 3 * term + 1)?;
                let factor = row.number(card, 3 * term + 2, "a coefficient")?;
                terms.push((deck.node(card, row.place, number)?, freedom, factor));
            }
        }
        match terms[..] {
            [(node, freedom, factor)] if factor != 0.0 => held.push((first.place, node, freedom)),
            [(a, freedom, one), (b, other, two)]
                if freedom == other
                    && a != b
                    && (one + two).abs() <= EQUAL * one.abs()
                    && one != 0.0 =>
            {
                equal.push(Equal {
                    place: first.place,
                    nodes: [a, b],
                    freedom,
                });
            }
            _ => {
                let message = "supported are one term, and two terms of the same degree of freedom with opposite coefficients: use *RIGID BODY, *COUPLING or *TIE";
                return Err(card.fault_at(first.place, message));
            }
        }
    }
    Ok((equal, held))
}

/// Nodes that are one: the second of each, named once, is to be replaced by the first, which stays. Their equations leave the list.
pub(crate) fn same(deck: &Deck, equal: &mut Vec<Equal>, axes: usize) -> Vec<[Index; 2]> {
    let size = (0..3).map(|d| {
        let along = deck.points.iter().map(|p| p[d]);
        along.clone().fold(f64::MIN, f64::max) - along.fold(f64::MAX, f64::min)
    });
    let reach = COINCIDENT * size.fold(0.0, f64::max);
    let mut freedoms: BTreeMap<[Index; 2], BTreeSet<u8>> = BTreeMap::new();
    for equation in equal.iter() {
        freedoms
            .entry(equation.sorted())
            .or_default()
            .insert(equation.freedom);
    }
    let near = |[a, b]: [Index; 2]| {
        (0..3).all(|d| (deck.points[a as usize][d] - deck.points[b as usize][d]).abs() <= reach)
    };
    let whole = |of: &BTreeSet<u8>| (1..=axes as u8).all(|freedom| of.contains(&freedom));
    let pairs = freedoms
        .iter()
        .filter(|(pair, of)| near(**pair) && whole(of));
    let pairs: Vec<[Index; 2]> = pairs.map(|(pair, _)| *pair).collect();
    equal.retain(|equation| !pairs.contains(&equation.sorted()));
    let mut first: BTreeMap<Index, Index> = BTreeMap::new();
    for pair in pairs {
        let [a, b] = pair.map(|node| stays(&first, node));
        if a != b {
            first.insert(a.max(b), a.min(b));
        }
    }
    let one = first.keys().map(|&node| [stays(&first, node), node]);
    one.collect()
}

/// The node that stays, of nodes that each may be replaced by another one.
fn stays(first: &BTreeMap<Index, Index>, mut node: Index) -> Index {
    while let Some(&next) = first.get(&node) {
        node = next;
    }
    node
}

impl Equal {
    fn sorted(&self) -> [Index; 2] {
        let [a, b] = self.nodes;
        [a.min(b), a.max(b)]
    }
}

/// Makes rigid sides of the nodes that other equations move together.
///
/// Errors: nodes whose other components are neither held alike nor equal, too.
pub(crate) fn rigid_sides(deck: &mut Deck, equal: &[Equal], axes: usize) -> Result<(), Fault> {
    // groups of each degree of freedom, and the line of the first equation of each
    let mut groups: BTreeMap<Vec<Index>, (BTreeSet<u8>, Place)> = BTreeMap::new();
    for freedom in 1..=axes as u8 {
        for (nodes, place) in grouped(equal.iter().filter(|e| e.freedom == freedom)) {
            groups
                .entry(nodes)
                .or_insert((BTreeSet::new(), place))
                .0
                .insert(freedom);
        }
    }
    let mut taken: BTreeSet<Index> = BTreeSet::new();
    for (nodes, (freedoms, place)) in groups {
        let fault = |message: String| Fault::new(place, "EQUATION", message);
        let reference = nodes[0];
        let held = &mut deck.acting.held.all;
        for freedom in (1..=axes as u8).filter(|freedom| !freedoms.contains(freedom)) {
            let first = held
                .get(&(reference, freedom))
                .map(|course| course.values.clone());
            let alike = nodes.iter().all(|node| {
                held.get(&(*node, freedom)).map(|course| &course.values) == first.as_ref()
            });
            if first.is_none() || !alike {
                return Err(fault(format!(
                    "{} nodes move together along some axes only: along the others they must be held alike (*BOUNDARY), or move together, too",
                    nodes.len()
                )));
            }
        }
        if nodes.iter().any(|node| !taken.insert(*node)) {
            return Err(fault(
                "a node belongs to several groups that move together".to_string(),
            ));
        }
        for freedom in 1..=axes as u8 {
            let courses = nodes
                .iter()
                .filter_map(|node| held.remove(&(*node, freedom)));
            if let Some(course) = courses.collect::<Vec<_>>().into_iter().next() {
                held.insert((reference, freedom), course);
            }
        }
        deck.couplings.push(Coupling {
            place,
            keyword: "EQUATION".to_string(),
            name: "equation".to_string(),
            reference,
            rotation: None,
            nodes,
            motion: Some(Motion::Parallel),
            of: "equation".to_string(),
        });
    }
    Ok(())
}

/// Nodes that equations connect, ascending, with the line of the first.
fn grouped<'e>(equations: impl Iterator<Item = &'e Equal>) -> Vec<(Vec<Index>, Place)> {
    let mut groups: Vec<(BTreeSet<Index>, Place)> = Vec::new();
    for equation in equations {
        let [a, b] = equation.nodes;
        let meets = |group: &(BTreeSet<Index>, Place)| group.0.contains(&a) || group.0.contains(&b);
        let (mut met, rest): (Vec<_>, Vec<_>) = groups.into_iter().partition(meets);
        groups = rest;
        let mut joined = match met.is_empty() {
            true => (BTreeSet::new(), equation.place),
            false => met.remove(0),
        };
        joined.0.extend(met.into_iter().flat_map(|group| group.0));
        joined.0.extend([a, b]);
        groups.push(joined);
    }
    groups
        .into_iter()
        .map(|(nodes, place)| (nodes.into_iter().collect(), place))
        .collect()
}
