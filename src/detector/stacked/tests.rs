//! Are stacked networks the networks that they stand for, whatever the shape, and the same with any number of threads?
//! (Beside Burn's automatic differentiation they stand in `learning::optimiser::in_place`.)

use super::*;
use crate::{detector::net::NetConfig, seed::Seed};
use ndarray::Array2;
use rand::RngExt;

const ALL: [Activation; 3] = [Activation::Sigmoid, Activation::Tanh, Activation::Relu];

fn weights(inputs: usize, hidden: &[usize], features: usize, activation: Activation) -> Weights {
    let config = NetConfig {
        hidden: hidden.to_vec(),
        activation,
        ..NetConfig::thrun1998()
    };
    Weights::random(&config, inputs, features, &mut Seed(2).stream("weights"))
}

fn numbers(rows: usize, columns: usize, stream: &str) -> Array2<f32> {
    let mut random = Seed(3).stream(stream);
    Array2::from_shape_simple_fn((rows, columns), || random.random_range(-1.0..1.0))
}

/// A network's outputs and gradient by hand in f64, a snapshot, a filter and a unit at a time.
fn by_hand(
    weights: &Weights,
    inputs: ArrayView2<f32>,
    slope: ArrayView2<f32>,
) -> (Array2<f64>, Vec<Vec<f64>>) {
    let features = weights.features();
    let mut out = Array2::zeros((inputs.nrows(), features));
    let layers = &weights.layers;
    let mut gradient: Vec<Vec<f64>> = layers
        .iter()
        .flat_map(|l| [vec![0.0; l.weight.len()], vec![0.0; l.bias.len()]])
        .collect();
    for (k, row) in inputs.outer_iter().enumerate() {
        for f in 0..features {
            let mut values: Vec<Vec<f64>> = vec![row.iter().map(|&x| f64::from(x)).collect()];
            for (at, layer) in layers.iter().enumerate() {
                let before = &values[at];
                let unit = |o: usize| {
                    let products = before
                        .iter()
                        .enumerate()
                        .map(|(i, x)| x * f64::from(layer.weight[[f, i, o]]));
                    let sum: f64 = products.sum::<f64>() + f64::from(layer.bias[[f, o]]);
                    match function_of(layers.len(), at, weights.activation) {
                        Activation::Sigmoid => 1.0 / (1.0 + (-sum).exp()),
                        Activation::Tanh => sum.tanh(),
                        Activation::Relu => sum.max(0.0),
                    }
                };
                let after = (0..layer.bias.ncols()).map(unit).collect();
                values.push(after);
            }
            out[[k, f]] = values[layers.len()][0];
            let mut back = vec![f64::from(slope[[k, f]])];
            for (at, layer) in layers.iter().enumerate().rev() {
                for (d, y) in back.iter_mut().zip(&values[at + 1]) {
                    *d *= match function_of(layers.len(), at, weights.activation) {
                        Activation::Sigmoid => y * (1.0 - y),
                        Activation::Tanh => 1.0 - y * y,
                        Activation::Relu => f64::from(u8::from(*y > 0.0)),
                    };
                }
                let (_, inputs, outputs) = layer.weight.dim();
                let mut before = vec![0.0; inputs];
                for o in 0..outputs {
                    gradient[2 * at + 1][f * outputs + o] += back[o];
                    for i in 0..inputs {
                        gradient[2 * at][(f * inputs + i) * outputs + o] += values[at][i] * back[o];
                        before[i] += back[o] * f64::from(layer.weight[[f, i, o]]);
                    }
                }
                back = before;
            }
        }
    }
    (out, gradient)
}

fn function_of(layers: usize, at: usize, hidden: Activation) -> Activation {
    if at + 1 == layers {
        Activation::Sigmoid
    } else {
        hidden
    }
}

fn stacked(
    weights: &Weights,
    inputs: ArrayView2<f32>,
    noise: Option<Noise>,
    slope: ArrayView2<f32>,
) -> (Array2<f32>, Weights) {
    let mut stacked = Stacked::new(weights);
    let mut out = Array2::from_elem(slope.dim(), f32::NAN);
    let mut gradient = weights.clone();
    // Twice, as what is kept from the first must not show in the second.
    for _ in 0..2 {
        stacked
            .forward(weights, inputs, noise, out.view_mut())
            .unwrap();
        stacked
            .backward(inputs, noise, slope, &mut gradient)
            .unwrap();
    }
    (out, gradient)
}

fn flat(weights: &Weights) -> Vec<Vec<f32>> {
    let layers = weights.layers.iter();
    layers
        .flat_map(|l| {
            [
                l.weight.iter().copied().collect(),
                l.bias.iter().copied().collect(),
            ]
        })
        .collect()
}

