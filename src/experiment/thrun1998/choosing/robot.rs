//! A robot that asks, before it senses or moves, what it expects of it.

use super::{
    READINGS, TRIALS, Tried,
    eye::{Eye, Eyes},
};
use crate::{
    belief::{BayesFilter, Belief, Places, expected_posterior_error::Approximation},
    error::{Error, Result},
    geometry::Displacement,
    localiser::PreparedSensorModel,
    seed::{Seed, Stream},
};
use rand::RngExt;

/// Metres between two snapshots.
const STEP_M: f64 = 0.5;

/// Metres that the robot drives, ahead or back, before it senses and decides anew.
const DRIVE_M: f64 = 2.0;

/// So many such drives on it looks, the belief moved without being corrected.
const DRIVES_AHEAD: usize = 4;

/// A place this near to one that it has sensed from since its start, by its odometry, tells it nothing new, in metres: the same wall seen
/// once more is no second witness, which no sum over independent readings knows.
const SEEN_WITHIN_M: f64 = 1.0;

/// What is to be decided.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Question {
    /// Which way the camera looks at the next reading.
    Heading,
    /// Which camera is mounted for all of them.
    Mount,
    /// Whether to drive ahead or back before the next.
    Action,
}

/// How it is decided.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Policy {
    LeastError,
    Chance,
    /// Always this one.
    Fixed(usize),
}

/// Ways to drive.
const WAYS: [(&str, f64); 2] = [("ahead", 1.0), ("back", -1.0)];

/// A robot in a world.
pub(super) struct Robot<'a> {
    eyes: &'a Eyes,
    route_m: &'a [f64],
    seed: Seed,
    /// Standard deviation of the start, where it is known.
    start_spread_m: Option<f64>,
}

/// One trial as it goes.
struct Going {
    filter: BayesFilter,
    /// Number among the snapshots that are driven.
    at: usize,
    /// Metres along the route since the start, by odometry.
    along_m: f64,
    /// Where on it was sensed.
    sensed_m: Vec<f64>,
    /// Of the sampled features.
    features: Stream,
    /// Of decisions by chance.
    chance: Stream,
}

impl<'a> Robot<'a> {
    /// One that has no idea where it starts, or knows it within so many metres.
    ///
    /// # Errors
    /// Where the recording has no route.
    pub fn new(eyes: &'a Eyes, seed: Seed, start_spread_m: Option<f64>) -> Result<Self> {
        let Places::Route(route_m) = &eyes.places else {
            return Err(Error::work("thrun1998: a corridor without a route"));
        };
        Ok(Self {
            eyes,
            route_m,
            seed,
            start_spread_m,
        })
    }

    /// The question, decided by least expected error, by chance and always alike, over the same trials.
    pub fn asked(&self, question: Question, cameras: &[&Eye]) -> Result<Tried> {
        let names: Vec<&'static str> = match question {
            Question::Action => WAYS.map(|(name, _)| name).to_vec(),
            _ => cameras.iter().map(|camera| camera.name).collect(),
        };
        let played = |policy| self.played(question, cameras, policy);
        let fixed =
            |(number, name): (usize, &'static str)| Ok((name, played(Policy::Fixed(number))?));
        Ok(Tried {
            chosen_m: played(Policy::LeastError)?,
            chance_m: played(Policy::Chance)?,
            fixed_m: names
                .into_iter()
                .enumerate()
                .map(fixed)
                .collect::<Result<_>>()?,
        })
    }

