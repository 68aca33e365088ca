//! What an answer of the detectors says about the place.

use super::{belief::Belief, map::GridMap};
use crate::{
    error::{Error, Result},
    seed::Stream,
};
use rand::RngExt;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use std::{fmt, str::FromStr};

/// Most features for which all 2ⁿ feature vectors are gone through.
pub const MAX_ENUMERATED_FEATURES: usize = 12;

/// How probabilities g_i = P(f_i = 1 | s), which are no certain features, become a likelihood of each place. With
/// m_i(ξ) = P(f_i = 1 | ξ) from the map, and M(ξ, f), P(f|s) the products over features (Thrun 1998, eq. 33):
///
/// ```
/// use ballmark::{belief::{Belief, Evidence, GridMap, Places}, seed::Seed};
/// let places = std::sync::Arc::new(Places::Route(vec![0.0, 1.0]));
/// let map = GridMap::new(ndarray::array![[0.9], [0.2]])?;
/// let belief = Belief::uniform(&places)?;
/// let log_likelihood = Evidence::Likelihood.log_likelihood(&[0.75], &map, &belief, &mut Seed(0).stream("features"))?;
/// assert!((log_likelihood[0].exp() - (0.75 * 0.9 + 0.25 * 0.1)).abs() < 1e-12);
/// # Ok::<(), ballmark::Error>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
#[non_exhaustive]
pub enum Evidence {
    /// A feature vector f drawn from P(f|s), then M(ξ, f): Table 1 of the paper with the stochastic filters of 4.2.
    Sampled,
    /// Σ_f P(f|s) M(ξ, f)/D(f) with D(f) = Σ_ξ Bel(ξ) M(ξ, f): the mean of the posteriors over all f (Jeffrey's rule). Where
    /// map and filters agree its expected error is what training minimises. For up to 12 features.
    Jeffrey,
    /// Σ_f P(f|s) M(ξ, f) = Π_i g_i m_i + (1−g_i)(1−m_i): the likelihood averaged over all f, then normalised. Not the same,
    /// and not what training minimises. It factorises, so it is exact for any number of features.
    Likelihood,
    /// exp Σ_i g_i ln m_i + (1−g_i) ln(1−m_i): mean field. Exact where every g_i is 0 or 1; the one for wide codes.
    MeanField,
}

impl Evidence {
    /// All of them.
    pub const ALL: [Evidence; 4] = [
        Evidence::Sampled,
        Evidence::Jeffrey,
        Evidence::Likelihood,
        Evidence::MeanField,
    ];

    /// The name that configurations use.
    pub fn name(self) -> &'static str {
        match self {
            Evidence::Sampled => "sampled",
            Evidence::Jeffrey => "jeffrey",
            Evidence::Likelihood => "likelihood",
            Evidence::MeanField => "mean-field",
        }
    }

    /// ln of the likelihood of each cell, up to a constant, for activations `g`, one a feature. `belief` is the belief
    /// before (Jeffrey asks for it); `stream` is where sampled evidence draws its features from.
    ///
    /// # Errors
    /// Where the numbers of features or cells differ, an activation isn't in [0, 1], or Jeffrey's rule is asked of more than
    /// [`MAX_ENUMERATED_FEATURES`].
    pub fn log_likelihood(
        self,
        g: &[f64],
        map: &GridMap,
        belief: &Belief,
        stream: &mut Stream,
    ) -> Result<Vec<f64>> {
        Ok(self.weighed(g, map, belief, stream)?.0)
    }

    /// The same, scaled so that ln Σ_ξ Bel(ξ) P(z|ξ) is the logarithm of how likely the belief held this answer to be:
    ///
    /// - sampled: the probability of the features that were drawn, D(f) = Σ_ξ Bel(ξ) M(ξ, f);
    /// - Jeffrey and likelihood: Σ_f P(f|s) D(f), the probability that features drawn from the map, at a place drawn from the
    ///   belief, are those drawn from the filters;
    /// - mean field: Σ_ξ Bel(ξ) Π_i m_i^g_i (1−m_i)^(1−g_i); the probability of the features where every g_i is 0 or 1, and
    ///   otherwise a likelihood that may be compared between beliefs, not between answers.
    ///
    /// # Errors
    /// As [`Evidence::log_likelihood`].
    pub fn predictive_log_likelihood(
        self,
        g: &[f64],
        map: &GridMap,
        belief: &Belief,
        stream: &mut Stream,
    ) -> Result<Vec<f64>> {
        let (mut log_likelihood, log_scale) = self.weighed(g, map, belief, stream)?;
        if log_scale.is_finite() {
            log_likelihood.iter_mut().for_each(|l| *l += log_scale);
        }
        Ok(log_likelihood)
    }

    /// ln P(z|ξ) at each cell, less the second number.
    fn weighed(
        self,
        g: &[f64],
        map: &GridMap,
        belief: &Belief,
        stream: &mut Stream,
    ) -> Result<(Vec<f64>, f64)> {
        if g.len() != map.features() || belief.mass().len() != map.cells() {
            return Err(Error::work(format!(
                "evidence: {} activations and a belief over {} places for a map of {} features at {} cells",
                g.len(),
                belief.mass().len(),
                map.features(),
                map.cells()
            )));
        }
        if let Some(bad) = g.iter().position(|g| !(0.0..=1.0).contains(g)) {
            return Err(Error::work(format!(
                "evidence: activation of feature {bad} is {}; expected a probability",
                g[bad]
            )));
        }
        match self {
            Evidence::Sampled => {
                let f: Vec<f64> = g
                    .iter()
                    .map(|&g| f64::from(stream.random::<f64>() < g))
                    .collect();
                Ok((map.cross_entropy(&f), 0.0))
            }
            Evidence::MeanField => Ok((map.cross_entropy(g), 0.0)),
            Evidence::Likelihood => Ok((averaged_over_features(g, map), 0.0)),
            Evidence::Jeffrey if g.len() > MAX_ENUMERATED_FEATURES => Err(Error::usage(format!(
                "evidence: Jeffrey's rule with {} features; expected at most {MAX_ENUMERATED_FEATURES}, since it goes through all 2^n feature vectors (`mean-field` takes any number)",
                g.len()
            ))),
            Evidence::Jeffrey => Ok(jeffrey(g, map, belief.mass())),
        }
    }
}

