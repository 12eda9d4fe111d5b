//! A TOML text as a tree with places, and how to read typed values out of it.
//!
//! Every reader returns the value or a located error with the expected and the found kind. Tables list their keys; any
//! other key is an error that names the nearest known one.

use crate::case::error::{CaseError, Fault};
use crate::case::expression::{self, ExpressionError, Variables};
use crate::case::given::Given;
use crate::case::parameters::{self, Parameters};
use crate::case::suggest::{elsewhere, listed};
use crate::geometry::{Field, Point};
use crate::model::Formula;
use std::borrow::Cow;
use std::ops::Range;
use std::rc::Rc;
use std::sync::Arc;
use toml::de::{DeTable, DeValue};

/// Bytes of the text.
pub(crate) type Span = Range<usize>;

/// A value and its place in the text.
#[derive(Debug)]
pub(crate) struct Node {
    pub value: Value,
    pub span: Span,
    /// Parameters of its expressions.
    parameters: Rc<Parameters>,
}

#[derive(Debug)]
pub(crate) enum Value {
    Text(String),
    Integer(i64),
    Float(f64),
    Boolean(bool),
    Date,
    List(Vec<Node>),
    Table(Vec<Entry>),
}

/// An expression counts as whole if it differs from an integer by less than this part: rounding.
const WHOLE: f64 = 1e-9;

/// Most bodies, contacts, steps, probes or parameters: each has a name, and is searched by it.
const MOST_LISTED: usize = 10_000;

/// Characters of an expression that a message quotes.
const QUOTED: usize = 80;

/// No count is this large.
const MOST_COUNTED: f64 = 1e15;

/// A key with its value.
#[derive(Debug)]
pub(crate) struct Entry {
    pub key: String,
    pub key_span: Span,
    pub node: Node,
}

/// The tree of a TOML text.
pub(crate) fn parse(text: &str) -> Result<Node, Fault> {
    Ok(parse_with(text, &[], &Arc::default())?.0)
}

/// The tree of a case file, in which its `parameters` have these other values, and their values.
pub(crate) fn parse_with(
    text: &str,
    set: &[(String, String)],
    given: &Arc<Given>,
) -> Result<(Node, Rc<Parameters>), Fault> {
    let document = tables(text)?;
    let span = document.span();
    let (mut document, none) = (document.into_inner(), Rc::default());
    let own = document.remove(parameters::KEY);
    let own = own.map(|value| node(value, &none)).transpose()?;
    let place = own.as_ref().map_or(0..0, |own| own.span.clone());
    let parameters = own.map_or(Ok(Parameters::default()), |own| parameters::read(&own, set))?;
    parameters::check_given(&parameters, set, &place)?;
    let parameters = Rc::new(Parameters {
        given: Arc::clone(given),
        ..parameters
    });
    let node = Node {
        value: table(document, &parameters)?,
        span,
        parameters: parameters.clone(),
    };
    Ok((node, parameters))
}

/// The tree of a TOML text, in which `parameters` is a table as all others.
pub(crate) fn parse_whole(text: &str) -> Result<Node, Fault> {
    let document = tables(text)?;
    let (span, parameters) = (document.span(), Rc::default());
    Ok(Node {
        value: table(document.into_inner(), &parameters)?,
        span,
        parameters,
    })
}

impl CaseError {
    /// The keys of the text that lead to the error, in words, such as "body `block`", "load 2", "`traction`"; none for the text as a
    /// whole.
    pub fn way(&self) -> Vec<String> {
        let root = self
            .span
            .as_ref()
            .and_then(|_| parse_whole(&self.source_text).ok());
        let found = root.zip(self.span.as_ref());
        let found = found.and_then(|(root, place)| way_from(&root, place));
        found.map_or_else(Vec::new, |(_, way)| way)
    }
}

