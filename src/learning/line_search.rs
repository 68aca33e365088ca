//! How far to go along a direction: the search that conjugate gradients need at every step.

use crate::error::Result;

/// A place counts as lower if the error there takes at least this share of what the slope at the start promises (Armijo's
/// condition).
const PROMISED: f64 = 0.1;
/// The search ends where it would change the length by less than this share.
const NEAR_ENOUGH: f64 = 0.2;
/// Most points tried.
const MAX_TRIES: usize = 10;
/// A length grows by at most this from one try to the next, and shrinks by at most its inverse.
const STRETCH: f64 = 10.0;

/// The length at which the error along a line is about lowest: each try goes to the bottom of the parabola that has the
/// error and the slope at the start and the error at the last try. `None` where no try is lower than the start.
///
/// `error` and `slope` (negative) are those at length 0, `first` the first length tried, `longest` the most that may be,
/// `error_at` the error at a length.
///
/// ```
/// use ballmark::learning::line_search::line_search;
/// let parabola = |x: f64| Ok((x - 3.0) * (x - 3.0));
/// let found = line_search(9.0, -6.0, 0.5, 10.0, parabola)?;
/// assert!((found.unwrap() - 3.0).abs() < 1e-12);
/// assert_eq!(line_search(0.0, -1.0, 1.0, 10.0, |x| Ok(x))?, None); // there is no way down
/// # Ok::<(), ballmark::Error>(())
/// ```
///
/// # Errors
/// Those of `error_at`.
pub fn line_search(
    error: f64,
    slope: f64,
    first: f64,
    longest: f64,
    mut error_at: impl FnMut(f64) -> Result<f64>,
) -> Result<Option<f64>> {
    let mut best: Option<(f64, f64)> = None; // length, error
    let mut length = first.min(longest);
    for _ in 0..MAX_TRIES {
        let here = error_at(length)?;
        let bend = here - error - slope * length;
        let bottom = match bend > 0.0 {
            true => -slope * length * length / (2.0 * bend),
            false => f64::INFINITY,
        };
        let lower = here <= error + PROMISED * slope * length; // false where it is no number
        if !lower {
            if best.is_some() {
                break;
            }
            length = match here.is_finite() {
                true => bottom.clamp(length / STRETCH, length / 2.0),
                false => length / STRETCH,
            };
            continue;
        }
        if best.is_some_and(|(_, least)| here >= least) {
            break;
        }
        best = Some((length, here));
        let next = bottom
            .clamp(length / STRETCH, length * STRETCH)
            .min(longest);
        if (next - length).abs() <= NEAR_ENOUGH * length {
            break;
        }
        length = next;
    }
    Ok(best.map(|(length, _)| length))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn finds_the_valley_from_near_and_far() {
        // Steep near the start, flat beyond: no parabola.
        let valley = |x: f64| (1.0 - x * (-x).exp() * std::f64::consts::E) + 0.01 * x;
        let slope = -std::f64::consts::E + 0.01;
        for first in [1e-4, 0.3, 1.0, 7.0, 100.0] {
            let mut tries = 0;
            let found = line_search(1.0, slope, first, 1000.0, |x| {
                tries += 1;
                Ok(valley(x))
            });
            let found = found.unwrap().unwrap();
            assert!(valley(found) < 0.2, "{first}: {found} {}", valley(found));
            assert!(tries <= 9, "{first}: {tries}");
        }
    }

    #[test]
    fn goes_no_farther_than_it_may() {
        let mut farthest: f64 = 0.0;
        let found = line_search(0.0, -1.0, 3.0, 2.5, |x| {
            farthest = farthest.max(x);
            Ok(-x)
        });
        assert_eq!((found.unwrap(), farthest), (Some(2.5), 2.5));
    }

    #[test]
    fn comes_back_from_where_the_error_is_no_number() {
        let cliff = |x: f64| match x > 2.0 {
            true => f64::NAN,
            false => (x - 1.0) * (x - 1.0),
        };
        let found = line_search(1.0, -2.0, 50.0, 1000.0, |x| Ok(cliff(x))).unwrap();
        assert!((found.unwrap() - 1.0).abs() < 0.3, "{found:?}");
    }
}
