//! A table with a header, so that any sensor can be brought: one row a snapshot.
//!
//! | column | meaning |
//! |---|---|
//! | `time_s` (or `stamp`) | seconds |
//! | `x_m`, `y_m`, `heading_rad` | the true place |
//! | `odometry_x_m`, `odometry_y_m`, `odometry_heading_rad` | optional, all three: raw dead-reckoned pose |
//! | `run` | optional: number of the run |
//! | `route_m` | optional: metres along a route |
//! | `compass_rad` | optional: compass heading |
//! | `frame` (or `image`) | optional: name of a PNG or JPEG file, relative to the table's folder |
//! | any other | one sensor value |
//!
//! `NAME.0`, `NAME.1`, … (or `NAME_0`, `NAME[0]`, `NAME0`, `NAME001`, …, from 0 or 1 on) together are one channel `NAME`; a plain name is a
//! channel of one value. An empty cell, `nan` or `inf` says that nothing came back. Channels named `laser`, `rear_laser`, `sonar` or
//! `infrared`, and those whose name ends in `_m`, are in metres; a unit in brackets says otherwise: `light[lux]`, `sonar.0[cm]`, and
//! lengths are made metres. Behind an `@` stands where a value's sensor points, in degrees to the left of ahead, and behind a `+`
//! how far from the robot's middle it sits: `sonar.3[cm @ 67.5 + 0.2m]`.
//! Cells are separated by commas, semicolons or tabs, whichever the header has most of; where it isn't commas, numbers may have a
//! decimal comma ([`Delimited`]). A step of more than [`LogOptions::gap_m`] that odometry doesn't know of begins a new run.
//! A picture becomes the channel `camera` of 140 values ([`features`](crate::recording::image::features)); an empty cell says that there is
//! none, and a `frame` or `image` column of numbers is a sensor like any other.
//! Values are taken as they stand: no maximum is looked for, since not every sensor measures a range.

mod channels;
mod column_name;
mod frames;
mod header;
mod row;

use crate::{
    delimited::Delimited,
    error::{Error, Result},
    recording::{
        Columns, Recording, gaps,
        import_report::ImportReport,
        imported_log::{ImportedLog, OdometrySource},
        log_options::LogOptions,
    },
};
use ::csv::{ByteRecord, Reader};
use header::{Fault, Header};
use ndarray::Array2;
use row::Row;
use std::{
    io::{self, Read},
    path::Path,
};

/// Rows read at a time; pictures of as many are decoded side by side.
const BATCH: usize = 256;

/// Bytes in which the header is looked for.
const HEADER_WITHIN: usize = 1 << 20;

/// Does the first line read like a header: several names, none of them a number?
pub(super) fn detect(bytes: &[u8]) -> bool {
    let table = Delimited::new(&bytes[..bytes.len().min(HEADER_WITHIN)]);
    let names = table.names();
    let is_name = |name: &String| {
        let mut letters = name.chars().filter(|c| !c.is_ascii_digit());
        letters.any(char::is_alphabetic) && !name.chars().any(char::is_control)
    };
    // Row numbers have a column without a name.
    let sensors = match names.split_first() {
        Some((first, rest)) if first.is_empty() => rest,
        _ => &names,
    };
    sensors.len() > 1 && sensors.iter().all(is_name)
}

/// Reads an unpacked table. `path` is for messages only.
///
/// # Errors
/// Where the header lacks a column or has one twice, or no row can be read. A damaged row is no error but an entry in the
/// account.
///
/// ```
/// use ballmark::recording::{format::csv::read, log_options::LogOptions};
/// let table = b"time_s;x_m;y_m;heading_rad;sonar.0;sonar.1;light[lux]\n0,5;1;2;0;3,5;;80\n";
/// let log = read("walk.csv".as_ref(), table, &LogOptions::default())?;
/// let channels = log.recording.channels();
/// assert_eq!((channels[0].width, channels[0].unit.as_str(), channels[1].unit.as_str()), (2, "m", "lux"));
/// assert!(log.recording.values()[[0, 0]] == 3.5 && log.recording.values()[[0, 1]].is_nan());
/// # Ok::<(), ballmark::Error>(())
/// ```
pub fn read(path: &Path, bytes: &[u8], options: &LogOptions) -> Result<ImportedLog> {
    read_lines(path, bytes, &mut io::empty(), options)
}

