//! Wall following: a reactive robot that keeps a wall at its side, at a distance, by what its ranges say.
//!
//! "A reactive wall-following strategy was used for exploration" (Duckett & Nehmzow 1998, 6.2), without a map and
//! without a plan: every two centimetres the robot turns by what is nearest on that side, so that it cuts short what it
//! would not fit into, goes round corners and into niches, and never drives quite the same way.

use super::{
    Raycaster, RobotConfig,
    driving::Wander,
    way::{STEP_M, Way},
};
use crate::{
    error::{Error, Result},
    geometry::{Displacement, Pose, wrapped},
    seed::{Seed, Stream},
};
use nalgebra::{Point2, Vector2};
use rand::RngExt;
use rand_distr::StandardNormal;
use std::f64::consts::FRAC_PI_2;

/// Where and how a wall is followed.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Following {
    /// Where the robot starts, and which way it faces.
    pub(super) start: Pose,
    /// Is the wall on its left?
    pub(super) left: bool,
    /// Way from its rim to the wall, metres.
    pub(super) distance_m: f64,
}

/// Directions it looks in, radians from straight ahead towards the wall, and how far, metres.
const LOOKS: std::ops::RangeInclusive<i32> = -10..=50;
const LOOK_RAD: f64 = 3.0 * std::f64::consts::PI / 180.0;
const REACH_M: f64 = 6.0;
/// What is nearer to straight ahead than this, or beyond, counts only where it is in the way.
const AHEAD_RAD: f64 = 0.35;
/// It comes back to its distance within about this way, critically damped, metres.
const SETTLE_M: f64 = 0.4;
/// Errors of distance beyond this turn it no more, so that it nears a wall at a slant, not head-on, metres.
const MAX_ERROR_M: f64 = 0.35;
/// The sharpest turn, radians a metre.
const MAX_TURN_PER_M: f64 = 10.0;
/// Way after the start by which it has settled beside the wall, metres.
const SETTLED_M: f64 = 2.0;
/// It has come round where it passes the place at which it had settled, this near and facing as much alike.
const ROUND_M: f64 = 1.5;
const ROUND_RAD: f64 = 1.0;
/// It is lost where it has not come round after this way, or nears nothing of its way round for that long, metres.
const MAX_ROUND_M: f64 = 5000.0;
const MAX_LOST_M: f64 = 60.0;
/// How far along the way round the robot's place is looked for, metres either way.
const LOOK_ALONG_M: f64 = 2.0;

impl Following {
    /// The same wall, followed the other way.
    pub(super) fn back(self) -> Self {
        let heading_rad = wrapped(self.start.heading_rad + std::f64::consts::PI);
        Self {
            start: Pose {
                heading_rad,
                ..self.start
            },
            left: !self.left,
            ..self
        }
    }

    /// Radians to turn left in the next metre, by what is nearest on the wall's side of the robot.
    fn turn_per_m(&self, caster: &Raycaster, pose: &Pose, wanted_m: f64, error: LookError) -> f64 {
        let towards = if self.left { 1.0 } else { -1.0 };
        let place = Point2::new(pose.x_m, pose.y_m);
        let nearest = LOOKS
            .filter_map(|look| {
                let aside_rad = f64::from(look) * LOOK_RAD;
                let angle_rad = pose.heading_rad + towards * aside_rad;
                let direction = Vector2::new(angle_rad.cos(), angle_rad.sin());
                let range_m = caster.cast(&place, &direction, REACH_M)?.distance_m;
                (aside_rad > AHEAD_RAD || range_m < wanted_m).then_some((range_m, aside_rad))
            })
            .min_by(|a, b| a.0.total_cmp(&b.0));
        let turn = match nearest {
            // Nothing near: it looks for the wall where it was.
            None => 1.0 / wanted_m,
            Some((range_m, aside_rad)) => {
                let range_m = range_m + error.range_m;
                let aside_rad = aside_rad + error.bearing_rad;
                let error_m = (range_m - wanted_m).clamp(-MAX_ERROR_M, MAX_ERROR_M);
                2.0 / SETTLE_M * (aside_rad - FRAC_PI_2) + error_m / (SETTLE_M * SETTLE_M)
            }
        };
        towards * turn.clamp(-MAX_TURN_PER_M, MAX_TURN_PER_M)
    }