    /// Mean expected error over the readings of all trials.
    fn played(&self, question: Question, cameras: &[&Eye], policy: Policy) -> Result<f64> {
        let mut sum_m = 0.0;
        for number in 0..TRIALS {
            let mut going = self.start(number)?;
            let mut mounted = None;
            for _ in 0..READINGS {
                let camera = match (question, mounted) {
                    (Question::Heading, _) => {
                        self.drive(&mut going, 1.0, STEP_M)?;
                        self.camera(policy, cameras, &mut going)?
                    }
                    (Question::Mount, Some(camera)) => {
                        self.drive(&mut going, 1.0, STEP_M)?;
                        camera
                    }
                    (Question::Mount, None) => self.camera(policy, cameras, &mut going)?,
                    (Question::Action, _) => {
                        let way = self.way(policy, cameras[0], &mut going)?;
                        self.drive(&mut going, way, DRIVE_M)?;
                        0
                    }
                };
                mounted = Some(camera);
                sum_m += self.sensed(&mut going, cameras[camera])?;
            }
        }
        Ok(sum_m / (TRIALS * READINGS) as f64)
    }

    /// Trial `number`, in the middle part of the corridor, so that there is a way ahead and a way back.
    fn start(&self, number: usize) -> Result<Going> {
        let driven = &self.eyes.driven;
        let mut stream = self
            .seed
            .numbered_stream("starts of choices", number as u64);
        let at = stream.random_range(driven.len() / 4..driven.len() * 3 / 4);
        let cells = self.eyes.grid.places();
        let belief = match self.start_spread_m {
            None => Belief::uniform(cells)?,
            Some(spread_m) => Belief::around(cells, &self.eyes.places, driven[at], spread_m, 1.0)?,
        };
        Ok(Going {
            filter: BayesFilter::new(&self.eyes.grid, self.eyes.motion.clone(), belief)?,
            at,
            along_m: 0.0,
            sensed_m: Vec::new(),
            features: self
                .seed
                .numbered_stream("features of choices", number as u64),
            chance: self
                .seed
                .numbered_stream("choices by chance", number as u64),
        })
    }

    /// Which camera a policy takes at this moment.
    fn camera(&self, policy: Policy, cameras: &[&Eye], going: &mut Going) -> Result<usize> {
        let belief = going.filter.belief();
        match policy {
            Policy::Fixed(number) => Ok(number),
            Policy::Chance => Ok(going.chance.random_range(0..cameras.len())),
            Policy::LeastError => least(cameras.iter().map(|camera| self.promise(camera, belief))),
        }
    }

    /// Which way it drives, ahead (1) or back (−1): of those that the corridor leaves.
    fn way(&self, policy: Policy, camera: &Eye, going: &mut Going) -> Result<f64> {
        let is_free = |way: f64| self.after(going.at, way, DRIVE_M).is_some();
        let free: Vec<f64> = WAYS
            .map(|(_, way)| way)
            .into_iter()
            .filter(|w| is_free(*w))
            .collect();
        let [_, _] = free[..] else {
            return Ok(free.first().copied().unwrap_or(1.0));
        };
        let number = match policy {
            Policy::Fixed(number) => number,
            Policy::Chance => going.chance.random_range(0..free.len()),
            Policy::LeastError => least(
                free.iter()
                    .map(|way| self.promise_of_way(*way, camera, going)),
            )?,
        };
        Ok(free[number])
    }

    /// The same after each of the next drives this way, on average; where nothing new is to be seen, what is left without a reading.
    fn promise_of_way(&self, way: f64, camera: &Eye, going: &Going) -> Result<f64> {
        let mut there = going.filter.clone();
        let mut sum_m = 0.0;
        for drives in 1..=DRIVES_AHEAD {
            there.predict(&Displacement {
                forward_m: way * DRIVE_M,
                left_m: 0.0,
                turn_rad: 0.0,
            })?;
            let along_m = going.along_m + way * DRIVE_M * drives as f64;
            sum_m += match is_seen(&going.sensed_m, along_m) {
                true => unsensed_error_m(there.belief()),
                false => self.promise(camera, there.belief())?,
            };
        }
        Ok(sum_m / DRIVES_AHEAD as f64)
    }

    /// The error that is expected to be left after a reading.
    fn promise(&self, camera: &Eye, belief: &Belief) -> Result<f64> {
        let mut unused = self.seed.stream("features of promises"); // along a route the sum is exact
        let sums = Approximation::default();
        camera
            .held_apart
            .expected_posterior_error_m(belief, sums, &mut unused)
    }

