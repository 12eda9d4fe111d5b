//! Expressions of a case file: text in, [`Field`] out.
//!
//! Grammar, loosest first, with the conventions of mathematics:
//!
//! ```text
//!   sum     = product (("+" | "-") product)*                 left
//!   product = signed (("*" | "/") signed)*                   left
//!   signed  = ("+" | "-") signed | power                     -x^2 = -(x^2)
//!   power   = atom ("^" signed)?                             right: 2^3^2 = 512; 2^-1 = 0.5
//!   atom    = number | x | y | z | t | pi | parameter | probe | name "(" sum ("," sum)* ")" | "(" sum ")"
//!   probe   = name | "'" any text "'"                        of a formula alone, which has no x, y and z
//! ```
//!
//! Angles in radians. A division by zero and the like give values that are not finite: the caller knows which
//! side and point to name. Evaluation walks a tree and allocates nothing.

use crate::case::suggest::nearest;
use crate::geometry::Field;
use crate::model::Formula;

/// Deepest nesting of parentheses and signs: beyond it a text is refused instead of exhausting the stack.
const DEEPEST: usize = 200;

/// Longest text, in bytes. Lines between the values of a thousand load steps, as programs write them, have room.
const LONGEST: usize = 100_000;

/// The vocabulary of expressions, for messages.
pub(crate) const VOCABULARY: &str = "an expression is made of numbers, parameters, x y z t pi, + - * / ^ ( ), sin cos \
    tan asin acos atan atan2 sinh cosh tanh sqrt exp ln abs min max pow";

/// The same where it must be one number.
pub(crate) const OF_NUMBERS: &str =
    "here stands a number, or an expression of numbers and of the case's [parameters]";

/// The same for a formula.
pub(crate) const OF_PROBES: &str = "an expression of probes is made of numbers, parameters, their names (in quotes what is no word: \
    'left side'), t, pi, + - * / ^ ( ) and functions";

/// An error in an expression, with its place.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{message}")]
pub struct ExpressionError {
    /// The fault, in words.
    pub message: String,
    /// Byte offset in the text.
    pub offset: usize,
}

/// The field that `text` describes, a function of x, y, z and t; without variables it is a constant.
///
/// Errors: unknown names (with the nearest known one), missing operands or parentheses, wrong number of arguments.
pub fn parse(text: &str) -> Result<Field, ExpressionError> {
    parse_with(text, Variables::All, &[])
}

/// Which variables an expression may have.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Variables {
    /// x, y, z and t.
    All,
    /// t alone: for values that are the same everywhere.
    Time,
    /// x, y and z: for values that are the same at all times.
    Place,
    /// No variables: a number.
    None,
}

/// As [`parse`], with these variables and with named values.
pub(crate) fn parse_with(
    text: &str,
    variables: Variables,
    parameters: &[(String, f64)],
) -> Result<Field, ExpressionError> {
    let tree = Parser::new(text, variables, parameters).whole()?;
    Ok(match tree.constant() {
        Some(value) => Field::constant(value),
        None => Field::function(text, move |[x, y, z], t| tree.value(&[x, y, z, t])),
    })
}

/// A formula of probes with these names, of t, and of named values.
///
/// Errors: as [`parse`]; a name that is a probe's and a value's; a constant that is not finite.
pub(crate) fn parse_formula(
    text: &str,
    probes: &[&str],
    parameters: &[(String, f64)],
) -> Result<Formula, ExpressionError> {
    let mut parser = Parser {
        probes: Some(probes),
        ..Parser::new(text, Variables::Time, parameters)
    };
    let tree = parser.whole()?;
    if let Some(value) = tree.constant().filter(|value| !value.is_finite()) {
        let message = format!("its value is not finite: {value}");
        return Err(parser.error_at(0, message));
    }
    Ok(Formula::new(text, parser.taken, move |values, t| {
        let place = [f64::NAN, f64::NAN, f64::NAN, t];
        tree.value(&[&place, values].concat())
    }))
}

