//! Pre-tension sections: the elements of a surface get nodes of their own there, and a bolt draws the two sides together.
//!
//! The node of a section has one degree of freedom, the shortening: a force on it is the tension of the bolt, a value that of the
//! shortening, and what is held where it is (FIXED) is locked.

use crate::deck::{Deck, Face, Index, find};
use crate::error::Fault;
use crate::lines::{Card, Place};
use crate::steps::Course;
use std::collections::{BTreeMap, BTreeSet};

/// A section.
#[derive(Debug, Clone)]
pub(crate) struct PreTension {
    pub place: Place,
    /// Name of its surface.
    pub of: String,
    /// The node of its shortening.
    pub node: Index,
    /// Its normal, where it is given.
    pub normal: Option<[f64; 3]>,
    /// The faces behind and ahead of the cut.
    pub faces: [Vec<Face>; 2],
}

/// What draws the sides of a section together at the end of a step.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Drawn {
    Force(f64),
    Length(f64),
    Locked,
}

/// When and by what a bolt is tightened: the values of a step where a force acts, or a given shortening.
#[derive(Debug, Default, PartialEq)]
pub(crate) struct Tightening {
    /// Forces in their steps, one after the other.
    pub forces: Vec<Option<f64>>,
    /// Lengths in all other steps; empty where it is locked there.
    pub lengths: Vec<Option<f64>>,
}

pub(crate) const KEYWORD: &str = "PRE-TENSION SECTION";

impl Deck {
    /// Reads the pre-tension sections and cuts the elements apart there.
    ///
    /// Errors: the first mistake, at its line.
    pub fn cut_sections(&mut self, cards: &[Card]) -> Result<(), Fault> {
        for card in cards.iter().filter(|card| card.keyword == KEYWORD) {
            if card.get("ELEMENT").is_some() {
                return Err(
                    card.fault("ELEMENT is of beams, which are not supported: name a SURFACE")
                );
            }
            let Some(name) = card.get("SURFACE").filter(|name| !name.is_empty()) else {
                return Err(card.fault("SURFACE=NAME is missing"));
            };
            let surface = find(card, card.place, "surface", name, &self.surfaces)?;
            if surface.nodes.is_some() {
                return Err(card.fault(format!(
                    "surface {name} is one of nodes: name one of element faces"
                )));
            }
            let (of, faces) = (surface.name.clone(), surface.faces.clone());
            let Some(number) = card.get("NODE").and_then(|node| node.parse::<u64>().ok()) else {
                return Err(card.fault("NODE=NUMBER is missing"));
            };
            let node = self.node(card, card.place, number)?;
            if self
                .elements
                .iter()
                .any(|element| element.nodes.contains(&node))
            {
                return Err(card.fault(format!(
                    "node {number} belongs to an element: take a node of its own"
                )));
            }
            if self.pretensions.iter().any(|other| other.node == node) {
                return Err(card.fault(format!("node {number} is that of another section already")));
            }
            let normal = match card.rows.first() {
                None => None,
                Some(row) => {
                    let part = |k: usize| row.number_or(card, k, 0.0);
                    let normal = [part(0)?, part(1)?, part(2)?];
                    if normal == [0.0; 3] {
                        return Err(card.fault_at(row.place, "the normal has no direction"));
                    }
                    Some(normal)
                }
            };
            let ahead = self.cut_apart(card, &faces)?;
            self.pretensions.push(PreTension {
                place: card.place,
                of,
                node,
                normal,
                faces: [faces, ahead],
            });
        }
        Ok(())
    }

