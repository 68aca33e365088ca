//! Sensors that are worse than the one that is simulated: fewer beams, a shorter reach, something mounted in the view.
//!
//! Networks that have learned with one sensor alone take every reading beyond another's reach for something that they know.

use crate::{
    detector::input::Input,
    error::{Error, Result},
    recording::Channel,
    seed::Stream,
};
use rand::RngExt;
use serde::{Deserialize, Serialize};

/// How much worse sensors are drawn.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct VariedSensorConfig {
    /// Share of the steps whose sensor reaches less far; what is beyond has no return, in scans taken and rendered alike.
    pub short: f64,
    /// Least reach in metres; it is drawn log-uniformly from here to the simulated sensor's.
    pub least_reach_m: f64,
    /// Share of the buildings that are seen by fewer beams, evenly chosen.
    pub thinned: f64,
    /// Fewest of them; their number is drawn log-uniformly from here.
    pub fewest_beams: usize,
    /// Share of the buildings that are seen past something mounted before a stretch of the beams.
    pub blocked: f64,
    /// Widest such stretch, as a share of the beams.
    pub widest_blocked: f64,
}

impl Default for VariedSensorConfig {
    fn default() -> Self {
        Self {
            short: 0.4,
            least_reach_m: 3.0,
            thinned: 0.4,
            fewest_beams: 8,
            blocked: 0.2,
            widest_blocked: 0.3,
        }
    }
}

impl VariedSensorConfig {
    /// # Errors
    /// A usage error where a value makes no sense; the message names its key.
    pub fn check(&self) -> Result<()> {
        let wrong = |key: &str, expected: &str| {
            Err(Error::usage(format!(
                "pretrain.sensors.{key}: expected {expected}"
            )))
        };
        let shares = [
            ("short", self.short, 1.0),
            ("thinned", self.thinned, 1.0),
            ("blocked", self.blocked, 1.0),
            ("widest_blocked", self.widest_blocked, 0.3), // two thirds of the sectors must be seen
        ];
        for (key, share, most) in shares {
            if !(0.0..=most).contains(&share) {
                return wrong(key, &format!("0 to {most}"));
            }
        }
        if !(self.least_reach_m.is_finite() && self.least_reach_m > 0.0) {
            return wrong("least_reach_m", "a positive number of metres");
        }
        if self.fewest_beams < 2 {
            return wrong("fewest_beams", "at least 2");
        }
        Ok(())
    }

    /// The inputs of a building, as a sensor sees it that has lost some of its beams.
    pub(super) fn worsened(
        &self,
        input: &Input,
        channels: &[Channel],
        random: &mut Stream,
    ) -> Input {
        let beams = channels.first().map_or(0, |channel| channel.width);
        let thinned = random.random_range(0.0..1.0) < self.thinned && self.fewest_beams < beams;
        let count = match thinned {
            true => log_uniform(self.fewest_beams as f64, beams as f64, random) as usize,
            false => beams,
        };
        let blocked = random.random_range(0.0..1.0) < self.blocked;
        let width = random.random_range(0.0..1.0) * self.widest_blocked * beams as f64;
        let from = random.random_range(0..beams.max(1));
        let to = from + if blocked { width as usize } else { 0 };
        let kept: Vec<usize> = (0..count)
            .map(|k| (2 * k + 1) * beams / (2 * count))
            .filter(|beam| !(from..to).contains(beam))
            .collect();
        match kept.len() == beams {
            true => input.clone(),
            false => input
                .of_beams(channels, &kept)
                .unwrap_or_else(|| input.clone()),
        }
    }

    /// How far a step's sensor reaches, where that is less far than the simulated one.
    pub(super) fn reach_m(&self, channels: &[Channel], random: &mut Stream) -> Option<f32> {
        let farthest_m = channels.first().and_then(|channel| channel.maximum)?;
        let short = random.random_range(0.0..1.0) < self.short && self.least_reach_m < farthest_m;
        let reach_m = log_uniform(
            self.least_reach_m,
            farthest_m.max(self.least_reach_m),
            random,
        );
        short.then_some(reach_m as f32)
    }
}

fn log_uniform(least: f64, most: f64, random: &mut Stream) -> f64 {
    let share: f64 = random.random_range(0.0..1.0);
    least * (most / least).powf(share)
}

#[cfg(test)]
mod tests;
