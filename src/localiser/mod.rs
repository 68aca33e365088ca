//! A run is replayed, and the localiser answers where it may be, from what it remembers of the run.
//!
//! Duckett & Nehmzow, *Mobile robot self-localisation and measurement of performance in middle-scale environments* (1998,
//! below D98), play the same recorded run to systems as black boxes: each learns from the first lap, then is put down
//! somewhere, again and again, and answers as it goes. A [`Localiser`] is such a system; [`Localiser::prepare`] takes in
//! the recording, and [`TrialRunner::play`] plays one trial.
//!
//! ```
//! use ballmark::{localiser::{self, Estimate, Kind, Learned}, seed::Seed, world::corridor};
//! let config = corridor::CorridorConfig { runs: 2, spacing_m: 1.0, ..Default::default() };
//! let recording = corridor::thrun1998(Seed(1), &config)?;
//! let (first, second): (Vec<usize>, Vec<usize>) = (0..recording.len()).partition(|k| recording.runs()[0].contains(k));
//!
//! let kind: Kind = "dead_reckoning".parse()?;
//! let learned = localiser::learn(&kind.default_config(), &recording, &first, Seed(1))?;
//! let player = learned.as_localiser().prepare(&recording, &second)?;
//! let start = recording.poses()[second[0]];
//! let steps = player.play(&second[..10], Some(start), &mut Seed(1).stream("a trial"))?;
//! assert_eq!(steps.len(), 10);
//! assert_eq!(steps[0].estimate, Some(Estimate::Place([start.x_m, start.y_m])));
//! # Ok::<(), ballmark::Error>(())
//! ```
//!
//! A localiser of another crate implements [`Localiser`], and its constants [`LocaliserConfig`]: `examples/own_localiser.rs`.
//! A new built-in one is one file, which implements [`Localiser`] and [`Learn`], and one line in the registry below.
//!
//! A [`LiveLocaliser`] is for a robot that drives now, without a recording. What sensors say about the place is a
//! [`SensorModel`], the same for both.

pub mod bayes;
pub mod codes;
pub mod dead_reckoning;
pub mod evidence_based;
mod filter;
pub mod landmark_classifier;
pub mod likelihood_field;
pub mod live;
pub mod local_grid;
pub mod memoryless;
pub mod monte_carlo;
pub mod place_map;
pub mod prepared;
pub mod reckoned;
pub mod responses;
pub mod restart;
pub mod self_labels;
pub mod sensor_model;
mod sites;

pub use filter::BayesLocaliser;
pub use live::{LiveConfig, LiveLocaliser};
pub use restart::RestartConfig;
pub use self_labels::{SelfLabel, SelfLabelConfig};
pub use sensor_model::{PreparedSensorModel, SensorModel};
pub use sites::Sites;

pub use crate::belief::lost::{self, LostConfig};
use crate::{
    error::Result,
    geometry::Pose,
    recording::{Channel, Recording},
    registry::{Constants, boxed_config},
    seed::{Seed, Stream},
};
use serde::{Deserialize, Serialize, de::DeserializeOwned};
use std::path::PathBuf;

/// Where a localiser says that it is.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub enum Estimate {
    /// The number of a place, class or pattern, which only the localiser can interpret.
    Class(usize),
    /// A place in the plane, x and y in metres, in the frame of the recording's poses.
    Place([f64; 2]),
}

/// A place in the plane, x and y in metres, and how probable it is to be there.
pub type Probable = ([f64; 2], f64);

/// What a localiser says after one snapshot of a trial.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Step {
    /// Its answer; `None`: it knows no place that would fit.
    pub estimate: Option<Estimate>,
    /// The heading that goes with it, in radians, in the frame of the recording's poses; `None` where it gives none.
    pub heading_rad: Option<f64>,
    /// How probable it holds which places: probabilities sum to 1, a place may come more than once. Empty where the
    /// localiser has no such opinion.
    pub posterior: Vec<Probable>,
}

/// A localiser that has learned what it needs to know; any number of trials can be played to it.
pub trait Localiser: Send + Sync {
    /// Its name in messages.
    fn name(&self) -> &str;

    /// Number of places or patterns that it keeps; 0 where it keeps none.
    fn places(&self) -> usize;

    /// What it keeps of a place, pose included, in bytes; 0 where it keeps none.
    fn bytes_per_place(&self) -> usize;

    /// Does it ask for the true pose that a trial starts at? If not, it is lost at the start.
    fn asks_for_the_start(&self) -> bool {
        false
    }

    /// Is that pose a help that it can do without? Then it is given where the start counts as known, and else it is lost.
    fn can_start_anywhere(&self) -> bool {
        !self.asks_for_the_start()
    }

    /// Power that it takes the likelihood of what its sensors say to; `None` where it has no such constant.
    fn evidence_scale(&self) -> Option<f64> {
        None
    }

