//! Splits that cut nothing and lose nothing.

use super::*;
use crate::{
    geometry::Pose,
    recording::{Channel, Columns},
    seed::Seed,
};
use rand::RngExt;

/// A wandering robot in several runs.
fn recording(seed: u64, snapshots: usize, runs: i64) -> Recording {
    let mut stream = Seed(seed).stream("walk");
    let mut x_m = 0.0;
    let pose: Vec<Pose> = (0..snapshots)
        .map(|_| {
            x_m += stream.random::<f64>();
            Pose::new(x_m, 0.0, 0.0)
        })
        .collect();
    Recording::new(Columns {
        channels: vec![Channel {
            name: "light".into(),
            width: 1,
            unit: "lux".into(),
            bearing_rad: None,
            maximum: None,
            offset_m: None,
        }],
        values: ndarray::Array2::zeros((snapshots, 1)),
        stamp_s: vec![0.0; snapshots],
        odometry: pose.clone(),
        pose,
        run: (0..snapshots)
            .map(|k| k as i64 * runs / snapshots as i64)
            .collect(),
        ..Columns::default()
    })
    .unwrap()
}

#[test]
fn parts_are_disjoint_complete_and_cut_no_unit() {
    for seed in 0..20 {
        let recording = recording(seed, 300, 1 + seed as i64 % 4);
        for stretch_m in [2.0, 7.5, 15.0] {
            for test_fold in [None, Some(0), Some(2)] {
                let config = SplitConfig {
                    unit: Unit::Stretch(stretch_m),
                    folds: 3,
                    test_fold,
                    validation_every: 3,
                };
                let split = config.split(&recording).unwrap();
                let mut all = [
                    split.train.clone(),
                    split.validation.clone(),
                    split.test.clone(),
                ]
                .concat();
                all.sort_unstable();
                assert_eq!(all, (0..300).collect::<Vec<_>>());
                let travelled = recording.travelled_m();
                let unit = |k: usize| {
                    (
                        recording.columns().run[k],
                        (travelled[k] / stretch_m) as i64,
                    )
                };
                let side = |k: usize| (split.test.contains(&k), split.validation.contains(&k));
                for k in 1..300 {
                    assert!(
                        unit(k) != unit(k - 1) || side(k) == side(k - 1),
                        "unit cut at {k}"
                    );
                }
            }
        }
    }
}

#[test]
fn every_snapshot_is_tested_on_once_over_all_folds() {
    let recording = recording(1, 200, 5);
    let mut tested = vec![0; 200];
    for fold in 0..5 {
        let config = SplitConfig {
            unit: Unit::Runs,
            folds: 5,
            test_fold: Some(fold),
            validation_every: 2,
        };
        config
            .split(&recording)
            .unwrap()
            .test
            .iter()
            .for_each(|k| tested[*k] += 1);
    }
    assert_eq!(tested, vec![1; 200]);
}

#[test]
fn impossible_splits_are_refused() {
    let one_run = recording(1, 50, 1);
    let runs = SplitConfig {
        unit: Unit::Runs,
        folds: 2,
        test_fold: Some(0),
        validation_every: 0,
    };
    assert!(
        runs.split(&one_run)
            .unwrap_err()
            .to_string()
            .contains("leaves none to learn from")
    );
    for wrong in [
        SplitConfig {
            unit: Unit::Stretch(0.0),
            ..runs
        },
        SplitConfig { folds: 0, ..runs },
        SplitConfig { folds: 1, ..runs },
        SplitConfig {
            test_fold: Some(2),
            ..runs
        },
        SplitConfig {
            validation_every: 1,
            ..runs
        },
    ] {
        assert!(wrong.check().unwrap_err().is_usage(), "{wrong:?}");
    }
    let unknown = serde_json::from_str::<SplitConfig>(r#"{"units": "10m"}"#);
    assert!(unknown.unwrap_err().to_string().contains("units"));
    let nonsense = serde_json::from_str::<SplitConfig>(r#"{"unit": "10 ft"}"#);
    assert!(nonsense.unwrap_err().to_string().contains("10 ft"));
}

#[test]
fn a_config_comes_back_as_it_was_written() {
    for unit in [Unit::Auto, Unit::Runs, Unit::Stretch(7.5)] {
        for test_fold in [None, Some(2)] {
            let config = SplitConfig {
                unit,
                test_fold,
                ..SplitConfig::default()
            };
            let text = serde_json::to_string(&config).unwrap();
            assert_eq!(
                serde_json::from_str::<SplitConfig>(&text).unwrap(),
                config,
                "{text}"
            );
        }
    }
}

#[test]
fn runs_of_equal_length_do_not_all_lose_the_same_piece() {
    let one = recording(3, 80, 1).into_columns();
    let four: Vec<usize> = (0..4).flat_map(|_| 0..80).collect();
    let mut columns = Recording::new(one)
        .unwrap()
        .select(&four)
        .unwrap()
        .into_columns();
    columns.run = (0..320).map(|k| k / 80).collect();
    let four_runs = Recording::new(columns).unwrap();
    let config = SplitConfig {
        unit: Unit::Stretch(5.0),
        folds: 4,
        test_fold: Some(3),
        validation_every: 3,
    };
    let split = config.split(&four_runs).unwrap();
    let pieces = |part: &[usize]| {
        part.iter()
            .map(|k| k % 80)
            .collect::<std::collections::BTreeSet<_>>()
            .len()
    };
    assert_eq!(
        pieces(&split.train),
        80,
        "every place is learned from in some run"
    );
    assert!(pieces(&split.test) > 70 && pieces(&split.validation) > 40);
}

#[test]
fn many_runs_stay_whole_by_themselves() {
    let config = SplitConfig {
        validation_every: 2,
        ..SplitConfig::default()
    };
    assert_eq!(
        config.split(&recording(1, 60, 6)).unwrap().validation,
        [10..20, 30..40, 50..60]
            .map(|r| r.collect::<Vec<_>>())
            .concat()
    );
    let one_run = recording(1, 60, 1); // about 30 m: stretches of 15 m
    assert_eq!(
        config.split(&one_run).unwrap().validation[0],
        one_run.travelled_m().partition_point(|d| *d < 15.0)
    );
}

#[test]
fn passes_are_runs_or_else_stretches() {
    let two = recording(2, 40, 2);
    let last = two.len() - 1;
    assert_eq!(passes(&two, &[0, 1, last]), [0, 0, 1]);
    let one = recording(1, 60, 1); // about 30 m
    let travelled_m = one.travelled_m();
    let all: Vec<usize> = (0..one.len()).collect();
    let passes = passes(&one, &all);
    assert!(passes.is_sorted() && passes[passes.len() - 1] >= 1);
    for (k, pass) in passes.iter().enumerate() {
        assert_eq!(*pass, (travelled_m[k] / AUTO_STRETCH_M) as usize);
    }
}
