//! Tables of recognition: who tells most with as many responses as the others, and whether that is more than chance.

use super::{Reader, Sheet, by_dataset, caption, matrix, no_answer, reader_of_matrix, who};
use crate::{
    experiment::compare::{ComparisonRecord, Outcome, PairedTest},
    report::{Cell, Table},
    score::Caution,
};

/// The matrix of coefficients, everything about everyone, and the tests between them.
pub(super) fn sheets(record: &ComparisonRecord) -> Vec<Sheet> {
    let Some(section) = &record.recognition else {
        return Vec::new();
    };
    let bins = format!("bins of {} m", section.config.bin_m);
    let sheet = |name: &str, title: String, table| Sheet {
        name: name.into(),
        title,
        table,
        reader: Reader::Everyone,
    };
    let mut sheets = vec![
        sheet(
            "recognition-matrix",
            format!("Recognition: U(L|R) with as many responses as each other, {bins}"),
            matrix(record, section, |cell| {
                cell.judgement.uncertainty_coefficient
            }),
        ),
        sheet(
            "recognition",
            format!("Recognition: {bins}"),
            everything(record),
        ),
    ];
    sheets[0].reader = reader_of_matrix(record);
    if !record.recognition_tests.is_empty() {
        let title = "Recognition: are the differences between systems more than chance?";
        sheets.push(sheet("recognition-tests", title.into(), tests(record)));
        let mut pairs = sheet("recognition-pairs", title.into(), pairs(record));
        pairs.reader = Reader::Programs;
        sheets.push(pairs);
    }
    sheets
}

fn everything(record: &ComparisonRecord) -> Table {
    let mut table = Table::new([
        "dataset",
        "system",
        "n",
        "bins",
        "responses",
        "patterns",
        "U",
        "corrected",
        "low",
        "high",
        "p",
        "silent %",
        "bytes each",
    ]);
    let mut as_they_are: Vec<&str> = Vec::new();
    let mut cautions = Vec::new();
    for (dataset, system, outcome) in record.recognition.iter().flat_map(by_dataset) {
        let mut row = who(record, dataset, system);
        match outcome {
            Outcome::Done(cell) => {
                let judged = &cell.judgement;
                let name = record.systems[system].name.as_str();
                if cell.wanted.is_none() && !as_they_are.contains(&name) {
                    as_they_are.push(name);
                }
                let caution = Caution::of(
                    judged.n,
                    judged.locations,
                    judged.uncertainty_coefficient,
                    judged.uncertainty_coefficient_corrected,
                );
                cautions.extend(caution.map(|caution| (caution, dataset, system)));
                row.extend([
                    Cell::Count(judged.n as u64),
                    Cell::Count(judged.locations as u64),
                    Cell::Count(cell.responses as u64),
                    Cell::Count(cell.patterns as u64),
                    Cell::number(judged.uncertainty_coefficient, 3),
                    Cell::number(judged.uncertainty_coefficient_corrected, 3),
                    Cell::number(judged.ci95.map(|ci| ci[0]), 3),
                    Cell::number(judged.ci95.map(|ci| ci[1]), 3),
                    Cell::number(judged.permutation_p, 3),
                    Cell::Number(100.0 * cell.unanswered, 1),
                    Cell::Count(cell.bytes_per_place as u64),
                ]);
            }
            other => row.push(no_answer(&mut table, other)),
        }
        table.row(row);
    }
    table.caption(
        "n = snapshots; responses = different ones in the test, for whose number one constant of each system was\n  \
         searched; patterns = kept; corrected = for chance, low, high = its 95 % interval; p = by permutations;\n  \
         silent = share of answers that are none; bytes each = of a pattern",
    );
    if !as_they_are.is_empty() {
        table.caption(format!(
            "as they are, since no constant of theirs changes the number of responses: {}",
            as_they_are.join(", ")
        ));
    }
    for line in caption::cautions(record, &cautions) {
        table.caption(line);
    }
    table
}

/// As Table 3 of Duckett & Nehmzow (2000), with the corrected values below the diagonal.
fn tests(record: &ComparisonRecord) -> Table {
    let systems = record
        .recognition
        .iter()
        .flat_map(|section| &section.systems);
    let systems: Vec<usize> = systems.copied().collect();
    let name = |&system: &usize| record.systems[system].name.clone();
    let mut table = Table::new(std::iter::once("p".to_string()).chain(systems.iter().map(name)));
    for row in &systems {
        let mut cells = vec![Cell::Text(name(row))];
        cells.extend(systems.iter().map(|column| {
            let test = |a: usize, b: usize| find(record, a, b);
            match row.cmp(column) {
                std::cmp::Ordering::Less => {
                    Cell::number(test(*row, *column).and_then(|test| test.p), 3)
                }
                std::cmp::Ordering::Equal => Cell::Missing,
                std::cmp::Ordering::Greater => {
                    Cell::number(test(*column, *row).and_then(|test| test.p_holm), 3)
                }
            }
        }));
        table.row(cells);
    }
    table.caption(format!(
        "above the diagonal: p of Student's t-test for paired samples, two-sided, over {} datasets; below: the same,\n  \
         corrected for the number of tests (Holm 1979); –: too few datasets, or no spread",
        record.datasets.len()
    ));
    table
}

fn find(record: &ComparisonRecord, a: usize, b: usize) -> Option<&PairedTest> {
    let mut tests = record.recognition_tests.iter();
    tests.find(|test| test.systems == [a, b])
}

fn pairs(record: &ComparisonRecord) -> Table {
    let mut table = Table::new(["system", "other", "datasets", "t", "p", "p_holm"]);
    for test in &record.recognition_tests {
        let [a, b] = test
            .systems
            .map(|system| record.systems[system].name.clone());
        table.row([
            Cell::Text(a),
            Cell::Text(b),
            Cell::Count(test.n as u64),
            Cell::number(test.t, 3),
            Cell::number(test.p, 4),
            Cell::number(test.p_holm, 4),
        ]);
    }
    table
}
