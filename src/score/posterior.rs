//! A score for who answers with probabilities instead of one place: the uncertainty coefficient, carried over to soft
//! posteriors.

use super::{
    contingency::{Ordinals, ordinal},
    uncertainty::entropy,
};
use crate::error::{Error, Result};
use std::hash::Hash;

/// Share of the prior p(l) in what is scored, which keeps ln 0 out: a posterior that excludes the truth loses
/// ln 100 nats and what the place is worth, not everything.
const PRIOR_SHARE: f64 = 0.01;

/// How far above 1 a sum of probabilities may come by rounding.
const ROUNDING: f64 = 1e-6;

/// U from soft posteriors: the share of the location's entropy that the posterior's probability of the truth tells,
///
/// ```text
/// U_soft = 1 + (1/N) Σ_k ln q_k / H(L),     q_k = 0.99 p_k(l_k) + 0.01 p(l_k)
/// ```
///
/// with p_k(l_k) the probability that the k-th posterior gives the true location, p(l) = N_•l/N how often the robot was
/// there, and H(L) the entropy of that, as in U(L|R) (Duckett & Nehmzow 1998, eq. 21 and 26). The mean of −ln q is the
/// logarithmic score (Good, *Rational decisions*, Journal of the Royal Statistical Society B 14, 1952): it is least on
/// average for a system that reports its true belief. The 1 % of prior is this crate's.
///
/// - 1 (less 0.0101/H(L) at most) says that the posterior was always sure and right.
/// - 0 is the worth of always answering with p(l), and of no answer, which counts as just that.
/// - Below 0 it would have been better to say nothing: the posterior was often sure and wrong. The least is
///   ln 0.01/H(L) = −4.61/H(L), for a posterior that always excludes the truth.
///
/// U(L|R) asks only whether responses can tell the locations apart, and so it decodes them with the very table it judges;
/// this asks whether the posterior as it stands is right. For a response r that is sent on as the posterior p(l|r) of its
/// own table, hard and calibrated, the mean of −ln p(l|r) is H(L|R): U_soft is U(L|R), but for the 1 %, and no other
/// posterior made from r scores more. So U_soft below U(L|R) is information that the system has and misjudges (one that
/// calls rooms by each other's names has U(L|R) = 1 and U_soft far below 0), and U_soft above U(L|R) is information that
/// was lost by answering with a single place. It needs no correction for chance, as the posterior is not fitted to the
/// truths that it is held against.
///
/// ```
/// use ballmark::score::PosteriorScore;
/// let mut sure = PosteriorScore::new();
/// let mut silent = PosteriorScore::new();
/// let mut misled = PosteriorScore::new();
/// for k in 0..40 {
///     let location = ["hall", "door", "desk", "lift"][k % 4];
///     sure.record(location, Some(1.0))?;
///     silent.record(location, None)?;
///     misled.record(location, Some(0.0))?;
/// }
/// assert!((sure.coefficient().unwrap() - 1.0).abs() < 0.01);
/// assert!(silent.coefficient().unwrap().abs() < 1e-12);
/// assert!((misled.coefficient().unwrap() - 0.01_f64.ln() / 4_f64.ln()).abs() < 1e-12); // −3.32
/// # Ok::<(), ballmark::Error>(())
/// ```
#[derive(Debug, Clone)]
pub struct PosteriorScore<L> {
    locations: Ordinals<L>,
    /// Number of the true location and its probability, one a data point.
    points: Vec<(usize, Option<f64>)>,
}

impl<L: Eq + Hash> Default for PosteriorScore<L> {
    fn default() -> Self {
        Self::new()
    }
}

impl<L: Eq + Hash> PosteriorScore<L> {
    /// A score without data points.
    pub fn new() -> Self {
        Self {
            locations: Ordinals::default(),
            points: Vec::new(),
        }
    }

    /// One data point: the robot was at `location`, and the posterior gave that location this probability (all that lies
    /// in it together); `None`: no posterior was given.
    ///
    /// # Errors
    /// Where the probability is not one, which is the fault of who answered.
    pub fn record(&mut self, location: L, probability: Option<f64>) -> Result<()> {
        if let Some(p) = probability.filter(|p| !(0.0..=1.0 + ROUNDING).contains(p)) {
            return Err(Error::work(format!(
                "posterior: data point {} gives the true location {p}; expected a probability",
                self.points.len()
            )));
        }
        let location = ordinal(&mut self.locations, location);
        self.points
            .push((location, probability.map(|p| p.min(1.0))));
        Ok(())
    }

    /// Number of data points N.
    pub fn len(&self) -> usize {
        self.points.len()
    }

    /// Is there no data point?
    pub fn is_empty(&self) -> bool {
        self.points.is_empty()
    }

    /// How many data points had a posterior.
    pub fn answered(&self) -> usize {
        self.points.iter().filter(|point| point.1.is_some()).count()
    }

    /// U_soft; `None` where H(L) = 0: with a single location there is nothing to tell. The same to the last bit in
    /// whatever order the points were recorded.
    pub fn coefficient(&self) -> Option<f64> {
        self.coefficient_with(PRIOR_SHARE)
    }

