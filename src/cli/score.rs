//! `ballmark score`: judges anyone's responses.

use super::{Outcome, print, warn};
use crate::{
    error::{Error, Result},
    report::{Cell, Table},
    score::{Contingency, Effort, Judgement},
    seed::Seed,
    storage,
};
use serde::Serialize;
use std::{
    collections::HashMap,
    path::{Path, PathBuf},
};

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
    let verdict = Verdict::of(&responses, effort, Seed(arguments.seed));
    verdict
        .notes
        .iter()
        .for_each(|note| warn(&format!("note: {note}")));
    if arguments.json {
        let json = serde_json::to_string_pretty(&verdict)
            .map_err(|e| Error::work(format!("cannot write the result as JSON: {e}")))?;
        print(&(json + "\n"))?;
    } else {
        print(&verdict.tables())?;
    }
    Ok(Outcome::Done)
}

/// The rows of the file, column by column.
struct Responses {
    location: Vec<String>,
    response: Vec<String>,
    trial: Option<Vec<usize>>,
    distance_m: Option<Vec<f64>>,
}

impl Responses {
    fn read(path: &Path) -> Result<Self> {
        let bytes = storage::read_file(path)?;
        let text = std::str::from_utf8(&bytes).map_err(|e| {
            let line = 1 + bytes[..e.valid_up_to()]
                .iter()
                .filter(|&&b| b == b'\n')
                .count();
            Error::input(
                path,
                format!("line {line}"),
                "is not UTF-8; expected CSV text",
            )
        })?;
        let text = text.strip_prefix('\u{feff}').unwrap_or(text);
        if text.trim().is_empty() {
            let fault = "is empty; expected CSV with the columns `response,location`";
            return Err(Error::file(path, fault));
        }
        let mut reader = csv::ReaderBuilder::new()
            .flexible(true)
            .from_reader(text.as_bytes());
        let unreadable = |e: csv::Error| Error::file(path, format!("is not CSV: {e}"));
        let headers = reader.headers().map_err(unreadable)?.clone();
        let wanted = |name: &str| column(path, &headers, name);
        let required = |name: &str| {
            wanted(name)?.ok_or_else(|| {
                let found: Vec<&str> = headers.iter().map(str::trim).collect();
                let fault = format!(
                    "no column `{name}` among {found:?}; expected `response` and `location`"
                );
                Error::input(path, "line 1", fault)
            })
        };
        let (response_at, location_at) = (required("response")?, required("location")?);
        let (trial_at, distance_at) = (wanted("trial")?, wanted("distance_m")?);

        let mut rows = Self {
            location: Vec::new(),
            response: Vec::new(),
            trial: trial_at.map(|_| Vec::new()),
            distance_m: distance_at.map(|_| Vec::new()),
        };
        let mut trials: HashMap<String, usize> = HashMap::new();
        for record in reader.records() {
            let record = record.map_err(unreadable)?;
            let start = record
                .position()
                .map_or(0, |position| position.byte() as usize);
            let wrong =
                |fault: String| Error::input(path, format!("line {}", line_of(text, start)), fault);
            if record.len() != headers.len() {
                let (found, expected) = (record.len(), headers.len());
                return Err(wrong(format!(
                    "{found} fields; expected {expected} as in the header"
                )));
            }
            let label = |at: usize| {
                let (name, label) = (headers[at].trim(), &record[at]);
                if label.contains(['\n', '\r']) {
                    let fault =
                        "goes on over the end of the line; expected a label, its quotes closed";
                    return Err(wrong(format!("column `{name}` {fault}")));
                }
                match label.trim() {
                    "" => Err(wrong(format!(
                        "column `{name}` is empty; expected a label, such as `none` for no answer"
                    ))),
                    label => Ok(label.to_string()),
                }
            };
            rows.location.push(label(location_at)?);
            rows.response.push(label(response_at)?);
            if let (Some(column), Some(at)) = (&mut rows.trial, trial_at) {
                let next = trials.len();
                column.push(*trials.entry(label(at)?).or_insert(next));
            }
            if let (Some(column), Some(at)) = (&mut rows.distance_m, distance_at) {
                let number = record[at]
                    .trim()
                    .parse::<f64>()
                    .ok()
                    .filter(|d| d.is_finite());
                let fault = || {
                    let found = record[at].trim();
                    wrong(format!(
                        "column `distance_m` holds `{found}`; expected metres as a number"
                    ))
                };
                column.push(number.ok_or_else(fault)? + 0.0); // −0 and 0 are one distance
            }
        }
        if rows.location.is_empty() {
            return Err(Error::file(
                path,
                "has a header and no rows; expected at least one",
            ));
        }
        Ok(rows)
    }

