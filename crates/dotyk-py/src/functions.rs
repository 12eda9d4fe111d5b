//! Callables of the user as fields: called with all points of a place at once, on the thread that waits.

use crate::errors;
use crate::mesh::rows;
use crate::worker::Caller;
use dotyk::geometry::{Field, Sampler};
use numpy::{PyReadonlyArrayDyn, PyUntypedArrayMethods};
use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;
use std::sync::Arc;

/// A callable `f(points, t)`, its place, and the shape of its values.
pub struct Function {
    /// Python's callable.
    pub callable: Py<PyAny>,
    /// Its place, such as "body `rock`, load on `top`, traction".
    pub place: String,
    /// Its name, for messages and reports.
    pub name: String,
    /// Number of components; `None` for a scalar at each point.
    pub components: Option<usize>,
    /// Number of coordinates of a point.
    pub dimension: usize,
}

/// The components of a function.
pub fn fields(function: Function, caller: &Arc<Caller>) -> Vec<Field> {
    let (caller, name) = (Arc::clone(caller), function.name.clone());
    let size = function.components.unwrap_or(1);
    let function = Arc::new(function);
    let sampler: Box<Sampler> = Box::new(move |points, t| {
        let (function, points) = (Arc::clone(&function), points.to_vec());
        let values = caller.ask(move |py| called(py, &function, points, t));
        values.unwrap_or_default()
    });
    Field::sampled(&name, size, sampler)
}

fn called(
    py: Python<'_>,
    function: &Function,
    points: Vec<[f64; 3]>,
    t: f64,
) -> PyResult<Vec<f64>> {
    let count = points.len();
    let array = match function.dimension {
        2 => rows(py, points.iter().map(|p| [p[0], p[1]]).collect())?.into_any(),
        _ => rows(py, points.clone())?.into_any(),
    };
    let found = function.callable.call1(py, (array, t))?;
    let what = format!("{}: what {} gave", function.place, function.name);
    let words = py.import("dotyk._words")?;
    words.call_method1("unmasked", (&found, what))?;
    let shape: Vec<usize> = [Some(count), function.components]
        .into_iter()
        .flatten()
        .collect();
    let Ok(array) = numbers(py, found.bind(py)) else {
        let told = "something that is no array of numbers";
        return Err(refused(py, function, &shape, told));
    };
    let values: PyReadonlyArrayDyn<'_, f64> = array.extract()?;
    if values.shape() != shape {
        let told = format!("the shape {}", told(values.shape()));
        return Err(refused(py, function, &shape, &told));
    }
    let values: Vec<f64> = values.as_array().iter().copied().collect();
    let Some(wrong) = values.iter().position(|value| !value.is_finite()) else {
        return Ok(values);
    };
    let at = &points[wrong / function.components.unwrap_or(1)][..function.dimension];
    let (place, name, value) = (&function.place, &function.name, values[wrong]);
    // where a value is at all times the same there is no time
    let why = match t.is_nan() {
        true => "the value is at all times the same, and t is nan",
        false => "values must be finite",
    };
    let message = format!("{place}: {name} gave {value} at {at:?}: {why}");
    Err(errors::input(py, message))
}

/// Real numbers of any kind as an array of floats. Errors: something else, such as words or complex numbers.
fn numbers<'py>(py: Python<'py>, found: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyAny>> {
    let numpy = py.import("numpy")?;
    let array = numpy.call_method1("asarray", (found,))?;
    let kind: String = array.getattr("dtype")?.getattr("kind")?.extract()?;
    match kind.as_str() {
        "b" | "i" | "u" | "f" | "O" => numpy.call_method1("asarray", (array, "float64")),
        _ => Err(PyTypeError::new_err("no numbers")),
    }
}

fn refused(py: Python<'_>, function: &Function, shape: &[usize], found: &str) -> PyErr {
    let (place, name) = (&function.place, &function.name);
    let expected = told(shape);
    errors::input(
        py,
        format!("{place}: {name} must give an array of shape {expected}, it gave {found}"),
    )
}

fn told(shape: &[usize]) -> String {
    match shape {
        [one] => format!("({one},)"),
        many => {
            let sizes: Vec<String> = many.iter().map(usize::to_string).collect();
            format!("({})", sizes.join(", "))
        }
    }
}
