//! Cases: files, and texts with meshes and functions; what can be done with them.

use crate::dual::{Dual, Own};
use crate::errors::{self, Origin};
use crate::functions::{Function, fields};
use crate::mesh::Mesh;
use crate::run::{AnyRun, Run};
use crate::worker::{Caller, wait};
use dotyk::case::{AnyCase, Given};
use dotyk::model::{Check, Event, Method, SolverOptions, Study, Varied};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::path::PathBuf;
use std::sync::Arc;
use std::time::Instant;

/// Does the same with a case of the plane and with one of space.
macro_rules! of_any {
    ($case:expr, |$name:ident| $body:expr) => {
        match $case {
            AnyCase::Plane($name) => $body,
            AnyCase::Space($name) => $body,
        }
    };
}
pub(crate) use of_any;

/// A case that was read and checked.
#[pyclass(frozen, module = "dotyk._dotyk")]
pub struct Case {
    case: Arc<AnyCase>,
    origin: Origin,
    caller: Arc<Caller>,
    since: Instant,
}

/// Name of a parameter, and a number or expression.
type Parameter = (String, String);

/// Tolerance, most iterations, and the step of methods that have one.
type Limits = (Option<f64>, Option<usize>, Option<f64>);

/// A callable, its place, its name, and its number of components.
type Callable = (Py<PyAny>, String, String, Option<usize>);

#[pymethods]
impl Case {
    /// Reads a case file, or a deck of Abaqus and CalculiX.
    #[staticmethod]
    fn of_file(py: Python<'_>, path: PathBuf, parameters: Vec<Parameter>) -> PyResult<Self> {
        let (caller, since) = (Arc::new(Caller::default()), Instant::now());
        let read = wait(py, &caller, None, move |_| {
            dotyk_deck::read_case(&path, &parameters)
        })?;
        // what is wrong already is told at its place in the deck
        let (case, deck) = read.map_err(|error| errors::of_case(py, &error, &Origin::File))?;
        let origin = match deck {
            Some(deck) => Origin::Deck(Arc::from(deck)),
            None => Origin::File,
        };
        Ok(Self {
            case: Arc::new(case),
            origin,
            caller,
            since,
        })
    }

    /// Reads a text with the meshes and functions that it names.
    #[staticmethod]
    fn of_text(
        py: Python<'_>,
        text: String,
        place: (String, PathBuf),
        parameters: Vec<Parameter>,
        meshes: Vec<Py<Mesh>>,
        callables: (Vec<Callable>, usize),
    ) -> PyResult<Self> {
        let ((name, folder), (functions, dimension)) = (place, callables);
        let (caller, since) = (Arc::new(Caller::default()), Instant::now());
        let of_functions = functions
            .into_iter()
            .map(|(callable, place, name, components)| {
                let function = Function {
                    callable,
                    place,
                    name,
                    components,
                    dimension,
                };
                fields(function, &caller)
            });
        let given = Arc::new(Given {
            functions: of_functions.collect(),
            meshes: meshes.iter().map(|mesh| mesh.get().given.clone()).collect(),
            ..Given::default()
        });
        let read = wait(py, &caller, None, move |_| {
            AnyCase::from_parts(&text, &name, &folder, &parameters, &given)
        })?;
        let case = read.map_err(|error| errors::of_case(py, &error, &Origin::Python))?;
        Ok(Self {
            case: Arc::new(case),
            origin: Origin::Python,
            caller,
            since,
        })
    }

    /// Name of the case.
    #[getter]
    fn stem(&self) -> String {
        of_any!(&*self.case, |case| case.stem.clone())
    }

    /// What was noticed while reading.
    #[getter]
    fn warnings(&self) -> Vec<String> {
        of_any!(&*self.case, |case| case.warnings.clone())
    }

