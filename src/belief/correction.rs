//! Weighing masses by a likelihood: P(f|ξ) Bel(ξ), normalised (Thrun 1998, eq. 17, 18).

use super::{
    belief::NEGLIGIBLE,
    support::{BLOCK, LaneSum, Support},
};
use crate::{
    error::{Error, Result},
    simd,
};
use rayon::prelude::*;

/// Weighs and normalises the masses, where there are any, and returns ln of what they summed to in between.
///
/// # Errors
/// Where a value is NaN or +∞, or the likelihood is 0 wherever there is mass: the masses stay as they were.
pub(super) fn weigh(
    mass: &mut [f64],
    support: &mut Support,
    log_likelihood: &[f64],
) -> Result<f64> {
    let (sites, blocks) = (support.sites(), support.blocks());
    let layers = mass.par_chunks(sites);
    let layers = layers.zip(log_likelihood.par_chunks(sites));
    // Only places that are believed in may set the scale: if the best of all places were far off, all the others could
    // underflow together.
    let (best, valid) = layers
        .zip(support.held().par_chunks(blocks))
        .map(|((mass, log_likelihood), held)| {
            simd::run(Best {
                mass,
                log_likelihood,
                held,
            })
        })
        .reduce(
            || (f64::NEG_INFINITY, true),
            |a, b| (a.0.max(b.0), a.1 && b.1),
        );
    if !valid {
        return Err(Error::work("likelihood: a value is NaN or infinite"));
    }
    if best == f64::NEG_INFINITY {
        return Err(Error::work(
            "likelihood: 0 at every place that the belief holds possible; expected a floor for the unmodelled",
        ));
    }
    let layers = mass.par_chunks_mut(sites);
    let layers = layers.zip(log_likelihood.par_chunks(sites));
    let totals: Vec<f64> = layers
        .zip(support.held().par_chunks(blocks))
        .map(|((mass, log_likelihood), held)| {
            let mut total = LaneSum::default();
            let blocks = mass.chunks_mut(BLOCK).zip(log_likelihood.chunks(BLOCK));
            for ((mass, log_likelihood), _) in blocks.zip(held).filter(|(_, held)| **held) {
                for (mass, l) in mass.iter_mut().zip(log_likelihood) {
                    if *mass > 0.0 {
                        *mass *= (l - best).exp();
                    }
                }
                total.add(mass);
            }
            total.total()
        })
        .collect();
    let total: f64 = totals.iter().sum();
    mass.par_chunks_mut(sites)
        .zip(support.held_mut().par_chunks_mut(blocks))
        .for_each(|(mass, held)| simd::run(Normalise { mass, held, total }));
    Ok(best + total.ln())
}

/// The largest logarithm of the likelihood where there is mass; and is every one a number or −∞?
struct Best<'a> {
    mass: &'a [f64],
    log_likelihood: &'a [f64],
    held: &'a [bool],
}

impl simd::Kernel for Best<'_> {
    type Output = (f64, bool);

    #[inline(always)]
    fn run(self) -> (f64, bool) {
        let (mut best, mut invalid) = ([f64::NEG_INFINITY; 32], [0.0; 32]);
        let blocks = self
            .mass
            .chunks(BLOCK)
            .zip(self.log_likelihood.chunks(BLOCK));
        for ((mass, log_likelihood), held) in blocks.zip(self.held) {
            let (parts, rest) = log_likelihood.as_chunks::<32>();
            for part in parts {
                for (invalid, l) in invalid.iter_mut().zip(part) {
                    *invalid += if *l < f64::INFINITY { 0.0 } else { 1.0 }; // 1 for NaN, too
                }
            }
            for (invalid, l) in invalid.iter_mut().zip(rest) {
                *invalid += if *l < f64::INFINITY { 0.0 } else { 1.0 };
            }
            if !*held {
                continue;
            }
            let (masses, masses_rest) = mass.as_chunks::<32>();
            for (part, masses) in parts.iter().zip(masses) {
                for ((best, l), mass) in best.iter_mut().zip(part).zip(masses) {
                    let counts = if *mass > 0.0 { *l } else { f64::NEG_INFINITY };
                    *best = if counts > *best { counts } else { *best };
                }
            }
            for ((best, l), mass) in best.iter_mut().zip(rest).zip(masses_rest) {
                if *mass > 0.0 && *l > *best {
                    *best = *l;
                }
            }
        }
        let best = best.iter().fold(f64::NEG_INFINITY, |a, b| a.max(*b));
        (best, invalid.iter().all(|count| *count == 0.0))
    }
}

/// Divides the masses by their sum; what is below [`NEGLIGIBLE`] becomes 0.
struct Normalise<'a> {
    mass: &'a mut [f64],
    held: &'a mut [bool],
    total: f64,
}

impl simd::Kernel for Normalise<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        for (mass, held) in self.mass.chunks_mut(BLOCK).zip(self.held) {
            if *held {
                for m in mass.iter_mut() {
                    let share = *m / self.total;
                    *m = if share < NEGLIGIBLE { 0.0 } else { share };
                }
                *held = mass.iter().any(|m| *m > 0.0);
            }
        }
    }
}
