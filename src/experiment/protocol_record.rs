//! What two records must share to stand in one table: the same data, parts, trials, bins and starts. Not how anybody learned.

use super::{methods::MethodContext, protocol::Protocol, trials::Trial};
use crate::{
    recording::Recording,
    score::{
        Responses,
        trajectory::{EvaluationOptions, Trajectory},
    },
    storage,
};
use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};
use std::collections::{BTreeMap, HashMap};

/// Digits of a digest that are kept: 64 bits, as nobody forges them.
const DIGITS: usize = 16;

/// Digests of what a result was measured on.
///
/// ```
/// use ballmark::experiment::protocol_record::ProtocolRecord;
/// let of = |data: &str, trials: &str| ProtocolRecord::new([("data", data.to_string()), ("trials", trials.to_string())]);
/// assert_eq!(of("a", "b").hash, of("a", "b").hash);
/// assert_eq!(of("a", "b").difference(&of("a", "c")), Some("trials"));
/// ```
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct ProtocolRecord {
    /// Of all the others together.
    pub hash: String,
    /// One a field: `data`, `sensor`, `mapping`, `testing`, `truth`, `disturbance`, and of localisation trials `trials`, `bins`, `starts`; of
    /// responses `truth`, `trials`, `distances`, and of trajectories `truth`, `rules`.
    #[serde(flatten)]
    pub fields: BTreeMap<String, String>,
}

impl ProtocolRecord {
    /// A record of these fields.
    pub fn new<'a>(fields: impl IntoIterator<Item = (&'a str, String)>) -> Self {
        let fields = fields
            .into_iter()
            .map(|(name, digest)| (name.to_string(), digest));
        let fields: BTreeMap<String, String> = fields.collect();
        let mut all = Fingerprint::default();
        for (name, digest) in &fields {
            all.text(name);
            all.text(digest);
        }
        Self {
            hash: all.end(),
            fields,
        }
    }

    /// Of a protocol that was applied to a recording.
    pub fn of_protocol(protocol: &Protocol) -> Self {
        let recording = &protocol.recording;
        let mut truth = Fingerprint::default();
        protocol
            .place
            .iter()
            .flatten()
            .for_each(|&m| truth.number(m));
        Self::new([
            ("data", data(recording)),
            ("sensor", sensor(recording)),
            ("mapping", indices(&protocol.mapping)),
            ("testing", indices(&protocol.testing)),
            ("truth", truth.end()),
            ("disturbance", seen(recording, &protocol.testing)),
        ])
    }

    /// Of a recording as a whole, by the sensor that it is seen by.
    pub fn of_recording(recording: &Recording) -> Self {
        Self::new([("data", data(recording)), ("sensor", sensor(recording))])
    }

    /// Of localisation trials.
    pub(super) fn of_trials(context: &MethodContext, trials: &[Trial]) -> Self {
        let (parts, config) = (context.parts, context.config);
        let mut snapshots = Fingerprint::default();
        for trial in trials {
            snapshots.whole(trial.unit);
            snapshots.text(&indices(&trial.snapshots));
        }
        let mut bins = Fingerprint::default();
        bins.whole(context.grid.len());
        bins.whole(context.grid.headings());
        bins.number(context.grid.cell_m());
        let mut starts = Fingerprint::default();
        starts.number(config.start_spread_m);
        starts.number(config.start_spread_rad);
        starts.number(config.kidnap_m.unwrap_or(0.0));
        let mut mapping: Vec<usize> = parts
            .source
            .iter()
            .flat_map(|source| source.training.iter().chain(&source.validation))
            .copied()
            .collect();
        mapping.sort_unstable();
        Self::new([
            ("data", data(parts.run)),
            ("sensor", sensor(parts.run)),
            ("mapping", indices(&mapping)),
            ("testing", indices(&parts.unseen)),
            ("disturbance", seen(parts.run, &parts.unseen)),
            ("trials", snapshots.end()),
            ("bins", bins.end()),
            ("starts", starts.end()),
        ])
    }

    /// Of responses that somebody gave: the locations, trials and distances of all rows, whatever was answered there.
    pub fn of_responses(responses: &Responses) -> Self {
        // Which rows share a location, whatever it is called.
        let mut truth = Fingerprint::default();
        let mut numbers: HashMap<&str, usize> = HashMap::new();
        for label in responses.location() {
            let next = numbers.len();
            truth.whole(*numbers.entry(label).or_insert(next));
        }
        let mut trials = Fingerprint::default();
        (responses.trial().unwrap_or_default().iter()).for_each(|&trial| trials.whole(trial));
        let mut distances = Fingerprint::default();
        (responses.distance_m().unwrap_or_default().iter()).for_each(|&m| distances.number(m));
        Self::new([
            ("truth", truth.end()),
            ("trials", trials.end()),
            ("distances", distances.end()),
        ])
    }

    /// Of a trajectory that others are held against: its poses with their time stamps, and by which rules poses are paired, aligned and
    /// measured.
    pub fn of_reference(reference: &Trajectory, options: &EvaluationOptions) -> Self {
        let mut truth = Fingerprint::default();
        (reference.stamps().unwrap_or_default().iter()).for_each(|&stamp_s| truth.number(stamp_s));
        for pose in reference.poses() {
            let numbers = pose.position_m.iter().chain(pose.rotation.iter());
            numbers.for_each(|&number| truth.number(number));
        }
        let mut rules = Fingerprint::default();
        let EvaluationOptions {
            matching,
            alignment,
            in_plane,
            delta,
            ..
        } = options;
        rules.text(&format!("{matching:?} {alignment:?} {in_plane} {delta:?}"));
        Self::new([("truth", truth.end()), ("rules", rules.end())])
    }

    /// The first field, in the order of what decides most, that another record has otherwise; none where they agree.
    pub fn difference(&self, other: &Self) -> Option<&str> {
        const ORDER: [&str; 9] = [
            "data",
            "sensor",
            "truth",
            "mapping",
            "testing",
            "disturbance",
            "trials",
            "bins",
            "starts",
        ];
        let differs = |name: &str| self.fields.get(name) != other.fields.get(name);
        let known = ORDER.into_iter().find(|name| differs(name));
        known.or_else(|| (self.hash != other.hash).then_some("fields that one of them lacks"))
    }
}

