//! The pictures of `docs/worlds/thrun1998.md`: what the camera of `configs/worlds/thrun1998.toml` sees along its corridor.
//! `cargo test --release --test binary camera_views -- --ignored` draws them anew.

use ballmark::{
    geometry::Pose,
    recording::image::Image,
    seed::Seed,
    world::{Building, Camera, CameraConfig, Raycaster, camera::Direction},
};
use std::{f64::consts::FRAC_PI_2, path::Path};

const NORTH: f64 = FRAC_PI_2;
const WEST: f64 = 2.0 * FRAC_PI_2;
/// The picture's rows, each a direction: places on the middle of the corridor, metres, with the robot's heading.
const VIEWS: [(Direction, [[f64; 3]; 5]); 3] = [
    (
        Direction::Right,
        [
            [10.0, 0.0, 0.0],    // an office door
            [25.93, 0.64, 1.2],  // the window at the first corner
            [26.0, 18.3, NORTH], // a blackboard
            [26.0, 21.4, NORTH], // the dark spot
            [1.9, 37.858, WEST], // a door in orange
        ],
    ),
    (
        Direction::Left,
        [
            [6.1, 0.0, 0.0],       // a class room's doors
            [26.0, 13.9, NORTH],   // the hallway
            [26.0, 22.7, NORTH],   // the elevator
            [22.25, 37.858, WEST], // where the orange begins
            [9.6, 37.858, WEST],   // a blackboard
        ],
    ),
    (
        Direction::Up,
        [
            [2.4, 0.0, 0.0],     // under a lamp
            [5.0, 0.0, 0.0],     // between two
            [26.0, 16.5, NORTH], // the last one before the dark spot
            [26.0, 21.2, NORTH], // the dark spot
            [26.0, 26.7, NORTH], // two near each other
        ],
    ),
];
/// White pixels between two views.
const GAP: usize = 2;

#[test]
#[ignore = "draws docs/worlds/thrun1998-views.png"]
fn views_along_the_corridor() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let corridor = Building::read(&root.join("configs/worlds/thrun1998.toml")).unwrap();
    let scene = corridor.plan_of_run(Seed(1), 0).unwrap();
    let caster = Raycaster::new(scene.plan.clone());
    let (rows, columns) = (60, 64);
    let width = VIEWS[0].1.len() * (columns + GAP) - GAP;
    let mut values = vec![255; (VIEWS.len() * (rows + GAP) - GAP) * width * 3];
    for (line, (look, places)) in VIEWS.into_iter().enumerate() {
        let camera = Camera::new(CameraConfig {
            look,
            ..CameraConfig::default()
        })
        .unwrap();
        for (number, [x_m, y_m, heading_rad]) in places.into_iter().enumerate() {
            let pose = Pose::new(x_m, y_m, heading_rad);
            let mut noise = Seed(1).numbered_stream("docs/views", (5 * line + number) as u64);
            let view = camera.render(&scene, &(&caster).into(), &pose, &mut noise);
            for row in 0..rows {
                for column in 0..columns {
                    let at =
                        (line * (rows + GAP) + row) * width + number * (columns + GAP) + column;
                    values[3 * at..3 * at + 3].copy_from_slice(&view.pixel(row, column));
                }
            }
        }
    }
    let sheet = Image::new(VIEWS.len() * (rows + GAP) - GAP, width, values).unwrap();
    std::fs::write(
        root.join("docs/worlds/thrun1998-views.png"),
        sheet.to_png().unwrap(),
    )
    .unwrap();
}