/// In units of the largest number.
#[track_caller]
fn assert_close(ours: &[f32], theirs: &[f64], tolerance: f64, what: &str) {
    assert_eq!(ours.len(), theirs.len(), "{what}");
    let largest = theirs.iter().fold(0.0f64, |m, x| m.max(x.abs()));
    for (a, b) in ours.iter().zip(theirs) {
        let off = (f64::from(*a) - b).abs();
        assert!(
            off <= tolerance * largest,
            "{what}: {a} for {b} of {largest}"
        );
    }
}

#[test]
fn any_shape_has_the_outputs_and_gradient_of_its_networks() {
    // Widths beside, at and past whole registers; snapshots beside and at whole blocks, chunks and shares.
    let shapes: [(usize, &[usize], usize); 7] = [
        (5, &[], 1),
        (16, &[], 3),
        (164, &[6], 4),
        (9, &[1], 2),
        (33, &[11], 7),
        (8, &[16], 8),
        (20, &[5, 3], 4),
    ];
    for (inputs, hidden, features) in shapes {
        for (activation, k) in ALL.into_iter().zip([75, 320, 701]) {
            let what = format!("{activation:?} {inputs} {hidden:?} × {features}, {k} snapshots");
            let weights = weights(inputs, hidden, features, activation);
            let (rows, slope) = (numbers(k, inputs, "inputs"), numbers(k, features, "slope"));
            let (out, gradient) = stacked(&weights, rows.view(), None, slope.view());
            let (expected, expected_gradient) = by_hand(&weights, rows.view(), slope.view());
            assert_close(
                out.as_slice().unwrap(),
                expected.as_slice().unwrap(),
                1e-6,
                &what,
            );
            for (ours, theirs) in flat(&gradient).iter().zip(&expected_gradient) {
                assert_close(ours, theirs, 3e-6, &what);
            }
        }
    }
}

#[test]
fn the_gradient_is_that_of_the_outputs() {
    // The hand-written reference itself is held to differences.
    for (at, activation) in ALL.into_iter().enumerate() {
        let mut moved = weights(4, &[3], 2, activation);
        let (rows, slope) = (numbers(9, 4, "inputs"), numbers(9, 2, "slope"));
        let (_, gradient) = by_hand(&moved, rows.view(), slope.view());
        let e = |weights: &Weights| {
            let (out, _) = by_hand(weights, rows.view(), slope.view());
            (out * slope.mapv(f64::from)).sum()
        };
        let start = moved.layers[0].weight[[1, 2, at]];
        // Powers of two, so that f32 weights are moved by just as much as is divided by.
        let mut along = |step: f32| {
            moved.layers[0].weight[[1, 2, at]] = start + step;
            (e(&moved), f64::from(start + step))
        };
        let ((up, right), (down, left)) = (along(1.0 / 1024.0), along(-1.0 / 1024.0));
        let difference = (up - down) / (right - left);
        let slope = gradient[0][4 * 3 + 2 * 3 + at];
        assert!(
            (difference - slope).abs() < 1e-5,
            "{activation:?}: {difference} for {slope}"
        );
    }
}

#[test]
fn noise_is_added_as_it_is_read() {
    let weights = weights(10, &[4], 2, Activation::Sigmoid);
    let (rows, slope) = (numbers(50, 10, "inputs"), numbers(50, 2, "slope"));
    let bank: Vec<f32> = numbers(1, 77, "noise").into_raw_vec_and_offset().0;
    let noise = Noise {
        bank: &bank,
        start: 70,
        deviation: 0.3,
    };
    let mut noisy = rows.clone();
    for (position, x) in noisy.iter_mut().enumerate() {
        *x += 0.3 * bank[(70 + position) % 77];
    }
    let fused = stacked(&weights, rows.view(), Some(noise), slope.view());
    let before = stacked(&weights, noisy.view(), None, slope.view());
    assert_eq!(fused, before);
    assert_ne!(fused, stacked(&weights, rows.view(), None, slope.view()));
}

#[test]
fn any_number_of_threads_gives_the_same_bits() {
    let weights = weights(40, &[6], 4, Activation::Sigmoid);
    let (rows, slope) = (numbers(3001, 40, "inputs"), numbers(3001, 4, "slope"));
    let with_threads = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
        pool.unwrap()
            .install(|| stacked(&weights, rows.view(), None, slope.view()))
    };
    let one = with_threads(1);
    assert_eq!(one, with_threads(2));
    assert_eq!(one, with_threads(4));
}

