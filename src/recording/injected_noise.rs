//! A recording as a worse odometry and noisier range sensors would have made it: the noise that Ruiz-Mayor et al. (2006, R06) inject to
//! see what a correction makes of it.

use super::{Columns, Recording};
use crate::{
    error::{Error, Result},
    geometry::Displacement,
    seed::{Seed, Stream},
};
use rand::RngExt;
use rand_distr::{Distribution, StandardNormal};
use serde::{Deserialize, Serialize};
use std::fmt;

/// Noise put on all that is tested on: on odometry, so that a localiser's prior estimates are worse (R06 3.4, 4.2), and on ranges, so
/// that it perceives worse (3.4). What is learned from, and what evidence is tuned on, has none of it, nor does a filter's motion model
/// know of it, unless it is said to.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct InjectedNoise {
    /// Odometry is off by up to this many metres, uniform over a disc, once in `every_m` of the way …
    pub odometry_m: f64,
    /// … and by up to this many degrees.
    pub odometry_deg: f64,
    /// Metres of way, as odometry has it, from one such error to the next; errors add up. As far apart as R06's estimates, and as
    /// the steps of localisation trials: then each prior has one.
    pub every_m: f64,
    /// Standard deviation of normal noise on every reading in metres; what did not come back stays missing.
    pub range_m: f64,
}

impl Default for InjectedNoise {
    fn default() -> Self {
        Self {
            odometry_m: 0.0,
            odometry_deg: 0.0,
            every_m: 0.5,
            range_m: 0.0,
        }
    }
}

impl InjectedNoise {
    /// # Errors
    /// A usage error where a value makes no sense; the message names the key.
    pub fn check(&self) -> Result<()> {
        for (key, value, most) in [
            ("odometry_m", self.odometry_m, f64::MAX),
            ("odometry_deg", self.odometry_deg, 180.0),
            ("range_m", self.range_m, f64::MAX),
        ] {
            if !(0.0..=most).contains(&value) {
                return Err(Error::usage(format!(
                    "degraded.noise.{key} = {value}: expected 0 or more{}",
                    if most == 180.0 { ", at most 180" } else { "" }
                )));
            }
        }
        if !(self.every_m.is_finite() && self.every_m > 0.0) {
            return Err(Error::usage(format!(
                "degraded.noise.every_m = {}: expected metres, more than 0",
                self.every_m
            )));
        }
        Ok(())
    }

    /// Is there none at all?
    pub fn is_none(&self) -> bool {
        self.odometry_m == 0.0 && self.odometry_deg == 0.0 && self.range_m == 0.0
    }
}

/// An error of position and heading, uniform over a disc of this radius in metres, and within so many degrees either way.
pub(crate) fn uniform_error(radius_m: f64, most_deg: f64, random: &mut Stream) -> Displacement {
    let [x, y] = loop {
        let [x, y] = [0; 2].map(|_| random.random_range(-1.0..=1.0_f64));
        if x * x + y * y <= 1.0 {
            break [x, y];
        }
    };
    let turn_deg = most_deg * random.random_range(-1.0..=1.0_f64);
    Displacement {
        forward_m: radius_m * x,
        left_m: radius_m * y,
        turn_rad: turn_deg.to_radians(),
    }
}

impl fmt::Display for InjectedNoise {
    /// "odometry off by up to 0.4 m and 40° every 0.5 m, ranges by 0.1 m".
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let is_odometry = self.odometry_m > 0.0 || self.odometry_deg > 0.0;
        if is_odometry {
            write!(
                f,
                "odometry off by up to {} m and {}° every {} m",
                self.odometry_m, self.odometry_deg, self.every_m
            )?;
        }
        if self.range_m > 0.0 {
            let between = if is_odometry { ", " } else { "" };
            write!(f, "{between}ranges by {} m (1 sd)", self.range_m)?;
        }
        if self.is_none() {
            f.write_str("none")?;
        }
        Ok(())
    }
}

