//! A localiser of one's own: in the standard experiment of a comparison, in the trials of `ballmark localise`, and under the
//! laws that every localiser must keep.
//!
//! `cargo run --release --example own_localiser`

use ballmark::{
    Localiser, Model, Pose, Recording, Result, Seed,
    experiment::{
        compare::{CompareConfig, DatasetConfig, Folders, SystemConfig, compare},
        line_up::line_up,
        localisation::{self, LocaliseConfig},
        methods::MethodContext,
        parts::Parts,
        protocol::{Mapping, ProtocolConfig},
        standard::StandardConfig,
    },
    localiser::{Estimate, Kind, LocaliserConfig, Step, TrialRunner, laws, prepared::Prepared},
    recording::{Channel, npz},
    registry::Constants,
    seed::Stream,
};
use serde::{Deserialize, Serialize};
use std::path::Path;

/// It is where the mapped scan most like the present one was taken, among those that odometry lets it reach since its last
/// answer.
#[derive(Debug, Clone, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
struct ScanTracker {
    /// How much farther or nearer than odometry says the next place may be, in metres.
    slack_m: f64,
}

impl Default for ScanTracker {
    fn default() -> Self {
        Self { slack_m: 1.0 }
    }
}

impl Constants for ScanTracker {
    fn kind(&self) -> &str {
        "scan_tracker"
    }
}

impl LocaliserConfig for ScanTracker {
    fn learn(
        &self,
        recording: &Recording,
        snapshots: &[usize],
        _: Seed,
    ) -> Result<Box<dyn Localiser>> {
        let scan = |&k: &usize| recording.observation(k).values.to_vec();
        let place = |&k: &usize| [recording.poses()[k].x_m, recording.poses()[k].y_m];
        Ok(Box::new(Map {
            slack_m: self.slack_m,
            channels: recording.channels().to_vec(),
            scans: snapshots.iter().map(scan).collect(),
            places: snapshots.iter().map(place).collect(),
        }))
    }
}

/// The mapped scans and where they were taken.
struct Map {
    slack_m: f64,
    channels: Vec<Channel>,
    scans: Vec<Vec<f32>>,
    places: Vec<[f64; 2]>,
}

impl Localiser for Map {
    fn name(&self) -> &str {
        "scan_tracker"
    }

    fn places(&self) -> usize {
        self.places.len()
    }

    fn bytes_per_place(&self) -> usize {
        size_of::<[f64; 2]>() + size_of::<f32>() * self.scans.first().map_or(0, Vec::len)
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

    /// How unlike each snapshot is to each mapped scan does not depend on the trial: it is worked out here.
    fn prepare<'a>(
        &'a self,
        recording: &'a Recording,
        snapshots: &[usize],
    ) -> Result<Box<dyn TrialRunner + 'a>> {
        self.check_channels(recording.channels())?;
        let unlike = |&k: &usize| -> Vec<f32> {
            let now = recording.observation(k).values.to_vec();
            let difference = |(a, b): (&f32, &f32)| match (a - b).abs() {
                d if d < 1.0 => d,
                _ => 1.0, // also where one has no return
            };
            let all = self.scans.iter();
            all.map(|scan| scan.iter().zip(&now).map(difference).sum())
                .collect()
        };
        Ok(Box::new(Tracker {
            map: self,
            recording,
            unlike: Prepared::new(snapshots, snapshots.iter().map(unlike).collect()),
        }))
    }
}

struct Tracker<'a> {
    map: &'a Map,
    recording: &'a Recording,
    unlike: Prepared<Vec<f32>>,
}

impl TrialRunner for Tracker<'_> {
    fn play(&self, trial: &[usize], _: Option<Pose>, _: &mut Stream) -> Result<Vec<Step>> {
        let odometry = |k: usize| self.recording.observation(k).odometry;
        let mut last: Option<(usize, [f64; 2])> = None;
        let mut steps = Vec::new();
        for &k in trial {
            let unlike = self.unlike.get(k)?;
            let within_reach = |place: &[f64; 2]| {
                last.is_none_or(|(before, from)| {
                    let moved_m = odometry(before).distance_m(&odometry(k));
                    let apart_m = (place[0] - from[0]).hypot(place[1] - from[1]);
                    (apart_m - moved_m).abs() <= self.map.slack_m
                })
            };
            let places = self.map.places.iter().zip(unlike);
            let reached = places.filter(|(place, _)| within_reach(place));
            let best = reached
                .min_by(|a, b| a.1.total_cmp(b.1))
                .map(|(place, _)| *place);
            last = best.map(|place| (k, place)).or(last);
            steps.push(Step {
                estimate: best.map(Estimate::Place),
                ..Step::default() // no heading, and no opinion on how sure it is
            });
        }
        Ok(steps)
    }
}

pub fn main() -> Result<()> {
    let here = Path::new(env!("CARGO_MANIFEST_DIR"));
    let dataset = here.join("datasets/corridor-small.npz");
    let recording = npz::read(&dataset)?;
    let [first, second] = [0, 1].map(|run| recording.runs()[run].clone().collect::<Vec<_>>());

    // Does it keep the laws?
    laws::check(&ScanTracker::default(), &recording, &first, &second[..40])?;

    // The standard experiment of Duckett & Nehmzow (1998), beside dead reckoning.
    let config = CompareConfig {
        dataset: vec![DatasetConfig::file(&dataset)],
        system: vec![
            SystemConfig::localiser("scan tracker", ScanTracker::default()),
            SystemConfig::localiser("dead reckoning", Kind::DeadReckoning.default_config()),
        ],
        protocol: ProtocolConfig {
            mapping: Mapping::FirstRun,
            ..ProtocolConfig::default()
        },
        standard: Some(StandardConfig::default()),
        ..CompareConfig::default()
    };
    let models = std::env::temp_dir(); // for models that a comparison trains; none here
    let folders = Folders {
        configuration: here,
        models: &models,
        keeps_beliefs: false,
    };
    let comparison = compare(&config, folders, &mut |_| ())?;
    assert!(comparison.record.failures().is_empty());
    for sheet in ballmark::report::comparison::sheets(&comparison)
        .iter()
        .take(2)
    {
        println!("{}\n\n{}", sheet.title, sheet.table.text());
    }

    // The trials of `ballmark localise`, beside learned filters, on a recording that these never saw.
    let model = Model::read(&here.join("models/corridor-2m.safetensors"))?;
    let parts = Parts::new(&model, &recording, None)?;
    let config = LocaliseConfig {
        trials: 10,
        ..LocaliseConfig::default()
    };
    let models = [&model];
    let context = MethodContext::new(&models, &parts, &config)?;
    let mut methods = line_up(&context)?;
    let tracker = ScanTracker::default().learn(&recording, &first, Seed(1))?;
    methods.push(context.localiser("scan_tracker", "scan tracker", tracker));
    let record = localisation::play(&context, methods, &mut |_| ())?;
    println!("{}", ballmark::report::localisation::table(&record).text());
    assert_eq!(record.results[3].name, "scan_tracker");
    Ok(())
}
