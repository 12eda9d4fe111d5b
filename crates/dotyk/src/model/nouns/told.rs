//! Words of messages: lists of names, and equal warnings merged into one.
//!
//! A warning begins with its subject, `body "b1"` or `contact "c1", "c2" and 3 more`, followed by a sentence with figures. Two
//! warnings are of a kind if they differ in names and figures only.
//!
//! * Several bodies or contacts: of three or more of a kind the one with the largest figures is kept, and the others are named.
//! * Several steps: of those about the same subject the one with the largest figures is kept, with the number of steps.

/// Fewest warnings of a kind that are merged.
const SEVERAL: usize = 3;

/// Text between a warning and the further names for which it holds.
const ALSO: &str = "; likewise ";

/// The warnings of one solution, in the order of the first of each kind.
pub(crate) fn told_once(warnings: Vec<String>) -> Vec<String> {
    let mut kinds: Vec<(Sentence, Vec<String>)> = Vec::new();
    for warning in warnings {
        let sentence = Sentence::of(&warning);
        let same = |(kind, _): &&mut (Sentence, Vec<String>)| {
            !sentence.name.is_empty() && kind.words == sentence.words
        };
        match kinds.iter_mut().find(same) {
            Some((_, all)) if all.contains(&warning) => {}
            Some((_, all)) => all.push(warning),
            None => kinds.push((sentence, vec![warning])),
        }
    }
    let tell = |(_, all): (Sentence, Vec<String>)| {
        let mut names: Vec<String> = all.iter().map(|w| Sentence::of(w).name).collect();
        names.sort_unstable();
        names.dedup();
        // several facts about one subject stay separate
        if names.len() < SEVERAL || names.len() < all.len() {
            return all;
        }
        let worst = worst(&all);
        let others = all.iter().enumerate().filter(|(k, _)| *k != worst);
        let others: Vec<String> = others.map(|(_, w)| Sentence::of(w).name).collect();
        let others = named(others.iter().map(String::as_str));
        vec![format!("{}{ALSO}{others}", all[worst])]
    };
    kinds.into_iter().flat_map(tell).collect()
}

/// The warnings of several steps, each merged within its step, in the order of the first of each.
pub(crate) fn told_in_steps<'w>(steps: impl Iterator<Item = &'w [String]>) -> Vec<String> {
    // the warning with the largest figures, and the number of steps with others
    struct Said {
        sentence: Sentence,
        texts: Vec<String>,
        last: usize,
        steps: usize,
        several: bool,
    }
    let mut all: Vec<Said> = Vec::new();
    for (step, warnings) in steps.enumerate() {
        for warning in warnings {
            let sentence = Sentence::of(warning);
            let known = all
                .iter_mut()
                .find(|said| said.sentence.is_about(&sentence));
            let Some(said) = known else {
                all.push(Said {
                    sentence,
                    texts: vec![warning.clone()],
                    last: step,
                    steps: 1,
                    several: false,
                });
                continue;
            };
            said.several |= said.last == step;
            said.steps += usize::from(said.last != step);
            said.last = step;
            if !said.texts.contains(warning) {
                said.texts.push(warning.clone());
            }
        }
    }
    let tell = |said: Said| match said.texts.len() {
        1 => said.texts,
        _ if said.several => said.texts,
        _ => {
            let text = &said.texts[worst(&said.texts)];
            vec![format!("{text} (in {} steps, here most)", said.steps)]
        }
    };
    all.into_iter().flat_map(tell).collect()
}

/// The index of the warning of a kind whose figures are largest, the first one counting most.
fn worst(warnings: &[String]) -> usize {
    let figures: Vec<Vec<f64>> = warnings.iter().map(|w| Sentence::of(w).figures).collect();
    let larger = |a: &[f64], b: &[f64]| {
        let differs = a.iter().zip(b).find(|(a, b)| a != b);
        differs.is_some_and(|(a, b)| a > b)
    };
    (0..warnings.len()).fold(0, |worst, k| match larger(&figures[k], &figures[worst]) {
        true => k,
        false => worst,
    })
}