/// The same of a table whose beginning is at hand and the rest still to be read; only its numbers are held, not its text.
///
/// # Errors
/// As [`read`], and where it can't be read on.
pub(super) fn read_lines(
    path: &Path,
    head: &[u8],
    rest: &mut dyn Read,
    options: &LogOptions,
) -> Result<ImportedLog> {
    let mut all = Vec::new();
    let mut table = Delimited::new(head);
    if table.is_converted() {
        // UTF-16 is converted as a whole.
        all.extend_from_slice(head);
        rest.read_to_end(&mut all)
            .map_err(|e| Error::file(path, e))?;
        table = Delimited::new(&all);
    }
    let mut reader = table.reader_with(rest);
    let line_1 = format!("line {}", table.line(1));
    let names = reader.headers().map_err(|e| match e.kind() {
        ::csv::ErrorKind::Utf8 { .. } => {
            Error::input(path, &line_1, "is not UTF-8; expected CSV text")
        }
        _ => Error::input(path, &line_1, e),
    })?;
    let names: Vec<String> = names.iter().map(String::from).collect();
    let names_files = |column| frames::are_named_in(&table, column);
    let header = Header::parse(&names, options, names_files);
    let header = header.map_err(|fault| match fault {
        Fault::Header(fault) => Error::input(path, &line_1, fault),
        Fault::Selection(fault) => Error::usage(format!("{}: {fault}", path.display())),
    })?;
    let mut account = ImportReport::default();
    let mut columns = Columns::default();
    let (mut route_m, mut compass_rad, mut values) = (Vec::new(), Vec::new(), Vec::new());
    header
        .notes
        .iter()
        .for_each(|note| account.note(note.clone()));
    loop {
        let mut batch = next_rows(path, &table, &mut reader, &header)?;
        if batch.is_empty() {
            break;
        }
        if header.frame.is_some() {
            frames::add(path, &mut batch);
        }
        for Numbered { line, more, row } in batch {
            match row {
                Err(fault) => {
                    account.lost(format!("line {line}: {fault}"));
                    account.lost_with_it(more);
                }
                Ok(row) => {
                    account.used("row");
                    columns.stamp_s.push(row.stamp_s);
                    columns.pose.push(row.pose);
                    columns.odometry.push(row.odometry.unwrap_or(row.pose));
                    columns.run.push(row.run);
                    route_m.extend(row.route_m);
                    compass_rad.extend(row.compass_rad);
                    values.extend(row.values);
                }
            }
        }
    }
    let k = columns.pose.len();
    if k == 0 {
        let first = account
            .lost_records()
            .first()
            .cloned()
            .unwrap_or_else(|| "nothing below the header".into());
        return Err(Error::file(
            path,
            format!("no row that can be read ({first}); expected one a snapshot"),
        ));
    }
    for pair in columns
        .stamp_s
        .windows(2)
        .zip(columns.run.windows(2))
        .filter(|(_, run)| run[0] == run[1])
    {
        match pair.0 {
            [a, b] if b < a => account.warning("row stamped before the one ahead of it"),
            [a, b] if b == a => account.warning("row stamped like the one ahead of it"),
            _ => {}
        }
    }
    columns.route_m = header.route.map(|_| route_m);
    columns.compass_rad = header.compass.map(|_| compass_rad);
    let width = header.channels.iter().map(|channel| channel.width).sum();
    columns.values =
        Array2::from_shape_vec((k, width), values).map_err(|e| Error::file(path, e))?;
    columns.channels = header.channels;
    let odometry = match header.odometry {
        Some(_) => OdometrySource::Stated,
        None => OdometrySource::Poses,
    };
    let odometry_m = &columns.odometry;
    columns.run = gaps::runs(
        &columns.pose,
        odometry_m,
        odometry,
        &columns.run,
        options.gap_or_usual_m(),
        &mut account,
    );
    let recording = Recording::new(columns).map_err(|e| e.in_file(path))?;
    Ok(ImportedLog {
        recording,
        account,
        odometry,
    })
}

