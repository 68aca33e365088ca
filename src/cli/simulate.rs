//! `ballmark simulate`: a simulated building and robot become a dataset.

use super::{Outcome, print};
use crate::{
    error::{Error, Result},
    recording::{Recording, npz},
    seed::Seed,
    storage,
    world::{
        Building,
        simulation::{Choice, simulate_building},
    },
};
use serde_json::{Value, json};
use std::{fmt::Write, path::PathBuf};

/// Simulate a robot in a building and record what its sensors say.
///
/// A world is one TOML: walls, doors, windows, lamps, a robot, its sensors, its way, and who walks about.
#[derive(Debug, clap::Args)]
#[command(after_long_help = HELP)]
pub struct Arguments {
    /// The world.
    #[arg(value_name = "WORLD.toml")]
    world: PathBuf,

    /// Dataset to write.
    #[arg(short, long, value_name = "D.npz")]
    output: PathBuf,

    /// Seed of everything that differs from run to run.
    #[arg(long, default_value_t = 1)]
    seed: u64,

    /// Only this set of the world's runs; without it all of them, one after another.
    #[arg(long, value_name = "NAME")]
    set: Option<String>,

    /// This number of runs of each set, instead of the world's.
    #[arg(long, value_name = "N")]
    runs: Option<usize>,

    /// Print the summary as one JSON object.
    #[arg(long)]
    json: bool,
}

const HELP: &str = "\
Example:
  printf 'name = \"hall\"\\n[[wall]]\\npoints = [[0,0],[9,0],[9,4],[0,4]]\\nclosed = true\\n[sonar]\\n[path]\\n\
corners = [[1,2],[8,2]]\\n[record]\\nevery_m = 0.5\\n' > hall.toml
  ballmark simulate hall.toml -o hall.npz";

pub fn run(arguments: Arguments) -> Result<Outcome> {
    storage::check_target(&arguments.output)?;
    let world = Building::read(&arguments.world)?;
    let choice = Choice {
        set: arguments.set.clone(),
        runs: arguments.runs,
    };
    let in_world = |fault: Error| fault.in_file(&arguments.world);
    let recording = simulate_building(&world, Seed(arguments.seed), &choice).map_err(in_world)?;
    npz::write(&arguments.output, &recording)?;
    if arguments.json {
        print(&format!("{}\n", summary(&world, &recording, &arguments)))?;
    } else {
        print(&table(&world, &recording, &arguments))?;
    }
    Ok(Outcome::Done)
}

fn path_m(recording: &Recording) -> f64 {
    let travelled_m = recording.travelled_m();
    let ends = recording.runs().into_iter().map(|run| run.end - 1);
    // Added to 0, not -0 which an empty sum of floats starts from.
    ends.fold(0.0, |sum, end| sum + travelled_m[end])
}

fn summary(world: &Building, recording: &Recording, arguments: &Arguments) -> Value {
    let channels = recording.channels().iter();
    let channels = channels.map(
        |c| json!({ "name": c.name, "values": c.width, "unit": c.unit, "maximum": c.maximum }),
    );
    json!({
        "output": arguments.output.display().to_string(),
        "world": world.name(),
        "seed": arguments.seed,
        "set": arguments.set,
        "snapshots": recording.len(),
        "runs": recording.runs().len(),
        "path_m": path_m(recording),
        "channels": channels.collect::<Vec<_>>(),
    })
}

fn table(world: &Building, recording: &Recording, arguments: &Arguments) -> String {
    let mut out = String::new();
    let mut row = |name: &str, value: String| {
        let _ = writeln!(out, "{name:<12} {value}"); // writing to a String can't fail
    };
    row("dataset", arguments.output.display().to_string());
    row("world", world.name().to_string());
    row("snapshots", recording.len().to_string());
    row("runs", recording.runs().len().to_string());
    row("path", format!("{:.1} m", path_m(recording)));
    for channel in recording.channels() {
        row(
            "channel",
            format!(
                "{}: {} values in {}",
                channel.name, channel.width, channel.unit
            ),
        );
    }
    out
}
