//! Progress on standard error: silent unless it is a terminal.

use dotyk::model::{Event, HistoryPoint};
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use std::io::IsTerminal;
use std::time::{Duration, Instant};

/// A line that tells the stage and the iteration, and one finished line for each stage.
pub struct Progress {
    bar: ProgressBar,
    /// The load step before every message, where there are several.
    step: String,
    stage: Option<(&'static str, Instant)>,
}

/// A line that is drawn on terminals, unless it is to be quiet.
fn bar(length: Option<u64>, quiet: bool) -> ProgressBar {
    let visible = !quiet && std::io::stderr().is_terminal();
    let target = if visible {
        ProgressDrawTarget::stderr()
    } else {
        ProgressDrawTarget::hidden()
    };
    // both templates are right: their test draws them
    let style = ProgressStyle::with_template(match length {
        Some(_) => "  {msg}{wide_bar} {pos} of {len}, {eta} left",
        None => "  {wide_msg} {elapsed}",
    });
    let bar = ProgressBar::with_draw_target(length, target)
        .with_style(style.unwrap_or_else(|_| ProgressStyle::default_spinner()));
    if visible {
        bar.enable_steady_tick(Duration::from_millis(100));
    }
    bar
}

/// How many of a known number are done.
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

    /// One more is done; from any thread.
    pub fn one_more(&self) {
        self.bar.inc(1);
    }

    /// Clears the line.
    pub fn finish(self) {
        self.bar.finish_and_clear();
    }
}

impl Progress {
    /// Silent with `quiet`, and where standard error is not a terminal.
    pub fn new(quiet: bool) -> Self {
        Self {
            bar: bar(None, quiet),
            step: String::new(),
            stage: None,
        }
    }

    /// Says what is being worked on before the first stage.
    pub fn announce(&self, what: &str) {
        self.bar.set_message(what.to_string());
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

    /// Clears the line: what follows on standard error starts afresh.
    pub fn finish(mut self) {
        self.end_stage();
        self.bar.finish_and_clear();
    }

    fn end_stage(&mut self) {
        if let Some((name, start)) = self.stage.take() {
            let seconds = start.elapsed().as_secs_f64();
            self.bar.println(format!("  {name:<12} {seconds:8.3} s"));
        }
    }
}
