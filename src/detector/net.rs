//! The learned detector: n small networks, one a feature, as stochastic filters (Thrun 1998, 4.1–4.2, 5.1.4).
//!
//! Thrun's networks share nothing but their inputs. Wide codes of dozens of features may stand on a common *trunk* of
//! layers instead, with a small network of its own for each feature on top. The first layers of a trunk may be
//! [convolutions](Convolution) over the sectors of a scan, which look for the same thing in every direction.

mod config;
mod convolution;
mod layered;
mod nets;
mod weights;

pub use config::{Activation, NetConfig};
pub use convolution::{Convolution, ConvolutionConfig};
pub use layered::Layered;
pub use nets::{Nets, values};
pub use weights::{Layer, Weights};

use super::{Detector, input::Input};
use crate::{
    error::{Error, Result},
    recording::Channel,
};
use burn::tensor::{Device, Tensor, TensorData};
use ndarray::{Array2, ArrayView2, Axis};
use rayon::prelude::*;

/// Snapshots that networks answer at once.
pub(crate) const AT_ONCE: usize = 2048;

/// The learned detector: preprocessing and networks together.
pub struct NetDetector {
    input: Input,
    nets: Nets,
    inputs: usize,
    features: usize,
    device: Device,
}

impl NetDetector {
    /// A detector on a device.
    pub fn new(input: Input, weights: &Weights, device: &Device) -> Self {
        Self {
            input,
            nets: Nets::new(weights, device),
            inputs: weights.inputs(),
            features: weights.features(),
            device: device.clone(),
        }
    }

    /// g_i of normalised inputs, `[snapshot, input]` → `[snapshot, feature]`.
    ///
    /// # Errors
    /// Where there are not as many inputs as the networks have, or the device fails to give its numbers back.
    pub fn respond(&self, input: ArrayView2<f32>) -> Result<Array2<f32>> {
        if input.ncols() != self.inputs {
            return Err(Error::work(format!(
                "networks: {} inputs a snapshot; expected {}",
                input.ncols(),
                self.inputs
            )));
        }
        // Some at a time: what stands between the layers takes more than inputs and outputs.
        let some: Vec<_> = input.axis_chunks_iter(Axis(0), AT_ONCE).collect();
        let answers = some
            .into_par_iter()
            .map(|input| self.respond_at_once(input));
        let answers = answers.collect::<Result<Vec<_>>>()?;
        let out = answers.concat();
        Array2::from_shape_vec((input.nrows(), self.features), out)
            .map_err(|e| Error::work(format!("network output: {e}")))
    }

    fn respond_at_once(&self, input: ArrayView2<f32>) -> Result<Vec<f32>> {
        let shape = [input.nrows(), input.ncols()];
        let data = TensorData::new(input.iter().copied().collect::<Vec<f32>>(), shape);
        values(self.nets.forward(Tensor::from_data(data, &self.device)))
    }
}

impl Detector for NetDetector {
    fn features(&self) -> usize {
        self.features
    }

    fn detect_batch(&self, channels: &[Channel], values: ArrayView2<f32>) -> Result<Array2<f32>> {
        self.respond(self.input.transform_values(channels, values)?.view())
    }
}
