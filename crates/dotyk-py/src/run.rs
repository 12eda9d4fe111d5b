//! The results of a case: numbers as arrays, the summary, pictures and files.

use crate::case::{Arguments, Beside, How, of_any};
use crate::errors::{self, Origin};
use crate::mesh::rows;
use crate::worker::{Caller, wait};
use dotyk::case::{AnyCase, Case, CaseError, Failure};
use dotyk::model::{BodyField, ContactNode, On, Shape, Solution};
use dotyk::output::{self, FailedStep, Record};
use numpy::{PyArray1, PyArrayMethods};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::path::PathBuf;
use std::sync::Arc;
use std::time::{Duration, Instant};

/// The run of a case of the plane or of space.
pub enum AnyRun {
    /// Of the plane.
    Plane(dotyk::case::Run<2>),
    /// Of space.
    Space(dotyk::case::Run<3>),
}

/// What a run keeps beside its case: solutions as bytes, method and limits, number of load steps, the step that has no answer, and
/// the seconds that it took.
pub type Kept = (Vec<u8>, How, usize, Option<Failed>, f64);

/// Number, time and reason of a step without an answer, and the part of it that is carried.
pub type Failed = (usize, f64, String, Option<f64>);

impl AnyRun {
    /// The run of a case that was kept, and when it would have begun.
    ///
    /// Errors: bytes of another version, or a case whose meshes are others now.
    pub fn of_kept(case: &AnyCase, kept: Kept) -> Result<(Self, Instant), String> {
        let (bytes, _, count, failed, spent) = kept;
        let failure = failed.map(|(step, time, reason, carried)| Failure {
            step,
            time,
            reason,
            carried,
            refusal: None,
        });
        let unread = |why| format!("the solution cannot be read from its pickle: {why}");
        let run = match case {
            AnyCase::Plane(case) => Self::Plane(dotyk::case::Run {
                steps: case.model.read_solutions(&bytes).map_err(unread)?,
                count,
                failure,
            }),
            AnyCase::Space(case) => Self::Space(dotyk::case::Run {
                steps: case.model.read_solutions(&bytes).map_err(unread)?,
                count,
                failure,
            }),
        };
        let now = Instant::now();
        let spent = Duration::try_from_secs_f64(spent).unwrap_or_default();
        Ok((run, now.checked_sub(spent).unwrap_or(now)))
    }
}

/// The solved load steps, and the reason if they end early.
#[pyclass(frozen, module = "dotyk._dotyk")]
pub struct Run {
    case: Arc<AnyCase>,
    run: Arc<AnyRun>,
    origin: Origin,
    spent: Duration,
    caller: Arc<Caller>,
    beside: Arc<Beside>,
    how: How,
}

/// Does the same with a case and its run, of the plane or of space; they are always of the same kind.
macro_rules! of_both {
    ($own:expr, |$case:ident, $run:ident| $body:expr) => {
        match (&*$own.case, &*$own.run) {
            (AnyCase::Plane($case), AnyRun::Plane($run)) => Ok($body),
            (AnyCase::Space($case), AnyRun::Space($run)) => Ok($body),
            _ => Err("a run of another case".to_string()),
        }
    };
}

#[pymethods]
impl Run {
    /// Why it ended early, in words, and whether the input was wrong; `None` if it did not.
    #[getter]
    fn failure(&self) -> Option<(String, bool)> {
        let (text, refusal) = match &*self.run {
            AnyRun::Plane(run) => (run.to_string(), run.failure.as_ref().map(|f| &f.refusal)),
            AnyRun::Space(run) => (run.to_string(), run.failure.as_ref().map(|f| &f.refusal)),
        };
        let refusal: &Option<CaseError> = refusal?;
        Some(match refusal {
            Some(error) => (self.origin.told(error), true),
            None => (text, false),
        })
    }

    /// Number of steps that have an answer, or one, the last iterate, where none has.
    #[getter]
    fn steps(&self) -> usize {
        match &*self.run {
            AnyRun::Plane(run) => run.standing().len(),
            AnyRun::Space(run) => run.standing().len(),
        }
    }

