//! When a robot should doubt all that it believes: augmented Monte Carlo localisation (Thrun, Burgard & Fox, *Probabilistic
//! Robotics*, 2005, table 8.3).

/// How well scans fit to where the particles are, averaged over long and over short.
pub(super) struct Recovery {
    slow: Average,
    fast: Average,
}

/// Mean of all values so far, in which each weighs less by a constant factor than the next. Table 8.3 adds the values up
/// from 0 and so, with a small decay, stays near 0 for a thousand scans; here the zero that it began with is taken out.
#[derive(Clone, Copy)]
struct Average {
    decay: f64,
    sum: f64,
    weight: f64,
}

impl Average {
    fn new(decay: f64) -> Self {
        Self {
            decay,
            sum: 0.0,
            weight: 0.0,
        }
    }

    fn add(&mut self, value: f64) {
        self.sum += self.decay * (value - self.sum);
        self.weight += self.decay * (1.0 - self.weight);
    }

    /// None before the first value, and with a decay of 0.
    fn mean(&self) -> Option<f64> {
        (self.weight > 0.0).then(|| self.sum / self.weight)
    }
}

impl Recovery {
    pub(super) fn new(slow_decay: f64, fast_decay: f64) -> Self {
        Self {
            slow: Average::new(slow_decay),
            fast: Average::new(fast_decay),
        }
    }

    /// Takes in how well a scan fits (lines 9 to 11).
    pub(super) fn add(&mut self, fit: f64) {
        self.slow.add(fit);
        self.fast.add(fit);
    }

    /// max{0, 1 − w_fast / w_slow} (line 13): the share of particles to be drawn at random.
    pub(super) fn random_share(&self) -> f64 {
        match (self.fast.mean(), self.slow.mean()) {
            (Some(fast), Some(slow)) if slow > 0.0 => (1.0 - fast / slow).max(0.0),
            _ => 0.0,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn particles_are_random_while_scans_fit_worse_than_they_used_to() {
        let mut recovery = Recovery::new(0.001, 0.1);
        assert_eq!(recovery.random_share(), 0.0);
        for _ in 0..50 {
            recovery.add(0.8);
            assert!(recovery.random_share() < 1e-12);
        }
        // After 10 scans of half the fit, by hand: the fast mean, of weight 1 − 0.9⁶⁰, has come down by 0.9¹⁰ of the way.
        for _ in 0..10 {
            recovery.add(0.4);
        }
        let old = |decay: f64| {
            let keep = 1.0 - decay;
            keep.powi(10) * (1.0 - keep.powi(50)) / (1.0 - keep.powi(60))
        };
        let mean = |decay| 0.4 + 0.4 * old(decay);
        let expected = 1.0 - mean(0.1) / mean(0.001);
        assert!(expected > 0.2 && (recovery.random_share() - expected).abs() < 1e-12);
        for _ in 0..100 {
            recovery.add(0.8);
        }
        assert_eq!(recovery.random_share(), 0.0);
        let mut never = Recovery::new(0.0, 0.0);
        never.add(0.8);
        never.add(0.1);
        assert_eq!(never.random_share(), 0.0);
    }
}
