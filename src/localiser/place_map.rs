//! The map of evidence-based localisation: places along the way, where each is and what it looks like.
//!
//! Duckett & Nehmzow (1998, below D98), 3.1. A place is entered "whenever the robot has travelled by more than a
//! prespecified distance D from the nearest stored place in the map, or when the current sonar and infrared readings differ
//! from the stored signatures of the *current* place by more than a threshold T"; its coordinates and signatures are means
//! over the snapshots taken within it. What the paper leaves open is settled thus:
//!
//! - the *current* place is the nearest one; a snapshot that enters no place belongs to it;
//! - signatures are those of [`crate::recogniser::signature`], each channel of Euclidean length 1, and a mean of them is
//!   brought to that length again. Two channels are then at most 2√2 apart, and T = 1.5 can be passed. A single channel is at
//!   most √2 from another: there T is never passed, the map grows by D alone, and every place is a candidate;
//! - where no compass turns the readings (a scanner that looks ahead, a robot without compass), a place seen from its other
//!   side is another place: one is near only if it was mapped with about the same heading.
//!
//! The centre of a place follows the robot at half its pace, so the robot is D away from it after 2D: "the maximum distance
//! between stored places will therefore be 2D" (footnote 3).

use super::reckoned::reckoned;
use crate::{
    error::{Error, Result},
    geometry::{Pose, wrapped},
    recogniser::signature::{Layout, Normalisation, SignatureConfig},
    recording::{Channel, Recording},
};
use serde::{Deserialize, Serialize};
use std::{
    collections::BTreeMap,
    f64::consts::{FRAC_PI_4, PI},
    ops::Range,
};

/// Where places lie: in the frame of what the robot reckons by, or in that of the poses it was mapped with.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum Coordinates {
    /// The robot's compass-based odometry, drift removed as in D98 6.4 ([`super::reckoned`]), by which it moves its hypotheses,
    /// too: "obtained by averaging the robot's odometer readings within that particular place" (3.1). Without a compass: as
    /// `pose`.
    #[default]
    Odometry,
    /// The recording's poses. A compass that steel distorts then leads hypotheses off the places.
    Pose,
}

/// When a place is another place; constants of D98, 3.1, but for the last.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct PlaceMapConfig {
    /// What of a snapshot is looked at.
    pub signature: SignatureConfig,
    /// What the readings of each channel are divided by. D98 3.1 has "a normalised sonar signature and a normalised infrared
    /// signature" and prints no norm: `length` brings each to length 1, and T = 1.5 then passes every place; `maximum` takes
    /// each reading as a share of the sensor's range, and T then passes few.
    pub normalisation: Normalisation,
    /// In which frame the places lie that are gone by in localising.
    pub coordinates: Coordinates,
    /// D: farther than this from all places, in metres, is a new one.
    pub distance_m: f64,
    /// T: a snapshot that differs by more than this from its place starts a new one.
    pub threshold: f64,
    /// w_son, w_ir: weights of the channels in eq. 1 by their names; 1 for those not named.
    pub weights: BTreeMap<String, f64>,
    /// A place whose heading is more than this from the robot's, in radians, is not near. Counts only where no compass turns
    /// the readings; ours, an eighth of a circle.
    pub heading_rad: f64,
}

impl Default for PlaceMapConfig {
    fn default() -> Self {
        Self {
            signature: SignatureConfig::default(),
            normalisation: Normalisation::default(),
            coordinates: Coordinates::default(),
            distance_m: 0.375,
            threshold: 1.5,
            weights: BTreeMap::new(),
            heading_rad: FRAC_PI_4,
        }
    }
}

impl PlaceMapConfig {
    /// # Errors
    /// A usage error where a constant makes no sense; the message names its key.
    pub fn check(&self) -> Result<()> {
        let wrong = |key: &str, value: f64, expected: &str| {
            Err(Error::usage(format!(
                "map.{key} = {value}: expected {expected}"
            )))
        };
        if !(1e-3..=1e6).contains(&self.distance_m) {
            return wrong("distance_m", self.distance_m, "0.001 to a million metres");
        }
        if !(1e-3..=1e6).contains(&self.threshold) {
            return wrong("threshold", self.threshold, "0.001 to a million");
        }
        if !(1e-3..=PI).contains(&self.heading_rad) {
            return wrong("heading_rad", self.heading_rad, "0.001 to π");
        }
        let mut weights = self.weights.iter();
        match weights.find(|(_, w)| !(0.0..=1e6).contains(*w)) {
            Some((name, &w)) => {
                let key = format!("weights.{}", name.escape_debug());
                wrong(&key, w, "0 to a million")
            }
            None => Ok(()),
        }
    }
}

/// A place of the map.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Place {
    /// Mean position and heading of the robot within it.
    pub pose: Pose,
    /// From there to where its own reckoning has the place ([`Coordinates::Odometry`]), metres.
    #[serde(default)]
    pub reckoned_off_m: [f64; 2],
    /// Mean of what it saw there, normalised.
    pub signature: Vec<f32>,
}

