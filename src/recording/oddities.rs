//! What reads well in a log and yet looks wrong: the notes that save a user an evening.

use super::{Channel, Columns, import_report::ImportReport, imported_log::OdometrySource};
use ndarray::{ArrayView2, Axis};

/// Fewer snapshots than this say nothing of what never changes.
const ENOUGH: usize = 20;
/// A heading beyond this many radians, a little more than a whole turn, may be in degrees.
const MOST_RAD: f64 = 6.5;
/// No clock in seconds has come this far since 1970.
const LATEST_S: f64 = 1e11;
/// The nearest reading of a range sensor is nearer than this, in metres; …
const NEAREST_M: f64 = 15.0;
/// … from here on they are rather millimetres than centimetres.
const NEAREST_IN_MM: f64 = 100.0;
/// A step that no robot makes, in metres.
const LONGEST_STEP_M: f64 = 1e6;
/// By so much more must headings agree with the direction of travel as degrees than as radians.
const CLEARLY: f64 = 0.2;
/// Steps shorter than this, in metres, have no direction.
const SHORTEST_M: f64 = 0.05;
/// Values named in a note.
const NAMED: usize = 3;

/// Notes what looks wrong about a log, without changing it; where its odometry comes from is told where its poses stay.
pub(super) fn note(
    columns: &Columns,
    odometry: Option<OdometrySource>,
    account: &mut ImportReport,
) {
    let mut first = 0;
    for channel in &columns.channels {
        let range = first..first + channel.width;
        first = range.end;
        let values = columns.values.slice_axis(Axis(1), range.into());
        never_changing(channel, values, account);
        if channel.unit == "m" {
            far_away(channel, values, account);
            if channel.bearing_rad.is_none() {
                account.note(format!(
                    "channel `{0}` says not where its values point, so scans can't be moved to other poses: state it by `--bearings {0}=...`",
                    channel.name.escape_debug()
                ));
            }
        }
    }
    labels_among_sensors(columns, account);
    places_and_times(columns, account);
    if odometry == Some(OdometrySource::Poses) && columns.pose.len() > 1 {
        account.note("the poses are all there is: odometry repeats them. Where they are odometry themselves, they are no labels".into());
    }
}

/// Values that read the same in every snapshot: a placeholder, or a sensor that is broken.
fn never_changing(channel: &Channel, values: ArrayView2<f32>, account: &mut ImportReport) {
    if values.nrows() < ENOUGH {
        return;
    }
    let fixed: Vec<(usize, f32)> = (0..channel.width)
        .filter_map(|k| {
            let mut column = values.column(k).into_iter();
            let first = column.next().copied().filter(|v| v.is_finite())?;
            column.all(|v| *v == first).then_some((k, first))
        })
        .collect();
    if fixed.is_empty() {
        return;
    }
    let name = channel.name.escape_debug();
    let named: Vec<String> = fixed
        .iter()
        .take(NAMED)
        .map(|(k, value)| format!("{k} ({value})"))
        .collect();
    let more = match fixed.len().saturating_sub(NAMED) {
        0 => String::new(),
        more => format!(" and {more} more"),
    };
    let what = if fixed.len() == channel.width {
        format!("channel `{name}` reads {} in every snapshot", fixed[0].1)
    } else {
        format!(
            "of channel `{name}`, these values (from 0) read the same in every snapshot: {}{more}",
            named.join(", ")
        )
    };
    account.note(format!("{what}; leave out what is no reading by `--drop`"));
}

/// Ranges that no robot's sensor has: another unit was meant.
fn far_away(channel: &Channel, values: ArrayView2<f32>, account: &mut ImportReport) {
    let nearest = values
        .iter()
        .copied()
        .filter(|v| v.is_finite())
        .fold(f32::INFINITY, f32::min);
    let nearest = f64::from(nearest);
    if values.nrows() < ENOUGH || !nearest.is_finite() || nearest < NEAREST_M {
        return;
    }
    let unit = if nearest < NEAREST_IN_MM { "cm" } else { "mm" };
    let name = channel.name.escape_debug();
    account.note(format!(
        "channel `{name}`, taken for metres, has its nearest reading at {nearest}: where it is {unit}, say so by `{name}.0[{unit}]` in the header or `--unit {name}={unit}`"
    ));
}

/// Single whole-number channels beside a wide one: rooms, floors and people's numbers rather than sensors.
fn labels_among_sensors(columns: &Columns, account: &mut ImportReport) {
    if columns.channels.iter().all(|channel| channel.width < 2) || columns.pose.len() < ENOUGH {
        return;
    }
    let mut first = 0;
    let mut whole = Vec::new();
    for channel in &columns.channels {
        let values = columns.values.column(first);
        first += channel.width;
        let single = channel.width == 1 && channel.unit == "as recorded";
        if single && values.iter().all(|v| v.fract() == 0.0) {
            whole.push(format!("`{}`", channel.name.escape_debug()));
        }
    }
    if !whole.is_empty() {
        account.note(format!(
            "{} hold whole numbers alone and are taken for sensors: leave out by `--drop` what numbers places, people or rows",
            whole.join(", ")
        ));
    }
}

