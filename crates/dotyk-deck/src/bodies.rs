//! The bodies of a deck: parts of elements that hang together by faces, each with its nodes, boundary and sections.

use crate::deck::{Deck, Face, Index};
use crate::error::Fault;
use crate::lines::folded;
use crate::names::{Names, clean};
use dotyk::model::Analysis;
use std::collections::{BTreeMap, HashMap, HashSet};

/// A part of the elements that hang together by faces.
#[derive(Debug)]
pub(crate) struct Body {
    pub name: String,
    pub elements: Vec<Index>,
    /// In the order of the deck, which is that of the mesh.
    pub nodes: Vec<Index>,
    pub boundary: Vec<Face>,
    /// Faces of the boundary, as indices there, at each node that is on it.
    pub at_node: HashMap<Index, Vec<usize>>,
    /// Sections in the order of the deck, and the name of the group of their cells.
    pub sections: Vec<(usize, String)>,
}

/// The bodies of a deck.
#[derive(Debug)]
pub(crate) struct Bodies {
    pub list: Vec<Body>,
    pub analysis: Analysis,
    /// Body of each node and of each element of the deck.
    pub of_node: Vec<Option<usize>>,
    pub of_element: Vec<usize>,
    pub section_of: Vec<usize>,
    /// Nodes at whose place their body has another node: no point tells which of them is meant.
    pub doubled: HashSet<Index>,
}

impl Bodies {
    /// The bodies of a deck.
    ///
    /// Errors: no elements; elements of different analyses, or without section; elements that share nodes, but no face.
    pub fn new(deck: &Deck, names: &mut Names) -> Result<Self, Fault> {
        let analysis = analysis(deck)?;
        let section_of = sections(deck)?;
        repeated(deck)?;
        let (of_element, parts) = parts(deck);
        let mut list: Vec<Body> = Vec::with_capacity(parts.len());
        let mut of_node: Vec<Option<usize>> = vec![None; deck.points.len()];
        for (body, elements) in parts.iter().enumerate() {
            for &element in elements {
                for &node in &deck.elements[element as usize].nodes {
                    match of_node[node as usize].replace(body) {
                        Some(other) if other != body => return Err(hinge(deck, element, node)),
                        _ => {}
                    }
                }
            }
        }
        let mut counts: BTreeMap<usize, usize> = BTreeMap::new();
        let first_section = |elements: &[Index]| {
            elements
                .iter()
                .map(|e| section_of[*e as usize])
                .min()
                .unwrap_or(0)
        };
        for elements in &parts {
            *counts.entry(first_section(elements)).or_default() += 1;
        }
        let mut numbers: BTreeMap<usize, usize> = BTreeMap::new();
        for elements in &parts {
            let first = first_section(elements);
            let set = clean(&deck.sections[first].set);
            let number = numbers.entry(first).or_default();
            *number += 1;
            let name = match counts[&first] {
                1 => names.fresh(&set),
                _ => names.fresh(&format!("{set}-{number}")),
            };
            let mut own: Vec<usize> = elements.iter().map(|e| section_of[*e as usize]).collect();
            own.sort_unstable();
            own.dedup();
            let mut group = |section: &usize| match own.len() {
                1 => name.clone(),
                _ => names.fresh(&format!("{name}_{}", clean(&deck.sections[*section].set))),
            };
            let sections = own.iter().map(|section| (*section, group(section)));
            list.push(Body {
                sections: sections.collect(),
                at_node: HashMap::new(),
                boundary: boundary(deck, elements),
                elements: elements.clone(),
                nodes: Vec::new(),
                name: name.clone(),
            });
        }
        for body in &mut list {
            for (place, &face) in body.boundary.iter().enumerate() {
                for node in deck.face_nodes(face) {
                    body.at_node.entry(node).or_default().push(place);
                }
            }
        }
        for (node, body) in of_node.iter().enumerate() {
            if let Some(body) = body {
                list[*body].nodes.push(node as Index);
            }
        }
        let mut doubled = HashSet::new();
        for body in &list {
            let mut at: HashMap<[u64; 3], Index> = HashMap::new();
            for &node in &body.nodes {
                // zero has two signs
                let place = deck.points[node as usize].map(|x| (x + 0.0).to_bits());
                if let Some(other) = at.insert(place, node) {
                    doubled.extend([other, node]);
                }
            }
        }
        Ok(Self {
            list,
            analysis,
            of_node,
            of_element,
            section_of,
            doubled,
        })
    }

    /// Nodes by the body that they are in; those of no body apart.
    pub fn split(&self, nodes: &[Index]) -> (BTreeMap<usize, Vec<Index>>, Vec<Index>) {
        let (mut of, mut loose) = (BTreeMap::new(), Vec::new());
        for &node in nodes {
            match self.of_node[node as usize] {
                Some(body) => of.entry(body).or_insert_with(Vec::new).push(node),
                None => loose.push(node),
            }
        }
        (of, loose)
    }

    /// Faces by the body that they are of.
    pub fn split_faces(&self, faces: &[Face]) -> BTreeMap<usize, Vec<Face>> {
        let mut of: BTreeMap<usize, Vec<Face>> = BTreeMap::new();
        for &face in faces {
            of.entry(self.of_element[face.0 as usize])
                .or_default()
                .push(face);
        }
        of
    }
}