    /// `summary.json`.
    fn summary(&self, py: Python<'_>) -> PyResult<String> {
        self.recorded(py, |own| {
            of_both!(own, |case, run| own.record(case, run).summary())
        })
    }

    /// `report.html`.
    fn report(&self, py: Python<'_>) -> PyResult<String> {
        self.recorded(py, |own| {
            of_both!(own, |case, run| own.record(case, run).report())
        })
    }

    /// `contact.csv`.
    fn contact_csv(&self, py: Python<'_>) -> PyResult<String> {
        self.recorded(py, |own| {
            of_both!(own, |case, run| own.record(case, run).contact_csv())
        })
    }

    /// The VTU file of a body in a step.
    fn vtu(&self, py: Python<'_>, step: usize, index: usize) -> PyResult<String> {
        self.recorded(py, move |own| {
            of_both!(own, |case, run| own.record(case, run).body_vtu(step, index))
        })
    }

    /// The figures of the report: titles and markup.
    fn figures(&self, py: Python<'_>) -> PyResult<Vec<(String, String)>> {
        self.recorded(py, |own| {
            of_both!(own, |case, run| Ok(own.record(case, run).figures()))
        })
    }

    /// Writes all files of the command into a folder; their paths.
    fn write(&self, py: Python<'_>, folder: PathBuf) -> PyResult<Vec<PathBuf>> {
        self.recorded(py, move |own| {
            of_both!(own, |case, run| {
                let record = own.record(case, run);
                let written = output::Folder::wait(&folder).and_then(|held| record.write(&held));
                written.map(|written| written.files)
            })
        })
    }

    /// A probe of a step by the keys of its table as text: value, place, line (s, points, values).
    fn probe(&self, py: Python<'_>, step: usize, text: String) -> PyResult<Py<PyAny>> {
        let own = self.clone();
        let read = wait(py, &self.caller, None, move |_| {
            of_both!(own, |case, run| case.probe(&text, &run.standing()[step]))
        })?;
        let read = read.map_err(|error| errors::input(py, error))?;
        let value = read.map_err(|error| errors::of_case(py, &error, &Origin::Python))?;
        if value.line.is_empty() {
            return Ok(value.value.into_pyobject(py)?.into_any().unbind());
        }
        let s: Vec<f64> = value.line.iter().map(|place| place.s).collect();
        let points: Vec<[f64; 3]> = value.line.iter().map(|place| place.point).collect();
        let values: Vec<f64> = value.line.iter().map(|place| place.value).collect();
        let arrays = (
            PyArray1::from_vec(py, s),
            rows(py, points)?,
            PyArray1::from_vec(py, values),
        );
        Ok(arrays.into_pyobject(py)?.into_any().unbind())
    }