    /// The same localiser with another such power, for whoever tunes it; `None` where there is none, or its constants state it.
    fn with_evidence_scale(&self, scale: f64) -> Option<Box<dyn Localiser + '_>> {
        let _ = scale;
        None
    }

    /// Share of its places that a snapshot of these does not rule out at once, on average; `None` where it does not sift them.
    fn candidates(&self, recording: &Recording, snapshots: &[usize]) -> Option<f64> {
        let _ = (recording, snapshots);
        None
    }

    /// Does it never look at its sensors? Then, once its estimate is outside of all mapped places, it counts as outside
    /// for the rest of the trial (D98 7.1).
    fn is_blind(&self) -> bool {
        false
    }

    /// Are these the sensors that it learned from?
    ///
    /// # Errors
    /// Where a channel is missing or has another width or unit; the message names it.
    fn check_channels(&self, channels: &[Channel]) -> Result<()>;

    /// Gets ready to play trials among these snapshots of a recording. What single snapshots tell is worked out here, once
    /// for all trials. It works from [`Recording::observation`] alone, never from poses or route.
    ///
    /// # Errors
    /// As [`Localiser::check_channels`].
    fn prepare<'a>(
        &'a self,
        recording: &'a Recording,
        snapshots: &[usize],
    ) -> Result<Box<dyn TrialRunner + 'a>>;
}

/// A localiser with a recording before it.
pub trait TrialRunner: Sync {
    /// Plays a trial: snapshots among those prepared, of one run, in the order driven; some may be left out between them.
    /// `start` is the true pose at the first one, where it is given and the localiser
    /// [asks for it](Localiser::asks_for_the_start). One step a snapshot, and none of them depends on later snapshots.
    ///
    /// # Errors
    /// Where a belief falls apart, which is the localiser's fault, not the recording's.
    fn play(&self, trial: &[usize], start: Option<Pose>, stream: &mut Stream) -> Result<Vec<Step>>;
}

/// Constants that a localiser is learned with: a built-in [`Config`], or a type of one's own.
pub trait LocaliserConfig: Constants + BoxedLocaliserConfig {
    /// Learns from some snapshots of a recording (the mapping part), in the order driven. Randomness comes from streams of
    /// `seed`.
    ///
    /// # Errors
    /// Where a constant makes no sense (a usage error), or the snapshots are not enough to learn from.
    fn learn(
        &self,
        recording: &Recording,
        snapshots: &[usize],
        seed: Seed,
    ) -> Result<Box<dyn Localiser>>;
}

boxed_config!(LocaliserConfig, BoxedLocaliserConfig);

/// What a member of the registry can do besides: learn, and be kept in a file.
pub trait Learn: Localiser + Serialize + DeserializeOwned {
    /// Its constants; the default is what the papers print, or else says why.
    type Config: Default;

    /// Learns from some snapshots of a recording (the mapping part), in the order driven. Randomness comes from streams of
    /// `seed`.
    ///
    /// # Errors
    /// Where a constant makes no sense (a usage error), or the snapshots are not enough to learn from.
    fn learn(
        config: &Self::Config,
        recording: &Recording,
        snapshots: &[usize],
        seed: Seed,
    ) -> Result<Self>;

    /// Checks what may have come from a file, so that it can be used without fear.
    ///
    /// # Errors
    /// Where its parts don't fit one another; the message names the fault.
    fn check(&self) -> Result<()>;
}

/// The registry: what a member is called in code, its file (which is its name), its constants, and what it is.
macro_rules! members {
    ($then:ident) => {
        $then! {
            EvidenceBased, evidence_based, EvidenceBasedConfig, "Evidence-based localisation of Duckett & Nehmzow (1998).", formerly "evidence";
            LandmarkClassifier, landmark_classifier, LandmarkClassifierConfig, "Nearest neighbour on the places of its map.";
            Memoryless, memoryless, MemorylessConfig, "Any recogniser, which answers by what is seen now.";
            DeadReckoning, dead_reckoning, DeadReckoningConfig, "Dead reckoning from a known start, never corrected.";
            Bayes, bayes, BayesConfig, "BaLL's grid Bayes filter over learned features (Thrun 1998).";
            LocalGrid, local_grid, LocalGridConfig, "Correction by the nearest expected perception around the reckoned pose (Ruiz-Mayor et al. 2006).";
        }
    };
}

macro_rules! registry {
    ($($members:tt)*) => {
        crate::registry::registry! {
            "localiser", Localiser, as_localiser, File, "ballmark_localiser", "localiser";
            $($members)*
        }
    };
}
members!(registry);

impl Constants for Config {
    fn kind(&self) -> &str {
        Config::kind(self).name()
    }

    fn description(&self) -> &str {
        Config::kind(self).what()
    }

    fn check(&self) -> Result<()> {
        Config::check(self)
    }

    fn model(&mut self) -> Option<&mut PathBuf> {
        match self {
            Config::Bayes(config) => Some(&mut config.model),
            Config::Memoryless(config) => config.recogniser.model(),
            _ => None,
        }
    }

    fn world(&mut self) -> Option<&mut PathBuf> {
        match self {
            Config::LocalGrid(config) => Some(&mut config.world),
            _ => None,
        }
    }

    fn files(&mut self) -> Vec<&mut PathBuf> {
        match self {
            Config::LocalGrid(config) => vec![&mut config.world],
            other => other.model().into_iter().collect(),
        }
    }
}

impl LocaliserConfig for Config {
    fn learn(
        &self,
        recording: &Recording,
        snapshots: &[usize],
        seed: Seed,
    ) -> Result<Box<dyn Localiser>> {
        learn(self, recording, snapshots, seed).map(Learned::boxed)
    }
}

pub mod laws;
