//! Where a channel's values point, as people write it.

use crate::error::{Error, Result};
use std::str::FromStr;

/// Directions of a channel's values, in degrees to the left of ahead.
///
/// ```
/// use ballmark::recording::bearings::Bearings;
/// assert_eq!("0,90,-90".parse::<Bearings>()?.of_width(3), Some(vec![0.0, 90.0, -90.0]));
/// assert_eq!("-90..90".parse::<Bearings>()?.of_width(5), Some(vec![-90.0, -45.0, 0.0, 45.0, 90.0]));
/// # Ok::<(), ballmark::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub enum Bearings {
    /// One number a value.
    Each(Vec<f64>),
    /// Evenly from the first to the last.
    Even([f64; 2]),
}

impl Bearings {
    /// Degrees of so many values; none where there is not one for each.
    pub fn of_width(&self, width: usize) -> Option<Vec<f64>> {
        match self {
            Self::Each(deg) => (deg.len() == width).then(|| deg.clone()),
            Self::Even([first, last]) => {
                let step = (last - first) / (width.max(2) - 1) as f64;
                Some((0..width).map(|k| first + step * k as f64).collect())
            }
        }
    }
}

impl FromStr for Bearings {
    type Err = Error;

    fn from_str(text: &str) -> Result<Self> {
        let number = |text: &str| text.trim().parse::<f64>().ok().filter(|n| n.is_finite());
        let bearings = match text.split_once("..") {
            Some((first, last)) => number(first)
                .zip(number(last))
                .map(|(first, last)| Self::Even([first, last])),
            None => text
                .split(',')
                .map(number)
                .collect::<Option<_>>()
                .map(Self::Each),
        };
        bearings.ok_or_else(|| {
            let shown: String = text.chars().take(40).collect();
            Error::usage(format!(
                "bearings `{}`: expected degrees, one a value separated by commas, or FIRST..LAST",
                shown.escape_debug()
            ))
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_no_bearing_is_refused() {
        for text in ["", "a", "0..", "0,,1", "nan", "1..inf"] {
            assert!(text.parse::<Bearings>().is_err(), "{text}");
        }
    }

    #[test]
    fn one_value_alone_points_where_the_first_does() {
        let even: Bearings = "30..90".parse().unwrap();
        assert_eq!(even.of_width(1), Some(vec![30.0]));
        let each: Bearings = "30".parse().unwrap();
        assert_eq!(
            (each.of_width(1), each.of_width(2)),
            (Some(vec![30.0]), None)
        );
    }
}
