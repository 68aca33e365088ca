//! How localisation trials are played, as a configuration's section `[localise]` says it.

use crate::{
    belief::{Evidence, GridConfig, OdometryMotion},
    detector::MOST_VIEWS,
    error::Result,
    localiser::{RestartConfig, sensor_model::BankChoice},
    seed::Seed,
    toml_file::out_of_range,
};
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};

/// The seed where nobody names one.
const FIRST_SEED: u64 = 1;

/// Most trials.
const MOST_TRIALS: usize = 100_000;

/// Most resamples of a bootstrap.
const MOST_RESAMPLES: usize = 1_000_000;

/// Most times as many particles.
const MOST_TIMES: usize = 1000;

/// How trials are played.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct LocaliseConfig {
    /// The one seed of the run: starts, random planes, sampled features, bootstrap. Not said: 1, or in a comparison its own.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub seed: Option<u64>,
    /// Number of trials, their starts drawn evenly over the unseen stretches.
    pub trials: usize,
    /// Metres between two snapshots (Thrun 1998, 5.2.4).
    pub spacing_m: f64,
    /// A start leaves at least this much of its stretch.
    pub shortest_m: f64,
    /// A trial ends after this much.
    pub longest_m: f64,
    /// A stretch ends where its way leads for more than this through places that training never saw.
    pub longest_gap_m: f64,
    /// How answers become likelihoods.
    pub evidence: Evidence,
    /// From so many places beside each snapshot, up to 64, learned features are looked for again, and their answers averaged; where
    /// scans can be drawn anew. Helps where the sensor sees what the map shows, and costs as many times the answer.
    pub query_views: usize,
    /// Which sets of a bank of filters speak at every step.
    pub bank: BankChoice,
    /// Cells of the belief.
    pub grid: GridConfig,
    /// What the filter believes of odometry; nothing said: what the model learned of it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub motion: Option<OdometryMotion>,
    /// Position tracking starts with this standard deviation around the truth …
    pub start_spread_m: f64,
    /// … and this one in heading.
    pub start_spread_rad: f64,
    /// Resamples of the bootstrap.
    pub resamples: usize,
    /// File of a ROS map (its YAML) in the frame of the recording's poses, for filters that localise in a map; empty: it is
    /// drawn by the scans that the models learned from. A comparison's `monte_carlo` has a key of its own.
    pub map: PathBuf,
    /// Share of the range beams of every unseen snapshot that people are in the way of, 0 to 1: stretches of 3° to 20° that end
    /// before what they met. What was learned from, and what evidence is tuned on, stays as it was. Not said: as `[degraded]` says,
    /// else nobody.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub people: Option<f64>,
    /// Systems of a comparison that say how many particles they have (`particles`) play once more with so many times as many, and the table says
    /// whether that changes their figures. 0: they don't. `ballmark localise` plays 5,000 and 40,000 of its own and says so always.
    pub more_particles: usize,
    /// Every filter plays trials once more and is carried to another place without a word after this many metres from its start.
    /// Not said: nobody is.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub kidnap_m: Option<f64>,
    /// How much of a belief is given up where sensors are explained worse than they used to be: for all filters, in all trials. Not
    /// said: nothing, and the usual constants where robots are carried away.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub restart: Option<RestartConfig>,
}

impl Default for LocaliseConfig {
    fn default() -> Self {
        Self {
            seed: None,
            trials: 60,
            spacing_m: 0.5,
            shortest_m: 5.0,
            longest_m: 30.0,
            longest_gap_m: 3.0,
            evidence: Evidence::MeanField,
            query_views: 0,
            bank: BankChoice::default(),
            grid: GridConfig::default(),
            motion: None,
            start_spread_m: 0.3,
            start_spread_rad: 0.1,
            resamples: 1000,
            map: PathBuf::new(),
            people: None,
            more_particles: 0,
            kidnap_m: None,
            restart: None,
        }
    }
}

impl LocaliseConfig {
    /// The seed of the run.
    pub fn seed(&self) -> Seed {
        Seed(self.seed.unwrap_or(FIRST_SEED))
    }

    /// The share of beams behind people.
    pub fn people(&self) -> f64 {
        self.people.unwrap_or(0.0)
    }

    /// The same with the file that it names looked for in that folder.
    pub fn beside(mut self, folder: &Path) -> Self {
        if !self.map.as_os_str().is_empty() {
            self.map = folder.join(&self.map);
        }
        self
    }

    /// # Errors
    /// Where a value makes no sense; the message names the key and the value.
    pub fn check(&self) -> Result<()> {
        let wrong = |key: &str, expected: &str| Err(out_of_range("localise", self, key, expected));
        let positive = |v: f64| v.is_finite() && v > 0.0;
        for (key, value, most) in [
            ("trials", self.trials, MOST_TRIALS),
            ("resamples", self.resamples, MOST_RESAMPLES),
        ] {
            if !(1..=most).contains(&value) {
                return wrong(key, &format!("1 to {most}"));
            }
        }
        self.bank.check().map_err(|e| e.context("localise"))?;
        if self.query_views > MOST_VIEWS {
            let expected = format!("at most {MOST_VIEWS}");
            return wrong("query_views", &expected);
        }
        if !positive(self.shortest_m) {
            return wrong("shortest_m", "metres above 0");
        }
        if !(self.longest_m.is_finite() && self.longest_m >= self.shortest_m) {
            let expected = format!("metres, localise.shortest_m = {} or more", self.shortest_m);
            return wrong("longest_m", &expected);
        }
        if !(self.spacing_m >= 0.01 && self.spacing_m <= self.shortest_m) {
            let expected = format!("0.01 m to localise.shortest_m = {}", self.shortest_m);
            return wrong("spacing_m", &expected);
        }
        if !(self.longest_gap_m.is_finite() && self.longest_gap_m >= 0.0) {
            return wrong("longest_gap_m", "0 or more metres");
        }
        if !(0.0..=1.0).contains(&self.people()) {
            let expected = "the share of beams that they hide, 0 to 1";
            return wrong("people", expected);
        }
        if self.more_particles == 1 || self.more_particles > MOST_TIMES {
            let expected = format!("0 for no more, or 2 to {MOST_TIMES} times as many");
            return wrong("more_particles", &expected);
        }
        if self.kidnap_m.is_some_and(|m| !positive(m)) {
            return wrong("kidnap_m", "metres above 0");
        }
        if let Some(restart) = &self.restart {
            restart.check().map_err(|e| e.context("localise"))?;
        }
        for (key, value) in [
            ("start_spread_m", self.start_spread_m),
            ("start_spread_rad", self.start_spread_rad),
        ] {
            if !positive(value) {
                return wrong(key, "a positive number");
            }
        }
        Ok(())
    }
}
