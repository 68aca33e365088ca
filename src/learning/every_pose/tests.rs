use super::*;
use crate::learning::{mini_batch::MiniBatch, training_set::TrainingSet};
use crate::{
    recording::{Channel, Columns, split::Split},
    seed::Seed,
};
use std::f64::consts::TAU;

/// A robot that drives through the middle of a room of 8 × 4 m, there and back, and measures all round.
fn recording(route: bool) -> Recording {
    let beams = 36;
    let there = (0..60).map(|k| Pose::new(1.0 + 0.1 * f64::from(k), 2.0, 0.0));
    let back = (0..60).map(|k| Pose::new(6.9 - 0.1 * f64::from(k), 2.1, TAU / 2.0));
    let pose: Vec<Pose> = there.chain(back).collect();
    let range = |pose: &Pose, beam: usize| {
        let angle = pose.heading_rad + TAU * beam as f64 / beams as f64;
        let (sin, cos) = angle.sin_cos();
        let to_wall = |at: f64, way: f64, most: f64| match way {
            w if w > 1e-9 => (most - at) / w,
            w if w < -1e-9 => at / -w,
            _ => f64::INFINITY,
        };
        to_wall(pose.x_m, cos, 8.0).min(to_wall(pose.y_m, sin, 4.0)) as f32
    };
    let k = pose.len();
    Recording::new(Columns {
        channels: vec![Channel {
            name: "laser".into(),
            width: beams,
            unit: "m".into(),
            bearing_rad: Some((0..beams).map(|b| TAU * b as f64 / beams as f64).collect()),
            maximum: None,
            offset_m: None,
        }],
        values: Array2::from_shape_fn((k, beams), |(k, beam)| range(&pose[k], beam)),
        stamp_s: (0..k).map(|k| k as f64).collect(),
        odometry: pose.clone(),
        run: (0..k as i64).map(|k| k / 60).collect(),
        route_m: route.then(|| (0..k).map(|k| k as f64 * 0.1).collect()),
        pose,
        ..Columns::default()
    })
    .unwrap()
}

fn recipe(filled_from: FilledFrom) -> Recipe {
    let mut recipe = Recipe::default();
    recipe.map.filled_from = filled_from;
    (
        recipe.descent.truths_per_step,
        recipe.descent.rendered_per_step,
    ) = (10, 50);
    recipe
}

fn training_set<T>(
    recipe: &Recipe,
    recording: &Recording,
    ask: impl FnOnce(Result<TrainingSet>) -> T,
) -> T {
    let everything = Split {
        train: (0..recording.len()).collect(),
        ..Split::default()
    };
    ask(TrainingSet::prepare(recipe, recording, &everything))
}

#[test]
fn validation_snapshots_are_judged_with_people_too_where_scans_are_rendered() {
    let recording = recording(false);
    let (train, validation) = (0..recording.len()).partition(|k| k % 4 > 0);
    let split = Split {
        train,
        validation,
        ..Split::default()
    };
    let inputs = |people: Option<f64>, filled_from| {
        let mut recipe = recipe(filled_from);
        recipe.augmentation.people = people;
        let set = TrainingSet::prepare(&recipe, &recording, &split).unwrap();
        let validation_set = set.validation_set.as_ref().unwrap();
        let truths = Array2::from_elem((validation_set.inputs.nrows(), 2), 0.5);
        let map = Array2::from_elem((set.candidates().nrows(), 2), 0.5);
        let judged = set.validate(validation_set, truths.view(), map.view());
        assert_eq!(judged.unwrap().snapshots, 30);
        validation_set.inputs.clone()
    };
    let as_it_was = inputs(Some(0.0), FilledFrom::Auto);
    assert_eq!(as_it_was.nrows(), 30);
    let usual = inputs(None, FilledFrom::Auto);
    let half = |number: usize| usual.slice_axis(Axis(0), (30 * number..30 * (number + 1)).into());
    assert_eq!((usual.nrows(), half(0)), (60, as_it_was.view()));
    assert_ne!(half(1), as_it_was);
    assert_eq!(inputs(None, FilledFrom::Visits).nrows(), 30);
    assert_eq!(inputs(Some(0.4), FilledFrom::Visits).nrows(), 60);
}

