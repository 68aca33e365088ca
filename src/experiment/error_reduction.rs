//! How much of its error a robot loses by one answer, whoever gives it, against how uncertain it was before: the curves
//! of Thrun (1998), Fig. 3 and 4, for any recogniser.
//!
//! T98 draws them for BaLL, doors and ceiling lights, whose answers are stochastic features ([`by_probabilities`]). A
//! recogniser that answers with the number of a pattern fits in as well ([`by_classes`]): the error that is left depends
//! on P(answer|ξ) alone (T98 eq. 36 with the answer for f), and that is learned from the mapping part for both in the same
//! way, by asking the nearest mapping snapshots (T98 5.1.6). So one figure holds them all.
//!
//! Candidates are the places of the mapping part. Truths are test snapshots at places that the mapping part has been to
//! ([`covered`]) and under priors that leave at least two candidates: others have no error to reduce, or nobody could.

use super::held_out;
use crate::{
    belief::{
        FeatureMap, MapConfig, Neighbours, Places, Uncertainty, prior::DEFAULT_HALF_TURN_RAD,
        thinning::thinned_snapshots,
    },
    error::{Error, Result},
    learning::{error_reduction::ErrorReduction, objective::MAX_FEATURES, training_set::covered},
};
use ndarray::{ArrayView2, Axis};
use serde::{Deserialize, Serialize};
use std::collections::HashMap;

/// Most priors of one curve.
const MAX_PRIORS: usize = 64;

/// Under which priors, and how P(answer|ξ) is learned.
///
/// ```
/// use ballmark::experiment::error_reduction::ErrorReductionConfig;
/// let config: ErrorReductionConfig = toml::from_str(r#"
///     priors = ["2m", "global"]
///     map = { nearness = { k = 3 } }
/// "#).unwrap();
/// config.check()?;
/// assert_eq!(config.map.nearness.k, 3);
/// # Ok::<(), ballmark::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct ErrorReductionConfig {
    /// How uncertain the robot is before it senses, a point of the curve each. T98's are 1, 2, 5, 10, 50 and 89 m, the last
    /// of which is all of its corridor.
    pub priors: Vec<Uncertainty>,
    /// Which mapping snapshots speak for a place, and the share of answers given by chance, which keeps an answer that
    /// was never given at a place from excluding it.
    pub map: MapConfig,
}

impl Default for ErrorReductionConfig {
    fn default() -> Self {
        let window = |half_width_m| Uncertainty::Window {
            half_width_m,
            half_turn_rad: Some(DEFAULT_HALF_TURN_RAD),
        };
        let windows = [1.0, 2.0, 5.0, 10.0, 50.0].map(window);
        Self {
            priors: windows.into_iter().chain([Uncertainty::Global]).collect(),
            map: MapConfig::default(),
        }
    }
}

impl ErrorReductionConfig {
    /// # Errors
    /// A usage error that names the key at fault.
    pub fn check(&self) -> Result<()> {
        let priors = self.priors.len();
        if !(1..=MAX_PRIORS).contains(&priors) {
            return Err(Error::usage(format!(
                "error_reduction: `priors` has {priors}; expected 1 to {MAX_PRIORS}"
            )));
        }
        let chance = self.map.unmodelled_probability;
        if !(chance > 0.0 && chance < 1.0) {
            return Err(Error::usage(format!(
                "error_reduction: `map.unmodelled_probability` is {chance}; expected more than 0, below 1"
            )));
        }
        self.map
            .check_most_places()
            .map_err(|e| e.context("error_reduction"))?;
        self.map.nearness.check(usize::MAX)
    }
}

/// Error reduction against prior uncertainty.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct Curve {
    /// In the order of the priors asked for. A prior that leaves no test snapshot two candidates at different places has
    /// no point.
    pub points: Vec<CurvePoint>,
}

/// One prior.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct CurvePoint {
    /// How uncertain the robot was.
    pub prior: Uncertainty,
    /// Its errors before and after, over all snapshots that count.
    pub score: ErrorReduction,
}

impl Curve {
    /// The point of a prior, where there is one.
    pub fn at(&self, prior: Uncertainty) -> Option<&ErrorReduction> {
        let mut points = self.points.iter();
        let point = points.find(|point| point.prior == prior)?;
        Some(&point.score)
    }
}

