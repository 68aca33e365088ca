//! What holds for the room as a whole, and the small worlds that its tests share.

use super::*;
use crate::{
    geometry::{Displacement, Pose},
    seed::{Seed, Stream},
};
use ndarray::Array2;
use rand::RngExt;
use std::sync::Arc;

/// A corridor with a bend, seen both ways.
pub(super) fn bend() -> Places {
    let out = (0..12).map(|i| Pose::new(0.5 * i as f64, 0.0, 0.0));
    let on = (0..8).map(|i| Pose::new(5.5, 0.5 * i as f64, 1.6));
    let back = (0..12).map(|i| Pose::new(0.5 * i as f64, 0.1, 3.1));
    Places::Plane(out.chain(on).chain(back).collect())
}

pub(super) fn corridor() -> Places {
    Places::Route((0..60).map(|i| 0.4 * i as f64).collect())
}

pub(super) fn grid(mapped: &Places) -> Arc<Grid> {
    let config = GridConfig {
        headings: 8,
        ..GridConfig::default()
    };
    Arc::new(Grid::over(mapped, &config).unwrap())
}

pub(super) fn step(forward_m: f64, left_m: f64, turn_rad: f64) -> Displacement {
    Displacement {
        forward_m,
        left_m,
        turn_rad,
    }
}

pub(super) fn random_activations(rows: usize, columns: usize, random: &mut Stream) -> Array2<f64> {
    Array2::from_shape_simple_fn((rows, columns), || random.random())
}

fn assert_mass_one(belief: &Belief, when: &str) {
    let sum: f64 = belief.mass().iter().sum();
    assert!((sum - 1.0).abs() < 1e-9, "{when}: {sum}");
    assert!(belief.mass().iter().all(|m| *m >= 0.0), "{when}");
}

#[test]
fn a_thousand_steps_neither_underflow_nor_lose_mass() {
    for mapped in [corridor(), bend()] {
        let grid = grid(&mapped);
        for evidence in Evidence::ALL {
            let mut random = Seed(1).stream("thousand steps");
            // Filters so sure that the map is 0 or 1 but for the floor.
            let activation = random_activations(mapped.len(), 4, &mut random).mapv(f64::round);
            let nearness = Nearness {
                k: 1,
                ..Nearness::default()
            };
            let config = MapConfig {
                nearness,
                ..MapConfig::default()
            };
            let map = FeatureMap::new(mapped.clone(), activation, config).unwrap();
            let map = map.at(grid.places()).unwrap();
            let prior = Belief::uniform(grid.places()).unwrap();
            let mut robot = BayesFilter::new(&grid, OdometryMotion::default(), prior).unwrap();
            for t in 0..1000 {
                // 0 and 1 exactly, and each step the opposite of the last; then anything.
                let g: Vec<f64> = match t % 3 {
                    0 => vec![0.0, 1.0, 0.0, 1.0],
                    1 => vec![1.0, 0.0, 1.0, 0.0],
                    _ => (0..4).map(|_| random.random()).collect(),
                };
                let likelihood = evidence.log_likelihood(&g, &map, robot.belief(), &mut random);
                robot.correct(&likelihood.unwrap()).unwrap();
                assert_mass_one(robot.belief(), &format!("{evidence}, correction {t}"));
                robot
                    .predict(&step(0.3, 0.02, 0.2 * random.random::<f64>() - 0.05))
                    .unwrap();
                assert_mass_one(robot.belief(), &format!("{evidence}, step {t}"));
            }
        }
    }
}

#[test]
fn without_movement_or_noise_contradictions_do_not_underflow_either() {
    let grid = grid(&corridor());
    let prior = Belief::uniform(grid.places()).unwrap();
    let mut robot = BayesFilter::new(&grid, OdometryMotion::exact(), prior).unwrap();
    let side = |left: bool| -> Vec<f64> {
        let half = grid.len() / 2;
        (0..grid.len())
            .map(|cell| if (cell < half) == left { 0.0 } else { -50.0 })
            .collect()
    };
    for t in 0..1000 {
        robot.correct(&side(t % 7 < 3)).unwrap();
        assert_mass_one(robot.belief(), &format!("correction {t}"));
    }
    robot.correct(&vec![-1e9; grid.len()]).unwrap();
    assert_mass_one(robot.belief(), "all alike unlikely");
}

