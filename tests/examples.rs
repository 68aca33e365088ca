//! Every example runs.

#[path = "../examples/live_robot.rs"]
mod live_robot;
#[path = "../examples/own_detector.rs"]
mod own_detector;
#[path = "../examples/own_localiser.rs"]
mod own_localiser;
#[path = "../examples/own_recogniser.rs"]
mod own_recogniser;
#[path = "../examples/own_sensor_model.rs"]
mod own_sensor_model;
#[path = "../examples/score_csv.rs"]
mod score_csv;
#[path = "../examples/train_and_localise.rs"]
mod train_and_localise;

#[test]
fn live_robot_runs() {
    live_robot::main().unwrap();
}

#[test]
fn own_detector_runs() {
    own_detector::main().unwrap();
}

#[test]
fn own_localiser_runs() {
    own_localiser::main().unwrap();
}

#[test]
fn own_recogniser_runs() {
    own_recogniser::main().unwrap();
}

#[test]
fn own_sensor_model_runs() {
    own_sensor_model::main().unwrap();
}

#[test]
fn score_csv_runs() {
    score_csv::main().unwrap();
}

#[test]
fn train_and_localise_runs() {
    train_and_localise::main().unwrap();
}
