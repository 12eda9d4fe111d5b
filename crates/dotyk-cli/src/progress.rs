//! Progress on standard error: silent unless it is a terminal.

use crate::text::is_silent;
use dotyk::model::{Event, HistoryPoint, Work};
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressState, ProgressStyle};
use std::fmt;
use std::io::IsTerminal;
use std::sync::atomic::Ordering;
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

/// A line with the stage and the iteration, and one finished line for each stage.
pub struct Progress {
    bar: ProgressBar,
    /// The load step before every message, where there are several.
    step: String,
    stage: Option<(&'static str, Instant)>,
    /// The factorisation in progress.
    factoring: Arc<Mutex<Option<Arc<Work>>>>,
}

/// A line that is drawn on terminals, unless `quiet`.
fn bar(length: Option<u64>, quiet: bool) -> ProgressBar {
    let visible = !quiet && !is_silent() && std::io::stderr().is_terminal();
    let target = if visible {
        ProgressDrawTarget::stderr()
    } else {
        ProgressDrawTarget::hidden()
    };
    // both templates are valid: a test draws them
    let style = ProgressStyle::with_template(match length {
        Some(_) => "  {msg}{wide_bar} {pos} of {len}, {eta} left",
        None => "  {wide_msg} {work} {elapsed}",
    });
    let bar = ProgressBar::with_draw_target(length, target)
        .with_style(style.unwrap_or_else(|_| ProgressStyle::default_spinner()));
    if visible {
        bar.enable_steady_tick(Duration::from_millis(100));
    }
    bar
}

/// The finished share of a factorisation, the memory of its factors, and the remaining time at the present rate.
fn share(work: &Work, elapsed: Duration) -> String {
    let bytes = work.bytes.load(Ordering::Relaxed) as f64;
    let size = match bytes < 1e9 {
        true => format!("{:.0} MB", (bytes / 1e6).ceil()),
        false => format!("{:.1} GB", bytes / 1e9),
    };
    let part = work.part();
    let left = elapsed.as_secs_f64() * (1.0 - part) / part;
    let all = work.all.load(Ordering::Relaxed) as f64 / 1e9;
    match (part > 0.02, left >= 1.0) {
        (false, _) => format!("{all:.0} Gflop, {size} of factors"),
        (true, true) => format!(
            "{:.0} %, about {left:.0} s left, {size} of factors",
            100.0 * part
        ),
        (true, false) => format!("{:.0} %, {size} of factors", 100.0 * part),
    }
}

/// A progress bar over a known number of items.
pub struct Count {
    bar: ProgressBar,
}

impl Count {
    /// Silent with `quiet`, and where standard error is not a terminal.
    pub fn new(all: usize, quiet: bool) -> Self {
        Self {
            bar: bar(Some(all as u64), quiet),
        }
    }

    /// Counts one more finished item; from any thread.
    pub fn one_more(&self) {
        self.bar.inc(1);
    }

    /// Prints while the line is hidden.
    pub fn aside<T>(&self, print: impl FnOnce() -> T) -> T {
        self.bar.suspend(print)
    }

    /// Clears the line.
    pub fn finish(self) {
        self.bar.finish_and_clear();
    }
}

impl Progress {
    /// Silent with `quiet`, and where standard error is not a terminal.
    pub fn new(quiet: bool) -> Self {
        let factoring: Arc<Mutex<Option<Arc<Work>>>> = Arc::default();
        let looked_at = Arc::clone(&factoring);
        // drawn at every tick, while the work goes on elsewhere
        let draw = move |state: &ProgressState, out: &mut dyn fmt::Write| {
            let work = looked_at.lock().ok().and_then(|work| work.clone());
            if let Some(work) = work {
                // the work goes on even if the line cannot be drawn
                let _ = write!(out, "{}", share(&work, state.elapsed()));
            }
        };
        let bar = bar(None, quiet);
        let style = bar.style().with_key("work", draw);
        bar.set_style(style);
        Self {
            bar,
            step: String::new(),
            stage: None,
            factoring,
        }
    }

    /// Takes note of an event.
    pub fn observe(&mut self, event: Event) {
        match event {
            Event::Step { steps: 1, .. } => {}
            Event::Step { step, steps, time } => {
                self.end_stage();
                self.step = format!("step {step} of {steps}: ");
                self.bar
                    .println(format!("step {step} of {steps}, t = {time}"));
            }
            Event::Stage(name) => {
                self.end_stage();
                self.stage = Some((name, Instant::now()));
                self.bar.set_message(format!("{}{name}", self.step));
            }
            Event::Factoring(work) => self.look_at(Some(work)),
            Event::Iteration(HistoryPoint {
                iteration,
                residual,
                active,
            }) => {
                let step = &self.step;
                let stage = self.stage.map_or("", |(name, _)| name);
                self.bar.set_message(format!(
                    "{step}{stage}: iteration {iteration}, residual {residual:.1e}, {active} active"
                ));
            }
        }
    }

    /// Clears the line: later output on standard error starts on an empty line.
    pub fn finish(mut self) {
        self.end_stage();
        self.bar.finish_and_clear();
    }

    fn look_at(&self, work: Option<Arc<Work>>) {
        self.bar.reset_elapsed();
        if let Ok(mut factoring) = self.factoring.lock() {
            *factoring = work;
        }
    }

    fn end_stage(&mut self) {
        self.look_at(None);
        if let Some((name, start)) = self.stage.take() {
            let seconds = start.elapsed().as_secs_f64();
            self.bar.println(format!("  {name:<12} {seconds:8.3} s"));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_rest_takes_as_long_as_it_has_gone_so_far() {
        let work = Work {
            all: 4_000.into(),
            done: 1_000.into(),
            bytes: 5_140_000_000.into(),
        };
        let told = |seconds| share(&work, Duration::from_secs(seconds));
        assert_eq!(told(10), "25 %, about 30 s left, 5.1 GB of factors");
        // a remaining time below one second is not shown
        assert_eq!(told(0), "25 %, 5.1 GB of factors");
        assert_eq!(
            share(&Work::default(), Duration::ZERO),
            "0 Gflop, 0 MB of factors"
        );
    }
}
