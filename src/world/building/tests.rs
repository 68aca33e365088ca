//! Files, and what they come to.

use super::*;
use crate::world::Raycaster;
use nalgebra::{Point2, Vector2};

/// A hall of 10 × 6 m with one sonar, and whatever a test adds.
fn hall(wall: &str, rest: &str) -> Result<Building> {
    Building::from_text(&format!(
        "name = \"hall\"\n[[wall]]\npoints = [[0, 0], [10, 0], [10, 6], [0, 6]]\nclosed = true\n{wall}\n{rest}\n\
         [sonar]\n[path]\ncorners = [[1, 3], [9, 3]]\n[record]\nevery_m = 1\n"
    ))
}

/// What a ray meets in a plan: how far away, and the wall.
fn seen(scene: &RunScene, from: [f64; 2], to: [f64; 2], height_m: f64) -> (f64, Wall) {
    let caster = Raycaster::new(scene.plan.clone());
    let (from, to): (Point2<f64>, Point2<f64>) = (from.into(), to.into());
    let hit = caster
        .cast_at(&from, &(to - from).normalize(), 100.0, |wall| {
            wall.stands_at(height_m)
        })
        .unwrap();
    (hit.distance_m, scene.plan.walls()[hit.wall])
}

/// Straight down onto the first wall, `x` metres along it, from 2 m away.
fn depth_m(scene: &RunScene, x: f64, height_m: f64) -> f64 {
    seen(scene, [x, 2.0], [x, 0.0], height_m).0 - 2.0
}

fn near(a: f64, b: f64) -> bool {
    (a - b).abs() < 1e-9
}

#[test]
fn each_thing_in_a_wall_lies_where_the_file_says() {
    let world = hall(
        "[[wall.window]]\nat_m = 1\nwidth_m = 1\nsill_m = 0.8\nhead_m = 2\n\
         [[wall.niche]]\nat_m = 3\nwidth_m = 1\ndepth_m = 0.4\nback = \"steel\"\n\
         [[wall.niche]]\nat_m = 5\nwidth_m = 1\ndepth_m = -0.3\nlow_m = 0.5\nhigh_m = 1.0\n\
         [[wall.hallway]]\nat_m = 7\nwidth_m = 1\ndepth_m = 5\n\
         [[wall.door]]\nat_m = 8.5\nwidth_m = 1\n",
        "",
    )
    .unwrap();
    let scene = world.plan_of_run(Seed(1), 0).unwrap();
    for (x, height_m, behind_m) in [
        (0.5, 1.0, 0.0),
        (1.5, 0.5, 0.0), // under the sill
        (1.5, 1.0, 0.15),
        (1.5, 2.1, 0.0), // over the head
        (3.5, 1.0, 0.4),
        (5.5, 0.7, -0.3),
        (5.5, 0.2, 0.0), // under what stands out
        (5.5, 1.2, 0.0),
        (7.5, 1.0, 5.0),
        (9.0, 1.0, 0.12), // a shut door
    ] {
        let found_m = depth_m(&scene, x, height_m);
        assert!(near(found_m, behind_m), "{x} at {height_m}: {found_m}");
    }
    let steel = seen(&scene, [3.5, 2.0], [3.5, 0.0], 1.0).1.material;
    let glass = seen(&scene, [1.5, 2.0], [1.5, 0.0], 1.0).1.material;
    assert_eq!((steel.reflectivity, glass.infrared), (1.0, 0.1));
}

#[test]
fn paint_reaches_round_corners_and_the_later_one_covers() {
    let world = hall(
        "[[wall.paint]]\nfrom_m = 8\nto_m = 12\nmaterial = \"orange\"\n\
         [[wall.paint]]\nfrom_m = 9\nto_m = 9.5\nmaterial = \"steel\"\n",
        "[materials.orange]\ncolour = [0.9, 0.5, 0.1]\ncritical_angle_deg = 30\n",
    )
    .unwrap();
    let scene = world.plan_of_run(Seed(1), 0).unwrap();
    let red = |from, to| seen(&scene, from, to, 1.0).1.material.look.colour[0];
    let down = |x: f64| red([x, 2.0], [x, 0.0]);
    assert_eq!(
        [down(7.9), down(8.1), down(9.2), down(9.7)],
        [0.8, 0.9, 0.6, 0.9]
    );
    let right = |y: f64| red([8.0, y], [10.0, y]);
    assert_eq!([right(1.9), right(2.1)], [0.9, 0.8]);
    let orange = seen(&scene, [8.1, 2.0], [8.1, 0.0], 1.0).1.material;
    assert!(near(orange.critical_angle_rad, 30_f64.to_radians()));
}

