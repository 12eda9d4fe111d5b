//! Cases: files, and texts with meshes and functions; what can be done with them.

use crate::dual::{Dual, Own};
use crate::errors::{self, Origin};
use crate::functions::{Function, fields};
use crate::mesh::Mesh;
use crate::run::{AnyRun, Kept, Run};
use crate::worker::{Caller, wait};
use dotyk::case::{AnyCase, Given};
use dotyk::model::{Check, Event, Method, SolverOptions, Study, Varied};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::collections::BTreeMap;
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
    beside: Arc<Beside>,
}

/// What a case is made of beside its text.
#[derive(Default)]
pub struct Beside {
    parameters: Vec<Parameter>,
    meshes: Vec<Py<Mesh>>,
    callables: (Vec<Callable>, usize),
}

/// Name of a parameter, and a number or expression.
type Parameter = (String, String);

/// Tolerance, most iterations, and the step of methods that have one.
pub type Limits = (Option<f64>, Option<usize>, Option<f64>);

/// Name of a method, and its limits, where they are not those of the case.
pub type How = (Option<String>, Limits);

/// A callable, its place, its name, and its number of components.
type Callable = (Py<PyAny>, String, String, Option<usize>);

/// The arguments of `of_text`.
pub type Arguments = (
    String,
    (String, PathBuf),
    Vec<Parameter>,
    Vec<Py<Mesh>>,
    (Vec<Callable>, usize),
    BTreeMap<String, Vec<u8>>,
);

impl Beside {
    /// What makes a case again, wherever its files are: the arguments of `of_text`.
    pub fn arguments(&self, py: Python<'_>, case: &AnyCase) -> Arguments {
        let ((text, name, folder), files) = of_any!(case, |case| (case.source(), case.files()));
        let (callables, dimension) = &self.callables;
        let callables = callables.iter().map(|(callable, place, name, components)| {
            (
                callable.clone_ref(py),
                place.clone(),
                name.clone(),
                *components,
            )
        });
        (
            text.to_string(),
            (name.to_string(), folder.to_path_buf()),
            self.parameters.clone(),
            self.meshes.iter().map(|mesh| mesh.clone_ref(py)).collect(),
            (callables.collect(), *dimension),
            files,
        )
    }
}

#[pymethods]
impl Case {
    /// Reads a case file, or a deck of Abaqus and CalculiX.
    #[staticmethod]
    fn of_file(py: Python<'_>, path: PathBuf, parameters: Vec<Parameter>) -> PyResult<Self> {
        let (caller, since) = (Arc::new(Caller::default()), Instant::now());
        let beside = Arc::new(Beside {
            parameters,
            ..Beside::default()
        });
        let own = Arc::clone(&beside);
        let read = wait(py, &caller, None, move |_| {
            dotyk_deck::read_case(&path, &own.parameters)
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
            beside,
        })
    }

    /// Reads a text with the meshes, functions and contents of files that it names.
    #[staticmethod]
    #[pyo3(signature = (text, place, parameters, meshes, callables, files=BTreeMap::new()))]
    fn of_text(
        py: Python<'_>,
        text: String,
        place: (String, PathBuf),
        parameters: Vec<Parameter>,
        meshes: Vec<Py<Mesh>>,
        callables: (Vec<Callable>, usize),
        files: BTreeMap<String, Vec<u8>>,
    ) -> PyResult<Self> {
        let (name, folder) = place;
        let (caller, since) = (Arc::new(Caller::default()), Instant::now());
        let (functions, dimension) = &callables;
        let of_functions = functions.iter().map(|(callable, place, name, components)| {
            let function = Function {
                callable: callable.clone_ref(py),
                place: place.clone(),
                name: name.clone(),
                components: *components,
                dimension: *dimension,
            };
            fields(function, &caller)
        });
        let given = Arc::new(Given {
            functions: of_functions.collect(),
            meshes: meshes.iter().map(|mesh| mesh.get().given.clone()).collect(),
            files,
        });
        let beside = Arc::new(Beside {
            parameters,
            meshes,
            callables,
        });
        let own = Arc::clone(&beside);
        let read = wait(py, &caller, None, move |_| {
            AnyCase::from_parts(&text, &name, &folder, &own.parameters, &given)
        })?;
        let case = read.map_err(|error| errors::of_case(py, &error, &Origin::Python))?;
        Ok(Self {
            case: Arc::new(case),
            origin: Origin::Python,
            caller,
            since,
            beside,
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
        let how = (method, limits);
        let case = self.with_options(py, &how)?;
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
            (Arc::clone(&self.caller), Arc::clone(&self.beside), how),
        ))
    }

