//! How much of a result is chance: the same trials answered again, with the same seed and with others.

use super::{
    convergence::{REPORTED_AT_M, converged_at_m, latest_at},
    methods::MethodContext,
    recorded_answers::RecordedAnswers,
    trial_play::judged,
    trials::Trial,
};
use crate::{error::Result, localiser::Step};
use serde::{Deserialize, Serialize};

/// A figure over several seeds.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct Spread {
    /// Its mean.
    pub mean: f64,
    /// Its standard deviation, of a sample.
    pub sd: f64,
    /// The smallest …
    pub least: f64,
    /// … and the largest.
    pub most: f64,
}

impl Spread {
    /// Of some values; none where there are fewer than two.
    pub fn over(values: &[f64]) -> Option<Self> {
        let n = values.len() as f64;
        let mean = values.iter().sum::<f64>() / n;
        let square = values
            .iter()
            .map(|value| (value - mean).powi(2))
            .sum::<f64>();
        (values.len() > 1).then(|| Self {
            mean,
            sd: (square / (n - 1.0)).sqrt(),
            least: values.iter().copied().fold(f64::INFINITY, f64::min),
            most: values.iter().copied().fold(f64::NEG_INFINITY, f64::max),
        })
    }
}

/// What came of asking somebody again about the trials that start anywhere.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct Repeats {
    /// Seeds, that of the result counted.
    pub seeds: usize,
    /// Trials that were answered otherwise though the seed was the same.
    pub trials_that_differ_with_one_seed: usize,
    /// Share of the trials that converged.
    pub converged_fraction: Option<Spread>,
    /// Mean point error after 10 m, in metres; null where no trial goes so far.
    pub point_error_at_10m_m: Option<Spread>,
}

impl Repeats {
    /// Of recorded answers; none where nobody was asked again.
    ///
    /// # Errors
    /// Where answers don't fit to the trials.
    pub(super) fn of(
        recorded: &RecordedAnswers,
        trials: &[Trial],
        context: &MethodContext,
    ) -> Result<Option<Self>> {
        let Some(same) = &recorded.same_seed else {
            return Ok(None);
        };
        let all = std::iter::once(&recorded.anywhere).chain(&recorded.other_seeds);
        let figures: Vec<(f64, Option<f64>)> = all
            .map(|steps| figures(steps, trials, context))
            .collect::<Result<_>>()?;
        let found: Vec<f64> = figures.iter().map(|(found, _)| *found).collect();
        let error_m: Vec<f64> = figures.iter().filter_map(|(_, error_m)| *error_m).collect();
        let pairs = recorded.anywhere.iter().zip(same);
        Ok(Some(Self {
            seeds: figures.len(),
            trials_that_differ_with_one_seed: pairs.filter(|(a, b)| a != b).count(),
            converged_fraction: Spread::over(&found),
            point_error_at_10m_m: Spread::over(&error_m),
        }))
    }
}

/// Share of the trials that converged, and the mean point error after 10 m.
fn figures(
    steps: &[Vec<Step>],
    trials: &[Trial],
    context: &MethodContext,
) -> Result<(f64, Option<f64>)> {
    let answers = judged(trials, steps, context, false)?;
    let both = || trials.iter().zip(&answers);
    let found = both().filter(|(trial, answers)| converged_at_m(trial, answers).is_some());
    let errors: Vec<f64> = both()
        .filter_map(|(trial, answers)| {
            let at = latest_at(trial, REPORTED_AT_M, context.config.spacing_m)?;
            Some(answers.point_error_m[at])
        })
        .collect();
    let mean = errors.iter().sum::<f64>() / errors.len() as f64;
    Ok((
        found.count() as f64 / trials.len() as f64,
        (!errors.is_empty()).then_some(mean),
    ))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_spread_is_that_of_a_sample() {
        let spread = Spread::over(&[1.0, 2.0, 6.0]).unwrap();
        assert_eq!((spread.mean, spread.least, spread.most), (3.0, 1.0, 6.0));
        assert!((spread.sd - 7.0_f64.sqrt()).abs() < 1e-12);
        assert_eq!(Spread::over(&[1.0]), None);
    }
}