    fn step(&self, caster: &Raycaster, pose: &Pose, wanted_m: f64, error: LookError) -> Pose {
        let turn_rad = self.turn_per_m(caster, pose, wanted_m, error) * STEP_M;
        let halfway = turn_rad / 2.0;
        pose.after(Displacement {
            forward_m: STEP_M * halfway.cos(),
            left_m: STEP_M * halfway.sin(),
            turn_rad,
        })
    }
}

/// How far what is measured at a look is off.
#[derive(Debug, Clone, Copy, Default)]
struct LookError {
    range_m: f64,
    bearing_rad: f64,
}

impl LookError {
    /// That of a new look. Where nothing errs, nothing is drawn either.
    fn draw(config: &RobotConfig, random: &mut Stream) -> Self {
        let mut off = |sd: f64| match sd {
            0.0 => 0.0,
            sd => {
                let normal: f64 = random.sample(StandardNormal);
                sd * normal
            }
        };
        Self {
            range_m: off(config.look_range_sd_m),
            bearing_rad: off(config.look_bearing_sd_rad),
        }
    }
}

/// One time round, as a robot without deviations drives it: what all runs measure their progress along.
#[derive(Debug, Clone)]
pub(super) struct Round {
    /// A point every step, `[step]`.
    points: Vec<Point2<f64>>,
}

impl Round {
    /// Follows the wall until the robot is back where it had settled.
    ///
    /// # Errors
    /// A work error where it comes too near to a wall, or never comes round.
    pub(super) fn drive(
        caster: &Raycaster,
        following: &Following,
        config: &RobotConfig,
    ) -> Result<Self> {
        let wanted_m = config.radius_m + following.distance_m;
        let settling = (SETTLED_M / STEP_M) as usize;
        let settle = |pose: Pose, _| following.step(caster, &pose, wanted_m, LookError::default());
        let first = (0..settling).fold(following.start, settle);
        let mut pose = first;
        let mut points = Vec::new();
        let mut before_m = 0.0;
        while points.len() < (MAX_ROUND_M / STEP_M) as usize {
            points.push(Point2::new(pose.x_m, pose.y_m));
            pose = following.step(caster, &pose, wanted_m, LookError::default());
            let place = Point2::new(pose.x_m, pose.y_m);
            if caster.plan().clearance_m(&place) < config.radius_m {
                return Err(Error::work(format!(
                    "robot: hits a wall near ({:.2}, {:.2}) where it follows one at {} m; expected room for its radius of {} m",
                    pose.x_m, pose.y_m, following.distance_m, config.radius_m
                )));
            }
            let passed = first.displacement_to(&pose);
            let alike = passed.left_m.abs() < ROUND_M && passed.turn_rad.abs() < ROUND_RAD;
            let crossed = before_m < 0.0 && passed.forward_m >= 0.0 && passed.forward_m < ROUND_M;
            if crossed && alike {
                return Ok(Self { points });
            }
            before_m = passed.forward_m;
        }
        Err(Error::work(format!(
            "robot: following the wall from ({}, {}) it has not come round after {MAX_ROUND_M} m; expected a wall that leads back",
            following.start.x_m, following.start.y_m
        )))
    }

    pub(super) fn length_m(&self) -> f64 {
        self.points.len() as f64 * STEP_M
    }

    /// Index of the point nearest to a place, among those within a number of points of one.
    fn nearest(&self, place: &Point2<f64>, around: usize, within: usize) -> usize {
        let count = self.points.len();
        let first = around + count - within.min(count / 2);
        let all = (first..=first + 2 * within.min(count / 2)).map(|index| index % count);
        let distance = |index: &usize| (self.points[*index] - place).norm_squared();
        all.min_by(|a, b| distance(a).total_cmp(&distance(b)))
            .unwrap_or(around)
    }
}

