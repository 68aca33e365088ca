use super::*;
use crate::detector::{device::cpu, net::values};

fn layer(width: usize, stride: usize, ring: bool) -> Convolution {
    Convolution {
        inputs: 1,
        positions: 5,
        outputs: 1,
        width,
        stride,
        ring,
    }
}

#[test]
fn a_scan_repeats_its_ends_and_a_ring_goes_round() {
    assert_eq!(layer(3, 2, false).sources(), [0, 0, 1, 1, 2, 3, 3, 4, 4]);
    assert_eq!(layer(3, 2, true).sources(), [4, 0, 1, 1, 2, 3, 3, 4, 0]);
    assert_eq!(layer(3, 2, true).positions_out(), 3);
}

#[test]
fn sums_are_those_of_a_window_moved_along() {
    // Two numbers in each of three directions; one tap looks back, one here, one ahead.
    let layer = Convolution {
        inputs: 2,
        positions: 3,
        outputs: 1,
        width: 3,
        stride: 1,
        ring: false,
    };
    let input = Tensor::<3>::from_floats([[[1.0, 10.0], [2.0, 20.0], [3.0, 30.0]]], &cpu());
    let weight = [[[1.0], [0.0], [0.5], [0.1], [0.0], [1.0]]]; // tap by tap, channel by channel
    let weight = Tensor::<3>::from_floats(weight, &cpu());
    let bias = Tensor::<3>::from_floats([[[100.0]]], &cpu());
    let sums = values(layer.forward(input, weight, bias)).unwrap();
    // 1 back · first + ½ here · first + 0.1 here · second + ahead · second + 100
    let expected = [
        1.0 + 0.5 + 1.0 + 20.0,
        1.0 + 1.0 + 2.0 + 30.0,
        2.0 + 1.5 + 3.0 + 30.0,
    ];
    for (sum, expected) in sums.iter().zip(expected) {
        assert!((sum - 100.0 - expected).abs() < 1e-5, "{sum} {expected}");
    }
}