#[test]
fn saturated_units_stay_numbers_and_numbers_that_are_none_stay_none() {
    for activation in ALL {
        let mut weights = weights(3, &[4], 2, activation);
        for scale in [1e3, 1e20, 1e37] {
            let rows = numbers(40, 3, "inputs") * scale;
            let slope = Array2::ones((40, 2));
            let (out, gradient) = stacked(&weights, rows.view(), None, slope.view());
            assert!(
                out.iter().all(|g| (0.0..=1.0).contains(g)),
                "{activation:?} {scale}"
            );
            assert!(
                flat(&gradient).iter().flatten().all(|g| g.is_finite()),
                "{activation:?} {scale}"
            );
        }
        weights.layers[0].weight[[1, 0, 0]] = f32::NAN;
        let rows = numbers(2, 3, "inputs");
        let (out, _) = stacked(&weights, rows.view(), None, Array2::ones((2, 2)).view());
        assert!(
            out[[0, 1]].is_nan() && out[[1, 1]].is_nan(),
            "{activation:?}"
        );
    }
}

#[test]
fn units_are_right_to_the_last_digits() {
    // One unit without hidden ones, then one hidden unit whose slope near 0 shows tanh's small values.
    let mut one = weights(1, &[], 1, Activation::Sigmoid);
    one.layers[0].weight.fill(1.0);
    one.layers[0].bias.fill(0.0);
    let mut behind = weights(1, &[1], 1, Activation::Tanh);
    for layer in &mut behind.layers {
        layer.weight.fill(1.0);
        layer.bias.fill(0.0);
    }
    let rows = Array2::from_shape_fn((4001, 1), |(k, _)| (k as f32 - 2000.0) * 0.01);
    let slope = Array2::ones((4001, 1));
    let (sigmoid, _) = stacked(&one, rows.view(), None, slope.view());
    for (&x, &y) in rows.iter().zip(&sigmoid) {
        let expected = 1.0 / (1.0 + (-f64::from(x)).exp());
        assert!(
            (f64::from(y) / expected - 1.0).abs() < 3e-7,
            "σ({x}) = {y}, not {expected}"
        );
    }
    // ∂g/∂w of the output's weight is g (1 − g) tanh x: a single snapshot gives tanh x.
    for x in [-3.0f32, -0.4, -1e-3, 1e-6, 0.2, 0.7, 5.0] {
        let (out, gradient) = stacked(
            &behind,
            Array2::from_elem((1, 1), x).view(),
            None,
            Array2::ones((1, 1)).view(),
        );
        let g = out[[0, 0]];
        let tanh = f64::from(gradient.layers[1].weight[[0, 0, 0]] / (g * (1.0 - g)));
        let expected = f64::from(x).tanh();
        assert!(
            (tanh / expected - 1.0).abs() < 5e-7,
            "tanh({x}) = {tanh}, not {expected}"
        );
    }
}

#[test]
fn shapes_are_chosen_and_checked() {
    let fits = |inputs, hidden: &[usize], features| {
        Stacked::fits(&weights(inputs, hidden, features, Activation::Tanh))
    };
    assert!(fits(164, &[6], 4));
    assert!(fits(108, &[], 4));
    assert!(fits(164, &[6], 10));
    assert!(!fits(164, &[6], 256)); // nearly all zeros
    assert!(!fits(1000, &[100], 4)); // past the caches

    let weights = weights(5, &[3], 2, Activation::Sigmoid);
    let mut stacked = Stacked::new(&weights);
    let mut out = Array2::zeros((4, 2));
    let message = |result: Result<()>| result.unwrap_err().to_string();
    let wrong = stacked.forward(&weights, Array2::zeros((4, 6)).view(), None, out.view_mut());
    assert!(message(wrong).contains("inputs of shape (4, 6); expected (4, 5)"));
    let rows = Array2::zeros((4, 5));
    stacked
        .forward(&weights, rows.view(), None, out.view_mut())
        .unwrap();
    let mut gradient = weights.clone();
    let wrong = stacked.backward(
        rows.view(),
        None,
        Array2::zeros((3, 2)).view(),
        &mut gradient,
    );
    assert!(message(wrong).contains("slopes of shape (3, 2); expected (4, 2)"));
    gradient.layers.pop();
    let wrong = stacked.backward(rows.view(), None, out.view(), &mut gradient);
    assert!(message(wrong).contains("another shape"));
}

#[test]
fn no_snapshots_have_no_gradient() {
    let weights = weights(5, &[3], 2, Activation::Sigmoid);
    let (out, gradient) = stacked(
        &weights,
        Array2::zeros((0, 5)).view(),
        None,
        Array2::zeros((0, 2)).view(),
    );
    assert_eq!(out.len(), 0);
    assert!(flat(&gradient).iter().flatten().all(|&g| g == 0.0));
}
