//! What a camera sees of a surface: its colour, its texture, and the light that comes out of it.

use serde::{Deserialize, Serialize};

/// The look of a matt surface.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Look {
    /// Share of red, green and blue light that it throws back, each in [0, 1].
    pub colour: [f64; 3],
    /// How much its brightness varies from spot to spot: relative standard deviation, in [0, 1].
    pub contrast: f64,
    /// Size of its spots, metres.
    pub grain_m: f64,
    /// Red, green and blue light that comes out of it besides, at full daylight, where a white surface in full light
    /// is 1: a window.
    pub daylight: [f64; 3],
}

impl Look {
    /// Off-white and even.
    pub const PLAIN: Self = Self {
        colour: [0.8, 0.78, 0.74],
        contrast: 0.03,
        grain_m: 0.05,
        daylight: [0.0; 3],
    };

    /// What is out of bounds, if anything.
    pub(super) fn check(&self) -> Result<(), String> {
        let shares = self.colour.iter().chain([&self.contrast]);
        if let Some(share) = shares.copied().find(|share| !(0.0..=1.0).contains(share)) {
            return Err(format!("colour or contrast of {share}; expected 0 to 1"));
        }
        if !(self.grain_m > 0.0 && self.grain_m.is_finite()) {
            return Err(format!("grain of {} m; expected more than 0", self.grain_m));
        }
        match self
            .daylight
            .iter()
            .find(|light| !(**light >= 0.0 && light.is_finite()))
        {
            Some(light) => Err(format!("daylight of {light}; expected 0 or more")),
            None => Ok(()),
        }
    }
}

impl Default for Look {
    fn default() -> Self {
        Self::PLAIN
    }
}
