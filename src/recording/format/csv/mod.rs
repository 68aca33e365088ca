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
//! `NAME.0`, `NAME.1`, … (or `NAME_0`, `NAME_1`, …) together are one channel `NAME`; a plain name is a channel of one value. An
//! empty cell, `nan` or `inf` says that nothing came back. Channels named `laser`, `rear_laser`, `sonar` or `infrared`, and
//! those whose name ends in `_m`, are in metres; a unit in brackets says otherwise: `light[lux]`, `sonar.0[cm]`.
//! A picture becomes the channel `camera` of 140 values ([`features`](crate::recording::image::features)); an empty cell says that there is
//! none, and a `frame` or `image` column of numbers is a sensor like any other.
//! Values are taken as they stand: no maximum is looked for, since not every sensor measures a range.

mod frames;
mod header;

use crate::{
    error::{Error, Result},
    recording::{
        Columns, Recording,
        import_report::ImportReport,
        imported_log::{ImportedLog, OdometrySource},
        log_options::LogOptions,
        ranges,
    },
};
use ::csv::{ByteRecord, Reader, ReaderBuilder, Trim};
use header::{Header, Row};
use ndarray::Array2;
use std::path::Path;

/// Rows read at a time; pictures of as many are decoded side by side.
const BATCH: usize = 256;

/// Does the first line read like such a header?
pub(super) fn detect(bytes: &[u8]) -> bool {
    let first = bytes.split(|b| *b == b'\n').next().unwrap_or_default();
    let first = String::from_utf8_lossy(first);
    let mut names = first
        .split(',')
        .map(|name| name.trim().trim_matches(['"', '\u{feff}']));
    names.any(|name| matches!(name, "x_m" | "y_m" | "heading_rad" | "time_s"))
}

/// Reads an unpacked table. `path` is for messages only.
///
/// # Errors
/// Where the header lacks a column or has one twice, or no row can be read. A damaged row is no error but an entry in the
/// account.
///
/// ```
/// use ballmark::recording::{format::csv::read, log_options::LogOptions};
/// let table = b"time_s,x_m,y_m,heading_rad,sonar.0,sonar.1,light[lux]\n0.5,1,2,0,3.5,,80\n";
/// let log = read("walk.csv".as_ref(), table, &LogOptions::default())?;
/// let channels = log.recording.channels();
/// assert_eq!((channels[0].width, channels[0].unit.as_str(), channels[1].unit.as_str()), (2, "m", "lux"));
/// assert!(log.recording.values()[[0, 1]].is_nan());
/// # Ok::<(), ballmark::Error>(())
/// ```
pub fn read(path: &Path, bytes: &[u8], options: &LogOptions) -> Result<ImportedLog> {
    let bytes = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
    let mut reader = ReaderBuilder::new()
        .flexible(true)
        .trim(Trim::All)
        .from_reader(bytes);
    let header = reader
        .byte_headers()
        .map_err(|e| Error::input(path, "line 1", e))?;
    let header = Header::parse(header, |column| frames::are_named_in(bytes, column))
        .map_err(|fault| Error::input(path, "line 1", fault))?;
    let mut account = ImportReport::default();
    let mut columns = Columns::default();
    let (mut route_m, mut compass_rad, mut values) = (Vec::new(), Vec::new(), Vec::new());
    loop {
        let mut batch = next_rows(path, &mut reader, &header)?;
        if batch.is_empty() {
            break;
        }
        if header.frame.is_some() {
            frames::add(path, &mut batch);
        }
        for (line, row) in batch {
            match row {
                Err(fault) => account.lost(format!("line {line}: {fault}")),
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
    if let Some(maximum_m) = options.max_range_m {
        ranges::limit_channels_in_metres(&mut columns, maximum_m);
    }
    let odometry = match header.odometry {
        Some(_) => OdometrySource::Stated,
        None => OdometrySource::Poses,
    };
    let recording = Recording::new(columns).map_err(|e| e.in_file(path))?;
    Ok(ImportedLog {
        recording,
        account,
        odometry,
    })
}

/// A row by the number of its line, or what is wrong with it.
type Numbered = (u64, std::result::Result<Row, String>);

/// The next few rows; none at the end.
fn next_rows(path: &Path, reader: &mut Reader<&[u8]>, header: &Header) -> Result<Vec<Numbered>> {
    let mut rows = Vec::new();
    let mut record = ByteRecord::new();
    while rows.len() < BATCH {
        match reader.read_byte_record(&mut record) {
            Ok(true) => {}
            Ok(false) => break,
            Err(e) => return Err(Error::file(path, e)),
        }
        let line = record.position().map_or(0, ::csv::Position::line);
        rows.push((line, header.row(&record)));
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