const VARIABLES: [&str; 4] = ["x", "y", "z", "t"];

type Unary = (&'static str, fn(f64) -> f64);
type Binary = (&'static str, Operator);
type Operator = fn(f64, f64) -> f64;

const UNARY: [Unary; 13] = [
    ("sin", f64::sin),
    ("cos", f64::cos),
    ("tan", f64::tan),
    ("asin", f64::asin),
    ("acos", f64::acos),
    ("atan", f64::atan),
    ("sinh", f64::sinh),
    ("cosh", f64::cosh),
    ("tanh", f64::tanh),
    ("sqrt", f64::sqrt),
    ("exp", f64::exp),
    ("ln", f64::ln),
    ("abs", f64::abs),
];

const BINARY: [Binary; 4] = [
    ("atan2", f64::atan2),
    ("min", smaller),
    ("max", larger),
    ("pow", f64::powf),
];

/// Unlike `f64::min`, a NaN argument stays visible.
fn smaller(a: f64, b: f64) -> f64 {
    if a.is_nan() || b.is_nan() {
        f64::NAN
    } else {
        a.min(b)
    }
}

/// Unlike `f64::max`, a NaN argument stays visible.
fn larger(a: f64, b: f64) -> f64 {
    if a.is_nan() || b.is_nan() {
        f64::NAN
    } else {
        a.max(b)
    }
}

/// Names that mean something in every expression.
pub(crate) fn reserved<'a>() -> impl Iterator<Item = &'a str> {
    let functions = UNARY.iter().map(|f| f.0).chain(BINARY.iter().map(|f| f.0));
    VARIABLES.into_iter().chain(["pi"]).chain(functions)
}

enum Tree {
    Number(f64),
    Variable(usize),
    Unary(fn(f64) -> f64, Box<Tree>),
    Binary(Operator, Box<[Tree; 2]>),
    /// Operators of one rank from the left: in one place, so that the depth of the tree does not grow with their number.
    Chain(Box<Tree>, Vec<(Operator, Tree)>),
}

impl Tree {
    /// Of x, y, z, t, and the probes that are taken.
    fn value(&self, variables: &[f64]) -> f64 {
        match self {
            Self::Number(value) => *value,
            Self::Variable(index) => variables[*index],
            Self::Unary(f, a) => f(a.value(variables)),
            Self::Binary(f, ab) => f(ab[0].value(variables), ab[1].value(variables)),
            Self::Chain(first, rest) => {
                let rest = rest.iter();
                rest.fold(first.value(variables), |left, (f, right)| {
                    f(left, right.value(variables))
                })
            }
        }
    }

    fn constant(&self) -> Option<f64> {
        match self {
            Self::Number(value) => Some(*value),
            Self::Variable(_) => None,
            Self::Unary(f, a) => a.constant().map(f),
            Self::Binary(f, ab) => Some(f(ab[0].constant()?, ab[1].constant()?)),
            Self::Chain(first, rest) => (rest.iter())
                .try_fold(first.constant()?, |left, (f, right)| {
                    Some(f(left, right.constant()?))
                }),
        }
    }
}

/// The token before the place of a missing operand.
#[derive(Clone, Copy)]
enum Seen {
    Nothing,
    Sign(char),
}

struct Parser<'t> {
    text: &'t str,
    variables: Variables,
    parameters: &'t [(String, f64)],
    /// Names of probes, in a formula.
    probes: Option<&'t [&'t str]>,
    /// Those that it takes.
    taken: Vec<String>,
    position: usize,
    depth: usize,
    last: Seen,
}

impl<'t> Parser<'t> {
    fn new(text: &'t str, variables: Variables, parameters: &'t [(String, f64)]) -> Self {
        Self {
            text,
            variables,
            parameters,
            probes: None,
            taken: Vec::new(),
            position: 0,
            depth: 0,
            last: Seen::Nothing,
        }
    }

