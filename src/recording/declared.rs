//! What is said about a log's channels beside the log: units, bearings, offsets. Lengths come out in metres.

use super::{Columns, import_report::ImportReport, log_options::LogOptions, ranges};
use crate::error::{Error, Result};
use ndarray::Axis;
use std::str::FromStr;

/// Lengths, and how many metres each is.
const LENGTHS: [(&str, f64); 8] = [
    ("mm", 0.001),
    ("cm", 0.01),
    ("dm", 0.1),
    ("km", 1000.0),
    ("in", 0.0254),
    ("inch", 0.0254),
    ("ft", 0.3048),
    ("yd", 0.9144),
];

/// Directions of a channel's values, in degrees to the left of ahead.
///
/// ```
/// use ballmark::recording::declared::Bearings;
/// assert_eq!("0,90,-90".parse::<Bearings>()?.of_width(3), Some(vec![0.0, 90.0, -90.0]));
/// assert_eq!("-90..90".parse::<Bearings>()?.of_width(5), Some(vec![-90.0, -45.0, 0.0, 45.0, 90.0]));
/// # Ok::<(), ballmark::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub enum Bearings {
    /// One number a value.
    Each(Vec<f64>),
    /// Evenly from the first to the last.
    Even([f64; 2]),
}

impl Bearings {
    /// Degrees of so many values; none where there is not one for each.
    pub fn of_width(&self, width: usize) -> Option<Vec<f64>> {
        match self {
            Self::Each(deg) => (deg.len() == width).then(|| deg.clone()),
            Self::Even([first, last]) => {
                let step = (last - first) / (width.max(2) - 1) as f64;
                Some((0..width).map(|k| first + step * k as f64).collect())
            }
        }
    }
}

impl FromStr for Bearings {
    type Err = Error;

    fn from_str(text: &str) -> Result<Self> {
        let number = |text: &str| text.trim().parse::<f64>().ok().filter(|n| n.is_finite());
        let bearings = match text.split_once("..") {
            Some((first, last)) => number(first)
                .zip(number(last))
                .map(|(first, last)| Self::Even([first, last])),
            None => text
                .split(',')
                .map(number)
                .collect::<Option<_>>()
                .map(Self::Each),
        };
        bearings.ok_or_else(|| {
            let shown: String = text.chars().take(40).collect();
            Error::usage(format!(
                "bearings `{}`: expected degrees, one a value separated by commas, or FIRST..LAST",
                shown.escape_debug()
            ))
        })
    }
}

/// Gives channels what is said about them, and makes lengths metres.
///
/// # Errors
/// A usage error where no channel has the name, or bearings are not one a value.
pub(super) fn apply(
    columns: &mut Columns,
    options: &LogOptions,
    account: &mut ImportReport,
) -> Result<()> {
    let at = |columns: &Columns, name: &str| {
        let at = columns.channels.iter().position(|c| c.name == name);
        at.ok_or_else(|| {
            let known: Vec<&str> = columns
                .channels
                .iter()
                .map(|c| c.name.as_str())
                .take(12)
                .collect();
            Error::usage(format!(
                "no channel is called `{}`; there are {}",
                name.escape_debug(),
                known.join(", ").escape_debug()
            ))
        })
    };
    for (name, unit) in &options.units {
        let at = at(columns, name)?;
        columns.channels[at].unit = unit.clone();
    }
    for (name, bearings) in &options.bearings {
        let at = at(columns, name)?;
        let channel = &mut columns.channels[at];
        let deg = bearings.of_width(channel.width).ok_or_else(|| {
            Error::usage(format!(
                "bearings of `{}`: one a value, which are {}; expected as many, or FIRST..LAST",
                name.escape_debug(),
                channel.width
            ))
        })?;
        channel.bearing_rad = Some(deg.iter().map(|deg| deg.to_radians()).collect());
    }
    for (name, offset_m) in &options.offsets_m {
        let at = at(columns, name)?;
        let channel = &mut columns.channels[at];
        channel.offset_m = Some(vec![*offset_m; channel.width]);
    }
    in_metres(columns, account);
    if let Some(maximum_m) = options.max_range_m {
        if columns.channels.iter().all(|channel| channel.unit != "m") {
            account.note("a maximal range has no effect: no channel is in metres".into());
        }
        ranges::limit_channels_in_metres(columns, maximum_m);
    }
    Ok(())
}

fn in_metres(columns: &mut Columns, account: &mut ImportReport) {
    let mut first = 0;
    for channel in &mut columns.channels {
        let range = first..first + channel.width;
        first = range.end;
        let Some((unit, metres)) = LENGTHS.iter().find(|(unit, _)| *unit == channel.unit) else {
            continue;
        };
        let mut values = columns.values.slice_axis_mut(Axis(1), range.into());
        values.mapv_inplace(|value| (f64::from(value) * metres) as f32);
        channel.maximum = channel.maximum.map(|maximum| maximum * metres);
        channel.unit = "m".into();
        let name = channel.name.escape_debug();
        account.note(format!("channel `{name}`: {unit} made metres"));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::recording::Channel;

    fn sonar() -> Columns {
        Columns {
            channels: vec![Channel {
                name: "sonar".into(),
                width: 2,
                unit: "as recorded".into(),
                ..Channel::default()
            }],
            values: ndarray::array![[1500.0, 8000.0]],
            ..Columns::default()
        }
    }

    #[test]
    fn what_is_said_makes_a_table_s_column_a_scan() {
        let mut columns = sonar();
        let mut account = ImportReport::default();
        let options = LogOptions {
            units: vec![("sonar".into(), "mm".into())],
            bearings: vec![("sonar".into(), Bearings::Each(vec![90.0, -90.0]))],
            offsets_m: vec![("sonar".into(), 0.25)],
            max_range_m: Some(5.0),
            ..LogOptions::default()
        };
        apply(&mut columns, &options, &mut account).unwrap();
        let channel = &columns.channels[0];
        assert!(channel.is_scan() && channel.offset_of(1) == 0.25);
        assert_eq!(channel.maximum, Some(5.0));
        assert_eq!(columns.values[[0, 0]], 1.5);
        assert!(columns.values[[0, 1]].is_nan());
        assert!(account.notes()[0].contains("mm made metres"));
    }

    #[test]
    fn what_fits_no_channel_is_refused_and_what_has_no_effect_noted() {
        let none = |options: LogOptions| {
            let mut account = ImportReport::default();
            apply(&mut sonar(), &options, &mut account).map(|()| account)
        };
        let bearings = |name: &str, deg| {
            none(LogOptions {
                bearings: vec![(name.into(), Bearings::Each(deg))],
                ..LogOptions::default()
            })
        };
        assert!(
            bearings("laser", vec![0.0])
                .unwrap_err()
                .to_string()
                .contains("no channel is called `laser`; there are sonar")
        );
        assert!(
            bearings("sonar", vec![0.0; 3])
                .unwrap_err()
                .to_string()
                .contains("which are 2")
        );
        let far = none(LogOptions {
            max_range_m: Some(5.0),
            ..LogOptions::default()
        })
        .unwrap();
        assert!(far.notes()[0].contains("no effect"));
        for text in ["", "a", "0..", "0,,1", "nan", "1..inf"] {
            assert!(text.parse::<Bearings>().is_err(), "{text}");
        }
    }
}
