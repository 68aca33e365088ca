//! A field of the sensor: each reading regressed over places, for sensors that no plan predicts.
//!
//! Where walls do not determine a reading (Wi-Fi, Bluetooth, magnetic field, light, ranges to beacons), its mean at a place
//! is learned from the readings taken around it, and read as a Gaussian likelihood: Ferris, Haehnel & Fox, *Gaussian
//! Processes for Signal Strength-Based Location Estimation* (2006). Here the mean is a kernel regression, which takes one
//! pass over the readings and no inverse of a matrix:
//!
//! ```text
//! w_k(ξ)  = exp(−d(ξ, ξ_k)²/2h² − turn(ξ, ξ_k)²/2ρ²), 0 below e^−4.5 (3 bandwidths)
//! μ_i(ξ)  = Σ_k w_k z_ki / Σ_k w_k                         over the snapshots k that have reading i
//! p_i(ξ)  = (Σ_k w_k [k has i] + 0.1 p_i) / (Σ_k w_k + 0.1)    is there a reading? p_i: its share over all snapshots
//! P(z|ξ)  = Π_i p_i(ξ) ((1−u) N(z_i; μ_i(ξ), σ_i²) + 0.15 u)   over the readings there are
//!         · Π_i (1 − p_i(ξ))                                over those missing
//! ```
//!
//! Readings are counted in deviations from their mean over all snapshots. σ_i is how far readings are off the mean that the
//! *other passes* by their place give: snapshots taken shortly before or after resemble each other more than the next visit
//! will. Only places that another pass came near are judged. Where no reading was taken within 3 bandwidths, nothing is
//! known: the mean is that of all snapshots, with their deviation for σ_i.
//!
//! The factors p_i and 1 − p_i stand only for readings that some snapshot lacked; both are kept above 10⁻³. So a
//! snapshot without any reading tells something where readings go missing in some places more than in others, and nothing
//! where none was ever missing.

mod field_at;
mod likelihood;
mod reading_model;
mod readings;
mod regression;
mod tuning;

pub use field_at::SignalFieldAt;
pub use readings::LabelledReadings;
pub use tuning::{TunedSignalField, fit_tuned};

use super::places::Places;
use crate::{
    error::{Error, Result},
    recording::Channel,
};
use rayon::prelude::*;
use reading_model::ReadingModel;
use regression::Visits;
use serde::{Deserialize, Serialize};

/// The constants of a signal field.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct SignalFieldConfig {
    /// h: deviation of the kernel, in metres.
    pub bandwidth_m: f64,
    /// ρ: deviation of the kernel in heading, in radians; without it heading plays no part, as it plays none along a route.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub bandwidth_rad: Option<f64>,
    /// u: share of readings that have nothing to do with the place.
    pub outliers: f64,
    /// Snapshots of a run closer to each other than this, counted in snapshots, belong to one pass.
    pub pass_snapshots: usize,
    /// Of more training snapshots than this, evenly spaced ones are kept.
    pub most_snapshots: usize,
}

impl Default for SignalFieldConfig {
    fn default() -> Self {
        Self {
            bandwidth_m: 0.6,
            bandwidth_rad: None,
            outliers: 0.05,
            pass_snapshots: 30,
            most_snapshots: 3000,
        }
    }
}

impl SignalFieldConfig {
    /// # Errors
    /// A usage error where a value makes no sense; the message names its key.
    pub fn check(&self) -> Result<()> {
        let wrong = |key: &str, value: String, expected: &str| {
            Err(Error::usage(format!(
                "signal_field.{key} = {value}: expected {expected}"
            )))
        };
        if !(self.bandwidth_m.is_finite() && self.bandwidth_m > 0.0) {
            return wrong(
                "bandwidth_m",
                self.bandwidth_m.to_string(),
                "metres above 0",
            );
        }
        if let Some(rad) = self.bandwidth_rad
            && (rad.is_nan() || rad <= 0.0)
        {
            return wrong("bandwidth_rad", rad.to_string(), "radians above 0");
        }
        if !(self.outliers > 0.0 && self.outliers < 1.0) {
            return wrong(
                "outliers",
                self.outliers.to_string(),
                "a share between 0 and 1",
            );
        }
        for (key, value) in [
            ("pass_snapshots", self.pass_snapshots),
            ("most_snapshots", self.most_snapshots),
        ] {
            if value == 0 {
                return wrong(key, "0".into(), "1 or more");
            }
        }
        Ok(())
    }

    /// ρ, where heading plays a part.
    fn heading_bandwidth_rad(&self) -> Option<f64> {
        self.bandwidth_rad.filter(|rad| rad.is_finite())
    }
}

/// Added to every σ_i², in squared deviations of the readings: a reading that repeated itself by chance is not exact.
const LEAST_VARIANCE: f64 = 1e-4;

/// Fewer judged readings than this say nothing about σ_i; it is then the deviation of all readings.
const FEWEST_JUDGED: usize = 10;

