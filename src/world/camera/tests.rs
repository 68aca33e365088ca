//! Rendered pictures held against geometry worked out by hand, and noise against its stated model.

use super::{exposure::exposed, *};
use crate::{
    seed::Seed,
    world::{FloorPlan, Light, Look, Material, Raycaster, Wall, floor_plan::round},
};
use nalgebra::Point2;

/// Even surfaces of one grey.
fn even(grey: f64) -> Material {
    Material {
        look: Look {
            colour: [grey; 3],
            contrast: 0.0,
            ..Look::PLAIN
        },
        ..Material::PLAIN
    }
}

fn wall(from: [f64; 2], to: [f64; 2], material: Material) -> Wall {
    Wall::new(from.into(), to.into(), material)
}

/// White floor and ceiling, no lamp.
fn scene(walls: Vec<Wall>) -> RunScene {
    RunScene {
        floor: even(1.0),
        ceiling: even(1.0),
        ..RunScene::of(FloorPlan::new(walls).unwrap())
    }
}

/// A camera whose picture is one ray a pixel, without noise: a pixel is 2 tan(25°) / 64 = 0.01457 wide at 1 m.
fn sharp(look: Direction) -> CameraConfig {
    CameraConfig {
        look,
        samples: 1,
        exposure: 0.6,
        bloom: 0.0,
        read_noise: 0.0,
        full_well: f64::INFINITY,
        ..CameraConfig::default()
    }
}

fn rendered(config: &CameraConfig, scene: &RunScene, passing: &[Wall], pose: &Pose) -> Image {
    let caster = Raycaster::new(scene.plan.clone());
    let around = Surroundings::new(&caster, passing);
    let camera = Camera::new(config.clone()).unwrap();
    camera.render(scene, &around, pose, &mut Seed(1).stream("camera"))
}

fn seen(look: Direction, scene: &RunScene) -> Image {
    rendered(&sharp(look), scene, &[], &Pose::default())
}

/// Rows of a column, or columns of a row, that are black.
fn black(pixels: impl Iterator<Item = [u8; 3]>) -> Vec<usize> {
    let numbered = pixels.enumerate();
    numbered
        .filter(|(_, p)| *p == [0; 3])
        .map(|(i, _)| i)
        .collect()
}

fn row(image: &Image, row: usize) -> Vec<[u8; 3]> {
    (0..image.columns()).map(|c| image.pixel(row, c)).collect()
}

fn column(image: &Image, column: usize) -> Vec<[u8; 3]> {
    (0..image.rows()).map(|r| image.pixel(r, column)).collect()
}

#[test]
fn a_wall_spans_the_rows_of_its_height() {
    // A black wall 1.8 m high, 3 m away, before a white one. From 1.2 m up its top lies 0.6 / 3 above the middle of the
    // picture, 13.7 pixels, and its foot 1.2 / 3 below, 27.4 pixels: the rows whose middles are from 13.5 above to 26.5
    // below.
    let high = wall([-20.0, 3.0], [20.0, 3.0], even(0.0)).between(0.0, 1.8);
    let far = wall([20.0, 6.0], [-20.0, 6.0], even(1.0));
    let image = seen(Direction::Left, &scene(vec![far, high]));
    for across in [0, 31, 63] {
        let rows = black(column(&image, across).into_iter());
        assert_eq!(rows, (16..=56).collect::<Vec<_>>(), "column {across}");
    }
    // A board that hangs from 1.5 m up to the ceiling: 0.3 / 3 is 6.86 pixels. The ceiling, 1.4 / 3 up, is above the picture.
    let board = high.between(1.5, f64::INFINITY);
    let image = seen(Direction::Left, &scene(vec![board, far]));
    let rows = black(column(&image, 31).into_iter());
    assert_eq!(rows, (0..=22).collect::<Vec<_>>());
}

#[test]
fn a_door_stands_in_the_columns_of_its_bearing() {
    // 0.3 to 0.7 m ahead of abreast, 2 m aside: 0.15 and 0.35 from the middle, 10.3 to 24.0 pixels.
    for (look, side, columns) in [
        (Direction::Left, 2.0, 42..=55),  // ahead is on the right
        (Direction::Right, -2.0, 8..=21), // ahead is on the left
    ] {
        let line = |from: f64, to: f64, grey| wall([from, side], [to, side], even(grey));
        let walls = vec![
            line(-9.0, 0.3, 1.0),
            line(0.3, 0.7, 0.0),
            line(0.7, 9.0, 1.0),
        ];
        let image = seen(look, &scene(walls));
        let found = black(row(&image, 30).into_iter());
        assert_eq!(found, columns.collect::<Vec<_>>(), "{look:?}");
    }
    // The same ahead: 0.3 to 0.7 m to the left of the way is on the left.
    let line = |from: f64, to: f64, grey| wall([2.0, from], [2.0, to], even(grey));
    let walls = vec![
        line(-9.0, 0.3, 1.0),
        line(0.3, 0.7, 0.0),
        line(0.7, 9.0, 1.0),
    ];
    let image = seen(Direction::Ahead, &scene(walls));
    assert_eq!(
        black(row(&image, 30).into_iter()),
        (8..=21).collect::<Vec<_>>()
    );
}

