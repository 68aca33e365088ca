//! How uncertain the robot is before it senses: the prior that filters are trained for.

use super::places::Places;
use crate::error::{Error, Result};
use serde::{Deserialize, Serialize};
use std::{fmt, str::FromStr};

/// Heading window of a plain `2m` in the plane, in radians.
pub const DEFAULT_HALF_TURN_RAD: f64 = 0.5;

/// Prior uncertainty Bel_prior: uniform over the places within a window centred on the truth, or over all places
/// (Thrun 1998, 5.1.7).
///
/// Written `2m` (within ±2 m and, in the plane, ±0.5 rad of heading), `2m,0.3rad`, `2m,any` (any heading) or `global`.
///
/// ```
/// use ballmark::belief::Uncertainty;
/// let window: Uncertainty = "2m,0.3rad".parse()?;
/// assert_eq!(window, Uncertainty::Window { half_width_m: 2.0, half_turn_rad: Some(0.3) });
/// assert_eq!(window.to_string(), "2m,0.3rad");
/// assert!("0m".parse::<Uncertainty>().unwrap_err().is_usage());
/// # Ok::<(), ballmark::Error>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "String", into = "String")]
pub enum Uncertainty {
    /// Every place and every heading.
    Global,
    /// Places around the truth; clipped where the places end.
    Window {
        /// Places no farther than this from the truth, in metres.
        half_width_m: f64,
        /// Headings no farther than this from the true one, in radians; `None`: any heading.
        half_turn_rad: Option<f64>,
    },
}

impl Uncertainty {
    /// The priors of a bank of filters, those of Thrun (1998, 5.1.7): ±1, 2, 5, 10 and 50 m, and no idea at all.
    pub fn of_a_bank() -> [Uncertainty; 6] {
        let window = |half_width_m| Uncertainty::Window {
            half_width_m,
            half_turn_rad: Some(DEFAULT_HALF_TURN_RAD),
        };
        [
            window(1.0),
            window(2.0),
            window(5.0),
            window(10.0),
            window(50.0),
            Uncertainty::Global,
        ]
    }

    /// Does the prior of a robot at `truth` give place `other_index` any mass?
    ///
    /// |ξ_j − ξ_i| ≤ w, which is symmetric under rounding.
    pub fn admits(
        &self,
        places: &Places,
        truth: usize,
        other: &Places,
        other_index: usize,
    ) -> bool {
        self.admits_at(places.distance_m(truth, other, other_index), || {
            places.turn_rad(truth, other, other_index)
        })
    }

    /// The same for a place so far from the truth, turned by so much: the turn is asked for only where it matters.
    pub fn admits_at(&self, distance_m: f64, turn_rad: impl FnOnce() -> f64) -> bool {
        match *self {
            Uncertainty::Global => true,
            Uncertainty::Window {
                half_width_m,
                half_turn_rad,
            } => distance_m <= half_width_m && half_turn_rad.is_none_or(|w| turn_rad() <= w),
        }
    }
}

impl FromStr for Uncertainty {
    type Err = Error;

    fn from_str(text: &str) -> Result<Self> {
        let wrong = || {
            Error::usage(format!(
                "uncertainty `{text}`: expected `global`, or metres with an optional heading window such as `2m`, `2m,0.3rad` or `2m,any`"
            ))
        };
        let positive = |number: Option<&str>| {
            number
                .and_then(|n| n.trim().parse::<f64>().ok())
                .filter(|v| v.is_finite() && *v > 0.0)
                .ok_or_else(wrong)
        };
        if text.trim() == "global" {
            return Ok(Uncertainty::Global);
        }
        let mut parts = text.split(',').map(str::trim);
        let half_width_m = positive(parts.next().and_then(|p| p.strip_suffix('m')))?;
        let half_turn_rad = match parts.next() {
            None => Some(DEFAULT_HALF_TURN_RAD),
            Some("any") => None,
            Some(turn) => Some(positive(turn.strip_suffix("rad"))?),
        };
        if parts.next().is_some() {
            return Err(wrong());
        }
        Ok(Uncertainty::Window {
            half_width_m,
            half_turn_rad,
        })
    }
}

impl TryFrom<String> for Uncertainty {
    type Error = Error;

    fn try_from(text: String) -> Result<Self> {
        text.parse()
    }
}

impl From<Uncertainty> for String {
    fn from(uncertainty: Uncertainty) -> Self {
        uncertainty.to_string()
    }
}

impl fmt::Display for Uncertainty {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Uncertainty::Global => write!(f, "global"),
            Uncertainty::Window {
                half_width_m,
                half_turn_rad,
            } => {
                write!(f, "{half_width_m}m")?;
                match half_turn_rad {
                    Some(DEFAULT_HALF_TURN_RAD) => Ok(()),
                    Some(turn) => write!(f, ",{turn}rad"),
                    None => write!(f, ",any"),
                }
            }
        }
    }
}
