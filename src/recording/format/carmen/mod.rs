//! CARMEN text logs, and the pose-graph files that borrow their laser lines.
//!
//! One snapshot comes from each line of the log's leading message: the first of `FLASER`, `ROBOTLASER1`, `RAWLASER1`, `RLASER`,
//! `SONAR` that the log has. The first three fill the channel `laser`, `RLASER` is `rear_laser`, `SONAR` is `sonar`. To a
//! snapshot belong the latest readings of each further channel, if they were logged since the snapshot before or are at most
//! half a second old by their stamps; otherwise the channel is all NaN there. Where a log states the same channel twice (`RAWLASER1` beside
//! `ROBOTLASER1`), the leading one counts.
//!
//! The place of a snapshot is the first pose of its line; for lines without one the `VERTEX2` line right before, else the last
//! `ODOM` line. A `VERTEX2` right before a line that states another pose (by more than 1 cm or 0.01 rad) wins, and the line's
//! pose is odometry: the graph was optimised after the line was written. Where odometry may come from:
//! [`OdometrySource`](crate::recording::imported_log::OdometrySource).
//!
//! A snapshot whose place is more than 5 m from the one before, without the odometry saying so, starts a new run: the log has
//! a gap there. Stamps are kept as recorded, and the order of lines is the order of time, since clocks in real logs are
//! sometimes broken. No-return readings are found as [`ranges`] tells.

mod message;
mod odometry;

use crate::{
    error::{Error, Result},
    geometry::Pose,
    recording::{
        Channel, Columns, Recording, format::clocks::Clocks, gaps, import_report::ImportReport,
        imported_log::ImportedLog, log_options::LogOptions, ranges,
    },
};
use message::{Message, Scan};
use ndarray::{Array2, Axis};
use odometry::Step;
use std::{
    collections::BTreeMap,
    io::{self, BufRead, BufReader, Read as _},
    ops::Range,
    path::Path,
};

/// Scans in the order in which they lead.
const LEADERS: [(&str, &str); 5] = [
    ("FLASER", "laser"),
    ("ROBOTLASER1", "laser"),
    ("RAWLASER1", "laser"),
    ("RLASER", "rear_laser"),
    ("SONAR", "sonar"),
];
/// How old readings of a further channel may be in any case, in seconds.
const LATEST_S: f64 = 0.5;
/// A vertex farther than this from the pose of its laser line was optimised since (metres, radians).
const OPTIMISED: f64 = 0.01;

/// A scan, the line it stood in, and where the robot was.
struct Placed {
    /// Without its readings, which are kept together.
    scan: Scan,
    /// Where those stand among the readings of its kind.
    readings: Range<usize>,
    line: usize,
    pose: Option<Pose>,
    stated: Option<Pose>,
}

enum Event {
    Odometry { pose: Pose, stamp_s: f64 },
    Scan(Placed),
}

/// Is one of the first lines a message that CARMEN writes?
pub(super) fn detect(bytes: &[u8]) -> bool {
    let lines = bytes.split(|b| *b == b'\n').take(1000);
    lines.map(message::kind).any(message::is_known)
}

/// Reads an unpacked log; a maximum that is stated replaces the one that the log shows itself. `path` is for messages only.
///
/// # Errors
/// Where the log has no scan, or no pose for any scan. A damaged line is no error but an entry in the account.
///
/// ```
/// use ballmark::recording::{format::carmen::read, log_options::LogOptions};
/// let text = b"FLASER 2 1.5 81.91 3 4 0 3 4 0 0.1 host 0.1\nNEFF 2.0\n";
/// let log = read("walk.log".as_ref(), text, &LogOptions::default())?;
/// assert_eq!(log.recording.poses()[0].x_m, 3.0);
/// assert!(log.recording.values()[[0, 1]].is_nan());
/// assert_eq!(log.account.passed_over_counts()["NEFF"], 1);
/// # Ok::<(), ballmark::Error>(())
/// ```
pub fn read(path: &Path, bytes: &[u8], options: &LogOptions) -> Result<ImportedLog> {
    read_lines(path, bytes, &mut io::empty(), options)
}

