//! What makes sense in a recipe, and together.

use super::{ObjectiveKind, Optimiser, Recipe, Scale};
use crate::{
    belief::FilledFrom,
    error::{Error, Result},
    learning::{mean_field, objective},
};

impl Recipe {
    /// Checks everything once; what passes can be trained.
    ///
    /// # Errors
    /// Where a value makes no sense; the message names the key and what was expected.
    pub fn check(&self) -> Result<()> {
        let wrong = |key: &str, value: &dyn std::fmt::Display, expected: &str| {
            Err(Error::usage(format!(
                "{key} = {value}: expected {expected}"
            )))
        };
        let d = &self.descent;
        let (most, why) = match d.objective {
            ObjectiveKind::Exact => (objective::MAX_FEATURES, "2^n outcomes are summed exactly"),
            ObjectiveKind::MeanField => (mean_field::MAX_FEATURES, "the mean-field objective"),
        };
        if self.features == 0 || self.features > most {
            return wrong("features", &self.features, &format!("1 to {most} ({why})"));
        }
        if !(d.learning_rate.is_finite() && d.learning_rate > 0.0) {
            return wrong(
                "descent.learning_rate",
                &d.learning_rate,
                "a positive number",
            );
        }
        if !(0.0..1.0).contains(&(d.weight_decay * d.learning_rate)) {
            return wrong(
                "descent.weight_decay",
                &d.weight_decay,
                "0 or more, and less than 1/learning_rate",
            );
        }
        let a = &self.augmentation;
        let lengths = [
            ("descent.cross_entropy", d.cross_entropy),
            ("augmentation.input_noise", a.input_noise),
            ("augmentation.shift_m", a.shift_m),
            ("augmentation.turn_rad", a.turn_rad),
            ("descent.gradient_limit", d.gradient_limit),
        ];
        let fits = |length: &f64| length.is_finite() && *length >= 0.0;
        if let Some((key, value)) = lengths.into_iter().find(|(_, value)| !fits(value)) {
            return wrong(key, &value, "0 or more");
        }
        let p = &self.priors;
        let shares = [
            ("augmentation.dropped_beams", a.dropped_beams),
            ("augmentation.people", a.people.unwrap_or(0.0)),
            ("priors.stated", self.stated_share()),
            ("priors.global", p.global),
        ];
        let fits = |share: &f64| (0.0..=1.0).contains(share);
        if let Some((key, value)) = shares.into_iter().find(|(_, value)| !fits(value)) {
            return wrong(key, &value, "0 to 1");
        }
        if !(p.narrowest_m > 0.0 && p.narrowest_m <= p.widest_m && p.widest_m.is_finite()) {
            return wrong(
                "priors.narrowest_m",
                &p.narrowest_m,
                "a positive number, no more than priors.widest_m",
            );
        }
        if d.objective == ObjectiveKind::Exact && self.stated_share() < 1.0 {
            return wrong(
                "priors.stated",
                &self.stated_share(),
                "1 with the exact objective, which knows one prior for all truths",
            );
        }
        if d.objective == ObjectiveKind::Exact && d.cross_entropy > 0.0 {
            return wrong(
                "descent.cross_entropy",
                &d.cross_entropy,
                "0 with the exact objective",
            );
        }
        if d.truths_per_step == 0
            && (d.candidates_per_step > 0
                || d.leave_run_out
                || a.shift_m > 0.0
                || a.turn_rad > 0.0
                || a.dropped_beams > 0.0
                || a.people.is_some_and(|people| people > 0.0))
        {
            return wrong(
                "descent.truths_per_step",
                &d.truths_per_step,
                "at least 1 where truths are moved or blinded or candidates drawn (descent.candidates_per_step, descent.leave_run_out, \
                 augmentation.shift_m, .turn_rad, .dropped_beams, .people)",
            );
        }
        if d.truths_per_step == 0 && self.map.filled_from == FilledFrom::Rendered {
            return wrong(
                "descent.truths_per_step",
                &d.truths_per_step,
                "at least 1 where candidates are rendered beside the truths (map.filled_from = \"rendered\")",
            );
        }
        let counts = [
            ("descent.pseudo_pattern_steps", d.pseudo_pattern_steps),
            ("descent.rendered_per_step", d.rendered_per_step),
            ("descent.validate_every", d.validate_every),
            ("descent.patience", d.patience),
            ("descent.checkpoint_every", d.checkpoint_every),
            ("descent.restarts", d.restarts),
        ];
        if let Some((key, value)) = counts.into_iter().find(|(_, value)| *value == 0) {
            return wrong(key, &value, "at least 1");
        }
        if d.scale == Scale::Sum && d.objective != ObjectiveKind::Exact {
            return wrong(
                "descent.scale",
                &"sum",
                "prior_share, for the sum is one of the exact objective",
            );
        }
        if d.sequential {
            if d.objective != ObjectiveKind::Exact || !self.network.trunk.is_empty() {
                return wrong(
                    "descent.sequential",
                    &true,
                    "descent.objective = \"exact\" and no network.trunk: features that learn one after another share nothing",
                );
            }
            if d.steps < self.features {
                return wrong(
                    "descent.steps",
                    &d.steps,
                    &format!(
                        "at least one for each of {} features in sequence",
                        self.features
                    ),
                );
            }
        }
        if d.optimiser == Optimiser::ConjugateGradient {
            let forbidden = [
                ("descent.weight_decay", d.weight_decay),
                ("descent.gradient_limit", d.gradient_limit),
                ("descent.truths_per_step", d.truths_per_step as f64),
                ("augmentation.input_noise", a.input_noise),
            ];
            if let Some((key, value)) = forbidden.into_iter().find(|(_, value)| *value != 0.0) {
                return wrong(
                    key,
                    &value,
                    "0 with conjugate_gradient, which needs the same error at every step",
                );
            }
        }
        let shares = [
            (
                "map.unmodelled_probability",
                self.map.unmodelled_probability,
            ),
            (
                "map.unmodelled_when_rendered",
                self.map.unmodelled_when_rendered,
            ),
        ];
        if let Some((key, value)) = shares.into_iter().find(|(_, u)| !(0.0..1.0).contains(u)) {
            return wrong(key, &value, "0 or more, below 1");
        }
        self.map.check_most_places()?;
        self.input.check()?;
        self.network.check()?;
        self.split.check()
    }
}
