//! The dual problem of a step, and solvers written in Python.

use crate::case::{Beside, How, method_of, of_any};
use crate::errors::{self, Origin};
use crate::worker::{Caller, Work, locked, wait};
use dotyk::case::AnyCase;
use dotyk::dual::{Block, Certificate, DualProblem, Multipliers};
use dotyk::linalg::SparseVector;
use dotyk::model::{self, Error, Solution};
use dotyk::solve::{ContactSolver, Observer, Outcome, SolveError};
use numpy::{PyArray1, PyArray2, PyArrayMethods, PyReadonlyArray1};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::sync::mpsc::{Sender, channel};
use std::sync::{Arc, Mutex};

/// F is given as an array up to this number of unknowns.
const ARRAY: usize = 2000;

/// λ and α as Python hands them over.
type Forces<'py> = (PyReadonlyArray1<'py, f64>, PyReadonlyArray1<'py, f64>);

/// λ and α as Python gets them.
type Answer<'py> = (Bound<'py, PyArray1<f64>>, Bound<'py, PyArray1<f64>>);

/// Law, number of components, bound, coefficient.
type Law = (&'static str, usize, f64, f64);

enum AnyDual {
    Plane(model::Dual<2>),
    Space(model::Dual<3>),
}

/// Does the same with a dual problem of the plane and with one of space.
macro_rules! of_dual {
    ($dual:expr, |$name:ident| $body:expr) => {
        match $dual {
            AnyDual::Plane($name) => $body,
            AnyDual::Space($name) => $body,
        }
    };
}

/// A model condensed onto its contact forces at one time.
#[pyclass(frozen, module = "dotyk._dotyk")]
pub struct Dual {
    case: Arc<AnyCase>,
    dual: Arc<Mutex<AnyDual>>,
    origin: Origin,
    caller: Arc<Caller>,
    beside: Arc<Beside>,
}

/// What a dual problem is made of, copied out of it: shift, rows of G, e, blocks.
#[pyclass(frozen, module = "dotyk._dotyk")]
pub struct Problem {
    shift: Vec<f64>,
    modes: Vec<Vec<f64>>,
    load: Vec<f64>,
    blocks: Vec<Law>,
    /// F by columns; `None` where it is too large for an array.
    compliance: Option<Vec<f64>>,
    /// Channel to the thread that multiplies by F, while a solver written in Python runs.
    products: Mutex<Option<Sender<Product>>>,
}

/// A vector, and the channel for its product.
type Product = (Vec<f64>, Sender<Vec<f64>>);

#[pymethods]
impl Problem {
    #[getter]
    fn d<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        PyArray1::from_slice(py, &self.shift)
    }

    #[getter]
    fn e<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        PyArray1::from_slice(py, &self.load)
    }

    #[getter]
    fn g<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let shape = [self.modes.len(), self.shift.len()];
        PyArray1::from_vec(py, self.modes.concat()).reshape(shape)
    }

    #[getter]
    fn blocks(&self) -> Vec<Law> {
        self.blocks.clone()
    }

    /// F times a vector (m,), while the solver that got the problem is asked; `None` at other times.
    fn product<'py>(
        &self,
        py: Python<'py>,
        vector: PyReadonlyArray1<'py, f64>,
    ) -> PyResult<Option<Bound<'py, PyArray1<f64>>>> {
        let vector: Vec<f64> = vector.as_array().iter().copied().collect();
        if vector.len() != self.shift.len() {
            return Err(errors::input(py, OTHER_LENGTH));
        }
        let products = locked(&self.products).clone();
        let made = products.and_then(|products| {
            let (reply, answer) = channel();
            products.send((vector, reply)).ok()?;
            py.detach(move || answer.recv().ok())
        });
        Ok(made.map(|product| PyArray1::from_vec(py, product)))
    }

    #[getter]
    fn f<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyArray2<f64>>>> {
        let m = self.shift.len();
        let array = |values: &Vec<f64>| PyArray1::from_slice(py, values).reshape([m, m]);
        self.compliance.as_ref().map(array).transpose()
    }
}

