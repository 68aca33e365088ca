//! What a method's correction is worth apart from its prediction, in trials from a known start: the metric of Ruiz-Mayor et al. (2006,
//! R06), for whatever localiser answers.
//!
//! R06's prior estimate is what a movement makes of the estimate before it. Of a black box nobody knows more than its answers, so the
//! prior is worked out here, and in the same way for all: the last answer, moved as odometry says. Who answers with a place alone has
//! no such prior in the plane.

use super::{convergence::Answers, methods::MethodContext, trials::Trial};
use crate::{
    belief::Places,
    error::Result,
    geometry::{Displacement, Pose},
    score::{
        ClusteredMean,
        prediction_correction::{
            EstimationErrors, MetricOptions, PositionHeading, RunMetric, SearchStep, TIE,
        },
    },
    seed::Seed,
};
use serde::{Deserialize, Serialize};

/// The prediction–correction metric of a method, over all steps of trials from a known start but the first, which has no prediction
/// before it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct Correction {
    /// Errors before and after correction, C_XY, C_T and C_XYT, all steps together. Optimal: what lies within a cell of the grid; null
    /// for localisers with a search of their own.
    #[serde(flatten)]
    pub metric: RunMetric,
    /// Have the answers headings? Along a route there are none; all figures of headings are then of no error at all.
    pub has_headings: bool,
    /// 95 % interval of C_XY with ≤, by bootstrap over runs or stretches.
    pub c_xy_ci95: Option<[f64; 2]>,
    /// Of C_XY with <.
    pub c_xy_better_ci95: Option<[f64; 2]>,
    /// Mean of posterior less prior position error, in metres: below 0 where corrections help.
    pub position_gain_m: f64,
    /// Its interval.
    pub position_gain_m_ci95: Option<[f64; 2]>,
}

/// The metric of answers from a known start, those of the grid filter or of a whole localiser; none where no answer has a prior.
///
/// A filter over a route answers with metres along it, a whole localiser always with poses in the plane.
///
/// # Errors
/// Where an answer is not finite.
pub(super) fn correction(
    trials: &[Trial],
    answers: &[Answers],
    is_grid_filter: bool,
    context: &MethodContext,
) -> Result<Option<Correction>> {
    let (run, grid) = (context.parts.run, &context.grid);
    let is_plane = matches!(context.parts.places, Places::Plane(_));
    let has_headings = is_plane || !is_grid_filter;
    let real = |k: usize| match has_headings {
        true => run.poses()[k],
        false => context.parts.places.pose(k),
    };
    let mut traces = Traces::default();
    for (trial, answers) in trials.iter().zip(answers) {
        for (step, pair) in answers.estimates.windows(2).enumerate() {
            let &[Some(before), Some(posterior)] = pair else {
                continue;
            };
            let (from, to) = (trial.snapshots[step], trial.snapshots[step + 1]);
            let odometry = |k: usize| run.observation(k).odometry;
            let moved = odometry(from).displacement_to(&odometry(to));
            traces.unit.push(trial.unit);
            traces.prior.push(before.after(along(moved, has_headings)));
            traces.posterior.push(posterior);
            traces.real.push(real(to));
        }
    }
    let options = MetricOptions {
        search_step: is_grid_filter.then(|| search_step(grid.cell_m(), grid.headings())),
        ..MetricOptions::default()
    };
    let (resamples, seed) = (context.config.resamples, context.seed());
    traces.judged(has_headings, &options, resamples, seed)
}

/// The steps of a grid's answers, for the share of optimal ones.
fn search_step(cell_m: f64, headings: usize) -> SearchStep {
    PositionHeading {
        position_m: Some(cell_m),
        heading_deg: (headings > 1).then(|| 360.0 / headings as f64),
    }
}

/// A movement; along a route nothing but its length, with the sign of the way.
fn along(moved: Displacement, has_headings: bool) -> Displacement {
    match has_headings {
        true => moved,
        false => Displacement {
            forward_m: moved.along_route_m(),
            left_m: 0.0,
            turn_rad: 0.0,
        },
    }
}

