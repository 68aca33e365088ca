//! The arrays of an exported model, put together by the rules that `models/README.md` states and nothing else, compute
//! what the model itself answers.

use ballmark::{
    Detector, Pose, Recipe, Recording, Training,
    detector::net::Activation,
    recording::{Channel, Columns},
};
use ndarray::{Array1, Array2, Array3};
use ndarray_npy::NpzReader;
use serde_json::Value;
use std::{fs::File, path::Path};

const BEAMS: usize = 11;

/// A walk of 60 m past readings of all sorts: ten beams and more, some without return, some beyond the clip, and two
/// values of no range, one of which is missing now and then; of the first channel alone, or of both.
fn recording(channels: usize) -> Recording {
    let snapshots = 120;
    let pose: Vec<Pose> = (0..snapshots)
        .map(|k| Pose::new(0.5 * k as f64, 0.0, 0.0))
        .collect();
    let value = |(k, d): (usize, usize)| match (k * 7 + d * 13) % 17 {
        0 => f32::NAN,
        other if d < BEAMS => other as f32 * 0.7 + (k as f32 * 0.31).sin(),
        other => other as f32 - 5.0,
    };
    Recording::new(Columns {
        channels: vec![
            channel("laser", BEAMS, "m", Some(30.0)),
            channel("light", 2, "lx", None),
        ]
        .into_iter()
        .take(channels)
        .collect(),
        values: Array2::from_shape_fn(
            (snapshots, if channels == 1 { BEAMS } else { BEAMS + 2 }),
            value,
        ),
        stamp_s: (0..snapshots).map(|k| k as f64).collect(),
        odometry: pose.clone(),
        pose,
        run: vec![0; snapshots],
        ..Columns::default()
    })
    .unwrap()
}

fn channel(name: &str, width: usize, unit: &str, maximum: Option<f64>) -> Channel {
    let (name, unit) = (name.into(), unit.into());
    Channel {
        name,
        width,
        unit,
        bearing_rad: None,
        maximum,
        offset_m: None,
    }
}

struct Exported(NpzReader<File>);

impl Exported {
    fn vector(&mut self, name: &str) -> Option<Array1<f32>> {
        self.0.by_name(name).ok()
    }

    fn matrix(&mut self, name: &str) -> Option<Array2<f32>> {
        self.0.by_name(name).ok()
    }

    /// Rule 3, the convolutions: `x` is `[number, direction]`, statistic by statistic.
    fn convolutions(
        &mut self,
        mut x: Array2<f32>,
        layers: &Value,
        activation: fn(f32) -> f32,
    ) -> Array1<f32> {
        let mut any = false;
        for l in 0.. {
            let name = format!("filter.convolution.{l}");
            let Some(weight): Option<Array3<f32>> = self.0.by_name(&format!("{name}.weight")).ok()
            else {
                break;
            };
            any = true;
            let bias = self.vector(&format!("{name}.bias")).unwrap();
            let (out, numbers, width) = weight.dim();
            let (directions, stride) = (x.ncols(), layers[l]["stride"].as_u64().unwrap() as usize);
            let sum = |(o, p): (usize, usize)| {
                let mut sum = bias[o];
                for (c, j) in (0..numbers).flat_map(|c| (0..width).map(move |j| (c, j))) {
                    // Past the ends the outermost direction is repeated.
                    let at = (p * stride + j)
                        .saturating_sub(width / 2)
                        .min(directions - 1);
                    sum += weight[[o, c, j]] * x[[c, at]];
                }
                activation(sum)
            };
            x = Array2::from_shape_fn((out, directions.div_ceil(stride)), sum);
        }
        // To the trunk they go direction by direction; without convolutions statistic by statistic.
        match any {
            true => x.t().iter().copied().collect(),
            false => x.iter().copied().collect(),
        }
    }

    /// Layers `name.0`, `name.1`, … on some inputs; the last one's sum goes through the activation too in a trunk.
    fn layers(
        &mut self,
        name: &str,
        mut x: Array1<f32>,
        activation: fn(f32) -> f32,
    ) -> Array1<f32> {
        for l in 0.. {
            let Some(weight) = self.matrix(&format!("{name}.{l}.weight")) else {
                break;
            };
            x = weight.dot(&x) + self.vector(&format!("{name}.{l}.bias")).unwrap();
            let is_last = self.matrix(&format!("{name}.{}.weight", l + 1)).is_none();
            if name == "filter.trunk" || !is_last {
                x.mapv_inplace(activation);
            }
        }
        x
    }
}

