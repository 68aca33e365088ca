//! Who maps and who is tested, and where the robot truly was: the protocol on which systems are compared.
//!
//! D98 (Duckett & Nehmzow 1998), 7: "the first lap of the recorded robot data were used for map building if required, and
//! the remaining data were used for testing."

use super::laps::{Laps, LapsConfig, Trace};
use crate::{
    error::{Error, Result},
    geometry::Pose,
    recording::{
        Recording,
        degraded::Degraded,
        split::{SplitConfig, Unit},
    },
    score::Binning,
    seed::Seed,
};
use serde::{Deserialize, Serialize};
use std::{borrow::Cow, ops::Range};

/// Which part of a recording is learned from; the rest tests.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum Mapping {
    /// The first lap of the first run (both papers).
    #[default]
    FirstLap,
    /// The first run.
    FirstRun,
    /// Stretches, or runs, dealt out in turn: see [`SplitConfig`].
    Split,
}

/// What counts as the true place.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum Truth {
    /// The recording's poses.
    #[default]
    Pose,
    /// Compass-based odometry, corrected lap by lap (D98 5.2, 6.4): all that the paper's robot had. Its frame is the
    /// compass's, with the origin at the recording's start.
    Odometry,
}

/// Which part maps, which tests, and what the truth is.
///
/// ```
/// let config: ballmark::experiment::protocol::ProtocolConfig =
///     toml::from_str("mapping = 'first_lap'\ntruth = 'odometry'\nlaps = { starts_s = [0.0, 492.0, 985.0] }").unwrap();
/// config.check()?;
/// # Ok::<(), ballmark::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct ProtocolConfig {
    /// Which part of a recording is learned from.
    pub mapping: Mapping,
    /// What counts as the true place.
    pub truth: Truth,
    /// The stretches of `mapping = "split"`; its validation part maps too. Without a `test_fold` the first fold is tested on.
    pub split: SplitConfig,
    /// The laps of `mapping = "first_lap"`.
    pub laps: LapsConfig,
}

impl Default for ProtocolConfig {
    /// As D98, but true poses are believed, and a split tests on the first of four folds.
    fn default() -> Self {
        Self {
            mapping: Mapping::default(),
            truth: Truth::default(),
            split: SplitConfig {
                test_fold: Some(0),
                ..SplitConfig::default()
            },
            laps: LapsConfig::default(),
        }
    }
}

impl ProtocolConfig {
    /// # Errors
    /// A usage error that names the key at fault.
    pub fn check(&self) -> Result<()> {
        self.laps.check()?;
        self.split.check()?;
        if self.truth == Truth::Odometry && self.mapping != Mapping::FirstLap {
            return Err(Error::usage(
                "protocol.truth = \"odometry\": drift is removed lap by lap; expected protocol.mapping = \"first_lap\", or \
                 protocol.truth = \"pose\"",
            ));
        }
        Ok(())
    }
}

/// A run that was divided into laps.
#[derive(Debug, Clone, PartialEq)]
pub struct LapsOfRun {
    /// Snapshots of the run.
    pub run: Range<usize>,
    /// Mean length of a lap, metres.
    pub lap_m: f64,
}

/// A recording with its parts and its truth.
#[derive(Debug, Clone)]
pub struct Protocol<'a> {
    /// What is learned from and played back. Its poses are the truth; under [`Truth::Odometry`] they are not those that
    /// came with it, so whoever learns knows no more than the paper's robot.
    pub recording: Cow<'a, Recording>,
    /// Snapshots to learn from, ascending.
    pub mapping: Vec<usize>,
    /// Snapshots to learn from that stop a learning and tune constants, ascending: as `split` deals them, or else so many
    /// stretches of the mapping part; none where that is too short for it.
    pub validation: Vec<usize>,
    /// Snapshots to be tested on, ascending.
    pub testing: Vec<usize>,
    /// The split that dealt the parts, where it is to deal a validation part, too.
    pub split: Option<SplitConfig>,
    /// True place of every snapshot, metres.
    pub place: Vec<[f64; 2]>,
    /// Metres travelled since the start of the run, one a snapshot.
    pub travelled_m: Vec<f64>,
    /// Lap, run or stretch of every snapshot, numbered from 0: what a bootstrap resamples, and what a trial stays in where
    /// there are no laps.
    pub unit: Vec<usize>,
    /// The run that was divided into laps.
    pub laps: Option<LapsOfRun>,
    /// What a table's caption must say of it.
    pub notes: Vec<String>,
}

