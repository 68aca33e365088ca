use super::*;
use crate::{
    geometry::Pose,
    world::{FloorPlan, Material, Raycaster, Sonar, SonarConfig},
};

const RADIUS_M: f64 = 0.23;

/// A corridor along x, 2 m wide, and fire doors across it at both ends.
fn corridor() -> (Raycaster, Vec<Wall>) {
    let along = |y_m| {
        Wall::new(
            Point2::new(-10.0, y_m),
            Point2::new(60.0, y_m),
            Material::PLAIN,
        )
    };
    let across = |x_m| {
        Wall::new(
            Point2::new(x_m, -0.5),
            Point2::new(x_m, 1.5),
            Material::PLAIN,
        )
    };
    let caster = Raycaster::new(FloorPlan::new(vec![along(-0.5), along(1.5)]).unwrap());
    (caster, vec![across(-2.0), across(52.0)])
}

/// 50 m along the corridor and back, its right wall 0.5 m away on the way there, at 0.125 m/s, for two laps.
fn path() -> Vec<TimedPose> {
    let outward = |second: i32| Pose::new(0.125 * f64::from(second), 0.0, 0.0);
    let back = |second: i32| Pose::new(50.0 - 0.125 * f64::from(second), 1.0, std::f64::consts::PI);
    let lap: Vec<Pose> = (0..400).map(outward).chain((0..400).map(back)).collect();
    let laps = lap.iter().chain(&lap).enumerate();
    laps.map(|(second, pose)| TimedPose {
        stamp_s: second as f64,
        pose: *pose,
    })
    .collect()
}

/// Duckett & Nehmzow's environment F.
fn crowd() -> PeopleConfig {
    PeopleConfig {
        map_laps: 1.0,
        passing: 29,
        between: 11,
        standing: 9,
        fire_doors_opened: 4,
        ..PeopleConfig::default()
    }
}

fn with<T>(config: &PeopleConfig, run: u64, judge: impl FnOnce(Result<People>) -> T) -> T {
    let ((caster, doors), path) = (corridor(), path());
    let outing = Outing {
        path: &path,
        map_until_s: 800.0,
        around: Surroundings::new(&caster, &doors),
        radius_m: RADIUS_M,
        wall_on_left: Some(false),
    };
    judge(People::new(config, Seed(1), run, &outing))
}

fn come(config: &PeopleConfig, run: u64) -> People {
    with(config, run, Result::unwrap)
}

/// Walls of people at a time.
fn bodies(people: &People, stamp_s: f64) -> Vec<Wall> {
    let mut walls = Vec::new();
    people.passing_at(stamp_s, &mut walls);
    walls.retain(|wall| wall.high_m < f64::INFINITY);
    walls
}

#[test]
fn as_many_come_as_asked_for_and_none_while_mapping() {
    let people = come(&crowd(), 0);
    let meetings: Vec<(f64, bool)> = people.meetings().collect();
    let between = meetings.iter().filter(|(_, left)| !left).count();
    assert_eq!(
        (meetings.len(), between, people.persons.len()),
        (29, 11, 38)
    );
    assert!(
        meetings
            .iter()
            .all(|(met_s, _)| (800.0..1600.0).contains(met_s))
    );
    for second in 0..8000 {
        assert!(bodies(&people, 0.1 * f64::from(second)).is_empty());
    }
    assert_eq!(people.openings.len(), 4);
    for &(door, from_s, until_s) in &people.openings {
        assert!(from_s >= 800.0 && (4.0..=10.0).contains(&(until_s - from_s)));
        let (robot, _) = people.path.at_time(from_s);
        let place = Point2::new(robot.x_m, robot.y_m);
        assert!(people.fire_doors[door].distance_m(&place) <= 3.0);
        let shut = |stamp_s| {
            let mut walls = Vec::new();
            people.passing_at(stamp_s, &mut walls);
            walls.contains(&people.fire_doors[door])
        };
        assert!(!shut(from_s) && !shut(until_s - 0.01));
        assert!(shut(790.0) && people.is_open(door, from_s));
    }
}

#[test]
fn whoever_is_met_is_beside_the_robot_and_nobody_is_ever_within_it_or_in_a_wall() {
    for run in 0..5 {
        let people = come(&crowd(), run);
        for (met_s, left) in people.meetings() {
            let (robot, _) = people.path.at_time(met_s);
            let aside = bodies(&people, met_s).into_iter().any(|wall| {
                let from_robot = robot.displacement_to(&Pose::new(wall.from.x, wall.from.y, 0.0));
                from_robot.forward_m.abs() < 0.25 && (from_robot.left_m > 0.0) == left
            });
            assert!(aside, "someone is met at {met_s} s");
        }
        for tenth in 8000..16_000 {
            let stamp_s = 0.1 * f64::from(tenth);
            let (robot, _) = people.path.at_time(stamp_s);
            let place = Point2::new(robot.x_m, robot.y_m);
            for wall in bodies(&people, stamp_s) {
                assert!(wall.distance_m(&place) > RADIUS_M, "at {stamp_s} s");
                assert!((-0.5..1.5).contains(&wall.from.y), "at {stamp_s} s");
                assert_eq!((wall.low_m, wall.high_m), (0.0, 1.75));
            }
        }
    }
}

