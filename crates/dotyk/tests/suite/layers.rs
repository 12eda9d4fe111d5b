//! The layer table of the library as a test: which module may use which, and who may touch what lies outside.
//!
//! Two legs that meet once: geometry → mesh → fem → contact and linalg → dual → solve meet in model; output and case
//! stand on it. Modules are named by `crate::` paths outside test modules, one module per `use`, so that this
//! test can read them.

use crate::source::{Source, library, sources};

/// Each module and what it may use beside itself.
const TABLE: [(&str, &str); 13] = [
    ("system", ""),
    ("geometry", ""),
    ("linalg", ""),
    ("analytic", "geometry"),
    ("mesh", "system geometry"),
    ("fem", "geometry linalg mesh"),
    ("contact", "geometry linalg mesh fem"),
    ("dual", "linalg"),
    ("solve", "linalg dual"),
    (
        "model",
        "system geometry linalg mesh fem contact dual solve",
    ),
    ("output", "system geometry mesh model dual"),
    (
        "case",
        "system geometry analytic linalg mesh fem contact dual solve model",
    ),
    ("prelude", "geometry mesh model"),
];

/// The module that a file of `src` belongs to; `lib.rs` belongs to none.
fn module(source: &Source) -> &str {
    let first = source.path.split('/').next().unwrap_or("");
    first.strip_suffix(".rs").unwrap_or(first)
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
    let touches_files = ["case", "output", "mesh", "system"].contains(&module);
    let pure = ["dual", "solve"].contains(&module);
    for (index, line) in source.code.lines().enumerate() {
        let mut find = |what: String| {
            findings.push(format!("{}:{}: {what}", source.path, index + 1));
        };
        for (start, _) in line.match_indices("crate::") {
            let path = &line[start + "crate::".len()..];
            let used = path.split(|c: char| !(c.is_alphanumeric() || c == '_'));
            match used.into_iter().next().unwrap_or("") {
                "" => find("a group of modules: write one `use` per module".to_string()),
                used if !allowed.contains(&used) => find(format!("{module} uses {used}")),
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
            find("only case, output, system and the readers of mesh touch files".to_string());
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
            "model/build.rs",
            "use crate::{fem, mesh};",
            "model/build.rs:1: a group",
        ),
        (
            "model/build.rs",
            "use super::nouns::Body;",
            "model/build.rs:1: `super::`",
        ),
        (
            "model/condense.rs",
            "use faer::Mat;",
            "model/condense.rs:1: only linalg",
        ),
        (
            "model/build.rs",
            "std::fs::read(path)",
            "model/build.rs:1: only case",
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
