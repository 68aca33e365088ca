use super::*;
use crate::{
    seed::Seed,
    world::{FloorPlan, Material, Raycaster, Wall, floor_plan::round},
};

const EXACT: InfraredConfig = InfraredConfig {
    beams: 16,
    ring_radius_m: 0.2,
    height_m: 0.5,
    opening_rad: 0.0,
    rays: 1,
    calibrated_to: 0.7,
    minimum_m: 0.05,
    maximum_m: 0.6,
    gain_sd: 0.0,
    stray_sd: 0.0,
    resolution_m: 0.0,
};

fn paint(infrared: f64) -> Material {
    Material {
        infrared,
        ..Material::PLAIN
    }
}

fn upright(x_m: f64, infrared: f64) -> Wall {
    Wall::new(
        Point2::new(x_m, -9.0),
        Point2::new(x_m, 9.0),
        paint(infrared),
    )
}

/// What the ring takes for ranges at a pose.
fn ranges(config: &InfraredConfig, walls: Vec<Wall>, pose: Pose) -> Vec<Option<f64>> {
    let ring = Infrared::new(config.clone()).unwrap();
    let caster = Raycaster::new(FloorPlan::new(walls).unwrap());
    (0..config.beams)
        .map(|beam| ring.range_m(&(&caster).into(), &pose, beam))
        .collect()
}

#[test]
fn a_wall_reads_its_distance_its_angle_and_its_paint() {
    let seen = ranges(&EXACT, vec![upright(0.5, 0.7)], Pose::default());
    assert!((seen[0].unwrap() - 0.3).abs() < 1e-12);
    // At 45° the sensor is 0.2 m out on the rim: (0.5 − 0.2 cos) / cos along the ray, and 1 / √cos farther by the angle.
    let cos = std::f64::consts::FRAC_1_SQRT_2;
    let slanted_m = (0.5 - 0.2 * cos) / cos / cos.sqrt();
    assert!(seen[2].is_none_or(|_| slanted_m < 0.6), "{seen:?}");
    let near = ranges(&EXACT, vec![upright(0.35, 0.7)], Pose::default());
    let slanted_m = (0.35 - 0.2 * cos) / cos / cos.sqrt();
    assert!((near[2].unwrap() - slanted_m).abs() < 1e-12, "{near:?}");
    assert_eq!(near[4..13], [None; 9], "nothing aside or behind");
    // Black paint, a ninth of the light: three times as far. A white wall seems nearer.
    let seen = |infrared| ranges(&EXACT, vec![upright(0.35, infrared)], Pose::default())[0];
    assert!((seen(0.7 / 9.0).unwrap() - 0.45).abs() < 1e-12);
    assert!((seen(1.0).unwrap() - 0.15 * 0.7_f64.sqrt()).abs() < 1e-12);
    assert_eq!(seen(0.7 / 17.0), None); // √17 · 0.15 m > 0.6 m
    assert_eq!(seen(0.0), None);
}

#[test]
fn a_corner_is_seen_by_each_sensor_on_its_own_wall() {
    let north = Wall::new(Point2::new(-9.0, 0.4), Point2::new(9.0, 0.4), paint(0.7));
    let seen = ranges(&EXACT, vec![upright(0.5, 0.7), north], Pose::default());
    assert!((seen[0].unwrap() - 0.3).abs() < 1e-12 && (seen[4].unwrap() - 0.2).abs() < 1e-12);
}

#[test]
fn a_beam_half_on_a_door_frame_gets_half_the_light() {
    let config = InfraredConfig {
        opening_rad: 10_f64.to_radians(),
        rays: 2,
        ..EXACT
    };
    // The frame ends on the axis: one of two rays meets it, and half the light is that from √2 times as far.
    let frame = Wall::new(Point2::new(0.5, -9.0), Point2::new(0.5, 0.0), paint(0.7));
    let seen = ranges(&config, vec![frame], Pose::default());
    assert!((seen[0].unwrap() - 0.3 * 2_f64.sqrt()).abs() < 1e-12);
    // A whole wall reads its distance, however wide the beam.
    let whole = ranges(&config, vec![upright(0.5, 0.7)], Pose::default());
    assert!((whole[0].unwrap() - 0.3).abs() < 1e-12);
}

