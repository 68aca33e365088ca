//! Recognition without memory: every test snapshot is answered once, by systems that give the same number of responses.
//!
//! D00 (Duckett & Nehmzow 2000), Experiments: places are bins of 6 m, the first lap is learned from and the others are
//! answered, and the parameters of each system are set so that all give the same number of responses N_R: more responses
//! can tell more, whoever gives them.

use super::{protocol::Protocol, standard::MAX_DRAWINGS};
use crate::{
    error::{Error, Result},
    recogniser::{Kind, ReadyToMatch, Recogniser, RecogniserConfig},
    recording::Observation,
    score::{AnswerCount, Binning, Contingency, Effort, Judgement},
    seed::Seed,
};
use serde::{Deserialize, Serialize};
use std::{
    cmp::Ordering,
    collections::{BTreeMap, HashSet},
    fmt,
    time::Instant,
};

/// The constants of the comparison; the default is D00's.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct RecognitionConfig {
    /// Sides of the location bins, metres.
    pub bin_m: f64,
    /// Number of responses N_R that all systems are to give; none: as many as the nearest neighbour's with its own
    /// constants, patterns 1.5 m apart.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub responses: Option<usize>,
    /// The same by the names of datasets, for those that have a number of their own: `{ A = 16, B = 25 }`.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub responses_of: BTreeMap<String, usize>,
    /// How far from it a system may stay. Ours: "as closely as possible".
    pub tolerance: usize,
    /// Random tables for the p-value; 0: no p-value.
    pub permutations: u64,
    /// Bootstrap resamples for the interval; 0: none.
    pub resamples: u64,
}

impl Default for RecognitionConfig {
    fn default() -> Self {
        let effort = Effort::default();
        Self {
            bin_m: 6.0,
            responses: None,
            responses_of: BTreeMap::new(),
            tolerance: 1,
            permutations: effort.permutations,
            resamples: effort.resamples,
        }
    }
}

/// Most responses that can be asked for.
const MAX_RESPONSES: usize = 10_000;
/// Steps of the search by halves: each dial's range is left with a part in a million.
const HALVINGS: usize = 20;
/// Values tried evenly over the range, from where halving ended outwards, where it ended beside the number: it needn't
/// fall or rise all the way.
const EVEN: usize = 48;

impl RecognitionConfig {
    /// # Errors
    /// A usage error that names the key out of bounds.
    pub fn check(&self) -> Result<()> {
        let wrong = |key: &str, value: String, expected: &str| {
            Err(Error::usage(format!(
                "recognition.{key} = {value}: expected {expected}"
            )))
        };
        if !(self.bin_m > 0.0 && self.bin_m.is_finite()) {
            return wrong("bin_m", self.bin_m.to_string(), "more than 0");
        }
        let named = self.responses_of.iter();
        let named = named.map(|(name, &n)| (format!("responses_of.{}", name.escape_debug()), n));
        let for_all = self.responses.map(|n| ("responses".to_string(), n));
        for (key, responses) in for_all.into_iter().chain(named) {
            if !(2..=MAX_RESPONSES).contains(&responses) {
                return wrong(&key, responses.to_string(), "2 to 10000");
            }
        }
        for (key, value) in [
            ("permutations", self.permutations),
            ("resamples", self.resamples),
        ] {
            if value > MAX_DRAWINGS {
                return wrong(key, value.to_string(), "1000000 or less");
            }
        }
        Ok(())
    }

    /// N_R of a dataset: the number asked for, or the nearest neighbour's on this protocol.
    ///
    /// # Errors
    /// As [`recognise`].
    pub fn wanted(&self, dataset: &str, protocol: &Protocol, seed: Seed) -> Result<usize> {
        self.check()?;
        let own = self.responses_of.get(dataset).copied();
        match own.or(self.responses) {
            Some(responses) => Ok(responses),
            None => Ok(Answers::of(protocol, &Kind::Nearest.default_config(), seed)?.different()),
        }
    }
}

/// What the comparison says of a recogniser.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct RecognitionRecord {
    /// Its kind and its constants, as they were set for the number of responses.
    pub config: serde_json::Value,
    /// Patterns that it keeps.
    pub patterns: usize,
    /// N_R: different responses in the test, no answer being one of them.
    pub responses: usize,
    /// The number that was to be met; none where it was left as it is, having no constant to set.
    pub wanted: Option<usize>,
    /// Share of the snapshots that it didn't answer.
    pub unanswered: f64,
    /// Bytes that it keeps of a pattern.
    pub bytes_per_place: usize,
    /// Patterns that a snapshot is compared with.
    pub matches: usize,
    /// Its answers, judged.
    pub judgement: Judgement,
    /// Themselves: how often each class was answered at each bin, `none` where it didn't answer.
    #[serde(default)]
    pub answers: Vec<AnswerCount>,
}

