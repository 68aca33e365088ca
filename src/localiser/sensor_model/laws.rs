//! What holds for every sensor model.

use super::*;
use crate::{
    belief::{
        Evidence, FeatureMap, MapConfig, Nearness, Neighbours, Places, SignalField,
        SignalFieldConfig, bayes, signal_field::LabelledReadings,
    },
    detector::{
        Detector,
        input::{Input, InputConfig},
        random_projection::RandomProjection,
    },
    geometry::Pose,
    mapping::{
        LikelihoodField, LikelihoodFieldConfig, OccupancyMap, OccupancyMapConfig, RangeSensors,
    },
    recogniser::test_world::test_world,
    recording::{Channel, Columns},
    seed::Seed,
};
use ndarray::{Array2, ArrayView1, Axis};
use std::sync::Arc;

const PLACES: usize = 30;

/// A corridor whose walls come and go: a snapshot every half metre, 12 ranges.
fn corridor() -> Recording {
    let sonar = Channel {
        name: "sonar".into(),
        width: 12,
        unit: "m".into(),
        bearing_rad: None,
        maximum: Some(8.0),
        offset_m: None,
    };
    let pose: Vec<Pose> = (0..PLACES)
        .map(|k| Pose::new(0.5 * k as f64, 0.0, 0.1 * (k % 3) as f64))
        .collect();
    let range = |(k, beam): (usize, usize)| 3.0 + ((k * (beam + 2)) as f32 * 0.7).sin() * 2.5;
    Recording::new(Columns {
        channels: vec![sonar],
        values: Array2::from_shape_fn((PLACES, 12), range),
        stamp_s: vec![0.0; PLACES],
        odometry: pose.clone(),
        compass_rad: Some(pose.iter().map(|pose| pose.heading_rad).collect()),
        pose,
        run: vec![0; PLACES],
        ..Columns::default()
    })
    .unwrap()
}

fn nearness() -> Nearness {
    Nearness {
        k: 2,
        ..Nearness::default()
    }
}

fn learned(recording: &Recording, evidence: Evidence) -> LearnedFeatures {
    let all: Vec<usize> = (0..PLACES).collect();
    let input = Input::fit(&InputConfig::default(), recording, &all).unwrap();
    let detector = RandomProjection::new(input, 5, Seed(1));
    let activation = detector.probabilities(recording).unwrap();
    let config = MapConfig {
        nearness: nearness(),
        ..MapConfig::default()
    };
    let places = Places::of(recording);
    let map = FeatureMap::new(places.clone(), activation.mapv(f64::from), config).unwrap();
    let map = Arc::new(map.at(&places).unwrap());
    LearnedFeatures::new(Arc::new(detector), map, evidence).unwrap()
}

fn kernel(recording: &Recording, views: usize) -> RawKernel {
    let all: Vec<usize> = (0..PLACES).collect();
    let input = Input::fit(&InputConfig::default(), recording, &all).unwrap();
    let input = input.with_common_scale();
    let scans = input.transform(recording).unwrap();
    let views = (0..views).map(|view| scans.mapv(|v| v + 0.1 * view as f32));
    let places = Places::of(recording);
    let near = Neighbours::find(&places, &places, &nearness()).unwrap();
    RawKernel::new(input, views.collect(), near.into(), 0.4, 0.01).unwrap()
}

fn signal_field(recording: &Recording) -> SignalFieldModel {
    let all: Vec<usize> = (0..PLACES).collect();
    let readings = LabelledReadings::of(recording, &all, &[]).unwrap();
    let config = SignalFieldConfig {
        pass_snapshots: 1,
        ..SignalFieldConfig::default()
    };
    let field = SignalField::fit(&readings, &config).unwrap();
    SignalFieldModel::new(field.at(&readings.places).unwrap().into())
}

fn models(recording: &Recording) -> Vec<Box<dyn SensorModel>> {
    let mut all: Vec<Box<dyn SensorModel>> = Vec::new();
    for evidence in Evidence::ALL {
        all.push(Box::new(learned(recording, evidence)));
    }
    for views in [1, 3] {
        all.push(Box::new(kernel(recording, views)));
    }
    all.push(Box::new(signal_field(recording)));
    all.push(Box::new(Compass::new(0.0, 0.2).unwrap()));
    let (features, compass) = (
        learned(recording, Evidence::MeanField),
        Compass::new(0.0, 0.2).unwrap(),
    );
    let both: Vec<Box<dyn SensorModel>> = vec![Box::new(features), Box::new(compass)];
    all.push(Box::new(Independent::new(both)));
    all
}

