use super::*;
use crate::{
    experiment::protocol::{Mapping, ProtocolConfig},
    geometry::Pose,
    recording::{
        Channel, Columns, Recording,
        split::{SplitConfig, Unit},
    },
    seed::Stream,
};

/// So many metres round a rectangle of 12 m × 5 m, a snapshot a second and a quarter of a metre.
fn rounds(metres: f64) -> Recording {
    let at = |m: f64| match m % 34.0 {
        m if m < 12.0 => Pose::new(m, 0.0, 0.0),
        m if m < 17.0 => Pose::new(12.0, m - 12.0, 0.0),
        m if m < 29.0 => Pose::new(29.0 - m, 5.0, 0.0),
        m => Pose::new(0.0, 34.0 - m, 0.0),
    };
    let count = (metres * 4.0) as usize + 1;
    let pose: Vec<Pose> = (0..count).map(|k| at(k as f64 * 0.25)).collect();
    let channel = Channel {
        name: "light".into(),
        width: 1,
        unit: "lux".into(),
        bearing_rad: None,
        maximum: None,
        offset_m: None,
    };
    Recording::new(Columns {
        channels: vec![channel],
        values: ndarray::Array2::zeros((count, 1)),
        stamp_s: (0..count).map(|k| k as f64).collect(),
        odometry: pose.clone(),
        pose,
        run: vec![0; count],
        ..Columns::default()
    })
    .unwrap()
}

/// Says whatever the test wants it to, from the place in the trial and the snapshot.
struct Scripted<F> {
    blind: bool,
    script: F,
}

impl<F: Fn(usize, usize) -> Option<Estimate> + Send + Sync> Localiser for Scripted<F> {
    fn name(&self) -> &'static str {
        "scripted"
    }
    fn places(&self) -> usize {
        0
    }
    fn bytes_per_place(&self) -> usize {
        0
    }
    fn is_blind(&self) -> bool {
        self.blind
    }
    fn check_channels(&self, _: &[Channel]) -> Result<()> {
        Ok(())
    }
    fn prepare<'a>(&'a self, _: &'a Recording, _: &[usize]) -> Result<Box<dyn TrialRunner + 'a>> {
        Ok(Box::new(Reader(&self.script)))
    }
}

struct Reader<'a, F>(&'a F);

impl<F: Fn(usize, usize) -> Option<Estimate> + Sync> TrialRunner for Reader<'_, F> {
    fn play(&self, trial: &[usize], start: Option<Pose>, _: &mut Stream) -> Result<Vec<Step>> {
        assert_eq!(start, None); // it does not ask for it
        // Whoever names a place is three quarters sure of it.
        let step = |(step, &k): (usize, &usize)| {
            let estimate = (self.0)(step, k);
            let posterior = match estimate {
                Some(Estimate::Place([x, y])) => vec![([x, y], 0.75), ([x + 70.0, y], 0.25)],
                _ => Vec::new(),
            };
            Step {
                estimate,
                posterior,
                ..Step::default()
            }
        };
        Ok(trial.iter().enumerate().map(step).collect())
    }
}

fn judged(
    recording: &Recording,
    blind: bool,
    script: impl Fn(&Protocol, &Binning, usize, usize) -> Option<Estimate> + Send + Sync,
) -> StandardRecord {
    let protocol = Protocol::new(recording, &ProtocolConfig::default()).unwrap();
    let binning = protocol.binning(2.0).unwrap();
    let script = |step: usize, k: usize| script(&protocol, &binning, step, k);
    let config = StandardConfig {
        permutations: 99,
        resamples: 99,
        ..StandardConfig::default()
    };
    play(
        &protocol,
        &binning,
        &Scripted { blind, script },
        &config,
        Seed(1),
    )
    .unwrap()
}

