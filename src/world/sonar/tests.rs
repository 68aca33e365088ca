use super::*;
use crate::{
    seed::Seed,
    world::{FloorPlan, Material, Raycaster, Wall},
};
use nalgebra::Point2;

#[test]
fn noise_has_the_stated_statistics() {
    let config = SonarConfig {
        short_probability: 0.1,
        lost_probability: 0.2,
        resolution_m: 0.0,
        ..Default::default()
    };
    let (sonar, n) = (Sonar::new(config).unwrap(), 100_000);
    let mut random = Seed(5).stream("noise");
    let readings: Vec<Option<f64>> = (0..n)
        .map(|_| sonar.corrupted(Some(3.0), &Chance::draw(&mut random)))
        .collect();
    let lost = readings.iter().filter(|reading| reading.is_none()).count() as f64 / n as f64;
    assert!((lost - 0.2).abs() < 0.005, "{lost}"); // 4 standard errors
    // Short ones are uniform on [0.15, 3]: 2.35/2.85 of them lie below 2.5, where no noisy echo comes.
    let short: Vec<f64> = readings
        .iter()
        .flatten()
        .copied()
        .filter(|&metres| metres < 2.5)
        .collect();
    let share = short.len() as f64 / n as f64;
    assert!((share - 0.1 * 2.35 / 2.85).abs() < 0.004, "{share}");
    let mean = short.iter().sum::<f64>() / short.len() as f64;
    assert!((mean - (0.15 + 2.5) / 2.0).abs() < 0.03, "{mean}");

    let sonar = Sonar::new(SonarConfig {
        short_probability: 0.0,
        lost_probability: 0.0,
        ..sonar.config
    })
    .unwrap();
    let errors: Vec<f64> = (0..n)
        .map(|_| {
            sonar
                .corrupted(Some(3.0), &Chance::draw(&mut random))
                .unwrap()
                - 3.0
        })
        .collect();
    let mean = errors.iter().sum::<f64>() / n as f64;
    let sd = (errors.iter().map(|error| error * error).sum::<f64>() / n as f64).sqrt();
    // 0.01 + 0.01 · 3 m
    assert!(
        mean.abs() < 0.0006 && (sd - 0.04).abs() < 0.0004,
        "{mean} ± {sd}"
    );
}

#[test]
fn readings_step_by_the_resolution_and_stay_in_their_bounds() {
    let sonar = Sonar::new(SonarConfig {
        short_probability: 0.0,
        resolution_m: 0.05,
        ..Default::default()
    })
    .unwrap();
    let mut random = Seed(6).stream("noise");
    for echo_m in [0.02, 1.3, 9.99] {
        for reading_m in
            (0..2000).filter_map(|_| sonar.corrupted(Some(echo_m), &Chance::draw(&mut random)))
        {
            let steps = reading_m / 0.05;
            assert!((steps - steps.round()).abs() < 1e-9 && (0.15..10.0).contains(&reading_m));
        }
    }
}

