use super::*;
use crate::{
    detector::{
        device::cpu,
        input::{InputShape, ScanShape},
        net::{Activation, ConvolutionConfig, NetConfig, Nets, values},
    },
    seed::Seed,
};
use burn::tensor::{Tensor, TensorData};
use ndarray::Array2;
use rand::RngExt;

fn networks(activation: Activation, ring: bool) -> (Weights, Array2<f32>, Array2<f32>) {
    let layer = |channels, width, stride| ConvolutionConfig {
        channels,
        width,
        stride,
    };
    let config = NetConfig {
        convolutions: vec![layer(6, 3, 1), layer(5, 3, 2)],
        trunk: vec![7],
        activation,
        ..NetConfig::default()
    };
    let inputs = InputShape {
        width: 22,
        scan: Some(ScanShape {
            statistics: 2,
            sectors: 11,
            ring,
        }),
    };
    let mut random = Seed(7).stream("layered");
    let weights = Weights::random(&config, inputs, 4, &mut random);
    // More than a share, and not a whole number of shares.
    let mut draw = |columns| {
        Array2::from_shape_simple_fn((2 * SHARE + 9, columns), || {
            random.random_range(-1.0..1.0f32)
        })
    };
    (weights, draw(22), draw(4))
}

/// The same on tensors: answers, then ∂E/∂weight of every layer, then ∂E/∂bias.
fn on_tensors(weights: &Weights, inputs: &Array2<f32>, slope: &Array2<f32>) -> Vec<Vec<f32>> {
    let device = cpu().autodiff();
    let tensor = |a: &Array2<f32>| {
        let data = TensorData::new(
            a.iter().copied().collect::<Vec<f32>>(),
            [a.nrows(), a.ncols()],
        );
        Tensor::<2>::from_data(data, &device)
    };
    let mut nets = Nets::new(weights, &device);
    let tracked = |t: &Tensor<3>| t.clone().require_grad();
    nets.weight = nets.weight.iter().map(tracked).collect();
    nets.bias = nets.bias.iter().map(tracked).collect();
    let out = nets.forward(tensor(inputs));
    let mut all = vec![values(out.clone().inner()).unwrap()];
    let mut gradients = (out * tensor(slope)).sum().backward();
    for parameter in nets.weight.iter().chain(&nets.bias) {
        all.push(values(parameter.grad_remove(&mut gradients).unwrap()).unwrap());
    }
    all
}

#[test]
fn answers_and_gradients_are_those_of_tensors() {
    for (activation, ring) in [
        (Activation::Relu, false),
        (Activation::Tanh, true),
        (Activation::Sigmoid, false),
    ] {
        let (weights, inputs, slope) = networks(activation, ring);
        let mut layered = Layered::default();
        let mut out = Array2::zeros((inputs.nrows(), 4));
        // Twice, the second time with fewer snapshots' memory still there.
        let few = inputs.slice_axis(Axis(0), (0..5).into());
        let of_few = out.slice_axis_mut(Axis(0), (0..5).into());
        layered.forward(&weights, few, of_few).unwrap();
        layered
            .forward(&weights, inputs.view(), out.view_mut())
            .unwrap();
        let mut gradient = weights.clone();
        layered
            .backward(&weights, slope.view(), &mut gradient)
            .unwrap();
        let mut found = vec![out.iter().copied().collect::<Vec<f32>>()];
        found.extend(
            gradient
                .layers
                .iter()
                .map(|l| l.weight.iter().copied().collect()),
        );
        found.extend(
            gradient
                .layers
                .iter()
                .map(|l| l.bias.iter().copied().collect()),
        );
        let expected = on_tensors(&weights, &inputs, &slope);
        for (which, (found, expected)) in found.iter().zip(&expected).enumerate() {
            assert_eq!(found.len(), expected.len(), "{which}");
            let largest = expected.iter().fold(1e-3f32, |most, e| most.max(e.abs()));
            for (f, e) in found.iter().zip(expected) {
                assert!(
                    (f - e).abs() < 1e-4 * largest,
                    "{activation:?} {which}: {f} {e}"
                );
            }
        }
    }
}

#[test]
fn shapes_that_do_not_fit_are_refused() {
    let (weights, inputs, slope) = networks(Activation::Relu, false);
    let mut layered = Layered::default();
    let mut narrow = Array2::zeros((inputs.nrows(), 3));
    let fault = layered
        .forward(&weights, inputs.view(), narrow.view_mut())
        .unwrap_err();
    assert!(fault.to_string().contains("expected (137, 4)"), "{fault}");
    let mut gradient = weights.clone();
    assert!(
        layered
            .backward(&weights, slope.view(), &mut gradient)
            .is_err()
    ); // no forward
    let mut own = weights.clone();
    own.trunk -= 1;
    assert!(!Layered::fits(&own));
}
