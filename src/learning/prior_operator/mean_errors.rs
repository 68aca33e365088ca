//! The expected error before sensing: the same sums as the objective's, over rows of ones.

use super::{
    rows::{CHUNK, Rows},
    shape::Shape,
    workspace::{PriorSums, Scratch},
};
use crate::{
    learning::lanes::Lanes,
    simd::{InstructionSet, Kernel},
};
use ndarray::Array1;
use rayon::prelude::*;

/// The mean of e over the candidates that every truth's prior admits, in metres.
pub(super) fn mean_errors_m(shape: &Shape) -> Array1<f64> {
    let (truths, candidates) = shape.counts();
    let ones = vec![Lanes::all(1.0); candidates];
    let rows_of = |weighted| Rows {
        tiles: 1,
        weighted,
        unweighted: None,
    };
    let (mut scratch, instructions) = (Scratch::default(), InstructionSet::Best);
    let accumulators = shape.map_accumulators(1, &mut scratch).into_par_iter();
    let chunks = accumulators.zip(ones.par_chunks(CHUNK));
    chunks.for_each(|(mut accumulator, ones)| accumulator.add(&rows_of(ones), instructions));
    let rows = rows_of(&ones[..]);
    shape.prepare(&rows, &mut scratch, instructions);
    let mut in_order = vec![0.0; truths];
    let chunks = in_order.par_chunks_mut(CHUNK).enumerate();
    chunks.for_each(|(chunk, out)| {
        instructions.run(MeanErrors {
            shape,
            first: chunk * CHUNK,
            rows: &rows,
            scratch: &scratch,
            out,
        });
    });
    let mut means = Array1::zeros(truths);
    for (place, mean) in in_order.into_iter().enumerate() {
        means[shape.truth_order().map_or(place, |order| order[place])] = mean;
    }
    means
}

/// The mean errors of a chunk of truths; of rows of ones.
struct MeanErrors<'a> {
    shape: &'a Shape,
    first: usize,
    rows: &'a Rows<'a, f64>,
    scratch: &'a Scratch<f64>,
    out: &'a mut [f64],
}

impl Kernel for MeanErrors<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let truths = self.first..self.first + self.out.len();
        let mut sums = PriorSums::new();
        self.shape
            .apply(truths, 0, self.rows, self.scratch, &mut sums);
        for (place, out) in self.out.iter_mut().enumerate() {
            let (error, count) = (sums.weighted[place][0], sums.unweighted[place][0]);
            *out = error.max(0.0) / count.max(1.0);
        }
    }
}
