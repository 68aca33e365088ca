//! Readings of the last metres as readings of now: what was sensed so many metres back, and where that lies from here.
//!
//! A few readings at a moment (Wi-Fi, Bluetooth, ranges to beacons) tell little; how they went along the way here tells more. Ways
//! are reckoned by odometry, so the robot can do the same as it drives.

use super::{Channel, Columns, Observation, Recording};
use crate::{
    error::{Error, Result},
    geometry::Pose,
};
use ndarray::Array2;
use std::collections::VecDeque;

/// Values that say where it was: x and y in the robot's frame of now, in metres, and by how much it was turned, in radians.
const MOVED_VALUES: usize = 3;

/// What was sensed some metres back is that of the snapshot nearest to it along the way, if that lies between this share of the metres …
const LEAST_SHARE: f64 = 0.5;
/// … and this.
const MOST_SHARE: f64 = 1.5;

/// Of snapshots that are closer to one another than this share of the shortest distance, the later is remembered.
const FINEST_SHARE: f64 = 0.05;

/// What names of channels begin with that say where something was sensed.
pub const MOVED: &str = "moved@";

/// Most distances to look back: each is as many inputs again.
pub const MOST_BACK: usize = 16;

/// What a robot remembers of the last metres.
///
/// ```
/// use ballmark::{geometry::Pose, recording::history::Past};
/// let mut past = Past::new(&[1.0]);
/// let at = |x_m| Pose::new(x_m, 0.0, 0.0);
/// assert!(past.with(&at(0.0), &[-60.0])[1].is_nan()); // nothing lies a metre back yet
/// past.with(&at(0.5), &[-55.0]);
/// let now = past.with(&at(1.0), &[-50.0]);
/// assert_eq!(now, [-50.0, -60.0, -1.0, 0.0, 0.0]); // now; a metre back; it lies a metre behind, unturned
/// ```
#[derive(Debug, Clone)]
pub struct Past {
    back_m: Vec<f64>,
    /// Metres driven since the first, where odometry was, and what was sensed; the latest last.
    sensed: VecDeque<(f64, Pose, Vec<f32>)>,
}

impl Past {
    /// That remembers what was sensed so many metres back.
    pub fn new(back_m: &[f64]) -> Self {
        Self {
            back_m: back_m.to_vec(),
            sensed: VecDeque::new(),
        }
    }

    /// Forgets everything: the robot was carried, or another run begins.
    pub fn forget(&mut self) {
        self.sensed.clear();
    }

    /// Takes in what is sensed now, with the pose that odometry has reckoned, and gives it back followed by, for every distance, what
    /// was sensed then and where: NaN where nothing was.
    pub fn with(&mut self, odometry: &Pose, values: &[f32]) -> Vec<f32> {
        let driven_m = self.sensed.back().map_or(0.0, |(driven_m, last, _)| {
            driven_m + (odometry.x_m - last.x_m).hypot(odometry.y_m - last.y_m)
        });
        // A robot that stands for hours must not fill its memory.
        let nearest_m = self.back_m.iter().copied().fold(f64::INFINITY, f64::min);
        let before = self.sensed.len().checked_sub(2).map(|k| self.sensed[k].0);
        if before.is_some_and(|before_m| driven_m - before_m < FINEST_SHARE * nearest_m) {
            self.sensed.pop_back();
        }
        self.sensed
            .push_back((driven_m, *odometry, values.to_vec()));
        let farthest_m = self.back_m.iter().copied().fold(0.0, f64::max);
        let oldest_m = driven_m - MOST_SHARE * farthest_m;
        while self
            .sensed
            .front()
            .is_some_and(|(at_m, ..)| *at_m < oldest_m)
        {
            self.sensed.pop_front();
        }
        let mut all = values.to_vec();
        for &back_m in &self.back_m {
            let (wanted_m, allowed_m) = (
                driven_m - back_m,
                [
                    driven_m - MOST_SHARE * back_m,
                    driven_m - LEAST_SHARE * back_m,
                ],
            );
            // They are in the order of the way: the first at or past the place, or the one before it.
            let past = self.sensed.partition_point(|(at_m, ..)| *at_m < wanted_m);
            let nearest = [past.checked_sub(1), Some(past)]
                .into_iter()
                .flatten()
                .filter_map(|k| self.sensed.get(k))
                .filter(|(at_m, ..)| (allowed_m[0]..=allowed_m[1]).contains(at_m))
                .min_by(|a, b| (a.0 - wanted_m).abs().total_cmp(&(b.0 - wanted_m).abs()));
            match nearest {
                Some((_, then, sensed)) => {
                    let moved = odometry.displacement_to(then);
                    all.extend(sensed);
                    all.extend(
                        [moved.forward_m, moved.left_m, moved.turn_rad].map(|moved| moved as f32),
                    );
                }
                None => all.extend(std::iter::repeat_n(f32::NAN, values.len() + MOVED_VALUES)),
            }
        }
        all
    }
}

