//! Rendered pictures held against geometry worked out by hand, and noise against its stated model.

use super::{exposure::exposed, *};
use crate::{
    seed::Seed,
    world::{FloorPlan, Light, Look, Material, Raycaster, Wall, floor_plan::round},
};
use nalgebra::Point2;

mod light;
mod noise;

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
