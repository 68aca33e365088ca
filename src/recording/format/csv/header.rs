//! The header of a table: which column is what.

use super::{
    channels,
    column_name::{bare_and_stem, shown},
};
use crate::recording::{Channel, image, log_options::LogOptions};
use std::collections::{HashMap, HashSet};

/// Names of columns that a message lists.
const LISTED: usize = 12;

/// Where each column stands.
pub(super) struct Header {
    pub width: usize,
    pub stamp: usize,
    /// None where poses come from elsewhere.
    pub pose: Option<[usize; 3]>,
    pub odometry: Option<[usize; 3]>,
    pub run: Option<usize>,
    pub route: Option<usize>,
    pub compass: Option<usize>,
    /// Names of picture files; their channel comes last.
    pub frame: Option<usize>,
    pub channels: Vec<Channel>,
    /// Columns of the other channels' values, side by side.
    pub values: Vec<usize>,
    /// What to know about how columns were taken.
    pub notes: Vec<String>,
}

/// What is wrong with a header.
pub(super) enum Fault {
    /// The header itself.
    Header(String),
    /// What the user chose of it.
    Selection(String),
}

impl From<String> for Fault {
    fn from(fault: String) -> Self {
        Self::Header(fault)
    }
}

impl Header {
    /// Reads the header; `names_files` says of a column by number whether its cells are names rather than numbers.
    pub fn parse(
        names: &[String],
        options: &LogOptions,
        names_files: impl Fn(usize) -> bool,
    ) -> std::result::Result<Self, Fault> {
        let mut at: HashMap<&str, usize> = HashMap::new();
        let mut notes = Vec::new();
        for (column, name) in names.iter().enumerate() {
            if name.is_empty() && column == 0 {
                notes.push(
                    "the first column has no name, like one of row numbers: it is passed over"
                        .into(),
                );
                continue;
            }
            if name.is_empty() {
                return Err(
                    format!("column {} has no name; expected one for each", column + 1).into(),
                );
            }
            if at.insert(name, column).is_some() {
                return Err(format!("column `{}` twice; expected it once", shown(name)).into());
            }
        }
        let find = |name: &str| at.get(name).copied();
        let stamp = match (find("time_s"), find("stamp")) {
            (Some(_), Some(_)) => {
                return Err("columns `time_s` and `stamp`; expected one of them"
                    .to_string()
                    .into());
            }
            (time, stamp) => time.or(stamp),
        };
        let places = ["x_m", "y_m", "heading_rad"].map(find);
        let selection = &options.sensors;
        let (stamp, pose) = match (stamp, places) {
            (Some(stamp), [Some(x), Some(y), Some(heading)]) => (stamp, Some([x, y, heading])),
            (Some(stamp), [None, None, None]) if options.poses_elsewhere => (stamp, None),
            _ => return Err(lacking(names, stamp, places).into()),
        };
        let odometry_names = ["odometry_x_m", "odometry_y_m", "odometry_heading_rad"];
        let odometry = match odometry_names.map(find) {
            [Some(x), Some(y), Some(heading)] => Some([x, y, heading]),
            [None, None, None] => None,
            _ => {
                let names = odometry_names.join(", ");
                return Err(format!("some of {names}; expected all three or none").into());
            }
        };
        let (run, route, compass) = (find("run"), find("route_m"), find("compass_rad"));
        let named = ["frame", "image"].map(|name| find(name).filter(|column| names_files(*column)));
        let frame = match named {
            [Some(_), Some(_)] => {
                return Err("columns `frame` and `image`; expected one of them"
                    .to_string()
                    .into());
            }
            [frame, image] => frame.or(image),
        };
        let mut used = HashSet::from([stamp]);
        used.extend(pose.iter().flatten());
        used.extend(odometry.iter().flatten());
        used.extend([run, route, compass, frame].iter().flatten());
        let sensors = names.iter().map(String::as_str).enumerate();
        let is_sensor = |(i, name): &(usize, &str)| !used.contains(i) && !name.is_empty();
        let sensors: Vec<(usize, &str)> = sensors.filter(is_sensor).collect();
        let going_by = |(_, name): &(usize, &'_ str)| -> Vec<String> {
            let mut all = vec![name.to_string()];
            let (bare, stem) = bare_and_stem(name);
            all.extend([Some(bare), stem].into_iter().flatten().map(String::from));
            all
        };
        let known: Vec<Vec<String>> = sensors.iter().map(going_by).collect();
        let known = known
            .iter()
            .map(|all| all.iter().map(String::as_str).collect::<Vec<_>>());
        selection.check(known.clone()).map_err(Fault::Selection)?;
        let kept = sensors
            .iter()
            .zip(known)
            .filter(|(_, names)| selection.keeps(names));
        let kept: Vec<(usize, &str)> = kept.map(|(sensor, _)| *sensor).collect();
        let mut found = channels::channels(&kept, selection.is_part())?;
        notes.append(&mut found.notes);
        found.channels.extend(frame.map(|_| image::channel()));
        if found.channels.is_empty() {
            let fault = match sensors.is_empty() {
                true => "no sensor column; expected at least one besides time and place",
                false => {
                    return Err(Fault::Selection(
                        "no sensor column is left; expected at least one".into(),
                    ));
                }
            };
            return Err(fault.to_string().into());
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
            channels: found.channels,
            values: found.values,
            notes,
        })
    }
}

/// Which of the columns that a table needs it lacks, and which it has.
fn lacking(names: &[String], stamp: Option<usize>, places: [Option<usize>; 3]) -> String {
    let needed = ["time_s", "x_m", "y_m", "heading_rad"];
    let there = [stamp, places[0], places[1], places[2]];
    let missing: Vec<String> = needed
        .iter()
        .zip(there)
        .filter(|(_, at)| at.is_none())
        .map(|(name, _)| format!("`{name}`"))
        .collect();
    let listed: Vec<String> = names.iter().take(LISTED).map(|name| shown(name)).collect();
    let more = match names.len().saturating_sub(LISTED) {
        0 => String::new(),
        more => format!(" and {more} more"),
    };
    format!(
        "no column {} among {}{more}; expected {} and sensor values",
        missing.join(", "),
        listed.join(", "),
        needed.join(", ")
    )
}
