//! Models whose map is rendered.

use super::*;

/// A model whose map is rendered in a room of 2 × 1 m.
fn rendered_model() -> Model {
    let mut model = model(false);
    let cell = |k: usize| match (k % 8, k / 8) {
        (0 | 7, _) | (_, 0 | 3) => Occupancy::Occupied,
        (5, 2) => Occupancy::Unknown,
        _ => Occupancy::Free,
    };
    let map = OccupancyMap::from_cells(0.25, [-1.0, 0.5], 8, (0..32).map(cell).collect());
    model.header.occupancy = Some(OccupancyHeader {
        cell_m: 0.25,
        origin_m: [-1.0, 0.5],
        sensors: RangeSensors::default(),
    });
    model.occupancy = Some(map.unwrap());
    model
}

#[test]
fn a_rendered_map_comes_back_and_what_is_none_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let model = rendered_model();
    for container in CONTAINERS {
        let path = folder.path().join("room").with_extension(container);
        model.write(&path).unwrap();
        assert_eq!(Model::read(&path).unwrap(), model, "{container}");
    }
    let bank = ModelBank::new(vec![model.clone()], vec![0; model.pose.len()]).unwrap();
    let graph = folder.path().join("room.onnx");
    onnx::write(&bank, &graph).unwrap();
    assert_eq!(Model::read(&graph).unwrap(), model);
    let (meta, whole) = (model.meta().unwrap(), all_of(&model));
    let place = "array `map.occupancy`";
    refused(
        &meta,
        &without(&whole, "map.occupancy"),
        &[place, "missing"],
    );
    let with = |cells: ArrayD<u8>| {
        let mut arrays = without(&whole, "map.occupancy");
        arrays.put_u8("map.occupancy", cells);
        arrays
    };
    let cells = |shape: &[usize], number| ArrayD::from_elem(IxDyn(shape), number);
    refused(
        &meta,
        &with(cells(&[4, 8], 7)),
        &[place, "holds 7", "expected 0 (free)"],
    );
    refused(
        &meta,
        &with(cells(&[4, 8], 0)),
        &[place, "no cell is occupied"],
    );
    refused(&meta, &with(cells(&[32], 100)), &[place, "axes"]);
    refused(&meta, &with(cells(&[0, 8], 100)), &[place]);
    let mut floats = without(&whole, "map.occupancy");
    floats.put_f32("map.occupancy", ArrayD::zeros(IxDyn(&[4, 8])));
    refused(&meta, &floats, &[place, "f32; expected u8"]);
    let mut header: Value = serde_json::from_str(&meta).unwrap();
    header["occupancy"]["cell_m"] = json!(-0.25);
    refused(&header.to_string(), &whole, &[place, "-0.25"]);
}

#[test]
fn where_the_robot_has_been_the_map_is_half_of_what_it_saw() {
    let mut model = rendered_model();
    // Far apart, so that no pose has two visits.
    model.pose = (0..40).map(|k| Pose::new(f64::from(k), 9.0, 0.0)).collect();
    model.pose[3] = Pose::new(-0.3, 1.0, 0.2);
    let (there, turned) = (model.pose[3], Pose::new(-0.3, 1.0, 0.6));
    let mut answers = |seen: f32| {
        model.activation.row_mut(3).fill(seen);
        let at = model.at_every_pose(&[there, turned]).unwrap();
        at.unwrap().values
    };
    let (none, all) = (answers(0.0), answers(1.0));
    // All but what no map knows.
    let half = 0.5 * (1.0 - 0.05);
    for i in 0..2 {
        assert!((all[(0, i)] - none[(0, i)] - half).abs() < 1e-6);
        assert_eq!(all[(1, i)], none[(1, i)]);
    }
}

#[test]
fn what_a_bit_is_worth_is_not_learned_from_the_snapshots_own_visits() {
    let mut model = rendered_model();
    let rendered = model.as_rendered(&model.pose).unwrap().unwrap().values;
    // Whoever was there saw the contrary of what is rendered, so a rendered bit is worth less than none.
    model.activation = rendered.mapv(|m| if m > 0.5 { 0.0 } else { 1.0 });
    let grid = Grid::over(&model.places(), &GridConfig::default()).unwrap();
    let bits = model.code_map(&grid, true).unwrap().unwrap();
    let worth = bits.as_kept(ndarray::array![[0.0, 0.0], [1.0, 1.0]].view());
    let examples = |i: usize, on: bool| {
        rendered
            .column(i)
            .iter()
            .filter(|&&m| (m > 0.5) == on)
            .count()
    };
    for i in 0..2 {
        for (row, on) in [(0, false), (1, true)] {
            let contrary = if on {
                1.0 - worth[(row, i)]
            } else {
                worth[(row, i)]
            };
            let seen = examples(i, on) as f32;
            assert!(
                (contrary - (seen + 1.0) / (seen + 2.0)).abs() < 1e-6,
                "{worth}"
            );
        }
    }
}
