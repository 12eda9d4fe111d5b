//! Work that the interpreter waits for without holding its lock: on a thread of its own, while the calling thread looks for signals
//! and answers what the work asks of Python.
//!
//! Callables are called on the thread that asked for the work, one at a time. An exception, Ctrl-C among them, ends the wait at
//! once; the work unwinds at the next thing that it tells or asks. The next piece of work knows nothing of it.

use crate::errors;
use pyo3::prelude::*;
use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread::Builder;
use std::time::Duration;

/// How often signals are looked for.
const PATIENCE: Duration = Duration::from_millis(50);

/// Deep recursion of factorisations and of readers has room.
const STACK: usize = 64 << 20;

/// Something to do with the interpreter.
type Call = Box<dyn FnOnce(Python<'_>) + Send>;

/// What the work unwinds with when nobody wants its result any more.
struct Ended;

/// What a mutex guards, also after a panic elsewhere.
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
            // whoever asked may have gone
            Ok(value) => drop(reply.send(value)),
            Err(error) => work.end(Some(error)),
        });
        // nobody hears it where the wait is over
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

/// Whom the functions of a case ask: the pieces of work that go on, each of which has somebody who waits.
#[derive(Default)]
pub struct Caller(Mutex<Vec<Arc<Work>>>);

impl Caller {
    /// As [`Work::ask`] of the last piece of work that has an answer; `None` where none has.
    pub fn ask<T: Send + 'static>(
        &self,
        call: impl FnOnce(Python<'_>) -> PyResult<T> + Clone + Send + 'static,
    ) -> Option<T> {
        let works = locked(&self.0).clone();
        works.iter().rev().find_map(|work| work.ask(call.clone()))
    }
}

/// Does work on a thread of its own, with so many threads for its parallel parts, or one for each processor, and waits for it.
///
/// Errors: an exception of what the work asked for, of a signal handler; threads that cannot be started; a panic.
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
            // threads of its own: a process that is forked has none of those that its parent had
            let pool = dotyk::host::threads(threads)?;
            let pool = pool.build().map_err(|error| error.to_string())?;
            Ok::<_, String>(pool.install(|| work(&shared)))
        }));
        // whoever waits looks for it at once
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
