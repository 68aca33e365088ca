use super::*;
use crate::recording::{Channel, Columns};

/// Scans of one cone each, taken at some poses; all of them read as far as a wall along x = 3 m, which is what a sonar
/// measures: the distance to the nearest of it within its cone.
fn cones_before_a_wall(poses: &[Pose]) -> Recording {
    let sonar = Channel {
        name: "sonar".into(),
        width: 1,
        unit: "m".into(),
        bearing_rad: Some(vec![0.0]),
        maximum: None,
        offset_m: None,
    };
    let half_rad = 15f64.to_radians();
    let readings = poses.iter().map(|pose| {
        let from_normal = (pose.heading_rad.abs() - half_rad).max(0.0);
        ((3.0 - pose.x_m) / from_normal.cos()) as f32
    });
    let values = ndarray::Array2::from_shape_vec((poses.len(), 1), readings.collect()).unwrap();
    Recording::new(Columns {
        channels: vec![sonar],
        values,
        stamp_s: (0..poses.len()).map(|k| k as f64).collect(),
        pose: poses.to_vec(),
        odometry: vec![Pose::default(); poses.len()],
        run: vec![0; poses.len()],
        ..Columns::default()
    })
    .unwrap()
}

#[test]
fn a_cones_echo_comes_from_where_no_other_cone_has_gone() {
    // Driving along the wall, looking at it straight and askew.
    let poses: Vec<Pose> = (0..240)
        .map(|k| {
            let heading_rad = [0.0, 0.4, -0.4][k % 3];
            Pose::new(0.52, 0.049 * (k / 3) as f64, heading_rad)
        })
        .collect();
    let recording = cones_before_a_wall(&poses);
    let all: Vec<usize> = (0..poses.len()).collect();
    let map = |sensors: RangeSensors| {
        let config = OccupancyMapConfig {
            sensors,
            ..OccupancyMapConfig::default()
        };
        OccupancyMap::from_scans(&recording, &all, &config).unwrap()
    };
    let cones = RangeSensors::default();
    let (rays, cones) = (map(cones.as_rays()), map(cones));
    let occupied = |map: &OccupancyMap| -> Vec<[f64; 2]> {
        let [width, _] = map.size();
        let cells = map.cells().iter().enumerate();
        let occupied = cells.filter(|(_, cell)| **cell == Occupancy::Occupied);
        let middle = |index: usize, axis: usize| {
            map.origin_m()[axis]
                + ([index % width, index / width][axis] as f64 + 0.5) * map.cell_m()
        };
        occupied
            .map(|(i, _)| [middle(i, 0), middle(i, 1)])
            .collect()
    };
    let before = |map: &OccupancyMap| {
        // Where cones from both sides looked.
        let all = occupied(map)
            .into_iter()
            .filter(|at| (0.5..3.5).contains(&at[1]));
        let all: Vec<[f64; 2]> = all.collect();
        let off = all.iter().filter(|at| (at[0] - 3.0).abs() > 0.15);
        (off.count(), all.len())
    };
    // The axis of a slanting cone ends before the wall, as its edge is what meets it.
    let (off_by_rays, _) = before(&rays);
    let (off_by_cones, found) = before(&cones);
    assert!(found > 50, "{found} cells of a wall");
    assert!(
        off_by_rays > 30 && off_by_cones == 0,
        "{off_by_rays} {off_by_cones}"
    );
    // What the sides of cones went through is not known by that.
    assert_eq!(cones.at(2.0, -1.0), Occupancy::Unknown);
}

#[test]
fn a_map_is_drawn_by_the_sensors_named() {
    let recording = cones_before_a_wall(&[Pose::default(); 3]);
    let config = OccupancyMapConfig {
        sensors: RangeSensors {
            channels: vec!["laser".into()],
            ..RangeSensors::default()
        },
        ..OccupancyMapConfig::default()
    };
    let error = OccupancyMap::from_scans(&recording, &[0, 1, 2], &config).unwrap_err();
    let expected = "occupancy map: no channel `laser`; found sonar";
    assert_eq!(error.to_string(), expected);
}
