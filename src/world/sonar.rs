//! A ring of sonars: cones of rays that come back from surfaces met head-on, from corners, or not at all.

mod config;
mod crosstalk;
mod echo;
mod loudness;
mod nearest;
#[cfg(test)]
mod tests;

pub use config::SonarConfig;

use super::Surroundings;
use crate::{
    error::Result,
    geometry::{Pose, wrapped},
    recording::Channel,
};
use config::speed_of_sound_m_per_s;
use echo::{Transducer, nearest_echo_m};
use rand::{Rng, RngExt};
use rand_distr::StandardNormal;
use std::f64::consts::TAU;

/// A ring of sonars whose constants have been checked.
///
/// Surfaces are mirrors beyond their critical angle; right-angled corners throw sound back to the sender (Kuc & Siegel
/// 1987). Near the threshold echoes come and go, where the constants say so. A sonar reports the nearest echo of its cone, its own or, where several fire in turn, another's.
///
/// ```
/// use ballmark::{geometry::Pose, world::{floor_plan::round, FloorPlan, Material, Raycaster, Sonar, SonarConfig}};
/// use nalgebra::Point2;
/// let brick = Material { reflectivity: 1.0, critical_angle_rad: 0.3, ..Material::PLAIN };
/// let caster = Raycaster::new(FloorPlan::new(round(Point2::origin(), 3.0, 48, brick))?);
/// let sonar = Sonar::new(SonarConfig::default())?;
/// let ahead_m = sonar.echo_m(&(&caster).into(), &Pose::default(), 0).unwrap();
/// assert!((ahead_m - (3.0 - 0.26)).abs() < 0.01); // the tower's wall, from the transducer
/// # Ok::<(), ballmark::Error>(())
/// ```
///
/// A detailed scan, nine sets of 16 readings while the turret turns by 2.5° at a time:
///
/// ```
/// # use ballmark::world::{Sonar, SonarConfig};
/// let sonar = Sonar::new(SonarConfig { detailed: 9, ..SonarConfig::nomad200() })?;
/// assert_eq!(sonar.channel().width, 144);
/// assert!((sonar.bearing_rad(1).to_degrees() - 2.5).abs() < 1e-12);
/// # Ok::<(), ballmark::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Sonar {
    config: SonarConfig,
    /// When each sonar fires, where they don't wait for quiet air.
    pulse_times_s: Option<Vec<f64>>,
}

/// The random numbers of one reading: the same four draws for each, so that what happens to one reading never shifts the
/// next one's.
#[derive(Debug, Clone, Copy)]
struct Chance {
    aside_normal: f64,
    outcome: f64,
    place: f64,
    range_normal: f64,
}

impl Chance {
    fn draw(random: &mut impl Rng) -> Self {
        let aside_normal = random.sample(StandardNormal);
        let (outcome, place): (f64, f64) = (random.random(), random.random());
        let range_normal = random.sample(StandardNormal);
        Self {
            aside_normal,
            outcome,
            place,
            range_normal,
        }
    }
}

impl Sonar {
    /// A ring of these constants.
    ///
    /// # Errors
    /// A usage error that names the first constant out of bounds.
    pub fn new(config: SonarConfig) -> Result<Self> {
        config.check()?;
        let pulse_times_s = config.pulse_times_s();
        Ok(Self {
            config,
            pulse_times_s,
        })
    }

    /// The constants.
    pub fn config(&self) -> &SonarConfig {
        &self.config
    }

    /// The channel that its readings make.
    pub fn channel(&self) -> Channel {
        let width = self.width();
        Channel {
            name: "sonar".into(),
            width,
            unit: "m".into(),
            bearing_rad: Some((0..width).map(|value| self.bearing_rad(value)).collect()),
            maximum: Some(self.config.maximum_m),
            offset_m: (self.config.ring_radius_m > 0.0)
                .then(|| vec![self.config.ring_radius_m; width]),
        }
    }

    /// Number of readings in a scan.
    fn width(&self) -> usize {
        self.config.beams * self.config.detailed
    }

