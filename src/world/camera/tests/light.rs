//! Lamps, daylight and texture.

use super::*;

#[test]
fn lamps_light_what_they_see() {
    let lit = |at: f64, lit: bool, screen: Option<Wall>| {
        let light = Light {
            at: Point2::new(at, 0.0),
            lit,
            ..Light::default()
        };
        let long = wall([-20.0, 1.2], [20.0, 1.2], even(0.5));
        let walls = [long].into_iter().chain(screen).collect();
        let scene = RunScene {
            lights: vec![light],
            ..scene(walls)
        };
        let pixel = seen(Direction::Left, &scene).pixel(30, 32);
        f64::from(pixel[0])
    };
    let dark = lit(0.0, false, None);
    // Ambient light alone: 0.6 of grey 0.5 at exposure 0.6.
    assert!((dark - 0.6 * 0.5 * 0.6 * 255.0).abs() <= 0.5, "{dark}");
    let (abreast, aside) = (lit(0.0, true, None), lit(2.5, true, None));
    // By hand, abreast: L A = 8 · 3 · 0.36, r² = 1.2² + 1.4², cosines 1.2 / r and 1.4 / r, faded by (1 − r² / 144)².
    let squared = 1.2_f64.powi(2) + 1.4_f64.powi(2);
    let share = 0.36 * 1.2 * 1.4 / (squared * (std::f64::consts::PI * squared + 0.36));
    let direct = 24.0 * share * (1.0 - squared / 144.0).powi(2);
    assert!(
        (abreast - dark * (1.0 + direct / 0.6)).abs() <= 1.0,
        "{abreast} {direct}"
    );
    assert!(
        aside > dark + 2.0 && aside < abreast - 20.0,
        "{dark} {aside} {abreast}"
    );
    // A screen between lamp and wall, out of sight: its end hides the lamp from the spot.
    let screen = wall([1.0, -3.0], [1.0, 1.1], even(0.5));
    assert_eq!(lit(2.5, true, Some(screen)), dark);
    assert_eq!(lit(2.5, true, Some(screen.between(0.0, 1.0))), aside);
}

#[test]
fn daylight_comes_through_windows_and_lights_what_is_opposite() {
    let mut pane = even(0.1);
    pane.look.daylight = [0.5, 0.6, 0.7];
    let walls = vec![
        wall([-1.0, 2.0], [1.0, 2.0], pane).between(0.9, 2.1),
        wall([-9.0, 2.1], [9.0, 2.1], even(0.5)),
        wall([-9.0, -2.0], [9.0, -2.0], even(0.5)),
    ];
    let [night, day] = [0.0, 1.0].map(|daylight| RunScene {
        daylight,
        ..scene(walls.clone())
    });
    let ([dark, ..], bright) = (
        seen(Direction::Left, &night).pixel(30, 32),
        seen(Direction::Left, &day).pixel(30, 32),
    );
    assert!((f64::from(dark) - 0.1 * 0.6 * 0.6 * 255.0).abs() <= 0.5);
    let expected = [0.5, 0.6, 0.7].map(|light| (0.06 + light) * 0.6 * 255.0);
    let near = |(found, expected): (&u8, f64)| (f64::from(*found) - expected).abs() <= 0.6;
    assert!(bright.iter().zip(expected).all(near), "{bright:?}");
    // 4 m opposite, by hand: blue 0.7 from 2.4 m² face to face, 0.7 · 2.4 / (16 π + 2.4), faded by (1 − 16 / 144)²:
    // 0.025 more than the 0.6 from all around, on grey 0.5 at exposure 0.6.
    let opposite = |scene| seen(Direction::Right, scene).pixel(30, 32)[2];
    assert_eq!([opposite(&night), opposite(&day)], [46, 48]);
}

#[test]
fn texture_belongs_to_the_place() {
    let brick = Material {
        look: Look {
            contrast: 0.3,
            grain_m: 0.2,
            ..Look::PLAIN
        },
        ..Material::PLAIN
    };
    let line = |points: &[f64]| -> RunScene {
        let pairs = points.windows(2);
        scene(
            pairs
                .map(|p| wall([p[0], 2.0], [p[1], 2.0], brick))
                .collect(),
        )
    };
    let whole = seen(Direction::Left, &line(&[-9.0, 9.0]));
    assert_eq!(seen(Direction::Left, &line(&[9.0, 0.13, -9.0])), whole);
    // A wall a few steps behind is another surface.
    let other = scene(vec![wall([-9.0, -2.0], [9.0, -2.0], brick)]);
    assert_ne!(seen(Direction::Right, &other), whole);
    // And it is as strong as the material says: 0.3 of the mean, over a strip of 120 × 4 grains.
    let mut values = Vec::new();
    for step in 0..12 {
        let pose = Pose::new(f64::from(step) * 2.0 - 11.0, 0.0, 0.0);
        let image = rendered(&sharp(Direction::Left), &line(&[-30.0, 30.0]), &[], &pose);
        values.extend(
            (10..50)
                .flat_map(|r| row(&image, r))
                .map(|p| f64::from(p[0])),
        );
    }
    let mean = values.iter().sum::<f64>() / values.len() as f64;
    let variance = values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / values.len() as f64;
    assert!(
        (variance.sqrt() / mean - 0.3).abs() < 0.03,
        "{} {mean}",
        variance.sqrt()
    );
}
