//! A robot that was carried away begins anew, a little: where sensors are explained worse than they used to be.

use crate::error::{Error, Result};
use serde::{Deserialize, Serialize};

/// How much of a belief is given up for knowing nothing: max(0, 1 − w_fast / w_slow), and no more than `most`.
///
/// w is the likelihood of an observation under the belief, w_slow and w_fast its long- and short-term averages (Thrun, Burgard &
/// Fox, *Probabilistic Robotics*, 2005, Table 8.3, augmented MCL). There it is the share of random particles; here, for a grid, the
/// share of mass that is spread over all cells before the next observation.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct RestartConfig {
    /// Weight of the newest observation in the long-term average: alpha_slow, above 0 and below `fast`.
    pub slow: f64,
    /// Its weight in the short-term average: alpha_fast, up to 1.
    pub fast: f64,
    /// Largest share of the belief that is given up between two observations, above 0 up to 1.
    pub most: f64,
}

impl Default for RestartConfig {
    /// Assumed, and not tuned (`docs/DESIGN.md`).
    fn default() -> Self {
        Self {
            slow: 0.1,
            fast: 0.5,
            most: 0.01,
        }
    }
}

impl RestartConfig {
    /// # Errors
    /// A usage error where a value makes no sense; the message names its key.
    pub fn check(&self) -> Result<()> {
        let Self { slow, fast, most } = *self;
        if !(slow > 0.0 && slow < fast && fast <= 1.0) {
            return Err(Error::usage(format!(
                "restart: `slow` is {slow} and `fast` {fast}; expected 0 < slow < fast ≤ 1"
            )));
        }
        if !(most > 0.0 && most <= 1.0) {
            return Err(Error::usage(format!(
                "restart: `most` is {most}; expected a share above 0 up to 1"
            )));
        }
        Ok(())
    }
}

/// The two averages of a robot at work.
///
/// ```
/// use ballmark::localiser::restart::{Restart, RestartConfig};
/// let mut restart = Restart::new(RestartConfig { slow: 0.1, fast: 0.5, most: 0.2 })?;
/// for _ in 0..20 {
///     assert_eq!(restart.after(-0.5), 0.0); // as usual
/// }
/// assert!(restart.after(-6.0) > 0.1);
/// assert_eq!(restart.after(-6.0), 0.2); // and no more
/// # Ok::<(), ballmark::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Restart {
    config: RestartConfig,
    averages: Option<(f64, f64)>,
}

impl Restart {
    /// # Errors
    /// As [`RestartConfig::check`].
    pub fn new(config: RestartConfig) -> Result<Self> {
        config.check()?;
        Ok(Self {
            config,
            averages: None,
        })
    }

    /// The share to give up after an observation with this ln P(z) under the belief. Its constant must be the same for all
    /// observations, as it is where evidence is scaled.
    pub fn after(&mut self, log_predictive: f64) -> f64 {
        let w = log_predictive.exp();
        let (slow, fast) = self.averages.unwrap_or((w, w));
        let slow = slow + self.config.slow * (w - slow);
        let fast = fast + self.config.fast * (w - fast);
        self.averages = Some((slow, fast));
        let share = if slow > 0.0 { 1.0 - fast / slow } else { 0.0 };
        match share.is_finite() && share > 1e-9 {
            true => share.min(self.config.most),
            false => 0.0,
        }
    }

    /// Forgets what was usual.
    pub fn forget(&mut self) {
        self.averages = None;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Table 8.3 by hand: w = 1, then 0.2 with alpha .1 and .5.
    #[test]
    fn shares_by_hand() {
        let config = RestartConfig {
            slow: 0.1,
            fast: 0.5,
            most: 1.0,
        };
        let mut restart = Restart::new(config).unwrap();
        assert_eq!(restart.after(0.0), 0.0);
        let share = restart.after(0.2f64.ln());
        assert!((share - (1.0 - 0.6 / 0.92)).abs() < 1e-12, "{share}");
        let share = restart.after(0.2f64.ln());
        assert!((share - (1.0 - 0.4 / 0.848)).abs() < 1e-12, "{share}");
        // As it was: after a while nothing is given up any more.
        assert!((restart.after(0.0) - (1.0 - 0.7 / 0.8632)).abs() < 1e-12);
        assert!(restart.after(0.0) > 0.0);
        assert_eq!(restart.after(0.0), 0.0);
        restart.forget();
        assert_eq!(restart.after(-900.0), 0.0); // whatever comes first is usual, and 0 / 0 is no share
        assert_eq!(restart.after(f64::NEG_INFINITY), 0.0);
    }

    #[test]
    fn senseless_constants_are_refused_by_name() {
        let refused = |slow: f64, fast: f64, most: f64, words: &str| {
            let fault = Restart::new(RestartConfig { slow, fast, most }).unwrap_err();
            assert!(
                fault.is_usage() && fault.to_string().contains(words),
                "{fault}"
            );
        };
        refused(0.5, 0.1, 0.1, "`slow` is 0.5");
        refused(0.0, 0.1, 0.1, "`slow` is 0");
        refused(0.1, 1.5, 0.1, "`fast` 1.5");
        refused(0.1, 0.5, 0.0, "`most` is 0");
        refused(0.1, 0.5, f64::NAN, "`most` is NaN");
        assert!(RestartConfig::default().check().is_ok());
    }
}
