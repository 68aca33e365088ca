//! Sensor models that the grid Bayes filter is driven by in comparisons: `kind = "bayes"` with `landmarks = …`.
//!
//! A kind is a type of constants that makes a [`Method`] of the mapping part. Several at once multiply, as if they erred
//! independently of each other. One's own implements [`SensorModelConfig`] and is added to a
//! [`Registry`](super::compare::Registry).

use super::{
    kernels::{Moved, VIEWS, kernel, kernel_views},
    learned_row::{Rounded, learned_features, random_bits},
    maps::RangeMaps,
    method::{AnswersBy, Method, method},
    methods::MethodContext,
    same_sensor::refuse_other_sensor,
    signal_row::signal_field,
};
use crate::{
    detector::{DetectorConfig, HandMade, ceiling_light::CeilingLight, door::DoorConfig},
    error::{Error, Result},
    localiser::sensor_model::Compass,
    model::{Model, seen},
    recogniser::{self, RecogniserConfig},
    registry::{Constants, boxed_config},
};
use serde::{Deserialize, Serialize};
use std::{
    path::{Path, PathBuf},
    sync::Arc,
};

/// Constants of a sensor model: [`Landmarks`], or a type of one's own.
pub trait SensorModelConfig: Constants + BoxedSensorModelConfig {
    /// The Bayes filter with the sensor model, fitted to the training part of the context; its evidence is tuned on the
    /// validation part by whoever plays.
    ///
    /// # Errors
    /// Where the recording lacks a sensor, or gives nothing to fit.
    fn method<'a>(&self, context: &MethodContext<'a>) -> Result<Method<'a>>;
}

boxed_config!(SensorModelConfig, BoxedSensorModelConfig);

/// What the built-in sensor models tell places apart by.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(tag = "kind", rename_all = "snake_case")]
#[non_exhaustive]
pub enum Landmarks {
    /// Features that a model has learned (Thrun 1998).
    Learned(LearnedLandmarks),
    /// The same, each rounded to a bit.
    LearnedBits(LearnedLandmarks),
    /// Doors.
    Door(DoorConfig),
    /// Ceiling lights.
    CeilingLight(CeilingLight),
    /// Signs of random projections.
    RandomBits(RandomBitsLandmarks),
    /// The scans themselves.
    Kernel(KernelLandmarks),
    /// The scans, seen from moved places as well.
    KernelViews(KernelViewsLandmarks),
    /// The responses of a recogniser.
    Recogniser(RecogniserLandmarks),
    /// The likelihood field of an occupancy map.
    LikelihoodField(LikelihoodFieldLandmarks),
    /// The beam model on scans rendered from that map.
    BeamModel(BeamModelLandmarks),
    /// Each reading regressed over places.
    SignalField(SignalFieldLandmarks),
    /// A compass.
    Compass(CompassLandmarks),
}

/// Of learned features.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct LearnedLandmarks {
    /// File of the model; not said: the system's own.
    pub model: PathBuf,
}

/// Of random bits.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct RandomBitsLandmarks {
    /// Their number.
    pub bits: usize,
}

impl Default for RandomBitsLandmarks {
    fn default() -> Self {
        Self { bits: 64 }
    }
}

/// Of the raw-scan kernel: none, as its bandwidth is tuned on the validation part.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct KernelLandmarks {}

/// Of the kernel over moved views.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct KernelViewsLandmarks {
    /// Moved views besides the recorded one.
    pub views: usize,
    /// Of what.
    pub moved: Moved,
}

impl Default for KernelViewsLandmarks {
    fn default() -> Self {
        Self {
            views: VIEWS,
            moved: Moved::default(),
        }
    }
}

/// Of a recogniser's responses.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RecogniserLandmarks {
    /// Its kind and constants.
    pub recogniser: recogniser::Config,
}

/// Of the likelihood field.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct LikelihoodFieldLandmarks {
    /// File of a ROS map (its YAML) in the frame of the recording's poses; not said: the section's `map`, and else a map that
    /// the mapping part's scans draw.
    pub map: PathBuf,
}

/// Of the beam model.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct BeamModelLandmarks {
    /// As that of the likelihood field.
    pub map: PathBuf,
}

/// Of the signal field.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct SignalFieldLandmarks {}

/// Of a compass.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct CompassLandmarks {
    /// Standard deviation expected of a heading, radians. Assumed: steel and cables turn compasses by some ten degrees
    /// indoors.
    pub sd_rad: f64,
}

impl Default for CompassLandmarks {
    fn default() -> Self {
        Self { sd_rad: 0.2 }
    }
}

/// Most bits, and most views.
const MOST: usize = 4096;

impl Landmarks {
    /// The names of all of them.
    pub const NAMES: [&'static str; 12] = [
        "learned",
        "learned_bits",
        "door",
        "ceiling_light",
        "random_bits",
        "kernel",
        "kernel_views",
        "recogniser",
        "likelihood_field",
        "beam_model",
        "signal_field",
        "compass",
    ];
}

impl Constants for Landmarks {
    fn kind(&self) -> &str {
        let number = match self {
            Self::Learned(_) => 0,
            Self::LearnedBits(_) => 1,
            Self::Door(_) => 2,
            Self::CeilingLight(_) => 3,
            Self::RandomBits(_) => 4,
            Self::Kernel(_) => 5,
            Self::KernelViews(_) => 6,
            Self::Recogniser(_) => 7,
            Self::LikelihoodField(_) => 8,
            Self::BeamModel(_) => 9,
            Self::SignalField(_) => 10,
            Self::Compass(_) => 11,
        };
        Self::NAMES[number]
    }

