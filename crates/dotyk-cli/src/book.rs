//! `dotyk verify --book`: the results as pages of Markdown, one for each folder of cases, and a table of all folders.
//!
//! A folder of the book has the name of the folder of the cases; it holds the page `index.md` with its pictures and copies of
//! the case files, and appears whole or not at all. Pages contain no times: the same program writes the same bytes.

use crate::failure::Failure;
use crate::text::number;
use crate::verify::{Folder, Judged, Solved, Tally};
use dotyk::dual::Certificate;
use dotyk::model::check_file_names;
use dotyk::output::{self, Stage};
use std::collections::HashSet;
use std::fmt::Write;
use std::path::Path;

/// Name of the page of a folder, and of the table of all folders.
const PAGE: &str = "index.md";

/// The text of a folder, with which its page begins.
const README: &str = "README.md";

/// Titles of figures of the report that no page shows: the first describes the solver, the others are animated.
const LEFT_OUT: [&str; 3] = [
    "Convergence",
    "View that turns",
    "Deformed shape over the load steps",
];

/// A picture of a page.
pub struct Picture {
    title: String,
    /// The caption as it stands in HTML, without the title.
    caption: String,
    svg: String,
}

impl Picture {
    /// The drawing of a figure of the report; `None` for one that no page shows.
    pub fn of((title, html): (String, String)) -> Option<Self> {
        let (begin, end) = (html.find("<svg")?, html.rfind("</svg>")?);
        let (_, caption) = html.split_once(".</b>")?;
        let (caption, _) = caption.split_once("</figcaption>")?;
        (!LEFT_OUT.contains(&title.as_str())).then(|| Self {
            caption: caption.trim().to_string(),
            svg: html[begin..end].to_string() + "</svg>\n",
            title,
        })
    }
}

/// The results of a folder.
pub struct Found<'a> {
    pub folder: &'a Folder,
    /// In the order of the cases; `None` where a case was refused.
    pub solved: &'a [Option<Solved>],
    pub judged: &'a [Judged<'a>],
    pub tally: &'a Tally,
}

/// A book during writing.
pub struct Book {
    stage: Stage,
    /// Names of all folders that the book will have.
    names: Vec<String>,
    /// Rows of the table of all folders.
    rows: Vec<String>,
}

impl Book {
    /// A book with a page for each of these folders; its files become visible when it is closed.
    pub fn new(dir: &Path, folders: &[Folder]) -> Result<Self, Failure> {
        let names = names_of(folders)?;
        let cases = folders.iter().flat_map(|folder| &folder.cases);
        let mut all = names.iter().chain(cases.map(|(name, _)| name));
        if let Some(name) = all.find(|name| !name.chars().all(is_plain)) {
            let message = format!(
                "`{name}` cannot name a page or a file of the book: rename it, with letters, digits, `-`, `_` and `.` only"
            );
            return Err(Failure::Message(message));
        }
        let stage = output::Folder::hold(dir).and_then(|folder| Stage::open(&folder));
        Ok(Self {
            stage: stage.map_err(of_book)?,
            names,
            rows: Vec::new(),
        })
    }

    /// Writes the page of the next folder.
    pub fn put(&mut self, found: &Found<'_>) -> Result<(), Failure> {
        let name = &self.names[self.rows.len()];
        let folder = &found.folder.path;
        let problem = Problem::read(folder, name)?;
        let statement = linked(&self.names, &problem, folder);
        let mut files = Vec::new();
        for file in copied(found.folder, &problem.text) {
            let bytes = std::fs::read(folder.join(&file));
            files.push((file, bytes.map_err(|e| Failure::of(folder, e))?));
        }
        let page = page([&problem.title, &statement, name], found, &mut files);
        files.push((PAGE.to_string(), page.into_bytes()));
        for (file, bytes) in files {
            let put = self.stage.put(&format!("{name}/{file}"), &bytes);
            put.map_err(of_book)?;
        }
        self.rows.push(row(&problem.title, name, found.tally));
        Ok(())
    }