/// Rule 1: the inputs before they are normalised.
fn pooled(channels: &Value, mut raw: &[f32]) -> Vec<f32> {
    let mut inputs = Vec::new();
    for channel in channels.as_array().unwrap() {
        let (own, others) = raw.split_at(channel["width"].as_u64().unwrap() as usize);
        raw = others;
        let Some(ranges) = channel["kind"].get("ranges") else {
            inputs.extend(own);
            let may_miss = channel["kind"]["values"].get("may_miss");
            for value in may_miss.and_then(Value::as_array).into_iter().flatten() {
                let reading = own[value.as_u64().unwrap() as usize];
                inputs.push(if reading.is_nan() { 0.0 } else { 1.0 });
            }
            continue;
        };
        let clip = ranges["clip"].as_f64().unwrap() as f32;
        let far_clip = ranges["far_clip"].as_f64().unwrap() as f32;
        let n = ranges["sectors"].as_u64().unwrap() as usize;
        for value in ranges["sector_values"].as_array().unwrap() {
            for s in 0..n {
                let beams = &own[s * own.len() / n..(s + 1) * own.len() / n];
                let mut beams: Vec<f32> = beams
                    .iter()
                    .map(|r| {
                        if r.is_nan() {
                            far_clip
                        } else {
                            r.clamp(0.0, far_clip)
                        }
                    })
                    .collect();
                beams.sort_by(f32::total_cmp);
                inputs.push(match value.as_str().unwrap() {
                    "nearest" => beams[0].min(clip),
                    "middle" => beams[(beams.len() - 1) / 2].min(clip),
                    "farthest" => beams[beams.len() - 1].min(clip),
                    "middle_log" => (1.0 + beams[(beams.len() - 1) / 2]).ln(),
                    "farthest_log" => (1.0 + beams[beams.len() - 1]).ln(),
                    other => panic!("{other}"),
                });
            }
        }
    }
    inputs
}

fn answers(file: &Path, recording: &Recording) -> Array2<f32> {
    let mut exported = Exported(NpzReader::new(File::open(file).unwrap()).unwrap());
    let meta: Array1<u8> = exported.0.by_name("meta").unwrap();
    let meta: Value = serde_json::from_slice(&meta.to_vec()).unwrap();
    let activation = match meta["activation"].as_str().unwrap() {
        "tanh" => f32::tanh,
        other => panic!("{other}"),
    };
    let mean = exported.vector("input.mean").unwrap();
    let deviation = exported.vector("input.deviation").unwrap();
    let features = meta["recipe"]["features"].as_u64().unwrap() as usize;
    let mut answers = Array2::zeros((recording.len(), features));
    for (k, raw) in recording.values().rows().into_iter().enumerate() {
        let x = Array1::from(pooled(&meta["input"]["channels"], &raw.to_vec()));
        let x = ((x - &mean) / &deviation).mapv(|x| if x.is_nan() { 0.0 } else { x });
        let n = x.len();
        let scan = &meta["input"]["channels"][0]["kind"]["ranges"];
        let directions = match meta["input"]["channels"].as_array().unwrap().len() {
            1 => scan["sectors"].as_u64().unwrap() as usize,
            _ => n,
        };
        let x = x
            .into_shape_with_order((n / directions, directions))
            .unwrap();
        let x = exported.convolutions(x, &meta["recipe"]["network"]["convolutions"], activation);
        let trunk = exported.layers("filter.trunk", x, activation);
        for i in 0..features {
            let sum = exported.layers(&format!("filter.{i}"), trunk.clone(), activation)[0];
            answers[[k, i]] = 1.0 / (1.0 + (-sum).exp());
        }
    }
    answers
}

#[test]
fn the_stated_rules_compute_what_the_model_answers() {
    rules_hold(&recording(1), &[]);
    rules_hold(&recording(2), &[]);
    rules_hold(&recording(2), &[1.0, 2.5]);
}

fn rules_hold(recording: &Recording, history_m: &[f64]) {
    let mut recipe = Recipe {
        features: 3,
        ..Recipe::default()
    };
    recipe.input.sectors = 4;
    recipe.input.history_m = Some(history_m.to_vec());
    recipe.network.trunk = vec![6, 5];
    recipe.network.hidden = vec![4];
    recipe.network.activation = Activation::Tanh;
    recipe.augmentation.shift_m = 0.0; // no bearings, so no moved views
    recipe.augmentation.turn_rad = 0.0;
    recipe.descent.steps = 60;
    let model = Training::new(&recipe, recording).run().unwrap().model;
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("weights.npz");
    model.write(&file).unwrap();

    let seen = model.seen_in(recording).unwrap();
    let expected = model.detector().probabilities(&seen).unwrap();
    let found = answers(&file, &seen);
    let spread = |g: ndarray::ArrayView1<f32>| g.fold(0f32, |m, v| m.max((v - g[0]).abs()));
    assert!(expected.columns().into_iter().all(|g| spread(g) > 0.05));
    for (found, expected) in found.iter().zip(&expected) {
        assert!(
            (found - expected).abs() < 1e-5,
            "{found} instead of {expected}"
        );
    }
}