/// The models that ask a map: of a room of 9 m by 6 m with a pillar, along its walls.
fn models_in_a_map(recording: &Recording) -> Vec<Box<dyn SensorModel>> {
    let all: Vec<usize> = (0..recording.len()).collect();
    // The sonars of that room are rays.
    let sensors = RangeSensors::default().as_rays();
    let config = OccupancyMapConfig {
        sensors: sensors.clone(),
        ..OccupancyMapConfig::default()
    };
    let map = OccupancyMap::from_scans(recording, &all, &config).unwrap();
    let poses: Vec<Vec<Pose>> = recording.poses().iter().map(|&pose| vec![pose]).collect();
    let field = LikelihoodField::new(&map, &LikelihoodFieldConfig::default()).unwrap();
    let field = LikelihoodFieldModel::at_poses(&Arc::new(field), poses.clone()).unwrap();
    let config = BeamModelConfig {
        sensors,
        ..BeamModelConfig::default()
    };
    let beams = BeamModel::at_poses(&map, recording.channels(), &config, poses).unwrap();
    vec![Box::new(field), Box::new(beams)]
}

/// All models, each with the recording that it was made of.
fn everybody<'a>(
    corridor: &'a Recording,
    room: &'a Recording,
) -> impl Iterator<Item = (Box<dyn SensorModel>, &'a Recording)> {
    let all = models(corridor).into_iter().map(move |m| (m, corridor));
    let in_a_map = models_in_a_map(room).into_iter();
    all.chain(in_a_map.map(move |model| (model, room)))
}

fn posterior(belief: &Belief, log_likelihood: &[f64]) -> Vec<f64> {
    let mut belief = belief.clone();
    bayes::correct(&mut belief, log_likelihood).unwrap();
    belief.mass().to_vec()
}

#[test]
fn a_live_robot_and_a_recording_get_the_same_answers() {
    let (corridor, room) = (corridor(), test_world());
    for (model, recording) in everybody(&corridor, &room) {
        let belief = Belief::uniform(&Arc::new(Places::of(recording))).unwrap();
        let prepared = model.prepare(recording, &[7, 3, 20]).unwrap();
        let places = recording.len();
        for snapshot in [3, 7, 20] {
            let stream = || Seed(5).stream("drawn features");
            let observation = recording.observation(snapshot);
            let live = model.log_likelihood(&observation, &belief, &mut stream());
            let replayed = prepared.log_likelihood(snapshot, &belief, &mut stream());
            let live = posterior(&belief, &live.unwrap());
            let replayed = posterior(&belief, &replayed.unwrap());
            let off = live.iter().zip(&replayed).map(|(a, b)| (a - b).abs());
            assert!(off.fold(0.0, f64::max) < 1e-5, "{}", model.name());
            // It says something, and the truth is among the likeliest places.
            let likelier = live.iter().filter(|&&mass| mass > live[snapshot]).count();
            assert!(likelier <= places / 2, "{}: {likelier}", model.name());
            assert!(live[snapshot] > 1.0 / places as f64, "{}", model.name());
        }
    }
}

/// Who says that belief and random numbers don't count answers alike whatever they are; who draws features, or asks the belief, says that they do.
#[test]
fn who_does_not_depend_on_the_belief_is_known() {
    let (corridor, room) = (corridor(), test_world());
    let mut depending = Vec::new();
    for (number, (model, recording)) in everybody(&corridor, &room).enumerate() {
        let places = Arc::new(Places::of(recording));
        let anywhere = Belief::uniform(&places).unwrap();
        let near = Belief::around(&places, &places, 3, 1.0, 0.5).unwrap();
        let prepared = model.prepare(recording, &[3, 7]).unwrap();
        let said = |belief: &Belief, seed: u64| {
            let mut stream = Seed(seed).stream("drawn features");
            [3, 7].map(|k| prepared.log_likelihood(k, belief, &mut stream).unwrap())
        };
        match prepared.depends_on_belief() {
            true => depending.push(number),
            false => assert_eq!(said(&anywhere, 1), said(&near, 2), "{}", model.name()),
        }
    }
    let draw_or_ask: Vec<usize> = (0..Evidence::ALL.len())
        .filter(|&e| matches!(Evidence::ALL[e], Evidence::Sampled | Evidence::Jeffrey))
        .collect();
    assert_eq!(depending, draw_or_ask);
}

#[test]
fn names_tell_models_apart() {
    let recording = corridor();
    let names: Vec<String> = models(&recording)
        .iter()
        .map(|model| model.name().to_string())
        .collect();
    assert_eq!(
        names[3..],
        [
            "learned",
            "kernel",
            "kernel_views",
            "signal_field",
            "compass",
            "learned+compass"
        ]
    );
}