    /// Writes the table of all folders; `summary` holds the totals over all of them.
    pub fn close(mut self, summary: &str) -> Result<(), Failure> {
        let mut page = format!("# Verification\n\n{}\n\n", begun(summary));
        page += "Each folder of cases is an example, an input file and a test. Its page has the problem, pictures, every \
                 reference value with its source and its verdict, and the certificate of each answer.\n\n\
                 | Problem | Folder | Cases | Certified | Within | Outside | Outside, known | Not judged |\n\
                 |---|---|---:|---:|---:|---:|---:|---:|\n";
        page += &self.rows.concat();
        page += "\n```{toctree}\n:hidden:\n\n";
        for name in &self.names {
            page += &format!("{name}/index\n");
        }
        page += "```\n";
        let put = self.stage.put(PAGE, page.as_bytes());
        let written = put.and_then(|()| self.stage.commit(&[]));
        written.map(drop).map_err(of_book)
    }
}

/// The statement of a problem with links that lead somewhere in the book; other links become their words.
fn linked(names: &[String], problem: &Problem, folder: &Path) -> String {
    let (mut out, mut rest) = (String::new(), problem.text.as_str());
    while let Some(link) = Link::first(rest) {
        out += &rest[..link.begin];
        let target = self::target(names, link.target, folder);
        out += &match target {
            Some(target) => format!("[{}]({target})", link.words),
            None => link.words.to_string(),
        };
        rest = &rest[link.end..];
    }
    out + rest
}

/// The target in the book of a link in a folder's text.
fn target(names: &[String], target: &str, folder: &Path) -> Option<String> {
    if ["https://", "http://", "#"]
        .iter()
        .any(|begin| target.starts_with(begin))
    {
        return Some(target.to_string());
    }
    if folder.join(target).is_file() {
        return (!target.contains('/')).then(|| target.to_string());
    }
    let name = target.strip_prefix("../")?.trim_end_matches('/');
    let known = names.iter().any(|known| known == name);
    known.then(|| format!("../{name}/{PAGE}"))
}

/// The case whose pictures stand on the page: the one that the text of the folder names first, else the first.
pub fn pictured(folder: &Folder) -> Option<String> {
    let text = std::fs::read_to_string(folder.path.join(README)).unwrap_or_default();
    let names = folder.cases.iter().map(|(name, _)| name);
    let first = names.min_by_key(|name| text.find(name.as_str()).unwrap_or(usize::MAX));
    first.cloned()
}

/// A character without a special meaning in names of files, links, Markdown and HTML.
fn is_plain(c: char) -> bool {
    c.is_alphanumeric() || "-_.".contains(c)
}

/// Names of output folders, one for each folder: they stay distinct on every system.
pub fn names_of(folders: &[Folder]) -> Result<Vec<String>, Failure> {
    let names = folders.iter().map(|folder| name_of(&folder.path));
    let names = names.collect::<Result<Vec<_>, _>>()?;
    let mut seen = HashSet::new();
    if let Some(twice) = names.iter().find(|name| !seen.insert(name.as_str())) {
        let message = format!(
            "two folders are called {twice}, and each needs a folder of its own for what is written"
        );
        return Err(Failure::Message(message));
    }
    let checked = check_file_names(names.iter().map(String::as_str));
    checked.map_err(|error| Failure::Message(format!("folder `{}`: {error}", error.name())))?;
    Ok(names)
}

/// The name of a folder, whatever path it was given by.
pub fn name_of(path: &Path) -> Result<String, Failure> {
    let whole = path.canonicalize().map_err(|e| Failure::of(path, e))?;
    let name = whole.file_name().unwrap_or_default();
    Ok(name.to_string_lossy().into_owned())
}

/// Title and statement of the problem of a folder.
struct Problem {
    title: String,
    /// Markdown without the title.
    text: String,
}

impl Problem {
    /// Reads the text of a folder; without one the title is the name of the folder.
    fn read(folder: &Path, name: &str) -> Result<Self, Failure> {
        let path = folder.join(README);
        if !path.exists() {
            return Ok(Self {
                title: name.to_string(),
                text: String::new(),
            });
        }
        let text = std::fs::read_to_string(&path).map_err(|e| Failure::of(&path, e))?;
        let (first, rest) = text.split_once('\n').unwrap_or((&text, ""));
        Ok(match first.strip_prefix("# ") {
            Some(title) => Self {
                title: title.to_string(),
                text: plain(rest.trim()),
            },
            None => Self {
                title: name.to_string(),
                text: plain(&text),
            },
        })
    }
}