/// The one analysis of all elements.
fn analysis(deck: &Deck) -> Result<Analysis, Fault> {
    let of = |element: &crate::deck::Element| &deck.kinds[element.kind];
    let Some(first) = deck.elements.first() else {
        let place = deck.steps[0].place;
        let message = "the deck has no elements".to_string();
        return Err(Fault::new(place, "ELEMENT", message));
    };
    let (first_name, first_kind) = of(first);
    let analysis = first_kind.analysis;
    match deck
        .elements
        .iter()
        .find(|element| of(element).1.analysis != analysis)
    {
        None => Ok(analysis),
        Some(other) => Err(Fault::new(
            other.place,
            "ELEMENT",
            format!(
                "element {} of type {} is {}, and element {} of type {first_name} is {}: a deck has one kind of analysis",
                other.number,
                of(other).0,
                of(other).1.analysis.name(),
                first.number,
                analysis.name()
            ),
        )),
    }
}

/// Errors: an element with the nodes of another one.
fn repeated(deck: &Deck) -> Result<(), Fault> {
    let mut seen: HashMap<Vec<Index>, u64> = HashMap::new();
    for element in &deck.elements {
        let mut nodes = element.nodes.clone();
        nodes.sort_unstable();
        if let Some(other) = seen.insert(nodes, element.number) {
            let message = format!(
                "element {} has the nodes of element {other}, and both would bear: leave one of them out",
                element.number
            );
            return Err(Fault::new(element.place, "ELEMENT", message));
        }
    }
    Ok(())
}

/// The section of each element.
fn sections(deck: &Deck) -> Result<Vec<usize>, Fault> {
    let mut of = vec![usize::MAX; deck.elements.len()];
    for (index, section) in deck.sections.iter().enumerate() {
        let fault = |message: String| Fault::new(section.place, "SOLID SECTION", message);
        match deck.materials.get(&folded(&section.material)) {
            None => return Err(fault(format!("there is no material {}", section.material))),
            Some(material) if material.elastic.is_none() => {
                return Err(Fault::new(
                    material.place,
                    "MATERIAL",
                    format!("material {} has no *ELASTIC", material.name),
                ));
            }
            Some(_) => {}
        }
        for &element in &deck.element_sets[&folded(&section.set)].members {
            let before = std::mem::replace(&mut of[element as usize], index);
            let other = deck.sections.get(before);
            if other.is_some_and(|other| {
                other.material != section.material || other.thickness != section.thickness
            }) {
                let number = deck.elements[element as usize].number;
                let first = deck.sections[before].place.line;
                return Err(fault(format!(
                    "element {number} has a section already, in line {first}"
                )));
            }
        }
    }
    match of.iter().position(|section| *section == usize::MAX) {
        None => Ok(of),
        Some(element) => Err(Fault::new(
            deck.elements[element].place,
            "ELEMENT",
            format!(
                "element {} has no *SOLID SECTION",
                deck.elements[element].number
            ),
        )),
    }
}

/// Parts that hang together by faces: the part of each element, and the elements of each part.
fn parts(deck: &Deck) -> (Vec<usize>, Vec<Vec<Index>>) {
    let count = deck.elements.len();
    let mut root: Vec<usize> = (0..count).collect();
    fn find(root: &mut [usize], mut k: usize) -> usize {
        while root[k] != k {
            root[k] = root[root[k]];
            k = root[k];
        }
        k
    }
    let mut seen: HashMap<Vec<Index>, usize> = HashMap::new();
    for element in 0..count {
        for face in 0..deck.shape(element as Index).faces.len() {
            if let Some(other) = seen.insert(deck.corners((element as Index, face)), element) {
                let (a, b) = (find(&mut root, element), find(&mut root, other));
                // the first element stands for its part
                root[a.max(b)] = a.min(b);
            }
        }
    }
    let mut number: HashMap<usize, usize> = HashMap::new();
    let (mut of, mut parts) = (Vec::with_capacity(count), Vec::new());
    for element in 0..count {
        let first = find(&mut root, element);
        let part = *number.entry(first).or_insert_with(|| {
            parts.push(Vec::new());
            parts.len() - 1
        });
        parts[part].push(element as Index);
        of.push(part);
    }
    (of, parts)
}

fn hinge(deck: &Deck, element: Index, node: Index) -> Fault {
    let element = &deck.elements[element as usize];
    Fault::new(
        element.place,
        "ELEMENT",
        format!(
            "element {} shares node {} with elements that it has no face in common with: bodies that hang together by a point or an edge are not supported",
            element.number, deck.numbers[node as usize]
        ),
    )
}

/// Faces that one element alone has.
fn boundary(deck: &Deck, elements: &[Index]) -> Vec<Face> {
    let mut seen: HashMap<Vec<Index>, (Face, usize)> = HashMap::new();
    for &element in elements {
        for face in 0..deck.shape(element).faces.len() {
            let entry = seen.entry(deck.corners((element, face)));
            entry.or_insert(((element, face), 0)).1 += 1;
        }
    }
    let outer = seen.into_values().filter(|(_, count)| *count == 1);
    let mut outer: Vec<Face> = outer.map(|(face, _)| face).collect();
    outer.sort_unstable();
    outer
}
