//! Whole worlds from the file to the Recording.

use super::*;
use nalgebra::Point2;

fn world(text: &str) -> Building {
    Building::from_text(text).unwrap()
}

fn recorded(text: &str) -> Recording {
    simulate(&world(text), Seed(1), &Choice::default()).unwrap()
}

/// A hall of 12 × 6 m with a bay in its upper wall, and the rest of a test.
fn hall(rest: &str) -> String {
    format!(
        "name = \"hall\"\n[[wall]]\nclosed = true\n\
         points = [[0, 0], [12, 0], [12, 6], [7, 6], [7, 9], [5, 9], [5, 6], [0, 6]]\n{rest}"
    )
}

/// A robot that drives exactly.
const EXACT: &str = "[robot]\nlateral_sd_m = 0.0\nheading_sd_rad = 0.0\nstart_scatter_m = 0.0\n";
const ROUND: &str = "[path]\nclosed = true\nbend_radius_m = 1.0\ncorners = [[2, 1.5], [10, 1.5], [10, 4.5], [2, 4.5]]\n";

/// 2 (6 + 1) + 2 π
const ROUND_M: f64 = 14.0 + std::f64::consts::TAU;

/// Whoever watches sees every snapshot once, and the same recording comes of it.
#[test]
fn progress_ends_with_the_last_snapshot() {
    let text = hall(&format!(
        "{EXACT}[sonar]\nbeams = 4\n{ROUND}[record]\nsnapshots = 30\n"
    ));
    let seen = std::sync::Mutex::new(Vec::new());
    let watched = simulate_watched(&world(&text), Seed(1), &Choice::default(), &|done, of| {
        seen.lock().unwrap().push((done, of));
    })
    .unwrap();
    let mut seen = seen.into_inner().unwrap();
    seen.sort_unstable();
    let all = watched.len();
    assert_eq!((seen.len(), seen.last()), (all, Some(&(all, all))));
    let same = recorded(&text); // NaN among its values
    let (a, b) = (watched.values().iter(), same.values().iter());
    assert!(a.map(|v| v.to_bits()).eq(b.map(|v| v.to_bits())));
}

#[test]
fn a_closed_route_is_driven_several_times_and_has_one_coordinate_a_place() {
    let text = hall(&format!(
        "{EXACT}[sonar]\nbeams = 4\n{ROUND}laps = 2.5\n[record]\nsnapshots = 100\n"
    ));
    let recording = recorded(&text);
    assert_eq!(recording.len(), 100);
    let travelled_m = *recording.travelled_m().last().unwrap();
    // 99 of 100 spacings; chords of 0.5 m are up to 1 % shorter than their arcs.
    let expected_m = 2.5 * ROUND_M * 0.99;
    assert!(
        (travelled_m / expected_m - 1.0).abs() < 0.01,
        "{travelled_m}"
    );
    let route_m = recording.route_m().unwrap();
    assert!(route_m.iter().all(|at_m| (0.0..=ROUND_M).contains(at_m)));
    for (pose, &at_m) in recording.poses().iter().zip(route_m) {
        if at_m < 6.0 {
            assert!((pose.x_m - 3.0 - at_m).abs() < 1e-6 && (pose.y_m - 1.5).abs() < 1e-6);
            assert!(pose.heading_rad.abs() < 1e-6);
        }
    }
}

#[test]
fn odd_runs_go_back_and_keep_the_coordinate() {
    for (path, whole_m) in [
        (
            "[path]\ncorners = [[2, 3], [10, 3]]\nboth_ways = true\n".to_string(),
            8.0,
        ),
        (format!("{ROUND}both_ways = true\n"), 6.0),
    ] {
        let text = hall(&format!(
            "{EXACT}[sonar]\nbeams = 4\n{path}[record]\nevery_m = 0.5\nruns = 2\n"
        ));
        let recording = recorded(&text);
        let route_m = recording.route_m().unwrap();
        let [outward, back] = &recording.runs()[..] else {
            panic!("two runs")
        };
        let first_x = 10.0 - whole_m - if whole_m == 8.0 { 0.0 } else { 1.0 };
        for (run, ahead) in [(outward, 1.0), (back, -1.0)] {
            let straight: Vec<usize> = run
                .clone()
                .filter(|&k| route_m[k] < whole_m - 1e-6)
                .collect();
            assert!(straight.len() > 10);
            for k in straight {
                let pose = recording.poses()[k];
                assert!(
                    (pose.x_m - first_x - route_m[k]).abs() < 1e-6,
                    "{pose:?} at {}",
                    route_m[k]
                );
                assert!((pose.heading_rad.cos() - ahead).abs() < 1e-6);
            }
        }
    }
}

