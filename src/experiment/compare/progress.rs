//! How far a comparison is, for whoever waits for it.

/// How far a comparison is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Progress<'a> {
    /// Datasets, trainings and cells done.
    pub done: usize,
    /// Of so many.
    pub all: usize,
    /// What is being done.
    pub now: &'a str,
}

/// Counts what is done and reports it.
pub(super) struct ProgressCounter<'a> {
    begun: usize,
    all: usize,
    report: &'a mut dyn FnMut(Progress),
}

impl<'a> ProgressCounter<'a> {
    /// Before the first of so many steps.
    pub fn new(all: usize, report: &'a mut dyn FnMut(Progress)) -> Self {
        Self {
            begun: 0,
            all,
            report,
        }
    }

    /// The next step begins.
    pub fn next(&mut self, now: &str) {
        self.begun += 1;
        self.meanwhile(now);
    }

    /// The step goes on.
    pub fn meanwhile(&mut self, now: &str) {
        (self.report)(Progress {
            done: self.begun.saturating_sub(1),
            all: self.all,
            now,
        });
    }
}