    /// The run whose `kept` this is: nothing is solved.
    fn restored(&self, py: Python<'_>, kept: Kept) -> PyResult<Run> {
        let how = kept.1.clone();
        let case = self.with_options(py, &how)?;
        let shared = Arc::clone(&case);
        let read = wait(py, &self.caller, None, move |_| {
            AnyRun::of_kept(&shared, kept)
        })?;
        let (run, since) = read.map_err(|why| errors::input(py, why))?;
        Ok(Run::new(
            case,
            run,
            (self.origin.clone(), since),
            (Arc::clone(&self.caller), Arc::clone(&self.beside), how),
        ))
    }

    /// Solves for all combinations of values of parameters, and tells the last load step or all of them.
    fn study<'py>(
        &self,
        py: Python<'py>,
        parameters: Vec<Parameter>,
        varied: Vec<(String, Vec<f64>)>,
        all_steps: bool,
        threads: Option<usize>,
    ) -> PyResult<Bound<'py, PyDict>> {
        let case = Arc::clone(&self.case);
        let varied = varied.into_iter().map(|(name, values)| Varied {
            name,
            values,
            log: false,
        });
        let varied: Vec<Varied> = varied.collect();
        let doubled = of_any!(&*case, |case| Study::doubled(
            &case.model,
            &varied,
            all_steps
        ));
        if let Some(name) = doubled {
            let message =
                format!("two columns are both named `{name}`: rename the probe or parameter");
            return Err(errors::input(py, message));
        }
        let study = wait(py, &self.caller, threads, move |work| {
            let observe = || work.go_on();
            of_any!(&*case, |case| case.study(&parameters, varied, &observe))
        })?;
        let study = study.map_err(|error| errors::of_case(py, &error, &self.origin))?;
        columns(py, &Study { all_steps, ..study })
    }

    /// The dual problem of the step at a time, of the last one without.
    fn dual(&self, py: Python<'_>, time: Option<f64>) -> PyResult<Dual> {
        Dual::new(
            py,
            Arc::clone(&self.case),
            time,
            (self.origin.clone(), Arc::clone(&self.caller)),
            Arc::clone(&self.beside),
        )
    }
}

impl Case {
    /// The case with settings of the solver by the caller.
    fn with_options(&self, py: Python<'_>, how: &How) -> PyResult<Arc<AnyCase>> {
        let mut any = AnyCase::clone(&self.case);
        of_any!(&mut any, |case| override_options(
            py,
            &mut case.model.solver,
            how.clone()
        )?);
        Ok(Arc::new(any))
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
    (method, (tolerance, most, rho)): How,
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
    let rows = study.rows();
    let mut numbers: Vec<Vec<f64>> = vec![Vec::with_capacity(rows.len()); study.heads().count()];
    for row in &rows {
        let columns = numbers.iter_mut().zip(row.numbers());
        columns.for_each(|(column, value)| column.push(value));
    }
    for (name, values) in study.heads().zip(numbers) {
        dict.set_item(name, numpy::PyArray1::from_vec(py, values))?;
    }
    if study.all_steps {
        let steps = rows.iter().filter_map(|row| Some(row.step?.0 as i64));
        dict.set_item("step", numpy::PyArray1::from_iter(py, steps))?;
    }
    let converged: Vec<bool> = rows.iter().map(|row| row.converged).collect();
    dict.set_item("converged", numpy::PyArray1::from_vec(py, converged))?;
    let reasons: Vec<&str> = rows.iter().map(|row| row.reason).collect();
    dict.set_item("reason", reasons)?;
    Ok(dict)
}
