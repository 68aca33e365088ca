//! A recording out of what a log's messages hold.

use super::{
    collector::{Collector, Readings, Topic, shown},
    poses::{Source, Sources, sources},
    sensors::{Sensors, sensors},
    track::{Lookup, TOLERANCE_S},
};
use crate::{
    geometry::Pose,
    recording::{
        Columns, Recording,
        format::clocks::Clocks,
        gaps,
        import_report::ImportReport,
        imported_log::{ImportedLog, OdometrySource},
        log_options::LogOptions,
    },
};
use ndarray::{Array2, Axis};
use std::collections::BTreeSet;

/// Snapshots farther apart than this with no odometry in between are of two runs, in seconds.
const GAP_S: f64 = 10.0;

/// Makes a recording of what was collected.
///
/// # Errors
/// In words, where there is no sensor topic, no pose, or none at the time of a snapshot, or a topic asked for isn't there.
pub(super) fn assemble(
    mut collector: Collector,
    options: &LogOptions,
) -> Result<ImportedLog, String> {
    collector.decode_pictures();
    check_topics(&collector, options.topics.as_deref())?;
    check_clocks(&mut collector);
    let (tree, oddities) = std::mem::take(&mut collector.transforms).into_tree();
    let (pose_topic, chosen) = (options.pose_topic.as_deref(), options.topics.as_deref());
    let base = sources(&collector, &tree, pose_topic, chosen)?.base;
    let found = sensors(&mut collector, &tree, &base, options.max_range_m);
    let found = found.ok_or_else(|| no_sensor(&collector))?;
    let stamps_s = found.leading_stamps();
    let mut account = std::mem::take(&mut collector.account);
    let sources = sources(&collector, &tree, pose_topic, chosen)?;
    oddities.iter().for_each(|oddity| account.warning(oddity));
    let placed = match place(&stamps_s, &sources, &found, &mut account) {
        Err(_) if options.poses_elsewhere => at_the_origin(&stamps_s),
        placed => placed?,
    };
    count_topics(&collector, &placed, &found, &mut account);
    let (width, k) = (
        found
            .sensors
            .iter()
            .map(|sensor| sensor.channel.width)
            .sum(),
        placed.snapshots.len(),
    );
    let mut values = Array2::from_elem((k, width), f32::NAN);
    for (snapshot, mut row) in placed.snapshots.iter().zip(values.axis_iter_mut(Axis(0))) {
        let Some(mut rest) = row.as_slice_mut() else {
            continue; // rows of a fresh array are contiguous
        };
        for sensor in &found.sensors {
            let (here, behind) = rest.split_at_mut(sensor.channel.width);
            if !sensor.fill(snapshot.stamp_s, here) {
                let name = &sensor.channel.name;
                account.warning(&format!("snapshot without readings of `{name}`"));
            }
            rest = behind;
        }
    }
    let column = |pose: fn(&Placed) -> Pose| placed.snapshots.iter().map(pose).collect::<Vec<_>>();
    let (pose, odometry) = (column(|s| s.pose), column(|s| s.odometry));
    let stamp_s: Vec<f64> = placed.snapshots.iter().map(|s| s.stamp_s).collect();
    let one_run = vec![0; pose.len()];
    let mut run = gaps::runs(
        &pose,
        &odometry,
        placed.source,
        &one_run,
        options.gap_or_usual_m(),
        &mut account,
    );
    part_in_time(&mut run, &stamp_s, placed.bridge, &mut account);
    let recording = Recording::new(Columns {
        channels: found.sensors.into_iter().map(|s| s.channel).collect(),
        values,
        stamp_s,
        pose,
        odometry,
        run,
        ..Columns::default()
    });
    Ok(ImportedLog {
        recording: recording.map_err(|e| e.to_string())?,
        account,
        odometry: placed.source,
    })
}

/// A snapshot's time and place.
struct Placed {
    stamp_s: f64,
    pose: Pose,
    odometry: Pose,
}

/// All snapshots that have a place.
struct Placement<'a> {
    snapshots: Vec<Placed>,
    source: OdometrySource,
    /// Topics that poses and odometry were taken from.
    topics: BTreeSet<&'a str>,
    /// What connects snapshots that are far apart in time.
    bridge: Option<&'a Source<'a>>,
}

