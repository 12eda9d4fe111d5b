//! The HTML of the pages: their frame, figures, banners and tables.

use crate::output::markup::{Markup, markup};
use crate::output::scene::{PHONE, WIDTH};
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use sha2::{Digest, Sha256};

/// The only script of all pages: it turns the view of a model in space.
const SCRIPT: &str = concat!("\n", include_str!("space/turning.js"));

/// Most rows of a table that no page of paper divides.
const SHORT: usize = 16;

/// The element of the script.
pub fn script() -> Markup {
    markup!("<script>{}</script>\n", Markup::own(SCRIPT))
}

/// A complete page. It tells the browser to load nothing from elsewhere, and to run no script but ours.
pub fn page(title: &str, intro: &Markup, body: &Markup, footer: &str) -> Markup {
    markup!(
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
         <meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'; style-src 'unsafe-inline'; \
         img-src data:; script-src 'sha256-{0}'; base-uri 'none'; form-action 'none'\">\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n<title>{1}</title>\n\
         <style>\n{2}</style>\n</head>\n<body>\n<main>\n<h1>{1}</h1>\n{3}{4}\
         <footer>{5}</footer>\n</main>\n</body>\n</html>\n",
        STANDARD.encode(Sha256::digest(SCRIPT)),
        title,
        Markup::own(include_str!("report.css")),
        intro,
        body,
        footer,
    )
}

/// A banner; `class` is `good`, `warn` or `bad`.
pub fn banner(class: &str, title: &str, body: &Markup) -> Markup {
    markup!(
        "<div class=\"banner {}\"><b>{}</b>{}</div>\n",
        class,
        title,
        body
    )
}

/// A drawing of one width, with title and caption: on a phone it scrolls.
pub fn figure(svg: &Markup, title: &str, caption: &str) -> Markup {
    markup!(
        "<figure>\n<div class=\"scroll\">{}</div>\n<figcaption><b>{}.</b> {}</figcaption>\n</figure>\n",
        svg,
        title,
        caption
    )
    .titled(title)
}

/// A drawing that `draw` lays out for a width, with title and caption: the page shows that for pages or that for phones.
pub fn fitted(draw: &dyn Fn(f64) -> Markup, title: &str, caption: &str) -> Markup {
    markup!(
        "<figure>\n<div class=\"wide\">{}</div>\n<div class=\"phone\">{}</div>\n<figcaption><b>{}.</b> {}</figcaption>\n</figure>\n",
        draw(WIDTH),
        draw(PHONE),
        title,
        caption
    )
    .titled(title)
}

/// Head of a table column.
pub struct Head {
    name: String,
    unit: String,
    left: bool,
}

/// Head of a column of numbers.
pub fn column(name: &str, unit: &str) -> Head {
    Head {
        name: name.to_string(),
        unit: unit.to_string(),
        left: false,
    }
}

/// Head of a column of words.
pub fn left(name: &str) -> Head {
    Head {
        left: true,
        ..column(name, "")
    }
}

/// Content of a table cell.
pub struct Entry {
    content: Markup,
    words: bool,
}

/// A cell with a number.
pub fn plain(text: String) -> Entry {
    marked(markup!("{}", text))
}

/// A cell with words.
pub fn text(text: &str) -> Entry {
    described(markup!("{}", text))
}

/// A cell of markup.
pub fn marked(content: Markup) -> Entry {
    Entry {
        content,
        words: false,
    }
}

/// A cell of markup that reads as words.
pub fn described(content: Markup) -> Entry {
    Entry {
        content,
        words: true,
    }
}

/// A table that scrolls if it is too wide.
pub fn table(heads: &[Head], rows: Vec<Vec<Entry>>) -> Markup {
    let class = |words: bool| match words {
        true => markup!(" class=\"text\""),
        false => Markup::default(),
    };
    let head = |head: &Head| {
        let unit = match head.unit.as_str() {
            "" => Markup::default(),
            unit => markup!("<small>{}</small>", unit),
        };
        markup!("<th{}>{}{}</th>", class(head.left), head.name, unit)
    };
    let cell = |cell: Entry| markup!("<td{}>{}</td>", class(cell.words), cell.content);
    // one that is short stays whole on paper
    let short = match rows.len() <= SHORT {
        true => markup!(" short"),
        false => Markup::default(),
    };
    let row = |row: Vec<Entry>| {
        let cells: Markup = row.into_iter().map(cell).collect();
        markup!("<tr>{}</tr>\n", cells)
    };
    markup!(
        "<div class=\"scroll{}\"><table>\n<thead><tr>{}</tr></thead>\n<tbody>\n{}</tbody></table></div>\n",
        short,
        heads.iter().map(head).collect::<Markup>(),
        rows.into_iter().map(row).collect::<Markup>()
    )
}

/// A table of vectors, which may take several lines each.
pub fn table_of_vectors(heads: &[Head], rows: Vec<Vec<Entry>>) -> Markup {
    markup!("<div class=\"tight\">\n{}</div>\n", table(heads, rows))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_page_has_a_drawing_for_phones_and_a_figure_alone_has_not() {
        let draw = |width: f64| markup!("<svg width=\"{}\"></svg>\n", width);
        let page = markup!("<p/>") + fitted(&draw, "one", "words") + fitted(&draw, "two", "more");
        for width in [WIDTH, PHONE] {
            assert_eq!(page.matches(&format!("<svg width=\"{width}\">")).count(), 2);
        }
        for (title, figure) in page.figures() {
            assert_eq!(figure.matches("<svg").count(), 1, "{title}");
            assert!(figure.contains(&format!("<svg width=\"{WIDTH}\">")));
            assert!(figure.ends_with("</figcaption>\n</figure>\n") && !figure.contains("phone"));
        }
    }

    #[test]
    fn figures_are_known_with_their_titles() {
        let titles = ["a < b & 'c'", "&lt;"];
        let drawn = titles.map(|title| figure(&markup!("<svg></svg>\n"), title, "more.</b>"));
        let [first, second] = drawn.clone();
        let mut page = markup!("<p>{}</p>\n", "ø") + first;
        page += [markup!("<h2/>"), second].into_iter().collect();
        let expected = titles.map(String::from).into_iter();
        let expected = expected.zip(drawn.map(Markup::into_string));
        assert_eq!(page.figures(), expected.collect::<Vec<_>>());
    }
}
