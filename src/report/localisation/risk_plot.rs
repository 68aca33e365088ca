//! Does a belief know when it is wrong? The picture.

use crate::{
    error::Result,
    experiment::localisation::{MethodResult, Record},
    report::{Curve, line_plot},
};

/// Mean point error at the trials' end against the share of trials rejected, those of least confidence first.
///
/// # Errors
/// None with a record that was made by an experiment.
pub fn risk_coverage_plot(title: &str, record: &Record) -> Result<String> {
    // Of who says nothing of how sure it is, a curve without points: a system has one colour in all pictures.
    let curve = |result: &MethodResult| {
        let rows = &result.risk_coverage;
        Curve {
            name: result.title.clone(),
            x: rows.iter().map(|row| 100.0 * row.rejected).collect(),
            y: rows.iter().map(|row| row.point_error_m).collect(),
            band: None,
        }
    };
    let curves: Vec<Curve> = record.results.iter().map(curve).collect();
    line_plot(
        title,
        "trials rejected for lack of confidence (%)",
        "mean point error at the end (m)",
        &curves,
    )
}