    /// Direction of a reading in the robot's frame, in (−π, π]. Readings go round counter-clockwise: number
    /// `sonar · detailed + set` is that of a sonar in a set.
    pub fn bearing_rad(&self, value: usize) -> f64 {
        wrapped(TAU * value as f64 / self.width() as f64)
    }

    /// One scan at a pose, with noise, `[value]`: metres, NaN = no return.
    pub fn read(&self, around: &Surroundings, pose: &Pose, random: &mut impl Rng) -> Vec<f32> {
        let (beams, sets) = (self.config.beams, self.config.detailed);
        let mut readings = vec![f32::NAN; self.width()];
        for set in 0..sets {
            let chances: Vec<Chance> = (0..beams).map(|_| Chance::draw(random)).collect();
            let ring: Vec<Transducer> = (0..beams)
                .zip(&chances)
                .map(|(beam, chance)| {
                    let aside_rad = chance.aside_normal * self.config.axis_sd_rad;
                    Transducer {
                        fade_db: self.fade_db(random),
                        ..self.transducer(pose, beam * sets + set, aside_rad)
                    }
                })
                .collect();
            let mut echoes_m: Vec<Option<f64>> = ring
                .iter()
                .map(|transducer| self.nearest_m(around, transducer))
                .collect();
            if let Some(times_s) = &self.pulse_times_s {
                crosstalk::add(around, &self.config, &ring, times_s, &mut echoes_m);
            }
            for (beam, (echo_m, chance)) in echoes_m.into_iter().zip(&chances).enumerate() {
                if let Some(metres) = self.corrupted(echo_m, chance) {
                    readings[beam * sets + set] = metres as f32;
                }
            }
        }
        readings
    }

    /// The nearest echo of its own that makes a reading, without noise, in metres from the transducer.
    pub fn echo_m(&self, around: &Surroundings, pose: &Pose, value: usize) -> Option<f64> {
        self.nearest_m(around, &self.transducer(pose, value, 0.0))
    }

    /// How much louder than usual a reading's echoes are, dB. Where nothing fades, nothing is drawn either.
    fn fade_db(&self, random: &mut impl Rng) -> f64 {
        match self.config.fading_db {
            0.0 => 0.0,
            fading_db => {
                let normal: f64 = random.sample(StandardNormal);
                fading_db * normal
            }
        }
    }

    /// The transducer of a reading, its cone turned aside of where it is mounted.
    fn transducer(&self, pose: &Pose, value: usize, aside_rad: f64) -> Transducer {
        let mounted_rad = self.bearing_rad(value);
        Transducer::mounted(
            pose,
            self.config.ring_radius_m,
            mounted_rad,
            mounted_rad + aside_rad,
        )
    }

    fn nearest_m(&self, around: &Surroundings, transducer: &Transducer) -> Option<f64> {
        if self.config.plain {
            nearest::in_cone_m(around, &self.config, transducer)
        } else {
            nearest_echo_m(around, &self.config, transducer)
        }
    }

    /// What the sensor reports of an echo.
    fn corrupted(&self, echo_m: Option<f64>, chance: &Chance) -> Option<f64> {
        let c = &self.config;
        // In warmer air than it is calibrated for, sound is back sooner and the wall seems nearer.
        let seeming =
            speed_of_sound_m_per_s(c.calibrated_celsius) / speed_of_sound_m_per_s(c.air_celsius);
        let echo_m = echo_m.map(|metres| metres * seeming);
        if chance.outcome < c.short_probability {
            let range_m = echo_m.unwrap_or(c.maximum_m).max(c.minimum_m);
            return Some(c.minimum_m + chance.place * (range_m - c.minimum_m));
        }
        if chance.outcome >= 1.0 - c.lost_probability {
            return None;
        }
        let range_m = echo_m?;
        let noisy_m = range_m + chance.range_normal * (c.noise_m + c.noise_per_m * range_m);
        let stepped_m = if c.resolution_m > 0.0 {
            (noisy_m / c.resolution_m).round() * c.resolution_m
        } else {
            noisy_m
        };
        (stepped_m < c.maximum_m).then_some(stepped_m.max(c.minimum_m))
    }
}
