//! Every example runs.

#[path = "../examples/live_robot.rs"]
mod live_robot;

#[test]
fn live_robot_runs() {
    live_robot::main().unwrap();
}