fn place<'a>(
    stamps_s: &[f64],
    sources: &'a Sources<'a>,
    sensors: &Sensors,
    account: &mut ImportReport,
) -> Result<Placement<'a>, String> {
    let hits = |source: &Source| {
        let found = stamps_s.iter().filter_map(|s| source.at(*s).found());
        found.count()
    };
    let (mut label, mut most) = (None, 0);
    for source in &sources.labels {
        let n = hits(source);
        if n > most {
            (label, most) = (Some(source), n);
        }
        if 2 * most >= stamps_s.len() {
            break;
        }
    }
    let odometry = sources.odometry.as_ref().filter(|source| hits(source) > 0);
    let source = match (label, odometry) {
        (Some(_), Some(_)) => OdometrySource::Interpolated,
        _ => OdometrySource::Poses,
    };
    let Some(pose) = label.or(odometry) else {
        return Err(no_pose(stamps_s, sources, sensors));
    };
    if label.is_none() {
        account.warning(&format!(
            "log whose only poses are odometry ({}): they drift, and are no labels to learn from",
            pose.name
        ));
    }
    let odometry = odometry.unwrap_or(pose);
    let topic = shown(&sensors.leader);
    let mut snapshots = Vec::new();
    for &stamp_s in stamps_s {
        match pose.at(stamp_s).and(odometry.at(stamp_s)) {
            Lookup::Found((pose, odometry)) => snapshots.push(Placed {
                stamp_s,
                pose,
                odometry,
            }),
            Lookup::Outside => {
                account.warning(&format!(
                    "`{topic}` outside of the poses' time, passed over"
                ));
                account.passed_over(&sensors.leader_type);
            }
            Lookup::Missing => {
                let what = match pose.at(stamp_s) {
                    Lookup::Found(_) => odometry,
                    _ => pose,
                };
                account.lost(format!(
                    "`{topic}` stamped {stamp_s:.3}: no pose of {} at that time; expected one at most {TOLERANCE_S} s away",
                    what.name
                ));
            }
        }
    }
    if snapshots.is_empty() {
        return Err(no_pose(stamps_s, sources, sensors));
    }
    Ok(Placement {
        snapshots,
        source,
        topics: [pose.topic, odometry.topic].into_iter().flatten().collect(),
        bridge: Some(odometry),
    })
}

/// Snapshots of a log without poses, whose places are not known yet.
fn at_the_origin(stamps_s: &[f64]) -> Placement<'static> {
    let placed = |stamp_s: &f64| Placed {
        stamp_s: *stamp_s,
        pose: Pose::default(),
        odometry: Pose::default(),
    };
    Placement {
        snapshots: stamps_s.iter().map(placed).collect(),
        source: OdometrySource::Poses,
        topics: BTreeSet::new(),
        bridge: None,
    }
}

fn no_pose(stamps_s: &[f64], sources: &Sources, sensors: &Sensors) -> String {
    let names = sources.labels.iter().chain(&sources.odometry);
    let names: Vec<&str> = names.map(|source| source.name.as_str()).collect();
    let span = match (stamps_s.first(), stamps_s.last()) {
        (Some(first), Some(last)) => format!(" (stamped {first:.3} to {last:.3} s)"),
        _ => String::new(),
    };
    let there = match names.is_empty() {
        true => "no source of poses".to_string(),
        false => format!("none of {} covers their time", names.join(", ")),
    };
    format!(
        "no pose for any of the {} messages of `{}`{span}: {there}; expected tf map → {}, PoseWithCovarianceStamped, PoseStamped or Odometry messages",
        stamps_s.len(),
        shown(&sensors.leader),
        shown(&sources.base)
    )
}

fn no_sensor(collector: &Collector) -> String {
    let topics = collector.topics.iter().take(8);
    let topics: Vec<String> = topics
        .map(|(name, topic)| format!("`{}` ({})", shown(name), shown(&topic.type_name)))
        .collect();
    let there = match topics.is_empty() {
        true => "no message that can be read".to_string(),
        false => format!("its topics: {}", topics.join(", ")),
    };
    format!(
        "no sensor message that can be read; expected sensor_msgs/LaserScan, Range or CompressedImage; {there}"
    )
}

