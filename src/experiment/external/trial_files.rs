//! What somebody else's localiser is given of a trial: all that ours see of it, and nothing from which its place follows.
//!
//! Trials are drawn in the order of their starts, so their numbers in file names are shuffled; time stamps count from the trial's first
//! snapshot; and odometry is laid to the origin there, as logs often begin at the true pose.

use crate::{
    error::Result,
    geometry::Pose,
    recording::{Columns, Recording},
    seed::Seed,
};
use rand::seq::SliceRandom;

/// When the first snapshot of every trial counts as taken, in seconds. Not at 0, which programs for ROS take for no time at all.
const FIRST_S: f64 = 1.0;

/// How a trial starts.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Start {
    /// Anywhere: the robot has no idea.
    Unknown,
    /// At a pose that it is told.
    Known,
}

impl Start {
    /// What file names begin with.
    pub fn word(self) -> &'static str {
        match self {
            Self::Unknown => "unknown",
            Self::Known => "known",
        }
    }
}

/// Names of trials in files, `unknown-001` and so on, in the order that they were drawn in.
///
/// ```
/// use ballmark::{Seed, experiment::external::{Start, names}};
/// let mut drawn = names(Start::Unknown, 12, Seed(1));
/// assert_ne!(drawn, names(Start::Unknown, 12, Seed(2)));
/// drawn.sort();
/// assert_eq!((drawn[0].as_str(), drawn[11].as_str()), ("unknown-001", "unknown-012"));
/// ```
pub fn names(start: Start, trials: usize, seed: Seed) -> Vec<String> {
    let mut numbers: Vec<usize> = (1..=trials).collect();
    let stream = match start {
        Start::Unknown => "names of trials from anywhere",
        Start::Known => "names of trials from a known start",
    };
    numbers.shuffle(&mut seed.stream(stream));
    let digits = trials.to_string().len().max(3);
    let name = |number| format!("{}-{number:0digits$}", start.word());
    numbers.into_iter().map(name).collect()
}

/// What a localiser may see of a trial of these snapshots, as a recording of one run. Its poses are its odometry.
///
/// # Errors
/// Never for trials of the recording.
pub fn observed(run: &Recording, snapshots: &[usize]) -> Result<Recording> {
    let columns = run.columns();
    let first = snapshots[0];
    let origin = columns.odometry[first];
    let odometry: Vec<Pose> = snapshots
        .iter()
        .map(|&k| Pose::default().after(origin.displacement_to(&columns.odometry[k])))
        .collect();
    Recording::new(Columns {
        channels: columns.channels.clone(),
        values: columns.values.select(ndarray::Axis(0), snapshots),
        stamp_s: times(run, snapshots),
        pose: odometry.clone(),
        odometry,
        run: vec![0; snapshots.len()],
        compass_rad: columns
            .compass_rad
            .as_ref()
            .map(|compass| snapshots.iter().map(|&k| compass[k]).collect()),
        ..Columns::default()
    })
}

/// When its snapshots count as taken: the first at 1 s. To the microsecond, as all formats have them.
pub fn times(run: &Recording, snapshots: &[usize]) -> Vec<f64> {
    let stamp_s = &run.columns().stamp_s;
    let first = stamp_s[snapshots[0]];
    let since = |&k: &usize| FIRST_S + ((stamp_s[k] - first) * 1e6).round() / 1e6;
    snapshots.iter().map(since).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::recording::Channel;
    use ndarray::Array2;

    #[test]
    fn nothing_says_where_a_trial_is() {
        let pose: Vec<Pose> = (0..6)
            .map(|k| Pose::new(5.0 + f64::from(k), -3.0, 0.25))
            .collect();
        let light = Channel {
            name: "light".into(),
            width: 1,
            unit: "lux".into(),
            ..Channel::default()
        };
        let run = Recording::new(Columns {
            channels: vec![light],
            values: Array2::from_shape_fn((6, 1), |(k, _)| k as f32),
            stamp_s: (0..6).map(|k| 1.7e9 + 0.5 * f64::from(k)).collect(),
            odometry: pose.clone(),
            pose,
            run: vec![7; 6],
            route_m: Some(vec![9.0; 6]),
            source: Some("walk.log".into()),
            ..Columns::default()
        })
        .unwrap();
        let seen = observed(&run, &[2, 3, 5]).unwrap();
        let columns = seen.columns();
        assert_eq!(columns.stamp_s, [1.0, 1.5, 2.5]);
        assert_eq!(columns.odometry[0], Pose::default());
        assert_eq!(columns.pose, columns.odometry);
        assert_eq!(columns.run, [0; 3]);
        assert!(columns.route_m.is_none() && columns.source.is_none());
        assert_eq!(columns.values.as_slice().unwrap(), [2.0, 3.0, 5.0]);
        // Where the robot goes is kept.
        let moved = |r: &Recording, a: usize, b: usize| {
            let step = r.columns().odometry[a].displacement_to(&r.columns().odometry[b]);
            [step.forward_m, step.left_m, step.turn_rad]
        };
        let pairs = moved(&seen, 0, 2).into_iter().zip(moved(&run, 2, 5));
        assert!(pairs.into_iter().all(|(a, b)| (a - b).abs() < 1e-12));
    }

    #[test]
    fn names_are_no_order_of_starts() {
        let numbers: Vec<String> = names(Start::Known, 1200, Seed(1));
        assert!(numbers[0].len() == "known-0001".len() && !numbers.is_sorted());
        let rising = numbers.windows(2).filter(|pair| pair[0] < pair[1]).count();
        assert!((500..700).contains(&rising), "{rising}");
    }
}
