//! Driving a route: not quite along its middle.

use super::{
    RobotConfig, Route, Stop,
    way::{Way, halts, reckoned},
};
use crate::{
    error::Result,
    geometry::{Pose, wrapped},
    seed::{Seed, Stream},
};
use nalgebra::Vector2;
use rand::RngExt;
use rand_distr::StandardNormal;
use std::f64::consts::TAU;

/// Waves that make up a deviation, and the shortest and longest of them, metres.
const WAVES: usize = 8;
const WAVELENGTH_M: std::ops::Range<f64> = 4.0..16.0;

/// Drives run number `run` along the route and stops for a snapshot every `spacing_m` metres of travel.
///
/// Randomness comes from streams numbered by the run, and the way driven doesn't depend on the spacing: asking for
/// more runs, or denser snapshots, changes none of it. Every two centimetres, `clear` is asked whether the robot may be
/// at a pose and coordinate of the route; sparse snapshots don't let it jump through walls.
///
/// # Errors
/// A usage error where a constant or the spacing is out of bounds; the first error of `clear`.
pub fn drive(
    seed: Seed,
    run: u64,
    route: &Route,
    config: &RobotConfig,
    spacing_m: f64,
    mut clear: impl FnMut(&Pose, f64) -> Result<()>,
) -> Result<Vec<Stop>> {
    config.check()?;
    let clear = |pose: &Pose, route_m: f64, _| clear(pose, route_m);
    let way = RouteWay::draw(seed, run, (route, route), false, 1.0, config);
    let halts = halts(seed, run, &way, config, (spacing_m, usize::MAX), clear)?;
    Ok(reckoned(seed, run, &config.odometry, &halts, None))
}

/// A route as one run drives it.
pub(super) struct RouteWay<'a> {
    route: &'a Route,
    wander: Wander,
    span_m: [f64; 2],
    /// On the way back: the coordinate, on the way there, of the place where it begins.
    mirror_m: Option<f64>,
}

impl<'a> RouteWay<'a> {
    /// Draws where run number `run` starts and how it deviates; `back`: along the second of the two routes, which is
    /// the first one's reverse.
    pub(super) fn draw(
        seed: Seed,
        run: u64,
        (there, reverse): (&'a Route, &'a Route),
        back: bool,
        laps: f64,
        config: &RobotConfig,
    ) -> Self {
        let mut path = seed.numbered_stream("world/robot/path", run);
        let wander = Wander::draw(config, &mut path);
        let start_m = path.random::<f64>() * config.start_scatter_m;
        let route = if back { reverse } else { there };
        let end_m = if route.is_closed() {
            start_m + laps * route.length_m()
        } else {
            route.length_m()
        };
        let mirror_m = match route.is_closed() {
            true => there.first_straight_m(),
            false => there.length_m(),
        };
        Self {
            route,
            wander,
            span_m: [start_m, end_m],
            mirror_m: back.then_some(mirror_m),
        }
    }
}

impl Way for RouteWay<'_> {
    fn span_m(&self) -> [f64; 2] {
        self.span_m
    }

    fn pose(&self, at_m: f64) -> Pose {
        self.wander.pose(self.route, at_m)
    }

    fn route_m(&self, at_m: f64) -> f64 {
        let on_m = self.mirror_m.map_or(at_m, |mirror_m| mirror_m - at_m);
        if self.route.is_closed() {
            on_m.rem_euclid(self.route.length_m())
        } else {
            on_m
        }
    }

    fn laps(&self, at_m: f64) -> f64 {
        (at_m - self.span_m[0]) / self.route.length_m()
    }
}

/// A smooth deviation from the route: a Gaussian sum of waves, so that side and heading belong together.
pub(super) struct Wander {
    /// Amplitudes of sine and cosine, and radians a metre.
    waves: [(f64, f64, f64); WAVES],
    limit_m: f64,
}

impl Wander {
    pub(super) fn draw(config: &RobotConfig, random: &mut Stream) -> Self {
        let amplitude_m = config.lateral_sd_m / (WAVES as f64).sqrt();
        let waves = std::array::from_fn(|_| {
            let per_m = TAU / random.random_range(WAVELENGTH_M);
            (
                amplitude_m * normal(random),
                amplitude_m * normal(random),
                per_m,
            )
        });
        Self {
            waves,
            limit_m: config.lateral_limit_m,
        }
    }

    /// How far to the left of the route it is at a coordinate, metres, and its slope.
    pub(super) fn left_m(&self, route_m: f64) -> (f64, f64) {
        let (mut free_m, mut free_slope) = (0.0, 0.0);
        for (sine_m, cosine_m, per_m) in self.waves {
            let (sin, cos) = (per_m * route_m).sin_cos();
            free_m += sine_m * sin + cosine_m * cos;
            free_slope += per_m * (sine_m * cos - cosine_m * sin);
        }
        let bent = (free_m / self.limit_m).tanh();
        (self.limit_m * bent, free_slope * (1.0 - bent * bent))
    }

