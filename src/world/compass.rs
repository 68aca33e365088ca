//! A flux-gate compass, which steel and cables turn aside, differently from place to place and alike at one, and which sways and
//! drifts while the robot drives ([`super::unsteadiness`]).

use super::bounds::Bounds;
use crate::{
    error::Result,
    geometry::{Pose, wrapped},
    seed::Seed,
};
use nalgebra::Vector2;
use rand::{Rng, RngExt};
use rand_distr::StandardNormal;
use serde::{Deserialize, Serialize};
use std::f64::consts::{FRAC_PI_2, PI, TAU};

/// How the compass errs, and how a turret follows it.
///
/// The instrument is a KVH C-100, a flux-gate compass of the papers' years. Its data sheet, as Borenstein, Everett & Feng (*Where
/// am I?*, 1996) print it, states ±0.5° of accuracy and ±0.2° of repeatability; its manual, ten measurements a second by a core
/// that floats, since one mounted fast errs by "often more than 3 degrees" for each degree of tilt. Floating, it hangs by gravity
/// and acceleration together. Which compass the papers' robot had they do not tell.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct CompassConfig {
    /// Standard deviation of the distortion by what stands still in a building, over its places, radians. Bounded by Duckett &
    /// Nehmzow 1998, 5.2: all that the compass leaves of drift is 2 to 5 % of the way, and a greater one would bend a lap by more.
    pub distortion_sd_rad: f64,
    /// How fast it changes from place to place: at this distance its correlation is e^−½ = 0.61, metres. Iron's field changes
    /// over about the distance to it; assumed: steel in floors and walls, some 0.7 m from a compass on a robot beside a wall.
    pub correlation_m: f64,
    /// Standard deviation of a reading's noise, anew at each reading, radians (±0.2°).
    pub noise_rad: f64,
    /// Standard deviation of the angle by which the core hangs aside of the vertical while the robot drives, radians. Assumed:
    /// half a degree, which an acceleration of 0.09 m/s² makes.
    pub tilt_sd_rad: f64,
    /// How long a tilt lasts: its correlation falls to e^−1 in this time, seconds. Assumed.
    pub tilt_time_s: f64,
    /// How steeply the earth's field points into the ground, radians: a tilt turns the reading by its tangent times as much. 68° at
    /// Manchester.
    pub dip_rad: f64,
    /// Standard deviation of a slow error: iron that is carried past, currents, the core's own magnetism, radians (±0.5°).
    pub drift_sd_rad: f64,
    /// How long it lasts, as `tilt_time_s`, seconds. Assumed.
    pub drift_time_s: f64,
    /// Where north is in the plan, radians counter-clockwise from the x axis.
    pub north_rad: f64,
    /// A turret held to the compass makes up for 63 % of its error in this time, seconds. Assumed, of "small speeds" that
    /// "smooth out local variations" (Duckett & Nehmzow 1998, 5.1).
    pub turret_time_s: f64,
    /// And turns no faster than this, radians a second. Assumed.
    pub turret_rad_per_s: f64,
}

impl Default for CompassConfig {
    fn default() -> Self {
        Self {
            distortion_sd_rad: 0.07,
            correlation_m: 0.7,
            noise_rad: 0.0035,
            tilt_sd_rad: 0.0087,
            tilt_time_s: 1.0,
            dip_rad: 1.19,
            drift_sd_rad: 0.0087,
            drift_time_s: 60.0,
            north_rad: FRAC_PI_2,
            turret_time_s: 5.0,
            turret_rad_per_s: 0.1,
        }
    }
}

impl CompassConfig {
    /// A compass without chance in it: nothing but what stands still in a building turns it aside.
    pub fn steady(self) -> Self {
        Self {
            noise_rad: 0.0,
            tilt_sd_rad: 0.0,
            drift_sd_rad: 0.0,
            ..self
        }
    }

