use super::*;
use crate::seed::Seed;

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
        ..OdometryConfig::default()
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

/// A closed route, twice round a square of 10 m, in steps of half a metre.
fn round_trip() -> Vec<Pose> {
    let step = Displacement {
        forward_m: 0.5,
        ..Displacement::default()
    };
    let corner = Displacement {
        turn_rad: std::f64::consts::FRAC_PI_2,
        ..Displacement::default()
    };
    let mut path = vec![Pose::new(1.0, 2.0, 0.3)];
    for number in 1..=160 {
        let next = path[path.len() - 1].after(step);
        path.push(if number % 20 == 0 {
            next.after(corner)
        } else {
            next
        });
    }
    path
}

fn last(config: &OdometryConfig, run: u64, turret_error_rad: impl Fn(usize) -> f64) -> Pose {
    let mut slip = Seed(3).numbered_stream("slip", run);
    let mut odometry = DeadReckoning::draw(config, &mut slip);
    let mut reached = Pose::default();
    for (step, pose) in round_trip().iter().enumerate() {
        reached = odometry.reach_beside(pose, turret_error_rad(step), &mut slip);
    }
    reached
}

#[test]
fn by_compass_errors_in_heading_are_the_turrets_and_do_not_add_up() {
    let config = OdometryConfig {
        translation_noise_m: 0.0,
        creep: [0.0, 0.0],
        rotation_drift_rad_per_m: 0.5,
        rotation_noise_rad: 0.5,
        ..OdometryConfig::by_compass()
    };
    let origin = Pose::default();
    // A turret that stands aside turns the whole way, which still closes.
    for error_rad in [0.0, 0.2] {
        let end = last(&config, 1, |_| error_rad);
        assert!(end.distance_m(&origin) < 1e-9, "{end:?}");
        assert!(wrapped(end.heading_rad - (0.3 - error_rad)).abs() < 1e-9);
    }
    // Aside by 0.2 rad on the first leg only: that leg, of 10 m, is turned by as much, but for the half step where
    // the turret turns back: 2 · 10 m · sin(0.1).
    let end = last(&config, 1, |step| if step < 20 { 0.2 } else { 0.0 });
    let expected_m = 2.0 * 10.0 * 0.1_f64.sin();
    assert!(
        (end.distance_m(&origin) - expected_m).abs() < 0.06,
        "{end:?}"
    );
    assert!(wrapped(end.heading_rad - 0.3).abs() < 1e-9);
    // By the wheels the same drift turns the robot round and round.
    let by_wheels = OdometryConfig {
        by_compass: false,
        ..config
    };
    assert!(last(&by_wheels, 1, |_| 0.0).distance_m(&origin) > 1.0);
    assert_eq!(last(&by_wheels, 1, |_| 0.0), last(&by_wheels, 1, |_| 0.2));
}

#[test]
fn by_compass_a_closed_route_ends_two_to_five_percent_of_the_way_off() {
    let config = OdometryConfig {
        translation_noise_m: 0.0,
        ..OdometryConfig::by_compass()
    };
    // 80 m: 1.6 to 4 m, evenly in all directions.
    let ends: Vec<Pose> = (0..2000).map(|run| last(&config, run, |_| 0.1)).collect();
    let off_m: Vec<f64> = ends.iter().map(|end| end.x_m.hypot(end.y_m)).collect();
    assert!(
        off_m
            .iter()
            .all(|metres| (1.6 - 1e-9..4.0 + 1e-9).contains(metres))
    );
    let mean = off_m.iter().sum::<f64>() / 2000.0;
    // 4 standard errors of 2.4 / √12
    assert!((mean - 2.8).abs() < 0.062, "{mean}");
    let (x_m, y_m) = ends
        .iter()
        .fold((0.0, 0.0), |(x, y), end| (x + end.x_m, y + end.y_m));
    assert!((x_m / 2000.0).hypot(y_m / 2000.0) < 0.25);
}

#[test]
fn what_creeps_keeps_its_direction_when_the_wheels_lose_theirs() {
    let config = OdometryConfig {
        translation_noise_m: 0.0,
        by_compass: false,
        rotation_drift_rad_per_m: 0.5,
        creep: [0.03, 0.03],
        ..OdometryConfig::by_compass()
    };
    for run in 0..20 {
        let mut slip = Seed(3).numbered_stream("slip", run);
        let mut odometry = DeadReckoning::draw(&config, &mut slip);
        // With every step turned to where the robot truly faced, only the creep is left: 3 % of 80 m.
        let (mut reached, mut last) = (Pose::default(), None);
        for truth in round_trip() {
            let now = odometry.reach(&truth, &mut slip);
            if let Some((facing, before)) = last.replace((truth, now)) {
                let from = Pose {
                    heading_rad: facing.heading_rad,
                    ..reached
                };
                reached = from.after(Pose::displacement_to(&before, &now));
            }
        }
        let off_m = reached.x_m.hypot(reached.y_m);
        assert!((off_m - 2.4).abs() < 1e-9, "{off_m}");
    }
}

#[test]
fn constants_out_of_bounds_are_told_by_name() {
    type Case = (&'static str, fn(&mut OdometryConfig));
    let cases: [Case; 7] = [
        ("translation_drift", |c| c.translation_drift = -0.1),
        ("rotation_drift_rad_per_m", |c| {
            c.rotation_drift_rad_per_m = f64::NAN
        }),
        ("translation_noise_m", |c| c.translation_noise_m = -0.1),
        ("rotation_noise_rad", |c| {
            c.rotation_noise_rad = f64::INFINITY
        }),
        ("creep", |c| c.creep = [0.05, 0.02]),
        ("creep", |c| c.creep = [-0.01, 0.02]),
        ("creep", |c| c.creep = [0.0, f64::NAN]),
    ];
    for (key, change) in cases {
        let mut config = OdometryConfig::default();
        change(&mut config);
        let error = config.check().unwrap_err();
        assert!(
            error.is_usage() && error.to_string().contains(&format!("`{key}`")),
            "{error}"
        );
    }
    assert!(OdometryConfig::by_compass().check().is_ok());
}
