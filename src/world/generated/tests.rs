//! What holds for every generated building.

use super::*;
use crate::{
    geometry::wrapped,
    world::{Material, Wall},
};
use nalgebra::Vector2;
use std::collections::BTreeSet;

/// Shorter runs than usual, so that tests take less time.
fn short() -> GeneratedConfig {
    GeneratedConfig {
        path_m: [30.0, 50.0],
        ..GeneratedConfig::default()
    }
}

/// Without noise, people, glass and lost beams.
fn exact() -> GeneratedConfig {
    GeneratedConfig {
        noise_m: [0.0, 0.0],
        dropped: vec![0.0],
        glass: vec![0.0],
        blank: vec![0.0],
        people: vec![0.0],
        ..short()
    }
}

fn site(config: &GeneratedConfig, number: u64) -> Option<Site> {
    Site::draw(config, number, Seed(1)).unwrap()
}

fn building(config: &GeneratedConfig, number: u64, seed: u64) -> GeneratedBuilding {
    GeneratedBuilding::draw(config, number, Seed(seed))
        .unwrap()
        .unwrap()
}

fn bits(recording: &Recording) -> Vec<u64> {
    let columns = recording.columns();
    let poses = columns.pose.iter().chain(&columns.odometry);
    let poses = poses.flat_map(|pose| [pose.x_m, pose.y_m, pose.heading_rad]);
    let others = columns
        .stamp_s
        .iter()
        .copied()
        .chain(poses)
        .map(f64::to_bits);
    let values = columns
        .values
        .iter()
        .map(|value| u64::from(value.to_bits()));
    others.chain(values).collect()
}

/// A ray hits the nearest of all walls of a visit, tried one by one, metres; ∞ where there is none.
fn nearest_m(walls: &[Wall], pose: &Pose, bearing_rad: f64) -> f64 {
    let angle_rad = pose.heading_rad + bearing_rad;
    let direction = Vector2::new(angle_rad.cos(), angle_rad.sin());
    let origin = Point2::new(pose.x_m, pose.y_m);
    let met = walls.iter().filter_map(|wall| {
        let (along, offset) = (wall.to - wall.from, wall.from - origin);
        let across = direction.perp(&along);
        let (t, u) = (
            offset.perp(&along) / across,
            offset.perp(&direction) / across,
        );
        (t >= 0.0 && (0.0..=1.0).contains(&u)).then_some(t)
    });
    met.fold(f64::INFINITY, f64::min)
}

#[test]
fn number_and_seed_say_all() {
    let one = building(&short(), 3, 1);
    let again = building(&short(), 3, 1);
    assert_eq!(bits(&one.first), bits(&again.first));
    assert_eq!(bits(&one.second), bits(&again.second));
    for other in [building(&short(), 4, 1), building(&short(), 3, 2)] {
        assert_ne!(bits(&one.first), bits(&other.first));
        assert_ne!(bits(&one.second), bits(&other.second));
    }
    // More later visits change neither the first run nor the visits before them.
    let more = GeneratedConfig {
        visits: 4,
        ..short()
    };
    let more = building(&more, 3, 1);
    assert_eq!(bits(&one.first), bits(&more.first));
    let rows = one.second.len();
    assert_eq!(
        one.second.poses(),
        &more.second.poses()[..rows],
        "labels of visits 1 to 3"
    );
}

#[test]
fn all_kinds_come_up_and_few_buildings_are_refused() {
    let sites: Vec<Site> = (0..40)
        .filter_map(|number| site(&short(), number))
        .collect();
    assert!(sites.len() >= 36, "{} of 40", sites.len());
    let kinds: BTreeSet<PlanKind> = sites.iter().map(|site| site.kind).collect();
    assert_eq!(kinds.len(), 4, "{kinds:?}");
    let tiny = GeneratedConfig {
        least_free_m2: 1e5,
        ..short()
    };
    assert!(site(&tiny, 0).is_none());
}

#[test]
fn the_robot_stands_inside_and_clear_of_every_wall_of_the_moment() {
    let mut beside_m = Vec::new();
    for number in 0..24 {
        let Some(site) = site(&short(), number) else {
            continue;
        };
        assert_eq!(site.visits.len(), 4);
        let first = &site.visits[0].truth;
        for (index, visit) in site.visits.iter().enumerate() {
            assert_eq!(visit.truth.len(), first.len());
            for (pose, place) in visit.truth.iter().zip(first) {
                let point = Point2::new(pose.x_m, pose.y_m);
                let clear_m = visit.caster.plan().clearance_m(&point);
                assert!(
                    clear_m > 0.15,
                    "building {number}, visit {index}: {clear_m}"
                );
                assert!(
                    site.plan.is_inside(&point),
                    "building {number}, visit {index}"
                );
                if index > 0 {
                    beside_m.push(pose.distance_m(place));
                    assert!(pose.turn_rad(place) < 1.2);
                }
            }
        }
    }
    // Drawn with .1, .2 and .4 m on both axes: √(π/2) · .23 m = .29 m in the mean, less where walls are near.
    let mean_m = beside_m.iter().sum::<f64>() / beside_m.len() as f64;
    assert!((0.2..0.36).contains(&mean_m), "{mean_m}");
}