    /// Looks at the model without solving: errors, warnings, bodies and contacts in words, and all of it as text.
    fn check<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let case = Arc::clone(&self.case);
        wait(py, &self.caller, None, move |_| {
            of_any!(&*case, |case| checked(case.check()))
        })?
        .into_dict(py)
    }

    /// Solves all load steps by a method, or a callable; limits are tolerance, most iterations and step.
    #[pyo3(signature = (method, own, limits, threads, callback))]
    fn solve(
        &self,
        py: Python<'_>,
        method: Option<String>,
        own: Option<Py<PyAny>>,
        limits: Limits,
        threads: Option<usize>,
        callback: Option<Py<PyAny>>,
    ) -> PyResult<Run> {
        let mut any = AnyCase::clone(&self.case);
        of_any!(&mut any, |case| override_options(
            py,
            &mut case.model.solver,
            method,
            limits
        )?);
        let case = Arc::new(any);
        let (shared, since) = (Arc::clone(&case), self.since);
        let tell = callback.map(Arc::new);
        let run = wait(py, &self.caller, threads, move |work| {
            let mut observe = |event: Event| {
                if let Some(tell) = &tell {
                    let tell = Arc::clone(tell);
                    work.ask(move |py| told(py, &tell, &event));
                }
                work.go_on();
            };
            let own = own.map(|callable| Own::new(callable, Arc::clone(work)));
            match &*shared {
                AnyCase::Plane(case) => AnyRun::Plane(match &own {
                    Some(own) => case.run_by(own, &mut observe),
                    None => case.run(&[], &mut observe),
                }),
                AnyCase::Space(case) => AnyRun::Space(match &own {
                    Some(own) => case.run_by(own, &mut observe),
                    None => case.run(&[], &mut observe),
                }),
            }
        })?;
        Ok(Run::new(
            case,
            run,
            (self.origin.clone(), since),
            Arc::clone(&self.caller),
        ))
    }

    /// Solves for all combinations of values of parameters.
    fn study<'py>(
        &self,
        py: Python<'py>,
        parameters: Vec<Parameter>,
        varied: Vec<(String, Vec<f64>)>,
        threads: Option<usize>,
    ) -> PyResult<Bound<'py, PyDict>> {
        let case = Arc::clone(&self.case);
        let varied = varied.into_iter().map(|(name, values)| Varied {
            name,
            values,
            log: false,
        });
        let varied: Vec<Varied> = varied.collect();
        let study = wait(py, &self.caller, threads, move |work| {
            let observe = || work.go_on();
            of_any!(&*case, |case| case.study(&parameters, varied, &observe))
        })?;
        let study = study.map_err(|error| errors::of_case(py, &error, &self.origin))?;
        columns(py, &study)
    }

    /// The dual problem of the step at a time, of the last one without.
    fn dual(&self, py: Python<'_>, time: Option<f64>) -> PyResult<Dual> {
        Dual::new(
            py,
            Arc::clone(&self.case),
            time,
            (self.origin.clone(), Arc::clone(&self.caller)),
        )
    }
}

/// An event as passed to the callback: stage, step, iteration, measure.
fn told(py: Python<'_>, callback: &Py<PyAny>, event: &Event) -> PyResult<()> {
    let none = || py.None();
    let told = match event {
        Event::Step { step, steps, time } => ("step", (*step, *steps, *time))
            .into_pyobject(py)?
            .into_any(),
        Event::Stage(name) => ("stage", *name).into_pyobject(py)?.into_any(),
        Event::Factoring(_) => ("factoring", none()).into_pyobject(py)?.into_any(),
        Event::Iteration(point) => ("iteration", (point.iteration, point.residual))
            .into_pyobject(py)?
            .into_any(),
    };
    callback.call1(py, (told,)).map(|_| ())
}

