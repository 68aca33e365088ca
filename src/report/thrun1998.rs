//! The figures of Thrun (1998), ours beside what is printed.

mod bank;
mod choices;
mod for_programs;
mod global;
mod pictures;

pub use pictures::pictures;

use super::{
    Cell, Table,
    comparison::Sheet,
    paper::{sheet, text, with_half},
};
use crate::{
    experiment::{
        printed::{THRUN_1998_FIG_3, THRUN_1998_SETS, THRUN_1998_TABLE_3},
        thrun1998::{ReductionRow, SetRecord, Thrun1998Record, local, priors, words},
    },
    score::MeanInterval,
};
use bank::bank;
use choices::choices;
use for_programs::{all_errors, all_reductions};
use global::{figure_6, readings};

/// Features of Fig. 4 and Fig. 6.
const LOCAL_FEATURES: usize = 4;

/// Its tables.
pub fn sheets(record: &Thrun1998Record) -> Vec<Sheet> {
    let mut sheets = vec![
        table_3(record),
        by_uncertainty(
            record,
            "figure_3",
            "Fig. 3: one feature, trained for the prior that it is judged under",
            1,
        ),
        by_uncertainty(
            record,
            "figure_4",
            "Fig. 4: four features trained for ±2 m, under other priors",
            LOCAL_FEATURES,
        ),
        figure_6(record),
    ];
    sheets.extend(readings(record));
    sheets.extend(harder(record));
    sheets.extend(bank(record));
    sheets.extend(choices(record));
    sheets.push(all_reductions(record));
    sheets.push(all_errors(record));
    sheets
}

/// As the paper calls a data set.
fn named(set: &str) -> String {
    set.replacen('d', "D-", 1)
}

/// As tables call an approach.
fn titled(approach: &str, features: usize) -> String {
    match approach {
        "door" => "doors".into(),
        "ceiling_light" => "ceiling lights".into(),
        "kernel" => "raw-scan kernel".into(),
        _ => format!("BaLL, n = {features}"),
    }
}

/// The landmarks chosen by people that a data set has: those of its first row.
fn chosen(set: &SetRecord) -> &str {
    set.rows.first().map_or("door", |row| &row.approach)
}

/// A share in per cent.
fn bare_percent(mean: Option<MeanInterval>) -> Cell {
    Cell::number(mean.map(|mean| 100.0 * mean.mean), 1)
}

/// A share in per cent, with half of its interval.
fn percent(mean: Option<MeanInterval>) -> Cell {
    mean.map_or(Cell::Missing, |mean| with_half(&mean, 100.0))
}

/// Which column of the paper's tables a data set is.
fn number_of(set: &SetRecord) -> Option<usize> {
    THRUN_1998_SETS.iter().position(|name| *name == set.name)
}

/// Table 3: ±2 m.
fn table_3(record: &Thrun1998Record) -> Sheet {
    let sets = record.sets.iter().map(|set| named(&set.name));
    let headers = ["approach", "from"].map(String::from).into_iter();
    let mut table = Table::new(headers.chain(sets));
    let prior = Some(local());
    let row_of = |set: &'_ SetRecord, approach: &str, features: usize| -> Option<ReductionRow> {
        let trained_for = prior.filter(|_| approach == "ball");
        set.row(approach, features, trained_for, prior?).cloned()
    };
    for printed in THRUN_1998_TABLE_3 {
        let (approach, n) = (printed.approach, printed.features);
        let paper = record.sets.iter().map(|set| {
            match number_of(set).and_then(|number| printed.reduction[number]) {
                Some([mean, half]) => text(format!("{mean:.1} ± {half:.1}")),
                None => Cell::Missing,
            }
        });
        let name = titled(approach, n);
        table.row([text(name), text("paper")].into_iter().chain(paper));
        let by_objective = record
            .sets
            .iter()
            .map(|set| percent(row_of(set, approach, n).and_then(|row| row.objective)));
        table.row([text(""), text("here")].into_iter().chain(by_objective));
        let held_out = record
            .sets
            .iter()
            .map(|set| percent(row_of(set, approach, n).and_then(|row| row.held_out)));
        table.row([text(""), text("held out")].into_iter().chain(held_out));
    }
    let kernel = record
        .sets
        .iter()
        .map(|set| percent(row_of(set, "kernel", 0).and_then(|row| row.held_out)));
    table.row(
        [text(titled("kernel", 0)), text("held out")]
            .into_iter()
            .chain(kernel),
    );
    let correlation = record
        .sets
        .iter()
        .map(|set| Cell::Number(set.correlation.mean, 2));
    table.row(
        [text("|correlation| of two of four features"), text("here")]
            .into_iter()
            .chain(correlation),
    );
    table.caption("share of the error that one snapshot takes away, %, ± half of the 95 % interval over the runs judged on");
    table.caption("here: eq. 42 on the snapshots of the run that is judged on, as the paper; held out: by the map of the");
    table.caption("  other runs, which is what a robot has");
    table.caption("the kernel is not in the paper; of six bandwidths it has the best on the very run that is judged on");
    sheet("table_3", "Table 3: one snapshot at ±2 m", table)
}

