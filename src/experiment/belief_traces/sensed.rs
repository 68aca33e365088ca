//! What the robot sensed along the kept trials, for a look at them from within.

use super::record::{BeliefTraces, TracedTrial};
use crate::{
    detector::Detector,
    error::{Error, Result},
    recording::{Channel, Recording},
};
use ndarray::{ArrayView1, Axis};
use serde::Serialize;

/// What the robot sensed along one kept trial.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[non_exhaustive]
pub struct SensedTrial {
    /// The trial's number among all.
    pub number: usize,
    /// A scan a channel of ranges in known directions; none where the dataset has no such channel.
    pub scans: Vec<SensedScan>,
    /// P(f_i = 1 | s) of the features `[step][feature]`; empty where no networks were asked.
    pub features: Vec<Vec<f32>>,
}

/// What the beams of one channel met along one trial.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[non_exhaustive]
pub struct SensedScan {
    /// Name of the channel.
    pub channel: String,
    /// Of each step the beams that met something.
    pub beams: Vec<Vec<Beam>>,
}

/// A beam in the robot's frame: x ahead, y to the left, in metres.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Beam {
    /// Where its sensor sits.
    pub from: [f64; 2],
    /// What it met.
    pub to: [f64; 2],
}

impl BeliefTraces {
    /// What was sensed along the kept trials, in their order: scans, and what these networks make of each snapshot. `run` is the
    /// recording that the trials were played in.
    ///
    /// # Errors
    /// Where the traces don't say their snapshots (older ones), or `run` is not their recording as far as can be seen, or the networks
    /// don't know its sensors.
    pub fn sensed(
        &self,
        run: &Recording,
        networks: Option<&dyn Detector>,
    ) -> Result<Vec<SensedTrial>> {
        let of_trial = |trial: &TracedTrial| sensed(trial, run, networks);
        self.trials.iter().map(of_trial).collect()
    }
}

fn sensed(
    trial: &TracedTrial,
    run: &Recording,
    networks: Option<&dyn Detector>,
) -> Result<SensedTrial> {
    let snapshots = &trial.snapshots;
    let steps = trial.travelled_m.len();
    if snapshots.len() != steps || snapshots.iter().any(|&k| k >= run.len()) {
        return Err(Error::work(format!(
            "trial {}: its {steps} steps are not snapshots of this recording",
            trial.number
        )));
    }
    let mut scans = Vec::new();
    let mut first = 0;
    for channel in run.channels() {
        let columns = first..first + channel.width;
        first = columns.end;
        if !channel.is_scan() {
            continue;
        }
        let of_step = |&k: &usize| {
            let row = run.values().row(k);
            beams(
                channel,
                row.slice_axis(Axis(0), ndarray::Slice::from(columns.clone())),
            )
        };
        scans.push(SensedScan {
            channel: channel.name.clone(),
            beams: snapshots.iter().map(of_step).collect(),
        });
    }
    let features = match networks {
        None => Vec::new(),
        Some(networks) => {
            let values = run.values().select(Axis(0), snapshots);
            let answers = networks.detect_batch(run.channels(), values.view())?;
            answers.rows().into_iter().map(|row| row.to_vec()).collect()
        }
    };
    Ok(SensedTrial {
        number: trial.number,
        scans,
        features,
    })
}

/// The beams of a scan that met something.
fn beams(channel: &Channel, ranges_m: ArrayView1<f32>) -> Vec<Beam> {
    let bearing_rad = channel.bearing_rad.iter().flatten();
    let limit = channel.maximum.unwrap_or(f64::INFINITY);
    let of_value = |(value, (&range_m, &bearing)): (usize, (&f32, &f64))| {
        let range_m = f64::from(range_m);
        let met = range_m.is_finite() && range_m > 0.0 && range_m < limit;
        let at = |m: f64| [m * bearing.cos(), m * bearing.sin()];
        let offset_m = channel.offset_of(value);
        met.then(|| Beam {
            from: at(offset_m),
            to: at(offset_m + range_m),
        })
    };
    let values = ranges_m.iter().zip(bearing_rad).enumerate();
    values.filter_map(of_value).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{geometry::Pose, recording::Columns};
    use ndarray::{Array2, array};

    struct Halves;
    impl Detector for Halves {
        fn features(&self) -> usize {
            1
        }
        fn detect_batch(
            &self,
            _: &[Channel],
            values: ndarray::ArrayView2<f32>,
        ) -> Result<Array2<f32>> {
            Ok(values.slice_axis(Axis(1), (0..1).into()).mapv(|v| v / 2.0))
        }
    }

    fn traces(snapshots: &[usize]) -> BeliefTraces {
        serde_json::from_value(serde_json::json!({
            "is_route": true, "cell_m": 1.0, "cells": [[0.5]], "plan": null, "systems": [], "errors": [],
            "trials": [{ "number": 4, "kept_as": [], "snapshots": snapshots, "travelled_m": [0.0, 1.0],
                "truth": [[0.5], [0.5]], "systems": [] }],
        }))
        .unwrap()
    }

    #[test]
    fn beams_lie_at_their_bearings_from_where_their_sensors_sit_and_those_without_echo_are_left_out()
     {
        let light = Channel {
            name: "light".into(),
            width: 1,
            unit: "lux".into(),
            ..Channel::default()
        };
        let sonar = Channel {
            name: "sonar".into(),
            width: 4,
            unit: "m".into(),
            bearing_rad: Some(vec![
                0.0,
                std::f64::consts::FRAC_PI_2,
                std::f64::consts::PI,
                3.0,
            ]),
            maximum: Some(5.0),
            offset_m: Some(vec![0.25, 0.5, 0.0, 0.0]),
        };
        let nan = f32::NAN;
        let run = Recording::new(Columns {
            channels: vec![light, sonar],
            values: array![
                [0.5, 9.0, 9.0, 9.0, 9.0],
                [0.25, 1.0, 2.0, nan, 5.0],
                [1.0, nan, nan, 4.0, nan]
            ],
            stamp_s: vec![0.0, 1.0, 2.0],
            pose: vec![Pose::default(); 3],
            odometry: vec![Pose::default(); 3],
            run: vec![0; 3],
            ..Columns::default()
        })
        .unwrap();
        let kept = traces(&[1, 2]);
        assert_eq!(kept.check(), Ok(()));
        let sensed = kept.sensed(&run, Some(&Halves)).unwrap();
        let [trial] = &sensed[..] else {
            panic!("one trial")
        };
        assert_eq!(trial.number, 4);
        assert_eq!(trial.features, [[0.125], [0.5]]);
        let [scan] = &trial.scans[..] else {
            panic!("one scan: light is none")
        };
        assert_eq!(scan.channel, "sonar");
        let near = |a: [f64; 2], b: [f64; 2]| (a[0] - b[0]).hypot(a[1] - b[1]) < 1e-9;
        let [ahead, left] = scan.beams[0][..] else {
            panic!("{scan:?}")
        };
        assert!(near(ahead.from, [0.25, 0.0]) && near(ahead.to, [1.25, 0.0]));
        assert!(near(left.from, [0.0, 0.5]) && near(left.to, [0.0, 2.5]));
        assert!(scan.beams[1].len() == 1 && near(scan.beams[1][0].to, [-4.0, 0.0]));
        let none = kept.sensed(&run, None).unwrap();
        assert!(none[0].features.is_empty());
        // Of another recording, or of an older file that doesn't say.
        for wrong in [traces(&[1, 3]), traces(&[])] {
            let error = wrong.sensed(&run, None).unwrap_err().to_string();
            assert!(error.contains("trial 4"), "{error}");
        }
    }
}