    /// Arrays of a body in a step.
    fn body<'py>(
        &self,
        py: Python<'py>,
        step: usize,
        index: usize,
    ) -> PyResult<Bound<'py, PyDict>> {
        let dict = of_both!(self, |case, run| {
            let solution = &run.standing()[step];
            body_arrays(py, &case.model.stage(solution.time), solution, index)
        });
        dict.map_err(|error| errors::input(py, error))?
    }

    /// Arrays of a contact in a step.
    fn contact<'py>(
        &self,
        py: Python<'py>,
        step: usize,
        index: usize,
    ) -> PyResult<Bound<'py, PyDict>> {
        let dict = of_both!(self, |_case, run| {
            contact_arrays(py, &run.standing()[step].contacts[index].nodes)
        });
        dict.map_err(|error| errors::input(py, error))?
    }

    /// The mesh of a body in a step.
    fn mesh(&self, py: Python<'_>, step: usize, index: usize) -> PyResult<crate::mesh::Mesh> {
        let mesh = match (&*self.case, &*self.run) {
            (AnyCase::Plane(case), AnyRun::Plane(run)) => {
                let stage = case.model.stage(run.standing()[step].time);
                let body = &stage.bodies[index];
                dotyk::case::GivenMesh::Plane(Arc::clone(&body.mesh), body.points.clone())
            }
            (AnyCase::Space(case), AnyRun::Space(run)) => {
                let stage = case.model.stage(run.standing()[step].time);
                let body = &stage.bodies[index];
                dotyk::case::GivenMesh::Space(Arc::clone(&body.mesh), body.points.clone())
            }
            _ => return Err(errors::internal(py)),
        };
        Ok(crate::mesh::Mesh::of_given(mesh))
    }

    /// Convergence history of a step: iterations, residuals, active.
    fn history(&self, step: usize) -> Vec<(usize, f64, usize)> {
        let of = |points: &[dotyk::model::HistoryPoint]| {
            points
                .iter()
                .map(|p| (p.iteration, p.residual, p.active))
                .collect()
        };
        match &*self.run {
            AnyRun::Plane(run) => of(&run.standing()[step].solver.history),
            AnyRun::Space(run) => of(&run.standing()[step].solver.history),
        }
    }

    /// What makes its case again: the arguments of `Case.of_text`.
    fn arguments(&self, py: Python<'_>) -> Arguments {
        self.beside.arguments(py, &self.case)
    }

    /// What makes it of its case, by `Case.restored`.
    fn kept(&self, py: Python<'_>) -> PyResult<Kept> {
        let own = self.clone();
        let kept = wait(py, &self.caller, None, move |_| {
            of_both!(own, |case, run| {
                let record = Record {
                    steps: &run.steps,
                    ..own.record(case, run)
                };
                let failed = run.failure.as_ref();
                let failed = failed.map(|f| (f.step, f.time, f.reason.clone(), f.carried));
                let spent = own.spent.as_secs_f64();
                (
                    record.solutions(),
                    own.how.clone(),
                    run.count,
                    failed,
                    spent,
                )
            })
        })?;
        kept.map_err(|error| errors::input(py, error))
    }

    /// Name of the case.
    #[getter]
    fn stem(&self) -> String {
        of_any!(&*self.case, |case| case.stem.clone())
    }
}

impl Clone for Run {
    fn clone(&self) -> Self {
        Self {
            case: Arc::clone(&self.case),
            run: Arc::clone(&self.run),
            origin: self.origin.clone(),
            caller: Arc::clone(&self.caller),
            beside: Arc::clone(&self.beside),
            how: self.how.clone(),
            ..*self
        }
    }
}

impl Run {
    /// The results of a case; what it comes from, and when its reading began; who solved it, what it is made of, and how it was solved.
    pub fn new(
        case: Arc<AnyCase>,
        run: AnyRun,
        (origin, since): (Origin, Instant),
        (caller, beside, how): (Arc<Caller>, Arc<Beside>, How),
    ) -> Self {
        Self {
            case,
            run: Arc::new(run),
            origin,
            spent: since.elapsed(),
            caller,
            beside,
            how,
        }
    }

    fn record<'a, const D: usize>(
        &self,
        case: &'a Case<D>,
        run: &'a dotyk::case::Run<D>,
    ) -> Record<'a, D> {
        let now = Instant::now();
        Record {
            model: &case.model,
            steps: run.standing(),
            stem: &case.stem,
            failed: run.failed_step().map(|failure| FailedStep {
                step: failure.step,
                time: failure.time,
                reason: failure.reason.clone(),
                carried: failure.carried,
            }),
            since: now.checked_sub(self.spent).unwrap_or(now),
            beside: &[],
        }
    }

    /// Does something with the record without the interpreter's lock.
    fn recorded<T: Send + 'static>(
        &self,
        py: Python<'_>,
        work: impl FnOnce(&Self) -> Result<Result<T, output::Error>, String> + Send + 'static,
    ) -> PyResult<T> {
        let own = self.clone();
        let done = wait(py, &self.caller, None, move |_| {
            work(&own).map(|done| done.map_err(|error| error.to_string()))
        })?;
        done.and_then(|done| done)
            .map_err(|error| errors::input(py, error))
    }
}

