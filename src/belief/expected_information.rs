//! How much a robot expects to learn from sensing, before it senses.

use super::{
    belief::Belief,
    evidence::MAX_ENUMERATED_FEATURES,
    expected_posterior_error::{
        Approximation, believed, check_cells, feature_vectors, outcomes, quantiles,
    },
    map::GridMap,
};
use crate::{error::Result, seed::Stream};

/// The bits by which the probability of the true place is expected to rise, for a robot with this belief:
///
/// ```text
/// I = Σ_f Σ_ξ* Bel(ξ*) P(f|ξ*) log₂ M(ξ*, f) / Σ_ξ Bel(ξ) M(ξ, f)
/// ```
///
/// Where P = M it is the mutual information of features and place, never below 0; a map that is wrong may take away more than it gives.
/// Arguments and errors are those of
/// [`expected_posterior_error_m`](super::expected_posterior_error::expected_posterior_error_m). Unlike an error, information adds up over
/// steps: a robot that has far to go learns most by most bits first, and only then asks where they leave it.
///
/// ```
/// use ballmark::{belief::{Belief, GridMap, Places, expected_information::expected_information_bits,
///     expected_posterior_error::Approximation}, seed::Seed};
/// use ndarray::array;
/// // Two features that number four places tell both bits of the place.
/// let map = GridMap::new(array![[0.0, 0.0], [0.0, 1.0], [1.0, 0.0], [1.0, 1.0]])?;
/// let places = std::sync::Arc::new(Places::Route(vec![0.0, 1.0, 2.0, 3.0]));
/// let lost = Belief::uniform(&places)?;
/// let bits = expected_information_bits(&lost, &map, &map, Approximation::default(), &mut Seed(1).stream("features"))?;
/// assert!((bits - 2.0).abs() < 1e-12);
/// # Ok::<(), ballmark::Error>(())
/// ```
///
/// # Errors
/// Where maps and belief are of different cells, or the maps of different features.
pub fn expected_information_bits(
    belief: &Belief,
    answers: &GridMap,
    map: &GridMap,
    approximation: Approximation,
    stream: &mut Stream,
) -> Result<f64> {
    check_cells(belief, answers, map)?;
    Ok(information(belief, answers, map, &|_| true, approximation, stream).0)
}

/// The sum over those places ξ* alone where `is_truth`, and how much of the belief lies there.
pub(super) fn information(
    belief: &Belief,
    answers: &GridMap,
    map: &GridMap,
    is_truth: &dyn Fn(usize) -> bool,
    approximation: Approximation,
    stream: &mut Stream,
) -> (f64, f64) {
    if map.features() > MAX_ENUMERATED_FEATURES {
        return over_drawn_features(belief, answers, map, is_truth, approximation, stream);
    }
    let believed = believed(belief);
    let (p, m) = (outcomes(&believed, answers), outcomes(&believed, map));
    let mut d = vec![0.0; 1 << map.features()];
    for ((_, mass), m) in believed.iter().zip(&m) {
        d.iter_mut().zip(m).for_each(|(d, m)| *d += mass * m);
    }
    let (mut bits, mut at_truths) = (0.0, 0.0);
    for ((cell, mass), (p, m)) in believed.iter().zip(p.iter().zip(&m)) {
        if is_truth(*cell) {
            let each = p.iter().zip(m).zip(&d).filter(|((p, _), _)| **p > 0.0);
            let gain = each.map(|((p, m), d)| p * (m.max(SMALLEST) / d.max(SMALLEST)).log2());
            bits += mass * gain.sum::<f64>();
            at_truths += mass;
        }
    }
    (bits, at_truths)
}

/// What a map holds impossible counts as this likely: some hundred bits lost, and not all that there are.
const SMALLEST: f64 = 1e-30;

fn over_drawn_features(
    belief: &Belief,
    answers: &GridMap,
    map: &GridMap,
    is_truth: &dyn Fn(usize) -> bool,
    approximation: Approximation,
    stream: &mut Stream,
) -> (f64, f64) {
    let believed = quantiles(belief, approximation.places);
    let (mut bits, mut at_truths) = (0.0, 0.0);
    for (index, &(truth, mass)) in believed.iter().enumerate() {
        if !is_truth(truth) {
            continue;
        }
        at_truths += mass;
        for log in feature_vectors(truth, &believed, answers, map, approximation.drawn, stream) {
            let best = log.iter().copied().fold(f64::NEG_INFINITY, f64::max);
            let each = believed.iter().zip(&log);
            let d: f64 = each.map(|((_, mass), log)| mass * (log - best).exp()).sum();
            let gain = (log[index] - best - d.ln()) / std::f64::consts::LN_2;
            bits += mass * gain / approximation.drawn.max(1) as f64;
        }
    }
    (bits, at_truths)
}
