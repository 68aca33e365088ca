//! How far apart the snapshots of a set's runs stand.

use crate::{
    error::{Error, Result},
    world::{
        building::{MAX_SNAPSHOTS, Spacing},
        way::STEP_M,
    },
};

/// Metres between the snapshots of each run, and how many there are at most; of a file that has so many runs by itself.
pub(super) fn spacings(
    spacing: Spacing,
    runs_of_file: usize,
    lengths_m: &[f64],
) -> Result<Vec<(f64, usize)>> {
    let runs = lengths_m.len();
    let whole_m: f64 = lengths_m.iter().sum();
    match spacing {
        Spacing::Metres(metres) => {
            let expected = whole_m / metres + runs as f64;
            if expected > MAX_SNAPSHOTS as f64 {
                return Err(Error::usage(format!(
                    "simulation: {runs} runs with a snapshot every {metres} m make {expected:.0}; expected up to {MAX_SNAPSHOTS}"
                )));
            }
            Ok(vec![(metres, usize::MAX); runs])
        }
        Spacing::Exactly(count) => {
            // The file's number is for the file's runs.
            let count = (count as f64 * runs as f64 / runs_of_file as f64).round();
            // Each run gets its share by length: what the runs up to it get, less what those before it got.
            let mut reached_m = 0.0;
            let mut given = 0;
            let shares = lengths_m.iter().map(|length_m| {
                reached_m += length_m;
                let until = (count * reached_m / whole_m).round() as usize;
                let share = until - given;
                given = until;
                (length_m / share.max(1) as f64, share)
            });
            let shares: Vec<(f64, usize)> = shares.collect();
            if let Some(run) = shares.iter().position(|(_, share)| *share == 0) {
                return Err(Error::usage(format!(
                    "simulation: {count} snapshots are none for run {run} of the set, {:.2} m long; expected more of them",
                    lengths_m[run]
                )));
            }
            match shares.iter().find(|(spacing_m, _)| *spacing_m < STEP_M) {
                Some((spacing_m, _)) => Err(Error::usage(format!(
                    "simulation: {count} snapshots make one every {spacing_m:.6} m; expected {STEP_M} m or more between them"
                ))),
                None => Ok(shares),
            }
        }
        Spacing::AtPoses => Err(Error::usage(
            "[record]: snapshots at poses; expected them only where the robot follows poses",
        )),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_million_snapshots_are_made_and_a_hundred_million_refused() {
        let days_drive = vec![86.6; 1155];
        let made = spacings(Spacing::Metres(0.1), 12, &days_drive).unwrap();
        assert_eq!(made, vec![(0.1, usize::MAX); 1155]);
        let refused = spacings(Spacing::Metres(0.001), 12, &days_drive).unwrap_err();
        assert!(refused.is_usage());
        assert!(
            refused
                .to_string()
                .contains("make 100024155; expected up to 10000000"),
            "{refused}"
        );
    }
}