fn body_arrays<'py, const D: usize>(
    py: Python<'py>,
    model: &dotyk::model::Model<D>,
    solution: &Solution<D>,
    index: usize,
) -> PyResult<Bound<'py, PyDict>> {
    let (body, answer) = (&model.bodies[index], &solution.bodies[index]);
    let dict = PyDict::new(py);
    let points = |list: &[[f64; D]]| rows(py, list.to_vec());
    dict.set_item("points", points(body.mesh.points())?)?;
    dict.set_item("shown", points(&answer.shown())?)?;
    // values at the nodes: on a border between materials those of the material with the largest stress
    let stressed = answer.borders.largest(&answer.von_mises);
    let cells = PyDict::new(py);
    for field in answer.fields() {
        if field.on == On::Cells {
            cells.set_item(field.name, of_cells(py, &field)?)?;
            continue;
        }
        let at = |place: usize, k: usize| field.values[place * field.shape.components() + k];
        let of_nodes = match field.shape {
            Shape::Number => {
                let places = answer.borders.largest(&field.values).into_iter();
                PyArray1::from_vec(py, places.map(|place| at(place, 0)).collect()).into_any()
            }
            Shape::Vector => {
                let nodes = 0..body.mesh.points().len();
                let vector = |node| std::array::from_fn::<f64, D, _>(|k| at(node, k));
                rows(py, nodes.map(vector).collect())?.into_any()
            }
            Shape::Tensor => {
                let tensor = |&place: &usize| std::array::from_fn::<f64, 6, _>(|k| at(place, k));
                rows(py, stressed.iter().map(tensor).collect())?.into_any()
            }
            Shape::Principal => {
                let values = |&place: &usize| std::array::from_fn::<f64, 3, _>(|k| at(place, k));
                rows(py, stressed.iter().map(values).collect())?.into_any()
            }
        };
        dict.set_item(field.name, of_nodes)?;
    }
    dict.set_item("cells", cells)?;
    Ok(dict)
}

/// Values of a field of cells, (cells,) or (cells, components).
fn of_cells<'py>(py: Python<'py>, field: &BodyField) -> PyResult<Bound<'py, PyAny>> {
    let values = PyArray1::from_slice(py, &field.values);
    Ok(match field.shape.components() {
        1 => values.into_any(),
        count => values
            .reshape([field.values.len() / count, count])?
            .into_any(),
    })
}

fn contact_arrays<'py, const D: usize>(
    py: Python<'py>,
    nodes: &[ContactNode<D>],
) -> PyResult<Bound<'py, PyDict>> {
    let dict = PyDict::new(py);
    let number = |value: fn(&ContactNode<D>) -> f64| {
        let values: Vec<f64> = nodes.iter().map(value).collect();
        PyArray1::from_vec(py, values)
    };
    let vector =
        |value: fn(&ContactNode<D>) -> [f64; D]| rows(py, nodes.iter().map(value).collect());
    let node: Vec<i64> = nodes.iter().map(|n| n.node as i64).collect();
    dict.set_item("node", PyArray1::from_vec(py, node))?;
    dict.set_item("points", vector(|n| n.point)?)?;
    dict.set_item("normal", vector(|n| n.normal)?)?;
    dict.set_item("weight", number(|n| n.weight))?;
    dict.set_item("gap", number(|n| n.gap))?;
    dict.set_item("pressure", number(|n| n.pressure))?;
    // in the plane: components along the tangent of the side, which has the body on its left
    if D == 2 {
        let along = |v: &[f64; D], n: &[f64; D]| v[1] * n[0] - v[0] * n[1];
        let shear: Vec<f64> = nodes.iter().map(|n| along(&n.shear, &n.normal)).collect();
        let slip: Vec<f64> = nodes.iter().map(|n| along(&n.slip, &n.normal)).collect();
        dict.set_item("shear", PyArray1::from_vec(py, shear))?;
        dict.set_item("slip", PyArray1::from_vec(py, slip))?;
    } else {
        dict.set_item("shear", vector(|n| n.shear)?)?;
        dict.set_item("slip", vector(|n| n.slip)?)?;
    }
    let status: Vec<&str> = nodes.iter().map(|n| n.status.name()).collect();
    dict.set_item("status", status)?;
    Ok(dict)
}
