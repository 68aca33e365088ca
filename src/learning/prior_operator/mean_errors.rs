//! How far off a robot is before sensing: the same sums as the objective's, over rows of ones.

use super::{Answers, Asking, CHUNK, PriorOperator, Rows, Scratch};
use crate::learning::lanes::{Kernel, Lanes, Vectors};
use ndarray::Array1;
use rayon::prelude::*;

impl PriorOperator {
    /// The mean of e over the candidates that every truth's prior admits.
    pub(super) fn mean_errors(&self) -> Array1<f64> {
        let ones = vec![Lanes::all(1.0); self.candidates];
        let rows_of = |weighted| Rows {
            tiles: 1,
            weighted,
            unweighted: None,
        };
        let (mut scratch, vectors) = (Scratch::default(), Vectors::Best);
        let to_take_in = self.take_in_map(1, &mut scratch).into_par_iter();
        let chunks = to_take_in.zip(ones.par_chunks(CHUNK));
        chunks.for_each(|(mut accumulate, ones)| accumulate.chunk(&rows_of(ones), vectors));
        let rows = rows_of(&ones[..]);
        self.prepare(Asking::Truths, &rows, &mut scratch, vectors);
        let mut in_order = vec![0.0; self.truths];
        let chunks = in_order.par_chunks_mut(CHUNK).enumerate();
        chunks.for_each(|(chunk, out)| {
            vectors.run(MeanErrors {
                prior: self,
                first: chunk * CHUNK,
                rows: &rows,
                scratch: &scratch,
                out,
            });
        });
        let mut means = Array1::zeros(self.truths);
        for (place, mean) in in_order.into_iter().enumerate() {
            means[self
                .order(Asking::Truths)
                .map_or(place, |order| order[place])] = mean;
        }
        means
    }
}

/// The mean errors of a chunk of truths; of rows of ones.
struct MeanErrors<'a> {
    prior: &'a PriorOperator,
    first: usize,
    rows: &'a Rows<'a, f64>,
    scratch: &'a Scratch<f64>,
    out: &'a mut [f64],
}

impl Kernel for MeanErrors<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let places = self.first..self.first + self.out.len();
        let mut answers = Answers::new();
        let asking = Asking::Truths;
        self.prior
            .answer(asking, places, 0, self.rows, self.scratch, &mut answers);
        for (place, out) in self.out.iter_mut().enumerate() {
            let (error, unweighted) = (answers.weighted[place][0], answers.unweighted[place][0]);
            *out = error.max(0.0) / unweighted.max(1.0);
        }
    }
}
