//! What a set of features promises, judged by runs that its map is not of.

use super::{
    belief::Belief,
    expected_information::information,
    expected_posterior_error::{Approximation, NO_PART, check_cells, over_truths},
    map::{FeatureMap, GridMap, MapConfig},
    neighbours::Neighbours,
    places::Places,
};
use crate::{
    error::{Error, Result},
    seed::Stream,
};
use ndarray::{Array2, Axis};
use std::collections::BTreeSet;

/// What a set of features answers at the cells of a grid in one run, and its map by all others, a pair a run.
#[derive(Debug, Clone)]
pub struct HeldApart {
    pairs: Vec<Pair>,
}

/// One run against the others.
#[derive(Debug, Clone)]
struct Pair {
    /// P(f_i = 1 | ξ) of the snapshot of this run that is nearest.
    answers: GridMap,
    /// P(f_i = 1 | ξ) by the others.
    map: GridMap,
    /// Whether this run and another have been there, `[cell]`.
    seen_twice: Vec<bool>,
}

impl HeldApart {
    /// From the places and answers of K training snapshots, `[snapshot, feature]`, and the run that each is of; `cells` are those of
    /// the belief. Where no two runs went to one place there is nothing to hold apart: answers are judged by their own map.
    ///
    /// # Errors
    /// Where there is not one run a snapshot, or as [`FeatureMap::new`].
    pub fn new(
        places: &Places,
        activation: &Array2<f64>,
        run: &[usize],
        config: &MapConfig,
        cells: &Places,
    ) -> Result<Self> {
        if run.len() != places.len() || activation.nrows() != places.len() {
            return Err(Error::work(format!(
                "expected error: {} runs and {} answers for {} places",
                run.len(),
                activation.nrows(),
                places.len()
            )));
        }
        let mapped = |which: &[usize], k: usize| {
            let mut config = config.clone();
            config.nearness.k = k.min(which.len());
            let places = places.select(which);
            let near = Neighbours::find(&places, cells, &config.nearness)?;
            let activation = activation.select(Axis(0), which);
            let map = FeatureMap::new(places, activation, config)?.from_neighbours(&near)?;
            let is_mapped: Vec<bool> = (0..near.len()).map(|c| near.is_mapped(c)).collect();
            Ok::<_, Error>((map, is_mapped))
        };
        let pair = |own: &[usize], others: &[usize]| {
            let (answers, here) = mapped(own, 1)?;
            let (map, there) = mapped(others, config.nearness.k)?;
            let seen_twice = here.iter().zip(&there).map(|(here, there)| *here && *there);
            Ok::<_, Error>(Pair {
                seen_twice: seen_twice.collect(),
                answers,
                map,
            })
        };
        let runs: BTreeSet<usize> = run.iter().copied().collect();
        let mut pairs = Vec::new();
        for number in runs {
            let (own, others): (Vec<usize>, Vec<usize>) =
                (0..run.len()).partition(|&k| run[k] == number);
            if others.is_empty() {
                break; // a single run
            }
            pairs.push(pair(&own, &others)?);
        }
        pairs.retain(|pair| pair.seen_twice.contains(&true));
        if pairs.is_empty() {
            let all: Vec<usize> = (0..run.len()).collect();
            pairs.push(pair(&all, &all)?);
        }
        Ok(Self { pairs })
    }

    /// [`expected_information_bits`](super::expected_information::expected_information_bits), over the same places and runs as
    /// [`expected_posterior_error_m`](Self::expected_posterior_error_m).
    ///
    /// # Errors
    /// Where the belief is over other cells.
    pub fn expected_information_bits(
        &self,
        belief: &Belief,
        approximation: Approximation,
        stream: &mut Stream,
    ) -> Result<f64> {
        self.mean(belief, &mut |answers, map, is_truth| {
            information(belief, answers, map, is_truth, approximation, stream)
        })
    }

