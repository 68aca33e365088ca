//! The whole metric, of every run and of all runs together.

use super::{
    CorrectionFactors, Edges, ErrorSummary, EstimationErrors, Optimal, PositionAndHeading,
    Precision, PriorInterval, SearchStep, Traces, TruthLimit, by_prior_error,
};
use crate::error::{Error, Result};
use serde::{Deserialize, Serialize};

/// What is known of the localiser and of the truth beside their poses.
#[derive(Debug, Clone, PartialEq, Default, Serialize)]
pub struct MetricOptions {
    /// Precision of the real poses; none: not stated, so errors can't be held against it.
    pub truth_precision: Option<Precision>,
    /// Steps of the localiser's search; none: it has none, or they are not stated.
    pub search_step: Option<SearchStep>,
    /// Ends of the intervals of prior error.
    pub edges: Edges,
    /// Mean time of a prediction and of a correction in seconds, where they were measured (R06 2.1). Poses don't tell them.
    pub prediction_s: Option<f64>,
    /// See `prediction_s`.
    pub correction_s: Option<f64>,
}

/// The metric of one run, or of the union of several.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct RunMetric {
    /// What the run is called.
    pub name: String,
    /// Number of estimates.
    pub n: usize,
    /// The prior errors (eq. 3-4).
    pub prior: PositionAndHeading<ErrorSummary>,
    /// The posterior errors (eq. 3-3), with the merit factors (4-2).
    pub posterior: PositionAndHeading<ErrorSummary>,
    /// C_XY, C_T and C_XYT (eq. 3-5, 3-6).
    pub correction: CorrectionFactors,
    /// Posterior errors held against the precision of the truth; none where that is not stated.
    pub truth: Option<TruthLimit>,
    /// Estimates that no search of these steps could have made better; none where no steps are stated.
    pub optimal: Option<Optimal>,
    /// Posterior position errors, in metres, by intervals of prior position error.
    pub by_prior_position_m: Vec<PriorInterval>,
    /// Posterior heading errors, in degrees, by intervals of prior heading error.
    pub by_prior_heading_deg: Vec<PriorInterval>,
}

/// The prediction–correction metric (R06 section 3); serialised, its fields are the JSON keys.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[non_exhaustive]
pub struct PredictionCorrection {
    /// The union of all runs.
    #[serde(flatten)]
    pub overall: RunMetric,
    /// Mean time of a prediction in seconds; none where nobody measured it.
    pub prediction_s: Option<f64>,
    /// Mean time of a correction in seconds; none where nobody measured it.
    pub correction_s: Option<f64>,
    /// Run by run.
    pub runs: Vec<RunMetric>,
}

impl PredictionCorrection {
    /// Of the traces of one run or more.
    ///
    /// # Errors
    /// Where there is no run, or in one of them traces differ in length, are empty or not finite; the message names the run.
    pub fn of(runs: &[Traces], options: &MetricOptions) -> Result<Self> {
        let (mut prior, mut posterior) = Default::default();
        let mut metrics = Vec::new();
        for run in runs {
            let errors = |estimated, what: &str| {
                EstimationErrors::of(estimated, run.real)
                    .map_err(|e| e.context(format!("run {}, {what}", run.name)))
            };
            let before = errors(run.prior, "prior")?;
            let after = errors(run.posterior, "posterior")?;
            metrics.push(RunMetric::of(run.name, &before, &after, options)?);
            EstimationErrors::extend(&mut prior, &before);
            EstimationErrors::extend(&mut posterior, &after);
        }
        let name = match runs {
            [run] => run.name,
            _ => "all runs",
        };
        Ok(Self {
            overall: RunMetric::of(name, &prior, &posterior, options)?,
            prediction_s: options.prediction_s,
            correction_s: options.correction_s,
            runs: metrics,
        })
    }

    /// What a reader should know before believing the figures.
    pub fn notes(&self) -> Vec<String> {
        let mut notes = Vec::new();
        let of = &self.overall;
        if let Some(truth) = &of.truth {
            let mut imprecise = |enough: Option<bool>, precision: Option<f64>, mean: f64, unit| {
                if let (Some(false), Some(precision)) = (enough, precision) {
                    notes.push(format!(
                        "the truth, precise to {precision} {unit}, is not twice as precise as the mean posterior error of {mean:.4} {unit}: \
                         part of that error is the truth's"
                    ));
                }
            };
            imprecise(
                truth.position_precise_enough,
                truth.position_m,
                of.posterior.position_m.mean,
                "m",
            );
            imprecise(
                truth.heading_precise_enough,
                truth.heading_deg,
                of.posterior.heading_deg.mean,
                "deg",
            );
        }
        let both = &of.correction.both;
        if both.unchanged == both.n {
            notes.push(
                "no correction changed an error: prior and posterior are as good as the same, and C with ≤ is 100 % without any merit"
                    .into(),
            );
        } else if of.correction.position.worsened > of.n / 2 {
            let share = 100.0 * of.correction.position.worsened as f64 / of.n as f64;
            notes.push(format!(
                "the correction makes {share:.0} % of the positions worse: are prior and estimate swapped?"
            ));
        }
        notes
    }
}

