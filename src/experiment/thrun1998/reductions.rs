//! What one snapshot takes away of the error: T98 5.2.1 to 5.2.3.

use super::{
    MOST_FEATURES, Thrun1998Config, priors,
    set_record::{JudgedFold, JudgedRow, OutputRecord},
    window,
};
use crate::{
    belief::{GridMap, MapConfig, Places, Uncertainty},
    detector::{
        Detector,
        ceiling_light::CeilingLight,
        door::{Door, DoorConfig, Side},
        input::{Input, InputConfig},
    },
    error::{Error, Result},
    experiment::{
        error_reduction::{ErrorReductionConfig, by_probabilities},
        held_out::{by_features, by_kernel, counted},
    },
    learning::training_set::covered,
    localiser::sensor_model::least_mean_squares,
    model::{Model, Training},
    recording::{Recording, split::Split},
};
use ndarray::{Array2, Axis};

/// Bandwidths of the raw-scan kernel, in standard deviations of the inputs.
const BANDWIDTHS: [f64; 6] = [0.04, 0.08, 0.16, 0.32, 0.64, 1.28];

/// A data set, and the run of it that is judged on.
pub(super) struct Fold<'a> {
    pub recording: &'a Recording,
    pub places: Places,
    pub split: Split,
    /// n, the prior trained for, and what came of it; the four features for ±2 m last.
    pub models: Vec<Model>,
    /// Landmarks chosen by people, by the name of their approach.
    pub chosen: Vec<(&'static str, Box<dyn Detector>)>,
}

impl<'a> Fold<'a> {
    /// Trains a feature for every prior and one to four for ±2 m on all runs but one.
    pub fn new(
        config: &Thrun1998Config,
        recording: &'a Recording,
        set: &str,
        tested: usize,
    ) -> Result<Self> {
        let of_one = priors().into_iter().map(|prior| (1, prior));
        let of_more = (2..=MOST_FEATURES).map(|features| (features, window(2.0)));
        Self::trained(config, recording, set, tested, of_one.chain(of_more))
    }

    /// Trains the four features for ±2 m alone.
    pub fn local(
        config: &Thrun1998Config,
        recording: &'a Recording,
        set: &str,
        tested: usize,
    ) -> Result<Self> {
        let local = [(MOST_FEATURES, window(2.0))].into_iter();
        Self::trained(config, recording, set, tested, local)
    }

    /// Trains four features for every prior.
    pub fn bank(
        config: &Thrun1998Config,
        recording: &'a Recording,
        set: &str,
        tested: usize,
    ) -> Result<Self> {
        let of_each = priors().into_iter().map(|prior| (MOST_FEATURES, prior));
        Self::trained(config, recording, set, tested, of_each)
    }

    /// Trains one and four features for ±2 m.
    pub fn one_and_four(
        config: &Thrun1998Config,
        recording: &'a Recording,
        set: &str,
        tested: usize,
    ) -> Result<Self> {
        let local = [1, MOST_FEATURES].map(|features| (features, window(2.0)));
        Self::trained(config, recording, set, tested, local.into_iter())
    }

    fn trained(
        config: &Thrun1998Config,
        recording: &'a Recording,
        set: &str,
        tested: usize,
        wanted: impl Iterator<Item = (usize, Uncertainty)>,
    ) -> Result<Self> {
        let split = config
            .recipe(1, window(2.0), tested)
            .split
            .split(recording)?;
        let train = |(features, prior): (usize, Uncertainty)| {
            let recipe = config.recipe(features, prior, tested);
            Ok(Training::new(&recipe, recording).run()?.model)
        };
        let looks = |side| DoorConfig {
            side,
            ..DoorConfig::default()
        };
        let door = |side| -> Result<(&'static str, Box<dyn Detector>)> {
            let door = Door::fit(&looks(side), recording, &split.train)?;
            Ok(("door", Box::new(door)))
        };
        let chosen = match set {
            "d1" => door(Side::Right)?,
            "d2" => door(Side::Left)?,
            _ => (
                "ceiling_light",
                Box::new(CeilingLight::default()) as Box<dyn Detector>,
            ),
        };
        Ok(Self {
            recording,
            places: Places::of(recording),
            models: wanted.map(train).collect::<Result<Vec<_>>>()?,
            split,
            chosen: vec![chosen],
        })
    }