    /// The tree of the whole text.
    fn whole(&mut self) -> Result<Tree, ExpressionError> {
        if self.text.len() > LONGEST {
            let message = format!("the expression is longer than {LONGEST} characters");
            return Err(self.error_at(0, message));
        }
        let tree = self.sum()?;
        let message = match self.peek() {
            None => return Ok(tree),
            Some(')') => "this parenthesis closes nothing".to_string(),
            Some(c) => format!("expected an operator or the end, found `{c}`"),
        };
        Err(self.error_at(self.position, message))
    }

    fn error_at(&self, offset: usize, message: String) -> ExpressionError {
        ExpressionError { message, offset }
    }

    /// The next character that is not a blank.
    fn peek(&mut self) -> Option<char> {
        let rest = &self.text[self.position..];
        self.position += rest.len() - rest.trim_start().len();
        self.text[self.position..].chars().next()
    }

    /// Steps over the next character when it is one of `wanted`.
    fn take(&mut self, wanted: &[char]) -> Option<char> {
        let found = self.peek().filter(|c| wanted.contains(c))?;
        self.position += found.len_utf8();
        self.last = Seen::Sign(found);
        Some(found)
    }

    fn sum(&mut self) -> Result<Tree, ExpressionError> {
        self.left_associative(&['+', '-'], Self::product)
    }

    fn product(&mut self) -> Result<Tree, ExpressionError> {
        self.left_associative(&['*', '/'], Self::signed)
    }

    fn left_associative(
        &mut self,
        operators: &[char],
        operand: fn(&mut Self) -> Result<Tree, ExpressionError>,
    ) -> Result<Tree, ExpressionError> {
        let first = operand(self)?;
        let mut rest: Vec<(Operator, Tree)> = Vec::new();
        while let Some(operator) = self.take(operators) {
            let right = operand(self)?;
            let f: Operator = match operator {
                '+' => |a, b| a + b,
                '-' => |a, b| a - b,
                '*' => |a, b| a * b,
                _ => |a, b| a / b,
            };
            rest.push((f, right));
        }
        Ok(match rest.is_empty() {
            true => first,
            false => Tree::Chain(Box::new(first), rest),
        })
    }

    fn signed(&mut self) -> Result<Tree, ExpressionError> {
        self.depth += 1;
        if self.depth > DEEPEST {
            return Err(self.error_at(self.position, "nested too deeply".to_string()));
        }
        let tree = match self.take(&['+', '-']) {
            Some('-') => Tree::Unary(|a| -a, Box::new(self.signed()?)),
            Some(_) => self.signed()?,
            None => self.power()?,
        };
        self.depth -= 1;
        Ok(tree)
    }

    fn power(&mut self) -> Result<Tree, ExpressionError> {
        let base = self.atom()?;
        if self.take(&['^']).is_none() {
            return Ok(base);
        }
        let exponent = self.signed()?;
        Ok(Tree::Binary(f64::powf, Box::new([base, exponent])))
    }

    fn atom(&mut self) -> Result<Tree, ExpressionError> {
        let Some(c) = self.peek() else {
            let message = match self.last {
                Seen::Nothing => "the expression is empty".to_string(),
                Seen::Sign(sign) => format!("the expression ends after `{sign}`"),
            };
            return Err(self.error_at(self.text.len(), message));
        };
        let start = self.position;
        if c.is_ascii_digit() || c == '.' {
            self.number()
        } else if c.is_alphabetic() || c == '_' {
            self.name()
        } else if c == '\'' && self.probes.is_some() {
            self.quoted()
        } else if self.take(&['(']).is_some() {
            let inner = self.sum()?;
            self.close(start)?;
            Ok(inner)
        } else {
            let message = format!("expected a number, a name or `(`, found `{c}`");
            Err(self.error_at(start, message))
        }
    }