#[test]
fn doors_and_things_are_others_at_another_visit() {
    let config = GeneratedConfig {
        changed: vec![0.25],
        ..short()
    };
    let (mut doors, mut changed) = (0, 0);
    for number in 0..40 {
        let Some(site) = site(&config, number) else {
            continue;
        };
        for later in &site.visits[1..] {
            doors += site.plan.doorways.len();
            changed += later.moment.doors_changed(&site.visits[0].moment);
        }
    }
    let share = changed as f64 / doors as f64;
    assert!(
        doors > 1000 && (0.2..0.28).contains(&share),
        "{changed} of {doors}"
    );
}

#[test]
fn ranges_are_those_to_the_nearest_wall_of_the_plan() {
    for number in 0..4 {
        let site = site(&exact(), number).unwrap();
        let building = building(&exact(), number, 1);
        let channel = &building.first.channels()[0];
        let bearings = channel.bearing_rad.as_ref().unwrap();
        assert_eq!(
            (channel.name.as_str(), channel.width, channel.maximum),
            ("laser", 180, Some(80.0))
        );
        for (beam, bearing) in bearings.iter().enumerate() {
            assert!((bearing.to_degrees() - (beam as f64 - 90.0)).abs() < 1e-9);
        }
        let columns = [building.first.columns(), building.second.columns()];
        assert!(columns[0].run.iter().all(|run| *run == 0));
        let places = building.first.len();
        for (k, run) in columns[1].run.iter().enumerate() {
            assert_eq!(*run, 1 + (k / places) as i64);
        }
        for (visit, rows) in [(0, columns[0]), (1, columns[1])] {
            let visit = &site.visits[visit];
            let walls = visit.caster.plan().walls();
            for k in (0..places).step_by(17) {
                for beam in (0..180).step_by(7) {
                    let expected_m = nearest_m(walls, &visit.truth[k], bearings[beam]);
                    let found_m = f64::from(rows.values[(k, beam)]);
                    if expected_m < 80.0 {
                        assert!(
                            (found_m - expected_m.max(0.05)).abs() < 1e-3,
                            "{found_m} {expected_m}"
                        );
                    } else {
                        assert!(found_m.is_nan());
                    }
                }
            }
        }
    }
}

#[test]
fn ranges_of_a_plan_drawn_by_hand_are_worked_out_by_hand() {
    // 2 m to the right, 3 m ahead, 4 m to the left; nothing behind.
    let wall = |from: [f64; 2], to: [f64; 2]| Wall::new(from.into(), to.into(), Material::PLAIN);
    let walls = vec![
        wall([-1.0, -2.0], [3.0, -2.0]),
        wall([3.0, -2.0], [3.0, 4.0]),
        wall([3.0, 4.0], [0.5, 4.0]),
    ];
    let caster = Raycaster::new(FloorPlan::new(walls).unwrap());
    let mut sensor = Sensor::draw(&exact(), 0, Seed(1)).unwrap();
    let scan = sensor.scan(&caster, &Pose::default()).unwrap();
    let at = |deg: i32| scan[(deg + 90) as usize];
    for (deg, expected) in [
        (-90, 2.0),
        (-60, 2.0 / 60_f32.to_radians().sin()),
        (-30, 3.0 / 30_f32.to_radians().cos()), // √12 m ahead, before 4 m to the wall on the right
        (0, 3.0),
        (45, 3.0 * 2_f32.sqrt()),
        (60, 4.0 / 60_f32.to_radians().sin()),
    ] {
        assert!((at(deg) - expected).abs() < 1e-5, "{deg}°: {}", at(deg));
    }
    assert!(
        at(84).is_nan(),
        "past the last wall's end: tan 84° · 0.5 m = 4.8 m"
    );
}

#[test]
fn readings_are_ranges_within_reach() {
    for sensor in [GeneratedSensor::Laser, GeneratedSensor::Sonar] {
        let config = GeneratedConfig { sensor, ..short() };
        let (mut returned, mut all) = (0, 0);
        for number in 0..4 {
            let building = building(&config, number, 1);
            for recording in [&building.first, &building.second] {
                let maximum = recording.channels()[0].maximum.unwrap() as f32;
                let ranges = recording.values().iter().filter(|range| !range.is_nan());
                all += recording.values().len();
                for range in ranges {
                    assert!(*range > 0.0 && *range <= maximum, "{range}");
                    returned += 1;
                }
            }
        }
        let share = f64::from(returned) / all as f64;
        assert!((0.5..1.0).contains(&share), "{sensor:?}: {share}");
    }
}

