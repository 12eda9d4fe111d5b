//! Source files as text and as code: the same lines without comments, literals and test modules.
//!
//! A reader of Rust's tokens as far as conventions need it, no parser: it knows comments (nested), strings (raw ones
//! too), characters, lifetimes, and the braces of an item.

use std::path::{Path, PathBuf};

/// A source file; `text` and `code` have the same number of lines.
pub struct Source {
    /// Path relative to the folder that was searched.
    pub path: String,
    /// As it is.
    pub text: String,
    /// Comments and literals blanked, items under `#[cfg(test)]` too.
    pub code: String,
}

/// The folder of the library.
pub fn library() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../dotyk")
}

/// All files below a folder with one of the extensions, sorted; build outputs and hidden folders are left out.
pub fn files(folder: &Path, extensions: &[&str]) -> Vec<PathBuf> {
    let mut found = Vec::new();
    let mut open = vec![folder.to_path_buf()];
    while let Some(folder) = open.pop() {
        for entry in std::fs::read_dir(&folder).unwrap() {
            let path = entry.unwrap().path();
            let name = path.file_name().unwrap().to_string_lossy().into_owned();
            let output = name == "target" || name.starts_with('.') || name.ends_with("-out");
            if path.is_dir() && !output {
                open.push(path);
            } else if path
                .extension()
                .is_some_and(|e| extensions.iter().any(|x| e == *x))
            {
                found.push(path);
            }
        }
    }
    found.sort();
    found
}

/// All Rust files below a folder.
pub fn sources(folder: &Path) -> Vec<Source> {
    files(folder, &["rs"])
        .iter()
        .map(|path| {
            let relative = path.strip_prefix(folder).unwrap();
            let text = std::fs::read_to_string(path).unwrap();
            Source::new(&relative.to_string_lossy().replace('\\', "/"), text)
        })
        .collect()
}

impl Source {
    /// A file of that text.
    pub fn new(path: &str, text: String) -> Self {
        let code = without_test_items(&without_comments_and_literals(&text));
        Self {
            path: path.to_string(),
            text,
            code,
        }
    }
}

/// Blanks comments, strings and characters; line breaks stay.
fn without_comments_and_literals(text: &str) -> String {
    let chars: Vec<char> = text.chars().collect();
    let at = |i: usize| chars.get(i).copied().unwrap_or('\0');
    let mut code = String::with_capacity(text.len());
    let mut i = 0;
    while i < chars.len() {
        let end = match (at(i), at(i + 1)) {
            ('/', '/') => i + chars[i..].iter().take_while(|c| **c != '\n').count(),
            ('/', '*') => end_of_comment(&chars, i),
            ('"', _) => end_of_string(&chars, i + 1),
            ('r', '"' | '#') if !is_word(at(i.wrapping_sub(1))) => end_of_raw_string(&chars, i),
            ('\'', '\\') => i + 3 + chars[i + 3..].iter().take_while(|c| **c != '\'').count() + 1,
            ('\'', _) if at(i + 2) == '\'' => i + 3,
            _ => i,
        };
        if end == i {
            code.push(chars[i]);
            i += 1;
            continue;
        }
        code.extend(
            chars[i..end]
                .iter()
                .map(|c| if *c == '\n' { '\n' } else { ' ' }),
        );
        i = end;
    }
    code
}

fn is_word(c: char) -> bool {
    c.is_alphanumeric() || c == '_'
}

fn end_of_comment(chars: &[char], start: usize) -> usize {
    let (mut depth, mut i) = (0, start);
    while i + 1 < chars.len() {
        match (chars[i], chars[i + 1]) {
            ('/', '*') => (depth, i) = (depth + 1, i + 2),
            ('*', '/') => (depth, i) = (depth - 1, i + 2),
            _ => i += 1,
        }
        if depth == 0 {
            return i;
        }
    }
    chars.len()
}

fn end_of_string(chars: &[char], mut i: usize) -> usize {
    while i < chars.len() && chars[i] != '"' {
        i += if chars[i] == '\\' { 2 } else { 1 };
    }
    (i + 1).min(chars.len())
}

/// `start` itself when what follows the r is no raw string.
fn end_of_raw_string(chars: &[char], start: usize) -> usize {
    let hashes = chars[start + 1..].iter().take_while(|c| **c == '#').count();
    let open = start + 1 + hashes;
    if chars.get(open) != Some(&'"') {
        return start;
    }
    let closes = |i: usize| chars[i] == '"' && (1..=hashes).all(|k| chars.get(i + k) == Some(&'#'));
    let end = (open + 1..chars.len()).find(|&i| closes(i));
    end.map_or(chars.len(), |i| i + 1 + hashes)
}

/// Blanks every item under `#[cfg(test)]`, to its closing brace or semicolon.
fn without_test_items(code: &str) -> String {
    const MARK: &str = "#[cfg(test)]";
    let mut rest = code;
    let mut kept = String::with_capacity(code.len());
    while let Some(start) = rest.find(MARK) {
        kept.push_str(&rest[..start]);
        let (mut depth, mut end) = (0, rest.len());
        for (i, c) in rest[start + MARK.len()..].char_indices() {
            match c {
                '{' => depth += 1,
                '}' => depth -= 1,
                _ => {}
            }
            if depth == 0 && matches!(c, '}' | ';') {
                end = start + MARK.len() + i + 1;
                break;
            }
        }
        kept.extend(rest[start..end].chars().filter(|c| *c == '\n'));
        rest = &rest[end..];
    }
    kept + rest
}
