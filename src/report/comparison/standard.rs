//! Tables and pictures of the standard experiment.

use super::caption::{cautions as cautions_by_dataset, notes_by_dataset};
use super::{Picture, Reader, Sheet, by_dataset, matrix, no_answer, reader_of_matrix, who};
use crate::{
    error::Result,
    experiment::compare::{ComparisonRecord, Outcome},
    report::{Cell, Curve, Panel, Table, framed_plot},
    score::Caution,
};

/// The matrix of means, all that is judged, how everybody answered, and the curves.
pub(super) fn sheets(record: &ComparisonRecord) -> Vec<Sheet> {
    let Some(section) = &record.standard else {
        return Vec::new();
    };
    let config = &section.config;
    let trials = format!(
        "trials of {} m, one every {} s, bins of {} m",
        config.trial_m, config.every_s, config.bin_m
    );
    let means = matrix(record, section, |cell| {
        Some(cell.record.mean_uncertainty_coefficient)
    });
    let sheet = |name: &str, title: &str, table, reader| Sheet {
        name: name.into(),
        title: format!("Standard experiment{title}: {trials}"),
        table,
        reader,
    };
    let of_matrix = reader_of_matrix(record);
    vec![
        sheet("standard-matrix", ", mean U(L|R)", means, of_matrix),
        sheet("standard", "", judged(record), Reader::Everyone),
        sheet(
            "standard-answers",
            ", answers",
            answers(record),
            Reader::Everyone,
        ),
        sheet(
            "standard-curves",
            ", by distance",
            curves(record),
            Reader::Programs,
        ),
    ]
}

fn judged(record: &ComparisonRecord) -> Table {
    let Some(section) = &record.standard else {
        return Table::default();
    };
    let reached = section.config.coefficient_to_reach;
    let words = |word: &str| word.to_string();
    let mut headers = ["dataset", "system", "trials", "bins", "mean U", "corrected"]
        .map(words)
        .to_vec();
    headers.extend(["low", "high", "H(L|R) nats"].map(words));
    headers.extend([
        format!("m to {reached}"),
        words("for good m"),
        words("end U"),
        words("posterior U"),
    ]);
    let mut table = Table::new(headers);
    let mut notes: Vec<(usize, &String)> = Vec::new();
    let mut cautions = Vec::new();
    for (dataset, system, outcome) in by_dataset(section) {
        let mut row = who(record, dataset, system);
        match outcome {
            Outcome::Done(cell) => {
                let record_of = &cell.record;
                let interval =
                    |end: usize| Cell::number(record_of.ci95_of_mean.map(|ci| ci[end]), 3);
                row.extend([
                    Cell::Count(record_of.trials as u64),
                    Cell::Count(record_of.bins as u64),
                    Cell::Number(record_of.mean_uncertainty_coefficient, 3),
                    Cell::number(record_of.mean_uncertainty_coefficient_corrected, 3),
                    interval(0),
                    interval(1),
                    Cell::Number(record_of.mean_entropy_of_location_given_response, 3),
                    Cell::number(record_of.distance_at_coefficient_m, 1),
                    Cell::number(record_of.distance_from_coefficient_on_m, 1),
                    Cell::number(record_of.at_end.uncertainty_coefficient, 3),
                    Cell::number(record_of.mean_posterior_coefficient, 3),
                ]);
                let caution = Caution::of(
                    record_of.trials,
                    record_of.bins,
                    Some(record_of.mean_uncertainty_coefficient),
                    record_of.mean_uncertainty_coefficient_corrected,
                );
                cautions.extend(caution.map(|caution| (caution, dataset, system)));
                notes.extend(record_of.notes.iter().map(|note| (dataset, note)));
            }
            other => row.push(no_answer(&mut table, other)),
        }
        table.row(row);
    }
    table.caption(
        "mean U, H(L|R) = means over all distances of the uncertainty coefficient, and of what is left of the location's\n  \
         entropy (nats); corrected = U corrected for chance, low, high = its 95 % interval",
    );
    table.caption(format!(
        "m to {reached} = metres until U first reaches it, for good m = from which it stays there (–: never); end U = U after\n  \
         {} m; posterior U = mean U of what the system holds probable (–: it has no posterior)",
        section.config.trial_m
    ));
    notes_by_dataset(record, notes)
        .into_iter()
        .chain(cautions_by_dataset(record, &cautions))
        .for_each(|line| table.caption(line));
    table
}

