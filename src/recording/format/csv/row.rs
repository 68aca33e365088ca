//! A row of a table, read by its header.

use super::{column_name::shown, header::Header};
use crate::{delimited::Delimited, geometry::Pose};
use ::csv::ByteRecord;

pub(super) struct Row {
    pub stamp_s: f64,
    pub pose: Pose,
    pub odometry: Option<Pose>,
    pub run: i64,
    pub route_m: Option<f64>,
    pub compass_rad: Option<f64>,
    /// The picture's file name, where there is one.
    pub frame: Option<String>,
    pub values: Vec<f32>,
}

impl Row {
    /// # Errors
    /// Where the row has more or fewer cells than the header, or a cell isn't what its column holds.
    pub fn read(
        header: &Header,
        table: &Delimited,
        record: &ByteRecord,
    ) -> std::result::Result<Self, String> {
        if record.len() != header.width {
            return Err(format!(
                "{} cells; expected {}, one a column",
                record.len(),
                header.width
            ));
        }
        let text = |i: usize| {
            let cell = std::str::from_utf8(&record[i])
                .map_err(|_| format!("cell {} is not UTF-8; expected a number", i + 1));
            cell.map(str::trim)
        };
        let wrong = |i: usize, cell: &str, expected: &str| {
            let cut: String = cell.chars().take(20).collect();
            format!(
                "cell {} holds `{}`; expected {expected}",
                i + 1,
                shown(&cut)
            )
        };
        let number = |i: usize| {
            let cell = text(i)?;
            let value = table.number::<f64>(cell).filter(|v| v.is_finite());
            value.ok_or_else(|| wrong(i, cell, "a finite number"))
        };
        let pose = |at: [usize; 3]| {
            Ok::<_, String>(Pose::new(number(at[0])?, number(at[1])?, number(at[2])?))
        };
        let reading = |i: usize| match text(i)? {
            "" => Ok(f32::NAN),
            cell => match table.number::<f32>(cell) {
                Some(value) if value.is_finite() => Ok(value),
                Some(_) => Ok(f32::NAN),
                None => Err(wrong(
                    i,
                    cell,
                    "a number, or nothing where nothing came back",
                )),
            },
        };
        Ok(Self {
            stamp_s: number(header.stamp)?,
            pose: header.pose.map_or(Ok(Pose::default()), pose)?,
            odometry: header.odometry.map(pose).transpose()?,
            run: match header.run {
                None => 0,
                Some(i) => text(i)?
                    .parse()
                    .map_err(|_| wrong(i, text(i).unwrap_or(""), "a whole number"))?,
            },
            route_m: header.route.map(number).transpose()?,
            compass_rad: header.compass.map(number).transpose()?,
            frame: match header.frame.map(text).transpose()? {
                None | Some("") => None,
                Some(name) => Some(name.to_string()),
            },
            values: header
                .values
                .iter()
                .map(|i| reading(*i))
                .collect::<std::result::Result<_, _>>()?,
        })
    }
}
