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
    assert_eq!(shared.direction_rad.len(), 144); // 2.5° apart
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