#[test]
fn a_sonar_hears_whoever_walks_by() {
    let config = PeopleConfig {
        passing: 1,
        ..PeopleConfig::default()
    };
    let people = come(&config, 0);
    let (met_s, left) = people.meetings().next().unwrap();
    assert!(left, "on the side that is free");
    let (caster, _) = corridor();
    let sonar = Sonar::new(SonarConfig {
        ring_radius_m: RADIUS_M,
        ..SonarConfig::default()
    })
    .unwrap();
    let (robot, _) = people.path.at_time(met_s);
    let walls = bodies(&people, met_s);
    let heard = |walls: &[Wall]| sonar.echo_m(&Surroundings::new(&caster, walls), &robot, 6);
    // The corridor's other wall stands 1.5 m away; the person's skin between.
    let person = people.persons[0];
    let expected_m = person.aside_m - person.body_m - RADIUS_M;
    assert!((heard(&[]).unwrap() - (1.5 - RADIUS_M)).abs() < 1e-9);
    let heard_m = heard(&walls).unwrap();
    assert!(
        (heard_m - expected_m).abs() < 0.01,
        "{heard_m} for {expected_m}"
    );
}

#[test]
fn a_run_has_its_own_people_and_a_rate_the_stated_mean() {
    assert_ne!(come(&crowd(), 0).persons, come(&crowd(), 1).persons);
    assert_eq!(come(&crowd(), 3).persons, come(&crowd(), 3).persons);
    let rate = PeopleConfig {
        per_minute: 0.6,
        ..PeopleConfig::default()
    };
    // 799 s after mapping: 7.99 a run, Poisson: 400 runs have a standard error of 0.141.
    let counts: Vec<f64> = (0..400)
        .map(|run| come(&rate, run).meetings().count() as f64)
        .collect();
    let mean = counts.iter().sum::<f64>() / 400.0;
    let variance = counts
        .iter()
        .map(|count| (count - mean).powi(2))
        .sum::<f64>()
        / 399.0;
    assert!(
        (mean - 7.99).abs() < 0.57 && (variance - 7.99).abs() < 2.3,
        "{mean}, {variance}"
    );
}

#[test]
fn what_cannot_be_had_is_told() {
    let refusal = |config: &PeopleConfig| with(config, 0, |people| people.unwrap_err());
    type Case = (&'static str, fn(&mut PeopleConfig));
    let cases: [Case; 12] = [
        ("`between`", |c| c.between = 30),
        ("`map_laps`", |c| c.map_laps = f64::NAN),
        ("`per_minute`", |c| c.per_minute = -1.0),
        ("`passing`", |c| c.passing = usize::MAX),
        ("`standing`", |c| c.standing = 1_000_000),
        ("`fire_doors_opened`", |c| c.fire_doors_opened = 1_000_000),
        ("`opened_s`", |c| c.opened_s = [10.0, 4.0]),
        ("`speed_m_per_s`", |c| c.speed_m_per_s = [0.0, 1.0]),
        ("`radius_m`", |c| c.radius_m = 0.0),
        ("`slim_m`", |c| c.slim_m = 0.3),
        ("`slim_m`", |c| c.slim_m = f64::NAN),
        ("`height_m`", |c| c.height_m = -1.0),
    ];
    for (key, change) in cases {
        let mut config = crowd();
        change(&mut config);
        let error = refusal(&config);
        assert!(
            error.is_usage() && error.to_string().contains(key),
            "{error}"
        );
    }
    // 0.27 m between robot and wall are too few for those who need 0.3 m.
    let stout = PeopleConfig {
        slim_m: 0.15,
        ..crowd()
    };
    let line = refusal(&stout).to_string();
    assert!(
        line.contains("`between` asks for 11") && line.contains("0.57 m"),
        "{line}"
    );

    let ((caster, doors), path) = (corridor(), path());
    let outing = Outing {
        path: &path,
        map_until_s: 800.0,
        around: Surroundings::new(&caster, &doors),
        radius_m: RADIUS_M,
        wall_on_left: None,
    };
    let line = |config: &PeopleConfig, outing: &Outing| {
        let error = People::new(config, Seed(1), 0, outing).unwrap_err();
        error.to_string()
    };
    assert!(line(&crowd(), &outing).contains("follows no wall"));
    let doors_only = PeopleConfig {
        fire_doors_opened: 1,
        ..PeopleConfig::default()
    };
    let without_doors = Outing {
        around: Surroundings::from(&caster),
        ..outing
    };
    assert!(line(&doors_only, &without_doors).contains("`fire_doors_opened` is 1"));
    let nowhere = Outing {
        path: &[],
        ..outing
    };
    assert!(line(&doors_only, &nowhere).contains("path"));
    let always_mapping = Outing {
        map_until_s: 1e9,
        ..outing
    };
    let passers = PeopleConfig {
        passing: 1,
        ..PeopleConfig::default()
    };
    assert!(line(&passers, &always_mapping).contains("after mapping"));
}