#[test]
fn behind_left_puts_rooms_on_the_other_side() {
    let text = |behind| {
        format!(
            "name = \"line\"\n[[wall]]\npoints = [[0, 0], [10, 0]]\nbehind = \"{behind}\"\n\
             [[wall.niche]]\nat_m = 4\nwidth_m = 1\ndepth_m = 0.5\n\
             [sonar]\n[path]\ncorners = [[1, 3], [9, 3]]\n[record]\nevery_m = 1\n"
        )
    };
    let deepest_y = |behind| {
        let world = Building::from_text(&text(behind)).unwrap();
        let (low, high) = world.plan_of_run(Seed(1), 0).unwrap().plan.bounds();
        (low.y, high.y)
    };
    assert_eq!(
        (deepest_y("right"), deepest_y("left")),
        ((-0.5, 0.0), (0.0, 0.5))
    );
}

#[test]
fn doors_open_as_often_and_as_far_as_said_and_stay_shut_while_mapping() {
    let door = |more: &str| {
        hall(
            &format!(
                "[[wall.door]]\nat_m = 4\nwidth_m = 1\nopen = 0.3\nopened_deg = [60, 80]\n{more}\n"
            ),
            "",
        )
        .unwrap()
    };
    // The leaf is the only wood.
    let leaf = |scene: &RunScene| {
        let wood = scene
            .plan
            .walls()
            .iter()
            .find(|wall| wall.material.reflectivity == 0.8);
        let along: Vector2<f64> = wood.map(|leaf| leaf.to - leaf.from).unwrap();
        along.y.abs().atan2(along.x.abs()).to_degrees()
    };
    let world = door("");
    let angles: Vec<f64> = (0..1000)
        .map(|run| leaf(&world.plan_of_run(Seed(3), run).unwrap()))
        .collect();
    let open: Vec<f64> = angles
        .iter()
        .copied()
        .filter(|angle| *angle > 1.0)
        .collect();
    assert!((255..345).contains(&open.len()), "{}", open.len());
    assert!(open.iter().all(|angle| (60.0..=80.0).contains(angle)));
    let mean = open.iter().sum::<f64>() / open.len() as f64;
    assert!((mean - 70.0).abs() < 1.5, "{mean}");

    let world = door("shut_while_mapping = true");
    for run in 0..50 {
        assert!(leaf(&world.plan_while_mapping(Seed(3), run).unwrap()) < 1e-9);
        let later = leaf(&world.plan_of_run(Seed(3), run).unwrap());
        assert!(near(later, angles[run as usize])); // and doesn't shift any other draw
    }
}

#[test]
fn things_move_and_are_missing_and_light_varies_as_said() {
    let world = hall(
        "",
        "[[thing]]\nat = [5, 1]\nradius_m = 0.2\nheight_m = 0.7\nmoved_sd_m = 0.2\npresent = 0.6\n\
         [building]\nillumination_sd = 0.1\ndaylight = [0.2, 0.8]\n",
    )
    .unwrap();
    let scenes: Vec<RunScene> = (0..1000)
        .map(|run| world.plan_of_run(Seed(4), run).unwrap())
        .collect();
    let present: Vec<f64> = scenes
        .iter()
        .filter_map(|scene| {
            let sides = &scene.plan.walls()[4..];
            let middle = sides.iter().map(|side| side.from.x).sum::<f64>() / 12.0;
            (!sides.is_empty()).then_some(middle - 5.0)
        })
        .collect();
    assert!((550..650).contains(&present.len()), "{}", present.len());
    let sd = |all: &[f64]| (all.iter().map(|x| x * x).sum::<f64>() / all.len() as f64).sqrt();
    // Cut at two standard deviations, a normal distribution's is 0.2 · √0.92 = 0.192.
    assert!((sd(&present) - 0.192).abs() < 0.015, "{}", sd(&present));
    let brightness: Vec<f64> = scenes
        .iter()
        .map(|scene| scene.illumination - 1.0)
        .collect();
    assert!((sd(&brightness) - 0.1).abs() < 0.008);
    assert!(
        scenes
            .iter()
            .all(|scene| (0.2..=0.8).contains(&scene.daylight))
    );
    let mean = scenes.iter().map(|scene| scene.daylight).sum::<f64>() / 1000.0;
    assert!((mean - 0.5).abs() < 0.02);
}

