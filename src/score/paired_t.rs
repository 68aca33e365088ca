//! Is one system better than another, over the same environments? Student's t-test for paired samples.

use serde::{Deserialize, Serialize};
use statrs::function::beta::checked_beta_reg;

/// Student's t-test for paired samples (Press et al. 1992, 14.2, as used by Duckett & Nehmzow, *Performance comparison of
/// landmark recognition systems*, Table 3): the null hypothesis is that the mean of the differences is 0.
///
/// With differences d_i = a_i − b_i, their mean d̄ and their standard deviation s (of n − 1), t = d̄ / (s/√n), and
/// p = I_x(ν/2, 1/2) with x = ν/(ν + t²), the regularised incomplete beta function: both tails beyond |t|.
///
/// The test assumes that the differences are normal and independent, and says nothing of how large they are. Who compares
/// many pairs of systems will find some p small by chance: see [`holm`](super::holm).
///
/// ```
/// use ballmark::score::PairedT;
/// // Duckett & Nehmzow's Table 2: growing cell structures and nearest neighbour in four environments.
/// let test = PairedT::of(&[0.719, 0.770, 0.502, 0.340], &[0.650, 0.715, 0.551, 0.350]).unwrap();
/// assert_eq!(test.degrees_of_freedom, 3);
/// assert!((test.t - 0.5859).abs() < 1e-4);
/// assert!((test.p - 0.599).abs() < 1e-3); // printed as 0.60: no difference to speak of
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct PairedT {
    /// Above 0 where the first system's values are the greater.
    pub t: f64,
    /// ν = n − 1 for n pairs.
    pub degrees_of_freedom: usize,
    /// Two-sided: how likely chance gives a t at least as far from 0.
    pub p: f64,
}

/// Differences that vary by less than this, relative to the values they were taken from, vary by rounding alone.
const ROUNDING: f64 = 4.0 * f64::EPSILON;

impl PairedT {
    /// Tests `a[i]` against `b[i]`, pair by pair.
    ///
    /// `None` where there is no test: not as many values in `a` as in `b`, fewer than two pairs, a value that is not
    /// finite, or differences that are all alike (0 or not), which leave no spread to measure their mean by.
    pub fn of(a: &[f64], b: &[f64]) -> Option<Self> {
        let all = || a.iter().chain(b);
        if a.len() != b.len() || a.len() < 2 || !all().all(|value| value.is_finite()) {
            return None;
        }
        let n = a.len() as f64;
        let differences = || a.iter().zip(b).map(|(a, b)| a - b);
        let mean = differences().sum::<f64>() / n;
        let squares: f64 = differences().map(|d| (d - mean) * (d - mean)).sum();
        let deviation = (squares / (n - 1.0)).sqrt();
        let largest = all().fold(0.0, |largest: f64, value| largest.max(value.abs()));
        if deviation <= ROUNDING * largest || !deviation.is_finite() {
            return None;
        }
        let t = mean / (deviation / n.sqrt());
        let freedom = n - 1.0;
        Some(Self {
            t,
            degrees_of_freedom: a.len() - 1,
            p: checked_beta_reg(freedom / 2.0, 0.5, freedom / (freedom + t * t)).ok()?,
        })
    }

