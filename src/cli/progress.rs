//! Progress for the one who waits: a bar with the time left on a terminal, now and then a line elsewhere.

use super::warn;
use indicatif::{ProgressBar, ProgressStyle};
use std::io::{IsTerminal, stderr};

/// Progress of some work that is done in steps, on standard error.
pub struct Progress {
    bar: Option<ProgressBar>,
    what: String,
    steps: usize,
    /// Tenths already told in lines.
    tenths: usize,
}

impl Progress {
    /// Before the first of `steps` steps.
    pub fn new(what: &str, steps: usize) -> Self {
        let bar = stderr().is_terminal().then(|| {
            let bar = ProgressBar::new(steps as u64);
            let style = ProgressStyle::with_template(
                "{prefix} {bar:20} {pos}/{len} · {eta} left · {wide_msg}",
            );
            bar.set_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()));
            bar.set_prefix(what.to_string());
            bar
        });
        Self {
            bar,
            what: what.to_string(),
            steps,
            tenths: 0,
        }
    }

    /// `step` steps are done; `message` says how it stands.
    pub fn at(&mut self, step: usize, message: &str) {
        match &self.bar {
            Some(bar) => {
                bar.set_position(step as u64);
                bar.set_message(message.to_string());
            }
            None => {
                let tenths = step * 10 / self.steps.max(1);
                if tenths > self.tenths {
                    self.tenths = tenths;
                    warn(&format!(
                        "{}: {step} of {} · {message}",
                        self.what, self.steps
                    ));
                }
            }
        }
    }

    /// Takes the bar away.
    pub fn done(self) {
        if let Some(bar) = self.bar {
            bar.finish_and_clear();
        }
    }
}
