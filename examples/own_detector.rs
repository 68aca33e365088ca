//! A detector of one's own, and a recogniser as a sensor model: in the trials of `ballmark localise` and in a comparison's error
//! reduction, just as learned features are.
//!
//! `cargo run --release --example own_detector`

use ballmark::{
    Detector, Model, Recording, Result, Seed,
    detector::DetectorConfig,
    experiment::{
        compare::{CompareConfig, DatasetConfig, Folders, SystemConfig, compare},
        error_reduction::ErrorReductionConfig,
        line_up::line_up,
        localisation::{self, LocaliseConfig},
        methods::MethodContext,
        parts::Parts,
        protocol::{Mapping, ProtocolConfig},
    },
    ndarray::{Array2, ArrayView2},
    recogniser::{Kind, RecogniserConfig},
    recording::Channel,
    registry::Constants,
    world::corridor::{CorridorConfig, thrun1998},
};
use serde::{Deserialize, Serialize};
use std::path::Path;

/// One feature for each of the four sides of the robot: is there room on that side?
#[derive(Debug, Clone, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
struct OpenSides {
    /// Room begins at so many metres.
    open_m: f32,
}

impl Default for OpenSides {
    fn default() -> Self {
        Self { open_m: 1.5 }
    }
}

impl Detector for OpenSides {
    fn features(&self) -> usize {
        4
    }

    /// A soft threshold on the median reading of each quarter of the first channel; a reading without return counts as far.
    fn detect_batch(&self, channels: &[Channel], values: ArrayView2<f32>) -> Result<Array2<f32>> {
        let width = channels.first().map_or(0, |channel| channel.width);
        if width < 4 {
            return Err(ballmark::Error::work(
                "open_sides: expected a channel of 4 values or more",
            ));
        }
        let mut probability = Array2::zeros((values.nrows(), 4));
        for (snapshot, readings) in values.rows().into_iter().enumerate() {
            for side in 0..4 {
                let mut quarter: Vec<f32> = (side * width / 4..(side + 1) * width / 4)
                    .map(|i| {
                        if readings[i].is_nan() {
                            f32::INFINITY
                        } else {
                            readings[i]
                        }
                    })
                    .collect();
                quarter.sort_by(f32::total_cmp);
                let median_m = quarter[quarter.len() / 2].min(100.0);
                probability[[snapshot, side]] =
                    1.0 / (1.0 + (4.0 * (self.open_m - median_m)).exp());
            }
        }
        Ok(probability)
    }
}

// For comparisons: its constants, and nothing to fit.
impl Constants for OpenSides {
    fn kind(&self) -> &str {
        "open_sides"
    }
}

impl DetectorConfig for OpenSides {
    fn fit(&self, _: &Recording, _: &[usize]) -> Result<Box<dyn Detector>> {
        Ok(Box::new(self.clone()))
    }
}

pub fn main() -> Result<()> {
    let here = Path::new(env!("CARGO_MANIFEST_DIR"));

    // What one snapshot takes away of a prior uncertainty, beside hand-made doors.
    let config = CompareConfig {
        dataset: vec![DatasetConfig::file("datasets/corridor-small.npz")],
        system: vec![SystemConfig::detector("open sides", OpenSides::default())],
        protocol: ProtocolConfig {
            mapping: Mapping::FirstRun,
            ..ProtocolConfig::default()
        },
        error_reduction: Some(ErrorReductionConfig::default()),
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
    for sheet in ballmark::report::comparison::sheets(&comparison) {
        println!("{}\n\n{}", sheet.title, sheet.table.text());
    }

    // The trials, on the test part of the corridor that the model learned from.
    let model = Model::read(&here.join("models/corridor-2m.safetensors"))?;
    let recording = thrun1998(Seed(1), &CorridorConfig::default())?;
    let parts = Parts::new(&model, &recording, None)?;
    let config = LocaliseConfig {
        trials: 10,
        ..LocaliseConfig::default()
    };
    let models = [&model];
    let context = MethodContext::new(&models, &parts, &config)?;
    let mut methods = line_up(&context)?;
    methods.push(context.detector("open_sides", "open sides", &OpenSides::default())?);
    // Any recogniser, built-in or not, by how likely its responses are at each place.
    let training = &context.source()?.training;
    let nearest = Kind::Nearest.default_config();
    let nearest = RecogniserConfig::learn(&nearest, &recording, training, Seed(1))?;
    methods.push(context.recogniser("nearest", "nearest neighbour", nearest)?);
    let record = localisation::play(&context, methods, &mut |_| ())?;
    println!("{}", ballmark::report::localisation::table(&record).text());

    let of_open_sides = record
        .results
        .iter()
        .find(|result| result.name == "open_sides");
    assert!(of_open_sides.is_some_and(|result| result.held_out[0].score.error_reduction > 0.0));
    Ok(())
}
