//! A table of answers: poses, poses with covariances, particles, or cells of a grid.

use super::belief::{Belief, Row, Said, together};
use crate::{
    delimited::Delimited,
    error::{Error, Result},
    storage,
};
use std::path::Path;

/// A heading above this in a column of radians is one in degrees.
const MOST_RADIANS: f64 = 50.0;

/// Where the columns of a table stand.
struct Header {
    names: Vec<String>,
    time: usize,
    place: [usize; 2],
    heading: Option<(usize, Angle)>,
    belief: Option<Belief>,
}

#[derive(Clone, Copy)]
enum Angle {
    Radians,
    Degrees,
}

impl Header {
    fn of(names: Vec<String>) -> std::result::Result<Self, String> {
        let find = |aliases: &[&str]| {
            names
                .iter()
                .position(|name| aliases.contains(&name.as_str()))
        };
        let need = |aliases: &[&str]| {
            let found: Vec<String> = names
                .iter()
                .take(12)
                .map(|n| n.escape_debug().to_string())
                .collect();
            find(aliases).ok_or_else(|| {
                format!(
                    "no column `{}` among `{}`; expected time_s, x_m, y_m, and heading_rad, weight, probability or xx_m2, xy_m2, \
                     yy_m2 where there are such",
                    aliases[0],
                    found.join("`, `")
                )
            })
        };
        let covariance = ["xx_m2", "xy_m2", "yy_m2"].map(|name| find(&[name]));
        let belief = match (covariance, find(&["weight"]), find(&["probability"])) {
            ([None, None, None], None, None) => None,
            ([Some(xx), Some(xy), Some(yy)], None, None) => Some(Belief::Covariance([xx, xy, yy])),
            ([None, None, None], Some(at), None) => Some(Belief::Weight(at)),
            ([None, None, None], None, Some(at)) => Some(Belief::Probability(at)),
            ([None, None, None], Some(_), Some(_)) => {
                return Err("columns `weight` and `probability`; expected one of them".into());
            }
            _ => {
                return Err(
                    "expected all of xx_m2, xy_m2 and yy_m2, and then neither weight nor probability"
                        .into(),
                );
            }
        };
        let radians = find(&["heading_rad", "yaw_rad", "heading", "yaw", "theta"]);
        let degrees = find(&["heading_deg", "yaw_deg", "theta_deg"]);
        Ok(Self {
            time: need(&["time_s", "stamp", "stamp_s", "timestamp", "time", "t"])?,
            place: [need(&["x_m", "x"])?, need(&["y_m", "y"])?],
            heading: match (radians, degrees) {
                (Some(_), Some(_)) => {
                    return Err(
                        "a heading in radians and one in degrees; expected one of them".into(),
                    );
                }
                (radians, degrees) => radians
                    .map(|at| (at, Angle::Radians))
                    .or(degrees.map(|at| (at, Angle::Degrees))),
            },
            belief,
            names,
        })
    }
}

/// What a table says, one entry a time.
///
/// # Errors
/// Where the header lacks a column, or a row makes no sense: the message names the line.
pub(super) fn read(file: &Path) -> Result<Vec<Said>> {
    let bytes = storage::read_file(file)?;
    let table = Delimited::new(&bytes);
    let header = Header::of(table.names());
    let header =
        header.map_err(|fault| Error::input(file, format!("line {}", table.line(1)), fault))?;
    let mut reader = table.reader();
    let mut said: Vec<Said> = Vec::new();
    let mut now: Option<(f64, u64, Vec<Row>)> = None;
    for record in reader.records() {
        let record = record.map_err(|e| Error::file(file, format!("is not CSV: {e}")))?;
        let line = table.line(record.position().map_or(0, |position| position.line()));
        let wrong = |fault: String| Error::input(file, format!("line {line}"), fault);
        if record.len() != header.names.len() {
            return Err(wrong(format!(
                "{} cells; expected {} as in the header",
                record.len(),
                header.names.len()
            )));
        }
        let number = |at: usize| match table.number::<f64>(&record[at]) {
            Some(value) if value.is_finite() => Ok(value),
            _ => Err(wrong(format!(
                "`{}` holds `{}`; expected a finite number",
                header.names[at].escape_debug(),
                record[at]
                    .chars()
                    .take(40)
                    .collect::<String>()
                    .escape_debug()
            ))),
        };
        let (time_s, row) = (number(header.time)?, row(&header, number, wrong)?);
        match &mut now {
            Some((at_s, _, rows)) if *at_s == time_s => rows.push(row),
            _ => {
                if let Some((before_s, line, rows)) = now.replace((time_s, line, vec![row])) {
                    if before_s > time_s {
                        return Err(wrong(format!(
                            "time {time_s} s after {before_s} s; expected rising times, rows of one time together"
                        )));
                    }
                    said.push(together(file, header.belief, before_s, line, &rows)?);
                }
            }
        }
    }
    if let Some((time_s, line, rows)) = now {
        said.push(together(file, header.belief, time_s, line, &rows)?);
    }
    Ok(said)
}

fn row(
    header: &Header,
    number: impl Fn(usize) -> Result<f64>,
    wrong: impl Fn(String) -> Error,
) -> Result<Row> {
    let heading_rad = match header.heading {
        None => None,
        Some((at, Angle::Degrees)) => Some(number(at)?.to_radians()),
        Some((at, Angle::Radians)) => match number(at)? {
            heading if heading.abs() > MOST_RADIANS => {
                return Err(wrong(format!(
                    "`{}` holds {heading}; expected radians (call it `heading_deg` where it is degrees)",
                    header.names[at].escape_debug()
                )));
            }
            heading => Some(heading),
        },
    };
    let mut row = Row {
        place: [number(header.place[0])?, number(header.place[1])?],
        heading_rad,
        weight: 1.0,
        covariance: None,
    };
    match header.belief {
        None => {}
        Some(Belief::Covariance(at)) => {
            let [xx, xy, yy] = [number(at[0])?, number(at[1])?, number(at[2])?];
            if !(xx >= 0.0 && yy >= 0.0 && xx * yy - xy * xy >= -1e-9 * (xx * yy).max(1e-12)) {
                return Err(wrong(format!(
                    "covariance {xx}, {xy}, {yy}; expected one that is positive semidefinite"
                )));
            }
            row.covariance = Some([xx, xy, yy]);
        }
        Some(Belief::Weight(at) | Belief::Probability(at)) => {
            row.weight = number(at)?;
            if row.weight < 0.0 {
                return Err(wrong(format!(
                    "`{}` holds {}; expected 0 or more",
                    header.names[at].escape_debug(),
                    row.weight
                )));
            }
        }
    }
    Ok(row)
}