#[test]
fn constants_out_of_bounds_are_told_by_name() {
    let default = SonarConfig::default;
    for (key, config) in [
        (
            "beams",
            SonarConfig {
                beams: 0,
                ..default()
            },
        ),
        (
            "rays",
            SonarConfig {
                rays: 1_000_000,
                ..default()
            },
        ),
        (
            "opening_rad",
            SonarConfig {
                opening_rad: -0.1,
                ..default()
            },
        ),
        (
            "noise_m",
            SonarConfig {
                noise_m: -0.1,
                ..default()
            },
        ),
        (
            "noise_per_m",
            SonarConfig {
                noise_per_m: f64::NAN,
                ..default()
            },
        ),
        (
            "maximum_m",
            SonarConfig {
                maximum_m: 0.1,
                ..default()
            },
        ),
        (
            "lost_probability",
            SonarConfig {
                lost_probability: 1.5,
                ..default()
            },
        ),
    ] {
        let error = Sonar::new(config).unwrap_err();
        assert!(
            error.is_usage() && error.to_string().contains(&format!("`{key}`")),
            "{error}"
        );
    }
    assert!(serde_json::from_str::<SonarConfig>(r#"{"beams": 16}"#).is_ok());
    assert!(serde_json::from_str::<SonarConfig>(r#"{"beems": 16}"#).is_err());
}

/// A ring without chance in it.
pub(super) fn exact(config: SonarConfig) -> SonarConfig {
    SonarConfig {
        axis_sd_rad: 0.0,
        noise_m: 0.0,
        noise_per_m: 0.0,
        resolution_m: 0.0,
        short_probability: 0.0,
        lost_probability: 0.0,
        ..config
    }
}

/// That and echoes that never fade.
fn steady(config: SonarConfig) -> SonarConfig {
    SonarConfig {
        edge_loss_db: 0.0,
        incidence_loss_db: 0.0,
        fading_db: 0.0,
        late_m: 0.0,
        ..exact(config)
    }
}

pub(super) fn upright(x_m: f64, critical_angle_rad: f64) -> Wall {
    let material = Material {
        reflectivity: 1.0,
        critical_angle_rad,
        ..Material::PLAIN
    };
    Wall::new(Point2::new(x_m, -9.0), Point2::new(x_m, 9.0), material)
}

/// One scan from the origin, facing along x.
pub(super) fn scan(config: SonarConfig, walls: Vec<Wall>) -> Vec<f32> {
    let sonar = Sonar::new(config).unwrap();
    let caster = Raycaster::new(FloorPlan::new(walls).unwrap());
    let mut random = Seed(7).stream("noise");
    sonar.read(&(&caster).into(), &Pose::default(), &mut random)
}

pub(super) fn close(reading_m: f32, expected_m: f64, within_m: f64) -> bool {
    (f64::from(reading_m) - expected_m).abs() < within_m
}

#[test]
fn a_detailed_scan_is_nine_scans_of_a_turret_that_turns() {
    let ring = |detailed| {
        Sonar::new(steady(SonarConfig {
            detailed,
            ..SonarConfig::nomad200()
        }))
        .unwrap()
    };
    let walls = vec![
        upright(2.0, 0.6),
        Wall::new(
            Point2::new(-9.0, 1.0),
            Point2::new(9.0, 1.0),
            Material::PLAIN,
        ),
    ];
    let caster = Raycaster::new(FloorPlan::new(walls).unwrap());
    let (around, mut random) = (Surroundings::from(&caster), Seed(9).stream("noise"));
    let detailed = ring(9).read(&around, &Pose::default(), &mut random);
    let mut differing = 0;
    for set in 0..9 {
        let turned = Pose::new(0.0, 0.0, (2.5 * set as f64).to_radians());
        let coarse = ring(1).read(&around, &turned, &mut random);
        for (beam, expected) in coarse.into_iter().enumerate() {
            let got = detailed[beam * 9 + set];
            // One more sine in the last bit may put a ray on the other side of a critical angle.
            let same = (got - expected).abs() < 1e-4 || (got.is_nan() && expected.is_nan());
            differing += usize::from(!same);
        }
    }
    assert!(differing <= 1, "{differing} of 144");
    let bearings = ring(9).channel().bearing_rad.unwrap();
    for (value, bearing_rad) in bearings.iter().enumerate() {
        assert!(wrapped(bearing_rad - (2.5 * value as f64).to_radians()).abs() < 1e-12);
    }
}

#[test]
fn in_cold_air_walls_seem_farther() {
    let reading_m = |air_celsius, calibrated_celsius| {
        let config = exact(SonarConfig {
            air_celsius,
            calibrated_celsius,
            ..SonarConfig::default()
        });
        scan(config, vec![upright(3.26, 0.2)])[0]
    };
    // √(293.15 / 273.15) = 1.03596
    assert!(close(reading_m(0.0, 20.0), 3.0 * 1.035_96, 1e-4));
    assert!(close(reading_m(25.0, 25.0), 3.0, 1e-6));
}

#[test]
fn options_out_of_bounds_are_told_by_name() {
    type Case = (&'static str, fn(&mut SonarConfig));
    let cases: [Case; 15] = [
        ("`detailed`", |c| c.detailed = 0),
        ("readings", |c| c.detailed = 5000),
        ("`opening_rad`", |c| {
            c.plain = true;
            c.opening_rad = 0.0;
        }),
        ("`height_m`", |c| c.height_m = f64::NAN),
        ("`ring_radius_m`", |c| c.ring_radius_m = -0.1),
        ("`edge_loss_db`", |c| c.edge_loss_db = -1.0),
        ("`fading_db`", |c| c.fading_db = f64::NAN),
        ("`late_m`", |c| c.late_m = -0.1),
        ("`firing_interval_s`", |c| c.firing_interval_s = -0.1),
        ("`air_celsius`", |c| c.air_celsius = -300.0),
        ("`calibrated_celsius`", |c| c.calibrated_celsius = f64::NAN),
        ("sonar 24", |c| c.firing = vec![(0..25).collect()]),
        ("sonar 3 0 times", |c| c.firing = vec![vec![0, 1, 2]]),
        ("sonar 5 2 times", |c| {
            c.firing = vec![(0..24).collect(), vec![5]];
        }),
        ("`plain`", |c| {
            c.plain = true;
            c.firing = vec![(0..24).collect()];
        }),
    ];
    for (part, change) in cases {
        let mut config = SonarConfig::default();
        change(&mut config);
        let error = Sonar::new(config).unwrap_err();
        let line = error.to_string();
        assert!(error.is_usage() && line.contains(part), "{line}");
    }
    for config in [SonarConfig::nomad200(), SonarConfig::sancho2()] {
        assert!(Sonar::new(config).is_ok());
    }
}