/// ln Σ_f P(f|s) M(ξ, f).
fn averaged_over_features(g: &[f64], map: &GridMap) -> Vec<f64> {
    let cells = map.probability();
    // The logarithm of each factor: a product of 64 of them could underflow.
    let factor = |(m, g): (&f64, &f64)| (g * m + (1.0 - g) * (1.0 - m)).ln();
    (0..map.cells())
        .into_par_iter()
        .map(|cell| cells.row(cell).iter().zip(g).map(factor).sum())
        .collect()
}

/// ln Σ_f P(f|s) M(ξ, f)/D(f) at each cell, and ln Σ_f P(f|s) D(f).
fn jeffrey(g: &[f64], map: &GridMap, mass: &[f64]) -> (Vec<f64>, f64) {
    let evidence = average_over_belief(map, mass); // D(f)
    let mut weights = product(g); // P(f|s), then P(f|s)/D(f)
    let log_scale = weights
        .iter()
        .zip(&evidence)
        .map(|(weight, evidence)| weight * evidence)
        .sum::<f64>()
        .ln();
    for (weight, evidence) in weights.iter_mut().zip(&evidence) {
        // A feature vector that the map holds impossible everywhere leaves no posterior to average.
        *weight = if *evidence > 0.0 {
            *weight / evidence
        } else {
            0.0
        };
    }
    if weights.iter().all(|w| *w == 0.0) {
        return (vec![0.0; mass.len()], log_scale);
    }
    let cells = map.probability();
    let log_likelihood = (0..map.cells())
        .into_par_iter()
        .map_init(Vec::new, |workspace, cell| {
            // Σ_f W(f) Π_i m_i^f_i (1−m_i)^(1−f_i), one feature at a time, the last first: half the sums are left each time.
            workspace.clear();
            workspace.extend_from_slice(&weights);
            for &m in cells.row(cell).iter().rev() {
                let half = workspace.len() / 2;
                let (without, with) = workspace.split_at_mut(half);
                without
                    .iter_mut()
                    .zip(with)
                    .for_each(|(a, b)| *a = (1.0 - m) * *a + m * *b);
                workspace.truncate(half);
            }
            workspace[0].ln()
        })
        .collect();
    (log_likelihood, log_scale)
}

/// D(f) = Σ_ξ Bel(ξ) M(ξ, f) for all 2ⁿ f, summed in blocks so that the number of threads changes nothing.
fn average_over_belief(map: &GridMap, mass: &[f64]) -> Vec<f64> {
    const BLOCK: usize = 4096;
    let cells = map.probability();
    let blocks: Vec<Vec<f64>> = mass
        .par_chunks(BLOCK)
        .enumerate()
        .map(|(block, mass)| {
            let (mut sum, mut m) = (vec![0.0; 1 << map.features()], Vec::new());
            let believed = mass.iter().enumerate().filter(|(_, mass)| **mass > 0.0);
            for (i, &mass) in believed {
                product_into(cells.row(block * BLOCK + i).iter().copied(), mass, &mut m);
                sum.iter_mut().zip(&m).for_each(|(s, m)| *s += m);
            }
            sum
        })
        .collect();
    let mut sum = vec![0.0; 1 << map.features()];
    for block in &blocks {
        sum.iter_mut().zip(block).for_each(|(s, b)| *s += b);
    }
    sum
}

/// Π_i p_i^f_i (1−p_i)^(1−f_i) for all f; bit i of the index is f_i.
fn product(p: &[f64]) -> Vec<f64> {
    let mut all = Vec::new();
    product_into(p.iter().copied(), 1.0, &mut all);
    all
}

pub(super) fn product_into(p: impl Iterator<Item = f64>, scale: f64, all: &mut Vec<f64>) {
    all.clear();
    all.push(scale);
    for p in p {
        for i in 0..all.len() {
            all.push(all[i] * p);
            all[i] *= 1.0 - p;
        }
    }
}

impl FromStr for Evidence {
    type Err = Error;

    fn from_str(text: &str) -> Result<Self> {
        Evidence::ALL
            .into_iter()
            .find(|e| e.name() == text)
            .ok_or_else(|| {
                let names = Evidence::ALL.map(Evidence::name).join(", ");
                Error::usage(format!("evidence `{text}`: expected one of {names}"))
            })
    }
}

impl fmt::Display for Evidence {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}
