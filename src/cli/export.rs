//! `ballmark export`: a model in another container.

use super::{Outcome, print};
use crate::{error::Result, model::Model};
use std::path::PathBuf;

/// Write a model's weights, constants and map for another program.
///
/// Array names and shapes are the same in both containers: filter.{i}.{layer}.weight [out, in], filter.{i}.{layer}.bias
/// [out], input.mean, input.deviation, map.pose [K, 3], map.activation [K, n]. In .npz the header is the array `meta`
/// (UTF-8 JSON), in .safetensors the metadata key `ballmark`.
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
    let model = Model::read(&arguments.model)?;
    model.write(&arguments.output)?;
    print(&format!(
        "{}: {} filters for uncertainty {}, {} places\n",
        arguments.output.display(),
        model.features(),
        model.header.prior,
        model.pose.len()
    ))?;
    Ok(Outcome::Done)
}
