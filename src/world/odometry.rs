//! Dead reckoning: wheels that count a little too much or too little, the same way all through a run, and noise on top.

use crate::{
    error::{Error, Result},
    geometry::{Displacement, Pose},
    seed::Stream,
};
use rand::RngExt;
use rand_distr::StandardNormal;
use serde::{Deserialize, Serialize};

/// How odometry errs; assumed, for a synchro drive on a hard floor.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct OdometryConfig {
    /// Standard deviation, over runs, of the error in scale, metres a metre.
    pub translation_drift: f64,
    /// Standard deviation, over runs, of the steady turn that is not there, radians a metre.
    pub rotation_drift_rad_per_m: f64,
    /// Standard deviation of the random error in distance after a metre; grows with the square root.
    pub translation_noise_m: f64,
    /// Standard deviation of the random error in heading after a metre; grows with the square root.
    pub rotation_noise_rad: f64,
}

impl Default for OdometryConfig {
    fn default() -> Self {
        Self {
            translation_drift: 0.01,
            rotation_drift_rad_per_m: 0.003,
            translation_noise_m: 0.01,
            rotation_noise_rad: 0.01,
        }
    }
}

impl OdometryConfig {
    /// Checks every constant.
    ///
    /// # Errors
    /// A usage error that names the first one out of bounds.
    pub fn check(&self) -> Result<()> {
        let constants = [
            ("translation_drift", self.translation_drift),
            ("rotation_drift_rad_per_m", self.rotation_drift_rad_per_m),
            ("translation_noise_m", self.translation_noise_m),
            ("rotation_noise_rad", self.rotation_noise_rad),
        ];
        match constants
            .iter()
            .find(|(_, value)| !(*value >= 0.0 && value.is_finite()))
        {
            None => Ok(()),
            Some((key, value)) => Err(Error::usage(format!(
                "odometry: `{key}` is {value}; expected 0 or more"
            ))),
        }
    }
}

/// The odometry of one run.
///
/// ```
/// use ballmark::{geometry::Pose, seed::Seed, world::odometry::{DeadReckoning, OdometryConfig}};
/// let mut slip = Seed(1).stream("slip");
/// let mut odometry = DeadReckoning::draw(&OdometryConfig::default(), &mut slip);
/// odometry.reach(&Pose::new(5.0, 2.0, 0.0), &mut slip); // wherever a run starts, its odometry starts at the origin
/// let after_ten_metres = odometry.reach(&Pose::new(15.0, 2.0, 0.0), &mut slip);
/// assert!((after_ten_metres.x_m - 10.0).abs() < 1.0 && after_ten_metres.x_m != 10.0);
/// ```
#[derive(Debug, Clone)]
pub struct DeadReckoning {
    config: OdometryConfig,
    scale: f64,
    turn_rad_per_m: f64,
    /// True and dead-reckoned pose of the place last reached.
    last: Option<(Pose, Pose)>,
}

impl DeadReckoning {
    /// Draws how this run's wheels err.
    pub fn draw(config: &OdometryConfig, random: &mut Stream) -> Self {
        Self {
            config: config.clone(),
            scale: 1.0 + config.translation_drift * normal(random),
            turn_rad_per_m: config.rotation_drift_rad_per_m * normal(random),
            last: None,
        }
    }

    /// The dead-reckoned pose where the robot truly is at `pose`; the first one is the origin.
    pub fn reach(&mut self, pose: &Pose, random: &mut Stream) -> Pose {
        let reckoned = match self.last {
            None => Pose::default(),
            Some((truth, reckoned)) => {
                reckoned.after(self.measured(truth.displacement_to(pose), random))
            }
        };
        self.last = Some((*pose, reckoned));
        reckoned
    }

    /// A movement as the wheels count it. Noise grows with the square root of the way, so it adds up to the same
    /// however finely the way is cut.
    fn measured(&self, step: Displacement, random: &mut Stream) -> Displacement {
        let moved_m = step.distance_m();
        let root = moved_m.sqrt();
        let slip_m = self.config.translation_noise_m * normal(random) * root;
        let turned_rad = self.config.rotation_noise_rad * normal(random) * root;
        let stretch = self.scale + slip_m / moved_m.max(f64::MIN_POSITIVE);
        Displacement {
            forward_m: step.forward_m * stretch,
            left_m: step.left_m * stretch,
            turn_rad: step.turn_rad + self.turn_rad_per_m * moved_m + turned_rad,
        }
    }
}

fn normal(random: &mut Stream) -> f64 {
    random.sample(StandardNormal)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{geometry::wrapped, seed::Seed};

    fn sd(errors: &[f64]) -> f64 {
        (errors.iter().map(|error| error * error).sum::<f64>() / errors.len() as f64).sqrt()
    }

    /// Dead-reckoned ends of 2,000 runs, 39 m straight ahead in steps of half a metre.
    fn ends(config: &OdometryConfig) -> Vec<Pose> {
        let end = |run| {
            let mut slip = Seed(2).numbered_stream("slip", run);
            let mut odometry = DeadReckoning::draw(config, &mut slip);
            let places = (0..=78).map(|step| Pose::new(f64::from(step) * 0.5, 0.0, 0.0));
            places
                .map(|pose| odometry.reach(&pose, &mut slip))
                .last()
                .unwrap()
        };
        (0..2000).map(end).collect()
    }

    #[test]
    fn odometry_without_errors_is_the_truth() {
        let exact = OdometryConfig {
            translation_drift: 0.0,
            rotation_drift_rad_per_m: 0.0,
            translation_noise_m: 0.0,
            rotation_noise_rad: 0.0,
        };
        let mut slip = Seed(2).stream("slip");
        let mut odometry = DeadReckoning::draw(&exact, &mut slip);
        let start = Pose::new(3.0, -2.0, 1.0);
        for step in 0..50 {
            let t = f64::from(step) * 0.1;
            let truth = start.after(Displacement {
                forward_m: t,
                left_m: t * t,
                turn_rad: 3.0 * t,
            });
            let (reckoned, expected) = (
                odometry.reach(&truth, &mut slip),
                start.displacement_to(&truth),
            );
            assert!((reckoned.x_m - expected.forward_m).abs() < 1e-9);
            assert!((reckoned.y_m - expected.left_m).abs() < 1e-9);
            assert!(wrapped(reckoned.heading_rad - expected.turn_rad).abs() < 1e-9);
        }
    }

    #[test]
    fn odometry_drifts_as_stated() {
        let all = OdometryConfig::default();
        let only_scale = OdometryConfig {
            rotation_drift_rad_per_m: 0.0,
            rotation_noise_rad: 0.0,
            ..all.clone()
        };
        // √((0.01 · 39)² + 0.01² · 39) = 0.395 m
        let along = sd(&ends(&only_scale)
            .iter()
            .map(|end| end.x_m - 39.0)
            .collect::<Vec<_>>());
        assert!((along - 0.395).abs() < 0.025, "{along}");
        // √((0.003 · 39)² + 0.01² · 39) = 0.133 rad
        let turned = sd(&ends(&all)
            .iter()
            .map(|end| end.heading_rad)
            .collect::<Vec<_>>());
        assert!((turned - 0.133).abs() < 0.009, "{turned}");
    }
}
