//! Answers of somebody else's localiser from files: poses, poses with covariances, particles, or the belief of a grid.
//!
//! `NAME.tum` holds a pose a snapshot (`time x y z qx qy qz qw`). `NAME.csv` has a header: `time_s`, `x_m`, `y_m` and perhaps
//! `heading_rad` (or `heading_deg`), and where there is a belief either `xx_m2`, `xy_m2`, `yy_m2` (the covariance of the place, a row a snapshot),
//! `weight` (particles, several rows a snapshot, any positive sum) or `probability` (cells, several rows a snapshot, which sum to 1).

use super::config::ExternalConfig;
use crate::{
    delimited::Delimited,
    error::{Error, Result},
    localiser::{Estimate, Probable, Step},
    score::trajectory::{self, Format},
    storage,
};
use std::path::{Path, PathBuf};

/// How far from 1 the probabilities of a belief may sum: cells that a program left out as next to nothing.
const SUM: f64 = 1e-3;
/// A heading above this in a column of radians is one in degrees.
const MOST_RADIANS: f64 = 50.0;
/// Rings and rays of places that stand for a Gaussian, all as probable.
const RINGS: usize = 16;
/// See [`RINGS`].
const RAYS: usize = 16;
/// Edge of the square that holds most of the particles and whose mean is the answer, in metres.
const SQUARE_M: f64 = 1.0;

/// What was said at one time.
struct Said {
    time_s: f64,
    step: Step,
}

/// Answers to a trial whose snapshots were taken at these times, one each.
///
/// # Errors
/// Where there is no file of that name in the folder, a line of it makes no sense, or a snapshot has no answer.
pub(super) fn read(
    folder: &Path,
    name: &str,
    times_s: &[f64],
    config: &ExternalConfig,
) -> Result<Vec<Step>> {
    let [poses, table] = ["tum", "csv"].map(|ending| folder.join(format!("{name}.{ending}")));
    let said = match (poses.is_file(), table.is_file()) {
        (false, false) => {
            return Err(Error::work(format!(
                "no answer to {name}; expected {} or .csv",
                poses.display()
            )));
        }
        (true, false) => poses_of(&poses)?,
        (false, true) => table_of(&table)?,
        (true, true) => {
            let (answers, beliefs) = (poses_of(&poses)?, table_of(&table)?);
            if let Some(bare) = beliefs.iter().find(|said| said.step.posterior.is_empty()) {
                return Err(Error::file(
                    &table,
                    format!(
                        "no belief at {} s; expected covariances, weights or probabilities beside {}",
                        bare.time_s,
                        poses.display()
                    ),
                ));
            }
            let answers = at_times(&poses, name, answers, times_s, config)?;
            let beliefs = at_times(&table, name, beliefs, times_s, config)?;
            let both = answers.into_iter().zip(beliefs);
            return Ok(both
                .map(|(answer, belief)| Step {
                    posterior: belief.posterior,
                    ..answer
                })
                .collect());
        }
    };
    let file = if table.is_file() { table } else { poses };
    at_times(&file, name, said, times_s, config)
}

/// What was said nearest to each of these times.
fn at_times(
    file: &Path,
    name: &str,
    said: Vec<Said>,
    times_s: &[f64],
    config: &ExternalConfig,
) -> Result<Vec<Step>> {
    let (first_s, last_s) = match times_s {
        [first, .., last] => (*first, *last),
        [one] => (*one, *one),
        [] => return Ok(Vec::new()),
    };
    let (from, to) = match (said.first(), said.last()) {
        (Some(first), Some(last)) => (first.time_s, last.time_s),
        _ => {
            return Err(Error::file(
                file,
                "holds no answer; expected one a snapshot",
            ));
        }
    };
    if from > last_s + config.tolerance_s || to < first_s - config.tolerance_s {
        return Err(Error::file(
            file,
            format!(
                "its time stamps go from {from} to {to} s; expected those of {name}, from {first_s} to {last_s} s"
            ),
        ));
    }
    let mut steps = Vec::with_capacity(times_s.len());
    for (snapshot, &time_s) in times_s.iter().enumerate() {
        let after = said.partition_point(|said| said.time_s < time_s);
        let candidates = [after.checked_sub(1), Some(after)];
        let near = candidates.into_iter().flatten().filter_map(|k| said.get(k));
        let off = |said: &&Said| (said.time_s - time_s).abs();
        let nearest = near.min_by(|a, b| off(a).total_cmp(&off(b)));
        match nearest {
            // Rounded stamps must not decide.
            Some(said) if off(&said) <= config.tolerance_s + 1e-9 => steps.push(said.step.clone()),
            _ if config.may_be_silent => steps.push(Step::default()),
            nearest => {
                let nearest = nearest.map_or(String::new(), |said| {
                    format!("; the nearest is at {} s", said.time_s)
                });
                return Err(Error::file(
                    file,
                    format!(
                        "no answer to snapshot {} of {}, at {time_s} s{nearest}; expected one within tolerance_s = {} s, or \
                         may_be_silent = true",
                        snapshot + 1,
                        times_s.len(),
                        config.tolerance_s
                    ),
                ));
            }
        }
    }
    Ok(steps)
}

