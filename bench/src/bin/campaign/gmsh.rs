//! Meshes as files in Gmsh's text format 2.2.

use std::collections::BTreeMap;
use std::fmt::Write;

/// Gmsh's number of a kind of cell, and the nodes in its order.
pub type Element = (usize, Vec<usize>);

/// A mesh file: all cells are the group "cells", of one dimension more than the sides.
pub fn text(
    dimension: usize,
    points: &[[f64; 3]],
    cells: &[Element],
    sides: &BTreeMap<String, Vec<Element>>,
) -> String {
    let mut out = String::from("$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$PhysicalNames\n");
    // writing to a String cannot fail
    let _ = writeln!(out, "{}", sides.len() + 1);
    for (tag, name) in sides.keys().enumerate() {
        let _ = writeln!(out, "{} {} \"{name}\"", dimension - 1, tag + 1);
    }
    let group = sides.len() + 1;
    let _ = writeln!(
        out,
        "{dimension} {group} \"cells\"\n$EndPhysicalNames\n$Nodes\n{}",
        points.len()
    );
    for (index, [x, y, z]) in points.iter().enumerate() {
        let _ = writeln!(out, "{} {x:?} {y:?} {z:?}", index + 1);
    }
    let facets: usize = sides.values().map(Vec::len).sum();
    let _ = writeln!(out, "$EndNodes\n$Elements\n{}", facets + cells.len());
    let mut number = 0;
    let mut element = |tag: usize, (kind, nodes): &Element| {
        number += 1;
        let nodes: Vec<String> = nodes.iter().map(|n| (n + 1).to_string()).collect();
        let _ = writeln!(out, "{number} {kind} 2 {tag} {tag} {}", nodes.join(" "));
    };
    for (tag, facets) in sides.values().enumerate() {
        facets.iter().for_each(|facet| element(tag + 1, facet));
    }
    cells.iter().for_each(|cell| element(group, cell));
    out + "$EndElements\n"
}
