//! Duckett & Nehmzow (1998): Tables 1 and 2, and Fig. 6.

use super::{
    answers::each,
    figure::{AGREES, Figure, in_rows, sentence},
    order::{Entrant, orders, pairs_sentence},
};
use crate::{
    error::Result,
    experiment::{
        compare::StandardCell,
        over_seeds::Reproduction,
        printed::{DUCKETT_1998, Duckett1998},
    },
    report::{
        Curve, Panel, Table,
        comparison::{Picture, Reader, Sheet},
        framed_plot,
        paper::{sheet, text},
    },
    score::MeanInterval,
};

type Printed = fn(&Duckett1998) -> f64;
type Here = fn(&StandardCell) -> Option<f64>;

/// A column of a table: heading, whose it is, decimals, what is printed and what is ours.
type Quantity = (&'static str, &'static str, usize, Printed, Here);

const EVIDENCE: &str = "evidence_based";
const LANDMARKS: &str = "landmark_classifier";
const DEAD_RECKONING: &str = "dead_reckoning";

const U: Here = |cell| Some(cell.record.mean_uncertainty_coefficient);
const H: Here = |cell| Some(cell.record.mean_entropy_of_location_given_response);

const TABLE_1: [Quantity; 3] = [
    (
        "location bins",
        EVIDENCE,
        0,
        |p| p.bins as f64,
        |cell| Some(cell.record.bins as f64),
    ),
    (
        "trials",
        EVIDENCE,
        0,
        |p| p.trials as f64,
        |cell| Some(cell.record.trials as f64),
    ),
    (
        "places in EBL's map",
        EVIDENCE,
        0,
        |p| p.places as f64,
        |cell| Some(cell.places as f64),
    ),
];

const TABLE_2: [Quantity; 5] = [
    (
        "EBL: m to U=0.9",
        EVIDENCE,
        1,
        |p| p.evidence_distance_m,
        |cell| cell.record.distance_at_coefficient_m,
    ),
    ("landmarks: U", LANDMARKS, 3, |p| p.landmarks[0], U),
    ("landmarks: H", LANDMARKS, 3, |p| p.landmarks[1], H),
    (
        "reckoning: U",
        DEAD_RECKONING,
        3,
        |p| p.dead_reckoning[0],
        U,
    ),
    (
        "reckoning: H",
        DEAD_RECKONING,
        3,
        |p| p.dead_reckoning[1],
        H,
    ),
];

/// Both tables, the order of the systems, and all figures for programs.
pub(super) fn sheets(reproduction: &Reproduction) -> Vec<Sheet> {
    let mut table_2 = table(reproduction, &TABLE_2);
    table_2.caption(
        "means over the 201 tables of 0 to 20 m; H in nats; EBL: evidence-based localisation; reckoning: dead reckoning",
    );
    let environments = environments(reproduction);
    let mut order = orders(&environments);
    order.caption("by mean U(L|R), which the paper prints of landmarks and dead reckoning alone");
    pairs_sentence(&environments)
        .into_iter()
        .for_each(|line| order.caption(line));
    let all: Vec<Figure> = [&TABLE_1[..], &TABLE_2[..]]
        .concat()
        .iter()
        .flat_map(|quantity| figures(reproduction, quantity))
        .collect();
    vec![
        sheet(
            "paper_table_1",
            "Table 1, the paper's and ours",
            table(reproduction, &TABLE_1),
        ),
        sheet("paper_table_2", "Table 2, the paper's and ours", table_2),
        sheet("order", "Order of the systems, the paper's and ours", order),
        Sheet {
            reader: Reader::Programs,
            ..sheet(
                "paper_figures",
                "All printed figures and ours",
                in_rows(&all),
            )
        },
    ]
}

fn figures(reproduction: &Reproduction, quantity: &Quantity) -> Vec<Figure> {
    let &(name, kind, decimals, printed, here) = quantity;
    let figure = |row: &Duckett1998| Figure {
        quantity: name.into(),
        place: row.environment.into(),
        printed: Some(printed(row)),
        decimals,
        values: each(
            reproduction,
            |r| r.standard.as_ref(),
            (kind, row.environment),
            here,
        ),
    };
    DUCKETT_1998.iter().map(figure).collect()
}