#[test]
fn who_knows_scores_one_and_who_is_silent_nothing() {
    let recording = rounds(4.0 * 34.0);
    let renamed = judged(&recording, false, |protocol, binning, _, k| {
        let bin = binning.bin_of(protocol.place[k])?;
        Some(Estimate::Class(100 - bin))
    });
    assert_eq!(renamed.mean_uncertainty_coefficient, 1.0);
    assert_eq!(renamed.mean_entropy_of_location_given_response, 0.0);
    assert_eq!(renamed.distance_at_coefficient_m, Some(0.0));
    assert_eq!((renamed.by_distance.len(), renamed.units), (201, 2));
    assert_eq!(renamed.responses, renamed.bins);
    assert_eq!(renamed.at_end.permutation_p, Some(0.01));
    assert_eq!(renamed.ci95_of_mean, Some([1.0, 1.0]));
    let placed = judged(&recording, true, |protocol, _, _, k| {
        Some(Estimate::Place(protocol.place[k]))
    });
    assert_eq!(placed.mean_uncertainty_coefficient, 1.0);
    // ln .75 of what there is to know is missing, but for the 1 % of prior.
    let missing = -0.75_f64.ln() / placed.entropy_of_location;
    let soft = placed.mean_posterior_coefficient.unwrap();
    assert!((1.0 - soft - missing).abs() < 0.01, "{soft} {missing}");
    assert_eq!(renamed.mean_posterior_coefficient, None);

    let silent = judged(&recording, false, |_, _, _, _| None);
    assert_eq!(silent.mean_uncertainty_coefficient, 0.0);
    assert_eq!((silent.unanswered, silent.outside), (1.0, 0.0));
    assert_eq!(
        (silent.responses, silent.distance_at_coefficient_m),
        (1, None)
    );
    assert!(
        (silent.mean_entropy_of_location_given_response - silent.entropy_of_location).abs() < 1e-12
    );
}

/// Known from step 20 (5 m) to step 40, and from step 60 (15 m) on.
#[test]
fn the_first_distance_and_that_from_which_on_are_told_apart() {
    let record = judged(&rounds(4.0 * 34.0), false, |protocol, _, step, k| {
        ((20..40).contains(&step) || step >= 60).then_some(Estimate::Place(protocol.place[k]))
    });
    let close = |found: Option<f64>, m: f64| (found.unwrap() - m).abs() < 1e-9;
    assert!(close(record.distance_at_coefficient_m, 5.0));
    assert!(close(record.distance_from_coefficient_on_m, 15.0));
    assert_eq!(record.by_distance[49].uncertainty_coefficient, Some(0.0));
    assert_eq!(record.by_distance[50].uncertainty_coefficient, Some(1.0));
    // 40 of the 81 snapshots of a trial are answered; 50 + 50 of the 201 tables aren't, and 20 m itself is.
    assert!(
        (record.unanswered - 100.0 / 201.0).abs() < 1e-9,
        "{}",
        record.unanswered
    );
}

#[test]
fn outside_is_an_answer_and_the_blind_stay_there() {
    let strays = |protocol: &Protocol, _: &Binning, step: usize, k: usize| {
        let [x, y] = protocol.place[k];
        Some(Estimate::Place(if step == 4 {
            [x, y + 500.0]
        } else {
            [x, y]
        }))
    };
    let recording = rounds(4.0 * 34.0);
    let looking = judged(&recording, false, strays);
    assert_eq!(looking.by_distance[10].uncertainty_coefficient, Some(0.0));
    assert_eq!(looking.by_distance[200].uncertainty_coefficient, Some(1.0));
    let blind = judged(&recording, true, strays);
    assert_eq!(blind.by_distance[9].uncertainty_coefficient, Some(1.0));
    assert_eq!(blind.by_distance[200].uncertainty_coefficient, Some(0.0));
    assert!((blind.outside - 191.0 / 201.0).abs() < 1e-9);
    assert_eq!(blind.responses, blind.bins + 1);
}

#[test]
fn trials_start_everywhere_alike_and_last_as_long_as_they_must() {
    let recording = rounds(4.7 * 34.0);
    let protocol = Protocol::new(&recording, &ProtocolConfig::default()).unwrap();
    let (trials, notes) = trials(&protocol, &StandardConfig::default()).unwrap();
    assert!(notes.is_empty(), "{notes:?}");
    // Three laps of 34 m, a start every 1.25 m.
    assert!((81..=83).contains(&trials.len()), "{}", trials.len());
    for trial in &trials {
        assert_eq!(trial.snapshots.len(), 81);
        assert_eq!((trial.step_at[0], trial.step_at[200]), (0, 80));
        // After 0.5 m the third snapshot, after 0.7 m still the third.
        assert_eq!(
            (trial.step_at[5], trial.step_at[7], trial.step_at[8]),
            (2, 2, 3)
        );
    }
    let starts: Vec<usize> = trials.iter().map(|trial| trial.snapshots[0]).collect();
    assert!(starts.windows(2).all(|pair| pair[1] - pair[0] == 5));
    let in_lap = |lap: usize| trials.iter().filter(|trial| trial.unit == lap).count();
    assert!((1..=3).all(|lap| (26..=28).contains(&in_lap(lap))));
}

