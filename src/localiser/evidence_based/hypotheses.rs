//! The mechanism: a set of hypotheses about where the robot is, and what each step makes of it.

use super::EvidenceBased;
use crate::{
    geometry::{Pose, wrapped},
    localiser::{Estimate, Probable, Step, place_map::PlaceMap},
    recording::{Channel, Observation},
    seed::Stream,
};
use ndarray::ArrayView1;
use rand::RngExt;
use std::borrow::Cow;

/// v: the variance of a new hypothesis. "Always initialised to the same arbitrary value" (3.2): gains don't depend on it.
const INITIAL_VARIANCE: f64 = 1.0;

/// h ∈ H: the robot may be in this place of the map.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Hypothesis {
    /// The number of the place.
    pub place: usize,
    /// x_h, y_h, and the heading that goes with them: where exactly, by all that was seen and reckoned so far, in the
    /// frame of the map's reckoning.
    pub pose: Pose,
    /// v_h, in units that don't matter.
    pub variance: f64,
    /// ln p(h)
    log_probability: f64,
}

impl Hypothesis {
    /// p(h); those of a set sum to 1.
    pub fn probability(&self) -> f64 {
        self.log_probability.exp()
    }
}

/// A robot that has been put down somewhere: the set H, to which one observation after the other is given (D98 3.2).
///
/// ```
/// use ballmark::{localiser::{Learn, evidence_based::{EvidenceBased, EvidenceBasedConfig, Hypotheses}}, seed::Seed, world::corridor};
/// let config = corridor::CorridorConfig { runs: 2, spacing_m: 0.25, ..Default::default() };
/// let recording = corridor::thrun1998(Seed(1), &config)?;
/// let (first, second): (Vec<usize>, Vec<usize>) = (0..recording.len()).partition(|k| recording.runs()[0].contains(k));
/// let evidence = EvidenceBased::learn(&EvidenceBasedConfig::default(), &recording, &first, Seed(1))?;
///
/// let mut robot = Hypotheses::none(&evidence);
/// let mut ties = Seed(1).stream("ties");
/// for &k in &second[..80] {
///     let step = robot.observe(recording.channels(), &recording.observation(k), &mut ties);
///     assert!(step.estimate.is_some());
/// }
/// let sum: f64 = robot.set().iter().map(|h| h.probability()).sum();
/// assert!((sum - 1.0).abs() < 1e-9);
/// # Ok::<(), ballmark::Error>(())
/// ```
#[derive(Debug, Clone)]
pub struct Hypotheses<'a> {
    evidence: &'a EvidenceBased,
    set: Vec<Hypothesis>,
    /// The last observation, without its sensor values.
    last: Option<Observation<'static>>,
    since: Option<Since>,
    answer: Option<usize>,
}

/// What is remembered of the last iteration.
#[derive(Debug, Clone)]
struct Since {
    signature: Vec<f32>,
    /// Metres travelled since.
    travelled_m: f64,
}

/// What a snapshot looks like.
pub(super) struct Sight {
    pub(super) signature: Vec<f32>,
    /// d_m for every place of the map (eq. 1), where that was worked out beforehand.
    pub(super) differences: Option<Vec<f32>>,
}

impl<'a> Hypotheses<'a> {
    /// H = ∅: the robot knows nothing of its place.
    pub fn none(evidence: &'a EvidenceBased) -> Self {
        Self {
            evidence,
            set: Vec::new(),
            last: None,
            since: None,
            answer: None,
        }
    }

    /// The hypotheses, in the order of their places.
    pub fn set(&self) -> &[Hypothesis] {
        &self.set
    }

    /// Takes in the next observation of the run. `ties` is drawn from where two hypotheses are equally good.
    pub fn observe(
        &mut self,
        channels: &[Channel],
        observation: &Observation,
        ties: &mut Stream,
    ) -> Step {
        let signature = self.map().signature(channels, observation);
        let sight = signature.map(|signature| Sight {
            signature,
            differences: None,
        });
        self.take_in(observation, sight.as_ref(), ties)
    }

    /// The same, with what the snapshot looks like already worked out.
    pub(super) fn take_in(
        &mut self,
        observation: &Observation,
        sight: Option<&Sight>,
        ties: &mut Stream,
    ) -> Step {
        self.follow(observation);
        if self.is_due(sight) {
            self.answer = sight.and_then(|sight| self.iterate(sight, ties));
        }
        Step {
            estimate: self.answer.map(Estimate::Class),
            posterior: self.set.iter().map(|h| self.probable(h)).collect(),
            ..Step::default()
        }
    }

    /// Where a hypothesis is in the frame of the mapping part's poses, and p(h).
    fn probable(&self, h: &Hypothesis) -> Probable {
        let [x_m, y_m] = self.map().places()[h.place].reckoned_off_m;
        ([h.pose.x_m - x_m, h.pose.y_m - y_m], h.probability())
    }

