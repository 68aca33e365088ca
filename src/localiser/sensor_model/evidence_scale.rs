//! How much a sensor model's evidence counts: snapshots of one place are not independent of each other, nor are the readings
//! of one snapshot, so their product is too sure by a factor that only whole sequences show.

use super::PreparedSensorModel;
use crate::{belief::Belief, error::Result, seed::Stream};
use serde::{Deserialize, Serialize};

/// P(z | ξ) as a filter is given it: (1 − u) · (P / P_best)^scale + u, of the likelihood P that a sensor model finds.
///
/// ```
/// use ballmark::localiser::sensor_model::EvidenceScale;
/// let half = EvidenceScale { scale: 0.5, unmodelled: 0.0 };
/// let mut log_likelihood = vec![-3.0, -7.0];
/// half.apply(&mut log_likelihood);
/// assert_eq!(log_likelihood, [0.0, -2.0]);
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct EvidenceScale {
    /// Power of the likelihood: 1 takes it at its word.
    pub scale: f64,
    /// Likelihood, as a share of the best place's, of what the model does not know: no snapshot can rule a place out further
    /// than to this.
    pub unmodelled: f64,
}

/// Share of likelihood that no sensor model explains: people, doors, a wheel that slipped.
pub const UNMODELLED: f64 = 1e-4;

impl EvidenceScale {
    /// A power with the usual share of the unmodelled.
    pub fn of(scale: f64) -> Self {
        Self {
            scale,
            unmodelled: UNMODELLED,
        }
    }

    /// Scales ln P(z | ξ), `[cell]`; the best is 0 afterwards.
    pub fn apply(&self, log_likelihood: &mut [f64]) {
        let best = log_likelihood
            .iter()
            .copied()
            .fold(f64::NEG_INFINITY, f64::max);
        if !best.is_finite() {
            return;
        }
        // Where the power alone is far above the floor, the floor would be lost in rounding.
        let near = (1.0 - self.unmodelled).ln();
        let far = self.unmodelled.ln();
        for l in log_likelihood {
            let scaled = self.scale * (*l - best);
            *l = if self.unmodelled == 0.0 {
                scaled
            } else if scaled < far - 40.0 {
                far
            } else {
                near + (scaled.exp() + self.unmodelled / (1.0 - self.unmodelled)).ln()
            };
        }
    }
}

/// A prepared sensor model whose evidence is scaled.
pub struct Scaled<'a> {
    model: &'a dyn PreparedSensorModel,
    scale: EvidenceScale,
}

impl<'a> Scaled<'a> {
    /// `model`, scaled.
    pub fn new(model: &'a dyn PreparedSensorModel, scale: EvidenceScale) -> Self {
        Self { model, scale }
    }
}

impl PreparedSensorModel for Scaled<'_> {
    fn log_likelihood(
        &self,
        snapshot: usize,
        belief: &Belief,
        stream: &mut Stream,
    ) -> Result<Vec<f64>> {
        let mut l = self.model.log_likelihood(snapshot, belief, stream)?;
        self.scale.apply(&mut l);
        Ok(l)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nothing_is_ruled_out_further_than_to_the_unmodelled() {
        let mut l = vec![10.0, 8.0, -500.0, f64::NEG_INFINITY];
        EvidenceScale::of(0.5).apply(&mut l);
        let p: Vec<f64> = l.iter().map(|l| l.exp()).collect();
        assert!((p[0] - 1.0).abs() < 1e-12);
        assert!((p[1] - ((1.0 - UNMODELLED) * (-1.0_f64).exp() + UNMODELLED)).abs() < 1e-12);
        assert!((p[2] - UNMODELLED).abs() < 1e-12 && (p[3] - UNMODELLED).abs() < 1e-12);
    }

    #[test]
    fn what_says_nothing_still_says_nothing() {
        let mut flat = vec![-3.0; 4];
        EvidenceScale::of(0.25).apply(&mut flat);
        assert!(flat.iter().all(|l| l.abs() < 1e-12));
    }
}
