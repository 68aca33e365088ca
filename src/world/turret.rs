//! A turret that turns slowly to the compass's north, however the base below it turns.
//!
//! "The robot's turret was rotated at small speeds in the direction of 'North' as indicated by the robot's compass. The
//! effect of this behaviour was to smooth out local variations in the magnetic field" (Duckett & Nehmzow 1998, 5.1).

use super::{
    Compass, CompassConfig,
    timed_path::{TimedPath, TimedPose},
    unsteadiness::Unsteadiness,
};
use crate::{
    error::{Error, Result},
    geometry::{Pose, wrapped},
};
use rand::Rng;

/// The turret looks at its compass this often, seconds: a KVH C-100 measures ten times a second.
const LOOK_S: f64 = 0.1;

/// A turret at one pose of a path.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Turret {
    /// Its true heading, radians in (−π, π].
    pub heading_rad: f64,
    /// How far its compass's [unsteadiness](Unsteadiness) turns a reading counter-clockwise just then, radians.
    pub unsteady_rad: f64,
}

/// Where the turret looks at each pose of a path, `[pose]`. It starts where the compass has
/// north; the poses' headings, those of the base, play no part.
///
/// ```
/// use ballmark::{geometry::Pose, seed::Seed, world::{turret_headings, Compass, CompassConfig, TimedPose}};
/// let config = CompassConfig { distortion_sd_rad: 0.0, ..CompassConfig::default().steady() };
/// let compass = Compass::new(config, Seed(1))?;
/// let path = [0.0, 1.0, 2.0].map(|x_m| TimedPose { stamp_s: 8.0 * x_m, pose: Pose::new(x_m, 0.0, x_m) });
/// let turrets = turret_headings(&compass, &path, &mut Seed(1).stream("turret"))?;
/// assert!(turrets.iter().all(|turret| (turret.heading_rad - std::f64::consts::FRAC_PI_2).abs() < 1e-12)); // north
/// # Ok::<(), ballmark::Error>(())
/// ```
///
/// # Errors
/// Where there is no pose, one is not finite, or the times go back.
pub fn turret_headings(
    compass: &Compass,
    path: &[TimedPose],
    random: &mut impl Rng,
) -> Result<Vec<Turret>> {
    let timed = TimedPath::new(path)
        .ok_or_else(|| Error::work("turret: expected a path of finite poses, in their order"))?;
    let config = compass.config();
    let start = path[0].pose; // a path has a pose
    let mut unsteadiness = Unsteadiness::draw(config, random);
    let read_rad = |place: Pose, heading_rad, unsteady_rad: f64, random: &mut _| {
        let turret = Pose {
            heading_rad,
            ..place
        };
        compass.read(&turret, random) + unsteady_rad
    };
    let unsteady_rad = unsteadiness.error_rad(config);
    let mut heading_rad = wrapped(config.north_rad - compass.distortion_rad(&start) - unsteady_rad);
    let mut now_s = path[0].stamp_s;
    let mut turrets = Vec::with_capacity(path.len());
    for next in path {
        let span_s = next.stamp_s - now_s;
        let looks = (span_s / LOOK_S).ceil();
        for look in 1..=looks as usize {
            let (place, _) = timed.at_time(now_s + span_s * look as f64 / looks);
            unsteadiness.pass(config, span_s / looks, random);
            let unsteady_rad = unsteadiness.error_rad(config);
            let read_rad = read_rad(place, heading_rad, unsteady_rad, random);
            let error_rad = wrapped(config.north_rad - read_rad);
            heading_rad = wrapped(heading_rad + turn_rad(config, error_rad, span_s / looks));
        }
        now_s = next.stamp_s;
        turrets.push(Turret {
            heading_rad,
            unsteady_rad: unsteadiness.error_rad(config),
        });
    }
    Ok(turrets)
}

