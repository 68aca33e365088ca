//! Several sets of features, of which each observation is told by the one that promises most: the filter bank.
//!
//! Thrun (1998) trains a set for each prior uncertainty and localises with one. How uncertain a robot is changes as it goes; so at every
//! step the [`Bank`] takes the set that promises most under the belief of that moment, before it looks at what was sensed:
//! [`ChosenBy`] says what that is.

use super::{EvidenceScale, PreparedSensorModel, SensorModel, flat};
use crate::{
    belief::{Belief, expected_posterior_error::Approximation, held_apart::HeldApart},
    error::{Error, Result},
    recording::{Observation, Recording},
    seed::{Seed, Stream},
};
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// What a [`Bank`] chooses sets by.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum ChosenBy {
    /// The least expected posterior error after the next snapshot
    /// ([`expected_posterior_error`](crate::belief::expected_posterior_error)).
    LeastError,
    #[default]
    /// The most expected information from the next snapshot ([`expected_information`](crate::belief::expected_information)).
    MostInformation,
}

/// How a [`Bank`] chooses.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct BankChoice {
    /// What sets are chosen by: `most_information`, or `least_error` expected after the step.
    pub by: ChosenBy,
    /// How many of them speak at every step, those that promise most.
    pub sets: usize,
}

impl Default for BankChoice {
    fn default() -> Self {
        Self {
            by: ChosenBy::default(),
            sets: 2,
        }
    }
}

impl BankChoice {
    /// # Errors
    /// Where no set would speak.
    pub fn check(&self) -> Result<()> {
        match self.sets {
            0 => Err(Error::usage("bank.sets = 0: expected at least 1")),
            _ => Ok(()),
        }
    }
}

/// One of the sets of a [`Bank`], with a sensor model `S`.
#[derive(Clone)]
pub struct BankSet<S> {
    /// What it was trained for.
    pub name: String,
    /// What its answers say about the place.
    pub sensor: S,
    /// How much that counts; none: as much as it says.
    pub scale: Option<EvidenceScale>,
    /// What it answers where, run by run, at the cells of the belief.
    pub held_apart: Arc<HeldApart>,
}

/// Several sets of features, of which those that promise most are used.
///
/// `S` is an `Arc<dyn SensorModel>`, or an `Arc<dyn PreparedSensorModel>` where a recording was answered beforehand.
#[derive(Clone)]
pub struct Bank<S> {
    sets: Vec<BankSet<S>>,
    choice: BankChoice,
    seed: Seed,
}

impl<S> Bank<S> {
    /// Of one set or more. `seed` is of feature vectors that are drawn where there are too many to go through.
    ///
    /// # Errors
    /// Where there is no set.
    pub fn new(sets: Vec<BankSet<S>>, choice: BankChoice, seed: Seed) -> Result<Self> {
        choice.check()?;
        if sets.is_empty() {
            return Err(Error::work("filter bank: no set; expected one or more"));
        }
        Ok(Self { sets, choice, seed })
    }

    /// The sets.
    pub fn sets(&self) -> &[BankSet<S>] {
        &self.sets
    }

    /// The sets that promise most to a robot with this belief, by their numbers, the first most; of equals, the earlier.
    ///
    /// # Errors
    /// Where the belief is over other cells.
    pub fn chosen(&self, belief: &Belief) -> Result<Vec<usize>> {
        let mut prices = Vec::new();
        for set in &self.sets {
            // The same draws for all, at all times: what differs is the sets.
            let stream = &mut self.seed.stream("features of a bank");
            let (held_apart, approximation) = (&set.held_apart, Approximation::default());
            prices.push(match self.choice.by {
                ChosenBy::LeastError => {
                    held_apart.expected_posterior_error_m(belief, approximation, stream)?
                }
                ChosenBy::MostInformation => {
                    -held_apart.expected_information_bits(belief, approximation, stream)?
                }
            });
        }
        let mut order: Vec<usize> = (0..prices.len()).collect();
        order.sort_by(|&a, &b| prices[a].total_cmp(&prices[b])); // stable
        order.truncate(self.choice.sets);
        Ok(order)
    }

    /// The same sets with other sensor models, in the same order.
    pub fn with_sensors<T>(&self, sensors: Vec<T>) -> Bank<T> {
        let sets = self.sets.iter().zip(sensors).map(|(set, sensor)| BankSet {
            name: set.name.clone(),
            sensor,
            scale: set.scale,
            held_apart: Arc::clone(&set.held_apart),
        });
        Bank {
            sets: sets.collect(),
            choice: self.choice,
            seed: self.seed,
        }
    }

