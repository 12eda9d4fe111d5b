//! The HTML of the pages: escaping, the frame of a page, figures, banners and tables.

/// Text that is safe inside HTML, XML and their attributes.
pub fn escape(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => out.push_str("&amp;"),
            '<' => out.push_str("&lt;"),
            '>' => out.push_str("&gt;"),
            '"' => out.push_str("&quot;"),
            '\'' => out.push_str("&#39;"),
            // XML has no place for control characters.
            c if c.is_control() && c != '\n' && c != '\t' => out.push('\u{fffd}'),
            c => out.push(c),
        }
    }
    out
}

/// A page of its own, which needs no network; title escaped, `intro` and `body` are markup, `footer` text.
pub fn page(title: &str, intro: &str, body: &str, footer: &str) -> String {
    format!(
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n<title>{title}</title>\n\
         <style>\n{css}</style>\n</head>\n<body>\n<main>\n<h1>{title}</h1>\n{intro}{body}\
         <footer>{footer}</footer>\n</main>\n</body>\n</html>\n",
        title = escape(title),
        css = include_str!("report.css"),
        footer = escape(footer),
    )
}

/// A box that is seen first; `class` is `good`, `warn` or `bad`, `body` is markup.
pub fn banner(class: &str, title: &str, body: &str) -> String {
    format!("<div class=\"banner {class}\"><b>{title}</b>{body}</div>\n")
}

/// A drawing with what it shows.
pub fn figure(svg: &str, title: &str, caption: &str) -> String {
    format!(
        "<figure>\n{svg}<figcaption><b>{}.</b> {}</figcaption>\n</figure>\n",
        escape(title),
        escape(caption)
    )
}

/// The figures in this markup of ours, which do not nest: the title of each, as text, and all of its markup.
pub fn figures(markup: &str) -> Vec<(String, String)> {
    let begun = markup.match_indices("<figure").filter(|(at, begin)| {
        let next = markup[at + begin.len()..].chars().next();
        next == Some('>') || next == Some(' ')
    });
    let whole = begun.filter_map(|(at, _)| {
        const END: &str = "</figure>\n";
        let end = markup[at..].find(END)? + END.len();
        Some(&markup[at..at + end])
    });
    let titled = whole.filter_map(|figure| {
        let (_, rest) = figure.split_once("<figcaption><b>")?;
        let (title, _) = rest.split_once(".</b>")?;
        Some((unescape(title), figure.to_string()))
    });
    titled.collect()
}

/// The text that was escaped.
fn unescape(markup: &str) -> String {
    let plain = markup.replace("&lt;", "<").replace("&gt;", ">");
    let plain = plain.replace("&quot;", "\"").replace("&#39;", "'");
    plain.replace("&amp;", "&")
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

/// Content of a table cell, already escaped.
pub struct Entry {
    html: String,
    text: bool,
}

/// A cell with a number.
pub fn plain(text: String) -> Entry {
    marked(escape(&text))
}

/// A cell with words.
pub fn text(text: &str) -> Entry {
    described(escape(text))
}

/// A cell of markup.
pub fn marked(html: String) -> Entry {
    Entry { html, text: false }
}

/// A cell of markup that reads as words.
pub fn described(html: String) -> Entry {
    Entry { html, text: true }
}

/// A table that scrolls where it is too wide.
pub fn table(heads: &[Head], rows: Vec<Vec<Entry>>) -> String {
    let class = |is_text: bool| if is_text { " class=\"text\"" } else { "" };
    let mut out = String::from("<div class=\"scroll\"><table>\n<thead><tr>");
    for head in heads {
        let unit = if head.unit.is_empty() {
            String::new()
        } else {
            format!("<small>{}</small>", escape(&head.unit))
        };
        out += &format!("<th{}>{}{unit}</th>", class(head.left), escape(&head.name));
    }
    out += "</tr></thead>\n<tbody>\n";
    for row in rows {
        out += "<tr>";
        for cell in row {
            out += &format!("<td{}>{}</td>", class(cell.text), cell.html);
        }
        out += "</tr>\n";
    }
    out + "</tbody></table></div>\n"
}

/// A table of vectors, which may take several lines each.
pub fn table_of_vectors(heads: &[Head], rows: Vec<Vec<Entry>>) -> String {
    format!("<div class=\"tight\">\n{}</div>\n", table(heads, rows))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn markup_is_escaped() {
        assert_eq!(
            escape("a<b & \"c\"\u{1}"),
            "a&lt;b &amp; &quot;c&quot;\u{fffd}"
        );
    }

    #[test]
    fn figures_are_found_with_their_titles() {
        let titles = ["a < b & 'c'", "&lt;"];
        let drawn = titles.map(|title| figure("<svg></svg>\n", title, "more.</b>"));
        let page = format!("<p>{}</p>\n{}<h2/>", drawn[0], drawn[1]);
        let found = figures(&page);
        let expected = titles.map(String::from).into_iter().zip(drawn);
        assert_eq!(found, expected.collect::<Vec<_>>());
        assert!(
            figures("<figcaption><b>a.</b></figcaption> <figure> <figure></figure>\n").is_empty()
        );
    }
}