    /// The snapshot so many metres ahead or back.
    fn after(&self, at: usize, way: f64, metres: f64) -> Option<usize> {
        let route_m = |at: usize| self.route_m[self.eyes.driven[at]];
        let goal_m = route_m(at) + way * metres;
        let mut next = at;
        while way * (goal_m - route_m(next)) > 1e-6 {
            next = next.checked_add_signed(if way > 0.0 { 1 } else { -1 })?;
            if next >= self.eyes.driven.len() {
                return None;
            }
        }
        Some(next)
    }

    /// Drives, in steps of half a metre, each of which the belief follows by odometry.
    fn drive(&self, going: &mut Going, way: f64, metres: f64) -> Result<()> {
        for _ in 0..(metres / STEP_M).round() as usize {
            let Some(next) = self.after(going.at, way, STEP_M) else {
                return Ok(()); // the end of the corridor
            };
            let odometry = |at: usize| {
                self.eyes
                    .recording
                    .observation(self.eyes.driven[at])
                    .odometry
            };
            going
                .filter
                .predict(&odometry(going.at).displacement_to(&odometry(next)))?;
            going.along_m += way * odometry(going.at).distance_m(&odometry(next));
            going.at = next;
        }
        Ok(())
    }

    /// Senses, and tells the expected error afterwards.
    fn sensed(&self, going: &mut Going, camera: &Eye) -> Result<f64> {
        let truth = self.eyes.driven[going.at];
        let seen = camera.nearest(self.route_m[truth]);
        let seen = seen.ok_or_else(|| Error::work("thrun1998: a camera without a snapshot"))?;
        let (belief, features) = (going.filter.belief(), &mut going.features);
        let log_likelihood = camera.sensor.log_likelihood(seen, belief, features)?;
        going.filter.correct(&log_likelihood)?;
        going.sensed_m.push(going.along_m);
        Ok(going
            .filter
            .belief()
            .expected_error_m(&self.eyes.places, truth))
    }
}

/// Was something sensed there, or near by?
fn is_seen(sensed_m: &[f64], along_m: f64) -> bool {
    let mut sensed = sensed_m.iter();
    sensed.any(|sensed_m| (sensed_m - along_m).abs() < SEEN_WITHIN_M)
}

/// The expected error of a robot that senses nothing: Σ_ξ* Bel(ξ*) Σ_ξ Bel(ξ) e(ξ*, ξ).
fn unsensed_error_m(belief: &Belief) -> f64 {
    let places = belief.places();
    let truths = belief.mass().iter().enumerate();
    let truths = truths.filter(|(_, mass)| **mass > 0.0);
    truths
        .map(|(truth, mass)| mass * belief.expected_error_m(places, truth))
        .sum()
}

/// The number of the least; of equals, the first.
fn least(values: impl Iterator<Item = Result<f64>>) -> Result<usize> {
    let mut best = (0, f64::INFINITY);
    for (number, value) in values.enumerate() {
        let value = value?;
        if value < best.1 {
            best = (number, value);
        }
    }
    Ok(best.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::Arc;

    #[test]
    fn without_a_reading_the_belief_is_held_against_itself() {
        let places = Arc::new(Places::Route(vec![0.0, 99.0]));
        let lost = Belief::uniform(&places).unwrap();
        assert!((unsensed_error_m(&lost) - 49.5).abs() < 1e-12);
        let leaning = Belief::from_mass(&places, vec![0.9, 0.1]).unwrap();
        assert!((unsensed_error_m(&leaning) - 2.0 * 0.09 * 99.0).abs() < 1e-12);
    }

    #[test]
    fn a_second_look_is_no_news() {
        assert!(is_seen(&[0.0, 2.0], 2.9) && is_seen(&[0.0], -0.9));
        assert!(!is_seen(&[0.0, 2.0], 4.0) && !is_seen(&[], 0.0));
    }
}
