//! The noise of the chip, its ends, and constants that make no sense.

use super::*;

#[test]
fn noise_has_the_stated_variance() {
    let config = CameraConfig {
        samples: 1,
        exposure: 1.0,
        read_noise: 3.0,
        full_well: 5000.0,
        ..CameraConfig::default()
    };
    for share in [0.2, 0.7] {
        let values = exposed(
            &config,
            &[[share; 3]; 60 * 64],
            &mut Seed(2).stream("camera"),
        );
        let values: Vec<f64> = values.into_iter().map(f64::from).collect();
        let count = values.len() as f64;
        let mean = values.iter().sum::<f64>() / count;
        let variance = values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / count;
        // Electronics, electrons (5000 of them are 255 steps), and rounding to whole steps.
        let expected: f64 = 9.0 + 255.0 * 255.0 * share / 5000.0 + 1.0 / 12.0;
        // Standard errors of 11,520 values: variance · √(2 / n), and deviation / √n.
        assert!(
            (variance / expected - 1.0).abs() < 4.0 * (2.0 / count).sqrt(),
            "{variance}"
        );
        assert!(
            (mean - 255.0 * share).abs() < 4.0 * (expected / count).sqrt(),
            "{mean}"
        );
    }
}

#[test]
fn too_much_light_ends_at_white_and_spills_over() {
    let mut rays = vec![[0.1; 3]; 60 * 64];
    rays[30 * 64 + 32] = [50.0; 3];
    let config = CameraConfig {
        exposure: 1.0,
        bloom: 0.1,
        ..sharp(Direction::Left)
    };
    let values = exposed(&config, &rays, &mut Seed(1).stream("camera"));
    let at = |row: usize, column: usize| values[3 * (row * 64 + column)];
    assert_eq!(at(30, 32), 255);
    assert!(at(30, 33) > 27 && at(30, 33) > at(30, 36) && at(27, 32) == at(33, 32));
    assert_eq!((at(30, 31), at(5, 5)), (at(30, 33), 26));
}

#[test]
fn the_same_noise_gives_the_same_picture() {
    let scene = scene(round(Point2::origin(), 3.0, 24, Material::PLAIN));
    let caster = Raycaster::new(scene.plan.clone());
    let camera = Camera::new(CameraConfig::default()).unwrap();
    let image = |stream| {
        let mut noise = Seed(1).numbered_stream("camera", stream);
        camera.render(&scene, &(&caster).into(), &Pose::default(), &mut noise)
    };
    assert_eq!(image(0), image(0));
    assert_ne!(image(0), image(1));
}

#[test]
fn bad_constants_get_one_clear_line() {
    let good = CameraConfig::default;
    for (config, part) in [
        (CameraConfig { rows: 0, ..good() }, "`rows` is 0"),
        (
            CameraConfig {
                columns: 100_000,
                ..good()
            },
            "`columns` is 100000",
        ),
        (
            CameraConfig {
                samples: 0,
                ..good()
            },
            "`samples` is 0",
        ),
        (
            CameraConfig {
                opening_rad: 3.2,
                ..good()
            },
            "`opening_rad` is 3.2",
        ),
        (
            CameraConfig {
                height_m: f64::NAN,
                ..good()
            },
            "`height_m` is NaN",
        ),
        (
            CameraConfig {
                exposure: 0.0,
                ..good()
            },
            "`exposure` is 0",
        ),
        (
            CameraConfig {
                bloom: 2.0,
                ..good()
            },
            "`bloom` is 2",
        ),
        (
            CameraConfig {
                read_noise: -1.0,
                ..good()
            },
            "`read_noise` is -1",
        ),
        (
            CameraConfig {
                full_well: 0.0,
                ..good()
            },
            "`full_well` is 0",
        ),
    ] {
        let error = Camera::new(config).unwrap_err();
        assert!(
            error.is_usage() && error.to_string().contains(part),
            "{error}"
        );
    }
    let tall = Camera::new(CameraConfig {
        height_m: 2.7,
        ..good()
    })
    .unwrap();
    let result = tall.check_in(&scene(vec![wall([0.0, 1.0], [1.0, 1.0], even(1.0))]));
    assert!(result.unwrap_err().to_string().contains("2.7"));
}
