//! Small changes of a program: the places of a source file, each with its change.
//!
//! A place is a range of bytes of the file and its replacement: pieces of the same file, and words between them. Two ranges
//! are nested or disjoint, so that all changes of a file can be written into one copy of it.
//!
//! Not changed: tests, constants and other values computed at compile time, patterns, types, attributes, and the contents of
//! macros.

use std::ops::Range;
use syn::spanned::Spanned;
use syn::visit::{self, Visit};
use syn::{BinOp, Expr, Lit, ReturnType, Stmt, UnOp};

/// Bytes of a file.
pub type Bytes = Range<usize>;

/// A piece of changed text.
#[derive(Debug, Clone, PartialEq)]
pub enum Piece {
    /// A piece of the file, with the changes inside of it.
    Same(Bytes),
    /// Other words.
    Words(String),
}

/// A place that can be changed.
#[derive(Debug, Clone)]
pub struct Place {
    /// The replaced range; empty for an insertion.
    pub bytes: Bytes,
    /// Line in the file, from 1.
    pub line: usize,
    /// The change in words.
    pub what: String,
    /// The replacement.
    pub changed: Vec<Piece>,
}

/// The places of a source text.
pub fn places(text: &str) -> Result<Vec<Place>, syn::Error> {
    let mut finder = Finder {
        text,
        places: Vec::new(),
    };
    finder.visit_file(&syn::parse_file(text)?);
    Ok(finder.places)
}

struct Finder<'t> {
    text: &'t str,
    places: Vec<Place>,
}

impl Finder<'_> {
    fn add(&mut self, bytes: Bytes, what: String, changed: Vec<Piece>) {
        let line = self.text[..bytes.start].matches('\n').count() + 1;
        self.places.push(Place {
            bytes,
            line,
            what,
            changed,
        });
    }

    /// Replaces one range inside of an expression.
    fn replace(&mut self, whole: &Expr, part: Bytes, by: &str) {
        let bytes = whole.span().byte_range();
        let what = format!("`{}` becomes `{by}`", &self.text[part.clone()]);
        let (before, after) = (bytes.start..part.start, part.end..bytes.end);
        let changed = vec![
            Piece::Same(before),
            Piece::Words(by.to_string()),
            Piece::Same(after),
        ];
        self.add(bytes, what, changed);
    }

    fn binary(&mut self, whole: &Expr, binary: &syn::ExprBinary) {
        let others: &[&str] = match binary.op {
            BinOp::Add(_) => &["-"],
            BinOp::Sub(_) => &["+"],
            BinOp::Mul(_) => &["/"],
            BinOp::Div(_) => &["*"],
            BinOp::AddAssign(_) => &["-="],
            BinOp::SubAssign(_) => &["+="],
            BinOp::MulAssign(_) => &["/="],
            BinOp::DivAssign(_) => &["*="],
            BinOp::And(_) => &["||"],
            BinOp::Or(_) => &["&&"],
            BinOp::Eq(_) => &["!="],
            BinOp::Ne(_) => &["=="],
            BinOp::Lt(_) => &["<=", ">"],
            BinOp::Le(_) => &["<", ">"],
            BinOp::Gt(_) => &[">=", "<"],
            BinOp::Ge(_) => &[">", "<"],
            _ => &[],
        };
        // a condition that binds a name is not an expression
        if !binds(whole) {
            for other in others {
                self.replace(whole, binary.op.span().byte_range(), other);
            }
        }
    }

    /// A literal, a little larger.
    fn literal(&mut self, whole: &Expr, literal: &Lit) {
        let larger = match literal {
            Lit::Int(n) => n.base10_parse::<u64>().ok().map(|value| {
                let suffix = n.suffix();
                format!("{}{suffix}", value + 1)
            }),
            // smaller numbers are tolerances of rounding: a small change of them is not an error
            Lit::Float(n) => n.base10_parse::<f64>().ok().and_then(|value| match value {
                0.0 => Some("0.1".to_string()),
                value if value >= 1e-3 => Some(format!("{:?}", 1.1 * value)),
                _ => None,
            }),
            Lit::Bool(value) => Some((!value.value).to_string()),
            _ => None,
        };
        if let Some(larger) = larger {
            self.replace(whole, whole.span().byte_range(), &larger);
        }
    }

    /// The body of a function, left at its beginning with a trivial value.
    fn body(&mut self, name: &syn::Ident, output: &ReturnType, block: &syn::Block) {
        let values: &[&str] = match output {
            ReturnType::Default => &[""],
            ReturnType::Type(_, kind) => match &self.text[kind.span().byte_range()] {
                "bool" => &["true", "false"],
                "f64" => &["0.0", "1.0"],
                kind if kind.starts_with("Result<") => &["Ok(Default::default())"],
                // these types have no trivial value
                "Self" => &[],
                kind if kind.starts_with("impl ") || kind.starts_with('&') => &[],
                _ => &["Default::default()"],
            },
        };
        let start = block.brace_token.span.open().byte_range().end;
        if block.stmts.is_empty() {
            return;
        }
        for value in values {
            let words = Piece::Words(format!("return {value};"));
            let what = format!("`{name}` answers `{value}`");
            self.add(start..start, what, vec![words]);
        }
    }
}

/// Does a condition bind a name (`if let`)?
fn binds(condition: &Expr) -> bool {
    match condition {
        Expr::Let(_) => true,
        Expr::Binary(binary) => binds(&binary.left) || binds(&binary.right),
        _ => false,
    }
}

