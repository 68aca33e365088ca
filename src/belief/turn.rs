//! Turning a belief: what moved with each heading is shared among the headings that it may have now.

use super::{
    belief::NEGLIGIBLE,
    support::{BLOCK, Support},
};
use crate::simd;
use rayon::prelude::*;

/// What moved, one heading after another.
#[derive(Clone, Copy)]
pub(super) struct Moved<'a> {
    /// `[heading · sites + site]`
    pub mass: &'a [f64],
    /// Which blocks of it hold any.
    pub held: &'a [bool],
}

/// Bytes of the masses of a band, all headings: they should stay in a core's cache while they are turned.
const BAND_BYTES: usize = 512 * 1024;

/// Shares the masses of each heading among the headings it may have turned to. Less than [`NEGLIGIBLE`] becomes 0, and
/// blocks without mass are held no more.
pub(super) fn turn(weights: &[f64], moved: Moved, mass: &mut [f64], support: &mut Support) {
    let headings = weights.len();
    let taps: Vec<(usize, f64)> = weights
        .iter()
        .copied()
        .enumerate()
        .filter(|(_, weight)| *weight > 0.0)
        .collect();
    let (sites, blocks) = (support.sites(), support.blocks());
    let band = (BAND_BYTES / size_of::<f64>() / headings / BLOCK).max(1);
    let masses = bands(mass, sites, band * BLOCK).into_par_iter();
    let held = bands(support.held_mut(), blocks, band).into_par_iter();
    masses
        .zip(held)
        .enumerate()
        .for_each(|(number, (masses, held))| {
            let first_block = number * band;
            simd::run(TurnBand {
                taps: &taps,
                moved,
                sites,
                first_block,
                masses,
                held,
            });
        });
}

/// Fills a band of all headings.
struct TurnBand<'a> {
    /// Headings turned by, and the share of the mass that is.
    taps: &'a [(usize, f64)],
    moved: Moved<'a>,
    /// Of a layer.
    sites: usize,
    first_block: usize,
    masses: Vec<&'a mut [f64]>,
    held: Vec<&'a mut [bool]>,
}

impl simd::Kernel for TurnBand<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let (moved, headings) = (self.moved, self.masses.len());
        let blocks = self.sites.div_ceil(BLOCK);
        let (mut sources, mut carried) = (Vec::new(), Vec::new());
        for (heading, (masses, held)) in self.masses.into_iter().zip(self.held).enumerate() {
            // Where the blocks of this band begin in each layer turned from.
            carried.clear();
            for &(turn, weight) in self.taps {
                let from = (heading + headings - turn) % headings;
                let held = &moved.held[from * blocks + self.first_block..][..held.len()];
                if held.contains(&true) {
                    let start = from * self.sites + self.first_block * BLOCK;
                    let masses = &moved.mass[start..start + masses.len()];
                    carried.push((weight, held, masses));
                }
            }
            let mut block = 0;
            while block < held.len() {
                // As many blocks as the same layers hold.
                let mut end = block + 1;
                while end < held.len()
                    && carried.iter().all(|(_, held, _)| held[end] == held[block])
                {
                    end += 1;
                }
                let sites = block * BLOCK..(end * BLOCK).min(masses.len());
                sources.clear();
                for (weight, held, masses) in &carried {
                    if held[block] {
                        sources.push((*weight, &masses[sites.clone()]));
                    }
                }
                let targets = masses[sites].chunks_mut(BLOCK);
                let targets = targets.zip(&mut held[block..end]);
                if sources.is_empty() {
                    for (target, held) in targets {
                        if std::mem::take(held) {
                            target.fill(0.0);
                        }
                    }
                } else {
                    for (number, (target, held)) in targets.enumerate() {
                        mix(&sources, number * BLOCK, target);
                        *held = target.iter().any(|mass| *mass > 0.0);
                    }
                }
                block = end;
            }
        }
    }
}

/// The weighted sum of the sources' masses from `at` on.
#[inline(always)]
fn mix(sources: &[(f64, &[f64])], mut at: usize, target: &mut [f64]) {
    const TOGETHER: usize = 32;
    let (parts, rest) = target.as_chunks_mut::<TOGETHER>();
    for part in parts {
        let mut sums = [0.0; TOGETHER];
        for (weight, source) in sources {
            for (sum, mass) in sums.iter_mut().zip(&source[at..][..TOGETHER]) {
                *sum += weight * mass;
            }
        }
        for (t, sum) in part.iter_mut().zip(sums) {
            *t = if sum < NEGLIGIBLE { 0.0 } else { sum };
        }
        at += TOGETHER;
    }
    for t in rest {
        let mut sum = 0.0;
        for (weight, source) in sources {
            sum += weight * source[at];
        }
        *t = if sum < NEGLIGIBLE { 0.0 } else { sum };
        at += 1;
    }
}

/// Cuts layers of `layer` items each into bands of `band` items, and lists the layers' parts of each band.
fn bands<T>(items: &mut [T], layer: usize, band: usize) -> Vec<Vec<&mut [T]>> {
    let mut bands: Vec<Vec<&mut [T]>> = (0..layer.div_ceil(band)).map(|_| Vec::new()).collect();
    for layer in items.chunks_mut(layer) {
        for (band, part) in bands.iter_mut().zip(layer.chunks_mut(band)) {
            band.push(part);
        }
    }
    bands
}
