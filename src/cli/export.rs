//! `ballmark export`: a model in another container, or as a graph.

use super::{Outcome, print};
use crate::{
    error::{Error, Result},
    model::{Model, ModelBank, onnx},
    storage,
};
use std::path::{Path, PathBuf};

/// Write a model's weights, constants and map for another program.
///
/// Array names and shapes are the same in both containers: filter.{i}.{layer}.weight [out, in], filter.{i}.{layer}.bias
/// [out], input.mean, input.deviation, map.pose [K, 3], map.activation [K, n]. In .npz the header is the array `meta`
/// (UTF-8 JSON), in .safetensors the metadata key `ballmark`. An .onnx file is a graph of operators with all preprocessing inside: from
/// `snapshot` [batch, D], the channels' raw values side by side, to `probability` [batch, n]; the map are outputs that need no input
/// (map.pose, map.activation, map.route). Every command that reads a model reads such a graph, too. Of a bank of filters the arrays of each set stand behind its name:
/// set.2m.filter.0.0.weight; map.pose, map.route and map.run [K], the run of each place, are those of all; the graph has an output a set, probability.2m.
#[derive(Debug, clap::Args)]
#[command(after_help = "Example:
  ballmark export models/corridor-2m.safetensors -o corridor-2m.onnx")]
pub struct Arguments {
    /// Model to export.
    #[arg(value_name = "M.safetensors")]
    model: PathBuf,
    /// File to write; its ending says how: .onnx, .npz or .safetensors.
    #[arg(short, long, value_name = "FILE")]
    output: PathBuf,
}

pub fn run(arguments: Arguments) -> Result<Outcome> {
    let is_graph = is_graph(&arguments.output)?;
    let bank = ModelBank::read(&arguments.model)?;
    match is_graph {
        true => onnx::write(&bank, &arguments.output)?,
        false => bank.write(&arguments.output)?,
    }
    for model in bank.sets() {
        print(&format!(
            "{}: {} filters for uncertainty {}, {} places\n",
            arguments.output.display(),
            model.features(),
            model.header.prior,
            model.pose.len()
        ))?;
    }
    Ok(Outcome::Done)
}

/// Is it to be a graph, by its ending? Asked, as whether it can be made there, before the reading.
fn is_graph(output: &Path) -> Result<bool> {
    match output.extension().and_then(|ending| ending.to_str()) {
        Some("onnx") => storage::check_target(output).map(|_| true),
        Some("safetensors" | "npz") => Model::check_name(output).map(|()| false),
        _ => Err(Error::usage(format!(
            "{}: no such format; expected a name ending in .onnx, .safetensors or .npz",
            output.display()
        ))),
    }
}