    /// Gives the elements of some faces nodes of their own there, as CalculiX does; returns the faces of those ahead of them.
    fn cut_apart(&mut self, card: &Card, faces: &[Face]) -> Result<Vec<Face>, Fault> {
        let cut: BTreeSet<Index> = faces
            .iter()
            .flat_map(|face| self.face_nodes(*face))
            .collect();
        let touching = (0..self.elements.len() as Index).filter(|element| {
            let mut nodes = self.elements[*element as usize].nodes.iter();
            nodes.any(|node| cut.contains(node))
        });
        // faces of the elements there, by their corners
        let mut beside: BTreeMap<Vec<Index>, Vec<Face>> = BTreeMap::new();
        for element in touching {
            for face in 0..self.shape(element).faces.len() {
                let corners = self.corners((element, face));
                beside.entry(corners).or_default().push((element, face));
            }
        }
        let mut ahead = Vec::with_capacity(faces.len());
        for face in faces {
            let both = &beside[&self.corners(*face)];
            match both.iter().find(|other| *other != face) {
                Some(other) => ahead.push(*other),
                None => {
                    let number = self.elements[face.0 as usize].number;
                    let message = format!(
                        "face {} of element {number} has no element beyond it: the surface of a section lies within a body",
                        face.1 + 1
                    );
                    return Err(card.fault(message));
                }
            }
        }
        let own: BTreeSet<Face> = faces.iter().chain(&ahead).copied().collect();
        let mut next: BTreeMap<Index, Vec<Index>> = BTreeMap::new();
        for both in beside.values().filter(|both| !own.contains(&both[0])) {
            for pair in both.windows(2) {
                next.entry(pair[0].0).or_default().push(pair[1].0);
                next.entry(pair[1].0).or_default().push(pair[0].0);
            }
        }
        let mut moved: BTreeSet<Index> = faces.iter().map(|face| face.0).collect();
        let mut open: Vec<Index> = moved.iter().copied().collect();
        while let Some(element) = open.pop() {
            for &other in next.get(&element).into_iter().flatten() {
                if moved.insert(other) {
                    open.push(other);
                }
            }
        }
        if let Some(face) = ahead.iter().find(|face| moved.contains(&face.0)) {
            let number = self.elements[face.0 as usize].number;
            return Err(card.fault(format!(
                "the surface does not cut the body through: it ends within it, near element {number}"
            )));
        }
        let copies: BTreeMap<Index, Index> =
            cut.into_iter().zip(self.points.len() as Index..).collect();
        for &node in copies.keys() {
            self.copy_node(node);
        }
        for element in moved {
            for node in &mut self.elements[element as usize].nodes {
                *node = copies.get(node).copied().unwrap_or(*node);
            }
        }
        for set in self.node_sets.values_mut() {
            let doubled = set.members.iter().filter_map(|node| copies.get(node));
            let doubled: Vec<Index> = doubled.copied().collect();
            set.members.extend(doubled);
        }
        let surfaces = self
            .surfaces
            .values_mut()
            .filter_map(|surface| surface.nodes.as_mut());
        for nodes in surfaces {
            let doubled = nodes.iter().filter_map(|node| copies.get(node));
            let doubled: Vec<Index> = doubled.copied().collect();
            nodes.extend(doubled);
        }
        self.copies.extend(copies);
        Ok(ahead)
    }

    /// Gives the copy of a node what lines with its number give the node: supports and temperatures.
    pub fn treat_copies_alike(&mut self) {
        for (node, copy) in &self.copies {
            if let Some(value) = self.initial.get(node).copied() {
                self.initial.entry(*copy).or_insert(value);
            }
            let temperatures = &mut self.acting.temperatures.all;
            if let Some(course) = temperatures.get(node).cloned() {
                temperatures.entry(*copy).or_insert(course);
            }
        }
        let held = &mut self.acting.held.all;
        let missing = held.iter().filter_map(|((node, freedom), course)| {
            let copy = (*self.copies.get(node)?, *freedom);
            Some((copy, course.clone()))
        });
        for (copy, course) in missing.collect::<Vec<_>>() {
            held.entry(copy).or_insert(course);
        }
    }

