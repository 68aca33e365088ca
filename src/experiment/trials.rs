//! Trials: stretches of unseen runs, each from some start, with a snapshot every half metre.

use crate::{
    error::{Error, Result},
    recording::Recording,
    seed::Seed,
};
use rand::RngExt;
use std::ops::Range;

/// One trial: the snapshots a robot takes in from its start on.
#[derive(Debug, Clone, PartialEq)]
pub struct Trial {
    /// Stretch of unseen snapshots that it runs in; trials of one stretch are no independent evidence.
    pub stretch: usize,
    /// What an interval resamples: the run, where the trials come from several, else the stretch.
    pub unit: usize,
    /// Indices in the recording.
    pub snapshots: Vec<usize>,
    /// Metres travelled from the start, one a snapshot.
    pub travelled_m: Vec<f64>,
}

/// How trials are drawn.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TrialSampling {
    /// Number of trials.
    pub count: usize,
    /// Metres between two snapshots; where the log is sparser, every one is taken.
    pub spacing_m: f64,
    /// A start leaves at least this much of its stretch.
    pub shortest_m: f64,
    /// A trial ends after this much.
    pub longest_m: f64,
}

/// Consecutive unseen snapshots of one run, from mapped place to mapped place: where there is no map, nobody can find
/// out where he is, and the trial would judge the map-maker's way instead of the localiser.
/// A way of up to `longest_gap_m` through unmapped places does not end a stretch.
pub fn stretches(
    recording: &Recording,
    unseen: &[usize],
    is_mapped: impl Fn(usize) -> bool,
    longest_gap_m: f64,
) -> Vec<Range<usize>> {
    let runs = recording.runs();
    let run_of = |k: usize| runs.partition_point(|run| run.end <= k);
    let travelled = recording.travelled_m();
    let mut stretches: Vec<Range<usize>> = Vec::new();
    let mut previous = None; // unseen snapshot before this one
    for &k in unseen {
        let unbroken = previous.is_some_and(|before| before + 1 == k);
        if is_mapped(k) {
            match stretches.last_mut() {
                Some(last)
                    if unbroken
                        && run_of(k) == run_of(last.start)
                        && travelled[k] - travelled[last.end - 1] <= longest_gap_m =>
                {
                    last.end = k + 1;
                }
                _ => stretches.push(k..k + 1),
            }
        }
        previous = Some(k);
    }
    stretches
}

/// Draws trials whose starts lie evenly over all snapshots that leave enough of their stretch.
///
/// # Errors
/// Where no stretch is long enough.
pub fn draw(
    recording: &Recording,
    stretches: &[Range<usize>],
    sampling: &TrialSampling,
    seed: Seed,
) -> Result<Vec<Trial>> {
    let travelled = recording.travelled_m();
    let length = |s: &Range<usize>| travelled[s.end - 1] - travelled[s.start];
    let starts: Vec<(usize, usize)> = stretches
        .iter()
        .enumerate()
        .flat_map(|(s, stretch)| stretch.clone().map(move |k| (s, k)))
        .filter(|&(s, k)| travelled[stretches[s].end - 1] - travelled[k] >= sampling.shortest_m)
        .collect();
    if starts.is_empty() {
        return Err(Error::work(format!(
            "no trial possible: the longest of {} unseen stretches through places seen in training is {:.1} m; expected \
             {} m (`shortest_m`), or a split with longer stretches (`unit` of the split)",
            stretches.len(),
            stretches.iter().map(length).fold(0.0, f64::max),
            sampling.shortest_m
        )));
    }
    let runs = recording.runs();
    let run_of = |k: usize| runs.partition_point(|run| run.end <= k);
    let several_runs = starts
        .iter()
        .any(|&(_, k)| run_of(k) != run_of(starts[0].1));
    let mut random = seed.stream("trial starts");
    let mut drawn: Vec<(usize, usize)> = (0..sampling.count)
        .map(|_| starts[random.random_range(0..starts.len())])
        .collect();
    drawn.sort_unstable();
    Ok(drawn
        .into_iter()
        .map(|(stretch, start)| {
            let mut trial = Trial {
                stretch,
                unit: if several_runs { run_of(start) } else { stretch },
                snapshots: vec![start],
                travelled_m: vec![0.0],
            };
            for k in start + 1..stretches[stretch].end {
                let distance = travelled[k] - travelled[start];
                let last = trial.travelled_m[trial.travelled_m.len() - 1];
                if distance > sampling.longest_m {
                    break;
                }
                // A thousandth of slack, or a log with a snapshot every 0.5 m would give one every metre.
                if distance - last >= sampling.spacing_m * 0.999 {
                    trial.snapshots.push(k);
                    trial.travelled_m.push(distance);
                }
            }
            trial
        })
        .collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        geometry::Pose,
        recording::{Channel, Columns},
    };

    /// Two runs of 40 snapshots, 0.25 m apart.
    fn recording() -> Recording {
        let pose: Vec<Pose> = (0..80)
            .map(|k| Pose::new((k % 40) as f64 * 0.25, 0.0, 0.0))
            .collect();
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
            values: ndarray::Array2::zeros((80, 1)),
            stamp_s: vec![0.0; 80],
            odometry: pose.clone(),
            pose,
            run: (0..80).map(|k| k / 40).collect(),
            ..Columns::default()
        })
        .unwrap()
    }

    #[test]
    fn a_stretch_ends_with_its_run_at_seen_snapshots_and_where_the_map_ends() {
        let unseen: Vec<usize> = (0..10).chain(15..60).collect();
        let all = stretches(&recording(), &unseen, |_| true, 1.0);
        assert_eq!(all, [0..10, 15..40, 40..60]);
        let hole = |from: usize, to: usize| {
            stretches(
                &recording(),
                &unseen,
                move |k| !(from..to).contains(&k),
                1.0,
            )
        };
        assert_eq!(hole(20, 23), [0..10, 15..40, 40..60]); // 19 to 23 is 1 m
        assert_eq!(hole(20, 24), [0..10, 15..20, 24..40, 40..60]);
    }

    #[test]
    fn trials_keep_their_spacing_and_their_length() {
        let sampling = TrialSampling {
            count: 50,
            spacing_m: 0.5,
            shortest_m: 4.0,
            longest_m: 5.0,
        };
        let drawn = draw(&recording(), &[0..40, 40..60], &sampling, Seed(1)).unwrap();
        assert_eq!(drawn.len(), 50);
        assert!(drawn.iter().any(|t| t.stretch == 1) && drawn.iter().any(|t| t.stretch == 0));
        for trial in &drawn {
            let end = trial.travelled_m[trial.travelled_m.len() - 1];
            assert!((3.99..=5.0).contains(&end), "{end}");
            assert!(
                trial
                    .travelled_m
                    .windows(2)
                    .all(|d| (d[1] - d[0] - 0.5).abs() < 1e-9)
            );
        }
        assert_eq!(
            drawn,
            draw(&recording(), &[0..40, 40..60], &sampling, Seed(1)).unwrap()
        );
        assert_ne!(
            drawn,
            draw(&recording(), &[0..40, 40..60], &sampling, Seed(2)).unwrap()
        );
        let short = draw(
            &recording(),
            std::slice::from_ref(&(0..10)),
            &sampling,
            Seed(1),
        )
        .unwrap_err()
        .to_string();
        assert!(
            short.contains("2.2 m") || short.contains("2.3 m"),
            "{short}"
        );
    }
}
