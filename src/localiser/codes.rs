//! Features as bits: what a robot with little memory keeps of a place, and how it compares a snapshot with all of them.
//!
//! Rounded, up to 64 features are 8 bytes. Where g and m are 0 or 1 but for a chance ε of being wrong, the mean-field
//! log-likelihood of a place is a constant less ln((1 − ε)/ε) for every bit in which its code differs, so counting those
//! bits is all that a query takes.

use crate::error::{Error, Result};
use ndarray::ArrayView2;

/// Most features in a code.
pub const MAX_FEATURES: usize = 64;

/// Probabilities `[place, feature]` rounded, bit i of a code for feature i; a half counts as seen.
///
/// ```
/// use ballmark::localiser::codes::{differing, packed};
/// let codes = packed(ndarray::array![[0.9, 0.2, 0.5], [0.1, 0.2, 0.8]].view())?;
/// assert_eq!(codes, [0b101, 0b100]);
/// assert_eq!(differing(0b100, &codes), [1, 0]);
/// # Ok::<(), ballmark::Error>(())
/// ```
///
/// # Errors
/// Where there are more than [`MAX_FEATURES`] features.
pub fn packed(probability: ArrayView2<f32>) -> Result<Vec<u64>> {
    let n = probability.ncols();
    if n > MAX_FEATURES {
        return Err(Error::work(format!(
            "a code of {n} features; expected up to {MAX_FEATURES}"
        )));
    }
    let pack = |bits: u64, (i, &g): (usize, &f32)| bits | u64::from(g >= 0.5) << i;
    let rows = probability.rows().into_iter();
    Ok(rows
        .map(|row| row.iter().enumerate().fold(0, pack))
        .collect())
}

/// Bits in which each place's code differs from that of a snapshot.
pub fn differing(snapshot: u64, places: &[u64]) -> Vec<u8> {
    // At most 64, so a byte holds it.
    let count = |place: &u64| (snapshot ^ place).count_ones() as u8;
    places.iter().map(count).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use ndarray::Array2;

    /// The log-likelihood of the wide evidence, with ε = 0.01, falls by the same amount a differing bit.
    #[test]
    fn differing_bits_are_the_mean_field_of_rounded_features() {
        let g = |k: usize, i: usize| f64::from((k * 37 + i * i * 11 + k * i) as u32 % 7 < 3);
        let probability = Array2::from_shape_fn((9, 64), |(k, i)| g(k, i) as f32);
        let codes = packed(probability.view()).unwrap();
        let log_likelihood = |a: usize, b: usize| -> f64 {
            let m = |i| g(b, i).clamp(0.01, 0.99);
            let one = |i: usize| g(a, i) * m(i).ln() + (1.0 - g(a, i)) * (1.0 - m(i)).ln();
            (0..64).map(one).sum()
        };
        for a in 0..9 {
            for (b, &bits) in differing(codes[a], &codes).iter().enumerate() {
                let expected = 64.0 * 0.99f64.ln() - f64::from(bits) * 99f64.ln();
                assert!((log_likelihood(a, b) - expected).abs() < 1e-9, "{a} {b}");
            }
        }
        assert!(packed(Array2::zeros((1, 65)).view()).is_err());
    }
}
