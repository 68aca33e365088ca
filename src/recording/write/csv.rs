//! A table as `import` reads it: one row a snapshot, what values mean in the header.

use crate::{
    geometry::Pose,
    recording::{Channel, Recording},
};
use ::csv::Writer;
use std::io::{self, Write};

pub(super) fn write(
    out: &mut dyn crate::storage::WriteSeek,
    recording: &Recording,
    poses: Option<&[Pose]>,
) -> io::Result<()> {
    let columns = recording.columns();
    let mut table = Writer::from_writer(out as &mut dyn Write);
    let mut header: Vec<String> = vec!["time_s".into()];
    if poses.is_some() {
        header.extend(["x_m", "y_m", "heading_rad"].map(String::from));
    }
    let odometry = ["odometry_x_m", "odometry_y_m", "odometry_heading_rad"];
    header.extend(odometry.map(String::from));
    if poses.is_some() {
        header.push("run".into());
    }
    header.extend(columns.compass_rad.iter().map(|_| "compass_rad".into()));
    header.extend(recording.channels().iter().flat_map(names));
    table.write_record(&header)?;
    for k in 0..recording.len() {
        let of = |pose: &Pose| [pose.x_m, pose.y_m, pose.heading_rad];
        let mut row = vec![columns.stamp_s[k]];
        row.extend(poses.iter().flat_map(|poses| of(&poses[k])));
        row.extend(of(&columns.odometry[k]));
        let mut row: Vec<String> = row.iter().map(f64::to_string).collect();
        if poses.is_some() {
            row.push(columns.run[k].to_string());
        }
        row.extend(
            columns
                .compass_rad
                .iter()
                .map(|compass| compass[k].to_string()),
        );
        // Whatever came back is written in the fewest digits that give it again.
        let cell = |value: &f32| match value.is_finite() {
            true => value.to_string(),
            false => String::new(),
        };
        row.extend(columns.values.row(k).iter().map(cell));
        table.write_record(&row)?;
    }
    table.flush()
}

/// Names of a channel's columns, with unit, bearings and offsets.
fn names(channel: &Channel) -> Vec<String> {
    let stated = |value: usize| {
        let bearing = channel
            .bearing_rad
            .as_ref()
            .map(|all| all[value].to_degrees());
        let offset = channel.offset_m.as_ref().map(|all| all[value]);
        match (bearing, offset) {
            (None, _) => format!("[{}]", channel.unit),
            (Some(deg), None) => format!("[{} @ {deg}]", channel.unit),
            (Some(deg), Some(m)) => format!("[{} @ {deg} + {m}m]", channel.unit),
        }
    };
    match channel.width {
        1 => vec![format!("{}{}", channel.name, stated(0))],
        width => (0..width)
            .map(|value| format!("{}.{value}{}", channel.name, stated(value)))
            .collect(),
    }
}