    fn coefficient_with(&self, share: f64) -> Option<f64> {
        if self.locations.len() < 2 {
            return None;
        }
        let mut times = vec![0; self.locations.len()];
        for &(location, _) in &self.points {
            times[location] += 1;
        }
        let n = self.points.len() as f64;
        let log_score = |&(location, probability): &(usize, Option<f64>)| {
            let prior = times[location] as f64 / n;
            let posterior = probability.unwrap_or(prior);
            ((1.0 - share) * posterior + share * prior).ln()
        };
        let mut scores: Vec<f64> = self.points.iter().map(log_score).collect();
        scores.sort_by(f64::total_cmp);
        times.sort_unstable();
        let entropy = entropy(&times, self.points.len() as u64);
        Some(1.0 + scores.iter().sum::<f64>() / n / entropy)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::score::{Contingency, Entropies};

    /// Responses of 300 data points at 13 locations, and U of them.
    fn responses() -> (Vec<(usize, usize)>, f64) {
        let points: Vec<(usize, usize)> = (0..300)
            .map(|i| (i % 13, if i % 3 == 0 { i * 7 % 6 } else { i % 13 / 2 }))
            .collect();
        let mut table = Contingency::new();
        points.iter().for_each(|&(l, r)| table.record(l, r));
        let u = Entropies::of(&table.counts()).uncertainty_coefficient();
        (points, u.unwrap())
    }

    /// The responses as posteriors `of(location, response)`.
    fn score(probability: impl Fn(usize, usize) -> f64) -> PosteriorScore<usize> {
        let mut score = PosteriorScore::new();
        for (location, response) in responses().0 {
            score
                .record(location, Some(probability(location, response)))
                .unwrap();
        }
        score
    }

    /// p(l|r) of the table of the responses.
    fn calibrated(location: usize, response: usize) -> f64 {
        let (points, _) = responses();
        let given = points.iter().filter(|p| p.1 == response);
        let here = given.clone().filter(|p| p.0 == location);
        here.count() as f64 / given.count() as f64
    }

    #[test]
    fn of_a_hard_calibrated_table_it_is_the_uncertainty_coefficient_in_the_limit() {
        let u = responses().1;
        let score = score(calibrated);
        let limit = score.coefficient_with(1e-13).unwrap();
        assert!((limit - u).abs() < 1e-10, "{limit} {u}");
        // The 1 % of prior takes away 0.0101/H(L) at most.
        let with_prior = score.coefficient().unwrap();
        assert!(
            with_prior < u && with_prior > u - 0.00394,
            "{with_prior} {u}"
        );
    }

    #[test]
    fn other_posteriors_from_the_same_responses_score_less() {
        let best = score(calibrated).coefficient().unwrap();
        let blunt = |l, r| 0.5 * calibrated(l, r) + 0.5 / 13.0;
        // Too sure of the most probable location, by the square of the probabilities.
        let sharp = |l, r| {
            let squares = |l: usize| calibrated(l, r).powi(2);
            squares(l) / (0..13).map(squares).sum::<f64>()
        };
        // Right in what it can tell apart, and wrong in every name.
        let misnamed = |l, r| calibrated((l + 4) % 13, r);
        let less = [
            score(blunt).coefficient().unwrap(),
            score(sharp).coefficient().unwrap(),
            score(misnamed).coefficient().unwrap(),
        ];
        assert!(less.iter().all(|&u| u < best - 0.01), "{less:?} {best}");
        assert!(less[2] < -0.5, "{less:?}");
    }

    #[test]
    fn worked_by_hand() {
        // Three of four data points at the first location: H(L) = −.75 ln .75 − .25 ln .25.
        let mut score = PosteriorScore::new();
        for (location, p) in [
            ("a", Some(1.0)),
            ("a", Some(0.5)),
            ("b", Some(0.0)),
            ("a", None),
        ] {
            score.record(location, p).unwrap();
        }
        let q: [f64; 4] = [0.9975, 0.5025, 0.0025, 0.75];
        let entropy = -0.75 * 0.75_f64.ln() - 0.25 * 0.25_f64.ln();
        let expected = 1.0 + q.iter().map(|q| q.ln()).sum::<f64>() / 4.0 / entropy;
        assert!((score.coefficient().unwrap() - expected).abs() < 1e-12);
        assert_eq!((score.len(), score.answered()), (4, 3));
    }

    #[test]
    fn the_order_of_recording_changes_no_bit() {
        let (points, _) = responses();
        let mut backward = PosteriorScore::new();
        for &(l, r) in points.iter().rev() {
            backward.record(l, Some(calibrated(l, r))).unwrap();
        }
        assert_eq!(backward.coefficient(), score(calibrated).coefficient());
    }

    #[test]
    fn what_is_no_probability_is_told_and_one_location_has_no_score() {
        let mut score = PosteriorScore::new();
        assert_eq!(score.coefficient(), None);
        for wrong in [f64::NAN, -0.1, 1.1, f64::INFINITY] {
            let message = score.record("a", Some(wrong)).unwrap_err().to_string();
            assert!(message.contains("expected a probability"), "{message}");
        }
        assert!(score.is_empty());
        score.record("a", Some(1.0 + 1e-12)).unwrap();
        assert_eq!(score.coefficient(), None);
        score.record("b", Some(1.0)).unwrap();
        assert!(score.coefficient().unwrap() < 1.0);
    }
}
