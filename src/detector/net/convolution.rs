//! Convolutions over the sectors of a scan: the same small window of weights in every direction.

use burn::tensor::{Int, Tensor, TensorData};
use serde::{Deserialize, Serialize};

/// A layer of convolutions, as data.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ConvolutionConfig {
    /// Numbers that it finds in every direction.
    pub channels: usize,
    /// Directions that each is found from, side by side; an odd number.
    pub width: usize,
    /// Directions from one output to the next.
    pub stride: usize,
}

/// A layer of convolutions over inputs of a certain size.
///
/// Its weights are those of a dense layer of `width · inputs` inputs, tap by tap and each tap channel by channel, which is
/// applied in every direction alike. Past the first and the last direction of a scan the outermost one is repeated; a ring goes
/// round.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Convolution {
    /// Numbers that come in from every direction.
    pub inputs: usize,
    /// Directions that they come in from.
    pub positions: usize,
    /// Numbers that are found in every direction.
    pub outputs: usize,
    /// Directions that each is found from.
    pub width: usize,
    /// Directions from one output to the next.
    pub stride: usize,
    /// Whether the last direction lies beside the first.
    pub ring: bool,
}

impl Convolution {
    /// Can it be applied at all, and is what it works on no more than memory is for?
    pub(in crate::detector) fn is_sound(&self) -> bool {
        let counts = [
            self.inputs,
            self.positions,
            self.outputs,
            self.width,
            self.stride,
        ];
        counts
            .into_iter()
            .all(|count| (1..=100_000).contains(&count))
    }

    /// Directions that come out.
    pub fn positions_out(&self) -> usize {
        self.positions.div_ceil(self.stride)
    }

    /// The direction behind every tap of every output, `[position out, tap]`, one row after the other.
    pub fn sources(&self) -> Vec<usize> {
        let last = self.positions as i64 - 1;
        let source = |(out, tap): (usize, usize)| {
            let at = (out * self.stride + tap) as i64 - (self.width / 2) as i64;
            match self.ring {
                true => at.rem_euclid(last + 1) as usize,
                false => at.clamp(0, last) as usize,
            }
        };
        let outs = 0..self.positions_out();
        outs.flat_map(|out| (0..self.width).map(move |tap| (out, tap)))
            .map(source)
            .collect()
    }

    /// Sums of every direction, `[snapshot, position, input]` → `[snapshot, position out, output]`; `weight` is
    /// `[1, tap · input, output]`, `bias` `[1, 1, output]`.
    pub(super) fn forward(
        &self,
        input: Tensor<3>,
        weight: Tensor<3>,
        bias: Tensor<3>,
    ) -> Tensor<3> {
        let [snapshots, _, _] = input.dims();
        let sources: Vec<i64> = self.sources().into_iter().map(|at| at as i64).collect();
        let shape = [sources.len()];
        let sources = Tensor::<1, Int>::from_data(TensorData::new(sources, shape), &input.device());
        let taps = self.width * self.inputs;
        let patches = input
            .select(1, sources)
            .reshape([snapshots * self.positions_out(), taps]);
        let sums = patches.matmul(weight.squeeze_dim(0)) + bias.squeeze_dim(0);
        sums.reshape([snapshots, self.positions_out(), self.outputs])
    }
}

#[cfg(test)]
mod tests;
