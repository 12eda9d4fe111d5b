//! `$Nodes` and `$Elements` of Gmsh's versions 1 and 2: one list each, groups stand at the elements.

use crate::mesh::import::cursor::Encoding;
use crate::mesh::import::error::ImportError;
use crate::mesh::import::gmsh::{Reader, Version};

/// What stands before the nodes of an element.
struct Head {
    label: i64,
    /// Physical tag; zero is none.
    physical: i64,
    /// In version 2.2, of a partitioned mesh.
    partition: Option<i64>,
}

impl Reader<'_> {
    /// `$NOD`, `$Nodes` and `$ParametricNodes`.
    pub(super) fn nodes(&mut self, parametric: bool) -> Result<(), ImportError> {
        for _ in 0..self.count("the number of nodes")? {
            let start = self.cursor.next_at();
            let number = self.positive("the number of a node")?;
            let point = self.point()?;
            self.add_point(number, start, point)?;
            if parametric {
                let dimension = self.cursor.integer("a dimension")?;
                self.cursor.integer("the number of an entity")?;
                // Nodes inside volumes have no parameters here.
                let parameters = if dimension > 2 { 0 } else { dimension };
                for _ in 0..parameters {
                    self.cursor.real("a parameter")?;
                }
            }
        }
        Ok(())
    }

    /// `$ELM` of version 1: number, type, physical tag, entity, number of nodes.
    pub(super) fn elements_of_version_1(&mut self) -> Result<(), ImportError> {
        self.elements = true;
        for _ in 0..self.count("the number of elements")? {
            let label = self.cursor.integer("the number of an element")?;
            let element = self.element_type()?;
            let physical = self.cursor.integer("a physical tag")?;
            self.cursor.integer("the number of an entity")?;
            let start = self.cursor.next_at();
            let nodes: usize = self.cursor.parsed("the number of nodes of an element")?;
            if nodes != element.nodes {
                let message = format!(
                    "element {label} is a {element} and has {nodes} nodes, {} are needed",
                    element.nodes
                );
                return Err(self.cursor.malformed(start, message));
            }
            let set = self.content.tag_set(vec![physical]);
            self.add_element(element, label.unsigned_abs(), set, |reader| {
                reader.positive("the number of a node")
            })?;
        }
        Ok(())
    }

    /// `$Elements` of version 2.
    pub(super) fn elements(&mut self) -> Result<(), ImportError> {
        self.elements = true;
        let total = self.count("the number of elements")?;
        let mut read = 0;
        while read < total {
            let text = self.cursor.encoding == Encoding::Text;
            let start = self.cursor.next_at();
            let mut label = if text {
                self.cursor.integer("the number of an element")?
            } else {
                0
            };
            let element = self.element_type()?;
            let count = if text {
                1
            } else {
                self.cursor.integer("a number of elements")?
            };
            let tags = self.cursor.integer("the number of tags")?;
            if count < 1 || tags < 0 {
                let message = format!("a block of {count} elements with {tags} tags");
                return Err(self.cursor.malformed(start, message));
            }
            for _ in 0..count {
                if !text {
                    label = self.cursor.integer("the number of an element")?;
                }
                let head = self.head(label, tags)?;
                if element.dimension == self.content.dimension {
                    self.partitions.seen.extend(head.partition);
                }
                let set = self.content.tag_set(vec![head.physical]);
                self.add_element(element, head.label.unsigned_abs(), set, |reader| {
                    reader.positive("the number of a node")
                })?;
            }
            read += count.unsigned_abs();
        }
        match read == total {
            true => Ok(()),
            false => {
                let message =
                    format!("the section announces {total} elements and has {read} or more");
                Err(self.cursor.malformed(self.cursor.at(), message))
            }
        }
    }

    /// The tags of an element: physical tag, entity, in version 2.2 the number of partitions, the partitions.
    fn head(&mut self, label: i64, tags: i64) -> Result<Head, ImportError> {
        let mut head = Head {
            label,
            physical: 0,
            partition: None,
        };
        for place in 0..tags {
            let tag = self.cursor.integer("a tag")?;
            match place {
                0 => head.physical = tag,
                3 if self.version == Version::V22 && tag > 0 => head.partition = Some(tag),
                _ => {}
            }
        }
        Ok(head)
    }
}
