//! Physical groups of one dimension: their names in the file and here, and their tags.

use crate::mesh::import::error::ImportError;
use std::collections::{BTreeMap, BTreeSet};

/// Groups of one dimension.
#[derive(Debug, Clone, Default)]
pub(crate) struct Groups {
    pub names: Vec<String>,
    /// Their names in the file; `None` where it gives a number only.
    pub originals: Vec<Option<String>>,
    pub tags: BTreeMap<i64, usize>,
}

impl Groups {
    /// The group with a name given by a user: its name here, or that in the file.
    pub fn find(&self, name: &str) -> Option<usize> {
        let called = |known: &String| known == name;
        let original = |known: &Option<String>| known.as_deref() == Some(name);
        let found = self.names.iter().position(called);
        found.or_else(|| self.originals.iter().position(original))
    }

    /// Groups of one dimension that elements belong to. Tags of one name are one group.
    pub fn new(
        file: &str,
        dimension: u8,
        used: &BTreeSet<i64>,
        names: &BTreeMap<(u8, i64), String>,
    ) -> Result<Self, ImportError> {
        let mut groups = Self::default();
        for &tag in used {
            let given = names.get(&(dimension, tag));
            let original = given.filter(|name| !name.trim().is_empty()).cloned();
            let called = original.clone().unwrap_or_else(|| tag.to_string());
            let name = valid_name(&called);
            let known = groups.names.iter().position(|known| *known == name);
            let index = match known {
                None => {
                    groups.names.push(name);
                    groups.originals.push(original);
                    groups.names.len() - 1
                }
                Some(index) if original.is_some() && groups.originals[index] == original => index,
                Some(index) => {
                    let first = groups.originals[index].clone();
                    return Err(ImportError::NameClash {
                        file: file.to_string(),
                        first: first.unwrap_or_else(|| groups.names[index].clone()),
                        second: called,
                        name,
                    });
                }
            };
            groups.tags.insert(tag, index);
        }
        Ok(groups)
    }

    /// Groups of each set of tags, ascending.
    pub fn sets(&self, tags: &[Vec<i64>]) -> Vec<Vec<usize>> {
        let of = |tags: &Vec<i64>| {
            let mut set: Vec<usize> = tags
                .iter()
                .filter_map(|t| self.tags.get(t).copied())
                .collect();
            set.sort_unstable();
            set.dedup();
            set
        };
        tags.iter().map(of).collect()
    }
}

/// A name that case files can use: each run of other characters is one `_`.
fn valid_name(text: &str) -> String {
    let mut name = String::new();
    let mut replaced = false;
    for c in text.trim().chars() {
        let valid = c.is_ascii_alphanumeric() || c == '_' || c == '-';
        if valid {
            name.push(c);
        } else if !replaced {
            name.push('_');
        }
        replaced = !valid;
    }
    name
}