/// Prior, posterior and real poses of all steps, and the unit of each.
#[derive(Default)]
struct Traces {
    unit: Vec<usize>,
    prior: Vec<Pose>,
    posterior: Vec<Pose>,
    real: Vec<Pose>,
}

impl Traces {
    fn judged(
        &self,
        has_headings: bool,
        options: &MetricOptions,
        resamples: usize,
        seed: Seed,
    ) -> Result<Option<Correction>> {
        if self.unit.is_empty() {
            return Ok(None);
        }
        let errors = |estimated: &[Pose]| EstimationErrors::of(estimated, &self.real);
        let (prior, posterior) = (errors(&self.prior)?, errors(&self.posterior)?);
        let gains = prior.position_m.iter().zip(&posterior.position_m);
        let gains: Vec<(usize, f64)> = (self.unit.iter().copied())
            .zip(gains.map(|(before, after)| after - before))
            .collect();
        let share = |counts: fn(f64) -> bool| {
            let steps: Vec<(usize, bool)> = gains.iter().map(|&(u, g)| (u, counts(g))).collect();
            ClusteredMean::share(&steps, resamples, seed).and_then(|share| share.ci95)
        };
        let gain = ClusteredMean::of(&gains, resamples, seed);
        Ok(Some(Correction {
            metric: RunMetric::of("known start", &prior, &posterior, options)?,
            has_headings,
            c_xy_ci95: share(|gain| gain <= TIE),
            c_xy_better_ci95: share(|gain| gain < -TIE),
            position_gain_m: gain.map_or(0.0, |gain| gain.mean),
            position_gain_m_ci95: gain.and_then(|gain| gain.ci95),
        }))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two units of four and two steps; prior errors of 0.4 m, posterior errors as given.
    fn traces(posterior_m: [f64; 6]) -> Traces {
        let at = |y: f64| Pose::new(0.0, y, 0.2);
        Traces {
            unit: vec![0, 0, 0, 0, 1, 1],
            real: vec![at(0.0); 6],
            prior: vec![at(0.4); 6],
            posterior: posterior_m.map(at).to_vec(),
        }
    }

    fn judged(posterior_m: [f64; 6]) -> Correction {
        let options = MetricOptions {
            search_step: Some(search_step(0.2, 36)),
            ..MetricOptions::default()
        };
        let judged = traces(posterior_m).judged(true, &options, 200, Seed(1));
        judged.unwrap().unwrap()
    }

    #[test]
    fn shares_gain_and_intervals_by_hand() {
        let of = judged([0.1, 0.1, 0.4, 0.6, 0.1, 0.1]);
        let position = &of.metric.correction.position;
        assert_eq!(
            (position.improved, position.unchanged, position.worsened),
            (4, 1, 1)
        );
        assert!((of.position_gain_m - (-0.3 * 4.0 + 0.2) / 6.0).abs() < 1e-12);
        // The first unit alone has 3 of 4 and 2 of 4, the second all.
        assert_eq!(of.c_xy_ci95, Some([0.75, 1.0]));
        assert_eq!(of.c_xy_better_ci95, Some([0.5, 1.0]));
        let optimal = of.metric.optimal.unwrap();
        assert_eq!((optimal.count, optimal.limit_heading_deg), (4, Some(5.0)));
    }

    #[test]
    fn nothing_to_judge_is_no_figure() {
        let none = Traces::default().judged(true, &MetricOptions::default(), 10, Seed(1));
        assert_eq!(none.unwrap(), None);
        assert_eq!(search_step(0.25, 1).heading_deg, None);
    }

    #[test]
    fn along_a_route_a_movement_is_its_length() {
        let moved = Displacement {
            forward_m: 3.0,
            left_m: -4.0,
            turn_rad: 1.0,
        };
        assert_eq!(along(moved, true), moved);
        let length = along(moved, false);
        assert_eq!(
            (length.forward_m, length.left_m, length.turn_rad),
            (5.0, 0.0, 0.0)
        );
        let back = Displacement {
            forward_m: -3.0,
            ..moved
        };
        assert_eq!(along(back, false).forward_m, -5.0);
    }
}