/// A warning taken apart.
#[derive(Debug, Clone, PartialEq)]
struct Sentence {
    /// Its subject, if that is a single name in front; else empty.
    name: String,
    /// All names in front, as they are written.
    names: String,
    /// The sentence without names and figures.
    words: String,
    figures: Vec<f64>,
}

impl Sentence {
    fn of(warning: &str) -> Self {
        let (said, also) = warning.split_once(ALSO).unwrap_or((warning, ""));
        let (front, rest) = front(said);
        let single = !front.is_empty() && also.is_empty() && front.matches('"').count() == 2;
        let name = front.split('"').nth(1).filter(|_| single);
        let (words, figures) = without_figures(rest);
        let kind = front.split('"').next().unwrap_or_default();
        Self {
            name: name.unwrap_or_default().to_string(),
            // of several subjects another one may have the largest figures in each step
            names: match also.is_empty() {
                true => front.to_string(),
                false => kind.to_string(),
            },
            words: format!("{kind}{words}"),
            figures,
        }
    }

    fn is_about(&self, other: &Self) -> bool {
        self.words == other.words && self.names == other.names
    }
}

/// The kind and the names at the beginning of a warning, and the rest: `contact "a", "b" and 3 more`, `body "b"`. Empty where it has
/// no such beginning.
fn front(warning: &str) -> (&str, &str) {
    let kind = warning.find(' ').unwrap_or(0);
    let mut end = 0;
    let mut at = kind;
    while let Some(inner) = warning[at..]
        .strip_prefix(" \"")
        .or_else(|| warning[at..].strip_prefix(", \""))
    {
        let Some(closing) = inner.find('"') else {
            break;
        };
        at = warning.len() - inner.len() + closing + 1;
        end = at;
    }
    if let Some(more) = warning[end..].strip_prefix(" and ").filter(|_| end > 0) {
        let digits = more.len() - more.trim_start_matches(|c: char| c.is_ascii_digit()).len();
        if digits > 0 && more[digits..].starts_with(" more") {
            end = warning.len() - more.len() + digits + " more".len();
        }
    }
    warning.split_at(end)
}

/// A text with its numbers and the names in quotes taken out, and the numbers; digits within words are no numbers.
fn without_figures(text: &str) -> (String, Vec<f64>) {
    let (mut words, mut figures) = (String::new(), Vec::new());
    let mut rest = text;
    let mut within = false;
    while let Some(c) = rest.chars().next() {
        if c == '"' {
            let closing = rest[1..].find('"').map_or(rest.len(), |k| k + 2);
            words.push('"');
            (rest, within) = (&rest[closing..], false);
            continue;
        }
        let number = if within { None } else { leading_number(rest) };
        match number {
            Some((value, length)) => {
                words.push('#');
                figures.push(value);
                (rest, within) = (&rest[length..], true);
            }
            None => {
                words.push(c);
                within = c.is_alphanumeric() || c == '_' || c == '.';
                rest = &rest[c.len_utf8()..];
            }
        }
    }
    (words, figures)
}

/// The number that a text begins with, and its length.
fn leading_number(text: &str) -> Option<(f64, usize)> {
    let part = |c: char| c.is_ascii_digit() || matches!(c, '.' | 'e' | '-' | '+');
    let longest = text.find(|c: char| !part(c)).unwrap_or(text.len());
    let begins = text.starts_with(|c: char| c.is_ascii_digit() || c == '-');
    let lengths = (1..=longest).rev().filter(|_| begins);
    let mut values = lengths.filter(|&k| text[..k].ends_with(|c: char| c.is_ascii_digit()));
    values.find_map(|k| Some((text[..k].parse().ok()?, k)))
}

/// Most contacts that a warning names.
pub(crate) const NAMED: usize = 4;

/// Words in a sentence: a, b and c; `last` is the word before the last one.
pub(crate) fn listed(words: &[&str], last: &str) -> String {
    match words {
        [before @ .., one, end] => {
            let before: String = before.iter().map(|word| format!("{word}, ")).collect();
            format!("{before}{one} {last} {end}")
        }
        few => few.concat(),
    }
}

