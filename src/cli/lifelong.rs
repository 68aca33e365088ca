//! `ballmark lifelong`: days of a simulated corridor that changes, and robots that learn on in it.

use super::{
    Outcome,
    files::{make_writable, write_text},
    picture::write_picture,
    print,
    progress::Progress,
};
use crate::{
    error::{Error, Result},
    experiment::{
        configuration::Experiment,
        lifelong::{self, LifelongRecord},
    },
    report::lifelong as tables,
};
use std::{
    path::{Path, PathBuf},
    time::Instant,
};

/// See what learning on is worth where a building changes from day to day.
///
/// In Thrun's corridor doors, bins and lamps change from night to night and daylight from day to day. A model is trained on the first
/// day. On each later day robots are judged with what they knew the evening before, and then learn from that day's runs: by labels of
/// their own that pass a gate (`ballmark adapt`), without a gate, by true labels, with the map alone, or not at all; a rival without
/// learning keeps raw snapshots. In a second world nothing changes. Figures are means over seeds, held against the model of the
/// first day in the same trials.
#[derive(Debug, clap::Args)]
#[command(after_help = "Example:
  ballmark lifelong configs/lifelong-thrun1998.toml --toy")]
pub struct Arguments {
    /// Configuration: its sections [lifelong], [train] and [adapt].
    #[arg(value_name = "C.toml")]
    config: PathBuf,
    /// Folder for the record (JSON), the days (CSV) and their picture (SVG, PNG).
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// The first seed.
    #[arg(long, value_name = "N")]
    seed: Option<u64>,
    /// Number of seeds.
    #[arg(long, value_name = "N")]
    seeds: Option<usize>,
    /// Two seeds, three days, few trials and steps: does it work here? The figures mean little.
    #[arg(long, visible_alias = "quick")]
    toy: bool,
    /// One JSON object, the whole record, instead of tables.
    #[arg(long)]
    json: bool,
}

/// Steps of a training at toy size.
const TOY_STEPS: usize = 10;

pub fn run(arguments: Arguments) -> Result<Outcome> {
    let Experiment {
        mut train,
        mut adapt,
        lifelong: mut config,
        ..
    } = Experiment::read(Some(&arguments.config), None)?;
    if arguments.toy {
        config = config.toy();
        train.descent.steps = train.descent.steps.min(TOY_STEPS);
        adapt.update.steps = adapt.update.steps.min(TOY_STEPS);
    }
    config.seed = arguments.seed.unwrap_or(config.seed);
    config.seeds = arguments.seeds.unwrap_or(config.seeds);
    config.check()?;
    let out = arguments.out.as_deref();
    if let Some(folder) = out {
        make_writable(folder)?;
    }
    let started = Instant::now();
    let mut progress: Option<Progress> = None;
    let record = lifelong::lifelong(&config, &train, &adapt, &mut |at| {
        let bar = progress.get_or_insert_with(|| Progress::new("learning on", at.all));
        bar.at(at.done, "robots' days");
    });
    if let Some(bar) = progress {
        bar.done();
    }
    let record = record?;
    let seconds = started.elapsed().as_secs_f64();
    if let Some(folder) = out {
        write(folder, &record)?;
    }
    if arguments.json {
        let mut value = json(&record)?;
        value["timing"] = serde_json::json!({ "seconds": seconds });
        print(&format!("{value}\n"))?;
        return Ok(Outcome::Done);
    }
    let texts = tables::tables(&record)
        .into_iter()
        .map(|table| table.text());
    print(&texts.collect::<Vec<_>>().join("\n"))?;
    print(&format!("{seconds:.0} s\n"))?;
    Ok(Outcome::Done)
}

fn json(record: &LifelongRecord) -> Result<serde_json::Value> {
    serde_json::to_value(record).map_err(|e| Error::work(format!("result: {e}")))
}

fn write(folder: &Path, record: &LifelongRecord) -> Result<()> {
    write_text(
        &folder.join("lifelong.json"),
        &format!("{:#}\n", json(record)?),
    )?;
    write_text(&folder.join("days.csv"), &tables::days(record).csv())?;
    write_picture(&folder.join("days"), &tables::plot(record)?)
}