/// Environments as rows, quantities as columns.
fn table(reproduction: &Reproduction, quantities: &[Quantity]) -> Table {
    let columns: Vec<Vec<Figure>> = quantities
        .iter()
        .map(|quantity| figures(reproduction, quantity))
        .collect();
    let names = quantities.iter().map(|(name, ..)| *name);
    let mut table = Table::new(["environment", "from"].into_iter().chain(names));
    for (row, printed) in DUCKETT_1998.iter().enumerate() {
        let paper = columns.iter().map(|column| column[row].printed());
        let who = [text(printed.environment), text("paper")];
        table.row(who.into_iter().chain(paper));
        let ours = columns.iter().map(|column| column[row].ours());
        table.row([text(""), text("here")].into_iter().chain(ours));
    }
    table.caption("–: never reached, or failed, with every seed");
    table.caption(AGREES);
    for ((name, ..), column) in quantities.iter().zip(&columns) {
        table.caption(sentence(name, column));
    }
    table
}

/// The three systems of each environment, by mean U.
fn environments(reproduction: &Reproduction) -> Vec<(String, Vec<Entrant>)> {
    let entrants = |row: &Duckett1998| {
        let all: [(&str, &str, Option<f64>); 3] = [
            ("EBL", EVIDENCE, None),
            ("landmarks", LANDMARKS, Some(row.landmarks[0])),
            (
                "dead reckoning",
                DEAD_RECKONING,
                Some(row.dead_reckoning[0]),
            ),
        ];
        all.map(|(name, kind, printed)| Entrant {
            name: name.into(),
            printed,
            values: each(
                reproduction,
                |r| r.standard.as_ref(),
                (kind, row.environment),
                U,
            ),
        })
        .to_vec()
    };
    DUCKETT_1998
        .iter()
        .map(|row| (row.environment.to_string(), entrants(row)))
        .collect()
}

/// Fig. 6: U(L|R) over the distance travelled, mean over the seeds with its 95 % interval, an environment a picture.
pub(super) fn pictures(reproduction: &Reproduction) -> Result<Vec<Picture>> {
    let picture = |row: &Duckett1998| {
        let names = [
            (EVIDENCE, "EBL"),
            (LANDMARKS, "landmarks"),
            (DEAD_RECKONING, "dead reckoning"),
        ];
        let curves = names.map(|(kind, name)| curve(reproduction, kind, row.environment, name));
        let panel = Panel {
            y_label: "U(L|R)".into(),
            curves: curves.to_vec(),
            y_range: Some((0.0, 1.0)),
        };
        let title = format!(
            "Fig. 6, environment {}: mean of {} seeds",
            row.environment, reproduction.seeds.count
        );
        let svg = framed_plot(&title, "distance travelled (m)", &panel)?;
        Ok((format!("figure_6_{}", row.environment.to_lowercase()), svg))
    };
    DUCKETT_1998.iter().map(picture).collect()
}

fn curve(reproduction: &Reproduction, kind: &str, environment: &str, name: &str) -> Curve {
    let by_distance = each(
        reproduction,
        |r| r.standard.as_ref(),
        (kind, environment),
        |cell| {
            let rows = cell.record.by_distance.iter();
            Some(
                rows.map(|at| (at.distance_m, at.uncertainty_coefficient))
                    .collect::<Vec<_>>(),
            )
        },
    );
    let seeds: Vec<Vec<(f64, Option<f64>)>> = by_distance.into_iter().flatten().collect();
    let rows = seeds.iter().map(Vec::len).min().unwrap_or(0);
    let mean_at = |row: usize| {
        let values: Vec<f64> = seeds.iter().filter_map(|seed| seed[row].1).collect();
        MeanInterval::of(&values)
    };
    let means: Vec<Option<MeanInterval>> = (0..rows).map(mean_at).collect();
    let end = |end: usize| -> Vec<f64> {
        let ends = means.iter().map(|mean| mean.and_then(|mean| mean.ci95));
        ends.map(|ci| ci.map_or(f64::NAN, |ci| ci[end])).collect()
    };
    Curve {
        name: name.into(),
        x: (0..rows).map(|row| seeds[0][row].0).collect(),
        y: means
            .iter()
            .map(|mean| mean.map_or(f64::NAN, |mean| mean.mean))
            .collect(),
        band: Some((end(0), end(1))),
    }
}
