//! What error a robot expects to be left with after sensing, before it senses: what tells sets of features, sensors and actions apart.
//!
//! Thrun (1998), eq. 36, with the robot's own belief as the prior, and the place where it may truly be weighed by that belief:
//!
//! ```text
//! E = Σ_f Σ_ξ* Bel(ξ*) P(f|ξ*) · (Σ_ξ e(ξ*, ξ) Bel(ξ) M(ξ, f)) / (Σ_ξ Bel(ξ) M(ξ, f))
//! ```
//!
//! P(f|ξ*) is what the sensor answers there, M what the map has. Where both are the same examples, features that were learned by heart
//! promise most; so P comes from one run and M from the others ([`HeldApart`](super::held_apart::HeldApart)).

use super::{
    belief::Belief,
    evidence::{MAX_ENUMERATED_FEATURES, product_into},
    map::GridMap,
    places::Places,
};
use crate::{
    error::{Error, Result},
    seed::Stream,
};
use rand::RngExt;
use std::collections::BTreeMap;

/// A belief below this has no part in the sums: what is left out is this times the extent at most.
pub(super) const NO_PART: f64 = 1e-12;

/// How the sum is approximated where it can't be had as it is: along a route, with up to 12 features, it can.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub struct Approximation {
    /// Places in the plane, at most: quantiles of the belief at even steps stand for all cells.
    pub places: usize,
    /// Feature vectors that are drawn a place, where there are too many to go through.
    pub drawn: usize,
}

impl Default for Approximation {
    /// 200 places, four feature vectors each.
    fn default() -> Self {
        Self {
            places: 200,
            drawn: 4,
        }
    }
}

/// Features whose 2ⁿ vectors are gone through for pairs of places in the plane.
const MAX_OVER_PAIRS: usize = 6;

/// E of one set of features, in metres, for a robot with this belief. `answers` is P(f_i = 1 | ξ*) of what the sensor would say, `map`
/// is P(f_i = 1 | ξ) of what it is held against, both at the cells of the belief; `stream` draws where all feature vectors are too
/// many.
///
/// ```
/// use ballmark::{belief::{Belief, GridMap, Places, expected_posterior_error::{Approximation, expected_posterior_error_m}}, seed::Seed};
/// use ndarray::array;
/// // Two places 99 m apart and one feature: 25 of 49.5 m are left (Thrun 1998, eq. 36 by hand).
/// let places = std::sync::Arc::new(Places::Route(vec![0.0, 99.0]));
/// let map = GridMap::new(array![[0.9], [0.2]])?;
/// let lost = Belief::uniform(&places)?;
/// let sums = Approximation::default();
/// let e = expected_posterior_error_m(&lost, &map, &map, sums, &mut Seed(1).stream("features"))?;
/// assert!((e - 25.0).abs() < 1e-12);
/// # Ok::<(), ballmark::Error>(())
/// ```
///
/// # Errors
/// Where maps and belief are of different cells, or the maps of different features.
pub fn expected_posterior_error_m(
    belief: &Belief,
    answers: &GridMap,
    map: &GridMap,
    approximation: Approximation,
    stream: &mut Stream,
) -> Result<f64> {
    check_cells(belief, answers, map)?;
    let everywhere = |_: usize| true;
    let (error_m, _) = over_truths(belief, answers, map, &everywhere, approximation, stream);
    Ok(error_m)
}

/// # Errors
/// Where maps and belief are of different cells, or the maps of different features.
pub(super) fn check_cells(belief: &Belief, answers: &GridMap, map: &GridMap) -> Result<()> {
    let cells = belief.mass().len();
    if [answers.cells(), map.cells()] != [cells; 2] || answers.features() != map.features() {
        return Err(Error::work(format!(
            "expected error: maps of {} features at {} cells and {} at {} for a belief over {cells} places",
            answers.features(),
            answers.cells(),
            map.features(),
            map.cells(),
        )));
    }
    Ok(())
}

