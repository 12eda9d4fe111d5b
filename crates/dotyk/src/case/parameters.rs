//! `[parameters]` of a case file: names that stand for numbers in every expression.
//!
//! A parameter is a number, or an expression of those before it. A run may give some of them another value; the file's own value
//! must still be valid.

use crate::case::document::{Entry, Node, Span, Value};
use crate::case::error::Fault;
use crate::case::expression::{self, Variables};
use crate::case::given::Given;
use crate::case::suggest::{listed, nearest};
use std::collections::{BTreeSet, HashMap};
use std::sync::Arc;

/// The table of a case file.
pub(crate) const KEY: &str = "parameters";

/// Words that stand where a number may.
const WORDS: [&str; 3] = ["closed", "geometric", "auto"];

/// Names and values, in the order of the text.
#[derive(Debug, Default)]
pub(crate) struct Parameters {
    pub values: Vec<(String, f64)>,
    /// Values that the text may name by handles.
    pub given: Arc<Given>,
    /// Words in their own expressions.
    pub words: BTreeSet<String>,
}

impl Parameters {
    /// Names that no text of the document and no other parameter mentions.
    pub fn unused(&self, document: &Node) -> Vec<String> {
        let mut words = self.words.clone();
        words_of(document, &mut words);
        let names = self.values.iter().map(|(name, _)| name);
        names
            .filter(|name| !words.contains(*name))
            .cloned()
            .collect()
    }
}

/// All words in the texts of a document.
fn words_of(node: &Node, words: &mut BTreeSet<String>) {
    match &node.value {
        Value::Text(text) => {
            let parts = text.split(|c: char| !(c.is_ascii_alphanumeric() || c == '_'));
            words.extend(parts.map(str::to_string));
        }
        Value::List(list) => list.iter().for_each(|node| words_of(node, words)),
        Value::Table(entries) => entries
            .iter()
            .for_each(|entry| words_of(&entry.node, words)),
        _ => {}
    }
}

/// The parameters of a table, of which those in `given` (name, number or expression) have another value.
pub(crate) fn read(table: &Node, given: &[(String, String)]) -> Result<Parameters, Fault> {
    let entries = table.entries()?;
    let mut values: Vec<(String, f64)> = Vec::with_capacity(entries.len());
    let places = entries
        .iter()
        .zip(0..)
        .map(|(entry, k)| (entry.key.as_str(), k));
    let places: HashMap<&str, usize> = places.collect();
    for (k, entry) in entries.iter().enumerate() {
        check_name(entry)?;
        check_order(entry, k, &places)?;
        let own = entry.node.number_among(&values)?;
        let other = given.iter().rfind(|(name, _)| *name == entry.key);
        let value = match other {
            Some((name, text)) => given_value(entry, name, text, &values)?,
            None => own,
        };
        values.push((entry.key.clone(), value));
    }
    let mut words = BTreeSet::new();
    words_of(table, &mut words);
    Ok(Parameters {
        values,
        words,
        ..Parameters::default()
    })
}

/// Refuses an expression of parameters that come later.
fn check_order(entry: &Entry, place: usize, places: &HashMap<&str, usize>) -> Result<(), Fault> {
    let mut words = BTreeSet::new();
    words_of(&entry.node, &mut words);
    let known = words
        .iter()
        .filter_map(|word| Some((places.get(word.as_str())?, word)));
    let Some((_, other)) = known.filter(|(at, _)| **at > place).min() else {
        return Ok(());
    };
    let name = &entry.key;
    let message = format!("the parameter `{name}` depends on `{other}`, which comes after it");
    Err(Fault::new(&entry.node.span, message)
        .label("too early")
        .help(format!(
            "a parameter is an expression of those before it: move `{other}` up"
        )))
}

fn given_value(
    entry: &Entry,
    name: &str,
    text: &str,
    before: &[(String, f64)],
) -> Result<f64, Fault> {
    let refused = |why: String| {
        let message = format!("the value given for the parameter `{name}`, \"{text}\": {why}");
        Fault::new(&entry.key_span, message).label("this parameter")
    };
    let field = expression::parse_with(text, Variables::None, before);
    let field = field.map_err(|error| refused(error.message).help(expression::OF_NUMBERS))?;
    let value = field.as_constant().filter(|value| value.is_finite());
    value.ok_or_else(|| refused("it is not finite".to_string()))
}

/// Refuses given values of parameters that the case does not have; `span` is where it has its own.
pub(crate) fn check_given(
    known: &Parameters,
    given: &[(String, String)],
    span: &Span,
) -> Result<(), Fault> {
    let names = || known.values.iter().map(|(name, _)| name.as_str());
    let Some((name, _)) = given
        .iter()
        .find(|(name, _)| names().all(|known| known != name))
    else {
        return Ok(());
    };
    let fault = Fault::new(span, format!("there is no parameter `{name}`"));
    Err(match nearest(name, names()) {
        Some(near) => fault
            .label(format!("the nearest is `{near}`"))
            .help(format!("parameters: {}", listed(names()))),
        None => fault
            .label("the case has none")
            .help(format!("add a table `[{KEY}]` with `{name} = ...`")),
    })
}

/// A name must be readable in an expression, and not have another meaning.
fn check_name(entry: &Entry) -> Result<(), Fault> {
    let name = entry.key.as_str();
    let word = |c: char| c.is_ascii_alphanumeric() || c == '_';
    let refused = |message: String, label: &str| {
        Err(Fault::new(&entry.key_span, message)
            .label(label)
            .help("names of parameters are made of letters, digits and `_`, and do not begin with a digit"))
    };
    if name.is_empty() || !name.chars().all(word) || name.starts_with(|c: char| c.is_ascii_digit())
    {
        return refused(
            format!("`{name}` is not a name of a parameter"),
            "not a name",
        );
    }
    if WORDS
        .into_iter()
        .chain(expression::reserved())
        .any(|known| known == name)
    {
        return refused(
            format!("`{name}` means something else, and cannot be a parameter"),
            "taken",
        );
    }
    Ok(())
}
