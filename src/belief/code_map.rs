//! P(f_i = 1 | ξ) of a wide code at very many places, as probabilities or as bits, ready for mean-field evidence.
//!
//! A grid in the plane has some hundred thousand cells, and every snapshot asks for Σ_i g_i ln m_i(ξ) + (1−g_i) ln(1−m_i(ξ)) at
//! each. What that takes is reading the map once, so it is kept small: four bytes a feature, or one bit.

use crate::{
    error::{Error, Result},
    simd,
};
use ndarray::{Array2, ArrayView2};
use rayon::prelude::*;

/// Cells whose features lie side by side.
const BLOCK: usize = 512;

/// Features that share a table of what their bits count for.
const BITS: usize = 8;

/// The map of a wide code at the cells of a grid.
///
/// ```
/// use ballmark::belief::CodeMap;
/// use ndarray::array;
/// // Two features at three cells, of the last of which nothing is known.
/// let probability = array![[0.9, 0.2], [0.4, 0.5], [0.0, 0.0]];
/// let map = CodeMap::probabilities(probability.view(), &[true, true, false])?;
/// let l = map.log_likelihood(&[1.0, 0.0])?;
/// assert!((l[0] - (0.9_f64 * 0.8).ln()).abs() < 1e-6);
/// assert!((l[2] - 0.5 * (l[0] + l[1])).abs() < 1e-6); // neither yes nor no
/// # Ok::<(), ballmark::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct CodeMap {
    cells: usize,
    features: usize,
    kept: Kept,
    /// Cells that nothing was seen from, ascending.
    unseen: Vec<usize>,
}

#[derive(Debug, Clone, PartialEq)]
enum Kept {
    /// ln m/(1−m), a block of cells after the other, `[feature, cell]` in each; and Σ_i ln(1−m_i), `[cell]`.
    Probabilities { log_odds: Vec<f32>, none: Vec<f32> },
    /// Eight features a byte, `[cell, byte]`; and P(f_i = 1) where the bit is 0 and where it is 1.
    Bits {
        codes: Vec<u8>,
        answered: Vec<[f32; 2]>,
    },
}

/// Logarithms stay finite: f32 knows no probability nearer to 1.
const SMALLEST_PROBABILITY: f32 = 1e-6;

impl CodeMap {
    /// From P(f_i = 1 | ξ), `[cell, feature]`, and whether anything was seen from each cell. A cell that nothing was seen from is
    /// as likely as the others are on average, whatever the features.
    ///
    /// # Errors
    /// Where there is no feature, not a probability, or not one word a cell on whether it was seen.
    pub fn probabilities(probability: ArrayView2<f32>, seen: &[bool]) -> Result<Self> {
        let (cells, features) = checked(probability, seen)?;
        let mut log_odds = vec![0.0; cells.next_multiple_of(BLOCK) * features];
        let mut none = vec![0.0; cells];
        let blocks = log_odds.par_chunks_mut(BLOCK * features);
        let blocks = blocks.zip(none.par_chunks_mut(BLOCK));
        blocks.enumerate().for_each(|(block, (log_odds, none))| {
            for (c, none) in none.iter_mut().enumerate() {
                for (i, &m) in probability.row(block * BLOCK + c).iter().enumerate() {
                    let m = m.clamp(SMALLEST_PROBABILITY, 1.0 - SMALLEST_PROBABILITY);
                    let off = (-m).ln_1p();
                    *none += off;
                    log_odds[i * BLOCK + c] = m.ln() - off;
                }
            }
        });
        Ok(Self {
            cells,
            features,
            kept: Kept::Probabilities { log_odds, none },
            unseen: unseen(seen),
        })
    }

    /// The same rounded to bits. What a bit is worth is learned from examples, whose snapshots answer `truth`,
    /// `[example, feature]`, at places where the map has `there`: P(f_i = 1) where the map's bit is 0, and where it is 1.
    ///
    /// # Errors
    /// As [`CodeMap::probabilities`], and where the examples are of another shape than each other.
    pub fn bits(
        probability: ArrayView2<f32>,
        seen: &[bool],
        (truth, there): (ArrayView2<f32>, ArrayView2<f32>),
    ) -> Result<Self> {
        let (cells, features) = checked(probability, seen)?;
        if truth.dim() != there.dim() || truth.ncols() != features {
            return Err(Error::work(format!(
                "map of bits: examples of shape {:?} and {:?}; expected {features} features of each",
                truth.dim(),
                there.dim()
            )));
        }
        let answered = (0..features).map(|i| answered(truth, there, i)).collect();
        let bytes = features.div_ceil(BITS);
        let mut codes = vec![0; cells * bytes];
        codes
            .par_chunks_mut(bytes)
            .enumerate()
            .for_each(|(cell, code)| {
                for (i, &m) in probability.row(cell).iter().enumerate() {
                    code[i / BITS] |= u8::from(m > 0.5) << (i % BITS);
                }
            });
        Ok(Self {
            cells,
            features,
            kept: Kept::Bits { codes, answered },
            unseen: unseen(seen),
        })
    }

    /// Number of cells.
    pub fn cells(&self) -> usize {
        self.cells
    }

    /// Number of features n.
    pub fn features(&self) -> usize {
        self.features
    }

    /// Cells that nothing was seen from, ascending: the map does not know them.
    pub fn unseen(&self) -> &[usize] {
        &self.unseen
    }

    /// What the map keeps of a cell, in bytes.
    pub fn bytes_per_cell(&self) -> usize {
        match &self.kept {
            Kept::Probabilities { .. } => self.features * size_of::<f32>(),
            Kept::Bits { .. } => self.features.div_ceil(BITS),
        }
    }