impl Recording {
    /// The recording with noise on odometry and readings of some snapshots, ascending. Poses, order and all other snapshots' readings
    /// stay as they are; the same seed gives the same noise.
    ///
    /// ```
    /// use ballmark::{recording::injected_noise::InjectedNoise, seed::Seed, world::corridor};
    /// let config = corridor::CorridorConfig { runs: 1, spacing_m: 0.5 };
    /// let clean = corridor::thrun1998(Seed(1), &config)?;
    /// let noise = InjectedNoise { odometry_m: 0.4, ..InjectedNoise::default() };
    /// let noisy = clean.with_noise(&[10, 11, 12], &noise, Seed(1))?;
    /// let step = |recording: &ballmark::recording::Recording, k: usize| {
    ///     recording.observation(k - 1).odometry.displacement_to(&recording.observation(k).odometry)
    /// };
    /// assert!((step(&noisy, 9).forward_m - step(&clean, 9).forward_m).abs() < 1e-12);
    /// assert!((step(&noisy, 11).forward_m - step(&clean, 11).forward_m).abs() > 1e-3);
    /// assert_eq!(noisy.poses(), clean.poses());
    /// # Ok::<(), ballmark::Error>(())
    /// ```
    ///
    /// # Errors
    /// A usage error where a value makes no sense; an error where ranges shall have noise and no channel is in metres.
    pub fn with_noise(
        &self,
        snapshots: &[usize],
        noise: &InjectedNoise,
        seed: Seed,
    ) -> Result<Recording> {
        noise.check()?;
        if noise.range_m > 0.0 && !self.channels().iter().any(|channel| channel.unit == "m") {
            return Err(Error::work(
                "degraded.noise.range_m: no channel is in metres; expected a range sensor",
            ));
        }
        let mut columns = self.columns().clone();
        if noise.odometry_m > 0.0 || noise.odometry_deg > 0.0 {
            disturb_odometry(self, &mut columns, snapshots, noise, seed);
        }
        if noise.range_m > 0.0 {
            for &k in snapshots {
                let mut random = seed.numbered_stream("noise on ranges", k as u64);
                disturb_ranges(&mut columns, k, noise.range_m, &mut random);
            }
        }
        columns.noise = Some(noise.clone());
        Recording::new(columns)
    }
}

/// Adds up errors along the way: one wherever odometry has gone `every_m` on through these snapshots.
fn disturb_odometry(
    recording: &Recording,
    columns: &mut Columns,
    snapshots: &[usize],
    noise: &InjectedNoise,
    seed: Seed,
) {
    let clean = |k: usize| recording.observation(k).odometry;
    for run in recording.runs() {
        let mut since_m = 0.0;
        for k in run.start + 1..run.end {
            let moved = clean(k - 1).displacement_to(&clean(k));
            let mut pose = columns.odometry[k - 1].after(moved);
            if snapshots.binary_search(&k).is_ok() {
                since_m += moved.distance_m();
                let mut random = seed.numbered_stream("noise on odometry", k as u64);
                // A hair less: steps of exactly that length have one error each, however their sum is rounded. Where the log
                // leaps, errors of more way than this make no difference that a robot could still recover from.
                let due = ((since_m / noise.every_m + 1e-9).floor() as usize).min(MOST_AT_ONCE);
                for _ in 0..due {
                    let (radius_m, most_deg) = (noise.odometry_m, noise.odometry_deg);
                    pose = pose.after(uniform_error(radius_m, most_deg, &mut random));
                }
                if due > 0 {
                    since_m = (since_m - due as f64 * noise.every_m).clamp(0.0, noise.every_m);
                }
            }
            columns.odometry[k] = pose;
        }
    }
}

/// Most errors between two snapshots.
const MOST_AT_ONCE: usize = 1000;

