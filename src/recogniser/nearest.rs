//! Nearest neighbour: a pattern every 1.5 m, by where the robot was, and the answer is the pattern most like the snapshot.
//!
//! D00: "identical to the RCE classifier described above, except that it uses *a priori* position information (from the
//! retrospectively corrected odometry in these experiments […]) to decide when to add new patterns", "at 1.5 m intervals".
//! The intervals are distances from the nearest *stored* pattern, not along the way: D00's Table 1 has about 16 responses
//! on a route of 54 m that comes back through the same hallway, where 1.5 m of travel each would make 36 (so does D98, 3.1,
//! for its places). The position is the pose of the mapping part; what answers later does not know it.

use super::{
    Learn, ReadyToMatch, Recogniser, Response, prototypes::Prototypes, signature::SignatureConfig,
};
use crate::{
    error::{Error, Result},
    geometry::Pose,
    recording::{Channel, Observation, Recording},
    seed::Seed,
};
use serde::{Deserialize, Serialize};

/// The one constant of the nearest neighbour, and what it works from.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct NearestConfig {
    /// What of a snapshot is looked at.
    pub signature: SignatureConfig,
    /// A snapshot this far from all stored ones, or farther, is stored, in metres (D00: 1.5).
    pub spacing_m: f64,
}

impl Default for NearestConfig {
    fn default() -> Self {
        Self {
            signature: SignatureConfig::default(),
            spacing_m: 1.5,
        }
    }
}

impl NearestConfig {
    /// # Errors
    /// Where the spacing is no positive number of metres.
    pub fn check(&self) -> Result<()> {
        match self.spacing_m.is_finite() && self.spacing_m > 0.0 {
            true => Ok(()),
            false => Err(Error::usage(format!(
                "nearest.spacing_m = {}: expected a positive number of metres",
                self.spacing_m
            ))),
        }
    }
}

/// Steps of a tenth of a metre add up to a little less than a round distance.
const ROUNDING_M: f64 = 1e-9;

/// Which snapshots, in the order given, become places: each that lies `spacing_m` or more from all places before it.
///
/// ```
/// use ballmark::{geometry::Pose, recogniser::nearest::spaced};
/// // Up a corridor of 3 m and back on its other side: the way back adds nothing.
/// let at = [0.0, 1.0, 2.0, 3.0, 2.5, 1.5, 0.5].map(|x_m| Pose::new(x_m, 0.0, 0.0));
/// assert_eq!(spaced(&at, &[0, 1, 2, 3, 4, 5, 6], 1.5), [0, 2]);
/// ```
pub fn spaced(poses: &[Pose], snapshots: &[usize], spacing_m: f64) -> Vec<usize> {
    let mut places: Vec<usize> = Vec::new();
    for &k in snapshots {
        let far = |&place: &usize| poses[k].distance_m(&poses[place]) >= spacing_m - ROUNDING_M;
        if places.iter().all(far) {
            places.push(k);
        }
    }
    places
}

/// Patterns of places. Many snapshots at once are answered by a blocked product, see [`Recogniser::respond_all`]:
/// `benches/nearest.rs` has the figures.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Nearest {
    prototypes: Prototypes,
    /// Where the patterns were taken.
    places: Vec<Pose>,
}

impl Nearest {
    /// Where the mapping part had each pattern.
    pub fn places(&self) -> &[Pose] {
        &self.places
    }
}

impl Learn for Nearest {
    type Config = NearestConfig;

    fn learn(
        config: &NearestConfig,
        recording: &Recording,
        snapshots: &[usize],
        _seed: Seed,
    ) -> Result<Self> {
        config.check()?;
        let mut prototypes = Prototypes::new(&config.signature, recording, snapshots)?;
        let mut places = Vec::new();
        for k in spaced(recording.poses(), snapshots, config.spacing_m) {
            let signature = prototypes
                .layout()
                .of(recording.channels(), &recording.observation(k));
            if let Some(signature) = signature {
                prototypes.push(&signature);
                places.push(recording.poses()[k]);
            }
        }
        Ok(Self { prototypes, places })
    }

    fn check(&self) -> Result<()> {
        self.prototypes.check()?;
        match self.places.len() == self.prototypes.len() {
            true => Ok(()),
            false => Err(Error::work(format!(
                "{} places of {} patterns; expected one each",
                self.places.len(),
                self.prototypes.len()
            ))),
        }
    }
}

impl Recogniser for Nearest {
    fn name(&self) -> &'static str {
        "nearest"
    }

    fn responses(&self) -> usize {
        self.prototypes.len()
    }

    fn matches(&self) -> usize {
        self.prototypes.len()
    }

    fn bytes_per_place(&self) -> usize {
        self.prototypes.bytes_each() + size_of::<Pose>()
    }

    fn check_channels(&self, channels: &[Channel]) -> Result<()> {
        self.prototypes.layout().check_channels(channels)
    }

    /// The pattern of largest dot product, which is the fit.
    fn respond(&self, channels: &[Channel], observation: &Observation) -> Option<Response> {
        self.prototypes.respond(channels, observation)
    }

    fn ready<'a>(
        &'a self,
        channels: &'a [Channel],
        observation: &'a Observation<'a>,
    ) -> ReadyToMatch<'a> {
        let signature = self.prototypes.layout().of(channels, observation);
        Box::new(move || self.prototypes.most_like(signature.as_ref()?))
    }

    fn respond_all(&self, recording: &Recording, snapshots: &[usize]) -> Vec<Option<Response>> {
        self.prototypes.respond_all(recording, snapshots)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A T of corridors driven along and back, a snapshot every half metre: 54 m in all, as D00's environment A.
    fn hallway() -> Vec<Pose> {
        let bar = |i: i32| Pose::new(0.5 * f64::from(i), 0.0, 0.0);
        let stem = |i: i32| Pose::new(8.0, -0.5 * f64::from(i), 0.0);
        let out = (0..=16).map(bar).chain((1..=22).map(stem));
        let back = (0..22).rev().map(stem).chain((17..=32).map(bar));
        let home = (0..32).rev().map(bar);
        out.chain(back).chain(home).collect()
    }

    #[test]
    fn a_route_of_54_m_gives_about_16_places_not_36() {
        let poses = hallway();
        let travelled: f64 = poses.windows(2).map(|w| w[0].distance_m(&w[1])).sum();
        assert!((travelled - 54.0).abs() < 1e-9, "{travelled}");
        let all: Vec<usize> = (0..poses.len()).collect();
        let places = spaced(&poses, &all, 1.5);
        assert!((15..=19).contains(&places.len()), "{}", places.len());
        for (i, a) in places.iter().enumerate() {
            let apart = |b: &usize| poses[*a].distance_m(&poses[*b]) >= 1.5;
            assert!(places[..i].iter().all(apart));
        }
        let covered = |pose: &Pose| places.iter().any(|p| poses[*p].distance_m(pose) < 1.5);
        assert!(poses.iter().all(covered));
    }

    #[test]
    fn steps_that_add_up_to_the_spacing_only_nearly_still_count() {
        let mut x_m = 0.0;
        let mut poses = vec![Pose::default()];
        for _ in 0..30 {
            x_m += 0.1;
            poses.push(Pose::new(x_m, 0.0, 0.0));
        }
        assert!(poses[15].x_m - poses[0].x_m != 1.5);
        let all: Vec<usize> = (0..poses.len()).collect();
        assert_eq!(spaced(&poses, &all, 1.5), [0, 15, 30]);
    }
}
