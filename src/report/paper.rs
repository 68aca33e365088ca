//! What the tables of all papers share.

use super::{
    Cell, Table,
    comparison::{Reader, Sheet},
};
use crate::score::MeanInterval;

/// Words in a table.
pub(super) fn text(text: impl Into<String>) -> Cell {
    Cell::Text(text.into())
}

/// A table for everyone.
pub(super) fn sheet(name: &str, title: &str, table: Table) -> Sheet {
    Sheet {
        name: name.into(),
        title: title.into(),
        table,
        reader: Reader::Everyone,
    }
}

/// A mean with half of its interval, both times `scale`.
pub(super) fn with_half(mean: &MeanInterval, scale: f64) -> Cell {
    let shown = scale * mean.mean;
    text(match mean.ci95 {
        Some([low, high]) => format!("{shown:.1} ± {:.1}", scale * (high - low) / 2.0),
        None => format!("{shown:.1}"),
    })
}
