//! Every example runs.

#[path = "../examples/score_csv.rs"]
mod score_csv;
#[path = "../examples/train_and_localise.rs"]
mod train_and_localise;

#[test]
fn train_and_localise_runs() {
    train_and_localise::main().unwrap();
}

#[test]
fn score_csv_runs() {
    score_csv::main().unwrap();
}
