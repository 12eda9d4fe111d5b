//! What of a mesh file no body can contain, or is called otherwise, in words.

use crate::mesh::MeshFile;
use crate::mesh::import::content::{Content, Edge, Refused};
use std::collections::{BTreeMap, HashSet};

impl MeshFile {
    /// What the user should know of the file whichever body is cut out of it; `content` is what was read, its elements
    /// moved into the file, and `repeated` cells of it were dropped.
    pub(crate) fn remarks(&self, content: &Content, repeated: usize) -> Vec<String> {
        let mut remarks = content.remarks.clone();
        let other = self.refused.iter().filter(|r| r.element.dimension != 2);
        let other = merged(other);
        remarks.extend(
            other
                .iter()
                .map(|r| format!("{} are left out", described(r))),
        );
        if repeated > 0 {
            remarks.push(format!("{repeated} repeated cells are left out"));
        }
        remarks.extend(self.renamed());
        let empty = self.empty_groups(content);
        if !empty.is_empty() {
            remarks.push(format!("groups without elements: {}", quoted(&empty)));
        }
        remarks.extend(self.edge_remarks());
        let named = |remark: String| format!("{}: {remark}", self.name);
        remarks.into_iter().map(named).collect()
    }

    /// Groups whose names could not stand in a case file.
    fn renamed(&self) -> Vec<String> {
        let groups = [&self.cell_groups, &self.edge_groups, &self.point_groups].into_iter();
        let names = groups.flat_map(|groups| groups.names.iter().zip(&groups.originals));
        let renamed = names.filter_map(|(name, original)| {
            let original = original.as_ref().filter(|original| *original != name)?;
            Some(format!(
                "the group `{original}` is called `{name}`: names consist of letters, digits, `_` and `-`"
            ))
        });
        renamed.collect()
    }

    /// Names of surfaces, curves and points that no element belongs to.
    fn empty_groups(&self, content: &Content) -> Vec<String> {
        let empty = content
            .names
            .iter()
            .filter(|((dimension, tag), _)| match dimension {
                0 => !self.point_groups.tags.contains_key(tag),
                1 => !self.edge_groups.tags.contains_key(tag),
                2 => !self.cell_groups.tags.contains_key(tag),
                _ => false,
            });
        empty.map(|(_, name)| name.clone()).collect()
    }

    /// Edges without a group, edges of no cell, nodes of no cell.
    fn edge_remarks(&self) -> Vec<String> {
        let mut remarks = Vec::new();
        let groups = |edge: &Edge| &self.edge_sets[edge.tags as usize];
        let loose = self.edges.iter().filter(|edge| groups(edge).is_empty());
        let loose = loose.count();
        if loose > 0 {
            remarks.push(format!(
                "{loose} edges belong to no physical group and are left out"
            ));
        }
        let mut off: HashSet<[u32; 2]> = self.edges.iter().map(|e| ordered(e.ends)).collect();
        let mut in_cells = vec![false; self.points.len()];
        for cell in &self.cells {
            for (_, facet) in cell.kind.facets() {
                off.remove(&ordered([cell.nodes[facet[0]], cell.nodes[facet[1]]]));
            }
            for &node in cell.nodes() {
                in_cells[node as usize] = true;
            }
        }
        let mut counts: BTreeMap<usize, usize> = BTreeMap::new();
        for edge in self
            .edges
            .iter()
            .filter(|edge| off.contains(&ordered(edge.ends)))
        {
            for &group in groups(edge) {
                *counts.entry(group).or_insert(0) += 1;
            }
        }
        for (group, count) in counts {
            let name = &self.edge_groups.names[group];
            remarks.push(format!(
                "{count} edges of the group `{name}` belong to no cell of the plane and are left out"
            ));
        }
        let nodes = in_cells.iter().filter(|used| !**used).count();
        if nodes > 0 {
            remarks.push(format!(
                "{nodes} nodes belong to no cell of the plane and are left out"
            ));
        }
        remarks
    }
}

/// Refused elements by kind alone.
fn merged<'r>(refused: impl Iterator<Item = &'r Refused>) -> Vec<Refused> {
    let mut kinds: Vec<Refused> = Vec::new();
    for one in refused {
        match kinds.iter_mut().find(|kind| kind.element == one.element) {
            Some(kind) => kind.count += one.count,
            None => kinds.push(one.clone()),
        }
    }
    kinds
}

pub(crate) fn described(refused: &Refused) -> String {
    format!(
        "{} elements of the kind {}",
        refused.count, refused.element.name
    )
}

fn ordered([a, b]: [u32; 2]) -> [u32; 2] {
    [a.min(b), a.max(b)]
}

pub(crate) fn quoted(names: &[String]) -> String {
    let quoted: Vec<String> = names.iter().map(|name| format!("`{name}`")).collect();
    quoted.join(", ")
}
