//! Occupancy grid matching: a place is known again by laying the grid of a scan on that of the place.
//!
//! Yamauchi & Langley, *Place recognition in dynamic environments* (1997), as Duckett & Nehmzow (2000) use it: a grid for each
//! place, places 1.5 m from one another, and "the best matching grid pattern determines the location of the robot". Their
//! hill climb over translations may end short of the best; [`super::alignment`] finds the best, and sooner.

use super::{
    Learn, ReadyToMatch, Recogniser, Response,
    alignment::SoughtGrid,
    local_scan::{LocalScans, ScanConfig, check_reach, check_spacing},
    occupancy::{CELLS, States},
};
use crate::{
    error::{Error, Result},
    geometry::Pose,
    recording::{Channel, Observation, Recording},
    seed::Seed,
};
use serde::{Deserialize, Serialize};

/// The constants of grid matching.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct GridMatchConfig {
    /// How a scan becomes a grid.
    pub scan: ScanConfig,
    /// A snapshot this far from all places, or farther, becomes one, in metres (Duckett & Nehmzow 2000: 1.5).
    pub spacing_m: f64,
    /// Translations reach this many cells of 15 cm in x and in y, at most 63. Not printed. The default is the spacing of the
    /// places, 1.5 m: no snapshot on the way is farther from all of them. The paper's T, 13,051 times what comparing 144
    /// readings costs, pays for about 460 comparisons of 64 × 64 cells; 21 × 21 are 441.
    pub reach_cells: usize,
}

impl Default for GridMatchConfig {
    fn default() -> Self {
        Self {
            scan: ScanConfig::default(),
            spacing_m: 1.5,
            reach_cells: 10,
        }
    }
}

impl GridMatchConfig {
    /// # Errors
    /// A usage error that names the first constant out of bounds.
    pub fn check(&self) -> Result<()> {
        check_spacing("grid_match", self.spacing_m)?;
        check_reach("grid_match", self.reach_cells)?;
        self.scan.check()
    }
}

/// Places by their grids.
///
/// ```
/// use ballmark::{recogniser::{Learn, Recogniser, grid_match::GridMatch}, seed::Seed, world::corridor};
/// let config = corridor::CorridorConfig { runs: 1, spacing_m: 1.0, ..Default::default() };
/// let recording = corridor::thrun1998(Seed(1), &config)?;
/// let all: Vec<usize> = (0..recording.len()).collect();
/// let places = GridMatch::learn(&Default::default(), &recording, &all, Seed(1))?;
/// let first = places.respond(recording.channels(), &recording.observation(0)).unwrap();
/// assert_eq!((first.class, first.fit), (0, 1.0)); // the place itself: all 4096 cells agree
/// # Ok::<(), ballmark::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct GridMatch {
    scans: LocalScans,
    reach_cells: usize,
    places: Vec<States>,
    poses: Vec<Pose>,
}

impl GridMatch {
    /// Where the mapping part had each place.
    pub fn places(&self) -> &[Pose] {
        &self.poses
    }
}

impl Learn for GridMatch {
    type Config = GridMatchConfig;

    fn learn(
        config: &GridMatchConfig,
        recording: &Recording,
        snapshots: &[usize],
        _seed: Seed,
    ) -> Result<Self> {
        config.check()?;
        let compass = recording.columns().compass_rad.is_some();
        let scans = LocalScans::new(&config.scan, recording.channels(), compass)?;
        let places = scans.places(recording, snapshots, config.spacing_m);
        let (poses, places) = places.into_iter().unzip();
        Ok(Self {
            scans,
            reach_cells: config.reach_cells,
            places,
            poses,
        })
    }

    fn check(&self) -> Result<()> {
        self.scans.check()?;
        check_reach("grid_match", self.reach_cells)?;
        match self.places.len() == self.poses.len() && !self.places.is_empty() {
            true => Ok(()),
            false => Err(Error::work(format!(
                "{} grids for {} places; expected one each, and a place at least",
                self.places.len(),
                self.poses.len()
            ))),
        }
    }
}

impl Recogniser for GridMatch {
    fn name(&self) -> &'static str {
        "grid_match"
    }

    fn responses(&self) -> usize {
        self.places.len()
    }

    fn matches(&self) -> usize {
        self.places.len() * self.scans.ways()
    }

    fn bytes_per_place(&self) -> usize {
        size_of::<States>() + size_of::<Pose>()
    }

    fn check_channels(&self, channels: &[Channel]) -> Result<()> {
        self.scans.check_channels(channels)
    }

    /// The place on which most cells agree under the best translation, the first of several; the fit is their share of 4096.
    fn respond(&self, channels: &[Channel], observation: &Observation) -> Option<Response> {
        let states = self.scans.grid(channels, observation)?;
        self.best_of(&states)
    }

    fn ready<'a>(
        &'a self,
        channels: &'a [Channel],
        observation: &'a Observation<'a>,
    ) -> ReadyToMatch<'a> {
        let states = self.scans.grid(channels, observation);
        Box::new(move || self.best_of(states.as_ref()?))
    }
}

impl GridMatch {
    fn best_of(&self, states: &States) -> Option<Response> {
        let (mut best, mut most) = (None, 0);
        for states in self.scans.turns(states.clone()) {
            let sought = SoughtGrid::new(&states, self.reach_cells);
            for (class, place) in self.places.iter().enumerate() {
                // Places that can't do better than the best so far are soon given up.
                if let Some(found) = sought.align(place, most) {
                    (best, most) = (Some(class), found.agreement);
                }
            }
        }
        best.map(|class| Response {
            class,
            fit: f64::from(most) / (CELLS * CELLS) as f64,
        })
    }
}

#[cfg(test)]
mod tests;
