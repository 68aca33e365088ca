//! Where a training stands between two steps: enough to go on from there and end in the same bits.

use super::pseudo_patterns::PseudoPatterns;
use crate::{detector::net::Nets, learning::optimiser::Descent};

/// The state of a training between two steps.
pub struct State {
    /// The networks now.
    pub nets: Nets,
    /// Steps taken, and what the parameters remember of them.
    pub descent: Descent,
    /// What steps descend that don't evaluate the objective.
    pub pseudo_patterns: Option<PseudoPatterns>,
    /// Evaluations of the objective so far.
    pub evaluations: usize,
    /// The networks at the best validation error.
    pub best_nets: Nets,
    /// Error reduction there; none where nothing was validated yet.
    pub best_validation: Option<f64>,
    /// And the step it was reached at.
    pub best_step: usize,
    /// Error reduction of the last step's own batch.
    pub batch_error_reduction: f64,
    /// Step at which it went on from the same training with another number of steps, under another schedule.
    pub extended_at: Option<usize>,
}

impl State {
    /// Before the first step.
    pub fn start(nets: Nets, descent: Descent) -> Self {
        let best_nets = nets.clone();
        Self {
            nets,
            descent,
            pseudo_patterns: None,
            evaluations: 0,
            best_nets,
            best_validation: None,
            best_step: 0,
            batch_error_reduction: 0.0,
            extended_at: None,
        }
    }

    /// Other networks learn from now on: nothing of what was found for the last ones holds.
    pub fn begin_phase(&mut self) {
        self.descent.forget();
        self.descent.promised = 0.0;
        self.pseudo_patterns = None;
        self.best_validation = None;
        self.best_step = self.descent.steps;
    }

    /// Keeps the networks if they validate better than any before.
    pub fn keep_if_best(&mut self, validation: Option<f64>) {
        if let Some(reduction) =
            validation.filter(|r| self.best_validation.is_none_or(|best| *r > best))
        {
            self.best_validation = Some(reduction);
            self.best_step = self.descent.steps;
            self.best_nets = self.nets.clone();
        }
    }
}
