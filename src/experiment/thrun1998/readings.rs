//! How many sensor readings one bit of information takes: T98 5.2.4.

use super::{CORRIDOR_M, global::Corridor};
use serde::{Deserialize, Serialize};

/// Readings and bits until the mean error is below 1 m. T98 counts the bits in two ways without saying so: its 6.48 is the logarithm of
/// the corridor's length, and its 5.4 that of the mean error before the first reading.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct ReadingsRecord {
    /// Until learned features leave a mean error below 1 m.
    pub readings: f64,
    /// log₂ of the corridor's length in metres.
    pub bits_of_length: f64,
    /// log₂ of the mean error in metres of a robot that has no idea where it is.
    pub bits_of_error: f64,
    /// Readings that a corridor of twice the length is predicted to take, one bit more by the first count.
    pub predicted_by_length: f64,
    /// And by the second, which is T98's.
    pub predicted_by_error: f64,
    /// What it does take; none where it was not tried, or the mean error is never below 1 m.
    pub found_in_doubled: Option<f64>,
}

/// None where the mean error is never below 1 m, or is at once.
pub(super) fn readings(corridor: &Corridor, prior_error_m: f64) -> Option<ReadingsRecord> {
    of(corridor.readings()?, prior_error_m)
}

fn of(readings: f64, prior_error_m: f64) -> Option<ReadingsRecord> {
    let (bits_of_length, bits_of_error) = (CORRIDOR_M.log2(), prior_error_m.log2());
    (bits_of_error > 0.0).then_some(ReadingsRecord {
        readings,
        bits_of_length,
        bits_of_error,
        predicted_by_length: readings + readings / bits_of_length,
        predicted_by_error: readings + readings / bits_of_error,
        found_in_doubled: None,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// T98: 19 readings, 89 m, a mean error of 42.2 m.
    #[test]
    fn the_papers_own_figures() {
        let paper = of(19.0, 42.2).unwrap();
        assert!((paper.bits_of_length - 6.48).abs() < 5e-3);
        assert!((paper.bits_of_error - 5.4).abs() < 5e-3);
        assert!((paper.readings / paper.bits_of_length - 2.93).abs() < 5e-3);
        assert!((paper.readings / paper.bits_of_error - 3.52).abs() < 5e-3);
        assert_eq!(paper.predicted_by_error.ceil(), 23.0);
        assert_eq!(paper.predicted_by_length.ceil(), 22.0);
    }
}
