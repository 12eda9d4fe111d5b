//! Suggestions for an unknown word: a misspelling, or a word of another program.
//!
//! Distance of two words: insertions, deletions, replacements and swaps of neighbours, each counted once
//! (optimal string alignment); case does not count. Words of other programs are those of their manuals and input files:
//! Abaqus, Code_Aster, PLAXIS, CalculiX, and textbooks.

use crate::case::keys::ALL;

/// Words of other programs and their meanings here; the file explains its format.
const MEANINGS: &str = include_str!("words.txt");

/// Our word, its table (`-` among the words of a choice), and the words of others; `!` in place of our word, with advice, where we
/// have no such word.
fn meanings() -> impl Iterator<Item = [&'static str; 3]> {
    let lines = MEANINGS.lines().filter(|line| !line.starts_with('#'));
    lines.filter_map(|line| {
        let mut parts = line.split(" | ");
        Some([parts.next()?, parts.next()?, parts.next()?])
    })
}

/// The known name with the smallest distance to `name`; ties go to the first. `None` without any known name.
pub fn nearest<'a>(name: &str, known: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    known.into_iter().min_by_key(|k| distance(name, k))
}

/// Letters and digits of a word alone, as in the list of meanings.
fn plain(word: &str) -> String {
    let word = word.to_lowercase();
    word.chars().filter(|c| c.is_alphanumeric()).collect()
}

/// Our words for a word of others, with their tables.
fn ours(plain: &str) -> impl Iterator<Item = [&'static str; 3]> {
    meanings().filter(move |[.., others]| others.split(' ').any(|other| other == plain))
}

/// The known word that means the same as a word of another program or a textbook.
fn here<'a>(word: &str, known: impl Iterator<Item = &'a str> + Clone) -> Option<&'static str> {
    let plain = plain(word);
    let mut words = ours(&plain).map(|[word, ..]| word);
    words.find(|word| known.clone().any(|known| known == *word))
}

/// The meaning of a word of another program or a textbook, if it is not a misspelled known word.
pub fn meaning<'a>(word: &str, known: impl Iterator<Item = &'a str> + Clone) -> Option<String> {
    if let Some(word) = here(word, known.clone()) {
        return Some(format!("here it is `{word}`"));
    }
    let plain = plain(word);
    // a changed letter of a short word makes another word
    let slip = |near: &str| plain.len() > 2 && distance(word, near) <= 1;
    if nearest(word, known.clone()).is_some_and(slip) {
        return None;
    }
    ours(&plain).find_map(|[word, place, _]| match (word, place) {
        (_, "-") => None,
        ("!", instead) => Some(instead.to_string()),
        (word, place) => Some(format!("`{word}` in {place}")),
    })
}

/// The tables of a key that belongs to other tables, if it is not one of these, nor a misspelled one, nor another program's word for
/// one. A word of another program for a key elsewhere ([`meaning`]) comes before a misspelled key.
pub fn elsewhere(key: &str, keys: &[&str]) -> Option<String> {
    let off = |known: &str| distance(key, known);
    let slips = match meaning(key, keys.iter().copied()) {
        None if key.chars().count() > 4 => 1,
        _ => 0,
    };
    if keys.iter().any(|known| off(known) <= 1) || here(key, keys.iter().copied()).is_some() {
        return None;
    }
    let mut tables: Vec<&str> = Vec::new();
    let found = ALL
        .iter()
        .filter(|(table, _)| !["reference", "value"].contains(table));
    let near = |wanted: usize| {
        let with = found.clone().filter_map(move |(table, keys)| {
            let known = keys.iter().find(|known| off(known) == wanted)?;
            Some((*table, *known))
        });
        with.collect::<Vec<_>>()
    };
    let there = (0..=slips).map(near).find(|near| !near.is_empty())?;
    let (_, word) = there[0];
    for (table, _) in there.iter().filter(|(_, known)| *known == word) {
        if !tables.contains(table) {
            tables.push(table);
        }
    }
    // a key of many tables gives no hint of the intended one
    (tables.len() <= 2).then(|| {
        let tables: Vec<String> = tables.iter().map(|table| format!("`{table}`")).collect();
        format!("`{word}` is a key of {}", tables.join(" and "))
    })
}

/// Number of edits between two names.
fn distance(a: &str, b: &str) -> usize {
    let a: Vec<char> = a.to_lowercase().chars().collect();
    let b: Vec<char> = b.to_lowercase().chars().collect();
    let mut rows = vec![vec![0; b.len() + 1]; a.len() + 1];
    for (i, row) in rows.iter_mut().enumerate() {
        row[0] = i;
    }
    rows[0] = (0..=b.len()).collect();
    for i in 1..=a.len() {
        for j in 1..=b.len() {
            let replace = rows[i - 1][j - 1] + usize::from(a[i - 1] != b[j - 1]);
            let mut best = replace.min(rows[i - 1][j] + 1).min(rows[i][j - 1] + 1);
            if i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1] {
                best = best.min(rows[i - 2][j - 2] + 1);
            }
            rows[i][j] = best;
        }
    }
    rows[a.len()][b.len()]
}

