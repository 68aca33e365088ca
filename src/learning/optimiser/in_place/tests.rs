//! Do stacked networks and plain arrays walk the same way as Burn's tensors?

use super::*;
use crate::{
    detector::{
        net::{Activation, NetConfig},
        stacked::Stacked,
    },
    seed::Seed,
};
use burn::tensor::Device;
use ndarray::{Array2, ArrayView2};
use rand::RngExt;

const SNAPSHOTS: usize = 70;
const INPUTS: usize = 13;
const FEATURES: usize = 3;

fn numbers(rows: usize, columns: usize, stream: &str) -> Array2<f32> {
    let mut random = Seed(3).stream(stream);
    Array2::from_shape_simple_fn((rows, columns), || random.random_range(-1.0..1.0))
}

fn weights(hidden: &[usize], activation: Activation) -> Weights {
    let config = NetConfig {
        hidden: hidden.to_vec(),
        activation,
        ..NetConfig::thrun1998()
    };
    Weights::random(&config, INPUTS, FEATURES, &mut Seed(4).stream("weights"))
}

fn on_device(array: ArrayView2<f32>) -> Tensor<2> {
    let values: Vec<f32> = array.iter().copied().collect();
    Tensor::from_data(
        TensorData::new(values, [array.nrows(), array.ncols()]),
        &Device::flex(),
    )
}

/// Outputs, and gradients of Σ slope ∘ g by Burn's tape.
fn by_tape(nets: &Nets, inputs: ArrayView2<f32>, slope: ArrayView2<f32>) -> (Vec<f32>, Nets) {
    let tracked = |t: &Tensor<3>| Tensor::from_inner(t.clone()).require_grad();
    let mut leaves = nets.clone();
    leaves.weight = nets.weight.iter().map(tracked).collect();
    leaves.bias = nets.bias.iter().map(tracked).collect();
    let output = leaves.forward(Tensor::from_inner(on_device(inputs)));
    let outputs = values(output.clone().inner()).unwrap();
    let mut gradients = (output * Tensor::from_inner(on_device(slope)))
        .sum()
        .backward();
    let mut take = |t: &Tensor<3>| t.grad_remove(&mut gradients).unwrap();
    leaves.weight = leaves.weight.iter().map(&mut take).collect();
    leaves.bias = leaves.bias.iter().map(&mut take).collect();
    (outputs, leaves)
}

/// Largest difference, in units of the largest number.
#[track_caller]
fn assert_close(ours: &[f32], theirs: &[f32], tolerance: f32, what: &str) {
    assert_eq!(ours.len(), theirs.len());
    let scale = theirs.iter().fold(f32::MIN_POSITIVE, |m, x| m.max(x.abs()));
    let worst = ours
        .iter()
        .zip(theirs)
        .map(|(a, b)| (a - b).abs() / scale)
        .fold(0.0, f32::max);
    assert!(
        worst <= tolerance,
        "{what}: {worst} of the largest, {scale}"
    );
}

#[track_caller]
fn assert_same_way(ours: &Weights, theirs: &Weights, tolerance: f32, what: &str) {
    let (ours, theirs) = (parameters_of(ours).unwrap(), parameters_of(theirs).unwrap());
    for (at, (a, b)) in ours.into_iter().zip(theirs).enumerate() {
        assert_close(a, b, tolerance, &format!("{what}, parameter {at}"));
    }
}

#[test]
fn stacked_networks_have_the_outputs_and_gradients_of_burn() {
    let inputs = numbers(SNAPSHOTS, INPUTS, "inputs");
    let slope = numbers(SNAPSHOTS, FEATURES, "slope");
    for activation in [Activation::Sigmoid, Activation::Tanh, Activation::Relu] {
        for hidden in [&[][..], &[5], &[6, 4]] {
            let what = format!("{activation:?} {hidden:?}");
            let weights = weights(hidden, activation);
            let (outputs, leaves) = by_tape(
                &Nets::new(&weights, &Device::flex()),
                inputs.view(),
                slope.view(),
            );
            let mut stacked = Stacked::new(&weights);
            let mut out = Array2::zeros((SNAPSHOTS, FEATURES));
            let mut gradient = weights.clone();
            stacked
                .forward(&weights, inputs.view(), None, out.view_mut())
                .unwrap();
            stacked
                .backward(inputs.view(), None, slope.view(), &mut gradient)
                .unwrap();
            assert_close(out.as_slice().unwrap(), &outputs, 1e-6, &what);
            assert_same_way(&gradient, &leaves.weights().unwrap(), 2e-6, &what);
        }
    }
}

#[test]
fn steps_are_those_of_the_descent_on_tensors() {
    for optimiser in [Optimiser::Adam, Optimiser::Momentum] {
        let config = DescentConfig {
            optimiser,
            ..Default::default()
        };
        let mut ours = weights(&[5], Activation::Sigmoid);
        let mut nets = Nets::new(&ours, &Device::flex());
        let (mut in_place, mut descent) = (InPlace::new(&config), Descent::new(&config));
        for step in 0..30u64 {
            // Halfway both go on with the other's memory.
            if step == 15 {
                (in_place, descent) = (InPlace::after(&descent).unwrap(), in_place.descent(&nets));
            }
            let mut random = Seed(step).stream("gradient");
            let config = NetConfig {
                hidden: vec![5],
                ..NetConfig::thrun1998()
            };
            let gradient = Weights::random(&config, INPUTS, FEATURES, &mut random);
            in_place.step(&mut ours, &gradient).unwrap();
            let slopes = Nets::new(&gradient, &Device::flex());
            let parameters = nets.weight.iter().chain(&nets.bias).cloned().collect();
            let slopes = slopes.weight.into_iter().chain(slopes.bias).collect();
            let mut moved = descent.step(parameters, slopes);
            nets.bias = moved.split_off(nets.weight.len());
            nets.weight = moved;
        }
        assert_eq!(in_place.steps, 30);
        assert_eq!(descent.steps, 30);
        assert_same_way(
            &ours,
            &nets.weights().unwrap(),
            1e-6,
            &format!("{optimiser:?}"),
        );
    }
}

#[test]
fn a_gradient_of_another_shape_is_refused() {
    let mut ours = weights(&[5], Activation::Sigmoid);
    let other = weights(&[6], Activation::Sigmoid);
    let message = InPlace::new(&DescentConfig::default())
        .step(&mut ours, &other)
        .unwrap_err()
        .to_string();
    assert!(message.contains("differ in shape"), "{message}");
}