fn answers(record: &ComparisonRecord) -> Table {
    let mut table = Table::new([
        "dataset",
        "system",
        "responses",
        "silent %",
        "outside %",
        "candidates %",
        "places",
        "bytes each",
    ]);
    for (dataset, system, outcome) in record.standard.iter().flat_map(by_dataset) {
        let mut row = who(record, dataset, system);
        match outcome {
            Outcome::Done(cell) => row.extend([
                Cell::Count(cell.record.responses as u64),
                Cell::Number(100.0 * cell.record.unanswered, 1),
                Cell::Number(100.0 * cell.record.outside, 1),
                Cell::number(cell.record.candidates.map(|share| 100.0 * share), 1),
                Cell::Count(cell.places as u64),
                Cell::Count(cell.bytes_per_place as u64),
            ]),
            other => row.push(no_answer(&mut table, other)),
        }
        table.row(row);
    }
    table.caption(
        "silent, outside = share of the answers that are none, or a place off the route; candidates = share of its places that a\n  \
         snapshot passes for on average, by d < T of Duckett & Nehmzow 1998 (–: it does not sift them); places = places or\n  \
         patterns kept; bytes each = what is kept of one, pose included (0: none are kept)",
    );
    table
}

fn curves(record: &ComparisonRecord) -> Table {
    let mut table = Table::new([
        "dataset",
        "system",
        "distance_m",
        "entropy_of_location_given_response",
        "uncertainty_coefficient",
        "uncertainty_coefficient_corrected",
    ]);
    for (dataset, system, outcome) in record.standard.iter().flat_map(by_dataset) {
        for at in outcome
            .done()
            .iter()
            .flat_map(|cell| &cell.record.by_distance)
        {
            let mut row = who(record, dataset, system);
            row.extend([
                Cell::Number(at.distance_m, 2),
                Cell::Number(at.entropy_of_location_given_response, 4),
                Cell::number(at.uncertainty_coefficient, 4),
                Cell::number(at.uncertainty_coefficient_corrected, 4),
            ]);
            table.row(row);
        }
    }
    table
}

/// U against distance for each dataset, as Fig. 6 of Duckett & Nehmzow (1998).
pub(super) fn pictures(record: &ComparisonRecord) -> Result<Vec<Picture>> {
    let Some(section) = &record.standard else {
        return Ok(Vec::new());
    };
    let files = record.file_names();
    let mut pictures = Vec::new();
    for (number, dataset) in record.datasets.iter().enumerate() {
        let rows = section.systems.iter().zip(&section.cells);
        let curves = rows.filter_map(|(&system, row)| {
            let cell = row[number].done()?;
            let rows = &cell.record.by_distance;
            let value = |at: Option<f64>| at.unwrap_or(f64::NAN);
            Some(Curve {
                name: record.systems[system].name.clone(),
                x: rows.iter().map(|at| at.distance_m).collect(),
                y: rows
                    .iter()
                    .map(|at| value(at.uncertainty_coefficient))
                    .collect(),
                band: None,
            })
        });
        let panel = Panel {
            y_label: "U(L|R)".into(),
            curves: curves.collect(),
            y_range: Some((0.0, 1.0)),
        };
        let title = format!("What answers tell about the place: {}", dataset.name);
        let svg = framed_plot(&title, "distance travelled (m)", &panel)?;
        pictures.push((format!("standard-{}", files[number]), svg));
    }
    Ok(pictures)
}
