//! How much of a row is chance, in a line below the table.

use crate::experiment::localisation::Record;

/// A line for everybody who was asked again.
pub(super) fn captions(record: &Record) -> Vec<String> {
    let told = record
        .results
        .iter()
        .filter_map(|result| Some((result, result.repeats.as_ref()?)));
    told.map(|(result, repeats)| {
        let mut line = format!("{}: with {} seeds", result.title, repeats.seeds);
        if let Some(found) = &repeats.converged_fraction {
            line += &format!(
                " {:.0} to {:.0} % found (s {:.1} %)",
                100.0 * found.least,
                100.0 * found.most,
                100.0 * found.sd
            );
        }
        if let Some(error) = &repeats.point_error_at_10m_m {
            line += &format!(
                ", {:.2} to {:.2} m after 10 m (s {:.2})",
                error.least, error.most, error.sd
            );
        }
        let same = match repeats.trials_that_differ_with_one_seed {
            0 => "one seed answers alike twice".to_string(),
            n => format!(
                "one seed answers otherwise in {n} of {} trials",
                record.trials
            ),
        };
        format!("{line};\n  {same}")
    })
    .collect()
}
