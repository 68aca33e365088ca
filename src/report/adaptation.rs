//! How a model was adapted, run by run, as a table.

use super::{Cell, Table};
use crate::experiment::adaptation::{LabelErrors, LabelRecord};

/// What came of one dataset.
#[derive(Debug, Clone, PartialEq)]
pub struct AdaptationRow {
    /// Its name.
    pub dataset: String,
    /// How it was labelled.
    pub labels: LabelRecord,
    /// Snapshots that came into the map and went out of it, and steps taken; none where no label was kept.
    pub update: Option<[usize; 3]>,
}

/// A row a dataset, in the order of their adaptation.
pub fn table(rows: &[AdaptationRow]) -> Table {
    let mut table = Table::new([
        "dataset",
        "snapshots",
        "kept %",
        "beyond %",
        "median m",
        "95 % m",
        ">1 m %",
        "all >1 m %",
        "added",
        "forgotten",
        "steps",
    ]);
    for AdaptationRow {
        dataset,
        labels,
        update,
    } in rows
    {
        let of_kept = |get: fn(&LabelErrors) -> f64, decimals| {
            Cell::number(labels.errors.as_ref().map(get), decimals)
        };
        let share = |count: usize| 100.0 * count as f64 / labels.snapshots as f64;
        let all = labels.errors_of_all.map(|all| 100.0 * all.beyond_1m);
        let mut cells = vec![
            Cell::Text(dataset.clone()),
            Cell::Count(labels.snapshots as u64),
            Cell::number(Some(share(labels.kept)), 1),
            Cell::number(Some(share(labels.beyond)), 1),
            of_kept(|errors| errors.median_m, 2),
            of_kept(|errors| errors.p95_m, 2),
            of_kept(|errors| 100.0 * errors.beyond_1m, 1),
            Cell::number(all, 1),
        ];
        cells.extend([0, 1, 2].map(|number| {
            let count = update.map(|counts| counts[number] as u64);
            count.map_or(Cell::Missing, Cell::Count)
        }));
        table.row(cells);
    }
    table.caption("kept % = snapshots whose own label passed the gate; beyond %: those believed to be beyond the map;");
    table.caption("median, 95 %, >1 m: errors of the labels kept; all >1 m %: of all labels;");
    table.caption("  the poses of a dataset are looked at for these alone");
    table.caption("added, forgotten: snapshots of the map; steps: of training");
    table
}
