//! Stored signatures, and which of them a new one is most like: by the dot product, as D00's RCE and nearest neighbour.

use super::{
    Response,
    signature::{Layout, SignatureConfig},
};
use crate::{
    error::{Error, Result},
    recording::{Channel, Observation, Recording},
};
use ndarray::{ArrayView2, ArrayViewMut2, linalg::general_mat_mul};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

/// Signatures `[pattern, value]` in the order they were stored.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Prototypes {
    layout: Layout,
    /// Row by row.
    values: Vec<f32>,
}

/// Snapshots and patterns in one product: it stays in a core's cache together with both its factors.
const SNAPSHOTS: usize = 64;
const PATTERNS: usize = 512;

impl Prototypes {
    /// None yet, for signatures of these sensors.
    pub fn new(
        config: &SignatureConfig,
        recording: &Recording,
        snapshots: &[usize],
    ) -> Result<Self> {
        Ok(Self {
            layout: Layout::fit(config, recording, snapshots)?,
            values: Vec::new(),
        })
    }

    pub fn len(&self) -> usize {
        self.values.len() / self.layout.width().max(1)
    }

    /// Bytes of a stored signature.
    pub fn bytes_each(&self) -> usize {
        self.layout.width() * size_of::<f32>()
    }

    pub fn layout(&self) -> &Layout {
        &self.layout
    }

    pub fn push(&mut self, signature: &[f32]) {
        self.values.extend_from_slice(signature);
    }

    /// The pattern of largest dot product, the first of several; the dot product is the mean over channels, so that a
    /// pattern's with itself is 1 however many there are.
    pub fn most_like(&self, signature: &[f32]) -> Option<Response> {
        let patterns = self.values.chunks_exact(self.layout.width().max(1));
        let mut best: Option<(usize, f32)> = None;
        for (class, pattern) in patterns.enumerate() {
            let product = dot(pattern, signature);
            if best.is_none_or(|(_, most)| product > most) {
                best = Some((class, product));
            }
        }
        best.map(|(class, product)| self.response(class, product))
    }

    pub fn respond(&self, channels: &[Channel], observation: &Observation) -> Option<Response> {
        self.most_like(&self.layout.of(channels, observation)?)
    }

    /// What [`Prototypes::respond`] gives, for many snapshots at once: as a product of matrices, block by block.
    pub fn respond_all(&self, recording: &Recording, snapshots: &[usize]) -> Vec<Option<Response>> {
        if self.layout.check_channels(recording.channels()).is_err() {
            return vec![None; snapshots.len()];
        }
        let blocks: Vec<Vec<Option<Response>>> = snapshots
            .par_chunks(SNAPSHOTS)
            .map(|snapshots| {
                let signature = |k: &usize| {
                    self.layout
                        .of(recording.channels(), &recording.observation(*k))
                };
                let signatures: Vec<f32> =
                    snapshots.iter().filter_map(signature).flatten().collect();
                self.most_like_each(&signatures)
            })
            .collect();
        blocks.concat()
    }

