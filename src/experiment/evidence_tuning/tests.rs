use super::*;
use crate::{
    belief::GridConfig,
    localiser::{TrialRunner, sensor_model::least_mean_squares},
    recording::{Channel, Columns},
    seed::Stream,
};
use ndarray::{Array2, array};
use rand::RngExt;
use rand_distr::StandardNormal;

/// Tuned on one validation snapshot at the first of three places, where it reads `seen`.
fn tuned(seen: f32) -> f64 {
    let candidates = Places::Route(vec![0.0, 10.0, 20.0]);
    let scans = array![[0.0], [0.1], [1.0]];
    let square = least_mean_squares(array![[seen]].view(), &[scans]);
    let validation = Places::Route(vec![0.0]);
    tuned_bandwidth(Uncertainty::Global, &validation, &candidates, square.view())
}

/// A reading of the way along a route, off by a metre or so each time, that counts as if it were `times` readings.
struct Repeats {
    reading_m: Vec<f64>,
    times: f64,
}

impl PreparedSensorModel for Repeats {
    fn log_likelihood(&self, k: usize, belief: &Belief, _: &mut Stream) -> Result<Vec<f64>> {
        let Places::Route(cells) = &**belief.places() else {
            unreachable!("cells along a route")
        };
        let gaussian = |x_m: &f64| -0.5 * self.times * (x_m - self.reading_m[k]).powi(2);
        Ok(cells.iter().map(gaussian).collect())
    }
}

/// A straight run of 300 m.
fn corridor() -> Recording {
    let way_m: Vec<f64> = (0..600).map(|k| 0.5 * f64::from(k)).collect();
    let pose = |x_m: &f64| Pose::new(*x_m, 0.0, 0.0);
    let poses: Vec<Pose> = way_m.iter().map(pose).collect();
    let light = Channel {
        name: "light".into(),
        width: 1,
        unit: String::new(),
        bearing_rad: None,
        maximum: None,
        offset_m: None,
    };
    Recording::new(Columns {
        channels: vec![light],
        values: Array2::zeros((600, 1)),
        stamp_s: (0..600).map(f64::from).collect(),
        odometry: poses.clone(),
        pose: poses,
        route_m: Some(way_m),
        run: vec![0; 600],
        ..Columns::default()
    })
    .unwrap()
}

#[test]
fn evidence_that_counts_twice_is_halved() {
    let recording = corridor();
    let way_m = recording.route_m().unwrap().to_vec();
    let places = Places::of(&recording);
    let grid = Arc::new(Grid::over(&places, &GridConfig::default()).unwrap());
    let trials: Vec<Trial> = (0..30)
        .map(|stretch| Trial {
            stretch,
            unit: stretch,
            snapshots: (20 * stretch..20 * stretch + 20).collect(),
            travelled_m: way_m[..20].to_vec(),
        })
        .collect();
    let sequences = Sequences {
        recording: &recording,
        places: &places,
        trials: &trials,
        grid: &grid,
        motion: &OdometryMotion::exact(),
    };
    let mut random = Seed(3).stream("readings");
    let mut reading = |x_m: &f64| -> f64 { x_m + random.sample::<f64, _>(StandardNormal) };
    let reading_m: Vec<f64> = way_m.iter().map(&mut reading).collect();
    let tuned = |times: f64| {
        let reading_m = reading_m.clone();
        let sensor = Repeats { reading_m, times };
        sequences.tuned(&sensor, Seed(1)).unwrap()
    };
    let (once, eight_times) = (tuned(1.0), tuned(8.0));
    assert!((0.5..=2.0).contains(&once), "{once}");
    assert!(
        (once / eight_times - 8.0).abs() < 1e-9,
        "{once} {eight_times}"
    );
}

/// It gives the true place a probability that is largest at a power of ¼, another one 3 m ahead the rest, and on the last
/// snapshot nothing at all.
struct Sure(f64);

impl Localiser for Sure {
    fn name(&self) -> &str {
        "sure"
    }
    fn places(&self) -> usize {
        0
    }
    fn bytes_per_place(&self) -> usize {
        0
    }
    fn evidence_scale(&self) -> Option<f64> {
        Some(self.0)
    }
    fn with_evidence_scale(&self, scale: f64) -> Option<Box<dyn Localiser + '_>> {
        (self.0 != 7.0).then(|| Box::new(Sure(scale)) as Box<dyn Localiser>)
    }
    fn check_channels(&self, _: &[Channel]) -> Result<()> {
        Ok(())
    }
    fn prepare<'a>(
        &'a self,
        recording: &'a Recording,
        _: &[usize],
    ) -> Result<Box<dyn TrialRunner + 'a>> {
        Ok(Box::new((self, recording)))
    }
}

impl TrialRunner for (&Sure, &Recording) {
    fn play(&self, trial: &[usize], _: Option<Pose>, _: &mut Stream) -> Result<Vec<Step>> {
        let near = 1.0 / (2.0 + (self.0.0 / 0.25).log2().powi(2));
        let step = |&k: &usize| {
            let x_m = self.1.poses()[k].x_m;
            let posterior = [([x_m + 0.4, 0.0], near), ([x_m + 3.0, 0.0], 1.0 - near)];
            Step {
                posterior: posterior.into_iter().filter(|_| k != trial[2]).collect(),
                ..Step::default()
            }
        };
        Ok(trial.iter().map(step).collect())
    }
}

#[test]
fn a_whole_localiser_is_tuned_on_the_mass_that_it_gives_to_the_truth() {
    let recording = corridor();
    let places = Places::of(&recording);
    let grid = Arc::new(Grid::over(&places, &GridConfig::default()).unwrap());
    let trials = [Trial {
        stretch: 0,
        unit: 0,
        snapshots: vec![10, 11, 12],
        travelled_m: vec![0.0, 0.5, 1.0],
    }];
    let sequences = Sequences {
        recording: &recording,
        places: &places,
        trials: &trials,
        grid: &grid,
        motion: &OdometryMotion::exact(),
    };
    // At ¼ half the mass is near the truth, twice; once none, which counts as that of one particle of 5,000.
    let nats = |scale: f64| {
        let found = sequences.negative_log_likelihood_of(&Sure(scale), Seed(1));
        found.unwrap()
    };
    let expected = (2.0 * 2_f64.ln() + 5000_f64.ln()) / 3.0;
    assert!((nats(0.25) - expected).abs() < 1e-12, "{}", nats(0.25));
    let expected = (2.0 * 3_f64.ln() + 5000_f64.ln()) / 3.0;
    assert!((nats(0.5) - expected).abs() < 1e-12, "{}", nats(0.5));
    let tuned = |localiser| sequences.tuned_localiser(&localiser, Seed(1)).unwrap();
    assert_eq!((tuned(Sure(1.0)), tuned(Sure(7.0))), (Some(0.25), None));
}

#[test]
fn scans_that_scatter_more_get_a_wider_kernel() {
    assert_eq!(tuned(0.0), BANDWIDTHS[0]);
    // Nearer to the second place's scan than to its own: a sharp kernel would be sure of the wrong place.
    assert!((0.08..0.64).contains(&tuned(0.06)), "{}", tuned(0.06));
}

#[test]
fn without_validation_the_middle_of_the_range_is_taken() {
    let (nowhere, places) = (Places::Route(Vec::new()), Places::Route(vec![0.0, 1.0]));
    let square = Array2::zeros((0, 2));
    let h = tuned_bandwidth(Uncertainty::Global, &nowhere, &places, square.view());
    assert_eq!(h, BANDWIDTHS[BANDWIDTHS.len() / 2]);
}