/// Every motion model keeps mass 1 for every movement, on a route and in the plane.
macro_rules! keeps_mass {
    ($($name:ident: $model:expr;)*) => { $(
        #[test]
        fn $name() {
            let motion: OdometryMotion = $model;
            for mapped in [corridor(), bend()] {
                let grid = grid(&mapped);
                let movements = [
                    step(0.0, 0.0, 0.0), step(0.25, 0.0, 0.0), step(0.3, -0.1, 0.4), step(-0.7, 0.0, -3.0),
                    step(40.0, 0.0, 100.0), step(1e300, -1e300, 1e300),
                ];
                for movement in movements {
                    for prior in [
                        Belief::uniform(grid.places()).unwrap(),
                        Belief::around(grid.places(), grid.places(), grid.len() - 1, 0.1, 0.1).unwrap(),
                    ] {
                        let mut robot = BayesFilter::new(&grid, motion.clone(), prior).unwrap();
                        for _ in 0..5 {
                            robot.predict(&movement).unwrap();
                            assert_mass_one(robot.belief(), &format!("{movement:?}"));
                        }
                    }
                }
            }
        }
    )* };
}

keeps_mass! {
    default_motion_keeps_mass: OdometryMotion::default();
    exact_motion_keeps_mass: OdometryMotion::exact();
    turning_noise_keeps_mass: OdometryMotion { rotation_noise_from_rotation: 0.5, ..OdometryMotion::exact() };
    veering_noise_keeps_mass: OdometryMotion { rotation_noise_from_translation: 2.0, ..OdometryMotion::exact() };
    slipping_noise_keeps_mass: OdometryMotion { translation_noise_from_translation: 0.3, ..OdometryMotion::exact() };
    shuffling_noise_keeps_mass: OdometryMotion { translation_noise_from_rotation: 0.3, ..OdometryMotion::exact() };
    lost_odometry_keeps_mass: OdometryMotion { translation_floor_m: 30.0, rotation_floor_rad: 9.0, ..OdometryMotion::exact() };
    stalling_keeps_mass: OdometryMotion { stall_probability: 0.5, ..OdometryMotion::default() };
}

/// Mean and variance of a coordinate under a belief.
fn moments(belief: &Belief, coordinate: impl Fn(usize) -> f64) -> (f64, f64) {
    let mean = |f: &dyn Fn(usize) -> f64| -> f64 {
        belief
            .mass()
            .iter()
            .enumerate()
            .map(|(cell, mass)| mass * f(cell))
            .sum()
    };
    let middle = mean(&coordinate);
    (middle, mean(&|cell| (coordinate(cell) - middle).powi(2)))
}

#[test]
fn prediction_along_a_route_moves_the_mean_and_grows_the_variance() {
    let grid = Arc::new(Grid::along_route(0.0, 100.0, &GridConfig::default()).unwrap());
    let Places::Route(cells) = &**grid.places() else {
        unreachable!()
    };
    let motion = OdometryMotion {
        translation_noise_from_translation: 0.05,
        stall_probability: 1e-15,
        ..OdometryMotion::default()
    };
    let start = Belief::around(grid.places(), &Places::Route(vec![50.0]), 0, 0.5, 1.0).unwrap();
    let (mean, variance) = moments(&start, |cell| cells[cell]);
    for ahead in [0.5, 1.0, 1.36, -2.11] {
        let mut robot = BayesFilter::new(&grid, motion.clone(), start.clone()).unwrap();
        let movement = step(ahead, 0.0, 0.1);
        robot.predict(&movement).unwrap();
        let (now, spread) = moments(robot.belief(), |cell| cells[cell]);
        assert!((now - mean - ahead).abs() < 1e-9, "{ahead}: {}", now - mean);
        let grown = spread - variance;
        let stated = 0.05 * ahead * ahead + 0.01 * 0.1 * 0.1 + 0.01 * 0.01;
        assert!(
            (grown - stated).abs() < 1e-6,
            "{ahead}: {grown}, not {stated}"
        );
    }
}