/// Channels, followed for every distance by their readings then and by where that was.
pub fn channels_with_history(channels: &[Channel], back_m: &[f64]) -> Vec<Channel> {
    let mut all = channels.to_vec();
    for back_m in back_m {
        // Seen from elsewhere they are no scan of the place of now.
        all.extend(channels.iter().map(|channel| Channel {
            name: format!("{}@{back_m}m", channel.name),
            bearing_rad: None,
            offset_m: None,
            ..channel.clone()
        }));
        all.push(Channel {
            name: format!("{MOVED}{back_m}m"),
            width: MOVED_VALUES,
            unit: "m, m, rad".to_string(),
            bearing_rad: None,
            maximum: None,
            offset_m: None,
        });
    }
    all
}

/// # Errors
/// Where distances make no sense; `key` names them.
pub fn check_back_m(key: &str, back_m: &[f64]) -> Result<()> {
    let rises = back_m.windows(2).all(|pair| pair[0] < pair[1]);
    let sound = back_m.iter().all(|m| m.is_finite() && *m > 0.0);
    match rises && sound && back_m.len() <= MOST_BACK {
        true => Ok(()),
        false => Err(Error::usage(format!(
            "{key} = {back_m:?}: expected at most {MOST_BACK} rising distances in metres, all above 0"
        ))),
    }
}

impl Recording {
    /// The recording with the readings of some metres back beside those of now, run by run: as a robot would have remembered them.
    /// Places, labels and checksum stay.
    ///
    /// ```
    /// use ballmark::{seed::Seed, world::corridor};
    /// let config = corridor::CorridorConfig { runs: 1, spacing_m: 0.5 };
    /// let recording = corridor::thrun1998(Seed(1), &config)?;
    /// let remembered = recording.with_history(&[1.0, 2.0])?;
    /// assert_eq!(remembered.channels().len(), 3 * recording.channels().len() + 2);
    /// assert_eq!(remembered.poses(), recording.poses());
    /// # Ok::<(), ballmark::Error>(())
    /// ```
    ///
    /// # Errors
    /// A usage error where distances are not above 0 and rising, or more than [`MOST_BACK`]; an error where a channel has a name that
    /// the history needs.
    pub fn with_history(&self, back_m: &[f64]) -> Result<Recording> {
        check_back_m("history_m", back_m)?;
        let columns = self.columns();
        let channels = channels_with_history(&columns.channels, back_m);
        let width = channels.iter().map(|channel| channel.width).sum();
        let mut values = Array2::zeros((self.len(), width));
        for run in self.runs() {
            let mut past = Past::new(back_m);
            for k in run {
                let observation = self.observation(k);
                let all = past.with(&observation.odometry, &observation.values.to_vec());
                values
                    .row_mut(k)
                    .iter_mut()
                    .zip(all)
                    .for_each(|(to, from)| *to = from);
            }
        }
        Recording::new(Columns {
            channels,
            values,
            ..columns.clone()
        })
    }

    /// Metres from one snapshot to the next along the way, by odometry: the median of all.
    pub fn spacing_m(&self) -> f64 {
        let odometry = &self.columns().odometry;
        let mut steps: Vec<f64> = self
            .runs()
            .into_iter()
            .flat_map(|run| odometry[run].windows(2))
            .map(|pair| (pair[1].x_m - pair[0].x_m).hypot(pair[1].y_m - pair[0].y_m))
            .collect();
        steps.sort_by(f64::total_cmp);
        steps.get(steps.len() / 2).copied().unwrap_or(0.0)
    }
}

