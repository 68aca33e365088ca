//! A paper's tables, ours beside what is printed.

use super::{
    Cell, Table,
    comparison::Sheet,
    paper::{sheet, text},
};
use crate::experiment::{
    compare::{ComparisonRecord, Section, StandardCell},
    printed::{DUCKETT_1998, DUCKETT_2000, DUCKETT_2000_P, DUCKETT_2000_SYSTEMS, Duckett1998},
    reproduce::Paper,
};

/// The tables of a paper, from the record of its [comparison](Paper::comparison).
pub fn sheets(paper: Paper, record: &ComparisonRecord) -> Vec<Sheet> {
    match paper {
        // No comparisons: `report::thrun1998` and `report::ruizmayor2006` have their tables.
        Paper::Thrun1998 | Paper::Ruizmayor2006 => Vec::new(),
        Paper::Duckett1998 => vec![duckett1998(record)],
        Paper::Duckett2000 => vec![coefficients(record), responses(record), tests(record)],
    }
}

/// D98 Tables 1 and 2.
fn duckett1998(record: &ComparisonRecord) -> Sheet {
    type Printed = fn(&Duckett1998) -> f64;
    type Here = fn(&StandardCell) -> Option<f64>;
    let coefficient: Here = |cell| Some(cell.record.mean_uncertainty_coefficient);
    let entropy: Here = |cell| Some(cell.record.mean_entropy_of_location_given_response);
    let rows: [(&str, &str, usize, Printed, Here); 8] = [
        (
            "location bins",
            "evidence_based",
            0,
            |p| p.bins as f64,
            |cell| Some(cell.record.bins as f64),
        ),
        (
            "trials",
            "evidence_based",
            0,
            |p| p.trials as f64,
            |cell| Some(cell.record.trials as f64),
        ),
        (
            "places in the map of evidence-based localisation",
            "evidence_based",
            0,
            |p| p.places as f64,
            |cell| Some(cell.places as f64),
        ),
        (
            "evidence-based localisation: distance to U = 0.9 (m)",
            "evidence_based",
            1,
            |p| p.evidence_distance_m,
            |cell| cell.record.distance_at_coefficient_m,
        ),
        (
            "landmarks, mean U(L|R)",
            "landmark_classifier",
            3,
            |p| p.landmarks[0],
            coefficient,
        ),
        (
            "landmarks, mean H(L|R) (nats)",
            "landmark_classifier",
            3,
            |p| p.landmarks[1],
            entropy,
        ),
        (
            "dead reckoning, mean U(L|R)",
            "dead_reckoning",
            3,
            |p| p.dead_reckoning[0],
            coefficient,
        ),
        (
            "dead reckoning, mean H(L|R) (nats)",
            "dead_reckoning",
            3,
            |p| p.dead_reckoning[1],
            entropy,
        ),
    ];
    let environments = DUCKETT_1998.map(|row| row.environment);
    let headers = ["quantity", "from"].into_iter().chain(environments);
    let mut table = Table::new(headers);
    for (quantity, kind, decimals, printed, here) in rows {
        let paper = DUCKETT_1998
            .iter()
            .map(|row| Cell::Number(printed(row), decimals));
        table.row([text(quantity), text("paper")].into_iter().chain(paper));
        let ours = environments.map(|environment| {
            let cell = done(record, record.standard.as_ref(), kind, environment);
            Cell::number(cell.and_then(here), decimals)
        });
        table.row([text(""), text("here")].into_iter().chain(ours));
    }
    table.caption("–: never reached, or failed. means over the 201 tables of 0 to 20 m");
    sheet(
        "paper_tables_1_2",
        "Tables 1 and 2, the paper's and ours",
        table,
    )
}

/// D00 Table 2.
fn coefficients(record: &ComparisonRecord) -> Sheet {
    let environments = DUCKETT_2000.map(|row| row.environment);
    let headers = ["system", "from"]
        .into_iter()
        .chain(environments)
        .chain(["mean"]);
    let mut table = Table::new(headers);
    for (number, system) in DUCKETT_2000_SYSTEMS.iter().enumerate() {
        let printed = DUCKETT_2000.map(|row| Some(row.coefficient[number]));
        let here = environments.map(|environment| {
            let cell = done(
                record,
                record.recognition.as_ref(),
                system.name,
                environment,
            );
            cell.and_then(|cell| cell.judgement.uncertainty_coefficient)
        });
        for (who, whose, row) in [(system.printed, "paper", printed), ("", "here", here)] {
            let sum: Option<f64> = row.iter().copied().sum();
            let mean = sum.map(|sum| sum / row.len() as f64);
            let cells = row.into_iter().chain([mean]).map(|u| Cell::number(u, 3));
            table.row([text(who), text(whose)].into_iter().chain(cells));
        }
    }
    table.caption(
        "–: failed, see below. The paper prints 0.509 for ART2's mean; its row gives 0.511",
    );
    sheet(
        "paper_table_2",
        "Table 2, U(L|R), the paper's and ours",
        table,
    )
}

/// D00 Table 1, N_R.
fn responses(record: &ComparisonRecord) -> Sheet {
    let headers = ["environment", "paper"];
    let systems = DUCKETT_2000_SYSTEMS.map(|system| system.printed);
    let mut table = Table::new(headers.into_iter().chain(systems));
    for row in DUCKETT_2000 {
        let here = DUCKETT_2000_SYSTEMS.map(|system| {
            let cell = done(
                record,
                record.recognition.as_ref(),
                system.name,
                row.environment,
            );
            cell.map_or(Cell::Missing, |cell| Cell::Count(cell.responses as u64))
        });
        let printed = [text(row.environment), Cell::Count(row.responses as u64)];
        table.row(printed.into_iter().chain(here));
    }
    sheet(
        "paper_table_1",
        "Table 1, the number of responses N_R, the paper's and ours",
        table,
    )
}

/// D00 Table 3.
fn tests(record: &ComparisonRecord) -> Sheet {
    let mut table = Table::new([
        "pair",
        "p, paper",
        "p, here",
        "t, here",
        "p after Holm, here",
    ]);
    for (one, other, printed) in DUCKETT_2000_P {
        let test = record.recognition_tests.iter().find(|test| {
            let names = test
                .systems
                .map(|system| record.systems[system].name.as_str());
            names == [one, other] || names == [other, one]
        });
        table.row([
            text(format!("{one} – {other}")),
            Cell::Number(printed, 2),
            Cell::number(test.and_then(|test| test.p), 4),
            Cell::number(test.and_then(|test| test.t), 2),
            Cell::number(test.and_then(|test| test.p_holm), 4),
        ]);
    }
    table.caption("Student's t-test for paired samples, two-sided; the paper prints max(0.01, p), and corrects for no number of tests");
    sheet("paper_table_3", "Table 3, the paper's and ours", table)
}

/// The answer of the system of a kind on the dataset of a name.
fn done<'a, C, T>(
    record: &ComparisonRecord,
    section: Option<&'a Section<C, T>>,
    kind: &str,
    dataset: &str,
) -> Option<&'a T> {
    let section = section?;
    let is_kind = |&&system: &&usize| record.systems[system].kind == kind;
    let row = section.systems.iter().position(|system| is_kind(&system))?;
    let column = record.datasets.iter().position(|d| d.name == dataset)?;
    section.cells.get(row)?.get(column)?.done()
}