fn poses_of(file: &Path) -> Result<Vec<Said>> {
    let trajectory = trajectory::read(file, Some(Format::Tum))?;
    let stamps = trajectory.stamps().unwrap_or_default(); // TUM has them
    let said = stamps.iter().zip(trajectory.poses());
    Ok(said
        .map(|(&time_s, pose)| {
            let pose = pose.to_plane();
            Said {
                time_s,
                step: Step {
                    estimate: Some(Estimate::Place([pose.x_m, pose.y_m])),
                    heading_rad: Some(pose.heading_rad),
                    posterior: Vec::new(),
                },
            }
        })
        .collect())
}

/// Where the columns of a table stand.
struct Header {
    names: Vec<String>,
    time: usize,
    place: [usize; 2],
    heading: Option<(usize, Angle)>,
    belief: Option<Belief>,
}

#[derive(Clone, Copy)]
enum Angle {
    Radians,
    Degrees,
}

#[derive(Clone, Copy)]
enum Belief {
    Covariance([usize; 3]),
    Weight(usize),
    Probability(usize),
}

impl Header {
    fn of(names: Vec<String>) -> std::result::Result<Self, String> {
        let find = |aliases: &[&str]| {
            names
                .iter()
                .position(|name| aliases.contains(&name.as_str()))
        };
        let need = |aliases: &[&str]| {
            let found: Vec<String> = names
                .iter()
                .take(12)
                .map(|n| n.escape_debug().to_string())
                .collect();
            find(aliases).ok_or_else(|| {
                format!(
                    "no column `{}` among `{}`; expected time_s, x_m, y_m, and heading_rad, weight, probability or xx_m2, xy_m2, \
                     yy_m2 where there are such",
                    aliases[0],
                    found.join("`, `")
                )
            })
        };
        let covariance = ["xx_m2", "xy_m2", "yy_m2"].map(|name| find(&[name]));
        let belief = match (covariance, find(&["weight"]), find(&["probability"])) {
            ([None, None, None], None, None) => None,
            ([Some(xx), Some(xy), Some(yy)], None, None) => Some(Belief::Covariance([xx, xy, yy])),
            ([None, None, None], Some(at), None) => Some(Belief::Weight(at)),
            ([None, None, None], None, Some(at)) => Some(Belief::Probability(at)),
            ([None, None, None], Some(_), Some(_)) => {
                return Err("columns `weight` and `probability`; expected one of them".into());
            }
            _ => {
                return Err(
                    "expected all of xx_m2, xy_m2 and yy_m2, and then neither weight nor probability"
                        .into(),
                );
            }
        };
        let radians = find(&["heading_rad", "yaw_rad", "heading", "yaw", "theta"]);
        let degrees = find(&["heading_deg", "yaw_deg", "theta_deg"]);
        Ok(Self {
            time: need(&["time_s", "stamp", "stamp_s", "timestamp", "time", "t"])?,
            place: [need(&["x_m", "x"])?, need(&["y_m", "y"])?],
            heading: match (radians, degrees) {
                (Some(_), Some(_)) => {
                    return Err(
                        "a heading in radians and one in degrees; expected one of them".into(),
                    );
                }
                (radians, degrees) => radians
                    .map(|at| (at, Angle::Radians))
                    .or(degrees.map(|at| (at, Angle::Degrees))),
            },
            belief,
            names,
        })
    }
}

/// One row of a table.
struct Row {
    place: [f64; 2],
    heading_rad: Option<f64>,
    /// Weight or probability; else 1.
    weight: f64,
    covariance: Option<[f64; 3]>,
}

