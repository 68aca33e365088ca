//! Dead reckoning: wheels that count a little too much or too little, the same way all through a run, and noise on top;
//! headings from the wheels, or from a turret that a compass holds to north.

use crate::{
    error::{Error, Result},
    geometry::{Displacement, Pose, wrapped},
    seed::Stream,
};
use nalgebra::{Rotation2, Vector2};
use rand::RngExt;
use rand_distr::StandardNormal;
use serde::{Deserialize, Serialize};
use std::f64::consts::TAU;

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
    /// Is the heading that of the base against a turret held to north, instead of what the wheels count (Duckett &
    /// Nehmzow 1998, 5.2)? Then errors in heading are the turret's and don't add up; the rotation's constants are
    /// unused.
    pub by_compass: bool,
    /// Least and greatest further drift, as a share of the way driven: in each run the reckoned place
    /// creeps one way, however the robot turns, since the body of a synchro drive, and with it its faults, does not
    /// turn. Unlike an error in scale it doesn't cancel out around a closed route. Its direction is one of the building,
    /// whatever heading the wheels count.
    pub creep: [f64; 2],
}

impl Default for OdometryConfig {
    fn default() -> Self {
        Self {
            translation_drift: 0.01,
            rotation_drift_rad_per_m: 0.003,
            translation_noise_m: 0.01,
            rotation_noise_rad: 0.01,
            by_compass: false,
            creep: [0.0, 0.0],
        }
    }
}

impl OdometryConfig {
    /// A Nomad 200 whose turret the compass holds to north: no drift in rotation, and 2 to 5 % of the distance
    /// travelled in translation (Duckett & Nehmzow 1998, 5.2).
    pub fn by_compass() -> Self {
        Self {
            translation_drift: 0.0,
            by_compass: true,
            creep: [0.02, 0.05],
            ..Self::default()
        }
    }

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
        if let Some((key, value)) = constants
            .iter()
            .find(|(_, value)| !(*value >= 0.0 && value.is_finite()))
        {
            return Err(Error::usage(format!(
                "odometry: `{key}` is {value}; expected 0 or more"
            )));
        }
        let [least, most] = self.creep;
        if !(least >= 0.0 && least <= most && most < 1.0) {
            return Err(Error::usage(format!(
                "odometry: `creep` is [{least}, {most}]; expected two shares of the way in rising order, below 1"
            )));
        }
        Ok(())
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
    /// Drift of the reckoned place, metres a metre.
    creep: Vector2<f64>,
    /// The place last reached.
    last: Option<Reached>,
}

#[derive(Debug, Clone, Copy)]
struct Reached {
    truth: Pose,
    reckoned: Pose,
    turret_error_rad: f64,
}

impl DeadReckoning {
    /// Draws how this run's wheels err.
    pub fn draw(config: &OdometryConfig, random: &mut Stream) -> Self {
        Self {
            config: config.clone(),
            scale: 1.0 + config.translation_drift * normal(random),
            turn_rad_per_m: config.rotation_drift_rad_per_m * normal(random),
            creep: creep(config, random),
            last: None,
        }
    }

    /// The dead-reckoned pose where the robot truly is at `pose`; the first one is the origin. With `by_compass` the
    /// turret is taken to stand to north exactly.
    pub fn reach(&mut self, pose: &Pose, random: &mut Stream) -> Pose {
        self.reach_beside(pose, 0.0, random)
    }

    /// The same where the turret stands `turret_error_rad` counter-clockwise of north; without `by_compass` that makes
    /// no difference. With it, headings count from the plan's x axis as the compass has it, from the first pose on.
    pub fn reach_beside(
        &mut self,
        pose: &Pose,
        turret_error_rad: f64,
        random: &mut Stream,
    ) -> Pose {
        let by_compass = self.config.by_compass;
        // The base is where the turret is, turned by the angle between them; the turret is thought to stand to north.
        let held_rad = wrapped(pose.heading_rad - turret_error_rad);
        let mut reckoned = match self.last {
            None => Pose::default(),
            Some(last) => {
                let step = last.truth.displacement_to(pose);
                let mut from = last.reckoned;
                if by_compass {
                    // On the way the turret turns evenly from one error to the other.
                    let drifted_rad = wrapped(turret_error_rad - last.turret_error_rad) / 2.0;
                    from.heading_rad = wrapped(from.heading_rad - drifted_rad);
                }
                let mut reached = from.after(self.measured(step, random));
                // The body's faults keep their direction in the building, however far the wheels' heading is off.
                let astray_rad = last.reckoned.heading_rad - last.truth.heading_rad;
                let frame_rad = if by_compass { 0.0 } else { astray_rad };
                let crept = Rotation2::new(frame_rad) * self.creep * step.distance_m();
                reached.x_m += crept.x;
                reached.y_m += crept.y;
                reached
            }
        };
        if by_compass {
            reckoned.heading_rad = held_rad;
        }
        self.last = Some(Reached {
            truth: *pose,
            reckoned,
            turret_error_rad,
        });
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

/// A drift of this run's own size and direction. Where there is none, nothing is drawn either.
fn creep(config: &OdometryConfig, random: &mut Stream) -> Vector2<f64> {
    let [least, most] = config.creep;
    if most == 0.0 {
        return Vector2::zeros();
    }
    let share = least + (most - least) * random.random::<f64>();
    let angle_rad = TAU * random.random::<f64>();
    Vector2::new(angle_rad.cos(), angle_rad.sin()) * share
}

#[cfg(test)]
mod tests;
