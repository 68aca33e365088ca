//! Global localisation: T98 5.2.4, Figs. 5 and 6.

use super::{Thrun1998Config, reductions::Fold};
use crate::{
    belief::{Belief, Evidence, Places},
    error::{Error, Result},
    experiment::{
        convergence::SURE_WITHIN_M,
        learned_row::{Rounded, learned_features},
        localisation::{Record, play},
        localise_config::LocaliseConfig,
        method::{AnswersBy, Method},
        methods::MethodContext,
        parts::{Parts, TrainingSource},
    },
    localiser::BayesLocaliser,
    score::MeanInterval,
    seed::Seed,
};
use serde::{Deserialize, Serialize};
use std::{borrow::Cow, collections::BTreeMap};

/// Metres that every trial goes: T98 tells the error of doors after 30, which its last snapshot may fall short of.
pub(super) const TRIAL_M: f64 = 31.0;

/// Metres between two snapshots (T98 5.2.4).
pub(super) const SPACING_M: f64 = 0.5;

/// Snapshots of Fig. 5: the belief before the first, and after each of these.
const SHOWN: usize = 8;

/// Mean errors of an approach over distance, from a start anywhere.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct GlobalRecord {
    /// The data set.
    pub set: String,
    /// `door`, `ceiling_light` or `ball`: four features trained for ±2 m.
    pub approach: String,
    /// A row every 0.5 m.
    pub error_by_distance: Vec<GlobalRow>,
    /// First distance at which the mean error is below 1 m; none where it never is.
    pub below_1m_at_m: Option<f64>,
}

/// The mean error after some way.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct GlobalRow {
    /// Metres travelled since the start.
    pub distance_m: f64,
    /// Σ Bel·e in metres (T98 eq. 21), mean over the trials of each run, then over the runs that are judged on.
    pub expected_error_m: MeanInterval,
}

impl GlobalRecord {
    /// The mean error after so many metres.
    pub fn error_at_m(&self, distance_m: f64) -> Option<f64> {
        let mut rows = self.error_by_distance.iter();
        let row = rows.find(|row| (row.distance_m - distance_m).abs() < SPACING_M / 2.0);
        row.map(|row| row.expected_error_m.mean)
    }

    /// First distance at which the mean error is below this.
    pub fn below_m(&self, error_m: f64) -> Option<f64> {
        let mut rows = self.error_by_distance.iter();
        let row = rows.find(|row| row.expected_error_m.mean < error_m);
        row.map(|row| row.distance_m)
    }
}

/// Beliefs of one trial.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct BeliefRecord {
    /// Cells, in metres along the corridor.
    pub route_m: Vec<f64>,
    /// Before the first snapshot, and after each.
    pub moments: Vec<Moment>,
}

/// A belief at one time.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct Moment {
    /// Snapshots taken so far.
    pub snapshots: usize,
    /// Where the robot is, in metres along the corridor.
    pub truth_m: f64,
    /// Probability of each cell.
    pub mass: Vec<f64>,
    /// Σ Bel·e in metres.
    pub expected_error_m: f64,
}

/// Errors over distance of every approach, run by run.
pub(super) struct Corridor {
    set: String,
    /// In the order in which approaches came.
    approaches: Vec<String>,
    /// Mean error at a step, one a run.
    errors_m: BTreeMap<(usize, usize), Vec<f64>>,
}

impl Corridor {
    pub fn new(set: &str) -> Self {
        Self {
            set: set.into(),
            approaches: Vec::new(),
            errors_m: BTreeMap::new(),
        }
    }

    /// Plays the trials of one run.
    pub fn add(&mut self, config: &Thrun1998Config, fold: &Fold) -> Result<()> {
        let model = [fold.local_model()?];
        let (parts, localise) = (parts(fold), localise_config(config));
        let context = MethodContext::new(&model, &parts, &localise)?;
        let mut methods = Vec::new();
        for (approach, detector) in &fold.chosen {
            methods.push(at_its_word(context.detector(
                approach,
                approach,
                detector.as_ref(),
            )?));
        }
        methods.push(ball(&context)?);
        self.take(&play(&context, methods, &mut |_| ())?)
    }