/// Names in a sentence: `a`, `b`, `c`.
pub fn listed<'a>(names: impl IntoIterator<Item = &'a str>) -> String {
    let quoted: Vec<String> = names.into_iter().map(|n| format!("`{n}`")).collect();
    quoted.join(", ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_swap_is_nearer_than_two_replacements() {
        assert_eq!(nearest("mehs", ["mash", "mesh"]), Some("mesh"));
    }

    #[test]
    fn a_key_of_another_table_is_sent_there() {
        use crate::case::keys;
        for (key, keys, expected) in [
            (
                "pressure",
                keys::BODY,
                Some("`pressure` is a key of `load` and `gasket`"),
            ),
            (
                "thicknes",
                keys::BODY,
                Some("`thickness` is a key of `material`"),
            ),
            (
                "friction",
                keys::SOLVER,
                Some("`friction` is a key of `contact`"),
            ),
            (
                "tolerance",
                keys::CASE,
                Some("`tolerance` is a key of `solver`"),
            ),
            // also words of other programs for a key, unless it is one of these
            (
                "prestress",
                keys::CONTACT,
                Some("`prestress` is a key of `bar` and `bolt`"),
            ),
            ("prestress", keys::BODY, None),
            // misspelled keys are not moved, and keys of many tables give no hint
            ("surfaces", keys::BODY, None),
            ("meterial", keys::BODY, None),
            ("nmae", keys::MATERIAL, None),
            (
                "compression",
                keys::BODY,
                Some("`compression` is a key of `strength` and `capacity`"),
            ),
            ("whatever", keys::BODY, None),
        ] {
            assert_eq!(elsewhere(key, keys).as_deref(), expected, "{key}");
        }
    }

    #[test]
    fn words_of_other_programs_lead_to_ours() {
        let body = [
            "name",
            "mesh",
            "material",
            "fix",
            "load",
            "body_force",
            "surface",
        ];
        let contact = [
            "name",
            "nonmortar",
            "mortar",
            "sides",
            "gap",
            "friction",
            "tied",
            "pairing",
        ];
        let material = ["young", "poisson", "thickness", "group"];
        let in_ = |known: &[&'static str], word: &str| meaning(word, known.iter().copied());
        for (known, word, expected) in [
            (&material[..], "E", "here it is `young`"),
            (&body, "E", "`young` in material"),
            (&material, "nu", "here it is `poisson`"),
            (&body, "gravity", "here it is `body_force`"),
            (&body, "unit_weight", "here it is `body_force`"),
            (&material, "density", "`body_force` in [[body]]"),
            (&contact, "mu", "here it is `friction`"),
            (&contact, "slave", "here it is `nonmortar`"),
            (&contact, "MASTER", "here it is `mortar`"),
            (&contact, "GROUP_MA_ESCL", "here it is `nonmortar`"),
            (&contact, "clearance", "here it is `gap`"),
            (
                &contact,
                "interference",
                "here it is `gap` of a [[contact]], below zero",
            ),
            (&["xx", "s1"], "S11", "here it is `xx`"),
            (&contact, "penalty", "contact is exact"),
            (&body, "boundary conditions", "here it is `fix`"),
            (
                &["displacement", "stress", "reaction"],
                "U",
                "here it is `displacement`",
            ),
            (
                &["pressure", "gap", "shear", "slip"],
                "CPRESS",
                "here it is `pressure`",
            ),
        ] {
            let found = in_(known, word).unwrap_or_default();
            assert!(found.starts_with(expected), "{word}: {found}");
        }
        // a misspelling counts first, whatever the word means elsewhere
        assert_eq!(in_(&contact, "side"), None);
        assert_eq!(in_(&body, "lod"), None);
    }

    #[test]
    fn every_word_of_ours_is_one() {
        let keys = crate::case::keys::ALL
            .iter()
            .flat_map(|(_, keys)| keys.iter());
        let keys: Vec<&str> = keys.copied().collect();
        assert!(meanings().count() > 30);
        for [word, place, others] in meanings() {
            let bare = word.trim_matches(['[', ']']);
            assert!(
                place == "-" || word == "!" || keys.contains(&bare),
                "{word}"
            );
            let plain = |c: char| c.is_ascii_lowercase() || c.is_ascii_digit() || c == ' ';
            assert!(others.chars().all(plain), "{others}");
        }
    }

    #[test]
    fn case_does_not_count() {
        assert_eq!(nearest("Young", ["poisson", "young"]), Some("young"));
    }
}
