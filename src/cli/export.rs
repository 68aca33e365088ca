//! `ballmark export`: a model in another container.

use super::{Outcome, print};
use crate::{
    error::Result,
    model::{Model, ModelBank},
};
use std::path::PathBuf;

/// Write a model's weights, constants and map for another program.
///
/// Array names and shapes are the same in both containers: filter.{i}.{layer}.weight [out, in], filter.{i}.{layer}.bias
/// [out], input.mean, input.deviation, map.pose [K, 3], map.activation [K, n]. In .npz the header is the array `meta`
/// (UTF-8 JSON), in .safetensors the metadata key `ballmark`. Of a bank of filters the arrays of each set stand behind its name:
/// set.2m.filter.0.0.weight; map.pose, map.route and map.run [K], the run of each place, are those of all.
#[derive(Debug, clap::Args)]
#[command(after_help = "Example:
  ballmark export models/corridor-2m.safetensors -o corridor-2m.npz")]
pub struct Arguments {
    /// Model to export.
    #[arg(value_name = "M.safetensors")]
    model: PathBuf,
    /// File to write; its ending says how: .npz or .safetensors.
    #[arg(short, long, value_name = "FILE")]
    output: PathBuf,
}

pub fn run(arguments: Arguments) -> Result<Outcome> {
    Model::check_name(&arguments.output)?;
    let bank = ModelBank::read(&arguments.model)?;
    bank.write(&arguments.output)?;
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
