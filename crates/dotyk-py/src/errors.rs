//! Exceptions of the package, with the library's own texts.

use dotyk::case::CaseError;
use pyo3::prelude::*;

/// The package module that defines them.
const MODULE: &str = "dotyk._errors";

fn raised(py: Python<'_>, class: &str, message: &str) -> PyErr {
    let made = py
        .import(MODULE)
        .and_then(|module| module.getattr(class)?.call1((message,)));
    match made {
        Ok(error) => PyErr::from_value(error),
        Err(error) => error,
    }
}

/// Bad input, in words.
pub fn input(py: Python<'_>, message: impl std::fmt::Display) -> PyErr {
    raised(py, "InputError", &message.to_string())
}

/// Bad input at a place of a text: with line and column for a file, without them for a model built in Python.
pub fn of_case(py: Python<'_>, error: &CaseError, file: bool) -> PyErr {
    let mut text = match file {
        true => error.to_string(),
        false => error.message.clone(),
    };
    // a label that names a thing is better than its position
    if error.label.contains('`') {
        text = format!("{text}: {}", error.label);
    }
    if let Some(help) = &error.help {
        text = format!("{text}; {help}");
    }
    input(py, text)
}

/// An iteration that ended without an answer, in words.
pub fn not_converged(py: Python<'_>, message: &str) -> PyErr {
    raised(py, "NotConverged", message)
}

/// Something that should not happen.
pub fn internal(py: Python<'_>) -> PyErr {
    raised(
        py,
        "Error",
        "the computation ended without a result; please report it",
    )
}
