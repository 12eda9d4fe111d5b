//! The layer table of the library as a test: which module may use which, and who may touch what lies outside.
//!
//! Two legs that meet once: geometry → mesh → fem → contact and linalg → dual → solve meet in model; output and case
//! stand on it. Modules are named by `crate::` paths outside test modules, one module per `use`, so that this
//! test can read them. Within model the rooms stand one behind the other, and no files in circles.

use crate::source::{Source, library, sources};
use std::collections::{BTreeMap, BTreeSet};

/// Each module and what it may use beside itself.
const TABLE: [(&str, &str); 13] = [
    ("host", ""),
    ("geometry", ""),
    ("linalg", "host"),
    ("analytic", "geometry"),
    ("mesh", "host geometry"),
    ("fem", "geometry linalg mesh host"),
    ("contact", "geometry linalg mesh fem host"),
    ("dual", "linalg"),
    ("solve", "linalg dual"),
    ("model", "host geometry linalg mesh fem contact dual solve"),
    ("output", "host geometry mesh model dual"),
    (
        "case",
        "host geometry analytic linalg mesh fem contact dual solve model",
    ),
    ("prelude", "geometry mesh model"),
];

/// The rooms of `model`; each uses itself and those before it.
const ROOMS: [&str; 5] = ["nouns", "system", "read", "march", "ask"];

/// The module that a file of `src` belongs to; `lib.rs` belongs to none.
fn module(source: &Source) -> &str {
    let first = source.path.split('/').next().unwrap_or("");
    first.strip_suffix(".rs").unwrap_or(first)
}

/// What a file of a room of `model` may not name behind `crate::model::`: a later room, or what the house shows outside.
fn above(path: &str, used: &str) -> Option<String> {
    let place = |name: &str| ROOMS.iter().position(|room| *room == name);
    let room = path.strip_prefix("model/")?.split('/').next()?;
    let own = place(room)?;
    match place(used) {
        Some(used) if used <= own => None,
        _ => Some(format!("the room {room} uses {used}")),
    }
}

/// Modules that may appear in `source`, itself included.
fn allowed(module: &str) -> Option<Vec<&'static str>> {
    let row = TABLE.iter().find(|(name, _)| *name == module)?;
    Some(row.1.split_whitespace().chain([row.0]).collect())
}

fn findings(source: &Source) -> Vec<String> {
    let mut findings = Vec::new();
    let module = module(source);
    let test_module = source.path.ends_with("/tests.rs");
    if module == "lib" || test_module {
        return findings;
    }
    let Some(allowed) = allowed(module) else {
        return vec![format!(
            "{}: a module without a row in the table",
            source.path
        )];
    };
    let touches_files = ["case", "output", "mesh", "host"].contains(&module);
    let pure = ["dual", "solve"].contains(&module);
    for (index, line) in source.code.lines().enumerate() {
        let mut find = |what: String| {
            findings.push(format!("{}:{}: {what}", source.path, index + 1));
        };
        for (start, _) in line.match_indices("crate::") {
            let path = &line[start + "crate::".len()..];
            let mut used = path.split(|c: char| !(c.is_alphanumeric() || c == '_'));
            match used.next().unwrap_or("") {
                "" => find("a group of modules: write one `use` per module".to_string()),
                used if !allowed.contains(&used) => find(format!("{module} uses {used}")),
                "model" => {
                    let room = used.find(|word| !word.is_empty()).unwrap_or("");
                    above(&source.path, room).into_iter().for_each(&mut find);
                }
                _ => {}
            }
        }
        let words = |word: &str| {
            let mut words = line.split(|c: char| !(c.is_alphanumeric() || c == '_'));
            words.any(|w| w == word)
        };
        if line.contains("super::") {
            find("`super::` outside a test module: write the `crate::` path".to_string());
        }
        if words("faer") && module != "linalg" {
            find("only linalg names the linear-algebra library".to_string());
        }
        if (line.contains("std::fs") || line.contains("std::env")) && !touches_files {
            find("only case, output, host and the readers of mesh touch files".to_string());
        }
        if ["print", "println", "eprint", "eprintln", "dbg"]
            .iter()
            .any(|m| line.contains(&format!("{m}!")))
        {
            find("the library prints nothing".to_string());
        }
        let geometric = ["mesh", "Mesh", "body", "Body", "bodies", "Bodies", "Point"];
        if pure && (geometric.iter().any(|w| words(w)) || line.contains("const D:")) {
            find(format!("{module} knows no mesh, no body, no dimension"));
        }
    }
    findings
}

#[test]
fn every_module_uses_only_what_its_layer_allows() {
    let sources = sources(&library().join("src"));
    assert!(sources.len() > 80, "the sources are elsewhere");
    // Else the lines of the findings would be wrong.
    for source in &sources {
        assert_eq!(
            source.text.lines().count(),
            source.code.lines().count(),
            "{}",
            source.path
        );
    }
    let all: Vec<String> = sources.iter().flat_map(findings).collect();
    assert!(all.is_empty(), "{}", all.join("\n"));
}