/// The sum over those places ξ* alone where `is_truth`, and how much of the belief lies there.
pub(super) fn over_truths(
    belief: &Belief,
    answers: &GridMap,
    map: &GridMap,
    is_truth: &dyn Fn(usize) -> bool,
    approximation: Approximation,
    stream: &mut Stream,
) -> (f64, f64) {
    let (n, places) = (map.features(), &**belief.places());
    let is_exact = matches!(places, Places::Route(_)) && n <= MAX_ENUMERATED_FEATURES;
    let believed = match is_exact {
        true => believed(belief),
        false => quantiles(belief, approximation.places),
    };
    let truths: Believed = believed
        .iter()
        .copied()
        .filter(|(cell, _)| is_truth(*cell))
        .collect();
    let mass = truths.iter().map(|(_, mass)| mass).sum();
    let error_m = match places {
        Places::Route(route_m) if is_exact => {
            let truth = |cell: usize| if is_truth(cell) { 1.0 } else { 0.0 };
            along_route(route_m, &believed, answers, map, &truth)
        }
        _ if n <= MAX_OVER_PAIRS => over_all_features(places, (&truths, &believed), answers, map),
        _ => {
            let drawn = approximation.drawn.max(1);
            over_drawn_features(places, (&truths, &believed), answers, map, drawn, stream)
        }
    };
    (error_m, mass)
}

/// A cell of the belief with its mass.
pub(super) type Believed = Vec<(usize, f64)>;

/// All cells that have a part in the sums.
pub(super) fn believed(belief: &Belief) -> Believed {
    let mass = belief.mass().iter().copied().enumerate();
    mass.filter(|(_, mass)| *mass > NO_PART).collect()
}

/// Cells at even steps of the summed belief, each with the share of the steps that end in it; all cells, where they are no more.
pub(super) fn quantiles(belief: &Belief, steps: usize) -> Believed {
    let all = believed(belief);
    if all.len() <= steps.max(1) {
        return all;
    }
    let total: f64 = all.iter().map(|(_, mass)| mass).sum();
    let mut shares: BTreeMap<usize, usize> = BTreeMap::new();
    let (mut sum, mut step) = (0.0, 0);
    for (cell, mass) in all {
        sum += mass;
        while step < steps && (step as f64 + 0.5) / steps as f64 * total <= sum {
            *shares.entry(cell).or_default() += 1;
            step += 1;
        }
    }
    let share = |(cell, steps_in_it): (usize, usize)| (cell, steps_in_it as f64 / steps as f64);
    shares.into_iter().map(share).collect()
}

/// P(f|ξ) of all 2ⁿ feature vectors, `[believed, f]`.
pub(super) fn outcomes(believed: &[(usize, f64)], map: &GridMap) -> Vec<Vec<f64>> {
    let of = |&(cell, _): &(usize, f64)| {
        let mut all = Vec::new();
        product_into(map.probability().row(cell).iter().copied(), 1.0, &mut all);
        all
    };
    believed.iter().map(of).collect()
}