    /// Steps over `)`, or says which parenthesis is open.
    fn close(&mut self, opened: usize) -> Result<(), ExpressionError> {
        match self.peek() {
            Some(')') => {
                self.position += 1;
                Ok(())
            }
            None => Err(self.error_at(opened, "this parenthesis is never closed".to_string())),
            Some(c) => {
                let message = format!("expected an operator or `)`, found `{c}`");
                Err(self.error_at(self.position, message))
            }
        }
    }

    /// Digits, point, exponent: `1e-6`, `2.`, `.5`. The exponent belongs to the number only when digits follow.
    fn number(&mut self) -> Result<Tree, ExpressionError> {
        let start = self.position;
        let bytes = self.text.as_bytes();
        let digits = |from: usize| {
            let count = bytes[from..].iter().take_while(|b| b.is_ascii_digit());
            from + count.count()
        };
        let mut end = digits(start);
        if bytes.get(end) == Some(&b'.') {
            end = digits(end + 1);
        }
        if matches!(bytes.get(end), Some(b'e' | b'E')) {
            let sign = usize::from(matches!(bytes.get(end + 1), Some(b'+' | b'-')));
            let last = digits(end + 1 + sign);
            if last > end + 1 + sign {
                end = last;
            }
        }
        let text = &self.text[start..end];
        self.position = end;
        match text.parse::<f64>() {
            Ok(value) if value.is_finite() => Ok(Tree::Number(value)),
            Ok(_) => Err(self.error_at(start, format!("the number `{text}` is too large"))),
            Err(_) => Err(self.error_at(start, format!("`{text}` is not a number"))),
        }
    }

    fn name(&mut self) -> Result<Tree, ExpressionError> {
        let start = self.position;
        let rest = &self.text[start..];
        let length = rest
            .find(|c: char| !(c.is_alphanumeric() || c == '_'))
            .unwrap_or(rest.len());
        let name = &rest[..length];
        self.position += length;
        // x, y and z have no other meaning in a formula
        let means_else = reserved().any(|word| word == name) && !["x", "y", "z"].contains(&name);
        let is_parameter = self.parameters.iter().any(|(known, _)| known == name);
        match self.probes.is_some_and(|probes| probes.contains(&name)) {
            true if is_parameter => {
                let message =
                    format!("`{name}` is a parameter and a probe: give one of them another name");
                return Err(self.error_at(start, message));
            }
            true if !means_else => return Ok(self.probe(name)),
            _ => {}
        }
        if let Some(index) = VARIABLES.iter().position(|v| *v == name) {
            let meaningless = match self.variables {
                Variables::All => None,
                Variables::Time if name == "t" => None,
                Variables::Time => Some("this is the same everywhere, it may change with t"),
                Variables::Place if name != "t" => None,
                Variables::Place => Some(
                    "this is the same at all times, it may change with x, y and z; what comes or goes has `active`",
                ),
                Variables::None => Some("this is one number"),
            };
            if let Some(why) = meaningless {
                return Err(self.error_at(start, format!("`{name}` has no meaning here: {why}")));
            }
            return Ok(Tree::Variable(index));
        }
        if let Some((_, value)) = self.parameters.iter().find(|(known, _)| known == name) {
            return Ok(Tree::Number(*value));
        }
        if name == "pi" {
            return Ok(Tree::Number(std::f64::consts::PI));
        }
        if let Some((_, f)) = UNARY.iter().find(|(n, _)| *n == name) {
            let [a] = self.arguments(name, start)?;
            return Ok(Tree::Unary(*f, Box::new(a)));
        }
        if let Some((_, f)) = BINARY.iter().find(|(n, _)| *n == name) {
            let ab = self.arguments(name, start)?;
            return Ok(Tree::Binary(*f, Box::new(ab)));
        }
        if ["nan", "inf", "infinity"].contains(&name.to_lowercase().as_str()) {
            let message = format!("`{name}` is no number to compute with");
            return Err(self.error_at(start, message));
        }
        let parameters = self.parameters.iter().map(|(name, _)| name.as_str());
        let meaningful = |known: &&str| match self.variables {
            Variables::All => true,
            Variables::Time => !["x", "y", "z"].contains(known),
            Variables::Place => *known != "t",
            Variables::None => !VARIABLES.contains(known),
        };
        let mut probes = self.probes.unwrap_or_default().iter().copied();
        let known = parameters.chain(reserved().filter(meaningful));
        let near = nearest(name, known.chain(probes.clone())).unwrap_or_default();
        // the beginning of the name of a probe that is no word
        let begins = |probe: &&str| probe.len() > length && rest.starts_with(probe);
        let message = match probes.find(begins) {
            Some(probe) => format!("the probe `{probe}` stands in quotes here: '{probe}'"),
            None => format!("unknown name `{name}`, the nearest known is `{near}`"),
        };
        Err(self.error_at(start, message))
    }

