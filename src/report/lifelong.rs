//! Learning that goes on, as tables and as a picture: a robot a row, a world a table.

use super::{Cell, Curve, Table, line_plot};
use crate::{
    error::Result,
    experiment::lifelong::{Change, DayRow, LifelongRecord, RobotRow, WorldRow},
    score::MeanInterval,
};

/// A table a world.
pub fn tables(record: &LifelongRecord) -> Vec<Table> {
    record
        .worlds
        .iter()
        .map(|world| table(record, world))
        .collect()
}

fn table(record: &LifelongRecord, world: &WorldRow) -> Table {
    let config = &record.config;
    let mut table = Table::new([
        name(world.change),
        "error m",
        "against frozen",
        "found %",
        "after m",
        "<1m at m",
        "kept %",
        "wrong %",
    ]);
    for robot in &world.robots {
        let labels = |value: fn(&DayRow) -> Option<f64>| {
            let each: Option<Vec<f64>> = robot.days.iter().map(value).collect();
            each.and_then(|each| MeanInterval::of(&each))
                .map(|mean| 100.0 * mean.mean)
        };
        table.row([
            Cell::Text(robot.title.clone()),
            Cell::number(Some(robot.error_at_10m_m.mean), 2),
            Cell::Text(change(&robot.error_at_10m_m_change)),
            Cell::number(Some(100.0 * robot.found.mean), 1),
            Cell::number(Some(robot.found_after_m.mean), 2),
            Cell::number(robot.mean_below_1m_at_m, 1),
            Cell::number(labels(|day| day.labels_kept), 1),
            Cell::number(labels(|day| day.labels_wrong), 1),
        ]);
    }
    table.caption(format!(
        "{} seeds; day 1 is learned from, days 2 to {} are judged before they are; {} runs and {} trials a day",
        config.seeds, config.days, config.runs, config.trials
    ));
    table.caption("error m = mean expected error 10 m from a start anywhere; against frozen: minus that of the");
    table.caption(
        "  first day's model (of raw snapshots: theirs), paired by seed, with its 95 % interval",
    );
    table.caption("found %, after m: trials that end up sure and right, and metres until then (never: all of a trial)");
    table.caption(
        "kept %, wrong %: own labels that were believed, and those of them off by more than 1 m",
    );
    table
}

fn name(change: Change) -> &'static str {
    match change {
        Change::Still => "nothing changes",
        _ => "the world changes",
    }
}

fn change(change: &MeanInterval) -> String {
    match change.ci95 {
        _ if change.mean == 0.0 => "–".into(),
        Some([low, high]) => format!("{:+.2} ({low:+.2} to {high:+.2})", change.mean),
        None => format!("{:+.2}", change.mean),
    }
}

/// Every robot's days, a line each.
pub fn days(record: &LifelongRecord) -> Table {
    let mut table = Table::new([
        "world",
        "robot",
        "day",
        "error_at_10m_m",
        "low_m",
        "high_m",
        "found",
        "labels_kept",
        "labels_wrong",
        "labels_median_m",
        "labels_p95_m",
    ]);
    for (world, robot) in each(record) {
        for day in &robot.days {
            let [low, high] = [0, 1].map(|end| day.error_at_10m_m.ci95.map(|ci95| ci95[end]));
            table.row([
                Cell::Text(name(world.change).into()),
                Cell::Text(robot.title.clone()),
                Cell::Count(day.day as u64),
                Cell::number(Some(day.error_at_10m_m.mean), 4),
                Cell::number(low, 4),
                Cell::number(high, 4),
                Cell::number(Some(day.found.mean), 4),
                Cell::number(day.labels_kept, 4),
                Cell::number(day.labels_wrong, 4),
                Cell::number(day.labels_median_m, 4),
                Cell::number(day.labels_p95_m, 4),
            ]);
        }
    }
    table
}

fn each(record: &LifelongRecord) -> impl Iterator<Item = (&WorldRow, &RobotRow)> {
    let worlds = record.worlds.iter();
    worlds.flat_map(|world| world.robots.iter().map(move |robot| (world, robot)))
}

/// Error against the day, a curve a robot of the world that changes.
///
/// # Errors
/// Where it can't be drawn.
pub fn plot(record: &LifelongRecord) -> Result<String> {
    let changing = each(record).filter(|(world, _)| world.change == Change::Changing);
    let curve = |(_, robot): (&WorldRow, &RobotRow)| {
        let days = robot.days.iter();
        Curve {
            name: robot.title.clone(),
            x: days.clone().map(|day| day.day as f64).collect(),
            y: days.map(|day| day.error_at_10m_m.mean).collect(),
            band: None,
        }
    };
    let curves: Vec<Curve> = changing.map(curve).collect();
    line_plot(
        "Learning that goes on: the world changes",
        "day",
        "error after 10 m (m)",
        &curves,
    )
}