/// The same of a log whose beginning is at hand and the rest still to be read; only what it says is held, not its text.
///
/// # Errors
/// As [`read`], and where it can't be read on.
pub(super) fn read_lines(
    path: &Path,
    head: &[u8],
    rest: &mut dyn io::Read,
    options: &LogOptions,
) -> Result<ImportedLog> {
    let mut account = ImportReport::default();
    let lines = BufReader::with_capacity(AT_ONCE, head.chain(rest));
    let Parsed {
        events,
        mut readings,
    } = parse(lines, &mut account).map_err(|e| Error::file(path, e))?;
    let leader = leader(&events).ok_or_else(|| {
        let is_vertex = |kind: &String| kind.starts_with("VERTEX");
        let what = match account.used_counts().keys().any(is_vertex) {
            true => "a pose graph without scans, whose vertices `--poses` joins to a log",
            false => "no scan that can be read",
        };
        Error::file(
            path,
            format!("{what}; expected FLASER, RLASER, SONAR, ROBOTLASER1 or RAWLASER1 lines"),
        )
    })?;
    let widths = usual_widths(&events);
    let mut steps = Vec::new();
    let mut rows: Vec<&Placed> = Vec::new();
    // For each snapshot and further channel, the readings that belong to it.
    let mut beside: Vec<BTreeMap<&str, &Placed>> = Vec::new();
    let mut latest: BTreeMap<&str, (&Placed, usize)> = BTreeMap::new();
    for event in &events {
        let placed = match event {
            Event::Odometry { pose, stamp_s } => {
                steps.push(Step::Odometry {
                    pose: *pose,
                    stamp_s: *stamp_s,
                });
                continue;
            }
            Event::Scan(placed) => placed,
        };
        let scan = &placed.scan;
        if scan.kind != leader.0 && channel(scan.kind) == leader.1 {
            account.passed_over(scan.kind);
            continue;
        }
        if placed.readings.len() != widths[scan.kind] {
            account.lost(format!(
                "line {}: `{}`: {} readings; expected {} as in the log's other lines",
                placed.line,
                scan.kind,
                placed.readings.len(),
                widths[scan.kind]
            ));
            continue;
        }
        if scan.kind != leader.0 {
            account.used(scan.kind);
            latest.insert(scan.kind, (placed, rows.len()));
            continue;
        }
        let elsewhere = options.poses_elsewhere.then(Pose::default);
        let Some(pose) = placed.pose.or(elsewhere) else {
            account.lost(format!(
                "line {}: `{}`: no pose up to here; expected an ODOM or VERTEX2 line before",
                placed.line, scan.kind
            ));
            continue;
        };
        account.used(scan.kind);
        let fresh = |(other, before): &&(&Placed, usize)| {
            let age_s = scan.stamp_s - other.scan.stamp_s;
            *before == rows.len() || (0.0..=LATEST_S).contains(&age_s)
        };
        beside.push(
            latest
                .iter()
                .filter(|(_, other)| fresh(other))
                .map(|(kind, (other, _))| (*kind, *other))
                .collect(),
        );
        rows.push(placed);
        steps.push(Step::Scan {
            pose,
            stated: placed.stated,
            stamp_s: scan.stamp_s,
        });
    }
    if rows.is_empty() {
        return Err(Error::file(
            path,
            format!(
                "no pose for any of its {} lines; expected poses in them, or ODOM or VERTEX2 lines before",
                leader.0
            ),
        ));
    }
    let (odometry, source) = odometry::of_scans(&steps);
    let pose: Vec<Pose> = steps
        .iter()
        .filter_map(|step| match step {
            Step::Scan { pose, .. } => Some(*pose),
            _ => None,
        })
        .collect();
    let further = || {
        LEADERS
            .iter()
            .filter(|(kind, name)| *name != leader.1 && latest.contains_key(kind))
    };
    let mut channels = Vec::new();
    let width = widths[leader.0] + further().map(|(kind, _)| widths[kind]).sum::<usize>();
    let size = rows.len() * width;
    // Where every line of the only kind of scan became a row, its readings are the table.
    let is_alone = further().next().is_none();
    let whole = readings.get_mut(leader.0);
    let whole = whole.filter(|all| is_alone && all.len() == size);
    let is_whole = whole.is_some();
    let values = whole.map_or_else(|| vec![f32::NAN; size], std::mem::take);
    let mut values =
        Array2::from_shape_vec((rows.len(), width), values).map_err(|e| Error::file(path, e))?;
    let mut first = 0;
    for (kind, name) in std::iter::once(&leader).chain(further()) {
        let width = widths[kind];
        let mut block = values.slice_axis_mut(Axis(1), (first..first + width).into());
        let all = readings.get(kind).map_or(&[][..], Vec::as_slice);
        let to_fill = block.rows_mut().into_iter().enumerate();
        for (k, mut row) in to_fill.filter(|_| !is_whole) {
            let placed = if *kind == leader.0 {
                Some(&rows[k])
            } else {
                beside[k].get(kind)
            };
            match placed {
                Some(placed) => row
                    .iter_mut()
                    .zip(&all[placed.readings.clone()])
                    .for_each(|(to, from)| *to = *from),
                None => account.warning(&format!("snapshot without readings of `{name}`")),
            }
        }
        let maximum = options
            .max_range_m
            .or_else(|| ranges::no_return_from(block.view(), &pose));
        ranges::blank_no_returns(block, maximum);
        let example = if *kind == leader.0 {
            Some(rows[0])
        } else {
            latest.get(kind).map(|(placed, _)| *placed)
        };
        channels.push(Channel {
            name: (*name).to_string(),
            width,
            unit: "m".to_string(),
            bearing_rad: example
                .and_then(|placed| placed.scan.fan)
                .map(|(start, step)| (0..width).map(|i| start + i as f64 * step).collect()),
            maximum,
            offset_m: None,
        });
        first += width;
    }
    let one_run = vec![0; pose.len()];
    let run = gaps::runs(
        &pose,
        &odometry,
        source,
        &one_run,
        options.gap_or_usual_m(),
        &mut account,
    );
    let recording = Recording::new(Columns {
        channels,
        values,
        stamp_s: rows.iter().map(|placed| placed.scan.stamp_s).collect(),
        pose,
        odometry,
        run,
        ..Columns::default()
    });
    Ok(ImportedLog {
        recording: recording.map_err(|e| e.in_file(path))?,
        account,
        odometry: source,
    })
}

