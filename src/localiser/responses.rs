//! The likelihood of a recogniser's response under the responses that were given near a place: P(response | ξ).
//!
//! So any recogniser can drive the Bayes filter: what was answered to the training snapshots near a place says how likely
//! an answer is there, as it does for features (Thrun 1998, 5.1.6).

use crate::{
    belief::{Belief, Neighbours},
    error::{Error, Result},
    localiser::{PreparedSensorModel, SensorModel, prepared::Prepared},
    recogniser::{Recogniser, Response},
    recording::{Observation, Recording},
    seed::Stream,
};
use std::sync::Arc;

/// A recogniser, and what it answered at the training places near every cell of a grid.
///
/// P(class | ξ) is the share of the k training snapshots nearest to ξ that were answered so, mixed with an even share for all
/// classes of the training part. Where no training snapshot is near it is the class's share of the whole training part. No
/// answer is a class like any other. A class that the training part never gave says nothing.
pub struct ResponseModel {
    recogniser: Box<dyn Recogniser>,
    map: Arc<ResponseMap>,
}

/// P(class | ξ) at every cell.
struct ResponseMap {
    /// What was answered at each training place, `[training]`.
    classes: Vec<Option<usize>>,
    /// How many different answers there are.
    different: usize,
    near: Arc<Neighbours>,
    /// Share of answers given by chance.
    chance: f64,
}

impl ResponseModel {
    /// `classes` are the answers to the training snapshots, `near` the training places near every cell, and `chance` the share
    /// of answers that are given by chance, above 0.
    ///
    /// # Errors
    /// Where a neighbour is none of the training places, or the share is not above 0 and below 1.
    pub fn new(
        recogniser: Box<dyn Recogniser>,
        classes: Vec<Option<usize>>,
        near: Arc<Neighbours>,
        chance: f64,
    ) -> Result<Self> {
        let neighbours = (0..near.len()).flat_map(|cell| near.of(cell));
        if let Some(bad) = neighbours.into_iter().find(|&&k| k >= classes.len()) {
            return Err(Error::work(format!(
                "responses: neighbour {bad} is none of the {} training places",
                classes.len()
            )));
        }
        if !(chance > 0.0 && chance < 1.0) {
            return Err(Error::work(format!(
                "responses: {chance} of the answers by chance; expected more than 0, below 1"
            )));
        }
        let mut different = classes.clone();
        different.sort_unstable();
        different.dedup();
        let map = Arc::new(ResponseMap {
            different: different.len(),
            classes,
            near,
            chance,
        });
        Ok(Self { recogniser, map })
    }

    /// The same recogniser and answers at other cells: `near` are the training places near them.
    ///
    /// # Errors
    /// As [`ResponseModel::new`].
    pub fn at_cells(self, near: Arc<Neighbours>) -> Result<Self> {
        let (classes, chance) = (self.map.classes.clone(), self.map.chance);
        Self::new(self.recogniser, classes, near, chance)
    }
}

impl ResponseMap {
    fn log_likelihood(&self, class: Option<usize>, belief: &Belief) -> Result<Vec<f64>> {
        if belief.mass().len() != self.near.len() {
            return Err(Error::work(format!(
                "responses: a belief over {} places; expected the {} cells that it was made for",
                belief.mass().len(),
                self.near.len()
            )));
        }
        let all = self.classes.iter().filter(|given| **given == class).count();
        if all == 0 {
            return Ok(vec![0.0; self.near.len()]);
        }
        let by_chance = self.chance / self.different as f64;
        let log = |share: f64| ((1.0 - self.chance) * share + by_chance).ln();
        let anywhere = log(all as f64 / self.classes.len() as f64);
        let k = self.near.k() as f64;
        let at = |cell: usize| {
            if !self.near.is_mapped(cell) {
                return anywhere;
            }
            let near = self.near.of(cell).iter();
            let times = near.filter(|&&k| self.classes[k] == class).count();
            log(times as f64 / k)
        };
        Ok((0..self.near.len()).map(at).collect())
    }
}

fn class(response: Option<Response>) -> Option<usize> {
    response.map(|response| response.class)
}

impl SensorModel for ResponseModel {
    fn name(&self) -> &str {
        self.recogniser.name()
    }

    fn log_likelihood(
        &self,
        observation: &Observation,
        belief: &Belief,
        _: &mut Stream,
    ) -> Result<Vec<f64>> {
        self.recogniser.check_channels(observation.channels)?;
        let response = self.recogniser.respond(observation.channels, observation);
        self.map.log_likelihood(class(response), belief)
    }

    /// The recogniser answers all of them at once.
    fn prepare<'a>(
        &'a self,
        recording: &'a Recording,
        snapshots: &[usize],
    ) -> Result<Box<dyn PreparedSensorModel + 'a>> {
        self.recogniser.check_channels(recording.channels())?;
        let responses = self.recogniser.respond_all(recording, snapshots);
        let classes = responses.into_iter().map(class).collect();
        Ok(Box::new(PreparedResponses {
            classes: Prepared::new(snapshots, classes),
            map: Arc::clone(&self.map),
        }))
    }
}

struct PreparedResponses {
    classes: Prepared<Option<usize>>,
    map: Arc<ResponseMap>,
}

impl PreparedSensorModel for PreparedResponses {
    fn log_likelihood(&self, snapshot: usize, belief: &Belief, _: &mut Stream) -> Result<Vec<f64>> {
        self.map
            .log_likelihood(*self.classes.get(snapshot)?, belief)
    }

    fn depends_on_belief(&self) -> bool {
        false
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        belief::{Nearness, Places},
        recogniser::{Kind, learn, test_world::test_world},
        seed::Seed,
    };

    /// Three mapped places a metre apart and one far off, two neighbours each.
    #[test]
    fn a_response_is_as_likely_as_it_was_given_near_the_place() {
        let room = test_world();
        let nearest = learn(&Kind::Nearest.default_config(), &room, &[0, 1, 2], Seed(1));
        let map = Places::Route(vec![0.0, 1.0, 2.0]);
        let cells = Arc::new(Places::Route(vec![0.4, 1.6, 50.0]));
        let nearness = Nearness {
            k: 2,
            ..Nearness::default()
        };
        let near = Arc::new(Neighbours::find(&map, &cells, &nearness).unwrap());
        assert!(!near.is_mapped(2));
        let classes = vec![Some(4), Some(4), None];
        let model = ResponseModel::new(nearest.unwrap().boxed(), classes, near, 0.1).unwrap();
        let belief = Belief::uniform(&cells).unwrap();
        let likelihood = |class| -> Vec<f64> {
            let log = model.map.log_likelihood(class, &belief).unwrap();
            log.into_iter().map(f64::exp).collect()
        };
        let close = |found: Vec<f64>, expected: [f64; 3]| {
            let off = found.iter().zip(expected).map(|(a, b)| (a - b).abs());
            assert!(off.sum::<f64>() < 1e-9, "{found:?}");
        };
        // 0.9 · share + 0.1 / 2 classes; on no mapped place two of three.
        close(likelihood(Some(4)), [0.95, 0.5, 0.65]);
        close(likelihood(None), [0.05, 0.5, 0.35]);
        // Never given: nothing is known.
        close(likelihood(Some(9)), [1.0, 1.0, 1.0]);
        let other = Belief::uniform(&Arc::new(Places::Route(vec![0.0]))).unwrap();
        let error = model.map.log_likelihood(None, &other).unwrap_err();
        assert!(
            error.to_string().contains("expected the 3 cells"),
            "{error}"
        );
    }
}
