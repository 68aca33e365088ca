//! The field once more, snapshot by snapshot, without an index.

use super::*;

/// The field by loops over all snapshots, as the formulas at the head of the module have it.
pub(super) struct BruteForce<'a> {
    readings: &'a LabelledReadings,
    config: &'a SignalFieldConfig,
    pub(super) mean: Vec<f64>,
    pub(super) deviation: Vec<f64>,
    pub(super) variance: Vec<f64>,
}

impl<'a> BruteForce<'a> {
    pub(super) fn new(readings: &'a LabelledReadings, config: &'a SignalFieldConfig) -> Self {
        let read = |value: usize| -> Vec<f64> {
            let column = readings.values.column(value);
            let finite = column.iter().filter(|v| v.is_finite());
            finite.map(|&v| f64::from(v)).collect()
        };
        let values = readings.values.ncols();
        let mean: Vec<f64> = (0..values)
            .map(|value| read(value).iter().sum::<f64>() / read(value).len().max(1) as f64)
            .collect();
        let deviation = (0..values)
            .map(|value| {
                let squares = read(value);
                let squares = squares.iter().map(|v| (v - mean[value]).powi(2));
                (squares.sum::<f64>() / read(value).len().max(1) as f64).sqrt()
            })
            .collect();
        let mut all = Self {
            readings,
            config,
            mean,
            deviation,
            variance: vec![1.0; values],
        };
        for value in 0..values {
            let mut squares = Vec::new();
            for k in 0..readings.len() {
                let others = |other: usize| {
                    let apart = readings.snapshot[k].abs_diff(readings.snapshot[other]);
                    readings.run[k] != readings.run[other] || apart >= config.pass_snapshots
                };
                let (mean, _) = all.mean_and_presence(&readings.places, k, value, others);
                let z = all.z(k, value);
                if let Some(mean) = mean.filter(|_| z.is_finite()) {
                    squares.push((z - mean).powi(2));
                }
            }
            if !squares.is_empty() {
                all.variance[value] = squares.iter().sum::<f64>() / squares.len() as f64 + 1e-4;
            }
        }
        all
    }

    fn z(&self, k: usize, value: usize) -> f64 {
        (f64::from(self.readings.values[[k, value]]) - self.mean[value]) / self.deviation[value]
    }

    pub(super) fn mean_and_presence(
        &self,
        places: &Places,
        place: usize,
        value: usize,
        counts: impl Fn(usize) -> bool,
    ) -> (Option<f64>, f64) {
        let (mut sum, mut there, mut all) = (0.0, 0.0, 0.0);
        for k in (0..self.readings.len()).filter(|&k| counts(k)) {
            let away = places.distance_m(place, &self.readings.places, k) / self.config.bandwidth_m;
            let turn = places.turn_rad(place, &self.readings.places, k);
            let turn = self.config.bandwidth_rad.map_or(0.0, |rad| turn / rad);
            let exponent = 0.5 * (away * away + turn * turn);
            if exponent > 4.5 {
                continue;
            }
            let weight = (-exponent).exp();
            all += weight;
            if self.z(k, value).is_finite() {
                there += weight;
                sum += weight * self.z(k, value);
            }
        }
        let snapshots = self.readings.len();
        let share = (0..snapshots)
            .filter(|&k| self.z(k, value).is_finite())
            .count() as f64;
        let presence = (there + 0.1 * share / snapshots as f64) / (all + 0.1);
        (
            (there > 0.0).then(|| sum / there),
            presence.clamp(1e-3, 1.0 - 1e-3),
        )
    }

    pub(super) fn log_likelihood(
        &self,
        places: &Places,
        place: usize,
        values: ArrayView1<f32>,
    ) -> f64 {
        let of_value = |value: usize| {
            let (mean, presence) = self.mean_and_presence(places, place, value, |_| true);
            let missing = (0..self.readings.len())
                .filter(|&k| self.z(k, value).is_nan())
                .count();
            let presence = if missing == 0 { None } else { Some(presence) };
            if missing == self.readings.len() {
                return 0.0;
            }
            let reading = f64::from(values[value]);
            if !reading.is_finite() {
                return presence.map_or(0.0, |p| (1.0 - p).ln());
            }
            let z = (reading - self.mean[value]) / self.deviation[value];
            let (off, variance) = match mean {
                Some(mean) => (z - mean, self.variance[value]),
                None => (z, 1.0),
            };
            let gaussian = (-0.5 * off * off / variance).exp() / (TAU * variance).sqrt();
            presence.map_or(0.0, f64::ln) + (0.95 * gaussian + 0.05 * 0.15).ln()
        };
        (0..values.len()).map(of_value).sum()
    }
}
