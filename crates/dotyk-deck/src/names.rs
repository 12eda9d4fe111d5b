//! Names of a deck as names of a case: letters, digits, `_` and `-`, each once.

use std::collections::BTreeSet;

/// A name of a deck with other characters as `_`.
pub(crate) fn clean(name: &str) -> String {
    let fits = |c: char| c.is_ascii_alphanumeric() || c == '_' || c == '-';
    let cleaned: String = name
        .trim()
        .chars()
        .map(|c| if fits(c) { c } else { '_' })
        .collect();
    match cleaned.is_empty() {
        true => "unnamed".to_string(),
        false => cleaned,
    }
}

/// Names that are taken; files of bodies must differ in more than capitals.
#[derive(Debug, Default)]
pub(crate) struct Names(BTreeSet<String>);

impl Names {
    /// A name that is not taken yet: the given one, or with a number behind it.
    pub fn fresh(&mut self, name: &str) -> String {
        let numbered = |k: usize| {
            if k == 1 {
                name.to_string()
            } else {
                format!("{name}-{k}")
            }
        };
        let mut k = 1;
        while !self.0.insert(numbered(k).to_uppercase()) {
            k += 1;
        }
        numbered(k)
    }
}