#[test]
fn candidates_are_rendered_beside_the_truths_and_anywhere() {
    let recording = recording(false);
    training_set(&recipe(FilledFrom::Auto), &recording, |set| {
        let set = set.unwrap();
        let every_pose = set.every_pose.as_ref().unwrap();
        let truths = Places::Plane(vec![Pose::new(3.0, 2.0, 0.0); 8]);
        let (places, inputs) = every_pose.draw(&truths, 50, &mut Seed(1).stream("draw"));
        assert_eq!((places.len(), inputs.nrows()), (50, 50));
        let near = |k: &usize| truths.distance_m(0, &places, *k) < 0.5;
        let facing_east = |k: &usize| truths.turn_rad(0, &places, *k) < 0.4;
        let beside = (0..50).filter(near).filter(facing_east).count();
        // By chance two or three would be: of 24 headings four, of 30 m² a half.
        assert!((6..30).contains(&beside), "{beside}");
        let mut each: Vec<String> = (0..50).map(|k| format!("{:?}", places.pose(k))).collect();
        each.sort();
        each.dedup();
        assert_eq!(each.len(), 50);
        // The robot's own scan, and what is rendered where it stood, are alike.
        let off = (&every_pose.at_training - &set.inputs).mapv(f32::abs);
        let mut elsewhere = set.inputs.clone();
        elsewhere.invert_axis(Axis(0));
        let far = (&every_pose.at_training - &elsewhere).mapv(f32::abs);
        assert!(
            off.mean().unwrap() < 0.3 * far.mean().unwrap(),
            "{off:?} {far:?}"
        );
    });
}

#[test]
fn a_step_is_of_rendered_candidates_the_same_for_the_same_seed() {
    let recording = recording(false);
    let recipe = recipe(FilledFrom::Auto);
    training_set(&recipe, &recording, |set| {
        let set = set.unwrap();
        let one = MiniBatch::new(&recipe, &set, 3).unwrap();
        let again = MiniBatch::new(&recipe, &set, 3).unwrap();
        let other = MiniBatch::new(&recipe, &set, 4).unwrap();
        assert_eq!((one.truths, one.inputs.nrows()), (10, 60));
        assert!(one.inputs == again.inputs && one.inputs != other.inputs);
    });
}

#[test]
fn a_route_and_a_recipe_that_wants_visits_render_nothing() {
    for (filled_from, route) in [(FilledFrom::Visits, false), (FilledFrom::Auto, true)] {
        training_set(&recipe(filled_from), &recording(route), |set| {
            assert!(set.unwrap().every_pose.is_none());
        });
    }
    training_set(&recipe(FilledFrom::Rendered), &recording(true), |set| {
        let fault = set.err().map(|fault| fault.to_string()).unwrap_or_default();
        assert!(
            fault.contains("map.filled_from") && fault.contains("route"),
            "{fault}"
        );
    });
}

#[test]
fn sonars_are_rendered_as_what_resembles_their_echoes_most() {
    // Each echo from the nearest point in a cone of 30°.
    let mut columns = recording(false).into_columns();
    columns.channels[0].name = "sonar".into();
    let rays = columns.values.clone();
    for (mut row, seen) in columns.values.rows_mut().into_iter().zip(rays.rows()) {
        for beam in 0..36 {
            let beside = [35, 0, 1].map(|off| seen[(beam + off) % 36]);
            row[beam] = beside.into_iter().fold(f32::INFINITY, f32::min);
        }
    }
    let recording = Recording::new(columns).unwrap();
    training_set(&recipe(FilledFrom::Auto), &recording, |set| {
        let set = set.unwrap();
        let every_pose = set.every_pose.as_ref().unwrap();
        let rendered_as = |sensors: RangeSensors| {
            let sensed = SensedMap {
                sensors,
                ..every_pose.sensed.clone()
            };
            let rendered = RenderedInputs::new(&sensed, recording.channels(), &set.input);
            let at = rendered.unwrap().at(recording.poses()).unwrap();
            (at.values - &set.inputs).mapv(f32::abs).mean().unwrap()
        };
        let chosen = rendered_as(every_pose.sensed.sensors.clone());
        for other in [RangeSensors::default(), RangeSensors::default().as_rays()] {
            assert!(chosen <= 1.001 * rendered_as(other));
        }
    });
}
