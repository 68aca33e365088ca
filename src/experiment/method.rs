//! Whoever can be asked in localisation trials where the robot is, as a value.

use super::{
    kept_evidence::SingleSnapshots, more_particles::FewerParticles,
    recorded_answers::RecordedAnswers, stopwatch::ready_ms,
};
use crate::{
    belief::OdometryMotion,
    detector::Detector,
    error::Result,
    learning::error_reduction::ErrorReduction,
    localiser::{Localiser, PreparedSensorModel, SensorModel, sensor_model::DetectorAnswers},
    mapping::OccupancyMap,
    recording::Recording,
};
use std::sync::Arc;

/// Someone who can be asked where the robot is.
pub struct Method<'a> {
    /// Key in results.
    pub name: String,
    /// In words, for tables.
    pub title: String,
    /// Of a kernel, as tuned on the validation part for a global prior.
    pub bandwidth: Option<f64>,
    /// What the map keeps of a place besides its pose, in bytes.
    pub bytes_per_place: Option<usize>,
    /// Whether the robot fills its map of places itself, from the rest of what it holds.
    pub fills_map: bool,
    /// What the robot must hold besides the places: networks, or a map that is none of places. In bytes.
    pub other_bytes: usize,
    /// What the filter believes of odometry, where the configuration names nothing; `None`: as the first model learned.
    pub motion: Option<OdometryMotion>,
    /// Milliseconds that a snapshot takes alone on one thread, where what the sensors say of all snapshots was worked out with
    /// the method; its steps are timed with them.
    pub ready_ms: f64,
    /// Power of its evidence, where it is known; `None`: it is tuned.
    pub evidence_scale: Option<f64>,
    /// Power of its evidence, where no sequence of the validation part is there to tune it on.
    pub usual_scale: f64,
    /// The sensor model prepared for the validation part of what the models learned from, where it is one that is prepared
    /// for the unseen part: its evidence is tuned there. Without it the evidence counts as usual.
    pub validation: Option<Arc<dyn PreparedSensorModel + 'a>>,
    /// Error reduction of one snapshot on the unseen part, one a prior of the
    /// [context](super::methods::MethodContext::priors); empty where it is not known.
    pub held_out: Vec<ErrorReduction>,
    /// What it says of single snapshots, where that is kept for products.
    pub single_snapshots: Option<Arc<SingleSnapshots>>,
    /// The map that it works from, where that is an occupancy map.
    pub plan: Option<Arc<OccupancyMap>>,
    /// The same method with fewer particles, where that plays beside it.
    pub fewer_particles: Option<FewerParticles>,
    /// Who answers.
    pub answers: AnswersBy<'a>,
}

/// Who answers in a trial.
pub enum AnswersBy<'a> {
    /// The grid Bayes filter by odometry alone.
    Odometry,
    /// The filter with a sensor model.
    Sensor(Arc<dyn SensorModel + 'a>),
    /// The filter with a sensor model that is prepared for the unseen part of the run.
    PreparedSensor(Arc<dyn PreparedSensorModel + 'a>),
    /// Anybody who answers with places in the plane.
    Localiser(Box<dyn Localiser + 'a>),
    /// Somebody who was asked elsewhere, by what was answered there.
    Recorded(RecordedAnswers),
    /// Nobody, for the reason given: a row of the table that says so, where one method of many can't be made.
    Nobody(String),
}

impl AnswersBy<'_> {
    /// Is it the grid Bayes filter, with a sensor or without?
    pub(super) fn is_grid_filter(&self) -> bool {
        !matches!(
            self,
            Self::Localiser(_) | Self::Recorded(_) | Self::Nobody(_)
        )
    }
}

/// What features are in snapshots.
#[derive(Debug, Clone)]
pub struct FeatureAnswers {
    /// In those of the run that are asked about.
    pub run: DetectorAnswers,
    /// Milliseconds that a snapshot takes alone on one thread.
    pub ready_ms: f64,
    /// In those of the validation part that are asked about, where what the models learned from is at hand.
    pub source: Option<DetectorAnswers>,
}

impl FeatureAnswers {
    /// What a detector answers to these snapshots of a run, and how long it takes for one.
    ///
    /// # Errors
    /// Where the recording lacks the detector's sensors.
    pub fn of_run(detector: &dyn Detector, run: &Recording, asked: &[usize]) -> Result<Self> {
        let detect = |k| detector.detect(&run.observation(k)).map(drop);
        Ok(Self {
            run: DetectorAnswers::of(detector, run, asked)?,
            ready_ms: ready_ms(asked, detect)?,
            source: None,
        })
    }
}

/// A method of which nothing else is known.
pub(super) fn method<'a>(
    name: &str,
    title: &str,
    bytes_per_place: Option<usize>,
    answers: AnswersBy<'a>,
) -> Method<'a> {
    Method {
        name: name.into(),
        title: title.into(),
        bandwidth: None,
        bytes_per_place,
        fills_map: false,
        other_bytes: 0,
        ready_ms: 0.0,
        evidence_scale: None,
        usual_scale: 1.0,
        validation: None,
        motion: None,
        held_out: Vec::new(),
        single_snapshots: None,
        plan: None,
        fewer_particles: None,
        answers,
    }
}
