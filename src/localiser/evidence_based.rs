//! Evidence-based localisation: of the places that look like this, those remain that also looked right on the way here.
//!
//! Duckett & Nehmzow (1998, below D98), 3.1 and 3.2. A map of places is learned ([`super::place_map`]). A robot that is put
//! down somewhere keeps a set of hypotheses, one for each place that looks like what it sees ([`Hypotheses`]); as it drives,
//! each new hypothesis inherits from the old one that it continues best. The response is the place of the most probable
//! hypothesis, and the posterior their coordinates and probabilities, which between iterations move with the robot while the
//! response stays. What the paper leaves open is settled thus:
//!
//! - where no place passes T there is no answer until one does; the hypotheses are kept and reckoned on, and the next
//!   observation is tried;
//! - "moved by a distance 2D" is the way travelled by odometry since the last iteration;
//! - probabilities are kept as logarithms: a set that was led astray has terms of eq. 9 too small for a number, and
//!   0/0 would be the end of it;
//! - the map lies in the frame that hypotheses move in ([`super::place_map::Coordinates`]); the posterior is told in that of
//!   the mapping part's poses, each hypothesis by how far the two differ at its place;
//! - a robot without compass is reckoned from the heading of the place it may be in, see [`super::place_map`].

mod hypotheses;

pub use hypotheses::{Hypotheses, Hypothesis};

use super::{
    Learn, Localiser, Step, TrialRunner,
    place_map::{PlaceMap, PlaceMapConfig},
    prepared::Prepared,
};
use crate::{
    error::{Error, Result},
    geometry::Pose,
    recording::{Channel, Recording},
    seed::{Seed, Stream},
};
use hypotheses::Sight;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

/// The constants printed in D98, 3.1 and 3.2.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct EvidenceBasedConfig {
    /// The map: D, T and the weights of the channels.
    pub map: PlaceMapConfig,
    /// w_ex: width of the likelihood of a sensor difference (eq. 2).
    pub exteroceptive_width: f64,
    /// w_pr, in units of D: width of the match of two places (eq. 7).
    pub proprioceptive_width: f64,
    /// γ: share by which a variance grows from one iteration to the next (eq. 6).
    pub variance_growth: f64,
}

impl Default for EvidenceBasedConfig {
    fn default() -> Self {
        Self {
            map: PlaceMapConfig::default(),
            exteroceptive_width: 1.5,
            proprioceptive_width: 4.0,
            variance_growth: 0.05,
        }
    }
}

impl EvidenceBasedConfig {
    /// # Errors
    /// A usage error where a constant makes no sense; the message names its key.
    pub fn check(&self) -> Result<()> {
        self.map.check().map_err(|e| e.context("evidence_based"))?;
        for (key, value, least) in [
            ("exteroceptive_width", self.exteroceptive_width, 1e-3),
            ("proprioceptive_width", self.proprioceptive_width, 1e-3),
            ("variance_growth", self.variance_growth, 0.0),
        ] {
            if !(least..=1e6).contains(&value) {
                return Err(Error::usage(format!(
                    "evidence_based.{key} = {value}: expected {least} to a million"
                )));
            }
        }
        Ok(())
    }
}

/// A map, and how to localise with it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct EvidenceBased {
    config: EvidenceBasedConfig,
    map: PlaceMap,
}

impl EvidenceBased {
    /// The map that was learned.
    pub fn map(&self) -> &PlaceMap {
        &self.map
    }
}

struct Prepare<'a> {
    evidence: &'a EvidenceBased,
    recording: &'a Recording,
    sights: Prepared<Option<Sight>>,
}

impl TrialRunner for Prepare<'_> {
    fn play(&self, trial: &[usize], _: Option<Pose>, stream: &mut Stream) -> Result<Vec<Step>> {
        let mut robot = Hypotheses::none(self.evidence);
        let step = |&k: &usize| {
            let sight = self.sights.get(k)?.as_ref();
            Ok(robot.take_in(&self.recording.observation(k), sight, stream))
        };
        trial.iter().map(step).collect()
    }
}

impl Localiser for EvidenceBased {
    fn name(&self) -> &'static str {
        "evidence_based"
    }

    fn places(&self) -> usize {
        self.map.places().len()
    }

    fn bytes_per_place(&self) -> usize {
        self.map.bytes_per_place()
    }

    /// Those with d_m < T (D98 3.2).
    fn candidates(&self, recording: &Recording, snapshots: &[usize]) -> Option<f64> {
        let threshold = self.map.config().threshold;
        let passing = |&k: &usize| {
            let observation = recording.observation(k);
            let signature = self.map.signature(recording.channels(), &observation)?;
            let differences = self.map.differences(&signature);
            Some(
                differences
                    .iter()
                    .filter(|d| f64::from(**d) < threshold)
                    .count(),
            )
        };
        let passed: usize = snapshots.iter().filter_map(passing).sum();
        let all = snapshots.len() * self.map.places().len();
        (all > 0).then(|| passed as f64 / all as f64)
    }

    fn check_channels(&self, channels: &[Channel]) -> Result<()> {
        self.map.check_channels(channels)
    }

    fn prepare<'a>(
        &'a self,
        recording: &'a Recording,
        snapshots: &[usize],
    ) -> Result<Box<dyn TrialRunner + 'a>> {
        self.check_channels(recording.channels())?;
        let sight = |&k: &usize| {
            let signature = self
                .map
                .signature(recording.channels(), &recording.observation(k))?;
            let differences = Some(self.map.differences(&signature));
            Some(Sight {
                signature,
                differences,
            })
        };
        Ok(Box::new(Prepare {
            evidence: self,
            recording,
            sights: Prepared::new(snapshots, snapshots.par_iter().map(sight).collect()),
        }))
    }
}

impl Learn for EvidenceBased {
    type Config = EvidenceBasedConfig;

    /// Builds the map; nothing else is learned.
    fn learn(
        config: &EvidenceBasedConfig,
        recording: &Recording,
        snapshots: &[usize],
        _: Seed,
    ) -> Result<Self> {
        config.check()?;
        let map = PlaceMap::build(&config.map, recording, snapshots);
        Ok(Self {
            config: config.clone(),
            map: map.map_err(|e| e.context("evidence_based"))?,
        })
    }

    fn check(&self) -> Result<()> {
        self.config.check()?;
        self.map.check()
    }
}