    /// The value of a probe.
    fn probe(&mut self, name: &str) -> Tree {
        let place = self.taken.iter().position(|taken| taken == name);
        let place = place.unwrap_or_else(|| {
            self.taken.push(name.to_string());
            self.taken.len() - 1
        });
        Tree::Variable(VARIABLES.len() + place)
    }

    /// A probe whose name stands in quotes, whatever it is.
    fn quoted(&mut self) -> Result<Tree, ExpressionError> {
        let start = self.position;
        let rest = &self.text[start + 1..];
        let Some(length) = rest.find('\'') else {
            return Err(self.error_at(start, "this quote is never closed".to_string()));
        };
        let name = &rest[..length];
        self.position += length + 2;
        let probes = self.probes.unwrap_or_default();
        if probes.contains(&name) {
            return Ok(self.probe(name));
        }
        let near = match nearest(name, probes.iter().copied()) {
            Some(near) => format!(", the nearest known is '{near}'"),
            None => String::new(),
        };
        Err(self.error_at(start, format!("there is no probe '{name}'{near}")))
    }

    /// The N arguments of a function, in parentheses.
    fn arguments<const N: usize>(
        &mut self,
        name: &str,
        start: usize,
    ) -> Result<[Tree; N], ExpressionError> {
        let opened = {
            self.peek();
            self.position
        };
        if self.take(&['(']).is_none() {
            let message = format!("the function `{name}` needs its argument in parentheses");
            return Err(self.error_at(start, message));
        }
        let mut arguments = vec![self.sum()?];
        while self.take(&[',']).is_some() {
            arguments.push(self.sum()?);
        }
        self.close(opened)?;
        arguments.try_into().map_err(|given: Vec<Tree>| {
            let plural = if N == 1 { "" } else { "s" };
            let count = given.len();
            self.error_at(
                start,
                format!("the function `{name}` takes {N} argument{plural}, found {count}"),
            )
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn value(text: &str) -> f64 {
        parse(text).unwrap().at([3.0, 5.0, 7.0], 0.5)
    }

    fn error(text: &str) -> (usize, String) {
        let e = parse(text).unwrap_err();
        (e.offset, e.message)
    }

    #[test]
    fn the_sign_binds_looser_than_the_power() {
        assert_eq!(value("-x^2"), -9.0);
        assert_eq!(value("-2^2"), -4.0);
        assert_eq!(value("1 - x^2"), -8.0);
        assert_eq!(value("(-x)^2"), 9.0);
        assert_eq!(value("2*-x^2"), -18.0);
        assert_eq!(value("--2"), 2.0);
        assert_eq!(value("-sin(0)^2 + 1"), 1.0);
    }

    #[test]
    fn powers_associate_to_the_right_and_take_signed_exponents() {
        assert_eq!(value("2^3^2"), 512.0);
        assert_eq!(value("2^-1"), 0.5);
        assert_eq!(value("2^-1^2"), 0.5);
        assert_eq!(value("-2^-2"), -0.25);
        assert_eq!(value("2^2*3"), 12.0);
    }

    #[test]
    fn products_bind_tighter_than_sums_and_both_associate_to_the_left() {
        assert_eq!(value("1 + 2*3"), 7.0);
        assert_eq!(value("(1 + 2)*3"), 9.0);
        assert_eq!(value("8 - 3 - 2"), 3.0);
        assert_eq!(value("16/4/2"), 2.0);
        assert_eq!(value("2*-3"), -6.0);
        assert_eq!(value("6/-3 - -1"), -1.0);
    }

    #[test]
    fn numbers_may_lack_digits_on_either_side_of_the_point() {
        assert_eq!(value("1e-6"), 1e-6);
        assert_eq!(value("2."), 2.0);
        assert_eq!(value(".5"), 0.5);
        assert_eq!(value("1.5E+3"), 1500.0);
        assert_eq!(value("210e9"), 210e9);
    }

    #[test]
    fn variables_are_the_place_and_the_time() {
        assert_eq!(value("x + 10*y + 100*z + t"), 753.5);
        assert_eq!(value("-1e6 * (1 + 0.1*x)"), -1e6 * (1.0 + 0.1 * 3.0));
    }

    #[test]
    fn every_function_is_the_one_of_its_name() {
        let expected = [
            ("sin(pi/6)", 0.5),
            ("cos(pi/3)", 0.5),
            ("tan(pi/4)", 1.0),
            ("asin(1)", std::f64::consts::FRAC_PI_2),
            ("acos(0)", std::f64::consts::FRAC_PI_2),
            ("atan(1)", std::f64::consts::FRAC_PI_4),
            ("atan2(1, 0)", std::f64::consts::FRAC_PI_2),
            ("sinh(ln(2))", 0.75),
            ("cosh(ln(2))", 1.25),
            ("tanh(ln(2))", 0.6),
            ("sqrt(x*x + 16)", 5.0),
            ("exp(0)", 1.0),
            ("ln(exp(2))", 2.0),
            ("abs(-x)", 3.0),
            ("min(x, y)", 3.0),
            ("max(x, y)", 5.0),
            ("pow(x, 2)", 9.0),
        ];
        for (text, expected) in expected {
            let found = value(text);
            // a few roundings of functions of order one
            assert!((found - expected).abs() < 1e-14, "{text}: {found}");
        }
    }

    #[test]
    fn a_formula_names_probes_as_words_and_in_quotes() {
        let probes = ["left", "crown-left", "x", "max", "a.b c"];
        let parameters = [("depth".to_string(), 4.0)];
        let text = "0.5*(left - 'crown-left')/depth + x*t + max('max', 'a.b c') + 0*left";
        let formula = parse_formula(text, &probes, &parameters).unwrap();
        assert_eq!(
            formula.probes(),
            ["left", "crown-left", "x", "max", "a.b c"]
        );
        let known = |name: &str| {
            probes
                .iter()
                .position(|p| *p == name)
                .map(|k| k as f64 + 1.0)
        };
        assert_eq!(
            formula.value(known, 2.0),
            0.5 * (1.0 - 2.0) / 4.0 + 3.0 * 2.0 + 5.0
        );
        assert_eq!(formula.to_string(), text);
    }

    #[test]
    fn wrong_formulas_are_told_at_their_place() {
        let parameters = [("depth".to_string(), 4.0)];
        let of = |text: &str| {
            let probes = ["left", "crown-left", "depth"];
            let e = parse_formula(text, &probes, &parameters).unwrap_err();
            (e.offset, e.message)
        };
        let wrong = [
            (
                "1 + lefft",
                4,
                "unknown name `lefft`, the nearest known is `left`",
            ),
            (
                "leftover",
                0,
                "unknown name `leftover`, the nearest known is `left`",
            ),
            (
                "crown-left + 1",
                0,
                "the probe `crown-left` stands in quotes here: 'crown-left'",
            ),
            (
                "left - 'crown-lef'",
                7,
                "there is no probe 'crown-lef', the nearest known is 'crown-left'",
            ),
            ("left + 'crown-left", 7, "this quote is never closed"),
            ("left/depth", 5, "`depth` is a parameter and a probe"),
            ("left*y", 5, "`y` has no meaning here"),
            ("1/0", 0, "not finite"),
            ("", 0, "the expression is empty"),
        ];
        for (text, offset, words) in wrong {
            let (at, message) = of(text);
            assert!(
                at == offset && message.contains(words),
                "{text}: {at} {message}"
            );
        }
        // elsewhere a quote is none
        assert!(error("'left'").1.contains("found `'`"));
        assert_eq!(of("left + $").0, 7);
    }

    #[test]
    fn an_expression_without_variables_is_a_constant() {
        assert_eq!(parse("2*3 + 1").unwrap().as_constant(), Some(7.0));
        assert_eq!(parse("0*x").unwrap().as_constant(), None);
    }

    #[test]
    fn undefined_values_are_not_finite() {
        assert!(value("1/0").is_infinite());
        assert!(value("sqrt(-x)").is_nan());
        assert!(value("max(0, ln(-1))").is_nan());
        assert!(value("min(ln(-1), 0)").is_nan());
    }

    #[test]
    fn errors_tell_the_position() {
        assert_eq!(error("").1, "the expression is empty");
        assert_eq!(error("1 + ").0, 4);
        assert_eq!(error("2 * (x + 1").0, 4);
        assert_eq!(error("x + 1)").0, 5);
        assert_eq!(error("x + * 2").0, 4);
        assert_eq!(error("2 x").0, 2);
        assert_eq!(error("x y").0, 2);
        assert_eq!(error("1 + $").0, 4);
        assert_eq!(error("1.2.3").0, 3);
        assert_eq!(error("min(1)").0, 0);
        assert_eq!(error("1 + sin x").0, 4);
        assert_eq!(error("sin(1, 2)").0, 0);
        assert_eq!(error("1 + sin()").0, 8);
        assert_eq!(error("ř + 1").0, 0);
        assert_eq!(error(".").0, 0);
    }

    #[test]
    fn an_unknown_name_brings_the_nearest_known_one() {
        let (offset, message) = error("1 + sinn(x)");
        assert_eq!(offset, 4);
        assert!(message.contains("`sinn`") && message.contains("nearest known is `sin`"));
        assert!(error("X").1.contains("nearest known is `x`"));
    }

    #[test]
    fn deep_nesting_is_an_error_and_not_a_crash() {
        assert!(error(&"(".repeat(4000)).1.contains("deeply"));
        assert!(error(&"-".repeat(4000)).1.contains("deeply"));
        assert!(error(&"2^".repeat(2000)).1.contains("deeply"));
        assert!(error(&"1+".repeat(100_000)).1.contains("longer"));
        assert_eq!(value(&("1+".repeat(1999) + "x")), 2002.0);
        assert_eq!(value(&("1-".repeat(49_999) + "x")), 1.0 - 49_998.0 - 3.0);
        assert_eq!(value(&("1*".repeat(49_999) + "1")), 1.0);
    }

    #[test]
    fn the_vocabulary_lists_every_name() {
        let functions = UNARY.iter().map(|f| f.0).chain(BINARY.iter().map(|f| f.0));
        for name in functions.chain(VARIABLES).chain(["pi"]) {
            assert!(
                VOCABULARY.split([' ', ',']).any(|word| word == name),
                "{name}"
            );
        }
    }

    proptest! {
        #[test]
        fn no_text_makes_the_parser_panic(text in "[-+*/^(),.0-9a-zxř ]{0,40}") {
            if let Err(e) = parse(&text) {
                prop_assert!(e.offset <= text.len() && text.is_char_boundary(e.offset));
            }
        }
    }
}
