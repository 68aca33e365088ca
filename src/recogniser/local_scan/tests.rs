use super::*;
use crate::{geometry::Pose, recogniser::occupancy::State};
use ndarray::Array1;
use std::f64::consts::{FRAC_PI_2, TAU};

const BEAMS: usize = 180;

fn channels() -> Vec<Channel> {
    let camera = Channel {
        name: "camera".into(),
        width: 2,
        unit: "grey".into(),
        bearing_rad: None,
        maximum: None,
        offset_m: None,
    };
    let laser = Channel {
        name: "laser".into(),
        width: BEAMS,
        unit: "m".into(),
        bearing_rad: Some((0..BEAMS).map(|i| TAU * i as f64 / BEAMS as f64).collect()),
        maximum: Some(8.0),
        offset_m: None,
    };
    vec![camera, laser]
}

fn scans(compass: bool) -> LocalScans {
    LocalScans::new(&ScanConfig::default(), &channels(), compass).unwrap()
}

/// A room from −2 to 3 m by −1 to 2 m, from the origin.
fn room(heading_rad: f64) -> Array1<f32> {
    let ranges = (0..BEAMS).map(|i| {
        let (sin, cos) = (TAU * i as f64 / BEAMS as f64 + heading_rad).sin_cos();
        let in_x = if cos > 0.0 { 3.0 / cos } else { -2.0 / cos };
        let in_y = if sin > 0.0 { 2.0 / sin } else { -1.0 / sin };
        in_x.min(in_y) as f32
    });
    [7.0, 9.0].into_iter().chain(ranges).collect()
}

fn seen(values: &Array1<f32>, compass_rad: Option<f64>) -> Observation<'_> {
    Observation {
        channels: &[],
        stamp_s: 0.0,
        values: values.view(),
        odometry: Pose::default(),
        compass_rad,
    }
}

fn agreeing(a: &States, b: &States) -> usize {
    let cells = (0..64).flat_map(|x| (0..64).map(move |y| (x, y)));
    cells.filter(|&(x, y)| a.at(x, y) == b.at(x, y)).count()
}

#[test]
fn with_a_compass_the_heading_does_not_matter() {
    let channels = channels();
    let of = |heading_rad: f64| {
        let values = room(heading_rad);
        let observation = seen(&values, Some(heading_rad));
        scans(true).grid(&channels, &observation).unwrap()
    };
    let ahead = of(0.0);
    assert_eq!(ahead.at(32 + 10, 32), State::Empty);
    assert_eq!(ahead.at(32 + 19, 33), State::Occupied); // 2.925 m of 3
    assert_eq!(ahead.at(32 + 25, 32), State::Unknown);
    for heading_rad in [0.4, 1.7, -2.9] {
        let same = agreeing(&ahead, &of(heading_rad));
        assert!(same > 4000, "{heading_rad}: {same}");
    }
    let values = room(0.0);
    assert_eq!(scans(true).grid(&channels, &seen(&values, None)), None);
}

#[test]
fn without_one_it_matters_by_quarter_turns_only() {
    let channels = channels();
    let of = |heading_rad: f64| {
        let values = room(heading_rad);
        scans(false).grid(&channels, &seen(&values, None)).unwrap()
    };
    let ahead = of(0.0);
    for heading_rad in [0.4, 1.2, FRAC_PI_2 + 0.1, -2.9] {
        let turned = of(heading_rad);
        let same = scans(false)
            .turns(turned)
            .map(|t| agreeing(&ahead, &t))
            .max()
            .unwrap();
        assert!(same > 3950, "{heading_rad}: {same}");
    }
}