/// What the lines of a log say.
struct Parsed {
    /// All messages that matter, in order, each with the place it was made at.
    events: Vec<Event>,
    /// The readings of all scans of a kind, one behind the other.
    readings: BTreeMap<&'static str, Vec<f32>>,
}

/// Bytes read at a time.
const AT_ONCE: usize = 1 << 16;

fn parse(mut lines: impl BufRead, account: &mut ImportReport) -> io::Result<Parsed> {
    let mut events = Vec::new();
    let mut readings: BTreeMap<&'static str, Vec<f32>> = BTreeMap::new();
    let mut clocks = Clocks::default();
    let mut vertex: Option<Pose> = None;
    let mut last_odometry: Option<Pose> = None;
    let mut line = Vec::new();
    for number in 1.. {
        line.clear();
        if lines.read_until(b'\n', &mut line)? == 0 {
            break;
        }
        let line = line.strip_suffix(b"\n").unwrap_or(&line);
        let kind = message::kind(line);
        if kind.is_empty() {
            continue;
        }
        match message::parse(line) {
            Err(fault) => account.lost(format!("line {number}: {fault}")),
            Ok(None) => account.passed_over(&shown(kind)),
            Ok(Some(Message::Vertex(pose))) => {
                account.used(&shown(kind));
                vertex = Some(pose);
            }
            Ok(Some(Message::Odometry { pose, stamp_s })) => {
                account.used("ODOM");
                clocks.check("ODOM", stamp_s, account);
                last_odometry = Some(pose);
                events.push(Event::Odometry { pose, stamp_s });
            }
            Ok(Some(Message::Scan(mut scan))) => {
                let all = readings.entry(scan.kind).or_default();
                let start = all.len();
                all.extend(std::mem::take(&mut scan.ranges));
                let own = start..all.len();
                clocks.check(scan.kind, scan.stamp_s, account);
                let vertex = vertex.take();
                let optimised =
                    |v: &Pose, p: &Pose| v.distance_m(p) > OPTIMISED || v.turn_rad(p) > OPTIMISED;
                let (pose, stated) = match (scan.pose, vertex) {
                    (Some(pose), Some(vertex)) if optimised(&vertex, &pose) => {
                        (Some(vertex), Some(pose))
                    }
                    (Some(pose), _) => (Some(pose), scan.odometry),
                    (None, vertex) => (vertex.or(last_odometry), None),
                };
                events.push(Event::Scan(Placed {
                    scan,
                    readings: own,
                    line: number,
                    pose,
                    stated,
                }));
            }
        }
    }
    Ok(Parsed { events, readings })
}

/// A message's name, fit to be printed.
fn shown(kind: &[u8]) -> String {
    if kind.starts_with(b"#") {
        return "#".to_string();
    }
    let name: String = String::from_utf8_lossy(kind).chars().take(24).collect();
    name.escape_debug().to_string()
}

fn channel(kind: &str) -> &'static str {
    LEADERS
        .iter()
        .find(|(leader, _)| *leader == kind)
        .map_or("", |(_, channel)| channel)
}

fn leader(events: &[Event]) -> Option<(&'static str, &'static str)> {
    let has = |kind: &str| {
        events
            .iter()
            .any(|e| matches!(e, Event::Scan(placed) if placed.scan.kind == kind))
    };
    LEADERS.into_iter().find(|(kind, _)| has(kind))
}

/// For each kind of scan, the number of readings that most of its lines have (the smaller one in a draw).
fn usual_widths(events: &[Event]) -> BTreeMap<&'static str, usize> {
    let mut counts: BTreeMap<&str, BTreeMap<usize, usize>> = BTreeMap::new();
    for event in events {
        if let Event::Scan(placed) = event {
            *counts
                .entry(placed.scan.kind)
                .or_default()
                .entry(placed.readings.len())
                .or_default() += 1;
        }
    }
    let usual = |lines: &BTreeMap<usize, usize>| {
        lines
            .iter()
            .rev()
            .max_by_key(|(_, n)| **n)
            .map_or(0, |(width, _)| *width)
    };
    counts
        .iter()
        .map(|(kind, lines)| (*kind, usual(lines)))
        .collect()
}
