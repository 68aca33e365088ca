//! What a generated building draws from its streams: numbers of a range, one of several, yes or no, a count.

use crate::seed::Stream;
use rand::RngExt;
use rand_distr::StandardNormal;

/// A stream, and the kinds of draws that a building is made of.
pub(super) struct Chance(pub(super) Stream);

impl Chance {
    /// A number drawn evenly from a range.
    pub(super) fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.0.random::<f64>()
    }

    /// Yes, with this probability.
    pub(super) fn yes(&mut self, probability: f64) -> bool {
        self.0.random::<f64>() < probability
    }

    /// A whole number below `count`, which is more than 0.
    pub(super) fn below(&mut self, count: usize) -> usize {
        self.0.random_range(0..count.max(1))
    }

    /// One of several, each as likely; there is at least one.
    pub(super) fn one_of<T: Copy>(&mut self, all: &[T]) -> T {
        all[self.below(all.len())]
    }

    /// A number of a normal distribution of mean 0 and standard deviation 1.
    pub(super) fn normal(&mut self) -> f64 {
        self.0.sample(StandardNormal)
    }

    /// How many of something there are where `mean` are expected: a Poisson process, one gap after another.
    pub(super) fn count(&mut self, mean: f64) -> usize {
        let mut count = 0;
        let mut until = -(1.0 - self.0.random::<f64>()).ln();
        while until < mean {
            count += 1;
            until -= (1.0 - self.0.random::<f64>()).ln();
        }
        count
    }
}
