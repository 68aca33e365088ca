//! What came of a sweep: all that its tables are made of.

use crate::score::MeanInterval;
use serde::Serialize;

/// A cell without a result.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Hole {
    /// Its name.
    pub cell: String,
    /// Its keys and seed, for a reader.
    pub what: String,
}

/// A figure of one combination.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct SweepRow {
    /// Values of the keys, for a reader, in the order of [`SweepRecord::keys`].
    pub values: Vec<String>,
    /// The figure's name.
    pub figure: String,
    /// Cells with a result.
    pub cells: usize,
    /// Of these, those whose record has no number there.
    pub undefined: usize,
    /// Mean over seeds and its 95 % interval; none where a cell's figure is undefined, or there is no cell.
    pub mean: Option<MeanInterval>,
    /// Is it what others are held against?
    pub is_baseline: bool,
    /// Mean difference to the baseline, seed by seed, and its 95 % interval.
    pub difference: Option<MeanInterval>,
    /// Two-sided p of Student's t-test for paired samples; none where there is no test.
    pub p: Option<f64>,
    /// The same corrected for the number of this figure's tests (Holm 1979).
    pub p_holm: Option<f64>,
}

/// One cell's figures.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct CellRow {
    /// Its name.
    pub cell: String,
    /// Values of all keys of the sweep.
    pub values: Vec<String>,
    /// Its seed.
    pub seed: Option<u64>,
    /// Did its command lose something?
    pub lossy: bool,
    /// In the order of [`SweepRecord::figures`].
    pub figures: Vec<Option<f64>>,
}

/// What came of a sweep.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct SweepRecord {
    /// Version of the crate that ran the cells.
    pub version: String,
    /// What every cell ran.
    pub command: String,
    /// Keys that rows differ in.
    pub keys: Vec<String>,
    /// All keys that cells differ in, those that were averaged over among them.
    pub cell_keys: Vec<String>,
    /// Those that were averaged over besides seeds.
    pub over: Vec<String>,
    /// Names of the figures.
    pub figures: Vec<String>,
    /// Of each figure every combination.
    pub rows: Vec<SweepRow>,
    /// Cells of the plan.
    pub cells: usize,
    /// Those without a result.
    pub holes: Vec<Hole>,
    /// Every cell with a result.
    pub by_cell: Vec<CellRow>,
}