    /// Takes in the mean errors of one run.
    pub fn take(&mut self, record: &Record) -> Result<()> {
        if let Some(left_out) = record.left_out.first() {
            return Err(Error::work(left_out.fault.clone()).context(&left_out.name));
        }
        for result in &record.results {
            let known = self.approaches.iter().position(|name| *name == result.name);
            let number = known.unwrap_or_else(|| {
                self.approaches.push(result.name.clone());
                self.approaches.len() - 1
            });
            for (step, row) in result.global.error_by_distance.iter().enumerate() {
                let errors = self.errors_m.entry((number, step)).or_default();
                errors.push(row.expected_error_m);
            }
        }
        Ok(())
    }

    /// One an approach.
    pub fn records(&self) -> Vec<GlobalRecord> {
        let of = |(number, approach): (usize, &String)| {
            let steps = self.errors_m.iter().filter(|((of, _), _)| *of == number);
            let rows = steps.filter_map(|((_, step), errors)| {
                Some(GlobalRow {
                    distance_m: *step as f64 * SPACING_M,
                    expected_error_m: MeanInterval::of(errors)?,
                })
            });
            let record = GlobalRecord {
                set: self.set.clone(),
                approach: approach.clone(),
                error_by_distance: rows.collect(),
                below_1m_at_m: None,
            };
            GlobalRecord {
                below_1m_at_m: record.below_m(SURE_WITHIN_M),
                ..record
            }
        };
        self.approaches.iter().enumerate().map(of).collect()
    }

    /// Runs that were judged on.
    pub fn runs(&self) -> usize {
        self.errors_m.values().map(Vec::len).max().unwrap_or(0)
    }

    /// Where each approach's mean error over some of the runs, each as often as it is named, passes 1 m: between the rows of the
    /// curve on a straight line.
    pub fn passes_1m_at_m(&self, runs: &[usize]) -> Vec<(String, Option<f64>)> {
        let mean_m = |errors: &Vec<f64>| {
            let of_runs = runs.iter().filter_map(|&run| errors.get(run));
            of_runs.sum::<f64>() / runs.len().max(1) as f64
        };
        let passes = |number: usize| {
            let mut before: Option<(f64, f64)> = None;
            for ((_, step), errors) in self.errors_m.range((number, 0)..(number + 1, 0)) {
                let (at_m, error_m) = (*step as f64 * SPACING_M, mean_m(errors));
                if error_m < SURE_WITHIN_M {
                    return Some(before.map_or(at_m, |(before_m, above_m)| {
                        before_m
                            + (at_m - before_m) * (above_m - SURE_WITHIN_M) / (above_m - error_m)
                    }));
                }
                before = Some((at_m, error_m));
            }
            None
        };
        let approaches = self.approaches.iter().enumerate();
        approaches
            .map(|(number, name)| (name.clone(), passes(number)))
            .collect()
    }

    /// Readings that learned features take until the mean error is below 1 m.
    pub fn readings(&self) -> Option<f64> {
        let records = self.records();
        let ball = records.iter().find(|record| record.approach == "ball")?;
        Some(ball.below_1m_at_m? / SPACING_M)
    }
}

