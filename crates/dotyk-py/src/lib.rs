//! The compiled part of the Python package `dotyk`: meshes, cases, runs and dual problems, exceptions with the library's texts, and
//! the wait for work with the interpreter's lock free. Docstrings and types are in the package itself.

mod case;
mod dual;
mod errors;
mod functions;
mod mesh;
mod run;
mod worker;

use pyo3::prelude::*;
use std::ffi::OsString;

#[pymodule(name = "_dotyk")]
mod module {
    #[pymodule_export]
    use super::case::Case;
    #[pymodule_export]
    use super::dual::{Dual, Problem};
    #[pymodule_export]
    use super::mesh::Mesh;
    #[pymodule_export]
    use super::run::Run;
    #[pymodule_export]
    use super::{check_file_names, command, keys, members, nearest, to_json, version};
}

/// Runs the command with its arguments, its own name the first of them; the exit status.
#[pyfunction]
fn command(py: Python<'_>, arguments: Vec<OsString>) -> u8 {
    py.detach(|| dotyk_cli::main(arguments))
}

/// Every table of a case file with its keys.
#[pyfunction]
fn keys() -> Vec<(&'static str, Vec<&'static str>)> {
    let tables = dotyk::case::keys::ALL.iter();
    tables
        .map(|(table, keys)| (*table, keys.to_vec()))
        .collect()
}

/// The kinds of members: the key of each in a case file, that in results, and the keys of one.
#[pyfunction]
fn members() -> Vec<(&'static str, &'static str, Vec<&'static str>)> {
    let (tables, kinds) = (dotyk::case::keys::ALL, dotyk::model::MemberKind::ALL);
    let tables = tables[tables.len() - kinds.len()..].iter();
    kinds
        .iter()
        .zip(tables)
        .map(|(kind, (_, keys))| (kind.key, kind.plural, keys.to_vec()))
        .collect()
}

/// A text of a case file as JSON.
#[pyfunction]
fn to_json(py: Python<'_>, text: &str, name: &str) -> PyResult<String> {
    dotyk::case::to_json(text, name)
        .map_err(|error| errors::of_case(py, &error, &errors::Origin::File))
}

/// The nearest of some known words, or none.
#[pyfunction]
#[allow(clippy::needless_pass_by_value)]
fn nearest(word: &str, known: Vec<String>) -> Option<String> {
    let near = dotyk::case::nearest(word, known.iter().map(String::as_str));
    near.map(str::to_string)
}

/// Refuses names of bodies by which no result files can be called.
#[pyfunction]
#[allow(clippy::needless_pass_by_value)]
fn check_file_names(py: Python<'_>, names: Vec<String>) -> PyResult<()> {
    let checked = dotyk::model::check_file_names(names.iter().map(String::as_str));
    checked.map_err(|error| errors::input(py, format!("body `{}`: {error}", error.name())))
}

/// Version of the library.
#[pyfunction]
fn version() -> &'static str {
    env!("CARGO_PKG_VERSION")
}
