//! Responses of any system from a CSV file: what it answered, where it was, and in which trial.

use super::contingency::Contingency;
use crate::{
    delimited::Delimited,
    error::{Error, Result},
    storage,
};
use serde::Serialize;
use std::{collections::HashMap, io::Read, path::Path};

/// Letters of a cell or a name that a message quotes.
const SHOWN: usize = 40;
/// Names of columns that a message lists.
const LISTED: usize = 12;

/// What the columns of a table of responses are called.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct ColumnNames {
    /// What the system answered.
    pub response: String,
    /// Where it was.
    pub location: String,
    /// Which trial a row belongs to; an optional column.
    pub trial: String,
    /// Metres travelled since the start of the trial; an optional column.
    pub distance_m: String,
}

impl Default for ColumnNames {
    fn default() -> Self {
        Self {
            response: "response".into(),
            location: "location".into(),
            trial: "trial".into(),
            distance_m: "distance_m".into(),
        }
    }
}

/// Responses and the locations they were given at, row by row.
///
/// The file has a header with the columns `response` and `location`: labels of any kind, spaces around them don't count.
/// Optional columns: `trial`, a label that rows of one trial share, and `distance_m`, a number. Other columns are passed
/// over. Which separator, decimal mark and encoding it has is seen in the header ([`Delimited`]).
///
/// ```
/// use ballmark::score::{Entropies, Responses};
/// let csv = "location,response,trial\nhall,1,a\nhall,1,a\ndoor,2,b\ndoor,1,b\n";
/// let responses = Responses::from_reader("answers.csv", csv.as_bytes())?;
/// assert_eq!(responses.len(), 4);
/// assert_eq!(responses.trial(), Some(&[0, 0, 1, 1][..]));
/// let entropies = Entropies::of(&responses.table().counts());
/// assert!((entropies.uncertainty_coefficient().unwrap() - 0.311278).abs() < 1e-6);
/// # Ok::<(), ballmark::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Responses {
    location: Vec<String>,
    response: Vec<String>,
    trial: Option<Vec<usize>>,
    distance_m: Option<Vec<f64>>,
}

impl Responses {
    /// Reads a file.
    ///
    /// # Errors
    /// Where it can't be read, or as [`Responses::from_reader`].
    pub fn read(path: impl AsRef<Path>) -> Result<Self> {
        Self::read_named(path, &ColumnNames::default())
    }

    /// Reads a file whose columns have other names.
    ///
    /// # Errors
    /// As [`Responses::read`], and where a column that isn't called as usual is missing.
    pub fn read_named(path: impl AsRef<Path>, names: &ColumnNames) -> Result<Self> {
        let path = path.as_ref();
        Self::from_bytes(path, &storage::read_file(path)?, names)
    }

    /// Reads everything that a reader gives; `name` stands for the file in messages.
    ///
    /// # Errors
    /// Where reading fails, or what is read is not UTF-8, has no row, lacks the column `response` or `location` or has one
    /// twice, or a cell is empty or, below `distance_m`, no finite number. The message names the line.
    pub fn from_reader(name: impl AsRef<Path>, mut reader: impl Read) -> Result<Self> {
        let mut bytes = Vec::new();
        let read = reader.read_to_end(&mut bytes);
        read.map_err(|e| Error::io("cannot read", &name, e))?;
        Self::from_bytes(name.as_ref(), &bytes, &ColumnNames::default())
    }