    /// What the chosen sets say together, each as much as it counts.
    fn log_likelihood_of_chosen(
        &self,
        belief: &Belief,
        mut of: impl FnMut(&S) -> Result<Vec<f64>>,
    ) -> Result<Vec<f64>> {
        let mut sum = flat(belief);
        for number in self.chosen(belief)? {
            let set = &self.sets[number];
            let mut log_likelihood = of(&set.sensor)?;
            if let Some(scale) = set.scale {
                scale.apply(&mut log_likelihood);
            }
            let pairs = sum.iter_mut().zip(log_likelihood);
            pairs.for_each(|(sum, one)| *sum += one);
        }
        Ok(sum)
    }
}

impl SensorModel for Bank<Arc<dyn SensorModel>> {
    fn name(&self) -> &str {
        "bank"
    }

    fn log_likelihood(
        &self,
        observation: &Observation,
        belief: &Belief,
        stream: &mut Stream,
    ) -> Result<Vec<f64>> {
        self.log_likelihood_of_chosen(belief, |set| {
            set.log_likelihood(observation, belief, stream)
        })
    }

    fn prepare<'a>(
        &'a self,
        recording: &'a Recording,
        snapshots: &[usize],
    ) -> Result<Box<dyn PreparedSensorModel + 'a>> {
        let sets = self.sets.iter();
        let prepared = sets.map(|set| set.sensor.prepare(recording, snapshots).map(Arc::from));
        let prepared: Vec<Arc<dyn PreparedSensorModel + 'a>> = prepared.collect::<Result<_>>()?;
        Ok(Box::new(self.with_sensors(prepared)))
    }
}

impl PreparedSensorModel for Bank<Arc<dyn PreparedSensorModel + '_>> {
    fn log_likelihood(
        &self,
        snapshot: usize,
        belief: &Belief,
        stream: &mut Stream,
    ) -> Result<Vec<f64>> {
        self.log_likelihood_of_chosen(belief, |set| set.log_likelihood(snapshot, belief, stream))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::belief::{MapConfig, Nearness, Places};
    use ndarray::Array2;

    struct Says(f64);

    impl PreparedSensorModel for Says {
        fn log_likelihood(&self, _: usize, belief: &Belief, _: &mut Stream) -> Result<Vec<f64>> {
            Ok(vec![self.0; belief.mass().len()])
        }
    }

    /// Of two sets one tells the halves of a corridor apart, the other every metre from the next.
    #[test]
    fn the_set_that_suits_the_belief_is_asked() {
        let route = Places::Route((0..40).map(f64::from).collect());
        let run = vec![0; 40];
        let config = MapConfig {
            nearness: Nearness {
                k: 1,
                ..Default::default()
            },
            ..MapConfig::default()
        };
        let set = |name: &str, says: f64, one: &dyn Fn(usize) -> bool| {
            let activation = Array2::from_shape_fn((40, 1), |(k, _)| f64::from(u8::from(one(k))));
            let held_apart = HeldApart::new(&route, &activation, &run, &config, &route).unwrap();
            let sensor: Arc<dyn PreparedSensorModel> = Arc::new(Says(says));
            BankSet {
                name: name.into(),
                sensor,
                scale: None,
                held_apart: Arc::new(held_apart),
            }
        };
        let sets = vec![
            set("1m", 1.0, &|k| k % 2 == 0),
            set("global", 2.0, &|k| k < 20),
        ];
        let places = Arc::new(route.clone());
        let lost = Belief::uniform(&places).unwrap();
        let near = Belief::within(&places, &route, 5, &"1m".parse().unwrap()).unwrap();
        for by in [ChosenBy::LeastError, ChosenBy::MostInformation] {
            let bank = |count| Bank::new(sets.clone(), BankChoice { by, sets: count }, Seed(1));
            let mut stream = Seed(1).stream("unused");
            let mut says = |count, belief| {
                let bank = bank(count).unwrap();
                bank.log_likelihood(0, belief, &mut stream).unwrap()[0]
            };
            // Both sets tell a lost robot one bit, of which that of the halves is worth more metres.
            let lost_says = if by == ChosenBy::LeastError { 2.0 } else { 1.0 };
            assert_eq!(says(1, &lost), lost_says);
            assert_eq!(says(1, &near), 1.0);
            assert_eq!(says(2, &near), 3.0);
            assert_eq!(bank(1).unwrap().chosen(&near).unwrap(), [0]);
            assert!(bank(0).err().unwrap().is_usage());
        }
    }

    #[test]
    fn a_bank_of_nothing_is_refused() {
        let none: Vec<BankSet<Arc<dyn SensorModel>>> = Vec::new();
        assert!(Bank::new(none, BankChoice::default(), Seed(1)).is_err());
    }
}
