//! Fig. 6 of Thrun (1998), and the readings that one bit of information takes.

use super::{LOCAL_FEATURES, named, titled};
use crate::{
    experiment::{
        printed::{THRUN_1998_FIG_6, THRUN_1998_READINGS},
        thrun1998::Thrun1998Record,
    },
    report::{
        Cell, Table,
        comparison::Sheet,
        paper::{sheet, text},
    },
};

/// Fig. 6: errors over distance.
pub(super) fn figure_6(record: &Thrun1998Record) -> Sheet {
    let mut table = Table::new([
        "data set",
        "approach",
        "4 m",
        "9.5 m",
        "30 m",
        "below 1 m",
        "as landmarks",
    ]);
    let [below_1m_m, doors_m, as_good_m] = THRUN_1998_FIG_6;
    let number = Cell::Number;
    table.row([
        text("D-1, paper"),
        text("doors"),
        Cell::Missing,
        Cell::Missing,
        number(doors_m, 2),
        Cell::Missing,
        Cell::Missing,
    ]);
    table.row([
        text("D-1, paper"),
        text("BaLL, n = 4"),
        number(doors_m, 2),
        text("below 1"),
        Cell::Missing,
        number(below_1m_m, 1),
        number(as_good_m, 1),
    ]);
    for global in &record.global {
        let chosen = record
            .global
            .iter()
            .find(|other| other.set == global.set && other.approach != "ball");
        let as_good = chosen
            .filter(|_| global.approach == "ball")
            .and_then(|chosen| global.below_m(chosen.error_at_m(30.0)?));
        table.row([
            text(named(&global.set)),
            text(titled(&global.approach, LOCAL_FEATURES)),
            Cell::number(global.error_at_m(4.0), 2),
            Cell::number(global.error_at_m(9.5), 2),
            Cell::number(global.error_at_m(30.0), 2),
            Cell::number(global.below_1m_at_m, 1),
            Cell::number(as_good, 1),
        ]);
    }
    table.caption(format!(
        "mean expected error (m) after so many metres, of {} trials on each of {} runs, from a start anywhere",
        record.config.trials, record.config.runs
    ));
    table.caption("below 1 m: after how many metres that is so of the mean; as landmarks: after how many metres BaLL is as");
    table.caption("  accurate as the landmarks are after 30 m; –: not told, or never");
    sheet("figure_6", "Fig. 6: global localisation", table)
}

/// Readings for one bit of information.
pub(super) fn readings(record: &Thrun1998Record) -> Option<Sheet> {
    let here = record.readings.as_ref()?;
    let mut table = Table::new(["quantity", "paper", "here"]);
    let [by_length, by_error] = [here.bits_of_length, here.bits_of_error];
    let ours = [
        here.readings,
        by_length,
        by_error,
        here.readings / by_length,
        here.readings / by_error,
        here.predicted_by_length,
        here.predicted_by_error,
    ];
    for ((quantity, paper, decimals), here) in THRUN_1998_READINGS.into_iter().zip(ours) {
        table.row([
            text(quantity),
            Cell::Number(paper, decimals),
            Cell::Number(here, decimals),
        ]);
    }
    table.row([
        text("found in twice the length"),
        Cell::Missing,
        Cell::number(here.found_in_doubled, 0),
    ]);
    table.caption("the paper predicts 23 and did not try; –: not tried, or never below 1 m");
    Some(sheet("readings", "Readings for one bit (5.2.4)", table))
}
