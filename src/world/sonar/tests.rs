use super::*;
use crate::{
    seed::Seed,
    world::{FloorPlan, Material, Raycaster, Wall},
};
use nalgebra::{Point2, Vector2};

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
fn exact(config: SonarConfig) -> SonarConfig {
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

fn upright(x_m: f64, critical_angle_rad: f64) -> Wall {
    let material = Material {
        reflectivity: 1.0,
        critical_angle_rad,
        ..Material::PLAIN
    };
    Wall::new(Point2::new(x_m, -9.0), Point2::new(x_m, 9.0), material)
}

/// One scan from the origin, facing along x.
fn scan(config: SonarConfig, walls: Vec<Wall>) -> Vec<f32> {
    let sonar = Sonar::new(config).unwrap();
    let caster = Raycaster::new(FloorPlan::new(walls).unwrap());
    let mut random = Seed(7).stream("noise");
    sonar.read(&(&caster).into(), &Pose::default(), &mut random)
}

fn close(reading_m: f32, expected_m: f64, within_m: f64) -> bool {
    (f64::from(reading_m) - expected_m).abs() < within_m
}

/// Eight sonars, 0.3 m from the centre.
fn wide_ring(opening_deg: f64) -> SonarConfig {
    exact(SonarConfig {
        beams: 8,
        ring_radius_m: 0.3,
        opening_rad: opening_deg.to_radians(),
        rays: 801,
        ..SonarConfig::default()
    })
}

#[test]
fn a_later_sonar_takes_an_earlier_ones_echo_for_its_own() {
    let firing_after = |firing_interval_s| SonarConfig {
        firing: vec![vec![0, 2, 4, 6], vec![1, 3, 5, 7]],
        firing_interval_s,
        ..wide_ring(60.0)
    };
    let wall = || vec![upright(2.0, 0.8)];
    let quiet = scan(wide_ring(60.0), wall());
    // Sonar 1, at 0.3 m (cos 45°, sin 45°), meets the wall at the edge of its cone, 15° off the normal.
    let at_m = 0.3 * std::f64::consts::FRAC_1_SQRT_2;
    let own_m = (2.0 - at_m) / 15_f64.to_radians().cos();
    assert!(close(quiet[1], own_m, 1e-4), "{}", quiet[1]);
    // Sonar 0's sound is scattered there too: on its way from (0.3, 0) to that spot and on to sonar 1.
    let spot_m = at_m + (2.0 - at_m) * 15_f64.to_radians().tan();
    let way_m = 1.7_f64.hypot(spot_m) + own_m;
    let together = scan(firing_after(0.0), wall());
    assert!(close(together[1], way_m / 2.0, 1e-3), "{}", together[1]);
    // Fired 5 ms later, sonar 1 has listened for 5 ms less: 1.7162 m of sound at 343.2 m/s.
    let later = scan(firing_after(0.005), wall());
    let expected_m = (way_m - 0.005 * 343.2) / 2.0;
    assert!(close(later[1], expected_m, 1e-3), "{}", later[1]);
    assert_eq!(
        later[0], quiet[0],
        "the one that fires first hears nothing sooner"
    );
    assert!(later[3..6].iter().all(|metres| metres.is_nan()));
    // After 60 ms, 20.6 m of sound, the air is quiet.
    assert_eq!(scan(firing_after(0.06), wall())[..2], quiet[..2]);
}

#[test]
fn mirrors_throw_a_pulse_at_another_sonar_unless_something_stands_between() {
    let firing = SonarConfig {
        firing: vec![(0..8).collect()],
        ..wide_ring(100.0)
    };
    // Sonar 1 seen in the mirror stands at 4 m − 0.2121, 0.2121 aside of sonar 0's height.
    let at_m = 0.3 * std::f64::consts::FRAC_1_SQRT_2;
    let way_m = (4.0 - at_m - 0.3).hypot(at_m);
    let heard = scan(firing.clone(), vec![upright(2.0, 0.02)]);
    assert!(close(heard[1], way_m / 2.0, 5e-3), "{}", heard[1]);
    let quiet = scan(wide_ring(100.0), vec![upright(2.0, 0.02)]);
    assert!(close(quiet[1], 2.0 - at_m, 1e-3), "{}", quiet[1]);
    // A board ahead of sonar 0, too dull to be heard itself, takes its sound away.
    let dull = Material {
        reflectivity: 0.01,
        ..Material::PLAIN
    };
    let board = Wall::new(Point2::new(1.0, -0.9), Point2::new(1.0, 0.15), dull);
    let hidden = scan(firing, vec![upright(2.0, 0.02), board]);
    assert!(close(hidden[1], 2.0 - at_m, 1e-3), "{}", hidden[1]);
}

#[test]
fn a_plain_sonar_tells_the_nearest_wall_in_its_cone_whatever_it_is() {
    let plain = |walls: Vec<Wall>| {
        let config = SonarConfig {
            ring_radius_m: 0.0,
            resolution_m: 0.0,
            ..SonarConfig::sancho2()
        };
        scan(config, walls)
    };
    let turned = |deg: f64| {
        let (sin, cos) = deg.to_radians().sin_cos();
        let (foot, along) = (Point2::new(cos, sin) * 2.0, Vector2::new(-sin, cos) * 9.0);
        let mirror = upright(0.0, 0.01).material;
        Wall::new(foot - along, foot + along, mirror)
    };
    // The wall's foot lies in the cone of ±15° up to there; past it, the cone's edge meets the wall first.
    for deg in [0.0, 10.0, -14.0] {
        assert!(close(plain(vec![turned(deg)])[0], 2.0, 1e-6));
    }
    let edge_m = 2.0 / 25_f64.to_radians().cos();
    assert!(close(plain(vec![turned(40.0)])[0], edge_m, 1e-6));
    // 110° and more aside, it slants away from the cone; all twelve cones together see all round.
    assert!(plain(vec![turned(110.0)])[0].is_nan());
    let short = |x_m: f64, y1_m: f64, y2_m: f64| {
        Wall::new(
            Point2::new(x_m, y1_m),
            Point2::new(x_m, y2_m),
            Material::PLAIN,
        )
    };
    // A door frame whose edge stands 14° aside is seen, one 16° aside is not: the room behind is.
    let frame = |deg: f64| short(1.0, deg.to_radians().tan(), 5.0);
    let behind = upright(3.0, 0.2);
    assert!(close(
        plain(vec![frame(14.0), behind])[0],
        1.0 / 14_f64.to_radians().cos(),
        1e-6
    ));
    assert!(close(plain(vec![frame(16.0), behind])[0], 3.0, 1e-6));
    // Nothing past 6 m; a bench lower than the ring (0.3 m) is not there.
    assert!(plain(vec![upright(6.0, 0.2)])[0].is_nan());
    let bench = short(1.0, -1.0, 1.0).between(0.0, 0.25);
    assert!(close(plain(vec![bench, behind])[0], 3.0, 1e-6));
}

#[test]
fn a_plain_sonar_tells_what_many_rays_find() {
    let mut random = Seed(8).stream("walls");
    let config = SonarConfig {
        resolution_m: 0.0,
        ..SonarConfig::sancho2()
    };
    let sonar = Sonar::new(config.clone()).unwrap();
    for _ in 0..50 {
        let mut end = || {
            Point2::new(
                random.random_range(-3.0..3.0),
                random.random_range(-3.0..3.0),
            )
        };
        let walls: Vec<Wall> = (0..6)
            .map(|_| Wall::new(end(), end(), Material::PLAIN))
            .collect();
        let caster = Raycaster::new(FloorPlan::new(walls).unwrap());
        let around = Surroundings::from(&caster);
        for beam in 0..12 {
            let axis_rad = sonar.bearing_rad(beam);
            let place = Point2::new(axis_rad.cos(), axis_rad.sin()) * 0.25;
            let by_rays = (0..=4000)
                .filter_map(|ray| {
                    let angle = axis_rad + (f64::from(ray) / 4000.0 - 0.5) * config.opening_rad;
                    let direction = Vector2::new(angle.cos(), angle.sin());
                    around.cast(&place, &direction, 5.999, 0.3)
                })
                .map(|hit| hit.distance_m)
                .min_by(f64::total_cmp);
            let exactly = sonar.echo_m(&around, &Pose::default(), beam);
            match (by_rays, exactly) {
                (None, None) => {}
                // Rays miss what is thinner than the way between them, and are never nearer than the nearest.
                (Some(rays_m), Some(exact_m)) => {
                    assert!(
                        (-1e-9..0.01).contains(&(rays_m - exact_m)),
                        "{rays_m} {exact_m}"
                    );
                }
                (rays, exact) => panic!("rays: {rays:?}, exactly: {exact:?}"),
            }
        }
    }
}

#[test]
fn sancho_tells_ranges_in_steps_of_four_centimetres() {
    // 2.345 − 0.25 = 2.095 m: 52.4 steps
    let reading_m = scan(SonarConfig::sancho2(), vec![upright(2.345, 0.2)])[0];
    assert!(close(reading_m, 52.0 * 0.04, 1e-6), "{reading_m}");
}

#[test]
fn a_detailed_scan_is_nine_scans_of_a_turret_that_turns() {
    let ring = |detailed| {
        Sonar::new(exact(SonarConfig {
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
    let cases: [(&str, &dyn Fn(&mut SonarConfig)); 11] = [
        ("`detailed`", &|c| c.detailed = 0),
        ("readings", &|c| c.detailed = 5000),
        ("`height_m`", &|c| c.height_m = f64::NAN),
        ("`ring_radius_m`", &|c| c.ring_radius_m = -0.1),
        ("`firing_interval_s`", &|c| c.firing_interval_s = -0.1),
        ("`air_celsius`", &|c| c.air_celsius = -300.0),
        ("`calibrated_celsius`", &|c| c.calibrated_celsius = f64::NAN),
        ("sonar 24", &|c| c.firing = vec![(0..25).collect()]),
        ("sonar 3 0 times", &|c| c.firing = vec![vec![0, 1, 2]]),
        ("sonar 5 2 times", &|c| {
            c.firing = vec![(0..24).collect(), vec![5]];
        }),
        ("`plain`", &|c| {
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