/// Markdown that only sets words: the opening signs of HTML elements, directives and roles are broken, so that generators of
/// books do not execute them. Addresses in angle brackets stay.
fn plain(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for (at, c) in text.char_indices() {
        let rest = &text[at + c.len_utf8()..];
        let next = rest.chars().next().unwrap_or(' ');
        let address = ["http://", "https://"].iter().any(|a| rest.starts_with(a));
        out.push(c);
        match c {
            '<' if !address && (next.is_ascii_alphabetic() || "/!?".contains(next)) => {
                out.push(' ')
            }
            '}' if next == '`' => out.push(' '),
            '`' | '~' | ':'
                if opens(&out, c) && rest.trim_start_matches([' ', '\t']).starts_with('{') =>
            {
                out.push_str(" text ");
            }
            _ => (),
        }
    }
    out
}

/// Whether a text ends with a fence (three or more) of this character.
fn opens(text: &str, fence: char) -> bool {
    text.chars().rev().take_while(|c| *c == fence).count() >= 3
}

/// A link of Markdown, `[words](target)`.
struct Link<'a> {
    begin: usize,
    end: usize,
    words: &'a str,
    target: &'a str,
}

impl<'a> Link<'a> {
    fn first(text: &'a str) -> Option<Self> {
        let middle = text.find("](")?;
        let begin = text[..middle].rfind('[')?;
        let length = text[middle..].find(')')?;
        Some(Self {
            begin,
            end: middle + length + 1,
            words: &text[begin + 1..middle],
            target: &text[middle + 2..middle + length],
        })
    }
}

/// Files of a folder that stand beside its page: its cases, and the files that its text links to.
fn copied(folder: &Folder, text: &str) -> Vec<String> {
    let mut files: Vec<String> = folder.cases.iter().map(|(name, _)| name.clone()).collect();
    let mut rest = text;
    while let Some(link) = Link::first(rest) {
        let known = files.iter().any(|file| file == link.target);
        if !known && !link.target.contains('/') && folder.path.join(link.target).is_file() {
            files.push(link.target.to_string());
        }
        rest = &rest[link.end..];
    }
    files
}

/// The page of a folder; its pictures are added to its files.
fn page(
    [title, statement, name]: [&str; 3],
    found: &Found<'_>,
    files: &mut Vec<(String, Vec<u8>)>,
) -> String {
    let mut page = format!("# {}\n\n{statement}\n\n", begun(title));
    let cases = found.folder.cases.iter().map(|(name, _)| name);
    for (case, solved) in cases.clone().zip(found.solved) {
        let pictures = solved.iter().flat_map(|solved| &solved.pictures);
        page += &pictures_of(case, pictures, files);
    }
    page += &references(found.judged);
    page += &certificates(found);
    page += &format!(
        "## Case files\n\n{}\n{}\n",
        fenced("", &format!("dotyk verify cases/{name}")),
        cases
            .clone()
            .map(|case| format!("* [{}]({case})\n", escaped(case)))
            .collect::<String>()
    );
    let shown = pictured(found.folder);
    let text = shown.and_then(|case| {
        let (_, bytes) = files.iter().find(|(file, _)| *file == case)?;
        Some((case, String::from_utf8_lossy(bytes).into_owned()))
    });
    if let Some((case, text)) = text {
        page += &format!(
            "<details><summary>{case}</summary>\n\n{}\n</details>\n",
            fenced("toml", text.trim_end())
        );
    }
    page
}

/// The pictures of a case, which become files.
fn pictures_of<'p>(
    case: &str,
    pictures: impl Iterator<Item = &'p Picture>,
    files: &mut Vec<(String, Vec<u8>)>,
) -> String {
    let stem = case.trim_end_matches(".toml");
    let mut text = String::new();
    for (number, picture) in (1..).zip(pictures) {
        if number == 1 {
            text += &format!("## Pictures of {}\n\n", escaped(case));
        }
        let file = format!("{stem}_{number}.svg");
        let title = escaped(&picture.title);
        let caption = shielded(&picture.caption);
        text += &format!("![{title}]({file})\n\n**{title}.** {caption}\n\n");
        files.push((file, picture.svg.clone().into_bytes()));
    }
    text
}

