//! A model as an ONNX graph: raw channel values in, probabilities out, all preprocessing inside.
//!
//! Input `snapshot` f32 `[batch, D]`: the channels' raw values side by side, NaN where nothing came back. Output `probability` f32
//! `[batch, n]`; of a bank of filters one output a set, `probability.2m`. The map travels as outputs that depend on no input, so that
//! whoever asks for the probabilities alone never sees them: `map.pose` f64 `[K, 3]` (m, m, rad), `map.activation` f32 `[K, n]` (of a
//! bank `set.2m.map.activation`) and, along a route, `map.route` f64 `[K]`; of a bank `map.run` f64 `[K]`. Metadata: `ballmark` (the header as
//! JSON, of a bank a list), `channels` (JSON: name, width, unit, bearings), and last of all `sha256`, the digest of every byte before it.
//!
//! Such a file is a model like any other: it is read back, to the bit.

mod graph;
mod networks;
mod preprocessing;
mod proto;
mod reading;
mod seal;
#[cfg(test)]
mod tests;

pub(super) use reading::{is_graph, read};

use super::{ModelBank, layout::occupancy_number, trained_model::Model};
use crate::{
    error::{Error, Result},
    recording::Channel,
    storage,
};
use graph::{Graph, Length};
use prost::Message;
use proto::{ModelProto, OperatorSetIdProto};
use seal::{entry, seal};
use serde_json::json;
use std::path::Path;

/// Of the standard: file format and operators, the oldest that have all that is used.
const IR_VERSION: i64 = 8;
const OPERATORS: i64 = 13;

/// Writes all sets of a bank (a single model is a bank of one) as an ONNX file, whole or not at all.
///
/// ```
/// use ballmark::model::{ModelBank, onnx};
/// let bank = ModelBank::read("models/corridor-2m.safetensors".as_ref())?;
/// let bytes = onnx::to_bytes(&bank)?;
/// assert!(bytes.windows(11).any(|name| name == b"probability"));
/// # Ok::<(), ballmark::Error>(())
/// ```
///
/// # Errors
/// As [`to_bytes`], and where the file can't be written.
pub fn write(bank: &ModelBank, path: &Path) -> Result<()> {
    let bytes = to_bytes(bank)?;
    storage::write_file(path, |out| out.write_all(&bytes))
}

/// The bytes of that file.
///
/// # Errors
/// Where the sets are of different sensors, so that no one input serves them all, or have different occupancy maps.
pub fn to_bytes(bank: &ModelBank) -> Result<Vec<u8>> {
    let mut bytes = file(bank)?.encode_to_vec();
    let seal = seal(&bytes);
    bytes.extend(seal);
    Ok(bytes)
}

fn file(bank: &ModelBank) -> Result<ModelProto> {
    let sets = bank.sets();
    let [first, others @ ..] = sets else {
        return Err(Error::usage("bank: no set; expected one or more"));
    };
    let channels = &first.header.channels;
    if others.iter().any(|set| set.header.channels != *channels) {
        return Err(Error::work(
            "onnx: sets of different sensors; expected the same channels for all",
        ));
    }
    if others.iter().any(|set| set.occupancy != first.occupancy) {
        return Err(Error::work(
            "onnx: sets with different occupancy maps; expected one map for all",
        ));
    }
    let width: usize = channels.iter().map(|channel| channel.width).sum();
    let mut graph = Graph::new("ballmark", what(sets));
    let batch = Length::Named("batch");
    let doc = format!("raw values, NaN = no return: {}", in_words(channels));
    graph.input("snapshot", &[batch, Length::Fixed(width)], doc);
    for set in sets {
        let prefix = match others {
            [] => String::new(),
            _ => format!("set.{}.", set.header.prior),
        };
        graph.begin(&prefix);
        let inputs =
            preprocessing::inputs(&mut graph, "snapshot", &set.header.input, channels, &prefix)?;
        let answer = networks::probabilities(&mut graph, &inputs, &set.weights, &prefix);
        let name = match others {
            [] => "probability".to_string(),
            _ => format!("probability.{}", set.header.prior),
        };
        graph.named(&answer, &name);
        let doc = format!(
            "P(f_i = 1 | snapshot) of {} features for uncertainty {}",
            set.features(),
            set.header.prior
        );
        let shape = [Length::Named("batch"), Length::Fixed(set.features())];
        graph.output(&name, false, &shape, doc);
    }
    add_map(&mut graph, bank);
    let header = match sets {
        [one] => json!(one.header),
        all => all.iter().map(|set| json!(set.header)).collect(),
    };
    Ok(ModelProto {
        ir_version: IR_VERSION,
        producer_name: "ballmark".into(),
        producer_version: env!("CARGO_PKG_VERSION").into(),
        doc_string: what(sets),
        graph: Some(graph.finish()),
        opset_import: vec![OperatorSetIdProto {
            domain: String::new(),
            version: OPERATORS,
        }],
        metadata_props: vec![
            entry("ballmark", header.to_string()),
            entry("channels", json!(channels).to_string()),
        ],
    })
}

