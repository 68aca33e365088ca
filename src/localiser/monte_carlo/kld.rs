//! How many particles are enough: KLD sampling (Thrun, Burgard & Fox, *Probabilistic Robotics*, 2005, table 8.4).

use super::MonteCarloConfig;
use crate::geometry::Pose;
use foldhash::fast::FixedState;
use std::{collections::HashSet, f64::consts::TAU};

/// Bins of x, y and heading that some particles fall into.
pub(super) struct Bins<'a> {
    config: &'a MonteCarloConfig,
    occupied: HashSet<[i64; 3], FixedState>,
    enough: usize,
}

impl<'a> Bins<'a> {
    pub(super) fn new(config: &'a MonteCarloConfig) -> Self {
        Self {
            config,
            occupied: HashSet::default(),
            enough: config.least_particles,
        }
    }

    /// Counts a particle in.
    pub(super) fn add(&mut self, pose: &Pose) {
        let bin = |value: f64, width: f64| (value / width).floor() as i64;
        let [x, y] = [pose.x_m, pose.y_m].map(|v| bin(v, self.config.kld_bin_m));
        let heading = bin(pose.heading_rad.rem_euclid(TAU), self.config.kld_bin_rad);
        if self.occupied.insert([x, y, heading]) {
            let MonteCarloConfig {
                least_particles,
                particles,
                kld_error,
                kld_quantile,
                ..
            } = *self.config;
            let wanted = particles_for(self.occupied.len(), kld_error, kld_quantile).ceil();
            self.enough = (wanted as usize).clamp(least_particles, particles);
        }
    }

    /// As many particles as the bins that are occupied so far ask for.
    pub(super) fn enough(&self) -> usize {
        self.enough
    }
}

/// M_χ (table 8.4, line 15): so many particles that, with the confidence of the normal quantile, the divergence of their
/// distribution over so many bins from the true one is at most `error`. Half of a quantile of the χ² distribution of
/// bins − 1 degrees of freedom over the error, by the approximation of Wilson and Hilferty.
fn particles_for(bins: usize, error: f64, quantile: f64) -> f64 {
    if bins < 2 {
        return 0.0;
    }
    let freedom = (bins - 1) as f64;
    let spread = 2.0 / (9.0 * freedom);
    freedom / (2.0 * error) * (1.0 - spread + spread.sqrt() * quantile).powi(3)
}

#[cfg(test)]
mod tests {
    use super::*;
    use statrs::distribution::{ChiSquared, ContinuousCDF};

    #[test]
    fn the_number_is_a_quantile_of_chi_squared() {
        for bins in [2, 3, 10, 100, 5000] {
            let exact = ChiSquared::new((bins - 1) as f64).unwrap();
            let exact = exact.inverse_cdf(0.99) / (2.0 * 0.05);
            let found = particles_for(bins, 0.05, 2.326_347_874);
            assert!(
                (found / exact - 1.0).abs() < 0.02,
                "{bins}: {found}, {exact}"
            );
        }
    }

    #[test]
    fn particles_of_one_bin_ask_for_the_fewest_and_scattered_ones_for_more() {
        let config = MonteCarloConfig {
            least_particles: 10,
            particles: 700,
            ..MonteCarloConfig::default()
        };
        let mut bins = Bins::new(&config);
        for _ in 0..100 {
            bins.add(&Pose::new(0.1, 0.1, 0.05));
            // Just short of a whole turn is another bin of heading than just past it.
            assert_eq!(bins.enough(), 10);
        }
        bins.add(&Pose::new(0.1, 0.1, -0.05));
        assert!((60..80).contains(&bins.enough()), "{}", bins.enough());
        for k in 0..1000 {
            bins.add(&Pose::new(f64::from(k), 0.0, 0.0));
        }
        assert_eq!(bins.enough(), 700);
    }
}