#[test]
fn a_turned_robot_sees_its_own_left() {
    // Facing north at (1, 2), left is west.
    let walls = vec![
        wall([-1.0, -9.0], [-1.0, 9.0], even(0.0)),
        wall([3.0, -9.0], [3.0, 9.0], even(1.0)),
    ];
    let north = Pose::new(1.0, 2.0, std::f64::consts::FRAC_PI_2);
    let middle = |look| rendered(&sharp(look), &scene(walls.clone()), &[], &north).pixel(30, 32);
    assert_eq!(middle(Direction::Left), [0; 3]);
    assert_ne!(middle(Direction::Right), [0; 3]);
}

/// Middle, height and width in pixels of what is brighter than a white surface.
fn bright_spot(image: &Image) -> ([f64; 2], usize, usize) {
    let most = *image.values().iter().max().unwrap();
    let places = (0..60).flat_map(|r| (0..64).map(move |c| (r, c)));
    let lit: Vec<_> = places
        .filter(|(r, c)| image.pixel(*r, *c)[0] == most)
        .collect();
    let rows: Vec<usize> = lit.iter().map(|place| place.0).collect();
    let columns: Vec<usize> = lit.iter().map(|place| place.1).collect();
    let ends = |all: &[usize]| (*all.iter().min().unwrap(), 1 + *all.iter().max().unwrap());
    let ((top, bottom), (left, right)) = (ends(&rows), ends(&columns));
    let middle = [(top + bottom) as f64 / 2.0, (left + right) as f64 / 2.0];
    assert_eq!(lit.len(), (bottom - top) * (right - left), "a rectangle");
    (middle, bottom - top, right - left)
}

#[test]
fn a_lamp_overhead_is_in_the_middle_and_one_ahead_below_it() {
    // 0.3 × 0.1 m, 1.4 m above the camera: 7.35 and 2.45 pixels to each side of its middle.
    let lamp = |x, y| {
        let light = Light {
            at: Point2::new(x, y),
            size_m: [0.3, 0.1],
            ..Light::default()
        };
        let walls = round(Point2::origin(), 8.0, 12, even(1.0));
        let scene = RunScene {
            lights: vec![light],
            ..scene(walls)
        };
        bright_spot(&seen(Direction::Up, &scene))
    };
    assert_eq!(lamp(0.0, 0.0), ([30.0, 32.0], 14, 4));
    // A fifth of a metre at 1.4 m is 9.8 pixels.
    let ([down, across], ..) = lamp(0.2, 0.0);
    assert!(
        (down - 39.8).abs() <= 1.0 && across == 32.0,
        "{down} {across}"
    );
    let ([down, across], ..) = lamp(0.0, 0.2);
    assert!(
        down == 30.0 && (across - 22.2).abs() <= 1.0,
        "{down} {across}"
    );
}

#[test]
fn walls_near_by_are_seen_when_looking_up() {
    // A wall 0.3 m to the left: rays more than 0.3 / 1.4 aside, 14.7 pixels, meet it below the ceiling.
    let image = seen(
        Direction::Up,
        &scene(vec![wall([-9.0, 0.3], [9.0, 0.3], even(0.0))]),
    );
    assert_eq!(
        black(row(&image, 30).into_iter()),
        (0..=16).collect::<Vec<_>>()
    );
}

#[test]
fn whoever_passes_hides_what_is_behind() {
    let scene = scene(vec![wall([-20.0, 3.0], [20.0, 3.0], even(1.0))]);
    // 0.5 m wide at 1 m: 17.2 pixels to each side; 1.7 m high: over the top of the picture.
    let person = wall([-0.25, 1.0], [0.25, 1.0], even(0.0)).between(0.0, 1.7);
    let image = rendered(&sharp(Direction::Left), &scene, &[person], &Pose::default());
    assert_eq!(
        black(row(&image, 30).into_iter()),
        (15..=48).collect::<Vec<_>>()
    );
    let behind = wall([-0.25, 4.0], [0.25, 4.0], even(0.0));
    let image = rendered(&sharp(Direction::Left), &scene, &[behind], &Pose::default());
    assert_eq!(black(row(&image, 30).into_iter()), [0; 0]);
}

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
        let told = Camera::new(config).unwrap_err();
        assert!(told.is_usage() && told.to_string().contains(part), "{told}");
    }
    let tall = Camera::new(CameraConfig {
        height_m: 2.7,
        ..good()
    })
    .unwrap();
    let told = tall.check_in(&scene(vec![wall([0.0, 1.0], [1.0, 1.0], even(1.0))]));
    assert!(told.unwrap_err().to_string().contains("2.7"));
}

