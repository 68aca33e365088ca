//! Progress on standard error: a bar with the time left on a terminal, now and then a line elsewhere.

use super::{terminal, warn};
use indicatif::{ProgressBar, ProgressStyle};
use std::{
    io::{IsTerminal, stderr},
    sync::Mutex,
    time::{Duration, Instant},
};

/// Narrow enough that name, step, time left and a short message fit a line of 80 columns. What is longer is cut.
const TEMPLATE: &str = "{prefix} {bar:12} {pos}/{len}, {eta} left, {wide_msg}";

/// Progress of some work that is done in steps.
pub struct Progress {
    bar: Option<ProgressBar>,
    name: String,
    steps: usize,
    /// Has anything been shown?
    is_started: bool,
    /// Tenths of the steps that lines have been printed for.
    tenths: usize,
}

impl Progress {
    /// Before the first of `steps` steps.
    pub fn new(name: &str, steps: usize) -> Self {
        let shown = stderr().is_terminal() && !terminal::is_quiet();
        let bar = shown.then(|| {
            let bar = ProgressBar::new(steps as u64);
            let style = ProgressStyle::with_template(TEMPLATE);
            bar.set_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()));
            bar.set_prefix(name.to_string());
            bar
        });
        Self {
            bar,
            name: name.to_string(),
            steps,
            is_started: false,
            tenths: 0,
        }
    }

    /// It is so many steps in all, if that was not known before the first.
    pub fn of(&mut self, steps: usize) {
        self.steps = steps;
        if let Some(bar) = &self.bar {
            bar.set_length(steps as u64);
        }
    }

    /// `step` steps are done; `message` says how it stands.
    pub fn at(&mut self, step: usize, message: &str) {
        match &self.bar {
            Some(bar) => {
                bar.set_position(step as u64);
                if !self.is_started && step > 0 {
                    bar.reset_eta(); // steps done in an earlier run took no time of this one
                }
                if bar.message() != message {
                    bar.set_message(message.to_string());
                }
            }
            None if terminal::is_quiet() => {}
            None => {
                let tenths = step * 10 / self.steps.max(1);
                if tenths > self.tenths {
                    self.tenths = tenths;
                    warn(&format!(
                        "{}: {step} of {}, {message}",
                        self.name, self.steps
                    ));
                }
            }
        }
        self.is_started = true;
    }

    /// Takes the bar away.
    pub fn done(self) {
        if let Some(bar) = self.bar {
            bar.finish_and_clear();
        }
    }
}

/// Work that mostly ends at once takes so long before anything is shown of it.
const PATIENCE: Duration = Duration::from_secs(1);

/// Progress of work that many threads do, shown only where it lasts.
pub struct PatientProgress {
    name: &'static str,
    began: Instant,
    shown: Mutex<Option<Progress>>,
}

impl PatientProgress {
    /// Before the work.
    pub fn new(name: &'static str) -> Self {
        Self {
            name,
            began: Instant::now(),
            shown: Mutex::new(None),
        }
    }

    /// `done` of `of` steps are done, as one of the threads sees it. A thread that finds another one showing goes on.
    pub fn at(&self, done: usize, of: usize, message: &str) {
        if self.began.elapsed() < PATIENCE {
            return;
        }
        if let Ok(mut shown) = self.shown.try_lock() {
            let progress = shown.get_or_insert_with(|| Progress::new(self.name, of));
            progress.at(done, message);
        }
    }

    /// Takes the bar away.
    pub fn done(self) {
        if let Ok(Some(progress)) = self.shown.into_inner() {
            progress.done();
        }
    }
}