/// The beliefs of a trial that starts in the middle of the corridor (Fig. 5).
pub(super) fn belief(config: &Thrun1998Config, fold: &Fold) -> Result<Option<BeliefRecord>> {
    let model = [fold.local_model()?];
    let (parts, localise) = (parts(fold), localise_config(config));
    let context = MethodContext::new(&model, &parts, &localise)?;
    let (Places::Route(cells), Places::Route(route_m)) = (&**context.grid.places(), &parts.places)
    else {
        return Ok(None);
    };
    let method = ball(&context)?;
    let AnswersBy::PreparedSensor(sensor) = &method.answers else {
        return Ok(None);
    };
    let middle_m = cells.iter().sum::<f64>() / cells.len().max(1) as f64;
    let mut wanted_m = middle_m;
    let mut shown = Vec::new();
    for &k in &parts.unseen {
        if route_m[k] >= wanted_m && shown.len() < SHOWN {
            shown.push(k);
            wanted_m = route_m[k] + SPACING_M;
        }
    }
    let start = Belief::uniform(context.grid.places())?;
    let moment = |snapshots: usize, k: usize, belief: &Belief| Moment {
        snapshots,
        truth_m: route_m[k],
        mass: belief.mass().to_vec(),
        expected_error_m: belief.expected_error_m(&parts.places, k),
    };
    let Some(&first) = shown.first() else {
        return Ok(None);
    };
    let mut moments = vec![moment(0, first, &start)];
    let motion = &model[0].header.motion;
    let random = Seed(config.seed).stream("sampled features of Fig. 5");
    let mut robot =
        BayesLocaliser::new(&context.grid, motion, start, Some(sensor.as_ref()), random)?;
    for (taken, &k) in shown.iter().enumerate() {
        let belief = robot.observe(k, &fold.recording.observation(k))?;
        moments.push(moment(taken + 1, k, belief));
    }
    Ok(Some(BeliefRecord {
        route_m: cells.clone(),
        moments,
    }))
}

/// Four features for ±2 m, sampled as in T98 Table 1.
fn ball<'a>(context: &MethodContext<'a>) -> Result<Method<'a>> {
    let method = learned_features(context, context.models[0], Rounded::No, "ball", "ball")?;
    Ok(at_its_word(method))
}

/// Evidence as it is, as in T98.
pub(super) fn at_its_word(method: Method<'_>) -> Method<'_> {
    Method {
        evidence_scale: Some(1.0),
        ..method
    }
}

pub(super) fn parts<'a>(fold: &'a Fold) -> Parts<'a> {
    Parts {
        run: fold.recording,
        places: fold.places.clone(),
        unseen: fold.split.test.clone(),
        unseen_is_validation: false,
        source: Some(TrainingSource {
            recording: Cow::Borrowed(fold.recording),
            training: fold.split.train.clone(),
            validation: Vec::new(),
        }),
    }
}

/// Every trial goes all the way, so that the same trials make each point of a curve.
pub(super) fn localise_config(config: &Thrun1998Config) -> LocaliseConfig {
    LocaliseConfig {
        seed: Some(config.seed),
        trials: config.trials,
        spacing_m: SPACING_M,
        shortest_m: TRIAL_M,
        longest_m: TRIAL_M,
        evidence: Evidence::Sampled,
        ..LocaliseConfig::default()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two runs; means 3, 2 and 0 m: 1 m lies in the middle between the second row and the third. The first run alone passes at 0.25 m.
    #[test]
    fn the_mean_passes_1m_between_two_rows() {
        let mut corridor = Corridor::new("d1");
        corridor.approaches = vec!["a".into(), "never".into()];
        let rows = [[2.0, 4.0], [0.0, 4.0], [0.0, 0.0]];
        for (step, errors) in rows.into_iter().enumerate() {
            corridor.errors_m.insert((0, step), errors.to_vec());
            corridor.errors_m.insert((1, step), vec![5.0, 5.0]);
        }
        assert_eq!(corridor.runs(), 2);
        let passes = |runs: &[usize]| corridor.passes_1m_at_m(runs);
        assert_eq!(passes(&[0, 1])[0], ("a".to_string(), Some(0.75)));
        assert_eq!(passes(&[0, 0])[0].1, Some(0.25));
        assert_eq!(passes(&[1])[0].1, Some(0.5 + 0.5 * 3.0 / 4.0));
        assert_eq!(passes(&[0, 1])[1], ("never".to_string(), None));
    }
}