/// Is an item, or a function, for tests alone?
fn for_tests(attributes: &[syn::Attribute]) -> bool {
    attributes.iter().any(|attribute| {
        attribute.path().is_ident("test")
            || (attribute.path().is_ident("cfg")
                && attribute
                    .parse_args::<syn::Ident>()
                    .is_ok_and(|word| word == "test"))
    })
}

impl<'ast> Visit<'ast> for Finder<'_> {
    fn visit_item(&mut self, item: &'ast syn::Item) {
        match item {
            syn::Item::Const(_) | syn::Item::Static(_) | syn::Item::Macro(_) => {}
            syn::Item::Mod(module) if for_tests(&module.attrs) => {}
            item => visit::visit_item(self, item),
        }
    }

    fn visit_item_fn(&mut self, function: &'ast syn::ItemFn) {
        if function.sig.constness.is_none() && !for_tests(&function.attrs) {
            self.body(&function.sig.ident, &function.sig.output, &function.block);
            self.visit_block(&function.block);
        }
    }

    fn visit_impl_item_fn(&mut self, function: &'ast syn::ImplItemFn) {
        if function.sig.constness.is_none() && !for_tests(&function.attrs) {
            self.body(&function.sig.ident, &function.sig.output, &function.block);
            self.visit_block(&function.block);
        }
    }

    fn visit_impl_item_const(&mut self, _: &'ast syn::ImplItemConst) {}

    fn visit_trait_item_const(&mut self, _: &'ast syn::TraitItemConst) {}

    fn visit_pat(&mut self, _: &'ast syn::Pat) {}

    fn visit_type(&mut self, _: &'ast syn::Type) {}

    fn visit_generic_argument(&mut self, _: &'ast syn::GenericArgument) {}

    fn visit_expr_const(&mut self, _: &'ast syn::ExprConst) {}

    fn visit_expr_repeat(&mut self, repeat: &'ast syn::ExprRepeat) {
        self.visit_expr(&repeat.expr);
    }

    fn visit_stmt(&mut self, statement: &'ast Stmt) {
        if let Stmt::Expr(Expr::Return(answer), Some(_)) = statement {
            let bytes = statement.span().byte_range();
            let what = format!("`{}` is dropped", &self.text[answer.span().byte_range()]);
            self.add(bytes, what, Vec::new());
        }
        visit::visit_stmt(self, statement);
    }

    fn visit_expr(&mut self, whole: &'ast Expr) {
        match whole {
            Expr::Binary(binary) => self.binary(whole, binary),
            Expr::Unary(unary) if !matches!(unary.op, UnOp::Deref(_)) => {
                self.replace(whole, unary.op.span().byte_range(), "");
            }
            Expr::Lit(literal) => self.literal(whole, &literal.lit),
            Expr::Range(range) => {
                if let (syn::RangeLimits::HalfOpen(_), Some(end)) = (&range.limits, &range.end) {
                    let bytes = end.span().byte_range();
                    let what = format!("`..{}` becomes `..=`", &self.text[bytes.clone()]);
                    let one_more = vec![
                        Piece::Words("(".to_string()),
                        Piece::Same(bytes.clone()),
                        Piece::Words(") + 1".to_string()),
                    ];
                    self.add(bytes, what, one_more);
                }
            }
            Expr::MethodCall(call) if call.args.len() == 1 => {
                let other = match call.method.to_string().as_str() {
                    "min" => Some("max"),
                    "max" => Some("min"),
                    "any" => Some("all"),
                    "all" => Some("any"),
                    _ => None,
                };
                if let Some(other) = other {
                    self.replace(whole, call.method.span().byte_range(), other);
                }
            }
            _ => {}
        }
        visit::visit_expr(self, whole);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The changed texts, one for each place alone.
    fn changed(text: &str) -> Vec<String> {
        let found = places(text).unwrap();
        let one = |place: &Place| {
            let words: String = place
                .changed
                .iter()
                .map(|piece| match piece {
                    Piece::Same(bytes) => &text[bytes.clone()],
                    Piece::Words(words) => words,
                })
                .collect();
            let Bytes { start, end } = place.bytes;
            format!("{}{words}{}", &text[..start], &text[end..])
        };
        found.iter().map(one).collect()
    }

    #[test]
    fn every_kind_of_place_is_found_and_constants_are_left_alone() {
        let text = "const N: usize = 3 + 4;\nfn f(a: f64) -> f64 { -a * a.min(N as f64) }";
        let body = |body: &str| text.replace("-a * a.min(N as f64)", body);
        let early = |value: &str| text.replace("{ -", &format!("{{return {value}; -"));
        assert_eq!(
            changed(text),
            [
                early("0.0"),
                early("1.0"),
                body("-a / a.min(N as f64)"),
                body("a * a.min(N as f64)"),
                body("-a * a.max(N as f64)"),
            ]
        );
    }

    #[test]
    fn a_range_reaches_one_further_and_a_condition_that_binds_is_left_alone() {
        let text = "fn f() { for _ in a..b { if let Some(x) = y && x { return; } } }";
        let [nothing, further, on] = changed(text).try_into().unwrap();
        assert!(nothing.starts_with("fn f() {return ; for"));
        assert!(further.contains("a..(b) + 1 {"));
        assert!(on.contains("&& x {  }"));
    }
}