impl Place {
    /// Position in the frame that hypotheses move in, and the heading.
    pub fn reckoned(&self) -> Pose {
        let [x_m, y_m] = self.reckoned_off_m;
        Pose::new(
            self.pose.x_m + x_m,
            self.pose.y_m + y_m,
            self.pose.heading_rad,
        )
    }
}

/// The places, in the order they were entered.
///
/// ```
/// use ballmark::{localiser::place_map::{PlaceMap, PlaceMapConfig}, seed::Seed, world::corridor};
/// let config = corridor::CorridorConfig { runs: 1, spacing_m: 0.1, ..Default::default() };
/// let recording = corridor::thrun1998(Seed(1), &config)?;
/// let all: Vec<usize> = (0..recording.len()).collect();
/// let map = PlaceMap::build(&PlaceMapConfig::default(), &recording, &all)?;
/// // 89 m straight ahead: a place about every 2D.
/// assert!((105..=140).contains(&map.places().len()));
///
/// let signature = map.signature(recording.channels(), &recording.observation(0)).unwrap();
/// assert_eq!(map.nearest_in_signature(&map.differences(&signature)), Some(0));
/// # Ok::<(), ballmark::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PlaceMap {
    config: PlaceMapConfig,
    layout: Layout,
    /// Does a place look different from its other side?
    oriented: bool,
    places: Vec<Place>,
}

impl PlaceMap {
    /// Goes through the mapping part in the order driven.
    ///
    /// # Errors
    /// Where a constant makes no sense, or it names a channel that the recording lacks (a weight: a usage error).
    pub fn build(
        config: &PlaceMapConfig,
        recording: &Recording,
        snapshots: &[usize],
    ) -> Result<Self> {
        config.check()?;
        let layout = Layout::fit(&config.signature, recording, snapshots)?;
        let named = |name: &String| layout.parts().iter().any(|(part, _)| part == name);
        if let Some(name) = config.weights.keys().find(|name| !named(name)) {
            return Err(Error::usage(format!(
                "map.weights.{}: no such channel in the signature; expected one of {}",
                name.escape_debug(),
                layout
                    .parts()
                    .iter()
                    .map(|(name, _)| *name)
                    .collect::<Vec<_>>()
                    .join(", ")
            )));
        }
        let oriented = !layout.is_turned_by_compass(recording);
        let mut map = Self {
            config: config.clone(),
            layout,
            oriented,
            places: Vec::new(),
        };
        let mut sums: Vec<Sums> = Vec::new();
        let reckoned = match config.coordinates {
            Coordinates::Odometry => reckoned(recording, snapshots),
            Coordinates::Pose => None,
        };
        for (i, &k) in snapshots.iter().enumerate() {
            let (label, observation) = (&recording.poses()[k], recording.observation(k));
            let pose = &reckoned.as_ref().map_or(*label, |reckoned| reckoned[i]);
            let Some(signature) = map.signature(recording.channels(), &observation) else {
                continue;
            };
            let current = map.nearest(pose).filter(|&m| {
                map.places[m].reckoned().distance_m(pose) <= config.distance_m
                    && map.difference(&map.places[m].signature, &signature) <= config.threshold
            });
            match current {
                Some(m) => sums[m].add(label, pose, &signature),
                None => {
                    map.places.push(Place::default());
                    sums.push(Sums::first(label, pose, &signature));
                }
            }
            let m = current.unwrap_or(sums.len() - 1);
            map.places[m] = sums[m].mean(&map.layout, config.normalisation);
        }
        Ok(map)
    }

    /// The places, in the order they were entered.
    pub fn places(&self) -> &[Place] {
        &self.places
    }

    /// Its constants.
    pub fn config(&self) -> &PlaceMapConfig {
        &self.config
    }

    /// Does a place look different from its other side? Then headings tell places apart.
    pub fn is_oriented(&self) -> bool {
        self.oriented
    }

    /// What is kept of a place, in bytes: its pose and its signature.
    pub fn bytes_per_place(&self) -> usize {
        size_of::<Pose>() + self.layout.width() * size_of::<f32>()
    }

    /// What a snapshot looks like; `None` where a channel is missing or has another width or unit.
    pub fn signature(
        &self,
        channels: &[Channel],
        observation: &crate::recording::Observation,
    ) -> Option<Vec<f32>> {
        let by = self.config.normalisation;
        self.layout.normalised(by, channels, observation)
    }

    /// d: the weighted sum of the distances of two signatures, channel by channel (eq. 1).
    pub fn difference(&self, a: &[f32], b: &[f32]) -> f64 {
        difference(&self.weighted_parts(), a, b)
    }

    /// d_m of a signature for every place m (eq. 1), `[place]`.
    pub fn differences(&self, signature: &[f32]) -> Vec<f32> {
        let parts = self.weighted_parts();
        let unlike = |place: &Place| difference(&parts, &place.signature, signature) as f32;
        self.places.iter().map(unlike).collect()
    }