    /// p as Duckett & Nehmzow print it in their Table 3: two digits, and never less than 0.01.
    pub fn p_as_printed(&self) -> f64 {
        ((100.0 * self.p).round() / 100.0).max(0.01)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn assert_near(test: Option<PairedT>, (t, p): (f64, f64)) {
        let test = test.unwrap();
        assert!((test.t - t).abs() <= 1e-11 * t.abs(), "{test:?}, t {t}");
        assert!((test.p - p).abs() <= 1e-9 * p, "{test:?}, p {p}");
    }

    /// scipy 1.17.1, `scipy.stats.ttest_rel(a, b)`.
    #[test]
    fn agrees_with_scipy() {
        let before = [1.83, 0.50, 1.62, 2.48, 1.68, 1.88, 1.55, 3.06, 1.30];
        let after = [0.878, 0.647, 0.598, 2.05, 1.06, 1.29, 1.06, 3.24, 1.29];
        let test = PairedT::of(&before, &after);
        assert_near(test, (2.850491911699701, 0.021462820475803616));
        assert_eq!(test.unwrap().degrees_of_freedom, 8);

        let tenths = |times: usize, modulus: usize| -> Vec<f64> {
            (0..30)
                .map(|i| (i * times % modulus) as f64 / 10.0)
                .collect()
        };
        let test = PairedT::of(&tenths(7, 11), &tenths(5, 13));
        assert_near(test, (-0.8882601576778811, 0.38170934931990025));

        // One degree of freedom; no difference on average; and a tail far out.
        let test = PairedT::of(&[0.1, 0.2], &[0.4, 0.1]);
        assert_near(test, (-0.5000000000000001, 0.7048327646991335));
        let even = PairedT::of(&[1.0, 2.0, 3.0, 4.0], &[1.5, 1.5, 3.5, 3.5]).unwrap();
        assert_eq!((even.t, even.p), (0.0, 1.0));
        let far: Vec<f64> = (0..10)
            .map(|i| f64::from(i) + 100.0 + f64::from(i % 3) * 1e-3)
            .collect();
        let near: Vec<f64> = (0..10).map(f64::from).collect();
        let p = PairedT::of(&far, &near).unwrap().p;
        assert!((p / 4.870407161211246e-47 - 1.0).abs() < 1e-6, "{p}");
    }

    /// Duckett & Nehmzow, *Performance comparison of landmark recognition systems*: every cell of Table 3 from Table 2.
    #[test]
    fn the_papers_third_table_follows_from_its_second() {
        let systems = [
            [0.554, 0.552, 0.462, 0.220], // RCE, environments A to D
            [0.573, 0.669, 0.538, 0.265], // ART2
            [0.650, 0.715, 0.551, 0.350], // nearest neighbour
            [0.719, 0.770, 0.502, 0.340], // growing cell structures
            [0.732, 0.879, 0.644, 0.487], // occupancy grids
            [0.806, 0.850, 0.632, 0.439], // occupancy histograms
        ];
        let printed: [&[f64]; 5] = [
            &[0.06, 0.01, 0.04, 0.01, 0.01],
            &[0.04, 0.16, 0.01, 0.01],
            &[0.60, 0.01, 0.01],
            &[0.05, 0.01],
            &[0.90],
        ];
        for (row, printed) in printed.iter().enumerate() {
            let others = &systems[row + 1..];
            assert_eq!(others.len(), printed.len());
            for (column, (other, &printed)) in others.iter().zip(*printed).enumerate() {
                let test = PairedT::of(&systems[row], other).unwrap();
                assert_eq!(test.degrees_of_freedom, 3);
                assert_eq!(test.p_as_printed(), printed, "row {row}, column {column}");
            }
        }
        // To more digits, by scipy 1.17.1's ttest_rel.
        let test = |a: usize, b: usize| PairedT::of(&systems[a], &systems[b]);
        assert_near(test(0, 2), (-7.012245898387683, 0.0059563918589820635));
        assert_near(test(2, 3), (-0.5859026925785209, 0.5991040060556859));
        assert_near(test(4, 5), (0.13920152046011078, 0.8981103183422583));
    }

    #[test]
    fn where_there_is_no_test_none_is_told() {
        assert_eq!(PairedT::of(&[], &[]), None);
        assert_eq!(PairedT::of(&[0.3], &[0.2]), None);
        assert_eq!(PairedT::of(&[0.3, 0.4], &[0.2]), None);
        assert_eq!(PairedT::of(&[0.3, f64::NAN], &[0.2, 0.1]), None);
        assert_eq!(PairedT::of(&[0.3, f64::INFINITY], &[0.2, 0.1]), None);
        assert_eq!(PairedT::of(&[0.3, 0.4], &[0.3, 0.4]), None);
        // Alike but for rounding: .3 − .2, .2 − .1 and .8 − .7 differ in their last bits.
        assert_eq!(PairedT::of(&[0.3, 0.2, 0.8], &[0.2, 0.1, 0.7]), None);
        assert_eq!(PairedT::of(&[f64::MAX, -f64::MAX], &[0.0, 0.0]), None);
    }

    #[test]
    fn the_order_of_the_two_turns_the_sign_alone() {
        let (a, b) = ([0.5, 0.7, 0.2], [0.4, 0.1, 0.3]);
        let (forth, back) = (PairedT::of(&a, &b).unwrap(), PairedT::of(&b, &a).unwrap());
        assert_eq!((forth.t, forth.p), (-back.t, back.p));
    }
}
