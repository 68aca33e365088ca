//! The header of a table: which column is what, and how a row is read by it.

use crate::{
    geometry::Pose,
    recording::{Channel, image},
};
use ::csv::ByteRecord;

/// Channels that are in metres where nothing else is said.
const IN_METRES: [&str; 4] = ["laser", "rear_laser", "sonar", "infrared"];

/// Where each column stands.
pub(super) struct Header {
    pub width: usize,
    pub stamp: usize,
    pub pose: [usize; 3],
    pub odometry: Option<[usize; 3]>,
    pub run: Option<usize>,
    pub route: Option<usize>,
    pub compass: Option<usize>,
    /// Names of picture files; their channel comes last.
    pub frame: Option<usize>,
    pub channels: Vec<Channel>,
    /// Columns of the other channels' values, side by side.
    pub values: Vec<usize>,
}

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

impl Header {
    /// Reads the header; `names_files` says of a column by number whether its cells are names rather than numbers.
    pub fn parse(
        record: &ByteRecord,
        names_files: impl Fn(usize) -> bool,
    ) -> std::result::Result<Self, String> {
        let mut names = Vec::new();
        for name in record {
            let name = std::str::from_utf8(name)
                .map_err(|_| "a column name that is not UTF-8; expected text")?;
            if name.is_empty() {
                return Err("a column without a name; expected one for each".into());
            }
            if names.contains(&name) {
                return Err(format!("column `{name}` twice; expected it once"));
            }
            names.push(name);
        }
        let find = |name: &str| names.iter().position(|n| *n == name);
        let need = |name: &str| {
            find(name).ok_or_else(|| {
                format!(
                    "no column `{name}`; expected time_s, x_m, y_m, heading_rad and sensor values"
                )
            })
        };
        let stamp = match (find("time_s"), find("stamp")) {
            (Some(_), Some(_)) => {
                return Err("columns `time_s` and `stamp`; expected one of them".into());
            }
            (time, stamp) => time.or(stamp).map_or_else(|| need("time_s"), Ok)?,
        };
        let pose = [need("x_m")?, need("y_m")?, need("heading_rad")?];
        let odometry_names = ["odometry_x_m", "odometry_y_m", "odometry_heading_rad"];
        let odometry = match odometry_names.map(find) {
            [Some(x), Some(y), Some(heading)] => Some([x, y, heading]),
            [None, None, None] => None,
            _ => {
                return Err(format!(
                    "some of {}; expected all three or none",
                    odometry_names.join(", ")
                ));
            }
        };
        let (run, route, compass) = (find("run"), find("route_m"), find("compass_rad"));
        let named = ["frame", "image"].map(|name| find(name).filter(|column| names_files(*column)));
        let frame = match named {
            [Some(_), Some(_)] => {
                return Err("columns `frame` and `image`; expected one of them".into());
            }
            [frame, image] => frame.or(image),
        };
        let mut used = vec![stamp];
        used.extend(pose);
        used.extend(odometry.iter().flatten());
        used.extend([run, route, compass, frame].iter().flatten());
        let sensors: Vec<(usize, &str)> = names
            .iter()
            .copied()
            .enumerate()
            .filter(|(i, _)| !used.contains(i))
            .collect();
        let (mut channels, values) = channels(&sensors)?;
        channels.extend(frame.map(|_| image::channel()));
        if channels.is_empty() {
            return Err("no sensor column; expected at least one besides time and place".into());
        }
        Ok(Self {
            width: names.len(),
            stamp,
            pose,
            odometry,
            run,
            route,
            compass,
            frame,
            channels,
            values,
        })
    }

