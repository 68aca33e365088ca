//! The beam model against the formula at every pose, in a room, and among people.

use super::*;
use crate::{
    belief::GridConfig,
    localiser::sensor_model::LikelihoodFieldModel,
    mapping::{LikelihoodField, LikelihoodFieldConfig, OccupancyMapConfig},
    recogniser::test_world::{seeing, test_world},
    recording::Recording,
    seed::Seed,
};
use std::sync::Arc;

/// The room's sonars are noisy rays without cones.
fn config() -> BeamModelConfig {
    let default = BeamModelConfig::default();
    BeamModelConfig {
        sensors: default.sensors.as_rays(),
        ..default
    }
}

fn map_of(recording: &Recording) -> OccupancyMap {
    let all: Vec<usize> = (0..recording.len()).collect();
    OccupancyMap::from_scans(recording, &all, &OccupancyMapConfig::default()).unwrap()
}

fn grid_of(recording: &Recording) -> Arc<Grid> {
    let config = GridConfig {
        headings: 12,
        ..GridConfig::default()
    };
    Arc::new(Grid::over(&Places::of(recording), &config).unwrap())
}

fn said(
    model: &dyn SensorModel,
    recording: &Recording,
    k: usize,
    places: &Arc<Places>,
) -> Vec<f64> {
    let belief = Belief::uniform(places).unwrap();
    let mut stream = Seed(1).stream("not drawn from");
    let said = model.log_likelihood(&recording.observation(k), &belief, &mut stream);
    said.unwrap()
}

/// How many of some snapshots each alone make a place within 0.6 m of the truth the likeliest.
fn found(model: &dyn SensorModel, recording: &Recording, places: &Arc<Places>) -> usize {
    let Places::Plane(cells) = &**places else {
        unreachable!("a grid in the plane")
    };
    let is_found = |&k: &usize| {
        let l = said(model, recording, k, places);
        let best = (0..l.len()).max_by(|&a, &b| l[a].total_cmp(&l[b])).unwrap();
        cells[best].distance_m(&recording.poses()[k]) < 0.6
    };
    (0..recording.len()).step_by(5).filter(is_found).count()
}

#[test]
fn every_cell_is_as_likely_as_the_formula_says() {
    let recording = test_world();
    let (map, grid) = (map_of(&recording), grid_of(&recording));
    let model = BeamModel::over_grid(&map, recording.channels(), &config(), &grid).unwrap();
    let render = RenderConfig {
        reach_m: 15.0,
        sensors: config().sensors,
        ..RenderConfig::default()
    };
    let renderer = Renderer::new(&map, recording.channels(), &render).unwrap();
    let mixture = Mixture::new(&config(), 5.0); // the sonars' maximum
    let Places::Plane(cells) = &**grid.places() else {
        unreachable!("a grid in the plane")
    };
    let l = said(&model, &recording, 17, grid.places());
    let values = recording.observation(17).values.to_vec();
    assert!(values.iter().any(|v| v.is_nan()) && values.iter().any(|v| v.is_finite()));
    let mut differ = 0;
    for (cell, pose) in cells.iter().enumerate() {
        let of_beam = |(expected, &reading): (Rendered, &f32)| {
            // Kept to half a cell of the map: 2.5 cm.
            let expected = match expected {
                Rendered::Hit(m) => Rendered::Hit(((m / 0.025).floor() + 0.5) * 0.025),
                other => other,
            };
            let measured = match reading.is_nan() {
                true => Measured::Max,
                false => Measured::Range(f64::from(reading)),
            };
            mixture.probability(measured, expected).ln()
        };
        let by_formula: f64 = renderer
            .at(pose)
            .into_iter()
            .zip(&values)
            .map(of_beam)
            .sum();
        // Where rounding takes a ray or a range to the other side of a border, it differs.
        differ += usize::from((by_formula - l[cell]).abs() > 1e-3);
    }
    assert!(differ * 50 < cells.len(), "{differ} of {}", cells.len());
}

#[test]
fn a_robot_in_a_room_is_found_and_people_hurt_it_less_than_a_likelihood_field() {
    let recording = test_world();
    let (map, grid) = (map_of(&recording), grid_of(&recording));
    let model = BeamModel::over_grid(&map, recording.channels(), &config(), &grid).unwrap();
    let field = LikelihoodField::new(&map, &LikelihoodFieldConfig::default()).unwrap();
    let field = LikelihoodFieldModel::over_grid(&Arc::new(field), &grid).unwrap();
    let all = recording.len().div_ceil(5);
    let alone = found(&model, &recording, grid.places());
    // Five sonars in a row see somebody at half of the way.
    let people = seeing(&recording, |k, beam| {
        let reading = recording.values()[[k, beam]];
        match (beam + k) % 16 < 5 {
            true => 0.5 * if reading.is_nan() { 5.0 } else { reading },
            false => reading,
        }
    });
    let with_people = found(&model, &people, grid.places());
    let by_field = found(&field, &people, grid.places());
    let field_alone = found(&field, &recording, grid.places());
    assert!(
        with_people > by_field && alone - with_people < field_alone - by_field,
        "{alone} → {with_people}, field {field_alone} → {by_field} of {all}"
    );
}

#[test]
fn what_does_not_fit_is_refused_by_name() {
    let recording = test_world();
    let (map, grid) = (map_of(&recording), grid_of(&recording));
    let made = |config: BeamModelConfig| {
        let model = BeamModel::over_grid(&map, recording.channels(), &config, &grid);
        model.err().unwrap()
    };
    let error = made(BeamModelConfig {
        most_bytes: 1000,
        ..config()
    });
    assert!(
        error.is_usage() && error.to_string().contains("expected at most 1000"),
        "{error}"
    );
    let error = made(BeamModelConfig {
        random: 0.0,
        ..config()
    });
    assert!(
        error.to_string().contains("beam_model.random = 0"),
        "{error}"
    );
    assert!(BeamModel::at_poses(&map, recording.channels(), &config(), vec![vec![]]).is_err());
    let here = vec![vec![recording.poses()[17]], vec![]];
    let model = BeamModel::at_poses(&map, recording.channels(), &config(), here).unwrap();
    let places = Arc::new(Places::Route(vec![0.0, 1.0]));
    let l = said(&model, &recording, 17, &places);
    assert!((l[0] - l[1]).abs() < 1e-9, "{l:?}");
    // A sensor that saw nothing at all says nothing.
    let dark = seeing(&recording, |_, _| f32::NAN);
    assert_eq!(said(&model, &dark, 17, &places), [0.0, 0.0]);
    let mut channels = recording.channels().to_vec();
    channels[0].name = "laser".into();
    let other = Observation {
        channels: &channels,
        ..recording.observation(0)
    };
    let belief = Belief::uniform(&places).unwrap();
    let mut stream = Seed(1).stream("not drawn from");
    let error = model
        .log_likelihood(&other, &belief, &mut stream)
        .unwrap_err();
    assert!(
        error.to_string().contains("channel 1 to be `sonar`"),
        "{error}"
    );
    let small = Belief::uniform(&Arc::new(Places::Route(vec![0.0]))).unwrap();
    let error = model.log_likelihood(&recording.observation(0), &small, &mut stream);
    assert!(
        error
            .unwrap_err()
            .to_string()
            .contains("a belief over 1 places")
    );
}