/// The way to the narrowest node around a place, and how narrow it is.
fn way_from(node: &Node, place: &Span) -> Option<(usize, Vec<String>)> {
    let around = |span: &Span| span.start <= place.start && place.end <= span.end;
    let mut best = around(&node.span).then(|| (node.span.len(), Vec::new()));
    let mut take = |found: Option<(usize, Vec<String>)>, step: &str| {
        let found = found.filter(|(width, _)| best.as_ref().is_none_or(|best| *width <= best.0));
        if let Some((width, way)) = found {
            best = Some((
                width,
                std::iter::once(step.to_string()).chain(way).collect(),
            ));
        }
    };
    for Entry {
        key,
        key_span,
        node,
    } in node.entries().unwrap_or_default()
    {
        let list = node
            .list()
            .ok()
            .filter(|list| list.iter().any(|one| one.entries().is_ok()));
        let several = list.is_some_and(|list| list.len() > 1);
        for (number, one) in (1..).zip(list.unwrap_or_default()) {
            let entries = one.entries().unwrap_or_default();
            let name = entries.iter().find(|entry| entry.key == "name");
            let step = match name.map(|entry| &entry.node.value) {
                Some(Value::Text(name)) => format!("{key} `{name}`"),
                _ if several => format!("{key} {number}"),
                _ => key.clone(),
            };
            take(way_from(one, place), &step);
        }
        if list.is_none() {
            let step = match node.value {
                Value::Table(_) => key.clone(),
                _ => format!("`{key}`"),
            };
            take(
                around(key_span).then(|| (key_span.len(), Vec::new())),
                &step,
            );
            take(way_from(node, place), &step);
        }
    }
    best
}

fn tables(text: &str) -> Result<toml::Spanned<DeTable<'_>>, Fault> {
    let document = DeTable::parse(text).map_err(|e| {
        let span = e.span().unwrap_or(0..0);
        Fault::new(&span, format!("not valid TOML: {}", e.message())).label("here")
    })?;
    for (key, value) in document.get_ref() {
        let count = match value.get_ref() {
            DeValue::Array(list) => list.len(),
            DeValue::Table(entries) => entries.len(),
            _ => 0,
        };
        if count > MOST_LISTED {
            let message = format!(
                "`{}` has {count} entries, at most {MOST_LISTED} are read",
                key.get_ref()
            );
            return Err(Fault::new(&key.span(), message).label("too many"));
        }
    }
    Ok(document)
}

/// A text as messages quote it: as much of it as a line holds.
fn short(text: &str) -> Cow<'_, str> {
    match text.char_indices().nth(QUOTED) {
        Some((end, _)) => Cow::Owned(format!("{} ...", &text[..end])),
        None => Cow::Borrowed(text),
    }
}

fn table(table: DeTable<'_>, parameters: &Rc<Parameters>) -> Result<Value, Fault> {
    let mut entries = Vec::with_capacity(table.len());
    for (key, value) in table {
        entries.push(Entry {
            key_span: key.span(),
            key: key.into_inner().into_owned(),
            node: node(value, parameters)?,
        });
    }
    // The TOML reader sorts by name; messages and side patches follow the text.
    entries.sort_by_key(|e| e.key_span.start);
    Ok(Value::Table(entries))
}

fn node(spanned: toml::Spanned<DeValue<'_>>, parameters: &Rc<Parameters>) -> Result<Node, Fault> {
    let span = spanned.span();
    let value = match spanned.into_inner() {
        DeValue::String(text) => Value::Text(text.into_owned()),
        DeValue::Integer(digits) => i64::from_str_radix(digits.as_str(), digits.radix())
            .map(Value::Integer)
            .map_err(|_| Fault::new(&span, "the number has too many digits"))?,
        DeValue::Float(digits) => digits
            .as_str()
            .parse()
            .map(Value::Float)
            .map_err(|_| Fault::new(&span, "this is not a number"))?,
        DeValue::Boolean(value) => Value::Boolean(value),
        DeValue::Datetime(_) => Value::Date,
        DeValue::Array(list) => {
            let nodes = list.into_iter().map(|value| node(value, parameters));
            Value::List(nodes.collect::<Result<_, _>>()?)
        }
        DeValue::Table(entries) => table(entries, parameters)?,
    };
    Ok(Node {
        value,
        span,
        parameters: parameters.clone(),
    })
}

