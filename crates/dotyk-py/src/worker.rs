//! Work that the interpreter waits for without holding its lock: it runs on a thread of its own, while the calling thread checks for
//! signals and answers the calls of the work into Python.
//!
//! Callables are called on the thread that asked for the work, one at a time. An exception, Ctrl-C among them, ends the wait at
//! once; the work unwinds at its next event or call. The next piece of work is not affected.

use crate::errors;
use pyo3::prelude::*;
use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread::Builder;
use std::time::Duration;

/// Interval between checks for signals.
const PATIENCE: Duration = Duration::from_millis(50);

/// Stack of the working thread, in bytes: factorisations and readers recurse deeply.
const STACK: usize = 64 << 20;

/// A call that needs the interpreter.
type Call = Box<dyn FnOnce(Python<'_>) + Send>;

/// Payload of the unwinding when the result is not wanted any more.
struct Ended;

/// The contents of a mutex, also after a panic of another thread.
pub fn locked<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

/// One piece of work, and the way from it to the thread that waits for it.
pub struct Work {
    calls: Mutex<Sender<Call>>,
    raised: Mutex<Option<PyErr>>,
    ended: AtomicBool,
}

impl Work {
    /// Unwinds where the result is not wanted any more.
    pub fn go_on(&self) {
        if self.ended.load(Ordering::Relaxed) {
            resume_unwind(Box::new(Ended));
        }
    }

    /// Does something with the interpreter on the thread that waits; `None` where it raised an exception, or where the result is
    /// not wanted any more.
    pub fn ask<T: Send + 'static>(
        self: &Arc<Self>,
        call: impl FnOnce(Python<'_>) -> PyResult<T> + Send + 'static,
    ) -> Option<T> {
        let (reply, answer) = channel();
        let work = Arc::clone(self);
        let call: Call = Box::new(move |py| match call(py) {
            // an error is ignored: the receiver may have gone
            Ok(value) => drop(reply.send(value)),
            Err(error) => work.end(Some(error)),
        });
        // fails if the wait is over
        locked(&self.calls).send(call).ok()?;
        answer.recv().ok()
    }

    fn end(&self, error: Option<PyErr>) {
        if let Some(error) = error {
            locked(&self.raised).get_or_insert(error);
        }
        self.ended.store(true, Ordering::Relaxed);
    }
}

/// The running pieces of work, each with a thread that waits; the functions of a case call Python through one of them.
#[derive(Default)]
pub struct Caller(Mutex<Vec<Arc<Work>>>);

impl Caller {
    /// [`Work::ask`] of the last piece of work that gives an answer; `None` if no piece does.
    pub fn ask<T: Send + 'static>(
        &self,
        call: impl FnOnce(Python<'_>) -> PyResult<T> + Clone + Send + 'static,
    ) -> Option<T> {
        let works = locked(&self.0).clone();
        works.iter().rev().find_map(|work| work.ask(call.clone()))
    }
}

/// Does work on a thread of its own, with `threads` threads for its parallel parts (or one for each processor), and waits for it.
///
/// Errors: an exception of a call by the work or of a signal handler; threads that cannot be started; a panic.
pub fn wait<T: Send + 'static>(
    py: Python<'_>,
    caller: &Arc<Caller>,
    threads: Option<usize>,
    work: impl FnOnce(&Arc<Work>) -> T + Send + 'static,
) -> PyResult<T> {
    let (calls, called) = channel();
    let (done, finished) = channel();
    let own = Arc::new(Work {
        calls: Mutex::new(calls),
        raised: Mutex::default(),
        ended: AtomicBool::new(false),
    });
    locked(&caller.0).push(Arc::clone(&own));
    let shared = Arc::clone(&own);
    let all = move || {
        let result = catch_unwind(AssertUnwindSafe(|| {
            // an own pool: a forked process does not have the threads of its parent
            let pool = dotyk::host::threads(threads)?;
            let pool = pool.build().map_err(|error| error.to_string())?;
            Ok::<_, String>(pool.install(|| work(&shared)))
        }));
        // an empty call wakes the waiting thread
        let _ = done.send(result);
        let _ = locked(&shared.calls).send(Box::new(|_| ()));
    };
    let started = Builder::new().stack_size(STACK).spawn(all);
    let result = match started {
        Ok(_) => answer(py, &own, &Mutex::new(called), &Mutex::new(finished)),
        Err(error) => Err(errors::input(py, format!("cannot start a thread: {error}"))),
    };
    locked(&caller.0).retain(|other| !Arc::ptr_eq(other, &own));
    match result? {
        Ok(Ok(value)) => Ok(value),
        Ok(Err(error)) => Err(errors::input(py, error)),
        Err(_) => Err(errors::internal(py)),
    }
}

/// Answers calls until the work is done.
///
/// Errors: an exception of a call or of a signal handler; then the result is not wanted any more.
fn answer<T: Send>(
    py: Python<'_>,
    work: &Work,
    called: &Mutex<Receiver<Call>>,
    finished: &Mutex<Receiver<T>>,
) -> PyResult<T> {
    loop {
        match py.detach(|| locked(called).recv_timeout(PATIENCE)) {
            Ok(call) => call(py),
            Err(RecvTimeoutError::Timeout) => {}
            Err(RecvTimeoutError::Disconnected) => return Err(errors::internal(py)),
        }
        if let Err(error) = py.check_signals() {
            work.end(None);
            return Err(error);
        }
        if let Some(error) = locked(&work.raised).take() {
            return Err(error);
        }
        if let Ok(result) = locked(finished).try_recv() {
            return Ok(result);
        }
    }
}
