//! How far a robot's odometry can be trusted, learned from runs whose true path is known.

use super::{motion::OdometryMotion, places::Places};
use crate::{
    geometry::{Displacement, Pose, wrapped},
    recording::Recording,
};

/// Movements are compared over about this distance, in metres: that of a filter's step.
const OVER_M: f64 = 0.5;

/// With fewer movements to compare, the default motion model holds.
const ENOUGH: usize = 30;

/// Turns smaller than this are driving straight, in radians.
const STRAIGHT_RAD: f64 = 0.1;

/// Errors of successive steps add up in the same direction more often than independent ones would, so variances are
/// taken this much larger: "a pessimistic approximation" is enough (Thrun 1998, 2.1).
const PESSIMISM: f64 = 2.0;

/// What odometry said of a movement against what it was.
struct Movement {
    distance_m: f64,
    turn_rad: f64,
    square_position_error_m2: f64,
    square_heading_error_rad2: f64,
}

impl OdometryMotion {
    /// The motion model that explains the odometry errors among some snapshots of a recording, pessimistically; the
    /// default one where there is too little to compare.
    pub fn fitted(recording: &Recording, snapshots: &[usize]) -> Self {
        let all = movements(recording, snapshots);
        let usual = Self::default();
        if all.len() < ENOUGH {
            return usual;
        }
        let (straight, turning): (Vec<&Movement>, Vec<&Movement>) =
            all.iter().partition(|m| m.turn_rad.abs() < STRAIGHT_RAD);
        // Least squares through the origin of an error's square over the square of what causes it.
        let ratio = |of: &[&Movement],
                     error: &dyn Fn(&Movement) -> f64,
                     cause: &dyn Fn(&Movement) -> f64| {
            let causes: f64 = of.iter().map(|m| cause(m)).sum();
            let ratio = of.iter().map(|m| error(m)).sum::<f64>() / causes;
            if of.len() >= ENOUGH && ratio.is_finite() {
                Some(ratio.max(0.0))
            } else {
                None
            }
        };
        let distance = |m: &Movement| m.distance_m * m.distance_m;
        let turn = |m: &Movement| m.turn_rad * m.turn_rad;
        let along = ratio(&straight, &|m| 0.5 * m.square_position_error_m2, &distance);
        let swerve = ratio(&straight, &|m| m.square_heading_error_rad2, &distance);
        // What driving explains already, as it was found, or else as it is usual.
        let explained = |found: Option<f64>, usual: f64| found.unwrap_or(usual);
        let by_way = explained(along, usual.translation_noise_from_translation);
        let by_swerve = explained(swerve, usual.rotation_noise_from_translation);
        let left_over = |error: f64, explained: f64, m: &Movement| error - explained * distance(m);
        let sideways = ratio(
            &turning,
            &|m| left_over(0.5 * m.square_position_error_m2, by_way, m),
            &turn,
        );
        let twist = ratio(
            &turning,
            &|m| left_over(m.square_heading_error_rad2, by_swerve, m),
            &turn,
        );
        let pessimistic =
            |found: Option<f64>, usual: f64| found.map_or(usual, |ratio| PESSIMISM * ratio);
        Self {
            rotation_noise_from_rotation: pessimistic(twist, usual.rotation_noise_from_rotation),
            rotation_noise_from_translation: pessimistic(
                swerve,
                usual.rotation_noise_from_translation,
            ),
            translation_noise_from_translation: pessimistic(
                along,
                usual.translation_noise_from_translation,
            ),
            translation_noise_from_rotation: pessimistic(
                sideways,
                usual.translation_noise_from_rotation,
            ),
            ..usual
        }
    }
}

