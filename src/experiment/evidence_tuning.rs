//! How sharply answers count: constants of a likelihood, chosen on the validation part and never on what is judged.

use super::held_out::by_kernel;
use crate::belief::{Places, Uncertainty};
use ndarray::ArrayView2;

/// Bandwidths h that the kernel is tuned over, in units of the inputs' deviation.
const BANDWIDTHS: [f64; 10] = [0.01, 0.02, 0.04, 0.08, 0.12, 0.16, 0.24, 0.32, 0.64, 1.28];

/// The bandwidth of least error on the validation part, given as its places and their distances `[validation, candidate]`
/// from the candidates' scans; in the middle of the range where nothing can be validated.
pub fn tuned_bandwidth(
    uncertainty: Uncertainty,
    validation: &Places,
    candidates: &Places,
    square: ArrayView2<f32>,
) -> f64 {
    let mut best = (BANDWIDTHS[BANDWIDTHS.len() / 2], f64::INFINITY);
    if !validation.is_empty() {
        for h in BANDWIDTHS {
            let score = by_kernel(uncertainty, validation, candidates, square, h);
            if score.posterior_error_m < best.1 {
                best = (h, score.posterior_error_m);
            }
        }
    }
    best.0
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::localiser::sensor_model::least_mean_squares;
    use ndarray::{Array2, array};

    /// Tuned on one validation snapshot at the first of three places, where it reads `seen`.
    fn tuned(seen: f32) -> f64 {
        let candidates = Places::Route(vec![0.0, 10.0, 20.0]);
        let scans = array![[0.0], [0.1], [1.0]];
        let square = least_mean_squares(array![[seen]].view(), &[scans]);
        let validation = Places::Route(vec![0.0]);
        tuned_bandwidth(Uncertainty::Global, &validation, &candidates, square.view())
    }

    #[test]
    fn scans_that_scatter_more_get_a_wider_kernel() {
        assert_eq!(tuned(0.0), BANDWIDTHS[0]);
        // Nearer to the second place's scan than to its own: a sharp kernel would be sure of the wrong place.
        assert!((0.08..0.64).contains(&tuned(0.06)), "{}", tuned(0.06));
    }

    #[test]
    fn without_validation_the_middle_of_the_range_is_taken() {
        let (nowhere, places) = (Places::Route(Vec::new()), Places::Route(vec![0.0, 1.0]));
        let square = Array2::zeros((0, 2));
        let h = tuned_bandwidth(Uncertainty::Global, &nowhere, &places, square.view());
        assert_eq!(h, BANDWIDTHS[BANDWIDTHS.len() / 2]);
    }
}