/// Exact along a route, where |x* − x| needs sums over what lies behind and before alone: a pass over the cells a feature vector.
fn along_route(
    route_m: &[f64],
    believed: &[(usize, f64)],
    answers: &GridMap,
    map: &GridMap,
    truth: &dyn Fn(usize) -> f64,
) -> f64 {
    let mut believed = believed.to_vec();
    believed.sort_by(|a, b| route_m[a.0].total_cmp(&route_m[b.0]));
    // Sums of coordinates stay small beside their differences.
    let origin_m = believed.first().map_or(0.0, |&(cell, _)| route_m[cell]);
    let (p, m) = (outcomes(&believed, answers), outcomes(&believed, map));
    let mut error_m = 0.0;
    for f in 0..1 << map.features() {
        let weights = believed.iter().zip(&m);
        let at = weights.map(|((cell, mass), m)| (route_m[*cell] - origin_m, mass * m[f]));
        let (mut d, mut moment) = (0.0, 0.0);
        for (x_m, weight) in at.clone() {
            d += weight;
            moment += x_m * weight;
        }
        if d <= 0.0 {
            continue; // the map holds f impossible wherever the robot may be, and no cell answers it
        }
        let (mut behind, mut moment_behind) = (0.0, 0.0);
        for ((x_m, weight), ((cell, mass), p)) in at.zip(believed.iter().zip(&p)) {
            behind += weight;
            moment_behind += x_m * weight;
            let distances_m =
                x_m * behind - moment_behind + (moment - moment_behind) - x_m * (d - behind);
            error_m += truth(*cell) * mass * p[f] * distances_m / d;
        }
    }
    error_m
}

/// Pairs of places, all feature vectors.
fn over_all_features(
    places: &Places,
    (truths, believed): (&Believed, &Believed),
    answers: &GridMap,
    map: &GridMap,
) -> f64 {
    let (p, m) = (outcomes(truths, answers), outcomes(believed, map));
    let mut d = vec![0.0; 1 << map.features()];
    for ((_, mass), m) in believed.iter().zip(&m) {
        d.iter_mut().zip(m).for_each(|(d, m)| *d += mass * m);
    }
    let mut error_m = 0.0;
    for ((truth, mass), p) in truths.iter().zip(&p) {
        for ((cell, weight), m) in believed.iter().zip(&m) {
            let outcomes = p.iter().zip(m).zip(&d);
            let confused: f64 = outcomes
                .filter(|(_, d)| **d > 0.0)
                .map(|((p, m), d)| p * m / d)
                .sum();
            error_m += mass * weight * confused * places.distance_m(*truth, places, *cell);
        }
    }
    error_m
}

/// Feature vectors drawn at each place.
fn over_drawn_features(
    places: &Places,
    (truths, believed): (&Believed, &Believed),
    answers: &GridMap,
    map: &GridMap,
    drawn: usize,
    stream: &mut Stream,
) -> f64 {
    let mut error_m = 0.0;
    for &(truth, mass) in truths {
        for log in feature_vectors(truth, believed, answers, map, drawn, stream) {
            let best = log.iter().copied().fold(f64::NEG_INFINITY, f64::max);
            let (mut d, mut distances_m) = (0.0, 0.0);
            for ((cell, weight), log) in believed.iter().zip(&log) {
                let weight = weight * (log - best).exp();
                d += weight;
                distances_m += weight * places.distance_m(truth, places, *cell);
            }
            error_m += mass * distances_m / d / drawn as f64;
        }
    }
    error_m
}

/// ln M(ξ, f) at each believed cell, for feature vectors drawn from what is answered at a place, `[drawn][believed]`.
pub(super) fn feature_vectors(
    truth: usize,
    believed: &Believed,
    answers: &GridMap,
    map: &GridMap,
    drawn: usize,
    stream: &mut Stream,
) -> Vec<Vec<f64>> {
    let certain = |m: f64| m.clamp(f64::EPSILON, 1.0 - f64::EPSILON);
    let (answers, map) = (answers.probability(), map.probability());
    let draw = |_: usize| {
        let answers = answers.row(truth);
        let f: Vec<bool> = answers
            .iter()
            .map(|p| stream.random::<f64>() < *p)
            .collect();
        let log = |(cell, _): &(usize, f64)| -> f64 {
            let terms = map.row(*cell);
            let terms = terms.iter().map(|m| certain(*m)).zip(&f);
            terms
                .map(|(m, &f)| if f { m.ln() } else { (-m).ln_1p() })
                .sum()
        };
        believed.iter().map(log).collect()
    };
    (0..drawn.max(1)).map(draw).collect()
}

#[cfg(test)]
mod tests;
