//! Entropies of a contingency table and the uncertainty coefficient (Duckett & Nehmzow 1998, 4.1, eq. 15–26).

use super::contingency::Counts;

/// Entropies of location L and response R in nats: natural logarithms throughout, as in the paper.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Entropies {
    /// H(L): what is unknown about the location before the response.
    pub location: f64,
    /// H(R).
    pub response: f64,
    /// H(L, R).
    pub joint: f64,
}

impl Entropies {
    /// The entropies of a table's counts.
    pub fn of(counts: &Counts) -> Self {
        let total = counts.total();
        Self {
            location: entropy(counts.locations(), total), // eq. 21
            response: entropy(counts.responses(), total), // eq. 22
            joint: entropy(counts.cells(), total),        // eq. 23
        }
    }

    /// H(L|R) = H(L, R) − H(R): what the response leaves unknown about the location (eq. 24). In [0, H(L)] (eq. 25);
    /// rounding is not let out of it.
    pub fn location_given_response(&self) -> f64 {
        (self.joint - self.response).clamp(0.0, self.location)
    }

    /// H(L) − H(L|R): the mutual information of location and response.
    pub fn mutual_information(&self) -> f64 {
        self.location - self.location_given_response()
    }

    /// U(L|R) = (H(L) − H(L|R)) / H(L): the share of what can be known about the location that the response tells
    /// (eq. 26), in [0, 1]. `None` where H(L) = 0: with a single location there is nothing to tell.
    pub fn uncertainty_coefficient(&self) -> Option<f64> {
        (self.location > 0.0).then(|| self.mutual_information() / self.location)
    }
}

/// −Σ p ln p with p = count / total (eq. 18–20, 21–23).
pub(super) fn entropy(counts: &[u64], total: u64) -> f64 {
    let of_one = |&count: &u64| {
        let p = count as f64 / total as f64;
        p * p.ln()
    };
    0.0 - counts.iter().map(of_one).sum::<f64>() // 0 −, so that one sure outcome gives 0 and not −0
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::score::Contingency;

    fn coefficient(points: impl Iterator<Item = (usize, usize)>) -> Option<f64> {
        let mut table = Contingency::new();
        points.for_each(|(location, response)| table.record(location, response));
        Entropies::of(&table.counts()).uncertainty_coefficient()
    }

    #[test]
    fn perfect_is_exactly_one_and_useless_exactly_zero() {
        let renamed = (0..90).map(|k| (k % 7, 100 - k % 7));
        assert_eq!(coefficient(renamed), Some(1.0));
        let finer = (0..84).map(|k| (k % 7, k % 14)); // two responses for one location are no fault
        assert_eq!(coefficient(finer), Some(1.0));
        assert_eq!(coefficient((0..90).map(|k| (k % 7, 4))), Some(0.0));
        assert_eq!(coefficient((0..90).map(|k| (3, k % 7))), None);
        assert_eq!(coefficient(std::iter::empty()), None);
    }

    /// scikit-learn 1.9.1, `homogeneity_score(labels_true=L, labels_pred=R)`; the axes swapped give .013551731548 for the
    /// second and .587656853466 for the third.
    #[test]
    fn agrees_with_scikit_learn() {
        let location = [0, 0, 0, 1, 1, 1, 2, 2, 2, 3];
        let response = [0, 0, 1, 1, 1, 2, 2, 2, 0, 3];
        let cases = [
            (
                coefficient(location.into_iter().zip(response)),
                0.563976318932,
            ),
            (
                coefficient((0..60).map(|i| (i % 7, i * i % 5))),
                0.007353024795,
            ),
            (
                coefficient((0..200).map(|i| {
                    let confused = if i % 3 == 0 { i * 7 % 6 } else { i % 13 / 2 };
                    (i % 13, confused)
                })),
                0.410312956209,
            ),
        ];
        for (ours, theirs) in cases {
            assert!((ours.unwrap() - theirs).abs() < 1e-11, "{ours:?} {theirs}");
        }
    }
}
