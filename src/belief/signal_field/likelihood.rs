//! The likelihood of a snapshot under the means and presences of many places: a product of one factor a value, in f32.
//!
//! Every factor is divided by its greatest, and the product by a power of 2 before it can underflow, so that one logarithm
//! a place is enough.

use super::reading_model::ReadingModel;
use crate::simd::{self, Kernel};
use std::f64::consts::{LOG2_E, TAU};

/// Places worked on at a time: their products stay in the first cache.
pub(super) const BLOCK: usize = 128;

/// Density of an outlier, in readings counted in deviations over all snapshots.
const OUTLIER_DENSITY: f64 = 0.15;

/// How far the product may fall or rise before its power of 2 is taken out: ln of f32's smallest normal number is −87.
const LARGEST_LOG: f64 = 80.0;

/// What the reading of one value, or its lack, says.
#[derive(Debug, Clone, Copy)]
pub(super) struct Term {
    /// Plane of the presence probabilities, of values that are ever missing.
    presence: Option<usize>,
    /// Where there is a reading.
    reading: Option<Reading>,
    /// By how much it may change ln of the product.
    largest_log: f64,
}

/// (1−u) N(z; μ, σ²) + 0.15 u, over its value at z = μ.
#[derive(Debug, Clone, Copy)]
struct Reading {
    /// Plane of the means.
    plane: usize,
    standardised: f32,
    /// log₂ e / 2σ²
    steepness: f32,
    /// Share of the Gaussian and of the outliers, which sum to 1.
    gaussian: f32,
    outlier: f32,
    /// The factor where nothing is known of the mean.
    unknown: f32,
}

/// ln of the least presence that there is, and somewhat more.
const PRESENCE_LOG: f64 = 7.0;

impl Term {
    /// Of a reading, and ln of its greatest density.
    pub(super) fn read(
        plane: usize,
        presence: Option<usize>,
        reading: f32,
        model: &ReadingModel,
    ) -> (Self, f64) {
        let z = model.standardised(reading);
        let outlier = OUTLIER_DENSITY * model.outliers;
        let gaussian = |variance: f64| (1.0 - model.outliers) / (TAU * variance).sqrt();
        let greatest = gaussian(model.variance) + outlier;
        let unknown = gaussian(1.0) * (-0.5 * f64::from(z).powi(2)).exp() + outlier;
        // However few outliers there are, a factor is no denormal number.
        let least = (outlier / greatest).max(1e-30);
        let unknown = (unknown / greatest).max(1e-30);
        let term = Self {
            presence,
            reading: Some(Reading {
                plane,
                standardised: z,
                steepness: (0.5 * LOG2_E / model.variance) as f32,
                gaussian: (gaussian(model.variance) / greatest) as f32,
                outlier: least as f32,
                unknown: unknown as f32,
            }),
            largest_log: unknown.ln().abs().max(-least.ln())
                + presence.map_or(0.0, |_| PRESENCE_LOG),
        };
        (term, greatest.ln())
    }

    /// Of a reading that is missing.
    pub(super) fn missing(presence: usize) -> Self {
        Self {
            presence: Some(presence),
            reading: None,
            largest_log: PRESENCE_LOG,
        }
    }
}

/// Σ ln of the terms' factors at the places of one block, whose planes are `[plane, place]`.
pub(super) fn sum(terms: &[Term], planes: &[f32]) -> [f32; BLOCK] {
    simd::run(Product { terms, planes })
}

struct Product<'a> {
    terms: &'a [Term],
    planes: &'a [f32],
}

impl Kernel for Product<'_> {
    type Output = [f32; BLOCK];

    #[inline(always)]
    fn run(self) -> [f32; BLOCK] {
        let (mut product, mut power) = ([1.0f32; BLOCK], [0i32; BLOCK]);
        let mut log = 0.0;
        for term in self.terms {
            if log + term.largest_log > LARGEST_LOG {
                take_out_power(&mut product, &mut power);
                log = 0.0;
            }
            log += term.largest_log;
            if let Some(reading) = &term.reading {
                let means = &self.planes[reading.plane * BLOCK..][..BLOCK];
                for (product, mean) in product.iter_mut().zip(means) {
                    *product *= reading.factor(*mean);
                }
            }
            let Some(presence) = term.presence else {
                continue;
            };
            let presence = &self.planes[presence * BLOCK..][..BLOCK];
            if term.reading.is_some() {
                for (product, presence) in product.iter_mut().zip(presence) {
                    *product *= presence;
                }
            } else {
                for (product, presence) in product.iter_mut().zip(presence) {
                    *product *= 1.0 - presence;
                }
            }
        }
        let mut sums = [0.0; BLOCK];
        for (sum, (product, power)) in sums.iter_mut().zip(product.iter().zip(&power)) {
            *sum = product.ln() + *power as f32 * std::f32::consts::LN_2;
        }
        sums
    }
}