    /// The answers to signatures that stand row by row, at most [`SNAPSHOTS`] of them.
    fn most_like_each(&self, signatures: &[f32]) -> Vec<Option<Response>> {
        let width = self.layout.width().max(1);
        let rows = signatures.len() / width;
        // Two orders of one sum of products of unit vectors differ by less than this, twice the bound of a rounded sum.
        let doubt = 4.0 * (width * self.layout.channels()) as f32 * f32::EPSILON;
        let mut most = vec![f32::NEG_INFINITY; rows];
        // Patterns, and their products, that were within doubt of the most so far.
        let mut candidates: Vec<Vec<(usize, f32)>> = vec![Vec::new(); rows];
        let mut products = vec![0.0; rows * PATTERNS];
        for (block, patterns) in self.values.chunks(PATTERNS * width).enumerate() {
            let stored = patterns.len() / width;
            let products = &mut products[..rows * stored];
            multiply(signatures, patterns, width, products);
            for (row, products) in products.chunks_exact(stored).enumerate() {
                let highest = largest(products);
                if highest < most[row] - doubt {
                    continue;
                }
                most[row] = most[row].max(highest);
                let numbered = products.iter().enumerate();
                let near = numbered.filter(|(_, p)| **p >= most[row] - doubt);
                candidates[row].extend(near.map(|(i, p)| (block * PATTERNS + i, *p)));
            }
        }
        let of_row = |(row, scan): (usize, &[f32])| {
            // The pattern that the plain loop would choose is one of these, and its sum decides among them.
            let near = candidates[row].iter().filter(|c| c.1 >= most[row] - doubt);
            let exact = near.map(|&(class, _)| {
                let pattern = &self.values[class * width..][..width];
                (class, dot(pattern, scan))
            });
            let best = exact.reduce(|best, next| if next.1 > best.1 { next } else { best });
            best.map(|(class, product)| self.response(class, product))
        };
        signatures
            .chunks_exact(width)
            .enumerate()
            .map(of_row)
            .collect()
    }

    fn response(&self, class: usize, product: f32) -> Response {
        let fit = f64::from(product) / self.layout.channels().max(1) as f64;
        Response { class, fit }
    }

    /// # Errors
    /// Where the values are no whole number of signatures, or one is not finite.
    pub fn check(&self) -> Result<()> {
        self.layout.check()?;
        let width = self.layout.width();
        if self.values.is_empty() || !self.values.len().is_multiple_of(width) {
            return Err(Error::work(format!(
                "{} values of stored signatures; expected a multiple of {width}, at least one signature",
                self.values.len()
            )));
        }
        // Parts of unit vectors; anything greater is damage, and could make a product infinite.
        match self.values.iter().find(|v| v.is_nan() || v.abs() > 1.0001) {
            Some(v) => Err(Error::work(format!(
                "a value of {v} in a stored signature; expected −1 to 1"
            ))),
            None => Ok(()),
        }
    }
}

/// All dot products of rows of two matrices of that width, `[row of a, row of b]`.
fn multiply(a: &[f32], b: &[f32], width: usize, products: &mut [f32]) {
    let rows = |values: &[f32]| values.len() / width;
    let shape = (rows(a), rows(b));
    let a = ArrayView2::from_shape((shape.0, width), a);
    let b = ArrayView2::from_shape((shape.1, width), b);
    let products = ArrayViewMut2::from_shape(shape, products);
    // All three are cut to whole rows of that width by the callers.
    if let (Ok(a), Ok(b), Ok(mut products)) = (a, b, products) {
        general_mat_mul(1.0, &a, &b.t(), 0.0, &mut products);
    }
}

/// Eight maxima side by side: in one chain each would wait for the last.
fn largest(values: &[f32]) -> f32 {
    let greater = |a: f32, b: f32| if b > a { b } else { a };
    let mut most = [f32::NEG_INFINITY; 8];
    let chunks = values.chunks_exact(8);
    let rest = chunks.remainder().iter().copied();
    for chunk in chunks {
        for (most, value) in most.iter_mut().zip(chunk) {
            *most = greater(*most, *value);
        }
    }
    most.into_iter()
        .chain(rest)
        .fold(f32::NEG_INFINITY, greater)
}

/// Eight sums side by side, which a vector unit adds at once, in an order that is always the same.
fn dot(a: &[f32], b: &[f32]) -> f32 {
    let mut sums = [0.0; 8];
    let (a, b) = (a.chunks_exact(8), b.chunks_exact(8));
    let rest = a.remainder().iter().zip(b.remainder());
    let rest: f32 = rest.map(|(a, b)| a * b).sum();
    for (a, b) in a.zip(b) {
        for ((sum, a), b) in sums.iter_mut().zip(a).zip(b) {
            *sum += a * b;
        }
    }
    sums.iter().sum::<f32>() + rest
}

#[cfg(test)]
mod tests;