impl Node {
    /// The kind of the value, for messages: "a boolean".
    pub fn kind(&self) -> &'static str {
        match self.value {
            Value::Text(_) => "a string",
            Value::Integer(_) => "an integer",
            Value::Float(_) => "a number",
            Value::Boolean(_) => "a boolean",
            Value::Date => "a date",
            Value::List(_) => "a list",
            Value::Table(_) => "a table",
        }
    }

    /// "expected ..., found ...".
    pub fn expected(&self, what: &str) -> Fault {
        Fault::new(
            &self.span,
            format!("expected {what}, found {}", self.kind()),
        )
        .label(self.kind())
    }

    pub fn text(&self) -> Result<&str, Fault> {
        match &self.value {
            Value::Text(text) => Ok(text),
            _ => Err(self.expected("a string")),
        }
    }

    /// Values that the text may name by handles.
    pub fn given(&self) -> &Given {
        &self.parameters.given
    }

    /// The place of a part of the text; of all of it, if the part is empty.
    pub fn part(&self, bytes: Range<usize>) -> Span {
        if bytes.is_empty() {
            return self.span.clone();
        }
        // the string opens with one quote in all but multi-line strings, where the place is off by two
        let start = (self.span.start + 1 + bytes.start).min(self.span.end.saturating_sub(1));
        start..start + bytes.len()
    }

    pub fn boolean(&self) -> Result<bool, Fault> {
        match self.value {
            Value::Boolean(value) => Ok(value),
            _ => Err(self.expected("true or false")),
        }
    }

    /// A finite number.
    pub fn number(&self) -> Result<f64, Fault> {
        self.number_among(&self.parameters.values)
    }

    /// A finite number, whose expression may name these parameters.
    pub fn number_among(&self, parameters: &[(String, f64)]) -> Result<f64, Fault> {
        let value = match &self.value {
            // Integers of a case file are small: beyond 2^53 the nearest double is meant.
            Value::Integer(value) => *value as f64,
            Value::Float(value) => *value,
            Value::Text(text) => {
                let field = self.expression(text, Variables::None, parameters)?;
                return field.as_constant().ok_or_else(|| self.expected("a number"));
            }
            _ => return Err(self.expected("a number")),
        };
        if value.is_finite() {
            Ok(value)
        } else {
            Err(Fault::new(&self.span, "the number must be finite").label("not finite"))
        }
    }

    /// A finite number > 0; `name` is for the message.
    pub fn positive(&self, name: &str) -> Result<f64, Fault> {
        let value = self.number()?;
        if value > 0.0 {
            Ok(value)
        } else {
            Err(Fault::new(&self.span, format!("{name} must be positive")).label("not > 0"))
        }
    }

    /// A finite number ≥ 0; `name` is for the message.
    pub fn not_negative(&self, name: &str) -> Result<f64, Fault> {
        let value = self.number()?;
        if value >= 0.0 {
            Ok(value)
        } else {
            let message = format!("{name} must not be negative");
            Err(Fault::new(&self.span, message).label("not ≥ 0"))
        }
    }

    /// An integer ≥ 1.
    pub fn positive_integer(&self, name: &str) -> Result<usize, Fault> {
        let count = match self.value {
            Value::Integer(value) => usize::try_from(value).ok(),
            Value::Text(_) => {
                let value = self.number()?;
                // a count is whole up to the rounding of its terms
                let whole = value.round();
                if (value - whole).abs() > WHOLE * whole.abs() {
                    let message = format!("{name} must come out whole, it is {value}");
                    return Err(Fault::new(&self.span, message).label("not whole"));
                }
                (0.0..MOST_COUNTED)
                    .contains(&whole)
                    .then_some(whole as usize)
            }
            _ => return Err(self.expected("a positive integer")),
        };
        count.filter(|count| *count > 0).ok_or_else(|| {
            let message = format!("{name} must be a positive integer");
            Fault::new(&self.span, message).label("not ≥ 1")
        })
    }

    /// A number, or a string with an expression in x, y, z and t.
    pub fn field(&self) -> Result<Field, Fault> {
        self.field_of(Variables::All)
    }

    fn field_of(&self, variables: Variables) -> Result<Field, Fault> {
        match &self.value {
            Value::Text(text) => self.expression(text, variables, &self.parameters.values),
            Value::Integer(_) | Value::Float(_) => Ok(Field::constant(self.number()?)),
            _ => Err(self.expected("a number or an expression string")),
        }
    }

    /// An expression of probes with these names.
    pub fn formula(&self, probes: &[&str]) -> Result<Formula, Fault> {
        let text = self.text()?;
        let formula = expression::parse_formula(text, probes, &self.parameters.values);
        formula.map_err(|error| {
            self.misread("expression", text, &error)
                .help(expression::OF_PROBES)
        })
    }

    /// A fault in an expression, at its place.
    fn misread(&self, what: &str, text: &str, error: &ExpressionError) -> Fault {
        let place = self.part(error.offset..error.offset + 1);
        Fault::new(&place, format!("{what} \"{}\": {error}", short(text))).label("here")
    }

    fn expression(
        &self,
        text: &str,
        variables: Variables,
        parameters: &[(String, f64)],
    ) -> Result<Field, Fault> {
        if let Some(function) = self.parameters.given.function(text) {
            return match variables {
                Variables::None => Err(Fault::new(
                    &self.span,
                    "expected a number, found a function",
                )
                .label("a function")),
                _ => Ok(function.clone()),
            };
        }
        let field = expression::parse_with(text, variables, parameters).map_err(|error| {
            let (what, help) = match variables {
                Variables::None => ("expected a number, the expression", expression::OF_NUMBERS),
                _ => ("expression", expression::VOCABULARY),
            };
            self.misread(what, text, &error).help(help)
        })?;
        match field.as_constant() {
            Some(value) if !value.is_finite() => {
                let text = short(text);
                let message = format!("the value of the expression \"{text}\" is not finite");
                Err(Fault::new(&self.span, message).label(format!("{value}")))
            }
            _ => Ok(field),
        }
    }

    pub fn list(&self) -> Result<&[Node], Fault> {
        match &self.value {
            Value::List(list) => Ok(list),
            _ => Err(self.expected("a list")),
        }
    }

    /// A list of exactly N values.
    fn exactly<const N: usize>(&self, what: &str) -> Result<&[Node; N], Fault> {
        let Value::List(list) = &self.value else {
            return Err(self.expected(&format!("a list of {N} {what}")));
        };
        list.as_slice().try_into().map_err(|_| {
            let message = format!("expected {N} {what}, found {}", list.len());
            let label = match (list.len(), N) {
                (2, 3) => "the third is missing".to_string(),
                (count, _) => format!("{count} values"),
            };
            Fault::new(&self.span, message).label(label)
        })
    }

    /// D finite numbers.
    pub fn point<const D: usize>(&self) -> Result<Point<D>, Fault> {
        let nodes = self.exactly::<D>("numbers")?;
        let mut point = [0.0; D];
        for (c, node) in point.iter_mut().zip(nodes) {
            *c = node.number()?;
        }
        Ok(point)
    }

    /// D numbers or expressions.
    pub fn fields<const D: usize>(&self) -> Result<[Field; D], Fault> {
        self.expressions(Variables::All)
    }

    /// D numbers or expressions in t alone: for values that are the same everywhere.
    pub fn courses<const D: usize>(&self) -> Result<[Field; D], Fault> {
        self.expressions(Variables::Time)
    }

    /// A number or an expression in t alone.
    pub fn course(&self) -> Result<Field, Fault> {
        self.field_of(Variables::Time)
    }

    /// A number or an expression in x, y and z, whose number is from 0 on.
    pub fn stiffness(&self, name: &str) -> Result<Field, Fault> {
        let field = self.field_of(Variables::Place)?;
        match field.as_constant() {
            Some(_) => self.not_negative(name).map(Field::constant),
            None => Ok(field),
        }
    }

    fn expressions<const D: usize>(&self, variables: Variables) -> Result<[Field; D], Fault> {
        let nodes = self.exactly::<D>("numbers or expressions")?;
        let mut fields = zero();
        for (f, node) in fields.iter_mut().zip(nodes) {
            *f = node.field_of(variables)?;
        }
        Ok(fields)
    }

    /// N integers ≥ 1.
    pub fn counts<const N: usize>(&self, name: &str) -> Result<[usize; N], Fault> {
        let mut counts = [0; N];
        for (count, node) in counts
            .iter_mut()
            .zip(self.exactly::<N>("positive integers")?)
        {
            *count = node.positive_integer(name)?;
        }
        Ok(counts)
    }

    /// One of a closed list of words.
    pub fn choice<T: Copy>(&self, what: &str, choices: &[(&str, T)]) -> Result<T, Fault> {
        let text = self.text()?;
        let found = choices.iter().find(|(name, _)| *name == text);
        found.map(|(_, value)| *value).ok_or_else(|| {
            let names = choices.iter().map(|(name, _)| *name);
            Fault::new(&self.span, format!("unknown {what} `{text}`")).nearest(
                text,
                ["the nearest known", "known"],
                names,
            )
        })
    }

    /// The table with these keys and no other.
    pub fn table(&self, keys: &'static [&'static str]) -> Result<Table<'_>, Fault> {
        let entries = self.entries()?;
        if let Some(entry) = entries.iter().find(|e| !keys.contains(&e.key.as_str())) {
            let mut comes = crate::case::keys::LATER
                .iter()
                .filter(|(table, _)| *table == keys);
            if comes.any(|(_, later)| later.contains(&entry.key.as_str())) {
                return Err(later(&entry.key_span, &format!("`{}`", entry.key)));
            }
            let message = format!("unknown key `{}`", entry.key);
            let words = ["the nearest known key", "known here"];
            let fault = Fault::new(&entry.key_span, message);
            return Err(match elsewhere(&entry.key, keys) {
                Some(place) => fault
                    .label(place)
                    .help(format!("known here: {}", listed(keys.iter().copied()))),
                _ => fault.nearest(&entry.key, words, keys.iter().copied()),
            });
        }
        Ok(Table {
            entries,
            span: &self.span,
        })
    }

    /// The entries of a table whose keys are the user's own names.
    pub fn entries(&self) -> Result<&[Entry], Fault> {
        match &self.value {
            Value::Table(entries) => Ok(entries),
            _ => Err(self.expected("a table")),
        }
    }
}