    /// The four features for ±2 m.
    pub fn local_model(&self) -> Result<&Model> {
        let last = self.models.last();
        last.ok_or_else(|| Error::work("thrun1998: nothing was trained"))
    }

    /// Landmarks chosen by people and what was trained, each at ±2 m.
    pub fn local_rows(&self) -> Result<Vec<JudgedRow>> {
        let (mut rows, prior) = (Vec::new(), window(2.0));
        for (approach, detector) in &self.chosen {
            let answers = detector.probabilities(self.recording)?.mapv(f64::from);
            self.judge(&mut rows, (approach, 1, None), &answers, &[prior])?;
        }
        for model in &self.models {
            let answers = model
                .detector()
                .probabilities(self.recording)?
                .mapv(f64::from);
            let trained = ("ball", model.features(), Some(model.header.prior));
            self.judge(&mut rows, trained, &answers, &[prior])?;
        }
        Ok(rows)
    }

    /// Everybody judged.
    pub fn judged(&self) -> Result<JudgedFold> {
        let mut rows = Vec::new();
        for (approach, detector) in &self.chosen {
            let answers = detector.probabilities(self.recording)?.mapv(f64::from);
            self.judge(&mut rows, (approach, 1, None), &answers, &priors())?;
        }
        let (mut outputs, mut correlation) = (Vec::new(), f64::NAN);
        for model in &self.models {
            let (n, prior) = (model.features(), model.header.prior);
            let answers = model
                .detector()
                .probabilities(self.recording)?
                .mapv(f64::from);
            let judged_at = match n {
                MOST_FEATURES => priors(), // Fig. 4
                _ => vec![prior],
            };
            self.judge(&mut rows, ("ball", n, Some(prior)), &answers, &judged_at)?;
            let is_of_fig_7 =
                n == 1 && [window(2.0), window(10.0), Uncertainty::Global].contains(&prior);
            if is_of_fig_7 || n == MOST_FEATURES {
                outputs.push(self.output(n, prior, &answers));
            }
            if n == MOST_FEATURES {
                correlation = mean_correlation(&answers.select(Axis(0), &self.split.test));
            }
        }
        rows.extend(self.kernel()?);
        let global = counted(
            Uncertainty::Global,
            &self.places,
            &self.split.test,
            &self.places,
        );
        let candidates = self.places.select(&global);
        let nothing = Array2::from_elem((global.len(), 1), 0.5);
        let ignorant = by_features(
            Uncertainty::Global,
            (&candidates, nothing.view()),
            (&candidates, &GridMap::new(nothing.clone())?),
        )?;
        Ok(JudgedFold {
            snapshots: self.recording.len(),
            prior_error_m: ignorant.prior_error_m,
            rows,
            correlation,
            outputs,
        })
    }