/// A row by the number of its line, or what is wrong with it.
struct Numbered {
    line: u64,
    /// Lines that it goes on for, where a quote isn't closed.
    more: usize,
    row: std::result::Result<Row, String>,
}

/// The next few rows; none at the end.
fn next_rows(
    path: &Path,
    table: &Delimited,
    reader: &mut Reader<impl Read>,
    header: &Header,
) -> Result<Vec<Numbered>> {
    let mut rows = Vec::new();
    let mut record = ByteRecord::new();
    while rows.len() < BATCH {
        match reader.read_byte_record(&mut record) {
            Ok(true) => {}
            Ok(false) => break,
            Err(e) => return Err(Error::file(path, e)),
        }
        let line = record.position().map_or(0, ::csv::Position::line);
        let breaks = |cell: &[u8]| cell.iter().filter(|b| **b == b'\n').count();
        let more: usize = record.iter().map(breaks).sum();
        let row = match more {
            0 => Row::read(header, table, &record),
            _ => Err(format!(
                "goes on over {} lines; expected a row a line, its quotes closed",
                more + 1
            )),
        };
        let line = table.line(line);
        rows.push(Numbered { line, more, row });
    }
    Ok(rows)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn table(text: &str) -> Result<ImportedLog> {
        read(Path::new("t.csv"), text.as_bytes(), &LogOptions::default())
    }

    #[test]
    fn columns_find_their_channels_in_any_order() {
        let log = table("s_1,x_m,s_0,y_m,heading_rad,stamp,gas_2,run,route_m,compass_rad\n1,0,0,0,0,5,7,3,2.5,0.1\n").unwrap();
        let c = log.recording.columns();
        let shape: Vec<(&str, usize)> = c
            .channels
            .iter()
            .map(|c| (c.name.as_str(), c.width))
            .collect();
        assert_eq!(shape, [("s", 2), ("gas_2", 1)]);
        assert_eq!(c.values.row(0).to_vec(), [0.0, 1.0, 7.0]);
        assert_eq!(
            (c.run[0], c.route_m.as_deref(), c.compass_rad.as_deref()),
            (3, Some(&[2.5][..]), Some(&[0.1][..]))
        );
        assert_eq!(log.odometry, OdometrySource::Poses);
    }

    #[test]
    fn damaged_rows_are_named_and_the_rest_kept() {
        let log = table("time_s,x_m,y_m,heading_rad,a\n0,0,0,0,1\n1,0,0,0\n2,nan,0,0,1\n3,0,0,0,x\n2,0,0,0,inf\n").unwrap();
        assert_eq!((log.recording.len(), log.account.lost_count()), (2, 3));
        assert!(log.account.lost_records()[0].contains("line 3: 4 cells; expected 5"));
        assert!(log.account.lost_records()[2].contains("line 5: cell 5 holds `x`"));
        assert!(log.recording.values()[[1, 0]].is_nan());
    }

    #[test]
    fn a_wrong_header_is_refused() {
        for (header, part) in [
            ("time_s,x_m,y_m,a", "no column `heading_rad`"),
            ("time_s,x_m,y_m,heading_rad", "no sensor column"),
            ("time_s,x_m,y_m,heading_rad,a,a", "column `a` twice"),
            ("time_s,x_m,y_m,heading_rad,a.0,a.2", "`a.1`"),
            ("time_s,stamp,x_m,y_m,heading_rad,a", "one of them"),
            (
                "time_s,x_m,y_m,heading_rad,odometry_x_m,a",
                "all three or none",
            ),
        ] {
            let error = table(&format!("{header}\n1,2,3,4,5,6\n"))
                .unwrap_err()
                .to_string();
            assert!(
                error.contains("t.csv: line 1") && error.contains(part),
                "{error}"
            );
        }
    }
}
