use super::*;
use crate::{
    detector::Detector,
    experiment::{
        localise_config::LocaliseConfig,
        mapped::Mapped,
        method::Method,
        parts::{Parts, TrainingSource},
        product::product,
    },
    recording::{Channel, Recording},
    seed::Seed,
    world::corridor,
};
use ndarray::{Array2, ArrayView2};
use std::{borrow::Cow, ops::Range};

/// Features of a detector.
const SIGNS: usize = 24;

/// Signs of some readings, told with a chance of being wrong that is greater than it is.
struct HalfHearted {
    off: f32,
    /// What it looks at; of fewer readings than signs each has several, for greater and greater ranges.
    readings: Range<usize>,
}

impl Detector for HalfHearted {
    fn features(&self) -> usize {
        SIGNS // more than the exact objective takes
    }

    fn detect_batch(&self, _: &[Channel], values: ArrayView2<f32>) -> Result<Array2<f32>> {
        let readings = self.readings.len();
        let short = |k: usize, i: usize| {
            let range_m = values[(k, self.readings.start + i % readings)];
            range_m < 1.5 * (1 + i / readings) as f32
        };
        Ok(Array2::from_shape_fn((values.nrows(), SIGNS), |(k, i)| {
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

/// The last run is unseen, the one before it chooses powers where it is said to validate.
fn parts(recording: &Recording, validated: bool) -> Parts<'_> {
    let of_runs = |some: std::ops::Range<i64>| {
        let of =
            |k: &usize| some.contains(&(recording.columns().run[*k] - recording.columns().run[0]));
        (0..recording.len()).filter(of).collect::<Vec<usize>>()
    };
    Parts {
        run: recording,
        places: Places::of(recording),
        unseen: of_runs(5..6),
        unseen_is_validation: false,
        source: Some(TrainingSource {
            recording: Cow::Borrowed(recording),
            training: of_runs(0..4),
            validation: if validated { of_runs(4..5) } else { Vec::new() },
        }),
    }
}

/// Over the places of the training part.
fn in_context(recording: &Recording, validated: bool, test: impl FnOnce(&MethodContext)) {
    let parts = parts(recording, validated);
    let config = LocaliseConfig::default();
    let mapped = Mapped::of(parts.source.as_ref().unwrap());
    test(&MethodContext::over(mapped, &parts, &config).unwrap());
}

/// The filter with the signs of some readings.
fn signs<'a>(context: &MethodContext<'a>, readings: Range<usize>) -> Method<'a> {
    let name = format!("{readings:?}");
    let detector = HalfHearted {
        off: 0.15,
        readings,
    };
    context.detector(&name, &name, &detector).unwrap()
}

fn reductions(held_out: &[ErrorReduction]) -> Vec<f64> {
    held_out.iter().map(|e| e.error_reduction).collect()
}

#[test]
fn features_count_as_much_as_the_validation_part_shows() {
    let recording = corridor();
    let reduction = |off: f32, evidence: Evidence, validated: bool| {
        let parts = parts(&recording, validated);
        let config = LocaliseConfig {
            evidence,
            ..LocaliseConfig::default()
        };
        let mapped = Mapped::of(parts.source.as_ref().unwrap());
        let context = MethodContext::over(mapped, &parts, &config).unwrap();
        let method = context.detector(
            "own",
            "own",
            &HalfHearted {
                off,
                readings: 0..24,
            },
        );
        reductions(&method.unwrap().held_out)
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

#[test]
fn two_halves_of_the_readings_say_more_together_than_either() {
    for validated in [false, true] {
        in_context(&corridor(), validated, |context| {
            let (left, right) = (signs(context, 0..12), signs(context, 12..24));
            let both = product(context, "both", "both", &[&left, &right]).unwrap();
            let both = reductions(&both.unwrap().held_out);
            // Who has no likelihood has none together with others.
            let factors = [left.single_snapshots.as_deref(), None];
            let nothing = context.held_out_of_product(&factors).unwrap();
            assert!(nothing.held_out.is_empty());
            let (left, right) = (reductions(&left.held_out), reductions(&right.held_out));
            assert_eq!(both.len(), 2);
            // At their word these say nothing of where in all of the corridor.
            for prior in 0..if validated { 2 } else { 1 } {
                let better = left[prior].max(right[prior]);
                assert!(
                    both[prior] > better + 0.02,
                    "validated: {validated}, {both:?} of {left:?} and {right:?}"
                );
            }
        });
    }
}

#[test]
fn evidence_that_is_too_much_to_keep_is_judged_all_the_same() {
    in_context(&corridor(), true, |context| {
        let detector = HalfHearted {
            off: 0.15,
            readings: 0..24,
        };
        let (answers, map) = context.map_of(&detector).unwrap();
        let map = Arc::new(map.at(&context.mapped.places).unwrap());
        let sensor = PreparedFeatures::new(answers.run, Arc::clone(&map), Evidence::MeanField);
        let on_source = answers.source.unwrap();
        let on_source = PreparedFeatures::new(on_source, map, Evidence::MeanField);
        let some = context.validated().unwrap();
        let judged = |most_kept| {
            let on_source = (&on_source as &dyn PreparedSensorModel, &some[..]);
            let judged = context.held_out_by(&sensor, Some(on_source), most_kept);
            judged.unwrap()
        };
        let (kept, not_kept) = (judged(MOST_KEPT), judged(0));
        assert!(kept.evidence.is_some() && not_kept.evidence.is_none());
        assert_eq!(kept.held_out, not_kept.held_out);
    });
}

#[test]
fn who_only_disturbs_counts_for_little_together() {
    in_context(&corridor(), true, |context| {
        let all = signs(context, 0..24);
        let known = all.single_snapshots.as_deref().unwrap();
        // The same evidence of other snapshots, and as sure of itself.
        let mut shuffled = SingleSnapshots {
            on_run: known.on_run.clone(),
            on_validation: known.on_validation.clone(),
            powers: known.powers.clone(),
        };
        shuffled.on_run.invert_axis(ndarray::Axis(0));
        shuffled.on_validation.invert_axis(ndarray::Axis(0));
        let both = context.held_out_of_product(&[Some(known), Some(&shuffled)]);
        let both = reductions(&both.unwrap().held_out);
        for (both, alone) in both.iter().zip(reductions(&all.held_out)) {
            assert!(*both > alone - 0.03, "{both} together, {alone} alone");
        }
    });
}

#[test]
fn of_many_every_so_many_are_judged() {
    let all = |n: usize| Vec::from_iter(0..n);
    assert_eq!(evenly(all(5), 5), all(5));
    assert_eq!(evenly(all(6), 5), [0, 2, 4]);
    assert_eq!(evenly(all(11), 5), [0, 3, 6, 9]);
    assert!(evenly(Vec::new(), 5).is_empty());
}
