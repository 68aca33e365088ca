//! What came of carrying robots away, for readers and as CSV.

use super::{Cell, Record, Table};
use crate::{
    experiment::kidnapping::{Kidnapped, Recovery, Way},
    score::{Auroc, FEW},
};

/// One row a method that was kidnapped; a table without rows where none was.
pub fn kidnapping(record: &Record) -> Table {
    let mut table = Table::new([
        "kidnapped",
        "right",
        "none %",
        "floor %",
        "m",
        "restart %",
        "m",
        "says %",
        "AUROC",
        "harm %",
    ]);
    let mut is_marked = false;
    let mut first: Option<&Kidnapped> = None;
    for result in &record.results {
        let Some(kidnapped) = &result.kidnapped else {
            continue;
        };
        first = first.or(Some(kidnapped));
        let way = |way: Way| kidnapped.ways.iter().find(|recovery| recovery.way == way);
        let localised = way(Way::Floor).map_or(0, |recovery| recovery.localised);
        let mut row = vec![
            Cell::Text(result.title.clone()),
            Cell::Count(localised as u64),
        ];
        for recovery in [Way::Nothing, Way::Floor, Way::Restart].map(way) {
            let is_uncertain = |r: &Recovery| r.localised < FEW || r.recovered_ci95.is_none();
            let is_uncertain = recovery.is_none_or(is_uncertain);
            let mut figure = |value: Option<f64>, decimals: usize| match value {
                Some(value) if is_uncertain => {
                    is_marked = true;
                    Cell::Uncertain(value, decimals)
                }
                value => Cell::number(value, decimals),
            };
            let share = recovery.and_then(|recovery| recovery.recovered);
            row.push(figure(share.map(|share| 100.0 * share), 0));
            if recovery.is_some_and(|recovery| recovery.way != Way::Nothing) {
                row.push(figure(recovery.and_then(|r| r.recovered_after_m), 1));
            }
        }
        let noticed = kidnapped.noticed.map(|share| 100.0 * share);
        row.push(Cell::number(noticed, 0));
        let auroc = kidnapped.lost_auroc.map(|auroc| auroc.value);
        row.push(Cell::number(auroc, 3));
        let harm = kidnapped.harm.as_ref();
        let harm = harm.and_then(|test| test.found_difference);
        row.push(Cell::number(harm.map(|found| -100.0 * found), 0));
        table.row(row);
    }
    if let Some(kidnapped) = first {
        table.caption(format!(
            "carried away without a word after {} m, in {} trials that start anywhere",
            kidnapped.after_m, kidnapped.trials
        ));
        for line in [
            "right = trials in which the robot was right within 1 m by then; of these, those in which it is\n  found again, and m = median metres from the jump until then: by evidence as it is (none), with a\n  floor below which no snapshot rules a place out (as in the table above), with a restart as well",
            "says % = trials in which it says that it is lost before it is found again; AUROC = of the lost\n  score after the jump; harm % = trials without a jump that the restart alone does not find",
        ] {
            table.caption(line);
        }
    }
    if is_marked {
        table
            .caption("* over fewer than 10 trials, or those of a single run or stretch: uncertain");
    }
    table
}

/// All of it, one row a method and way.
pub fn kidnapping_figures(record: &Record) -> Table {
    let mut table = Table::new([
        "system",
        "way",
        "after_m",
        "trials",
        "localised",
        "recovered",
        "recovered_low95",
        "recovered_high95",
        "recovered_after_m",
        "noticed",
        "noticed_after_m",
        "lost_auroc",
        "lost_auroc_low95",
        "lost_auroc_high95",
        "mass_auroc",
        "gain_found",
        "gain_found_p",
        "gain_distance_m",
        "gain_distance_p",
        "harm_found",
        "harm_found_p",
        "harm_distance_m",
        "harm_distance_p",
        "harm_error_m",
        "harm_error_p",
    ]);
    for result in &record.results {
        let Some(kidnapped) = &result.kidnapped else {
            continue;
        };
        for recovery in &kidnapped.ways {
            let of = |way: Way, value: Option<f64>| value.filter(|_| recovery.way == way);
            let floor = |value: Option<f64>| of(Way::Floor, value);
            let interval = recovery.recovered_ci95;
            let auroc = |of: fn(Auroc) -> Option<f64>| floor(kidnapped.lost_auroc.and_then(of));
            let name = match recovery.way {
                Way::Nothing => "nothing",
                Way::Floor => "floor",
                Way::Restart => "restart",
            };
            let mut row = vec![
                Cell::Text(result.name.clone()),
                Cell::Text(name.into()),
                Cell::Number(kidnapped.after_m, 2),
                Cell::Count(kidnapped.trials as u64),
                Cell::Count(recovery.localised as u64),
            ];
            let mut figures = vec![
                recovery.recovered,
                interval.map(|ci95| ci95[0]),
                interval.map(|ci95| ci95[1]),
                recovery.recovered_after_m,
                floor(kidnapped.noticed),
                floor(kidnapped.noticed_after_m),
                auroc(|auroc| Some(auroc.value)),
                auroc(|auroc| auroc.ci95.map(|ci95| ci95[0])),
                auroc(|auroc| auroc.ci95.map(|ci95| ci95[1])),
                floor(kidnapped.mass_auroc.map(|auroc| auroc.value)),
            ];
            let (gain, harm) = (kidnapped.gain.as_ref(), kidnapped.harm.as_ref());
            figures.extend(
                [
                    gain.and_then(|test| test.found_difference),
                    gain.and_then(|test| test.p_found),
                    gain.and_then(|test| test.distance_difference_m),
                    gain.and_then(|test| test.p_distance),
                    harm.and_then(|test| test.found_difference),
                    harm.and_then(|test| test.p_found),
                    harm.and_then(|test| test.distance_difference_m),
                    harm.and_then(|test| test.p_distance),
                    harm.and_then(|test| test.error_difference_m),
                    harm.and_then(|test| test.p),
                ]
                .map(|value| of(Way::Restart, value)),
            );
            row.extend(figures.into_iter().map(|value| Cell::number(value, 4)));
            table.row(row);
        }
    }
    table
}
