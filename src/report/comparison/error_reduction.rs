//! What one snapshot takes away of the error, against how uncertain the robot was before.

use super::{Picture, Reader, Sheet, by_dataset, no_answer, who};
use crate::{
    error::Result,
    experiment::compare::{ComparisonRecord, Outcome},
    report::{Cell, Curve, Panel, Table, category_plot},
};

fn priors(record: &ComparisonRecord) -> Vec<String> {
    let section = record.error_reduction.iter();
    let priors = section.flat_map(|section| &section.config.priors);
    priors.map(|prior| prior.to_string()).collect()
}

/// One row a dataset and system, one column a prior.
pub(super) fn sheet(record: &ComparisonRecord) -> Option<Sheet> {
    let section = record.error_reduction.as_ref()?;
    let priors = priors(record);
    let headers = ["dataset".to_string(), "system".into()].into_iter();
    let mut table = Table::new(headers.chain(priors.iter().map(|prior| format!("{prior} %"))));
    for (dataset, system, outcome) in by_dataset(section) {
        let mut row = who(record, dataset, system);
        match outcome {
            Outcome::Done(curve) => row.extend(priors.iter().map(|prior| {
                let mut points = curve.points.iter();
                let point = points.find(|point| point.prior.to_string() == *prior);
                Cell::number(point.map(|point| 100.0 * point.score.error_reduction), 1)
            })),
            other => row.push(no_answer(&mut table, other)),
        }
        table.row(row);
    }
    table.caption(
        "share of the prior error that one snapshot takes away, on unseen snapshots at mapped places; 2m = the robot knows\n  \
         its place to ±2 m (and its heading to ±0.5 rad), global = it knows nothing; –: no snapshot has two candidates at\n  \
         different places",
    );
    Some(Sheet {
        name: "error-reduction".into(),
        title: "Error reduction against prior uncertainty".into(),
        table,
        reader: Reader::Everyone,
    })
}

/// Error reduction against prior uncertainty for each dataset, as Fig. 3 of Thrun (1998).
pub(super) fn pictures(record: &ComparisonRecord) -> Result<Vec<Picture>> {
    let Some(section) = &record.error_reduction else {
        return Ok(Vec::new());
    };
    let priors = priors(record);
    let files = record.file_names();
    let mut pictures = Vec::new();
    for (number, dataset) in record.datasets.iter().enumerate() {
        let rows = section.systems.iter().zip(&section.cells);
        let curves = rows.filter_map(|(&system, row)| {
            let points = &row[number].done()?.points;
            let at = |point: &String| priors.iter().position(|prior| prior == point);
            let x = points
                .iter()
                .filter_map(|point| at(&point.prior.to_string()));
            Some(Curve {
                name: record.systems[system].name.clone(),
                x: x.map(|x| x as f64).collect(),
                y: points
                    .iter()
                    .map(|point| 100.0 * point.score.error_reduction)
                    .collect(),
                band: None,
            })
        });
        let panel = Panel {
            y_label: "error reduction (%)".into(),
            curves: curves.collect(),
            y_range: None,
        };
        let title = format!(
            "What one snapshot takes away of the error: {}",
            dataset.name
        );
        let svg = category_plot(&title, "prior uncertainty", &priors, &panel)?;
        pictures.push((format!("error-reduction-{}", files[number]), svg));
    }
    Ok(pictures)
}
