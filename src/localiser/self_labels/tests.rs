use super::*;
use crate::recording::{Columns, npz};
use std::path::Path;

fn corridor() -> Recording {
    npz::read(&Path::new(env!("CARGO_MANIFEST_DIR")).join("datasets/corridor-small.npz")).unwrap()
}

fn model() -> Model {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("models/corridor-2m.safetensors");
    Model::read(&path).unwrap()
}

/// Its last run, whose snapshots can be changed.
fn run(change: impl FnOnce(&mut Columns)) -> Recording {
    let recording = corridor();
    let last: Vec<usize> = recording.runs().pop().unwrap().collect();
    let mut columns = recording.select(&last).unwrap().into_columns();
    change(&mut columns);
    Recording::new(columns).unwrap()
}

fn errors_m(labels: &[SelfLabel], recording: &Recording) -> Vec<f64> {
    let truth = recording.route_m().unwrap().iter();
    let errors = labels.iter().zip(truth);
    errors
        .map(|(label, truth)| (label.route_m.unwrap() - truth).abs())
        .collect()
}

#[test]
fn labels_of_a_run_are_right_from_its_first_metres_on() {
    let (model, run) = (model(), run(|_| {}));
    let labels = of_model(&model, &run, &SelfLabelConfig::default(), None).unwrap();
    assert_eq!(labels.len(), run.len());
    let errors = errors_m(&labels, &run);
    let early = &errors[..run.len() / 8];
    assert!(early.iter().all(|m| *m < 1.0), "{early:?}");
    // In the plane a label lies on the robot's way.
    for (label, truth) in labels.iter().zip(run.poses()) {
        assert!(
            !label.kept || label.pose.distance_m(truth) < 1.5,
            "{label:?} {truth:?}"
        );
    }
    // A filter has no idea at first.
    let filtered = SelfLabelConfig {
        from: LabelsFrom::Filtered,
        ..SelfLabelConfig::default()
    };
    let filtered = of_model(&model, &run, &filtered, None).unwrap();
    let worst = |errors: &[f64]| errors.iter().copied().fold(0.0, f64::max);
    assert!(worst(&errors_m(&filtered, &run)) > 3.0 * worst(&errors));
}

#[test]
fn a_known_start_is_believed() {
    let (model, run) = (model(), run(|_| {}));
    let config = SelfLabelConfig {
        from: LabelsFrom::Filtered,
        ..SelfLabelConfig::default()
    };
    let start = |x_m: f64| {
        let start = KnownStart {
            pose: Pose::new(x_m, 0.0, 0.0),
            spread_m: 0.3,
            spread_rad: 0.1,
        };
        of_model(&model, &run, &config, Some(start))
    };
    let labels = start(run.route_m().unwrap()[0]).unwrap();
    assert!(errors_m(&labels, &run)[..8].iter().all(|m| *m < 0.5));
    let off = start(-500.0).unwrap_err();
    assert!(off.to_string().contains("off the grid"), "{off}");
}

/// Who is carried, or whose readings are somebody else's, does not believe its labels.
#[test]
fn the_gate_keeps_out_what_the_rest_of_the_run_contradicts() {
    let model = model();
    let share = |run: &Recording| {
        let config = SelfLabelConfig {
            gate_over: GateOver::Moment,
            ..SelfLabelConfig::default()
        };
        let labels = of_model(&model, run, &config, None).unwrap();
        labels.iter().filter(|label| label.kept).count() as f64 / labels.len() as f64
    };
    let as_it_was = share(&run(|_| {}));
    let noise = run(|columns| {
        let rows = columns.values.nrows();
        let shuffled: Vec<usize> = (0..rows).map(|k| k * 89 % rows).collect();
        columns.values = columns.values.select(ndarray::Axis(0), &shuffled);
    });
    assert!(as_it_was > 0.6, "{as_it_was}");
    assert!(share(&noise) < 0.25 * as_it_was, "{}", share(&noise));
    // Asked as a whole, the run is believed or it isn't.
    let by_run = |run: &Recording| {
        let labels = of_model(&model, run, &SelfLabelConfig::default(), None).unwrap();
        labels.iter().filter(|label| label.kept).count() as f64 / labels.len() as f64
    };
    let whole = by_run(&run(|_| {}));
    assert!(whole > as_it_was, "{whole} {as_it_was}");
    assert_eq!(by_run(&noise), 0.0);
    // Without a gate all are taken.
    let open = SelfLabelConfig {
        gate: 1.0,
        ..SelfLabelConfig::default()
    };
    let labels = of_model(&model, &noise, &open, None).unwrap();
    assert!(labels.iter().all(|label| label.kept));
}

#[test]
fn labels_are_the_same_on_any_number_of_threads() {
    let (model, run) = (model(), run(|_| {}));
    let on = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .unwrap();
        pool.install(|| of_model(&model, &run, &SelfLabelConfig::default(), None))
            .unwrap()
    };
    assert_eq!(on(1), on(3));
}

#[test]
fn anchors_stand_as_far_apart_as_odometry_says() {
    let at = |k: usize| Pose::new(0.2 * k as f64, 0.0, 0.0);
    assert_eq!(spaced(2..12, 0.5, at), [2, 5, 8, 11]);
    assert_eq!(spaced(4..5, 0.5, at), [4]);
}