#[test]
fn a_wall_is_followed_at_its_distance_round_corners_and_through_bays() {
    for (corners, side) in [
        ("[[2, 5.2], [0.5, 5.2]]", "right"),
        ("[[2, 0.8], [0.5, 0.8]]", "left"),
    ] {
        let path = format!(
            "[path]\nfollow = \"wall\"\ncorners = {corners}\nside = \"{side}\"\nlaps = 2.3\n"
        );
        let text = hall(&format!(
            "{EXACT}[sonar]\nbeams = 4\n{path}[record]\nevery_m = 0.1\n"
        ));
        let building = world(&text);
        let recording = recorded(&text);
        let plan = building.plan_of_run(Seed(1), 0).unwrap().plan;
        // The radius of 0.27 and the distance of 0.5 m; in corners nearer, as it turns when the next wall is as near.
        let clear_m: Vec<f64> = recording
            .poses()
            .iter()
            .map(|pose| plan.clearance_m(&Point2::new(pose.x_m, pose.y_m)))
            .collect();
        let within = clear_m
            .iter()
            .filter(|metres| (**metres - 0.77).abs() < 0.1)
            .count();
        assert!(
            within * 10 > clear_m.len() * 7,
            "{within} of {}",
            clear_m.len()
        );
        let least_m = clear_m.iter().copied().fold(f64::INFINITY, f64::min);
        assert!(least_m > 0.4, "{least_m}");
        assert!(
            recording.poses().iter().any(|pose| pose.y_m > 8.0),
            "into the bay"
        );
        // 2.3 times round: one and the same coordinate for one and the same place.
        let route_m = recording.route_m().unwrap();
        let round_m = route_m.iter().fold(0.0, |most: f64, at_m| most.max(*at_m));
        let travelled_m = *recording.travelled_m().last().unwrap();
        assert!(
            (travelled_m / round_m - 2.3).abs() < 0.1,
            "{travelled_m} of {round_m}"
        );
        for a in (0..recording.len()).step_by(7) {
            for b in (0..a).step_by(5) {
                let apart_m = (route_m[a] - route_m[b]).abs();
                if apart_m < 0.05 {
                    let metres = recording.poses()[a].distance_m(&recording.poses()[b]);
                    assert!(metres < 0.4, "{metres} m apart at {} m", route_m[a]);
                }
            }
        }
    }
}

#[test]
fn a_wall_that_never_leads_back_is_told() {
    let pillar = "[[thing]]\nat = [6, 3]\nradius_m = 0.3\n";
    let path = "[path]\nfollow = \"wall\"\ncorners = [[0.9, 3], [0.9, 4]]\ndistance_m = 2.4\n";
    let text = hall(&format!("{pillar}[sonar]\n{path}[record]\nevery_m = 0.1\n"));
    let message = simulate(&world(&text), Seed(1), &Choice::default())
        .unwrap_err()
        .to_string();
    assert!(
        message.contains("robot: ") && !message.contains('\n'),
        "{message}"
    );
}

#[test]
fn poses_are_visited_in_their_order_and_back() {
    let path = "[path]\nfollow = \"poses\"\nposes = [[2, 2, 0], [3, 2, 90], [3, 4, 180]]\nlaps = 2\nboth_ways = true\n";
    let recording = recorded(&hall(&format!(
        "{EXACT}[sonar]\nbeams = 4\n{path}[record]\nruns = 2\n"
    )));
    let places: Vec<(f64, f64)> = recording
        .poses()
        .iter()
        .map(|pose| (pose.x_m, pose.y_m))
        .collect();
    let outward = [(2.0, 2.0), (3.0, 2.0), (3.0, 4.0)];
    let back = [(3.0, 4.0), (3.0, 2.0), (2.0, 2.0)];
    assert_eq!(places, [outward, outward, back, back].concat());
    assert_eq!(recording.route_m().unwrap()[..3], [0.0, 1.0, 3.0]);
    assert_eq!(recording.route_m().unwrap()[6..9], [3.0, 1.0, 0.0]);
    assert!((recording.poses()[1].heading_rad - std::f64::consts::FRAC_PI_2).abs() < 1e-12);
}

#[test]
fn channels_stand_side_by_side_and_one_more_changes_none_of_the_others() {
    let rest = "[path]\ncorners = [[2, 3], [10, 3]]\n[record]\nevery_m = 2\n";
    let all = recorded(&hall(&format!(
        "[camera]\n[laser]\nbeams = 19\n[compass]\n[infrared]\nbeams = 6\n[sonar]\nbeams = 4\n{rest}"
    )));
    let widths: Vec<(&str, usize)> = all
        .channels()
        .iter()
        .map(|c| (c.name.as_str(), c.width))
        .collect();
    assert_eq!(
        widths,
        [
            ("sonar", 4),
            ("infrared", 6),
            ("laser", 19),
            ("camera", 140)
        ]
    );
    assert!(all.columns().compass_rad.is_some());
    let alone = recorded(&hall(&format!("[sonar]\nbeams = 4\n{rest}")));
    assert!(alone.columns().compass_rad.is_none());
    let bits = |recording: &Recording| -> Vec<u32> {
        recording
            .values()
            .rows()
            .into_iter()
            .flat_map(|row| row.iter().take(4).map(|v| v.to_bits()).collect::<Vec<_>>())
            .collect()
    };
    assert_eq!(bits(&all), bits(&alone));
}