/// The curve of a recogniser that answers with one of some classes, or not at all.
///
/// `class` is its answer to every snapshot of the recording, `places` where these were taken, `mapping` and `testing`
/// which of them it learned from and is judged on. P(class|ξ) is how often the k mapping snapshots nearest to ξ were
/// answered so, mixed with an even share for all classes of the mapping part. No answer is a class like any other. A
/// class that the mapping part never gave tells nothing.
///
/// ```
/// use ballmark::{belief::{Places, Uncertainty}, experiment::error_reduction::{ErrorReductionConfig, by_classes}};
/// // A corridor of 40 m, mapped on the way there and tested on another, with a recogniser that knows its first quarter.
/// let metres: Vec<f64> = (0..400).chain(0..400).map(|k| 0.1 * f64::from(k)).collect();
/// let class: Vec<Option<usize>> = metres.iter().map(|&x| (x < 10.0).then_some(7)).collect();
/// let (mapping, testing): (Vec<usize>, Vec<usize>) = ((0..400).collect(), (400..800).collect());
///
/// let config = ErrorReductionConfig::default();
/// let curve = by_classes(&Places::Route(metres), &mapping, &testing, &class, &config)?;
/// let global = curve.at(Uncertainty::Global).unwrap();
/// assert!((global.prior_error_m - 40.0 / 3.0).abs() < 0.01);
/// assert!((global.error_reduction - 0.375).abs() < 0.01);
/// # Ok::<(), ballmark::Error>(())
/// ```
///
/// # Errors
/// Where `class` has not one entry a place, an index is none of them, there are fewer mapping snapshots than k, or no
/// prior gives a point; a usage error where `config` makes no sense.
pub fn by_classes(
    places: &Places,
    mapping: &[usize],
    testing: &[usize],
    class: &[Option<usize>],
    config: &ErrorReductionConfig,
) -> Result<Curve> {
    let context = CurveContext::new(places, mapping, testing, class.len(), config)?;
    // ln P(class|ξ) of every class that the mapping part knows, `[candidate]`.
    let candidates = context.candidates.len();
    let mut times: HashMap<Option<usize>, Vec<usize>> = HashMap::new();
    let near = Neighbours::find(
        &context.candidates,
        &context.candidates,
        &config.map.nearness,
    )?;
    for candidate in 0..candidates {
        for &neighbour in near.of(candidate) {
            let given = times.entry(class[context.mapping[neighbour]]);
            given.or_insert_with(|| vec![0; candidates])[candidate] += 1;
        }
    }
    let chance = config.map.unmodelled_probability;
    let (by_chance, k) = (chance / times.len() as f64, near.k() as f64);
    let log_probability = |times: Vec<usize>| -> Vec<f64> {
        let smoothed = |n: usize| (1.0 - chance) * n as f64 / k + by_chance;
        times.into_iter().map(|n| smoothed(n).ln()).collect()
    };
    let log_probability: HashMap<Option<usize>, Vec<f64>> = times
        .into_iter()
        .map(|(class, times)| (class, log_probability(times)))
        .collect();
    let never_given = vec![0.0; candidates];
    context.curve(|prior, truths| {
        let at = places.select(truths);
        Ok(held_out::by_likelihood(
            prior,
            &at,
            &context.candidates,
            |truth| {
                let known = log_probability.get(&class[truths[truth]]);
                known.unwrap_or(&never_given).clone()
            },
        ))
    })
}

/// The curve of a detector, which answers with probabilities P(f_i = 1 | s): doors, ceiling lights, BaLL.
///
/// `answers` are those for every snapshot of the recording, `[snapshot, feature]`; the rest as for [`by_classes`]. The
/// error is exact, over all outcomes of the features (T98 eq. 36), up to [`MAX_FEATURES`] of them; more are taken by
/// mean field.
///
/// # Errors
/// As [`by_classes`], and where an answer of the mapping part is no probability.
pub fn by_probabilities(
    places: &Places,
    mapping: &[usize],
    testing: &[usize],
    answers: ArrayView2<f64>,
    config: &ErrorReductionConfig,
) -> Result<Curve> {
    let context = CurveContext::new(places, mapping, testing, answers.nrows(), config)?;
    let candidates = &context.candidates;
    let activation = answers.select(Axis(0), &context.mapping);
    let map =
        FeatureMap::new(candidates.clone(), activation, config.map.clone())?.at(candidates)?;
    context.curve(|prior, truths| {
        let (at, seen) = (places.select(truths), answers.select(Axis(0), truths));
        let (truths, map) = ((&at, seen.view()), (candidates, &map));
        if answers.ncols() > MAX_FEATURES {
            return Ok(held_out::by_mean_field(prior, truths, map));
        }
        held_out::by_features(prior, truths, map)
    })
}

/// What both kinds of answers share.
struct CurveContext<'a> {
    places: &'a Places,
    /// Mapping snapshots that the map is made of.
    mapping: Vec<usize>,
    /// Test snapshots at mapped places.
    mapped: Vec<usize>,
    candidates: Places,
    config: &'a ErrorReductionConfig,
}

impl<'a> CurveContext<'a> {
    fn new(
        places: &'a Places,
        mapping: &[usize],
        testing: &[usize],
        answers: usize,
        config: &'a ErrorReductionConfig,
    ) -> Result<Self> {
        config.check()?;
        let wrong = |fault: String| Err(Error::work(format!("error reduction: {fault}")));
        if answers != places.len() {
            let expected = places.len();
            return wrong(format!(
                "{answers} answers; expected {expected}, one a snapshot"
            ));
        }
        let all = || mapping.iter().chain(testing);
        if let Some(index) = all().find(|index| **index >= places.len()) {
            let snapshots = places.len();
            return wrong(format!("snapshot {index}; expected one of {snapshots}"));
        }
        config.map.nearness.check(mapping.len())?;
        let mapping = thinned_snapshots(places, mapping, config.map.most_places);
        let candidates = places.select(&mapping);
        Ok(Self {
            places,
            mapping,
            mapped: covered(places, testing, &candidates),
            candidates,
            config,
        })
    }

    /// One point a prior, `score(prior, truths)` of those that count under it.
    fn curve(
        &self,
        score: impl Fn(Uncertainty, &[usize]) -> Result<ErrorReduction>,
    ) -> Result<Curve> {
        let mut points = Vec::new();
        for &prior in &self.config.priors {
            let truths = held_out::counted(prior, self.places, &self.mapped, &self.candidates);
            if truths.is_empty() {
                continue;
            }
            let score = score(prior, &truths)?;
            // 0 where all candidates are where the truth is: nothing to reduce either.
            if score.prior_error_m > 0.0 {
                points.push(CurvePoint { prior, score });
            }
        }
        if points.is_empty() {
            return Err(Error::work(format!(
                "error reduction: none of {} test snapshots at mapped places has two candidates under any prior; \
                 expected test runs through places of the mapping part, or wider priors",
                self.mapped.len()
            )));
        }
        Ok(Curve { points })
    }
}

#[cfg(test)]
mod tests;