impl RunMetric {
    /// From the errors before and after correction, pose by pose.
    ///
    /// # Errors
    /// Where numbers differ or there is none.
    pub fn of(
        name: &str,
        prior: &EstimationErrors,
        posterior: &EstimationErrors,
        options: &MetricOptions,
    ) -> Result<Self> {
        let correction = CorrectionFactors::of(prior, posterior)?;
        let nothing = || Error::work("no estimate; expected at least one");
        let edges = &options.edges;
        let precision = options.truth_precision.as_ref();
        Ok(Self {
            name: name.into(),
            n: posterior.len(),
            prior: prior.summary().ok_or_else(nothing)?,
            posterior: posterior.summary().ok_or_else(nothing)?,
            correction,
            truth: precision.map(|precision| TruthLimit::of(posterior, precision)),
            optimal: (options.search_step.as_ref()).map(|step| Optimal::of(posterior, step)),
            by_prior_position_m: by_prior_error(
                &prior.position_m,
                &posterior.position_m,
                &edges.position_m,
            ),
            by_prior_heading_deg: by_prior_error(
                &prior.heading_deg,
                &posterior.heading_deg,
                &edges.heading_deg,
            ),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Pose;

    fn off(real: &[Pose], by: impl Fn(usize) -> f64) -> Vec<Pose> {
        let moved = |(k, p): (usize, &Pose)| Pose::new(p.x_m, p.y_m + by(k), p.heading_rad);
        real.iter().enumerate().map(moved).collect()
    }

    #[test]
    fn runs_are_judged_apart_and_together() {
        let real: Vec<Pose> = (0..30).map(|k| Pose::new(f64::from(k), 0.0, 0.1)).collect();
        let prior = off(&real, |_| 1.0);
        let (good, bad) = (off(&real, |_| 0.2), off(&real[..10], |k| k as f64));
        let runs = [
            Traces {
                name: "R1",
                real: &real,
                prior: &prior,
                posterior: &good,
            },
            Traces {
                name: "R2",
                real: &real[..10],
                prior: &prior[..10],
                posterior: &bad,
            },
        ];
        let metric = PredictionCorrection::of(&runs, &MetricOptions::default()).unwrap();
        assert_eq!((metric.runs.len(), metric.overall.n), (2, 40));
        assert_eq!(metric.runs[0].correction.position.improved, 30);
        let together = metric.overall.correction.position;
        assert_eq!(
            (together.improved, together.unchanged, together.worsened),
            (31, 1, 8)
        );
        assert_eq!(
            metric.runs[1].posterior.position_m.merit,
            4.5 + 8.25f64.sqrt()
        );
        assert!(PredictionCorrection::of(&[], &MetricOptions::default()).is_err());
        let short = Traces {
            prior: &prior[..3],
            ..runs[0]
        };
        let error = PredictionCorrection::of(&[short], &MetricOptions::default()).unwrap_err();
        assert!(error.to_string().contains("run R1, prior"), "{error}");
    }

    #[test]
    fn what_may_mislead_is_noted() {
        let real: Vec<Pose> = (0..30).map(|k| Pose::new(f64::from(k), 0.0, 0.1)).collect();
        let (near, far) = (off(&real, |_| 0.1), off(&real, |_| 0.4));
        let notes = |prior: &[Pose], posterior: &[Pose], precision: &str| {
            let options = MetricOptions {
                truth_precision: Some(precision.parse().unwrap()),
                ..MetricOptions::default()
            };
            let run = Traces {
                name: "R1",
                real: &real,
                prior,
                posterior,
            };
            PredictionCorrection::of(&[run], &options)
                .unwrap()
                .notes()
                .join("\n")
        };
        assert_eq!(notes(&far, &near, "0.05m"), "");
        assert!(notes(&far, &near, "0.06m").contains("not twice as precise"));
        assert!(notes(&near, &far, "1mm").contains("swapped"));
        assert!(notes(&near, &near, "1mm").contains("no correction"));
    }
}
