//! A sensor model of one's own in the trials of `ballmark localise`: the same grid, filter and trials as everybody's.
//!
//! `cargo run --release --example own_sensor_model`

use ballmark::{
    Belief, Model, Observation, Result, Seed,
    belief::Places,
    experiment::{
        line_up::line_up,
        localisation::{self, LocaliseConfig},
        methods::MethodContext,
        parts::Parts,
    },
    localiser::SensorModel,
    seed::Stream,
    world::corridor::{CorridorConfig, thrun1998},
};
use std::path::Path;

/// How much room there is around the robot: the mean of all readings is Gaussian around what it was at the nearest place of
/// the map.
struct RoomAround {
    /// At every cell of the grid, in metres.
    expected_m: Vec<f64>,
    deviation_m: f64,
}

impl SensorModel for RoomAround {
    fn name(&self) -> &str {
        "room_around"
    }

    fn log_likelihood(
        &self,
        observation: &Observation,
        belief: &Belief,
        _: &mut Stream,
    ) -> Result<Vec<f64>> {
        let Some(mean_m) = mean(observation) else {
            return Ok(vec![0.0; belief.mass().len()]); // no return at all says nothing
        };
        let log = |expected_m: &f64| -0.5 * ((mean_m - expected_m) / self.deviation_m).powi(2);
        Ok(self.expected_m.iter().map(log).collect())
    }
}

fn mean(observation: &Observation) -> Option<f64> {
    let readings = observation.values.iter().filter(|v| v.is_finite());
    let (sum, n) = readings.fold((0.0, 0.0), |(sum, n), v| (sum + f64::from(*v), n + 1.0));
    (n > 0.0).then(|| sum / n)
}

pub fn main() -> Result<()> {
    let here = Path::new(env!("CARGO_MANIFEST_DIR"));
    // The corridor that the model learned from, driven again: its test part is what the trials run on.
    let model = Model::read(&here.join("models/corridor-2m.safetensors"))?;
    let recording = thrun1998(Seed(1), &CorridorConfig::default())?;
    let parts = Parts::new(&model, &recording, None)?;
    let config = LocaliseConfig {
        trials: 10,
        ..LocaliseConfig::default()
    };
    let models = [&model];
    let context = MethodContext::new(&models, &parts, &config)?;

    // What the training part showed at the place nearest to each cell.
    let training = &context.source()?.training;
    let mapped: Vec<(f64, f64)> = training
        .iter()
        .filter_map(|&k| Some((recording.route_m()?[k], mean(&recording.observation(k))?)))
        .collect();
    let Places::Route(cells) = &**context.grid.places() else {
        return Err(ballmark::Error::work("expected a grid along the corridor"));
    };
    let nearest = |cell: &f64| {
        let off = |place: &(f64, f64)| (place.0 - cell).abs();
        let nearest = mapped.iter().min_by(|a, b| off(a).total_cmp(&off(b)));
        nearest.map_or(0.0, |place| place.1)
    };
    let room_around = RoomAround {
        expected_m: cells.iter().map(nearest).collect(),
        deviation_m: 0.3,
    };

    let mut methods = line_up(&context)?;
    methods.push(context.sensor_model("room_around", "room around", Box::new(room_around)));
    let record = localisation::play(&context, methods, &mut |_| ())?;
    println!("{}", ballmark::report::localisation::table(&record).text());

    let found = |name: &str| {
        let mut results = record.results.iter();
        results
            .find(|result| result.name == name)
            .map(|result| result.global.converged_fraction)
    };
    assert!(found("room_around").is_some() && found("learned").is_some());
    Ok(())
}
