//! The constants of Monte Carlo localisation.

use super::MonteCarlo;
use crate::{
    belief::{Grid, GridConfig, OdometryMotion, Places},
    error::{Error, Result},
    localiser::{Localiser, LocaliserConfig},
    mapping::{
        LikelihoodField, LikelihoodFieldConfig, OccupancyMap, OccupancyMapConfig, RangeSensors,
        read_fitting,
    },
    recording::Recording,
    registry::Constants,
    seed::Seed,
};
use serde::{Deserialize, Serialize};
use std::{path::PathBuf, sync::Arc};

/// Power of a scan's evidence where nobody states or tunes it.
pub(super) const USUAL_SCALE: f64 = 0.2;

/// How many particles, how they are weighed, and when some are drawn anew.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct MonteCarloConfig {
    /// Most particles; as many are drawn while the robot may be anywhere.
    pub particles: usize,
    /// Fewest particles, however certain the robot is.
    pub least_particles: usize,
    /// ε: largest error, as a Kullback-Leibler divergence, of the particles' distribution over the occupied bins.
    pub kld_error: f64,
    /// Upper quantile of the standard normal distribution for the confidence that the error is kept: 2.33 for 99 %.
    pub kld_quantile: f64,
    /// Edge of a bin in which particles count as at the same place, in metres.
    pub kld_bin_m: f64,
    /// Width of such a bin in heading, in radians.
    pub kld_bin_rad: f64,
    /// α_slow: share of the last scan in the long average of how well scans fit; 0, like `fast_decay`, for no random particles.
    pub slow_decay: f64,
    /// α_fast: the same for the short average. Random particles are drawn while that is below the long one.
    pub fast_decay: f64,
    /// Roughening (Gordon, Salmond & Smith 1993): standard deviation of x and of y, in metres, that each particle is moved by when it is drawn anew;
    /// 0: copies are alike until the robot moves.
    pub roughening_m: f64,
    /// The same of the heading, in radians.
    pub roughening_rad: f64,
    /// Power that a scan's likelihood is taken to; not said: localisation trials tune it on whole sequences of the validation
    /// part, and elsewhere it is 0.2. At 1 all beams of all scans count as independent: the likelihood then has a
    /// peak so narrow that few particles are near enough to the truth to outlive a scan. Starting anywhere in the
    /// buildings of Freiburg and Intel (36 beams, no roughening), 40,000 particles find the robot in 73 and 97 of 100 trials with 1, in 100
    /// and 97 with 0.2, in 90 and 70 with 0.1; and 5,000 in 30 and 50 with 1, 67 and 57 with 0.2.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub evidence_scale: Option<f64>,
    /// Standard deviation of x and of y about a known start, in metres.
    pub start_spread_m: f64,
    /// Standard deviation of the heading about a known start, in radians.
    pub start_spread_rad: f64,
    /// File of a ROS map (its YAML) in the frame of the recording's poses; empty: the map that the mapping part's scans draw.
    pub map: PathBuf,
}

impl Default for MonteCarloConfig {
    fn default() -> Self {
        Self {
            particles: 5000,
            least_particles: 500,
            kld_error: 0.05,
            kld_quantile: 2.33,
            kld_bin_m: 0.5,
            kld_bin_rad: 10_f64.to_radians(),
            slow_decay: 0.001,
            fast_decay: 0.1,
            roughening_m: 0.05,
            roughening_rad: 2_f64.to_radians(),
            evidence_scale: None,
            start_spread_m: 0.3,
            start_spread_rad: 0.1,
            map: PathBuf::new(),
        }
    }
}

impl MonteCarloConfig {
    /// # Errors
    /// A usage error where a value makes no sense; the message names its key.
    pub fn check(&self) -> Result<()> {
        let wrong = |key: &str, value: String, expected: &str| {
            Err(Error::usage(format!(
                "monte_carlo.{key} = {value}: expected {expected}"
            )))
        };
        for (key, value) in [
            ("particles", self.particles),
            ("least_particles", self.least_particles),
        ] {
            if value == 0 {
                return wrong(key, "0".into(), "1 or more");
            }
        }
        if self.least_particles > self.particles {
            let expected = format!("at most {}, which is monte_carlo.particles", self.particles);
            return wrong(
                "least_particles",
                self.least_particles.to_string(),
                &expected,
            );
        }
        for (key, value) in [
            ("kld_error", self.kld_error),
            ("kld_quantile", self.kld_quantile),
            ("kld_bin_m", self.kld_bin_m),
            ("kld_bin_rad", self.kld_bin_rad),
            ("evidence_scale", self.evidence_scale.unwrap_or(USUAL_SCALE)),
            ("start_spread_m", self.start_spread_m),
            ("start_spread_rad", self.start_spread_rad),
        ] {
            if !(value.is_finite() && value > 0.0) {
                return wrong(key, value.to_string(), "a number above 0");
            }
        }
        for (key, value) in [
            ("roughening_m", self.roughening_m),
            ("roughening_rad", self.roughening_rad),
        ] {
            if !(value.is_finite() && value >= 0.0) {
                return wrong(key, value.to_string(), "a number from 0");
            }
        }
        for (key, value) in [
            ("slow_decay", self.slow_decay),
            ("fast_decay", self.fast_decay),
        ] {
            if !(0.0..=1.0).contains(&value) {
                return wrong(key, value.to_string(), "a share between 0 and 1");
            }
        }
        let no_random_particles = self.slow_decay == 0.0 && self.fast_decay == 0.0;
        if !(no_random_particles || (self.slow_decay > 0.0 && self.slow_decay < self.fast_decay)) {
            let expected = format!(
                "above 0 and below monte_carlo.fast_decay = {}, or both 0 for no random particles",
                self.fast_decay
            );
            return wrong("slow_decay", self.slow_decay.to_string(), &expected);
        }
        Ok(())
    }
}

impl Constants for MonteCarloConfig {
    fn kind(&self) -> &str {
        "monte_carlo"
    }

    fn description(&self) -> &str {
        "Monte Carlo localisation in an occupancy map of the mapping part's scans, as AMCL does it (Thrun, Burgard & Fox 2005)."
    }

    fn check(&self) -> Result<()> {
        MonteCarloConfig::check(self)
    }

    fn particles(&mut self) -> Option<&mut usize> {
        Some(&mut self.particles)
    }

    fn files(&mut self) -> Vec<&mut PathBuf> {
        vec![&mut self.map]
    }
}

impl LocaliserConfig for MonteCarloConfig {
    /// Particles keep to where the mapping part was, as the cells of a grid filter do. Nothing random is drawn yet.
    fn learn(
        &self,
        recording: &Recording,
        snapshots: &[usize],
        _: Seed,
    ) -> Result<Box<dyn Localiser>> {
        let map = match self.map.as_os_str().is_empty() {
            true => OccupancyMap::from_scans(recording, snapshots, &OccupancyMapConfig::default())?,
            false => read_fitting(&self.map, recording, snapshots, &RangeSensors::default())?,
        };
        let field = LikelihoodField::new(&map, &LikelihoodFieldConfig::default())?;
        let poses = snapshots.iter().map(|&k| recording.poses()[k]).collect();
        let grid = Grid::over(&Places::Plane(poses), &GridConfig::default())?;
        let motion = OdometryMotion::fitted(recording, snapshots);
        let localiser = MonteCarlo::new(Arc::new(field), motion, Arc::new(grid), self.clone())?;
        Ok(Box::new(localiser.with_sensors_of(recording.channels())?))
    }
}