    pub fn row(&self, record: &ByteRecord) -> std::result::Result<Row, String> {
        if record.len() != self.width {
            return Err(format!(
                "{} cells; expected {}, one a column",
                record.len(),
                self.width
            ));
        }
        let text = |i: usize| {
            let cell = std::str::from_utf8(&record[i])
                .map_err(|_| format!("cell {} is not UTF-8; expected a number", i + 1));
            cell.map(str::trim)
        };
        let wrong = |i: usize, cell: &str, expected: &str| {
            let shown: String = cell.chars().take(20).collect();
            format!(
                "cell {} holds `{}`; expected {expected}",
                i + 1,
                shown.escape_debug()
            )
        };
        let number = |i: usize| {
            let cell = text(i)?;
            let value = cell.parse::<f64>().ok().filter(|v| v.is_finite());
            value.ok_or_else(|| wrong(i, cell, "a finite number"))
        };
        let pose = |at: [usize; 3]| {
            Ok::<_, String>(Pose::new(number(at[0])?, number(at[1])?, number(at[2])?))
        };
        let reading = |i: usize| match text(i)? {
            "" => Ok(f32::NAN),
            cell => match cell.parse::<f32>() {
                Ok(value) if value.is_finite() => Ok(value),
                Ok(_) => Ok(f32::NAN),
                Err(_) => Err(wrong(
                    i,
                    cell,
                    "a number, or nothing where nothing came back",
                )),
            },
        };
        Ok(Row {
            stamp_s: number(self.stamp)?,
            pose: pose(self.pose)?,
            odometry: self.odometry.map(pose).transpose()?,
            run: match self.run {
                None => 0,
                Some(i) => text(i)?
                    .parse()
                    .map_err(|_| wrong(i, text(i).unwrap_or(""), "a whole number"))?,
            },
            route_m: self.route.map(number).transpose()?,
            compass_rad: self.compass.map(number).transpose()?,
            frame: match self.frame.map(text).transpose()? {
                None | Some("") => None,
                Some(name) => Some(name.to_string()),
            },
            values: self
                .values
                .iter()
                .map(|i| reading(*i))
                .collect::<std::result::Result<_, _>>()?,
        })
    }
}

/// The channels that sensor columns form, in the order of their first columns, and the columns of their values.
fn channels(sensors: &[(usize, &str)]) -> std::result::Result<(Vec<Channel>, Vec<usize>), String> {
    /// A channel in the making: name, unit, and its columns by number.
    struct Group<'a> {
        name: &'a str,
        unit: Option<&'a str>,
        dotted: bool,
        columns: Vec<(usize, usize)>,
    }
    let mut groups: Vec<Group> = Vec::new();
    let in_a_row = |stem: &str| {
        // `light_0, light_1` are one channel, `gas_2` alone is a name of its own.
        sensors
            .iter()
            .any(|(_, column)| unbracketed(column).0.strip_prefix(stem) == Some("_0"))
    };
    for (position, column) in sensors {
        let (column, unit) = unbracketed(column);
        let indexed = |separator: char| {
            let (stem, index) = column.rsplit_once(separator)?;
            Some((stem, index.parse::<usize>().ok()?)).filter(|(stem, _)| !stem.is_empty())
        };
        let dotted = indexed('.');
        let (name, index) = dotted
            .or_else(|| indexed('_').filter(|(stem, _)| in_a_row(stem)))
            .unwrap_or((column, 0));
        match groups.iter_mut().find(|g| g.name == name) {
            Some(group) => {
                group.unit = group.unit.or(unit);
                group.columns.push((index, *position));
            }
            None => groups.push(Group {
                name,
                unit,
                dotted: dotted.is_some(),
                columns: vec![(index, *position)],
            }),
        }
    }
    let (mut channels, mut values) = (Vec::new(), Vec::new());
    for mut group in groups {
        group.columns.sort_unstable();
        if let Some((expected, _)) = (0..)
            .zip(&group.columns)
            .find(|(expected, (index, _))| expected != index)
        {
            let separator = if group.dotted { '.' } else { '_' };
            return Err(format!(
                "columns of channel `{0}` leave out or repeat `{0}{separator}{expected}`; expected each number from 0 once",
                group.name
            ));
        }
        let metres = IN_METRES.contains(&group.name) || group.name.ends_with("_m");
        channels.push(Channel {
            name: group.name.to_string(),
            width: group.columns.len(),
            unit: group
                .unit
                .unwrap_or(if metres { "m" } else { "as recorded" })
                .to_string(),
            bearing_rad: None,
            maximum: None,
            offset_m: None,
        });
        values.extend(group.columns.iter().map(|(_, position)| *position));
    }
    Ok((channels, values))
}

/// `light[lux]` → `light`, `lux`
fn unbracketed(column: &str) -> (&str, Option<&str>) {
    let cut = column.strip_suffix(']').and_then(|c| c.split_once('['));
    cut.map_or((column, None), |(name, unit)| (name, Some(unit)))
}