#[test]
fn two_laps_have_trials_for_a_part_and_less_is_told() {
    let recording = rounds(2.0 * 34.0);
    let protocol = Protocol::new(&recording, &ProtocolConfig::default()).unwrap();
    let (some, notes) = trials(&protocol, &StandardConfig::default()).unwrap();
    assert!((11..=12).contains(&some.len()), "{}", some.len());
    assert!(notes[0].contains("41 %"), "{notes:?}");
    // Longer than the route, where the robot goes round it often enough: no matter.
    let recording = rounds(4.0 * 34.0);
    let protocol = Protocol::new(&recording, &ProtocolConfig::default()).unwrap();
    let trials_of = |trial_m: f64| {
        let config = StandardConfig {
            trial_m,
            ..StandardConfig::default()
        };
        trials(&protocol, &config)
    };
    assert!(
        trials_of(60.0)
            .unwrap()
            .0
            .iter()
            .all(|trial| trial.snapshots.len() == 241)
    );
    let error = trials_of(150.0).unwrap_err().to_string();
    assert!(error.contains("150 m") && error.contains("102."), "{error}");
}

#[test]
fn stretches_that_are_too_short_are_left_out() {
    let recording = rounds(110.0);
    let protocol = |metres: f64| {
        let config = ProtocolConfig {
            mapping: Mapping::Split,
            split: SplitConfig {
                unit: Unit::Stretch(metres),
                folds: 2,
                test_fold: Some(0),
                validation_every: 0,
            },
            ..ProtocolConfig::default()
        };
        Protocol::new(&recording, &config).unwrap()
    };
    // Tested on: 0 to 30 m, 60 to 90 m.
    let stretches = protocol(30.0);
    let (played, _) = trials(&stretches, &StandardConfig::default()).unwrap();
    let units: Vec<usize> = played.iter().map(|trial| trial.unit).collect();
    assert!(units.contains(&0) && units.contains(&2) && units.iter().all(|u| u % 2 == 0));
    for trial in &played {
        let unit = |k: &usize| stretches.unit[*k] == trial.unit;
        assert!(trial.snapshots.iter().all(unit));
    }
    let error = trials(&protocol(12.0), &StandardConfig::default()).unwrap_err();
    assert!(
        error
            .to_string()
            .contains("longest part to be tested on is 11."),
        "{error}"
    );
}

#[test]
fn threads_change_nothing_and_neither_does_a_file() {
    let recording = rounds(4.0 * 34.0);
    let on = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
        let half = |protocol: &Protocol, _: &Binning, step: usize, k: usize| {
            (k % 3 < step % 5).then_some(Estimate::Place(protocol.place[k]))
        };
        pool.build()
            .unwrap()
            .install(|| judged(&recording, false, half))
    };
    let record = on(1);
    assert_eq!(record, on(3));
    let json = serde_json::to_string(&record).unwrap();
    assert_eq!(
        serde_json::from_str::<StandardRecord>(&json).unwrap(),
        record
    );
}

#[test]
fn constants_and_bins_that_make_no_sense_are_named() {
    for (config, key) in [
        ("bin_m = 0.0", "standard.bin_m"),
        ("trial_m = inf", "standard.trial_m"),
        ("every_s = -1.0", "standard.every_s"),
        ("step_m = 0.001", "standard.step_m"),
        (
            "coefficient_to_reach = 1.1",
            "standard.coefficient_to_reach",
        ),
        ("permutations = 2000000", "standard.permutations"),
    ] {
        let config: StandardConfig = toml::from_str(config).unwrap();
        let error = config.check().unwrap_err();
        assert!(
            error.is_usage() && error.to_string().starts_with(key),
            "{error}"
        );
    }
    assert!(toml::from_str::<StandardConfig>("bins_m = 2.0").is_err());
    let recording = rounds(2.0 * 34.0);
    let protocol = Protocol::new(&recording, &ProtocolConfig::default()).unwrap();
    let error = protocol.binning(40.0).unwrap_err().to_string();
    assert!(error.contains("one bin of 40 m"), "{error}");
}
