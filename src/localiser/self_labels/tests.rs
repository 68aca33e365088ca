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
    refused(|c| c.grid.cell_m = -1.0, "`cell_m`");
}
