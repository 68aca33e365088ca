//! What is known of one value whatever the place: its mean, how far it varies, and how often it is there.

/// A reading whose deviation is less than this share of its mean never varied: it is divided by 1.
const SMALLEST_VARIATION: f64 = 1e-6;

/// What is known of one value whatever the place.
#[derive(Debug, Clone)]
pub(super) struct ReadingModel {
    pub(super) mean: f64,
    /// Of all readings, never 0.
    pub(super) deviation: f64,
    /// Share of the snapshots that have it.
    pub(super) presence: f64,
    pub(super) is_ever_missing: bool,
    /// σ_i², in squared deviations.
    pub(super) variance: f64,
    /// u.
    pub(super) outliers: f64,
}

impl ReadingModel {
    /// Of a value as the snapshots have it, `[snapshot]`, and the share u of outliers; σ_i² is yet that of all readings.
    pub(super) fn of(column: &[f32], outliers: f64) -> Self {
        let is_there = column.iter().filter(|value| value.is_finite());
        let read: Vec<f64> = is_there.map(|&value| f64::from(value)).collect();
        let count = read.len().max(1) as f64;
        let mean = read.iter().sum::<f64>() / count;
        let deviation = (read.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / count).sqrt();
        let varies = deviation > SMALLEST_VARIATION * mean.abs();
        Self {
            mean,
            deviation: if varies { deviation } else { 1.0 },
            presence: read.len() as f64 / column.len().max(1) as f64,
            is_ever_missing: read.len() < column.len(),
            variance: 1.0,
            outliers,
        }
    }

    /// A reading in deviations from the mean.
    pub(super) fn standardised(&self, reading: f32) -> f32 {
        ((f64::from(reading) - self.mean) / self.deviation) as f32
    }
}
