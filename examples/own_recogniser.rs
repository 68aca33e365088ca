//! A recogniser of one's own: in a comparison beside built-in ones, by value and by name in a configuration, and under the
//! laws that every recogniser must keep.
//!
//! `cargo run --release --example own_recogniser`

use ballmark::{
    Observation, Recogniser, Recording, Result, Seed,
    experiment::{
        compare::{CompareConfig, DatasetConfig, Folders, Registry, SystemConfig, compare},
        protocol::{Mapping, ProtocolConfig},
        recognition::RecognitionConfig,
    },
    recogniser::{Kind, RecogniserConfig, Response, dial::Dial, laws},
    recording::{Channel, npz},
    registry::Constants,
};
use serde::{Deserialize, Serialize};
use std::path::Path;

/// Tells places apart by how much room there is around the robot: the mean of all its readings, in steps.
#[derive(Debug, Clone, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
struct RoomAround {
    /// Means that fall into one step of so many metres are one class.
    step_m: f64,
}

impl Default for RoomAround {
    fn default() -> Self {
        Self { step_m: 0.25 }
    }
}

impl Constants for RoomAround {
    fn kind(&self) -> &str {
        "room_around"
    }

    fn description(&self) -> &str {
        "The mean of all readings, in steps."
    }
}

impl RecogniserConfig for RoomAround {
    fn learn(
        &self,
        recording: &Recording,
        snapshots: &[usize],
        _: Seed,
    ) -> Result<Box<dyn Recogniser>> {
        let values = |&k: &usize| mean(&recording.observation(k));
        let farthest_m = snapshots.iter().filter_map(values).fold(f64::NAN, f64::max);
        if farthest_m.is_nan() {
            return Err(ballmark::Error::work(
                "room_around: no reading to learn from",
            ));
        }
        Ok(Box::new(Learned {
            channels: recording.channels().to_vec(),
            step_m: self.step_m,
            classes: (farthest_m / self.step_m) as usize + 1,
        }))
    }

    /// Optional: comparisons at equal numbers of responses search this constant. Without it the recogniser is judged as it is.
    fn dial(&self, _: usize) -> Option<Dial> {
        Some(Dial {
            key: "step_m".into(),
            range: [0.001, 5.0],
            is_whole: false,
            by_ratio: true,
            more_makes_more: false, // wider steps, fewer classes
        })
    }

    fn turn_dial(&mut self, to: f64) {
        self.step_m = to;
    }
}

/// What it has learned: which sensors it works from, and how many steps there are.
struct Learned {
    channels: Vec<Channel>,
    step_m: f64,
    classes: usize,
}

/// The mean of the readings that are any; NaN is no return.
fn mean(observation: &Observation) -> Option<f64> {
    let readings = observation.values.iter().filter(|v| v.is_finite());
    let (sum, n) = readings.fold((0.0, 0.0), |(sum, n), v| (sum + f64::from(*v), n + 1.0));
    (n > 0.0).then(|| sum / n)
}

impl Recogniser for Learned {
    fn name(&self) -> &str {
        "room_around"
    }

    fn responses(&self) -> usize {
        self.classes
    }

    fn matches(&self) -> usize {
        1
    }

    fn bytes_per_place(&self) -> usize {
        size_of::<f64>()
    }

    fn check_channels(&self, channels: &[Channel]) -> Result<()> {
        let missing = self
            .channels
            .iter()
            .find(|channel| !channels.contains(channel));
        missing.map_or(Ok(()), |channel| {
            let fault = format!("no channel `{}` as it was learned from", channel.name);
            Err(ballmark::Error::work(fault))
        })
    }

    fn respond(&self, channels: &[Channel], observation: &Observation) -> Option<Response> {
        self.check_channels(channels).ok()?;
        let step = mean(observation)? / self.step_m;
        Some(Response {
            class: (step.max(0.0) as usize).min(self.classes - 1),
            fit: 1.0,
        })
    }
}

pub fn main() -> Result<()> {
    let here = Path::new(env!("CARGO_MANIFEST_DIR"));
    let dataset = here.join("datasets/corridor-small.npz");

    // Does it keep the laws? Learned from the first run, asked about all.
    let recording = npz::read(&dataset)?;
    let first_run: Vec<usize> = recording.runs()[0].clone().collect();
    laws::check(&RoomAround::default(), &recording, &first_run)?;

    // By value: beside the nearest neighbour, as many responses as that gives.
    let config = CompareConfig {
        dataset: vec![DatasetConfig::file(&dataset)],
        system: vec![
            SystemConfig::recogniser("room around", RoomAround::default()),
            SystemConfig::recogniser("nearest", Kind::Nearest.default_config()),
        ],
        protocol: ProtocolConfig {
            mapping: Mapping::FirstRun,
            ..ProtocolConfig::default()
        },
        recognition: Some(RecognitionConfig::default()),
        ..CompareConfig::default()
    };
    let models = std::env::temp_dir(); // for models that a comparison trains; none here
    let folders = Folders {
        configuration: here,
        models: &models,
        keeps_beliefs: false,
    };
    let by_value = compare(&config, folders, &mut |_| ())?;
    for sheet in ballmark::report::comparison::sheets(&by_value) {
        println!("{}\n\n{}", sheet.title, sheet.table.text());
    }

    // By name: a program that registers the kind takes configurations that use it.
    let mut registry = Registry::built_in();
    registry.add_recogniser::<RoomAround>("room_around")?;
    let text = r#"
        dataset = [{ file = "datasets/corridor-small.npz" }]
        system = [{ kind = "room_around", name = "room around", step_m = 0.25 }, { kind = "nearest" }]
        protocol = { mapping = "first_run" }
        [recognition]
    "#;
    let by_name = compare(
        &CompareConfig::parse_with(&registry, text)?,
        folders,
        &mut |_| (),
    )?;
    assert_eq!(by_name.record.recognition, by_value.record.recognition);
    Ok(())
}