    fn check(&self) -> Result<()> {
        let counted = |key: &str, count: usize| match (1..=MOST).contains(&count) {
            true => Ok(()),
            false => Err(Error::usage(format!(
                "{}.{key} = {count}: expected 1 to {MOST}",
                self.kind()
            ))),
        };
        match self {
            Self::Door(config) => config.check(),
            Self::CeilingLight(light) => light.check(),
            Self::RandomBits(config) => counted("bits", config.bits),
            Self::KernelViews(config) => counted("views", config.views),
            Self::Recogniser(config) => config.recogniser.check(),
            Self::Compass(config) => Compass::new(0.0, config.sd_rad).map(|_| ()),
            _ => Ok(()),
        }
    }

    fn model(&mut self) -> Option<&mut PathBuf> {
        match self {
            Self::Learned(config) | Self::LearnedBits(config) => Some(&mut config.model),
            Self::Recogniser(config) => config.recogniser.model(),
            _ => None,
        }
    }

    fn files(&mut self) -> Vec<&mut PathBuf> {
        match self {
            Self::LikelihoodField(config) => vec![&mut config.map],
            Self::BeamModel(config) => vec![&mut config.map],
            other => other.model().into_iter().collect(),
        }
    }
}

impl SensorModelConfig for Landmarks {
    fn method<'a>(&self, context: &MethodContext<'a>) -> Result<Method<'a>> {
        let name = self.kind();
        let hand_made = |detector: &HandMade| {
            let source = context.source()?;
            let detector = detector.fit(&source.recording, &source.training)?;
            context.detector(name, name, detector.as_ref())
        };
        match self {
            Self::Learned(config) => from_file(context, &config.model, Rounded::No, name),
            Self::LearnedBits(config) => from_file(context, &config.model, Rounded::ToBits, name),
            Self::Door(config) => hand_made(&HandMade::Door(config.clone())),
            Self::CeilingLight(light) => hand_made(&HandMade::CeilingLight(light.clone())),
            Self::RandomBits(config) => random_bits(context, config.bits, name),
            Self::Kernel(_) => kernel(context),
            Self::KernelViews(config) => kernel_views(context, config.views, config.moved),
            Self::Recogniser(config) => {
                let source = context.source()?;
                let (recording, training) = (&source.recording, &source.training);
                let learned = RecogniserConfig::learn(
                    &config.recogniser,
                    recording,
                    training,
                    context.seed(),
                )?;
                context.recogniser(name, name, learned)
            }
            Self::LikelihoodField(config) => {
                let maps = maps(context, &config.map)?;
                maps.in_filter(&maps.field()?)
            }
            Self::BeamModel(config) => maps(context, &config.map)?.beam_model(),
            Self::SignalField(_) => {
                let field = signal_field(context)?;
                field
                    .ok_or_else(|| no_sensor("no scan and no picture, or one of 64 values at most"))
            }
            Self::Compass(config) => by_compass(context, config),
        }
    }
}

/// Maps from the file that a sensor model names, else from that of the whole section, else from scans.
fn maps<'a, 'b>(context: &'b MethodContext<'a>, given: &Path) -> Result<RangeMaps<'a, 'b>> {
    let given = match given.as_os_str().is_empty() {
        true => &context.config.map,
        false => given,
    };
    let maps = RangeMaps::new(context, given)?;
    maps.ok_or_else(|| no_sensor("a range sensor whose beams have bearings"))
}

fn no_sensor(expected: &str) -> Error {
    Error::work(format!("not for these channels; expected {expected}"))
}

/// The features of a model in a file, which must not have learned from what is tested.
fn from_file<'a>(
    context: &MethodContext<'a>,
    file: &Path,
    rounded: Rounded,
    name: &str,
) -> Result<Method<'a>> {
    let model = Model::read(file)?;
    let source = context.source()?;
    let mapping: Vec<usize> = [&source.training[..], &source.validation].concat();
    let learned = seen::learned_poses(&model.pose, &source.recording, &mapping);
    if !seen::is_chance(learned) {
        return Err(Error::file(
            file,
            format!(
                "the model has learned from {learned} snapshots of this recording that are not among those to learn from; \
                 expected one trained on these alone"
            ),
        ));
    }
    let own = source.recording.columns().dataset_sha256.as_deref();
    if own.is_some() && own == model.header.dataset_sha256.as_deref() {
        refuse_other_sensor(&model, &source.recording).map_err(|e| e.in_file(file))?;
    }
    let title = format!("{} {name}", model.features());
    learned_features(context, &model, rounded, name, &title).map_err(|e| e.in_file(file))
}

/// The heading of a compass, which says nothing of the place.
fn by_compass<'a>(context: &MethodContext<'a>, config: &CompassLandmarks) -> Result<Method<'a>> {
    let source = context.source()?;
    let zero_rad = Compass::zero_rad(&source.recording, &source.training)
        .ok_or_else(|| no_sensor("a recording with `compass`"))?;
    let sensor = Compass::new(zero_rad, config.sd_rad)?;
    let answers = AnswersBy::Sensor(Arc::new(sensor));
    Ok(method("compass", "compass", None, answers))
}
