//! Where a belief has mass: blocks of cells, so that whatever goes over all masses passes by those that hold none.

use std::ops::Range;

/// Cells of a block.
pub(super) const BLOCK: usize = 64;

/// For each block of each heading, whether it may hold mass; a block that is not held holds none.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Support {
    sites: usize,
    held: Vec<bool>,
}

impl Support {
    /// All blocks of `cells` cells that come in layers of `sites` cells, one layer a heading.
    pub(super) fn everywhere(cells: usize, sites: usize) -> Self {
        let blocks = sites.div_ceil(BLOCK) * cells.div_ceil(sites.max(1));
        Self {
            sites,
            held: vec![true; blocks],
        }
    }

    /// Cells of a layer.
    pub(super) fn sites(&self) -> usize {
        self.sites
    }

    /// Blocks of a layer.
    pub(super) fn blocks(&self) -> usize {
        self.sites.div_ceil(BLOCK)
    }

    /// One entry a block, layer by layer.
    pub(super) fn held(&self) -> &[bool] {
        &self.held
    }

    /// The same, to be changed.
    pub(super) fn held_mut(&mut self) -> &mut [bool] {
        &mut self.held
    }
}

/// The masses of one heading with the blocks that are held. What the others hold means nothing: it counts as 0.
pub(super) struct Layer<'a> {
    mass: &'a mut [f64],
    held: &'a mut [bool],
}

impl<'a> Layer<'a> {
    pub(super) fn new(mass: &'a mut [f64], held: &'a mut [bool]) -> Self {
        Self { mass, held }
    }

    pub(super) fn is_empty(&self) -> bool {
        !self.held.contains(&true)
    }

    /// The masses of some sites, all in blocks that are held.
    pub(super) fn mass(&self, sites: Range<usize>) -> &[f64] {
        &self.mass[sites]
    }

    /// The same, to be written; holds their blocks.
    pub(super) fn mass_mut(&mut self, sites: Range<usize>) -> &mut [f64] {
        self.hold(&sites);
        &mut self.mass[sites]
    }

    /// The shortest stretch within `sites` that has all their mass.
    pub(super) fn span(&self, sites: &Range<usize>) -> Range<usize> {
        let mut blocks = sites.start / BLOCK..sites.end.div_ceil(BLOCK);
        let (Some(first), last) = (
            blocks.clone().find(|&b| self.held[b]),
            blocks.rfind(|&b| self.held[b]),
        ) else {
            return sites.start..sites.start;
        };
        let end = last.map_or(sites.start, |last| sites.end.min((last + 1) * BLOCK));
        let stretch = sites.start.max(first * BLOCK)..end;
        let masses = &self.mass[stretch.clone()];
        match masses.iter().position(|m| *m > 0.0) {
            None => sites.start..sites.start,
            Some(before) => {
                let after = masses.iter().rev().take_while(|m| **m == 0.0).count();
                stretch.start + before..stretch.end - after
            }
        }
    }

    /// Adds `weight` times `source` to the sites from `at` on.
    #[inline(always)]
    pub(super) fn add(&mut self, at: usize, source: &[f64], weight: f64) {
        for (t, s) in self.mass_mut(at..at + source.len()).iter_mut().zip(source) {
            *t += weight * s;
        }
    }

    fn hold(&mut self, sites: &Range<usize>) {
        for block in sites.start / BLOCK..sites.end.div_ceil(BLOCK) {
            if !self.held[block] {
                self.held[block] = true;
                let end = self.mass.len().min((block + 1) * BLOCK);
                self.mass[block * BLOCK..end].fill(0.0);
            }
        }
    }

    /// Holds no block any more.
    pub(super) fn forget(&mut self) {
        self.held.fill(false);
    }

    /// Becomes a copy of another layer.
    pub(super) fn copy_from(&mut self, other: &Layer) {
        self.held.copy_from_slice(other.held);
        let blocks = self.mass.chunks_mut(BLOCK).zip(other.mass.chunks(BLOCK));
        for ((to, from), _) in blocks.zip(other.held.iter()).filter(|(_, held)| **held) {
            to.copy_from_slice(from);
        }
    }

    /// Sum of all masses; a block without mass changes no digit of it, held or not.
    #[inline(always)]
    pub(super) fn sum(&self) -> f64 {
        let mut sum = LaneSum::default();
        for (masses, held) in self.mass.chunks(BLOCK).zip(self.held.iter()) {
            if *held {
                sum.add(masses);
            }
        }
        sum.total()
    }
}

/// A sum in parts, which processors can add to at once.
#[derive(Default)]
pub(super) struct LaneSum([f64; 32]);

impl LaneSum {
    #[inline(always)]
    pub(super) fn add(&mut self, values: &[f64]) {
        let (parts, rest) = values.as_chunks::<32>();
        for part in parts {
            for (lane, value) in self.0.iter_mut().zip(part) {
                *lane += value;
            }
        }
        for (lane, value) in self.0.iter_mut().zip(rest) {
            *lane += value;
        }
    }

    pub(super) fn total(&self) -> f64 {
        self.0.iter().sum()
    }
}