    /// Checks every constant.
    ///
    /// # Errors
    /// A usage error that names the first one out of bounds.
    pub fn check(&self) -> Result<()> {
        let bounds = Bounds("compass");
        for (key, value) in [
            ("distortion_sd_rad", self.distortion_sd_rad),
            ("noise_rad", self.noise_rad),
            ("tilt_sd_rad", self.tilt_sd_rad),
            ("drift_sd_rad", self.drift_sd_rad),
        ] {
            if !(0.0..=PI).contains(&value) {
                return bounds.wrong(key, value, "0 to π");
            }
        }
        bounds.positive(&[
            ("correlation_m", self.correlation_m),
            ("tilt_time_s", self.tilt_time_s),
            ("drift_time_s", self.drift_time_s),
            ("turret_time_s", self.turret_time_s),
            ("turret_rad_per_s", self.turret_rad_per_s),
        ])?;
        if !(-STEEPEST_RAD..=STEEPEST_RAD).contains(&self.dip_rad) {
            return bounds.wrong("dip_rad", self.dip_rad, "-1.5 to 1.5");
        }
        if !(-TAU..=TAU).contains(&self.north_rad) {
            return bounds.wrong("north_rad", self.north_rad, "-2π to 2π");
        }
        Ok(())
    }
}

/// Nearer to a pole than this no compass tells anything, radians.
const STEEPEST_RAD: f64 = 1.5;

/// Waves that make up the distortion: enough that it is normally distributed.
const WAVES: usize = 32;

/// The compass of a robot in one building.
///
/// Its distortion is a sum of plane waves of random direction, length and phase; with wave vectors drawn from a normal
/// distribution of standard deviation 1 / ℓ the correlation of two places d apart is exp(−d² / 2ℓ²) (Rahimi & Recht,
/// *Random features for large-scale kernel machines*, 2007).
///
/// ```
/// use ballmark::{geometry::Pose, seed::Seed, world::compass::{Compass, CompassConfig}};
/// let compass = Compass::new(CompassConfig::default().steady(), Seed(1))?;
/// let mut random = Seed(1).stream("noise");
/// let mut error_rad = |x_m: f64| compass.read(&Pose::new(x_m, 0.0, 1.0), &mut random) - 1.0;
/// assert_eq!(error_rad(2.0), error_rad(2.0)); // always alike at one place
/// assert!((error_rad(2.0) - error_rad(2.01)).abs() < 0.01 && error_rad(2.0) != error_rad(9.0));
/// # Ok::<(), ballmark::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Compass {
    config: CompassConfig,
    waves: Vec<Wave>,
}

#[derive(Debug, Clone, Copy, PartialEq)]
struct Wave {
    /// Radians a metre along x and y.
    per_m: Vector2<f64>,
    phase_rad: f64,
}

impl Compass {
    /// The compass with the distortion that the seed gives the building.
    ///
    /// # Errors
    /// A usage error that names the first constant out of bounds.
    pub fn new(config: CompassConfig, seed: Seed) -> Result<Self> {
        config.check()?;
        let mut random = seed.stream("world/compass");
        let waves = (0..WAVES).map(|_| Wave {
            per_m: Vector2::new(random.sample(StandardNormal), random.sample(StandardNormal))
                / config.correlation_m,
            phase_rad: TAU * random.random::<f64>(),
        });
        let waves = waves.collect();
        Ok(Self { config, waves })
    }

    /// The constants.
    pub fn config(&self) -> &CompassConfig {
        &self.config
    }

    /// How far a reading at a place is turned counter-clockwise of the truth, radians.
    pub fn distortion_rad(&self, pose: &Pose) -> f64 {
        let place = Vector2::new(pose.x_m, pose.y_m);
        let heights = self
            .waves
            .iter()
            .map(|wave| (wave.per_m.dot(&place) + wave.phase_rad).cos());
        self.config.distortion_sd_rad * (2.0 / WAVES as f64).sqrt() * heights.sum::<f64>()
    }

