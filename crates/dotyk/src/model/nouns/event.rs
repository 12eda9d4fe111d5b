//! Events for an observer of a run, and the duration of its stages.

use crate::model::nouns::solution::HistoryPoint;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Instant;

/// An event, as passed to an observer of `Model::solve_steps_with`.
#[derive(Debug, Clone)]
pub enum Event {
    /// A load step begins; its stages and iterations follow.
    Step {
        /// From 1.
        step: usize,
        /// Number of steps of the model.
        steps: usize,
        /// Its time.
        time: f64,
    },
    /// A stage begins.
    Stage(&'static str),
    /// The bodies are factored from here on; progress may be read at any time, from any thread.
    Factoring(Arc<Work>),
    /// An iteration of the contact solver is done.
    Iteration(HistoryPoint),
}

/// Progress of the factorisations of all bodies; it may be read from any thread.
#[derive(Debug, Default)]
pub struct Work {
    /// Operations to do.
    pub all: AtomicU64,
    /// Operations on bodies that are done.
    pub done: AtomicU64,
    /// Bytes of the factors.
    pub bytes: AtomicU64,
}

impl Work {
    /// The part that is done, in [0, 1].
    pub fn part(&self) -> f64 {
        let [done, all] = [&self.done, &self.all].map(|count| count.load(Ordering::Relaxed));
        done as f64 / all.max(1) as f64
    }
}

/// A stopwatch of stages.
pub(crate) struct Lap(Instant);

impl Lap {
    pub fn start() -> Self {
        Self(Instant::now())
    }

    /// Seconds since the last call.
    pub fn seconds(&mut self) -> f64 {
        let last = std::mem::replace(&mut self.0, Instant::now());
        last.elapsed().as_secs_f64()
    }
}