fn places_and_times(columns: &Columns, account: &mut ImportReport) {
    let headings = columns.pose.iter().map(|pose| pose.heading_rad.abs());
    let most = headings.fold(0.0, f64::max);
    if most > MOST_RAD && agreement(columns, 1f64.to_radians()) > agreement(columns, 1.0) + CLEARLY
    {
        account.note(format!(
            "headings reach {most}, and agree with the direction of travel where they are degrees; expected radians"
        ));
    }
    let latest = columns.stamp_s.iter().copied().fold(0.0, f64::max);
    if latest > LATEST_S {
        let unit = match latest {
            ..1e14 => "milliseconds",
            ..1e17 => "microseconds",
            _ => "nanoseconds",
        };
        account.note(format!(
            "stamps reach {latest:e}; expected seconds. Are they {unit}?"
        ));
    }
    for (name, poses) in [("pose", &columns.pose), ("odometry", &columns.odometry)] {
        let far = poses
            .iter()
            .position(|p| p.x_m.abs().max(p.y_m.abs()) > LONGEST_STEP_M);
        if let Some(k) = far {
            account.note(format!(
                "{name} of snapshot {k} lies more than {LONGEST_STEP_M:e} m from the origin; expected metres in a frame of the place"
            ));
        }
    }
}

/// How well headings agree with the direction of travel where one of their units is so many radians: the mean of the cosine
/// between them, without regard to forward or back; 0 for a robot that stands.
fn agreement(columns: &Columns, unit_rad: f64) -> f64 {
    let steps = columns.pose.windows(2).filter_map(|pair| {
        let (dx, dy) = (pair[1].x_m - pair[0].x_m, pair[1].y_m - pair[0].y_m);
        let long = dx.hypot(dy) > SHORTEST_M && dx.hypot(dy) < LONGEST_STEP_M;
        long.then(|| (dy.atan2(dx) - pair[0].heading_rad * unit_rad).cos().abs())
    });
    let (sum, n) = steps.fold((0.0, 0), |(sum, n), cosine| (sum + cosine, n + 1));
    sum / f64::from(n.max(1))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Pose;
    use ndarray::Array2;

    fn log(channel: Channel, value: impl Fn(usize, usize) -> f32) -> Columns {
        let values = Array2::from_shape_fn((30, channel.width), |(k, i)| value(k, i));
        Columns {
            channels: vec![channel],
            values,
            stamp_s: (0..30).map(f64::from).collect(),
            pose: (0..30).map(|k| Pose::new(f64::from(k), 0.0, 0.0)).collect(),
            odometry: vec![Pose::default(); 30],
            run: vec![0; 30],
            ..Columns::default()
        }
    }

    fn scan(width: usize) -> Channel {
        Channel {
            name: "sonar".into(),
            width,
            unit: "m".into(),
            bearing_rad: Some(vec![0.0; width]),
            ..Channel::default()
        }
    }

    fn notes(columns: &Columns) -> String {
        let mut account = ImportReport::default();
        note(columns, Some(OdometrySource::Stated), &mut account);
        account.notes().join("\n")
    }

    #[test]
    fn a_sound_log_has_no_notes() {
        let sound = log(scan(3), |k, i| 1.0 + (k * 3 + i) as f32 / 100.0);
        assert_eq!(notes(&sound), "");
        let odometry_alone = {
            let mut account = ImportReport::default();
            note(&sound, Some(OdometrySource::Poses), &mut account);
            account.notes().join("\n")
        };
        assert!(odometry_alone.contains("no labels"));
    }

    #[test]
    fn each_oddity_is_noted() {
        let dead = log(scan(3), |k, i| if i == 1 { 50.0 } else { 1.0 + k as f32 });
        assert!(notes(&dead).contains("read the same in every snapshot: 1 (50)"));
        let all_dead = log(scan(2), |_, _| 7.0);
        assert!(notes(&all_dead).contains("channel `sonar` reads 7 in every snapshot"));
        let far = |nearest: f32| notes(&log(scan(1), |k, _| nearest + k as f32));
        assert!(far(300.0).contains("--unit sonar=mm") && far(30.0).contains("--unit sonar=cm"));
        let silent = log(
            Channel {
                bearing_rad: None,
                ..scan(1)
            },
            |k, _| k as f32,
        );
        assert!(notes(&silent).contains("--bearings sonar="));
    }

    #[test]
    fn labels_degrees_and_other_clocks_are_noted() {
        let mut fingerprints = log(scan(2), |k, i| (k + i) as f32 / 7.0);
        fingerprints.channels.push(Channel {
            name: "FLOOR".into(),
            width: 1,
            unit: "as recorded".into(),
            ..Channel::default()
        });
        let floors = Array2::from_shape_fn((30, 1), |(k, _)| (k / 10) as f32);
        fingerprints.values = ndarray::concatenate![Axis(1), fingerprints.values, floors];
        assert!(notes(&fingerprints).starts_with("`FLOOR` hold whole numbers alone"));
        let mut odd = log(scan(1), |k, _| 1.0 + k as f32);
        for (k, pose) in odd.pose.iter_mut().enumerate() {
            let (sin, cos) = 30f64.to_radians().sin_cos();
            *pose = Pose::new(k as f64 * cos, k as f64 * sin, 30.0);
        }
        odd.stamp_s[29] = 1.4e18;
        odd.odometry[4].x_m = 1e30;
        let said = notes(&odd);
        for part in [
            "headings reach 30,",
            "Are they nanoseconds?",
            "odometry of snapshot 4",
        ] {
            assert!(said.contains(part), "{said}");
        }
        // Headings that count whole turns are radians none the less.
        let turns =
            |pose: &mut Pose| pose.heading_rad = 20.0 * std::f64::consts::PI + 30f64.to_radians();
        odd.pose.iter_mut().for_each(turns);
        assert!(!notes(&odd).contains("headings reach"));
    }
}