    /// The heading of whatever carries the compass, as the compass has it while it neither sways nor drifts: counter-clockwise from
    /// the plan's x axis, in (−π, π]. With its [unsteadiness](super::unsteadiness) it is the `compass_rad` of a recording.
    pub fn read(&self, pose: &Pose, random: &mut impl Rng) -> f64 {
        let normal: f64 = random.sample(StandardNormal);
        wrapped(pose.heading_rad + self.distortion_rad(pose) + self.config.noise_rad * normal)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn distortion_has_the_stated_size_and_reach() {
        let n = 20_000;
        let at = |x_m: f64, y_m: f64| Pose::new(x_m, y_m, 0.0);
        let places = [at(1.0, 2.0), at(1.7, 2.0), at(1.0, 1.3), at(3.3, 2.0)];
        let config = CompassConfig::default();
        let fields = (0..n).map(|seed| {
            let compass = Compass::new(config.clone(), Seed(seed)).unwrap();
            places.map(|place| compass.distortion_rad(&place))
        });
        let mut products = [0.0; 4];
        let mut mean = 0.0;
        for field in fields {
            mean += field[0] / n as f64;
            for (product, value) in products.iter_mut().zip(field) {
                *product += field[0] * value / n as f64;
            }
        }
        assert!(
            mean.abs() < 4.0 * 0.07 / f64::from(n as u32).sqrt(),
            "{mean}"
        );
        assert!((products[0].sqrt() - 0.07).abs() < 0.001, "{products:?}");
        // 0.7 m away along x or y: e^−½; 2.3 m away: e^(−5.29/0.98) = 0.0045.
        for (product, expected) in products[1..].iter().zip([0.6065, 0.6065, 0.0045]) {
            assert!(
                (product / products[0] - expected).abs() < 0.03,
                "{products:?}"
            );
        }
    }

    #[test]
    fn noise_has_the_stated_statistics_and_readings_wrap() {
        let config = CompassConfig {
            distortion_sd_rad: 0.0,
            noise_rad: 0.02,
            ..CompassConfig::default()
        };
        let (compass, n) = (Compass::new(config, Seed(3)).unwrap(), 100_000);
        let mut random = Seed(4).stream("noise");
        let pose = Pose::new(5.0, 1.0, PI);
        let errors: Vec<f64> = (0..n)
            .map(|_| {
                let read = compass.read(&pose, &mut random);
                assert!(read > -PI && read <= PI);
                wrapped(read - PI)
            })
            .collect();
        let mean = errors.iter().sum::<f64>() / f64::from(n);
        let sd = (errors.iter().map(|error| error * error).sum::<f64>() / f64::from(n)).sqrt();
        // 4 standard errors
        assert!(
            mean.abs() < 0.00026 && (sd - 0.02).abs() < 0.00018,
            "{mean} ± {sd}"
        );
    }

    #[test]
    fn constants_out_of_bounds_are_told_by_name() {
        type Case = (&'static str, fn(&mut CompassConfig));
        let cases: [Case; 12] = [
            ("distortion_sd_rad", |c| c.distortion_sd_rad = -0.1),
            ("noise_rad", |c| c.noise_rad = f64::NAN),
            ("correlation_m", |c| c.correlation_m = 0.0),
            ("correlation_m", |c| c.correlation_m = f64::INFINITY),
            ("turret_time_s", |c| c.turret_time_s = 0.0),
            ("turret_rad_per_s", |c| c.turret_rad_per_s = -1.0),
            ("north_rad", |c| c.north_rad = f64::NAN),
            ("tilt_sd_rad", |c| c.tilt_sd_rad = -0.1),
            ("tilt_time_s", |c| c.tilt_time_s = 0.0),
            ("dip_rad", |c| c.dip_rad = 1.57),
            ("drift_sd_rad", |c| c.drift_sd_rad = f64::NAN),
            ("drift_time_s", |c| c.drift_time_s = -1.0),
        ];
        for (key, change) in cases {
            let mut config = CompassConfig::default();
            change(&mut config);
            let error = Compass::new(config, Seed(1)).unwrap_err();
            assert!(
                error.is_usage() && error.to_string().contains(&format!("`{key}`")),
                "{error}"
            );
        }
        assert!(toml::from_str::<CompassConfig>("declination = 1").is_err());
    }
}
