//! `ballmark score`: judges anyone's responses.

use super::{Outcome, print, warn};
use crate::{
    error::{Error, Result},
    report::{Table, verdict_tables},
    score::{Effort, Responses, Verdict},
    seed::Seed,
};
use std::path::PathBuf;

/// Judge responses: how much do they tell about the true location?
///
/// The CSV file has a header with the columns `response` and `location`: labels of any kind, spaces around them don't
/// count. Optional columns: `trial`, over which the interval is then drawn, and `distance_m`, which adds a table of
/// the coefficient at each distance. Other columns are passed over.
///
/// The uncertainty coefficient U(L|R) (Duckett & Nehmzow 1998) is the share of the location's entropy that the response
/// removes: 1 tells all, 0 nothing. Small samples flatter it; the corrected one is 0 on average for a response that
/// knows nothing. The interval is that of the corrected coefficient. Natural logarithms.
#[derive(Debug, clap::Args)]
#[command(after_help = "Example:
  printf 'location,response\\nhall,1\\nhall,1\\ndoor,2\\ndoor,1\\n' > answers.csv
  ballmark score answers.csv")]
pub struct Arguments {
    /// Responses: CSV with the columns `response,location`, optional `trial,distance_m`.
    #[arg(value_name = "R.csv")]
    responses: PathBuf,
    /// One JSON object instead of tables.
    #[arg(long)]
    json: bool,
    /// Seed of permutations and resamples.
    #[arg(long, value_name = "N", default_value_t = 0)]
    seed: u64,
    /// Permutations for the p-value; 0: none.
    #[arg(long, value_name = "N", default_value_t = Effort::default().permutations,
          value_parser = clap::value_parser!(u64).range(..=1_000_000))]
    permutations: u64,
    /// Bootstrap resamples for the interval; 0: none.
    #[arg(long, value_name = "N", default_value_t = Effort::default().resamples,
          value_parser = clap::value_parser!(u64).range(..=1_000_000))]
    bootstrap: u64,
}

pub fn run(arguments: Arguments) -> Result<Outcome> {
    let responses = Responses::read(&arguments.responses)?;
    let effort = Effort {
        permutations: arguments.permutations,
        resamples: arguments.bootstrap,
    };
    let verdict = Verdict::new(&responses, effort, Seed(arguments.seed));
    verdict
        .notes
        .iter()
        .for_each(|note| warn(&format!("note: {note}")));
    if arguments.json {
        let json = serde_json::to_string_pretty(&verdict)
            .map_err(|e| Error::work(format!("cannot write the result as JSON: {e}")))?;
        print(&(json + "\n"))?;
    } else {
        let tables: Vec<String> = verdict_tables(&verdict).iter().map(Table::text).collect();
        print(&tables.join("\n"))?;
    }
    Ok(Outcome::Done)
}
