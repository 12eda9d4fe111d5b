//! `$Entities`, `$Nodes` and `$Elements` of Gmsh's version 4: in blocks by geometric entity, whose groups stand there.
//!
//! Version 4.0 has the number of an entity before its dimension, numbers of nodes and elements as integers of four bytes
//! beside their data, and boxes of points.

use crate::mesh::import::error::ImportError;
use crate::mesh::import::gmsh::{Reader, Version};

impl Reader<'_> {
    /// `$Entities`: physical tags; positions and boundaries are not needed.
    pub(super) fn entities(&mut self) -> Result<(), ImportError> {
        for (dimension, count) in (0..).zip(self.counts()?) {
            for _ in 0..count {
                let entity = self.cursor.integer("the number of an entity")?;
                let physical = self.physical(dimension)?;
                self.entities.insert((dimension, entity), physical);
            }
        }
        Ok(())
    }

    /// `$PartitionedEntities`: the same with the partitions that an entity belongs to.
    pub(super) fn partitioned(&mut self) -> Result<(), ImportError> {
        let announced = self.cursor.size("the number of partitions")?;
        self.partitions.announced = self.partitions.announced.max(announced);
        for _ in 0..self.cursor.size("the number of ghost entities")? {
            self.cursor.integer("the number of a ghost entity")?;
            self.cursor.integer("a partition")?;
        }
        for (dimension, count) in (0..).zip(self.counts()?) {
            for _ in 0..count {
                let entity = self.cursor.integer("the number of an entity")?;
                let parent = self.cursor.integer("the dimension of an entity")?;
                self.cursor.integer("the number of an entity")?;
                let partitions = self.integers("a partition")?;
                let mut physical = self.physical(dimension)?;
                if parent != dimension {
                    // between partitions: the tags are those of a group of the dimension above
                    physical.clear();
                }
                self.entities.insert((dimension, entity), physical);
                self.partitions
                    .entities
                    .insert((dimension, entity), partitions);
            }
        }
        Ok(())
    }

    /// Numbers of the points, curves, surfaces and volumes.
    fn counts(&mut self) -> Result<[u64; 4], ImportError> {
        let mut counts = [0; 4];
        for count in &mut counts {
            *count = self.cursor.size("the number of entities")?;
        }
        Ok(counts)
    }

    /// The physical tags of an entity, behind its box and before its boundary.
    fn physical(&mut self, dimension: i64) -> Result<Vec<i64>, ImportError> {
        let point = dimension == 0 && self.version == Version::V41;
        for _ in 0..if point { 3 } else { 6 } {
            // A bounding box may be infinite where an entity is empty.
            self.cursor.number("a coordinate")?;
        }
        let physical = self.integers("a physical tag")?;
        if dimension > 0 {
            self.integers("an entity of the boundary")?;
        }
        Ok(physical)
    }

    /// A size and as many integers.
    fn integers(&mut self, what: &str) -> Result<Vec<i64>, ImportError> {
        let count = self.cursor.size("a number of tags")?;
        (0..count).map(|_| self.cursor.integer(what)).collect()
    }

    /// Number of blocks and of all their entries, which the head of a section tells.
    fn totals(&mut self, what: &str) -> Result<(u64, u64), ImportError> {
        let blocks = self
            .cursor
            .size(&format!("the number of blocks of {what}"))?;
        let total = self.cursor.size(&format!("the number of {what}"))?;
        if self.version == Version::V41 {
            self.cursor
                .size(&format!("the smallest number of {what}"))?;
            self.cursor.size(&format!("the largest number of {what}"))?;
        }
        Ok((blocks, total))
    }

    /// Dimension and number of the entity of a block.
    fn entity(&mut self) -> Result<(i64, i64), ImportError> {
        let words = ["a dimension", "the number of an entity"];
        if self.version == Version::V41 {
            let dimension = self.cursor.integer(words[0])?;
            return Ok((dimension, self.cursor.integer(words[1])?));
        }
        let number = self.cursor.integer(words[1])?;
        Ok((self.cursor.integer(words[0])?, number))
    }

    /// The number of a node or an element.
    fn label(&mut self, what: &str) -> Result<u64, ImportError> {
        match self.version {
            Version::V41 => self.cursor.size(what),
            _ => self.positive(what),
        }
    }

    pub(super) fn nodes_of_entities(&mut self) -> Result<(), ImportError> {
        let start = self.cursor.next_at();
        let (blocks, total) = self.totals("nodes")?;
        let mut read = 0;
        for _ in 0..blocks {
            let (dimension, _) = self.entity()?;
            let parametric = self.cursor.integer("0, or 1 for parametric nodes")?;
            let parameters = if parametric == 0 { 0 } else { dimension };
            let count = self.cursor.size("the number of nodes of a block")?;
            let mut numbers = Vec::new();
            if self.version == Version::V41 {
                for _ in 0..count {
                    numbers.push((self.cursor.next_at(), self.label("the number of a node")?));
                }
            }
            for node in 0..count {
                let (at, number) = match numbers.get(node as usize) {
                    Some(listed) => *listed,
                    None => (self.cursor.next_at(), self.label("the number of a node")?),
                };
                let point = self.point()?;
                self.add_point(number, at, point)?;
                for _ in 0..parameters {
                    self.cursor.real("a parameter")?;
                }
                read += 1;
            }
        }
        self.agree(start, total, read, "nodes")
    }

    pub(super) fn elements_of_entities(&mut self) -> Result<(), ImportError> {
        self.elements = true;
        let start = self.cursor.next_at();
        let (blocks, total) = self.totals("elements")?;
        let mut read = 0;
        for _ in 0..blocks {
            let entity = self.entity()?;
            let element = self.element_type()?;
            let count = self.cursor.size("the number of elements of a block")?;
            if count > 0 && element.dimension == self.content.dimension {
                self.partitions.see(entity);
            }
            let physical = self.entities.get(&entity);
            let set = self.content.tag_set(physical.cloned().unwrap_or_default());
            for _ in 0..count {
                let label = self.label("the number of an element")?;
                self.add_element(element, label, set, |reader| {
                    reader.label("the number of a node")
                })?;
                read += 1;
            }
        }
        self.agree(start, total, read, "elements")
    }

    /// The total that a section announces must be that of its blocks.
    fn agree(&self, start: usize, total: u64, read: u64, what: &str) -> Result<(), ImportError> {
        if total == read {
            return Ok(());
        }
        let message = format!(
            "the section announces {total} {what}, its blocks have {read}: write the file again"
        );
        Err(self.cursor.malformed(start, message))
    }
}
