//! A bank of filters beside each of its sets alone.

use super::named;
use crate::{
    experiment::thrun1998::{BankRecord, Thrun1998Record, UsedRow, words},
    report::{
        Cell, Table,
        comparison::Sheet,
        paper::{sheet, text},
    },
};

/// How the table calls an approach.
pub(super) fn titled(approach: &str) -> String {
    match approach {
        "bank_by_error" => "one set a step, by least error".into(),
        "bank_of_2_by_error" => "two sets a step, by least error".into(),
        "bank" => "one set a step, by information".into(),
        "bank_of_2" => "two sets a step, by information".into(),
        "bank_of_3" => "three sets a step, by information".into(),
        "all_sets" => "all six sets at every step".into(),
        set => match set.parse() {
            Ok(prior) => format!("four features for {}", words(prior)),
            Err(_) => set.into(),
        },
    }
}

/// How soon robots are found.
pub(super) fn bank(record: &Thrun1998Record) -> Option<Sheet> {
    let bank = record.bank.as_ref()?;
    let mut table = Table::new(["filters", "2 m", "4 m", "below 1 m", "of best", "95 %"]);
    for approach in &bank.approaches {
        let mut shares = bank.shares.iter();
        let share = shares.find(|share| share.approach == approach.approach);
        let interval = share.and_then(|share| share.ci95);
        table.row([
            text(titled(&approach.approach)),
            Cell::number(approach.error_at_m(2.0), 2),
            Cell::number(approach.error_at_m(4.0), 2),
            Cell::number(approach.below_1m_at_m, 1),
            Cell::number(share.and_then(|share| share.share), 2),
            interval.map_or(Cell::Missing, |[low, high]| {
                text(format!("{low:.2} to {high:.2}"))
            }),
        ]);
    }
    table.caption(format!(
        "{}: mean expected error (m) after so many metres, of {} trials on {} runs, each judged on in turn, from a start anywhere",
        named(&bank.set),
        bank.trials,
        bank.runs
    ));
    table
        .caption("by least expected error after the step, or by most expected information from it");
    table.caption("of best: the way until the mean error passes 1 m, as a share of that of the best set alone, which each");
    table.caption("  resample of the runs chooses anew; the paper's features for ±2 m need 9.5 m in its own corridor");
    table.caption(used(bank));
    Some(sheet("bank", "A bank of filters (not in the paper)", table))
}

/// Which sets were used most, in words.
fn used(bank: &BankRecord) -> String {
    let most = |row: &UsedRow| {
        let mut sets: Vec<_> = row.share.iter().collect();
        sets.sort_by(|a, b| b.1.total_cmp(a.1));
        let sets = sets.into_iter().take(2);
        let words: Vec<String> = sets
            .map(|(name, share)| {
                let prior = name.parse().map_or(name.clone(), words);
                format!("{prior} {:.0} %", 100.0 * share)
            })
            .collect();
        format!("at {} m {}", row.distance_m, words.join(", "))
    };
    let shown = bank
        .used
        .iter()
        .filter(|row| [0.0, 1.0, 4.0].contains(&row.distance_m));
    let shown: Vec<String> = shown.map(most).collect();
    format!(
        "one set a step by information uses most: {}",
        shown.join("; ")
    )
}
