//! Responses of any system from a CSV file: what it answered, where it was, and in which trial.

use super::contingency::Contingency;
use crate::{
    error::{Error, Result},
    storage,
};
use std::{collections::HashMap, io::Read, path::Path};

/// Responses and the locations they were given at, row by row.
///
/// The file has a header with the columns `response` and `location`: labels of any kind, spaces around them don't count.
/// Optional columns: `trial`, a label that rows of one trial share, and `distance_m`, a number. Other columns are passed
/// over.
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
        let path = path.as_ref();
        Self::from_bytes(path, &storage::read_file(path)?)
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
        Self::from_bytes(name.as_ref(), &bytes)
    }

    fn from_bytes(path: &Path, bytes: &[u8]) -> Result<Self> {
        let text = std::str::from_utf8(bytes).map_err(|e| {
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
        let optional = |name: &str| column(path, &headers, name);
        let required = |name: &str| {
            optional(name)?.ok_or_else(|| {
                let found: Vec<&str> = headers.iter().map(str::trim).collect();
                let fault = format!(
                    "no column `{name}` among {found:?}; expected `response` and `location`"
                );
                Error::input(path, "line 1", fault)
            })
        };
        let (response_at, location_at) = (required("response")?, required("location")?);
        let (trial_at, distance_at) = (optional("trial")?, optional("distance_m")?);

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
