//! Content of a mesh file, in a form common to all formats: nodes, elements with their groups, names of groups.
//!
//! Cells have the dimension of the bodies to be cut out, their sides one less. Only kinds that meshes can consist of are
//! kept; of the others only their numbers and groups are known, so that they can be reported, or refused if a body needs
//! them.

use crate::mesh::facets::sorted;
use crate::mesh::{CellKind, MAX_CELL_NODES};
use std::collections::{BTreeMap, BTreeSet};
use std::fmt;

/// A kind of element as files know it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct ElementType {
    pub name: &'static str,
    pub dimension: u8,
    /// Zero: any number.
    pub nodes: usize,
    pub order: u8,
}

impl fmt::Display for ElementType {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.order {
            0..=2 => f.write_str(self.name),
            order => write!(f, "{} of order {order} ({} nodes)", self.name, self.nodes),
        }
    }
}

impl ElementType {
    /// A kind that meshes consist of.
    pub fn of(kind: CellKind) -> Self {
        Self {
            name: kind.name(),
            dimension: kind.dimension() as u8,
            nodes: kind.nodes(),
            order: kind.order() as u8,
        }
    }
}

/// A cell as a file gives it.
#[derive(Debug, Clone)]
pub(crate) struct ReadCell {
    pub kind: CellKind,
    /// Number in the file.
    pub number: u64,
    /// Indices of points, the first `kind.nodes()` count.
    pub nodes: [u32; MAX_CELL_NODES],
    /// Index into [`Content::tags`].
    pub tags: u32,
}

impl ReadCell {
    pub fn nodes(&self) -> &[u32] {
        &self.nodes[..self.kind.nodes()]
    }

    /// The corners in ascending order.
    pub fn corners(&self) -> [u32; 8] {
        sorted(self.nodes[..self.kind.corners()].iter().copied())
    }
}

/// An edge by its ends, or a face by its corners.
#[derive(Debug, Clone)]
pub(crate) struct ReadSide {
    pub kind: CellKind,
    /// The first `kind.corners()` count.
    pub corners: [u32; 4],
    /// Index into [`Content::tags`].
    pub tags: u32,
}

impl ReadSide {
    pub fn corners(&self) -> &[u32] {
        &self.corners[..self.kind.corners()]
    }
}

/// A node that an element of dimension 0 names.
#[derive(Debug, Clone)]
pub(crate) struct NamedNode {
    pub node: u32,
    /// Index into [`Content::tags`].
    pub tags: u32,
}

/// Elements that no such mesh has, of one kind and with the same groups.
#[derive(Debug, Clone)]
pub(crate) struct Refused {
    pub element: ElementType,
    pub tags: u32,
    pub count: usize,
    /// Number in the file of the first one.
    pub first: u64,
}

/// All data that were read.
#[derive(Debug, Clone, Default)]
pub(crate) struct Content {
    /// Of the cells: 2 or 3.
    pub dimension: u8,
    pub points: Vec<[f64; 3]>,
    pub cells: Vec<ReadCell>,
    pub sides: Vec<ReadSide>,
    pub nodes: Vec<NamedNode>,
    pub refused: Vec<Refused>,
    /// Physical tags that elements have in common: > 0, ascending, each once; elements hold an index.
    pub tags: Vec<Vec<i64>>,
    /// Index of each entry of `tags`.
    places: BTreeMap<Vec<i64>, u32>,
    /// Names by dimension and tag.
    pub names: BTreeMap<(u8, i64), String>,
    /// Remarks on omitted data.
    pub remarks: Vec<String>,
}

impl Content {
    /// Nothing read yet.
    pub fn new(dimension: u8) -> Self {
        Self {
            dimension,
            ..Self::default()
        }
    }

    /// Index of a set of tags. Zero means no group, and the sign tells an orientation: neither is kept.
    pub fn tag_set(&mut self, mut tags: Vec<i64>) -> u32 {
        for tag in &mut tags {
            *tag = tag.saturating_abs();
        }
        tags.retain(|tag| *tag != 0);
        tags.sort_unstable();
        tags.dedup();
        if let Some(index) = self.places.get(&tags) {
            return *index;
        }
        let index = self.tags.len() as u32;
        self.tags.push(tags.clone());
        self.places.insert(tags, index);
        index
    }

    /// Tags of the elements of a dimension.
    pub fn used(&self, dimension: u8) -> BTreeSet<i64> {
        let own: BTreeSet<u32> = match dimension {
            0 => self.nodes.iter().map(|n| n.tags).collect(),
            d if d == self.dimension => self.cells.iter().map(|c| c.tags).collect(),
            _ => self.sides.iter().map(|s| s.tags).collect(),
        };
        let refused = self.refused.iter();
        let refused = refused
            .filter(|r| r.element.dimension == dimension)
            .map(|r| r.tags);
        let sets = own.into_iter().chain(refused);
        sets.flat_map(|set| self.tags[set as usize].iter().copied())
            .collect()
    }

    /// One more element; `nodes` has as many as its type says, of kinds with any number of them the first ones.
    pub fn add(&mut self, element: ElementType, number: u64, nodes: &[u32], tags: u32) {
        match (element.dimension, CellKind::from_name(element.name)) {
            (0, _) if element.nodes == 1 => self.nodes.push(NamedNode {
                node: nodes[0],
                tags,
            }),
            (d, Some(kind)) if d + 1 == self.dimension => {
                let mut corners = [u32::MAX; 4];
                let count = kind.corners();
                corners[..count].copy_from_slice(&nodes[..count]);
                self.sides.push(ReadSide {
                    kind,
                    corners,
                    tags,
                });
            }
            (d, Some(kind)) if d == self.dimension => {
                let mut own = [u32::MAX; MAX_CELL_NODES];
                own[..nodes.len()].copy_from_slice(nodes);
                self.cells.push(ReadCell {
                    kind,
                    number,
                    nodes: own,
                    tags,
                });
            }
            _ => self.refuse(element, number, tags),
        }
    }

    fn refuse(&mut self, element: ElementType, number: u64, tags: u32) {
        let mut known = self.refused.iter_mut();
        match known.find(|known| known.element == element && known.tags == tags) {
            Some(known) => known.count += 1,
            None => self.refused.push(Refused {
                element,
                tags,
                count: 1,
                first: number,
            }),
        }
    }
}