/// Rows of one of the curves over priors.
fn curve_rows<'r>(
    set: &'r SetRecord,
    features: usize,
) -> Vec<(String, Vec<Option<&'r ReductionRow>>)> {
    let of = |approach: &str, n: usize| -> Vec<Option<&'r ReductionRow>> {
        let row = |prior| {
            let trained_for = match (approach, n) {
                ("ball", 1) => Some(prior),
                ("ball", _) => Some(local()),
                _ => None,
            };
            set.row(approach, n, trained_for, prior)
        };
        priors().into_iter().map(row).collect()
    };
    [(chosen(set), 1), ("ball", features), ("kernel", 0)]
        .map(|(approach, n)| (approach.to_string(), of(approach, n)))
        .to_vec()
}

fn by_uncertainty(record: &Thrun1998Record, name: &str, title: &str, features: usize) -> Sheet {
    let headers = ["data set", "approach", "from"]
        .map(String::from)
        .into_iter();
    let mut table = Table::new(headers.chain(priors().into_iter().map(words)));
    for set in &record.sets {
        for (approach, rows) in curve_rows(set, features) {
            let n = if approach == "ball" { features } else { 1 };
            let label = titled(&approach, n);
            let printed = |prior| {
                let mut all = THRUN_1998_FIG_3.iter();
                let known = all.find(|(of, name, half_width_m, _)| {
                    Some(*of) == number_of(set)
                        && *name == approach
                        && words(prior) == format!("±{half_width_m} m")
                });
                Cell::number(known.map(|known| known.3), 1)
            };
            if features == 1 && approach != "kernel" {
                let cells = priors().into_iter().map(printed);
                table.row(
                    [text(named(&set.name)), text(label.clone()), text("paper")]
                        .into_iter()
                        .chain(cells),
                );
            }
            if approach != "kernel" {
                let cells = rows
                    .iter()
                    .map(|row| bare_percent(row.and_then(|row| row.objective)));
                table.row(
                    [text(named(&set.name)), text(label.clone()), text("here")]
                        .into_iter()
                        .chain(cells),
                );
            }
            let cells = rows
                .iter()
                .map(|row| bare_percent(row.and_then(|row| row.held_out)));
            table.row(
                [text(named(&set.name)), text(label), text("held out")]
                    .into_iter()
                    .chain(cells),
            );
        }
    }
    table.caption("%, as in Table 3, whose intervals are as wide; all are in `reductions.csv`. Of the paper, what its text tells");
    sheet(name, title, table)
}

/// Why the corridor is easier than the paper's.
fn harder(record: &Thrun1998Record) -> Option<Sheet> {
    let set = record.sets.first()?;
    let mut table = Table::new(["corridor", "approach", "here (%)", "held out (%)"]);
    for (approach, features) in [(chosen(set), 1), ("ball", 1), ("ball", LOCAL_FEATURES)] {
        let trained_for = Some(local()).filter(|_| approach == "ball");
        let row = set.row(approach, features, trained_for, local())?;
        let name = titled(approach, features);
        let cells = [percent(row.objective), percent(row.held_out)];
        table.row([text("as it is"), text(name)].into_iter().chain(cells));
    }
    for harder in &record.harder {
        let cells = [
            percent(Some(harder.objective)),
            percent(Some(harder.held_out)),
        ];
        let name = titled(&harder.approach, harder.features);
        table.row([text(&harder.name), text(name)].into_iter().chain(cells));
    }
    table.caption(format!(
        "{}, ±2 m; the paper's figures stand in Table 3",
        named(&set.name)
    ));
    let title = "Why more than the paper's: guesses tried";
    (!record.harder.is_empty()).then(|| sheet("harder", title, table))
}
