//! Scans in a room: walls, maxima, cones, what nobody knows, and many poses at once.

use super::*;
use crate::{mapping::Occupancy, seed::Seed};
use rand::RngExt;
use std::f64::consts::TAU;

/// A room of 6 m by 4 m with a gap in its western wall, 5 cm cells, what is outside unknown.
fn room() -> OccupancyMap {
    let size = [160, 120];
    let mut cells = vec![Occupancy::Unknown; size[0] * size[1]];
    for (row, column) in (20..100).flat_map(|r| (20..140).map(move |c| (r, c))) {
        let wall = row == 20 || row == 99 || column == 20 || column == 139;
        let gap = column == 20 && (50..60).contains(&row);
        cells[row * size[0] + column] = match wall && !gap {
            true => Occupancy::Occupied,
            false => Occupancy::Free,
        };
    }
    OccupancyMap::from_cells(0.05, [-1.0, -1.0], size[0], cells).unwrap()
}

fn channel(name: &str, beams: usize, maximum: Option<f64>) -> Channel {
    Channel {
        name: name.into(),
        width: beams,
        unit: "m".into(),
        bearing_rad: Some((0..beams).map(|b| TAU * b as f64 / beams as f64).collect()),
        maximum,
        offset_m: None,
    }
}

#[test]
fn a_scan_in_a_room_has_its_walls_its_maximum_and_what_nobody_knows() {
    let renderer = |maximum| {
        let channels = [channel("laser", 4, maximum)];
        Renderer::new(&room(), &channels, &RenderConfig::default()).unwrap()
    };
    let hit = |r: Rendered, m: f32| matches!(r, Rendered::Hit(x) if (x - m).abs() < 0.03);
    // In the middle, facing east; the gap lies behind.
    let middle = Pose::new(3.0, 1.75, 0.0);
    let seen = renderer(None).at(&middle);
    assert!(
        hit(seen[0], 2.975) && hit(seen[1], 2.225) && hit(seen[3], 1.725),
        "{seen:?}"
    );
    assert!(matches!(seen[2], Rendered::Unknown(_)));
    let seen = renderer(Some(2.0)).at(&middle);
    assert_eq!(seen[..3], [Rendered::Free; 3]);
    assert!(hit(seen[3], 1.725) && seen[0].reading_m().is_nan());
    // What is unknown past the maximum is no matter, what is before it is.
    assert_eq!(renderer(Some(2.9)).at(&middle)[2], Rendered::Free);
    assert!(
        matches!(renderer(Some(3.5)).at(&middle)[2], Rendered::Unknown(m) if m > 2.5 && m < 3.5)
    );
    // In a wall, and outside.
    for nowhere in [Pose::new(0.02, 0.5, 0.0), Pose::new(-50.0, 0.5, 0.0)] {
        assert_eq!(renderer(None).at(&nowhere), [Rendered::Unknown(0.0); 4]);
    }
}

#[test]
fn a_cone_sees_the_nearest_of_what_lies_in_it() {
    let of = |name| {
        let channels = [channel(name, 1, None)];
        Renderer::new(&room(), &channels, &RenderConfig::default()).unwrap()
    };
    // 45° to the wall: the cone's edge, 15° nearer to head-on, meets it first.
    let pose = Pose::new(3.0, 1.0, -TAU / 8.0);
    let range_m = |name| match of(name).at(&pose)[0] {
        Rendered::Hit(range_m) => range_m,
        other => panic!("{name}: {other:?}"),
    };
    assert!((range_m("laser") - 0.975 * 2f32.sqrt()).abs() < 0.06);
    assert!((range_m("sonar") - 0.975 / 30_f32.to_radians().cos()).abs() < 0.06);
    // Beside the gap the ray is lost, the cone is not.
    let before_gap = Pose::new(1.0, 1.75, TAU / 2.0);
    assert!(matches!(
        of("laser").at(&before_gap)[0],
        Rendered::Unknown(_)
    ));
    assert!(matches!(of("sonar").at(&before_gap)[0], Rendered::Hit(m) if m > 0.9 && m < 1.1));
}

#[test]
fn many_poses_see_what_each_alone_sees_whether_they_share_directions_or_not() {
    let mut random = Seed(2).stream("poses");
    let channels = [channel("laser", 12, None), channel("sonar", 8, Some(3.0))];
    let renderer = Renderer::new(&room(), &channels, &RenderConfig::default()).unwrap();
    let mut at = || {
        let (x_m, y_m) = (random.random_range(0.0..6.0), random.random_range(0.0..4.0));
        (x_m, y_m, random.random_range(0.0..TAU))
    };
    let alone: Vec<Pose> = (0..50)
        .map(|_| at())
        .map(|(x, y, h)| Pose::new(x, y, h))
        .collect();
    assert!(SharedDirections::of(&alone, renderer.beams()).is_none());
    let turning: Vec<Pose> = (0..24)
        .flat_map(|h| {
            alone
                .iter()
                .map(move |p| (p.x_m, p.y_m, f64::from(h) * TAU / 24.0))
        })
        .map(|(x, y, h)| Pose::new(x, y, h))
        .collect();
    let shared = SharedDirections::of(&turning, renderer.beams()).unwrap();
    assert_eq!(shared.directions.len(), 144); // 2.5° apart
    for poses in [alone, turning] {
        let all = renderer.at_all(&poses);
        let mut differ = 0;
        for (row, pose) in all.rows().into_iter().zip(&poses) {
            let each = renderer.at(pose);
            differ += row.iter().zip(&each).filter(|(a, b)| a != b).count();
        }
        // The same direction by another sum may pass a corner on its other side.
        assert!(differ * 200 < all.len(), "{differ} of {}", all.len());
        let one_thread = rayon::ThreadPoolBuilder::new()
            .num_threads(1)
            .build()
            .unwrap();
        assert_eq!(one_thread.install(|| renderer.at_all(&poses)), all);
    }
}

