//! How many robots are found by which distance: the picture.

use crate::{
    error::Result,
    experiment::localisation::{MethodResult, Record},
    report::{Curve, Panel, framed_plot},
};

/// Share of the trials from a start anywhere that have converged, against the distance travelled, with 95 % bands.
///
/// # Errors
/// None with a record that was made by an experiment.
pub fn found_plot(title: &str, record: &Record) -> Result<String> {
    let curve = |result: &MethodResult| {
        let rows = &result.global.error_by_distance;
        let end = |end: usize| {
            let ends = rows
                .iter()
                .map(|row| row.found_ci95.map_or(f64::NAN, |ci| 100.0 * ci[end]));
            ends.collect::<Vec<f64>>()
        };
        Curve {
            name: result.title.clone(),
            x: rows.iter().map(|row| row.distance_m).collect(),
            y: rows.iter().map(|row| 100.0 * row.found).collect(),
            band: Some((end(0), end(1))),
        }
    };
    let panel = Panel {
        y_label: "robots found (%)".into(),
        curves: record.results.iter().map(curve).collect(),
        y_range: Some((0.0, 102.0)),
    };
    framed_plot(title, "distance travelled (m)", &panel)
}
