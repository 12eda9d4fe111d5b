//! A mesh with groups as a Gmsh file, version 2.2: nodes and elements keep the numbers of the deck.

use crate::bodies::Bodies;
use crate::deck::{Deck, Face, Index};
use std::collections::BTreeMap;
use std::fmt::Write;

/// Groups of faces and of nodes by name.
#[derive(Debug, Default)]
pub(crate) struct Groups {
    pub sides: BTreeMap<String, Vec<Face>>,
    pub points: BTreeMap<String, Vec<Index>>,
}

/// Gmsh's numbers of the faces of cells, by number of dimensions and corners.
fn face_type(dimension: usize, corners: usize) -> u32 {
    match (dimension, corners) {
        (2, _) => 1,
        (_, 3) => 2,
        _ => 3,
    }
}

/// The text of the file.
pub(crate) fn text(deck: &Deck, bodies: &Bodies, groups: &Groups) -> String {
    let dimension = deck.shape(0).dimension;
    let mut out = String::from("$MeshFormat\n2.2 0 8\n$EndMeshFormat\n");
    let cells = bodies.list.iter().flat_map(|body| &body.sections);
    let cells: Vec<&str> = cells.map(|(_, group)| group.as_str()).collect();
    let named = cells.iter().map(|name| (dimension, *name));
    let named = named.chain(
        groups
            .sides
            .keys()
            .map(|name| (dimension - 1, name.as_str())),
    );
    let named = named.chain(groups.points.keys().map(|name| (0, name.as_str())));
    let named: Vec<(usize, &str)> = named.collect();
    // writing to a string does not fail
    let _ = write!(out, "$PhysicalNames\n{}\n", named.len());
    for (tag, (dimension, name)) in named.iter().enumerate() {
        let _ = writeln!(out, "{dimension} {} \"{name}\"", tag + 1);
    }
    out.push_str("$EndPhysicalNames\n");
    nodes(&mut out, deck, bodies);
    let sides = groups.sides.values().map(Vec::len).sum::<usize>();
    let points = groups.points.values().map(Vec::len).sum::<usize>();
    let _ = write!(out, "$Elements\n{}\n", deck.elements.len() + sides + points);
    let mut tag = 0;
    for body in &bodies.list {
        for (section, _) in &body.sections {
            tag += 1;
            for &element in body
                .elements
                .iter()
                .filter(|e| bodies.section_of[**e as usize] == *section)
            {
                let own = &deck.elements[element as usize];
                let (kind, order) = deck.shape(element).gmsh;
                let _ = write!(out, "{} {kind} 2 {tag} {tag}", own.number);
                let nodes = order.iter().map(|k| own.nodes[*k]);
                finish(&mut out, deck, nodes);
            }
        }
    }
    let mut number = deck.elements.iter().map(|e| e.number).max().unwrap_or(0);
    for faces in groups.sides.values() {
        tag += 1;
        for &(element, face) in faces {
            let own = &deck.elements[element as usize].nodes;
            let corners = deck.shape(element).faces[face];
            number += 1;
            let _ = write!(
                out,
                "{number} {} 2 {tag} {tag}",
                face_type(dimension, corners.len())
            );
            finish(&mut out, deck, corners.iter().map(|k| own[*k]));
        }
    }
    for nodes in groups.points.values() {
        tag += 1;
        for &node in nodes {
            number += 1;
            let _ = write!(out, "{number} 15 2 {tag} {tag}");
            finish(&mut out, deck, [node].into_iter());
        }
    }
    out.push_str("$EndElements\n");
    out
}

fn nodes(out: &mut String, deck: &Deck, bodies: &Bodies) {
    let used = (0..deck.points.len()).filter(|node| bodies.of_node[*node].is_some());
    let used: Vec<usize> = used.collect();
    let _ = write!(out, "$Nodes\n{}\n", used.len());
    for node in used {
        let [x, y, z] = deck.points[node];
        let _ = writeln!(out, "{} {x:?} {y:?} {z:?}", deck.numbers[node]);
    }
    out.push_str("$EndNodes\n");
}

/// The nodes of an element behind its head.
fn finish(out: &mut String, deck: &Deck, nodes: impl Iterator<Item = Index>) {
    for node in nodes {
        let _ = write!(out, " {}", deck.numbers[node as usize]);
    }
    out.push('\n');
}