/// A recogniser that was judged, as it was then.
pub struct Recognition {
    /// What is said of it.
    pub record: RecognitionRecord,
    /// Its constants, as they were set for the number of responses.
    pub config: Box<dyn RecogniserConfig>,
    /// Itself, having learned.
    pub recogniser: Box<dyn Recogniser>,
}

/// A recogniser that has learned, and its answers to the testing part.
struct Answers {
    recogniser: Box<dyn Recogniser>,
    classes: Vec<Option<usize>>,
}

impl Answers {
    fn of(protocol: &Protocol, config: &dyn RecogniserConfig, seed: Seed) -> Result<Self> {
        config.check()?;
        let recogniser = config.learn(&protocol.recording, &protocol.mapping, seed)?;
        recogniser.check_channels(protocol.recording.channels())?;
        let answers = recogniser.respond_all(&protocol.recording, &protocol.testing);
        let classes = answers
            .iter()
            .map(|answer| answer.map(|a| a.class))
            .collect();
        Ok(Self {
            recogniser,
            classes,
        })
    }

    fn different(&self) -> usize {
        self.classes.iter().collect::<HashSet<_>>().len()
    }
}

/// Lets a recogniser learn from the mapping part and answer the testing part, with its [dial](RecogniserConfig::dial) set so
/// that it gives `wanted` responses, or its constants as they are where no number is wanted or it has no dial. Judged by these
/// bins, which must be the protocol's own.
///
/// ```
/// use ballmark::{experiment::{recognition::{RecognitionConfig, recognise}, protocol::{Mapping, Protocol, ProtocolConfig}},
///     recogniser::Kind, seed::Seed, world::corridor};
/// let config = corridor::CorridorConfig { runs: 2, spacing_m: 0.5, ..Default::default() };
/// let recording = corridor::thrun1998(Seed(1), &config)?;
/// let protocol = Protocol::new(&recording, &ProtocolConfig { mapping: Mapping::FirstRun, ..Default::default() })?;
/// let config = RecognitionConfig { responses: Some(12), ..Default::default() };
/// let binning = protocol.binning(config.bin_m)?;
/// for kind in [Kind::Rce, Kind::Nearest] {
///     let wanted = config.wanted("corridor", &protocol, Seed(1))?;
///     let record = recognise(&protocol, &binning, &kind.default_config(), Some(wanted), &config, Seed(1), &mut |_| ())?.record;
///     assert!(record.responses.abs_diff(12) <= 1 && record.judgement.uncertainty_coefficient > Some(0.05));
/// }
/// # Ok::<(), ballmark::Error>(())
/// ```
///
/// `progress` is called before each value of the dial that is tried.
///
/// # Errors
/// Where the recogniser can't learn, or no value of its dial gives the number wanted: the message names dial and number.
pub fn recognise(
    protocol: &Protocol,
    binning: &Binning,
    config: &dyn RecogniserConfig,
    wanted: Option<usize>,
    recognition: &RecognitionConfig,
    seed: Seed,
    progress: &mut dyn FnMut(Search),
) -> Result<Recognition> {
    recognition.check()?;
    let wanted = wanted.filter(|&wanted| config.dial(wanted).is_some());
    let (config, answers) = match wanted {
        None => (config.clone_box(), Answers::of(protocol, config, seed)?),
        Some(wanted) => {
            let tolerance = recognition.tolerance;
            tuned(protocol, config, (wanted, tolerance), seed, progress)?
        }
    };
    let (mut table, mut points) = (Contingency::new(), Vec::new());
    for (&k, class) in protocol.testing.iter().zip(&answers.classes) {
        let location = binning.bin_of(protocol.place[k]).ok_or_else(|| {
            Error::work(format!(
                "recognition: snapshot {k} is in none of the bins; expected bins laid over this protocol"
            ))
        })?;
        table.record(location, *class);
        points.push((location, *class));
    }
    let counted = AnswerCount::all(points.into_iter().map(|(location, class)| {
        let class = class.map_or("none".to_string(), |class| class.to_string());
        (location, class)
    }));
    let unit_of: Vec<usize> = protocol.testing.iter().map(|&k| protocol.unit[k]).collect();
    let effort = Effort {
        permutations: recognition.permutations,
        resamples: recognition.resamples,
    };
    let silent = answers
        .classes
        .iter()
        .filter(|class| class.is_none())
        .count();
    let responses = answers.different();
    let recogniser = answers.recogniser;
    Ok(Recognition {
        record: RecognitionRecord {
            config: config.to_json()?,
            patterns: recogniser.responses(),
            responses,
            wanted,
            unanswered: silent as f64 / protocol.testing.len() as f64,
            bytes_per_place: recogniser.bytes_per_place(),
            matches: recogniser.matches(),
            judgement: Judgement::of(&table, &unit_of, effort, seed),
            answers: counted,
        },
        config,
        recogniser,
    })
}

