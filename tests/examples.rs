//! Every example runs.

#[path = "../examples/train_and_localise.rs"]
mod train_and_localise;

#[test]
fn train_and_localise_runs() {
    train_and_localise::main().unwrap();
}