/// How far the turret turns within a time to undo an error: as a first-order lag does, up to its greatest speed.
fn turn_rad(config: &CompassConfig, error_rad: f64, elapsed_s: f64) -> f64 {
    let wanted_rad = error_rad * (1.0 - (-elapsed_s / config.turret_time_s).exp());
    let most_rad = config.turret_rad_per_s * elapsed_s;
    wanted_rad.clamp(-most_rad, most_rad)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::seed::Seed;

    #[test]
    fn an_error_is_made_up_for_in_the_stated_time_and_no_faster_than_stated() {
        let config = CompassConfig::default();
        let after = |error_rad: f64, seconds: usize| {
            (0..seconds * 10).fold(error_rad, |left, _| left - turn_rad(&config, left, 0.1))
        };
        assert!((after(0.2, 5) - 0.2 / std::f64::consts::E).abs() < 1e-12);
        assert!((after(-3.0, 5) + 2.5).abs() < 1e-9); // 5 s at 0.1 rad/s
    }

    /// The turret's and the compass's deviations from north along 120 m at 0.122 m/s, a pose a second.
    fn deviations(config: CompassConfig) -> (Vec<f64>, Vec<f64>) {
        let compass = Compass::new(config.clone(), Seed(5)).unwrap();
        let path: Vec<TimedPose> = (0..1000)
            .map(|second| TimedPose {
                stamp_s: f64::from(second),
                pose: Pose::new(0.122 * f64::from(second), 1.0, f64::from(second)),
            })
            .collect();
        let headings = turret_headings(&compass, &path, &mut Seed(5).stream("turret")).unwrap();
        let turret = headings
            .iter()
            .map(|turret| wrapped(turret.heading_rad - config.north_rad));
        let bare = path
            .iter()
            .map(|timed| -compass.distortion_rad(&timed.pose));
        (turret.collect(), bare.collect())
    }

    fn variation(deviations: &[f64]) -> f64 {
        deviations
            .windows(2)
            .map(|pair| (pair[1] - pair[0]).powi(2))
            .sum::<f64>()
    }

    #[test]
    fn the_turret_follows_the_wide_variations_and_smooths_out_the_local_ones() {
        let quiet = |correlation_m| CompassConfig {
            distortion_sd_rad: 0.15,
            correlation_m,
            ..CompassConfig::default().steady()
        };
        // Over 8 m the field turns slower than the turret: it lags by 0.6 m at most.
        let (turret, bare) = deviations(quiet(8.0));
        assert!(turret.iter().zip(&bare).all(|(a, b)| (a - b).abs() < 0.04));
        // Over 0.2 m, 1.6 s, it is too slow, and turns far less.
        let (turret, bare) = deviations(quiet(0.2));
        assert!(variation(&turret) < 0.1 * variation(&bare));
    }

    #[test]
    fn noise_of_the_compass_is_averaged() {
        let (turret, _) = deviations(CompassConfig {
            distortion_sd_rad: 0.0,
            noise_rad: 0.02,
            ..CompassConfig::default().steady()
        });
        let settled = &turret[50..];
        let sd = (settled.iter().map(|d| d * d).sum::<f64>() / settled.len() as f64).sqrt();
        // A lag with share a = 1 − e^(−0.1/5) a look has variance a / (2 − a) of the noise: 0.02 · 0.0999 = 0.0020.
        assert!((sd - 0.0020).abs() < 0.0005, "{sd}");
    }

    #[test]
    fn a_sway_shorter_than_the_turrets_lag_is_smoothed_a_slow_error_is_not() {
        let sd = |config: CompassConfig| {
            let (turret, _) = deviations(CompassConfig {
                distortion_sd_rad: 0.0,
                ..config
            });
            (turret.iter().map(|d| d * d).sum::<f64>() / turret.len() as f64).sqrt()
        };
        let steady = || CompassConfig::default().steady();
        // A lag of 5 s leaves τ / (τ + 5 s) of the variance of a process of correlation time τ.
        let sway = sd(CompassConfig {
            tilt_sd_rad: 0.0087,
            ..steady()
        });
        let expected = 0.0087 * 2.498 * (1.0_f64 / 6.0).sqrt();
        assert!((sway / expected - 1.0).abs() < 0.2, "{sway} {expected}");
        let drift = sd(CompassConfig {
            drift_sd_rad: 0.02,
            drift_time_s: 20.0,
            ..steady()
        });
        let expected = 0.02 * (20.0_f64 / 25.0).sqrt();
        assert!((drift / expected - 1.0).abs() < 0.3, "{drift} {expected}");
    }

    #[test]
    fn paths_that_are_none_are_told() {
        let compass = Compass::new(CompassConfig::default(), Seed(1)).unwrap();
        let at = |stamp_s| TimedPose {
            stamp_s,
            pose: Pose::default(),
        };
        for path in [vec![], vec![at(1.0), at(0.0)], vec![at(f64::NAN)]] {
            let result = turret_headings(&compass, &path, &mut Seed(1).stream("turret"));
            assert!(result.unwrap_err().to_string().contains("turret"));
        }
    }
}