/// Views of a small corridor, to be looked at: `BALLMARK_VIEWS=FOLDER cargo test --release views_to_look_at -- --ignored`.
#[test]
#[ignore = "writes pictures for people"]
fn views_to_look_at() {
    let folder = std::env::var_os("BALLMARK_VIEWS").map_or_else(std::env::temp_dir, Into::into);
    let coloured = |colour: [f64; 3], contrast: f64, grain_m: f64| Material {
        look: Look {
            colour,
            contrast,
            grain_m,
            ..Look::PLAIN
        },
        ..Material::PLAIN
    };
    let (orange, brown) = (
        coloured([0.8, 0.42, 0.15], 0.05, 0.1),
        coloured([0.68, 0.56, 0.4], 0.05, 0.1),
    );
    let (wood, steel) = (
        coloured([0.4, 0.25, 0.13], 0.15, 0.08),
        coloured([0.5; 3], 0.02, 0.1),
    );
    let mut pane = coloured([0.1, 0.1, 0.12], 0.0, 1.0);
    pane.look.daylight = [2.0, 2.2, 2.5];
    // Along x, 2.4 m wide: left orange with a door, right brown with a window, a bin; closed at both ends.
    let mut walls = vec![
        wall([-6.0, 1.2], [2.0, 1.2], orange),
        wall([2.0, 1.2], [2.0, 1.32], steel),
        wall([2.0, 1.32], [2.9, 1.32], wood),
        wall([2.9, 1.32], [2.9, 1.2], steel),
        wall([2.9, 1.2], [14.0, 1.2], orange),
        wall([-6.0, -1.2], [4.0, -1.2], brown),
        wall([4.0, -1.2], [5.6, -1.2], brown).between(0.0, 0.9),
        wall([4.0, -1.35], [5.6, -1.35], pane).between(0.0, 2.1),
        wall([4.0, -1.2], [5.6, -1.2], brown).between(2.1, f64::INFINITY),
        wall([4.0, -1.2], [4.0, -1.35], brown),
        wall([5.6, -1.35], [5.6, -1.2], brown),
        wall([5.6, -1.2], [14.0, -1.2], brown),
        wall([-6.0, -1.2], [-6.0, 1.2], steel),
        wall([14.0, -1.2], [14.0, 1.2], steel),
    ];
    let bin = round(
        Point2::new(8.0, 0.98),
        0.2,
        12,
        coloured([0.2, 0.3, 0.5], 0.0, 1.0),
    );
    walls.extend(bin.into_iter().map(|wall| wall.between(0.0, 0.7)));
    let light = |x| Light {
        at: Point2::new(x, 0.0),
        size_m: [0.3, 1.2],
        lit: x < 12.0,
        ..Light::default()
    };
    let scene = RunScene {
        lights: [-5.0, 0.0, 5.0, 10.0, 12.5].map(light).to_vec(),
        floor: coloured([0.35, 0.34, 0.33], 0.1, 0.3),
        ceiling: coloured([0.85; 3], 0.03, 0.6),
        ..RunScene::of(FloorPlan::new(walls).unwrap())
    };
    for (name, look, x, y) in [
        ("ahead", Direction::Ahead, 0.0, 0.0),
        ("left-door", Direction::Left, 2.2, -0.4),
        ("left-bin", Direction::Left, 7.6, -0.6),
        ("right-window", Direction::Right, 4.5, 0.4),
        ("right-wall", Direction::Right, 7.5, 0.4),
        ("up-lamp", Direction::Up, 4.8, 0.0),
        ("up-wall", Direction::Up, 4.2, 0.7),
        ("up-dark", Direction::Up, 12.2, 0.0),
    ] {
        for (size, factor) in [("small", 1), ("large", 5)] {
            let config = CameraConfig {
                look,
                rows: 60 * factor,
                columns: 64 * factor,
                ..CameraConfig::default()
            };
            let image = rendered(&config, &scene, &[], &Pose::new(x, y, 0.0));
            let png = image.to_png().unwrap();
            std::fs::write(folder.join(format!("{name}-{size}.png")), png).unwrap();
        }
    }
}