#[test]
fn a_person_is_seen_up_to_their_head_and_hides_the_wall() {
    let legs: Vec<Wall> = round(Point2::new(0.6, 0.0), 0.15, 64, paint(0.7))
        .into_iter()
        .map(|wall| wall.between(0.0, 1.75))
        .collect();
    let seen_from = |height_m| {
        let config = InfraredConfig { height_m, ..EXACT };
        let walls = [legs.clone(), vec![upright(0.7, 0.7)]].concat();
        ranges(&config, walls, Pose::default())[0].unwrap()
    };
    // The polygon has a corner on the axis; its faces are all but head-on.
    assert!((seen_from(0.5) - 0.25).abs() < 1e-3, "{}", seen_from(0.5));
    assert!((seen_from(1.8) - 0.5).abs() < 1e-12);
}

#[test]
fn noise_has_the_stated_statistics() {
    let config = InfraredConfig {
        gain_sd: 0.04,
        stray_sd: 0.05,
        ..EXACT
    };
    let ring = Infrared::new(config).unwrap();
    let (mut random, n) = (Seed(5).stream("noise"), 100_000);
    for range_m in [0.1, 0.4] {
        let light = 0.7 / f64::powi(range_m, 2);
        let errors: Vec<f64> = (0..n)
            .map(|_| ring.told_m(ring.disturbed(light, &mut random)).unwrap() - range_m)
            .collect();
        let sd = (errors.iter().map(|error| error * error).sum::<f64>() / n as f64).sqrt();
        // d ∝ light^−½, so its relative error is half the light's: √(0.04² + (0.05 (d / 0.6)²)²) / 2.
        let stray = 0.05 * f64::powi(range_m / 0.6, 2);
        let expected = range_m * 0.04_f64.hypot(stray) / 2.0;
        assert!(
            (sd / expected - 1.0).abs() < 0.015,
            "{sd} for {expected} m at {range_m}"
        );
        // Second order: E d = d (1 + ⅜ var).
        let mean = errors.iter().sum::<f64>() / n as f64;
        let bias = range_m * 0.375 * (0.04_f64.powi(2) + stray * stray);
        assert!(
            (mean - bias).abs() < 4.0 * sd / f64::from(n).sqrt(),
            "{mean} for {bias}"
        );
    }
    // From the maximum exactly, every other reading is none.
    let light = 0.7 / f64::powi(0.6, 2);
    let none = (0..n).filter(|_| ring.told_m(ring.disturbed(light, &mut random)).is_none());
    let share = none.count() as f64 / f64::from(n);
    assert!((share - 0.5).abs() < 0.0065, "{share}"); // 4 standard errors
}

#[test]
fn readings_step_by_the_resolution_and_stay_in_their_bounds() {
    let ring = Infrared::new(InfraredConfig {
        minimum_m: 0.06,
        resolution_m: 0.03,
        ..Default::default()
    })
    .unwrap();
    let mut random = Seed(6).stream("noise");
    let light_from = |metres: f64| ring.reference / metres.powi(2);
    for range_m in [0.001, 0.2, 0.5, 0.59] {
        for _ in 0..2000 {
            if let Some(told_m) = ring.told_m(ring.disturbed(light_from(range_m), &mut random)) {
                let steps = told_m / 0.03;
                assert!((steps - steps.round()).abs() < 1e-9 && (0.06..0.6).contains(&told_m));
            }
        }
    }
    assert_eq!(ring.told_m(light_from(0.001)), Some(0.06), "saturated");
}

#[test]
fn constants_out_of_bounds_are_told_by_name() {
    type Case = (&'static str, fn(&mut InfraredConfig));
    let cases: [Case; 13] = [
        ("beams", |c| c.beams = 0),
        ("rays", |c| c.rays = 0),
        ("rays", |c| c.rays = 1_000_000),
        ("opening_rad", |c| c.opening_rad = PI),
        ("opening_rad", |c| c.opening_rad = f64::NAN),
        ("calibrated_to", |c| c.calibrated_to = 0.0),
        ("ring_radius_m", |c| c.ring_radius_m = f64::NAN),
        ("height_m", |c| c.height_m = -0.1),
        ("minimum_m", |c| c.minimum_m = -0.1),
        ("maximum_m", |c| c.maximum_m = -1.0),
        ("gain_sd", |c| c.gain_sd = -0.1),
        ("stray_sd", |c| c.stray_sd = f64::INFINITY),
        ("resolution_m", |c| c.resolution_m = -0.1),
    ];
    for (key, change) in cases {
        let mut config = InfraredConfig::default();
        change(&mut config);
        let error = Infrared::new(config).unwrap_err();
        assert!(
            error.is_usage() && error.to_string().contains(&format!("`{key}`")),
            "{error}"
        );
    }
    assert!(toml::from_str::<InfraredConfig>("beams = 8").is_ok());
    assert!(toml::from_str::<InfraredConfig>("beems = 8").is_err());
}