fn table_of(file: &Path) -> Result<Vec<Said>> {
    let bytes = storage::read_file(file)?;
    let table = Delimited::new(&bytes);
    let header = Header::of(table.names());
    let header =
        header.map_err(|fault| Error::input(file, format!("line {}", table.line(1)), fault))?;
    let mut reader = table.reader();
    let mut said: Vec<Said> = Vec::new();
    let mut now: Option<(f64, u64, Vec<Row>)> = None;
    for record in reader.records() {
        let record = record.map_err(|e| Error::file(file, format!("is not CSV: {e}")))?;
        let line = table.line(record.position().map_or(0, |position| position.line()));
        let wrong = |fault: String| Error::input(file, format!("line {line}"), fault);
        if record.len() != header.names.len() {
            return Err(wrong(format!(
                "{} cells; expected {} as in the header",
                record.len(),
                header.names.len()
            )));
        }
        let number = |at: usize| match table.number::<f64>(&record[at]) {
            Some(value) if value.is_finite() => Ok(value),
            _ => Err(wrong(format!(
                "`{}` holds `{}`; expected a finite number",
                header.names[at].escape_debug(),
                record[at]
                    .chars()
                    .take(40)
                    .collect::<String>()
                    .escape_debug()
            ))),
        };
        let (time_s, row) = (number(header.time)?, row(&header, number, wrong)?);
        match &mut now {
            Some((at_s, _, rows)) if *at_s == time_s => rows.push(row),
            _ => {
                if let Some((before_s, line, rows)) = now.replace((time_s, line, vec![row])) {
                    if before_s > time_s {
                        return Err(wrong(format!(
                            "time {time_s} s after {before_s} s; expected rising times, rows of one time together"
                        )));
                    }
                    said.push(together(file, &header, before_s, line, rows)?);
                }
            }
        }
    }
    if let Some((time_s, line, rows)) = now {
        said.push(together(file, &header, time_s, line, rows)?);
    }
    Ok(said)
}

fn row(
    header: &Header,
    number: impl Fn(usize) -> Result<f64>,
    wrong: impl Fn(String) -> Error,
) -> Result<Row> {
    let heading_rad = match header.heading {
        None => None,
        Some((at, Angle::Degrees)) => Some(number(at)?.to_radians()),
        Some((at, Angle::Radians)) => match number(at)? {
            heading if heading.abs() > MOST_RADIANS => {
                return Err(wrong(format!(
                    "`{}` holds {heading}; expected radians (call it `heading_deg` where it is degrees)",
                    header.names[at].escape_debug()
                )));
            }
            heading => Some(heading),
        },
    };
    let mut row = Row {
        place: [number(header.place[0])?, number(header.place[1])?],
        heading_rad,
        weight: 1.0,
        covariance: None,
    };
    match header.belief {
        None => {}
        Some(Belief::Covariance(at)) => {
            let [xx, xy, yy] = [number(at[0])?, number(at[1])?, number(at[2])?];
            if !(xx >= 0.0 && yy >= 0.0 && xx * yy - xy * xy >= -1e-9 * (xx * yy).max(1e-12)) {
                return Err(wrong(format!(
                    "covariance {xx}, {xy}, {yy}; expected one that is positive semidefinite"
                )));
            }
            row.covariance = Some([xx, xy, yy]);
        }
        Some(Belief::Weight(at) | Belief::Probability(at)) => {
            row.weight = number(at)?;
            if row.weight < 0.0 {
                return Err(wrong(format!(
                    "`{}` holds {}; expected 0 or more",
                    header.names[at].escape_debug(),
                    row.weight
                )));
            }
        }
    }
    Ok(row)
}

/// What the rows of one time say together; the first of them stands on that line.
fn together(file: &Path, header: &Header, time_s: f64, line: u64, rows: Vec<Row>) -> Result<Said> {
    let wrong = |fault: String| Error::input(file, format!("line {line}"), fault);
    let sum: f64 = rows.iter().map(|row| row.weight).sum();
    let one = |rows: &[Row]| match rows {
        [one] => Ok((one.place, one.heading_rad)),
        _ => Err(wrong(format!(
            "{} rows at {time_s} s; expected one answer a time, or a column `weight` or `probability`",
            rows.len()
        ))),
    };
    let step = match header.belief {
        None => {
            let (place, heading_rad) = one(&rows)?;
            Step {
                estimate: Some(Estimate::Place(place)),
                heading_rad,
                posterior: Vec::new(),
            }
        }
        Some(Belief::Covariance(_)) => {
            let (place, heading_rad) = one(&rows)?;
            Step {
                estimate: Some(Estimate::Place(place)),
                heading_rad,
                posterior: gaussian(place, rows[0].covariance.unwrap_or_default()),
            }
        }
        Some(Belief::Weight(_)) => {
            if !(sum > 0.0 && sum.is_finite()) {
                return Err(wrong(format!(
                    "weights at {time_s} s sum to {sum}; expected more than 0"
                )));
            }
            let (place, heading_rad) = densest(&rows);
            Step {
                estimate: Some(Estimate::Place(place)),
                heading_rad,
                posterior: shares(&rows, sum),
            }
        }
        Some(Belief::Probability(_)) => {
            if (sum - 1.0).abs() > SUM {
                return Err(wrong(format!(
                    "probabilities at {time_s} s sum to {sum}; expected 1 ± {SUM}"
                )));
            }
            let likelier = |a: &&Row, b: &&Row| a.weight.total_cmp(&b.weight);
            // As where a localiser's posterior is its answer: of several as likely the last.
            let likeliest = rows.iter().max_by(likelier);
            Step {
                estimate: likeliest.map(|row| Estimate::Place(row.place)),
                heading_rad: likeliest.and_then(|row| row.heading_rad),
                posterior: shares(&rows, sum),
            }
        }
    };
    Ok(Said { time_s, step })
}

