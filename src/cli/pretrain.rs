//! `ballmark pretrain`: networks that have seen thousands of simulated buildings, for `train` to begin with.

use super::{Outcome, interrupt::Interrupt, print, progress::Progress};
use crate::{
    error::Result,
    experiment::configuration::Experiment,
    learning::{pretraining::pretrain, trainer::Directive},
    model::Model,
    report::{Cell, Table},
};
use std::{path::PathBuf, time::Instant};

/// Pre-train networks on simulated buildings.
///
/// Each step is on one of many buildings that are drawn at random, seen by a laser scanner or a ring of sonars: offices, rooms,
/// corridors and halls, with doors, furniture, glass and people that change between visits. `ballmark train --from` goes on
/// from what comes out, in the user's own building.
#[derive(Debug, clap::Args)]
#[command(after_help = "Example:
  ballmark pretrain -o trunk.safetensors --features 16 --steps 3")]
pub struct Arguments {
    /// Where the networks go: a name ending in .safetensors or .npz.
    #[arg(short, long, value_name = "T.safetensors")]
    output: PathBuf,
    /// Configuration; its section [pretrain] holds for the buildings, [train] for the networks and their descent.
    #[arg(long, value_name = "C.toml")]
    config: Option<PathBuf>,
    /// Number of filters.
    #[arg(long, value_name = "N")]
    features: Option<usize>,
    /// The one seed of the run.
    #[arg(long, value_name = "N")]
    seed: Option<u64>,
    /// Steps of descent.
    #[arg(long, value_name = "N")]
    steps: Option<usize>,
    /// One JSON object instead of a table.
    #[arg(long)]
    json: bool,
}

/// Filters where nobody says how many: eight bytes a place as bits.
const FEATURES: usize = 64;

pub fn run(arguments: Arguments) -> Result<Outcome> {
    let experiment = Experiment::read(arguments.config.as_deref(), None)?;
    let mut recipe = experiment.train;
    if arguments.config.is_none() {
        recipe.features = FEATURES;
    }
    recipe.features = arguments.features.unwrap_or(recipe.features);
    recipe.seed = arguments.seed.unwrap_or(recipe.seed);
    recipe.descent.steps = arguments.steps.unwrap_or(recipe.descent.steps);
    recipe.check()?;
    Model::check_name(&arguments.output)?;
    let started = Instant::now();
    let interrupt = Interrupt::watched();
    let mut progress = Progress::new("learning", recipe.descent.steps);
    let pretrained = pretrain(&experiment.pretrain, &recipe, &mut |p| {
        let held_out = p.held_out.map_or(String::new(), |reduction| {
            format!("unseen buildings {:.1} %", 100.0 * reduction)
        });
        progress.at(p.step, &format!("{} buildings, {held_out}", p.buildings));
        match interrupt.is_set() {
            true => Directive::Cancel,
            false => Directive::Continue,
        }
    });
    progress.done();
    let pretrained = pretrained?;
    let (buildings, held_out) = (pretrained.buildings, pretrained.held_out);
    let model = Model::of_pretrained(&recipe, pretrained)?;
    model.write(&arguments.output)?;
    let seconds = started.elapsed().as_secs_f64();
    if arguments.json {
        let value = serde_json::json!({
            "buildings": buildings,
            "held_out_error_reduction": held_out,
            "recipe": recipe,
            "pretrain": experiment.pretrain,
            "timing": { "seconds": seconds },
        });
        print(&format!("{value}\n"))?;
        return Ok(Outcome::Done);
    }
    let mut table = Table::new(["buildings drawn", "kept apart", "error reduction there (%)"]);
    table.row([
        Cell::Count(buildings as u64),
        Cell::Count(experiment.pretrain.held_out as u64),
        Cell::number(Some(100.0 * held_out), 1),
    ]);
    table.caption(format!(
        "{} filters, seed {}; {} steps, {seconds:.0} s",
        recipe.features, recipe.seed, recipe.descent.steps
    ));
    table.caption(
        "error reduction: share of the prior error that one later snapshot removes with no idea where",
    );
    table.caption(format!("networks: {}", arguments.output.display()));
    print(&table.text())?;
    Ok(Outcome::Done)
}
