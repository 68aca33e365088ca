//! Every figure with its interval, for other programs.

use crate::{
    experiment::thrun1998::Thrun1998Record,
    report::{
        Cell, Table,
        comparison::{Reader, Sheet},
        paper::{sheet, text},
    },
    score::MeanInterval,
};

/// Error reductions.
pub(super) fn all_reductions(record: &Thrun1998Record) -> Sheet {
    let mut table = Table::new([
        "set",
        "approach",
        "features",
        "trained_for",
        "judged_at",
        "objective",
        "objective_low",
        "objective_high",
        "held_out",
        "held_out_low",
        "held_out_high",
    ]);
    for set in &record.sets {
        for row in &set.rows {
            let trained_for = row
                .trained_for
                .map_or(Cell::Missing, |prior| text(prior.to_string()));
            let cells = [row.objective, row.held_out]
                .into_iter()
                .flat_map(of_interval);
            let names = [
                text(&set.name),
                text(&row.approach),
                Cell::Count(row.features as u64),
                trained_for,
                text(row.judged_at.to_string()),
            ];
            table.row(names.into_iter().chain(cells));
        }
    }
    Sheet {
        reader: Reader::Programs,
        ..sheet("reductions", "Error reductions", table)
    }
}

/// Errors over distance.
pub(super) fn all_errors(record: &Thrun1998Record) -> Sheet {
    let mut table = Table::new([
        "set",
        "approach",
        "distance_m",
        "expected_error_m",
        "low",
        "high",
    ]);
    for global in &record.global {
        for row in &global.error_by_distance {
            let names = [
                text(&global.set),
                text(&global.approach),
                Cell::Number(row.distance_m, 1),
            ];
            table.row(
                names
                    .into_iter()
                    .chain(of_interval(Some(row.expected_error_m))),
            );
        }
    }
    Sheet {
        reader: Reader::Programs,
        ..sheet("errors", "Errors over distance", table)
    }
}

fn of_interval(mean: Option<MeanInterval>) -> [Cell; 3] {
    let ci95 = mean.and_then(|mean| mean.ci95);
    [
        mean.map(|mean| mean.mean),
        ci95.map(|ci| ci[0]),
        ci95.map(|ci| ci[1]),
    ]
    .map(|value| Cell::number(value, 4))
}
