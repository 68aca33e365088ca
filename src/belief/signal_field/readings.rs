//! What a signal field is learned from: readings, each with its place and when it was taken.

use crate::{
    belief::Places,
    error::{Error, Result},
    recording::{Channel, Recording},
};
use ndarray::{Array2, Axis};

/// The readings of some snapshots, where they were taken, and in what order.
#[derive(Debug, Clone)]
pub struct LabelledReadings {
    /// The sensors, in order; their widths add up to the columns of `values`.
    pub channels: Vec<Channel>,
    /// As recorded, `[snapshot, value]`; what is not finite is missing.
    pub values: Array2<f32>,
    /// One a snapshot.
    pub places: Places,
    /// Run of each snapshot.
    pub run: Vec<i64>,
    /// Position of each snapshot in its recording.
    pub snapshot: Vec<usize>,
}

impl LabelledReadings {
    /// Of some snapshots of a recording, the channels of these names; none named: all of them.
    ///
    /// # Errors
    /// Where the recording lacks a channel.
    pub fn of(recording: &Recording, snapshots: &[usize], channels: &[String]) -> Result<Self> {
        let mut columns = Vec::new();
        let mut kept = Vec::new();
        let mut from = 0;
        for channel in recording.channels() {
            if channels.is_empty() || channels.contains(&channel.name) {
                columns.extend(from..from + channel.width);
                kept.push(channel.clone());
            }
            from += channel.width;
        }
        if let Some(missing) = channels
            .iter()
            .find(|name| kept.iter().all(|channel| channel.name != **name))
        {
            let names: Vec<&str> = recording
                .channels()
                .iter()
                .map(|c| c.name.as_str())
                .collect();
            return Err(Error::work(format!(
                "signal field: the recording has no channel `{missing}`; expected one of {}",
                names.join(", ")
            )));
        }
        let values = recording.values().select(Axis(0), snapshots);
        let run = &recording.columns().run;
        Ok(Self {
            channels: kept,
            values: values.select(Axis(1), &columns),
            places: Places::of(recording).select(snapshots),
            run: snapshots.iter().map(|&k| run[k]).collect(),
            snapshot: snapshots.to_vec(),
        })
    }

    /// Number of snapshots.
    pub fn len(&self) -> usize {
        self.values.nrows()
    }

    /// Is there no snapshot at all?
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Do the parts fit one another?
    ///
    /// # Errors
    /// Where their lengths differ, there is no value, no snapshot, or a place that is not finite.
    pub(super) fn check(&self) -> Result<()> {
        let wrong = |fault: String| Err(Error::work(format!("signal field: {fault}")));
        let (snapshots, values) = self.values.dim();
        if snapshots == 0 {
            return wrong("no training snapshot; expected at least one".into());
        }
        let width: usize = self.channels.iter().map(|channel| channel.width).sum();
        if width != values || values == 0 {
            return wrong(format!(
                "{values} values a snapshot; expected {width}, those of its channels, and at least one"
            ));
        }
        for (name, length) in [
            ("places", self.places.len()),
            ("runs", self.run.len()),
            ("snapshot numbers", self.snapshot.len()),
        ] {
            if length != snapshots {
                return wrong(format!(
                    "{length} {name}; expected {snapshots}, one a snapshot"
                ));
            }
        }
        check_finite(&self.places)
    }

    /// At most so many snapshots, evenly spaced.
    pub(super) fn evenly(&self, most: usize) -> Self {
        let step = self.len().div_ceil(most).max(1);
        let kept: Vec<usize> = (0..self.len()).step_by(step).collect();
        Self {
            channels: self.channels.clone(),
            values: self.values.select(Axis(0), &kept),
            places: self.places.select(&kept),
            run: kept.iter().map(|&k| self.run[k]).collect(),
            snapshot: kept.iter().map(|&k| self.snapshot[k]).collect(),
        }
    }

    /// Were two snapshots taken in one pass: in the same run, fewer than so many snapshots apart?
    pub(super) fn is_one_pass(&self, a: usize, b: usize, pass_snapshots: usize) -> bool {
        let apart = self.snapshot[a].abs_diff(self.snapshot[b]);
        self.run[a] == self.run[b] && apart < pass_snapshots
    }
}

/// # Errors
/// Where a place is not finite; the message says which.
pub(super) fn check_finite(places: &Places) -> Result<()> {
    let bad = (0..places.len()).find(|&k| !places.pose(k).is_finite());
    match bad {
        Some(k) => Err(Error::work(format!(
            "signal field: place {k} is {:?}; expected finite numbers",
            places.pose(k)
        ))),
        None => Ok(()),
    }
}