/// How far the search for a number of responses is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Search {
    /// Values of the dial that were tried; there are at most 69.
    pub tried: usize,
    /// The number of responses nearest to the one wanted so far; none before the first.
    pub nearest: Option<usize>,
    /// The number wanted.
    pub wanted: usize,
}

impl fmt::Display for Search {
    /// How many values were tried, and what came nearest.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "value {}", self.tried + 1)?;
        match self.nearest {
            Some(nearest) => write!(f, ": {nearest} of {} responses", self.wanted),
            None => Ok(()),
        }
    }
}

/// The constants, and the answers, nearest to the number of responses wanted.
fn tuned(
    protocol: &Protocol,
    config: &dyn RecogniserConfig,
    (wanted, tolerance): (usize, usize),
    seed: Seed,
    progress: &mut dyn FnMut(Search),
) -> Result<(Box<dyn RecogniserConfig>, Answers)> {
    let Some(dial) = config.dial(wanted) else {
        return Err(Error::work(format!(
            "{}: no constant changes the number of its responses",
            config.kind()
        )));
    };
    let mut best: Option<Tried> = None;
    let mut tried = HashSet::new();
    // The number of responses at a share of the range, from few to many; none where it was tried before.
    let mut try_at = |share: f64, best: &mut Option<Tried>| -> Result<usize> {
        progress(Search {
            tried: tried.len(),
            nearest: best.as_ref().map(|best| best.answers.different()),
            wanted,
        });
        let mut config = config.clone_box();
        config.turn_dial(dial.at(share));
        let answers = Answers::of(protocol, config.as_ref(), seed)?;
        let number = answers.different();
        let off = number.abs_diff(wanted);
        if tried.insert(dial.at(share).to_bits()) && best.as_ref().is_none_or(|best| off < best.off)
        {
            let value = dial.at(share);
            *best = Some(Tried {
                off,
                value,
                config,
                answers,
            });
        }
        Ok(number)
    };
    let (mut few, mut many) = (0.0, 1.0);
    for _ in 0..HALVINGS {
        let middle = 0.5 * (few + many);
        match try_at(middle, &mut best)?.cmp(&wanted) {
            Ordering::Less => few = middle,
            Ordering::Equal => break,
            Ordering::Greater => many = middle,
        }
        if dial.at(few) == dial.at(many) {
            break;
        }
    }
    let mut even: Vec<f64> = (0..=EVEN).map(|step| step as f64 / EVEN as f64).collect();
    even.sort_by(|a, b| (a - few).abs().total_cmp(&(b - few).abs()));
    for share in even {
        if best.as_ref().is_some_and(|best| best.off <= tolerance) {
            break;
        }
        try_at(share, &mut best)?;
    }
    match best {
        Some(best) if best.off <= tolerance => Ok((best.config, best.answers)),
        best => {
            let (value, number) =
                best.map_or((f64::NAN, 0), |best| (best.value, best.answers.different()));
            Err(Error::work(format!(
                "{}: no {} from {} to {} gives {wanted} responses (± {tolerance}); nearest is {number}, at {value}",
                config.kind(),
                dial.key,
                dial.range[0],
                dial.range[1]
            )))
        }
    }
}

/// A value of the dial that was tried.
struct Tried {
    /// How far the number of responses is from the one wanted.
    off: usize,
    value: f64,
    config: Box<dyn RecogniserConfig>,
    answers: Answers,
}

/// Snapshots that are answered for one reading of the clock.
const TIMED: usize = 200;
/// Seconds that are measured at least.
const LEAST_S: f64 = 0.3;

/// Seconds for comparing a snapshot with one pattern, on one thread: the fastest of several passes over at most 200 snapshots of
/// the testing part, whose grids and signatures have been made before ([`Recogniser::ready`]). D00's T, "the mean processor
/// time required to match a landmark". A timing: kept out of records.
pub fn seconds_per_match(protocol: &Protocol, recogniser: &dyn Recogniser) -> f64 {
    let every = protocol.testing.len().div_ceil(TIMED).max(1);
    let some: Vec<usize> = protocol.testing.iter().copied().step_by(every).collect();
    let channels = protocol.recording.channels();
    let observations: Vec<Observation> = some
        .iter()
        .map(|&k| protocol.recording.observation(k))
        .collect();
    let ready = |observation| recogniser.ready(channels, observation);
    let ready: Vec<ReadyToMatch> = observations.iter().map(ready).collect();
    let (begun, mut fastest) = (Instant::now(), f64::INFINITY);
    loop {
        let pass = Instant::now();
        for answer in &ready {
            std::hint::black_box(answer());
        }
        fastest = fastest.min(pass.elapsed().as_secs_f64());
        if begun.elapsed().as_secs_f64() > LEAST_S {
            return fastest / (some.len() * recogniser.matches().max(1)) as f64;
        }
    }
}

#[cfg(test)]
mod tests;
