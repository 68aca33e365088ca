//! Where a mapping part lay by the robot's own reckoning.
//!
//! Duckett & Nehmzow (1998, below D98) average "the robot's odometer readings" within a place (3.1) and move hypotheses by the same
//! odometry (eq. 4, 5), wheels with north from the compass (5.2). Steel distorts a compass, and it does so alike in every lap: a map
//! in that distorted frame and a robot that moves in it agree, a map of true poses and that robot do not. Drift is taken out
//! as in 6.4: "for each lap, the accumulated drift error was then removed by correcting each data point by an amount
//! proportional to the distance travelled along the route". Their landmark that ends a lap is here a pose near to where the lap
//! began, as the mapping part's poses are known.

use crate::{geometry::Pose, recording::Recording};

/// A lap has left where it began once it is this far off, metres, …
const LEFT_M: f64 = 2.0;
/// … and is back there within this.
const BACK_M: f64 = 0.5;

/// Poses of some snapshots of a recording, as its compass-based odometry has them, in their order: anchored to the
/// recording's own where a lap, or a stretch without gap, begins and ends. Headings are the recording's own. `None` without a
/// compass.
///
/// ```
/// use ballmark::{geometry::Pose, localiser::reckoned::reckoned, recording::{Channel, Columns, Recording}};
/// // Four metres east and back, with wheels that measure a tenth too much on the way out.
/// let light = Channel { name: "light".into(), width: 1, unit: "lux".into(), ..Channel::default() };
/// let at = |x: &[f64]| x.iter().map(|&x_m| Pose::new(x_m, 0.0, 0.0)).collect::<Vec<Pose>>();
/// let recording = Recording::new(Columns {
///     channels: vec![light],
///     values: ndarray::Array2::zeros((5, 1)),
///     stamp_s: vec![0.0, 1.0, 2.0, 3.0, 4.0],
///     pose: at(&[0.0, 2.0, 4.0, 2.0, 0.0]),
///     odometry: at(&[7.0, 9.2, 11.4, 9.4, 7.4]),
///     run: vec![0; 5],
///     compass_rad: Some(vec![0.0; 5]),
///     ..Columns::default()
/// })?;
/// let reckoned = reckoned(&recording, &[0, 1, 2, 3, 4]).unwrap();
/// // 0.4 m too far in the end, of which each metre travelled has its share.
/// assert!((reckoned[2].x_m - (4.4 - 0.4 * 4.4 / 8.4)).abs() < 1e-9 && reckoned[4].x_m.abs() < 1e-9);
/// # Ok::<(), ballmark::Error>(())
/// ```
pub fn reckoned(recording: &Recording, snapshots: &[usize]) -> Option<Vec<Pose>> {
    recording.columns().compass_rad.as_ref()?;
    let poses = recording.poses();
    let mut reckoned: Vec<Pose> = snapshots.iter().map(|&k| poses[k]).collect();
    let mut first = 0;
    while first < snapshots.len() {
        let end = lap_end(recording, snapshots, first);
        let last = end - 1;
        // Where odometry alone gets to, and how far it has travelled until then.
        let (mut at, mut travelled_m) = (
            [poses[snapshots[first]].x_m, poses[snapshots[first]].y_m],
            0.0,
        );
        let mut way = vec![(at, 0.0)];
        for pair in snapshots[first..end].windows(2) {
            let (from, to) = (
                recording.observation(pair[0]),
                recording.observation(pair[1]),
            );
            let [x_m, y_m] = from.north_displacement(&to)?;
            at = [at[0] + x_m, at[1] + y_m];
            travelled_m += x_m.hypot(y_m);
            way.push((at, travelled_m));
        }
        let truth = [poses[snapshots[last]].x_m, poses[snapshots[last]].y_m];
        let drift_m = [0, 1].map(|axis| truth[axis] - at[axis]);
        for (pose, (at, so_far_m)) in reckoned[first..end].iter_mut().zip(way) {
            let share = if travelled_m > 0.0 {
                so_far_m / travelled_m
            } else {
                0.0
            };
            pose.x_m = at[0] + share * drift_m[0];
            pose.y_m = at[1] + share * drift_m[1];
        }
        // The next lap begins where this one ended, which is anchored.
        let goes_on = end < snapshots.len() && is_next(recording, snapshots, last);
        first = if goes_on && end - first > 1 {
            last
        } else {
            end
        };
    }
    Some(reckoned)
}

/// Behind the last snapshot of the lap, or stretch without gap, that begins with this one.
fn lap_end(recording: &Recording, snapshots: &[usize], first: usize) -> usize {
    let poses = recording.poses();
    let (start, mut left) = (poses[snapshots[first]], false);
    for i in first + 1..snapshots.len() {
        if !is_next(recording, snapshots, i - 1) {
            return i;
        }
        let off_m = start.distance_m(&poses[snapshots[i]]);
        left |= off_m > LEFT_M;
        if left && off_m <= BACK_M {
            return i + 1;
        }
    }
    snapshots.len()
}

/// Does odometry lead from this snapshot to the next one of the list?
fn is_next(recording: &Recording, snapshots: &[usize], i: usize) -> bool {
    let run = &recording.columns().run;
    snapshots[i + 1] == snapshots[i] + 1 && run[snapshots[i + 1]] == run[snapshots[i]]
}
