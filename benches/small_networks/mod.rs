//! What the benchmarks of small networks train on and how: four networks 164→6→1 on a drive along a route.

use ballmark::{
    geometry::Pose,
    learning::{
        Recipe,
        recipe::{DescentConfig, Optimiser, Scale},
    },
    recording::{Channel, Columns, Recording},
    seed::Seed,
};
use ndarray::Array2;
use rand::RngExt;

/// Values of a snapshot, as many as Thrun 1998 (5.1.3) has.
pub const INPUTS: usize = 164;

/// One drive along the route, its snapshots evenly spaced, with sensors of no particular kind, which are fed to the
/// networks as they are.
pub fn recording(snapshots: usize, length_m: f64) -> Recording {
    let mut random = Seed(1).stream("bench");
    let along = |k: usize| length_m * k as f64 / (snapshots - 1) as f64;
    let pose: Vec<Pose> = (0..snapshots)
        .map(|k| Pose::new(along(k), 0.0, 0.0))
        .collect();
    Recording::new(Columns {
        channels: vec![Channel {
            name: "light".into(),
            width: INPUTS,
            unit: "lux".into(),
            bearing_rad: None,
            maximum: None,
            offset_m: None,
        }],
        values: Array2::from_shape_simple_fn((snapshots, INPUTS), || random.random_range(0.0..1.0)),
        stamp_s: (0..snapshots).map(|k| k as f64).collect(),
        odometry: pose.clone(),
        pose,
        run: vec![0; snapshots],
        route_m: Some((0..snapshots).map(along).collect()),
        ..Columns::default()
    })
    .expect("columns of one length")
}

/// Four networks of six hidden units, all snapshots at every step, Adam.
pub fn recipe() -> Recipe {
    let mut recipe = Recipe::thrun1998();
    recipe.descent = DescentConfig {
        optimiser: Optimiser::Adam,
        learning_rate: 0.01,
        scale: Scale::PriorShare,
        pseudo_pattern_steps: 1,
        ..recipe.descent
    };
    recipe
}