#[test]
fn a_thing_may_move_along_its_wall_alone() {
    let thing = "[[thing]]\nat = [5, 1]\nradius_m = 0.2\nmoved_sd_m = 0.2\nmoved_deg = 90\n";
    let world = hall("", thing).unwrap();
    let middles: Vec<[f64; 2]> = (0..100)
        .map(|run| {
            let scene = world.plan_of_run(Seed(4), run).unwrap();
            let sides = scene.plan.walls()[4..].iter();
            let sum = sides.fold(Vector2::zeros(), |sum, side| sum + side.from.coords);
            [sum.x / 12.0, sum.y / 12.0]
        })
        .collect();
    assert!(middles.iter().all(|middle| near(middle[0], 5.0)));
    assert!(middles.iter().any(|middle| (middle[1] - 1.0).abs() > 0.2));
}

#[test]
fn a_preset_brings_its_robot_and_the_file_has_the_last_word() {
    let robot_with = |robot: &str, rest: &str| {
        Building::from_text(&format!(
            "name = \"hall\"\nwall = [{{ points = [[0, 0], [10, 0]] }}]\n{rest}\n[robot]\n{robot}\n\
             [path]\ncorners = [[1, 3], [9, 3]]\n[record]\nevery_m = 1\n"
        ))
    };
    let nomad = robot_with("kind = \"nomad200\"", "").unwrap();
    let sensors = &nomad.sets()[0].sensors;
    assert_eq!(nomad.robot().speed_m_per_s, 0.122);
    assert!(nomad.turret_north() && nomad.robot().odometry.by_compass);
    assert_eq!(sensors.sonar.as_ref().unwrap().channel().width, 16);
    assert_eq!(sensors.infrared.as_ref().unwrap().channel().width, 16);
    assert!(sensors.compass.is_some() && sensors.camera.is_none());

    let changed = "kind = \"nomad200\"\nspeed_m_per_s = 0.3\nturret_north = false";
    let changed = robot_with(changed, "infrared = false\nsonar = { maximum_m = 5.0 }").unwrap();
    let sensors = &changed.sets()[0].sensors;
    assert_eq!(
        (changed.robot().speed_m_per_s, changed.robot().radius_m),
        (0.3, 0.23)
    );
    assert!(!changed.turret_north() && !changed.robot().odometry.by_compass);
    assert!(sensors.infrared.is_none());
    let sonar = sensors.sonar.as_ref().unwrap().channel();
    assert_eq!((sonar.width, sonar.maximum), (16, Some(5.0)));

    let b21 = robot_with("kind = \"b21\"", "").unwrap();
    let sensors = &b21.sets()[0].sensors;
    assert_eq!(sensors.sonar.as_ref().unwrap().channel().width, 24);
    assert!(sensors.camera.is_some() && b21.robot().speed_m_per_s == 0.15);
    let sancho = robot_with("kind = \"sancho2\"", "").unwrap();
    let sonar = sancho.sets()[0].sensors.sonar.as_ref().unwrap();
    assert_eq!(
        (sonar.channel().width, sonar.config().resolution_m),
        (12, 0.04)
    );
}

/// The page that explains the file shows one that runs.
#[test]
fn the_example_of_the_page_on_the_format_runs() {
    let page = include_str!("../../../docs/worlds/format.md");
    let example = page.split("```").nth(1).unwrap();
    let world = Building::from_text(example.trim_start_matches("toml")).unwrap();
    let choice = crate::world::simulation::Choice::default();
    let recording = crate::world::simulation::simulate(&world, Seed(1), &choice).unwrap();
    assert_eq!((recording.runs().len(), recording.channels().len()), (2, 3));
}
