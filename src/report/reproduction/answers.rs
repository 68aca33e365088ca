//! What systems answered with each seed.

use crate::experiment::{
    compare::{ComparisonRecord, Section},
    over_seeds::Reproduction,
};

/// The answer of the system of a kind on the dataset of a name, of each seed.
pub(super) fn each<C, T, V>(
    reproduction: &Reproduction,
    section: fn(&ComparisonRecord) -> Option<&Section<C, T>>,
    (kind, dataset): (&str, &str),
    value: impl Fn(&T) -> Option<V>,
) -> Vec<Option<V>> {
    let of = |record: &ComparisonRecord| {
        let section = section(record)?;
        let is_kind = |&&system: &&usize| record.systems[system].kind == kind;
        let row = section.systems.iter().position(|system| is_kind(&system))?;
        let column = record.datasets.iter().position(|d| d.name == dataset)?;
        value(section.cells.get(row)?.get(column)?.done()?)
    };
    reproduction
        .comparisons
        .iter()
        .map(|comparison| of(&comparison.record))
        .collect()
}