/// The checksum of the dataset's file, or of times and poses of a recording that is of none.
fn data(recording: &Recording) -> String {
    match &recording.columns().dataset_sha256 {
        Some(sha256) => sha256.chars().take(DIGITS).collect(),
        None => {
            let mut made = Fingerprint::default();
            for (pose, &stamp_s) in recording.poses().iter().zip(&recording.columns().stamp_s) {
                [stamp_s, pose.x_m, pose.y_m, pose.heading_rad]
                    .into_iter()
                    .for_each(|value| made.number(value));
            }
            made.end()
        }
    }
}

fn sensor(recording: &Recording) -> String {
    let mut sensor = Fingerprint::default();
    if let Some(degraded) = &recording.columns().degraded {
        sensor.text(&degraded.to_string());
    }
    for channel in recording.channels() {
        sensor.text(&channel.name);
        sensor.whole(channel.width);
    }
    sensor.end()
}

/// What sensors and odometry said at some snapshots: people and noise show in it.
fn seen(recording: &Recording, snapshots: &[usize]) -> String {
    let mut seen = Fingerprint::default();
    for &k in snapshots {
        let observation = recording.observation(k);
        let odometry = observation.odometry;
        [odometry.x_m, odometry.y_m, odometry.heading_rad]
            .into_iter()
            .for_each(|value| seen.number(value));
        observation
            .values
            .iter()
            .for_each(|&value| seen.number(f64::from(value)));
    }
    seen.end()
}

fn indices(snapshots: &[usize]) -> String {
    let mut all = Fingerprint::default();
    snapshots.iter().for_each(|&k| all.whole(k));
    all.end()
}

/// A digest in the making.
#[derive(Default)]
struct Fingerprint(Sha256);

impl Fingerprint {
    fn text(&mut self, text: &str) {
        self.whole(text.len());
        self.0.update(text);
    }

    fn whole(&mut self, number: usize) {
        self.0.update((number as u64).to_le_bytes());
    }

    fn number(&mut self, number: f64) {
        // All that is no number is alike.
        let number = if number.is_nan() { f64::NAN } else { number };
        self.0.update(number.to_le_bytes());
    }

    fn end(self) -> String {
        storage::hexadecimal(self.0)[..DIGITS].to_string()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        experiment::protocol::{Mapping, ProtocolConfig},
        seed::Seed,
        world::corridor::{CorridorConfig, thrun1998},
    };

    #[test]
    fn what_decides_a_figure_changes_the_hash() {
        let config = CorridorConfig {
            runs: 3,
            spacing_m: 1.0,
        };
        let recording = thrun1998(Seed(2), &config).unwrap();
        let by = |mapping| ProtocolConfig {
            mapping,
            ..ProtocolConfig::default()
        };
        let applied = || Protocol::new(&recording, &by(Mapping::FirstRun)).unwrap();
        let record = ProtocolRecord::of_protocol(&applied());
        assert_eq!(record, ProtocolRecord::of_protocol(&applied()));
        let crowded = applied().with_people(0.3, Seed(1)).unwrap();
        let crowded = ProtocolRecord::of_protocol(&crowded);
        assert_eq!(record.difference(&crowded), Some("disturbance"));
        let split = Protocol::new(&recording, &by(Mapping::Split)).unwrap();
        assert_eq!(
            record.difference(&ProtocolRecord::of_protocol(&split)),
            Some("mapping")
        );
        let other = thrun1998(Seed(3), &config).unwrap();
        let other = Protocol::new(&other, &by(Mapping::FirstRun)).unwrap();
        assert_eq!(
            record.difference(&ProtocolRecord::of_protocol(&other)),
            Some("data")
        );
        // Which rows share a place, not what places and answers are called.
        let by = |csv: &str| {
            let responses = Responses::from_reader("r.csv", csv.as_bytes()).unwrap();
            ProtocolRecord::of_responses(&responses)
        };
        let own = by("location,response,trial,distance_m\na,1,x,0\na,2,x,1\nb,1,y,0\n");
        let same = by("location,response,trial,distance_m\n7,9,p,0\n7,9,p,1\n8,9,q,0\n");
        assert_eq!(own, same);
        for (other, field) in [
            ("a,1,x,0\nb,2,x,1\nb,1,y,0\n", "truth"),
            ("a,1,x,0\na,2,y,1\nb,1,y,0\n", "trials"),
            ("a,1,x,0\na,2,x,2\nb,1,y,0\n", "distances"),
        ] {
            let other = by(&format!("location,response,trial,distance_m\n{other}"));
            assert_ne!(own.fields[field], other.fields[field]);
            assert!(own.difference(&other).is_some());
        }
        let json = serde_json::to_string(&record).unwrap();
        assert_eq!(
            serde_json::from_str::<ProtocolRecord>(&json).unwrap(),
            record
        );
    }
}
