//! The activations that the objective is given.

use super::MAX_FEATURES;
use crate::{
    error::{Error, Result},
    learning::prior_operator::PriorOperator,
};
use ndarray::{ArrayRef2, ArrayView1, ArrayView2};

/// Activations g of one side's places, `[place, feature]`.
#[derive(Clone, Copy)]
pub(super) struct Activations<'a, T> {
    g: &'a [T],
    pub features: usize,
    /// The operator's order of the places.
    pub order: Option<&'a [usize]>,
}

impl<'a, T> Activations<'a, T> {
    /// Of an array in standard layout.
    pub(super) fn new(g: &'a ArrayRef2<T>, order: Option<&'a [usize]>) -> Self {
        Self {
            g: g.as_slice().unwrap_or_default(), // a standard layout is a slice
            features: g.ncols(),
            order,
        }
    }

    /// The caller's number of place `place` in order.
    #[inline(always)]
    pub(super) fn number(&self, place: usize) -> usize {
        match self.order {
            Some(order) => order[place],
            None => place,
        }
    }

    /// All features of place `place` in order.
    #[inline(always)]
    pub(super) fn row(&self, place: usize) -> &'a [T] {
        let k = self.number(place);
        &self.g[k * self.features..(k + 1) * self.features]
    }
}

/// Do they fit the prior?
pub(super) fn check<T>(
    prior: &PriorOperator,
    truth: ArrayView2<T>,
    map: ArrayView2<T>,
    weight: ArrayView1<f64>,
) -> Result<()> {
    let n = truth.ncols();
    if n == 0 {
        return Err(Error::work(
            "objective: activations of no feature; expected at least one",
        ));
    }
    if n > MAX_FEATURES {
        return Err(Error::work(format!(
            "{n} features have 2^{n} outcomes; the exact objective takes at most {MAX_FEATURES}"
        )));
    }
    let expected = [(prior.truths(), n), (prior.candidates(), n)];
    if [truth.dim(), map.dim()] != expected || weight.len() != prior.truths() {
        return Err(Error::work(format!(
            "objective: activations of {:?} truths and {:?} places of the map with {} weights; expected {:?}, {:?} and {}",
            truth.dim(),
            map.dim(),
            weight.len(),
            expected[0],
            expected[1],
            prior.truths()
        )));
    }
    Ok(())
}
