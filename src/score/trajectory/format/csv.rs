//! A table of poses with a header.

use super::{Rows, lines, tum};
use crate::{
    delimited::separator,
    error::{Error, Result},
    geometry::Pose,
    score::trajectory::Pose3,
};
use ::csv::{ReaderBuilder, StringRecord, Trim};
use std::path::Path;

/// Names of a column, the first of which is the documented one.
const TIME: &[&str] = &["time_s", "stamp", "stamp_s", "timestamp", "time", "t"];
const X: &[&str] = &["x_m", "x"];
const Y: &[&str] = &["y_m", "y"];
const Z: &[&str] = &["z_m", "z"];
const RADIANS: &[&str] = &["heading_rad", "heading", "yaw_rad", "yaw", "theta"];
const DEGREES: &[&str] = &["heading_deg", "yaw_deg", "theta_deg"];
const QUATERNION: [&[&str]; 4] = [&["qx"], &["qy"], &["qz"], &["qw"]];

/// A heading above this in a column of radians is one in degrees, …
const MOST_RADIANS: f64 = 50.0;
/// … and above this where the column's name has no unit: a little more than a whole turn.
const MOST_WITHOUT_UNIT: f64 = 6.5;

/// Where the orientation stands.
enum Orientation {
    Quaternion([usize; 4]),
    Radians(usize),
    Degrees(usize),
}

struct Columns {
    time: Option<usize>,
    place: [usize; 2],
    height: Option<usize>,
    orientation: Orientation,
}

pub(super) fn read(path: &Path, text: &str) -> Result<Rows> {
    let header = lines::content(text).next().map_or("", |(_, line)| line);
    let mut reader = ReaderBuilder::new()
        .flexible(true)
        .trim(Trim::All)
        .comment(Some(b'#'))
        .delimiter(separator(header.as_bytes()))
        .from_reader(text.as_bytes());
    let unreadable = |e: ::csv::Error| Error::file(path, format!("is not CSV: {e}"));
    let headers = reader.headers().map_err(unreadable)?.clone();
    let header_line = headers.position().map_or(1, ::csv::Position::line);
    let columns = Columns::of(&headers)
        .map_err(|fault| Error::input(path, format!("line {header_line}"), fault))?;
    let (mut line, mut pose) = (Vec::new(), Vec::new());
    let mut stamp_s = columns.time.map(|_| Vec::new());
    let mut record = StringRecord::new();
    while reader.read_record(&mut record).map_err(unreadable)? {
        let number = record.position().map_or(0, ::csv::Position::line);
        let wrong = |fault: String| Error::input(path, format!("line {number}"), fault);
        if record.len() != headers.len() {
            return Err(wrong(format!(
                "{} cells; expected {} as in the header",
                record.len(),
                headers.len()
            )));
        }
        let cell = |at: usize| lines::number(&record[at], &headers[at]);
        pose.push(columns.pose(&headers, cell).map_err(wrong)?);
        if let (Some(stamps), Some(at)) = (&mut stamp_s, columns.time) {
            stamps.push(cell(at).map_err(wrong)?);
        }
        line.push(number);
    }
    Ok(Rows {
        line,
        stamp_s,
        pose,
    })
}

fn most_radians(name: &str) -> f64 {
    match name.ends_with("_rad") {
        true => MOST_RADIANS,
        false => MOST_WITHOUT_UNIT,
    }
}

impl Columns {
    fn of(headers: &StringRecord) -> std::result::Result<Self, String> {
        let find = |names: &[&str]| -> std::result::Result<Option<usize>, String> {
            let mut found = (0..headers.len()).filter(|&at| names.contains(&&headers[at]));
            let first = found.next();
            match (first, found.next()) {
                (Some(first), Some(second)) => Err(format!(
                    "columns `{}` and `{}`; expected one of them",
                    &headers[first], &headers[second]
                )),
                _ => Ok(first),
            }
        };
        let need = |names: &[&str]| {
            find(names)?.ok_or_else(|| {
                let found: Vec<&str> = headers.iter().take(12).collect();
                format!(
                    "no column `{}` among `{}`; expected x_m, y_m and heading_rad, or qx, qy, qz, qw",
                    names[0],
                    found.iter().map(|name| lines::shown(name)).collect::<Vec<_>>().join("`, `")
                )
            })
        };
        let quaternion = QUATERNION.map(find);
        if let Some(Err(twice)) = quaternion.iter().find(|at| at.is_err()) {
            return Err(twice.clone());
        }
        let some = quaternion
            .iter()
            .filter(|at| matches!(at, Ok(Some(_))))
            .count();
        let orientation = match (some, find(RADIANS)?, find(DEGREES)?) {
            (4, ..) => Orientation::Quaternion([
                need(QUATERNION[0])?,
                need(QUATERNION[1])?,
                need(QUATERNION[2])?,
                need(QUATERNION[3])?,
            ]),
            (1..4, ..) => return Err("some of qx, qy, qz, qw; expected all four or none".into()),
            (_, Some(_), Some(_)) => {
                return Err("a heading in radians and one in degrees; expected one of them".into());
            }
            (_, None, Some(at)) => Orientation::Degrees(at),
            (_, radians, None) => Orientation::Radians(radians.map_or_else(|| need(RADIANS), Ok)?),
        };
        Ok(Self {
            time: find(TIME)?,
            place: [need(X)?, need(Y)?],
            height: find(Z)?,
            orientation,
        })
    }

    fn pose(
        &self,
        headers: &StringRecord,
        cell: impl Fn(usize) -> std::result::Result<f64, String>,
    ) -> std::result::Result<Pose3, String> {
        let [x, y] = [cell(self.place[0])?, cell(self.place[1])?];
        let z = self.height.map_or(Ok(0.0), &cell)?;
        let heading_rad = match &self.orientation {
            Orientation::Quaternion([qx, qy, qz, qw]) => {
                return tum::pose([x, y, z], [cell(*qx)?, cell(*qy)?, cell(*qz)?, cell(*qw)?]);
            }
            Orientation::Radians(at) => match cell(*at)? {
                heading if heading.abs() > most_radians(&headers[*at]) => {
                    return Err(format!(
                        "`{}` holds {heading}; expected radians (call it `heading_deg` or `heading_rad`)",
                        &headers[*at]
                    ));
                }
                heading => heading,
            },
            Orientation::Degrees(at) => cell(*at)?.to_radians(),
        };
        Ok(Pose3 {
            position_m: tum::position([x, y, z])?,
            ..Pose3::from_plane(&Pose::new(x, y, heading_rad))
        })
    }
}
