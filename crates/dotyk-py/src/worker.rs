//! Work that the interpreter waits for without holding its lock: on a thread of its own, while the calling thread looks for signals
//! and answers what the work asks of Python.
//!
//! Callables are called on the thread that asked for the work, one at a time. An exception, Ctrl-C among them, ends the wait at
//! once; the work unwinds at the next thing that it tells or asks.

use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;
use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::Builder;
use std::time::Duration;

/// How often signals are looked for.
const PATIENCE: Duration = Duration::from_millis(50);

/// Deep recursion of factorisations and of readers has room.
const STACK: usize = 64 << 20;

/// Something to do with the interpreter.
type Call = Box<dyn FnOnce(Python<'_>) + Send>;

/// The way from the work to the thread that waits for it.
#[derive(Default)]
pub struct Caller {
    /// Nobody waits where there is none.
    calls: Mutex<Option<Sender<Call>>>,
    raised: Mutex<Option<PyErr>>,
    ended: AtomicBool,
}

/// What the work unwinds with when nobody wants its result any more.
struct Ended;

fn locked<T>(mutex: &Mutex<T>) -> std::sync::MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Caller {
    /// Whether the result is still wanted.
    pub fn is_ended(&self) -> bool {
        self.ended.load(Ordering::Relaxed)
    }

    /// Unwinds where the result is not wanted any more.
    pub fn go_on(&self) {
        if self.is_ended() {
            resume_unwind(Box::new(Ended));
        }
    }

    fn end(&self, error: Option<PyErr>) {
        if let Some(error) = error {
            locked(&self.raised).get_or_insert(error);
        }
        self.ended.store(true, Ordering::Relaxed);
    }

    /// Does something with the interpreter, on the thread that waits if there is one; `None` where it raised an exception, or
    /// where something before it has.
    pub fn ask<T: Send + 'static>(
        self: &Arc<Self>,
        work: impl FnOnce(Python<'_>) -> PyResult<T> + Send + 'static,
    ) -> Option<T> {
        if self.is_ended() {
            return None;
        }
        let sender = locked(&self.calls).clone();
        let Some(sender) = sender else {
            return Python::attach(|py| self.told(work(py)));
        };
        let (reply, answer) = channel();
        let caller = Arc::clone(self);
        let call: Call = Box::new(move |py| {
            // whoever asked may have gone
            let _ = reply.send(caller.told(work(py)));
        });
        sender.send(call).ok()?;
        answer.recv().ok().flatten()
    }

    fn told<T>(&self, result: PyResult<T>) -> Option<T> {
        result.map_err(|error| self.end(Some(error))).ok()
    }
}

/// Does work on a thread of its own, with so many threads for its parallel parts, and waits for it.
///
/// Errors: an exception of what the work asked for, of a signal handler; threads that cannot be started.
pub fn wait<T: Send + 'static>(
    py: Python<'_>,
    caller: &Arc<Caller>,
    threads: Option<usize>,
    work: impl FnOnce(&Arc<Caller>) -> T + Send + 'static,
) -> PyResult<T> {
    let (calls, called) = channel::<Call>();
    *locked(&caller.calls) = Some(calls);
    let own = Arc::clone(caller);
    let (done, finished) = channel();
    let all = move || {
        let result = catch_unwind(AssertUnwindSafe(|| match threads {
            None => Ok(work(&own)),
            Some(threads) => rayon::ThreadPoolBuilder::new()
                .num_threads(threads)
                .build()
                .map(|pool| pool.install(|| work(&own)))
                .map_err(|error| error.to_string()),
        }));
        // the sender goes with the work: who waits for calls wakes up
        *locked(&own.calls) = None;
        let _ = done.send(result);
    };
    let started = Builder::new().stack_size(STACK).spawn(all);
    started.map_err(|error| PyRuntimeError::new_err(format!("cannot start a thread: {error}")))?;
    answer(py, caller, Mutex::new(called))?;
    let result = py.detach(move || finished.recv());
    if let Some(error) = locked(&caller.raised).take() {
        return Err(error);
    }
    match result {
        Ok(Ok(Ok(value))) => Ok(value),
        Ok(Ok(Err(error))) => Err(PyRuntimeError::new_err(error)),
        _ => Err(crate::errors::internal(py)),
    }
}

/// Answers calls until the work is done, or its result is not wanted any more.
fn answer(py: Python<'_>, caller: &Arc<Caller>, called: Mutex<Receiver<Call>>) -> PyResult<()> {
    loop {
        match py.detach(|| locked(&called).recv_timeout(PATIENCE)) {
            Ok(call) => call(py),
            Err(RecvTimeoutError::Timeout) => {}
            Err(RecvTimeoutError::Disconnected) => return Ok(()),
        }
        if let Err(error) = py.check_signals() {
            caller.end(None);
            return Err(error);
        }
        if caller.is_ended() {
            let raised = locked(&caller.raised).take();
            return Err(raised.unwrap_or_else(|| crate::errors::internal(py)));
        }
    }
}