impl<'a> Protocol<'a> {
    /// Applies a protocol to a recording.
    ///
    /// # Errors
    /// A usage error where the configuration is at fault; a work error where the recording has no laps, one run, no
    /// compass, or too few stretches for what is asked: the message says what to ask for instead.
    pub fn new(recording: &'a Recording, config: &ProtocolConfig) -> Result<Self> {
        config.check()?;
        let mut notes = Vec::new();
        if recording.observation(0).compass_rad.is_none() {
            notes.push("no compass: headings are the robot's own".to_string());
        }
        let mut protocol = Self {
            recording: Cow::Borrowed(recording),
            mapping: Vec::new(),
            validation: Vec::new(),
            testing: Vec::new(),
            split: None,
            place: recording.poses().iter().map(|p| [p.x_m, p.y_m]).collect(),
            travelled_m: recording.travelled_m(),
            unit: vec![0; recording.len()],
            laps: None,
            notes,
        };
        match config.mapping {
            Mapping::FirstLap => protocol.by_laps(config)?,
            Mapping::FirstRun => protocol.by_runs()?,
            Mapping::Split => protocol.by_split(&config.split)?,
        }
        if protocol.split.is_none() {
            let own = protocol.recording.select(&protocol.mapping)?;
            if let Ok(split) = SplitConfig::default().split(&own) {
                let of_mapping = split.validation.iter().map(|&k| protocol.mapping[k]);
                protocol.validation = of_mapping.collect();
            }
        }
        Ok(protocol)
    }

    /// The same with [people in the way](Recording::with_people) of this share of the range beams of what is tested on.
    ///
    /// # Errors
    /// As [`Recording::with_people`].
    pub fn with_people(mut self, share: f64, seed: Seed) -> Result<Self> {
        let crowded = self.recording.with_people(&self.testing, share, seed)?;
        self.recording = Cow::Owned(crowded);
        self.notes.push(format!(
            "people before {:.0} % of the beams of all that is tested on; what was learned knows nothing of them",
            100.0 * share
        ));
        Ok(self)
    }

    /// The same with the noise that a configuration puts on what is tested on.
    ///
    /// # Errors
    /// As [`Recording::with_noise`].
    pub fn with_noise(mut self, degraded: &Degraded, seed: Seed) -> Result<Self> {
        if let Some(noisy) = degraded.noisy(&self.recording, &self.testing, seed)? {
            let noise = noisy.columns().noise.as_ref();
            self.notes.extend(noise.map(|noise| {
                format!(
                    "noise on all that is tested on: {noise}; what was learned knows nothing of it"
                )
            }));
            self.recording = Cow::Owned(noisy);
        }
        Ok(self)
    }

    /// Does the way go on from one snapshot to the next: within a lap, run or stretch, or from lap to lap?
    pub fn is_one_way(&self, from: usize, to: usize) -> bool {
        let of_laps = |laps: &LapsOfRun| laps.run.contains(&from) && laps.run.contains(&to);
        self.unit[from] == self.unit[to] || self.laps.as_ref().is_some_and(of_laps)
    }

    /// A grid of square bins over all places, laid as D98 6.4 lays it.
    ///
    /// # Errors
    /// As [`Binning::search`], and where all places fall into one bin, so that there is nothing to tell.
    pub fn binning(&self, bin_m: f64) -> Result<Binning> {
        let binning = Binning::search(&self.place, bin_m)?;
        match binning.bins() {
            1 => Err(Error::work(format!(
                "binning: all places lie in one bin of {bin_m} m; expected smaller bins, for two or more"
            ))),
            _ => Ok(binning),
        }
    }

    fn by_laps(&mut self, config: &ProtocolConfig) -> Result<()> {
        let runs = self.recording.runs();
        let first = runs[0].clone();
        let trace = match config.truth {
            Truth::Pose => Trace::new(self.place[first.clone()].to_vec()),
            Truth::Odometry if runs.len() > 1 => {
                return Err(Error::work(format!(
                    "protocol.truth = \"odometry\": the recording has {} runs, and odometry doesn't connect them; expected \
                     one run, or protocol.truth = \"pose\"",
                    runs.len()
                )));
            }
            Truth::Odometry => Trace::new(compass_based_odometry(&self.recording)?),
        };
        let laps = match &config.laps.starts_s[..] {
            [] => trace.laps(&config.laps)?,
            starts_s => trace.laps_at(&self.snapshots_at(starts_s, &first)?),
        };
        let starts: Vec<usize> = trace.first_points(&laps);
        self.laps = Some(LapsOfRun {
            run: first.clone(),
            lap_m: laps.length_m,
        });
        for (lap, &start) in starts.iter().enumerate() {
            self.unit[start..first.end].fill(lap);
        }
        for (number, run) in runs.iter().enumerate().skip(1) {
            self.unit[run.clone()].fill(starts.len() - 1 + number);
        }
        // What a hand-made division leaves before the first lap is neither mapped nor tested.
        self.mapping = (starts[0]..starts[1]).collect();
        self.testing = (starts[1]..self.recording.len()).collect();
        if config.truth == Truth::Odometry {
            self.believe(&trace, &laps)?;
        }
        self.count_tested();
        Ok(())
    }