/// Topics asked for must be there.
fn check_topics(collector: &Collector, chosen: Option<&[String]>) -> Result<(), String> {
    let used = |topic: &Topic| topic.kind.is_some();
    for name in chosen.unwrap_or_default() {
        if collector.topics.get(name).is_some_and(used) {
            continue;
        }
        let there: Vec<String> = collector
            .topics
            .iter()
            .filter(|(_, topic)| used(topic))
            .map(|(name, topic)| format!("`{}` ({})", shown(name), topic.type_name))
            .collect();
        let what = match collector.topics.get(name) {
            Some(topic) => format!("holds {}, which isn't read", shown(&topic.type_name)),
            None => "isn't in the log".to_string(),
        };
        return Err(format!(
            "the topic `{}` {what}; expected some of {}",
            shown(name),
            there.join(", ")
        ));
    }
    Ok(())
}

/// Warns of clocks that run backwards; a topic whose stamps are all 0 gets the times of logging.
fn check_clocks(collector: &mut Collector) {
    let mut account = std::mem::take(&mut collector.account);
    let mut clocks = Clocks::default();
    for (name, topic) in &mut collector.topics {
        let mut check = |times: &mut dyn Iterator<Item = (&mut f64, f64)>| {
            let mut times: Vec<_> = times.collect();
            if times.iter().all(|(stamp_s, _)| **stamp_s == 0.0) {
                for (stamp_s, logged_s) in &mut times {
                    **stamp_s = *logged_s;
                    account.warning(&format!(
                        "`{}` stamped 0, the time of logging is used",
                        shown(name)
                    ));
                }
            }
            for (stamp_s, _) in times {
                clocks.check(name, *stamp_s, &mut account);
            }
        };
        match &mut topic.readings {
            Readings::None => {}
            Readings::Scans(all) => {
                check(&mut all.iter_mut().map(|r| (&mut r.stamp_s, r.logged_s)))
            }
            Readings::Ranges(all) => {
                check(&mut all.iter_mut().map(|r| (&mut r.stamp_s, r.logged_s)))
            }
            Readings::Pictures(all) => {
                check(&mut all.iter_mut().map(|r| (&mut r.stamp_s, r.logged_s)))
            }
            Readings::Poses(all) => {
                check(&mut all.iter_mut().map(|r| (&mut r.stamp_s, r.logged_s)))
            }
        }
    }
    collector.account = account;
}

/// Counts the messages of topics of poses: used, or passed over.
fn count_topics(
    collector: &Collector,
    placed: &Placement,
    sensors: &Sensors,
    account: &mut ImportReport,
) {
    for (name, topic) in &collector.topics {
        let Readings::Poses(poses) = &topic.readings else {
            continue;
        };
        for _ in poses {
            match placed.topics.contains(name.as_str()) {
                true => account.used(&topic.type_name),
                false => account.passed_over(&topic.type_name),
            }
        }
    }
    for (topic, n) in sensors.further_counts() {
        let type_name = collector.topics.get(topic).map(|t| t.type_name.as_str());
        (0..n).for_each(|_| account.used(type_name.unwrap_or_default()));
    }
    (0..placed.snapshots.len()).for_each(|_| account.used(&sensors.leader_type));
}

/// Begins a new run wherever a long time passed that no odometry tells of.
fn part_in_time(
    run: &mut [i64],
    stamp_s: &[f64],
    bridge: Option<&Source>,
    account: &mut ImportReport,
) {
    let mut added = 0;
    for k in 1..run.len() {
        let (from_s, to_s) = (stamp_s[k - 1], stamp_s[k]);
        let silent = to_s - from_s > GAP_S
            && bridge.is_none_or(|source| source.longest_silence_s(from_s, to_s) > GAP_S);
        if silent && run[k] + added == run[k - 1] {
            account.warning("gap of more than 10 s, where a new run begins");
            added += 1;
        }
        run[k] += added;
    }
}

#[cfg(test)]
mod tests;
