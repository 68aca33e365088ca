//! What a unit does with its sum, and the slope of it: sigmoid, hyperbolic tangent, max(0, x).

use super::{
    super::net::Activation,
    kernel::{Register, load, store},
};
use macerator::{Scalar, Simd};

/// Applies an activation function to every number; as many as fill whole registers.
#[inline(always)]
pub fn apply<S: Simd, const L: usize>(activation: Activation, values: &mut [f32]) {
    let values = values.as_chunks_mut::<L>().0;
    match activation {
        Activation::Sigmoid => {
            for x in values {
                store(sigmoid::<S>(load(x)), x);
            }
        }
        Activation::Tanh => {
            for x in values {
                store(tanh::<S>(load(x)), x);
            }
        }
        Activation::Relu => {
            for x in values {
                // In this order a number that is none stays none.
                store(0f32.splat::<S>().max(load(x)), x);
            }
        }
    }
}

/// Takes ∂E/∂output to ∂E/∂sum, given the outputs.
#[inline(always)]
pub fn slope(activation: Activation, outputs: &[f32], slopes: &mut [f32]) {
    let pairs = slopes.iter_mut().zip(outputs);
    match activation {
        Activation::Sigmoid => pairs.for_each(|(slope, y)| *slope = *slope * y * (1.0 - y)),
        Activation::Tanh => pairs.for_each(|(slope, y)| *slope *= 1.0 - y * y),
        Activation::Relu => pairs.for_each(|(slope, y)| {
            *slope = if *y > 0.0 { *slope } else { 0.0 };
        }),
    }
}

/// 1/(1 + e^−x), by e^−|x| so that nothing overflows; within 2e-7 of its value.
#[inline(always)]
fn sigmoid<S: Simd>(x: Register<S>) -> Register<S> {
    let one = 1f32.splat::<S>();
    let (rest, power) = exponential(0f32.splat::<S>() - magnitude(x));
    let e = rest.mul_add(power, power);
    x.lt(0f32.splat()).select(e, one) / (one + e)
}

/// −(e^−2|x| − 1)/(e^−2|x| + 1) with the sign of x: the difference is taken before rounding, so that small numbers keep
/// their digits.
#[inline(always)]
fn tanh<S: Simd>(x: Register<S>) -> Register<S> {
    let zero = 0f32.splat::<S>();
    let (rest, power) = exponential((-2f32).splat::<S>() * magnitude(x));
    let less_one = rest.mul_add(power, power - 1f32.splat());
    let y = less_one / (less_one + 2f32.splat());
    x.lt(zero).select(y, zero - y)
}

/// |x|, but at most 43: from there on e^−2|x| is nothing beside 1 in either function's last digit, and 2^k stays normal.
/// In this order of the minimum a number that is none stays none.
#[inline(always)]
fn magnitude<S: Simd>(x: Register<S>) -> Register<S> {
    43f32.splat::<S>().min(x.abs())
}

/// e^x as (p, 2^k) with e^x = p 2^k + 2^k, for |x| ≤ 87: k = x/ln 2 rounded, p = e^r − 1 for the rest r = x − k ln 2 by its
/// Taylor series, whose first term left out, r^8/8!, is below 6e-9 for |r| ≤ ln 2/2.
#[inline(always)]
fn exponential<S: Simd>(x: Register<S>) -> (Register<S>, Register<S>) {
    // Adding 1.5 · 2^23 leaves no room for a fraction: what remains is k, in the lowest bits.
    let shift = 12_582_912f32.splat::<S>();
    let shifted = x.mul_add(std::f32::consts::LOG2_E.splat(), shift);
    let k = shifted - shift;
    // ln 2 in two parts, the first so short that its product with k is exact.
    let r = k.mul_add((-0.693_359_4f32).splat(), x);
    let r = k.mul_add(2.121_944_4e-4f32.splat(), r);
    let mut series = (1.0f32 / 5040.0).splat::<S>();
    for divisor in [720.0f32, 120.0, 24.0, 6.0, 2.0] {
        series = series.mul_add(r, (1.0 / divisor).splat());
    }
    let rest = (series * r).mul_add(r, r);
    let power = (shifted.reinterpret::<u32>() << 23) + 0x3f80_0000u32.splat();
    (rest, power.reinterpret())
}