#[test]
fn a_turret_held_north_looks_north_wherever_the_robot_goes() {
    let robot = "[robot]\nkind = \"nomad200\"\n[compass]\ndistortion_sd_rad = 0.0\nnoise_rad = 0.0\ntilt_sd_rad = 0.0\ndrift_sd_rad = 0.0\n";
    let recording = recorded(&hall(&format!("{robot}{ROUND}[record]\nevery_s = 1\n")));
    let north = std::f64::consts::FRAC_PI_2;
    let columns = recording.columns();
    for k in 0..recording.len() {
        let compass_rad = columns.compass_rad.as_ref().unwrap()[k];
        for heading in [
            columns.pose[k].heading_rad,
            columns.odometry[k].heading_rad,
            compass_rad,
        ] {
            assert!((heading - north).abs() < 1e-9);
        }
    }
    // What stands north of the robot is what the first sonar sees: the wall at y = 6, from the rim of 0.22 m.
    let seen = (0..recording.len()).filter(|&k| {
        let pose = columns.pose[k];
        let expected_m = 6.0 - pose.y_m - 0.22;
        pose.x_m > 8.0 && f64::from(recording.values()[(k, 0)] - expected_m as f32).abs() < 0.3
    });
    let expected = (0..recording.len())
        .filter(|&k| columns.pose[k].x_m > 8.0)
        .count();
    assert!(seen.count() * 10 > expected * 8);
    let end = columns.odometry.last().unwrap();
    let start = columns.pose[0];
    let truth = columns.pose.last().unwrap();
    // 2 to 5 % of the way, with noise on top.
    let off_m = (end.x_m - (truth.x_m - start.x_m)).hypot(end.y_m - (truth.y_m - start.y_m));
    assert!(off_m > 0.01 * ROUND_M && off_m < 0.08 * ROUND_M, "{off_m}");
}

#[test]
fn people_come_when_mapping_is_done_and_fire_doors_are_there_until_opened() {
    let quiet = "[laser]\nnoise_m = 0.0\nnoise_per_m = 0.0\nshort_probability = 0.0\nlost_probability = 0.0\nresolution_m = 0.0\n";
    let path = format!("{EXACT}{quiet}{ROUND}laps = 3\n[record]\nevery_m = 0.1\n");
    let empty = recorded(&hall(&path));
    let crowd = "[people]\nmap_laps = 1\npassing = 6\nstanding = 3\n";
    let crowded = recorded(&hall(&format!("{path}{crowd}")));
    assert_eq!(empty.len(), crowded.len());
    let differ = |k: usize| {
        let rows = [&empty, &crowded].map(|recording| recording.values().row(k).to_owned());
        rows[0]
            .iter()
            .zip(&rows[1])
            .any(|(a, b)| (a - b).abs() > 0.1)
    };
    let laps = |k: usize| empty.travelled_m()[k] / (ROUND_M * 0.995);
    let split = (0..empty.len()).find(|&k| laps(k) > 0.98).unwrap();
    assert_eq!((0..split).filter(|&k| differ(k)).count(), 0);
    assert!((split..empty.len()).filter(|&k| differ(k)).count() > 20);

    let door = "[[fire_door]]\nfrom = [11, 1]\nto = [11, 5]\n";
    let doors = recorded(&hall(&format!("{door}{path}")));
    let opened = recorded(&hall(&format!(
        "{door}{path}[people]\nmap_laps = 1\nfire_doors_opened = 2\n"
    )));
    let open = |k: usize| {
        let rows = [&doors, &opened].map(|recording| recording.values().row(k).to_owned());
        rows[0]
            .iter()
            .zip(&rows[1])
            .any(|(a, b)| (a - b).abs() > 0.1)
    };
    assert!((0..doors.len()).any(|k| {
        doors
            .values()
            .row(k)
            .iter()
            .zip(empty.values().row(k))
            .any(|(a, b)| (a - b).abs() > 0.1)
    }));
    assert_eq!((0..split).filter(|&k| open(k)).count(), 0);
    let seconds = (split..doors.len()).filter(|&k| open(k)).count() as f64 * 0.1 / 0.15;
    assert!((4.0..20.0).contains(&seconds), "{seconds} s");
}