    /// P(f_i = 1 | ξ) that the map has for some probabilities, `[place, feature]`: themselves, or what their bits are worth.
    pub fn as_kept(&self, probability: ArrayView2<f32>) -> Array2<f32> {
        let mut kept = probability.to_owned();
        if let Kept::Bits { answered, .. } = &self.kept {
            for (mut column, answered) in kept.columns_mut().into_iter().zip(answered) {
                column.mapv_inplace(|m| answered[usize::from(m > 0.5)]);
            }
        }
        kept
    }

    /// Σ_i g_i ln m_i(ξ) + (1−g_i) ln(1−m_i(ξ)) at every cell, for the probabilities g of a snapshot, `[feature]`.
    ///
    /// # Errors
    /// Where there are not as many as features, or one is no probability.
    pub fn log_likelihood(&self, g: &[f32]) -> Result<Vec<f64>> {
        if g.len() != self.features {
            return Err(Error::work(format!(
                "evidence: {} activations for a map of {} features",
                g.len(),
                self.features
            )));
        }
        if let Some(bad) = g.iter().position(|g| !(0.0..=1.0).contains(g)) {
            return Err(Error::work(format!(
                "evidence: activation of feature {bad} is {}; expected a probability",
                g[bad]
            )));
        }
        let mut l = vec![0.0; self.cells];
        match &self.kept {
            Kept::Probabilities { log_odds, none } => {
                let blocks = log_odds.par_chunks(BLOCK * self.features);
                let blocks = blocks.zip(none.par_chunks(BLOCK));
                let blocks = blocks.zip(l.par_chunks_mut(BLOCK));
                blocks.for_each(|((log_odds, none), l)| {
                    simd::run(OfBlock {
                        g,
                        log_odds,
                        none,
                        l,
                    })
                });
            }
            Kept::Bits { codes, answered } => {
                let tables = tables(g, answered);
                let cells = codes.par_chunks(tables.len()).zip(&mut l);
                let cells = cells.with_min_len(BLOCK);
                cells.for_each(|(code, l)| {
                    let of_byte = code.iter().zip(&tables);
                    let sum: f32 = of_byte.map(|(&byte, table)| table[usize::from(byte)]).sum();
                    *l = f64::from(sum);
                });
            }
        }
        self.even_out(&mut l);
        Ok(l)
    }

    /// Unseen cells are as likely as the others are on average.
    fn even_out(&self, l: &mut [f64]) {
        let seen = self.cells - self.unseen.len();
        if self.unseen.is_empty() || seen == 0 {
            return;
        }
        self.unseen.iter().for_each(|&cell| l[cell] = 0.0);
        let mean = l.iter().sum::<f64>() / seen as f64;
        self.unseen.iter().for_each(|&cell| l[cell] = mean);
    }
}

/// A block of cells against a snapshot's probabilities.
struct OfBlock<'a> {
    g: &'a [f32],
    log_odds: &'a [f32],
    none: &'a [f32],
    l: &'a mut [f64],
}

impl simd::Kernel for OfBlock<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let mut sum = [0.0_f32; BLOCK];
        for (&g, log_odds) in self.g.iter().zip(self.log_odds.as_chunks::<BLOCK>().0) {
            for (sum, s) in sum.iter_mut().zip(log_odds) {
                *sum += g * s;
            }
        }
        for ((l, sum), none) in self.l.iter_mut().zip(sum).zip(self.none) {
            *l = f64::from(sum + none);
        }
    }
}

/// What every value of a byte of a code counts for.
fn tables(g: &[f32], answered: &[[f32; 2]]) -> Vec<[f32; 256]> {
    let worth = |(&g, m): (&f32, &[f32; 2])| m.map(|m| g * m.ln() + (1.0 - g) * (-m).ln_1p());
    let worth: Vec<[f32; 2]> = g.iter().zip(answered).map(worth).collect();
    let table = |of_byte: &[[f32; 2]]| {
        let sum = |byte: usize| {
            let bits = of_byte.iter().enumerate();
            bits.map(|(i, worth)| worth[byte >> i & 1]).sum()
        };
        std::array::from_fn(sum)
    };
    worth.chunks(BITS).map(table).collect()
}

/// P(f_i = 1) where the map's bit of feature i is 0 and where it is 1, by Laplace's rule.
fn answered(truth: ArrayView2<f32>, there: ArrayView2<f32>, i: usize) -> [f32; 2] {
    let mut sums = [[1.0_f32, 2.0]; 2];
    for (&g, &m) in truth.column(i).iter().zip(there.column(i)) {
        let sums = &mut sums[usize::from(m > 0.5)];
        sums[0] += g;
        sums[1] += 1.0;
    }
    sums.map(|[on, all]| on / all)
}

fn unseen(seen: &[bool]) -> Vec<usize> {
    (0..seen.len()).filter(|&cell| !seen[cell]).collect()
}

fn checked(probability: ArrayView2<f32>, seen: &[bool]) -> Result<(usize, usize)> {
    let (cells, features) = probability.dim();
    if features == 0 || seen.len() != cells {
        return Err(Error::work(format!(
            "map: {features} features at {cells} cells, {} of which are said to be seen or not; expected one feature or more, \
             and a word on each cell",
            seen.len()
        )));
    }
    match probability
        .indexed_iter()
        .find(|(_, m)| !(0.0..=1.0).contains(*m))
    {
        Some(((cell, feature), m)) => Err(Error::work(format!(
            "map: probability of cell {cell}, feature {feature} is {m}; expected 0 to 1"
        ))),
        None => Ok((cells, features)),
    }
}

#[cfg(test)]
mod tests;
