//! Snapshots that were never taken, from places close to those that were: range scans drawn anew for a moved robot.
//!
//! Two recorded runs never pass the very same poses. What learns from recorded poses alone learns them by heart; what is
//! also shown how the scan of each would have looked from beside learns the place.

mod scan;
#[cfg(test)]
mod tests;

pub use scan::Viewpoint;

use super::{Channel, Recording};
use crate::{
    error::{Error, Result},
    geometry::{Displacement, Pose, wrapped},
    seed::Stream,
};
use ndarray::{Array2, ArrayView2, Axis};
use rand_distr::{Distribution, StandardNormal};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use std::ops::Range;

/// How far from a recorded pose views are drawn: normally distributed.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Moves {
    /// Standard deviation of the shift ahead, and of that to the left, in metres.
    pub shift_m: f64,
    /// Standard deviation of the turn, in radians.
    pub turn_rad: f64,
}

impl Default for Moves {
    /// 0.2 m and 8°: two passes of a robot along the same way.
    fn default() -> Self {
        Self {
            shift_m: 0.2,
            turn_rad: 8_f64.to_radians(),
        }
    }
}

impl Moves {
    /// # Errors
    /// Where a deviation is negative or not finite; the message names the key.
    pub fn check(&self) -> Result<()> {
        for (key, value) in [("shift_m", self.shift_m), ("turn_rad", self.turn_rad)] {
            if !(value.is_finite() && value >= 0.0) {
                return Err(Error::usage(format!(
                    "moves.{key} = {value}: expected 0 or more"
                )));
            }
        }
        Ok(())
    }

    /// That many moves, drawn one after the other.
    pub fn draw(&self, count: usize, random: &mut Stream) -> Vec<Displacement> {
        let mut normal = |deviation: f64| -> f64 {
            let standard: f64 = StandardNormal.sample(random);
            deviation * standard
        };
        (0..count)
            .map(|_| Displacement {
                forward_m: normal(self.shift_m),
                left_m: normal(self.shift_m),
                turn_rad: normal(self.turn_rad),
            })
            .collect()
    }
}

/// A recording whose scans can be drawn from moved places.
///
/// Range channels with bearings are drawn anew; other channels can't be, and are repeated as they are.
///
/// ```
/// use ballmark::{recording::viewpoint::{Moves, Views}, seed::Seed, world::corridor};
/// let config = corridor::CorridorConfig { runs: 1, ..Default::default() };
/// let recording = corridor::thrun1998(Seed(1), &config)?;
///
/// let views = Views::of(&recording)?.expect("sonars have bearings");
/// let moved = views.drawn(&[3, 4, 5], &Moves::default(), &mut Seed(1).stream("moved views"))?;
/// assert_eq!(moved.len(), 3);
/// assert!(moved.poses()[0].distance_m(&recording.poses()[3]) < 1.0);
/// # Ok::<(), ballmark::Error>(())
/// ```
#[derive(Debug, Clone)]
pub struct Views<'a> {
    recording: &'a Recording,
    /// Columns of the channels that can be drawn anew, and how.
    scans: Vec<(Range<usize>, Viewpoint)>,
    /// Direction of travel at every snapshot, where the recording lies along a route.
    ways: Option<Vec<Way>>,
}

/// How the coordinate along a route grows at a place: `[metres a metre east, metres a metre north]`.
type Way = [f64; 2];

impl<'a> Views<'a> {
    /// Makes the recording's scans ready to be drawn; `None` where it has no range channel with bearings.
    ///
    /// # Errors
    /// Where a bearing is not a finite number; the message names the channel.
    pub fn of(recording: &'a Recording) -> Result<Option<Self>> {
        let scans = scans(recording.channels())?;
        if scans.is_empty() {
            return Ok(None);
        }
        let ways = recording.route_m().map(|route_m| ways(recording, route_m));
        Ok(Some(Self {
            recording,
            scans,
            ways,
        }))
    }

    /// The snapshots of these indices, each from a place of its own that `moves` gives. The same stream gives the same
    /// views, whatever the number of threads.
    ///
    /// # Errors
    /// Where `snapshots` is empty, or a deviation makes no sense.
    pub fn drawn(
        &self,
        snapshots: &[usize],
        moves: &Moves,
        random: &mut Stream,
    ) -> Result<Recording> {
        moves.check()?;
        self.moved(snapshots, &moves.draw(snapshots.len(), random))
    }