/// The way that one run takes along the wall.
pub(super) struct WallWay {
    /// A pose every step, with its place on the way round and how often that was passed, `[step]`.
    steps: Vec<(Pose, f64, f64)>,
}

impl WallWay {
    /// Follows the wall `laps` times round; `caster_at` says what the building is like after so many.
    ///
    /// # Errors
    /// A work error where the robot loses its way round.
    pub(super) fn drive<'a>(
        (seed, run): (Seed, u64),
        caster_at: impl Fn(f64) -> &'a Raycaster,
        following: &Following,
        round: &Round,
        laps: f64,
        config: &RobotConfig,
    ) -> Result<Self> {
        let mut path = seed.numbered_stream("world/robot/path", run);
        let wander = Wander::draw(config, &mut path);
        let scattered_m = path.random::<f64>() * config.start_scatter_m;
        let mut pose = following.start.after(Displacement {
            forward_m: scattered_m,
            left_m: 0.0,
            turn_rad: 0.0,
        });
        let count = round.points.len();
        let place = |pose: &Pose| Point2::new(pose.x_m, pose.y_m);
        let mut index = round.nearest(&place(&pose), 0, count);
        let along = (LOOK_ALONG_M / STEP_M) as usize;
        let (mut steps, mut passed, mut furthest, mut since) = (Vec::new(), 0_i64, 0, 0);
        let mut looks = seed.numbered_stream("world/robot/looks", run);
        let look_m = (config.look_s * config.speed_m_per_s).max(STEP_M);
        let (mut error, mut due_m) = (LookError::default(), 0.0);
        loop {
            let done = passed.abs() as f64 * STEP_M / round.length_m();
            steps.push((pose, index as f64 * STEP_M, done));
            if done >= laps {
                return Ok(Self { steps });
            }
            let caster = caster_at(done);
            let (aside_m, _) = wander.left_m(steps.len() as f64 * STEP_M);
            let wanted_m = config.radius_m + (following.distance_m + aside_m).max(0.1);
            let travelled_m = steps.len() as f64 * STEP_M;
            if travelled_m >= due_m {
                (error, due_m) = (LookError::draw(config, &mut looks), due_m + look_m);
            }
            pose = following.step(caster, &pose, wanted_m, error);
            let next = round.nearest(&place(&pose), index, along);
            let half = count as i64 / 2;
            passed += (next as i64 - index as i64 + half).rem_euclid(count as i64) - half;
            index = next;
            since += 1;
            if passed.abs() > furthest {
                (furthest, since) = (passed.abs(), 0);
            }
            if since as f64 * STEP_M > MAX_LOST_M {
                return Err(Error::work(format!(
                    "robot: following the wall it has lost its way round, near ({:.2}, {:.2}); expected doors and niches that it comes out of again",
                    pose.x_m, pose.y_m
                )));
            }
        }
    }

    fn step(&self, at_m: f64) -> (usize, f64) {
        let at = (at_m / STEP_M).clamp(0.0, (self.steps.len() - 1) as f64);
        let index = (at as usize).min(self.steps.len().saturating_sub(2));
        (index, at - index as f64)
    }
}

impl Way for WallWay {
    fn span_m(&self) -> [f64; 2] {
        [0.0, (self.steps.len() - 1) as f64 * STEP_M]
    }

    fn pose(&self, at_m: f64) -> Pose {
        let (index, share) = self.step(at_m);
        let from = self.steps[index].0;
        let to = self.steps[(index + 1).min(self.steps.len() - 1)].0;
        let step = from.displacement_to(&to);
        from.after(Displacement {
            forward_m: share * step.forward_m,
            left_m: share * step.left_m,
            turn_rad: share * step.turn_rad,
        })
    }

    fn route_m(&self, at_m: f64) -> f64 {
        self.steps[self.step(at_m).0].1
    }

    fn laps(&self, at_m: f64) -> f64 {
        self.steps[self.step(at_m).0].2
    }
}