/// Movements of about half a metre between snapshots that follow one another.
fn movements(recording: &Recording, snapshots: &[usize]) -> Vec<Movement> {
    let travelled = recording.travelled_m();
    let runs = recording.runs();
    let run_of = |k: usize| runs.partition_point(|run| run.end <= k);
    let along_route = matches!(Places::of(recording), Places::Route(_));
    let truth = |k: usize| match recording.route_m().filter(|_| along_route) {
        Some(route) => Pose::new(route[k], 0.0, 0.0),
        None => recording.poses()[k],
    };
    let mut all = Vec::new();
    let mut from: Option<usize> = None;
    let mut previous = None;
    for &k in snapshots {
        let unbroken =
            previous.is_some_and(|before: usize| before + 1 == k && run_of(before) == run_of(k));
        previous = Some(k);
        let Some(start) = from.filter(|_| unbroken) else {
            from = Some(k);
            continue;
        };
        if travelled[k] - travelled[start] < OVER_M {
            continue;
        }
        from = Some(k);
        let was = truth(start).displacement_to(&truth(k));
        let said = recording
            .observation(start)
            .odometry
            .displacement_to(&recording.observation(k).odometry);
        all.push(compare(was, said, along_route));
    }
    all
}

fn compare(was: Displacement, said: Displacement, along_route: bool) -> Movement {
    if along_route {
        // One coordinate: only how far it went can be wrong. Twice the square, as if both axes erred alike.
        let error = said.distance_m() - was.distance_m();
        return Movement {
            distance_m: said.distance_m(),
            turn_rad: 0.0,
            square_position_error_m2: 2.0 * error * error,
            square_heading_error_rad2: 0.0,
        };
    }
    let (dx, dy) = (said.forward_m - was.forward_m, said.left_m - was.left_m);
    Movement {
        distance_m: said.distance_m(),
        turn_rad: said.turn_rad,
        square_position_error_m2: dx * dx + dy * dy,
        square_heading_error_rad2: wrapped(said.turn_rad - was.turn_rad).powi(2),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        recording::{Channel, Columns},
        seed::Seed,
    };
    use rand_distr::{Distribution, StandardNormal};

    /// A robot whose steps of 0.5 m err by the given standard deviations, a quarter of them turning by 0.6 rad.
    fn recording(position_m: f64, heading_rad: f64, twist: f64) -> Recording {
        let mut random = Seed(4).stream("odometry errors");
        let mut draw = || -> f64 { StandardNormal.sample(&mut random) };
        let (mut pose, mut odometry) = (vec![Pose::default()], vec![Pose::default()]);
        for k in 0..4000 {
            let turn_rad = if k % 4 == 0 { 0.6 } else { 0.0 };
            let step = Displacement {
                forward_m: 0.5,
                left_m: 0.0,
                turn_rad,
            };
            let said = Displacement {
                forward_m: 0.5 + position_m * draw(),
                left_m: position_m * draw(),
                turn_rad: turn_rad + heading_rad * draw() + twist * turn_rad * draw(),
            };
            pose.push(pose[k].after(step));
            odometry.push(odometry[k].after(said));
        }
        let k = pose.len();
        let channel = Channel {
            name: "light".into(),
            width: 1,
            unit: "lux".into(),
            bearing_rad: None,
            maximum: None,
            offset_m: None,
        };
        Recording::new(Columns {
            channels: vec![channel],
            values: ndarray::Array2::zeros((k, 1)),
            stamp_s: vec![0.0; k],
            odometry,
            pose,
            run: vec![0; k],
            ..Columns::default()
        })
        .unwrap()
    }

    #[test]
    fn finds_the_noise_that_was_put_in() {
        let recording = recording(0.05, 0.04, 0.2);
        let all: Vec<usize> = (0..recording.len()).collect();
        let motion = OdometryMotion::fitted(&recording, &all);
        let near = |found: f64, put_in: f64| {
            assert!(
                (found / (PESSIMISM * put_in) - 1.0).abs() < 0.15,
                "{motion:?}"
            )
        };
        near(
            motion.translation_noise_from_translation,
            0.05f64.powi(2) / 0.25,
        );
        near(
            motion.rotation_noise_from_translation,
            0.04f64.powi(2) / 0.25,
        );
        near(motion.rotation_noise_from_rotation, 0.2f64.powi(2));
    }

    #[test]
    fn too_little_to_compare_leaves_the_default() {
        let recording = recording(0.05, 0.04, 0.2);
        assert_eq!(
            OdometryMotion::fitted(&recording, &[0, 1, 2, 3]),
            OdometryMotion::default()
        );
        let scattered: Vec<usize> = (0..2000).step_by(3).collect(); // no two follow one another
        assert_eq!(
            OdometryMotion::fitted(&recording, &scattered),
            OdometryMotion::default()
        );
    }
}
