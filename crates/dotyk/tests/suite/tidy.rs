//! Conventions of the text of the repository: headers, leftovers, paths of a machine, the change log.

use crate::source::{Source, files, library, sources};
use std::path::PathBuf;

/// The folder that holds the workspace.
fn repository() -> PathBuf {
    library().join("../..")
}

/// All Rust files of the workspace.
fn rust() -> Vec<Source> {
    let all = sources(&repository());
    assert!(all.len() > 100, "the sources are elsewhere");
    all
}

fn report(findings: &[String]) {
    assert!(findings.is_empty(), "{}", findings.join("\n"));
}

#[test]
fn every_file_says_first_what_it_is_for() {
    let silent: Vec<String> = rust()
        .iter()
        .filter(|source| !source.text.starts_with("//! "))
        .map(|source| format!("{}: begins without `//! `", source.path))
        .collect();
    report(&silent);
}

/// Words that mark unfinished work; in pieces, because this file is searched too.
const LEFTOVERS: [&str; 6] = [
    concat!("TO", "DO"),
    concat!("FIX", "ME"),
    concat!("XX", "X"),
    concat!("dbg", "!"),
    concat!("todo", "!"),
    concat!("unimplemented", "!"),
];

#[test]
fn nothing_is_left_for_later() {
    let mut found = Vec::new();
    for source in rust() {
        for (index, line) in source.text.lines().enumerate() {
            let left = LEFTOVERS.iter().filter(|word| line.contains(**word));
            found.extend(left.map(|word| format!("{}:{}: {word}", source.path, index + 1)));
        }
    }
    report(&found);
}

/// Its parts are escaped by the macro, and by nothing else.
#[test]
fn markup_comes_out_of_templates_alone() {
    let others = sources(&library().join("src")).into_iter();
    let others = others.filter(|source| source.path != "output/markup.rs");
    let around = others.filter(|source| source.code.contains("Markup::filled"));
    report(&around.map(|source| source.path).collect::<Vec<_>>());
}

/// What cannot happen may say so with a reason; what can happen is an error.
#[test]
fn the_library_panics_on_no_input() {
    let calls = [".unwrap()", "panic!(", "unreachable!()"];
    let mut found = Vec::new();
    for source in sources(&library().join("src")) {
        if source.path.ends_with("/tests.rs") || source.path.ends_with("/tunnel.rs") {
            continue;
        }
        for (index, line) in source.code.lines().enumerate() {
            let used = calls.iter().filter(|call| line.contains(**call));
            found.extend(used.map(|call| format!("{}:{}: {call}", source.path, index + 1)));
        }
    }
    report(&found);
}

/// Whether a line is a comment that can only be code: prose neither ends like a statement nor like a block.
fn is_disabled_code(line: &str) -> bool {
    let Some(comment) = line.trim_start().strip_prefix("//") else {
        return false;
    };
    if comment.starts_with(['/', '!']) {
        return false;
    }
    let text = comment.trim();
    let statement = text.ends_with(';')
        && (text.contains(" = ") || text.contains("::") || text.ends_with(");"));
    let starts = [
        "let ", "use ", "pub ", "fn ", "impl ", "mod ", "#[", "} else",
    ];
    let item = starts.iter().any(|start| text.starts_with(start))
        && text.ends_with([';', '{', ']', '}', ')']);
    statement || item || text.ends_with(") {") || matches!(text, "}" | "};" | "})" | "});")
}

#[test]
fn no_code_is_commented_out() {
    let mut found = Vec::new();
    for source in rust() {
        for (index, line) in source.text.lines().enumerate() {
            if is_disabled_code(line) {
                found.push(format!("{}:{}: {}", source.path, index + 1, line.trim()));
            }
        }
    }
    report(&found);
    let code = [
        "// let x = 1;",
        "    // x += f(y);",
        "// use crate::mesh::Mesh;",
        "// if x > 0 && f(x) {",
        "// }",
        "// #[test]",
        "// solve(&mut matrix, &mut right);",
    ];
    for line in code {
        assert!(is_disabled_code(line), "{line}");
    }
    let prose = [
        "// The sign is that of the gap; the force follows (see below).",
        "// Let the bolt be where λ > 0;",
        "/// let x = 1;",
        "// Below 1e-6 of λ the quotient of differences loses too many digits.",
        "let x = 1; // let it be",
    ];
    for line in prose {
        assert!(!is_disabled_code(line), "{line}");
    }
}

#[test]
fn no_file_names_a_path_of_a_machine() {
    let folders = ["work", "home", "root", "tmp", "Users", "mnt"];
    let kinds = ["rs", "toml", "md", "cff", "txt", "css", "html", "sh", "yml"];
    let mut found = Vec::new();
    for path in files(&repository(), &kinds) {
        let text = std::fs::read_to_string(&path).unwrap();
        for (index, line) in text.lines().enumerate() {
            let absolute = |folder: &&str| {
                let named = format!("/{folder}/");
                line.match_indices(&named).any(|(at, _)| {
                    let before = line[..at].chars().next_back();
                    before.is_none_or(|c| c.is_whitespace() || "\"'`(=".contains(c))
                })
            };
            if folders.iter().any(absolute) {
                found.push(format!("{}:{}: {line}", path.display(), index + 1));
            }
        }
    }
    report(&found);
}

#[test]
fn the_change_log_knows_the_current_version() {
    let version = env!("CARGO_PKG_VERSION");
    if !repository().join("README.md").exists() {
        // The library alone, outside its repository: there is no log to check.
        return;
    }
    let log = std::fs::read_to_string(repository().join("CHANGELOG.md")).unwrap();
    let heading = |line: &str| line.starts_with("## ") && line.contains(version);
    assert!(
        log.lines().any(heading),
        "no heading `## [{version}]` in CHANGELOG.md"
    );
}