    fn map(&self) -> &'a PlaceMap {
        &self.evidence.map
    }

    /// Moves all hypotheses along with the robot (eq. 4, 5), by compass-based odometry (5.2); without a compass by odometry
    /// from the heading that each hypothesis has.
    fn follow(&mut self, now: &Observation) {
        let now = Observation {
            channels: &[],
            stamp_s: now.stamp_s,
            values: ArrayView1::from(&[]),
            odometry: now.odometry,
            compass_rad: now.compass_rad,
        };
        let Some(last) = self.last.replace(now) else {
            return;
        };
        let moved = last.odometry.displacement_to(&now.odometry);
        for Hypothesis { pose, .. } in &mut self.set {
            match last.north_displacement(&now) {
                Some([x_m, y_m]) => {
                    let heading_rad = wrapped(pose.heading_rad + moved.turn_rad);
                    *pose = Pose::new(pose.x_m + x_m, pose.y_m + y_m, heading_rad);
                }
                None => *pose = pose.after(moved),
            }
        }
        if let Some(since) = &mut self.since {
            since.travelled_m += moved.distance_m();
        }
    }

    /// "The robot then waits until it has moved by a distance 2D or the current sensor readings change by T."
    fn is_due(&self, sight: Option<&Sight>) -> bool {
        let (config, map) = (self.map().config(), self.map());
        let Some(since) = &self.since else {
            return true;
        };
        since.travelled_m >= 2.0 * config.distance_m
            || sight.is_some_and(|sight| {
                map.difference(&since.signature, &sight.signature) >= config.threshold
            })
    }

    /// One iteration: from H and what is seen to the new H. Gives the most probable place, the first of several; none where
    /// no place looks like this, and then H is kept and the next observation is tried.
    fn iterate(&mut self, sight: &Sight, ties: &mut Stream) -> Option<usize> {
        self.since = None;
        let differences = match &sight.differences {
            Some(differences) => Cow::Borrowed(differences),
            None => Cow::Owned(self.map().differences(&sight.signature)),
        };
        let mut candidates = self.candidates(&differences);
        if candidates.is_empty() {
            return None;
        }
        for h in &mut self.set {
            h.variance *= 1.0 + self.evidence.config.variance_growth; // eq. 6
        }
        let found: Vec<Hypothesis> = candidates
            .iter()
            .filter_map(|new| {
                let (old, log_match) = self.best_match(new, ties)?;
                let log_probability = new.log_probability + log_match; // eq. 9, 10, not yet normalised
                Some(Hypothesis {
                    log_probability,
                    ..corrected(new, &self.set[old])
                })
            })
            .collect();
        // Without prior hypotheses (eq. 3), or none that could be compared, what is seen must do.
        if found.len() == candidates.len() {
            candidates = found;
        }
        normalise(&mut candidates);
        self.set = candidates;
        self.since = Some(Since {
            signature: sight.signature.clone(),
            travelled_m: 0.0,
        });
        let more = |a: &Hypothesis, b: &Hypothesis| b.log_probability > a.log_probability;
        let most = self
            .set
            .iter()
            .reduce(|a, b| if more(a, b) { b } else { a });
        most.map(|h| h.place)
    }

    /// H': the places with d_m < T, each with ln L(S_c, I_c | h') = −(d_m / w_ex)² (eq. 2).
    fn candidates(&self, differences: &[f32]) -> Vec<Hypothesis> {
        let width = self.evidence.config.exteroceptive_width;
        let threshold = self.map().config().threshold;
        let places = self.map().places().iter().zip(differences).enumerate();
        places
            .filter(|(_, (_, d))| f64::from(**d) < threshold)
            .map(|(place, (of, d))| Hypothesis {
                place,
                pose: of.reckoned(),
                variance: INITIAL_VARIANCE,
                log_probability: -(f64::from(*d) / width).powi(2),
            })
            .collect()
    }

    /// The prior hypothesis h_j* that a new one matches best, and ln Eval (eq. 7, 8); one of the best at random. Where
    /// headings tell places apart, a difference in heading counts as one in place does. `None` where nothing compares.
    fn best_match(&self, new: &Hypothesis, ties: &mut Stream) -> Option<(usize, f64)> {
        let (config, map) = (&self.evidence.config, self.map().config());
        let per_square_m = (config.proprioceptive_width * map.distance_m).powi(-2);
        let oriented = self.map().is_oriented();
        let mut best = (None, f64::NEG_INFINITY);
        let mut equals = 1;
        for (i, old) in self.set.iter().enumerate() {
            let (dx, dy) = (new.pose.x_m - old.pose.x_m, new.pose.y_m - old.pose.y_m);
            let mut log_match = old.log_probability - (dx * dx + dy * dy) * per_square_m;
            if oriented {
                log_match -= (new.pose.turn_rad(&old.pose) / map.heading_rad).powi(2);
            }
            if log_match > best.1 {
                best = (Some(i), log_match);
                equals = 1;
            } else if log_match == best.1 && best.0.is_some() {
                equals += 1;
                if ties.random_range(0..equals) == 0 {
                    best.0 = Some(i);
                }
            }
        }
        best.0.map(|i| (i, best.1))
    }
}

/// The Kalman filter of one hypothesis (eq. 11 to 14): what was reckoned, corrected towards the place on the map. Eq. 14 is
/// printed as K = v / (v − v'), which is infinite at the first step; a Kalman gain is v / (v + v').
fn corrected(new: &Hypothesis, reckoned: &Hypothesis) -> Hypothesis {
    let gain = reckoned.variance / (reckoned.variance + new.variance);
    let (at, place) = (reckoned.pose, new.pose);
    Hypothesis {
        place: new.place,
        pose: Pose::new(
            at.x_m + gain * (place.x_m - at.x_m),
            at.y_m + gain * (place.y_m - at.y_m),
            wrapped(at.heading_rad + gain * wrapped(place.heading_rad - at.heading_rad)),
        ),
        variance: reckoned.variance - gain * reckoned.variance,
        log_probability: new.log_probability,
    }
}

/// Makes the probabilities sum to 1, whatever their scale.
fn normalise(set: &mut [Hypothesis]) {
    let logs = set.iter().map(|h| h.log_probability);
    let most = logs.clone().fold(f64::NEG_INFINITY, f64::max);
    let sum: f64 = logs.map(|log| (log - most).exp()).sum();
    for h in set {
        h.log_probability -= most + sum.ln();
    }
}

#[cfg(test)]
mod tests;