impl Problem {
    fn of(problem: &DualProblem) -> Self {
        let m = problem.len();
        let modes = problem.balance.modes().rows();
        let blocks = problem.admissible.blocks().iter().map(law);
        Self {
            shift: problem.shift.clone(),
            modes: modes.iter().map(SparseVector::to_dense).collect(),
            load: problem.balance.load().to_vec(),
            blocks: blocks.collect(),
            compliance: (m <= ARRAY).then(|| columns(problem)),
            products: Mutex::default(),
        }
    }
}

/// Why there is no product.
const OTHER_LENGTH: &str = "the vector has another length than F";

/// F by columns, which equal its rows.
fn columns(problem: &DualProblem) -> Vec<f64> {
    let m = problem.len();
    let (mut all, mut unit) = (vec![0.0; m * m], vec![0.0; m]);
    for (k, column) in all.chunks_exact_mut(m.max(1)).enumerate() {
        unit[k] = 1.0;
        problem.compliance.apply(&unit, column);
        unit[k] = 0.0;
    }
    all
}

fn law(block: &Block) -> Law {
    let told = block.told();
    let [bound, coefficient] = [told.bound, told.coefficient].map(|v| v.unwrap_or(f64::NAN));
    (told.name, block.size(), bound, coefficient)
}

#[pymethods]
impl Dual {
    /// What the problem is made of.
    fn problem(&self, py: Python<'_>) -> PyResult<Problem> {
        self.with(py, |dual| {
            of_dual!(dual, |dual| Problem::of(dual.problem()))
        })
    }

    /// F times a vector (m,).
    fn product<'py>(
        &self,
        py: Python<'py>,
        vector: PyReadonlyArray1<'py, f64>,
    ) -> PyResult<Bound<'py, PyArray1<f64>>> {
        let x: Vec<f64> = vector.as_array().iter().copied().collect();
        let y = self.with(py, move |dual| {
            of_dual!(dual, |dual| {
                let mut y = vec![0.0; dual.problem().len()];
                (x.len() == y.len()).then(|| {
                    dual.problem().compliance.apply(&x, &mut y);
                    y
                })
            })
        })?;
        let y = y.ok_or_else(|| errors::input(py, OTHER_LENGTH))?;
        Ok(PyArray1::from_vec(py, y))
    }

    /// λ and α by one of the methods.
    fn solve<'py>(&self, py: Python<'py>, method: &str) -> PyResult<Answer<'py>> {
        let method = method_of(py, method)?;
        let solved = self.with(py, move |dual| {
            of_dual!(dual, |dual| dual.solve(method).map_err(|e| e.to_string()))
        })?;
        let solved = solved.map_err(|error| errors::not_converged(py, &error))?;
        Ok((
            PyArray1::from_vec(py, solved.lambda),
            PyArray1::from_vec(py, solved.alpha),
        ))
    }

    /// The certificate of λ and α: value, relative and limit by name.
    fn certify<'py>(&self, py: Python<'py>, forces: Forces<'py>) -> PyResult<Bound<'py, PyDict>> {
        let multipliers = multipliers(&forces);
        let certificate = self.with(py, move |dual| {
            of_dual!(dual, |dual| dual
                .certify(&multipliers)
                .map_err(|e| e.to_string()))
        })?;
        let certificate: Certificate = certificate.map_err(|error| errors::input(py, error))?;
        let dict = PyDict::new(py);
        for (name, figure) in certificate.figures() {
            dict.set_item(name, (figure.value, figure.relative, figure.limit))?;
        }
        Ok(dict)
    }

    /// The solution of λ and α as a run of one step.
    fn recover(&self, py: Python<'_>, forces: Forces<'_>) -> PyResult<crate::run::Run> {
        let multipliers = multipliers(&forces);
        let since = std::time::Instant::now();
        let run = self.with(py, move |dual| match dual {
            AnyDual::Plane(dual) => {
                run_of(dual.recover(&multipliers)).map(crate::run::AnyRun::Plane)
            }
            AnyDual::Space(dual) => {
                run_of(dual.recover(&multipliers)).map(crate::run::AnyRun::Space)
            }
        })?;
        let run = run.map_err(|error| errors::input(py, error))?;
        let case = Arc::clone(&self.case);
        Ok(crate::run::Run::new(
            case,
            run,
            (self.origin.clone(), since),
            (
                Arc::clone(&self.caller),
                Arc::clone(&self.beside),
                How::default(),
            ),
        ))
    }
}

