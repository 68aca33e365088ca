//! A robot localises itself as it drives, observation by observation: no dataset, no file.
//!
//! `cargo run --release --example live_robot`

use ballmark::{
    learning::{Recipe, trainer, training_set::TrainingSet},
    localiser::LiveLocaliser,
    model::Model,
    recording::Observation,
    seed::Seed,
    world::corridor::{CorridorConfig, thrun1998},
};

pub fn main() -> ballmark::Result<()> {
    // Train a small model on five runs along a simulated corridor, for a robot that has no idea where it is.
    let config = |runs| CorridorConfig {
        runs,
        spacing_m: 0.5,
    };
    let recording = thrun1998(Seed(1), &config(5))?;
    let mut recipe = Recipe {
        features: 4,
        uncertainty: "global".parse()?,
        ..Recipe::default()
    };
    recipe.descent.steps = 300;
    let split = recipe.split.split(&recording)?;
    let training_set = TrainingSet::prepare(&recipe, &recording, &split)?;
    let trained = trainer::train(&recipe, &training_set, None, false, "", &mut |_| ())?;
    let model = Model::new(&recipe, &recording, &training_set, trained);

    // The robot: sonar readings and odometry come in, one after the other. Here a simulated run stands for both.
    let run = thrun1998(Seed(2), &config(1))?;
    let mut robot = LiveLocaliser::new(&model)?;
    println!("  true   mean     sd  entropy  ln P(z)");
    for k in 0..run.len() {
        let sensed = run.observation(k);
        let readings = sensed.values.to_vec(); // 24 ranges in metres, NaN where there was no return
        let channels = &model.header.channels;
        let observation = Observation::new(channels, &readings, sensed.stamp_s, sensed.odometry)?;
        let log_predictive = robot.observe(&observation)?;
        if k % 10 == 0 {
            let truth_m = run.route_m().map_or(f64::NAN, |route| route[k]);
            println!(
                "{truth_m:6.1} {:6.1} {:6.2} {:8.2} {log_predictive:8.2}  {}",
                robot.mean().x_m, // along the corridor, in metres
                robot.covariance()[(0, 0)].sqrt(),
                robot.entropy(),
                if robot.lost() { "lost" } else { "" },
            );
        }
    }
    Ok(())
}