impl Past {
    /// The same of an observation: the channels with those of the past, and their values.
    pub fn observed(&mut self, observation: &Observation) -> (Vec<Channel>, Vec<f32>) {
        let values = self.with(&observation.odometry, &observation.values.to_vec());
        (
            channels_with_history(observation.channels, &self.back_m),
            values,
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two runs of five snapshots half a metre apart; the second goes left.
    fn recording() -> Recording {
        let pose = |k: usize| match k {
            0..5 => Pose::new(0.5 * k as f64, 0.0, 0.0),
            _ => Pose::new(7.0, 0.5 * k as f64, std::f64::consts::FRAC_PI_2),
        };
        Recording::new(Columns {
            channels: vec![Channel {
                name: "rssi".into(),
                width: 2,
                unit: "dBm".into(),
                bearing_rad: None,
                maximum: None,
                offset_m: None,
            }],
            values: Array2::from_shape_fn((10, 2), |(k, i)| -((10 * k + i) as f32)),
            stamp_s: (0..10).map(f64::from).collect(),
            pose: (0..10).map(pose).collect(),
            odometry: (0..10).map(pose).collect(),
            run: (0..10).map(|k| k / 5).collect(),
            ..Columns::default()
        })
        .unwrap()
    }

    #[test]
    fn what_was_sensed_then_stands_beside_now_and_no_run_remembers_another() {
        let remembered = recording().with_history(&[0.5, 1.5]).unwrap();
        let names: Vec<&str> = remembered
            .channels()
            .iter()
            .map(|c| c.name.as_str())
            .collect();
        assert_eq!(
            names,
            ["rssi", "rssi@0.5m", "moved@0.5m", "rssi@1.5m", "moved@1.5m"]
        );
        let row = |k: usize| remembered.values().row(k).to_vec();
        assert_eq!(row(4)[..7], [-40.0, -41.0, -30.0, -31.0, -0.5, 0.0, 0.0]);
        assert_eq!(row(4)[7..], [-10.0, -11.0, -1.5, 0.0, 0.0]);
        // At a start nothing is remembered; half the distance back counts, less does not.
        assert!(row(5)[2..].iter().all(|v| v.is_nan()));
        assert!(row(6)[7..].iter().all(|v| v.is_nan()));
        assert_eq!(row(7)[7..9], [-50.0, -51.0]);
        // Behind the robot, wherever it heads.
        let behind: Vec<f32> = row(6)[4..7].to_vec();
        assert!((behind[0] + 0.5).abs() < 1e-6 && behind[1].abs() < 1e-6 && behind[2] == 0.0);
    }

    #[test]
    fn a_robot_remembers_as_a_recording_does() {
        let recording = recording();
        let remembered = recording.with_history(&[1.0]).unwrap();
        let mut past = Past::new(&[1.0]);
        for k in 0..10 {
            if k == 5 {
                past.forget();
            }
            let (channels, values) = past.observed(&recording.observation(k));
            assert_eq!(channels, remembered.channels());
            let same = |(a, b): (&f32, &f32)| a.to_bits() == b.to_bits();
            assert!(values.iter().zip(remembered.values().row(k)).all(same));
        }
    }

    #[test]
    fn a_robot_that_stands_remembers_no_more() {
        let mut past = Past::new(&[1.0]);
        for k in 0..5000 {
            past.with(&Pose::new(1e-6 * f64::from(k), 0.0, 0.0), &[0.0]);
        }
        assert!(past.sensed.len() < 50, "{}", past.sensed.len());
    }

    #[test]
    fn distances_that_make_no_sense_are_refused() {
        for wrong in [vec![0.0], vec![1.0, 1.0], vec![f64::NAN], vec![-1.0]] {
            let fault = recording().with_history(&wrong).unwrap_err();
            assert!(
                fault.is_usage() && fault.to_string().contains("rising distances"),
                "{fault}"
            );
        }
        let many: Vec<f64> = (1..=17).map(f64::from).collect();
        assert!(recording().with_history(&many).is_err());
        assert!((recording().spacing_m() - 0.5).abs() < 1e-12);
    }
}