#[test]
fn odd_readings_give_an_answer_or_an_error_and_never_a_panic() {
    let (corridor, room) = (corridor(), test_world());
    let mut stream = Seed(5).stream("drawn features");
    for (model, recording) in everybody(&corridor, &room) {
        let belief = Belief::uniform(&Arc::new(Places::of(recording))).unwrap();
        let width = recording.values().ncols();
        for reading in [f32::NAN, f32::INFINITY, -f32::INFINITY, f32::MAX, -3.0] {
            let values = vec![reading; width];
            let observation =
                Observation::new(recording.channels(), &values, 0.0, Pose::default()).unwrap();
            let answer = model.log_likelihood(&observation, &belief, &mut stream);
            let sums = posterior(&belief, &answer.unwrap()).iter().sum::<f64>();
            assert!((sums - 1.0).abs() < 1e-12, "{}: {reading}", model.name());
        }
        if model.name() == "compass" {
            continue; // works from no channel
        }
        let few = Observation {
            values: ArrayView1::from(&[1.0; 5]),
            ..recording.observation(0)
        };
        let error = model.log_likelihood(&few, &belief, &mut stream);
        let error = error.unwrap_err().to_string();
        assert!(
            error.contains(&format!("5 values; expected {width}")),
            "{error}"
        );
        let mut camera = recording.channels().to_vec();
        (camera[0].name, camera[0].bearing_rad) = ("camera".into(), None);
        let other = Observation {
            channels: &camera,
            ..recording.observation(0)
        };
        let error = model.log_likelihood(&other, &belief, &mut stream);
        let error = error.unwrap_err().to_string();
        // A field takes any range sensor that knows where its beams look.
        let missed = match model.name() {
            "likelihood_field" => "has bearings",
            _ => "`sonar`",
        };
        assert!(error.contains(missed), "{error}");
    }
}

/// What a model says about the place must sum up to how likely the belief held the answer to be: by hand, from the map.
#[test]
fn the_likelihood_under_the_belief_is_what_each_rule_says() {
    let recording = corridor();
    let places = Arc::new(Places::of(&recording));
    let mass = (0..PLACES).map(|k| 1.0 + k as f64).collect();
    let belief = Belief::from_mass(&places, mass).unwrap();
    let observation = recording.observation(4);
    for evidence in [Evidence::Jeffrey, Evidence::Likelihood, Evidence::MeanField] {
        let model = learned(&recording, evidence);
        let mut stream = Seed(5).stream("unused");
        let log_likelihood = model.log_likelihood(&observation, &belief, &mut stream);
        let weighed = belief.mass().iter().zip(log_likelihood.unwrap());
        let found: f64 = weighed.map(|(mass, l)| mass * l.exp()).sum();
        let g = model.detector.detect(&observation).unwrap();
        let at_cell = |cell: usize| -> f64 {
            let m = model.map.probability();
            let each = g.iter().zip(m.index_axis(Axis(0), cell));
            each.map(|(&g, &m): (&f32, &f64)| {
                let g = f64::from(g);
                match evidence {
                    Evidence::MeanField => m.powf(g) * (1.0 - m).powf(1.0 - g),
                    _ => g * m + (1.0 - g) * (1.0 - m),
                }
            })
            .product()
        };
        let expected: f64 = (0..PLACES).map(|k| belief.mass()[k] * at_cell(k)).sum();
        assert!(
            (found / expected - 1.0).abs() < 1e-9,
            "{evidence}: {found} {expected}"
        );
    }
}

#[test]
fn parts_that_do_not_fit_are_refused() {
    let recording = corridor();
    let all: Vec<usize> = (0..PLACES).collect();
    let input = Input::fit(&InputConfig::default(), &recording, &all).unwrap();
    let good = learned(&recording, Evidence::MeanField);
    let three = Arc::new(RandomProjection::new(input.clone(), 3, Seed(1)));
    let error = LearnedFeatures::new(three, good.map, Evidence::MeanField).err();
    assert!(
        error
            .unwrap()
            .to_string()
            .contains("3 features; expected 5")
    );
    let places = Places::of(&recording);
    let near: Arc<Neighbours> = Neighbours::find(&places, &places, &nearness())
        .unwrap()
        .into();
    let scans = Array2::zeros((PLACES, input.width()));
    let kernel = |views, bandwidth| {
        let made = RawKernel::new(input.clone(), views, Arc::clone(&near), bandwidth, 0.01);
        made.err().unwrap().to_string()
    };
    assert!(kernel(vec![], 0.1).contains("at least one"));
    assert!(kernel(vec![scans.clone()], 0.0).contains("bandwidth"));
    let few = Array2::zeros((PLACES - 1, input.width()));
    assert!(kernel(vec![few.clone()], 0.1).contains("neighbour 29"));
    assert!(kernel(vec![scans, few], 0.1).contains("as many places"));
}

#[test]
fn a_signal_field_asks_for_its_own_cells_and_channels_as_they_were() {
    let recording = corridor();
    let model = signal_field(&recording);
    let few = Arc::new(Places::of(&recording).select(&[0, 1, 2]));
    let belief = Belief::uniform(&few).unwrap();
    let mut stream = Seed(5).stream("unused");
    let observation = recording.observation(0);
    let error = model.log_likelihood(&observation, &belief, &mut stream);
    let error = error.unwrap_err().to_string();
    assert_eq!(
        error,
        "signal field: a belief of 3 cells; expected 30, those of the field"
    );
    let mut columns = recording.columns().clone();
    columns.channels[0].unit = "cm".into();
    let other = Recording::new(columns).unwrap();
    let error = model.prepare(&other, &[0]).err().unwrap().to_string();
    assert_eq!(
        error,
        "signal field: channel `sonar` has 12 values in `cm`; expected 12 in `m`, as it was learned from"
    );
}
