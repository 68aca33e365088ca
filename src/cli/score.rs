//! `ballmark score`: judges anyone's responses.

use super::{
    Outcome,
    files::{make_writable, write_json, write_text},
    page::{CONFIG, call, write_page},
    picture::write_picture,
    print,
    progress::PatientProgress,
    sheets::write_sheets,
    warn,
};
use crate::{
    error::{Error, Result},
    experiment::protocol_record::ProtocolRecord,
    report::{
        Page, Part, Table,
        comparison::{Reader, Sheet},
        contingency_plot, verdict_in_words, verdict_tables,
    },
    score::{ColumnNames, Effort, Responses, Verdict},
    seed::Seed,
};
use serde::Serialize;
use std::path::{Path, PathBuf};

/// Judge responses: how much do they tell about the true location?
///
/// The CSV file has a header with the columns `response` and `location`: labels of any kind, spaces around them don't
/// count. Optional columns: `trial`, over which the interval is then drawn, and `distance_m`, which adds a table of
/// the coefficient at each distance. Other columns are passed over; columns of other names are named by options. Cells are
/// separated by commas, semicolons or tabs; UTF-16 and decimal commas are read.
///
/// The uncertainty coefficient U(L|R) (Duckett & Nehmzow 1998) is the share of the location's entropy that the response
/// removes: at 1 the response determines the location, at 0 it says nothing about it. Small samples raise it by chance; the
/// corrected one is 0 on average for responses that are independent of the location. The interval is that of the corrected coefficient. Natural logarithms.
#[derive(Debug, clap::Args)]
#[command(after_help = "Example:
  printf 'location,response\\nhall,1\\nhall,1\\ndoor,2\\ndoor,1\\n' > answers.csv
  ballmark score answers.csv")]
pub struct Arguments {
    /// Responses: CSV with the columns `response,location`, optional `trial,distance_m`.
    #[arg(value_name = "R.csv")]
    responses: PathBuf,
    /// Column of what the system answered.
    #[arg(long, value_name = "NAME", default_value = "response")]
    response: String,
    /// Column of where it was.
    #[arg(long, value_name = "NAME", default_value = "location")]
    location: String,
    /// Optional column of the trial that a row belongs to.
    #[arg(long, value_name = "NAME", default_value = "trial")]
    trial: String,
    /// Optional column of the metres travelled.
    #[arg(long, value_name = "NAME", default_value = "distance_m")]
    distance: String,
    /// Folder for a page to look at (index.html), the verdict (JSON), the tables (text, CSV, Markdown, LaTeX), the picture of
    /// responses against locations (SVG, PNG) and the resolved configuration.
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
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
    if let Some(folder) = &arguments.out {
        make_writable(folder)?; // a wrong name fails now
    }
    let names = ColumnNames {
        response: arguments.response,
        location: arguments.location,
        trial: arguments.trial,
        distance_m: arguments.distance,
    };
    let responses = Responses::read_named(&arguments.responses, &names)?;
    let effort = Effort {
        permutations: arguments.permutations,
        resamples: arguments.bootstrap,
    };
    let progress = PatientProgress::new("score");
    let seed = Seed(arguments.seed);
    let verdict = Verdict::watched(&responses, effort, seed, &|done, of| {
        progress.at(done, of, "random tables");
    });
    progress.done();
    verdict
        .notes
        .iter()
        .for_each(|note| warn(&format!("note: {note}")));
    let record = Record {
        verdict: &verdict,
        protocol: ProtocolRecord::of_responses(&responses),
    };
    if let Some(folder) = &arguments.out {
        let config = serde_json::json!({
            "crate_version": env!("CARGO_PKG_VERSION"),
            "responses": arguments.responses,
            "columns": names,
            "effort": effort,
            "seed": arguments.seed,
        });
        let config = format!("{config:#}\n");
        write(folder, &arguments.responses, &responses, &record, config)?;
    }
    if arguments.json {
        let json = serde_json::to_string_pretty(&record)
            .map_err(|e| Error::work(format!("cannot write the result as JSON: {e}")))?;
        print(&(json + "\n"))?;
    } else {
        let tables: Vec<String> = verdict_tables(&verdict).iter().map(Table::text).collect();
        print(&tables.join("\n"))?;
    }
    Ok(Outcome::Done)
}

/// What is said of responses, and what another record must share with it to stand beside it.
#[derive(Serialize)]
struct Record<'a> {
    #[serde(flatten)]
    verdict: &'a Verdict,
    protocol: ProtocolRecord,
}

/// Writes everything to a folder.
fn write(
    folder: &Path,
    file: &Path,
    responses: &Responses,
    record: &Record,
    config: String,
) -> Result<()> {
    write_text(&folder.join(CONFIG), &config)?;
    write_json(&folder.join("score.json"), record)?;
    let verdict = record.verdict;
    let name = file.file_name().unwrap_or_default().to_string_lossy();
    let titles = ["All rows", "By metres travelled"];
    let names = ["score", "score-by-distance"];
    let tables = verdict_tables(verdict)
        .into_iter()
        .zip(titles.into_iter().zip(names));
    let sheets: Vec<Sheet> = tables
        .map(|(table, (title, name))| Sheet {
            name: name.into(),
            title: title.into(),
            table,
            reader: Reader::Everyone,
        })
        .collect();
    write_sheets(folder, &sheets, &[])?;
    let svg = contingency_plot(&format!("Responses against locations: {name}"), responses)?;
    write_picture(&folder.join("contingency"), &svg)?;
    let caption = "Where each response was given: a row a location, a column a response; the darker, the larger the share of the \
                   response's answers. Labels beyond the sixty most frequent are left out.";
    let mut parts = vec![Part::picture(
        format!("{caption} {}", verdict_in_words(verdict)),
        format!(
            "Contingency table as a heat map. {}",
            verdict_in_words(verdict)
        ),
        svg,
    )];
    parts.extend(
        sheets
            .into_iter()
            .map(|sheet| Part::table(sheet.title, sheet.table)),
    );
    let content = Page {
        title: format!("What the responses of {name} tell about the place"),
        summary: vec![verdict_in_words(verdict)],
        command: call(),
        parts,
        config: vec![(CONFIG.into(), config)],
    };
    write_page(folder, &content)
}