/// The keys of the components of vectors.
pub(crate) const AXES: [&str; 3] = ["x", "y", "z"];

/// How a point of D dimensions is written.
pub(crate) fn coordinates<const D: usize>() -> String {
    format!("[{}]", AXES[..D].join(", "))
}

/// The zero vector as fields.
pub(crate) fn zero<const D: usize>() -> [Field; D] {
    std::array::from_fn(|_| Field::constant(0.0))
}

/// A table all of whose keys are known.
#[derive(Clone, Copy)]
pub(crate) struct Table<'n> {
    entries: &'n [Entry],
    pub span: &'n Span,
}

impl<'n> Table<'n> {
    pub fn entry(&self, key: &str) -> Option<&'n Entry> {
        self.entries.iter().find(|e| e.key == key)
    }

    pub fn get(&self, key: &str) -> Option<&'n Node> {
        self.entry(key).map(|e| &e.node)
    }

    /// The value of a key that must be there; `what` names the table in the message.
    pub fn require(&self, key: &str, what: &str) -> Result<&'n Node, Fault> {
        self.get(key).ok_or_else(|| {
            Fault::new(self.span, format!("{what} needs the key `{key}`"))
                .label(format!("`{key}` is missing"))
        })
    }

    /// The elements of a list that may be missing.
    pub fn list(&self, key: &str) -> Result<&'n [Node], Fault> {
        let Some(entry) = self.entry(key) else {
            return Ok(&[]);
        };
        entry.node.list().map_err(|fault| {
            let header = entry.node.span.start < entry.key_span.start;
            fault.help(match header {
                true => format!("write `[[{key}]]`, with two brackets on each side"),
                false => format!("write `{key} = [...]`: there may be several"),
            })
        })
    }

    /// The first entry whose key is none of these.
    pub fn first_but(&self, keys: &[&str]) -> Option<&'n Entry> {
        self.entries
            .iter()
            .find(|e| !keys.contains(&e.key.as_str()))
    }
    /// The keys that are present, for messages.
    pub fn present(&self) -> Vec<&'n str> {
        self.entries.iter().map(|e| e.key.as_str()).collect()
    }
}

