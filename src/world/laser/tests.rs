use super::*;
use crate::{
    seed::Seed,
    world::{FloorPlan, Material, Raycaster, floor_plan::round},
};

/// A beam a degree, the middle one straight ahead, 90° to either side.
fn fan() -> LaserConfig {
    LaserConfig {
        beams: 181,
        field_of_view_rad: 181_f64.to_radians(),
        ahead_m: 0.0,
        ..LaserConfig::default()
    }
}

fn upright(x_m: f64, material: Material) -> Wall {
    Wall::new(Point2::new(x_m, -9.0), Point2::new(x_m, 9.0), material)
}

/// Where the beams end, by degrees to the left.
fn seen(walls: &[Wall], pose: Pose, left_deg: i32) -> Option<f64> {
    let laser = Laser::new(fan()).unwrap();
    let caster = Raycaster::new(FloorPlan::new(walls.to_vec()).unwrap());
    laser.range_m(&(&caster).into(), &pose, (90 + left_deg) as usize)
}

#[test]
fn beams_share_the_field_of_view() {
    let half = Laser::new(LaserConfig::default()).unwrap();
    assert!((half.bearing_rad(0).to_degrees() + 89.5).abs() < 1e-12);
    assert!((half.bearing_rad(179).to_degrees() - 89.5).abs() < 1e-12);
    // All round, no two beams look the same way.
    let round = Laser::new(LaserConfig {
        beams: 360,
        field_of_view_rad: TAU,
        ..LaserConfig::default()
    })
    .unwrap();
    let bearings = round.channel().bearing_rad.unwrap();
    assert!((bearings[0].to_degrees() + 179.5).abs() < 1e-9 && bearings.len() == 360);
    for pair in bearings.windows(2) {
        assert!(((pair[1] - pair[0]).to_degrees() - 1.0).abs() < 1e-9);
    }
}

#[test]
fn a_wall_a_corner_and_a_door_frame_are_where_geometry_has_them() {
    let plain = Material::PLAIN;
    let walls = [
        upright(3.0, plain),
        Wall::new(Point2::new(-9.0, 2.0), Point2::new(3.0, 2.0), plain),
    ];
    let place = Pose::new(0.0, 0.0, 20_f64.to_radians());
    for turned_deg in [-40, 0, 13] {
        // The plan's direction of the beam, from the x axis.
        let angle = f64::from(turned_deg + 20).to_radians();
        let expected_m = (3.0 / angle.cos()).min(if angle > 0.0 {
            2.0 / angle.sin()
        } else {
            f64::INFINITY
        });
        assert!((seen(&walls, place, turned_deg).unwrap() - expected_m).abs() < 1e-9);
    }
    // Into the corner, at (3, 2).
    let into = Pose::new(0.0, 0.0, 2_f64.atan2(3.0));
    assert!((seen(&walls, into, 0).unwrap() - 13_f64.sqrt()).abs() < 1e-6);
    // Through a door from y = −0.5 to 0.5 in a wall at 3 m, the room's back at 5 m. The frame ends at 9.46°.
    let door = [
        Wall::new(Point2::new(3.0, 0.5), Point2::new(3.0, 9.0), plain),
        Wall::new(Point2::new(3.0, -9.0), Point2::new(3.0, -0.5), plain),
        upright(5.0, plain),
    ];
    let ahead = Pose::default();
    let through_m = 5.0 / 9_f64.to_radians().cos();
    let beside_m = 3.0 / 10_f64.to_radians().cos();
    assert!((seen(&door, ahead, 9).unwrap() - through_m).abs() < 1e-9);
    assert!((seen(&door, ahead, 10).unwrap() - beside_m).abs() < 1e-9);
}

#[test]
fn a_person_is_seen_before_the_wall_and_glass_is_not() {
    let person = round(Point2::new(2.0, 0.0), 0.2, 64, Material::PLAIN);
    let walls = [person, vec![upright(4.0, Material::PLAIN)]].concat();
    assert!((seen(&walls, Pose::default(), 0).unwrap() - 1.8).abs() < 1e-3);
    // 0.2 m aside at 2 m is 5.7°.
    assert!(
        (seen(&walls, Pose::default(), 6).unwrap() - 4.0 / 6_f64.to_radians().cos()).abs() < 1e-9
    );
    let glass = Material {
        infrared: 0.05,
        ..Material::PLAIN
    };
    let panes = [
        upright(1.0, glass),
        upright(1.02, glass),
        upright(4.0, Material::PLAIN),
    ];
    assert!((seen(&panes, Pose::default(), 0).unwrap() - 4.0).abs() < 1e-9);
    assert_eq!(seen(&panes[..2], Pose::default(), 0), None);
}