fn disturb_ranges(columns: &mut Columns, k: usize, range_m: f64, random: &mut Stream) {
    let mut row = columns.values.row_mut(k);
    let mut first = 0;
    for channel in &columns.channels {
        let most_m = channel.maximum.unwrap_or(f64::from(f32::MAX));
        for value in first..first + channel.width {
            let off: f64 = StandardNormal.sample(random); // drawn for every value, so that none depends on others
            if channel.unit == "m" && row[value].is_finite() {
                let noisy_m = f64::from(row[value]) + range_m * off;
                row[value] = noisy_m.clamp(0.0, most_m) as f32;
            }
        }
        first += channel.width;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        geometry::{Pose, wrapped},
        recording::Channel,
    };
    use ndarray::Array2;

    /// Two runs of 100 snapshots, 0.25 m apart; two ranges to 5 m and a light sensor.
    fn recording() -> Recording {
        let channel = |name: &str, unit: &str, width, maximum| Channel {
            name: name.into(),
            width,
            unit: unit.into(),
            bearing_rad: None,
            maximum,
            offset_m: None,
        };
        let pose: Vec<Pose> = (0..200)
            .map(|k| Pose::new(0.25 * f64::from(k % 100), 0.0, 0.3))
            .collect();
        let mut values = Array2::from_elem((200, 3), 2.0_f32);
        values[(150, 0)] = f32::NAN;
        values.column_mut(1).fill(4.95);
        Recording::new(Columns {
            channels: vec![
                channel("sonar", "m", 2, Some(5.0)),
                channel("light", "lux", 1, None),
            ],
            values,
            stamp_s: (0..200).map(f64::from).collect(),
            odometry: pose.clone(),
            pose,
            run: (0..200).map(|k| k / 100).collect(),
            ..Columns::default()
        })
        .unwrap()
    }

    fn errors(noisy: &Recording, range: std::ops::Range<usize>) -> Vec<Displacement> {
        let clean = recording();
        let moved = |of: &Recording, k: usize| {
            let odometry = |k| of.observation(k).odometry;
            odometry(k - 1).displacement_to(&odometry(k))
        };
        range
            .map(|k| {
                let at = |of: Displacement| Pose::new(of.forward_m, of.left_m, of.turn_rad);
                at(moved(&clean, k)).displacement_to(&at(moved(noisy, k)))
            })
            .collect()
    }

    #[test]
    fn odometry_errs_once_in_so_many_metres_and_within_the_limits() {
        let noise = InjectedNoise {
            odometry_m: 0.4,
            odometry_deg: 40.0,
            ..InjectedNoise::default()
        };
        let tested: Vec<usize> = (100..200).collect();
        let noisy = recording().with_noise(&tested, &noise, Seed(3)).unwrap();
        let is_error = |e: &Displacement| e.distance_m() > 1e-9 || e.turn_rad.abs() > 1e-9;
        assert!(!errors(&noisy, 1..100).iter().any(is_error));
        let all = errors(&noisy, 101..200);
        // Every second step of 0.25 m.
        let there: Vec<usize> = (0..99).filter(|&k| is_error(&all[k])).collect();
        assert_eq!(there, (1..99).step_by(2).collect::<Vec<_>>());
        let largest_m = all.iter().map(|e| e.distance_m()).fold(0.0, f64::max);
        let largest_deg = all.iter().map(|e| wrapped(e.turn_rad).abs().to_degrees());
        let largest_deg = largest_deg.fold(0.0, f64::max);
        assert!((0.3..=0.4).contains(&largest_m), "{largest_m}");
        assert!((30.0..=40.0).contains(&largest_deg), "{largest_deg}");
        assert_eq!(noisy.poses(), recording().poses());
        let once_more = recording().with_noise(&tested, &noise, Seed(3)).unwrap();
        assert_eq!(once_more.columns().odometry, noisy.columns().odometry);
        let told = noisy.columns().noise.as_ref().unwrap().to_string();
        assert_eq!(told, "odometry off by up to 0.4 m and 40° every 0.5 m");
    }

    #[test]
    fn ranges_alone_are_disturbed_and_missing_ones_stay_so() {
        let noise = InjectedNoise {
            range_m: 0.2,
            ..InjectedNoise::default()
        };
        let tested: Vec<usize> = (100..200).collect();
        let noisy = recording().with_noise(&tested, &noise, Seed(3)).unwrap();
        let column = |c: usize| noisy.values().column(c).to_vec();
        assert_eq!(column(0)[..100], [2.0; 100]);
        assert!(column(0)[150].is_nan());
        let off: Vec<f64> = (100..200)
            .filter(|&k| k != 150)
            .map(|k| f64::from(column(0)[k]) - 2.0)
            .collect();
        let sd = (off.iter().map(|off| off * off).sum::<f64>() / 99.0).sqrt();
        assert!((0.15..0.25).contains(&sd), "{sd}");
        assert!(column(1).iter().all(|range| *range <= 5.0));
        assert_eq!(column(2), [2.0; 200]);
        assert_eq!(noisy.columns().odometry, recording().columns().odometry);
    }

    #[test]
    fn senseless_noise_is_refused_by_name() {
        let refused = |change: fn(&mut InjectedNoise), key: &str| {
            let mut noise = InjectedNoise::default();
            change(&mut noise);
            let fault = recording().with_noise(&[1], &noise, Seed(1)).unwrap_err();
            assert!(
                fault.is_usage() && fault.to_string().contains(key),
                "{fault}"
            );
        };
        refused(|n| n.odometry_m = -1.0, "noise.odometry_m = -1");
        refused(|n| n.odometry_deg = 181.0, "at most 180");
        refused(|n| n.range_m = f64::NAN, "noise.range_m = NaN");
        refused(|n| n.every_m = 0.0, "noise.every_m = 0");
        let lux = recording().into_columns();
        let light = Columns {
            channels: vec![lux.channels[1].clone()],
            values: lux.values.select(ndarray::Axis(1), &[2]),
            ..lux
        };
        let noise = InjectedNoise {
            range_m: 0.1,
            ..InjectedNoise::default()
        };
        let fault = Recording::new(light)
            .unwrap()
            .with_noise(&[1], &noise, Seed(1))
            .unwrap_err();
        assert!(fault.to_string().contains("no channel is in metres"));
    }
}