#[test]
fn a_ring_of_sonars_hears_what_it_meets_head_on() {
    let config = GeneratedConfig {
        sensor: GeneratedSensor::Sonar,
        ..short()
    };
    let building = building(&config, 0, 1);
    let channel = &building.first.channels()[0];
    assert_eq!(
        (channel.name.as_str(), channel.width, channel.maximum),
        ("sonar", 24, Some(7.0))
    );
    for (sonar, bearing) in channel.bearing_rad.as_ref().unwrap().iter().enumerate() {
        let expected = 15_f64.to_radians() * sonar as f64;
        assert!(wrapped(bearing - expected).abs() < 1e-9);
    }
    // A cone hears nothing that lies behind the nearest wall in it.
    let site = site(&config, 0).unwrap();
    let walls = site.visits[0].caster.plan().walls();
    let mut nearer = 0;
    for (k, pose) in site.visits[0].truth.iter().enumerate().step_by(5) {
        for sonar in 0..24 {
            let middle_rad = channel.bearing_rad.as_ref().unwrap()[sonar];
            let within = (-20..=20)
                .map(|deg| nearest_m(walls, pose, middle_rad + f64::from(deg).to_radians()));
            let nearest = within.fold(f64::INFINITY, f64::min);
            let range = f64::from(building.first.values()[(k, sonar)]);
            nearer += usize::from(range < nearest - 0.3);
        }
    }
    let readings = site.visits[0].truth.len().div_ceil(5) * 24;
    assert!(nearer * 25 < readings, "{nearer} of {readings} too short");
}

#[test]
fn people_only_shorten_beams() {
    let alone = building(&exact(), 5, 1);
    let crowd = GeneratedConfig {
        people: vec![1.0],
        ..exact()
    };
    let crowd = building(&crowd, 5, 1);
    let (mut shorter, mut all) = (0, 0);
    for (with, without) in [(&crowd.first, &alone.first), (&crowd.second, &alone.second)] {
        assert_eq!(with.poses(), without.poses());
        for (with, without) in with.values().iter().zip(without.values()) {
            all += 1;
            if without.is_nan() {
                shorter += usize::from(!with.is_nan());
            } else {
                assert!(with <= without, "{with} after {without}");
                shorter += usize::from(with < without);
            }
        }
    }
    // Three people of .08 to .3 m at .5 to 5 m cover 3 · 10° of 180°, where no wall hides them.
    let share = shorter as f64 / f64::from(all);
    assert!((0.02..0.2).contains(&share), "{share}");
}

#[test]
fn glass_is_seen_in_some_scans_and_not_in_others() {
    let pane = Wall::new(
        Point2::new(2.0, -9.0),
        Point2::new(2.0, 9.0),
        Material {
            infrared: 0.15,
            ..Material::PLAIN
        },
    );
    let caster = Raycaster::new(FloorPlan::new(vec![pane]).unwrap());
    let mut sensor = Sensor::draw(&exact(), 0, Seed(1)).unwrap();
    let seen = (0..100).filter(|_| !sensor.scan(&caster, &Pose::default()).unwrap()[90].is_nan());
    let seen = seen.count();
    assert!((30..70).contains(&seen), "{seen} of 100");
    let glazed = GeneratedConfig {
        glass: vec![1.0],
        ..short()
    };
    let site = site(&glazed, 1).unwrap();
    let panes = site
        .plan
        .walls
        .iter()
        .filter(|wall| wall.material.infrared < 0.3);
    assert!(panes.count() > 10);
}

#[test]
fn labels_stay_within_centimetres_of_the_truth_and_drift_slowly() {
    let config = GeneratedConfig::default();
    let (mut worst_m, mut step_m, mut sum_m) = (0.0_f64, 0.0_f64, 0.0);
    let mut count = 0.0;
    for number in 0..6 {
        let Some(site) = site(&config, number) else {
            continue;
        };
        let building = building(&config, number, 1);
        let off = |k: usize| {
            let (label, truth) = (building.first.poses()[k], site.visits[0].truth[k]);
            Vector2::new(label.x_m - truth.x_m, label.y_m - truth.y_m)
        };
        for k in 1..building.first.len() {
            worst_m = worst_m.max(off(k).norm());
            step_m += (off(k) - off(k - 1)).norm();
            sum_m += off(k).norm();
            count += 1.0;
        }
        let later = site.visits[1..].iter().flat_map(|visit| &visit.truth);
        for (label, truth) in building.second.poses().iter().zip(later) {
            assert!(label.distance_m(truth) < 0.3 && label.turn_rad(truth) < 0.08);
        }
    }
    assert!(worst_m < 0.25, "{worst_m}");
    assert!(sum_m / count > 0.01, "{}", sum_m / count);
    assert!(
        step_m < sum_m,
        "steps of {step_m} m against errors of {sum_m} m"
    );
}
