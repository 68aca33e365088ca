//! How sharply answers count: constants of a likelihood, chosen on the validation part and never on what is judged.
//!
//! Readings of one snapshot are not independent of each other, nor are snapshots of one place. So every method's evidence
//! has a power ([`EvidenceScale`]), the same way for all: the one under which the Bayes filter, run over whole sequences of
//! the validation part, gives the truth the least negative log likelihood.

use super::{
    held_out::{by_kernel, by_likelihood},
    trials::Trial,
};
use crate::{
    belief::{Belief, Grid, OdometryMotion, Places, Uncertainty},
    error::Result,
    localiser::{
        BayesLocaliser, PreparedSensorModel,
        sensor_model::{EvidenceScale, Scaled},
    },
    recording::Recording,
    seed::Seed,
};
use ndarray::ArrayView2;
use rayon::prelude::*;
use std::{f64::consts::SQRT_2, sync::Arc};

/// Powers that evidence is tuned over.
pub const SCALES: [f64; 10] = [
    8.0, 4.0, 2.0, 1.0, 0.5, 0.25, 0.125, 0.0625, 0.03125, 0.015625,
];

/// A belief within this distance of the truth is right, in metres. A single cell would ask for more than a grid can say: where
/// the truth lies on a border between cells, a sharp belief takes the wrong one, and every evidence would seem too sharp.
const NEAR_M: f64 = 0.5;

/// Least likelihood of the truth that counts.
const LEAST: f64 = 1e-9;

/// Sequences of the validation part, and the filter that runs over them.
pub struct Sequences<'a> {
    /// Holds the validation part.
    pub recording: &'a Recording,
    /// Its places.
    pub places: &'a Places,
    /// Where each sequence starts, and the snapshots taken on its way.
    pub trials: &'a [Trial],
    /// Cells of the filter.
    pub grid: &'a Arc<Grid>,
    /// What it believes of odometry.
    pub motion: &'a OdometryMotion,
}

impl Sequences<'_> {
    /// Mean −ln Bel of the true place, all within half a metre of it, over all sequences, each from a start anywhere, in nats a
    /// snapshot; snapshots off the grid don't count.
    ///
    /// # Errors
    /// Where the sensor model fails.
    pub fn negative_log_likelihood(
        &self,
        sensor: &dyn PreparedSensorModel,
        scale: EvidenceScale,
        seed: Seed,
    ) -> Result<f64> {
        let sensor = Scaled::new(sensor, scale);
        let of_trial = |(number, trial): (usize, &Trial)| -> Result<(f64, usize)> {
            let start = Belief::uniform(self.grid.places())?;
            let stream = seed.numbered_stream("evidence tuning", number as u64);
            let mut robot =
                BayesLocaliser::new(self.grid, self.motion, start, Some(&sensor), stream)?;
            let (mut sum, mut count) = (0.0, 0);
            for &k in &trial.snapshots {
                let belief = robot.observe(k, &self.recording.observation(k))?;
                if self.grid.cell_at(self.places, k).is_some() {
                    let mass = belief.mass_within_m(self.places, k, NEAR_M);
                    sum -= mass.max(LEAST).ln();
                    count += 1;
                }
            }
            Ok((sum, count))
        };
        let each = self.trials.par_iter().enumerate().map(of_trial);
        let each = each.collect::<Result<Vec<_>>>()?;
        let (sum, count) = each.iter().fold((0.0, 0), |a, b| (a.0 + b.0, a.1 + b.1));
        Ok(sum / count.max(1) as f64)
    }

    /// The power of least negative log likelihood: among [`SCALES`], and then half an octave to either side of the best.
    ///
    /// # Errors
    /// Where the sensor model fails.
    pub fn tuned(&self, sensor: &dyn PreparedSensorModel, seed: Seed) -> Result<f64> {
        let mut best = (1.0, f64::INFINITY);
        let mut try_all = |scales: &[f64]| -> Result<f64> {
            for &scale in scales {
                let nats = self.negative_log_likelihood(sensor, EvidenceScale::of(scale), seed)?;
                if nats < best.1 {
                    best = (scale, nats);
                }
            }
            Ok(best.0)
        };
        let coarse = try_all(&SCALES)?;
        try_all(&[coarse * SQRT_2, coarse / SQRT_2])
    }
}

/// The power among [`SCALES`] under which single snapshots of the validation part leave least error, for figures of single
/// snapshots; 1 where nothing can be validated. `log_likelihood(row)` is ln P(s | candidate) for validation place `row`.
pub fn tuned_power(
    uncertainty: Uncertainty,
    validation: &Places,
    candidates: &Places,
    log_likelihood: impl Fn(usize) -> Vec<f64> + Sync,
) -> (f64, f64) {
    let mut best = (1.0, f64::INFINITY);
    if !validation.is_empty() {
        for power in SCALES {
            let score = by_likelihood(uncertainty, validation, candidates, |row| {
                let mut l = log_likelihood(row);
                l.iter_mut().for_each(|l| *l *= power);
                l
            });
            if score.posterior_error_m < best.1 {
                best = (power, score.posterior_error_m);
            }
        }
    }
    best
}

/// Bandwidths h that the kernel is tuned over, in units of the inputs' deviation.
const BANDWIDTHS: [f64; 10] = [0.01, 0.02, 0.04, 0.08, 0.12, 0.16, 0.24, 0.32, 0.64, 1.28];

/// The bandwidth of least error on the validation part, given as its places and their distances `[validation, candidate]`
/// from the candidates' scans; in the middle of the range where nothing can be validated.
pub fn tuned_bandwidth(
    uncertainty: Uncertainty,
    validation: &Places,
    candidates: &Places,
    square: ArrayView2<f32>,
) -> f64 {
    let mut best = (BANDWIDTHS[BANDWIDTHS.len() / 2], f64::INFINITY);
    if !validation.is_empty() {
        for h in BANDWIDTHS {
            let score = by_kernel(uncertainty, validation, candidates, square, h);
            if score.posterior_error_m < best.1 {
                best = (h, score.posterior_error_m);
            }
        }
    }
    best.0
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        belief::GridConfig,
        geometry::Pose,
        localiser::sensor_model::least_mean_squares,
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

    #[test]
    fn evidence_that_counts_twice_is_halved() {
        let way_m: Vec<f64> = (0..600).map(|k| 0.5 * f64::from(k)).collect();
        let pose = |x_m: &f64| Pose::new(*x_m, 0.0, 0.0);
        let poses: Vec<Pose> = way_m.iter().map(pose).collect();
        let light = Channel {
            name: "light".into(),
            width: 1,
            unit: String::new(),
            bearing_rad: None,
            maximum: None,
        };
        let recording = Recording::new(Columns {
            channels: vec![light],
            values: Array2::zeros((600, 1)),
            stamp_s: (0..600).map(f64::from).collect(),
            odometry: poses.clone(),
            pose: poses,
            route_m: Some(way_m.clone()),
            run: vec![0; 600],
            ..Columns::default()
        })
        .unwrap();
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
}