/// Settings of the solver by the caller, instead of those of the case.
fn override_options<const D: usize>(
    py: Python<'_>,
    options: &mut SolverOptions<D>,
    method: Option<String>,
    (tolerance, most, rho): Limits,
) -> PyResult<()> {
    let method = method.map(|name| method_of(py, &name)).transpose()?;
    options.take(method, rho).map_err(|method| {
        let message = format!(
            "`rho` has no meaning for the method `{}`: it is a step of `gradient` and `uzawa`",
            method.name()
        );
        errors::input(py, message)
    })?;
    for (name, value) in [("tolerance", tolerance), ("rho", rho)] {
        if value.is_some_and(|value| !(value.is_finite() && value > 0.0)) {
            return Err(errors::input(
                py,
                format!("`{name}` must be a positive number"),
            ));
        }
    }
    if most == Some(0) {
        return Err(errors::input(
            py,
            "`max_iterations` must be a positive integer",
        ));
    }
    options.tolerance = tolerance.unwrap_or(options.tolerance);
    options.max_iterations = most.or(options.max_iterations);
    Ok(())
}

/// A method by its name.
pub fn method_of(py: Python<'_>, name: &str) -> PyResult<Method> {
    Method::from_name(name).ok_or_else(|| {
        let known: Vec<&str> = Method::NAMED.iter().map(|method| method.name()).collect();
        errors::input(
            py,
            format!("unknown method `{name}`; known: auto, {}", known.join(", ")),
        )
    })
}

/// Name, nodes and cells, resultant of the loads, held dofs, and the rigid motions left with the contacts that hold them.
type Found = (String, [usize; 2], Vec<f64>, usize, Vec<String>);

/// Name, kind and ends of a member, its length, the number of its elements, and how many it stands for.
type FoundMember = (String, &'static str, [String; 2], f64, usize, f64);

/// The results of a check.
struct Checked {
    errors: Vec<String>,
    warnings: Vec<String>,
    notes: Vec<String>,
    bodies: Vec<Found>,
    contacts: Vec<(String, [String; 2], usize)>,
    members: Vec<FoundMember>,
    text: String,
}

/// The results of a check of a case.
fn checked<const D: usize>(check: Check<D>) -> Checked {
    let bodies = check.bodies.iter();
    let contacts = check.contacts.iter();
    let members = check.members.iter();
    Checked {
        members: members
            .map(|m| {
                let (kind, ends) = (m.kind.key, m.ends.clone());
                (m.name.clone(), kind, ends, m.length, m.elements, m.count)
            })
            .collect(),
        text: check.to_string(),
        bodies: bodies
            .map(|b| {
                let load = b.load.to_vec();
                (b.name.clone(), b.size, load, b.held, b.floating.clone())
            })
            .collect(),
        contacts: contacts
            .map(|c| (c.name.clone(), c.sides.clone(), c.unknowns))
            .collect(),
        errors: check.errors,
        warnings: check.warnings,
        notes: check.notes,
    }
}

impl Checked {
    fn into_dict(self, py: Python<'_>) -> PyResult<Bound<'_, PyDict>> {
        let dict = PyDict::new(py);
        dict.set_item("errors", self.errors)?;
        dict.set_item("warnings", self.warnings)?;
        dict.set_item("notes", self.notes)?;
        dict.set_item("bodies", self.bodies)?;
        dict.set_item("contacts", self.contacts)?;
        dict.set_item("members", self.members)?;
        dict.set_item("text", self.text)?;
        Ok(dict)
    }
}

/// The columns of `study.csv`.
fn columns<'py>(py: Python<'py>, study: &Study) -> PyResult<Bound<'py, PyDict>> {
    let dict = PyDict::new(py);
    let members = &study.members;
    for (k, varied) in study.varied.iter().enumerate() {
        let values: Vec<f64> = members.iter().map(|member| member.values[k]).collect();
        dict.set_item(&varied.name, numpy::PyArray1::from_vec(py, values))?;
    }
    for (k, probe) in study.probes.iter().enumerate() {
        let values: Vec<f64> = members.iter().map(|member| member.probes[k]).collect();
        dict.set_item(&probe.name, numpy::PyArray1::from_vec(py, values))?;
    }
    let converged: Vec<bool> = members.iter().map(|member| member.converged).collect();
    dict.set_item("converged", numpy::PyArray1::from_vec(py, converged))?;
    let reasons: Vec<String> = members.iter().map(|member| member.reason.clone()).collect();
    dict.set_item("reason", reasons)?;
    Ok(dict)
}
