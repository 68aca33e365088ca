//! The detector that learns nothing: signs of random projections of the inputs. What learning buys is judged against it.

use super::{Detector, input::Input};
use crate::{error::Result, recording::Channel, seed::Seed};
use ndarray::{Array2, ArrayView2};
use rand_distr::{Distribution, StandardNormal};

/// A bit is never quite certain, so that every detector answers in (0, 1).
const DOUBT: f32 = 1e-3;

/// Which side of n random planes through the mean the inputs lie on.
pub struct RandomProjection {
    input: Input,
    /// `[input, feature]`
    planes: Array2<f32>,
}

impl RandomProjection {
    /// Planes of normally distributed direction, from the seed's stream "random planes".
    pub fn new(input: Input, features: usize, seed: Seed) -> Self {
        let mut random = seed.stream("random planes");
        let planes = Array2::from_shape_simple_fn((input.width(), features), || {
            StandardNormal.sample(&mut random)
        });
        Self { input, planes }
    }
}

impl Detector for RandomProjection {
    fn features(&self) -> usize {
        self.planes.ncols()
    }

    fn detect_batch(&self, channels: &[Channel], values: ArrayView2<f32>) -> Result<Array2<f32>> {
        let sides = self
            .input
            .transform_values(channels, values)?
            .dot(&self.planes);
        Ok(sides.mapv(|side| if side > 0.0 { 1.0 - DOUBT } else { DOUBT }))
    }
}