    /// Takes the corrected trace for the truth, with the compass's headings.
    fn believe(&mut self, trace: &Trace, laps: &Laps) -> Result<()> {
        self.place = trace.without_drift(laps);
        self.travelled_m = trace.travelled_m().to_vec();
        let mut columns = self.recording.columns().clone();
        for (k, pose) in columns.pose.iter_mut().enumerate() {
            let heading_rad = columns
                .compass_rad
                .as_ref()
                .map_or(pose.heading_rad, |c| c[k]);
            *pose = Pose::new(self.place[k][0], self.place[k][1], heading_rad);
        }
        self.recording = Cow::Owned(Recording::new(columns)?);
        Ok(())
    }

    /// The first snapshots at or after these stamps.
    fn snapshots_at(&self, starts_s: &[f64], run: &Range<usize>) -> Result<Vec<usize>> {
        let stamps = &self.recording.columns().stamp_s[run.clone()];
        let first_at = |&start_s: &f64| stamps.iter().position(|&stamp_s| stamp_s >= start_s);
        let found: Vec<usize> = starts_s.iter().filter_map(first_at).collect();
        if found.len() < starts_s.len() || !found.is_sorted_by(|a, b| a < b) {
            return Err(Error::work(format!(
                "laps.starts_s: the first run lasts from {} s to {} s; expected starts of laps within it, a snapshot or \
                 more in each",
                stamps[0],
                stamps[stamps.len() - 1]
            )));
        }
        Ok(found)
    }

    fn by_runs(&mut self) -> Result<()> {
        let runs = self.recording.runs();
        if runs.len() < 2 {
            return Err(Error::work(
                "protocol.mapping = \"first_run\": the recording has one run; expected two or more, or protocol.mapping = \
                 \"first_lap\" or \"split\"",
            ));
        }
        for (number, run) in runs.iter().enumerate() {
            self.unit[run.clone()].fill(number);
        }
        self.mapping = runs[0].clone().collect();
        self.testing = (runs[0].end..self.recording.len()).collect();
        self.count_tested();
        Ok(())
    }

    fn by_split(&mut self, config: &SplitConfig) -> Result<()> {
        let config = SplitConfig {
            test_fold: Some(config.test_fold.unwrap_or(0)),
            ..*config
        };
        let split = config.split(&self.recording)?;
        let mut tested = vec![false; self.recording.len()];
        split.test.iter().for_each(|&k| tested[k] = true);
        let starts: Vec<usize> = self.recording.runs().iter().map(|run| run.start).collect();
        for k in 1..tested.len() {
            let new = tested[k] != tested[k - 1] || starts.binary_search(&k).is_ok();
            self.unit[k] = self.unit[k - 1] + usize::from(new);
        }
        self.split = (config.validation_every > 0).then_some(config);
        self.validation = split.validation;
        (self.testing, self.mapping) = (0..tested.len()).partition(|&k| tested[k]);
        let unit = match config.unit {
            Unit::Runs => "runs",
            Unit::Auto | Unit::Stretch(_) => "stretches",
        };
        self.notes.push(format!(
            "learned from and tested on {unit} in turn, not on laps"
        ));
        self.count_tested();
        Ok(())
    }

    fn count_tested(&mut self) {
        if let (Some(&first), Some(&last)) = (self.testing.first(), self.testing.last())
            && self.unit[first] == self.unit[last]
        {
            self.notes.push(
                "tested on a single lap, run or stretch: no interval can be given".to_string(),
            );
        }
    }
}

/// Where odometry and compass together say that the robot was, metres from the start, in the compass's frame: "the
/// relative angular displacement of the turret against the base" (D98 5.2) instead of the wheels' own headings.
fn compass_based_odometry(recording: &Recording) -> Result<Vec<[f64; 2]>> {
    let mut place = [0.0; 2];
    let mut places = vec![place];
    for k in 1..recording.len() {
        let before = recording.observation(k - 1);
        let Some([dx, dy]) = before.north_displacement(&recording.observation(k)) else {
            return Err(Error::work(
                "protocol.truth = \"odometry\": the recording has no compass; expected one, or protocol.truth = \"pose\"",
            ));
        };
        place = [place[0] + dx, place[1] + dy];
        places.push(place);
    }
    Ok(places)
}

#[cfg(test)]
mod tests;