    /// [`expected_posterior_error_m`](super::expected_posterior_error::expected_posterior_error_m) over the places that a run and
    /// another have been to, each run for as much of the belief as lies there; over all places alike where none of it does.
    ///
    /// # Errors
    /// Where the belief is over other cells.
    pub fn expected_posterior_error_m(
        &self,
        belief: &Belief,
        approximation: Approximation,
        stream: &mut Stream,
    ) -> Result<f64> {
        self.mean(belief, &mut |answers, map, is_truth| {
            over_truths(belief, answers, map, is_truth, approximation, stream)
        })
    }

    /// The mean of a sum over places ξ* where the robot may truly be, `of(answers, map, which places)` with the mass of these.
    fn mean(&self, belief: &Belief, of: &mut Sum<'_>) -> Result<f64> {
        let (mut sum, mut mass) = (0.0, 0.0);
        for pair in &self.pairs {
            check_cells(belief, &pair.answers, &pair.map)?;
            let (s, m) = of(&pair.answers, &pair.map, &|cell| pair.seen_twice[cell]);
            (sum, mass) = (sum + s, mass + m);
        }
        if mass > NO_PART {
            return Ok(sum / mass);
        }
        let each = self.pairs.iter();
        let sums = each.map(|pair| of(&pair.answers, &pair.map, &|_| true).0);
        Ok(sums.sum::<f64>() / self.pairs.len() as f64)
    }
}

/// A sum over some places, and their mass.
type Sum<'a> = dyn FnMut(&GridMap, &GridMap, &dyn Fn(usize) -> bool) -> (f64, f64) + 'a;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::seed::Seed;
    use ndarray::array;
    use std::sync::Arc;

    /// Features that tell the places of their own run apart and nothing else: by their own map they promise all, held apart nothing.
    #[test]
    fn what_was_learned_by_heart_promises_nothing_once_runs_are_held_apart() {
        let route: Vec<f64> = (0..40).map(|k| f64::from(k % 20)).collect();
        let places = Places::Route(route);
        let run: Vec<usize> = (0..40).map(|k| usize::from(k >= 20)).collect();
        let by_heart = Array2::from_shape_fn((40, 5), |(k, i)| match k < 20 {
            true => f64::from(u8::from(k >> i & 1 == 1)),
            false => f64::from(u8::from((k * 7 + 3) >> i & 1 == 1)),
        });
        let config = MapConfig {
            nearness: crate::belief::Nearness {
                k: 1,
                ..Default::default()
            },
            ..MapConfig::default()
        };
        let cells = Places::Route((0..20).map(f64::from).collect());
        let lost = Belief::uniform(&Arc::new(cells.clone())).unwrap();
        let of = |run: &[usize]| {
            let apart = HeldApart::new(&places, &by_heart, run, &config, &cells).unwrap();
            let mut stream = Seed(1).stream("features");
            apart
                .expected_posterior_error_m(&lost, Approximation::default(), &mut stream)
                .unwrap()
        };
        let first = HeldApart::new(
            &places.select(&(0..20).collect::<Vec<_>>()),
            &by_heart.select(Axis(0), &(0..20).collect::<Vec<_>>()),
            &[0; 20],
            &config,
            &cells,
        );
        let mut stream = Seed(1).stream("features");
        let own = first
            .unwrap()
            .expected_posterior_error_m(&lost, Approximation::default(), &mut stream)
            .unwrap();
        assert!(own < 0.5, "{own}");
        assert!(of(&run) > 5.0, "{}", of(&run));
    }

    #[test]
    fn not_one_run_a_snapshot_is_refused() {
        let places = Places::Route(vec![0.0, 1.0]);
        let config = MapConfig::default();
        let fault = HeldApart::new(&places, &array![[0.5], [0.5]], &[0], &config, &places);
        assert!(fault.unwrap_err().to_string().contains("1 runs"));
    }
}