    /// The place of least difference, the first of several: the nearest neighbour of D98 7.2.
    pub fn nearest_in_signature(&self, differences: &[f32]) -> Option<usize> {
        let numbered = differences.iter().enumerate();
        let least = numbered.reduce(|best, next| if next.1 < best.1 { next } else { best });
        least.map(|(m, _)| m)
    }

    /// # Errors
    /// Where a channel of ours is missing there, or has another width or unit.
    pub fn check_channels(&self, channels: &[Channel]) -> Result<()> {
        self.layout.check_channels(channels)
    }

    /// Checks what may have come from a file.
    ///
    /// # Errors
    /// Where a constant makes no sense, there is no place, or one has no pose or no signature of the right length.
    pub fn check(&self) -> Result<()> {
        self.config.check()?;
        self.layout.check()?;
        let width = self.layout.width();
        // Parts of unit vectors, or shares; anything greater is damage.
        let sound = |place: &Place| {
            place.reckoned().is_finite()
                && place.pose.is_finite()
                && place.signature.len() == width
                && place.signature.iter().all(|v| v.abs() <= 1.0001)
        };
        match self.places.iter().position(|place| !sound(place)) {
            Some(m) => Err(Error::work(format!(
                "place {m}: expected a finite pose and a signature of {width} values from −1 to 1"
            ))),
            None if self.places.is_empty() => {
                Err(Error::work("places: none; expected at least one"))
            }
            None => Ok(()),
        }
    }

    /// The place nearest to a pose, the first of several; where headings count, among those of about its heading.
    fn nearest(&self, pose: &Pose) -> Option<usize> {
        let faces =
            |place: &Pose| !self.oriented || place.turn_rad(pose) <= self.config.heading_rad;
        let places = self.places.iter().map(Place::reckoned).enumerate();
        let near = places.filter(|(_, place)| faces(place));
        let near = near.map(|(m, place)| (m, place.distance_m(pose)));
        let nearest = near.reduce(|best, next| if next.1 < best.1 { next } else { best });
        nearest.map(|(m, _)| m)
    }

    /// Where each channel stands in a signature, and its weight.
    fn weighted_parts(&self) -> Vec<(Range<usize>, f64)> {
        let weight = |name: &str| self.config.weights.get(name).copied().unwrap_or(1.0);
        let parts = self.layout.parts().into_iter();
        parts.map(|(name, part)| (part, weight(name))).collect()
    }
}

fn difference(parts: &[(Range<usize>, f64)], a: &[f32], b: &[f32]) -> f64 {
    let distance = |part: &Range<usize>| -> f64 {
        let pairs = a[part.clone()].iter().zip(&b[part.clone()]);
        pairs
            .map(|(a, b)| f64::from(a - b).powi(2))
            .sum::<f64>()
            .sqrt()
    };
    parts
        .iter()
        .map(|(part, weight)| weight * distance(part))
        .sum()
}

/// Sums over the snapshots of a place.
struct Sums {
    snapshots: f64,
    at: [f64; 2],
    reckoned: [f64; 2],
    /// Heading of the first one, and the sum of turns from it.
    heading_rad: (f64, f64),
    signature: Vec<f64>,
}

impl Sums {
    fn first(pose: &Pose, reckoned: &Pose, signature: &[f32]) -> Self {
        Self {
            snapshots: 1.0,
            at: [pose.x_m, pose.y_m],
            reckoned: [reckoned.x_m, reckoned.y_m],
            heading_rad: (pose.heading_rad, 0.0),
            signature: signature.iter().map(|&v| f64::from(v)).collect(),
        }
    }

    fn add(&mut self, pose: &Pose, reckoned: &Pose, signature: &[f32]) {
        self.snapshots += 1.0;
        self.at[0] += pose.x_m;
        self.at[1] += pose.y_m;
        self.reckoned[0] += reckoned.x_m;
        self.reckoned[1] += reckoned.y_m;
        self.heading_rad.1 += wrapped(pose.heading_rad - self.heading_rad.0);
        for (sum, &value) in self.signature.iter_mut().zip(signature) {
            *sum += f64::from(value);
        }
    }

    fn mean(&self, layout: &Layout, by: Normalisation) -> Place {
        let n = self.snapshots;
        let heading_rad = wrapped(self.heading_rad.0 + self.heading_rad.1 / n);
        let mut signature: Vec<f32> = self.signature.iter().map(|sum| (sum / n) as f32).collect();
        // A mean of shares is one; of unit vectors it is shorter.
        if by == Normalisation::Length {
            layout.to_unit_length(&mut signature);
        }
        Place {
            pose: Pose::new(self.at[0] / n, self.at[1] / n, heading_rad),
            reckoned_off_m: [0, 1].map(|axis| (self.reckoned[axis] - self.at[axis]) / n),
            signature,
        }
    }
}

#[cfg(test)]
mod tests;