#[test]
fn values_without_sense_are_refused_by_name() {
    for (config, expected) in [
        (
            RenderConfig {
                unknown_m: -1.0,
                ..RenderConfig::default()
            },
            "render.unknown_m = -1",
        ),
        (
            RenderConfig {
                reach_m: 0.0,
                ..RenderConfig::default()
            },
            "render.reach_m = 0",
        ),
    ] {
        let error = Renderer::new(&room(), &[channel("laser", 1, None)], &config).unwrap_err();
        assert!(
            error.is_usage() && error.to_string().contains(expected),
            "{error}"
        );
    }
    let camera = Channel {
        bearing_rad: None,
        ..channel("camera", 3, None)
    };
    let error = Renderer::new(&room(), &[camera], &RenderConfig::default()).unwrap_err();
    assert!(
        error
            .to_string()
            .contains("rendered scans: no channel in metres"),
        "{error}"
    );
}

/// The law of the ring: a wall is in the same cells of a map, in the same ends of a field, and at the same distance of a rendered
/// scan, whether ranges count from the robot's middle or from where the sensors sit.
#[test]
fn a_wall_seen_from_a_ring_is_where_it_is_seen_from_the_middle() {
    use crate::{
        mapping::{LikelihoodField, LikelihoodFieldConfig, OccupancyMapConfig},
        recording::{Columns, Recording},
    };
    let radius_m = 0.22;
    let bearing_rad: Vec<f64> = (0..24).map(|b| TAU * f64::from(b) / 24.0).collect();
    let channel = |offset_m: Option<f64>| Channel {
        name: "laser".into(),
        width: 24,
        unit: "m".into(),
        bearing_rad: Some(bearing_rad.clone()),
        maximum: Some(9.0 - offset_m.unwrap_or(0.0)),
        offset_m: offset_m.map(|m| vec![m; 24]),
    };
    // A room of 5 by 3 m, from places and headings all over it.
    let poses: Vec<Pose> = (0..60)
        .map(|k| {
            Pose::new(
                0.6 + 0.063 * f64::from(k),
                0.6 + 0.029 * f64::from(k),
                0.37 * f64::from(k),
            )
        })
        .collect();
    let range_m = |pose: &Pose, bearing_rad: f64| {
        let (sin, cos) = (pose.heading_rad + bearing_rad).sin_cos();
        let in_x = if cos > 0.0 {
            (5.013 - pose.x_m) / cos
        } else {
            (-0.013 - pose.x_m) / cos
        };
        let in_y = if sin > 0.0 {
            (3.013 - pose.y_m) / sin
        } else {
            (-0.013 - pose.y_m) / sin
        };
        in_x.min(in_y)
    };
    let recording = |offset_m: Option<f64>| {
        let values = Array2::from_shape_fn((poses.len(), 24), |(k, b)| {
            (range_m(&poses[k], bearing_rad[b]) - offset_m.unwrap_or(0.0)) as f32
        });
        Recording::new(Columns {
            channels: vec![channel(offset_m)],
            values,
            stamp_s: (0..poses.len()).map(|k| k as f64).collect(),
            odometry: poses.clone(),
            run: vec![0; poses.len()],
            pose: poses.clone(),
            ..Columns::default()
        })
        .unwrap()
    };
    let (middle, ring) = (recording(None), recording(Some(radius_m)));
    let all: Vec<usize> = (0..poses.len()).collect();
    let config = OccupancyMapConfig {
        least_hits: 1,
        ..OccupancyMapConfig::default()
    };
    let map = |recording: &Recording| OccupancyMap::from_scans(recording, &all, &config).unwrap();
    let (map, of_ring) = (map(&middle), map(&ring));
    let differing = map
        .cells()
        .iter()
        .zip(of_ring.cells())
        .filter(|(a, b)| a != b);
    let walls = map
        .cells()
        .iter()
        .filter(|c| **c == Occupancy::Occupied)
        .count();
    let differing = differing.count();
    assert!(differing * 50 < walls, "{differing} of {walls}"); // rounding of single precision

    let field = LikelihoodField::new(&map, &LikelihoodFieldConfig::default()).unwrap();
    for k in [3, 31] {
        let beams = |r: &Recording| field.beams(r.channels(), &r.observation(k)).unwrap();
        for (a, b) in beams(&middle).iter().zip(beams(&ring)) {
            assert!((a.ahead_m - b.ahead_m).hypot(a.left_m - b.left_m) < 1e-5);
        }
    }
    let seen = |r: &Recording| {
        let renderer = Renderer::new(&map, r.channels(), &RenderConfig::default()).unwrap();
        let together = renderer.at_all(&poses);
        for (k, pose) in poses.iter().enumerate() {
            assert_eq!(renderer.at(pose), together.row(k).to_vec());
        }
        together
    };
    let mut hits = 0;
    for (a, b) in seen(&middle).iter().zip(&seen(&ring)) {
        if let (Rendered::Hit(a), Rendered::Hit(b)) = (a, b) {
            assert!((a - b - radius_m as f32).abs() < 1e-3, "{a} {b}");
            hits += 1;
        }
    }
    assert!(hits > 1000, "{hits}");
}