/// The error for a feature of the case file that this version does not have.
pub(crate) fn later(span: &Span, what: &str) -> Fault {
    Fault::new(span, format!("{what} is not supported yet")).label("not supported yet")
}

/// A name that may appear in file names and quantities.
pub(crate) fn name(node: &Node) -> Result<String, Fault> {
    let text = node.text()?;
    check_name(text, &node.span)?;
    Ok(text.to_string())
}

pub(crate) fn check_name(text: &str, span: &Span) -> Result<(), Fault> {
    let valid = |c: char| c.is_ascii_alphanumeric() || c == '_' || c == '-';
    if !text.is_empty() && text.chars().all(valid) {
        return Ok(());
    }
    Err(Fault::new(span, format!("`{text}` is not a valid name"))
        .label("not a valid name")
        .help("names are made of the letters A to Z and a to z, digits, `_` and `-`"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_header_table_has_the_place_of_its_header() {
        let text = "a = 1\n[[body]]\nname = 'b'\n[solver]\ntolerance = 2\n";
        let document = parse(text).unwrap();
        let root = document.table(&["a", "body", "solver"]).unwrap();
        let first = &root.list("body").unwrap()[0];
        assert_eq!(&text[first.span.clone()], "[[body]]");
        assert_eq!(&text[root.get("solver").unwrap().span.clone()], "[solver]");
    }

    #[test]
    fn the_keys_that_lead_to_an_error_are_told() {
        let text = "title = 1\n[units]\nforce = 2\n[[body]]\nname = 'b'\nload = [{ side = 'a', traction = [0, 3] }, { side = 'c' }]\n\
                    [[step]]\ntime = 4\n";
        let way = |at: &str| {
            let start = text.find(at).unwrap();
            let error = CaseError {
                span: Some(start..start + at.len()),
                source_text: text.into(),
                ..CaseError::unplaced("case.toml", "wrong")
            };
            error.way().join(", ")
        };
        assert_eq!(way("1"), "`title`");
        assert_eq!(way("2"), "units, `force`");
        assert_eq!(way("3"), "body `b`, load 1, `traction`");
        assert_eq!(way("'c'"), "body `b`, load 2, `side`");
        assert_eq!(way("{ side = 'c' }"), "body `b`, load 2");
        assert_eq!(way("time"), "step, `time`");
        assert_eq!(CaseError::unplaced("case.toml", "wrong").way(), [""; 0]);
    }

    #[test]
    fn an_error_in_an_expression_points_into_the_string() {
        let text = "a = \"1 + 2*)\"";
        let document = parse(text).unwrap();
        let root = document.table(&["a"]).unwrap();
        let fault = root.get("a").unwrap().field().unwrap_err();
        assert_eq!(&text[fault.span], ")");
    }

    #[test]
    fn radix_and_underscores_are_numbers() {
        let document = parse("a = 0x10\nb = 1_000\nc = 1_0.5e1_0\nd = -3").unwrap();
        let root = document.table(&["a", "b", "c", "d"]).unwrap();
        let value = |key| root.get(key).unwrap().number().unwrap();
        assert_eq!([value("a"), value("b"), value("d")], [16.0, 1000.0, -3.0]);
        assert_eq!(value("c"), 10.5e10);
    }
}
