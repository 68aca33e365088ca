//! What a detector answers to some snapshots of a recording.

use crate::{detector::Detector, error::Result, recording::Recording};
use ndarray::{Array2, ArrayView1, Axis};
use std::sync::Arc;

/// P(f_i = 1 | s) of some snapshots of a recording: those that will be asked about, which of a long one are few.
///
/// ```
/// use ballmark::localiser::sensor_model::DetectorAnswers;
/// let answered = DetectorAnswers::new(vec![3, 7], ndarray::array![[0.2], [0.9]]);
/// assert_eq!(answered.of_snapshot(7).unwrap()[0], 0.9);
/// assert!(answered.of_snapshot(5).is_none());
/// ```
#[derive(Debug, Clone)]
pub struct DetectorAnswers {
    /// Ascending.
    snapshots: Arc<[usize]>,
    /// `[snapshot, feature]`
    probabilities: Arc<Array2<f32>>,
}

impl DetectorAnswers {
    /// The answers `[snapshot, feature]` to these snapshots, in rising order.
    ///
    /// # Panics
    /// Where there is not one row a snapshot.
    pub fn new(snapshots: Vec<usize>, probabilities: Array2<f32>) -> Self {
        assert_eq!(snapshots.len(), probabilities.nrows(), "one row a snapshot");
        Self {
            snapshots: snapshots.into(),
            probabilities: Arc::new(probabilities),
        }
    }

    /// What a detector answers to these snapshots, in any order.
    ///
    /// # Errors
    /// Where the recording lacks the detector's sensors.
    pub fn of(detector: &dyn Detector, recording: &Recording, snapshots: &[usize]) -> Result<Self> {
        let mut snapshots = snapshots.to_vec();
        snapshots.sort_unstable();
        snapshots.dedup();
        let probabilities = match snapshots.is_empty() {
            true => Array2::zeros((0, detector.features())),
            false => detector.probabilities(&recording.select(&snapshots)?)?,
        };
        Ok(Self::new(snapshots, probabilities))
    }

    /// The answers to a snapshot, if it is one of these.
    pub fn of_snapshot(&self, snapshot: usize) -> Option<ArrayView1<'_, f32>> {
        let row = self.snapshots.binary_search(&snapshot).ok()?;
        Some(self.probabilities.row(row))
    }

    /// The answers to several, `[snapshot, feature]`; none where one of them was not asked about.
    pub fn select(&self, snapshots: &[usize]) -> Option<Array2<f32>> {
        let rows = snapshots
            .iter()
            .map(|k| self.snapshots.binary_search(k).ok());
        let rows: Vec<usize> = rows.collect::<Option<_>>()?;
        Some(self.probabilities.select(Axis(0), &rows))
    }

    /// The same with other answers.
    pub fn mapped(&self, of: impl FnMut(f32) -> f32) -> Self {
        Self {
            snapshots: Arc::clone(&self.snapshots),
            probabilities: Arc::new(self.probabilities.mapv(of)),
        }
    }

    /// Number of features.
    pub fn features(&self) -> usize {
        self.probabilities.ncols()
    }
}