    fn table(&self, rows: impl Iterator<Item = usize>) -> Contingency<&str, &str> {
        let mut table = Contingency::new();
        rows.for_each(|k| table.record(self.location[k].as_str(), self.response[k].as_str()));
        table
    }
}

/// The line of the record that starts at this byte or after the blank lines there, which the reader passes over.
fn line_of(text: &str, start: usize) -> usize {
    let bytes = text.as_bytes();
    let breaks = |b: &&u8| matches!(b, b'\n' | b'\r');
    let blank = bytes[start..].iter().take_while(breaks).count();
    1 + bytes[..start + blank]
        .iter()
        .filter(|&&b| b == b'\n')
        .count()
}

/// Where in the header a column stands; two of one name are a fault.
fn column(path: &Path, headers: &csv::StringRecord, name: &str) -> Result<Option<usize>> {
    let mut places = (0..headers.len()).filter(|&at| headers[at].trim() == name);
    let first = places.next();
    match places.next() {
        None => Ok(first),
        Some(_) => {
            let fault = format!("two columns `{name}`; expected one");
            Err(Error::input(path, "line 1", fault))
        }
    }
}

/// All that the command says; serialised, its fields are the JSON keys.
#[derive(Serialize)]
struct Verdict {
    #[serde(flatten)]
    overall: Judgement,
    /// What `ci95` is an interval of, and what was drawn for it.
    ci95_of: &'static str,
    ci95_over: &'static str,
    trials: Option<usize>,
    logarithm: &'static str,
    permutations: u64,
    bootstrap: u64,
    seed: u64,
    #[serde(skip_serializing_if = "Option::is_none")]
    by_distance: Option<Vec<AtDistance>>,
    notes: Vec<String>,
}

/// The table of one distance travelled (Duckett & Nehmzow 1998, 6.5).
#[derive(Serialize)]
struct AtDistance {
    distance_m: f64,
    #[serde(flatten)]
    judgement: Judgement,
}

impl Verdict {
    fn of(responses: &Responses, effort: Effort, seed: Seed) -> Self {
        let rows: Vec<usize> = (0..responses.location.len()).collect();
        let unit_of = responses.trial.as_ref().unwrap_or(&rows);
        let overall = Judgement::of(
            &responses.table(rows.iter().copied()),
            unit_of,
            effort,
            seed,
        );
        let by_distance = responses.distance_m.as_ref().map(|distance_m| {
            let mut order = rows.clone();
            order.sort_by(|&a, &b| distance_m[a].total_cmp(&distance_m[b]));
            let same = |a: &usize, b: &usize| distance_m[*a] == distance_m[*b];
            let at = |rows: &[usize]| {
                let units: Vec<usize> = rows.iter().map(|&k| unit_of[k]).collect();
                AtDistance {
                    distance_m: distance_m[rows[0]],
                    judgement: Judgement::of(
                        &responses.table(rows.iter().copied()),
                        &units,
                        effort,
                        seed,
                    ),
                }
            };
            order.chunk_by(same).map(at).collect::<Vec<_>>()
        });
        let trials = responses
            .trial
            .as_ref()
            .map(|t| t.iter().max().map_or(0, |last| last + 1));
        let mut verdict = Self {
            overall,
            ci95_of: "uncertainty_coefficient_corrected",
            ci95_over: if trials.is_some() { "trials" } else { "rows" },
            trials,
            logarithm: "natural",
            permutations: effort.permutations,
            bootstrap: effort.resamples,
            seed: seed.0,
            by_distance,
            notes: Vec::new(),
        };
        verdict.notes = verdict.what_to_note();
        verdict
    }