/// Reference values with their verdicts, and below them their sources.
fn references(judged: &[Judged<'_>]) -> String {
    if judged.is_empty() {
        return String::new();
    }
    let mut text = "## Reference values\n\n\
                    | Case | Value | Kind | Reference | Computed | Difference | Verdict | Source |\n\
                    |---|---|---|---:|---:|---:|---|---:|\n"
        .to_string();
    let mut sources: Vec<(&str, &str)> = Vec::new();
    for value in judged {
        let reference = value.reference;
        let source = (reference.source.as_str(), reference.reason.as_str());
        let known = sources.iter().position(|known| *known == source);
        let place = known.unwrap_or(sources.len());
        if known.is_none() {
            sources.push(source);
        }
        let cells = value.row().map(|cell| escaped(&cell));
        text += &format!("| {} | {} |\n", cells.join(" | "), place + 1);
    }
    text += "\n";
    for (number, (source, reason)) in (1..).zip(sources) {
        let source = match source {
            "" => "an earlier result of this program",
            source => source,
        };
        text += &format!("{number}. {}", begun(source));
        if !reason.is_empty() {
            text += &format!("; band: {}", escaped(reason));
        }
        text += "\n";
    }
    text + "\n"
}

/// The certificate of each case: the largest figures over its load steps beside their limits.
fn certificates(found: &Found<'_>) -> String {
    let solved = found.solved.iter().flatten();
    let all = solved.flat_map(|solved| solved.steps.iter());
    // bodies that yield have more figures than others
    let names = all
        .map(|step| step.certificate.figures())
        .max_by_key(Vec::len)
        .unwrap_or_default();
    let names: Vec<&str> = names.into_iter().map(|(name, _)| name).collect();
    let mut text = format!(
        "## Certificates\n\nThe largest figure of all load steps, relative to its scale; in the last line its limit.\n\n\
         | Case | Steps | {} |\n|---|---:|{}\n",
        names.join(" | ").replace('_', " "),
        "---:|".repeat(names.len())
    );
    let mut limits = vec![f64::NAN; names.len()];
    for ((case, _), solved) in found.folder.cases.iter().zip(found.solved) {
        let Some(solved) = solved else {
            let _ = writeln!(
                text,
                "| {} | refused |{}",
                escaped(case),
                " |".repeat(names.len())
            );
            continue;
        };
        let certificates = || solved.steps.iter().map(|step| &step.certificate);
        let figures = names.iter().zip(&mut limits).map(|(name, limit)| {
            let Some((relative, own)) = worst(certificates(), name) else {
                return String::new();
            };
            *limit = own;
            match relative <= own {
                true => short(relative),
                false => format!("**{}**", short(relative)),
            }
        });
        let figures: Vec<String> = figures.collect();
        text += &format!(
            "| {} | {} | {} |\n",
            escaped(case),
            solved.steps.len(),
            figures.join(" | ")
        );
    }
    if limits.iter().any(|limit| !limit.is_nan()) {
        let limits: Vec<String> = limits.into_iter().map(short).collect();
        text += &format!("| limit | | {} |\n", limits.join(" | "));
    }
    text + "\n"
}

/// A figure of a certificate.
fn short(value: f64) -> String {
    match value {
        0.0 => "0".to_string(),
        value => format!("{value:.1e}"),
    }
}

/// The largest relative figure of a name, and its limit; `None` where no certificate has it.
fn worst<'c>(
    certificates: impl Iterator<Item = &'c Certificate>,
    name: &str,
) -> Option<(f64, f64)> {
    let figures = certificates.flat_map(Certificate::figures);
    let own = figures.filter(|(known, _)| *known == name);
    own.map(|(_, figure)| (figure.relative, figure.limit))
        // NaN counts as the worst value
        .reduce(|most, own| match own.0.is_nan() || own.0 > most.0 {
            true => own,
            false => most,
        })
}

/// The line of a folder in the table of all.
fn row(title: &str, name: &str, tally: &Tally) -> String {
    let counts = [
        tally.cases,
        tally.certified,
        tally.within,
        tally.outside,
        tally.known,
        tally.shown,
    ];
    let counts = counts.map(|count| number(count as f64));
    format!(
        "| [{}]({name}/{PAGE}) | `{name}` | {} |\n",
        escaped(title),
        counts.join(" | ")
    )
}

/// Words escaped for a line or table of Markdown: nothing in them is markup, HTML, a formula, a role or an entity.
fn escaped(words: &str) -> String {
    shielded(&words.replace('&', "&amp;"))
}

/// Words in which entities of HTML keep their meaning and all other characters stand for themselves.
fn shielded(words: &str) -> String {
    let mut out = String::with_capacity(words.len());
    for c in words.chars() {
        if "\\`*_[]|<>$~{}".contains(c) {
            out.push('\\');
        }
        out.push(if c.is_control() { ' ' } else { c });
    }
    out
}