#[test]
fn constants_that_make_no_sense_are_refused_by_name() {
    let refused = |change: fn(&mut SelfLabelConfig), words: &str| {
        let mut config = SelfLabelConfig::default();
        change(&mut config);
        let fault = config.check().unwrap_err();
        assert!(
            fault.is_usage() && fault.to_string().contains(words),
            "{fault}"
        );
    };
    assert!(SelfLabelConfig::default().check().is_ok());
    refused(|c| c.gate = f64::NAN, "labels.gate = NaN");
    refused(|c| c.spacing_m = 0.0, "labels.spacing_m = 0");
    refused(|c| c.lost.slope = -1.0, "`slope`");
    refused(|c| c.beyond_m = -1.0, "labels.beyond_m = -1");
    refused(|c| c.grid.cell_m = -1.0, "`cell_m`");
}

/// Lamps of a corridor of 10 m along x: one at 2 m, another kind at 6 m, none elsewhere. It tells which is overhead.
struct Lamps<'a> {
    grid: &'a Grid,
    seen: Vec<u8>,
}

fn lamp_at(x_m: f64) -> u8 {
    match x_m {
        x if (x - 2.0).abs() < 0.5 => 1,
        x if (x - 6.0).abs() < 0.5 => 2,
        _ => 0,
    }
}

impl PreparedSensorModel for Lamps<'_> {
    fn log_likelihood(
        &self,
        snapshot: usize,
        _belief: &Belief,
        _stream: &mut crate::seed::Stream,
    ) -> Result<Vec<f64>> {
        let places = self.grid.places();
        let of_cell = |cell: usize| match lamp_at(places.pose(cell).x_m) == self.seen[snapshot] {
            true => 0.9_f64.ln(),
            false => 0.05_f64.ln(),
        };
        Ok((0..places.len()).map(of_cell).collect())
    }
}

/// The robot drives along the corridor, goes 6 m into a room that the map lacks, comes back, and drives on.
#[test]
fn who_goes_beyond_the_map_is_not_laid_over_it() {
    let corridor = (0..=40).map(|k| 0.25 * f64::from(k));
    let mapped: Vec<Pose> = corridor.map(|x_m| Pose::new(x_m, 0.0, 0.0)).collect();
    let mut way: Vec<Pose> = (0..12)
        .map(|k| Pose::new(0.5 * f64::from(k) + 1.0, 0.0, 0.0))
        .collect();
    let corner = *way.last().unwrap();
    let room =
        |y_m: f64, turned: f64| Pose::new(corner.x_m, y_m, turned * std::f64::consts::FRAC_PI_2);
    way.extend((0..=12).map(|k| room(0.5 * f64::from(k), 1.0)));
    way.extend((0..=12).rev().map(|k| room(0.5 * f64::from(k), -1.0)));
    way.extend((0..6).map(|k| Pose::new(corner.x_m + 0.5 * f64::from(k), 0.0, 0.0)));
    let seen = way
        .iter()
        .map(|p| if p.y_m > 1.0 { 0 } else { lamp_at(p.x_m) });
    let seen: Vec<u8> = seen.collect();
    let recording = Recording::new(Columns {
        channels: vec![crate::recording::Channel {
            name: "lamp".into(),
            width: 1,
            unit: String::new(),
            bearing_rad: None,
            maximum: None,
            offset_m: None,
        }],
        values: ndarray::Array2::from_shape_fn((way.len(), 1), |(k, _)| f32::from(seen[k])),
        stamp_s: (0..way.len()).map(|k| k as f64).collect(),
        odometry: way.clone(),
        pose: way.clone(),
        run: vec![0; way.len()],
        ..Columns::default()
    })
    .unwrap();
    let labels = |beyond_m: f64| {
        let config = SelfLabelConfig {
            gate_over: GateOver::Moment,
            ..SelfLabelConfig::default()
        };
        let places = Places::Plane(mapped.clone());
        let cells = Beyond::new(&places, &config.grid, beyond_m).unwrap();
        let lamps = Lamps {
            grid: &cells.mapped,
            seen: seen.clone(),
        };
        let labeller = Labeller {
            grid: &cells.grid,
            motion: &OdometryMotion::default(),
            sensor: &BeyondTheMap {
                cells: &cells,
                within: &lamps,
                anywhere: Belief::uniform(cells.mapped.places()).unwrap(),
            },
            pose: &mapped,
            route_m: None,
            is_mapped: Some(&cells.is_mapped()),
        };
        let start = KnownStart {
            pose: way[0],
            spread_m: 0.3,
            spread_rad: 0.1,
        };
        self_labels(&labeller, &recording, &config, Some(start)).unwrap()
    };
    let worst_m = |labels: &[SelfLabel]| {
        let off = labels.iter().zip(&way);
        off.map(|(label, truth)| label.pose.distance_m(truth))
            .fold(0.0, f64::max)
    };
    let (within, beyond) = (labels(0.0), labels(8.0));
    assert!(worst_m(&within) > 2.0, "{}", worst_m(&within));
    assert!(worst_m(&beyond) < 1.0, "{}", worst_m(&beyond));
    for (label, truth) in beyond.iter().zip(&way) {
        assert!(!(label.kept && truth.y_m > 1.5), "{label:?} {truth:?}");
        assert!(label.beyond || truth.y_m <= 1.5, "{label:?} {truth:?}");
    }
    assert!(beyond[..10].iter().all(|label| !label.beyond)); // before it enters the room
    assert!(within.iter().all(|label| !label.beyond));
}