    /// Adds a row a prior.
    fn judge(
        &self,
        rows: &mut Vec<JudgedRow>,
        (approach, features, trained_for): (&'static str, usize, Option<Uncertainty>),
        answers: &Array2<f64>,
        judged_at: &[Uncertainty],
    ) -> Result<()> {
        let (at, seen) = (
            self.places.select(&self.split.test),
            answers.select(Axis(0), &self.split.test),
        );
        let own = GridMap::new(seen.clone())?;
        let config = ErrorReductionConfig {
            priors: judged_at.to_vec(),
            map: MapConfig::default(),
        };
        let (mapping, testing) = (&self.split.train, &self.split.test);
        let held_out = by_probabilities(&self.places, mapping, testing, answers.view(), &config)?;
        for &prior in judged_at {
            let objective = by_features(prior, (&at, seen.view()), (&at, &own))?;
            rows.push(JudgedRow {
                approach,
                features,
                trained_for,
                judged_at: prior,
                objective: Some(objective.error_reduction),
                held_out: held_out.at(prior).map(|point| point.error_reduction),
            });
        }
        Ok(())
    }

    /// The nearest recorded snapshots, each bandwidth chosen on the very run that it is judged on: the most that raw readings can
    /// give in this way.
    fn kernel(&self) -> Result<Vec<JudgedRow>> {
        let input = Input::fit(&InputConfig::default(), self.recording, &self.split.train)?;
        let inputs = input.transform(self.recording)?;
        let candidates = self.places.select(&self.split.train);
        let seen = covered(&self.places, &self.split.test, &candidates);
        let training = inputs.select(Axis(0), &self.split.train);
        let of_prior = |prior: Uncertainty| {
            let truths = counted(prior, &self.places, &seen, &candidates);
            let asked = inputs.select(Axis(0), &truths);
            let square = least_mean_squares(asked.view(), std::slice::from_ref(&training));
            let at = self.places.select(&truths);
            let of = |h: f64| by_kernel(prior, &at, &candidates, square.view(), h).error_reduction;
            let best = BANDWIDTHS
                .map(of)
                .into_iter()
                .fold(f64::NEG_INFINITY, f64::max);
            JudgedRow {
                approach: "kernel",
                features: 0,
                trained_for: None,
                judged_at: prior,
                objective: None,
                held_out: Some(best).filter(|best| best.is_finite()),
            }
        };
        Ok(priors().into_iter().map(of_prior).collect())
    }

    fn output(
        &self,
        features: usize,
        trained_for: Uncertainty,
        answers: &Array2<f64>,
    ) -> OutputRecord {
        let mut order = self.split.test.clone();
        let route_m = |k: usize| match &self.places {
            Places::Route(route_m) => route_m[k],
            Places::Plane(_) => f64::NAN,
        };
        order.sort_by(|&a, &b| route_m(a).total_cmp(&route_m(b)));
        let of_feature = |feature| order.iter().map(|&k| answers[[k, feature]]).collect();
        OutputRecord {
            features,
            trained_for,
            route_m: order.iter().map(|&k| route_m(k)).collect(),
            activation: (0..features).map(of_feature).collect(),
        }
    }
}

/// Mean absolute Pearson correlation of every two columns; a column that never changes correlates with none.
fn mean_correlation(answers: &Array2<f64>) -> f64 {
    let n = answers.nrows().max(1) as f64;
    let centred: Vec<Vec<f64>> = answers
        .columns()
        .into_iter()
        .map(|column| {
            let mean = column.sum() / n;
            column.iter().map(|value| value - mean).collect()
        })
        .collect();
    let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    let (mut sum, mut pairs) = (0.0, 0);
    for (i, a) in centred.iter().enumerate() {
        for b in &centred[..i] {
            let norm = (dot(a, a) * dot(b, b)).sqrt();
            sum += if norm > 0.0 {
                (dot(a, b) / norm).abs()
            } else {
                0.0
            };
            pairs += 1;
        }
    }
    sum / f64::from(pairs.max(1))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_that_run_together_or_against_each_other_correlate() {
        let answers = ndarray::array![[0.0, 1.0, 0.0], [0.5, 0.5, 0.0], [1.0, 0.0, 0.0]];
        assert!((mean_correlation(&answers) - 1.0 / 3.0).abs() < 1e-12);
        let apart = ndarray::array![[0.0, 0.0], [0.0, 1.0], [1.0, 0.0], [1.0, 1.0]];
        assert!(mean_correlation(&apart).abs() < 1e-12);
    }
}
