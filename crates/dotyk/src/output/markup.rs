//! Markup, HTML, SVG or XML, into which no text gets unescaped.
//!
//! Cases come from strangers: their names are shown on a page, but must never act as markup. [`Markup`] comes only from
//! templates, [`markup!`], which escape all parts that are not markup, so that an escape cannot be forgotten.

use std::fmt::{self, Display, Write};
use std::ops::{Add, AddAssign, Deref, Range};

/// Markup of this program. It can be read as text, but no text becomes markup unescaped, and it cannot be formatted into text.
///
/// It knows the figures among its parts as long as these are added; what fills a template becomes a part of one text.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Markup {
    text: String,
    /// Title of each, and where it stands.
    figures: Vec<(String, Range<usize>)>,
}

/// Markup from a template: a literal with `{}` for each part, which is escaped if it is not markup.
macro_rules! markup {
    ($template:literal $(, $part:expr)* $(,)?) => {
        // The result of `concat!` captures no variables: parts stand behind the template, where they are escaped.
        $crate::output::markup::Markup::filled(format_args!(
            concat!($template, "") $(, $crate::output::markup::Escaped(&$part))*
        ))
    };
}
pub(crate) use markup;

impl Markup {
    /// A template with its parts; for [`markup!`] alone.
    pub fn filled(template: fmt::Arguments<'_>) -> Self {
        Self::from(template.to_string())
    }

    fn from(text: String) -> Self {
        Self {
            text,
            figures: Vec::new(),
        }
    }

    /// All of it as a figure with this title.
    pub fn titled(self, title: &str) -> Self {
        let whole = 0..self.text.len();
        Self {
            figures: vec![(title.to_string(), whole)],
            ..self
        }
    }

    /// Its figures in their order, which do not nest: title and markup of each, without the drawing for phones, which only a page
    /// can choose.
    pub fn figures(&self) -> Vec<(String, String)> {
        let figures = self.figures.iter();
        figures
            .map(|(title, at)| (title.clone(), without_phones(&self.text[at.clone()])))
            .collect()
    }

    /// Markup, style or script from the program itself.
    pub fn own(text: &'static str) -> Self {
        Self::from(text.to_string())
    }

    /// Data for the inside of a script element, which no text of it can end.
    pub fn json(data: &serde_json::Value) -> Self {
        let data = data.to_string().replace('<', "\\u003c");
        Self::from(data.replace('>', "\\u003e"))
    }

    /// The markup as text, to be written into a file.
    pub fn into_string(self) -> String {
        self.text
    }
}

/// Markup without the parts of this class, in which there are no other parts.
fn without_phones(text: &str) -> String {
    let (start, end) = ("<div class=\"phone\">", "</div>\n");
    let mut parts = text.split(start);
    let first = parts.next().unwrap_or_default().to_string();
    let rests = parts.map(|part| part.split_once(end).map_or("", |(_, rest)| rest));
    rests.fold(first, |text, rest| text + rest)
}

impl Deref for Markup {
    type Target = str;

    fn deref(&self) -> &str {
        &self.text
    }
}

impl AddAssign for Markup {
    fn add_assign(&mut self, more: Self) {
        let before = self.text.len();
        self.text += &more.text;
        let figures = more.figures.into_iter();
        self.figures
            .extend(figures.map(|(title, at)| (title, before + at.start..before + at.end)));
    }
}

impl Add for Markup {
    type Output = Self;

    fn add(mut self, more: Self) -> Self {
        self += more;
        self
    }
}

impl FromIterator<Self> for Markup {
    fn from_iter<I: IntoIterator<Item = Self>>(parts: I) -> Self {
        parts.into_iter().fold(Self::default(), Self::add)
    }
}

/// A part of a template.
pub trait Part {
    /// Writes markup as it is, all else escaped.
    fn put(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result;
}

impl Part for Markup {
    fn put(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        out.write_str(self)
    }
}

impl Part for &Markup {
    fn put(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        out.write_str(self)
    }
}

impl<T: Display + ?Sized> Part for T {
    fn put(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(Escaping(out), "{self}")
    }
}

/// A part in its template.
pub struct Escaped<'a, P: ?Sized>(pub &'a P);

impl<P: Part + ?Sized> Display for Escaped<'_, P> {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.put(out)
    }
}

/// Escapes the text written to it.
struct Escaping<'a, 'f>(&'a mut fmt::Formatter<'f>);

impl Write for Escaping<'_, '_> {
    fn write_str(&mut self, text: &str) -> fmt::Result {
        let mut written = 0;
        for (at, c) in text.char_indices() {
            let Some(escaped) = escaped(c) else { continue };
            self.0.write_str(&text[written..at])?;
            self.0.write_str(escaped)?;
            written = at + c.len_utf8();
        }
        self.0.write_str(&text[written..])
    }
}

/// The escape of a character inside HTML, XML and their attributes; `None` if the character needs none.
fn escaped(c: char) -> Option<&'static str> {
    match c {
        '&' => Some("&amp;"),
        '<' => Some("&lt;"),
        '>' => Some("&gt;"),
        '"' => Some("&quot;"),
        '\'' => Some("&#39;"),
        // XML has no place for control characters
        c if c.is_control() && c != '\n' && c != '\t' => Some("\u{fffd}"),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn texts_are_escaped_and_markup_is_not() {
        let text = "a<b & \"c\" 'd'\u{1}";
        let once = markup!("<p>{}</p>", text);
        let escaped = "a&lt;b &amp; &quot;c&quot; &#39;d&#39;\u{fffd}";
        assert_eq!(*once, *format!("<p>{escaped}</p>"));
        let both = markup!("<i title=\"{1}\">{0} {2}</i>", once, text, 3);
        assert_eq!(
            *both,
            *format!("<i title=\"{escaped}\"><p>{escaped}</p> 3</i>")
        );
        let list: Markup = [&once, &both].map(Clone::clone).into_iter().collect();
        assert_eq!(list, once + both);
    }

    #[test]
    fn data_do_not_end_their_script() {
        let data = serde_json::json!({ "name": "</script><!--" });
        let written = Markup::json(&data);
        assert!(!written.contains(['<', '>']));
        assert_eq!(
            serde_json::from_str::<serde_json::Value>(&written).ok(),
            Some(data)
        );
    }
}