/// The readings of the training snapshots, and how to tell from them what is read at any place.
///
/// ```
/// use ballmark::belief::{Places, signal_field::{LabelledReadings, SignalField, SignalFieldConfig}};
/// use ballmark::recording::Channel;
/// // A corridor of 10 m driven along four times; a beacon at its far end gets 3 dB louder a metre, and is not heard in
/// // the first 2 m.
/// let wifi = Channel { name: "wifi".into(), width: 1, unit: "dBm".into(), bearing_rad: None, maximum: None, offset_m: None };
/// let at_m: Vec<f64> = (0..80).map(|k| 0.5 * f64::from(k % 20)).collect();
/// let run: Vec<i64> = (0..80).map(|k| k / 20).collect();
/// let heard = |&x_m: &f64| if x_m < 2.0 { f32::NAN } else { (3.0 * x_m - 80.0) as f32 };
/// let readings = LabelledReadings {
///     channels: vec![wifi],
///     values: ndarray::Array2::from_shape_vec((80, 1), at_m.iter().map(heard).collect()).unwrap(),
///     places: Places::Route(at_m),
///     run,
///     snapshot: (0..80).collect(),
/// };
/// let field = SignalField::fit(&readings, &SignalFieldConfig::default())?;
/// let here = field.at(&Places::Route(vec![0.5, 5.0, 9.0]))?;
/// assert!((here.mean(1, 0) + 65.0).abs() < 0.1 && here.presence(0, 0) < 0.1);
/// let louder = here.log_likelihood(ndarray::aview1(&[-53.5]))?;
/// assert!(louder[2] > louder[1] && louder[2] > louder[0]);
/// let nothing_heard = here.log_likelihood(ndarray::aview1(&[f32::NAN]))?;
/// assert!(nothing_heard[0] > nothing_heard[1]);
/// # Ok::<(), ballmark::Error>(())
/// ```
#[derive(Debug, Clone)]
pub struct SignalField {
    channels: Vec<Channel>,
    config: SignalFieldConfig,
    visits: Visits,
    /// One a value.
    models: Vec<ReadingModel>,
}

impl SignalField {
    /// Learns the field from training snapshots.
    ///
    /// # Errors
    /// Where a value of `config` makes no sense, the parts of `readings` do not fit one another, no snapshot is left or
    /// none has any reading.
    pub fn fit(readings: &LabelledReadings, config: &SignalFieldConfig) -> Result<Self> {
        config.check()?;
        readings.check()?;
        let readings = readings.evenly(config.most_snapshots);
        let mut models: Vec<ReadingModel> = readings
            .values
            .columns()
            .into_iter()
            .map(|column| ReadingModel::of(&column.to_vec(), config.outliers))
            .collect();
        if models.iter().all(|model| model.presence == 0.0) {
            return Err(Error::work(format!(
                "signal field: none of {} snapshots has a reading; expected at least one",
                readings.len()
            )));
        }
        let bandwidths = (config.bandwidth_m, config.heading_bandwidth_rad());
        let visits = Visits::new(&readings, &models, bandwidths);
        for (model, variance) in
            models
                .iter_mut()
                .zip(variances(&readings, &visits, config.pass_snapshots))
        {
            model.variance = variance;
        }
        Ok(Self {
            channels: readings.channels,
            config: config.clone(),
            visits,
            models,
        })
    }

    /// The field at some places: those of the training snapshots, or the cells of a grid.
    ///
    /// The cells of a [`Grid`](super::Grid) are worked out site by site; without a `bandwidth_rad` all headings of a site
    /// share what is kept of it. A place takes 4 bytes a value, and as much again for values that some training snapshot
    /// lacked: 300,000 cells of 140 values at most 336 MB, or 14 MB with 24 headings that share.
    ///
    /// # Errors
    /// Where the places lie along a route and those of the training snapshots in the plane, or the other way round, or one
    /// is not finite.
    pub fn at(&self, places: &Places) -> Result<SignalFieldAt> {
        SignalFieldAt::new(self, places)
    }

    /// The sensors whose readings these are, in their order.
    pub fn channels(&self) -> &[Channel] {
        &self.channels
    }

    /// The constants that it was fitted with.
    pub fn config(&self) -> &SignalFieldConfig {
        &self.config
    }

    /// Training snapshots that are kept.
    pub fn snapshots(&self) -> usize {
        self.visits.len()
    }

    /// σ_i of every value, in the unit of the readings: how far they are off what other passes say.
    pub fn spread(&self) -> Vec<f64> {
        let spread = |model: &ReadingModel| model.variance.sqrt() * model.deviation;
        self.models.iter().map(spread).collect()
    }

    /// What a robot must hold to make the field at any place: of every training snapshot its readings and its place, 4
    /// bytes a number, and of every value mean, deviation and σ_i.
    pub fn bytes(&self) -> usize {
        let values = self.models.len();
        let numbers_of_place = self.visits.numbers_of_place();
        (self.visits.len() * (values + numbers_of_place) + 3 * values) * size_of::<f32>()
    }
}

/// σ_i² of every value, in squared deviations: mean square by which readings are off what the other passes by their place say.
fn variances(readings: &LabelledReadings, visits: &Visits, pass_snapshots: usize) -> Vec<f64> {
    let residuals: Vec<Vec<f32>> = (0..visits.len())
        .into_par_iter()
        .map(|k| visits.residuals(k, |other| readings.is_one_pass(k, other, pass_snapshots)))
        .collect();
    // One after the other, so that the sums are the same with any number of threads.
    let variance = |value: usize| {
        let squares = residuals.iter().map(|of| f64::from(of[value]).powi(2));
        let judged: Vec<f64> = squares.filter(|square| square.is_finite()).collect();
        if judged.len() < FEWEST_JUDGED {
            return 1.0;
        }
        judged.iter().sum::<f64>() / judged.len() as f64 + LEAST_VARIANCE
    };
    (0..readings.values.ncols()).map(variance).collect()
}

#[cfg(test)]
mod tests;