    /// The pose driven at a coordinate of the route.
    fn pose(&self, route: &Route, route_m: f64) -> Pose {
        let (left_m, slope) = self.left_m(route_m);
        let (middle, heading_rad, curvature_per_m) = route.at(route_m);
        let place = middle + Vector2::new(-heading_rad.sin(), heading_rad.cos()) * left_m;
        // d/ds (r + l n) = (1 − κ l) t + l' n
        let aside_rad = slope.atan2(1.0 - curvature_per_m * left_m);
        Pose::new(place.x, place.y, wrapped(heading_rad + aside_rad))
    }
}

fn normal(random: &mut Stream) -> f64 {
    random.sample(StandardNormal)
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Point2;

    /// 40 m ahead, 10 m to the left.
    fn route() -> Route {
        let corners = [
            Point2::new(0.0, 0.0),
            Point2::new(40.0, 0.0),
            Point2::new(40.0, 10.0),
        ];
        Route::new(&corners, 1.0).unwrap()
    }

    fn drives(config: &RobotConfig, runs: u64) -> Vec<Vec<Stop>> {
        (0..runs)
            .map(|run| drive(Seed(2), run, &route(), config, 0.5, |_, _| Ok(())).unwrap())
            .collect()
    }

    fn sd(numbers: impl Iterator<Item = f64> + Clone) -> f64 {
        (numbers.clone().map(|x| x * x).sum::<f64>() / numbers.count() as f64).sqrt()
    }

    #[test]
    fn snapshots_stand_the_spacing_apart_along_the_way_driven() {
        for stops in drives(&RobotConfig::default(), 20) {
            assert!(
                stops[0].route_m < 0.25 && stops.last().unwrap().route_m > route().length_m() - 0.6
            );
            for pair in stops.windows(2) {
                // A chord is shorter than its arc, by 1 − sin(¼)/¼ = 1 % on the 1 m bend (2 % driven inside of it).
                let chord_m = pair[0].pose.distance_m(&pair[1].pose);
                assert!(chord_m <= 0.5 + 1e-3 && chord_m > 0.47, "{chord_m}");
                assert!((pair[1].stamp_s - pair[0].stamp_s - 0.5 / 0.15).abs() < 1e-9);
            }
        }
    }

    #[test]
    fn deviations_have_the_stated_size_and_stay_within_their_limit() {
        let straight = |stops: &Vec<Stop>| {
            stops
                .iter()
                .filter(|s| s.route_m < 39.0)
                .map(|s| s.pose)
                .collect::<Vec<_>>()
        };
        let poses = drives(&RobotConfig::default(), 400)
            .iter()
            .flat_map(straight)
            .collect::<Vec<_>>();
        let side_sd = sd(poses.iter().map(|pose| pose.y_m));
        // tanh takes a little off: for 0.12 within 0.4, E tanh² gives 0.111.
        assert!((side_sd - 0.111).abs() < 0.006, "{side_sd}");
        assert!(poses.iter().all(|pose| pose.y_m.abs() <= 0.4));
        let wild = RobotConfig {
            lateral_sd_m: 5.0,
            ..RobotConfig::default()
        };
        assert!(
            drives(&wild, 5)
                .iter()
                .flat_map(straight)
                .all(|pose| pose.y_m.abs() <= 0.4)
        );
        let tame = RobotConfig {
            lateral_sd_m: 0.0,
            ..RobotConfig::default()
        };
        let poses = drives(&tame, 100)
            .iter()
            .flat_map(straight)
            .collect::<Vec<_>>();
        assert!(poses.iter().all(|pose| pose.y_m == 0.0));
        let heading_sd = sd(poses.iter().map(|pose| pose.heading_rad));
        assert!((heading_sd - 0.05).abs() < 0.002, "{heading_sd}");
    }

    #[test]
    fn denser_snapshots_drive_the_same_way() {
        let config = RobotConfig {
            heading_sd_rad: 0.0,
            ..RobotConfig::default()
        };
        let [coarse, dense] = [1.0, 0.25].map(|spacing_m| {
            drive(Seed(2), 3, &route(), &config, spacing_m, |_, _| Ok(())).unwrap()
        });
        for (index, stop) in coarse.iter().enumerate() {
            assert_eq!(stop.pose, dense[4 * index].pose);
        }
    }

    #[test]
    fn the_robot_faces_where_it_goes_also_round_the_bend() {
        let config = RobotConfig {
            heading_sd_rad: 0.0,
            lateral_sd_m: 0.3,
            ..RobotConfig::default()
        };
        for stops in
            (0..10).map(|run| drive(Seed(2), run, &route(), &config, 0.02, |_, _| Ok(())).unwrap())
        {
            for pair in stops.windows(2) {
                let step = pair[0].pose.displacement_to(&pair[1].pose);
                // The chord points halfway between the headings at its ends.
                let aside_rad = wrapped(step.left_m.atan2(step.forward_m) - step.turn_rad / 2.0);
                // Where the bend begins and ends, a way that slants across the route has a slight kink.
                let at_joint = [39.0, 39.0 + TAU / 4.0]
                    .iter()
                    .any(|joint_m| (pair[0].route_m - joint_m).abs() < 0.05);
                assert!(
                    at_joint || aside_rad.abs() < 0.005,
                    "{aside_rad} at {} m",
                    pair[0].route_m
                );
            }
        }
    }
}
