//! Remarks on parts of a mesh file that no body can contain, or that are renamed.

use crate::mesh::MeshFile;
use crate::mesh::facets::sorted;
use crate::mesh::import::content::{Content, ReadSide, Refused};
use std::collections::{BTreeMap, HashSet};

impl MeshFile {
    /// Remarks on the file that hold for every body cut out of it; `content` is the read content, whose elements have been moved
    /// into the file, and `repeated` the number of dropped cells.
    pub(crate) fn remarks(&self, content: &Content, repeated: usize) -> Vec<String> {
        let mut remarks = content.remarks.clone();
        let dimension = self.dimension;
        let other = self.refused.iter();
        let other = other.filter(|r| r.element.dimension != dimension);
        remarks.extend(merged(other).iter().map(|r| {
            let meant = match r.element.dimension > dimension {
                true => ": bodies of such cells need `analysis = \"3d\"`",
                false => "",
            };
            format!("{} are left out{meant}", described(r))
        }));
        if repeated > 0 {
            remarks.push(format!("{repeated} repeated cells are left out"));
        }
        remarks.extend(self.renamed());
        let empty = self.empty_groups(content);
        if !empty.is_empty() {
            remarks.push(format!("groups without elements: {}", quoted(&empty)));
        }
        remarks.extend(self.side_remarks());
        let named = |remark: String| format!("{}: {remark}", self.name);
        remarks.into_iter().map(named).collect()
    }

    /// Groups whose names could not stand in a case file.
    fn renamed(&self) -> Vec<String> {
        let groups = [&self.cell_groups, &self.side_groups, &self.point_groups].into_iter();
        let names = groups.flat_map(|groups| groups.names.iter().zip(&groups.originals));
        let renamed = names.filter_map(|(name, original)| {
            let original = original.as_ref().filter(|original| *original != name)?;
            Some(format!(
                "the group `{original}` is called `{name}`: names consist of letters, digits, `_` and `-`"
            ))
        });
        renamed.collect()
    }

    /// Names of groups of cells, sides and points that no element belongs to.
    fn empty_groups(&self, content: &Content) -> Vec<String> {
        let empty = content
            .names
            .iter()
            .filter(|((dimension, tag), _)| match *dimension {
                0 => !self.point_groups.tags.contains_key(tag),
                d if d == self.dimension => !self.cell_groups.tags.contains_key(tag),
                d if d + 1 == self.dimension => !self.side_groups.tags.contains_key(tag),
                _ => false,
            });
        empty.map(|(_, name)| name.clone()).collect()
    }

    /// Edges or faces without a group, those of no cell, nodes of no cell.
    fn side_remarks(&self) -> Vec<String> {
        let mut remarks = Vec::new();
        let (sides, space) = (self.sides_word(), self.space_word());
        let groups = |side: &ReadSide| &self.side_sets[side.tags as usize];
        let loose = self.sides.iter().filter(|side| groups(side).is_empty());
        let loose = loose.count();
        if loose > 0 {
            remarks.push(format!(
                "{loose} {sides} belong to no physical group and are left out"
            ));
        }
        let ordered = |side: &ReadSide| sorted(side.corners().iter().copied());
        let own = self.sides.iter().map(ordered);
        let mut off: HashSet<[u32; 4]> = own.collect();
        let mut in_cells = vec![false; self.points.len()];
        for cell in &self.cells {
            for (kind, facet) in cell.kind.facets() {
                let corners = facet[..kind.corners()].iter();
                off.remove(&sorted(corners.map(|&local| cell.nodes[local])));
            }
            for &node in cell.nodes() {
                in_cells[node as usize] = true;
            }
        }
        let mut counts: BTreeMap<usize, usize> = BTreeMap::new();
        let off = |side: &&ReadSide| off.contains(&ordered(side));
        for side in self.sides.iter().filter(off) {
            for &group in groups(side) {
                *counts.entry(group).or_insert(0) += 1;
            }
        }
        for (group, count) in counts {
            let name = &self.side_groups.names[group];
            remarks.push(format!(
                "{count} {sides} of the group `{name}` belong to no cell of {space} and are left out"
            ));
        }
        let nodes = in_cells.iter().filter(|used| !**used).count();
        if nodes > 0 {
            remarks.push(format!(
                "{nodes} nodes belong to no cell of {space} and are left out"
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
    format!("{} elements of the kind {}", refused.count, refused.element)
}

pub(crate) fn quoted(names: &[String]) -> String {
    let quoted: Vec<String> = names.iter().map(|name| format!("`{name}`")).collect();
    quoted.join(", ")
}
