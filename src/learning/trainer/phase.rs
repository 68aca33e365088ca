//! Which networks learn now: all of them, or one after another (Thrun 1998, 4.4.2 item 1).
//!
//! In sequential training feature i learns with the features before it, which stay as they are; those after it do not
//! exist yet. The objective then has 2^i outcomes and not 2^n, and only one network is carried forward and back. The
//! steps are dealt evenly among the features.

use crate::{detector::net::Nets, learning::recipe::Recipe};
use burn::tensor::Tensor;
use std::ops::Range;

/// A part of a training in which the same networks learn.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Phase {
    /// Those that learn; the ones before them are frozen, the ones after them not there yet.
    pub learners: Range<usize>,
    /// The phase's first step.
    pub first_step: usize,
    /// Is it the last one?
    pub is_last: bool,
}

impl Phase {
    /// The phase that step `step` is of; after the last step, that of the last one.
    pub fn at(recipe: &Recipe, step: usize) -> Self {
        let n = recipe.features;
        if !recipe.descent.sequential {
            return Self {
                learners: 0..n,
                first_step: 0,
                is_last: true,
            };
        }
        let first_step = |feature: usize| feature * recipe.descent.steps / n;
        let feature = (0..n).rev().find(|&i| first_step(i) <= step).unwrap_or(0);
        Self {
            learners: feature..feature + 1,
            first_step: first_step(feature),
            is_last: feature + 1 == n,
        }
    }

    /// Number of a step in its series of steps on one evaluation, and the step that the series began with.
    pub fn place_in_series(&self, recipe: &Recipe, step: usize) -> (usize, usize) {
        let place = (step - self.first_step) % recipe.descent.pseudo_pattern_steps;
        (place, step - place)
    }
}

/// Some of the networks, by number; the same tensors where it is all of them. Only networks without a trunk come apart.
pub fn of_features(nets: &Nets, features: Range<usize>) -> Nets {
    let all = nets.weight.last().map_or(0, |weight| weight.dims()[0]);
    if features == (0..all) {
        return nets.clone();
    }
    let part = |tensors: &[Tensor<3>]| {
        let one = |t: &Tensor<3>| t.clone().slice([features.clone()]);
        tensors.iter().map(one).collect()
    };
    Nets {
        weight: part(&nets.weight),
        bias: part(&nets.bias),
        ..nets.clone()
    }
}

/// Puts networks in the place of some of all, whose bits are not touched elsewhere.
pub fn put_features(all: &mut Nets, features: Range<usize>, part: Nets) {
    let put = |all: &mut Vec<Tensor<3>>, part: Vec<Tensor<3>>| {
        for (all, part) in all.iter_mut().zip(part) {
            let dims = all.dims();
            *all = match part.dims() == dims {
                true => part,
                false => {
                    let place = [features.clone(), 0..dims[1], 0..dims[2]];
                    all.clone().slice_assign(place, part)
                }
            };
        }
    };
    put(&mut all.weight, part.weight);
    put(&mut all.bias, part.bias);
}