#[test]
fn prediction_in_the_plane_moves_each_heading_its_own_way() {
    let square = (0..400).map(|i| Pose::new((i % 20) as f64, (i / 20) as f64, 0.0));
    let config = GridConfig {
        headings: 48,
        ..GridConfig::default()
    };
    let grid = Arc::new(Grid::over(&Places::Plane(square.collect()), &config).unwrap());
    let Places::Plane(cells) = &**grid.places() else {
        unreachable!()
    };
    let motion = OdometryMotion {
        translation_noise_from_translation: 0.05,
        rotation_noise_from_rotation: 0.2,
        stall_probability: 1e-15,
        ..OdometryMotion::default()
    };
    let start_pose = Pose::new(9.6, 10.1, 5.0 * std::f64::consts::TAU / 48.0);
    let start_at = Places::Plane(vec![start_pose]);
    // One heading only, so that the mean goes straight.
    let start = Belief::around(grid.places(), &start_at, 0, 0.4, 0.01).unwrap();
    let movement = step(1.3, -0.4, 0.3);
    let mut robot = BayesFilter::new(&grid, motion, start.clone()).unwrap();
    robot.predict(&movement).unwrap();
    let expected = start_pose.after(movement);
    let distance2 = 1.3 * 1.3 + 0.4 * 0.4;
    let position = 0.05 * distance2 + 0.01 * 0.09 + 1e-4;
    let heading = 0.2 * 0.09 + 0.01 * distance2 + 1e-4;
    type Coordinate = fn(&Pose) -> f64;
    let all: [(Coordinate, f64); 3] = [
        (|p| p.x_m, position),
        (|p| p.y_m, position),
        (|p| p.heading_rad, heading),
    ];
    for (i, (coordinate, stated)) in all.into_iter().enumerate() {
        let (from, narrow) = moments(&start, |cell| coordinate(&cells[cell]));
        let (to, wide) = moments(robot.belief(), |cell| coordinate(&cells[cell]));
        let moved = coordinate(&expected) - coordinate(&start_pose);
        assert!(
            (to - from - moved).abs() < 1e-6,
            "coordinate {i}: {} not {moved}",
            to - from
        );
        assert!(
            (wide - narrow - stated).abs() < 1e-5,
            "coordinate {i}: {} not {stated}",
            wide - narrow
        );
    }
}

#[test]
fn a_belief_that_would_leave_as_a_whole_stays() {
    let grid = grid(&corridor());
    let end = Places::Route(vec![23.5]);
    let start = Belief::around(grid.places(), &end, 0, 0.1, 1.0).unwrap();
    let mut robot = BayesFilter::new(&grid, OdometryMotion::exact(), start).unwrap();
    robot.predict(&step(10.0, 0.0, 0.0)).unwrap();
    assert!(robot.belief().point_error_m(&end, 0) < 0.25);
}

#[test]
fn correction_refuses_what_is_no_likelihood_and_keeps_the_belief() {
    let places = Arc::new(Places::Route(vec![0.0, 1.0]));
    let mut belief = Belief::from_mass(&places, vec![1.0, 0.0]).unwrap();
    let before = belief.clone();
    for bad in [
        [f64::NAN, 0.0],
        [0.0, f64::INFINITY],
        [f64::NEG_INFINITY, 0.0],
    ] {
        assert!(bayes::correct(&mut belief, &bad).is_err(), "{bad:?}");
        assert_eq!(belief, before);
    }
    assert!(bayes::correct(&mut belief, &[0.0]).is_err());
    // The likelihood of a place without mass must not set the scale.
    bayes::correct(&mut belief, &[-2000.0, 0.0]).unwrap();
    assert_eq!(belief, before);
    let grid = grid(&corridor());
    let mut robot = BayesFilter::new(
        &grid,
        OdometryMotion::default(),
        Belief::uniform(grid.places()).unwrap(),
    )
    .unwrap();
    assert!(robot.predict(&step(f64::NAN, 0.0, 0.0)).is_err());
    assert!(BayesFilter::new(&grid, OdometryMotion::default(), before).is_err());
}

#[test]
fn one_thread_or_many_give_the_same_bits() {
    let run = |threads: usize| -> Vec<u64> {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .unwrap();
        pool.install(|| {
            let mapped = bend();
            let config = GridConfig {
                cell_m: 0.15,
                ..GridConfig::default()
            };
            let grid = Arc::new(Grid::over(&mapped, &config).unwrap());
            assert!(grid.len() > 10_000, "several blocks of sums");
            let mut random = Seed(4).stream("threads");
            let activation = random_activations(mapped.len(), 4, &mut random);
            let map = FeatureMap::new(mapped, activation, MapConfig::default()).unwrap();
            let map = map.at(grid.places()).unwrap();
            let prior = Belief::uniform(grid.places()).unwrap();
            let mut robot = BayesFilter::new(&grid, OdometryMotion::default(), prior).unwrap();
            for t in 0..12 {
                let g: Vec<f64> = (0..4).map(|_| random.random()).collect();
                let evidence = Evidence::ALL[t % 4];
                let log = evidence
                    .log_likelihood(&g, &map, robot.belief(), &mut random)
                    .unwrap();
                robot.correct(&log).unwrap();
                robot.predict(&step(0.3, 0.1, 0.2)).unwrap();
            }
            let belief = robot.belief();
            let truth = bend();
            let judged = [belief.expected_error_m(&truth, 0), belief.entropy_bits()];
            belief
                .mass()
                .iter()
                .chain(&judged)
                .map(|m| m.to_bits())
                .collect()
        })
    };
    let one = run(1);
    assert!(one == run(2) && one == run(4));
}