    /// How a section is tightened.
    ///
    /// Errors: forces that come again after it was locked; lengths that come after it.
    pub fn tightening(&self, section: &PreTension) -> Result<Tightening, Fault> {
        let key = (section.node, 1);
        let force = self.acting.forces.all.get(&key);
        let held = self.acting.held.all.get(&key);
        let other = |all: &BTreeMap<(Index, u8), Course>, keyword: &str| {
            let mut others = all.range((section.node, 2)..=(section.node, u8::MAX));
            let found =
                others.find(|(_, course)| course.values.iter().flatten().any(|v| *v != 0.0));
            found.map(|((_, freedom), course)| {
                let number = self.numbers[section.node as usize];
                let message = format!(
                    "node {number} is that of a pre-tension section: it has degree of freedom 1 alone, and not {freedom}"
                );
                Fault::new(course.place, keyword, message)
            })
        };
        let wrong = other(&self.acting.forces.all, "CLOAD");
        if let Some(fault) = wrong.or_else(|| other(&self.acting.held.all, "BOUNDARY")) {
            return Err(fault);
        }
        let mut drawn: Vec<Drawn> = Vec::new();
        for step in 0..self.steps.len() {
            let value = |course: Option<&Course>| course.and_then(|course| course.values[step]);
            let next = match (value(held), drawn.last()) {
                (None, _) => Drawn::Force(value(force).unwrap_or(0.0)),
                (Some(_), Some(Drawn::Length(length)))
                    if held.is_some_and(|own| own.fixed[step]) =>
                {
                    Drawn::Length(*length)
                }
                (Some(_), Some(_)) if held.is_some_and(|own| own.fixed[step]) => Drawn::Locked,
                (Some(length), _) => Drawn::Length(length),
            };
            drawn.push(next);
        }
        let pulled = |drawn: &Drawn| matches!(drawn, Drawn::Force(_));
        let turns = drawn
            .windows(2)
            .filter(|two| pulled(&two[0]) != pulled(&two[1]))
            .count();
        let apart = turns > 2 || turns == 2 && pulled(&drawn[0]);
        let mixed = drawn.contains(&Drawn::Locked)
            && drawn.iter().any(|own| matches!(own, Drawn::Length(_)));
        if apart || mixed {
            let place = held.map_or(section.place, |course| course.place);
            let message = "a bolt is tightened in steps one after the other, and locked or given its shortening in all others";
            return Err(Fault::new(place, "BOUNDARY", message));
        }
        let force = |drawn: &Drawn| match drawn {
            Drawn::Force(force) => Some(*force),
            _ => None,
        };
        let length = |drawn: &Drawn| match drawn {
            Drawn::Length(length) => Some(*length),
            _ => None,
        };
        Ok(Tightening {
            forces: drawn.iter().map(force).collect(),
            lengths: drawn.iter().map(length).collect(),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::steps::Step;

    /// How a section is tightened whose node has a force, or is held, at the end of each step; of what is held whether it is FIXED.
    fn tightened(forces: &[f64], held: &[Option<(f64, bool)>]) -> Result<Tightening, Fault> {
        let course = |values: Vec<Option<f64>>, fixed: Vec<bool>| Course {
            place: Place::default(),
            of: String::new(),
            keyword: String::new(),
            values,
            fixed,
        };
        let mut deck = Deck::default();
        deck.numbers.push(7);
        deck.steps.resize(held.len(), Step::default());
        let values = held.iter().map(|held| held.map(|held| held.0)).collect();
        let fixed = held.iter().map(|held| held.is_some_and(|held| held.1));
        let fixed = fixed.collect();
        deck.acting.held.all.insert((0, 1), course(values, fixed));
        let forces: Vec<Option<f64>> = forces.iter().copied().map(Some).collect();
        let none = vec![false; forces.len()];
        deck.acting.forces.all.insert((0, 1), course(forces, none));
        deck.tightening(&PreTension {
            place: Place::default(),
            of: String::new(),
            node: 0,
            normal: None,
            faces: [Vec::new(), Vec::new()],
        })
    }

    #[test]
    fn a_held_node_locks_a_bolt_or_shortens_it() {
        let fixed = Some((0.0, true));
        let locked = tightened(&[5.0, 6.0, 6.0], &[None, None, fixed]).unwrap();
        assert_eq!(locked.forces, [Some(5.0), Some(6.0), None]);
        assert_eq!(locked.lengths, [None; 3]);
        let given = tightened(&[0.0; 3], &[Some((0.1, false)), Some((0.2, false)), fixed]).unwrap();
        assert_eq!(given.forces, [None; 3]);
        assert_eq!(given.lengths, [Some(0.1), Some(0.2), Some(0.2)]);
    }

    #[test]
    fn what_is_tightened_again_after_it_was_locked_is_refused() {
        let fixed = Some((0.0, true));
        let again = tightened(&[5.0, 5.0, 9.0], &[None, fixed, None]);
        assert!(again.unwrap_err().message.contains("one after the other"));
        let mixed = tightened(&[5.0, 5.0, 5.0], &[None, fixed, Some((0.3, false))]);
        assert!(mixed.is_err());
    }
}
