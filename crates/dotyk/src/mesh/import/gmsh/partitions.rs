//! Partitions of a mesh: which of them its files hold.
//!
//! Gmsh saves a partitioned mesh in one file, or each partition in a file of its own. Entities are cut into one part for
//! each partition, and lie on the boundary between partitions with several; their physical tags are those of the entity
//! they are cut from. Cells of a partition that is in no file would be a hole that nothing tells of.

use std::collections::{BTreeMap, BTreeSet};

#[derive(Debug, Default)]
pub(super) struct Partitions {
    /// Number of partitions that a file of version 4 announces.
    pub announced: u64,
    /// Partitions of the entities, by dimension and number.
    pub entities: BTreeMap<(i64, i64), Vec<i64>>,
    /// Partitions that have cells.
    pub seen: BTreeSet<i64>,
}

impl Partitions {
    /// Notes that an entity has cells.
    pub fn see(&mut self, entity: (i64, i64)) {
        // the boundary between two partitions belongs to neither of them
        if let Some([own]) = self.entities.get(&entity).map(Vec::as_slice) {
            self.seen.insert(*own);
        }
    }

    /// Number of partitions, and the first ones that have no cells, in words; `None` where all or none have some.
    pub fn missing(&self) -> Option<(u64, String)> {
        let last = self.seen.last()?.unsigned_abs().max(self.announced);
        let missing = (1..=last).filter(|own| !self.seen.contains(&(*own as i64)));
        let missing: Vec<String> = missing.take(6).map(|own| own.to_string()).collect();
        let told = match missing.len() {
            0 => return None,
            6 => format!("{}, ..", missing[..5].join(", ")),
            _ => missing.join(", "),
        };
        Some((last, told))
    }
}
