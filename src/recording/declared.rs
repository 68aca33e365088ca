//! What is said about a log's channels beside the log: units, bearings, offsets. Lengths come out in metres.

use super::{Columns, import_report::ImportReport, log_options::LogOptions, ranges};
use crate::error::{Error, Result};
use ndarray::Axis;

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
    use crate::recording::{Channel, bearings::Bearings};

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
    }
}
