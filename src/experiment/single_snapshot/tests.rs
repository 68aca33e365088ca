use super::*;
use crate::{
    detector::Detector,
    experiment::{
        localise_config::LocaliseConfig,
        mapped::Mapped,
        parts::{Parts, TrainingSource},
    },
    recording::{Channel, Recording},
    seed::Seed,
    world::corridor,
};
use ndarray::{Array2, ArrayView2};
use std::borrow::Cow;

/// Signs of some readings, told with a chance of being wrong that is greater than it is.
struct HalfHearted {
    off: f32,
}

impl Detector for HalfHearted {
    fn features(&self) -> usize {
        24 // more than the exact objective takes
    }

    fn detect_batch(&self, _: &[Channel], values: ArrayView2<f32>) -> Result<Array2<f32>> {
        let short = |k: usize, i: usize| values[(k, i)] < 1.5;
        Ok(Array2::from_shape_fn((values.nrows(), 24), |(k, i)| {
            if short(k, i) {
                0.5 + self.off
            } else {
                0.5 - self.off
            }
        }))
    }
}

fn corridor() -> Recording {
    let config = corridor::CorridorConfig {
        runs: 6,
        spacing_m: 0.5,
    };
    corridor::thrun1998(Seed(3), &config).unwrap()
}

#[test]
fn features_count_as_much_as_the_validation_part_shows() {
    let recording = corridor();
    let of_runs = |some: std::ops::Range<i64>| {
        let of =
            |k: &usize| some.contains(&(recording.columns().run[*k] - recording.columns().run[0]));
        (0..recording.len()).filter(of).collect::<Vec<usize>>()
    };
    let parts = |validated: bool| Parts {
        run: &recording,
        places: Places::of(&recording),
        unseen: of_runs(5..6),
        unseen_is_validation: false,
        source: Some(TrainingSource {
            recording: Cow::Borrowed(&recording),
            training: of_runs(0..4),
            validation: if validated { of_runs(4..5) } else { Vec::new() },
        }),
    };
    let reduction = |off: f32, evidence: Evidence, validated: bool| {
        let parts = parts(validated);
        let config = LocaliseConfig {
            evidence,
            ..LocaliseConfig::default()
        };
        let mapped = Mapped::of(parts.source.as_ref().unwrap());
        let context = MethodContext::over(mapped, &parts, &config).unwrap();
        let method = context.detector("own", "own", &HalfHearted { off });
        let held_out = method.unwrap().held_out;
        held_out
            .iter()
            .map(|e| e.error_reduction)
            .collect::<Vec<f64>>()
    };
    // Of so many features no rule goes through all outcomes.
    for evidence in Evidence::ALL {
        let reduction = |validated| reduction(0.15, evidence, validated);
        let (taken, tuned) = (reduction(false), reduction(true));
        assert!(taken[0] < 0.1, "{evidence} at its word: {taken:?}");
        assert!(
            tuned[0] > taken[0] + 0.1,
            "{evidence}: {tuned:?}, {taken:?}"
        );
        assert!(tuned.iter().zip(&taken).all(|(tuned, taken)| tuned > taken));
    }
}