    /// Why a value is missing, and what a reader may take wrongly.
    fn what_to_note(&self) -> Vec<String> {
        let mut notes = Vec::new();
        let overall = &self.overall;
        if overall.uncertainty_coefficient.is_none() {
            notes.push(
                "all rows have one location: H(L) = 0, so the uncertainty coefficient is undefined"
                    .into(),
            );
        } else if overall.uncertainty_coefficient_corrected.is_none() {
            notes.push("pairing locations and responses at random tells as much in every way: no corrected coefficient".into());
        } else if overall.ci95.is_none() && self.bootstrap > 0 {
            notes.push(match self.trials {
                Some(1) => "one trial only: no interval over trials".into(),
                _ => "too few resamples have a coefficient: no interval".into(),
            });
        }
        if let Some(rows) = &self.by_distance {
            let single = rows.iter().filter(|row| row.judgement.n == 1).count();
            if single > 0 {
                let of = rows.len();
                notes.push(format!("{single} of {of} distances hold a single row; round `distance_m` to bins, such as 0.1 m"));
            }
            if self.trials.is_none() {
                notes.push("`distance_m` without `trial`: the interval takes rows of one trial for independent and is too narrow".into());
            }
        }
        notes
    }

    fn tables(&self) -> String {
        let overall = &self.overall;
        let mut table = Table::new(["quantity", "value"]);
        let mut row = |name: &str, cell| table.row([Cell::Text(name.into()), cell]);
        row("n", Cell::Count(overall.n as u64));
        row("locations", Cell::Count(overall.locations as u64));
        row("responses", Cell::Count(overall.responses as u64));
        row(
            "entropy_of_location H(L) (nats)",
            Cell::Number(overall.entropy_of_location, 6),
        );
        row(
            "entropy_of_location_given_response H(L|R) (nats)",
            Cell::Number(overall.entropy_of_location_given_response, 6),
        );
        row(
            "uncertainty_coefficient U(L|R)",
            Cell::number(overall.uncertainty_coefficient, 6),
        );
        row(
            "uncertainty_coefficient_corrected",
            Cell::number(overall.uncertainty_coefficient_corrected, 6),
        );
        row("permutation_p", Cell::number(overall.permutation_p, 6));
        row(
            "ci95 low (of the corrected, bootstrap)",
            Cell::number(overall.ci95.map(|c| c[0]), 6),
        );
        row("ci95 high", Cell::number(overall.ci95.map(|c| c[1]), 6));
        let over = self.ci95_over;
        table.caption(format!(
            "natural logarithm; {} permutations, {} bootstrap resamples over {over}, seed {}",
            self.permutations, self.bootstrap, self.seed
        ));
        self.notes
            .iter()
            .for_each(|note| table.caption(format!("note: {note}")));
        let mut text = table.text();
        if let Some(rows) = &self.by_distance {
            let mut table = Table::new([
                "distance (m)",
                "n",
                "H(L|R) (nats)",
                "U(L|R)",
                "corrected",
                "ci95 low",
                "ci95 high",
                "p",
            ]);
            for AtDistance {
                distance_m,
                judgement,
            } in rows
            {
                table.row([
                    Cell::Number(*distance_m, 3),
                    Cell::Count(judgement.n as u64),
                    Cell::Number(judgement.entropy_of_location_given_response, 4),
                    Cell::number(judgement.uncertainty_coefficient, 4),
                    Cell::number(judgement.uncertainty_coefficient_corrected, 4),
                    Cell::number(judgement.ci95.map(|c| c[0]), 4),
                    Cell::number(judgement.ci95.map(|c| c[1]), 4),
                    Cell::number(judgement.permutation_p, 4),
                ]);
            }
            text.push('\n');
            text.push_str(&table.text());
        }
        text
    }
}
