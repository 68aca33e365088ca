//! The detector that learns nothing: signs of random projections of the inputs. What learning buys is judged against it.

use super::{
    Detector,
    input::Input,
    net::{Layer, NetConfig, Weights},
};
use crate::{error::Result, recording::Channel, seed::Seed};
use ndarray::{Array2, ArrayView2, Axis};
use rand_distr::{Distribution, StandardNormal};

/// A bit is never quite certain, so that every detector answers in (0, 1).
const DOUBT: f32 = 1e-3;

/// What sigmoid units multiply their sums by to be sides of planes: inputs have a deviation of 1 each.
const DECIDED: f32 = 50.0;

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

    /// The same as networks of one layer, whose answers are as decided.
    pub fn weights(&self) -> Weights {
        let features = self.planes.ncols();
        let weight = self.planes.t().mapv(|w| DECIDED * w);
        Weights {
            layers: vec![Layer {
                weight: weight
                    .as_standard_layout()
                    .into_owned()
                    .insert_axis(Axis(2)),
                bias: Array2::zeros((features, 1)),
            }],
            convolutions: Vec::new(),
            trunk: 0,
            activation: NetConfig::single_layer().activation, // of hidden units, of which there are none
        }
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        detector::{device, input::InputConfig, net::NetDetector},
        world::corridor::{CorridorConfig, thrun1998},
    };

    #[test]
    fn networks_of_one_layer_answer_as_the_planes_do() {
        let config = CorridorConfig {
            runs: 1,
            spacing_m: 0.5,
        };
        let recording = thrun1998(Seed(1), &config).unwrap();
        let all: Vec<usize> = (0..recording.len()).collect();
        let input = Input::fit(&InputConfig::default(), &recording, &all).unwrap();
        let projection = RandomProjection::new(input.clone(), 12, Seed(3));
        let networks = NetDetector::new(input, &projection.weights(), &device::cpu());
        let [bits, answers] = [
            projection.probabilities(&recording).unwrap(),
            networks.probabilities(&recording).unwrap(),
        ];
        let different = bits.iter().zip(&answers);
        let different = different.filter(|(bit, answer)| bit.round() != answer.round());
        assert!(different.count() * 1000 <= bits.len());
        let undecided = answers.iter().filter(|g| (0.1..0.9).contains(*g)).count();
        assert!(undecided * 20 < answers.len(), "{undecided}");
    }
}