    /// The snapshots of these indices, each after its own step: scans, poses, odometry, compass and the coordinate along
    /// the route are those of the moved robot. On a route only the part of a step along the direction of travel counts,
    /// metre for metre. What results is no file's content, so it carries no checksum.
    ///
    /// # Errors
    /// Where `snapshots` is empty, or there is not one finite step for each.
    pub fn moved(&self, snapshots: &[usize], steps: &[Displacement]) -> Result<Recording> {
        let finite = |s: &Displacement| (s.forward_m + s.left_m + s.turn_rad).is_finite();
        if steps.len() != snapshots.len() || !steps.iter().all(finite) {
            return Err(Error::work(format!(
                "{} moves for {} snapshots; expected one finite move for each",
                steps.len(),
                snapshots.len()
            )));
        }
        let mut columns = self.recording.select(snapshots)?.into_columns();
        render_rows(&mut columns.values, &self.scans, |k| steps[k]);
        if let (Some(route_m), Some(ways)) = (&mut columns.route_m, &self.ways) {
            for (i, (route_m, &k)) in route_m.iter_mut().zip(snapshots).enumerate() {
                let from = columns.pose[i];
                let to = from.after(steps[i]);
                *route_m += ways[k][0] * (to.x_m - from.x_m) + ways[k][1] * (to.y_m - from.y_m);
            }
        }
        for poses in [&mut columns.pose, &mut columns.odometry] {
            for (pose, &step) in poses.iter_mut().zip(steps) {
                *pose = pose.after(step);
            }
        }
        for (compass_rad, step) in columns.compass_rad.iter_mut().flatten().zip(steps) {
            *compass_rad = wrapped(*compass_rad + step.turn_rad);
        }
        (columns.source_sha256, columns.dataset_sha256) = (None, None);
        Recording::new(columns)
    }
}

/// Readings `[snapshot, value]` of `channels` side by side, as a robot would have them that has made a step: scans are drawn anew,
/// other channels repeated as they are. `None` where no channel is a range scan with bearings.
///
/// # Errors
/// Where a bearing is not a finite number; the message names the channel.
pub fn after_step(
    channels: &[Channel],
    values: ArrayView2<f32>,
    step: Displacement,
) -> Result<Option<Array2<f32>>> {
    let scans = scans(channels)?;
    if scans.is_empty() {
        return Ok(None);
    }
    let mut moved = values.to_owned();
    render_rows(&mut moved, &scans, |_| step);
    Ok(Some(moved))
}

/// Columns of the channels that can be drawn anew, and how.
fn scans(channels: &[Channel]) -> Result<Vec<(Range<usize>, Viewpoint)>> {
    let (mut scans, mut from) = (Vec::new(), 0);
    for channel in channels {
        let columns = from..from + channel.width;
        from = columns.end;
        if let Some(viewpoint) = viewpoint(channel)? {
            scans.push((columns, viewpoint));
        }
    }
    Ok(scans)
}

/// Draws the scans of every row anew, as seen after the step of that row.
fn render_rows(
    values: &mut Array2<f32>,
    scans: &[(Range<usize>, Viewpoint)],
    step_of: impl Fn(usize) -> Displacement + Sync,
) {
    let rows = values.axis_iter_mut(Axis(0)).into_par_iter().enumerate();
    rows.for_each(|(k, mut row)| {
        let recorded = row.to_vec();
        let mut drawn = recorded.clone();
        for (columns, viewpoint) in scans {
            let columns = columns.clone();
            viewpoint.render(&recorded[columns.clone()], step_of(k), &mut drawn[columns]);
        }
        row.iter_mut()
            .zip(drawn)
            .for_each(|(value, drawn)| *value = drawn);
    });
}

fn viewpoint(channel: &Channel) -> Result<Option<Viewpoint>> {
    let Some(bearing_rad) = channel.bearing_rad.as_ref().filter(|_| channel.unit == "m") else {
        return Ok(None);
    };
    let viewpoint = Viewpoint::new(bearing_rad, channel.maximum);
    let on_robot = |viewpoint: Viewpoint| match &channel.offset_m {
        Some(offset_m) => viewpoint.with_offset_m(offset_m),
        None => viewpoint,
    };
    viewpoint
        .map(|viewpoint| Some(on_robot(viewpoint)))
        .map_err(|e| Error::work(format!("channel `{}`: {e}", channel.name)))
}

/// A direction of travel is taken from places at least so far apart, in metres: poses of a log tremble.
const TRAVELLED_M: f64 = 0.1;

/// Direction of travel at every snapshot, from the snapshots of its run around it; straight ahead where the robot never
/// leaves its place.
fn ways(recording: &Recording, route_m: &[f64]) -> Vec<Way> {
    let poses = recording.poses();
    let mut ways = Vec::with_capacity(poses.len());
    for run in recording.runs() {
        for k in run.clone() {
            let apart = |(a, b): &(usize, usize)| poses[*a].distance_m(&poses[*b]) >= TRAVELLED_M;
            let around = (1..run.len())
                .map(|d| (k.saturating_sub(d).max(run.start), (k + d).min(run.end - 1)));
            ways.push(match around.into_iter().find(apart) {
                Some((a, b)) => towards(&poses[a], &poses[b], route_m[b] - route_m[a]),
                None => [poses[k].heading_rad.cos(), poses[k].heading_rad.sin()],
            });
        }
    }
    ways
}

/// The direction from one pose to another, against it where the route is driven backwards.
fn towards(a: &Pose, b: &Pose, gained_m: f64) -> Way {
    let sign = if gained_m < 0.0 { -1.0 } else { 1.0 };
    let share = sign / a.distance_m(b);
    [share * (b.x_m - a.x_m), share * (b.y_m - a.y_m)]
}
