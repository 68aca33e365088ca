//! How well a belief explains what is sensed that it has not seen.

use crate::localiser::lost::MOST;

/// How likely an observation was held to be, in nats, up to a constant that both share.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Explained {
    /// ln Σ_ξ Bel(ξ) P(z|ξ): by the belief without it.
    pub(super) by_belief: f64,
    /// The same by a robot that may be anywhere.
    pub(super) anywhere: f64,
}

/// What observations say of the belief: the short-term mean of their log-likelihood ratios.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct Prediction {
    observations: usize,
    mean: f64,
}

impl Prediction {
    /// Takes in an observation, with the weight `short`; the first ones count alike, as there is nothing before them.
    pub(super) fn observe(&mut self, explained: Explained, short: f64) {
        self.observations += 1;
        let ratio = (explained.by_belief - explained.anywhere).clamp(-MOST, MOST);
        let weight = short.max(1.0 / self.observations as f64);
        self.mean += weight * (ratio - self.mean);
    }

    /// In nats: above 0 where the belief predicts better than knowing nothing, below where it does worse; 0 before the first
    /// observation.
    pub(super) fn mean(&self) -> f64 {
        self.mean
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_mean_is_of_all_at_first_and_of_the_latest_then() {
        let mut prediction = Prediction::default();
        let mut see = |ratio: f64| {
            let explained = Explained {
                by_belief: ratio - 5.0,
                anywhere: -5.0,
            };
            prediction.observe(explained, 0.4);
            prediction.mean()
        };
        assert_eq!(see(1.0), 1.0);
        assert_eq!(see(3.0), 2.0);
        assert!((see(-1.0) - (2.0 + 0.4 * -3.0)).abs() < 1e-12);
        assert!((see(-1e9) - (0.8 + 0.4 * (-8.0 - 0.8))).abs() < 1e-12); // no proof alone
    }
}
