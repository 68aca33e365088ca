//! Occupancy histogram matching: a place is known again by how much its grid's columns and rows hold of what.
//!
//! Duckett & Nehmzow (2000), *New System*: "the robot's map consists of a list of places added at 1.5 m intervals", each with
//! the histograms of its local grid; the place with the greatest product of the x and the y match is the response.
//! Intervals are distances from the nearest place stored, as [`super::nearest`] has it, by the poses of the mapping part.
//! Without a compass ([`super::local_scan`]) each of the four quarter turns of a scan is matched, at four times the cost.

use super::{
    Learn, ReadyToMatch, Recogniser, Response,
    histogram::{FULL_MATCH, HistogramPair, PairMatch, Sought},
    local_scan::{LocalScans, ScanConfig, check_reach, check_spacing},
    occupancy::{CELL_M, CELLS, States},
};
use crate::{
    error::{Error, Result},
    geometry::Pose,
    recording::{Channel, Observation, Recording},
    seed::Seed,
};
use serde::{Deserialize, Serialize};

/// The constants of histogram matching.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct HistogramMatchConfig {
    /// How a scan becomes a grid.
    pub scan: ScanConfig,
    /// A snapshot this far from all places, or farther, becomes one, in metres (Duckett & Nehmzow 2000: 1.5).
    pub spacing_m: f64,
    /// Histograms are moved by so many cells of 15 cm to either side, at most 63. Not said: by half of `spacing_m`, 5 cells for
    /// 1.5 m, as a robot on the way that was mapped is no farther from the nearest place. The paper prints none; its T
    /// pays for about as many: 31 times what comparing 144 readings costs is eleven or twelve translations of two histograms.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub reach_cells: Option<usize>,
}

impl Default for HistogramMatchConfig {
    fn default() -> Self {
        Self {
            scan: ScanConfig::default(),
            spacing_m: 1.5,
            reach_cells: None,
        }
    }
}

impl HistogramMatchConfig {
    /// # Errors
    /// A usage error that names the first constant out of bounds.
    pub fn check(&self) -> Result<()> {
        check_spacing("histogram_match", self.spacing_m)?;
        check_reach("histogram_match", self.reach_cells.unwrap_or(0))?;
        self.scan.check()
    }

    /// Cells that histograms are moved by at most.
    pub fn reach_cells(&self) -> usize {
        let half = (0.5 * self.spacing_m / CELL_M).round() as usize;
        self.reach_cells.unwrap_or(half).min(CELLS - 1)
    }
}

/// Places by their histograms.
///
/// ```
/// use ballmark::{recogniser::{Learn, Recogniser, histogram_match::HistogramMatch}, seed::Seed, world::corridor};
/// let config = corridor::CorridorConfig { runs: 1, spacing_m: 1.0, ..Default::default() };
/// let recording = corridor::thrun1998(Seed(1), &config)?;
/// let all: Vec<usize> = (0..recording.len()).collect();
/// let places = HistogramMatch::learn(&Default::default(), &recording, &all, Seed(1))?;
/// let first = places.respond(recording.channels(), &recording.observation(0)).unwrap();
/// assert_eq!((first.class, first.fit), (0, 1.0)); // the place itself: 4096 × 4096 of as many
/// # Ok::<(), ballmark::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct HistogramMatch {
    scans: LocalScans,
    /// Unbounded in files that are older than it.
    #[serde(default = "everywhere")]
    reach_cells: usize,
    places: Vec<HistogramPair>,
    poses: Vec<Pose>,
}

fn everywhere() -> usize {
    CELLS - 1
}

impl HistogramMatch {
    /// Where the mapping part had each place.
    pub fn places(&self) -> &[Pose] {
        &self.poses
    }
}

impl Learn for HistogramMatch {
    type Config = HistogramMatchConfig;

    fn learn(
        config: &HistogramMatchConfig,
        recording: &Recording,
        snapshots: &[usize],
        _seed: Seed,
    ) -> Result<Self> {
        config.check()?;
        let compass = recording.columns().compass_rad.is_some();
        let scans = LocalScans::new(&config.scan, recording.channels(), compass)?;
        let places = scans.places(recording, snapshots, config.spacing_m);
        let pair = |(pose, states)| (pose, HistogramPair::of(&states));
        let (poses, places) = places.into_iter().map(pair).unzip();
        Ok(Self {
            scans,
            reach_cells: config.reach_cells(),
            places,
            poses,
        })
    }

    fn check(&self) -> Result<()> {
        self.scans.check()?;
        check_reach("histogram_match", self.reach_cells)?;
        match self.places.len() == self.poses.len() && !self.places.is_empty() {
            true => Ok(()),
            false => Err(Error::work(format!(
                "{} pairs of histograms for {} places; expected one each, and a place at least",
                self.places.len(),
                self.poses.len()
            ))),
        }
    }
}

impl Recogniser for HistogramMatch {
    fn name(&self) -> &'static str {
        "histogram_match"
    }

    fn responses(&self) -> usize {
        self.places.len()
    }

    fn matches(&self) -> usize {
        self.places.len() * self.scans.ways()
    }

    fn bytes_per_place(&self) -> usize {
        size_of::<HistogramPair>() + size_of::<Pose>()
    }

    fn check_channels(&self, channels: &[Channel]) -> Result<()> {
        self.scans.check_channels(channels)
    }

    /// The place of greatest product, the first of several; the fit is the product's share of 4096².
    fn respond(&self, channels: &[Channel], observation: &Observation) -> Option<Response> {
        let states = self.scans.grid(channels, observation)?;
        self.best_of(self.pairs(states).iter())
    }

    fn ready<'a>(
        &'a self,
        channels: &'a [Channel],
        observation: &'a Observation<'a>,
    ) -> ReadyToMatch<'a> {
        let states = self.scans.grid(channels, observation);
        let pairs = states.map(|states| self.pairs(states));
        Box::new(move || self.best_of(pairs.as_ref()?.iter()))
    }
}

impl HistogramMatch {
    /// The histograms of a grid, one pair for each way that the robot may face.
    fn pairs(&self, states: States) -> Vec<HistogramPair> {
        let turns = self.scans.turns(states);
        turns.map(|states| HistogramPair::of(&states)).collect()
    }

    fn best_of<'a>(&self, pairs: impl Iterator<Item = &'a HistogramPair>) -> Option<Response> {
        let mut matches = vec![PairMatch { x: 0, y: 0 }; self.places.len()];
        let mut best: Option<(usize, u32)> = None;
        for pair in pairs {
            Sought::new(pair, self.reach_cells).best_matches(&self.places, &mut matches);
            for (class, matched) in matches.iter().enumerate() {
                let product = matched.product();
                if best.is_none_or(|(_, most)| product > most) {
                    best = Some((class, product));
                }
            }
        }
        best.map(|(class, product)| Response {
            class,
            fit: f64::from(product) / f64::from(FULL_MATCH * FULL_MATCH),
        })
    }
}
