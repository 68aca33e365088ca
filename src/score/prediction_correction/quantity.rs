//! Lengths and angles as users write them: `0.1m,1deg`.

use crate::error::{Error, Result};
use serde::Serialize;
use std::str::FromStr;

/// A length and an angle, either of which may be unstated; written `0.1m,1deg`, in `m`, `cm`, `mm`, `deg`, `rad`.
///
/// ```
/// use ballmark::score::prediction_correction::PositionHeading;
/// let step: PositionHeading = "10cm,10deg".parse()?;
/// assert_eq!((step.position_m, step.heading_deg), (Some(0.1), Some(10.0)));
/// assert_eq!("5deg".parse::<PositionHeading>()?.position_m, None);
/// assert!("10".parse::<PositionHeading>().unwrap_err().is_usage());
/// # Ok::<(), ballmark::Error>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize)]
pub struct PositionHeading {
    /// Metres, from 0 on.
    pub position_m: Option<f64>,
    /// Degrees, from 0 on.
    pub heading_deg: Option<f64>,
}

/// Where intervals of the prior error end: lengths and angles from 0 on, rising, written `0.1m,0.2m,0.4m,5deg,10deg`.
///
/// ```
/// use ballmark::score::prediction_correction::Edges;
/// let edges: Edges = "10cm,0.2m,5deg".parse()?;
/// assert_eq!((edges.position_m, edges.heading_deg), (vec![0.1, 0.2], vec![5.0]));
/// assert!("0.2m,0.1m".parse::<Edges>().is_err());
/// # Ok::<(), ballmark::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq, Default, Serialize)]
pub struct Edges {
    /// Metres; none: quartiles of what there is.
    pub position_m: Vec<f64>,
    /// Degrees; none: quartiles of what there is.
    pub heading_deg: Vec<f64>,
}

enum Quantity {
    Metres(f64),
    Degrees(f64),
}

fn quantity(text: &str) -> Result<Quantity> {
    let trimmed = text.trim();
    let at = trimmed.find(|c: char| c.is_ascii_alphabetic() && c != 'e');
    let (number, unit) = trimmed.split_at(at.unwrap_or(trimmed.len()));
    let wrong = || {
        let shown: String = trimmed.chars().take(24).collect();
        Error::usage(format!(
            "`{}`: expected a length or an angle from 0 on, such as 0.1m, 10cm, 1deg or 0.02rad",
            shown.escape_debug()
        ))
    };
    let value: f64 = number.trim().parse().map_err(|_| wrong())?;
    if !(value.is_finite() && value >= 0.0) {
        return Err(wrong());
    }
    match unit {
        "m" => Ok(Quantity::Metres(value)),
        "cm" => Ok(Quantity::Metres(value / 100.0)),
        "mm" => Ok(Quantity::Metres(value / 1000.0)),
        "deg" => Ok(Quantity::Degrees(value)),
        "rad" => Ok(Quantity::Degrees(value.to_degrees())),
        _ => Err(wrong()),
    }
}

impl FromStr for PositionHeading {
    type Err = Error;

    fn from_str(text: &str) -> Result<Self> {
        let mut of = Self::default();
        for part in text.split(',') {
            let (slot, value, what) = match quantity(part)? {
                Quantity::Metres(value) => (&mut of.position_m, value, "lengths"),
                Quantity::Degrees(value) => (&mut of.heading_deg, value, "angles"),
            };
            if slot.replace(value).is_some() {
                return Err(Error::usage(format!("two {what}; expected one")));
            }
        }
        Ok(of)
    }
}

impl FromStr for Edges {
    type Err = Error;

    fn from_str(text: &str) -> Result<Self> {
        let mut edges = Self::default();
        for part in text.split(',') {
            let (list, value) = match quantity(part)? {
                Quantity::Metres(value) => (&mut edges.position_m, value),
                Quantity::Degrees(value) => (&mut edges.heading_deg, value),
            };
            if list.last().is_some_and(|&last| value <= last) || value == 0.0 {
                return Err(Error::usage(format!(
                    "intervals end at {value} behind {}; expected rising numbers above 0",
                    list.last().unwrap_or(&0.0)
                )));
            }
            list.push(value);
        }
        Ok(edges)
    }
}