    fn from_bytes(path: &Path, bytes: &[u8], names: &ColumnNames) -> Result<Self> {
        let table = Delimited::new(bytes);
        let bytes = table.text();
        let text = std::str::from_utf8(bytes).map_err(|e| {
            let line = table.line(1) as usize
                + bytes[..e.valid_up_to()]
                    .iter()
                    .filter(|&&b| b == b'\n')
                    .count();
            Error::input(
                path,
                format!("line {line}"),
                "is not UTF-8; expected CSV text",
            )
        })?;
        if text.trim().is_empty() {
            let fault = "is empty; expected CSV with the columns `response,location`";
            return Err(Error::file(path, fault));
        }
        let mut reader = table.reader();
        let unreadable = |e: csv::Error| Error::file(path, format!("is not CSV: {e}"));
        let headers = reader.headers().map_err(unreadable)?.clone();
        let header_line = format!("line {}", table.line(1));
        let find = |name: &str| {
            let found = column(&headers, name);
            found.map_err(|fault| Error::input(path, &header_line, fault))
        };
        let required = |name: &str| {
            find(name)?.ok_or_else(|| {
                let found: Vec<String> = headers.iter().take(LISTED).map(shown).collect();
                let fault = format!(
                    "no column `{}` among {found:?}; expected `{}` and `{}`, or their names by `--response` and `--location`",
                    shown(name), shown(&names.response), shown(&names.location)
                );
                Error::input(path, &header_line, fault)
            })
        };
        // A name that the user gave must be there.
        let optional = |name: &str, usual: &str| match name == usual {
            true => find(name),
            false => required(name).map(Some),
        };
        let (response_at, location_at) = (required(&names.response)?, required(&names.location)?);
        let usual = ColumnNames::default();
        let trial_at = optional(&names.trial, &usual.trial)?;
        let distance_at = optional(&names.distance_m, &usual.distance_m)?;

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
            let wrong = |fault: String| {
                Error::input(
                    path,
                    format!("line {}", table.line(line_of(text, start) as u64)),
                    fault,
                )
            };
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
                let number = table.number::<f64>(&record[at]).filter(|d| d.is_finite());
                let fault = || {
                    wrong(format!(
                        "column `{}` holds `{}`; expected metres as a number",
                        shown(&headers[at]),
                        shown(&record[at])
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

    /// Responses of a program: one a row, with the location that each was given at, and where there are, its trial and the
    /// metres travelled in it.
    ///
    /// # Errors
    /// Where there is no row, columns differ in length, a label is empty, or a distance is not finite.
    ///
    /// ```
    /// use ballmark::score::Responses;
    /// let labels = |all: [&str; 3]| all.map(String::from).to_vec();
    /// let responses = Responses::new(labels(["hall", "hall", "door"]), labels(["1", "1", "2"]), None, None)?;
    /// assert_eq!(responses.len(), 3);
    /// # Ok::<(), ballmark::Error>(())
    /// ```
    pub fn new(
        location: Vec<String>,
        response: Vec<String>,
        trial: Option<Vec<String>>,
        distance_m: Option<Vec<f64>>,
    ) -> Result<Self> {
        let rows = location.len();
        if rows == 0 {
            return Err(Error::usage("no rows; expected at least one"));
        }
        let lengths = [
            ("response", Some(response.len())),
            ("trial", trial.as_ref().map(Vec::len)),
            ("distance_m", distance_m.as_ref().map(Vec::len)),
        ];
        for (name, length) in lengths {
            if let Some(length) = length.filter(|length| *length != rows) {
                return Err(Error::usage(format!(
                    "`{name}`: {length} entries; expected {rows}, one a location"
                )));
            }
        }
        let labels = [
            ("location", Some(&location)),
            ("response", Some(&response)),
            ("trial", trial.as_ref()),
        ];
        for (name, labels) in labels {
            let empty = labels.and_then(|all| all.iter().position(|label| label.trim().is_empty()));
            if let Some(k) = empty {
                return Err(Error::usage(format!(
                    "`{name}`: entry {k} is empty; expected a label, such as `none` for no answer"
                )));
            }
        }
        let far = distance_m.iter().flatten().position(|d| !d.is_finite());
        if let Some(k) = far {
            return Err(Error::usage(format!(
                "`distance_m`: entry {k} is not finite; expected metres"
            )));
        }
        let mut trials: HashMap<String, usize> = HashMap::new();
        let trial = trial.map(|labels| {
            let number = |label: String| {
                let next = trials.len();
                *trials.entry(label).or_insert(next)
            };
            labels.into_iter().map(number).collect()
        });
        Ok(Self {
            location,
            response,
            trial,
            distance_m: distance_m.map(|all| all.into_iter().map(|d| d + 0.0).collect()),
        })
    }

    /// Number of rows; never 0.
    #[allow(clippy::len_without_is_empty)]
    pub fn len(&self) -> usize {
        self.location.len()
    }

    /// True locations, one a row.
    pub fn location(&self) -> &[String] {
        &self.location
    }

    /// Responses, one a row.
    pub fn response(&self) -> &[String] {
        &self.response
    }

    /// The trial of each row, numbered from 0 in the order of first appearance; none without the column.
    pub fn trial(&self) -> Option<&[usize]> {
        self.trial.as_deref()
    }

    /// Metres travelled since the start of the trial, one a row; none without the column.
    pub fn distance_m(&self) -> Option<&[f64]> {
        self.distance_m.as_deref()
    }

    /// The contingency table of all rows.
    pub fn table(&self) -> Contingency<&str, &str> {
        self.table_of(0..self.len())
    }

    /// The contingency table of some rows, in the order given.
    pub(super) fn table_of(&self, rows: impl Iterator<Item = usize>) -> Contingency<&str, &str> {
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

/// A cell or a name as messages quote it.
fn shown(text: &str) -> String {
    let text = text.trim();
    let cut: String = text.chars().take(SHOWN).collect();
    let rest = if cut.len() < text.len() { "…" } else { "" };
    format!("{}{rest}", cut.escape_debug())
}

/// Where in the header a column stands; two of one name are a fault.
fn column(headers: &csv::StringRecord, name: &str) -> std::result::Result<Option<usize>, String> {
    let mut places = (0..headers.len()).filter(|&at| headers[at].trim() == name);
    let first = places.next();
    match places.next() {
        None => Ok(first),
        Some(_) => Err(format!("two columns `{}`; expected one", shown(name))),
    }
}