impl Dual {
    /// The dual problem of a case at a time.
    pub fn new(
        py: Python<'_>,
        case: Arc<AnyCase>,
        time: Option<f64>,
        (origin, caller): (Origin, Arc<Caller>),
        beside: Arc<Beside>,
    ) -> PyResult<Self> {
        let shared = Arc::clone(&case);
        let dual = wait(py, &caller, None, move |_| {
            let last = of_any!(&*shared, |case| case.model.times.last().copied());
            let time = time.or(last).unwrap_or(1.0);
            Ok::<_, String>(match &*shared {
                AnyCase::Plane(case) => {
                    AnyDual::Plane(case.model.dual(time).map_err(|e| e.to_string())?)
                }
                AnyCase::Space(case) => {
                    AnyDual::Space(case.model.dual(time).map_err(|e| e.to_string())?)
                }
            })
        })?;
        let dual = dual.map_err(|error| errors::input(py, error))?;
        Ok(Self {
            case,
            dual: Arc::new(Mutex::new(dual)),
            origin,
            caller,
            beside,
        })
    }

    fn with<T: Send + 'static>(
        &self,
        py: Python<'_>,
        work: impl FnOnce(&mut AnyDual) -> T + Send + 'static,
    ) -> PyResult<T> {
        let dual = Arc::clone(&self.dual);
        wait(py, &self.caller, None, move |_| work(&mut locked(&dual)))
    }
}

fn multipliers((lambda, alpha): &Forces<'_>) -> Multipliers {
    let list = |array: &PyReadonlyArray1<'_, f64>| array.as_array().iter().copied().collect();
    Multipliers {
        lambda: list(lambda),
        alpha: list(alpha),
    }
}

/// A run of one step, converged or not.
fn run_of<const D: usize>(
    recovered: Result<Solution<D>, Error<D>>,
) -> Result<dotyk::case::Run<D>, String> {
    let (solution, failure) = match recovered {
        Ok(solution) => (solution, None),
        Err(Error::NotConverged {
            reason, solution, ..
        }) => {
            let failure = dotyk::case::Failure {
                step: 1,
                time: solution.time,
                reason: reason.to_string(),
                carried: None,
                refusal: None,
            };
            (*solution, Some(failure))
        }
        Err(error) => return Err(error.to_string()),
    };
    Ok(dotyk::case::Run {
        steps: vec![solution],
        count: 1,
        failure,
    })
}

/// A solver written in Python: a callable that gets a [`Problem`] and gives λ and α.
pub struct Own {
    callable: Arc<Py<PyAny>>,
    work: Arc<Work>,
}

impl Own {
    /// The callable, and the work that calls it.
    pub fn new(callable: Py<PyAny>, work: Arc<Work>) -> Self {
        Self {
            callable: Arc::new(callable),
            work,
        }
    }
}

impl ContactSolver for Own {
    fn name(&self) -> &str {
        "own"
    }

    fn solve(
        &self,
        problem: &DualProblem,
        _guess: Option<&Multipliers>,
        _observe: Observer<'_>,
    ) -> Result<Outcome, SolveError> {
        let (callable, mut copied) = (Arc::clone(&self.callable), Problem::of(problem));
        let (products, asked) = channel::<Product>();
        copied.products = Mutex::new(Some(products));
        let answer = std::thread::scope(|scope| {
            let answer = scope.spawn(|| {
                self.work.ask(move |py| {
                    let copied = Py::new(py, copied)?;
                    let answer = callable.call1(py, (&copied,));
                    // a problem that the user keeps gives no products any more
                    *locked(&copied.get().products) = None;
                    let answer = answer?;
                    let forces: Forces<'_> = answer.extract(py)?;
                    Ok(multipliers(&forces))
                })
            });
            for (vector, reply) in asked {
                let mut product = vec![0.0; vector.len()];
                problem.compliance.apply(&vector, &mut product);
                // an error is ignored: the wait may have ended
                let _ = reply.send(product);
            }
            answer.join().ok().flatten()
        });
        self.work.go_on();
        let answer =
            answer.ok_or_else(|| SolveError::Invalid("the solver gave no answer".to_string()))?;
        Ok(Outcome::new(answer, 1))
    }
}