/// Files that could not be written.
fn of_book(error: output::Error) -> Failure {
    Failure::of_files(&error, "--book")
}

/// Words escaped for the beginning of a block: they start no heading, list, directive, comment or target.
fn begun(words: &str) -> String {
    let mut out = escaped(words.trim());
    let number = out.len() - out.trim_start_matches(|c: char| c.is_ascii_digit()).len();
    let sign = |c: char| c.is_ascii_punctuation() && !"\\&".contains(c);
    if out[number..].starts_with(sign) {
        out.insert(number, '\\');
    }
    out
}

/// A block of code: its fence is longer than every run of backquotes in the text, so that only the fence ends it.
fn fenced(language: &str, text: &str) -> String {
    let longest = text.split(|c| c != '`').map(str::len).max();
    let fence = "`".repeat(3.max(longest.unwrap_or(0) + 1));
    format!("{fence}{language}\n{text}\n{fence}\n")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn links_lead_to_pages_and_files_or_become_words() {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
        let names = ["other".to_string()];
        let problem = Problem {
            title: String::new(),
            text: "[a](../other), [b](main.rs), [c](../else), [d](https://dml.cz/1) [e], [f](javascript://x)"
                .to_string(),
        };
        let expected = "[a](../other/index.md), [b](main.rs), c, [d](https://dml.cz/1) [e], f";
        assert_eq!(linked(&names, &problem, &folder), expected);
    }

    #[test]
    fn texts_of_folders_set_words_and_nothing_else() {
        let cases = [
            (
                "a < b, 12 <r, <https://dml.cz/1>",
                "a < b, 12 < r, <https://dml.cz/1>",
            ),
            (
                "<script>1</script><!-- x -->",
                "< script>1< /script>< !-- x -->",
            ),
            ("```{raw} html", "``` text {raw} html"),
            ("~~~~ {include} x", "~~~~ text  {include} x"),
            (":::{figure} x", "::: text {figure} x"),
            ("{download}`x` `{}`", "{download} `x` `{} `"),
            ("```\n|<-a->|\n```", "```\n|<-a->|\n```"),
        ];
        for (text, expected) in cases {
            assert_eq!(plain(text), expected);
        }
    }

    #[test]
    fn figures_become_drawings_but_for_those_that_move() {
        let figure = |title: &str| {
            let html = format!(
                "<figure>\n<svg x=\"1\">a</svg>\n<figcaption><b>{title}.</b> It &lt; that.</figcaption>\n</figure>\n"
            );
            Picture::of((title.to_string(), html))
        };
        let picture = figure("Deformed shape").unwrap();
        assert_eq!(picture.svg, "<svg x=\"1\">a</svg>\n");
        assert_eq!(picture.caption, "It &lt; that.");
        assert!(figure("View that turns").is_none());
    }

    #[test]
    fn words_of_markdown_are_escaped() {
        assert_eq!(escaped("a|b_c\n<d>"), "a\\|b\\_c \\<d\\>");
        assert_eq!(escaped("{raw}`<b>`&lt;"), "\\{raw\\}\\`\\<b\\>\\`&amp;lt;");
        // a caption is HTML already
        assert_eq!(shielded("it&#39;s $x$ &lt;"), "it&#39;s \\$x\\$ &lt;");
    }

    #[test]
    fn words_that_begin_a_block_begin_nothing_else() {
        for (words, text) in [
            (":::{include} /a", "\\:::\\{include\\} /a"),
            ("# a", "\\# a"),
            ("+ a", "\\+ a"),
            ("1. a", "1\\. a"),
            ("(a)=", "\\(a)="),
            ("% a", "\\% a"),
            ("    a", "a"),
            ("```{raw} html\r<b>", "\\`\\`\\`\\{raw\\} html \\<b\\>"),
            ("a: b", "a: b"),
        ] {
            assert_eq!(begun(words), text);
        }
    }

    #[test]
    fn no_text_leaves_its_block_of_code() {
        assert_eq!(fenced("toml", "a = 1"), "```toml\na = 1\n```\n");
        let text = "a\n```\n{raw} html\n`````";
        assert_eq!(fenced("", text), format!("``````\n{text}\n``````\n"));
    }
}