/// The training places, what the networks answered there, and the occupancy map that they are rendered from, as outputs without inputs.
fn add_map(graph: &mut Graph, bank: &ModelBank) {
    graph.begin("");
    let sets = bank.sets();
    let Some(first) = sets.first() else {
        return;
    };
    let k = first.pose.len();
    let poses = first
        .pose
        .iter()
        .flat_map(|p| [p.x_m, p.y_m, p.heading_rad]);
    graph.array_f64("map.pose.values", poses, &[k, 3]);
    graph.named("map.pose.values", "map.pose");
    let shape = [Length::Fixed(k), Length::Fixed(3)];
    graph.output(
        "map.pose",
        true,
        &shape,
        "training places: m, m, rad".into(),
    );
    if let Some(route_m) = &first.route_m {
        graph.array_f64("map.route.values", route_m.iter().copied(), &[k]);
        graph.named("map.route.values", "map.route");
        let doc = "their coordinate along the route, m";
        graph.output("map.route", true, &[Length::Fixed(k)], doc.into());
    }
    if sets.len() > 1 {
        let run = bank.run().iter().map(|&run| run as f64);
        graph.array_f64("map.run.values", run, &[k]);
        graph.named("map.run.values", "map.run");
        let doc = "the run that each is of, counted from 0";
        graph.output("map.run", true, &[Length::Fixed(k)], doc.into());
    }
    if let Some(map) = &first.occupancy {
        let ([columns, rows], [x_m, y_m]) = (map.size(), map.origin_m());
        let cells = map
            .cells()
            .iter()
            .map(|&cell| f32::from(occupancy_number(cell)));
        graph.array("map.occupancy.values", cells, &[rows, columns]);
        graph.named("map.occupancy.values", "map.occupancy");
        let doc = "what scans drew: 0 free, 100 occupied, 255 unknown; the southernmost row first, from west to east";
        let shape = [rows, columns].map(Length::Fixed);
        graph.output("map.occupancy", false, &shape, doc.into());
        graph.array_f64("map.occupancy.frame.values", [x_m, y_m, map.cell_m()], &[3]);
        graph.named("map.occupancy.frame.values", "map.occupancy.frame");
        let doc = "x and y of its south-west corner, and the edge of a cell, m";
        graph.output("map.occupancy.frame", true, &[Length::Fixed(3)], doc.into());
    }
    for set in sets {
        let name = match sets.len() {
            1 => "map.activation".to_string(),
            _ => format!("set.{}.map.activation", set.header.prior),
        };
        let values = format!("{name}.values");
        let shape = [k, set.features()];
        graph.array(&values, set.activation.iter().copied(), &shape);
        graph.named(&values, &name);
        let doc = "P(f_i = 1) at the training places";
        graph.output(&name, false, &shape.map(Length::Fixed), doc.into());
    }
}

fn what(sets: &[Model]) -> String {
    let of = |set: &Model| format!("{} for {}", set.features(), set.header.prior);
    let all: Vec<String> = sets.iter().map(of).collect();
    format!(
        "ballmark {}: stochastic binary features learned for localisation (Thrun 1998): {}",
        env!("CARGO_PKG_VERSION"),
        all.join(", ")
    )
}

fn in_words(channels: &[Channel]) -> String {
    let of = |channel: &Channel| format!("{} ({}, {})", channel.name, channel.width, channel.unit);
    channels.iter().map(of).collect::<Vec<_>>().join(", ")
}
