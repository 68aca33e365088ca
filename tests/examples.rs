//! Every example runs.

#[path = "../examples/live_robot.rs"]
mod live_robot;
#[path = "../examples/score_csv.rs"]
mod score_csv;
#[path = "../examples/train_and_localise.rs"]
mod train_and_localise;

#[test]
fn live_robot_runs() {
    live_robot::main().unwrap();
}

#[test]
fn score_csv_runs() {
    score_csv::main().unwrap();
}

#[test]
fn train_and_localise_runs() {
    train_and_localise::main().unwrap();
}