/// Some names in quotes: the first ones, and how many more there are.
pub(crate) fn named<'a>(names: impl ExactSizeIterator<Item = &'a str>) -> String {
    let more = match names.len().saturating_sub(NAMED) {
        0 => String::new(),
        more => format!(" and {more} more"),
    };
    let first: Vec<String> = names
        .take(NAMED)
        .map(|name| format!("\"{name}\""))
        .collect();
    first.join(", ") + &more
}

#[cfg(test)]
mod tests {
    use super::*;

    fn strained(name: &str, part: f64) -> String {
        format!("body \"{name}\" is strained by up to {part:.1} %: off by about as much")
    }

    #[test]
    fn of_a_dozen_bodies_the_worst_is_told_and_others_are_named() {
        let mut all: Vec<String> = (0..12).map(|k| strained(&format!("b{k}"), 10.0)).collect();
        all[7] = strained("b7", 43.5);
        all.insert(3, "contact \"c\": it does nothing".to_string());
        let told = told_once(all);
        assert_eq!(
            told,
            [
                "body \"b7\" is strained by up to 43.5 %: off by about as much; likewise \"b0\", \"b1\", \"b2\", \"b3\" and 7 more",
                "contact \"c\": it does nothing",
            ]
        );
    }

    #[test]
    fn two_of_a_kind_and_several_facts_about_one_are_told_one_by_one() {
        let two = vec![strained("a", 6.0), strained("b", 7.0)];
        assert_eq!(told_once(two.clone()), two);
        let at = |x: f64| format!("body \"a\": the force at ({x}, 0) acts at its nearest node");
        let places = vec![at(1.0), at(2.0), at(3.0)];
        assert_eq!(told_once(places.clone()), places);
        // the same of other kinds, and sentences without a name in front
        let others = vec![
            strained("a", 6.0),
            strained("b", 6.0).replace("strained", "turned"),
            strained("c", 6.0).replace("body", "bar"),
            "loads are 1 large".to_string(),
            "loads are 2 large".to_string(),
            "loads are 3 large".to_string(),
        ];
        assert_eq!(told_once(others.clone()), others);
        assert_eq!(told_once(vec![others[0].clone(); 4]), [others[0].clone()]);
    }

    #[test]
    fn what_grows_from_step_to_step_is_told_once_where_it_is_most() {
        let steps = [
            vec![strained("a", 6.0), strained("b", 9.0)],
            vec![strained("a", 8.5), strained("b", 9.0)],
            vec![strained("a", 7.0), "no name".to_string()],
        ];
        let told = told_in_steps(steps.iter().map(Vec::as_slice));
        let most = format!("{} (in 3 steps, here most)", strained("a", 8.5));
        assert_eq!(told, [most, strained("b", 9.0), "no name".to_string()]);
        // the worst of many may be another one in each step
        let many = |worst: &str, part: f64| {
            let all =
                ["a", "b", "c", "d"].map(|n| strained(n, if n == worst { part } else { 6.0 }));
            told_once(all.to_vec())
        };
        let steps = [many("a", 7.0), many("c", 8.0)];
        let told = told_in_steps(steps.iter().map(Vec::as_slice));
        assert_eq!(told.len(), 1, "{told:?}");
        assert!(told[0].starts_with("body \"c\"") && told[0].ends_with("(in 2 steps, here most)"));
        // several places of one body stay several
        let at = |x: f64| format!("body \"a\": the force at ({x}, 0) acts at its nearest node");
        let steps = [vec![at(1.0), at(2.0)], vec![at(1.0), at(2.0)]];
        let told = told_in_steps(steps.iter().map(Vec::as_slice));
        assert_eq!(told, steps[0]);
    }

    #[test]
    fn digits_within_names_are_no_figures() {
        let (words, figures) = without_figures(" at b2.top (1.5, -2e-3), ν = 0.49, 12 %: use tri6");
        assert_eq!(figures, [1.5, -2e-3, 0.49, 12.0]);
        assert_eq!(words, " at b2.top (#, #), ν = #, # %: use tri6");
        assert_eq!(
            front("contact \"a\", \"b\" and 3 more: x").0,
            "contact \"a\", \"b\" and 3 more"
        );
        assert_eq!(front("body \"a\" and body \"b\" meet").0, "body \"a\"");
        assert_eq!(front("nothing \"a").0, "");
        assert_eq!(front("").0, "");
    }
}
