//! How many responses a recogniser gives, and which of its constants changes that.
//!
//! D00 (Duckett & Nehmzow 2000), Experiments: "to enable a fair comparison between systems, the parameters for each of the
//! mechanisms were configured as closely as possible so that each system produced the same number of responses N_R". The
//! paper doesn't say which parameters. Each recogniser here has one that decides how finely it tells snapshots apart.

use super::Config;
use std::borrow::Cow;

/// The constant of a recogniser that is set for more or fewer responses, and the range that is tried.
///
/// ```
/// use ballmark::recogniser::{Kind, dial::Dial};
/// let mut config = Kind::Nearest.default_config();
/// let dial = Dial::of(&config, 16);
/// assert_eq!((&*dial.key, Dial::value(&config)), ("spacing_m", 1.5));
/// Dial::turn(&mut config, 2.5);
/// assert_eq!(Dial::value(&config), 2.5);
/// assert!(!dial.more_makes_more); // farther apart, fewer places
/// config.check()?;
/// # Ok::<(), ballmark::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Dial {
    /// Its key in configurations.
    pub key: Cow<'static, str>,
    /// The least and the greatest that is tried. Ours.
    pub range: [f64; 2],
    /// Is it a whole number?
    pub is_whole: bool,
    /// Is it tried in equal ratios, not in equal steps?
    pub by_ratio: bool,
    /// Does a greater value make more responses?
    pub more_makes_more: bool,
}

impl Dial {
    /// The dial of the recogniser with these constants, for about so many responses.
    pub fn of(config: &Config, responses: usize) -> Self {
        let (key, range, is_whole, by_ratio, more_makes_more) = match config {
            // From nearly every snapshot of a robot that stops each half metre to one for a whole hall.
            Config::Nearest(_) | Config::GridMatch(_) | Config::HistogramMatch(_) => {
                ("spacing_m", [0.25, 50.0], false, true, false)
            }
            // Unit vectors are at most 2 apart.
            Config::Rce(_) => ("radius", [0.001, 2.0], false, true, false),
            Config::Art2(_) => ("vigilance", [0.0, 1.0], false, false, true),
            // Not every cell is a test snapshot's nearest, nor does the test part show every pattern.
            Config::GrowingCells(_) => (
                "cells",
                [3.0, 8.0 * responses.max(3) as f64],
                true,
                true,
                true,
            ),
            Config::Ball(_) => (
                "most_patterns",
                [1.0, 64.0 * responses.max(1) as f64],
                true,
                true,
                true,
            ),
        };
        Self {
            key: key.into(),
            range,
            is_whole,
            by_ratio,
            more_makes_more,
        }
    }

    /// The constant's value; infinite where there is no bound.
    pub fn value(config: &Config) -> f64 {
        match config {
            Config::Nearest(c) => c.spacing_m,
            Config::GridMatch(c) => c.spacing_m,
            Config::HistogramMatch(c) => c.spacing_m,
            Config::Rce(c) => c.radius,
            Config::Art2(c) => c.vigilance,
            Config::GrowingCells(c) => c.cells as f64,
            Config::Ball(c) => c.most_patterns.map_or(f64::INFINITY, |most| most as f64),
        }
    }

    /// Sets the constant, to the nearest whole number where it is one.
    pub fn turn(config: &mut Config, to: f64) {
        match config {
            Config::Nearest(c) => c.spacing_m = to,
            Config::GridMatch(c) => c.spacing_m = to,
            Config::HistogramMatch(c) => c.spacing_m = to,
            Config::Rce(c) => c.radius = to,
            Config::Art2(c) => c.vigilance = to,
            Config::GrowingCells(c) => c.cells = to.round() as usize,
            Config::Ball(c) => c.most_patterns = Some(to.round() as usize),
        }
    }

    /// The value at a share of the range, from 0, fewest responses, to 1, most.
    pub fn at(&self, share: f64) -> f64 {
        let share = if self.more_makes_more {
            share
        } else {
            1.0 - share
        };
        let [least, most] = self.range;
        let value = match self.by_ratio {
            true => least * (most / least).powf(share),
            false => least + (most - least) * share,
        };
        // Rounding must not lead out of the range.
        let value = value.clamp(least, most);
        if self.is_whole { value.round() } else { value }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::recogniser::Kind;

    #[test]
    fn every_dial_turns_its_own_constant_and_stays_in_bounds() {
        for &kind in Kind::ALL {
            let mut config = kind.default_config();
            let dial = Dial::of(&config, 20);
            let mut before = f64::NAN;
            for share in [0.0, 0.3, 0.7, 1.0] {
                Dial::turn(&mut config, dial.at(share));
                let value = Dial::value(&config);
                assert_eq!(value, dial.at(share), "{kind}");
                assert!(value != before && (dial.range[0]..=dial.range[1]).contains(&value));
                before = value;
                let text = toml::to_string(&config).unwrap();
                assert!(text.contains(&format!("{} = ", dial.key)), "{text}");
                if kind != Kind::Ball {
                    config.check().unwrap();
                }
            }
        }
    }
}