impl Reading {
    #[inline(always)]
    fn factor(&self, mean: f32) -> f32 {
        let off = self.standardised - mean;
        let known = self.gaussian * exp2(-off * off * self.steepness) + self.outlier;
        if mean.is_nan() { self.unknown } else { known }
    }
}

/// Splits off the power of 2, so that 1 ≤ product < 2.
#[inline(always)]
fn take_out_power(product: &mut [f32; BLOCK], power: &mut [i32; BLOCK]) {
    for (product, power) in product.iter_mut().zip(power) {
        let bits = product.to_bits();
        *power += (bits >> 23) as i32 - 127;
        *product = f32::from_bits(bits & 0x007f_ffff | 0x3f80_0000);
    }
}

/// 2^x of x ≤ 0, within 3·10⁻⁷ of it; at least 2^−125.
#[inline(always)]
fn exp2(x: f32) -> f32 {
    // 1.5 · 2²³, whose last bit counts ones: adding it rounds to a whole number.
    const WHOLE: f32 = 12_582_912.0;
    let x = if x > -125.0 { x } else { -125.0 };
    let rounded = x + WHOLE;
    let whole = rounded.to_bits().wrapping_sub(WHOLE.to_bits());
    let rest = x - (rounded - WHOLE);
    // (ln 2)^n / n!
    let series = 1.540_353e-4;
    let series = series * rest + 1.333_355_8e-3;
    let series = series * rest + 9.618_129e-3;
    let series = series * rest + 5.550_411e-2;
    let series = series * rest + 0.240_226_5;
    let series = series * rest + std::f32::consts::LN_2;
    let series = series * rest + 1.0;
    series * f32::from_bits(whole.wrapping_add(127) << 23)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::simd::InstructionSet;

    #[test]
    fn powers_of_two_are_as_the_standard_library_has_them() {
        for i in 0..200_000 {
            let x = -(i as f32) * 6e-4;
            let (found, expected) = (f64::from(exp2(x)), f64::from(x).exp2());
            assert!(
                (found / expected - 1.0).abs() < 3e-7,
                "2^{x}: {found} {expected}"
            );
        }
        assert_eq!(exp2(f32::NEG_INFINITY), exp2(-125.0));
    }

    #[test]
    fn products_that_would_underflow_are_the_sum_of_their_logarithms() {
        let model = ReadingModel {
            mean: -60.0,
            deviation: 5.0,
            presence: 0.5,
            is_ever_missing: true,
            variance: 0.01,
            outliers: 0.05,
        };
        // 60 values, a third of them missing, each with its presence; every seventh mean unknown.
        let planes: Vec<f32> = (0..120 * BLOCK)
            .map(|i| match i {
                _ if i >= 60 * BLOCK => 0.001 + 0.998 * ((i * 31 % 97) as f32 / 97.0),
                _ if i % 7 == 0 => f32::NAN,
                _ => (i * 17 % 83) as f32 / 20.0 - 2.0,
            })
            .collect();
        let readings: Vec<f32> = (0..60)
            .map(|value| {
                if value % 3 == 0 {
                    f32::NAN
                } else {
                    -70.0 + 0.37 * value as f32
                }
            })
            .collect();
        let mut terms = Vec::new();
        let mut constant = 0.0;
        for (value, &reading) in readings.iter().enumerate() {
            if reading.is_nan() {
                terms.push(Term::missing(60 + value));
                continue;
            }
            let (term, everywhere) = Term::read(value, Some(60 + value), reading, &model);
            terms.push(term);
            constant += everywhere;
        }
        let run = |set: InstructionSet| {
            let (terms, planes) = (&terms[..], &planes[..]);
            set.run(Product { terms, planes })
        };
        let found = run(InstructionSet::Best);
        assert_eq!(found, run(InstructionSet::Portable));
        for (place, found) in found.iter().enumerate() {
            let of_value = |(value, reading): (usize, &f32)| {
                let at = |plane: usize| f64::from(planes[plane * BLOCK + place]);
                let presence = at(60 + value);
                if reading.is_nan() {
                    return (1.0 - presence).ln();
                }
                let z = (f64::from(*reading) + 60.0) / 5.0;
                let (off, variance) = match at(value) {
                    mean if mean.is_nan() => (z, 1.0),
                    mean => (z - mean, 0.01),
                };
                let gaussian = (-0.5 * off * off / variance).exp() / (TAU * variance).sqrt();
                presence.ln() + (0.95 * gaussian + 0.05 * 0.15).ln()
            };
            let expected: f64 = readings.iter().enumerate().map(of_value).sum();
            assert!(expected < -150.0, "{expected}: no underflow to be tried");
            let found = f64::from(*found) + constant;
            assert!(
                (found - expected).abs() < 1e-3,
                "{place}: {found} {expected}"
            );
        }
    }
}