#[test]
fn nothing_heard_is_no_grid_and_missing_sensors_are_told() {
    let channels = channels();
    for silence in [f32::NAN, 8.0, f32::INFINITY, -1.0] {
        let values = Array1::from_elem(BEAMS + 2, silence);
        let observation = seen(&values, Some(0.0));
        assert_eq!(scans(true).grid(&channels, &observation), None, "{silence}");
    }
    let short = Array1::from_elem(1, 2.0);
    assert_eq!(scans(false).grid(&channels, &seen(&short, None)), None);
    assert_eq!(scans(false).check().map_err(|e| e.to_string()), Ok(()));
    assert!(scans(true).check_channels(&channels).is_ok());
    let error = scans(true).check_channels(&channels[..1]).unwrap_err();
    assert!(error.to_string().contains("`laser`"), "{error}");
    let error = LocalScans::new(&ScanConfig::default(), &channels[..1], true).unwrap_err();
    assert!(
        error.to_string().contains("no channel of ranges"),
        "{error}"
    );
    let flat = ScanConfig {
        light_opening_rad: 0.0,
        ..ScanConfig::default()
    };
    let error = flat.check().unwrap_err();
    assert!(error.is_usage() && error.to_string().contains("scan.light_opening_rad = 0"));
}

#[test]
fn a_cone_without_return_says_nothing_or_that_it_is_empty() {
    let channels = channels();
    let mut values = room(0.0);
    values[2] = f32::NAN; // ahead
    (3..7)
        .chain(BEAMS - 3..BEAMS + 2)
        .for_each(|i| values[i] = 8.0);
    let observation = seen(&values, Some(0.0));
    let of = |empty_without_return| {
        let config = ScanConfig {
            empty_without_return,
            ..ScanConfig::default()
        };
        let scans = LocalScans::new(&config, &channels, true).unwrap();
        scans.grid(&channels, &observation).unwrap()
    };
    assert_eq!(of(false).at(32 + 25, 32), State::Unknown);
    assert_eq!(of(true).at(32 + 25, 32), State::Empty);
    assert_eq!(of(true).at(63, 32), State::Empty); // nothing stands at the grid's edge
    assert_eq!(of(true).at(32, 32 + 13), of(false).at(32, 32 + 13)); // aside nothing is changed
}

/// The law of the ring: a wall is in the same cells, whether its distance counts from the robot's middle or from where the
/// sensors sit.
#[test]
fn a_room_seen_from_a_ring_is_the_room_seen_from_the_middle() {
    let from_middle = channels();
    for radius_m in [0.1, 0.22, 0.5] {
        let mut on_ring = from_middle.clone();
        on_ring[1].offset_m = Some(vec![radius_m; BEAMS]);
        on_ring[1].maximum = from_middle[1].maximum.map(|m| m - radius_m);
        for heading_rad in [0.0, 0.7] {
            let values = room(heading_rad);
            let mut less = values.clone();
            less.iter_mut()
                .skip(2)
                .for_each(|range| *range -= radius_m as f32);
            let grid = |channels: &[Channel], values| {
                let observation = seen(values, Some(heading_rad));
                scans(true).grid(channels, &observation).unwrap()
            };
            let (middle, ring) = (grid(&from_middle, &values), grid(&on_ring, &less));
            let walls = |states: &States| {
                let cells = (0..64).flat_map(|x| (0..64).map(move |y| (x, y)));
                cells
                    .filter(|&(x, y)| states.at(x, y) == State::Occupied)
                    .collect::<Vec<_>>()
            };
            let (middle, ring) = (walls(&middle), walls(&ring));
            let share = |cells: &[(usize, usize)]| {
                let same = cells.iter().filter(|cell| middle.contains(cell));
                same.count() as f64 / cells.len() as f64
            };
            // Thin beams from a ring leave a gap here and there; what they meet stands where it stands.
            assert!(share(&ring) > 0.9, "{radius_m}: {}", share(&ring));
            assert!(ring.len() * 3 > middle.len() * 2, "{}", ring.len());
            // Who takes the ring's ranges for the middle's puts the walls elsewhere.
            let elsewhere = walls(&grid(&from_middle, &less));
            assert!(
                radius_m < 0.2 || share(&elsewhere) < 0.8,
                "{}",
                share(&elsewhere)
            );
        }
    }
}