#[test]
fn nothing_comes_back_from_the_maximum_on() {
    let wall = [upright(20.0, Material::PLAIN)];
    assert_eq!(seen(&wall, Pose::default(), 0), None);
    assert!(seen(&wall, Pose::new(0.01, 0.0, 0.0), 0).is_some());
}

#[test]
fn noise_has_the_stated_statistics() {
    let config = LaserConfig {
        short_probability: 0.1,
        lost_probability: 0.2,
        resolution_m: 0.0,
        ..LaserConfig::default()
    };
    let (laser, n) = (Laser::new(config.clone()).unwrap(), 100_000);
    let mut random = Seed(5).stream("noise");
    let readings: Vec<Option<f64>> = (0..n)
        .map(|_| laser.corrupted(Some(10.0), &mut random))
        .collect();
    let share = |count: usize| count as f64 / f64::from(n);
    let lost = share(readings.iter().filter(|reading| reading.is_none()).count());
    assert!((lost - 0.2).abs() < 0.005, "{lost}"); // 4 standard errors
    // False ones are uniform on [0.02, 10]: 8.98/9.98 of them lie below 9, where no noise reaches.
    let short: Vec<f64> = readings
        .into_iter()
        .flatten()
        .filter(|&metres| metres < 9.0)
        .collect();
    let found = share(short.len());
    assert!((found - 0.1 * 8.98 / 9.98).abs() < 0.004, "{found}");
    let mean = short.iter().sum::<f64>() / short.len() as f64;
    assert!((mean - (0.02 + 9.0) / 2.0).abs() < 0.11, "{mean}");

    let laser = Laser::new(LaserConfig {
        short_probability: 0.0,
        lost_probability: 0.0,
        ..config
    })
    .unwrap();
    let errors: Vec<f64> = (0..n)
        .map(|_| laser.corrupted(Some(10.0), &mut random).unwrap() - 10.0)
        .collect();
    let mean = errors.iter().sum::<f64>() / f64::from(n);
    let sd = (errors.iter().map(|error| error * error).sum::<f64>() / f64::from(n)).sqrt();
    // 0.01 + 0.0005 · 10 m
    assert!(
        mean.abs() < 0.0002 && (sd - 0.015).abs() < 0.00014,
        "{mean} ± {sd}"
    );
}

#[test]
fn readings_step_by_the_resolution() {
    let laser = Laser::new(LaserConfig {
        short_probability: 0.0,
        resolution_m: 0.05,
        ..LaserConfig::default()
    })
    .unwrap();
    let mut random = Seed(6).stream("noise");
    for range_m in [0.0, 1.3, 19.99] {
        for told_m in (0..2000).filter_map(|_| laser.corrupted(Some(range_m), &mut random)) {
            let steps = told_m / 0.05;
            let stepped = (steps - steps.round()).abs() < 1e-9 || told_m == 0.02;
            assert!(stepped && (0.02..20.0).contains(&told_m), "{told_m}");
        }
    }
}

#[test]
fn constants_out_of_bounds_are_told_by_name() {
    type Case = (&'static str, fn(&mut LaserConfig));
    let cases: [Case; 13] = [
        ("beams", |c| c.beams = 0),
        ("beams", |c| c.beams = 1_000_000),
        ("field_of_view_rad", |c| c.field_of_view_rad = 0.0),
        ("field_of_view_rad", |c| c.field_of_view_rad = 7.0),
        ("ahead_m", |c| c.ahead_m = f64::NAN),
        ("height_m", |c| c.height_m = f64::NAN),
        ("minimum_m", |c| c.minimum_m = -0.1),
        ("maximum_m", |c| c.maximum_m = -20.0),
        ("clear_below", |c| c.clear_below = 1.5),
        ("noise_m", |c| c.noise_m = f64::NAN),
        ("resolution_m", |c| c.resolution_m = -0.1),
        ("short_probability", |c| c.short_probability = -0.1),
        ("lost_probability", |c| c.lost_probability = f64::NAN),
    ];
    for (key, change) in cases {
        let mut config = LaserConfig::default();
        change(&mut config);
        let error = Laser::new(config).unwrap_err();
        assert!(
            error.is_usage() && error.to_string().contains(&format!("`{key}`")),
            "{error}"
        );
    }
    assert!(toml::from_str::<LaserConfig>("beams = 361").is_ok());
    assert!(toml::from_str::<LaserConfig>("beems = 361").is_err());
}