/// Shares of the whole; those that sum to 1 but for rounding are taken as they stand, so that what was equal stays equal.
fn shares(rows: &[Row], sum: f64) -> Vec<Probable> {
    let sum = if (sum - 1.0).abs() < 1e-9 { 1.0 } else { sum };
    let held = rows.iter().filter(|row| row.weight > 0.0);
    held.map(|row| (row.place, row.weight / sum)).collect()
}

/// The mean of the particles in the square that holds most of their weight, the first of several with as much.
fn densest(rows: &[Row]) -> ([f64; 2], Option<f64>) {
    let square = |row: &Row| row.place.map(|m| (m / SQUARE_M).floor());
    let mut sorted: Vec<&Row> = rows.iter().collect();
    let order = |a: &&Row, b: &&Row| {
        let (a, b) = (square(a), square(b));
        a[0].total_cmp(&b[0]).then(a[1].total_cmp(&b[1]))
    };
    sorted.sort_by(order);
    let weight = |rows: &[&Row]| rows.iter().map(|row| row.weight).sum::<f64>();
    let squares = sorted.chunk_by(|a, b| square(a) == square(b));
    let mut heaviest: (&[&Row], f64) = (&[], 0.0);
    for rows in squares {
        let weight = weight(rows);
        if weight > heaviest.1 {
            heaviest = (rows, weight);
        }
    }
    let (rows, all) = heaviest;
    let mean =
        |of: &dyn Fn(&Row) -> f64| rows.iter().map(|row| row.weight * of(row)).sum::<f64>() / all;
    let heading = rows.iter().all(|row| row.heading_rad.is_some()).then(|| {
        let of = |part: fn(f64) -> f64| mean(&|row| part(row.heading_rad.unwrap_or(0.0)));
        of(f64::sin).atan2(of(f64::cos))
    });
    (
        [mean(&|row| row.place[0]), mean(&|row| row.place[1])],
        heading,
    )
}

/// Places as probable as each other that stand for a Gaussian: on the middle radii of rings of one mass each.
fn gaussian([x, y]: [f64; 2], [xx, xy, yy]: [f64; 3]) -> Vec<Probable> {
    // Cholesky's root of the covariance.
    let a = xx.sqrt();
    let b = if a > 0.0 { xy / a } else { 0.0 };
    let c = (yy - b * b).max(0.0).sqrt();
    let share = 1.0 / (RINGS * RAYS) as f64;
    let on_ring = |ring: usize| {
        let outside = 1.0 - (ring as f64 + 0.5) / RINGS as f64;
        let radius = (-2.0 * outside.ln()).sqrt();
        (0..RAYS).map(move |ray| {
            let angle = std::f64::consts::TAU * (ray as f64 + 0.5) / RAYS as f64;
            let (u, v) = (radius * angle.cos(), radius * angle.sin());
            ([x + a * u, y + b * u + c * v], share)
        })
    };
    (0..RINGS).flat_map(on_ring).collect()
}

/// Files of a folder that are answers to no trial of these names: what a person should be told of.
///
/// # Errors
/// Where the folder can't be read.
pub(super) fn strangers(folder: &Path, names: &[String]) -> Result<Vec<PathBuf>> {
    let unreadable = |e| Error::io("cannot read the folder", folder, e);
    let mut strangers = Vec::new();
    for entry in std::fs::read_dir(folder).map_err(unreadable)? {
        let path = entry.map_err(unreadable)?.path();
        let is_answer = path
            .extension()
            .is_some_and(|ending| ending == "tum" || ending == "csv");
        let stem = path
            .file_stem()
            .map(|stem| stem.to_string_lossy().into_owned());
        if is_answer && !stem.is_some_and(|stem| names.contains(&stem)) {
            strangers.push(path);
        }
    }
    strangers.sort();
    Ok(strangers)
}

#[cfg(test)]
mod tests;