/// The file of `model` behind a `crate::model::` path, by room and name.
fn file_of_model(path: &str) -> Option<String> {
    let mut words = path.split(|c: char| !(c.is_alphanumeric() || c == '_'));
    let (room, _, file) = (words.next()?, words.next()?, words.next()?);
    ROOMS
        .contains(&room)
        .then(|| format!("model/{room}/{file}.rs"))
}

#[test]
fn no_file_of_the_model_needs_itself_through_others() {
    let sources = sources(&library().join("src"));
    let ours = sources.iter().filter(|s| s.path.starts_with("model/"));
    let mut needs: BTreeMap<&str, BTreeSet<String>> = ours
        .map(|source| {
            let lines = source.code.lines();
            let paths = lines.flat_map(|line| {
                line.match_indices("crate::model::")
                    .map(move |m| &line[m.0..])
            });
            let files = paths.filter_map(|path| file_of_model(&path["crate::model::".len()..]));
            (
                &source.path[..],
                files.filter(|file| *file != source.path).collect(),
            )
        })
        .collect();
    assert!(needs.len() > 50, "the sources are elsewhere");
    // what needs nothing that is left is taken away, until nothing is left or all of it needs each other
    loop {
        let names: BTreeSet<String> = needs.keys().map(|name| name.to_string()).collect();
        let before = needs.len();
        needs.retain(|_, needs| needs.iter().any(|need| names.contains(need)));
        if needs.len() == before {
            break;
        }
    }
    assert!(
        needs.is_empty(),
        "files in circles, and what they need: {needs:?}"
    );
}

#[test]
fn every_row_of_the_table_names_modules_below_it() {
    for (row, (module, uses)) in TABLE.iter().enumerate() {
        for used in uses.split_whitespace() {
            let place = TABLE.iter().position(|(name, _)| *name == used);
            assert!(
                place.is_some_and(|place| place < row),
                "{module} uses {used}"
            );
        }
    }
}

#[test]
fn forbidden_uses_are_found_with_file_and_line() {
    let found = |path: &str, text: &str| findings(&Source::new(path, text.to_string()));
    let cases = [
        (
            "dual/mod.rs",
            "\nuse crate::mesh::Mesh;",
            "dual/mod.rs:2: dual uses mesh",
        ),
        (
            "fem/stress.rs",
            "let x = crate::model::Error;",
            "fem/stress.rs:1: fem uses model",
        ),
        (
            "model/nouns/build.rs",
            "use crate::{fem, mesh};",
            "model/nouns/build.rs:1: a group",
        ),
        (
            "model/nouns/build.rs",
            "use super::model::Body;",
            "model/nouns/build.rs:1: `super::`",
        ),
        (
            "model/system/condense.rs",
            "use faer::Mat;",
            "model/system/condense.rs:1: only linalg",
        ),
        (
            "model/system/condense.rs",
            "use crate::model::march::judge::judge;",
            "model/system/condense.rs:1: the room system uses march",
        ),
        (
            "model/read/fields.rs",
            "use crate::model::Solution;",
            "model/read/fields.rs:1: the room read uses Solution",
        ),
        (
            "model/nouns/build.rs",
            "std::fs::read(path)",
            "model/nouns/build.rs:1: only case",
        ),
        (
            "solve/newton.rs",
            "eprintln!(\"\")",
            "solve/newton.rs:1: the library prints",
        ),
        (
            "solve/newton.rs",
            "fn f<const D: usize>() {}",
            "solve/newton.rs:1: solve knows",
        ),
        ("plugin/mod.rs", "", "plugin/mod.rs: a module without"),
    ];
    for (path, text, expected) in cases {
        let found = found(path, text);
        assert!(
            found.iter().any(|f| f.starts_with(expected)),
            "{text}: {found:?}"
        );
    }
    let harmless = [
        "// crate::mesh in a comment, println! too",
        "/* crate::mesh /* nested */ super:: */",
        "let s = \"crate::mesh \\\" super::\";",
        "let s = r#\"crate::mesh \" super::\"#;",
        "let c = '\"'; let l: &'static str = s; // crate::mesh",
        "#[cfg(test)]\nmod tests {\n    use super::*;\n    fn f() {}\n}",
        "#[cfg(test)]\nmod tests;",
        "use crate::dual::Block;",
    ];
    for text in harmless {
        assert_eq!(found("dual/mod.rs", text), Vec::<String>::new(), "{text}");
    }
    let after = "#[cfg(test)]\nmod tests { use super::*; }\nuse crate::fem::assemble;";
    assert_eq!(
        found("dual/mod.rs", after),
        ["dual/mod.rs:3: dual uses fem"]
    );
}
