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

#[cfg(test)]
mod tests {
    use super::*;

    fn of(announced: u64, seen: &[i64]) -> Option<(u64, String)> {
        let partitions = Partitions {
            announced,
            entities: BTreeMap::new(),
            seen: seen.iter().copied().collect(),
        };
        partitions.missing()
    }

    #[test]
    fn partitions_without_cells_are_named() {
        assert_eq!(of(0, &[]), None);
        assert_eq!(of(3, &[1, 2, 3]), None);
        // a file of another dimension than that of the bodies
        assert_eq!(of(3, &[]), None);
        assert_eq!(of(3, &[2]), Some((3, "1, 3".to_string())));
        assert_eq!(of(0, &[4]), Some((4, "1, 2, 3".to_string())));
        assert_eq!(
            of(u64::MAX, &[1]),
            Some((u64::MAX, "2, 3, 4, 5, 6, ..".to_string()))
        );
    }

    #[test]
    fn what_lies_between_partitions_is_of_neither() {
        let mut partitions = Partitions::default();
        partitions.entities.insert((2, 1), vec![1, 2]);
        partitions.entities.insert((2, 2), vec![2]);
        for entity in [(2, 1), (2, 2), (2, 3)] {
            partitions.see(entity);
        }
        assert_eq!(partitions.seen, [2].into());
    }
}
